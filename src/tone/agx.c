/* AgX, Troy Sobotka's display transform (github.com/sobotka/AgX), in the
 * form of Benjamin Wrensch's Minimal AgX Implementation, default look
 * (iolite-engine.com/blog_posts/minimal_agx_implementation, 2023):
 *
 *   inset matrix, log2 between two exposures, a polynomial for the contrast
 *   curve, outset matrix, and the 2.2 power of the display it was made for.
 *
 * The polynomial is the 6th-order one, which rises everywhere; the 7th-order
 * one falls near black. Its end is 0.99858, so that the brightest grey is
 * 0.9969 of the display's white.
 */
#include "tone/agx.h"

#include "core/cpu.h"

#include <stdint.h>
#include <string.h>

/* Without this GCC keeps a branch wherever an unused division might raise an
 * exception flag, and vectorises nothing. Values are the same. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-trapping-math")
#endif

static const float inset[9] = {
    0.842479062253094f,  0.0784335999999992f, 0.0792237451477643f,
    0.0423282422610123f, 0.878468636469772f,  0.0791661274605434f,
    0.0423756549057051f, 0.0784336f,          0.879142973793104f,
};
static const float outset[9] = {
    1.19687900512017f,    -0.0980208811401368f, -0.0990297440797205f,
    -0.0528968517574562f, 1.15190312990417f,    -0.0989611768448433f,
    -0.0529716355144438f, -0.0980434501171241f, 1.15107367264116f,
};

/* Both clones of the loop must have their own copy. */
#define INLINE static inline __attribute__((always_inline))

#define EV_MIN (-12.47393f)     // 0.18 * 2^-10
#define EV_MAX 4.026069f        // 0.18 * 2^6.5
#define LIGHT_MIN 1.7578e-4f    // a little under 2^EV_MIN
#define LIGHT_MAX 1e15f         // sums of it stay finite

INLINE float clamp(float x, float lo, float hi)
{
    x = x > lo ? x : lo; // NaN becomes lo
    return x < hi ? x : hi;
}

/* The polynomials here are written for short chains of dependence.
 *
 * log2 of a positive normal x to 1e-7: with x = 2^e m, m in [sqrt(1/2),
 * sqrt(2)), and s = (m - 1) / (m + 1), log2 m = 2 / ln 2 * atanh s. */
INLINE float log2_of(float x)
{
    const int32_t half = 0x3f3504f3; // sqrt(1/2)
    int32_t bits;
    float m;
    memcpy(&bits, &x, sizeof bits);
    int32_t e = (bits - half) >> 23;
    bits -= e * (1 << 23);
    memcpy(&m, &bits, sizeof m);
    float s = (m - 1.0f) / (m + 1.0f), z = s * s, z2 = z * z;
    float series = (1.0f + z * (1.0f / 3)) +
                   z2 * ((1.0f / 5 + z * (1.0f / 7)) + z2 * (1.0f / 9));
    return (float) e + s * 2.885390082f * series;
}

/* 2^x for -100 < x < 100 to 1e-7, Taylor's series around the nearest integer */
INLINE float exp2_of(float x)
{
    const float round = 12582912.0f; // 1.5 * 2^23: adding it drops fractions
    float whole = (x + round) - round;
    float t = (x - whole) * 0.6931471806f, t2 = t * t;
    float series = (1.0f + t) + t2 * (1.0f / 2 + t * (1.0f / 6)) +
                   t2 * t2 * ((1.0f / 24 + t * (1.0f / 120)) +
                              t2 * (1.0f / 720 + t * (1.0f / 5040)));
    int32_t bits = ((int32_t) whole + 127) * (1 << 23);
    float power;
    memcpy(&power, &bits, sizeof power);
    return power * series;
}

/* x^2.2 for x in [0,1], as x^2 times its fifth root, so that the logarithm's
 * error counts a fifth. */
INLINE float power22(float x)
{
    return x * x * exp2_of(0.2f * log2_of(x > 1e-30f ? x : 1e-30f));
}

INLINE float row(const float m[3], float r, float g, float b)
{
    return m[0] * r + m[1] * g + m[2] * b;
}

/* The published polynomial in x in [0,1] is
 *   15.5 x^6 - 40.14 x^5 + 31.96 x^4 - 6.868 x^3 + 0.4298 x^2 + 0.1191 x
 *   - 0.00232
 * whose large terms cancel; in u = x - 1/2 they do not, and floats give 1e-7
 * instead of 3e-6. Taylor's coefficients at 1/2: */
#define P6 15.5
#define P5 (-40.14 + 15.5 * 6 / 2)
#define P4 (31.96 - 40.14 * 5 / 2 + 15.5 * 15 / 4)
#define P3 (-6.868 + 31.96 * 4 / 2 - 40.14 * 10 / 4 + 15.5 * 20 / 8)
#define P2 (0.4298 - 6.868 * 3 / 2 + 31.96 * 6 / 4 - 40.14 * 10 / 8 +         \
            15.5 * 15 / 16)
#define P1 (0.1191 + 0.4298 * 2 / 2 - 6.868 * 3 / 4 + 31.96 * 4 / 8 -         \
            40.14 * 5 / 16 + 15.5 * 6 / 32)
#define P0 (-0.00232 + 0.1191 / 2 + 0.4298 / 4 - 6.868 / 8 + 31.96 / 16 -     \
            40.14 / 32 + 15.5 / 64)

INLINE float contrast(float light)
{
    float ev = log2_of(clamp(light, LIGHT_MIN, LIGHT_MAX));
    float u = (ev - 0.5f * (EV_MIN + EV_MAX)) * (1.0f / (EV_MAX - EV_MIN));
    u = clamp(u, -0.5f, 0.5f);
    float u2 = u * u;
    return ((float) P0 + (float) P1 * u) + ((float) P2 + (float) P3 * u) * u2 +
           ((float) P4 + (float) P5 * u + (float) P6 * u2) * (u2 * u2);
}

GP_CLONES void gp_tone_agx(float *restrict r, float *restrict g,
                           float *restrict b, size_t n, float white)
{
    (void) white;
    for (size_t i = 0; i < n; i++) {
        float r0 = clamp(r[i], -LIGHT_MAX, LIGHT_MAX);
        float g0 = clamp(g[i], -LIGHT_MAX, LIGHT_MAX);
        float b0 = clamp(b[i], -LIGHT_MAX, LIGHT_MAX);
        float r1 = contrast(row(inset, r0, g0, b0));
        float g1 = contrast(row(inset + 3, r0, g0, b0));
        float b1 = contrast(row(inset + 6, r0, g0, b0));
        r[i] = power22(clamp(row(outset, r1, g1, b1), 0.0f, 1.0f));
        g[i] = power22(clamp(row(outset + 3, r1, g1, b1), 0.0f, 1.0f));
        b[i] = power22(clamp(row(outset + 6, r1, g1, b1), 0.0f, 1.0f));
    }
}
