/* Random frames, kernels and settings, and what glare/bound/bound.h says of
 * them; everything comes from a seed. */
#ifndef GP_TESTS_BOUND_TRIAL_H
#define GP_TESTS_BOUND_TRIAL_H

#include "glare/splat/splat_priv.h"
#include "glare_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static inline int pick(uint32_t *seed, int low, int high)
{
    return low + (int) (scene_random(seed) * (float) (high - low + 1));
}

/* In [low, high], each octave as likely. */
static inline float pick_log(uint32_t *seed, float low, float high)
{
    return low * powf(high / low, scene_random(seed));
}

/* -- frames -----------------------------------------------------------------*/

enum content {
    SPARSE, CROWDED, GRADIENT, NOISE, SPOTS, WINDOWS, COMB, EVERY, CONTENTS,
};
static const char *const content_text[CONTENTS] = {
    "sparse", "crowded", "gradient", "noise", "coloured spots", "windows",
    "comb", "constant",
};

/* Light of pixel (x, y), 0 where dark; `step` is a distance of its own. */
static inline float light_of(enum content what, int x, int y, int step,
                             uint32_t *seed)
{
    const float u = scene_random(seed);
    switch (what) {
    case SPARSE:
        return u < 0.005f ? pick_log(seed, 1.0f, 1e4f) : 0.0f;
    case CROWDED:
        return u < 0.3f ? 1.0f + 5.0f * u : 0.0f;
    case GRADIENT:
        return 1.0f + 0.05f * (float) (x + 2 * y);
    case NOISE:
        return pick_log(seed, 0.1f, 100.0f);
    case SPOTS:
        return x / 5 % 4 == 1 && y / 3 % 5 == 2 ? 2.0f + u : 0.0f;
    case WINDOWS:
        return x / step % 2 && y / (step + 2) % 3 == 1 ? 3.0f + u : 0.0f;
    case COMB: // all blocks wrong in the same way
        return x % step == 0 && y % step == 0 ? 10.0f : 0.0f;
    default:
        return 1.0f;
    }
}

static inline struct gp_frame make_frame(enum content what, int w, int h,
                                         uint32_t *seed)
{
    struct gp_frame f = scene_frame(w, h, pick(seed, -70, 70),
                                    pick(seed, -70, 70), DARK, 1u);
    const int step = pick(seed, 2, 12), tint = pick(seed, 0, 2);
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            const float v = light_of(what, x, y, step, seed);
            for (int c = 0; c < 3; c++) {
                const float share =
                    what == SPOTS ? ((x / 5 + c) % 3 == 0 ? 1.0f : 0.01f)
                    : tint == 2   ? 0.5f + scene_random(seed)
                    : tint == 1   ? 1.0f + 0.5f * (float) c
                                  : 1.0f;
                f.rgb.c[c][(size_t) y * (size_t) w + (size_t) x] = v * share;
            }
        }
    }
    return f;
}

/* -- kernels ----------------------------------------------------------------*/

enum kind {
    EYE, RANDOM, STREAKS, POINT, EVEN, LARGE, TINT, LEVEL, HOLLOW, ASIDE, KINDS,
};
static const char *const kind_text[KINDS] = {
    "eye", "random", "streaks", "1x1", "even", "over the frame", "tinted",
    "flat", "ring", "centre aside",
};

static inline struct gp_kernel kernel_of_planes(int w, int h, enum kind kind,
                                                uint32_t *seed)
{
    struct gp_frame image = {.data = {0, 0, w, h}};
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_kernel k;
    memcpy(image.luminance, gp_rec709_luminance, sizeof image.luminance);
    if (gp_planes_make(NULL, "kernel", (size_t) w * (size_t) h, &image.rgb))
        abort();
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < w * h; i++) {
            const int dx = abs(i % w - w / 2), dy = abs(i / w - h / 2);
            const float far = 1.0f + (float) (dx * dx + dy * dy);
            const float streak = dx == 0 || dy == 0 || dx == dy ? 1.0f : 0.0f;
            image.rgb.c[c][i] =
                kind == RANDOM ? powf(scene_random(seed), 4.0f)
                               : streak / sqrtf(far) + 0.1f / (far * far);
        }
    }
    if (gp_kernel_from_frame(NULL, &p, &image, &k))
        abort();
    gp_planes_free(&image.rgb);
    return k;
}

static inline struct gp_kernel make_kernel(enum kind kind, int w, int h,
                                           uint32_t *seed)
{
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_kernel k;
    switch (kind) {
    case EYE:
        p.builtin_size = w | 1;
        if (gp_kernel_builtin(NULL, &p, &k))
            abort();
        return k;
    case RANDOM:
    case STREAKS:
        return kernel_of_planes(w, h, kind, seed);
    case POINT:
        return scene_kernel(1, 1, MID, 0, BOX);
    case EVEN:
        return scene_kernel(w & ~1, h & ~1, MID, 0, PEAK);
    case LEVEL:
        return scene_kernel(w, h, MID, 0, BOX);
    case HOLLOW:
        return scene_kernel(w, h, MID, 0, RING);
    case ASIDE:
        return scene_kernel(w, h, pick(seed, -w / 2, w + w / 2),
                            pick(seed, -h / 2, h), TINTED);
    default:
        return scene_kernel(w, h, MID, 0, kind == TINT ? TINTED : PEAK);
    }
}

/* -- settings ---------------------------------------------------------------*/

static inline struct gp_splat_params make_params(uint32_t *seed)
{
    static const float shares[] = {0.0f, 0.0f, 1e-4f, 1e-3f, 1e-2f, 0.2f};
    struct gp_splat_params p = {
        .group = 1 << pick(seed, 0, scene_random(seed) < 0.2f ? 6 : 4),
        .cluster_fill = 0.25f + 0.75f * scene_random(seed),
        .shrink = shares[pick(seed, 0, 5)],
        .method = (enum gp_group_method) pick(seed, 0, 2),
    };
    if (p.group < 64 && scene_random(seed) < 0.6f)
        p.cluster = p.group << pick(seed, 1, p.group < 32 ? 2 : 1);
    return p;
}

struct trial {
    struct scene s;
    struct gp_splat_params p;
    struct gp_polygons q;
    struct gp_shrink shrink;
    enum content content;
    enum kind kind;
};

/* Everything but the exact layer, from a seed. */
static inline struct trial make_trial(uint32_t seed)
{
    // the generator's first numbers are near each other for near seeds
    for (int i = 0; i < 8; i++)
        scene_random(&seed);
    struct trial t = {
        .content = (enum content) pick(&seed, 0, CONTENTS - 1),
        .kind = (enum kind) pick(&seed, 0, KINDS - 1),
    };
    const int small = getenv("GLAREPP_TEST_QUICK") != NULL;
    const int most = small ? 40 : pick(&seed, 0, 3) ? 80 : 160;
    const int w = pick(&seed, 16, most), h = pick(&seed, 16, most);
    int kw = pick(&seed, 3, small ? 40 : 90);
    int kh = pick(&seed, 3, small ? 40 : 90);
    if (t.kind == LARGE) {
        kw = 2 * w + 5;
        kh = 2 * h + 9;
    }
    t.s = scene_sense(make_frame(t.content, w, h, &seed),
                      make_kernel(t.kind, kw, kh, &seed),
                      &(struct gp_sensor_params) {0.0f, 0.0f, 65504.0f});
    t.p = make_params(&seed);
    if (gp_polygons_make(NULL, &t.s.src, &t.p, &t.q) ||
        gp_shrink_make(NULL, &t.s.k, &t.p, &t.q, &t.shrink))
        abort();
    return t;
}

static inline void free_trial(struct trial *t)
{
    gp_polygons_free(&t->q);
    scene_free(&t->s);
}

static inline double bound_of(const struct trial *t, double roundings,
                              struct gp_bound_cache *cache)
{
    double bound = -1.0;
    assert_int_equal(gp_group_bound(NULL, &t->s.src, &t->s.k, &t->p, &t->q,
                                    &t->shrink, roundings, cache, &bound),
                     GP_OK);
    assert_true(bound >= 0.0);
    return bound;
}

static inline double least_of(const struct trial *t,
                              struct gp_bound_cache *cache)
{
    double least = -1.0;
    assert_int_equal(gp_layer_least(NULL, &t->s.src, &t->s.k, cache, &least),
                     GP_OK);
    assert_true(least >= 0.0);
    return least;
}

#endif
