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
    struct gp_frame f = {.data = {0, 0, src->w, src->h}};
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare g = {0};
    struct gp_glare_stats stats;
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
                         int h, float value, enum gp_surround_how how)
{
    const struct gp_compose_params compose = GP_COMPOSE_DEFAULTS;
    struct gp_frame f = scene_frame(w, h, 0, 0, BLACK, 0);
    for (int c = 0; c < 3; c++) {
        for (int p = 0; p < w * h; p++)
            f.rgb.c[c][p] = value;
    }
    struct scene s = scene_sense(f, (struct gp_kernel) {0}, &usual);
    const struct gp_surround edges = {how, &s.src, NULL};
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
        while (preset[p].name && strcmp(preset[p].name, gp_model_name(*m)) != 0)
            p++;
        if (!preset[p].name && i-- == 0)
            return gp_model_name(*m);
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
                             (i + (int) j) % 2 ? GP_SURROUND_MIRROR
                                               : GP_SURROUND_EXTEND);
            gp_kernel_free(&k);
        }
    }
}

/* The layer is the plain sum's, within 1e-6 or its bound, with kernels that have
 * a tail, without, off centre, tinted and negative. */
static void layers_are_the_plain_sum(void **state)
{
    static const enum shape shapes[] = {PEAK, TINTED, LOBES, BORDER, DIPOLE};
    static const char *const models[] = {"eye", "cie:age=70", "streak",
                                         "aperture"};
    static const char *const engines[] = {"fft", "direct", "auto"};
    static const enum light lights[] = {ALL, RAMP, COLOURED, MANY};
    (void) state;
    for (size_t i = 0; i < (COUNT(shapes) + COUNT(models)) * COUNT(lights);
         i++) {
        const size_t n = i / COUNT(lights);
        const bool model = n >= COUNT(shapes);
        const int w = model ? 420 : 61, h = model ? 300 : 47;
        struct scene s = sensed(w, h, lights[i % COUNT(lights)]);
        s.k = model ? kernel_for(models[n - COUNT(shapes)], w, h)
                    : scene_kernel(45, 38, n == 2 ? 3 : MID, n == 2 ? 40 : MID,
                                   shapes[n]);
        const struct gp_surround edges = {
            i % 2 ? GP_SURROUND_MIRROR : GP_SURROUND_EXTEND, &s.src, NULL,
        };
        const size_t e = model ? 2 * (i % 2) : i % COUNT(engines);
        double bound, black;
        s.exact = scene_alloc(3 * gp_frame_pixels(&s.f), sizeof *s.exact);
        assert_ok(gp_glare_reference(NULL, NULL, &s.src, &s.k, s.exact));
        s.f.layer = layer_of(&s.src, &edges, &s.k, engines[e], &bound);
        black = scene_rel_l2(&s);
        assert_ok(gp_glare_reference(NULL, &edges, &s.src, &s.k, s.exact));
        const double error = scene_rel_l2(&s);
        if (!(error <= fmax(1e-6, s.k.negative ? 0.0 : bound)))
            fail_msg("kernel %zu, light %zu, %s: %g, bound %g", n,
                     i % COUNT(lights), engines[e], error, bound);
        assert_true(i % COUNT(lights) != 0 || black > 1e-3); // light came back
        scene_free(&s);
    }
}

/* The share that is outside, sample by sample. */
static void shares_are_counted(void **state)
{
    const int w = 23, h = 17;
    struct scene s = sensed(w, h, FLAT);
    struct gp_kernel k = scene_kernel(15, 12, 2, 9, TINTED);
    const struct gp_surround edges = {GP_SURROUND_EXTEND, &s.src, NULL};
    const struct gp_surround none = {GP_SURROUND_BLACK, &s.src, NULL};
    struct gp_planes with = layer_of(&s.src, &edges, &k, "direct", NULL);
    struct gp_planes without = layer_of(&s.src, &none, &k, "direct", NULL);
    (void) state;
    for (int i = 0; i < 3 * w * h; i++) {
        const int c = i / (w * h), x = i % w, y = i / w % h;
        double share = 0.0;
        for (int j = 0; j < k.w * k.h; j++) {
            const int sx = x - (j % k.w - k.cx), sy = y - (j / k.w - k.cy);
            if (sx < 0 || sx >= w || sy < 0 || sy >= h)
                share += (double) k.k.c[c][j];
        }
        const double got = (double) with.c[c][i % (w * h)] -
                           (double) without.c[c][i % (w * h)];
        if (!(fabs(got - share) <= 1e-6))
            fail_msg("%d, %d of %d: %g, not %g", x, y, c, got, share);
        assert_true(share > 0.0 || got == 0.0);
    }
    gp_planes_free(&with);
    gp_planes_free(&without);
    gp_kernel_free(&k);
    scene_free(&s);
}

/* Pixels that the kernel does not join with the border keep their bits: with
 * overscan as wide as the kernel reaches nothing changes. */
static void overscan_makes_no_difference(void **state)
{
    const int w = 90, h = 80, reach = 20;
    struct scene s = sensed(w, h, ALL);
    struct gp_kernel k = scene_kernel(2 * reach + 1, 2 * reach + 1, MID, MID,
                                      PEAK);
    const struct gp_surround none = {GP_SURROUND_BLACK, &s.src, NULL};
    struct gp_planes want = layer_of(&s.src, &none, &k, "fft", NULL);
    (void) state;
    for (int how = GP_SURROUND_EXTEND; how <= GP_SURROUND_MIRROR; how++) {
        const struct gp_surround edges = {(enum gp_surround_how) how, &s.src,
                                          NULL};
        struct gp_planes got = layer_of(&s.src, &edges, &k, "fft", NULL);
        for (int i = 0; i < 3 * w * h; i++) {
            const int x = i % w, y = i / w % h, c = i / (w * h);
            const float a = want.c[c][i % (w * h)], b = got.c[c][i % (w * h)];
            const bool inside = x >= reach && x < w - reach && y >= reach &&
                                y < h - reach;
            if (inside && how == GP_SURROUND_EXTEND)
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

/* A mirror image is that of the pixels. */
static void mirrors_are_plain(void **state)
{
    const int w = 29, h = 21, reach = gp_mirror_reach(29, 21);
    struct scene s = sensed(w, h, ALL);
    struct gp_kernel k = scene_kernel(2 * reach + 1, 2 * reach + 1, MID, MID,
                                      TINTED);
    const struct gp_surround edges = {GP_SURROUND_MIRROR, &s.src, NULL};
    struct gp_planes got = layer_of(&s.src, &edges, &k, "direct", NULL);
    struct gp_planes light;
    (void) state;
    assert_ok(gp_sources_planes(NULL, &s.src, &light));
    for (int i = 0; i < 3 * w * h; i++) {
        const int c = i / (w * h), x = i % w, y = i / w % h;
        double want = 0.0;
        for (int j = 0; j < k.w * k.h; j++) {
            int sx = x - (j % k.w - k.cx), sy = y - (j / k.w - k.cy);
            sx = sx < 0 ? -1 - sx : sx < w ? sx : 2 * w - 1 - sx;
            sy = sy < 0 ? -1 - sy : sy < h ? sy : 2 * h - 1 - sy;
            want += (double) light.c[c][sy * w + sx] * (double) k.k.c[c][j];
        }
        assert_close((double) got.c[c][i % (w * h)], want, 1e-6);
    }
    gp_planes_free(&light);
    gp_planes_free(&got);
    gp_kernel_free(&k);
    scene_free(&s);
}

/* Parts of a picture that add up to it add up beyond its border too. */
static void parts_add_up(void **state)
{
    const int w = 120, h = 80;
    struct scene s = sensed(w, h, ALL);
    struct gp_kernel k = kernel_for("eye", w, h);
    struct gp_sources part[2];
    struct gp_planes layer[3];
    (void) state;
    for (int i = 0; i < 2; i++) {
        assert_ok(gp_sources_make(NULL, &s.src, s.src.n, &part[i]));
        for (int y = 0; y < h; y++) {
            for (uint32_t j = s.src.row[y]; j < s.src.row[y + 1]; j++) {
                const float to = scene_noise((int) j);
                const float share = i ? 1.0f - to : to;
                const float rgb[3] = {share * s.src.rgb[0][j],
                                      share * s.src.rgb[1][j],
                                      share * s.src.rgb[2][j]};
                gp_sources_add(&part[i], s.src.x[j], y, rgb);
            }
        }
        gp_sources_finish(&part[i]);
    }
    for (int i = 0; i < 3; i++) {
        const struct gp_sources *const own = i < 2 ? &part[i] : &s.src;
        const struct gp_surround edges = {GP_SURROUND_EXTEND, &s.src, own};
        layer[i] = layer_of(own, &edges, &k, "direct", NULL);
    }
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < w * h; i++)
            assert_close((double) layer[0].c[c][i] + (double) layer[1].c[c][i],
                         (double) layer[2].c[c][i], 2e-6);
    }
    for (int i = 0; i < 3; i++)
        gp_planes_free(&layer[i]);
    gp_sources_free(&part[0]);
    gp_sources_free(&part[1]);
    gp_kernel_free(&k);
    scene_free(&s);
}

/* A lamp that leaves the picture in twenty frames, by night and before a sky:
 * the light of the layer falls as that of the picture does; no step of it is
 * another by over 3 % of what was there first. */
static void leaving_lamps_fade(void **state)
{
    static const char *const models[] = {"eye", "cie:age=70",
                                         "moffat:share=.06,fwhm=.1,beta=2.5"};
    enum { FRAMES = 20, RADIUS = 10 };
    const int w = 320, h = 180;
    (void) state;
    for (size_t i = 0; i < 2 * COUNT(models); i++) {
        const float sky = i % 2 ? 3.0f : 0.02f;
        struct gp_kernel k = kernel_for(models[i / 2], w, h);
        double first[2] = {0}, before[2] = {0};
        for (int frame = 0; frame < FRAMES; frame++) {
            struct gp_frame f = scene_frame(w, h, 0, 0, BLACK, 0);
            const double x = w - 2 * RADIUS + 30.0 * frame / FRAMES;
            for (int p = 0; p < w * h; p++) {
                const double r = hypot(p % w - x, p / w - 80.0);
                const double in = fmin(fmax(RADIUS + 0.5 - r, 0.0), 1.0);
                for (int c = 0; c < 3; c++)
                    f.rgb.c[c][p] = sky + (float) (1000.0 * in);
            }
            struct scene s = scene_sense(f, (struct gp_kernel) {0}, &usual);
            const struct gp_surround edges = {GP_SURROUND_EXTEND, &s.src, NULL};
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

/* A frame of `sky`, w wide, with a lamp of 1000 at x. */
static struct scene lamp_at(int w, int h, double x, double radius, float sky)
{
    struct gp_frame f = scene_frame(w, h, 0, 0, BLACK, 0);
    for (int p = 0; p < w * h; p++) {
        const double r = hypot(p % w + 0.5 - x, p / w + 0.5 - 0.5 * h);
        const double in = fmin(fmax(radius + 0.5 - r, 0.0), 1.0);
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][p] = sky + (float) (1000.0 * in);
    }
    return scene_sense(f, (struct gp_kernel) {0}, &usual);
}

/* A lamp that the border cuts adds nothing beyond it, by night and before a sky:
 * no pixel gets more light than of the whole picture, by 2 %. */
static void cut_lamps_add_nothing(void **state)
{
    static const char *const models[] = {
        "moffat:share=.06,fwhm=.1,beta=2.5", "star", "streak", "aperture", "eye",
    };
    const int w = 320, h = 180, more = 160;
    (void) state;
    for (size_t i = 0; i < 4 * COUNT(models); i++) {
        const float sky = i % 2 ? 3.0f : 0.02f;
        const double radius = i % 4 < 2 ? 8.0 : 14.0;
        struct gp_kernel k = kernel_for(models[i / 4], w + more, h);
        struct scene cut = lamp_at(w, h, w + 3.0, radius, sky);
        struct scene whole = lamp_at(w + more, h, w + 3.0, radius, sky);
        const struct gp_surround ends = {GP_SURROUND_EXTEND, &cut.src, NULL};
        const struct gp_surround far = {GP_SURROUND_EXTEND, &whole.src, NULL};
        struct gp_planes got = layer_of(&cut.src, &ends, &k, "fft", NULL);
        struct gp_planes want = layer_of(&whole.src, &far, &k, "fft", NULL);
        for (int p = 0; p < w * h; p++) {
            for (int c = 0; c < 3; c++) {
                const float a = got.c[c][p];
                const float b = want.c[c][p / w * (w + more) + p % w];
                if (a > 1.02f * b + 1e-3f)
                    fail_msg("%s, sky %g, %d %d: %g, not %g", models[i / 4],
                             (double) sky, p % w, p / w, (double) a, (double) b);
            }
        }
        gp_planes_free(&got);
        gp_planes_free(&want);
        gp_kernel_free(&k);
        scene_free(&cut);
        scene_free(&whole);
    }
}

SUITE_OF(edges, NULL, NULL,
    flat_pictures_stay_flat,
    layers_are_the_plain_sum,
    shares_are_counted,
    overscan_makes_no_difference,
    mirrors_are_plain,
    parts_add_up,
    leaving_lamps_fade,
    cut_lamps_add_nothing)
