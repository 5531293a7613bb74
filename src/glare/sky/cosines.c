// SPDX-License-Identifier: Apache-2.0
/* Direction cosines: their nodes, and the layer by way of these. */
#include "glare/sky/cosines.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/engine.h"
#include "glare/far_field/far_field.h"

#include <float.h>
#include <math.h>
#include <string.h>

// -- nodes ---------------------------------------------------------------------

/* Direction cosines of places between two corners. */
struct box {
    double low[2], high[2];
};

enum { TAPS = 8 }; // nodes that a spline meets

/* The nodes around cosines from low to high: n from `first` on, in steps. */
struct span {
    int first, n;
};
static struct span span_of(double low, double high, double step)
{
    const int beyond = TAPS / 2;
    const int first = (int) floor(low / step) + 1 - beyond;
    return (struct span) {first, (int) floor(high / step) + beyond + 1 - first};
}

/* B at the nodes three before to four after t in [0, 1): de Boor's recursion. */
static inline void spline_at(double t, double b[TAPS])
{
    b[0] = 1.0;
    for (int degree = 1; degree < TAPS; degree++) {
        double saved = 0.0;
        for (int i = 0; i < degree; i++) {
            const double part = b[i] / degree;
            b[i] = saved + part * (i + 1 - t);
            saved = part * (t + degree - 1 - i);
        }
        b[degree] = saved;
    }
}

static struct box box_of(const struct gp_projection *p, const double from[2],
                         const double to[2])
{
    struct box b = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    // a cosine grows along its axis, and is largest where the other's place is
    // nearest to the pupil's normal, or farthest
    const double x[3] = {from[0], to[0], fmin(fmax(p->x0, from[0]), to[0])};
    const double y[3] = {from[1], to[1], fmin(fmax(p->y0, from[1]), to[1])};
    for (int i = 0; i < 9; i++) {
        const struct gp_v3 d = gp_projection_direction(p, x[i % 3], y[i / 3]);
        b.low[0] = fmin(b.low[0], d.x);
        b.low[1] = fmin(b.low[1], d.y);
        b.high[0] = fmax(b.high[0], d.x);
        b.high[1] = fmax(b.high[1], d.y);
    }
    return b;
}

bool gp_cosine_grid_lay(const struct gp_projection *p, int w, int h,
                        double finest, struct gp_cosine_grid *out)
{
    // of splines' error: see `wrong`; and of periods that are finest
    static const double DENSE = 2.75, LOOSE = 1.25, PERIOD = 2.3;
    static const double MOST = 8.0 * M_PI / 180.0;
    const double from[2] = {-0.5, -0.5}, to[2] = {w - 0.5, h - 0.5};
    const double pixel = fmax(p->dx, p->dy);
    if (p->kind != GP_PERSPECTIVE || !(pixel <= MOST))
        return false;
    const struct box b = box_of(p, from, to);
    *out = (struct gp_cosine_grid) {
        .projection = *p,
        .w = w,
        .h = h,
        .nodes = fmin(fmax(PERIOD * finest * pixel, LOOSE), DENSE),
    };
    for (int i = 0; i < 2; i++) {
        out->step[i] = (i ? p->dy : p->dx) / out->nodes;
        out->size[i] = span_of(b.low[i], b.high[i], out->step[i]).n;
    }
    return true;
}

// -- their kernel --------------------------------------------------------------------

void gp_cosines_at(const struct gp_kernel *k, double u, double v, double d[3])
{
    enum { MID = TAPS / 2 - 1, WIDE = 4 * MID + 2 };
    const int x = (int) floor(u) + k->cx, y = (int) floor(v) + k->cy;
    double own[TAPS], at[2][TAPS], both[2][WIDE] = {{0}};
    spline_at(0.0, own);
    spline_at(u - floor(u), at[0]);
    spline_at(v - floor(v), at[1]);
    for (int i = 0; i < 2 * TAPS * (2 * MID + 1); i++) {
        const int a = i / 2 % TAPS, b = i / 2 / TAPS;
        both[i % 2][a + b] += at[i % 2][a] * own[b];
    }
    for (int c = 0; c < 3; c++) {
        d[c] = 0.0;
        for (int i = 0; i < WIDE * WIDE; i++)
            d[c] += both[0][i % WIDE] * both[1][i / WIDE] *
                    (double) gp_planes_at(&k->k, c, k->w, k->h,
                                          x - 2 * MID + i % WIDE,
                                          y - 2 * MID + i / WIDE);
    }
}

// -- the layer: light to the nodes, spread there, and back ------------------------

struct gp_cosines_kept {
    void *fft;
    struct gp_far_state *far;
};

void gp_cosines_kept_free(struct gp_cosines_kept **kept)
{
    if (*kept && (*kept)->fft)
        gp_engine_fft.close(&(*kept)->fft);
    if (*kept)
        gp_far_close(&(*kept)->far);
    GP_FREE(*kept);
}

/* A source among the cosines, in steps, and its light times area over a node's. */
struct point {
    double at[2];
    float light[3];
};

/* A picture on its way to nodes and back. */
struct adding {
    const struct gp_cosines *c;
    struct point *point; // owned
    size_t n;
    double x0, y0; // place of the picture's corner
    int w, h;      // of it, pixels
    int halved;    // times that points' light is halved: 1 is the brightest
    struct span all[2];      // nodes of picture and sources
    struct span lit[2];      // of sources
    float *light[3];         // lit[0].n * lit[1].n; owned
    struct gp_planes spread; // all[0].n * all[1].n; owned
    struct gp_planes *layer; // of the picture: in float, or ...
    double *sum;             // ... in double, with ...
    float *core[3];          // ... coefficients of D; owned
};

// -- pixels and nodes ------------------------------------------------------------

/* A place among nodes: the first of those around it, and their splines. */
struct taps {
    size_t node;
    float at[2][TAPS];
};

/* Finds those of a place, in steps, among rows of `wide` nodes from (x, y) on. */
static inline struct taps taps_of(const double at[2], int x, int y, size_t wide)
{
    const int first[2] = {x, y};
    struct taps t;
    size_t node[2];
    for (int i = 0; i < 2; i++) {
        const double down = floor(at[i]);
        double b[TAPS];
        node[i] = (size_t) ((int) down - first[i] + 1 - TAPS / 2);
        spline_at(at[i] - down, b);
        for (int k = 0; k < TAPS; k++)
            t.at[i][k] = (float) b[k];
    }
    t.node = node[1] * wide + node[0];
    return t;
}

/* The sum of a plane's nodes around a place. */
static inline float sum_taps(const struct taps *t, const float *plane,
                             size_t wide)
{
    float sum = 0.0f;
    for (size_t j = 0; j < TAPS; j++) {
        const float *const row = plane + t->node + j * wide;
        float along = 0.0f;
        for (size_t i = 0; i < TAPS; i++)
            along += t->at[0][i] * row[i];
        sum += t->at[1][j] * along;
    }
    return sum;
}

/* The cosines of a place, in steps. */
static inline void place_of(const struct gp_cosine_grid *g, double x, double y,
                            double at[2])
{
    const struct gp_v3 d = gp_projection_direction(&g->projection, x, y);
    at[0] = d.x / g->step[0];
    at[1] = d.y / g->step[1];
}

/* Lays light on the nodes, one channel. */
GP_CLONES static void lay_channel(void *ctx, int c, GP_UNUSED int thread)
{
    const struct adding *const a = ctx;
    const size_t wide = (size_t) a->lit[0].n;
    for (size_t i = 0; i < a->n; i++) {
        const struct point *const p = &a->point[i];
        const struct taps t =
            taps_of(p->at, a->lit[0].first, a->lit[1].first, wide);
        for (size_t j = 0; j < TAPS; j++) {
            const float light = p->light[c] * t.at[1][j];
            float *const to = a->light[c] + t.node + j * wide;
            for (size_t k = 0; k < TAPS; k++)
                to[k] += light * t.at[0][k];
        }
    }
}

/* Adds pairs of a place and points, all of the core, to sum. */
static void add_pairs(const struct adding *a, const double at[2], double sum[3])
{
    const struct gp_kernel *const k = &a->c->nodes;
    for (size_t i = 0; i < a->n; i++) {
        const struct point *const p = &a->point[i];
        // among samples; beyond them there is nothing
        const double apart[2] = {at[0] - p->at[0] + k->cx,
                                 at[1] - p->at[1] + k->cy};
        if (!(apart[0] > -TAPS / 2 && apart[0] < k->w + TAPS / 2 &&
              apart[1] > -TAPS / 2 && apart[1] < k->h + TAPS / 2))
            continue;
        const size_t wide = (size_t) k->w + 2 * TAPS;
        const struct taps t = taps_of(apart, -TAPS, -TAPS, wide);
        for (int c = 0; c < 3; c++)
            sum[c] +=
                (double) p->light[c] * (double) sum_taps(&t, a->core[c], wide);
    }
}

/* Adds a row of the picture. */
GP_CLONES static void add_row(void *ctx, int y, GP_UNUSED int thread)
{
    const struct adding *const a = ctx;
    const size_t wide = (size_t) a->all[0].n, w = (size_t) a->w;
    for (int x = 0; x < a->w; x++) {
        const size_t i = (size_t) y * w + (size_t) x;
        double at[2], sum[3] = {0};
        if (a->sum && isnan(a->sum[i]))
            continue;
        place_of(&a->c->grid, x + a->x0, y + a->y0, at);
        if (a->spread.c[0]) {
            const struct taps t =
                taps_of(at, a->all[0].first, a->all[1].first, wide);
            for (int c = 0; c < 3; c++)
                sum[c] = (double) sum_taps(&t, a->spread.c[c], wide);
        }
        if (a->sum)
            add_pairs(a, at, sum);
        for (int c = 0; c < 3; c++) {
            // D rings a little where it is cut off
            const double v = fmax(ldexp(sum[c], a->halved), 0.0);
            if (a->sum)
                a->sum[(size_t) c * w * (size_t) a->h + i] += v;
            else
                a->layer->c[c][i] = (float) fmin((double) a->layer->c[c][i] + v,
                                                 (double) FLT_MAX);
        }
    }
}

// -- sources ---------------------------------------------------------------------

/* Tests whether a place's light reaches the picture; and where there is a far field,
 * whether that serves both. */
static bool is_reached(const struct gp_cosines *c, const double at[2],
                       const struct box *picture)
{
    const struct gp_kernel *const k = &c->nodes;
    bool reached = true;
    for (int i = 0; i < 2; i++) {
        const double step = c->grid.step[i], u = at[i] * step;
        const double low = picture->low[i], high = picture->high[i];
        const double core = ((i ? k->h : k->w) / 2 + TAPS) * step;
        const struct span all = span_of(fmin(low, u), fmax(high, u), step);
        reached &= k->far ? all.n <= (i ? k->far->h : k->far->w)
                          : u > low - core && u < high + core;
    }
    return reached;
}

/* Finds points, and the nodes of them and the picture, as far as the kernel reaches;
 * those beyond are left out. */
static gp_status find_points(const struct gp_log *log,
                             const struct gp_source *source, size_t n,
                             struct adding *a)
{
    const struct gp_cosine_grid *const g = &a->c->grid;
    const struct gp_projection *const p = &g->projection;
    const double from[2] = {a->x0 - 0.5, a->y0 - 0.5};
    const double to[2] = {from[0] + a->w, from[1] + a->h};
    const struct box picture = box_of(p, from, to);
    struct box lit = {{1.0, 1.0}, {-1.0, -1.0}};
    gp_status st = gp_alloc(log, "layer", n, sizeof *a->point, &a->point);
    float most = 0.0f;
    if (st)
        return st;
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < 3; c++)
            most = gp_maxf(most, source[i].rgb[c]);
    a->halved = most > 0.0f ? ilogbf(most) : 0;
    for (size_t i = 0; i < n && most > 0.0f; i++) {
        const struct gp_source *const s = &source[i];
        const double x = s->x + a->x0, y = s->y + a->y0;
        struct point *const to_point = &a->point[a->n];
        place_of(g, x, y, to_point->at);
        if (!is_reached(a->c, to_point->at, &picture))
            continue;
        const double area = gp_projection_solid(p, x, y) *
                            gp_projection_direction(p, x, y).z /
                            (g->step[0] * g->step[1]);
        for (int c = 0; c < 3; c++)
            to_point->light[c] =
                (float) (area * ldexp((double) s->rgb[c], -a->halved));
        for (int k = 0; k < 2; k++) {
            const double u = to_point->at[k] * g->step[k];
            lit.low[k] = fmin(lit.low[k], u);
            lit.high[k] = fmax(lit.high[k], u);
        }
        a->n++;
    }
    for (int k = 0; k < 2; k++) {
        a->lit[k] = span_of(lit.low[k], lit.high[k], g->step[k]);
        a->all[k] = span_of(fmin(picture.low[k], lit.low[k]),
                            fmax(picture.high[k], lit.high[k]), g->step[k]);
    }
    return st;
}

/* Makes nodes that have light sources of their own. */
static gp_status make_sources(const struct gp_log *log, struct adding *a,
                              struct gp_sources *out)
{
    const size_t n = (size_t) a->lit[0].n * (size_t) a->lit[1].n;
    const struct gp_sources like = {
        .w = a->all[0].n,
        .h = a->all[1].n,
        .luminance = {a->c->weight[0], a->c->weight[1], a->c->weight[2]}};
    size_t room = 0;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "layer", 3 * n, sizeof(float), &a->light[0]));
    a->light[1] = a->light[0] + n;
    a->light[2] = a->light[1] + n;
    gp_parallel_do(3, lay_channel, a);
    for (size_t i = 0; i < n; i++)
        room += a->light[0][i] + a->light[1][i] + a->light[2][i] > 0.0f;
    GP_TRY(gp_sources_make(log, &like, room, out));
    for (size_t i = 0; i < n; i++) {
        const float rgb[3] = {a->light[0][i], a->light[1][i], a->light[2][i]};
        const int x = (int) (i % (size_t) a->lit[0].n) + a->lit[0].first;
        const int y = (int) (i / (size_t) a->lit[0].n) + a->lit[1].first;
        if (rgb[0] + rgb[1] + rgb[2] > 0.0f)
            gp_sources_add(out, x - a->all[0].first, y - a->all[1].first, rgb);
    }
    gp_sources_finish(out);
out:
    GP_FREE(a->light[0]);
    return st;
}

// -- all of it -------------------------------------------------------------------

/* The far field's rows; nodes may be negative. */
struct far {
    struct gp_far_rows *rows;
    struct gp_planes *to;
    float *line; // of each thread
    int w, h;
};

static void add_far_row(void *ctx, int i, int thread)
{
    const struct far *const f = ctx;
    const int c = i / f->h, y = i % f->h;
    float *const line = f->line + (size_t) thread * (size_t) f->w;
    float *const to = f->to->c[c] + (size_t) y * (size_t) f->w;
    gp_far_row(f->rows, c, y, thread, line);
    for (int x = 0; x < f->w; x++)
        to[x] += line[x];
}

/* Spreads light on the nodes: by a transform, and the far field's; `only_far`: that
 * alone. */
static gp_status spread(const struct gp_log *log, struct adding *a,
                        bool only_far, bool last, struct gp_cosines_kept *kept)
{
    const struct gp_kernel *const k = &a->c->nodes;
    struct glarepp_layer_facts facts = {.bound = 1.0}; // not asked for
    struct gp_glare_params params = GP_GLARE_DEFAULTS;
    struct far far = {.to = &a->spread, .w = a->all[0].n, .h = a->all[1].n};
    struct gp_sources src = {0};
    const size_t n = (size_t) far.w * (size_t) far.h;
    gp_status st;
    params.last = last;
    GP_TRY(make_sources(log, a, &src));
    GP_TRY(gp_planes_make(log, "layer", n, &a->spread));
    if (k->far) {
        GP_TRY(gp_far_open(log, k->far, &kept->far));
        GP_TRY(gp_far_find(log, k->far, kept->far, &src, far.w, far.h,
                           &a->spread, &far.rows));
        GP_TRY(gp_alloc(log, "layer", (size_t) gp_threads() * (size_t) far.w,
                        sizeof *far.line, &far.line));
    }
    if (only_far)
        gp_planes_clear(&a->spread, 0, n);
    else
        GP_TRY(
            gp_engine_fft.run(&(struct gp_glare_request) {.log = log,
                                                          .params = &params,
                                                          .src = &src,
                                                          .kernel = k,
                                                          .layer = &a->spread,
                                                          .stats = &facts,
                                                          .far = kept->far},
                              &kept->fft));
    if (k->far)
        gp_parallel_do(3 * far.h, add_far_row, &far);
out:
    gp_far_rows_free(&far.rows);
    gp_free(far.line);
    gp_sources_free(&src);
    return st;
}

gp_status gp_cosines_add(const struct gp_log *log, const struct gp_cosines *c,
                         const struct gp_source *source, size_t n,
                         struct gp_rect picture, struct gp_planes *layer,
                         bool last, struct gp_cosines_kept **kept)
{
    const int w = gp_rect_w(picture), h = gp_rect_h(picture);
    struct adding a = {.c = c,
                       .x0 = 0.5 * (c->grid.w - w),
                       .y0 = 0.5 * (c->grid.h - h),
                       .w = w,
                       .h = h,
                       .layer = layer};
    gp_status st;
    GP_TRY(find_points(log, source, n, &a));
    if (!*kept)
        GP_TRY(gp_alloc_zero(log, "layer", 1, sizeof **kept, kept));
    if (a.n) {
        GP_TRY(spread(log, &a, false, last, *kept));
        gp_parallel_do(h, add_row, &a);
    }
out:
    gp_planes_free(&a.spread);
    gp_free(a.point);
    return st;
}

gp_status gp_cosines_beyond(const struct gp_log *log,
                            const struct gp_cosines *c, int w, int h,
                            struct gp_planes *share)
{
    const size_t wide = (size_t) w, n = wide * (size_t) h;
    struct gp_cosines_kept *kept = NULL;
    struct gp_source *even;
    gp_status st = gp_alloc(log, "edges", n, sizeof *even, &even);
    if (st)
        return st;
    for (size_t i = 0; i < n; i++)
        even[i] = (struct gp_source) {
            (int) (i % wide), (int) (i / wide), {1.0f, 1.0f, 1.0f}};
    gp_planes_clear(share, 0, n);
    st = gp_cosines_add(log, c, even, n, (struct gp_rect) {0, 0, w, h}, share,
                        true, &kept);
    for (int k = 0; k < 3; k++)
        for (size_t i = 0; i < n; i++)
            share->c[k][i] = (float) (c->light[k] - (double) share->c[k][i]);
    gp_cosines_kept_free(&kept);
    gp_free(even);
    return st;
}

/* Finds the coefficients of D, TAPS of zeros around them: K times B's own samples. */
static gp_status find_core(const struct gp_log *log, struct adding *a)
{
    enum { MID = TAPS / 2 - 1, OWN = 2 * MID + 1 };
    const struct gp_kernel *const k = &a->c->nodes;
    const size_t wide = (size_t) k->w + 2 * TAPS;
    const size_t n = wide * ((size_t) k->h + 2 * TAPS);
    double own[TAPS];
    gp_status st =
        gp_alloc_zero(log, "exact layer", 3 * n, sizeof(float), &a->core[0]);
    spline_at(0.0, own);
    for (size_t c = 0; c < 3 && !st; c++) {
        a->core[c] = a->core[0] + c * n;
        for (int y = -MID; y < k->h + MID; y++) {
            for (int x = -MID; x < k->w + MID; x++) {
                double sum = 0.0;
                for (int i = 0; i < OWN * OWN; i++)
                    sum += own[i % OWN] * own[i / OWN] *
                           (double) gp_planes_at(&k->k, (int) c, k->w, k->h,
                                                 x + i % OWN - MID,
                                                 y + i / OWN - MID);
                a->core[c][(size_t) (y + TAPS) * wide + (size_t) (x + TAPS)] =
                    (float) sum;
            }
        }
    }
    return st;
}

gp_status gp_cosines_exact(const struct gp_log *log, const struct gp_cosines *c,
                           const struct gp_source *source, size_t n,
                           double *layer)
{
    struct adding a = {.c = c, .w = c->grid.w, .h = c->grid.h, .sum = layer};
    struct gp_cosines_kept *kept = NULL;
    gp_status st;
    GP_TRY(find_points(log, source, n, &a));
    GP_TRY(gp_alloc_zero(log, "exact layer", 1, sizeof *kept, &kept));
    if (a.n && c->nodes.far)
        GP_TRY(spread(log, &a, true, true, kept));
    if (a.n) {
        GP_TRY(find_core(log, &a));
        gp_parallel_do(a.h, add_row, &a);
    }
out:
    gp_cosines_kept_free(&kept);
    gp_planes_free(&a.spread);
    gp_free(a.core[0]);
    gp_free(a.point);
    return st;
}
