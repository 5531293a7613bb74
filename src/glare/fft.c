#include "glare/engine.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "glare/cost.h"
#include "glare/direct.h"
#include "glare/fft_lib.h"
#include "glare/fft_pass.h"
#include "glare/fft_place.h"
#include "glare/fft_split.h"

#include <math.h>
#include <stdlib.h>
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

/* Kept from frame to frame; each part is made anew when its key differs. */
struct state {
    struct gp_fft_plan_pair plan[8]; // of the lengths used last, latest last
    int plans;
    unsigned long kernel; // serial of the spectrum's
    struct gp_fft_placing placing;
    int core;
    struct gp_fft_matrix spectrum; // the kernel's, transposed, scaled
    struct gp_fft_matrix work;     // of one channel: three would leave the cache
    size_t work_rows;
    unsigned long taps_kernel; // serial of the taps'
    struct gp_taps core_taps, all_taps;
    int core_taps_radius;
    unsigned long norms_kernel; // serial and frame of what follows
    int norms_w, norms_h;
    double tail[GP_FFT_CORES], spread;
};

static bool is_known(unsigned long serial, const struct gp_kernel *k)
{
    return serial && serial == k->serial;
}

static void close_state(void **state)
{
    struct state *const s = *state;
    if (s) {
        for (int i = 0; i < s->plans; i++)
            gp_fft_plan_free(&s->plan[i]);
        gp_fft_matrix_free(&s->spectrum);
        gp_fft_matrix_free(&s->work);
        gp_taps_free(&s->core_taps);
        gp_taps_free(&s->all_taps);
    }
    GP_FREE(*state);
}

/* The plans of length n, from the state or made; they stay when one more
 * length is asked for, but may move. */
static gp_status find_plan(const struct gp_glare_job *job, struct state *s,
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

/* The matrix of one plane, as the plane of channel c. */
static struct gp_fft_matrix as_channel(const struct gp_fft_matrix *m, int c)
{
    struct gp_fft_matrix view = {.columns = m->columns, .pitch = m->pitch};
    view.z[c] = m->z[0];
    return view;
}

/* -- the kernel's spectrum -------------------------------------------------- */

struct kernel_rows {
    const struct gp_kernel *kernel;
    const struct gp_fft_placing *p;
    int core;
};

/* Row of offset dy = taps.y0 + j, each sample at its offset modulo nx. */
static void load_kernel(const void *ctx, int c, int j, float *z)
{
    const struct kernel_rows *const r = ctx;
    const struct gp_kernel *const k = r->kernel;
    const int dy = r->p->taps.y0 + j, nx = r->p->nx;
    const float *const row =
        k->k.c[c] + (size_t) (dy + k->cy) * (size_t) k->w + k->cx;
    for (int dx = r->p->taps.x0; dx < r->p->taps.x1; dx++) {
        const int inside = abs(dx) <= r->core && abs(dy) <= r->core;
        if (!inside)
            z[2 * wrap(dx, nx)] = row[dx];
    }
}

/* Rows first .. first + n at places modulo ny. */
static gp_status make_places(const struct gp_log *log, int first, int n,
                             int ny, int **out)
{
    void *v;
    gp_status st = gp_alloc(log, "transform", (size_t) n, sizeof **out, &v);
    if (st)
        return st;
    *out = v;
    for (int j = 0; j < n; j++)
        (*out)[j] = wrap(first + j, ny);
    return GP_OK;
}

static bool same_spectrum(const struct state *s, const struct gp_kernel *k,
                          const struct gp_fft_placing *p, int core)
{
    return s->spectrum.z[0] && is_known(s->kernel, k) &&
           s->core == core && s->placing.nx == p->nx &&
           s->placing.ny == p->ny &&
           memcmp(&s->placing.taps, &p->taps, sizeof p->taps) == 0;
}

static gp_status make_spectrum(const struct gp_glare_job *job,
                               struct state *s, const struct gp_fft_job *fft,
                               const struct gp_fft_placing *p, int core)
{
    gp_status st = GP_OK;
    const struct gp_kernel *const k = job->kernel;
    if (same_spectrum(s, k, p, core))
        return GP_OK;
    gp_fft_matrix_free(&s->spectrum);
    struct gp_fft_matrix rows = {0};
    int *places = NULL;
    const int n = gp_rect_h(p->taps), channels = k->grey ? 1 : 3;
    const struct kernel_rows from = {.kernel = k, .p = p, .core = core};
    struct gp_fft_job one = *fft;
    // two factors 1/2 were left out on the way in: the kernel's rows, the
    // sources' rows
    const float scale = (float) (0.25 / ((double) p->nx * p->ny));
    GP_TRY(gp_fft_matrix_make(job->log, 1, p->nx, n, &rows));
    GP_TRY(gp_fft_matrix_make(job->log, channels, p->nx, p->ny,
                              &s->spectrum));
    GP_TRY(make_places(job->log, p->taps.y0, n, p->ny, &places));
    for (one.channel = 0; one.channel < channels; one.channel++) {
        struct gp_fft_matrix m = as_channel(&rows, one.channel);
        GP_TRY(gp_fft_rows_in(&one, n, load_kernel, &from, &m));
        GP_TRY(gp_fft_columns(&one, &m, n, places, scale, &s->spectrum));
    }
    s->kernel = k->serial;
    s->placing = *p;
    s->core = core;
out:
    if (st)
        gp_fft_matrix_free(&s->spectrum);
    gp_free(places);
    gp_fft_matrix_free(&rows);
    return st;
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
static gp_status transform(const struct gp_glare_job *job, struct state *s,
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
        struct gp_fft_matrix m = as_channel(&s->work, fft.channel);
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

static bool has_plan(const struct state *s, int n, enum gp_fft_plan how)
{
    for (int i = 0; i < s->plans; i++) {
        if (s->plan[i].n == n && s->plan[i].how == how)
            return true;
    }
    return false;
}

/* What a run with this placing has to make before it can start. */
static double setup_ms(const struct gp_glare_job *job, const struct state *s,
                       const struct gp_fft_placing *p, int core)
{
    const struct gp_glare_params *const params = job->params;
    const struct gp_kernel *const k = job->kernel;
    // a file that keeps measured plans is taken to have these
    const double plan = params->fft_plan == GP_FFT_PLAN_MEASURE &&
                                !params->wisdom
                            ? GP_COST_FFT_PLAN_MEASURE
                            : GP_COST_FFT_PLAN_ESTIMATE;
    const int rows = max(gp_rect_h(p->in), gp_rect_h(p->out));
    double ms = s->plans ? 0.0 : GP_COST_FFT_LIBRARY;
    if (!has_plan(s, p->nx, params->fft_plan))
        ms += plan;
    if (p->ny != p->nx && !has_plan(s, p->ny, params->fft_plan))
        ms += plan;
    if (!same_spectrum(s, k, p, core))
        ms += gp_cost_spectrum(k, p, params->fft_plan);
    if (!s->work.z[0])
        ms += GP_COST_FRESH_BYTE * 4.0 * p->nx * rows;
    if (!is_known(s->norms_kernel, k))
        ms += GP_COST_FFT_NORMS * 3.0 * k->w * k->h;
    return ms;
}

static double predict_ms(const struct gp_glare_job *job, const void *state)
{
    static const struct state empty;
    const struct state *const s = state ? state : &empty;
    const struct gp_fft_placing p = gp_fft_place(job->src, job->kernel);
    if (!p.nx)
        return GP_COST_FFT_RUN;
    double tail[GP_FFT_CORES];
    struct gp_fft_split split;
    if (is_known(s->norms_kernel, job->kernel))
        memcpy(tail, s->tail, sizeof tail);
    else
        gp_fft_tail_norms(job->kernel, tail);
    gp_fft_split_choose(job->src, job->kernel, tail, (double) p.nx * p.ny,
                        gp_fft_predict_ms(job->src, &p),
                        (double) job->params->gain, &split);
    return GP_COST_FFT_RUN + split.ms +
           gp_cost_passes(job->src, &p, job->params->fft_plan) +
           (job->later ? 0.0 : setup_ms(job, s, &p, split.core));
}

/* Adds a direct part, and its rounding to the bound. */
static gp_status add_taps(const struct gp_glare_job *job,
                          const struct gp_sources *src,
                          const struct gp_taps *taps)
{
    job->stats->bound += gp_direct_bound(taps, src->n);
    return gp_direct_sum(job->log, src, taps, true, job->layer);
}

/* What goes direct: the core for all that was transformed, and hot sources
 * whole. */
static gp_status add_direct(const struct gp_glare_job *job, struct state *s,
                            const struct gp_fft_split *split,
                            const struct gp_sources *hot,
                            const struct gp_sources *rest)
{
    gp_status st = GP_OK;
    if (!is_known(s->taps_kernel, job->kernel)) {
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
            st = add_taps(job, rest, &s->core_taps);
    }
    if (!st && hot->n && !s->all_taps.k[0])
        st = gp_taps_make(job->log, job->kernel, -1, &s->all_taps);
    if (!st && hot->n)
        st = add_taps(job, hot, &s->all_taps);
    return st;
}

static void find_norms(struct state *s, const struct gp_kernel *k,
                       const struct gp_sources *src)
{
    if (is_known(s->norms_kernel, k) && s->norms_w == src->w &&
        s->norms_h == src->h)
        return;
    gp_fft_tail_norms(k, s->tail);
    s->spread = gp_fft_kernel_spread(k, src->w, src->h);
    s->norms_kernel = k->serial;
    s->norms_w = src->w;
    s->norms_h = src->h;
}

static gp_status run(const struct gp_glare_job *job, void **state)
{
    gp_status st = GP_OK;
    if (!*state)
        st = gp_alloc_zero(job->log, "fft", 1, sizeof(struct state), state);
    if (st)
        return st;
    struct state *const s = *state;
    struct gp_sources hot = {0}, rest = {0};
    const struct gp_sources *src = job->src;
    struct gp_fft_split split = {.core = -1, .hot = INFINITY};
    struct gp_fft_placing p = gp_fft_place(src, job->kernel);
    if (p.nx) {
        find_norms(s, job->kernel, src);
        gp_fft_split_choose(src, job->kernel, s->tail, (double) p.nx * p.ny,
                            gp_fft_predict_ms(src, &p), (double) job->params->gain,
                            &split);
    }
    if (split.hot_count) {
        GP_TRY(gp_fft_split_sources(job->log, src, split.hot, &hot, &rest));
        src = &rest;
        p = src->n ? gp_fft_place(src, job->kernel) : (struct gp_fft_placing) {0};
    }
    if (p.nx)
        GP_TRY(transform(job, s, src, &p, split.core));
    else
        clear_rows(job, 0, job->src->h);
    job->stats->bound = p.nx ? gp_fft_bound(s->spread, &p) : 0.0;
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
    .predict_ms = predict_ms,
    .bound = NULL,
    .run = run,
    .close = close_state,
};
