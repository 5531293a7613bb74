/* The laws of a convolution, for all engines. GLAREPP_TEST_QUICK leaves out
 * GL. */
#include "unit.h"
#include "hard_cases.h"

static const struct gp_sensor_params usual = GP_SENSOR_DEFAULTS;

static struct scene law_scene(enum light light, uint32_t seed)
{
    return scene_make(scene_frame(97, 61, 0, 0, light, seed),
                      scene_kernel(31, 29, MID, 0, TINTED), &usual);
}

/* |a + b - sum| / |sum| over all samples; exact layers are not looked at. */
static double sum_error(const struct gp_planes *a, const struct gp_planes *b,
                        const struct gp_planes *sum, size_t n)
{
    double wrong = 0.0, all = 0.0;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++) {
            const double s = (double) sum->c[c][i];
            const double d = (double) a->c[c][i] + (double) b->c[c][i] - s;
            wrong += d * d;
            all += s * s;
        }
    }
    return sqrt(wrong / all);
}

/* layer(a) + layer(b) = layer(a + b) */
static void layers_add_up(void **state)
{
    struct scene a = law_scene(FEW, 1u), b = law_scene(ALL, 2u);
    struct gp_frame both = scene_frame(97, 61, 0, 0, DARK, 0u);
    const size_t n = gp_frame_pixels(&both);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            both.rgb.c[c][i] = b.f.rgb.c[c][i];
        for (int y = 0; y < 61; y++) {
            for (uint32_t i = a.src.row[y]; i < a.src.row[y + 1]; i++)
                both.rgb.c[c][y * 97 + a.src.x[i]] += a.src.rgb[c][i];
        }
    }
    struct scene s = scene_make(both, scene_kernel(31, 29, MID, 0, TINTED),
                                &(struct gp_sensor_params) {1.0f, 0.0f, 1e6f});
    assert_int_equal(s.src.n, n);
    for (int i = 0; gp_engines[i]; i++) {
        const char *const e = gp_engines[i]->name;
        struct gp_glare_stats stats;
        if (!ran_once(e, &a, &stats, "a") || !ran_once(e, &b, &stats, "b") ||
            !ran_once(e, &s, &stats, "a + b"))
            continue;
        const double error = sum_error(&a.f.layer, &b.f.layer, &s.f.layer, n);
        if (!(error <= 2.0 * usual_bar(e)))
            fail_msg("%s: layers do not add up (%g)", e, error);
    }
    scene_free(&a);
    scene_free(&b);
    scene_free(&s);
}

/* Four times the light is four times the layer, to the bit: no engine has a
 * scale of its own. */
static void layers_scale(void **state)
{
    struct scene a = law_scene(FEW, 3u);
    struct gp_frame f = scene_frame(97, 61, 0, 0, FEW, 3u);
    const size_t n = gp_frame_pixels(&f);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            f.rgb.c[c][i] *= 4.0f;
    }
    struct scene b = scene_make(f, scene_kernel(31, 29, MID, 0, TINTED),
                                &(struct gp_sensor_params) {4.0f, 0.0f, 1e6f});
    for (int i = 0; gp_engines[i]; i++) {
        const char *const e = gp_engines[i]->name;
        struct gp_glare_stats stats;
        if (!ran_once(e, &a, &stats, "a") || !ran_once(e, &b, &stats, "4 a"))
            continue;
        for (int c = 0; c < 3; c++) {
            for (size_t j = 0; j < n; j++) {
                if (b.f.layer.c[c][j] != 4.0f * a.f.layer.c[c][j])
                    fail_msg("%s: sample %zu does not scale", e, j);
            }
        }
    }
    scene_free(&a);
    scene_free(&b);
}

/* The frame's pixels moved by (dx, dy); what enters is background. */
static struct gp_frame moved(int dx, int dy)
{
    struct gp_frame f = scene_frame(97, 61, 0, 0, DARK, 4u);
    struct gp_frame from = scene_frame(97, 61, 0, 0, MIDDLE, 4u);
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < 61; y++) {
            for (int x = 0; x < 97; x++) {
                const int sx = x - dx, sy = y - dy;
                if (sx >= 0 && sx < 97 && sy >= 0 && sy < 61)
                    f.rgb.c[c][y * 97 + x] = from.rgb.c[c][sy * 97 + sx];
            }
        }
    }
    gp_frame_free(&from);
    return f;
}

/* |moved layer - layer| / |layer| over the pixels that both frames have. */
static double shift_error(const struct gp_planes *a, const struct gp_planes *b,
                          int dx, int dy)
{
    double wrong = 0.0, all = 0.0;
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < 61; y++) {
            for (int x = 0; x < 97; x++) {
                const int to_x = x + dx, to_y = y + dy;
                if (to_x < 0 || to_x >= 97 || to_y < 0 || to_y >= 61)
                    continue;
                const double v = (double) a->c[c][y * 97 + x];
                const double d = (double) b->c[c][to_y * 97 + to_x] - v;
                wrong += d * d;
                all += v * v;
            }
        }
    }
    return sqrt(wrong / all);
}

static void light_moves_its_layer(void **state)
{
    static const int steps[][2] = {{1, 0}, {0, 1}, {-19, 7}, {30, -18}};
    struct scene a = scene_make(moved(0, 0),
                                scene_kernel(31, 29, MID, 0, TINTED), &usual);
    assert_true(a.src.n > 1);
    for (size_t k = 0; k < COUNT(steps); k++) {
        const int dx = steps[k][0], dy = steps[k][1];
        struct scene b = scene_make(moved(dx, dy),
                                    scene_kernel(31, 29, MID, 0, TINTED),
                                    &usual);
        assert_int_equal(b.src.n, a.src.n);
        for (int i = 0; gp_engines[i]; i++) {
            const char *const e = gp_engines[i]->name;
            struct gp_glare_stats stats;
            if (!ran_once(e, &a, &stats, "a") ||
                !ran_once(e, &b, &stats, "moved"))
                continue;
            const double error = shift_error(&a.f.layer, &b.f.layer, dx, dy);
            if (!(error <= 2.0 * usual_bar(e)))
                fail_msg("%s: moved by %d, %d: %g", e, dx, dy, error);
        }
        scene_free(&b);
    }
    scene_free(&a);
}

/* The window's place is no part of the sum. */
static void windows_change_no_byte(void **state)
{
    static const int corner[][2] = {
        {-1000, 3}, {7, -90000}, {1 << 20, 1 << 20},
    };
    struct scene a = law_scene(FEW, 5u);
    for (int i = 0; gp_engines[i]; i++) {
        struct gp_glare_stats stats;
        if (!ran_once(gp_engines[i]->name, &a, &stats, "window"))
            continue;
        const uint64_t hash = scene_hash(&a);
        for (size_t k = 0; k < COUNT(corner); k++) {
            struct scene b = scene_make(
                scene_frame(97, 61, corner[k][0], corner[k][1], FEW, 5u),
                scene_kernel(31, 29, MID, 0, TINTED), &usual);
            ran_once(gp_engines[i]->name, &b, &stats, "window");
            assert_true(scene_hash(&b) == hash);
            scene_free(&b);
        }
    }
    scene_free(&a);
}

/* A kernel of one pixel gives the sources back: exactly where the sum is
 * taken as it is written, to the bar through a transform. */
static void identity_gives_the_sources(void **state)
{
    struct gp_planes image;
    struct scene s = scene_make(scene_frame(97, 61, 0, 0, FEW, 6u),
                                scene_kernel(1, 1, MID, 0, BOX),
                                &(struct gp_sensor_params) {0.3f, 0.5f, 1e9f});
    const size_t n = gp_frame_pixels(&s.f);
    s.k.k.c[0][0] = s.k.k.c[1][0] = s.k.k.c[2][0] = 1.0f;
    assert_ok(gp_sources_planes(NULL, &s.src, &image));
    for (int i = 0; gp_engines[i]; i++) {
        const char *const e = gp_engines[i]->name;
        struct gp_glare_stats stats;
        struct gp_glare_error error;
        if (!ran_once(e, &s, &stats, "identity"))
            continue;
        for (size_t j = 0; j < 3 * n; j++)
            s.exact[j] = (double) image.c[j / n][j % n];
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &error);
        const double bar = strcmp(e, "fft") == 0 ? usual_bar(e) : 0.0;
        if (!(error.rel_l2 <= bar))
            fail_msg("%s: identity is %g off", e, error.rel_l2);
    }
    gp_planes_free(&image);
    scene_free(&s);
}

/* Sources whose whole kernel is in the frame lose no light. */
static void light_is_kept(void **state)
{
    struct scene s = law_scene(MIDDLE, 7u);
    assert_true(s.src.box.x0 >= 15 && s.src.box.x1 <= 97 - 15);
    assert_true(s.src.box.y0 >= 14 && s.src.box.y1 <= 61 - 14);
    for (int i = 0; gp_engines[i]; i++) {
        const char *const e = gp_engines[i]->name;
        struct gp_glare_stats stats;
        if (!ran_once(e, &s, &stats, "flux"))
            continue;
        for (int c = 0; c < 3; c++) {
            const double want = s.src.flux[c] * s.k.sum[c];
            double flux = 0.0;
            for (size_t j = 0; j < gp_frame_pixels(&s.f); j++)
                flux += (double) s.f.layer.c[c][j];
            if (!(fabs(flux - want) <= usual_bar(e) * want))
                fail_msg("%s: flux %.9g, not %.9g", e, flux, want);
        }
    }
    scene_free(&s);
}

SUITE_OF(laws, ask_quick, NULL,
    layers_add_up, layers_scale, light_moves_its_layer, windows_change_no_byte,
    identity_gives_the_sources, light_is_kept)
