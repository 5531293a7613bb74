// SPDX-License-Identifier: Apache-2.0
/* Bounds of splat and of the least layer: what is measured is never over the
 * bound, and the bound is not far over it. Random frames, kernels and settings;
 * the layer of the polygons and the exact one both in double. */
#include "unit.h"
#include "core/memory.h"
#include "glare/splat/splat_priv.h"
#include "glare_scene.h"
#include "plain_groups.h"

static int between(uint32_t *seed, int low, int high)
{
    return low + (int) (scene_random(seed) * (float) (high - low + 1));
}

/* A kernel that is a point, even, larger than the frame, or off its centre in
 * some cases. */
static struct gp_kernel make_kernel(int w, int h, uint32_t *seed)
{
    static const enum shape shapes[] = {
        PEAK, TINTED, BOX, RAYS, SPECKS, HOLES, RING, BORDER,
    };
    const enum shape shape = shapes[between(seed, 0, COUNT(shapes) - 1)];
    const int kind = between(seed, 0, 7);
    int kw = kind ? between(seed, 3, 90) : 1;
    int kh = kind ? between(seed, 3, 90) : 1;
    if (kind == 1) {
        kw = 2 * w + 5;
        kh = 2 * h + 9;
    }
    if (kind == 2)
        return scene_kernel(kw, kh, between(seed, -kw / 2, kw + kw / 2),
                            between(seed, -kh / 2, kh), TINTED);
    return scene_kernel(kw, kh, MID, 0, kind ? shape : BOX);
}

static struct gp_splat_params make_params(uint32_t *seed)
{
    static const float shares[] = {0.0f, 0.0f, 1e-4f, 1e-3f, 1e-2f, 0.2f};
    struct gp_splat_params p = {
        .group = 1 << between(seed, 0, scene_random(seed) < 0.2f ? 6 : 4),
        .cluster_fill = 0.25f + 0.75f * scene_random(seed),
        .shrink = shares[between(seed, 0, 5)],
    };
    if (p.group < 64 && scene_random(seed) < 0.6f)
        p.cluster = p.group << between(seed, 1, p.group < 32 ? 2 : 1);
    return p;
}

struct trial {
    struct scene s;
    struct gp_splat_params p;
    struct gp_polygons q;
    struct gp_shrink shrink;
};

/* Everything but the exact layer, from a seed. */
static struct trial make_trial(uint32_t seed)
{
    static const enum light lights[] = {
        FEW, MANY, ALL, RAMP, BLOCK, COLOURED, EQUAL, CORNERS, DARK, HOT,
    };
    // the generator's first numbers are near each other for near seeds
    for (int i = 0; i < 8; i++)
        scene_random(&seed);
    struct trial t = {0};
    const int most = between(&seed, 0, 3) ? 80 : 160;
    const int w = between(&seed, 16, most), h = between(&seed, 16, most);
    const int x0 = between(&seed, -70, 70), y0 = between(&seed, -70, 70);
    const enum light light = lights[between(&seed, 0, COUNT(lights) - 1)];
    const bool all = between(&seed, 0, 1);
    t.s = scene_sense(scene_frame(w, h, x0, y0, light, seed),
                      make_kernel(w, h, &seed),
                      all || light == DARK ? &open_all : &usual);
    t.p = make_params(&seed);
    assert_ok(gp_polygons_make(NULL, &t.s.src, &t.p, &t.q));
    assert_ok(gp_shrink_make(NULL, &t.s.k, &t.p, &t.q, &t.shrink));
    return t;
}

/* Norms of the exact layer and of what the polygons are wrong by. */
static void measure(struct trial *t, double *norm, double *wrong)
{
    const size_t n = 3 * gp_image_pixels(&t->s.f);
    double *const layer = scene_alloc(n, sizeof *layer);
    scene_find_exact(&t->s);
    plain_groups(&t->s.src, &t->s.k, &t->p, &t->q, &t->shrink, layer);
    *norm = *wrong = 0.0;
    for (size_t i = 0; i < n; i++) {
        *norm += t->s.exact[i] * t->s.exact[i];
        *wrong += (layer[i] - t->s.exact[i]) * (layer[i] - t->s.exact[i]);
    }
    *norm = sqrt(*norm);
    *wrong = sqrt(*wrong);
    free(layer);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

/* Four roundings are the reference's own: its blurred kernels and the
 * polygons are floats. */
static void measured_is_never_over_the_bound(void **state)
{
    const char *const more = getenv("GLAREPP_TEST_CASES");
    const uint32_t cases = more ? (uint32_t) strtoul(more, NULL, 10)
                           : getenv("GLAREPP_TEST_QUICK") ? 40 : 400;
    double *const ratio = scene_alloc(cases, sizeof *ratio);
    size_t n = 0;
    for (uint32_t seed = 0; seed < cases; seed++) {
        struct trial t = make_trial(seed);
        double norm, wrong, bound = -1.0, least = -1.0;
        assert_ok(gp_group_bound(NULL, &t.s.src, &t.s.k, &t.p, &t.q, &t.shrink,
                                 4.0, &bound));
        assert_ok(gp_layer_least(NULL, &t.s.src, &t.s.k, &least));
        measure(&t, &norm, &wrong);
        if (!(bound >= 0.0 && least >= 0.0 && least <= norm * (1.0 + 1e-9)) ||
            !(isinf(bound) || wrong <= bound * norm))
            fail_msg("seed %u, %dx%d: rel_l2 %g, bound %g; norm %g, least %g",
                     seed, t.s.src.w, t.s.src.h, wrong / norm, bound, norm,
                     least);
        // exact grouping leaves nothing to compare
        if (norm > 0.0 && wrong > 1e-6 * norm)
            ratio[n++] = bound * norm / wrong;
        gp_free(t.q.at);
        scene_free(&t.s);
    }
    qsort(ratio, n, sizeof *ratio, compare);
    print_message("bound / measured of %zu frames: median %.2f, from %.2f to "
                  "%.2f\n", n, ratio[n / 2], ratio[0], ratio[n - 1]);
    assert_true(n > cases / 3);
    assert_true(ratio[n / 2] <= 10.0);
    free(ratio);
}

SUITE_OF(bound, NULL, NULL, measured_is_never_over_the_bound)
