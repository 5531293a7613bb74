// SPDX-License-Identifier: Apache-2.0
/* What a caller does to the layer: its tint, and kernels and gains of groups. */
#include "unit.h"

#include "glarepp.h"

enum { W = 80, H = 48, PIXELS = W * H };

static struct glarepp *gp;

static int start(void **state)
{
    const struct glarepp_params p = GLAREPP_PARAMS;
    return glarepp_open(&p, &gp);
}

static int end(void **state)
{
    glarepp_close(&gp);
    return 0;
}

static struct glarepp_image view_of(float *rgb)
{
    struct glarepp_image v = GLAREPP_IMAGE;
    for (int c = 0; c < 3; c++)
        v.plane[c] = rgb + c * PIXELS;
    v.data = (struct glarepp_rect) {0, 0, W, H};
    return v;
}

/* A dim picture with a lamp. */
static void draw(float *rgb, int x, int y, float light)
{
    for (int i = 0; i < 3 * PIXELS; i++)
        rgb[i] = 0.05f + 0.001f * (float) (i % 7);
    for (int c = 0; c < 3; c++)
        rgb[c * PIXELS + y * W + x] = light * (1.0f + 0.5f * (float) c);
}

static void run_to(struct glarepp_frame *f, enum glarepp_step last)
{
    for (int i = 0; i <= (int) last; i++)
        assert_int_equal(glarepp_frame_run(f, (enum glarepp_step) i), 0);
}

static float sample(struct glarepp_frame *f, enum glarepp_view view, int c)
{
    struct glarepp_image v;
    assert_int_equal(glarepp_frame_view(f, view, 0, &v), GLAREPP_OK);
    return ((const float *) v.plane[c])[10 * W + 30];
}

// -- tint ---------------------------------------------------------------------

/* A layer is tinted once, by COMPOSE or DONE, each time that it is made; one that
 * is set has its colour; nothing may be added to it then. */
static void layers_are_tinted_once(void **state)
{
    static float rgb[3 * PIXELS];
    struct glarepp_layer_params layer = GLAREPP_LAYER_PARAMS;
    struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
    struct glarepp_lens_params lens = GLAREPP_LENS_PARAMS;
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_plan *plan;
    struct glarepp_frame *f;
    struct glarepp_image set = view_of(rgb);
    layer.tint[0] = 0.5f;
    layer.mix = GLAREPP_ADD;
    how.layer = &layer;
    lens.lens = "examples/lenses/tessar.json";
    how.lens = &lens;
    draw(rgb, 40, 20, 900.0f);
    p.image = view_of(rgb);
    assert_int_equal(glarepp_plan(gp, &how, &plan), GLAREPP_OK);
    assert_int_equal(glarepp_frame(plan, &p, &f), GLAREPP_OK);
    for (int again = 0; again < 2; again++) {
        run_to(f, GLAREPP_VERIFY);
        const float red = sample(f, GLAREPP_GLARE, 0);
        const float green = sample(f, GLAREPP_GLARE, 1);
        assert_true(red > 0.0f);
        assert_int_equal(
            glarepp_frame_run(f, again ? GLAREPP_COMPOSE : GLAREPP_DONE), 0);
        assert_int_equal(glarepp_frame_run(f, GLAREPP_COMPOSE), 0);
        assert_true(sample(f, GLAREPP_GLARE, 0) == 0.5f * red);
        assert_true(sample(f, GLAREPP_GLARE, 1) == green);
        assert_true(sample(f, GLAREPP_LIT, 0) == rgb[10 * W + 30] + 0.5f * red);
        assert_int_equal(glarepp_frame_run(f, GLAREPP_LENS), GLAREPP_ERR_USAGE);
    }
    assert_int_equal(glarepp_frame_set(f, GLAREPP_GLARE, &set), GLAREPP_OK);
    assert_int_equal(glarepp_frame_run(f, GLAREPP_COMPOSE), 0);
    assert_true(sample(f, GLAREPP_GLARE, 0) == rgb[10 * W + 30]);
    glarepp_frame_end(&f);
    glarepp_plan_end(&plan);
}

SUITE_OF(groups, start, end, layers_are_tinted_once)
