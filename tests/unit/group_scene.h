/* Sources of made-up frames, their groups, and how far a group's polygon is
 * spread. */
#ifndef GP_TESTS_GROUP_SCENE_H
#define GP_TESTS_GROUP_SCENE_H

#include "glare/splat/splat_priv.h"
#include "glare_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const struct gp_sensor_params over_one = {1.0f, 0.0f, 65504.0f};

static inline struct gp_sources scene_sources(int w, int h, int x0, int y0,
                                              enum light light, uint32_t seed)
{
    struct gp_frame f = scene_frame(w, h, x0, y0, light, seed);
    struct gp_sources s;
    assert_int_equal(gp_sense(NULL, &over_one, &f, &s), GP_OK);
    gp_frame_free(&f);
    return s;
}

static inline struct gp_polygons group(const struct gp_sources *s,
                                       const struct gp_splat_params *p)
{
    struct gp_polygons q;
    assert_int_equal(gp_polygons_make(NULL, s, p, &q), GP_OK);
    assert_int_equal(q.n, q.groups + q.clusters);
    return q;
}

/* The variance that drawing `q` by bilinear samples of a box gives it, in
 * pixels^2. */
static inline double spread_of(int box, const struct gp_polygon *q)
{
    double f[2] = {(double) q->x - (box - 1) / 2.0,
                   (double) q->y - (box - 1) / 2.0};
    double sum = (box * box - 1) / 12.0;
    for (int i = 0; i < 2; i++) {
        f[i] -= floor(f[i]);
        sum += f[i] * (1.0 - f[i]) / 2.0;
    }
    return sum;
}

#endif
