// SPDX-License-Identifier: Apache-2.0
/* gp_compose(): both mixes, empty layers, energy, threads. */
#include "unit.h"
#include "glare_scene.h"

/* Noise in [0, 1) and, once in `every` pixels, light of up to 1 + bright. */
static struct gp_image noise_frame(int w, int h, int every, float bright)
{
    struct gp_image f = scene_frame(w, h, -3, 5, BLACK, 1u);
    uint32_t seed = 1;
    for (int i = 0; i < 3 * w * h; i++) {
        const float u = scene_random(&seed);
        const bool lit = (i % (w * h) + 1) % every == 0;
        f.rgb.c[i / (w * h)][i % (w * h)] = lit ? 1.0f + bright * u : u;
    }
    return f;
}

/* Takes the frame: light over 1 is a source, its whole pixel; the layer is
 * noise. */
static struct scene noise_scene(struct gp_image f)
{
    const struct glarepp_sense_params p = WHOLE(1, 0, 1e10f);
    struct scene s = scene_sense(f, scene_kernel(1, 1, MID, 0, BOX), &p);
    const size_t n = gp_image_pixels(&f);
    uint32_t seed = 2;
    scene_clear_layer(&s);
    for (size_t i = 0; i < 3 * n; i++)
        s.f.layer.c[i / n][i % n] = scene_random(&seed);
    return s;
}

static double total(const struct gp_image *f, const struct gp_planes *p, int c)
{
    double sum = 0.0;
    for (size_t i = 0; i < gp_image_pixels(f); i++)
        sum += (double) p->c[c][i];
    return sum;
}

static void mixes_are_their_formulas(void **state)
{
    static const struct {
        enum glarepp_mix mix;
        float gain;
        int w, h, every;
    } rows[] = {
        {GLAREPP_ADD, 1.0f, 17, 9, 5}, {GLAREPP_ADD, 0.0f, 17, 9, 5},
        {GLAREPP_ADD, 3.5f, 1, 1, 1}, {GLAREPP_SCATTER, 1.0f, 17, 9, 5},
        {GLAREPP_SCATTER, 0.25f, 16, 16, 1}, {GLAREPP_SCATTER, 0.0f, 17, 9, 5},
        {GLAREPP_SCATTER, 1.0f, 1, 31, 3}, {GLAREPP_SCATTER, 0.5f, 31, 1, 3},
        {GLAREPP_SCATTER, 1.0f, 7, 7, 1000}, {GLAREPP_SCATTER, 2.5f, 17, 9, 5},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_compose_params p = {
            rows[i].gain, rows[i].mix, 0.0f, false,
        };
        struct scene s = noise_scene(
            noise_frame(rows[i].w, rows[i].h, rows[i].every, 1000.0f));
        assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
        for (int k = 0; k < rows[i].w * rows[i].h; k++) {
            const bool source = (k + 1) % rows[i].every == 0;
            for (int c = 0; c < 3; c++) {
                double in = (double) s.f.rgb.c[c][k];
                double want = in + (double) p.gain * (double) s.f.layer.c[c][k];
                if (source && p.mix == GLAREPP_SCATTER)
                    want -= fmin((double) p.gain, 1.0) * in;
                assert_true(fabs((double) s.f.lit.c[c][k] - want) <=
                            1e-6 * (fabs(in) + 1.0));
            }
        }
        scene_free(&s);
    }
}

/* Scatter moves light and makes none: sources in the middle, a 3x3 kernel. */
static void scatter_conserves_energy(void **state)
{
    static const float kernel[9] = {0.05f, 0.1f, 0.05f, 0.1f, 0.4f,
                                    0.1f,  0.05f, 0.1f, 0.05f};
    static const float gains[] = {0.1f, 0.5f, 1.0f};
    enum { W = 19, H = 11 };
    for (size_t g = 0; g < COUNT(gains); g++) {
        const struct gp_compose_params p = {
            gains[g], GLAREPP_SCATTER, 0.0f, false,
        };
        struct gp_image f = noise_frame(W, H, W + 1, 100.0f); // a diagonal
        for (int i = 0; i < 3 * W * H; i++) {
            const int x = i % W, y = i / W % H;
            if (x < 1 || x > W - 2 || y < 1 || y > H - 2)
                f.rgb.c[i / (W * H)][i % (W * H)] = 0.5f;
        }
        struct scene s = noise_scene(f);
        assert_true(s.src.n > 5);
        for (int c = 0; c < 3; c++) {
            memset(s.f.layer.c[c], 0, W * H * sizeof(float));
            for (int i = W; i < W * H - W; i++) {
                const float v = f.rgb.c[c][i];
                for (int k = 0; k < 9 && v >= 1.0f; k++)
                    s.f.layer.c[c][i + (k / 3 - 1) * W + k % 3 - 1] +=
                        v * kernel[k];
            }
        }
        assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
        for (int c = 0; c < 3; c++) {
            double in = total(&s.f, &s.f.rgb, c);
            assert_true(fabs(total(&s.f, &s.f.lit, c) / in - 1.0) < 1e-6);
        }
        scene_free(&s);
    }
}

/* The lit frame has the same bytes in the layer's own memory. */
static void a_last_layer_becomes_the_lit_frame(void **state)
{
    enum { W = 37, H = 23, BYTES = W * H * sizeof(float) };
    for (int i = 0; i < 8; i++) {
        struct gp_compose_params p = {
            0.75f, i & 1 ? GLAREPP_SCATTER : GLAREPP_ADD, i & 2 ? 0.25f : 0.0f,
            true,
        };
        const bool layer = !(i & 4);
        struct scene s = noise_scene(noise_frame(W, H, 3, 50.0f));
        struct scene apart = noise_scene(noise_frame(W, H, 3, 50.0f));
        if (!layer) {
            gp_planes_free(&s.f.layer);
            gp_planes_free(&apart.f.layer);
        }
        const float *const was = s.f.layer.c[0];
        assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
        p.last = false;
        assert_ok(gp_compose(NULL, &p, &apart.src, &apart.f));
        assert_null(s.f.layer.c[0]);
        assert_true((s.f.lit.c[0] == was) == layer);
        assert_true((apart.f.layer.c[0] != NULL) == layer);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(s.f.lit.c[c], apart.f.lit.c[c], BYTES);
        scene_free(&s);
        scene_free(&apart);
    }
}

/* A pupil takes its share of every sample, of whichever mix, layer or none. */
static void dim_takes_its_share(void **state)
{
    enum { N = 19 * 11 };
    for (int i = 0; i < 4; i++) {
        struct gp_compose_params p = {
            0.7f, i & 1 ? GLAREPP_SCATTER : GLAREPP_ADD, 0.0f, false,
        };
        struct scene s = noise_scene(noise_frame(19, 11, 6, 50.0f));
        float plain[3 * N];
        if (i & 2)
            gp_planes_free(&s.f.layer);
        assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
        for (int k = 0; k < 3 * N; k++)
            plain[k] = s.f.lit.c[k / N][k % N];
        p.dim = 0.25f;
        assert_ok(gp_compose(NULL, &p, &s.src, &s.f));
        for (int k = 0; k < 3 * N; k++)
            assert_true(s.f.lit.c[k / N][k % N] == 0.75f * plain[k]);
        scene_free(&s);
    }
}

/* The formula in plain double, over layers of any sign up to the largest float;
 * a tint alone keeps other channels' bits, an empty layer stays empty. */
static void tints_are_their_formula(void **state)
{
    static const struct gp_tint_params rows[] = {
        {{1.0f, 0.5f, 2.0f}, 1.0f},
        {{1.0f, 1.0f, 1.0f}, 0.0f},
        {{0.25f, 1.0f, 0.0f}, 3.0f},
        {{1e6f, 1.0f, 1.0f}, 10.0f},
    };
    enum { W = 37, H = 23, N = W * H };
    for (size_t r = 0; r < COUNT(rows); r++) {
        const struct gp_tint_params *const p = &rows[r];
        struct scene s = noise_scene(noise_frame(W, H, 3, 50.0f));
        const float *const weight = s.f.luminance;
        float was[3][N];
        for (int c = 0; c < 3; c++) {
            s.f.layer.c[c][5] = c ? FLT_MAX : 0.0f;
            s.f.layer.c[c][6] = c ? 1.0f : -1.0f;
            memcpy(was[c], s.f.layer.c[c], sizeof was[c]);
        }
        gp_layer_tint(p, false, &s.f);
        for (int i = 0; i < 3 * N; i++) {
            const int c = i / N, k = i % N;
            double y = 0.0;
            for (int j = 0; j < 3; j++)
                y += (double) weight[j] * (double) was[j][k];
            const double all =
                (double) p->tint[c] *
                (y + (double) p->saturation * ((double) was[c][k] - y));
            const double want = fmin(fmax(all, 0.0), (double) FLT_MAX);
            assert_true(fabs((double) s.f.layer.c[c][k] - want) <=
                        1e-6 * (want + fabs(y)));
            if (p->saturation == 1.0f && p->tint[c] == 1.0f &&
                was[c][k] >= 0.0f)
                assert_true(s.f.layer.c[c][k] == was[c][k]);
        }
        gp_planes_free(&s.f.layer);
        gp_layer_tint(p, false, &s.f);
        assert_null(s.f.layer.c[0]);
        scene_free(&s);
    }
}

SUITE_OF(compose, NULL, NULL, mixes_are_their_formulas,
         scatter_conserves_energy, a_last_layer_becomes_the_lit_frame,
         dim_takes_its_share, tints_are_their_formula)
