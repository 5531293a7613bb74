/* Depths by tiles, and scissors, against every pixel. */
#include "scene/sets/sets_priv.h"

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
static void what_no_pixel_shows(void **state)
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
        struct gp_depths p;
        assert_ok(gp_depths_make(NULL, window, depth, &p));
        for (int k = 0; k < 60; k++) {
            struct gp_screen_box b = {.seen = true};
            b.x0 = made_between(&seed, window.x0 - 9, window.x1 + 5);
            b.x1 = b.x0 + 30 * made_random(&seed) * made_random(&seed);
            b.y0 = made_between(&seed, window.y0 - 9, window.y1 + 5);
            b.y1 = b.y0 + 30 * made_random(&seed) * made_random(&seed);
            b.near = made_between(&seed, 2, 14);
            const bool got = gp_depths_hide(&p, &b);
            assert_int_equal(got, !shows(window, depth, &b));
            hidden += got;
            shown += !got;
        }
        gp_depths_free(&p);
        free(depth);
    }
    assert_true(hidden > 500 && shown > 500);
}

static struct gp_screen_box random_box(uint64_t *seed)
{
    struct gp_screen_box b = {.seen = true};
    b.x0 = made_between(seed, -20, 120);
    b.x1 = b.x0 + made_between(seed, 0, 60);
    b.y0 = made_between(seed, -20, 80);
    b.y1 = b.y0 + made_between(seed, 0, 60);
    b.near = made_between(seed, 1, 20);
    b.far = b.near + made_between(seed, 0, 6);
    return b;
}

static bool in(const struct gp_screen_box *b, int x, int y, double z)
{
    return x + 0.5 >= b->x0 && x + 0.5 <= b->x1 && y + 0.5 >= b->y0 &&
           y + 0.5 <= b->y1 && z >= b->near && z <= b->far;
}

enum { W = 117, H = 83 };
static const struct gp_rect window = {-5, 9, -5 + W, 9 + H};

/* Every pixel whose surface is in an object's and the light's bounds is in the
 * scissor and its depths; of the pixels of the scissor without one most are
 * near some, and with depths it is never larger than without. */
static void every_pixel(void **state)
{
    uint64_t seed = 51;
    long kept = 0, needed = 0, plain = 0;
    int empty = 0;
    static float depth[W * H];
    for (int i = 0; i < 400; i++) {
        for (int k = 0; k < W * H; k++) // steps, and a sky
            depth[k] = k < W * (i % 30) ? 1e10f
                : (float) (2 + (k % W * 7 / W + k / W * 3 / H + i) % 9 * 2 +
                           made_random(&seed));
        struct gp_depths h, none = {.window = window};
        assert_ok(gp_depths_make(NULL, window, depth, &h));
        struct gp_screen_box box[6], seen[6];
        static const int index[] = {1, 2, 4};
        for (int k = 0; k < 6; k++) {
            box[k] = random_box(&seed);
            seen[k] = gp_scissor_visible(&h, &box[k]);
        }
        struct gp_screen_box light = random_box(&seed);
        light.x1 += 40;
        light.y1 += 40;
        light.far += 10;
        const struct gp_scissor s = gp_scissor_make(&h, seen, index, 3, &light);
        const struct gp_scissor all =
            gp_scissor_make(&none, box, index, 3, &light);
        const struct gp_rect joined =
            gp_rect_empty(s.rect) ? all.rect : gp_rect_join(s.rect, all.rect);
        assert_memory_equal(&joined, &all.rect, sizeof joined);
        assert_true(gp_rect_empty(s.rect) ||
                    (s.near >= all.near * 0.998 && s.far <= all.far * 1.002));
        for (int y = window.y0; y < window.y1; y++) {
            for (int x = window.x0; x < window.x1; x++) {
                const double z =
                    (double) depth[(y - window.y0) * W + x - window.x0];
                const bool held = x >= s.rect.x0 && x < s.rect.x1 &&
                                  y >= s.rect.y0 && y < s.rect.y1 &&
                                  z >= s.near && z <= s.far;
                bool need = false;
                for (int k = 0; k < 3; k++)
                    need |= in(&box[index[k]], x, y, z) && in(&light, x, y, z);
                assert_true(held || !need);
                needed += need;
                kept += held;
                plain += x >= all.rect.x0 && x < all.rect.x1 &&
                         y >= all.rect.y0 && y < all.rect.y1;
            }
        }
        empty += gp_rect_empty(s.rect);
        gp_depths_free(&h);
    }
    print_message("# scissor: %ld pixels needed, %ld kept, %ld in rectangles "
                  "without depth\n", needed, kept, plain);
    assert_true(needed > 5000 && empty > 10 && empty < 300);
    assert_true(kept < plain / 2);
}

SUITE_OF(scissor, NULL, NULL, what_no_pixel_shows, every_pixel)
