/* The bytes of ZIP, ZIPS and RLE chunks, from and to planes: for libdeflate, which
 * OpenEXRCore has from 3.2 on, and in one pass, which no release has. */
#include "io/exr/exr_priv.h"

#include "core/cpu.h"
#include "core/half.h"

#include <libdeflate.h>
#include <string.h>

#if defined(__x86_64__) && defined(__GNUC__)
#define HAVE_X86 1
#include <immintrin.h>
#endif

// little-endian samples are read as they are; EXR has no other order
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "big-endian machines need byte swaps in io");

/* -- out ------------------------------------------------------------------ */

/* Splits `n` bytes (even) into those at even and at odd places, and turns
 * each into its difference to the one before, plus 128. */
GP_CLONES static void filter_bytes(const uint8_t *restrict in,
                                   uint8_t *restrict out, size_t n)
{
    const size_t half = n / 2;
    uint8_t *restrict even = out, *restrict odd = out + half;
    if (n == 0)
        return;
    even[0] = in[0]; // the very first byte has none before it
    odd[0] = (uint8_t) (in[1] - in[n - 2] + 128);
    for (size_t i = 1; i < half; i++) {
        even[i] = (uint8_t) (in[2 * i] - in[2 * i - 2] + 128);
        odd[i] = (uint8_t) (in[2 * i + 1] - in[2 * i - 1] + 128);
    }
}

size_t gp_exr_zip(struct libdeflate_compressor *c, const uint8_t *raw,
                  size_t n, uint8_t *scratch, uint8_t *out)
{
    if (n == 0)
        return 0;
    filter_bytes(raw, scratch, n);
    return libdeflate_zlib_compress(c, scratch, n, out, n - 1);
}

/* -- in ------------------------------------------------------------------- */

bool gp_unrle(const uint8_t *in, size_t in_size, uint8_t *out, size_t out_size)
{
    const uint8_t *const in_end = in + in_size;
    uint8_t *const out_end = out + out_size;
    while (in < in_end) {
        // NOLINTNEXTLINE(*-signed-char-misuse,cert-str34-c): below 0 is a copy
        int code = (int8_t) *in++;
        size_t count = (size_t) (code < 0 ? -code : code + 1);
        size_t taken = code < 0 ? count : 1;
        if (taken > (size_t) (in_end - in) || count > (size_t) (out_end - out))
            return false;
        if (code < 0)
            memcpy(out, in, count);
        else
            memset(out, *in, count);
        in += taken;
        out += count;
    }
    return out == out_end;
}

#ifdef HAVE_X86

/* Prefix sums of 16 bytes by shifted additions; the running total is kept
 * apart, so that one block waits for the one before by a single addition. */
static size_t undo_delta_blocks(uint8_t *v, size_t n, uint8_t *last)
{
    const __m128i bias = _mm_set1_epi8(-128);
    __m128i total = _mm_set1_epi8((char) *last);
    size_t i = 0;
    for (; i + 16 <= n; i += 16) {
        __m128i *at = (__m128i *) (v + i);
        __m128i d = _mm_add_epi8(_mm_loadu_si128(at), bias);
        d = _mm_add_epi8(d, _mm_slli_si128(d, 1));
        d = _mm_add_epi8(d, _mm_slli_si128(d, 2));
        d = _mm_add_epi8(d, _mm_slli_si128(d, 4));
        d = _mm_add_epi8(d, _mm_slli_si128(d, 8));
        __m128i sum = _mm_unpackhi_epi8(d, d);
        sum = _mm_shufflehi_epi16(sum, 0xff);
        sum = _mm_shuffle_epi32(sum, 0xff);
        _mm_storeu_si128(at, _mm_add_epi8(d, total));
        total = _mm_add_epi8(total, sum);
    }
    *last = (uint8_t) _mm_cvtsi128_si32(total);
    return i;
}

#else

static size_t undo_delta_blocks(uint8_t *v, size_t n, uint8_t *last)
{
    (void) v;
    (void) n;
    (void) last;
    return 0;
}

#endif

void gp_undo_delta(uint8_t *v, size_t n)
{
    uint8_t last = 128; // the first byte is stored without the bias
    for (size_t i = undo_delta_blocks(v, n, &last); i < n; i++) {
        last = (uint8_t) (last + v[i] - 128);
        v[i] = last;
    }
}

void gp_interleave(const uint8_t *even, const uint8_t *odd, void *out, size_t n)
{
    uint8_t *to = out;
    size_t i = 0;
#ifdef HAVE_X86
    for (; i + 16 <= n; i += 16) {
        __m128i e = _mm_loadu_si128((const __m128i *) (even + i));
        __m128i o = _mm_loadu_si128((const __m128i *) (odd + i));
        __m128i *at = (__m128i *) (to + 2 * i);
        _mm_storeu_si128(at, _mm_unpacklo_epi8(e, o));
        _mm_storeu_si128(at + 1, _mm_unpackhi_epi8(e, o));
    }
#endif
    for (; i < n; i++) {
        to[2 * i] = even[i];
        to[2 * i + 1] = odd[i];
    }
}

#ifdef HAVE_X86

GP_X86_AVX2 static size_t split_half_wide(const uint8_t *even,
    const uint8_t *odd, float *out, size_t n)
{
    size_t i = 0;
    for (; i + 16 <= n; i += 16) {
        __m128i e = _mm_loadu_si128((const __m128i *) (even + i));
        __m128i o = _mm_loadu_si128((const __m128i *) (odd + i));
        __m256 a = _mm256_cvtph_ps(_mm_unpacklo_epi8(e, o));
        __m256 b = _mm256_cvtph_ps(_mm_unpackhi_epi8(e, o));
        _mm256_storeu_ps(out + i, a);
        _mm256_storeu_ps(out + i + 8, b);
    }
    return i;
}

#endif

void gp_split_half_to_float(const uint8_t *even, const uint8_t *odd,
                            float *out, size_t n)
{
    enum { BLOCK = 512 };
    uint16_t half[BLOCK];
    size_t i = 0;
#ifdef HAVE_X86
    if (gp_cpu_has_avx2())
        i = split_half_wide(even, odd, out, n);
#endif
    for (; i < n; i += BLOCK) {
        size_t m = n - i < BLOCK ? n - i : BLOCK;
        gp_interleave(even + i, odd + i, half, m);
        gp_half_to_float(half, out + i, m);
    }
}
