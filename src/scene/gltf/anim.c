// SPDX-License-Identifier: Apache-2.0
/* Keys of nodes (specification, 3.11 and appendix C), and places at a time. */
#include "scene/gltf/gltf_priv.h"

#include "core/maths.h"
#include "core/memory.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* Numbers of a value, by path. */
static const int components_of[GP_KEY_PATHS] = {3, 4, 3};

// -- reading ------------------------------------------------------------------

static gp_status read_keys(struct gp_gltf *g, const struct gp_json_place *at,
                           json_t *sampler, struct gp_keys *out)
{
    static const char *const ways[] = {"STEP", "LINEAR", "CUBICSPLINE", NULL};
    struct gp_gltf_accessor input, output;
    int from, to, way = GP_KEY_LINEAR;
    gp_status st;
    GP_TRY(gp_json_choice(at, sampler, "interpolation", ways, &way));
    GP_TRY(gp_gltf_index(g, at, sampler, "input", "accessors", &from));
    GP_TRY(gp_gltf_index(g, at, sampler, "output", "accessors", &to));
    if (from < 0 || to < 0)
        GP_TRY(gp_gltf_fail(at, "a sampler without \"input\" or \"output\""));
    GP_TRY(gp_gltf_accessor(g, from, &input));
    GP_TRY(gp_gltf_accessor(g, to, &output));
    const int values = way == GP_KEY_CUBIC ? 3 : 1;
    const int components = components_of[out->path];
    if (output.count / values != input.count || output.count % values)
        GP_TRY(gp_gltf_fail(at, "%d values for %d keys", output.count,
                            input.count));
    out->way = (enum gp_key_way) way;
    out->n = input.count;
    GP_TRY(
        gp_gltf_alloc(g, (size_t) input.count, sizeof *out->time, &out->time));
    GP_TRY(gp_gltf_alloc(g, (size_t) output.count * (size_t) components,
                         sizeof *out->value, &out->value));
    GP_TRY(gp_gltf_floats(&input, 1, out->time));
    GP_TRY(gp_gltf_floats(&output, components, out->value));
    for (int i = 1; i < out->n; i++) {
        if (!(out->time[i] > out->time[i - 1]))
            GP_TRY(gp_gltf_fail(&input.place, "keys that do not rise (%g after "
                                "%g s)", (double) out->time[i],
                                (double) out->time[i - 1]));
    }
out:
    return st;
}

static gp_status read_channel(struct gp_gltf *g, const struct gp_json_place *at,
                              json_t *animation, json_t *o,
                              struct gp_scene_nodes *nodes, uint8_t *moved)
{
    static const char *const paths[] = {"translation", "rotation", "scale",
                                        "weights", NULL};
    json_t *const samplers = json_object_get(animation, "samplers");
    json_t *const target = json_object_get(o, "target");
    int node, path = -1, sampler = -1;
    gp_status st;
    GP_TRY(gp_json_int(at, o, "sampler", 0, INT_MAX, &sampler));
    GP_TRY(gp_gltf_index(g, at, target, "node", "nodes", &node));
    GP_TRY(gp_json_choice(at, target, "path", paths, &path));
    json_t *const s = json_array_get(samplers, (size_t) sampler);
    if (!json_is_object(s) || path < 0)
        GP_TRY(gp_gltf_fail(at, "a channel without sampler or path (sampler %d "
                            "of %zu)", sampler, json_array_size(samplers)));
    if (node < 0)
        return GP_OK; // an extension's target
    if (path == GP_KEY_PATHS) {
        g->odd[GP_GLTF_MORPHS] = true;
        return GP_OK;
    }
    if (nodes->at[node].matrix)
        GP_TRY(gp_gltf_fail(at, "it moves node %d, which has a matrix", node));
    if (moved[node] & 1 << path) {
        g->odd[GP_GLTF_TWICE] = true;
        return GP_OK;
    }
    moved[node] = (uint8_t) (moved[node] | 1 << path);
    struct gp_keys *const k = &nodes->key[nodes->keys++];
    k->node = node;
    k->path = (enum gp_key_path) path;
    GP_TRY(read_keys(g, at, s, k));
out:
    return st;
}

gp_status gp_gltf_animations(struct gp_gltf *g, struct gp_scene *out)
{
    struct gp_scene_nodes *const nodes = out->nodes;
    const int n = gp_gltf_count(g, "animations");
    uint8_t *moved = NULL; // bits of the paths of each node that have keys
    size_t channels = 0;
    gp_status st;
    for (int i = 0; i < n; i++)
        channels += json_array_size(
            json_object_get(gp_gltf_item(g, "animations", i), "channels"));
    if (!channels)
        return GP_OK;
    GP_TRY(gp_gltf_alloc(g, channels, sizeof *nodes->key, &nodes->key));
    GP_TRY(gp_gltf_alloc(g, (size_t) nodes->n, 1, &moved));
    for (int i = 0; i < n; i++) {
        json_t *const o = gp_gltf_item(g, "animations", i), *channel;
        const struct gp_json_place at = gp_gltf_at(g, "animation", i);
        size_t k;
        json_array_foreach (json_object_get(o, "channels"), k, channel) {
            GP_TRY(read_channel(g, &at, o, channel, nodes, moved));
        }
    }
    for (int i = 0; i < nodes->keys; i++) {
        const struct gp_keys *const k = &nodes->key[i];
        const double first = (double) k->time[0];
        const double last = (double) k->time[k->n - 1];
        out->start = i ? fmin(out->start, first) : first;
        out->end = i ? fmax(out->end, last) : last;
    }
    st = GP_OK;
out:
    gp_free(moved);
    return st;
}

// -- values at a time ---------------------------------------------------------

/* Spherical interpolation of unit quaternions, the shorter way. */
static void turn_between(const float *a, const float *b, double t, double *out)
{
    double dot = 0.0;
    for (int c = 0; c < 4; c++)
        dot += (double) a[c] * (double) b[c];
    const double sign = dot < 0.0 ? -1.0 : 1.0;
    const double angle = gp_acos(fmin(fabs(dot), 1.0));
    const double s = gp_sin(angle);
    const double wa = s > 1e-6 ? gp_sin((1.0 - t) * angle) / s : 1.0 - t;
    const double wb = s > 1e-6 ? gp_sin(t * angle) / s : t;
    for (int c = 0; c < 4; c++)
        out[c] = wa * (double) a[c] + sign * wb * (double) b[c];
}

static void value_at(const struct gp_keys *k, double seconds, double *out)
{
    const int components = components_of[k->path];
    const size_t step =
        (size_t) (k->way == GP_KEY_CUBIC ? 3 * components : components);
    int lo = 0, hi = k->n - 1; // the last key not after `seconds`, if any
    while (lo < hi) {
        const int middle = lo + (hi - lo + 1) / 2;
        if ((double) k->time[middle] <= seconds)
            lo = middle;
        else
            hi = middle - 1;
    }
    const float *const a = k->value + (size_t) lo * step;
    const float *const va = a + (k->way == GP_KEY_CUBIC ? components : 0);
    const double from = (double) k->time[lo];
    if (lo == k->n - 1 || seconds <= from || k->way == GP_KEY_STEP) {
        for (int c = 0; c < components; c++)
            out[c] = (double) va[c];
        return;
    }
    const double length = (double) k->time[lo + 1] - from;
    const double t = (seconds - from) / length;
    const float *const b = a + step;
    if (k->way == GP_KEY_LINEAR && k->path == GP_KEY_TURN) {
        turn_between(a, b, t, out);
        return;
    }
    for (int c = 0; c < components; c++) {
        if (k->way == GP_KEY_LINEAR) {
            out[c] = (1.0 - t) * (double) a[c] + t * (double) b[c];
            continue;
        }
        // appendix C.5: tangent out of a, tangent into b
        const double t2 = t * t, t3 = t2 * t;
        out[c] = (2.0 * t3 - 3.0 * t2 + 1.0) * (double) va[c] +
                 length * (t3 - 2.0 * t2 + t) * (double) a[2 * components + c] +
                 (3.0 * t2 - 2.0 * t3) * (double) b[components + c] +
                 length * (t3 - t2) * (double) b[c];
    }
}

// -- places -------------------------------------------------------------------

/* The matrix of scale, then turn, then move, for row vectors. */
static void matrix_of(const struct gp_scene_node *n, double m[16])
{
    const double *const q = n->turn;
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] +
                               q[3] * q[3]);
    const double s = length > 0.0 ? 1.0 / length : 0.0;
    const double x = q[0] * s, y = q[1] * s, z = q[2] * s;
    const double w = length > 0.0 ? q[3] * s : 1.0;
    const double turn[9] = {
        1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),
        2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
        2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y),
    };
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            m[4 * i + j] = n->scale[i] * turn[3 * i + j];
        m[4 * i + 3] = 0.0;
        m[12 + i] = n->move[i];
    }
    m[15] = 1.0;
}

static struct gp_v3 row_of(const double m[16], int i)
{
    return (struct gp_v3) {m[4 * i], m[4 * i + 1], m[4 * i + 2]};
}

/* The inverse of a camera's place, without its scale: cameras have none. */
static void camera_from(const double world[16], double out[16])
{
    const struct gp_v3 at = row_of(world, 3);
    struct gp_v3 z = gp_v3_unit(row_of(world, 2));
    struct gp_v3 x = gp_v3_unit(gp_v3_cross(row_of(world, 1), z));
    if (!(gp_v3_dot(x, x) > 0.5 && gp_v3_dot(z, z) > 0.5)) {
        x = (struct gp_v3) {1.0, 0.0, 0.0}; // it looks nowhere
        z = (struct gp_v3) {0.0, 0.0, 1.0};
    }
    const struct gp_v3 y = gp_v3_cross(z, x);
    const double m[16] = {
        x.x, y.x, z.x, 0.0,
        x.y, y.y, z.y, 0.0,
        x.z, y.z, z.z, 0.0,
        -gp_v3_dot(at, x), -gp_v3_dot(at, y), -gp_v3_dot(at, z), 1.0,
    };
    memcpy(out, m, sizeof m);
}

// -- posing -------------------------------------------------------------------

enum { MOST_MOVES = 1 << 20 };

void gp_bounds_set(const struct gp_scene *s, struct gp_object *o)
{
    const struct gp_mesh *const m = &s->mesh[o->mesh];
    const struct gp_submesh *const part = &s->submesh[m->first];
    const struct gp_submesh *const last = part + m->submeshes - 1;
    const int indices = last->first + last->count - part->first;
    const bool corners = (long long) indices * s->objects > MOST_MOVES;
    struct gp_box box = GP_BOX_EMPTY;
    struct gp_v3 c = {0.0, 0.0, 0.0};
    double most = 0.0;                     // squared
    for (int pass = 0; pass < 2; pass++) { // the box, then the sphere
        const uint32_t *const index = &s->index[part->first];
        for (int i = 0; i < (corners ? 8 : indices); i++) {
            const struct gp_v3 at =
                gp_move(o->to_world, corners ? gp_box_corner(&m->box, i)
                                             : gp_scene_vertex(s, index[i]));
            const struct gp_v3 d = gp_v3_sub(at, c);
            if (pass == 0)
                box = gp_box_with(box, at);
            else
                most = fmax(most, gp_v3_dot(d, d));
        }
        c = gp_box_middle(&box);
    }
    o->box = box;
    o->radius = sqrt(most) * (1.0 + 1e-12); // rounding never leaves one out
}

void gp_scene_pose(struct gp_scene *s, double seconds)
{
    // of the root: glTF's (x, y, z), or (x, -z, y)
    static const double root[2][16] = {
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
        {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1},
    };
    struct gp_scene_nodes *const nodes = s->nodes;
    s->time = seconds;
    // keys are floats: the time of a frame is rounded as that of its key was
    const double rounded = (double) (float) seconds;
    for (int i = 0; i < nodes->keys; i++) {
        const struct gp_keys *const k = &nodes->key[i];
        struct gp_scene_node *const n = &nodes->at[k->node];
        value_at(k, rounded, k->path == GP_KEY_MOVE   ? n->move
                             : k->path == GP_KEY_TURN ? n->turn
                                                      : n->scale);
    }
    for (int i = 0; i < nodes->n; i++) {
        struct gp_scene_node *const n = &nodes->at[nodes->order[i]];
        if (!n->matrix)
            matrix_of(n, n->local);
        gp_matrix_mul(n->local, n->parent >= 0 ? nodes->at[n->parent].world
                                               : root[nodes->turned],
                      n->world);
        bool good = true;
        for (int k = 0; k < 16; k++)
            good = good && fabs(n->world[k]) <= GP_GLTF_MOST;
        if (!good) { // nowhere: at the origin, with size 0
            memset(n->world, 0, sizeof n->world);
            n->world[15] = 1.0;
        }
    }
    for (int i = 0; i < s->objects; i++) {
        struct gp_object *const o = &s->object[i];
        memcpy(o->to_world, nodes->at[o->node].world, sizeof o->to_world);
        gp_bounds_set(s, o);
    }
    for (int i = 0; i < s->lights; i++) {
        struct gp_scene_light *const l = &s->light[i];
        const double *const world = nodes->at[l->node].world;
        l->at = row_of(world, 3);
        l->along = gp_v3_scale(gp_v3_unit(row_of(world, 2)), -1.0);
        if (!(gp_v3_dot(l->along, l->along) > 0.5))
            l->along = (struct gp_v3) {0.0, -1.0, 0.0}; // it points nowhere
    }
    for (int i = 0; i < s->cameras; i++)
        camera_from(nodes->at[s->camera[i].node].world, s->camera[i].to_camera);
}

void gp_scene_turn(struct gp_scene *s, enum glarepp_up up)
{
    s->nodes->turned = up == GLAREPP_UP_Z;
    gp_scene_pose(s, s->time);
}
