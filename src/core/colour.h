// SPDX-License-Identifier: Apache-2.0
/* Luminance from a frame's own primaries, the sRGB transfer curve, and colours
 * of wavelengths. */
#ifndef GP_CORE_COLOUR_H
#define GP_CORE_COLOUR_H

#include "core/maths.h"

/* ITU-R BT.709 primaries and D65 white: rx ry gx gy bx by wx wy. A file
 * without a chromaticities attribute has these (ImfStandardAttributes.h). */
extern const float gp_rec709_chromaticities[8];

/* Luminance weights of BT.709, rounded to four digits as its item 3.2 does. */
extern const float gp_rec709_luminance[3];

/* The Y row of the RGB to CIE XYZ matrix of these primaries, scaled so that
 * white has Y = 1 (SMPTE RP 177-1993). Exactly gp_rec709_luminance for BT.709.
 * Degenerate or non-finite primaries give gp_rec709_luminance.
 *   chromaticities  rx ry gx gy bx by wx wy
 *   weight          written; may be negative for unreal primaries such as XYZ
 */
void gp_luminance_weights(const float chromaticities[8], float weight[3]);

/* RGB to CIE XYZ of these primaries, row-major, white has Y = 1; false (and
 * nothing written) when they are degenerate. */
int gp_rgb_to_xyz(const float chromaticities[8], double m[9]);

/* Linear RGB of primaries `from` to that of `to`, row-major, white to white:
 * Bradford (Lam 1985; the matrix as in Lindbloom, Chromatic Adaptation). The
 * primaries of CIE XYZ itself, (1,0) (0,1) (0,0), with white (1/3,1/3), say that
 * values are XYZ, not that (1,1,1) is white: their white is D65, so that XYZ and
 * BT.709 are one matrix apart, as RGBtoXYZ() of OpenEXR's ImfChromaticities.h
 * has it. False when either are degenerate, or so odd that an element is 1e3 or
 * more. */
int gp_rgb_to_rgb(const float from[8], const float to[8], double m[9]);

/* Luminance of a colour by such weights. */
static inline double gp_luminance_of(const float weight[3], const double rgb[3])
{
    return rgb[0] * (double) weight[0] + rgb[1] * (double) weight[1] +
           rgb[2] * (double) weight[2];
}

/* out = a * b of 3x3 matrices; out is neither. */
void gp_multiply3(const double a[9], const double b[9], double out[9]);

/* The inverse of a 3x3 matrix by cofactors; not finite when it is singular. Returns its
 * determinant. */
double gp_invert3(const double m[9], double out[9]);

/* The sRGB transfer curve, IEC 61966-2-1:1999: linear to encoded and back,
 * both in [0,1]; values outside are clamped, NaN becomes 0. The references of
 * faster forms. */
static inline float gp_srgb_encode(float linear)
{
    const float v =
        linear <= 0.0031308f
            ? 12.92f * linear
            : (float) (1.055 * gp_pow((double) linear, 1.0 / 2.4) - 0.055);
    return linear > 0.0f ? (linear < 1.0f ? v : 1.0f) : 0.0f;
}

static inline float gp_srgb_decode(float encoded)
{
    const float v =
        encoded <= 0.04045f
            ? encoded / 12.92f
            : (float) gp_pow(((double) encoded + 0.055) / 1.055, 2.4);
    return encoded > 0.0f ? (encoded < 1.0f ? v : 1.0f) : 0.0f;
}

enum { GP_NM_FROM = 380, GP_NM_TO = 780, GP_BANDS = 256 };

/* Linear RGB in these primaries (those of BT.709 where they are degenerate) of
 * n equal bands of [380, 780] nm, n up to GP_BANDS: nm[i] is the middle of band
 * i. Equal energy light is the primaries' white: each channel's weights sum to
 * 1. Out of gamut is folded in towards grey at constant luminance, so that none
 * is negative. */
void gp_spectrum_weights(const float chromaticities[8], int n, double *nm,
                         double (*rgb)[3]);

/* The same, not folded in: a channel of a band may be negative. A sum of bands
 * has one colour in all primaries, and gp_gamut_fold() then folds it in. */
void gp_spectrum_colours(const float chromaticities[8], int n, double *nm,
                         double (*rgb)[3]);

/* Colours of gp_spectrum_colours() in primaries `from` to those in `to`,
 * row-major: what a kernel makes of white light. XYZ is scaled from white to
 * white as it does, so that grey stays grey, whatever the whites. False when
 * either are degenerate, or so odd that an element is 1e3 or more. */
int gp_spectrum_to_spectrum(const float from[8], const float to[8],
                            double m[9]);

/* Moves a colour with a negative channel towards grey of its own luminance until
 * that channel is 0; one without luminance becomes 0.
 *   luminance  weights of the primaries */
void gp_gamut_fold(const float luminance[3], double rgb[3]);

#endif
