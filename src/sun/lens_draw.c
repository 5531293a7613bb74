/* Chooses ghosts, traces their meshes light by light, and draws them. */
#include "sun/lens_draw.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "core/spectrum.h"
#include "sun/lens_priv.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum {
    FINE = 48,         // bands that sets of bands join
    SETS = 5,
    MOST_BANDS = 24,
    BAND_ROWS = 256,   // of pixels, drawn by one thread
    CHUNK = 128,       // ghosts of lights in memory at once
};

/* Wavelengths that the rays have: of blue, green and red. */
static const double node[GP_LENS_NODES] = {450.0, 545.0, 640.0};
static const int bands_of_set[SETS] = {1, 3, 6, 12, 24};

// -- bands --------------------------------------------------------------------

/* A part of the spectrum: its share of each channel, and how the nodes make
 * its rays (Lagrange). */
struct band {
    double weight[3];
    double of_node[GP_LENS_NODES];
    // of each channel's own middle of the part
    double of_channel[3][GP_LENS_NODES];
    double image[3];   // 1 / (mm^2 times share) of the image on the axis
};

/* A light's ghost by one pair of surfaces. */
struct item {
    struct gp_lens_mesh mesh;
    struct gp_lens_blades blades;
    double flux[3], turn[2], u;
    double along[2], aside[2], middle[2]; // pixels of the layer: of a mm along
                                          // and across the light's axis, and
                                          // of the lens's axis
    double y0, y1;     // pixels of the layer that it covers
    int set, level;
};

struct job {
    const struct gp_log *log;
    const struct gp_lens *lens;
    const struct gp_lens_view *view;
    const struct gp_lens_light *light;
    const struct gp_lens_ghost *ghost;
    const struct gp_lens_optics *optics;
    const int *kept;   // indices of ghosts
    int kept_n, first; // of the chunk: light * kept_n + ghost
    double scale;      // mm on the sensor for a slope of 1
    struct band band[SETS][MOST_BANDS];
    struct gp_lens_steps level[GP_LENS_LEVELS];
    struct item *item;
    int items;
};

static void lagrange(double nm, double out[GP_LENS_NODES])
{
    for (int k = 0; k < GP_LENS_NODES; k++) {
        out[k] = 1.0;
        for (int i = 0; i < GP_LENS_NODES; i++)
            out[k] *= i == k ? 1.0 : (nm - node[i]) / (node[k] - node[i]);
    }
}

/* No curve is followed below the least light that an eye sees. */
static double seen(double nm)
{
    return nm > 420.0 ? (nm < 680.0 ? nm : 680.0) : 420.0;
}

static void make_bands(struct job *job, const double image[GP_LENS_NODES])
{
    double nm[FINE], rgb[FINE][3];
    gp_spectrum_weights(job->view->chromaticities, FINE, nm, rgb);
    for (int s = 0; s < SETS; s++) {
        const int each = FINE / bands_of_set[s];
        for (int b = 0; b < bands_of_set[s]; b++) {
            struct band *const out = &job->band[s][b];
            double sum = 0.0, middle = 0.0, own[3] = {0};
            *out = (struct band) {0};
            for (int i = b * each; i < (b + 1) * each; i++) {
                for (int c = 0; c < 3; c++) {
                    out->weight[c] += rgb[i][c];
                    own[c] += rgb[i][c] * nm[i];
                    sum += rgb[i][c];
                    middle += rgb[i][c] * nm[i];
                }
            }
            middle = seen(middle / sum);
            lagrange(middle, out->of_node);
            for (int c = 0; c < 3; c++) {
                double at = 0.0;
                lagrange(out->weight[c] > 0.0 ? seen(own[c] / out->weight[c])
                                              : middle, out->of_channel[c]);
                for (int k = 0; k < GP_LENS_NODES; k++)
                    at += out->of_channel[c][k] * image[k];
                out->image[c] = 1.0 / at;
            }
        }
    }
}

// -- choice -------------------------------------------------------------------

static double luminance(const struct gp_lens_view *v, const double rgb[3])
{
    return rgb[0] * (double) v->luminance[0] +
           rgb[1] * (double) v->luminance[1] +
           rgb[2] * (double) v->luminance[2];
}

struct rank {
    double bright; // luminance at a pixel that all lights together may make
    int ghost;
};

static int by_brightness(const void *a, const void *b)
{
    const struct rank *const x = a, *const y = b;
    return x->bright != y->bright ? (x->bright < y->bright ? -1 : 1)
                                  : x->ghost - y->ghost;
}

/* Keeps the ghosts that can be seen, in their order; returns how many. */
static int choose(const struct job *job, const struct gp_lens_ghost *ghost,
                  int n, const double light[3], double image, int *kept,
                  struct gp_lens_stats *stats)
{
    const struct gp_lens_view *const v = job->view;
    const double pixel = v->mm[0] * v->mm[1];
    struct rank rank[GP_LENS_GHOSTS] = {{0}};
    bool dark[GP_LENS_GHOSTS] = {false};
    double sum = 0.0;
    int kept_n = 0;
    for (int i = 0; i < n; i++) {
        // light of a disc of rays over the disc on the sensor, or a pixel
        const double through = ghost[i].through / image;
        const double disc = pi * ghost[i].radius * ghost[i].radius;
        const double area = fmax(disc * ghost[i].m.a * ghost[i].m.a, pixel);
        rank[i] = (struct rank) {
            luminance(v, light) * through * disc * pixel / area, i};
    }
    qsort(rank, (size_t) n, sizeof *rank, by_brightness);
    for (int i = 0; i < n; i++) {
        if (sum + rank[i].bright > v->tolerance * v->mean)
            break;
        sum += rank[i].bright;
        dark[rank[i].ghost] = true;
        stats->left_out++;
    }
    for (int i = 0; i < n; i++) {
        if (!dark[i])
            kept[kept_n++] = i;
    }
    stats->drawn = kept_n;
    stats->dark = v->mean > 0.0 ? sum / v->mean : 0.0;
    return kept_n;
}

// -- places -------------------------------------------------------------------

static void place_axes(const struct gp_lens_view *v, struct item *it)
{
    it->along[0] = it->turn[0] / v->mm[0];
    it->along[1] = it->turn[1] / v->mm[1];
    it->aside[0] = -it->turn[1] / v->mm[0];
    it->aside[1] = it->turn[0] / v->mm[1];
    it->middle[0] = 0.5 * ((double) v->display.x0 + (double) v->display.x1) -
                    v->frame.x0;
    it->middle[1] = 0.5 * ((double) v->display.y0 + (double) v->display.y1) -
                    v->frame.y0;
}

static const struct gp_lens_hit *rays_of(const struct gp_lens_mesh *m, int k)
{
    return m->hit + (size_t) k * (size_t) (m->cells + 1) *
                        (size_t) (m->cells / 2 + 1);
}

/* Finds the rows that an item covers, its step and its bands. */
static void place_item(const struct job *job, const struct gp_lens_ghost *g,
                       struct item *it)
{
    const struct gp_lens_mesh *const m = &it->mesh;
    const int rays = (m->cells + 1) * (m->cells / 2 + 1);
    const double pixel = fmin(job->view->mm[0], job->view->mm[1]);
    const double reach = 1.5 * hypot(job->view->mm[0] *
                                         gp_rect_w(job->view->frame),
                                     job->view->mm[1] *
                                         gp_rect_h(job->view->frame));
    double x0 = INFINITY, x1 = -INFINITY, apart = 0.0;
    it->y0 = INFINITY;
    it->y1 = -INFINITY;
    for (int i = 0; i < rays; i++) {
        const struct gp_lens_hit *const a = &rays_of(m, 0)[i];
        const struct gp_lens_hit *const b = &rays_of(m, 1)[i];
        const struct gp_lens_hit *const c = &rays_of(m, 2)[i];
        if (a->through < 0.0f || b->through < 0.0f || c->through < 0.0f ||
            b->rim > 1.5f)
            continue;
        // (colours far outside the frame are not seen)
        if (b->rim < 1.0f && fabs(b->x) < reach && fabs(b->y) < reach)
            apart = fmax(apart, hypot(c->x - a->x, c->y - a->y) / pixel);
        for (int k = 0; k < 2 * GP_LENS_NODES; k++) {
            const struct gp_lens_hit *const h = k < 2 ? a : k < 4 ? b : c;
            const double aside = k % 2 ? -h->y : h->y;
            const double x = it->middle[0] + h->x * it->along[0] +
                             aside * it->aside[0];
            const double y = it->middle[1] + h->x * it->along[1] +
                             aside * it->aside[1];
            x0 = fmin(x0, x);
            x1 = fmax(x1, x);
            it->y0 = fmin(it->y0, y);
            it->y1 = fmax(it->y1, y);
        }
    }
    // bands reach beyond the nodes; a step must not hide the size
    const double size = fmax(x1 - x0, it->y1 - it->y0);
    const double finest = fmin((job->view->fine ? 0.35 : 0.7) * g->blur / pixel,
                               size / 24.0);
    it->level = 0;
    while (it->level + 1 < GP_LENS_LEVELS && 2 << it->level <= finest)
        it->level++;
    it->set = 0;
    const double most = (job->view->fine ? 1.5 : 3.0) * (1 << it->level);
    while (it->set + 1 < SETS && apart > most * bands_of_set[it->set])
        it->set++;
    it->y0 -= apart + 2.0;
    it->y1 += apart + 2.0;
    if (!(x1 + apart > 0.0 && x0 - apart < gp_rect_w(job->view->frame) &&
          it->y1 > 0.0 && it->y0 < gp_rect_h(job->view->frame)))
        it->level = -1; // outside the frame
}

static gp_status trace_item(void *ctx, int i, int thread)
{
    struct job *const job = ctx;
    struct item *const it = &job->item[i];
    const struct gp_lens_view *const v = job->view;
    const int at = job->first + i;
    const struct gp_lens_light *const light = &job->light[at / job->kept_n];
    const struct gp_lens_ghost *const g =
        &job->ghost[job->kept[at % job->kept_n]];
    const double x = (light->x - 0.5 * ((double) v->display.x0 +
                                        (double) v->display.x1)) * v->mm[0];
    const double y = (light->y - 0.5 * ((double) v->display.y0 +
                                        (double) v->display.y1)) * v->mm[1];
    const double away = hypot(x, y);
    struct gp_lens_path path;
    (void) thread;
    *it = (struct item) {.u = away / job->scale, .turn = {1.0, 0.0},
                         .level = -1};
    if (away > 0.0) {
        it->turn[0] = x / away;
        it->turn[1] = y / away;
    }
    memcpy(it->flux, light->flux, sizeof it->flux);
    place_axes(v, it);
    it->blades = gp_lens_blades_of(job->lens, atan2(it->turn[1], it->turn[0]));
    gp_lens_path(job->lens, g->first, g->second, &path);
    const gp_status st = gp_lens_mesh_make(NULL, job->optics, &path,
                                           &it->blades, it->u,
                                           v->fine ? fmin(v->tolerance, 5e-4)
                                                   : v->tolerance,
                                           (v->fine ? 0.25 : 1.0) *
                                               fmax(g->blur, v->mm[0]),
                                           &it->mesh);
    if (!st && it->mesh.cells)
        place_item(job, g, it);
    return st;
}

// -- drawing ------------------------------------------------------------------

/* A band's rays of an item, in steps of its accumulator. */
struct rays {
    double p[(GP_LENS_CELLS + 1) * (GP_LENS_CELLS / 2 + 1)][2][2]; // halves
    double through[(GP_LENS_CELLS + 1) * (GP_LENS_CELLS / 2 + 1)];
    bool clear[(GP_LENS_CELLS + 1) * (GP_LENS_CELLS / 2 + 1)];
    double density[GP_LENS_CELLS * GP_LENS_CELLS / 2];
};

static void make_rays(const struct item *it, const struct band *b, double step,
                      struct rays *out)
{
    const int n = (it->mesh.cells + 1) * (it->mesh.cells / 2 + 1);
    const double per = 1.0 / step;
    for (int i = 0; i < n; i++) {
        double x = 0.0, y = 0.0, through = 0.0;
        bool whole = true;
        for (int k = 0; k < GP_LENS_NODES; k++) {
            const struct gp_lens_hit *const h = &it->mesh.hit[k * n + i];
            x += b->of_node[k] * h->x;
            y += b->of_node[k] * h->y;
            through += b->of_node[k] * (double) h->through;
            whole = whole && h->through >= 0.0f;
        }
        out->through[i] = !whole ? -1.0 : through > 0.0 ? through : 0.0;
        for (int half = 0; half < 2; half++) {
            const double aside = half ? -y : y;
            // the accumulator begins a step before the frame
            for (int e = 0; e < 2; e++)
                out->p[i][half][e] = (it->middle[e] + x * it->along[e] +
                                      aside * it->aside[e]) * per + 1.0;
        }
    }
}

/* Spreads a piece of a cell; one that a caustic folds as triangles. */
static void add_piece(const struct gp_lens_cover *k, int n,
                      const struct gp_lens_corner *c, const double light[3])
{
    double p[GP_LENS_CORNERS][2], before[GP_LENS_CORNERS], all = 0.0;
    bool left = false, right = false;
    for (int i = 0; i < n; i++) {
        p[i][0] = c[i].x;
        p[i][1] = c[i].y;
    }
    for (int i = 1; i + 1 < n; i++) {
        const double area = (p[i][0] - p[0][0]) * (p[i + 1][1] - p[0][1]) -
                            (p[i + 1][0] - p[0][0]) * (p[i][1] - p[0][1]);
        left = left || area < 0.0;
        right = right || area > 0.0;
        before[i] = fabs((c[i].p - c[0].p) * (c[i + 1].q - c[0].q) -
                         (c[i + 1].p - c[0].p) * (c[i].q - c[0].q));
        all += before[i];
    }
    if (!(left && right) || !(all > 0.0)) {
        gp_lens_cover_add(k, p, n, light);
        return;
    }
    for (int i = 1; i + 1 < n; i++) {
        const double share = before[i] / all;
        const double own[3] = {share * light[0], share * light[1],
                               share * light[2]};
        const double triangle[3][2] = {{p[0][0], p[0][1]}, {p[i][0], p[i][1]},
                                       {p[i + 1][0], p[i + 1][1]}};
        gp_lens_cover_add(k, triangle, 3, own);
    }
}

/* Adds the part of a cell that rims and blades leave, with light a mm^2 before
 * the lens. */
static void add_cell(const struct gp_lens_cover *k, const struct item *it,
                     struct gp_lens_corner c[GP_LENS_CORNERS],
                     const double light[3])
{
    const int n = gp_lens_cut(&it->blades, it->mesh.passes, c);
    double area = 0.0, through = 0.0;
    for (int i = 0; i < n; i++) {
        const struct gp_lens_corner *const b = &c[i + 1 < n ? i + 1 : 0];
        area += 0.5 * (c[i].p * b->q - b->p * c[i].q);
        through += c[i].through / n;
    }
    const double share = fabs(area) * through;
    const double own[3] = {share * light[0], share * light[1],
                           share * light[2]};
    if (n)
        add_piece(k, n, c, own);
}

/* Signed light a step of a whole cell over `cell` mm^2; 0 for one that folds,
 * or of no area, which is drawn by itself. */
static double density_of(const double (*p[4]), double through, double cell)
{
    double twice[4], area = 0.0;
    int left = 0, right = 0;
    for (int e = 0; e < 4; e++) { // the turn at each corner
        const double *const a = p[(e + 3) % 4], *const b = p[e];
        const double *const c = p[(e + 1) % 4];
        twice[e] = (b[0] - a[0]) * (c[1] - b[1]) - (c[0] - b[0]) *
                                                       (b[1] - a[1]);
        left += twice[e] < 0.0;
        right += twice[e] > 0.0;
    }
    area = 0.5 * (twice[0] + twice[2]);
    return (left && right) || !(fabs(area) > 1e-9) ? 0.0
                                                   : -cell * through / area;
}

/* Draws one half of a band: whole cells by the edges that they share, with the
 * difference of their light, others by themselves. */
static void draw_half(const struct item *it, struct rays *rays, int half,
                      const double light[3], const struct gp_lens_cover *k)
{
    const struct gp_lens_mesh *const m = &it->mesh;
    const struct gp_lens_hit *const hit = rays_of(m, GP_LENS_NODES / 2);
    const int w = m->cells + 1, cells = m->cells, rows = m->cells / 2;
    const double dx = (m->x1 - m->x0) / cells, dy = m->y1 / rows;
    const double sign = half ? -1.0 : 1.0;
    for (int j = 0; j < rows; j++) {
        for (int i = 0; i < cells; i++) {
            const int at[4] = {j * w + i, j * w + i + 1, (j + 1) * w + i + 1,
                               (j + 1) * w + i};
            double *const density = &rays->density[j * cells + i];
            const double *p[4];
            bool arrives = true, passes = false, clear = true;
            double low = INFINITY, high = -INFINITY, through = 0.0;
            double left = INFINITY, right = -INFINITY;
            for (int e = 0; e < 4; e++) {
                p[e] = rays->p[at[e]][half];
                arrives = arrives && rays->through[at[e]] >= 0.0;
                passes = passes || hit[at[e]].rim < 1.0f;
                clear = clear && rays->clear[at[e]];
                low = low < p[e][1] ? low : p[e][1];
                high = high > p[e][1] ? high : p[e][1];
                left = left < p[e][0] ? left : p[e][0];
                right = right > p[e][0] ? right : p[e][0];
                through += 0.25 * rays->through[at[e]];
            }
            *density = 0.0;
            if (!arrives || !passes || !(high > k->y0 && low < k->y1) ||
                !(right > 0.0 && left < k->w))
                continue;
            if (clear)
                *density = density_of(p, through, dx * dy);
            if (*density != 0.0)
                continue;
            struct gp_lens_corner c[GP_LENS_CORNERS];
            for (int e = 0; e < 4; e++) {
                const struct gp_lens_hit *const h = &hit[at[e]];
                c[e] = (struct gp_lens_corner) {
                    .p = m->x0 + dx * (i + (e == 1 || e == 2)),
                    .q = sign * dy * (j + (e >= 2)), .x = p[e][0],
                    .y = p[e][1], .through = rays->through[at[e]],
                    .rim = (double) h->rim,
                };
                for (int s = 0; s < m->passes; s++) {
                    c[e].stop[s][0] = (double) h->stop[s][0];
                    c[e].stop[s][1] = sign * (double) h->stop[s][1];
                }
            }
            add_cell(k, it, c, light);
        }
    }
    for (int j = 0; j <= rows; j++) {
        for (int i = 0; i <= cells; i++) {
            const double *const d = &rays->density[j * cells + i];
            const double here = j < rows && i < cells ? d[0] : 0.0;
            const double left = j < rows && i > 0 ? d[-1] : 0.0;
            const double above = j > 0 && i < cells ? d[-cells] : 0.0;
            const double *const p = rays->p[j * w + i][half];
            const double across[3] = {light[0] * (here - above),
                                      light[1] * (here - above),
                                      light[2] * (here - above)};
            const double down[3] = {light[0] * (left - here),
                                    light[1] * (left - here),
                                    light[2] * (left - here)};
            if (here != above)
                gp_lens_cover_edge(k, p, rays->p[j * w + i + 1][half], across);
            if (left != here)
                gp_lens_cover_edge(k, p, rays->p[(j + 1) * w + i][half], down);
        }
    }
}

/* Light of each channel, of a step for a mm^2 before the lens: of the rays at
 * the band's middle, as much as the channel's own middle has. */
static void light_of_band(const struct item *it, const struct band *b,
                          double step, double light[3])
{
    double all = 0.0;
    for (int k = 0; k < GP_LENS_NODES; k++)
        all += b->of_node[k] * it->mesh.flux[k];
    for (int c = 0; c < 3; c++) {
        double own = 0.0;
        for (int k = 0; k < GP_LENS_NODES; k++)
            own += b->of_channel[c][k] * it->mesh.flux[k];
        light[c] = it->flux[c] * b->weight[c] * b->image[c] * it->mesh.scale *
                   (all > 0.0 && own > 0.0 ? own / all : 1.0) /
                   sqrt(1.0 + it->u * it->u) / (step * step);
    }
}

/* Draws all items of the chunk into the rows of one part of the frame. */
static gp_status draw_rows(void *ctx, int part, int thread)
{
    struct job *const job = ctx;
    struct rays *rays;
    const int last = (gp_rect_h(job->view->frame) - 1) / BAND_ROWS;
    gp_status st = gp_alloc(NULL, "rays", 1, sizeof *rays, &rays);
    (void) thread;
    for (int i = 0; i < job->items && !st; i++) {
        const struct item *const it = &job->item[i];
        if (it->level < 0)
            continue;
        const struct gp_lens_steps *const a = &job->level[it->level];
        // the first and the last part have the margin too
        const int top = part == 0 ? 0 : part * BAND_ROWS / a->step + 1;
        const int end = part == last ? a->h
                                     : (part + 1) * BAND_ROWS / a->step + 1;
        const double step = a->step;
        if (it->y1 / step + 1.0 < top || it->y0 / step + 1.0 > end)
            continue;
        const struct gp_lens_cover k = {
            .v = a->v + 3 * (size_t) top * (size_t) (a->w + 2), .w = a->w,
            .top = top, .y0 = top, .y1 = end,
        };
        const struct gp_lens_mesh *const m = &it->mesh;
        for (int e = 0; e < (m->cells + 1) * (m->cells / 2 + 1); e++)
            rays->clear[e] = gp_lens_is_clear(
                &it->blades, m->passes, &rays_of(m, GP_LENS_NODES / 2)[e]);
        for (int i_band = 0; i_band < bands_of_set[it->set]; i_band++) {
            const struct band *const b = &job->band[it->set][i_band];
            double light[3];
            light_of_band(it, b, step, light);
            make_rays(it, b, step, rays);
            draw_half(it, rays, 0, light, &k);
            draw_half(it, rays, 1, light, &k);
        }
    }
    gp_free(rays);
    return st;
}

static gp_status make_accumulators(struct job *job)
{
    gp_status st = GP_OK;
    for (int i = 0; i < job->items && !st; i++) {
        const int l = job->item[i].level;
        if (l >= 0 && !job->level[l].v)
            st = gp_lens_steps_make(job->log, gp_rect_w(job->view->frame),
                                    gp_rect_h(job->view->frame), 1 << l,
                                    &job->level[l]);
    }
    return st;
}

/* Traces and draws the items of a chunk, and adds up their figures. */
static gp_status run_chunk(struct job *job, struct gp_lens_stats *stats)
{
    const int parts = (gp_rect_h(job->view->frame) + BAND_ROWS - 1) / BAND_ROWS;
    gp_status st = gp_parallel(job->items, trace_item, job, NULL);
    if (!st)
        st = make_accumulators(job);
    if (!st)
        st = gp_parallel(parts, draw_rows, job, NULL);
    for (int i = 0; i < job->items; i++) {
        struct item *const it = &job->item[i];
        if (!st && it->mesh.cells) {
            const struct band *const b = &job->band[0][0];
            for (int c = 0; c < 3; c++) {
                double own = 0.0;
                for (int k = 0; k < GP_LENS_NODES; k++)
                    own += b->of_channel[c][k] * it->mesh.flux[k];
                stats->light[c] += it->flux[c] * own * b->image[c];
            }
            stats->lost += luminance(job->view, it->flux) * it->mesh.lost *
                           b->image[1];
            if (it->level >= 0)
                stats->steps[it->level]++;
        }
        gp_lens_mesh_free(&it->mesh);
    }
    return st;
}

gp_status gp_lens_draw(const struct gp_log *log, const struct gp_lens *lens,
    const struct gp_lens_view *view, const struct gp_lens_light *light, int n,
    struct gp_planes *layer, struct gp_lens_stats *out)
{
    struct job job = {.log = log, .lens = lens, .view = view, .light = light};
    struct gp_lens_stats stats = {.lights = n};
    struct gp_lens_ghost *ghost = NULL;
    struct gp_lens_optics *optics = NULL;
    struct gp_lens_figures figures;
    struct gp_lens_path straight;
    struct gp_lens_mesh mesh = {0};
    double all[3] = {0};
    int *kept = NULL;
    gp_status st;
    GP_TRY(gp_alloc(log, "ghosts", GP_LENS_GHOSTS, sizeof *ghost, &ghost));
    GP_TRY(gp_alloc(log, "ghosts", GP_LENS_GHOSTS, sizeof *kept, &kept));
    GP_TRY(gp_alloc(log, "lens", GP_LENS_NODES, sizeof *optics, &optics));
    GP_TRY(gp_alloc(log, "ghosts", CHUNK, sizeof *job.item, &job.item));
    for (int k = 0; k < GP_LENS_NODES; k++)
        gp_lens_optics_make(lens, node[k], &optics[k]);
    // the image on the axis: what the frame's light stands for
    const struct gp_lens_blades blades = gp_lens_blades_of(lens, 0.0);
    gp_lens_path(lens, -1, -1, &straight);
    GP_TRY(gp_lens_mesh_make(log, optics, &straight, &blades, 0.0, 1e-4,
                             0.0, &mesh));
    gp_lens_measure(lens, &figures);
    const struct gp_lens_matrix m = gp_lens_matrix(lens, &straight,
                                                   straight.steps, GP_D_LINE,
                                                   true);
    job.scale = m.b - m.a * figures.pupil_at;
    if (!mesh.cells || !(job.scale > 0.0 && job.scale < 1e9))
        GP_TRY(gp_fail(log, GP_ERR_DATA, "%s: no light reaches its image; "
                       "check it by glarepp lens --check", lens->name));
    make_bands(&job, mesh.flux);
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++)
            all[c] += light[i].flux[c];
    }
    stats.ghosts = gp_lens_ghosts(lens, GP_D_LINE, ghost);
    job.ghost = ghost;
    job.optics = optics;
    job.kept = kept;
    job.kept_n = choose(&job, ghost, stats.ghosts, all, mesh.flux[1], kept,
                        &stats);
    for (int i = 0; i < n * job.kept_n; i += job.items) {
        job.first = i;
        job.items = gp_min(n * job.kept_n - i, CHUNK);
        GP_TRY(run_chunk(&job, &stats));
    }
    GP_TRY(gp_lens_steps_add(job.level, gp_rect_w(view->frame),
                             gp_rect_h(view->frame), layer));
    const double light_sum = luminance(view, stats.light);
    stats.lost = stats.lost > 0.0 ? stats.lost / (stats.lost + light_sum) : 0.0;
    *out = stats;
out:
    gp_lens_mesh_free(&mesh);
    for (int l = 0; l < GP_LENS_LEVELS; l++)
        gp_free(job.level[l].v);
    gp_free(job.item);
    gp_free(optics);
    gp_free(kept);
    gp_free(ghost);
    return st;
}
