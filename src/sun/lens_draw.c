/* Chooses ghosts, traces their meshes light by light, and draws them. */
#include "sun/lens_draw.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "core/spectrum.h"
#include "sun/lens_priv.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum {
    FINE = 48,         // bands that sets of bands join
    SETS = 5,
    MOST_BANDS = 24,
    PAIRS = GP_LENS_NODES * (GP_LENS_NODES + 1) / 2,
    BAND_ROWS = 256,   // of pixels, drawn by one thread
    CHUNK = 128,       // ghosts of lights in memory at once
};

/* Wavelengths that the rays have: of blue, green and red. */
static const double node[GP_LENS_NODES] = {450.0, 545.0, 640.0};
static const int bands_of_set[SETS] = {1, 3, 6, 12, 24};

// -- bands --------------------------------------------------------------------

/* A part of the spectrum: how the nodes make its rays (Lagrange), and each
 * channel's light of a ray from the products of two nodes' roots of it, over
 * the light of the image on the axis. */
struct band {
    double of_node[GP_LENS_NODES];
    double light[3][PAIRS];
};

/* A light's ghost by one pair of surfaces. */
struct item {
    struct gp_lens_mesh mesh;
    struct gp_lens_blades blades;
    double flux[3], turn[2], u;
    double along[2], aside[2], middle[2]; // pixels of the layer: of a mm along
                                          // and across the light's axis, and
                                          // of the lens's axis
    double y0, y1;     // rows of the layer that it covers
    int level;
    // of each cell of both halves: 1 + its set of bands; 0: not in the frame
    uint8_t set[2][GP_LENS_CELLS * GP_LENS_CELLS / 2];
    bool has[SETS];
};

static inline double least(double a, double b)
{
    return a < b ? a : b;
}

static inline double most(double a, double b)
{
    return a > b ? a : b;
}

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

/* In 1 / nm: Cauchy's index, and with it the places of rays, go with its
 * square. */
static void lagrange(double nm, double out[GP_LENS_NODES])
{
    for (int k = 0; k < GP_LENS_NODES; k++) {
        out[k] = 1.0;
        for (int i = 0; i < GP_LENS_NODES; i++)
            out[k] *= i == k ? 1.0 : (1.0 / nm - 1.0 / node[i]) /
                                         (1.0 / node[k] - 1.0 / node[i]);
    }
}

/* No curve is followed below the least light that an eye sees. */
static double seen(double nm)
{
    return nm > 420.0 ? (nm < 680.0 ? nm : 680.0) : 420.0;
}

/* Sets each channel's light from that at the nodes. A coat's reflectance goes
 * with the square of the distance, in 1 / nm, to its own wavelength, and that
 * of two surfaces with the fourth power: it is the root that Lagrange's
 * polynomial follows. */
static inline void light_of(const struct band *b,
                            const double root[GP_LENS_NODES], double out[3])
{
    double pair[PAIRS];
    int n = 0;
    for (int i = 0; i < GP_LENS_NODES; i++) {
        for (int k = i; k < GP_LENS_NODES; k++)
            pair[n++] = root[i] * root[k];
    }
    for (int c = 0; c < 3; c++) {
        out[c] = 0.0;
        for (int i = 0; i < PAIRS; i++)
            out[c] += b->light[c][i] * pair[i];
        out[c] = most(out[c], 0.0);
    }
}

/* Adds a part of the spectrum of weights rgb and the image's light to a band. */
static void add_light(const double rgb[3], const double of_node[GP_LENS_NODES],
                      double image, struct band *b)
{
    int n = 0;
    for (int i = 0; i < GP_LENS_NODES; i++) {
        for (int k = i; k < GP_LENS_NODES; k++, n++) {
            const double both = of_node[i] * of_node[k] * (i == k ? 1.0 : 2.0);
            for (int c = 0; c < 3; c++)
                b->light[c][n] += rgb[c] * both / image;
        }
    }
}

static void make_bands(struct job *job, const double image[GP_LENS_NODES])
{
    double nm[FINE], rgb[FINE][3];
    gp_spectrum_weights(job->view->chromaticities, FINE, nm, rgb);
    for (int s = 0; s < SETS; s++) {
        const int each = FINE / bands_of_set[s];
        for (int b = 0; b < bands_of_set[s]; b++) {
            struct band *const out = &job->band[s][b];
            double sum = 0.0, middle = 0.0;
            *out = (struct band) {0};
            for (int i = b * each; i < (b + 1) * each; i++) {
                double at[GP_LENS_NODES], root = 0.0;
                lagrange(seen(nm[i]), at);
                for (int k = 0; k < GP_LENS_NODES; k++)
                    root += at[k] * sqrt(image[k]);
                add_light(rgb[i], at, root * root, out);
                for (int c = 0; c < 3; c++) {
                    sum += rgb[i][c];
                    middle += rgb[i][c] * nm[i];
                }
            }
            lagrange(seen(middle / sum), out->of_node);
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
        const double area = most(disc * ghost[i].m.a * ghost[i].m.a, pixel);
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

/* A box in pixels of the layer. */
struct box {
    double x0, y0, x1, y1;
};

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

/* Widens a box by a spot in one half of a mesh. */
static void widen(const struct item *it, const struct spot *s, int half,
                  struct box *b)
{
    for (int k = 0; k < GP_LENS_NODES; k++) {
        const double aside = half ? -s->y[k] : s->y[k];
        const double x = it->middle[0] + s->x[k] * it->along[0] +
                         aside * it->aside[0];
        const double y = it->middle[1] + s->x[k] * it->along[1] +
                         aside * it->aside[1];
        *b = (struct box) {least(b->x0, x), least(b->y0, y), most(b->x1, x),
                           most(b->y1, y)};
    }
}

/* Measures a cell: the box of its light in each half, and how far its colours
 * are apart, in pixels. Returns false where no light passes. */
static bool measure(const struct job *job, const struct item *it, int cell,
                    struct box box[2], double *apart)
{
    const struct gp_lens_mesh *const m = &it->mesh;
    const int w = m->cells + 1, last = GP_LENS_NODES - 1;
    const int first = cell / m->cells * w + cell % m->cells;
    const int at[4] = {first, first + 1, first + w + 1, first + w};
    const double pixel = least(job->view->mm[0], job->view->mm[1]);
    struct spot spot[8];
    const int n = spots_of(m, at, spot);
    *apart = 0.0;
    box[0] = box[1] = (struct box) {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (int e = 0; e < n; e++) {
        *apart = most(*apart, hypot(spot[e].x[last] - spot[e].x[0],
                                    spot[e].y[last] - spot[e].y[0]) / pixel);
        widen(it, &spot[e], 0, &box[0]);
        widen(it, &spot[e], 1, &box[1]);
    }
    return n > 0;
}

/* Finds the step of an item, the bands of each of its cells, and the rows of
 * those in the frame. */
static void place_item(const struct job *job, const struct gp_lens_ghost *g,
                       struct item *it)
{
    const struct gp_lens_mesh *const m = &it->mesh;
    const struct gp_lens_view *const v = job->view;
    const double w = gp_rect_w(v->frame), h = gp_rect_h(v->frame);
    const int cells = m->cells * (m->cells / 2);
    struct box all = {INFINITY, INFINITY, -INFINITY, -INFINITY}, box[2];
    double apart;
    for (int i = 0; i < cells; i++) {
        if (!measure(job, it, i, box, &apart))
            continue;
        for (int half = 0; half < 2; half++)
            all = (struct box) {
                least(all.x0, box[half].x0), least(all.y0, box[half].y0),
                most(all.x1, box[half].x1), most(all.y1, box[half].y1)};
    }
    // a step must not hide the size
    const double size = most(all.x1 - all.x0, all.y1 - all.y0);
    const double finest = least((v->fine ? 0.35 : 0.7) * g->blur /
                                   least(v->mm[0], v->mm[1]), size / 24.0);
    int level = 0;
    while (level + 1 < GP_LENS_LEVELS && 2 << level <= finest)
        level++;
    const double allowed = (v->fine ? 1.5 : 3.0) * (1 << level);
    it->y0 = INFINITY;
    it->y1 = -INFINITY;
    for (int i = 0; i < cells; i++) {
        int set = 0;
        if (!measure(job, it, i, box, &apart))
            continue;
        while (set + 1 < SETS && apart > allowed * bands_of_set[set])
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
            it->set[half][i] = (uint8_t) (1 + set);
            it->has[set] = true;
            it->y0 = least(it->y0, b.y0);
            it->y1 = most(it->y1, b.y1);
        }
    }
    it->level = it->y0 < it->y1 ? level : -1;
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
                                           v->fine ? least(v->tolerance, 5e-4)
                                                   : v->tolerance,
                                           (v->fine ? 0.25 : 1.0) *
                                               most(g->blur, v->mm[0]),
                                           &it->mesh);
    if (!st && it->mesh.cells)
        place_item(job, g, it);
    return st;
}

// -- drawing ------------------------------------------------------------------

/* A band's rays of an item, in steps of its accumulator. */
struct rays {
    double p[(GP_LENS_CELLS + 1) * (GP_LENS_CELLS / 2 + 1)][2][2]; // halves
    double light[(GP_LENS_CELLS + 1) * (GP_LENS_CELLS / 2 + 1)][3];
    bool arrives[(GP_LENS_CELLS + 1) * (GP_LENS_CELLS / 2 + 1)];
    bool clear[(GP_LENS_CELLS + 1) * (GP_LENS_CELLS / 2 + 1)];
    double density[GP_LENS_CELLS * GP_LENS_CELLS / 2][3];
};

/* `scale` is of a ray's light to light a step for a mm^2 before the lens. */
static void make_rays(const struct item *it, const struct band *b, double step,
                      const double scale[3], struct rays *out)
{
    const int n = (it->mesh.cells + 1) * (it->mesh.cells / 2 + 1);
    const double per = 1.0 / step;
    for (int i = 0; i < n; i++) {
        double x = 0.0, y = 0.0, root[GP_LENS_NODES];
        out->arrives[i] = true;
        for (int k = 0; k < GP_LENS_NODES; k++) {
            const struct gp_lens_hit *const h = &it->mesh.hit[k * n + i];
            x += b->of_node[k] * h->x;
            y += b->of_node[k] * h->y;
            root[k] = sqrt(most((double) h->through, 0.0));
            out->arrives[i] = out->arrives[i] && h->through >= 0.0f;
        }
        light_of(b, root, out->light[i]);
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
 * the lens: `light` is the cell's mean, whose sum the corners' `through` is. */
static void add_cell(const struct gp_lens_cover *k, const struct item *it,
                     struct gp_lens_corner c[GP_LENS_CORNERS],
                     const double light[3])
{
    const int n = gp_lens_cut(&it->blades, it->mesh.passes, c);
    const double all = light[0] + light[1] + light[2];
    double area = 0.0, through = 0.0, own[3];
    for (int i = 0; i < n; i++) {
        const struct gp_lens_corner *const b = &c[i + 1 < n ? i + 1 : 0];
        area += 0.5 * (c[i].p * b->q - b->p * c[i].q);
        through += c[i].through / n;
    }
    for (int i = 0; i < 3; i++)
        own[i] = fabs(area) * through * light[i] / all;
    if (n && all > 0.0)
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

/* Adds the edge of two cells with the difference of their light; either may be
 * NULL, dark. */
static void add_between(const struct gp_lens_cover *k, const double a[2],
                        const double b[2], const double *right,
                        const double *left)
{
    static const double dark[3];
    double light[3];
    right = right ? right : dark;
    left = left ? left : dark;
    for (int c = 0; c < 3; c++)
        light[c] = right[c] - left[c];
    if (light[0] != 0.0 || light[1] != 0.0 || light[2] != 0.0)
        gp_lens_cover_edge(k, a, b, light);
}

/* Draws the cells of one set in one half of a band: whole cells by the edges
 * that they share, with the difference of their light, others by themselves. */
static void draw_half(const struct item *it, struct rays *rays, int half,
                      int set, const struct gp_lens_cover *k)
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
            double *const density = rays->density[j * cells + i];
            const double *p[4];
            bool arrives = true, passes = false, clear = true;
            double low = INFINITY, high = -INFINITY, light[3] = {0};
            double left = INFINITY, right = -INFINITY;
            density[0] = density[1] = density[2] = 0.0;
            if (it->set[half][j * cells + i] != 1 + set)
                continue;
            for (int e = 0; e < 4; e++) {
                p[e] = rays->p[at[e]][half];
                arrives = arrives && rays->arrives[at[e]];
                passes = passes || hit[at[e]].rim < 1.0f;
                clear = clear && rays->clear[at[e]];
                low = least(low, p[e][1]);
                high = most(high, p[e][1]);
                left = least(left, p[e][0]);
                right = most(right, p[e][0]);
                for (int c = 0; c < 3; c++)
                    light[c] += 0.25 * rays->light[at[e]][c];
            }
            if (!arrives || !passes || !(high > k->y0 && low < k->y1) ||
                !(right > 0.0 && left < k->w))
                continue;
            const double share = clear ? density_of(p) : 0.0;
            for (int c = 0; c < 3; c++)
                density[c] = light[c] * share * dx * dy;
            if (share != 0.0)
                continue;
            struct gp_lens_corner c[GP_LENS_CORNERS];
            for (int e = 0; e < 4; e++) {
                const struct gp_lens_hit *const h = &hit[at[e]];
                const double *const own = rays->light[at[e]];
                c[e] = (struct gp_lens_corner) {
                    .p = m->x0 + dx * (i + (e == 1 || e == 2)),
                    .q = sign * dy * (j + (e >= 2)), .x = p[e][0],
                    .y = p[e][1], .through = own[0] + own[1] + own[2],
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
            const double (*const d)[3] = &rays->density[j * cells + i];
            const double *const here = j < rows && i < cells ? d[0] : NULL;
            const double *const left = j < rows && i > 0 ? d[-1] : NULL;
            const double *const above = j > 0 && i < cells ? d[-cells] : NULL;
            const double *const p = rays->p[j * w + i][half];
            if (here || above)
                add_between(k, p, rays->p[j * w + i + 1][half], here, above);
            if (here || left)
                add_between(k, p, rays->p[(j + 1) * w + i][half], left, here);
        }
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
        double scale[3];
        for (int c = 0; c < 3; c++)
            scale[c] = it->flux[c] * m->scale /
                       (sqrt(1.0 + it->u * it->u) * step * step);
        for (int set = 0; set < SETS; set++) {
            const int bands = it->has[set] ? bands_of_set[set] : 0;
            for (int b = 0; b < bands; b++) {
                make_rays(it, &job->band[set][b], step, scale, rays);
                draw_half(it, rays, 0, set, &k);
                draw_half(it, rays, 1, set, &k);
            }
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
            double own[3], root[GP_LENS_NODES], arrives = 0.0;
            for (int k = 0; k < GP_LENS_NODES; k++) {
                root[k] = sqrt(it->mesh.flux[k]);
                arrives += it->mesh.flux[k] / GP_LENS_NODES;
            }
            light_of(&job->band[0][0], root, own);
            for (int c = 0; c < 3; c++)
                stats->light[c] += own[c] *= it->flux[c];
            stats->lost += arrives > 0.0 ? luminance(job->view, own) *
                                               it->mesh.lost / arrives : 0.0;
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
