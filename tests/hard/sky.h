// SPDX-License-Identifier: Apache-2.0
/* The sky of a hard case: its sun, the depth and mask that hide it with the
 * truth of which pixels do, and its plain share that shows. */
#ifndef GP_TESTS_HARD_SKY_H
#define GP_TESTS_HARD_SKY_H

#include "cases.h"
#include "sun/occluder.h"

enum { WITH_DEPTH = 1, WITH_MASK = 2, PLANES = 4 };

/* A frame whose planes cover the data window. */
struct hard_sky {
    struct gp_rect data;
    float *depth, *mask;
    bool *surface;        // the truth of depth
    enum glarepp_depth type;
    struct gp_plane plane[2];
};

// -- planes -------------------------------------------------------------------

static inline uint32_t hard_hash_of(int x, int y)
{
    uint32_t h = (uint32_t) x * 2654435761u ^ (uint32_t) y * 2246822519u;
    h = (h ^ h >> 15) * 3266489917u;
    return h ^ h >> 13;
}

/* A depth sample: of a surface at distance d in [5, 25), or of none. */
static inline float hard_depth_value(enum hard_depth kind, bool surface,
                                     double d, uint32_t h)
{
    static const float none[] = {
        [DEPTH_ZERO] = 0.0f, [DEPTH_INF] = INFINITY, [DEPTH_NAN] = NAN,
        [DEPTH_1E10] = 1e10f, [DEPTH_RAY] = 1e10f, [DEPTH_HALF_MAX] = 65504.0f,
        [DEPTH_NEGATIVE] = 0.0f, [DEPTH_INVERSE] = 0.0f, [DEPTH_0_TO_1] = 1.0f,
        [DEPTH_1_TO_0] = 0.0f, [DEPTH_ALL_NEAR] = 0.0f, // has none
    };
    static const float mixed[] = {1e10f, INFINITY, NAN, 0.0f, 65504.0f, -NAN};
    const float share = (float) (d / 30.0); // of the way to the far plane
    if (!surface)
        return kind == DEPTH_MIXED ? mixed[h % (sizeof mixed / sizeof *mixed)]
                                   : none[kind];
    return kind == DEPTH_NEGATIVE  ? (float) -d
           : kind == DEPTH_INVERSE ? (float) (1.0 / d)
           : kind == DEPTH_0_TO_1  ? share
           : kind == DEPTH_1_TO_0  ? 1.0f - share : (float) d;
}

static inline enum glarepp_depth hard_type_of(enum hard_depth kind)
{
    return kind == DEPTH_INVERSE                          ? GLAREPP_INVERSE
           : kind == DEPTH_RAY                            ? GLAREPP_RAY
           : kind == DEPTH_0_TO_1 || kind == DEPTH_1_TO_0 ? GLAREPP_NORMALIZED
                                                          : GLAREPP_Z;
}

static inline float hard_mask_value(uint32_t h)
{
    const float odd[] = {NAN, -1.0f, 3.0f, INFINITY, -INFINITY, 1e-41f};
    return h % 16 < 6 ? odd[h % 16] : h % 16 < 9 ? 0.0f
           : h % 16 < 12 ? 1.0f : (float) (h >> 8) * 0x1p-24f;
}

static inline struct hard_sky hard_sky_make(const struct hard_case *h)
{
    const size_t n = (size_t) h->w * (size_t) h->h;
    struct hard_sky s = {.data = {h->x0, h->y0, h->x0 + h->w, h->y0 + h->h}};
    s.depth = scene_alloc(n, sizeof *s.depth);
    s.mask = scene_alloc(n, sizeof *s.mask);
    s.surface = scene_alloc(n, sizeof *s.surface);
    s.type = hard_type_of(h->depth);
    const int seed = (int) (hard_own(h) >> 12); // the row's own blocks
    for (int i = 0; i < h->w * h->h; i++) {
        const int x = i % h->w, y = i / h->w;
        const uint32_t block = hard_hash_of(x / 3 + seed, y / 3);
        const double d = 5.0 + 20.0 * (block >> 8) * 0x1p-24;
        s.surface[i] = h->depth == DEPTH_ALL_NEAR || block % 5 < 2;
        s.depth[i] = hard_depth_value(h->depth, s.surface[i], d,
                                      hard_hash_of(y, x));
        s.mask[i] = hard_mask_value(hard_hash_of(x + 7 + seed, y));
    }
    s.plane[0] = (struct gp_plane) {.window = s.data, .v = s.depth};
    s.plane[1] = (struct gp_plane) {.window = s.data, .v = s.mask};
    return s;
}

static inline void hard_sky_free(struct hard_sky *s)
{
    free(s->depth);
    free(s->mask);
    free(s->surface);
}

/* Both windows together. */
static inline struct gp_rect hard_frame_of(const struct hard_case *h,
                                           struct gp_rect data)
{
    const struct gp_rect shown = {0, 0, h->w, h->h};
    const struct gp_rect d = gp_rect_empty(h->display) ? shown : h->display;
    return (struct gp_rect) {
        d.x0 < data.x0 ? d.x0 : data.x0, d.y0 < data.y0 ? d.y0 : data.y0,
        d.x1 > data.x1 ? d.x1 : data.x1, d.y1 > data.y1 ? d.y1 : data.y1,
    };
}

// -- plain sums ---------------------------------------------------------------

/* The share of a sun beyond everything that a pixel shows. */
static inline double hard_plain_show(const struct hard_sky *s, int planes,
                                     int x, int y)
{
    if (x < s->data.x0 || x >= s->data.x1 || y < s->data.y0 || y >= s->data.y1)
        return 1.0;
    const size_t i = (size_t) (y - s->data.y0) *
                         (size_t) gp_rect_w(s->data) +
                     (size_t) (x - s->data.x0);
    const double m = fmin(fmax((double) s->mask[i], 0.0), 1.0);
    if (planes == WITH_DEPTH)
        return s->surface[i] ? 0.0 : 1.0;
    return planes ? 1.0 - m : 1.0; // with both, a surface and nothing alike
}

/* Pixels of the frame that the box around a light reaches. */
static inline struct gp_rect hard_box_of(struct gp_rect frame,
                                         const struct gp_light *l)
{
    const double r = fmax(l->radius, 0.0) + 2.0;
    if (!(l->x + r > frame.x0 && l->x - r < frame.x1 && l->y + r > frame.y0 &&
          l->y - r < frame.y1))
        return (struct gp_rect) {0, 0, 0, 0};
    return (struct gp_rect) {
        (int) floor(fmax(l->x - r, frame.x0)),
        (int) floor(fmax(l->y - r, frame.y0)),
        (int) ceil(fmin(l->x + r, frame.x1)),
        (int) ceil(fmin(l->y + r, frame.y1)),
    };
}

/* The share of a light that shows, by the area of each pixel under its disc. */
static inline double hard_plain_share(const struct hard_sky *s, int planes,
                                      struct gp_rect frame, int outside,
                                      const struct gp_light *l)
{
    const double r = fmax(l->radius, 1e-3);
    const struct gp_rect box = hard_box_of(frame, l);
    double area = 0.0, shown = 0.0;
    for (int y = box.y0; y < box.y1; y++) {
        for (int x = box.x0; x < box.x1; x++) {
            const double a = gp_light_pixel_area(l, r, x, y);
            area += a;
            shown += a * hard_plain_show(s, planes, x, y);
        }
    }
    const double rest = fmax(M_PI * r * r - area, 0.0);
    if (outside != (int) GLAREPP_IGNORE)
        area += rest;
    if (outside == (int) GLAREPP_VISIBLE)
        shown += rest;
    return area > 0.0 ? shown / area : 0.0;
}

static inline struct gp_light hard_light_of(const struct hard_case *h)
{
    struct gp_light l = GP_LIGHT_DEFAULTS;
    const bool given = h->sun[2] > 0.0;
    l.x = h->x0 + (given ? h->sun[0] : 0.5 * h->w);
    l.y = h->y0 + (given ? h->sun[1] : 0.5 * h->h);
    l.radius = given ? h->sun[2] : (h->w < h->h ? h->w : h->h) / 3.0;
    return l;
}

#endif
