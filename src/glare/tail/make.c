/* Making a tail: sampled on the coarse grid, its splines divided out. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/tail/tail_priv.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

/* A step that spans this many pixels holds what samples every 8 pixels can:
 * within 1e-6 of the light for the eye, 1/36 degree a pixel. Twice as wide with
 * steps twice as wide holds as much, of frames twice as wide. */
static const double WIDE = 95.0, NEAREST = 32.0;

/* 1 on [1, inf), 0 on (-inf, 0]: the step of degree 11, never outside. */
static double smooth_step(double u)
{
    const double v = fmin(fmax(u <= 0.5 ? u : 1.0 - u, 0.0), 1.0);
    const double v3 = v * v * v;
    const double s = v3 * v3 *
        (462.0 + v * (-1980.0 + v * (3465.0 + v * (-3080.0 +
                 v * (1386.0 - 252.0 * v)))));
    return u <= 0.5 ? s : 1.0 - s;
}

struct gp_tail_split gp_tail_choose(double smooth, int w, int h)
{
    static const int LEAST_STEP = 8, MOST_STEP = 32, NODES = 512;
    static const double WORTH = 1.5; // core and tail against the whole
    const int side = gp_max(w, h);
    struct gp_tail_split s = {.step = LEAST_STEP};
    while (s.step < MOST_STEP && side / s.step > NODES)
        s.step *= 2;
    const double scale = (double) s.step / LEAST_STEP;
    s.from = fmax(NEAREST * scale, ceil(smooth));
    s.to = s.from + WIDE * scale;
    if (!(s.to * WORTH < side)) // INFINITY too
        s = (struct gp_tail_split) {0};
    return s;
}

double gp_tail_share(const struct gp_tail_split *s, int x, int y)
{
    const double r = sqrt((double) x * x + (double) y * y);
    return smooth_step((r - s->from) / (s->to - s->from));
}

void gp_tail_free(struct gp_tail *t)
{
    for (int c = 0; t && c < 3; c++)
        gp_free(t->c[c]);
    gp_free(t);
}

// -- samples ------------------------------------------------------------------

struct sampling {
    struct gp_tail *t;
    gp_tail_sample sample;
    const void *ctx;
    bool even;
    double *at[3]; // as t->c
};

/* Beyond the offsets that frames meet the tail fades out over GP_TAIL_FADE
 * steps, so that it has no edge: no frame shows that part, and the error of the
 * splines and the transform is that of a smooth function everywhere. */
static double fade(int i, int r)
{
    const int past = abs(i) - (r - GP_TAIL_FADE);
    return 1.0 - smooth_step((double) past / GP_TAIL_FADE);
}

static void sample_row(void *ctx, int i, int thread)
{
    const struct sampling *const s = ctx;
    const struct gp_tail *const t = s->t;
    const int step = t->split.step, y = s->even ? i : i - t->ry;
    const ptrdiff_t w = 2 * t->rx + 1;
    const ptrdiff_t up = (t->ry - y) * w, down = (t->ry + y) * w;
    (void) thread;
    for (int x = s->even ? 0 : -t->rx; x <= t->rx; x++) {
        double v[3];
        const double k = gp_tail_share(&t->split, x * step, y * step) *
                         fade(x, t->rx) * fade(y, t->ry);
        if (k > 0.0)
            s->sample(s->ctx, x * step, y * step, v);
        for (int c = 0; c < (t->grey ? 1 : 3); c++) {
            double *const at = s->at[c] + t->rx;
            const double value = k > 0.0 ? k * v[c] : 0.0;
            at[down + x] = value;
            if (s->even)
                at[down - x] = at[up + x] = at[up - x] = value;
        }
    }
}

/* Norms of one channel from its samples. */
static void find_norms(struct gp_tail *t, int c, const double *at)
{
    static const double MORE = 1.0 + 1e-3; // than samples of all pixels
    const size_t n = (2 * (size_t) t->rx + 1) * (2 * (size_t) t->ry + 1);
    const int s = t->split.step;
    double square = 0.0, sum = 0.0;
    for (size_t i = 0; i < n; i++) {
        sum += at[i];
        square += at[i] * at[i];
    }
    t->norm1[c] = MORE * sum * s * s;
    t->norm2[c] = MORE * sqrt(square) * s;
}

// -- the splines divided out --------------------------------------------------

/* Divides the samples 1/6, 4/6, 1/6 of the cubic B-spline out of n values
 * `pitch` apart, twice, zero beyond both ends: Unser et al. 1993, part II, eq.
 * 2.5. Of `lines` such rows side by side. */
GP_CLONES static void divide(double *v, int n, size_t pitch, int lines)
{
    static const double Z = -0.26794919243112270647; // sqrt 3 - 2
    for (int twice = 0; twice < 2; twice++) {
        double *at = v;
        for (int i = 1; i < n; i++, at += pitch) {
            for (int k = 0; k < lines; k++)
                at[pitch + (size_t) k] += Z * at[k];
        }
        for (int k = 0; k < lines; k++)
            at[k] *= -Z / (1.0 - Z * Z);
        for (int i = 1; i < n; i++) {
            at -= pitch;
            for (int k = 0; k < lines; k++)
                at[k] = Z * (at[pitch + (size_t) k] - at[k]);
        }
        for (int i = 0; i < n; i++, at += pitch) {
            for (int k = 0; k < lines; k++)
                at[k] *= 6.0;
        }
    }
}

/* The sum over pixels x, |x| < n, of what a node adds to a row, or to a column,
 * with a source that stands on a node. */
static double pixels_of(int node, int step, int n)
{
    static const double own[3] = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
    double sum = 0.0;
    for (int m = -1; m <= 1; m++) {
        for (int x = (node + m - 2) * step; x < (node + m + 2) * step; x++) {
            const double u = fabs((double) x / step - node - m);
            const double far = 2.0 - u, near = fmax(1.0 - u, 0.0);
            if (abs(x) < n)
                sum += own[m + 1] / 6.0 *
                       (far * far * far - 4.0 * near * near * near);
        }
    }
    return sum;
}

static gp_status find_sum(const struct gp_log *log, struct gp_tail *t, int c,
                          const double *at)
{
    const int rx = t->rx, ry = t->ry, s = t->split.step;
    double *weight;
    gp_status st = gp_alloc(log, "tail", 2 * (size_t) rx + 1, sizeof *weight,
                            &weight);
    if (st)
        return st;
    for (int x = -rx; x <= rx; x++)
        weight[x + rx] = pixels_of(x, s, t->w);
    for (int y = -ry; y <= ry; y++) {
        double row = 0.0;
        for (int x = 0; x <= 2 * rx; x++)
            row += *at++ * weight[x];
        t->sum[c] += row * pixels_of(y, s, t->h);
    }
    gp_free(weight);
    return GP_OK;
}

gp_status gp_tail_make(const struct gp_log *log,
    const struct gp_tail_split *split, int w, int h, bool grey, bool even,
    gp_tail_sample sample, const void *ctx, struct gp_tail **out)
{
    gp_status st;
    struct sampling s = {.sample = sample, .ctx = ctx, .even = even};
    struct gp_tail *t = NULL;
    GP_TRY(gp_alloc_zero(log, "tail", 1, sizeof *t, &t));
    t->split = *split;
    t->w = w;
    t->h = h;
    t->rx = gp_tail_nodes(w, split->step) - 1 + GP_TAIL_FADE;
    t->ry = gp_tail_nodes(h, split->step) - 1 + GP_TAIL_FADE;
    t->grey = grey;
    t->serial = gp_serial_next();
    s.t = t;
    const int across = 2 * t->rx + 1, down = 2 * t->ry + 1;
    const size_t n = (size_t) across * (size_t) down;
    for (int c = 0; c < (grey ? 1 : 3); c++) {
        GP_TRY(gp_alloc(log, "tail", n, sizeof(double), &s.at[c]));
        GP_TRY(gp_alloc(log, "tail", n, sizeof(float), &t->c[c]));
    }
    gp_parallel_do(even ? t->ry + 1 : down, sample_row, &s);
    for (int c = 0; c < (grey ? 1 : 3); c++) {
        find_norms(t, c, s.at[c]);
        for (int y = 0; y < down; y++)
            divide(s.at[c] + (size_t) y * (size_t) across, across, 1, 1);
        divide(s.at[c], down, (size_t) across, across);
        GP_TRY(find_sum(log, t, c, s.at[c]));
        for (size_t i = 0; i < n; i++)
            t->c[c][i] = (float) s.at[c][i];
    }
    for (int c = 1; c < 3 && grey; c++) {
        t->sum[c] = t->sum[0];
        t->norm1[c] = t->norm1[0];
        t->norm2[c] = t->norm2[0];
    }
    *out = t;
    t = NULL;
out:
    for (int c = 0; c < 3; c++)
        gp_free(s.at[c]);
    gp_tail_free(t);
    return st;
}
