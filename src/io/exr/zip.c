// SPDX-License-Identifier: Apache-2.0
/* The bytes of ZIP, ZIPS and RLE chunks: for libdeflate, which OpenEXRCore has
 * from 3.2 on. Then this file can go. */
#include "io/exr/exr_priv.h"

#include "core/cpu.h"

#include <libdeflate.h>
#include <string.h>

/* -- out ------------------------------------------------------------------ */

/* Splits `n` bytes and makes them differences, as exr_priv.h says. */
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
    filter_bytes(raw, scratch, n);
    const size_t size =
        n ? libdeflate_zlib_compress(c, scratch, n, out, n - 1) : 0;
    if (!size)
        memcpy(out, raw, n);
    return size ? size : n;
}

/* -- in ------------------------------------------------------------------- */

/* Expands EXR's run lengths to exactly `out_size` bytes, or returns false. */
static bool expand_runs(const uint8_t *in, size_t in_size, uint8_t *out,
                        size_t out_size)
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

/* Undoes filter_bytes(): the second half goes on from the first. */
static void undo_filter(const uint8_t *restrict in, uint8_t *restrict out,
                        size_t n)
{
    const size_t half = n / 2;
    uint8_t even = 128, odd = 128; // the first byte is stored without the bias
    for (size_t i = 0; i < half; i++)
        odd = (uint8_t) (odd + in[i] - 128);
    for (size_t i = 0; i < half; i++) {
        even = (uint8_t) (even + in[i] - 128);
        odd = (uint8_t) (odd + in[half + i] - 128);
        out[2 * i] = even;
        out[2 * i + 1] = odd;
    }
}

bool gp_exr_unzip(struct libdeflate_decompressor *d, bool rle,
                  const uint8_t *packed, size_t size, uint8_t *scratch,
                  uint8_t *out, size_t n)
{
    // without a place for the size, another one than n is a failure
    if (rle ? !expand_runs(packed, size, scratch, n)
            : libdeflate_zlib_decompress(d, packed, size, scratch, n, NULL))
        return false;
    undo_filter(scratch, out, n);
    return true;
}
