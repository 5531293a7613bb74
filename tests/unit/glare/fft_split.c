/* glare/fft/split.c: what goes direct, what it costs, and that the rounding
 * it predicts is kept. */
#include "unit.h"
#include "glare/fft/fft_priv.h"
#include "hard_cases.h"

/* -- choices ----------------------------------------------------------------*/

struct chosen {
    struct gp_fft_split split;
    double plain; // rounding without a split
    double fft_ms;
};

static struct chosen choose(const struct scene *s, double gain)
{
    double tail[GP_FFT_CORES];
    struct chosen c;
    struct gp_fft_split unseen;
    const struct gp_fft_placing p = gp_fft_place(&s->src, &s->k);
    const double points = (double) p.nx * p.ny;
    c.fft_ms = gp_fft_passes_ms(&s->src, &p, GP_FFT_PLAN_MEASURE);
    gp_fft_tail_norms(&s->k, tail);
    gp_fft_split_choose(&s->src, &s->k, tail, points, c.fft_ms, gain,
                        &c.split);
    // what no eye could see is not split, and the rounding goes with the gain
    gp_fft_split_choose(&s->src, &s->k, tail, points, c.fft_ms, 1e-40,
                        &unseen);
    c.plain = unseen.rounding * 1e40 * gain;
    assert_int_equal(unseen.core, -1);
    assert_true(isinf(unseen.hot) && unseen.hot_count == 0);
    return c;
}

static size_t count_hot(const struct gp_sources *s, float hot)
{
    size_t n = 0;
    for (size_t i = 0; i < s->n; i++)
        n += s->rgb[0][i] >= hot || s->rgb[1][i] >= hot || s->rgb[2][i] >= hot;
    return n;
}

/* What every choice must be, whatever the frame. */
static void choices_keep_the_rules(void **state)
{
    static const double gains[] = {1.0, 0.0, 1e-6, 1e-3, 0.1, 100.0};
    int split = 0, whole = 0;
    for (int i = 0; i < HARD_CASES; i++) {
        struct scene s = hard_sense(&hard_cases[i]);
        if (!s.src.n || !gp_fft_place(&s.src, &s.k).nx) {
            scene_free(&s);
            continue;
        }
        for (size_t g = 0; g < COUNT(gains); g++) {
            const struct chosen c = choose(&s, gains[g]);
            const int none = c.split.core < 0 && c.split.hot_count == 0;
            split += !none;
            whole += none;
            assert_int_equal(c.split.hot_count,
                             count_hot(&s.src, c.split.hot));
            if (c.plain <= 0.999e-6 && !none)
                fail_msg("%s: split for nothing", hard_cases[i].name);
            if (c.split.ms > 4.0 * c.fft_ms + 5.0 ||
                (c.split.rounding > 1e-6 && c.split.ms > c.fft_ms / 2.0))
                fail_msg("%s: %g ms direct for %g of transform",
                         hard_cases[i].name, c.split.ms, c.fft_ms);
            if (!(c.split.rounding <= 1.001 * c.plain / (none ? 1.0 : 4.0) ||
                  c.split.rounding <= 1e-6))
                fail_msg("%s: rounding %g in place of %g", hard_cases[i].name,
                         c.split.rounding, c.plain);
        }
        scene_free(&s);
    }
    assert_true(split > 20 && whole > 20);
}

/* One sun over a night: it alone goes direct. */
static void one_sun_goes_direct(void **state)
{
    struct scene s = scene_sense(
        scene_frame(256, 192, 0, 0, HOT, 1u),
        scene_kernel(255, 255, MID, 0, PEAK),
        &(struct gp_sensor_params) {0.0f, 0.0f, 1e10f});
    const struct chosen c = choose(&s, 1.0);
    assert_int_equal(c.split.hot_count, 1);
    assert_true(c.split.hot > 1.0f && c.split.hot <= 1e9f);
    assert_true(c.plain > 1.0); // of the dark pixels' own value
    assert_true(c.split.rounding < 1e-5);
    scene_free(&s);
}

/* Norms of what is left of the kernel, against a sum without its core. */
static void tails_are_the_rest(void **state)
{
    static const int kernels[][4] = {
        {1, 1, MID, 0}, {9, 9, MID, 0}, {10, 8, MID, 0}, {75, 41, MID, 0},
        {75, 41, 3, 40}, {31, 31, -9, 12}, {31, 31, 400, 400},
    };
    for (size_t i = 0; i < COUNT(kernels); i++) {
        const int *const r = kernels[i];
        struct gp_kernel k = scene_kernel(r[0], r[1], r[2], r[3], TINTED);
        double tail[GP_FFT_CORES];
        gp_fft_tail_norms(&k, tail);
        for (int t = 0; t < GP_FFT_CORES; t++) {
            const int radius = gp_fft_core_radius[t];
            double worst = 0.0;
            for (int c = 0; c < 3; c++) {
                double sum = 0.0;
                for (int j = 0; j < k.w * k.h; j++) {
                    const double v = (double) k.k.c[c][j];
                    if (abs(j % k.w - k.cx) > radius ||
                        abs(j / k.w - k.cy) > radius)
                        sum += v * v;
                }
                worst = fmax(worst, sqrt(sum));
            }
            // squares were subtracted: half the digits may be gone
            assert_true(fabs(tail[t] - worst) <= 4e-8 * tail[0]);
        }
        gp_kernel_free(&k);
    }
}

/* -- the promise ------------------------------------------------------------*/

/* Smooth noise in [0, 1] from a grid of `cells` cells. */
static float smooth(int x, int y, int w, int h, int cells, uint32_t seed)
{
    const float gx = (float) x * (float) cells / (float) w;
    const float gy = (float) y * (float) cells / (float) h;
    const int ix = (int) gx, iy = (int) gy;
    float corner[2][2];
    for (int i = 0; i < 4; i++) {
        uint32_t s = seed + 7919u * (uint32_t) (ix + i % 2) +
                     104729u * (uint32_t) (iy + i / 2);
        scene_random(&s);
        corner[i / 2][i % 2] = scene_random(&s);
    }
    const float u = gx - (float) ix, v = gy - (float) iy;
    return (corner[0][0] * (1 - u) + corner[0][1] * u) * (1 - v) +
           (corner[1][0] * (1 - u) + corner[1][1] * u) * v;
}

static void add_blob(struct gp_frame *f, int x0, int y0, float light,
                     float sigma)
{
    const int w = gp_frame_w(f), h = gp_frame_h(f), r = (int) (4 * sigma) + 1;
    for (int y = y0 - r; y <= y0 + r; y++) {
        for (int x = x0 - r; x <= x0 + r; x++) {
            if (x < 0 || x >= w || y < 0 || y >= h)
                continue;
            const float d = (float) ((x - x0) * (x - x0) +
                                     (y - y0) * (y - y0));
            for (int c = 0; c < 3; c++)
                f->rgb.c[c][y * w + x] +=
                    (1.0f - 0.15f * (float) c) * light *
                    expf(-d / (2 * sigma * sigma));
        }
    }
}

enum view { LAMPS, WINDOWS, SKY, VIEWS };

/* Like the three workloads of make_frames.py: a dim ground of smooth noise;
 * lamps of 10 to 5000, lit windows and some lamps, a bright upper half. */
static struct gp_frame make_view(enum view view, int w, int h, uint32_t seed)
{
    struct gp_frame f = scene_frame(w, h, 0, 0, DARK, seed);
    for (int i = 0; i < w * h; i++) {
        const int x = i % w, y = i / w;
        float v = 0.05f + 0.75f * (0.6f * smooth(x, y, w, h, 4, seed) +
                                   0.4f * smooth(x, y, w, h, 31, seed));
        const int pane = x * 16 / w + y * 12 / h * 16;
        uint32_t lot = seed + 977u * (uint32_t) pane;
        scene_random(&lot);
        if (view == SKY && y < h / 2)
            v = 2.1f + 17.9f * smooth(x, y, w, h, 6, seed);
        if (view == WINDOWS && scene_random(&lot) < 0.34f &&
            x % (w / 16) < w / 64 && y % (h / 12) < h / 36)
            v = 5.0f * expf(2.3f * scene_random(&lot));
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] = v * (1.0f - 0.05f * (float) c);
    }
    for (int i = 0; i < (view == LAMPS ? 60 : view == WINDOWS ? 20 : 0); i++) {
        const int x = (int) (scene_random(&seed) * (float) w);
        const int y = (int) (scene_random(&seed) * (float) h);
        const float light = 10.0f * expf(6.2f * scene_random(&seed));
        add_blob(&f, x, y, light, 0.7f + 0.8f * scene_random(&seed));
    }
    return f;
}

/* Where the split says that no pixel is off by over 1e-6 of its own value, none
 * is; elsewhere it is off by no more than a few times what was said. */
static void check_promise(struct scene *s, const struct chosen *c,
                          enum view view)
{
    struct gp_glare_stats stats;
    struct gp_glare_error e;
    ran_once("fft", s, &stats, "rounding");
    gp_glare_measure(&s->f, &s->f.layer, s->exact, 1.0f, &e);
    assert_int_equal(stats.hot, c->split.hot_count);
    assert_int_equal(stats.fft_core, c->split.core);
    assert_true(e.rel_l2 <= 1e-6);
    const double own = scene_own_error(s);
    if (!(own <= (c->split.rounding <= 1e-6 ? 1e-6
                                            : 4.0 * c->split.rounding)))
        fail_msg("view %d, %dx%d: %g of a pixel's own value, %g predicted",
                 (int) view, s->src.w, s->src.h, own, c->split.rounding);
}

static void predicted_rounding_is_kept(void **state)
{
    static const int sizes[][3] = {{192, 144, 97}, {384, 216, 97}};
    int promised = 0;
    for (int i = 0; i < 3 * VIEWS && !(quick && i); i++) {
        const int *const size = sizes[i / VIEWS % 2];
        const enum view view = (enum view) (i % VIEWS);
        struct scene s = scene_make(
            make_view(view, size[0], size[1], 5u + (uint32_t) i),
            scene_kernel(size[2], size[2], MID, 0,
                         i < 2 * VIEWS ? PEAK : TINTED),
            &(struct gp_sensor_params) GP_SENSOR_DEFAULTS);
        const struct chosen c = choose(&s, 1.0);
        promised += c.split.rounding <= 1e-6;
        check_promise(&s, &c, view);
        scene_free(&s);
    }
    assert_true(promised > 0);
}

/* -- the budget -------------------------------------------------------------*/

/* At the size of work: lamps over a night are kept from spoiling it, though
 * that takes longer than the transform; a bright sky is not worth as much. */
static void a_night_is_worth_more_than_a_sky(void **state)
{
    if (quick)
        skip();
    struct gp_frame night = make_view(LAMPS, 960, 540, 3u);
    uint32_t seed = 11u;
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 960 * 540; i++)
            night.rgb.c[c][i] = 3e-4f;
    }
    for (int i = 0; i < 24; i++)
        add_blob(&night, (int) (960.0f * scene_random(&seed)),
                 (int) (540.0f * scene_random(&seed)), 3000.0f, 0.6f);
    struct scene s = scene_sense(
        night, scene_kernel(512, 512, MID, 0, PEAK),
        &(struct gp_sensor_params) GP_SENSOR_DEFAULTS);
    struct chosen c = choose(&s, 1.0);
    if (!(c.split.rounding <= 1e-6 && c.split.ms > 1.5 * c.fft_ms + 5.0))
        fail_msg("night: rounding %g, %g ms direct for %g of transform",
                 c.split.rounding, c.split.ms, c.fft_ms);
    scene_free(&s);
    s = scene_sense(make_view(SKY, 1024, 768, 3u),
                    scene_kernel(512, 512, MID, 0, PEAK),
                    &(struct gp_sensor_params) GP_SENSOR_DEFAULTS);
    c = choose(&s, 1.0);
    if (!(c.split.ms <= c.fft_ms + 10.0))
        fail_msg("sky: %g ms direct for %g of transform", c.split.ms,
                 c.fft_ms);
    scene_free(&s);
}

SUITE_OF(fft_split, ask_quick, NULL,
    choices_keep_the_rules, one_sun_goes_direct, tails_are_the_rest,
    predicted_rounding_is_kept, a_night_is_worth_more_than_a_sky)
