// SPDX-License-Identifier: Apache-2.0
/* A far field spread over a light's disc, on its own grid. */
#include "core/memory.h"
#include "glare/far_field/far_field.h"
#include "glare/kernel.h"

#include <math.h>
#include <string.h>

/* The disc's shares on nodes -r .. r, by the splines. */
static void shares_of(int step, int reach, const float *weight, int r,
                      double *sum)
{
    const int side = 2 * reach + 1, nodes = 2 * r + 1;
    for (int i = 0; i < side * side; i++) {
        const int x = i % side - reach + r * step;
        const int y = i / side - reach + r * step;
        double along[GP_FAR_TAPS], down[GP_FAR_TAPS];
        gp_far_spline((double) (x % step) / step, along);
        gp_far_spline((double) (y % step) / step, down);
        for (int k = 0; k < GP_FAR_TAPS * GP_FAR_TAPS; k++) {
            const int u = k % GP_FAR_TAPS, v = k / GP_FAR_TAPS;
            sum[(y / step + v - 1) * nodes + x / step + u - 1] +=
                along[u] * down[v] * (double) weight[i];
        }
    }
}

/* Takes coefficients of splines to their values at the nodes, but those on the border to 0;
 * `in` is scratch, w x h each. */
static void find_values(int w, int h, float *in, float *out)
{
    memcpy(in, out, (size_t) w * (size_t) h * sizeof *in);
    memset(out, 0, (size_t) w * (size_t) h * sizeof *out);
    for (int y = 1; y < h - 1; y++) {
        for (int x = 1; x < w - 1; x++) {
            const float *const at = in + (size_t) y * (size_t) w + (size_t) x;
            const float *const up = at - w, *const low = at + w;
            const float sum = 16.0f * at[0] +
                              4.0f * (at[-1] + at[1] + up[0] + low[0]) +
                              (up[-1] + up[1] + low[-1] + low[1]);
            out[(size_t) y * (size_t) w + (size_t) x] =
                fmaxf(sum / 36.0f, 0.0f);
        }
    }
}

gp_status gp_kernel_spread_far(const struct gp_log *log,
                               const struct gp_kernel *k, int reach,
                               const float *weight,
                               struct gp_spread_kernel *out)
{
    gp_status st;
    const struct gp_far_field *const t = k->far;
    const int w = 2 * t->rx + 1, h = 2 * t->ry + 1;
    const int r = (reach + t->split.step - 1) / t->split.step + 2;
    const size_t n = (size_t) w * (size_t) h, side = 2 * (size_t) r + 1;
    struct gp_planes planes = {0};
    struct gp_kernel coarse = {0};
    struct gp_spread_kernel wide = {0};
    double *sum = NULL;
    float *shares = NULL, *values = NULL;
    GP_TRY(gp_alloc_zero(log, "tail", side * side, sizeof *sum, &sum));
    GP_TRY(gp_alloc(log, "tail", side * side, sizeof *shares, &shares));
    shares_of(t->split.step, reach, weight, r, sum);
    for (size_t i = 0; i < side * side; i++)
        shares[i] = (float) sum[i];
    GP_TRY(gp_planes_make(log, "tail", n, &planes));
    for (int c = 0; c < 3; c++)
        memcpy(planes.c[c], t->c[t->grey ? 0 : c], n * sizeof(float));
    GP_TRY(gp_kernel_of_planes(log, "tail", w, h, &planes, &coarse));
    GP_TRY(gp_kernel_spread(log, &coarse, r, shares, &wide));
    GP_TRY(gp_alloc(log, "tail", (size_t) wide.w * (size_t) wide.h,
                    sizeof *values, &values));
    for (int c = 0; c < 3; c++)
        find_values(wide.w, wide.h, values, wide.k.c[c]);
    wide.step = t->split.step;
    *out = wide;
    wide.k = (struct gp_planes) {0};
out:
    gp_planes_free(&wide.k);
    gp_kernel_free(&coarse);
    gp_free(sum);
    gp_free(shares);
    gp_free(values);
    return st;
}
