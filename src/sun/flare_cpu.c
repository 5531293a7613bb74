/* Flare elements in plain C, in float: the twin of shaders/flare.frag. */
#include "sun/sun_priv.h"

#include "core/cpu.h"
#include "core/minmax.h"

#include <math.h>

enum { RUN = 64 }; // pixels of a polygon at a time

/* Cuts [*lo, *hi] to the values of (limit - a * y) / b at four corners. */
static void narrow_span(double limit, double a, double b, const double y[2],
                        double *lo, double *hi)
{
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 4; i++) {
        const double x = ((i & 1 ? limit : -limit) - a * y[i >> 1]) / b;
        low = fmin(low, x);
        high = fmax(high, x);
    }
    *lo = fmax(*lo, low);
    *hi = fmin(*hi, high);
}

static float largest(const float v[3])
{
    return fmaxf(v[0], fmaxf(v[1], v[2]));
}

bool gp_flare_span(const struct gp_flare_quad *i, int y0, int y1, int *x0,
                   int *x1)
{
    const int top = y0 > i->rect.y0 ? y0 : i->rect.y0;
    const int bottom = y1 < i->rect.y1 ? y1 : i->rect.y1;
    *x0 = i->rect.x0;
    *x1 = i->rect.x1;
    if (top >= bottom)
        return false;
    if (i->shape == GP_FLARE_IMAGE)
        return true;
    const double y[2] = {top + 0.5 - i->y, bottom - 0.5 - i->y};
    double lo, hi;
    if (i->shape == GP_FLARE_STREAK) {
        const double c = (double) i->turn[0], s = (double) i->turn[1];
        lo = -INFINITY;
        hi = INFINITY;
        if (fabs(s) > 1e-6)
            narrow_span((double) largest(i->inner) + 1.0, c, s, y, &lo, &hi);
        if (fabs(c) > 1e-6)
            narrow_span((double) largest(i->radius) + 1.0, -s, c, y, &lo, &hi);
    } else { // around the place, for the rows' centre nearest to it
        const double radius = (double) largest(i->radius) + 1.0;
        const double d = y[0] > 0.0 ? y[0] : y[1] < 0.0 ? -y[1] : 0.0;
        hi = d < radius ? sqrt(radius * radius - d * d) : -1.0;
        lo = -hi;
    }
    lo += i->x - 1.0;
    hi += i->x + 1.0;
    if (lo > *x0)
        *x0 = lo < *x1 ? (int) lo : *x1;
    if (hi < *x1)
        *x1 = hi > *x0 ? (int) hi : *x0;
    return *x0 < *x1;
}

// -- shapes ------------------------------------------------------------------

/* Columns `from`, ... of a row, counted from the rect's corner. */
struct run {
    int from, n;
    float x, y;   // pixel's place: x + column, y
    float amount;
    float *out;
};

static struct run cut(const struct run *r, int first, int end)
{
    struct run part = *r;
    part.from += first;
    part.n = end - first;
    part.out += first;
    return part;
}

GP_CLONES static void add_flat(const struct run *r)
{
    for (int i = 0; i < r->n; i++)
        r->out[i] += r->amount;
}

GP_CLONES static void add_round(const struct run *r, float radius, float inner)
{
    const float x0 = r->x, y = r->y, tiny = 1e-20f, amount = r->amount;
    const float edge = gp_minf(radius, 0.5f), hole = gp_minf(inner, 0.5f);
    const int from = r->from;
    float *const out = r->out;
    for (int i = 0; i < r->n; i++) {
        const float x = x0 + (float) (from + i);
        const float rho = sqrtf(x * x + y * y);
        const float m = gp_maxf(fabsf(x), fabsf(y));
        const float slope = gp_maxf(rho, tiny) / gp_maxf(m, tiny);
        const float cover = gp_clamp01(edge + (radius - rho) * slope) -
                            gp_clamp01(hole + (inner - rho) * slope);
        out[i] += amount * cover;
    }
}

GP_CLONES static void meet_side(const struct run *r, const float *side,
                                float apothem, float *cover)
{
    const float nx = side[0], ny = side[1], steep = side[2];
    const float x0 = r->x, y = r->y;
    const int from = r->from;
    for (int i = 0; i < r->n; i++) {
        const float x = x0 + (float) (from + i);
        const float c = 0.5f + (apothem - (nx * x + ny * y)) * steep;
        cover[i] = gp_minf(cover[i], c);
    }
}

static void add_polygon(const struct run *r, const struct gp_flare_quad *q,
                        float apothem)
{
    for (int at = 0; at < r->n; at += RUN) {
        const struct run part = cut(r, at, r->n - at < RUN ? r->n : at + RUN);
        float cover[RUN];
        for (int i = 0; i < part.n; i++)
            cover[i] = 1.0f;
        for (int s = 0; s < q->sides; s++)
            meet_side(&part, q->edge + 3 * s, apothem, cover);
        for (int i = 0; i < part.n; i++)
            part.out[i] += part.amount * gp_maxf(cover[i], 0.0f);
    }
}

GP_CLONES static void add_streak(const struct run *r, const float turn[2],
                                 float radius, float half)
{
    const float x0 = r->x, y = r->y, amount = r->amount;
    const float c = turn[0], s = turn[1];
    const float steep = 1.0f / gp_maxf(fabsf(c), fabsf(s));
    const float share = 1.0f / radius;
    const int from = r->from;
    float *const out = r->out;
    for (int i = 0; i < r->n; i++) {
        const float x = x0 + (float) (from + i);
        const float v = fabsf(x * s + y * c);
        const float fade = gp_maxf(1.0f - fabsf(x * c - y * s) * share, 0.0f);
        const float cover = gp_clamp01(0.5f + (half - v) * steep) -
                            gp_clamp01(0.5f - (half + v) * steep);
        out[i] += amount * (cover * (fade * fade));
    }
}

// -- images ------------------------------------------------------------------

static float texel(const struct gp_flare_image *m, int c, int x, int y)
{
    return x < 0 || y < 0 || x >= m->w || y >= m->h
               ? 0.0f
               : m->rgb.c[c][(size_t) y * (size_t) m->w + (size_t) x];
}

static float blend(float a, float b, float t)
{
    return a * (1.0f - t) + b * t;
}

/* Far outside, where this texel and the next are none. */
static int clamp_texel(float v, int size)
{
    return (int) gp_maxf(-2.0f, gp_minf(v, (float) size));
}

static void add_image(const struct run *r, const struct gp_flare_quad *q, int c)
{
    const struct gp_flare_image *const m = q->image;
    const float cosine = q->turn[0] * q->radius[0];
    const float sine = q->turn[1] * q->radius[0];
    for (int i = 0; i < r->n; i++) {
        const float x = r->x + (float) (r->from + i);
        const float u = x * cosine - r->y * sine + q->inner[0] - 0.5f;
        const float v = x * sine + r->y * cosine + q->inner[1] - 0.5f;
        const float left = floorf(u), top = floorf(v);
        const int tx = clamp_texel(left, m->w), ty = clamp_texel(top, m->h);
        const float upper = blend(texel(m, c, tx, ty),
                                  texel(m, c, tx + 1, ty), u - left);
        const float lower = blend(texel(m, c, tx, ty + 1),
                                  texel(m, c, tx + 1, ty + 1), u - left);
        r->out[i] += r->amount * blend(upper, lower, v - top);
    }
}

GP_CLONES static void add_taps(const struct run *r, const float *upper,
                               const float *lower, float s, float t)
{
    float *const out = r->out;
    const float amount = r->amount;
    for (int i = 0; i < r->n; i++) {
        const float a = upper[i] * (1.0f - s) + upper[i + 1] * s;
        const float b = lower[i] * (1.0f - s) + lower[i + 1] * s;
        out[i] += amount * (a * (1.0f - t) + b * t);
    }
}

/* At its own pixels: all of a run have the same weights. */
static void add_plain(const struct run *r, const struct gp_flare_quad *q,
                      int c, int row)
{
    const struct gp_flare_image *const m = q->image;
    const float s = q->fraction[0], t = q->fraction[1];
    const int ty = q->corner[1] + row;
    const int tx = q->corner[0] + r->from; // texel of weight 1 - s
    const bool inside = ty >= 0 && ty + 1 < m->h;
    const int first = tx < 0 ? -tx : 0;
    const int end = m->w - 1 - tx < r->n ? m->w - 1 - tx : r->n;
    for (int i = 0; i < r->n; i++) {
        if (inside && i >= first && i < end) {
            const struct run part = cut(r, i, end);
            const float *const at = m->rgb.c[c] + (size_t) ty * (size_t) m->w +
                (size_t) (tx + i);
            add_taps(&part, at, at + m->w, s, t);
            i = end - 1;
            continue;
        }
        const float a = blend(texel(m, c, tx + i, ty),
                              texel(m, c, tx + i + 1, ty), s);
        const float b = blend(texel(m, c, tx + i, ty + 1),
                              texel(m, c, tx + i + 1, ty + 1), s);
        r->out[i] += r->amount * blend(a, b, t);
    }
}

void gp_flare_add_row(const struct gp_flare_quad *q, int c, int y, int x0,
                      int x1, float amount, float *out)
{
    const int row = y - q->rect.y0;
    const struct run r = {
        .from = x0 - q->rect.x0, .n = x1 - x0, .x = q->base[0],
        .y = q->base[1] + (float) row, .amount = amount, .out = out,
    };
    if (q->plain) {
        add_plain(&r, q, c, row);
        return;
    }
    if (q->shape == GP_FLARE_IMAGE) {
        add_image(&r, q, c);
        return;
    }
    if (q->shape == GP_FLARE_STREAK) {
        add_streak(&r, q->turn, q->radius[c], q->inner[c]);
        return;
    }
    // ramps, flat light (or the hole of a ring) between them, ramps: only
    // pixels within a pixel of an edge need a ramp
    const float flat = q->shape == GP_FLARE_DISC ? q->radius[c] : q->inner[c];
    const float radius = flat - 1.0f;
    // the part whose pixels lie all within the radius
    const double d = (double) radius * (double) radius -
                     (double) r.y * (double) r.y;
    const double half = radius > 0.0f && d > 0.0 ? sqrt(d) : -1.0;
    const double x = (double) r.x + r.from; // of the run's first pixel
    const double lo = ceil(-half - x), hi = floor(half - x) + 1.0;
    const int first = lo < 0.0 ? 0 : lo > r.n ? r.n : (int) lo;
    const int end = hi > r.n ? r.n : hi < first ? first : (int) hi;
    const struct run flat_run = cut(&r, first, end);
    const struct run ramps[2] = {cut(&r, 0, first), cut(&r, end, r.n)};
    for (int i = 0; i < 2; i++) {
        if (q->shape == GP_FLARE_POLYGON)
            add_polygon(&ramps[i], q, q->inner[c]);
        else
            add_round(&ramps[i], q->radius[c], q->inner[c]);
    }
    if (q->shape != GP_FLARE_RING)
        add_flat(&flat_run);
}
