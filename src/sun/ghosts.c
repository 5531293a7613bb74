// SPDX-License-Identifier: Apache-2.0
#include "sun/ghosts.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "sun/flare_priv.h"

#include <math.h>
#include <string.h>

// -- images ------------------------------------------------------------------

/* Scales coordinate v of axis k about the display's centre. */
static double moved_by(const struct gp_ghost *run, struct gp_rect display,
                       int k, double v)
{
    const double c = gp_rect_middle(display, k);
    return c + run->scale * (v - c);
}

/* Pixels from any source to any pixel of the frame along axis k, at most. */
static double farthest(const struct gp_ghost *run, const struct gp_ghosts *g,
                       int k)
{
    const double end[2] = {k == 0 ? g->data.x0 : g->data.y0,
                           k == 0 ? g->data.x1 : g->data.y1};
    double most = 0.0;
    for (int i = 0; i < 4; i++)
        most = fmax(most, fabs(moved_by(run, g->display, k, end[i & 1]) -
                               end[i >> 1]));
    return ceil(most) + 1.0;
}

/* Returns true when elements i and k are of bright pixels and one run: of one
 * position, and sources dimmed alike. */
static bool is_one_run(const struct gp_flare *f, int i, int k)
{
    const struct gp_flare_element *const a = &f->element[i];
    const struct gp_flare_element *const b = &f->element[k];
    return a->source == GP_FLARE_BRIGHT && b->source == GP_FLARE_BRIGHT &&
           a->at == b->at && a->flicker == b->flicker &&
           (a->flicker == 0.0 || a->seed == b->seed) &&
           a->by_place.given == b->by_place.given &&
           a->by_place.edge == b->by_place.edge &&
           memcmp(a->by_place.colour, b->by_place.colour,
                  sizeof a->by_place.colour) == 0;
}

/* Returns the error (rel_l2) of the worst channel where w * h pixels of `image`
 * are split evenly among four, against `half`, drawn half a pixel further. */
static double split_error(const struct gp_planes *image,
                          const struct gp_planes *half, int w, int h)
{
    double worst = 0.0;
    for (int c = 0; c < 3; c++) {
        double off = 0.0, norm = 0.0;
        for (int y = 1; y < h; y++) {
            const float *const v = image->c[c] + (size_t) y * (size_t) w;
            const float *const above = v - w;
            const float *const want = half->c[c] + (size_t) y * (size_t) w;
            for (int x = 1; x < w; x++) {
                const double got = 0.25 * ((double) v[x] + (double) v[x - 1] +
                                           (double) above[x] +
                                           (double) above[x - 1]);
                const double d = got - (double) want[x];
                off += d * d;
                norm += got * got;
            }
        }
        if (norm > 0.0)
            worst = fmax(worst, sqrt(off / norm));
    }
    return worst;
}

/* Draws elements for a lamp into planes of 2m + 1 by 2n + 1 pixels, made here,
 * whose middle is pixel (0, 0). */
static gp_status draw(const struct gp_log *log, const struct gp_flare *own,
    const struct gp_light *lamp, int m, int n, struct gp_rect display,
    struct gp_planes *out)
{
    const size_t pixels = (size_t) (2 * m + 1) * (size_t) (2 * n + 1);
    const struct gp_rect frame = {-m, -n, m + 1, n + 1};
    const gp_status st = gp_planes_make(log, "flare of bright pixels", pixels,
                                        out);
    if (st)
        return st;
    gp_planes_clear(out, 0, pixels);
    return gp_flare_add(log, own, lamp, 1, frame, display, out);
}

/* Draws the elements of a run, of which k is the first, into its image. */
static gp_status draw_image(const struct gp_log *log, const struct gp_flare *f,
    const struct gp_ghosts *g, int k0, struct gp_ghost *run)
{
    static const double most = 1 << 26; // pixels
    struct gp_light lamp = GP_LIGHT_DEFAULTS;
    struct gp_flare own = {0};
    struct gp_planes planes = {0}, half = {0};
    struct gp_rect reach = {0};
    gp_status st;
    double place[2];
    run->e = &f->element[k0];
    run->scale = 1.0 - run->e->at;
    for (int k = 0; k < 2; k++) {
        run->pixel[k] = (int) floor(gp_rect_middle(g->display, k));
        place[k] = moved_by(run, g->display, k, run->pixel[k] + 0.5);
        run->moved[k] = (int) floor(place[k]);
        place[k] -= run->moved[k];
    }
    for (int c = 0; c < 3; c++)
        lamp.flux[c] = 1.0f;
    lamp.x = place[0];
    lamp.y = place[1];
    GP_TRY(gp_alloc(log, "flare of bright pixels", (size_t) f->n,
                    sizeof *own.element, &own.element));
    for (int i = k0; i < f->n; i++) {
        if (!is_one_run(f, k0, i))
            continue;
        own.element[own.n] = f->element[i]; // borrows
        own.element[own.n].at = 0.0;
        own.element[own.n].source = GP_FLARE_LIGHTS;
        own.element[own.n].flicker = 0.0; // of the sources
        own.element[own.n].by_place.given = false;
        reach = gp_rect_join(reach, gp_flare_reach(&own.element[own.n++], &lamp,
                                                   g->display));
    }
    run->elements = own.n;
    const double far_x = fmin(fmax(-reach.x0, reach.x1), farthest(run, g, 0));
    const double far_y = fmin(fmax(-reach.y0, reach.y1), farthest(run, g, 1));
    const double w = 2.0 * far_x + 1.0, h = 2.0 * far_y + 1.0;
    if (w * h > most)
        GP_TRY(gp_fail(log, GP_ERR_DATA, "%s: element %d: its image is too "
                       "large (%.0fx%.0f pixels); give a smaller size or "
                       "position", f->path, k0 + 1, w, h));
    const int m = (int) far_x, n = (int) far_y;
    const size_t pixels = (size_t) (2 * m + 1) * (size_t) (2 * n + 1);
    bool black = true;
    GP_TRY(draw(log, &own, &lamp, m, n, g->display, &planes));
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; black && i < pixels; i++)
            black = !(planes.c[c][i] > 1e-37f);
    }
    if (!black && run->scale != rint(run->scale)) {
        lamp.x += 0.5;
        lamp.y += 0.5;
        GP_TRY(draw(log, &own, &lamp, m, n, g->display, &half));
        run->split = split_error(&planes, &half, 2 * m + 1, 2 * n + 1);
    }
    if (!black) {
        st = gp_kernel_of_planes(log, f->path, 2 * m + 1, 2 * n + 1, &planes,
                                 &run->kernel);
        planes = (struct gp_planes) {0};
    }
out:
    gp_free(own.element);
    gp_planes_free(&planes);
    gp_planes_free(&half);
    return st;
}

gp_status gp_ghosts_make(const struct gp_log *log, const struct gp_flare *f,
    struct gp_rect data, struct gp_rect display, struct gp_ghosts *out)
{
    gp_status st = GP_OK;
    out->frame = f->frame;
    if (out->run && memcmp(&out->data, &data, sizeof data) == 0 &&
        memcmp(&out->display, &display, sizeof display) == 0)
        return GP_OK;
    gp_ghosts_free(out);
    struct gp_ghosts g = {.data = data, .display = display, .frame = f->frame};
    GP_TRY(gp_alloc_zero(log, "flare of bright pixels", (size_t) f->n + 1,
                         sizeof *g.run, &g.run));
    for (int i = 0; i < f->n; i++) {
        bool drawn = f->element[i].source != GP_FLARE_BRIGHT;
        for (int k = 0; k < i && !drawn; k++)
            drawn = is_one_run(f, k, i);
        if (!drawn)
            GP_TRY(draw_image(log, f, &g, i, &g.run[g.n++]));
    }
    *out = g;
    g = (struct gp_ghosts) {0};
out:
    gp_ghosts_free(&g);
    return st;
}

void gp_ghosts_free(struct gp_ghosts *g)
{
    for (int i = 0; i < g->n; i++)
        gp_kernel_free(&g->run[i].kernel);
    gp_free(g->run);
    *g = (struct gp_ghosts) {0};
}

// -- sources -----------------------------------------------------------------

/* Returns the point of the grid at or before the scaled pixel v of axis k, and
 * how far after it the pixel lies, in [0, 1). Exact for whole scales. */
static int point_of(const struct gp_ghost *run, int k, int v, double *after)
{
    const double u = run->scale * ((double) v - run->pixel[k]);
    const double low = floor(u);
    *after = u - low;
    return run->moved[k] + (int) low;
}

/* Finds the points of axis k that sources of pixels [v0, v1) may light and that
 * the image carries into the frame, joined with the frame. */
static void cut_axis(const struct gp_ghosts *g, const struct gp_ghost *run,
                     int k, int v0, int v1, int *lo, int *hi)
{
    const struct gp_kernel *const ker = &run->kernel;
    const int from = k == 0 ? g->data.x0 : g->data.y0;
    const int to = k == 0 ? g->data.x1 : g->data.y1;
    const int c = k == 0 ? ker->cx : ker->cy, size = k == 0 ? ker->w : ker->h;
    double after;
    const int a = point_of(run, k, v0, &after);
    const int b = point_of(run, k, v1 - 1, &after);
    *lo = gp_max(gp_min(a, b), from + c - size + 1);
    *hi = gp_min(gp_max(a, b) + 2, to + c);
    *lo = gp_min(*lo, from);
    *hi = gp_max(*hi, to);
}

/* Sums of a row of points, and those that are not 0. */
struct sums {
    double *v[3];
    int lo, hi;
};

/* Adds `weight` of row y of the sources. */
static void add_row(const struct gp_ghosts *g, const struct gp_ghost *run,
    const struct gp_sources *src, int y, double weight, int x0, int w,
    struct sums *to)
{
    double dim[3] = {1.0, 1.0, 1.0}, size;
    for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
        double after;
        const int x = point_of(run, 0, src->x0 + src->x[i], &after) - x0;
        if (run->e->by_place.given)
            gp_flare_factors(&run->e->by_place, src->x0 + src->x[i] + 0.5,
                             src->y0 + y + 0.5, g->display, &size, dim);
        for (int k = 0; k < 2; k++) {
            const double share = weight * (k == 0 ? 1.0 - after : after);
            if (x + k < 0 || x + k >= w || !(share > 0.0))
                continue;
            for (int c = 0; c < 3; c++)
                to->v[c][x + k] += share * dim[c] * (double) src->rgb[c][i];
            to->lo = gp_min(to->lo, x + k);
            to->hi = gp_max(to->hi, x + k + 1);
        }
    }
}

gp_status gp_ghost_move(const struct gp_log *log, const struct gp_ghosts *g,
    const struct gp_ghost *run, const struct gp_sources *src,
    struct gp_sources *out)
{
    const struct gp_rect box = src->box;
    const double bright = gp_flare_flicker(run->e, g->frame);
    struct gp_rect window = g->data;
    struct gp_sources like = *src, s = {0};
    struct sums sums = {0};
    double *block = NULL;
    gp_status st;
    if (src->n) {
        cut_axis(g, run, 0, src->x0 + box.x0, src->x0 + box.x1, &window.x0,
                 &window.x1);
        cut_axis(g, run, 1, src->y0 + box.y0, src->y0 + box.y1, &window.y0,
                 &window.y1);
    }
    like.x0 = window.x0;
    like.y0 = window.y0;
    like.w = gp_rect_w(window);
    like.h = gp_rect_h(window);
    const size_t points = (size_t) like.w * (size_t) like.h;
    GP_TRY(gp_sources_make(log, &like, src->n < points / 4 ? 4 * src->n
                                                           : points, &s));
    GP_TRY(gp_alloc_zero(log, "sources", 3 * (size_t) like.w, sizeof *block,
                         &block));
    for (int c = 0; c < 3; c++)
        sums.v[c] = block + (size_t) c * (size_t) like.w;
    for (int y = 0; y < like.h; y++) {
        // rows of sources whose point is this one or the one before
        const double from = y + like.y0 - run->moved[1] - 1.0, to = from + 2.0;
        int row[2] = {box.y0, box.y1};
        if (fabs(run->scale) > 1e-9) {
            const double a = from / run->scale, b = to / run->scale;
            const double base = run->pixel[1] - src->y0;
            row[0] = (int) fmax(floor(fmin(a, b) + base) - 1.0, row[0]);
            row[1] = (int) fmin(ceil(fmax(a, b) + base) + 2.0, row[1]);
        }
        sums.lo = like.w;
        sums.hi = 0;
        for (int k = row[0]; k < row[1]; k++) {
            double after;
            const int at = point_of(run, 1, src->y0 + k, &after) - like.y0;
            const double weight = (at == y       ? 1.0 - after
                                   : at + 1 == y ? after : 0.0) * bright;
            if (weight > 0.0)
                add_row(g, run, src, k, weight, like.x0, like.w, &sums);
        }
        for (int x = sums.lo; x < sums.hi; x++) {
            float rgb[3];
            for (int c = 0; c < 3; c++) {
                rgb[c] = (float) fmin(sums.v[c][x], 3e38);
                sums.v[c][x] = 0.0;
            }
            gp_sources_add(&s, x, y, rgb);
        }
    }
    gp_sources_finish(&s);
    *out = s;
    s = (struct gp_sources) {0};
out:
    gp_free(block);
    gp_sources_free(&s);
    return st;
}
