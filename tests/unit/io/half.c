// SPDX-License-Identifier: Apache-2.0
/* core/half: every half, and every place where rounding could go wrong. */
#include "unit.h"
#include "core/bytes.h"
#include "core/half.h"

enum { HALFS = 65536 };

/* The definition of binary16, by ldexp; NaN is left to the caller. */
static double half_value(unsigned h)
{
    int exponent = (int) (h >> 10 & 31), mantissa = (int) (h & 1023);
    double v = exponent == 31 ? (double) INFINITY
               : exponent ? ldexp(1024 + mantissa, exponent - 25)
                          : ldexp(mantissa, -24);
    return h & 0x8000 ? -v : v;
}

static int half_is_nan(unsigned h)
{
    return (h & 0x7c00) == 0x7c00 && (h & 1023);
}

static void all_halfs_to_float(void **state)
{
    static uint16_t in[HALFS];
    static float out[HALFS];
    for (unsigned h = 0; h < HALFS; h++)
        in[h] = (uint16_t) h;
    gp_half_to_float(in, out, HALFS);
    for (unsigned h = 0; h < HALFS; h++) {
        if (half_is_nan(h)) {
            assert_true(isnan(out[h]));
            assert_int_equal(gp_bits_of(out[h]) >> 31, h >> 15);
            assert_int_equal(gp_bits_of(out[h]) >> 13 & 0x1ff, h & 0x1ff);
            continue;
        }
        assert_true((double) out[h] == half_value(h));
        assert_int_equal(gp_bits_of(out[h]) >> 31, h >> 15); // -0
    }
}

/* Between two neighbours the tie goes to the even one, and the floats next
 * to the tie to the nearer one. */
static void rounding_is_to_nearest_even(void **state)
{
    for (unsigned h = 0; h < 0x7bff; h++) {
        double low = half_value(h), high = half_value(h + 1);
        float tie = (float) ((low + high) / 2);
        float in[6] = {nextafterf(tie, 0), tie, nextafterf(tie, 1e30f)};
        uint16_t out[6];
        for (int i = 0; i < 3; i++)
            in[3 + i] = -in[i];
        assert_int_equal(gp_float_to_half(in, out, 6), 0);
        unsigned want[3] = {h, h & 1 ? h + 1 : h, h + 1};
        for (int i = 0; i < 3; i++) {
            assert_int_equal(out[i], want[i]);
            assert_int_equal(out[3 + i], want[i] | 0x8000);
        }
    }
}

static void large_values_are_clamped_and_counted(void **state)
{
    static const struct {
        float in;
        unsigned out;
        size_t clamped;
    } row[] = {
        {65504.0f, 0x7bff, 0},      {65519.996f, 0x7bff, 0},
        {65520.0f, 0x7bff, 1},      {-65520.0f, 0xfbff, 1},
        {3.4028235e38f, 0x7bff, 1}, {-3.4028235e38f, 0xfbff, 1},
        {INFINITY, 0x7c00, 0},      {-INFINITY, 0xfc00, 0},
        {0.0f, 0, 0},               {-0.0f, 0x8000, 0},
        {1e-45f, 0, 0},             {2.9802322e-8f, 0, 0},
        {2.9802326e-8f, 1, 0},      {-5.9604645e-8f, 0x8001, 0},
        {6.1035156e-5f, 0x0400, 0}, {6.0975552e-5f, 0x03ff, 0},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        // once in the tail and once in a whole vector
        float in[11];
        uint16_t out[11];
        for (int k = 0; k < 11; k++)
            in[k] = row[i].in;
        assert_int_equal(gp_float_to_half(in, out, 11), 11 * row[i].clamped);
        for (int k = 0; k < 11; k++)
            assert_int_equal(out[k], row[i].out);
    }
}

static void nan_stays_nan(void **state)
{
    static const uint32_t in_bits[] = {0x7fc00000, 0x7f800001, 0xffc00001,
                                       0xff812345, 0x7fffffff};
    for (size_t i = 0; i < COUNT(in_bits); i++) {
        float in[9];
        uint16_t out[9];
        for (int k = 0; k < 9; k++)
            in[k] = gp_float_with_bits(in_bits[i]);
        assert_int_equal(gp_float_to_half(in, out, 9), 0);
        for (int k = 0; k < 9; k++) {
            assert_true(half_is_nan(out[k]));
            assert_int_equal(out[k] >> 15, in_bits[i] >> 31);
            assert_true(isnan(gp_half_nearest(in[k])));
        }
    }
}

static void a_row_is_its_values(void **state)
{
    static const float odd[] = {65519.0f, 65520.0f, -1e9f,
                                INFINITY, NAN,      -6e-8f};
    enum { N = 43 };
    float in[N];
    uint16_t all[N], one;
    for (int place = 0; place < N * (int) COUNT(odd); place++) {
        size_t clamped = 0;
        for (int i = 0; i < N; i++)
            in[i] = i == place % N ? odd[place / N] : 0.37f * (float) i - 5.0f;
        const size_t counted = gp_float_to_half(in, all, N);
        for (int i = 0; i < N; i++) {
            clamped += gp_float_to_half(&in[i], &one, 1);
            assert_int_equal(all[i], one);
        }
        assert_int_equal(counted, clamped);
    }
}

SUITE_OF(half, NULL, NULL, all_halfs_to_float, rounding_is_to_nearest_even,
         large_values_are_clamped_and_counted, nan_stays_nan,
         a_row_is_its_values)
