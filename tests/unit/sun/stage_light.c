// SPDX-License-Identifier: Apache-2.0
/* sun/stage_light: a light's disc in pixels. */
#include "unit.h"
#include "sun/stage.h"

enum { W = 40, H = 30 };

/* Joins a light and no sources of a frame from (-3, 7) on, `left` pixels more and a
 * sphere, or not; false: the light does not go through the engines. */
static bool join_in(const struct gp_light *light, int left, bool round,
                    struct gp_sources *out)
{
    const struct gp_rect frame = {-3 - left, 7, -3 + W, 7 + H};
    const struct glarepp_light_params p = {0};
    const struct gp_image image = {.data = frame, .display = frame};
    const struct gp_sources like = {
        .x0 = frame.x0, .y0 = 7, .w = W + left, .h = H};
    struct gp_light l = *light;
    const struct gp_suns suns = {
        .p = &p,
        .light = &l,
        .n = 1,
        .wide = gp_projection_of(round ? GP_LATLONG : GP_PLANE,
                                 (struct gp_rect) {-3, 7, -3 + W, 7 + H}, 1.0,
                                 180.0),
    };
    struct gp_sources none;
    assert_ok(gp_sources_make(NULL, &like, 0, &none));
    gp_sources_finish(&none);
    *out = (struct gp_sources) {0};
    assert_ok(gp_suns_join(NULL, &suns, &image, &none, out));
    gp_sources_free(&none);
    return out->n > 0;
}

static bool join(const struct gp_light *light, struct gp_sources *out)
{
    return join_in(light, 0, false, out);
}

/* Flux is kept and the centroid is the light's place, wherever it stands. */
static void a_disc_keeps_flux_and_place(void **state)
{
    static const double radius[] = {0.0, 0.3, 0.5, 0.51, 1.0, 2.48, 7.9};
    for (int k = 0; k < 7 * 64; k++) {
        struct gp_sources s;
        double sum = 0.0, x = 0.0, y = 0.0;
        const struct gp_light l = {
            .x = 14.0 + k % 64 / 8.0, .y = 20.0 + k % 64 / 32.0,
            .radius = radius[k / 64], .flux = {1000.0f, 10.0f, 1.0f},
            .visibility = 0.25,
        };
        assert_true(join(&l, &s));
        for (int row = 0; row < H; row++) {
            for (uint32_t i = s.row[row]; i < s.row[row + 1]; i++) {
                sum += (double) s.rgb[0][i];
                x += (double) s.rgb[0][i] * (s.x[i] + 0.5 - 3.0);
                y += (double) s.rgb[0][i] * (row + 0.5 + 7.0);
            }
        }
        assert_true(fabs(sum / 250.0 - 1.0) < 1e-6);
        assert_true(fabs(x / sum - l.x) < 1e-5);
        assert_true(fabs(y / sum - l.y) < 1e-5);
        gp_sources_free(&s);
    }
}

/* Of a light across the border, what is in the frame is as in a wider frame. */
static void a_disc_across_the_border_is_cut(void **state)
{
    (void) state;
    for (int k = 0; k < 40; k++) {
        const struct gp_light l = {.x = -8.0 + 0.25 * k,
                                   .y = 20.25,
                                   .radius = 4.0,
                                   .flux = {1000.0f},
                                   .visibility = 1.0};
        float wide[H][W + 20] = {{0}}, cut[H][W] = {{0}};
        float *const to[] = {wide[0], cut[0]};
        for (int i = 0; i < 2; i++) {
            struct gp_sources s;
            if (!join_in(&l, i ? 0 : 20, false, &s))
                continue;
            for (int y = 0; y < H; y++) {
                for (uint32_t q = s.row[y]; q < s.row[y + 1]; q++)
                    to[i][y * s.w + s.x[q]] += s.rgb[0][q];
            }
            gp_sources_free(&s);
        }
        for (int i = 0; i < W * H; i++) {
            const int x = i % W, y = i / W;
            assert_true(cut[y][x] == wide[y][x + 20]);
        }
    }
}

/* In a sphere a light has its cone's pixels: the same all around, over the seam, and even
 * around a pole; their light by solid angle is that of its flux at the equator. */
static void a_cone_is_the_same_all_around(void **state)
{
    static const double rows[] = {22.0, 13.3, 8.4, 7.0}; // the last: the pole
    (void) state;
    for (int k = 0; k < 4 * W; k++) {
        float first[H][W] = {{0}}, other[H][W] = {{0}};
        const int turn = k % W;
        double sum = 0.0;
        for (int i = 0; i < 2; i++) {
            const struct gp_light l = {
                .x = 10.25 + (i ? turn - (turn > 20 ? W : 0) : 0),
                .y = rows[k / W],
                .radius = 2.0,
                .flux = {1000.0f},
                .visibility = 0.5,
                .sight = {.known = true, .half = 0.25}};
            struct gp_sources s;
            assert_true(join_in(&l, 0, true, &s));
            for (int y = 0; y < H; y++) {
                for (uint32_t q = s.row[y]; q < s.row[y + 1]; q++)
                    (i ? other : first)[y][s.x[q]] += s.rgb[0][q];
            }
            gp_sources_free(&s);
        }
        for (int i = 0; i < W * H; i++) {
            const float a = first[i / W][i % W];
            const float b = other[i / W][(i % W + turn) % W];
            sum += (double) a * cos((i / W + 0.5 - H / 2.0) * (M_PI / H));
            assert_true(fabsf(a - b) < 1e-4f);
        }
        assert_true(fabs(sum - 500.0) < 1e-3);
        // a crop of it has the same pixels
        const struct gp_light l = {.x = 10.25 + turn - (turn > 20 ? W : 0),
                                   .y = rows[k / W],
                                   .radius = 2.0,
                                   .flux = {1000.0f},
                                   .visibility = 0.5,
                                   .sight = {.known = true, .half = 0.25}};
        struct gp_sources cut;
        if (join_in(&l, -20, true, &cut)) {
            for (int y = 0; y < H; y++) {
                for (uint32_t q = cut.row[y]; q < cut.row[y + 1]; q++)
                    assert_true(fabsf(cut.rgb[0][q] - other[y][20 + cut.x[q]]) <
                                1e-4f);
            }
            gp_sources_free(&cut);
        }
        assert_true(k / W < 3 || fabsf(first[0][0] - first[0][W / 2]) < 1e-4f);
    }
}

/* The engines have no pixels beyond the frame for a light. */
static void lights_beyond_the_frame_are_no_sources(void **state)
{
    static const double x[] = {-10.0, 44.0, -90.0, 1e300, -1e9, NAN};
    for (size_t i = 0; i < COUNT(x); i++) {
        struct gp_sources s;
        const struct gp_light l = {.x = x[i], .y = 15.0, .radius = 6.0,
                                   .flux = {1.0f}, .visibility = 1.0};
        assert_false(join(&l, &s));
    }
}

/* The kernel must reach from lights beside the frame to its far side, but not for
 * those in it, behind the camera, hidden, without flux, or too far for numbers. */
static void offsets_reach_the_far_side(void **state)
{
    static const struct {
        struct gp_light l;
        int x, y;
    } rows[] = {
        {{.x = 20, .y = 15, .radius = 3, .visibility = 1}, 0, 0},
        {{.x = -50, .y = 15, .radius = 3, .visibility = 1}, 95, 20},
        {{.x = 20, .y = 80, .radius = 3, .visibility = 1}, 25, 85},
        {{.x = 1.5, .y = 15, .radius = 3, .visibility = 1}, 43, 20},
        {{.x = -50, .y = 15, .radius = 3, .visibility = 0}, 0, 0},
        {{.x = -50, .y = 15, .radius = 3, .visibility = 1, .behind = true}, 0,
         0},
        {{.x = -1e12, .y = 15, .radius = 3, .visibility = 1}, 0, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct glarepp_light_params p = {0};
        struct gp_light l = rows[i].l;
        const struct gp_suns suns = {.p = &p, .light = &l, .n = 1};
        int offset[2];
        for (int flux = 0; flux < 2; flux++) {
            l.flux[1] = (float) flux;
            gp_suns_offsets(&suns, (struct gp_rect) {0, 0, W, H}, offset);
            if (offset[0] != flux * rows[i].x || offset[1] != flux * rows[i].y)
                fail_msg("light %d: %d, %d", (int) i, offset[0], offset[1]);
        }
    }
}

SUITE_OF(stage_light, NULL, NULL, a_disc_keeps_flux_and_place,
         a_disc_across_the_border_is_cut, a_cone_is_the_same_all_around,
         lights_beyond_the_frame_are_no_sources, offsets_reach_the_far_side)
