/* glare/fft: what it keeps from frame to frame, and the rest that it adds. */
#include "unit.h"
#include "core/memory.h"
#include "glare/fft/fft.h"
#include "glare/fft/fft_priv.h"
#include "hard_cases.h"

/* Runs the transform alone, of a last frame or another; returns its hash. */
static uint64_t run_fft(struct scene *s, bool last, struct gp_glare *g)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    p.engine = "fft";
    p.gain = 0.0f;
    p.last = last;
    assert_ok(gp_glare_run(NULL, &p, g, &s->src, &s->k, &s->f, &stats));
    assert_true(stats.fft_w > 0 && stats.hot == 0);
    return scene_hash(s);
}

/* After the last frame no spectrum is kept, and its channels may be made one
 * after the other: the layer is the same. */
static void a_last_frame_is_as_any_other(void **state)
{
    static const enum shape shapes[] = {PEAK, TINTED, LOBES, RING};
    for (size_t i = 0; i < COUNT(shapes); i++) {
        for (int side = 30; side <= 31; side++) { // never even, and maybe
            struct gp_glare g = {0}, alone = {0};
            struct scene s = scene_make(
                scene_frame(97, 61, 0, 0, ALL, 3u),
                scene_kernel(side, side, MID, 0, shapes[i]),
                &(struct gp_sensor_params) WHOLE(1, 0, 1e3f));
            const uint64_t hash = run_fft(&s, false, &g);
            assert_true(run_fft(&s, true, &alone) == hash);
            assert_true(run_fft(&s, false, &alone) == hash);
            assert_true(run_fft(&s, true, &g) == hash); // one was kept
            gp_glare_close(&g);
            gp_glare_close(&alone);
            scene_free(&s);
        }
    }
}

/* A rest of 1 in each sample. */
struct ones {
    struct gp_planes *layer;
    int w, h;
    int *times; // that it was added to each row of each channel
};

static void add_one(void *ctx, int i, int thread)
{
    const struct ones *const m = ctx;
    float *const row = m->layer->c[i / m->h] + i % m->h * m->w;
    (void) thread;
    m->times[i]++;
    for (int x = 0; x < m->w; x++)
        row[x] += 1.0f;
}

/* Each row of each channel gets the rest once, over what the transform leaves
 * there: where light is all over the frame, and where rows are out of reach. */
static void each_row_gets_the_rest_once(void **state)
{
    static const enum light lights[] = {ALL, BLOCK, COLOURED};
    for (size_t i = 0; i < COUNT(lights); i++) {
        struct scene s = scene_make(scene_frame(97, 61, 0, 0, lights[i], 3u),
                                    scene_kernel(15, 15, MID, 0, TINTED),
                                    &usual);
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare_stats stats = {0};
        struct gp_glare_request req = {
            .params = &p, .src = &s.src, .kernel = &s.k,
            .layer = &s.f.layer, .stats = &stats,
        };
        const int n = 97 * 61;
        float *const alone = scene_alloc(3 * (size_t) n, sizeof *alone);
        int *const times = scene_alloc((size_t) (3 * 61), sizeof *times);
        struct ones ones = {&s.f.layer, 97, 61, times};
        struct gp_layer_rest rest = {.add = add_one, .ctx = &ones};
        void *kept = NULL;
        p.gain = 0.0f; // the transform alone
        assert_ok(gp_planes_make(NULL, "layer", (size_t) n, &s.f.layer));
        assert_ok(gp_engine_fft.run(&req, &kept));
        for (int j = 0; j < 3 * n; j++)
            alone[j] = s.f.layer.c[j / n][j % n];
        req.rest = &rest;
        assert_ok(gp_engine_fft.run(&req, &kept));
        assert_true(rest.added);
        for (int j = 0; j < 3 * 61; j++)
            assert_int_equal(times[j], 1);
        for (int j = 0; j < 3 * n; j++)
            assert_true(s.f.layer.c[j / n][j % n] == alone[j] + 1.0f);
        gp_engine_fft.close(&kept);
        free(alone);
        free(times);
        scene_free(&s);
    }
}

/* Facts found while a kernel is made equal those found in its samples: its
 * quarters, and the support of its rows. */
static void a_kernel_is_known_as_it_is(void **state)
{
    static const enum shape shapes[] = {PEAK, TINTED, LOBES, RING};
    for (size_t i = 0; i < COUNT(shapes); i++) {
        for (int j = 0; j < 4; j++) { // sides, and centres in it and beyond
            struct gp_kernel k = scene_kernel(30 + j % 2, 41 - j, j < 2 ? MID : 50,
                                              j < 2 ? 0 : -3, shapes[i]);
            struct gp_kernel bare = k;
            struct gp_fft_quarters known, found;
            assert_non_null(k.lit);
            bare.lit = NULL;
            for (int side = 20; side <= 60; side += 20) { // of the frame
                gp_fft_find_quarters(&k, side, side, &known);
                gp_fft_find_quarters(&bare, side, side, &found);
                assert_memory_equal(&known, &found, sizeof known);
            }
            for (int c = 0; c < 3; c++) {
                struct gp_fft_shape a, b;
                assert_ok(gp_fft_shape_make(NULL, &k, c, &a));
                assert_ok(gp_fft_shape_make(NULL, &bare, c, &b));
                assert_memory_equal(a.row, b.row,
                                    ((size_t) k.h + 1) * sizeof *a.row);
                assert_memory_equal(a.run, b.run,
                                    a.row[k.h] * sizeof *a.run);
                gp_fft_shape_free(&a);
                gp_fft_shape_free(&b);
            }
            gp_kernel_free(&k);
        }
    }
}

SUITE_OF(fft_kept, NULL, NULL,
    a_last_frame_is_as_any_other, a_kernel_is_known_as_it_is,
    each_row_gets_the_rest_once)
