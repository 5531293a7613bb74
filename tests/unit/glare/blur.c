// SPDX-License-Identifier: Apache-2.0
/* glare/splat/blur.c: the kernel blurred by boxes, against the plain sum, and how
 * far polygons reach. */
#include "unit.h"
#include "glare/splat/polygons.h"
#include "glare_scene.h"

/* -- blurs ------------------------------------------------------------------*/

struct blur_row {
    int w, h, cx, cy;
    enum shape shape;
    struct gp_rect crop; // all zero: the whole kernel
    bool hollow;
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

/* Sample (x, y) of the cut kernel without its middle. */
static double cut_sample(const struct gp_kernel *k, const struct blur_row *r,
                         struct gp_rect crop, int c, int x, int y)
{
    x += crop.x0;
    y += crop.y0;
    if (x < crop.x0 || x >= crop.x1 || y < crop.y0 || y >= crop.y1)
        return 0.0;
    if (r->hollow && abs(x - k->cx) <= GP_MIDDLE_RADIUS &&
        abs(y - k->cy) <= GP_MIDDLE_RADIUS)
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
        assert_ok(gp_blur_make(NULL, &k, crop_of(r), r->hollow, r->side, &b));
        assert_int_equal(b.grey, k.grey);
        check_blur(&k, r, &b);
        gp_planes_free(&b.k);
        gp_kernel_free(&k);
    }
}

/* -- shrinking --------------------------------------------------------------*/

/* Light of the kernel's samples more than `reach` away, over its whole, the
 * largest channel. Without its middle when `hollow`. */
static double beyond(const struct gp_kernel *k, int reach, bool hollow)
{
    double worst = 0.0;
    for (int c = 0; c < 3; c++) {
        double sum = 0.0;
        for (int i = 0; i < k->w * k->h; i++) {
            const int dx = abs(i % k->w - k->cx), dy = abs(i / k->w - k->cy);
            const int d = dx > dy ? dx : dy;
            if (d > reach && !(hollow && d <= GP_MIDDLE_RADIUS))
                sum += fabs((double) k->k.c[c][i]);
        }
        worst = fmax(worst, sum / k->norm1[c]);
    }
    return worst;
}

struct shrink_row {
    int w, h, cx, cy;
    enum shape shape;
    bool hollow; // beside the middle
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
    const bool hollow = r->hollow;
    double left = 0.0, all = 0.0;
    for (size_t i = 0; i < q->n; i++) {
        const double light = (double) q->at[i].light;
        const int reach = s->reach[gp_source_bin(q->at[i].light)];
        left += light * beyond(k, reach - 5, hollow);
        all += light;
    }
    if (left > share * all * (1.0 + 1e-9) ||
        s->left_out > share || left > s->left_out * all * (1.0 + 1e-9))
        fail_msg("%s: %g left out, %g said, %g allowed", what, left / all,
                 s->left_out, share);
    for (int b = 0; b < GP_SOURCE_BINS; b++) {
        assert_true(s->reach[b] >= (hollow ? GP_MIDDLE_RADIUS : 0));
        assert_true(b == 0 || s->reach[b] >= s->reach[b - 1]);
    }
}

static void what_is_left_out_is_allowed(void **state)
{
    for (size_t i = 0; i < COUNT(shrink_rows); i++) {
        const struct shrink_row *const r = &shrink_rows[i];
        struct gp_kernel k = scene_kernel(r->w, r->h, r->cx, r->cy, r->shape);
        struct gp_polygon at[LIGHTS];
        const struct gp_polygons q = lights(r->brightest, at);
        const struct gp_splat_params p = {
            .group = r->hollow ? 8 : 1, .shrink = r->share,
        };
        struct gp_shrink s;
        char what[16];
        snprintf(what, sizeof what, "row %zu", i);
        assert_ok(gp_shrink_make(NULL, &k, &p, &q, &s));
        check_shrink(&k, r, (double) r->share, &q, &s, what);
        gp_kernel_free(&k);
    }
}

SUITE_OF(blur, NULL, NULL, blurs_are_box_means, what_is_left_out_is_allowed)

