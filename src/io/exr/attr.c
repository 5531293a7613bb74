#include "io/exr/exr_priv.h"

#include <stddef.h>
#include <string.h>

enum {
    NAME = GP_EXR_NAME,
    CHANNEL = 16, // bytes behind a channel's name
};

/* A block of the value, so that what is short is not read one by one. */
struct window {
    const struct gp_exr_value *v;
    uint64_t from, to; // the bytes of the file that are in b
    uint8_t b[16 * NAME];
};

/* The byte at `at`, and up to `n`, at most NAME, with it: `*left` of them.
 * NULL when there is none. */
static const uint8_t *look(struct window *w, uint64_t at, uint64_t n,
                           size_t *left)
{
    const uint64_t end = w->v->at + w->v->size;
    if (n > end - at)
        n = end - at;
    if (at < w->from || at + n > w->to) {
        const uint64_t size = end - at < sizeof w->b ? end - at : sizeof w->b;
        const int64_t got = gp_stream_read(w->v->stream, w->b, size, at);
        w->from = at;
        w->to = at + (uint64_t) (got > 0 ? got : 0);
    }
    *left = (size_t) (w->to - at < n ? w->to - at : n);
    return *left > 0 ? w->b + (at - w->from) : NULL;
}

static uint32_t get32(const uint8_t *p)
{
    return (uint32_t) p[0] | (uint32_t) p[1] << 8 | (uint32_t) p[2] << 16 |
           (uint32_t) p[3] << 24;
}

uint64_t gp_exr_count_channels(const struct gp_exr_value *v, uint64_t most,
                               bool *whole)
{
    struct window w = {.v = v};
    const uint64_t end = v->at + v->size;
    uint64_t n = 0;
    *whole = false;
    for (uint64_t at = v->at; at < end && n < most; n++) {
        size_t left;
        const uint8_t *const name = look(&w, at, NAME, &left);
        const uint8_t *const null = name ? memchr(name, 0, left) : NULL;
        if (!null || null == name) { // no more, or the list's end
            *whole = null ? at + 1 == end : left < NAME && at + left < end;
            break;
        }
        at += (uint64_t) (null - name) + 1 + CHANNEL;
    }
    return n;
}

static bool is_chlist(const struct gp_exr_value *v)
{
    bool whole;
    (void) gp_exr_count_channels(v, UINT64_MAX, &whole);
    return whole;
}

static bool is_floatvector(const struct gp_exr_value *v)
{
    return v->size % 4 == 0;
}

/* The size of what is packed behind, then that. */
static bool is_idmanifest(const struct gp_exr_value *v)
{
    return v->size >= 8;
}

/* Film codes within the ranges of SMPTE 254. */
static bool is_keycode(const struct gp_exr_value *v)
{
    static const struct {
        uint32_t lo, hi;
    } range[] = {
        {0, 99},    // manufacturer
        {0, 99},    // type
        {0, 999999}, // prefix
        {0, 9999},  // count
        {0, 119},   // perforation offset
        {1, 15},    // perforations a frame
        {20, 120},  // perforations a count
    };
    enum { N = sizeof range / sizeof *range };
    uint8_t b[4 * N];
    if (v->size != sizeof b)
        return false;
    if (gp_stream_read(v->stream, b, sizeof b, v->at) != sizeof b)
        return true;
    for (size_t i = 0; i < N; i++) {
        const uint32_t code = get32(b + 4 * i);
        if (code < range[i].lo || code > range[i].hi)
            return false;
    }
    return true;
}

/* Width, height and as many RGBA bytes. */
static bool is_preview(const struct gp_exr_value *v)
{
    uint8_t b[8];
    if (v->size < sizeof b)
        return false;
    if (gp_stream_read(v->stream, b, sizeof b, v->at) != sizeof b)
        return true;
    const uint64_t w = get32(b), h = get32(b + 4);
    return w <= INT32_MAX && h <= INT32_MAX && v->size == 8 + 4 * w * h;
}

/* Strings, each behind its length. */
static bool is_stringvector(const struct gp_exr_value *v)
{
    struct window w = {.v = v};
    const uint64_t end = v->at + v->size;
    uint64_t at = v->at;
    while (at < end) {
        size_t left;
        if (end - at < 4)
            return false;
        const uint8_t *const b = look(&w, at, 4, &left);
        if (left < 4)
            return true;
        at += 4;
        if (get32(b) > end - at)
            return false;
        at += get32(b);
    }
    return true;
}

bool gp_exr_value_is(const struct gp_exr_value *v, const char *type)
{
    // those of OpenEXR's C++ library; "string" and "bytes" may be any bytes
    static const struct {
        const char *name;
        uint64_t size;
        bool (*is)(const struct gp_exr_value *v); // where it is not one size
    } types[] = {
        {"box2f", 16, NULL},         {"box2i", 16, NULL},
        {"chlist", 0, is_chlist},    {"chromaticities", 32, NULL},
        {"compression", 1, NULL},    {"deepImageState", 1, NULL},
        {"double", 8, NULL},         {"envmap", 1, NULL},
        {"float", 4, NULL},          {"floatvector", 0, is_floatvector},
        {"idmanifest", 0, is_idmanifest}, {"int", 4, NULL},
        {"keycode", 0, is_keycode},  {"lineOrder", 1, NULL},
        {"m33d", 72, NULL},          {"m33f", 36, NULL},
        {"m44d", 128, NULL},         {"m44f", 64, NULL},
        {"preview", 0, is_preview},  {"rational", 8, NULL},
        {"stringvector", 0, is_stringvector}, {"tiledesc", 9, NULL},
        {"timecode", 8, NULL},       {"v2d", 16, NULL},
        {"v2f", 8, NULL},            {"v2i", 8, NULL},
        {"v3d", 24, NULL},           {"v3f", 12, NULL},
        {"v3i", 12, NULL},
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        if (strcmp(type, types[i].name) == 0)
            return types[i].is ? types[i].is(v) : v->size == types[i].size;
    }
    return true;
}

const char *gp_exr_type_of(const char *name, bool multi)
{
    static const struct {
        const char *name, *type;
        bool multi; // only there
    } known[] = {
        {"channels", "chlist", false},
        {"compression", "compression", false},
        {"dataWindow", "box2i", false},
        {"displayWindow", "box2i", false},
        {"lineOrder", "lineOrder", false},
        {"pixelAspectRatio", "float", false},
        {"screenWindowCenter", "v2f", false},
        {"screenWindowWidth", "float", false},
        {"type", "string", false},
        {"name", "string", true},
        {"chunkCount", "int", true},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (strcmp(name, known[i].name) == 0 && (multi || !known[i].multi))
            return known[i].type;
    }
    return NULL;
}
