// SPDX-License-Identifier: Apache-2.0
/* compare/figures.c: figures against sums written out, equal
 * values that are not numbers, windows, names, whole numbers. */
#include "unit.h"
#include "compare/compare.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"

static const struct glarepp_compare_params defaults = GLAREPP_COMPARE_PARAMS;

enum { CHANNELS = 8, ROOM = 4096 };

/* An image on the stack; channel names are one letter each. */
struct image {
    struct glarepp_stored raw;
    struct glarepp_channel channel[CHANNELS];
    char name[CHANNELS][2];
    float v[CHANNELS][ROOM];
};

/* A channel for each letter of `names`, all 0; light where R, G and B are. */
static void image_make(struct image *m, const char *names,
                       struct gp_rect window)
{
    memset(m, 0, sizeof *m);
    m->raw.data = (struct glarepp_rect) {window.x0, window.y0, window.x1,
                                         window.y1};
    m->raw.channel = m->channel;
    m->raw.channels = (int) strlen(names);
    for (int i = 0; i < m->raw.channels; i++) {
        m->name[i][0] = names[i];
        m->channel[i] = (struct glarepp_channel) {m->name[i], m->v[i], false};
    }
    const bool lit = strchr(names, 'R') && strchr(names, 'G') &&
                     strchr(names, 'B');
    for (int k = 0; lit && k < 3; k++)
        m->raw.light[k] = m->v[strchr(names, "RGB"[k]) - names];
}

static struct image a, b;

static void make_both(const char *names, int x0, int y0, int x1, int y1)
{
    image_make(&a, names, (struct gp_rect) {x0, y0, x1, y1});
    image_make(&b, names, (struct gp_rect) {x0, y0, x1, y1});
}

static void image_random(struct image *m, unsigned seed)
{
    const struct glarepp_rect r = m->raw.data;
    const size_t n = (size_t) (r.x1 - r.x0) * (size_t) (r.y1 - r.y0);
    for (int c = 0; c < m->raw.channels; c++) {
        for (size_t i = 0; i < n; i++) {
            seed = seed * 1664525u + 1013904223u;
            m->v[c][i] = (float) (seed >> 8) / (float) (1 << 22);
        }
    }
}

static struct glarepp_compare_facts measure(const struct glarepp_compare_params *s)
{
    struct gp_compare_match m;
    struct glarepp_compare_facts f;
    assert_ok(gp_compare_match_make(NULL, &a.raw, &b.raw, &m));
    assert_ok(gp_compare_measure(NULL, s, &m, &f));
    gp_compare_match_free(&m);
    gp_compare_match_free(&m);
    return f;
}

static int judge(const struct glarepp_compare_params *s)
{
    struct glarepp_compare_facts f = measure(s);
    gp_compare_judge(s, &f);
    return f.result;
}

// -- figures -----------------------------------------------------------------

static void two_pixels(void **state)
{
    make_both("R", 0, 0, 2, 1);
    a.v[0][0] = 3.0f, a.v[0][1] = -4.0f;
    b.v[0][0] = 3.0f, b.v[0][1] = -4.5f;
    const struct glarepp_compare_facts f = measure(&defaults);
    assert_true(f.max == 0.5 && f.x == 1 && f.y == 0 && f.channel == 0);
    assert_true(f.worst_a == -4.0 && f.worst_b == -4.5);
    assert_true(f.mean == 0.25 && fabs(f.rms - sqrt(0.125)) < 1e-15);
    assert_true(fabs(f.psnr - 20.0 * log10(4.5 / sqrt(0.125))) < 1e-12);
    assert_true(fabs(f.rel_l2 - 0.1) < 1e-15);
    assert_true(isnan(f.max_rel)); // no colour
    assert_int_equal(f.failed, 1);
    assert_int_equal(f.warned, 1);
    assert_int_equal(judge(&defaults), GP_COMPARE_FAILURE);
}

static void luminance_is_relative(void **state)
{
    make_both("BGR", 0, 0, 2, 1);
    for (int c = 0; c < 3; c++) {
        a.v[c][0] = b.v[c][0] = 10.0f;
        a.v[c][1] = b.v[c][1] = 0.0f;
    }
    b.v[1][0] = 11.0f; // green
    struct glarepp_compare_facts f = measure(&defaults);
    assert_true(fabs(f.max_rel - (double) gp_rec709_luminance[1] / 10.0) <
                1e-6);
    b.v[1][0] = 10.0f;
    b.v[1][1] = 1.0f; // the first is black there: over 1e-6 of its maximum
    f = measure(&defaults);
    assert_true(fabs(f.max_rel * 1e-5 - (double) gp_rec709_luminance[1]) <
                1e-5);
    b.v[1][1] = NAN;
    assert_true(isinf(measure(&defaults).max_rel));
}

/* Each pair of values that are no numbers has its own answer. */
static void values_that_are_no_numbers(void **state)
{
    static const struct { float a, b; bool same; } rows[] = {
        {NAN, NAN, true},        {-NAN, NAN, true},
        {INFINITY, INFINITY, true}, {-INFINITY, -INFINITY, true},
        {INFINITY, -INFINITY, false}, {NAN, INFINITY, false},
        {NAN, 0.0f, false},      {0.0f, NAN, false},
        {INFINITY, 3e38f, false}, {-3e38f, -INFINITY, false},
        {0.0f, -0.0f, true},     {1e-40f, 0.0f, true},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        make_both("Z", -3, -2, 4, 3);
        a.v[0][9] = rows[i].a;
        b.v[0][9] = rows[i].b;
        const struct glarepp_compare_facts f = measure(&defaults);
        assert_int_equal(judge(&defaults), rows[i].same ? GP_COMPARE_MATCH
                                                        : GP_COMPARE_FAILURE);
        assert_int_equal(f.nonfinite, !rows[i].same);
        assert_int_equal(f.failed, !rows[i].same);
        assert_true(isfinite(f.mean) && isfinite(f.rms));
        if (!rows[i].same)
            assert_true(isinf(f.max) && f.x == -1 && f.y == -1);
    }
}

/* Five of a hundred pixels are off by 1. */
static void limits_are_idiffs(void **state)
{
    const float none = INFINITY;
    enum { MATCH = GP_COMPARE_MATCH, WARNING = GP_COMPARE_WARNING,
           FAILURE = GP_COMPARE_FAILURE };
    const struct {
        float fail, fail_percent, hard_fail;
        int allowed;
        float warn, warn_percent, hard_warn;
        int wanted;
    } rows[] = {
        {1e-6f, 5.0f, none, 0, 1e-6f, 5.0f, none, MATCH},
        {1e-6f, 5.0f, none, 0, 1e-6f, 4.9f, none, WARNING},
        {1e-6f, 4.9f, none, 0, 1e-6f, 4.9f, none, FAILURE},
        {1e-6f, 5.0f, none, 0, 1e-6f, 5.0f, 0.5f, WARNING},
        {1e-6f, 5.0f, 0.5f, 0, 1e-6f, 5.0f, none, FAILURE},
        // nothing is over --fail: whatever else is asked
        {1.0f, 0.0f, none, 0, 1e-6f, 0.0f, none, MATCH},
        {1.0f, 0.0f, 0.5f, 0, 1e-6f, 0.0f, 0.5f, MATCH},
        {1e-6f, 0.0f, 0.5f, 5, 1e-6f, 0.0f, 0.5f, MATCH},
        {1e-6f, 0.0f, none, 4, 1.0f, 0.0f, none, FAILURE},
        {1e-6f, 0.0f, 0.5f, -1, 1e-6f, 0.0f, none, MATCH},
        {1e-6f, 150.0f, none, 0, 1e-6f, 150.0f, none, MATCH},
    };
    struct glarepp_compare_params s = defaults;
    make_both("R", 0, 0, 10, 10);
    for (int i = 0; i < 5; i++)
        b.v[0][i] = 1.0f;
    for (size_t i = 0; i < COUNT(rows); i++) {
        s.fail = rows[i].fail, s.fail_percent = rows[i].fail_percent;
        s.hard_fail = rows[i].hard_fail, s.allow_failures = rows[i].allowed;
        s.warn = rows[i].warn, s.warn_percent = rows[i].warn_percent;
        s.hard_warn = rows[i].hard_warn;
        assert_int_equal(judge(&s), rows[i].wanted);
    }
    s = defaults;
    s.warn_relative = 2.0f; // 1 against 0 is 2 of their mean
    assert_int_equal(measure(&s).warned, 0);
    s.warn_relative = 1.99f;
    assert_int_equal(measure(&s).warned, 5);
}

static void limits_of_our_own(void **state)
{
    struct glarepp_compare_params s = defaults;
    make_both("R", 0, 0, 2, 1);
    a.v[0][0] = b.v[0][0] = 3.0f;
    a.v[0][1] = 4.0f, b.v[0][1] = 4.5f; // rel_l2 0.1
    s.fail = s.warn = INFINITY;
    const struct { float rel, flip; int wanted; } rows[] = {
        {0.11f, 0.21f, GP_COMPARE_MATCH}, {0.09f, 0.21f, GP_COMPARE_FAILURE},
        {0.11f, 0.19f, GP_COMPARE_FAILURE},
        {INFINITY, INFINITY, GP_COMPARE_MATCH},
    };
    struct glarepp_compare_facts f = measure(&s);
    f.has_flip = true;
    f.flip = 0.2;
    for (size_t i = 0; i < COUNT(rows); i++) {
        s.fail_rel = rows[i].rel, s.fail_flip = rows[i].flip;
        gp_compare_judge(&s, &f);
        assert_int_equal(f.result, rows[i].wanted);
    }
    b.v[0][1] = NAN; // no limit lets that pass
    s.fail_rel = s.fail_flip = INFINITY;
    assert_int_equal(judge(&s), GP_COMPARE_FAILURE);
}

// -- names and windows -------------------------------------------------------

static void names_decide(void **state)
{
    image_make(&a, "ABGR", (struct gp_rect) {0, 0, 5, 4});
    image_random(&a, 1);
    image_make(&b, "RAGB", (struct gp_rect) {0, 0, 5, 4});
    // a: A B G R at 0..3; b: R A G B
    memcpy(b.v[0], a.v[3], sizeof *a.v);
    memcpy(b.v[1], a.v[0], sizeof *a.v);
    memcpy(b.v[2], a.v[2], sizeof *a.v);
    memcpy(b.v[3], a.v[1], sizeof *a.v);
    struct glarepp_compare_facts f = measure(&defaults);
    assert_true(f.max == 0.0 && f.max_rel == 0.0);
    assert_int_equal(judge(&defaults), GP_COMPARE_MATCH);
}

/* Channels that no name fits are taken in their order. */
static void numbers_decide_where_no_name_does(void **state)
{
    static const struct { const char *a, *b, *wanted; } rows[] = {
        {"ABGR", "XG", "R-X G-G B-0 A-0 "}, {"Y", "RGB", "G-0 B-0 Y-R "},
        {"RGB", "Y", "R-Y G-0 B-0 "}, {"RX", "YR", "R-R X-Y "},
        {"XY", "UVW", "X-U Y-V W-0 "}, {"RGBZ", "RGBAZ", "R-R G-G B-B A-0 Z-Z "},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_compare_match m;
        char text[64] = "";
        image_make(&a, rows[i].a, (struct gp_rect) {0, 0, 5, 4});
        image_make(&b, rows[i].b, (struct gp_rect) {0, 0, 5, 4});
        assert_ok(gp_compare_match_make(NULL, &a.raw, &b.raw, &m));
        for (int k = 0; k < m.pairs; k++) {
            const int in_b = m.in[0][k] < 0 ? -1 : m.in[1][k];
            snprintf(text + 4 * k, 5, "%s-%s ", m.name[k],
                     in_b < 0 ? "0" : b.raw.channel[in_b].name);
        }
        assert_string_equal(text, rows[i].wanted);
        gp_compare_match_free(&m);
    }
}

// -- visible pixels ----------------------------------------------------------

/* Counts by both orders, with 1 and 5 threads, which must agree. */
static long long see(void)
{
    long long seen[4];
    for (int i = 0; i < 4; i++) {
        struct gp_compare_match m;
        gp_set_threads(i < 2 ? 1 : 5);
        assert_ok(gp_compare_match_make(NULL, i % 2 ? &b.raw : &a.raw,
                                        i % 2 ? &a.raw : &b.raw, &m));
        assert_ok(gp_compare_see(NULL, &m, &seen[i]));
        gp_compare_match_free(&m);
        assert_true(seen[i] == seen[0]);
    }
    gp_set_threads(0);
    return seen[0];
}

static void an_eye_sees(void **state)
{
    make_both("RGB", -7, 3, 57, 67);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < ROOM; i++)
            a.v[c][i] = b.v[c][i] = 0.1f;
    }
    assert_true(see() == 0);
    for (int y = 17; y <= 27; y++) { // OpenImageIO's own case, testsuite/diff
        for (int x = 5; x <= 15; x++)
            b.v[1][y * 64 + x] = 0.6f;
    }
    assert_true(see() == 121);
    for (int i = 0; i < ROOM; i++) // under 1 % is not seen, but a difference
        b.v[1][i] = 0.1005f;
    assert_true(see() == 0 && judge(&defaults) == GP_COMPARE_FAILURE);
    for (int i = 0; i < ROOM; i++) // the same luminance in another colour
        b.v[0][i] = 0.1f + 0.05f / 0.2126f, b.v[1][i] = 0.1f - 0.05f / 0.7152f;
    assert_true(see() == ROOM);
    memcpy(b.v, a.v, sizeof a.v);
    a.v[1][70] = b.v[1][70] = b.v[0][99] = NAN;
    assert_true(see() == 1);
}

/* A step that is seen in an even field is not, in one of strong contrasts. */
static void contrasts_hide(void **state)
{
    long long seen[2];
    for (int k = 0; k < 2; k++) {
        make_both("RGB", 0, 0, 64, 64);
        for (int i = 0; i < ROOM; i++) {
            const float v = k ? 0.5f + 0.45f * (float) ((i & 1) ^ (i >> 6 & 1))
                              : 0.5f;
            for (int c = 0; c < 3; c++) {
                a.v[c][i] = v;
                b.v[c][i] = v + 0.04f;
            }
        }
        seen[k] = see();
    }
    assert_true(seen[0] == ROOM && seen[1] == 0);
}

static void windows_are_joined(void **state)
{
    image_make(&a, "R", (struct gp_rect) {-5, -5, -3, -4}); // 2 x 1
    image_make(&b, "R", (struct gp_rect) {2, 3, 3, 5});     // 1 x 2
    for (int i = 0; i < 2; i++)
        a.v[0][i] = b.v[0][i] = 1.0f;
    b.v[0][1] = 2.0f;
    const struct glarepp_compare_facts f = measure(&defaults);
    assert_true(f.max == 2.0 && f.x == 2 && f.y == 4);
    assert_true(fabs(f.mean - 5.0 / (8.0 * 10.0)) < 1e-15);
    assert_int_equal(f.failed, 4);
    assert_int_equal(f.pixels, 2);
}

static void whole_numbers_are_exact(void **state)
{
    uint32_t x[2] = {4000000001u, 7u}, y[2] = {4000000000u, 7u};
    make_both("i", 0, 0, 2, 1);
    a.channel[0] = (struct glarepp_channel) {a.name[0], x, true};
    b.channel[0] = (struct glarepp_channel) {b.name[0], y, true};
    const struct glarepp_compare_facts f = measure(&defaults);
    assert_true(f.max == 1.0 && f.failed == 1); // floats would be equal
}

static void threads_do_not_matter(void **state)
{
    struct glarepp_compare_facts f[2];
    memset(f, 0, sizeof f);
    image_make(&a, "RGB", (struct gp_rect) {0, 0, 61, 53});
    image_make(&b, "RGB", (struct gp_rect) {3, -2, 60, 51});
    image_random(&a, 3);
    image_random(&b, 4);
    for (int i = 0; i < 2; i++) {
        gp_set_threads(i ? 5 : 1);
        f[i] = measure(&defaults);
    }
    gp_set_threads(0);
    assert_true(f[0].mean == f[1].mean && f[0].rms == f[1].rms &&
                f[0].rel_l2 == f[1].rel_l2 && f[0].max == f[1].max &&
                f[0].max_rel == f[1].max_rel && f[0].x == f[1].x &&
                f[0].y == f[1].y && f[0].failed == f[1].failed);
}

// -- FLIP --------------------------------------------------------------------

static struct glarepp_compare_facts flip(void)
{
    struct gp_compare_match m;
    struct glarepp_compare_facts f = {0};
    float *map = NULL;
    assert_ok(gp_compare_match_make(NULL, &a.raw, &b.raw, &m));
    assert_ok(gp_compare_flip(NULL, &defaults, &m, &f, &map));
    gp_free(map);
    gp_compare_match_free(&m);
    assert_true(f.has_flip && f.flip >= 0.0 && f.flip <= 1.0);
    return f;
}

static void flip_fits_the_files(void **state)
{
    image_make(&a, "RGB", (struct gp_rect) {0, 0, 20, 20});
    image_make(&b, "RGB", (struct gp_rect) {2, 1, 22, 21});
    image_random(&a, 1);
    image_random(&b, 2);
    struct glarepp_compare_facts f = flip();
    assert_true(f.hdr && f.flip > 0.0);
    a.v[0][5] = INFINITY; // counts as very bright, and nothing breaks
    a.v[1][5] = NAN;
    assert_true(flip().flip > 0.0);
    a.raw.integers = b.raw.integers = true;
    assert_false(flip().hdr);
    make_both("RGB", 0, 0, 7, 5); // black
    f = flip();
    assert_true(f.flip == 0.0 && f.exposures == 1);
}

static void magma_is_magma(void **state)
{
    // of 255, from the published table
    static const struct { float v, rgb[3]; } rows[] = {
        {0.0f, {0, 0, 4}},       {0.25f, {81, 18, 124}},
        {0.5f, {183, 55, 121}},  {0.75f, {252, 137, 97}},
        {1.0f, {252, 253, 191}}, {2.0f, {252, 253, 191}},
        {-1.0f, {0, 0, 4}},      {NAN, {0, 0, 4}},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        float rgb[3];
        gp_compare_heatmap(&rows[i].v, 1,
                           &(struct gp_planes) {{&rgb[0], &rgb[1], &rgb[2]}});
        for (int c = 0; c < 3; c++)
            assert_true(fabsf(gp_srgb_encode(rgb[c]) * 255.0f -
                              rows[i].rgb[c]) < 6.0f);
    }
}

SUITE_OF(figures, NULL, NULL, two_pixels, luminance_is_relative,
         values_that_are_no_numbers, limits_are_idiffs, limits_of_our_own,
         names_decide, numbers_decide_where_no_name_does, an_eye_sees,
         contrasts_hide, windows_are_joined, whole_numbers_are_exact,
         threads_do_not_matter, flip_fits_the_files, magma_is_magma)
