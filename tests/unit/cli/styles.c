// SPDX-License-Identifier: Apache-2.0
/* cli/styles: rows that the option table takes, what a style sets and what a
 * user's options keep, and how much glare it is by the standard. */
#include "unit.h"
#include "cli/option_line.h"

#include "cli/options.h"

#include <math.h>

static void rows_are_options(void **state)
{
    int rows = 0;
    for (const struct gp_style *t = gp_styles; t->name; t++, rows++) {
        int words = 0;
        assert_true(strlen(t->text) > 10);
        assert_int_equal(strspn(t->name, "abcdefghijklmnopqrstuvwxyz-"),
                         strlen(t->name)); // what the sheet can write
        for (; t->word[words]; words += 2) {
            const struct gp_option *const o =
                gp_option_find(t->word[words], strlen(t->word[words]));
            assert_non_null(o);
            assert_true(o->commands & GP_COMMAND_MAIN);
            assert_non_null(t->word[words + 1]);
        }
        assert_true(words < GP_STYLE_WORDS);
    }
    assert_true(rows >= 8);
    assert_string_equal(gp_style_of(GP_STYLE_USUAL)->name, "camera");
}

static void styles_set_what_is_not_given(void **state)
{
    struct gp_settings s;
    assert_ok(parse("--style eye -o a.png in.exr", &s));
    assert_int_equal(s.kernel.words.n, 1);
    assert_string_equal(s.kernel.words.at[0], "builtin:eye");
    assert_false(gp_option_given(&s, "kernel"));
    assert_int_equal(s.words.options.n,
                     4); // the style's words are not written out
    gp_settings_free(&s);
    // in any order
    assert_ok(parse("-t 3 --style mist -k star -o a.png in.exr", &s));
    assert_true(s.light.sense.threshold == 3.0f);
    assert_int_equal(s.kernel.words.n, 1);
    assert_string_equal(s.kernel.words.at[0], "star");
    gp_settings_free(&s);
    assert_ok(parse("--style vintage --lens heliar -o a.png in.exr", &s));
    assert_string_equal(s.lens.lens, "heliar");
    gp_settings_free(&s);
    assert_ok(parse("bench --style anamorphic in.exr", &s));
    assert_string_equal(s.sun.p.flare, "preset:oval");
    gp_settings_free(&s);
    assert_int_equal(parse("--style starr -o a.png in.exr", &s), GP_ERR_USAGE);
    assert_kept("did you mean star?");
    gp_settings_free(&s);
}

/* The light of a style's kernels that lies farther than t degrees from its
 * source: what reaches the middle of a black disc of that radius in a bright
 * field, the veiling glare index of ISO 9358. */
static double glare_index(const char *name, double t)
{
    enum { REACH = 20, SIDE = 2 * REACH + 1 };
    const double degrees = 30.0 / 540.0;
    const struct glarepp_field field = {
        .w = 128, .h = 128, .fov = 128 * degrees, .radius = REACH,
        .most = 1 << 20,
    };
    const double weight[] = {0.2126, 0.7152, 0.0722};
    struct glarepp_kernel_params p;
    struct glarepp_kernel *k;
    struct glarepp_image image;
    struct glarepp_label label;
    struct glarepp *gp;
    struct gp_settings s;
    char line[64];
    double within = 0.0;
    snprintf(line, sizeof line, "--style %s -o a.png in.exr", name);
    assert_ok(parse(line, &s));
    p = s.kernel.p;
    assert_ok(glarepp_open(NULL, &gp));
    assert_ok(glarepp_kernel(gp, &p, &k));
    assert_ok(glarepp_kernel_draw(k, &field, &image, &label));
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int x = i % SIDE - REACH, y = i / SIDE - REACH;
        for (int c = 0; c < 3 && hypot(x, y) * degrees <= t; c++)
            within += weight[c] * (double) ((const float *) image.plane[c])[i];
    }
    glarepp_image_end(&image);
    glarepp_kernel_end(&k);
    glarepp_close(&gp);
    gp_settings_free(&s);
    return 1.0 - within;
}

static void indices_are_as_stated(void **state)
{
    assert_true(fabs(glare_index("camera", 0.5) - 0.0075) < 0.0003);
    assert_true(fabs(glare_index("vintage", 0.5) - 0.033) < 0.002);
    assert_true(fabs(glare_index("mist", 0.5) - 0.1) < 0.005);
}

SUITE_OF(styles, NULL, NULL, rows_are_options, styles_set_what_is_not_given,
         indices_are_as_stated)
