// SPDX-License-Identifier: Apache-2.0
/* Numbers from buffers: every component type, strides, normalised integers,
 * sparse replacements (specification, 3.6.2). */
#include "scene/gltf/gltf_priv.h"

#include "core/bytes.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* glTF's componentType. */
enum {
    I8 = 5120,
    U8,
    I16,
    U16,
    U32 = 5125,
    F32,
};

/* Of each type from I8 on: bytes of a number, 0 of no type; and the number that 1 is
 * stored as, normalised. */
static const struct {
    int bytes;
    double unit;
} types[] = {{1, 127}, {1, 255},        {2, 32767}, {2, 65535},
             {0, 1},   {4, 4294967295}, {4, 1}};

/* Checks that `count` elements of that many bytes are in a buffer view. */
static gp_status check_numbers(const struct gp_gltf *g,
                               const struct gp_json_place *at, json_t *o,
                               bool strided, int count, int bytes,
                               struct gp_gltf_numbers *out)
{
    struct gp_gltf_span span;
    int view, offset = 0, stride;
    gp_status st;
    GP_TRY(gp_gltf_index(g, at, o, "bufferView", "bufferViews", &view));
    GP_TRY(gp_json_int(at, o, "byteOffset", 0, INT_MAX, &offset));
    if (view < 0)
        return GP_OK; // zeros
    GP_TRY(gp_gltf_view(g, view, &span, &stride));
    if (!span.at)
        return gp_gltf_fail(at, "its bytes are compressed (meshopt), which is "
                            "not supported");
    stride = strided && stride ? stride : bytes;
    const long long end =
        offset + (long long) stride * (count - 1) + (long long) bytes;
    if (stride < bytes || end > span.bytes)
        return gp_gltf_fail(at, "it leaves its buffer view (%d elements of %d "
                            "bytes end at byte %lld of %d)", count, bytes, end,
                            span.bytes);
    out->at = span.at + offset;
    out->stride = stride;
out:
    return st;
}

static gp_status check_sparse(const struct gp_gltf *g, json_t *o,
                              struct gp_gltf_accessor *a)
{
    const struct gp_json_place *const at = &a->place;
    json_t *const where = json_object_get(o, "indices");
    json_t *const with = json_object_get(o, "values");
    gp_status st;
    GP_TRY(gp_json_int(at, o, "count", 1, a->count, &a->sparse));
    GP_TRY(gp_json_int(at, where, "componentType", U8, U32, &a->where.type));
    if (a->where.type != U8 && a->where.type != U16 && a->where.type != U32)
        return gp_gltf_fail(at, "\"sparse\" counts in component type %d",
                            a->where.type);
    a->with.type = a->all.type;
    GP_TRY(check_numbers(g, at, where, false, a->sparse,
                         types[a->where.type - I8].bytes, &a->where));
    GP_TRY(check_numbers(g, at, with, false, a->sparse,
                         a->components * types[a->with.type - I8].bytes,
                         &a->with));
    if (!a->sparse || !a->where.at || !a->with.at)
        return gp_gltf_fail(at, "\"sparse\" without count, indices or values");
out:
    return st;
}

gp_status gp_gltf_accessor(const struct gp_gltf *g, int index,
                           struct gp_gltf_accessor *out)
{
    static const char *const shapes[] = {
        "SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4", NULL,
    };
    json_t *const o = gp_gltf_item(g, "accessors", index);
    const struct gp_json_place *const at = &out->place;
    int type = -1;
    gp_status st;
    memset(out, 0, sizeof *out);
    out->place = gp_gltf_at(g, "accessor", index);
    GP_TRY(gp_json_int(at, o, "componentType", I8, F32, &out->all.type));
    GP_TRY(gp_json_choice(at, o, "type", shapes, &type));
    GP_TRY(gp_json_int(at, o, "count", 1, INT_MAX / 16, &out->count));
    if (!out->all.type || !types[out->all.type - I8].bytes || type < 0 ||
        type > 3 || !out->count)
        return gp_gltf_fail(at, "%s", out->count ? "a type that is not read "
                            "(numbers and vectors are)" : "no \"count\"");
    out->components = type + 1;
    const json_t *const normalized = json_object_get(o, "normalized");
    out->normalized = json_is_true(normalized) && out->all.type != F32;
    GP_TRY(check_numbers(g, at, o, true, out->count,
                         out->components * types[out->all.type - I8].bytes,
                         &out->all));
    json_t *const sparse = json_object_get(o, "sparse");
    if (sparse)
        GP_TRY(check_sparse(g, sparse, out));
out:
    return st;
}

static double stored_number(const uint8_t *p, int type)
{
    if (type == F32)
        return (double) gp_float_with_bits(gp_le32(p));
    if (type == U32)
        return gp_le32(p);
    const int bytes = types[type - I8].bytes,
              v = bytes == 2 ? p[0] | p[1] << 8 : *p;
    const int sign = type == I8 || type == I16 ? 1 << (8 * bytes - 1) : 0;
    return (v ^ sign) - sign;
}

/* Reads element k, of those of "sparse" after the others, and which one of the
 * accessor it is. */
static gp_status read_element(const struct gp_gltf_accessor *a, int k, int *at,
                              double out[4])
{
    const bool sparse = k >= a->count;
    const size_t i = (size_t) (sparse ? k - a->count : k);
    const struct gp_gltf_numbers *const n = sparse ? &a->with : &a->all;
    double where = k;
    if (sparse)
        where = stored_number(a->where.at + i * (size_t) a->where.stride,
                              a->where.type);
    if (where >= a->count)
        return gp_gltf_fail(&a->place, "\"sparse\" replaces element %.0f of %d",
                            where, a->count);
    *at = (int) where;
    for (int c = 0; c < a->components; c++) {
        out[c] = 0.0;
        if (!n->at)
            continue;
        out[c] = stored_number(n->at + i * (size_t) n->stride +
                                   c * types[n->type - I8].bytes,
                               n->type);
        if (a->normalized)
            out[c] = fmax(out[c] / types[n->type - I8].unit, -1.0);
    }
    return GP_OK;
}

gp_status gp_gltf_floats(const struct gp_gltf_accessor *a, int components,
                         float *out)
{
    double v[4];
    int at;
    if (a->components != components)
        return gp_gltf_fail(&a->place, "elements of %d numbers, where %d are "
                            "needed", a->components, components);
    for (int k = 0; k < a->count + a->sparse; k++) {
        const gp_status st = read_element(a, k, &at, v);
        if (st)
            return st;
        for (int c = 0; c < components; c++) {
            if (!(fabs(v[c]) <= GP_GLTF_MOST))
                return gp_gltf_fail(&a->place,
                                    "element %d is not finite, or "
                                    "over %g",
                                    at, GP_GLTF_MOST);
            out[(size_t) at * (size_t) components + (size_t) c] = (float) v[c];
        }
    }
    return GP_OK;
}

gp_status gp_gltf_indices(const struct gp_gltf_accessor *a, int below,
                          uint32_t *out)
{
    const int type = a->all.type;
    double v[4];
    int at;
    if (a->components != 1 || (!a->sparse && !a->all.at) ||
        (type != U8 && type != U16 && type != U32))
        return gp_gltf_fail(&a->place, "it cannot be indices (component type "
                            "%d, %d to an element)", type, a->components);
    for (int k = 0; k < a->count + a->sparse; k++) {
        const gp_status st = read_element(a, k, &at, v);
        if (st)
            return st;
        if (v[0] >= below)
            return gp_gltf_fail(&a->place, "index %d is %.0f, there are %d "
                                "vertices", at, v[0], below);
        out[at] = (uint32_t) v[0];
    }
    return GP_OK;
}
