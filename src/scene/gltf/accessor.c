/* Numbers from buffers: every component type, strides, normalised integers,
 * sparse replacements (specification, 3.6.2). */
#include "scene/gltf/gltf_priv.h"

#include "core/bytes.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* glTF's componentType. */
enum {
    I8 = 5120, U8, I16, U16, U32 = 5125, F32,
};
static const float MOST_VALUE = 1e15f;

/* Returns the bytes of a number, 0 of an unknown type. */
static int type_bytes(int type)
{
    return type == I8 || type == U8     ? 1
           : type == I16 || type == U16 ? 2
           : type == U32 || type == F32 ? 4
                                        : 0;
}

/* Checks that `count` elements of that many bytes are in a buffer view. */
static gp_status check_numbers(const struct gp_gltf *g,
    const struct gp_gltf_at *at, json_t *o, bool strided, int count, int bytes,
    struct gp_gltf_numbers *out)
{
    struct gp_gltf_span span;
    int view, offset = 0, stride;
    gp_status st;
    GP_TRY(gp_gltf_index(g, at, o, "bufferView", "bufferViews", &view));
    GP_TRY(gp_json_int(&at->p, o, "byteOffset", 0, INT_MAX, &offset, NULL));
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
    const struct gp_gltf_at *const at = &a->place;
    json_t *const where = json_object_get(o, "indices");
    json_t *const with = json_object_get(o, "values");
    gp_status st;
    GP_TRY(gp_json_int(&at->p, o, "count", 1, a->count, &a->sparse, NULL));
    GP_TRY(gp_json_int(&at->p, where, "componentType", U8, U32, &a->where.type,
                       NULL));
    if (a->where.type != U8 && a->where.type != U16 && a->where.type != U32)
        return gp_gltf_fail(at, "\"sparse\" counts in component type %d",
                            a->where.type);
    a->with.type = a->all.type;
    GP_TRY(check_numbers(g, at, where, false, a->sparse,
                         type_bytes(a->where.type), &a->where));
    GP_TRY(check_numbers(g, at, with, false, a->sparse,
                         a->components * type_bytes(a->with.type), &a->with));
    if (!a->sparse || !a->where.at || !a->with.at)
        return gp_gltf_fail(at, "\"sparse\" without count, indices or values");
out:
    return st;
}

gp_status gp_gltf_accessor(const struct gp_gltf *g, int index,
                           struct gp_gltf_accessor *out)
{
    static const char *const types[] = {
        "SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4", NULL,
    };
    json_t *const o = gp_gltf_item(g, "accessors", index);
    const struct gp_gltf_at *const at = &out->place;
    int type = -1;
    gp_status st;
    memset(out, 0, sizeof *out);
    gp_gltf_place(g, "accessor", index, &out->place);
    GP_TRY(gp_json_int(&at->p, o, "componentType", I8, F32, &out->all.type,
                       NULL));
    GP_TRY(gp_json_choice(&at->p, o, "type", types, &type, NULL));
    GP_TRY(gp_json_int(&at->p, o, "count", 1, INT_MAX / 16, &out->count, NULL));
    if (!type_bytes(out->all.type) || type < 0 || type > 3 || !out->count)
        return gp_gltf_fail(at, "%s", out->count ? "a type that is not read "
                            "(numbers and vectors are)" : "no \"count\"");
    out->components = type + 1;
    const json_t *const normalized = json_object_get(o, "normalized");
    out->normalized = json_is_true(normalized) && out->all.type != F32;
    GP_TRY(check_numbers(g, at, o, true, out->count,
                         out->components * type_bytes(out->all.type),
                         &out->all));
    json_t *const sparse = json_object_get(o, "sparse");
    if (sparse)
        GP_TRY(check_sparse(g, sparse, out));
out:
    return st;
}

/* Returns a number as stored, and what 1 is stored as, for normalised ones. */
static float stored_number(const uint8_t *p, int type, float *unit)
{
    int8_t i8;
    int16_t i16;
    uint16_t u16;
    switch (type) {
    case I8:
        memcpy(&i8, p, sizeof i8);
        *unit = 127.0f;
        return (float) i8;
    case U8:
        *unit = 255.0f;
        return (float) *p;
    case I16:
        memcpy(&i16, p, sizeof i16);
        *unit = 32767.0f;
        return (float) i16;
    case U16:
        memcpy(&u16, p, sizeof u16);
        *unit = 65535.0f;
        return (float) u16;
    case U32:
        *unit = 4294967295.0f;
        return (float) gp_le32(p);
    default:
        *unit = 1.0f;
        return gp_float_with_bits(gp_le32(p));
    }
}

static uint32_t load_index(const uint8_t *p, int type)
{
    uint16_t u16;
    if (type == U8)
        return *p;
    if (type == U32)
        return gp_le32(p);
    memcpy(&u16, p, sizeof u16);
    return u16;
}

/* Converts one element. Returns false for a value that is not finite, or over
 * MOST_VALUE. */
static bool convert(const struct gp_gltf_accessor *a, int type,
                    const uint8_t *from, float *to)
{
    const int bytes = type_bytes(type);
    bool good = true;
    for (int c = 0; c < a->components; c++) {
        float unit;
        float v = stored_number(from + c * bytes, type, &unit);
        if (a->normalized)
            v = fmaxf(v / unit, -1.0f);
        good = good && fabsf(v) <= MOST_VALUE;
        to[c] = v;
    }
    return good;
}

/* Finds the element that number i of "sparse" replaces. */
static gp_status replaced(const struct gp_gltf_accessor *a, int i, uint32_t *at)
{
    *at = load_index(a->where.at + (size_t) i * (size_t) a->where.stride,
                     a->where.type);
    return *at < (uint32_t) a->count
               ? GP_OK
               : gp_gltf_fail(&a->place, "\"sparse\" replaces element %u of %d",
                              *at, a->count);
}

gp_status gp_gltf_floats(const struct gp_gltf_accessor *a, int components,
                         float *out)
{
    if (a->components != components)
        return gp_gltf_fail(&a->place, "elements of %d numbers, where %d are "
                            "needed", a->components, components);
    if (!a->all.at)
        memset(out, 0, (size_t) a->count * (size_t) components * sizeof *out);
    for (int i = 0; i < a->count && a->all.at; i++) {
        const uint8_t *const from = a->all.at + (size_t) i *
                                                (size_t) a->all.stride;
        if (!convert(a, a->all.type, from,
                     out + (size_t) i * (size_t) components))
            return gp_gltf_fail(&a->place, "element %d is not finite, or over "
                                "%g", i, (double) MOST_VALUE);
    }
    for (int i = 0; i < a->sparse; i++) {
        const size_t k = (size_t) i;
        uint32_t at;
        const gp_status st = replaced(a, i, &at);
        if (st)
            return st;
        if (!convert(a, a->with.type, a->with.at + k * (size_t) a->with.stride,
                     out + (size_t) at * (size_t) components))
            return gp_gltf_fail(&a->place, "element %u is not finite, or over "
                                "%g", at, (double) MOST_VALUE);
    }
    return GP_OK;
}

gp_status gp_gltf_indices(const struct gp_gltf_accessor *a, int below,
                          uint32_t *out)
{
    const int type = a->all.type;
    if (a->components != 1 || (!a->sparse && !a->all.at) ||
        (type != U8 && type != U16 && type != U32))
        return gp_gltf_fail(&a->place, "it cannot be indices (component type "
                            "%d, %d to an element)", type, a->components);
    for (int i = 0; i < a->count; i++)
        out[i] = a->all.at ? load_index(a->all.at + (size_t) i *
                                        (size_t) a->all.stride, type)
                           : 0;
    for (int i = 0; i < a->sparse; i++) {
        uint32_t at;
        const gp_status st = replaced(a, i, &at);
        if (st)
            return st;
        out[at] = load_index(a->with.at + (size_t) i * (size_t) a->with.stride,
                             type);
    }
    for (int i = 0; i < a->count; i++) {
        if (out[i] >= (uint32_t) below)
            return gp_gltf_fail(&a->place, "index %d is %u, there are %d "
                                "vertices", i, out[i], below);
    }
    return GP_OK;
}
