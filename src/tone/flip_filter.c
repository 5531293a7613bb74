#include "tone/flip_filter.h"

#include "core/cpu.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* Table 1 of the paper: a * sqrt(pi / b) * exp(-pi^2 x^2 / b), x in degrees. */
static const struct {
    double a, b;
} gaussian[GP_FLIP_COLOURS] = {
    [GP_FLIP_ACHROMATIC] = {1.0, 0.0047},
    [GP_FLIP_RED_GREEN] = {1.0, 0.0053},
    [GP_FLIP_BLUE_YELLOW] = {34.1, 0.04},
    [GP_FLIP_BLUE_YELLOW_2] = {13.5, 0.025},
};

/* Section 4.2: the detectors' width is 0.082 degrees from peak to trough,
 * which is two standard deviations. */
static const double FEATURE_WIDTH = 0.082;

static int radius_of(double sigma)
{
    return (int) ceil(3.0 * sigma);
}

/* Scales the taps by 1 / sum; returns the sum. */
static double normalise(const double *tap, int n, float *out)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        sum += tap[i];
    for (int i = 0; i < n; i++)
        out[i] = (float) (tap[i] / sum);
    return sum;
}

static void make_colour(double ppd, struct gp_flip_filters *f)
{
    double tap[2 * GP_FLIP_RADIUS_MAX + 1] = {0}, volume[GP_FLIP_COLOURS];
    // of the widest, whose standard deviation is sqrt(b / (2 pi^2)) degrees
    const double widest = gaussian[GP_FLIP_BLUE_YELLOW].b;
    f->radius = radius_of(sqrt(widest / (2.0 * PI * PI)) * ppd);
    for (int c = 0; c < GP_FLIP_COLOURS; c++) {
        for (int i = -f->radius; i <= f->radius; i++) {
            const double x = i / ppd;
            tap[i + f->radius] = exp(-PI * PI * x * x / gaussian[c].b);
        }
        const double sum = normalise(tap, 2 * f->radius + 1, f->colour[c].at);
        volume[c] = gaussian[c].a * sqrt(PI / gaussian[c].b) * sum * sum;
    }
    const double both = volume[GP_FLIP_BLUE_YELLOW] +
                        volume[GP_FLIP_BLUE_YELLOW_2];
    f->share[0] = (float) (volume[GP_FLIP_BLUE_YELLOW] / both);
    f->share[1] = (float) (volume[GP_FLIP_BLUE_YELLOW_2] / both);
}

/* Positive and negative taps to a sum of 1 each. */
static void normalise_signs(const double *tap, int n, float *out)
{
    double above = 0.0, below = 0.0;
    for (int i = 0; i < n; i++) {
        above += tap[i] > 0.0 ? tap[i] : 0.0;
        below -= tap[i] < 0.0 ? tap[i] : 0.0;
    }
    for (int i = 0; i < n; i++)
        out[i] = (float) (tap[i] / (tap[i] > 0.0 ? above : below));
}

static void make_features(double ppd, struct gp_flip_filters *f)
{
    double blur[2 * GP_FLIP_RADIUS_MAX + 1] = {0};
    double edge[2 * GP_FLIP_RADIUS_MAX + 1] = {0};
    double point[2 * GP_FLIP_RADIUS_MAX + 1] = {0};
    const double sigma = 0.5 * FEATURE_WIDTH * ppd;
    const int r = f->feature_radius = radius_of(sigma), n = 2 * r + 1;
    for (int i = -r; i <= r; i++) {
        const double g = exp(-(double) i * i / (2.0 * sigma * sigma));
        blur[i + r] = g;
        edge[i + r] = -i * g;
        point[i + r] = ((double) i * i / (sigma * sigma) - 1.0) * g;
    }
    (void) normalise(blur, n, f->feature[GP_FLIP_BLUR].at);
    normalise_signs(edge, n, f->feature[GP_FLIP_EDGE].at);
    normalise_signs(point, n, f->feature[GP_FLIP_POINT].at);
}

void gp_flip_filters_make(float ppd, struct gp_flip_filters *out)
{
    memset(out, 0, sizeof *out);
    make_colour((double) ppd, out);
    make_features((double) ppd, out);
}

GP_CLONES void gp_flip_filter_row(const float *in, const float *tap, int taps,
                                  int n, float *restrict out)
{
    for (int i = 0; i < n; i++)
        out[i] = 0.0f;
    for (int t = 0; t < taps; t++) {
        const float k = tap[t], *const from = in + t;
        for (int i = 0; i < n; i++)
            out[i] += k * from[i];
    }
}

GP_CLONES void gp_flip_filter_column(const float *in, int pitch,
                                     const float *tap, int taps, float weight,
                                     int n, float *restrict out)
{
    for (int t = 0; t < taps; t++) {
        const float k = weight * tap[t];
        const float *const from = in + (long) t * pitch;
        for (int i = 0; i < n; i++)
            out[i] += k * from[i];
    }
}
