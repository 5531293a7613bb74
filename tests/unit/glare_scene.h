// SPDX-License-Identifier: Apache-2.0
/* Frames, sources, kernels and their exact layer, made up for the engines'
 * tests. Everything comes from a seed; nothing is read from a file. */
#ifndef GP_TESTS_GLARE_SCENE_H
#define GP_TESTS_GLARE_SCENE_H

#include "core/colour.h"
#include "glare/engine.h"
#include "glare/sources.h"
#include "hash.h"
#include "kept_log.h"
#include "model_scene.h"
#include "unit.h"

#include <float.h>
#include <limits.h>

/* Light of frames. Backgrounds are in (0.05, 0.8), under a threshold of 1. */
enum light {
    DARK,     // background alone
    ALL,      // every pixel bright
    FEW,      // one pixel in 83, up to 65504
    MANY,     // three in ten, up to 65504, some without a channel
    CORNERS,  // four sources
    MIDDLE,   // FEW, but none near the border
    HOT,      // one pixel of 1e9 in a frame of 1e-3
    BAD,      // FEW with NaN, Inf, denormals and negative light among them
    DENORMAL, // nothing over 1e-39
    EDGE,     // values at 1, one step over, one step under
    RAMP,     // luminance from 0 to 2, every pixel another
    COLOURED, // FEW, each source in one channel
    BLOCK,    // 33 x 33 bright pixels in the middle, no other
    CANCEL,   // every other pixel as negative as its neighbour is bright
    FLAT,     // 2 everywhere
    EQUAL,    // 1.1 everywhere: all roundings go one way
    BLACK,    // 0 everywhere
    FAINT,    // three in ten near the smallest that counts, else 0
    OVER,     // around and far over what a half can hold
    ENDS,     // around the ends of half's range and those of its denormals
};

enum shape {
    PEAK,   // bright centre, long tail
    TINTED, // PEAK, another one a channel
    BOX,
    RAYS,   // straight and oblique ones over a short tail
    SPECKS, // random, few of them large
    HOLES,  // every third sample, another one a channel
    RING,   // dark within 4/5 of its radius
    LOBES,  // negative ones
    SLANT,  // even about its centre, and not from side to side
    BORDER, // PEAK with zeros around it, more on the left and the top
    DIPOLE, // 1 in its left half and -1 in its right one, not normalised
};

/* Sensors that take the whole colour of a pixel over t. */
#define WHOLE(t, k, most)                                                     \
    { .threshold = (t), .knee = (k), .max_value = (most),                     \
      .whole = true }
static const struct glarepp_sense_params usual = GLAREPP_SENSE_PARAMS;
static const struct glarepp_sense_params open_all = WHOLE(0.0f, 0.0f, 1e30f);

struct scene {
    struct gp_image f;
    struct gp_sources src;
    struct gp_kernel k;
    double *exact; // 3 * w * h
};

/* In [0, 1); the generator of Numerical Recipes, its upper bits. */
static inline float scene_random(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (float) (*seed >> 8) * 0x1p-24f;
}

/* In [0, 1), the same for the same i; the mixing of MurmurHash3. */
static inline float scene_noise(int i)
{
    uint32_t h = 0x85ebca6bu * (uint32_t) (i + 1);
    h = 0xc2b2ae35u * (h ^ h >> 13);
    return (float) ((h ^ h >> 16) >> 8) * 0x1p-24f;
}

static inline void *scene_alloc(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size);
    if (!p)
        abort();
    return p;
}

static inline void assert_close(double got, double want, double relative)
{
    if (!(fabs(got - want) <= relative * fabs(want)))
        fail_msg("%.15g, not %.15g within %g of it", got, want, relative);
}

/* -- light ------------------------------------------------------------------*/

static inline int scene_is_lit(enum light light, int x, int y, int w, int h)
{
    const int i = y * w + x;
    if (light == CORNERS)
        return (x == 0 || x == w - 1) && (y == 0 || y == h - 1);
    if (light == MIDDLE)
        return i % 83 == 13 && x >= w / 3 && x < w - w / 3 && y >= h / 3 &&
               y < h - h / 3;
    if (light == MANY)
        return scene_noise(i) < 0.3f;
    return i % 83 == 13 || i == w * h / 2;
}

static inline float scene_value(enum light light, int c, int x, int y, int w,
                                int h, uint32_t *seed)
{
    static const float bad[] = {
        NAN, INFINITY, -INFINITY, 1e-41f, -1e-41f, -3.0f, FLT_MAX, -0.0f,
        -FLT_MAX, FLT_MIN, -NAN,
    };
    static const float ends[] = {
        65504.0f, 65519.99f, 65520.0f, 65536.0f, -65520.0f, 0x1p-14f,
        0x1.ffcp-15f, 0x1p-24f, 0x1p-25f, 0x1.000002p-25f, -0x1p-24f, 0.0f,
        2049.0f, 2051.0f, 0x1.002p0f, 0x1.006p0f, FLT_MIN, 1e6f,
    };
    const int i = y * w + x;
    const float u = scene_random(seed), dim = 0.05f + 0.75f * u;
    switch (light) {
    case DARK:
        return dim;
    case ALL:
        return 1.1f + 30.0f * u;
    case HOT:
        return i == w * h / 2 ? 1e9f : 1e-3f;
    case DENORMAL:
        return 1e-39f * u;
    case BLOCK:
        return abs(x - w / 2) <= 16 && abs(y - h / 2) <= 16 ? 1.1f + u : dim;
    case CANCEL:
        return i % 2 ? 3.0f : -3.0f;
    case FLAT:
        return 2.0f;
    case EQUAL:
        return 1.1f;
    case BLACK:
        return 0.0f;
    case FAINT:
        return scene_noise(i) < 0.3f ? 1e-35f * (1.0f + u) : 0.0f;
    case MANY:
        if (!scene_is_lit(light, x, y, w, h))
            return dim;
        return i % 11 == c ? 0.0f : 20.0f + (i % 5 ? u : 65484.0f * u);
    case OVER:
        return u < 0.5f ? 60000.0f + 20000.0f * u : 1e6f * u;
    case ENDS:
        return ends[(i + c) % (int) COUNT(ends)];
    case EDGE:
        return i % 3 == 0 ? 1.0f : nextafterf(1.0f, i % 3 == 1 ? 2.0f : 0.0f);
    case RAMP:
        return 2.0f * (float) i / (float) (w * h);
    case BAD:
        if (i % 89 == 5 || i == w * h / 2 - 1)
            return bad[(i / 89 + c) % (int) COUNT(bad)];
        break;
    case COLOURED:
        if (scene_is_lit(light, x, y, w, h))
            return i % 3 == c ? 100.0f * (1.0f + u) : 0.0f;
        break;
    default:
        break;
    }
    return scene_is_lit(light, x, y, w, h)
               ? (i % 5 == 0 ? 2.0f + 65502.0f * u : 2.0f + u) : dim;
}

/* A frame with its data window's corner at (x0, y0). */
static inline struct gp_image scene_frame(int w, int h, int x0, int y0,
                                          enum light light, uint32_t seed)
{
    struct gp_image f =
        gp_image_blank((struct gp_rect) {x0, y0, x0 + w, y0 + h});
    f.display = (struct gp_rect) {0, 0, w, h};
    if (gp_planes_make(NULL, "rgb", (size_t) w * (size_t) h, &f.rgb))
        abort();
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            for (int c = 0; c < 3; c++)
                f.rgb.c[c][(size_t) y * (size_t) w + (size_t) x] =
                    scene_value(light, c, x, y, w, h, &seed);
        }
    }
    return f;
}

/* -- kernels ----------------------------------------------------------------*/

static inline double scene_tap(enum shape shape, int c, int x, int y, int w,
                               int h)
{
    const double dx = x - w / 2, dy = y - h / 2, r2 = dx * dx + dy * dy;
    const double peak = shape == BOX ? 1.0 : pow(r2 + 1.5, -1.25);
    switch (shape) {
    case TINTED:
        return peak * (1.0 + 0.2 * c) + 0.01 * c / (1.0 + r2);
    case RAYS:
        return (dx == 0.0 || dy == 0.0 || fabs(dx) == fabs(dy)
                    ? 1.0 / sqrt(1.0 + r2) : 0.0) +
               0.1 / ((1.0 + r2) * (1.0 + r2));
    case SPECKS:
        return pow((double) scene_noise(x + w * (y + h * c)), 4.0);
    case HOLES:
        return (x + y * w + c) % 3 ? 0.0 : peak;
    case RING:
        return r2 >= 0.16 * fmin(w * w, h * h) ? 1.0 : 0.0;
    case LOBES:
        return cos(0.7 * dx + 0.2 * c) * cos(0.4 * dy) * peak;
    case SLANT: // (exactly even: dx and dy are halves)
        return 1.0 / (1.0 + (dx + 2.0 * dy) * (dx + 2.0 * dy) + 0.01 * r2);
    case BORDER:
        return x < w / 4 || y < h / 3 || x >= w - 2 || y >= h - 1 ? 0.0 : peak;
    case DIPOLE:
        return x < w / 2 ? 1.0 : -1.0;
    default:
        return peak;
    }
}

enum { MID = INT_MIN }; // the centre that design.md gives a kernel

/* The square field of kernels `size` pixels wide at most, of 36 pixels a degree
 * as 1080 lines are by default. */
static inline struct gp_field scene_model_field(int size, double rotate)
{
    const int most = size / 2 + 1; // of an offset, and 1
    struct gp_field f = scene_field(most, most, 1.0 / 36.0, 1.0);
    f.rotate = rotate;
    return f;
}

/* The kernel of a recipe for that field. */
static inline struct gp_kernel scene_model(const char *recipe, int size,
                                           double rotate)
{
    const struct gp_field field = scene_model_field(size, rotate);
    struct gp_recipe r = scene_recipe(recipe);
    struct gp_kernel k, whole;
    if (gp_model_kernel(NULL, &r, 1, &field, &k) ||
        gp_kernel_whole(NULL, &k, field.w, field.h, &whole))
        abort();
    gp_recipe_free(&r);
    gp_kernel_free(&k);
    return whole;
}

/* Normalised so that the luminance sums to 1, LOBES included, DIPOLE not. */
static inline struct gp_kernel scene_kernel(int w, int h, int cx, int cy,
                                            enum shape shape)
{
    struct gp_image image = gp_image_blank((struct gp_rect) {0, 0, w, h});
    struct gp_kernel k;
    struct gp_kernel_params p = {0};
    p.normalize = shape == DIPOLE ? GP_NORMALIZE_NONE : GP_NORMALIZE_LUMINANCE;
    p.centered = cx != MID;
    p.center[0] = cx + 0.5;
    p.center[1] = cy + 0.5;
    if (gp_planes_make(NULL, "kernel", (size_t) w * (size_t) h, &image.rgb))
        abort();
    for (int i = 0; i < w * h; i++) {
        for (int c = 0; c < 3; c++)
            image.rgb.c[c][i] = (float) scene_tap(shape, c, i % w, i / w, w, h);
    }
    if (gp_kernel_from_frame(NULL, &p, &image, &k))
        abort();
    gp_planes_free(&image.rgb);
    return k;
}

/* Sample at an offset from the centre, 0 outside. */
static inline float scene_at(const struct gp_kernel *k, int c, int dx, int dy)
{
    const int x = k->cx + dx, y = k->cy + dy;
    return x >= 0 && x < k->w && y >= 0 && y < k->h
               ? k->k.c[c][(size_t) y * (size_t) k->w + (size_t) x] : 0.0f;
}

/* Takes k; the same with samples times `gain`, turned by `rotate` degrees. */
static inline struct gp_kernel scene_kernel_times(struct gp_kernel k,
                                                  double gain, float rotate)
{
    struct gp_kernel_params p = {
        .centered = true, .center = {k.cx + 0.5, k.cy + 0.5},
        .normalize = GP_NORMALIZE_NONE, .rotate = rotate,
    };
    struct gp_image image = {.data = {0, 0, k.w, k.h}, .rgb = k.k};
    struct gp_kernel out;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_image_pixels(&image); i++)
            k.k.c[c][i] = (float) ((double) k.k.c[c][i] * gain);
    }
    if (gp_kernel_from_frame(NULL, &p, &image, &out))
        abort();
    gp_kernel_free(&k);
    return out;
}

/* -- truth ------------------------------------------------------------------*/

/* One sample of the layer, gathered: the sum over the kernel's taps of the
 * source that each came from. `image` is the sources as a plane. */
static inline double scene_sample(const float *image, int w, int h,
    const struct gp_kernel *k, int c, int x, int y)
{
    double sum = 0.0;
    for (int ky = 0; ky < k->h; ky++) {
        const int sy = y - (ky - k->cy);
        for (int kx = 0; kx < k->w && sy >= 0 && sy < h; kx++) {
            const int sx = x - (kx - k->cx);
            if (sx >= 0 && sx < w)
                sum += (double) image[(size_t) sy * (size_t) w + (size_t) sx] *
                       (double) k->k.c[c][(size_t) ky * (size_t) k->w +
                                          (size_t) kx];
        }
    }
    return sum;
}

/* Light as engines get it: gp_glare_run() halves what is over 2^80 in sum. */
static inline void scene_limit(struct gp_sources *src)
{
    struct gp_sources less;
    if (!(src->brightest > 0x1p60f))
        return;
    if (gp_sources_scale(NULL, src, 0x1p-68, NULL, &less))
        abort();
    gp_sources_free(src);
    *src = less;
}

/* Takes the frame and the kernel; senses. No exact layer. */
static inline struct scene scene_sense(struct gp_image f, struct gp_kernel k,
                                       const struct glarepp_sense_params *p)
{
    struct scene s = {.f = f, .k = k};
    if (gp_sense(NULL, p, false, &s.f, &s.src))
        abort();
    return s;
}

static inline void scene_find_exact(struct scene *s)
{
    s->exact = scene_alloc(3 * gp_image_pixels(&s->f), sizeof *s->exact);
    if (gp_glare_reference(NULL, NULL, &s->src, &s->k, NULL, s->exact))
        abort();
}

/* Both. */
static inline struct scene scene_make(struct gp_image f, struct gp_kernel k,
                                      const struct glarepp_sense_params *p)
{
    struct scene s = scene_sense(f, k, p);
    scene_find_exact(&s);
    return s;
}

static inline void scene_free(struct scene *s)
{
    gp_image_free(&s->f);
    gp_sources_free(&s->src);
    gp_kernel_free(&s->k);
    free(s->exact);
    *s = (struct scene) {0};
}

static inline double scene_rel_l2(const struct scene *s)
{
    struct glarepp_errors e;
    gp_glare_measure(&s->f, &s->f.layer, s->exact, NULL, 1.0f, NULL, &e);
    return e.rel_l2;
}

/* Largest luminance error of a pixel over its own composite value. */
static inline double scene_own_error(const struct scene *s)
{
    const size_t n = gp_image_pixels(&s->f);
    double worst = 0.0;
    for (size_t i = 0; i < n; i++) {
        double wrong = 0.0, own = 0.0;
        for (int c = 0; c < 3; c++) {
            const double exact = s->exact[(size_t) c * n + i];
            const double y = (double) s->f.luminance[c];
            wrong += y * ((double) s->f.layer.c[c][i] - exact);
            own += y * (fmax((double) s->f.rgb.c[c][i], 0.0) + exact);
        }
        if (!(fabs(wrong) <= worst * own))
            worst = own > 0.0 ? fabs(wrong) / own : INFINITY;
    }
    return worst;
}

/* -- engines ----------------------------------------------------------------*/

static float scene_gain = 1.0f; // of the layer in the composite

/* Makes s->f.layer where there is none, and fills it with NaN: every sample
 * must be written. */
static inline void scene_clear_layer(struct scene *s)
{
    const size_t n = gp_image_pixels(&s->f);
    if (!s->f.layer.c[0] && gp_planes_make(NULL, "layer", n, &s->f.layer))
        abort();
    for (int c = 0; c < 3; c++)
        memset(s->f.layer.c[c], 0xff, n * sizeof(float));
}

/* Runs the named engine into s->f.layer. */
static inline gp_status scene_run(const char *engine, struct scene *s,
    struct gp_glare *g, struct glarepp_layer_facts *stats)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    p.engine = engine;
    p.gain = scene_gain;
    p.splat = (struct gp_splat_params) GP_SPLAT_EXACT; // as other engines
    scene_clear_layer(s);
    return gp_glare_run(&kept_log, &p, g, &s->src, &s->k, &s->f, stats);
}

/* FNV-1a of the layer's bytes. */
static inline uint64_t scene_hash(const struct scene *s)
{
    return hash_layer(&s->f.layer, gp_image_pixels(&s->f));
}

#endif
