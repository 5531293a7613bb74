// SPDX-License-Identifier: Apache-2.0
/* scene: what a frame alone cannot give (O'Rorke, GPU Gems 15): lights that are
 * off screen or hidden, and the objects before them, from a glTF 2.0 file.
 *
 * The scene's world is the frame's: gltf/ turns glTF's (y up) to it. Units are
 * the file's, metres by glTF. Matrices are for row vectors, p' = p * m,
 * m[4 * row + column], as in core/camera.h.
 *
 * A scene is read once and posed for each frame; between poses it is const, and
 * any thread may read it. */
#ifndef GP_SCENE_SCENE_H
#define GP_SCENE_SCENE_H

#include "core/camera.h"
#include "core/maths.h"
#include "core/minmax.h"
#include "core/status.h"
#include "glarepp.h"

#include <stdbool.h>
#include <stdint.h>

enum { GP_SCENE_NAME = 64 }; // bytes of a name, with its null byte

/* An axis-aligned box; empty when lo.x > hi.x. */
struct gp_box {
    struct gp_v3 lo, hi;
};

#define GP_BOX_EMPTY                                  \
    ((struct gp_box) {{INFINITY, INFINITY, INFINITY}, \
                      {-INFINITY, -INFINITY, -INFINITY}})

static inline bool gp_box_empty(struct gp_box b)
{
    return !(b.lo.x <= b.hi.x && b.lo.y <= b.hi.y && b.lo.z <= b.hi.z);
}

/* Returns corner i of 8: bit 0 is x, 1 y, 2 z; set is the high side. */
static inline struct gp_v3 gp_box_corner(const struct gp_box *b, int i)
{
    return (struct gp_v3) {i & 1 ? b->hi.x : b->lo.x, i & 2 ? b->hi.y : b->lo.y,
                           i & 4 ? b->hi.z : b->lo.z};
}

/* Returns the middle of a box, and half its sides. */
static inline struct gp_v3 gp_box_middle(const struct gp_box *b)
{
    return gp_v3_scale(gp_v3_add(b->lo, b->hi), 0.5);
}

static inline struct gp_v3 gp_box_half(const struct gp_box *b)
{
    return gp_v3_scale(gp_v3_sub(b->hi, b->lo), 0.5);
}

/* Returns the smallest box that holds a and b, of which either may be empty. */
static inline struct gp_box gp_box_join(struct gp_box a, struct gp_box b)
{
    return (struct gp_box) {
        {gp_mind(a.lo.x, b.lo.x), gp_mind(a.lo.y, b.lo.y),
         gp_mind(a.lo.z, b.lo.z)},
        {gp_maxd(a.hi.x, b.hi.x), gp_maxd(a.hi.y, b.hi.y),
         gp_maxd(a.hi.z, b.hi.z)},
    };
}

/* Returns the smallest box that holds b and p. */
static inline struct gp_box gp_box_with(struct gp_box b, struct gp_v3 p)
{
    return gp_box_join(b, (struct gp_box) {p, p});
}

/* Returns column c of p' = p * m, for a matrix of row vectors. */
static inline double gp_move_column(const double m[16], struct gp_v3 p, int c)
{
    return p.x * m[c] + p.y * m[4 + c] + p.z * m[8 + c] + m[12 + c];
}

/* Returns p' of an affine matrix. */
static inline struct gp_v3 gp_move(const double m[16], struct gp_v3 p)
{
    return (struct gp_v3) {gp_move_column(m, p, 0), gp_move_column(m, p, 1),
                           gp_move_column(m, p, 2)};
}

/* Coverage of a texture, of a material that is cut out by it. Sampled
 * bilinearly on the base level (no mip maps) with `wrap`; u right, v down,
 * (0, 0) the upper left corner. */
enum gp_wrap { GP_WRAP_REPEAT, GP_WRAP_CLAMP, GP_WRAP_MIRROR };
struct gp_cutout {
    int w, h;
    uint16_t *alpha;          // w * h codes, 65535 is 1; owned by cutout
                              // `owner`
    int image;                // its number in the file
    int owner;                // itself, or an earlier one of the same image
    enum gp_wrap wrap[2];     // of u and v
};

/* A material as far as it hides or takes light. */
struct gp_material {
    float base[4];   // linear colour and alpha; where no texture says otherwise
    float cutoff;    // MASK: opaque where base[3] * texture's alpha >= cutoff;
                     // 0: opaque everywhere. BLEND: hides as MASK at 0.5, and
                     // the scene has a warning; 2: glass, which hides nothing
    int cutout;      // index; -1: alpha is base[3] alone
};

/* True for a material that a texture cuts out. */
static inline bool gp_material_cut(const struct gp_material *m)
{
    return m->cutoff > 0.0f && m->cutout >= 0;
}

/* True for a material that is cut away everywhere. */
static inline bool gp_material_gone(const struct gp_material *m)
{
    return m->cutoff > 0.0f && m->cutout < 0 && m->base[3] < m->cutoff;
}

/* Triangles of one material: a batch. Three vertices each, in the order of
 * `index`, counter-clockwise from the front. */
struct gp_submesh {
    int first, count;  // of gp_scene.index; count is a multiple of 3
    int material;
};

/* A mesh in its own space; submeshes [first, first + submeshes). */
struct gp_mesh {
    int first, submeshes;
    struct gp_box box;
};

/* A mesh of at least one triangle in its place: what the sets hold, the paper's
 * object. */
struct gp_object {
    int mesh, node;
    double to_world[16];   // posed
    struct gp_box box;     // of the world, posed: holds every vertex
    double radius;         // of a sphere round its middle that does so
};

enum gp_scene_light_kind {
    GP_LIGHT_DIRECTIONAL, GP_LIGHT_POINT, GP_LIGHT_SPOT,
};

/* A light in its place (KHR_lights_punctual). */
struct gp_scene_light {
    enum gp_scene_light_kind kind;
    struct gp_v3 at;       // posed; not of a directional one
    struct gp_v3 along;    // unit, from the light, posed; not of a point
    double color[3];       // linear
    double intensity;      // cd; directional lux
    double range;          // > 0; INFINITY: no limit
    double inner, outer;   // half angles of a spot, radians
    double ball;           // radius of its lamp, extras.ball_radius; 0: not
                           // given
    double degrees;        // that a sun is wide, of extras.angle_deg or
                           // extras.angle, radians, of its node, else its own;
                           // 0: not given
    int node;
    char name[GP_SCENE_NAME]; // of the node, else of the light
};

/* Returns the share of a light's intensity towards a unit vector: of a spot
 * clamp((cos a - cos outer) / (cos inner - cos outer), 0, 1)^2 at the angle a
 * from its axis (KHR_lights_punctual), else 1. */
static inline double gp_spot_share(const struct gp_scene_light *l,
                                   struct gp_v3 to)
{
    if (l->kind != GP_LIGHT_SPOT)
        return 1.0;
    const double outer = gp_cos(l->outer);
    const double soft = fmax(gp_cos(l->inner) - outer, 1e-6);
    const double edge = (gp_v3_dot(to, l->along) - outer) / soft;
    return edge <= 0.0 ? 0.0 : edge >= 1.0 ? 1.0 : edge * edge;
}

/* A camera of the scene (perspective). */
struct gp_scene_camera {
    double to_camera[16];  // posed; y up, it looks along -z
    double yfov;           // radians
    double near;           // 0: not given
    int node;
    char name[GP_SCENE_NAME];
};

struct gp_scene {
    const char *path;      // for messages; owned
    // geometry, as in the file
    float *position;       // 3 a vertex
    float *uv;             // 2 a vertex; 0 where the file has none
    uint32_t *index;       // of vertices; 3 a triangle
    int vertices, indices;
    struct gp_submesh *submesh;
    int submeshes;
    struct gp_mesh *mesh;
    int meshes;
    struct gp_material *material; // the last one is glTF's default
    int materials;
    struct gp_cutout *cutout;     // of each texture; alpha NULL: of no cut-out
    int cutouts;
    // what is placed, by gp_scene_pose()
    struct gp_object *object;
    int objects;
    struct gp_scene_light *light;
    int lights;
    struct gp_scene_camera *camera;
    int cameras;
    double start, end;     // of all keys, seconds; equal: nothing moves
    double time;           // posed
    struct gp_scene_nodes *nodes; // private to the reader
};

/* Returns vertex v of the scene, in its mesh's space. */
static inline struct gp_v3 gp_scene_vertex(const struct gp_scene *s, uint32_t v)
{
    const float *const p = &s->position[3 * (size_t) v];
    return (struct gp_v3) {(double) p[0], (double) p[1], (double) p[2]};
}

#endif
