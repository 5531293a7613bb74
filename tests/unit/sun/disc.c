/* sun/disc: the area of a disc in a pixel by quadrature and by laws, and the
 * samples of a disc. */
#include "unit.h"
#include "sun/sun_priv.h"
#include "sun/occluder.h"

static unsigned next_random(unsigned *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

/* In [0, 1). */
static double uniform(unsigned *seed)
{
    return (double) next_random(seed) * 0x1p-24;
}

static void assert_near(double got, double want, double bar, const char *what,
                        double detail)
{
    if (!(fabs(got - want) <= bar))
        fail_msg("%s (%g): %.17g, not %.17g: %g over %g", what, detail, got,
                 want, fabs(got - want), bar);
}

/* -- area in a pixel, by quadrature ---------------------------------------- */

/* A disc and a pixel in whole sixteenths, so that what is squared is exact. */
struct exact_case {
    long long dx, dy, r; // pixel's corner from the centre
};

/* The roots of t^2 + 2 u t + g = 0 without cancellation, where u^2 - g is
 * `square`; false for none. */
static bool roots(double u, double g, double square, double out[2])
{
    if (!(square > 0.0))
        return false;
    const double half = sqrt(square);
    out[u < 0.0] = u < 0.0 ? half - u : -u - half;
    out[!(u < 0.0)] = g / out[u < 0.0];
    return true;
}

/* Covered height of the pixel's column at s from its left side. */
static double height_at(const struct exact_case *c, double s)
{
    const double dx = (double) c->dx / 16, dy = (double) c->dy / 16;
    const double g = (double) (c->dx * c->dx + c->dy * c->dy - c->r * c->r) /
                     256;
    const double square = ((double) (c->r - c->dx) / 16 - s) *
                          ((double) (c->r + c->dx) / 16 + s);
    double t[2];
    if (!roots(dy, g + 2.0 * dx * s + s * s, square, t))
        return 0.0;
    return fmax(fmin(t[1], 1.0) - fmax(t[0], 0.0), 0.0);
}

/* Simpson's rule over a piece without kinks; both ends are approached as a
 * square, which makes the square roots there smooth. */
static double integral(const struct exact_case *c, double a, double b)
{
    enum { STEPS = 8192 };
    double sum = 0.0;
    for (int i = 0; i <= STEPS; i++) {
        const double t = (double) i / STEPS;
        const double s = a + (b - a) * t * t * (3.0 - 2.0 * t);
        const double weight = i == 0 || i == STEPS ? 1.0 : i % 2 ? 4.0 : 2.0;
        sum += weight * 6.0 * t * (1.0 - t) * height_at(c, s);
    }
    return (b - a) * sum / (3.0 * STEPS);
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

static double area_by_quadrature(const struct exact_case *c)
{
    // kinks: where the circle crosses the pixel's top and bottom, and its ends
    double cut[8] = {0.0, 1.0, (double) (c->r - c->dx) / 16,
                     (double) (-c->r - c->dx) / 16};
    int n = 4;
    for (long long line = c->dy; line <= c->dy + 16; line += 16) {
        const double g = (double) (c->dx * c->dx + line * line -
                                   c->r * c->r) / 256;
        const double square = (double) ((c->r - line) * (c->r + line)) / 256;
        n += roots((double) c->dx / 16, g, square, cut + n) ? 2 : 0;
    }
    for (int i = 0; i < n; i++)
        cut[i] = fmin(fmax(cut[i], 0.0), 1.0);
    qsort(cut, (size_t) n, sizeof *cut, by_value);
    double sum = 0.0;
    for (int i = 1; i < n; i++)
        sum += cut[i] > cut[i - 1] ? integral(c, cut[i - 1], cut[i]) : 0.0;
    return sum;
}

static void test_pixel_area(void **state)
{
    (void) state;
    static const long long radii[] = {1,   3,    8,     16,     23,     39,
                                      160, 1001, 16000, 160007, 1600000};
    unsigned seed = 20071u;
    for (size_t k = 0; k < sizeof radii / sizeof *radii; k++) {
        for (int i = 0; i < 40; i++) {
            const double r = (double) radii[k] / 16;
            // a pixel near the edge, at axes and between
            const double turn = i < 8 ? i * M_PI_4 : uniform(&seed) * 2 * M_PI;
            const double fx = (double) (next_random(&seed) % 16) / 16;
            const double fy = (double) (next_random(&seed) % 16) / 16;
            const int x = (int) floor(fx + r * cos(turn));
            const int y = (int) floor(fy + r * sin(turn)) - (i % 3 == 2);
            const struct exact_case c = {(long long) (16 * (x - fx)),
                                         (long long) (16 * (y - fy)),
                                         radii[k]};
            assert_near(gp_disc_pixel_area(fx, fy, r, x, y),
                        area_by_quadrature(&c), 1e-12, "area, radius", r);
        }
    }
}

/* -- laws of areas --------------------------------------------------------- */

static double sum_of_pixels(double cx, double cy, double r)
{
    double sum = 0.0;
    for (int y = (int) floor(cy - r) - 1; y <= (int) ceil(cy + r); y++) {
        for (int x = (int) floor(cx - r) - 1; x <= (int) ceil(cx + r); x++)
            sum += gp_disc_pixel_area(cx, cy, r, x, y);
    }
    return sum;
}

/* Centres on corners, on edges, a hair beside them, anywhere. */
static const double centres[][2] = {
    {0, 0}, {0.5, 0.5}, {0.5, 0}, {1, 0.25}, {0x1.fffffffffffffp-1, 7},
    {1 + 0x1p-52, 1 - 0x1p-53}, {1e-20, -1e-20}, {0.3, 0.7},
    {-0.3, 100.123456789}, {283.2402801513672, 129.05892848968506},
    {-1000.4999999, 2047.0000001}, {99999.7, -99999.1}};
static const double law_radii[] = {1e-3, 0.01, 0.3, 0.5, M_SQRT1_2, 1, 1.5,
                                   M_SQRT2, 2.480712533280226, 17.3, 60};
enum {
    CENTRES = sizeof centres / sizeof *centres,
    LAW_RADII = sizeof law_radii / sizeof *law_radii
};

static void test_area_sum(void **state)
{
    (void) state;
    for (int c = 0; c < CENTRES; c++) {
        for (int k = 0; k < LAW_RADII; k++) {
            const double r = law_radii[k], want = M_PI * r * r;
            assert_near(sum_of_pixels(centres[c][0], centres[c][1], r), want,
                        1e-12 * want, "sum of areas, radius", r);
        }
    }
}

/* Whole pixels, reflections and the diagonal change nothing. */
static void test_area_symmetry(void **state)
{
    (void) state;
    unsigned seed = 77;
    for (int i = 0; i < 4000; i++) {
        const double r = law_radii[i % LAW_RADII] * (1.0 + i % 3);
        const double cx = uniform(&seed), cy = uniform(&seed);
        const int reach = (int) r + 2;
        const int x = (int) (uniform(&seed) * 2 * reach) - reach;
        const int y = (int) (uniform(&seed) * 2 * reach) - reach;
        const double want = gp_disc_pixel_area(cx, cy, r, x, y);
        assert_true(want >= 0.0 && want <= 1.0);
        assert_near(gp_disc_pixel_area(cx + 4096, cy - 512, r, x + 4096,
                                       y - 512), want, 2e-12, "moved", r);
        assert_near(gp_disc_pixel_area(-cx, cy, r, -x - 1, y), want, 1e-14,
                    "left and right", r);
        assert_near(gp_disc_pixel_area(cx, -cy, r, x, -y - 1), want, 1e-14,
                    "up and down", r);
        assert_near(gp_disc_pixel_area(cy, cx, r, y, x), want, 1e-14,
                    "diagonal", r);
    }
}

/* Circles through a corner, which the edges on its two sides may find in or
 * out each for itself: four pixels are the square that they make. */
static void test_area_corner(void **state)
{
    (void) state;
    static const double hard[][4] = {
        {0x1.4b00a5f6498ep-1, 0x1.86fce2dae58cp-1, 2, 3},
        {0x1.80de57310c6cp-2, 0x1.c91a4c9b5228p-2, 1, -1},
        {0x1.4d0f142fc826p-1, 0x1.3fa7f4c9711p-3, 2, 9},
        {0x1.071431436786p-1, 0x1.0b632c3d7824p-1, -13, -7},
        {0x1.4ccb6a63d66cp-2, 0x1.31254add50ap-4, 2, -2}};
    unsigned seed = 41;
    for (int i = 0; i < 20000; i++) {
        const double cx = i < 5 ? hard[i][0] : uniform(&seed);
        const double cy = i < 5 ? hard[i][1] : uniform(&seed);
        const int x = (int) (i < 5 ? hard[i][2] : 40 * uniform(&seed) - 20);
        const int y = (int) (i < 5 ? hard[i][3] : 40 * uniform(&seed) - 20);
        const double r = hypot(x - cx, y - cy);
        double sum = 0.0;
        for (int k = 0; k < 4; k++)
            sum += gp_disc_pixel_area(cx, cy, r, x - k % 2, y - k / 2);
        assert_near(sum, gp_disc_rect_area(cx, cy, r, x - 1, y - 1, x + 1,
                                           y + 1), 1e-13, "corner", i);
    }
}

static void test_area_grows(void **state)
{
    (void) state;
    double last = 0.0;
    for (int i = 0; i <= 4000; i++) {
        const double area = gp_disc_pixel_area(0.3, 0.6, i / 2000.0, 0, 0);
        assert_true(area >= last - 1e-15);
        last = area;
    }
    assert_near(last, 1.0, 0.0, "a pixel inside", 2);
}

static void test_area_hard(void **state)
{
    (void) state;
    const double inf = (double) INFINITY, nan = (double) NAN;
    assert_near(gp_disc_pixel_area(0.5, 0.5, 0.5, 0, 0), M_PI / 4, 1e-15,
                "touches all sides", 0.5);
    assert_near(gp_disc_pixel_area(0, 0, 1, 0, 0), M_PI / 4, 1e-15, "quarter",
                1);
    assert_near(gp_disc_pixel_area(0, 0, M_SQRT2 * 1.0000001, 0, 0), 1, 0,
                "over the corner", 0);
    const struct {
        double cx, cy, r;
    } none[] = {{0, 0, 0},    {0, 0, -1},  {0, 0, nan}, {nan, 0, 1},
                {0, nan, 1},  {-1, 0, 1},  {2, 0.5, 1}, {-1, -1, M_SQRT2},
                {1e300, 0, 1}, {inf, 0, 5}, {0, -inf, 5}};
    for (size_t i = 0; i < sizeof none / sizeof *none; i++)
        assert_near(gp_disc_pixel_area(none[i].cx, none[i].cy, none[i].r, 0,
                                       0), 0, 1e-15, "no area", (double) i);
    assert_near(gp_disc_pixel_area(INT32_MAX + 0.5, INT32_MIN + 0.5, 9,
                                   INT32_MAX, INT32_MIN), 1, 0, "far", 9);
}

/* A rectangle holds what its pixels hold. */
static void test_rect_area(void **state)
{
    (void) state;
    unsigned seed = 3;
    for (int i = 0; i < 300; i++) {
        const double cx = 40 * uniform(&seed), cy = 40 * uniform(&seed);
        const double r = pow(10.0, -2 + 4 * uniform(&seed));
        const int x0 = (int) (40 * uniform(&seed));
        const int y0 = (int) (40 * uniform(&seed));
        const int x1 = x0 + (int) (30 * uniform(&seed));
        const int y1 = y0 + (int) (30 * uniform(&seed));
        double want = 0.0;
        for (int y = y0; y < y1; y++) {
            for (int x = x0; x < x1; x++)
                want += gp_disc_pixel_area(cx, cy, r, x, y);
        }
        assert_near(gp_disc_rect_area(cx, cy, r, x0, y0, x1, y1), want,
                    1e-13 + 1e-12 * want, "rectangle, radius", r);
    }
}

/* -- samples of a disc ----------------------------------------------------- */

/* Cells of (u, v) cover equal areas: sectors and rings hold their share. */
static void test_disc_samples(void **state)
{
    (void) state;
    enum { N = 256 };
    int ring[4] = {0}, sector[8] = {0};
    double sum_x = 0.0, sum_y = 0.0;
    for (int j = 0; j < N; j++) {
        for (int i = 0; i < N; i++) {
            double x, y, sx, sy;
            const double u = (i + 0.5) / N, v = (j + 0.5) / N;
            gp_pattern_place(GP_PATTERN_DISC, u, v, &x, &y);
            gp_pattern_place(GP_PATTERN_SQUARE, u, v, &sx, &sy);
            assert_true(sx == 2 * u - 1 && sy == 2 * v - 1);
            assert_near(hypot(x, y), fmax(fabs(sx), fabs(sy)), 1e-15,
                        "radius", u);
            ring[(int) (4 * (x * x + y * y))]++;
            sector[(int) (atan2(y, x) / M_PI_4 + 4.0)]++;
            sum_x += x;
            sum_y += y;
        }
    }
    for (int i = 0; i < 4; i++)
        assert_near(ring[i] / (double) (N * N), 0.25, 0.01, "ring", i);
    for (int i = 0; i < 8; i++)
        assert_near(sector[i] / (double) (N * N), 0.125, 0.002, "sector", i);
    assert_near(sum_x, 0, 1e-9, "mean x", N);
    assert_near(sum_y, 0, 1e-9, "mean y", N);
}

static void test_disc_ends(void **state)
{
    (void) state;
    static const double at[][4] = {{0.5, 0.5, 0, 0}, {0, 0.5, -1, 0},
                                   {1, 0.5, 1, 0},   {0.5, 0, 0, -1},
                                   {0, 0, -M_SQRT1_2, -M_SQRT1_2}};
    for (int i = 0; i < 5; i++) {
        double x, y;
        gp_pattern_place(GP_PATTERN_DISC, at[i][0], at[i][1], &x, &y);
        assert_near(x, at[i][2], 1e-15, "x", i);
        assert_near(y, at[i][3], 1e-15, "y", i);
    }
}

SUITE_OF(disc, NULL, NULL,
    test_pixel_area, test_area_sum, test_area_symmetry, test_area_grows,
    test_area_corner, test_area_hard, test_rect_area, test_disc_samples,
    test_disc_ends)
