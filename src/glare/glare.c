// SPDX-License-Identifier: Apache-2.0
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"
#include "glare/model/model.h"
#include "glare/sky/sky.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* Limits of light and kernels within which no engine leaves the range of
 * float: its sums, transforms of 2^30 points among them, are under 2^127.
 * Larger values are halved until they fit, which is exact, and the layer is
 * doubled as often. */
static const double MOST = 0x1p80;

static int halvings(double sum)
{
    return sum > MOST ? ilogb(sum / MOST) + 1 : 0;
}

static double largest(const double v[3])
{
    return fmax(v[0], fmax(v[1], v[2]));
}

/* Makes a kernel whose samples are halved so often. Without a serial, so that
 * no engine keeps what it makes of it. */
static gp_status halve_kernel(const struct gp_log *log,
    const struct gp_kernel *k, int times, struct gp_kernel *out)
{
    const size_t n = (size_t) k->w * (size_t) k->h;
    *out = *k;
    out->k = (struct gp_planes) {0};
    out->far = NULL;
    out->sky = NULL; // the caller has it
    out->origin = NULL;
    out->serial = 0;
    gp_status st = gp_planes_make(log, "kernel", n, &out->k);
    for (int c = 0; !st && c < 3; c++) {
        out->sum[c] = ldexp(k->sum[c], -times);
        out->norm1[c] = ldexp(k->norm1[c], -times);
        out->norm2[c] = ldexp(k->norm2[c], -times);
        for (size_t i = 0; i < n; i++)
            out->k.c[c][i] = ldexpf(k->k.c[c][i], -times);
    }
    return st;
}

/* Doubles the layer. Samples that overflow are clamped to FLT_MAX; then a
 * warning is printed and the bound is INFINITY. */
static void double_layer(const struct gp_log *log, const char *path,
                         const struct gp_image *f, int times, double *bound)
{
    bool over = false;
    for (int c = 0; c < 3; c++) {
        float *const v = f->layer.c[c];
        for (size_t i = 0; i < gp_image_pixels(f); i++) {
            const float whole = ldexpf(v[i], times);
            v[i] = gp_maxf(gp_minf(whole, FLT_MAX), -FLT_MAX);
            over |= v[i] != whole;
        }
    }
    if (!over)
        return;
    *bound = INFINITY;
    gp_say_at(log, GP_LEVEL_WARN, "sense.max_value",
              "%s: the layer overflows and has no bound (limited to %.3g, "
              "the largest float); normalise the kernel",
              path, (double) FLT_MAX);
}

/* The whole of a kernel with a far field, kept in g. */
static gp_status find_whole(const struct gp_log *log, struct gp_glare *g,
    const struct gp_kernel *kernel, int w, int h, const struct gp_kernel **out)
{
    *out = &g->whole;
    if (kernel->serial && g->whole_of == kernel->serial && g->whole_w == w &&
        g->whole_h == h)
        return GP_OK;
    gp_kernel_free(&g->whole);
    g->whole_of = 0;
    gp_status st = gp_kernel_whole(log, kernel, w, h, &g->whole);
    if (st)
        return st;
    g->whole_of = kernel->serial;
    g->whole_w = w;
    g->whole_h = h;
    return GP_OK;
}

/* Warns where the sum is long and a transform would not be: on a farm a slow
 * choice should be known before the hour is spent. */
static void warn_of_hours(const struct gp_glare_request *req, const char *path)
{
    static const double LONG_S = 20.0;
    const double s = gp_sum_seconds(req);
    if (s > LONG_S)
        gp_say_at(req->log, GP_LEVEL_WARN, "sense.threshold",
                  "%s: engine direct will take about %.0f s for %zu sources",
                  path, s, req->src->n);
}

static int find_engine(const char *name)
{
    int i = 0;
    while (gp_engines[i] && strcmp(gp_engines[i]->name, name) != 0)
        i++;
    return gp_engines[i] ? i : -1;
}

/* A frame on its way to a layer. */
struct drawing {
    struct gp_glare *g;
    const struct gp_sources *src;   // as bright as the frame is
    const struct gp_kernel *kernel; // with its far field, if it has one
    const struct gp_kernel *drawn;  // that, or the whole of it
    bool core;                      // without its sky
    struct gp_image *f;
    const char *path;
    struct gp_sources less;         // halved, or empty
    struct gp_kernel small;
    int times;                      // that light and kernel were halved
    struct gp_beyond *beyond;
    struct gp_glare_request req;
};

/* Halves kernel and light until no engine leaves the range of float. */
static gp_status fit_range(const struct gp_log *log, struct drawing *d)
{
    gp_status st = GP_OK;
    // a kernel with a far field is a model's, of norm 1 at most
    const double norm = largest(d->kernel->norm1);
    const int of_kernel = d->kernel->far ? 0 : halvings(norm);
    const int of_light = halvings(
        largest(d->src->flux) * fmax(ldexp(norm, -of_kernel), 1.0));
    d->times = of_kernel + of_light;
    if (of_kernel) {
        st = halve_kernel(log, d->kernel, of_kernel, &d->small);
        d->req.kernel = &d->small;
    }
    if (of_light && !st) {
        st = gp_sources_scale(log, d->src, ldexp(1.0, -of_light), NULL,
                              &d->less);
        d->req.src = &d->less;
    }
    return st;
}

/* Chooses the engine, and finds what is guaranteed before it runs; `named` is
 * its number, or -1. */
static gp_status choose(const struct gp_log *log, int named, struct drawing *d,
                        struct gp_choice *out)
{
    gp_status st;
    struct gp_pixel_floor floor = {0};
    struct gp_glare_request *const req = &d->req;
    struct gp_glare *const g = d->g;
    *out = (struct gp_choice) {.engine = named,
                               .in_double = req->params->in_double};
    GP_TRY(gp_error_floor_find(req, &req->floor));
    if (req->params->tolerance_pixel > 0.0f) {
        struct gp_glare_request whole = *req; // as bright as the frame is
        whole.src = d->src;
        whole.kernel = d->kernel;
        GP_TRY(gp_pixel_floor_find(&whole, d->f, &floor));
        floor.times = d->times;
    }
    if (named < 0) {
        GP_TRY(gp_plan(req, g, d->path, &floor, out));
        req->stats->bound = out->bound;
    } else {
        if (req->params->tolerance_pixel > 0.0f)
            GP_TRY(gp_plan_pixel(req, g, named, &floor, &out->pixel));
        if (gp_engines[named] == &gp_engine_direct)
            warn_of_hours(req, d->path);
    }
    req->exact |= out->whole;
    if (out->whole && d->kernel->far) {
        GP_TRY(find_whole(log, g, d->kernel, d->src->w, d->src->h, &d->drawn));
        req->kernel = d->drawn;
        req->far = NULL;
    }
    req->in_double = out->in_double;
    req->stats->engine = gp_engines[out->engine]->name;
    req->stats->bound_pixel = out->pixel;
out:
    return st;
}

/* Adds true angles to the core, as they are defined. */
static gp_status add_exact(const struct gp_log *log, struct drawing *d)
{
    const struct gp_sources *const src = d->req.src;
    const size_t w = (size_t) src->w, h = (size_t) src->h;
    double *sum;
    gp_status st = gp_alloc_zero(log, "layer", 3 * w * h, sizeof *sum, &sum);
    if (st)
        return st;
    st = gp_sky_exact(log, d->kernel->sky, src, sum);
    for (size_t i = 0; i < 3 * h && !st; i++) {
        float *const to = d->f->layer.c[i / h] + i % h * w;
        for (size_t x = 0; x < w; x++)
            to[x] = (float) ((double) to[x] + sum[i * w + x]);
        gp_sky_cut_row(d->kernel->sky, (int) (i % h), (int) w, to);
    }
    gp_free(sum);
    return st;
}

/* Draws by true angles, with a kernel's core where that is more than what stays in
 * its pixel. */
static gp_status draw_sky(const struct gp_log *log,
                          const struct gp_choice *engine, struct drawing *d)
{
    const struct gp_glare_request *const req = &d->req;
    const struct gp_kernel *const k = req->kernel;
    const bool alone = k->w == 1 && k->h == 1 && k->cx == 0 && k->cy == 0;
    float stays[3] = {0};
    gp_status st = GP_OK;
    for (int c = 0; c < 3 && alone; c++)
        stays[c] = k->k.c[c][0];
    if (!alone || req->exact)
        st = gp_engines[engine->engine]->run(req, &d->g->state[engine->engine]);
    if (st || req->exact)
        return st ? st : add_exact(log, d);
    const struct gp_sky_facts *const sky = gp_sky_facts(d->kernel->sky);
    req->stats->bound_angle = sky->splines > 0.0 ? req->floor : sky->relative;
    req->stats->engine = sky->way;
    return gp_sky_add(log, k->sky,
                      &(struct gp_sky_drawing) {
                          .src = req->src,
                          .add = !alone,
                          .more = {stays[0], stays[1], stays[2]},
                          .layer = &d->f->layer,
                          .last = req->params->last,
                          .kept = &d->g->cosines,
                      });
}

/* Runs the engine, and adds the kernel's far field and light from beyond the
 * border. */
static gp_status draw(const struct gp_log *log, const struct gp_choice *engine,
                      struct drawing *d)
{
    gp_status st = GP_OK;
    struct gp_glare *const g = d->g;
    struct gp_glare_request *const req = &d->req;
    const int h = d->src->h;
    struct gp_far_rows *far = NULL;
    if (req->far)
        GP_TRY(gp_far_find(log, d->kernel->far, g->far, req->src, d->src->w, h,
                           &d->f->layer, &far));
    if (d->beyond)
        GP_TRY(gp_outside_find(log, d->drawn, d->drawn->far ? g->far : NULL,
                               d->beyond, &d->f->layer, &g->outside));
    if (d->kernel->sky && !d->core)
        GP_TRY(draw_sky(log, engine, d));
    else
        GP_TRY(gp_engines[engine->engine]->run(req, &g->state[engine->engine]));
    if (far)
        gp_parallel_do(3 * h, gp_far_add_row, far);
    // an engine's bound is that of its own sum
    if (!(engine->bound > 0.0))
        req->stats->bound += req->floor;
    if (d->times)
        double_layer(log, d->path, d->f, d->times, &req->stats->bound);
    if (d->beyond) // as bright as the frame
        gp_parallel_do(h, gp_beyond_add_row, g->outside);
out:
    gp_far_rows_free(&far);
    return st;
}

/* gp_glare_run() but for the margin. */
static gp_status run_picture(const struct gp_log *log,
                             const struct gp_glare_params *p,
                             struct gp_glare *g, const struct gp_sources *src,
                             const struct gp_kernel *kernel, bool core,
                             struct gp_image *f,
                             struct glarepp_layer_facts *stats)
{
    gp_status st = GP_OK;
    struct gp_choice taken;
    const int named = find_engine(p->engine);
    const struct gp_engine *const engine = named < 0 ? NULL : gp_engines[named];
    const bool direct = engine == &gp_engine_direct;
    struct drawing d = {
        .g = g,
        .src = src,
        .kernel = kernel,
        .drawn = kernel,
        .core = core,
        .f = f,
        .path = f->path ? f->path : "frame",
    };
    *stats = (struct glarepp_layer_facts) {0};
    if (named < 0 && strcmp(p->engine, "auto") != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: no engine of this name; use auto, direct, fft or "
                       "splat", p->engine);
    if (kernel->sky && engine == &gp_engine_splat)
        return gp_fail_at(log, GP_ERR_USAGE, "plan.projection",
                          "%s: engine splat draws one shape everywhere, and by "
                          "true angles it "
                          "differs from place to place",
                          d.path);
    if (!f->layer.c[0])
        st = gp_planes_make(log, "layer", gp_image_pixels(f), &f->layer);
    if (st)
        return st;
    if (!src->n) {
        gp_planes_clear(&f->layer, 0, gp_image_pixels(f));
        return GP_OK;
    }
    if (kernel->far && direct)
        GP_TRY(find_whole(log, g, kernel, src->w, src->h, &d.drawn));
    else if (kernel->far)
        GP_TRY(gp_far_open(log, kernel->far, &g->far));
    d.req = (struct gp_glare_request) {
        .log = log,
        .params = p,
        .src = src,
        .kernel = d.drawn,
        .far = d.drawn->far ? g->far : NULL,
        .layer = &f->layer,
        .stats = stats,
        .exact = kernel->sky && direct,
    };
    GP_TRY(fit_range(log, &d));
    GP_TRY(gp_beyond_find(log, &p->edges, &d.beyond));
    d.req.beyond = d.beyond ? d.beyond->most : 0.0;
    GP_TRY(choose(log, named, &d, &taken));
    GP_TRY(draw(log, &taken, &d));
out:
    gp_beyond_free(&d.beyond);
    gp_sources_free(&d.less);
    gp_kernel_free(&d.small);
    return st;
}

gp_status gp_glare_run(const struct gp_log *log,
    const struct gp_glare_params *p, struct gp_glare *g,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    struct gp_image *f, struct glarepp_layer_facts *stats)
{
    gp_status st;
    const struct gp_margin margin =
        gp_margin_of(&p->edges, kernel, src->w, src->h);
    if (!margin.x || !src->n)
        return run_picture(log, p, g, src, kernel, false, f, stats);
    struct gp_mirrored m = {0};
    struct gp_glare_params params = *p;
    struct gp_image wide = {.path = f->path};
    struct gp_sources taken = {0};
    const size_t w = (size_t) src->w, h = (size_t) src->h;
    const bool pixel = p->tolerance_pixel > 0.0f;
    memcpy(wide.luminance, f->luminance, sizeof wide.luminance);
    GP_TRY(gp_mirror(log, &p->edges, src, pixel ? &f->rgb : NULL, &margin, &m));
    wide.data = (struct gp_rect) {0, 0, m.src.w, m.src.h};
    wide.rgb = m.rgb;
    params.edges = m.edges;
    // what scatters is the picture, for which the edges are made, or a part of it
    if (p->taken && p->taken != p->edges.picture) {
        GP_TRY(gp_mirror_sources(log, p->taken, &margin, &taken));
        params.taken = &taken;
    } else if (p->taken) {
        params.taken = m.edges.picture;
    }
    GP_TRY(run_picture(log, &params, g, &m.src, kernel, margin.turn > 0, &wide,
                       stats));
    if (!f->layer.c[0])
        GP_TRY(gp_planes_make(log, "layer", gp_image_pixels(f), &f->layer));
    for (size_t i = 0; i < 3 * h; i++) // without the margin
        memcpy(f->layer.c[i / h] + i % h * w,
               gp_row(wide.layer.c[i / h], m.src.w, margin.y + (int) (i % h)) +
                   margin.x,
               w * sizeof(float));
    if (kernel->sky && margin.turn) // which knows of the other side
        GP_TRY(gp_sky_add(log, kernel->sky,
                          &(struct gp_sky_drawing) {.src = src,
                                                    .add = true,
                                                    .layer = &f->layer,
                                                    .last = p->last,
                                                    .kept = &g->cosines}));
out:
    gp_planes_free(&wide.layer);
    gp_sources_free(&taken);
    gp_mirrored_free(&m);
    return st;
}

void gp_glare_close(struct gp_glare *g)
{
    for (int i = 0; gp_engines[i]; i++) {
        if (g->state[i])
            gp_engines[i]->close(&g->state[i]);
    }
    gp_outside_free(&g->outside);
    gp_far_close(&g->far);
    gp_cosines_kept_free(&g->cosines);
    gp_kernel_free(&g->whole);
    g->whole_of = 0;
}

// -- a kernel spread over a disc: the layer of a frame that is the disc -------

gp_status gp_kernel_spread(const struct gp_log *log, const struct gp_kernel *k,
    int reach, const float *weight, struct gp_spread_kernel *out)
{
    gp_status st;
    const int w = k->w + 2 * reach, h = k->h + 2 * reach;
    const int side = 2 * reach + 1;
    const struct gp_sources frame = {
        .w = w, .h = h, .luminance = {0.3f, 0.6f, 0.1f},
    };
    struct gp_image f = {.data = {0, 0, w, h}, .display = {0, 0, w, h}};
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare engines = {0};
    struct glarepp_layer_facts stats;
    struct gp_sources disc = {0};
    struct gp_kernel core = *k;
    core.far = NULL; // it has a sprite of its own
    core.sky = NULL; // it has none, and is asked for on a plane
    p.engine = reach > 3 ? "fft" : "direct";
    GP_TRY(gp_sources_make(log, &frame, (size_t) side * (size_t) side, &disc));
    // the kernel's centre may lie outside it, and pixels of the disc with it
    for (int i = 0; i < side * side; i++) {
        const int x = k->cx + i % side, y = k->cy + i / side;
        const float rgb[3] = {weight[i], weight[i], weight[i]};
        if (x >= 0 && x < w && y >= 0 && y < h)
            gp_sources_add(&disc, x, y, rgb);
    }
    gp_sources_finish(&disc);
    GP_TRY(gp_glare_run(log, &p, &engines, &disc, &core, &f, &stats));
    *out = (struct gp_spread_kernel) {
        .w = w, .h = h, .cx = k->cx + reach + 0.5, .cy = k->cy + reach + 0.5,
        .k = f.layer, .step = 1,
    };
    f.layer = (struct gp_planes) {0};
out:
    gp_glare_close(&engines);
    gp_sources_free(&disc);
    gp_planes_free(&f.layer);
    return st;
}

// -- the layer's colour --------------------------------------------------------

struct tinting {
    const struct gp_tint_params *p;
    struct gp_image *f;
    double low;
};

/* In double, where no luminance overflows, and white stays as it is. */
GP_CLONES static void tint_row(void *ctx, int y, GP_UNUSED int thread)
{
    const struct tinting *const m = ctx;
    const size_t w = (size_t) gp_image_w(m->f), at = (size_t) y * w;
    const float *const weight = m->f->luminance;
    const double s = (double) m->p->saturation;
    float *const v[3] = {m->f->layer.c[0] + at, m->f->layer.c[1] + at,
                         m->f->layer.c[2] + at};
    for (size_t x = 0; x < w; x++) {
        const double grey = (1.0 - s) * ((double) weight[0] * (double) v[0][x] +
                                         (double) weight[1] * (double) v[1][x] +
                                         (double) weight[2] * (double) v[2][x]);
        for (int c = 0; c < 3; c++)
            v[c][x] = (float) gp_mind(
                gp_maxd((double) m->p->tint[c] * (grey + s * (double) v[c][x]),
                        m->low),
                (double) FLT_MAX);
    }
}

void gp_layer_tint(const struct gp_tint_params *p, bool part,
                   struct gp_image *f)
{
    struct tinting m = {p, f, part ? -(double) FLT_MAX : 0.0};
    if (f->layer.c[0])
        gp_parallel_do(gp_image_h(f), tint_row, &m);
}

// -- adding the layer to the frame --------------------------------------------
//
// Rows share nothing, so the result is the same for any number of threads.

struct composing {
    struct gp_image *f;
    const struct gp_sources *src;
    const struct gp_planes *layer;
    float *line;  // of each thread, a row: f->lit is the layer; else NULL
    float gain;
    float taken;  // share of a source's light that leaves its pixel
    float keep;   // share that the pupil lets through
    atomic_llong over; // samples clamped
};

/* Clamps infinite light to the largest float. */
static inline __attribute__((always_inline)) float kept_finite(float v)
{
    return gp_maxf(gp_minf(v, FLT_MAX), -FLT_MAX);
}

GP_CLONES static void add_row(const float *in, const float *layer, float gain,
                              size_t n, float *restrict out)
{
    for (size_t i = 0; i < n; i++)
        out[i] = kept_finite(in[i] + gain * layer[i]);
}

/* Counts the samples of a row that kept_finite() changed. */
GP_CLONES static int count_over(const float *in, const float *out, size_t n)
{
    int over = 0;
    for (size_t i = 0; i < n; i++)
        over += (fabsf(out[i]) >= FLT_MAX) & (fabsf(in[i]) < FLT_MAX);
    return over;
}

/* One row: in + gain * layer, less what sources scatter, dimmed. */
static void compose_row(void *ctx, int y, int thread)
{
    struct composing *m = ctx;
    const struct gp_image *f = m->f;
    const size_t w = (size_t) gp_image_w(f);
    const size_t at = (size_t) y * w;
    for (int c = 0; c < 3; c++) {
        const float *in = f->rgb.c[c] + at;
        float *out = f->lit.c[c] + at;
        const float *layer = m->layer->c[c] ? m->layer->c[c] + at : NULL;
        if (m->line)
            layer = memcpy(m->line + (size_t) thread * w, out,
                           w * sizeof *out);
        if (layer)
            add_row(in, layer, m->gain, w, out);
        else
            memcpy(out, in, w * sizeof *out);
        // the sources' pixels once more, with their own light taken away first:
        // where gain is 1 and the source is the whole pixel nothing of it is
        // left, whatever the rounding of in + gain * layer was
        if (layer && m->taken > 0.0f) {
            const struct gp_sources *const src = m->src;
            for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
                const int32_t x = src->x[i];
                out[x] = kept_finite((in[x] - m->taken * src->rgb[c][i]) +
                                m->gain * layer[x]);
            }
        }
        const int over = count_over(in, out, w);
        if (over)
            atomic_fetch_add(&m->over, over);
        for (size_t x = 0; m->keep < 1.0f && x < w; x++)
            out[x] *= m->keep;
    }
}

gp_status gp_compose(const struct gp_log *log,
                     const struct gp_compose_params *p,
                     const struct gp_sources *src, struct gp_image *f)
{
    gp_status st = GP_OK;
    struct composing m = {
        .f = f, .src = src, .layer = &f->layer, .gain = p->gain,
        .keep = 1.0f - p->dim,
        .taken = p->mix == GLAREPP_SCATTER && src->n > 0
                     ? gp_minf(p->gain, 1.0f) : 0.0f,
    };
    const size_t w = (size_t) gp_image_w(f);
    if (!f->lit.c[0] && p->last && f->layer.c[0]) {
        st = gp_alloc(log, "lit row", (size_t) gp_threads() * w,
                      sizeof *m.line, &m.line);
        if (!st) {
            f->lit = f->layer;
            f->layer = (struct gp_planes) {{NULL, NULL, NULL}};
            m.layer = &f->lit;
        }
    } else if (!f->lit.c[0]) {
        st = gp_planes_make(log, "lit frame", gp_image_pixels(f), &f->lit);
    }
    if (st)
        return st;
    gp_parallel_do(gp_image_h(f), compose_row, &m);
    gp_free(m.line);
    const long long over = atomic_load(&m.over);
    if (over)
        gp_say_at(log, GP_LEVEL_WARN, "layer.gain", "%s: %lld samples overflow "
                  "with their glare (limited to %.3g, the largest float)",
                  f->path, over, (double) FLT_MAX);
    return GP_OK;
}
