// SPDX-License-Identifier: Apache-2.0
/* Cells of a ghost's mesh: which are in the frame, with how many parts of the
 * spectrum, and their light in the steps of an accumulator. */
#include "sun/lens_priv.h"

#include "core/colour.h"
#include "core/cpu.h"
#include "core/luminance.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <string.h>

// -- the spectrum -------------------------------------------------------------

const double gp_lens_node[GP_LENS_NODES] = {420.0, 545.0, 640.0};
static const int bands_of_set[GP_LENS_SETS] = {1, 3, 6, 12, 24, 48, 96};

/* In 1 / nm: Cauchy's index, and with it the places of rays, go with its
 * square. */
static void lagrange(double nm, double out[GP_LENS_NODES])
{
    for (int k = 0; k < GP_LENS_NODES; k++) {
        out[k] = 1.0;
        for (int i = 0; i < GP_LENS_NODES; i++) {
            const double other = 1.0 / gp_lens_node[i];
            out[k] *= i == k ? 1.0 : (1.0 / nm - other) /
                                         (1.0 / gp_lens_node[k] - other);
        }
    }
}

void gp_lens_spectrum_make(const float *chromaticities,
                           const struct gp_lens *lens,
                           const double image[GP_LENS_NODES],
                           struct gp_lens_spectrum *out)
{
    double rgb[GP_LENS_PARTS][3];
    struct gp_lens_path straight;
    struct gp_lens_pair pair;
    gp_spectrum_colours(chromaticities, GP_LENS_PARTS, out->nm, rgb);
    for (int k = 0; k < lens->n * (GP_LENS_COSINES + 1); k++) {
        const int surface = k / (GP_LENS_COSINES + 1);
        const int step = k % (GP_LENS_COSINES + 1);
        const double root = step / (double) GP_LENS_COSINES;
        for (int i = 0; i < GP_LENS_PARTS; i++)
            out->reflected[surface][step][i] = (float) gp_lens_reflected(
                lens, surface, 1.0 - root * root, out->nm[i]);
    }
    for (int i = 0; i < GP_LENS_PARTS; i++) {
        double at[GP_LENS_NODES];
        lagrange(out->nm[i], at);
        for (int k = 0; k < GP_LENS_NODES; k++)
            out->at[k][i] = at[k];
    }
    gp_lens_path(lens, -1, -1, &straight);
    gp_lens_pair_make(out, lens, &straight, &pair);
    for (int i = 0; i < GP_LENS_PARTS; i++) {
        double root = 0.0;
        for (int k = 0; k < GP_LENS_NODES; k++)
            root += out->at[k][i] * sqrt(image[k]);
        for (int c = 0; c < 3; c++)
            out->rgb[c][i] = rgb[i][c] / (root * root * pair.over[i]);
    }
}

void gp_lens_pair_make(const struct gp_lens_spectrum *s,
                       const struct gp_lens *lens,
                       const struct gp_lens_path *path,
                       struct gp_lens_pair *out)
{
    *out = (struct gp_lens_pair) {.axis = {1.0, 1.0, 1.0}};
    for (int i = 0; i < GP_LENS_PARTS; i++)
        out->over[i] = 1.0;
    for (int j = 0, turns = 0; j < path->steps; j++) {
        const int surface = path->step[j].surface;
        const float *const reflected = s->reflected[surface][0];
        if (path->step[j].reflects) {
            out->by[turns++] = s->reflected[surface];
            continue;
        }
        for (int k = 0; k < GP_LENS_NODES; k++)
            out->axis[k] *=
                1.0 - gp_lens_reflected(lens, surface, 1.0, gp_lens_node[k]);
        for (int i = 0; i < GP_LENS_PARTS; i++)
            out->over[i] *= 1.0 - (double) reflected[i];
    }
    for (int i = 0; i < GP_LENS_PARTS; i++) {
        double root = 0.0;
        for (int k = 0; k < GP_LENS_NODES; k++)
            root += s->at[k][i] * sqrt(out->axis[k]);
        out->over[i] = root > 0.0 ? out->over[i] / (root * root) : 0.0;
    }
}

/* The light of parts of one angle at each reflection. */
static inline void add_parts(const struct gp_lens_spectrum *s,
                             const struct gp_lens_pair *pair, int from, int to,
                             const double root[GP_LENS_NODES],
                             const double cosine[2], double sum[3])
{
    double light[GP_LENS_SAME] = {0};
    const float *row[2][2];
    float t[2];
    for (int k = 0; k < 2; k++) {
        const double at =
            GP_LENS_COSINES * sqrt(1.0 - gp_mind(gp_maxd(cosine[k], 0.0), 1.0));
        row[k][0] = pair->by[k][(int) at];
        row[k][1] = pair->by[k][(int) at + 1];
        t[k] = (float) (at - (int) at);
    }
    for (int i = from; i < to; i++) {
        const double r = s->at[0][i] * root[0] + s->at[1][i] * root[1] +
                         s->at[2][i] * root[2];
        const float a = row[0][0][i] + t[0] * (row[0][1][i] - row[0][0][i]);
        const float b = row[1][0][i] + t[1] * (row[1][1][i] - row[1][0][i]);
        light[i - from] = r * r * pair->over[i] * (double) (a * b);
    }
    for (int i = from; i < to; i++) {
        for (int c = 0; c < 3; c++)
            sum[c] += s->rgb[c][i] * light[i - from];
    }
}

/* The nodes know where a ray goes and what it loses on its way; how much the two surfaces
 * reflect turns too fast with the wavelength for them, and is known in each part. */
GP_CLONES void gp_lens_light_of(const struct gp_lens_spectrum *s,
                                const struct gp_lens_pair *pair,
                                const struct gp_lens_band *band,
                                const double root[GP_LENS_NODES],
                                const double cosine[2][GP_LENS_NODES],
                                double out[3])
{
    double sum[3] = {0};
    for (int i = band->from; i < band->to; i += GP_LENS_SAME) {
        const int to = gp_min(i + GP_LENS_SAME, band->to),
                  middle = (i + to) / 2;
        double own[2] = {0};
        for (int k = 0; k < 2 * GP_LENS_NODES; k++)
            own[k % 2] += s->at[k / 2][middle] * cosine[k % 2][k / 2];
        add_parts(s, pair, i, to, root, own, sum);
    }
    memcpy(out, sum, sizeof sum);
}

/* Makes a band: its light is at the place of its middle. */
static struct gp_lens_band band_of(const struct gp_lens_spectrum *s, int from,
                                   int parts)
{
    struct gp_lens_band out = {.from = from, .to = from + parts};
    double sum = 0.0, middle = 0.0;
    for (int i = from; i < out.to; i++) {
        for (int c = 0; c < 3; c++) {
            sum += fabs(s->rgb[c][i]);
            middle += fabs(s->rgb[c][i]) * s->nm[i];
        }
    }
    // places, of Cauchy's index, are followed further: all violet at the place
    // of one wavelength would be a ring
    lagrange(fmin(fmax(middle / sum, 390.0), 720.0), out.of_node);
    return out;
}

// -- places -------------------------------------------------------------------

/* Rays of a mesh at node k. */
static const struct gp_lens_hit *rays_of(const struct gp_lens_mesh *m, int k)
{
    return m->hit + (size_t) k * (size_t) (m->cells + 1) *
                        (size_t) (m->cells / 2 + 1);
}

/* A box in pixels of the layer. */
struct box {
    double x0, y0, x1, y1;
};
static const struct box no_box = {INFINITY, INFINITY, -INFINITY, -INFINITY};

/* Widens a box by another. */
static void join(struct box *b, struct box by)
{
    *b = (struct box) {gp_mind(b->x0, by.x0), gp_mind(b->y0, by.y0),
                       gp_maxd(b->x1, by.x1), gp_maxd(b->y1, by.y1)};
}

/* The places on the sensor, in mm, of a ray in each wavelength. */
struct spot {
    double x[GP_LENS_NODES], y[GP_LENS_NODES];
};

/* Returns the spot at t from ray a to ray b of a mesh. */
static struct spot spot_between(const struct gp_lens_mesh *m, int a, int b,
                                double t)
{
    struct spot s;
    for (int k = 0; k < GP_LENS_NODES; k++) {
        const struct gp_lens_hit *const p = &rays_of(m, k)[a];
        const struct gp_lens_hit *const q = &rays_of(m, k)[b];
        s.x[k] = p->x + t * (q->x - p->x);
        s.y[k] = p->y + t * (q->y - p->y);
    }
    return s;
}

/* Lists the corners of the part of a cell that the rims let through; returns
 * how many, 0 where a ray does not arrive. */
static int spots_of(const struct gp_lens_mesh *m, const int at[4],
                    struct spot out[8])
{
    const struct gp_lens_hit *const middle = rays_of(m, GP_LENS_NODES / 2);
    int n = 0;
    for (int k = 0; k < GP_LENS_NODES; k++) {
        for (int e = 0; e < 4; e++) {
            if (rays_of(m, k)[at[e]].through < 0.0f)
                return 0;
        }
    }
    for (int e = 0; e < 4; e++) {
        const int next = at[(e + 1) % 4];
        const double a = (double) middle[at[e]].rim - 1.0;
        const double b = (double) middle[next].rim - 1.0;
        if (a <= 0.0)
            out[n++] = spot_between(m, at[e], at[e], 0.0);
        if ((a <= 0.0) != (b <= 0.0))
            out[n++] = spot_between(m, at[e], next, a / (a - b));
    }
    return n;
}

/* Widens the boxes of both halves of a mesh by a spot. */
static void widen(const struct gp_lens_item *it, const struct spot *s,
                  struct box box[2])
{
    for (int k = 0; k < 2 * GP_LENS_NODES; k++) {
        const double along = s->x[k / 2];
        const double aside = k % 2 ? -s->y[k / 2] : s->y[k / 2];
        const double x =
            it->middle[0] + along * it->along[0] + aside * it->aside[0];
        const double y =
            it->middle[1] + along * it->along[1] + aside * it->aside[1];
        join(&box[k % 2], (struct box) {x, y, x, y});
    }
}

/* Measures a cell: the box of its light in each half, and how far its colours
 * are apart, in pixels. Returns false where no light passes. */
static bool measure(const struct gp_lens_view *v,
                    const struct gp_lens_item *it, int cell,
                    struct box box[2], double *apart)
{
    const struct gp_lens_mesh *const m = &it->mesh;
    const int w = m->cells + 1, last = GP_LENS_NODES - 1;
    const int first = cell / m->cells * w + cell % m->cells;
    const int at[4] = {first, first + 1, first + w + 1, first + w};
    const double pixel = gp_mind(v->mm[0], v->mm[1]);
    struct spot spot[8];
    const int n = spots_of(m, at, spot);
    *apart = 0.0;
    box[0] = box[1] = no_box;
    for (int e = 0; e < n; e++) {
        *apart = gp_maxd(*apart, gp_hypot(spot[e].x[last] - spot[e].x[0],
                                          spot[e].y[last] - spot[e].y[0]) /
                                     pixel);
        widen(it, &spot[e], box);
    }
    return n > 0;
}

void gp_lens_item_place(const struct gp_lens_view *v, double blur,
                        double ease, struct gp_lens_item *it)
{
    const struct gp_lens_mesh *const m = &it->mesh;
    const double w = gp_rect_w(v->frame), h = gp_rect_h(v->frame);
    const int cells = m->cells * (m->cells / 2);
    struct box all = no_box, box[2];
    double apart;
    for (int i = 0; i < cells; i++) {
        (void) measure(v, it, i, box, &apart); // no box: no light
        join(&all, box[0]);
        join(&all, box[1]);
    }
    const double finer = 1 << v->detail;
    // a step must not hide the size
    const double size = gp_maxd(all.x1 - all.x0, all.y1 - all.y0);
    const double finest = gp_mind(0.7 / finer * blur /
                                   gp_mind(v->mm[0], v->mm[1]), size / 24.0);
    int level = 0;
    while (level + 1 < GP_LENS_LEVELS && 2 << level <= finest)
        level++;
    // bands of equal width in nm are three times as far apart in the blue
    const double allowed = (v->detail ? 0.65 : 3.9 * ease) * (1 << level);
    const int sets = v->detail ? GP_LENS_SETS : GP_LENS_SETS_COARSE;
    for (int i = 0; i < cells; i++) {
        int set = 0;
        if (!measure(v, it, i, box, &apart))
            continue;
        while (set + 1 < sets && apart > allowed * bands_of_set[set])
            set++;
        for (int half = 0; half < 2; half++) {
            // bands reach beyond the nodes
            const struct box b = {
                box[half].x0 - apart - 2.0, box[half].y0 - apart - 2.0,
                box[half].x1 + apart + 2.0, box[half].y1 + apart + 2.0};
            // and steps as far beyond the frame
            const double margin = 2 << level;
            if (!(b.x1 > -margin && b.x0 < w + margin && b.y1 > -margin &&
                  b.y0 < h + margin))
                continue;
            it->cell[half][i] = (struct gp_lens_cell) {
                (float) b.y0, (float) b.y1, (uint8_t) (1 + set)};
            it->level = level;
        }
    }
}

// -- drawing ------------------------------------------------------------------

/* Finds the cells that meet rows [y0, y1) of the layer, and their rays; returns
 * the bits of their sets. */
static unsigned find_cells(const struct gp_lens_item *it, double y0, double y1,
                           struct gp_lens_rays *out)
{
    const int cells = it->mesh.cells, w = cells + 1;
    unsigned all = 0;
    memset(out->needs, 0, sizeof out->needs);
    for (int half = 0; half < 2; half++) {
        for (int i = 0; i < cells * (cells / 2); i++) {
            const struct gp_lens_cell *const c = &it->cell[half][i];
            uint8_t *const ray = &out->needs[i / cells * w + i % cells];
            const bool meets = c->set && (double) c->y1 > y0 &&
                               (double) c->y0 < y1;
            const uint8_t bit = (uint8_t) (meets ? 1u << (c->set - 1) : 0u);
            out->set[half][i] = meets ? c->set : 0;
            ray[0] |= bit;
            ray[1] |= bit;
            ray[w] |= bit;
            ray[w + 1] |= bit;
            all |= bit;
        }
    }
    return all;
}

/* The light of a ray of a mesh in a band; false where it does not arrive at all
 * nodes: it has the light of the others. */
static bool shine(const struct gp_lens_item *it, int ray,
                  const struct gp_lens_spectrum *s,
                  const struct gp_lens_band *b, double light[3])
{
    const struct gp_lens_hit *const middle =
        &rays_of(&it->mesh, GP_LENS_NODES / 2)[ray];
    double root[GP_LENS_NODES], cosine[2][GP_LENS_NODES];
    bool all = true;
    for (int k = 0; k < GP_LENS_NODES; k++) {
        const struct gp_lens_hit *const h = &rays_of(&it->mesh, k)[ray];
        const bool arrives = h->through >= 0.0f;
        all = all && arrives;
        root[k] = arrives ? it->mesh.root[k] * sqrt((double) h->passed) : 0.0;
        for (int e = 0; e < 2; e++)
            cosine[e][k] = (double) (arrives ? h : middle)->cosine[e];
    }
    gp_lens_light_of(s, it->pair, b, root, cosine, light);
    return all;
}

void gp_lens_item_light(struct gp_lens_item *it,
                        const struct gp_lens_spectrum *s,
                        const float luminance[3])
{
    struct gp_lens_mesh *const m = &it->mesh;
    const struct gp_lens_hit *const middle = rays_of(m, GP_LENS_NODES / 2);
    const struct gp_lens_band all = band_of(s, 0, GP_LENS_PARTS);
    double sum[2][3] = {{0}}, own[3];
    for (int i = 0; i < (m->cells + 1) * (m->cells / 2 + 1); i++) {
        const float *const weight = middle[i].weight;
        if (!(weight[1] > 0.0f))
            continue;
        shine(it, i, s, &all, own);
        for (int k = 0; k < 6; k++)
            sum[k / 3][k % 3] += (double) weight[k / 3] * own[k % 3];
    }
    const double cells = gp_luminance_of(luminance, sum[0]);
    const double light = gp_luminance_of(luminance, sum[1]);
    for (int c = 0; c < 3; c++)
        it->light[c] = sum[1][c] * m->scale / sqrt(1.0 + it->u * it->u);
    m->scale *= cells > 0.0 ? fmin(light / cells, 1.25) : 1.0;
}

/* `scale` is of a ray's light to light a step for a mm^2 before the lens. */
static void make_rays(const struct gp_lens_item *it, int set,
                      const struct gp_lens_spectrum *s,
                      const struct gp_lens_band *b, double step,
                      const double scale[3], struct gp_lens_rays *out)
{
    const int n = (it->mesh.cells + 1) * (it->mesh.cells / 2 + 1);
    const double per = 1.0 / step;
    for (int i = 0; i < n; i++) {
        double x = 0.0, y = 0.0;
        if (!(out->needs[i] & 1u << set))
            continue;
        out->arrives[i] = shine(it, i, s, b, out->light[i]);
        for (int k = 0; k < GP_LENS_NODES; k++) {
            const struct gp_lens_hit *const h = &it->mesh.hit[k * n + i];
            x += b->of_node[k] * h->x;
            y += b->of_node[k] * h->y;
        }
        for (int c = 0; c < 3; c++)
            out->light[i][c] *= scale[c];
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
                      const union gp_lens_corner *c, const double light[3])
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

/* Adds the part of a cell that rims and blades leave; `light` of the ray at each
 * corner is a mm^2 before the lens. */
static void add_cell(const struct gp_lens_cover *k,
                     const struct gp_lens_item *it,
                     union gp_lens_corner c[GP_LENS_CORNERS],
                     const double *const light[4])
{
    const union gp_lens_corner from = c[0], to = c[2];
    const int n = gp_lens_cut(&it->blades, it->mesh.passes, c);
    double share[4], own[3] = {0};
    const double area = gp_lens_piece(c, n, &from, &to, share);
    for (int i = 0; i < 12; i++)
        own[i % 3] += area * share[i / 3] * light[i / 3][i % 3];
    if (n)
        add_piece(k, n, c, own);
}

/* Returns the signed share of light a step of a whole cell; 0 for one that
 * folds, or of no area, which is drawn by itself. */
static double density_of(const double (*p[4]))
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
    return (left && right) || !(fabs(area) > 1e-9) ? 0.0 : -1.0 / area;
}

/* Adds the edge of two cells with the difference of their light. */
static void add_between(const struct gp_lens_cover *k, const double a[2],
                        const double b[2], const double right[3],
                        const double left[3])
{
    const double light[3] = {right[0] - left[0], right[1] - left[1],
                             right[2] - left[2]};
    if (light[0] != 0.0 || light[1] != 0.0 || light[2] != 0.0)
        gp_lens_cover_edge(k, a, b, light);
}

/* Draws the cells of one set in one half of a band: whole cells by the edges
 * that they share, with the difference of their light, others by themselves. */
static void draw_half(const struct gp_lens_item *it, struct gp_lens_rays *rays,
                      int half, int set, const struct gp_lens_cover *k)
{
    const struct gp_lens_mesh *const m = &it->mesh;
    const struct gp_lens_hit *const hit = rays_of(m, GP_LENS_NODES / 2);
    const int w = m->cells + 1, cells = m->cells, rows = m->cells / 2;
    const double dx = (m->x1 - m->x0) / cells, dy = m->y1 / rows;
    const double sign = half ? -1.0 : 1.0;
    double (*const density)[3] = rays->density + cells + 3;
    const int down = cells + 2; // to the next row of densities
    memset(rays->density, 0, (size_t) (down * (rows + 2)) * sizeof *density);
    for (int j = 0; j < rows; j++) {
        for (int i = 0; i < cells; i++) {
            const int at[4] = {j * w + i, j * w + i + 1, (j + 1) * w + i + 1,
                               (j + 1) * w + i};
            const double *p[4];
            bool arrives = true, passes = false, clear = true;
            double light[3] = {0};
            if (rays->set[half][j * cells + i] != 1 + set)
                continue;
            for (int e = 0; e < 4; e++) {
                p[e] = rays->p[at[e]][half];
                arrives = arrives && rays->arrives[at[e]];
                passes = passes || hit[at[e]].rim < 1.0f;
                clear = clear && rays->clear[at[e]];
                for (int c = 0; c < 3; c++)
                    light[c] += 0.25 * rays->light[at[e]][c];
            }
            if (!arrives || !passes)
                continue;
            const double share = clear ? density_of(p) : 0.0;
            for (int c = 0; c < 3; c++)
                density[j * down + i][c] = light[c] * share * dx * dy;
            if (share != 0.0)
                continue;
            union gp_lens_corner c[GP_LENS_CORNERS];
            const double *corner[4];
            for (int e = 0; e < 4; e++) {
                c[e] = gp_lens_corner_of(
                    &hit[at[e]], m->x0 + dx * (i + (e == 1 || e == 2)),
                    dy * (j + (e >= 2)), sign);
                c[e].x = p[e][0];
                c[e].y = p[e][1];
                corner[e] = rays->light[at[e]];
            }
            add_cell(k, it, c, corner);
        }
    }
    for (int j = 0; j <= rows; j++) {
        for (int i = 0; i <= cells; i++) {
            double (*const here)[3] = density + j * down + i;
            const double *const p = rays->p[j * w + i][half];
            if (i < cells)
                add_between(k, p, rays->p[j * w + i + 1][half], here[0],
                            here[-down]);
            if (j < rows)
                add_between(k, p, rays->p[(j + 1) * w + i][half], here[-1],
                            here[0]);
        }
    }
}

void gp_lens_item_draw(const struct gp_lens_item *it,
                       const struct gp_lens_spectrum *spectrum,
                       const struct gp_lens_steps *steps, int top, int end,
                       struct gp_lens_rays *rays)
{
    const struct gp_lens_mesh *const m = &it->mesh;
    const double step = steps->step;
    const struct gp_lens_cover k = {
        .v = steps->v + 3 * (size_t) top * (size_t) (steps->w + 2),
        .w = steps->w,
        .y0 = top,
        .y1 = end,
    };
    double scale[3];
    for (int i = 0; i < (m->cells + 1) * (m->cells / 2 + 1); i++)
        rays->clear[i] = gp_lens_is_clear(&it->blades, m->passes,
                                          &rays_of(m, GP_LENS_NODES / 2)[i]);
    for (int c = 0; c < 3; c++)
        scale[c] = it->flux[c] * m->scale /
                   (sqrt(1.0 + it->u * it->u) * step * step);
    // the accumulator begins a step before the frame
    const unsigned sets = find_cells(it, (top - 1.0) * step,
                                     (end - 1.0) * step, rays);
    for (int set = 0; set < GP_LENS_SETS; set++) {
        const int parts = GP_LENS_PARTS / bands_of_set[set];
        for (int i = 0; sets >> set & 1 && i < GP_LENS_PARTS; i += parts) {
            const struct gp_lens_band band = band_of(spectrum, i, parts);
            make_rays(it, set, spectrum, &band, step, scale, rays);
            draw_half(it, rays, 0, set, &k);
            draw_half(it, rays, 1, set, &k);
        }
    }
}
