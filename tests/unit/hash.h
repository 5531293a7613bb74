// SPDX-License-Identifier: Apache-2.0
/* A hash of bytes, for tests that two runs make the same ones. */
#ifndef GP_TESTS_HASH_H
#define GP_TESTS_HASH_H

#include "core/image.h"

#include <stdint.h>

#define HASH_NONE UINT64_C(14695981039346656037) // of no bytes

/* FNV-1a, on from `hash`. */
static inline uint64_t hash_more(uint64_t hash, const void *bytes, size_t n)
{
    const unsigned char *const b = bytes;
    for (size_t i = 0; i < n; i++)
        hash = (hash ^ b[i]) * UINT64_C(1099511628211);
    return hash;
}

/* Of three planes of `samples` each. */
static inline uint64_t hash_layer(const struct gp_planes *layer, size_t samples)
{
    uint64_t hash = HASH_NONE;
    for (int c = 0; c < 3; c++)
        hash = hash_more(hash, layer->c[c], samples * sizeof(float));
    return hash;
}

#endif
