/* Sums over a kernel's samples. Each adds in one order, so that all who ask for
 * a sum get the same bits. */
#ifndef GP_GLARE_KERNEL_SUMS_H
#define GP_GLARE_KERNEL_SUMS_H

#include <stdbool.h>

/* Adds the squares and the samples of n in eight parts, so that it becomes
 * vector code. */
void gp_add_samples(const float *v, int n, double *squares, double *sum);

/* Squares and samples of one channel above the centre and below, left and right
 * of it, which all hold the centre's own row and column. */
struct gp_quarter_sums {
    double square[2][2], sum[2][2];
};

/* Sums of a row of w samples, from its centre as far as `reach`: squares left
 * and right, samples alike. */
void gp_side_sums(const float *row, int w, int cx, int reach, double side[4]);

/* Adds those of a row above the centre, below it, or in both. */
void gp_quarter_add(struct gp_quarter_sums *q, const double side[4],
                    bool above, bool below);

/* Returns the least of four quarters. */
double gp_quarter_least(double v[2][2]);

#endif
