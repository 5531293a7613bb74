/* glare/eye.c against brute-force quadrature and closed forms. */
#include "unit.h"
#include "glare/eye.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define COUNT(a) (sizeof(a) / sizeof *(a))
#define PI 3.14159265358979323846
#define RADIAN (PI / 180.0)

static void assert_close(double got, double want, double relative)
{
    if (!(fabs(got - want) <= relative * fabs(want)))
        fail_msg("%.15g, not %.15g within %g of it", got, want, relative);
}

/* Spencer et al. 1995, as printed: degrees in, per steradian out. */
static double f0(double t)
{
    return 2.61e6 * exp(-(t / 0.02) * (t / 0.02));
}

static double f1(double t)
{
    return 20.91 / pow(t + 0.02, 3.0);
}

static double f2(double t)
{
    return 72.37 / pow(t + 0.02, 2.0);
}

static double photopic(double t)
{
    return 0.384 * f0(t) + 0.478 * f1(t) + 0.138 * f2(t);
}

/* Five-point Gauss-Legendre over a cell, in pixels. */
static double cell(double x, double y, double side)
{
    static const double node[5] = {
        -0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
        0.906179845938664,
    };
    static const double weight[5] = {
        0.236926885056189, 0.478628670499366, 0.568888888888889,
        0.478628670499366, 0.236926885056189,
    };
    const double pitch = GP_EYE_DEGREES_PER_PIXEL;
    double sum = 0.0;
    for (int j = 0; j < 5; j++) {
        for (int i = 0; i < 5; i++)
            sum += weight[i] * weight[j] *
                   photopic(pitch * hypot(x + 0.5 * side * (1 + node[i]),
                                          y + 0.5 * side * (1 + node[j])));
    }
    return 0.25 * sum * side * side * pitch * pitch * RADIAN * RADIAN;
}

/* Quarters every cell that is wide for its distance from the cusp. */
static double brute(double x, double y, double side)
{
    double dx = x > 0 ? x : x + side < 0 ? -(x + side) : 0.0;
    double dy = y > 0 ? y : y + side < 0 ? -(y + side) : 0.0;
    if (side < 1e-9)
        return 0.0; // 1e-18 of the pixel's area, at most 1e-15 of its light
    if (side <= 0.25 && side <= 0.5 * hypot(dx, dy))
        return cell(x, y, side);
    double h = 0.5 * side;
    return brute(x, y, h) + brute(x + h, y, h) + brute(x, y + h, h) +
           brute(x + h, y + h, h);
}

static void eye_is_integrated(void **state)
{
    static const int rows[][2] = {
        {0, 0},   {1, 0},   {1, 1},   {2, 0},    {2, 2},   {3, 1},    {4, 4},
        {5, 0},   {5, 5},   {7, 3},   {11, 0},   {12, 0},  {12, 12},  {15, 4},
        {16, 1},  {23, 0},  {24, 0},  {24, 24},  {40, 7},  {100, 99}, {255, 0},
        {255, 255},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        int x = rows[i][0], y = rows[i][1];
        assert_close(gp_eye_share(x, y), brute(x - 0.5, y - 0.5, 1.0), 1e-10);
    }
}

/* The centre of the pixel instead of its mean would be wrong by this much. */
static void eye_is_not_sampled(void **state)
{
    const double pitch = GP_EYE_DEGREES_PER_PIXEL;
    const double area = pitch * pitch * RADIAN * RADIAN;
    (void) state;
    assert_true(photopic(0.0) * area > 1.9 * gp_eye_share(0, 0));
    assert_true(photopic(pitch) * area < 0.95 * gp_eye_share(1, 0));
}

static void eye_is_symmetric_to_the_bit(void **state)
{
    static const int rows[][2] = {{3, 1}, {17, 16}, {255, 254}, {9, 0}};
    struct gp_planes k;
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        int x = rows[i][0], y = rows[i][1];
        double share = gp_eye_share(x, y);
        assert_true(share == gp_eye_share(-x, y));
        assert_true(share == gp_eye_share(y, x));
        assert_true(share == gp_eye_share(-y, -x));
    }
    enum { N = 91 };
    assert_int_equal(gp_eye_make(NULL, N, &k), GP_OK);
    for (int y = 0; y < N; y++) {
        for (int x = 0; x < N; x++) {
            float v = k.c[0][y * N + x];
            assert_true(v == k.c[0][x * N + y]);
            assert_true(v == k.c[0][y * N + (N - 1 - x)]);
            assert_true(v == k.c[1][y * N + x] && v == k.c[2][y * N + x]);
            assert_true(v == (float) gp_eye_share(x - N / 2, y - N / 2));
        }
    }
    gp_planes_free(&k);
}

static void eye_falls_on_every_side(void **state)
{
    struct gp_planes k;
    enum { N = 511, C = N / 2 };
    (void) state;
    assert_int_equal(gp_eye_make(NULL, N, &k), GP_OK);
    for (int y = C; y < N; y++) {
        for (int x = C; x < N - 1; x++)
            assert_true(k.c[0][y * N + x + 1] < k.c[0][y * N + x]);
    }
    gp_planes_free(&k);
}

/* Light inside the circle of t degrees, closed form of photopic(). */
static double inside_circle(double t)
{
    const double a = 0.02, s = t + a;
    double g0 = 2.61e6 * 0.5 * a * a * (1.0 - exp(-(t / a) * (t / a)));
    double g1 = 20.91 * t * t / (2.0 * a * s * s);
    double g2 = 72.37 * (log(s / a) - t / s);
    return 2.0 * PI * RADIAN * RADIAN * (0.384 * g0 + 0.478 * g1 + 0.138 * g2);
}

/* The share inside a square of n pixels: eight triangles, each a mean of
 * circles, by the midpoint rule in the angle. */
static double inside_square(int n)
{
    const int steps = 20000;
    const double h = 0.5 * n * GP_EYE_DEGREES_PER_PIXEL;
    double sum = 0.0;
    for (int i = 0; i < steps; i++)
        sum += inside_circle(h / cos(PI / 4.0 * (i + 0.5) / steps));
    return sum / steps;
}

static void eye_keeps_all_light_of_its_square(void **state)
{
    static const int sizes[] = {1, 3, 9, 25, 49, 101};
    (void) state;
    for (size_t i = 0; i < COUNT(sizes); i++) {
        double sum = 0.0;
        int reach = sizes[i] / 2;
        for (int y = 0; y <= reach; y++) {
            for (int x = y; x <= reach; x++) {
                int images = (x ? 2 : 1) * (y ? 2 : 1) * (x != y ? 2 : 1);
                sum += images * gp_eye_share(x, y);
            }
        }
        assert_close(sum, inside_square(sizes[i]), 2e-9);
    }
}

static void default_kernel_cuts_off_what_eye_h_says(void **state)
{
    struct gp_planes k;
    double sum = 0.0;
    enum { N = 511 };
    (void) state;
    assert_int_equal(gp_eye_make(NULL, N, &k), GP_OK);
    for (int i = 0; i < N * N; i++)
        sum += (double) k.c[0][i];
    gp_planes_free(&k);
    assert_close(sum, inside_square(N), 5e-8); // float samples
    assert_close(sum, 0.9548, 1e-4);
}

/* The paper's functions are normalised over the hemisphere: a slip in a
 * constant would show. f2 is given to two digits of its integral. */
static void eye_is_the_papers(void **state)
{
    double (*const f[3])(double) = {f0, f1, f2};
    static const double tolerance[3] = {0.002, 0.002, 0.02};
    (void) state;
    for (int k = 0; k < 3; k++) {
        double sum = 0.0, from = 0.0;
        for (double to = 1e-6; from < 90.0; from = to, to *= 1.0005) {
            to = to < 90.0 ? to : 90.0;
            double t = 0.5 * (from + to);
            sum += f[k](t) * 2.0 * PI * sin(t * RADIAN) * (to - from) * RADIAN;
        }
        assert_close(sum, 1.0, tolerance[k]);
    }
}

SUITE(eye)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eye_is_integrated),
        cmocka_unit_test(eye_is_not_sampled),
        cmocka_unit_test(eye_is_symmetric_to_the_bit),
        cmocka_unit_test(eye_falls_on_every_side),
        cmocka_unit_test(eye_keeps_all_light_of_its_square),
        cmocka_unit_test(default_kernel_cuts_off_what_eye_h_says),
        cmocka_unit_test(eye_is_the_papers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
