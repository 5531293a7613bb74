// SPDX-License-Identifier: Apache-2.0
#include "glare/sky/rows.h"

#include "core/cpu.h"

enum { LANES = 8, REACH = GP_SKY_REACH };

typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef float loose
    __attribute__((vector_size(4 * LANES), aligned(4), may_alias));

#define AT(p) (*(const loose *) (p))

GP_CLONES void gp_sky_add_scaled(float *restrict to, const float *restrict from,
                                 float by, int n)
{
    for (int i = 0; i < n; i++)
        to[i] += by * from[i];
}

GP_CLONES float gp_sky_dot(const float *a, const float *b, int n)
{
    lanes sum = {0};
    int i = 0;
    for (; i + LANES <= n; i += LANES)
        sum += AT(a + i) * AT(b + i);
    float total = 0.0f;
    for (int k = 0; k < LANES; k++)
        total += sum[k];
    for (; i < n; i++)
        total += a[i] * b[i];
    return total;
}

GP_CLONES void gp_sky_sum_rows(const float *const *from, const float *at,
                               int count, int n, float *restrict to)
{
    int i = 0;
    for (; i + 2 * LANES <= n; i += 2 * LANES) {
        lanes a = {0}, b = {0};
        for (int k = 0; k < count; k++) {
            a += at[k] * AT(from[k] + i);
            b += at[k] * AT(from[k] + i + LANES);
        }
        *(loose *) (to + i) = a;
        *(loose *) (to + i + LANES) = b;
    }
    for (; i < n; i++) {
        to[i] = 0.0f;
        for (int k = 0; k < count; k++)
            to[i] += at[k] * from[k][i];
    }
}

GP_CLONES void gp_sky_gather_row(const float *restrict e,
                                 const float *restrict o, int n,
                                 float *restrict node)
{
    for (int m = 0; m < n; m++)
        node[m] += (e[m] + e[m - 2]) * (1.0f / 6.0f) +
                   e[m - 1] * (4.0f / 6.0f) +
                   (o[m] + o[m - 3]) * (1.0f / 48.0f) +
                   (o[m - 1] + o[m - 2]) * (23.0f / 48.0f);
}

GP_CLONES void gp_sky_between_row(const float *restrict node,
                                  const float even[4], const float odd[4],
                                  int n, float *restrict row)
{
    int i = 0;
    for (; 2 * (i + LANES) <= n; i += LANES) {
        const lanes l0 = AT(node + i), l1 = AT(node + i + 1);
        const lanes l2 = AT(node + i + 2), l3 = AT(node + i + 3);
        const lanes a =
            even[0] * l0 + even[1] * l1 + even[2] * l2 + even[3] * l3;
        const lanes b = odd[0] * l0 + odd[1] * l1 + odd[2] * l2 + odd[3] * l3;
        *(loose *) (row + 2 * i) +=
            __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
        *(loose *) (row + 2 * i + LANES) +=
            __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
    }
    for (int x = 2 * i; x < n; x++) {
        const float *const at = x & 1 ? odd : even, *const l = node + x / 2;
        row[x] += at[0] * l[0] + at[1] * l[1] + at[2] * l[2] + at[3] * l[3];
    }
}

GP_CLONES void gp_sky_divide_row(const float *restrict line,
                                 const float at[REACH + 1], int n,
                                 float *restrict out)
{
    int i = 0;
    for (; i + LANES <= n; i += LANES) {
        lanes v = at[0] * AT(line + i);
        for (int k = 1; k <= REACH; k++)
            v += at[k] * (AT(line + i - k) + AT(line + i + k));
        *(loose *) (out + i) = v;
    }
    for (; i < n; i++) {
        float v = at[0] * line[i];
        for (int k = 1; k <= REACH; k++)
            v += at[k] * (line[i - k] + line[i + k]);
        out[i] = v;
    }
}
