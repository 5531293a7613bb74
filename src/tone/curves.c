// SPDX-License-Identifier: Apache-2.0
/* The operators, each a few lines of arithmetic without branches, so
 * that compilers vectorise them. All clamp their input first, where NaN becomes
 * the lower end. */
#include "tone/tone.h"

#include "core/cpu.h"
#include "core/minmax.h"

#include <float.h>
#include <stdint.h>
#include <string.h>

/* Without this GCC keeps a branch wherever an unused division might raise an
 * exception flag, and vectorises nothing. Values are the same. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-trapping-math")
#endif

/* Both clones of a loop must have their own copy. */
#define INLINE static inline __attribute__((always_inline))

/* Negative light is none: a colour outside BT.709 loses that primary. */
static inline float positive(float x)
{
    x = x > 0.0f ? x : 0.0f;
    return gp_minf(x, GP_LIGHT_MAX);
}

static inline float luminance(float r, float g, float b)
{
    return 0.2126f * r + 0.7152f * g + 0.0722f * b; // BT.709
}

// -- Reinhard ----------------------------------------------------------------

/* Reinhard et al., Photographic Tone Reproduction for Digital Images, SIGGRAPH
 * 2002. */

/* A saturated colour of displayable luminance y may need more of a primary
 * than the display has. It then moves towards the grey of its own luminance
 * until it fits, which keeps luminance and hue, and gives up saturation:
 *   y + (c - y) (1 - y) / (top - y)  =  1 - (top - c) (1 - y) / (top - y)
 * `rest` is 1 - y, from the curve's equation, and top - y is made of
 * differences: neither cancels. */
INLINE void fit(float r0, float g0, float b0, float rest, float *r, float *g,
                float *b)
{
    float top = gp_maxf(r0, gp_maxf(g0, b0));
    float gap = luminance(top - r0, top - g0, top - b0);
    float by = rest / gp_maxf(gap, 1e-30f); // grey has no gap, and needs none
    float r1 = gp_maxf(1.0f - (top - r0) * by, 0.0f);
    float g1 = gp_maxf(1.0f - (top - g0) * by, 0.0f);
    float b1 = gp_maxf(1.0f - (top - b0) * by, 0.0f);
    *r = gp_minf(top > 1.0f ? r1 : r0, 1.0f);
    *g = gp_minf(top > 1.0f ? g1 : g0, 1.0f);
    *b = gp_minf(top > 1.0f ? b1 : b0, 1.0f);
}

/* Eq. 3: L_d = L / (1 + L); the colour is scaled by L_d / L. */
GP_CLONES static void reinhard(float *restrict r, float *restrict g,
                               float *restrict b, size_t n, float white)
{
    (void) white;
    for (size_t i = 0; i < n; i++) {
        float r0 = positive(r[i]), g0 = positive(g[i]), b0 = positive(b[i]);
        float rest = 1.0f / (1.0f + luminance(r0, g0, b0)); // 1 - L_d
        r0 *= rest;
        g0 *= rest;
        b0 *= rest;
        fit(r0, g0, b0, rest, &r[i], &g[i], &b[i]);
    }
}

/* Eq. 4: L_d = L (1 + L / L_white^2) / (1 + L), which is 1 at L_white;
 * 1 - L_d = (1 - (L / L_white)^2) / (1 + L). From L_white on this is held at
 * 0, and fit() gives white. It may make 14 of an error in 1 - L / L_white
 * (1 / 0.0722), which therefore comes from the difference, exact near white.
 * c / L_white is bounded beside it, as its product with L / L_white must be a
 * number however small L_white is. */
GP_CLONES static void reinhard_extended(float *restrict r, float *restrict g,
    float *restrict b, size_t n, float white)
{
    white = gp_maxf(white, FLT_MIN);
    const float per_white = 1.0f / white;
    for (size_t i = 0; i < n; i++) {
        float r0 = positive(r[i]), g0 = positive(g[i]), b0 = positive(b[i]);
        float y = luminance(r0, g0, b0), ratio = gp_minf(y * per_white, 1.0f);
        float open = 1.0f / (1.0f + y);
        float under = gp_maxf((white - y) * per_white, 0.0f); // 1 - ratio
        float rest = under * (1.0f + ratio) * open;
        r0 = (r0 + ratio * gp_minf(r0 * per_white, GP_LIGHT_MAX)) * open;
        g0 = (g0 + ratio * gp_minf(g0 * per_white, GP_LIGHT_MAX)) * open;
        b0 = (b0 + ratio * gp_minf(b0 * per_white, GP_LIGHT_MAX)) * open;
        fit(r0, g0, b0, rest, &r[i], &g[i], &b[i]);
    }
}

// -- ACES --------------------------------------------------------------------

/* Stephen Hill, ACESFitted, in MJP and Neubelt, Baking Lab, ACES.hlsl, 2016.
 *
 * BT.709 to the rendering transform's primaries, with its saturation. */
static const float aces_in[9] = {
    0.59719f, 0.35458f, 0.04823f,
    0.07600f, 0.90834f, 0.01566f,
    0.02840f, 0.13383f, 0.83777f,
};
/* From there to BT.709, with the output transform's saturation. */
static const float aces_out[9] = {
    1.60475f,  -0.53108f, -0.07367f,
    -0.10208f, 1.10813f,  -0.00605f,
    -0.00327f, -0.07276f, 1.07602f,
};

INLINE float row(const float m[3], float r, float g, float b)
{
    return m[0] * r + m[1] * g + m[2] * b;
}

static inline float aces_fit(float v)
{
    return (v * (v + 0.0245786f) - 0.000090537f) /
           (v * (0.983729f * v + 0.4329510f) + 0.238081f);
}

/* Colours outside BT.709 pass into the wider primaries as they are. */
GP_CLONES static void aces(float *restrict r, float *restrict g,
                           float *restrict b, size_t n, float white)
{
    (void) white;
    for (size_t i = 0; i < n; i++) {
        float r0 = gp_minf(gp_maxf(r[i], -GP_LIGHT_MAX), GP_LIGHT_MAX);
        float g0 = gp_minf(gp_maxf(g[i], -GP_LIGHT_MAX), GP_LIGHT_MAX);
        float b0 = gp_minf(gp_maxf(b[i], -GP_LIGHT_MAX), GP_LIGHT_MAX);
        float r1 = aces_fit(positive(row(aces_in, r0, g0, b0)));
        float g1 = aces_fit(positive(row(aces_in + 3, r0, g0, b0)));
        float b1 = aces_fit(positive(row(aces_in + 6, r0, g0, b0)));
        r[i] = gp_minf(positive(row(aces_out, r1, g1, b1)), 1.0f);
        g[i] = gp_minf(positive(row(aces_out + 3, r1, g1, b1)), 1.0f);
        b[i] = gp_minf(positive(row(aces_out + 6, r1, g1, b1)), 1.0f);
    }
}

/* John Hable, Filmic Tonemapping Operators, filmicworlds.com, 2010:
 * ((x (A x + C B) + D E) / (x (A x + B) + D F)) - E / F with a shoulder A,
 * linear strength B, linear angle C, toe D, toe angle E / F; over one fraction
 * bar, where the constants cancel and black is exactly black. */
static inline float hable_curve(float x)
{
    const float a = 0.15f, b = 0.50f, c = 0.10f, d = 0.20f, f = 0.30f;
    const float toe = 0.02f / 0.30f; // E / F
    return x * (a * (1.0f - toe) * x + b * (c - toe)) /
           (x * (a * x + b) + d * f);
}

GP_CLONES static void hable(float *r, float *g, float *b, size_t n, float white)
{
    const float exposure_bias = 2.0f;
    const float per_white = 1.0f / hable_curve(11.2f);
    float *const plane[] = {r, g, b};
    (void) white;
    for (int c = 0; c < 3; c++) {
        float *const v = plane[c];
        for (size_t i = 0; i < n; i++) {
            float y = hable_curve(exposure_bias * positive(v[i])) * per_white;
            v[i] = gp_minf(y, 1.0f);
        }
    }
}

// -- AgX ---------------------------------------------------------------------

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

#define EV_MIN (-12.47393f)     // 0.18 * 2^-10
#define EV_MAX 4.026069f        // 0.18 * 2^6.5
#define LIGHT_MIN 1.7578e-4f    // a little under 2^EV_MIN

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

/* x^2.2 for x in [0,1], as x^2 times its fifth root, so that the logarithm's
 * error counts a fifth. The root is 2^p, -100 < p < 100, to 1e-7: Taylor's
 * series around the nearest integer. */
INLINE float power22(float x)
{
    const float round = 12582912.0f; // 1.5 * 2^23: adding it drops fractions
    float p = 0.2f * log2_of(x > 1e-30f ? x : 1e-30f);
    float whole = (p + round) - round;
    float t = (p - whole) * 0.6931471806f, t2 = t * t;
    float series = (1.0f + t) + t2 * (1.0f / 2 + t * (1.0f / 6)) +
                   t2 * t2 * ((1.0f / 24 + t * (1.0f / 120)) +
                              t2 * (1.0f / 720 + t * (1.0f / 5040)));
    int32_t bits = ((int32_t) whole + 127) * (1 << 23);
    float power;
    memcpy(&power, &bits, sizeof power);
    return x * x * (power * series);
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
    float ev = log2_of(clamp(light, LIGHT_MIN, GP_LIGHT_MAX));
    float u = (ev - 0.5f * (EV_MIN + EV_MAX)) * (1.0f / (EV_MAX - EV_MIN));
    u = clamp(u, -0.5f, 0.5f);
    float u2 = u * u;
    return ((float) P0 + (float) P1 * u) + ((float) P2 + (float) P3 * u) * u2 +
           ((float) P4 + (float) P5 * u + (float) P6 * u2) * (u2 * u2);
}

GP_CLONES static void agx(float *restrict r, float *restrict g,
                          float *restrict b, size_t n, float white)
{
    (void) white;
    for (size_t i = 0; i < n; i++) {
        float r0 = clamp(r[i], -GP_LIGHT_MAX, GP_LIGHT_MAX);
        float g0 = clamp(g[i], -GP_LIGHT_MAX, GP_LIGHT_MAX);
        float b0 = clamp(b[i], -GP_LIGHT_MAX, GP_LIGHT_MAX);
        float r1 = contrast(row(inset, r0, g0, b0));
        float g1 = contrast(row(inset + 3, r0, g0, b0));
        float b1 = contrast(row(inset + 6, r0, g0, b0));
        r[i] = power22(clamp(row(outset, r1, g1, b1), 0.0f, 1.0f));
        g[i] = power22(clamp(row(outset + 3, r1, g1, b1), 0.0f, 1.0f));
        b[i] = power22(clamp(row(outset + 6, r1, g1, b1), 0.0f, 1.0f));
    }
}

/* Names as in the Khronos PBR Neutral Tone Mapper specification, 2024: F_90 =
 * 0.04, K_s = 0.8 - F_90, K_d = 0.15.
 * The part under K_s, c - f, is x - f added to c - x: nothing cancels. */
GP_CLONES static void neutral(float *restrict r, float *restrict g,
                              float *restrict b, size_t n, float white)
{
    const float f90 = 0.04f, ks = 0.8f - 0.04f, kd = 0.15f;
    (void) white;
    for (size_t i = 0; i < n; i++) {
        float r0 = positive(r[i]), g0 = positive(g[i]), b0 = positive(b[i]);
        float x = gp_minf(r0, gp_minf(g0, b0));
        float rest = x <= 2.0f * f90 ? x * x / (4.0f * f90) : x - f90;
        r0 = (r0 - x) + rest;
        g0 = (g0 - x) + rest;
        b0 = (b0 - x) + rest;
        float p = gp_maxf(r0, gp_maxf(g0, b0));
        float pn = 1.0f - (1.0f - ks) * (1.0f - ks) / (p + 1.0f - 2.0f * ks);
        float gain = 1.0f / (kd * (p - pn) + 1.0f);
        float grey = pn * (kd * (p - pn) * gain); // pn (1 - gain)
        float scale = pn / p * gain;
        r[i] = p <= ks ? r0 : gp_minf(r0 * scale + grey, 1.0f);
        g[i] = p <= ks ? g0 : gp_minf(g0 * scale + grey, 1.0f);
        b[i] = p <= ks ? b0 : gp_minf(b0 * scale + grey, 1.0f);
    }
}

GP_CLONES static void linear(float *r, float *g, float *b, size_t n,
                             float white)
{
    float *const plane[] = {r, g, b};
    (void) white;
    for (int c = 0; c < 3; c++) {
        float *const v = plane[c];
        for (size_t i = 0; i < n; i++)
            v[i] = gp_minf(positive(v[i]), 1.0f);
    }
}

#define CURVE(...) &(const struct gp_tone_curve) {__VA_ARGS__}

const struct gp_tone_curve *const gp_tone_curves[] = {
    CURVE(.name = "reinhard", .map = reinhard,
          .text = "L / (1 + L) on luminance; keeps hue"),
    CURVE(.name = "reinhard-extended", .map = reinhard_extended,
          .text = "reinhard with a luminance that becomes white",
          .reads_white = true),
    CURVE(.name = "aces", .map = aces,
          .text = "Stephen Hill's fit of the ACES rendering and output "
                  "transforms"),
    CURVE(.name = "hable", .map = hable,
          .text = "John Hable's filmic curve, white 11.2, exposure bias 2"),
    CURVE(.name = "agx", .map = agx,
          .text = "Troy Sobotka's AgX, default look"),
    CURVE(.name = "neutral", .map = neutral,
          .text = "Khronos PBR Neutral: true colours up to 0.8, then white"),
    CURVE(.name = "linear", .map = linear,
          .text = "exposure alone, cut at 0 and 1"),
    CURVE(.name = "none", .text = "the lit frame as it is, without exposure"),
    NULL,
};

const struct gp_tone_curve *gp_tone_find(const char *name)
{
    for (const struct gp_tone_curve *const *c = gp_tone_curves; *c; c++) {
        if (strcmp((*c)->name, name) == 0)
            return *c;
    }
    return NULL;
}
