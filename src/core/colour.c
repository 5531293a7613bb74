// SPDX-License-Identifier: Apache-2.0
#include "core/colour.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

const float gp_rec709_chromaticities[8] = {
    0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f,
};
const float gp_rec709_luminance[3] = {0.2126f, 0.7152f, 0.0722f};

int gp_rgb_to_xyz(const float ch[8], double m[9])
{
    // columns are the primaries' xyz; their scale S makes white's Y = 1
    double p[9], back[9], b[3];
    for (int i = 0; i < 8; i++) {
        if (!isfinite(ch[i]))
            return 0;
    }
    for (int i = 0; i < 3; i++) {
        p[i] = ch[2 * i];
        p[3 + i] = ch[2 * i + 1];
        p[6 + i] = 1.0 - (double) ch[2 * i] - (double) ch[2 * i + 1];
    }
    if (!(fabs((double) ch[7]) > 1e-6))
        return 0;
    b[0] = (double) ch[6] / (double) ch[7];
    b[1] = 1.0;
    b[2] = (1.0 - (double) ch[6] - (double) ch[7]) / (double) ch[7];
    if (!(fabs(gp_invert3(p, back)) > 1e-12))
        return 0;
    for (int i = 0; i < 9; i++) { // p * s = b
        const double *const row = back + i % 3 * 3;
        m[i] = p[i] * (row[0] * b[0] + row[1] * b[1] + row[2] * b[2]);
    }
    return 1;
}

double gp_invert3(const double m[9], double out[9])
{
    double cofactor[9];
    for (int i = 0; i < 9; i++) {
        const int r1 = (i / 3 + 1) % 3 * 3, r2 = (i / 3 + 2) % 3 * 3;
        const int c1 = (i + 1) % 3, c2 = (i + 2) % 3;
        cofactor[i] = m[r1 + c1] * m[r2 + c2] - m[r1 + c2] * m[r2 + c1];
    }
    const double det =
        m[0] * cofactor[0] + m[1] * cofactor[1] + m[2] * cofactor[2];
    for (int i = 0; i < 9; i++)
        out[i] = cofactor[i % 3 * 3 + i / 3] / det;
    return det;
}

void gp_multiply3(const double a[9], const double b[9], double out[9])
{
    for (int i = 0; i < 9; i++) {
        const double *row = a + i / 3 * 3;
        out[i] = row[0] * b[i % 3] + row[1] * b[3 + i % 3] +
                 row[2] * b[6 + i % 3];
    }
}

/* From one RGB to another, both by their matrices to a space; false: too odd. */
static int between(const double from[9], const double to[9], double m[9])
{
    double back[9];
    int usable = 1;
    gp_invert3(to, back); // of a singular matrix it is not finite
    gp_multiply3(back, from, m);
    for (int i = 0; i < 9; i++)
        usable = usable && fabs(m[i]) < 1e3;
    return usable;
}

/* The white of RGB of these primaries, in that RGB. */
static void white_of(const float ch[8], double white[3])
{
    static const double d65[3] = {
        0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290};
    static const float xyz[8] = {1, 0, 0, 1, 0, 0, 1.0f / 3, 1.0f / 3};
    bool same = true;
    for (int i = 0; i < 8; i++)
        same = same && fabsf(ch[i] - xyz[i]) < 1e-3f;
    for (int i = 0; i < 3; i++)
        white[i] = same ? d65[i] : 1.0;
}

int gp_rgb_to_rgb(const float from[8], const float to[8], double m[9])
{
    static const double bradford[9] = {
        0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685,
        1.0296,
    };
    double xyz[9], target[9], cone_from[9], cone_to[9], wf[3], wt[3];
    if (!gp_rgb_to_xyz(from, xyz) || !gp_rgb_to_xyz(to, target))
        return 0;
    white_of(from, wf);
    white_of(to, wt);
    // rows of the RGB to cone matrices, times white: its responses
    gp_multiply3(bradford, xyz, cone_from);
    gp_multiply3(bradford, target, cone_to);
    for (int i = 0; i < 3; i++) {
        double *f = cone_from + 3 * i;
        const double *t = cone_to + 3 * i;
        double adapt = (t[0] * wt[0] + t[1] * wt[1] + t[2] * wt[2]) /
                       (f[0] * wf[0] + f[1] * wf[1] + f[2] * wf[2]);
        if (!(adapt > 1e-3 && adapt < 1e3)) // a white that no eye adapts to
            return 0;
        for (int c = 0; c < 3; c++)
            f[c] *= adapt;
    }
    return between(cone_from, cone_to, m);
}

void gp_luminance_weights(const float ch[8], float weight[3])
{
    double m[9];
    memcpy(weight, gp_rec709_luminance, sizeof gp_rec709_luminance);
    if (memcmp(ch, gp_rec709_chromaticities, sizeof gp_rec709_chromaticities) ==
            0 || !gp_rgb_to_xyz(ch, m))
        return;
    for (int c = 0; c < 3; c++)
        weight[c] = (float) m[3 + c];
}

// -- colours of wavelengths ---------------------------------------------------

/* A curve with one slope before its peak and one after it. */
static double lobe(double nm, double height, double peak, double before,
                   double after)
{
    const double z = (nm - peak) / (nm < peak ? before : after);
    return height * gp_exp(-0.5 * z * z);
}

/* CIE 1931 2 degree observer: the multi-lobe fit of Wyman, Sloan and Shirley,
 * Simple Analytic Approximations to the CIE XYZ Color Matching Functions, JCGT
 * 2 (2013), eq. 4; within 1 % of the table's peaks. */
static void spectrum_xyz(double nm, double xyz[3])
{
    xyz[0] = lobe(nm, 1.056, 599.8, 37.9, 31.0) +
             lobe(nm, 0.362, 442.0, 16.0, 26.7) +
             lobe(nm, -0.065, 501.1, 20.4, 26.2);
    xyz[1] = lobe(nm, 0.821, 568.8, 46.9, 40.5) +
             lobe(nm, 0.286, 530.9, 16.3, 31.1);
    xyz[2] = lobe(nm, 1.217, 437.0, 11.8, 36.0) +
             lobe(nm, 0.681, 459.0, 26.0, 13.8);
}

/* Moves a colour of luminance y towards grey until no channel is negative. */
static void fold(double y, double rgb[3])
{
    const double least = fmin(fmin(rgb[0], rgb[1]), rgb[2]);
    for (int c = 0; c < 3 && least < 0.0; c++)
        rgb[c] = fmax(y + y / (y - least) * (rgb[c] - y), 0.0);
}

void gp_gamut_fold(const float luminance[3], double rgb[3])
{
    fold(fmax(gp_luminance_of(luminance, rgb), 0.0), rgb);
}

void gp_spectrum_colours(const float chromaticities[8], int n, double *nm,
                         double (*rgb)[3])
{
    double to_xyz[9], from_xyz[9], white[3] = {0};
    if (!gp_rgb_to_xyz(chromaticities, to_xyz))
        gp_rgb_to_xyz(gp_rec709_chromaticities, to_xyz);
    gp_invert3(to_xyz, from_xyz);
    for (int i = 0; i < n; i++) {
        nm[i] = GP_NM_FROM + (GP_NM_TO - GP_NM_FROM) * (i + 0.5) / n;
        spectrum_xyz(nm[i], rgb[i]);
        for (int c = 0; c < 3; c++)
            white[c] += rgb[i][c];
    }
    for (int i = 0; i < n; i++) {
        // equal energy light becomes the primaries' white, channel by channel
        // of XYZ as von Kries did it
        double v[3];
        for (int c = 0; c < 3; c++)
            v[c] = rgb[i][c] / white[c] *
                   (to_xyz[3 * c] + to_xyz[3 * c + 1] + to_xyz[3 * c + 2]);
        for (int c = 0; c < 3; c++)
            rgb[i][c] = from_xyz[3 * c] * v[0] + from_xyz[3 * c + 1] * v[1] +
                        from_xyz[3 * c + 2] * v[2];
    }
}

int gp_spectrum_to_spectrum(const float from[8], const float to[8],
                            double m[9])
{
    double xyz[9], target[9];
    if (!gp_rgb_to_xyz(from, xyz) || !gp_rgb_to_xyz(to, target))
        return 0;
    for (int i = 0; i < 9; i += 3) {
        const double white = target[i] + target[i + 1] + target[i + 2];
        const double scale = white / (xyz[i] + xyz[i + 1] + xyz[i + 2]);
        for (int c = 0; c < 3; c++)
            xyz[i + c] *= scale;
    }
    return between(xyz, target, m);
}

void gp_spectrum_weights(const float chromaticities[8], int n, double *nm,
                         double (*rgb)[3])
{
    enum { STEPS = 100 }; // luminances to 1e-3
    double to_xyz[9] = {0}, y[GP_BANDS], sum[3];
    if (!gp_rgb_to_xyz(chromaticities, to_xyz))
        gp_rgb_to_xyz(gp_rec709_chromaticities, to_xyz);
    gp_spectrum_colours(chromaticities, n, nm, rgb);
    for (int i = 0; i < n; i++)
        y[i] = to_xyz[3] * rgb[i][0] + to_xyz[4] * rgb[i][1] +
               to_xyz[5] * rgb[i][2];
    // light that folding takes from a channel and gives to others has no
    // luminance: it is spread over all bands, which are folded again
    for (int step = 0; step <= STEPS; step++) {
        sum[0] = sum[1] = sum[2] = 0.0;
        for (int i = 0; i < n; i++) {
            fold(y[i], rgb[i]);
            for (int c = 0; c < 3; c++)
                sum[c] += rgb[i][c];
        }
        for (int i = 0; i < 3 * n; i++) {
            double *const v = &rgb[i / 3][i % 3];
            *v = step < STEPS ? *v + (1.0 - sum[i % 3]) * y[i / 3]
                              : *v / sum[i % 3];
        }
    }
}
