// SPDX-License-Identifier: Apache-2.0
/* The engine fft; split.c chooses the part that goes direct, spectrum.c makes
 * the kernel's spectrum, pass.c has the transforms. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/bound/bound.h"
#include "glare/direct/direct.h"
#include "glare/fft/fft_priv.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Kept from frame to frame; each part is made anew when its key differs. */
struct fft_state {
    struct gp_fft_plan_pair plan[8]; // of the lengths used last, latest last
    int plans;
    struct gp_fft_spectrum spectrum; // the kernel's
    struct gp_fft_matrix work; // of one channel: three leave the cache; empty
                               // between frames
    unsigned long shape_kernel; // serial of the shapes'
    struct gp_fft_shape shape[3];
    unsigned long taps_kernel; // serial of the taps'
    struct gp_taps core_taps, all_taps;
    struct gp_fft_core core_taps_of;
    unsigned long tail_kernel; // serial of the norms'
    double tail[GP_FFT_CORES];
    unsigned long quarters_kernel; // serial and frame of the quarters
    int quarters_w, quarters_h;
    struct gp_fft_quarters quarters;
};

static void close_state(void **state)
{
    struct fft_state *const s = *state;
    if (s) {
        for (int i = 0; i < s->plans; i++)
            gp_fft_plan_free(&s->plan[i]);
        gp_fft_matrix_free(&s->spectrum.m);
        for (int c = 0; c < 3; c++)
            gp_fft_shape_free(&s->shape[c]);
        gp_taps_free(&s->core_taps);
        gp_taps_free(&s->all_taps);
    }
    GP_FREE(*state);
}

/* Returns the index of the plans of length n; s->plans when it has none. */
static int plan_at(const struct fft_state *s, int n, enum gp_fft_plan how,
                   bool in_double)
{
    int i = 0;
    while (i < s->plans &&
           (s->plan[i].n != n || s->plan[i].in_double != in_double ||
            (s->plan[i].how != how && !in_double)))
        i++;
    return i;
}

/* The plans of length n, from the state or made; they stay when one more
 * length is asked for, but may move. */
static gp_status find_plan(const struct gp_glare_request *req,
                           struct fft_state *s, int n, bool in_double,
                           const struct gp_fft_plan_pair **out)
{
    const int room = (int) (sizeof s->plan / sizeof *s->plan);
    const int i = plan_at(s, n, req->params->fft_plan, in_double);
    if (i < s->plans) {
        const struct gp_fft_plan_pair found = s->plan[i];
        memmove(s->plan + i, s->plan + i + 1,
                sizeof found * (size_t) (s->plans - 1 - i));
        s->plan[s->plans - 1] = found;
        *out = &s->plan[s->plans - 1];
        return GP_OK;
    }
    if (s->plans == room) { // the one that was not used for longest
        gp_fft_plan_free(&s->plan[0]);
        memmove(s->plan, s->plan + 1, sizeof *s->plan * (size_t) (room - 1));
        s->plans--;
    }
    struct gp_fft_plan_pair *const made = &s->plan[s->plans];
    gp_status st =
        in_double ? gp_fft_plan_make_double(req->log, n, made)
                  : gp_fft_plan_make(req->log, n, req->params->fft_plan,
                                     req->params->wisdom, made);
    if (!st)
        *out = made;
    s->plans += !st;
    return st;
}

// -- one frame ---------------------------------------------------------------

/* Rows of the frame that hold light, in order, and their places. */
struct light_rows {
    const struct gp_sources *src;
    const struct gp_fft_placing *p;
    struct gp_planes *layer;
    struct gp_fft_reach *reach; // NULL: of a negative kernel
    float noise[3];             // most of a sample, by channels
    struct gp_layer_rest *rest; // or NULL
    int n;
    int *y, *place;
};

static void load_light_row(const void *ctx, int c, int j, float *z)
{
    const struct light_rows *const r = ctx;
    const struct gp_sources *const s = r->src;
    const int y = r->y[j];
    for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++)
        z[2 * (s->x[i] - r->p->in.x0)] = s->rgb[c][i];
}

/* Makes samples under 0 black. Returns true when some are in (0, noise]. */
GP_CLONES static bool clean_row(float *row, int n, float noise)
{
    int some = 0;
    for (int x = 0; x < n; x++) {
        row[x] = row[x] > 0.0f ? row[x] : 0.0f;
        some |= (row[x] > 0.0f) & (row[x] <= noise);
    }
    return some;
}

/* Every second of 2 n floats. */
GP_CLONES static void take_real(const float *restrict z, int n,
                                float *restrict out)
{
    for (int x = 0; x < n; x++)
        out[x] = z[2 * x];
}

/* Output row j back to the layer, without rounding noise where no light
 * reaches, and with the rest: places start at the box's corner, modulo nx. */
static void store_layer_row(const void *ctx, int c, int j, int thread,
                            const float *z)
{
    const struct light_rows *const r = ctx;
    const struct gp_fft_placing *const p = r->p;
    const int w = r->src->w, y = p->out.y0 + j;
    float *const row = r->layer->c[c] + (size_t) y * (size_t) w;
    memset(row, 0, (size_t) p->out.x0 * sizeof *row);
    const int first = gp_fft_wrap(p->out.x0 - p->in.x0, p->nx);
    const int end = p->out.x0 + p->nx - first;
    const int seam = end < p->out.x1 ? end : p->out.x1;
    take_real(z + 2 * first, seam - p->out.x0, row + p->out.x0);
    take_real(z, p->out.x1 - seam, row + seam);
    memset(row + p->out.x1, 0, (size_t) (w - p->out.x1) * sizeof *row);
    if (r->reach &&
        clean_row(row + p->out.x0, gp_rect_w(p->out), r->noise[c]))
        gp_fft_reach_clear(r->reach, c, y, thread, r->noise[c], row);
    if (r->rest)
        r->rest->add(r->rest->ctx, c * r->src->h + y, thread);
}

/* Row i of those of the layer that no light of the transform reaches: only the
 * rest. */
static void store_dark_row(void *ctx, int i, int thread)
{
    const struct light_rows *const r = ctx;
    const struct gp_rect *const out = &r->p->out;
    const size_t w = (size_t) r->src->w;
    const int y = i < out->y0 ? i : i + gp_rect_h(*out);
    for (int c = 0; c < 3; c++) {
        memset(r->layer->c[c] + (size_t) y * w, 0, w * sizeof(float));
        if (r->rest)
            r->rest->add(r->rest->ctx, c * r->src->h + y, thread);
    }
}

/* Opens the reach of `src` through the kernel, whose shapes are kept. */
static gp_status open_reach(const struct gp_glare_request *req,
    struct fft_state *s, const struct gp_sources *src,
    struct gp_fft_reach **out)
{
    const struct gp_kernel *const k = req->kernel;
    const struct gp_fft_shape *shape[3];
    if (!gp_fft_is_of(s->shape_kernel, k)) {
        for (int c = 0; c < 3; c++)
            gp_fft_shape_free(&s->shape[c]);
        s->shape_kernel = k->serial;
    }
    for (int c = 0; c < 3; c++) {
        struct gp_fft_shape *const own = &s->shape[k->grey ? 0 : c];
        gp_status st = GP_OK;
        if (!own->row)
            st = gp_fft_shape_make(req->log, k, c, own);
        if (st)
            return st;
        shape[c] = own;
    }
    return gp_fft_reach_open(req->log, src, k, shape, out);
}

/* Returns the rounding of a split's transforms over that of float. */
static double over_float(const struct gp_fft_split *split)
{
    return split->in_double ? GP_FFT_DOUBLE_ROUNDING : 1.0;
}

/* Transforms `src` with the kernel less its core into the layer. */
static gp_status transform(const struct gp_glare_request *req,
    struct fft_state *s,
    const struct gp_sources *src, const struct gp_fft_placing *p,
    const struct gp_fft_split *split)
{
    gp_status st;
    const bool twice = split->in_double;
    struct gp_fft_request fft = {.log = req->log, .channels = 1};
    struct gp_fft_making kernel = {0};
    struct light_rows light = {.src = src, .p = p, .layer = req->layer,
                               .rest = req->rest};
    const int count = gp_rect_h(p->out);
    GP_TRY(find_plan(req, s, p->ny, twice, &fft.y));
    const struct gp_fft_plan_pair kept = *fft.y; // the list may move
    GP_TRY(find_plan(req, s, p->nx, twice, &fft.x));
    fft.y = &kept;
    const size_t lit = (size_t) gp_rect_h(p->in);
    GP_TRY(gp_alloc(req->log, "transform", lit, sizeof(int), &light.y));
    GP_TRY(gp_alloc(req->log, "transform", lit, sizeof(int), &light.place));
    for (int row = p->in.y0; row < p->in.y1; row++) {
        if (src->row[row + 1] > src->row[row]) {
            light.y[light.n] = row;
            light.place[light.n++] = row - p->in.y0;
        }
    }
    GP_TRY(gp_fft_making_open(req, &s->spectrum, p, split, &kernel));
    GP_TRY(gp_fft_matrix_make_of(
        req->log, (struct gp_fft_numbers) {.in_double = twice}, 1, p->nx,
        gp_max(light.n, count), &s->work));
    for (int c = 0; c < 3; c++) {
        const struct gp_kernel *const k = req->kernel;
        const double norm = sqrt(src->energy[c]);
        const double noise = gp_fft_pixel_error(
            p, fmin((double) src->brightest * k->norm1[c], norm * k->norm2[c]),
            fmin(norm * k->norm1[c], src->flux[c] * k->norm2[c]), INFINITY);
        light.noise[c] = (float) (noise * over_float(split));
    }
    if (!req->kernel->negative)
        GP_TRY(open_reach(req, s, src, &light.reach));
    const int first = gp_fft_wrap(p->out.y0 - p->in.y0, p->ny);
    for (fft.channel = 0; fft.channel < 3; fft.channel++) {
        struct gp_fft_matrix m = gp_fft_one_channel(&s->work, 0, fft.channel), view;
        GP_TRY(gp_fft_making_load(&fft, &kernel, &view));
        GP_TRY(gp_fft_rows_in(&fft, light.n, load_light_row, &light, &m));
        GP_TRY(gp_fft_multiply(&fft, &m, light.n, light.place, &kernel.passes,
                               first, count));
        GP_TRY(gp_fft_rows_out(&fft, &m, count, store_layer_row, &light));
    }
    gp_parallel_do(src->h - count, store_dark_row, &light);
    if (req->rest)
        req->rest->added = true;
    gp_fft_matrix_free(&s->work);
    gp_fft_making_free(&kernel);
    if (s->spectrum.m.z[0]) {
        s->spectrum.kernel = req->kernel->serial;
        s->spectrum.placing = *p;
        s->spectrum.core = split->core;
        s->spectrum.in_double = twice;
    }
    if (req->params->last)
        gp_fft_matrix_free(&s->spectrum.m);
out:
    gp_fft_matrix_free(&s->work);
    gp_fft_making_free(&kernel);
    gp_fft_reach_free(&light.reach);
    gp_free(light.y);
    gp_free(light.place);
    return st;
}

/* Returns the norms of gp_fft_far_norms(), which are found once a kernel. */
static const double *find_tail_norms(struct fft_state *s,
                                     const struct gp_kernel *k)
{
    if (!gp_fft_is_of(s->tail_kernel, k)) {
        gp_fft_far_norms(k, s->tail);
        s->tail_kernel = k->serial;
    }
    return s->tail;
}

/* Chooses the split, or double where it is asked for. */
static void choose_split(const struct gp_glare_request *req,
    const struct gp_fft_placing *p, const double tail[GP_FFT_CORES],
    struct gp_fft_split *out)
{
    // never by how plans are made: the layer would then depend on it
    const double ms = gp_fft_passes_ms(req->src, p, GP_FFT_PLAN_MEASURE);
    gp_fft_split_choose(req->src, req->kernel, tail, (double) p->nx * p->ny, ms,
                        (double) req->params->gain, out);
    if (req->params->in_double && !out->in_double)
        *out = (struct gp_fft_split) {
            .core = {-1, -1}, .hot = INFINITY, .in_double = true,
            .ms = (GP_COST_FFT_DOUBLE - 1.0) * ms,
        };
}

/* Opens the state, places all sources, and chooses the part of the sum that
 * goes direct; p->nx is 0 when no light reaches the frame. */
static gp_status place_and_split(const struct gp_glare_request *req,
    void **state, struct gp_fft_placing *p, struct gp_fft_split *split)
{
    const struct gp_kernel *const k = req->kernel;
    const struct gp_sources *const src = req->src;
    if (!*state) {
        gp_status st = gp_alloc_zero(req->log, "fft", 1,
                                     sizeof(struct fft_state), state);
        if (st)
            return st;
    }
    struct fft_state *const s = *state;
    *split = (struct gp_fft_split) {.core = {-1, -1}, .hot = INFINITY};
    *p = gp_fft_place(src, k);
    if (!p->nx)
        return GP_OK;
    if (!gp_fft_is_of(s->quarters_kernel, k) || s->quarters_w != src->w ||
        s->quarters_h != src->h) {
        gp_fft_find_quarters(k, src->w, src->h, &s->quarters);
        s->quarters_kernel = k->serial;
        s->quarters_w = src->w;
        s->quarters_h = src->h;
    }
    choose_split(req, p, find_tail_norms(s, k), split);
    return GP_OK;
}

/* Adds the bounds of the parts, each relative to its own share of the layer,
 * whose norm is at least `least`. */
static double bound_of(const struct gp_glare_request *req,
                       const struct gp_fft_placing *p,
                       const struct gp_fft_split *split, double least)
{
    const size_t n = req->src->n;
    const int direct = (split->core.x >= 0) + (split->hot_count > 0);
    double sum = direct ? direct * gp_direct_bound(req->kernel, n) : 0.0;
    if (p->nx && split->hot_count < n)
        sum += gp_fft_bound(req->src, req->kernel, least, p) *
               over_float(split);
    return sum + (split->in_double ? 0x1p-24 : 0.0); // rounded to float once
}

/* Bounds by the lower limit of the layer of sources anywhere and, where that is
 * over the tolerance, by the limit for these sources, which takes longer to
 * find than the layer. */
static gp_status bound_fft(const struct gp_glare_request *req, void **state,
                           double *out)
{
    struct gp_fft_placing p;
    struct gp_fft_split split;
    double least;
    gp_status st = place_and_split(req, state, &p, &split);
    if (st)
        return st;
    struct fft_state *const s = *state;
    const double anywhere = gp_fft_least(req->src, &s->quarters);
    *out = bound_of(req, &p, &split, anywhere);
    if (*out <= (double) req->params->tolerance || req->kernel->negative)
        return GP_OK;
    st = gp_layer_least(req->log, req->src, req->kernel, &least);
    if (!st)
        *out = bound_of(req, &p, &split, fmax(least, anywhere));
    return st;
}

/* Sums of the sources that are transformed, those under `hot`. */
struct cool {
    double flux[3], energy[3], brightest;
};

static struct cool find_cool(const struct gp_sources *src, float hot)
{
    struct cool o = {0};
    for (size_t i = 0; i < src->n; i++) {
        const float most = gp_maxf(src->rgb[0][i],
                                   gp_maxf(src->rgb[1][i], src->rgb[2][i]));
        if (most >= hot)
            continue;
        o.brightest = fmax(o.brightest, (double) most);
        for (int c = 0; c < 3; c++) {
            const double v = (double) src->rgb[c][i];
            o.flux[c] += v;
            o.energy[c] += v * v;
        }
    }
    return o;
}

/* Bounds the error of a sample of channel c of the transform, of this light and
 * the kernel without its core: Young's inequality for the layer's largest
 * sample and for its norm. */
static double cool_error(const struct gp_fft_placing *p,
                         const struct gp_kernel *k, const struct cool *s, int c,
                         struct gp_fft_core core)
{
    double sum = 0.0, square = 0.0, most = 0.0;
    for (int y = 0; y < k->h; y++) {
        const float *const row = k->k.c[c] + (size_t) y * (size_t) k->w;
        for (int x = 0; x < k->w; x++) {
            const double v =
                abs(x - k->cx) <= core.x && abs(y - k->cy) <= core.y
                    ? 0.0 : (double) row[x];
            sum += v;
            square += v * v;
            most = fmax(most, v);
        }
    }
    const double norm = sqrt(s->energy[c]), kernel = sqrt(square);
    return gp_fft_pixel_error(
        p, fmin(fmin(s->brightest * sum, s->flux[c] * most), norm * kernel),
        fmin(norm * sum, s->flux[c] * kernel), s->brightest * most);
}

/* Bounds the pixel error: direct parts by their share, the rest by split.c. */
static gp_status pixel_fft(const struct gp_glare_request *req, void **state,
                           struct gp_pixel_error *out)
{
    struct gp_fft_placing p;
    struct gp_fft_split split;
    const size_t n = req->src->n;
    gp_status st = place_and_split(req, state, &p, &split);
    if (st)
        return st;
    const int direct = (split.core.x >= 0) + (split.hot_count > 0);
    *out = (struct gp_pixel_error) {
        .relative = req->kernel->negative ? INFINITY
                    : direct ? direct * gp_direct_bound(req->kernel, n)
                    : split.in_double ? 0x1p-24 : 0.0,
    };
    const struct cool cool = find_cool(req->src, split.hot);
    for (int c = 0; c < 3 && p.nx && split.hot_count < n; c++)
        out->of[c] = cool_error(&p, req->kernel, &cool, c, split.core) *
                     over_float(&split);
    return GP_OK;
}

static gp_status run_fft(const struct gp_glare_request *req, void **state)
{
    struct gp_sources hot = {0}, rest = {0};
    const struct gp_sources *src = req->src;
    const struct gp_kernel *const k = req->kernel;
    struct gp_fft_split split;
    struct gp_fft_placing p;
    gp_status st = place_and_split(req, state, &p, &split);
    if (st)
        return st;
    struct fft_state *const s = *state;
    if (!(req->stats->bound > 0.0))
        req->stats->bound =
            bound_of(req, &p, &split, gp_fft_least(src, &s->quarters));
    if (split.hot_count) {
        GP_TRY(gp_sources_split(req->log, src, split.hot, &hot, &rest));
        src = &rest;
        p = src->n ? gp_fft_place(src, k) : (struct gp_fft_placing) {0};
    }
    if (p.nx)
        GP_TRY(transform(req, s, src, &p, &split));
    else
        gp_planes_clear(req->layer, 0, (size_t) req->src->w *
                                           (size_t) req->src->h);
    // add the direct parts: the core for all that was transformed, and hot
    // sources whole
    if (!gp_fft_is_of(s->taps_kernel, k)) {
        gp_taps_free(&s->core_taps);
        gp_taps_free(&s->all_taps);
        s->taps_kernel = k->serial;
    }
    if (split.core.x >= 0 && src->n) {
        if (!s->core_taps.k[0] || !gp_fft_same_core(s->core_taps_of, split.core)) {
            gp_taps_free(&s->core_taps);
            GP_TRY(gp_taps_cut(req->log, k, split.core.x, split.core.y,
                               &s->core_taps));
            s->core_taps_of = split.core;
        }
        GP_TRY(gp_direct_sum(req->log, src, &s->core_taps, true, req->layer));
    }
    if (hot.n) {
        if (!s->all_taps.k[0])
            GP_TRY(gp_taps_make(req->log, k, -1, &s->all_taps));
        GP_TRY(gp_direct_sum(req->log, &hot, &s->all_taps, true, req->layer));
    }
    req->stats->fft_w = p.nx;
    req->stats->fft_h = p.ny;
    req->stats->near[0] = split.core.x;
    req->stats->near[1] = split.core.y;
    req->stats->in_double = split.in_double;
out:
    gp_sources_free(&hot);
    gp_sources_free(&rest);
    return st;
}

const struct gp_engine gp_engine_fft = {
    .name = "fft",
    .text = "exact convolution by fast Fourier transforms",
    .bound = bound_fft,
    .pixel = pixel_fft,
    .run = run_fft,
    .close = close_state,
};
