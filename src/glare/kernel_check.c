// SPDX-License-Identifier: Apache-2.0
#include "glare/kernel_check.h"

#include "core/colour.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <assert.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Half a code value of 8 bits in black, by the line of IEC 61966-2-1 (sRGB). */
static const double half_code = 0.5 / 255.0 / 12.92;

/* Rows that are measured together, and columns at a time. */
enum { BANDS = 64, STRIP = 254 };

/* Samples that the widest edge spans along rows and columns, and diagonals;
 * lines to either side that it is on; rows and columns around it that are read. */
enum { SPAN = 4, SPAN_DIAGONAL = 3, SIDES = 4, REACH = 14 };
static_assert(REACH >= 3 * SPAN && REACH > 3 * SPAN_DIAGONAL + SIDES,
              "what is read around an edge is there");

struct band {
    struct gp_kernel_figures f; // sums and maxima of its rows
    double all, odd;            // magnitudes; those without a counterpart
};

struct measuring {
    const struct gp_kernel *k;
    const float *luminance;
    bool edges;                 // whose steps are of interest
    double centre;
    int about[2];               // pixel that mirrors, from the centre's
    struct band band[BANDS];
};

/* Luminance of columns x .. x + n - 1 of a row; 0 outside. */
static void read_row(const struct measuring *m, int x, int n, int y,
                     float *restrict v)
{
    const struct gp_kernel *const k = m->k;
    const int from = gp_clamp(-x, 0, n), to = gp_clamp(k->w - x, from, n);
    const float *const w = m->luminance;
    memset(v, 0, (size_t) n * sizeof *v);
    if (y < 0 || y >= k->h || from == to)
        return;
    const size_t at = (size_t) y * (size_t) k->w + (size_t) (x + from);
    const float *const r = k->k.c[0] + at, *const g = k->k.c[1] + at;
    const float *const b = k->k.c[2] + at;
    for (int i = 0; i < to - from; i++)
        v[from + i] = w[0] * r[i] + w[1] * g[i] + w[2] * b[i];
}

/* Rows around that which is measured, row 0. */
typedef const float *const rows[2 * REACH + 1];

/* From sample i of row 0, n on. */
static const float *at_of(rows r, int i, const int way[2], int n)
{
    return r[REACH + n * way[1]] + (i + n * way[0]);
}

/* The step from sample i to a dark neighbour, less 1.5 times what the sample
 * before it differs: a slope that reaches 0 is no edge. */
static double find_cut(rows r, int i, const int way[2])
{
    const float at = *at_of(r, i, way, 0), next = *at_of(r, i, way, 1);
    const double before = (double) *at_of(r, i, way, -1);
    if (!(next < 1e-3f * at))
        return 0.0;
    return (double) at - 1.5 * fabs(before - (double) at);
}

/* The drop from sample i over `span` samples, less twice the larger change over
 * as many before it and after it, which leaves nothing of a power law, an
 * exponential, a Gaussian or a wave. It is an edge where it lasts: on it and on
 * SIDES lines to either side, all of 2 span samples before it, with those
 * between diagonals, are above all of 2 span after it, as those of spikes,
 * speckle and narrow rings are not. 0 where it is not over `least`. */
static double find_drop(rows r, int i, const int way[2], double least)
{
    const bool diagonal = way[0] && way[1];
    const int span = diagonal ? SPAN_DIAGONAL : SPAN;
    const int between = diagonal ? way[0] : 0; // samples between diagonals
    const float at = *at_of(r, i, way, 0), end = *at_of(r, i, way, span);
    if (!((double) (at - end) > least))
        return 0.0;
    const float before = fabsf(*at_of(r, i, way, -span) - at);
    const float after = fabsf(end - *at_of(r, i, way, 2 * span));
    const double slope = 2.0 * (double) gp_maxf(before, after);
    float low = at, high = end;
    for (int n = 0; n <= 2 * span; n++) {
        if (!((double) (low - high) - slope > least))
            return 0.0;
        for (int side = -SIDES; side <= SIDES; side++) {
            const float *const in = r[REACH - n * way[1] + side * way[0]];
            const float *const out =
                r[REACH + (span + n) * way[1] + side * way[0]];
            const int within = i - n * way[0] - side * way[1];
            const int beyond = i + (span + n) * way[0] - side * way[1];
            low = gp_minf(low, gp_minf(in[within], in[within - between]));
            high = gp_maxf(high, gp_maxf(out[beyond], out[beyond + between]));
        }
    }
    return fmax((double) (low - high) - slope, 0.0);
}

/* The largest edge in rows from .. to - 1, in any of eight directions. */
static double find_rim(const struct measuring *m, int from, int to)
{
    static const int ways[8][2] = {
        {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1},
    };
    enum { ROWS = 2 * REACH + 1, WIDTH = STRIP + 2 * REACH };
    float v[ROWS][WIDTH];
    double rim = 0.0;
    for (int x = 0; x < m->k->w; x += STRIP) {
        const int n = gp_min(m->k->w - x, STRIP);
        for (int y = from - REACH; y < to + REACH; y++) {
            float *const newest = v[(y - from + REACH) % ROWS];
            const float *r[ROWS];
            read_row(m, x - REACH, n + 2 * REACH, y, newest);
            for (int i = 0; i < n + 2 * REACH; i++)
                newest[i] = fabsf(newest[i]);
            if (y < from + REACH)
                continue;
            for (int i = 0; i < ROWS; i++)
                r[i] = v[(y - from + REACH + 1 + i) % ROWS];
            for (int i = REACH; i < n + REACH; i++) {
                for (int j = 0; j < 8 && (double) r[REACH][i] > rim; j++) {
                    if (j < 4)
                        rim = fmax(rim, find_cut(r, i, ways[j]));
                    rim = fmax(rim, find_drop(r, i, ways[j], rim));
                }
            }
        }
    }
    return rim;
}

/* Adds n samples v of row y from column x on; `mirror` are those opposite. */
static void add_samples(const struct measuring *m, int x, int y, int n,
    const float *restrict v, const float *restrict mirror, struct band *b)
{
    const struct gp_kernel *const k = m->k;
    const size_t at = (size_t) y * (size_t) k->w + (size_t) x;
    const bool top = k->h > 2 && (y == 0 || y == k->h - 1);
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        const double light = (double) v[i], size = fabs(light);
        const int dx = x + i - k->cx;
        sum += light;
        b->all += size;
        b->odd += fmax(size - fabs((double) mirror[n - 1 - i]), 0.0);
        b->f.place.centroid[0] += light * dx;
        if (top || (k->w > 2 && (dx == -k->cx || dx == k->w - 1 - k->cx)))
            b->f.border += size;
        if (light > b->f.place.peak) {
            b->f.place.peak = light;
            b->f.place.peak_at[0] = dx;
            b->f.place.peak_at[1] = y - k->cy;
            b->f.place.mirrored = (double) mirror[n - 1 - i];
        }
    }
    b->f.place.centroid[1] += sum * (y - k->cy);
    if (k->negative) {
        for (int i = 0; i < n; i++)
            b->f.negatives += k->k.c[0][at + (size_t) i] < 0.0f ||
                              k->k.c[1][at + (size_t) i] < 0.0f ||
                              k->k.c[2][at + (size_t) i] < 0.0f;
    }
}

static void measure_band(void *ctx, int i, GP_UNUSED int thread)
{
    struct measuring *const m = ctx;
    const struct gp_kernel *const k = m->k;
    struct band *const b = &m->band[i];
    const int from = (int) ((long long) k->h * i / BANDS);
    const int to = (int) ((long long) k->h * (i + 1) / BANDS);
    float v[STRIP], mirror[STRIP];
    b->f.place.peak = b->f.place.mirrored = m->centre;
    for (int y = from; y < to; y++) {
        for (int x = 0; x < k->w; x += STRIP) {
            const int n = gp_min(k->w - x, STRIP);
            read_row(m, x, n, y, v);
            read_row(m, 2 * (k->cx + m->about[0]) - x - n + 1, n,
                     2 * (k->cy + m->about[1]) - y, mirror);
            add_samples(m, x, y, n, v, mirror, b);
        }
    }
    if (m->edges)
        b->f.rim = find_rim(m, from, to);
}

/* Asymmetry about the pixel of the centroid, if that is in the kernel. `all`:
 * magnitudes. */
static double find_moved(struct measuring *m, double all,
                         const struct gp_kernel_place *f)
{
    const double x = round(f->centroid[0]), y = round(f->centroid[1]);
    float at;
    double odd = 0.0;
    if ((x == 0.0 && y == 0.0) || !(fabs(x) < m->k->w) ||
        !(fabs(y) < m->k->h))
        return f->asymmetry;
    m->about[0] = (int) x;
    m->about[1] = (int) y;
    m->edges = false;
    memset(m->band, 0, sizeof m->band);
    gp_parallel_do(BANDS, measure_band, m);
    for (int i = 0; i < BANDS; i++)
        odd += m->band[i].odd;
    read_row(m, m->k->cx + (int) x, 1, m->k->cy + (int) y, &at);
    const double leaves = all - fabs((double) at);
    return leaves > 0.0 ? odd / leaves : 0.0;
}

void gp_kernel_glance(const struct gp_kernel *k, const float luminance[3],
                      struct gp_kernel_figures *out)
{
    const struct measuring m = {.k = k, .luminance = luminance};
    float own;
    *out = (struct gp_kernel_figures) {
        .w = k->w, .h = k->h, .left_out = k->left_out,
    };
    memcpy(out->sum, k->sum, sizeof out->sum);
    out->light = gp_luminance_of(luminance, k->sum);
    read_row(&m, k->cx, 1, k->cy, &own);
    out->own = out->light > 0.0 ? (double) own / out->light : 0.0;
}

/* Measures the light that the weights make of the channels. */
static void measure_light(const struct gp_kernel *k, const float weights[3],
                          bool edges, struct gp_kernel_figures *out)
{
    struct measuring m = {.k = k, .luminance = weights, .edges = edges};
    struct gp_kernel_place *const place = &out->place;
    double all = 0.0, odd = 0.0;
    float centre;
    gp_kernel_glance(k, weights, out);
    read_row(&m, k->cx, 1, k->cy, &centre);
    m.centre = place->peak = place->mirrored = (double) centre;
    gp_parallel_do(BANDS, measure_band, &m);
    for (int i = 0; i < BANDS; i++) {
        const struct gp_kernel_figures *const b = &m.band[i].f;
        if (b->place.peak > place->peak) {
            place->peak = b->place.peak;
            place->mirrored = b->place.mirrored;
            memcpy(place->peak_at, b->place.peak_at, sizeof place->peak_at);
        }
        out->rim = fmax(out->rim, b->rim);
        out->negatives += b->negatives;
        out->border += b->border;
        place->centroid[0] += b->place.centroid[0];
        place->centroid[1] += b->place.centroid[1];
        all += m.band[i].all;
        odd += m.band[i].odd;
    }
    for (int i = 0; i < 2; i++)
        place->centroid[i] /= out->light != 0.0 ? out->light : 1.0;
    out->border /= all > 0.0 ? all : 1.0;
    const double w = k->w, h = k->h;
    const double within = (w > 2.0 ? w - 2.0 : w) * (h > 2.0 ? h - 2.0 : h);
    out->outermost = 1.0 - within / (w * h);
    const double leaves = all - fabs(m.centre);
    place->asymmetry = leaves > 0.0 ? odd / leaves : 0.0;
    place->moved = find_moved(&m, all, place);
    out->measured = true;
}

void gp_kernel_measure(const struct gp_kernel *k, const float luminance[3],
                       struct gp_kernel_figures *out)
{
    static const float only[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    measure_light(k, luminance, !k->origin, out);
    for (int c = 0; c < 3 && !k->grey; c++) {
        struct gp_kernel_figures f;
        measure_light(k, only[c], false, &f);
        out->channel[c] = f.place;
    }
    out->coloured = !k->grey;
}

// -- faults -------------------------------------------------------------------

static const char *const channel_names[3] = {"red", "green", "blue"};

static bool has_light(const struct gp_kernel_figures *f, int c)
{
    return f->sum[c] > 1e-3 * fmax(f->sum[0], fmax(f->sum[1], f->sum[2]));
}

/* Made about the middle of an even number of pixels. */
static bool is_half_beside(const struct gp_kernel_place *p)
{
    const double x = fabs(fabs(p->centroid[0]) - 0.5);
    const double y = fabs(fabs(p->centroid[1]) - 0.5);
    return x < 0.05 || y < 0.05;
}

/* A peak without a counterpart opposite to it. */
static bool is_peak_beside(const struct gp_kernel_place *p)
{
    return p->peak > 0.0 && p->mirrored < 0.5 * p->peak;
}

/* Of a symmetric kernel that is some pixels beside its centre: it is less than
 * a third as asymmetric about its centroid. */
static bool is_moved(const struct gp_kernel_place *p)
{
    return p->asymmetry > 0.01 && p->moved < p->asymmetry / 3.0 &&
           p->mirrored >= 0.5 * p->peak; // else its peak says so
}

/* The first channel with light that breaks a rule which others keep; -1: none. */
static int find_beside(const struct gp_kernel_figures *f,
                       bool breaks(const struct gp_kernel_place *))
{
    int first = -1;
    bool kept = !breaks(&f->place);
    for (int c = 2; c >= 0 && f->coloured; c--) {
        if (!has_light(f, c))
            continue;
        if (breaks(&f->channel[c]))
            first = c;
        else
            kept = true;
    }
    return kept ? first : -1;
}

/* A centroid's coordinate to 1e-4 pixel, without -0. */
static double rounded(double v)
{
    return round(1e4 * v) / 1e4 + 0.0;
}

GP_PRINTF(3, 4)
static void say(struct gp_fault *out, const char *parameter, const char *fmt,
                ...)
{
    va_list args;
    va_start(args, fmt);
    vsnprintf(out->line, sizeof out->line, fmt, args);
    va_end(args);
    out->parameter = parameter;
}

/* No light at all, a channel without light, or light that is made or lost. */
static void check_sum(const struct gp_kernel_figures *f, bool as_it_is,
                      struct gp_fault *out)
{
    const double most = fmax(f->sum[0], fmax(f->sum[1], f->sum[2]));
    const double whole = f->light + f->left_out;
    if (!(most > 0.0))
        say(out, "", "its light sums to %.3g; use an image that has light, with "
            "lobes smaller than it", f->light);
    for (int c = 0; c < 3 && !out->line[0]; c++) {
        if (!has_light(f, c))
            say(out, "", "its %s sums to %.3g, another channel to %.3g: white "
                "light loses a colour; give it that channel", channel_names[c],
                f->sum[c], most);
    }
    if (!out->line[0] && as_it_is && !(fabs(whole - 1.0) <= 0.01))
        say(out, "kernel.normalized", "its light sums to %.4g, with what it "
            "leaves out to %.4g, not 1: it was changed after it was made; make "
            "it again", f->light, whole);
}

/* A peak beside the centre: of one channel, or of the light. */
static void check_peak(const struct gp_kernel_figures *f, struct gp_fault *out)
{
    const int c = find_beside(f, is_peak_beside);
    const struct gp_kernel_place *const p = c < 0 ? &f->place : &f->channel[c];
    if (c >= 0)
        say(out, "", "the peak of its %s is %d,%d pixels from its centre: "
            "lights would get coloured fringes; align its channels",
            channel_names[c], p->peak_at[0], p->peak_at[1]);
    else if (is_peak_beside(p))
        say(out, "kernel.centre", "its peak is %d,%d pixels from its centre: "
            "all light would move; crop the image about its peak",
            p->peak_at[0], p->peak_at[1]);
}

/* A centroid beside the centre: of one channel, or of the light. */
static void check_centroid(const struct gp_kernel_figures *f, bool resampled,
                           struct gp_fault *out)
{
    const int c = find_beside(f, is_moved);
    const struct gp_kernel_place *const p = c < 0 ? &f->place : &f->channel[c];
    const double x = rounded(p->centroid[0]), y = rounded(p->centroid[1]);
    if (c >= 0)
        say(out, "", "the centroid of its %s is %.3g,%.3g pixels from its "
            "centre, and it is symmetric about that: lights would get coloured "
            "fringes; align its channels", channel_names[c], x, y);
    else if (is_moved(p))
        say(out, "kernel.centre", "its centroid is %.3g,%.3g pixels from its "
            "centre, and it is symmetric about that: all light would move; crop "
            "the image about it", x, y);
    else if (!resampled && is_half_beside(p) &&
             find_beside(f, is_peak_beside) < 0)
        say(out, "", "its centroid is half a pixel from the centre of its "
            "pixel (%.3g,%.3g); use an odd number of pixels", x, y);
}

static void check_figures(const struct gp_kernel_figures *f,
    const struct gp_kernel_use *use, enum gp_kernel_rule rule,
    struct gp_fault *out)
{
    if (rule == GP_RULE_SIZE && f->w == 1 && f->h == 1)
        say(out, "", "it is a single sample, which spreads no light; use a "
            "larger kernel");
    if (rule == GP_RULE_SUM)
        check_sum(f, use->as_it_is, out);
    if (rule == GP_RULE_NEGATIVE && f->negatives > 0)
        say(out, "", "%lld samples are negative, which darkens pixels near "
            "light; clamp them to 0", f->negatives);
    if (use->centred)
        return;
    if (rule == GP_RULE_PEAK)
        check_peak(f, out);
    if (rule == GP_RULE_CENTROID)
        check_centroid(f, use->resampled, out);
    if (rule == GP_RULE_BORDER && use->ends &&
        f->border > fmax(0.01, 0.25 * f->outermost))
        say(out, "", "%.3g %% of its light is in its outermost rows and "
            "columns: it is cut off; use a larger kernel", 100.0 * f->border);
    if (rule == GP_RULE_SYMMETRY && f->place.asymmetry > 0.5)
        say(out, "kernel.centre", "%.3g %% of the light that it spreads has no "
            "counterpart opposite to it: glare falls to one side; centre the "
            "image", 100.0 * f->place.asymmetry);
}

bool gp_kernel_fault(const struct gp_kernel_figures *f,
                     const struct gp_kernel_use *use, enum gp_kernel_rule rule,
                     struct gp_fault *out)
{
    const double glow = f->rim * use->brightest;
    const double beyond = f->left_out - use->missed;
    *out = (struct gp_fault) {.parameter = ""};
    if (f->nonfinite > 0) {
        if (rule == GP_RULE_NONFINITE)
            say(out, "", "%lld samples are NaN or infinite; replace them",
                f->nonfinite);
        return out->line[0] != '\0';
    }
    if (f->measured)
        check_figures(f, use, rule, out);
    if (rule == GP_RULE_OWN && use->add && f->own < 0.05)
        say(out, "layer.mix", "%.2g %% of its light stays in its pixel: added "
            "to the frame that is a second, blurred frame", 100.0 * f->own);
    if (rule == GP_RULE_RIM && use->ends && glow > half_code)
        say(out, "", "its edge shows: %.2g beside a source of %.3g, over half a "
            "code value of 8 bits (%.2g); use a larger kernel, or one that "
            "fades to 0", glow, use->brightest, half_code);
    if (rule == GP_RULE_LEFT_OUT && use->missed > 0.01)
        say(out, "field.radius", "%.2g %% of its model's light falls in the "
            "frame but outside of the kernel", 100.0 * use->missed);
    if (rule == GP_RULE_BEYOND && beyond > 0.01 && beyond > 0.1 * use->share)
        say(out, "plan.fov", "%.2g %% of the light that it takes from a pixel "
            "falls outside of the frame, wherever the source is, and is lost; "
            "choose keys or a kernel that falls faster with the angle",
            100.0 * beyond / fmax(use->share, beyond));
    return out->line[0] != '\0';
}
