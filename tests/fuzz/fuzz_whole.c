/* Bytes that say that they are a PNG, JPEG, TIFF or IFF: whether the file is
 * all there. A PNG's checksums are made right, or no input would get behind
 * them. */
#include "harness.h"
#include "io/whole.h"

#include <libdeflate.h>
#include <stdlib.h>
#include <string.h>

static uint32_t be32(const uint8_t *b)
{
    return (uint32_t) b[0] << 24 | (uint32_t) b[1] << 16 |
           (uint32_t) b[2] << 8 | b[3];
}

static void mend_checksums(uint8_t *b, size_t size)
{
    for (size_t at = 8; size - at >= 12;) {
        const size_t n = be32(b + at);
        if (n > size - at - 12)
            return;
        const uint32_t crc = libdeflate_crc32(0, b + at + 4, n + 4);
        for (int i = 0; i < 4; i++)
            b[at + 8 + n + (size_t) i] = (uint8_t) (crc >> (24 - 8 * i));
        at += n + 12;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    enum { PARTS = 2 };
    uint8_t *const copy = malloc(size + 1);
    if (!copy)
        return 0;
    if (size)
        memcpy(copy, data, size);
    if (size >= 8 && memcmp(copy, "\x89PNG", 4) == 0)
        mend_checksums(copy, size);
    const struct gp_stream s = {
        .fd = -1, .borrowed = true, .size = size, .data = copy,
    };
    fuzz_begin();
    for (int part = 0; part < PARTS; part++)
        fuzz_said(gp_whole_check(&fuzz_log, "input", &s, part, FUZZ_PIXELS));
    fuzz_end(FUZZ_FIXED);
    free(copy);
    return 0;
}
