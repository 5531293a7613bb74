/* Shared by the files of diffraction: transforms and a pupil's lags. */
#ifndef GP_GLARE_MODEL_DIFFRACT_PRIV_H
#define GP_GLARE_MODEL_DIFFRACT_PRIV_H

#include "glare/fft/fft.h"
#include "glare/model/model_priv.h"

#include <complex.h>
#include <math.h>

#ifndef CMPLX // glibc defines these only for gcc; clang has the built-in
#define CMPLX(re, im) __builtin_complex((double) (re), (double) (im))
#define CMPLXF(re, im) __builtin_complex((float) (re), (float) (im))
#endif

#define GP_PI 3.14159265358979323846

/* sin(pi x) / (pi x) */
static inline double gp_sinc(double x)
{
    return fabs(x) > 1e-8 ? sin(GP_PI * x) / (GP_PI * x) : 1.0;
}

/* Fades samples out over the last quarter of the reach: no rim. */
static inline double gp_diffract_fade(double t, double reach)
{
    const double z = fmin(fmax(4.0 * (reach - t) / reach, 0.0), 1.0);
    return z * z * (3.0 - 2.0 * z);
}

/* Joins to a shape whose samples, of offsets up to rx and ry, fade out at `reach`
 * degrees, the spikes of d's blades up to d->reach, and the mean far out. Where
 * the samples hold all up to `reach` (`fits`), the light of the centre is changed
 * for all of it to be 1.
 *
 *   shape  owned by the caller; after an error as before */
GP_MUST_CHECK gp_status gp_diffract_join(const struct gp_log *log,
    const struct gp_diffraction *d, int rx, int ry, double reach,
    const struct gp_field *f, struct gp_shape *shape);

enum { GP_GROUP = 4 }; // rows that go through memory together: a cache line

/* Plans of a length, and GP_GROUP arrays in and as many out for each thread. */
struct gp_transform {
    const struct gp_fftwd *lib;
    int n;
    fftw_plan forward, backward;
    double complex *room;
};

/* Call on one thread. Free with gp_transform_free().
 * Errors: GP_ERR_IO no FFTW; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_transform_make(const struct gp_log *log, int n,
                                          struct gp_transform *out);
void gp_transform_free(struct gp_transform *t);

static inline double complex *gp_transform_in(const struct gp_transform *t,
                                              int thread, int i)
{
    return t->room + (size_t) (2 * GP_GROUP * thread + i) * (size_t) t->n;
}

static inline double complex *gp_transform_out(const struct gp_transform *t,
                                               int thread, int i)
{
    return gp_transform_in(t, thread, GP_GROUP + i);
}

/* Transforms the thread's first n arrays. */
void gp_transform_run(const struct gp_transform *t, fftw_plan plan, int n,
                      int thread);

/* A pupil's autocorrelation at lags (u, v), u in [0, n], v in [-n, n] cells,
 * times `sum`: re, im [u * pitch + n + v]; the rest is conjugate. */
struct gp_lags {
    int n;
    size_t pitch;
    float *re, *im; // im is NULL where it is 0: the pupil has no path
    double sum;     // 0: the pupil is dark
};

/* Plans and scratch for a pupil's autocorrelation in single precision: off by
 * at most 1e-6 of the light that passes (build/tests/glare model_aperture). */
struct gp_correlator {
    const struct gp_pupil *pupil;
    const struct gp_fftwf *lib;
    struct gp_fft_plan_pair plan; // of at least twice the pupil's cells, so
                                  // that no lag meets another
    size_t pitch;                 // complex numbers of an array of `room`
    float complex *room;
    int columns, across;          // of the spectrum; stored, a multiple of 8
    float complex *z;             // [8 rows, or lags v >= 0][column][row]
};

/* Borrows the pupil. Call on one thread. Free with gp_correlator_free().
 * Errors: GP_ERR_IO no FFTW; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_correlator_make(const struct gp_log *log,
    const struct gp_pupil *p, struct gp_correlator *out);
void gp_correlator_free(struct gp_correlator *t);

/* Fills a->re, a->im and a->sum at one wavelength. */
GP_MUST_CHECK gp_status gp_correlate(const struct gp_log *log,
    const struct gp_correlator *t, double nm, struct gp_lags *a);

#endif
