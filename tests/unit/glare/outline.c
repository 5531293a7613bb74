/* glare/splat/outline.c: the rims of the polygons that splat draws. */
#include "unit.h"
#include "glare_scene.h"

#include "glare/splat/polygons.h"

enum { W = 60, H = 50 };

/* A black frame with lights of 2 at these pixels. */
static struct scene lights(const int (*at)[2], int n, struct gp_kernel k)
{
    const struct gp_sensor_params p = GP_SENSOR_DEFAULTS;
    struct gp_frame f = scene_frame(W, H, -7, 3, DARK, 1);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < n; i++)
            f.rgb.c[c][at[i][1] * W + at[i][0]] = 2.0f;
    }
    return scene_sense(f, k, &p);
}

/* A picture of 0.25 with the outlines drawn over it. */
static struct gp_planes outlined(const struct scene *s,
                                 const struct gp_splat_params *p)
{
    const size_t n = gp_frame_pixels(&s->f);
    struct gp_planes picture;
    assert_int_equal(gp_planes_make(NULL, "picture", n, &picture), GP_OK);
    for (size_t i = 0; i < 3 * n; i++)
        picture.c[i / n][i % n] = 0.25f;
    assert_int_equal(gp_polygons_outline(NULL, &s->src, &s->k, p, &picture),
                     GP_OK);
    return picture;
}

/* True where it is green; whatever is not green is as it was. */
static bool green(const struct gp_planes *p, int x, int y)
{
    const size_t i = (size_t) y * W + (size_t) x;
    const bool is = p->c[1][i] == 1.0f;
    for (int c = 0; c < 3; c++)
        assert_true(p->c[c][i] == (is ? (float) (c == 1) : 0.25f));
    return is;
}

struct box {
    int x0, y0, x1, y1; // of pixels, the last included
};

static bool on_rim(const struct box *b, int x, int y)
{
    const bool inside =
        x >= b->x0 && x <= b->x1 && y >= b->y0 && y <= b->y1;
    return inside && (x == b->x0 || x == b->x1 || y == b->y0 || y == b->y1);
}

/* Each source is a polygon as large as the kernel, whatever its centre; what
 * leaves the frame has no rim there. */
static void single_sensors_have_the_kernels_box(void **state)
{
    static const struct {
        int at[2];
        int w, h, cx, cy;
        struct box box;
    } rows[] = {
        {{30, 20}, 9, 7, MID, MID, {26, 17, 34, 23}},
        {{30, 20}, 8, 6, MID, MID, {26, 17, 33, 22}},
        {{30, 20}, 1, 1, MID, MID, {30, 20, 30, 20}},
        {{30, 20}, 9, 7, 0, 6, {30, 14, 38, 20}},
        {{30, 20}, 9, 7, -5, 3, {35, 17, 43, 23}},  // centre outside
        {{2, 49}, 9, 7, MID, MID, {-2, 46, 6, 52}},
        {{59, 0}, 9, 7, MID, MID, {55, -3, 63, 3}},
        {{30, 20}, 301, 299, MID, MID, {-120, -129, 180, 169}}, // none seen
    };
    const struct gp_splat_params p = GP_SPLAT_EXACT;
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s = lights(&rows[i].at, 1,
                                scene_kernel(rows[i].w, rows[i].h, rows[i].cx,
                                             rows[i].cy, BOX));
        struct gp_planes picture = outlined(&s, &p);
        for (int y = 0; y < H; y++) {
            for (int x = 0; x < W; x++) {
                if (green(&picture, x, y) != on_rim(&rows[i].box, x, y))
                    fail_msg("row %zu: pixel %d, %d", i, x, y);
            }
        }
        gp_planes_free(&picture);
        scene_free(&s);
    }
}

/* Two lights of a block of four are one polygon around their middle; a third
 * alone has its own. */
static void groups_have_one(void **state)
{
    // pixel (0, 0) of the frame is (-7, 3) of EXR pixel space: blocks of 4
    // start at column 3, row 1
    static const int at[][2] = {{19, 17}, {21, 19}, {40, 30}};
    static const struct box boxes[] = {{16, 14, 24, 22}, {36, 26, 44, 34}};
    const struct gp_splat_params p = {.group = 4, .cluster_fill = 0.9f};
    (void) state;
    struct scene s = lights(at, 3, scene_kernel(9, 9, MID, MID, BOX));
    struct gp_planes picture = outlined(&s, &p);
    for (int y = 0; y < H; y++) {
        for (int x = 0; x < W; x++)
            assert_int_equal(green(&picture, x, y),
                             on_rim(&boxes[0], x, y) ||
                                 on_rim(&boxes[1], x, y));
    }
    gp_planes_free(&picture);
    scene_free(&s);
}

/* Against the polygons one by one, with blurs, clusters and shrinking: every
 * rim inside the frame is drawn, and nothing else. */
static void all_that_are_drawn_have_one(void **state)
{
    static const struct gp_splat_params rows[] = {
        GP_SPLAT_DEFAULTS,
        {.group = 1, .cluster_fill = 0.9f, .shrink = 0.2f},
        {.group = 2, .cluster = 8, .cluster_fill = 0.3f, .shrink = 0.1f,
         .method = GP_GROUP_MOMENTS},
        {.group = 8, .cluster_fill = 0.9f, .method = GP_GROUP_MOMENTS},
    };
    const struct gp_sensor_params sensors = GP_SENSOR_DEFAULTS;
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s = scene_sense(scene_frame(W, H, -7, 3, BLOCK, 5),
                                     scene_kernel(31, 20, MID, MID, PEAK),
                                     &sensors);
        struct gp_polygons polygons;
        struct gp_shrink shrink;
        assert_int_equal(gp_polygons_make(NULL, &s.src, &rows[i], &polygons),
                         GP_OK);
        assert_int_equal(gp_shrink_make(NULL, &s.k, &rows[i], &polygons,
                                        &shrink), GP_OK);
        struct gp_planes picture = outlined(&s, &rows[i]);
        static bool want[H][W];
        memset(want, 0, sizeof want);
        for (size_t k = 0; k < polygons.n; k++) {
            const struct gp_polygon *const q = &polygons.at[k];
            const double reach = shrink.reach[gp_source_bin(q->light)];
            const double m = (gp_blur_box[q->blur] - 1) / 2.0;
            const double x = (double) q->x, y = (double) q->y;
            // pixels that the blurred kernel's samples lie around
            const struct box b = {
                (int) ceil(x - fmin(reach, 15 + m)),
                (int) ceil(y - fmin(reach, 10 + m)),
                (int) floor(x + fmin(reach, 15 + m)),
                (int) floor(y + fmin(reach, 9 + m)),
            };
            for (int j = 0; j < W * H; j++)
                want[j / W][j % W] |= on_rim(&b, j % W, j / W);
        }
        for (int j = 0; j < W * H; j++)
            assert_int_equal(green(&picture, j % W, j / W),
                             want[j / W][j % W]);
        gp_polygons_free(&polygons);
        gp_planes_free(&picture);
        scene_free(&s);
    }
}

static void no_light_no_line(void **state)
{
    const struct gp_splat_params p = GP_SPLAT_DEFAULTS;
    (void) state;
    struct scene s = lights(NULL, 0, scene_kernel(9, 9, MID, MID, PEAK));
    struct gp_planes picture = outlined(&s, &p);
    for (int i = 0; i < W * H; i++)
        assert_false(green(&picture, i % W, i / W));
    gp_planes_free(&picture);
    scene_free(&s);
}

SUITE_OF(outline, NULL, NULL,
    single_sensors_have_the_kernels_box, groups_have_one,
    all_that_are_drawn_have_one, no_light_no_line)
