#include "glare/sensors.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { BLOCK = 16 }; // rows a task takes

/* What one block of rows found; added up in the order of the blocks. */
struct block_sum {
    long long nonfinite, clamped;
    double flux[3], energy[3];
    float brightest;
    int x0, x1; // columns that hold light
    uint32_t count[GP_SOURCE_BINS];
};

struct sense {
    const struct gp_sensor_params *p;
    const float *weight;
    int w, h;
    float *rgb[3];
    float open; // luminance over which a pixel may be a source
    struct block_sum *block;
    struct gp_sources *out;
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

static inline __attribute__((always_inline)) float lit(float v)
{
    return v > 0.0f ? v : 0.0f;
}

static inline __attribute__((always_inline)) float
luminance_of(const float weight[3], float r, float g, float b)
{
    return weight[0] * lit(r) + weight[1] * lit(g) + weight[2] * lit(b);
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
        lit_up += luminance_of(weight, vr, vg, vb) > open;
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

static void clean_block(void *ctx, int i, int thread)
{
    struct sense *const s = ctx;
    (void) thread;
    const int end = (i + 1) * BLOCK < s->h ? (i + 1) * BLOCK : s->h;
    for (int y = i * BLOCK; y < end; y++) {
        const size_t at = (size_t) y * (size_t) s->w;
        float *const r = s->rgb[0] + at, *const g = s->rgb[1] + at;
        float *const b = s->rgb[2] + at;
        int bad, over, bright, none;
        count_row(r, g, b, s->w, s->p->max_value, s->weight, s->open, &bad,
                  &over, &bright);
        if (bad || over) {
            clean_row(r, s->w, s->p->max_value);
            clean_row(g, s->w, s->p->max_value);
            clean_row(b, s->w, s->p->max_value);
            count_row(r, g, b, s->w, s->p->max_value, s->weight, s->open,
                      &none, &none, &bright);
        }
        s->out->row[y + 1] = (uint32_t) bright;
        s->block[i].nonfinite += bad;
        s->block[i].clamped += over;
    }
}

/* Writes the sources of one row; its place in the list is known by now. */
static void list_row(const struct sense *s, int y, struct block_sum *sum)
{
    const struct gp_sources *const o = s->out;
    const size_t at = (size_t) y * (size_t) s->w;
    uint32_t n = o->row[y];
    for (int x = 0; x < s->w && n < o->row[y + 1]; x++) {
        float c[3];
        for (int k = 0; k < 3; k++)
            c[k] = lit(s->rgb[k][at + (size_t) x]);
        const float lum = luminance_of(s->weight, c[0], c[1], c[2]);
        if (!(lum > s->open))
            continue;
        const float pass = gp_bright_pass(s->p, lum);
        float largest = 0.0f;
        for (int k = 0; k < 3; k++) {
            const float v = c[k] * pass;
            o->rgb[k][n] = v;
            sum->flux[k] += (double) v;
            sum->energy[k] += (double) v * (double) v;
            largest = v > largest ? v : largest;
        }
        sum->brightest = fmaxf(sum->brightest, largest);
        sum->count[gp_source_bin(largest)]++;
        sum->x0 = x < sum->x0 ? x : sum->x0;
        sum->x1 = x + 1 > sum->x1 ? x + 1 : sum->x1;
        o->x[n++] = x;
    }
}

static void list_block(void *ctx, int i, int thread)
{
    struct sense *const s = ctx;
    (void) thread;
    struct block_sum *const sum = &s->block[i];
    sum->x0 = s->w;
    const int end = (i + 1) * BLOCK < s->h ? (i + 1) * BLOCK : s->h;
    for (int y = i * BLOCK; y < end; y++) {
        if (s->out->row[y + 1] > s->out->row[y])
            list_row(s, y, sum);
    }
}

/* The luminance under which 0.1 % of the pixels with light lie, to within a
 * sixteenth, from every k-th pixel of a fixed grid of about 16 thousand. */
static double darkest(const struct sense *s)
{
    enum { BINS = 1 << 13, SHIFT = 19 }; // sign, exponent, 4 bits of mantissa
    static const size_t WANTED = 16384;
    uint32_t count[BINS] = {0}, total = 0;
    const size_t n = (size_t) s->w * (size_t) s->h;
    const size_t step = n / WANTED + 1;
    for (size_t i = 0; i < n; i += step) {
        const float y = luminance_of(s->weight, s->rgb[0][i], s->rgb[1][i],
                                     s->rgb[2][i]);
        if (!(y > 0.0f))
            continue;
        uint32_t bits;
        memcpy(&bits, &y, sizeof bits);
        count[bits >> SHIFT]++;
        total++;
    }
    uint32_t below = 0;
    for (uint32_t b = 0; total && b < BINS; b++) {
        below += count[b];
        if (below * 1000ull >= total) {
            const uint32_t bits = b << SHIFT;
            float y;
            memcpy(&y, &bits, sizeof y);
            return (double) y;
        }
    }
    return 0.0;
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
            o->flux[k] += b->flux[k];
            o->energy[k] += b->energy[k];
        }
        o->brightest = b->brightest > o->brightest ? b->brightest
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
    struct gp_sources o = {.w = gp_frame_w(f), .h = gp_frame_h(f)};
    struct sense s = {
        .p = p, .weight = f->luminance, .w = o.w, .h = o.h, .out = &o,
        .rgb = {f->rgb.c[0], f->rgb.c[1], f->rgb.c[2]},
        .open = p->knee > 0.0f ? p->threshold * (1.0f - p->knee)
                               : p->threshold,
    };
    const int blocks = (o.h + BLOCK - 1) / BLOCK;
    GP_TRY(gp_alloc_zero(log, "sensors", (size_t) blocks + 1,
                         sizeof *s.block, &v));
    s.block = v;
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
    o.darkest = darkest(&s);
    *out = o;
    o = (struct gp_sources) {0};
out:
    gp_free(s.block);
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
