#include "glare/kernel_rows.h"

#include "core/cpu.h"
#include "core/minmax.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Adds the squares and the samples of n in eight parts, so that it becomes
 * vector code. */
GP_CLONES static void add_samples(const float *v, int n, double *squares,
                                  double *sum)
{
    enum { LANES = 8 };
    double square[LANES] = {0}, whole[LANES] = {0};
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        for (int i = 0; i < LANES; i++) {
            const double one = (double) v[x + i];
            square[i] += one * one;
            whole[i] += one;
        }
    }
    for (; x < n; x++) {
        square[0] += (double) v[x] * (double) v[x];
        whole[0] += (double) v[x];
    }
    for (int i = 0; i < LANES; i++) {
        *squares += square[i];
        *sum += whole[i];
    }
}

void gp_row_sides(const float *row, int w, int cx, int reach, double side[4])
{
    for (int i = 0; i < 2; i++) {
        const int from = gp_max(i ? cx : cx - reach, 0);
        const int last = gp_min(i ? cx + reach : cx, w - 1);
        side[i] = side[2 + i] = 0.0;
        add_samples(row + from, last + 1 - from, &side[i], &side[2 + i]);
    }
}

void gp_quarter_add(struct gp_quarter_sums *q, const double side[4],
                    bool above, bool below)
{
    const bool in[2] = {above, below};
    for (int i = 0; i < 4; i++) {
        q->square[i / 2][i % 2] += in[i / 2] ? side[i % 2] : 0.0;
        q->sum[i / 2][i % 2] += in[i / 2] ? side[2 + i % 2] : 0.0;
    }
}

double gp_quarter_least(double v[2][2])
{
    return fmin(fmin(v[0][0], v[0][1]), fmin(v[1][0], v[1][1]));
}

static inline __attribute__((always_inline)) void
add_in_order(const float *const *v, int n, int w, double *restrict sum,
             double *restrict square)
{
    double a[3] = {0}, b[3] = {0};
    for (int x = 0; x < w; x++) {
        for (int c = 0; c < n; c++) {
            const double one = (double) v[c][x];
            a[c] += one;
            b[c] += one * one;
        }
    }
    for (int c = 0; c < n; c++) {
        sum[c] = a[c];
        square[c] = b[c];
    }
}

void gp_row_sums(const float *const *v, int n, int w, double sum[3],
                 double square[3])
{
    if (n == 3)
        add_in_order(v, 3, w, sum, square);
    else
        add_in_order(v, 1, w, sum, square);
}

GP_CLONES uint32_t gp_row_bits(const float *v, int w)
{
    uint32_t most = 0;
    for (int x = 0; x < w; x++) {
        const float magnitude = fabsf(v[x]);
        uint32_t bits;
        memcpy(&bits, &magnitude, sizeof bits);
        most = bits > most ? bits : most;
    }
    return most;
}

GP_CLONES bool gp_row_scale(float *v, int w, double factor, bool *negative)
{
    int under = 0, faint = 0;
    for (int x = 0; x < w; x++) {
        const float scaled = (float) ((double) v[x] * factor);
        under |= scaled < 0.0f;
        faint |= fabsf(scaled) < FLT_MIN;
        v[x] = scaled;
    }
    *negative = under;
    return faint;
}

double gp_row_drop_faint(float *v, int w)
{
    double sum = 0.0;
    for (int x = 0; x < w; x++) {
        if (fabsf(v[x]) < FLT_MIN) {
            sum += fabs((double) v[x]);
            v[x] = 0.0f;
        }
    }
    return sum;
}

double gp_row_magnitudes(const float *v, int w)
{
    double sum = 0.0;
    for (int x = 0; x < w; x++)
        sum += fabs((double) v[x]);
    return sum;
}

GP_CLONES static int count_lit(const float *v, int w)
{
    int n = 0;
    for (int x = 0; x < w; x++)
        n += v[x] != 0.0f;
    return n;
}

struct gp_lit_row gp_row_lit(const float *v, int w)
{
    struct gp_lit_row lit = {0, w, 0};
    while (lit.to > 0 && v[lit.to - 1] == 0.0f)
        lit.to--;
    while (lit.from < lit.to && v[lit.from] == 0.0f)
        lit.from++;
    lit.dark = lit.to - lit.from - count_lit(v, w);
    return lit;
}
