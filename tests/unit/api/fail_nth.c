// SPDX-License-Identifier: Apache-2.0
/* Memory that is full, a file that cannot be read, or a GL that refuses, twice
 * for each path of callers, through whole runs of the library: the documented
 * status and one message, or the same picture; no block lost. */
#include "fail.h"
#include "unit.h"

#include "glarepp.h"

#include <jansson.h>

// jansson 2.14 writes beyond a string whose next block it did not get
void *__real_malloc(size_t size);
void __real_free(void *block);

enum { W = 61, H = 43, PIXELS = W * H };

static int errors; // messages since
static char text[512];
static bool bare;  // of the last

static void keep(void *user, const struct glarepp_message *m)
{
    errors += m->level == GLAREPP_ERROR;
    bare = m->bare;
    if (m->level == GLAREPP_ERROR)
        snprintf(text, sizeof text, "%s", m->text);
}

/* The input of a run, and the picture that it makes. */
struct run {
    const char *name;
    int (*call)(struct glarepp *gp, const struct run *run);
    const char *word, *engine; // of the kernel; NULL: an image, "auto"
    bool lamps;                // few lights; else all is bright
    bool gl;
};
static float in[3 * PIXELS], out[3 * PIXELS], depth[PIXELS];

static void draw(bool lamps)
{
    for (int i = 0; i < 3 * PIXELS; i++)
        in[i] = lamps ? 0.05f : 2.0f + 0.1f * (float) (i % 7);
    for (int c = 0; c < 3; c++)
        in[c * PIXELS + 20 * W + 30] = 500.0f + 100.0f * (float) c;
    for (int i = 0; i < PIXELS; i++)
        depth[i] = i % 5 ? 1e10f : 3.0f;
}

static struct glarepp_image view_of(float *v, int planes)
{
    struct glarepp_image view = GLAREPP_IMAGE;
    for (int c = 0; c < planes; c++)
        view.plane[c] = v + c * PIXELS;
    view.data = (struct glarepp_rect) {0, 0, W, H};
    return view;
}

// -- runs ---------------------------------------------------------------------

static int make_kernel(struct glarepp *gp, const struct run *run,
                       struct glarepp_kernel **kernel)
{
    static float v[3 * PIXELS];
    const struct glarepp_image image = view_of(v, 3);
    struct glarepp_kernel_params p = GLAREPP_KERNEL_PARAMS;
    for (int i = 0; i < PIXELS; i++) {
        const double x = i % W - W / 2, y = i / W - H / 2;
        for (int c = 0; c < 3; c++)
            v[c * PIXELS + i] = (float) (1.0 / (1.0 + c + x * x + 2.0 * y * y));
    }
    p.word = &run->word;
    p.words = run->word != NULL;
    p.image = run->word ? NULL : &image;
    return glarepp_kernel(gp, &p, kernel);
}

/* One call, over a kernel that turns. */
static int execute(struct glarepp *gp, const struct run *run)
{
    struct glarepp_plan_params p = GLAREPP_PLAN_PARAMS;
    struct glarepp_layer_params layer = GLAREPP_LAYER_PARAMS;
    struct glarepp_kernel *kernel = NULL;
    struct glarepp_plan *plan = NULL;
    const struct glarepp_image a = view_of(in, 3), b = view_of(out, 3);
    layer.engine = run->engine ? run->engine : "auto";
    layer.cluster_fill = 0.5f;
    p.layer = &layer;
    p.rotate = 30.0;
    int st = make_kernel(gp, run, &kernel);
    p.kernel = kernel;
    st = st ? st : glarepp_plan(gp, &p, &plan);
    st = st ? st : glarepp_execute(plan, &a, &b, NULL);
    glarepp_plan_end(&plan);
    glarepp_kernel_end(&kernel);
    return st;
}

static int run_steps(struct glarepp_plan *plan)
{
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_frame *frame = NULL;
    struct glarepp_image view = view_of(depth, 1);
    p.image = view_of(in, 3);
    p.details = true;
    int st = glarepp_frame(plan, &p, &frame);
    st = st ? st : glarepp_frame_set(frame, GLAREPP_DEPTH, &view);
    for (int i = 0; !st && i < GLAREPP_STEPS; i++)
        st = glarepp_frame_run(frame, (enum glarepp_step) i);
    st = st ? st : glarepp_frame_view(frame, GLAREPP_SHOWN, 0, &view);
    for (int c = 0; !st && c < 3; c++)
        memcpy(out + c * PIXELS, view.plane[c], PIXELS * sizeof *out);
    glarepp_frame_end(&frame);
    return st;
}

/* All steps: lights with shares, flares, a lens, --verify, a curve. */
static int steps(struct glarepp *gp, const struct run *run)
{
    struct glarepp_light light = GLAREPP_LIGHT;
    struct glarepp_plan_params p = GLAREPP_PLAN_PARAMS;
    struct glarepp_layer_params layer = GLAREPP_LAYER_PARAMS;
    struct glarepp_light_params lights = GLAREPP_LIGHT_PARAMS;
    struct glarepp_lens_params lens = GLAREPP_LENS_PARAMS;
    struct glarepp_plan *plan = NULL;
    light.at[0] = 20.0;
    light.at[1] = 12.0;
    light.radius = 4.0;
    light.depth = 100.0;
    for (int c = 0; c < 3; c++)
        light.flux[c] = 1e3f;
    layer.engine = "fft";
    lights.light = &light;
    lights.lights = 1;
    lights.flare = "preset:vintage";
    lights.method = run->gl ? GLAREPP_MASK : GLAREPP_EXACT;
    lens.lens = "tessar";
    lens.sensor = 36.0;
    p.layer = &layer;
    p.lights = &lights;
    p.lens = &lens;
    int st = glarepp_plan(gp, &p, &plan);
    st = st ? st : run_steps(plan);
    glarepp_plan_end(&plan);
    return st;
}

/* Samples of recipes, in each way to draw them. */
static int kernels(struct glarepp *gp, const struct run *run)
{
    const struct glarepp_field field = {
        .w = 40, .h = 30, .fov = 30.0 / 36.0, .aspect = 1.0, .rotate = 30.0,
        .frame = 3, .fps = 24.0, .most = 1 << 20,
    };
    struct glarepp_kernel *kernel = NULL;
    struct glarepp_image image = GLAREPP_IMAGE;
    struct glarepp_label label = {0};
    int st = make_kernel(gp, run, &kernel);
    st = st ? st : glarepp_kernel_draw(kernel, &field, &image, &label);
    for (int c = 0; !st && c < 3; c++)
        memcpy(out + c * PIXELS, image.plane[c], PIXELS * sizeof *out);
    glarepp_image_end(&image);
    glarepp_kernel_end(&kernel);
    return st;
}

/* A triangle before a camera, and a lamp that moves. */
static const char gltf_path[] = "/tmp/glarepp-fail-nth.gltf";
static const char gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":["
    "\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{"
    "\"lights\":[{\"type\":\"point\",\"name\":\"l\",\"intensity\":9}]}},"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:;base64,"
    "AAAQwQAAEMEAAKDAAAAQQQAAEMEAAKDAAAAAAAAAEEEAAKDA\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":["
    "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[-9,-9,-5],\"max\":[9,9,-5]},{\"bufferView\":0,"
    "\"componentType\":5126,\"count\":1,\"type\":\"SCALAR\",\"min\":[-9],"
    "\"max\":[-9]},{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5126,"
    "\"count\":1,\"type\":\"VEC3\"}],\"materials\":[{\"name\":\"m\"}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
    "\"material\":0}]}],\"cameras\":[{\"type\":\"perspective\","
    "\"perspective\":{\"yfov\":1,\"znear\":0.1}}],\"nodes\":["
    "{\"name\":\"t\",\"mesh\":0},{\"name\":\"c\",\"camera\":0},"
    "{\"name\":\"l\",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
    "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,"
    "\"path\":\"translation\"}}],\"samplers\":[{\"input\":1,\"output\":2}]}],"
    "\"scenes\":[{\"nodes\":[0,1,2]}],\"scene\":0}";

static int scene(struct glarepp *gp, const struct run *run)
{
    static const char *const all = "all";
    struct glarepp_plan_params p = GLAREPP_PLAN_PARAMS;
    struct glarepp_scene_params s = GLAREPP_SCENE_PARAMS;
    struct glarepp_frame_params f = GLAREPP_FRAME_PARAMS;
    struct glarepp_image view[] = {view_of(depth, 1), view_of(in, 3)};
    struct glarepp_plan *plan = NULL;
    struct glarepp_frame *frame = NULL;
    s.path = gltf_path;
    s.relight = &all;
    s.relights = 1;
    s.light_scale = 1.0;
    p.scene = &s;
    f.image = view_of(in, 3);
    int st = glarepp_plan(gp, &p, &plan);
    st = st ? st : glarepp_frame(plan, &f, &frame);
    for (int i = 0; !st && i < 3; i++)
        st = glarepp_frame_set(frame, i == 0 ? GLAREPP_DEPTH : i == 1
                               ? GLAREPP_NORMAL : GLAREPP_ALBEDO, &view[i > 0]);
    for (int i = 0; !st && i <= GLAREPP_SHARES; i++)
        st = glarepp_frame_run(frame, (enum glarepp_step) i);
    glarepp_frame_end(&frame);
    glarepp_plan_end(&plan);
    return st;
}

/* Planes that a frame borrows stay the caller's. */
static int borrow(struct glarepp *gp, const struct run *run)
{
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_plan *plan = NULL;
    struct glarepp_frame *frame = NULL;
    p.image = view_of(in, 3);
    p.in_place = true;
    int st = glarepp_plan(gp, NULL, &plan);
    st = st ? st : glarepp_frame(plan, &p, &frame);
    glarepp_frame_end(&frame);
    glarepp_plan_end(&plan);
    return st;
}

static const struct run runs[] = {
    {"image, few", execute, .engine = "direct", .lamps = true},
    {"image, all", execute, .engine = "direct"},
    {"image, fft", execute, .engine = "fft"},
    {"image, splat", execute, .engine = "splat", .lamps = true, .gl = true},
    {"image, clusters", execute, .engine = "splat", .gl = true},
    {"eye", execute, .word = "eye", .lamps = true},
    {"borrow", borrow, .lamps = true}, {"steps", steps, .lamps = true},
    {"steps, mask", steps, .lamps = true, .gl = true},
    {"eye", kernels, .word = "eye"}, {"night", kernels, .word = "eye-night"},
    {"aperture", kernels, .word = "aperture:wavelengths=1,coma=0.1,lashes=0.1"},
    {"temporal", kernels, .word = "temporal:wavelengths=1,pupil=2,reach=1"},
    {"star", kernels, .word = "star"}, {"streak", kernels, .word = "streak"},
    {"ring", kernels, .word = "ring"}, {"moffat", kernels, .word = "moffat"},
    {"halation", kernels, .word = "halation"},
    {"scene", scene, .lamps = true},
};

// -- faults -------------------------------------------------------------------

static const struct fault {
    enum fail_class class;
    int status;
} faults[] = {{FAIL_ALLOC, GLAREPP_ERR_BUG}, {FAIL_IO, GLAREPP_ERR_IO},
              {FAIL_GL, GLAREPP_ERR_GL}};

/* A step that a run can do without may fail: its picture is the same then.
 * Returns whether the run was done without the fault. */
static bool one_fault(struct glarepp *gp, const struct run *run,
                      const struct fault *f, const float *want)
{
    const long blocks = fail_blocks();
    errors = 0;
    text[0] = '\0';
    memset(out, 0, sizeof out);
    fail_next(f->class);
    const int st = run->call(gp, run);
    const bool fired = fail_end();
    const bool right = st ? fired && st == f->status && errors == 1
                          : errors == 0 && memcmp(out, want, sizeof out) == 0;
    if (!right || fail_blocks() != blocks)
        fail_msg("%s: status %d, %d errors, %ld blocks: %s", run->name, st,
                 errors, fail_blocks() - blocks, text);
    return !fired;
}

static void every_fault(struct glarepp *gp, const struct run *run)
{
    static float want[3 * PIXELS];
    draw(run->lamps);
    int st = run->call(gp, run);
    if (st == GLAREPP_ERR_GL && run->gl) {
        print_message("%s: no context: %s\n", run->name, text);
        return;
    }
    if (st)
        fail_msg("%s: %s", run->name, text);
    memset(out, 0, sizeof out);
    st = run->call(gp, run);
    assert_int_equal(st, GLAREPP_OK);
    memcpy(want, out, sizeof want);
    for (size_t k = 0; k < COUNT(faults); k++) {
        int n = 0;
        fail_forget();
        while (!one_fault(gp, run, &faults[k], want))
            n++;
        print_message("%s: %d faults\n", run->name, n);
        assert_true(n > 0 || k > 0);
    }
}

static void runs_end_well(void **state)
{
    struct glarepp_params p = GLAREPP_PARAMS;
    struct glarepp *gp;
    p.threads = 2;
    p.message = keep;
    p.data = "examples";
    FILE *const f = fopen(gltf_path, "w");
    json_set_alloc_funcs(__real_malloc, __real_free);
    assert_true(f && fputs(gltf, f) >= 0 && fclose(f) == 0);
    fail_at(FAIL_ALLOC, 1);
    assert_int_equal(glarepp_open(&p, &gp), GLAREPP_ERR_BUG);
    assert_true(fail_end() && errors == 1 && bare);
    assert_int_equal(glarepp_open(&p, &gp), GLAREPP_OK);
    for (size_t i = 0; i < COUNT(runs); i++) {
        if (!runs[i].gl || !getenv("GLAREPP_TEST_QUICK"))
            every_fault(gp, &runs[i]);
    }
    glarepp_close(&gp);
    assert_int_equal(remove(gltf_path), 0);
}

SUITE_OF(fail_nth, NULL, NULL, runs_end_well)
