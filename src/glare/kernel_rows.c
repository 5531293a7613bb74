// SPDX-License-Identifier: Apache-2.0
#include "glare/kernel_rows.h"

#include "core/luminance.h"
#include "core/minmax.h"

#include <float.h>
#include <limits.h>
#include <math.h>

void gp_row_sides(const float *row, int w, int cx, int reach, double side[4])
{
    for (int i = 0; i < 2; i++) {
        const int from = gp_max(i ? cx : cx - reach, 0);
        const int last = gp_min(i ? cx + reach : cx, w - 1);
        side[i] = side[2 + i] = 0.0;
        gp_samples_add(row + from, last + 1 - from, &side[i], &side[2 + i]);
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

struct gp_cut_row gp_row_cut(const float *in, int w, int cx, double factor,
                             float *out)
{
    struct gp_cut_row r = {.lit = {w, 0, 0}};
    int lit = 0;
    for (int x = 0; x < w; x++) {
        float scaled = (float) ((double) in[x] * factor);
        const double size = fabs((double) scaled);
        if (size < (double) FLT_MIN) {
            r.faint += size;
            scaled = 0.0f;
        }
        out[x] = scaled;
        if (scaled == 0.0f)
            continue;
        r.sum += (double) scaled;
        r.square += (double) scaled * (double) scaled;
        r.magnitude += size;
        r.negative |= scaled < 0.0f;
        r.lit.from = lit++ ? r.lit.from : x;
        r.lit.to = x + 1;
    }
    if (!lit)
        r.lit.from = 0;
    r.lit.dark = r.lit.to - r.lit.from - lit;
    gp_row_sides(out, w, cx, INT_MAX / 2, r.side);
    return r;
}
