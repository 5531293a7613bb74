#include "glare/fft/place.h"

#include "glare/direct/direct.h"
#include "glare/fft/lib.h"

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

/* Adds one row up to `reach` left and right of the centre, which both sides
 * count: squares to [0] and [1], samples to [2] and [3]. */
static void add_row(const float *row, int w, int cx, int reach, double side[4])
{
    for (int x = 0; x < w; x++) {
        const double v = (double) row[x];
        const double left = x <= cx && x >= cx - reach ? v : 0.0;
        const double right = x >= cx && x <= cx + reach ? v : 0.0;
        side[0] += left * left;
        side[1] += right * right;
        side[2] += left;
        side[3] += right;
    }
}

/* How far from the centre a source in a frame of n pixels is sure to see, to
 * one side at least, on an axis where the kernel has w samples. */
static int sure_reach(int w, int n)
{
    return w - 1 <= n ? INT_MAX / 2 : n / 2;
}

/* Of channel c: the least quarter's squares and samples. */
static void least_quarter(const struct gp_kernel *k, int c, int w, int h,
                          double *square, double *sum)
{
    const int reach_x = sure_reach(k->w, w), reach_y = sure_reach(k->h, h);
    double half[2][4] = {{0}}; // above the centre, and below
    for (int y = 0; y < k->h; y++) {
        double side[4] = {0};
        add_row(k->k.c[c] + (size_t) y * (size_t) k->w, k->w, k->cx, reach_x,
                side);
        const bool above = y <= k->cy && y >= k->cy - reach_y;
        const bool below = y >= k->cy && y <= k->cy + reach_y;
        for (int i = 0; i < 4; i++) {
            half[0][i] += above ? side[i] : 0.0;
            half[1][i] += below ? side[i] : 0.0;
        }
    }
    *square = fmin(fmin(half[0][0], half[0][1]), fmin(half[1][0], half[1][1]));
    *sum = fmin(fmin(half[0][2], half[0][3]), fmin(half[1][2], half[1][3]));
}

void gp_fft_find_quarters(const struct gp_kernel *k, int w, int h,
                          struct gp_fft_quarters *out)
{
    *out = (struct gp_fft_quarters) {.lobes = gp_direct_lobes(k)};
    for (int c = 0; c < 3 && !out->lobes; c++)
        least_quarter(k, c, w, h, &out->square[c], &out->sum[c]);
}

double gp_fft_least(const struct gp_sources *s,
                    const struct gp_fft_quarters *q)
{
    double all = 0.0;
    for (int c = 0; c < 3; c++) {
        const double flux = s->flux[c] * q->sum[c];
        all += fmax(s->energy[c] * q->square[c],
                    flux * flux / ((double) s->w * s->h));
    }
    return sqrt(all);
}

double gp_fft_bound(const struct gp_sources *s, const struct gp_kernel *k,
                    double least, const struct gp_fft_placing *p)
{
    static const double STAGE = 5.42, ADDING = 1.0; // of 2^-24: see above
    static const double CERTAIN = 1e-6; // sums in double lose what is under it
    double noise = 0.0, layer = 0.0; // squares
    for (int c = 0; c < 3; c++) {
        const double norm = sqrt(s->energy[c]);
        const double young = fmin(norm * k->norm1[c],
                                  s->flux[c] * k->norm2[c]);
        noise += norm * norm * k->norm2[c] * k->norm2[c];
        layer += young * young;
    }
    if (!(least > CERTAIN * sqrt(noise)))
        return INFINITY;
    return 0x1p-24 * sqrt(log2((double) p->nx * p->ny)) *
           (2.0 * STAGE * sqrt(noise) +
            (STAGE + 2.0 * ADDING) * sqrt(layer)) / least;
}
