/* Rows of a kernel's samples. Each sum adds in one order, so that all who ask
 * for it get the same bits. */
#ifndef GP_GLARE_KERNEL_ROWS_H
#define GP_GLARE_KERNEL_ROWS_H

#include "glare/kernel.h"

#include <stdbool.h>
#include <stdint.h>

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

/* Sums of samples and squares of a row of n channels, 1 or 3, each in order;
 * the channels at once, as each sum waits for its own last sample. */
void gp_row_sums(const float *const *v, int n, int w, double sum[3],
                 double square[3]);

/* Returns the bits of the largest magnitude, by which floats are ordered: those
 * of Inf and NaN are the largest. */
uint32_t gp_row_bits(const float *v, int w);

/* Returns the sum of the magnitudes, in order. */
double gp_row_magnitudes(const float *v, int w);

/* Multiplies samples by `factor`; *negative: one is under 0 then. Returns true
 * when some are under FLT_MIN in magnitude. */
bool gp_row_scale(float *v, int w, double factor, bool *negative);

/* Makes samples under FLT_MIN 0; returns the sum of their magnitudes. */
double gp_row_drop_faint(float *v, int w);

/* Returns where a row is not 0. */
struct gp_lit_row gp_row_lit(const float *v, int w);

#endif
