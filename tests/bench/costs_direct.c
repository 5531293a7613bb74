/* Cost of direct. */
#include "costs_scene.h"

#include "glare/direct/direct.h"

enum { STRIP = GP_TAPS_PAD };

/* Rows of strips that the sources' kernels cover. */
static double source_rows(const struct costs_run *j)
{
    const struct gp_sources *const s = &j->src;
    double rows = 0.0;
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            const int x0 = s->x[i] - j->k.cx, y0 = y - j->k.cy;
            const int from = x0 > 0 ? x0 : 0, top = y0 > 0 ? y0 : 0;
            const int to = x0 + j->k.w < s->w ? x0 + j->k.w : s->w;
            const int end = y0 + j->k.h < s->h ? y0 + j->k.h : s->h;
            rows += (double) ((to - 1) / STRIP - from / STRIP + 1) *
                    (end - top);
        }
    }
    return rows;
}

/* ms without any work but for the layer's rows: it depends on where the layer
 * happens to lie, so the median of several. */
static double empty_ms(int w, int h)
{
    enum { LAYERS = 5 };
    double ms[LAYERS];
    for (int i = 0; i < LAYERS; i++) {
        const double v =
            costs_engine_ms(&gp_engine_direct, w, h, 1, 1, 1, NULL);
        int at = i;
        for (; at > 0 && ms[at - 1] > v; at--)
            ms[at] = ms[at - 1];
        ms[at] = v;
    }
    return ms[LAYERS / 2];
}

/* ms of a row of a source's kernel: of squares of side * side sources, in a
 * frame so small that its own rows are a small part. */
static double row_ms(int w, int h, int kernel, int spots, int side)
{
    struct costs_run j = costs_make(&gp_engine_direct, w, h, spots, side,
                                    kernel);
    const double ms = costs_time(costs_run, &j), rows = source_rows(&j);
    costs_free(&j);
    return (ms - empty_ms(w, h)) / rows;
}

static void measure_rows(double run)
{
    static const int side[3] = {209, 836, 3344};
    double row[3];
    for (int i = 0; i < 3; i++)
        row[i] = (empty_ms(side[i], side[i]) - run) /
                 ((side[i] + STRIP - 1) / STRIP * side[i]);
    COSTS_PRINT(GP_COST_DIRECT_STRIP_ROW, row[0], row[1], row[2]);
}

/* ms of a tile of a quad, where kernels of 64 x 64 hardly leave the frame. */
static double tile_ms(void)
{
    struct costs_run j =
        costs_make(&gp_engine_direct, 800, 600, 250, 6, 64);
    const double ms = costs_time(costs_run, &j);
    const double tiles = gp_direct_quads(&j.src) * (64 + 15) / 16 *
                         (64 + 3) / 4;
    costs_free(&j);
    return tiles > 0.0 ? (ms - empty_ms(800, 600)) / tiles : 0.0;
}

static void lay_out(void *ctx)
{
    struct gp_taps taps;
    if (gp_taps_make(NULL, ctx, -1, &taps))
        costs_die("out of memory");
    gp_taps_free(&taps);
}

void costs_direct(void)
{
    if (!costs_wants("GP_COST_DIRECT"))
        return;
    const double run =
        costs_engine_ms(&gp_engine_direct, 8, 8, 1, 1, 1, NULL);
    COSTS_PRINT(GP_COST_DIRECT_RUN, run);
    measure_rows(run);
    // with its padding a kernel of n * n has 12 (n + 64) n bytes
    const double near[3] = {
        row_ms(400, 300, 120, 6, 24), row_ms(400, 300, 226, 2, 24),
        row_ms(1000, 750, 992, 2, 24),
    };
    const double far[3] = {
        row_ms(400, 300, 39, 2000, 1), row_ms(400, 300, 226, 600, 1),
        row_ms(1000, 750, 992, 300, 1),
    };
    COSTS_PRINT(GP_COST_DIRECT_NEAR_ROW, near[0], near[1], near[2]);
    COSTS_PRINT(GP_COST_DIRECT_FAR_ROW, far[0], far[1], far[2]);
    COSTS_PRINT(GP_COST_DIRECT_QUAD_TILE, tile_ms());
    COSTS_PRINT(GP_COST_DIRECT_TAP, row_ms(512, 512, 512, 40, 1) / STRIP);
    COSTS_PRINT(GP_COST_DIRECT_PIXEL, empty_ms(1920, 1080) / (1920.0 * 1080));
    double sources;
    const double listed =
        costs_engine_ms(&gp_engine_direct, 400, 300, 5000, 1, 1, &sources);
    COSTS_PRINT(GP_COST_DIRECT_LIST,
                  (listed - empty_ms(400, 300)) / sources - far[0]);
    struct gp_kernel k = costs_kernel(256);
    COSTS_PRINT(GP_COST_DIRECT_LAYOUT,
                  costs_time(lay_out, &k) /
                      (3.0 * (k.w + 2.0 * GP_TAPS_PAD) * k.h));
    gp_kernel_free(&k);
}
