/* Light of shapes finer than a pixel, shared out by where it falls. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

gp_status gp_deposit_make(const struct gp_log *log, int rx, int ry,
                          struct gp_deposit *out)
{
    const size_t n = (2 * (size_t) rx + 1) * (2 * (size_t) ry + 1);
    struct gp_deposit d = {.rx = rx, .ry = ry};
    gp_status st = gp_alloc_zero(log, "kernel", 3 * n, sizeof(double), &d.v[0]);
    if (st)
        return st;
    d.v[1] = d.v[0] + n;
    d.v[2] = d.v[1] + n;
    *out = d;
    return GP_OK;
}

void gp_deposit_free(struct gp_deposit *d)
{
    gp_free(d->v[0]);
    *d = (struct gp_deposit) {0};
}

void gp_deposit_add(const struct gp_deposit *d, double u, double v,
                    const double light[3])
{
    if (!(fabs(u) < d->rx + 1.0 && fabs(v) < d->ry + 1.0))
        return;
    const int x0 = (int) floor(u), y0 = (int) floor(v);
    const double right = u - x0, low = v - y0;
    for (int k = 0; k < 4; k++) {
        const int x = x0 + k % 2, y = y0 + k / 2;
        const double share = (k % 2 ? right : 1.0 - right) *
                             (k / 2 ? low : 1.0 - low);
        if (abs(x) > d->rx || abs(y) > d->ry)
            continue;
        const size_t at = (size_t) (y + d->ry) * (2 * (size_t) d->rx + 1) +
                          (size_t) (x + d->rx);
        for (int c = 0; c < 3; c++)
            d->v[c][at] += share * light[c];
    }
}

void gp_deposit_row(const struct gp_deposit *d, int channels, int x, int y,
                    int n, double *const out[3])
{
    const size_t row = (size_t) (y + d->ry) * (2 * (size_t) d->rx + 1);
    for (int i = 0; i < n; i++) {
        const bool inside = abs(y) <= d->ry && abs(x + i) <= d->rx;
        for (int c = 0; c < channels; c++)
            out[c][i] = inside ? d->v[c][row + (size_t) (x + i + d->rx)] : 0.0;
    }
}

// -- rings --------------------------------------------------------------------

/* Adds the circle of radii (u, v) pixels about the light: arcs between the
 * places where it passes from pixel to pixel, on which tents are straight. */
static void add_circle(const struct gp_deposit *d, double u, double v,
                       const double light[3])
{
    const int columns = (int) fmin(u, d->rx + 1.0);
    const int rows = (int) fmin(v, d->ry + 1.0);
    // angles that grow: columns from the last, rows from the first
    int column = columns, row = 1;
    double from = 0.0;
    for (;;) {
        const double by_column =
            column > 0 ? acos(fmin(column / u, 1.0)) : 0.5 * PI;
        const double by_row = row <= rows ? asin(fmin(row / v, 1.0))
                                          : 0.5 * PI;
        const double to = fmin(by_column, by_row);
        const struct gp_gauss *const g = gp_gauss_rule(to - from > 0.5 ? 7 : 4);
        for (int k = 0; k < g->n && to > from; k++) {
            const double angle =
                0.5 * (from + to) + (to - from) * g->node[k];
            const double share = (to - from) * g->weight[k] / (2.0 * PI);
            const double part[3] = {share * light[0], share * light[1],
                                    share * light[2]};
            const double x = u * cos(angle), y = v * sin(angle);
            gp_deposit_add(d, x, y, part);
            gp_deposit_add(d, -x, y, part);
            gp_deposit_add(d, x, -y, part);
            gp_deposit_add(d, -x, -y, part);
        }
        if (column <= 0 && row > rows)
            return;
        from = fmax(from, to);
        if (column > 0 && by_column <= by_row)
            column--;
        else
            row++;
    }
}

void gp_deposit_rings(const struct gp_deposit *d, gp_profile p,
    const void *ctx, const struct gp_field *f, double from, double to,
    double light[3])
{
    const struct gp_gauss *const g = gp_gauss_rule(6);
    const double b = f->degrees, a = b * f->aspect;
    while (from < to) {
        // to where circles begin to reach another column or row
        const double next = fmin(a * floor(from / a * (1.0 + 1e-12) + 1.0),
                                 b * floor(from / b * (1.0 + 1e-12) + 1.0));
        const double end = next < to ? next : to;
        for (int k = 0; k < g->n; k++) {
            // a circle's part beyond a line grows with the root of the distance
            const double root = 0.5 + g->node[k];
            const double t = from + (end - from) * root * root;
            const double ring = 2.0 * PI * t * (end - from) * 2.0 * root *
                                g->weight[k];
            double v[3] = {0};
            p(ctx, t, v);
            for (int c = 0; c < 3; c++) {
                v[c] *= ring;
                light[c] += v[c];
            }
            add_circle(d, t / a, t / b, v);
        }
        from = end;
    }
}
