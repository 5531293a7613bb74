/* One table of the room's parts and engines, and what must hold for each:
 *
 * - by any number of threads they make the same bytes;
 * - with a memory that is full at one allocation, or a GL with one answer that
 *   is an error, for each path of callers twice: one line, no block lost, and
 *   what is kept from frame to frame still gives the same bytes when all is
 *   well again. */
#include "unit.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bound/bound.h"
#include "glare/sources.h"
#include "glare/splat/splat_priv.h"
#include "glare/glare_priv.h"
#include "glare/model/model_priv.h"
#include "glare_scene.h"
#include "fail.h"

enum { W = 61, H = 43, SIZE = 25 };

/* A frame of light and what a part of the room makes of it. */
struct starved {
    const char *name;
    gp_status (*run)(void);
    const char *engine;
    enum light light;
    enum shape shape;
    struct gp_splat_params splat;
    float tolerance;
    int side, size; // of the frame and the kernel; 0: W x H, SIZE, times
                    // 3 for threads
    float rotate;   // the kernel is the eye's, turned; 0: of that shape
    bool faint;     // the kernel is far under what it is usually
};

static const struct starved *row; // under way
static struct scene scene;
static struct gp_kernel other;    // takes the place of what is kept
static struct gp_glare glare;
static uint64_t hash;             // of what was made
static int size;                  // of kernels

/* -- the engines ----------------------------------------------------------- */

static gp_status run_with(const struct gp_kernel *k)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    p.engine = row->engine;
    p.splat = row->splat;
    p.tolerance = row->tolerance;
    gp_planes_free(&scene.f.layer);
    const gp_status st = gp_glare_run(&kept_log, &p, &glare, &scene.src, k,
                                      &scene.f, &stats);
    hash = st ? 0 : scene_hash(&scene);
    return st;
}

/* With all that a sequence keeps made anew, but the context. */
static gp_status run_engine(void)
{
    return run_with(&scene.k);
}

/* Another kernel takes the place of the one that an engine keeps. */
static void forget(void)
{
    fail_end();
    if (run_with(&other) != GP_OK)
        fail_msg("%s: %s", row->name, kept_line);
    gp_planes_free(&scene.f.layer);
}

static gp_status run_bound(void)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats = {0};
    struct gp_planes none = {0};
    void *state = NULL;
    double least = 0.0;
    p.splat = row->splat;
    p.tolerance = row->tolerance;
    const struct gp_glare_request req = {
        .log = &kept_log, .params = &p, .src = &scene.src, .kernel = &scene.k,
        .layer = &none, .stats = &stats,
    };
    for (int i = 0; gp_engines[i]; i++) {
        if (strcmp(gp_engines[i]->name, row->engine) != 0)
            continue;
        const gp_status st = gp_engines[i]->bound(&req, &state, &least);
        gp_engines[i]->close(&state);
        hash = hash_more(HASH_NONE, &least, sizeof least);
        return st;
    }
    return GP_ERR_USAGE;
}

/* -- the parts ------------------------------------------------------------- */

static gp_status hash_planes(gp_status st, struct gp_planes *p, size_t n)
{
    hash = 0;
    for (int c = 0; !st && c < 3; c++)
        hash = hash * 31 + hash_more(HASH_NONE, p->c[c], n * sizeof(float));
    gp_planes_free(p);
    return st;
}

static gp_status hash_sources(gp_status st, struct gp_sources *s)
{
    hash = hash_more(HASH_NONE, s->flux, sizeof s->flux);
    hash = hash_more(hash, s->energy, sizeof s->energy);
    hash = hash_more(hash, &s->darkest, sizeof s->darkest);
    for (int c = 0; !st && c < 3; c++)
        hash = hash_more(hash, s->rgb[c], s->n * sizeof(float));
    hash = st ? 0 : hash_more(hash, s->x, s->n * sizeof *s->x);
    gp_sources_free(s);
    return st;
}

static gp_status run_sense(void)
{
    const struct gp_sensor_params p = WHOLE(0.5f, 0.5f, 1e9f);
    struct gp_sources s = {0};
    return hash_sources(gp_sense(&kept_log, &p, &scene.f, &s), &s);
}

static gp_status run_planes(void)
{
    struct gp_planes p = {0};
    const gp_status st = gp_sources_planes(&kept_log, &scene.src, &p);
    return hash_planes(st, &p, gp_frame_pixels(&scene.f));
}

static gp_status run_compose(void)
{
    const struct gp_compose_params p = GP_COMPOSE_DEFAULTS;
    gp_planes_free(&scene.f.layer);
    gp_planes_free(&scene.f.lit);
    const gp_status st = gp_compose(&kept_log, &p, &scene.src, &scene.f);
    return hash_planes(st, &scene.f.lit, gp_frame_pixels(&scene.f));
}

/* In the layer's memory, which stays where a row is missing. */
static gp_status run_compose_last(void)
{
    const struct gp_compose_params p = {1.0f, GP_MIX_SCATTER, 0.0f, true};
    const size_t n = gp_frame_pixels(&scene.f);
    gp_planes_free(&scene.f.layer);
    gp_planes_free(&scene.f.lit);
    gp_status st = gp_planes_make(&kept_log, "layer", n, &scene.f.layer);
    if (st)
        return st;
    gp_planes_clear(&scene.f.layer, 0, n);
    st = gp_compose(&kept_log, &p, &scene.src, &scene.f);
    assert_true((scene.f.layer.c[0] != NULL) == (st != GP_OK));
    gp_planes_free(&scene.f.layer);
    return hash_planes(st, &scene.f.lit, n);
}

static gp_status run_extra(void)
{
    struct gp_source extra[] = {{5, 6, {1, 2, 3}}, {2, 3, {4, 5, 6}},
                               {5, 6, {7, 8, 9}}};
    struct gp_sources s = {0};
    return hash_sources(
        gp_sources_join(&kept_log, &scene.src, extra, 3, &s), &s);
}

static gp_status run_reference(void)
{
    const size_t n = 3 * gp_frame_pixels(&scene.f);
    double *const layer = scene_alloc(n, sizeof *layer);
    memset(layer, 0xff, n * sizeof *layer); // every sample must be written
    const gp_status st = gp_glare_reference(&kept_log, NULL, &scene.src, &scene.k,
                                            layer);
    hash = st ? 0 : hash_more(HASH_NONE, layer, n * sizeof *layer);
    free(layer);
    return st;
}

static gp_status run_outline(void)
{
    struct gp_planes p = {0};
    const size_t n = gp_frame_pixels(&scene.f);
    if (gp_planes_make(&kept_log, "picture", n, &p))
        return GP_ERR_BUG;
    for (int c = 0; c < 3; c++)
        memset(p.c[c], 0, n * sizeof(float));
    return hash_planes(gp_polygons_outline(&kept_log, &scene.src, &scene.k,
                                           &row->splat, &p), &p, n);
}

/* -- kernels --------------------------------------------------------------- */

static gp_status hash_kernel(gp_status st, struct gp_kernel *k)
{
    hash = st ? 0 : hash_layer(&k->k, (size_t) k->w * (size_t) k->h);
    if (!st)
        gp_kernel_free(k);
    return st;
}

static gp_status make_model(const char *text, double rotate)
{
    const struct gp_field field = scene_model_field(size, rotate);
    struct gp_recipe r;
    struct gp_kernel k = {0};
    gp_status st = gp_recipe_parse(&kept_log, text, &r);
    if (st)
        return st;
    st = gp_model_kernel(&kept_log, &r, 1, &field, &k);
    gp_recipe_free(&r);
    return hash_kernel(st, &k);
}

static gp_status run_models(void)
{
    static const double angles[] = {0.0, 90.0, 30.0};
    uint64_t all = HASH_NONE;
    for (int m = 0; gp_models[m]; m++) {
        if (gp_models[m] == &gp_model_aperture ||
            gp_models[m] == &gp_model_temporal ||
            gp_models[m] == &gp_model_image) // an image is no formula
            continue;
        for (int i = 0; i < 3; i++) {
            const gp_status st =
                make_model(gp_model_name(gp_models[m]), angles[i]);
            if (st)
                return st;
            all = hash_more(all, &hash, sizeof hash);
        }
    }
    hash = all;
    return GP_OK;
}

static gp_status run_aperture(void)
{
    return make_model("aperture:wavelengths=2,coma=0.1,lashes=0.1", 0.0);
}

static gp_status run_temporal(void)
{
    return make_model("temporal:wavelengths=2", 0.0);
}

static gp_status run_from_frame(void)
{
    struct gp_kernel_params p = {0};
    struct gp_frame image =
        gp_frame_blank((struct gp_rect) {0, 0, size, 2 * size});
    struct gp_kernel k = {0};
    if (gp_planes_make(&kept_log, "kernel", gp_frame_pixels(&image),
                       &image.rgb))
        return GP_ERR_BUG;
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 2 * size * size; i++)
            image.rgb.c[c][i] = i < size ? 0.0f : (float) (i + c); // a border
    }
    p.rotate = 12.0f;
    const gp_status st = gp_kernel_from_frame(&kept_log, &p, &image, &k);
    gp_planes_free(&image.rgb);
    return hash_kernel(st, &k);
}

/* -- every n --------------------------------------------------------------- */

#define EXACT GP_SPLAT_EXACT
#define GROUPS(form, few)                                                     \
    { .group = 2, .cluster = 4, .cluster_fill = few, .shrink = 1e-2f,         \
      .primitive = form }

static const struct starved rows[] = {
    {"sensors", run_sense, NULL, FEW, PEAK, .splat = EXACT},
    {"sensors, all", run_sense, NULL, ALL, PEAK, .splat = EXACT},
    {"planes of sources", run_planes, NULL, FEW, PEAK, .splat = EXACT},
    {"compose", run_compose, NULL, FEW, PEAK, .splat = EXACT},
    {"compose, last", run_compose_last, NULL, FEW, PEAK, .splat = EXACT},
    {"extra light", run_extra, NULL, FEW, PEAK, .splat = EXACT},
    {"reference", run_reference, NULL, ALL, TINTED, .splat = EXACT,
     .side = 200, .size = 401},
    {"outline", run_outline, NULL, ALL, PEAK,
     .splat = GROUPS(GP_PRIMITIVE_AUTO, 0.5f)},
    {"models", run_models, NULL, CORNERS, PEAK, .splat = EXACT},
    {"model of an aperture", run_aperture, NULL, CORNERS, PEAK,
     .splat = EXACT},
    {"model of a pupil", run_temporal, NULL, CORNERS, PEAK, .splat = EXACT},
    {"a kernel's frame", run_from_frame, NULL, CORNERS, PEAK, .splat = EXACT},
    {"direct, few", run_engine, "direct", FEW, TINTED, .splat = EXACT},
    {"direct, quads", run_engine, "direct", BLOCK, PEAK, .splat = EXACT},
    {"direct, lobes", run_engine, "direct", FEW, LOBES, .splat = EXACT},
    {"fft", run_engine, "fft", ALL, TINTED, .splat = EXACT},
    {"fft, grey", run_engine, "fft", ALL, PEAK, .splat = EXACT},
    {"fft, hot", run_engine, "fft", HOT, PEAK, .splat = EXACT},
    {"bound of fft", run_bound, "fft", FEW, PEAK, .splat = EXACT},
    {"bound of fft, all", run_bound, "fft", ALL, TINTED, .splat = EXACT},
    {"auto", run_engine, "auto", FEW, PEAK, .splat = GP_SPLAT_DEFAULTS,
     .tolerance = 1e-3f},
    {"auto, no tolerance", run_engine, "auto", ALL, PEAK,
     .splat = GP_SPLAT_DEFAULTS, .tolerance = 0.0f},
    {"tiles", run_engine, "splat", FEW, PEAK,
     .splat = GROUPS(GP_PRIMITIVE_TILE, 0.5f), .side = 20,
     .size = 19},
    {"tiles, tinted", run_engine, "splat", ALL, TINTED,
     .splat = GROUPS(GP_PRIMITIVE_TILE, 0.5f), .side = 20,
     .size = 19},
    {"quads, tinted", run_engine, "splat", ALL, TINTED,
     .splat = GROUPS(GP_PRIMITIVE_QUAD, 0.5f), .side = 20, .size = 19},
    {"quads", run_engine, "splat", FEW, PEAK,
     .splat = GROUPS(GP_PRIMITIVE_QUAD, 0.5f), .side = 20,
     .size = 19},
    {"turned quads", run_engine, "splat", FEW, PEAK,
     .splat = {.group = 1, .cluster_fill = 0.9f,
               .primitive = GP_PRIMITIVE_QUAD},
     .side = 20, .size = 19, .rotate = 30.0f},
    {"fft, faint kernel", run_engine, "fft", ALL, TINTED, .splat = EXACT,
     .faint = true},
    {"direct, faint turned kernel", run_engine, "direct", FEW, PEAK,
     .splat = EXACT, .rotate = 30.0f, .faint = true},
};

static bool is_drawn(const struct starved *r)
{
    return r->engine && strcmp(r->engine, "splat") == 0 &&
           r->run == run_engine;
}

/* A fault at calls of a class. */
struct fault {
    const char *name, *text;
    gp_status status;
    enum fail_class class;
};
static const struct fault faults[] = {
    {"allocations", "out of memory", GP_ERR_BUG, FAIL_ALLOC},
    {"answers of GL", "GL_OUT_OF_MEMORY", GP_ERR_GL, FAIL_GL},
};

/* Makes a call fail by a path that none has failed by; false when there is no
 * more. */
static bool fail_once(const struct fault *f, int n, uint64_t want)
{
    const bool engine = row->run == run_engine;
    if (engine)
        forget();
    kept_clear();
    const long blocks = fail_blocks();
    fail_next(f->class);
    const gp_status st = row->run();
    const bool fired = fail_end();
    if (!fired) {
        assert_ok(st);
        assert_true(hash == want);
        return false;
    }
    if (st != f->status || kept_errors != 1 || !strstr(kept_line, f->text))
        fail_msg("%s, %d: status %d, %d lines, \"%s\"", row->name, n,
                 (int) st, kept_errors, kept_line);
    if (!engine) {
        assert_int_equal(fail_blocks(), blocks);
        return true;
    }
    if (row->run() != GP_OK || hash != want)
        fail_msg("%s, %d: not the same bytes when all is well", row->name, n);
    return true;
}

static void fail_each(const struct fault *f, uint64_t want)
{
    int n = 0;
    fail_forget();
    while (fail_once(f, n + 1, want))
        n++;
    print_message("%s: %d %s\n", row->name, n, f->name);
    assert_true(n > 0);
}

static struct gp_kernel kernel_of(const struct starved *r, int side)
{
    struct gp_kernel_params p = {0};
    struct gp_kernel k;
    if (r->rotate == 0.0f || r->faint) {
        k = scene_kernel(side, side, MID, 0, r->shape);
        return r->faint ? scene_kernel_times(k, 0x1p-90, r->rotate) : k;
    }
    // a turned image has its unturned form with it
    struct gp_frame image = gp_frame_blank((struct gp_rect) {0, 0, side, side});
    struct gp_kernel eye = scene_model("eye", side, 0.0);
    image.rgb = eye.k;
    p.rotate = r->rotate;
    if (gp_kernel_from_frame(NULL, &p, &image, &k))
        abort();
    gp_kernel_free(&eye);
    return k;
}

static void begin_row(const struct starved *r, int times)
{
    const int w = r->side ? r->side : times * W;
    const int h = r->side ? r->side : times * H;
    row = r;
    size = r->size ? r->size : times * SIZE;
    scene = scene_sense(scene_frame(w, h, -7, 11, r->light, 6u),
                        kernel_of(r, size), &usual);
    other = kernel_of(r, size + 8);
}

static void close_glare(void)
{
    gp_glare_close(&glare);
    glare = (struct gp_glare) {0};
}

static void end_row(void)
{
    scene_free(&scene);
    gp_kernel_free(&other);
}

static void faults_leave_nothing(void **state)
{
    gp_set_threads(2);
    for (size_t i = 0; i < COUNT(rows); i++) {
        begin_row(&rows[i], 1);
        const long blocks = fail_blocks();
        kept_clear();
        fail_end();
        const gp_status st = row->run();
        if (st == GP_ERR_GL && is_drawn(row)) {
            print_message("%s: no context: %s\n", row->name, kept_line);
        } else {
            assert_ok(st);
            const uint64_t want = hash;
            for (int k = 0; k < 1 + is_drawn(row); k++)
                fail_each(&faults[k], want);
        }
        close_glare();
        gp_planes_free(&scene.f.layer);
        assert_int_equal(fail_blocks(), blocks); // none is lost
        end_row();
    }
    gp_set_threads(0);
}

/* Threads share rows in blocks; nothing may depend on who took which. */
static void threads_change_no_byte(void **state)
{
    static const int threads[] = {1, 2, 4, 7};
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint64_t first = 0;
        begin_row(&rows[i], 3);
        for (size_t t = 0; t < COUNT(threads); t++) {
            gp_set_threads(threads[t]);
            const gp_status st = row->run();
            if (st == GP_ERR_GL && is_drawn(row))
                break;
            assert_ok(st);
            first = t ? first : hash;
            if (hash != first)
                fail_msg("%s: other bytes with %d threads", row->name,
                         threads[t]);
            close_glare();
        }
        end_row();
    }
    gp_set_threads(0);
}

SUITE_OF(starved_glare, NULL, NULL,
    faults_leave_nothing, threads_change_no_byte)
