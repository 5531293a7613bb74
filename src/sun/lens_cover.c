/* Polygons by exact coverage: edges add the change of coverage along a row,
 * and running sums along rows make pixels of it. */
#include "sun/lens_priv.h"

#include <math.h>

static inline double least(double a, double b)
{
    return a < b ? a : b;
}

static inline double most(double a, double b)
{
    return a > b ? a : b;
}

static inline void add(double *at, double amount, const double light[3])
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
        add(row + 3 * first, high * (1.0 - right), light);
        add(row + 3 * (first + 1), high * right, light);
        return;
    }
    // each pixel's mean coverage, less that of the pixel before
    const double slope = high / (x1 - x0);
    double before = 0.0;
    for (int i = first; i < end; i++) {
        const double a = most(x0, i), b = least(x1, i + 1.0);
        const double mean = slope * ((b - a) * (i + 1.0 - 0.5 * (a + b)));
        const double whole = slope * (a - x0); // of what ends before a
        add(row + 3 * i, mean + whole - before, light);
        before = mean + whole;
    }
    add(row + 3 * end, high - before, light);
}

/* An edge within [0, w] across, rows [y0, y1). */
static void add_edge(const struct gp_lens_cover *k, double x0, double y0,
                     double x1, double y1, const double light[3])
{
    const double sign = y0 < y1 ? 1.0 : -1.0;
    if (y0 == y1)
        return;
    if (y0 > y1) {
        const double x = x0, y = y0;
        x0 = x1;
        y0 = y1;
        x1 = x;
        y1 = y;
    }
    const double step = (x1 - x0) / (y1 - y0);
    const double from = most(y0, k->y0), to = least(y1, k->y1);
    const double low = least(x0, x1), high = most(x0, x1);
    double x = least(most(x0 + step * (from - y0), low), high);
    int row = (int) from; // over 0
    double *at = k->v + 3 * (size_t) (row - k->top) * (size_t) (k->w + 2);
    for (double y = from; y < to; row++, at += 3 * (k->w + 2)) {
        const double next = least(row + 1.0, to);
        const double after = least(most(x + step * (next - y), low), high);
        add_in_row(at, least(x, after), most(x, after), sign * (next - y),
                   light);
        x = after;
        y = next;
    }
}

/* Cuts an edge at a column, and adds the parts; those beyond lie on it. */
static void add_clipped(const struct gp_lens_cover *k, double x0, double y0,
                        double x1, double y1, const double light[3])
{
    const double side[2] = {0.0, k->w};
    if (!(most(y0, y1) > k->y0 && least(y0, y1) < k->y1) ||
        least(x0, x1) >= k->w) // what lies to its right is not seen
        return;
    for (int i = 0; i < 2; i++) {
        if ((x0 < side[i]) == (x1 < side[i]))
            continue;
        const double y = y0 + (y1 - y0) * (side[i] - x0) / (x1 - x0);
        add_clipped(k, x0, y0, side[i] + (x0 < side[i] ? -1e-12 : 0.0), y,
                    light);
        add_clipped(k, side[i] + (x1 < side[i] ? -1e-12 : 0.0), y, x1, y1,
                    light);
        return;
    }
    x0 = least(most(x0, 0.0), k->w);
    x1 = least(most(x1, 0.0), k->w);
    add_edge(k, x0, y0, x1, y1, light);
}

/* Adds light to the pixel of a point. */
static void add_point(const struct gp_lens_cover *k, const double p[2],
                      const double light[3])
{
    if (!(p[0] >= 0.0 && p[0] < k->w && p[1] >= k->y0 && p[1] < k->y1))
        return;
    double *const at = k->v + 3 * ((size_t) ((int) p[1] - k->top) *
                                   (size_t) (k->w + 2) + (size_t) p[0]);
    add(at, 1.0, light);
    add(at + 3, -1.0, light);
}

void gp_lens_cover_edge(const struct gp_lens_cover *k, const double a[2],
                        const double b[2], const double light[3])
{
    add_clipped(k, a[0], a[1], b[0], b[1], light);
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
        add_clipped(k, a[0], a[1], b[0], b[1], each);
    }
}
