/* The filters of FLIP: what an eye at some distance resolves, and what it
 * takes for edges and points. All are separable. */
#ifndef GP_TONE_FLIP_FILTER_H
#define GP_TONE_FLIP_FILTER_H

/* Of one dimension, at most 2 * GP_FLIP_RADIUS_MAX + 1 taps, from the left. */
enum { GP_FLIP_RADIUS_MAX = 136 };
struct gp_flip_taps {
    float at[2 * GP_FLIP_RADIUS_MAX + 1];
};

/* Contrast sensitivity of the opponent channels (Andersson et al. 2020,
 * section 4.1.1): Gaussians, for blue-yellow the sum of two. Each sums to 1. */
enum gp_flip_colour {
    GP_FLIP_ACHROMATIC, GP_FLIP_RED_GREEN, GP_FLIP_BLUE_YELLOW,
    GP_FLIP_BLUE_YELLOW_2, GP_FLIP_COLOURS,
};

/* Detectors (section 4.2): a Gaussian and its first two derivatives. The
 * Gaussian sums to 1, the derivatives' positive and negative taps to 1 each. */
enum gp_flip_feature {
    GP_FLIP_BLUR, GP_FLIP_EDGE, GP_FLIP_POINT, GP_FLIP_FEATURES,
};

struct gp_flip_filters {
    int radius;          // of the colour filters, 2 * radius + 1 taps
    int feature_radius;  // of the detectors, <= radius
    struct gp_flip_taps colour[GP_FLIP_COLOURS];
    struct gp_flip_taps feature[GP_FLIP_FEATURES];
    float share[2];      // of the two blue-yellow Gaussians; sum 1
};

/* Makes them for `ppd` pixels a degree, in the range of tone/flip.h. */
void gp_flip_filters_make(float ppd, struct gp_flip_filters *out);

/* out[i] = sum over t of tap[t] * in[i + t]; n values from n + taps - 1. */
void gp_flip_filter_row(const float *in, const float *tap, int taps, int n,
                        float *out);

/* out[i] += weight * sum over t of tap[t] * in[t * pitch + i]. */
void gp_flip_filter_column(const float *in, int pitch, const float *tap,
                           int taps, float weight, int n, float *out);

#endif
