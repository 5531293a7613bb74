// SPDX-License-Identifier: Apache-2.0
/* What the library refuses, and by which name; what a step needs. */
#include "unit.h"

#include "glarepp.h"

#include <locale.h>

enum { W = 24, H = 16, PIXELS = W * H };

static struct glarepp *gp;
static float rgb[3 * PIXELS], depth[PIXELS];

static int start(void **state)
{
    for (int i = 0; i < 3 * PIXELS; i++)
        rgb[i] = 0.1f + (i % PIXELS == 200 ? 90.0f : 0.0f);
    return glarepp_open(NULL, &gp);
}

static int end(void **state)
{
    glarepp_close(&gp);
    return 0;
}

static struct glarepp_image view_of(float *v, int planes, int w, int h)
{
    struct glarepp_image view = GLAREPP_IMAGE;
    for (int c = 0; c < planes; c++)
        view.plane[c] = v + c * w * h;
    view.data = (struct glarepp_rect) {0, 0, w, h};
    return view;
}

static void is_refused(int status, const char *parameter)
{
    const struct glarepp_message *const m = glarepp_error();
    if (status != GLAREPP_ERR_USAGE || m->status != status ||
        strcmp(m->parameter, parameter) != 0)
        fail_msg("%s: status %d, \"%s\": %s", parameter, status, m->parameter,
                 m->text);
}

/* All parameters of a plan, each as by default. */
struct all {
    struct glarepp_plan_params plan;
    struct glarepp_sense_params sense;
    struct glarepp_layer_params layer;
    struct glarepp_light light;
    struct glarepp_light_params lights;
    struct glarepp_lens_params lens;
    struct glarepp_scene_params scene;
    struct glarepp_tone_params tone;
};

static void set(struct all *a)
{
    *a = (struct all) {
        GLAREPP_PLAN_PARAMS, GLAREPP_SENSE_PARAMS, GLAREPP_LAYER_PARAMS,
        GLAREPP_LIGHT, GLAREPP_LIGHT_PARAMS, GLAREPP_LENS_PARAMS,
        GLAREPP_SCENE_PARAMS, GLAREPP_TONE_PARAMS,
    };
    a->lights.light = &a->light;
    a->lights.lights = 1;
    a->plan.sense = &a->sense;
    a->plan.layer = &a->layer;
    a->plan.lights = &a->lights;
    a->plan.lens = &a->lens;
    a->plan.scene = &a->scene;
    a->plan.tone = &a->tone;
}

static void values_out_of_range(void **state)
{
    struct all a;
    struct glarepp_plan *plan;
    set(&a);
    assert_int_equal(glarepp_plan(gp, &a.plan, &plan), GLAREPP_OK);
    glarepp_plan_end(&plan);
#define BAD(struct_, field, ...)                                              \
    do {                                                                      \
        set(&a);                                                              \
        const __typeof__(a.struct_.field) bad[] = {__VA_ARGS__};                  \
        for (size_t i = 0; i < COUNT(bad); i++) {                             \
            a.struct_.field = bad[i];                                         \
            is_refused(glarepp_plan(gp, &a.plan, &plan), #struct_ "." #field); \
            assert_null(plan);                                                \
        }                                                                     \
    } while (0)
    BAD(plan, fov, NAN, -5.0, 361.0);
    BAD(plan, rotate, NAN, INFINITY);
    BAD(sense, threshold, NAN, INFINITY, -1.0f);
    BAD(sense, knee, NAN, -0.1f, 2.0f);
    BAD(sense, max_value, NAN, -1.0f, INFINITY);
    BAD(sense, unit, (enum glarepp_threshold) 3);
    BAD(layer, engine, NULL, "magic");
    BAD(layer, gain, NAN, INFINITY, -1.0f);
    BAD(layer, tolerance, NAN, -1.0f);
    BAD(layer, mix, (enum glarepp_mix) 2);
    BAD(layer, group, 0, 3, -4, 65);
    BAD(layer, cluster, 6, -8, 65);
    BAD(layer, shrink, NAN, 1.0f);
    BAD(layer, tint[2], NAN, -0.5f, INFINITY);
    BAD(layer, saturation, NAN, -0.5f, 11.0f);
    BAD(light, place, (enum glarepp_place) 9);
    BAD(light, at[1], NAN, INFINITY);
    BAD(light, flux[2], NAN, -1.0f, INFINITY);
    BAD(light, bias, NAN, 1.5);
    BAD(lights, lights, -1, 1025);
    BAD(lights, light, NULL);
    BAD(lights, method, (enum glarepp_share_method) 7);
    BAD(lights, outside, (enum glarepp_outside) 4, GLAREPP_BY_SCENE);
    BAD(lights, share_by, -1, 3, GLAREPP_SHARES_SCENE);
    BAD(lights, side, -1, 0, 59, 299);
    BAD(lights, adapt, NAN, 7.0f);
    BAD(lens, detail, -1, 9);
    BAD(lens, sensor, NAN, -1.0);
    BAD(scene, relights, -1);
    BAD(tone, curve, NULL, "magic");
    BAD(tone, exposure, NAN);
    BAD(tone, key, NAN, 0.0f);
#undef BAD
    set(&a);
    a.sense.unit = GLAREPP_PERCENTILE;
    a.sense.threshold = 150.0f;
    is_refused(glarepp_plan(gp, &a.plan, &plan), "sense.threshold");
}

/* Of what a caller's words are about, when the sentence is about a file. */
static void errors_of_readers_name_a_parameter(void **state)
{
    static const char *const words[] = {"moffat:share=2", "moffat:magic=1",
                                        "builtin:none"};
    struct glarepp_kernel_params k = GLAREPP_KERNEL_PARAMS;
    struct glarepp_kernel *kernel;
    struct glarepp_lens lens;
    struct glarepp_plan *plan;
    struct all a;
    k.words = 1;
    for (size_t i = 0; i < COUNT(words); i++) {
        k.word = &words[i];
        is_refused(glarepp_kernel(gp, &k, &kernel), "kernel");
    }
    const char *const *const file[] = {(const char *const *) &a.lights.file,
                                       (const char *const *) &a.lights.cameras};
    for (size_t i = 0; i < COUNT(file); i++) {
        set(&a);
        *(const char **) (uintptr_t) file[i] = "absent.json";
        assert_int_equal(glarepp_plan(gp, &a.plan, &plan), GLAREPP_ERR_IO);
        assert_string_equal(glarepp_error()->parameter, "lights");
    }
    set(&a);
    a.scene.path = "absent.glb";
    assert_int_equal(glarepp_plan(gp, &a.plan, &plan), GLAREPP_ERR_IO);
    assert_string_equal(glarepp_error()->parameter, "scene");
    assert_int_equal(glarepp_lens(gp, "absent.json", &lens), GLAREPP_ERR_IO);
}

// -- images -------------------------------------------------------------------

static void groups_are_of_the_frame(void **state)
{
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    const struct glarepp_image group[] = {view_of(rgb, 3, W, H),
                                          view_of(rgb, 3, W - 4, H)};
    struct glarepp_plan *plan;
    struct glarepp_frame *frame;
    assert_int_equal(glarepp_plan(gp, NULL, &plan), GLAREPP_OK);
    p.image = view_of(rgb, 3, W, H);
    p.group = group;
    for (int in_place = 0; in_place < 2; in_place++) {
        p.in_place = in_place;
        p.groups = 2;
        is_refused(glarepp_frame(plan, &p, &frame), "frame.group");
        assert_null(frame);
        p.groups = 1;
        assert_int_equal(glarepp_frame(plan, &p, &frame), GLAREPP_OK);
        glarepp_frame_end(&frame);
    }
    p.image.type = GLAREPP_CODES;
    is_refused(glarepp_frame(plan, &p, &frame), "image.type");
    glarepp_plan_end(&plan);
}

// -- steps --------------------------------------------------------------------

static struct glarepp_frame *begin(struct glarepp_plan **plan)
{
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    const struct glarepp_image z = view_of(depth, 1, W, H);
    struct glarepp_frame *frame;
    struct all a;
    set(&a);
    a.light.at[0] = 5.0;
    a.light.at[1] = 6.0;
    a.light.flux[0] = 10.0f;
    a.lens.lens = "examples/lenses/heliar.json";
    assert_int_equal(glarepp_plan(gp, &a.plan, plan), GLAREPP_OK);
    p.image = view_of(rgb, 3, W, H);
    assert_int_equal(glarepp_frame(*plan, &p, &frame), GLAREPP_OK);
    assert_int_equal(glarepp_frame_set(frame, GLAREPP_DEPTH, &z), GLAREPP_OK);
    return frame;
}

static void steps_say_what_they_need(void **state)
{
    static const enum glarepp_step early[] = {
        GLAREPP_SHARES, GLAREPP_KERNEL, GLAREPP_LAYER, GLAREPP_VERIFY,
        GLAREPP_FLARE, GLAREPP_LENS, GLAREPP_TONE, GLAREPP_STEPS,
    };
    static const enum glarepp_view unmade[] = {
        GLAREPP_SOURCES, GLAREPP_LIT, GLAREPP_SHOWN, GLAREPP_POLYGONS,
        GLAREPP_SUNMAP, GLAREPP_TRUTH,
    };
    struct glarepp_plan *plan;
    struct glarepp_image view;
    struct glarepp_frame *frame = begin(&plan);
    for (size_t i = 0; i < COUNT(early); i++)
        is_refused(glarepp_frame_run(frame, early[i]), "step");
    for (size_t i = 0; i < COUNT(unmade); i++)
        is_refused(glarepp_frame_view(frame, unmade[i], 0, &view), "view");
    for (int i = 0; i < GLAREPP_DONE; i++)
        assert_int_equal(glarepp_frame_run(frame, (enum glarepp_step) i),
                         GLAREPP_OK);
    is_refused(glarepp_frame_run(frame, GLAREPP_LENS), "step"); // twice
    assert_int_equal(glarepp_frame_run(frame, GLAREPP_DONE), GLAREPP_OK);
    is_refused(glarepp_frame_run(frame, GLAREPP_SHARES), "step");
    is_refused(glarepp_frame_view(frame, GLAREPP_SUNMAP, 0, &view), "view");
    glarepp_frame_drop(frame, 1u << GLAREPP_CLEAN);
    is_refused(glarepp_frame_run(frame, GLAREPP_SENSE), "step");
    glarepp_frame_end(&frame);
    glarepp_plan_end(&plan);
}

/* A caller may measure again, with another depth. */
static void shares_are_measured_again(void **state)
{
    struct glarepp_plan *plan;
    struct glarepp_frame *const frame = begin(&plan);
    for (int k = 0; k < 3; k++) {
        const struct glarepp_image z = view_of(depth, 1, W, H);
        for (int i = 0; i < PIXELS; i++)
            depth[i] = k == 1 ? 1.0f : 1e10f;
        assert_int_equal(glarepp_frame_set(frame, GLAREPP_DEPTH, &z), GLAREPP_OK);
        assert_int_equal(glarepp_frame_run(frame, GLAREPP_PLACE), GLAREPP_OK);
        assert_int_equal(glarepp_frame_run(frame, GLAREPP_SHARES), GLAREPP_OK);
        const struct glarepp_facts *const facts = glarepp_frame_facts(frame);
        assert_int_equal(facts->lights, 1);
        assert_true(facts->light[0].visibility == (k == 1 ? 0.0 : 1.0));
    }
    struct glarepp_frame *ended = frame;
    glarepp_frame_end(&ended);
    glarepp_plan_end(&plan);
}

// -- the thread ---------------------------------------------------------------

/* Numbers have a point whatever the caller's locale has, which stays. */
static void the_locale_stays(void **state)
{
    static const char *const word[] = {"moffat:share=.25,fwhm=0.5"};
    struct glarepp_kernel_params k = GLAREPP_KERNEL_PARAMS;
    struct glarepp_kernel *kernel;
    const int made = system("localedef -i de_DE -f UTF-8 "
                            "./comma.UTF-8 >/dev/null 2>&1");
    setenv("LOCPATH", ".", 1);
    const bool comma = made == 0 && setlocale(LC_ALL, "comma.UTF-8");
    unsetenv("LOCPATH");
    k.word = word;
    k.words = 1;
    const int st = glarepp_kernel(gp, &k, &kernel);
    const bool stays = !comma || *localeconv()->decimal_point == ',';
    setlocale(LC_ALL, "C");
    (void) !system("rm -rf ./comma.UTF-8");
    assert_int_equal(st, GLAREPP_OK);
    assert_true(stays);
    assert_non_null(strstr(glarepp_kernel_recipe(kernel, 0), "share=0.25"));
    glarepp_kernel_end(&kernel);
    if (!comma)
        skip();
}

/* A thread is in one context at a time. */
static void contexts_are_left(void **state)
{
    struct glarepp_params one = GLAREPP_PARAMS;
    struct glarepp *other;
    struct glarepp_plan *plan;
    one.threads = 1;
    assert_int_equal(glarepp_open(&one, &other), GLAREPP_OK);
    for (int i = 0; i < 2; i++) {
        glarepp_enter(other);
        glarepp_enter(gp);
        glarepp_leave(gp);
        glarepp_leave(other);
    }
    assert_int_equal(glarepp_plan(other, NULL, &plan), GLAREPP_OK);
    glarepp_plan_end(&plan);
    glarepp_close(&other);
}

SUITE_OF(refused, start, end, values_out_of_range,
         errors_of_readers_name_a_parameter, groups_are_of_the_frame,
         steps_say_what_they_need, shares_are_measured_again, the_locale_stays,
         contexts_are_left)
