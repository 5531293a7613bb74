/* Made-up light and kernels, the splat engine on them, and the plain sum in
 * double that it is tested against. */
#ifndef GP_TESTS_SPLAT_SCENE_H
#define GP_TESTS_SPLAT_SCENE_H

#include "glare/glare_priv.h"
#include "glare/splat/splat_priv.h"
#include "said.h"

static uint32_t seed;

static inline float uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float) (seed >> 8) * 0x1p-24f;
}

/* -- light ----------------------------------------------------------------- */

/* FAINT light is near the smallest that counts. */
enum light { EVERY, NONE, CORNERS, FEW, MANY, HOT, EQUAL, FAINT };

static inline bool is_lit(enum light light, int i, int w, int h)
{
    int x = i % w, y = i / w;
    switch (light) {
    case EVERY:
    case EQUAL:
        return true;
    case NONE:
        return false;
    case CORNERS:
        return (x == 0 || x == w - 1) && (y == 0 || y == h - 1);
    case FEW:
    case HOT:
        return i % 97 == 13 || i == w * h / 2;
    case MANY:
    case FAINT:
        break;
    }
    return uniform() < 0.3f;
}

static inline float lit_value(enum light light, int i, int w, int h)
{
    if (light == EQUAL)
        return 1.1f;
    if (light == FAINT)
        return 1e-35f * (1.0f + uniform());
    if (light == HOT)
        return i == w * h / 2 ? 1e9f : 1e-3f * uniform();
    return i % 5 == 0 ? 65504.0f * uniform() : 1.0f + uniform();
}

static inline struct gp_sources make_sources(int w, int h, enum light light)
{
    const struct gp_sources like = {
        .w = w, .h = h, .luminance = {0.2126f, 0.7152f, 0.0722f},
    };
    struct gp_sources s;
    if (gp_sources_make(NULL, &like, (size_t) w * (size_t) h, &s))
        abort();
    for (int i = 0; i < w * h; i++) {
        float rgb[3];
        if (!is_lit(light, i, w, h))
            continue;
        for (int c = 0; c < 3; c++)
            rgb[c] = i % 11 == c ? 0.0f : lit_value(light, i, w, h);
        gp_sources_add(&s, i % w, i / w, rgb);
    }
    gp_sources_finish(&s);
    return s;
}

/* -- kernels --------------------------------------------------------------- */

enum shape { PEAK, BOX, LOBES, HOLES };

static inline void find_norms(struct gp_kernel *k)
{
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, norm1 = 0.0, squares = 0.0;
        for (int i = 0; i < k->w * k->h; i++) {
            const double v = (double) k->k.c[c][i];
            sum += v;
            norm1 += fabs(v);
            k->negative |= v < 0.0;
            squares += v * v;
        }
        k->sum[c] = sum;
        k->norm1[c] = norm1;
        k->norm2[c] = sqrt(squares);
    }
}

static inline void fill_kernel(struct gp_kernel *k, enum shape shape)
{
    for (int i = 0; i < k->w * k->h; i++) {
        double dx = i % k->w - k->w / 2, dy = i / k->w - k->h / 2;
        for (int c = 0; c < 3; c++) {
            double v = 1.0 / (1.0 + 0.1 * (c + 1) * (dx * dx + dy * dy));
            if (shape == BOX)
                v = 0.1;
            else if (shape == LOBES)
                v = cos(0.7 * dx) * cos(0.4 * dy) * v;
            else if (shape == HOLES)
                v = (i + c) % 3 ? 0.0 : (double) uniform();
            k->k.c[c][i] = (float) v;
        }
    }
    find_norms(k);
}

static inline struct gp_kernel make_kernel(int w, int h, int cx, int cy,
                                           enum shape shape)
{
    struct gp_kernel k = {.w = w, .h = h, .cx = cx, .cy = cy};
    if (gp_planes_make(NULL, "kernel", (size_t) w * (size_t) h, &k.k))
        abort();
    fill_kernel(&k, shape);
    return k;
}

/* -- the engine ------------------------------------------------------------ */

enum { PRIMITIVES = 3 };
static const enum gp_primitive primitives[PRIMITIVES] = {
    GP_PRIMITIVE_QUAD, GP_PRIMITIVE_POINT, GP_PRIMITIVE_TILE,
};
static struct gp_glare_stats stats; // of the last run
static struct gp_splat_params how = GP_SPLAT_EXACT; // of the next

static inline gp_status splat(enum gp_gl_api gl, const struct gp_sources *src,
    const struct gp_kernel *k, struct gp_planes *layer, void **state)
{
    const struct gp_glare_params params = {.engine = "splat", .gain = 1.0f,
                                           .gl = gl, .splat = how};
    const struct gp_glare_job job = {.log = &said_log, .params = &params,
                                     .src = src, .kernel = k, .layer = layer,
                                     .stats = &stats};
    size_t samples = (size_t) src->w * (size_t) src->h;
    stats = (struct gp_glare_stats) {0};
    if (gp_planes_make(NULL, "layer", samples, layer))
        abort();
    for (int c = 0; c < 3; c++) // every sample must be written
        memset(layer->c[c], 0xff, samples * sizeof(float));
    return gp_engine_splat.run(&job, state);
}

/* Makes the engine's state with a context, or skips the test without one. */
static inline void *open_or_skip(enum gp_gl_api gl)
{
    void *state = NULL;
    assert_ok(gp_splat_make(&said_log, &state));
    const gp_status st = gp_splat_open(&said_log, state, gl);
    if (st == GP_ERR_GL && strstr(said_line, "install the Debian")) {
        print_message("no context: %s\n", said_line);
        gp_engine_splat.close(&state);
        skip();
    }
    assert_int_equal(st, GP_OK);
    return state;
}

/* rel_l2 of a layer against the sum in double; 0 when both are all 0. */
static inline double rel_l2(const struct gp_sources *src,
    const struct gp_kernel *k, const struct gp_planes *layer)
{
    const size_t n = (size_t) src->w * (size_t) src->h;
    double wrong = 0.0, all = 0.0, *const sum = calloc(3 * n, sizeof *sum);
    gp_glare_reference_direct(src, k, sum);
    for (size_t i = 0; i < 3 * n; i++) {
        const double d = (double) layer->c[i / n][i % n] - sum[i];
        wrong += d * d;
        all += sum[i] * sum[i];
    }
    free(sum);
    return wrong == 0.0 ? 0.0 : sqrt(wrong / all);
}

#endif
