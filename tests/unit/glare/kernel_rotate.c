/* glare/kernel_rotate.c and rotated kernels: the identity that engines rely on, right
 * angles, normalisation, engines that agree. */
#include "unit.h"
#include "glare_scene.h"
#include "said.h"

#include "glare/glare_priv.h"

static const float angles[] = {0.5f, 30.0f, 45.0f, 89.999f, 135.0f, 200.0f,
                               -22.5f, 359.0f, -1000.0f};

/* A frame of random samples with a few zeros; lobes below 0 on request. */
static struct gp_frame image(int w, int h, bool grey, bool lobes)
{
    struct gp_frame f = {.data = {0, 0, w, h}};
    uint32_t seed = (uint32_t) (w * 131 + h);
    memcpy(f.luminance, gp_rec709_luminance, sizeof f.luminance);
    assert_ok(gp_planes_make(NULL, "image", (size_t) (w * h), &f.rgb));
    for (int i = 0; i < w * h; i++) {
        for (int c = 0; c < 3; c++) {
            const float v = scene_random(&seed) - (lobes ? 0.2f : 0.0f);
            f.rgb.c[c][i] = c && grey ? f.rgb.c[0][i] : v;
        }
    }
    return f;
}

static struct gp_kernel turned(const struct gp_frame *f, float degrees,
                               enum gp_normalize normalize, const double *at)
{
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_kernel k;
    p.rotate = degrees;
    p.normalize = normalize;
    p.centered = at != NULL;
    for (int i = 0; i < 2 && at; i++)
        p.center[i] = at[i];
    if (gp_kernel_from_frame(NULL, &p, f, &k) != GP_OK)
        fail_msg("%g degrees", (double) degrees);
    return k;
}

/* Sample at an offset from the centre, 0 outside. */
static float at(const struct gp_kernel *k, int c, int dx, int dy)
{
    const int x = k->cx + dx, y = k->cy + dy;
    return x >= 0 && x < k->w && y >= 0 && y < k->h
               ? k->k.c[c][(size_t) y * (size_t) k->w + (size_t) x] : 0.0f;
}

static double unturned_at(const struct gp_unturned *u, int c, int x, int y)
{
    return x >= 0 && x < u->w && y >= 0 && y < u->h
               ? (double) u->k.c[c][y * u->w + x] : 0.0;
}

/* turned(d) = bilinear(unturned, R d), as a reader of kernel.h would write
 * it. */
static double identity(const struct gp_unturned *u, int c, int dx, int dy)
{
    const double x = u->cx + (u->cos * dx - u->sin * dy);
    const double y = u->cy + (u->sin * dx + u->cos * dy);
    const int x0 = (int) floor(x), y0 = (int) floor(y);
    const double fx = x - x0, fy = y - y0;
    return (1 - fy) * ((1 - fx) * unturned_at(u, c, x0, y0) +
                       fx * unturned_at(u, c, x0 + 1, y0)) +
           fy * ((1 - fx) * unturned_at(u, c, x0, y0 + 1) +
                 fx * unturned_at(u, c, x0 + 1, y0 + 1));
}

static const struct {
    int w, h;
    bool centered;
    double center[2];
    bool grey, lobes;
} kernels[] = {
    {1, 1, false, {0}, true, false}, {2, 1, false, {0}, false, false},
    {7, 5, false, {0}, false, false}, {8, 12, false, {0}, true, false},
    {9, 9, true, {0.5, 8.5}, false, true},
    {6, 5, true, {-20.0, 3.0}, false, false}, // centre outside
    {33, 1, false, {0}, false, false},
};

static void samples_are_the_unturned_ones(void **state)
{
    for (size_t i = 0; i < COUNT(kernels); i++) {
        struct gp_frame f = image(kernels[i].w, kernels[i].h, kernels[i].grey,
                                  kernels[i].lobes);
        for (size_t a = 0; a < 2 * COUNT(angles); a++) {
            struct gp_kernel k =
                turned(&f, angles[a / 2], a % 2 ? GP_NORMALIZE_NONE
                                                : GP_NORMALIZE_LUMINANCE,
                       kernels[i].centered ? kernels[i].center : NULL);
            assert_non_null(k.unturned);
            assert_int_equal(k.grey, kernels[i].grey);
            // every offset where either is not 0, and a rim around them
            for (int dy = -45; dy <= 45; dy++) {
                for (int dx = -45; dx <= 45; dx++) {
                    for (int c = 0; c < 3; c++) {
                        const double want = identity(k.unturned, c, dx, dy);
                        if (at(&k, c, dx, dy) != (float) want ||
                            gp_rotate_reference(k.unturned, c, dx, dy) != want)
                            fail_msg("kernel %zu, %g degrees, (%d, %d): %g, "
                                     "not %g", i, (double) angles[a / 2], dx,
                                     dy, (double) at(&k, c, dx, dy), want);
                    }
                }
            }
            gp_kernel_free(&k);
            assert_null(k.unturned);
        }
        gp_frame_free(&f);
    }
}

/* (dx, dy) of the kernel before goes to (dy, -dx) by a quarter turn
 * counter-clockwise, y being down: what was to the right is above. */
static void right_angles_move_samples(void **state)
{
    static const float turns[] = {90.0f, 180.0f, 270.0f, -90.0f, 450.0f,
                                  -720.0f, 0.0f, 360.0f, -0.0f};
    static const int quarters[] = {1, 2, 3, 3, 1, 0, 0, 0, 0};
    for (size_t i = 0; i < COUNT(kernels); i++) {
        struct gp_frame f = image(kernels[i].w, kernels[i].h, false, false);
        const double *const center =
            kernels[i].centered ? kernels[i].center : NULL;
        struct gp_kernel flat = turned(&f, 0.0f, GP_NORMALIZE_NONE, center);
        for (size_t t = 0; t < COUNT(turns); t++) {
            struct gp_kernel k = turned(&f, turns[t], GP_NORMALIZE_NONE,
                                        center);
            assert_null(k.unturned);
            assert_int_equal(k.w * k.h, flat.w * flat.h);
            for (int y = 0; y < flat.h; y++) {
                for (int x = 0; x < flat.w; x++) {
                    int dx = x - flat.cx, dy = y - flat.cy;
                    const float want = at(&flat, 1, dx, dy);
                    for (int q = 0; q < quarters[t]; q++) {
                        const int old = dx;
                        dx = dy;
                        dy = -old;
                    }
                    assert_true(at(&k, 1, dx, dy) == want);
                }
            }
            gp_kernel_free(&k);
        }
        gp_kernel_free(&flat);
        gp_frame_free(&f);
    }
}

static void turned_kernels_are_normalised(void **state)
{
    struct gp_frame f = image(9, 8, false, false);
    for (size_t a = 0; a < COUNT(angles); a++) {
        struct gp_kernel k = turned(&f, angles[a], GP_NORMALIZE_LUMINANCE,
                                    NULL);
        double sum[3] = {0}, luminance = 0.0;
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < k.w * k.h; i++)
                sum[c] += (double) k.k.c[c][i];
            luminance += (double) gp_rec709_luminance[c] * sum[c];
            assert_true(fabs(sum[c] - k.sum[c]) < 1e-6);
        }
        assert_true(fabs(luminance - 1.0) < 1e-6);
        gp_kernel_free(&k);
    }
    gp_frame_free(&f);
}

/* A line of 40,000 pixels turned by 45 degrees has a box of 28,000 squared;
 * angles that are none are refused. */
static void what_cannot_be_is_refused(void **state)
{
    struct gp_frame line = image(40000, 1, true, false);
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_kernel k = {.w = 77};
    static const float bad[] = {45.0f, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < COUNT(bad); i++) {
        p.rotate = bad[i];
        assert_int_equal(gp_kernel_from_frame(&said_log, &p, &line, &k),
                         GP_ERR_USAGE);
        assert_non_null(strstr(said_line, i ? "angle" : "too large"));
        assert_int_equal(k.w, 77);
    }
    p.rotate = 90.0f;
    assert_ok(gp_kernel_from_frame(&said_log, &p, &line, &k));
    assert_int_equal(k.h, 40000);
    gp_kernel_free(&k);
    gp_frame_free(&line);
}

/* The exact engines see the turned kernel. */
static void engines_agree(void **state)
{
    static const char *const engines[] = {"direct", "fft"};
    const struct gp_sensor_params sensors = GP_SENSOR_DEFAULTS;
    struct gp_frame f = image(21, 30, false, false);
    struct scene s = scene_make(scene_frame(90, 70, -3, 5, FEW, 7),
                                turned(&f, 30.0f, GP_NORMALIZE_LUMINANCE, NULL),
                                &sensors);
    for (size_t i = 0; i < COUNT(engines); i++) {
        struct gp_glare g = {0};
        struct gp_glare_stats stats;
        struct gp_glare_error e;
        assert_ok(scene_run(engines[i], &s, &g, &stats));
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
        if (!(e.rel_l2 < 1e-6))
            fail_msg("%s: rel_l2 %g", engines[i], e.rel_l2);
        gp_glare_close(&g);
    }
    scene_free(&s);
    gp_frame_free(&f);
}

SUITE_OF(kernel_rotate, NULL, NULL,
    samples_are_the_unturned_ones, right_angles_move_samples,
    turned_kernels_are_normalised, what_cannot_be_is_refused, engines_agree)
