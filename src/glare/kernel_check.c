#include "glare/kernel_check.h"

#include "core/minmax.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Half a code value of 8 bits in black, by the line of IEC 61966-2-1 (sRGB). */
static const double half_code = 0.5 / 255.0 / 12.92;

static double sample(const struct gp_kernel *k, const float weight[3], int x,
                     int y)
{
    const size_t at = (size_t) y * (size_t) k->w + (size_t) x;
    double sum = 0.0;
    for (int c = 0; c < 3; c++)
        sum += (double) weight[c] * (double) k->k.c[c][at];
    return sum;
}

static bool is_outermost(const struct gp_kernel *k, int x, int y)
{
    return x == 0 || y == 0 || x == k->w - 1 || y == k->h - 1;
}

void gp_kernel_glance(const struct gp_kernel *k, const float luminance[3],
                      struct gp_kernel_figures *out)
{
    struct gp_kernel_figures f = {.left_out = k->left_out};
    for (int c = 0; c < 3; c++)
        f.light += (double) luminance[c] * k->sum[c];
    if (k->cx >= 0 && k->cx < k->w && k->cy >= 0 && k->cy < k->h)
        f.centre = sample(k, luminance, k->cx, k->cy);
    f.own = f.light > 0.0 ? f.centre / f.light : 0.0;
    for (int y = 0; y < k->h && k->w > 2 && k->h > 2; y++) {
        const bool whole = y == 0 || y == k->h - 1;
        for (int x = 0; x < k->w; x += whole ? 1 : k->w - 1) {
            const double edge = sample(k, luminance, x, y);
            const double inner = sample(k, luminance,
                gp_clamp(x, 1, k->w - 2), gp_clamp(y, 1, k->h - 2));
            f.rim = fmax(f.rim, fabs(edge) - fabs(inner - edge));
        }
    }
    *out = f;
}

void gp_kernel_measure(const struct gp_kernel *k, const float luminance[3],
                       struct gp_kernel_figures *out)
{
    double all = 0.0, square = 0.0, odd = 0.0;
    gp_kernel_glance(k, luminance, out);
    out->measured = true;
    for (int y = 0; y < k->h; y++) {
        for (int x = 0; x < k->w; x++) {
            const size_t at = (size_t) y * (size_t) k->w + (size_t) x;
            const double v = sample(k, luminance, x, y);
            const int dx = x - k->cx, dy = y - k->cy;
            const int mx = k->cx - dx, my = k->cy - dy;
            const bool inside = mx >= 0 && mx < k->w && my >= 0 && my < k->h;
            const double mirror = inside ? sample(k, luminance, mx, my) : 0.0;
            for (int c = 0; c < 3; c++) {
                if (k->k.c[c][at] < 0.0f) {
                    out->negatives++;
                    break;
                }
            }
            if (v > out->peak) {
                out->peak = v;
                out->peak_at[0] = dx;
                out->peak_at[1] = dy;
            }
            all += fabs(v);
            out->border += is_outermost(k, x, y) ? fabs(v) : 0.0;
            square += v * v;
            odd += (v - mirror) * (v - mirror);
            out->centroid[0] += v * dx;
            out->centroid[1] += v * dy;
        }
    }
    for (int i = 0; i < 2; i++)
        out->centroid[i] /= out->light != 0.0 ? out->light : 1.0;
    out->border /= all > 0.0 ? all : 1.0;
    out->asymmetry = square > 0.0 ? sqrt(odd / square) : 0.0;
}

// -- faults -------------------------------------------------------------------

/* True for a kernel made about the middle of an even number of pixels, half a
 * pixel off the centre's. */
static bool is_half_beside(const struct gp_kernel_figures *f)
{
    const double x = fabs(fabs(f->centroid[0]) - 0.5);
    const double y = fabs(fabs(f->centroid[1]) - 0.5);
    return f->measured && (x < 0.05 || y < 0.05);
}

bool gp_kernel_fault(const struct gp_kernel_figures *f,
                     const struct gp_kernel_use *use, int i,
                     char line[GP_FAULT_BYTES])
{
    const double glow = f->rim * use->brightest;
    line[0] = '\0';
    // a disc or box ends at its own brightness; a falloff should reach 0
    if (i == 0 && use->ends && f->rim < 0.1 * f->centre && glow > half_code)
        snprintf(line, GP_FAULT_BYTES, "its edge shows: %.2g beside a source "
                 "of %.3g, over half a code value of 8 bits (%.2g); use a "
                 "larger kernel, or one that fades to 0", glow, use->brightest,
                 half_code);
    else if (i == 1 && use->add && f->own < 0.05)
        snprintf(line, GP_FAULT_BYTES, "%.2g %% of its light stays in its "
                 "pixel: added to the frame that is a second, blurred frame; "
                 "use --mix scatter", 100.0 * f->own);
    else if (i == 2 && use->ends && f->left_out > 0.01)
        snprintf(line, GP_FAULT_BYTES, "%.2g %% of the model's light is "
                 "outside of it; make it larger", 100.0 * f->left_out);
    else if (i == 3 && f->measured && f->negatives > 0)
        snprintf(line, GP_FAULT_BYTES, "%lld samples are negative, which "
                 "darkens pixels near light; clamp them to 0", f->negatives);
    else if (i == 4 && is_half_beside(f))
        snprintf(line, GP_FAULT_BYTES, "its centroid is half a pixel from the "
                 "centre of its pixel (%.3g,%.3g); use an odd number of "
                 "pixels", f->centroid[0], f->centroid[1]);
    return line[0] != '\0';
}
