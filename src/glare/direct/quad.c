#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"

#include <limits.h>
#include <math.h>
#include <stdbool.h>

enum {
    BAND = 16,         // rows of a task of the sum: a multiple of GP_QUAD
    PANEL = 512,       // its columns: a multiple of STRIP
    STRIP = 16,        // columns summed together: two vectors
};

/* Sources (x, y), (x, y + 1), (x, y + 2), (x, y + 3) for each x and y where one
 * of them is light; dark ones are 0. Those of y are [row[y + 3], row[y + 4]),
 * from y = -3 on, x ascending. */
struct quads {
    size_t n;
    uint32_t *row;   // h + GP_QUAD offsets
    int32_t *x;      // n columns
    float *light[3]; // GP_QUAD * n each
};

/* The places of the sources of four rows that are read side by side. */
struct heads {
    const struct gp_sources *src;
    uint32_t at[GP_QUAD], end[GP_QUAD];
};

static struct heads open_rows(const struct gp_sources *s, int y)
{
    struct heads h = {.src = s};
    for (int i = 0; i < GP_QUAD; i++) {
        const bool inside = y + i >= 0 && y + i < s->h;
        h.at[i] = inside ? s->row[y + i] : 0;
        h.end[i] = inside ? s->row[y + i + 1] : 0;
    }
    return h;
}

static inline int column(const struct heads *h, int i)
{
    return h->at[i] < h->end[i] ? h->src->x[h->at[i]] : INT_MAX;
}

/* The next column that holds light, or INT_MAX. */
static inline int next_column(const struct heads *h)
{
    const int a = column(h, 0), b = column(h, 1);
    const int c = column(h, 2), d = column(h, 3);
    const int ab = a < b ? a : b, cd = c < d ? c : d;
    return ab < cd ? ab : cd;
}

static uint32_t count_row(const struct gp_sources *s, int y)
{
    struct heads h = open_rows(s, y);
    uint32_t n = 0;
    for (int x = next_column(&h); x != INT_MAX; x = next_column(&h)) {
        for (int i = 0; i < GP_QUAD; i++)
            h.at[i] += column(&h, i) == x;
        n++;
    }
    return n;
}

double gp_direct_quads(const struct gp_sources *src)
{
    static const size_t MOST = 1 << 20, WANTED = 1 << 13;
    static const double FULL = 2.5; // most quads for each source
    size_t n = 0; // in every step-th row
    if (src->n >= MOST)
        return 0.0;
    // an odd step, as light may be in every other row
    const int step = 7 + 2 * (int) (src->n / WANTED);
    for (int y = 1 - GP_QUAD; y < src->h; y += step)
        n += count_row(src, y);
    const double quads =
        fmin(fmax((double) n * step, (double) src->n), GP_QUAD * (double) src->n);
    return quads <= FULL * (double) src->n ? quads : 0.0;
}

struct quading {
    const struct gp_sources *src;
    struct quads *q;
};

static void count_quads(void *ctx, int r, int thread)
{
    const struct quading *const m = ctx;
    (void) thread;
    m->q->row[r + 1] = count_row(m->src, r + 1 - GP_QUAD);
}

static void write_quads(void *ctx, int r, int thread)
{
    const struct quading *const m = ctx;
    const struct gp_sources *const s = m->src;
    struct heads h = open_rows(s, r + 1 - GP_QUAD);
    (void) thread;
    for (uint32_t n = m->q->row[r]; n < m->q->row[r + 1]; n++) {
        const int x = next_column(&h);
        m->q->x[n] = x;
        for (int i = 0; i < GP_QUAD; i++) {
            const bool lit = column(&h, i) == x;
            for (int c = 0; c < 3; c++)
                m->q->light[c][GP_QUAD * (size_t) n + (size_t) i] =
                    lit ? s->rgb[c][h.at[i]] : 0.0f;
            h.at[i] += lit;
        }
    }
}

/* Lists the quads. On failure *q holds those made so far. */
static gp_status make_quads(const struct gp_log *log,
                            const struct gp_sources *src, struct quads *q)
{
    gp_status st;
    const int rows = src->h + GP_QUAD - 1; // in which quads may start
    struct quading m = {src, q};
    GP_TRY(gp_alloc_zero(log, "direct", (size_t) rows + 1, sizeof *q->row,
                         &q->row));
    gp_parallel_do(rows, count_quads, &m);
    for (int r = 0; r < rows; r++) // counts become offsets
        q->row[r + 1] += q->row[r];
    q->n = q->row[rows];
    GP_TRY(gp_alloc(log, "direct", q->n, sizeof *q->x, &q->x));
    for (int c = 0; c < 3; c++)
        GP_TRY(gp_alloc(log, "direct", GP_QUAD * q->n, sizeof(float),
                        &q->light[c]));
    gp_parallel_do(rows, write_quads, &m);
out:
    return st;
}

/* -- the sum ----------------------------------------------------------------
 *
 * Band after band of rows, and in a band from left to right: the layer and the
 * kernel's rows are read in the order of memory. */

struct summing {
    const struct quads *in;
    const struct gp_taps *taps;
    struct gp_planes *layer;
    int w, h, panels;
    bool add;
    // scratch of each thread: the quads that reach a strip of a band, in their
    // order. k[at + y * pitch] is the kernel's sample for the strip's first
    // pixel of row y
    int32_t *at;    // in->n
    uint32_t *quad; // in->n
    uint32_t *row;  // first quad of a row: first to last row
};

/* Rows of quads whose kernel reaches row y: [*from, *to). */
static void rows_of(const struct summing *s, int y, int *from, int *to)
{
    // those that start in row sy have y - sy + cy in [0, taps->h)
    const int rows = s->h + GP_QUAD - 1;
    const int end = y + s->taps->cy + GP_QUAD, start = end - s->taps->h;
    *to = end < 0 ? 0 : end > rows ? rows : end;
    *from = start < 0 ? 0 : start > *to ? *to : start;
}

/* A range of the list, as the sums read it. */
struct quad_range {
    const int32_t *at;
    const uint32_t *quad;
    uint32_t n;
};

/* sum[row] = sum over quads of light * taps, four rows of a strip: each sample
 * of the kernel serves all four. */
GP_CLONES static void sum_quads(struct quad_range p, const float *light,
                                const float *k, ptrdiff_t row,
                                float sum[GP_QUAD * STRIP])
{
    gp_vec total[GP_QUAD][2], lost[GP_QUAD][2];
    for (int r = 0; r < GP_QUAD; r++) {
        for (int v = 0; v < 2; v++)
            total[r][v] = lost[r][v] = (gp_vec) {0};
    }
    for (uint32_t i = 0; i < p.n;) {
        const uint32_t end = p.n - i < GP_DIRECT_GROUP ? p.n
                                                       : i + GP_DIRECT_GROUP;
        gp_vec a[GP_QUAD][2];
        for (int r = 0; r < GP_QUAD; r++)
            a[r][0] = a[r][1] = (gp_vec) {0};
        for (; i < end; i++) {
            const float *const l = light + GP_QUAD * (size_t) p.quad[i];
            const float *const at = k + (row + p.at[i]);
            const gp_vec k0 = *(const gp_loose *) at;
            const gp_vec k1 = *(const gp_loose *) (at + GP_DIRECT_LANES);
            for (int r = 0; r < GP_QUAD; r++) {
                a[r][0] += l[r] * k0;
                a[r][1] += l[r] * k1;
            }
        }
        for (int r = 0; r < GP_QUAD; r++) {
            GP_ADD_KEPT(total[r][0], lost[r][0], a[r][0]);
            GP_ADD_KEPT(total[r][1], lost[r][1], a[r][1]);
        }
    }
    for (int r = 0; r < GP_QUAD; r++) {
        for (int v = 0; v < 2; v++)
            *(gp_vec *) (sum + r * STRIP + v * GP_DIRECT_LANES) = total[r][v];
    }
}

static void run_task(void *ctx, int task, int thread)
{
    const struct summing *const s = ctx;
    const struct quads *const in = s->in;
    const struct gp_taps *const t = s->taps;
    int32_t *const at = s->at + (size_t) thread * in->n;
    uint32_t *const quad = s->quad + (size_t) thread * in->n;
    uint32_t *const row = s->row + thread * (s->h + GP_QUAD);
    const int x0 = task % s->panels * PANEL, y0 = task / s->panels * BAND;
    const int x1 = x0 + PANEL < s->w ? x0 + PANEL : s->w;
    const int y1 = y0 + BAND < s->h ? y0 + BAND : s->h;
    int first, end, from, to;
    rows_of(s, y0, &first, &to);
    rows_of(s, y1 - 1, &from, &end);
    // reached pixels of a source at x: [x - cx, x - cx + w)
    const int reach = t->cx - t->w + 1;
    for (int x = x0; x < x1; x += STRIP) {
        // the quads that reach pixels [x, x + STRIP) of the band
        uint32_t n = 0;
        for (int r = first; r < end; r++) {
            const int y = r + 1 - GP_QUAD;
            const uint32_t past = in->row[r + 1];
            const int base = (t->cy - y) * (int) t->pitch + x + t->cx +
                             GP_TAPS_PAD;
            row[r - first] = n;
            uint32_t i = gp_first_from(in->x, in->row[r], past, x + reach);
            for (; i < past && in->x[i] < x + STRIP + t->cx; i++) {
                at[n] = base - in->x[i];
                quad[n++] = i;
            }
        }
        row[end - first] = n;
        // rows y to y + 3 of the strip
        const int cols = s->w - x < STRIP ? s->w - x : STRIP;
        for (int y = y0; y < y1; y += GP_QUAD) {
            rows_of(s, y, &from, &to);
            const uint32_t start = row[from - first];
            const struct quad_range p = {
                at + start, quad + start, row[to - first] - start,
            };
            if (s->add && !p.n)
                continue;
            float sum[3][GP_QUAD * STRIP]
                __attribute__((aligned(4 * GP_DIRECT_LANES)));
            for (int c = 0; c < 3; c++) { // comes while the sum is made
                for (int r = 0; r < GP_QUAD && y + r < s->h; r++)
                    __builtin_prefetch(s->layer->c[c] +
                                       (size_t) (y + r) * (size_t) s->w + x, 1);
            }
            for (int c = 0; c < 3; c++)
                sum_quads(p, in->light[c], t->k[c],
                          (ptrdiff_t) y * (ptrdiff_t) t->pitch, sum[c]);
            for (int i = 0; i < 3 * GP_QUAD; i++) {
                const int c = i / GP_QUAD, r = i % GP_QUAD;
                if (y + r >= s->h)
                    continue;
                const float *const of = sum[c] + r * STRIP;
                float *const out =
                    s->layer->c[c] + (size_t) (y + r) * (size_t) s->w + x;
                for (int j = 0; j < cols; j++)
                    out[j] = s->add ? out[j] + of[j] : of[j];
            }
        }
    }
}

gp_status gp_quads_sum(const struct gp_log *log, const struct gp_sources *src,
    const struct gp_taps *taps, bool add, struct gp_planes *layer)
{
    gp_status st;
    const size_t threads = (size_t) gp_threads();
    const size_t rows = (size_t) src->h + GP_QUAD;
    struct quads q = {0};
    struct summing s = {
        .in = &q, .taps = taps, .layer = layer, .w = src->w, .h = src->h,
        .panels = (src->w + PANEL - 1) / PANEL, .add = add,
    };
    GP_TRY(make_quads(log, src, &q));
    GP_TRY(gp_alloc(log, "direct", threads * q.n, sizeof *s.at, &s.at));
    GP_TRY(gp_alloc(log, "direct", threads * q.n, sizeof *s.quad, &s.quad));
    GP_TRY(gp_alloc(log, "direct", threads * rows, sizeof *s.row, &s.row));
    gp_parallel_do(s.panels * ((src->h + BAND - 1) / BAND), run_task, &s);
out:
    gp_free(q.row);
    gp_free(q.x);
    for (int c = 0; c < 3; c++)
        gp_free(q.light[c]);
    gp_free(s.at);
    gp_free(s.quad);
    gp_free(s.row);
    return st;
}
