#include "io/exr/exr_priv.h"

#include "core/memory.h"

#include <limits.h>
#include <string.h>

enum { FIRST_BYTES = 1 << 16 }; // holds nearly all headers

static uint32_t get32(const uint8_t *p)
{
    return (uint32_t) p[0] | (uint32_t) p[1] << 8 | (uint32_t) p[2] << 16 |
           (uint32_t) p[3] << 24;
}

/* A walk over the header's bytes; `at` stays at an attribute's start. */
struct walk {
    const uint8_t *bytes;
    size_t size, at;
};

enum step { ATTRIBUTE, END_OF_PART, TOO_SHORT, DAMAGED };

/* A name of 1 to 255 bytes and its null; NULL when it does not end in time. */
static const char *walk_name(const struct walk *w, size_t *at)
{
    const size_t left = w->size - *at;
    const uint8_t *start = w->bytes + *at;
    const uint8_t *end = memchr(start, 0, left < 256 ? left : 256);
    if (!end)
        return NULL;
    *at += (size_t) (end - start) + 1;
    return (const char *) start;
}

static enum step walk_next(struct walk *w, struct gp_exr_attr *a)
{
    size_t at = w->at;
    if (at >= w->size)
        return TOO_SHORT;
    if (w->bytes[at] == 0) {
        w->at++;
        return END_OF_PART;
    }
    a->name = walk_name(w, &at);
    a->type = a->name ? walk_name(w, &at) : NULL;
    if (!a->type)
        return w->size - w->at < 512 ? TOO_SHORT : DAMAGED;
    if (w->size - at < 4)
        return TOO_SHORT;
    a->size = get32(w->bytes + at);
    a->data = w->bytes + at + 4;
    if (a->size > INT_MAX)
        return DAMAGED;
    if (w->size - at - 4 < a->size)
        return TOO_SHORT;
    w->at = at + 4 + a->size;
    return ATTRIBUTE;
}

/* Counts attributes and the header's size, or with `raw` filled in, fills its
 * lists. Returns END_OF_PART when the whole header was walked. */
static enum step walk_header(struct walk *w, int parts, int *attrs,
                             struct gp_exr_raw *raw)
{
    *attrs = 0;
    w->at = 8;
    for (int p = 0; p < parts; p++) {
        struct gp_exr_attr a;
        const size_t begin = w->at;
        const int first = *attrs;
        enum step step;
        while ((step = walk_next(w, &a)) == ATTRIBUTE) {
            if (raw)
                raw->attr[*attrs] = a;
            ++*attrs;
        }
        if (step != END_OF_PART)
            return step;
        if (raw)
            raw->part[p] = (struct gp_exr_raw_part) {
                w->bytes + begin, w->at - begin, raw->attr + first,
                *attrs - first,
            };
    }
    if (get32(w->bytes + 4) & GP_EXR_MULTIPART) { // one more null ends it
        if (w->at >= w->size)
            return TOO_SHORT;
        if (w->bytes[w->at++] != 0)
            return DAMAGED;
    }
    return END_OF_PART;
}

static gp_status damaged(const struct gp_log *log, const char *path)
{
    return gp_fail(log, GP_ERR_DATA,
                   "%s: the EXR header cannot be read again (cut off or "
                   "damaged); copy or render the file again", path);
}

/* Reads the first `size` bytes again, into a larger block. */
static gp_status load(const struct gp_log *log, const char *path,
                      const struct gp_input *o, size_t size,
                      struct gp_exr_raw *raw)
{
    void *bytes;
    gp_status st = gp_alloc(log, path, size, 1, &bytes);
    if (st)
        return st;
    gp_free(raw->bytes);
    raw->bytes = bytes;
    raw->size = size;
    gp_exr_fault_clear();
    if (gp_exr_read_bytes(&o->stream, bytes, size, 0) == (int64_t) size)
        return GP_OK;
    return gp_exr_fault() ? gp_exr_fault_print(log, path, gp_exr_fault())
                          : damaged(log, path);
}

gp_status gp_exr_raw_read(const struct gp_log *log, const char *path,
                          const struct gp_input *o, struct gp_exr_raw *out)
{
    gp_status st;
    void *part = NULL, *attr = NULL;
    int attrs = 0;
    struct gp_exr_raw raw = {.parts = o->parts};
    struct walk w = {0};
    enum step step = TOO_SHORT;
    for (uint64_t size = FIRST_BYTES; step == TOO_SHORT; size *= 2) {
        if (raw.size >= o->stream.size)
            GP_TRY(damaged(log, path));
        const uint64_t most = o->stream.size;
        GP_TRY(load(log, path, o, (size_t) (size < most ? size : most), &raw));
        w = (struct walk) {.bytes = raw.bytes, .size = raw.size};
        if (w.size >= 8)
            step = walk_header(&w, raw.parts, &attrs, NULL);
    }
    if (step != END_OF_PART)
        GP_TRY(damaged(log, path));
    GP_TRY(gp_alloc_zero(log, path, (size_t) attrs, sizeof *raw.attr, &attr));
    raw.attr = attr;
    GP_TRY(gp_alloc_zero(log, path, (size_t) raw.parts, sizeof *raw.part,
                         &part));
    raw.part = part;
    (void) walk_header(&w, raw.parts, &attrs, &raw);
    raw.size = w.at;
    raw.version = get32(raw.bytes + 4);
    *out = raw;
    return GP_OK;
out:
    gp_exr_raw_free(&raw);
    *out = raw;
    return st;
}

void gp_exr_raw_free(struct gp_exr_raw *raw)
{
    gp_free(raw->bytes);
    gp_free(raw->part);
    gp_free(raw->attr);
    *raw = (struct gp_exr_raw) {0};
}

const struct gp_exr_attr *gp_exr_raw_find(const struct gp_exr_raw_part *part,
                                          const char *name, const char *type)
{
    for (int i = 0; i < part->attrs; i++) {
        const struct gp_exr_attr *a = &part->attr[i];
        if (strcmp(a->name, name) == 0 && strcmp(a->type, type) == 0)
            return a;
    }
    return NULL;
}
