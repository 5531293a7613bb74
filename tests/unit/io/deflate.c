/* The last block of deflate streams, against zlib's inflate(). */
#include "unit.h"

#include "io/io_priv.h"

#include <libdeflate.h>
#include <zlib.h>

enum { MOST = 700000, ROOM = MOST + MOST / 8 + 1000 };

static uint32_t noise(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Bytes that need stored blocks, codes of one symbol, long codes, matches of
 * every length, and codes that change. */
static void fill(int kind, uint8_t *raw, size_t n)
{
    uint32_t seed = 7;
    for (size_t i = 0; i < n; i++) {
        const uint32_t r = noise(&seed);
        raw[i] = kind == 0   ? 0
                 : kind == 1 ? (uint8_t) r
                 : kind == 2 ? (uint8_t) __builtin_ctz(r | 1u << 20)
                 : kind == 3 ? (uint8_t) (i / 20000 % 2 ? r : i * i >> 9)
                 : i > 300 && r % 4 == 0 ? raw[i - 1 - r / 4 % 300]
                                         : (uint8_t) (i * i >> 9);
        const size_t copy = 3 + noise(&seed) % 256;
        if (kind == 4 && r % 64 == 0 && i > 40000 && i + copy < n) {
            memmove(raw + i, raw + i - 259 - r / 64 % 32000, copy);
            i += copy - 1;
        }
    }
}

static void find_by_zlib(const uint8_t *data, size_t n, size_t *begin,
                         size_t *end)
{
    static uint8_t back[MOST + 300];
    z_stream z = {0};
    bool last = false;
    assert_int_equal(inflateInit2(&z, -15), Z_OK);
    z.next_in = (uint8_t *) (uintptr_t) data;
    z.avail_in = (uInt) n;
    z.next_out = back;
    z.avail_out = sizeof back;
    for (*end = 0; !last; last = z.data_type & 64) {
        *begin = *end;
        assert_int_equal(inflate(&z, Z_BLOCK), Z_OK);
        *end = 8 * (size_t) z.total_in - (size_t) (z.data_type & 7);
    }
    inflateEnd(&z);
}

static void check(const uint8_t *data, size_t n)
{
    size_t begin = 0, end = 0, want_begin, want_end;
    // a copy of its own size: a sanitizer sees a byte read after it
    uint8_t *const copy = malloc(n);
    memcpy(copy, data, n);
    find_by_zlib(data, n, &want_begin, &want_end);
    assert_true(gp_deflate_last_block(copy, n, &begin, &end));
    assert_int_equal(begin, want_begin);
    assert_int_equal(end, want_end);
    // (the end of a last block may be found without its symbols)
    if (want_begin)
        assert_false(gp_deflate_last_block(copy, want_begin / 8, &begin, &end));
    free(copy);
}

static void last_block_is_found(void **state)
{
    static const size_t size[] = {0, 1, 300, 4999, 65536, 262144, MOST};
    static uint8_t raw[MOST], packed[ROOM];
    static const int levels[] = {0, 1, 3, 6, 9};
    static const int strategy[] = {Z_DEFAULT_STRATEGY, Z_FILTERED,
                                   Z_HUFFMAN_ONLY, Z_RLE, Z_FIXED};
    for (int kind = 0; kind < 5; kind++) {
        fill(kind, raw, MOST);
        for (size_t i = 0; i < COUNT(size) * COUNT(levels); i++) {
            const size_t n = size[i / COUNT(levels)], k = i % COUNT(levels);
            struct libdeflate_compressor *const c =
                libdeflate_alloc_compressor(levels[k]);
            check(packed, libdeflate_deflate_compress(c, raw, n, packed, ROOM));
            libdeflate_free_compressor(c);
            z_stream z = {.next_in = raw, .avail_in = (uInt) n,
                          .next_out = packed, .avail_out = ROOM};
            assert_int_equal(deflateInit2(&z, 4, Z_DEFLATED, -15, 1,
                                          strategy[k]), Z_OK);
            assert_int_equal(deflate(&z, Z_FINISH), Z_STREAM_END);
            check(packed, z.total_out);
            deflateEnd(&z);
        }
    }
}

/* Random bytes and streams with some changed: each ends, and within its
 * bytes; a reserved kind of block is refused. */
static void damage_is_harmless(void **state)
{
    static uint8_t raw[20000], packed[2 * sizeof raw];
    struct libdeflate_compressor *const c = libdeflate_alloc_compressor(6);
    uint32_t seed = 1;
    int refused = 0;
    fill(4, raw, sizeof raw);
    const size_t whole = libdeflate_deflate_compress(c, raw, sizeof raw, packed,
                                                     sizeof packed);
    for (int i = 0; i < 4000; i++) {
        const size_t n = i % 2 ? whole : 1 + noise(&seed) % 400;
        size_t begin = 0, end = 0;
        uint8_t *const data = malloc(n);
        for (size_t k = 0; k < n; k++)
            data[k] = i % 2 ? packed[k] : (uint8_t) noise(&seed);
        for (int k = 0; k < 4; k++)
            data[noise(&seed) % (k ? n : 1 + n / 50)] = (uint8_t) noise(&seed);
        if (gp_deflate_last_block(data, n, &begin, &end))
            assert_true(begin < end && end <= 8 * n);
        else
            refused++;
        free(data);
    }
    assert_in_range(refused, 2000, 3990);
    static const uint8_t reserved[] = {7, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    size_t begin, end;
    assert_false(gp_deflate_last_block(reserved, sizeof reserved, &begin, &end));
    assert_false(gp_deflate_last_block(reserved, 0, &begin, &end));
    libdeflate_free_compressor(c);
}

SUITE_OF(deflate, NULL, NULL, last_block_is_found, damage_is_harmless)
