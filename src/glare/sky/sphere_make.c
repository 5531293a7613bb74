// SPDX-License-Identifier: Apache-2.0
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sphere.h"

#include <math.h>
#include <string.h>

enum { LINES = GP_FLOAT_LINES };

static double side_of(const struct gp_sky *s)
{
    return fmax(s->p.projection.dx, s->p.projection.dy);
}

static double scale_of(const struct gp_sky *s, int l)
{
    const double a = s->ratio * ldexp(side_of(s), l);
    return a * a;
}

// -- means ----------------------------------------------------------------------

/* The mean of P over two pixels, however near. */
static double mean_of(const struct gp_sky *s, double chord2, const double at[2],
                      const double from[2])
{
    const double away = sqrt(chord2) / side_of(s);
    return away < 2.0 ? gp_sky_close_mean(&s->light, &s->p.projection, at, from)
                      : gp_sky_mean(&s->light, &s->p.projection, 0.0, 0.0,
                                    gp_sky_order(away), at, from);
}

static double soft_mean(const struct gp_sky *s, const double at[2],
                        const double from[2])
{
    return gp_sky_mean(&s->light, &s->p.projection, scale_of(s, 1), 0.0, 2, at,
                       from);
}

/* Tests whether the first term of two pixels has ended. */
static bool is_over(const struct gp_sky *s, double chord2)
{
    return chord2 > scale_of(s, 1) * (1.0 + 2.0 / s->ratio);
}

/* The first term of two pixels; 0 of one with itself. */
static double first_term(const struct gp_sky *s, const double at[2],
                         const double from[2])
{
    const double c =
        gp_projection_chord2(&s->p.projection, at[0], at[1], from[0], from[1]);
    const bool along = at[1] == from[1];
    if (is_over(s, c) || (along && at[0] == from[0]))
        return 0.0;
    return (along ? s->sphere->even[(int) at[1]] : 1.0) *
           (mean_of(s, c, at, from) - soft_mean(s, at, from));
}

double gp_sky_sphere_mean(const struct gp_sky *s, const double at[2],
                          const double from[2])
{
    const double c =
        gp_projection_chord2(&s->p.projection, at[0], at[1], from[0], from[1]);
    return is_over(s, c) ? mean_of(s, c, at, from)
                         : soft_mean(s, at, from) + first_term(s, at, from);
}

// -- the first term -----------------------------------------------------------------

/* First terms of rows `row` of the upper half and `row` + `down`, 0 .. near, of pixels
 * 0 .. reach columns apart. */
struct terms {
    const struct gp_sky *s;
    struct gp_sky_arc *pair; // [row][down]; owned
    float *v;                // owned
};

/* Returns a pair's terms; `*reach` is -1 where there are none. */
static const float *terms_of(const struct terms *t, int row, int down,
                             int *reach)
{
    const struct gp_sky_arc *const p =
        &t->pair[row * (t->s->sphere->near + 1) + down];
    *reach = p->reach;
    return t->v + p->at;
}

/* Finds how far the first term reaches along a row. */
static int reach_of(const struct gp_sky *s, int row, int from)
{
    int reach = -1;
    while (2 * (reach + 1) <= s->sphere->w &&
           !is_over(s, gp_projection_chord2(&s->p.projection, 0.0, row,
                                            reach + 1.0, from)))
        reach++;
    return reach;
}

static void find_terms(void *ctx, int i, int thread)
{
    const struct terms *const t = ctx;
    const int side = t->s->sphere->near + 1;
    const double at[2] = {0.0, i / side};
    (void) thread;
    for (int x = 0; x <= t->pair[i].reach; x++)
        t->v[t->pair[i].at + (size_t) x] = (float) first_term(
            t->s, at, (const double[2]) {x, i / side + i % side});
}

static gp_status make_terms(const struct gp_log *log, const struct gp_sky *s,
                            struct terms *t)
{
    const struct gp_sky_sphere *const o = s->sphere;
    const int side = o->near + 1, pairs = (o->h + 1) / 2 * side;
    size_t count = 0;
    t->s = s;
    gp_status st =
        gp_alloc(log, "kernel", (size_t) pairs, sizeof *t->pair, &t->pair);
    for (int i = 0; i < pairs && !st; i++) {
        const int row = i / side, y = row + i % side;
        t->pair[i] =
            (struct gp_sky_arc) {y < o->h ? reach_of(s, row, y) : -1, count};
        count += (size_t) (t->pair[i].reach + 1);
    }
    if (!st)
        st = gp_alloc(log, "kernel", count, sizeof *t->v, &t->v);
    if (!st)
        gp_parallel_do(pairs, find_terms, t);
    return st;
}

/* The light of the first term: what P has within its end, less the next level's. */
static double first_light(const struct gp_sky *s)
{
    const struct gp_gauss *const g = gp_gauss_rule(16);
    const double a = scale_of(s, 1);
    double sum = 0.0;
    gp_curve_add(&s->within, a, 1.0, &sum);
    for (int k = 0; k < g->n; k++)
        sum -= M_PI * a * g->weight[k] *
               gp_sky_soft(&s->light, a, a * (0.5 + g->node[k]));
    return sum;
}

/* Fills the weights of a row. What stays in its pixels is what no other pixel gets;
 * around the poles, whose pixels are slivers of which that is next to nothing, terms along
 * the row take the difference. */
static void weigh_row(void *ctx, int row, int thread)
{
    const struct terms *const t = ctx;
    const struct gp_sky *const s = t->s;
    const struct gp_sky_sphere *const o = s->sphere;
    double left = first_light(s), along = 0.0;
    (void) thread;
    for (int k = -o->near; k <= o->near; k++) {
        const struct gp_sky_arc *const a =
            &o->arc[row * (2 * o->near + 1) + k + o->near];
        const int y = row + k;
        int reach;
        if (y < 0 || y >= o->h)
            continue;
        const float *const v =
            terms_of(t, k < 0 ? y : row, k < 0 ? -k : k, &reach);
        const double solid = gp_projection_solid(&s->p.projection, 0.0, y);
        for (int x = 0; x <= reach; x++) {
            const double share = solid * (double) v[x];
            const double both = x && 2 * x < o->w ? 2.0 * share : share;
            left -= both;
            along += k ? 0.0 : both;
            if (a->reach >= 0) {
                o->weight[a->at + (size_t) x] = (float) share;
                o->weight[a->at - (size_t) x] = (float) share;
            }
        }
    }
    if (row < o->level[0].n) {
        const double at[2] = {0.0, row};
        const double own = gp_projection_solid(&s->p.projection, 0.0, row) *
                           (mean_of(s, 0.0, at, at) - soft_mean(s, at, at));
        if (left < 0.5 * own) {
            o->even[row] = o->even[o->h - 1 - row] = 1.0 + (left - own) / along;
            left = own;
        }
    }
    o->own[row] = left + s->light.stays;
    o->own[o->h - 1 - row] = o->own[row];
}

/* Weights of rows, but for those around the poles. */
static gp_status make_arcs(const struct gp_log *log, struct gp_sky *s,
                           struct terms *t)
{
    struct gp_sky_sphere *const o = s->sphere;
    const int rows = (o->h + 1) / 2, side = 2 * o->near + 1;
    size_t count = 0;
    gp_status st;
    GP_TRY(gp_alloc(log, "kernel", (size_t) rows * (size_t) side,
                    sizeof *o->arc, &o->arc));
    GP_TRY(gp_alloc(log, "kernel", (size_t) o->h, sizeof *o->own, &o->own));
    GP_TRY(gp_alloc(log, "kernel", (size_t) o->h, sizeof *o->even, &o->even));
    for (int y = 0; y < o->h; y++)
        o->even[y] = 1.0;
    GP_TRY(make_terms(log, s, t));
    for (int i = 0; i < rows * side; i++) {
        const int row = i / side, k = i % side - o->near, y = row + k;
        int reach = -1;
        if (row >= o->level[0].n && y >= 0)
            (void) terms_of(t, k < 0 ? y : row, k < 0 ? -k : k, &reach);
        const size_t half = (size_t) gp_max(reach, 0);
        o->arc[i] = (struct gp_sky_arc) {reach, count + half};
        count += reach < 0 ? 0 : 2 * half + 1;
        o->margin = gp_max(o->margin, reach);
    }
    GP_TRY(gp_alloc(log, "kernel", count, sizeof *o->weight, &o->weight));
    gp_parallel_do(rows, weigh_row, t);
out:
    return st;
}

// -- coefficients ----------------------------------------------------------------

struct tabling {
    const struct gp_sky *s;
    const struct terms *terms;
    struct gp_sky_circles *of;
    int level, width; // points around a circle
    double step;      // rows
    size_t first;     // pair
};

/* The first terms of rows i and i + down around a pole, on both halves of z. */
static void load_rows(const struct tabling *t, int i, int down, float *z)
{
    int reach;
    const float *const v = terms_of(t->terms, i, down, &reach);
    const float by = down ? 1.0f : (float) t->s->sphere->even[i];
    for (int x = 0; x <= reach; x++)
        z[x] = z[(t->width - x) % t->width] = by * v[x];
}

/* The terms of a pair of circles, around both: they are even, and end. */
static void load_pair(const void *ctx, int c, int j, float *z)
{
    const struct tabling *const t = ctx;
    const struct gp_sky *const s = t->s;
    const size_t pair = t->first + (size_t) j, row = (size_t) t->of->reach + 1;
    const int i = (int) (pair / row), down = (int) (pair % row);
    const double at[2] = {0.0, i * t->step - 0.5};
    const bool last = t->level == s->sphere->levels - 1;
    (void) c;
    if (!t->level) {
        load_rows(t, i, down, z);
        return;
    }
    for (int q = 0; 2 * q <= t->width && 2 * i + down <= t->of->n; q++) {
        const double from[2] = {(double) q * s->sphere->w / t->width,
                                at[1] + down * t->step};
        const double v = gp_sky_term(s, t->level, last, at, from, side_of(s));
        if (v == 0.0 && q)
            break;
        z[q] = z[(t->width - q) % t->width] = (float) v;
    }
}

/* Transforms n pairs from t->first on. */
static gp_status transform_pairs(const struct gp_log *log,
                                 const struct tabling *t,
                                 const struct gp_transform *x, size_t n,
                                 struct gp_fft_matrix *m)
{
    const struct gp_fft_request req = {
        .log = log,
        .t = x,
        .channels = 1,
    };
    return gp_fft_rows_in(&req, (int) n, load_pair, t, m);
}

/* Counts the blocks of coefficients of a circle with itself at the equator, where they
 * go on the longest, that are something. */
static int count_blocks(const struct gp_fft_matrix *m)
{
    static const float NOTHING = 2e-5f;
    const float *const z = m->z[0];
    int last = 0;
    for (int b = 0; b < m->blocks; b++) {
        for (int k = 0; k < LINES; k++) {
            if (fabsf(z[(size_t) b * m->pitch * 2 * LINES + (size_t) k]) >
                NOTHING * z[0])
                last = b;
        }
    }
    return last + 1;
}

static gp_status make_circles(const struct gp_log *log, const struct gp_sky *s,
                              const struct terms *terms, int l,
                              struct gp_sky_circles *of)
{
    enum { CHUNK = 512 };
    struct tabling t = {.s = s, .terms = terms, .of = of, .level = l};
    struct gp_transform x = {0};
    struct gp_fft_matrix m = {0};
    gp_status st;
    t.width = l > 1 ? gp_fft_length(gp_max(s->sphere->w >> (l - 1), 16))
                    : s->sphere->w;
    t.step = l ? (double) s->sphere->h / of->n : 1.0;
    of->pairs = (size_t) (l ? of->n / 2 + 1 : of->n) * ((size_t) of->reach + 1);
    GP_TRY(gp_float_transform_make(log, t.width, &x));
    GP_TRY(gp_fft_matrix_make(log, (struct gp_fft_numbers) {0}, 1, t.width,
                              CHUNK, &m));
    of->blocks = m.blocks;
    if (l) {
        t.first = (size_t) (of->n / 2) * ((size_t) of->reach + 1);
        GP_TRY(transform_pairs(log, &t, &x, 1, &m));
        of->blocks = count_blocks(&m);
    }
    GP_TRY(gp_alloc(log, "kernel", (size_t) of->blocks * of->pairs,
                    LINES * sizeof(float), &of->k));
    // rows of a matrix are twice their coefficients
    const float by = (float) (0.5 * s->sphere->w / t.width);
    for (t.first = 0; t.first < of->pairs; t.first += CHUNK) {
        const size_t n =
            of->pairs - t.first < CHUNK ? of->pairs - t.first : CHUNK;
        GP_TRY(transform_pairs(log, &t, &x, n, &m));
        for (size_t b = 0; b < (size_t) of->blocks; b++) {
            const float *const from =
                (const float *) m.z[0] + b * m.pitch * 2 * LINES;
            float *const to = of->k + (b * of->pairs + t.first) * LINES;
            for (size_t i = 0; i < n * LINES; i++)
                to[i] = by * from[i / LINES * 2 * LINES + i % LINES];
        }
    }
out:
    gp_transform_free(&x);
    gp_fft_matrix_free(&m);
    return st;
}

/* Lays out the levels: circles 3/4 of 2^l rows apart, nearly, on both poles; a veil that is
 * seen all around is to be the same everywhere. */
static void lay_levels(struct gp_sky *s)
{
    static const int FEW = 96; // intervals of the last level
    struct gp_sky_sphere *const o = s->sphere;
    o->levels = 1;
    while (o->h >> (o->levels + 1) >= FEW && o->levels < GP_SKY_LEVELS - 1)
        o->levels++;
    const int last = gp_max((int) lround(ldexp(o->h, -o->levels) / 0.75), 2);
    o->levels++;
    for (int l = 1; l < o->levels; l++) {
        const double end = sqrt(fmin(scale_of(s, l + 1), 4.0));
        const int n = last << (o->levels - 1 - l);
        // and both pixels, whose means terms are
        const double angle =
            2.0 * gp_asin(0.5 * end) + 2.0 * s->p.projection.dy;
        o->level[l] = (struct gp_sky_circles) {
            .n = n,
            .reach = l == o->levels - 1
                         ? n
                         : gp_min(n, 1 + (int) (angle * n / M_PI)),
        };
        s->level[l].step = (double) o->h / n;
    }
    s->levels = o->levels;
}

// -- all of it -----------------------------------------------------------------------

static gp_status place_rows(const struct gp_log *log, struct gp_sky_sphere *o)
{
    gp_status st =
        gp_alloc(log, "kernel", (size_t) o->h, sizeof *o->rows, &o->rows);
    for (int y = 0; y < o->h && !st; y++) {
        const double t = (y + 0.5) * o->level[1].n / o->h;
        double at[GP_SKY_TAPS];
        o->rows[y].first = (int) floor(t) - 1;
        gp_far_spline(t - floor(t), at);
        for (int k = 0; k < GP_SKY_TAPS; k++)
            o->rows[y].at[k] = (float) at[k];
    }
    return st;
}

/* Finds the sphere that a frame is part of; false: none. */
static bool find_sphere(const struct gp_sky *s, struct gp_sky_sphere *o)
{
    enum { LEAST = 48 }; // rows
    static const double SAME = 1e-3;
    const struct gp_projection *const p = &s->p.projection;
    const double w = 2.0 * M_PI / p->dx, h = M_PI / p->dy;
    const double x = 0.5 * (w - 1.0) - p->x0, y = 0.5 * (h - 1.0) - p->y0;
    if (!(h >= LEAST && w <= 65536.0 && h <= 65536.0))
        return false;
    *o = (struct gp_sky_sphere) {
        .w = (int) lround(w),
        .h = (int) lround(h),
        .x0 = (int) lround(x),
        .y0 = (int) lround(y),
    };
    return fabs(w - o->w) < SAME && fabs(h - o->h) < SAME &&
           fabs(x - o->x0) < SAME && fabs(y - o->y0) < SAME && o->y0 >= 0 &&
           o->y0 + s->p.h <= o->h && s->p.w <= o->w && o->w % 2 == 0 &&
           gp_fft_takes(o->w);
}

gp_status gp_sky_sphere_make(const struct gp_log *log, struct gp_sky *s)
{
    static const double SHORT = 0.25; // of the equator, rows around a pole
    struct gp_sky_sphere *o = NULL, found;
    struct terms terms = {0};
    gp_status st = GP_OK;
    if (!find_sphere(s, &found))
        return GP_OK;
    GP_TRY(gp_alloc(log, "kernel", 1, sizeof *o, &o));
    *o = found;
    s->sphere = o;
    s->p.projection.x0 =
        0.5 * (o->w - 1); // from here on places are the sphere's
    s->p.projection.y0 = 0.5 * (o->h - 1);
    o->x0 = (o->x0 % o->w + o->w) % o->w;
    o->near = 1 + (int) (sqrt(scale_of(s, 1) * (1.0 + 2.0 / s->ratio)) /
                         s->p.projection.dy);
    o->level[0] = (struct gp_sky_circles) {
        .n = gp_max((int) (gp_asin(SHORT) * o->h / M_PI), 1),
        .reach = o->near,
    };
    lay_levels(s);
    GP_TRY(gp_float_transform_make(log, o->w, &o->around));
    GP_TRY(place_rows(log, o));
    GP_TRY(make_arcs(log, s, &terms));
    for (int l = 0; l < o->levels; l++)
        GP_TRY(make_circles(log, s, &terms, l, &o->level[l]));
out:
    gp_free(terms.pair);
    gp_free(terms.v);
    if (st)
        gp_sky_sphere_free(&s->sphere);
    return st;
}

void gp_sky_sphere_free(struct gp_sky_sphere **sphere)
{
    struct gp_sky_sphere *const o = *sphere;
    for (int l = 0; o && l < o->levels; l++)
        gp_free(o->level[l].k);
    if (o) {
        gp_transform_free(&o->around);
        gp_free(o->arc);
        gp_free(o->weight);
        gp_free(o->own);
        gp_free(o->even);
        gp_free(o->rows);
    }
    GP_FREE(*sphere);
}
