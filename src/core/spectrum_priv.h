/* For tests of colours of wavelengths. */
#ifndef GP_CORE_SPECTRUM_PRIV_H
#define GP_CORE_SPECTRUM_PRIV_H

/* XYZ of light of one wavelength, nm. */
void gp_spectrum_xyz(double nm, double xyz[3]);

#endif
