/* Every function of glare with a plain form, as pairs.h has it. */
#include "unit.h"
#include "glare/direct/direct.h"
#include "glare/glare_priv.h"
#include "glare/splat/splat_priv.h"
#include "glare_scene.h"
#include "pairs.h"
#include "plain_groups.h"

/* -- sensors, by the contract's words ---------------------------------------
 */

struct sensing {
    const struct gp_sensor_params *params;
    struct gp_frame f;
    float *plain; // the frame as it was
};

static void *open_sensing(const struct pair *pair, struct gp_frame f)
{
    struct sensing *const p = scene_alloc(1, sizeof *p);
    const size_t n = gp_frame_pixels(&f);
    *p = (struct sensing) {pair->how, f, scene_alloc(3 * n, sizeof(float))};
    for (size_t i = 0; i < 3 * n; i++)
        p->plain[i] = f.rgb.c[i / n][i % n];
    return p;
}

static void sense_plainly(void *ctx, double *out)
{
    const struct sensing *const p = ctx;
    const size_t n = gp_frame_pixels(&p->f);
    const double limit = (double) p->params->max_value;
    float top = 65504.0f; // +Inf counts as this
    for (size_t i = 0; i < 3 * n; i++)
        top = isfinite(p->plain[i]) ? fmaxf(top, p->plain[i]) : top;
    for (size_t i = 0; i < n; i++) {
        float rgb[3], y = 0.0f; // of the pixel's light: values over 0
        float most = 0.0f;
        for (size_t c = 0; c < 3; c++) {
            const float v = p->plain[c * n + i];
            rgb[c] = isnan(v) || v == -INFINITY ? 0.0f : fminf(v, top);
            most = fmaxf(most, rgb[c]);
        }
        for (size_t c = 0; c < 3; c++) {
            if (limit > 0.0 && (double) most > limit)
                rgb[c] = (float) ((double) rgb[c] * (limit / (double) most));
            y += p->f.luminance[c] * fmaxf(rgb[c], 0.0f);
        }
        float v[3];
        for (int c = 0; c < 3; c++)
            v[c] = fmaxf(rgb[c], 0.0f) * gp_bright_pass(p->params, y);
        const bool faint = fmaxf(v[0], fmaxf(v[1], v[2])) < GP_FAINT;
        for (size_t c = 0; c < 3; c++)
            out[c * n + i] = faint && v[c] < FLT_MIN ? 0.0 : (double) v[c];
    }
}

static void sense(void *ctx, float *out)
{
    struct sensing *const p = ctx;
    struct gp_sources src;
    struct gp_planes image;
    const size_t n = gp_frame_pixels(&p->f);
    for (int c = 0; c < 3; c++)
        memcpy(p->f.rgb.c[c], p->plain + (size_t) c * n, n * sizeof(float));
    if (gp_sense(NULL, p->params, &p->f, &src) ||
        gp_sources_planes(NULL, &src, &image))
        abort();
    for (int c = 0; c < 3; c++)
        memcpy(out + (size_t) c * n, image.c[c], n * sizeof(float));
    gp_planes_free(&image);
    gp_sources_free(&src);
}

static void close_sensing(void *ctx)
{
    struct sensing *const p = ctx;
    gp_frame_free(&p->f);
    free(p->plain);
    free(p);
}

/* -- engines -----------------------------------------------------------------
 */

struct spreading {
    const struct pair *pair;
    struct scene s;
    struct gp_taps taps;
    struct gp_glare g;
    struct gp_polygons polygons;
    struct gp_shrink shrink;
};

/* The frame's light, all of it, and a kernel that is not grey. */
static struct spreading *open_spreading(const struct pair *pair,
    struct gp_frame f, int w, int h, int cx, int cy)
{
    struct spreading *const p = scene_alloc(1, sizeof *p);
    p->pair = pair;
    p->s = scene_sense(f, scene_kernel(w, h, cx, cy, TINTED), &open_all);
    return p;
}

static void close_spreading(void *ctx)
{
    struct spreading *const p = ctx;
    gp_taps_free(&p->taps);
    gp_glare_close(&p->g);
    gp_polygons_free(&p->polygons);
    scene_free(&p->s);
    free(p);
}

static void *open_direct(const struct pair *pair, struct gp_frame f)
{
    struct spreading *const p = open_spreading(pair, f, 33, 21, 20, 9);
    assert_ok(gp_taps_make(NULL, &p->s.k, -1, &p->taps));
    return p;
}

static void spread_by_loops(void *ctx, double *out)
{
    const struct spreading *const p = ctx;
    gp_glare_reference_direct(&p->s.src, &p->s.k, out);
}

static void copy_layer(const struct gp_frame *f, float *out)
{
    const size_t n = gp_frame_pixels(f);
    for (int c = 0; c < 3; c++)
        memcpy(out + (size_t) c * n, f->layer.c[c], n * sizeof *out);
}

static void spread_directly(void *ctx, float *out)
{
    struct spreading *const p = ctx;
    scene_clear_layer(&p->s);
    assert_ok(gp_direct_sum(NULL, &p->s.src, &p->taps, false, &p->s.f.layer));
    copy_layer(&p->s.f, out);
}

static void *open_fft(const struct pair *pair, struct gp_frame f)
{
    const int side = gp_frame_pixels(&f) > 100000 ? 129 : 25;
    return open_spreading(pair, f, side, side - 2, MID, 0);
}

static void spread_in_double(void *ctx, double *out)
{
    const struct spreading *const p = ctx;
    assert_ok(gp_glare_reference(NULL, NULL, &p->s.src, &p->s.k, out));
}

static void spread_by_fft(void *ctx, float *out)
{
    struct spreading *const p = ctx;
    struct gp_glare_stats stats;
    assert_ok(scene_run("fft", &p->s, &p->g, &stats));
    copy_layer(&p->s.f, out);
}

static void *open_groups(const struct pair *pair, struct gp_frame f)
{
    const struct gp_splat_params *const how = pair->how;
    struct spreading *const p = open_spreading(pair, f, 23, 18, 11, 9);
    assert_ok(gp_polygons_make(NULL, &p->s.src, how, &p->polygons));
    assert_ok(gp_shrink_make(NULL, &p->s.k, how, &p->polygons, &p->shrink));
    return p;
}

static void draw_plainly(void *ctx, double *out)
{
    struct spreading *const p = ctx;
    plain_groups(&p->s.src, &p->s.k, p->pair->how, &p->polygons, &p->shrink,
                 out);
}

static void *splat_state; // one context for all; closed at the end
static bool no_context;

static void draw_by_splat(void *ctx, float *out)
{
    struct spreading *const p = ctx;
    struct gp_glare_stats stats = {0};
    struct gp_glare_params params = GP_GLARE_DEFAULTS;
    params.splat = *(const struct gp_splat_params *) p->pair->how;
    scene_clear_layer(&p->s);
    const struct gp_glare_request req = {
        .log = &kept_log, .params = &params, .src = &p->s.src,
        .kernel = &p->s.k, .layer = &p->s.f.layer, .stats = &stats,
    };
    if (gp_engine_splat.run(&req, &splat_state))
        fail_msg("%s: %s", p->pair->name, kept_line);
    copy_layer(&p->s.f, out);
}

/* -- rotated kernels ---------------------------------------------------------
 */

struct rotating {
    struct gp_unturned u;
    int w, h;
};

/* The frame is the kernel, without what no kernel has. */
static void *open_rotating(const struct pair *pair, struct gp_frame f)
{
    struct rotating *const p = scene_alloc(1, sizeof *p);
    const int w = gp_frame_w(&f), h = gp_frame_h(&f);
    *p = (struct rotating) {
        {.w = w, .h = h, .cx = w / 2, .cy = h / 3, .k = f.rgb}, w, h,
    };
    for (int i = 0; i < 3 * w * h; i++) {
        float *const v = &f.rgb.c[i / (w * h)][i % (w * h)];
        *v = fabsf(*v) < 1e30f ? *v : 0.0f;
    }
    gp_rotate_angle(*(const float *) pair->how, &p->u);
    return p;
}

/* Samples at offsets from the centre, a frame of them. */
static void rotate_plainly(void *ctx, double *out)
{
    const struct rotating *const p = ctx;
    for (int i = 0; i < 3 * p->w * p->h; i++) {
        const int x = i % p->w, y = i / p->w % p->h, c = i / (p->w * p->h);
        out[i] = (double) (float) gp_rotate_reference(&p->u, c, x - p->w / 2,
                                                      y - p->h / 2);
    }
}

static void rotate(void *ctx, float *out)
{
    const struct rotating *const p = ctx;
    struct gp_rotated r;
    if (gp_rotate(NULL, "kernel", &p->u, false, &r))
        abort();
    for (int i = 0; i < 3 * p->w * p->h; i++) {
        const int x = r.cx + i % p->w - p->w / 2;
        const int y = r.cy + i / p->w % p->h - p->h / 2;
        const bool inside = x >= 0 && x < r.w && y >= 0 && y < r.h;
        out[i] = inside ? r.k.c[i / (p->w * p->h)][y * r.w + x] : 0.0f;
    }
    gp_planes_free(&r.k);
}

static void close_rotating(void *ctx)
{
    struct rotating *const p = ctx;
    gp_planes_free(&p->u.k);
    free(p);
}

/* -- the table ---------------------------------------------------------------
 */

static const struct gp_sensor_params sensing[] = {
    GP_SENSOR_DEFAULTS, WHOLE(0.0f, 0.0f, 65504.0f),
    WHOLE(0.0f, 1.0f, 65504.0f), WHOLE(1.0f, 0.5f, 65504.0f),
    WHOLE(1.0f, 1.0f, 1e30f), WHOLE(0.5f, 0.01f, 0.75f),
    WHOLE(1.0f, 0.0f, FLT_MAX), WHOLE(FLT_MIN, 0.0f, FLT_MIN),
    WHOLE(FLT_MAX, 0.0f, FLT_MAX),
    {.threshold = 0.0f, .max_value = FLT_MAX, .mode = GP_THRESHOLD_EXCESS},
    {.threshold = 0.3f, .max_value = 1e30f, .mode = GP_THRESHOLD_EXCESS},
    {.threshold = FLT_MIN, .max_value = 1.0f, .mode = GP_THRESHOLD_EXCESS},
};
static const struct gp_splat_params
    tiles = {.group = 4, .cluster = 8, .cluster_fill = 0.9f, .shrink = 1e-3f,
             .primitive = GP_PRIMITIVE_TILE},
    quads = {.group = 2, .cluster = 4, .cluster_fill = 0.5f, .shrink = 1e-2f,
             .primitive = GP_PRIMITIVE_QUAD};
static const float angles[] = {30.0f, 90.0f, -77.3f};

#define SENSORS(name, i)                                                      \
    {name, FLT_MAX, 0.0, 0.0, 1920, 1080, false, &sensing[i], open_sensing,   \
     sense_plainly, sense, close_sensing}
#define ROTATED(name, i)                                                      \
    {name, 1e28f, 0.0, 0.0, 511, 511, false, &angles[i], open_rotating,       \
     rotate_plainly, rotate, close_rotating}
/* An engine; `lost` is what products under FLT_MIN lose of a sample. */
#define ENGINE(name, max, bar, lost, w, h, gl, how, open, plain, fast)        \
    {name, max, bar, lost, w, h, gl, how, open, plain, fast, close_spreading}

static const struct pair pairs[] = {
    SENSORS("sensors", 0), SENSORS("sensors, all bright", 1),
    SENSORS("sensors, all on the ramp", 2), SENSORS("sensors, knee 1/2", 3),
    SENSORS("sensors, knee 1", 4), SENSORS("sensors, clamped", 5),
    SENSORS("sensors, not clamped", 6), SENSORS("sensors, least values", 7),
    SENSORS("sensors, largest values", 8), SENSORS("sensors, all over 0", 9),
    SENSORS("sensors, excess", 10), SENSORS("sensors, least excess", 11),
    // half of the least denormal for each of 33x21 samples
    ENGINE("direct", 1e28f, 1e-6, 693 * 0.5 * 1.4013e-45, 512, 384, false,
           NULL, open_direct, spread_by_loops, spread_directly),
    ENGINE("fft", 1e25f, 1e-6, (double) FLT_MIN, 1024, 768, false, NULL,
           open_fft, spread_in_double, spread_by_fft),
    // GL may take each of 23x18 products under FLT_MIN for 0, and its parts
    ENGINE("splat, tiles", 1e25f, 5e-6, 4 * 414 * (double) FLT_MIN, 320, 240,
           true, &tiles, open_groups, draw_plainly, draw_by_splat),
    ENGINE("splat, quads", 1e25f, 5e-6, 4 * 414 * (double) FLT_MIN, 320, 240,
           true, &quads, open_groups, draw_plainly, draw_by_splat),
    ROTATED("rotated kernel", 0), ROTATED("kernel at a right angle", 1),
    ROTATED("kernel rotated back", 2),
};

static void fast_forms_equal_the_plain_ones(void **state)
{
    pairs_prove(pairs, COUNT(pairs), !no_context);
}

/* Rows of every length: what vectors leave over. */
static void sensors_of_any_length(void **state)
{
    static const float odd[] = {0.0f, -0.0f, 1.0f, -3.0f, 2.0f, 65504.0f};
    for (int n = 1; n <= 600; n += n < 40 ? 1 : 36) {
        struct gp_frame f = pair_frame(n, 1, PAIR_UNIFORM, 0.0f, 3u);
        float *const got = scene_alloc(3 * (size_t) n, sizeof *got);
        double *const want = scene_alloc(3 * (size_t) n, sizeof *want);
        for (int i = 0; i < 3 * n; i += 11)
            f.rgb.c[i % 3][i / 3] = odd[i / 11 % 6];
        void *const both = pairs[0].open(&pairs[0], f);
        pairs[0].reference(both, want);
        pairs[0].fast(both, got);
        pairs[0].close(both);
        for (int i = 0; i < 3 * n; i++)
            assert_true((double) got[i] == want[i]);
        free(got);
        free(want);
    }
}

SUITE(pairs)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fast_forms_equal_the_plain_ones),
        cmocka_unit_test(sensors_of_any_length),
    };
    no_context = gp_splat_make(NULL, &splat_state) ||
                 gp_splat_open(&kept_log, splat_state, GP_GL_AUTO);
    if (no_context)
        printf("no context: %s\n", kept_line);
    const bool only_time =
        pairs_time(pairs, COUNT(pairs), !no_context, argc, argv);
    const int failed =
        only_time ? 0 : cmocka_run_group_tests(tests, NULL, NULL);
    gp_engine_splat.close(&splat_state);
    return failed;
}
