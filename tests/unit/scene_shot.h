// SPDX-License-Identifier: Apache-2.0
/* Pictures of scenes in memory by plain rays, and what lights do to them: the
 * truth of sets, shares and relit frames. */
#ifndef GP_TESTS_SCENE_SHOT_H
#define GP_TESTS_SCENE_SHOT_H

#include "scene/sets/sets_priv.h"
#include "scene_rays.h"

enum { SHOT_MOST = 96 * 64 };
#define SHOT_NEAR 0.05
#define SHOT_FAR 9e8 // under GP_DEPTH_HUGE

/* A frame of a scene: its camera, and the visible point of each pixel. */
struct shot {
    struct gp_rect window;
    int w, pixels;
    struct gp_camera camera;
    struct gp_v3 eye, point[SHOT_MOST];
    int object[SHOT_MOST]; // -1: none
    float depth[SHOT_MOST];
};

/* Returns the direction through a pixel's centre, 1 long along the axis. */
static inline struct gp_v3 shot_through(const struct gp_camera *c,
                                        struct gp_rect window, int x, int y)
{
    const double u = (x + 0.5 - window.x0) / gp_rect_w(window);
    const double v = (y + 0.5 - window.y0) / gp_rect_h(window);
    return gp_v3_sub(gp_camera_point(c, u, v, 2.0),
                     gp_camera_point(c, u, v, 1.0));
}

static inline void shot_take(const struct gp_scene *s, struct gp_camera c,
                             struct gp_v3 eye, int w, int h, struct shot *shot)
{
    shot->window = (struct gp_rect) {0, 0, w, h};
    shot->w = w;
    shot->pixels = w * h;
    shot->camera = c;
    shot->eye = eye;
    for (int i = 0; i < w * h; i++) {
        const struct gp_v3 to = shot_through(&c, shot->window, i % w, i / w);
        const struct ray_hit hit = ray_scene(s, eye, to, SHOT_NEAR, SHOT_FAR);
        shot->object[i] = hit.object;
        shot->point[i] = gp_v3_add(eye, gp_v3_scale(to, hit.t));
        shot->depth[i] = hit.object < 0 ? 1e10f : (float) hit.t;
    }
}

static inline struct gp_sets_view shot_view(const struct shot *shot)
{
    return (struct gp_sets_view) {.camera = shot->camera, .near = SHOT_NEAR,
                                  .display = shot->window,
                                  .window = shot->window,
                                  .depth = shot->depth};
}

/* The first object that a light meets on the way to a point; -1: none. The way
 * is searched from the point on, whose own surface is near, so that a light may
 * be far away. */
static inline int shot_blocker(const struct gp_scene *s,
                               const struct gp_scene_light *light,
                               struct gp_v3 p)
{
    const bool sun = light->kind == GP_LIGHT_DIRECTIONAL;
    const struct gp_v3 to = sun ? gp_v3_scale(light->along, -1.0)
                                : gp_v3_sub(light->at, p);
    const double most = sun ? 1e11 : 1.0;
    struct ray_hit hit = {-1, (1e-6 + 1e-12 * gp_v3_length(p)) /
                                  fmax(gp_v3_length(to), 1e-5)};
    for (int last = -1;; last = hit.object) {
        hit = ray_scene(s, p, to, hit.t * (1.0 + 1e-9), most);
        if (hit.object < 0)
            return last;
    }
}

static inline bool shot_reaches(const struct gp_scene_light *light,
                                struct gp_v3 p)
{
    if (light->kind == GP_LIGHT_DIRECTIONAL)
        return true;
    const struct gp_v3 to = gp_v3_sub(p, light->at);
    return gp_v3_length(to) < light->range &&
           (light->kind == GP_LIGHT_POINT ||
            gp_v3_dot(gp_v3_unit(to), light->along) > cos(light->outer));
}

#endif
