// SPDX-License-Identifier: Apache-2.0
#include "scene/sets/sets_priv.h"

#include "core/maths.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

enum { TEXELS = 2 }; // of a vertex, as scene.vert reads them

/* Vertices of a submesh, or of all opaque submeshes of a mesh. */
struct run {
    int first, count;
};

/* Programs: + 1 with holes, of SHADOW + 2 for cubes; LIGHT + GP_LIGHT_... */
enum { AMBIENT = 0, SHADOW = 2, LIGHT = 6, SPOT_IN_CUBE = 3, PROGRAMS = 10 };

struct gp_drawing {
    const struct gp_log *log;
    const struct gp_gl *gl;
    const struct gp_scene *s;
    struct glarepp_sets_params p;
    struct gp_box whole;       // holds every object
    struct gp_buffer vertices;
    struct run *submesh;       // a submesh of the scene
    struct run *opaque;        // a mesh of it; count 0: none
    struct gp_texture *cutout; // alpha, of each of the scene's
    struct gp_program program[PROGRAMS];
    struct gp_target picture;
    struct gp_rect all;        // of its pixels
    struct gp_target maps[2];  // square and atlas; made when first used
    double to_clip[16];        // of the picture
    struct gp_v3 eye;
    struct glarepp_sets_row *counts; // of the row that is drawn
};

// -- maps of shadows ----------------------------------------------------------
//
// One square for spots and suns, six of one atlas for points. Depth is
// reversed, as in gl: near / distance, of a sun from 1 to 0.

/* The map of one light: how places come to it. */
struct map {
    bool cube;           // six squares, 3 x 2: +x -x +y -y +z -z
    int side;            // texels of a square
    double near;         // near plane, but of a sun
    double to_map[16];   // world, from origin, to clip coordinates; of a square
    struct gp_v3 origin; // the light's place; of a sun the middle of its box
    float form_of[4];    // `map` of light.frag
};

/* Sets the clip coordinates of a square: x and y are k times those across
 * `along`, z and w products with columns. */
static void set_square(struct map *m, struct gp_v3 along, double k,
                       const double z[4], const double w[4])
{
    const struct gp_v3 other = fabs(along.z) < 0.9 ? (struct gp_v3) {0, 0, 1}
                                                   : (struct gp_v3) {1, 0, 0};
    const struct gp_v3 x = gp_v3_unit(gp_v3_cross(other, along));
    const struct gp_v3 y = gp_v3_cross(along, x);
    const double column[4][4] = {
        {k * x.x, k * x.y, k * x.z, 0.0}, {k * y.x, k * y.y, k * y.z, 0.0},
        {z[0], z[1], z[2], z[3]}, {w[0], w[1], w[2], w[3]},
    };
    for (int i = 0; i < 16; i++)
        m->to_map[i] = column[i % 4][i / 4];
}

/* Lays a spot's map a texel around its cone, as light.frag reads neighbours. */
static void lay_spot(const struct gp_scene_light *l, struct map *m)
{
    const double k = (m->side - 2.0) / m->side / gp_tan(fmax(l->outer, 1e-3));
    set_square(m, l->along, k, (const double[4]) {0.0, 0.0, 0.0, m->near},
               (const double[4]) {l->along.x, l->along.y, l->along.z, 0.0});
    m->form_of[2] = (float) k;
}

/* Lays a sun's map over the lit box, as deep as the whole scene. */
static void lay_sun(const struct gp_draw_light *d, const struct gp_box *whole,
                    struct map *m)
{
    const struct gp_v3 along = d->light->along, half = gp_box_half(&d->all);
    const struct gp_v3 middle = gp_v3_add(whole->lo, gp_box_half(whole));
    const double reach = fmax(gp_v3_length(half), 1e-6);
    const double deep = fmax(gp_v3_length(gp_box_half(whole)), 1e-6) * 1.001;
    const double k = (m->side - 2.0) / m->side / reach, s = 0.5 / deep;
    m->origin = gp_v3_add(d->all.lo, half);
    const double at = gp_v3_dot(gp_v3_sub(m->origin, middle), along);
    set_square(m, along, k, (const double[4]) {-s * along.x, -s * along.y,
                                               -s * along.z, 0.5 - s * at},
               (const double[4]) {0.0, 0.0, 0.0, 1.0});
    m->form_of[1] = (float) (2.0 / (k * m->side));
    m->form_of[2] = (float) s;
}

/* Lays a map out; `whole` holds every object. Spots wider than 120 degrees get
 * a cube. */
static struct map map_of(const struct gp_draw_light *d,
                         const struct gp_box *whole, int side)
{
    const struct gp_scene_light *const l = d->light;
    const bool sun = l->kind == GP_LIGHT_DIRECTIONAL;
    const bool narrow = l->kind == GP_LIGHT_SPOT && l->outer < 1.05;
    struct map m = {
        .cube = !sun && !narrow,
        .side = side,
        .origin = l->at,
        // reversed depth is as precise at every distance
        .near = isfinite(l->range) ? 1e-4 * l->range : 1e-3,
    };
    m.form_of[0] = (float) side;
    m.form_of[1] = (float) m.near;
    m.form_of[2] = 1.0f;
    if (sun)
        lay_sun(d, whole, &m);
    if (narrow)
        lay_spot(l, &m);
    return m;
}

/* Sets x, y and w of a point: x / w and y / w are its place in a square. */
static void look_at(const struct map *m, int face, struct gp_v3 at,
                    double out[3])
{
    const struct gp_v3 p = gp_v3_sub(at, m->origin);
    const double q[3] = {p.x, p.y, p.z};
    const double k = (m->side - 2.0) / m->side;
    const int axis = face >> 1; // as scene.vert
    for (int c = 0; c < 2; c++)
        out[c] = m->cube ? k * q[(axis + 1 + c) % 3]
                         : gp_move_column(m->to_map, p, c);
    out[2] = m->cube ? (face & 1 ? -q[axis] : q[axis])
                     : gp_move_column(m->to_map, p, 3);
}

/* Returns bits of the squares of a map where a box of the world may be; of a
 * map of one square 0 or 1. */
static int faces_of(const struct map *m, const struct gp_box *box)
{
    const double wide = 1.0 + 4.0 / m->side; // a texel around each square
    int faces = 0;
    for (int face = 0; face < (m->cube ? 6 : 1); face++) {
        int out = 31; // sides that all corners are beyond
        for (int i = 0; i < 8; i++) {
            double p[3];
            look_at(m, face, gp_box_corner(box, i), p);
            out &= (p[0] < -wide * p[2]) | (p[1] < -wide * p[2]) << 1 |
                   (p[0] > wide * p[2]) << 2 | (p[1] > wide * p[2]) << 3 |
                   (p[2] < 0.0) << 4;
        }
        faces |= (out == 0) << face;
    }
    return faces;
}

// -- geometry -----------------------------------------------------------------

/* Writes the vertices of a submesh, each with its triangle's normal. */
static void write_submesh(const struct gp_scene *s,
                          const struct gp_submesh *submesh, float *to)
{
    for (int t = 0; t < submesh->count; t += 3) {
        const uint32_t *const v = &s->index[submesh->first + t];
        const struct gp_v3 a = gp_scene_vertex(s, v[0]);
        const struct gp_v3 n = gp_v3_unit(gp_v3_cross(
            gp_v3_sub(gp_scene_vertex(s, v[1]), a),
            gp_v3_sub(gp_scene_vertex(s, v[2]), a)));
        for (int i = 0; i < 3; i++, to += 4 * TEXELS) {
            memcpy(to, &s->position[3 * (size_t) v[i]], 3 * sizeof *to);
            to[3] = s->uv ? s->uv[2 * (size_t) v[i]] : 0.0f;
            to[4] = (float) n.x;
            to[5] = (float) n.y;
            to[6] = (float) n.z;
            to[7] = s->uv ? s->uv[2 * (size_t) v[i] + 1] : 0.0f;
        }
    }
}

/* Uploads a mesh after another, its opaque submeshes first: they are one shadow
 * batch. */
static gp_status upload_meshes(struct gp_drawing *d)
{
    const struct gp_scene *const s = d->s;
    gp_status st;
    float *list = NULL;
    const int n = s->indices;
    int at = 0;
    const int limit = gp_gl_info(d->gl)->max_texel_buffer;
    if (n > limit / TEXELS)
        return gp_fail_bare(d->log, GP_ERR_GL,
                            "%s: %d triangles do not fit "
                            "into the memory of %s (the limit is %d)",
                            s->path, n / 3, gp_gl_info(d->gl)->name,
                            limit / TEXELS / 3);
    GP_TRY(gp_alloc_zero(d->log, "batches", (size_t) s->submeshes + 1,
                         sizeof *d->submesh, &d->submesh));
    GP_TRY(gp_alloc_zero(d->log, "batches", (size_t) s->meshes + 1,
                         sizeof *d->opaque, &d->opaque));
    GP_TRY(gp_alloc(d->log, "vertices", (size_t) n * 4 * TEXELS + 1,
                    sizeof *list, &list));
    for (int m = 0; m < s->meshes; m++) {
        const struct gp_mesh *const mesh = &s->mesh[m];
        d->opaque[m].first = at;
        for (int holes = 0; holes < 2; holes++) {
            for (int i = mesh->first; i < mesh->first + mesh->submeshes; i++) {
                const struct gp_submesh *const submesh = &s->submesh[i];
                const struct gp_material *const of =
                    &s->material[submesh->material];
                if (gp_material_cut(of) != holes || gp_material_gone(of))
                    continue;
                d->submesh[i] = (struct run) {at, submesh->count};
                write_submesh(s, submesh, list + (size_t) at * 4 * TEXELS);
                at += submesh->count;
            }
            if (!holes)
                d->opaque[m].count = at - d->opaque[m].first;
        }
    }
    GP_TRY(gp_buffer_make(d->log, d->gl, "vertices", GP_BUFFER_TEXELS,
                          at ? TEXELS * at : 1, &d->vertices));
    gp_buffer_write(d->gl, &d->vertices, 0, TEXELS * at, list);
out:
    gp_free(list);
    return st;
}

// -- opening ------------------------------------------------------------------

static gp_status make_programs(struct gp_drawing *d)
{
#define HOLES "#define HOLES\n"
#define LIT "#define LIT\n"
    static const char *const defines[PROGRAMS] = {
        [AMBIENT] = "#define COLOUR\n",
        "#define COLOUR\n" HOLES,
        [SHADOW] = "",
        HOLES,
        "#define CUBE\n",
        "#define CUBE\n" HOLES,
        [LIGHT + GP_LIGHT_DIRECTIONAL] = LIT "#define SUN\n",
        [LIGHT + GP_LIGHT_POINT] = LIT "#define IN_CUBE\n",
        [LIGHT + GP_LIGHT_SPOT] = LIT "#define SPOT\n",
        [LIGHT + SPOT_IN_CUBE] = LIT "#define SPOT\n#define IN_CUBE\n",
    };
    gp_status st = GP_OK;
    for (int i = 0; i < PROGRAMS && !st; i++)
        st = gp_program_make(d->log, d->gl, defines[i], "scene.vert",
                             i < LIGHT ? "solid.frag" : "light.frag",
                             &d->program[i]);
    return st;
}

gp_status gp_drawing_open(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_scene *s, const struct gp_camera *c,
    const struct glarepp_sets_params *p, struct gp_drawing **out)
{
    struct gp_drawing *d = NULL;
    gp_status st = gp_alloc_zero(log, "drawing", 1, sizeof *d, &d);
    if (st)
        return st;
    *d = (struct gp_drawing) {
        .log = log,
        .gl = gl,
        .s = s,
        .p = *p,
        .whole = GP_BOX_EMPTY,
        .all = {0, 0, p->w, p->h},
    };
    for (int i = 0; i < s->objects; i++)
        d->whole = gp_box_join(d->whole, s->object[i].box);
    d->eye = gp_camera_eye(c);
    for (int r = 0; r < 4; r++) { // y stays down, depth is near / distance
        const double *const ndc = &c->to_ndc[4 * r];
        d->to_clip[4 * r] = 2.0 * ndc[0] - ndc[3];
        d->to_clip[4 * r + 1] = 2.0 * ndc[1] - ndc[3];
        d->to_clip[4 * r + 2] = r == 3 ? p->near : 0.0;
        d->to_clip[4 * r + 3] = ndc[3];
    }
    GP_TRY(gp_gl_use(log, gl));
    GP_TRY(upload_meshes(d));
    GP_TRY(gp_alloc_zero(log, "textures", (size_t) s->cutouts + 1,
                         sizeof *d->cutout, &d->cutout));
    for (int i = 0; i < s->cutouts; i++) {
        const struct gp_cutout *const cut = &s->cutout[i];
        if (!cut->alpha || cut->owner != i)
            continue;
        GP_TRY(gp_texture_make(log, gl, "alpha", GP_TEXEL_CODE, cut->w, cut->h,
                               &d->cutout[i]));
        gp_texture_write_codes(gl, &d->cutout[i], cut->alpha);
    }
    GP_TRY(make_programs(d));
    GP_TRY(gp_target_make(log, gl, "picture of the scene", GP_TEXEL_DEPTH, 1,
                          p->w, p->h, &d->picture));
    GP_TRY(gp_gl_check(log, gl, "uploading the scene"));
    *out = d;
    return GP_OK;
out:
    gp_drawing_close(&d);
    return st;
}

void gp_drawing_close(struct gp_drawing **drawing)
{
    struct gp_drawing *const d = *drawing;
    if (!d)
        return;
    for (int i = 0; i < 2; i++)
        gp_target_free(d->gl, &d->maps[i]);
    for (int i = 0; i < PROGRAMS; i++)
        gp_program_free(d->gl, &d->program[i]);
    for (int i = 0; d->cutout && i < d->s->cutouts; i++)
        gp_texture_free(d->gl, &d->cutout[i]);
    gp_target_free(d->gl, &d->picture);
    gp_buffer_free(d->gl, &d->vertices);
    gp_free(d->submesh);
    gp_free(d->opaque);
    gp_free(d->cutout);
    GP_FREE(*drawing);
}

// -- drawing ------------------------------------------------------------------

enum { UNIFORMS = 16 };

/* Uniforms of a draw, and the matrices that they point to. */
struct inputs {
    struct gp_uniform u[UNIFORMS];
    int n;
    float matrix[4][16];
    int matrices;
};

static void add_matrix(struct inputs *in, const char *name, const double m[16])
{
    float *const to = in->matrix[in->matrices++];
    for (int i = 0; i < 16; i++)
        to[i] = (float) m[i];
    in->u[in->n++] = (struct gp_uniform) {.name = name, .matrix = to};
}

static void add_floats(struct inputs *in, const char *name, int n,
                       const double v[4])
{
    struct gp_uniform u = {.name = name, .floats = n};
    for (int i = 0; i < n; i++)
        u.f[i] = (float) v[i];
    in->u[in->n++] = u;
}

static void add_holes(const struct gp_drawing *d, const struct gp_material *m,
                      struct inputs *in)
{
    const struct gp_cutout *const c = &d->s->cutout[m->cutout];
    struct gp_uniform *const u = in->u + in->n;
    u[0] = (struct gp_uniform) {.name = "holes",
                                .texture = &d->cutout[c->owner]};
    u[1] = (struct gp_uniform) {
        .name = "wraps", .v = {(int) c->wrap[0], (int) c->wrap[1]}};
    u[2] = (struct gp_uniform) {
        .name = "cut", .floats = 2, .f = {m->base[3], m->cutoff}};
    in->n += 3;
}

/* Draws a run of vertices and counts it as a batch. */
static gp_status draw_run(struct gp_drawing *d, struct run run,
                          const struct inputs *in, struct gp_draw draw)
{
    draw.first = run.first;
    draw.vertices = run.count;
    draw.uniform = in->u;
    draw.replace = draw.depth == GP_DEPTH_WRITE;
    draw.instances = draw.instances ? draw.instances : 1;
    d->counts->batches++;
    return gp_draw_run(d->log, d->gl, &draw);
}

static void begin(const struct gp_drawing *d, struct inputs *in)
{
    in->u[0] = (struct gp_uniform) {.name = "vertices",
                                    .texture = &d->vertices.texture};
    in->n = 1;
    in->matrices = 0;
}

/* Returns a matrix from an object to the world with its origin at p. */
static void place_from(const struct gp_object *o, struct gp_v3 p, double m[16])
{
    memcpy(m, o->to_world, 16 * sizeof *m);
    m[12] -= p.x;
    m[13] -= p.y;
    m[14] -= p.z;
}

gp_status gp_drawing_ambient(struct gp_drawing *d, const int *object, int n)
{
    const struct gp_scene *const s = d->s;
    gp_status st = GP_OK;
    d->counts->passes += d->counts->passes == 0;
    for (int i = 0; i < n; i++) {
        const struct gp_object *const o = &s->object[object[i]];
        const struct gp_mesh *const mesh = &s->mesh[o->mesh];
        double m[16];
        gp_matrix_mul(o->to_world, d->to_clip, m);
        for (int k = mesh->first; k < mesh->first + mesh->submeshes; k++) {
            const struct gp_material *const of =
                &s->material[s->submesh[k].material];
            const bool holes = gp_material_cut(of);
            struct inputs in = {0};
            if (!d->submesh[k].count)
                continue;
            begin(d, &in);
            add_matrix(&in, "to_clip", m);
            add_floats(&in, "colour", 4, (const double[4]) {
                d->p.ambient * (double) of->base[0],
                d->p.ambient * (double) of->base[1],
                d->p.ambient * (double) of->base[2], 1.0});
            if (holes)
                add_holes(d, of, &in);
            const struct gp_draw draw = {
                .program = &d->program[AMBIENT + holes],
                .target = &d->picture,
                .cut = d->all,
                .depth = GP_DEPTH_WRITE,
            };
            GP_TRY(draw_run(d, d->submesh[k], &in, draw));
        }
    }
    st = gp_gl_check(d->log, d->gl, "drawing the ambient pass");
out:
    return st;
}

static gp_status draw_shadow(struct gp_drawing *d, const struct map *map,
    const struct gp_object *o, int faces, struct run run,
    const struct gp_material *of)
{
    struct inputs in = {0};
    double m[16];
    if (!run.count)
        return GP_OK;
    begin(d, &in);
    place_from(o, map->origin, m);
    if (map->cube) {
        add_matrix(&in, "to_light", m);
        in.u[in.n++] = (struct gp_uniform) {.name = "faces", .v = {faces}};
        add_floats(&in, "map", 4, (const double[4]) {map->side, map->near});
    } else {
        gp_matrix_mul(m, map->to_map, m);
        add_matrix(&in, "to_clip", m);
    }
    if (of)
        add_holes(d, of, &in);
    const struct gp_target *const to = &d->maps[map->cube];
    const struct gp_draw draw = {
        .program = &d->program[SHADOW + 2 * map->cube + (of != NULL)],
        .target = to,
        .cut = {0, 0, to->w, to->h},
        .depth = GP_DEPTH_WRITE,
        .instances = map->cube ? __builtin_popcount((unsigned) faces) : 1,
        .clips = map->cube ? 4 : 0,
    };
    d->counts->shadow_batches++;
    return draw_run(d, run, &in, draw);
}

static gp_status draw_map(struct gp_drawing *d, const struct gp_draw_light *l,
                          const struct map *map)
{
    const struct gp_scene *const s = d->s;
    struct gp_target *const to = &d->maps[map->cube];
    const int w = map->cube ? 3 * map->side : map->side;
    const int h = map->cube ? 2 * map->side : map->side;
    gp_status st;
    GP_TRY(gp_target_make(d->log, d->gl, "map of shadows", GP_TEXEL_DEPTH, 0, w,
                          h, to));
    gp_target_clear(d->gl, to, (struct gp_rect) {0, 0, w, h});
    d->counts->passes++;
    for (int i = 0; i < l->shadows; i++) {
        const struct gp_object *const o = &s->object[l->shadow[i]];
        const struct gp_mesh *const mesh = &s->mesh[o->mesh];
        const int faces = faces_of(map, &o->box);
        if (!faces)
            continue;
        if (!d->p.separate)
            GP_TRY(draw_shadow(d, map, o, faces, d->opaque[o->mesh], NULL));
        for (int k = mesh->first; k < mesh->first + mesh->submeshes; k++) {
            const struct gp_material *const of =
                &s->material[s->submesh[k].material];
            const bool holes = gp_material_cut(of);
            if (holes || d->p.separate)
                GP_TRY(draw_shadow(d, map, o, faces, d->submesh[k],
                                   holes ? of : NULL));
        }
    }
    st = gp_gl_check(d->log, d->gl, "drawing a map of shadows");
out:
    return st;
}

/* Adds what all surfaces of a light's pass have in common. */
static void add_light(const struct gp_drawing *d, const struct gp_draw_light *l,
                      const struct map *map, struct inputs *in)
{
    const struct gp_scene_light *const of = l->light;
    const struct gp_v3 eye = gp_v3_sub(d->eye, map->origin), to = of->along;
    add_floats(in, "eye", 4, (const double[4]) {eye.x, eye.y, eye.z});
    add_floats(in, "along", 4,
               (const double[4]) {to.x, to.y, to.z, 1.0 / of->range});
    in->u[in->n] = (struct gp_uniform) {.name = "map", .floats = 4};
    memcpy(in->u[in->n++].f, map->form_of, sizeof map->form_of);
    in->u[in->n++] = (struct gp_uniform) {
        .name = "shadows", .texture = &d->maps[map->cube].depth,
    };
    if (!map->cube)
        add_matrix(in, "to_map", map->to_map);
    if (of->kind == GP_LIGHT_SPOT) {
        const double outer = gp_cos(of->outer);
        const double soft = fmax(gp_cos(of->inner) - outer, 1e-6);
        add_floats(in, "cone", 2, (const double[4]) {outer, 1.0 / soft});
    }
}

/* Adds the surface's own: its matrices and the light that comes back. */
static void add_surface(const struct gp_drawing *d, const struct gp_object *o,
                        const struct map *map, struct inputs *in)
{
    const double *const t = o->to_world;
    double m[16];
    const struct gp_v3 a = {t[0], t[1], t[2]}, b = {t[4], t[5], t[6]},
                       c = {t[8], t[9], t[10]};
    const struct gp_v3 bc = gp_v3_cross(b, c), ca = gp_v3_cross(c, a),
                       ab = gp_v3_cross(a, b);
    gp_matrix_mul(t, d->to_clip, m);
    add_matrix(in, "to_clip", m);
    place_from(o, map->origin, m);
    add_matrix(in, "to_light", m);
    // normals turn by the cofactors: right also where the scale is uneven
    add_matrix(in, "normals", (const double[16]) {
        bc.x, bc.y, bc.z, 0, ca.x, ca.y, ca.z, 0, ab.x, ab.y, ab.z, 0, 0, 0, 0,
        1});
}

static gp_status draw_lit(struct gp_drawing *d, const struct gp_draw_light *l,
                          const struct map *map)
{
    const struct gp_scene *const s = d->s;
    const struct gp_scene_light *const of = l->light;
    const bool wide = of->kind == GP_LIGHT_SPOT && map->cube;
    const double scale = d->p.light_scale * of->intensity / M_PI;
    gp_status st = GP_OK;
    struct gp_draw draw = {
        .program = &d->program[LIGHT + (wide ? SPOT_IN_CUBE : (int) of->kind)],
        .target = &d->picture,
        .cut = l->cut,
        .depth = GP_DEPTH_SAME,
    };
    d->counts->passes++;
    for (int i = 0; i < l->lits; i++) {
        const struct gp_object *const o = &s->object[l->lit[i]];
        const struct gp_mesh *const mesh = &s->mesh[o->mesh];
        struct inputs in = {0};
        if (l->own)
            draw.cut = gp_rect_meet(l->cut, l->own[i]);
        if (gp_rect_empty(draw.cut))
            continue;
        begin(d, &in);
        add_light(d, l, map, &in);
        add_surface(d, o, map, &in);
        const int common = in.n;
        for (int k = mesh->first; k < mesh->first + mesh->submeshes; k++) {
            const float *const base = s->material[s->submesh[k].material].base;
            if (!d->submesh[k].count)
                continue;
            in.n = common;
            add_floats(&in, "tint", 4, (const double[4]) {
                scale * of->color[0] * (double) base[0],
                scale * of->color[1] * (double) base[1],
                scale * of->color[2] * (double) base[2], 0.0});
            GP_TRY(draw_run(d, d->submesh[k], &in, draw));
        }
    }
    st = gp_gl_check(d->log, d->gl, "drawing a light");
out:
    return st;
}

gp_status gp_drawing_light(struct gp_drawing *d, const struct gp_draw_light *l)
{
    if (!l->lits || gp_rect_empty(l->cut))
        return GP_OK;
    const struct map map = map_of(l, &d->whole, d->p.map);
    gp_status st = draw_map(d, l, &map);
    if (!st)
        st = draw_lit(d, l, &map);
    d->counts->lights++;
    return st;
}

void gp_drawing_clear(struct gp_drawing *d, struct glarepp_sets_row *counts)
{
    gp_target_clear(d->gl, &d->picture, d->all);
    d->counts = counts;
}

void gp_drawing_depth(struct gp_drawing *d, float *z)
{
    const float near = (float) d->p.near;
    gp_target_read(d->gl, &d->picture, GP_DEPTH_ATTACHMENT, d->all, z);
    for (size_t i = 0; i < gp_rect_pixels(d->all); i++)
        z[i] = z[i] > 0.0f ? near / z[i] : INFINITY;
}

void gp_drawing_wait(struct gp_drawing *d)
{
    float pixel[4]; // its copy is made after the last draw
    gp_target_read(d->gl, &d->picture, 0, (struct gp_rect) {0, 0, 1, 1}, pixel);
}

void gp_drawing_picture(struct gp_drawing *d, float *rgba)
{
    gp_target_read(d->gl, &d->picture, 0, d->all, rgba);
}
