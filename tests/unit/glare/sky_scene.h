// SPDX-License-Identifier: Apache-2.0
/* Levels of a model, lamps and layers, for tests of glare/sky. */
#ifndef GP_SKY_SCENE_H
#define GP_SKY_SCENE_H

#include "unit.h"
#include "glare/model/model_priv.h"
#include "glare/sky/sky_priv.h"
#include "glare_scene.h"
#include "model_scene.h"

/* A model whose channels differ. */
#define TINT "spencer:light=scotopic,halo=1"

/* Parameters of frames of a projection; places count from the first pixel. */
static inline struct gp_sky_params sky_params(const char *recipe,
                                              enum gp_projecting kind, int w,
                                              int h, double fov,
                                              double tolerance)
{
    const struct gp_field field = scene_field(w, h, fov / h, 1.0);
    struct gp_recipe r = scene_recipe(recipe);
    struct gp_sky_params p = {
        .n = 1,
        .share = {gp_recipe_value(&r, "share")},
        .w = w,
        .h = h,
        .tolerance = tolerance,
        .projection =
            gp_projection_of(kind, (struct gp_rect) {0, 0, w, h}, 1.0, fov),
    };
    memcpy(p.luminance, field.luminance, sizeof p.luminance);
    p.projection.x0 -= 0.5;
    p.projection.y0 -= 0.5;
    assert_true(r.model->angular(&r, &field, &p.part[0]));
    gp_recipe_free(&r);
    return p;
}

static inline struct gp_sky *sky_of(const struct gp_sky_params *p)
{
    struct gp_sky *s = NULL;
    assert_ok(gp_sky_make(NULL, p, &s));
    return s;
}

/* n lamps at random, or one at a place. */
static inline struct gp_sources sky_lamps(int w, int h, int n, int x, int y)
{
    const struct gp_sources like = {.w = w, .h = h};
    struct gp_sources s, blank;
    struct gp_source *list = scene_alloc((size_t) n, sizeof *list);
    uint32_t seed = 7u;
    assert_ok(gp_sources_make(NULL, &like, 0, &blank));
    gp_sources_finish(&blank);
    for (int i = 0; i < n; i++) {
        list[i].x = n == 1 ? x : (int) (scene_random(&seed) * (float) w);
        list[i].y = n == 1 ? y : (int) (scene_random(&seed) * (float) h);
        for (int c = 0; c < 3; c++)
            list[i].rgb[c] = 100.0f * (0.5f + scene_random(&seed));
    }
    assert_ok(gp_sources_join(NULL, &blank, list, (size_t) n, &s));
    gp_sources_free(&blank);
    free(list);
    return s;
}

static inline void sky_add(const struct gp_sky *sky,
                           const struct gp_sources *src, bool more, float stays,
                           struct gp_planes *layer)
{
    const struct gp_sky_drawing d = {
        .src = src,
        .add = more,
        .more = {stays, stays, stays},
        .layer = layer,
    };
    assert_ok(gp_sky_add(NULL, sky, &d));
}

static inline struct gp_planes sky_layer(const struct gp_sky *sky,
                                         const struct gp_sources *src)
{
    struct gp_planes p;
    assert_ok(
        gp_planes_make(NULL, "layer", (size_t) src->w * (size_t) src->h, &p));
    sky_add(sky, src, false, 0.0f, &p);
    return p;
}

static inline double *sky_exact(const struct gp_sky *sky,
                                const struct gp_sources *src)
{
    const size_t n = 3 * (size_t) src->w * (size_t) src->h;
    double *const v = scene_alloc(n, sizeof *v);
    memset(v, 0, n * sizeof *v);
    assert_ok(gp_sky_exact(NULL, sky, src, v));
    return v;
}

#endif
