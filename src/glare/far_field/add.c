// SPDX-License-Identifier: Apache-2.0
/* Applying a far field: light to the coarse grid, a convolution, and back. */
#include "core/cpu.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/fft.h"
#include "glare/far_field/far_field.h"

#include <math.h>
#include <string.h>

enum { TAPS = GP_FAR_TAPS, MOST_STEP = 32, LANES = 8 };

struct gp_far_state {
    unsigned long serial;          // of the far field
    struct gp_transform pair[2];   // of x and y
    struct gp_fft_matrix spectrum; // of c, times factors of the passes
    struct gp_far_error error;
    float weight[MOST_STEP][TAPS]; // B at the nodes around pixel i of a step
    float at[TAPS][MOST_STEP];     // the same, tap by tap
};

void gp_far_close(struct gp_far_state **state)
{
    struct gp_far_state *const s = *state;
    if (s) {
        gp_fft_pair_free(s->pair);
        gp_fft_matrix_free(&s->spectrum);
    }
    GP_FREE(*state);
}

const struct gp_far_error *gp_far_error_of(const struct gp_far_state *s)
{
    return &s->error;
}

// -- the kernel's spectrum and its error --------------------------------------

struct kernel_rows {
    const struct gp_far_field *t;
    int nx;
};

/* Row of offset j - ry, each sample at its offset modulo nx. */
static void load_kernel_row(const void *ctx, int c, int j, float *z)
{
    const struct kernel_rows *const r = ctx;
    const int rx = r->t->rx, w = 2 * rx + 1;
    const float *const row = r->t->c[c] + (size_t) j * (size_t) w + rx;
    memcpy(z, row, ((size_t) rx + 1) * sizeof *z);
    memcpy(z + r->nx - rx, row - rx, (size_t) rx * sizeof *z);
}

struct gp_far_keeping gp_far_keep_of(int i, int n)
{
    enum { IMAGES = 4 };
    static const double EDGE = 0.45;
    const double f = (double) (2 * i <= n ? i : i - n) / n;
    struct gp_far_keeping k = {
        .own = (2.0 + gp_cos(2.0 * M_PI * f)) / 3.0,
        .edge = fabs(f) > EDGE,
    };
    for (int m = -IMAGES; m <= IMAGES; m++) {
        const double a = M_PI * (f + m);
        // up to its sign
        const double s = a == 0.0 ? 1.0 : gp_sin(M_PI * f) / a;
        const double v = s * s * s * s / k.own;
        k.kept = m == 0 ? v : k.kept;
        k.sum += v;
        k.square += v * v;
    }
    return k;
}

/* Figures of one channel's spectrum that limit the error. */
struct limits {
    double most, edge;  // of the frequencies
    double sum, square; // over all frequencies
};

/* Adds a column of the spectrum, one lane of its points, of frequency u across
 * and as many as `twice` alike, to l. */
GP_CLONES static void limit_column(const float *restrict z, double scale,
                                   const struct gp_far_keeping *u,
                                   const struct gp_far_keeping *down, int ny,
                                   double twice, struct limits *l)
{
    double most = l->most, edge = l->edge, sum = 0.0, squares = 0.0;
    for (int y = 0; y < ny; y++) {
        const struct gp_far_keeping *const v = &down[y];
        const double own = u->own * v->own;
        const float *const at = z + 2 * GP_FLOAT_LINES * y;
        const double re = (double) at[0], im = (double) at[GP_FLOAT_LINES];
        const double f = scale * own * own * sqrt(re * re + im * im);
        const double kept = u->kept * v->kept;
        const double lost = fabs(1.0 - kept * kept);
        const double eps =
            sqrt(gp_maxd(u->square * v->square - kept * kept, 0.0));
        const double eta = u->sum * v->sum - kept;
        const double same = lost + kept * eta, other = kept + eta;
        most = gp_maxd(most, f * (lost + kept * eps + eps * eps));
        edge = gp_maxd(edge, u->edge || v->edge ? f : 0.0);
        sum += f * (lost + 2.0 * kept * eta + eta * eta);
        squares += f * f * (same * same + eps * eps * other * other);
    }
    l->most = most;
    l->edge = edge;
    l->sum += twice * sum;
    l->square += twice * squares;
}

/* Finds the error's limits from the spectrum: far_field.h. */
static gp_status find_error(const struct gp_log *log, const struct gp_far_field *t,
                            struct gp_far_state *s)
{
    // of sums of products: 24 of two lines of a step's pixels, and 40 of the
    // transforms, gp_fft_pixel_error() of 2^19 nodes
    static const double ROUNDINGS = 64.0;
    const int nx = s->pair[0].n, ny = s->pair[1].n;
    const double step = t->split.step, area = step * step;
    const double points = (double) nx * ny;
    struct gp_far_error e = {.rounding = ROUNDINGS * 0x1p-24};
    struct gp_far_keeping *down;
    gp_status st = gp_alloc(log, "tail", (size_t) ny, sizeof *down, &down);
    if (st)
        return st;
    for (int i = 0; i < ny; i++)
        down[i] = gp_far_keep_of(i, ny);
    double norm1 = 0.0;
    for (int c = 0; c < (t->grey ? 1 : 3); c++) {
        struct limits l = {0};
        for (int x = 0; x <= nx / 2; x++) {
            const struct gp_far_keeping across = gp_far_keep_of(x, nx);
            // the passes' factor 1 / 2 of rows was left out once
            const float *const plane = s->spectrum.z[c];
            limit_column(plane +
                             (size_t) (x / GP_FLOAT_LINES) * s->spectrum.pitch *
                                 2 * GP_FLOAT_LINES +
                             x % GP_FLOAT_LINES,
                         2.0 * points * area, &across, down, ny,
                         x == 0 || 2 * x == nx ? 1.0 : 2.0, &l);
        }
        e.norm = fmax(e.norm, l.most + 2.0 * l.edge);
        e.pixel = fmax(e.pixel, (l.sum / points + 2.0 * l.edge) / area);
        e.column = fmax(e.column, sqrt(l.square / points +
                                       4.0 * l.edge * l.edge) / step);
        norm1 = fmax(norm1, t->norm1[c]);
    }
    e.norm += e.rounding * norm1;
    s->error = e;
    gp_free(down);
    return GP_OK;
}

gp_status gp_far_open(const struct gp_log *log, const struct gp_far_field *t,
                       struct gp_far_state **state)
{
    gp_status st = GP_OK;
    const int channels = t->grey ? 1 : 3, rows = 2 * t->ry + 1;
    struct gp_far_state *s = NULL;
    int *places = NULL;
    if (*state && (*state)->serial == t->serial)
        return GP_OK;
    // a torus on which nothing that wraps around meets a frame
    const int nx = gp_fft_length(2 * t->rx + 1);
    const int ny = gp_fft_length(2 * t->ry + 1);
    GP_TRY(gp_alloc_zero(log, "tail", 1, sizeof *s, &s));
    GP_TRY(gp_fft_pair_make(log, nx, ny, false, s->pair));
    GP_TRY(gp_fft_matrix_make(log, (struct gp_fft_numbers) {0}, channels, nx,
                              ny, &s->spectrum));
    GP_TRY(gp_alloc(log, "tail", (size_t) rows, sizeof *places, &places));
    const struct gp_fft_request fft = {
        .log = log,
        .t = s->pair,
        .channels = channels,
    };
    const struct kernel_rows from = {t, nx};
    for (int j = 0; j < rows; j++)
        places[j] = (j - t->ry + ny) % ny;
    GP_TRY(gp_fft_rows_in(&fft, rows, load_kernel_row, &from, &s->spectrum));
    // factors 1/2 of rows were left out here, and will be of the light's
    GP_TRY(gp_fft_make_kernel(&fft, (struct gp_fft_rows) {rows, places},
                              0.25 / ((double) nx * ny), &s->spectrum));
    GP_TRY(find_error(log, t, s));
    for (int i = 0; i < t->split.step; i++) {
        double b[TAPS];
        gp_far_spline((double) i / t->split.step, b);
        for (int k = 0; k < TAPS; k++)
            s->at[k][i] = s->weight[i][k] = (float) b[k];
    }
    s->serial = t->serial;
    gp_far_close(state);
    *state = s;
    s = NULL;
out:
    gp_far_close(&s);
    gp_free(places);
    return st;
}

double gp_far_pixel_error(const struct gp_far_state *s,
                           const struct gp_far_field *t,
                           const struct gp_sources *src, int c)
{
    const double norm = sqrt(src->energy[c]);
    const double most = fmin((double) src->brightest * t->norm1[c],
                             norm * t->norm2[c]);
    return fmin(s->error.pixel * src->flux[c], s->error.column * norm) +
           s->error.rounding * most;
}

// -- light to the grid --------------------------------------------------------

struct gp_far_rows {
    const struct gp_far_field *t;
    const struct gp_far_state *s;
    const struct gp_sources *src; // NULL: light 1 everywhere
    int w, h;             // of the frame
    int nodes_x, nodes_y;
    size_t pitch;         // floats of a row of nodes
    int first, last;      // steps [first, last) of rows that hold light
    float *sums;          // of these: what each adds to rows of nodes, [step -
                          // first][tap][channel][pitch]
    float *line;          // scratch of a thread: 3 * pitch
    float *grid[3];       // the convolution: nodes_y * pitch
    struct gp_planes *layer;
};

typedef float four __attribute__((vector_size(TAPS * sizeof(float))));

/* Adds the lights [from, to) of a row to the nodes of a line, channel after
 * channel. */
static void spread_along(const struct gp_far_rows *a, uint32_t from, uint32_t to,
                         float *line)
{
    const struct gp_sources *const src = a->src;
    const int bits = __builtin_ctz((unsigned) a->t->split.step);
    const int mask = a->t->split.step - 1;
    const float *const r = src->rgb[0], *const g = src->rgb[1];
    const float *const b = src->rgb[2];
    for (uint32_t i = from; i < to;) {
        const int node = src->x[i] >> bits;
        four sum[3] = {{0}}, w;
        for (; i < to && src->x[i] >> bits == node; i++) {
            memcpy(&w, a->s->weight[src->x[i] & mask], sizeof w);
            sum[0] += w * r[i];
            sum[1] += w * g[i];
            sum[2] += w * b[i];
        }
        for (size_t c = 0; c < 3; c++) {
            float *const at = line + c * a->pitch + (size_t) node;
            memcpy(&w, at, sizeof w);
            w += sum[c];
            memcpy(at, &w, sizeof w);
        }
    }
}

/* The rows of one step: along them, then down to the four rows of nodes. */
static void spread_step(void *ctx, int i, int thread)
{
    const struct gp_far_rows *const a = ctx;
    const int step = a->t->split.step, first = (a->first + i) * step;
    const size_t n = 3 * a->pitch;
    float *const line = a->line + (size_t) thread * n;
    float *const sums = a->sums + (size_t) i * TAPS * n;
    memset(sums, 0, TAPS * n * sizeof *sums);
    for (int y = first; y < gp_min(first + step, a->src->h); y++) {
        const uint32_t from = a->src->row[y], to = a->src->row[y + 1];
        if (from == to)
            continue;
        memset(line, 0, n * sizeof *line);
        spread_along(a, from, to, line);
        for (size_t k = 0; k < TAPS; k++) {
            const float w = a->s->weight[y - first][k];
            for (size_t x = 0; x < n; x++)
                sums[k * n + x] += w * line[x];
        }
    }
}

/* Row `first + j` of nodes: what the four steps above and below it add. */
static void load_nodes(const void *ctx, int c, int j, float *z)
{
    const struct gp_far_rows *const a = ctx;
    for (int k = TAPS - 1; k >= 0; k--) {
        const int i = j - k;
        if (i < 0 || i >= a->last - a->first)
            continue;
        const float *const from =
            a->sums + (((size_t) i * TAPS + (size_t) k) * 3 + (size_t) c) *
                          a->pitch;
        for (int x = 0; x < a->nodes_x; x++)
            z[x] += from[x];
    }
}

// -- and back -----------------------------------------------------------------

static void store_nodes(const void *ctx, int c, int j, const float *z)
{
    const struct gp_far_rows *const a = ctx;
    float *const to = a->grid[c] + (size_t) j * a->pitch;
    memcpy(to, z, (size_t) a->nodes_x * sizeof *to);
}

/* Adds a line of nodes to a row of w pixels, `at` the weights of each tap. */
GP_CLONES static void put_line(float *restrict row, int w,
    const float *restrict line, int step, const float at[TAPS][MOST_STEP])
{
    for (int x = 0; x < w; x += step, line++) {
        const int n = gp_min(step, w - x);
        for (int i = 0; i < n; i++) {
            float v = line[0] * at[0][i] + line[1] * at[1][i] +
                      line[2] * at[2][i] + line[3] * at[3][i];
            v += row[x + i];
            row[x + i] = v > 0.0f ? v : 0.0f;
        }
    }
}

/* Returns the nodes of row y of channel c, in `thread`'s line. */
static const float *line_of(const struct gp_far_rows *a, int c, int y, int thread)
{
    const int step = a->t->split.step;
    const float *const down = a->s->weight[y % step];
    float *const line = a->line + (size_t) thread * 3 * a->pitch;
    const float *const g = a->grid[a->t->grey && !a->src ? 0 : c] +
                           (size_t) (y / step) * a->pitch;
    for (size_t x = 0; x < a->pitch; x++)
        line[x] = down[0] * g[x] + down[1] * g[x + a->pitch] +
                  down[2] * g[x + 2 * a->pitch] + down[3] * g[x + 3 * a->pitch];
    return line;
}

void gp_far_row(const struct gp_far_rows *a, int c, int y, int thread, float *row)
{
    memset(row, 0, (size_t) a->w * sizeof *row);
    put_line(row, a->w, line_of(a, c, y, thread), a->t->split.step, a->s->at);
}

void gp_far_add_row(void *ctx, int i, int thread)
{
    const struct gp_far_rows *const a = ctx;
    const int c = i / a->h, y = i % a->h;
    put_line(a->layer->c[c] + (size_t) y * (size_t) a->w, a->w,
             line_of(a, c, y, thread), a->t->split.step, a->s->at);
}

void gp_far_rows_free(struct gp_far_rows **rows)
{
    struct gp_far_rows *const a = *rows;
    if (a) {
        gp_free(a->sums);
        gp_free(a->line);
        for (int c = 0; c < 3; c++)
            gp_free(a->grid[c]);
    }
    GP_FREE(*rows);
}

/* Row `j` of nodes of light 1 everywhere: what all pixels give them. */
static void load_flat(const void *ctx, GP_UNUSED int c, int j, float *z)
{
    const struct gp_far_rows *const a = ctx;
    for (int x = 0; x < a->nodes_x; x++)
        z[x] = a->sums[x] * a->sums[a->nodes_x + j];
}

/* Adds n pixels of light 1 to their nodes. */
static void spread_flat(const struct gp_far_state *s, int step, int n,
                        float *nodes)
{
    for (int x = 0; x < n; x++) {
        for (int k = 0; k < TAPS; k++)
            nodes[x / step + k] += s->weight[x % step][k];
    }
}

gp_status gp_far_find(const struct gp_log *log, const struct gp_far_field *t,
                      const struct gp_far_state *state,
                      const struct gp_sources *src, int w, int h,
                      struct gp_planes *layer, struct gp_far_rows **out)
{
    gp_status st;
    struct gp_far_rows *a = NULL;
    const int step = t->split.step, channels = src || !t->grey ? 3 : 1;
    struct gp_fft_matrix m = {0};
    int *places = NULL;
    if (w > t->w || h > t->h)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "glare: a kernel made for %dx%d "
                            "pixels meets %dx%d",
                            t->w, t->h, w, h);
    GP_TRY(gp_alloc_zero(log, "tail", 1, sizeof *a, &a));
    *a = (struct gp_far_rows) {
        .t = t,
        .s = state,
        .src = src,
        .w = w,
        .h = h,
        .layer = layer,
        .first = src ? src->box.y0 / step : 0,
        .last = ((src ? src->box.y1 : h) - 1) / step + 1,
    };
    a->nodes_x = gp_far_nodes(a->w, step);
    a->nodes_y = gp_far_nodes(a->h, step);
    a->pitch = ((size_t) a->nodes_x + LANES - 1) / LANES * LANES;
    const int rows = a->last - a->first + TAPS - 1; // of nodes that are lit
    GP_TRY(gp_alloc(log, "tail", (size_t) gp_threads() * 3,
                    a->pitch * sizeof(float), &a->line));
    for (int c = 0; c < channels; c++)
        GP_TRY(gp_alloc_zero(log, "tail", (size_t) a->nodes_y,
                             a->pitch * sizeof(float), &a->grid[c]));
    GP_TRY(gp_alloc(log, "tail", (size_t) rows, sizeof *places, &places));
    GP_TRY(gp_fft_matrix_make(log, (struct gp_fft_numbers) {0}, channels,
                              state->pair[0].n, gp_max(rows, a->nodes_y), &m));
    for (int j = 0; j < rows; j++)
        places[j] = a->first + j;
    const struct gp_fft_request fft = {
        .log = log,
        .t = state->pair,
        .channels = channels,
    };
    if (src) {
        GP_TRY(gp_alloc(log, "tail", (size_t) (a->last - a->first) * TAPS * 3,
                        a->pitch * sizeof(float), &a->sums));
        gp_parallel_do(a->last - a->first, spread_step, a);
    } else {
        GP_TRY(gp_alloc_zero(log, "tail", (size_t) (a->nodes_x + a->nodes_y),
                             sizeof *a->sums, &a->sums));
        spread_flat(state, step, a->w, a->sums);
        spread_flat(state, step, a->h, a->sums + a->nodes_x);
    }
    GP_TRY(gp_fft_rows_in(&fft, rows, src ? load_nodes : load_flat, a, &m));
    GP_TRY(gp_fft_multiply(&fft, (struct gp_fft_rows) {rows, places},
                           &state->spectrum, 0, a->nodes_y, &m));
    GP_TRY(gp_fft_rows_out(&fft, &m, a->nodes_y, store_nodes, a));
    GP_FREE(a->sums);
    *out = a;
    a = NULL;
out:
    gp_far_rows_free(&a);
    gp_free(places);
    gp_fft_matrix_free(&m);
    return st;
}
