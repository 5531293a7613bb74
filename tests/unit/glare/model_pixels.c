// SPDX-License-Identifier: Apache-2.0
/* glare/model at any pixel: as wide as the sky, or finer than the shape. */
#include "unit.h"
#include "glare/model/model_priv.h"
#include "model_scene.h"

/* The models in forms that take little time, and the light that each leaves out
 * of a field as large as the sky: the eye's goes on in the plane, as 83 to 90
 * degrees from the light have it. */
static const struct {
    const char *text;
    double out, within; // relative error of a share
} forms[] = {
    {"spencer", 7e-4, 1e-4},
    {"cie", 1.3e-3, 1e-4},
    {"cie:share=1,equation=general", 1.4e-3, 1e-4},
    {"aperture:share=1,wavelengths=3,pupil=0.1,reach=4", 0.031, 3e-3},
    {"temporal:wavelengths=3,pupil=1,reach=1", 0.03, 3e-3},
    {"star:share=1", 0.0, 1e-3},
    {"star:share=1,squeeze=0.1", 0.0, 1e-3},
    {"cross:share=1", 0.0, 1e-3},
    {"streak:share=1", 0.0, 1e-3},
    {"ring:share=1", 0.0, 1e-3},
    {"circle:share=1,soft=0.08", 0.0, 1e-3},
    {"circle:share=1,size=20,soft=0.01", 0.0, 1e-3},
    {"gaussian:share=1", 0.0, 1e-4},
    {"moffat:share=1", 1e-4, 1e-4},
    {"moffat:share=1,fwhm=1e-4", 1e-4, 1e-4},
    {"halation:share=.3", 1e-4, 1e-4},
};

static double luminance(double *const v[3], bool grey)
{
    return 0.2126 * v[0][0] + 0.7152 * v[grey ? 0 : 1][0] +
           0.0722 * v[grey ? 0 : 2][0];
}

/* The share of the light that stays in its pixel. With parts > 1, from pixels
 * that are as much smaller: light from each of them to each. */
static double own_share(const char *text, double degrees, double aspect,
                        int parts)
{
    const struct gp_field f =
        scene_field(2 * parts, 2 * parts, degrees / parts, aspect);
    struct gp_recipe r = scene_recipe(text);
    struct gp_shape s;
    double sum = 0.0, v[3];
    double *const out[3] = {&v[0], &v[1], &v[2]};
    assert_ok(r.model->open(NULL, &r, &f, &s));
    for (int y = 1 - parts; y < parts; y++) {
        for (int x = 1 - parts; x < parts; x++) {
            s.row(s.state, x, y, 1, out);
            sum += luminance(out, s.grey) *
                   (1.0 - fabs((double) x / parts)) *
                   (1.0 - fabs((double) y / parts));
        }
    }
    sum += luminance((double *[3]) {&s.own[0], &s.own[1], &s.own[2]}, s.grey);
    s.free(s.state);
    gp_recipe_free(&r);
    return sum;
}

/* Fields of any size and angle: none is "zero everywhere", none makes light,
 * and those that hold a whole shape have all of it. */
static void light_is_kept_at_any_angle(void **state)
{
    (void) state;
    static const double fovs[] = {0.001, 1.0, 30.0, 170.0};
    static const int sizes[][2] = {{1, 1}, {512, 4}, {1, 300}, {96, 54}};
    for (size_t i = 0; i < COUNT(forms) * COUNT(fovs) * COUNT(sizes); i++) {
        const char *const text = forms[i / 16].text;
        const double fov = fovs[i / 4 % 4];
        const int w = sizes[i % 4][0], h = sizes[i % 4][1];
        const struct gp_field f = scene_field(w, h, fov / h, 1.0);
        struct gp_recipe r = scene_recipe(text);
        struct gp_kernel k;
        if (gp_model_kernel(NULL, &r, 1, &f, &k) != GP_OK)
            fail_msg("%s, %dx%d, fov %g: no kernel", text, w, h, fov);
        // 127 degrees to each side: more than any has
        const bool whole = w > 90 && fov > 100.0;
        if (k.negative || !(k.left_out > -1e-4) || !(k.left_out < 1.0) ||
            (whole && !(k.left_out < forms[i / 16].out + 1e-4)))
            fail_msg("%s, %dx%d, fov %g: %g left out", text, w, h, fov,
                     k.left_out);
        gp_kernel_free(&k);
        gp_recipe_free(&r);
    }
}

/* A pixel's own share is that of its nine parts, grows with the pixel, and goes
 * to all the light: through every way in which pixels are integrated. */
static void pixels_grow_to_a_point(void **state)
{
    (void) state;
    for (size_t i = 0; i < COUNT(forms); i++) {
        double before = 0.0;
        for (double p = 1.0 / 1024.0; p < 180.0; p *= 3.7) {
            for (int wide = 0; wide < 2; wide++) {
                const double aspect = wide ? 2.0 : 1.0;
                const double own = own_share(forms[i].text, p, aspect, 1);
                const double parts = own_share(forms[i].text, p, aspect, 3);
                if (!(fabs(own / parts - 1.0) < forms[i].within))
                    fail_msg("%s, %g degrees, aspect %g: %.9g, in parts %.9g",
                             forms[i].text, p, aspect, own, parts);
                if (!wide && !(own >= before * (1.0 - 1e-6)))
                    fail_msg("%s, %g degrees: %.9g after %.9g", forms[i].text,
                             p, own, before);
                before = wide ? before : own;
            }
        }
        const double all = own_share(forms[i].text, 170.0, 1.0, 1);
        if (!(all > 0.9 - forms[i].out) || all > 1.0 + 1e-6)
            fail_msg("%s: %g of all in a pixel of 170 degrees", forms[i].text,
                     all);
    }
}

SUITE_OF(model_pixels, NULL, NULL, light_is_kept_at_any_angle,
         pixels_grow_to_a_point)

