// SPDX-License-Identifier: Apache-2.0
/* Kernels from images in the primaries of the frames that they are for. */
#include "unit.h"
#include "core/colour.h"
#include "core/memory.h"
#include "glare/kernel.h"
#include "kept_log.h"
#include "model_scene.h"

/* ITU-R BT.2020 and ACES AP1, whose white is another; values of CIE XYZ. */
static const float rec2020[8] = {0.708f, 0.292f, 0.170f, 0.797f,
                                 0.131f, 0.046f, 0.3127f, 0.3290f};
static const float ap1[8] = {0.713f, 0.293f, 0.165f, 0.830f,
                             0.128f, 0.044f, 0.32168f, 0.33767f};
static const float xyz[8] = {1, 0, 0, 1, 0, 0, 1.0f / 3, 1.0f / 3};

static struct gp_field field_in(const float *chromaticities)
{
    struct gp_field f = scene_field(48, 32, 0.05, 1.0);
    memcpy(f.chromaticities, chromaticities, sizeof f.chromaticities);
    gp_luminance_weights(chromaticities, f.luminance);
    return f;
}

/* An image of a kernel's samples, which it borrows, in primaries. */
static struct gp_image image_of(const struct gp_kernel *k,
                                const float *chromaticities)
{
    struct gp_image f = {.path = (char *) "k.exr", .data = {0, 0, k->w, k->h},
                         .rgb = k->k, .names_chromaticities = true};
    memcpy(f.chromaticities, chromaticities, sizeof f.chromaticities);
    gp_luminance_weights(chromaticities, f.luminance);
    return f;
}

static struct gp_kernel kernel_in(const struct gp_image *f,
                                  const float *chromaticities,
                                  enum gp_normalize normalize)
{
    const struct gp_kernel_params p = {
        .chromaticities = chromaticities, .normalize = normalize,
    };
    struct gp_kernel k;
    assert_ok(gp_kernel_from_frame(NULL, &p, f, &k));
    return k;
}

/* Distance of two kernels' samples around their centres, over a's norm. */
static double distance(const struct gp_kernel *a, const struct gp_kernel *b)
{
    double norm = 0.0, error = 0.0;
    for (int c = 0; c < 3; c++) {
        for (int y = -31; y <= 31; y++) {
            for (int x = -47; x <= 47; x++) {
                const double v = sample_at(a, c, x, y);
                norm += v * v;
                error += pow(sample_at(b, c, x, y) - v, 2.0);
            }
        }
    }
    return sqrt(error / norm);
}

/* The image of a model for one frame is the model's kernel in another. From
 * wide primaries to narrow ones both fold the same colours in; from narrow ones
 * the colours that they fold are lost, which is little of these. */
static void images_are_the_models_in_other_primaries(void **state)
{
    static const struct {
        const char *model;
        const float *from, *to;
        double most, least; // distance after and before
    } rows[] = {
        {"aperture:share=1,wavelengths=8", gp_rec709_chromaticities, rec2020,
         1e-6, 0.01},
        {"aperture:share=1,wavelengths=8", rec2020, gp_rec709_chromaticities,
         1e-6, 0.01},
        {"aperture:share=1,wavelengths=8", ap1, rec2020, 1e-6, 1e-3},
        {"aperture:share=1,wavelengths=8", rec2020, xyz, 1e-6, 0.01},
        {"temporal:wavelengths=4", rec2020, ap1, 1e-6, 5e-4},
        {"star:share=1", gp_rec709_chromaticities, rec2020, 5e-4, 0.01},
        {"streak:share=.4", gp_rec709_chromaticities, rec2020, 1e-3, 0.05},
        {"streak:share=.4,dispersion=0", gp_rec709_chromaticities, ap1, 1e-4,
         0.1},
        {"ring:share=.9", gp_rec709_chromaticities, ap1, 1e-3, 0.01},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_field from = field_in(rows[i].from);
        const struct gp_field to = field_in(rows[i].to);
        struct gp_kernel made, wanted;
        model_make(rows[i].model, &from, &made);
        model_make(rows[i].model, &to, &wanted);
        assert_null(made.far); // all samples are in the image
        struct gp_image f = image_of(&made, rows[i].from);
        struct gp_kernel got = kernel_in(&f, rows[i].to, GP_NORMALIZE_NONE);
        got.cx = made.cx, got.cy = made.cy;
        const double after = distance(&wanted, &got);
        const double before = distance(&wanted, &made);
        if (!(after <= rows[i].most) || !(before >= rows[i].least))
            fail_msg("%s: %g, %g before", rows[i].model, after, before);
        gp_kernel_free(&got);
        gp_kernel_free(&wanted);
        gp_kernel_free(&made);
    }
}

enum { W = 3, N = 3 };

/* Three samples in a row that add up to 1 in each channel. */
static struct gp_image row_of(float sample[3][N], const float *chromaticities)
{
    const struct gp_kernel k = {
        .w = W, .h = 1, .k = {{sample[0], sample[1], sample[2]}},
    };
    return image_of(&k, chromaticities);
}

static void primaries_that_are_none_are_refused(void **state)
{
    static const float flat[8] = {0.3f, 0.3f, 0.3f, 0.3f,
                                  0.3f, 0.3f, 0.3f, 0.3f};
    float v[3][N] = {{0.6f, 0.3f, 0.1f}, {0.3f, 0.5f, 0.2f},
                     {0.1f, 0.7f, 0.2f}};
    for (int i = 0; i < 2; i++) {
        struct gp_image f = row_of(v, i ? flat : rec2020);
        const struct gp_kernel_params p = {.chromaticities = i ? rec2020
                                                               : flat};
        struct gp_kernel k = {.w = 77};
        kept_clear();
        assert_int_equal(gp_kernel_from_frame(&kept_log, &p, &f, &k),
                         GP_ERR_DATA);
        assert_kept("k.exr: the kernel's primaries");
        assert_int_equal(k.w, 77);
    }
    v[1][2] = NAN; // the message has its channel, not one it is spread to
    struct gp_image f = row_of(v, gp_rec709_chromaticities);
    const struct gp_kernel_params p = {.chromaticities = rec2020};
    struct gp_kernel k;
    assert_int_equal(gp_kernel_from_frame(&kept_log, &p, &f, &k), GP_ERR_DATA);
    assert_kept("nan in channel G, column 2, row 0");
}

SUITE_OF(kernel_colour, NULL, NULL, images_are_the_models_in_other_primaries,
         primaries_that_are_none_are_refused)

