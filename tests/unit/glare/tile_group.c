/* Polygons gathered per tile, as groups make them: against the plain form of
 * the same polygons, and ungrouped against the exact layer. */
#include "unit.h"
#include "glare/glare_priv.h"
#include "gl_open.h"
#include "glare/splat/polygons.h"
#include "glare/splat/splat_priv.h"
#include "glare_scene.h"

struct row {
    int w, h, x0, y0;
    enum light light;
    int kw, kh;
    enum shape shape;
    struct gp_splat_params p;
    double most; // of rel_l2
};

static const struct row rows[] = {
    {61, 47, 0, 0, FEW, 21, 21, PEAK, GP_SPLAT_EXACT, 1e-6},
    {61, 47, -7, 5, ALL, 200, 180, TINTED, GP_SPLAT_EXACT, 1e-6},
    {64, 64, 0, 0, HOT, 63, 63, PEAK, GP_SPLAT_EXACT, 1e-6},
    {70, 51, 3, -9, ALL, 41, 40, PEAK,
     {4, 8, 0.9f, 0.0f, GP_GROUP_CENTROID, GP_PRIMITIVE_AUTO}, 2e-6},
    {70, 51, 3, -9, ALL, 41, 40, TINTED,
     {4, 0, 0.9f, 1e-3f, GP_GROUP_MOMENTS, GP_PRIMITIVE_AUTO}, 2e-6},
    {70, 51, 3, -9, BLOCK, 41, 40, PEAK,
     {4, 16, 0.9f, 1e-3f, GP_GROUP_CORE, GP_PRIMITIVE_AUTO}, 2e-6},
    {130, 97, 0, 0, RAMP, 81, 80, TINTED,
     {2, 64, 0.5f, 1e-2f, GP_GROUP_CORE, GP_PRIMITIVE_AUTO}, 2e-6},
    {130, 97, 0, 0, MIDDLE, 81, 80, RING,
     {8, 0, 0.9f, 1e-2f, GP_GROUP_MOMENTS, GP_PRIMITIVE_AUTO}, 2e-6},
    {130, 97, 0, 0, FEW, 33, 33, LOBES,
     {4, 8, 0.9f, 0.0f, GP_GROUP_MOMENTS, GP_PRIMITIVE_AUTO}, 2e-6},
};

static double rel_l2(const struct gp_planes *layer, const double *exact,
                     size_t n)
{
    double wrong = 0.0, all = 0.0;
    for (size_t i = 0; i < 3 * n; i++) {
        double d = (double) layer->c[i / n][i % n] - exact[i];
        wrong += d * d;
        all += exact[i] * exact[i];
    }
    return wrong == 0.0 ? 0.0 : sqrt(wrong / all);
}

/* What the polygons are meant to give; without single sensors' cores, which
 * are another's work: the reference gets a frame without sources. */
static void find_meant(const struct row *r, const struct scene *s,
                       const struct gp_polygons *q,
                       const struct gp_shrink *shrink, double *meant)
{
    static const struct gp_sensor_params none = {1e9f, 0.0f, 65504.0f};
    struct gp_frame dark = scene_frame(r->w, r->h, r->x0, r->y0, DARK, 1u);
    struct gp_sources empty;
    assert_int_equal(gp_sense(NULL, &none, &dark, &empty), GP_OK);
    assert_int_equal(empty.n, 0);
    assert_int_equal(gp_group_reference(NULL, &empty, &s->k, &r->p, q, shrink,
                                        meant), GP_OK);
    gp_sources_free(&empty);
    gp_frame_free(&dark);
}

static void run_row(struct gp_gl *gl, const struct row *r,
                    struct gp_tiles **state, int row)
{
    static const struct gp_sensor_params over_one = {1.0f, 0.0f, 65504.0f};
    struct scene s = scene_sense(
        scene_frame(r->w, r->h, r->x0, r->y0, r->light, 77u + (uint32_t) row),
        scene_kernel(r->kw, r->kh, MID, MID, r->shape), &over_one);
    size_t n = (size_t) r->w * (size_t) r->h;
    double *meant = scene_alloc(3 * n, sizeof *meant), roundings;
    struct gp_planes layer;
    struct gp_polygons q;
    struct gp_shrink shrink;
    assert_int_equal(gp_planes_make(NULL, "layer", n, &layer), GP_OK);
    assert_int_equal(gp_polygons_make(NULL, &s.src, &r->p, &q), GP_OK);
    assert_int_equal(gp_shrink_make(NULL, &s.k, &r->p, &q, &shrink), GP_OK);
    if (gp_tiles_draw(&scene_log, gl, &s.k,
                      (struct gp_rect) {0, 0, s.k.w, s.k.h},
                      r->p.method == GP_GROUP_CORE, &q, &shrink, r->w, r->h,
                      &layer, state, &roundings) != GP_OK)
        fail_msg("row %d: %s", row, scene_line);
    assert_true(roundings <= gp_tiles_roundings(&q));
    if (r->p.group == 1)
        gp_glare_reference_direct(&s.src, &s.k, meant);
    else
        find_meant(r, &s, &q, &shrink, meant);
    double error = rel_l2(&layer, meant, n);
    if (!(error <= r->most))
        fail_msg("row %d: rel_l2 %g", row, error);
    gp_polygons_free(&q);
    gp_planes_free(&layer);
    free(meant);
    scene_free(&s);
}

static void groups_equal_the_plain_form(void **state)
{
    (void) state;
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct gp_tiles *kept = NULL;
    for (int i = 0; i < (int) (sizeof rows / sizeof rows[0]); i++)
        run_row(gl, &rows[i], &kept, i);
    gp_tiles_free(gl, &kept);
    gp_gl_close(&gl);
}

SUITE(tile_group)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups_equal_the_plain_form),
    };
    if (getenv("GLAREPP_TEST_QUICK")) { // Mesa's compiler crawls in valgrind
        puts("1..0 # skipped: too long for GLAREPP_TEST_QUICK");
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
