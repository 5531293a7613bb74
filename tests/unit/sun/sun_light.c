/* glare/sources.c and sun/stage_light.c: lights that join the sources. */
#include "unit.h"
#include "sun/sun_priv.h"
#include "core/memory.h"

enum { W = 40, H = 30, MOST = 4096 };

/* The sources of a small frame that scene_extra pixels made. */
static struct gp_sources with(const struct gp_sources *src,
                              struct gp_source *list, size_t n)
{
    struct gp_sources out;
    assert_int_equal(gp_sources_join(NULL, src, list, n, &out), GP_OK);
    return out;
}

static struct gp_sources none(uint32_t row[H + 1])
{
    memset(row, 0, (H + 1) * sizeof *row);
    return (struct gp_sources) {.w = W, .h = H, .x0 = -3, .y0 = 7};
}

/* -- lists ---------------------------------------------------------------- */

/* What a list says of itself is what its pixels say. */
static void check_sums(const struct gp_sources *s)
{
    double flux[3] = {0}, energy[3] = {0};
    float brightest = 0.0f;
    uint32_t counted = 0;
    for (size_t i = 0; i < s->n; i++) {
        for (int c = 0; c < 3; c++) {
            flux[c] += (double) s->rgb[c][i];
            energy[c] += (double) s->rgb[c][i] * (double) s->rgb[c][i];
            brightest = fmaxf(brightest, s->rgb[c][i]);
        }
    }
    for (int b = 0; b < GP_SOURCE_BINS; b++)
        counted += s->count[b];
    assert_int_equal(counted, s->n);
    assert_true(s->brightest == brightest);
    for (int c = 0; c < 3; c++) {
        assert_true(fabs(s->flux[c] - flux[c]) <= 1e-12 * flux[c]);
        assert_true(fabs(s->energy[c] - energy[c]) <= 1e-12 * energy[c]);
    }
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i + 1 < s->row[y + 1]; i++)
            assert_true(s->x[i] < s->x[i + 1]);
        if (s->row[y] < s->row[y + 1])
            assert_in_range(y, s->box.y0, s->box.y1 - 1);
    }
}

static void pixels_join(void **state)
{
    (void) state;
    uint32_t row[H + 1];
    const struct gp_sources empty = none(row);
    struct gp_sources start = empty;
    start.row = row;
    struct gp_source first[] = {
        {5, 2, {1, 2, 3}}, {7, 2, {4, 4, 4}}, {0, 29, {9, 0, 0}},
    };
    struct gp_sources src = with(&start, first, 3);
    assert_int_equal(src.n, 3);
    check_sums(&src);
    struct gp_source more[] = {
        {7, 2, {1, 1, 1}},  {39, 0, {2, 0, 0}}, {6, 2, {0, 5, 0}},
        {7, 2, {2, 0, 1}},  {3, 3, {0, 0, 0}},  {8, 29, {1, 1, 1}},
    };
    struct gp_sources all = with(&src, more, 6);
    assert_int_equal(all.n, 6); // two on a source, a black one left out
    check_sums(&all);
    assert_int_equal(all.x0, -3);
    assert_int_equal(all.row[1], 1);
    assert_int_equal(all.row[3], 4);
    assert_true(all.rgb[0][3] == 7.0f && all.rgb[1][3] == 5.0f &&
                all.rgb[2][3] == 6.0f);
    assert_true(all.box.x0 == 0 && all.box.x1 == 40 && all.box.y0 == 0 &&
                all.box.y1 == 30);
    gp_sources_free(&src);
    gp_sources_free(&all);
}

static void order_does_not_matter(void **state)
{
    (void) state;
    uint32_t row[H + 1];
    struct gp_sources start = none(row);
    start.row = row;
    struct gp_source a[60], b[60];
    for (int i = 0; i < 60; i++) {
        const float v = 0.1f + (float) (i * 7 % 13) * 0.37f;
        a[i] = b[59 - i] = (struct gp_source) {
            i * 11 % 5, i * 5 % 3, {v, 1.0f / v, v * v},
        };
    }
    struct gp_sources p = with(&start, a, 60), q = with(&start, b, 60);
    assert_int_equal(p.n, 15);
    assert_int_equal(q.n, 15);
    for (int c = 0; c < 3; c++)
        assert_memory_equal(p.rgb[c], q.rgb[c], 15 * sizeof(float));
    assert_memory_equal(p.flux, q.flux, sizeof p.flux);
    gp_sources_free(&p);
    gp_sources_free(&q);
}

static void outside_is_refused(void **state)
{
    (void) state;
    static const int at[][2] = {{-1, 0}, {0, -1}, {W, 0}, {0, H}};
    uint32_t row[H + 1];
    struct gp_sources start = none(row), out;
    start.row = row;
    for (int i = 0; i < 4; i++) {
        struct gp_source one = {at[i][0], at[i][1], {1, 1, 1}};
        assert_int_equal(gp_sources_join(NULL, &start, &one, 1, &out),
                         GP_ERR_BUG);
    }
    struct gp_sources same = with(&start, NULL, 0);
    assert_int_equal(same.n, 0);
    assert_true(gp_rect_empty(same.box));
    gp_sources_free(&same);
}

/* -- discs ---------------------------------------------------------------- */

/* Total and centroid of a light's pixels, from the frame's corner. */
static void moments(const struct gp_source *list, size_t n, double m[3])
{
    m[0] = m[1] = m[2] = 0.0;
    for (size_t i = 0; i < n; i++) {
        m[0] += (double) list[i].rgb[0];
        m[1] += (double) list[i].rgb[0] * (list[i].x + 0.5);
        m[2] += (double) list[i].rgb[0] * (list[i].y + 0.5);
    }
    m[1] /= m[0];
    m[2] /= m[0];
}

/* Flux is kept and the centroid is the light's place, wherever it stands. */
static void a_disc_keeps_flux_and_place(void **state)
{
    (void) state;
    static const double radius[] = {0.0, 0.3, 0.5, 0.51, 1.0, 2.48, 7.9};
    static const struct gp_rect frame = {-3, 7, -3 + W, 7 + H};
    for (int r = 0; r < 7; r++) {
        struct gp_disc_pixels d;
        assert_int_equal(gp_disc_pixels_make(NULL, radius[r], &d), GP_OK);
        for (int step = 0; step < 64; step++) {
            struct gp_source list[MOST];
            size_t n = 0;
            double m[3];
            const struct gp_light l = {
                .x = 14.0 + step / 8.0, .y = 20.0 + step / 32.0,
                .radius = radius[r], .flux = {1000.0f, 10.0f, 1.0f},
                .visibility = 0.25,
            };
            gp_disc_light(&d, &l, frame, list, &n);
            moments(list, n, m);
            assert_true(fabs(m[0] / 250.0 - 1.0) < 1e-6);
            assert_true(fabs(m[1] - 3.0 - l.x) < 1e-5);
            assert_true(fabs(m[2] + 7.0 - l.y) < 1e-5);
        }
        gp_free(d.weight);
    }
}

/* Beyond the frame there is no pixel, and no light either. */
static void a_disc_is_cut_to_the_frame(void **state)
{
    (void) state;
    static const struct { double x, y, share; } row[] = {
        {0.0, 15.0, 0.5}, {0.0, 0.0, 0.25}, {40.0, 15.0, 0.5},
        {-90.0, 15.0, 0.0}, {1e300, 15.0, 0.0}, {-1e9, -1e9, 0.0},
    };
    struct gp_disc_pixels d;
    assert_int_equal(gp_disc_pixels_make(NULL, 6.0, &d), GP_OK);
    for (int i = 0; i < 6; i++) {
        struct gp_source list[MOST];
        size_t n = 0;
        double total = 0.0;
        const struct gp_light l = {
            .x = row[i].x, .y = row[i].y, .radius = 6.0,
            .flux = {1.0f, 1.0f, 1.0f}, .visibility = 1.0,
        };
        gp_disc_light(&d, &l, (struct gp_rect) {0, 0, W, H}, list, &n);
        for (size_t k = 0; k < n; k++)
            total += (double) list[k].rgb[0];
        assert_true(fabs(total - row[i].share) < 1e-6);
    }
    gp_free(d.weight);
}

SUITE_OF(sun_light, NULL, NULL,
    pixels_join, order_does_not_matter, outside_is_refused,
    a_disc_keeps_flux_and_place, a_disc_is_cut_to_the_frame)
