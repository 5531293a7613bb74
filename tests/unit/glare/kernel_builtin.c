/* glare/kernel_builtin.c: laws that hold for each builtin kernel, and its
 * formula. */
#include "unit.h"
#include "core/colour.h"
#include "glare/glare_priv.h"
#include "glare_scene.h"

static struct gp_kernel builtin_of(const char *name, int size)
{
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_kernel k;
    p.source = name;
    p.builtin_size = size;
    if (gp_kernel_builtin(NULL, &p, &k) != GP_OK)
        fail_msg("%s at size %d", name, size);
    return k;
}

static double at(const struct gp_kernel *k, int c, int dx, int dy)
{
    return (double) scene_at(k, c, dx, dy);
}

static double luminance(const struct gp_kernel *k)
{
    return 0.2126 * k->sum[0] + 0.7152 * k->sum[1] + 0.0722 * k->sum[2];
}

/* Each builtin at each size holds light, no negative and no tiny value (which
 * a CPU is slow with), sums to 1 in luminance, and is the same turned by half
 * a turn. */
static void are_light(void **state)
{
    static const int sizes[] = {1, 3, 5, 31, 65, 255, 511};
    for (const struct gp_builtin_kernel *b = gp_builtin_kernels; b->name; b++) {
        for (size_t i = 0; i < COUNT(sizes); i++) {
            struct gp_kernel k = builtin_of(b->name, sizes[i]);
            assert_true(fabs(luminance(&k) - 1.0) < 1e-6);
            assert_true(k.norm1[1] == k.sum[1] && k.norm2[1] <= k.norm1[1]);
            assert_false(k.negative);
            assert_true(k.cx < k.w && k.cy < k.h && k.cx >= 0 && k.cy >= 0);
            const int n = k.w * k.h;
            for (int c = 0; c < 3; c++) {
                for (int j = 0; j < n; j++) {
                    const float v = k.k.c[c][j], w = k.k.c[c][n - 1 - j];
                    if (!(v == 0.0f || v >= FLT_MIN) ||
                        !(fabsf(v - w) <= 1e-5f * v + 1e-12f))
                        fail_msg("%s at size %d: sample %d is %g, %g opposite",
                                 b->name, sizes[i], j, (double) v, (double) w);
                }
            }
            gp_kernel_free(&k);
        }
    }
}

/* Numbers of BT.709 in frames of other primaries: the same light there, sample
 * by sample, but for the scale that makes the luminance sum 1 by the frame's
 * weights (a white of its own gives a colour another luminance). */
/* In a frame of CIE XYZ, whose white is not (1,1,1), a kernel's X, Y and Z are
 * fractions of those of white. */
static void white_is_scattered_as_white_in_xyz(void **state)
{
    const struct gp_frame f = {
        .pixel_aspect = 1.0f, .luminance = {0, 1, 0},
        .chromaticities = {1, 0, 0, 1, 0, 0, 1.0f / 3, 1.0f / 3},
    };
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_kernel k, rec709 = builtin_of("star", 65);
    double xyz[9];
    assert_true(gp_rgb_to_xyz(gp_rec709_chromaticities, xyz));
    p.source = "star";
    p.builtin_size = 65;
    p.frame = &f;
    assert_ok(gp_kernel_builtin(NULL, &p, &k));
    for (int c = 0; c < 3; c++) {
        const double *const m = xyz + 3 * c;
        const double light = (m[0] * rec709.sum[0] + m[1] * rec709.sum[1] +
                              m[2] * rec709.sum[2]) / (m[0] + m[1] + m[2]);
        assert_close(k.sum[c], light, 1e-4);
    }
    gp_kernel_free(&k);
    gp_kernel_free(&rec709);
}

static void are_made_in_the_frames_primaries(void **state)
{
    static const float primaries[][8] = {
        {0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f}, // AP0
        {0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f},
        {0.68f, 0.32f, 0.265f, 0.69f, 0.15f, 0.06f, 0.3127f, 0.329f}, // P3
    };
    for (const struct gp_builtin_kernel *b = gp_builtin_kernels; b->name; b++) {
        struct gp_kernel rec709 = builtin_of(b->name, 65);
        assert_true(rec709.grey != b->coloured);
        for (size_t i = 0; i < COUNT(primaries); i++) {
            struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
            struct gp_frame f = {.pixel_aspect = 1.0f};
            struct gp_kernel k;
            double back[9], sum = 0.0;
            memcpy(f.chromaticities, primaries[i], sizeof f.chromaticities);
            gp_luminance_weights(f.chromaticities, f.luminance);
            assert_true(gp_rgb_to_rgb(f.chromaticities,
                                      gp_rec709_chromaticities, back));
            p.source = b->name;
            p.builtin_size = 65;
            p.frame = &f;
            assert_ok(gp_kernel_builtin(NULL, &p, &k));
            for (int c = 0; c < 3; c++)
                sum += (double) f.luminance[c] * k.sum[c];
            assert_close(sum, 1.0, 1e-6);
            assert_false(k.negative);
            assert_int_equal(k.w, rec709.w);
            const double scale = (back[3] * k.sum[0] + back[4] * k.sum[1] +
                                  back[5] * k.sum[2]) / rec709.sum[1];
            assert_close(scale, 1.0, b->coloured ? 0.02 : 1e-6);
            for (int j = 0; j < k.w * k.h; j++) {
                const double green = back[3] * (double) k.k.c[0][j] +
                                     back[4] * (double) k.k.c[1][j] +
                                     back[5] * (double) k.k.c[2][j];
                const double red = back[0] * (double) k.k.c[0][j] +
                                   back[1] * (double) k.k.c[1][j] +
                                   back[2] * (double) k.k.c[2][j];
                if (fabs(green - scale * (double) rec709.k.c[1][j]) > 2e-6 ||
                    fabs(red - scale * (double) rec709.k.c[0][j]) > 2e-6)
                    fail_msg("%s, primaries %zu, sample %d: %g, %g; %g, %g",
                             b->name, i, j, red, green,
                             (double) rec709.k.c[0][j],
                             (double) rec709.k.c[1][j]);
            }
            gp_kernel_free(&k);
        }
        gp_kernel_free(&rec709);
    }
}

/* Nothing ends at once: no step on the kernel's own border, seen against its
 * largest value, for kernels with room to fade. */
static void end_softly(void **state)
{
    for (const struct gp_builtin_kernel *b = gp_builtin_kernels; b->name; b++) {
        struct gp_kernel k = builtin_of(b->name, 511);
        double peak = 0.0, border = 0.0;
        for (int y = 0; y < k.h; y++) {
            for (int x = 0; x < k.w; x++) {
                const bool edge = x == 0 || y == 0 || x == k.w - 1 ||
                                  y == k.h - 1;
                for (int c = 0; c < 3; c++) {
                    const double v = at(&k, c, x - k.cx, y - k.cy);
                    peak = fmax(peak, v);
                    border = fmax(border, edge ? v : 0.0);
                }
            }
        }
        if (!(border <= 1e-2 * peak))
            fail_msg("%s: %g on its border, %g at its peak", b->name, border,
                     peak);
        gp_kernel_free(&k);
    }
}

static void have_their_colours(void **state)
{
    static const struct {
        const char *name;
        bool grey;
    } rows[] = {{"eye", true}, {"streak", false}, {"star", false},
                {"cross", true}, {"circle", true}, {"ring", false}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel k = builtin_of(rows[i].name, 255);
        assert_int_equal(k.grey, rows[i].grey);
        gp_kernel_free(&k);
    }
    struct gp_kernel k = builtin_of("streak", 511);
    assert_true(k.sum[2] > 2.0 * k.sum[1] && k.sum[1] > k.sum[0]);
    gp_kernel_free(&k);
    k = builtin_of("ring", 511); // by the sequence of wavelengths, from within
    for (int c = 0; c < 3; c++) {
        static const int radius[3] = {113, 102, 86};
        for (int other = 0; other < 3; other++)
            assert_true(at(&k, c, radius[c], 0) >= at(&k, other, radius[c], 0));
    }
    assert_true(at(&k, 1, 0, 0) == 0.0);
    gp_kernel_free(&k);
}

/* The header's formulas, by ratios of samples within half the radius, where
 * nothing has faded. */
static void follow_their_formulas(void **state)
{
    const double r = 511 / 2.0;
    static const double l[3] = {0.15, 0.2, 0.3};
    struct gp_kernel k = builtin_of("builtin:streak", 511);
    for (int c = 0; c < 3; c++) {
        const double got = at(&k, c, 100, 0) / at(&k, c, 0, 0);
        assert_true(fabs(got / exp(-100.0 / (l[c] * r)) - 1.0) < 1e-5);
        assert_true(at(&k, c, -100, 0) == at(&k, c, 100, 0));
        assert_true(at(&k, c, 100, 6) == 0.0);
    }
    gp_kernel_free(&k);
    k = builtin_of("cross", 511);
    assert_true(fabs(at(&k, 0, 100, 0) / at(&k, 0, 50, 0) /
                     exp(-50.0 / (0.2 * r)) - 1.0) < 1e-5);
    assert_true(at(&k, 0, 100, 0) == at(&k, 0, 0, -100));
    gp_kernel_free(&k);
    k = builtin_of("star", 511); // its rays stand at 90, 30 and 150 degrees
    const double u = 100.0 / (r / 40.0), v = 50.0 / (r / 40.0);
    assert_true(fabs(at(&k, 1, 0, 100) / at(&k, 1, 0, 50) /
                     ((1.0 + v * v) / (1.0 + u * u)) - 1.0) < 1e-5);
    assert_true(at(&k, 0, 0, 100) > at(&k, 2, 0, 100));
    assert_true(at(&k, 1, 87, 50) > 0.5 * at(&k, 1, 0, 100));
    assert_true(at(&k, 1, 100, 0) == 0.0);
    gp_kernel_free(&k);
    k = builtin_of("circle", 511);
    assert_true(at(&k, 0, 0, 0) == at(&k, 0, 111, 0));
    assert_true(fabs(at(&k, 0, 120, 0) / at(&k, 0, 0, 0) - 0.4774) < 1e-2);
    assert_true(at(&k, 0, 128, 0) == 0.0);
    gp_kernel_free(&k);
}

// -- the eye, against brute-force quadrature and closed forms -----------------

#define PI 3.14159265358979323846
#define RADIAN (PI / 180.0)

/* Spencer et al. 1995, as printed: degrees in, per steradian out. */
static double f0(double t)
{
    return 2.61e6 * exp(-(t / 0.02) * (t / 0.02));
}

static double f1(double t)
{
    return 20.91 / pow(t + 0.02, 3.0);
}

static double f2(double t)
{
    return 72.37 / pow(t + 0.02, 2.0);
}

static double photopic(double t)
{
    return 0.384 * f0(t) + 0.478 * f1(t) + 0.138 * f2(t);
}

/* Five-point Gauss-Legendre over a cell, in pixels. */
static double cell(double x, double y, double side)
{
    static const double node[5] = {
        -0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
        0.906179845938664,
    };
    static const double weight[5] = {
        0.236926885056189, 0.478628670499366, 0.568888888888889,
        0.478628670499366, 0.236926885056189,
    };
    const double pitch = GP_EYE_DEGREES_PER_PIXEL;
    double sum = 0.0;
    for (int j = 0; j < 5; j++) {
        for (int i = 0; i < 5; i++)
            sum += weight[i] * weight[j] *
                   photopic(pitch * hypot(x + 0.5 * side * (1 + node[i]),
                                          y + 0.5 * side * (1 + node[j])));
    }
    return 0.25 * sum * side * side * pitch * pitch * RADIAN * RADIAN;
}

/* Quarters every cell that is wide for its distance from the cusp. */
static double brute(double x, double y, double side)
{
    double dx = x > 0 ? x : x + side < 0 ? -(x + side) : 0.0;
    double dy = y > 0 ? y : y + side < 0 ? -(y + side) : 0.0;
    if (side < 1e-9)
        return 0.0; // 1e-18 of the pixel's area, at most 1e-15 of its light
    if (side <= 0.25 && side <= 0.5 * hypot(dx, dy))
        return cell(x, y, side);
    double h = 0.5 * side;
    return brute(x, y, h) + brute(x + h, y, h) + brute(x, y + h, h) +
           brute(x + h, y + h, h);
}

static void eye_is_integrated(void **state)
{
    static const int rows[][2] = {
        {0, 0}, {1, 0}, {1, 1}, {2, 0}, {2, 2}, {3, 1}, {4, 4},
        {5, 0}, {5, 5}, {7, 3}, {11, 0}, {12, 0}, {12, 12}, {15, 4},
        {16, 1}, {23, 0}, {24, 0}, {24, 24}, {40, 7}, {100, 99}, {255, 0},
        {255, 255},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        int x = rows[i][0], y = rows[i][1];
        assert_close(gp_eye_share(x, y), brute(x - 0.5, y - 0.5, 1.0), 1e-10);
    }
}

/* The centre of the pixel instead of its mean would be wrong by this much. */
static void eye_is_not_sampled(void **state)
{
    const double pitch = GP_EYE_DEGREES_PER_PIXEL;
    const double area = pitch * pitch * RADIAN * RADIAN;
    assert_true(photopic(0.0) * area > 1.9 * gp_eye_share(0, 0));
    assert_true(photopic(pitch) * area < 0.95 * gp_eye_share(1, 0));
}

static void eye_is_symmetric_to_the_bit(void **state)
{
    static const int rows[][2] = {{3, 1}, {17, 16}, {255, 254}, {9, 0}};
    struct gp_planes k;
    for (size_t i = 0; i < COUNT(rows); i++) {
        int x = rows[i][0], y = rows[i][1];
        double share = gp_eye_share(x, y);
        assert_true(share == gp_eye_share(-x, y));
        assert_true(share == gp_eye_share(y, x));
        assert_true(share == gp_eye_share(-y, -x));
    }
    enum { N = 63 }; // too small to fade
    const struct gp_kernel_params p = {.source = "eye", .builtin_size = N};
    bool coloured;
    assert_ok(gp_builtin_make(NULL, &p, &k, &coloured));
    for (int y = 0; y < N; y++) {
        for (int x = 0; x < N; x++) {
            float v = k.c[0][y * N + x];
            assert_true(v == k.c[0][x * N + y]);
            assert_true(v == k.c[0][y * N + (N - 1 - x)]);
            assert_true(v == k.c[1][y * N + x] && v == k.c[2][y * N + x]);
            assert_true(v == (float) gp_eye_share(x - N / 2, y - N / 2));
        }
    }
    gp_planes_free(&k);
}

static void eye_falls_on_every_side(void **state)
{
    struct gp_kernel k = builtin_of("eye", 511);
    for (int y = 0; y <= 255; y++) {
        for (int x = 0; x < 255; x++) {
            const double v = at(&k, 0, x, y), next = at(&k, 0, x + 1, y);
            assert_true(next < v || (next == 0.0 && v < 1e-9));
        }
    }
    gp_kernel_free(&k);
}

/* Light inside the circle of t degrees, closed form of photopic(). */
static double inside_circle(double t)
{
    const double a = 0.02, s = t + a;
    double g0 = 2.61e6 * 0.5 * a * a * (1.0 - exp(-(t / a) * (t / a)));
    double g1 = 20.91 * t * t / (2.0 * a * s * s);
    double g2 = 72.37 * (log(s / a) - t / s);
    return 2.0 * PI * RADIAN * RADIAN * (0.384 * g0 + 0.478 * g1 + 0.138 * g2);
}

/* The share inside a square of n pixels: eight triangles, each a mean of
 * circles, by the midpoint rule in the angle. */
static double inside_square(int n)
{
    const int steps = 20000;
    const double h = 0.5 * n * GP_EYE_DEGREES_PER_PIXEL;
    double sum = 0.0;
    for (int i = 0; i < steps; i++)
        sum += inside_circle(h / cos(PI / 4.0 * (i + 0.5) / steps));
    return sum / steps;
}

static void eye_keeps_all_light_of_its_square(void **state)
{
    static const int sizes[] = {1, 3, 9, 25, 49, 101};
    for (size_t i = 0; i < COUNT(sizes); i++) {
        double sum = 0.0;
        int reach = sizes[i] / 2;
        for (int y = 0; y <= reach; y++) {
            for (int x = y; x <= reach; x++) {
                int images = (x ? 2 : 1) * (y ? 2 : 1) * (x != y ? 2 : 1);
                sum += images * gp_eye_share(x, y);
            }
        }
        assert_close(sum, inside_square(sizes[i]), 2e-9);
    }
    assert_close(inside_square(511), 0.9548, 1e-4); // what the source says
}

/* The paper's functions are normalised over the hemisphere: a slip in a
 * constant would show. f2 is given to two digits of its integral. */
static void eye_is_the_papers(void **state)
{
    double (*const f[3])(double) = {f0, f1, f2};
    static const double tolerance[3] = {0.002, 0.002, 0.02};
    for (int k = 0; k < 3; k++) {
        double sum = 0.0, from = 0.0;
        for (double to = 1e-6; from < 90.0; from = to, to *= 1.0005) {
            to = to < 90.0 ? to : 90.0;
            double t = 0.5 * (from + to);
            sum += f[k](t) * 2.0 * PI * sin(t * RADIAN) * (to - from) * RADIAN;
        }
        assert_close(sum, 1.0, tolerance[k]);
    }
}

SUITE_OF(kernel_builtin, NULL, NULL, are_light,
         are_made_in_the_frames_primaries, white_is_scattered_as_white_in_xyz,
         end_softly, have_their_colours, follow_their_formulas, eye_is_integrated, eye_is_not_sampled,
         eye_is_symmetric_to_the_bit, eye_falls_on_every_side,
         eye_keeps_all_light_of_its_square, eye_is_the_papers)
