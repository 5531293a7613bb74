// SPDX-License-Identifier: Apache-2.0
/* The engine fft: one frame by transforms, in float or in double. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/bound/bound.h"
#include "glare/fft/fft.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* Kept from frame to frame; each part is made anew when its key differs. */
struct fft_state {
    struct gp_fft_placing p; // of the frame; nx is 0 when no light reaches it
    bool in_double;          // it is
    struct gp_transform pair[2]; // of x and y
    bool pair_in_double;
    struct gp_fft_spectrum spectrum;
    struct gp_fft_matrix work; // of one channel: three leave the cache; empty
                               // between frames
    unsigned long kernel; // serial of the kernel, and frame, of what follows
    int w, h;
    struct gp_fft_norms norms;
    struct gp_fft_quarters quarters;
};

static void close_state(void **state)
{
    struct fft_state *const s = *state;
    if (s) {
        gp_fft_pair_free(s->pair);
        gp_fft_spectrum_free(&s->spectrum);
    }
    GP_FREE(*state);
}

// -- the kernel ---------------------------------------------------------------

/* Adds n samples to sum of magnitudes, sum of squares and largest. */
GP_CLONES static void add_norms(const float *v, size_t n, double out[3])
{
    enum { LANES = 8 };
    double sum[LANES] = {0}, square[LANES] = {0};
    float most[LANES] = {0};
    size_t i = 0;
    for (; i < n; i += LANES) {
        for (size_t j = 0; j < LANES; j++) {
            const float a = i + j < n ? fabsf(v[i + j]) : 0.0f;
            sum[j] += (double) a;
            square[j] += (double) a * (double) a;
            most[j] = gp_maxf(most[j], a);
        }
    }
    for (int j = 0; j < LANES; j++) {
        out[0] += sum[j];
        out[1] += square[j];
        out[2] = fmax(out[2], (double) most[j]);
    }
}

static struct gp_fft_norms norms_of(const struct gp_kernel *k)
{
    struct gp_fft_norms o;
    for (int c = 0; c < 3; c++) {
        double v[3] = {0};
        const size_t at = (size_t) k->cy * (size_t) k->w + (size_t) k->cx;
        const size_t n = (size_t) k->w * (size_t) k->h;
        const float *const all = k->k.c[c];
        if (gp_kernel_centre(k, c) > 0.0f) {
            add_norms(all, at, v);
            add_norms(all + at + 1, n - at - 1, v);
        } else {
            add_norms(all, n, v);
        }
        o.sum[c] = v[0];
        o.norm[c] = sqrt(v[1]);
        o.most[c] = v[2];
    }
    return o;
}

// -- one frame ---------------------------------------------------------------

/* Rows of the frame that hold light, in order, and their places; and what
 * becomes of the layer's rows. */
struct light_rows {
    const struct gp_sources *src;
    const struct gp_fft_placing *p;
    struct gp_planes *layer;
    float centre[3], noise[3]; // of the kernel; samples up to it become 0
    int *y;                    // of row j of light
    int *lost; // by channel and row of the layer: samples up to noise
};

static void load_light_row(const void *ctx, int c, int j, float *z)
{
    const struct light_rows *const r = ctx;
    const struct gp_sources *const s = r->src;
    const uint32_t end = s->row[r->y[j] + 1];
    for (uint32_t i = s->row[r->y[j]]; i < end; i++)
        z[s->x[i] - r->p->in.x0] = s->rgb[c][i];
}

/* Copies n samples, those up to `noise` as black. Returns how many of these were
 * over 0. */
GP_CLONES static int take_row(const float *restrict z, int n, float noise,
                              float *restrict row)
{
    int lost = 0;
    for (int x = 0; x < n; x++) {
        row[x] = z[x] > noise ? z[x] : 0.0f;
        lost += (z[x] > 0.0f) & (z[x] <= noise);
    }
    return lost;
}

/* Output row j back to the layer: places start at the box's corner, modulo nx. */
static void store_layer_row(const void *ctx, int c, int j, const float *z)
{
    const struct light_rows *const r = ctx;
    const struct gp_fft_placing *const p = r->p;
    const struct gp_sources *const src = r->src;
    const int y = p->out.y0 + j;
    float *const row = r->layer->c[c] + (size_t) y * (size_t) src->w;
    memset(row, 0, (size_t) p->out.x0 * sizeof *row);
    const int first = gp_fft_wrap(p->out.x0 - p->in.x0, p->nx);
    const int n = gp_rect_w(p->out), upper = gp_min(n, p->nx - first);
    r->lost[c * src->h + y] =
        take_row(z + first, upper, r->noise[c], row + p->out.x0) +
        take_row(z, n - upper, r->noise[c], row + p->out.x0 + upper);
    memset(row + p->out.x1, 0, (size_t) (src->w - p->out.x1) * sizeof *row);
    for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
        row[src->x[i]] += src->rgb[c][i] * r->centre[c];
}

/* Returns what counts as noise of a sample of channel c: so many deviations. In
 * double they are nothing, and more of them keep black what no light reaches, but
 * for one sample in a million. */
static double noise_of(const struct gp_glare_request *req,
                       const struct fft_state *s, int c)
{
    static const double LEFT_OUT = 4.0, IN_DOUBLE = 32.0;
    return (s->in_double ? IN_DOUBLE : LEFT_OUT) *
           gp_fft_rounding(s->in_double) *
           gp_fft_noise(&s->p, req->src, &s->norms, c, false);
}

/* Makes the transforms of the frame's lengths, unless the state has them. */
static gp_status find_pair(const struct gp_log *log, struct fft_state *s)
{
    if (s->pair[1].root && s->pair[0].n == s->p.nx && s->pair[1].n == s->p.ny &&
        s->pair_in_double == s->in_double)
        return GP_OK;
    gp_fft_pair_free(s->pair);
    s->pair_in_double = s->in_double;
    return gp_fft_pair_make(log, s->p.nx, s->p.ny, s->in_double, s->pair);
}

/* Transforms the sources with the kernel into the layer. *dropped is the most that
 * became black, its sum of squares. */
static gp_status transform(const struct gp_glare_request *req,
                           struct fft_state *s, double *dropped)
{
    gp_status st;
    const struct gp_fft_placing *const p = &s->p;
    const struct gp_sources *const src = req->src;
    struct light_rows light = {.src = src, .p = p, .layer = req->layer};
    const int count = gp_rect_h(p->out), lit = gp_rect_h(p->in);
    const int first = gp_fft_wrap(p->out.y0 - p->in.y0, p->ny);
    struct gp_fft_rows rows = {0};
    int *place = NULL;
    GP_TRY(find_pair(req->log, s));
    struct gp_fft_request fft = {
        .log = req->log,
        .t = s->pair,
        .in_double = s->in_double,
        .channels = 1,
    };
    GP_TRY(
        gp_alloc(req->log, "transform", (size_t) lit, sizeof(int), &light.y));
    GP_TRY(gp_alloc(req->log, "transform", (size_t) lit, sizeof(int), &place));
    for (int row = p->in.y0; row < p->in.y1; row++) {
        if (src->row[row + 1] > src->row[row]) {
            light.y[rows.n] = row;
            place[rows.n++] = row - p->in.y0;
        }
    }
    rows.place = place;
    for (int c = 0; c < 3; c++) {
        light.centre[c] = gp_kernel_centre(req->kernel, c);
        light.noise[c] =
            req->kernel->negative ? -INFINITY : (float) noise_of(req, s, c);
    }
    GP_TRY(gp_alloc_zero(req->log, "transform", 3 * (size_t) src->h,
                         sizeof *light.lost, &light.lost));
    GP_TRY(gp_fft_matrix_make(
        req->log, (struct gp_fft_numbers) {.in_double = s->in_double}, 1, p->nx,
        gp_max(rows.n, count), &s->work));
    for (fft.channel = 0; fft.channel < 3; fft.channel++) {
        struct gp_fft_matrix m = gp_fft_one_channel(&s->work, fft.channel);
        GP_TRY(gp_fft_find_spectrum(req, &fft, p, &s->spectrum));
        GP_TRY(gp_fft_rows_in(&fft, rows.n, load_light_row, &light, &m));
        GP_TRY(gp_fft_multiply(&fft, rows, &s->spectrum.m, first, count, &m));
        GP_TRY(gp_fft_rows_out(&fft, &m, count, store_layer_row, &light));
    }
    const size_t w =
        (size_t) src->w; // rows that no light of the transform reaches
    gp_planes_clear(req->layer, 0, (size_t) p->out.y0 * w);
    gp_planes_clear(req->layer, (size_t) p->out.y1 * w,
                    (size_t) (src->h - p->out.y1) * w);
    for (int i = 0; i < 3 * src->h; i++) {
        const double noise = (double) light.noise[i / src->h];
        *dropped += light.lost[i] ? light.lost[i] * noise * noise : 0.0;
    }
    if (req->params->last)
        gp_fft_spectrum_free(&s->spectrum);
out:
    gp_fft_matrix_free(&s->work);
    gp_free(light.y);
    gp_free(light.lost);
    gp_free(place);
    return st;
}

/* Tests whether the noise of transforms in float would be seen: where the largest
 * error of a pixel is over the share of the darkest light that may be wrong. */
static bool is_seen(const struct gp_glare_request *req,
                    const struct fft_state *s)
{
    const struct gp_sources *const src = req->src;
    const double own = gp_sources_dark(src), gain = (double) req->params->gain;
    double noise = 0.0, glare = INFINITY;
    for (int c = 0; c < 3; c++) {
        noise += (double) src->luminance[c] *
                 gp_fft_noise(&s->p, src, &s->norms, c, true);
        if (req->kernel->far && src->flux[c] > 0.0)
            glare = fmin(glare, src->flux[c] * req->kernel->far->least);
    }
    const double limit = (double) req->params->seen *
                         (own + (glare < INFINITY ? gain * glare : 0.0));
    return !(gain * gp_fft_rounding(false) * noise <= limit);
}

/* Opens the state, places the sources, and chooses the precision. */
static gp_status open_frame(const struct gp_glare_request *req, void **state,
                            struct fft_state **out)
{
    const struct gp_kernel *const k = req->kernel;
    const struct gp_sources *const src = req->src;
    if (!*state) {
        gp_status st = gp_alloc_zero(req->log, "fft", 1,
                                     sizeof(struct fft_state), state);
        if (st)
            return st;
    }
    struct fft_state *const s = *out = *state;
    s->p = gp_fft_place(src, k);
    if (!gp_fft_is_of(s->kernel, k) || s->w != src->w || s->h != src->h) {
        s->norms = norms_of(k);
        gp_fft_find_quarters(k, src->w, src->h, &s->quarters);
        s->kernel = k->serial;
        s->w = src->w;
        s->h = src->h;
    }
    s->in_double = s->p.nx && (req->params->in_double || req->in_double ||
                               is_seen(req, s));
    return GP_OK;
}

/* Roundings of a sample outside of the transform: to float or of the centre's light,
 * of their sum, and where the far field is added. */
static const double OUTSIDE = 0x3p-24;

/* Bounds rel_l2, where the layer's norm is at least `least`. */
static double bound_of(const struct gp_glare_request *req,
                       const struct fft_state *s, double least)
{
    return !s->p.nx ? 0.0
                    : gp_fft_rounding(s->in_double) *
                              gp_fft_bound(req->src, &s->norms, least, &s->p) +
                          OUTSIDE;
}

/* A lower limit of the layer's norm, of sources anywhere. */
static double least_of(const struct gp_glare_request *req,
                       const struct fft_state *s)
{
    return fmax(gp_fft_least(req->src, &s->quarters), gp_layer_some(req));
}

/* Bounds by the lower limit of the layer of sources anywhere and, where that is
 * over the tolerance, by the limit for these sources, which takes longer to
 * find than the layer. */
static gp_status bound_fft(const struct gp_glare_request *req, void **state,
                           double *out)
{
    struct fft_state *s;
    double least;
    gp_status st = open_frame(req, state, &s);
    if (st)
        return st;
    const double anywhere = least_of(req, s);
    *out = bound_of(req, s, anywhere);
    if (*out <= (double) req->params->tolerance || req->kernel->negative)
        return GP_OK;
    st = gp_layer_least(req->log, req->src, req->kernel, &least);
    if (!st)
        *out = bound_of(req, s, fmax(least, anywhere));
    return st;
}

static gp_status pixel_fft(const struct gp_glare_request *req, void **state,
                           struct gp_pixel_error *out)
{
    struct fft_state *s;
    gp_status st = open_frame(req, state, &s);
    if (st)
        return st;
    *out = (struct gp_pixel_error) {
        .relative = req->kernel->over * OUTSIDE,
    };
    for (int c = 0; c < 3 && s->p.nx; c++)
        out->of[c] = noise_of(req, s, c) +
                     gp_fft_rounding(s->in_double) *
                         gp_fft_pixel_error(&s->p, req->src, &s->norms, c);
    return GP_OK;
}

static gp_status run_fft(const struct gp_glare_request *req, void **state)
{
    struct fft_state *s;
    double dropped = 0.0;
    const struct gp_sources *const src = req->src;
    gp_status st = open_frame(req, state, &s);
    if (st)
        return st;
    double least = least_of(req, s);
    if (!(req->stats->bound > 0.0))
        req->stats->bound = bound_of(req, s, least);
    if (s->p.nx)
        st = transform(req, s, &dropped);
    else
        gp_planes_clear(req->layer, 0, (size_t) src->w * (size_t) src->h);
    // (a bound may be known by the limit for these sources alone)
    if (!st && dropped > 0.0 && !(least > 0.0) && req->stats->bound < INFINITY)
        st = gp_layer_least(req->log, src, req->kernel, &least);
    req->stats->bound += dropped > 0.0 ? sqrt(dropped) / least : 0.0;
    req->stats->fft_w = s->p.nx;
    req->stats->fft_h = s->p.ny;
    req->stats->in_double = s->in_double;
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
