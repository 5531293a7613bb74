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

/* v in [0, 1]; NaN becomes 0. */
static inline float gp_clamp01(float v)
{
    return v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f;
}

#endif
