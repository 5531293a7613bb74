/* The sRGB transfer curve, IEC 61966-2-1:1999. */
#ifndef GP_CORE_SRGB_H
#define GP_CORE_SRGB_H

/* Linear to encoded and back, both in [0,1]; values outside are clamped, NaN
 * becomes 0. The plain forms that faster ones are tested against. */
float gp_srgb_encode(float linear);
float gp_srgb_decode(float encoded);

#endif
