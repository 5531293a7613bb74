#include "glare/sensors.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bright.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    BLOCK = 16,  // rows a task takes
    WIDE = 4,    // doubles summed side by side
    TABLES = 4,  // that neighbours are counted in: a sky has them in one bin
};

typedef double wide __attribute__((vector_size(8 * WIDE)));
typedef float narrow
    __attribute__((vector_size(4 * WIDE), aligned(4), may_alias));
typedef int32_t ints __attribute__((vector_size(4 * WIDE)));

/* Darkness is found to within a sixteenth, on a fixed grid. */
enum {
    GRID = 16384,    // pixels, about
    DARK_SHIFT = 19, // leaves sign, exponent and 4 bits of mantissa
    DARK_BINS = 1 << 13,
};

/* What one block of rows found; added up in the order of the blocks. */
struct block_sum {
    long long nonfinite, clamped;
    wide flux[3], energy[3];
    narrow brightest;
    int x0, x1; // columns that hold light
    uint32_t count[GP_SOURCE_BINS];
};

struct sense {
    const struct gp_sensor_params *p;
    struct gp_bright_rule rule;
    int w, h;
    float *rgb[3];
    struct block_sum *block;
    struct gp_sources *out;
    uint32_t (*dark)[DARK_BINS]; // of each thread: luminance of the grid
    size_t step;                 // of the grid, in pixels
};

float gp_bright_pass(const struct gp_sensor_params *p, float y)
{
    if (p->knee <= 0.0f)
        return y > p->threshold ? 1.0f : 0.0f;
    const float lo = p->threshold * (1.0f - p->knee);
    const float hi = p->threshold * (1.0f + p->knee);
    if (!(y > lo))
        return 0.0f;
    if (y >= hi)
        return 1.0f;
    const float t = (y - lo) / (hi - lo);
    return t * t * (3.0f - 2.0f * t); // smoothstep: slope 0 at both ends
}

int gp_source_bin(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return (int) (bits >> 22) & (GP_SOURCE_BINS - 1);
}

float gp_source_bin_start(int bin)
{
    const uint32_t bits = (uint32_t) bin << 22;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline __attribute__((always_inline)) float clean(float v, float max)
{
    v = v != v ? 0.0f : v;
    v = v > max ? max : v;
    return v < -FLT_MAX ? 0.0f : v;
}

/* Counts one row's bad pixels and, if there are none, its bright ones. No
 * branch and no store, so that it becomes vector code and the frame is only
 * read: bad pixels are rare. */
GP_CLONES static void count_row(const float *restrict r,
                                const float *restrict g,
                                const float *restrict b, int w, float max,
                                const float *restrict weight, float open,
                                int *nonfinite, int *clamped, int *bright)
{
    int bad = 0, over = 0, lit_up = 0;
    for (int x = 0; x < w; x++) {
        const float vr = r[x], vg = g[x], vb = b[x];
        const int finite = (fabsf(vr) <= FLT_MAX) & (fabsf(vg) <= FLT_MAX) &
                           (fabsf(vb) <= FLT_MAX);
        const int large = ((vr > max) & (vr <= FLT_MAX)) |
                          ((vg > max) & (vg <= FLT_MAX)) |
                          ((vb > max) & (vb <= FLT_MAX));
        bad += !finite;
        over += large;
        lit_up += gp_lit_luminance(weight, vr, vg, vb) > open;
    }
    *nonfinite = bad;
    *clamped = over;
    *bright = lit_up;
}

static void clean_row(float *v, int w, float max)
{
    for (int x = 0; x < w; x++)
        v[x] = clean(v[x], max);
}

/* Counts the grid's pixels of one row, which is in the cache by now: from
 * every k-th pixel of the frame, about GRID in all. */
static void sample_row(const struct sense *s, size_t at, uint32_t *count)
{
    const size_t end = at + (size_t) s->w;
    for (size_t i = (at + s->step - 1) / s->step * s->step; i < end;
         i += s->step) {
        const float y = gp_lit_luminance(s->rule.weight, s->rgb[0][i],
                                         s->rgb[1][i], s->rgb[2][i]);
        if (!(y > 0.0f))
            continue;
        uint32_t bits;
        memcpy(&bits, &y, sizeof bits);
        count[bits >> DARK_SHIFT]++;
    }
}

static void clean_block(void *ctx, int i, int thread)
{
    struct sense *const s = ctx;
    const int end = (i + 1) * BLOCK < s->h ? (i + 1) * BLOCK : s->h;
    for (int y = i * BLOCK; y < end; y++) {
        const size_t at = (size_t) y * (size_t) s->w;
        float *const r = s->rgb[0] + at, *const g = s->rgb[1] + at;
        float *const b = s->rgb[2] + at;
        int bad, over, bright, none;
        count_row(r, g, b, s->w, s->p->max_value, s->rule.weight,
                  s->rule.open, &bad, &over, &bright);
        if (bad || over) {
            clean_row(r, s->w, s->p->max_value);
            clean_row(g, s->w, s->p->max_value);
            clean_row(b, s->w, s->p->max_value);
            count_row(r, g, b, s->w, s->p->max_value, s->rule.weight,
                      s->rule.open, &none, &none, &bright);
        }
        sample_row(s, at, s->dark[thread]);
        s->out->row[y + 1] = (uint32_t) bright;
        s->block[i].nonfinite += bad;
        s->block[i].clamped += over;
    }
}

/* -- the list ---------------------------------------------------------------*/

static void apply_knee(const struct sense *s, int n, struct gp_bright *c)
{
    for (int i = 0; i < n; i++) {
        const float pass = gp_bright_pass(
            s->p, gp_lit_luminance(s->rule.weight, c->rgb[0][i],
                                   c->rgb[1][i], c->rgb[2][i]));
        for (int k = 0; k < 3; k++)
            c->rgb[k][i] *= pass;
    }
}

static inline __attribute__((always_inline)) narrow larger(narrow a, narrow b)
{
    const ints which = a > b;
    return (narrow) ((which & (ints) a) | (~which & (ints) b));
}

/* Adds n sources to the sums, each lane by itself, in the order of the row:
 * the same bits with any vectors. */
GP_CLONES static void sum_row(struct gp_bright *c, int n, float *largest,
                              struct block_sum *sum)
{
    for (int i = n; i % WIDE; i++) // dark lanes fill the last vector
        c->rgb[0][i] = c->rgb[1][i] = c->rgb[2][i] = 0.0f;
    for (int k = 0; k < 3; k++) {
        wide flux = sum->flux[k], energy = sum->energy[k];
        for (int i = 0; i < n; i += WIDE) {
            const wide v = __builtin_convertvector(
                *(const narrow *) (c->rgb[k] + i), wide);
            flux += v;
            energy += v * v;
        }
        sum->flux[k] = flux;
        sum->energy[k] = energy;
    }
    narrow brightest = sum->brightest;
    for (int i = 0; i < n; i += WIDE) {
        const narrow r = *(const narrow *) (c->rgb[0] + i);
        const narrow g = *(const narrow *) (c->rgb[1] + i);
        const narrow b = *(const narrow *) (c->rgb[2] + i);
        const narrow v = larger(larger(r, g), b);
        *(narrow *) (largest + i) = v;
        brightest = larger(v, brightest);
    }
    sum->brightest = brightest;
}

/* Writes the sources of one row; its place in the list is known by now. */
static void list_row(const struct sense *s, int y, struct block_sum *sum,
                     uint32_t count[TABLES][GP_SOURCE_BINS])
{
    const struct gp_sources *const o = s->out;
    uint32_t at = o->row[y];
    struct gp_bright c;
    float largest[GP_BRIGHT_MOST + GP_BRIGHT_LANES]; // channel of each
    for (int x0 = 0; x0 < s->w && at < o->row[y + 1]; x0 += GP_BRIGHT_MOST) {
        const size_t first = (size_t) y * (size_t) s->w + (size_t) x0;
        const float *const rgb[3] = {s->rgb[0] + first, s->rgb[1] + first,
                                     s->rgb[2] + first};
        const int rest = s->w - x0;
        const int n = gp_bright_find(
            &s->rule, rgb, x0,
            rest < GP_BRIGHT_MOST ? rest : GP_BRIGHT_MOST, &c);
        if (!n)
            continue;
        if (s->p->knee > 0.0f)
            apply_knee(s, n, &c);
        sum_row(&c, n, largest, sum);
        for (int i = 0; i < n; i++)
            count[i % TABLES][gp_source_bin(largest[i])]++;
        sum->x0 = c.x[0] < sum->x0 ? c.x[0] : sum->x0;
        sum->x1 = c.x[n - 1] + 1 > sum->x1 ? c.x[n - 1] + 1 : sum->x1;
        memcpy(o->x + at, c.x, (size_t) n * sizeof *o->x);
        for (int k = 0; k < 3; k++)
            memcpy(o->rgb[k] + at, c.rgb[k], (size_t) n * sizeof *c.rgb[k]);
        at += (uint32_t) n;
    }
}

static void list_block(void *ctx, int i, int thread)
{
    struct sense *const s = ctx;
    (void) thread;
    struct block_sum *const sum = &s->block[i];
    uint32_t count[TABLES][GP_SOURCE_BINS];
    sum->x0 = s->w;
    const int end = (i + 1) * BLOCK < s->h ? (i + 1) * BLOCK : s->h;
    if (s->out->row[end] == s->out->row[i * BLOCK])
        return;
    memset(count, 0, sizeof count);
    for (int y = i * BLOCK; y < end; y++) {
        if (s->out->row[y + 1] > s->out->row[y])
            list_row(s, y, sum, count);
    }
    for (int t = 0; t < TABLES; t++) {
        for (int k = 0; k < GP_SOURCE_BINS; k++)
            sum->count[k] += count[t][k];
    }
}

/* The luminance under which 0.1 % of the grid's pixels with light lie. */
static double darkest(const struct sense *s, int threads)
{
    uint32_t total = 0, below = 0;
    for (int t = 1; t < threads; t++) {
        for (int b = 0; b < DARK_BINS; b++)
            s->dark[0][b] += s->dark[t][b];
    }
    for (int b = 0; b < DARK_BINS; b++)
        total += s->dark[0][b];
    for (uint32_t b = 0; total && b < DARK_BINS; b++) {
        below += s->dark[0][b];
        if (below * 1000ull >= total) {
            const uint32_t bits = b << DARK_SHIFT;
            float y;
            memcpy(&y, &bits, sizeof y);
            return (double) y;
        }
    }
    return 0.0;
}

static double total(wide v)
{
    return (v[0] + v[1]) + (v[2] + v[3]);
}

static void add_up(const struct sense *s, int blocks)
{
    struct gp_sources *const o = s->out;
    struct gp_rect box = {s->w, s->h, 0, 0};
    for (int i = 0; i < blocks; i++) {
        const struct block_sum *const b = &s->block[i];
        o->nonfinite += b->nonfinite;
        o->clamped += b->clamped;
        for (int k = 0; k < 3; k++) {
            o->flux[k] += total(b->flux[k]);
            o->energy[k] += total(b->energy[k]);
        }
        for (int k = 0; k < WIDE; k++)
            o->brightest = b->brightest[k] > o->brightest ? b->brightest[k]
                                                          : o->brightest;
        for (int k = 0; k < GP_SOURCE_BINS; k++)
            o->count[k] += b->count[k];
        box.x0 = b->x0 < box.x0 ? b->x0 : box.x0;
        box.x1 = b->x1 > box.x1 ? b->x1 : box.x1;
    }
    for (int y = 0; y < s->h; y++) {
        if (o->row[y + 1] > o->row[y]) {
            box.y0 = y < box.y0 ? y : box.y0;
            box.y1 = y + 1;
        }
    }
    o->box = o->n ? box : (struct gp_rect) {0};
}

gp_status gp_sense(const struct gp_log *log, const struct gp_sensor_params *p,
                   struct gp_frame *f, struct gp_sources *out)
{
    gp_status st;
    void *v;
    struct gp_sources o = {
        .w = gp_frame_w(f), .h = gp_frame_h(f),
        .x0 = f->data.x0, .y0 = f->data.y0,
        .luminance = {f->luminance[0], f->luminance[1], f->luminance[2]},
    };
    struct sense s = {
        .p = p, .w = o.w, .h = o.h, .out = &o,
        .rgb = {f->rgb.c[0], f->rgb.c[1], f->rgb.c[2]},
    };
    const int blocks = (o.h + BLOCK - 1) / BLOCK, threads = gp_threads();
    s.step = (size_t) o.w * (size_t) o.h / GRID + 1;
    gp_bright_rule_make(p->knee > 0.0f ? p->threshold * (1.0f - p->knee)
                                       : p->threshold,
                        f->luminance, &s.rule);
    GP_TRY(gp_alloc_zero(log, "sensors", (size_t) blocks + 1,
                         sizeof *s.block, &v));
    s.block = v;
    GP_TRY(gp_alloc_zero(log, "sensors", (size_t) threads, sizeof *s.dark,
                         &v));
    s.dark = v;
    GP_TRY(gp_alloc_zero(log, "sensors", (size_t) o.h + 1, sizeof *o.row, &v));
    o.row = v;
    gp_parallel_do(blocks, clean_block, &s);
    for (int y = 0; y < o.h; y++) // counts become offsets
        o.row[y + 1] += o.row[y];
    o.n = o.row[o.h];
    GP_TRY(gp_alloc(log, "sources", o.n, sizeof *o.x, &v));
    o.x = v;
    for (int k = 0; k < 3; k++) {
        GP_TRY(gp_alloc(log, "sources", o.n, sizeof *o.rgb[k], &v));
        o.rgb[k] = v;
    }
    if (o.n)
        gp_parallel_do(blocks, list_block, &s);
    add_up(&s, blocks);
    o.darkest = darkest(&s, threads);
    *out = o;
    o = (struct gp_sources) {0};
out:
    gp_free(s.block);
    gp_free(s.dark);
    gp_sources_free(&o);
    return st;
}

void gp_sources_free(struct gp_sources *s)
{
    gp_free(s->row);
    gp_free(s->x);
    for (int k = 0; k < 3; k++)
        gp_free(s->rgb[k]);
    *s = (struct gp_sources) {0};
}

gp_status gp_sources_planes(const struct gp_log *log,
                            const struct gp_sources *s, struct gp_planes *p)
{
    const size_t n = (size_t) s->w * (size_t) s->h;
    gp_status st = gp_planes_make(log, "sources", n, p);
    if (st)
        return st;
    for (int k = 0; k < 3; k++) {
        memset(p->c[k], 0, n * sizeof(float));
        for (int y = 0; y < s->h; y++) {
            float *const row = p->c[k] + (size_t) y * (size_t) s->w;
            for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++)
                row[s->x[i]] = s->rgb[k][i];
        }
    }
    return GP_OK;
}
