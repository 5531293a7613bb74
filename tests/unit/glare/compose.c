/* glare/compose.c: both mixes, empty layers, energy, threads. */
#include "unit.h"
#include "glare/compose.h"

struct scene {
    struct gp_frame f;
    struct gp_sources src;
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
    assert_ok(gp_planes_make(NULL, "test", n, &s->f.rgb));
    assert_ok(gp_planes_make(NULL, "test", n, &s->f.layer));
    const struct gp_sources like = {.w = w, .h = h};
    assert_ok(gp_sources_make(NULL, &like, n, &s->src));
    for (int i = 0; i < w * h; i++) {
        const bool source = (i + 1) % every == 0;
        float rgb[3];
        for (int c = 0; c < 3; c++) {
            rgb[c] = source ? 1.0f + bright * noise() : noise();
            s->f.rgb.c[c][i] = rgb[c];
            s->f.layer.c[c][i] = noise();
        }
        if (source)
            gp_sources_add(&s->src, i % w, i / w, rgb);
    }
    gp_sources_finish(&s->src);
}

static void free_scene(struct scene *s)
{
    gp_frame_free(&s->f);
    gp_sources_free(&s->src);
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
        {GP_MIX_ADD, 1.0f, 17, 9, 5}, {GP_MIX_ADD, 0.0f, 17, 9, 5},
        {GP_MIX_ADD, 3.5f, 1, 1, 1}, {GP_MIX_SCATTER, 1.0f, 17, 9, 5},
        {GP_MIX_SCATTER, 0.25f, 16, 16, 1}, {GP_MIX_SCATTER, 0.0f, 17, 9, 5},
        {GP_MIX_SCATTER, 1.0f, 1, 31, 3}, {GP_MIX_SCATTER, 0.5f, 31, 1, 3},
        {GP_MIX_SCATTER, 1.0f, 7, 7, 1000},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s;
        struct gp_compose_params p = {rows[i].gain, rows[i].mix, 0.0f};
        make_scene(&s, rows[i].w, rows[i].h, rows[i].every, 1000.0f);
        assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
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
        free_scene(&s);
    }
}

static void no_layer_means_no_light(void **state)
{
    for (int mix = 0; mix < 2; mix++) {
        struct scene s;
        struct gp_compose_params p = {1.0f, mix ? GP_MIX_SCATTER : GP_MIX_ADD, 0.0f};
        make_scene(&s, 13, 7, 4, 10.0f);
        gp_planes_free(&s.f.layer);
        s.f.rgb.c[0][3] = -0.0f;
        s.f.rgb.c[1][4] = -2.5f;
        assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
        for (int c = 0; c < 3; c++)
            assert_memory_equal(s.f.lit.c[c], s.f.rgb.c[c],
                                13 * 7 * sizeof(float));
        free_scene(&s);
    }
}

/* At gain 1 a source gives all of itself away. Next to 1e9, 1e-3 of glare
 * would vanish in in + layer - source. */
static void a_huge_source_leaves_nothing_behind(void **state)
{
    struct scene s;
    struct gp_compose_params p = {1.0f, GP_MIX_SCATTER, 0.0f};
    make_scene(&s, 5, 5, 13, 1.0f);
    for (int c = 0; c < 3; c++) {
        s.f.rgb.c[c][12] = s.src.rgb[c][0] = 1e9f;
        s.f.layer.c[c][12] = 1e-3f;
    }
    assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
    for (int c = 0; c < 3; c++)
        assert_true(s.f.lit.c[c][12] == 1e-3f);
    free_scene(&s);
}

/* Scatter moves light and makes none: sources in the middle, a 3x3 kernel. */
static void scatter_conserves_energy(void **state)
{
    static const float kernel[9] = {0.05f, 0.1f, 0.05f, 0.1f, 0.4f,
                                    0.1f,  0.05f, 0.1f, 0.05f};
    static const float gains[] = {0.1f, 0.5f, 1.0f};
    enum { W = 19, H = 11 };
    for (size_t g = 0; g < COUNT(gains); g++) {
        struct scene s;
        struct gp_compose_params p = {gains[g], GP_MIX_SCATTER, 0.0f};
        make_scene(&s, W, H, W + 1, 100.0f); // on a diagonal
        for (int c = 0; c < 3; c++)
            memset(s.f.layer.c[c], 0, W * H * sizeof(float));
        struct gp_sources inside;
        assert_ok(gp_sources_make(NULL, &s.src, s.src.n, &inside));
        for (int y = 1; y < H - 1; y++) {
            for (uint32_t i = s.src.row[y]; i < s.src.row[y + 1]; i++) {
                const int x = s.src.x[i];
                const float rgb[3] = {s.src.rgb[0][i], s.src.rgb[1][i],
                                      s.src.rgb[2][i]};
                if (x < 1 || x > W - 2)
                    continue; // its glare would leave the frame
                gp_sources_add(&inside, x, y, rgb);
                for (int k = 0; k < 27; k++)
                    s.f.layer.c[k / 9][(y + k % 9 / 3 - 1) * W + x + k % 3 -
                                       1] += rgb[k / 9] * kernel[k % 9];
            }
        }
        gp_sources_finish(&inside);
        gp_sources_free(&s.src);
        s.src = inside;
        assert_true(inside.n > 5);
        assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
        for (int c = 0; c < 3; c++) {
            double in = total(&s.f, &s.f.rgb, c);
            assert_true(fabs(total(&s.f, &s.f.lit, c) / in - 1.0) < 1e-6);
        }
        free_scene(&s);
    }
}

static void planes_are_made_once(void **state)
{
    struct scene s;
    struct gp_compose_params p = GP_COMPOSE_DEFAULTS;
    make_scene(&s, 8, 8, 9, 4.0f);
    assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
    float *lit = s.f.lit.c[0], first = lit[5];
    lit[5] = NAN;
    assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
    assert_ptr_equal(s.f.lit.c[0], lit);
    assert_true(lit[5] == first);
    free_scene(&s);
}

static void sources_of_another_frame_are_refused(void **state)
{
    struct scene s;
    struct gp_compose_params p = {1.0f, GP_MIX_SCATTER, 0.0f};
    make_scene(&s, 8, 8, 9, 4.0f);
    s.src.h = 9;
    assert_int_equal(gp_compose(NULL, &p, &s.src, &s.f), GP_ERR_BUG);
    assert_null(s.f.lit.c[0]);
    free_scene(&s);
}

/* A pupil takes its share of every sample, of whichever mix, layer or none. */
static void dim_takes_its_share(void **state)
{
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
        assert_ok(gp_compose(NULL, &p, &plain.src, &plain.f));
        p.dim = 0.25f;
        assert_ok(gp_compose(NULL, &p, &dim.src, &dim.f));
        for (int c = 0; c < 3; c++) {
            for (int k = 0; k < 19 * 11; k++)
                assert_true(dim.f.lit.c[c][k] == 0.75f * plain.f.lit.c[c][k]);
        }
        free_scene(&plain);
        free_scene(&dim);
    }
}

SUITE_OF(compose, NULL, NULL,
    mixes_are_their_formulas, no_layer_means_no_light,
    a_huge_source_leaves_nothing_behind, scatter_conserves_energy,
    planes_are_made_once, sources_of_another_frame_are_refused,
    dim_takes_its_share)
