/* glare/splat/group_reference.c: what is drawn of a group is what was meant. */
#include "unit.h"
#include "group_scene.h"

static double *draw(const struct gp_sources *s, const struct gp_kernel *k,
                    const struct gp_splat_params *p,
                    const struct gp_polygons *q)
{
    double *const layer =
        scene_alloc(3 * (size_t) s->w * (size_t) s->h, sizeof *layer);
    struct gp_shrink shrink;
    assert_int_equal(gp_shrink_make(NULL, k, p, q, &shrink), GP_OK);
    assert_int_equal(gp_group_reference(NULL, s, k, p, q, &shrink, layer),
                     GP_OK);
    return layer;
}

/* A point's polygon has its light, its centroid and the spread claimed. */
static void moments_are_kept(void **state)
{
    (void) state;
    struct gp_kernel point = scene_kernel(1, 1, MID, 0, BOX);
    struct gp_sources s = scene_sources(96, 96, 0, 0, CORNERS, 1u);
    for (int blur = 0; blur < GP_BLURS; blur++) {
        struct gp_polygon at = {
            .x = 47.3125f, .y = 46.75f, .rgb = {2, 2, 2}, .light = 2,
            .side = 64, .blur = (uint8_t) blur,
        };
        const struct gp_polygons q = {1, 1, 0, &at};
        const struct gp_splat_params p = {.group = 64};
        double *const layer = draw(&s, &point, &p, &q);
        double m0 = 0.0, mx = 0.0, my = 0.0, m2 = 0.0;
        for (int i = 0; i < 96 * 96; i++) {
            const double dx = i % 96 - (double) at.x;
            const double dy = i / 96 - (double) at.y;
            m0 += layer[i];
            mx += layer[i] * dx;
            my += layer[i] * dy;
            m2 += layer[i] * (dx * dx + dy * dy);
        }
        assert_true(fabs(m0 - 2.0) < 1e-6 && fabs(mx) < 1e-5 &&
                    fabs(my) < 1e-5);
        const double want = spread_of(gp_blur_box[blur], &at);
        assert_true(fabs(m2 / m0 / 2.0 - want) < 1e-5 * (1.0 + want));
        free(layer);
    }
    gp_sources_free(&s);
    gp_kernel_free(&point);
}

/* Ungrouped, it is the exact sum, whatever the method and the kernel. */
static void ungrouped_is_exact(void **state)
{
    static const int kernels[][4] = {
        {1, 1, MID, 0}, {9, 9, MID, 0}, {30, 18, MID, 0}, {121, 97, MID, 0},
        {13, 11, -20, 5}, {13, 11, 30, 25}, {13, 11, 1048575, 5},
    };
    (void) state;
    for (int i = 0; i < 7 * 3; i++) {
        const int *const r = kernels[i / 3];
        struct scene s = scene_make(
            scene_frame(61, 47, -3, 7, FEW, 5u),
            scene_kernel(r[0], r[1], r[2], r[3], TINTED), &over_one);
        struct gp_splat_params p = GP_SPLAT_EXACT;
        p.method = (enum gp_group_method) (i % 3);
        struct gp_polygons q = group(&s.src, &p);
        assert_int_equal(q.n, s.src.n);
        double *const layer = draw(&s.src, &s.k, &p, &q);
        for (size_t k = 0; k < 3 * gp_frame_pixels(&s.f); k++)
            assert_true(fabs(layer[k] - s.exact[k]) <=
                        1e-12 * fabs(s.exact[k]));
        free(layer);
        gp_polygons_free(&q);
        scene_free(&s);
    }
}

/* Pixels beyond the reach get nothing from the tail, those within all. */
static void reach_cuts(void **state)
{
    (void) state;
    struct gp_kernel k = scene_kernel(81, 81, MID, 0, PEAK);
    struct gp_sources s = scene_sources(96, 96, 0, 0, DARK, 1u);
    struct gp_polygon at = {
        .x = 40.5f, .y = 44.0f, .rgb = {1, 1, 1}, .light = 1, .side = 4,
        .blur = 1,
    };
    const struct gp_polygons q = {1, 1, 0, &at};
    const struct gp_splat_params p = {.group = 4};
    double *const whole = draw(&s, &k, &p, &q);
    double *const cut = scene_alloc(3 * 96 * 96, sizeof *cut);
    struct gp_shrink shrink = {.reach = {0}};
    shrink.reach[gp_source_bin(1.0f)] = 10;
    assert_int_equal(gp_group_reference(NULL, &s, &k, &p, &q, &shrink, cut),
                     GP_OK);
    for (int i = 0; i < 3 * 96 * 96; i++) {
        const double dx = i % 96 - 40.5, dy = i / 96 % 96 - 44.0;
        const int inside = fabs(dx) <= 10.0 && fabs(dy) <= 10.0;
        assert_true(cut[i] == (inside ? whole[i] : 0.0));
        assert_true(!inside || cut[i] > 0.0);
    }
    free(whole);
    free(cut);
    gp_sources_free(&s);
    gp_kernel_free(&k);
}

SUITE_OF(group_drawn, NULL, NULL,
    moments_are_kept, ungrouped_is_exact, reach_cuts)
