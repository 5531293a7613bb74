/* What the fft engine keeps; only fft.c and fft_predict.c include this. */
#ifndef GP_GLARE_FFT_STATE_H
#define GP_GLARE_FFT_STATE_H

#include "glare/bound/bound.h"
#include "glare/direct/direct.h"
#include "glare/engine.h"
#include "glare/fft/lib.h"
#include "glare/fft/pass.h"
#include "glare/fft/place.h"
#include "glare/fft/split.h"

#include <stdbool.h>
#include <string.h>

/* Kept from frame to frame; each part is made anew when its key differs. */
struct gp_fft_state {
    struct gp_fft_plan_pair plan[8]; // of the lengths used last, latest last
    int plans;
    unsigned long kernel; // serial of the spectrum's
    struct gp_fft_placing placing;
    int core;
    struct gp_fft_matrix spectrum; // the kernel's, transposed, scaled
    struct gp_fft_matrix work;     // of one channel: three leave the cache
    size_t work_rows;
    unsigned long taps_kernel; // serial of the taps'
    struct gp_taps core_taps, all_taps;
    int core_taps_radius;
    unsigned long norms_kernel; // serial and frame of what follows
    int norms_w, norms_h;
    double tail[GP_FFT_CORES];
    struct gp_fft_quarters quarters;
    struct gp_bound_cache least;
};

static inline bool gp_fft_is_known(unsigned long serial,
                                   const struct gp_kernel *k)
{
    return serial && serial == k->serial;
}

static inline bool gp_fft_same_spectrum(const struct gp_fft_state *s,
                                        const struct gp_kernel *k,
                                        const struct gp_fft_placing *p,
                                        int core)
{
    return s->spectrum.z[0] && gp_fft_is_known(s->kernel, k) &&
           s->core == core && s->placing.nx == p->nx &&
           s->placing.ny == p->ny &&
           memcmp(&s->placing.taps, &p->taps, sizeof p->taps) == 0;
}

/* gp_engine.predict of fft. */
struct gp_prediction gp_fft_predict(const struct gp_glare_job *job,
                                    const void *state);

#endif
