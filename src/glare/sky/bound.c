// SPDX-License-Identifier: Apache-2.0
/* Limits of the error of levels over the layer, found when they are made. Around a
 * place the sum is a convolution but for what changes over the frame, and so is each
 * error.
 *
 * Of pixels: weights as they are interpolated, less those that are right, over these,
 * both as norms: what a lamp meets. Light that is even meets their sums, which agree
 * better.
 *
 * Of a level: its term has the spectrum K. At a frequency where splines keep k of it,
 * and eps in their images, they lose 1 - k^2 and add k eps + eps^2 of it (far_field's
 * add.c has the same). Levels err at frequencies an octave apart, so that their norms
 * add up as squares, nearly (Cotlar and Stein). As no light is negative, no frequency
 * has more of it than 0 has, where levels keep all. A lamp has as much of all: its error
 * is a norm over that of all weights. The larger of both counts: that of a lamp where
 * light is even within many pixels, as in narrow fields. */
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sum.h"

#include <math.h>
#include <string.h>

enum { SIDE = 64 }; // most frequencies of an axis

struct complex {
    double re, im;
};

/* Adds v times the wave of frequency i of n at `at`. */
static inline void add_wave(struct complex *sum, struct complex v,
                            const double turn[SIDE][2], int n, int i, int at)
{
    const double *const t = turn[i * (at + n) % n];
    sum->re += v.re * t[0] + v.im * t[1];
    sum->im += v.im * t[0] - v.re * t[1];
}

/* The spectrum of n x n samples, the middle one at 0. */
static void find_spectrum(const double *v, int n,
                          struct complex out[SIDE][SIDE])
{
    double turn[SIDE][2];
    for (int i = 0; i < n; i++) {
        const double t = 2.0 * M_PI * i / n;
        turn[i][0] = gp_cos(t);
        turn[i][1] = gp_sin(t);
    }
    memset(out, 0, SIDE * sizeof *out);
    for (int y = 0; y < n; y++) {
        struct complex line[SIDE] = {{0}};
        for (int x = 0; x < n; x++) {
            const struct complex at = {v[y * n + x], 0.0};
            for (int i = 0; i < n && at.re != 0.0; i++)
                add_wave(&line[i], at, turn, n, i, x - n / 2);
        }
        for (int j = 0; j < n; j++) {
            for (int i = 0; i < n; i++)
                add_wave(&out[j][i], line[i], turn, n, j, y - n / 2);
        }
    }
}

/* Fades samples out in the outer quarter of a line: of far levels some have no end in
 * a perspective, whose horizon is infinitely far away. */
static double fade(int i, int n)
{
    const double out = fabs((double) (2 * i - n)) / n;
    const double v = gp_cos(0.5 * M_PI * fmax(4.0 * out - 3.0, 0.0));
    return v * v;
}

/* The term of a level between a place and another one, by its metric alone: around a
 * fisheye's rim directions end. */
static double flat_term(const struct gp_sky *s, int l, double side,
                        const struct gp_metric *m, double x, double y)
{
    const double angle =
        sqrt(m->xx * x * x + 2.0 * m->xy * x * y + m->yy * y * y);
    const double chord = 2.0 * gp_sin(0.5 * fmin(angle, M_PI));
    return gp_sky_soft_term(s, l, side, chord * chord);
}

/* Errors of light that is even but for one frequency, and of a lamp. */
struct errors {
    double even, lamp;
};

/* The norms of the error of a level at a place. Of the last one, whose term has no end,
 * as if others came after it, and these: each is under .75 of the
 * one before. */
static struct errors level_error(const struct gp_sky *s, int l,
                                 const double at[2])
{
    const bool last = l == s->levels - 1;
    const double step = s->level[l].step;
    const double area =
        step * step * gp_projection_solid(&s->p.projection, at[0], at[1]);
    const double side = gp_sky_ellipse_at(&s->p.projection, at[0], at[1]).side;
    struct complex spectrum[SIDE][SIDE];
    double term[SIDE * SIDE], most = 0.0, square = 0.0;
    // all of the term
    const int n =
        gp_max(s->level[l].rx, s->level[l].ry) < SIDE / 4 ? SIDE / 2 : SIDE;
    const struct gp_metric m =
        gp_projection_metric(&s->p.projection, at[0], at[1]);
    for (int i = 0; i < n * n; i++) {
        const double x = (i % n - n / 2) * step, y = (i / n - n / 2) * step;
        const double from[2] = {at[0] - x, at[1] - y};
        term[i] = s->p.projection.rim > 0.0
                      ? flat_term(s, l, side, &m, x, y)
                      : gp_sky_term(s, l, false, at, from, side);
        term[i] *= area * fade(i % n, n) * fade(i / n, n);
    }
    find_spectrum(term, n, spectrum);
    struct gp_far_keeping keep[SIDE];
    for (int i = 0; i < n; i++)
        keep[i] = gp_far_keep_of(i, n);
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) {
            const double kept = keep[i].kept * keep[j].kept;
            const double eps =
                sqrt(fmax(keep[i].square * keep[j].square - kept * kept, 0.0));
            const double lost =
                gp_hypot(spectrum[j][i].re, spectrum[j][i].im) *
                (fabs(1.0 - kept * kept) + kept * eps + eps * eps);
            most = fmax(most, lost);
            square += lost * lost;
        }
    }
    const double by = last ? 2.0 : 1.0;
    return (struct errors) {by * most, by * sqrt(square) / (n * step)};
}

/* Those of all levels, of the first over the layer. */
static struct errors levels_error(const struct gp_sky *s, const double at[2])
{
    struct errors sum = {0.0, 0.0};
    for (int l = 1; l < s->levels; l++) {
        const struct errors e = level_error(s, l, at);
        sum.even += e.even * e.even;
        sum.lamp += e.lamp * e.lamp;
    }
    return (struct errors) {sqrt(sum.even) /
                                (s->spread + s->light.stays + s->p.stays),
                            sqrt(sum.lamp)};
}

/* The weights of a pixel, what stays in it among them, and how far those are apart
 * from them that are interpolated. w x h of each; `right` is owned. */
struct apart {
    double *right, *wrong;
    int w, h;
    double level[GP_SKY_LEVELS]; // of levels that have one weight a node
};

/* The errors at a place over the layer. */
static double error_at(const struct gp_sky *s, int x, int y,
                       const struct apart *a)
{
    const struct gp_projection *const p = &s->p.projection;
    const double at[2] = {x, y};
    const double soft = gp_sky_scale(s, 1, gp_sky_ellipse_at(p, x, y).side);
    double wrong = 0.0, right = 0.0, all = 0.0;
    for (int i = 0; i < a->w * a->h; i++) {
        const double from[2] = {x + i % a->w - a->w / 2,
                                y + i / a->w - a->h / 2};
        const double c = gp_projection_chord2(p, x, y, from[0], from[1]);
        const double v =
            a->right[i] + (i == a->w * a->h / 2 ? s->p.stays : 0.0);
        // with what levels add there
        const double more = gp_projection_solid(p, from[0], from[1]) *
                            gp_sky_soft(&s->light, soft, c);
        wrong += a->wrong[i] * a->wrong[i];
        right += v * v;
        all += (v + more) * (v + more);
    }
    a->right[a->w * a->h / 2] += s->single ? s->p.stays : 0.0;
    if (s->single) // its near weights are what others leave
        return sqrt(wrong / all) +
               gp_sky_single_error(s, at, gp_sky_ellipse_at(p, x, y).side,
                                   a->level, a->right);
    const struct errors e = levels_error(s, at);
    return sqrt(wrong / right) + fmax(e.even, e.lamp / sqrt(all));
}

static gp_status find_apart(const struct gp_log *log, const struct gp_sky *s,
                            int x, int y, struct apart *out)
{
    const struct gp_sky_level *const g = &s->level[0];
    const int n = g->block == 1 ? 1 : g->rows, first = y - y % n;
    const int count = gp_min(n, s->p.h - first), block = x / g->block;
    struct apart a = {.w = 2 * g->rx + 1, .h = 2 * g->ry + 1};
    const size_t all = (size_t) a.w * (size_t) a.h, middle = all / 2;
    const double side = gp_sky_ellipse_at(&s->p.projection, x, y).side;
    float *scratch = NULL, *right = NULL, own, factor[GP_SKY_BAND] = {1.0f};
    struct gp_sky_weights w;
    gp_status st;
    GP_TRY(gp_alloc(log, "bound", gp_sky_weights_room(s, g), sizeof *scratch,
                    &scratch));
    GP_TRY(gp_alloc_zero(log, "bound", g->size, sizeof *right, &right));
    GP_TRY(gp_alloc(log, "bound", 2 * all, sizeof *a.right, &a.right));
    a.wrong = a.right + all;
    (void) gp_sky_weights_open(s, 0, first, count, scratch, &w);
    gp_sky_find_block(&w, g->block == 1 ? gp_max(block - 1, 0) : block);
    if (g->block > 1)
        gp_sky_find_factors(&w, block, count, factor);
    const double place[2] = {x, y};
    if (s->single)
        gp_sky_single_fit(s, place, side, a.level);
    const double stays =
        s->single
            ? gp_sky_single_pixels(s, place, a.level, side, a.right, right)
            : gp_sky_weigh_pixels(s, place, side, a.right, right);
    gp_sky_own(s, s->p.w, s->p.h, y, &(int32_t) {x}, 1, &own);
    const float lane = (float) (g->block == 1 ? block > 0 : x % g->block);
    for (size_t i = 0; i < all; i++) {
        const size_t row = i / (size_t) a.w, column = i % (size_t) a.w;
        const size_t at = row * w.pitch + GP_SKY_PAD + column;
        const float made =
            factor[y - first] * gp_sky_weight_at(&w, at, lane, y - first);
        a.right[i] = (double) right[row * g->pitch + column];
        a.wrong[i] = (double) made - a.right[i];
    }
    a.right[middle] = stays;
    a.wrong[middle] = (double) own + s->facts.given - stays;
    *out = a;
    a.right = NULL;
out:
    gp_free(a.right);
    gp_free(scratch);
    gp_free(right);
    return st;
}

static const double SURE = 1.5;    // between the places that are looked at
static const double TABLES = 4e-5; // of curves, means and roundings

void gp_sky_error_of_sphere(struct gp_sky *s)
{
    const double at[2] = {0.0, s->p.projection.y0};
    s->facts.relative = SURE * levels_error(s, at).even + TABLES;
}

gp_status gp_sky_error_find(const struct gp_log *log, struct gp_sky *s)
{
    gp_status st = GP_OK;
    for (int i = 0; i < 4 && !st; i++) { // middle, right, lower, corner
        double at[2] = {i & 1 ? s->p.w - 1 : s->p.w / 2,
                        i & 2 ? s->p.h - 1 : s->p.h / 2};
        gp_projection_pull(&s->p.projection, 0.0, at);
        const int x = (int) at[0], y = (int) at[1];
        struct apart a;
        st = find_apart(log, s, x, y, &a);
        if (st)
            break;
        s->facts.relative = fmax(s->facts.relative, error_at(s, x, y, &a));
        gp_free(a.right);
    }
    s->facts.relative = SURE * s->facts.relative + TABLES;
    return st;
}
