// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_priv.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <stdint.h>

const struct gp_paper_rate gp_paper_rates[GP_PAPER_KINDS] = {
    [GP_PAPER_POINTS] = {"points", "best", 120},
    [GP_PAPER_WINDOWS] = {"windows", "average", 60},
    [GP_PAPER_SKY] = {"sky", "worst", 40},
};

// -- numbers -----------------------------------------------------------------

/* SplitMix64 (Steele, Lea, Flood 2014). */
static uint64_t mix(uint64_t x)
{
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/* In [0, 1). */
static double roll(uint64_t *dice)
{
    return (double) (mix(*dice += 0x9e3779b97f4a7c15u) >> 11) * 0x1p-53;
}

static double between(uint64_t *dice, double low, double high)
{
    return low + (high - low) * roll(dice);
}

/* Spread over octaves from `low`: about log-uniform, without a logarithm. */
static double octaves(uint64_t *dice, double low, double high)
{
    double v = low * (1.0 + roll(dice));
    int doublings = 0;
    for (double top = 2.0 * low; top < high; top *= 2.0)
        doublings++;
    for (int n = (int) (roll(dice) * (doublings + 1)); n > 0; n--)
        v *= 2.0;
    return v < high ? v : high;
}

/* Value noise in [0, 1): random at whole x and y, smooth between. */
static double noise(uint64_t seed, double x, double y)
{
    const int64_t ix = (int64_t) floor(x), iy = (int64_t) floor(y);
    const double fx = gp_smoothstep(x - (double) ix);
    const double fy = gp_smoothstep(y - (double) iy);
    double corner[4];
    for (int i = 0; i < 4; i++) {
        const uint64_t at = (uint64_t) (ix + i % 2) * 0x9e3779b97f4a7c15u +
                            (uint64_t) (iy + i / 2) * 0xc2b2ae3d27d4eb4fu;
        corner[i] = (double) (mix(mix(at) + seed) >> 11) * 0x1p-53;
    }
    const double top = corner[0] + fx * (corner[1] - corner[0]);
    const double low = corner[2] + fx * (corner[3] - corner[2]);
    return top + fy * (low - top);
}

// -- light -------------------------------------------------------------------

/* Pixels of the frames that are painted. */
enum { W = GP_PAPER_W, H = GP_PAPER_H };

/* A colour of luminance 1. */
struct tint {
    double c[3];
};

static struct tint tint_of(double r, double g, double b)
{
    const float *const k = gp_rec709_luminance;
    const double y = (double) k[0] * r + (double) k[1] * g + (double) k[2] * b;
    return (struct tint) {{r / y, g / y, b / y}};
}

static struct tint random_tint(uint64_t *dice, struct tint low)
{
    double c[3];
    for (int i = 0; i < 3; i++)
        c[i] = between(dice, low.c[i], 1.0);
    return tint_of(c[0], c[1], c[2]);
}

static void add_light(const struct gp_frame *f, int x, int y,
                      const struct tint *t, double luminance)
{
    for (int c = 0; c < 3; c++)
        f->rgb.c[c][y * W + x] += (float) (luminance * t->c[c]);
}

static void set_light(const struct gp_frame *f, int x, int y,
                      const struct tint *t, double luminance)
{
    for (int c = 0; c < 3; c++)
        f->rgb.c[c][y * W + x] = 0.0f;
    add_light(f, x, y, t, luminance);
}

/* Points of light between pixels, each on its four neighbours. */
static void paint_points(const struct gp_frame *f)
{
    enum { POINTS = 32 };
    static const struct tint least = {{0.5, 0.5, 0.5}};
    uint64_t dice = 11;
    for (int i = 0; i < POINTS; i++) {
        const struct tint t = random_tint(&dice, least);
        const double x = between(&dice, 2.0, W - 4);
        const double y = between(&dice, 2.0, H - 4);
        const double luminance = octaves(&dice, 10.0, 5000.0);
        const int ix = (int) x, iy = (int) y;
        const double fx = x - ix, fy = y - iy;
        for (int k = 0; k < 4; k++) // by their nearness
            add_light(f, ix + k % 2, iy + k / 2, &t,
                      luminance * (k % 2 ? fx : 1.0 - fx) *
                          (k / 2 ? fy : 1.0 - fy));
    }
}

/* Lit rooms seen through windows: brighter towards a room's lamp, darker where
 * a curtain is on one side, whose folds are 3 pixels wide; and street lamps. */
static void paint_windows(const struct gp_frame *f)
{
    enum { ACROSS = 16, DOWN = 12, LAMPS = 6 };
    static const struct tint room = {{0.8, 0.6, 0.3}};
    static const struct tint least = {{0.7, 0.6, 0.4}};
    uint64_t dice = 22;
    for (int i = 0; i < ACROSS * DOWN; i++) {
        struct gp_rect r = {W * (10 * (i % ACROSS) + 3) / (10 * ACROSS),
                            H * (10 * (i / ACROSS) + 3) / (10 * DOWN), 0, 0};
        r.x1 = r.x0 + W * 26 / (100 * ACROSS);
        r.y1 = r.y0 + H * 35 / (100 * DOWN);
        if (roll(&dice) >= 1.0 / 3.0)
            continue;
        const struct tint t = random_tint(&dice, room);
        const double luminance = octaves(&dice, 5.0, 50.0);
        const double lamp_x = roll(&dice), lamp_y = roll(&dice);
        const double curtain = between(&dice, -0.5, 0.5); // < 0: none
        const bool left = roll(&dice) < 0.5;
        for (int y = r.y0; y < r.y1; y++) {
            for (int x = r.x0; x < r.x1; x++) {
                const double u = (x - r.x0 + 0.5) / gp_rect_w(r);
                const double s = (y - r.y0 + 0.5) / gp_rect_h(r);
                const double du = u - lamp_x, ds = s - lamp_y;
                double l = luminance / (1.0 + 0.8 * (du * du + ds * ds));
                if ((left ? u : 1.0 - u) < curtain)
                    l *= (x - r.x0) % 3 == 0 ? 0.3 : 0.45;
                set_light(f, x, y, &t, l);
            }
        }
    }
    for (int i = 0; i < LAMPS; i++) {
        const struct tint t = random_tint(&dice, least);
        const double x = between(&dice, 4.0, W - 5);
        const double y = between(&dice, 0.8 * H, H - 5);
        const double luminance = octaves(&dice, 100.0, 5000.0);
        const double radius = between(&dice, 0.7, 2.0); // fades within a pixel
        const int reach = (int) radius + 2;
        const struct gp_rect r = {(int) x - reach, (int) y - reach,
                                  (int) x + reach, (int) y + reach};
        for (int j = gp_max(r.y0, 0); j <= gp_min(r.y1, H - 1); j++) {
            for (int k = gp_max(r.x0, 0); k <= gp_min(r.x1, W - 1); k++) {
                const double dx = k - x, dy = j - y;
                const double in = radius + 0.5 - sqrt(dx * dx + dy * dy);
                if (in > 0.0)
                    add_light(f, k, j, &t, luminance * (in < 1.0 ? in : 1.0));
            }
        }
    }
}

static void paint_sky(const struct gp_frame *f)
{
    const struct tint blue = tint_of(0.8, 1.0, 1.3);
    for (int x = 0; x < W; x++) {
        const double u = (double) x / H;
        const double horizon = H * (0.57 + 0.08 * noise(31, 3.0 * u, 0.0) +
                                       0.02 * noise(32, 29.0 * u, 0.0));
        for (int y = 0; y < (int) horizon; y++) {
            const double t = (double) y / H;
            const double cloud = 0.55 * noise(33, 5.0 * u, 7.0 * t) +
                                 0.3 * noise(34, 17.0 * u, 23.0 * t) +
                                 0.15 * noise(35, 61.0 * u, 71.0 * t);
            set_light(f, x, y, &blue, 2.1 + 17.8 * cloud);
        }
    }
}

static gp_status make_frame(const struct gp_log *log, const char *name, int w,
                            int h, struct gp_frame *out)
{
    struct gp_frame f = gp_frame_blank((struct gp_rect) {0, 0, w, h});
    f.path = gp_strdup(name);
    gp_status st = f.path ? gp_planes_make(log, name, gp_frame_pixels(&f),
                                           &f.rgb)
                          : gp_no_memory(log, name);
    if (st)
        gp_frame_free(&f);
    else
        *out = f;
    return st;
}

gp_status gp_paper_frame(const struct gp_log *log, enum gp_paper_kind kind,
                         struct gp_frame *out)
{
    static void (*const paint[GP_PAPER_KINDS])(const struct gp_frame *) = {
        [GP_PAPER_POINTS] = paint_points, [GP_PAPER_WINDOWS] = paint_windows,
        [GP_PAPER_SKY] = paint_sky,
    };
    gp_status st = make_frame(log, gp_paper_rates[kind].name, W, H, out);
    if (st)
        return st;
    const uint64_t seed = 100 * (uint64_t) (kind + 1);
    const struct tint warm = tint_of(1.0, 0.95, 0.85);
    for (int y = 0; y < H; y++) { // the background: 0.05 to 0.8
        for (int x = 0; x < W; x++) {
            const double u = (double) x / H, t = (double) y / H;
            const double n = 0.5 * noise(seed, 4.0 * u, 4.0 * t) +
                             0.3 * noise(seed + 1, 16.0 * u, 16.0 * t) +
                             0.2 * noise(seed + 2, 97.0 * u, 97.0 * t);
            set_light(out, x, y, &warm, 0.05 + 0.75 * n);
        }
    }
    paint[kind](out);
    return GP_OK;
}

struct streak {
    double x, y;      // direction, a unit vector
    double strength;
};

enum { STREAKS = 44, STRONG = 8 };

gp_status gp_paper_kernel(const struct gp_log *log, struct gp_frame *out)
{
    static const double spread[3] = {1.06, 1.0, 0.93}; // red scatters widest
    enum { size = GP_PAPER_KERNEL };
    struct streak s[STREAKS];
    gp_status st = make_frame(log, "kernel", size, size, out);
    if (st)
        return st;
    // 8 strong ones that cross, the others anywhere and weaker. Directions are
    // ((1 - t^2), 2 t) / (1 + t^2), points of the circle without a sine
    uint64_t dice = 7;
    for (int i = 0; i < STREAKS; i++) {
        const double t = i < STRONG ? 0.47 * (i / 2) - 0.9
                                    : between(&dice, -1.0, 1.0);
        const double side = i % 2 ? -1.0 : 1.0, q = 1.0 + t * t;
        s[i].x = side * (1.0 - t * t) / q;
        s[i].y = side * 2.0 * t / q;
        s[i].strength = i < STRONG ? 8.0 : 2.0 * roll(&dice) * roll(&dice);
    }
    const double half = size / 2;
    for (int c = 0; c < 3; c++) {
        float *to = out->rgb.c[c];
        for (int y = 0; y < size; y++) {
            for (int x = 0; x < size; x++) {
                const double u = x - size / 2, v = y - size / 2;
                const double r2 = (u * u + v * v) / (spread[c] * spread[c]);
                const double r = sqrt(r2), a = r2 + 1.5;
                double light = 1.0 / (a * sqrt(sqrt(a))) + 0.02 / (r2 + 60.0);
                double streaks = 0.0;
                for (int i = 0; i < STREAKS; i++) {
                    const double along = u * s[i].x + v * s[i].y;
                    const double across = (u * s[i].y - v * s[i].x) / 0.7;
                    const double q = 1.0 + across * across;
                    if (along > 0.0)
                        streaks += s[i].strength / (q * q);
                }
                light += 0.02 * streaks / ((r + 3.0) * sqrt(r + 3.0));
                // fades over the last sixth, and ends inside the border
                const double left = half - sqrt(u * u + v * v);
                *to++ = (float) (light * gp_smoothstep(left / (half / 6.0)));
            }
        }
    }
    return GP_OK;
}
