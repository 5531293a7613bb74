// SPDX-License-Identifier: Apache-2.0
/* Kernels from images: centre, cutting, normalisation, rotation (the identity
 * that engines rely on, right angles), bad images. */
#include "unit.h"
#include "core/colour.h"
#include "glare/glare_priv.h"
#include "glare/kernel.h"
#include "glare_scene.h"

// -- kernels from images ------------------------------------------------------

/* A frame of w x h zeros whose corner is at (x0, y0). */
static struct gp_image blank(int x0, int y0, int w, int h)
{
    struct gp_image f = scene_frame(w, h, x0, y0, BLACK, 1u);
    f.path = strdup("k.exr");
    return f;
}

static void set_sample(struct gp_image *f, int x, int y, float r, float g,
                       float b)
{
    const float v[3] = {r, g, b};
    for (int c = 0; c < 3; c++)
        f->rgb.c[c][y * gp_image_w(f) + x] = v[c];
}

static struct gp_kernel kernel_of(const struct gp_image *f, float degrees,
                                  enum gp_normalize normalize, const double *at)
{
    struct gp_kernel_params p = {0};
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

static void image_keeps_the_ratios_of_its_channels(void **state)
{
    struct gp_image f = blank(0, 0, 3, 3);
    set_sample(&f, 0, 0, 4, 1, -1);
    set_sample(&f, 1, 1, 4, 5, 4);
    set_sample(&f, 2, 2, 0, 2, 1);
    struct gp_kernel k = kernel_of(&f, 0, GP_NORMALIZE_LUMINANCE, NULL);
    assert_false(k.grey);
    assert_close(k.sum[1] / k.sum[0], 1.0, 1e-6);
    assert_close(k.sum[2] / k.sum[0], 0.5, 1e-6);
    assert_close(0.2126 * k.sum[0] + 0.7152 * k.sum[1] + 0.0722 * k.sum[2],
                 1.0, 1e-6);
    double factor = k.sum[0] / 8.0;
    assert_close(k.norm1[2], 6.0 * factor, 1e-6);
    assert_close(k.norm2[1], sqrt(30.0) * factor, 1e-6);
    assert_true(k.k.c[2][0] < 0.0f); // a negative lobe stays
    gp_kernel_free(&k);

    f.luminance[0] = 0.5f; // the image's own primaries
    f.luminance[1] = 0.5f;
    f.luminance[2] = 0.0f;
    k = kernel_of(&f, 0, GP_NORMALIZE_LUMINANCE, NULL);
    assert_close(k.sum[0], 1.0, 1e-6);
    gp_kernel_free(&k);

    k = kernel_of(&f, 0, GP_NORMALIZE_NONE, NULL);
    for (int c = 0; c < 3; c++)
        assert_memory_equal(k.k.c[c], f.rgb.c[c], 9 * sizeof(float));
    assert_true(k.sum[0] == 8.0 && k.sum[1] == 8.0 && k.sum[2] == 4.0);
    gp_kernel_free(&k);
    gp_image_free(&f);
}

static void image_borders_are_cut(void **state)
{
    static const struct {
        int w, h, x, y;          // one pixel of light at x, y
        bool centered;
        double center[2];
        int x0, y0;              // the data window's corner
        int cx, cy;
    } rows[] = {
        {5, 5, 2, 2, false, {0}, 0, 0, 0, 0},
        {4, 6, 0, 0, false, {0}, 0, 0, 2, 3},       // even: floor(size / 2)
        {4, 6, 3, 5, false, {0}, 0, 0, -1, -2},     // centre outside the rest
        {1, 1, 0, 0, false, {0}, 0, 0, 0, 0},
        {5, 5, 1, 1, true, {1.5, 1.5}, 0, 0, 0, 0},
        {5, 5, 1, 1, true, {1.999, 1.0}, 0, 0, 0, 0},
        {5, 5, 1, 1, true, {-0.5, 7.0}, 0, 0, -2, 6},
        {5, 5, 1, 1, true, {11.5, -6.5}, 10, -8, 0, 0},
        {5, 5, 4, 4, false, {0}, 10, -8, -2, -2},   // window moves nothing
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_image f = blank(rows[i].x0, rows[i].y0, rows[i].w, rows[i].h);
        set_sample(&f, rows[i].x, rows[i].y, 0, 0, 3);
        struct gp_kernel k =
            kernel_of(&f, 0, GP_NORMALIZE_LUMINANCE,
                      rows[i].centered ? rows[i].center : NULL);
        assert_int_equal(k.w, 1);
        assert_int_equal(k.h, 1);
        assert_int_equal(k.cx, rows[i].cx);
        assert_int_equal(k.cy, rows[i].cy);
        assert_close((double) k.k.c[2][0], 1.0 / 0.0722, 1e-6);
        assert_true(k.k.c[0][0] == 0.0f && !k.grey);
        gp_kernel_free(&k);
        gp_image_free(&f);
    }
}

static void bad_images_are_refused(void **state)
{
    static const struct {
        float r, g, b;           // at column 2, row 1
        float other;             // at (0, 0)
        enum gp_normalize normalize;
    } rows[] = {
        {NAN, 1, 1, 1, GP_NORMALIZE_LUMINANCE},
        {1, NAN, 1, 1, GP_NORMALIZE_NONE},
        {1, 1, INFINITY, 1, GP_NORMALIZE_NONE},
        {-INFINITY, 1, 1, 1, GP_NORMALIZE_NONE},
        {0, 0, 0, 0, GP_NORMALIZE_LUMINANCE},
        {0, -0.0f, 0, 0, GP_NORMALIZE_NONE},
        {1e-38f, 0, 0, 1e-40f, GP_NORMALIZE_NONE}, // all of it counts as 0
        {-1, -1, -1, 1, GP_NORMALIZE_LUMINANCE},
        {-2, -2, -2, 1, GP_NORMALIZE_LUMINANCE},
    };
    struct gp_kernel_params p = {0};
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_image f = blank(0, 0, 4, 3);
        struct gp_kernel k = {.w = 77};
        const float v = rows[i].other;
        p.normalize = rows[i].normalize;
        set_sample(&f, 0, 0, v, v, v);
        set_sample(&f, 2, 1, rows[i].r, rows[i].g, rows[i].b);
        kept_clear();
        assert_int_equal(gp_kernel_from_frame(&kept_log, &p, &f, &k),
                         GP_ERR_DATA);
        assert_kept("k.exr: ");
        assert_int_equal(k.w, 77);
        gp_image_free(&f);
    }
    struct gp_image none = {.path = NULL};
    struct gp_kernel k;
    assert_int_equal(gp_kernel_from_frame(&kept_log, &p, &none, &k),
                     GP_ERR_DATA);
}

static const float angles[] = {0.5f, 30.0f, 45.0f, 89.999f, 135.0f, 200.0f,
                               -22.5f, 359.0f, -1000.0f};

/* A frame of random samples; lobes below 0 on request. */
static struct gp_image image(int w, int h, bool grey, bool lobes)
{
    struct gp_image f = scene_frame(w, h, 0, 0, DARK, (uint32_t) (w * 131 + h));
    for (int i = 0; i < 3 * w * h; i++) {
        const int c = grey ? 0 : i / (w * h);
        f.rgb.c[i / (w * h)][i % (w * h)] =
            f.rgb.c[c][i % (w * h)] - (lobes && i / (w * h) == c ? 0.2f : 0.0f);
    }
    return f;
}

/* turned(d) = bilinear(flat, R d), as a reader of kernel.c would write it. */
static double identity(const struct gp_kernel *u, double degrees, int dx,
                       int dy, int c)
{
    const double angle = fmod(degrees, 360) * M_PI / 180;
    const double x = u->cx + (gp_cos(angle) * dx - gp_sin(angle) * dy);
    const double y = u->cy + (gp_sin(angle) * dx + gp_cos(angle) * dy);
    const double fx = x - floor(x), fy = y - floor(y);
    const int x0 = (int) floor(x) - u->cx, y0 = (int) floor(y) - u->cy;
    return (1 - fy) * ((1 - fx) * (double) scene_at(u, c, x0, y0) +
                       fx * (double) scene_at(u, c, x0 + 1, y0)) +
           fy * ((1 - fx) * (double) scene_at(u, c, x0, y0 + 1) +
                 fx * (double) scene_at(u, c, x0 + 1, y0 + 1));
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
        struct gp_image f = image(kernels[i].w, kernels[i].h, kernels[i].grey,
                                  kernels[i].lobes);
        const double *const center =
            kernels[i].centered ? kernels[i].center : NULL;
        struct gp_kernel flat = kernel_of(&f, 0.0f, GP_NORMALIZE_NONE, center);
        for (size_t a = 0; a < 2 * COUNT(angles); a++) {
            const float degrees = angles[a / 2];
            struct gp_kernel as_it_is =
                kernel_of(&f, degrees, GP_NORMALIZE_NONE, center);
            struct gp_kernel k = kernel_of(
                &f, degrees, a % 2 ? GP_NORMALIZE_NONE : GP_NORMALIZE_LUMINANCE,
                center);
            double light = 0, most = 0;
            for (int c = 0; c < 3 && a % 2 == 0; c++)
                light += (double) f.luminance[c] * as_it_is.sum[c];
            for (int j = 0; j < 3 * flat.w * flat.h; j++)
                most = fmax(most, fabs((double) flat.k.c[j % 3][j / 3]));
            light = a % 2 ? 1 : light;
            assert_true(k.resampled);
            assert_int_equal(k.grey, kernels[i].grey);
            // every offset where either is not 0, and a rim around them
            for (int dy = -45; dy <= 45; dy++) {
                for (int dx = -45; dx <= 45; dx++) {
                    for (int c = 0; c < 3; c++) {
                        const double want =
                            identity(&flat, (double) degrees, dx, dy, c);
                        const double got = (double) scene_at(&k, c, dx, dy);
                        if (a % 2 ? (float) got != (float) want
                                  : fabs(got * light - want) > 3e-7 * most)
                            fail_msg("kernel %zu, %g degrees, (%d, %d): %g, "
                                     "not %g",
                                     i, (double) degrees, dx, dy, got,
                                     want / light);
                    }
                }
            }
            gp_kernel_free(&as_it_is);
            gp_kernel_free(&k);
        }
        gp_kernel_free(&flat);
        gp_image_free(&f);
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
        struct gp_image f = image(kernels[i].w, kernels[i].h, false, false);
        const double *const center =
            kernels[i].centered ? kernels[i].center : NULL;
        struct gp_kernel flat = kernel_of(&f, 0.0f, GP_NORMALIZE_NONE, center);
        for (size_t t = 0; t < COUNT(turns); t++) {
            struct gp_kernel k = kernel_of(&f, turns[t], GP_NORMALIZE_NONE,
                                           center);
            assert_false(k.resampled);
            assert_int_equal(k.w * k.h, flat.w * flat.h);
            for (int y = 0; y < flat.h; y++) {
                for (int x = 0; x < flat.w; x++) {
                    int dx = x - flat.cx, dy = y - flat.cy;
                    const float want = scene_at(&flat, 1, dx, dy);
                    for (int q = 0; q < quarters[t]; q++) {
                        const int old = dx;
                        dx = dy;
                        dy = -old;
                    }
                    assert_true(scene_at(&k, 1, dx, dy) == want);
                }
            }
            gp_kernel_free(&k);
        }
        gp_kernel_free(&flat);
        gp_image_free(&f);
    }
}

/* A line of 40,000 pixels turned by 45 degrees has a box of 28,000 squared;
 * angles that are none are refused. */
static void what_cannot_be_is_refused(void **state)
{
    struct gp_image line = image(40000, 1, true, false);
    struct gp_kernel_params p = {0};
    struct gp_kernel k = {.w = 77};
    static const float bad[] = {45.0f, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < COUNT(bad); i++) {
        p.rotate = bad[i];
        assert_int_equal(gp_kernel_from_frame(&kept_log, &p, &line, &k),
                         GP_ERR_USAGE);
        assert_kept(i ? "angle" : "too large");
        assert_int_equal(k.w, 77);
    }
    p.rotate = 90.0f;
    assert_ok(gp_kernel_from_frame(&kept_log, &p, &line, &k));
    assert_int_equal(k.h, 40000);
    gp_kernel_free(&k);
    gp_image_free(&line);
}

/* On pixels `aspect` times as wide as high a halo is as wide as it is high on
 * the screen, in its place, and each channel's sum stays. */
static void halos_are_round_on_the_screen(void **state)
{
    static const char *const names[] = {
        "circle:share=1,soft=0.08", "ring:share=0.07", "moffat:beta=4,share=1",
        "gaussian:share=1", NULL,
    };
    static const float aspects[] = {2.0f, 0.5f, 1.3333f, 0.9f, 4.0f};
    for (size_t n = 0; n < COUNT(names); n++) {
        for (size_t i = 0; i < 2 * COUNT(aspects); i++) {
            const double aspect = (double) aspects[i / 2];
            struct gp_kernel_params p = {0};
            struct gp_image f = blank(0, 0, 61, 61);
            struct gp_kernel k, square;
            double across = 0.0, down = 0.0, middle = 0.0;
            for (int j = 0; j < 61 * 61 && !names[n]; j++) { // a disc
                const int x = j % 61 - 30, y = j / 61 - 30;
                const float v = x * x + y * y < 800 ? 1.0f : 0.0f;
                set_sample(&f, j % 61, j / 61, v, 2.0f * v, v);
            }
            p.normalize = GP_NORMALIZE_NONE;
            p.rotate = i % 2 ? 37.0f : 0.0f;
            for (int turn = 0; turn < 2; turn++) {
                f.pixel_aspect = turn ? aspects[i / 2] : 1.0f;
                p.aspect = (double) f.pixel_aspect;
                struct gp_kernel *const out = turn ? &k : &square;
                if (!names[n]) {
                    assert_ok(gp_kernel_from_frame(NULL, &p, &f, out));
                    continue;
                }
                struct gp_field field = gp_field_of(&f, 61.0 / 36.0);
                struct gp_recipe r;
                field.w = field.h = 1100;
                field.rotate = (double) p.rotate;
                assert_ok(gp_recipe_parse(NULL, names[n], &r));
                assert_ok(gp_model_kernel(NULL, &r, 1, &field, out));
                gp_recipe_free(&r);
            }
            for (int c = 0; c < 3; c++)
                assert_close(k.sum[c] / square.sum[c], 1.0, 1e-5);
            for (int j = 0; j < k.w * k.h; j++) {
                const double x = (j % k.w - k.cx) * aspect;
                const double y = j / k.w - k.cy, v = (double) k.k.c[1][j];
                across += v * x * x;
                middle += v * x / aspect;
                down += v * y * y;
            }
            if (fabs(middle) > 0.02 * k.sum[1])
                fail_msg("%s, aspect %g: centre off by %g pixels",
                         names[n] ? names[n] : "file", aspect,
                         middle / k.sum[1]);
            // a pixel has a width too: aspect^2 / 12 of the mean square, and a
            // model's light has it as well
            const double width = names[n] ? 6.0 : 12.0;
            across -= k.sum[1] * aspect * aspect / width;
            down -= k.sum[1] / width;
            if (fabs(across / down - 1.0) > 0.04)
                fail_msg("%s, aspect %g, turned %g: %g across, %g down",
                         names[n] ? names[n] : "file", aspect,
                         (double) p.rotate, sqrt(across / k.sum[1]),
                         sqrt(down / k.sum[1]));
            gp_kernel_free(&k);
            gp_kernel_free(&square);
            gp_image_free(&f);
        }
    }
}

/* Each channel's centroid about the kernel's centre. */
static void find_centroid(const struct gp_kernel *k, int c, double at[2])
{
    at[0] = at[1] = 0.0;
    for (int j = 0; j < k->w * k->h; j++) {
        const double v = (double) k->k.c[c][j] / k->sum[c];
        at[0] += v * (j % k->w - k->cx);
        at[1] += v * (j / k->w - k->cy);
    }
}

/* The kernel of f in another size has the sums of the one in its own, and its
 * centroids at the same places of the screen. */
static void check_size(const struct gp_image *f, double scale, double aspect)
{
    const struct gp_kernel_params p = {
        .normalize = GP_NORMALIZE_NONE, .scale = scale, .aspect = aspect,
    };
    struct gp_kernel flat = kernel_of(f, 0.0f, p.normalize, NULL), k;
    assert_ok(gp_kernel_from_frame(NULL, &p, f, &k));
    for (int c = 0; c < 3; c++) {
        double from[2], to[2];
        find_centroid(&flat, c, from);
        find_centroid(&k, c, to);
        if (!(fabs(k.sum[c] / flat.sum[c] - 1.0) < 1e-5) ||
            !(fabs(to[0] - scale / aspect * from[0]) < 1e-3) ||
            !(fabs(to[1] - scale * from[1]) < 1e-3))
            fail_msg("%dx%d by %g, aspect %g: sum %g of %g, centroid %g,%g of "
                     "%g,%g", gp_image_w(f), gp_image_h(f), scale, aspect,
                     k.sum[c], flat.sum[c], to[0], to[1],
                     scale / aspect * from[0], scale * from[1]);
    }
    gp_kernel_free(&k);
    gp_kernel_free(&flat);
}

/* Kernels of another size keep each channel's sum and centroid, those of even
 * sizes too, and a point stays a point where it is not made larger; for pixels
 * that are not square, and of windows that begin elsewhere. */
static void sizes_keep_light_and_place(void **state)
{
    static const double scales[] = {0.07, 0.37, 0.5, 0.9, 1.0, 1.5, 2.0, 3.3};
    static const double aspects[] = {1.0, 2.0, 0.5};
    static const int sizes[][2] = {{8, 6}, {9, 7}, {64, 33}, {1, 40}};
    for (size_t n = 0; n < COUNT(sizes) * COUNT(scales); n++) {
        const int *const size = sizes[n / COUNT(scales)];
        const double scale = scales[n % COUNT(scales)];
        for (size_t a = 0; a < COUNT(aspects); a++) {
            struct gp_image f = image(size[0], size[1], false, false);
            f.data = (struct gp_rect) {-7, 5, size[0] - 7, size[1] + 5};
            check_size(&f, scale, aspects[a]);
            gp_image_free(&f);
        }
        const struct gp_kernel_params p = {
            .normalize = GP_NORMALIZE_NONE, .scale = scale,
        };
        struct gp_kernel k;
        struct gp_image f = blank(0, 0, size[0], size[1]);
        set_sample(&f, size[0] / 2, size[1] / 2, 1, 1, 1);
        assert_ok(gp_kernel_from_frame(NULL, &p, &f, &k));
        assert_int_equal(k.w % 2, 1);
        assert_true(k.cx == k.w / 2 && k.cy == k.h / 2);
        assert_true(scale > 1.0 || k.w * k.h == 1);
        gp_kernel_free(&k);
        gp_image_free(&f);
    }
}

SUITE_OF(kernel, NULL, NULL, image_keeps_the_ratios_of_its_channels,
         image_borders_are_cut, bad_images_are_refused,
         samples_are_the_unturned_ones, right_angles_move_samples,
         what_cannot_be_is_refused, halos_are_round_on_the_screen,
         sizes_keep_light_and_place)

