/* The clear share of a disc by a sun map from geometry (Maughan, step 3). */
#include "scene/scene_priv.h"

#include "core/memory.h"
#include "scene/bounds.h"

#include <math.h>
#include <string.h>

enum {
    MOST_SIDE = 256,
    CHUNK = 4096,      // triangles of a draw
    TEXELS = 2,        // of a vertex in the buffer, as scene.vert has it
};

/* The front plane, as a share of a lamp's distance. Depth is nearly that of the
 * far plane, which is at the lamp. */
static const double FRONT = 1e-3;

static const double WIDEST = 1.0; // half angle of a map, radians

struct gp_eye_map {
    struct gp_program solid[2];  // [1]: with holes
    struct gp_target map;
    struct gp_buffer vertices;   // of a chunk
    float *chunk;                // the same; owned
    struct gp_texture holes;     // of the material that is drawn
    const uint16_t *holes_of;
    float texel[4 * MOST_SIDE * MOST_SIDE];
};

static gp_status open_map(const struct gp_log *log, const struct gp_gl *gl,
                          int side, struct gp_eye_map **state)
{
    static const char *const defines[2] = {
        "#define COLOUR\n", "#define COLOUR\n#define HOLES\n"};
    gp_status st = GP_OK;
    if (!*state)
        GP_TRY(gp_alloc_zero(log, "sun map of a scene", 1, sizeof **state,
                             state));
    struct gp_eye_map *const m = *state;
    for (int i = 0; i < 2; i++) {
        if (!m->solid[i].id)
            GP_TRY(gp_program_make(log, gl, defines[i], "scene.vert",
                                   "solid.frag", &m->solid[i]));
    }
    if (!m->chunk)
        GP_TRY(gp_alloc(log, "occluders", 3 * CHUNK * TEXELS,
                        4 * sizeof *m->chunk, &m->chunk));
    if (!m->vertices.id)
        GP_TRY(gp_buffer_make(log, gl, "occluders", GP_BUFFER_TEXELS,
                              3 * CHUNK * TEXELS, &m->vertices));
    if (m->map.w != side) {
        gp_target_free(gl, &m->map);
        GP_TRY(gp_target_make(log, gl, "sun map of a scene", GP_TEXEL_FLOAT, 1,
                              side, side, &m->map));
    }
out:
    return st;
}

void gp_eye_map_close(const struct gp_gl *gl, struct gp_eye_map **state)
{
    struct gp_eye_map *const m = *state;
    if (!m)
        return;
    for (int i = 0; i < 2; i++)
        gp_program_free(gl, &m->solid[i]);
    gp_target_free(gl, &m->map);
    gp_buffer_free(gl, &m->vertices);
    gp_texture_free(gl, &m->holes);
    gp_free(m->chunk);
    GP_FREE(*state);
}

/* Writes a material's alpha to the texture, if it is not there. */
static gp_status use_holes(const struct gp_log *log, const struct gp_gl *gl,
                           struct gp_eye_map *m, const struct gp_cutout *c)
{
    if (m->holes_of == c->alpha)
        return GP_OK;
    m->holes_of = NULL;
    gp_texture_free(gl, &m->holes);
    const gp_status st = gp_cutout_upload(log, gl, c, &m->holes);
    if (!st)
        m->holes_of = c->alpha;
    return st;
}

// -- drawing ------------------------------------------------------------------

/* A map that is being drawn. */
struct drawing {
    const struct gp_log *log;
    const struct gp_gl *gl;
    const struct gp_scene *scene;
    const struct gp_eye_measure *measure;
    struct gp_eye_map *map;
    float to_clip[16];
    const struct gp_material *material; // of the chunk
    int triangles;                      // in it
};

/* The projection of places in the disc's axes, x and y over the tangent of its
 * half angle: the disc fills the square, the far plane is where a lamp's edge
 * is. */
static void project(struct drawing *d)
{
    const struct gp_eye_disc *const disc = d->measure->disc;
    const bool lamp = isfinite(disc->distance);
    const double c = cos(disc->half);
    const double far = lamp ? disc->distance * c * c : 0.0;
    memset(d->to_clip, 0, sizeof d->to_clip);
    d->to_clip[0] = d->to_clip[5] = d->to_clip[11] = 1.0f;
    d->to_clip[10] = lamp ? (float) (1.0 + FRONT) : 0.0f;
    d->to_clip[14] = (float) (-FRONT * far);
}

static gp_status flush(struct drawing *d)
{
    struct gp_eye_map *const m = d->map;
    const struct gp_material *const of = d->material;
    const int n = d->triangles;
    d->triangles = 0;
    if (n == 0)
        return GP_OK;
    const bool holes = gp_material_cut(of);
    struct gp_uniform in[8] = {
        {.name = "vertices", .fetch = &m->vertices},
        {.name = "to_clip", .matrix = d->to_clip},
        {.name = "colour", .floats = 4}, // black
    };
    if (holes) {
        gp_status st = use_holes(d->log, d->gl, m,
                                 &d->scene->cutout[of->cutout]);
        if (st)
            return st;
        gp_cutout_uniforms(d->scene, of, &m->holes, in + 3);
    }
    gp_buffer_write(d->gl, &m->vertices, 0, 3 * n * TEXELS, m->chunk);
    const struct gp_draw draw = {
        .program = &m->solid[holes], .target = &m->map,
        .cut = {0, 0, m->map.w, m->map.h}, .uniform = in, .vertices = 3 * n,
        .instances = 1, .replace = true,
    };
    return gp_draw_run(d->log, d->gl, &draw);
}

/* Adds a triangle of an object, unless its sphere misses the cone. */
static gp_status add_triangle(struct drawing *d, const struct gp_object *o,
                              const uint32_t *index,
                              const struct gp_material *of)
{
    const struct gp_eye_disc *const disc = d->measure->disc;
    const double wide = tan(disc->half);
    struct gp_v3 p[3];
    for (int i = 0; i < 3; i++)
        p[i] = gp_move(o->to_world, gp_scene_vertex(d->scene, index[i]));
    const struct gp_v3 middle = gp_v3_scale(
        gp_v3_add(p[0], gp_v3_add(p[1], p[2])), 1.0 / 3.0);
    double radius = 0.0;
    for (int i = 0; i < 3; i++)
        radius = fmax(radius, gp_v3_length(gp_v3_sub(p[i], middle)));
    // corners of the square are beyond the disc, and sampled by nothing
    if (!gp_eye_meets_sphere(disc, middle, radius))
        return GP_OK;
    if (d->triangles == CHUNK || d->material != of) {
        const gp_status st = flush(d);
        if (st)
            return st;
    }
    d->material = of;
    float *out = d->map->chunk + (size_t) d->triangles++ * 3 * TEXELS * 4;
    for (int i = 0; i < 3; i++, out += TEXELS * 4) {
        const struct gp_v3 q = gp_v3_sub(p[i], disc->eye);
        const float *const uv = d->scene->uv + 2 * (size_t) index[i];
        const float vertex[TEXELS * 4] = {
            (float) (gp_v3_dot(q, d->measure->across) / wide),
            (float) (gp_v3_dot(q, d->measure->up) / wide),
            (float) gp_v3_dot(q, disc->to), uv[0], 0.0f, 0.0f, 0.0f, uv[1],
        };
        memcpy(out, vertex, sizeof vertex);
    }
    return GP_OK;
}

static gp_status draw_occluders(struct drawing *d, const int *object,
                                int objects)
{
    gp_status st = GP_OK;
    for (int i = 0; i < objects; i++) {
        const struct gp_object *const o = &d->scene->object[object[i]];
        const struct gp_mesh *const m = &d->scene->mesh[o->mesh];
        for (int k = m->first; k < m->first + m->submeshes; k++) {
            const struct gp_submesh *const submesh = &d->scene->submesh[k];
            const struct gp_material *const of =
                &d->scene->material[submesh->material];
            if (gp_material_gone(of))
                continue;
            for (int t = 0; t < submesh->count; t += 3)
                GP_TRY(add_triangle(d, o, d->scene->index + submesh->first + t,
                                    of));
        }
    }
    GP_TRY(flush(d));
    st = gp_gl_check(d->log, d->gl, "sun map of a scene");
out:
    return st;
}

// -- counting -----------------------------------------------------------------

/* Sums the texels whose centres are in the disc, and beside the window. */
static void count(const struct gp_eye_measure *m, const float *rgba, int side,
                  struct gp_eye_share *out)
{
    const double wide = tan(m->disc->half);
    double all = 0.0, outside = 0.0, clear = 0.0;
    int n = 0, edges = 0;
    for (int i = 0; i < side * side; i++) {
        const double x = 2.0 * (i % side + 0.5) / side - 1.0;
        const double y = 2.0 * (i / side + 0.5) / side - 1.0;
        if (x * x + y * y > 1.0)
            continue;
        const struct gp_v3 way = gp_v3_add(
            m->disc->to, gp_v3_scale(gp_v3_add(gp_v3_scale(m->across, x),
                                               gp_v3_scale(m->up, y)), wide));
        const double length = gp_v3_length(way);
        const struct gp_v3 along = gp_v3_scale(way, 1.0 / length);
        // the texel's solid angle
        const double weight =
            gp_eye_weight(m, along) / (length * length * length);
        all += weight;
        if (gp_eye_inside(m, along))
            continue;
        const float shown = rgba[4 * i];
        outside += weight;
        clear += shown > 0.5f ? weight : 0.0;
        n++;
        edges += i % side + 1 < side && rgba[4 * (i + 1)] != shown;
        edges += i / side + 1 < side && rgba[4 * (i + side)] != shown;
    }
    out->samples = side;
    out->outside = all > 0.0 ? outside / all : 1.0;
    out->clear = outside > 0.0 ? fmin(clear / outside, 1.0) : 1.0;
    out->error = n > 0 ? 0.5 * sqrt(2.0 * edges) / n : 0.0;
}

/* Returns the triangles of objects. */
static long long triangles_of(const struct gp_scene *s, const int *object,
                              int objects)
{
    long long n = 0;
    for (int i = 0; i < objects; i++) {
        const struct gp_mesh *const m = &s->mesh[s->object[object[i]].mesh];
        for (int k = m->first; k < m->first + m->submeshes; k++)
            n += s->submesh[k].count / 3;
    }
    return n;
}

gp_status gp_eye_map_draw(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_scene *s, struct gp_meshes *meshes,
    const struct gp_eye_disc *d, const struct gp_eye_window *window, int side,
    struct gp_eye_map **state, struct gp_eye_share *out)
{
    const struct gp_eye_measure measure = gp_eye_measure_of(d, window);
    struct gp_eye_share share = {.clear = 1.0, .outside = 1.0};
    int *object = NULL;
    gp_status st = GP_OK;
    if (!(d->half > 0.0 && d->half <= WIDEST))
        return gp_eye_rays(log, s, meshes, d, window, out);
    if (!measure.cut && gp_eye_inside(&measure, d->to))
        share.outside = 0.0;
    GP_TRY(gp_alloc(log, "objects before a light", (size_t) s->objects + 1,
                    sizeof *object, &object));
    share.objects = gp_eye_set(s, d, object);
    if (triangles_of(s, object, share.objects) > GP_EYE_DRAWN) {
        GP_TRY(gp_eye_rays(log, s, meshes, d, window, out));
        goto out;
    }
    if (!measure.cut && share.outside > 0.0 &&
        gp_eye_hidden(s, d, object, share.objects))
        share.clear = 0.0;
    else if (measure.cut || (share.outside > 0.0 && share.objects > 0)) {
        side = side < 2 ? 2 : side > MOST_SIDE ? MOST_SIDE : side;
        GP_TRY(open_map(log, gl, side, state));
        struct drawing drawing = {.log = log, .gl = gl, .scene = s,
                                  .measure = &measure, .map = *state};
        struct gp_eye_map *const m = *state;
        const struct gp_rect all = {0, 0, side, side};
        project(&drawing);
        // the sun's image is white
        for (int i = 0; i < 4 * side * side; i++)
            m->texel[i] = 1.0f;
        gp_texture_write(gl, &m->map.colour, all, m->texel);
        GP_TRY(draw_occluders(&drawing, object, share.objects));
        gp_target_read(gl, &m->map, 0, all, m->texel);
        GP_TRY(gp_gl_check(log, gl, "sun map of a scene"));
        count(&measure, m->texel, side, &share);
    }
    *out = share;
out:
    gp_free(object);
    return st;
}
