/* glare/direct/quad.c: quads hold all light once, and their sum is the sum. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "hard_cases.h"

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
    struct gp_frame f = scene_frame(c->w, c->h, 0, 0, DARK, seed);
    for (int i = 0; i < c->w * c->h; i++) {
        const float v = shines(c->pattern, i % c->w, i / c->w, c->w, c->h)
                            ? 2.0f + 100.0f * scene_random(&seed)
                            : 0.0f;
        for (int k = 0; k < 3; k++)
            f.rgb.c[k][i] = v * (1.0f - 0.2f * (float) k);
    }
    return scene_sense(f, scene_kernel(c->kw, c->kh, c->cx, c->cy, TINTED),
                       &(struct gp_sensor_params) GP_SENSOR_DEFAULTS);
}

/* Source (x, y) of a channel, 0 where it is dark or outside. */
static float light_at(const struct gp_sources *s, int c, int x, int y)
{
    if (y < 0 || y >= s->h)
        return 0.0f;
    for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
        if (s->x[i] == x)
            return s->rgb[c][i];
    }
    return 0.0f;
}

static void check_quads(const struct gp_sources *s, const struct gp_quads *q)
{
    uint32_t n = 0;
    for (int y = 1 - GP_QUAD; y < s->h; y++) {
        assert_int_equal(q->row[y + GP_QUAD - 1], n);
        for (int x = 0; x < s->w; x++) {
            float light[3][GP_QUAD], most = 0.0f;
            for (int i = 0; i < 3 * GP_QUAD; i++) {
                light[i / GP_QUAD][i % GP_QUAD] =
                    light_at(s, i / GP_QUAD, x, y + i % GP_QUAD);
                most = fmaxf(most, light[i / GP_QUAD][i % GP_QUAD]);
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

/* The sum in double, on what the layer holds at first. */
static void sum_plainly(const struct gp_sources *s, const struct gp_taps *t,
                        int c, double first, double *out)
{
    for (int i = 0; i < s->w * s->h; i++)
        out[i] = first;
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            for (int j = 0; j < t->w * t->h; j++) {
                const int x = s->x[i] + j % t->w - t->cx;
                const int to = y + j / t->w - t->cy;
                if (x < 0 || x >= s->w || to < 0 || to >= s->h)
                    continue;
                const float k = t->k[c][(size_t) (j / t->w) * t->pitch +
                                        GP_TAPS_PAD + (size_t) (j % t->w)];
                out[to * s->w + x] += (double) s->rgb[c][i] * (double) k;
            }
        }
    }
}

static void check_sum(const struct quad_case *row, const struct scene *s,
                      const struct gp_taps *t, bool add)
{
    const size_t n = gp_frame_pixels(&s->f);
    struct gp_planes layer, again;
    struct gp_quads q;
    double *const exact = scene_alloc(n, sizeof *exact);
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
    for (int c = 0; c < 3; c++) {
        sum_plainly(&s->src, t, c, add ? 0.5 : 0.0, exact);
        for (size_t i = 0; i < n; i++) {
            if (!(fabs((double) layer.c[c][i] - exact[i]) <= 1e-6 * exact[i]))
                fail_msg("%dx%d pattern %d add %d: sample %zu is %.9g not %.9g",
                         row->w, row->h, (int) row->pattern, add, i,
                         (double) layer.c[c][i], exact[i]);
        }
    }
    free(exact);
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

SUITE_OF(direct_quad, ask_quick, NULL,
    quads_hold_the_light, quads_sum_like_sources, the_form_goes_with_the_light)
