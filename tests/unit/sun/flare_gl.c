/* flare on GL: equals the plain form, in tiles too; hidden lights stay shut. */
#include "scene.h"
#include "gl_open.h"

/* A context, what flare keeps on it, and all elements. */
struct stage {
    struct gp_gl *gl;
    struct gp_flare_gl *kept;
    struct gp_flare_element e[4];
    struct gp_flare all;
};

static void open_stage(struct stage *s)
{
    *s = (struct stage) {.gl = open_or_skip(GP_GL_AUTO)};
    s->all = all_images(s->e);
}

static void close_stage(struct stage *s)
{
    gp_flare_close(s->gl, &s->kept);
    assert_null(s->kept);
    gp_flare_close(s->gl, &s->kept);
    free_images(s->e, s->all.n);
    gp_gl_close(&s->gl);
}

static void draw(struct stage *s, struct picture *p, const struct gp_flare *f,
                 const struct gp_light *light, int n)
{
    struct gp_texture t = {0};
    float *const rgba = calloc((size_t) n, 4 * sizeof(float));
    assert_non_null(rgba);
    for (int i = 0; i < n; i++) {
        rgba[4 * i] = (float) light[i].visibility * 0.5f;
        rgba[4 * i + 1] = 0.5f;
    }
    assert_ok(gp_texture_make(&kept_log, s->gl, "test", GP_TEXEL_FLOAT,
                     n, 1, &t));
    gp_texture_write(s->gl, &t, (struct gp_rect) {0, 0, n, 1}, rgba);
    assert_ok(gp_flare_draw(&kept_log, s->gl, f, light, n, &t, p->frame,
                                   p->display, &s->kept));
    assert_ok(gp_flare_read_layer(&kept_log, s->gl, s->kept, p->frame,
                                         &p->layer));
    gp_texture_free(s->gl, &t);
    free(rgba);
}

/* Draws both forms and compares them. */
static void check_pair(struct stage *s, const struct gp_flare *f,
    const struct gp_light *light, int n, struct gp_rect frame,
    struct gp_rect display, size_t row)
{
    struct picture a = picture_make(frame, display);
    struct picture b = picture_make(frame, display);
    add(&a, f, light, n);
    draw(s, &b, f, light, n);
    for (int c = 0; c < 3; c++) {
        double peak = 0.0, off = 0.0;
        for (size_t i = 0; i < picture_pixels(&a); i++) {
            const double u = (double) a.layer.c[c][i];
            const double v = (double) b.layer.c[c][i];
            peak = fmax(peak, fabs(u));
            off = fmax(off, fabs(u - v));
        }
        if (!(off <= 1e-5 * peak))
            fail_msg("row %zu channel %d: off by %g of %g", row, c, off, peak);
    }
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
    struct stage s;
    struct gp_light light[9];
    open_stage(&s);
    for (int i = 0; i < 9; i++) {
        light[i] = lamp_at(37.3 * i - 20.0, 31.7 * i + 0.3);
        light[i].visibility = i == 4 ? 0.0 : 0.11 * i;
    }
    light[7].behind = true;
    const size_t step = getenv("GLAREPP_TEST_QUICK") ? 6 : 1;
    for (size_t i = 0; i < (size_t) s.all.n; i += step) {
        const struct gp_flare f = {.element = &s.e[i], .n = 1};
        check_pair(&s, &f, light + 3, 1, frames[0], frames[0], i);
    }
    for (size_t k = 0; k < COUNT(frames); k += step)
        check_pair(&s, &s.all, light, 9, frames[k], frames[0], 100 + k);
    close_stage(&s);
}

/* Frames beyond a texture's size come in tiles. */
static void tiles_agree(void **state)
{
    struct stage s;
    const struct gp_light l[2] = {lamp_at(60.3, 41.7), lamp_at(-20, 180)};
    const struct gp_rect frame = {-3, 2, 450, 321};
    set_env("GLAREPP_GL_MAX_SIZE", "128");
    open_stage(&s);
    assert_int_equal(gp_gl_info(s.gl)->max_size, 128);
    check_pair(&s, &s.all, l, 2, frame, frame, 0);
    close_stage(&s);
    set_env("GLAREPP_GL_MAX_SIZE", NULL);
}

static void hidden_lights_stay_shut(void **state)
{
    static const struct gp_flare none = {0};
    struct stage s;
    struct gp_light l = lamp_at(60.3, 41.7);
    struct picture p = picture_of(200, 150);
    open_stage(&s);
    l.visibility = 0.0;
    draw(&s, &p, &s.all, &l, 1);
    l.visibility = 1.0;
    l.behind = true;
    draw(&s, &p, &s.all, &l, 1);
    draw(&s, &p, &none, &l, 1);
    for (int c = 0; c < 3; c++)
        assert_true(total(&p, c) == 0.0);
    picture_free(&p);
    close_stage(&s);
}

SUITE_OF(flare_gl, NULL, NULL, forms_agree, tiles_agree,
         hidden_lights_stay_shut)
