/* Every way to find a share before a fence that slides, and exact areas against
 * the truth beside the data's frames (of masks: tests/cli/sun.t). Their folder
 * is data_path()'s; without it that test skips. */
#include "scene.h"
#include "io/channels.h"
#include "reading.h"

#include <jansson.h>

// -- a fence that slides -----------------------------------------------------

enum { BAR = 3, PERIOD = 8, STEPS = 8, FENCE_W = 64, FENCE_H = 48 };

/* Bars BAR wide every PERIOD pixels, `shift` eighths of a pixel to the right:
 * a pixel's coverage, or its centre's depth. */
static void draw_fence(struct gp_plane *p, int shift, bool coverage)
{
    for (int x = 0; x < FENCE_W; x++) {
        int eighths = 0;
        for (int k = 0; k < STEPS; k++) {
            const int at = STEPS * (x + 4 * PERIOD) + k - shift;
            eighths += at % (STEPS * PERIOD) < STEPS * BAR;
        }
        for (int y = 0; y < FENCE_H; y++)
            p->v[y * FENCE_W + x] = coverage        ? (float) eighths / STEPS
                                    : eighths >= 4 ? 5.0f
                                                   : 1e10f;
    }
}

/* The share between the bars: eight times as large, all edges are whole. */
static double fence_truth(double x, double y, double r, int shift)
{
    const double all = M_PI * r * r * STEPS * STEPS;
    double hidden = 0.0;
    for (int bar = -4; bar < FENCE_W / PERIOD + 1; bar++) {
        const int x0 = STEPS * PERIOD * bar + shift;
        hidden += gp_disc_rect_area(STEPS * x, STEPS * y, STEPS * r, x0, -9999,
                                    x0 + STEPS * BAR, 9999);
    }
    return 1.0 - hidden / all;
}

/* A step of 1/8 pixel moves each edge that crosses the disc over at most 1/8
 * of the pixels of a column of it: no more can change. Depth, which has no
 * coverage, waits for a pixel's centre and then moves by all of it. */
static void exact_follows_a_fence(void **state)
{
    static const double at[][3] = {{32, 24, 2.48}, {31.3, 23.8, 0.45},
                                   {32.5, 24.5, 6}, {30.1, 24.2, 15}};
    struct gp_plane p = plane_of((struct gp_rect) {0, 0, FENCE_W, FENCE_H});
    for (int i = 0; i < 8; i++) {
        const double x = at[i / 2][0], y = at[i / 2][1], r = at[i / 2][2];
        const bool coverage = i % 2;
        const double edges = 2.0 * ceil((2.0 * r + 2.0) / PERIOD) + 1.0;
        // that an edge may sweep in a pixel, as a share of the disc
        const double column = fmin(M_PI * r * r, 2.0 * r) / (M_PI * r * r);
        const double most = (coverage ? 1.0 / STEPS : 1.0) * edges * column;
        double last = -1.0, largest = 0.0, error = 0.0;
        for (int shift = 0; shift <= 2 * STEPS * PERIOD; shift++) {
            draw_fence(&p, shift, coverage);
            const struct gp_occluders o = occluders(
                coverage ? NULL : &p, coverage ? &p : NULL, p.window);
            const double truth = fence_truth(x, y, r, shift);
            struct gp_light l = light_at(x, y, r);
            gp_sun_exact(&o, GP_OUTSIDE_IGNORE, &l, 1);
            gp_sun_interval(&o, GP_OUTSIDE_IGNORE, &l, 1);
            assert_true(l.low <= truth + 1e-12 && l.high >= truth - 1e-12);
            const double got = l.visibility;
            error = fmax(error, fabs(got - truth));
            if (last >= 0.0)
                largest = fmax(largest, fabs(got - last));
            last = got;
        }
        print_message("fence, r %g, %s: largest step %.4f (bound %.4f), worst "
                      "error %.4f\n", r, coverage ? "mask" : "depth", largest,
                      most, error);
        assert_true(largest > 0.0 && largest <= fmin(most, 1.0) + 1e-12);
        // a pixel's coverage says how much of it is hidden, not which part;
        // the centre alone misses by half a pixel for each edge
        assert_true(error <= (coverage ? 0.25 / fmax(r, 0.5)
                                       : 0.5 * edges * column));
    }
    gp_plane_free(&p);
}

/* Coverage lets every method move in small steps: an edge of the fence sweeps
 * 12 of the disc's 113 square pixels in a step at most, and 4 cross it. */
static void masks_follow_a_fence(void **state)
{
    // 8 bits round each grey texel's 1/255 to all or nothing; a square sees
    // more than the disc
    static const struct {
        const char *name;
        struct gp_map_params p;
        bool readback;
        double most, worst; // bars of step and error
    } curves[] = {
        {"mask 4", {.side = 4}, false, 0.04, 0.04},
        {"mask 16", {.side = 16}, false, 0.04, 0.04},
        {"mask 64", {.side = 64}, false, 0.04, 0.005},
        {"mask 16 bilinear", {.side = 16, .sum = GP_SUM_BILINEAR}, false, 0.04,
         0.04},
        {"mask 16 8bit", {.side = 16, .sum = GP_SUM_BYTE}, false, 0.25, 0.25},
        {"mask 16 square", {.side = 16, .pattern = GP_PATTERN_SQUARE}, false,
         0.06, 0.12},
        {"readback", {.side = 16}, true, 0.04, 0.04},
    };
    struct gp_plane mask = plane_of((struct gp_rect) {0, 0, FENCE_W, FENCE_H});
    const struct gp_occluders o = {.mask = &mask, .frame = mask.window};
    for (size_t k = 0; k < COUNT(curves) * (size_t) machine_count; k++) {
        const size_t c = k % COUNT(curves);
        struct machine *const m = machine_at((int) (k / COUNT(curves)));
        double last = -1.0, step = 0.0, error = 0.0;
        for (int shift = 0; shift < 2 * STEPS * PERIOD; shift++) {
            struct gp_light l = light_at(31.3, 23.8, 6.0);
            draw_fence(&mask, shift, true);
            const double exact = visibility(&o, GP_OUTSIDE_IGNORE, l);
            measure(m, &o, &curves[c].p, curves[c].readback, &l, 1);
            step = last < 0.0 ? 0.0 : fmax(step, fabs(l.visibility - last));
            error = fmax(error, fabs(l.visibility - exact));
            last = l.visibility;
        }
        print_message("fence, %s: largest step %.4f, worst error %.4f\n",
                      curves[c].name, step, error);
        assert_true(step > 0.0 && step < curves[c].most);
        assert_true(error < curves[c].worst);
    }
    gp_plane_free(&mask);
}

/* Floats of the channel called `name`. */
static struct gp_plane channel_of(const struct gp_frame *f, const char *name)
{
    struct gp_plane p = plane_of(f->data);
    int index;
    assert_ok(gp_find_depth(&kept_log, f, name, NULL, &index));
    gp_channel_floats(f, index, p.v);
    return p;
}

static void frames_of_the_data(void **state)
{
    static const char *const stems[] = {
        "seq_foliage/foliage", "seq_foliage/foliage_f32", "rendered/window",
        "rendered/brightsky", "rendered/night"};
    double worst_z = 0.0, worst_a = 0.0;
    int frames = 0;
    for (size_t i = 0; i < COUNT(stems); i++) {
        char stem[4096], name[4200];
        snprintf(stem, sizeof stem, "%s", data_path(stems[i]));
        snprintf(name, sizeof name, "%s.camera.json", stem);
        json_t *const root = json_load_file(name, 0, NULL);
        const json_t *const list = json_object_get(root, "frames");
        for (size_t k = 0; k < json_array_size(list); k++) {
            const json_t *const frame = json_array_get(list, k);
            const json_t *const by_depth =
                json_object_get(frame, "sun_visibility_depth");
            const json_t *const by_alpha =
                json_object_get(frame, "sun_visibility_alpha");
            const json_t *const at =
                json_object_get(frame, "sun_pixel_xy_depth");
            struct gp_light l = light_at(
                json_number_value(json_array_get(at, 0)),
                json_number_value(json_array_get(at, 1)),
                json_number_value(json_object_get(frame, "sun_radius_px")));
            struct gp_frame f;
            if (!by_depth)
                continue;
            l.depth = json_number_value(json_array_get(at, 2));
            snprintf(name, sizeof name, "%s.%lld.exr", stem, (long long)
                     json_integer_value(json_object_get(frame, "frame")));
            assert_ok(read_file(name, &f));
            struct gp_plane z = channel_of(&f, "Z"), a = channel_of(&f, "A");
            const struct gp_occluders by_z = occluders(&z, NULL, f.data);
            const struct gp_occluders by_a = occluders(NULL, &a, f.data);
            worst_z = fmax(worst_z, fabs(visibility(&by_z, 0, l) -
                                         json_number_value(by_depth)));
            worst_a = fmax(worst_a, fabs(visibility(&by_a, 0, l) -
                                         json_number_value(by_alpha)));
            frames++;
            gp_plane_free(&z);
            gp_plane_free(&a);
            gp_frame_free(&f);
        }
        json_decref(root);
    }
    if (frames == 0)
        skip_for(NO_DATA);
    print_message("%d frames: exact to truth, worst by depth %.4f, by mask "
                  "%.4f\n", frames, worst_z, worst_a);
    assert_true(worst_z <= 0.02 && worst_a <= 0.02);
}

SUITE_OF(truth, open_machines, close_machines, exact_follows_a_fence,
         masks_follow_a_fence, frames_of_the_data)
