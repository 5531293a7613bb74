// SPDX-License-Identifier: Apache-2.0
/* The sources' reach: pixels where a float transform leaves rounding noise and
 * the sum itself has no term. It is the support of the light dilated by the
 * support of the kernel, by bits of rows.
 *
 * A row of the frame is reached through each row of the kernel by another row
 * of light. Rows of the kernel are taken together where that decides: what
 * all of them hold reaches at least that far, and what one of them holds at
 * most that far, from all their rows of light in one. Only where both differ,
 * the rows are halved. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/fft_priv.h"

#include <limits.h>
#include <pthread.h>
#include <string.h>

// -- bits ---------------------------------------------------------------------

static int lowest(uint64_t v)
{
    return __builtin_ctzll(v);
}

static int highest(uint64_t v)
{
    return 63 - __builtin_clzll(v);
}

/* Sets bits [from, to), those in words [first, end). */
static void set_bits(uint64_t *bits, int first, int end, int from, int to)
{
    from = gp_max(from, 64 * first);
    to = gp_min(to, 64 * end);
    if (from >= to)
        return;
    const int a = from / 64, b = (to - 1) / 64;
    const uint64_t head = ~0ull << from % 64;
    const uint64_t tail = ~0ull >> (63 - (to - 1) % 64);
    bits[a] |= a == b ? head & tail : head;
    for (int i = a + 1; i < b; i++)
        bits[i] = ~0ull;
    if (b > a)
        bits[b] |= tail;
}

/* Sets bits x + o, those in words [first, end) of `out`, for all bits x of
 * `light` and o in `run`. */
static void dilate(const uint64_t *light, int words, struct gp_fft_run run,
                   uint64_t *out, int first, int end)
{
    const int length = run.to - run.from;
    const int start = gp_max(64 * first - run.to + 1, 0) / 64;
    const int past = gp_min((gp_max(64 * end - run.from, 0) + 63) / 64, words);
    int from = 0, to = 0; // found and not set yet
    for (int i = start; i < past; i++) {
        if (!light[i])
            continue;
        if (length >= 64) { // bridges every gap of a word
            const int next = 64 * i + lowest(light[i]) + run.from;
            if (next > to) {
                set_bits(out, first, end, from, to);
                from = next;
            }
            to = 64 * i + highest(light[i]) + run.to;
            continue;
        }
        uint64_t bits[3] = {light[i]};
        for (int n = 1, s; n < length; n += s) {
            s = gp_min(n, length - n);
            bits[1] |= bits[1] << s | bits[0] >> (64 - s);
            bits[0] |= bits[0] << s;
        }
        const int at = 64 * i + run.from, shift = at & 63;
        const int word = (at - shift) / 64;
        if (shift) {
            bits[2] = bits[1] >> (64 - shift);
            bits[1] = bits[1] << shift | bits[0] >> (64 - shift);
            bits[0] <<= shift;
        }
        for (int j = 0; j < 3; j++) {
            if (word + j >= first && word + j < end)
                out[word + j] |= bits[j];
        }
    }
    set_bits(out, first, end, from, to);
}

// -- the kernel's support -----------------------------------------------------

void gp_fft_shape_free(struct gp_fft_shape *s)
{
    gp_free(s->row);
    gp_free(s->run);
    gp_free(s->node);
    *s = (struct gp_fft_shape) {0};
}

/* Rows [from, to) of a node. */
struct node_rows {
    int from, to;
};

/* Fills in node i of those rows; its halves, which are after it, are there. */
static void make_node(const struct gp_fft_shape *s, struct node_rows rows,
                      struct gp_fft_node *node)
{
    struct gp_fft_node n = {{0, 0}, {0, 0}, true};
    const int from = rows.from, to = rows.to;
    if (to - from > 1) {
        const int half = (from + to) / 2;
        const struct gp_fft_node *const a = node + 1;
        const struct gp_fft_node *const b = node + 2 * (half - from);
        n.most = a->most.to <= a->most.from   ? b->most
                 : b->most.to <= b->most.from ? a->most
                     : (struct gp_fft_run) {gp_min(a->most.from, b->most.from),
                                            gp_max(a->most.to, b->most.to)};
        n.least.from = gp_max(a->least.from, b->least.from);
        n.least.to = gp_min(a->least.to, b->least.to);
        n.full = n.least.from == n.most.from && n.least.to == n.most.to;
    } else if (s->row[from] < s->row[to]) {
        n.most.from = s->run[s->row[from]].from;
        n.most.to = s->run[s->row[to] - 1].to;
        for (uint32_t i = s->row[from]; i < s->row[to]; i++) {
            if (s->run[i].to - s->run[i].from > n.least.to - n.least.from)
                n.least = s->run[i];
        }
        n.full = s->row[to] - s->row[from] == 1;
    }
    *node = n;
}

/* Fills in all nodes of h rows, from the last to the first. */
static gp_status make_nodes(const struct gp_log *log, int h,
                            struct gp_fft_shape *s)
{
    struct node_rows *rows;
    const int n = 2 * h - 1;
    gp_status st = gp_alloc(log, "reach", (size_t) n, sizeof *rows, &rows);
    if (st)
        return st;
    rows[0] = (struct node_rows) {0, h};
    for (int i = 0; i < n; i++) {
        const int from = rows[i].from, to = rows[i].to, half = (from + to) / 2;
        if (to - from == 1)
            continue;
        rows[i + 1] = (struct node_rows) {from, half};
        rows[i + 2 * (half - from)] = (struct node_rows) {half, to};
    }
    for (int i = n - 1; i >= 0; i--)
        make_node(s, rows[i], s->node + i);
    gp_free(rows);
    return GP_OK;
}

/* Runs of a row of w samples, the first of them at offset x0, from `run` on;
 * returns how many. They are w / 2 + 1 at most. */
GP_CLONES static uint32_t row_runs(const float *v, int w, int x0,
                                   struct gp_fft_run *run)
{
    enum { BLOCK = 32 };
    uint32_t n = 0;
    int on = 0; // before sample x
    for (int x = 0; x < w;) {
        int lit = 0;
        for (int i = 0; i < BLOCK && x + BLOCK <= w; i++)
            lit += v[x + i] != 0.0f;
        if (x + BLOCK <= w && lit == on * BLOCK) {
            x += BLOCK;
            continue;
        }
        for (const int end = gp_min(x + BLOCK, w); x < end; x++) {
            if ((v[x] != 0.0f) == on)
                continue;
            if (on)
                run[n++].to = x0 + x;
            else
                run[n].from = x0 + x;
            on = !on;
        }
    }
    if (on)
        run[n++].to = x0 + w;
    return n;
}

/* Makes the runs of neighbouring rows, one a row, hold all of theirs, so that a
 * reach is found by fewer parts. */
static void join_runs(const struct gp_fft_shape *s, int h)
{
    enum { BLOCK = 16 };
    for (int from = 0; from < h; from += BLOCK) {
        const uint32_t end = s->row[gp_min(from + BLOCK, h)];
        struct gp_fft_run all = {INT_MAX, INT_MIN};
        for (uint32_t i = s->row[from]; i < end; i++) {
            all.from = gp_min(all.from, s->run[i].from);
            all.to = gp_max(all.to, s->run[i].to);
        }
        for (uint32_t i = s->row[from]; i < end; i++)
            s->run[i] = all;
    }
}

gp_status gp_fft_shape_make(const struct gp_log *log, const struct gp_kernel *k,
                            int c, struct gp_fft_shape *out)
{
    struct gp_fft_shape s = {0};
    void *runs = NULL; // grows
    size_t room = 0, n = 0;
    const size_t w = (size_t) k->w, h = (size_t) k->h;
    gp_status st = gp_alloc(log, "reach", h + 1, sizeof *s.row, &s.row);
    if (!st)
        st = gp_alloc(log, "reach", 2 * h, sizeof *s.node, &s.node);
    for (size_t y = 0; y < h && !st; y++) {
        if (n + w / 2 + 1 > room) {
            room = 2 * n + w / 2 + 1;
            st = gp_resize(log, "reach", room * sizeof *s.run, &runs);
            s.run = runs;
        }
        s.row[y] = (uint32_t) n;
        if (st)
            break;
        const struct gp_lit_row *const lit =
            k->lit ? &k->lit[(size_t) c * h + y] : NULL;
        if (lit && (!lit->dark || k->far)) { // its tail fills the gaps
            s.run[n] = (struct gp_fft_run) {lit->from - k->cx,
                                            lit->to - k->cx};
            n += lit->from < lit->to;
            continue;
        }
        uint32_t found = row_runs(k->k.c[c] + y * w, k->w, -k->cx, s.run + n);
        if (k->far && found > 1) {
            s.run[n].to = s.run[n + found - 1].to;
            found = 1;
        }
        n += found;
    }
    if (!st) {
        s.row[h] = (uint32_t) n;
        if (k->far)
            join_runs(&s, k->h);
        st = make_nodes(log, k->h, &s);
    }
    if (st)
        gp_fft_shape_free(&s);
    else
        *out = s;
    return st;
}

static bool same_shape(const struct gp_fft_shape *a,
                       const struct gp_fft_shape *b, int h)
{
    return a == b || (memcmp(a->row, b->row,
                             ((size_t) h + 1) * sizeof *a->row) == 0 &&
                      memcmp(a->run, b->run, a->row[h] * sizeof *a->run) == 0);
}

// -- the light's support ------------------------------------------------------

/* Rows of bits of the light of one channel, those of the sources' box, of
 * which level l has 2^l in one from each row on. */
enum { LEVELS = 32 };
struct light {
    const struct gp_sources *src;
    int c, y0, h, words, levels;
    int *dark;             // rows without light over each row, h + 1
    uint64_t *bits;        // of level 0; others follow
};

static uint64_t *bits_at(const struct light *s, int level, int row)
{
    return s->bits + ((size_t) level * (size_t) s->h + (size_t) row) *
                         (size_t) s->words;
}

/* Sets the bits of n sources in a row, 64 at most, one beside another. */
GP_CLONES static uint64_t lit_bits(const float *v, int n)
{
    int lit = 0;
    for (int i = 0; i < n; i++)
        lit += v[i] > 0.0f;
    if (lit == n && n > 0)
        return ~0ull >> (64 - n);
    uint64_t bits = 0;
    for (int i = 0; i < n; i++)
        bits |= (uint64_t) (v[i] > 0.0f) << i;
    return bits;
}

static void make_bits(void *ctx, int row, int thread)
{
    const struct light *const m = ctx;
    const struct gp_sources *const s = m->src;
    const int32_t *const x = s->x;
    const float *const v = s->rgb[m->c];
    uint64_t *const bits = bits_at(m, 0, row);
    uint64_t any = 0;
    const uint32_t end = s->row[m->y0 + row + 1];
    (void) thread;
    memset(bits, 0, (size_t) m->words * sizeof *bits);
    for (uint32_t i = s->row[m->y0 + row]; i < end;) {
        const uint32_t rest = end - i, room = 64u - (uint32_t) x[i] % 64u;
        const uint32_t most = rest < room ? rest : room;
        const uint32_t n = x[i + most - 1] == x[i] + (int) most - 1 ? most : 1;
        const uint64_t lit = n == 1 ? v[i] > 0.0f : lit_bits(v + i, (int) n);
        bits[x[i] / 64] |= lit << x[i] % 64;
        any |= lit;
        i += n;
    }
    m->dark[row + 1] = !any;
}

/* Words [8 i, 8 i + 8) of all levels. */
static void join_rows(void *ctx, int i, int thread)
{
    const struct light *const m = ctx;
    const int end = gp_min(8 * i + 8, m->words);
    (void) thread;
    for (int level = 1; level < m->levels; level++) {
        for (int row = 0; row < m->h; row++) {
            const uint64_t *const a = bits_at(m, level - 1, row);
            const uint64_t *const b = bits_at(
                m, level - 1, gp_min(row + (1 << (level - 1)), m->h - 1));
            uint64_t *const out = bits_at(m, level, row);
            for (int j = 8 * i; j < end; j++)
                out[j] = a[j] | b[j];
        }
    }
}

/* Makes room for the light of any channel. */
static gp_status make_light(const struct gp_log *log,
    const struct gp_sources *src, int kernel_h, struct light *out)
{
    struct light m = {
        .src = src, .y0 = src->box.y0, .h = gp_rect_h(src->box),
        .words = (src->w + 63) / 64, .levels = 1,
    };
    while (m.levels < LEVELS - 1 && gp_min(m.h, kernel_h) >> m.levels)
        m.levels++;
    const size_t rows = (size_t) m.levels * (size_t) m.h;
    gp_status st = gp_alloc_zero(log, "reach", (size_t) m.h + 1,
                                 sizeof *m.dark, &m.dark);
    if (!st)
        st = gp_alloc(log, "reach", rows, (size_t) m.words * sizeof *m.bits,
                      &m.bits);
    if (st)
        gp_free(m.dark);
    else
        *out = m;
    return st;
}

/* Fills in that of channel c, on one thread: tasks of others wait for it. */
static void fill_light(struct light *m, int c)
{
    m->c = c;
    for (int row = 0; row < m->h; row++)
        make_bits(m, row, 0);
    for (int row = 0; row < m->h; row++)
        m->dark[row + 1] += m->dark[row];
    for (int i = 0; i < (m->words + 7) / 8; i++)
        join_rows(m, i, 0);
}

/* Returns true when the channels have light in the same pixels. */
GP_CLONES static bool same_light(const float *a, const float *b, size_t n)
{
    int differ = 0;
    for (size_t i = 0; i < n; i++)
        differ |= (a[i] > 0.0f) ^ (b[i] > 0.0f);
    return !differ;
}

// -- the reach ----------------------------------------------------------------

/* Channels whose light and kernel have the same support. */
struct part {
    const struct gp_kernel *k;
    const struct gp_fft_shape *shape;
    const struct light *light;
    uint64_t *reached; // words of each row of the frame
    bool *found;       // rows of these that are found
};

struct gp_fft_reach {
    const struct gp_fft_shape *shape[3];
    struct light light[3]; // of channels that differ
    struct part part[3];   // of channels that differ; none: no light
    int of[3];             // part of each channel
    bool known[3];         // channels of which it is
    pthread_mutex_t lock;  // of what is found of channels
    uint64_t *scratch;     // 2 * words a thread
};

/* A row of the frame, and the words that kernel rows reach of it. */
struct row {
    const struct part *m;
    int y;
    uint64_t *reached, *maybe, *joined;
};

/* All of light rows [from, to) in one; in r->joined, or where it is known. */
static const uint64_t *joined_rows(const struct row *r, int from, int to)
{
    const struct light *const s = r->m->light;
    const int level = highest((uint64_t) (to - from));
    const uint64_t *const a = bits_at(s, level, from);
    const uint64_t *const b = bits_at(s, level, to - (1 << level));
    if (a == b)
        return a;
    for (int i = 0; i < s->words; i++)
        r->joined[i] = a[i] | b[i];
    return r->joined;
}

/* Kernel rows [from, to), whose node it is, to be looked at for words [first,
 * end) of a row. */
struct look {
    const struct gp_fft_node *node;
    int from, to, first, end;
};

/* Adds what those rows reach; true where their halves must be looked at, of
 * which *l then has the words. */
static bool look_at(const struct row *r, struct look *l)
{
    static const int FEW = 2; // rows that cost less than all of them in one
    const struct gp_fft_shape *const k = r->m->shape;
    const struct light *const s = r->m->light;
    const struct gp_fft_node *const node = l->node;
    const int above = r->y + r->m->k->cy - s->y0; // light of kernel row 0
    const int start = gp_max(above - l->to + 1, 0);
    const int past = gp_min(above - l->from + 1, s->h);
    if (start >= past || node->most.from >= node->most.to)
        return false;
    const int lit = past - start - (s->dark[past] - s->dark[start]);
    if (!lit)
        return false;
    while (l->first < l->end && r->reached[l->first] == ~0ull)
        l->first++;
    while (l->first < l->end && r->reached[l->end - 1] == ~0ull)
        l->end--;
    if (l->first == l->end)
        return false;
    if (lit <= FEW || l->to - l->from == 1) {
        for (int row = start; row < past; row++) {
            const uint32_t *const runs = k->row + (above - row);
            if (s->dark[row + 1] > s->dark[row])
                continue;
            for (uint32_t i = runs[0]; i < runs[1]; i++)
                dilate(bits_at(s, 0, row), s->words, k->run[i], r->reached,
                       l->first, l->end);
        }
        return false;
    }
    const uint64_t *const light = joined_rows(r, start, past);
    if (node->least.from < node->least.to) {
        dilate(light, s->words, node->least, r->reached, l->first, l->end);
        if (node->full)
            return false;
    }
    memset(r->maybe + l->first, 0,
           (size_t) (l->end - l->first) * sizeof *r->maybe);
    dilate(light, s->words, node->most, r->maybe, l->first, l->end);
    while (l->first < l->end && !(r->maybe[l->first] & ~r->reached[l->first]))
        l->first++;
    while (l->first < l->end &&
           !(r->maybe[l->end - 1] & ~r->reached[l->end - 1]))
        l->end--;
    return l->first < l->end;
}

/* Adds what all kernel rows reach of a row. */
static void reach_row(const struct row *r)
{
    struct look stack[LEVELS + 2] = {
        {r->m->shape->node, 0, r->m->k->h, 0, r->m->light->words},
    };
    int n = 1; // each level leaves one
    while (n > 0) {
        struct look l = stack[--n];
        if (!look_at(r, &l))
            continue;
        const int half = (l.from + l.to) / 2;
        struct look a = l, b = l;
        a.node = l.node + 1;
        a.to = half;
        b.node = l.node + 2 * (half - l.from);
        b.from = half;
        // the half that surely reaches further is first
        const bool first = a.node->least.to - a.node->least.from >=
                           b.node->least.to - b.node->least.from;
        stack[n++] = first ? b : a;
        stack[n++] = first ? a : b;
    }
}

/* Clears n samples, 64 at most, that are not reached and `noise` at most. */
GP_CLONES static void clear_bits(float *v, int n, uint64_t reached, float noise)
{
    if (!reached) {
        for (int x = 0; x < n; x++)
            v[x] = v[x] <= noise ? 0.0f : v[x];
        return;
    }
    for (uint64_t left = ~reached; left; left &= left - 1) {
        const int x = lowest(left);
        v[x] = v[x] <= noise ? 0.0f : v[x];
    }
}

/* Finds the part of channel c: that of a channel before it, or its own. */
static void find_part(struct gp_fft_reach *r, int c)
{
    const struct gp_sources *const src = r->light[c].src;
    int lit = 0, same = 0;
    while (lit < c && !(r->known[lit] && r->part[lit].light == &r->light[lit] &&
                        same_light(src->rgb[lit], src->rgb[c], src->n)))
        lit++;
    if (lit == c)
        fill_light(&r->light[c], c);
    while (same < c && !(r->part[same].light == &r->light[lit] &&
                         same_shape(r->shape[same], r->shape[c],
                                    r->part[c].k->h)))
        same++;
    r->of[c] = same;
    r->part[same].light = &r->light[lit];
    r->known[c] = true;
}

void gp_fft_reach_clear(struct gp_fft_reach *r, int c, int y, int thread,
                        float noise, float *v)
{
    pthread_mutex_lock(&r->lock);
    if (!r->known[c])
        find_part(r, c);
    pthread_mutex_unlock(&r->lock);
    const struct part *const m = &r->part[r->of[c]];
    const int w = m->light->src->w, words = m->light->words;
    const size_t n = (size_t) words;
    uint64_t *const reached = m->reached + (size_t) y * n;
    uint64_t *const scratch = r->scratch + 2 * (size_t) thread * n;
    if (!m->found[y]) {
        const struct row row = {m, y, reached, scratch, scratch + n};
        memset(reached, 0, n * sizeof *reached);
        if (w % 64) // no pixels
            reached[n - 1] = ~0ull << w % 64;
        reach_row(&row);
        m->found[y] = true;
    }
    for (int i = 0; i < words; i++)
        clear_bits(v + 64 * i, gp_min(w - 64 * i, 64), reached[i], noise);
}

void gp_fft_reach_free(struct gp_fft_reach **reach)
{
    struct gp_fft_reach *const r = *reach;
    for (int c = 0; c < 3 && r; c++) {
        gp_free(r->light[c].bits);
        gp_free(r->light[c].dark);
        gp_free(r->part[c].reached);
        gp_free(r->part[c].found);
    }
    if (r) {
        gp_free(r->scratch);
        pthread_mutex_destroy(&r->lock);
    }
    GP_FREE(*reach);
}

gp_status gp_fft_reach_open(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *k,
    const struct gp_fft_shape *const shape[3], struct gp_fft_reach **out)
{
    gp_status st;
    struct gp_fft_reach *r = NULL;
    const size_t words = ((size_t) src->w + 63) / 64, h = (size_t) src->h;
    GP_TRY(gp_alloc_zero(log, "reach", 1, sizeof *r, &r));
    pthread_mutex_init(&r->lock, NULL);
    GP_TRY(gp_alloc(log, "reach", 2 * (size_t) gp_threads(),
                    words * sizeof *r->scratch, &r->scratch));
    for (int c = 0; c < 3; c++) { // room: none is touched before it is needed
        struct part *const m = &r->part[c];
        r->shape[c] = shape[c];
        m->k = k;
        m->shape = shape[c];
        GP_TRY(make_light(log, src, k->h, &r->light[c]));
        GP_TRY(gp_alloc(log, "reach", h, words * sizeof *m->reached,
                        &m->reached));
        GP_TRY(gp_alloc_zero(log, "reach", h, sizeof *m->found, &m->found));
    }
    *out = r;
    r = NULL;
out:
    gp_fft_reach_free(&r);
    return st;
}
