// SPDX-License-Identifier: Apache-2.0
#include "glare/fft/pass.h"

#include "core/cpu.h"
#include "core/minmax.h"
#include "glare/fft/lines.h"

#include <string.h>

enum { ROWS = 2 * LINES }; // of a block of lines

/* Samples from row to row of a block in scratch: a cache line over n, as rows
 * must not share the sets of a cache; they end in the gap after the points. */
static size_t pitch_of(int n)
{
    return (size_t) n + 16;
}

/* Samples of a row in float, of as many points as there are lines. */
typedef float flat
    __attribute__((vector_size(4 * LINES), aligned(4), may_alias));

/* LINES vectors to those of the same lane of each: perfect shuffles. */
INLINE void transpose(lines v[LINES])
{
    for (int round = 1; round < LINES; round *= 2) {
        lines w[LINES];
        for (int i = 0; i < LINES / 2; i++) {
            w[2 * i] = __builtin_shufflevector(v[i], v[i + LINES / 2], LOW);
            w[2 * i + 1] =
                __builtin_shufflevector(v[i], v[i + LINES / 2], HIGH);
        }
        memcpy(v, w, sizeof w);
    }
}

/* Rows of n samples, `pitch` apart, to the re of n points from the first row, to
 * their im from the second, and so on. */
GP_CLONES_WIDE static void weave(const float *rows, size_t pitch, int n,
                                 struct point *z)
{
    for (int x = 0; x < n; x += LINES) {
        lines re[LINES], im[LINES];
        for (size_t i = 0; i < LINES; i++) {
            const float *const row = rows + 2 * i * pitch + x;
            re[i] = __builtin_convertvector(*(const flat *) row, lines);
            im[i] =
                __builtin_convertvector(*(const flat *) (row + pitch), lines);
        }
        transpose(re);
        transpose(im);
        for (int i = 0; i < LINES; i++)
            z[x + i] = (struct point) {re[i], im[i]};
    }
}

/* The inverse, of points whose re and im are exchanged. */
GP_CLONES_WIDE static void unweave(const struct point *z, int n, size_t pitch,
                                   float *rows)
{
    for (int x = 0; x < n; x += LINES) {
        lines re[LINES], im[LINES];
        for (int i = 0; i < LINES; i++) {
            re[i] = z[x + i].im;
            im[i] = z[x + i].re;
        }
        transpose(re);
        transpose(im);
        for (size_t i = 0; i < LINES; i++) {
            float *const row = rows + 2 * i * pitch + x;
            *(flat *) row = __builtin_convertvector(re[i], flat);
            *(flat *) (row + pitch) = __builtin_convertvector(im[i], flat);
        }
    }
}

/* Spectra z of LINES pairs of rows to twice the spectra of the rows: of block b
 * of columns to m[b * pitch + row]. */
GP_CLONES_WIDE static void part(const struct point *z, int n, int blocks,
                                size_t pitch, struct point *m)
{
    for (int b = 0; b < blocks; b++, m += pitch) {
        struct {
            lines re[LINES], im[LINES];
        } first, second;
        for (int i = 0; i < LINES; i++) {
            const int k = b * LINES + i;
            const struct point f = z[k], r = z[k ? n - k : 0];
            first.re[i] = f.re + r.re;
            first.im[i] = f.im - r.im;
            second.re[i] = f.im + r.im; // times -i
            second.im[i] = r.re - f.re;
        }
        transpose(first.re);
        transpose(first.im);
        transpose(second.re);
        transpose(second.im);
        for (int i = 0; i < LINES; i++) {
            m[2 * i] = (struct point) {first.re[i], first.im[i]};
            m[2 * i + 1] = (struct point) {second.re[i], second.im[i]};
        }
    }
}

/* The inverse, to points whose re and im are exchanged. */
GP_CLONES_WIDE static void join(const struct point *m, size_t pitch, int blocks,
                                int n, struct point *z)
{
    for (int b = 0; b < blocks; b++, m += pitch) {
        struct {
            lines re[LINES], im[LINES];
        } first, second;
        for (int i = 0; i < LINES; i++) {
            first.re[i] = m[2 * i].re;
            first.im[i] = m[2 * i].im;
            second.re[i] = m[2 * i + 1].re;
            second.im[i] = m[2 * i + 1].im;
        }
        transpose(first.re);
        transpose(first.im);
        transpose(second.re);
        transpose(second.im);
        for (int i = 0; i < LINES; i++) {
            const int k = b * LINES + i;
            if (2 * k > n)
                break;
            if (k) // the conjugates, of column -k
                z[n - k] = (struct point) {second.re[i] - first.im[i],
                                           first.re[i] + second.im[i]};
            z[k] = (struct point) {first.im[i] + second.re[i],
                                   first.re[i] - second.im[i]};
        }
    }
}

/* z times a kernel's spectrum, re and im exchanged. */
GP_CLONES_WIDE static void times(struct point *restrict z,
                                 const struct point *restrict k, int n)
{
    for (int y = 0; y < n; y++)
        z[y] = (struct point) {z[y].re * k[y].im + z[y].im * k[y].re,
                               z[y].re * k[y].re - z[y].im * k[y].im};
}

GP_CLONES_WIDE static void times_real(struct point *restrict z,
                                      const lines *restrict k, int n)
{
    for (int y = 0; y < n; y++)
        z[y] = (struct point) {z[y].im * k[y], z[y].re * k[y]};
}

// -- tasks --------------------------------------------------------------------

/* Scratch of a task, and its place. */
struct task {
    int c, block; // channel, block of lines
    struct point *z, *other;
};

static struct task open_task(const struct gp_pass *s, int i, int thread)
{
    const size_t room = gp_transform_room(s->t->n);
    char *const scratch =
        s->scratch + (size_t) s->arrays * room * (size_t) thread;
    return (struct task) {
        s->req->channel + i / s->tasks,
        i % s->tasks,
        (void *) scratch,
        (void *) (scratch + room),
    };
}

/* Returns the other array. */
static struct point *transform(const struct gp_pass *s, struct task *t)
{
    struct point *const from = t->z, *const to = t->other;
    t->z = (void *) OF(transform)(s->t, (void *) from, (void *) to);
    t->other = t->z == from ? to : from;
    return t->z;
}

/* Block b of a plane of complex numbers. */
static struct point *block_of(const struct gp_fft_matrix *m, int c, int b)
{
    return (struct point *) m->z[c] + (size_t) b * m->pitch;
}

void OF(rows_in)(void *ctx, int i, int thread)
{
    const struct gp_pass *const s = ctx;
    struct task t = open_task(s, i, thread);
    const int n = s->t->n, first = t.block * ROWS;
    float *const rows = (void *) t.other;
    const size_t pitch = pitch_of(n);
    memset(rows, 0, sizeof *rows * ROWS * pitch);
    for (int j = 0; j < ROWS && first + j < s->rows.n; j++)
        s->load(s->ctx, t.c, first + j, rows + (size_t) j * pitch);
    weave(rows, pitch, n, t.z);
    part(transform(s, &t), n, s->m->blocks, s->m->pitch,
         block_of(s->m, t.c, 0) + first);
}

/* Rows of a block to their places on a torus of n points, dark between them. */
static void place_rows(const struct gp_fft_rows *r, int n,
                       const struct point *from, struct point *to)
{
    int at = 0, j = 0; // places under `at` are written; the first that wraps
    while (j < r->n && r->place[j] >= r->place[0])
        j++;
    for (int i = 0; i < r->n; i++, j++) {
        const int row = j < r->n ? j : j - r->n, place = r->place[row];
        memset(to + at, 0, sizeof *to * (size_t) (place - at));
        to[place] = from[row];
        at = place + 1;
    }
    memset(to + at, 0, sizeof *to * (size_t) (n - at));
}

GP_CLONES_WIDE static void scale(struct point *z, real by, int n)
{
    for (int y = 0; y < n; y++)
        z[y] = (struct point) {z[y].re * by, z[y].im * by};
}

/* Makes a block of a kernel's spectrum of the block's rows: t->z, of a real one re
 * of all points, one after the other. */
static void make_block(const struct gp_pass *s, const struct point *block,
                       struct task *t)
{
    const struct gp_fft_kernel *const k = s->kernel;
    const int n = s->t->n;
    place_rows(&k->rows, n, block, t->z);
    for (int y = 1; k->m.of.real && y < k->rows.n; y++)
        t->z[n - y] = (struct point) {t->z[y].re, -t->z[y].im};
    scale(transform(s, t), (real) k->scale, n);
    for (int y = 0; k->m.of.real && y < n; y++)
        ((lines *) t->z)[y] = t->z[y].re;
}

void OF(make_kernel)(void *ctx, int i, int thread)
{
    const struct gp_pass *const s = ctx;
    const struct gp_fft_matrix *const m = &s->kernel->m;
    struct task t = open_task(s, i, thread);
    struct point *const block = block_of(m, t.c, t.block);
    make_block(s, block, &t);
    memcpy(block, t.z,
           (m->of.real ? sizeof(lines) : sizeof *block) * (size_t) s->t->n);
}

void OF(multiply)(void *ctx, int i, int thread)
{
    const struct gp_pass *const s = ctx;
    struct task t = open_task(s, i, thread), own = t;
    const int n = s->t->n, upper = gp_min(s->count, n - s->first);
    const struct gp_fft_kernel *const kernel = s->kernel;
    const struct gp_fft_matrix *const m = &kernel->m;
    struct point *const block = block_of(s->m, t.c, t.block);
    const struct point *k = block_of(m, m->z[t.c] ? t.c : 0, t.block);
    if (!kernel->made) {
        own.z = t.z + 2 * gp_transform_room(n) / sizeof *t.z;
        own.other = t.other + 2 * gp_transform_room(n) / sizeof *t.z;
        make_block(s, k, &own);
        k = own.z;
    }
    place_rows(&s->rows, n, block, t.z);
    if (m->of.real)
        times_real(transform(s, &t), (const lines *) k, n);
    else
        times(transform(s, &t), k, n);
    const struct point *const z = transform(s, &t);
    for (int y = 0; y < s->count; y++) {
        const struct point *const from =
            z + (y < upper ? s->first + y : y - upper);
        block[y] = (struct point) {from->im, from->re};
    }
}

void OF(rows_out)(void *ctx, int i, int thread)
{
    const struct gp_pass *const s = ctx;
    struct task t = open_task(s, i, thread);
    const int n = s->t->n, first = t.block * ROWS;
    const int past = first + ROWS - s->rows.n; // rows of the last lines, dark
    for (int b = 0; past > 0 && b < s->m->blocks; b++)
        memset(block_of(s->m, t.c, b) + s->rows.n, 0,
               sizeof(struct point) * (size_t) past);
    join(block_of(s->m, t.c, 0) + first, s->m->pitch, s->m->blocks, n, t.z);
    transform(s, &t);
    float *const rows = (void *) t.other;
    const size_t pitch = pitch_of(n);
    unweave(t.z, n, pitch, rows);
    for (int j = 0; j < ROWS && first + j < s->rows.n; j++)
        s->store(s->ctx, t.c, first + j, thread, rows + (size_t) j * pitch);
}
