#include "glare/engine.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "glare/fft/pass.h"
#include "glare/fft/place.h"
#include "glare/fft/spectrum.h"
#include "glare/fft/state.h"
#include "glare/fft/split.h"

#include <math.h>
#include <string.h>

static int max(int a, int b)
{
    return a > b ? a : b;
}

static int min(int a, int b)
{
    return a < b ? a : b;
}

/* v modulo n, in [0, n). */
static int wrap(int v, int n)
{
    return v % n < 0 ? v % n + n : v % n;
}

static void close_state(void **state)
{
    struct gp_fft_state *const s = *state;
    if (s) {
        for (int i = 0; i < s->plans; i++)
            gp_fft_plan_free(&s->plan[i]);
        gp_fft_matrix_free(&s->spectrum);
        gp_fft_matrix_free(&s->work);
        gp_taps_free(&s->core_taps);
        gp_taps_free(&s->all_taps);
        gp_bound_cache_free(&s->least);
    }
    GP_FREE(*state);
}

/* The plans of length n, from the state or made; they stay when one more
 * length is asked for, but may move. */
static gp_status find_plan(const struct gp_glare_job *job, struct gp_fft_state *s,
                           int n, const struct gp_fft_plan_pair **out)
{
    const int room = (int) (sizeof s->plan / sizeof *s->plan);
    for (int i = 0; i < s->plans; i++) {
        const struct gp_fft_plan_pair found = s->plan[i];
        if (found.n == n && found.how == job->params->fft_plan) {
            memmove(s->plan + i, s->plan + i + 1,
                    sizeof found * (size_t) (s->plans - 1 - i));
            s->plan[s->plans - 1] = found;
            *out = &s->plan[s->plans - 1];
            return GP_OK;
        }
    }
    if (s->plans == room) { // the one that was not used for longest
        gp_fft_plan_free(&s->plan[0]);
        memmove(s->plan, s->plan + 1, sizeof *s->plan * (size_t) (room - 1));
        s->plans--;
    }
    gp_status st = gp_fft_plan_make(job->log, n, job->params->fft_plan,
                                    job->params->wisdom, &s->plan[s->plans]);
    if (!st)
        *out = &s->plan[s->plans++];
    return st;
}

static gp_status make_spectrum(const struct gp_glare_job *job,
                               struct gp_fft_state *s, const struct gp_fft_job *fft,
                               const struct gp_fft_placing *p, int core)
{
    if (gp_fft_same_spectrum(s, job->kernel, p, core))
        return GP_OK;
    gp_fft_matrix_free(&s->spectrum);
    gp_status st = gp_fft_spectrum(fft, job->kernel, p, core, &s->spectrum);
    if (st)
        return st;
    s->kernel = job->kernel->serial;
    s->placing = *p;
    s->core = core;
    return GP_OK;
}

/* -- one frame ---------------------------------------------------------------*/

/* Rows of the frame that hold light, in order, and where they stand. */
struct light_rows {
    const struct gp_sources *src;
    const struct gp_fft_placing *p;
    struct gp_planes *layer;
    int n;
    int *y, *place;
};

static gp_status find_light(const struct gp_log *log,
                            const struct gp_sources *s,
                            const struct gp_fft_placing *p, struct light_rows *out)
{
    gp_status st;
    void *v;
    const size_t rows = (size_t) gp_rect_h(p->in);
    GP_TRY(gp_alloc(log, "transform", rows, sizeof(int), &v));
    out->y = v;
    GP_TRY(gp_alloc(log, "transform", rows, sizeof(int), &v));
    out->place = v;
    for (int y = p->in.y0; y < p->in.y1; y++) {
        if (s->row[y + 1] > s->row[y]) {
            out->y[out->n] = y;
            out->place[out->n++] = y - p->in.y0;
        }
    }
out:
    return st;
}

static void load_light(const void *ctx, int c, int j, float *z)
{
    const struct light_rows *const r = ctx;
    const struct gp_sources *const s = r->src;
    const int y = r->y[j];
    for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++)
        z[2 * (s->x[i] - r->p->in.x0)] = s->rgb[c][i];
}

/* Output row j back to the layer: places start at the box's corner, modulo
 * nx. */
static void store_layer(const void *ctx, int c, int j, const float *z)
{
    const struct light_rows *const r = ctx;
    const struct gp_fft_placing *const p = r->p;
    const int w = r->src->w;
    float *const row =
        r->layer->c[c] + (size_t) (p->out.y0 + j) * (size_t) w;
    memset(row, 0, (size_t) p->out.x0 * sizeof *row);
    const int first = wrap(p->out.x0 - p->in.x0, p->nx);
    const int seam = min(p->out.x0 + p->nx - first, p->out.x1);
    for (int x = p->out.x0; x < seam; x++)
        row[x] = z[2 * (x - p->out.x0 + first)];
    for (int x = seam; x < p->out.x1; x++)
        row[x] = z[2 * (x - seam)];
    memset(row + p->out.x1, 0, (size_t) (w - p->out.x1) * sizeof *row);
}

static void clear_rows(const struct gp_glare_job *job, int from, int to)
{
    const size_t w = (size_t) job->src->w;
    for (int c = 0; c < 3 && to > from; c++)
        memset(job->layer->c[c] + (size_t) from * w, 0,
               (size_t) (to - from) * w * sizeof(float));
}

/* Transforms `src` with the kernel less its core into the layer. */
static gp_status transform(const struct gp_glare_job *job, struct gp_fft_state *s,
                           const struct gp_sources *src,
                           const struct gp_fft_placing *p, int core)
{
    gp_status st;
    struct gp_fft_job fft = {.log = job->log, .channels = 1};
    struct light_rows light = {.src = src, .p = p, .layer = job->layer};
    const int count = gp_rect_h(p->out);
    const struct gp_fft_plan_pair *x, *y;
    GP_TRY(find_plan(job, s, p->ny, &y));
    const struct gp_fft_plan_pair kept = *y; // the list may move
    GP_TRY(find_plan(job, s, p->nx, &x));
    fft.x = x;
    fft.y = &kept;
    GP_TRY(make_spectrum(job, s, &fft, p, core));
    GP_TRY(find_light(job->log, src, p, &light));
    const int rows = max(light.n, count);
    if (s->work.columns != (p->nx / 2 + 4) / 4 * 4 ||
        s->work_rows != (size_t) rows) {
        gp_fft_matrix_free(&s->work);
        GP_TRY(gp_fft_matrix_make(job->log, 1, p->nx, rows, &s->work));
        s->work_rows = (size_t) rows;
    }
    clear_rows(job, 0, p->out.y0);
    clear_rows(job, p->out.y1, src->h);
    const int first = wrap(p->out.y0 - p->in.y0, p->ny);
    for (fft.channel = 0; fft.channel < 3; fft.channel++) {
        struct gp_fft_matrix m = gp_fft_channel(&s->work, fft.channel);
        GP_TRY(gp_fft_rows_in(&fft, light.n, load_light, &light, &m));
        GP_TRY(gp_fft_multiply(&fft, &m, light.n, light.place, &s->spectrum,
                               job->kernel->grey ? 1 : 3, first, count));
        GP_TRY(gp_fft_rows_out(&fft, &m, count, store_layer, &light));
    }
out:
    gp_free(light.y);
    gp_free(light.place);
    return st;
}

/* What goes direct: the core for all that was transformed, and hot sources
 * whole. */
static gp_status add_direct(const struct gp_glare_job *job, struct gp_fft_state *s,
                            const struct gp_fft_split *split,
                            const struct gp_sources *hot,
                            const struct gp_sources *rest)
{
    gp_status st = GP_OK;
    if (!gp_fft_is_known(s->taps_kernel, job->kernel)) {
        gp_taps_free(&s->core_taps);
        gp_taps_free(&s->all_taps);
        s->taps_kernel = job->kernel->serial;
    }
    if (split->core >= 0 && rest->n) {
        if (!s->core_taps.k[0] || s->core_taps_radius != split->core) {
            gp_taps_free(&s->core_taps);
            st = gp_taps_make(job->log, job->kernel, split->core,
                              &s->core_taps);
            s->core_taps_radius = split->core;
        }
        if (!st)
            st = gp_direct_sum(job->log, rest, &s->core_taps, true, job->layer);
    }
    if (!st && hot->n && !s->all_taps.k[0])
        st = gp_taps_make(job->log, job->kernel, -1, &s->all_taps);
    if (!st && hot->n)
        st = gp_direct_sum(job->log, hot, &s->all_taps, true, job->layer);
    return st;
}

static void find_norms(struct gp_fft_state *s, const struct gp_kernel *k,
                       const struct gp_sources *src)
{
    if (gp_fft_is_known(s->norms_kernel, k) && s->norms_w == src->w &&
        s->norms_h == src->h)
        return;
    gp_fft_tail_norms(k, s->tail);
    gp_fft_find_quarters(k, src->w, src->h, &s->quarters);
    s->norms_kernel = k->serial;
    s->norms_w = src->w;
    s->norms_h = src->h;
}

static gp_status open_state(const struct gp_glare_job *job, void **state)
{
    return *state ? GP_OK
                  : gp_alloc_zero(job->log, "fft", 1, sizeof(struct gp_fft_state),
                                  state);
}

/* Where all sources stand, and what of the sum goes direct; p->nx is 0 when no
 * light reaches the frame. */
static void place_and_split(const struct gp_glare_job *job, struct gp_fft_state *s,
                            struct gp_fft_placing *p,
                            struct gp_fft_split *split)
{
    *split = (struct gp_fft_split) {.core = -1, .hot = INFINITY};
    *p = gp_fft_place(job->src, job->kernel);
    if (!p->nx)
        return;
    find_norms(s, job->kernel, job->src);
    gp_fft_split_choose(job->src, job->kernel, s->tail,
                        (double) p->nx * p->ny,
                        gp_fft_predict_ms(job->src, p),
                        (double) job->params->gain, split);
}

/* Each part is within its bound of its own share of the layer, of which the
 * norm is at least `least`. */
static double bound_of(const struct gp_glare_job *job,
                       const struct gp_fft_state *s,
                       const struct gp_fft_placing *p,
                       const struct gp_fft_split *split, double least)
{
    const size_t n = job->src->n;
    const struct gp_taps taps = {.lobes = s->quarters.lobes};
    const int parts = (split->core >= 0) + (split->hot_count > 0);
    double sum = parts ? parts * gp_direct_bound(&taps, n) : 0.0;
    if (p->nx && split->hot_count < n)
        sum += gp_fft_bound(job->src, job->kernel, least, p);
    return sum;
}

/* By the least layer that sources anywhere would leave and, where that is more
 * than the tolerance, by the least that these do, which takes longer to find
 * than the layer. */
static gp_status bound(const struct gp_glare_job *job, void **state,
                       double *out)
{
    struct gp_fft_placing p;
    struct gp_fft_split split;
    double least;
    gp_status st = open_state(job, state);
    if (st)
        return st;
    struct gp_fft_state *const s = *state;
    place_and_split(job, s, &p, &split);
    const double anywhere = gp_fft_least(job->src, &s->quarters);
    *out = bound_of(job, s, &p, &split, anywhere);
    if (*out <= (double) job->params->tolerance || s->quarters.lobes)
        return GP_OK;
    st = gp_layer_least(job->log, job->src, job->kernel, &s->least, &least);
    if (!st)
        *out = bound_of(job, s, &p, &split, fmax(least, anywhere));
    return st;
}

static gp_status run(const struct gp_glare_job *job, void **state)
{
    gp_status st = open_state(job, state);
    if (st)
        return st;
    struct gp_fft_state *const s = *state;
    struct gp_sources hot = {0}, rest = {0};
    const struct gp_sources *src = job->src;
    struct gp_fft_split split;
    struct gp_fft_placing p;
    place_and_split(job, s, &p, &split);
    if (!(job->stats->bound > 0.0))
        job->stats->bound =
            bound_of(job, s, &p, &split, gp_fft_least(src, &s->quarters));
    if (split.hot_count) {
        GP_TRY(gp_sources_split(job->log, src, split.hot, &hot, &rest));
        src = &rest;
        p = src->n ? gp_fft_place(src, job->kernel) : (struct gp_fft_placing) {0};
    }
    if (p.nx)
        GP_TRY(transform(job, s, src, &p, split.core));
    else
        clear_rows(job, 0, job->src->h);
    GP_TRY(add_direct(job, s, &split, &hot, src));
    job->stats->fft_w = p.nx;
    job->stats->fft_h = p.ny;
    job->stats->fft_core = split.core;
    job->stats->hot = split.hot_count;
out:
    gp_sources_free(&hot);
    gp_sources_free(&rest);
    return st;
}

const struct gp_engine gp_engine_fft = {
    .name = "fft",
    .text = "exact convolution by fast Fourier transforms",
    .predict = gp_fft_predict,
    .bound = bound,
    .run = run,
    .close = close_state,
};
