/* One zlib stream, packed on every core.
 *
 * The data is cut into pieces of equal size, whatever the number of threads,
 * and libdeflate packs each by itself. A piece loses the 32 KiB before it as
 * a dictionary, which libdeflate cannot take, and has code tables of its own:
 * at most 0.9 % of 74 real and rendered frames at 8 and 16 bits, where pieces
 * of 256 KiB lose up to 4 %. Of a picture that is flat, or whose rows repeat,
 * that is more: vertical stripes of noise would be several times as large. So
 * the loss is estimated, and over 1 % the picture is packed again in fewer
 * pieces, or in one, which is quick where so much repeats. The estimate sees no
 * rows that repeat every second row or more rarely, and no diagonals: noise
 * that does is several times as large. libdeflate ends every stream with a block
 * that is marked as the last. Its mark is cleared, and an empty stored block
 * fills the last byte up, so that the next piece begins on a whole one.
 * Source: RFC 1950, RFC 1951 section 3.2.3; zlib's examples/gzjoin.c. */
#include "io/io_priv.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "io/write.h"

#include <libdeflate.h>
#include <string.h>
#include <zlib.h>

enum {
    PIECE = 1 << 19,
    // of the loss where pieces meet, by what pictures of all kinds lose
    TABLES = 100,      // bytes for code tables
    RUN = 3,           // bytes that DEFLATE can repeat
    SHIFT = 48,        // bytes, whole pixels of any format
    AGAIN = 100,       // a loss over 1 / AGAIN is too much
    WINDOW = 1 << 15,
    LEVEL = 3,         // png.c has its time and size beside others
    HEAD = 2,          // bytes of the stream's header, before the first piece
    EMPTY = 5,         // at most, of the empty block after the other pieces
    CHECKSUM = 4,      // Adler-32, after the last piece
};

struct packer {
    struct libdeflate_compressor *c;
    uint8_t *packed; // room for any piece
};

/* Facts of a piece. */
struct piece {
    uint32_t adler;
    uint32_t above, aside; // bytes that count_repeated() finds
};

struct packing {
    const uint8_t *raw;
    size_t n, piece;         // bytes of all, and of a piece
    size_t stride;           // of a row
    size_t room;             // bytes that a packed piece takes at most
    struct packer *packer;   // of each thread
    struct piece *known;     // of each piece
    struct gp_zlib_stream *out;
    const struct gp_log *log;
};

/* Clears the mark of the last block of a deflate stream, and ends it on a whole
 * byte. Returns its new size, up to EMPTY more; 0 where it is damaged. */
static size_t unmark_last_block(uint8_t *data, size_t size)
{
    size_t begin, end; // bits
    if (!gp_deflate_last_block(data, size, &begin, &end))
        return 0;
    data[begin / 8] &= (uint8_t) ~(1u << begin % 8);
    // three bits of 0: not the last, stored; then no length, and its complement
    static const uint8_t empty[4] = {0, 0, 0xff, 0xff};
    const size_t whole = (end + 3 + 7) / 8;
    if (whole > size)
        data[size] = 0;
    memcpy(data + whole, empty, sizeof empty);
    return whole + sizeof empty;
}

static size_t piece_bytes(const struct packing *k, int i)
{
    const size_t at = (size_t) i * k->piece;
    return k->n - at < k->piece ? k->n - at : k->piece;
}

/* Counts bytes other than 0 in runs that are the same in both. */
static uint32_t count_same(const uint8_t *a, const uint8_t *b, size_t n)
{
    uint32_t count = 0;
    for (size_t i = 0, end; i < n; i = end + 1) {
        uint32_t run = 0;
        for (end = i; end < n && a[end] == b[end]; end++)
            run += a[end] != 0;
        count += end - i >= RUN ? run : 0;
    }
    return count;
}

/* Counts the bytes of a piece's first row that repeat the row above, which is
 * in the piece before, and those that repeat it moved aside: by chance, or
 * because the row repeats itself, for which no row above is needed. */
static void count_repeated(const struct packing *k, int i)
{
    const size_t n = piece_bytes(k, i), row = k->stride < n ? k->stride : n;
    const uint8_t *const at = k->raw + (size_t) i * k->piece;
    if (!i || row <= SHIFT || k->stride > WINDOW)
        return;
    k->known[i].above = count_same(at + SHIFT, at + SHIFT - k->stride,
                                   row - SHIFT);
    k->known[i].aside = count_same(at + SHIFT, at - k->stride, row - SHIFT);
}

static gp_status pack_piece(void *ctx, int i, int thread)
{
    const struct packing *const k = ctx;
    struct packer *const p = &k->packer[thread];
    const size_t n = piece_bytes(k, i);
    const uint8_t *const raw = k->raw + (size_t) i * k->piece;
    static const uint8_t header[HEAD] = {0x78, 0x5e}; // 32 KiB; fast
    const size_t head = i ? 0 : HEAD;
    uint8_t *const to = p->packed + head;
    struct gp_bytes *const out = &k->out->piece[i];
    k->known[i].adler = libdeflate_adler32(1, raw, n);
    count_repeated(k, i);
    size_t size = libdeflate_deflate_compress(p->c, raw, n, to,
                                              k->room - HEAD - EMPTY);
    if (size > 0 && i < k->out->pieces - 1)
        size = unmark_last_block(to, size);
    if (!size ||
        gp_alloc(NULL, "PNG piece", head + size + CHECKSUM, 1, &out->data))
        return GP_ERR_BUG;
    memcpy(p->packed, header, head);
    out->size = head + size;
    memcpy(out->data, p->packed, out->size);
    out->crc = libdeflate_crc32(0, out->data, out->size);
    return GP_OK;
}

static gp_status make_packers(struct packing *k, int n)
{
    gp_status st = gp_alloc_zero(k->log, "PNG compressors", (size_t) n,
                                 sizeof *k->packer, &k->packer);
    for (int i = 0; i < n && !st; i++) {
        struct packer *const p = &k->packer[i];
        p->c = libdeflate_alloc_compressor(LEVEL);
        st = p->c ? gp_alloc(k->log, "PNG piece", k->room, 1, &p->packed)
                  : gp_no_memory_bare(k->log, "PNG compressor");
    }
    return st;
}

static void free_packers(struct packing *k, int n)
{
    for (int i = 0; i < n && k->packer; i++) {
        libdeflate_free_compressor(k->packer[i].c);
        gp_free(k->packer[i].packed);
    }
    GP_FREE(k->packer);
}

/* Appends the checksum of all to the last piece, which has room for it. */
static void add_checksum(struct packing *k)
{
    struct gp_bytes *const last = k->out->piece + k->out->pieces - 1;
    uLong adler = 1;
    for (int i = 0; i < k->out->pieces; i++)
        adler = adler32_combine(adler, k->known[i].adler,
                                (z_off_t) piece_bytes(k, i));
    for (int i = 0; i < CHECKSUM; i++)
        last->data[last->size + (size_t) i] = (uint8_t) (adler >> (24 - 8 * i));
    last->crc = libdeflate_crc32(last->crc, last->data + last->size, CHECKSUM);
    last->size += CHECKSUM;
}

/* Finds how many pieces lose little of the packed size. Nearly all that repeats
 * above and not aside also repeats other rows above, in shorter runs, as under
 * dither: 8 times as much is lost at most. */
static int best_pieces(const struct packing *k, size_t size)
{
    const uint64_t meetings = (uint64_t) k->out->pieces - 1;
    uint64_t above = 0, aside = 0;
    for (int i = 1; i < k->out->pieces; i++) {
        above += k->known[i].above;
        aside += k->known[i].aside;
    }
    const uint64_t lost = meetings * TABLES + (above > 8 * aside ? 8 * above
                                               : above > aside ? above - aside
                                                               : 0);
    if (lost * AGAIN <= size)
        return k->out->pieces;
    return (int) (meetings * size / (2 * AGAIN * lost)) + 1;
}

/* Packs k->raw in pieces of `piece` bytes; `room` bytes are enough for one. */
static gp_status pack(struct packing *k, size_t piece, size_t room,
                      struct gp_zlib_stream *out)
{
    gp_status st;
    const int pieces = k->n ? (int) ((k->n - 1) / piece) + 1 : 1;
    const int threads = gp_threads() < pieces ? gp_threads() : pieces;
    *out = (struct gp_zlib_stream) {.pieces = pieces};
    k->piece = piece;
    k->room = HEAD + EMPTY + room;
    k->out = out;
    GP_TRY(make_packers(k, threads));
    GP_TRY(gp_alloc_zero(k->log, "PNG pieces", (size_t) pieces,
                         sizeof *out->piece, &out->piece));
    GP_TRY(gp_alloc_zero(k->log, "PNG pieces", (size_t) pieces,
                         sizeof *k->known, &k->known));
    st = gp_parallel(pieces, pack_piece, k, NULL);
    if (st)
        GP_TRY(gp_no_memory_bare(k->log, "PNG piece"));
    add_checksum(k);
out:
    free_packers(k, threads);
    return st;
}

static size_t packed_size(const struct gp_zlib_stream *s)
{
    size_t size = 0;
    for (int i = 0; i < s->pieces; i++)
        size += s->piece[i].size;
    return size;
}

gp_status gp_zlib_pack(const struct gp_log *log, const uint8_t *raw, size_t n,
                       size_t stride, struct gp_zlib_stream *out)
{
    struct packing k = {.raw = raw, .n = n, .stride = stride, .log = log};
    const size_t bound =
        libdeflate_deflate_compress_bound(NULL, n < PIECE ? n : PIECE);
    gp_status st = pack(&k, PIECE, bound, out);
    const size_t size = st ? 0 : packed_size(out);
    const int best = st ? out->pieces : best_pieces(&k, size);
    gp_free(k.known);
    if (!st && best < out->pieces) {
        gp_zlib_stream_free(out);
        k.known = NULL;
        st = pack(&k, (n - 1) / (size_t) best + 1, bound + 2 * size, out);
        gp_free(k.known);
    }
    if (st)
        gp_zlib_stream_free(out);
    return st;
}

void gp_zlib_stream_free(struct gp_zlib_stream *s)
{
    for (int i = 0; s->piece && i < s->pieces; i++)
        gp_free(s->piece[i].data);
    gp_free(s->piece);
    *s = (struct gp_zlib_stream) {0};
}

// -- memory of libdeflate -----------------------------------------------------

static void *take_memory(size_t bytes)
{
    void *block;
    return gp_alloc(NULL, "libdeflate", bytes, 1, &block) ? NULL : block;
}

void gp_write_keep_memory(void)
{
    libdeflate_set_memory_allocator(take_memory, gp_free);
}
