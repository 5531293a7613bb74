// SPDX-License-Identifier: Apache-2.0
/* The lights of a scene that are named: passes from its visibility sets. */
#include "scene/relight_priv.h"

#include "core/depth.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "scene/sets/sets.h"

#include <math.h>
#include <string.h>

static const double BLENDER = 1.0 / 683.0; // radiance a cd or lux

// -- the axis of normals that points up ---------------------------------------

enum { UP_ACROSS = 256 }; // pixels that are looked at across the picture

/* Finds the place that a pixel shows; false: none. */
static bool place_at(const struct gp_surfaces *f, int x, int y,
                     struct gp_v3 *place)
{
    const struct gp_camera *const c = &f->camera;
    const double z = gp_surface_depth(f, x, y);
    const double w = gp_rect_w(f->display), h = gp_rect_h(f->display);
    if (z == 0.0)
        return false;
    *place = gp_camera_point(c, (x + 0.5 - f->display.x0) / w,
                             (y + 0.5 - f->display.y0) / h, z);
    return true;
}

/* Finds the normal of the depths around a pixel; false: they are no plane. */
static bool normal_at(const struct gp_surfaces *f, int x, int y,
                      struct gp_v3 *normal)
{
    struct gp_v3 at, left, right, up, down;
    if (!place_at(f, x, y, &at) || !place_at(f, x - 1, y, &left) ||
        !place_at(f, x + 1, y, &right) || !place_at(f, x, y - 1, &up) ||
        !place_at(f, x, y + 1, &down))
        return false;
    const struct gp_v3 a = gp_v3_sub(right, left), b = gp_v3_sub(down, up);
    const struct gp_v3 n = gp_v3_unit(gp_v3_cross(a, b));
    const double most = 0.05 * (gp_v3_length(a) + gp_v3_length(b));
    *normal = n;
    return fabs(gp_v3_dot(n, gp_v3_sub(left, at))) < most &&
           fabs(gp_v3_dot(n, gp_v3_sub(up, at))) < most;
}

/* Turns normals of a world that is z up to the scene's, which is y up, where
 * only so they fit the frame's own depths: of a frame without a camera nothing
 * else says so. Warns where both or neither fit. */
static void turn_normals(const struct gp_log *log, const char *path,
                         const struct gp_surfaces *own)
{
    const struct gp_rect d = own->z->window;
    struct gp_plane *const normal = own->normal;
    const double fits = 0.95; // cosine
    const int step = 1 + gp_max(gp_rect_w(d), gp_rect_h(d)) / UP_ACROSS;
    int looked = 0, only_y = 0, only_z = 0;
    for (int y = d.y0 + 1; y < d.y1 - 1; y += step) {
        for (int x = d.x0 + 1; x < d.x1 - 1; x += step) {
            struct gp_v3 at;
            const struct gp_v3 n = {gp_surface_sample(&normal[0], x, y),
                                    gp_surface_sample(&normal[1], x, y),
                                    gp_surface_sample(&normal[2], x, y)};
            const double length = gp_v3_length(n);
            if (!(fabs(length - 1.0) < 0.01) || !normal_at(own, x, y, &at))
                continue;
            const struct gp_v3 turned = {n.x, n.z, -n.y};
            const bool is_y = fabs(gp_v3_dot(at, n)) > fits * length;
            const bool is_z = fabs(gp_v3_dot(at, turned)) > fits * length;
            looked++;
            only_y += is_y && !is_z;
            only_z += is_z && !is_y;
        }
    }
    const int more = only_y > only_z ? only_y : only_z;
    if (more < 4 * (only_y + only_z - more) || 8 * more <= looked) {
        gp_say_at(log, GP_LEVEL_WARN, "scene.camera_normals", "%s: has no "
                  "camera, and its normals fit its depth y up as well as z up "
                  "(%d and %d of %d pixels), y up is taken", path, only_y,
                  only_z, looked);
    } else if (only_z == more) {
        const struct gp_plane y = normal[1];
        const size_t n = gp_rect_pixels(y.window);
        for (size_t i = 0; i < n; i++)
            y.v[i] = -y.v[i];
        normal[1] = normal[2];
        normal[2] = y;
        gp_say(log, GP_LEVEL_INFO, "%s: normals are of a world that is z "
               "up (%d of %d pixels)", path, only_z, looked);
    }
}

// -- lights -------------------------------------------------------------------

/* A frame while lights are added: those of a batch in one call. */
struct lighting {
    const struct gp_log *log;
    const struct gp_scene *s;
    struct gp_meshes *meshes;
    const struct gp_relit_frame *f;
    struct gp_surfaces surfaces;
    struct gp_sets *sets;
    struct glarepp_relit *out;
    int lit;
    struct gp_relight_pass pass[GP_RELIGHT_PASSES]; // of the last of out[]
    int *list; // of casters, s->objects for each pass, then visible ones; owned
    int n;
};

/* Lists a light and its pass, which is empty where it reaches no pixel. */
static void list_light(struct lighting *l, int light)
{
    const struct gp_scene *const s = l->s;
    const struct gp_scissor cut = gp_sets_light(l->sets, light);
    const uint8_t *const flag = gp_sets_flags(l->sets);
    int *const list = l->list + (size_t) l->n * (size_t) s->objects;
    int casters = 0;
    for (int i = 0; i < s->objects; i++) {
        if (flag[i] & GP_SET_S)
            list[casters++] = i;
    }
    l->pass[l->n++] = (struct gp_relight_pass) {
        .light = &s->light[light], .caster = list, .casters = casters,
        .light_scale = l->f->light_scale > 0.0 ? l->f->light_scale : BLENDER,
        .cut = cut.rect, .near = cut.near * (1.0 - 1e-6),
        .far = cut.far * (1.0 + 1e-6),
    };
    l->out[l->lit++] = (struct glarepp_relit) {
        .name = s->light[light].name, .casters = casters,
    };
}

/* Adds the lights of a batch to the frame's colour, and empties it. */
static gp_status add_lights(struct lighting *l)
{
    struct glarepp_relit *const out = l->out + l->lit - l->n;
    const gp_status st =
        gp_relight(l->log, l->s, l->meshes, &l->surfaces, l->pass, l->n, out);
    for (int i = 0; i < l->n && !st; i++) {
        if (gp_rect_empty(l->pass[i].cut))
            continue;
        gp_say(l->log, GP_LEVEL_INFO, "%s: %s lights %lld pixels, %d objects "
               "may cast shadows, %lld rays", l->f->path, out[i].name,
               out[i].pixels, out[i].casters, out[i].rays);
    }
    l->n = 0;
    return st;
}

gp_status gp_relit_find(const struct gp_log *log, const struct gp_scene *s,
    const char *const *name, int names, unsigned char *asked)
{
    for (int k = 0; k < names; k++) {
        const bool all = strcmp(name[k], "all") == 0;
        bool found = all;
        for (int i = 0; i < s->lights; i++) {
            const bool is = all || strcmp(name[k], s->light[i].name) == 0;
            if (asked)
                asked[i] |= is;
            found |= is;
        }
        if (!found)
            return gp_fail_at(log, GP_ERR_USAGE, "scene.relight", "%s: has no "
                              "light of that name (found \"%s\"), it has %d, "
                              "the first is %s", s->path, name[k], s->lights,
                              s->lights ? s->light[0].name : "none");
    }
    return GP_OK;
}

/* Warns of lights that are named and light no pixel; where "all" is named, if
 * no light does. */
static void warn_of_dark(const struct lighting *l, const char *const *name,
                         int names)
{
    long long lit = 0;
    for (int i = 0; i < l->lit; i++)
        lit += l->out[i].pixels;
    for (int k = 0; k < names; k++) {
        bool dark = strcmp(name[k], "all") == 0 && lit == 0;
        for (int i = 0; i < l->lit; i++)
            dark |= l->out[i].pixels == 0 &&
                    strcmp(l->out[i].name, name[k]) == 0;
        if (dark)
            gp_say_at(l->log, GP_LEVEL_WARN, "scene.relight.dark", "%s: %s "
                      "lights no pixel: out of reach, hidden, or on albedo of "
                      "0", l->f->path, gp_printable(name[k]).text);
    }
}

/* Returns a distance that no surface is nearer than. */
static double nearest(const struct gp_plane *depth)
{
    const size_t n = gp_rect_pixels(depth->window);
    double near = INFINITY;
    for (size_t i = 0; i < n; i++) {
        if (depth->v[i] > 0.0f)
            near = fmin(near, (double) depth->v[i]);
    }
    return near < (double) GP_DEPTH_HUGE ? 0.999 * near : 1.0;
}

gp_status gp_relit_add(const struct gp_log *log, const struct gp_scene *s,
    struct gp_meshes *meshes, const struct gp_relit_frame *f,
    const char *const *name, int names, struct glarepp_relit **out, int *lit)
{
    struct lighting l = {
        .log = log, .s = s, .meshes = meshes, .f = f,
        .surfaces = f->surfaces,
    };
    unsigned char *asked = NULL;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "lights", (size_t) s->lights + 1, 1, &asked));
    GP_TRY(gp_alloc(log, "objects", (size_t) s->objects + 1,
                    (GP_RELIGHT_PASSES + 1) * sizeof *l.list, &l.list));
    GP_TRY(gp_alloc(log, "lights", (size_t) s->lights + 1, sizeof *l.out,
                    &l.out));
    GP_TRY(gp_relit_find(log, s, name, names, asked));
    if (f->up_unknown && !f->surfaces.normal_of_camera)
        turn_normals(log, f->path, &l.surfaces);
    const struct gp_plane *const z = f->surfaces.z;
    const struct gp_sets_view view = {
        .camera = f->surfaces.camera, .display = f->surfaces.display,
        .window = z->window, .near = nearest(z), .depth = z->v,
    };
    GP_TRY(gp_sets_open(log, s, &view, GP_SETS_ALL | GP_SETS_DEPTHS, &l.sets));
    int *const visible = l.list + GP_RELIGHT_PASSES * (size_t) s->objects;
    for (int i = 0; i < s->objects; i++) {
        visible[l.surfaces.objects] = i;
        l.surfaces.objects += (gp_sets_flags(l.sets)[i] & GP_SET_V) != 0;
    }
    l.surfaces.object = visible;
    for (int i = 0; i < s->lights; i++) {
        if (asked[i])
            list_light(&l, i);
        if (l.n == GP_RELIGHT_PASSES || (l.n > 0 && i == s->lights - 1))
            GP_TRY(add_lights(&l));
    }
    warn_of_dark(&l, name, names);
    *out = l.out;
    *lit = l.lit;
    l.out = NULL;
out:
    gp_sets_close(&l.sets);
    gp_free(l.list);
    gp_free(l.out);
    gp_free(asked);
    return st;
}
