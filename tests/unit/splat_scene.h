/* Made-up light and kernels, and the glare they make as a plain sum in double:
 * what the splat engine is tested against. */
#ifndef GP_TESTS_SPLAT_SCENE_H
#define GP_TESTS_SPLAT_SCENE_H

#include "core/frame.h"
#include "glare/engine.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t seed;

static inline float uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float) (seed >> 8) * 0x1p-24f;
}

/* -- light ----------------------------------------------------------------- */

/* FAINT light is near the smallest that float has whole, UNDER is below it. */
enum light { EVERY, NONE, CORNERS, FEW, MANY, HOT, EQUAL, FAINT, UNDER };

static inline bool is_lit(enum light light, int i, int w, int h)
{
    int x = i % w, y = i / w;
    switch (light) {
    case EVERY:
    case EQUAL:
        return true;
    case NONE:
        return false;
    case CORNERS:
        return (x == 0 || x == w - 1) && (y == 0 || y == h - 1);
    case FEW:
    case HOT:
        return i % 97 == 13 || i == w * h / 2;
    case MANY:
    case FAINT:
    case UNDER:
        break;
    }
    return uniform() < 0.3f;
}

static inline float lit_value(enum light light, int i, int w, int h)
{
    if (light == EQUAL)
        return 1.1f;
    if (light == FAINT || light == UNDER)
        return (light == FAINT ? 1e-35f : 1e-40f) * (1.0f + uniform());
    if (light == HOT)
        return i == w * h / 2 ? 1e9f : 1e-3f * uniform();
    return i % 5 == 0 ? 65504.0f * uniform() : 1.0f + uniform();
}

static inline struct gp_sources make_sources(int w, int h, enum light light)
{
    struct gp_sources s = {.w = w, .h = h, .box = {w, h, 0, 0},
                           .luminance = {0.2126f, 0.7152f, 0.0722f}};
    size_t pixels = (size_t) w * (size_t) h;
    s.row = calloc((size_t) h + 1, sizeof *s.row);
    s.x = calloc(pixels, sizeof *s.x);
    for (int c = 0; c < 3; c++)
        s.rgb[c] = calloc(pixels, sizeof(float));
    for (int i = 0; i < w * h; i++) {
        int x = i % w, y = i / w;
        if (is_lit(light, i, w, h)) {
            for (int c = 0; c < 3; c++)
                s.rgb[c][s.n] = i % 11 == c ? 0.0f
                                            : lit_value(light, i, w, h);
            for (int c = 0; c < 3; c++)
                s.flux[c] += (double) s.rgb[c][s.n];
            s.x[s.n++] = x;
            s.box.x0 = x < s.box.x0 ? x : s.box.x0;
            s.box.y0 = y < s.box.y0 ? y : s.box.y0;
            s.box.x1 = x >= s.box.x1 ? x + 1 : s.box.x1;
            s.box.y1 = y + 1;
        }
        s.row[y + 1] = (uint32_t) s.n;
    }
    return s;
}

static inline void free_sources(struct gp_sources *s)
{
    free(s->row);
    free(s->x);
    for (int c = 0; c < 3; c++)
        free(s->rgb[c]);
}

/* -- kernels --------------------------------------------------------------- */

enum shape { PEAK, BOX, LOBES, HOLES };

static inline void find_norms(struct gp_kernel *k)
{
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, norm1 = 0.0, squares = 0.0;
        for (int i = 0; i < k->w * k->h; i++) {
            const double v = (double) k->k.c[c][i];
            sum += v;
            norm1 += fabs(v);
            k->negative |= v < 0.0;
            squares += v * v;
        }
        k->sum[c] = sum;
        k->norm1[c] = norm1;
        k->norm2[c] = sqrt(squares);
    }
}

static inline void fill_kernel(struct gp_kernel *k, enum shape shape)
{
    for (int i = 0; i < k->w * k->h; i++) {
        double dx = i % k->w - k->w / 2, dy = i / k->w - k->h / 2;
        for (int c = 0; c < 3; c++) {
            double v = 1.0 / (1.0 + 0.1 * (c + 1) * (dx * dx + dy * dy));
            if (shape == BOX)
                v = 0.1;
            else if (shape == LOBES)
                v = cos(0.7 * dx) * cos(0.4 * dy) * v;
            else if (shape == HOLES)
                v = (i + c) % 3 ? 0.0 : (double) uniform();
            k->k.c[c][i] = (float) v;
        }
    }
    find_norms(k);
}

static inline struct gp_kernel make_kernel(int w, int h, int cx, int cy,
                                           enum shape shape)
{
    struct gp_kernel k = {.w = w, .h = h, .cx = cx, .cy = cy};
    if (gp_planes_make(NULL, "kernel", (size_t) w * (size_t) h, &k.k))
        abort();
    fill_kernel(&k, shape);
    return k;
}

/* -- the engine ------------------------------------------------------------ */

static char last_line[4096];

static inline void keep(void *user, enum gp_level level, const char *line)
{
    (void) user;
    (void) level;
    snprintf(last_line, sizeof last_line, "%s", line);
}

static const struct gp_log log_kept = {keep, NULL, GP_LEVEL_INFO};

static struct gp_glare_stats stats; // of the last run
static struct gp_splat_params how = GP_SPLAT_EXACT; // of the next

static inline gp_status splat(enum gp_gl_api gl,
                              const struct gp_sources *src,
                              const struct gp_kernel *k,
                              struct gp_planes *layer, void **state)
{
    const struct gp_glare_params params = {.engine = "splat", .gain = 1.0f,
                                           .gl = gl, .splat = how};
    const struct gp_glare_job job = {.log = &log_kept, .params = &params,
                                     .src = src, .kernel = k, .layer = layer,
                                     .stats = &stats};
    size_t samples = (size_t) src->w * (size_t) src->h;
    stats = (struct gp_glare_stats) {0};
    if (gp_planes_make(NULL, "layer", samples, layer))
        abort();
    for (int c = 0; c < 3; c++) // every sample must be written
        memset(layer->c[c], 0xff, samples * sizeof(float));
    return gp_engine_splat.run(&job, state);
}

/* -- the sum --------------------------------------------------------------- */

static inline void add_source(const struct gp_sources *src,
                              const struct gp_kernel *k, int sx, int sy,
                              float value, int c, double *sum)
{
    for (int y = 0; y < k->h; y++) {
        long long py = (long long) sy + y - k->cy;
        if (py < 0 || py >= src->h)
            continue;
        for (int x = 0; x < k->w; x++) {
            long long px = (long long) sx + x - k->cx;
            if (px >= 0 && px < src->w)
                sum[py * src->w + px] += (double) value *
                                         (double) k->k.c[c][y * k->w + x];
        }
    }
}

/* rel_l2 of a layer against the sum in double; 0 when both are all 0. */
static inline double rel_l2(const struct gp_sources *src,
                            const struct gp_kernel *k,
                            const struct gp_planes *layer)
{
    size_t samples = (size_t) src->w * (size_t) src->h;
    double wrong = 0.0, all = 0.0;
    for (int c = 0; c < 3; c++) {
        double *sum = calloc(samples, sizeof *sum);
        for (int y = 0; y < src->h; y++) {
            for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
                add_source(src, k, src->x[i], y, src->rgb[c][i], c, sum);
        }
        for (size_t i = 0; i < samples; i++) {
            double d = (double) layer->c[c][i] - sum[i];
            wrong += d * d;
            all += sum[i] * sum[i];
        }
        free(sum);
    }
    if (all == 0.0)
        return wrong == 0.0 ? 0.0 : INFINITY;
    return sqrt(wrong / all);
}

#endif
