// SPDX-License-Identifier: Apache-2.0
/* Integers in a file's bytes, in either byte order and at any alignment, and
 * floats and doubles as bits. */
#ifndef GP_CORE_BYTES_H
#define GP_CORE_BYTES_H

#include <stdint.h>
#include <string.h>

/* Little-endian: EXR. */
static inline uint32_t gp_le32(const uint8_t *p)
{
    return (uint32_t) p[0] | (uint32_t) p[1] << 8 | (uint32_t) p[2] << 16 |
           (uint32_t) p[3] << 24;
}

/* Big-endian: PNG. */
static inline uint32_t gp_be32(const uint8_t *p)
{
    return (uint32_t) p[0] << 24 | (uint32_t) p[1] << 16 |
           (uint32_t) p[2] << 8 | (uint32_t) p[3];
}

static inline uint32_t gp_bits_of(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static inline float gp_float_with_bits(uint32_t bits)
{
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline uint64_t gp_bits_of_double(double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static inline double gp_double_with_bits(uint64_t bits)
{
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

#endif
