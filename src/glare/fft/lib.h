/* FFTW by dlopen: a run without a Fourier transform never loads it. */
#ifndef GP_GLARE_FFT_LIB_H
#define GP_GLARE_FFT_LIB_H

#include "core/status.h"
#include "glare/engine.h"

#include <fftw3.h>

/* The functions of one precision; P is its prefix, real its scalar type. */
#define GP_FFTW_TABLE(name, P)                                                \
    struct name {                                                             \
        P##plan (*plan_dft_1d)(int, P##complex *, P##complex *, int,          \
                               unsigned);                                     \
        void (*execute_dft)(const P##plan, P##complex *, P##complex *);       \
        void (*destroy_plan)(P##plan);                                        \
        int (*import_wisdom_from_filename)(const char *);                     \
        int (*export_wisdom_to_filename)(const char *);                       \
    }
GP_FFTW_TABLE(gp_fftwf, fftwf_);  // float
GP_FFTW_TABLE(gp_fftwd, fftw_);   // double

/* The library's functions, loaded at first call. Errors: GP_ERR_IO, with the
 * Debian package that is missing (libfftw3-single3, libfftw3-double3). */
GP_MUST_CHECK gp_status gp_fftwf_open(const struct gp_log *log,
                                      const struct gp_fftwf **out);
GP_MUST_CHECK gp_status gp_fftwd_open(const struct gp_log *log,
                                      const struct gp_fftwd **out);

/* The fastest transform length >= n, n >= 1: a multiple of 8 whose other
 * factors are 3, 5 and 7, by the costs in fft_lib.c. */
int gp_fft_length(int n);

/* Nanoseconds, about, of one complex transform of that length. */
double gp_fft_cost(int n);

/* The plans of one length: out of place, GP_ALIGN-aligned arrays. */
struct gp_fft_plan_pair {
    int n;
    enum gp_fft_plan how;
    fftwf_plan forward, backward;
};

/* Plans for that length. Estimated plans depend on nothing but the length and
 * the CPU; measured ones are faster, may differ in the last bits from run to
 * run, and are read from and added to the wisdom file (NULL: kept nowhere).
 * Call on one thread. Errors: GP_ERR_BUG. Free with gp_fft_plan_free(). */
GP_MUST_CHECK gp_status gp_fft_plan_make(const struct gp_log *log, int n,
                                         enum gp_fft_plan how,
                                         const char *wisdom,
                                         struct gp_fft_plan_pair *out);
void gp_fft_plan_free(struct gp_fft_plan_pair *p);

#endif
