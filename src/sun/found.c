// SPDX-License-Identifier: Apache-2.0
#include "sun/found.h"

#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"

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
};

struct blob {
    struct gp_rect box;
    uint32_t root;
    double light; // luminance, of its sources
};

struct finding {
    const struct gp_sources *src;
    const struct gp_image *f;
    struct run *run;   // owned
    uint32_t *row;     // owned; runs of row y: [row[y], row[y + 1])
    struct blob *blob; // owned
    uint32_t blobs;
};

// -- blobs --------------------------------------------------------------------

/* Lists the runs of all rows. */
static gp_status list_runs(const struct gp_log *log, struct finding *d)
{
    const struct gp_sources *const s = d->src;
    size_t n = 0;
    gp_status st = gp_alloc(log, "runs of bright pixels", (size_t) s->h + 1,
                            sizeof *d->row, &d->row);
    for (int y = 0; y < s->h && !st; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++)
            n += i == s->row[y] || s->x[i] != s->x[i - 1] + 1;
    }
    if (!st)
        st = gp_alloc(log, "runs of bright pixels", n + 1, sizeof *d->run,
                      &d->run);
    if (st)
        return st;
    uint32_t k = 0;
    for (int y = 0; y < s->h; y++) {
        d->row[y] = k;
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            if (i == s->row[y] || s->x[i] != s->x[i - 1] + 1) {
                d->run[k] = (struct run) {s->x[i], s->x[i], y, k};
                k++;
            }
            d->run[k - 1].x1++;
        }
    }
    d->row[s->h] = k;
    return GP_OK;
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

static int by_light(const void *a, const void *b)
{
    const struct blob *const x = a, *const y = b;
    return x->light != y->light ? (x->light < y->light ? 1 : -1)
                                : (x->root > y->root) - (x->root < y->root);
}

/* Lists the blobs that are no larger than lights, the brightest first. */
static gp_status list_blobs(const struct gp_log *log, struct finding *d)
{
    const struct gp_sources *const s = d->src;
    const uint32_t runs = d->row[s->h];
    const int most = gp_max(gp_rect_h(d->f->display) / SIDE, 1);
    const gp_status st = gp_alloc_zero(log, "blobs", (size_t) runs + 1,
                                       sizeof *d->blob, &d->blob);
    if (st)
        return st;
    uint32_t i = 0, n = 0; // source, blobs that are kept
    for (uint32_t k = 0; k < runs; k++) {
        const struct run *const r = &d->run[k];
        struct blob *const b = &d->blob[root_of(d->run, k)];
        const struct gp_rect box = {r->x0, r->y, r->x1, r->y + 1};
        b->box = b->light > 0.0 ? gp_rect_join(b->box, box) : box;
        b->root = root_of(d->run, k);
        for (int x = r->x0; x < r->x1; x++, i++) {
            for (int c = 0; c < 3; c++)
                b->light += (double) s->luminance[c] * (double) s->rgb[c][i];
        }
    }
    for (uint32_t k = 0; k < runs; k++) {
        const struct blob *const b = &d->blob[k];
        if (b->light > 0.0 && gp_rect_w(b->box) <= most &&
            gp_rect_h(b->box) <= most)
            d->blob[n++] = *b;
    }
    qsort(d->blob, n, sizeof *d->blob, by_light);
    d->blobs = n < GP_FOUND_MOST ? n : GP_FOUND_MOST;
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
        const uint32_t first = d->row[gp_max(area.y0 - reach, 0)];
        const uint32_t end = d->row[gp_min(area.y1 + reach, d->src->h)];
        for (uint32_t k = first; k < end; k++) {
            const struct run *const r = &d->run[k];
            const int x0 = gp_max(r->x0 - reach, area.x0);
            const int x1 = gp_min(r->x1 + reach, area.x1);
            const int y1 = gp_min(r->y + reach + 1, area.y1);
            if (x0 >= x1 || (root_of(d->run, k) == b->root) != turn[i].own)
                continue;
            for (int y = gp_max(r->y - reach, area.y0); y < y1; y++)
                memset(at + (size_t) (y - area.y0) * (size_t) w +
                           (x0 - area.x0),
                       turn[i].as, (size_t) (x1 - x0));
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

/* Measures a blob as a light; `at` has room for its area. False: it is none. */
static bool measure(struct finding *d, const struct blob *b, unsigned char *at,
                    struct gp_light *out)
{
    static const double FADE = 0.5;        // of the threshold
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
    const double over =
        t > 0.0 ? fmax(0.0, fmin((own.peak - t) / (FADE * t), 1.0)) : 1.0;
    *out = (struct gp_light) GP_LIGHT_DEFAULTS;
    out->x = d->src->x0 + area.x0 + x;
    out->y = d->src->y0 + area.y0 + y;
    out->radius = sqrt(fmax(2.0 * moment, 0.0));
    for (int c = 0; c < 3; c++)
        out->flux[c] = (float) (over * over * (3.0 - 2.0 * over) *
                                fmax(own.light[c], 0.0));
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

/* Sorts lights by falling flux; of equal ones the first stays first. */
static void sort_lights(struct gp_light *light, int n, const float weight[3])
{
    for (int i = 1; i < n; i++) {
        const struct gp_light l = light[i];
        int k = i;
        for (; k > 0 &&
               luminance_of(&light[k - 1], weight) < luminance_of(&l, weight);
             k--)
            light[k] = light[k - 1];
        light[k] = l;
    }
}

gp_status gp_lights_find(const struct gp_log *log, const struct gp_sources *src,
                         const struct gp_image *f, struct gp_light **out,
                         int *n)
{
    struct finding d = {.src = src, .f = f};
    struct gp_light *light = NULL;
    unsigned char *at = NULL;
    size_t room = 1;
    gp_status st;
    *n = 0;
    *out = NULL;
    GP_TRY(list_runs(log, &d));
    join_runs(&d);
    GP_TRY(list_blobs(log, &d));
    for (uint32_t i = 0; i < d.blobs; i++) {
        const struct gp_rect b = d.blob[i].box;
        const size_t more = 2 * (SKIRT + RING);
        const size_t area =
            ((size_t) gp_rect_w(b) + more) * ((size_t) gp_rect_h(b) + more);
        room = area > room ? area : room;
    }
    GP_TRY(gp_alloc(log, "blobs", room, 1, &at));
    GP_TRY(gp_alloc(log, "lights", d.blobs + 1, sizeof *light, &light));
    for (uint32_t i = 0; i < d.blobs; i++)
        *n += measure(&d, &d.blob[i], at, &light[*n]);
    sort_lights(light, *n, src->luminance);
    *out = light;
out:
    gp_free(at);
    gp_free(d.run);
    gp_free(d.row);
    gp_free(d.blob);
    return st;
}

// -- names --------------------------------------------------------------------

/* Returns the distance of a light from one that is known; INFINITY: they are two. */
static double apart(const struct gp_light *l, const struct glarepp_light *k,
                    double height)
{
    static const double PLACE = 0.05, FAR_AWAY = 0.25, OCTAVES = 3.0;
    const double way = gp_hypot(l->x - k->at[0], l->y - k->at[1]) / height;
    const double own =
        (double) l->flux[0] + (double) l->flux[1] + (double) l->flux[2];
    const double old =
        (double) k->flux[0] + (double) k->flux[1] + (double) k->flux[2];
    const double octaves =
        own > 0.0 && old > 0.0 ? fabs(gp_log(own / old)) / M_LN2 : 0.0;
    // one that fades has little flux in its old place
    return way <= (octaves <= OCTAVES ? FAR_AWAY : PLACE)
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
        taken[p->known] = true;
    }
    gp_free(pair);
    return GP_OK;
}
