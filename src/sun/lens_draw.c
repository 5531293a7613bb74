// SPDX-License-Identifier: Apache-2.0
/* Chooses ghosts, traces their meshes light by light, and draws them; and draws a
 * lens in section. */
#include "sun/lens.h"

#include "core/colour.h"
#include "core/luminance.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "sun/lens_priv.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// -- lights of a frame --------------------------------------------------------

/* Groups of sources: blocks of the frame, of which the brightest are lights. */
enum { BLOCK = 16, GROUPS = 100 };

struct group {
    struct gp_lens_light light; // place: sum of places by luminance
    double luminance;
    int index;
};

static int by_light(const void *a, const void *b)
{
    const struct group *const x = a, *const y = b;
    return x->luminance != y->luminance ? (x->luminance > y->luminance ? -1 : 1)
                                        : x->index - y->index;
}

/* Makes lights of the brightest blocks of sources. */
static gp_status group_sources(const struct gp_log *log,
    const struct gp_sources *s, struct gp_lens_light *out, int *n, double *rest,
    double dark[3])
{
    const int across = (s->w + BLOCK - 1) / BLOCK;
    const int down = (s->h + BLOCK - 1) / BLOCK;
    struct group *group;
    double all = 0.0, taken = 0.0;
    const gp_status st = gp_alloc_zero(log, "groups of sources",
        (size_t) across * (size_t) down, sizeof *group, &group);
    if (st)
        return st;
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            const int at = y / BLOCK * across + s->x[i] / BLOCK;
            struct group *const g = &group[at];
            const double rgb[3] = {(double) s->rgb[0][i],
                                   (double) s->rgb[1][i],
                                   (double) s->rgb[2][i]};
            const double light = gp_luminance_of(s->luminance, rgb);
            for (int c = 0; c < 3; c++)
                g->light.flux[c] += rgb[c];
            g->light.x += light * (s->x0 + s->x[i] + 0.5);
            g->light.y += light * (s->y0 + y + 0.5);
            g->luminance += light;
            g->index = at;
            all += light;
        }
    }
    qsort(group, (size_t) across * (size_t) down, sizeof *group, by_light);
    *n = 0;
    for (int i = 0; i < across * down; i++) {
        if (!(group[i].luminance > 0.0))
            break;
        if (*n == GROUPS) {
            for (int c = 0; c < 3; c++)
                dark[c] += group[i].light.flux[c];
            continue;
        }
        out[*n] = group[i].light;
        out[*n].x /= group[i].luminance;
        out[*n].y /= group[i].luminance;
        taken += group[i].luminance;
        ++*n;
    }
    *rest = all > 0.0 ? fmax(1.0 - taken / all, 0.0) : 0.0;
    gp_free(group);
    return GP_OK;
}

gp_status gp_lens_lights(const struct gp_log *log,
    const struct gp_light *light, int lights, const struct gp_sources *src,
    struct gp_lens_light **out, int *n, double *rest, double dark[3])
{
    struct gp_lens_light *list;
    const gp_status st = gp_alloc_zero(
        log, "lights", (size_t) gp_max(lights, GROUPS), sizeof *list, &list);
    *n = 0;
    *out = st ? NULL : list;
    *rest = 0.0;
    if (st)
        return st;
    for (int i = 0; i < lights; i++) {
        const struct gp_light *const l = &light[i];
        if (!gp_light_has_flux(l) || !(l->visibility > 0.0))
            continue;
        list[*n] = (struct gp_lens_light) {.x = l->x, .y = l->y};
        for (int c = 0; c < 3; c++)
            list[*n].flux[c] = l->visibility * (double) l->flux[c];
        ++*n;
    }
    return lights == 0 && src->n
               ? group_sources(log, src, list, n, rest, dark) : GP_OK;
}

// -- ghosts -------------------------------------------------------------------

enum {
    STRIP_ROWS = 256, // of pixels, drawn by one thread
    CHUNK = 64,      // ghosts of lights in memory at once
};

/* A ghost by first order: a disc of even light. */
struct rank {
    double bright;   // luminance at a pixel that all lights together may make
    double share[3]; // of a light's flux, by channel
    double pixels;   // that it covers
    double norm;     // over the frame's pixels, for a share of 1
    int ghost;
};

struct drawing {
    const struct gp_lens *lens;
    const struct gp_lens_view *view;
    const struct gp_lens_light *light;
    struct glarepp_ghost ghost[GP_LENS_GHOSTS];
    double blur[GP_LENS_GHOSTS];
    struct gp_lens_optics optics[GP_LENS_NODES];
    struct rank rank[GP_LENS_GHOSTS], *kept; // kept: those that are drawn
    int kept_n, first; // of the chunk: light * kept_n + ghost
    double scale;      // mm on the sensor for a slope of 1
    struct gp_lens_spectrum spectrum;
    struct gp_lens_pair pair[GP_LENS_GHOSTS];
    struct gp_lens_steps level[GP_LENS_LEVELS];
    struct gp_lens_item item[CHUNK];
    int items;
    struct gp_planes *layer;
};

// -- choice -------------------------------------------------------------------

static int by_brightness(const void *a, const void *b)
{
    const struct rank *const x = a, *const y = b;
    return x->bright != y->bright ? (x->bright < y->bright ? -1 : 1)
                                  : x->ghost - y->ghost;
}

static int by_ghost(const void *a, const void *b)
{
    const struct rank *const x = a, *const y = b;
    return x->ghost - y->ghost;
}

/* Ranks a ghost of lights of the flux `light` together. */
static void rank_ghost(struct drawing *d, int i, const double light[3])
{
    const struct gp_lens_view *const v = d->view;
    const struct glarepp_ghost *const g = &d->ghost[i];
    const double disc = M_PI * g->radius * g->radius;
    // or a pixel
    const double pixels = fmax(disc * g->a * g->a / (v->mm[0] * v->mm[1]),
                               1.0);
    const double frame = (double) gp_rect_w(v->frame) *
                         (double) gp_rect_h(v->frame);
    struct rank *const rank = &d->rank[i];
    const struct gp_lens_band band = {0, GP_LENS_PARTS, {0}};
    const double axial[2][GP_LENS_NODES] = {{1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}};
    double root[GP_LENS_NODES], all[3];
    struct gp_lens_path path;
    gp_lens_path(d->lens, g->first, g->second, &path);
    gp_lens_pair_make(&d->spectrum, d->lens, &path, &d->pair[i]);
    rank->norm = sqrt(fmin(pixels, frame)) / pixels;
    rank->pixels = pixels;
    rank->ghost = i;
    for (int k = 0; k < GP_LENS_NODES; k++)
        root[k] = sqrt(d->pair[i].axis[k] * disc);
    gp_lens_light_of(&d->spectrum, &d->pair[i], &band, root, axial,
                     rank->share);
    for (int c = 0; c < 3; c++)
        all[c] = light[c] * rank->share[c];
    rank->bright = gp_luminance_of(v->luminance, all) / pixels;
}

/* Returns the norm of a ghost of lights of the flux `light` together. */
static double norm_of(const struct rank *r, const double light[3])
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++)
        sum += light[c] * r->share[c] * light[c] * r->share[c];
    return sqrt(sum) * r->norm;
}

/* Keeps the ghosts that can be seen, in their order, and counts the others. */
static void choose(struct drawing *d, int lights, struct glarepp_lens_facts *stats)
{
    const struct gp_lens_view *const v = d->view;
    double sum = 0.0, light[3] = {0};
    const int n = gp_lens_ghosts(d->lens, GP_D_LINE, d->ghost, d->blur);
    int left = 0;
    for (int i = 0; i < lights; i++) {
        for (int c = 0; c < 3; c++)
            light[c] += d->light[i].flux[c];
    }
    for (int i = 0; i < n; i++)
        rank_ghost(d, i, light);
    qsort(d->rank, (size_t) n, sizeof *d->rank, by_brightness);
    while (left < n && sum + d->rank[left].bright <= v->tolerance * v->mean) {
        sum += d->rank[left].bright;
        stats->missing += norm_of(&d->rank[left++], light);
    }
    for (int i = 0; i < n; i++)
        stats->missing += norm_of(&d->rank[i], v->rest);
    d->kept = d->rank + left;
    d->kept_n = n - left;
    qsort(d->kept, (size_t) d->kept_n, sizeof *d->kept, by_ghost);
    stats->ghosts = n;
    stats->drawn = n - left;
    stats->left_out = left;
    stats->dark = v->mean > 0.0 ? sum / v->mean : 0.0;
}

// -- items --------------------------------------------------------------------

/* Returns how much coarser than a bright ghost one may be that adds little to
 * the frame: 1 from 0.03 of its mean luminance on, up to 4. */
static double ease_of(const struct drawing *d, const struct rank *r,
                      const double flux[3])
{
    const double plain = 0.03, most = 4.0;
    double light[3];
    for (int c = 0; c < 3; c++)
        light[c] = flux[c] * (r->share[c] / r->pixels);
    const double bright = gp_luminance_of(d->view->luminance, light);
    const double ease = sqrt(plain * d->view->mean / bright);
    return ease > 1.0 && d->view->detail != GP_LENS_REFERENCE
               ? fmin(ease, most)
               : 1.0;
}

static gp_status trace_item(void *ctx, int i, int thread)
{
    struct drawing *const d = ctx;
    struct gp_lens_item *const it = &d->item[i];
    const struct gp_lens_view *const v = d->view;
    const int at = d->first + i;
    const struct gp_lens_light *const light = &d->light[at / d->kept_n];
    const struct rank *const rank = &d->kept[at % d->kept_n];
    const struct glarepp_ghost *const g = &d->ghost[rank->ghost];
    const double x = (light->x - gp_rect_middle(v->display, 0)) * v->mm[0];
    const double y = (light->y - gp_rect_middle(v->display, 1)) * v->mm[1];
    const double away = gp_hypot(x, y);
    const double turn[2] = {away > 0.0 ? x / away : 1.0,
                            away > 0.0 ? y / away : 0.0};
    struct gp_lens_path path;
    (void) thread;
    *it = (struct gp_lens_item) {
        .pair = &d->pair[rank->ghost],
        .u = away / d->scale,
        .level = -1,
        .blades = gp_lens_blades_of(d->lens, gp_atan2(turn[1], turn[0])),
        .along = {turn[0] / v->mm[0], turn[1] / v->mm[1]},
        .aside = {-turn[1] / v->mm[0], turn[0] / v->mm[1]},
        .middle = {gp_rect_middle(v->display, 0) - v->frame.x0,
                   gp_rect_middle(v->display, 1) - v->frame.y0},
    };
    memcpy(it->flux, light->flux, sizeof it->flux);
    gp_lens_path(d->lens, g->first, g->second, &path);
    static const double most[] = {1.0, 5e-4, 0.0}, edge[] = {1.0, 0.25, 0.0};
    const double ease = ease_of(d, rank, light->flux);
    const double blur = d->blur[rank->ghost];
    const gp_status st = gp_lens_mesh_make(
        NULL, d->optics, &path, &it->blades, it->u,
        ease * fmin(v->tolerance, most[v->detail]),
        ease * edge[v->detail] * fmax(blur, v->mm[0]), &it->mesh);
    if (!st && it->mesh.cells) {
        gp_lens_item_light(it, &d->spectrum, v->luminance);
        gp_lens_item_place(v, blur, ease, it);
    }
    return st;
}

// -- drawing ------------------------------------------------------------------

/* Draws all items of the chunk into the rows of one strip of the frame. */
static gp_status draw_rows(void *ctx, int strip, int thread)
{
    struct drawing *const d = ctx;
    struct gp_lens_rays *rays;
    const int last = (gp_rect_h(d->view->frame) - 1) / STRIP_ROWS;
    const gp_status st = gp_alloc(NULL, "rays", 1, sizeof *rays, &rays);
    (void) thread;
    for (int i = 0; i < d->items && !st; i++) {
        const struct gp_lens_item *const it = &d->item[i];
        if (it->level < 0)
            continue;
        const struct gp_lens_steps *const a = &d->level[it->level];
        // the first and the last strip have the margin too
        const int top = strip == 0 ? 0 : strip * STRIP_ROWS / a->step + 1;
        const int end = strip == last ? a->h
                                     : (strip + 1) * STRIP_ROWS / a->step + 1;
        gp_lens_item_draw(it, &d->spectrum, a, top, end, rays);
    }
    gp_free(rays);
    return st;
}

/* Traces and draws the items of a chunk, and adds up their figures. */
static gp_status run_chunk(struct drawing *d, struct glarepp_lens_facts *stats)
{
    const int w = gp_rect_w(d->view->frame), h = gp_rect_h(d->view->frame);
    const int strips = (h + STRIP_ROWS - 1) / STRIP_ROWS;
    gp_status st = gp_parallel(d->items, trace_item, d, NULL);
    for (int i = 0; i < d->items && !st; i++) {
        const int level = d->item[i].level, step = 1 << gp_max(level, 0);
        struct gp_lens_steps *const s = &d->level[gp_max(level, 0)];
        if (level < 0 || s->v)
            continue;
        s->step = step;
        s->w = (w + step - 1) / step + 2;
        s->h = (h + step - 1) / step + 2;
        st = gp_alloc_zero(NULL, "ghosts", (size_t) (s->w + 2) *
                           (size_t) (s->h + 2), 3 * sizeof *s->v, &s->v);
    }
    if (!st)
        st = gp_parallel(strips, draw_rows, d, NULL);
    for (int i = 0; i < d->items; i++) {
        struct gp_lens_item *const it = &d->item[i];
        if (!st && it->mesh.cells) {
            double own[3];
            for (int c = 0; c < 3; c++)
                stats->light[c] += own[c] = it->light[c] * it->flux[c];
            stats->lost += gp_luminance_of(d->view->luminance, own) *
                           it->mesh.lost / it->mesh.flux[GP_LENS_NODES / 2];
            if (it->level >= 0)
                stats->steps[it->level]++;
        }
        gp_lens_mesh_free(&it->mesh);
    }
    return st;
}

/* Measures the image on the axis: what the frame's light stands for. */
static gp_status measure_image(const struct gp_log *log, struct drawing *d)
{
    const struct gp_lens_blades blades = gp_lens_blades_of(d->lens, 0.0);
    struct glarepp_lens figures;
    struct gp_lens_path straight;
    struct gp_lens_mesh mesh;
    for (int k = 0; k < GP_LENS_NODES; k++)
        gp_lens_optics_make(d->lens, gp_lens_node[k], &d->optics[k]);
    gp_lens_path(d->lens, -1, -1, &straight);
    const gp_status st = gp_lens_mesh_make(log, d->optics, &straight, &blades,
                                           0.0, 1e-4, 0.0, &mesh);
    d->scale = gp_lens_measure(d->lens, &figures);
    const bool lit = mesh.cells && d->scale > 0.0 && d->scale < 1e9;
    if (!st && lit)
        gp_lens_spectrum_make(d->view->chromaticities, d->lens, mesh.flux,
                              &d->spectrum);
    gp_lens_mesh_free(&mesh);
    return st || lit ? st : gp_fail_at(log, GP_ERR_DATA, "lens.lens.dark",
                                       "%s: no light reaches its image",
                                       d->lens->says.name);
}

// -- steps --------------------------------------------------------------------

static void sum_row(void *ctx, int y, int thread)
{
    const struct gp_lens_steps *const s = ctx;
    double *const row = s->v + 3 * (size_t) y * (size_t) (s->w + 2);
    (void) thread;
    for (int i = 3; i < 3 * (s->w + 2); i++)
        row[i] += row[i - 3];
}

/* Weights of three steps around a place that is `off` from the middle one's:
 * the quadratic B-spline, whose sum is 1 everywhere. */
static void spline(double off, double weight[3])
{
    weight[0] = 0.5 * (0.5 - off) * (0.5 - off);
    weight[1] = 0.75 - off * off;
    weight[2] = 0.5 * (0.5 + off) * (0.5 + off);
}

/* Adds steps to a row of pixels, smooth between them. */
static void add_level(int w, const struct gp_lens_steps *s, int y, double *row,
                      double *to)
{
    const int stride = 3 * (s->w + 2);
    const double v = (y + 0.5) / s->step + 0.5;
    const int near = (int) (v + 0.5);
    const double *const at = s->v + (size_t) near * (size_t) stride;
    double down[3] = {0.0, 1.0, 0.0}, across[3] = {0.0, 1.0, 0.0};
    if (s->step > 1)
        spline(v - near, down);
    for (int i = 0; i < stride; i++)
        row[i] = down[0] * at[i - stride] + down[1] * at[i] +
                 down[2] * at[i + stride];
    for (int x = 0; x < w; x++) {
        const double u = (x + 0.5) / s->step + 0.5;
        const int i = (int) (u + 0.5);
        if (s->step > 1)
            spline(u - i, across);
        for (int c = 0; c < 3; c++) {
            const double *const p = row + 3 * i + c;
            to[3 * x + c] +=
                across[0] * p[-3] + across[1] * p[0] + across[2] * p[3];
        }
    }
}

/* Sums up all steps of a row, each pixel's colour folded into the gamut. */
static gp_status add_row(void *ctx, int y, int thread)
{
    const struct drawing *const d = ctx;
    const int w = gp_rect_w(d->view->frame);
    const size_t room = 3 * ((size_t) w + 4);
    double *row;
    const gp_status st =
        gp_alloc_zero(NULL, "row", 2 * room, sizeof *row, &row);
    double *const sum = row + room;
    (void) thread;
    for (int l = 0; l < GP_LENS_LEVELS && !st; l++) {
        if (d->level[l].v)
            add_level(w, &d->level[l], y, row, sum);
    }
    for (int x = 0; x < w && !st; x++) {
        gp_gamut_fold(d->view->luminance, sum + 3 * x);
        for (int c = 0; c < 3; c++) {
            // running sums leave a rounding error of 0
            if (sum[3 * x + c] > 1e-30)
                gp_row(d->layer->c[c], w, y)[x] += (float) sum[3 * x + c];
        }
    }
    gp_free(row);
    return st;
}

gp_status gp_lens_draw(const struct gp_log *log, const struct gp_lens *lens,
    const struct gp_lens_view *view, const struct gp_lens_light *light, int n,
    struct gp_planes *layer, struct glarepp_lens_facts *out)
{
    struct glarepp_lens_facts stats = {.lights = n};
    struct drawing *d;
    gp_status st = gp_alloc_zero(log, "ghosts", 1, sizeof *d, &d);
    if (st)
        return st;
    d->lens = lens;
    d->view = view;
    d->light = light;
    d->layer = layer;
    GP_TRY(measure_image(log, d));
    choose(d, n, &stats);
    for (int i = 0; i < n * d->kept_n; i += d->items) {
        d->first = i;
        d->items = gp_min(n * d->kept_n - i, CHUNK);
        // one message, however many threads fail
        if (run_chunk(d, &stats))
            GP_TRY(gp_no_memory(log, "ghosts"));
    }
    for (int l = 0; l < GP_LENS_LEVELS; l++) {
        if (d->level[l].v)
            gp_parallel_do(d->level[l].h, sum_row, &d->level[l]);
    }
    if (gp_parallel(gp_rect_h(view->frame), add_row, d, NULL))
        GP_TRY(gp_no_memory(log, "ghosts"));
    const double light_sum = gp_luminance_of(view->luminance, stats.light);
    stats.lost = stats.lost > 0.0 ? stats.lost / (stats.lost + light_sum) : 0.0;
    *out = stats;
out:
    for (int l = 0; l < GP_LENS_LEVELS; l++)
        gp_free(d->level[l].v);
    gp_free(d);
    return st;
}

// -- a lens in section -------------------------------------------------------

enum { RAYS = 9, ARC = 24 };

/* Adds the points of a surface from one height to another. */
static void print_arc(FILE *f, const struct gp_lens_surface *s, double z,
                      double from, double to)
{
    for (int i = 0; i <= ARC; i++) {
        const double y = from + (to - from) * i / ARC;
        // a rim that is wider than the surface is a flat edge
        const double height = fmin(fabs(y), s->semi), c = s->curvature;
        const double root = fmax(1.0 - c * c * height * height, 0.0);
        fprintf(f, "%.3f,%.3f ", z + c * height * height / (1.0 + sqrt(root)),
                -y);
    }
}

static void print_glass(FILE *f, const struct gp_lens_optics *o)
{
    const struct gp_lens *const lens = o->lens;
    for (int i = 0; i + 1 < lens->n; i++) {
        const struct gp_lens_surface *const a = &lens->at[i], *const b = a + 1;
        const double semi = fmax(a->semi, b->semi);
        if (a->n == 1.0)
            continue;
        fprintf(f, "<polygon class=\"glass\" points=\"");
        print_arc(f, a, o->z[i], -semi, semi);
        print_arc(f, b, o->z[i + 1], semi, -semi);
        fprintf(f, "\"/>\n");
    }
}

/* Rays of a light a little off the axis, over the ghost's pupil. */
static void print_rays(FILE *f, const struct gp_lens_optics *o,
                       const struct glarepp_ghost *ghost, double u)
{
    struct gp_lens_path path;
    double at[GP_LENS_STEPS + 1][3];
    gp_lens_path(o->lens, ghost->first, ghost->second, &path);
    for (int i = 0; i < RAYS; i++) {
        const double radius = fmin(ghost->radius, o->lens->at[0].semi);
        const double x = ghost->shift * u +
                         0.95 * radius * (2.0 * i / (RAYS - 1) - 1.0);
        const struct gp_lens_hit h = gp_lens_trace(o, &path, x, 0.0, u, at);
        if (h.through < 0.0f || h.rim > 1.0f)
            continue;
        const double before = 0.15 * o->z[o->lens->n];
        fprintf(f, "<polyline class=\"ray\" points=\"%.3f,%.3f ", -before,
                -(x - before * u));
        for (int k = 0; k <= path.steps; k++)
            fprintf(f, "%.3f,%.3f ", at[k][2], -at[k][0]);
        fprintf(f, "\"/>\n");
    }
}

gp_status gp_lens_svg(const struct gp_log *log, FILE *f,
                      const struct gp_lens *lens,
                      const struct glarepp_ghost *ghost)
{
    struct gp_lens_optics *o; // 130 KiB: too large for a stack
    double tall = 0.0;
    const gp_status st = gp_alloc(log, lens->says.name, 1, sizeof *o, &o);
    if (st)
        return st;
    gp_lens_optics_make(lens, GP_D_LINE, o);
    for (int i = 0; i < lens->n; i++)
        tall = fmax(tall, lens->at[i].semi);
    const double end = o->z[lens->n], side = 0.17 * end, half = 1.25 * tall;
    const double stop = lens->at[lens->stop].semi, at = o->z[lens->stop];
    const double line = 0.002 * end;
    fprintf(f, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"960\" "
               "viewBox=\"%.3f %.3f %.3f %.3f\">\n"
               "<style>.glass{fill:#cfe3f2;stroke:#3a5a78;stroke-width:%.4f}"
               ".ray{fill:none;stroke:#d06020;stroke-width:%.4f}"
               ".line{stroke:#222;stroke-width:%.4f}</style>\n"
               "<rect x=\"%.3f\" y=\"%.3f\" width=\"%.3f\" height=\"%.3f\" "
               "fill=\"#fff\"/>\n", -side, -half, end + 1.3 * side, 2.0 * half,
            line, 0.6 * line, 1.5 * line, -side, -half, end + 1.3 * side,
            2.0 * half);
    fprintf(f, "<line class=\"line\" stroke-dasharray=\"%.3f\" x1=\"%.3f\" "
               "y1=\"0\" x2=\"%.3f\" y2=\"0\"/>\n", 8.0 * line, -side, end);
    print_glass(f, o);
    for (int k = -1; k <= 1; k += 2)
        fprintf(f, "<line class=\"line\" x1=\"%.3f\" y1=\"%.3f\" x2=\"%.3f\" "
                   "y2=\"%.3f\"/>\n", at, k * stop, at, k * 1.15 * tall);
    fprintf(f, "<line class=\"line\" x1=\"%.3f\" y1=\"%.3f\" x2=\"%.3f\" "
               "y2=\"%.3f\"/>\n", end, -tall, end, tall);
    if (ghost)
        print_rays(f, o, ghost, 0.05);
    fprintf(f, "</svg>\n");
    gp_free(o);
    return GP_OK;
}
