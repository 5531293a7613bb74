/* Colours of wavelengths. */
#ifndef GP_CORE_SPECTRUM_H
#define GP_CORE_SPECTRUM_H

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

/* Moves a colour with a negative channel towards grey of its own luminance until
 * that channel is 0; one without luminance becomes 0.
 *   luminance  weights of the primaries */
void gp_gamut_fold(const float luminance[3], double rgb[3]);

#endif
