/* Ando's system on real frames: groups of 4x4, clusters of 8x8 and shrinking
 * to 1e-3, with the core from single sensors, stay within 1e-2 of the exact
 * layer and within their bound on every frame of the data folder that is not
 * far over 1k. The layer is the plain form of what GL draws; splat_form
 * holds GL to it. The exact layer is that of fft, whose bound of at most 1e-5
 * is added: the direct sum of half a million sources takes seconds. The folder
 * is $GLAREPP_DATA, or ../shared/data; without it the test is skipped. */
#include "unit.h"
#include "data_frames.h"
#include "glare_scene.h"
#include "core/memory.h"
#include "glare/sensors.h"
#include "glare/splat/splat_priv.h"
#include "glare/bound/bound.h"
#include "glare/engine.h"
#include "io/read.h"
#include "plain_groups.h"

enum { WIDEST = 1300 };

/* Largest rel_l2 so far. */
struct worst {
    int frames;
    double rel_l2;
};

/* Makes f->layer; returns the largest rel_l2 that it may have. */
static double make_exact(struct gp_frame *f, const struct gp_sources *src,
                         const struct gp_kernel *k, struct gp_glare *g)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    p.engine = "fft";
    assert_ok(gp_planes_make(NULL, "layer", gp_frame_pixels(f), &f->layer));
    assert_ok(gp_glare_run(NULL, &p, g, src, k, f, &stats));
    assert_true(stats.bound <= 1e-5);
    return stats.bound;
}

static void check_frame(struct gp_frame *f, const struct gp_sources *src,
                        const struct gp_kernel *k, struct gp_glare *g,
                        struct worst *worst)
{
    const struct gp_splat_params p = GP_SPLAT_DEFAULTS;
    const size_t n = gp_frame_pixels(f);
    struct gp_polygons polygons;
    struct gp_shrink shrink;
    double bound, *const layer = calloc(3 * n, sizeof *layer);
    const double of_exact = make_exact(f, src, k, g);
    assert_non_null(layer);
    assert_ok(gp_polygons_make(NULL, src, &p, &polygons));
    assert_ok(gp_shrink_make(NULL, k, &p, &polygons, &shrink));
    assert_ok(gp_group_bound(NULL, src, k, &p, &polygons, &shrink, 0.0,
                             &bound));
    plain_groups(src, k, &p, &polygons, &shrink, layer);
    double wrong = 0.0, all = 0.0;
    for (size_t i = 0; i < 3 * n; i++) {
        const double exact = (double) f->layer.c[i / n][i % n];
        wrong += (layer[i] - exact) * (layer[i] - exact);
        all += exact * exact;
    }
    const double rel_l2 = sqrt(wrong / all) + of_exact;
    print_message("# %s: %zu sources, %zu groups, %zu clusters, rel_l2 %.2e, "
                  "bound %.2e\n", f->path, src->n, polygons.groups,
                  polygons.clusters, rel_l2, bound);
    if (!(rel_l2 <= 1e-2) || !(rel_l2 <= bound))
        fail_msg("%s: rel_l2 %g, bound %g", f->path, rel_l2, bound);
    worst->frames++;
    worst->rel_l2 = fmax(worst->rel_l2, rel_l2);
    free(layer);
    gp_polygons_free(&polygons);
}

static void every_frame_of_the_data_is_within_a_hundredth(void **state)
{
    const struct gp_read_params read = GP_READ_DEFAULTS;
    const struct gp_sensor_params sense = GP_SENSOR_DEFAULTS;
    struct gp_kernel k;
    struct gp_glare g = {0};
    struct worst worst = {0};
    if (!data_frames)
        skip_for(NO_DATA);
    k = scene_model("eye", 255, 0.0);
    const int step = getenv("GLAREPP_TEST_QUICK") ? 9 : 1;
    for (int i = 0; i < data_frames; i += step) {
        struct gp_frame f = {0};
        struct gp_sources src = {0};
        // (what cannot be read, or has no colour, is for io's suite data)
        if (gp_read_frame(NULL, &read, data_frame[i], &f) == GP_OK &&
            gp_frame_w(&f) <= WIDEST &&
            gp_sense(NULL, &sense, &f, &src) == GP_OK && src.n) {
            scene_limit(&src);
            check_frame(&f, &src, &k, &g, &worst);
        }
        gp_sources_free(&src);
        gp_frame_free(&f);
    }
    print_message("# worst of %d frames: rel_l2 %.2e\n", worst.frames,
                  worst.rel_l2);
    assert_true(worst.frames > 0);
    gp_glare_close(&g);
    gp_kernel_free(&k);
}

SUITE_OF(splat_data, list_data_frames, free_data_frames,
    every_frame_of_the_data_is_within_a_hundredth)
