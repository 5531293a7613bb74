// SPDX-License-Identifier: Apache-2.0
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/sky/sphere.h"

#include <math.h>
#include <string.h>

enum { LINES = GP_FLOAT_LINES, BAND = GP_SKY_BAND };

typedef gp_float_lines lines;

/* A coefficient of LINES frequencies. */
struct point {
    lines re, im;
};

struct adding {
    const struct gp_sky *s;
    const struct gp_sky_sphere *o;
    const struct gp_sky_drawing *d;
    const struct gp_fft_matrix *m;
    char *scratch;
    size_t room;              // bytes of a thread
    size_t at[GP_SKY_LEVELS]; // points before a level's, in moments or nodes
    size_t nodes;             // of all levels
};

// -- rows, in and out ---------------------------------------------------------

/* The column of the sphere that one of the frame is. */
static int column_of(const struct gp_sky_sphere *o, int x)
{
    return x + o->x0 < o->w ? x + o->x0 : x + o->x0 - o->w;
}

static void load_row(const void *ctx, int c, int y, float *z)
{
    const struct adding *const a = ctx;
    const struct gp_sources *const src = a->d->src;
    const int row = y - a->o->y0;
    if (row < 0 || row >= src->h || c < a->s->from || c >= a->s->to)
        return;
    const float solid =
        (float) gp_projection_solid(&a->s->p.projection, 0.0, y);
    for (uint32_t i = src->row[row]; i < src->row[row + 1]; i++)
        z[column_of(a->o, src->x[i])] = solid * src->rgb[c][i];
}

static void store_row(const void *ctx, int c, int y, const float *z)
{
    const struct adding *const a = ctx;
    const struct gp_sources *const src = a->d->src;
    const int row = y - a->o->y0, w = src->w;
    const float by = 0.5f / (float) a->o->w;
    if (row < 0 || row >= src->h || c < a->s->from || c >= a->s->to)
        return;
    float *const to = a->d->layer->c[c] + (size_t) row * (size_t) w;
    for (int x = 0, at = a->o->x0; x < w; x++, at++) {
        at = at == a->o->w ? 0 : at;
        to[x] = (a->d->add ? to[x] : 0.0f) + by * z[at];
    }
}

// -- levels of a block of coefficients ----------------------------------------

/* (-1)^m. */
static const lines TURN = {1, -1, 1, -1, 1, -1, 1, -1};

static inline __attribute__((always_inline)) struct point turned(struct point p)
{
    return (struct point) {p.re * TURN, p.im * TURN};
}

static inline __attribute__((always_inline)) void
add_to(struct point *to, struct point p, lines by)
{
    to->re += by * p.re;
    to->im += by * p.im;
}

static inline __attribute__((always_inline)) lines all(float v)
{
    return (lines) {v, v, v, v, v, v, v, v};
}

/* Moments of level 1, its nodes from -1 on, of rows; and folded: a node beyond a pole is
 * one half a turn away. */
GP_CLONES static void gather_rows(const struct gp_sky_sphere *o,
                                  const struct point *rows, struct point *e)
{
    const int n = o->level[1].n;
    memset(e - 1, 0, ((size_t) n + 3) * sizeof *e);
    for (int y = 0; y < o->h; y++) {
        for (int k = 0; k < GP_SKY_TAPS; k++)
            add_to(&e[o->rows[y].first + k], rows[y], all(o->rows[y].at[k]));
    }
    add_to(&e[1], e[-1], TURN);
    add_to(&e[n - 1], e[n + 1], TURN);
    add_to(&e[0], e[0], TURN);
    add_to(&e[n], e[n], TURN);
}

/* Node i of 0 .. n, or beyond a pole. */
static inline __attribute__((always_inline)) struct point
node_at(const struct point *e, int n, int i)
{
    return i < 0 ? turned(e[-i]) : i > n ? turned(e[2 * n - i]) : e[i];
}

/* Moments of half as many nodes: 1, 4, 6, 4, 1 of 8. */
GP_CLONES static void halve(const struct point *from, int n, struct point *to)
{
    static const float B[5] = {0.125f, 0.5f, 0.75f, 0.5f, 0.125f};
    for (int i = 0; 2 * i <= n; i++) {
        to[i] = (struct point) {{0}, {0}};
        for (int k = 0; k < 5; k++)
            add_to(&to[i], node_at(from, n, 2 * i + k - 2), all(B[k]));
    }
}

/* Divides the samples 1/6, 4/6, 1/6 of the cubic B-spline out of nodes: Unser et al.
 * 1993, part II, eq. 2.5. Of three planes, `apart` points apart: each waits for the node
 * before, and meanwhile the others do not. */
GP_CLONES static void divide(struct point *e, int n, size_t apart)
{
    enum { TERMS = 16 };
    static const float Z = -0.26794919243112270647f; // sqrt 3 - 2
    // the mirror image of an even line; an odd one ends in 0
    const lines end = (all(1.0f) + TURN) * all(0.5f * Z / (Z * Z - 1.0f));
    for (size_t c = 0; c < 3; c++) {
        struct point first = e[c * apart];
        float z = Z;
        for (int k = 1; k <= TERMS; k++, z *= Z)
            add_to(&first, node_at(e + c * apart, n, k <= n ? -k : -n),
                   all(k <= n ? z : 0.0f));
        e[c * apart] = first;
    }
    for (struct point *p = e + 1; p <= e + n; p++)
        for (size_t c = 0; c < 3; c++)
            add_to(&p[c * apart], p[c * apart - 1], all(Z));
    for (size_t c = 0; c < 3; c++) {
        struct point *const last = e + c * apart + n;
        add_to(last, last[-1], all(Z));
        *last = (struct point) {last->re * end, last->im * end};
    }
    for (struct point *p = e + n - 1; p >= e; p--)
        for (size_t c = 0; c < 3; c++) {
            struct point *const at = p + c * apart;
            *at = (struct point) {all(Z) * (at[1].re - at->re),
                                  all(Z) * (at[1].im - at->im)};
            at[1].re *= all(6.0f);
            at[1].im *= all(6.0f);
        }
    for (size_t c = 0; c < 3; c++) {
        e[c * apart].re *= all(6.0f);
        e[c * apart].im *= all(6.0f);
    }
}

/* Both of a pair of circles light each other. */
static inline __attribute__((always_inline)) void
spread_pair(const struct point *e, struct point *v, int i, int k, lines by)
{
    add_to(&v[i], e[k], by);
    if (i != k)
        add_to(&v[k], e[i], by);
}

/* v += the sum over circles of all pairs of a level; planes of `apart` points. */
GP_CLONES static void spread(const struct gp_sky_circles *g, int block,
                             const struct point *e, struct point *v,
                             size_t apart)
{
    const lines *k =
        (const lines *) (const void *) g->k + (size_t) block * g->pairs;
    for (int i = 0; 2 * i <= g->n; i++, k += g->reach + 1) {
        for (int o = 0; o <= g->reach && 2 * i + o <= g->n; o++) {
            const int j = i + o;
            for (size_t c = 0; c < 3; c++)
                spread_pair(e + c * apart, v + c * apart, i, j, k[o]);
            for (size_t c = 0; c < 3 && i + j != g->n; c++)
                spread_pair(e + c * apart, v + c * apart, g->n - j, g->n - i,
                            k[o]);
        }
    }
}

/* Adds the nodes of the next level. */
GP_CLONES static void between(const struct point *from, int n, struct point *to)
{
    for (int i = 0; i <= n; i++) {
        add_to(&to[2 * i], from[i], all(0.75f));
        add_to(&to[2 * i], node_at(from, n, i - 1), all(0.125f));
        add_to(&to[2 * i], node_at(from, n, i + 1), all(0.125f));
        if (i == n)
            break;
        add_to(&to[2 * i + 1], from[i], all(0.5f));
        add_to(&to[2 * i + 1], from[i + 1], all(0.5f));
    }
}

/* The first term of rows around the poles: of `rows` to `out`, which has those of the
 * north and then of the south from the pole on. */
GP_CLONES static void spread_poles(const struct gp_sky_sphere *o, int block,
                                   const struct point *rows, struct point *out)
{
    const struct gp_sky_circles *const g = &o->level[0];
    const lines *k =
        (const lines *) (const void *) g->k + (size_t) block * g->pairs;
    memset(out, 0, 2 * (size_t) g->n * sizeof *out);
    for (int i = 0; i < g->n; i++, k += g->reach + 1) {
        for (int r = 0; r <= g->reach && i + r < o->h; r++) {
            const int j = i + r, last = o->h - 1;
            add_to(&out[i], rows[j], k[r]);
            add_to(&out[g->n + i], rows[last - j], k[r]);
            if (j == i || j >= g->n)
                continue;
            add_to(&out[j], rows[i], k[r]);
            add_to(&out[g->n + j], rows[last - i], k[r]);
        }
    }
}

/* Rows of level 1's nodes, and of the poles'. */
GP_CLONES static void give_rows(const struct gp_sky_sphere *o,
                                struct point *nodes, const struct point *pole,
                                struct point *rows)
{
    const int n = o->level[1].n, near = o->level[0].n;
    nodes[-1] = turned(nodes[1]);
    nodes[n + 1] = turned(nodes[n - 1]);
    for (int y = 0; y < o->h; y++) {
        struct point sum = {{0}, {0}};
        for (int k = 0; k < GP_SKY_TAPS; k++)
            add_to(&sum, nodes[o->rows[y].first + k], all(o->rows[y].at[k]));
        rows[y] = sum;
    }
    for (int y = 0; y < near; y++) {
        add_to(&rows[y], pole[y], all(1.0f));
        add_to(&rows[o->h - 1 - y], pole[near + y], all(1.0f));
    }
}

/* A block of coefficients of all rows: what levels spread, in its place. */
static void spread_block(void *ctx, int b, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_sky_sphere *const o = a->o;
    struct point *const e = (void *) (a->scratch + (size_t) thread * a->room);
    struct point *const v = e + 3 * a->nodes, *const pole = v + 3 * a->nodes;
    int top = 0; // the last level that has the block
    while (top < o->levels - 1 && b < o->level[top + 1].blocks)
        top++;
    memset(v, 0, 3 * a->nodes * sizeof *v);
    for (size_t c = 0; c < 3 && top; c++) {
        struct point *const of = e + c * a->nodes;
        gather_rows(o, (struct point *) a->m->z[c] + (size_t) b * a->m->pitch,
                    of + a->at[1]);
        for (int l = 1; l < top; l++)
            halve(of + a->at[l], o->level[l].n, of + a->at[l + 1]);
    }
    for (int l = 1; l <= top; l++) {
        const int n = o->level[l].n;
        divide(e + a->at[l], n, a->nodes);
        // both halves of a turn have what is on a pole
        for (size_t c = 0; c < 3; c++) {
            struct point *const nodes = e + c * a->nodes + a->at[l];
            for (int k = 0; k <= n; k += n)
                nodes[k] = (struct point) {all(0.5f) * nodes[k].re,
                                           all(0.5f) * nodes[k].im};
        }
    }
    for (int l = top; l >= 1; l--) {
        spread(&o->level[l], b, e + a->at[l], v + a->at[l], a->nodes);
        divide(v + a->at[l], o->level[l].n, a->nodes);
    }
    for (size_t c = 0; c < 3; c++) {
        struct point *const rows =
            (struct point *) a->m->z[c] + (size_t) b * a->m->pitch;
        struct point *const of = v + c * a->nodes;
        for (int l = top - 1; l >= 1; l--)
            between(of + a->at[l + 1], o->level[l + 1].n, of + a->at[l]);
        spread_poles(o, b, rows, pole);
        give_rows(o, of + a->at[1], pole, rows);
    }
}

// -- the first term -----------------------------------------------------------

/* Adds the sum of weight[k] light[x - k], |k| <= reach, to n columns. */
GP_CLONES_WIDE static void sum_dense(const float *restrict light,
                                     const float *restrict weight, int reach,
                                     int n, float *restrict to)
{
    enum { CHUNK = 64 };
    for (int x = 0; x < n; x += CHUNK) {
        float sum[CHUNK] = {0};
        for (int k = -reach; k <= reach; k++) {
            for (int i = 0; i < CHUNK; i++)
                sum[i] += weight[k] * light[x + i - k];
        }
        const int end = n - x < CHUNK ? n - x : CHUNK;
        for (int i = 0; i < end; i++)
            to[x + i] += sum[i];
    }
}

/* Lines of a row with room beyond both ends. */
static size_t line_room(const struct gp_sky_sphere *o)
{
    return (size_t) o->w + 2 * (size_t) o->margin + 128;
}

/* Lines of a thread: of rows that reach a band, and of one of its rows. */
static size_t band_room(const struct gp_sky_sphere *o)
{
    return (size_t) (BAND + 2 * o->near + 1) * 3 * line_room(o);
}

/* Tests whether so many sources of a row are faster summed with all its pixels. */
static bool is_dense(const struct adding *a, int y)
{
    const struct gp_sources *const src = a->d->src;
    return (src->row[y + 1] - src->row[y]) * 8 > (uint32_t) a->o->w;
}

/* Lays out a row of sources, from `margin` before the first column on. */
static void lay_out(const struct adding *a, int y, float *lines_of)
{
    const struct gp_sky_sphere *const o = a->o;
    const struct gp_sources *const src = a->d->src;
    const size_t margin = (size_t) o->margin, w = (size_t) o->w;
    for (size_t c = 0; c < 3; c++) {
        float *const line = lines_of + c * line_room(o);
        memset(line, 0, line_room(o) * sizeof *line);
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
            line[margin + (size_t) column_of(o, src->x[i])] = src->rgb[c][i];
        memcpy(line, line + w, margin * sizeof *line); // all around
        memcpy(line + margin + w, line + margin, margin * sizeof *line);
    }
}

/* to += by * from, n of each. */
GP_CLONES static void add_scaled(float *restrict to, const float *restrict from,
                                 float by, int n)
{
    for (int i = 0; i < n; i++)
        to[i] += by * from[i];
}

/* Adds what row `from` of sources, laid out where they are dense, spreads to the three
 * lines of row y of the sphere. */
static void add_arc(const struct adding *a, int y, int from, const float *light,
                    float *line)
{
    const struct gp_sky_sphere *const o = a->o;
    const struct gp_sources *const src = a->d->src;
    const bool south = 2 * y >= o->h;
    const int row = south ? o->h - 1 - y : y, down = from + o->y0 - y;
    const struct gp_sky_arc *const arc =
        &o->arc[row * (2 * o->near + 1) + (south ? -down : down) + o->near];
    const float *const weight = o->weight + arc->at;
    const int reach = arc->reach;
    for (size_t c = 0; c < 3 && reach >= 0; c++) {
        const size_t at = c * line_room(o) + (size_t) o->margin;
        if (is_dense(a, from)) {
            sum_dense(light + at, weight, reach, o->w, line + at);
            continue;
        }
        for (uint32_t i = src->row[from]; i < src->row[from + 1]; i++)
            add_scaled(line + at + column_of(o, src->x[i]) - reach,
                       weight - reach, src->rgb[c][i], 2 * reach + 1);
    }
}

/* Adds a line of the sphere to a row of the frame; what stays, by `own`; and leaves no
 * light below 0. */
static void finish_row(const struct adding *a, int y, size_t c, float own,
                       float *at, bool lit)
{
    const struct gp_sky_sphere *const o = a->o;
    const struct gp_sources *const src = a->d->src;
    const int w = src->w, before = gp_min(w, o->w - o->x0);
    float *const to = a->d->layer->c[c] + (size_t) y * (size_t) w;
    for (int x = 0; x < o->margin && lit; x++) { // all around
        at[x] += at[o->w + x];
        at[o->w - 1 - x] += at[-1 - x];
    }
    if (lit) {
        add_scaled(to, at + o->x0, 1.0f, before);
        add_scaled(to + before, at, 1.0f, w - before);
    }
    for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
        to[src->x[i]] += own * src->rgb[c][i];
    for (int x = 0; x < w; x++)
        to[x] = gp_maxf(to[x], 0.0f);
}

/* A band of rows: the first term, and all the rest. */
static void finish_band(void *ctx, int band, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_sky_sphere *const o = a->o;
    const struct gp_sky_drawing *const d = a->d;
    const int h = d->src->h, near = o->level[0].n, top = band * BAND - o->near;
    const size_t room = line_room(o);
    float *const line = (void *) (a->scratch + (size_t) thread * a->room);
    float *const light = line + 3 * room; // of rows from `top` on
    for (int y = gp_max(top, 0); y < gp_min(top + BAND + 2 * o->near, h); y++) {
        if (is_dense(a, y))
            lay_out(a, y, light + (size_t) (y - top) * 3 * room);
    }
    for (int y = band * BAND; y < gp_min((band + 1) * BAND, h); y++) {
        const int row = y + o->y0, from = gp_max(y - o->near, 0);
        const int end = gp_min(y + o->near + 1, h);
        const bool lit = row >= near && row < o->h - near &&
                         d->src->row[from] != d->src->row[end];
        if (lit)
            memset(line, 0, 3 * room * sizeof *line);
        for (int s = from; s < end && lit; s++)
            add_arc(a, row, s, light + (size_t) (s - top) * 3 * room, line);
        for (int c = a->s->from; c < a->s->to; c++)
            finish_row(a, y, (size_t) c, (float) o->own[row] + d->more[c],
                       line + (size_t) c * room + o->margin, lit);
    }
}

// -- all of it ----------------------------------------------------------------

gp_status gp_sky_sphere_add(const struct gp_log *log, const struct gp_sky *s,
                            const struct gp_sky_drawing *d)
{
    const struct gp_sky_sphere *const o = s->sphere;
    struct gp_fft_matrix m = {0};
    struct adding a = {.s = s, .o = o, .d = d, .m = &m};
    const struct gp_fft_request req = {
        .log = log, .t = &o->around, .channels = 3};
    gp_status st = GP_OK;
    for (int l = 1; l < o->levels; l++) { // one node beyond each pole
        a.at[l] = a.nodes + 1;
        a.nodes += (size_t) o->level[l].n + 3;
    }
    a.room = (6 * a.nodes + 2 * (size_t) o->level[0].n) * sizeof(struct point);
    const size_t lines = band_room(o) * sizeof(float);
    a.room = (a.room > lines ? a.room : lines) + GP_POINT_BYTES;
    a.room -= a.room % GP_POINT_BYTES;
    GP_TRY(gp_fft_matrix_make(log, (struct gp_fft_numbers) {0}, 3, o->w, o->h,
                              &m));
    GP_TRY(gp_alloc(log, "layer", a.room, (size_t) gp_threads(), &a.scratch));
    GP_TRY(gp_fft_rows_in(&req, o->h, load_row, &a, &m));
    gp_parallel_do(m.blocks, spread_block, &a);
    GP_TRY(gp_fft_rows_out(&req, &m, o->h, store_row, &a));
    gp_parallel_do((d->src->h + BAND - 1) / BAND, finish_band, &a);
out:
    gp_fft_matrix_free(&m);
    gp_free(a.scratch);
    return st;
}
