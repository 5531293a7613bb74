/* The stage of --relight: the frame lit by lights of its scene, before the
 * sensors, so that what they light glares too. */
#include "app/stages.h"

#include "core/clock.h"
#include "core/depth.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/plane.h"
#include "scene/relight.h"
#include "scene/sets/sets.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double BLENDER = 1.0 / 683.0; // radiance a cd or lux

// -- channels -----------------------------------------------------------------

static const struct gp_layer_names normal_names = {
    "normals", {"N", "Normal", "normal", "Normals", "normals", NULL},
    {{"X", "Y", "Z"}, {"x", "y", "z"}, {"R", "G", "B"}},
};
static const struct gp_layer_names albedo_names = {
    "albedo", {"albedo", "Albedo", "DiffCol", "diffuse_albedo",
               "diffuse_color", NULL},
    {{"R", "G", "B"}, {"r", "g", "b"}, {"red", "green", "blue"}},
};

// -- the surfaces of a frame --------------------------------------------------

/* Planes of a frame, and its surfaces that borrow from them. */
struct surfaces {
    struct gp_plane depth, mask, normal[3], albedo[3];
    struct gp_surfaces f;
    double near; // no surface is nearer
};

static void free_surfaces(struct surfaces *s)
{
    gp_plane_free(&s->depth);
    gp_plane_free(&s->mask);
    for (int c = 0; c < 3; c++) {
        gp_plane_free(&s->normal[c]);
        gp_plane_free(&s->albedo[c]);
    }
}

static gp_status read_surfaces(struct gp_run *r, struct gp_frame_state *fs,
                               struct surfaces *out)
{
    struct gp_sun_files files = {r->s, fs->job};
    const struct gp_sun_reader reader = gp_sun_reader_of(&files);
    const struct gp_run_scene *const own = &r->scene;
    gp_status st;
    if (!own->has_camera)
        return gp_fail(fs->log, GP_ERR_USAGE, "%s: --relight needs a camera, "
                       "and neither the frame nor the scene has one; give "
                       "--camera", fs->job->input);
    if (r->s->sun.depth_type != GP_DEPTH_Z)
        return gp_fail(fs->log, GP_ERR_USAGE, "--relight: needs distances "
                       "along the view axis; give --depth-type z, and depth of "
                       "that kind");
    GP_TRY(reader.planes(reader.user, fs->log, &fs->frame, &out->depth,
                         &out->mask));
    if (!out->depth.v)
        return gp_fail(fs->log, GP_ERR_USAGE, "%s: --relight needs depth, and "
                       "no channel is; name one with --depth",
                       fs->job->input);
    GP_TRY(gp_read_vectors(fs->log, &r->s->input.read, &fs->frame,
                           &normal_names, out->normal));
    GP_TRY(gp_read_vectors(fs->log, &r->s->input.read, &fs->frame,
                           &albedo_names, out->albedo));
    out->f = (struct gp_surfaces) {
        .rgb = &fs->frame.rgb, .data = fs->frame.data,
        .camera = own->frame_camera, .display = fs->frame.display,
        .z = &out->depth, .normal = out->normal, .albedo = out->albedo,
        .normal_of_camera = r->s->scene.normal_space == GP_NORMALS_CAMERA,
    };
    const size_t n = (size_t) gp_rect_w(out->depth.window) *
                     (size_t) gp_rect_h(out->depth.window);
    double near = INFINITY;
    for (size_t i = 0; i < n; i++) {
        if (out->depth.v[i] > 0.0f)
            near = fmin(near, (double) out->depth.v[i]);
    }
    out->near = near < (double) GP_DEPTH_HUGE ? 0.999 * near : 1.0;
out:
    return st;
}

// -- the axis of normals that points up ---------------------------------------

enum { UP_ACROSS = 256 }; // pixels that are looked at across the picture

/* Returns the sample of a plane, or 0 outside. */
static double sample_of(const struct gp_plane *p, int x, int y)
{
    const struct gp_rect w = p->window;
    const bool inside = x >= w.x0 && x < w.x1 && y >= w.y0 && y < w.y1;
    return inside ? (double) p->v[(ptrdiff_t) (y - w.y0) * gp_rect_w(w) + x -
                                  w.x0] : 0.0;
}

/* Finds the place that a pixel shows; false: none. */
static bool place_at(const struct gp_surfaces *f, int x, int y,
                     struct gp_v3 *place)
{
    const struct gp_camera *const c = &f->camera;
    const double z = sample_of(f->z, x, y);
    const double w = gp_rect_w(f->display), h = gp_rect_h(f->display);
    if (!(z > 0.0 && z < (double) GP_DEPTH_HUGE))
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
static void turn_normals(const struct gp_frame_state *fs, struct surfaces *s)
{
    const struct gp_rect d = s->depth.window;
    const double fits = 0.95; // cosine
    const int step = 1 + gp_max(gp_rect_w(d), gp_rect_h(d)) / UP_ACROSS;
    int looked = 0, only_y = 0, only_z = 0;
    for (int y = d.y0 + 1; y < d.y1 - 1; y += step) {
        for (int x = d.x0 + 1; x < d.x1 - 1; x += step) {
            struct gp_v3 own;
            const struct gp_v3 n = {sample_of(&s->normal[0], x, y),
                                    sample_of(&s->normal[1], x, y),
                                    sample_of(&s->normal[2], x, y)};
            const double length = gp_v3_length(n);
            if (!(fabs(length - 1.0) < 0.01) || !normal_at(&s->f, x, y, &own))
                continue;
            const struct gp_v3 turned = {n.x, n.z, -n.y};
            const bool is_y = fabs(gp_v3_dot(own, n)) > fits * length;
            const bool is_z = fabs(gp_v3_dot(own, turned)) > fits * length;
            looked++;
            only_y += is_y && !is_z;
            only_z += is_z && !is_y;
        }
    }
    const int more = only_y > only_z ? only_y : only_z;
    if (more < 4 * (only_y + only_z - more) || 8 * more <= looked) {
        gp_say(fs->log, GP_LEVEL_WARN, "%s: has no camera, and its normals "
               "fit its depth y up as well as z up (%d and %d of %d pixels); "
               "y up is taken, give --scene-up or --normal-space",
               fs->job->input, only_y, only_z, looked);
    } else if (only_z == more) {
        const struct gp_plane y = s->normal[1];
        const size_t n = (size_t) gp_rect_w(y.window) *
                         (size_t) gp_rect_h(y.window);
        for (size_t i = 0; i < n; i++)
            y.v[i] = -y.v[i];
        s->normal[1] = s->normal[2];
        s->normal[2] = y;
        gp_say(fs->log, GP_LEVEL_INFO, "%s: normals are of a world that is z "
               "up (%d of %d pixels)", fs->job->input, only_z, looked);
    }
}

// -- lights -------------------------------------------------------------------

/* Lights that are added together. */
struct batch {
    struct gp_relight_pass pass[GP_RELIGHT_PASSES];
    int fact[GP_RELIGHT_PASSES]; // of each pass, in facts.scene.relit
    int *list;                   // of casters: s->objects for each pass; owned
    int n;
};

/* Lists a light, and its pass where it may reach a pixel. */
static void list_light(const struct gp_run *r, struct gp_frame_state *fs,
                       struct gp_sets *sets, int light, struct batch *b)
{
    const struct gp_scene *const s = &r->scene.scene;
    const int fact = fs->facts.scene.relits++;
    struct gp_relit_facts *const facts = &fs->facts.scene.relit[fact];
    *facts = (struct gp_relit_facts) {.name = s->light[light].name};
    if (!gp_sets_light(sets, light))
        return;
    const uint8_t *const flag = gp_sets_flags(sets);
    const struct gp_scissor cut = gp_sets_scissor(sets);
    int *const list = b->list + (size_t) b->n * (size_t) s->objects;
    int casters = 0;
    for (int i = 0; i < s->objects; i++) {
        if (flag[i] & GP_SET_S)
            list[casters++] = i;
    }
    b->pass[b->n] = (struct gp_relight_pass) {
        .light = &s->light[light], .caster = list, .casters = casters,
        .light_scale = r->s->scene.light_scale > 0.0f
                           ? (double) r->s->scene.light_scale : BLENDER,
        .cut = cut.rect, .near = cut.near * (1.0 - 1e-6),
        .far = cut.far * (1.0 + 1e-6),
    };
    b->fact[b->n++] = fact;
    facts->casters = casters;
}

/* Adds the lights of a batch to the frame's colour, and empties it. */
static gp_status add_lights(struct gp_run *r, struct gp_frame_state *fs,
                            const struct surfaces *surfaces, struct batch *b)
{
    struct gp_relit facts[GP_RELIGHT_PASSES];
    const gp_status st =
        gp_relight(fs->log, &r->scene.scene, &r->scene.meshes, &surfaces->f,
                   b->pass, b->n, facts);
    if (st)
        return st;
    for (int i = 0; i < b->n; i++) {
        struct gp_relit_facts *const f = &fs->facts.scene.relit[b->fact[i]];
        f->pixels = facts[i].pixels;
        f->rays = facts[i].rays;
        gp_say(fs->log, GP_LEVEL_INFO, "%s: %s lights %lld pixels, %d objects "
               "may cast shadows, %lld rays", fs->job->input, f->name,
               f->pixels, f->casters, f->rays);
    }
    b->n = 0;
    return GP_OK;
}

/* Finds the lights that --relight names: sets asked[i]. */
static gp_status find_lights(const struct gp_log *log, const struct gp_run *r,
                             unsigned char *asked)
{
    const struct gp_scene *const s = &r->scene.scene;
    const struct gp_texts *const names = &r->s->scene.relight;
    for (int k = 0; k < names->n; k++) {
        const bool all = strcmp(names->at[k], "all") == 0;
        bool found = all;
        for (int i = 0; i < s->lights; i++) {
            const bool is = all || strcmp(names->at[k], s->light[i].name) == 0;
            asked[i] |= is;
            found |= is;
        }
        if (!found)
            return gp_fail(log, GP_ERR_USAGE, "--relight: %s has no light of "
                           "that name (found \"%s\"); it has %d, the first is "
                           "%s", r->s->scene.path, names->at[k], s->lights,
                           s->lights ? s->light[0].name : "none");
    }
    return GP_OK;
}

/* Warns of lights that are named and light no pixel; where "all" is named, if
 * no light does. */
static void warn_of_dark(const struct gp_run *r,
                         const struct gp_frame_state *fs)
{
    const struct gp_scene_facts *const f = &fs->facts.scene;
    const struct gp_texts *const names = &r->s->scene.relight;
    long long lit = 0;
    for (int i = 0; i < f->relits; i++)
        lit += f->relit[i].pixels;
    for (int k = 0; k < names->n; k++) {
        const char *const name = names->at[k];
        bool dark = strcmp(name, "all") == 0 && lit == 0;
        for (int i = 0; i < f->relits; i++)
            dark |= f->relit[i].pixels == 0 &&
                    strcmp(f->relit[i].name, name) == 0;
        if (dark)
            gp_say(fs->log, GP_LEVEL_WARN, "%s: --relight %s lights no pixel: "
                   "out of reach, hidden, or on albedo of 0; leave it out, or "
                   "check --scene-start", fs->job->input,
                   gp_printable(name).text);
    }
}

gp_status gp_run_relight(struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_scene *const s = &r->scene.scene;
    struct surfaces surfaces = {0};
    struct gp_sets *sets = NULL;
    unsigned char *asked = NULL;
    struct batch batch = {0};
    int *visible = NULL;
    gp_status st;
    GP_TRY(gp_alloc(fs->log, "objects", (size_t) s->objects + 1,
                    sizeof *visible, &visible));
    GP_TRY(gp_alloc_zero(fs->log, "lights", (size_t) s->lights + 1, 1, &asked));
    GP_TRY(gp_alloc(fs->log, "objects", (size_t) s->objects + 1,
                    GP_RELIGHT_PASSES * sizeof *batch.list, &batch.list));
    GP_TRY(gp_alloc(fs->log, "lights", (size_t) s->lights + 1,
                    sizeof *fs->facts.scene.relit, &fs->facts.scene.relit));
    GP_TRY(find_lights(fs->log, r, asked));
    GP_TRY(read_surfaces(r, fs, &surfaces));
    if (!r->scene.settled && !surfaces.f.normal_of_camera)
        turn_normals(fs, &surfaces);
    const struct gp_sets_view view = {
        .camera = r->scene.frame_camera, .display = fs->frame.display,
        .window = surfaces.depth.window, .near = surfaces.near,
        .depth = surfaces.depth.v,
    };
    GP_TRY(gp_sets_open(fs->log, s, &view, GP_SETS_ALL | GP_SETS_DEPTHS,
                        &sets));
    for (int i = 0; i < s->objects; i++) {
        visible[surfaces.f.objects] = i;
        surfaces.f.objects += (gp_sets_flags(sets)[i] & GP_SET_V) != 0;
    }
    surfaces.f.object = visible;
    for (int i = 0; i < s->lights; i++) {
        if (asked[i])
            list_light(r, fs, sets, i, &batch);
        if (batch.n == GP_RELIGHT_PASSES || (batch.n > 0 && i == s->lights - 1))
            GP_TRY(add_lights(r, fs, &surfaces, &batch));
    }
    warn_of_dark(r, fs);
out:
    gp_sets_close(&sets);
    free_surfaces(&surfaces);
    gp_free(visible);
    gp_free(batch.list);
    gp_free(asked);
    return st;
}
