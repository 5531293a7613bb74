/* sun/stage_light: a light's disc in pixels. */
#include "unit.h"
#include "sun/sun_priv.h"
#include "core/memory.h"

enum { W = 40, H = 30, MOST = 4096 };

/* Flux is kept and the centroid is the light's place, wherever it stands. */
static void a_disc_keeps_flux_and_place(void **state)
{
    static const double radius[] = {0.0, 0.3, 0.5, 0.51, 1.0, 2.48, 7.9};
    static const struct gp_rect frame = {-3, 7, -3 + W, 7 + H};
    for (int r = 0; r < 7; r++) {
        struct gp_disc_pixels d;
        assert_ok(gp_disc_pixels_make(NULL, radius[r], &d));
        for (int step = 0; step < 64; step++) {
            struct gp_source list[MOST];
            size_t n = 0;
            double sum = 0.0, x = 0.0, y = 0.0; // from the frame's corner
            const struct gp_light l = {
                .x = 14.0 + step / 8.0, .y = 20.0 + step / 32.0,
                .radius = radius[r], .flux = {1000.0f, 10.0f, 1.0f},
                .visibility = 0.25,
            };
            gp_disc_light(&d, &l, frame, list, &n);
            for (size_t i = 0; i < n; i++) {
                sum += (double) list[i].rgb[0];
                x += (double) list[i].rgb[0] * (list[i].x + 0.5);
                y += (double) list[i].rgb[0] * (list[i].y + 0.5);
            }
            assert_true(fabs(sum / 250.0 - 1.0) < 1e-6);
            assert_true(fabs(x / sum - 3.0 - l.x) < 1e-5);
            assert_true(fabs(y / sum + 7.0 - l.y) < 1e-5);
        }
        gp_free(d.weight);
    }
}

/* Beyond the frame there is no pixel, and no light either. */
static void a_disc_is_cut_to_the_frame(void **state)
{
    static const struct { double x, y, share; } row[] = {
        {0.0, 15.0, 0.5}, {0.0, 0.0, 0.25}, {40.0, 15.0, 0.5},
        {-90.0, 15.0, 0.0}, {1e300, 15.0, 0.0}, {-1e9, -1e9, 0.0},
    };
    struct gp_disc_pixels d;
    assert_ok(gp_disc_pixels_make(NULL, 6.0, &d));
    for (int i = 0; i < 6; i++) {
        struct gp_source list[MOST];
        size_t n = 0;
        double total = 0.0;
        const struct gp_light l = {
            .x = row[i].x, .y = row[i].y, .radius = 6.0,
            .flux = {1.0f, 1.0f, 1.0f}, .visibility = 1.0,
        };
        gp_disc_light(&d, &l, (struct gp_rect) {0, 0, W, H}, list, &n);
        for (size_t k = 0; k < n; k++)
            total += (double) list[k].rgb[0];
        assert_true(fabs(total - row[i].share) < 1e-6);
    }
    gp_free(d.weight);
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
        const struct gp_sun_params p = GP_SUN_DEFAULTS;
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
         a_disc_is_cut_to_the_frame, offsets_reach_the_far_side)
