/* The kernel's spectrum, which a sequence keeps. */
#ifndef GP_GLARE_FFT_SPECTRUM_H
#define GP_GLARE_FFT_SPECTRUM_H

#include "core/status.h"
#include "glare/fft/pass.h"
#include "glare/fft/place.h"
#include "glare/kernel.h"

/* Transforms the kernel, its samples within `core` pixels of the centre in x
 * and y left out (-1: none), to one channel (a grey kernel) or three of p->ny
 * rows, scaled so that the passes need no more factors. fft has the plans of
 * p->nx and p->ny and one channel. Written only on GP_OK; free with
 * gp_fft_matrix_free(). Errors: GP_ERR_BUG out of memory; GP_ERR_IO no FFTW. */
GP_MUST_CHECK gp_status gp_fft_spectrum(const struct gp_fft_job *fft,
                                        const struct gp_kernel *k,
                                        const struct gp_fft_placing *p,
                                        int core, struct gp_fft_matrix *out);

/* A matrix of one plane, as the plane of channel c; borrowed. */
struct gp_fft_matrix gp_fft_channel(const struct gp_fft_matrix *m, int c);

#endif
