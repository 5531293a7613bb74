#include "core/spectrum.h"

#include "core/colour.h"
#include "core/spectrum_priv.h"

#include <math.h>

/* A curve with one slope before its peak and one after it. */
static double lobe(double nm, double height, double peak, double before,
                   double after)
{
    const double z = (nm - peak) / (nm < peak ? before : after);
    return height * exp(-0.5 * z * z);
}

/* CIE 1931 2 degree observer: the multi-lobe fit of Wyman, Sloan and Shirley,
 * Simple Analytic Approximations to the CIE XYZ Color Matching Functions, JCGT
 * 2 (2013), eq. 4; within 1 % of the table's peaks. */
void gp_spectrum_xyz(double nm, double xyz[3])
{
    xyz[0] = lobe(nm, 1.056, 599.8, 37.9, 31.0) +
             lobe(nm, 0.362, 442.0, 16.0, 26.7) +
             lobe(nm, -0.065, 501.1, 20.4, 26.2);
    xyz[1] = lobe(nm, 0.821, 568.8, 46.9, 40.5) +
             lobe(nm, 0.286, 530.9, 16.3, 31.1);
    xyz[2] = lobe(nm, 1.217, 437.0, 11.8, 36.0) +
             lobe(nm, 0.681, 459.0, 26.0, 13.8);
}

/* Folds bands in towards grey of their own luminance until none is negative,
 * and adds them up. */
static void fold(int n, const double *y, double (*rgb)[3], double sum[3])
{
    sum[0] = sum[1] = sum[2] = 0.0;
    for (int i = 0; i < n; i++) {
        const double least = fmin(fmin(rgb[i][0], rgb[i][1]), rgb[i][2]);
        const double keep = least < 0.0 ? y[i] / (y[i] - least) : 1.0;
        for (int c = 0; c < 3; c++) {
            rgb[i][c] = fmax(y[i] + keep * (rgb[i][c] - y[i]), 0.0);
            sum[c] += rgb[i][c];
        }
    }
}

void gp_spectrum_weights(const float chromaticities[8], int n, double *nm,
                         double (*rgb)[3])
{
    enum { STEPS = 100 }; // luminances to 1e-3
    double to_xyz[9], from_xyz[9], y[GP_BANDS], sum[3], white[3] = {0};
    if (!gp_rgb_to_xyz(chromaticities, to_xyz))
        gp_rgb_to_xyz(gp_rec709_chromaticities, to_xyz);
    gp_invert3(to_xyz, from_xyz);
    for (int i = 0; i < n; i++) {
        nm[i] = GP_NM_FROM + (GP_NM_TO - GP_NM_FROM) * (i + 0.5) / n;
        gp_spectrum_xyz(nm[i], rgb[i]);
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
        y[i] = v[1];
        for (int c = 0; c < 3; c++)
            rgb[i][c] = from_xyz[3 * c] * v[0] + from_xyz[3 * c + 1] * v[1] +
                        from_xyz[3 * c + 2] * v[2];
    }
    // light that folding takes from a channel and gives to others has no
    // luminance: it is spread over all bands, which are folded again
    for (int step = 0; step < STEPS; step++) {
        fold(n, y, rgb, sum);
        for (int i = 0; i < n; i++) {
            for (int c = 0; c < 3; c++)
                rgb[i][c] += (1.0 - sum[c]) * y[i];
        }
    }
    fold(n, y, rgb, sum);
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++)
            rgb[i][c] /= sum[c];
    }
}
