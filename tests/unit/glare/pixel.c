/* glare/floor.c, fft/reach.c: what every single pixel of a layer keeps. */
#include "unit.h"
#include "glare/fft/fft_priv.h"
#include "glare/glare_priv.h"
#include "glare_scene.h"

/* -- reach ------------------------------------------------------------------*/

/* Kernel n of the table below: with holes, to one side, dark in a channel. */
static struct gp_kernel reaching_kernel(int n, uint32_t *seed)
{
    static const char *const names[] = {
        "star:length=1,share=1", "circle:share=1,soft=0.08", "ring", "eye",
    };
    struct gp_kernel_params p = {0};
    struct gp_kernel k;
    if (n < 4)
        return scene_model(names[n], 67, 0.0);
    struct gp_frame f = scene_frame(31, 24, 0, 0, BLACK, 1u);
    for (int i = 0; i < 31 * 24; i++) {
        for (int c = 0; c < 3 - (n == 5); c++)
            f.rgb.c[c][i] = scene_random(seed) < 0.05f ? scene_random(seed)
                                                       : 0.0f;
    }
    p.centered = n == 5;
    p.center[0] = -7.5;
    p.center[1] = 60.5;
    assert_ok(gp_kernel_from_frame(NULL, &p, &f, &k));
    gp_frame_free(&f);
    return k;
}

/* Light and kernel are not negative: the layer is not, and 0 where no source
 * reaches, channel by channel. */
static void no_light_where_no_light_reaches(void **state)
{
    static const struct { int lamps; float most; } light[] = {
        {1, 1e6f}, {5, 1e4f}, {60, 30.0f}, {4000, 3.0f},
    };
    enum { W = 211, H = 134 };
    for (uint32_t i = 0; i < 6 * COUNT(light); i++) {
        uint32_t seed = 77u + i;
        struct gp_frame f = scene_frame(W, H, 0, 0, BLACK, 1u);
        for (int n = 0; n < light[i / 6].lamps; n++) {
            const int at = (int) (W * H * scene_random(&seed));
            for (int c = 0; c < 3; c++)
                f.rgb.c[c][at] = scene_random(&seed) < 0.3f ? 0.0f
                    : 2.0f + light[i / 6].most * scene_random(&seed);
        }
        struct scene s = scene_sense(f, reaching_kernel((int) i % 6, &seed),
                                     &usual);
        struct gp_glare g = {0};
        struct gp_glare_stats stats;
        s.exact = scene_alloc(3 * W * H, sizeof *s.exact);
        gp_glare_reference_direct(&s.src, &s.k, s.exact);
        assert_ok(scene_run("fft", &s, &g, &stats));
        long dark = 0, wrong = 0;
        for (int j = 0; j < 3 * W * H; j++) {
            const float v = s.f.layer.c[j / (W * H)][j % (W * H)];
            dark += s.exact[j] == 0.0;
            wrong += !(v >= 0.0f) || (s.exact[j] == 0.0 && v != 0.0f);
        }
        if (wrong || scene_rel_l2(&s) > 1e-6)
            fail_msg("%d lamps, kernel %u: %ld of %ld dark samples are not "
                     "dark, rel_l2 %g", light[i / 6].lamps, i % 6, wrong, dark,
                     scene_rel_l2(&s));
        gp_glare_close(&g);
        scene_free(&s);
    }
}

enum support { FULL, DISC, HOLLOW, SPECKLED, ROWS, SUPPORTS };

/* True where a kernel of n x m samples is not 0 at (x, y). */
static bool in_support(enum support s, int x, int y, int n, int m, float dense,
                       uint32_t *seed)
{
    const float dx = 2.0f * (float) x / (float) n - 1.0f;
    const float dy = 2.0f * (float) y / (float) m - 1.0f;
    const float r2 = dx * dx + dy * dy;
    switch (s) {
    case DISC:
        return r2 < 1.0f;
    case HOLLOW:
        return r2 < 1.0f && r2 > dense;
    case SPECKLED:
        return scene_random(seed) < dense;
    case ROWS: // some are empty, some have a gap
        return scene_noise(y) < dense && (x < n / 3 || scene_noise(-y) < 0.5f);
    default:
        return true;
    }
}

/* Marks the samples of a kernel that count as its support: those that are not 0
 * and, where a tail fills what is between them, those between the first and the
 * last of 16 rows that have some, in each of these that has some itself. */
static void mark_support(const float *v, int w, int h, bool tail, bool *held)
{
    enum { BLOCK = 16 };
    for (int y = 0; y < h; y++) {
        const int end = y / BLOCK * BLOCK + BLOCK;
        int from = w, to = 0, own = 0;
        for (int i = y / BLOCK * BLOCK * w; i < h * w && i < end * w; i++) {
            if (!(v[i] > 0.0f))
                continue;
            from = from < i % w ? from : i % w;
            to = to > i % w ? to : i % w + 1;
            own += i / w == y;
        }
        for (int x = 0; x < w; x++)
            held[y * w + x] = tail ? own && x >= from && x < to
                                   : v[y * w + x] > 0.0f;
    }
}

/* Of random light, kernels (centres outside too, and with a tail) and layers:
 * samples of marked rows in (0, noise] become 0 where a sum over all sources
 * and samples of the kernel has no term; all others stay. */
static void only_noise_out_of_reach_is_cleared(void **state)
{
    static struct gp_tail tail;
    long cleared = 0;
    for (uint32_t seed, i = 0; i < 200; i++) {
        seed = 31u * i;
        const enum support support = i % SUPPORTS;
        const bool alike = scene_random(&seed) < 0.5f;
        const float lit = powf(scene_random(&seed), 8.0f);
        const float dense = powf(scene_random(&seed), 3.0f);
        struct gp_sources like = {
            .w = 1 + (int) (280.0f * scene_random(&seed)),
            .h = 1 + (int) (60.0f * scene_random(&seed)),
        };
        struct gp_kernel k = {
            .w = 1 + (int) (250.0f * scene_random(&seed)),
            .h = 1 + (int) (70.0f * scene_random(&seed)),
        };
        k.cx = (int) ((float) k.w * (2.0f * scene_random(&seed) - 0.5f));
        k.cy = (int) ((float) k.h * (2.0f * scene_random(&seed) - 0.5f));
        const int w = like.w, h = like.h, n = w * h, area = k.w * k.h;
        struct gp_sources src;
        struct gp_planes layer;
        struct gp_fft_shape shape[3];
        struct gp_fft_reach *reach;
        const float noise = 0.5f;
        assert_ok(gp_sources_make(NULL, &like, (size_t) n, &src));
        for (int j = 0; j < n; j++) {
            float rgb[3];
            for (int c = 0; c < 3; c++)
                rgb[c] = alike || scene_random(&seed) < 0.7f ? 1.0f : 0.0f;
            if (scene_random(&seed) < lit || (!j && lit < 0.01f))
                gp_sources_add(&src, j % w, j / w, rgb);
        }
        gp_sources_finish(&src);
        assert_ok(gp_planes_make(NULL, "kernel", (size_t) area, &k.k));
        assert_ok(gp_planes_make(NULL, "layer", (size_t) n, &layer));
        float *const was = scene_alloc(3 * (size_t) n, sizeof *was);
        bool *const reached = scene_alloc(3 * (size_t) n, sizeof *reached);
        bool *const noisy = scene_alloc(3 * (size_t) h, sizeof *noisy);
        bool *const held = scene_alloc(3 * (size_t) area, sizeof *held);
        k.tail = scene_random(&seed) < 0.3f ? &tail : NULL;
        for (int c = 0; c < 3; c++) {
            for (int j = 0; j < area; j++)
                k.k.c[c][j] = alike && c ? k.k.c[0][j]
                    : in_support(support, j % k.w, j / k.w, k.w, k.h, dense,
                                 &seed) ? 0.5f : 0.0f;
            assert_ok(gp_fft_shape_make(NULL, &k, c, &shape[c]));
            mark_support(k.k.c[c], k.w, k.h, k.tail, held + c * area);
            for (int y = 0; y < h; y++)
                noisy[c * h + y] = scene_random(&seed) < 0.8f;
            for (int j = 0; j < n; j++)
                layer.c[c][j] = was[c * n + j] =
                    scene_random(&seed) < 0.2f ? 0.0f : scene_random(&seed);
        }
        for (int y = 0; y < h; y++) {
            for (uint32_t s = src.row[y]; s < src.row[y + 1]; s++) {
                for (int j = 0; j < 3 * area; j++) {
                    const int c = j / area;
                    const int px = src.x[s] + j % k.w - k.cx;
                    const int py = y + j % area / k.w - k.cy;
                    if (src.rgb[c][s] > 0.0f && held[j] && px >= 0 &&
                        px < w && py >= 0 && py < h)
                        reached[c * n + py * w + px] = true;
                }
            }
        }
        const struct gp_fft_shape *const shapes[] = {shape, shape + 1,
                                                     shape + 2};
        assert_ok(gp_fft_reach_open(NULL, &src, &k, shapes, &reach));
        for (int j = 0; j < 3 * h; j++) {
            if (noisy[j])
                gp_fft_reach_clear(reach, j / h, j % h, 0, noise,
                                   layer.c[j / h] + j % h * w);
        }
        gp_fft_reach_free(&reach);
        for (int j = 0; j < 3 * n; j++) {
            const int c = j / n;
            const bool clear = !reached[j] && was[j] <= noise &&
                               noisy[c * h + j % n / w];
            if (layer.c[c][j % n] != (clear ? 0.0f : was[j]))
                fail_msg("run %u, channel %d, pixel %d %d: %g of %g", i, c,
                         j % w, j % n / w, (double) layer.c[c][j % n],
                         (double) was[j]);
            cleared += clear;
        }
        for (int c = 0; c < 3; c++)
            gp_fft_shape_free(&shape[c]);
        free(noisy);
        gp_planes_free(&k.k);
        gp_planes_free(&layer);
        gp_sources_free(&src);
        free(was);
        free(reached);
        free(held);
    }
    assert_true(cleared > 0);
}

/* -- the worst pixel --------------------------------------------------------*/

/* A frame and a kernel of a search: few or many lamps in the dark, and a kernel
 * that is flat, has a peak, or holds few samples. */
static struct scene search_scene(uint32_t *seed)
{
    const int w = 8 + (int) (120.0f * scene_random(seed));
    const int h = 8 + (int) (90.0f * scene_random(seed));
    const float few = scene_random(seed);
    const float hot = exp2f(24.0f * scene_random(seed));
    const float dark = scene_random(seed) < 0.5f ? 0.0f : 1e-3f;
    const int side = 1 + (int) (60.0f * scene_random(seed));
    const float holes = scene_random(seed), peak = scene_random(seed);
    struct gp_frame f = scene_frame(w, h, 0, 0, BLACK, 1u);
    struct gp_frame image = scene_frame(side, side, 0, 0, BLACK, 1u);
    struct gp_kernel_params p = {0};
    struct gp_kernel k;
    for (int i = 0; i < w * h; i++) {
        const bool lit = i == w * h / 3 || scene_random(seed) < few * few * few;
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] = lit ? 2.0f + hot * scene_random(seed) : dark;
    }
    for (int i = 0; i < side * side; i++) {
        const bool on = i == side * side / 2 || scene_random(seed) > holes;
        for (int c = 0; c < 3; c++)
            image.rgb.c[c][i] = !on ? 0.0f
                : (peak < 0.3f ? 1.0f : scene_random(seed)) +
                  (i == side * side / 2 ? 1000.0f * (peak > 0.7f) : 0.0f);
    }
    assert_ok(gp_kernel_from_frame(NULL, &p, &image, &k));
    gp_frame_free(&image);
    return scene_make(f, k, &usual);
}

/* No pixel of the composite is further off than bound_pixel says, on frames
 * found by a search (the suite adversary has the bound from below). */
static void no_pixel_is_over_its_bound(void **state)
{
    static const char *const engines[] = {"direct", "fft"};
    for (uint32_t i = 0; i < 150; i++) {
        uint32_t seed = 9000u + i;
        struct scene s = search_scene(&seed);
        for (int scatter = 0; scatter < 2; scatter++) {
            for (size_t e = 0; e < COUNT(engines); e++) {
                struct gp_glare_params p = GP_GLARE_DEFAULTS;
                struct gp_glare g = {0};
                struct gp_glare_stats stats;
                struct gp_glare_error error;
                p.engine = engines[e];
                p.tolerance_pixel = 1e-3f;
                p.taken = scatter ? &s.src : NULL;
                assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f,
                                       &stats));
                gp_glare_measure(&s.f, &s.f.layer, s.exact, p.gain, p.taken,
                                 &error);
                if (!(error.max_rel <= stats.bound_pixel))
                    fail_msg("seed %u, %s: max_rel %g, bound %g", 9000u + i,
                             p.engine, error.max_rel, stats.bound_pixel);
                gp_glare_close(&g);
            }
        }
        scene_free(&s);
    }
}

/* Even light; light of one side that all but the last column gets; others. */
static struct scene limits_scene(uint32_t i)
{
    uint32_t seed = 700u + i;
    if (i > 1)
        return search_scene(&seed);
    if (i == 0)
        return scene_make(scene_frame(90, 70, 0, 0, ALL, 1u),
                          scene_kernel(61, 61, MID, 0, BOX), &usual);
    struct gp_frame f = scene_frame(200, 160, 0, 0, BLACK, 1u);
    for (int y = 0; y < 3 * 160; y++)
        f.rgb.c[y / 160][y % 160 * 200] = 5.0f;
    return scene_make(f, scene_kernel(199, 321, 0, 160, BOX), &usual);
}

/* The limits of the composite are on the safe side; the least one counts the
 * light of other pixels: for even light to a kernel's reach, nearly all. */
static void composites_keep_their_limits(void **state)
{
    double nearest = 0.0;
    for (uint32_t i = 0; i < 40; i++) {
        struct scene s = limits_scene(i);
        const size_t n = gp_frame_pixels(&s.f);
        for (int scatter = 0; scatter < 2; scatter++) {
            struct gp_glare_params p = GP_GLARE_DEFAULTS;
            const struct gp_glare_request req = {
                .params = &p, .src = &s.src, .kernel = &s.k,
            };
            struct gp_pixel_floor floor;
            double *const y = scene_alloc(n, sizeof *y);
            double least = INFINITY, most = 0.0;
            p.taken = scatter ? &s.src : NULL;
            assert_ok(gp_pixel_floor_find(&req, &s.f, &floor));
            for (size_t j = 0; j < 3 * n; j++)
                y[j % n] += (double) s.f.luminance[j / n] *
                            ((double) s.f.rgb.c[j / n][j % n] + s.exact[j]);
            for (uint32_t j = 0, row = 0; scatter && j < s.src.n; j++) {
                while (s.src.row[row + 1] <= j)
                    row++;
                for (int c = 0; c < 3; c++)
                    y[row * (uint32_t) s.src.w + (uint32_t) s.src.x[j]] -=
                        (double) s.f.luminance[c] * (double) s.src.rgb[c][j];
            }
            for (size_t j = 0; j < n; j++) {
                least = fmin(least, y[j]);
                most = fmax(most, y[j]);
            }
            free(y);
            const double slack = 1e-9 * most; // exact layers have some too
            if (!(floor.lit <= least + slack && floor.least <= floor.lit &&
                  floor.most <= most + slack))
                fail_msg("seed %u: from %.9g to %.9g, not %.9g to %.9g", i,
                         floor.lit, floor.most, least, most);
            if (!i)
                nearest = (floor.lit - floor.least) / (least - floor.least);
        }
        scene_free(&s);
    }
    print_message("least light of others: %.3f of it\n", nearest);
    assert_true(nearest > 0.5);
}

/* A frame in which each fifth pixel is a lamp and the others are black. */
static struct gp_frame lamps(void)
{
    uint32_t seed = 5u;
    struct gp_frame f = scene_frame(200, 150, 0, 0, BLACK, 1u);
    for (int i = 0; i < 200 * 150; i++) {
        const bool lit = scene_random(&seed) < 0.2f;
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] = lit ? 50.0f * scene_random(&seed) : 0.0f;
    }
    return f;
}

/* Lamps in the dark: the darkest pixel is lit by a hundred others, and the
 * bound of fft knows it. */
static void lamps_light_the_dark(void **state)
{
    struct scene s =
        scene_make(lamps(), scene_kernel(90, 80, MID, 0, PEAK), &usual);
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare g = {0};
    struct gp_glare_stats stats;
    struct gp_glare_error error;
    p.engine = "fft";
    p.tolerance_pixel = 1e-3f;
    assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f, &stats));
    gp_glare_measure(&s.f, &s.f.layer, s.exact, p.gain, NULL, &error);
    assert_true(error.max_rel <= stats.bound_pixel);
    assert_true(stats.bound_pixel < 2e-4);
    gp_glare_close(&g);
    scene_free(&s);
}

/* auto takes fft where its bound keeps the tolerance, in double where only that
 * one does. */
static void auto_keeps_the_tolerance_of_a_pixel(void **state)
{
    struct scene s =
        scene_make(lamps(), scene_kernel(90, 80, MID, 0, SPECKS), &usual);
    double fft = 0.0;
    s.src.hidden = 0.0; // or fft is in double
    for (int i = 0; i < 3; i++) {
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare g = {0};
        struct gp_glare_stats stats;
        struct gp_glare_error error;
        p.engine = i ? "auto" : "fft";
        p.tolerance_pixel = i == 1 ? 1e-5f : (float) (2.0 * fft + 1e-9);
        assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f, &stats));
        gp_glare_measure(&s.f, &s.f.layer, s.exact, p.gain, NULL, &error);
        fft = i ? fft : stats.bound_pixel;
        assert_true(error.max_rel <= stats.bound_pixel);
        assert_string_equal(stats.engine, "fft");
        assert_int_equal(stats.fft_double, i == 1);
        assert_true(stats.bound_pixel <= (double) p.tolerance_pixel || !i);
        gp_glare_close(&g);
    }
    scene_free(&s);
}

SUITE_OF(pixel, NULL, NULL, no_light_where_no_light_reaches,
         only_noise_out_of_reach_is_cleared, no_pixel_is_over_its_bound,
         composites_keep_their_limits, lamps_light_the_dark,
         auto_keeps_the_tolerance_of_a_pixel)
