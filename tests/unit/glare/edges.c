// SPDX-License-Identifier: Apache-2.0
/* glare/edges.c: the picture goes on beyond its border. */
#include "unit.h"
#include "core/luminance.h"
#include "glare/edges.h"
#include "glare/glare_priv.h"
#include "glare_scene.h"

/* The layer of sources with a picture that goes on; made. */
static struct gp_planes layer_of(const struct gp_sources *src,
    const struct gp_surround *edges, const struct gp_kernel *k,
    const char *engine, double *bound)
{
    struct gp_image f = {.data = {0, 0, src->w, src->h}};
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare g = {0};
    struct glarepp_layer_facts stats;
    p.engine = engine;
    p.edges = *edges;
    assert_ok(gp_glare_run(NULL, &p, &g, src, k, &f, &stats));
    if (bound)
        *bound = stats.bound;
    gp_glare_close(&g);
    return f.layer;
}

/* The kernel of a recipe for a picture, and its mirror image, 36 pixels a
 * degree. */
static struct gp_kernel kernel_for(const char *recipe, int w, int h)
{
    const int more = 2 * gp_mirror_reach(w, h);
    const struct gp_field field =
        scene_field(w + more, h + more, 1.0 / 36.0, 1.0);
    struct gp_kernel k;
    model_make(recipe, &field, &k);
    return k;
}

static struct scene sensed(int w, int h, enum light light)
{
    return scene_sense(scene_frame(w, h, 0, 0, light, 1),
                       (struct gp_kernel) {0}, &usual);
}

static void assert_stays(const char *word, const struct gp_kernel *k, int w,
                         int h, float value, enum glarepp_edges how)
{
    const struct gp_compose_params compose = {
        .gain = 1,
        .mix = GLAREPP_SCATTER,
    };
    struct gp_image f = scene_frame(w, h, 0, 0, BLACK, 0);
    for (int c = 0; c < 3; c++) {
        for (int p = 0; p < w * h; p++)
            f.rgb.c[c][p] = value;
    }
    struct scene s = scene_sense(f, (struct gp_kernel) {0}, &usual);
    const struct gp_surround edges = {.how = how, .picture = &s.src};
    s.f.layer = layer_of(&s.src, &edges, k, "auto", NULL);
    assert_ok(gp_compose(NULL, &compose, &s.src, &s.f));
    for (int p = 0; p < 3 * w * h; p++) {
        const float got = s.f.lit.c[p / (w * h)][p % (w * h)];
        if (!(fabsf(got - value) <= 1e-4f * value))
            fail_msg("%s, %dx%d: %.8g, not %g", word, w, h, (double) got,
                     (double) value);
    }
    scene_free(&s);
}

/* The i-th preset, then the models that no preset is named after; NULL after the
 * last. */
static const char *word_at(int i)
{
    const struct gp_model_preset *const preset = gp_model_presets;
    for (int p = 0; preset[p].name; p++) {
        if (i-- == 0)
            return preset[p].name;
    }
    for (const struct gp_model *const *m = gp_models; *m; m++) {
        int p = 0;
        while (preset[p].name && strcmp(preset[p].name, (*m)->name) != 0)
            p++;
        if (!preset[p].name && i-- == 0)
            return (*m)->name;
    }
    return NULL;
}

/* A flat picture of any value comes out flat, of every model and size. */
static void flat_pictures_stay_flat(void **state)
{
    static const struct { int w, h; } sizes[] = {
        {1, 1}, {1, 7}, {2, 2}, {13, 5}, {65, 36}, {301, 200}, {2048, 3},
        {640, 360},
    };
    static const float values[] = {0.5f, 10.0f, 1000.0f};
    static const char *const tinted[] = { // as far as their light goes
        "streak:share=1", "halation:share=.3", "star:share=1", NULL,
    };
    const char *word;
    int words = 0;
    (void) state;
    while (word_at(words))
        words++;
    for (int i = 0; (word = i < words ? word_at(i) : tinted[i - words]); i++) {
        struct gp_recipe r;
        const bool whole = gp_recipe_parse(NULL, word, &r) == GP_OK;
        if (whole)
            gp_recipe_free(&r);
        if (!whole)
            continue; // it wants a file
        for (size_t j = 0; j < COUNT(sizes); j++) {
            const int w = sizes[j].w, h = sizes[j].h;
            struct gp_kernel k = kernel_for(word, w, h);
            for (size_t v = 0; v < (j < 5 ? COUNT(values) : 2); v++)
                assert_stays(word, &k, w, h, values[v],
                             (i + (int) j) % 2 ? GLAREPP_MIRROR
                                               : GLAREPP_EXTEND);
            gp_kernel_free(&k);
        }
    }
}

/* The layer is the plain sum's, within 1e-6 or its bound, with kernels that have
 * a far field, without, off centre, tinted and negative. */
static void layers_are_the_plain_sum(void **state)
{
    static const enum shape shapes[] = {PEAK, TINTED, LOBES, BORDER, DIPOLE};
    static const char *const models[] = {"eye", "cie:age=70", "streak",
                                         "aperture"};
    static const char *const engines[] = {"fft", "direct", "auto"};
    static const enum light lights[] = {ALL, RAMP, COLOURED, MANY};
    (void) state;
    struct gp_kernel k = {0};
    for (size_t i = 0; i < (COUNT(shapes) + COUNT(models)) * COUNT(lights);
         i++) {
        const size_t n = i / COUNT(lights);
        const bool model = n >= COUNT(shapes);
        const int w = model ? 420 : 61, h = model ? 100 : 47;
        struct scene s = sensed(w, h, lights[i % COUNT(lights)]);
        if (i % COUNT(lights) == 0)
            k = model ? kernel_for(models[n - COUNT(shapes)], w, h)
                      : scene_kernel(45, 38, n == 2 ? 3 : MID,
                                     n == 2 ? 40 : MID, shapes[n]);
        s.k = k;
        const struct gp_surround edges = {
            .how = i % 2 ? GLAREPP_MIRROR : GLAREPP_EXTEND,
            .picture = &s.src,
        };
        const size_t e = model ? 2 * (i % 2) : i % COUNT(engines);
        double bound, black;
        s.exact = scene_alloc(3 * gp_image_pixels(&s.f), sizeof *s.exact);
        assert_ok(gp_glare_reference(NULL, NULL, &s.src, &s.k, NULL, s.exact));
        s.f.layer = layer_of(&s.src, &edges, &s.k, engines[e], &bound);
        black = scene_rel_l2(&s);
        assert_ok(
            gp_glare_reference(NULL, &edges, &s.src, &s.k, NULL, s.exact));
        const double error = scene_rel_l2(&s);
        if (!(error <= fmax(1e-6, s.k.negative ? 0.0 : bound)))
            fail_msg("kernel %zu, light %zu, %s: %g, bound %g", n,
                     i % COUNT(lights), engines[e], error, bound);
        assert_true(i % COUNT(lights) != 0 || black > 1e-3); // light came back
        if (i % COUNT(lights) < COUNT(lights) - 1)
            s.k = (struct gp_kernel) {0}; // the next light has it too
        scene_free(&s);
    }
}

/* Pixels that the kernel does not join with the border keep their bits: with
 * overscan as wide as the kernel reaches nothing changes. */
static void overscan_makes_no_difference(void **state)
{
    const int w = 90, h = 80, reach = 20;
    struct scene s = sensed(w, h, ALL);
    struct gp_kernel k = scene_kernel(2 * reach + 1, 2 * reach + 1, MID, MID,
                                      PEAK);
    const struct gp_surround none = {.how = GLAREPP_BLACK};
    struct gp_planes want = layer_of(&s.src, &none, &k, "fft", NULL);
    (void) state;
    for (int how = GLAREPP_EXTEND; how <= GLAREPP_MIRROR; how++) {
        const struct gp_surround edges = {.how = (enum glarepp_edges) how,
                                          .picture = &s.src};
        struct gp_planes got = layer_of(&s.src, &edges, &k, "fft", NULL);
        for (int i = 0; i < 3 * w * h; i++) {
            const int x = i % w, y = i / w % h, c = i / (w * h);
            const float a = want.c[c][i % (w * h)], b = got.c[c][i % (w * h)];
            const bool inside = x >= reach && x < w - reach && y >= reach &&
                                y < h - reach;
            if (inside && how == GLAREPP_EXTEND)
                assert_true(a == b);
            else if (inside) // transforms of another size
                assert_true(fabsf(a - b) <= 1e-5f * a);
            else
                assert_true(b > a);
        }
        gp_planes_free(&got);
    }
    gp_planes_free(&want);
    gp_kernel_free(&k);
    scene_free(&s);
}

/* A lamp that leaves the picture in twenty frames, by night and before a sky:
 * the light of the layer falls as that of the picture does; no step of it is
 * another by over 3 % of what was there first. */
static void leaving_lamps_fade(void **state)
{
    static const char *const models[] = {"eye",
                                         "moffat:share=.06,fwhm=.1,beta=2.5"};
    enum { FRAMES = 20, RADIUS = 10 };
    const int w = 320, h = 180;
    (void) state;
    for (size_t i = 0; i < 2 * COUNT(models); i++) {
        const float sky = i % 2 ? 3.0f : 0.02f;
        struct gp_kernel k = kernel_for(models[i / 2], w, h);
        double first[2] = {0}, before[2] = {0};
        for (int frame = 0; frame < FRAMES; frame++) {
            struct gp_image f = scene_frame(w, h, 0, 0, BLACK, 0);
            const double x = w - 2 * RADIUS + 30.0 * frame / FRAMES;
            for (int p = 0; p < w * h; p++) {
                const double r = hypot(p % w - x, p / w - 80.0);
                const double in = fmin(fmax(RADIUS + 0.5 - r, 0.0), 1.0);
                for (int c = 0; c < 3; c++)
                    f.rgb.c[c][p] = sky + (float) (1000.0 * in);
            }
            struct scene s = scene_sense(f, (struct gp_kernel) {0}, &usual);
            const struct gp_surround edges = {.how = GLAREPP_EXTEND,
                                              .picture = &s.src};
            struct gp_planes layer = layer_of(&s.src, &edges, &k, "auto", NULL);
            double sum[3], squares;
            gp_planes_sum(&layer, (size_t) w * (size_t) h, sum, &squares);
            const double now[2] = {sum[1], s.src.flux[1]};
            if (frame == 0)
                memcpy(first, now, sizeof first);
            const double step = frame ? (before[0] - now[0]) / first[0] : 0.0;
            const double own = frame ? (before[1] - now[1]) / first[1] : 0.0;
            // (its own edge is drawn to a thousandth)
            if (step < -1e-3 || fabs(step - own) > 0.03)
                fail_msg("%s, sky %g, frame %d: a step of %g where the light "
                         "has %g", models[i / 2], (double) sky, frame, step, own);
            memcpy(before, now, sizeof before);
            gp_planes_free(&layer);
            scene_free(&s);
        }
        gp_kernel_free(&k);
    }
}

/* Where a turn has so many columns a kernel's samples go around, once: of a whole turn,
 * and of a part, whose other side is near. */
static void light_goes_around(void **state)
{
    static const int turns[] = {61, 67, 90};
    static const char *const engines[] = {"fft", "direct", "auto"};
    enum { W = 61, H = 20, KW = 51, KH = 9 };
    (void) state;
    for (size_t i = 0; i < COUNT(turns) * COUNT(engines); i++) {
        const int turn = turns[i / COUNT(engines)];
        struct scene s = sensed(W, H, MANY);
        s.k = scene_kernel(KW, KH, 9, 2, TINTED);
        const struct gp_surround edges = {
            .how = GLAREPP_BLACK, .picture = &s.src, .turn = turn};
        double *const want = scene_alloc(3 * W * H, sizeof *want);
        memset(want, 0, 3 * W * H * sizeof *want);
        for (int p = 0; p < W * H; p++) {
            for (uint32_t k = 0; k < s.src.n; k++) {
                int y = 0;
                while (s.src.row[y + 1] <= k)
                    y++;
                const int dy = p / W - y + 2, most = turn < 41 ? turn : 41;
                for (int side = -1; side <= 1; side++) {
                    const int from = s.src.x[k] + side * turn;
                    const int dx = p % W - from + 9;
                    if (from < -most || from >= W + most || dx < 0 ||
                        dx >= KW || dy < 0 || dy >= KH)
                        continue;
                    for (int c = 0; c < 3; c++)
                        want[c * W * H + p] +=
                            (double) s.src.rgb[c][k] *
                            (double) s.k.k.c[c][dy * KW + dx];
                }
            }
        }
        s.f.layer =
            layer_of(&s.src, &edges, &s.k, engines[i % COUNT(engines)], NULL);
        s.exact = scene_alloc(3 * W * H, sizeof *s.exact);
        assert_ok(
            gp_glare_reference(NULL, &edges, &s.src, &s.k, NULL, s.exact));
        assert_true(scene_rel_l2(&s) < 1e-6);
        for (int p = 0; p < 3 * W * H; p++)
            assert_true(fabs(s.exact[p] - want[p]) <= 1e-9 * (1.0 + want[p]));
        free(want);
        scene_free(&s);
    }
}

SUITE_OF(edges, NULL, NULL, flat_pictures_stay_flat, layers_are_the_plain_sum,
         overscan_makes_no_difference, leaving_lamps_fade, light_goes_around)
