// SPDX-License-Identifier: Apache-2.0
/* Making a far field: sampled on the coarse grid, its splines divided out. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
#include "glare/kernel.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* A step that spans this many pixels holds what samples every 8 pixels can:
 * within 1e-6 of the light for the eye, 1/36 degree a pixel. Twice as wide with
 * steps twice as wide holds as much, of frames twice as wide. */
enum { NEAREST = 32, WIDE = GP_FAR_CORE - NEAREST };

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

struct gp_far_split gp_far_choose(double smooth, double stretch, int sharp,
                                    int w, int h)
{
    static const int LEAST_STEP = 8, MOST_STEP = 32, NODES = 512;
    static const double WORTH = 1.5;   // core and far field against the whole
    static const double STRETCH = 2.0; // that NEAREST is enough for
    const int side = gp_max(w, h);
    struct gp_far_split s = {.step = LEAST_STEP};
    while (s.step < MOST_STEP && side / s.step > NODES)
        s.step *= 2;
    const double scale = (double) s.step / LEAST_STEP;
    s.from = fmax(ceil(NEAREST * scale * fmax(stretch / STRETCH, 1.0)),
                  ceil(smooth));
    s.to = s.from + WIDE * scale;
    if (!(fmax(s.to, sharp) * WORTH < side)) // INFINITY too
        s = (struct gp_far_split) {0};
    return s;
}

double gp_far_share(const struct gp_far_split *s, int x, int y)
{
    const double square = (double) x * x + (double) y * y;
    if (square <= s->from * s->from)
        return 0.0;
    if (square >= s->to * s->to)
        return 1.0;
    return smooth_step((sqrt(square) - s->from) / (s->to - s->from));
}

void gp_far_free(struct gp_far_field *t)
{
    if (t)
        gp_free(t->c[0]);
    gp_free(t);
}

// -- samples ------------------------------------------------------------------

struct sampling {
    struct gp_far_field *t;
    const struct gp_far_kernel *kernel;
    double *at[3];     // as t->c
    double *fade[2];   // of offsets 0 .. rx, 0 .. ry
    double *weight[2]; // of nodes -rx .. rx, -ry .. ry: pixels_of()
};

/* Samples the row of offset i - ry or, where samples are even, the right half
 * of that of offset i. */
static void sample_row(void *ctx, int i, GP_UNUSED int thread)
{
    const struct sampling *const s = ctx;
    const struct gp_far_field *const t = s->t;
    const int step = t->split.step, y = s->kernel->even ? i : i - t->ry;
    const size_t row =
        (size_t) (t->ry + y) * (2 * (size_t) t->rx + 1) + (size_t) t->rx;
    for (int x = s->kernel->even ? 0 : -t->rx; x <= t->rx; x++) {
        double v[3];
        const double k = gp_far_share(&t->split, x * step, y * step) *
                         s->fade[0][abs(x)] * s->fade[1][abs(y)];
        if (k > 0.0)
            s->kernel->sample(s->kernel->ctx, x * step, y * step, v);
        for (int c = 0; c < (t->grey ? 1 : 3); c++)
            s->at[c][row + (size_t) x] = k > 0.0 ? k * v[c] : 0.0;
    }
}

/* Fills the left half of rows, and then the upper half, from the other. */
static void mirror(const struct gp_far_field *t, double *at)
{
    const size_t w = 2 * (size_t) t->rx + 1;
    for (int y = 0; y <= t->ry; y++) {
        double *const middle = at + (size_t) (t->ry + y) * w + (size_t) t->rx;
        for (int x = 1; x <= t->rx; x++)
            middle[-x] = middle[x];
    }
    for (int y = 1; y <= t->ry; y++)
        memcpy(at + (size_t) (t->ry - y) * w, at + (size_t) (t->ry + y) * w,
               w * sizeof *at);
}

/* Norms of one channel from its samples, and the least of those that frames
 * meet from split.to on. */
static void find_norms(struct gp_far_field *t, int c, const double *at)
{
    static const double MORE = 1.0 + 1e-3; // than samples of all pixels
    const int s = t->split.step;
    const double to = t->split.to / s;
    double square = 0.0, sum = 0.0;
    for (int y = -t->ry; y <= t->ry; y++) {
        for (int x = -t->rx; x <= t->rx; x++, at++) {
            sum += *at;
            square += *at * *at;
            if (abs(x) * s < t->w && abs(y) * s < t->h && *at < t->least &&
                (double) x * x + (double) y * y >= to * to)
                t->least = *at;
        }
    }
    t->norm1[c] = MORE * sum * s * s;
    t->norm2[c] = MORE * sqrt(square) * s;
}

// -- the splines divided out --------------------------------------------------

enum { LINES = 16 }; // that go through together: each is a chain of sums that
                     // wait for one another

/* Lines of n values `pitch` apart, `across` from line to line. */
struct dividing {
    double *at;
    int n, lines;
    size_t pitch, across;
    int times;
};

static void divide_lines(void *ctx, int task, GP_UNUSED int thread)
{
    static const double Z = -0.26794919243112270647; // sqrt 3 - 2
    const struct dividing *const d = ctx;
    const size_t pitch = d->pitch, across = d->across;
    const size_t lines = (size_t) gp_min(d->lines - task * LINES, LINES);
    for (int pass = 0; pass < d->times; pass++) {
        double *at = d->at + (size_t) task * LINES * across;
        for (int i = 1; i < d->n; i++, at += pitch) {
            for (size_t k = 0; k < lines; k++)
                at[pitch + k * across] += Z * at[k * across];
        }
        for (size_t k = 0; k < lines; k++)
            at[k * across] *= 6.0 * -Z / (1.0 - Z * Z);
        for (int i = 1; i < d->n; i++) {
            at -= pitch;
            for (size_t k = 0; k < lines; k++)
                at[k * across] =
                    Z * (at[pitch + k * across] - 6.0 * at[k * across]);
        }
    }
}

void gp_far_divide(double *v, int w, int h, int times)
{
    const size_t pitch = (size_t) w;
    struct dividing rows = {v, w, h, 1, pitch, times};
    struct dividing columns = {v, h, w, pitch, 1, times};
    gp_parallel_do((h + LINES - 1) / LINES, divide_lines, &rows);
    gp_parallel_do((w + LINES - 1) / LINES, divide_lines, &columns);
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

/* Makes what an axis of offsets -r .. r needs, of frames of n pixels.
 *
 * Beyond the offsets that frames meet the far field fades out over GP_FAR_FADE
 * steps, so that it has no edge: no frame shows that part, and the error of the
 * splines and the transform is that of a smooth function everywhere. */
static gp_status make_axis(const struct gp_log *log, int r, int step, int n,
                           double **fade, double **weight)
{
    gp_status st = gp_alloc(log, "tail", (size_t) r + 1, sizeof **fade, fade);
    if (!st)
        st = gp_alloc(log, "tail", 2 * (size_t) r + 1, sizeof **weight, weight);
    for (int i = 0; i <= 2 * r && !st; i++) {
        (*weight)[i] = pixels_of(i - r, step, n);
        if (i <= r)
            (*fade)[i] = 1.0 - smooth_step((double) (i - (r - GP_FAR_FADE)) /
                                           GP_FAR_FADE);
    }
    return st;
}

/* Finds the sum that a channel's nodes add to a frame. */
static double find_sum(const struct sampling *s, const double *at)
{
    double sum = 0.0;
    for (int y = 0; y <= 2 * s->t->ry; y++) {
        double row = 0.0;
        for (int x = 0; x <= 2 * s->t->rx; x++)
            row += *at++ * s->weight[0][x];
        sum += row * s->weight[1][y];
    }
    return sum;
}

gp_status gp_far_make(const struct gp_log *log,
    const struct gp_far_split *split, int w, int h,
    const struct gp_far_kernel *kernel, struct gp_far_field **out)
{
    gp_status st;
    const bool grey = kernel->grey, even = kernel->even;
    struct sampling s = {.kernel = kernel};
    struct gp_far_field *t = NULL;
    GP_TRY(gp_alloc_zero(log, "tail", 1, sizeof *t, &t));
    t->split = *split;
    t->w = w;
    t->h = h;
    t->rx = gp_far_nodes(w, split->step) - 1 + GP_FAR_FADE;
    t->ry = gp_far_nodes(h, split->step) - 1 + GP_FAR_FADE;
    t->grey = grey;
    t->least = INFINITY;
    t->serial = gp_serial_next();
    s.t = t;
    const int across = 2 * t->rx + 1, down = 2 * t->ry + 1;
    const size_t n = (size_t) across * (size_t) down;
    const size_t channels = grey ? 1 : 3;
    GP_TRY(gp_alloc(log, "tail", channels * n, sizeof(double), &s.at[0]));
    GP_TRY(gp_alloc(log, "tail", channels * n, sizeof(float), &t->c[0]));
    for (size_t c = 1; c < channels; c++) {
        s.at[c] = s.at[0] + c * n;
        t->c[c] = t->c[0] + c * n;
    }
    GP_TRY(make_axis(log, t->rx, split->step, w, &s.fade[0], &s.weight[0]));
    GP_TRY(make_axis(log, t->ry, split->step, h, &s.fade[1], &s.weight[1]));
    gp_parallel_do(even ? t->ry + 1 : down, sample_row, &s);
    for (int c = 0; c < (grey ? 1 : 3); c++) {
        if (even)
            mirror(t, s.at[c]);
        find_norms(t, c, s.at[c]);
        gp_far_divide(s.at[c], across, down, 2);
        if (even) // to the last bit
            mirror(t, s.at[c]);
        t->sum[c] = find_sum(&s, s.at[c]);
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
    gp_free(s.at[0]);
    for (int i = 0; i < 2; i++) {
        gp_free(s.fade[i]);
        gp_free(s.weight[i]);
    }
    gp_far_free(t);
    return st;
}
