// SPDX-License-Identifier: Apache-2.0
/* lens_draw: ghosts in a layer hold the light of closed forms, at every size of
 * the frame; what is left out is counted; threads change nothing. */
#include "core/colour.h"
#include "json_file.h"
#include "scene.h"
#include "sun/lens.h"
#include "sun/lens_priv.h"

/* Stop and thin lens, of glass without dispersion: one ghost, R^2 of the
 * image's light, a disc about six times the stop's size. */
#define THIN "{'name': 'thin', %s 'surfaces': [{'stop': true, 'semi': 2,"      \
    "'thickness': 0.01}, {'radius': 400, 'thickness': 0.01, 'n': 1.5,"         \
    "'semi': 20},{'radius': -400, 'semi': 20}]}"

static struct gp_lens thin_lens(const char *more)
{
    char text[512];
    struct gp_lens lens = {0};
    snprintf(text, sizeof text, THIN, more);
    assert_ok(gp_lens_read(&kept_log, jf_write(text), &lens));
    assert_ok(gp_lens_focus(&kept_log, &lens, INFINITY, 0.0));
    return lens;
}

/* A layer of w x h pixels, `mm` wide, drawn for lights. */
static struct gp_planes layer_of(const struct gp_lens *lens, int w, int h,
    double mm, double mean, const struct gp_lens_light *light, int n,
    struct glarepp_lens_facts *stats)
{
    struct gp_planes p;
    const struct gp_rect frame = {-3, 5, w - 3, h + 5};
    const struct gp_lens_view view = {
        .frame = frame, .display = frame, .mm = {mm / w, mm / w},
        .chromaticities = gp_rec709_chromaticities,
        .luminance = gp_rec709_luminance, .mean = mean, .tolerance = 1e-3,
    };
    const size_t pixels = (size_t) w * (size_t) h;
    assert_ok(gp_planes_make(&kept_log, "layer", pixels, &p));
    for (int c = 0; c < 3; c++)
        memset(p.c[c], 0, pixels * sizeof(float));
    assert_ok(gp_lens_draw(&kept_log, lens, &view, light, n, &p, stats));
    return p;
}

/* Sum, and centroid in pixels from the data window's corner. */
static double sum_of(const struct gp_planes *p, int c, int w, int h, double *x,
                     double *y)
{
    double sum = 0.0;
    *x = *y = 0.0;
    for (int i = 0; i < w * h; i++) {
        const double v = (double) p->c[c][i];
        assert_true(v >= 0.0 && isfinite(v));
        sum += v;
        *x += v * (i % w + 0.5);
        *y += v * (i / w + 0.5);
    }
    *x /= sum;
    *y /= sum;
    return sum;
}

static void light_in_closed_form(void **state)
{
    static const char *const stops[] = {"", "'blades': 5, 'blade_turn': 20,"};
    static const int sizes[] = {24, 97, 300};
    for (size_t s = 0; s < COUNT(stops); s++) {
        const struct gp_lens lens = thin_lens(stops[s]);
        for (size_t i = 0; i < COUNT(sizes); i++) {
            const int w = sizes[i], h = w;
            const double at = 0.04 * w; // from the middle
            const struct gp_lens_light light = {
                0.5 * w - 3 + at, 0.5 * h + 5 - 0.5 * at, {100, 200, 300}};
            struct glarepp_lens_facts stats;
            struct gp_planes p = layer_of(&lens, w, h, 40.0, 0.0, &light, 1,
                                          &stats);
            for (int c = 0; c < 3; c++) {
                double x, y;
                const double want = 0.0016 * light.flux[c];
                assert_near(sum_of(&p, c, w, h, &x, &y) / want, 1.0, 1e-3,
                            "light", w);
                assert_near(stats.light[c] / want, 1.0, 1e-3, "counted", w);
                // by first order: its middle, through the stop's
                struct glarepp_ghost ghost[GP_LENS_GHOSTS];
                assert_int_equal(gp_lens_ghosts(&lens, 550.0, ghost, NULL), 1);
                const double place = ghost[0].b / 400.0;
                assert_near(x, 0.5 * w + at * place, 0.1, "across", w);
                assert_near(y, 0.5 * h - 0.5 * at * place, 0.1, "down", w);
            }
            assert_int_equal(stats.drawn, 1);
            assert_true(stats.lost == 0.0 && stats.dark == 0.0);
            gp_planes_free(&p);
        }
    }
}

/* An even disc: its light over its area, in the middle. */
static void disc_is_even(void **state)
{
    enum { W = 200 };
    const struct gp_lens lens = thin_lens("");
    struct glarepp_ghost ghost[GP_LENS_GHOSTS];
    double blur[GP_LENS_GHOSTS];
    struct glarepp_lens_facts stats;
    const struct gp_lens_light light = {0.5 * W - 3, 0.5 * W + 5, {1, 1, 1}};
    struct gp_planes p = layer_of(&lens, W, W, 40.0, 0.0, &light, 1, &stats);
    gp_lens_ghosts(&lens, 550.0, ghost, blur);
    const double radius = 2.0 * fabs(ghost[0].a) * W / 40.0;
    const double even = 0.0016 / (acos(-1.0) * radius * radius);
    for (int i = 0; i < W * W; i++) {
        const double far = hypot(i % W + 0.5 - 0.5 * W, i / W + 0.5 - 0.5 * W);
        const double v = (double) p.c[1][i];
        if (far < 0.8 * radius)
            assert_near(v / even, 1.0, 0.02, "inside", far / radius);
        if (far > 1.05 * radius + 3.0 * blur[0] * W / 40.0)
            assert_near(v / even, 0.0, 1e-9, "outside", far / radius);
    }
    gp_planes_free(&p);
}

/* Faint ghosts are left out together under the tolerance; none of a black
 * frame. */
static void faint_ghosts_are_counted(void **state)
{
    struct gp_lens lens = {0};
    enum { W = 96, H = 64 };
    const struct gp_lens_light light = {20.0, 30.0, {1e3, 1e3, 1e3}};
    struct glarepp_lens_facts stats[4];
    static const double mean[4] = {0.0, 0.01, 1.0, 1e9};
    assert_ok(gp_lens_read(&kept_log, "heliar", &lens));
    assert_ok(gp_lens_focus(&kept_log, &lens, INFINITY, 0.0));
    for (int i = 0; i < 4; i++) {
        struct gp_planes p = layer_of(&lens, W, H, 84.0, mean[i], &light, 1,
                                      &stats[i]);
        double x, y;
        assert_int_equal(stats[i].ghosts, 28);
        assert_int_equal(stats[i].drawn + stats[i].left_out, 28);
        assert_true(stats[i].dark <= 1e-3);
        if (i == 3)
            assert_true(sum_of(&p, 1, W, H, &x, &y) == 0.0);
        gp_planes_free(&p);
    }
    assert_int_equal(stats[0].left_out, 0);
    assert_true(stats[1].left_out < stats[2].left_out);
    assert_int_equal(stats[3].drawn, 0);
    // the drawn light is less than the image's, by far
    assert_true(stats[0].light[1] > 0.0 && stats[0].light[1] < 0.01 * 1e3);
}

/* The norm of the ghosts that are left out is under the bound, and not far
 * under it; lights that are not given count as much as lights that are. */
static void left_out_is_bounded(void **state)
{
    enum { W = 120, H = 80, N = W * H };
    static const char *const names[] = {"heliar", "tessar", "double-gauss"};
    const struct gp_rect frame = {0, 0, W, H};
    const struct gp_lens_light light[2] = {{35.0, 30.0, {1e3, 1e3, 1e3}},
                                           {90.0, 45.0, {5e2, 1e3, 2e3}}};
    for (size_t l = 0; l < COUNT(names); l++) {
        struct gp_planes p[2] = {0}; // of all ghosts, and of those that count
        struct glarepp_lens_facts stats[3];
        for (int t = 0; t < 3; t++) {
            static const double mean[] = {0.003, 0.03, 1e9};
            struct gp_lens lens = {0};
            double off = 0.0;
            assert_ok(gp_lens_read(&kept_log, names[l], &lens));
            assert_ok(gp_lens_focus(&kept_log, &lens, INFINITY, 0.0));
            struct gp_lens_view view = {
                .frame = frame,
                .display = frame,
                .mm = {84.0 / W, 84.0 / W},
                .chromaticities = gp_rec709_chromaticities,
                .luminance = gp_rec709_luminance,
                .tolerance = 1e-3,
                .detail = GP_LENS_REFERENCE, // the same meshes
            };
            for (int k = t ? 1 : 0; k < 2; k++) {
                view.mean = k ? mean[t] : 0.0;
                if (!t)
                    assert_ok(gp_planes_make(&kept_log, "layer", N, &p[k]));
                gp_planes_clear(&p[k], 0, N);
                assert_ok(gp_lens_draw(&kept_log, &lens, &view, light, 2, &p[k],
                                       &stats[k]));
            }
            for (int c = 0; c < 3; c++) {
                for (int i = 0; i < N; i++)
                    off += pow((double) (p[0].c[c][i] - p[1].c[c][i]), 2.0);
            }
            assert_true(stats[0].missing == 0.0 && stats[1].left_out > 0);
            assert_true(sqrt(off) > 0.0);
            const double over = stats[1].missing / sqrt(off);
            if (!(over >= 1.0 && over < 30.0))
                fail_msg("%s, mean %g: %g times the error", names[l], mean[t],
                         over);
            // the second light as one that is not given
            memcpy(view.rest, light[1].flux, sizeof view.rest);
            assert_ok(gp_lens_draw(&kept_log, &lens, &view, light, 1, &p[1],
                                   &stats[2]));
            assert_true(stats[2].missing >= stats[1].missing * (1.0 - 1e-9));
        }
        gp_planes_free(&p[0]);
        gp_planes_free(&p[1]);
    }
}

/* Light of a path at one wavelength, in mm^2. */
static double traced_light(const struct gp_lens *lens, int first, int second,
                           double u, double nm)
{
    struct gp_lens_optics o[GP_LENS_NODES];
    struct gp_lens_path path;
    struct gp_lens_mesh m;
    const struct gp_lens_blades blades = gp_lens_blades_of(lens, 0.0);
    for (int k = 0; k < GP_LENS_NODES; k++)
        gp_lens_optics_make(lens, nm, &o[k]);
    gp_lens_path(lens, first, second, &path);
    assert_ok(gp_lens_mesh_make(&kept_log, o, &path, &blades, u, 1e-3, 0.0,
                                &m));
    const double light = m.flux[0];
    gp_lens_mesh_free(&m);
    return light;
}

/* Each channel's light of all ghosts is that of 26 traced parts of the
 * spectrum: coats reflect several times as much at its ends. */
static void colours_follow_the_spectrum(void **state)
{
    enum { W = 96, H = 64, PARTS = 26 };
    static const char *const names[] = {"heliar",       "tessar",
                                        "double-gauss", "telephoto",
                                        "zoom-wide",    "zoom-tele"};
    for (size_t l = 0; l < COUNT(names); l++) {
        struct gp_lens lens = {0};
        struct glarepp_lens f;
        struct glarepp_ghost ghost[GP_LENS_GHOSTS];
        struct glarepp_lens_facts stats;
        double nm[PARTS], rgb[PARTS][3], want[3] = {0};
        assert_ok(gp_lens_read(&kept_log, names[l], &lens));
        assert_ok(gp_lens_focus(&kept_log, &lens, INFINITY, 0.0));
        gp_lens_measure(&lens, &f);
        const int n = gp_lens_ghosts(&lens, GP_D_LINE, ghost, NULL);
        const double u = 0.15;
        const struct gp_lens_light light = {
            0.5 * W - 3 + u * f.focal * W / 84.0, 0.5 * H + 5, {1, 1, 1}};
        gp_spectrum_colours(gp_rec709_chromaticities, PARTS, nm, rgb);
        for (int i = 0; i < PARTS; i++) {
            const double image = traced_light(&lens, -1, -1, 0.0, nm[i]);
            double sum = 0.0;
            for (int g = 0; g < n; g++)
                sum += traced_light(&lens, ghost[g].first, ghost[g].second, u,
                                    nm[i]);
            for (int c = 0; c < 3; c++)
                want[c] += rgb[i][c] * sum / image;
        }
        struct gp_planes p = layer_of(&lens, W, H, 84.0, 0.0, &light, 1,
                                      &stats);
        for (int c = 0; c < 3; c++)
            assert_near(stats.light[c] / want[c], 1.0, 0.015, names[l], c);
        gp_planes_free(&p);
    }
}

/* Few bands and coarse meshes, as for many lights, against many and fine ones:
 * the same light of each channel, at nearly the same places. */
static void coarse_is_near_fine(void **state)
{
    enum { W = 240, H = 160, N = W * H };
    struct gp_lens lens = {0};
    const struct gp_rect frame = {0, 0, W, H};
    const struct gp_lens_light light = {70.0, 60.0, {1e3, 1e3, 1e3}};
    struct gp_planes p[2];
    assert_ok(gp_lens_read(&kept_log, "heliar", &lens));
    assert_ok(gp_lens_focus(&kept_log, &lens, INFINITY, 0.0));
    for (int k = 0; k < 2; k++) {
        struct glarepp_lens_facts stats;
        const struct gp_lens_view view = {
            .frame = frame, .display = frame, .mm = {84.0 / W, 84.0 / W},
            .chromaticities = gp_rec709_chromaticities,
            .luminance = gp_rec709_luminance, .tolerance = 1e-3,
            .detail = k ? GP_LENS_FINE : GP_LENS_COARSE,
        };
        assert_ok(gp_planes_make(&kept_log, "layer", N, &p[k]));
        gp_planes_clear(&p[k], 0, N);
        assert_ok(gp_lens_draw(&kept_log, &lens, &view, &light, 1, &p[k],
                               &stats));
    }
    for (int c = 0; c < 3; c++) {
        double sum[2] = {0}, off = 0.0, all = 0.0;
        for (int i = 0; i < N; i++) {
            const double a = (double) p[0].c[c][i], b = (double) p[1].c[c][i];
            sum[0] += a;
            sum[1] += b;
            off += (a - b) * (a - b);
            all += b * b;
        }
        assert_near(sum[0] / sum[1], 1.0, 0.01, "light", c);
        assert_near(sqrt(off / all), 0.0, 0.105, "places", c);
    }
    gp_planes_free(&p[0]);
    gp_planes_free(&p[1]);
}

/* Middle of a telephoto's ghost, whose violet light is spread over many pixels:
 * luminance rises and falls once, without rings of bands. */
static void bands_leave_no_rings(void **state)
{
    enum { W = 1920, H = 1080, X = 1000, CROP = 480 };
    struct gp_lens lens = {0};
    const struct gp_lens_light light = {1280.0, 180.0, {1e7, 1e7, 1e7}};
    struct glarepp_lens_facts stats;
    struct gp_planes p;
    assert_ok(gp_lens_read(&kept_log, "telephoto", &lens));
    assert_ok(gp_lens_focus(&kept_log, &lens, INFINITY, 0.0));
    const struct gp_lens_view view = {
        .frame = {X, 232, X + CROP, 236},
        .display = {0, 0, W, H},
        .mm = {36.0 / W, 36.0 / W},
        .chromaticities = gp_rec709_chromaticities,
        .luminance = gp_rec709_luminance,
        .tolerance = 1e-3,
        .mean = 0.01,
        .detail = GP_LENS_FINE,
    };
    assert_ok(gp_planes_make(&kept_log, "layer", CROP * 4, &p));
    gp_planes_clear(&p, 0, CROP * 4);
    assert_ok(gp_lens_draw(&kept_log, &lens, &view, &light, 1, &p, &stats));
    enum { NEAR = 12 }; // pixels: finer than rings that an eye sees
    float row[CROP] = {0}, top = 0.0f;
    for (int x = 0; x < CROP - NEAR; x++) {
        for (int i = 0; i < NEAR; i++)
            for (int k = 0; k < 3; k++)
                row[x] += gp_rec709_luminance[k] * p.c[k][CROP + x + i] / NEAR;
        top = fmaxf(top, row[x]);
    }
    float turn = row[0];
    int turns = 0, way = 0;
    for (int x = 0; x < CROP - NEAR; x++) {
        const float off = row[x] - turn;
        if (way == 0 ? fabsf(off) > 0.15f * top
                     : (float) way * off < -0.15f * top) {
            turns += way != 0;
            way = off > 0.0f ? 1 : -1;
            turn = row[x];
        }
        turn = (float) way * (row[x] - turn) > 0.0f ? row[x] : turn;
    }
    if (turns > 3)
        fail_msg("luminance turns %d times", turns);
    gp_planes_free(&p);
}

/* Polygons cover pixels by area: sums, and those of one pixel. */
static void cover_is_exact(void **state)
{
    enum { W = 9, H = 7 };
    static const double light[3] = {1.0, 2.0, 0.5};
    double v[H * (W + 2) * 3];
    const struct gp_lens_cover k = {v, W, 0, H};
    static const double shapes[][4][2] = {
        {{1.25, 1.5}, {4.75, 1.5}, {4.75, 4.25}, {1.25, 4.25}},
        {{1.25, 1.5}, {1.25, 4.25}, {4.75, 4.25}, {4.75, 1.5}},
        {{2.1, 0.3}, {8.2, 3.3}, {6.0, 6.6}, {0.4, 4.9}},
        {{3.2, 3.3}, {3.4, 3.3}, {3.4, 3.5}, {3.2, 3.5}},
        {{3.2, 3.3}, {5.2, 3.3}, {5.2, 3.3}, {3.2, 3.3}}, // no area
    };
    for (int s = 0; s < (int) COUNT(shapes); s++) {
        double sum = 0.0;
        memset(v, 0, sizeof v);
        gp_lens_cover_add(&k, shapes[s], 4, light);
        for (int y = 0; y < H; y++) {
            double run[3] = {0};
            for (int x = 0; x < W + 2; x++) {
                for (int c = 0; c < 3; c++)
                    run[c] += v[3 * (y * (W + 2) + x) + c];
                assert_true(run[0] > -1e-12);
                assert_near(run[1], 2.0 * run[0], 1e-12, "channel", s);
                sum += run[0];
                if (s < 2 && y == 1 && x == 1)
                    assert_near(run[0], 0.75 * 0.5 / (3.5 * 2.75), 1e-12,
                                "corner", s);
            }
        }
        assert_near(sum, 1.0, 1e-12, "sum", s);
    }
    // half of it beyond the left side, and all beyond the right
    const double left[4][2] = {{-2, 1}, {2, 1}, {2, 3}, {-2, 3}};
    const double right[4][2] = {{W, 1}, {W + 5, 1}, {W + 5, 3}, {W, 3}};
    double sum = 0.0;
    memset(v, 0, sizeof v);
    gp_lens_cover_add(&k, left, 4, light);
    gp_lens_cover_add(&k, right, 4, light);
    for (int y = 0; y < H; y++) {
        double run = 0.0;
        for (int x = 0; x < W; x++)
            sum += run += v[3 * (y * (W + 2) + x)];
    }
    assert_near(sum, 0.5, 1e-12, "half", 0);
}

SUITE_OF(lens_draw, make_folder, remove_folder, light_in_closed_form,
         disc_is_even, faint_ghosts_are_counted, left_out_is_bounded,
         colours_follow_the_spectrum, coarse_is_near_fine, bands_leave_no_rings,
         cover_is_exact)
