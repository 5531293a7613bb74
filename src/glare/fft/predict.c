/* What a frame by fft will take: see engine.h. */
#include "glare/cost.h"
#include "glare/fft/state.h"

#include <math.h>

static bool has_plan(const struct gp_fft_state *s, int n, enum gp_fft_plan how)
{
    for (int i = 0; i < s->plans; i++) {
        if (s->plan[i].n == n && s->plan[i].how == how)
            return true;
    }
    return false;
}

/* What a run with this placing has to make before it can start. */
static double setup_ms(const struct gp_glare_job *job,
                       const struct gp_fft_state *s,
                       const struct gp_fft_placing *p, int core)
{
    const struct gp_glare_params *const params = job->params;
    const struct gp_kernel *const k = job->kernel;
    // a file that keeps measured plans is taken to have these
    const double plan = params->fft_plan == GP_FFT_PLAN_MEASURE &&
                                !params->wisdom
                            ? GP_COST_FFT_PLAN_MEASURE
                            : GP_COST_FFT_PLAN_ESTIMATE;
    const double rows = fmax(gp_rect_h(p->in), gp_rect_h(p->out));
    double ms = s->plans ? 0.0 : GP_COST_FFT_LIBRARY;
    if (!has_plan(s, p->nx, params->fft_plan))
        ms += plan;
    if (p->ny != p->nx && !has_plan(s, p->ny, params->fft_plan))
        ms += plan;
    if (!gp_fft_same_spectrum(s, k, p, core))
        ms += gp_cost_spectrum(k, p, params->fft_plan);
    if (!s->work.z[0])
        ms += GP_COST_FRESH_BYTE * 4.0 * p->nx * rows;
    return ms;
}

/* What goes direct. Finding the tails' norms takes as long as a small frame:
 * not before it is known that without a core it is too wrong. */
static void predict_split(const struct gp_glare_job *job,
                          const struct gp_fft_state *s,
                          const struct gp_fft_placing *p,
                          struct gp_fft_split *split)
{
    const struct gp_kernel *const k = job->kernel;
    const double points = (double) p->nx * p->ny;
    const double ms = gp_fft_predict_ms(job->src, p);
    const double gain = (double) job->params->gain;
    const bool known = gp_fft_is_known(s->norms_kernel, k);
    double tail[GP_FFT_CORES] = {
        fmax(k->norm2[0], fmax(k->norm2[1], k->norm2[2])),
    };
    if (known)
        memcpy(tail, s->tail, sizeof tail);
    gp_fft_split_choose(job->src, k, tail, points, ms, gain, split);
    if (known || (split->core < 0 && split->hot_count == 0))
        return;
    gp_fft_tail_norms(k, tail);
    gp_fft_split_choose(job->src, k, tail, points, ms, gain, split);
}

static struct gp_prediction once(double ms)
{
    return (struct gp_prediction) {.ms = ms, .later_ms = ms};
}

struct gp_prediction gp_fft_predict(const struct gp_glare_job *job,
                                    const void *state)
{
    static const struct gp_fft_state empty;
    const struct gp_fft_state *const s = state ? state : &empty;
    const struct gp_kernel *const k = job->kernel;
    struct gp_fft_placing p = gp_fft_place(job->src, k);
    struct gp_fft_split split;
    if (!p.nx)
        return once(GP_COST_FFT_RUN);
    const double passes = gp_cost_passes(job->src, &p, job->params->fft_plan);
    if (job->enough > 0.0 && passes > job->enough)
        return (struct gp_prediction) {
            .ms = GP_COST_FFT_RUN + passes,
            .later_ms = GP_COST_FFT_RUN + passes, .more = true,
        };
    predict_split(job, s, &p, &split);
    struct gp_prediction ms = once(GP_COST_FFT_RUN + split.ms);
    if (!gp_fft_is_known(s->norms_kernel, k))
        ms.ms += GP_COST_FFT_NORMS * 3.0 * k->w * k->h;
    if (split.hot_count == job->src->n)
        return ms;
    // without the hot ones the rest may stand elsewhere: where it stood before
    if (split.hot_count && gp_fft_is_known(s->kernel, k) &&
        s->core == split.core)
        p = s->placing;
    const double again = gp_cost_passes(job->src, &p, job->params->fft_plan);
    ms.later_ms += again;
    ms.ms += again + setup_ms(job, s, &p, split.core);
    return ms;
}
