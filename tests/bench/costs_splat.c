/* Cost of splat on the context that `auto` would open. */
#include "costs_scene.h"

#include <math.h>
#include <stdio.h>

/* ms with this setting, and without set-up in *ms. */
static double first_ms(const struct gp_splat_params *p, int w, int h, int spots,
                       int side, int kernel, double *ms, double *sources)
{
    struct costs_run j =
        costs_make(&gp_engine_splat, w, h, spots, side, kernel);
    const struct gp_glare_request req = costs_request(&j);
    j.params.splat = *p;
    const double t = costs_now();
    if (j.engine->run(&req, &j.state)) {
        fprintf(stderr, "costs: no GL context: what splat costs stays\n");
        costs_free(&j);
        return -1.0;
    }
    const double first = costs_now() - t;
    *ms = costs_time(costs_run, &j);
    *sources = (double) j.src.n;
    costs_free(&j);
    return first;
}

/* Bounds, not drawn: no context is opened. */
static void bound_ms(void)
{
    enum { W = 1024, H = 768, KERNEL = 511, RUNS = 5 };
    double first = INFINITY, later = INFINITY, bound;
    if (!costs_wants("GP_COST_BOUND"))
        return;
    for (int i = 0; i < RUNS; i++) {
        struct costs_run j =
            costs_make(&gp_engine_splat, W, H, 200, 6, KERNEL);
        const struct gp_glare_request req = costs_request(&j);
        for (int again = 0; again < 2; again++) {
            j.params.splat.cluster_fill = again ? 0.8f : 0.9f; // a new layout
            const double t = costs_now();
            if (j.engine->bound(&req, &j.state, &bound))
                costs_die("bound");
            double *const ms = again ? &later : &first;
            *ms = fmin(*ms, costs_now() - t);
        }
        costs_free(&j);
    }
    COSTS_PRINT(GP_COST_BOUND_PIXEL, later / (1.0 * W * H));
    COSTS_PRINT(GP_COST_BOUND_POINT,
                (first - later) / (3.0 * (W + 0.5 * KERNEL) *
                                   (H + 0.5 * KERNEL)));
}

void costs_splat(void)
{
    struct gp_splat_params tile = GP_SPLAT_EXACT, quad = GP_SPLAT_EXACT;
    double n, small, base, lamps, large, many, tall;
    bound_ms();
    if (!costs_wants("GP_COST_GL"))
        return;
    tile.primitive = GP_PRIMITIVE_TILE;
    quad.primitive = GP_PRIMITIVE_QUAD;
    const double first = first_ms(&tile, 64, 64, 1, 1, 1, &small, &n);
    if (first < 0.0)
        return;
    COSTS_PRINT(GP_COST_GL_START, first - small);
    first_ms(&tile, 1024, 768, 1, 1, 1, &base, &n);
    COSTS_PRINT(GP_COST_GL_TRANSFER,
                  (base - small) / (1024.0 * 768 - 64 * 64));
    first_ms(&tile, 1024, 768, 2000, 6, 1, &many, &n);
    const double source = (many - base) / n;
    COSTS_PRINT(GP_COST_GL_SOURCE, source);
    // 64 fields of as many pixels together as the one of `base`
    first_ms(&tile, 12, 64 * 1024, 500, 1, 1, &tall, &n);
    COSTS_PRINT(GP_COST_GL_FIELD, (tall - base - source * n) / 63.0);
    // kernels of 129 x 129 that hardly leave the frame
    first_ms(&tile, 1024, 768, 300, 1, 129, &large, &n);
    COSTS_PRINT(GP_COST_GL_TILE, (large - base) / (n * 129 * 129));
    first_ms(&quad, 1024, 768, 2, 1, 1, &small, &n);
    const double sensor = (small - base) / (1024.0 * 768);
    COSTS_PRINT(GP_COST_GL_SENSOR, sensor);
    first_ms(&quad, 1024, 768, 2000, 1, 1, &lamps, &n);
    COSTS_PRINT(GP_COST_GL_POLYGON,
                  (lamps - base - sensor * 1024 * 768) / n);
    first_ms(&quad, 1024, 768, 300, 1, 129, &large, &n);
    COSTS_PRINT(GP_COST_GL_BLEND,
                  (large - base - sensor * 1024 * 768) / (n * 129 * 129));
}
