// SPDX-License-Identifier: Apache-2.0
/* Materials, as far as they hide or take light, and triangles. */
#include "scene/gltf/gltf_priv.h"

#include "core/maths.h"
#include "core/memory.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

/* Texels of all images of cut-outs of a scene. */
enum { MOST_TEXELS = 1 << 24 };

// -- materials ----------------------------------------------------------------

/* Reads an image into the cut-out of a texture, or shares that of another. */
static gp_status read_image(struct gp_gltf *g, int index,
                            const struct gp_scene *s, int texture)
{
    struct gp_cutout *const c = &s->cutout[texture];
    const struct gp_json_place place = gp_gltf_at(g, "image", index);
    struct gp_gltf_span span = {0};
    char name[GP_LINE_BYTES];
    gp_status st;
    for (int i = 0; i < s->cutouts; i++) {
        if (s->cutout[i].alpha && s->cutout[i].image == index) {
            *c = s->cutout[i];
            return GP_OK;
        }
    }
    GP_TRY(gp_gltf_image(g, index, &span));
    snprintf(name, sizeof name, "%s: image %d", g->path, index);
    GP_TRY(g->images->alpha(g->images->user, g->log,
                            span.file ? span.file : name, span.at,
                            (size_t) span.bytes, MOST_TEXELS, c));
    c->image = index;
    c->owner = texture;
    g->texels += (long long) c->w * c->h;
    if (g->texels > MOST_TEXELS)
        GP_TRY(gp_gltf_fail(&place, "images of cut-outs of over %d texels "
                            "together", (int) MOST_TEXELS));
out:
    gp_free(span.own);
    gp_free(span.file);
    return st;
}

/* Reads a texture, unless another material has. */
static gp_status read_cutout(struct gp_gltf *g, int texture,
                             struct gp_scene *out)
{
    struct gp_cutout *const c = &out->cutout[texture];
    const struct gp_json_place at = gp_gltf_at(g, "texture", texture);
    int image, sampler, code[2] = {0, 0};
    gp_status st;
    json_t *const o = gp_gltf_item(g, "textures", texture);
    if (c->alpha)
        return GP_OK;
    GP_TRY(gp_gltf_index(g, &at, o, "source", "images", &image));
    GP_TRY(gp_gltf_index(g, &at, o, "sampler", "samplers", &sampler));
    if (image < 0)
        GP_TRY(gp_gltf_fail(&at, "no \"source\", a PNG or JPEG"));
    GP_TRY(read_image(g, image, out, texture));
    if (sampler >= 0) {
        json_t *const s = gp_gltf_item(g, "samplers", sampler);
        GP_TRY(gp_json_int(&at, s, "wrapS", 0, INT_MAX, &code[0]));
        GP_TRY(gp_json_int(&at, s, "wrapT", 0, INT_MAX, &code[1]));
    }
    for (int i = 0; i < 2; i++)
        c->wrap[i] = code[i] == 33071   ? GP_WRAP_CLAMP
                     : code[i] == 33648 ? GP_WRAP_MIRROR
                                        : GP_WRAP_REPEAT; // and no sampler
out:
    return st;
}

/* Returns the texture's object of a material's base colour, or NULL. */
static json_t *base_texture(json_t *material)
{
    return json_object_get(json_object_get(material, "pbrMetallicRoughness"),
                           "baseColorTexture");
}

/* Lets a material that transmits at least half of the light hide nothing
 * (KHR_materials_transmission), as a blended one of at most half its alpha
 * would; a texture of it is not read, and the material is opaque. */
static gp_status read_glass(struct gp_gltf *g, const struct gp_json_place *at,
                            json_t *o, struct gp_material *m)
{
    json_t *const glass = gp_gltf_extension(o, "KHR_materials_transmission");
    double factor = 0.0;
    const gp_status st =
        gp_json_number(at, glass, "transmissionFactor", 0.0, 1.0, &factor);
    if (st || !(factor > 0.0))
        return st;
    const bool textured = json_object_get(glass, "transmissionTexture");
    g->odd[GP_GLTF_GLASS] |= textured || factor < 1.0;
    if (!textured && factor >= 0.5) {
        m->cutoff = 2.0f; // no alpha reaches it
        m->cutout = -1;
    }
    return GP_OK;
}

/* Reads a material; its cutout is the texture that its alpha asks for. */
static gp_status read_material(struct gp_gltf *g, int index,
                               struct gp_material *m)
{
    static const char *const modes[] = {"OPAQUE", "MASK", "BLEND", NULL};
    json_t *const o = gp_gltf_item(g, "materials", index);
    json_t *const base = base_texture(o);
    const struct gp_json_place at = gp_gltf_at(g, "material", index);
    double colour[4] = {1.0, 1.0, 1.0, 1.0}, cutoff = 0.5;
    int mode = 0;
    gp_status st;
    GP_TRY(gp_json_numbers(&at, json_object_get(o, "pbrMetallicRoughness"),
                           "baseColorFactor", 4, 0.0, 1.0, colour));
    GP_TRY(gp_json_choice(&at, o, "alphaMode", modes, &mode));
    if (mode == 1)
        GP_TRY(gp_json_number(&at, o, "alphaCutoff", 0.0, 1e6, &cutoff));
    GP_TRY(gp_gltf_index(g, &at, base, "index", "textures", &m->cutout));
    if (!mode)
        m->cutout = -1; // its alpha is ignored
    g->odd[GP_GLTF_BLENDED] |= mode == 2;
    for (int i = 0; i < 4; i++)
        m->base[i] = (float) colour[i];
    m->cutoff = mode ? (float) cutoff : 0.0f;
    st = read_glass(g, &at, o, m);
out:
    return st;
}

gp_status gp_gltf_materials(struct gp_gltf *g, struct gp_scene *out)
{
    const int n = gp_gltf_count(g, "materials");
    const int textures = gp_gltf_count(g, "textures");
    gp_status st;
    GP_TRY(gp_gltf_alloc(g, (size_t) n + 1, sizeof *out->material,
                         &out->material));
    GP_TRY(
        gp_gltf_alloc(g, (size_t) textures, sizeof *out->cutout, &out->cutout));
    out->cutouts = textures;
    out->materials = n + 1;
    out->material[n] = (struct gp_material) {
        .base = {1.0f, 1.0f, 1.0f, 1.0f}, .cutout = -1,
    };
    for (int i = 0; i < n; i++) {
        struct gp_material *const m = &out->material[i];
        GP_TRY(read_material(g, i, m));
        g->odd[GP_GLTF_BLIND] |= m->cutout >= 0 && !g->images;
        if (!g->images)
            m->cutout = -1;
        else if (m->cutout >= 0)
            GP_TRY(read_cutout(g, m->cutout, out));
    }
out:
    return st;
}

// -- meshes -------------------------------------------------------------------

struct walk {
    struct gp_gltf *g;
    struct gp_scene *out;
    struct known {     // of each accessor of positions
        bool read;
        int first;     // its first vertex
        int uv, moved; // accessor of its texture coordinates, and the material
                       // that moves these; -1: none
    } *known;          // owned
    bool drawn;        // points or lines that were left out
};

/* Writes the triangles of `n` vertices in glTF's mode 4 to 6. */
static void triangles(int mode, int n, const uint32_t *v, uint32_t *to)
{
    for (int i = 0; i + 2 < n; i += mode == 4 ? 3 : 1) {
        const int odd = mode == 5 ? i & 1 : 0;
        *to++ = v[mode == 6 ? i + 1 : i];
        *to++ = v[mode == 6 ? i + 2 : i + 1 + odd];
        *to++ = v[mode == 6 ? 0 : i + 2 - odd];
    }
}

/* Texture coordinates of a cut-out. */
struct uv_of {
    int accessor;    // -1: none
    int moved;       // material whose KHR_texture_transform moves them, or -1
    double scale[2], turn, offset[2]; // in that order; turn in radians,
                                      // counter-clockwise as the image is seen
};

/* Moves n coordinates (KHR_texture_transform). v points down: in numbers the
 * turn is clockwise, so that the extension's example, offset (0, 1), a turn of
 * pi / 2 and scale 0.5, shows the lower left quarter of the image. */
static void move_uv(const struct uv_of *by, int n, float *uv)
{
    const double c = gp_cos(by->turn), s = gp_sin(by->turn);
    for (int i = 0; i < n; i++, uv += 2) {
        const double u = by->scale[0] * (double) uv[0],
                     v = by->scale[1] * (double) uv[1];
        uv[0] = (float) (c * u + s * v + by->offset[0]);
        uv[1] = (float) (c * v - s * u + by->offset[1]);
    }
}

/* Reads the vertices of accessors, unless another primitive has. */
static gp_status read_vertices(struct walk *w, int positions,
                               const struct uv_of *uv,
                               const struct gp_gltf_accessor *a)
{
    struct gp_gltf_accessor map;
    struct gp_scene *const s = w->out;
    struct known *const known = &w->known[positions];
    const size_t at = (size_t) s->vertices, n = (size_t) a->count;
    gp_status st = GP_OK;
    if (known->read && known->uv == uv->accessor && known->moved == uv->moved)
        return GP_OK;
    if (uv->accessor >= 0) {
        GP_TRY(gp_gltf_accessor(w->g, uv->accessor, &map));
        if (map.count != a->count)
            GP_TRY(gp_gltf_fail(&map.place, "%d texture coordinates for %d "
                                "positions", map.count, a->count));
    }
    if (at + n > INT_MAX / 4)
        GP_TRY(gp_gltf_fail(&a->place, "over %d vertices", INT_MAX / 4));
    GP_TRY(gp_gltf_grow(w->g, at, n, 3 * sizeof(float), &s->position));
    GP_TRY(gp_gltf_grow(w->g, at, n, 2 * sizeof(float), &s->uv));
    GP_TRY(gp_gltf_floats(a, 3, s->position + 3 * at));
    if (uv->accessor >= 0)
        GP_TRY(gp_gltf_floats(&map, 2, s->uv + 2 * at));
    if (uv->accessor >= 0 && uv->moved >= 0)
        move_uv(uv, a->count, s->uv + 2 * at);
    *known = (struct known) {true, s->vertices, uv->accessor, uv->moved};
    s->vertices += a->count;
out:
    return st;
}

/* Adds the triangles of a primitive, a submesh, and grows the box of its mesh. */
static gp_status add_triangles(struct walk *w, int mode, int material,
                               int first, const struct gp_gltf_accessor *a,
                               const struct gp_gltf_accessor *index,
                               struct gp_box *box)
{
    struct gp_scene *const s = w->out;
    const int count = index ? index->count : a->count;
    const long long n = count < 3   ? 0
                        : mode == 4 ? count / 3 * 3
                                    : 3LL * (count - 2);
    const size_t at = (size_t) s->indices, submesh = (size_t) s->submeshes;
    uint32_t *list = NULL;
    gp_status st;
    if (n > INT_MAX - s->indices)
        return gp_gltf_fail(&a->place, "over %d indices", INT_MAX);
    GP_TRY(gp_gltf_grow(w->g, at, (size_t) n, sizeof *s->index, &s->index));
    GP_TRY(gp_gltf_grow(w->g, submesh, 1, sizeof *s->submesh, &s->submesh));
    GP_TRY(gp_alloc(w->g->log, w->g->path, (size_t) count, sizeof *list,
                    &list));
    if (index)
        GP_TRY(gp_gltf_indices(index, a->count, list));
    for (int i = 0; i < count && !index; i++)
        list[i] = (uint32_t) i;
    triangles(mode, count, list, s->index + at);
    for (uint32_t *to = s->index + at; to < s->index + at + n; to++) {
        *to += (uint32_t) first;
        *box = gp_box_with(*box, gp_scene_vertex(s, *to));
    }
    s->submesh[s->submeshes++] =
        (struct gp_submesh) {s->indices, (int) n, material};
    s->indices += (int) n;
out:
    gp_free(list);
    return st;
}

/* Finds the texture coordinates that the material's cut-out reads, and
 * KHR_texture_transform of them. */
static gp_status find_uv(const struct walk *w, const struct gp_json_place *at,
                         json_t *attributes, int material, struct uv_of *uv)
{
    json_t *const base =
        base_texture(gp_gltf_item(w->g, "materials", material));
    json_t *const o = gp_gltf_extension(base, "KHR_texture_transform");
    const struct gp_json_place of = gp_gltf_at(w->g, "material", material);
    char key[32];
    int set = 0;
    gp_status st;
    *uv = (struct uv_of) {.accessor = -1, .moved = -1, .scale = {1.0, 1.0}};
    if (w->out->material[material].cutout < 0)
        return GP_OK;
    GP_TRY(gp_json_int(&of, base, "texCoord", 0, 99, &set));
    uv->moved = o ? material : -1;
    GP_TRY(gp_json_int(&of, o, "texCoord", 0, 99, &set));
    GP_TRY(gp_json_numbers(&of, o, "scale", 2, -1e6, 1e6, uv->scale));
    GP_TRY(gp_json_number(&of, o, "rotation", -1e6, 1e6, &uv->turn));
    GP_TRY(gp_json_numbers(&of, o, "offset", 2, -1e6, 1e6, uv->offset));
    snprintf(key, sizeof key, "TEXCOORD_%d", set);
    st = gp_gltf_index(w->g, at, attributes, key, "accessors", &uv->accessor);
out:
    return st;
}

/* Notes a cut-out whose vertices have an alpha: COLOR_0 of four components,
 * which multiplies that of the base colour (glTF 2.0, 3.9.2). */
static gp_status note_faded(struct walk *w, const struct gp_json_place *at,
                            json_t *attributes, int material)
{
    int colour;
    if (!(w->out->material[material].cutoff > 0.0f))
        return GP_OK;
    const gp_status st = gp_gltf_index(w->g, at, attributes, "COLOR_0",
                                       "accessors", &colour);
    if (st || colour < 0)
        return st;
    const char *const type = json_string_value(json_object_get(
        gp_gltf_item(w->g, "accessors", colour), "type"));
    w->g->odd[GP_GLTF_FADED] |= type && strcmp(type, "VEC4") == 0;
    return GP_OK;
}

static gp_status read_primitive(struct walk *w, const struct gp_json_place *at,
                                json_t *o, struct gp_mesh *mesh)
{
    struct gp_gltf *const g = w->g;
    struct gp_gltf_accessor a, index;
    json_t *const attributes = json_object_get(o, "attributes");
    struct uv_of uv;
    int mode = 4, positions, indices, material;
    gp_status st;
    if (!json_is_object(o))
        return gp_gltf_fail(at, "\"primitives\" holds no object");
    GP_TRY(gp_json_int(at, o, "mode", 0, 6, &mode));
    GP_TRY(gp_gltf_index(g, at, attributes, "POSITION", "accessors",
                         &positions));
    GP_TRY(gp_gltf_index(g, at, o, "indices", "accessors", &indices));
    GP_TRY(gp_gltf_index(g, at, o, "material", "materials", &material));
    w->drawn = w->drawn || mode < 4;
    g->odd[GP_GLTF_MORPHS] |= json_object_get(o, "targets") != NULL;
    if (mode < 4 || positions < 0)
        return GP_OK;
    material = material < 0 ? w->out->materials - 1 : material;
    GP_TRY(find_uv(w, at, attributes, material, &uv));
    GP_TRY(note_faded(w, at, attributes, material));
    GP_TRY(gp_gltf_accessor(g, positions, &a));
    if (indices >= 0)
        GP_TRY(gp_gltf_accessor(g, indices, &index));
    if (gp_gltf_extension(o, "KHR_draco_mesh_compression") &&
        (!a.all.at || (indices >= 0 && !index.all.at)))
        GP_TRY(gp_gltf_fail(at, "its triangles are compressed (Draco), which "
                            "is not supported"));
    GP_TRY(read_vertices(w, positions, &uv, &a));
    GP_TRY(add_triangles(w, mode, material, w->known[positions].first, &a,
                         indices >= 0 ? &index : NULL, &mesh->box));
out:
    return st;
}

gp_status gp_gltf_meshes(struct gp_gltf *g, struct gp_scene *out)
{
    struct walk w = {.g = g, .out = out};
    const size_t accessors = (size_t) gp_gltf_count(g, "accessors");
    gp_status st;
    out->meshes = gp_gltf_count(g, "meshes");
    GP_TRY(
        gp_gltf_alloc(g, (size_t) out->meshes, sizeof *out->mesh, &out->mesh));
    GP_TRY(gp_gltf_alloc(g, accessors, sizeof *w.known, &w.known));
    for (int i = 0; i < out->meshes; i++) {
        struct gp_mesh *const mesh = &out->mesh[i];
        json_t *const o = gp_gltf_item(g, "meshes", i), *primitive;
        json_t *const list = json_object_get(o, "primitives");
        const struct gp_json_place at = gp_gltf_at(g, "mesh", i);
        size_t k;
        mesh->first = out->submeshes;
        mesh->box = GP_BOX_EMPTY;
        if (!json_is_array(list))
            GP_TRY(gp_gltf_fail(&at, "no \"primitives\""));
        json_array_foreach (list, k, primitive) {
            GP_TRY(read_primitive(&w, &at, primitive, mesh));
        }
        mesh->submeshes = out->submeshes - mesh->first;
    }
    if (w.drawn)
        gp_say(g->log, GP_LEVEL_INFO, "%s: points and lines hide no light and "
               "are left out", g->path);
out:
    gp_free(w.known);
    return st;
}
