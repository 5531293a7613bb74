// SPDX-License-Identifier: Apache-2.0
/* flare: files are read strictly; totals, places and edges hold. */
#include "scene.h"
#include "json_file.h"

static gp_status read_text(const char *text, struct gp_flare *out)
{
    return gp_flare_read(&kept_log, jf_write(text), out);
}

/* Images lie beside the file that names them. */
static void reads_paths(void **state)
{
    struct gp_flare f = {0};
    assert_ok(read_text("{'elements': [{'shape': 'image', 'image': 'a/b.exr'},"
                        "{'shape': 'image', 'image': '/c.exr'}]}", &f));
    assert_memory_equal(f.element[0].path, folder, strlen(folder));
    assert_string_equal(f.element[0].path + strlen(folder), "/a/b.exr");
    assert_string_equal(f.element[1].path, "/c.exr");
    gp_flare_free(&f);
    assert_null(f.element);
}

static void reads_sources(void **state)
{
    struct gp_flare f = {0};
    assert_ok(read_text("{'source': 'bright', 'elements': [{'shape': 'disc'},"
                        "{'shape': 'ring', 'source': 'lights'}]}", &f));
    assert_int_equal(f.element[0].source, GP_FLARE_BRIGHT);
    assert_int_equal(f.element[1].source, GP_FLARE_LIGHTS);
    assert_true(gp_flare_has(&f, GP_FLARE_LIGHTS));
    assert_string_equal(f.path, path);
    gp_flare_free(&f);
    assert_ok(read_text("[{'shape': 'disc', 'source': 'bright'}]", &f));
    assert_true(gp_flare_has(&f, GP_FLARE_BRIGHT));
    assert_false(gp_flare_has(&f, GP_FLARE_LIGHTS));
    gp_flare_free(&f);
}

/* Lights draw their own elements only. */
static void lights_leave_bright_elements(void **state)
{
    struct picture p = picture_of(40, 30);
    struct gp_flare_element e = ELEMENT(.size = 0.5);
    e.source = GP_FLARE_BRIGHT;
    add_one(&p, e, lamp_at(20.0, 15.0));
    assert_true(total(&p, 0) == 0.0);
    picture_free(&p);
}

static void refuses_elements(void **state)
{
    static const char *const rows[] = {
        "{'elements': [], 'source': 'sun'}",
        "{'elements': [], 'sauce': 'lights'}", "disc', 'source': 3",
        "[{}]", "[{'size': 1}]", "[3]", "{'lights': []}", "[{'shape': 'disc'",
        "[{'shape': 'disc'}, {'shape': 'blob'}]",
        // the rest of an element, from its shape
        "disc', 'colour': 1", "disc', 'sides': 5", "disc', 'size': 11",
        "disc', 'size': -1", "disc', 'position': 11", "disc', 'color': [1, 2]",
        "disc', 'color': 1e7", "disc', 'scale': [1, 1, 0]",
        "disc', 'scale': 1", "disc', 'rotation': 'x'", "ring', 'width': 0",
        "ring', 'width': 2", "polygon', 'sides': 2", "polygon', 'sides': 65",
        "polygon', 'sides': 3.5", "image'", "image', 'image': ''",
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_flare f = {.n = -7};
        char text[100];
        snprintf(text, sizeof text, strchr("[{", rows[i][0]) ? "%s"
                 : "[{'shape': '%s}]", rows[i]);
        assert_int_equal(read_text(text, &f), GP_ERR_DATA);
        assert_int_equal(f.n, -7);
        assert_kept(path);
    }
    struct gp_flare f;
    assert_int_equal(gp_flare_read(&kept_log, "/nonexistent/f.json", &f),
                     GP_ERR_IO);
}

static void refuses_too_many(void **state)
{
    char *const text = malloc(1025 * 20 + 3);
    char *p = text;
    struct gp_flare f = {0};
    assert_non_null(text);
    *p++ = '[';
    for (int i = 0; i < 1025; i++)
        p += sprintf(p, "%s{'shape':'disc'}", i ? "," : "");
    strcpy(p, "]");
    assert_int_equal(read_text(text, &f), GP_ERR_DATA);
    free(text);
}

static void centroid(const struct picture *p, int c, double *x, double *y)
{
    const int w = gp_rect_w(p->frame);
    double sum = 0.0;
    *x = *y = 0.0;
    for (size_t i = 0; i < picture_pixels(p); i++) {
        const double v = (double) p->layer.c[c][i];
        *x += v * ((double) (i % (size_t) w) + 0.5 + p->frame.x0);
        *y += v * ((double) (i / (size_t) w) + 0.5 + p->frame.y0);
        sum += v;
    }
    *x /= sum;
    *y /= sum;
}

// -- laws --------------------------------------------------------------------

static void totals_hold(void **state)
{
    static const double places[][2] = {
        {200.0, 150.0}, {200.5, 150.5}, {200.25, 150.625}, {199.9, 150.4},
    };
    for (size_t i = 0; i < COUNT(laws); i++) {
        const struct gp_flare_element e = whole(laws[i]);
        for (size_t k = 0; k < COUNT(places); k++) {
            struct picture p = picture_of(400, 300);
            struct gp_light l = lamp_at(places[k][0], places[k][1]);
            l.visibility = 0.75;
            add_one(&p, e, l);
            for (int c = 0; c < 3; c++) {
                const double want = (double) e.colour[c] *
                                    (double) l.flux[c] * 0.75;
                if (!(fabs(total(&p, c) / want - 1.0) < 1e-3))
                    fail_msg("element %zu place %zu channel %d: %g, not %g",
                             i, k, c, total(&p, c), want);
            }
            picture_free(&p);
        }
    }
}

/* At 0 the light, 1 the centre, 2 mirrored; of a display that is not the
 * frame. */
static void places_lie_on_the_axis(void **state)
{
    for (int k = 0; k <= 4; k++) {
        struct picture p = picture_make((struct gp_rect) {-60, -50, 340, 250},
                                        (struct gp_rect) {-20, -10, 300, 210});
        double x, y;
        add_one(&p, ELEMENT(.size = 0.1, .at = 0.5 * k), lamp_at(60.3, 40.8));
        centroid(&p, 1, &x, &y);
        assert_true(fabs(x - (60.3 + 0.5 * k * (140.0 - 60.3))) < 0.01);
        assert_true(fabs(y - (40.8 + 0.5 * k * (100.0 - 40.8))) < 0.01);
        picture_free(&p);
    }
}

/* Counter-clockwise as seen: a streak at 30 degrees goes up to the right. */
static void rotation_is_counter_clockwise(void **state)
{
    struct picture p = picture_of(200, 200);
    add_one(&p, ELEMENT(.shape = GP_FLARE_STREAK, .size = 0.8,
                        .rotation = 30.0), lamp_at(100.0, 100.0));
    const int x = 100 + (int) (30.0 * cos(0.5235987756));
    const int up = 100 - (int) (30.0 * sin(0.5235987756)) - 1;
    assert_true(p.layer.c[0][up * 200 + x] > 0.0f);
    assert_true(p.layer.c[0][(200 - up) * 200 + x] == 0.0f);
    picture_free(&p);
}

/* Pixels outside of the reach stay 0, and some inside do not. */
static void reach_holds_all(void **state)
{
    for (size_t i = 0; i < COUNT(laws); i++) {
        const struct gp_flare_element e = whole(laws[i]);
        struct picture p = picture_make((struct gp_rect) {-9, 11, 311, 251},
                                        (struct gp_rect) {0, 0, 300, 300});
        const struct gp_light l = lamp_at(281.6, 207.1);
        const struct gp_rect r = gp_flare_reach(&e, &l, p.display);
        add_one(&p, e, l);
        assert_true(total(&p, 0) > 0.0);
        for (int y = p.frame.y0; y < p.frame.y1; y++) {
            for (int x = p.frame.x0; x < p.frame.x1; x++) {
                const bool inside = x >= r.x0 && x < r.x1 && y >= r.y0 &&
                                    y < r.y1;
                const int at = (y - 11) * 320 + x + 9;
                if (!inside)
                    assert_true(p.layer.c[0][at] == 0.0f);
                assert_true(p.layer.c[2][at] >= 0.0f);
            }
        }
        picture_free(&p);
    }
}

static void plain_images_keep_total_and_centroid(void **state)
{
    static const struct {
        int w, h;
        double x, y;
    } rows[] = {
        {64, 64, 100.0, 90.0}, {33, 17, 100.3, 90.7}, {1, 1, 100.49, 90.51},
        {64, 64, 99.125, 88.875}, {2, 3, 100.5, 90.5}, {127, 128, 100.2, 91.0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_flare_element e = ELEMENT(.shape = GP_FLARE_IMAGE,
            .plain = true, .size = 9, .rotation = 33);
        e.image = image_make(rows[i].w, rows[i].h, rows[i].w / 2 + 0.5,
                             rows[i].h / 2 + 0.5, true);
        const struct gp_light l = lamp_at(rows[i].x, rows[i].y);
        struct picture p = picture_of(200, 180);
        struct picture of = {.frame = {0, 0, rows[i].w, rows[i].h},
                             .layer = e.image.rgb};
        double x, y, ix, iy;
        add_one(&p, e, l);
        centroid(&p, 0, &x, &y);
        centroid(&of, 0, &ix, &iy);
        assert_true(fabs(x - rows[i].x - ix + e.image.cx) < 1e-4);
        assert_true(fabs(y - rows[i].y - iy + e.image.cy) < 1e-4);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(total(&p, c) / (total(&of, c) *
                                             (double) l.flux[c]) - 1.0) < 1e-6);
        gp_planes_free(&e.image.rgb);
        picture_free(&p);
    }
}

static void scaled_images_keep_their_totals(void **state)
{
    static const struct {
        int w, h;
        double size, rotation;
        float scale[3];
        bool hot;
    } rows[] = {
        {64, 48, 0.5, 0.0, {1, 1, 1}, false},
        {64, 48, 0.5, 30.0, {1, 0.5f, 1.2f}, false},
        {501, 300, 0.4, 10.0, {1, 1, 1}, false},
        {501, 300, 0.05, 0.0, {1, 2, 3}, true},
        {64, 64, 0.001, 0.0, {1, 1, 1}, true},
        {1, 1, 0.2, 45.0, {1, 1, 1}, false},
        {3, 500, 0.2, 45.0, {1, 1.5f, 1}, false},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_flare_element e = ELEMENT(.shape = GP_FLARE_IMAGE,
            .size = rows[i].size, .rotation = rows[i].rotation);
        memcpy(e.scale, rows[i].scale, sizeof e.scale);
        e.image = image_make(rows[i].w, rows[i].h, rows[i].w / 2.0,
                             rows[i].h / 2.0, rows[i].hot);
        const struct gp_light l = lamp_at(200.3, 150.8);
        struct picture p = picture_of(400, 300);
        const double y = 0.2126 + 2.0 * 0.7152 + 3.0 * 0.0722;
        add_one(&p, e, l);
        for (int c = 0; c < 3; c++) {
            const double want = (c + 1) / y * (double) e.colour[c] *
                                (double) l.flux[c];
            if (!(fabs(total(&p, c) / want - 1.0) < 1e-3))
                fail_msg("image %zu channel %d: %g, not %g", i, c,
                         total(&p, c), want);
        }
        gp_planes_free(&e.image.rgb);
        picture_free(&p);
    }
}

static void unseen_lights_draw_nothing(void **state)
{
    struct gp_light rows[8];
    for (int i = 0; i < 8; i++)
        rows[i] = lamp_at(20.0, 20.0);
    rows[0].visibility = 0.0;
    rows[1].behind = true;
    rows[2].x = (double) NAN;
    rows[3].y = (double) INFINITY;
    rows[4].x = -1e300;
    rows[5].x = 1e6;
    rows[6].visibility = (double) NAN;
    memset(rows[7].flux, 0, sizeof rows[7].flux);
    for (size_t i = 0; i < COUNT(laws); i++) {
        struct picture p = picture_of(40, 30);
        for (int k = 0; k < 8; k++)
            add_one(&p, whole(laws[i]), rows[k]);
        for (int c = 0; c < 3; c++)
            assert_true(total(&p, c) == 0.0);
        picture_free(&p);
    }
}

SUITE_OF(flare, make_folder, remove_folder, reads_paths, reads_sources,
         lights_leave_bright_elements, refuses_elements, refuses_too_many,
         totals_hold, places_lie_on_the_axis,
         rotation_is_counter_clockwise, reach_holds_all,
         plain_images_keep_total_and_centroid, scaled_images_keep_their_totals,
         unseen_lights_draw_nothing)
