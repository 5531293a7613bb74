// SPDX-License-Identifier: Apache-2.0
/* Nodes, lights and cameras; the scene as a whole. */
#include "scene/gltf/gltf_priv.h"

#include "core/memory.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// -- nodes --------------------------------------------------------------------

static gp_status read_node(const struct gp_gltf *g, int index,
                           struct gp_scene_node *n)
{
    const struct gp_json_place at = gp_gltf_at(g, "node", index);
    json_t *const o = gp_gltf_item(g, "nodes", index);
    gp_status st;
    *n = (struct gp_scene_node) {
        .parent = -1,
        .turn = {0, 0, 0, 1},
        .scale = {1, 1, 1},
    };
    n->matrix = json_object_get(o, "matrix");
    GP_TRY(gp_json_numbers(&at, o, "matrix", 16, -GP_GLTF_MOST, GP_GLTF_MOST,
                           n->local));
    GP_TRY(gp_json_numbers(&at, o, "translation", 3, -GP_GLTF_MOST,
                           GP_GLTF_MOST, n->move));
    GP_TRY(gp_json_numbers(&at, o, "rotation", 4, -GP_GLTF_MOST, GP_GLTF_MOST,
                           n->turn));
    GP_TRY(gp_json_numbers(&at, o, "scale", 3, -GP_GLTF_MOST, GP_GLTF_MOST,
                           n->scale));
    if (n->turn[0] == 0.0 && n->turn[1] == 0.0 && n->turn[2] == 0.0 &&
        n->turn[3] == 0.0)
        GP_TRY(gp_gltf_fail(&at, "\"rotation\" is 0, 0, 0, 0, no turn"));
    // column-major for column vectors is row-major for row vectors
    if (n->matrix && !(n->local[3] == 0.0 && n->local[7] == 0.0 &&
                       n->local[11] == 0.0 && n->local[15] == 1.0))
        GP_TRY(gp_gltf_fail(&at, "a \"matrix\" with perspective"));
out:
    return st;
}

static bool is_node(const struct gp_scene_nodes *s, const json_t *item)
{
    const double d = json_number_value(item);
    return json_is_number(item) && d >= 0.0 && d < s->n && d == floor(d);
}

/* Gives each node its parent, and refuses a second one. */
static gp_status link_nodes(const struct gp_gltf *g, struct gp_scene_nodes *s)
{
    for (int i = 0; i < s->n; i++) {
        json_t *const list = json_object_get(gp_gltf_item(g, "nodes", i),
                                             "children"), *item;
        const struct gp_json_place at = gp_gltf_at(g, "node", i);
        size_t k;
        if (list && !json_is_array(list))
            return gp_gltf_fail(&at, "\"children\" is not an array");
        json_array_foreach (list, k, item) {
            const double d = json_number_value(item);
            if (!is_node(s, item))
                return gp_gltf_fail(&at, "no such child (found %g, there are "
                                    "%d nodes)", d, s->n);
            struct gp_scene_node *const child = &s->at[(int) d];
            if (child->parent >= 0)
                return gp_gltf_fail(&at, "its child %g has another parent "
                                    "(node %d)", d, child->parent);
            child->parent = i;
        }
    }
    return GP_OK;
}

/* Orders the nodes, parents first. */
static gp_status order_nodes(const struct gp_gltf *g, struct gp_scene_nodes *s)
{
    int n = 0;
    for (int i = 0; i < s->n; i++) {
        int up = s->n; // from here on: the way to a node that is listed
        for (int k = i; k >= 0 && !s->at[k].listed; k = s->at[k].parent) {
            const struct gp_json_place at = gp_gltf_at(g, "node", i);
            if (up == n)
                return gp_gltf_fail(&at, "its parents are a circle");
            s->order[--up] = k;
        }
        for (; up < s->n; up++) {
            s->at[s->order[up]].listed = true;
            s->order[n++] = s->order[up];
        }
    }
    return GP_OK;
}

/* Marks the nodes of the file's scene; without one, all. */
static gp_status choose_nodes(const struct gp_gltf *g, struct gp_scene_nodes *s)
{
    const bool whole = gp_gltf_count(g, "scenes") == 0;
    json_t *roots = NULL, *item;
    size_t k;
    int scene;
    gp_status st = gp_gltf_index(g, &g->whole, g->root, "scene", "scenes",
                                 &scene);
    if (st)
        return st;
    if (!whole) // the specification leaves the choice; the first is usual
        roots = json_object_get(
            gp_gltf_item(g, "scenes", scene < 0 ? 0 : scene), "nodes");
    json_array_foreach (roots, k, item) {
        const double d = json_number_value(item);
        if (!is_node(s, item) || s->at[(int) d].parent >= 0)
            return gp_gltf_fail(&g->whole, "its scene holds no root (found %g "
                                "of %d nodes)", d, s->n);
        s->at[(int) d].placed = true;
    }
    for (int i = 0; i < s->n; i++) {
        struct gp_scene_node *const n = &s->at[s->order[i]];
        n->placed = whole || (n->parent >= 0 ? s->at[n->parent].placed
                                             : n->placed);
    }
    return GP_OK;
}

static gp_status read_nodes(struct gp_gltf *g, struct gp_scene *out)
{
    struct gp_scene_nodes *s;
    const int n = gp_gltf_count(g, "nodes");
    gp_status st;
    GP_TRY(gp_gltf_alloc(g, 1, sizeof *s, &out->nodes));
    s = out->nodes;
    GP_TRY(gp_gltf_alloc(g, (size_t) n, sizeof *s->at, &s->at));
    GP_TRY(gp_gltf_alloc(g, (size_t) n, sizeof *s->order, &s->order));
    s->n = n;
    for (int i = 0; i < n; i++)
        GP_TRY(read_node(g, i, &s->at[i]));
    GP_TRY(link_nodes(g, s));
    GP_TRY(order_nodes(g, s));
    GP_TRY(choose_nodes(g, s));
out:
    return st;
}

// -- lights and cameras -------------------------------------------------------

/* Reads a light's size from the extras of `o`, its node or itself. */
static gp_status read_size(const struct gp_json_place *at, json_t *o,
                           struct gp_scene_light *l)
{
    json_t *const extras = json_object_get(o, "extras");
    double radians = 0.0;
    gp_status st;
    GP_TRY(
        gp_json_number(at, extras, "ball_radius", 0.0, GP_GLTF_MOST, &l->ball));
    if (l->kind != GP_LIGHT_DIRECTIONAL)
        return GP_OK;
    GP_TRY(gp_json_number(at, extras, "angle", 0.0, M_PI / 2, &radians));
    if (radians > 0.0)
        l->degrees = radians * (180.0 / M_PI);
    GP_TRY(gp_json_number(at, extras, "angle_deg", 0.0, 90.0, &l->degrees));
out:
    return st;
}

static json_t *lights_of(const struct gp_gltf *g)
{
    return json_object_get(gp_gltf_extension(g->root, "KHR_lights_punctual"),
                           "lights");
}

static gp_status read_light(const struct gp_gltf *g, int index,
                            struct gp_scene_light *l)
{
    static const char *const kinds[] = {"directional", "point", "spot", NULL};
    const struct gp_json_place place = gp_gltf_at(g, "light", index);
    const struct gp_json_place *const at = &place;
    json_t *const o = json_array_get(lights_of(g), (size_t) index);
    json_t *const spot = json_object_get(o, "spot");
    int kind = -1;
    gp_status st;
    *l = (struct gp_scene_light) {
        .color = {1.0, 1.0, 1.0}, .intensity = 1.0, .range = INFINITY,
        .outer = M_PI / 4,
    };
    if (!json_is_object(o))
        return gp_gltf_fail(at, "not an object");
    GP_TRY(gp_json_choice(at, o, "type", kinds, &kind));
    if (kind < 0)
        GP_TRY(gp_gltf_fail(at, "no \"type\""));
    l->kind = (enum gp_scene_light_kind) kind;
    GP_TRY(gp_json_numbers(at, o, "color", 3, 0.0, 1e6, l->color));
    GP_TRY(gp_json_number(at, o, "intensity", 0.0, 1e12, &l->intensity));
    GP_TRY(gp_json_number(at, o, "range", 0.0, GP_GLTF_MOST, &l->range));
    GP_TRY(
        gp_json_number(at, spot, "innerConeAngle", 0.0, M_PI / 2, &l->inner));
    GP_TRY(gp_json_number(at, spot, "outerConeAngle", 0.0, M_PI / 2 + 1e-6,
                          &l->outer));
    if (!(l->range > 0.0))
        GP_TRY(gp_gltf_fail(at, "\"range\" is not over 0 (found %g)",
                            l->range));
    if (l->inner > l->outer)
        GP_TRY(gp_gltf_fail(at, "\"innerConeAngle\" %g is over "
                            "\"outerConeAngle\" %g", l->inner, l->outer));
    gp_gltf_name(o, l->name);
    GP_TRY(read_size(at, o, l));
out:
    return st;
}

/* Reads camera `index`; *perspective: it is one. */
static gp_status read_camera(const struct gp_gltf *g, int index,
                             bool *perspective, struct gp_scene_camera *c)
{
    static const char *const kinds[] = {"perspective", "orthographic", NULL};
    const struct gp_json_place at = gp_gltf_at(g, "camera", index);
    json_t *const o = gp_gltf_item(g, "cameras", index);
    json_t *const p = json_object_get(o, "perspective");
    double far = INFINITY;
    int kind = -1;
    gp_status st;
    *c = (struct gp_scene_camera) {0};
    GP_TRY(gp_json_choice(&at, o, "type", kinds, &kind));
    if (kind < 0)
        GP_TRY(gp_gltf_fail(&at, "no \"type\""));
    *perspective = kind == 0;
    gp_gltf_name(o, c->name);
    if (kind == 1)
        return GP_OK;
    GP_TRY(gp_json_number(&at, p, "yfov", 1e-6, M_PI - 1e-6, &c->yfov));
    GP_TRY(gp_json_number(&at, p, "znear", 0.0, GP_GLTF_MOST, &c->near));
    GP_TRY(gp_json_number(&at, p, "zfar", 0.0, GP_GLTF_MOST, &far));
    if (!(c->yfov > 0.0) || !(far > c->near))
        GP_TRY(gp_gltf_fail(&at, "no \"yfov\", or \"zfar\" not over \"znear\""));
out:
    return st;
}

// -- what is placed -----------------------------------------------------------

static gp_status place_node(struct gp_gltf *g, int index, struct gp_scene *out)
{
    const int defined = (int) json_array_size(lights_of(g));
    const struct gp_json_place at = gp_gltf_at(g, "node", index);
    json_t *const o = gp_gltf_item(g, "nodes", index);
    char name[GP_SCENE_NAME];
    bool perspective = false;
    int mesh, cam, light = -1;
    gp_status st;
    gp_gltf_name(o, name);
    GP_TRY(gp_gltf_index(g, &at, o, "mesh", "meshes", &mesh));
    GP_TRY(gp_gltf_index(g, &at, o, "camera", "cameras", &cam));
    GP_TRY(gp_json_int(&at, gp_gltf_extension(o, "KHR_lights_punctual"),
                       "light", 0, INT_MAX, &light));
    if (light >= defined)
        GP_TRY(gp_gltf_fail(&at, "no such light (found %d, the file has %d)",
                            light, defined));
    g->odd[GP_GLTF_SKINS] |= json_object_get(o, "skin") != NULL;
    g->odd[GP_GLTF_COPIES] |=
        gp_gltf_extension(o, "EXT_mesh_gpu_instancing") && mesh >= 0;
    g->odd[GP_GLTF_HIDDEN] |= json_is_false(json_object_get(
        gp_gltf_extension(o, "KHR_node_visibility"), "visible"));
    if (mesh >= 0 && !gp_box_empty(out->mesh[mesh].box))
        out->object[out->objects++] =
            (struct gp_object) {.mesh = mesh, .node = index};
    if (light >= 0) {
        struct gp_scene_light *const l = &out->light[out->lights++];
        GP_TRY(read_light(g, light, l));
        l->node = index;
        GP_TRY(read_size(&at, o, l));
        if (*name)
            memcpy(l->name, name, sizeof name);
    }
    if (cam >= 0) {
        struct gp_scene_camera *const c = &out->camera[out->cameras];
        GP_TRY(read_camera(g, cam, &perspective, c));
        c->node = index;
        if (*name)
            memcpy(c->name, name, sizeof name);
        out->cameras += perspective;
        g->odd[GP_GLTF_FLAT] |= !perspective;
    }
out:
    return st;
}

static gp_status place_all(struct gp_gltf *g, struct gp_scene *out)
{
    const struct gp_scene_nodes *const nodes = out->nodes;
    struct gp_scene_light light;
    struct gp_scene_camera camera;
    size_t objects = 0, lights = 0, cameras = 0; // at most
    bool perspective;
    gp_status st;
    // a bad one is an error also where no node has it
    for (int i = 0; i < (int) json_array_size(lights_of(g)); i++)
        GP_TRY(read_light(g, i, &light));
    for (int i = 0; i < gp_gltf_count(g, "cameras"); i++)
        GP_TRY(read_camera(g, i, &perspective, &camera));
    for (int i = 0; i < nodes->n; i++) {
        json_t *const o = gp_gltf_item(g, "nodes", i);
        objects += json_object_get(o, "mesh") != NULL;
        lights += json_object_get(o, "extensions") != NULL;
        cameras += json_object_get(o, "camera") != NULL;
    }
    GP_TRY(gp_gltf_alloc(g, objects, sizeof *out->object, &out->object));
    GP_TRY(gp_gltf_alloc(g, lights, sizeof *out->light, &out->light));
    GP_TRY(gp_gltf_alloc(g, cameras, sizeof *out->camera, &out->camera));
    for (int i = 0; i < nodes->n; i++) {
        if (nodes->at[i].placed)
            GP_TRY(place_node(g, i, out));
    }
out:
    return st;
}

// -- the scene ----------------------------------------------------------------

static void warn_of_odd(const struct gp_gltf *g)
{
    static const char *const text[GP_GLTF_ODD] = {
        [GP_GLTF_BLENDED] = "blended materials hide light where their alpha is "
                            "at least 0.5",
        [GP_GLTF_GLASS] = "glass (KHR_materials_transmission) of a factor "
                          "under 0.5, or with a texture, hides all light, "
                          "other glass none",
        [GP_GLTF_BLIND] = "textures of cut-outs are not read; they count as "
                          "opaque",
        [GP_GLTF_MORPHS] = "morph targets are not supported; meshes keep their "
                           "base shape",
        [GP_GLTF_FADED] = "alpha of vertices (COLOR_0) is not read; cut-outs "
                          "have that of their material only; bake it into the "
                          "texture",
        [GP_GLTF_TWICE] = "two animations move a node the same way; the first "
                          "counts",
        [GP_GLTF_SKINS] = "skins are not supported; meshes keep the pose they "
                          "are stored in",
        [GP_GLTF_COPIES] = "instances of one node (EXT_mesh_gpu_instancing) "
                           "are not supported; its mesh is placed once",
        [GP_GLTF_HIDDEN] = "hidden nodes (KHR_node_visibility) are not "
                           "supported; they are placed as the others",
        [GP_GLTF_FLAT] = "orthographic cameras are not supported and left out",
    };
    for (int i = 0; i < GP_GLTF_ODD; i++) {
        if (g->odd[i])
            gp_say(g->log, GP_LEVEL_WARN, "%s: %s", g->path, text[i]);
    }
}

gp_status gp_scene_read(const struct gp_log *log, const char *path,
                        enum glarepp_up up,
                        const struct gp_scene_images *images,
                        struct gp_scene *out)
{
    struct gp_gltf g = {.images = images};
    struct gp_scene s = {0};
    gp_status st;
    GP_TRY(gp_gltf_open(log, path, &g));
    s.path = gp_strdup(path);
    if (!s.path)
        GP_TRY(gp_no_memory(log, path));
    GP_TRY(gp_gltf_materials(&g, &s));
    GP_TRY(gp_gltf_meshes(&g, &s));
    GP_TRY(read_nodes(&g, &s));
    GP_TRY(gp_gltf_animations(&g, &s));
    GP_TRY(place_all(&g, &s));
    warn_of_odd(&g);
    s.nodes->turned = up == GLAREPP_UP_Z;
    gp_scene_pose(&s, s.start);
    *out = s;
    s = (struct gp_scene) {0}; // the caller's
out:
    gp_scene_free(&s);
    gp_gltf_close(&g);
    return st;
}

void gp_scene_free(struct gp_scene *s)
{
    for (int i = 0; i < s->cutouts; i++) {
        if (s->cutout[i].owner == i)
            gp_free(s->cutout[i].alpha);
    }
    for (int i = 0; s->nodes && i < s->nodes->keys; i++) {
        gp_free(s->nodes->key[i].time);
        gp_free(s->nodes->key[i].value);
    }
    if (s->nodes) {
        gp_free(s->nodes->at);
        gp_free(s->nodes->order);
        gp_free(s->nodes->key);
    }
    void *const block[] = {
        s->nodes,    s->position, s->uv,     s->index, s->submesh, s->mesh,
        s->material, s->cutout,   s->object, s->light, s->camera,
    };
    for (size_t i = 0; i < sizeof block / sizeof *block; i++)
        gp_free(block[i]);
    free((char *) (uintptr_t) s->path);
    *s = (struct gp_scene) {0};
}
