/* A lone lamp in the dark, 6 stops brighter: no kernel has a rim or a ball. */
#include "unit.h"
#include "core/minmax.h"
#include "hard_cases.h"
#include "model_scene.h"

/* Light of a lamp of 1e6 that shows at +6 EV: half a code value of 8 bits. */
static const double SEEN = 1.5e-4 / 64.0;

/* A row of `lines` over 9:16 pixels out of a frame fov degrees high, with a
 * lamp of that radius near its left end, and `band` rows around it. */
static struct scene lamp(const char *text, double fov, int lines, int radius,
                         int band)
{
    const int w = lines * 16 / 9, h = 2 * (radius + band) + 1, x0 = w / 96;
    struct gp_frame f = scene_frame(w, h, 0, 0, BLACK, 0);
    struct gp_field field = gp_field_of(&f, fov);
    struct gp_recipe r = scene_recipe(text);
    struct gp_kernel k;
    field.degrees = fov / lines;
    for (int i = 0; i < w * h; i++) {
        const int x = i % w - x0 - radius, y = i / w - h / 2;
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] = x * x + y * y <= radius * radius ? 1e6f : 0.0f;
    }
    assert_ok(gp_model_kernel(NULL, &r, 1, &field, &k));
    gp_recipe_free(&r);
    return scene_make(f, k, &usual);
}

/* The row to the right of the lamp: pixels, from `radius` + 1 away on. */
static int row_of(const struct scene *s, int radius, const double **out)
{
    const int w = gp_frame_w(&s->f), h = gp_frame_h(&s->f);
    const int x = w / 96 + 2 * radius + 1;
    *out = s->exact + (size_t) (w * h) + (size_t) (h / 2 * w + x);
    return w - x;
}

/* The largest step to the next pixel of the model's own light, beside the step
 * before it (a share of it), of `away` pixels and more from the lamp. */
static double bend(const double *v, int n, int away)
{
    double most = 0.0;
    for (int r = gp_max(away, 1); r + 1 < n && v[r] >= SEEN; r++)
        most = fmax(most, fabs(v[r + 1] / v[r] / (v[r] / v[r - 1]) - 1.0));
    return most;
}

static double step(const double *v, int n, int away)
{
    double most = 0.0;
    for (int r = away; r + 1 < n && v[r] >= SEEN; r++)
        most = fmax(most, fabs(v[r + 1] / v[r] - 1.0));
    return most;
}

/* The largest difference between an engine's step and the exact one, a share of
 * the value; less than SEEN does not show. */
static double astray(const struct scene *s, int radius)
{
    const double *v;
    const int n = row_of(s, radius, &v);
    const float *const got = s->f.layer.c[1] + (v - s->exact) -
                             gp_frame_pixels(&s->f);
    double most = 0.0;
    for (int r = 0; r + 1 < n; r++) {
        const double wrong = fabs((double) got[r + 1] - (double) got[r] -
                                  (v[r + 1] - v[r]));
        if (wrong > SEEN)
            most = fmax(most, wrong / v[r + 1]);
    }
    return most;
}

/* No engine adds a step to those of a model, at any number of lines, nor of a
 * lamp of a few hundred pixels. */
static void engines_add_no_steps(void **state)
{
    static const char *const models[] = {
        "eye", "eye-night", "eye-old", "star", "cross", "streak", "ring",
        "circle", "aperture:wavelengths=8", "temporal:wavelengths=8",
        "gaussian", "moffat", "moffat:beta=2.5", "moffat:beta=3",
        "cie:equation=general",
    };
    static const char *const engines[] = {"direct", "auto", "fft"};
    static const int lines[] = {540, 1080, 2160};
    (void) state;
    for (size_t i = 0; i < COUNT(models) * COUNT(lines) * 2; i++) {
        const char *const text = models[i / 6];
        const int tall = lines[i / 2 % 3];
        // with few rows that is enough of a disc
        const int radius = i % 2 == 0 ? 0 : tall == 540 ? 13 : tall / 270;
        struct scene s = lamp(text, 30.0, tall, radius, 4);
        for (size_t k = 0; k < COUNT(engines); k++) {
            struct gp_glare_stats stats;
            assert_true(ran_once(engines[k], &s, &stats, text));
            const double most = astray(&s, radius);
            if (!(most < 0.005))
                fail_msg("%s, %d lines, lamp of %d, %s: a step of %g %%", text,
                         tall, radius, engines[k], 100.0 * most);
        }
        scene_free(&s);
    }
}

/* Models that go on over the whole field: the largest steps of their own light,
 * %, from pixel to pixel, 150 pixels and more from the lamp; and beside the
 * step before, 20 pixels and more from it. Of 540, 1080 and 2160 lines of 30
 * degrees, then of 540 lines of 60, 100 and 170 degrees. A power p of the
 * distance steps by p / 150 there, more than 2 % from p = 3 on. They are of
 * luminance. */
static const struct {
    double fov;
    int lines;
} views[] = {{30, 540}, {30, 1080}, {30, 2160}, {60, 540}, {100, 540},
             {170, 540}};
static const struct {
    const char *text;
    double steps[COUNT(views)], bends[COUNT(views)];
} endless[] = {
    {"eye", {2, 2, 2, 2, 2, 2}, {2, 2, 2, 2, 2, 2}},
    {"eye-old", {2, 2, 2, 2, 2, 2}, {2, 2, 2, 2, 2, 2}},
    // its halo: eq. 8, as pale as fibres of many widths make it
    {"eye-night", {2, 2.6, 2.5, 2, 2, 2}, {2, 2, 2, 4, 2, 2}},
    {"cie:equation=general", {2, 2, 2, 2, 2, 2}, {2, 2, 2, 2, 2, 2}},
    {"moffat", {2.3, 2.3, 2.3, 2.3, 2.3, 2.3}, {2, 2, 2, 2, 2, 2}},
    {"moffat:beta=3", {4, 4, 4, 4, 4, 4}, {2, 2, 2, 2, 2, 2}},
};

static void models_have_no_rim(void **state)
{
    (void) state;
    for (size_t i = 0; i < COUNT(endless) * COUNT(views); i++) {
        const size_t j = i % COUNT(views);
        const char *const text = endless[i / COUNT(views)].text;
        struct scene s = lamp(text, views[j].fov, views[j].lines, 0, 4);
        const size_t plane = gp_frame_pixels(&s.f);
        const double *green;
        const int n = row_of(&s, 0, &green);
        double *const v = malloc((size_t) n * sizeof *v); // luminance
        assert_non_null(v);
        for (int x = 0; x < n; x++)
            v[x] = (double) s.f.luminance[0] * (green - plane)[x] +
                   (double) s.f.luminance[1] * green[x] +
                   (double) s.f.luminance[2] * (green + plane)[x];
        const double one = 100.0 * step(v, n, 150);
        const double more = 100.0 * bend(v, n, 20);
        free(v);
        if (!(one <= endless[i / COUNT(views)].steps[j]) ||
            !(more <= endless[i / COUNT(views)].bends[j]))
            fail_msg("%s, %d lines of %g degrees: steps of %g %%, by %g %% off "
                     "those before", text, views[j].lines, views[j].fov, one,
                     more);
        scene_free(&s);
    }
}

SUITE_OF(rim, NULL, NULL, engines_add_no_steps, models_have_no_rim)
