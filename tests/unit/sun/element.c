// SPDX-License-Identifier: Apache-2.0
/* element: closed forms keep their light at every size, and lights change them
 * as the JSON says. */
#include "scene.h"
#include "json_file.h"

#define DISPLAY(h) ((struct gp_rect) {0, 0, 4 * (h) / 3, h})

/* Shapes and keys beyond those of `laws`; each in a copy of its own. */
static const struct gp_flare_element forms[] = {
    {.shape = GP_FLARE_DISC, .size = 0.4, .softness = 0.5},
    {.shape = GP_FLARE_DISC, .size = 0.5, .dispersion = 0.4},
    {.shape = GP_FLARE_DISC, .size = 0.4, .rim = 3.0, .aspect = 0.5},
    {.shape = GP_FLARE_DISC, .size = 0.5, .profiles = 3,
     .profile = {0, 1, 0.5f}},
    {.shape = GP_FLARE_POLYGON, .size = 0.5, .sides = 5, .round = 0.5,
     .softness = 0.2, .dispersion = -0.3},
    {.shape = GP_FLARE_RING, .size = 0.6, .width = 0.2, .softness = 1.0,
     .dispersion = 0.2},
    {.shape = GP_FLARE_RING, .size = 0.6, .width = 0.1, .completion = 0.3,
     .feather = 0.5, .rotation = 40.0},
    {.shape = GP_FLARE_GLOW, .size = 0.9, .falloff = 8.0},
    {.shape = GP_FLARE_GLOW, .size = 0.9, .falloff = 3.0, .aspect = 1.7,
     .rotation = 30.0},
    {.shape = GP_FLARE_CAUSTIC, .size = 0.5, .softness = 0.1},
    {.shape = GP_FLARE_SPIKES, .size = 0.8, .count = 9, .width = 0.02,
     .random = 0.6, .seed = 3},
    {.shape = GP_FLARE_SPIKES, .size = 0.8, .count = 6, .width = 1e-4,
     .dispersion = 0.3},
    {.shape = GP_FLARE_STREAK, .size = 0.9, .count = 4, .spread = 30.0,
     .random = 0.3, .softness = 1.0, .rotation = 15.0},
};

/* Of all forms, at sizes from a few pixels to a frame. */
static void totals_hold(void **state)
{
    static const int heights[] = {12, 45, 150, 540};
    for (size_t i = 0; i < COUNT(forms); i++) {
        for (size_t k = 0; k < COUNT(heights); k++) {
            const struct gp_rect d = DISPLAY(heights[k]);
            struct picture p = picture_make(
                (struct gp_rect) {-40, -40, d.x1 + 40, d.y1 + 40}, d);
            const struct gp_flare_element e = whole(forms[i]);
            const struct gp_light l = lamp_at(0.5 * d.x1 + 0.3,
                                              0.5 * d.y1 - 0.2);
            add_one(&p, e, l);
            for (int c = 0; c < 3; c++) {
                const double want = (double) e.colour[c] * (double) l.flux[c];
                assert_near(total(&p, c) / want, 1.0, 2e-3, "form and height",
                            (double) i + 1e-4 * heights[k]);
            }
            picture_free(&p);
        }
    }
}

/* Mean of the 4 x 4 pixels of a picture that is four times as high. */
static double mean16(const struct picture *p, int c, int x, int y)
{
    const int w = gp_rect_w(p->frame);
    double sum = 0.0;
    for (int i = 0; i < 16; i++)
        sum += (double) p->layer.c[c][(4 * y + i / 4) * w + 4 * x + i % 4];
    return sum;
}

static void looks_alike_at_every_size(void **state)
{
    for (size_t i = 0; i < COUNT(forms); i++) {
        const struct gp_flare_element e = whole(forms[i]);
        struct picture small = picture_of(360, 270);
        struct picture large = picture_of(1440, 1080);
        double off = 0.0, norm = 0.0;
        if (e.width == 1e-4)
            continue; // under a pixel in both
        add_one(&small, e, lamp_at(180.0, 135.0));
        add_one(&large, e, lamp_at(720.0, 540.0));
        for (int at = 0; at < 3 * 360 * 270; at++) {
            const int c = at / (360 * 270), px = at % (360 * 270);
            const double want = mean16(&large, c, px % 360, px / 360);
            const double got = (double) small.layer.c[c][px];
            off += (got - want) * (got - want);
            norm += want * want;
        }
        // edges, and spikes' tips, are a pixel wide or more in both
        assert_near(sqrt(off / norm), 0.0,
                    e.shape == GP_FLARE_SPIKES ? 0.15 : 0.08, "form",
                    (double) i);
        picture_free(&small);
        picture_free(&large);
    }
}

/* A dispersed edge runs through the spectrum: no channel steps, red is outside.
 */
static void dispersion_is_continuous(void **state)
{
    const struct gp_flare_element e = ELEMENT(.shape = GP_FLARE_DISC,
        .size = 0.6, .dispersion = 0.5);
    struct picture p = picture_of(900, 900);
    double far[3] = {0};
    add_one(&p, e, lamp_at(450.0, 450.0));
    for (int c = 0; c < 3; c++) {
        const float *const row = p.layer.c[c] + 450 * 900;
        for (int x = 451; x < 899; x++) {
            if (fabsf(row[x] - row[x - 1]) > 0.05f * row[450])
                fail_msg("channel %d steps at %d: %g to %g of %g", c, x,
                         (double) row[x - 1], (double) row[x],
                         (double) row[450]);
            if (row[x] > 0.5f * row[450])
                far[c] = x - 450;
        }
    }
    assert_true(far[0] > far[1] + 10.0 && far[1] > far[2] + 5.0);
    picture_free(&p);
}

static double at(const struct picture *p, double x, double y)
{
    return (double) p->layer.c[1][(int) y * gp_rect_w(p->frame) + (int) x];
}

static void shapes_have_their_features(void **state)
{
    const struct gp_light l = lamp_at(150.5, 150.5);
    struct picture p = picture_of(300, 300);
    // half a ring around 90 degrees, up
    add_one(&p, ELEMENT(.shape = GP_FLARE_RING, .size = 0.6, .width = 0.2,
                        .completion = 0.4, .rotation = 90.0), l);
    assert_true(at(&p, 150, 150 - 80) > 0.0 && at(&p, 150, 150 + 80) == 0.0);
    picture_free(&p);
    // a caustic is brightest at its rim, along the rotation
    p = picture_of(300, 300);
    add_one(&p, ELEMENT(.shape = GP_FLARE_CAUSTIC, .size = 0.6), l);
    assert_true(at(&p, 150 + 85, 150) > 3.0 * at(&p, 150 + 30, 150));
    assert_true(at(&p, 150 + 85, 150) > 20.0 * at(&p, 150 - 85, 150));
    picture_free(&p);
    // a round polygon is a disc
    struct picture q = picture_of(300, 300);
    p = picture_of(300, 300);
    add_one(&p, ELEMENT(.shape = GP_FLARE_POLYGON, .size = 0.6, .sides = 4,
                        .round = 1.0), l);
    add_one(&q, ELEMENT(.shape = GP_FLARE_DISC, .size = 0.6), l);
    assert_near(at(&p, 150 + 60, 150 + 60), at(&q, 150 + 60, 150 + 60),
                1e-3 * at(&q, 150, 150), "round", 1.0);
    picture_free(&p);
    picture_free(&q);
    // wider than high by its aspect
    p = picture_of(300, 300);
    add_one(&p, ELEMENT(.shape = GP_FLARE_DISC, .size = 0.3, .aspect = 2.0), l);
    assert_true(at(&p, 150 + 80, 150) > 0.0 && at(&p, 150, 150 + 50) == 0.0);
    picture_free(&p);
}

// -- changes of elements by lights -------------------------------------------

static void transforms_follow_the_light(void **state)
{
    struct picture p = picture_of(400, 300);
    const struct gp_light l = lamp_at(100.5, 50.5); // the line: (100, 100) down
    const struct gp_flare_element ray = ELEMENT(.shape = GP_FLARE_STREAK,
        .size = 0.4, .width = 0.05, .axis = true);
    add_one(&p, ray, l);
    assert_true(at(&p, 100 + 25, 50 + 25) > 0.0);
    assert_true(at(&p, 100 + 25, 50 - 25) == 0.0);
    picture_free(&p);
    // across the line to its left, as seen from the light: up and right
    p = picture_of(400, 300);
    add_one(&p, ELEMENT(.size = 0.05, .at = 0.5, .offset = 0.2), l);
    const double s = 0.2 * 300.0 * sqrt(0.5);
    assert_true(at(&p, 150 + s, 100 - s) > 0.0);
    picture_free(&p);
    // the pupil's rim takes light, more of it farther out, none at the centre
    double left[3];
    for (int i = 0; i < 3; i++) {
        p = picture_of(400, 300);
        add_one(&p, ELEMENT(.size = 0.2, .at = 1.0, .cut = 0.4),
                lamp_at(200.0 - 60.0 * i, 150.0 - 40.0 * i));
        left[i] = total(&p, 0);
        picture_free(&p);
    }
    assert_true(left[0] > 1.1 * left[1] && left[1] > 1.1 * left[2]);
}

static void triggers_act(void **state)
{
    struct gp_flare_element e = ELEMENT(.size = 0.1, .at = 1.0);
    struct gp_flare f = {.element = &e, .n = 1};
    struct gp_light l = lamp_at(200.0, 150.0);
    struct picture p = picture_of(400, 300);
    const double plain = (double) e.colour[0] * (double) l.flux[0];
    // twice as bright in a corner
    e.by_place = (struct gp_flare_by_place) {
        .given = true, .size = {1.0, 2.0},
        .colour = {{1.0, 1.0, 1.0}, {2.0, 2.0, 2.0}},
    };
    add(&p, &f, &l, 1);
    assert_near(total(&p, 0), plain, 1e-3 * plain, "by place", 0.0);
    assert_true(at(&p, 200 + 20, 150) == 0.0);
    l.x = 0.0;
    l.y = 0.0;
    add(&p, &f, &l, 1);
    assert_near(total(&p, 0), 3.0 * plain, 3e-3 * plain, "by place", 1.0);
    assert_true(at(&p, 200 + 20, 150) > 0.0);
    picture_free(&p);
    // smaller, and as bright as the share
    e = ELEMENT(.size = 0.3, .shrink = 1.0);
    l = lamp_at(200.0, 150.0);
    l.visibility = 0.5;
    p = picture_of(400, 300);
    add(&p, &f, &l, 1);
    assert_near(total(&p, 0), 0.5 * plain, 1e-3 * plain, "shrink", 0.5);
    assert_true(at(&p, 200 + 35, 150) == 0.0 && at(&p, 200 + 15, 150) > 0.0);
    picture_free(&p);
    // another brightness in each frame, between a half and all
    double was = 0.0;
    e = ELEMENT(.size = 0.3, .flicker = 0.5, .seed = 9);
    l.visibility = 1.0;
    for (f.frame = 1; f.frame < 9; f.frame++) {
        p = picture_of(400, 300);
        add(&p, &f, &l, 1);
        const double now = total(&p, 0) / plain;
        assert_true(now > 0.499 && now < 1.001 && now != was);
        was = now;
        picture_free(&p);
    }
}

static void names_choose_lights(void **state)
{
    static char pattern[] = "lamp*";
    struct gp_flare_element e = ELEMENT(.size = 0.1);
    struct picture p = picture_of(200, 150);
    struct gp_light l[2] = {lamp_at(50.0, 70.0), lamp_at(150.0, 70.0)};
    strcpy(l[0].name, "lamp 3");
    strcpy(l[1].name, "sun");
    e.only = pattern;
    add(&p, &(struct gp_flare) {.element = &e, .n = 1}, l, 2);
    assert_true(at(&p, 50, 70) > 0.0 && at(&p, 150, 70) == 0.0);
    picture_free(&p);
}

/* Dirt stays in its place in the frame, and shows near a light. */
static void dirt_is_lit(void **state)
{
    struct gp_flare_element e = ELEMENT(.shape = GP_FLARE_DIRT, .size = 1.0);
    struct picture p = picture_of(200, 100);
    e.image = image_make(20, 10, 10.0, 5.0, false);
    for (int i = 0; i < 200; i++) // its right half is clean
        e.image.rgb.c[1][i] = i % 20 < 10 ? 1.0f : 0.0f;
    add_one(&p, e, lamp_at(100.0, 50.0));
    assert_true(at(&p, 80, 50) > at(&p, 60, 50) && at(&p, 60, 50) > 0.0);
    assert_true(at(&p, 120, 50) == 0.0);
    gp_planes_free(&e.image.rgb);
    picture_free(&p);
}

// -- files ---------------------------------------------------------------------

/* Draws an element of JSON, of two lamps, in frame 3. */
static void draw_text(const char *element, struct picture *p)
{
    struct gp_flare f = {0};
    char text[300];
    struct gp_light l[2] = {lamp_at(50.0, 40.0), lamp_at(140.0, 90.0)};
    strcpy(l[0].name, "key");
    strcpy(l[1].name, "fill");
    l[1].visibility = 0.5;
    snprintf(text, sizeof text, "[{%s}]", element);
    if (gp_flare_read(&kept_log, jf_write(text), &f))
        fail_msg("%s: %s", text, kept_line);
    f.frame = 3;
    memset(p->layer.c[0], 0, 3 * picture_pixels(p) * sizeof(float));
    add(p, &f, l, 2);
    gp_flare_free(&f);
}

/* No key is read and ignored: each changes a pixel of an element that has none
 * of it. */
static void every_key_acts(void **state)
{
    static const char *const rows[][2] = {
        {"disc", "'position': 0.5"}, {"disc", "'size': 0.2"},
        {"disc", "'color': 0.5"}, {"disc", "'scale': [1, 1.1, 1]"},
        {"disc", "'profile': [1, 0]"}, {"disc", "'softness': 0.5"},
        {"disc", "'rim': 1"}, {"disc", "'dispersion': 0.5"},
        {"disc", "'aspect': 0.5"}, {"disc", "'count': 3"},
        {"disc", "'count': 2, 'spread': 0.5"}, {"disc", "'offset': 0.2"},
        {"disc", "'cut': 0.5"}, {"disc", "'shrink': 1"},
        {"disc", "'flicker': 0.5"}, {"disc", "'only': 'k*'"},
        {"disc", "'by_place': {'size': [1, 2]}"},
        {"disc", "'by_place': {'brightness': [1, 2]}"},
        {"disc", "'by_place': {'color': [1, [1, 2, 3]]}"},
        {"disc", "'by_place': {'from': 'edge', 'brightness': [1, 2]}"},
        {"polygon", "'rotation': 20"}, {"polygon", "'sides': 5"},
        {"polygon", "'round': 0.5"}, {"polygon", "'turn': 'axis'"},
        {"ring", "'width': 0.3"}, {"ring", "'completion': 0.5"},
        {"ring", "'completion': 0.5, 'feather': 0.5"}, {"glow", "'falloff': 3"},
        {"spikes", "'count': 5"}, {"spikes", "'random': 0.5"},
        {"spikes", "'random': 0.5, 'seed': 7"}, {"spikes", "'width': 0.1"},
        {"streak", "'count': 3, 'spread': 40"}, {"streak", "'count': 3"},
    };
    struct picture one = picture_of(200, 150), two = picture_of(200, 150);
    const size_t bytes = 3 * picture_pixels(&one) * sizeof(float);
    assert_ptr_equal(one.layer.c[2], one.layer.c[0] + 2 * picture_pixels(&one));
    for (size_t i = 0; i < COUNT(rows); i++) {
        char text[200];
        snprintf(text, sizeof text, "'shape': '%s'", rows[i][0]);
        // the last key of a row is tried, beside those before it
        const char *const comma = strrchr(rows[i][1], ',');
        const bool beside = comma && strchr(comma, ':') &&
                            !strchr(rows[i][1], '{');
        if (beside)
            snprintf(text, sizeof text, "'shape': '%s', %.*s", rows[i][0],
                     (int) (comma - rows[i][1]), rows[i][1]);
        draw_text(text, &one);
        snprintf(text, sizeof text, "'shape': '%s', %s", rows[i][0],
                 rows[i][1]);
        draw_text(text, &two);
        if (memcmp(one.layer.c[0], two.layer.c[0], bytes) == 0)
            fail_msg("%s: changes nothing", text);
    }
    picture_free(&one);
    picture_free(&two);
}

/* Copies share the light of their element. */
static void copies_keep_the_light(void **state)
{
    for (int count = 2; count <= 16; count *= 2) {
        struct gp_flare f = {0};
        char text[120];
        double sum = 0.0;
        snprintf(text, sizeof text, "[{'shape': 'disc', 'count': %d, 'spread': "
                 "0.5, 'seed': %d, 'color': 0.5}]", count, count);
        assert_ok(gp_flare_read(&kept_log, jf_write(text), &f));
        assert_int_equal(f.n, count);
        for (int i = 0; i < f.n; i++)
            sum += (double) f.element[i].colour[1];
        assert_near(sum, 0.5, 1e-6, "copies", (double) count);
        gp_flare_free(&f);
    }
}

static void refuses_keys(void **state)
{
    static const char *const rows[] = {
        "disc', 'falloff': 3", "glow', 'sides': 5", "image', 'profile': [1, 1]",
        "disc', 'profile': [1]", "disc', 'profile': [0, 0]",
        "disc', 'profile': 3", "disc', 'softness': 2", "disc', 'cut': -1",
        "disc', 'dispersion': 2", "disc', 'turn': 'left'", "disc', 'only': 3",
        "disc', 'by_place': 3", "disc', 'by_place': {'from': 'left'}",
        "disc', 'by_place': {'color': [1]}", "disc', 'count': 0",
        "disc', 'by_place': {'sise': [1, 2]}", "disc', 'count': 1025",
        "disc', 'source': 'bright', 'cut': 0.1", "ring', 'completion': 0",
        "disc', 'source': 'bright', 'only': 'x'", "dirt', 'source': 'bright'",
        "disc', 'source': 'bright', 'by_place': {'size': [1, 2]}", "dirt'",
        "spikes', 'count': 513", "spikes', 'spread': 5", "disc', 'random': 1",
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_flare f = {.n = -7};
        char text[120];
        snprintf(text, sizeof text, "[{'shape': '%s}]", rows[i]);
        if (gp_flare_read(&kept_log, jf_write(text), &f) != GP_ERR_DATA)
            fail_msg("%s: no error", text);
        assert_int_equal(f.n, -7);
        assert_kept("element 1");
    }
}

SUITE_OF(element, make_folder, remove_folder, totals_hold,
         looks_alike_at_every_size, dispersion_is_continuous,
         shapes_have_their_features, transforms_follow_the_light, triggers_act,
         names_choose_lights, dirt_is_lit, every_key_acts,
         copies_keep_the_light, refuses_keys)
