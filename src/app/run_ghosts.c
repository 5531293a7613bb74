/* Runs the engines for lens flare of bright pixels. */
#include "app/stages.h"

#include "core/clock.h"
#include "core/memory.h"

#include <math.h>

/* Adds the layer of a run to that of f. Adds the squared norms of the whole and of
 * the frame's part to norm2[0] and [1]. */
static void add_layer(const struct gp_frame *from, struct gp_frame *f,
                      double norm2[2])
{
    const struct gp_rect in = from->data, to = f->data;
    const size_t w = (size_t) gp_rect_w(in);
    const int first = to.x0 - in.x0, end = to.x1 - in.x0;
    for (int y = 0; y < gp_rect_h(in); y++) {
        const int row = in.y0 + y - to.y0;
        double all = 0.0, own = 0.0;
        for (int c = 0; c < 3; c++) {
            const float *const v = from->layer.c[c] + (size_t) y * w;
            for (size_t x = 0; x < w; x++)
                all += (double) v[x] * (double) v[x];
            if (row < 0 || row >= gp_rect_h(to))
                continue;
            float *const out = f->layer.c[c] +
                               (size_t) row * (size_t) gp_rect_w(to);
            for (int x = first; x < end; x++) {
                own += (double) v[x] * (double) v[x];
                out[x - first] += v[x];
            }
        }
        norm2[0] += all;
        norm2[1] += own;
    }
}

gp_status gp_run_ghosts_add(const struct gp_log *log, const struct gp_run *r,
    const struct gp_sources *src, struct gp_run_ghosts *ghosts,
    struct gp_frame *f, struct gp_flare_facts *facts)
{
    const struct gp_flare *const flare = &r->suns.flare;
    const double start = gp_now_ms();
    struct gp_glare_params p = r->s->glare;
    double error = 0.0; // norm of the errors
    double light = 0.0; // squared norms of the layers
    gp_status st = GP_OK;
    if (!src->n || !gp_flare_has(flare, GP_FLARE_BRIGHT))
        return GP_OK;
    p.tolerance_pixel = 0.0f; // a window has no picture to be relative to
    p.taken = NULL;
    GP_TRY(gp_ghosts_make(log, flare, f->data, f->display, &ghosts->set));
    if (!ghosts->engine)
        GP_TRY(gp_alloc_zero(log, "engines", (size_t) ghosts->set.n,
                             sizeof *ghosts->engine, &ghosts->engine));
    ghosts->engines = ghosts->set.n;
    if (!f->layer.c[0]) {
        GP_TRY(gp_planes_make(log, "layer", gp_frame_pixels(f), &f->layer));
        gp_planes_clear(&f->layer, 0, gp_frame_pixels(f));
    }
    for (int i = 0; i < ghosts->set.n; i++) {
        const struct gp_ghost *const run = &ghosts->set.run[i];
        struct gp_frame window = {.path = f->path, .display = f->display};
        struct gp_sources moved = {0};
        struct gp_glare_stats stats = {0};
        double norm2[2] = {0};
        if (!run->kernel.w)
            continue;
        st = gp_ghost_move(log, &ghosts->set, run, src, &moved);
        window.data = (struct gp_rect) {moved.x0, moved.y0, moved.x0 + moved.w,
                                        moved.y0 + moved.h};
        if (!st && moved.n)
            st = gp_glare_run(log, &p, &ghosts->engine[i], &moved, &run->kernel,
                              &window, &stats);
        if (!st && moved.n)
            add_layer(&window, f, norm2);
        gp_planes_free(&window.layer);
        gp_sources_free(&moved);
        GP_TRY(st);
        if (!stats.engine)
            continue;
        facts->engine = !facts->runs || facts->engine == stats.engine
                            ? stats.engine : "several";
        facts->elements += run->elements;
        facts->runs++;
        // the exact layer's norm is at most that of the run / (1 - bound)
        error += stats.bound < 1.0
                     ? stats.bound * sqrt(norm2[0]) / (1.0 - stats.bound)
                     : INFINITY;
        error += run->split * sqrt(norm2[0]);
        light += norm2[1]; // no layer is negative: their sum has no less
    }
    facts->bound = error < sqrt(light) ? error / (sqrt(light) - error)
                                       : INFINITY;
    facts->ms = gp_now_ms() - start;
out:
    return st;
}

void gp_run_ghosts_free(struct gp_run_ghosts *ghosts)
{
    for (int i = 0; i < ghosts->engines; i++)
        gp_glare_close(&ghosts->engine[i]);
    gp_free(ghosts->engine);
    gp_ghosts_free(&ghosts->set);
    *ghosts = (struct gp_run_ghosts) {0};
}
