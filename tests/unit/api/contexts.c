// SPDX-License-Identifier: Apache-2.0
/* Two contexts in two threads, each through all parts of the library at once:
 * the same bytes, and for ThreadSanitizer no race. */
#include "folder.h"
#include "unit.h"

#include "glarepp.h"

#include <pthread.h>
#include <unistd.h>

enum { W = 64, H = 36, PIXELS = W * H, SIDES = 2, RUNS = 2 };

static const char config_text[] =
    "ocio_profile_version: 2\n"
    "roles: {scene_linear: lin, default: lin}\n"
    "displays:\n  Screen:\n    - !<View> {name: Half, colorspace: half}\n"
    "colorspaces:\n  - !<ColorSpace> {name: lin}\n  - !<ColorSpace>\n"
    "    name: half\n"
    "    from_scene_reference: !<MatrixTransform> {matrix: [0.5,0,0,0, "
    "0,0.5,0,0, 0,0,0.5,0, 0,0,0,1]}\n";

static char config[256], bridges[4200];

static int start(void **state)
{
    char self[4096] = "";
    const char *const named = getenv("GLAREPP_BRIDGES");
    if (make_folder(state) || readlink("/proc/self/exe", self, 4095) < 0)
        return -1;
    *strrchr(self, '/') = '\0';
    snprintf(bridges, sizeof bridges, "%s%s", named ? named : self,
             named ? "" : "/..");
    snprintf(config, sizeof config, "%s", in_folder("c.ocio"));
    FILE *const f = fopen(config, "w");
    if (!f)
        return -1;
    fputs(config_text, f);
    return fclose(f);
}

/* A context in its thread. Statuses count too: a part that is missing here, as
 * GL may be, is missing on both sides. */
struct side {
    pthread_barrier_t *together; // before each part
    struct glarepp *gp;
    uint64_t sum;
    int parts, good;
};

static void add(struct side *s, const void *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++)
        s->sum = (s->sum ^ ((const unsigned char *) bytes)[i]) *
                 UINT64_C(1099511628211); // FNV-1a
}

static int begin(struct side *s)
{
    pthread_barrier_wait(s->together);
    s->parts++;
    return GLAREPP_OK;
}

static void end(struct side *s, int status)
{
    if (status)
        print_message("%s\n", glarepp_error()->text);
    s->good += !status;
    add(s, &status, sizeof status);
}

// -- parts --------------------------------------------------------------------

/* All presets, drawn. */
static void kernels(struct side *s)
{
    const struct glarepp_field field = {
        .w = W, .h = H, .fov = 30.0, .aspect = 1.0, .frame = 3,
        .fps = 24.0, .radius = 12, .most = 1 << 20,
    };
    const char *name, *text;
    for (int i = 0; (name = glarepp_name(s->gp, GLAREPP_PRESET_RECIPES, i,
                                         &text)); i++) {
        struct glarepp_kernel_params p = GLAREPP_KERNEL_PARAMS;
        struct glarepp_image k = GLAREPP_IMAGE;
        struct glarepp_kernel *kernel;
        struct glarepp_label label = {0};
        int st = begin(s);
        p.word = &name;
        p.words = 1;
        st = glarepp_kernel(s->gp, &p, &kernel);
        if (!st)
            st = glarepp_kernel_draw(kernel, &field, &k, &label);
        for (int c = 0; c < 3 && !st; c++)
            add(s, k.plane[c], sizeof(float) * (size_t) (k.data.x1 - k.data.x0) *
                                   (size_t) (k.data.y1 - k.data.y0));
        glarepp_image_end(&k);
        glarepp_kernel_end(&kernel);
        end(s, st);
    }
}

/* A frame with lights, flare, ghosts, a scene and a view, through all steps. */
static void frame(struct side *s, enum glarepp_share_method method,
                  const char *engine, bool posed)
{
    static const float depth[PIXELS]; // no surface
    float rgb[3 * PIXELS];
    struct glarepp_light light[2] = {GLAREPP_LIGHT, GLAREPP_LIGHT};
    struct glarepp_plan_params p = GLAREPP_PLAN_PARAMS;
    struct glarepp_layer_params layer = GLAREPP_LAYER_PARAMS;
    struct glarepp_light_params lights = GLAREPP_LIGHT_PARAMS;
    struct glarepp_lens_params lens = GLAREPP_LENS_PARAMS;
    struct glarepp_scene_params scene = GLAREPP_SCENE_PARAMS;
    struct glarepp_tone_params tone = GLAREPP_TONE_PARAMS;
    struct glarepp_frame_params how = GLAREPP_FRAME_PARAMS;
    struct glarepp_image view = GLAREPP_IMAGE;
    struct glarepp_plan *plan = NULL;
    struct glarepp_frame *f = NULL;
    int st = begin(s);
    for (int i = 0; i < 3 * PIXELS; i++)
        rgb[i] = 0.1f + (i % PIXELS == H / 2 * W + 20 ? 300.0f : 0.0f);
    for (int i = 0; i < 2; i++) {
        light[i].at[0] = 15.0 + 30.0 * i;
        light[i].at[1] = 12.0;
        light[i].radius = 3.0;
        light[i].flux[0] = light[i].flux[1] = light[i].flux[2] = 40.0f;
    }
    layer.engine = engine;
    lights.light = light;
    lights.lights = 2;
    lights.flare = "examples/flares/vintage.json";
    lights.method = method;
    lens.lens = "examples/lenses/tessar.json";
    scene.path = "examples/alley.glb";
    tone.config = posed ? config : NULL;
    p.layer = &layer;
    p.lights = &lights;
    p.lens = &lens;
    p.scene = posed ? &scene : NULL;
    p.tone = &tone;
    how.image.data = (struct glarepp_rect) {0, 0, W, H};
    for (int c = 0; c < 3; c++)
        how.image.plane[c] = rgb + c * PIXELS;
    how.numbered = true;
    how.details = true;
    st = glarepp_plan(s->gp, &p, &plan);
    if (!st)
        st = glarepp_frame(plan, &how, &f);
    view.data = how.image.data;
    view.plane[0] = (void *) depth;
    if (!st)
        st = glarepp_frame_set(f, GLAREPP_DEPTH, &view);
    for (int i = 0; i <= GLAREPP_DONE && !st; i++) {
        if (i != GLAREPP_RELIGHT && (posed || i != GLAREPP_POSE))
            st = glarepp_frame_run(f, (enum glarepp_step) i);
    }
    for (int v = GLAREPP_LIT; v <= GLAREPP_SHOWN && !st; v++) {
        st = glarepp_frame_view(f, (enum glarepp_view) v, 0, &view);
        for (int c = 0; c < 3 && !st; c++)
            add(s, view.plane[c], PIXELS * sizeof(float));
    }
    glarepp_frame_end(&f);
    glarepp_plan_end(&plan);
    end(s, st);
}

static void lenses(struct side *s)
{
    struct glarepp_lens lens;
    int st = begin(s);
    st = glarepp_lens(s->gp, "examples/lenses/heliar.json", &lens);
    const char *const svg =
        st ? NULL : glarepp_lens_draw(&lens, &lens.ghost[0]);
    if (svg)
        add(s, svg, strlen(svg));
    glarepp_lens_end(&lens);
    end(s, st);
}

static void comparing(struct side *s)
{
    float v[2][PIXELS];
    struct glarepp_channel channel[2];
    struct glarepp_stored image[2];
    struct glarepp_compare *compare;
    const int st = begin(s);
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < PIXELS; i++)
            v[k][i] = (float) (i % (17 + k));
        channel[k] = (struct glarepp_channel) {"Y", v[k], false};
        image[k] = (struct glarepp_stored) {
            .size = sizeof image[k], .data = {0, 0, W, H},
            .channel = &channel[k], .channels = 1, .light = {v[k], v[k], v[k]},
        };
    }
    assert_int_equal(st, glarepp_compare(s->gp, NULL, &image[0], &image[1],
                                         &compare));
    const double flip = glarepp_compare_facts(compare)->flip;
    add(s, &flip, sizeof flip);
    glarepp_compare_end(&compare);
    end(s, st);
}

static void *run_side(void *arg)
{
    struct side *const s = arg;
    struct glarepp_params p = GLAREPP_PARAMS;
    p.threads = 2;
    p.bridges = bridges;
    p.data = "examples";
    p.keep_memory = true;
    pthread_barrier_wait(s->together);
    for (int run = 0; run < RUNS; run++) {
        if (glarepp_open(&p, &s->gp))
            return NULL;
        kernels(s);
        frame(s, GLAREPP_EXACT, "fft", false);
        frame(s, GLAREPP_EXACT, "direct", true);
        frame(s, GLAREPP_MASK, "splat", false);
        lenses(s);
        comparing(s);
        glarepp_close(&s->gp);
    }
    return NULL;
}

static void side_by_side(void **state)
{
    struct side side[SIDES];
    pthread_t id[SIDES];
    pthread_barrier_t together;
    pthread_barrier_init(&together, NULL, SIDES);
    for (int i = 0; i < SIDES; i++) {
        side[i] = (struct side) {.together = &together};
        assert_int_equal(pthread_create(&id[i], NULL, run_side, &side[i]), 0);
    }
    for (int i = 0; i < SIDES; i++)
        pthread_join(id[i], NULL);
    pthread_barrier_destroy(&together);
    print_message("%d of %d parts ran\n", side[0].good, side[0].parts);
    assert_true(side[0].parts > 10 && side[0].good >= side[0].parts / 2);
    assert_true(side[0].sum == side[1].sum);
    assert_int_equal(side[0].good, side[1].good);
}

SUITE_OF(contexts, start, remove_folder, side_by_side)
