#include "io/members.h"

#include "core/memory.h"
#include "io/exr/exr.h"
#include "io/read_open.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

static const uint8_t exr_magic[4] = {0x76, 0x2f, 0x31, 0x01};
static const uint8_t png_magic[8] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10};

/* The bytes that are left, from the start of an image on. */
struct rest {
    const uint8_t *data;
    uint64_t size;
};

static bool starts(const struct rest *r, const void *magic, size_t n)
{
    return r->size >= n && memcmp(r->data, magic, n) == 0;
}

// -- EXR -----------------------------------------------------------------------

/* Bytes of an EXR, 0 when they cannot be told. Fails, without a line, only
 * when memory is full: that is no damage of the file. */
static gp_status exr_size(const struct rest *r, uint64_t *size)
{
    struct gp_stream view = {.fd = -1, .borrowed = true, .size = r->size,
                             .data = (uint8_t *) (uintptr_t) r->data};
    struct gp_input *o;
    const gp_status st = gp_exr_open(NULL, "-", &view, &o);
    if (st)
        return st == GP_ERR_BUG ? st : GP_OK;
    *size = o->end;
    gp_input_free(o);
    return GP_OK;
}

// -- PNG -----------------------------------------------------------------------

static uint64_t png_size(const struct rest *r)
{
    uint64_t at = sizeof png_magic;
    while (r->size - at >= 12) { // length, type, checksum
        const uint8_t *c = r->data + at;
        const uint64_t length = (uint64_t) c[0] << 24 | (uint64_t) c[1] << 16 |
                                (uint64_t) c[2] << 8 | c[3];
        if (length > r->size - at - 12)
            return 0;
        at += 12 + length;
        if (memcmp(c + 4, "IEND", 4) == 0)
            return at;
    }
    return 0;
}

// -- PFM -----------------------------------------------------------------------

static bool is_space(uint8_t c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/* A whole number up to INT_MAX behind white space; 0 when there is none. */
static uint64_t whole_number(const struct rest *r, uint64_t *at)
{
    uint64_t v = 0;
    while (*at < r->size && is_space(r->data[*at]))
        (*at)++;
    for (; *at < r->size; (*at)++) {
        const uint8_t c = r->data[*at];
        if (c < '0' || c > '9' || v > INT_MAX)
            break;
        v = v * 10 + (uint64_t) (c - '0');
    }
    return v <= INT_MAX ? v : 0;
}

/* Portable float map, by P. Debevec: "PF" or "Pf", width, height, scale, one
 * white space, then three floats or one for each pixel. */
static uint64_t pfm_size(const struct rest *r)
{
    const uint64_t sample = r->data[1] == 'F' ? 12 : 4;
    uint64_t at = 2;
    const uint64_t w = whole_number(r, &at), h = whole_number(r, &at);
    while (at < r->size && is_space(r->data[at]))
        at++;
    while (at < r->size && !is_space(r->data[at])) // the scale
        at++;
    if (w == 0 || h == 0 || at == r->size)
        return 0;
    at++;
    return h <= (r->size - at) / (w * sample) ? at + w * h * sample : 0;
}

// -- all of them ----------------------------------------------------------------

static bool is_pfm(const struct rest *r)
{
    return (starts(r, "PF", 2) || starts(r, "Pf", 2)) && r->size > 2 &&
           is_space(r->data[2]);
}

/* *known: whether an image begins here that may stand among others. *size is
 * its bytes, 0 when they cannot be told. Fails as exr_size() does. */
static gp_status measure(const struct rest *r, bool *known, uint64_t *size)
{
    *size = 0;
    *known = true;
    if (starts(r, exr_magic, sizeof exr_magic))
        return exr_size(r, size);
    if (starts(r, png_magic, sizeof png_magic))
        *size = png_size(r);
    else if (is_pfm(r))
        *size = pfm_size(r);
    else
        *known = false;
    return GP_OK;
}

static gp_status add_member(const struct gp_log *log, struct gp_members *m,
                            uint64_t at, uint64_t size)
{
    if ((m->n & (m->n - 1)) == 0) { // room doubles at powers of two
        void *wider;
        gp_status st = gp_alloc(log, "frame list", m->n ? 2 * (size_t) m->n : 1,
                                sizeof *m->member, &wider);
        if (st)
            return st;
        if (m->n)
            memcpy(wider, m->member, (size_t) m->n * sizeof *m->member);
        gp_free(m->member);
        m->member = wider;
    }
    m->member[m->n++] = (struct gp_member) {at, size};
    return GP_OK;
}

static gp_status find_members(const struct gp_log *log, const char *path,
                              struct gp_members *m)
{
    const uint64_t end = m->stream.size;
    for (uint64_t at = 0; at < end;) {
        const struct rest r = {m->stream.data + at, end - at};
        uint64_t size;
        bool known;
        if (measure(&r, &known, &size))
            return gp_fail(log, GP_ERR_BUG, "%s: out of memory; close other "
                           "programs", path);
        if (!known && m->n > 0)
            return gp_fail(log, GP_ERR_DATA,
                           "%s: what follows frame %d is no EXR, PNG or PFM "
                           "(found %02x at byte %llu); give whole files one "
                           "behind the other", path, m->n, r.data[0],
                           (unsigned long long) at);
        if (size == 0 || size > r.size)
            size = r.size;
        gp_status st = add_member(log, m, at, size);
        if (st)
            return st;
        for (at += size; at < end && m->stream.data[at] == 0; at++)
            ;
    }
    return GP_OK;
}

gp_status gp_members_read(const struct gp_log *log,
                          const struct gp_read_params *p, const char *path,
                          struct gp_members *out)
{
    struct gp_members m = {.stream = GP_STREAM_EMPTY};
    bool exr;
    gp_status st = gp_read_open(log, p, path, &m.stream, &exr);
    if (!st && !m.stream.data)
        st = gp_fail(log, GP_ERR_BUG, "%s: is no pipe", path);
    if (!st)
        st = find_members(log, path, &m);
    if (st)
        gp_members_free(&m);
    else
        *out = m;
    return st;
}

void gp_members_free(struct gp_members *m)
{
    if (m->stream.data) // one that is all zero has no stream either
        gp_stream_close(&m->stream);
    gp_free(m->member);
    *m = (struct gp_members) {.stream = GP_STREAM_EMPTY};
}

gp_status gp_members_frame(const struct gp_log *log,
                           const struct gp_read_params *p, const char *name,
                           const struct gp_members *m, int i,
                           struct gp_frame *out)
{
    struct gp_stream view = {
        .fd = -1, .borrowed = true, .size = m->member[i].size,
        .data = m->stream.data + m->member[i].at,
    };
    return gp_read_stream(log, p, name, &view, out);
}
