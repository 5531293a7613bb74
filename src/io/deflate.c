/* One zlib stream, packed on every core.
 *
 * The data is cut into pieces of equal size, whatever the number of threads,
 * and libdeflate packs each by itself. A piece loses the 32 KiB before it as
 * a dictionary, which libdeflate cannot take, and has code tables of its own:
 * at most 0.9 % of 74 real and rendered frames at 8 and 16 bits, where pieces
 * of 256 KiB lose up to 4 %. Some 100 bytes a piece are much of a picture
 * that is mostly flat: it is packed again in larger pieces, which takes
 * little time there. libdeflate ends every stream with a block that is marked
 * as the last. Its mark is cleared, and an empty stored block fills the last
 * byte up, so that the next piece begins on a whole one.
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
    FLAT_PIECE = 1 << 22,
    FLAT = 16,         // data that shrinks to less than 1 / FLAT is flat
    LEVEL = 3,         // png.c has its time and size beside others
    HEAD = 2,          // bytes of the stream's header, before the first piece
    EMPTY = 5,         // at most, of the empty block after the other pieces
    CHECKSUM = 4,      // Adler-32, after the last piece
};

struct packer {
    struct libdeflate_compressor *c;
    uint8_t *packed; // room for any piece
};

struct packing {
    const uint8_t *raw;
    size_t n, piece;         // bytes of all, and of a piece
    size_t room;             // bytes that a packed piece takes at most
    struct packer *packer;   // of each thread
    uint32_t *adler;         // of each piece
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
    k->adler[i] = libdeflate_adler32(1, raw, n);
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
    gp_free(k->packer);
}

/* Appends the checksum of all to the last piece, which has room for it. */
static void add_checksum(struct packing *k)
{
    struct gp_bytes *const last = k->out->piece + k->out->pieces - 1;
    uLong adler = 1;
    for (int i = 0; i < k->out->pieces; i++)
        adler = adler32_combine(adler, k->adler[i],
                                (z_off_t) piece_bytes(k, i));
    for (int i = 0; i < CHECKSUM; i++)
        last->data[last->size + (size_t) i] = (uint8_t) (adler >> (24 - 8 * i));
    last->crc = libdeflate_crc32(last->crc, last->data + last->size, CHECKSUM);
    last->size += CHECKSUM;
}

/* Packs in pieces of `piece` bytes. */
static gp_status pack(const struct gp_log *log, const uint8_t *raw, size_t n,
                      size_t piece, struct gp_zlib_stream *out)
{
    gp_status st;
    struct packing k = {.raw = raw, .n = n, .piece = piece, .out = out,
                        .log = log};
    const int pieces = n ? (int) ((n - 1) / piece) + 1 : 1;
    const int threads = gp_threads() < pieces ? gp_threads() : pieces;
    *out = (struct gp_zlib_stream) {.pieces = pieces};
    k.room = HEAD + EMPTY + libdeflate_deflate_compress_bound(
                                NULL, n < piece ? n : piece);
    GP_TRY(make_packers(&k, threads));
    GP_TRY(gp_alloc_zero(log, "PNG pieces", (size_t) pieces,
                         sizeof *out->piece, &out->piece));
    GP_TRY(gp_alloc(log, "PNG checksums", (size_t) pieces, sizeof *k.adler,
                    &k.adler));
    st = gp_parallel(pieces, pack_piece, &k, NULL);
    if (st)
        GP_TRY(gp_no_memory_bare(log, "PNG piece"));
    add_checksum(&k);
out:
    free_packers(&k, threads);
    gp_free(k.adler);
    if (st)
        gp_zlib_stream_free(out);
    return st;
}

gp_status gp_zlib_pack(const struct gp_log *log, const uint8_t *raw, size_t n,
                       struct gp_zlib_stream *out)
{
    const gp_status st = pack(log, raw, n, PIECE, out);
    size_t size = 0;
    if (st)
        return st;
    for (int i = 0; i < out->pieces; i++)
        size += out->piece[i].size;
    if (out->pieces == 1 || size >= n / FLAT)
        return GP_OK;
    gp_zlib_stream_free(out);
    return pack(log, raw, n, FLAT_PIECE, out);
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
