// SPDX-License-Identifier: Apache-2.0
#include "sun/found.h"

#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    SKIRT = 2, // pixels around a blob that are its light
    RING = 3,  // ... and around those its ground
    SIDE = 4,  // blobs are lights up to 1 of so many heights
};

/* Sources side by side in a row, and the first run that they touch. */
struct run {
    int x0, x1, y;
    uint32_t root;
    uint32_t first; // source
};

struct blob {
    struct gp_rect box;
    uint32_t root;
    double light; // luminance, of its sources
    bool wide;    // no light
};

struct finding {
    const struct gp_sources *src;
    const struct gp_image *f;
    struct run *run;   // owned
    uint32_t *row;     // owned; runs of row y: [row[y], row[y + 1])
    struct blob *blob; // owned; room for one a run
    float *bright;     // owned; luminance of each source, -INFINITY: of one
                       // in a blob that is a light
    struct blob best[GP_FOUND_MOST]; // the brightest first
    int blobs;
    bool wide; // a blob is
};

// -- blobs --------------------------------------------------------------------

/* Lists the runs of what is left of at least `level`. */
static gp_status list_runs(const struct gp_log *log, struct finding *d,
                           float level)
{
    const struct gp_sources *const s = d->src;
    gp_status st = GP_OK;
    GP_FREE(d->run);
    GP_FREE(d->blob);
    for (int pass = 0; pass < 2 && !st;
         pass++) { // counts them, then lists them
        uint32_t n = 0;
        for (int y = 0; y < s->h; y++) {
            bool open = false;
            d->row[y] = n;
            for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
                const bool bright = d->bright[i] >= level;
                const bool first =
                    bright && !(open && s->x[i] == s->x[i - 1] + 1);
                n += first;
                if (pass && first)
                    d->run[n - 1] =
                        (struct run) {s->x[i], s->x[i], y, n - 1, i};
                if (pass && bright)
                    d->run[n - 1].x1++;
                open = bright;
            }
        }
        d->row[s->h] = n;
        if (!pass)
            st = gp_alloc(log, "runs of bright pixels", (size_t) n + 1,
                          sizeof *d->run, &d->run);
    }
    return st;
}

static uint32_t root_of(struct run *run, uint32_t i)
{
    while (run[i].root != i) {
        run[i].root = run[run[i].root].root;
        i = run[i].root;
    }
    return i;
}

/* Joins runs that touch those of the row above; the first is the root. */
static void join_runs(struct finding *d)
{
    for (int y = 1; y < d->src->h; y++) {
        uint32_t above = d->row[y - 1];
        for (uint32_t i = d->row[y]; i < d->row[y + 1]; i++) {
            const struct run *const r = &d->run[i];
            while (above < d->row[y] && d->run[above].x1 < r->x0)
                above++;
            for (uint32_t k = above; k < d->row[y] && d->run[k].x0 <= r->x1;
                 k++) {
                const uint32_t a = root_of(d->run, k), b = root_of(d->run, i);
                d->run[a > b ? a : b].root = a > b ? b : a;
            }
        }
    }
}

/* Adds a blob to the brightest; of equal ones the first stays first. */
static void rank(struct finding *d, const struct blob *b)
{
    int at = d->blobs;
    if (at == GP_FOUND_MOST && d->best[at - 1].light >= b->light)
        return;
    at -= at == GP_FOUND_MOST;
    d->blobs = at + 1;
    for (; at > 0 && d->best[at - 1].light < b->light; at--)
        d->best[at] = d->best[at - 1];
    d->best[at] = *b;
}

/* Lists the brightest blobs that are no larger than lights, whose sources are done. */
static gp_status list_blobs(const struct gp_log *log, struct finding *d)
{
    const uint32_t runs = d->row[d->src->h];
    const int most = gp_max(gp_rect_h(d->f->display) / SIDE, 1);
    const gp_status st = gp_alloc_zero(log, "blobs", (size_t) runs + 1,
                                       sizeof *d->blob, &d->blob);
    if (st)
        return st;
    d->blobs = 0;
    d->wide = false;
    for (uint32_t k = 0; k < runs; k++) {
        struct run *const r = &d->run[k];
        const struct gp_rect box = {r->x0, r->y, r->x1, r->y + 1};
        r->root = root_of(d->run, k); // no root comes after its runs
        struct blob *const b = &d->blob[r->root];
        b->box = r->root < k ? gp_rect_join(b->box, box) : box;
        b->root = r->root;
    }
    for (uint32_t k = 0; k < runs; k++) {
        const struct run *const r = &d->run[k];
        struct blob *const b = &d->blob[r->root];
        b->wide = gp_rect_w(b->box) > most || gp_rect_h(b->box) > most;
        d->wide = d->wide || b->wide;
        for (int i = 0; i < r->x1 - r->x0 && !b->wide; i++) {
            b->light += (double) d->bright[r->first + (uint32_t) i];
            d->bright[r->first + (uint32_t) i] = -INFINITY;
        }
    }
    for (uint32_t k = 0; k < runs; k++) {
        if (d->run[k].root == k && !d->blob[k].wide)
            rank(d, &d->blob[k]);
    }
    return GP_OK;
}

// -- a blob's light -----------------------------------------------------------

/* Kinds of pixels around a blob. */
enum { FAR, GROUND, OTHER, OWN };

/* Marks those pixels of `area` that are up to some way from the blob's sources, or
 * from others', in turn. */
static void mark(struct finding *d, const struct blob *b, struct gp_rect area,
                 unsigned char *at)
{
    static const struct {
        int reach;
        bool own;
        unsigned char as;
    } turn[] = {
        {SKIRT + RING, true, GROUND},
        {SKIRT, false, OTHER},
        {SKIRT, true, OWN},
        {0, false, OTHER},
    };
    const int w = gp_rect_w(area);
    memset(at, FAR, (size_t) w * (size_t) gp_rect_h(area));
    for (int i = 0; i < 4; i++) {
        const int reach = turn[i].reach;
        const int last = gp_min(area.y1 + reach, d->src->h);
        for (int y = gp_max(area.y0 - reach, 0); y < last; y++) {
            const int y0 = gp_max(y - reach, area.y0) - area.y0;
            const int y1 = gp_min(y + reach + 1, area.y1) - area.y0;
            for (uint32_t k = d->row[y];
                 k < d->row[y + 1] && d->run[k].x0 - reach < area.x1; k++) {
                const struct run *const r = &d->run[k];
                const int x0 = gp_max(r->x0 - reach, area.x0) - area.x0;
                const int x1 = gp_min(r->x1 + reach, area.x1) - area.x0;
                const bool own = r->root == b->root;
                for (int v = y0; v < y1 && x0 < x1 && own == turn[i].own; v++)
                    memset(at + v * w + x0, turn[i].as, (size_t) (x1 - x0));
            }
        }
    }
}

/* Sums over pixels: of their light, by channel; of its luminance times 1, x, y,
 * and x^2 + y^2, from the area's corner. */
struct sums {
    double light[3], y[4], peak;
};

/* Adds up the pixels of a mark, each less `ground`. Returns how many there are. */
static long long add_up(const struct finding *d, struct gp_rect area,
                        const unsigned char *at, unsigned char as,
                        const double ground[3], struct sums *out)
{
    const int w = gp_rect_w(area);
    long long n = 0;
    *out = (struct sums) {.peak = 0.0};
    for (int i = 0; i < w * gp_rect_h(area); i++) {
        const double x = i % w + 0.5, y = i / w + 0.5;
        const size_t pixel = (size_t) (area.y0 + i / w) * (size_t) d->src->w +
                             (size_t) (area.x0 + i % w);
        double own = 0.0, all = 0.0;
        if (at[i] != as)
            continue;
        for (int c = 0; c < 3; c++) {
            const double v = (double) d->f->rgb.c[c][pixel];
            out->light[c] += v - ground[c];
            own += (double) d->src->luminance[c] * (v - ground[c]);
            all += (double) d->src->luminance[c] * v;
        }
        out->y[0] += own;
        out->y[1] += own * x;
        out->y[2] += own * y;
        out->y[3] += own * (x * x + y * y);
        out->peak = fmax(out->peak, all);
        n++;
    }
    return n;
}

/* Returns how much of a light there is, 0 to 1, on its way from `from` to `to`. */
static double fade(double v, double from, double to)
{
    return to > from ? gp_smoothstep((v - from) / (to - from)) : 1.0;
}

/* Measures a blob as a light, of a part of a wide one if `part`; `at` has room for
 * its area. False: it is none. */
static bool measure(struct finding *d, const struct blob *b, bool part,
                    unsigned char *at, struct gp_light *out)
{
    static const double FADE = 1.5;        // of the threshold, to all of it
    static const double OVER = 4.0;        // times its ground, 1.5 to all of it
    static const double PIXEL = 1.0 / 6.0; // second moment of a pixel
    static const double none[3] = {0.0, 0.0, 0.0};
    const int more = SKIRT + RING;
    const struct gp_rect area =
        gp_rect_meet((struct gp_rect) {b->box.x0 - more, b->box.y0 - more,
                                       b->box.x1 + more, b->box.y1 + more},
                     (struct gp_rect) {0, 0, d->src->w, d->src->h});
    struct sums ground, own;
    mark(d, b, area, at);
    const long long n = add_up(d, area, at, GROUND, none, &ground);
    for (int c = 0; c < 3 && n; c++)
        ground.light[c] /= (double) n;
    add_up(d, area, at, OWN, ground.light, &own);
    if (!(own.y[0] > 0.0))
        return false;
    const double x = own.y[1] / own.y[0], y = own.y[2] / own.y[0];
    const double moment = own.y[3] / own.y[0] - x * x - y * y - PIXEL;
    const double t = (double) d->src->threshold;
    double ground_light = 0.0;
    for (int c = 0; c < 3; c++)
        ground_light += (double) d->src->luminance[c] * ground.light[c];
    // the least that its brightest pixel would have, wherever in it the light is
    const double least = fmin(own.peak, own.y[0] / 4.0);
    const double over =
        fade(least, t, FADE * t) *
        (part ? fade(own.peak, OVER * ground_light, FADE * OVER * ground_light)
              : 1.0);
    *out = (struct gp_light) GP_LIGHT_DEFAULTS;
    out->x = d->src->x0 + area.x0 + x;
    out->y = d->src->y0 + area.y0 + y;
    out->radius = sqrt(fmax(2.0 * moment, 0.0));
    for (int c = 0; c < 3; c++)
        out->flux[c] = (float) (over * fmax(own.light[c], 0.0));
    out->found = out->in_frame = true;
    out->low = out->high = 1.0;
    return gp_light_has_flux(out);
}

static double luminance_of(const struct gp_light *l, const float weight[3])
{
    return (double) weight[0] * (double) l->flux[0] +
           (double) weight[1] * (double) l->flux[1] +
           (double) weight[2] * (double) l->flux[2];
}

/* Adds the lights among the blobs to a list that has room for them, by falling flux;
 * of equal ones the first stays first. */
static gp_status measure_all(const struct gp_log *log, struct finding *d,
                             bool part, struct gp_light *light, int *n)
{
    const float *const weight = d->src->luminance;
    unsigned char *at;
    size_t room = 1;
    for (int i = 0; i < d->blobs; i++) {
        const struct gp_rect b = d->best[i].box;
        const size_t more = 2 * (SKIRT + RING);
        const size_t area =
            ((size_t) gp_rect_w(b) + more) * ((size_t) gp_rect_h(b) + more);
        room = area > room ? area : room;
    }
    const gp_status st = gp_alloc(log, "blobs", room, 1, &at);
    for (int i = 0; i < d->blobs && !st; i++) {
        struct gp_light l;
        if (!measure(d, &d->best[i], part, at, &l))
            continue;
        int k = (*n)++;
        for (; k > 0 &&
               luminance_of(&light[k - 1], weight) < luminance_of(&l, weight);
             k--)
            light[k] = light[k - 1];
        light[k] = l;
    }
    gp_free(at);
    *n = gp_min(*n, GP_FOUND_MOST);
    return st;
}

gp_status gp_lights_find(const struct gp_log *log, const struct gp_sources *src,
                         const struct gp_image *f, struct gp_light **out,
                         int *n, bool *wide)
{
    const float *const weight = src->luminance;
    struct finding d = {.src = src, .f = f};
    struct gp_light *light = NULL;
    float level = src->threshold, from = -INFINITY;
    gp_status st;
    *n = 0;
    *wide = false;
    *out = NULL;
    GP_TRY(gp_alloc(log, "lights", 2 * (size_t) GP_FOUND_MOST, sizeof *light,
                    &light));
    GP_TRY(gp_alloc(log, "bright pixels", src->n, sizeof *d.bright, &d.bright));
    GP_TRY(gp_alloc(log, "runs of bright pixels", (size_t) src->h + 1,
                    sizeof *d.row, &d.row));
    for (size_t i = 0; i < src->n; i++)
        d.bright[i] = weight[0] * src->rgb[0][i] + weight[1] * src->rgb[1][i] +
                      weight[2] * src->rgb[2][i];
    for (;; from = level = fmaxf(4.0f * level, FLT_MIN)) {
        GP_TRY(list_runs(log, &d, from));
        join_runs(&d);
        GP_TRY(list_blobs(log, &d));
        GP_TRY(measure_all(log, &d, from > 0.0f, light, n));
        *wide = *wide || d.wide;
        if (!d.wide || level > FLT_MAX / 4.0f)
            break;
    }
    *out = light;
    light = NULL;
out:
    gp_free(light);
    gp_free(d.run);
    gp_free(d.row);
    gp_free(d.blob);
    gp_free(d.bright);
    return st;
}

// -- names --------------------------------------------------------------------

int gp_lights_at(const struct glarepp_light *track, int n, double frame,
                 struct glarepp_light *out)
{
    int lights = 0;
    for (int i = 0, end; i < n; i = end) {
        for (end = i + 1;
             end < n && strcmp(track[end].name, track[i].name) == 0;)
            end++;
        int k = i; // the last that is not after the frame, but one
        while (k + 2 < end && track[k + 1].at[2] <= frame)
            k++;
        const struct glarepp_light *const a = &track[k];
        const struct glarepp_light *const b = &track[k + 1 < end ? k + 1 : k];
        const double way = b->at[2] - a->at[2];
        const double t =
            way > 0.0 ? fmax(0.0, fmin((frame - a->at[2]) / way, 1.0)) : 0.0;
        out[lights] = *a;
        for (int c = 0; c < 2; c++)
            out[lights].at[c] += t * (b->at[c] - a->at[c]);
        lights++;
    }
    return lights;
}

/* Returns the distance of a light from one that is known; INFINITY: they are two. */
static double apart(const struct gp_light *l, const struct glarepp_light *k,
                    double height)
{
    static const double PLACE = 0.05, FAR_AWAY = 0.25, OCTAVES = 3.0;
    const double way = gp_hypot(l->x - k->at[0], l->y - k->at[1]) / height;
    const double own =
        (double) fmaxf(l->flux[0], fmaxf(l->flux[1], l->flux[2]));
    const double old =
        (double) fmaxf(k->flux[0], fmaxf(k->flux[1], k->flux[2]));
    double octaves = 0.0; // of all channels, so that colours tell lamps apart
    for (int c = 0; c < 3 && own > 0.0 && old > 0.0; c++) {
        const double part = gp_log(((double) l->flux[c] + 0.01 * own) /
                                   ((double) k->flux[c] + 0.01 * old)) /
                            M_LN2;
        octaves = gp_hypot(octaves, part);
    }
    // one that fades has little flux in its old place
    return way <= (octaves <= OCTAVES * sqrt(3.0) ? FAR_AWAY : PLACE)
               ? gp_hypot(way / PLACE, octaves)
               : INFINITY;
}

struct pair {
    double apart;
    int light, known;
};

static int by_distance(const void *a, const void *b)
{
    const struct pair *const x = a, *const y = b;
    return x->apart != y->apart   ? (x->apart > y->apart ? 1 : -1)
           : x->light != y->light ? x->light - y->light
                                  : x->known - y->known;
}

gp_status gp_lights_name(const struct gp_log *log, struct gp_light *light,
                         int n, const struct glarepp_light *known, int knowns,
                         double height)
{
    bool taken[GP_LIGHTS_MAX] = {false};
    struct pair *pair;
    size_t pairs = 0;
    const gp_status st =
        gp_alloc(log, "names of lights", (size_t) n * (size_t) knowns + 1,
                 sizeof *pair, &pair);
    if (st)
        return st;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < knowns; k++) {
            const double d = apart(&light[i], &known[k], height);
            if (d < INFINITY)
                pair[pairs++] = (struct pair) {d, i, k};
        }
    }
    qsort(pair, pairs, sizeof *pair, by_distance);
    for (const struct pair *p = pair; p < pair + pairs; p++) {
        struct gp_light *const l = &light[p->light];
        if (taken[p->known] || l->name[0])
            continue;
        memcpy(l->name, known[p->known].name, sizeof l->name);
        for (int c = 0; c < 3; c++)
            l->flux[c] *= known[p->known].gain[c];
        taken[p->known] = true;
    }
    gp_free(pair);
    return GP_OK;
}
