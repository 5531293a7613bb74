// SPDX-License-Identifier: Apache-2.0
/* Minimum, maximum, clamp. Inline, without branches where the compiler can. */
#ifndef GP_CORE_MINMAX_H
#define GP_CORE_MINMAX_H

static inline int gp_min(int a, int b)
{
    return a < b ? a : b;
}

static inline int gp_max(int a, int b)
{
    return a > b ? a : b;
}

/* v in [low, high], low <= high. */
static inline int gp_clamp(int v, int low, int high)
{
    return v < low ? low : v > high ? high : v;
}

/* The same of a wider value, for sums that overflow an int. */
static inline int gp_clamp_wide(long long v, int low, int high)
{
    return v < low ? low : v > high ? high : (int) v;
}

/* Of two floats, `b` where either is NaN (fminf() takes the other one). */
static inline float gp_minf(float a, float b)
{
    return a < b ? a : b;
}

static inline float gp_maxf(float a, float b)
{
    return a > b ? a : b;
}

/* The same of doubles; unlike fmin() and fmax() no calls. */
static inline double gp_mind(double a, double b)
{
    return a < b ? a : b;
}

static inline double gp_maxd(double a, double b)
{
    return a > b ? a : b;
}

/* v as a whole number within [low, high]; NaN becomes low. */
static inline int gp_clamp_whole(double v, int low, int high)
{
    return !(v > (double) low) ? low : v < (double) high ? (int) v : high;
}

/* v in [0, 1]; NaN becomes 0. */
static inline float gp_clamp01(float v)
{
    return v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f;
}

/* Rises from 0 at 0 to 1 at 1 with slopes of 0 there: 3 t^2 - 2 t^3. */
static inline double gp_smoothstep(double t)
{
    t = t > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0;
    return t * t * (3.0 - 2.0 * t);
}

#endif
