/* compare/figures.c: figures against sums written out, equal
 * values that are not numbers, windows, names, whole numbers. */
#include "unit.h"
#include "compare/compare_priv.h"
#include "core/colour.h"
#include "core/parallel.h"

static const struct gp_compare_params defaults = GP_COMPARE_DEFAULTS;

enum { CHANNELS = 8, ROOM = 4096 };

/* An image on the stack; channel names are one letter each. */
struct image {
    struct gp_stored_image raw;
    struct gp_stored_channel channel[CHANNELS];
    char name[CHANNELS][2];
    float v[CHANNELS][ROOM];
};

/* A channel for each letter of `names`, all 0; light where R, G and B are. */
static void make(struct image *m, const char *names, struct gp_rect window)
{
    memset(m, 0, sizeof *m);
    m->raw.data = m->raw.display = window;
    m->raw.channel = m->channel;
    m->raw.channels = (int) strlen(names);
    memcpy(m->raw.luminance, gp_rec709_luminance, sizeof m->raw.luminance);
    for (int i = 0; i < m->raw.channels; i++) {
        m->name[i][0] = names[i];
        m->channel[i] = (struct gp_stored_channel) {m->name[i], false, m->v[i]};
    }
    const bool lit = strchr(names, 'R') && strchr(names, 'G') &&
                     strchr(names, 'B');
    for (int k = 0; lit && k < 3; k++)
        m->raw.light[k] = m->v[strchr(names, "RGB"[k]) - names];
}

static struct image a, b;

static void make_both(const char *names, int x0, int y0, int x1, int y1)
{
    make(&a, names, (struct gp_rect) {x0, y0, x1, y1});
    make(&b, names, (struct gp_rect) {x0, y0, x1, y1});
}

static void fill(struct image *m, unsigned seed)
{
    const size_t n = (size_t) gp_rect_w(m->raw.data) *
                     (size_t) gp_rect_h(m->raw.data);
    for (int c = 0; c < m->raw.channels; c++) {
        for (size_t i = 0; i < n; i++) {
            seed = seed * 1664525u + 1013904223u;
            m->v[c][i] = (float) (seed >> 8) / (float) (1 << 22);
        }
    }
}

static struct gp_compare_figures measure(const struct gp_compare_params *s)
{
    struct gp_compare_match m;
    struct gp_compare_figures f;
    assert_ok(gp_compare_match_make(NULL, &a.raw, &b.raw, &m));
    assert_ok(gp_compare_measure(NULL, s, &m, &f));
    gp_compare_match_free(&m);
    gp_compare_match_free(&m);
    return f;
}

// -- figures -----------------------------------------------------------------

static void two_pixels(void **state)
{
    make_both("R", 0, 0, 2, 1);
    a.v[0][0] = 3.0f, a.v[0][1] = -4.0f;
    b.v[0][0] = 3.0f, b.v[0][1] = -4.5f;
    const struct gp_compare_figures f = measure(&defaults);
    assert_true(f.max == 0.5 && f.x == 1 && f.y == 0 && f.channel == 0);
    assert_true(f.worst_a == -4.0 && f.worst_b == -4.5);
    assert_true(f.mean == 0.25 && fabs(f.rms - sqrt(0.125)) < 1e-15);
    assert_true(fabs(f.psnr - 20.0 * log10(4.5 / sqrt(0.125))) < 1e-12);
    assert_true(fabs(f.rel_l2 - 0.1) < 1e-15);
    assert_true(isnan(f.max_rel)); // no colour
    assert_int_equal(f.failed, 1);
    assert_int_equal(f.warned, 1);
    assert_int_equal(f.result, GP_COMPARE_FAILURE);
}

static void luminance_is_relative(void **state)
{
    make_both("BGR", 0, 0, 2, 1);
    for (int c = 0; c < 3; c++) {
        a.v[c][0] = b.v[c][0] = 10.0f;
        a.v[c][1] = b.v[c][1] = 0.0f;
    }
    b.v[1][0] = 11.0f; // green
    struct gp_compare_figures f = measure(&defaults);
    assert_true(fabs(f.max_rel - (double) gp_rec709_luminance[1] / 10.0) <
                1e-6);
    b.v[1][0] = 10.0f;
    b.v[1][1] = 1.0f; // where the first is black: over 1e-6 of its maximum
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
        const struct gp_compare_figures f = measure(&defaults);
        assert_int_equal(f.result, rows[i].same ? GP_COMPARE_MATCH
                                                : GP_COMPARE_FAILURE);
        assert_int_equal(f.nonfinite, !rows[i].same);
        assert_int_equal(f.failed, !rows[i].same);
        assert_true(isfinite(f.mean) && isfinite(f.rms));
        if (!rows[i].same)
            assert_true(isinf(f.max) && f.x == -1 && f.y == -1);
    }
}

static void limits_are_idiffs(void **state)
{
    struct gp_compare_params s = defaults;
    make_both("R", 0, 0, 10, 10);
    for (int i = 0; i < 5; i++)
        b.v[0][i] = 1.0f;
    s.fail_percent = s.warn_percent = 5.0f;
    assert_int_equal(measure(&s).result, GP_COMPARE_MATCH);
    s.warn_percent = 4.9f;
    assert_int_equal(measure(&s).result, GP_COMPARE_WARNING);
    s.fail_percent = 4.9f;
    assert_int_equal(measure(&s).result, GP_COMPARE_FAILURE);
    s = defaults;
    s.fail = s.warn = 1.0f; // not over it
    assert_int_equal(measure(&s).result, GP_COMPARE_MATCH);
    s.hard_warn = 0.5f;
    assert_int_equal(measure(&s).result, GP_COMPARE_WARNING);
    s.hard_fail = 0.5f;
    assert_int_equal(measure(&s).result, GP_COMPARE_FAILURE);
    s = defaults;
    s.warn_relative = 2.0f; // 1 against 0 is 2 of their mean
    assert_int_equal(measure(&s).warned, 0);
    s.warn_relative = 1.99f;
    assert_int_equal(measure(&s).warned, 5);
}

// -- names and windows -------------------------------------------------------

static void names_decide(void **state)
{
    make(&a, "ABGR", (struct gp_rect) {0, 0, 5, 4});
    fill(&a, 1);
    make(&b, "RAGB", (struct gp_rect) {0, 0, 5, 4});
    // a: A B G R at 0..3; b: R A G B
    memcpy(b.v[0], a.v[3], sizeof *a.v);
    memcpy(b.v[1], a.v[0], sizeof *a.v);
    memcpy(b.v[2], a.v[2], sizeof *a.v);
    memcpy(b.v[3], a.v[1], sizeof *a.v);
    struct gp_compare_figures f = measure(&defaults);
    assert_true(f.max == 0.0 && f.max_rel == 0.0);
    assert_int_equal(f.result, GP_COMPARE_MATCH);
    struct gp_compare_match m;
    make(&b, "XG", (struct gp_rect) {0, 0, 5, 4});
    assert_ok(gp_compare_match_make(NULL, &a.raw, &b.raw, &m));
    assert_int_equal(m.pairs, 5);
    assert_int_equal(m.shared, 1);
    assert_string_equal(gp_compare_name(&m, 0), "R");
    assert_string_equal(gp_compare_name(&m, 4), "X");
    gp_compare_match_free(&m);
}

static void windows_are_joined(void **state)
{
    make(&a, "R", (struct gp_rect) {-5, -5, -3, -4}); // 2 x 1
    make(&b, "R", (struct gp_rect) {2, 3, 3, 5});     // 1 x 2
    for (int i = 0; i < 2; i++)
        a.v[0][i] = b.v[0][i] = 1.0f;
    b.v[0][1] = 2.0f;
    const struct gp_compare_figures f = measure(&defaults);
    assert_true(f.max == 2.0 && f.x == 2 && f.y == 4);
    assert_true(fabs(f.mean - 5.0 / (8.0 * 10.0)) < 1e-15);
    assert_int_equal(f.failed, 4);
    assert_int_equal(f.pixels, 2);
}

static void whole_numbers_are_exact(void **state)
{
    uint32_t x[2] = {4000000001u, 7u}, y[2] = {4000000000u, 7u};
    make_both("i", 0, 0, 2, 1);
    a.channel[0] = (struct gp_stored_channel) {a.name[0], true, x};
    b.channel[0] = (struct gp_stored_channel) {b.name[0], true, y};
    const struct gp_compare_figures f = measure(&defaults);
    assert_true(f.max == 1.0 && f.failed == 1); // floats would be equal
}

static void threads_do_not_matter(void **state)
{
    struct gp_compare_figures f[2];
    memset(f, 0, sizeof f);
    make(&a, "RGB", (struct gp_rect) {0, 0, 61, 53});
    make(&b, "RGB", (struct gp_rect) {3, -2, 60, 51});
    fill(&a, 3);
    fill(&b, 4);
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

static struct gp_compare_flip flip(const struct gp_compare_params *s)
{
    struct gp_compare_match m;
    struct gp_compare_flip f;
    assert_ok(gp_compare_match_make(NULL, &a.raw, &b.raw, &m));
    assert_ok(gp_compare_flip(NULL, s, &m, &f));
    gp_compare_match_free(&m);
    return f;
}

static void flip_fits_the_files(void **state)
{
    struct gp_compare_params s = defaults;
    make(&a, "RGB", (struct gp_rect) {0, 0, 20, 20});
    make(&b, "RGB", (struct gp_rect) {2, 1, 22, 21});
    fill(&a, 1);
    fill(&b, 2);
    struct gp_compare_flip f = flip(&s);
    assert_true(f.known && f.hdr && f.mean > 0.0 && f.mean <= 1.0);
    gp_compare_flip_free(&f);
    a.v[0][5] = INFINITY; // counts as very bright, and nothing breaks
    a.v[1][5] = NAN;
    f = flip(&s);
    assert_true(f.known && f.mean > 0.0 && f.mean <= 1.0);
    gp_compare_flip_free(&f);
    a.raw.integers = b.raw.integers = true;
    f = flip(&s);
    assert_true(f.known && !f.hdr);
    gp_compare_flip_free(&f);
    b.raw.light[0] = NULL;
    f = flip(&s);
    assert_false(f.known);
    gp_compare_flip_free(&f);
    s.no_flip = true;
    assert_false(flip(&s).known);
}

static void black_has_flip(void **state)
{
    make_both("RGB", 0, 0, 7, 5);
    struct gp_compare_flip f = flip(&defaults);
    assert_true(f.known && f.mean == 0.0 && f.exposures.count == 1);
    gp_compare_flip_free(&f);
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
        gp_compare_magma(rows[i].v, rgb);
        for (int c = 0; c < 3; c++)
            assert_true(fabsf(rgb[c] * 255.0f - rows[i].rgb[c]) < 6.0f);
    }
}

SUITE_OF(figures, NULL, NULL, two_pixels, luminance_is_relative,
         values_that_are_no_numbers, limits_are_idiffs, names_decide,
         windows_are_joined, whole_numbers_are_exact, threads_do_not_matter,
         flip_fits_the_files, black_has_flip, magma_is_magma)
