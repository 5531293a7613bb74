// SPDX-License-Identifier: Apache-2.0
/* Polygons by exact coverage: edges add the change of coverage along a row,
 * whose running sum is light. */
#include "sun/lens_priv.h"

#include "core/minmax.h"

#include <math.h>

static inline void add_light(double *at, double amount, const double light[3])
{
    for (int c = 0; c < 3; c++)
        at[c] += amount * light[c];
}

/* Adds the part of an edge in one row: from x0 to x1 >= x0, both in [0, w],
 * over a height of `high`, negative upwards. */
static void add_in_row(double *row, double x0, double x1, double high,
                       const double light[3])
{
    const int first = (int) x0, end = (int) ceil(x1);
    if (end <= first + 1) {
        const double right = 0.5 * (x0 + x1) - first;
        add_light(row + 3 * first, high * (1.0 - right), light);
        add_light(row + 3 * (first + 1), high * right, light);
        return;
    }
    // each pixel's mean coverage, less that of the pixel before
    const double slope = high / (x1 - x0);
    double before = 0.0;
    for (int i = first; i < end; i++) {
        const double a = gp_maxd(x0, i), b = gp_mind(x1, i + 1.0);
        const double mean = slope * ((b - a) * (i + 1.0 - 0.5 * (a + b)));
        const double whole = slope * (a - x0); // of what ends before a
        add_light(row + 3 * i, mean + whole - before, light);
        before = mean + whole;
    }
    add_light(row + 3 * end, high - before, light);
}

/* An edge within [0, w] across, rows [y0, y1). */
static void add_edge(const struct gp_lens_cover *k, double x0, double y0,
                     double x1, double y1, const double light[3])
{
    if (y0 == y1)
        return;
    const double sign = y0 < y1 ? 1.0 : -1.0, first = y0 < y1 ? x0 : x1;
    const double step = (x1 - x0) / (y1 - y0), top = gp_mind(y0, y1);
    const double from = gp_maxd(top, k->y0);
    const double to = gp_mind(gp_maxd(y0, y1), k->y1);
    const double low = gp_mind(x0, x1), high = gp_maxd(x0, x1);
    double x = gp_mind(gp_maxd(first + step * (from - top), low), high);
    int row = (int) from; // over 0
    double *at = k->v + 3 * (size_t) (row - k->y0) * (size_t) (k->w + 2);
    for (double y = from; y < to; row++, at += 3 * (k->w + 2)) {
        const double next = gp_mind(row + 1.0, to);
        const double after = gp_mind(gp_maxd(x + step * (next - y), low), high);
        add_in_row(at, gp_mind(x, after), gp_maxd(x, after), sign * (next - y),
                   light);
        x = after;
        y = next;
    }
}

/* Adds a part of an edge that is on one side of each column: one before the
 * first lies on it, one from the last on has no samples to its right. */
static void add_beside(const struct gp_lens_cover *k, double x0, double y0,
                       double x1, double y1, const double light[3])
{
    if (gp_maxd(y0, y1) > k->y0 && gp_mind(y0, y1) < k->y1 &&
        gp_mind(x0, x1) < k->w)
        add_edge(k, gp_mind(gp_maxd(x0, 0.0), k->w), y0,
                 gp_mind(gp_maxd(x1, 0.0), k->w), y1, light);
}

// cuts the edge at the first and the last column, and adds its parts
void gp_lens_cover_edge(const struct gp_lens_cover *k, const double a[2],
                        const double b[2], const double light[3])
{
    const double x0 = a[0], y0 = a[1], x1 = b[0], y1 = b[1];
    const double side[2] = {x0 < x1 ? 0.0 : k->w, x0 < x1 ? k->w : 0.0};
    const double slope = (y1 - y0) / (x1 - x0); // used where they differ
    double x = x0, y = y0;
    for (int i = 0; i < 2; i++) {
        if ((x0 < side[i]) == (x1 < side[i]))
            continue;
        const double at = y0 + slope * (side[i] - x0);
        const double end = side[i] + (x0 < side[i] ? -1e-12 : 0.0);
        add_beside(k, x, y, end, at, light);
        x = side[i] + (x1 < side[i] ? -1e-12 : 0.0);
        y = at;
    }
    add_beside(k, x, y, x1, y1, light);
}

/* Adds light to the pixel of a point. */
static void add_point(const struct gp_lens_cover *k, const double p[2],
                      const double light[3])
{
    if (!(p[0] >= 0.0 && p[0] < k->w && p[1] >= k->y0 && p[1] < k->y1))
        return;
    double *const at =
        k->v + 3 * ((size_t) ((int) p[1] - k->y0) * (size_t) (k->w + 2) +
                    (size_t) p[0]);
    add_light(at, 1.0, light);
    add_light(at + 3, -1.0, light);
}

void gp_lens_cover_add(const struct gp_lens_cover *k, const double (*p)[2],
                       int n, const double light[3])
{
    const double thin = 1e-9; // pixels of area: below, a line or a point
    double area = 0.0, each[3];
    for (int i = 0; i < n; i++) {
        const double *const a = p[i], *const b = p[i + 1 < n ? i + 1 : 0];
        area += 0.5 * ((a[0] - p[0][0]) * (b[1] - p[0][1]) -
                       (b[0] - p[0][0]) * (a[1] - p[0][1]));
    }
    if (!(fabs(area) > thin)) {
        for (int c = 0; c < 3; c++)
            each[c] = light[c] / n;
        for (int i = 0; i < n; i++)
            add_point(k, p[i], each);
        return;
    }
    // coverage lies to the right of edges that go down
    for (int c = 0; c < 3; c++)
        each[c] = -light[c] / area;
    for (int i = 0; i < n; i++) {
        const double *const a = p[i], *const b = p[i + 1 < n ? i + 1 : 0];
        gp_lens_cover_edge(k, a, b, each);
    }
}
