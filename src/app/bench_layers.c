/* Rows of bench for the flare of bright pixels and for ghosts of a lens. */
#include "app/stages.h"

#include "core/memory.h"

#include <math.h>

/* The sources scaled for each element, by the planned engine. */
static gp_status draw_flare(void *user, const struct gp_log *log,
    const struct gp_sources *src, struct gp_frame *f, double *bound)
{
    struct gp_bench_layers *const b = user;
    struct gp_flare_facts facts = {0};
    const gp_status st = gp_run_ghosts_add(log, &b->run, src, &b->run.glare.ghosts, f,
                                           &facts);
    *bound = facts.bound;
    return st;
}

/* Adds the part of a window's layer that is in f. */
static void add_window(const struct gp_frame *f, const struct gp_sources *moved,
                       const double *layer, double *out)
{
    const size_t n = gp_frame_pixels(f);
    const size_t own = (size_t) moved->w * (size_t) moved->h;
    const int x0 = f->data.x0 - moved->x0, y0 = f->data.y0 - moved->y0;
    const int w = gp_frame_w(f);
    for (size_t i = 0; i < 3 * n; i++) {
        const int x = (int) (i % n) % w + x0, y = (int) (i % n) / w + y0;
        out[i] += layer[i / n * own + (size_t) y * (size_t) moved->w +
                        (size_t) x];
    }
}

/* The same, each run summed in double. */
static gp_status sum_flare(void *user, const struct gp_log *log,
    const struct gp_sources *src, const struct gp_frame *f, double *out)
{
    struct gp_bench_layers *const b = user;
    struct gp_ghosts *const set = &b->run.glare.ghosts.set;
    gp_status st = gp_ghosts_make(log, &b->run.suns.flare, f->data, f->display,
                                  set);
    for (int i = 0; i < set->n && !st; i++) {
        const struct gp_ghost *const run = &set->run[i];
        struct gp_sources moved = {0};
        double *layer = NULL;
        if (!run->kernel.w)
            continue;
        st = gp_ghost_move(log, set, run, src, &moved);
        if (!st && moved.n)
            st = gp_alloc(log, "exact layer", (size_t) moved.w *
                                                  (size_t) moved.h,
                          3 * sizeof *layer, &layer);
        if (!st && moved.n)
            st = gp_glare_reference(log, NULL, &moved, &run->kernel, layer);
        if (!st && moved.n)
            add_window(f, &moved, layer, out);
        gp_free(layer);
        gp_sources_free(&moved);
    }
    return st;
}

/* Ghosts of the lens into f->layer. Meshes have no bound. */
static gp_status draw_lens(struct gp_bench_layers *b, const struct gp_log *log,
    const struct gp_sources *src, const struct gp_frame *f,
    enum gp_lens_detail detail)
{
    struct gp_frame_state fs = {
        .log = log, .job = &b->job, .frame = *f, .sources = *src};
    return gp_run_lens(&b->run, &fs, detail);
}

static gp_status draw_coarse(void *user, const struct gp_log *log,
    const struct gp_sources *src, struct gp_frame *f, double *bound)
{
    *bound = NAN;
    return draw_lens(user, log, src, f, GP_LENS_COARSE);
}

static gp_status draw_fine(void *user, const struct gp_log *log,
    const struct gp_sources *src, struct gp_frame *f, double *bound)
{
    *bound = NAN;
    return draw_lens(user, log, src, f, GP_LENS_FINE);
}

static gp_status draw_reference(void *user, const struct gp_log *log,
    const struct gp_sources *src, const struct gp_frame *f, double *out)
{
    const size_t n = gp_frame_pixels(f);
    struct gp_frame own = *f;
    gp_status st = gp_planes_make(log, "exact layer", n, &own.layer);
    if (st)
        return st;
    gp_planes_clear(&own.layer, 0, n);
    st = draw_lens(user, log, src, &own, GP_LENS_REFERENCE);
    for (size_t i = 0; i < 3 * n && !st; i++)
        out[i] += (double) own.layer.c[i / n][i % n];
    gp_planes_free(&own.layer);
    return st;
}

static void add_row(struct gp_bench_layers *b, struct gp_bench_layer row)
{
    row.user = b;
    b->row[b->rows++] = row;
}

gp_status gp_bench_layers_begin(const struct gp_log *log,
    const struct gp_settings *s, char *input, struct gp_bench_layers *out)
{
    gp_status st = GP_OK;
    out->job = (struct gp_job) {.input = input};
    out->files = (struct gp_sun_files) {s, &out->job};
    out->run.s = s;
    if (s->sun.flare || s->lens.name) {
        const struct gp_sun_reader reader = gp_sun_reader_of(&out->files);
        GP_TRY(gp_suns_begin(log, &s->sun, s->glare.gl, &reader,
                             &out->run.suns));
    }
    if (gp_flare_has(&out->run.suns.flare, GP_FLARE_BRIGHT))
        add_row(out, (struct gp_bench_layer) {
            .name = "flare of bright pixels", .options = "--flare",
            .layer = "flare", .draw = draw_flare, .exact = sum_flare});
    GP_TRY(gp_run_lens_begin(log, &out->run));
    if (s->lens.name) {
        add_row(out, (struct gp_bench_layer) {
            .name = "lens, of many lights", .options = "--lens",
            .layer = "lens", .draw = draw_coarse, .exact = draw_reference});
        add_row(out, (struct gp_bench_layer) {
            .name = "lens, of up to 8 lights", .options = "--lens --lights",
            .layer = "lens", .draw = draw_fine, .exact = draw_reference});
    }
out:
    if (st)
        gp_bench_layers_end(out);
    return st;
}

void gp_bench_layers_end(struct gp_bench_layers *b)
{
    gp_run_ghosts_free(&b->run.glare.ghosts);
    gp_suns_close(&b->run.suns);
    b->rows = 0;
}
