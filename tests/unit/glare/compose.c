/* glare/compose.c: both mixes, empty layers, energy, threads. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/compose.h"

enum { MAX_SOURCES = 256 };

struct scene {
    struct gp_frame f;
    struct gp_sources src;
    uint32_t row[64];
    int32_t x[MAX_SOURCES];
    float rgb[3][MAX_SOURCES];
};

static unsigned seed = 1;

static float noise(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float) (seed >> 8) / 16777216.0f;
}

/* A frame of noise in [0,1) and, once in `every` pixels, a source of up to
 * `bright`, which is the whole pixel. */
static void make_scene(struct scene *s, int w, int h, int every, float bright)
{
    *s = (struct scene) {.f = {.data = {-3, 5, w - 3, h + 5}}};
    const size_t n = gp_frame_pixels(&s->f);
    s->f.path = strdup("test");
    assert_int_equal(gp_planes_make(NULL, "test", n, &s->f.rgb), GP_OK);
    assert_int_equal(gp_planes_make(NULL, "test", n, &s->f.layer), GP_OK);
    s->src = (struct gp_sources) {
        .w = w, .h = h, .row = s->row, .x = s->x,
        .rgb = {s->rgb[0], s->rgb[1], s->rgb[2]},
    };
    for (int i = 0; i < w * h; i++) {
        if (i % w == 0)
            s->row[i / w] = (uint32_t) s->src.n;
        const bool source = (i + 1) % every == 0 && s->src.n < MAX_SOURCES;
        for (int c = 0; c < 3; c++) {
            s->f.rgb.c[c][i] = source ? 1.0f + bright * noise() : noise();
            s->f.layer.c[c][i] = noise();
            if (source)
                s->rgb[c][s->src.n] = s->f.rgb.c[c][i];
        }
        if (source)
            s->x[s->src.n++] = i % w;
    }
    s->row[h] = (uint32_t) s->src.n;
}

static double total(const struct gp_frame *f, const struct gp_planes *p, int c)
{
    double sum = 0.0;
    for (size_t i = 0; i < gp_frame_pixels(f); i++)
        sum += (double) p->c[c][i];
    return sum;
}

static void mixes_are_their_formulas(void **state)
{
    static const struct {
        enum gp_mix mix;
        float gain;
        int w, h, every;
    } rows[] = {
        {GP_MIX_ADD, 1.0f, 17, 9, 5},      {GP_MIX_ADD, 0.0f, 17, 9, 5},
        {GP_MIX_ADD, 3.5f, 1, 1, 1},       {GP_MIX_SCATTER, 1.0f, 17, 9, 5},
        {GP_MIX_SCATTER, 0.25f, 16, 16, 1}, {GP_MIX_SCATTER, 0.0f, 17, 9, 5},
        {GP_MIX_SCATTER, 1.0f, 1, 31, 3},  {GP_MIX_SCATTER, 0.5f, 31, 1, 3},
        {GP_MIX_SCATTER, 1.0f, 7, 7, 1000},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s;
        struct gp_compose_params p = {rows[i].gain, rows[i].mix, 0.0f};
        make_scene(&s, rows[i].w, rows[i].h, rows[i].every, 1000.0f);
        assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_OK);
        for (int k = 0; k < rows[i].w * rows[i].h; k++) {
            const bool source = (k + 1) % rows[i].every == 0;
            for (int c = 0; c < 3; c++) {
                double in = (double) s.f.rgb.c[c][k];
                double want = in + (double) p.gain * (double) s.f.layer.c[c][k];
                if (source && p.mix == GP_MIX_SCATTER)
                    want -= (double) p.gain * in;
                assert_true(fabs((double) s.f.lit.c[c][k] - want) <=
                            1e-6 * (fabs(in) + 1.0));
            }
        }
        gp_frame_free(&s.f);
    }
}

static void no_layer_means_no_light(void **state)
{
    (void) state;
    for (int mix = 0; mix < 2; mix++) {
        struct scene s;
        struct gp_compose_params p = {1.0f, mix ? GP_MIX_SCATTER : GP_MIX_ADD, 0.0f};
        make_scene(&s, 13, 7, 4, 10.0f);
        gp_planes_free(&s.f.layer);
        s.f.rgb.c[0][3] = -0.0f;
        s.f.rgb.c[1][4] = -2.5f;
        assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_OK);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(s.f.lit.c[c], s.f.rgb.c[c],
                                13 * 7 * sizeof(float));
        gp_frame_free(&s.f);
    }
}

/* At gain 1 a source gives all of itself away. Next to 1e9, 1e-3 of glare
 * would vanish in in + layer - source. */
static void a_huge_source_leaves_nothing_behind(void **state)
{
    struct scene s;
    struct gp_compose_params p = {1.0f, GP_MIX_SCATTER, 0.0f};
    (void) state;
    make_scene(&s, 5, 5, 13, 1.0f);
    for (int c = 0; c < 3; c++) {
        s.f.rgb.c[c][12] = s.rgb[c][0] = 1e9f;
        s.f.layer.c[c][12] = 1e-3f;
    }
    assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_OK);
    for (int c = 0; c < 3; c++)
        assert_true(s.f.lit.c[c][12] == 1e-3f);
    gp_frame_free(&s.f);
}

/* Scatter moves light and makes none: sources in the middle, a 3x3 kernel. */
static void scatter_conserves_energy(void **state)
{
    static const float kernel[9] = {0.05f, 0.1f, 0.05f, 0.1f, 0.4f,
                                    0.1f,  0.05f, 0.1f, 0.05f};
    static const float gains[] = {0.1f, 0.5f, 1.0f};
    enum { W = 19, H = 11 };
    (void) state;
    for (size_t g = 0; g < COUNT(gains); g++) {
        struct scene s;
        struct gp_compose_params p = {gains[g], GP_MIX_SCATTER, 0.0f};
        make_scene(&s, W, H, W + 1, 100.0f); // on a diagonal
        for (int c = 0; c < 3; c++)
            memset(s.f.layer.c[c], 0, W * H * sizeof(float));
        size_t kept = 0;
        for (int y = 0; y < H; y++) {
            uint32_t from = s.row[y], to = s.row[y + 1];
            s.row[y] = (uint32_t) kept;
            for (uint32_t i = from; i < to; i++) {
                int x = s.x[i];
                if (x < 1 || y < 1 || x > W - 2 || y > H - 2)
                    continue; // its glare would leave the frame
                s.x[kept] = x;
                for (int c = 0; c < 3; c++) {
                    float v = s.rgb[c][kept] = s.rgb[c][i];
                    for (int k = 0; k < 9; k++)
                        s.f.layer.c[c][(y + k / 3 - 1) * W + x + k % 3 - 1] +=
                            v * kernel[k];
                }
                kept++;
            }
        }
        s.row[H] = (uint32_t) kept;
        s.src.n = kept;
        assert_true(kept > 5);
        assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_OK);
        for (int c = 0; c < 3; c++) {
            double in = total(&s.f, &s.f.rgb, c);
            assert_true(fabs(total(&s.f, &s.f.lit, c) / in - 1.0) < 1e-6);
        }
        gp_frame_free(&s.f);
    }
}

static void planes_are_made_once(void **state)
{
    struct scene s;
    struct gp_compose_params p = GP_COMPOSE_DEFAULTS;
    (void) state;
    make_scene(&s, 8, 8, 9, 4.0f);
    assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_OK);
    float *lit = s.f.lit.c[0], first = lit[5];
    lit[5] = NAN;
    assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_OK);
    assert_ptr_equal(s.f.lit.c[0], lit);
    assert_true(lit[5] == first);
    gp_frame_free(&s.f);
}

static void sources_of_another_frame_are_refused(void **state)
{
    struct scene s;
    struct gp_compose_params p = {1.0f, GP_MIX_SCATTER, 0.0f};
    (void) state;
    make_scene(&s, 8, 8, 9, 4.0f);
    s.src.h = 9;
    assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_ERR_BUG);
    assert_null(s.f.lit.c[0]);
    gp_frame_free(&s.f);
}

/* A pupil takes its share of every sample, of whichever mix, layer or none. */
static void dim_takes_its_share(void **state)
{
    (void) state;
    for (int i = 0; i < 4; i++) {
        struct scene plain, dim;
        struct gp_compose_params p = {
            0.7f, i & 1 ? GP_MIX_SCATTER : GP_MIX_ADD, 0.0f,
        };
        seed = 5;
        make_scene(&plain, 19, 11, 6, 50.0f);
        seed = 5;
        make_scene(&dim, 19, 11, 6, 50.0f);
        if (i & 2) {
            gp_planes_free(&plain.f.layer);
            gp_planes_free(&dim.f.layer);
        }
        assert_int_equal(gp_compose(NULL, &p, &plain.src, &plain.f), GP_OK);
        p.dim = 0.25f;
        assert_int_equal(gp_compose(NULL, &p, &dim.src, &dim.f), GP_OK);
        for (int c = 0; c < 3; c++) {
            for (int k = 0; k < 19 * 11; k++)
                assert_true(dim.f.lit.c[c][k] == 0.75f * plain.f.lit.c[c][k]);
        }
        gp_frame_free(&plain.f);
        gp_frame_free(&dim.f);
    }
}

static void threads_change_nothing(void **state)
{
    float first[37 * 23];
    (void) state;
    for (int threads = 1; threads <= 7; threads++) {
        struct scene s;
        struct gp_compose_params p = {0.7f, GP_MIX_SCATTER, 0.0f};
        seed = 9;
        gp_set_threads(threads);
        make_scene(&s, 37, 23, 6, 50.0f);
        assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_OK);
        if (threads == 1)
            memcpy(first, s.f.lit.c[1], sizeof first);
        assert_memory_equal(s.f.lit.c[1], first, sizeof first);
        gp_frame_free(&s.f);
    }
    gp_set_threads(0);
}

SUITE(compose)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mixes_are_their_formulas),
        cmocka_unit_test(no_layer_means_no_light),
        cmocka_unit_test(a_huge_source_leaves_nothing_behind),
        cmocka_unit_test(scatter_conserves_energy),
        cmocka_unit_test(planes_are_made_once),
        cmocka_unit_test(sources_of_another_frame_are_refused),
        cmocka_unit_test(dim_takes_its_share),
        cmocka_unit_test(threads_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
