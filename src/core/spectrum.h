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

#endif
