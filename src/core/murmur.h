// SPDX-License-Identifier: Apache-2.0
/* A hash of bytes. */
#ifndef GP_CORE_MURMUR_H
#define GP_CORE_MURMUR_H

#include <stddef.h>
#include <stdint.h>

static inline uint32_t gp_rotate(uint32_t v, int bits)
{
    return v << bits | v >> (32 - bits);
}

/* Returns MurmurHash3_x86_32 of n bytes. Source: Appleby, MurmurHash3.cpp, in the
 * public domain. */
static inline uint32_t gp_murmur3(const void *bytes, size_t n, uint32_t seed)
{
    const uint8_t *const from = bytes;
    uint32_t h = seed;
    for (size_t i = 0; i < n; i += 4) {
        uint32_t k = 0;
        for (size_t j = i; j < i + 4 && j < n; j++)
            k |= (uint32_t) from[j] << 8 * (j - i);
        h ^= gp_rotate(k * 0xcc9e2d51u, 15) * 0x1b873593u;
        if (n - i >= 4) // a whole block
            h = gp_rotate(h, 13) * 5 + 0xe6546b64u;
    }
    h ^= (uint32_t) n;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

#endif
