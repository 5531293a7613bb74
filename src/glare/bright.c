#include "glare/bright.h"

#include "core/cpu.h"

#include <string.h>

#ifdef __x86_64__
#include <immintrin.h>
#endif

/* Pixels [from, n), after `at` that were found before. */
static int find_plain(const struct gp_bright_rule *rule,
                      const float *const rgb[3], int x0, int from, int n,
                      int at, struct gp_bright *out)
{
    for (int i = from; i < n; i++) {
        const float c[3] = {gp_lit(rgb[0][i]), gp_lit(rgb[1][i]),
                            gp_lit(rgb[2][i])};
        if (!(gp_lit_luminance(rule->weight, c[0], c[1], c[2]) > rule->open))
            continue;
        for (int k = 0; k < 3; k++)
            out->rgb[k][at] = c[k];
        out->x[at++] = x0 + i;
    }
    return at;
}

#ifdef __x86_64__
/* The same, eight pixels at a time: those that are bright move to the front
 * of their vector, and the next vector overwrites the rest. */
GP_X86_AVX2 static int find_avx2(const struct gp_bright_rule *rule,
                                 const float *const rgb[3], int x0, int n,
                                 struct gp_bright *out)
{
    const __m256 zero = _mm256_setzero_ps(), open = _mm256_set1_ps(rule->open);
    const __m256 weight[3] = {_mm256_set1_ps(rule->weight[0]),
                              _mm256_set1_ps(rule->weight[1]),
                              _mm256_set1_ps(rule->weight[2])};
    __m256i x = _mm256_add_epi32(_mm256_set1_epi32(x0),
                                 _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    int i = 0, at = 0;
    for (; i + GP_BRIGHT_LANES <= n; i += GP_BRIGHT_LANES) {
        __m256 c[3];
        for (int k = 0; k < 3; k++)
            c[k] = _mm256_max_ps(_mm256_loadu_ps(rgb[k] + i), zero);
        const __m256 y = _mm256_add_ps(
            _mm256_add_ps(_mm256_mul_ps(weight[0], c[0]),
                          _mm256_mul_ps(weight[1], c[1])),
            _mm256_mul_ps(weight[2], c[2]));
        const int bright =
            _mm256_movemask_ps(_mm256_cmp_ps(y, open, _CMP_GT_OQ));
        if (bright) {
            const __m256i order = _mm256_cvtepu8_epi32(
                _mm_loadl_epi64((const __m128i *) rule->order[bright]));
            for (int k = 0; k < 3; k++)
                _mm256_storeu_ps(out->rgb[k] + at,
                                 _mm256_permutevar8x32_ps(c[k], order));
            _mm256_storeu_si256((__m256i *) (void *) (out->x + at),
                                _mm256_permutevar8x32_epi32(x, order));
            at += __builtin_popcount((unsigned) bright);
        }
        x = _mm256_add_epi32(x, _mm256_set1_epi32(GP_BRIGHT_LANES));
    }
    return find_plain(rule, rgb, x0, i, n, at, out);
}
#endif

void gp_bright_rule_make(float open, const float weight[3],
                         struct gp_bright_rule *out)
{
    out->open = open;
    memcpy(out->weight, weight, sizeof out->weight);
    out->avx2 = gp_cpu_has_avx2();
    // order[m]: the places of the bits of m, lowest first
    for (int m = 0; m < 1 << GP_BRIGHT_LANES; m++) {
        int n = 0;
        for (int i = 0; i < GP_BRIGHT_LANES; i++) {
            if (m >> i & 1)
                out->order[m][n++] = (uint8_t) i;
        }
    }
}

int gp_bright_find(const struct gp_bright_rule *rule,
                   const float *const rgb[3], int x0, int n,
                   struct gp_bright *out)
{
#ifdef __x86_64__
    if (rule->avx2)
        return find_avx2(rule, rgb, x0, n, out);
#endif
    return find_plain(rule, rgb, x0, 0, n, 0, out);
}
