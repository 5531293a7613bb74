/* sun/exact over sequences: a fence that slides before a light, and the truth
 * beside the data's frames. Their folder is $GLAREPP_DATA, or ../shared/data;
 * without it that test skips. */
#include "unit.h"
#include "io/channels.h"
#include "sun/sun_priv.h"

#include "reading.h"
#include "sun_scene.h"

#include <jansson.h>

/* -- a fence that slides --------------------------------------------------- */

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
static void check_fence(double x, double y, double r, bool coverage)
{
    struct gp_plane p = plane_of((struct gp_rect) {0, 0, FENCE_W, FENCE_H});
    const double edges = 2.0 * ceil((2.0 * r + 2.0) / PERIOD) + 1.0;
    const double column = fmin(M_PI * r * r, 2.0 * r);
    const double most = (coverage ? 1.0 / STEPS : 1.0) * edges * column /
                        (M_PI * r * r);
    double last = -1.0, largest = 0.0, error = 0.0;
    for (int shift = 0; shift <= 2 * STEPS * PERIOD; shift++) {
        draw_fence(&p, shift, coverage);
        const struct gp_occluders o = occluders(
            coverage ? NULL : &p, coverage ? &p : NULL, p.window);
        const double got = visibility(&o, 0, light_at(x, y, r));
        error = fmax(error, fabs(got - fence_truth(x, y, r, shift)));
        if (last >= 0.0)
            largest = fmax(largest, fabs(got - last));
        last = got;
    }
    print_message("fence, r %g, %s: largest step %.4f (bound %.4f), worst "
                  "error %.4f\n", r, coverage ? "mask" : "depth", largest, most,
                  error);
    assert_true(largest > 0.0 && largest <= fmin(most, 1.0) + 1e-12);
    // a pixel's coverage says how much of it is hidden, not which part; the
    // centre alone misses by half a pixel for each edge
    assert_true(error <= (coverage ? 0.25 / fmax(r, 0.5)
                                   : 0.5 * edges * column / (M_PI * r * r)));
    gp_plane_free(&p);
}

static void test_fence(void **state)
{
    (void) state;
    static const double at[][3] = {{32, 24, 2.48}, {31.3, 23.8, 0.45},
                                   {32.5, 24.5, 6}, {30.1, 24.2, 15}};
    for (int i = 0; i < 4; i++) {
        check_fence(at[i][0], at[i][1], at[i][2], true);
        check_fence(at[i][0], at[i][1], at[i][2], false);
    }
}

/* -- the data's truth ------------------------------------------------------ */

/* Floats of the channel called `name`. */
static struct gp_plane channel_of(const struct gp_frame *f, const char *name)
{
    struct gp_plane p = plane_of(f->data);
    int index;
    assert_int_equal(gp_find_depth(&hear, f, name, &index), GP_OK);
    gp_channel_floats(f, index, p.v);
    return p;
}

/* One frame of a .camera.json; errors of depth alone, the mask alone. */
static void frame_errors(const char *stem, const json_t *frame,
                         double error[2])
{
    const json_t *const at = json_object_get(frame, "sun_pixel_xy_depth");
    struct gp_light l = light_at(
        json_number_value(json_array_get(at, 0)),
        json_number_value(json_array_get(at, 1)),
        json_number_value(json_object_get(frame, "sun_radius_px")));
    l.depth = json_number_value(json_array_get(at, 2));
    char name[600];
    snprintf(name, sizeof name, "%s.%lld.exr", stem,
             (long long) json_integer_value(json_object_get(frame, "frame")));
    struct gp_frame f;
    assert_int_equal(read_file(name, &f), GP_OK);
    struct gp_plane z = channel_of(&f, "Z"), a = channel_of(&f, "A");
    const struct gp_occluders by_z = occluders(&z, NULL, f.data);
    const struct gp_occluders by_a = occluders(NULL, &a, f.data);
    error[0] = visibility(&by_z, 0, l) -
               json_number_value(json_object_get(frame,
                                                 "sun_visibility_depth"));
    error[1] = visibility(&by_a, 0, l) -
               json_number_value(json_object_get(frame,
                                                 "sun_visibility_alpha"));
    gp_plane_free(&z);
    gp_plane_free(&a);
    gp_frame_free(&f);
}

static void test_truth(void **state)
{
    (void) state;
    static const char *const stems[] = {
        "seq_foliage/foliage", "seq_foliage/foliage_f32", "rendered/window",
        "rendered/brightsky", "rendered/night"};
    const char *const data = getenv("GLAREPP_DATA");
    int frames = 0;
    double worst[2] = {0.0};
    for (int i = 0; i < 5; i++) {
        char stem[400], name[500];
        snprintf(stem, sizeof stem, "%.300s/%s", data ? data : "../shared/data",
                 stems[i]);
        snprintf(name, sizeof name, "%s.camera.json", stem);
        json_t *const root = json_load_file(name, 0, NULL);
        const json_t *const list = json_object_get(root, "frames");
        for (size_t k = 0; k < json_array_size(list); k++) {
            const json_t *const frame = json_array_get(list, k);
            if (!json_object_get(frame, "sun_visibility_depth"))
                continue;
            double error[2];
            frame_errors(stem, frame, error);
            worst[0] = fmax(worst[0], fabs(error[0]));
            worst[1] = fmax(worst[1], fabs(error[1]));
            frames++;
        }
        json_decref(root);
    }
    if (frames == 0)
        skip();
    print_message("%d frames: worst error by depth %.4f, by mask %.4f\n",
                  frames, worst[0], worst[1]);
    assert_true(worst[0] <= 0.02 && worst[1] <= 0.02);
}

SUITE_OF(sun_truth, NULL, NULL,
    test_fence, test_truth)
