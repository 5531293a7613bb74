#include "files_lossy.h"

#include "hardcases.h"

#include <float.h>

/* The largest error by `one` of all samples. */
static double worst_of(const struct gp_frame *got, const struct gp_frame *f,
                       double (*one)(float got, float from))
{
    const size_t n = gp_frame_pixels(f);
    double worst = 0.0;
    for (size_t i = 0; i < 3 * n; i++)
        worst = hard_worse(worst, one(got->rgb.c[i / n][i % n],
                                      f->rgb.c[i / n][i % n]));
    return worst;
}

// -- PXR24 --------------------------------------------------------------------

static double pxr24_one(float got, float from)
{
    if (isnan(from) || isinf(from))
        return (isnan(from) ? isnan(got) : got == from) ? 0.0 : HARD_NO_BAR;
    return fabs((double) got - (double) from) /
           fmax(fabs((double) from), (double) FLT_MIN);
}

double hard_pxr24_error(const struct gp_frame *got, const struct gp_frame *f)
{
    return worst_of(got, f, pxr24_one);
}

// -- B44 ----------------------------------------------------------------------

/* The place of v's half in the order of all halfs, 0 being 0. */
static double half_code(float v)
{
    const double a = fmin(fabs((double) v), 65504.0);
    const int e = a > 0x1p-14 ? ilogb(a) : -14;
    const double code = nearbyint(ldexp(a, 10 - e)) + 1024.0 * (e + 14);
    return signbit(v) ? -1.0 - code : code;
}

/* The 4x4 block of channel c whose first pixel is `at`; blocks start anew with
 * each chunk of 32 lines, which is whole blocks. */
static double b44_block(const float *got, const float *from, int w, int h,
                        int x0, int y0)
{
    double least = HUGE_VAL, most = -HUGE_VAL, worst = 0.0;
    for (int i = 0; i < 16; i++) {
        const int x = x0 + i % 4, y = y0 + i / 4;
        if (x >= w || y >= h)
            continue;
        const size_t at = (size_t) y * (size_t) w + (size_t) x;
        const double code =
            isfinite(from[at]) ? half_code(fmaxf(from[at], -32752.0f)) : 0.0;
        least = fmin(least, code);
        most = fmax(most, code);
        worst = isfinite(got[at])
                    ? hard_worse(worst, fabs(half_code(got[at]) - code))
                    : HARD_NO_BAR;
    }
    return worst > 0.0 ? worst / (most - least) : 0.0;
}

double hard_b44_error(const struct gp_frame *got, const struct gp_frame *f)
{
    const int w = gp_rect_w(f->data), h = gp_rect_h(f->data);
    double worst = 0.0;
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < h; y += 4) {
            for (int x = 0; x < w; x += 4)
                worst = hard_worse(worst, b44_block(got->rgb.c[c], f->rgb.c[c],
                                                    w, h, x, y));
        }
    }
    return worst;
}

// -- DWA ----------------------------------------------------------------------

static double bent(float v)
{
    const double a = fabs((double) v);
    return copysign(a <= 1.0 ? pow(a, 1.0 / 2.2) : log(a) / 2.2 + 1.0,
                    (double) v);
}

static double dwa_one(float got, float from)
{
    const float most = 57344.0f;
    const float v = isnan(from) ? 0.0f : fmaxf(fminf(from, most), -most);
    return isfinite(got) ? fabs(bent(got) - bent(v)) : HARD_NO_BAR;
}

double hard_dwa_error(const struct gp_frame *got, const struct gp_frame *f)
{
    return worst_of(got, f, dwa_one);
}
