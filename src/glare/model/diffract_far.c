/* Diffraction far from the light, where its mean is made, and before that the
 * spikes of straight or round blades.
 *
 * An edge of a pupil sends light out by the inverse cube of the angle, in the
 * mean over the circle: Airy's rings fall so, and so does the sum over a spike
 * of an n-gon, an inverse square that keeps its width. Far out a shape is
 *
 *   light_c(phi) / (t^2 + a^2)^1.5,   a = reach / 20
 *
 * in direction phi. The light is that of the samples from half of the reach to
 * three quarters of it, in means over phi. Over the last half of the reach they
 * take over in turn, each of twice the degrees of the one before: what is narrow
 * tapers and widens, and nothing ends. A tail may take over with that of 4
 * degrees, which is smooth. Wider ones follow beyond the reach: fans dissolve.
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

/* Directions; means over them, the first JOIN of which take over up to the
 * reach. */
enum { TURN = 1440, JOIN = 5, MEANS = 8 };
static const struct {
    double sigma;    // degrees of phi
    double from, to; // it and wider ones take over, shares of the reach
} means[MEANS] = {
    {0.25, GP_DIFFRACT_SAMPLED, 0.6}, {0.5, 0.54, 0.68}, {1.0, 0.59, 0.78},
    {2.0, 0.66, 0.9}, {4.0, 0.75, 1.0}, {8.0, 1.0, 1.6}, {16.0, 1.3, 2.3},
    {32.0, 1.8, 3.3},
};

/* Spikes of blades. Degrees of view, but for radians that say so. */
struct spikes {
    int n;                         // 0: none
    double turn, fan;              // radians clockwise, as y is down; half of
                                   // the fan
    double width[3], soft[3];      // of a straight edge; squared over t
    double reach;                  // they widen over its last half
    double strength[3];            // by channel, of 1 / t^2
};

struct joined {
    struct gp_shape near, far;     // far: of light 1, grey
    struct spikes spikes;
    double pixel[2];               // degrees
    double reach, end;             // of samples; of these and spikes
    double own[3];                 // light of the centre, so that all is 1
    double light[MEANS][TURN][3];  // by directions i / TURN of a turn
    double spread[MEANS][TURN][3]; // part of it that spikes have before their
                                   // reach
};

/* The share of light that means i and wider have t degrees from the light. */
static double taken(int i, double t, double reach)
{
    const double from = means[i].from * reach, to = means[i].to * reach;
    const double z = fmin(fmax((t - from) / (to - from), 0.0), 1.0);
    return z * z * (3.0 - 2.0 * z);
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

/* The part of them that means have. */
static double spikes_taken(const struct spikes *k, int i, double t)
{
    return k->n ? taken(i, t, k->reach) : 1.0;
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

/* Parts that take over: of the mean's light, of that where spikes have ended, and
 * of a spike of 1 / t^2, as if it were even around the circle. */
static void taking_over(const void *ctx, double t, double out[3])
{
    const struct joined *const s = ctx;
    const double share = taken(0, t, s->reach);
    const double spikes = spikes_taken(&s->spikes, 0, t);
    out[0] = falloff(t, s->reach) * share;
    out[1] = out[0] * spikes;
    out[2] = share * (1.0 - spikes) / (2.0 * GP_PI * t * t * t);
}

/* Degrees; much faster than hypot(). */
static inline double distance(const struct joined *s, int x, int y)
{
    const double u = s->pixel[0] * x, v = s->pixel[1] * y;
    return sqrt(u * u + v * v);
}

/* Direction of an offset, in steps of TURN, in [0, TURN). */
static double direction(const struct joined *s, int x, int y)
{
    const double turns = atan2(s->pixel[1] * y, s->pixel[0] * x) / (2 * GP_PI);
    return fmin(fmax(TURN * (turns < 0.0 ? turns + 1.0 : turns), 0.0),
                TURN * (1.0 - 1e-15));
}

/* Adds means of the light at a place t degrees away, from the reach on, in
 * direction `at`: `strip` in all. */
static void add_wide(const struct joined *s, double t, double at, double strip,
                     int channels, double out[3])
{
    const int k = (int) at, next = (k + 1) % TURN;
    double rest = 1.0;
    for (int i = JOIN - 1; i < MEANS && rest > 0.0; i++) {
        const double wider = i + 1 < MEANS ? taken(i + 1, t, s->end) : 0.0;
        for (int c = 0; c < channels; c++) {
            const double a = s->light[i][k][c], b = s->light[i][next][c];
            out[c] += strip * (rest - wider) * (a + (at - k) * (b - a));
        }
        rest = wider;
    }
}

/* Adds the same up to the reach, of samples' light and of spikes'. */
static void add_means(const struct joined *s, double t, double at, double strip,
                      int channels, double out[3])
{
    const int k = (int) at, next = (k + 1) % TURN;
    const double share = taken(0, t, s->reach);
    double rest = share, spikes = spikes_taken(&s->spikes, 0, t);
    for (int i = 0; i < JOIN && (rest > 0.0 || spikes > 0.0); i++) {
        const bool last = i + 1 == JOIN;
        const double wider = last ? 0.0 : taken(i + 1, t, s->reach);
        const double wide = last ? 0.0 : spikes_taken(&s->spikes, i + 1, t);
        const double of = strip * (rest - wider);
        const double more = strip * share * (spikes - wide) - of;
        for (int c = 0; c < channels; c++) {
            const double a = of * s->light[i][k][c] + more * s->spread[i][k][c];
            const double b =
                of * s->light[i][next][c] + more * s->spread[i][next][c];
            out[c] += a + (at - k) * (b - a);
        }
        rest = wider;
        spikes = wide;
    }
}

/* Fades the samples of n pixels, and adds the part that takes over: spikes, and
 * means of the rest and of spikes beyond their reach. */
static void take_over(const struct joined *s, int x, int y, int n,
                      double *const out[3])
{
    const int channels = s->near.grey ? 1 : 3;
    double strip[GP_SHAPE_STRIP];
    double *const far[3] = {strip, NULL, NULL};
    const int last = gp_max(abs(x), abs(x + n - 1));
    if (!(hypot(s->pixel[0] * last, s->pixel[1] * y) >
          means[0].from * s->reach))
        return;
    s->far.row(s->far.state, x, y, n, far);
    for (int i = 0; i < n; i++) {
        const double t = distance(s, x + i, y);
        const double share = taken(0, t, s->reach);
        if (!(share > 0.0))
            continue;
        const double part = 1.0 - spikes_taken(&s->spikes, 0, t);
        double v[3] = {0};
        if (part > 0.0)
            spikes_at(&s->spikes, s->pixel, s->pixel[0] * (x + i),
                      s->pixel[1] * y, channels, v);
        for (int c = 0; c < channels; c++)
            v[c] *= share * part * s->spikes.strength[c];
        (t < s->end ? add_means : add_wide)(s, t, direction(s, x + i, y),
                                            strip[i], channels, v);
        for (int c = 0; c < channels; c++)
            out[c][i] = (1.0 - share) * out[c][i] + v[c];
    }
}

/* The smooth means from where they begin: 0 within three quarters of s->end. */
static void joined_far(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct joined *const s = state;
    const int channels = s->near.grey ? 1 : 3;
    double strip[GP_SHAPE_STRIP];
    double *const far[3] = {strip, NULL, NULL};
    const int last = gp_max(abs(x), abs(x + n - 1));
    for (int c = 0; c < channels; c++)
        memset(out[c], 0, (size_t) n * sizeof *out[c]);
    if (!(hypot(s->pixel[0] * last, s->pixel[1] * y) > 0.75 * s->end))
        return;
    s->far.row(s->far.state, x, y, n, far);
    for (int i = 0; i < n; i++) {
        const double t = distance(s, x + i, y);
        double v[3] = {0};
        if (!(taken(JOIN - 1, t, s->end) > 0.0))
            continue;
        add_wide(s, t, direction(s, x + i, y), strip[i], channels, v);
        for (int c = 0; c < channels; c++)
            out[c][i] = v[c];
    }
}

/* The share of them that has taken over, at the nearest such pixels: nothing
 * is negative. */
static double joined_least(const void *state, double pixels)
{
    const struct joined *const s = state;
    const double t = pixels * fmin(s->pixel[0], s->pixel[1]);
    return taken(JOIN - 1, t, s->end);
}

static void joined_row(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct joined *const s = state;
    const int channels = s->near.grey ? 1 : 3;
    s->near.row(s->near.state, x, y, n, out);
    take_over(s, x, y, n, out);
    for (int c = 0; c < channels && y == 0 && x <= 0 && x + n > 0; c++)
        out[c][-x] += s->own[c];
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
    double light[TURN][3], spikes[TURN][3], shape[TURN], all;
};

/* Adds up the samples that do not fade, and those from which the means are. */
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
                const double left = 1.0 - taken(0, t, s->reach);
                for (int c = 0; c < channels; c++)
                    sum[c] += left * strip[c][i];
                if (t < 0.5 * s->reach || t >= 0.75 * s->reach)
                    continue;
                const int k = (int) (direction(s, x + i, y) + 0.5) % TURN;
                d->shape[k] += falloff(t, s->reach) * area;
                d->all += falloff(t, s->reach) * area;
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

/* The strength of spikes in a channel, by least squares over the directions of
 * samples, of which the rest is taken as even. */
static double fit_spikes(const struct directions *d, int c)
{
    double sum[2] = {0}, square = 0.0, product = 0.0, weight = 0.0;
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < TURN; i++) {
            if (!(d->shape[i] > 0.0))
                continue;
            const double v = d->light[i][c] / d->shape[i];
            const double z = d->spikes[i][c] / d->shape[i];
            if (!pass) {
                sum[0] += d->shape[i] * v;
                sum[1] += d->shape[i] * z;
                weight += d->shape[i];
                continue;
            }
            square += d->shape[i] * pow(z - sum[1] / weight, 2.0);
            product += d->shape[i] * (z - sum[1] / weight) *
                       (v - sum[0] / weight);
        }
    }
    return square > 0.0 ? fmax(product / square, 0.0) : 0.0;
}

/* The mean of `light` over `sigma` degrees. */
static void even_out(const struct directions *d, const double light[TURN][3],
                     double sigma, double out[TURN][3])
{
    enum { MOST = TURN / 2 - 1 };
    const int wide = gp_min((int) (4.0 * sigma * TURN / 360.0), MOST);
    // a direction without samples has the mean of all
    const double few = fmax(1e-6 * d->all, 1e-300);
    double all[3] = {0}, g[MOST + 1];
    for (int k = 0; k <= wide; k++)
        g[k] = exp(-0.5 * pow(k * 360.0 / TURN / sigma, 2.0));
    for (int i = 0; i < TURN; i++) {
        for (int c = 0; c < 3; c++)
            all[c] += d->all > 0.0 ? light[i][c] / d->all : 0.0;
    }
    for (int i = 0; i < TURN; i++) {
        double v[3] = {all[0] * few, all[1] * few, all[2] * few}, w = few;
        for (int k = -wide; k <= wide; k++) {
            const int at = (i + k + TURN) % TURN;
            w += g[abs(k)] * d->shape[at];
            for (int c = 0; c < 3; c++)
                v[c] += g[abs(k)] * light[at][c];
        }
        for (int c = 0; c < 3; c++)
            out[i][c] = v[c] / w;
    }
}

/* The means of each channel over all directions. */
static void mean_of(const double light[TURN][3], double mean[3])
{
    memset(mean, 0, 3 * sizeof *mean);
    for (int i = 0; i < TURN; i++) {
        for (int c = 0; c < 3; c++)
            mean[c] += light[i][c] / TURN;
    }
}

/* Scales channels to have such means. */
static void scale_to(const double mean[3], double light[TURN][3])
{
    double has[3];
    mean_of(light, has);
    for (int i = 0; i < TURN; i++) {
        for (int c = 0; c < 3; c++)
            light[i][c] *= has[c] > 0.0 ? mean[c] / has[c] : 0.0;
    }
}

/* Fills s->light, s->spread, the spikes' strength, and their means. */
static void share_out(struct joined *s, struct directions *d, double light[3],
                      double spread[3])
{
    const int channels = s->near.grey ? 1 : 3;
    for (int c = 0; c < channels && s->spikes.n; c++)
        s->spikes.strength[c] = fit_spikes(d, c);
    for (int i = 0; i < TURN; i++) {
        for (int c = 0; c < 3; c++)
            d->spikes[i][c] *= s->spikes.strength[c];
    }
    for (int m = MEANS - 1; m >= 0; m--) {
        even_out(d, d->light, means[m].sigma, s->light[m]);
        even_out(d, d->spikes, means[m].sigma, s->spread[m]);
        if (m < MEANS - 1) { // all means have the same light
            scale_to(light, s->light[m]);
            scale_to(spread, s->spread[m]);
        }
        for (int i = 0; i < TURN; i++) {
            for (int c = 0; c < 3; c++)
                s->spread[m][i][c] =
                    fmin(s->spread[m][i][c], s->light[m][i][c]);
        }
        if (m == MEANS - 1) {
            mean_of(s->light[m], light);
            mean_of(s->spread[m], spread);
        }
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
    k.reach = d->reach;
    for (int c = 0; c < 3; c++) {
        const double mm = 1e-6 * (d->nm > 0.0 ? d->nm : waves[c]);
        k.width[c] = hypot(mm / b->length, 1e-6 * d->steep) / degree;
        k.soft[c] = 0.5 * mm / b->bend / degree;
    }
    return k;
}

gp_status gp_diffract_join(const struct gp_log *log,
    const struct gp_diffraction *d, int rx, int ry, double reach,
    const struct gp_field *f, struct gp_shape *shape)
{
    struct joined *s;
    struct directions *by;
    double over[3], light[3], spread[3], sum[3] = {0};
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
    s->reach = reach;
    s->near = *shape;
    s->spikes = spikes_of(d, reach);
    s->end = fmax(reach, s->spikes.reach);
    measure(s, rx, ry, by, sum);
    share_out(s, by, light, spread);
    gp_free(by);
    const double end = s->end;
    gp_profile_integral(taking_over, s, 3, means[0].from * reach, end, over);
    const double a = reach / 20.0; // and from there to infinity
    const double rest = 2.0 * GP_PI / sqrt(end * end + a * a);
    for (int c = 0; c < 3 && shape->fits[0] && shape->fits[1]; c++)
        s->own[c] = 1.0 - sum[c] - (over[0] + rest) * (light[c] - spread[c]) -
                    (over[1] + rest) * spread[c] -
                    over[2] * 2.0 * s->spikes.n * s->spikes.strength[c];
    shape->state = s;
    shape->free = joined_free;
    shape->row = joined_row;
    shape->reach = INT_MAX;
    shape->rows = 0;
    const double pixels = end / (f->degrees * fmin(f->aspect, 1.0));
    shape->smooth = 0.75 * pixels;
    shape->far = joined_far;
    shape->least = joined_least;
    shape->far_grey = shape->grey;
    shape->sharp = s->spikes.n ? (int) fmin(ceil(pixels), INT_MAX)
                               : gp_max(rx, ry);
    return GP_OK;
}
