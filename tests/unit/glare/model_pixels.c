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
    {"cie", 1.2e-3, 1e-4},
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

/* Every model with its default keys, over a plane to 190 degrees on each side,
 * which is 84.4 in the sky (gp_sky_in_plane()): its rows add up to 1, less what
 * goes on beyond (1.4e-3 of the eye's). They are summed here, as
 * gp_kernel.left_out is 1 less the kernel's own sum. */
static void every_model_is_one(void **state)
{
    (void) state;
    enum { N = 64 };
    const struct gp_field f = scene_field(N, N, 3.0, 1.0);
    float v[9] = {0.0f, 1.0f, 0.0f, 2.0f, 5.0f, 1.0f, 0.0f, 3.0f, 0.0f};
    const struct gp_frame image = {
        .data = {0, 0, 3, 3}, .rgb = {{v, v, v}},
        .luminance = {0.2126f, 0.7152f, 0.0722f},
    };
    for (int i = 0; gp_models[i]; i++) {
        const char *const name = gp_model_name(gp_models[i]);
        const bool is_image = gp_models[i] == &gp_model_image;
        struct gp_recipe r = scene_recipe(is_image ? "image:file=f" : name);
        struct gp_shape s;
        double sum[3] = {0};
        r.image = is_image ? &image : NULL;
        assert_ok(r.model->open(NULL, &r, &f, &s));
        for (int y = 1 - N; y < N; y++) {
            double row[3][2 * N - 1] = {{0}};
            double *const out[3] = {row[0], row[1], row[2]};
            s.row(s.state, 1 - N, y, 2 * N - 1, out);
            for (int c = 0; c < 3; c++) {
                for (int x = 0; x < 2 * N - 1; x++)
                    sum[c] += row[s.grey ? 0 : c][x];
            }
        }
        double *const at[3] = {&sum[0], &sum[1], &sum[2]};
        const double all = luminance(at, false);
        if (!(all > 1.0 - 3e-3) || all > 1.0 + 1e-6)
            fail_msg("%s: %.9g", name, all);
        for (int c = 0; c < 3; c++) {
            // models are white to 1 %; streak and film have a colour by keys
            if (r.model != &gp_model_streak && r.model != &gp_model_halation &&
                !(fabs(sum[c] - all) < 0.01))
                fail_msg("%s: %.9g in channel %d, %.9g in all", name, sum[c],
                         c, all);
        }
        s.free(s.state);
        gp_recipe_free(&r);
    }
}

/* The luminance of a pixel of a shape. */
static double light_at(const struct gp_shape *s, int x, int y)
{
    double v[3];
    double *const out[3] = {&v[0], &v[1], &v[2]};
    s->row(s->state, x, y, 1, out);
    return luminance(out, s->grey);
}

/* A lamp of one pixel lights each pixel as the same lamp in parts x parts
 * smaller pixels lights theirs: needles too, in all pixels and in those farther
 * than 3 from it. */
static void needles_are_integrated_over_pixels(void **state)
{
    enum { FAR = 12 };
    static const struct {
        double degrees, aspect;
        int parts;
    } rows[] = {{1.0 / 18.0, 1.0, 2}, {1.0 / 18.0, 1.0, 4}, {0.2, 1.0, 2},
                {1.0 / 18.0, 2.0, 2}, {1.0 / 18.0, 0.5, 2}};
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        const int parts = rows[i].parts;
        const struct gp_field wide =
            scene_field(64, 64, rows[i].degrees, rows[i].aspect);
        const struct gp_field fine = scene_field(64 * parts, 64 * parts,
            rows[i].degrees / parts, rows[i].aspect);
        struct gp_recipe r = scene_recipe("builtin:eye-night");
        struct gp_shape s, p;
        double off[2] = {0}, norm[2] = {0};
        assert_ok(r.model->open(NULL, &r, &wide, &s));
        assert_ok(r.model->open(NULL, &r, &fine, &p));
        for (int at = 0; at < (2 * FAR + 1) * (2 * FAR + 1); at++) {
            const int x = at % (2 * FAR + 1) - FAR;
            const int y = at / (2 * FAR + 1) - FAR;
            const double want = light_at(&s, x, y);
            double sum = 0.0;
            for (int v = 1 - parts; v < parts; v++) {
                for (int u = 1 - parts; u < parts; u++)
                    sum += light_at(&p, x * parts + u, y * parts + v) *
                           (1.0 - fabs((double) u / parts)) *
                           (1.0 - fabs((double) v / parts));
            }
            for (int k = 0; k <= (hypot(x, y) > 3.0); k++) {
                off[k] += (sum - want) * (sum - want);
                norm[k] += want * want;
            }
        }
        for (int k = 0; k < 2; k++) {
            if (!(sqrt(off[k] / norm[k]) < 1e-3))
                fail_msg("%g degrees, aspect %g, %d parts, %s: %.3g apart",
                         rows[i].degrees, rows[i].aspect, parts,
                         k ? "far" : "all", sqrt(off[k] / norm[k]));
        }
        s.free(s.state);
        p.free(p.state);
        gp_recipe_free(&r);
    }
}

SUITE_OF(model_pixels, NULL, NULL,
    every_model_is_one,
    light_is_kept_at_any_angle,
    pixels_grow_to_a_point,
    needles_are_integrated_over_pixels)
