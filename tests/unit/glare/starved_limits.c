/* glare at its edges: FFTW that is missing or makes no plan, drivers with low
 * limits, kernels that reach nothing, jobs that take too long, and CPUs without
 * AVX2. */
#include "unit.h"
#include "core/memory.h"
#include "glare/fft/fft.h"
#include "glare/glare_priv.h"
#include "glare/model/model.h"
#include "glare/splat/splat_priv.h"
#include "gl/gl_priv.h"
#include "glare_scene.h"
#include "fail.h"

#include <dlfcn.h>
#include <unistd.h>

// -- FFTW --------------------------------------------------------------------

/* A model's kernel over the whole field: fft and splat need the library for the
 * tail, direct does not; diffraction needs it with any engine. Errors name what
 * does without. */
static void models_without_fftw(void)
{
    static const char *const names[] = {"fft", "splat", "auto", "direct"};
    struct gp_frame f = scene_frame(300, 200, 0, 0, FEW, 1u);
    const struct gp_field field = gp_field_of(&f, 5.0);
    struct gp_recipe eye, aperture;
    struct gp_kernel k;
    assert_ok(gp_recipe_parse(NULL, "eye", &eye));
    assert_ok(gp_recipe_parse(NULL, "aperture", &aperture));
    fail_always.library = "libfftw3f.so.3";
    assert_ok(gp_model_kernel(NULL, &eye, 1, &field, &k));
    assert_true(k.tail);
    const struct gp_sources like = {.w = 300, .h = 200};
    struct gp_sources src;
    const float light[3] = {1.0f, 2.0f, 3.0f};
    assert_ok(gp_sources_make(NULL, &like, 1, &src));
    gp_sources_add(&src, 150, 100, light);
    gp_sources_finish(&src);
    for (size_t i = 0; i < COUNT(names); i++) {
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare g = {0};
        struct gp_glare_stats stats;
        p.engine = names[i];
        kept_clear();
        const gp_status st =
            gp_glare_run(&kept_log, &p, &g, &src, &k, &f, &stats);
        gp_glare_close(&g);
        assert_int_equal(st, i < 3 ? GP_ERR_IO : GP_OK);
        if (st)
            assert_string_equal(kept_parameter, "layer.engine.fft");
        else
            assert_true(f.layer.c[0][0] > 0.0f);
    }
    gp_sources_free(&src);
    gp_kernel_free(&k);
    // in double precision; in single precision it is loaded here
    fail_always.library = "libfftw3.so.3";
    kept_clear();
    assert_int_equal(gp_model_kernel(&kept_log, &aperture, 1, &field, &k),
                     GP_ERR_IO);
    assert_string_equal(kept_parameter, "layer.in_double");
    gp_recipe_free(&eye);
    gp_recipe_free(&aperture);
    gp_frame_free(&f);
    fail_always.library = NULL;
}

/* Before any other test: what is loaded once stays. */
static void fftw_is_missing(void **state)
{
    static const struct { const char *library, *symbol; } rows[] = {
        {"libfftw3f.so.3", NULL}, {NULL, "fftwf_plan_dft_1d"},
        {NULL, "fftwf_execute_dft"}, {NULL, "fftwf_export_wisdom_to_filename"},
    };
    const struct gp_fftwf *lib;
    struct gp_fft_plan_pair pair = {0};
    for (size_t i = 0; i < COUNT(rows); i++) {
        fail_always.library = rows[i].library;
        fail_always.symbol = rows[i].symbol;
        kept_clear();
        assert_int_equal(gp_fft_plan_make(&kept_log, 64, GP_FFT_PLAN_ESTIMATE,
                                          NULL, &pair), GP_ERR_IO);
        assert_int_equal(kept_errors, 1);
        assert_null(pair.forward);
    }
    fail_always.symbol = NULL;
    models_without_fftw();
    const struct gp_fftwd *twice;
    fail_always.library = "libfftw3.so.3";
    assert_int_equal(gp_fftwd_open(&kept_log, &twice), GP_ERR_IO);
    kept_clear();
    assert_int_equal(gp_fft_plan_make_double(&kept_log, 64, &pair), GP_ERR_IO);
    assert_string_equal(kept_parameter, "layer.engine.fft");
    assert_null(pair.forward_double);
    fail_always.library = NULL;
    assert_ok(gp_fftwf_open(&kept_log, &lib));
    assert_ok(gp_fftwd_open(&kept_log, &twice));
}

static int plans;   // made since
static int refused; // this one is not
static fftwf_plan (*real_plan)(int, fftwf_complex *, fftwf_complex *, int,
                               unsigned);
static fftw_plan (*real_twice)(int, fftw_complex *, fftw_complex *, int,
                               unsigned);

static fftwf_plan plan(int n, fftwf_complex *a, fftwf_complex *b, int sign,
                       unsigned flags)
{
    return ++plans == refused ? NULL : real_plan(n, a, b, sign, flags);
}

static fftw_plan plan_twice(int n, fftw_complex *a, fftw_complex *b, int sign,
                            unsigned flags)
{
    return ++plans == refused ? NULL : real_twice(n, a, b, sign, flags);
}

static struct scene make_scene(enum light light, int w, int h, int size, int cx)
{
    return scene_sense(scene_frame(w, h, 0, 0, light, 4u),
                       scene_kernel(size, size, cx, size / 2, PEAK), &usual);
}

/* Every plan in turn, of the engine and of the reference. */
static void fftw_makes_no_plan(void **state)
{
    const struct gp_fftwf *lib;
    const struct gp_fftwd *twice;
    struct scene s = make_scene(ALL, 200, 200, 401, MID);
    double *const layer = scene_alloc(3 * 200 * 200, sizeof *layer);
    assert_ok(gp_fftwf_open(NULL, &lib));
    assert_ok(gp_fftwd_open(NULL, &twice));
    real_plan = lib->plan_dft_1d;
    real_twice = twice->plan_dft_1d;
    ((struct gp_fftwf *) lib)->plan_dft_1d = plan;
    ((struct gp_fftwd *) twice)->plan_dft_1d = plan_twice;
    for (int i = 0; i < 3; i++) { // in float; in double, where much is seen
        scene_gain = i == 1 ? 1e3f : 1.0f;
        for (refused = 1; refused <= 5; refused++) {
            struct gp_glare g = {0};
            struct gp_glare_stats stats;
            plans = 0;
            kept_clear();
            const gp_status st =
                i == 2 ? gp_glare_reference(&kept_log, NULL, &s.src, &s.k, layer)
                       : scene_run("fft", &s, &g, &stats);
            assert_true(st != GP_OK || i == 2 || stats.fft_double == i);
            assert_int_equal(st, plans >= refused ? GP_ERR_BUG : GP_OK);
            assert_true((st != GP_OK) ==
                        (strstr(kept_line, "no plan for length") != NULL));
            assert_true(refused > 1 || st != GP_OK);
            gp_glare_close(&g);
        }
    }
    ((struct gp_fftwf *) lib)->plan_dft_1d = real_plan;
    ((struct gp_fftwd *) twice)->plan_dft_1d = real_twice;
    refused = 0;
    free(layer);
    scene_free(&s);
}

/* Wisdom that cannot be kept is no error, and leaves no file. */
static void wisdom_is_not_kept(void **state)
{
    char folder[] = "/tmp/glarepp-wisdom-XXXXXX", longest[5000];
    struct gp_fft_plan_pair p = {0};
    assert_non_null(mkdtemp(folder));
    memset(longest, 'a', sizeof longest - 1);
    longest[sizeof longest - 1] = '\0';
    // a name too long, a folder in the file's place, a folder that is not
    const char *const names[] = {longest, folder, "/nonexistent/wisdom"};
    for (int i = 0; i < 3; i++) {
        assert_ok(
            gp_fft_plan_make(&kept_log, 16, GP_FFT_PLAN_MEASURE, names[i], &p));
        assert_true(p.forward && p.backward);
        gp_fft_plan_free(&p);
        gp_fft_plan_free(&p);
    }
    assert_int_equal(rmdir(folder), 0); // it is empty
    assert_true(gp_fft_cost(1, GP_FFT_PLAN_MEASURE) == 1.0);
}

// -- engines -----------------------------------------------------------------

/* Light that falls beside the frame leaves it black, at no cost. */
static void kernels_that_reach_nothing(void **state)
{
    struct scene s = make_scene(FEW, 20, 10, 5, 900);
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats = {0};
    struct gp_glare g = {0};
    for (int i = 0; gp_engines[i]; i++) {
        assert_ok(scene_run(gp_engines[i]->name, &s, &g, &stats));
        for (int k = 0; k < 3 * 200; k++)
            assert_true(s.f.layer.c[k % 3][k / 3] == 0.0f);
        const struct gp_glare_request req = {
            .log = &kept_log, .params = &p, .src = &s.src, .kernel = &s.k,
            .layer = &s.f.layer, .stats = &stats,
        };
        double bound = NAN;
        void *kept = NULL;
        if (gp_engines[i]->bound) {
            assert_ok(gp_engines[i]->bound(&req, &kept, &bound));
            assert_true(bound >= 0.0 && bound < 1e-3);
        }
        gp_engines[i]->close(&kept);
    }
    assert_int_equal(scene_run("none", &s, &g, &stats), GP_ERR_USAGE);
    assert_kept("no engine of this name");
    gp_glare_close(&g);
    scene_free(&s);
}

/* The same bytes by the form for any CPU. */
static void cpus_agree(void **state)
{
    static const enum light lights[] = {FEW, BLOCK, HOT, ALL};
    static const char *const names[] = {"direct", "fft"};
    for (int i = 0; i < 8; i++) {
        struct scene s = make_scene(lights[i / 2], 61, 43, 25, MID);
        uint64_t hash[2];
        for (int base = 0; base < 2; base++) {
            struct gp_glare g = {0};
            struct gp_glare_stats stats;
            if (base)
                set_env("GLAREPP_CPU", "base");
            assert_ok(scene_run(names[i % 2], &s, &g, &stats));
            set_env("GLAREPP_CPU", NULL);
            hash[base] = scene_hash(&s);
            gp_glare_close(&g);
        }
        if (i % 2 == 0) // FFTW is another on each CPU
            assert_true(hash[0] == hash[1]);
        scene_find_exact(&s);
        assert_true(scene_own_error(&s) < 1e-4);
        scene_free(&s);
    }
}

/* Said before the first source is drawn; memory ends the run there. */
static void patience_is_asked_for(void **state)
{
    struct scene s = make_scene(ALL, 1200, 1000, 1001, MID);
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    struct gp_glare g = {0};
    static char name[] = "lamp.exr";
    p.engine = "direct";
    assert_ok(gp_planes_make(NULL, "layer", gp_frame_pixels(&s.f), &s.f.layer));
    for (int named = 0; named < 2; named++) {
        s.f.path = named ? name : NULL;
        fail_at(FAIL_ALLOC, 1);
        assert_int_equal(gp_glare_run(&kept_log, &p, &g, &s.src, &s.k, &s.f,
                                      &stats), GP_ERR_BUG);
        fail_end();
        assert_non_null(strstr(kept_warning, "direct will take about"));
        assert_true(strncmp(kept_warning, named ? "lamp.exr: " : "frame: ",
                            named ? 10 : 7) == 0);
    }
    s.f.path = NULL;
    gp_glare_close(&g);
    scene_free(&s);
}

// -- a driver's limits -------------------------------------------------------

static gp_status draw_form(struct scene *s, struct gp_glare *g,
                           enum gp_primitive form)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    p.engine = "splat";
    p.splat = (struct gp_splat_params) {
        .group = 8, .cluster_fill = 0.9f, .primitive = form,
    };
    return gp_glare_run(&kept_log, &p, g, &s->src, &s->k, &s->f, &stats);
}

static void limits_are_named(void **state)
{
    struct scene s = make_scene(FEW, 40, 30, 25, MID);
    struct gp_glare g = {0};
    struct gp_splat *splat = NULL;
    kept_clear();
    if (draw_form(&s, &g, GP_PRIMITIVE_QUAD) == GP_ERR_GL) {
        scene_free(&s);
        skip_for("no GL");
    }
    for (int i = 0; gp_engines[i]; i++) {
        if (gp_engines[i] == &gp_engine_splat)
            splat = g.state[i];
    }
    assert_non_null(splat);
    const int size = splat->gl->info.max_size;
    splat->gl->info.max_size = 4; // less than a group
    assert_int_equal(draw_form(&s, &g, GP_PRIMITIVE_QUAD), GP_ERR_GL);
    assert_int_equal(kept_errors, 1);
    splat->gl->info.max_size = size;
    assert_ok(draw_form(&s, &g, GP_PRIMITIVE_QUAD));
    gp_glare_close(&g);
    scene_free(&s);
}

SUITE_OF(starved_limits, NULL, NULL, fftw_is_missing, fftw_makes_no_plan,
         wisdom_is_not_kept, kernels_that_reach_nothing, cpus_agree,
         patience_is_asked_for, limits_are_named)
