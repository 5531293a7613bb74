/* Bounds of splat and of the least layer: what is measured is never over the bound, and the bound
 * is not far over it. Random frames, kernels and settings; the layer of the
 * polygons and the exact one both in double. */
#include "unit.h"
#include "glare/splat/splat_priv.h"
#include "glare_scene.h"
#include "plain_groups.h"

static int between(uint32_t *seed, int low, int high)
{
    return low + (int) (scene_random(seed) * (float) (high - low + 1));
}

/* In [low, high], each octave as likely. */
static float pick_log(uint32_t *seed, float low, float high)
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
static float light_of(enum content what, int x, int y, int step, uint32_t *seed)
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

static struct gp_image make_frame(enum content what, int w, int h,
                                  uint32_t *seed)
{
    struct gp_image f = scene_frame(w, h, between(seed, -70, 70),
                                    between(seed, -70, 70), DARK, 1u);
    const int step = between(seed, 2, 12), tint = between(seed, 0, 2);
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
static const struct {
    const char *text;
    enum shape shape;
} kinds[KINDS] = {
    {"eye", PEAK}, {"random", SPECKS}, {"streaks", RAYS}, {"1x1", BOX},
    {"even", PEAK}, {"over the frame", PEAK}, {"tinted", TINTED},
    {"flat", BOX}, {"ring", RING}, {"centre aside", TINTED},
};

static struct gp_kernel make_kernel(enum kind kind, int w, int h,
                                    uint32_t *seed)
{
    int cx = MID, cy = 0;
    if (kind == EYE)
        return scene_model("eye", w, 0.0);
    if (kind == POINT)
        w = h = 1;
    if (kind == EVEN) {
        w &= ~1;
        h &= ~1;
    }
    if (kind == ASIDE) {
        cx = between(seed, -w / 2, w + w / 2);
        cy = between(seed, -h / 2, h);
    }
    return scene_kernel(w, h, cx, cy, kinds[kind].shape);
}

/* -- settings ---------------------------------------------------------------*/

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
    enum content content;
    enum kind kind;
};

/* Everything but the exact layer, from a seed. */
static struct trial make_trial(uint32_t seed)
{
    // the generator's first numbers are near each other for near seeds
    for (int i = 0; i < 8; i++)
        scene_random(&seed);
    struct trial t = {
        .content = (enum content) between(&seed, 0, CONTENTS - 1),
        .kind = (enum kind) between(&seed, 0, KINDS - 1),
    };
    const int small = getenv("GLAREPP_TEST_QUICK") != NULL;
    const int most = small ? 40 : between(&seed, 0, 3) ? 80 : 160;
    const int w = between(&seed, 16, most), h = between(&seed, 16, most);
    int kw = between(&seed, 3, small ? 40 : 90);
    int kh = between(&seed, 3, small ? 40 : 90);
    if (t.kind == LARGE) {
        kw = 2 * w + 5;
        kh = 2 * h + 9;
    }
    t.s = scene_sense(make_frame(t.content, w, h, &seed), make_kernel(t.kind,
        kw, kh, &seed), &open_all);
    t.p = make_params(&seed);
    if (gp_polygons_make(NULL, &t.s.src, &t.p, &t.q) ||
        gp_shrink_make(NULL, &t.s.k, &t.p, &t.q, &t.shrink))
        abort();
    return t;
}

static void free_trial(struct trial *t)
{
    gp_polygons_free(&t->q);
    scene_free(&t->s);
}

static double bound_of(const struct trial *t, double roundings)
{
    double bound = -1.0;
    assert_ok(gp_group_bound(NULL, &t->s.src, &t->s.k, &t->p, &t->q, &t->shrink,
                             roundings, &bound));
    assert_true(bound >= 0.0);
    return bound;
}

static double least_of(const struct trial *t)
{
    double least = -1.0;
    assert_ok(gp_layer_least(NULL, &t->s.src, &t->s.k, &least));
    assert_true(least >= 0.0);
    return least;
}

enum { CASES = 400, QUICK_CASES = 40 };

/* -- the law ----------------------------------------------------------------*/

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

static double median(double *v, size_t n)
{
    qsort(v, n, sizeof *v, compare);
    return v[n / 2];
}

/* Four roundings are the reference's own: its blurred kernels and the
 * polygons are floats. */
static void measured_is_never_over_the_bound(void **state)
{
    const char *const more = getenv("GLAREPP_TEST_CASES");
    const uint32_t cases = more ? (uint32_t) strtoul(more, NULL, 10)
                           : getenv("GLAREPP_TEST_QUICK") ? QUICK_CASES : CASES;
    double *const ratio = scene_alloc(cases, sizeof *ratio);
    double *const slack = scene_alloc(cases, sizeof *slack);
    size_t n = 0, layers = 0;
    for (uint32_t seed = 0; seed < cases; seed++) {
        struct trial t = make_trial(seed);
        double norm, wrong;
        const double bound = bound_of(&t, 4.0);
        const double least = least_of(&t);
        measure(&t, &norm, &wrong);
        if (least > norm * (1.0 + 1e-9) ||
            !(isinf(bound) || wrong <= bound * norm))
            fail_msg("seed %u: %s, %dx%d, kernel %s %dx%d, group %d, cluster "
                     "%d, shrink %g: rel_l2 %g, bound %g; norm "
                     "%g, least %g", seed, content_text[t.content],
                     t.s.src.w, t.s.src.h, kinds[t.kind].text, t.s.k.w,
                     t.s.k.h, t.p.group, t.p.cluster, (double) t.p.shrink, wrong / norm, bound, norm, least);
        if (norm > 0.0 && least > 0.0)
            slack[layers++] = norm / least;
        // exact grouping leaves nothing to compare
        if (norm > 0.0 && wrong > 1e-6 * norm)
            ratio[n++] = bound * norm / wrong;
        free_trial(&t);
    }
    const double middle = median(ratio, n), usual = median(slack, layers);
    print_message("bound / measured of %zu frames: median %.2f, from %.2f to "
                  "%.2f; layer / least: median %.2f, to %.2f\n", n, middle,
                  ratio[0], ratio[n - 1], usual, slack[layers - 1]);
    assert_true(n > cases / 3);
    assert_true(middle <= 10.0);
    free(ratio);
    free(slack);
}

SUITE_OF(bound, NULL, NULL, measured_is_never_over_the_bound)

