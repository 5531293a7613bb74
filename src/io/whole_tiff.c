#include "io/whole_tiff.h"

#include "io/whole_zip.h"

#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <string.h>

/* A field of a directory; no value when count is 0. */
struct field {
    uint64_t at;     // of its first value in the file
    uint64_t count;
    unsigned size;   // bytes of a value
};

enum {
    WIDTH, HEIGHT, BITS, COMPRESSION, PHOTOMETRIC, BIT_ORDER, STRIP_OFFSETS,
    SAMPLES, STRIP_ROWS, STRIP_COUNTS, PLANAR, TILE_WIDTH, TILE_HEIGHT,
    TILE_OFFSETS, TILE_COUNTS, FIELDS
};
static const uint16_t tags[FIELDS] = {256, 257, 258, 259, 262, 266, 273, 277,
                                      278, 279, 284, 322, 323, 324, 325};

struct tiff {
    const struct gp_log *log;
    const char *path;
    const struct gp_stream *s;
    long long max_pixels;
    bool motorola;   // high byte first
    bool large;      // offsets of 8 bytes
    struct field field[FIELDS];
};

/* What a directory says of its strips or tiles, which are "chunks" here. */
struct chunks {
    const char *name;
    uint64_t number, across, down; // down: in one plane
    uint64_t rows, height;         // of a chunk, of the picture
    uint64_t row_bytes;            // unpacked; 0 unknown
    uint64_t ratio;                // most bytes that one packed byte gives;
                                   // 1 uncompressed, 0 unknown
    bool zip;                      // and to be unpacked here
    struct field offsets, counts;
};

static gp_status damaged(const struct tiff *t, const char *what,
                         uint64_t found)
{
    return gp_fail(t->log, GP_ERR_DATA,
                   "%s: cut off or damaged (%s %" PRIu64 " of %" PRIu64
                   " bytes); copy or render the file again", t->path, what,
                   found, t->s->size);
}

static bool within(const struct tiff *t, uint64_t at, uint64_t bytes)
{
    return bytes <= t->s->size && at <= t->s->size - bytes;
}

static uint64_t number(const struct tiff *t, const uint8_t *b, unsigned n)
{
    uint64_t v = 0;
    for (unsigned i = 0; i < n; i++)
        v = v << 8 | b[t->motorola ? i : n - 1 - i];
    return v;
}

static gp_status take(const struct tiff *t, const char *what, uint64_t at,
                      unsigned n, uint8_t *to)
{
    if (!within(t, at, n))
        return damaged(t, what, at);
    const int64_t got = gp_stream_read(t->s, to, n, at);
    if (got < 0)
        return gp_fail(t->log, GP_ERR_IO,
                       "%s: cannot be read (%s); check the disk", t->path,
                       strerror(errno));
    return got == (int64_t) n ? GP_OK : damaged(t, what, at);
}

// -- directories --------------------------------------------------------------

/* Bytes of a value of each type; 0 for what is none. */
static unsigned type_size(unsigned type)
{
    static const uint8_t size[] = {
        0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8,
    };
    return type < sizeof size ? size[type] : 0;
}

static bool is_whole_number(unsigned type)
{
    return type == 1 || type == 3 || type == 4 || type == 13 || type == 16 ||
           type == 18;
}

/* Values of fields that nobody asks for are there too, or the file is cut. */
static gp_status keep_field(struct tiff *t, uint64_t at, const uint8_t *b)
{
    const unsigned tag = (unsigned) number(t, b, 2);
    const unsigned type = (unsigned) number(t, b + 2, 2);
    const unsigned wide = t->large ? 8 : 4; // of a count, and of an offset
    struct field f = {.size = type_size(type), .count = number(t, b + 4, wide)};
    if (!f.size)
        return GP_OK;
    if (f.count > t->s->size)
        return damaged(t, "a field with more values than", f.count);
    f.at = f.count * f.size <= wide ? at + 4 + wide
                                    : number(t, b + 4 + wide, wide);
    if (!within(t, f.at, f.count * f.size))
        return damaged(t, "a field's values start at", f.at);
    int i = 0;
    while (i < FIELDS && tags[i] != tag)
        i++;
    if (i < FIELDS && is_whole_number(type))
        t->field[i] = f;
    return GP_OK;
}

/* Fields of the directory at `at`, if `keep`; *next is where the one after it
 * is, 0 at the end. */
static gp_status read_directory(struct tiff *t, uint64_t at, bool keep,
                                uint64_t *next)
{
    static const char where[] = "a directory at";
    const unsigned head = t->large ? 8 : 2, entry = t->large ? 20 : 12;
    const unsigned wide = t->large ? 8 : 4;
    uint8_t b[20];
    gp_status st = take(t, where, at, head, b);
    if (st)
        return st;
    const uint64_t entries = number(t, b, head);
    if (entries > 65535 || !within(t, at, head + entries * entry))
        return damaged(t, where, at);
    at += head;
    for (uint64_t i = 0; keep && i < entries; i++) {
        st = take(t, where, at + i * entry, entry, b);
        if (!st)
            st = keep_field(t, at + i * entry, b);
        if (st)
            return st;
    }
    *next = 0; // a last directory may end with the file
    if (keep || !within(t, at + entries * entry, wide))
        return GP_OK;
    st = take(t, where, at + entries * entry, wide, b);
    *next = number(t, b, wide);
    return st;
}

/* The first value of a field, `otherwise` without one. */
static gp_status value(const struct tiff *t, int field, uint64_t otherwise,
                       uint64_t *out)
{
    const struct field *f = &t->field[field];
    uint8_t b[8];
    *out = otherwise;
    if (!f->count)
        return GP_OK;
    const gp_status st = take(t, "a field at", f->at, f->size, b);
    if (!st)
        *out = number(t, b, f->size);
    return st;
}

// -- chunks -------------------------------------------------------------------

/* TIFF's numbers of deflate, and of a photometric. */
enum { ZIP = 8, OLD_ZIP = 32946, YCBCR = 6 };

/* Most bytes that a packed byte unpacks to, by TIFF's number. */
static uint64_t ratio_of(uint64_t compression)
{
    switch (compression) {
    case 1:
        return 1;
    case 5: // LZW: strings of 4096 codes, 12 bits each
        return 4096;
    case ZIP: // 258 bytes in 2 bits
    case OLD_ZIP:
        return 1100;
    case 32773: // PackBits: 128 bytes in 2
        return 128;
    default:
        return 0;
    }
}

static struct field either(const struct field *f, const struct field *other)
{
    return f->count ? *f : *other; // writers, and libtiff, take one for another
}

/* Whether all of it is to be unpacked: zlib streams in the order of their bits
 * whose rows are known, and not too many. */
static gp_status find_zip(const struct tiff *t, struct chunks *c,
                          uint64_t compression, uint64_t photometric)
{
    const uint64_t most = 32 * (uint64_t) t->max_pixels; // of four doubles
    uint64_t order, bytes;
    const gp_status st = value(t, BIT_ORDER, 1, &order);
    c->zip = (compression == ZIP || compression == OLD_ZIP) && order == 1 &&
             photometric != YCBCR && c->counts.count > 0 &&
             !__builtin_mul_overflow(c->rows, c->row_bytes, &bytes) &&
             !__builtin_mul_overflow(bytes, c->number, &bytes) &&
             bytes <= most;
    return st;
}

/* *judged is whether there is enough to go by. */
static gp_status find_chunks(const struct tiff *t, struct chunks *c,
                             bool *judged)
{
    gp_status st;
    uint64_t w, bits, compression, photometric, samples, planar, tile_w;
    *judged = false;
    GP_TRY(value(t, WIDTH, 0, &w));
    GP_TRY(value(t, HEIGHT, 0, &c->height));
    GP_TRY(value(t, BITS, 1, &bits));
    GP_TRY(value(t, COMPRESSION, 1, &compression));
    GP_TRY(value(t, PHOTOMETRIC, 0, &photometric));
    GP_TRY(value(t, SAMPLES, 1, &samples));
    GP_TRY(value(t, PLANAR, 1, &planar));
    GP_TRY(value(t, TILE_WIDTH, 0, &tile_w));
    GP_TRY(value(t, tile_w ? TILE_HEIGHT : STRIP_ROWS, c->height, &c->rows));
    const struct field *const f = t->field;
    c->name = tile_w ? "tile" : "strip";
    c->offsets = tile_w ? either(&f[TILE_OFFSETS], &f[STRIP_OFFSETS])
                        : either(&f[STRIP_OFFSETS], &f[TILE_OFFSETS]);
    c->counts = tile_w ? either(&f[TILE_COUNTS], &f[STRIP_COUNTS])
                       : either(&f[STRIP_COUNTS], &f[TILE_COUNTS]);
    const uint64_t most = UINT64_C(1) << 31; // no product of two overflows
    if (!w || !c->height || w >= most || c->height >= most || !c->rows ||
        tile_w >= most || !c->offsets.count || compression == 6 || bits > 64 ||
        !samples || samples > 65535)
        goto out; // old JPEG keeps its own tables
    if (c->rows >= most || (!tile_w && c->rows > c->height))
        c->rows = c->height;
    c->across = tile_w ? (w + tile_w - 1) / tile_w : 1;
    c->down = (c->height + c->rows - 1) / c->rows;
    c->ratio = ratio_of(compression);
    c->row_bytes = ((tile_w ? tile_w : w) * bits *
                    (planar == 2 ? 1 : samples) + 7) / 8;
    if (photometric == YCBCR) // which has fewer samples of colour
        c->ratio = c->ratio == 1 ? 0 : c->ratio;
    *judged = !__builtin_mul_overflow(c->across * c->down,
                                      planar == 2 ? samples : 1, &c->number);
    if (!*judged || c->number > c->offsets.count ||
        (c->counts.count && c->number > c->counts.count))
        st = damaged(t, c->name[0] == 't'
                            ? "a table of tiles that is too short, in a file"
                            : "a table of strips that is too short, in a file",
                     c->offsets.count);
    else
        st = find_zip(t, c, compression, photometric);
out:
    return st;
}

/* Bytes that a chunk unpacks to; strips at the bottom have fewer rows. */
static uint64_t unpacked(const struct chunks *c, uint64_t i)
{
    const uint64_t top = i % c->down * c->rows;
    uint64_t rows = c->rows, bytes;
    if (c->name[0] == 's' && c->height - top < rows)
        rows = c->height - top;
    return __builtin_mul_overflow(rows, c->row_bytes, &bytes) ? UINT64_MAX
                                                              : bytes;
}

static gp_status bad_chunk(const struct tiff *t, const struct chunks *c,
                           uint64_t i, const char *wrong, uint64_t at,
                           uint64_t bytes)
{
    return gp_fail(t->log, GP_ERR_DATA,
                   "%s: cut off or damaged (%s %" PRIu64 " %s: %" PRIu64
                   " bytes at %" PRIu64 " of %" PRIu64 "); copy or render the "
                   "file again", t->path, c->name, i, wrong, bytes, at,
                   t->s->size);
}

static gp_status check_chunk(const struct tiff *t, const struct chunks *c,
                             uint64_t i, uint64_t at, uint64_t bytes)
{
    const char *wrong = NULL;
    const bool counted = c->counts.count > 0;
    // libtiff trusts the size more than the count of a lone strip
    const bool lone = c->ratio == 1 && (c->number == 1 || !counted);
    const uint64_t need = c->ratio ? unpacked(c, i) : 0;
    if (at < 8 || (counted && !bytes && !lone))
        wrong = "has no data";
    else if (!within(t, at, lone ? need : bytes))
        wrong = "ends behind the end";
    else if (!lone && counted && need && (need - 1) / c->ratio >= bytes)
        wrong = "is too short for its rows";
    return wrong ? bad_chunk(t, c, i, wrong, at, bytes) : GP_OK;
}

/* Values of a table are read this many at once. */
enum { SOME = 512 };

static gp_status take_some(const struct tiff *t, const struct field *f,
                           uint64_t first, uint64_t n, uint64_t *to)
{
    uint8_t b[8 * SOME];
    if (!f->count) {
        memset(to, 0, n * sizeof *to);
        return GP_OK;
    }
    const gp_status st = take(t, "a table at", f->at + first * f->size,
                              (unsigned) n * f->size, b);
    for (uint64_t i = 0; !st && i < n; i++)
        to[i] = number(t, b + i * f->size, f->size);
    return st;
}

/* Unpacks `n` chunks from `first` on. Some writers fill up the last strip with
 * rows that it does not have. */
static gp_status check_zip(const struct tiff *t, const struct chunks *c,
                           uint64_t first, uint64_t n, const uint64_t *at,
                           const uint64_t *bytes)
{
    struct gp_zip zip[SOME];
    int i = 0;
    for (uint64_t k = 0; k < n; k++)
        zip[k] = (struct gp_zip) {at[k], bytes[k], unpacked(c, first + k),
                                  c->rows * c->row_bytes};
    const gp_status st = gp_whole_zip(t->s, zip, (int) n, &i);
    switch (st) {
    case GP_OK:
        return GP_OK;
    case GP_ERR_IO:
        return gp_fail(t->log, st, "%s: cannot be read (%s %" PRIu64 "); check "
                       "the disk", t->path, c->name, first + (uint64_t) i);
    case GP_ERR_DATA:
        return bad_chunk(t, c, first + (uint64_t) i, "does not unpack to its "
                         "rows", at[i], bytes[i]);
    default:
        return gp_fail(t->log, st, "%s: out of memory (%s %" PRIu64 "); close "
                       "other programs", t->path, c->name,
                       first + (uint64_t) i);
    }
}

static gp_status check_chunks(const struct tiff *t, const struct chunks *c)
{
    gp_status st = GP_OK;
    uint64_t at[SOME], bytes[SOME];
    for (uint64_t first = 0; !st && first < c->number; first += SOME) {
        const uint64_t left = c->number - first;
        const uint64_t n = left < SOME ? left : SOME;
        st = take_some(t, &c->offsets, first, n, at);
        if (!st)
            st = take_some(t, &c->counts, first, n, bytes);
        for (uint64_t i = 0; !st && i < n; i++)
            st = check_chunk(t, c, first + i, at[i], bytes[i]);
        if (!st && c->zip)
            st = check_zip(t, c, first, n, at, bytes);
    }
    return st;
}

gp_status gp_whole_tiff(const struct gp_log *log, const char *path,
                        const struct gp_stream *s, int part,
                        long long max_pixels)
{
    struct tiff t = {.log = log, .path = path, .s = s,
                     .max_pixels = max_pixels};
    struct chunks c = {0};
    bool judged = false;
    uint8_t b[16];
    gp_status st = take(&t, "its head at", 0, 8, b);
    if (st)
        return st;
    t.motorola = b[0] == 'M';
    t.large = number(&t, b + 2, 2) == 43;
    if (t.large)
        GP_TRY(take(&t, "its head at", 0, 16, b));
    uint64_t at = t.large ? number(&t, b + 8, 8) : number(&t, b + 4, 4);
    for (int i = 0; i < part; i++) { // as many as asked for: a loop ends
        GP_TRY(read_directory(&t, at, false, &at));
        if (!at)
            goto out;
    }
    GP_TRY(read_directory(&t, at, true, &at));
    GP_TRY(find_chunks(&t, &c, &judged));
    if (judged)
        st = check_chunks(&t, &c);
out:
    return st;
}
