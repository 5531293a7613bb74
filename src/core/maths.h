// SPDX-License-Identifier: Apache-2.0
/* Elementary functions that give the same bits everywhere.
 *
 * A C library's differ between its versions, and between processors of one family:
 * with fused multiply-add it rounds otherwise. Here is only what IEEE 754 rounds in
 * one way: + - * / and square roots, by compilers that fuse nothing
 * (-ffp-contract=off). House rule: what makes a layer or a picture takes these, or
 * what the C library has exact, as floor() and fmod().
 *
 * Inline and without branches, so that loops become vectors. Errors are those that
 * build/tests/core maths measures; e is 2^-53. */
#ifndef GP_CORE_MATHS_H
#define GP_CORE_MATHS_H

#include "core/bytes.h"

#include <float.h>
#include <math.h>

/* Added to a double of less than 2^51 it leaves a whole number, the nearest one,
 * in the last bits of the sum. */
#define GP_WHOLE 0x1.8p52

#define GP_LN2_HIGH 0x1.62e42fefp-1 // times a whole number it is exact
#define GP_LN2_LOW 0x1.473de6af278edp-34

/* e^x within 2 e; 0 under -708, INFINITY over 709. 2^n times Taylor's series of
 * what n = x / ln 2, rounded, leaves: Cody and Waite 1980, chapter 6. */
static inline double gp_exp(double x)
{
    const double sum = x * 1.4426950408889634 + GP_WHOLE, n = sum - GP_WHOLE;
    const double r = (x - n * GP_LN2_HIGH) - n * GP_LN2_LOW;
    const double q = r * r, q2 = q * q;
    // 1 / 2! to 1 / 13!, in short chains
    const double low =
        (1.0 / 2 + r * (1.0 / 6)) + q * (1.0 / 24 + r * (1.0 / 120));
    const double middle =
        (1.0 / 720 + r * (1.0 / 5040)) + q * (1.0 / 40320 + r * (1.0 / 362880));
    const double high = (1.0 / 3628800 + r * (1.0 / 39916800)) +
                        q * (1.0 / 479001600 + r * (1.0 / 6227020800));
    const double series = 1.0 + (r + q * (low + q2 * (middle + q2 * high)));
    const double scale =
        gp_double_with_bits((gp_bits_of_double(sum) + 1023) << 52);
    const double v = series * scale;
    return x < -708.0 ? 0.0 : x > 709.0 ? INFINITY : v;
}

/* 2^x, exact for whole x; within 2 e as far as gp_exp() goes. */
static inline double gp_exp2(double x)
{
    const double n = fmax(fmin(rint(x), 2e3), -2e3);
    return ldexp(gp_exp((x - n) * M_LN2), (int) n);
}

/* The natural logarithm within 3 e; -INFINITY under the normal numbers. With
 * x = 2^n m, m in [sqrt(1/2), sqrt(2)), and s = (m - 1) / (m + 1), log m is
 * 2 atanh s: Abramowitz and Stegun 4.1.27. */
static inline double gp_log(double x)
{
    // n + 1024, from the bits of x over those of sqrt(1/2)
    const uint64_t most = 1024ull << 52, bits = gp_bits_of_double(x);
    const uint64_t n = (bits + (most - 0x3fe6a09e667f3bcd)) >> 52;
    const double e =
        gp_double_with_bits(0x4338000000000000 + n) - (GP_WHOLE + 1024.0);
    const double m = gp_double_with_bits(bits + most - (n << 52));
    const double f = m - 1.0, s = f / (m + 1.0), q = s * s, q2 = q * q;
    const double series =
        (1.0 / 3 + q * (1.0 / 5)) +
        q2 * ((1.0 / 7 + q * (1.0 / 9)) +
              q2 * ((1.0 / 11 + q * (1.0 / 13)) +
                    q2 * (1.0 / 15 + q * (1.0 / 17 + q * (1.0 / 19)))));
    const double v =
        e * GP_LN2_HIGH + (2.0 * s + (2.0 * s * q * series + e * GP_LN2_LOW));
    return x >= DBL_MIN ? (x > DBL_MAX ? x : v) : x < DBL_MIN ? -INFINITY : x;
}

/* x^y of x >= 0 within (2 + 3 |y log x|) e. */
static inline double gp_pow(double x, double y)
{
    return y == 0.0 ? 1.0 : gp_exp(y * gp_log(x));
}

/* sin(x + quarter pi / 2): x less its nearest multiple of pi / 2, in three parts
 * as Cody and Waite, chapter 8, then Taylor's series of sine or cosine. */
static inline double gp_wave(double x, uint64_t quarter)
{
    const double sum = x * (2.0 / M_PI) + GP_WHOLE, n = sum - GP_WHOLE;
    const double r = ((x - n * 0x1.921fb544p+0) - n * 0x1.0b4611a6p-34) -
                     n * 0x1.3198a2e037073p-69;
    const double q = r * r, q2 = q * q, q4 = q2 * q2;
    const double odd = ((-1.0 / 6 + q * (1.0 / 120)) +
                        q2 * (-1.0 / 5040 + q * (1.0 / 362880))) +
                       q4 * ((-1.0 / 39916800 + q * (1.0 / 6227020800)) +
                             q2 * (-1.0 / 1307674368000));
    const double even = ((1.0 / 24 + q * (-1.0 / 720)) +
                         q2 * (1.0 / 40320 + q * (-1.0 / 3628800))) +
                        q4 * ((1.0 / 479001600 + q * (-1.0 / 87178291200)) +
                              q2 * (1.0 / 20922789888000));
    const double sine = r + r * q * odd;
    const double cosine = 1.0 - (0.5 * q - q2 * even);
    const uint64_t turn = gp_bits_of_double(sum) + quarter;
    const double v = turn & 1 ? cosine : sine;
    return turn & 2 ? -v : v;
}

/* Sine and cosine within 2 e, of |x| <= 1e6; their quotient within 5 e of its
 * value. Of one x, both cost little more than one. */
static inline double gp_sin(double x)
{
    return gp_wave(x, 0);
}

static inline double gp_cos(double x)
{
    return gp_wave(x, 1);
}

static inline double gp_tan(double x)
{
    return gp_sin(x) / gp_cos(x);
}

/* The angle of (x, y) in [-pi, pi] within 3 e of its value; 0 of (0, 0). The
 * smaller over the larger of |x| and |y|, turned back by pi / 4 or pi / 8, then the
 * arc tangent's series: Abramowitz and Stegun 4.4.34 and 4.4.42. */
static inline double gp_atan2(double y, double x)
{
    const double a = fabs(x), b = fabs(y);
    const double most = a >= b ? a : b, least = a >= b ? b : a;
    // tangents of pi / 16, pi / 8 and 3 pi / 16
    const int eighth = least > 0.19891236737965800 * most;
    const int fourth = least > 0.66817863791929891 * most;
    const double t = fourth ? 1.0 : eighth ? 0.41421356237309505 : 0.0;
    const double turned = fourth ? M_PI / 4 : eighth ? M_PI / 8 : 0.0;
    const double up = eighth ? least - t * most : least;
    const double z = most > 0.0 ? up / (most + t * least) : most;
    const double q = z * z, q2 = q * q, q4 = q2 * q2;
    const double series =
        ((-1.0 / 3 + q * (1.0 / 5)) + q2 * (-1.0 / 7 + q * (1.0 / 9))) +
        q4 * (((-1.0 / 11 + q * (1.0 / 13)) +
               q2 * (-1.0 / 15 + q * (1.0 / 17))) +
              q4 * (-1.0 / 19 + q * (1.0 / 21)));
    const double angle = turned + (z + z * q * series);
    const double quarter = a >= b ? angle : M_PI / 2 - angle;
    const double half = x < 0.0 ? M_PI - quarter : quarter;
    return y < 0.0 ? -half : half;
}

static inline double gp_atan(double x)
{
    return gp_atan2(x, 1.0);
}

static inline double gp_asin(double x)
{
    return gp_atan2(x, sqrt((1.0 - x) * (1.0 + x)));
}

static inline double gp_acos(double x)
{
    return gp_atan2(sqrt((1.0 - x) * (1.0 + x)), x);
}

/* The length of (x, y), of up to 1e150, within 2 e. */
static inline double gp_hypot(double x, double y)
{
    return sqrt(x * x + y * y);
}

#endif
