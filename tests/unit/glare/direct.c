/* glare/direct: taps, counted work and quads, each form of the sum against
 * the sum in double. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "glare/glare_priv.h"
#include "hard_cases.h"

/* -- taps -------------------------------------------------------------------*/

/* Every sample within the radius stands where it was from the centre, and
 * zeros stand on both sides. */
static void check_taps(const struct gp_kernel *k, int radius)
{
    struct gp_taps t;
    const int r = radius < 0 ? 1 << 24 : radius;
    size_t kept = 0, counted = 0;
    assert_ok(gp_taps_make(NULL, k, radius, &t));
    for (int y = 0; y < k->h; y++) {
        for (int x = 0; x < k->w; x++)
            kept += abs(x - k->cx) <= r && abs(y - k->cy) <= r;
    }
    assert_int_equal(kept, (size_t) t.w * (size_t) t.h);
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < t.h; y++) {
            const float *const row = t.k[c] + (size_t) y * t.pitch;
            for (int i = 0; i < GP_TAPS_PAD; i++)
                assert_true(row[i] == 0.0f &&
                            row[t.pitch - 1 - (size_t) i] == 0.0f);
            for (int x = 0; x < t.w; x++) {
                const int kx = x - t.cx + k->cx, ky = y - t.cy + k->cy;
                assert_true(abs(kx - k->cx) <= r && abs(ky - k->cy) <= r);
                assert_true(row[GP_TAPS_PAD + x] == k->k.c[c][ky * k->w + kx]);
                counted++;
            }
        }
    }
    assert_int_equal(counted, 3 * kept);
    gp_taps_free(&t);
    gp_taps_free(&t);
    assert_null(t.k[0]);
}

static void taps_are_the_kernel(void **state)
{
    static const int centres[][2] = {
        {MID, 0}, {0, 0}, {36, 20}, {-20, 5}, {10, 100}, {1048575, -1048576},
    };
    static const int radii[] = {-1, 0, 1, 4, 8, 16, 32, 1000};
    for (size_t i = 0; i < COUNT(centres); i++) {
        struct gp_kernel k = scene_kernel(37, 21, centres[i][0], centres[i][1],
            i % 2 ? LOBES : TINTED);
        for (size_t j = 0; j < COUNT(radii); j++)
            check_taps(&k, radii[j]);
        assert_int_equal(isinf(gp_direct_bound(&k, 100)), k.negative);
        gp_kernel_free(&k);
    }
}

/* Samples of the kernel within the radius, or those beyond it, become 0. */
static void cut_kernel(struct gp_kernel *k, int radius, bool within)
{
    for (int i = 0; i < k->w * k->h && radius >= 0; i++) {
        const bool is = abs(i % k->w - k->cx) <= radius &&
                        abs(i / k->w - k->cy) <= radius;
        for (int c = 0; c < 3 && is == within; c++)
            k->k.c[c][i] = 0.0f;
    }
}

/* The core and the kernel without it are the kernel: `add` adds, and leaves
 * alone what no tap reaches. */
static void parts_add_up(void **state)
{
    static const int radii[] = {0, 4, 8, 16};
    for (size_t i = 0; i < COUNT(radii); i++) {
        struct scene s = hard_scene(&hard_cases[6]);
        struct scene other = hard_sense(&hard_cases[6]);
        struct gp_taps core, around;
        cut_kernel(&other.k, radii[i], true);
        assert_ok(gp_taps_make(NULL, &s.k, radii[i], &core));
        assert_ok(gp_taps_make(NULL, &other.k, -1, &around));
        scene_clear_layer(&s);
        assert_ok(gp_direct_sum(NULL, &s.src, &around, false, &s.f.layer));
        assert_ok(gp_direct_sum(NULL, &s.src, &core, true, &s.f.layer));
        assert_true(scene_rel_l2(&s) <= 1e-6);
        gp_taps_free(&core);
        gp_taps_free(&around);
        scene_free(&other);
        scene_free(&s);
    }
}

/* -- work -------------------------------------------------------------------*/

/* Source by source, tap by tap. */
static double count_work(const struct gp_sources *s, const struct gp_kernel *k)
{
    double work = 0.0;
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            for (int t = 0; t < k->w * k->h; t++) {
                const int x = s->x[i] + t % k->w - k->cx;
                const int ty = y + t / k->w - k->cy;
                work += x >= 0 && x < s->w && ty >= 0 && ty < s->h;
            }
        }
    }
    return work;
}

static void work_is_counted(void **state)
{
    for (int i = 0; i < HARD_CASES; i++) {
        if (!hard_is_quick(&hard_cases[i]))
            continue;
        struct scene s = hard_sense(&hard_cases[i]);
        const double work = gp_direct_work(&s.src, s.k.w, s.k.h, s.k.cx,
                                           s.k.cy);
        if (work != count_work(&s.src, &s.k))
            fail_msg("%s: work %g", hard_cases[i].name, work);
        scene_free(&s);
    }
}

/* Many equal sources on one pixel's way: roundings of one direction add up,
 * and the groups keep them under the bar. */
static void equal_sources_do_not_drift(void **state)
{
    if (quick)
        skip_for("quick");
    struct scene s = scene_make(scene_frame(211, 193, 0, 0, EQUAL, 1u),
                                scene_kernel(95, 95, MID, 0, BOX), &usual);
    struct gp_glare_stats stats;
    ran_once("direct", &s, &stats, "equal sources");
    const double rel_l2 = scene_rel_l2(&s);
    if (!(rel_l2 <= 1e-6 && rel_l2 <= stats.bound))
        fail_msg("rel_l2 %g, bound %g", rel_l2, stats.bound);
    scene_free(&s);
}

enum pattern { FULL, STARS, LINES, PANES, EDGES, ONE, NOTHING };

static int shines(enum pattern pattern, int x, int y, int w, int h)
{
    switch (pattern) {
    case FULL:
        return 1;
    case STARS:
        return x % 7 == 3 && y % 9 == 5;
    case LINES:
        return y % 4 == 1;
    case PANES:
        return x % 13 < 6 && y % 11 < 7;
    case EDGES:
        return x == 0 || y == 0 || x == w - 1 || y == h - 1;
    case ONE:
        return x == w / 2 && y == h / 2;
    default:
        return 0;
    }
}

static const struct quad_case {
    int w, h;
    enum pattern pattern;
    int kw, kh, cx, cy; // kernel; its centre
    int radius;         // of the taps
} cases[] = {
    {1, 1, FULL, 1, 1, 0, 0, -1}, {1, 9, FULL, 5, 3, 2, 1, -1},
    {9, 1, FULL, 3, 5, 1, 2, -1}, {3, 2, FULL, 9, 9, 4, 4, -1},
    {17, 5, STARS, 9, 9, 4, 4, -1}, {40, 33, STARS, 33, 21, 16, 10, -1},
    {40, 33, LINES, 10, 8, 5, 4, -1}, {47, 35, PANES, 33, 21, 20, 9, -1},
    {47, 35, PANES, 33, 21, 20, 9, 4}, {530, 18, PANES, 9, 9, 4, 4, -1},
    {529, 21, EDGES, 31, 7, 15, 3, -1}, {33, 70, EDGES, 7, 75, 3, 37, 16},
    {64, 64, ONE, 31, 31, 15, 15, -1}, {20, 20, NOTHING, 9, 9, 4, 4, -1},
    {31, 29, FULL, 5, 5, 40, 2, -1}, {31, 29, FULL, 5, 5, -12, 30, -1},
    {31, 29, FULL, 5, 5, 400, 400, -1},
};
enum { CASES = COUNT(cases) };

static struct scene open_case(const struct quad_case *c)
{
    uint32_t seed = 5u;
    struct gp_frame f = scene_frame(c->w, c->h, 0, 0, BLACK, seed);
    for (int i = 0; i < c->w * c->h; i++) {
        const float v = shines(c->pattern, i % c->w, i / c->w, c->w, c->h)
                            ? 2.0f + 100.0f * scene_random(&seed)
                            : 0.0f;
        for (int k = 0; k < 3; k++)
            f.rgb.c[k][i] = v * (1.0f - 0.2f * (float) k);
    }
    return scene_sense(f, scene_kernel(c->kw, c->kh, c->cx, c->cy, TINTED),
                       &usual);
}

static void check_quads(const struct gp_sources *s, const struct gp_quads *q)
{
    uint32_t n = 0;
    struct gp_planes image;
    assert_ok(gp_sources_planes(NULL, s, &image));
    for (int y = 1 - GP_QUAD; y < s->h; y++) {
        assert_int_equal(q->row[y + GP_QUAD - 1], n);
        for (int x = 0; x < s->w; x++) {
            float light[3][GP_QUAD], most = 0.0f;
            for (int i = 0; i < 3 * GP_QUAD; i++) {
                const int c = i / GP_QUAD, at = y + i % GP_QUAD;
                const float v = at >= 0 && at < s->h
                                    ? image.c[c][at * s->w + x] : 0.0f;
                light[c][i % GP_QUAD] = v;
                most = fmaxf(most, v);
            }
            if (most == 0.0f)
                continue;
            assert_true(n < q->n);
            assert_int_equal(q->x[n], x);
            for (int c = 0; c < 3; c++)
                assert_memory_equal(q->light[c] + GP_QUAD * n, light[c],
                                    sizeof light[c]);
            n++;
        }
    }
    assert_int_equal(q->row[s->h + GP_QUAD - 1], n);
    assert_int_equal(q->n, n);
    gp_planes_free(&image);
}

static void quads_hold_the_light(void **state)
{
    for (int i = 0; i < CASES; i++) {
        struct scene s = open_case(&cases[i]);
        struct gp_quads q;
        assert_ok(gp_quads_make(NULL, &s.src, &q));
        check_quads(&s.src, &q);
        assert_int_equal(gp_quads_count(&s.src, 1), q.n);
        const size_t some = gp_quads_count(&s.src, 7);
        assert_true(some >= s.src.n && some <= GP_QUAD * s.src.n);
        gp_quads_free(&q);
        gp_quads_free(&q);
        assert_null(q.x);
        scene_free(&s);
    }
}

/* s->exact is the layer's when it is black at first. */
static void check_sum(const struct quad_case *row, const struct scene *s,
                      const struct gp_taps *t, bool add)
{
    const size_t n = gp_frame_pixels(&s->f);
    struct gp_planes layer, again;
    struct gp_quads q;
    assert_ok(gp_quads_make(NULL, &s->src, &q));
    assert_ok(gp_planes_make(NULL, "layer", n, &layer));
    assert_ok(gp_planes_make(NULL, "layer", n, &again));
    for (int threads = 1; threads <= 3; threads++) {
        struct gp_planes *const out = threads == 1 ? &layer : &again;
        gp_set_threads(threads);
        for (size_t i = 0; i < 3 * n; i++)
            out->c[i / n][i % n] = add ? 0.5f : NAN;
        assert_ok(gp_quads_sum(NULL, &q, t, s->src.w, s->src.h, add, out));
        for (int c = 0; c < 3; c++)
            assert_memory_equal(layer.c[c], out->c[c], n * sizeof(float));
    }
    gp_set_threads(0);
    for (size_t i = 0; i < 3 * n; i++) {
        const double want = s->exact[i] + (add ? 0.5 : 0.0);
        const double got = (double) layer.c[i / n][i % n];
        if (!(fabs(got - want) <= 1e-6 * want))
            fail_msg("%dx%d pattern %d add %d: sample %zu is %.9g not %.9g",
                     row->w, row->h, (int) row->pattern, add, i, got, want);
    }
    gp_planes_free(&layer);
    gp_planes_free(&again);
    gp_quads_free(&q);
}

static void quads_sum_like_sources(void **state)
{
    for (int i = 0; i < CASES; i++) {
        struct scene s = open_case(&cases[i]);
        struct gp_taps t;
        assert_ok(gp_taps_make(NULL, &s.k, cases[i].radius, &t));
        cut_kernel(&s.k, cases[i].radius, false);
        scene_find_exact(&s);
        check_sum(&cases[i], &s, &t, false);
        check_sum(&cases[i], &s, &t, true);
        gp_taps_free(&t);
        scene_free(&s);
    }
}

/* Stars are summed one by one; walls of light in quads. */
static void the_form_goes_with_the_light(void **state)
{
    static const struct {
        enum pattern pattern;
        int quads;
    } rows[] = {{FULL, 1}, {PANES, 1}, {STARS, 0}, {LINES, 0}, {ONE, 0}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s = open_case(
            &(struct quad_case) {96, 96, rows[i].pattern, 9, 9, 4, 4, -1});
        const double quads = gp_direct_quads(&s.src);
        assert_int_equal(quads > 0.0, rows[i].quads);
        assert_true(quads == 0.0 || quads >= (double) s.src.n);
        scene_free(&s);
    }
}

SUITE_OF(direct, ask_quick, NULL, taps_are_the_kernel, parts_add_up,
         work_is_counted, equal_sources_do_not_drift, quads_hold_the_light,
         quads_sum_like_sources, the_form_goes_with_the_light)
