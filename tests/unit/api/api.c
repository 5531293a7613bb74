// SPDX-License-Identifier: Apache-2.0
/* glarepp.h: what its contracts say, seen from outside. */
#include "unit.h"

#include "glarepp.h"

#include <pthread.h>
#include <stdatomic.h>

enum { W = 96, H = 54, PIXELS = W * H };

/* A context, a plan of defaults, and the last message. */
struct world {
    struct glarepp *gp;
    struct glarepp_plan *plan;
    char text[512], parameter[64];
    int messages, status;
    const char *stop; // step before which a call is cancelled
};

static void keep(void *user, const struct glarepp_message *m)
{
    struct world *const w = user;
    w->messages++;
    w->status = m->status;
    snprintf(w->text, sizeof w->text, "%s", m->text);
    snprintf(w->parameter, sizeof w->parameter, "%s", m->parameter);
}

static bool progress(void *user, const char *step, double done)
{
    struct world *const w = user;
    assert_true(done >= 0.0 && done <= 1.0);
    return w->stop && strcmp(w->stop, step) == 0;
}

static void open_world(struct world *w, int threads)
{
    struct glarepp_params p = GLAREPP_PARAMS;
    p.threads = threads;
    p.message = keep;
    p.progress = progress;
    p.user = w;
    *w = (struct world) {0};
    assert_int_equal(glarepp_open(&p, &w->gp), GLAREPP_OK);
    assert_int_equal(glarepp_plan(w->gp, NULL, &w->plan), GLAREPP_OK);
}

static void close_world(struct world *w)
{
    glarepp_plan_end(&w->plan);
    glarepp_close(&w->gp);
    assert_null(w->gp);
}

/* A dim frame with lamps, as planes. */
static void draw(float *rgb, int lamp)
{
    for (int i = 0; i < 3 * PIXELS; i++)
        rgb[i] = 0.05f + 0.001f * (float) (i % 7);
    for (int c = 0; c < 3; c++)
        rgb[c * PIXELS + H / 2 * W + lamp] = 500.0f + 100.0f * (float) c;
}

static struct glarepp_image view_of(float *rgb)
{
    struct glarepp_image v = GLAREPP_IMAGE;
    for (int c = 0; c < 3; c++)
        v.plane[c] = rgb + c * PIXELS;
    v.data = (struct glarepp_rect) {0, 0, W, H};
    return v;
}

// -- results ------------------------------------------------------------------

/* Glare is added, light is kept, the error is bounded. */
static void adds_glare(void **state)
{
    static float in[3 * PIXELS], out[3 * PIXELS];
    struct glarepp_facts facts;
    struct world w;
    open_world(&w, 0);
    draw(in, 40);
    const struct glarepp_image a = view_of(in), b = view_of(out);
    assert_int_equal(glarepp_execute(w.plan, &a, &b, &facts), GLAREPP_OK);
    assert_int_equal(facts.sense.sources, 1);
    assert_true(facts.layer.bound > 0.0 && facts.layer.bound <= 1e-3);
    assert_true(out[H / 2 * W + 44] > 1.02f * in[H / 2 * W + 44]);
    assert_true(out[H / 2 * W + 40] < in[H / 2 * W + 40]);
    double before = 0.0, after = 0.0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        before += (double) in[i];
        after += (double) out[i];
    }
    assert_true(after <= before * (1.0 + 1e-5));
    assert_true(after >= 0.9 * before);
    close_world(&w);
}

/* Without light the output is the input, and no engine runs. */
static void dark_frame_stays(void **state)
{
    static float in[3 * PIXELS], out[3 * PIXELS];
    struct glarepp_facts facts;
    struct world w;
    open_world(&w, 0);
    for (int i = 0; i < 3 * PIXELS; i++)
        in[i] = 0.5f;
    const struct glarepp_image a = view_of(in), b = view_of(out);
    assert_int_equal(glarepp_execute(w.plan, &a, &b, &facts), GLAREPP_OK);
    assert_memory_equal(in, out, sizeof in);
    assert_string_equal(facts.layer.engine, "none");
    close_world(&w);
}

/* Planes, interleaved pixels, padded rows and halfs hold the same picture. */
static void views_agree(void **state)
{
    static float in[3 * PIXELS], out[3 * PIXELS], packed[3 * PIXELS];
    static float wide[3 * (W + 5) * H];
    static uint16_t half[4 * PIXELS];
    struct world w;
    open_world(&w, 0);
    draw(in, 60);
    const struct glarepp_image a = view_of(in), b = view_of(out);
    assert_int_equal(glarepp_execute(w.plan, &a, &b, NULL), GLAREPP_OK);
    struct glarepp_image v = view_of(packed);
    for (int c = 0; c < 3; c++)
        v.plane[c] = packed + c;
    v.pixel = 3 * sizeof(float);
    assert_int_equal(glarepp_execute(w.plan, &a, &v, NULL), GLAREPP_OK);
    for (int i = 0; i < 3 * PIXELS; i++)
        assert_true(packed[i % PIXELS * 3 + i / PIXELS] == out[i]);
    v = view_of(wide);
    v.row = (W + 5) * sizeof(float);
    for (int c = 0; c < 3; c++)
        v.plane[c] = wide + c * (W + 5) * H;
    assert_int_equal(glarepp_execute(w.plan, &a, &v, NULL), GLAREPP_OK);
    assert_int_equal(glarepp_execute(w.plan, &v, &v, NULL), GLAREPP_OK);
    v = view_of(NULL);
    for (int c = 0; c < 3; c++)
        v.plane[c] = half + c;
    v.type = GLAREPP_HALF;
    v.pixel = 4 * sizeof *half;
    assert_int_equal(glarepp_execute(w.plan, &a, &v, NULL), GLAREPP_OK);
    struct glarepp_image floats = view_of(packed);
    struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
    struct glarepp_layer_params none = GLAREPP_LAYER_PARAMS;
    struct glarepp_plan *still;
    none.gain = 0.0f;
    how.layer = &none;
    assert_int_equal(glarepp_plan(w.gp, &how, &still), GLAREPP_OK);
    assert_int_equal(glarepp_execute(still, &v, &floats, NULL), GLAREPP_OK);
    for (int i = 0; i < 3 * PIXELS; i++)
        assert_true(fabsf(packed[i] - out[i]) <= 0.0005f * out[i]);
    glarepp_plan_end(&still);
    close_world(&w);
}

/* Reads the layer and the lit picture of a frame with a mask, or NULL. */
static void spread(struct world *w, const struct glarepp_image *image,
                   float *mask, float *layer, float *lit)
{
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_frame *frame;
    struct glarepp_image v = view_of(mask);
    p.image = *image;
    assert_int_equal(glarepp_frame(w->plan, &p, &frame), GLAREPP_OK);
    if (mask)
        assert_int_equal(glarepp_frame_set(frame, GLAREPP_SOURCE_MASK, &v),
                         GLAREPP_OK);
    for (int i = GLAREPP_SENSE; i <= GLAREPP_COMPOSE; i++) {
        if (i != GLAREPP_VERIFY)
            assert_int_equal(glarepp_frame_run(frame, (enum glarepp_step) i),
                             GLAREPP_OK);
    }
    assert_int_equal(glarepp_frame_view(frame, GLAREPP_GLARE, 0, &v),
                     GLAREPP_OK);
    for (int c = 0; c < 3; c++)
        memcpy(layer + c * PIXELS, v.plane[c], PIXELS * sizeof *layer);
    assert_int_equal(glarepp_frame_view(frame, GLAREPP_LIT, 0, &v), GLAREPP_OK);
    for (int c = 0; c < 3; c++)
        memcpy(lit + c * PIXELS, v.plane[c], PIXELS * sizeof *lit);
    glarepp_frame_end(&frame);
}

/* Of a mask and its inverse, layers add up to that without one, with any edges, and
 * so does the light that is taken. */
static void masks_add_up(void **state)
{
    static float in[3 * PIXELS], mask[2][PIXELS], layer[3][3 * PIXELS],
        lit[3][3 * PIXELS];
    for (int edges = GLAREPP_BLACK; edges <= GLAREPP_MIRROR; edges++) {
        struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
        struct glarepp_layer_params p = GLAREPP_LAYER_PARAMS;
        struct world w;
        double norm = 0.0, error[2] = {0.0, 0.0};
        open_world(&w, 0);
        draw(in, 40);
        for (int i = 0; i < PIXELS; i++) {
            in[i] += i % W < 8 ? 30.0f : 0.0f; // a wall along the border
            mask[0][i] = (float) (i % 9) / 8.0f;
            mask[1][i] = 1.0f - mask[0][i];
        }
        p.edges = (enum glarepp_edges) edges;
        p.engine = "fft";
        how.layer = &p;
        glarepp_plan_end(&w.plan);
        assert_int_equal(glarepp_plan(w.gp, &how, &w.plan), GLAREPP_OK);
        const struct glarepp_image a = view_of(in);
        spread(&w, &a, NULL, layer[2], lit[2]);
        spread(&w, &a, mask[0], layer[0], lit[0]);
        spread(&w, &a, mask[1], layer[1], lit[1]);
        for (int i = 0; i < 3 * PIXELS; i++) {
            const double whole = (double) layer[2][i];
            const double sum = (double) layer[0][i] + (double) layer[1][i];
            const double moved = (double) lit[0][i] + (double) lit[1][i] -
                                 (double) in[i] - (double) lit[2][i];
            norm += whole * whole;
            error[0] += (sum - whole) * (sum - whole);
            error[1] += moved * moved;
        }
        assert_true(norm > 1.0 && sqrt(error[0] / norm) < 1e-6);
        assert_true(sqrt(error[1] / norm) < 1e-6);
        close_world(&w);
    }
}

/* In place gives what two images give. */
static void in_place(void **state)
{
    static float in[3 * PIXELS], out[3 * PIXELS];
    struct world w;
    open_world(&w, 0);
    draw(in, 20);
    const struct glarepp_image a = view_of(in), b = view_of(out);
    assert_int_equal(glarepp_execute(w.plan, &a, &b, NULL), GLAREPP_OK);
    assert_int_equal(glarepp_execute(w.plan, &a, &a, NULL), GLAREPP_OK);
    assert_memory_equal(in, out, sizeof in);
    close_world(&w);
}

// -- threads ------------------------------------------------------------------

struct job {
    struct world *w;
    float in[3 * PIXELS], out[3 * PIXELS];
    int status;
};

static void *run_job(void *arg)
{
    struct job *const j = arg;
    const struct glarepp_image a = view_of(j->in), b = view_of(j->out);
    for (int k = 0; k < 3 && !j->status; k++)
        j->status = glarepp_execute(j->w->plan, &a, &b, NULL);
    return NULL;
}

/* Two contexts of other numbers of threads, and two threads of one plan, give
 * the same bytes. */
static void threads_agree(void **state)
{
    enum { JOBS = 4 };
    static struct job job[JOBS];
    struct world w[2];
    pthread_t id[JOBS];
    open_world(&w[0], 1);
    open_world(&w[1], 3);
    for (int i = 0; i < JOBS; i++) {
        job[i].w = &w[i % 2];
        draw(job[i].in, 30);
        assert_int_equal(pthread_create(&id[i], NULL, run_job, &job[i]), 0);
    }
    for (int i = 0; i < JOBS; i++) {
        pthread_join(id[i], NULL);
        assert_int_equal(job[i].status, GLAREPP_OK);
        assert_memory_equal(job[i].out, job[0].out, sizeof job[0].out);
    }
    close_world(&w[0]);
    close_world(&w[1]);
}

// -- errors -------------------------------------------------------------------

/* A cancelled call leaves the output as it was, and the plan usable. */
static void cancel(void **state)
{
    static const char *const steps[] = {"sensors", "kernel", "glare", "compose"};
    static float in[3 * PIXELS], out[3 * PIXELS];
    struct world w;
    open_world(&w, 0);
    draw(in, 50);
    const struct glarepp_image a = view_of(in), b = view_of(out);
    for (size_t i = 0; i < COUNT(steps); i++) {
        w.stop = steps[i];
        assert_int_equal(glarepp_execute(w.plan, &a, &b, NULL),
                         GLAREPP_ERR_CANCELLED);
        for (int k = 0; k < 3 * PIXELS; k++)
            assert_true(out[k] == 0.0f);
    }
    w.stop = NULL;
    assert_int_equal(glarepp_execute(w.plan, &a, &b, NULL), GLAREPP_OK);
    assert_true(out[0] > 0.0f);
    close_world(&w);
}

/* Errors are a code, a parameter and a sentence that names no option. */
static void errors_name_parameters(void **state)
{
    static float rgb[3 * PIXELS];
    struct world w;
    open_world(&w, 0);
    struct glarepp_image v = view_of(rgb);
    v.plane[1] = NULL;
    assert_int_equal(glarepp_execute(w.plan, &v, &v, NULL), GLAREPP_ERR_USAGE);
    assert_string_equal(w.parameter, "image.plane");
    assert_string_equal(glarepp_error()->text, w.text);
    assert_int_equal(glarepp_error()->status, GLAREPP_ERR_USAGE);
    v = view_of(rgb);
    v.data.x1 = 0;
    assert_int_equal(glarepp_execute(w.plan, &v, &v, NULL), GLAREPP_ERR_USAGE);
    assert_string_equal(w.parameter, "image.data");
    v = view_of(rgb);
    struct glarepp_image other = v;
    other.data.x1--;
    draw(rgb, 5);
    assert_int_equal(glarepp_execute(w.plan, &v, &other, NULL),
                     GLAREPP_ERR_USAGE);
    assert_string_equal(w.parameter, "image.data");
    const char *const word[] = {"nothing:share=2"};
    struct glarepp_kernel_params k = GLAREPP_KERNEL_PARAMS;
    struct glarepp_kernel *kernel;
    k.word = word;
    k.words = 1;
    assert_int_not_equal(glarepp_kernel(w.gp, &k, &kernel), GLAREPP_OK);
    assert_null(kernel);
    assert_null(strstr(w.text, "--"));
    struct glarepp_plan_params p = GLAREPP_PLAN_PARAMS;
    struct glarepp_layer_params layer = GLAREPP_LAYER_PARAMS;
    struct glarepp_plan *plan;
    layer.engine = "magic";
    p.layer = &layer;
    assert_int_equal(glarepp_plan(w.gp, &p, &plan), GLAREPP_ERR_USAGE);
    assert_null(plan);
    assert_string_equal(w.parameter, "layer.engine");
    close_world(&w);
}

/* A caller of an older header has smaller structs; one of a newer, none that
 * this version knows. */
static void sizes(void **state)
{
    struct world w;
    open_world(&w, 0);
    struct glarepp_sense_params sense = GLAREPP_SENSE_PARAMS;
    struct glarepp_plan_params p = GLAREPP_PLAN_PARAMS;
    struct glarepp_plan *plan;
    p.sense = &sense;
    sense.size = offsetof(struct glarepp_sense_params, knee);
    sense.knee = 77.0f; // not the older caller's
    assert_int_equal(glarepp_plan(w.gp, &p, &plan), GLAREPP_OK);
    glarepp_plan_end(&plan);
    sense.size = sizeof sense + 8;
    assert_int_equal(glarepp_plan(w.gp, &p, &plan), GLAREPP_ERR_USAGE);
    assert_string_equal(w.parameter, "sense");
    p.size = 0;
    assert_int_equal(glarepp_plan(w.gp, &p, &plan), GLAREPP_ERR_USAGE);
    close_world(&w);
}

/* Ends do nothing for NULL, and set it. */
static void ends(void **state)
{
    struct glarepp *gp = NULL;
    struct glarepp_plan *plan = NULL;
    struct glarepp_frame *frame = NULL;
    struct glarepp_kernel *kernel = NULL;
    glarepp_close(&gp);
    glarepp_plan_end(&plan);
    glarepp_frame_end(&frame);
    glarepp_kernel_end(&kernel);
    assert_int_equal(glarepp_open(NULL, &gp), GLAREPP_OK);
    glarepp_close(&gp);
    assert_null(gp);
}

// -- lists --------------------------------------------------------------------

static void names(void **state)
{
    const char *text;
    int n = 0;
    bool found = false;
    for (const char *name; (name = glarepp_name(NULL, GLAREPP_ENGINES, n, &text));
         n++)
        found |= strcmp(name, "fft") == 0 && text && *text;
    assert_true(found && n >= 3);
    assert_null(glarepp_name(NULL, GLAREPP_ENGINES, n + 5, NULL));
    struct glarepp_key key;
    for (int i = 0; glarepp_name(NULL, GLAREPP_MODELS, i, &text); i++) {
        assert_true(glarepp_key(i, 0, &key));
        assert_string_equal(key.name, "share");
        assert_false(glarepp_key(i, 1000, &key));
    }
    assert_false(glarepp_key(1000, 0, &key));
    assert_string_equal(glarepp_version(), GP_VERSION);
}

SUITE_OF(api, NULL, NULL, adds_glare, dark_frame_stays, views_agree,
         masks_add_up, in_place, threads_agree, cancel, errors_name_parameters,
         sizes, ends, names)
