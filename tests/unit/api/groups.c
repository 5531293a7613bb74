// SPDX-License-Identifier: Apache-2.0
/* Changes of the layer by its caller: its tint, and kernels and gains of groups. */
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

// -- kernels and gains ----------------------------------------------------------

static float lamps[2][3 * PIXELS], all[3 * PIXELS];

/* Makes the layer of the first `groups` lamps, or with `groups` 0 of the first
 * lamp alone; the plan's kernel is a ring, and another one is `more`. */
static void make(const char *engine, const struct glarepp_group *how,
                 int groups, const char *kernel, float *layer,
                 struct glarepp_facts *facts)
{
    static const char *const star = "star";
    struct glarepp_kernel_params words = GLAREPP_KERNEL_PARAMS;
    struct glarepp_layer_params p = GLAREPP_LAYER_PARAMS;
    struct glarepp_plan_params plan_params = GLAREPP_PLAN_PARAMS;
    struct glarepp_frame_params frame = GLAREPP_FRAME_PARAMS;
    struct glarepp_image group[2], v;
    struct glarepp_kernel *main, *other;
    struct glarepp_plan *plan;
    struct glarepp_frame *f;
    words.words = 1;
    words.word = &kernel;
    assert_int_equal(glarepp_kernel(gp, &words, &main), GLAREPP_OK);
    words.word = &star;
    assert_int_equal(glarepp_kernel(gp, &words, &other), GLAREPP_OK);
    const struct glarepp_kernel *const more[] = {other};
    p.engine = engine;
    p.tolerance_pixel = 0.01f;
    plan_params.kernel = main;
    plan_params.layer = &p;
    plan_params.more = more;
    plan_params.mores = 1;
    frame.image = view_of(groups ? all : lamps[0]);
    for (int i = 0; i < groups; i++)
        group[i] = view_of(lamps[i]);
    frame.group = group;
    frame.groups = groups;
    frame.how = how;
    assert_int_equal(glarepp_plan(gp, &plan_params, &plan), GLAREPP_OK);
    assert_int_equal(glarepp_frame(plan, &frame, &f), GLAREPP_OK);
    run_to(f, GLAREPP_VERIFY);
    assert_int_equal(glarepp_frame_view(f, GLAREPP_GLARE, 0, &v), GLAREPP_OK);
    for (int c = 0; c < 3; c++)
        memcpy(layer + c * PIXELS, v.plane[c], PIXELS * sizeof *layer);
    *facts = *glarepp_frame_facts(f);
    assert_true(facts->errors.rel_l2 <= facts->layer.bound);
    assert_true(facts->errors.max_rel <= facts->layer.bound_pixel);
    glarepp_frame_end(&f);
    glarepp_plan_end(&plan);
    glarepp_kernel_end(&main);
    glarepp_kernel_end(&other);
}

/* Each group is spread by its kernel, times its gain, and all of them add up; the
 * bounds hold. */
static void groups_have_kernels_and_gains(void **state)
{
    static const struct glarepp_group star[2] = {{1, 1.0f}, {0, 2.0f}};
    static const struct glarepp_group ring[2] = {{0, 0.0f}, {0, 2.0f}};
    static const struct glarepp_group one[2] = {{0, 1.0f}, {0, 1.0f}};
    static float a[3 * PIXELS], b[3 * PIXELS], sum[3 * PIXELS];
    struct glarepp_facts facts;
    draw(lamps[0], 20, 20, 900.0f);
    draw(lamps[1], 60, 30, 300.0f);
    for (int i = 0; i < 3 * PIXELS; i++)
        all[i] = lamps[0][i] + lamps[1][i];
    static const char *const engines[] = {"direct", "fft", "auto"};
    for (size_t e = 0; e < COUNT(engines); e++) {
        make(engines[e], star, 1, "ring", a, &facts);
        assert_int_equal(facts.sense.sources, 1);
        const double bound = facts.layer.bound;
        make(engines[e], one, 1, "star", b, &facts);
        assert_memory_equal(a, b, sizeof a);
        make(engines[e], ring, 2, "ring", b, &facts);
        assert_int_equal(facts.sense.sources, 1);
        const double least = fmin(bound, facts.layer.bound);
        make(engines[e], star, 2, "ring", sum, &facts);
        assert_int_equal(facts.sense.sources, 2);
        assert_true(facts.layer.bound >= least && facts.layer.bound < 1e-4);
        double most = 0.0;
        for (int i = 0; i < 3 * PIXELS; i++) {
            most = fmax(most, (double) sum[i]);
            assert_true(fabs((double) (a[i] + b[i] - sum[i])) <= 1e-4);
        }
        assert_true(most > 10.0);
        make(engines[e], one, 2, "ring", a, &facts);
        make(engines[e], NULL, 2, "ring", b, &facts);
        assert_memory_equal(a, b, sizeof a);
    }
}

static void groups_are_refused(void **state)
{
    static const struct glarepp_group bad[] = {
        {1, 1.0f}, {-1, 1.0f}, {0, -1.0f}, {0, NAN}, {0, 2e6f},
    };
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
    struct glarepp_image group;
    struct glarepp_plan *plan;
    struct glarepp_frame *f;
    draw(all, 20, 20, 900.0f);
    group = p.image = view_of(all);
    p.group = &group;
    p.groups = 1;
    assert_int_equal(glarepp_plan(gp, &how, &plan), GLAREPP_OK);
    for (size_t i = 0; i < COUNT(bad); i++) {
        p.how = &bad[i];
        assert_int_equal(glarepp_frame(plan, &p, &f), GLAREPP_ERR_USAGE);
        assert_string_equal(glarepp_error()->parameter,
                            i < 2 ? "group.kernel" : "group.gain");
    }
    glarepp_plan_end(&plan);
    how.mores = 1;
    assert_int_equal(glarepp_plan(gp, &how, &plan), GLAREPP_ERR_USAGE);
    assert_string_equal(glarepp_error()->parameter, "plan.more");
}

SUITE_OF(groups, start, end, layers_are_tinted_once,
         groups_have_kernels_and_gains, groups_are_refused)
