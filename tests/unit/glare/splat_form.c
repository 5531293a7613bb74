// SPDX-License-Identifier: Apache-2.0
/* Every form of drawing groups and clusters against the plain form in double,
 * and against each other. */
#include "unit.h"
#include "core/memory.h"
#include "plain_groups.h"
#include "splat_scene.h"

/* -- the forms ------------------------------------------------------------- */

struct form {
    int w, h, x0, y0;
    enum light light;
    int kw, kh, cx, cy;
    enum shape shape;
    int group, cluster;
    float fill, shrink;
};

static const struct form forms[] = {
    {1, 1, 0, 0, ALL, 9, 7, 4, 3, PEAK, 4, 8, 0.9f, 0},
    {61, 47, 0, 0, MANY, 21, 20, 10, 10, PEAK, 2, 0, 1, 0},
    {61, 47, -3, 5, MANY, 21, 20, 10, 10, PEAK, 4, 0, 1, 0},
    {61, 47, -3, 5, MANY, 21, 20, 10, 10, HOLES, 4, 0, 1, 0},
    {61, 47, -3, 5, MANY, 41, 36, 20, 18, TINTED, 4, 8, 0.3f, 0},
    {61, 47, -3, 5, MANY, 41, 36, 20, 18, LOBES, 4, 8, 0.3f, 0},
    {61, 47, 1, 5, MANY, 41, 36, 20, 18, PEAK, 1, 8, 0.3f, 0},
    {61, 47, 1, 5, MANY, 41, 36, 20, 18, PEAK, 1, 4, 0.3f, 0},
    {61, 47, 1, 5, ALL, 41, 36, 20, 18, PEAK, 8, 16, 0.9f, 0},
    {61, 47, 1, 5, ALL, 41, 36, 20, 18, PEAK, 4, 64, 0.9f, 0},
    {61, 67, 0, 0, HOT, 63, 63, 31, 31, PEAK, 4, 8, 0.9f, 1e-2f},
    {61, 67, 0, 0, HOT, 63, 63, 31, 31, PEAK, 1, 0, 0.9f, 1e-2f},
    {131, 67, 7, 7, MANY, 64, 64, 32, 32, PEAK, 4, 8, 0.2f, 1e-2f},
    {131, 67, 7, 7, FEW, 151, 90, 75, 45, TINTED, 4, 8, 0.9f, 1e-3f},
    {64, 64, 0, 0, FEW, 13, 11, 0, 10, PEAK, 4, 8, 0.9f, 0},
    {64, 64, 0, 0, FEW, 13, 11, -20, 31, PEAK, 4, 8, 0.9f, 0},
    {64, 64, 0, 0, FEW, 90, 90, 7, 80, PEAK, 8, 0, 0.9f, 0},
    {64, 64, 0, 0, FEW, 13, 13, 70, 6, PEAK, 16, 0, 1, 0},
    {97, 1, 0, 0, FEW, 33, 33, 16, 16, PEAK, 4, 8, 0.9f, 0},
    {64, 80, 0, 0, ALL, 24, 25, 12, 12, PEAK, 1, 2, 1, 0},
};
enum { FORMS = COUNT(forms) };

struct drawn {
    struct scene s;
    double *want; // the plain form
};

static struct drawn make_drawn(const struct form *f)
{
    struct drawn d = {.s = splat_scene(f->w, f->h, f->light, splat_kernel(f->kw,
        f->kh, f->cx, f->cy, f->shape))};
    d.s.src.x0 = f->x0;
    d.s.src.y0 = f->y0;
    how = (struct gp_splat_params) {
        .group = f->group, .cluster = f->cluster, .cluster_fill = f->fill,
        .shrink = f->shrink,
    };
    struct gp_polygons polygons;
    struct gp_shrink shrink;
    d.want = scene_alloc(3 * gp_image_pixels(&d.s.f), sizeof *d.want);
    if (gp_polygons_make(NULL, &d.s.src, &how, &polygons) ||
        gp_shrink_make(NULL, &d.s.k, &how, &polygons, &shrink))
        abort();
    plain_groups(&d.s.src, &d.s.k, &how, &polygons, &shrink, d.want);
    gp_free(polygons.at);
    return d;
}

static void free_drawn(struct drawn *d)
{
    scene_free(&d->s);
    free(d->want);
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
}

static void check_form(int row, struct drawn *d, enum gp_primitive primitive,
                       void **state)
{
    how.primitive = primitive;
    if (splat(GP_GL_AUTO, &d->s, state) != GP_OK)
        fail_msg("row %d, primitive %d: %s", row, primitive, kept_line);
    const double error = splat_error(&d->s);
    struct scene plain = d->s;
    plain.exact = d->want;
    const double off = scene_rel_l2(&plain);
    if (!(off <= 5e-6 && error <= stats.bound))
        fail_msg("row %d, primitive %d: %g off the plain form, rel_l2 %g, "
                 "bound %g", row, primitive, off, error, stats.bound);
}

/* One state for all: frames, kernels and groups change under way. */
static void forms_equal_the_plain_form(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    const int n = getenv("GLAREPP_TEST_QUICK") ? 3 : FORMS;
    for (int i = 0; i < n; i++) {
        struct drawn d = make_drawn(&forms[i]);
        for (int p = 0; p < PRIMITIVES; p++)
            check_form(i, &d, primitives[p], &kept);
        free_drawn(&d);
    }
    gp_engine_splat.close(&kept);
}

/* A frame that no target holds goes by tiles. */
static void large_frames_go_by_tiles(void **state)
{
    void *kept = open_small_or_skip("100");
    static const int row[] = {4, 12}; // 61 and 131 pixels wide
    static const char *const form[] = {"blended quads",
                                       "tiles, groups from the CPU"};
    for (size_t i = 0; i < COUNT(row); i++) {
        struct drawn d = make_drawn(&forms[row[i]]);
        check_form(row[i], &d, GP_PRIMITIVE_QUAD, &kept);
        assert_string_equal(stats.form, form[i]);
        free_drawn(&d);
    }
    gp_engine_splat.close(&kept);
}

SUITE(splat_form)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forms_equal_the_plain_form),
        cmocka_unit_test(large_frames_go_by_tiles),
    };
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("forms_equal*");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
