// SPDX-License-Identifier: Apache-2.0
/* Rows of floats, and splines along them. */
#ifndef GP_GLARE_SKY_ROWS_H
#define GP_GLARE_SKY_ROWS_H

enum { GP_SKY_REACH = 6 }; // nodes that dividing splines meets on either side

/* to += by * from, n of each. */
void gp_sky_add_scaled(float *to, const float *from, float by, int n);

/* The sum of n products. */
float gp_sky_dot(const float *a, const float *b, int n);

/* to = the sum of at[k] from[k] over `count` rows, n of each. */
void gp_sky_sum_rows(const float *const *from, const float *at, int count,
                     int n, float *to);

/* Adds pixels to n nodes half as dense, of which node m meets pixels from 2 m - 6 on,
 * by cubic B-splines. even, odd: pixels 2 i and 2 i + 1 at i; 0 from -3 to -1. */
void gp_sky_gather_row(const float *even, const float *odd, int n, float *node);

/* Adds n values between nodes: the sum of even[k] node[i + k] to row[2 i], of
 * odd[k] node[i + k] to row[2 i + 1]. */
void gp_sky_between_row(const float *node, const float even[4],
                        const float odd[4], int n, float *row);

/* out[i] = the sum of at[|k|] line[i + k], |k| <= REACH: n of them. */
void gp_sky_divide_row(const float *line, const float at[GP_SKY_REACH + 1],
                       int n, float *out);

#endif
