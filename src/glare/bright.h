/* The bright pixels of a piece of a row, moved together. */
#ifndef GP_GLARE_BRIGHT_H
#define GP_GLARE_BRIGHT_H

#include <stdbool.h>
#include <stdint.h>

enum {
    GP_BRIGHT_MOST = 256, // pixels at a time: they stay in the first-level cache
    GP_BRIGHT_LANES = 8,
};

/* Which pixels are bright: luminance of the non-negative part over `open`. */
struct gp_bright_rule {
    float open;
    float weight[3]; // of luminance
    bool avx2;
    uint8_t order[1 << GP_BRIGHT_LANES][GP_BRIGHT_LANES]; // for avx2
};
void gp_bright_rule_make(float open, const float weight[3],
                         struct gp_bright_rule *out);

/* What was found. Vectors are stored whole: what lies behind the last pixel
 * is of no meaning. */
struct gp_bright {
    float rgb[3][GP_BRIGHT_MOST + GP_BRIGHT_LANES]; // non-negative part
    int32_t x[GP_BRIGHT_MOST + GP_BRIGHT_LANES];
};

/* Finds the bright ones of n <= GP_BRIGHT_MOST cleaned pixels whose first is
 * at column x0; returns how many. The same bits with AVX2 and without. */
int gp_bright_find(const struct gp_bright_rule *rule,
                   const float *const rgb[3], int x0, int n,
                   struct gp_bright *out);

static inline __attribute__((always_inline)) float gp_lit(float v)
{
    return v > 0.0f ? v : 0.0f;
}

/* Luminance of the non-negative part. */
static inline __attribute__((always_inline)) float
gp_lit_luminance(const float weight[3], float r, float g, float b)
{
    return weight[0] * gp_lit(r) + weight[1] * gp_lit(g) +
           weight[2] * gp_lit(b);
}

#endif
