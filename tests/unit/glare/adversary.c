/* The engines' bounds, from above and from below: frames of a few pixels and
 * kernels of a few samples, made by a search for the largest error over its
 * bound. No frame on the search's way may be over its bound, and the worst
 * ones, which are kept as rows, are over half of it: a bound divided by two
 * breaks one of them, and so does a term that is left out. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/bound/bound_priv.h"
#include "glare/splat/splat_priv.h"
#include "glare_scene.h"
#include "plain_groups.h"

enum { MOST = 256, LEVELS = 40 };

/* Light and samples by letter: '.' is none, then powers of 1.9, whose
 * mantissas are all over the place. L is the most that 1 swallows, H the least
 * that raises it, X a bit of both. */
static const char letters[] = ".0123456789abcdefghijklmnopqrstuvwxyzLHX";

static float level(char c)
{
    const char *const at = strchr(letters, c);
    switch (c) {
    case '.':
        return 0.0f;
    case 'L':
        return 0x1.fffffep-25f;
    case 'H':
        return 0x1.000002p-24f;
    case 'X':
        return 0x1.555556p-12f;
    }
    return (float) pow(1.9, (double) (at - letters - 1));
}

/* A frame of w x h pixels and a kernel of kw x kh samples, both grey, in rows
 * from the top; a text that is too short begins again. */
struct toy {
    int w, h, kw, kh, cx, cy;
    char light[MOST + 1], taps[MOST + 1];
};

/* False: a black frame or kernel. */
static bool open_toy(const struct toy *t, struct scene *s)
{
    struct gp_kernel_params kp = {0};
    struct gp_frame image = scene_frame(t->kw, t->kh, 0, 0, BLACK, 0);
    struct gp_frame f = scene_frame(t->w, t->h, 0, 0, BLACK, 0);
    const int lights = (int) strlen(t->light), taps = (int) strlen(t->taps);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < t->w * t->h; i++)
            f.rgb.c[c][i] = level(t->light[i % lights]);
        for (int i = 0; i < t->kw * t->kh; i++)
            image.rgb.c[c][i] = level(t->taps[i % taps]);
    }
    kp.normalize = GP_NORMALIZE_NONE;
    kp.centered = true;
    kp.center[0] = t->cx + 0.5;
    kp.center[1] = t->cy + 0.5;
    *s = (struct scene) {.f = f};
    const gp_status st = gp_kernel_from_frame(NULL, &kp, &image, &s->k);
    gp_frame_free(&image);
    if (!st && !gp_sense(NULL, &open_all, &s->f, &s->src) && s->src.n) {
        scene_find_exact(s);
        return true;
    }
    scene_free(s);
    return false;
}

static double norm_of(const double *v, size_t n)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++)
        sum += v[i] * v[i];
    return sqrt(sum);
}

/* -- measured error over bound ----------------------------------------------*/

enum scope { LAYER, SAMPLE, COMPOSITE };

/* Of the layer's norm, of the sample nearest to its bound, or of the
 * composite's pixel: there `direct` is measured on the layer, and fft, whose
 * error is the same everywhere, on the frame. */
static double engine_ratio(const struct gp_engine *e, enum scope scope,
                           struct scene *s)
{
    struct gp_glare g = {0};
    struct gp_glare_error error;
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats = {0};
    struct gp_pixel_error of;
    void *state = NULL;
    double bound, worst = 0.0;
    scene_clear_layer(s);
    const struct gp_glare_request req = {
        .params = &p, .src = &s->src, .kernel = &s->k, .stats = &stats,
        .layer = &s->f.layer,
    };
    p.tolerance = 0.0f; // the least bound that can be found
    p.gain = 1e-35f;    // no light is so hot that fft leaves it to direct
    if (scope == COMPOSITE) {
        p.gain = e == &gp_engine_fft ? p.gain : 1e3f;
        p.engine = e->name;
        p.tolerance_pixel = 1e-3f;
        assert_ok(gp_glare_run(NULL, &p, &g, &s->src, &s->k, &s->f, &stats));
        gp_glare_close(&g);
        gp_glare_measure(&s->f, &s->f.layer, s->exact, p.gain, NULL, &error);
        return error.max_rel / stats.bound_pixel;
    }
    assert_ok(e->bound(&req, &state, &bound));
    assert_ok(e->pixel(&req, &state, &of));
    assert_ok(e->run(&req, &state));
    e->close(&state);
    if (scope == LAYER)
        return scene_rel_l2(s) / bound;
    const size_t n = gp_frame_pixels(&s->f);
    for (size_t i = 0; i < 3 * n; i++) {
        const double exact = s->exact[i];
        const double wrong = fabs((double) s->f.layer.c[i / n][i % n] - exact);
        if (wrong > 0.0)
            worst = fmax(worst, wrong / (of.share * exact + of.of[i / n]));
    }
    return worst;
}

static double group_ratio(const struct gp_splat_params *p, struct scene *s)
{
    const size_t n = 3 * gp_frame_pixels(&s->f);
    double *const layer = scene_alloc(n, sizeof *layer);
    struct gp_bound_cache cache = {0};
    struct gp_polygons q;
    struct gp_shrink shrink;
    double bound;
    assert_ok(gp_polygons_make(NULL, &s->src, p, &q));
    assert_ok(gp_shrink_make(NULL, &s->k, p, &q, &shrink));
    assert_ok(gp_group_bound(NULL, &s->src, &s->k, p, &q, &shrink, 4.0,
                             &cache, &bound));
    plain_groups(&s->src, &s->k, p, &q, &shrink, layer);
    for (size_t i = 0; i < n; i++)
        layer[i] -= s->exact[i];
    const double wrong = norm_of(layer, n);
    const double ratio = wrong / (bound * norm_of(s->exact, n));
    free(layer);
    gp_polygons_free(&q);
    gp_bound_cache_free(&cache);
    return wrong > 0.0 ? ratio : 0.0;
}

/* Of the limit for these sources, or for sources anywhere. */
static double least_ratio(bool anywhere, const struct scene *s)
{
    struct gp_bound_cache cache = {0};
    struct gp_fft_quarters q;
    double least;
    gp_fft_find_quarters(&s->k, s->src.w, s->src.h, &q);
    assert_ok(gp_layer_least(NULL, &s->src, &s->k, &cache, &least));
    gp_bound_cache_free(&cache);
    if (anywhere)
        least = gp_fft_least(&s->src, &q);
    return least / norm_of(s->exact, 3 * gp_frame_pixels(&s->f));
}

/* The bounds, and the sides of the frames that are searched. */
enum bound {
    FFT, DIRECT, FFT_SAMPLE, DIRECT_SAMPLE, FFT_PIXEL, DIRECT_PIXEL, CENTROID,
    MOMENTS, CORE, SHRINK, LEAST,
    FFT_LEAST, BOUNDS,
};
static const struct {
    const char *name;
    int side;
    const struct gp_engine *engine;
    enum scope scope;
    struct gp_splat_params p;
} bounds[BOUNDS] = {
    {"fft", 14, &gp_engine_fft, LAYER, {0}},
    {"direct", 8, &gp_engine_direct, LAYER, {0}},
    {"fft, a sample", 14, &gp_engine_fft, SAMPLE, {0}},
    {"direct, a sample", 8, &gp_engine_direct, SAMPLE, {0}},
    {"fft, a pixel", 14, &gp_engine_fft, COMPOSITE, {0}},
    {"direct, a pixel", 8, &gp_engine_direct, COMPOSITE, {0}},
    {"centroid", 8, NULL, LAYER, {.group = 2, .method = GP_GROUP_CENTROID}},
    {"moments", 8, NULL, LAYER, {.group = 4, .method = GP_GROUP_MOMENTS}},
    {"core", 16, NULL, LAYER, {.group = 4, .method = GP_GROUP_CORE}},
    {"shrink", 10, NULL, LAYER, {.group = 1, .shrink = 0.2f}},
    {"layer_least", 9, NULL, LAYER, {0}},
    {"fft_least", 9, NULL, LAYER, {0}},
};

/* The measured error over the bound; 0 where there is no layer. */
static double measure(enum bound b, const struct toy *t)
{
    struct scene s;
    double ratio = 0.0;
    if (!open_toy(t, &s))
        return 0.0;
    if (norm_of(s.exact, 3 * gp_frame_pixels(&s.f)) > 0.0)
        ratio = bounds[b].engine ? engine_ratio(bounds[b].engine,
                                                 bounds[b].scope, &s)
                : b >= LEAST ? least_ratio(b == FFT_LEAST, &s)
                                 : group_ratio(&bounds[b].p, &s);
    scene_free(&s);
    if (!(ratio <= 1.0 + 1e-9))
        fail_msg("%s: %g of the bound: {%d, %d, %d, %d, %d, %d, \"%s\", "
                 "\"%s\"}", bounds[b].name, ratio, t->w, t->h, t->kw, t->kh,
                 t->cx, t->cy, t->light, t->taps);
    return ratio;
}

/* -- the search -------------------------------------------------------------*/

/* The generator's first numbers are near each other for near seeds. */
static uint32_t mixed_seed(uint32_t seed)
{
    for (int i = 0; i < 8; i++)
        scene_random(&seed);
    return seed;
}

static int below(uint32_t *seed, int n)
{
    return (int) (scene_random(seed) * (float) n);
}

static void random_letters(char *to, int n, uint32_t *seed)
{
    const int dark = below(seed, 4), from = 1 + below(seed, LEVELS - 1);
    const int wide = 1 + below(seed, LEVELS - from);
    for (int i = 0; i < n; i++)
        to[i] = below(seed, 4) < dark ? '.' : letters[from + below(seed, wide)];
    to[n] = '\0';
}

static void change(char *at, int n, uint32_t *seed)
{
    const int from = below(seed, n), to = from + 1 + below(seed, 3);
    const char c = letters[below(seed, LEVELS)];
    for (int i = from; i < to && i < n; i++)
        at[i] = below(seed, 3) ? c : at[below(seed, n)];
}

static struct toy make_toy(int side, uint32_t *seed)
{
    struct toy t = {.w = 1 + below(seed, side), .h = 1 + below(seed, side)};
    t.kw = 1 + below(seed, side);
    t.kh = 1 + below(seed, side);
    t.cx = below(seed, t.kw + 2) - 1;
    t.cy = below(seed, t.kh + 2) - 1;
    random_letters(t.light, t.w * t.h, seed);
    random_letters(t.taps, t.kw * t.kh, seed);
    return t;
}

/* Keeps the changes that bring *t nearer to the bound; returns how much of it
 * is reached. */
static double climb(enum bound b, uint32_t *seed, int steps, struct toy *t)
{
    double best = measure(b, t);
    for (int i = 0; i < steps; i++) {
        struct toy u = *t;
        if (below(seed, 2))
            change(u.light, (int) strlen(u.light), seed);
        else
            change(u.taps, (int) strlen(u.taps), seed);
        const double ratio = measure(b, &u);
        if (ratio >= best) {
            best = ratio;
            *t = u;
        }
    }
    return best;
}

/* GLAREPP_TEST_CASES: how many frames to start from; prints what is better
 * than those before. */
static void no_frame_is_over_its_bound(void **state)
{
    const char *const more = getenv("GLAREPP_TEST_CASES");
    const int starts = more ? atoi(more) : getenv("GLAREPP_TEST_QUICK") ? 2 : 6;
    gp_set_threads(1);
    for (int b = 0; b < BOUNDS; b++) {
        double top = 0.0;
        for (int i = 0; i < starts; i++) {
            uint32_t seed = mixed_seed((uint32_t) i);
            struct toy t = make_toy(bounds[b].side, &seed);
            const double best =
                climb((enum bound) b, &seed, more ? 2000 : 60, &t);
            if (more && best > top)
                print_message("%s: %.3f: {%d, %d, %d, %d, %d, %d, \"%s\", "
                              "\"%s\"}\n", bounds[b].name, best, t.w, t.h,
                              t.kw, t.kh, t.cx, t.cy, t.light, t.taps);
            top = fmax(top, best);
        }
        print_message("%s: the search reached %.3f of the bound\n",
                      bounds[b].name, top);
    }
    gp_set_threads(0);
}

/* Found by the search, or made for one term; over half of the bound. A sample
 * of fft is within seven deviations of its rounding, and no search came over
 * 0.36 of that. Where another processor rounds another way, the search goes on
 * from there. */
static void bounds_are_not_twice_too_large(void **state)
{
    static const struct {
        enum bound b;
        struct toy t;
    } row[] = {
        {FFT, {7, 9, 9, 1, 8, -1,
               "0jl0k0k0ljlimmtttlkmypiicl06c531ttjo0mej13jmilkjjkt0ng30omL0Hi"
               "m",
               "..bxhbk5k"}},
        // each sample but the first is swallowed by the sum
        {DIRECT, {1, 200, 1, 32, 0, 0, "0",
                  "LLLLLLLLLLLLLLLLLLLLLLLLLLLLLLL0"}},
        {DIRECT_SAMPLE, {1, 32, 1, 32, 0, 0, "0",
                         "LLLLLLLLLLLLLLLLLLLLLLLLLLLLLLL0"}},
        {FFT_SAMPLE,
         {13, 13, 5, 10, 5, -1,
          "0...iH1d..HH..Hd9.9ggjL.L.1.H.z3.L...LHHbHHL.HL.0.H..HL.9L.LH.....LH"
          "H.7f.........L....HH.00..H8.LLHH..HcL....d........H.H...HH.....H.H.LL"
          "..XXH.....HHHH.H.1HHHa.LL.Hb...H",
          "9Hjl03L366H9522LLkoylllkk2ol.H556LL5.X60044XH1114X"}},
        {FFT_PIXEL,
         {14, 12, 3, 2, 0, -1,
          "..03.p..i.3033447HHzooo..sX18..00144..0111rX44..5.4....m.mpsL4.0.X1o."
          "50.7H1oH.4....1..74XeX....XX1o.r.o.30300i888h1.1.5oX.Xb3b.33..14..0X0"
          "0..0s.0.044X...1r4.Hs.p.002qhh", "XcjHc2"}},
        {DIRECT_PIXEL, {1, 32, 1, 32, 0, 0, "0",
                        "LLLLLLLLLLLLLLLLLLLLLLLLLLLLLLL0"}},
        {CENTROID, {2, 3, 1, 2, 0, 0, "cnnc80", ".d"}},
        {MOMENTS, {5, 1, 4, 2, 1, 0, ".iki0", "..q....."}},
        {MOMENTS, {5, 7, 5, 4, 2, 3, ".8...y....v.ee4gl.y..66.8.448.89lll",
                   "4b3333bhhf88...7k7zg"}},
        {CORE, {3, 11, 7, 12, 0, 12, "468.006.8.70400090082..84.00.8qdh",
                "2.....44.p7..44.m0000w...078...hl4f...6554a999rri.i0k.d.5..6c."
                "pp..n47a.........d4..r"}},
        // by the most light and its sum, and by the kernel's rings
        {SHRINK, {3, 2, 1, 3, 1, 1, "..f.j.", "..f"}},
        {SHRINK, {6, 6, 8, 8, 5, 7, "j445222720.v7199jt40.00.92.2.92u40..",
                  "..4444a.3x....11..aa1.55111c....55..o.fa.xx0...se.4x1xff.ic"
                  "j.h.."}},
        // single lights, and light everywhere: of cells that the frame cuts,
        // and where only one end of a cell sees the kernel's edge
        {LEAST, {5, 7, 7, 1, 4, 1, "g2444cmgjgfsss6t6obll2goo7dgggbgg2g",
                 "...n..."}},
        {LEAST, {8, 8, 17, 17, 8, 8, "0", "0"}},
        {LEAST, {9, 8, 19, 17, 9, 8, "0", "0"}},
        {LEAST, {8, 11, 17, 23, 8, 11, "0", "0"}},
        {LEAST, {4, 8, 7, 14, 3, 6, "0", "0"}},
        {LEAST, {4, 8, 7, 14, 3, 7, "0", "0"}},
        {LEAST, {8, 4, 14, 7, 6, 3, "0", "0"}},
        {LEAST, {8, 4, 14, 7, 7, 3, "0", "0"}},
        // single lights, and light spread evenly
        {FFT_LEAST, {5, 7, 1, 1, 0, 0, "0..a", "0"}},
        {FFT_LEAST, {1, 8, 1, 3, 0, 1, "0", "0"}},
    };
    gp_set_threads(1);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct toy t = row[i].t;
        uint32_t seed = mixed_seed((uint32_t) i);
        double ratio = measure(row[i].b, &t);
        const bool random = row[i].b == FFT_SAMPLE || row[i].b == FFT_PIXEL;
        const double least = random ? 0.3 : 0.5, most = random ? 0.5 : 1.0;
        if ((random || row[i].b == FFT) && ratio <= least)
            ratio = climb(row[i].b, &seed, 4000, &t);
        print_message("%s: %.3f\n", bounds[row[i].b].name, ratio);
        if (!(ratio > least && ratio <= most + 1e-9))
            fail_msg("row %zu: %g", i, ratio);
    }
    gp_set_threads(0);
}

/* -- single terms -----------------------------------------------------------*/

/* Lights in twos far to the right, whose centroid is between pixels, where a
 * sample is exactly what they were. In so wide a frame GL may sample a float's
 * step aside, each to its own side: with a kernel that rises and falls in their
 * rhythm that makes most of what the bound allows. */
static void samples_places_are_in_the_bound(void **state)
{
    enum { WIDE = 8000, HIGH = 96, N = 3 * WIDE * HIGH, KW = 24, KH = 33 };
    static const float aside[][2] = {{1, 0}, {0, 1}, {1, 1}};
    const float step = 0x1p-11f; // 13 of a float's 24 bits are before the point
    const struct gp_splat_params p = {.group = 2, .method = GP_GROUP_CENTROID};
    struct gp_kernel_params kp = {0};
    struct gp_frame f = scene_frame(WIDE, HIGH, 0, 0, BLACK, 0);
    struct gp_frame image = scene_frame(KW, KH, 0, 0, BLACK, 0);
    struct gp_kernel kernel;
    struct gp_bound_cache cache = {0};
    struct gp_polygons q;
    struct gp_shrink shrink;
    double bound, most = 0.0;
    double *const layer = scene_alloc(N, sizeof *layer);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < WIDE * HIGH; i += 1 + WIDE * (i % WIDE == WIDE - 1))
            f.rgb.c[c][i] = i % WIDE < 7000 ? 0.0f : i % 2 ? 1.5f : 1.0f;
        for (int i = 0; i < KW * KH; i++)
            image.rgb.c[c][i] = i % KW / 2 % 2 ? 0.0f : 1.0f;
    }
    assert_ok(gp_kernel_from_frame(NULL, &kp, &image, &kernel));
    struct scene s = scene_make(f, kernel, &open_all);
    assert_ok(gp_polygons_make(NULL, &s.src, &p, &q));
    assert_ok(gp_shrink_make(NULL, &s.k, &p, &q, &shrink));
    assert_ok(gp_group_bound(NULL, &s.src, &s.k, &p, &q, &shrink, 4.0, &cache,
                             &bound));
    struct gp_polygon *const moved = scene_alloc(q.n, sizeof *moved);
    for (size_t i = 0; i < 2 * COUNT(aside); i++) {
        const float *const by = aside[i / 2];
        struct gp_polygons m = q;
        m.at = moved;
        for (size_t k = 0; k < q.n; k++) {
            const bool back = i % 2 && (int) q.at[k].x / 2 % 2;
            moved[k] = q.at[k];
            moved[k].x += by[0] * (back ? -step : step);
            moved[k].y += by[1] * (back ? -step : step);
        }
        plain_groups(&s.src, &s.k, &p, &m, &shrink, layer);
        for (int k = 0; k < N; k++)
            layer[k] -= s.exact[k];
        most = fmax(most, norm_of(layer, N) / norm_of(s.exact, N) / bound);
    }
    print_message("samples aside: %.3f of the bound %.3g\n", most, bound);
    assert_true(most > 0.5 && most <= 1.0);
    gp_bound_cache_free(&cache);
    gp_polygons_free(&q);
    gp_frame_free(&image);
    scene_free(&s);
    free(moved);
    free(layer);
}

/* Four blocks, each bright at the corner where they meet and a little at its
 * far one, are blurred over the same pixels: light left out of all adds up to
 * nearly twice what it would be side by side. */
static void blocks_may_share_pixels(void **state)
{
    enum { SIDE = 64, N = 3 * SIDE * SIDE, FAR = 8 };
    const struct gp_splat_params p = {.group = 16, .method = GP_GROUP_MOMENTS};
    struct gp_kernel_params kp = {0};
    struct gp_frame f = scene_frame(SIDE, SIDE, 0, 0, BLACK, 0);
    struct gp_frame image = scene_frame(2 * FAR + 1, 1, 0, 0, BLACK, 0);
    struct gp_kernel kernel;
    struct gp_bound_rings rings;
    struct gp_polygons q;
    struct gp_shrink all, none = {0};
    double sum[3], norm[3];
    double *const layer = scene_alloc(N, sizeof *layer);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < 4; i++) {
            const int right = i % 2, low = i / 2;
            f.rgb.c[c][(31 + low) * SIDE + 31 + right] = 9.0f;
            f.rgb.c[c][(16 + 31 * low) * SIDE + 16 + 31 * right] = 1.0f;
        }
        image.rgb.c[c][2 * FAR] = 1.0f;
    }
    assert_ok(gp_kernel_from_frame(NULL, &kp, &image, &kernel));
    struct scene s = scene_make(f, kernel, &open_all);
    assert_ok(gp_polygons_make(NULL, &s.src, &p, &q));
    assert_ok(gp_shrink_make(NULL, &s.k, &p, &q, &all));
    assert_ok(gp_bound_rings_make(NULL, &s.k, false, SIDE, SIDE, &rings));
    assert_ok(gp_bound_rings_left(NULL, &rings, &q, &none, sum, norm));
    plain_groups(&s.src, &s.k, &p, &q, &all, layer);
    const double share =
        norm_of(layer, N) / sqrt(norm[0] * norm[0] + norm[1] * norm[1] +
                                 norm[2] * norm[2]);
    print_message("shared pixels: %.3f of the bound\n", share);
    assert_true(share > 0.55 && share <= 1.0);
    gp_bound_rings_free(&rings);
    gp_polygons_free(&q);
    gp_frame_free(&image);
    scene_free(&s);
    free(layer);
}

/* Rounding to float of the difference of sources and polygons is within its
 * bound: a worst case of signs, of which chance leaves a 20th. */
static void residues_know_their_rounding(void **state)
{
    static const enum light lights[] = {ALL, MANY, EQUAL, RAMP, FEW};
    enum { PAD = 16, W = 61, H = 47, ALONG = W + 2 * PAD };
    double most = 0.0;
    for (int i = 0; i < 2 * (int) COUNT(lights); i++) {
        const struct gp_splat_params p = {
            .group = i % 2 ? 16 : 4, .method = GP_GROUP_MOMENTS,
        };
        struct scene s = scene_sense(
            scene_frame(W, H, -3, 5, lights[i / 2], 3u),
            scene_kernel(3, 3, MID, 0, BOX), &usual);
        struct gp_polygons q;
        struct gp_residue r;
        assert_ok(gp_polygons_make(NULL, &s.src, &p, &q));
        assert_ok(gp_residue_make(NULL, &s.src, &q, PAD, &r));
        double *const d = scene_alloc(ALONG * (H + 2 * PAD), sizeof *d);
        for (int y = 0; y < H; y++) {
            for (uint32_t k = s.src.row[y]; k < s.src.row[y + 1]; k++)
                d[(y + PAD) * ALONG + s.src.x[k] + PAD] =
                    (double) s.src.rgb[1][k];
        }
        for (size_t k = 0; k < q.n; k++) {
            const int m = gp_blur_box[q.at[k].blur];
            const double x = (double) q.at[k].x - (m - 1) / 2.0 + PAD;
            const double y = (double) q.at[k].y - (m - 1) / 2.0 + PAD;
            const double fx = x - floor(x), fy = y - floor(y);
            for (int at = 0; at < (m + 1) * (m + 1); at++) {
                const int j = at / (m + 1), l = at % (m + 1);
                const double down = j == 0 ? 1.0 - fy : j < m ? 1.0 : fy;
                const double along = l == 0 ? 1.0 - fx : l < m ? 1.0 : fx;
                d[((int) y + j) * ALONG + (int) x + l] -=
                    (double) q.at[k].rgb[1] * down * along / ((double) m * m);
            }
        }
        double square = 0.0;
        for (int k = 0; k < ALONG * (H + 2 * PAD); k++)
            square += (d[k] - (double) r.d.c[1][k]) *
                      (d[k] - (double) r.d.c[1][k]);
        if (!(sqrt(square) <= r.rounding[1]))
            fail_msg("row %d: %g, not within %g", i, sqrt(square),
                     r.rounding[1]);
        if (square > 0.0)
            most = fmax(most, sqrt(square) / r.rounding[1]);
        gp_residue_free(&r);
        gp_polygons_free(&q);
        free(d);
        scene_free(&s);
    }
    print_message("residues: %.3f of the bound\n", most);
    assert_true(most > 0.04 && most < 0.06);
}

/* No |K| is under that of the kernel in double, a single sample's neither, whose
 * spectrum is flat; what is added for the transform's rounding is a worst case
 * of signs, of which chance leaves a 150th. */
static void spectra_are_never_too_small(void **state)
{
    enum { W = 40, H = 30, SIDE = 24 };
    double most = 0.0;
    for (int one = 0; one < 2; one++) {
        struct gp_kernel k = scene_kernel(one ? 1 : SIDE, one ? 1 : SIDE, MID,
                                          0, one ? BOX : SPECKS);
        struct gp_power p;
        double added = 0.0, least = INFINITY, over = -INFINITY;
        assert_ok(gp_power_make(NULL, &k, false, W, H, 3, &p));
        const int n = (p.nx / 2 + 1) * p.ny;
        for (int i = 0; i < n; i++) {
            double re = 0.0, im = 0.0;
            for (int j = 0; j < k.w * k.h; j++) {
                const double turn = (double) (j % k.w) * (i / p.ny) / p.nx +
                                    (double) (j / k.w) * (i % p.ny) / p.ny;
                re += (double) k.k.c[0][j] * cos(turn * 2.0 * acos(-1.0));
                im += (double) k.k.c[0][j] * sin(turn * 2.0 * acos(-1.0));
            }
            const double v =
                (double) p.power[0][i] / (1.0 + 0x1p-20) - hypot(re, im);
            assert_true((double) p.most[0][i / p.ny] >= hypot(re, im));
            added += v / n;
            least = fmin(least, v);
            over = fmax(over, v);
        }
        assert_true(least >= 0.0);
        most = fmax(most, fmax(over - added, added - least) / added);
        gp_power_free(&p);
        gp_kernel_free(&k);
    }
    print_message("spectra: rounding takes %.3f of what is added\n", most);
    assert_true(most > 0.004 && most < 0.008);
}

SUITE_OF(adversary, NULL, NULL, no_frame_is_over_its_bound,
         bounds_are_not_twice_too_large, samples_places_are_in_the_bound,
         blocks_may_share_pixels, residues_know_their_rounding,
         spectra_are_never_too_small)
