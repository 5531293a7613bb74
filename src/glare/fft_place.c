#include "glare/fft_place.h"

#include "glare/fft_lib.h"

#include <limits.h>
#include <math.h>
#include <stdbool.h>

static int max(int a, int b)
{
    return a > b ? a : b;
}

static int min(int a, int b)
{
    return a < b ? a : b;
}

/* One axis: sources [in0, in1), kernel offsets [-c, w - 1 - c], frame [0, n).
 * Returns the least period. */
static int place_axis(int in0, int in1, int c, int w, int n, int *out0,
                      int *out1, int *tap0, int *tap1)
{
    *out0 = max(0, in0 - c);
    *out1 = min(n, in1 + w - 1 - c);
    if (*out1 <= *out0) // nothing of the kernel reaches the frame
        *out1 = *out0 = 0;
    *tap0 = max(-c, *out0 - (in1 - 1));
    *tap1 = min(w - c, *out1 - in0);
    const int right = in1 - 1 + *tap1 - 1 - *out0; // wraps to the left end
    const int left = *out1 - 1 - (in0 + *tap0);
    return max(max(right, left) + 1, max(in1 - in0, *tap1 - *tap0));
}

struct gp_fft_placing gp_fft_place(const struct gp_sources *s,
                                   const struct gp_kernel *k)
{
    struct gp_fft_placing p = {.in = s->box};
    const int x = place_axis(p.in.x0, p.in.x1, k->cx, k->w, s->w, &p.out.x0,
                             &p.out.x1, &p.taps.x0, &p.taps.x1);
    const int y = place_axis(p.in.y0, p.in.y1, k->cy, k->h, s->h, &p.out.y0,
                             &p.out.y1, &p.taps.y0, &p.taps.y1);
    if (!gp_rect_empty(p.out)) {
        p.nx = gp_fft_length(x);
        p.ny = gp_fft_length(y);
    }
    return p;
}

/* Work of the passes, one core: half the row transforms, all columns twice,
 * for three channels; a third more for moving the data. */
double gp_fft_predict_ms(const struct gp_sources *s,
                           const struct gp_fft_placing *p)
{
    int light = 0;
    for (int y = 0; y < s->h; y++)
        light += s->row[y + 1] > s->row[y];
    const double rows = (light + gp_rect_h(p->out)) / 2.0;
    return 3.0 * 1.35e-6 * (rows * gp_fft_cost(p->nx) +
                            (p->nx + 2.0) * gp_fft_cost(p->ny));
}

/* Squares of one row up to `reach` left and right of the centre, which both
 * count it; false when a sample is negative. */
static bool row_squares(const float *row, int w, int cx, int reach,
                        double *left, double *right)
{
    bool lobe = false;
    for (int x = 0; x < w; x++) {
        const double v = (double) row[x];
        lobe |= v < 0.0;
        *left += x <= cx && x >= cx - reach ? v * v : 0.0;
        *right += x >= cx && x <= cx + reach ? v * v : 0.0;
    }
    return !lobe;
}

/* How far from the centre a source in a frame of n pixels is sure to see, to
 * one side at least, on an axis where the kernel has w samples. */
static int sure_reach(int w, int n)
{
    return w - 1 <= n ? INT_MAX / 2 : n / 2;
}

/* Sum of squares of the least quarter; -1 for a channel with lobes. */
static double least_quarter(const struct gp_kernel *k, int c, int w, int h)
{
    const int reach_x = sure_reach(k->w, w), reach_y = sure_reach(k->h, h);
    double quarter[4] = {0}; // top left, top right, bottom left, right
    for (int y = 0; y < k->h; y++) {
        double left = 0.0, right = 0.0;
        if (!row_squares(k->k.c[c] + (size_t) y * (size_t) k->w, k->w, k->cx,
                         reach_x, &left, &right))
            return -1.0;
        const bool above = y <= k->cy && y >= k->cy - reach_y;
        const bool below = y >= k->cy && y <= k->cy + reach_y;
        quarter[0] += above ? left : 0.0;
        quarter[1] += above ? right : 0.0;
        quarter[2] += below ? left : 0.0;
        quarter[3] += below ? right : 0.0;
    }
    return fmin(fmin(quarter[0], quarter[1]), fmin(quarter[2], quarter[3]));
}

double gp_fft_kernel_spread(const struct gp_kernel *k, int w, int h)
{
    double worst = 0.0;
    for (int c = 0; c < 3; c++) {
        const double least = least_quarter(k, c, w, h);
        if (least < 0.0)
            return INFINITY;
        if (k->norm2[c] > 0.0)
            worst = fmax(worst, k->norm2[c] / sqrt(least));
    }
    return worst;
}

double gp_fft_bound(double spread, const struct gp_fft_placing *p)
{
    return 3.0 * 5.42 * 0x1p-24 * log2((double) p->nx * p->ny) * spread;
}
