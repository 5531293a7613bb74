// SPDX-License-Identifier: Apache-2.0
/* bench/paper.c: the synthetic frames are what they say they are, and the same
 * bytes everywhere. */
#include "unit.h"
#include "views.h"
#include "bench/bench_priv.h"
#include "glare/sources.h"

/* FNV-1a, of the planes. */
static uint64_t hash(const struct gp_frame *f)
{
    uint64_t h = 0xcbf29ce484222325u;
    for (int c = 0; c < 3; c++) {
        const unsigned char *p = (const void *) f->rgb.c[c];
        for (size_t i = 0; i < gp_frame_pixels(f) * sizeof(float); i++)
            h = (h ^ p[i]) * 0x100000001b3u;
    }
    return h;
}

static struct gp_frame paper_scene(enum gp_paper_kind kind)
{
    struct gp_frame f = {0};
    assert_ok(gp_paper_frame(NULL, kind, &f));
    return f;
}

static void bytes_are_the_same_everywhere(void **state)
{
    static const uint64_t want[GP_PAPER_KINDS + 1] = {
        0x21cfe2289c5f114du, 0xcbeacece0ef7d228u, 0x8d26befe0c8208bdu,
        0x3f2e76b5dda9753au,
    };
    for (int i = 0; i <= GP_PAPER_KINDS; i++) {
        struct gp_frame f = {0};
        if (i < GP_PAPER_KINDS)
            f = paper_scene((enum gp_paper_kind) i);
        else
            assert_ok(gp_paper_kernel(NULL, &f));
        if (hash(&f) != want[i])
            fail_msg("frame %d hashes to %#llx", i,
                     (unsigned long long) hash(&f));
        gp_frame_free(&f);
    }
}

/* Each kind has its share of sources, of its luminance, as sensors see them. */
static void light_is_as_it_is_named(void **state)
{
    static const struct {
        enum gp_paper_kind kind;
        double least, most;      // share of pixels that are sources
        double low, high;        // luminance of sources
    } rows[] = {
        {GP_PAPER_POINTS, 100.0 / 786432, 128.0 / 786432, 1.0, 5001.0},
        {GP_PAPER_WINDOWS, 0.02, 0.04, 1.0, 5001.0},
        {GP_PAPER_SKY, 0.5, 0.7, 2.0, 20.0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct glarepp_sense_params p = {
            .threshold = 1.0f, .whole = true, .max_value = 1e9f,
        };
        struct gp_frame f = paper_scene(rows[i].kind);
        struct gp_sources s = {0};
        struct gp_image v = view_of(&f);
        assert_ok(gp_sense(NULL, &p, false, &v, &s));
        const double share = (double) s.n / (double) gp_frame_pixels(&f);
        assert_true(share >= rows[i].least && share <= rows[i].most);
        assert_true(s.nonfinite == 0 && s.clamped == 0);
        for (size_t k = 0; k < s.n; k++) {
            double y = 0.0;
            for (int c = 0; c < 3; c++)
                y += (double) f.luminance[c] * (double) s.rgb[c][k];
            assert_true(y >= rows[i].low && y <= rows[i].high);
        }
        gp_sources_free(&s);
        gp_frame_free(&f);
    }
}

static double luminance(const struct gp_frame *f, int x, int y)
{
    const size_t at = (size_t) y * (size_t) gp_frame_w(f) + (size_t) x;
    double l = 0.0;
    for (int c = 0; c < 3; c++)
        l += (double) f->luminance[c] * (double) f->rgb.c[c][at];
    return l;
}

/* No polygon of the paper's may be exact by luck: windows differ inside. */
static void windows_are_not_constant(void **state)
{
    struct gp_frame f = paper_scene(GP_PAPER_WINDOWS);
    int lit = 0, pairs = 0, same = 0;
    for (int y = 0; y < GP_PAPER_H; y++) {
        for (int x = 1; x < GP_PAPER_W; x++) {
            const double a = luminance(&f, x - 1, y), b = luminance(&f, x, y);
            lit += b > 1.0;
            pairs += a > 1.0 && b > 1.0;
            same += a > 1.0 && a == b;
        }
    }
    assert_true(lit > 15000 && pairs > lit * 9 / 10 && same < pairs / 20);
    gp_frame_free(&f);
}

static void the_kernel_is_coloured_and_ends_inside(void **state)
{
    enum { n = GP_PAPER_KERNEL, half = n / 2 };
    struct gp_frame f = {0};
    int coloured = 0;
    assert_ok(gp_paper_kernel(NULL, &f));
    for (int k = 0; k < n * n; k++) {
        const float *const g = f.rgb.c[1];
        assert_true(g[k] >= 0.0f && g[k] <= g[half * n + half]);
        if (k % n == 0 || k / n == 0)
            assert_true(g[k] == 0.0f);
        coloured += f.rgb.c[0][k] > g[k] && g[k] > f.rgb.c[2][k];
    }
    assert_true(coloured > n * n / 2);
    gp_frame_free(&f);
}

SUITE_OF(paper, NULL, NULL, bytes_are_the_same_everywhere,
         light_is_as_it_is_named, windows_are_not_constant,
         the_kernel_is_coloured_and_ends_inside)
