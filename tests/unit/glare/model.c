// SPDX-License-Identifier: Apache-2.0
/* glare/model: recipes, quadrature, and laws that hold for each model. */
#include "unit.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
#include "glare/kernel_kept.h"
#include "glare/model/model_priv.h"
#include "kept_log.h"
#include "model_scene.h"

static double luminance(const struct gp_kernel *k)
{
    return 0.2126 * k->sum[0] + 0.7152 * k->sum[1] + 0.0722 * k->sum[2];
}

static void recipes_are_read(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        gp_status st;
        const char *again; // as gp_recipe_text() writes it
    } rows[] = {
        {"gaussian", GP_OK, "gaussian"},
        {"gaussian:share=0.25,fwhm=1e-1", GP_OK,
         "gaussian:share=0.25,fwhm=0.1"},
        {"gaussian:fwhm=0.30000000000000004", GP_OK,
         "gaussian:fwhm=0.30000000000000004"},
        {"gausian", GP_ERR_USAGE, NULL},
        {"gaussian:width=2", GP_ERR_USAGE, NULL},
        {"gaussian:share", GP_ERR_USAGE, NULL},
        {"gaussian:share= 1", GP_ERR_USAGE, NULL},
        {"gaussian:share=1x", GP_ERR_USAGE, NULL},
        {"gaussian:share=2", GP_ERR_USAGE, NULL},
        {"gaussian:share=nan", GP_ERR_USAGE, NULL},
        {"gaussian:share=.1,share=.1", GP_ERR_USAGE, NULL},
        {"image:file=a\\,b\\\\.exr,share=0.1", GP_OK,
         "image:share=0.1,file=a\\,b\\\\.exr"},
        {"image:file=,size=1", GP_ERR_USAGE, NULL},
        {"aperture:mask=", GP_ERR_USAGE, NULL},
        {"builtin:nothing", GP_ERR_USAGE, NULL},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_recipe r, again;
        if (gp_recipe_parse(NULL, rows[i].text, &r) != rows[i].st)
            fail_msg("%s", rows[i].text);
        if (rows[i].st)
            continue;
        char *text = gp_recipe_text(&r);
        assert_string_equal(text, rows[i].again);
        assert_ok(gp_recipe_parse(NULL, text, &again));
        assert_memory_equal(r.value, again.value, sizeof r.value);
        if (gp_recipe_file(&r))
            assert_string_equal(gp_recipe_file(&r), "a,b\\.exr");
        gp_free(text);
        gp_recipe_free(&r);
        gp_recipe_free(&again);
    }
    assert_true(gp_recipe_is("builtin:nothing"));
    assert_true(gp_recipe_is("moffat"));
    assert_false(gp_recipe_is("kernel.exr"));
    assert_false(gp_recipe_is("./moffat"));
}

/* A message has the word that was found, the nearest name first and then all,
 * and long texts are cut, not in the middle of a character. */
static void messages_are_short(void **state)
{
    (void) state;
    enum { LONG = 100000 };
    static const struct {
        const char *text, *says;
    } rows[] = {
        {"builtin:staer", "\"staer\"; did you mean star? give one of "},
        {"star:ponits=3", "did you mean points?"},
        {"cie:equation=totla", "did you mean total?"},
        {"cie:zzzzz=1", "\"zzzzz\"; give one of "},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_recipe r;
        kept_clear();
        assert_int_equal(gp_recipe_parse(&kept_log, rows[i].text, &r),
                         GP_ERR_USAGE);
        assert_kept(rows[i].says);
        for (int m = 0; i == 0 && gp_models[m]; m++)
            assert_kept(gp_models[m]->name);
    }
    static const char *const starts[] = {
        "builtin:", "star:share=", "star:share=1,share=", "star:", "star:share",
        "cie:equation=", "image:file=,share=1,size=",
    };
    char *const text = malloc(LONG + 40);
    for (size_t i = 0; i < COUNT(starts); i++) {
        struct gp_recipe r;
        const size_t n = strlen(starts[i]);
        memcpy(text, starts[i], n);
        for (size_t k = 0; k < LONG; k += 2)
            memcpy(text + n + k, "\xc3\xa9", 2); // é
        text[n + LONG] = '\0';
        kept_clear();
        assert_int_equal(gp_recipe_parse(&kept_log, text, &r), GP_ERR_USAGE);
        assert_in_range(strlen(kept_line), 1, 500);
        for (const char *c = kept_line; *c; c += gp_utf8_bytes(c))
            assert_true(gp_utf8_bytes(c) > 0);
    }
    free(text);
}

static double luminance_of(const double v[3], bool grey)
{
    double y = 0.0;
    for (int c = 0; c < 3; c++)
        y += (double) gp_rec709_luminance[c] * v[grey ? 0 : c];
    return y;
}

/* A scene has one glare at all resolutions: a pixel's share is the mean of
 * those of its four quarters, each of light from each of the four quarters of
 * the light's pixel. */
static void resolution_does_not_matter(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        double within;
    } rows[] = {
        {"spencer", 4e-6}, {"spencer:light=scotopic", 4e-6},
        {"cie:age=70", 1e-4}, {"cie:equation=general", 2e-3},
        {"moffat:share=1", 1e-6}, {"gaussian:share=1", 1e-6},
        {"halation:share=1", 1e-4},
        {"gaussian:share=1,fwhm=0.05", 1e-6},
        {"circle:share=1,soft=0.08", 2e-3},
        {"ring:share=1", 3e-4}, {"star:share=1", 2e-3},
        {"streak:share=1", 2e-3},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_field coarse = scene_field(41, 41, 1.0 / 18.0, 1.0);
        const struct gp_field fine = scene_field(84, 84, 1.0 / 36.0, 1.0);
        struct gp_recipe r = scene_recipe(rows[i].text);
        struct gp_shape a, b;
        double worst = 0.0, most = 0.0;
        assert_ok(r.model->open(NULL, &r, &coarse, &a));
        assert_ok(r.model->open(NULL, &r, &fine, &b));
        for (int y = 0; y < 41; y += y < 4 ? 1 : 7) {
            for (int x = 0; x < 41; x += x < 4 ? 1 : 9) {
                double one[3], v[3], sum = 0.0;
                double *const to[3] = {&one[0], &one[1], &one[2]};
                double *const from[3] = {&v[0], &v[1], &v[2]};
                a.row(a.state, x, y, 1, to);
                for (int k = 0; k < 16; k++) {
                    b.row(b.state, 2 * x + k % 2 - k / 2 % 2,
                          2 * y + k / 4 % 2 - k / 8, 1, from);
                    sum += luminance_of(v, b.grey) / 4.0;
                }
                one[0] = luminance_of(one, a.grey);
                // a blur's own share; of rays and edges that of their peak
                const double light = fmax(one[0], 1e-9); // less is not seen
                worst = fmax(worst, fabs(sum - one[0]) /
                                        (rows[i].within > 2e-4 ? 1.0 : light));
                most = fmax(most, one[0]);
            }
        }
        worst /= rows[i].within > 2e-4 ? most : 1.0;
        if (!(worst < rows[i].within))
            fail_msg("%s: %g", rows[i].text, worst);
        a.free(a.state);
        b.free(b.state);
        gp_recipe_free(&r);
    }
}

/* Several recipes: each by its share over what stays; divided by their sum
 * where that is over 1. */
static void recipes_add_up(void **state)
{
    (void) state;
    const struct gp_field f = scene_field(101, 101, 0.1, 1.0);
    struct gp_recipe r[2] = {scene_recipe("gaussian:share=0.8,fwhm=1"),
                             scene_recipe("moffat:share=0.8,fwhm=0.5")};
    struct gp_recipe one[2] = {scene_recipe("gaussian:share=1,fwhm=1"),
                               scene_recipe("moffat:share=1,fwhm=0.5")};
    struct gp_kernel both, a, b;
    assert_ok(gp_model_kernel(NULL, r, 2, &f, &both));
    assert_ok(gp_model_kernel(NULL, &one[0], 1, &f, &a));
    assert_ok(gp_model_kernel(NULL, &one[1], 1, &f, &b));
    assert_int_equal(both.w, b.w);
    for (int y = 0; y < a.h; y++) {
        for (int x = 0; x < a.w; x++) {
            const int dx = x - a.cx, dy = y - a.cy;
            const float v = a.k.c[0][y * a.w + x];
            const float w = b.k.c[0][(dy + b.cy) * b.w + dx + b.cx];
            const float sum = both.k.c[0][(dy + both.cy) * both.w + dx +
                                          both.cx];
            assert_true(fabsf(sum - 0.5f * (v + w)) <= 1e-6f * sum);
        }
    }
    gp_kernel_free(&both);
    gp_kernel_free(&a);
    gp_kernel_free(&b);
    for (int i = 0; i < 2; i++) {
        gp_recipe_free(&r[i]);
        gp_recipe_free(&one[i]);
    }
}

/* An image of 8 x 6 pixels that is 2 degrees high, beside a model: its light by
 * its share, its centroid where its centre's pixel puts it. */
static void images_are_recipes(void **state)
{
    (void) state;
    const struct gp_field f = scene_field(200, 100, 0.05, 1.0);
    struct gp_recipe r[2] = {scene_recipe("image:file=f,share=0.25,size=2"),
                             scene_recipe("gaussian:share=0.5,fwhm=0.2")};
    float v[3][48] = {{0}};
    const struct gp_image image = {
        .data = {5, -3, 13, 3}, .rgb = {{v[0], v[1], v[2]}},
        .luminance = {0.2126f, 0.7152f, 0.0722f},
    };
    struct gp_kernel k;
    for (int i = 0; i < 48; i++)
        v[1][i] = (float) (i * 7 % 11);
    r[0].image = &image;
    assert_ok(gp_model_kernel(NULL, r, 2, &f, &k));
    double x = 0.0, y = 0.0, want_x = 0.0, want_y = 0.0, sum = 0.0;
    for (int i = 0; i < 48; i++) {
        sum += (double) v[1][i];
        want_x += (double) v[1][i] * (i % 8 - 4) * 40.0 / 6.0;
        want_y += (double) v[1][i] * (i / 8 - 3) * 40.0 / 6.0;
    }
    for (int i = 0; i < k.w * k.h; i++) { // red has only the rest
        const double d = (double) k.k.c[1][i] - (double) k.k.c[0][i];
        x += d * 0.7152 / 0.25 * (i % k.w - k.cx);
        y += d * 0.7152 / 0.25 * (i / k.w - k.cy);
    }
    assert_true(fabs(x - want_x / sum) < 1e-3 && fabs(y - want_y / sum) < 1e-3);
    assert_true(fabs(luminance(&k) + k.left_out - 1.0) < 1e-5);
    assert_true(fabs(k.sum[0] - 0.75) < 1e-5);
    gp_kernel_free(&k);
    gp_recipe_free(&r[0]);
    gp_recipe_free(&r[1]);
}

/* The light of channel c that is farther than t degrees. */
static double light_beyond(const struct gp_kernel *k, double degrees, int c,
                           double t)
{
    double sum = 0.0;
    for (int y = 0; y < k->h; y++) {
        for (int x = 0; x < k->w; x++) {
            if (hypot(x - k->cx, y - k->cy) * degrees > t)
                sum += (double) k->k.c[c][y * k->w + x];
        }
    }
    return sum;
}

/* Halation is wider in red than in green than in blue; by the index of the base
 * it has a ring. */
static void halation_is_of_film(void **state)
{
    (void) state;
    const double degrees = 1.0 / 36.0, n = 1.48;
    const double across = 2.0 * 0.13 / 26.0 * 180.0 / M_PI;
    const double ring = across / sqrt(n * n - 1.0);
    const struct gp_field f = scene_field(801, 801, degrees, 1.0);
    struct gp_kernel k, whole;
    double far[3];
    model_make("halation:share=0.2", &f, &k);
    assert_ok(gp_kernel_whole(NULL, &k, f.w, f.h, &whole));
    for (int c = 0; c < 3; c++)
        far[c] = light_beyond(&whole, degrees, c, 2.0 * ring) /
                 light_beyond(&whole, degrees, c, 0.5 * ring);
    assert_true(far[0] > 1.1 * far[1] && far[1] > 1.1 * far[2]);
    const double inside = sample_at(&whole, 0, (int) (0.5 * ring / degrees), 0);
    assert_true(sample_at(&whole, 0, (int) (1.2 * ring / degrees), 0) >
                3.0 * inside);
    gp_kernel_free(&whole);
    gp_kernel_free(&k);
}

/* A frame of a sequence has its own kernel and far part: those of its size, its
 * angle and its time. */
static void frames_have_their_own_kernels(void **state)
{
    (void) state;
    static const struct {
        int w, frame;
        double degrees;
        bool made;
    } rows[] = {
        {330, 1, 1.0 / 36.0, true}, {330, 1, 1.0 / 36.0, false},
        {330, 2, 1.0 / 36.0, true}, {360, 2, 1.0 / 36.0, true},
        {360, 2, 1.0 / 30.0, true},
    };
    struct gp_kernel_request r = {.recipes = 2};
    struct gp_kernels *kernels;
    struct gp_far_state *far = NULL;
    r.recipe[0] = scene_recipe("cie");
    r.recipe[1] = scene_recipe("temporal:reach=1,wavelengths=3");
    assert_ok(gp_kernels_make(NULL, &r, &kernels));
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_field f = scene_field(rows[i].w, 310, rows[i].degrees, 1.0);
        struct gp_made_kernel *m;
        struct gp_far_state *own = NULL;
        struct gp_kernel k;
        bool made;
        f.frame = rows[i].frame;
        assert_ok(gp_kernels_take(NULL, kernels, NULL, &f, &made, &m));
        assert_int_equal(made, rows[i].made);
        assert_ok(gp_model_kernel(NULL, r.recipe, 2, &f, &k));
        assert_true(m->k.w == k.w && m->k.h == k.h);
        assert_memory_equal(m->k.k.c[0], k.k.c[0],
                            (size_t) k.w * (size_t) k.h * sizeof(float));
        assert_ok(gp_far_open(NULL, m->k.far, &far));
        assert_ok(gp_far_open(NULL, k.far, &own));
        assert_memory_equal(gp_far_error_of(far), gp_far_error_of(own),
                            sizeof(struct gp_far_error));
        gp_far_close(&own);
        gp_kernel_free(&k);
        gp_made_kernel_free(&m);
    }
    gp_far_close(&far);
    gp_kernels_free(&kernels);
    gp_kernel_request_free(&r);
}

SUITE_OF(model, NULL, NULL, halation_is_of_film, recipes_are_read,
         messages_are_short, resolution_does_not_matter,
         recipes_add_up, images_are_recipes,
         frames_have_their_own_kernels)

