// SPDX-License-Identifier: Apache-2.0
/* Scenes in memory, without a file: boxes, cards with holes, balls, rooms, and
 * random ones from a seed. Their world is z up.
 *
 *   struct gp_scene s = made_scene();
 *   const int box = made_box(&s, made_material(&s, 0.0f, -1));
 *   made_put(&s, box, (struct gp_v3) {0, 5, 1}, (struct gp_v3) {2, 2, 2}, 30.0);
 *   made_point(&s, (struct gp_v3) {0, 0, 4}, 100.0, 20.0);
 *   const struct gp_camera c = made_camera(&s, eye, at, 40.0, 16.0 / 9.0);
 *   made_free(&s);
 *
 * Functions that add return the index. Every block is from gp_resize(), as a
 * reader's; nodes is NULL. */
#ifndef GP_TESTS_SCENE_MADE_H
#define GP_TESTS_SCENE_MADE_H

#include "core/memory.h"
#include "unit.h"

#define MADE_PI 3.14159265358979323846

/* Makes room for one more element at the end of an array. */
#define MADE_GROW(array, count)                                               \
    made_grow((void **) (void *) &(array), sizeof *(array),                   \
              (size_t) (count) + 1)

static inline void made_grow(void **block, size_t size, size_t count)
{
    if (count == 1 || (count & (count - 1)) == 0) // doubles at powers of two
        assert_ok(gp_resize(NULL, "made", 2 * count * size, block));
}

/* In [0, 1): splitmix64, the upper bits. */
static inline double made_random(uint64_t *seed)
{
    uint64_t z = *seed += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double) ((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static inline double made_between(uint64_t *seed, double lo, double hi)
{
    return lo + (hi - lo) * made_random(seed);
}

static inline struct gp_v3 made_within(uint64_t *seed, struct gp_box box)
{
    const double x = made_between(seed, box.lo.x, box.hi.x);
    const double y = made_between(seed, box.lo.y, box.hi.y);
    const double z = made_between(seed, box.lo.z, box.hi.z);
    return (struct gp_v3) {x, y, z};
}

// -- materials and meshes ----------------------------------------------------

/* A grey material; cutoff 0: opaque; cutout -1: no texture. */
static inline int made_material(struct gp_scene *s, float cutoff, int cutout)
{
    MADE_GROW(s->material, s->materials);
    s->material[s->materials] = (struct gp_material) {
        .base = {0.5f, 0.5f, 0.5f, 1.0f}, .cutoff = cutoff, .cutout = cutout,
    };
    return s->materials++;
}

/* An empty scene with the default material. */
static inline struct gp_scene made_scene(void)
{
    struct gp_scene s = {.path = gp_strdup("made")};
    assert_non_null(s.path);
    made_material(&s, 0.0f, -1);
    return s;
}

static inline void made_free(struct gp_scene *s)
{
    for (int i = 0; i < s->cutouts; i++)
        gp_free(s->cutout[i].alpha);
    void *const blocks[] = {
        s->position, s->uv, s->index, s->submesh, s->mesh, s->material,
        s->cutout, s->object, s->light, s->camera,
        (void *) (uintptr_t) s->path,
    };
    for (size_t i = 0; i < COUNT(blocks); i++)
        gp_free(blocks[i]);
    memset(s, 0, sizeof *s);
}

/* A texture of n x n squares, alternately 1 and 0, `side` samples each. */
static inline int made_holes(struct gp_scene *s, int n, int side)
{
    MADE_GROW(s->cutout, s->cutouts);
    struct gp_cutout *const c = &s->cutout[s->cutouts];
    *c = (struct gp_cutout) {.w = n * side, .h = n * side};
    assert_ok(gp_alloc(NULL, "made", (size_t) c->w * (size_t) c->h,
                       sizeof *c->alpha, &c->alpha));
    for (int y = 0; y < c->h; y++) {
        for (int x = 0; x < c->w; x++)
            c->alpha[y * c->w + x] = (x / side + y / side) % 2 ? 0 : 65535;
    }
    return s->cutouts++;
}

static inline int made_vertex(struct gp_scene *s, double x, double y, double z,
                              double u, double v)
{
    const size_t n = (size_t) s->vertices;
    if (n == 0 || ((n + 1) & n) == 0) {
        assert_ok(gp_resize(NULL, "made", 6 * (n + 1) * sizeof(float),
                            (void **) (void *) &s->position));
        assert_ok(gp_resize(NULL, "made", 4 * (n + 1) * sizeof(float),
                            (void **) (void *) &s->uv));
    }
    const double p[] = {x, y, z}, t[] = {u, v};
    for (size_t i = 0; i < 3; i++)
        s->position[3 * n + i] = (float) p[i];
    for (size_t i = 0; i < 2; i++)
        s->uv[2 * n + i] = (float) t[i];
    return s->vertices++;
}

static inline void made_triangle(struct gp_scene *s, int a, int b, int c)
{
    const int v[] = {a, b, c};
    for (int i = 0; i < 3; i++) {
        MADE_GROW(s->index, s->indices);
        s->index[s->indices++] = (uint32_t) v[i];
    }
}

/* Two triangles, a b c d counter-clockwise. */
static inline void made_quad(struct gp_scene *s, int a, int b, int c, int d)
{
    made_triangle(s, a, b, c);
    made_triangle(s, a, c, d);
}

/* A part of the triangles since `first`, added to the last mesh when `more`,
 * else to one of its own. Returns the mesh. */
static inline int made_part(struct gp_scene *s, int first, int material,
                            bool more)
{
    MADE_GROW(s->submesh, s->submeshes);
    s->submesh[s->submeshes] =
        (struct gp_submesh) {first, s->indices - first, material};
    if (!more) {
        MADE_GROW(s->mesh, s->meshes);
        s->mesh[s->meshes++] = (struct gp_mesh) {
            .first = s->submeshes,
            .box = {{INFINITY, INFINITY, INFINITY},
                    {-INFINITY, -INFINITY, -INFINITY}},
        };
    }
    s->submeshes++;
    struct gp_mesh *const m = &s->mesh[s->meshes - 1];
    m->submeshes++;
    for (int i = first; i < s->indices; i++) {
        const float *const p = &s->position[3 * s->index[i]];
        const double x = (double) p[0], y = (double) p[1], z = (double) p[2];
        m->box.lo = (struct gp_v3) {fmin(m->box.lo.x, x), fmin(m->box.lo.y, y),
                                    fmin(m->box.lo.z, z)};
        m->box.hi = (struct gp_v3) {fmax(m->box.hi.x, x), fmax(m->box.hi.y, y),
                                    fmax(m->box.hi.z, z)};
    }
    return s->meshes - 1;
}

/* The cube [-1/2, 1/2]^3; each face has four vertices of its own, as exporters
 * write it. A bit of `open` leaves a face away: -x, +x, -y, +y, -z, +z. */
static inline int made_open_box(struct gp_scene *s, int material, unsigned open)
{
    static const int corner[6][4] = {
        {0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6},
    };
    const int first = s->indices;
    for (int f = 0; f < 6; f++) {
        int v[4];
        if (open >> f & 1)
            continue;
        for (int i = 0; i < 4; i++) {
            const int at = corner[f][i];
            v[i] = made_vertex(s, (at & 1) - 0.5, (at >> 1 & 1) - 0.5,
                               (at >> 2 & 1) - 0.5, i == 1 || i == 2, i > 1);
        }
        made_quad(s, v[0], v[1], v[2], v[3]);
    }
    return made_part(s, first, material, false);
}

static inline int made_box(struct gp_scene *s, int material)
{
    return made_open_box(s, material, 0);
}

/* The square [-1/2, 1/2]^2 of x and y at z = 0. */
static inline int made_card(struct gp_scene *s, int material)
{
    const int first = s->indices;
    const int a = made_vertex(s, -0.5, -0.5, 0.0, 0.0, 1.0);
    const int b = made_vertex(s, 0.5, -0.5, 0.0, 1.0, 1.0);
    const int c = made_vertex(s, 0.5, 0.5, 0.0, 1.0, 0.0);
    const int d = made_vertex(s, -0.5, 0.5, 0.0, 0.0, 0.0);
    made_quad(s, a, b, c, d);
    return made_part(s, first, material, false);
}

/* A ball of radius 1/2 in `rings` rings of 2 * rings faces; convex. */
static inline int made_ball(struct gp_scene *s, int material, int rings)
{
    const int first = s->indices, around = 2 * rings;
    int below = -1; // first vertex of the ring below
    for (int i = 0; i <= rings; i++) {
        const double a = MADE_PI * i / rings;
        const bool pole = i == 0 || i == rings;
        const int ring = s->vertices;
        for (int j = 0; j < (pole ? 1 : around); j++) {
            const double b = 2.0 * MADE_PI * j / around;
            const double r = pole ? 0.0 : 0.5 * sin(a);
            made_vertex(s, r * cos(b), r * sin(b), -0.5 * cos(a),
                        (double) j / around, 1.0 - (double) i / rings);
        }
        for (int j = 0; i > 0 && j < around; j++) {
            const int k = (j + 1) % around;
            if (i == 1)
                made_triangle(s, below, ring + k, ring + j);
            else if (pole)
                made_triangle(s, below + j, below + k, ring);
            else
                made_quad(s, below + j, below + k, ring + k, ring + j);
        }
        below = ring;
    }
    return made_part(s, first, material, false);
}

// -- what is placed ----------------------------------------------------------

static inline struct gp_v3 made_moved(const double m[16], struct gp_v3 p)
{
    return (struct gp_v3) {
        p.x * m[0] + p.y * m[4] + p.z * m[8] + m[12],
        p.x * m[1] + p.y * m[5] + p.z * m[9] + m[13],
        p.x * m[2] + p.y * m[6] + p.z * m[10] + m[14],
    };
}

/* Vertex `i` of the index array, in the world of an object. */
static inline struct gp_v3 made_corner(const struct gp_scene *s,
                                       const struct gp_object *o, int i)
{
    const float *const p = &s->position[3 * s->index[i]];
    return made_moved(o->to_world,
                      (struct gp_v3) {(double) p[0], (double) p[1],
                                      (double) p[2]});
}

/* Box and sphere of an object, from each of its vertices. */
static inline void made_bounds(const struct gp_scene *s, struct gp_object *o)
{
    const struct gp_mesh *const m = &s->mesh[o->mesh];
    struct gp_box b = GP_BOX_EMPTY;
    for (int pass = 0; pass < 2; pass++) {
        for (int k = m->first; k < m->first + m->submeshes; k++) {
            const int first = s->submesh[k].first, n = s->submesh[k].count;
            for (int i = first; i < first + n; i++) {
                const struct gp_v3 p = made_corner(s, o, i);
                b = gp_box_with(b, p);
                if (pass == 1)
                    o->radius = fmax(o->radius, (1.0 + 1e-12) * gp_v3_length(
                        gp_v3_sub(p, gp_box_middle(&b))));
            }
        }
    }
    o->box = b;
}

/* An object of a mesh; the matrix is for row vectors. */
static inline int made_place(struct gp_scene *s, int mesh, const double m[16])
{
    MADE_GROW(s->object, s->objects);
    struct gp_object *const o = &s->object[s->objects];
    *o = (struct gp_object) {.mesh = mesh, .node = s->objects};
    memcpy(o->to_world, m, sizeof o->to_world);
    made_bounds(s, o);
    return s->objects++;
}

/* The same, scaled by `size`, turned about z, then moved to `at`. */
static inline int made_put(struct gp_scene *s, int mesh, struct gp_v3 at,
                           struct gp_v3 size, double degrees)
{
    const double c = cos(degrees * MADE_PI / 180.0),
                 d = sin(degrees * MADE_PI / 180.0);
    const double m[16] = {
        size.x * c, size.x * d, 0.0, 0.0, -size.y * d, size.y * c, 0.0, 0.0,
        0.0, 0.0, size.z, 0.0, at.x, at.y, at.z, 1.0,
    };
    return made_place(s, mesh, m);
}

/* The same in any direction: its x axis along `x`, z square to that. */
static inline int made_put_along(struct gp_scene *s, int mesh, struct gp_v3 at,
                                 struct gp_v3 size, struct gp_v3 x)
{
    const struct gp_v3 a = gp_v3_unit(x);
    const struct gp_v3 side = fabs(a.z) < 0.9 ? (struct gp_v3) {0.0, 0.0, 1.0}
                                              : (struct gp_v3) {0.0, 1.0, 0.0};
    const struct gp_v3 b = gp_v3_unit(gp_v3_cross(side, a));
    const struct gp_v3 c = gp_v3_cross(a, b);
    const double m[16] = {
        size.x * a.x, size.x * a.y, size.x * a.z, 0.0,
        size.y * b.x, size.y * b.y, size.y * b.z, 0.0,
        size.z * c.x, size.z * c.y, size.z * c.z, 0.0, at.x, at.y, at.z, 1.0,
    };
    return made_place(s, mesh, m);
}

/* Moves an object to `at`, `size` times as large. */
static inline void made_move(struct gp_scene *s, int object, struct gp_v3 at,
                             double size)
{
    struct gp_object *const o = &s->object[object];
    for (int i = 0; i < 12; i++)
        o->to_world[i] *= i % 4 < 3 ? size : 1.0;
    o->to_world[12] = at.x;
    o->to_world[13] = at.y;
    o->to_world[14] = at.z;
    o->radius = 0.0;
    made_bounds(s, o);
}

static inline int made_light(struct gp_scene *s, struct gp_scene_light light)
{
    MADE_GROW(s->light, s->lights);
    for (int c = 0; c < 3; c++)
        light.color[c] = light.color[c] > 0.0 ? light.color[c] : 1.0;
    light.node = s->lights;
    snprintf(light.name, sizeof light.name, "light%d", s->lights + 1);
    s->light[s->lights] = light;
    return s->lights++;
}

static inline int made_point(struct gp_scene *s, struct gp_v3 at, double cd,
                             double range)
{
    return made_light(s, (struct gp_scene_light) {
        .kind = GP_LIGHT_POINT, .at = at, .intensity = cd, .range = range});
}

/* Half angles in degrees. */
static inline int made_spot(struct gp_scene *s, struct gp_v3 at,
                            struct gp_v3 along, double cd, double range,
                            double inner, double outer)
{
    return made_light(s, (struct gp_scene_light) {
        .kind = GP_LIGHT_SPOT, .at = at, .along = gp_v3_unit(along),
        .intensity = cd, .range = range, .inner = inner * MADE_PI / 180.0,
        .outer = outer * MADE_PI / 180.0});
}

static inline int made_sun(struct gp_scene *s, struct gp_v3 along, double lux)
{
    return made_light(s, (struct gp_scene_light) {
        .kind = GP_LIGHT_DIRECTIONAL, .along = gp_v3_unit(along),
        .intensity = lux, .range = INFINITY});
}

/* A camera at `eye` that looks at `at`, z up, added to the scene; returned as
 * the frame's, with matrices as Blender's headers have them. */
static inline struct gp_camera made_camera(struct gp_scene *s,
    struct gp_v3 eye, struct gp_v3 at, double yfov, double aspect)
{
    const struct gp_v3 back = gp_v3_unit(gp_v3_sub(eye, at));
    const struct gp_v3 up = {0.0, fabs(back.z) < 0.999 ? 0.0 : 1.0,
                             fabs(back.z) < 0.999 ? 1.0 : 0.0};
    const struct gp_v3 x = gp_v3_unit(gp_v3_cross(up, back));
    const struct gp_v3 y = gp_v3_cross(back, x);
    const double m[16] = {
        x.x, y.x, back.x, 0.0, x.y, y.y, back.y, 0.0, x.z, y.z, back.z, 0.0,
        -gp_v3_dot(x, eye), -gp_v3_dot(y, eye), -gp_v3_dot(back, eye), 1.0,
    };
    const double f = 1.0 / tan(0.5 * yfov * MADE_PI / 180.0);
    double ndc[16]; // [-1, 1], y up
    for (int row = 0; row < 4; row++) {
        ndc[4 * row] = m[4 * row] * f / aspect;
        ndc[4 * row + 1] = m[4 * row + 1] * f;
        ndc[4 * row + 2] = -m[4 * row + 2] - (row == 3 ? 0.2 : 0.0);
        ndc[4 * row + 3] = -m[4 * row + 2];
    }
    struct gp_camera c;
    assert_ok(gp_camera_make(NULL, "made", m, ndc, GLAREPP_NDC_CLIP, &c));
    MADE_GROW(s->camera, s->cameras);
    struct gp_scene_camera *const k = &s->camera[s->cameras];
    *k = (struct gp_scene_camera) {
        .yfov = yfov * MADE_PI / 180.0, .near = 0.1,
        .node = s->cameras++, .name = "made",
    };
    memcpy(k->to_camera, m, sizeof k->to_camera);
    return c;
}

// -- random scenes -----------------------------------------------------------

/* A ground of 60 x 60, and objects and lights in a world of 40 x 40 x 10 around
 * the point (0, 0, 5): boxes, balls, cards, walls, cards with holes and boxes
 * with an open side, in all directions; point lights, spots and suns. */
static inline struct gp_scene made_random_scene(uint64_t *seed, int objects,
                                                int lights)
{
    static const struct gp_box world = {{-20, -20, 0}, {20, 20, 10}};
    struct gp_scene s = made_scene();
    const int holes = made_material(&s, 0.5f, made_holes(&s, 3, 4));
    const int mesh[] = {
        made_box(&s, 0), made_ball(&s, 0, 4), made_card(&s, 0),
        made_card(&s, holes), made_open_box(&s, 0, 1u << 3),
    };
    made_put(&s, mesh[2], (struct gp_v3) {0, 0, 0},
             (struct gp_v3) {60, 60, 1}, 0.0);
    while (s.objects < objects) {
        const int kind = (int) (7.0 * made_random(seed));
        const struct gp_v3 at = made_within(seed, world);
        const double big = 4.0 * made_random(seed) * made_random(seed) + 0.2;
        struct gp_v3 size = {big, big * made_between(seed, 0.3, 1.0), 0.0};
        size.z = big * made_between(seed, 0.3, 1.0);
        const double turn = made_between(seed, 0.0, 360.0);
        if (kind >= 5) { // a wall on the ground
            size.x = made_between(seed, 4, 20);
            size.y = 0.3;
            size.z = made_between(seed, 2, 9);
            made_put(&s, mesh[0], (struct gp_v3) {at.x, at.y, size.z / 2}, size,
                     turn);
        } else if (made_random(seed) < 0.5) {
            made_put(&s, mesh[kind], at, size, turn);
        } else {
            made_put_along(&s, mesh[kind], at, size,
                           gp_v3_sub(made_within(seed, world),
                                     (struct gp_v3) {0, 0, 5}));
        }
    }
    while (s.lights < lights) {
        const double kind = made_random(seed);
        const struct gp_v3 at = made_within(seed, world);
        const struct gp_v3 to = made_within(seed, world);
        const double range =
            made_random(seed) < 0.2 ? INFINITY : made_between(seed, 3, 30);
        if (kind < 0.5)
            made_point(&s, at, 100.0, range);
        else if (kind < 0.8)
            made_spot(&s, at, gp_v3_sub(to, at), 100.0, range, 10.0,
                      made_between(seed, 12.0, 85.0));
        else
            made_sun(&s, (struct gp_v3) {to.x - at.x, to.y - at.y,
                                         -made_between(seed, 1, 30)}, 100.0);
    }
    return s;
}

/* The example of 15.2.1: a room of eight batches, three models of two batches
 * each, three lights that reach all of it. The camera of the room is to look
 * from (-3.5, -3.5, 2) at (0, 0, 1), 90 degrees, to see all models. */
static inline struct gp_scene made_example(void)
{
    struct gp_scene s = made_scene();
    static const unsigned faces[8] = {1, 2, 4, 8, 16, 32, 16, 32};
    int room[8];
    for (int i = 0; i < 8; i++)
        room[i] = made_open_box(&s, 0, 63u & ~faces[i]);
    // one mesh of eight parts: the parts are in order in the array
    s.mesh[room[0]].submeshes = 8;
    s.meshes = room[0] + 1;
    for (int i = 0; i < 3; i++) {
        const int body = made_box(&s, 0);
        const int first = s.submesh[s.mesh[body].first].first;
        s.submesh[s.mesh[body].first].count = 18; // half of the faces
        s.mesh[body].submeshes = 1;
        made_part(&s, first + 18, 0, true);
        made_put(&s, body, (struct gp_v3) {i - 1.0, 1.5 - i, 1},
                 (struct gp_v3) {0.5, 0.5, 1}, 20.0 * i);
        made_point(&s, (struct gp_v3) {i - 0.5, 2.0 - i, 3.2}, 100.0, INFINITY);
    }
    made_put(&s, room[0], (struct gp_v3) {0, 0, 2}, (struct gp_v3) {8, 8, 4}, 0);
    return s;
}

#endif
