/* Diffraction far from the light, where its mean is made, and before that the
 * spikes of straight or round blades.
 *
 * An edge of a pupil sends light out by the inverse cube of the angle, in the
 * mean over the circle: Airy's rings fall so, and so does the sum over a spike
 * of an n-gon, an inverse square that keeps its width. Far out a shape is
 *
 *   light_c / (t^2 + a^2)^1.5,   a = reach / 20
 *
 * with the light of the samples from half of the reach to three quarters of it,
 * in the median of directions: that between spikes, even around the circle.
 * Before the reach it takes over from what is narrow, which only fades, as
 * left_at() says: a spike that got wider in place of fainter would end in a tuft.
 * The light that spikes then lack, some 0.1 % of all, stays in the centre.
 *
 * Of a pupil with blades, the part of that light which is theirs goes on in
 * spikes as far as the recipe's reach. The transform of a polygon is a sum over
 * its edges: with an edge's length L, its middle at m, and q = t / l in
 * direction delta from its normal,
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
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/model/model_priv.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

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
    double from, reach;            // they fade between: left_at()
    double strength[3];            // by channel, of 1 / t^2
};

struct joined {
    struct gp_shape near, far;     // far: of light 1, grey
    struct spikes spikes;
    double pixel[2];               // degrees
    double from, reach;            // samples fade between: left_at()
    double end;                    // of these and spikes
    double light[3];               // of the mean
};

/* The share of what is narrow that is left t degrees from the light. After
 * `from` degrees it falls by the power STEEP beside its own, bent in over SOFT of
 * a logarithm of t, and to 0 over the LAST of the reach. Light that falls by no
 * more than the 12th power of the distance has no rim. */
static double left_at(double t, double from, double reach)
{
    static const double STEEP = 5.5, SOFT = 0.3, LAST = 0.4;
    const double u = log(t / from);
    if (!(u > 0.0))
        return 1.0;
    const double fall = u < SOFT ? u * u / (2.0 * SOFT) : u - 0.5 * SOFT;
    return exp(-STEEP * fall) * gp_smoothstep((1.0 - t / reach) / LAST);
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
    const double t = hypot(x, y), at = atan2(y, x);
    // the pixel's square, as boxes along its sides seen along the spike
    const double a = pixel[0] * fabs(y) / t, b = pixel[1] * fabs(x) / t;
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
        const double s = t * fabs(remainder(at - k->turn - 2.0 * GP_PI * i /
                                            k->n, GP_PI));
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
    out[1] = share * spikes_left(&s->spikes, t) / (2.0 * GP_PI * t * t * t);
}

/* Degrees; much faster than hypot(). */
static inline double distance(const struct joined *s, int x, int y)
{
    const double u = s->pixel[0] * x, v = s->pixel[1] * y;
    return sqrt(u * u + v * v);
}

/* Fades the samples of n pixels, and adds what takes over: spikes and mean. */
static void take_over(const struct joined *s, int x, int y, int n,
                      double *const out[3])
{
    const int channels = s->near.grey ? 1 : 3;
    double strip[GP_SHAPE_STRIP] = {0};
    double *const far[3] = {strip, NULL, NULL};
    const int last = gp_max(abs(x), abs(x + n - 1));
    if (!(hypot(s->pixel[0] * last, s->pixel[1] * y) > s->from))
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
    if (s->far.free)
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
    const double turns = atan2(s->pixel[1] * y, s->pixel[0] * x) / (2 * GP_PI);
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

/* The strength of spikes in a channel: the light of directions within 2 degrees
 * of theirs, over that between. */
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
static struct spikes spikes_of(const struct gp_diffraction *d, double reach)
{
    static const double waves[3] = {610.0, 550.0, 465.0}; // nm, of channels
    const struct gp_blades *const b = &d->blades;
    const double degree = GP_PI / 180.0;
    struct spikes k = {.n = d->reach > 1.05 * reach ? b->n : 0};
    if (!k.n)
        return k;
    k.turn = -b->turn;
    k.fan = asin(fmin(0.5 * b->length / b->bend, 1.0));
    k.from = d->sampled * d->reach;
    k.reach = d->reach;
    for (int c = 0; c < 3; c++) {
        const double mm = 1e-6 * (d->nm > 0.0 ? d->nm : waves[c]);
        k.width[c] = hypot(mm / b->length, 1e-6 * d->steep) / degree;
        k.soft[c] = 0.5 * mm / b->bend / degree;
    }
    return k;
}

gp_status gp_diffract_join(const struct gp_log *log,
    const struct gp_diffraction *d, const int r[2], double reach,
    const struct gp_field *f, struct gp_shape *shape)
{
    struct joined *s;
    struct directions *by;
    double over[3], sum[3] = {0};
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *s, &s);
    if (st)
        return st;
    st = gp_alloc_zero(log, "kernel", 1, sizeof *by, &by);
    if (!st) // it is taken where it only falls, from 10 of its core's radii on
        st = gp_radial_shape(log, mean_profile, &reach, 1, 0.0, f, &s->far);
    if (st) {
        gp_free(by);
        gp_free(s);
        return st;
    }
    s->pixel[0] = f->degrees * f->aspect;
    s->pixel[1] = f->degrees;
    s->from = d->sampled * reach;
    s->reach = reach;
    s->near = *shape;
    s->spikes = spikes_of(d, reach);
    s->end = fmax(reach, s->spikes.reach);
    measure(s, r[0], r[1], by, sum);
    share_out(s, by);
    gp_free(by);
    const double end = s->end;
    gp_profile_integral(taking_over, s, 2, s->from, end, over);
    const double a = reach / 20.0; // and from there to infinity
    const double rest = 2.0 * GP_PI / sqrt(end * end + a * a);
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
    return GP_OK;
}
