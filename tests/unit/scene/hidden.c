/* The hierarchy of depths against a look at every pixel. */
#include "scene/hidden.h"

#include "scene_made.h"

/* True where a pixel of the bounds shows what is at b->near. */
static bool shows(struct gp_rect window, const float *depth,
                  const struct gp_screen_box *b)
{
    for (int y = window.y0; y < window.y1; y++) {
        for (int x = window.x0; x < window.x1; x++) {
            const size_t i = (size_t) (y - window.y0) *
                                 (size_t) gp_rect_w(window) +
                             (size_t) (x - window.x0);
            const bool surface = depth[i] > 0.0f && depth[i] < 1e9f;
            // (any part of the pixel counts, not only its centre)
            if (x + 1 > b->x0 && x < b->x1 && y + 1 > b->y0 && y < b->y1 &&
                (!surface ||
                 (double) depth[i] >= b->near * (1.0 - GP_DEPTH_SLACK)))
                return true;
        }
    }
    return false;
}

/* Frames of steps in depth with holes, of all small sizes: hidden is what no
 * pixel shows, exactly. */
static void every_pixel(void **state)
{
    uint64_t seed = 21;
    int hidden = 0, shown = 0;
    for (int i = 0; i < 300; i++) {
        const int w = 1 + (int) (70 * made_random(&seed)),
                  h = 1 + (int) (50 * made_random(&seed));
        const struct gp_rect window = {i % 7 - 9, 3 - i % 5, i % 7 - 9 + w,
                                       3 - i % 5 + h};
        float *const depth = calloc((size_t) (w * h), sizeof *depth);
        assert_non_null(depth);
        for (int k = 0; k < w * h; k++) {
            static const float none[] = {0.0f, -1.0f, NAN, 1e10f, INFINITY};
            const double r = made_random(&seed);
            depth[k] = (float) (3 + k % w / 9 + k / w / 11 + r);
            if (r < 0.002)
                depth[k] = none[k % 5];
        }
        struct gp_hidden p;
        assert_ok(gp_hidden_make(NULL, window, depth, &p));
        for (int k = 0; k < 60; k++) {
            struct gp_screen_box b = {.seen = true};
            b.x0 = made_between(&seed, window.x0 - 9, window.x1 + 5);
            b.x1 = b.x0 + 30 * made_random(&seed) * made_random(&seed);
            b.y0 = made_between(&seed, window.y0 - 9, window.y1 + 5);
            b.y1 = b.y0 + 30 * made_random(&seed) * made_random(&seed);
            b.near = made_between(&seed, 2, 14);
            const bool got = gp_hidden_box(&p, &b);
            assert_int_equal(got, !shows(window, depth, &b));
            hidden += got;
            shown += !got;
        }
        gp_hidden_free(&p);
        free(depth);
    }
    assert_true(hidden > 500 && shown > 500);
}

/* Tiles have the least and the greatest depth of their pixels. */
static void tiles(void **state)
{
    uint64_t seed = 22;
    const struct gp_rect window = {2, 3, 2 + 53, 3 + 37};
    float depth[53 * 37];
    for (int i = 0; i < 53 * 37; i++)
        depth[i] = i % 200 == 7 ? 1e10f : (float) made_between(&seed, 1, 9);
    struct gp_hidden p;
    assert_ok(gp_hidden_make(NULL, window, depth, &p));
    assert_int_equal(p.w[GP_TILE_LEVEL], 4);
    assert_int_equal(p.h[GP_TILE_LEVEL], 3);
    for (int t = 0; t < 12; t++) {
        float least = INFINITY, most = 0.0f, deepest = 0.0f;
        for (int i = 0; i < 53 * 37; i++) {
            if (i % 53 / 16 != t % 4 || i / 53 / 16 != t / 4)
                continue;
            least = fminf(least, depth[i]);
            deepest = depth[i] > 1e9f ? deepest : fmaxf(deepest, depth[i]);
            most = depth[i] > 1e9f ? INFINITY : fmaxf(most, depth[i]);
        }
        assert_true(p.least[t] == least);
        assert_true(p.deepest[t] == deepest);
        assert_true(p.most[GP_TILE_LEVEL][t] == most);
    }
    gp_hidden_free(&p);
}

SUITE_OF(hidden, NULL, NULL, every_pixel, tiles)
