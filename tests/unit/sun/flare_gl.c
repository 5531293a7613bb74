/* flare on GL: equals the plain form, in tiles too; hidden lights stay shut.
 * `--time` prints what a typical flare costs in both. */
#include "core/clock.h"
#include "flare_scene.h"

static struct gp_gl *open_or_skip(void)
{
    struct gp_gl *gl = NULL;
    if (gp_gl_open(&said_log, GP_GL_AUTO, &gl) != GP_OK) {
        print_message("no context: %s\n", said_line);
        skip();
    }
    return gl;
}

static void draw(struct gp_gl *gl, struct picture *p, const struct gp_flare *f,
    const struct gp_light *light, int n, struct gp_flare_gl **state)
{
    struct gp_texture t = {0};
    float *const rgba = calloc((size_t) n, 4 * sizeof(float));
    assert_non_null(rgba);
    for (int i = 0; i < n; i++) {
        rgba[4 * i] = (float) light[i].visibility * 0.5f;
        rgba[4 * i + 1] = 0.5f;
    }
    assert_int_equal(gp_texture_make(&said_log, gl, "test", GP_TEXEL_FLOAT, n,
                     1, &t), GP_OK);
    gp_texture_write(gl, &t, (struct gp_rect) {0, 0, n, 1}, rgba);
    assert_int_equal(gp_flare_draw(&said_log, gl, f, light, n, &t, p->frame,
                                   p->display, state), GP_OK);
    assert_int_equal(gp_flare_read_layer(&said_log, gl, *state, p->frame,
                                         &p->layer), GP_OK);
    gp_texture_free(gl, &t);
    free(rgba);
}

static void assert_same(const struct picture *a, const struct picture *b,
                        double bar, const char *what, size_t row)
{
    for (int c = 0; c < 3; c++) {
        double peak = 0.0, off = 0.0;
        for (size_t i = 0; i < picture_pixels(a); i++) {
            const double u = (double) a->layer.c[c][i];
            const double v = (double) b->layer.c[c][i];
            peak = fmax(peak, fabs(u));
            off = fmax(off, fabs(u - v));
        }
        if (!(off <= bar * peak))
            fail_msg("%s %zu channel %d: off by %g of %g", what, row, c, off,
                     peak);
    }
}

static void check_pair(struct gp_gl *gl, const struct gp_flare *f,
    const struct gp_light *light, int n, struct gp_rect frame,
    struct gp_rect display, struct gp_flare_gl **state, size_t row)
{
    struct picture a = picture_make(frame, display);
    struct picture b = picture_make(frame, display);
    add(&a, f, light, n);
    draw(gl, &b, f, light, n, state);
    assert_same(&a, &b, 1e-5, "pair", row);
    picture_free(&a);
    picture_free(&b);
}

/* Each element alone, then all with many lights, one of them hidden, in frames
 * that change size. */
static void forms_agree(void **state)
{
    static const struct gp_rect frames[] = {
        {0, 0, 320, 240}, {-40, -30, 501, 77}, {11, 5, 30, 300}, {0, 0, 1, 1},
        {0, 0, 640, 480},
    };
    struct gp_gl *gl = open_or_skip();
    struct gp_flare_gl *kept = NULL;
    struct gp_flare_element e[COUNT(laws) + 4];
    const struct gp_flare all = all_shapes(e);
    struct gp_light light[9];
    for (int i = 0; i < 9; i++) {
        light[i] = light_at(37.3 * i - 20.0, 31.7 * i + 0.3);
        light[i].visibility = i == 4 ? 0.0 : 0.11 * i;
    }
    light[7].behind = true;
    const size_t step = getenv("GLAREPP_TEST_QUICK") ? 6 : 1;
    for (size_t i = 0; i < (size_t) all.n; i += step) {
        const struct gp_flare f = {&e[i], 1};
        check_pair(gl, &f, light + 3, 1, frames[0], frames[0], &kept, i);
    }
    for (size_t k = 0; k < COUNT(frames); k += step)
        check_pair(gl, &all, light, 9, frames[k], frames[0], &kept, 100 + k);
    gp_flare_close(gl, &kept);
    assert_null(kept);
    free_images(e, all.n);
    gp_gl_close(&gl);
}

/* Frames beyond a texture's size come in tiles. */
static void tiles_agree(void **state)
{
    setenv("GLAREPP_GL_MAX_SIZE", "128", 1);
    struct gp_gl *gl = open_or_skip();
    struct gp_flare_gl *kept = NULL;
    struct gp_flare_element e[COUNT(laws) + 4];
    const struct gp_flare all = all_shapes(e);
    const struct gp_light l[2] = {light_at(60.3, 41.7), light_at(-20, 180)};
    const struct gp_rect frame = {-3, 2, 450, 321};
    assert_int_equal(gp_gl_info(gl)->max_size, 128);
    check_pair(gl, &all, l, 2, frame, frame, &kept, 0);
    gp_flare_close(gl, &kept);
    free_images(e, all.n);
    gp_gl_close(&gl);
    unsetenv("GLAREPP_GL_MAX_SIZE");
}

static void hidden_lights_stay_shut(void **state)
{
    struct gp_gl *gl = open_or_skip();
    struct gp_flare_gl *kept = NULL;
    struct gp_flare_element e[COUNT(laws) + 4];
    const struct gp_flare all = all_shapes(e);
    struct gp_light l = light_at(60.3, 41.7);
    struct picture p = picture_make((struct gp_rect) {0, 0, 200, 150},
                                    (struct gp_rect) {0, 0, 200, 150});
    l.visibility = 0.0;
    draw(gl, &p, &all, &l, 1, &kept);
    l.visibility = 1.0;
    l.behind = true;
    draw(gl, &p, &all, &l, 1, &kept);
    const struct gp_flare none = {0};
    draw(gl, &p, &none, &l, 1, &kept);
    for (int c = 0; c < 3; c++)
        assert_true(total(&p, c) == 0.0);
    gp_flare_close(gl, &kept);
    gp_flare_close(gl, &kept);
    picture_free(&p);
    free_images(e, all.n);
    gp_gl_close(&gl);
}

/* All shapes for 1 and 64 lights, and a sprite, on the CPU and on GL. */
static void time_all(void)
{
    const struct gp_rect frame = {0, 0, 1920, 1080};
    struct gp_gl *gl = NULL;
    struct gp_flare_element e[COUNT(laws) + 4];
    struct gp_flare_element sprite = ELEMENT(.shape = GP_FLARE_IMAGE,
                                             .plain = true);
    struct gp_light light[64];
    if (gp_gl_open(&said_log, GP_GL_AUTO, &gl) != GP_OK)
        return;
    sprite.image = image_make(512, 512, 256.5, 256.5, false);
    for (int i = 0; i < 64; i++)
        light[i] = light_at(640.3 + 17.0 * i, 300.7 + 7.0 * i);
    const struct {
        const char *name;
        struct gp_flare f;
        int n;
    } rows[] = {
        {"all shapes, 1 light", all_shapes(e), 1},
        {"all shapes, 64 lights", {e, COUNT(laws) + 4}, 64},
        {"a sprite of 512x512", {&sprite, 1}, 1},
    };
    printf("1920x1080, %s\n", gp_gl_info(gl)->name);
    for (size_t k = 0; k < 2 * COUNT(rows); k++) {
        const struct gp_flare *const f = &rows[k / 2].f;
        struct picture p = picture_make(frame, frame);
        struct gp_flare_gl *kept = NULL;
        double least = INFINITY;
        for (int i = 0; i < 12; i++) {
            const double start = gp_now_ms();
            if (k % 2)
                draw(gl, &p, f, light, rows[k / 2].n, &kept);
            else
                add(&p, f, light, rows[k / 2].n);
            least = fmin(least, gp_now_ms() - start);
        }
        printf("%s, %s: %.2f ms\n", rows[k / 2].name, k % 2 ? "GL" : "CPU",
               least);
        gp_flare_close(gl, &kept);
        picture_free(&p);
    }
    gp_planes_free(&sprite.image.rgb);
    free_images(e, COUNT(e));
    gp_gl_close(&gl);
}

SUITE(flare_gl)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(forms_agree),
        cmocka_unit_test(tiles_agree),
        cmocka_unit_test(hidden_lights_stay_shut)};
    if (argc > 1 && strcmp(argv[1], "--time") == 0) {
        time_all();
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
