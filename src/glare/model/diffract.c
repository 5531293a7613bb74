// SPDX-License-Identifier: Apache-2.0
/* Fraunhofer diffraction: from the light that passes a pupil to a shape.
 *
 *   I(q)    = |sum over cells of t exp(2 pi i path / l) exp(-2 pi i q x)|^2
 *   A(u)    = sum over q of I(q) exp(2 pi i q u) / sum over q of I(q)
 *   OTF_c(f) = sum over wavelengths l of w_c(l) A(l f)
 *   kernel_c(x) = sum over f of OTF_c(f) sinc(f)^2 exp(-2 pi i f x)
 *
 * A is the pupil's autocorrelation by the lag u in mm, f is in cycles per
 * radian, sinc is a pixel's: Goodman, Introduction to Fourier Optics,
 * sections 4.3 and 6.3. The spectrum is summed in the transfer function, one
 * transform a channel; OTF_c(0) is 1, so no light is lost. A channel of a
 * sample outside of the primaries' gamut comes out negative, and is folded in at
 * constant luminance.
 *
 * The kernel is periodic: light from beyond N / 2 pixels wraps to the other
 * side. OTFs are means over steps of frequency by a hat, which multiplies
 * the unbounded kernel by sinc(x / N)^2 in x and y, and the result is divided
 * by it: light that wraps to x from x - N is down to (x / (N - x))^2, a quarter
 * at the reach, a 25th at half of it, as N is three times the reach. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/pass.h"
#include "glare/model/model_priv.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CELLS = 2048, LEAST_CELLS = 512 }; // of a pupil, along a side

// -- from frequencies to the shape --------------------------------------------

struct finishing {
    const struct gp_spectra *s;
    int c;
    int first;                    // row of samples: 0, or -ry with a path,
                                  // without which the shape is even
    const struct gp_transform *t; // of x, of y
    struct gp_fft_matrix m;       // row of samples y is its row y - first
    char *scratch;                // of a thread: two arrays of points
    double pixel[2], fades;       // degrees; at the second samples are 0
    struct gp_samples *out;
};

/* A block of columns of the spectrum to rows of samples. Those are real, so that
 * they are also the transform back of the conjugate spectrum. */
static void finish_columns(void *ctx, int block, int thread)
{
    enum { LINES = GP_DOUBLE_LINES, POINT = 2 * LINES };
    const struct finishing *const f = ctx;
    const struct gp_transform *const t = &f->t[1];
    const size_t room = gp_transform_room(t->n) / sizeof(double);
    double *const z =
        (double *) (void *) f->scratch + 2 * room * (size_t) thread;
    const int x = block * LINES, n = t->n;
    const size_t from = (size_t) (x / GP_LANES * GP_LANES) * (size_t) n +
                        (size_t) (x % GP_LANES);
    const float *const re = f->s->re[f->c], *const im = f->s->im[f->c];
    for (size_t y = 0; y < (size_t) n; y++) {
        for (size_t i = 0; i < LINES; i++) {
            const size_t at = from + y * GP_LANES + i;
            // re and im exchanged
            z[y * POINT + i] = im ? -(double) im[at] : 0.0;
            z[y * POINT + LINES + i] = (double) re[at];
        }
    }
    const double *const out = gp_double_transform(t, z, z + room);
    double *const to =
        (double *) f->m.z[0] + (size_t) block * f->m.pitch * POINT;
    for (int y = f->first; y <= f->out->cy; y++) {
        const double *const row = out + (size_t) (y < 0 ? y + n : y) * POINT;
        double *const at = to + (size_t) (y - f->first) * POINT;
        memcpy(at, row + LINES, LINES * sizeof *at);
        memcpy(at + LINES, row, LINES * sizeof *at);
    }
}

/* A row of samples, and without a path the one across the centre. */
static void store_samples(const void *ctx, GP_UNUSED int c, int j,
                          const float *z)
{
    const struct finishing *const f = ctx;
    const int n = f->t[0].n, rx = f->out->cx, ry = f->out->cy;
    const double all = (double) n * f->t[1].n;
    const int y = j + f->first;
    const double across = gp_sinc((double) y / f->t[1].n);
    const size_t w = 2 * (size_t) rx + 1;
    float *const to = f->out->k.c[f->c] + (size_t) (y + ry) * w;
    float *const other = f->out->k.c[f->c] + (size_t) (ry - y) * w;
    for (int x = f->first == 0 && y == 0 ? 0 : -rx; x <= rx; x++) {
        const double at = gp_hypot(f->pixel[0] * x, f->pixel[1] * y);
        const double window = across * gp_sinc((double) x / n);
        // no rim: the last quarter fades out
        const double fade = gp_smoothstep(4.0 * (f->fades - at) / f->fades);
        const double v =
            (double) z[x < 0 ? x + n : x] * fade / (all * window * window);
        to[x + rx] = (float) v;
        if (f->first == 0)
            other[rx - x] = (float) v;
    }
}

static gp_status finish(const struct gp_log *log, const struct gp_spectra *s,
                        const struct gp_transform t[2], const double pixel[2],
                        double fades, const float luminance[3],
                        struct gp_samples *out)
{
    struct finishing f = {
        .s = s,
        .t = t,
        .pixel = {pixel[0], pixel[1]},
        .fades = fades,
        .out = out,
        .first = s->im[0] ? -out->cy : 0,
    };
    const struct gp_fft_request fft = {
        .log = log,
        .t = t,
        .in_double = true,
        .channels = 1,
    };
    const int rows = out->cy + 1 - f.first;
    gp_status st =
        gp_fft_matrix_make(log, (struct gp_fft_numbers) {.in_double = true}, 1,
                           t[0].n, rows, &f.m);
    if (!st)
        st = gp_alloc(log, "kernel", 2 * (size_t) gp_threads(),
                      gp_transform_room(t[1].n), &f.scratch);
    for (f.c = 0; f.c < s->channels && !st; f.c++) {
        gp_parallel_do(f.m.blocks, finish_columns, &f);
        st = gp_fft_rows_out(&fft, &f.m, rows, store_samples, &f);
    }
    // of nodes the pixel is folded, which is the sum of many
    const size_t n = luminance ? (size_t) out->w * (size_t) out->h : 0;
    for (size_t i = 0; i < n && !st; i++) {
        double v[3] = {0};
        for (int c = 0; c < s->channels; c++)
            v[c] = (double) out->k.c[c][i];
        if (s->channels == 3)
            gp_gamut_fold(luminance, v);
        for (int c = 0; c < s->channels; c++)
            out->k.c[c][i] = (float) fmax(v[c], 0.0);
    }
    gp_fft_matrix_free(&f.m);
    gp_free(f.scratch);
    return st;
}

// -- far from the light -------------------------------------------------------

/* Far from the light its mean is made, and before that the spikes of straight or
 * round blades. An edge of a pupil sends light out by the inverse cube of the angle, in the
 * mean over the circle: Airy's rings fall so, and so does the sum over a spike
 * of an n-gon, an inverse square that keeps its width. Far out a shape is
 *
 *   light_c / (t^2 + a^2)^1.5,   a = reach / 20
 *
 * with the light of the samples from half of the reach to three quarters of it,
 * in the median of directions: that between spikes. Before the reach it takes
 * over from what is narrow, which only fades, as left_at() says: a spike that got
 * wider would end in a tuft. The light that spikes then lack, some 0.1 % of all,
 * stays in the centre.
 *
 * Of a pupil with blades, the part of that light which is theirs goes on in
 * spikes as far as the recipe's reach. The transform of a polygon is a sum over
 * its edges: with length L, middle m, and q = t / l at delta from the normal,
 *
 *   F(q) = sum over edges of cos(delta) L sinc(L q sin(delta)) / (2 pi q)
 *                            exp(-2 pi i q m) (times a phase)
 *
 * so that its spikes fall as 1 / t^2 and are l / L wide, at any distance. Of an
 * arc, which turns by 2 b from end to end, each direction within b of the middle
 * has one point whose normal it is, and stationary phase spreads the edge's light
 * evenly over them: a fan 2 b t wide, with edges as soft as Fresnel's integral,
 * sqrt(t l / 2 rho) of the arc's radius rho: Born and Wolf, sections 8.5.1,
 * 8.8.3 and appendix III. Fringes between edges are finer than a spectrum and
 * pixels show. Both are one formula,
 *
 *   spike(s) = box of 2 b t * tent of sqrt((l / L)^2 + t l / 2 rho)
 *
 * in s = t delta, integrated over pixels. How strong it is per channel is fitted
 * to the samples, which know of dust on an edge, and of colours. */
enum {
    TURN = 1440,      // directions
    SIDE = TURN / 180 // of 2 degrees
};

/* Spikes of blades. Degrees of view, but for radians that say so. */
struct spikes {
    int n;                         // 0: none
    double turn, fan;              // radians clockwise, as y is down; half of
                                   // the fan
    double width[3], soft[3];      // of a straight edge; squared over t
    double nodes;                  // that a pixel is wide
    double from, reach;            // they fade between: left_at()
    double strength[3];            // by channel, of 1 / t^2
};

struct joined {
    struct gp_shape near, far;     // far: of light 1, grey
    struct spikes spikes;
    double pixel[2];               // degrees
    double from, reach;            // degrees; samples fade between: left_at()
    double light[3];               // of the mean
};

/* The share of what is narrow that is left t degrees from the light. After
 * `from` degrees it falls by the power STEEP beside its own, bent in over SOFT of
 * a logarithm of t, and to 0 over the LAST of the reach: it has no rim. */
static double left_at(double t, double from, double reach)
{
    static const double STEEP = 5.5, SOFT = 0.3, LAST = 0.4;
    const double u = gp_log(t / from);
    if (!(u > 0.0))
        return 1.0;
    const double fall = u < SOFT ? u * u / (2.0 * SOFT) : u - 0.5 * SOFT;
    return gp_exp(-STEEP * fall) * gp_smoothstep((1.0 - t / reach) / LAST);
}

// -- spikes -------------------------------------------------------------------

/* The integral up to z of two tents of half-widths a and b, convolved. */
static double tents_up_to(double z, double a, double b)
{
    static const double second[3] = {1.0, -2.0, 1.0};
    double sum = 0.0;
    if (z <= -a - b)
        return 0.0;
    if (z >= a + b)
        return 1.0;
    for (int i = 0; i < 9; i++) {
        const double x = fmax(z + (i / 3 - 1) * a + (i % 3 - 1) * b, 0.0);
        sum += second[i / 3] * second[i % 3] * x * x * x * x;
    }
    return sum / (24.0 * a * a * b * b);
}

/* Light of all spikes on a pixel at (x, y) degrees, of strength 1, by channel:
 * means over the pixels that shine and are lit, across the spike. */
static void spikes_at(const struct spikes *k, const double pixel[2], double x,
                      double y, int channels, double out[3])
{
    const double t = gp_hypot(x, y), at = gp_atan2(y, x);
    // the pixel's square, as boxes along its sides seen along the spike
    const double a = k->nodes * pixel[0] * fabs(y) / t;
    const double b = k->nodes * pixel[1] * fabs(x) / t;
    const double wide = fmax(a, b), thin = fmin(a, b);
    const double fan = fmax(2.0 * k->fan * t, 0.1 * wide);
    const double light = pixel[0] * pixel[1] / (t * t * fan);
    double width[3] = {0};
    for (int c = 0; c < channels; c++)
        width[c] = fmax(sqrt(k->width[c] * k->width[c] + k->soft[c] * t +
                             thin * thin), 0.1 * wide);
    const double side = 0.5 * fan + wide + width[0]; // red's is the widest
    out[0] = out[1] = out[2] = 0.0;
    for (int i = 0; i < k->n; i++) {
        const double s =
            t * fabs(remainder(at - k->turn - 2.0 * M_PI * i / k->n, M_PI));
        for (int c = 0; c < channels && s < side; c++)
            out[c] += light * (tents_up_to(s + 0.5 * fan, wide, width[c]) -
                               tents_up_to(s - 0.5 * fan, wide, width[c]));
    }
}

/* The share of them that is left; 0 where there are none. */
static double spikes_left(const struct spikes *k, double t)
{
    return k->n ? left_at(t, k->from, k->reach) : 0.0;
}

// -- the mean -----------------------------------------------------------------

static double falloff(double t, double reach)
{
    const double a = reach / 20.0, s = t * t + a * a;
    return 1.0 / (s * sqrt(s));
}

static void mean_profile(const void *ctx, double t, double out[3])
{
    const double *const reach = ctx;
    out[0] = falloff(t, *reach);
}

/* Parts that take over: of the mean, and of a spike of 1 / t^2, as if it were
 * even around the circle. */
static void taking_over(const void *ctx, double t, double out[3])
{
    const struct joined *const s = ctx;
    const double share = 1.0 - left_at(t, s->from, s->reach);
    out[0] = share * falloff(t, s->reach);
    out[1] = share * spikes_left(&s->spikes, t) / (2.0 * M_PI * t * t * t);
}

/* Degrees. */
static inline double distance(const struct joined *s, int x, int y)
{
    return gp_hypot(s->pixel[0] * x, s->pixel[1] * y);
}

/* Fades the samples of n pixels, and adds what takes over: spikes and mean. */
static void take_over(const struct joined *s, int x, int y, int n,
                      double *const out[3])
{
    const int channels = s->near.grey ? 1 : 3;
    double strip[GP_SHAPE_STRIP] = {0};
    double *const far[3] = {strip, NULL, NULL};
    const int last = gp_max(abs(x), abs(x + n - 1));
    if (!(distance(s, last, y) > s->from))
        return;
    s->far.row(s->far.state, x, y, n, far);
    for (int i = 0; i < n; i++) {
        const double t = distance(s, x + i, y);
        const double share = 1.0 - left_at(t, s->from, s->reach);
        if (!(share > 0.0))
            continue;
        const double part = spikes_left(&s->spikes, t);
        double v[3] = {0};
        if (part > 0.0)
            spikes_at(&s->spikes, s->pixel, s->pixel[0] * (x + i),
                      s->pixel[1] * y, channels, v);
        for (int c = 0; c < channels; c++)
            out[c][i] = (1.0 - share) * out[c][i] +
                        share * (part * s->spikes.strength[c] * v[c] +
                                 strip[i] * s->light[c]);
    }
}

/* The mean. */
static void joined_far(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct joined *const s = state;
    double strip[GP_SHAPE_STRIP] = {0};
    double *const far[3] = {strip, NULL, NULL};
    s->far.row(s->far.state, x, y, n, far);
    for (int c = 0; c < (s->near.grey ? 1 : 3); c++) {
        for (int i = 0; i < n; i++)
            out[c][i] = s->light[c] * strip[i];
    }
}

/* The share of it that has taken over, at the nearest such pixels. */
static double joined_least(const void *state, double pixels)
{
    const struct joined *const s = state;
    return 1.0 - left_at(pixels * fmin(s->pixel[0], s->pixel[1]), s->from,
                         s->reach);
}

static void joined_row(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct joined *const s = state;
    s->near.row(s->near.state, x, y, n, out);
    take_over(s, x, y, n, out);
}

static void joined_free(void *state)
{
    struct joined *const s = state;
    s->near.free(s->near.state);
    s->far.free(s->far.state);
    gp_free(s);
}

/* Light of samples by direction, and of spikes of strength 1. */
struct directions {
    double light[TURN][3], spikes[TURN][3], shape[TURN];
};

/* Direction of an offset, in steps of TURN. */
static int direction(const struct joined *s, int x, int y)
{
    const double turns =
        gp_atan2(s->pixel[1] * y, s->pixel[0] * x) / (2 * M_PI);
    return (int) (TURN * (turns + 1.0) + 0.5) % TURN;
}

/* Adds up the samples that do not fade, and those from which the mean is. */
static void measure(const struct joined *s, int rx, int ry,
                    struct directions *d, double sum[3])
{
    const int channels = s->near.grey ? 1 : 3;
    const double area = s->pixel[0] * s->pixel[1];
    double strip[3][GP_SHAPE_STRIP], spike[3] = {0};
    double *const row[3] = {strip[0], strip[1], strip[2]};
    for (int y = -ry; y <= ry; y++) {
        for (int x = -rx; x <= rx; x += GP_SHAPE_STRIP) {
            const int n = gp_min(rx + 1 - x, GP_SHAPE_STRIP);
            s->near.row(s->near.state, x, y, n, row);
            for (int i = 0; i < n; i++) {
                const double t = distance(s, x + i, y);
                const double left = left_at(t, s->from, s->reach);
                for (int c = 0; c < channels; c++)
                    sum[c] += left * strip[c][i];
                if (t < 0.5 * s->reach || t >= 0.75 * s->reach)
                    continue;
                const int k = direction(s, x + i, y);
                d->shape[k] += falloff(t, s->reach) * area;
                if (s->spikes.n)
                    spikes_at(&s->spikes, s->pixel, s->pixel[0] * (x + i),
                              s->pixel[1] * y, channels, spike);
                for (int c = 0; c < channels; c++) {
                    d->light[k][c] += strip[c][i];
                    d->spikes[k][c] += spike[c];
                }
            }
        }
    }
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

/* The light of directions within 2 degrees of spikes, over that between. */
static double fit_spikes(const struct directions *d, int c, double between)
{
    double sum = 0.0, spikes = 0.0;
    for (int i = 0; i < TURN; i++) {
        bool near = false;
        for (int k = -SIDE; k <= SIDE; k++)
            near |= d->spikes[(i + k + TURN) % TURN][c] > 0.0;
        sum += near ? d->light[i][c] - between * d->shape[i] : 0.0;
        spikes += d->spikes[i][c];
    }
    return spikes > 0.0 ? fmax(sum / spikes, 0.0) : 0.0;
}

/* Fills s->light and the spikes' strength. */
static void share_out(struct joined *s, const struct directions *d)
{
    // of the mean: without dust there is hardly light for spikes to end in
    static const double DARKEST = 0.1;
    for (int c = 0; c < (s->near.grey ? 1 : 3); c++) {
        double light[TURN / SIDE] = {0}, mean = 0.0;
        int n = 0;
        for (int i = 0; i < TURN; i += SIDE) {
            double sum = 0.0, shape = 0.0;
            for (int k = i; k < i + SIDE; k++) {
                sum += d->light[k][c];
                shape += d->shape[k];
            }
            if (shape > 0.0)
                light[n++] = sum / shape;
        }
        for (int i = 0; i < n; i++)
            mean += light[i] / n;
        qsort(light, (size_t) n, sizeof *light, compare);
        s->light[c] = n ? fmax(light[n / 2], DARKEST * mean) : 0.0;
        if (s->spikes.n)
            s->spikes.strength[c] = fit_spikes(d, c, s->light[c]);
    }
}

/* The spikes of d's blades, if they go on beyond `reach`. */
static struct spikes spikes_of(const struct gp_diffraction *d, double reach,
                               double nodes)
{
    static const double waves[3] = {610.0, 550.0, 465.0}; // nm, of channels
    const struct gp_blades *const b = &d->blades;
    const double degree = M_PI / 180.0;
    struct spikes k = {.n = d->reach > 1.05 * reach ? b->n : 0};
    if (!k.n)
        return k;
    k.turn = -b->turn;
    k.nodes = fmax(nodes, 1.0);
    k.fan = gp_asin(fmin(0.5 * b->length / b->bend, 1.0));
    k.from = d->sampled * d->reach;
    k.reach = d->reach;
    for (int c = 0; c < 3; c++) {
        const double mm = 1e-6 * (d->nm > 0.0 ? d->nm : waves[c]);
        k.width[c] = gp_hypot(mm / b->length, 1e-6 * d->steep) / degree;
        k.soft[c] = 0.5 * mm / b->bend / degree;
    }
    return k;
}

/* Joins to a shape whose samples, of offsets up to r[0] and r[1], end at `reach`
 * degrees, what takes over before: spikes up to d->reach, and the mean. Where the
 * field cuts no samples off, the centre's light makes all of it 1. */
static gp_status join(const struct gp_log *log,
    const struct gp_diffraction *d, const int r[2], double reach,
    const struct gp_field *f, struct gp_shape *shape)
{
    struct joined *s = NULL;
    struct directions *by = NULL;
    double over[3], sum[3] = {0};
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "kernel", 1, sizeof *s, &s));
    GP_TRY(gp_alloc_zero(log, "kernel", 1, sizeof *by, &by));
    // it is taken where it only falls, from 10 of its core's radii on
    GP_TRY(gp_radial_shape(log, mean_profile, &reach, 1, 0.0, f, &s->far));
    s->pixel[0] = f->degrees * f->aspect;
    s->pixel[1] = f->degrees;
    s->from = d->sampled * reach;
    s->reach = reach;
    s->near = *shape;
    s->spikes = spikes_of(d, reach, f->nodes);
    measure(s, r[0], r[1], by, sum);
    share_out(s, by);
    const double end = fmax(reach, s->spikes.reach);
    gp_profile_integral(taking_over, s, 2, s->from, end, over);
    const double a = reach / 20.0; // and from there to infinity
    const double rest = 2.0 * M_PI / sqrt(end * end + a * a);
    const bool whole = r[0] < f->w - 1 && r[1] < f->h - 1;
    for (int c = 0; c < 3 && whole; c++)
        shape->own[c] = 1.0 - sum[c] - (over[0] + rest) * s->light[c] -
                        over[1] * 2.0 * s->spikes.n * s->spikes.strength[c];
    shape->state = s;
    shape->free = joined_free;
    shape->row = joined_row;
    shape->reach = INT_MAX;
    const double pixels = end / (f->degrees * fmin(f->aspect, 1.0));
    shape->smooth = 0.75 * pixels;
    shape->far = joined_far;
    shape->least = joined_least;
    shape->far_grey = shape->grey;
    shape->far_even = true;
    shape->sharp = s->spikes.n ? (int) fmin(ceil(pixels), INT_MAX)
                               : gp_max(r[0], r[1]);
    s = NULL; // it is the shape's
out:
    gp_free(by);
    gp_free(s);
    return st;
}

// -- all of it ----------------------------------------------------------------

/* The pupil's cells, so that light up to `reach` degrees is resolved and its
 * path changes by under a sixteenth of a wave from cell to cell: the mean over
 * a cell is near its middle. Aberrations too strong for MOST_CELLS stay under
 * half a wave from cell to cell, where they do not alias. */
static int cells_of(const struct gp_diffraction *d, double reach)
{
    const double nm = d->nm > 0.0 ? d->nm : 450.0; // shorter ones are dim
    const double waves = d->diameter * 1e6 / nm * reach * M_PI / 180.0;
    const double n = fmax(2.2 * waves, 16.0 * d->steep * d->diameter / 400.0);
    return (int) fmin(ceil(fmax(n, LEAST_CELLS) / 8.0), MOST_CELLS / 8) * 8;
}

struct drawing {
    const struct gp_diffraction *d;
    struct gp_pupil *p;
};

static void draw_row(void *ctx, int y, GP_UNUSED int thread)
{
    const struct drawing *const d = ctx;
    d->d->draw(d->d->ctx, d->p, y);
}

/* Slices that hold `reach` at least; pixels that are wider are cut into them. */
enum { LEAST_REACH = 16 };

gp_status gp_diffract(const struct gp_log *log, const struct gp_diffraction *d,
                      const struct gp_field *f, struct gp_shape *out)
{
    double pixel[2] = {f->degrees * f->aspect, f->degrees};
    const int size[2] = {f->w, f->h};
    int period[2], slices[2], r[2];
    struct gp_pupil p = {0};
    struct gp_spectra s = {0};
    struct gp_transform t[2] = {{0}, {0}};
    struct gp_shape shape = {0};
    double finest[3] = {0};
    gp_status st;
    // as far as the key says, as cells resolve it, as a frame can meet it
    const double corner = gp_hypot(pixel[0] * f->w, pixel[1] * f->h);
    p.n = cells_of(d, fmin(d->reach, corner / d->sampled));
    p.cell = d->diameter / (p.n - 4);
    const double resolved =
        (d->nm > 0.0 ? d->nm : 450.0) * 0.5e-6 / p.cell * 0.95 * 180.0 / M_PI;
    const double reach = fmin(d->reach, resolved);
    for (int i = 0; i < 2; i++) {
        slices[i] = f->nodes > 0.0
                        ? 1 // D is wide
                        : (int) fmin(ceil(LEAST_REACH * pixel[i] / reach), 1e8);
        pixel[i] /= slices[i];
        r[i] = (int) fmin(ceil(reach / pixel[i]),
                          slices[i] > 1 ? LEAST_REACH * 2.0 : size[i] - 1);
        period[i] = gp_fft_length(gp_max(3 * r[i] + 1, 64));
    }
    const size_t cells = (size_t) p.n * (size_t) p.n;
    GP_TRY(gp_alloc_zero(log, "kernel", cells, sizeof(float), &p.t));
    if (d->steep > 0.0)
        GP_TRY(gp_alloc_zero(log, "kernel", cells, sizeof(float), &p.path));
    gp_parallel_do(p.n, draw_row, &(struct drawing) {d, &p});
    GP_TRY(gp_spectra_make(log, d, f, &p, period, pixel, &s));
    GP_FREE(p.t);
    GP_FREE(p.path);
    GP_TRY(gp_fft_pair_make(log, period[0], period[1], true, t));
    GP_TRY(gp_samples_make(log, s.channels, r[0], r[1], &shape));
    const bool sliced = slices[0] > 1 || slices[1] > 1; // nothing goes on
    if (f->nodes > 0.0)
        gp_finest_take(&s, period, f->nodes, finest);
    GP_TRY(finish(log, &s, t, pixel, sliced ? reach : 1e9,
                  f->nodes > 0.0 ? NULL : f->luminance, shape.state));
    memcpy(shape.own, finest, sizeof shape.own);
    if (!sliced && corner > d->sampled * reach)
        GP_TRY(join(log, d, r, reach, f, &shape));
    *out = shape;
    shape.free = NULL;
    if (sliced)
        st = gp_slices_join(log, slices, r[0], r[1], f, out);
out:
    if (shape.free)
        shape.free(shape.state);
    gp_free(p.t);
    gp_free(p.path);
    gp_fft_pair_free(t);
    gp_spectra_free(&s);
    return st;
}
