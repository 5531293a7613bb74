#include "glare/kernel_sums.h"

#include "core/cpu.h"
#include "core/minmax.h"

#include <math.h>

GP_CLONES void gp_add_samples(const float *v, int n, double *squares,
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

void gp_side_sums(const float *row, int w, int cx, int reach, double side[4])
{
    for (int i = 0; i < 2; i++) {
        const int from = gp_max(i ? cx : cx - reach, 0);
        const int last = gp_min(i ? cx + reach : cx, w - 1);
        side[i] = side[2 + i] = 0.0;
        gp_add_samples(row + from, last + 1 - from, &side[i], &side[2 + i]);
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
