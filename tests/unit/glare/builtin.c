/* glare/builtin.c: laws that hold for each builtin kernel, and its formula. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/builtin.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define COUNT(a) (sizeof(a) / sizeof *(a))

static struct gp_kernel make(const char *name, int size)
{
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_kernel k;
    p.source = name;
    p.builtin_size = size;
    if (gp_kernel_builtin(NULL, &p, &k) != GP_OK)
        fail_msg("%s at size %d", name, size);
    return k;
}

static double at(const struct gp_kernel *k, int c, int dx, int dy)
{
    const int x = k->cx + dx, y = k->cy + dy;
    return x >= 0 && x < k->w && y >= 0 && y < k->h
               ? (double) k->k.c[c][(size_t) y * (size_t) k->w + (size_t) x]
               : 0.0;
}

static double luminance(const struct gp_kernel *k)
{
    return 0.2126 * k->sum[0] + 0.7152 * k->sum[1] + 0.0722 * k->sum[2];
}

/* Each builtin at each size holds light, no negative and no tiny value (which
 * a CPU is slow with), sums to 1 in luminance, and is the same turned by half
 * a turn. */
static void are_light(void **state)
{
    static const int sizes[] = {1, 3, 5, 31, 65, 255, 511};
    (void) state;
    for (const struct gp_builtin_kernel *b = gp_builtin_kernels; b->name; b++) {
        for (size_t i = 0; i < COUNT(sizes); i++) {
            struct gp_kernel k = make(b->name, sizes[i]);
            assert_true(fabs(luminance(&k) - 1.0) < 1e-6);
            assert_true(k.cx < k.w && k.cy < k.h && k.cx >= 0 && k.cy >= 0);
            const int n = k.w * k.h;
            for (int c = 0; c < 3; c++) {
                for (int j = 0; j < n; j++) {
                    const float v = k.k.c[c][j], w = k.k.c[c][n - 1 - j];
                    if (!(v == 0.0f || v >= FLT_MIN) ||
                        !(fabsf(v - w) <= 1e-5f * v + 1e-12f))
                        fail_msg("%s at size %d: sample %d is %g, %g opposite",
                                 b->name, sizes[i], j, (double) v, (double) w);
                }
            }
            gp_kernel_free(&k);
        }
    }
}

/* Nothing ends at once: no step on the kernel's own border, seen against its
 * largest value, for kernels with room to fade. */
static void end_softly(void **state)
{
    (void) state;
    for (const struct gp_builtin_kernel *b = gp_builtin_kernels; b->name; b++) {
        struct gp_kernel k = make(b->name, 511);
        double peak = 0.0, border = 0.0;
        for (int y = 0; y < k.h; y++) {
            for (int x = 0; x < k.w; x++) {
                const bool edge = x == 0 || y == 0 || x == k.w - 1 ||
                                  y == k.h - 1;
                for (int c = 0; c < 3; c++) {
                    const double v = at(&k, c, x - k.cx, y - k.cy);
                    peak = fmax(peak, v);
                    border = fmax(border, edge ? v : 0.0);
                }
            }
        }
        if (!(border <= 1e-2 * peak))
            fail_msg("%s: %g on its border, %g at its peak", b->name, border,
                     peak);
        gp_kernel_free(&k);
    }
}

static void have_their_colours(void **state)
{
    static const struct {
        const char *name;
        bool grey;
    } rows[] = {{"eye", true}, {"streak", false}, {"star", false},
                {"cross", true}, {"circle", true}, {"ring", false}};
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel k = make(rows[i].name, 255);
        assert_int_equal(k.grey, rows[i].grey);
        gp_kernel_free(&k);
    }
    struct gp_kernel k = make("streak", 511);
    assert_true(k.sum[2] > 2.0 * k.sum[1] && k.sum[1] > k.sum[0]);
    gp_kernel_free(&k);
    k = make("ring", 511); // by the sequence of wavelengths, from within
    for (int c = 0; c < 3; c++) {
        static const int radius[3] = {113, 102, 86};
        for (int other = 0; other < 3; other++)
            assert_true(at(&k, c, radius[c], 0) >=
                        at(&k, other, radius[c], 0));
    }
    assert_true(at(&k, 1, 0, 0) == 0.0);
    gp_kernel_free(&k);
}

/* The header's formulas, by ratios of samples within half the radius, where
 * nothing has faded. */
static void follow_their_formulas(void **state)
{
    const double r = 511 / 2.0;
    static const double l[3] = {0.15, 0.2, 0.3};
    (void) state;
    struct gp_kernel k = make("builtin:streak", 511);
    for (int c = 0; c < 3; c++) {
        const double got = at(&k, c, 100, 0) / at(&k, c, 0, 0);
        assert_true(fabs(got / exp(-100.0 / (l[c] * r)) - 1.0) < 1e-5);
        assert_true(at(&k, c, -100, 0) == at(&k, c, 100, 0));
        assert_true(at(&k, c, 100, 6) == 0.0);
    }
    gp_kernel_free(&k);
    k = make("cross", 511);
    assert_true(fabs(at(&k, 0, 100, 0) / at(&k, 0, 50, 0) /
                     exp(-50.0 / (0.2 * r)) - 1.0) < 1e-5);
    assert_true(at(&k, 0, 100, 0) == at(&k, 0, 0, -100));
    gp_kernel_free(&k);
    k = make("star", 511); // its rays stand at 90, 30 and 150 degrees
    const double u = 100.0 / (r / 40.0), v = 50.0 / (r / 40.0);
    assert_true(fabs(at(&k, 1, 0, 100) / at(&k, 1, 0, 50) /
                     ((1.0 + v * v) / (1.0 + u * u)) - 1.0) < 1e-5);
    assert_true(at(&k, 0, 0, 100) > at(&k, 2, 0, 100));
    assert_true(at(&k, 1, 87, 50) > 0.5 * at(&k, 1, 0, 100));
    assert_true(at(&k, 1, 100, 0) == 0.0);
    gp_kernel_free(&k);
    k = make("circle", 511);
    assert_true(at(&k, 0, 0, 0) == at(&k, 0, 111, 0));
    assert_true(fabs(at(&k, 0, 120, 0) / at(&k, 0, 0, 0) - 0.4774) < 1e-2);
    assert_true(at(&k, 0, 128, 0) == 0.0);
    gp_kernel_free(&k);
}

static void are_the_same_for_any_threads(void **state)
{
    (void) state;
    for (const struct gp_builtin_kernel *b = gp_builtin_kernels; b->name; b++) {
        gp_set_threads(1);
        struct gp_kernel first = make(b->name, 129);
        gp_set_threads(5);
        struct gp_kernel k = make(b->name, 129);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(k.k.c[c], first.k.c[c],
                                (size_t) (k.w * k.h) * sizeof(float));
        gp_kernel_free(&k);
        gp_kernel_free(&first);
    }
    gp_set_threads(0);
}

SUITE(builtin)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(are_light),
        cmocka_unit_test(end_softly),
        cmocka_unit_test(have_their_colours),
        cmocka_unit_test(follow_their_formulas),
        cmocka_unit_test(are_the_same_for_any_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
