/* glare/tail against the plain double sum, its laws, and its bound. */
#include "unit.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/tail/tail_priv.h"
#include "glare/model/model.h"
#include "hard_cases.h"
#include "starved.h"

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
    struct gp_tail *t;
    struct gp_tail_state *s;
};

static struct made make_tail(int w, int h, bool grey, const double *degrees)
{
    const struct gp_tail_split split = gp_tail_choose(0.0, 1.0, 0, w, h);
    struct made m = {0};
    assert_true(split.step > 0);
    assert_ok(gp_tail_make(NULL, &split, w, h, grey, true, veil, degrees,
                           &m.t));
    assert_ok(gp_tail_open(NULL, m.t, &m.s));
    return m;
}

static void drop_tail(struct made *m)
{
    gp_tail_close(&m->s);
    gp_tail_free(m->t);
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

/* The tail of sources, added to black. */
static struct gp_planes added(const struct made *m, const struct gp_sources *s)
{
    const size_t n = (size_t) s->w * (size_t) s->h;
    struct gp_planes p;
    struct gp_tail_rows *rows = NULL;
    assert_ok(gp_planes_make(NULL, "layer", n, &p));
    for (int c = 0; c < 3; c++)
        memset(p.c[c], 0, n * sizeof(float));
    assert_ok(gp_tail_find(NULL, m->t, m->s, s, &p, &rows));
    gp_parallel_do(s->h, gp_tail_add_row, rows);
    gp_tail_rows_free(&rows);
    return p;
}

/* The tail's samples as a kernel, for the plain sum. */
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
                                 gp_tail_share(&m->t->split, x, y));
    }
    assert_ok(gp_kernel_of_planes(NULL, "tail", w, h, &p, &k));
    return k;
}

/* The error of a tail against the plain sum, over its limits. */
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
    assert_ok(gp_glare_reference(NULL, s, &k, exact));
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
        e.pixel = fmax(e.pixel, most / gp_tail_pixel_error(m->s, m->t, s, c));
    }
    e.norm = sqrt(error / light) / gp_tail_error_of(m->s)->norm;
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
        struct made m = make_tail(w, h, rows[i].grey, rows[i].degrees);
        struct gp_sources s = lights(w, h, rows[i].n, rows[i].light,
                                     (uint32_t) i);
        const struct error e = compare(&m, &s, rows[i].degrees);
        print_message("%dx%d: %.2g of the norm, %.2g of a pixel, %.2g\n", w, h,
                      e.norm, e.pixel, e.layer);
        assert_true(e.norm <= 1.0 && e.pixel <= 1.0 && e.layer < 1e-3);
        gp_sources_free(&s);
        drop_tail(&m);
    }
}

/* Stripes of the periods at which most is lost reach a tenth of the limit, so
 * that one ten times less is broken. Light that is never negative has over half
 * of its norm in its mean, of which nothing is lost. */
static void limits_are_reached(void **state)
{
    enum { W = 640, H = 400 };
    struct made m = make_tail(W, H, true, &fine);
    double most = 0.0;
    (void) state;
    for (int period = 38; period <= 90; period += 20) {
        struct gp_frame f = scene_frame(W, H, 0, 0, BLACK, 0);
        struct scene s;
        for (int i = 0; i < W * H; i++) {
            const double turn = 2.0 * acos(-1.0) * (i % W) / period;
            for (int c = 0; c < 3; c++)
                f.rgb.c[c][i] = (float) (1.0 + cos(turn));
        }
        s = scene_sense(f, scene_kernel(3, 3, MID, 0, PEAK), &open_all);
        const struct error e = compare(&m, &s.src, &fine);
        print_message("stripes of %d: %.2g of the norm, %.2g of a pixel\n",
                      period, e.norm, e.pixel);
        assert_true(e.norm <= 1.0 && e.pixel <= 1.0);
        most = fmax(most, e.norm);
        scene_free(&s);
    }
    assert_true(most > 0.1);
    drop_tail(&m);
}

static void laws_hold(void **state)
{
    enum { W = 300, H = 250 };
    struct made m = make_tail(W, H, false, &fine);
    const int step = m.t->split.step;
    struct gp_sources a = lights(W, H, 60, 1.0f, 1u), half, moved, one;
    (void) state;
    // light that is halved halves every bit
    struct gp_planes p = added(&m, &a), q;
    assert_ok(gp_sources_halve(NULL, &a, 1, &half));
    q = added(&m, &half);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < W * H; i++)
            assert_true(p.c[c][i] == 2.0f * q.c[c][i]);
    }
    gp_planes_free(&q);
    gp_planes_free(&p);
    // light that moves by (dx, dy) moves the layer, within both limits
    for (int dx = 0; dx <= step; dx += 3) {
        const int dy = step - dx, x0 = 20, y0 = 30;
        struct gp_source at[2] = {{x0, y0, {1.0f, 2.0f, 3.0f}},
                                  {x0 + dx, y0 + dy, {1.0f, 2.0f, 3.0f}}};
        const struct gp_sources like = {.w = W, .h = H};
        struct gp_sources none;
        assert_ok(gp_sources_make(NULL, &like, 0, &none));
        gp_sources_finish(&none);
        assert_ok(gp_sources_join(NULL, &none, &at[0], 1, &one));
        assert_ok(gp_sources_join(NULL, &none, &at[1], 1, &moved));
        p = added(&m, &one);
        q = added(&m, &moved);
        for (int c = 0; c < 3; c++) {
            const double limit = 2.0 * gp_tail_pixel_error(m.s, m.t, &one, c);
            for (int y = 0; y < H - dy; y++) {
                for (int x = 0; x < W - dx; x++)
                    assert_true(fabs((double) q.c[c][(y + dy) * W + x + dx] -
                                     (double) p.c[c][y * W + x]) <= limit);
            }
        }
        gp_planes_free(&q);
        gp_planes_free(&p);
        gp_sources_free(&one);
        gp_sources_free(&moved);
        gp_sources_free(&none);
    }
    gp_sources_free(&a);
    gp_sources_free(&half);
    drop_tail(&m);
}

/* The sum that a tail says it has is that of its samples, and light in the
 * middle leaves a frame's part of it. */
static void sums_are_kept(void **state)
{
    static const int size[][2] = {{300, 250}, {1, 400}, {411, 283}};
    (void) state;
    for (size_t i = 0; i < COUNT(size); i++) {
        struct made m = make_tail(size[i][0], size[i][1], false, &fine);
        struct gp_kernel k = plain(&m, &fine);
        for (int c = 0; c < 3; c++) {
            assert_true(fabs(k.sum[c] - m.t->sum[c]) < 1e-8);
            assert_true(m.t->norm1[c] >= k.norm1[c]);
            assert_true(m.t->norm2[c] >= k.norm2[c]);
        }
        gp_kernel_free(&k);
        drop_tail(&m);
    }
}

static void threads_change_nothing(void **state)
{
    enum { W = 500, H = 300 };
    struct got { uint64_t layer; struct gp_tail_error error; } got[3];
    (void) state;
    for (int i = 0; i < 3; i++) {
        gp_set_threads(1 + 3 * i);
        struct made m = make_tail(W, H, i % 2, &fine);
        struct gp_sources s = lights(W, H, 4000, 1.0f, 7u);
        struct gp_planes p = added(&m, &s);
        got[i] = (struct got) {hash_layer(&p, W * H), *gp_tail_error_of(m.s)};
        gp_planes_free(&p);
        gp_sources_free(&s);
        drop_tail(&m);
    }
    gp_set_threads(0);
    assert_memory_equal(&got[0], &got[2], sizeof *got);
    assert_true(got[0].layer != got[1].layer);
}

/* A disc's tail at the grid's own pixels is the plain sum over the disc. */
static void discs_have_tails(void **state)
{
    enum { W = 400, H = 300, REACH = 9, SIDE = 2 * REACH + 1 };
    const double degrees = fine;
    struct made m = make_tail(W, H, false, &degrees);
    const struct gp_kernel k = {.tail = m.t};
    const int step = m.t->split.step;
    struct gp_spread_kernel out;
    float weight[SIDE * SIDE];
    (void) state;
    for (int i = 0; i < SIDE * SIDE; i++)
        weight[i] = (float) (i % 7) / (3.0f * SIDE * SIDE);
    assert_ok(gp_kernel_spread_tail(NULL, &k, REACH, weight, &out));
    assert_int_equal(out.step, step);
    for (int i = 0; i < 400; i++) {
        const int u = i % 20 * 3 - 30, v = i / 20 * 2 - 20;
        const int x = (int) floor(out.cx) + u, y = (int) floor(out.cy) + v;
        double sum[3] = {0};
        if (abs(u) * step > W - REACH || abs(v) * step > H - REACH)
            continue; // the tail fades there
        for (int j = 0; j < SIDE * SIDE; j++) {
            const int dx = u * step - (j % SIDE - REACH);
            const int dy = v * step - (j / SIDE - REACH);
            double w[3];
            veil(&degrees, dx, dy, w);
            for (int c = 0; c < 3; c++)
                sum[c] += (double) weight[j] * w[c] *
                          gp_tail_share(&m.t->split, dx, dy);
        }
        for (int c = 0; c < 3; c++) {
            const double got = (double) out.k.c[c][y * out.w + x];
            assert_true(fabs(got - sum[c]) <=
                        gp_tail_error_of(m.s)->pixel + 1e-6 * sum[c]);
        }
    }
    gp_planes_free(&out.k);
    drop_tail(&m);
}

static void splits_are_for_smooth_kernels(void **state)
{
    (void) state;
    assert_int_equal(gp_tail_choose(INFINITY, 1.0, 0, 1920, 1080).step, 0);
    assert_int_equal(gp_tail_choose(0.0, 1.0, 0, 128, 72).step, 0);
    assert_int_equal(gp_tail_choose(1500.0, 1.0, 0, 1920, 1080).step, 0);
    assert_int_equal(gp_tail_choose(0.0, 1.0, 0, 1920, 1080).step, 8);
    assert_int_equal(gp_tail_choose(0.0, 1.0, 0, 16384, 1).step, 32);
    const struct gp_tail_split s = gp_tail_choose(150.0, 1.0, 0, 1920, 1080);
    double before = 0.0;
    assert_true(s.from >= 150.0);
    for (int x = 0; x < 1920; x++) {
        const double share = gp_tail_share(&s, x, 0);
        assert_true(share >= before && share <= 1.0);
        assert_true(x > s.from || share == 0.0);
        assert_true(x < s.to || share == 1.0);
        before = share;
    }
}

static void larger_frames_are_refused(void **state)
{
    struct made m = make_tail(300, 200, true, &fine);
    struct gp_sources s = lights(301, 200, 3, 1.0f, 1u);
    struct gp_planes p;
    struct gp_tail_rows *rows = NULL;
    (void) state;
    assert_ok(gp_planes_make(NULL, "layer", 301 * 200, &p));
    assert_int_equal(gp_tail_find(&kept_log, m.t, m.s, &s, &p, &rows),
                     GP_ERR_BUG);
    assert_non_null(strstr(kept_line, "300x200"));
    gp_planes_free(&p);
    gp_sources_free(&s);
    drop_tail(&m);
}

// -- engines with kernels over the whole field --------------------------------

/* The kernel of recipes with a + between them, 36 pixels a degree. */
static struct gp_kernel field_kernel(const struct gp_frame *f, const char *text)
{
    enum { MOST = 4 };
    struct gp_field field = gp_field_of(f, 30.0);
    struct gp_recipe r[MOST];
    struct gp_kernel k;
    char words[256];
    int n = 0;
    field.degrees = fine;
    snprintf(words, sizeof words, "%s", text);
    for (char *at = words, *next; at; at = next) {
        next = strchr(at, '+');
        if (next)
            *next++ = '\0';
        assert_ok(gp_recipe_parse(NULL, at, &r[n++]));
    }
    assert_ok(gp_model_kernel(NULL, r, n, &field, &k));
    while (n > 0)
        gp_recipe_free(&r[--n]);
    return k;
}

static struct scene field_scene(struct gp_frame f, const char *text)
{
    return scene_make(f, field_kernel(&f, text), &usual);
}

/* Every engine's error against the whole kernel's sum is within its bound, and
 * nothing is wrong where there is no light. */
static void check_engines(struct scene *s, const char *what)
{
    static const char *const names[] = {"direct", "fft", "splat", "auto"};
    for (size_t i = 0; i < COUNT(names); i++) {
        struct gp_glare_stats stats;
        if (!ran_once(names[i], s, &stats, what))
            continue;
        const double error = s->src.n ? scene_rel_l2(s) : 0.0;
        if (!(error <= stats.bound) || !(stats.bound < 1e-3))
            fail_msg("%s, %s: rel_l2 %g, bound %g", what, names[i], error,
                     stats.bound);
        for (size_t k = 0; k < 3 * gp_frame_pixels(&s->f) && !s->src.n; k++)
            assert_true(s->f.layer.c[k % 3][k / 3] == 0.0f);
        const bool tail = s->src.n && s->k.tail && i != 0;
        assert_int_equal(stats.tail_step, tail ? s->k.tail->split.step : 0);
    }
}

static void engines_keep_their_bounds(void **state)
{
    static const struct { int w, h, x, y; enum light light; } rows[] = {
        {331, 257, 0, 0, FEW},     {331, 67, -700, 3, MANY},
        {256, 48, 0, 0, FLAT},     {257, 191, 5, 5, HOT},
        {300, 200, 0, 0, BAD},     {300, 200, 0, 0, DENORMAL},
        {300, 200, 0, 0, CORNERS}, {1, 700, 0, 0, ALL},
        {700, 1, 0, 0, COLOURED},  {1, 1, 0, 0, ALL},
        {4096, 3, 0, 0, MANY},     {300, 200, 0, 0, DARK},
        {300, 50, 0, 0, OVER},     {300, 50, 0, 0, CANCEL},
    };
    static const char *const recipes[] = {"eye", "cie:age=70,share=.3",
                                          "moffat:share=1"};
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char what[64];
        struct scene s = field_scene(
            scene_frame(rows[i].w, rows[i].h, rows[i].x, rows[i].y,
                        rows[i].light, (uint32_t) i), recipes[i % 3]);
        snprintf(what, sizeof what, "row %zu %s", i, recipes[i % 3]);
        assert_true(!s.k.tail == (gp_max(rows[i].w, rows[i].h) < 192));
        check_engines(&s, what);
        scene_free(&s);
    }
    // and the table's own frames, from those that are wide enough on
    for (int i = 0; i < (int) COUNT(hard_cases); i++) {
        const struct hard_case *const h = &hard_cases[i];
        struct gp_frame f = hard_frame(h);
        if (gp_max(gp_frame_w(&f), gp_frame_h(&f)) < 192 ||
            gp_frame_pixels(&f) > 400000) {
            gp_frame_free(&f);
            continue;
        }
        struct scene s = field_scene(f, "eye");
        check_engines(&s, h->name);
        scene_free(&s);
    }
}

/* Beside shapes that are smooth all over, sharp ones stay in the core and make
 * neither it larger than they are nor the tail coloured, but for diffraction's.
 * Core and tail are not negative, and add up to the whole within 1e-5. */
static void sharp_shapes_stay_in_the_core(void **state)
{
    static const struct {
        const char *text;
        int reach;    // of the core, at most
        bool turned;  // the same when halved by a line through the centre
    } rows[] = {
        {"cie+star", 185, true}, {"moffat+eye+cross:length=3", 130, true},
        {"spencer:light=scotopic", 197, true}, {"eye-night", 210, false},
        {"spencer:needles=40+circle", 200, false},
        {"cie+streak:length=3.9", 150, false},
        // reaches of 144 pixels; the mean far out takes over before its end
        {"eye+aperture:reach=4,wavelengths=5", 205, true},
        {"temporal:reach=4,wavelengths=5", 205, true},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s = field_scene(
            scene_frame(430, i == 1 ? 70 : 310, 0, 0, i == 1 ? MANY : CORNERS,
                        (uint32_t) i), rows[i].text);
        struct gp_glare_stats stats;
        const bool grey = !strstr(rows[i].text, "wavelengths");
        if (!s.k.tail || s.k.tail->grey != grey || s.k.cx > rows[i].reach)
            fail_msg("%s: %s, a core of %d pixels", rows[i].text,
                     s.k.tail ? "a tail" : "no tail", s.k.cx);
        assert_true(!s.k.negative);
        for (int x = 0; x < s.k.w && rows[i].turned; x++) // across the centre
            assert_true(fabsf(s.k.k.c[1][s.k.cy * s.k.w + x] -
                              s.k.k.c[1][s.k.cy * s.k.w + s.k.w - 1 - x]) <=
                        1e-4f * s.k.k.c[1][s.k.cy * s.k.w + x]);
        check_engines(&s, rows[i].text);
        assert_true(ran_once("fft", &s, &stats, rows[i].text));
        const double error = scene_rel_l2(&s);
        if (!(error < 1e-5))
            fail_msg("%s: rel_l2 %g", rows[i].text, error);
        scene_free(&s);
    }
}

/* Fields as wide as the sky, and pixels of any aspect: transforms are within
 * 1e-5 of the exact layer, and their bounds hold. */
static void any_field_is_within_1e_5(void **state)
{
    enum { W = 400, H = 150 };
    static const char *const recipes[] = {
        "eye", "eye-night", "cie:age=100", "moffat",
    };
    static const double fovs[] = {30.0, 60.0, 100.0, 170.0};
    static const double aspects[] = {1.0, 2.0, 0.1};
    (void) state;
    for (size_t i = 0; i < COUNT(recipes) * COUNT(fovs) * COUNT(aspects); i++) {
        const char *const text = recipes[i / 12];
        const double fov = fovs[i / 3 % 4], aspect = aspects[i % 3];
        struct gp_frame f = scene_frame(W, H, 0, 0, DARK, (uint32_t) i);
        uint32_t seed = (uint32_t) i;
        for (int k = 0; k < 20; k++) {
            const int x = (int) (scene_random(&seed) * (W - 2));
            const int y = (int) (scene_random(&seed) * (H - 2));
            for (int c = 0; c < 12; c++)
                f.rgb.c[c % 3][(y + c / 6) * W + x + c / 3 % 2] =
                    100.0f + 1000.0f * scene_random(&seed);
        }
        struct gp_field field = gp_field_of(&f, fov);
        struct gp_recipe r;
        struct gp_kernel k;
        struct gp_glare_stats stats;
        field.aspect = aspect;
        assert_ok(gp_recipe_parse(NULL, text, &r));
        assert_ok(gp_model_kernel(NULL, &r, 1, &field, &k));
        gp_recipe_free(&r);
        assert_true(k.tail || aspect < 1.0); // where the halo is that wide
        struct scene s = scene_make(f, k, &usual);
        assert_true(ran_once("fft", &s, &stats, text));
        const double error = scene_rel_l2(&s);
        if (!(error <= 1e-5) || !(error <= stats.bound))
            fail_msg("%s, %g degrees, aspect %g: rel_l2 %g, bound %g", text,
                     fov, aspect, error, stats.bound);
        scene_free(&s);
    }
}

/* A sharp shape that reaches over the field, or lobes that a tail would fill,
 * leave the kernel whole. */
static void some_kernels_stay_whole(void **state)
{
    static const char *const rows[] = {"star:length=20", "cie+cross:length=12",
                                       "gaussian:fwhm=20+eye"};
    struct gp_frame f = scene_frame(430, 310, 0, 0, DARK, 0);
    struct gp_frame lobes = scene_frame(3, 3, 0, 0, ALL, 0);
    struct gp_field field = gp_field_of(&f, 30.0);
    struct gp_recipe r[2];
    struct gp_kernel k;
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        k = field_kernel(&f, rows[i]);
        assert_true(!k.tail);
        gp_kernel_free(&k);
    }
    for (int c = 0; c < 3; c++)
        lobes.rgb.c[c][0] = -lobes.rgb.c[c][4];
    assert_ok(gp_recipe_parse(NULL, "cie", &r[0]));
    assert_ok(gp_recipe_of_image(NULL, "lobes", 0.0, 100.0, &r[1]));
    r[1].image = &lobes;
    field.degrees = fine;
    for (int tail = 0; tail < 2; tail++) {
        assert_ok(gp_model_kernel(NULL, r, 2, &field, &k));
        assert_true(k.negative == !tail && !k.tail == !tail);
        gp_kernel_free(&k);
        for (int c = 0; c < 3; c++)
            lobes.rgb.c[c][0] = 0.0f;
    }
    gp_recipe_free(&r[0]);
    gp_recipe_free(&r[1]);
    gp_frame_free(&lobes);
    gp_frame_free(&f);
}

/* A lone lamp in the dark at +6 EV: no rim, no step where the core ends, and no
 * noise of transforms, out to the frame's end. In black, and in a night whose
 * own light hides such noise from the choice of what goes direct. */
static void a_lamp_has_no_rim(void **state)
{
    enum { W = 1200, H = 300, X = 40, Y = 150 };
    static const char *const names[] = {"fft", "auto"};
    static const struct {
        const char *text;
        int radius; // of the lamp, pixels
        float sky;
        double within;
    } rows[] = {
        {"eye", 0, 0.0f, 1e-3}, {"eye", 2, 0.1f, 1e-3},
        {"moffat", 0, 0.1f, 1e-3}, {"moffat", 6, 0.1f, 1e-3},
        {"moffat", 20, 0.1f, 0.02}, {"moffat:share=1", 0, 0.1f, 1e-3},
        {"eye-night", 0, 0.1f, 1e-3}, {"cie:equation=general", 2, 0.1f, 1e-3},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows) * COUNT(names); i++) {
        const int radius = rows[i / 2].radius;
        const char *const text = rows[i / 2].text, *const name = names[i % 2];
        struct gp_frame f = scene_frame(W, H, 0, 0, BLACK, 0);
        struct gp_glare_stats stats;
        for (int k = 0; k < 3 * W * H; k++) {
            const int x = k / 3 % W - X, y = k / 3 / W - Y;
            f.rgb.c[k % 3][k / 3] =
                x * x + y * y <= radius * radius ? 64.0f : rows[i / 2].sky;
        }
        struct scene s = field_scene(f, text);
        ran_once(name, &s, &stats, "lamp");
        for (int r = radius + 4; X + r + 1 < W; r++) {
            const size_t at = Y * W + X + (size_t) r;
            const double v = (double) s.f.layer.c[1][at];
            const double next = (double) s.f.layer.c[1][at + 1];
            const double exact = s.exact[W * H + at];
            const double beyond = s.exact[W * H + at + 1];
            if (!(fabs(v / exact - 1.0) < rows[i / 2].within) ||
                (r > 150 && !(fabs(next / v - beyond / exact) < 0.005)))
                fail_msg("%s of %s, %d pixels away: %g, then %g, not %g", name,
                         text, r, v, next, exact);
        }
        scene_free(&s);
    }
}

/* Bounds of --tolerance-pixel count the tail's error. */
static void pixels_are_within_their_bounds(void **state)
{
    static const enum light lights[] = {FEW, MANY, HOT, ALL};
    (void) state;
    for (size_t i = 0; i < COUNT(lights); i++) {
        struct scene s = field_scene(
            scene_frame(300, 200, 0, 0, lights[i], (uint32_t) i), "eye");
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare g = {0};
        struct gp_glare_stats stats;
        struct gp_glare_error e;
        p.engine = "fft";
        p.tolerance_pixel = 1.0f;
        assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f, &stats));
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, NULL, &e);
        print_message("max_rel %.2g, bound %.2g\n", e.max_rel,
                      stats.bound_pixel);
        assert_true(e.max_rel <= stats.bound_pixel);
        gp_glare_close(&g);
        scene_free(&s);
    }
}

// -- without memory -----------------------------------------------------------

static struct scene starved;
static const char *starved_engine; // NULL: makes the kernel and a disc's tail
static double starved_sum;

static gp_status run_starved(void)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    struct gp_glare g = {0};
    p.engine = starved_engine;
    gp_status st = gp_glare_run(&kept_log, &p, &g, &starved.src, &starved.k,
                                &starved.f, &stats);
    gp_glare_close(&g);
    for (int i = 0; !st && i < starved.src.w * starved.src.h; i++)
        starved_sum += (double) starved.f.layer.c[0][i];
    gp_planes_free(&starved.f.layer);
    return st;
}

static gp_status run_making(void)
{
    static const float weight[9] = {0.1f, 0.1f, 0.1f, 0.1f, 0.2f,
                                    0.1f, 0.1f, 0.1f, 0.1f};
    const struct gp_tail_split split = gp_tail_choose(0.0, 1.0, 0, 300, 200);
    struct gp_kernel k = {0};
    struct gp_spread_kernel wide;
    gp_status st = gp_tail_make(&kept_log, &split, 300, 200, false, true, veil,
                                &fine, &k.tail);
    if (!st)
        st = gp_kernel_spread_tail(&kept_log, &k, 1, weight, &wide);
    if (!st) {
        starved_sum = k.tail->sum[0] + (double) wide.k.c[1][wide.w * 40 + 50];
        gp_planes_free(&wide.k);
    }
    gp_tail_free(k.tail);
    return st;
}

static void full_memory_is_an_error(void **state)
{
    static const char *const engines[] = {"fft", "direct", "auto"};
    (void) state;
    starved = field_scene(scene_frame(300, 200, 0, 0, FEW, 3u), "eye");
    gp_set_threads(1);
    for (size_t i = 0; i < COUNT(engines); i++) {
        starved_engine = engines[i];
        starve(engines[i], run_starved, &starved_sum, 8);
    }
    starve("making", run_making, &starved_sum, 8);
    gp_set_threads(0);
    scene_free(&starved);
}

SUITE_OF(tail, ask_quick, NULL, sums_are_those_of_the_kernel,
    limits_are_reached, laws_hold, sums_are_kept, threads_change_nothing,
    discs_have_tails, splits_are_for_smooth_kernels, larger_frames_are_refused,
    engines_keep_their_bounds, sharp_shapes_stay_in_the_core,
    any_field_is_within_1e_5, some_kernels_stay_whole, a_lamp_has_no_rim,
    pixels_are_within_their_bounds, full_memory_is_an_error)
