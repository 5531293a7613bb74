/* Needles of the ciliary corona, integrated over pixels. */
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

enum { CIRCLE = 1 << 14 }; // steps of m

/* Pixels as near as this, in columns and in rows, take points of rings. */
enum { NEAR = 3 };

struct needling {
    const struct gp_needles *of;
    double a, b, turn; // degrees of a pixel; turns
    int rx, ry;
    float *out;
    double *sum; // that rows add
    // by steps of a turn, both periodic: the integral of m - 1, and of that
    double first[CIRCLE + 1], second[CIRCLE + 1];
};

double gp_needle_fade(double t)
{
    const double end = fmin(fmax(2.0 * (1.0 - t / GP_NEEDLE_END), 0.0), 1.0);
    return end * end * (3.0 - 2.0 * end);
}

/* Makes m, of mean 1, and its integrals. */
static void make_circle(const struct gp_recipe *r, struct needling *out)
{
    const int n = (int) gp_recipe_value(r, "needles");
    const uint64_t seed = (uint64_t) gp_recipe_value(r, "seed");
    double *const sum = out->first, total = 0.0, mean = 0.0;
    memset(sum, 0, sizeof out->first);
    for (int i = 0; i < n; i++) {
        const uint64_t key = 3 * (uint64_t) i;
        const double at = CIRCLE * gp_model_random(seed, key);
        // a few are strong, as of an exponential distribution
        const double strength = -log(1.0 - gp_model_random(seed, key + 1));
        const double width = CIRCLE * (0.3 + gp_model_random(seed, key + 2)) *
                             0.35 / fmax(n, 32.0);
        const int reach = (int) ceil(4.0 * width);
        for (int k = -reach; k <= reach; k++) {
            const double z = (floor(at) + k + 0.5 - at) / width;
            const double v = strength * exp(-0.5 * z * z) / width;
            const int step = (((int) at + k) % CIRCLE + CIRCLE) % CIRCLE;
            sum[step + 1] += v;
            total += v;
        }
    }
    for (int i = 0; i < CIRCLE; i++) {
        const double more = GP_NEEDLE_CONTRAST *
                            (sum[i + 1] / total - 1.0 / CIRCLE);
        sum[i + 1] = sum[i] + more;
        mean += (sum[i] + 0.5 * more) / CIRCLE;
    }
    for (int i = 0; i <= CIRCLE; i++)
        sum[i] -= mean;
    out->second[0] = 0.0;
    for (int i = 0; i < CIRCLE; i++)
        out->second[i + 1] =
            out->second[i] + 0.5 * (sum[i] + sum[i + 1]) / CIRCLE;
}

/* The second integral at a place in turns, from -8 on. */
static inline double second_at(const struct needling *m, double turns)
{
    const double at = (turns + 8.0) * CIRCLE;
    const int step = (int) at, i = step % CIRCLE;
    const double x = at - step, p = m->first[i], q = m->first[i + 1];
    return m->second[i] + x * (p + 0.5 * x * (q - p)) / CIRCLE;
}

/* The corona that needles have t degrees from the light, per square degree. */
static double corona_at(const struct gp_needles *n, double t)
{
    const double near = 1.0 / (t + 0.02), r = t * M_PI / 180.0, rr = r * r;
    const double plane = (M_PI / 180.0) * (M_PI / 180.0) *
                         (1.0 - rr / 6.0 * (1.0 - rr / 20.0)); // sin(r) / r
    return plane * near * near * (n->f1 * near + n->f2) * gp_needle_fade(t);
}

/* Adds the needles of the pixels (x, y), (-x, y), (x, -y) and (-x, -y) to v:
 * counter-clockwise from the upper right, y is down. Across rays, along the
 * pixel's side that they cross, light times the tent is taken as straight in
 * the angle between a few places, so that m enters by its second integral at
 * them, however narrow needles are; along them, by a rule of quadrature. */
static void add_pixel(const struct needling *m, int x, int y, double v[4])
{
    enum { MOST = 4 };
    const bool steep = y > x;
    const int along = steep ? y : x, across = steep ? x : y;
    const double a = steep ? m->b : m->a, b = steep ? m->a : m->b;
    const int steps = along < 8 ? 4 : along < 24 ? 2 : 1;
    const struct gp_gauss *const g =
        gp_tent_rule(along < 8 ? 6 : along < 24 ? 4 : 2);
    for (int k = 0; k < g->n; k++) {
        const double u = a * (along + g->node[k]);
        double before = 0.0, turns = 0.0, last[4] = {0};
        for (int i = -steps; i <= steps; i++) { // by angles that grow
            const double offset = (double) (steep ? -i : i) / steps;
            const double w = b * (across + offset);
            const double tent = 1.0 - fabs(offset);
            const double ss = u * u + w * w;
            const double light = // a turn
                tent > 0.0 ? a * g->weight[k] * tent * 2.0 * M_PI * ss / u *
                                 corona_at(m->of, sqrt(ss)) : 0.0;
            const double angle =
                (steep ? atan2(u, w) : atan2(w, u)) / (2.0 * M_PI);
            const double slope = (light - before) / (angle - turns);
            const double at[4] = {angle, 0.5 - angle, 0.5 + angle, -angle};
            for (int q = 0; q < 4; q++) {
                const double here = second_at(m, at[q] - m->turn);
                if (i > -steps)
                    v[q] -= slope * (here - last[q]);
                last[q] = here;
            }
            before = light;
            turns = angle;
        }
    }
}

/* The needles of the pixels y rows above and below the light. */
static void needle_row(void *ctx, int y, int thread)
{
    const struct needling *const m = ctx;
    const size_t w = 2 * (size_t) m->rx + 1;
    float *const up = m->out + (size_t) (m->ry - y) * w + m->rx;
    float *const down = m->out + (size_t) (m->ry + y) * w + m->rx;
    double sum = 0.0;
    (void) thread;
    for (int x = y > NEAR ? 0 : NEAR + 1; x <= m->rx; x++) {
        const double nearest = hypot(m->a * fmax(x - 1.0, 0.0),
                                     m->b * fmax(y - 1.0, 0.0));
        if (nearest >= GP_NEEDLE_END)
            break;
        double v[4] = {0};
        add_pixel(m, x, y, v);
        for (int k = 0; k < 4; k++) {
            const bool left = k == 1 || k == 2, low = k >= 2;
            if ((left && x == 0) || (low && y == 0))
                continue;
            float *const to = (low ? down : up) + (left ? -x : x);
            *to = (float) v[k];
            sum += (double) *to;
        }
    }
    m->sum[y] = sum;
}

/* Fills the pixels within NEAR by points of rings, and adds them to `sum`, but
 * the light's own. */
static gp_status add_near(const struct gp_log *log, const struct needling *m,
                          double *sum)
{
    enum { ANGLES = 1024, FEW = 256 };
    static const double RATIO = 0.1, STEP = 0.07, LEAST = 1e-4;
    struct gp_deposit d = {0};
    const double side = fmin(m->a, m->b);
    const double end = fmin(GP_NEEDLE_END,
                            hypot(m->a * (NEAR + 1), m->b * (NEAR + 1)));
    gp_status st = gp_deposit_make(log, 1, NEAR, NEAR, &d);
    if (st)
        return st;
    for (double t = LEAST * side; t < end;) {
        const double step = fmin(fmin(RATIO * t, STEP * side), end - t);
        const double mid = t + 0.5 * step;
        const double ring = 2.0 * M_PI * mid * step * corona_at(m->of, mid);
        const int angles = t < side / 2.0 ? FEW : ANGLES;
        const int steps = CIRCLE / angles;
        for (int i = 0; i < angles; i++) {
            const double more =
                m->first[(i + 1) * steps] - m->first[i * steps];
            const double angle = 2.0 * M_PI * ((i + 0.5) / angles + m->turn);
            gp_deposit_add(&d, mid * (cos(angle) / m->a),
                           mid * (-sin(angle) / m->b),
                           (const double[3]) {ring * more});
        }
        t = step < end - t ? t + step : end;
    }
    for (int y = -NEAR; y <= NEAR; y++) {
        for (int x = -NEAR; x <= NEAR; x++) {
            if (abs(y) > m->ry || abs(x) > m->rx || (x == 0 && y == 0))
                continue;
            float *const to = m->out + (size_t) (y + m->ry) *
                              (2 * (size_t) m->rx + 1) + (size_t) (x + m->rx);
            *to = (float) d.v[0][(y + NEAR) * (2 * NEAR + 1) + x + NEAR];
            *sum += (double) *to;
        }
    }
    gp_deposit_free(&d);
    return GP_OK;
}

gp_status gp_needles_make(const struct gp_log *log, const struct gp_recipe *r,
    const struct gp_needles *n, const struct gp_field *f, int rx, int ry,
    float **out)
{
    gp_status st;
    struct needling *m = NULL;
    double *sum = NULL, rest = 0.0;
    const size_t w = 2 * (size_t) rx + 1, h = 2 * (size_t) ry + 1;
    *out = NULL;
    GP_TRY(gp_alloc(log, "kernel", 1, sizeof *m, &m));
    GP_TRY(gp_alloc(log, "kernel", (size_t) ry + 1, sizeof *sum, &sum));
    GP_TRY(gp_alloc_zero(log, "kernel", w * h, sizeof **out, out));
    m->of = n;
    m->a = f->degrees * f->aspect;
    m->b = f->degrees;
    m->turn = fmod(f->rotate / 360.0, 1.0);
    m->rx = rx;
    m->ry = ry;
    m->out = *out;
    m->sum = sum;
    make_circle(r, m);
    gp_parallel_do(ry + 1, needle_row, m);
    GP_TRY(add_near(log, m, &rest));
    for (int y = 0; y <= ry; y++)
        rest += sum[y];
    (*out)[(size_t) ry * w + (size_t) rx] = (float) -rest;
out:
    gp_free(m);
    gp_free(sum);
    return st;
}
