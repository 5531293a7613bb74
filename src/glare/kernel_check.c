#include "glare/kernel_check.h"

#include "core/minmax.h"

#include <math.h>
#include <stdio.h>

/* Half a code value of 8 bits in black, by the line of IEC 61966-2-1 (sRGB). */
static const double half_code = 0.5 / 255.0 / 12.92;

/* Luminance of a sample; 0 outside. */
static double sample(const struct gp_kernel *k, const float weight[3], int x,
                     int y)
{
    const size_t at = (size_t) y * (size_t) k->w + (size_t) x;
    double sum = 0.0;
    if (x < 0 || y < 0 || x >= k->w || y >= k->h)
        return 0.0;
    for (int c = 0; c < 3; c++)
        sum += (double) weight[c] * (double) k->k.c[c][at];
    return sum;
}

/* The largest step from a sample to a dark neighbour in any of four directions,
 * less 1.5 times what the sample before it differs: a slope that reaches 0 is
 * no edge, as it is a little steeper from sample to sample around a circle. */
static double find_rim(const struct gp_kernel *k, const float luminance[3])
{
    static const int way[4][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    double rim = 0.0;
    for (int y = 0; y < k->h; y++) {
        for (int x = 0; x < k->w; x++) {
            const double v = sample(k, luminance, x, y);
            for (int i = 0; i < 4 && fabs(v) > rim; i++) {
                const int dx = way[i][0], dy = way[i][1];
                const double next = sample(k, luminance, x + dx, y + dy);
                const double before = sample(k, luminance, x - dx, y - dy);
                if (fabs(next) < 1e-3 * fabs(v))
                    rim = fmax(rim, fabs(v) - 1.5 * fabs(before - v));
            }
        }
    }
    return rim;
}

void gp_kernel_glance(const struct gp_kernel *k, const float luminance[3],
                      struct gp_kernel_figures *out)
{
    struct gp_kernel_figures f = {
        .w = k->w, .h = k->h, .left_out = k->left_out,
    };
    for (int c = 0; c < 3; c++) {
        f.sum[c] = k->sum[c];
        f.light += (double) luminance[c] * k->sum[c];
    }
    f.own = f.light > 0.0 ? sample(k, luminance, k->cx, k->cy) / f.light : 0.0;
    f.rim = k->origin ? 0.0 : find_rim(k, luminance);
    *out = f;
}

void gp_kernel_measure(const struct gp_kernel *k, const float luminance[3],
                       struct gp_kernel_figures *out)
{
    double all = 0.0, odd = 0.0;
    size_t outermost = 0;
    const double centre = sample(k, luminance, k->cx, k->cy);
    gp_kernel_glance(k, luminance, out);
    out->measured = true;
    out->peak = out->mirrored = centre;
    for (int y = 0; y < k->h; y++) {
        for (int x = 0; x < k->w; x++) {
            const size_t at = (size_t) y * (size_t) k->w + (size_t) x;
            const double v = sample(k, luminance, x, y);
            const int dx = x - k->cx, dy = y - k->cy;
            const double mirror =
                sample(k, luminance, k->cx - dx, k->cy - dy);
            if (k->k.c[0][at] < 0.0f || k->k.c[1][at] < 0.0f ||
                k->k.c[2][at] < 0.0f)
                out->negatives++;
            if (v > out->peak) {
                out->peak = v;
                out->peak_at[0] = dx;
                out->peak_at[1] = dy;
                out->mirrored = mirror;
            }
            all += fabs(v);
            if ((k->w > 2 && (x == 0 || x == k->w - 1)) ||
                (k->h > 2 && (y == 0 || y == k->h - 1))) {
                out->border += fabs(v);
                outermost++;
            }
            odd += fmax(fabs(v) - fabs(mirror), 0.0);
            out->centroid[0] += v * dx;
            out->centroid[1] += v * dy;
        }
    }
    for (int i = 0; i < 2; i++)
        out->centroid[i] /= out->light != 0.0 ? out->light : 1.0;
    out->border /= all > 0.0 ? all : 1.0;
    out->outermost = (double) outermost / ((double) k->w * (double) k->h);
    out->asymmetry = all > fabs(centre) ? odd / (all - fabs(centre)) : 0.0;
}

// -- faults -------------------------------------------------------------------

/* The half-pixel trap: made about the middle of an even number of pixels, and
 * so half a pixel beside the centre's. */
static bool is_half_beside(const struct gp_kernel_figures *f)
{
    const double x = fabs(fabs(f->centroid[0]) - 0.5);
    const double y = fabs(fabs(f->centroid[1]) - 0.5);
    return x < 0.05 || y < 0.05;
}

/* A channel without light, or light that is made or lost. */
static void check_sum(const struct gp_kernel_figures *f, bool as_it_is,
                      char line[GP_FAULT_BYTES])
{
    static const char *const names[3] = {"red", "green", "blue"};
    const double most = fmax(f->sum[0], fmax(f->sum[1], f->sum[2]));
    const double whole = f->light + f->left_out;
    for (int c = 0; c < 3 && !line[0]; c++) {
        if (!(f->sum[c] > 1e-3 * most))
            snprintf(line, GP_FAULT_BYTES, "its %s sums to %.3g, another "
                     "channel to %.3g: white light loses a colour; give it "
                     "that channel", names[c], f->sum[c], most);
    }
    if (!line[0] && as_it_is && !(fabs(whole - 1.0) <= 0.01))
        snprintf(line, GP_FAULT_BYTES, "its light sums to %.4g, with what it "
                 "leaves out to %.4g, not 1: it was changed after it was made; "
                 "make it again, or use --kernel-normalize luminance",
                 f->light, whole);
}

/* Rules about all figures. */
static void check_figures(const struct gp_kernel_figures *f,
    const struct gp_kernel_use *use, enum gp_kernel_rule rule,
    char line[GP_FAULT_BYTES])
{
    if (rule == GP_RULE_SIZE && f->w == 1 && f->h == 1)
        snprintf(line, GP_FAULT_BYTES, "it is a single sample, which spreads "
                 "no light; use a larger kernel");
    if (rule == GP_RULE_SUM)
        check_sum(f, use->as_it_is, line);
    if (rule == GP_RULE_PEAK && f->mirrored < 0.5 * f->peak)
        snprintf(line, GP_FAULT_BYTES, "its peak is %d,%d pixels from its "
                 "centre: all light would move; set --kernel-center, or crop "
                 "the image about its peak", f->peak_at[0], f->peak_at[1]);
    if (rule == GP_RULE_CENTROID && is_half_beside(f))
        snprintf(line, GP_FAULT_BYTES, "its centroid is half a pixel from the "
                 "centre of its pixel (%.3g,%.3g); use an odd number of "
                 "pixels", f->centroid[0], f->centroid[1]);
    if (rule == GP_RULE_BORDER && use->ends &&
        f->border > fmax(0.01, 0.25 * f->outermost))
        snprintf(line, GP_FAULT_BYTES, "%.3g %% of its light is in its "
                 "outermost rows and columns: it is cut off; use a larger "
                 "kernel", 100.0 * f->border);
    if (rule == GP_RULE_NEGATIVE && f->negatives > 0)
        snprintf(line, GP_FAULT_BYTES, "%lld samples are negative, which "
                 "darkens pixels near light; clamp them to 0", f->negatives);
    if (rule == GP_RULE_SYMMETRY && f->asymmetry > 0.5)
        snprintf(line, GP_FAULT_BYTES, "%.3g %% of the light that it spreads "
                 "has no counterpart opposite to it: glare falls to one side; "
                 "set --kernel-center, or centre the image",
                 100.0 * f->asymmetry);
}

bool gp_kernel_fault(const struct gp_kernel_figures *f,
                     const struct gp_kernel_use *use, enum gp_kernel_rule rule,
                     char line[GP_FAULT_BYTES])
{
    const double glow = f->rim * use->brightest;
    line[0] = '\0';
    if (f->nonfinite > 0) {
        if (rule == GP_RULE_NONFINITE)
            snprintf(line, GP_FAULT_BYTES, "%lld samples are NaN or infinite; "
                     "replace them", f->nonfinite);
        return line[0] != '\0';
    }
    if (f->measured)
        check_figures(f, use, rule, line);
    if (rule == GP_RULE_OWN && use->add && f->own < 0.05)
        snprintf(line, GP_FAULT_BYTES, "%.2g %% of its light stays in its "
                 "pixel: added to the frame that is a second, blurred frame; "
                 "use --mix scatter", 100.0 * f->own);
    if (rule == GP_RULE_RIM && use->ends && glow > half_code)
        snprintf(line, GP_FAULT_BYTES, "its edge shows: %.2g beside a source "
                 "of %.3g, over half a code value of 8 bits (%.2g); use a "
                 "larger kernel, or one that fades to 0", glow, use->brightest,
                 half_code);
    if (rule == GP_RULE_LEFT_OUT && use->missed > 0.01)
        snprintf(line, GP_FAULT_BYTES, "%.2g %% of its model's light falls in "
                 "the frame but outside of the kernel; make it again with a "
                 "larger --size or --radius", 100.0 * use->missed);
    return line[0] != '\0';
}
