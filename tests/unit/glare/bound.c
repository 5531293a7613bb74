/* glare/bound/bound.h: what is measured is never over the bound, and the bound
 * is not far over it. Random frames, kernels and settings; the layer of the
 * polygons and the exact one both in double. */
#include "unit.h"
#include "bound_trial.h"

#include "core/parallel.h"

enum { CASES = 400, QUICK_CASES = 40 };

/* -- the law ----------------------------------------------------------------*/

/* Norms of the exact layer and of what the polygons are wrong by. */
static void measure(struct trial *t, double *norm, double *wrong)
{
    const size_t n = 3 * gp_frame_pixels(&t->s.f);
    double *const layer = scene_alloc(n, sizeof *layer);
    scene_find_exact(&t->s);
    assert_int_equal(gp_group_reference(NULL, &t->s.src, &t->s.k, &t->p,
                                        &t->q, &t->shrink, layer),
                     GP_OK);
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
    (void) state;
    const char *const more = getenv("GLAREPP_TEST_CASES");
    const uint32_t cases = more ? (uint32_t) strtoul(more, NULL, 10)
                           : getenv("GLAREPP_TEST_QUICK") ? QUICK_CASES : CASES;
    double *const ratio = scene_alloc(cases, sizeof *ratio);
    double *const slack = scene_alloc(cases, sizeof *slack);
    size_t n = 0, layers = 0;
    for (uint32_t seed = 0; seed < cases; seed++) {
        struct trial t = make_trial(seed);
        struct gp_bound_cache cache = {0};
        double norm, wrong;
        const double bound = bound_of(&t, 4.0, &cache);
        const double least = least_of(&t, &cache);
        measure(&t, &norm, &wrong);
        if (least > norm * (1.0 + 1e-9) ||
            !(isinf(bound) || wrong <= bound * norm))
            fail_msg("seed %u: %s, %dx%d, kernel %s %dx%d, group %d, cluster "
                     "%d, method %d, shrink %g: rel_l2 %g, bound %g; norm "
                     "%g, least %g", seed, content_text[t.content],
                     t.s.src.w, t.s.src.h, kind_text[t.kind], t.s.k.w,
                     t.s.k.h, t.p.group, t.p.cluster, (int) t.p.method,
                     (double) t.p.shrink, wrong / norm, bound, norm, least);
        if (norm > 0.0 && least > 0.0)
            slack[layers++] = norm / least;
        // where grouping is exact there is nothing to compare
        if (norm > 0.0 && wrong > 1e-6 * norm)
            ratio[n++] = bound * norm / wrong;
        if (getenv("GLAREPP_TEST_VERBOSE"))
            printf("%3u %-14s %-14s %3dx%3d k %3dx%3d N %2d C %2d m %d s %g: "
                   "%.3e bound %.3e ratio %.2f layer %.2f\n", seed,
                   content_text[t.content], kind_text[t.kind], t.s.src.w,
                   t.s.src.h, t.s.k.w, t.s.k.h, t.p.group, t.p.cluster,
                   (int) t.p.method, (double) t.p.shrink, wrong / norm, bound,
                   bound * norm / wrong, norm / least);
        gp_bound_cache_free(&cache);
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

/* -- what it must not depend on ---------------------------------------------*/

/* A cache that has seen other frames, kernels and settings. */
static void caches_change_nothing(void **state)
{
    (void) state;
    struct gp_bound_cache old = {0};
    double bound[24], least[24];
    for (int pass = 0; pass < 2; pass++) {
        struct trial shared = make_trial(1000u);
        for (uint32_t i = 0; i < 24; i++) {
            struct gp_bound_cache own = {0};
            struct trial t = make_trial(1000u + i);
            // half of them share one kernel
            struct gp_kernel k = t.s.k;
            if (i % 2) {
                t.s.k = shared.s.k;
                assert_int_equal(gp_shrink_make(NULL, &t.s.k, &t.p, &t.q,
                                                &t.shrink), GP_OK);
            }
            struct gp_bound_cache *const cache = pass ? &old : &own;
            bound[i] = pass && bound_of(&t, 1.0, cache) != bound[i]
                           ? -1.0 : bound_of(&t, 1.0, cache);
            least[i] = pass && least_of(&t, cache) != least[i]
                           ? -1.0 : least_of(&t, cache);
            if (bound[i] < 0.0 || least[i] < 0.0)
                fail_msg("trial %u: the cache changed it", i);
            t.s.k = k;
            gp_bound_cache_free(&own);
            free_trial(&t);
        }
        free_trial(&shared);
        // serials differ between the passes; the kernels do not
    }
    gp_bound_cache_free(&old);
    gp_bound_cache_free(&old); // twice is harmless
}

static void threads_change_nothing(void **state)
{
    (void) state;
    double bound[6];
    for (int threads = 1; threads < 5; threads++) {
        gp_set_threads(threads);
        for (uint32_t i = 0; i < 6; i++) {
            struct gp_bound_cache cache = {0};
            struct trial t = make_trial(300u + i);
            const double b = bound_of(&t, 1.0, &cache);
            if (threads == 1)
                bound[i] = b;
            assert_true(b == bound[i]);
            gp_bound_cache_free(&cache);
            free_trial(&t);
        }
    }
    gp_set_threads(0);
}

/* -- the ends of the range --------------------------------------------------*/

static struct trial simple_trial(enum light light, struct gp_kernel k,
                                 struct gp_splat_params p)
{
    struct trial t = {.p = p};
    t.s = scene_sense(scene_frame(61, 47, -3, 5, light, 3u), k,
                      &(struct gp_sensor_params) {1.0f, 0.0f, 65504.0f});
    if (gp_polygons_make(NULL, &t.s.src, &t.p, &t.q) ||
        gp_shrink_make(NULL, &t.s.k, &t.p, &t.q, &t.shrink))
        abort();
    return t;
}

static void nothing_is_said_of_lobes(void **state)
{
    (void) state;
    struct gp_bound_cache cache = {0};
    struct trial t = simple_trial(FEW, scene_kernel(31, 31, MID, 0, LOBES),
                                  (struct gp_splat_params) {.group = 4});
    assert_true(isinf(bound_of(&t, 0.0, &cache)));
    assert_true(least_of(&t, &cache) == 0.0);
    gp_bound_cache_free(&cache);
    free_trial(&t);
}

/* Single sensors are wrong by rounding alone, and roundings count. */
static void single_sensors_only_round(void **state)
{
    (void) state;
    for (int method = 0; method < 3; method++) {
        struct gp_bound_cache cache = {0};
        struct gp_splat_params p = GP_SPLAT_EXACT;
        p.method = (enum gp_group_method) method;
        struct trial t =
            simple_trial(FEW, scene_kernel(31, 31, MID, 0, PEAK), p);
        const double none = bound_of(&t, 0.0, &cache);
        const double many = bound_of(&t, 1000.0, &cache);
        assert_true(none < 1e-6);
        assert_true(many >= 1000.0 * 0x1p-24 && many < 1100.0 * 0x1p-24);
        gp_bound_cache_free(&cache);
        free_trial(&t);
    }
}

static void darkness_is_no_error(void **state)
{
    (void) state;
    struct gp_bound_cache cache = {0};
    struct trial t = simple_trial(DARK, scene_kernel(31, 31, MID, 0, PEAK),
                                  (struct gp_splat_params) {.group = 4});
    assert_true(least_of(&t, &cache) == 0.0);
    bound_of(&t, 0.0, &cache);
    gp_bound_cache_free(&cache);
    free_trial(&t);
}

/* More light left out, or larger blocks: never a smaller bound than what a
 * point far from others must lose. One lit pixel is exact in every block. */
static void a_single_light_is_exact(void **state)
{
    (void) state;
    for (int group = 2; group <= 64; group *= 2) {
        struct gp_bound_cache cache = {0};
        struct trial t = simple_trial(
            CORNERS, scene_kernel(31, 31, MID, 0, PEAK),
            (struct gp_splat_params) {.group = group < 32 ? group : 16,
                                      .method = GP_GROUP_MOMENTS});
        assert_int_equal(t.q.n, t.s.src.n);
        // only the samples' places and rounding are left
        assert_true(bound_of(&t, 0.0, &cache) < 1e-3);
        gp_bound_cache_free(&cache);
        free_trial(&t);
    }
}

/* A kernel that cannot reach the frame. */
static void out_of_reach(void **state)
{
    (void) state;
    struct gp_bound_cache cache = {0};
    struct trial t = simple_trial(FEW, scene_kernel(13, 11, 2000, 5, PEAK),
                                  (struct gp_splat_params) {.group = 4});
    assert_true(least_of(&t, &cache) == 0.0);
    bound_of(&t, 0.0, &cache);
    gp_bound_cache_free(&cache);
    free_trial(&t);
}

SUITE_OF(bound, NULL, NULL,
    measured_is_never_over_the_bound, caches_change_nothing,
    threads_change_nothing, nothing_is_said_of_lobes,
    single_sensors_only_round, darkness_is_no_error, a_single_light_is_exact,
    out_of_reach)
