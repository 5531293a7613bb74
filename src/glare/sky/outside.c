// SPDX-License-Identifier: Apache-2.0
/* Light that leaves the frame.
 *
 * Around a place, light within the chord r is F(r^2), of which a sector d phi holds
 * d phi / 2 pi. So the share that falls into the frame is the sum over its border of
 *
 *   F(r^2) d phi / 2 pi,   d phi = p . (e x de) / |p x e|^2
 *
 * p the direction of the place, e that of the border, all the way around. */
#include "core/cpu.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/sky/sky_priv.h"

#include <math.h>
#include <string.h>

gp_status gp_sky_outside_make(const struct gp_log *log, struct gp_sky *s)
{
    const struct gp_curve *const of = &s->light.curve;
    const struct gp_gauss *const g = gp_gauss_rule(6);
    gp_status st = gp_curve_make(log, 1, s->light.nearest, 2.1, &s->within);
    double sum = 0.0, step;
    for (int i = 0; !st && i <= of->n; i++) {
        const double c = gp_curve_square(of, i, &step);
        double light = 0.0;
        if (i == 0) // even nearer in
            sum = M_PI * c * gp_sky_soft(&s->light, 0.0, c);
        s->within.value[2 * i] = sum;
        s->spread = c <= 4.0 ? sum : s->spread;
        light = gp_sky_soft(&s->light, 0.0, c);
        s->within.value[2 * i + 1] = M_PI * light * step;
        for (int k = 0; k < g->n && i < of->n; k++)
            sum += M_PI * step * g->weight[k] *
                   gp_sky_soft(&s->light, 0.0, c + step * (0.5 + g->node[k]));
    }
    s->facts.light += s->spread + s->light.stays;
    return st;
}

/* A side of the frame's border. */
struct side {
    double from[2], along[2]; // pixels; a unit step
    double length;
};

/* The part of the light around a place that is beyond a stretch of a side, from a to b
 * along it: next to nothing where it is far, though directions there turn fast behind
 * the place. */
static double part_of(const struct gp_sky *s, struct gp_v3 p,
                      const struct side *side, double a, double b)
{
    static const double STEP = 1e-3; // pixels, for the tangent
    const struct gp_projection *const q = &s->p.projection;
    const struct gp_gauss *const g = gp_gauss_rule(4);
    double sum = 0.0;
    for (int k = 0; k < g->n; k++) {
        const double t = 0.5 * (a + b) + (b - a) * g->node[k];
        double at[2], on[2]; // the border, and a step further on
        for (int i = 0; i < 2; i++) {
            at[i] = side->from[i] + t * side->along[i];
            on[i] = at[i] + STEP * side->along[i];
        }
        gp_projection_pull(q, 0.0, at);
        gp_projection_pull(q, 0.0, on);
        const struct gp_v3 e = gp_projection_direction(q, at[0], at[1]);
        const struct gp_v3 next = gp_projection_direction(q, on[0], on[1]);
        const struct gp_v3 apart = gp_v3_sub(e, p), across = gp_v3_cross(p, e);
        const double turn =
            gp_v3_dot(p, gp_v3_cross(e, gp_v3_sub(next, e))) / STEP;
        const double c = gp_v3_dot(apart, apart);
        double within = 0.0;
        gp_curve_add(&s->within, c, 1.0, &within);
        sum += g->weight[k] * (b - a) * (s->spread - within) * turn /
               fmax(gp_v3_dot(across, across), 1e-300);
    }
    return sum / (2.0 * M_PI);
}

/* The same from the foot of the place on it, `away`, to one end: in stretches that
 * grow with the distance. */
static double half_of(const struct gp_sky *s, struct gp_v3 p,
                      const struct side *side, double foot, double away,
                      double end)
{
    const double way = end < foot ? -1.0 : 1.0, length = fabs(end - foot);
    double sum = 0.0, at = 0.0;
    while (at < length) {
        const double to = fmin(at + fmax(away, at), length);
        sum += part_of(s, p, side, foot + way * at, foot + way * to);
        at = to;
    }
    return sum;
}

/* The share for light at a point. */
static double outside_of(const struct gp_sky *s, double x, double y)
{
    const double w = s->p.w, h = s->p.h;
    const struct side sides[4] = {
        {{-0.5, -0.5}, {1, 0}, w},
        {{w - 0.5, -0.5}, {0, 1}, h},
        {{w - 0.5, h - 0.5}, {-1, 0}, w},
        {{-0.5, h - 0.5}, {0, -1}, h},
    };
    const struct gp_v3 p = gp_projection_direction(&s->p.projection, x, y);
    const struct gp_projection *const q = &s->p.projection;
    const bool shown =
        !(q->rim > 0.0) ||
        gp_hypot((x - q->x0) * q->dx, (y - q->y0) * q->dy) < q->rim;
    double beyond = 0.0;
    for (int i = 0; i < 4; i++) {
        const struct side *const d = &sides[i];
        const double u = x - d->from[0], v = y - d->from[1];
        const double foot = u * d->along[0] + v * d->along[1];
        const double away = fabs(u * d->along[1] - v * d->along[0]);
        const double at = fmin(fmax(foot, 0.0), d->length);
        beyond += half_of(s, p, d, at, fmax(away, 0.01), d->length) -
                  half_of(s, p, d, at, fmax(away, 0.01), 0.0);
    }
    const double v = fmin(fabs(beyond), s->spread);
    return shown ? v : s->spread - v;
}

/* Points of an axis on which the share is found: within some pixels of a border it
 * bends across that, and the pixel shines evenly. */
static const struct gp_gauss *points_of(double at, int n)
{
    static const double NEAR = 6.0;
    const double border = fmin(at, n - 1 - at);
    return gp_gauss_rule(border < 1.0 ? 10 : border < NEAR ? 3 : 1);
}

double gp_sky_outside(const struct gp_sky *s, double x, double y)
{
    if (s->sphere || !s->p.n)
        return 0.0; // all of the sky is in the frame, or there are no levels
    const struct gp_gauss *const g = points_of(x, s->p.w);
    const struct gp_gauss *const d = points_of(y, s->p.h);
    double sum = 0.0;
    for (int i = 0; i < g->n * d->n; i++)
        sum += g->weight[i % g->n] * d->weight[i / g->n] *
               outside_of(s, x + g->node[i % g->n], y + d->node[i / g->n]);
    return sum;
}

// -- a table of places --------------------------------------------------------

/* Pixels 0 .. n - 1 at which the share is known: each at both borders, and then as far
 * apart as a sixth of the way from there; the same from either side. */
static int lay_axis(int n, int *at)
{
    int count = 0, half;
    for (int i = 0; 2 * i <= n - 1; i += gp_max(1, i / 6))
        at[count++] = i;
    half = count;
    for (int k = half - 1; k >= 0; k--) {
        if (n - 1 - at[k] > at[count - 1])
            at[count++] = n - 1 - at[k];
    }
    return count;
}

static void find_row(void *ctx, int j, GP_UNUSED int thread)
{
    struct gp_sky *const s = ctx;
    const int w = s->outer[0], h = s->outer[1];
    for (int i = 0; i < w; i++) {
        // mirrored places have the same share
        const bool known =
            (s->even[0] && i > w - 1 - i) || (s->even[1] && j > h - 1 - j);
        if (!known)
            s->outside[j * w + i] =
                (float) gp_sky_outside(s, s->outer_at[0][i], s->outer_at[1][j]);
    }
}

/* Finds how far the table is off over the frame: in the middles of cells between its
 * places, each for its pixels, of some cells. */
enum { LOOKED = 8 }; // of cells along each axis

struct looking {
    struct gp_sky *s;
    double square[LOOKED * LOOKED], area[LOOKED * LOOKED];
    float *row; // of each thread
};

static void look_at_cell(void *ctx, int k, int thread)
{
    struct looking *const l = ctx;
    const struct gp_sky *const s = l->s;
    float *const row = l->row + (size_t) thread * (size_t) s->p.w;
    int at[2], side[2];
    for (int a = 0; a < 2; a++) {
        const int n = s->outer[a] - 1, i = (a ? k / LOOKED : k % LOOKED);
        const int cell = n > 0 ? (int) ((2 * i + 1) * n / (2.0 * LOOKED)) : 0;
        const int first = s->outer_at[a][cell];
        side[a] = n > 0 ? s->outer_at[a][cell + 1] - first : 1;
        at[a] = first + side[a] / 2;
    }
    gp_sky_outside_row(s, at[1], row);
    const double off = (double) row[at[0]] - gp_sky_outside(s, at[0], at[1]);
    l->area[k] = side[0] * side[1];
    l->square[k] = off * off * l->area[k];
}

static gp_status find_outside_error(const struct gp_log *log, struct gp_sky *s)
{
    static const double SURE = 3.0; // between the places that are looked at
    struct looking l = {.s = s};
    const gp_status st =
        gp_alloc(log, "kernel", (size_t) s->p.w * (size_t) gp_threads(),
                 sizeof *l.row, &l.row);
    double square = 0.0, area = 0.0;
    if (st)
        return st;
    gp_parallel_do(LOOKED * LOOKED, look_at_cell, &l);
    for (int k = 0; k < LOOKED * LOOKED; k++) {
        square += l.square[k];
        area += l.area[k];
    }
    s->facts.outside = SURE * sqrt(square / area) + 1e-7;
    gp_free(l.row);
    return GP_OK;
}

/* Finds the least share of a source's light that all samples of its layer sum to: what
 * falls into the frame, of a pixel of the smallest solid angle over the largest. */
static void find_kept(struct gp_sky *s)
{
    const struct gp_projection *const p = &s->p.projection;
    double least = INFINITY, most = 0.0, out = 0.0;
    for (int i = 0; i < 9; i++) {
        const double middle[2] = {fmin(fmax(p->x0, 0.0), s->p.w - 1),
                                  fmin(fmax(p->y0, 0.0), s->p.h - 1)};
        double at[2] = {i % 3 == 1 ? middle[0] : (i % 3) * 0.5 * (s->p.w - 1),
                        i / 3 == 1 ? middle[1] : (i / 3) * 0.5 * (s->p.h - 1)};
        gp_projection_pull(p, 0.0, at);
        const double solid = gp_projection_solid(p, at[0], at[1]);
        least = fmin(least, solid);
        most = fmax(most, solid);
    }
    for (int i = 0; i < s->outer[0] * s->outer[1]; i++)
        out = fmax(out, (double) s->outside[i]);
    s->facts.kept =
        0.99 * fmax(s->spread + s->light.stays - out, 0.0) * least / most;
}

gp_status gp_sky_outside_table(const struct gp_log *log, struct gp_sky *s)
{
    gp_status st = gp_alloc(log, "kernel", (size_t) s->p.w + (size_t) s->p.h,
                            sizeof *s->outer_at[0], &s->outer_at[0]);
    if (st)
        return st;
    s->outer_at[1] = s->outer_at[0] + s->p.w;
    s->outer[0] = lay_axis(s->p.w, s->outer_at[0]);
    s->outer[1] = lay_axis(s->p.h, s->outer_at[1]);
    st = gp_alloc(log, "kernel", (size_t) s->outer[0] * (size_t) s->outer[1],
                  sizeof *s->outside, &s->outside);
    if (st)
        return st;
    const int w = s->outer[0], h = s->outer[1];
    gp_parallel_do(h, find_row, s);
    for (int i = 0; i < w * h; i++) {
        const int x = i % w, y = i / w;
        const int from = s->even[0] && x > w - 1 - x ? w - 1 - x : x;
        const int down = s->even[1] && y > h - 1 - y ? h - 1 - y : y;
        s->outside[i] = s->outside[down * w + from];
    }
    find_kept(s);
    return find_outside_error(log, s);
}

/* The first of the four places around place i of n, or of as many as there are. */
static int first_of(int i, int n)
{
    return gp_max(gp_min(i - 1, n - 4), 0);
}

/* Weights of n places in what is between them at y. */
static void weigh_places(const int *at, int n, int y, double by[4])
{
    for (int j = 0; j < n; j++) { // Lagrange
        by[j] = 1.0;
        for (int k = 0; k < n; k++)
            by[j] *= k == j ? 1.0 : (double) (y - at[k]) / (at[j] - at[k]);
    }
}

/* Fills pixels [from, end) of a row by Newton's form of a cubic. */
GP_CLONES static void cubic_row(const double v[4], const int *at, int n,
                                int from, int end, float *restrict row)
{
    const float a = (float) v[0], b = (float) v[1], c = (float) v[2];
    const float d = (float) v[3], x0 = (float) at[0];
    const float x1 = (float) at[n > 1], x2 = (float) at[n > 2 ? 2 : 0];
    for (int i = from; i < end; i++) {
        const float x = (float) i;
        row[i] =
            gp_maxf(a + (x - x0) * (b + (x - x1) * (c + (x - x2) * d)), 0.0f);
    }
}

/* Cubics through the four places around each, or as many as there are. */
void gp_sky_outside_row(const struct gp_sky *s, int y, float *row)
{
    const int *const at = s->outer_at[0];
    int j = 0, end = 0;
    if (s->sphere || !s->p.n) {
        memset(row, 0, (size_t) s->p.w * sizeof *row);
        return;
    }
    while (j + 1 < s->outer[1] && s->outer_at[1][j + 1] <= y)
        j++;
    const int columns = gp_min(s->outer[0], 4), rows = gp_min(s->outer[1], 4);
    const int upper = first_of(j, s->outer[1]);
    double by[4];
    weigh_places(s->outer_at[1] + upper, rows, y, by);
    double column[4]; // what is around, of place i at i % 4
    for (int i = 0, known = 0; i < s->outer[0]; i++) {
        const int first = first_of(i, s->outer[0]), from = end;
        double v[4] = {0};
        for (; known < first + columns; known++) {
            const float *const share = s->outside + upper * s->outer[0] + known;
            column[known % 4] = 0.0;
            for (int m = 0; m < rows; m++)
                column[known % 4] += by[m] * (double) share[m * s->outer[0]];
        }
        for (int m = 0; m < columns; m++)
            v[m] = column[(first + m) % 4];
        for (int k = 1; k < columns; k++) // Newton's differences
            for (int m = columns - 1; m >= k; m--)
                v[m] = (v[m] - v[m - 1]) / (at[first + m] - at[first + m - k]);
        end = i + 1 < s->outer[0] ? at[i + 1] : s->p.w;
        cubic_row(v, at + first, columns, from, end, row);
    }
}

// -- of cosines ----------------------------------------------------------------

/* The core's light in its row y between two places on it, in samples. */
static double between(const struct gp_cosines *c, int y, double from, double to)
{
    const int w = c->w;
    const double *const row = c->sums + (size_t) y * ((size_t) w + 1);
    double at[2] = {from, to};
    for (int i = 0; i < 2; i++) {
        const double t = fmin(fmax(at[i], 0.0), w);
        const int k = (int) fmin(floor(t), w - 1);
        at[i] = row[k] + (t - k) * (row[k + 1] - row[k]);
    }
    return fmax(at[1] - at[0], 0.0);
}

/* With X = x / z of a place, and Y: where y is b, Y is at most Y1 where z is at least
 * b / Y1, which is |x| at most this; 0 where no z is. */
static double side_of(double b, double side)
{
    const double z = b / side;
    return side > 0.0 ? sqrt(fmax(1.0 - b * b - z * z, 0.0)) : 0.0;
}

double gp_cosines_outside(const struct gp_cosines *c, double x, double y)
{
    const struct gp_cosine_grid *const g = &c->grid;
    const struct gp_projection *const p = &g->projection;
    const struct gp_v3 at = gp_projection_direction(p, x, y);
    const double left = (-0.5 - p->x0) * p->dx;
    const double right = (g->w - 0.5 - p->x0) * p->dx;
    const double top = (-0.5 - p->y0) * p->dy;
    const double bottom = (g->h - 0.5 - p->y0) * p->dy;
    double inside = 0.0;
    for (int j = 0; j < c->h; j++) {
        const double b = at.y + (j - c->h / 2) * g->step[1];
        if (fabs(b) >= 1.0)
            continue;
        const double q = sqrt(1.0 - b * b), size = fabs(b);
        // b / z is between both sides: |x| between `near` and `far`
        const double far = side_of(size, b < 0.0 ? -top : bottom);
        const double near = side_of(size, b < 0.0 ? -bottom : top);
        const double from = left * q / sqrt(1.0 + left * left);
        const double to = right * q / sqrt(1.0 + right * right);
        const double ends[2][2] = {{fmax(from, -far), fmin(to, far)},
                                   {fmax(from, -near), fmin(to, near)}};
        for (int i = 0; i < (near > 0.0 ? 2 : 1); i++) {
            const double first = 0.5 + c->w / 2 - at.x / g->step[0];
            const double light = between(c, j, first + ends[i][0] / g->step[0],
                                         first + ends[i][1] / g->step[0]);
            inside += i ? -light : light;
        }
    }
    // what no node has is outside
    return fmax(c->all - inside, 0.0);
}
