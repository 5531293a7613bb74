// SPDX-License-Identifier: Apache-2.0
/* Rows of a kernel's samples. Each sum adds in one order, so that all who ask
 * for it get the same bits. */
#ifndef GP_GLARE_KERNEL_ROWS_H
#define GP_GLARE_KERNEL_ROWS_H

#include "glare/kernel.h"

#include <stdbool.h>

/* Squares and samples of one channel above the centre and below, left and right
 * of it, which all hold the centre's own row and column. */
struct gp_quarter_sums {
    double square[2][2], sum[2][2];
};

/* Sums of a row of w samples, from its centre as far as `reach`: squares left
 * and right, samples alike. */
void gp_row_sides(const float *row, int w, int cx, int reach, double side[4]);

/* Adds those of a row above the centre, below it, or in both. */
void gp_quarter_add(struct gp_quarter_sums *q, const double side[4],
                    bool above, bool below);

/* Returns the least of four quarters. */
double gp_quarter_least(double v[2][2]);

/* A row that was cut: its sums in order, and where it is not 0. */
struct gp_cut_row {
    double sum, square, magnitude;
    double faint;           // magnitudes that became 0: each was under FLT_MIN
    double side[4];         // gp_row_sides() as far as it goes
    bool negative;          // a sample is under 0
    struct gp_lit_row lit;
};

/* Writes w samples times `factor` to `out`, which may be `in`; `cx` is the
 * centre's column. */
struct gp_cut_row gp_row_cut(const float *in, int w, int cx, double factor,
                             float *out);

#endif
