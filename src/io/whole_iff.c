#include "io/whole_iff.h"

#include "core/memory.h"

#include <errno.h>
#include <stdbool.h>
#include <string.h>

struct iff {
    const struct gp_log *log;
    const char *path;
    const struct gp_stream *s;
    uint64_t at;            // of the next chunk
    uint64_t w, h, planes;  // a plane is a byte of a channel
    uint32_t tiles, x, y;
};

struct chunk {
    char type[4];
    uint64_t at, size;      // of its bytes
};

/* Of the head's flags. */
enum { RGB = 1, ALPHA = 2 };

static gp_status damaged(const struct iff *f, const char *what)
{
    return gp_fail(f->log, GP_ERR_DATA,
                   "%s: cut off or damaged (%s); copy or render the file again",
                   f->path, what);
}

static gp_status take(const struct iff *f, uint64_t at, uint64_t n, void *to)
{
    const int64_t got = gp_stream_read(f->s, to, n, at);
    if (got < 0)
        return gp_fail(f->log, GP_ERR_IO,
                       "%s: cannot be read (%s); check the disk", f->path,
                       strerror(errno));
    return (uint64_t) got == n ? GP_OK
                               : damaged(f, "the file ends in its pixels");
}

static uint32_t be(const uint8_t *b, int n)
{
    uint32_t v = 0;
    for (int i = 0; i < n; i++)
        v = v << 8 | b[i];
    return v;
}

static bool is(const struct chunk *c, const char *type)
{
    return memcmp(c->type, type, sizeof c->type) == 0;
}

/* The chunk at f->at, which moves behind it, to the next four bytes. */
static gp_status next_chunk(struct iff *f, struct chunk *c)
{
    uint8_t head[8];
    const gp_status st = take(f, f->at, sizeof head, head);
    if (st)
        return st;
    memcpy(c->type, head, sizeof c->type);
    c->size = be(head + 4, 4);
    c->at = f->at + sizeof head;
    if (c->size > f->s->size - c->at)
        return damaged(f, "the file ends in its pixels");
    f->at = c->at + (c->size + 3) / 4 * 4;
    return GP_OK;
}

/* To the first chunk of this type. */
static gp_status find_chunk(struct iff *f, const char *type, struct chunk *c)
{
    gp_status st;
    do
        st = next_chunk(f, c);
    while (!st && !is(c, type));
    return st;
}

static gp_status read_head(struct iff *f)
{
    struct chunk c = {0};
    uint8_t b[32] = {0};
    gp_status st = find_chunk(f, "TBHD", &c);
    if (!st && c.size != 24 && c.size != 32)
        st = damaged(f, "its head has another size");
    if (!st)
        st = take(f, c.at, c.size, b);
    if (st)
        return st;
    const uint32_t flags = be(b + 12, 4);
    f->w = be(b, 4);
    f->h = be(b + 4, 4);
    f->planes = (flags & ALPHA ? 4 : 3) * (be(b + 16, 2) ? 2U : 1U);
    f->tiles = be(b + 18, 2);
    f->x = be(b + 24, 4);
    f->y = be(b + 28, 4);
    return flags & RGB ? GP_OK : damaged(f, "it has no colours");
}

/* Whether runs give exactly `size` bytes; *in moves behind them. */
static bool runs_are_whole(const uint8_t **in, const uint8_t *end,
                           uint64_t size)
{
    while (size > 0 && *in < end) {
        const uint64_t count = (**in & 0x7f) + 1U;
        const uint64_t taken = 1 + (**in & 0x80 ? 1 : count);
        if (count > size || taken > (uint64_t) (end - *in))
            return false;
        *in += taken;
        size -= count;
    }
    return size == 0;
}

/* A tile's place, then its planes, packed where they would be longer. */
static gp_status check_tile(const struct iff *f, const struct chunk *c,
                            const uint8_t *b, uint64_t *area)
{
    if (c->size < 8)
        return damaged(f, "a tile has no place");
    const uint32_t x0 = be(b, 2), y0 = be(b + 2, 2);
    const uint32_t x1 = be(b + 4, 2), y1 = be(b + 6, 2);
    if (x0 > x1 || y0 > y1 || x1 >= f->w || y1 >= f->h)
        return damaged(f, "a tile lies outside of the picture");
    const uint64_t size = (x1 - x0 + 1ULL) * (y1 - y0 + 1ULL);
    if (size * f->planes > UINT32_MAX - 8)
        return damaged(f, "a tile is too large for OpenImageIO");
    const uint8_t *in = b + 8;
    bool whole = true;
    if (c->size < 8 + size * f->planes) {
        for (uint64_t i = 0; whole && i < f->planes; i++)
            whole = runs_are_whole(&in, b + c->size, size);
    }
    *area += size;
    return whole ? GP_OK : damaged(f, "a tile does not unpack to its rows");
}

static gp_status check_tiles(struct iff *f)
{
    gp_status st = GP_OK;
    uint64_t area = 0;
    for (uint32_t i = 0; !st && i < f->tiles; i++) {
        struct chunk c = {0};
        void *bytes = NULL;
        st = next_chunk(f, &c);
        if (!st && !is(&c, "RGBA"))
            return damaged(f, "a chunk between its tiles, which OpenImageIO "
                           "reads wrong");
        if (!st)
            st = gp_alloc(f->log, "tile", c.size + 1, 1, &bytes);
        if (!st)
            st = take(f, c.at, c.size, bytes);
        if (!st)
            st = check_tile(f, &c, bytes, &area);
        gp_free(bytes);
    }
    return st || area == f->w * f->h
               ? st : damaged(f, "its tiles have not the picture's area");
}

/* The file's length, that it is a picture, and its head. */
static gp_status check_head(struct iff *f)
{
    uint8_t b[12];
    gp_status st = take(f, 0, sizeof b, b);
    if (!st && be(b + 4, 4) > f->s->size - 8)
        st = damaged(f, "the file ends in its pixels");
    if (!st && memcmp(b + 8, "CIMG", 4) != 0)
        st = damaged(f, "it is an IFF of another kind");
    f->at = sizeof b;
    if (!st)
        st = read_head(f);
    if (!st && (f->x || f->y))
        st = damaged(f, "its origin is not 0,0, which OpenImageIO reads wrong");
    return st;
}

gp_status gp_whole_iff(const struct gp_log *log, const char *path,
                       const struct gp_stream *s, long long max_pixels)
{
    struct iff f = {.log = log, .path = path, .s = s};
    struct chunk c = {0};
    char kind[4] = "";
    gp_status st = check_head(&f);
    if (!st)
        st = find_chunk(&f, "FOR4", &c);
    if (!st)
        st = take(&f, c.at, sizeof kind, kind);
    if (!st && memcmp(kind, "TBMP", sizeof kind) != 0)
        st = damaged(&f, "it has no tiles");
    if (st || f.w * f.h > (uint64_t) max_pixels)
        return st;
    f.at = c.at + sizeof kind;
    return check_tiles(&f);
}
