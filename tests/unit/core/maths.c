// SPDX-License-Identifier: Apache-2.0
/* Own elementary functions: their largest errors against the C library's in long
 * double, and their bits. */
#include "unit.h"
#include "core/maths.h"

#include <float.h>

// each of x and, where it has two arguments, of y
#define OWN(name, call, wide)                                    \
    static double name##_own(double x, double y)                 \
    {                                                            \
        (void) y;                                                \
        return call;                                             \
    }                                                            \
    static long double name##_wide(long double x, long double y) \
    {                                                            \
        (void) y;                                                \
        return wide;                                             \
    }
OWN(exp, gp_exp(x), expl(x))
OWN(exp2, gp_exp2(x), exp2l(x))
OWN(log, gp_log(x), logl(x))
OWN(pow, gp_pow(x, y), powl(x, y))
OWN(sin, gp_sin(x), sinl(x))
OWN(cos, gp_cos(x), cosl(x))
OWN(tan, gp_tan(x), tanl(x))
OWN(atan, gp_atan(x), atanl(x))
OWN(atan2, gp_atan2(x, y), atan2l(x, y))
OWN(asin, gp_asin(x), asinl(x))
OWN(acos, gp_acos(x), acosl(x))
OWN(hypot, gp_hypot(x, y), hypotl(x, y))

/* The header's figures: 2^-53 of a value, or of 1 where it is PLAIN; x is e to the
 * power of numbers in the range where it is of POWERS. */
enum how { RELATIVE, PLAIN, POWERS };
static const struct own {
    const char *name;
    double (*own)(double x, double y);
    long double (*wide)(long double x, long double y);
    enum how how;
    double most, x[2], y[2];
} rows[] = {
#define ROW(name, ...)                              \
    {                                               \
#name, name##_own, name##_wide, __VA_ARGS__ \
    }
    ROW(exp, RELATIVE, 2, {-708, 709}, {0}),
    ROW(exp, RELATIVE, 2, {-1, 1}, {0}),
    ROW(exp2, RELATIVE, 2, {-900, 900}, {0}),
    ROW(log, RELATIVE, 3, {0.5, 2}, {0}),
    ROW(log, POWERS, 3, {-700, 700}, {0}),
    ROW(pow, RELATIVE, 2 + 3 * 7, {0.1, 10}, {-3, 3}), // 3 log(10) is under 7
    ROW(sin, PLAIN, 2, {-7, 7}, {0}),
    ROW(sin, PLAIN, 2, {-1e6, 1e6}, {0}),
    ROW(cos, PLAIN, 2, {-7, 7}, {0}),
    ROW(cos, PLAIN, 2, {-1e6, 1e6}, {0}),
    ROW(tan, RELATIVE, 5, {-7, 7}, {0}),
    ROW(atan, RELATIVE, 3, {-3, 3}, {0}),
    ROW(atan, POWERS, 3, {-90, 90}, {0}),
    ROW(atan2, RELATIVE, 3, {-1, 1}, {-1, 1}),
    ROW(asin, RELATIVE, 5, {-1, 1}, {0}),
    ROW(acos, RELATIVE, 5, {-1, 1}, {0}),
    ROW(hypot, RELATIVE, 2, {-9, 9}, {-9, 9}),
};

static double between(const double range[2])
{
    static uint64_t seed = 1;
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return range[0] + (range[1] - range[0]) * (double) (seed >> 11) * 0x1p-53;
}

static void errors_are_those_of_the_header(void **state)
{
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct own *const r = &rows[i];
        double worst = 0.0, at = 0.0;
        for (int k = 0; k < 40000; k++) {
            const double v = between(r->x), y = between(r->y);
            const double x = r->how == POWERS ? exp(v) : v;
            const long double want = r->wide(x, y);
            const long double off = fabsl(r->own(x, y) - want) /
                                    (r->how == PLAIN ? 1.0L : fabsl(want));
            if ((double) off * 0x1p53 > worst) {
                worst = (double) off * 0x1p53;
                at = x;
            }
        }
        if (!(worst <= r->most))
            fail_msg("%s of %.17g: %.2f, not %g", r->name, at, worst, r->most);
    }
}

static void ends_are_exact(void **state)
{
    static const double turn[2] = {1.0, -1.0};
    assert_true(gp_exp(0.0) == 1.0 && gp_exp(-INFINITY) == 0.0);
    assert_true(isinf(gp_exp(INFINITY)) && isnan(gp_exp(NAN)));
    for (int k = -1070; k < 1024; k++)
        assert_true(gp_exp2(k) == ldexp(1.0, k));
    assert_true(isinf(gp_exp2(1e9)) && gp_exp2(-1e9) == 0.0);
    assert_true(gp_log(1.0) == 0.0 && gp_log(0.0) == -INFINITY);
    assert_true(isinf(gp_log(INFINITY)) && isnan(gp_log(NAN)));
    assert_true(gp_pow(0.0, 3.0) == 0.0 && gp_pow(1.0, 3.0) == 1.0);
    assert_true(gp_pow(0.0, 0.0) == 1.0);
    assert_true(gp_sin(0.0) == 0.0 && gp_cos(0.0) == 1.0);
    assert_true(gp_atan2(0.0, 0.0) == 0.0 && gp_atan2(0.0, -1.0) == M_PI);
    assert_true(gp_atan(INFINITY) == M_PI / 2 && isnan(gp_acos(1.5)));
    for (int k = 0; k < 2; k++) {
        assert_true(gp_sin(turn[k] * M_PI / 2) == turn[k]);
        assert_true(gp_atan2(turn[k], 0.0) == turn[k] * M_PI / 2);
        assert_true(gp_atan2(turn[k], turn[k]) ==
                    (k ? -3.0 : 1.0) * (M_PI / 4));
    }
}

/* Bits of many results, the same on every processor and by every compiler. */
static void bits_are_the_same_everywhere(void **state)
{
    uint64_t hash = 14695981039346656037u; // FNV-1a
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (int k = 0; k < 1000; k++) {
            const double *const r = rows[i].x;
            const double x = r[0] + k * (r[1] - r[0]) / 999;
            hash = (hash ^ gp_bits_of_double(rows[i].own(x, 0.75))) *
                   1099511628211u;
        }
    }
    assert_true(hash == 0xab8c604d4582b5a5u);
}

SUITE_OF(maths, NULL, NULL, errors_are_those_of_the_header, ends_are_exact,
         bits_are_the_same_everywhere)
