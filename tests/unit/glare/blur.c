/* glare/splat/blur.c: the kernel blurred by boxes, against the plain sum; how
 * far polygons reach; and the picture of their rims. */
#include "unit.h"
#include "glare/splat/polygons.h"
#include "glare_scene.h"

/* -- blurs ------------------------------------------------------------------*/

struct blur_row {
    int w, h, cx, cy;
    enum shape shape;
    struct gp_rect crop; // all zero: the whole kernel
    bool tail;
    int side;
};

static const struct blur_row blur_rows[] = {
    {1, 1, MID, 0, BOX, {0}, false, 1}, {1, 1, MID, 0, BOX, {0}, false, 64},
    {1, 1, MID, 0, BOX, {0}, true, 4}, {9, 7, MID, 0, TINTED, {0}, false, 2},
    {9, 7, MID, 0, LOBES, {0}, false, 3},
    {10, 8, MID, 0, TINTED, {0}, false, 4},
    {31, 18, MID, 0, PEAK, {0}, true, 6}, {31, 18, 3, 17, TINTED, {0}, true, 8},
    {31, 18, -20, 5, TINTED, {0}, true, 12},
    {63, 65, MID, 0, TINTED, {0}, true, 16},
    {64, 66, MID, 0, LOBES, {0}, false, 5}, // no box of the list
    {129, 70, MID, 0, PEAK, {0}, false, 32},
    {200, 3, MID, 0, RING, {0}, true, 64},
    {61, 47, MID, 0, TINTED, {10, 5, 40, 47}, true, 4},
    {61, 47, MID, 0, TINTED, {0, 0, 1, 1}, false, 3},
    {61, 47, MID, 0, PEAK, {-5, -5, 100, 9}, false, 2},
    {61, 47, 2000000, 5, PEAK, {0}, true, 2},
};

static struct gp_rect crop_of(const struct blur_row *r)
{
    return gp_rect_empty(r->crop) ? (struct gp_rect) {0, 0, r->w, r->h}
                                  : r->crop;
}

/* Sample (x, y) of the cut kernel without its core. */
static double cut_sample(const struct gp_kernel *k, const struct blur_row *r,
                         struct gp_rect crop, int c, int x, int y)
{
    x += crop.x0;
    y += crop.y0;
    if (x < crop.x0 || x >= crop.x1 || y < crop.y0 || y >= crop.y1)
        return 0.0;
    if (r->tail && abs(x - k->cx) <= GP_CORE_RADIUS &&
        abs(y - k->cy) <= GP_CORE_RADIUS)
        return 0.0;
    return (double) k->k.c[c][y * k->w + x];
}

static double box_mean(const struct gp_kernel *k, const struct blur_row *r,
                       struct gp_rect crop, int c, int x, int y)
{
    double sum = 0.0;
    for (int j = 0; j < r->side; j++) {
        for (int i = 0; i < r->side; i++)
            sum += cut_sample(k, r, crop, c, x - i, y - j);
    }
    return sum / ((double) r->side * r->side);
}

static void check_blur(const struct gp_kernel *k, const struct blur_row *r,
                       const struct gp_blur *b)
{
    const struct gp_rect crop = gp_rect_meet(
        crop_of(r), (struct gp_rect) {0, 0, k->w, k->h});
    const float half = 0.5f * (float) (r->side - 1);
    assert_int_equal(b->w, gp_rect_w(crop) + r->side - 1);
    assert_int_equal(b->h, gp_rect_h(crop) + r->side - 1);
    assert_true(b->cx == (float) (k->cx - crop.x0) + half);
    assert_true(b->cy == (float) (k->cy - crop.y0) + half);
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, want_sum = 0.0;
        for (int i = 0; i < b->w * b->h; i++) {
            const double got = (double) b->k.c[c][i];
            const double want = box_mean(k, r, crop, c, i % b->w, i / b->w);
            sum += got;
            if (fabs(got - want) > 1e-7 * fabs(want) + 1e-20)
                fail_msg("box %d, channel %d, sample %d: %g in place of %g",
                         r->side, c, i, got, want);
        }
        for (int i = 0; i < gp_rect_w(crop) * gp_rect_h(crop); i++)
            want_sum += cut_sample(k, r, crop, c, i % gp_rect_w(crop),
                                   i / gp_rect_w(crop));
        assert_true(fabs(sum - want_sum) <= 1e-6 * (fabs(want_sum) + 1e-3));
    }
}

static void blurs_are_box_means(void **state)
{
    for (size_t i = 0; i < COUNT(blur_rows); i++) {
        const struct blur_row *const r = &blur_rows[i];
        struct gp_kernel k = scene_kernel(r->w, r->h, MID, 0, r->shape);
        struct gp_blur b;
        if (r->cx != MID) { // (a kernel made there is the same)
            k.cx = r->cx;
            k.cy = r->cy;
        }
        assert_ok(gp_blur_make(NULL, &k, crop_of(r), r->tail, r->side, &b));
        assert_int_equal(b.grey, k.grey);
        check_blur(&k, r, &b);
        gp_blur_free(&b);
        gp_blur_free(&b); // twice is harmless
        gp_kernel_free(&k);
    }
}

static void nothing_left_is_an_empty_blur(void **state)
{
    struct gp_kernel k = scene_kernel(9, 9, MID, 0, PEAK);
    struct gp_blur b;
    assert_ok(
        gp_blur_make(NULL, &k, (struct gp_rect){20, 0, 30, 9}, false, 4, &b));
    assert_true(b.w == 0 && b.h == 0);
    gp_blur_free(&b);
    gp_kernel_free(&k);
}

static void no_memory_leaves_nothing(void **state)
{
    // sanitizers and valgrind take such a request for an error
    if (getenv("GLAREPP_TEST_QUICK"))
        skip_for("quick");
    struct gp_kernel k = {.w = INT_MAX - 64, .h = INT_MAX - 64};
    struct gp_blur b = {.w = 3};
    assert_int_equal(gp_blur_make(NULL, &k, (struct gp_rect) {0, 0, k.w, k.h},
                                  false, 2, &b), GP_ERR_BUG);
    assert_int_equal(b.w, 3);
}

/* -- shrinking --------------------------------------------------------------*/

/* Light of the kernel's samples more than `reach` away, over its whole, the
 * largest channel. Without its core when `tail`. */
static double beyond(const struct gp_kernel *k, int reach, bool tail)
{
    double worst = 0.0;
    for (int c = 0; c < 3; c++) {
        double sum = 0.0;
        for (int i = 0; i < k->w * k->h; i++) {
            const int dx = abs(i % k->w - k->cx), dy = abs(i / k->w - k->cy);
            const int d = dx > dy ? dx : dy;
            if (d > reach && !(tail && d <= GP_CORE_RADIUS))
                sum += fabs((double) k->k.c[c][i]);
        }
        worst = fmax(worst, sum / k->norm1[c]);
    }
    return worst;
}

struct shrink_row {
    int w, h, cx, cy;
    enum shape shape;
    bool tail; // beside the core
    float share;
    float brightest; // light of the polygons: from 1e-6 of that up
};

static const struct shrink_row shrink_rows[] = {
    {101, 101, MID, 0, PEAK, false, 1e-3f, 100},
    {101, 101, MID, 0, PEAK, true, 1e-2f, 100},
    {101, 61, MID, 0, TINTED, false, 0.2f, 100},
    {40, 64, 3, 60, TINTED, true, 0.05f, 1},
    {40, 64, -30, 20, TINTED, false, 0.05f, 1},
    {40, 64, 90, 20, TINTED, true, 0.05f, 1},
    {61, 61, MID, 0, RING, false, 0.5f, 1},
    {61, 61, MID, 0, LOBES, false, 0.1f, 1},
    {1, 1, MID, 0, BOX, false, 0.5f, 1},
    {1, 1, MID, 0, BOX, true, 0.5f, 1},
    {61, 61, MID, 0, PEAK, false, 0.999f, 1e30f},
    {61, 61, MID, 0, PEAK, true, 0.999f, 3e38f},
    {61, 61, MID, 0, PEAK, false, 1e-2f, 1e-37f},
    {61, 61, MID, 0, PEAK, false, 1e-7f, 1},
};

enum { LIGHTS = 60 };

static struct gp_polygons lights(float brightest, struct gp_polygon *at)
{
    for (int i = 0; i < LIGHTS; i++)
        at[i] = (struct gp_polygon) {
            .light = brightest * powf(10.0f, -0.1f * (float) i),
            .side = 8, .blur = (uint8_t) (i % 6),
        };
    return (struct gp_polygons) {LIGHTS, LIGHTS, 0, at};
}

/* The boxes above carry samples up to 5 pixels from where they were. */
static void check_shrink(const struct gp_kernel *k, const struct shrink_row *r,
    double share, const struct gp_polygons *q, const struct gp_shrink *s,
    const char *what)
{
    const bool tail = r->tail;
    double left = 0.0, all = 0.0;
    for (size_t i = 0; i < q->n; i++) {
        const double light = (double) q->at[i].light;
        const int reach = s->reach[gp_source_bin(q->at[i].light)];
        left += light * beyond(k, reach - 5, tail);
        all += light;
    }
    if (left > share * all * (1.0 + 1e-9) ||
        s->left_out > share || left > s->left_out * all * (1.0 + 1e-9))
        fail_msg("%s: %g left out, %g said, %g allowed", what, left / all,
                 s->left_out, share);
    for (int b = 0; b < GP_SOURCE_BINS; b++) {
        assert_true(s->reach[b] >= (tail ? GP_CORE_RADIUS : 0));
        assert_true(b == 0 || s->reach[b] >= s->reach[b - 1]);
    }
}

/* One step over `least` leaves too much out, or all that there is. */
static void check_largest(const struct gp_kernel *k, const struct shrink_row *r,
    const struct gp_polygons *q, const struct gp_shrink *s)
{
    const bool tail = r->tail;
    const double least = (double) nextafterf(s->least, INFINITY);
    double left = 0.0, all = 0.0;
    for (size_t i = 0; i < q->n; i++) {
        const double light = (double) q->at[i].light;
        const int bin = gp_source_bin(q->at[i].light) + 1;
        const double most = (double) gp_source_bin_start(bin);
        int reach = -1;
        for (int c = 0; c < 3; c++) {
            for (int j = 0; j < k->w * k->h; j++) {
                const int dx = abs(j % k->w - k->cx);
                const int dy = abs(j / k->w - k->cy);
                const int d = dx > dy ? dx : dy;
                if ((!tail || d > GP_CORE_RADIUS) && d > reach &&
                    most * fabs((double) k->k.c[c][j]) > least)
                    reach = d;
            }
        }
        left += light * beyond(k, reach, tail);
        all += light;
    }
    assert_true(left >= 0.999 * (double) r->share * all ||
                left >= 0.999 * beyond(k, -1, tail) * all);
}

static void what_is_left_out_is_allowed(void **state)
{
    for (size_t i = 0; i < COUNT(shrink_rows); i++) {
        const struct shrink_row *const r = &shrink_rows[i];
        struct gp_kernel k = scene_kernel(r->w, r->h, r->cx, r->cy, r->shape);
        struct gp_polygon at[LIGHTS];
        const struct gp_polygons q = lights(r->brightest, at);
        const struct gp_splat_params p = {
            .group = r->tail ? 8 : 1, .shrink = r->share,
        };
        struct gp_shrink s;
        char what[16];
        snprintf(what, sizeof what, "row %zu", i);
        assert_ok(gp_shrink_make(NULL, &k, &p, &q, &s));
        check_shrink(&k, r, (double) r->share, &q, &s, what);
        if (r->brightest < 1e30f && r->brightest > 1e-30f)
            check_largest(&k, r, &q, &s);
        gp_kernel_free(&k);
    }
}

/* More may be left out: no polygon reaches farther. */
static void reach_falls_with_the_share(void **state)
{
    struct gp_kernel k = scene_kernel(201, 201, MID, 0, PEAK);
    struct gp_polygon at[LIGHTS];
    const struct gp_polygons q = lights(10.0f, at);
    struct gp_shrink last, s;
    struct gp_splat_params p = {.group = 8};
    assert_ok(gp_shrink_make(NULL, &k, &p, &q, &last));
    assert_true(last.left_out == 0.0);
    for (int b = 0; b < GP_SOURCE_BINS; b++)
        assert_int_equal(last.reach[b], INT_MAX / 2);
    for (p.shrink = 1e-5f; p.shrink < 1.0f; p.shrink *= 3.0f) {
        assert_ok(gp_shrink_make(NULL, &k, &p, &q, &s));
        for (int b = 0; b < GP_SOURCE_BINS; b++)
            assert_true(s.reach[b] <= last.reach[b]);
        assert_true(s.least >= last.least);
        last = s;
    }
    assert_true(last.reach[gp_source_bin(10.0f)] < 100);
    gp_kernel_free(&k);
}

static void no_light_draws_all(void **state)
{
    struct gp_kernel k = scene_kernel(9, 9, MID, 0, PEAK);
    struct gp_polygon dark = {.side = 1};
    const struct gp_splat_params p = {.group = 1, .shrink = 0.5f};
    for (size_t n = 0; n < 2; n++) {
        const struct gp_polygons q = {n, n, 0, &dark};
        struct gp_shrink s;
        assert_ok(gp_shrink_make(NULL, &k, &p, &q, &s));
        assert_int_equal(s.reach[0], INT_MAX / 2);
        assert_true(s.left_out == 0.0);
    }
    gp_kernel_free(&k);
}

/* -- the rims of polygons -------------------------------------------------- */

enum { W = 60, H = 50 };

/* A black frame with lights of 2 at these pixels. */
static struct scene lit_scene(const int (*at)[2], int n, struct gp_kernel k)
{
    struct gp_frame f = scene_frame(W, H, -7, 3, DARK, 1);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < n; i++)
            f.rgb.c[c][at[i][1] * W + at[i][0]] = 2.0f;
    }
    return scene_sense(f, k, &usual);
}

/* A picture of 0.25 with the outlines drawn over it. */
static struct gp_planes outlined(const struct scene *s,
                                 const struct gp_splat_params *p)
{
    const size_t n = gp_frame_pixels(&s->f);
    struct gp_planes picture;
    assert_ok(gp_planes_make(NULL, "picture", n, &picture));
    for (size_t i = 0; i < 3 * n; i++)
        picture.c[i / n][i % n] = 0.25f;
    assert_ok(gp_polygons_outline(NULL, &s->src, &s->k, p, &picture));
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
    const bool inside = x >= b->x0 && x <= b->x1 && y >= b->y0 && y <= b->y1;
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
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s = lit_scene(&rows[i].at, 1, scene_kernel(rows[i].w,
            rows[i].h, rows[i].cx, rows[i].cy, BOX));
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

/* Against the polygons one by one, with blurs, clusters and shrinking: every
 * rim inside the frame is drawn, and nothing else. */
static void all_that_are_drawn_have_one(void **state)
{
    static const struct gp_splat_params rows[] = {
        GP_SPLAT_DEFAULTS,
        {.group = 1, .cluster_fill = 0.9f, .shrink = 0.2f},
        {.group = 2, .cluster = 8, .cluster_fill = 0.3f, .shrink = 0.1f},
        {.group = 8, .cluster_fill = 0.9f},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s = scene_sense(scene_frame(W, H, -7, 3, BLOCK, 5),
            scene_kernel(31, 20, MID, MID, PEAK), &usual);
        struct gp_polygons polygons;
        struct gp_shrink shrink;
        assert_ok(gp_polygons_make(NULL, &s.src, &rows[i], &polygons));
        assert_ok(gp_shrink_make(NULL, &s.k, &rows[i], &polygons, &shrink));
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
            assert_int_equal(green(&picture, j % W, j / W), want[j / W][j % W]);
        gp_polygons_free(&polygons);
        gp_planes_free(&picture);
        scene_free(&s);
    }
}

static void no_light_no_line(void **state)
{
    const struct gp_splat_params p = GP_SPLAT_DEFAULTS;
    struct scene s = lit_scene(NULL, 0, scene_kernel(9, 9, MID, MID, PEAK));
    struct gp_planes picture = outlined(&s, &p);
    for (int i = 0; i < W * H; i++)
        assert_false(green(&picture, i % W, i / W));
    gp_planes_free(&picture);
    scene_free(&s);
}

SUITE_OF(blur, NULL, NULL, blurs_are_box_means, nothing_left_is_an_empty_blur,
         no_memory_leaves_nothing, what_is_left_out_is_allowed,
         reach_falls_with_the_share, no_light_draws_all,
         single_sensors_have_the_kernels_box, all_that_are_drawn_have_one,
         no_light_no_line)
