/* Frames and kernels made up for `costs`. */
#ifndef GP_BENCH_COSTS_SCENE_H
#define GP_BENCH_COSTS_SCENE_H

#include "core/colour.h"
#include "costs.h"
#include "glare/engine.h"
#include "glare/sensors.h"

#include <stdlib.h>
#include <string.h>

/* w * h pixels, `spots` squares of side * side sources at places that look
 * random and stay the same; the layer is made and touched. */
static inline struct gp_frame costs_frame(int w, int h, int spots, int side)
{
    struct gp_frame f = {.data = {0, 0, w, h}, .display = {0, 0, w, h}};
    const size_t n = (size_t) w * (size_t) h;
    uint32_t seed = 1;
    memcpy(f.luminance, gp_rec709_luminance, sizeof f.luminance);
    if (gp_planes_make(NULL, "rgb", n, &f.rgb) ||
        gp_planes_make(NULL, "layer", n, &f.layer))
        costs_die("out of memory");
    for (int c = 0; c < 3; c++) {
        memset(f.layer.c[c], 0, n * sizeof(float));
        for (size_t i = 0; i < n; i++)
            f.rgb.c[c][i] = 0.25f;
    }
    for (int i = 0; i < spots; i++) {
        seed = seed * 1664525u + 1013904223u; // Numerical Recipes
        const int x0 = (int) (seed >> 8) % (w - side + 1);
        seed = seed * 1664525u + 1013904223u;
        const int y0 = (int) (seed >> 8) % (h - side + 1);
        for (int y = y0; y < y0 + side; y++) {
            for (int x = x0; x < x0 + side; x++) {
                for (int c = 0; c < 3; c++)
                    f.rgb.c[c][(size_t) y * (size_t) w + (size_t) x] =
                        2.0f + (float) c;
            }
        }
    }
    return f;
}

/* Coloured, size * size, 1 / (r^2 + 3/2) in its middle. */
static inline struct gp_kernel costs_kernel(int size)
{
    struct gp_frame f = {.data = {0, 0, size, size}};
    const struct gp_kernel_params p = {0};
    struct gp_kernel k;
    memcpy(f.luminance, gp_rec709_luminance, sizeof f.luminance);
    if (gp_planes_make(NULL, "kernel", (size_t) size * (size_t) size, &f.rgb))
        costs_die("out of memory");
    for (int i = 0; i < size * size; i++) {
        const double dx = i % size - size / 2, dy = i / size - size / 2;
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] = (float) ((1.0 + 0.1 * c) /
                                     (dx * dx + dy * dy + 1.5));
    }
    if (gp_kernel_from_frame(NULL, &p, &f, &k))
        costs_die("kernel");
    gp_planes_free(&f.rgb);
    return k;
}

/* A request that an engine can run. */
struct costs_run {
    struct gp_frame f;
    struct gp_kernel k;
    struct gp_sources src;
    struct gp_glare_params params;
    struct gp_glare_stats stats;
    const struct gp_engine *engine;
    void *state;
};

static inline struct costs_run costs_make(const struct gp_engine *engine,
                                          int w, int h, int spots, int side,
                                          int kernel)
{
    const struct gp_sensor_params sense = GP_SENSOR_DEFAULTS;
    struct costs_run j = {
        .f = costs_frame(w, h, spots, side), .k = costs_kernel(kernel),
        .params = GP_GLARE_DEFAULTS, .engine = engine,
    };
    if (gp_sense(NULL, &sense, &j.f, &j.src))
        costs_die("out of memory");
    return j;
}

static inline struct gp_glare_request costs_request(struct costs_run *j)
{
    return (struct gp_glare_request) {
        .params = &j->params, .src = &j->src, .kernel = &j->k,
        .layer = &j->f.layer, .stats = &j->stats,
    };
}

static inline void costs_run(void *ctx)
{
    struct costs_run *const j = ctx;
    const struct gp_glare_request req = costs_request(j);
    if (j->engine->run(&req, &j->state))
        costs_die(j->engine->name);
}

static inline void costs_free(struct costs_run *j)
{
    j->engine->close(&j->state);
    gp_sources_free(&j->src);
    gp_kernel_free(&j->k);
    gp_planes_free(&j->f.rgb);
    gp_planes_free(&j->f.layer);
}

/* Least ms of the engine on such a frame, all set up; *src gets how many
 * sources there are. */
static inline double costs_engine_ms(const struct gp_engine *engine, int w,
                                     int h, int spots, int side, int kernel,
                                     double *sources)
{
    struct costs_run j = costs_make(engine, w, h, spots, side, kernel);
    const double ms = costs_time(costs_run, &j);
    if (sources)
        *sources = (double) j.src.n;
    costs_free(&j);
    return ms;
}

#endif
