/* Diffraction far from the light, where only its mean is made.
 *
 * An edge of a pupil sends light out by the inverse cube of the angle, in the
 * mean over the circle: Airy's rings fall so, and so does the sum over a spike
 * of an n-gon, an inverse square that keeps its width. Beyond `reach` a shape
 * is
 *
 *   light_c(phi) / (t^2 + a^2)^1.5,   a = reach / 20
 *
 * in direction phi. The light is that of the samples from half of the reach to
 * where they begin to fade out, in a mean of SIGMA degrees of phi, so that it
 * is smooth; and takes over as they fade, where a tail may take over as well. */
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/model/diffract_priv.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { TURN = 720 };               // directions
static const double SIGMA = 4.0;

struct joined {
    struct gp_shape near, far;     // far: of light 1, grey
    double pixel[2], reach;        // degrees
    double own[3];                 // light of the centre, so that all is 1
    double light[TURN][3];         // by directions i / TURN of a turn
};

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

/* The part of it that takes over. */
static void taking_over(const void *ctx, double t, double out[3])
{
    const double *const reach = ctx;
    out[0] = falloff(t, *reach) * (1.0 - gp_diffract_fade(t, *reach));
}

/* Direction of an offset, in steps of TURN, in [0, TURN). */
static double direction(const struct joined *s, int x, int y)
{
    const double turns = atan2(s->pixel[1] * y, s->pixel[0] * x) / (2 * GP_PI);
    return fmin(fmax(TURN * (turns < 0.0 ? turns + 1.0 : turns), 0.0),
                TURN * (1.0 - 1e-15));
}

/* Adds the light far out to n pixels, 0 within three quarters of the reach; or,
 * `faded`, the part of it that takes over. */
static void add_far(const struct joined *s, int x, int y, int n, bool faded,
                    double *const out[3])
{
    const int channels = s->near.grey ? 1 : 3;
    double strip[GP_SHAPE_STRIP] = {0};
    double *const far[3] = {strip, NULL, NULL};
    const int last = gp_max(abs(x), abs(x + n - 1));
    if (!(hypot(s->pixel[0] * last, s->pixel[1] * y) > 0.75 * s->reach))
        return;
    s->far.row(s->far.state, x, y, n, far);
    for (int i = 0; i < n; i++) {
        const double t = hypot(s->pixel[0] * (x + i), s->pixel[1] * y);
        const double share = 1.0 - gp_diffract_fade(t, s->reach);
        if (!(share > 0.0))
            continue;
        const double v = faded ? share * strip[i] : strip[i];
        const double at = direction(s, x + i, y);
        const int k = (int) at;
        const double *const a = s->light[k];
        const double *const b = s->light[(k + 1) % TURN];
        for (int c = 0; c < channels; c++)
            out[c][i] += v * (a[c] + (at - k) * (b[c] - a[c]));
    }
}

static void joined_far(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct joined *const s = state;
    for (int c = 0; c < (s->near.grey ? 1 : 3); c++)
        memset(out[c], 0, (size_t) n * sizeof *out[c]);
    add_far(s, x, y, n, false, out);
}

/* The share that takes over, at the nearest such pixels: nothing is negative. */
static double joined_least(const void *state, double pixels)
{
    const struct joined *const s = state;
    const double t = pixels * fmin(s->pixel[0], s->pixel[1]);
    return 1.0 - gp_diffract_fade(t, s->reach);
}

static void joined_row(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct joined *const s = state;
    const int channels = s->near.grey ? 1 : 3;
    s->near.row(s->near.state, x, y, n, out);
    add_far(s, x, y, n, true, out);
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

/* Fills s->light, and its means and the sums of all samples. */
static void measure(struct joined *s, int rx, int ry, double mean[3],
                    double sum[3])
{
    double light[TURN][3] = {{0}}, shape[TURN] = {0}, all = 0.0;
    const int channels = s->near.grey ? 1 : 3, wide = (int) (2.0 * SIGMA * 4.0);
    double strip[3][GP_SHAPE_STRIP];
    double *const row[3] = {strip[0], strip[1], strip[2]};
    for (int y = -ry; y <= ry; y++) {
        for (int x = -rx; x <= rx; x += GP_SHAPE_STRIP) {
            const int n = gp_min(rx + 1 - x, GP_SHAPE_STRIP);
            s->near.row(s->near.state, x, y, n, row);
            for (int i = 0; i < n; i++) {
                const double t = hypot(s->pixel[0] * (x + i), s->pixel[1] * y);
                for (int c = 0; c < channels; c++)
                    sum[c] += strip[c][i];
                if (t < 0.5 * s->reach || t >= 0.75 * s->reach)
                    continue;
                const int k = (int) direction(s, x + i, y);
                const double area = s->pixel[0] * s->pixel[1];
                shape[k] += falloff(t, s->reach) * area;
                all += falloff(t, s->reach) * area;
                for (int c = 0; c < channels; c++) {
                    light[k][c] += strip[c][i];
                    mean[c] += strip[c][i];
                }
            }
        }
    }
    for (int c = 0; c < channels; c++)
        mean[c] = all > 0.0 ? mean[c] / all : 0.0;
    // a direction without samples has the mean of all
    const double few = fmax(1e-6 * all, 1e-300);
    double total[3] = {0};
    for (int i = 0; i < TURN; i++) {
        double v[3] = {mean[0] * few, mean[1] * few, mean[2] * few}, w = few;
        for (int k = -wide; k <= wide; k++) {
            const double z = k * 360.0 / TURN / SIGMA;
            const double g = exp(-0.5 * z * z);
            const int at = (i + k + TURN) % TURN;
            w += g * shape[at];
            for (int c = 0; c < channels; c++)
                v[c] += g * light[at][c];
        }
        for (int c = 0; c < channels; c++) {
            s->light[i][c] = v[c] / w;
            total[c] += v[c] / w / TURN;
        }
    }
    memcpy(mean, total, sizeof total);
}

gp_status gp_diffract_join(const struct gp_log *log, int rx, int ry,
    double reach, const struct gp_field *f, struct gp_shape *shape)
{
    struct joined *s;
    double over[3], mean[3] = {0}, sum[3] = {0};
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *s, &s);
    if (st)
        return st;
    st = gp_radial_shape(log, mean_profile, &reach, 1, reach, f, &s->far);
    if (st) {
        gp_free(s);
        return st;
    }
    s->pixel[0] = f->degrees * f->aspect;
    s->pixel[1] = f->degrees;
    s->reach = reach;
    s->near = *shape;
    measure(s, rx, ry, mean, sum);
    gp_profile_integral(taking_over, &reach, 1, 0.75 * reach, reach, over);
    const double a = reach / 20.0; // and from the reach to infinity
    over[0] += 2.0 * GP_PI / sqrt(reach * reach + a * a);
    for (int c = 0; c < 3 && shape->fits[0] && shape->fits[1]; c++)
        s->own[c] = 1.0 - sum[c] - over[0] * mean[c];
    shape->state = s;
    shape->free = joined_free;
    shape->row = joined_row;
    shape->reach = INT_MAX;
    shape->rows = 0;
    shape->smooth = 0.75 * reach / (f->degrees * fmin(f->aspect, 1.0));
    shape->far = joined_far;
    shape->least = joined_least;
    shape->far_grey = shape->grey;
    shape->sharp = gp_max(rx, ry);
    return GP_OK;
}
