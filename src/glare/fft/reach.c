/* The sources' reach: pixels where a float transform leaves rounding noise and
 * the sum itself has no term. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/fft_priv.h"

#include <string.h>

void gp_fft_runs_free(struct gp_fft_runs *r)
{
    gp_free(r->row);
    gp_free(r->run);
    *r = (struct gp_fft_runs) {0};
}

/* Room for `most` runs in h rows. */
static gp_status make_runs(const struct gp_log *log, int h, size_t most,
                           struct gp_fft_runs *out)
{
    struct gp_fft_runs r = {0};
    gp_status st = gp_alloc(log, "reach", (size_t) h + 1, sizeof *r.row,
                            &r.row);
    if (!st)
        st = gp_alloc(log, "reach", most + 1, sizeof *r.run, &r.run);
    if (st)
        gp_fft_runs_free(&r);
    else
        *out = r;
    return st;
}

gp_status gp_fft_kernel_runs(const struct gp_log *log,
    const struct gp_kernel *k, int c, struct gp_fft_runs *out)
{
    size_t n = 0;
    const float *v = k->k.c[c];
    for (int y = 0; y < k->h; y++) {
        for (int x = 0; x < k->w; x++, v++)
            n += *v != 0.0f && (x == 0 || v[-1] == 0.0f);
    }
    struct gp_fft_runs r;
    gp_status st = make_runs(log, k->h, n, &r);
    if (st)
        return st;
    n = 0;
    for (int y = 0; y < k->h; y++) {
        r.row[y] = (uint32_t) n;
        v = k->k.c[c] + (size_t) y * (size_t) k->w;
        for (int x = 0; x < k->w; x++) {
            if (v[x] == 0.0f)
                continue;
            if (x == 0 || v[x - 1] == 0.0f)
                r.run[n++].from = x - k->cx;
            r.run[n - 1].to = x + 1 - k->cx;
        }
    }
    r.row[k->h] = (uint32_t) n;
    *out = r;
    return GP_OK;
}

/* The same of the sources' light in channel c, by columns of the frame. */
static gp_status source_runs(const struct gp_log *log,
    const struct gp_sources *s, int c, struct gp_fft_runs *out)
{
    size_t n = 0;
    gp_status st = make_runs(log, s->h, s->n, out);
    for (int y = 0; y < s->h && !st; y++) {
        out->row[y] = (uint32_t) n;
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            if (!(s->rgb[c][i] > 0.0f))
                continue;
            if (n == out->row[y] || out->run[n - 1].to != s->x[i])
                out->run[n++].from = s->x[i];
            out->run[n - 1].to = s->x[i] + 1;
        }
    }
    if (!st)
        out->row[s->h] = (uint32_t) n;
    return st;
}

struct clearing {
    const struct gp_kernel *k;
    const struct gp_fft_runs *kernel, *light;
    float *plane;
    int w, h, words;
    float noise;
    int *gap;          // the widest between the light's runs, of each row
    uint64_t *scratch; // 2 * words a thread
};

/* Sets bits [from, to). */
static void set_bits(uint64_t *bits, int from, int to)
{
    const int first = from / 64, last = (to - 1) / 64;
    const uint64_t head = ~0ull << from % 64;
    const uint64_t tail = ~0ull >> (63 - (to - 1) % 64);
    if (first == last) {
        bits[first] |= head & tail;
        return;
    }
    bits[first] |= head;
    for (int i = first + 1; i < last; i++)
        bits[i] = ~0ull;
    bits[last] |= tail;
}

/* Takes what row `sy` of the light reaches by row `ky` of the kernel out of
 * `left`; [*lo, *hi) is known to be out. False when nothing is left. */
static bool take_reached(const struct clearing *m, int sy, int ky,
                         uint64_t *reached, uint64_t *left, int *lo, int *hi)
{
    bool changed = false;
    const struct gp_fft_runs *const s = m->light, *const k = m->kernel;
    const uint32_t last = s->row[sy + 1] - 1;
    for (uint32_t j = k->row[ky]; j < k->row[ky + 1]; j++) {
        // a run of the kernel over every gap makes one of all the light's
        const bool bridged =
            k->run[j].to - k->run[j].from > m->gap[sy];
        const uint32_t step = bridged ? last + 1 - s->row[sy] : 1;
        for (uint32_t i = s->row[sy]; i <= last; i += step) {
            const int end = s->run[i + step - 1].to;
            const int from = gp_max(s->run[i].from + k->run[j].from, 0);
            const int to = gp_min(end - 1 + k->run[j].to, m->w);
            if (from >= to || (from >= *lo && to <= *hi))
                continue;
            set_bits(reached, from, to);
            if (to - from > *hi - *lo) {
                *lo = from;
                *hi = to;
            }
            changed = true;
        }
    }
    uint64_t any = !changed;
    for (int i = 0; i < m->words && changed; i++) {
        left[i] &= ~reached[i];
        any |= left[i];
    }
    return any != 0;
}

/* Returns whether a row holds samples over 0 that may be noise. */
GP_CLONES static int has_faint(const float *row, int w, float noise)
{
    int some = 0;
    for (int x = 0; x < w; x++)
        some |= (row[x] > 0.0f) & (row[x] <= noise);
    return some;
}

static void clear_row(void *ctx, int y, int thread)
{
    const struct clearing *const m = ctx;
    const struct gp_kernel *const k = m->k;
    uint64_t *const left = m->scratch + 2 * (size_t) thread * (size_t) m->words;
    uint64_t *const reached = left + m->words;
    float *const row = m->plane + (size_t) y * (size_t) m->w;
    bool some = true;
    int lo = 0, hi = 0;
    if (!has_faint(row, m->w, m->noise))
        return;
    memset(left, 0, 2 * (size_t) m->words * sizeof *left);
    for (int x = 0; x < m->w; x++) {
        const bool faint = row[x] > 0.0f && row[x] <= m->noise;
        left[x / 64] |= (uint64_t) faint << x % 64;
    }
    // the kernel's rows from its centre on: the widest first
    const int middle = gp_max(0, gp_min(k->cy, k->h - 1));
    const int steps = 2 * gp_max(middle, k->h - 1 - middle);
    for (int i = 0; i <= steps && some; i++) {
        const int ky = middle + (i % 2 ? (i + 1) / 2 : -i / 2);
        const int sy = y - (ky - k->cy);
        if (ky >= 0 && ky < k->h && sy >= 0 && sy < m->h &&
            m->light->row[sy] < m->light->row[sy + 1])
            some = take_reached(m, sy, ky, reached, left, &lo, &hi);
    }
    for (int x = 0; x < m->w && some; x++) {
        if (left[x / 64] >> x % 64 & 1)
            row[x] = 0.0f;
    }
}

gp_status gp_fft_clear_unreached(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *k,
    const struct gp_fft_runs *kernel, int c, double noise, float *plane)
{
    struct gp_fft_runs light = {0};
    struct clearing m = {
        .k = k, .kernel = kernel, .light = &light, .plane = plane,
        .w = src->w, .h = src->h, .words = src->w / 64 + 1,
        .noise = (float) noise,
    };
    gp_status st = source_runs(log, src, c, &light);
    if (!st)
        st = gp_alloc(log, "reach", 2 * (size_t) gp_threads(),
                      (size_t) m.words * sizeof *m.scratch, &m.scratch);
    if (!st)
        st = gp_alloc_zero(log, "reach", (size_t) src->h, sizeof *m.gap,
                           &m.gap);
    for (int y = 0; y < src->h && !st; y++) {
        for (uint32_t i = light.row[y] + 1; i < light.row[y + 1]; i++)
            m.gap[y] = gp_max(m.gap[y],
                              light.run[i].from - light.run[i - 1].to);
    }
    if (!st)
        gp_parallel_do(src->h, clear_row, &m);
    gp_free(m.gap);
    gp_free(m.scratch);
    gp_fft_runs_free(&light);
    return st;
}
