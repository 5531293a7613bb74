/* The plain forms are branch-free integer arithmetic, which the compiler turns
 * into SSE2 or NEON; the AVX2 forms use the CPU's own conversion
 * (F16C). Both give the same bits. */
#include "core/half.h"

#include "core/bytes.h"
#include "core/cpu.h"

#include <stdbool.h>

#if defined(__x86_64__) && defined(__GNUC__)
#define HAVE_F16C 1
#include <immintrin.h>
#endif

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

#ifdef HAVE_F16C

GP_X86_AVX2 static size_t half_to_float_wide(const uint16_t *in, float *out,
                                             size_t n)
{
    size_t i = 0;
    for (; i + 8 <= n; i += 8) {
        __m128i h = _mm_loadu_si128((const __m128i *) (in + i));
        _mm256_storeu_ps(out + i, _mm256_cvtph_ps(h));
    }
    return i;
}

/* Adds to *clamped. */
GP_X86_AVX2 static size_t float_to_half_wide(const float *in, uint16_t *out,
                                             size_t n, size_t *clamped)
{
    const __m256i sign = _mm256_set1_epi32((int) 0x80000000);
    size_t i = 0;
    for (; i + 8 <= n; i += 8) {
        __m256 f = _mm256_loadu_ps(in + i);
        const __m256i u = _mm256_castps_si256(f);
        const __m256i body = _mm256_andnot_si256(sign, u);
        // clamp what is over 65504 but not infinite
        const __m256i over = _mm256_and_si256(
            _mm256_cmpgt_epi32(body, _mm256_set1_epi32(FLOAT_65520 - 1)),
            _mm256_cmpgt_epi32(_mm256_set1_epi32(FLOAT_INF), body));
        const int mask = _mm256_movemask_ps(_mm256_castsi256_ps(over));
        if (mask != 0) {
            const __m256i most = _mm256_or_si256(
                _mm256_and_si256(u, sign), _mm256_set1_epi32(FLOAT_65504));
            f = _mm256_castsi256_ps(_mm256_blendv_epi8(u, most, over));
            *clamped += (size_t) __builtin_popcount((unsigned) mask);
        }
        const __m128i h = _mm256_cvtps_ph(f, _MM_FROUND_TO_NEAREST_INT);
        _mm_storeu_si128((__m128i *) (out + i), h);
    }
    return i;
}

GP_X86_AVX2 static size_t round_wide(float *v, size_t n)
{
    size_t i = 0;
    for (; i + 8 <= n; i += 8) {
        __m128i h = _mm256_cvtps_ph(_mm256_loadu_ps(v + i),
                                    _MM_FROUND_TO_NEAREST_INT);
        _mm256_storeu_ps(v + i, _mm256_cvtph_ps(h));
    }
    return i;
}

#endif

void gp_half_to_float(const uint16_t *in, float *out, size_t n)
{
    size_t done = 0;
#ifdef HAVE_F16C
    if (gp_cpu_has_avx2())
        done = half_to_float_wide(in, out, n);
#endif
    for (size_t i = done; i < n; i++)
        out[i] = to_float(in[i]);
}

size_t gp_float_to_half(const float *in, uint16_t *out, size_t n)
{
    size_t done = 0, clamped = 0;
#ifdef HAVE_F16C
    if (gp_cpu_has_avx2())
        done = float_to_half_wide(in, out, n, &clamped);
#endif
    for (size_t i = done; i < n; i++) {
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

void gp_half_round(float *v, size_t n)
{
    size_t done = 0;
#ifdef HAVE_F16C
    if (gp_cpu_has_avx2())
        done = round_wide(v, n);
#endif
    for (size_t i = done; i < n; i++)
        v[i] = gp_half_nearest(v[i]);
}
