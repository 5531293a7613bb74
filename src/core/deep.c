// SPDX-License-Identifier: Apache-2.0
#include "core/deep.h"

#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>
#include <stdlib.h>

/* Optical depth of an alpha under 1. */
static double depth_of(double alpha)
{
    return alpha > 1e-8 ? -gp_log(1.0 - alpha) : alpha;
}

static double alpha_of(double depth)
{
    return depth > 1e-8 ? 1.0 - gp_exp(-depth) : depth;
}

double gp_deep_clear(const struct gp_deep *d, int x, int y, double depth)
{
    const struct gp_rect w = d->window;
    if (x < w.x0 || x >= w.x1 || y < w.y0 || y >= w.y1)
        return 1.0;
    const int64_t at =
        ((int64_t) y - w.y0) * gp_rect_w(w) + ((int64_t) x - w.x0);
    double clear = 1.0;
    for (int64_t i = d->first[at]; i < d->first[at + 1]; i++) {
        const double a = (double) gp_clamp01(d->alpha[i]);
        const double z = (double) d->z[i];
        const double back = d->back ? (double) d->back[i] : z;
        if (!(z < depth))
            continue;
        if (back > depth) // the part before it
            clear *=
                a < 1.0 ? gp_exp(-depth_of(a) * (depth - z) / (back - z)) : 0.0;
        else
            clear *= 1.0 - a;
    }
    return clear;
}

// -- flattening -----------------------------------------------------------------

/* Sums over samples that are merged, or per unit of depth over volumes. */
struct sums {
    double depth, light[3]; // of those under alpha 1: optical depth; light
    double wall[3];         // light of those of alpha 1
    int walls, some;        // of which so many, and of all
};

static void add(struct sums *s, const struct sums *t, int sign)
{
    s->depth += sign * t->depth;
    for (int c = 0; c < 3; c++) {
        s->light[c] += sign * t->light[c];
        s->wall[c] += sign * t->wall[c];
    }
    s->walls += sign * t->walls;
    s->some += sign * t->some;
    if (!s->some) // no rest of rounding
        *s = (struct sums) {0};
}

/* A place where the samples before the eye change. */
struct event {
    double at;
    enum { END, SURFACE, START } kind; // in this order at one place
    int64_t sample;
    struct sums sums;
};

static int by_place(const void *a, const void *b)
{
    const struct event *const x = a, *const y = b;
    const int place = (x->at > y->at) - (x->at < y->at);
    const int kind = (x->kind > y->kind) - (x->kind < y->kind);
    return place  ? place
           : kind ? kind
                  : (x->sample > y->sample) - (x->sample < y->sample);
}

/* Writes the events of a sample, up to two; returns how many. */
static int events_of(const struct gp_deep *d, int64_t i, struct event *to)
{
    const double a = (double) gp_clamp01(d->alpha[i]), z = (double) d->z[i];
    const double back = d->back ? (double) d->back[i] : z;
    const bool volume = back > z && isfinite(back - z);
    const double part = volume ? 1.0 / (back - z) : 1.0;
    struct event e = {z, volume ? START : SURFACE, i, {.some = 1}};
    if (isnan(z))
        return 0;
    e.sums.walls = a >= 1.0;
    e.sums.depth = a < 1.0 ? part * depth_of(a) : 0.0;
    for (int c = 0; c < 3; c++) {
        const double v = (double) d->colour[c][i];
        if (a >= 1.0)
            e.sums.wall[c] = v;
        else // its light in a part goes as the part's alpha
            e.sums.light[c] = v * part * (a > 0.0 ? depth_of(a) / a : 1.0);
    }
    to[0] = e;
    e.at = back;
    e.kind = END;
    to[1] = e;
    return volume ? 2 : 1;
}

/* A pixel as far as it is laid: light of three channels, and what still shows. */
struct laid {
    double light[3], clear;
};

/* Lays merged samples, of volumes over `length`, under a pixel. */
static void lay(struct laid *p, const struct sums *s, double length)
{
    const double depth = s->depth * length;
    const double alpha = s->walls ? 1.0 : alpha_of(depth);
    const double share = depth > 0.0 ? alpha / depth : 1.0;
    for (int c = 0; c < 3; c++)
        p->light[c] += p->clear * (s->walls ? s->wall[c] / s->walls
                                            : s->light[c] * length * share);
    p->clear *= 1.0 - alpha;
}

struct flattening {
    const struct gp_deep *deep;
    const struct gp_planes *out;
    float *alpha;
    struct event *event; // of each thread, `room`
    size_t room;
};

static void flatten_row(void *ctx, int y, int thread)
{
    const struct flattening *const f = ctx;
    const struct gp_deep *const d = f->deep;
    const int64_t w = gp_rect_w(d->window);
    struct event *const event = f->event + (size_t) thread * f->room;
    for (int64_t at = y * w; at < (y + 1) * w; at++) {
        struct laid p = {.clear = 1.0};
        struct sums on = {0}; // volumes, and
        struct sums here;     // surfaces in one place
        size_t n = 0;
        for (int64_t i = d->first[at]; i < d->first[at + 1]; i++)
            n += (size_t) events_of(d, i, &event[n]);
        qsort(event, n, sizeof *event, by_place);
        for (size_t i = 0; i < n && p.clear > 0.0; i++) {
            const struct event *const e = &event[i];
            if (i && on.some && e->at > e[-1].at)
                lay(&p, &on, e->at - e[-1].at);
            if (e->kind != SURFACE) {
                add(&on, &e->sums, e->kind == START ? 1 : -1);
                continue;
            }
            here = e->sums;
            while (i + 1 < n && event[i + 1].kind == SURFACE &&
                   !(event[i + 1].at > e->at))
                add(&here, &event[++i].sums, 1);
            lay(&p, &here, 1.0);
        }
        for (int c = 0; c < 3; c++)
            f->out->c[c][at] = (float) p.light[c];
        if (f->alpha)
            f->alpha[at] = (float) (1.0 - p.clear);
    }
}

gp_status gp_deep_flatten(const struct gp_log *log, const struct gp_deep *d,
                          const struct gp_planes *out, float *alpha)
{
    struct flattening f = {d, out, alpha, NULL, 1};
    const int64_t pixels =
        (int64_t) gp_rect_w(d->window) * gp_rect_h(d->window);
    for (int64_t i = 0; i < pixels; i++) {
        const size_t n = (size_t) (d->first[i + 1] - d->first[i]);
        f.room = 2 * n > f.room ? 2 * n : f.room;
    }
    const gp_status st =
        gp_alloc(log, "deep samples", f.room,
                 (size_t) gp_threads() * sizeof *f.event, &f.event);
    if (!st)
        gp_parallel_do(gp_rect_h(d->window), flatten_row, &f);
    gp_free(f.event);
    return st;
}
