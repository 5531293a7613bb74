/* glare/direct/direct.c: the fast sum against the sum in double, taps, counted
 * work. */
#include "unit.h"
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
                assert_true(row[GP_TAPS_PAD + x] ==
                            k->k.c[c][ky * k->w + kx]);
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
        struct gp_kernel k = scene_kernel(37, 21, centres[i][0],
                                          centres[i][1],
                                          i % 2 ? LOBES : TINTED);
        for (size_t j = 0; j < COUNT(radii); j++)
            check_taps(&k, radii[j]);
        assert_int_equal(isinf(gp_direct_bound(&k, 100)), k.negative);
        gp_kernel_free(&k);
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
        const struct gp_kernel rest = other.k;
        struct gp_taps core, around;
        struct gp_glare_error e;
        const size_t n = gp_frame_pixels(&s.f);
        for (int j = 0; j < rest.w * rest.h; j++) {
            const int inside = abs(j % rest.w - rest.cx) <= radii[i] &&
                               abs(j / rest.w - rest.cy) <= radii[i];
            for (int c = 0; c < 3 && inside; c++)
                rest.k.c[c][j] = 0.0f;
        }
        assert_ok(gp_taps_make(NULL, &s.k, radii[i], &core));
        assert_ok(gp_taps_make(NULL, &rest, -1, &around));
        assert_ok(gp_planes_make(NULL, "layer", n, &s.f.layer));
        for (int c = 0; c < 3; c++)
            memset(s.f.layer.c[c], 0xff, n * sizeof(float));
        assert_ok(gp_direct_sum(NULL, &s.src, &around, false, &s.f.layer));
        assert_ok(gp_direct_sum(NULL, &s.src, &core, true, &s.f.layer));
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
        assert_true(e.rel_l2 <= 1e-6);
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
        skip();
    struct gp_frame f = scene_frame(211, 193, 0, 0, ALL, 1u);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_frame_pixels(&f); i++)
            f.rgb.c[c][i] = 1.1f;
    }
    struct scene s = scene_make(f, scene_kernel(95, 95, MID, 0, BOX),
                                &(struct gp_sensor_params) GP_SENSOR_DEFAULTS);
    struct gp_glare_stats stats;
    struct gp_glare_error e;
    ran_once("direct", &s, &stats, "equal sources");
    gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
    if (!(e.rel_l2 <= 1e-6 && e.rel_l2 <= stats.bound))
        fail_msg("rel_l2 %g, bound %g", e.rel_l2, stats.bound);
    scene_free(&s);
}

SUITE_OF(direct, ask_quick, NULL,
    taps_are_the_kernel, parts_add_up, work_is_counted,
    equal_sources_do_not_drift)
