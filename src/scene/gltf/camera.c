// SPDX-License-Identifier: Apache-2.0
/* The scene's cameras beside the frame's: names, projection, comparison, and
 * the axis that points up. */
#include "scene/gltf/gltf_priv.h"
#include "core/maths.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int count_named(const struct gp_scene *s, const char *name)
{
    int n = 0;
    for (int i = 0; i < s->cameras; i++)
        n += strcmp(s->camera[i].name, name) == 0;
    return n;
}

const struct gp_scene_camera *gp_scene_find_camera(const struct gp_scene *s,
                                                   const char *name)
{
    if (!name)
        return s->cameras == 1 ? s->camera : NULL;
    const int n = count_named(s, name);
    char node[16];
    for (int i = 0; i < s->cameras; i++) {
        snprintf(node, sizeof node, "%d", s->camera[i].node);
        if (n == 1 ? strcmp(s->camera[i].name, name) == 0
                   : n == 0 && strcmp(node, name) == 0)
            return &s->camera[i];
    }
    return NULL;
}

gp_status gp_scene_no_camera(const struct gp_log *log, const struct gp_scene *s,
                             const char *name)
{
    char names[512] = "(it has none)"; // cut to fit
    size_t at = 0;
    for (int i = 0; i < s->cameras && at < sizeof names; i++) {
        const struct gp_scene_camera *const c = &s->camera[i];
        const char *const comma = i ? ", " : "";
        at += (size_t) (count_named(s, c->name) > 1
                            ? snprintf(names + at, sizeof names - at,
                                       "%s%d (%s)", comma, c->node, c->name)
                            : snprintf(names + at, sizeof names - at, "%s%s",
                                       comma, c->name));
    }
    return gp_fail_at(log, GP_ERR_USAGE, "scene.camera", "%s: has %d cameras "
                      "of that name (found \"%s\"), it has: %s", s->path,
                      count_named(s, name), name, names);
}

gp_status gp_scene_camera_make(const struct gp_log *log,
                               const struct gp_scene *s,
                               const struct gp_scene_camera *c, double aspect,
                               struct gp_camera *out)
{
    const double tall = gp_tan(0.5 * c->yfov), wide = tall * aspect;
    const double *const m = c->to_camera;
    double ndc[16];
    for (int i = 0; i < 4; i++) { // x, y, z, w of a row
        const double w = -m[4 * i + 2];
        ndc[4 * i] = 0.5 * w + 0.5 * m[4 * i] / wide;
        ndc[4 * i + 1] = 0.5 * w - 0.5 * m[4 * i + 1] / tall;
        ndc[4 * i + 2] = w;
        ndc[4 * i + 3] = w;
    }
    ndc[14] -= 1.0; // depth, (w - 1) / w: any that is no multiple of w
    return gp_camera_make(log, s->path, m, ndc, GLAREPP_NDC_SPEC, out);
}

/* Returns the length of the diagonal of a box round all objects and lights of
 * a place, at least 1. */
static double diagonal(const struct gp_scene *s)
{
    struct gp_box box = GP_BOX_EMPTY;
    for (int i = 0; i < s->objects; i++)
        box = gp_box_join(box, s->object[i].box);
    const double length = gp_v3_length(gp_v3_sub(box.hi, box.lo));
    return s->objects ? fmax(length, 1.0) : 100.0;
}

double gp_scene_apart(const struct gp_scene *s, const struct gp_camera *a,
                      const struct gp_camera *b, struct gp_rect display)
{
    const double far = diagonal(s);
    double most = 0.0;
    for (int i = 0; i < 18; i++) {
        const double x = 0.5 * (i % 3), y = 0.5 * (i / 3 % 3);
        const struct gp_v3 at =
            gp_camera_point(a, x, y, i < 9 ? far : 0.1 * far);
        const double p[3] = {at.x, at.y, at.z};
        const struct gp_projected from = gp_camera_project(a, display, p, 1.0);
        const struct gp_projected to = gp_camera_project(b, display, p, 1.0);
        if (from.behind || to.behind)
            return INFINITY;
        most = fmax(most, gp_hypot(from.x - to.x, from.y - to.y));
    }
    return most;
}

/* Returns how far a camera of the scene is from the frame's: the distance of
 * the eyes over `across`, the scene's diagonal, and of the axes. The world is z
 * up when `turned`, and the scene is not turned. */
static double camera_distance(const struct gp_scene_camera *c, bool turned,
                              const struct gp_camera *frame, double across)
{
    const double *const m = c->to_camera;
    struct gp_v3 axis = {-m[2], -m[6], -m[10]}, eye = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++)
        eye = gp_v3_sub(eye, gp_v3_scale(gp_column(m, k), m[12 + k]));
    if (turned) {
        axis = (struct gp_v3) {axis.x, -axis.z, axis.y};
        eye = (struct gp_v3) {eye.x, -eye.z, eye.y};
    }
    const double *const f = frame->to_ndc;
    const struct gp_v3 view = gp_v3_unit(gp_column(f, 3));
    return gp_v3_length(gp_v3_sub(gp_camera_eye(frame), eye)) / across +
           gp_v3_length(gp_v3_sub(view, axis));
}

enum glarepp_up gp_scene_find_up(const struct gp_scene *s,
                                 const struct gp_camera *frame)
{
    const double *const f = frame->to_ndc;
    const double across = diagonal(s);
    double y = INFINITY, z = INFINITY;
    for (int i = 0; i < s->cameras; i++) {
        y = fmin(y, camera_distance(&s->camera[i], false, frame, across));
        z = fmin(z, camera_distance(&s->camera[i], true, frame, across));
    }
    if (s->cameras)
        return z < y ? GLAREPP_UP_Z : GLAREPP_UP_Y;
    // the picture's y grows downwards: without the part along the axis
    const struct gp_v3 w = gp_v3_unit(gp_column(f, 3));
    const struct gp_v3 down = gp_column(f, 1);
    const struct gp_v3 side =
        gp_v3_sub(down, gp_v3_scale(w, gp_v3_dot(down, w)));
    return fabs(side.z) > fabs(side.y) ? GLAREPP_UP_Z : GLAREPP_UP_Y;
}
