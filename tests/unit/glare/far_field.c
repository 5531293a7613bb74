// SPDX-License-Identifier: Apache-2.0
/* glare/far_field against the plain double sum, its laws, and its bound. */
#include "unit.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
#include "glare_scene.h"

/* The eye's veil, Spencer et al. 1995, f1 and f2, sampled: light a pixel
 * `degrees` wide gets, so far from its source. */
static void veil(const void *ctx, int x, int y, double out[3])
{
    const double degrees = *(const double *) ctx;
    const double pi = acos(-1.0), t = degrees * hypot(x, y);
    const double p = 0.478 * 20.91 / pow(t + 0.02, 3.0) +
                     0.138 * 72.37 / pow(t + 0.02, 2.0);
    out[0] = p * pow(degrees * pi / 180.0, 2.0);
    out[1] = 0.5 * out[0];
    out[2] = out[0] * exp(-t);
}
static const double fine = 1.0 / 36.0;

struct made {
    struct gp_far_field *t;
    struct gp_far_state *s;
};

static struct made make_far(int w, int h, bool grey, const double *degrees)
{
    const struct gp_far_split split = gp_far_choose(0.0, 1.0, 0, w, h);
    struct made m = {0};
    assert_true(split.step > 0);
    assert_ok(gp_far_make(NULL, &split, w, h,
        &(struct gp_far_kernel) {veil, degrees, grey, true}, &m.t));
    assert_ok(gp_far_open(NULL, m.t, &m.s));
    return m;
}

static void drop_far(struct made *m)
{
    gp_far_close(&m->s);
    gp_far_free(m->t);
}

/* n lights of 0.5 to 1.5 times `light` at random. */
static struct gp_sources lights(int w, int h, int n, float light, uint32_t seed)
{
    const struct gp_sources like = {.w = w, .h = h};
    struct gp_sources none, s;
    struct gp_source *list = scene_alloc((size_t) n, sizeof *list);
    assert_ok(gp_sources_make(NULL, &like, 0, &none));
    gp_sources_finish(&none);
    for (int i = 0; i < n; i++) {
        list[i].x = (int) (scene_random(&seed) * (float) w);
        list[i].y = (int) (scene_random(&seed) * (float) h);
        for (int c = 0; c < 3; c++)
            list[i].rgb[c] = light * (0.5f + scene_random(&seed));
    }
    assert_ok(gp_sources_join(NULL, &none, list, (size_t) n, &s));
    gp_sources_free(&none);
    free(list);
    return s;
}

/* The far field of sources, added to black. */
static struct gp_planes added(const struct made *m, const struct gp_sources *s)
{
    const size_t n = (size_t) s->w * (size_t) s->h;
    struct gp_planes p;
    struct gp_far_rows *rows = NULL;
    assert_ok(gp_planes_make(NULL, "layer", n, &p));
    for (int c = 0; c < 3; c++)
        memset(p.c[c], 0, n * sizeof(float));
    assert_ok(gp_far_find(NULL, m->t, m->s, s, s->w, s->h, &p, &rows));
    gp_parallel_do(3 * s->h, gp_far_add_row, rows);
    gp_far_rows_free(&rows);
    return p;
}

/* The far field's samples as a kernel, for the plain sum. */
static struct gp_kernel plain(const struct made *m, const double *degrees)
{
    const int w = 2 * m->t->w - 1, h = 2 * m->t->h - 1;
    struct gp_planes p;
    struct gp_kernel k;
    assert_ok(gp_planes_make(NULL, "tail", (size_t) w * (size_t) h, &p));
    for (int i = 0; i < w * h; i++) {
        const int x = i % w - w / 2, y = i / w - h / 2;
        double v[3];
        veil(degrees, x, y, v);
        for (int c = 0; c < 3; c++)
            p.c[c][i] = (float) (v[m->t->grey ? 0 : c] *
                                 gp_far_share(&m->t->split, x, y));
    }
    assert_ok(gp_kernel_of_planes(NULL, "tail", w, h, &p, &k));
    return k;
}

/* The error of a far field against the plain sum, over its limits. */
struct error {
    double norm, pixel, layer; // the last: the error's norm over the sum's
};

static struct error compare(const struct made *m, const struct gp_sources *s,
                            const double *degrees)
{
    const size_t n = (size_t) s->w * (size_t) s->h;
    struct gp_kernel k = plain(m, degrees);
    struct gp_planes p = added(m, s);
    double *const exact = scene_alloc(3 * n, sizeof *exact);
    struct error e = {0};
    double error = 0.0, layer = 0.0, light = 0.0;
    assert_ok(gp_glare_reference(NULL, NULL, s, &k, NULL, exact));
    for (int c = 0; c < 3; c++) {
        double most = 0.0;
        for (size_t i = 0; i < n; i++) {
            const double want = exact[(size_t) c * n + i];
            const double d = (double) p.c[c][i] - want;
            assert_true(p.c[c][i] >= 0.0f);
            error += d * d;
            layer += want * want;
            most = fmax(most, fabs(d));
        }
        light += s->energy[c];
        e.pixel = fmax(e.pixel, most / gp_far_pixel_error(m->s, m->t, s, c));
    }
    e.norm = sqrt(error / light) / gp_far_error_of(m->s)->norm;
    e.layer = sqrt(error / layer);
    free(exact);
    gp_planes_free(&p);
    gp_kernel_free(&k);
    return e;
}

static void sums_are_those_of_the_kernel(void **state)
{
    static const double finer = 1.0 / 72.0, coarser = 1.0 / 12.0;
    static const struct {
        int w, h, n;
        bool grey;
        const double *degrees;
        float light;
    } rows[] = {
        {320, 240, 40, true, &fine, 1.0f},
        {331, 97, 300, false, &finer, 1.0f},
        {1, 400, 40, true, &fine, 1e9f},
        {400, 1, 40, true, &fine, 1e-30f},
        {197, 193, 1, false, &fine, 1.0f},
        {256, 192, 40, true, &coarser, 1.0f},
        {16384, 2, 40, true, &fine, 1.0f}, // steps of 32
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        const int w = rows[i].w, h = rows[i].h;
        struct made m = make_far(w, h, rows[i].grey, rows[i].degrees);
        struct gp_sources s = lights(w, h, rows[i].n, rows[i].light,
                                     (uint32_t) i);
        const struct error e = compare(&m, &s, rows[i].degrees);
        print_message("%dx%d: %.2g of the norm, %.2g of a pixel, %.2g\n", w, h,
                      e.norm, e.pixel, e.layer);
        assert_true(e.norm <= 1.0 && e.pixel <= 1.0 && e.layer < 1e-3);
        gp_sources_free(&s);
        drop_far(&m);
    }
}

/* A far field that waves along x, some way right of its light, as no model's
 * does: pixels. */
struct wave {
    double at, wide, high, period;
};

static double across(const struct wave *w, int x)
{
    const double z = (x - w->at) / w->wide;
    return exp(-0.5 * z * z) * (1.0 + cos(2.0 * acos(-1.0) * x / w->period));
}

static double down(const struct wave *w, int y)
{
    return exp(-0.5 * y * y / (w->high * w->high));
}

static void waving(const void *ctx, int x, int y, double out[3])
{
    out[0] = across(ctx, x) * down(ctx, y);
}

static struct made make_wave(int w, int h, int step, const struct wave *wave)
{
    const struct gp_far_split split = {.from = 1.0, .to = 2.0, .step = step};
    struct made m = {0};
    assert_ok(gp_far_make(NULL, &split, w, h,
                          &(struct gp_far_kernel) {waving, wave, true, false},
                          &m.t));
    assert_ok(gp_far_open(NULL, m.t, &m.s));
    return m;
}

/* The light of columns [0, n), along[x], in rows [y0, y1). */
struct columns {
    const float *along; // of either sign
    int n, y0, y1;
};

static struct gp_sources sources_of(const struct made *m,
                                    const struct columns *l)
{
    const struct gp_sources like = {.w = m->t->w, .h = m->t->h};
    struct gp_sources s;
    assert_ok(
        gp_sources_make(NULL, &like, (size_t) (l->n * (l->y1 - l->y0)), &s));
    for (int i = l->y0 * l->n; i < l->y1 * l->n; i++) {
        const float v = fabsf(l->along[i % l->n]), rgb[3] = {v, v, v};
        if (v > 0.0f)
            gp_sources_add(&s, i % l->n, i / l->n, rgb);
    }
    gp_sources_finish(&s); // wants sizes
    for (size_t i = 0; i < s.n; i++)
        s.rgb[0][i] = l->along[s.x[i]];
    return s;
}

/* Returns the error's norm over the light's, and its largest sample over the
 * limit. The far field is added to `over`, so that no sample becomes negative. */
static double wave_error(const struct made *m, const struct wave *wave,
                         const struct columns *l, float over, double *pixel)
{
    const int w = m->t->w, h = m->t->h;
    const size_t pixels = (size_t) w * (size_t) h;
    struct gp_sources s = sources_of(m, l);
    struct gp_planes p;
    struct gp_far_rows *rows = NULL;
    double norm = 0.0, *const high = scene_alloc((size_t) h, sizeof *high);
    assert_ok(gp_planes_make(NULL, "layer", pixels, &p));
    for (size_t i = 0; i < 3 * pixels; i++)
        p.c[i / pixels][i % pixels] = over;
    assert_ok(gp_far_find(NULL, m->t, m->s, &s, s.w, s.h, &p, &rows));
    gp_parallel_do(3 * h, gp_far_add_row, rows);
    gp_far_rows_free(&rows);
    for (int y = l->y0; y < l->y1; y++) {
        for (int to = 0; to < h; to++)
            high[to] += down(wave, to - y);
    }
    double largest = 0.0;
    for (int x = 0; x < w; x++) {
        double exact = 0.0;
        for (int from = 0; from < l->n; from++) {
            if (l->along[from] != 0.0f)
                exact += (double) l->along[from] * across(wave, x - from);
        }
        for (int y = 0; y < h; y++) {
            const double d =
                (double) (p.c[0][y * w + x] - over) - exact * high[y];
            norm += d * d;
            largest = fmax(largest, fabs(d));
        }
    }
    norm = sqrt(norm / s.energy[0]);
    *pixel = largest / gp_far_pixel_error(m->s, m->t, &s, 0);
    gp_planes_free(&p);
    gp_sources_free(&s);
    free(high);
    return norm;
}

/* Light that a kernel has between the frequencies of the grid and the next ones is in
 * the limits: of light that waves alike, of the column and of the worst pixel of
 * one light. So are images of what the grid holds. */
static void what_the_grid_does_not_hold_is_in_the_limits(void **state)
{
    // waves a step, the grid holds up to 0.5; least parts of the limits
    static const struct {
        double periods, norm, pixel, column;
    } rows[] = {{0.57, 0.5, 0.0, 0.3}, {0.4, 0.0, 0.6, 0.9}};
    enum { LIT = 1100, H = 160 };
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct wave wave = {600.0, 120.0, 16.0, 8.0 / rows[i].periods};
        struct made m = make_wave(1800, H, 8, &wave);
        const struct gp_far_error *const e = gp_far_error_of(m.s);
        float light[LIT];
        double one_pixel, pixel = 0.0, column = 0.0;
        for (int x = 0; x < LIT; x++)
            light[x] = (float) (0.01 * cos(2.0 * acos(-1.0) * x / wave.period));
        const double norm =
            wave_error(&m, &wave, &(struct columns) {light, LIT, 0, H}, 64.0f,
                       &one_pixel) /
            e->norm;
        for (int x = 400; x < 408; x++) {
            const struct columns one = {light, LIT, 80, 81};
            memset(light, 0, sizeof light);
            light[x] = 1.0f;
            column =
                fmax(column, wave_error(&m, &wave, &one, 64.0f, &one_pixel) /
                                 e->column);
            pixel = fmax(pixel, one_pixel);
        }
        print_message("%.2g of the norm, %.2g of a pixel, %.2g of a column\n",
                      norm, pixel, column);
        assert_true(norm > rows[i].norm && norm <= 1.0);
        assert_true(pixel > rows[i].pixel && pixel <= 1.0);
        assert_true(column > rows[i].column && column <= 1.0);
        drop_far(&m);
    }
}

/* Roundings are the error where the grid holds all of a kernel: of light that a
 * search found, whose sums along a step are all rounded one way. */
static void roundings_are_in_the_limits(void **state)
{
    enum { SIDE = 704, STEP = 8 };
    static const float FOUND = 0x1.3271a4p0f;
    static const float more[STEP] = {2, 58, 253, 100, 245, 249, 21, 39};
    const struct wave wave = {880.0, 160.0, 160.0, INFINITY};
    struct made m = make_wave(1700, SIDE, STEP, &wave);
    float light[SIDE];
    double pixel;
    (void) state;
    for (int x = 0; x < SIDE; x++)
        light[x] = FOUND + 0x1p-23f * more[x % STEP];
    const double norm = wave_error(
        &m, &wave, &(struct columns) {light, SIDE, 0, SIDE}, 0.0f, &pixel);
    const double share = norm / gp_far_error_of(m.s)->norm;
    print_message("%.3g roundings, %.2g of the norm, %.2g of a pixel\n",
                  norm / (m.t->norm1[0] * 0x1p-24), share, pixel);
    assert_true(share > 0.08 && share <= 1.0 && pixel <= 1.0);
    drop_far(&m);
}

/* The sum that a far field says it has is that of its samples, and light in the
 * middle leaves a frame's part of it. */
static void sums_are_kept(void **state)
{
    static const int size[][2] = {{300, 250}, {1, 400}, {411, 283}};
    (void) state;
    for (size_t i = 0; i < COUNT(size); i++) {
        struct made m = make_far(size[i][0], size[i][1], false, &fine);
        struct gp_kernel k = plain(&m, &fine);
        for (int c = 0; c < 3; c++) {
            assert_true(fabs(k.sum[c] - m.t->sum[c]) < 1e-8);
            assert_true(m.t->norm1[c] >= k.norm1[c]);
            assert_true(m.t->norm2[c] >= k.norm2[c]);
        }
        gp_kernel_free(&k);
        drop_far(&m);
    }
}

/* A disc's far field on the grid's own pixels is the plain sum over it. */
static void discs_have_far_fields(void **state)
{
    enum { W = 400, H = 300, REACH = 9, SIDE = 2 * REACH + 1 };
    const double degrees = fine;
    struct made m = make_far(W, H, false, &degrees);
    const struct gp_kernel k = {.far = m.t};
    const int step = m.t->split.step;
    struct gp_spread_kernel out;
    float weight[SIDE * SIDE];
    (void) state;
    for (int i = 0; i < SIDE * SIDE; i++)
        weight[i] = (float) (i % 7) / (3.0f * SIDE * SIDE);
    assert_ok(gp_kernel_spread_far(NULL, &k, REACH, weight, &out));
    assert_int_equal(out.step, step);
    for (int i = 0; i < 400; i++) {
        const int u = i % 20 * 3 - 30, v = i / 20 * 2 - 20;
        const int x = (int) floor(out.cx) + u, y = (int) floor(out.cy) + v;
        double sum[3] = {0};
        if (abs(u) * step > W - REACH || abs(v) * step > H - REACH)
            continue; // the far field fades there
        for (int j = 0; j < SIDE * SIDE; j++) {
            const int dx = u * step - (j % SIDE - REACH);
            const int dy = v * step - (j / SIDE - REACH);
            double w[3];
            veil(&degrees, dx, dy, w);
            for (int c = 0; c < 3; c++)
                sum[c] += (double) weight[j] * w[c] *
                          gp_far_share(&m.t->split, dx, dy);
        }
        for (int c = 0; c < 3; c++) {
            const double got = (double) out.k.c[c][y * out.w + x];
            assert_true(fabs(got - sum[c]) <=
                        gp_far_error_of(m.s)->pixel + 1e-6 * sum[c]);
        }
    }
    gp_planes_free(&out.k);
    drop_far(&m);
}

static void larger_frames_are_refused(void **state)
{
    struct made m = make_far(300, 200, true, &fine);
    struct gp_sources s = lights(301, 200, 3, 1.0f, 1u);
    struct gp_planes p;
    struct gp_far_rows *rows = NULL;
    (void) state;
    assert_ok(gp_planes_make(NULL, "layer", 301 * 200, &p));
    assert_int_equal(gp_far_find(&kept_log, m.t, m.s, &s, s.w, s.h, &p, &rows),
                     GP_ERR_BUG);
    assert_non_null(strstr(kept_line, "300x200"));
    gp_planes_free(&p);
    gp_sources_free(&s);
    drop_far(&m);
}

SUITE_OF(far_field, NULL, NULL, sums_are_those_of_the_kernel, sums_are_kept,
         what_the_grid_does_not_hold_is_in_the_limits,
         roundings_are_in_the_limits, discs_have_far_fields,
         larger_frames_are_refused)
