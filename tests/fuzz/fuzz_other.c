// SPDX-License-Identifier: Apache-2.0
/* Files that the helper program reads: as they are, cut off, and with bytes
 * changed. Each is one line, or a picture that is the same when it is read
 * again; a file that was cut is one line, or the whole file's picture. The
 * fuzzer does not see into the helper, so the changes are made here. */
#include "core/bridge.h"
#include "io/frame.h"
#include "harness.h"
#include "io/io_priv.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CUTS = 4, CHANGES = 8 };

static void broken(const char *promise, size_t size, int variant)
{
    fprintf(stderr, "broken promise: %s (%zu bytes, variant %d)\n", promise,
            size, variant);
    abort();
}

static uint64_t mix(uint64_t hash, const void *p, size_t n)
{
    const uint8_t *const b = p;
    for (size_t i = 0; i < n; i++) // FNV-1a
        hash = (hash ^ b[i]) * 0x100000001b3u;
    return hash;
}

/* A number of the picture; 0: it was refused. */
static uint64_t read_picture(const uint8_t *data, size_t size, int variant)
{
    const struct gp_read_params p = {.max_pixels = FUZZ_PIXELS};
    struct gp_stream s = gp_stream_of(data, size);
    struct gp_frame f = {0};
    uint64_t hash = 0xcbf29ce484222325u;
    fuzz_begin();
    const gp_status st = fuzz_line(gp_read_stream(&fuzz_log, &p, "input", &s,
                                                  &f));
    if (!st) {
        const size_t bytes = gp_frame_pixels(&f) * sizeof(float);
        hash = mix(hash, &f.data, sizeof f.data);
        for (int c = 0; c < 3; c++) {
            fuzz_touch(f.rgb.c[c], bytes);
            hash = mix(hash, f.rgb.c[c], bytes);
        }
        gp_frame_free(&f);
    } else if (st != GP_ERR_DATA) {
        broken("a damaged file is status 4", size, variant);
    }
    fuzz_end(FUZZ_FIXED);
    return st ? 0 : hash | 1;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char program[PATH_MAX];
    if (!gp_bridge_find("glarepp-oiio", program, sizeof program))
        return 0; // built without OpenImageIO
    uint8_t *const copy = malloc(size + !size);
    uint64_t seed = mix(1, data, size);
    if (!copy)
        abort();
    setenv("GLAREPP_HELPER_SECONDS", "10", 0);
    // a Targa's gamma is in a footer, and nothing says that there is one
    const char *const format = gp_format_name(data, size);
    const bool footer = format && strcmp(format, "Targa") == 0;
    const uint64_t whole = read_picture(data, size, 0);
    if (whole != read_picture(data, size, 0))
        broken("a file is the same picture when it is read again", size, 0);
    for (int i = 1; i <= CUTS && size > 1; i++) {
        seed = mix(seed, &i, sizeof i);
        const size_t left = i == 1 ? size - 1 : 1 + seed % (size - 1);
        const uint64_t got = read_picture(data, left, i);
        if (got && got != whole && !footer)
            broken("a file that was cut is no other picture", left, i);
    }
    for (int i = CUTS + 1; i <= CUTS + CHANGES && size; i++) {
        memcpy(copy, data, size);
        for (int k = 0; k < 1 + i % 3; k++) {
            seed = mix(seed, &i, sizeof i);
            // half of them in the header
            const size_t most = k % 2 && size > 64 ? 64 : size;
            copy[seed % most] ^= (uint8_t) (1 + (seed >> 32) % 255);
        }
        const uint64_t got = read_picture(copy, size, i);
        if (got != read_picture(copy, size, i))
            broken("a file is the same picture when it is read again", size,
                   i);
    }
    free(copy);
    return 0;
}
