// SPDX-License-Identifier: Apache-2.0
/* compare/flip.c: against a form of the papers in double with plain
 * two-dimensional filters (numpy and scipy), and by law. */
#include "unit.h"
#include "compare/compare.h"
#include "core/parallel.h"

#include <float.h>

/* Single precision under a square root: a feature of 1e-9 counts 3e-5. */
static const double NEAR = 3e-4;

static void assert_near(double got, double want, double by, const char *what)
{
    if (!(fabs(got - want) <= by))
        fail_msg("%s is %.8g, not %.8g", what, got, want);
}

struct pair {
    int w, h;
    size_t n;
    struct gp_planes a, b;
    float *map;
};

static struct pair make_pair(int w, int h)
{
    struct pair p = {.w = w, .h = h, .n = (size_t) w * (size_t) h};
    assert_ok(gp_planes_make(NULL, "a", p.n, &p.a));
    assert_ok(gp_planes_make(NULL, "b", p.n, &p.b));
    p.map = calloc(p.n, sizeof *p.map);
    assert_non_null(p.map);
    return p;
}

static void free_pair(struct pair *p)
{
    gp_planes_free(&p->a);
    gp_planes_free(&p->b);
    free(p->map);
}

/* A pattern with edges, and one of less contrast on its right half. */
static struct pair pattern(int w, int h)
{
    struct pair p = make_pair(w, h);
    for (size_t i = 0; i < 3 * p.n; i++) {
        const int c = (int) (i / p.n), at = (int) (i % p.n);
        const int x = at % w, y = at / w;
        float v = (float) ((x * x * 7 + y * 13 + x * y * 3 + c * 57) % 101) /
                  100.0f;
        if ((x / 9 + y / 7) % 3 != c)
            v = 0.25f * (float) (c + 1);
        p.a.c[c][at] = v;
        p.b.c[c][at] = x > w / 2 ? v * 0.75f + 0.125f : v;
    }
    return p;
}

static struct pair flat(int w, int h, const float a[3], const float b[3])
{
    struct pair p = make_pair(w, h);
    for (size_t i = 0; i < 3 * p.n; i++) {
        p.a.c[i / p.n][i % p.n] = a[i / p.n];
        p.b.c[i / p.n][i % p.n] = b[i / p.n];
    }
    return p;
}

static double ldr(struct pair *p)
{
    double mean = NAN;
    assert_ok(gp_flip(NULL, p->w, p->h, &p->a, &p->b, NULL, p->map, &mean));
    return mean;
}

static double hdr(struct pair *p, const struct gp_flip_exposures *e)
{
    double mean = NAN;
    struct gp_flip_exposures found = {0};
    if (!e)
        assert_ok(gp_flip_exposures_find(NULL, p->n, &p->a, &found));
    assert_ok(
        gp_flip(NULL, p->w, p->h, &p->a, &p->b, e ? e : &found, p->map, &mean));
    return mean;
}

// -- LDR ---------------------------------------------------------------------

static void flat_colours_are_as_far_as_they_are(void **state)
{
    static const struct { float a[3], b[3]; double want; } rows[] = {
        {{0, 0, 0}, {1, 1, 1}, 0.967380}, {{1, 0, 0}, {0, 1, 0}, 0.986662},
        {{0, 1, 0}, {0, 0, 1}, 1.0}, {{1, 0, 0}, {0, 0, 1}, 0.965079},
        {{1, 1, 0}, {0, 1, 1}, 0.971958},
        {{.5f, .5f, .5f}, {.6f, .6f, .6f}, 0.196215},
        {{.2f, .3f, .4f}, {.25f, .3f, .4f}, 0.142384},
        {{0, 0, 0}, {.01f, .01f, .01f}, 0.267698},
        {{.18f, .18f, .18f}, {.19f, .18f, .17f}, 0.067320},
        {{.3f, .2f, .1f}, {.3f, .2f, .1f}, 0.0},
        // outside [0,1] there is nothing more to see, and NaN is black
        {{-3, -INFINITY, NAN}, {5, INFINITY, FLT_MAX}, 0.967380},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct pair p = flat(5, 4, rows[i].a, rows[i].b);
        char what[32];
        snprintf(what, sizeof what, "row %zu", i);
        assert_near(ldr(&p), rows[i].want, NEAR, what);
        assert_near((double) p.map[7], rows[i].want, NEAR, what);
        free_pair(&p);
    }
}

static void patterns_agree_with_the_plain_form(void **state)
{
    static const struct {
        int w, h;
        double mean, middle, most;
    } rows[] = {
        {60, 44, 0.0929018, 0.1029685, 0.3343140},
        {7, 3, 0.0905933, 0.0855764, 0.1665924},
        {1, 9, 0.0, 0.0, 0.0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct pair p = pattern(rows[i].w, rows[i].h);
        const double mean = ldr(&p);
        float most = 0.0f;
        for (size_t k = 0; k < p.n; k++)
            most = p.map[k] > most ? p.map[k] : most;
        assert_near(mean, rows[i].mean, NEAR, "mean");
        assert_near((double) most, rows[i].most, NEAR, "the largest");
        assert_near((double) p.map[rows[i].h / 2 * rows[i].w + rows[i].w / 2],
                    rows[i].middle, NEAR, "the middle");
        free_pair(&p);
    }
}

static void laws_hold_at_any_size(void **state)
{
    static const int sizes[][2] = {{1, 1}, {1, 200}, {129, 65}, {130, 3}};
    for (size_t s = 0; s < COUNT(sizes); s++) {
        struct pair p = pattern(sizes[s][0], sizes[s][1]);
        const double mean = ldr(&p);
        float *there = p.map;
        double sum = 0.0;
        for (size_t i = 0; i < p.n; i++) {
            assert_true(p.map[i] >= 0.0f && p.map[i] <= 1.0f);
            sum += (double) p.map[i];
        }
        assert_near(mean, sum / (double) p.n, 1e-9, "mean of the map");
        p.map = calloc(p.n, sizeof *p.map);
        const struct gp_planes a = p.a;
        p.a = p.b;
        p.b = a;
        assert_true(ldr(&p) == mean); // symmetry, to the bit
        assert_memory_equal(p.map, there, p.n * sizeof *there);
        free(there);
        gp_planes_free(&p.b); // a picture and itself
        p.b = p.a;
        assert_true(ldr(&p) == 0.0);
        p.b = (struct gp_planes) {0};
        free_pair(&p);
    }
}

static void one_pixel_is_seen_near_it_alone(void **state)
{
    const float grey[3] = {0.2f, 0.2f, 0.2f};
    struct pair p = flat(200, 100, grey, grey);
    p.b.c[1][50 * 200 + 100] = 1.0f;
    assert_true(ldr(&p) > 0.0);
    for (int y = 0; y < 100; y++) {
        for (int x = 0; x < 200; x++) {
            const int far = abs(x - 100) > abs(y - 50) ? abs(x - 100)
                                                       : abs(y - 50);
            // the filters reach 10 pixels, colours further than features
            if (far == 0)
                assert_true(p.map[y * 200 + x] > 0.1f);
            if (far > 10)
                assert_true(p.map[y * 200 + x] == 0.0f);
        }
    }
    free_pair(&p);
}

// -- HDR ---------------------------------------------------------------------

static void square(struct pair *p, float scale)
{
    for (size_t i = 0; i < 3 * p->n; i++) {
        float *const a = p->a.c[i / p->n], *const b = p->b.c[i / p->n];
        const size_t at = i % p->n;
        a[at] *= a[at] * scale;
        b[at] *= b[at] * scale;
    }
}

static void exposures_fit_the_reference(void **state)
{
    static const struct { int w, h; double mean; } rows[] = {
        {60, 44, 0.1392478}, {31, 70, 0.1420240},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct pair p = pattern(rows[i].w, rows[i].h);
        struct gp_flip_exposures e;
        square(&p, 40.0f);
        assert_ok(gp_flip_exposures_find(NULL, p.n, &p.a, &e));
        assert_near((double) e.start, -3.859875, 1e-4, "start");
        assert_near((double) e.stop, -2.135175, 1e-4, "stop");
        assert_int_equal(e.count, 2);
        const double mean = hdr(&p, NULL);
        assert_near(mean, rows[i].mean, NEAR, "mean");
        assert_true(hdr(&p, &e) == mean); // found or given
        free_pair(&p);
    }
}

/* Medians by a sort, of counts and values that are hard to part. */
static int by_value(const void *a, const void *b)
{
    const float x = *(const float *) a, y = *(const float *) b;
    return (x > y) - (x < y);
}

static void the_median_decides_where_exposures_stop(void **state)
{
    uint32_t seed = 9;
    for (int n = 1; n < 60; n++) {
        struct pair p = make_pair(n, 1);
        float *sorted = calloc((size_t) n, sizeof *sorted);
        for (int i = 0; i < n; i++) {
            seed = seed * 1664525u + 1013904223u;
            const float v =
                1.0f + (float) ((seed >> 16) % (n % 3 ? 5u : 1000u));
            for (int c = 0; c < 3; c++)
                p.a.c[c][i] = v;
            sorted[i] = v;
        }
        qsort(sorted, (size_t) n, sizeof *sorted, by_value);
        const double median = 0.5 * ((double) sorted[n / 2] +
                                     (double) sorted[(n - 1) / 2]);
        struct gp_flip_exposures e;
        assert_ok(gp_flip_exposures_find(NULL, p.n, &p.a, &e));
        assert_near((double) (e.stop - e.start),
                    log2((double) sorted[n - 1] / median), 1e-5, "the range");
        free(sorted);
        free_pair(&p);
    }
}

static void dark_and_hostile_references_have_exposures(void **state)
{
    static const struct {
        float v[4]; // of a frame of 4 grey pixels
        float range;
        int count;
    } rows[] = {
        {{0, 0, 0, 0}, 0, 1}, {{-1, -INFINITY, NAN, 0}, 0, 1},
        {{0, 0, 0, 8}, 0, 2}, // the median of what is lit
        {{0, 0, 2, 8}, 3, 3}, {{1, 1, 1, 1024}, 10, 10},
        {{1e-30f, 1e-30f, 1e-30f, INFINITY}, 149.486f, GP_FLIP_EXPOSURES_MAX},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct pair p = make_pair(4, 1);
        struct gp_flip_exposures e;
        for (int k = 0; k < 12; k++) {
            p.a.c[k / 4][k % 4] = rows[i].v[k % 4];
            p.b.c[k / 4][k % 4] = 1.0f;
        }
        assert_ok(gp_flip_exposures_find(NULL, p.n, &p.a, &e));
        assert_near((double) (e.stop - e.start), (double) rows[i].range, 2e-3,
                    "the range");
        assert_int_equal(e.count, rows[i].count);
        const double mean = hdr(&p, NULL);
        assert_true(mean >= 0.0 && mean <= 1.0);
        free_pair(&p);
    }
}

static void the_largest_of_all_exposures_counts(void **state)
{
    struct pair p = pattern(40, 30);
    square(&p, 40.0f);
    const struct gp_flip_exposures all = {-4.0f, 2.0f, 4};
    float *most = calloc(p.n, sizeof *most);
    for (int i = 0; i < all.count; i++) {
        const struct gp_flip_exposures one = {-4.0f + 2.0f * (float) i, 99.0f,
                                              1};
        (void) hdr(&p, &one);
        for (size_t k = 0; k < p.n; k++)
            most[k] = p.map[k] > most[k] ? p.map[k] : most[k];
    }
    (void) hdr(&p, &all);
    assert_memory_equal(p.map, most, p.n * sizeof *most);
    gp_planes_free(&p.b);
    p.b = p.a;
    assert_true(hdr(&p, NULL) == 0.0);
    p.b = (struct gp_planes) {0};
    free(most);
    free_pair(&p);
}

static void what_makes_no_sense_is_refused(void **state)
{
    static const struct gp_flip_exposures rows[] = {
        {0, 0, 0}, {0, 0, 65}, {NAN, 0, 2}, {0, INFINITY, 2},
    };
    struct pair p = pattern(2, 2);
    for (size_t i = 0; i < COUNT(rows); i++) {
        double mean = 7.0;
        assert_int_equal(
            gp_flip(NULL, 2, 2, &p.a, &p.b, &rows[i], p.map, &mean),
            GP_ERR_USAGE);
        assert_true(mean == 7.0);
    }
    free_pair(&p);
}

SUITE_OF(flip, NULL, NULL, flat_colours_are_as_far_as_they_are,
    patterns_agree_with_the_plain_form, laws_hold_at_any_size,
    one_pixel_is_seen_near_it_alone, exposures_fit_the_reference,
    the_median_decides_where_exposures_stop,
    dark_and_hostile_references_have_exposures,
    the_largest_of_all_exposures_counts, what_makes_no_sense_is_refused)
