// SPDX-License-Identifier: Apache-2.0
/* Branch-free integer arithmetic, which the compiler turns into vectors. */
#include "core/half.h"

#include "core/bytes.h"
#include "core/cpu.h"

#include <stdbool.h>

enum {
    FLOAT_INF = 0x7f800000,
    FLOAT_QUIET = 0x00400000,
    FLOAT_65520 = 0x477ff000,  // first float that rounds past 65504
    FLOAT_65504 = 0x477fe000,
    HALF_INF = 0x7c00,
};

/* Half's exponent bias is 15, float's 127; denormals are made normal by
 * subtracting 2^-14 from (1 + mantissa) * 2^-14. */
static inline float to_float(uint16_t half)
{
    uint32_t body = (uint32_t) (half & 0x7fff) << 13;
    uint32_t exponent = body & 0x0f800000;
    uint32_t normal = body + ((127u - 15u) << 23);
    uint32_t special = body | FLOAT_INF;
    special |= body & 0x007fe000 ? FLOAT_QUIET : 0;
    uint32_t tiny = gp_bits_of(gp_float_with_bits(body + (113u << 23)) -
                               gp_float_with_bits(113u << 23));
    uint32_t u = exponent == 0 ? tiny
                 : exponent == 0x0f800000 ? special : normal;
    return gp_float_with_bits(u | (uint32_t) (half & 0x8000) << 16);
}

/* Nearest even; overflow gives Inf. Denormals: adding 0.5 to a value below
 * 2^-14 leaves its nearest multiple of 2^-24 in the low bits. */
static inline uint16_t to_half(float f)
{
    uint32_t u = gp_bits_of(f);
    uint32_t body = u & 0x7fffffff;
    uint32_t odd = body >> 13 & 1;
    uint32_t normal = (body - ((127u - 15u) << 23) + 0xfff + odd) >> 13;
    uint32_t tiny = gp_bits_of(gp_float_with_bits(body) + 0.5f) -
                    gp_bits_of(0.5f);
    uint32_t nan = HALF_INF | 0x200 | (body >> 13 & 0x3ff);
    uint32_t h = body < 113u << 23 ? tiny : normal;
    h = body >= FLOAT_65520 ? HALF_INF : h;
    h = body > FLOAT_INF ? nan : h;
    return (uint16_t) (h | (u >> 16 & 0x8000));
}

GP_CLONES void gp_half_to_float(const uint16_t *in, float *out, size_t n)
{
    for (size_t i = 0; i < n; i++)
        out[i] = to_float(in[i]);
}

GP_CLONES size_t gp_float_to_half(const float *in, uint16_t *out, size_t n)
{
    size_t clamped = 0;
    for (size_t i = 0; i < n; i++) {
        const uint32_t u = gp_bits_of(in[i]), body = u & 0x7fffffff;
        const bool over = body >= FLOAT_65520 && body < FLOAT_INF;
        out[i] = to_half(over ? gp_float_with_bits((u & 0x80000000) |
                                                   FLOAT_65504) : in[i]);
        clamped += over;
    }
    return clamped;
}

float gp_half_nearest(float v)
{
    return to_float(to_half(v));
}
