/* Autocorrelation of pupils by transforms. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/model/model_priv.h"

#include <stdlib.h>

/* Splits the transform of a + ib, a and b real, at frequency k. */
static inline void unpack(const float complex *z, int n, int k,
                          float complex *a, float complex *b)
{
    const float complex here = z[k], other = z[k ? n - k : 0];
    *a = CMPLXF(0.5f * (crealf(here) + crealf(other)),
                0.5f * (cimagf(here) - cimagf(other)));
    *b = CMPLXF(0.5f * (cimagf(here) + cimagf(other)),
                0.5f * (crealf(other) - crealf(here)));
}

enum { GROUP = 8 }; // rows that go through memory together: a cache line

void gp_correlator_free(struct gp_correlator *t)
{
    gp_fft_plan_free(&t->plan);
    gp_free(t->room);
    gp_free(t->boost);
    gp_free(t->z);
    *t = (struct gp_correlator) {0};
}

gp_status gp_correlator_make(const struct gp_log *log,
    const struct gp_pupil *p, struct gp_correlator *out)
{
    const int n = gp_fft_length(2 * p->n);
    // arrays a power of two apart would share the lines of a cache
    struct gp_correlator t = {.pupil = p, .pitch = (size_t) n + 16};
    gp_status st;
    GP_TRY(gp_fftwf_open(log, &t.lib));
    GP_TRY(gp_fft_plan_make(log, n, GP_FFT_PLAN_ESTIMATE, NULL, &t.plan));
    t.columns = p->path ? n : n / 2 + 1;
    t.across = (t.columns + GROUP - 1) / GROUP * GROUP;
    GP_TRY(gp_alloc_zero(log, "kernel",
                         2 * GROUP * (size_t) gp_threads() * t.pitch,
                         sizeof *t.room, &t.room));
    GP_TRY(gp_alloc(log, "kernel", (size_t) p->n + 2 * GROUP,
                    (size_t) t.across * sizeof *t.z, &t.z));
    GP_TRY(gp_alloc(log, "kernel", (size_t) n + GROUP, sizeof *t.boost,
                    &t.boost));
    for (int k = 0; k < n + GROUP; k++) {
        const double s = gp_sinc((double) gp_min(k, abs(n - k)) / n);
        t.boost[k] = (float) (1.0 / (s * s * s * s));
    }
    *out = t;
    return GP_OK;
out:
    gp_correlator_free(&t);
    return st;
}

/* A pupil without a path is real: two rows go through one transform, and half
 * the columns of the spectrum are all. */
struct correlating {
    const struct gp_correlator *t;
    double nm;
    int pack;             // rows that go through one transform
    struct gp_lags *a;
};

static float complex *array_in(const struct correlating *c, int thread, int i)
{
    return c->t->room + (size_t) (2 * GROUP * thread + i) * c->t->pitch;
}

/* Rows, or lags v >= 0, from a multiple of GROUP on, of column k. */
static float complex *rows_at(const struct correlating *c, int row, int k)
{
    return c->t->z + (size_t) row * (size_t) c->t->across +
           (size_t) k * GROUP;
}

static float complex *array_out(const struct correlating *c, int thread, int i)
{
    return array_in(c, thread, GROUP + i);
}

/* Transforms the thread's first n arrays. */
static void run(const struct correlating *c, fftwf_plan plan, int n,
                int thread)
{
    const struct gp_fftwf *const lib = c->t->lib;
    for (int i = 0; i < n; i++)
        lib->execute_dft(plan, (void *) array_in(c, thread, i),
                         (void *) array_out(c, thread, i));
}

/* Amplitudes t of n cells whose paths are so many nm, of `waves` a nm, as re,
 * im. */
GP_CLONES static void add_path(const float *restrict t,
    const float *restrict path, double waves, int n, float *restrict to)
{
    static const double ROUND = 0x1.8p52; // added, leaves whole numbers
    for (int x = 0; x < n; x++) {
        const double turns = (double) path[x] * waves;
        const float z = (float) (GP_PI * (turns - ((turns + ROUND) - ROUND)));
        const float q = z * z;
        // of half the angle, within pi / 2: Taylor's series, to 1e-9
        const float s = z * (1.0f + q * (-1.0f / 6 + q * (1.0f / 120 +
            q * (-1.0f / 5040 + q * (1.0f / 362880 +
            q * (-1.0f / 39916800 + q / 6227020800.0f))))));
        const float c = 1.0f + q * (-1.0f / 2 + q * (1.0f / 24 +
            q * (-1.0f / 720 + q * (1.0f / 40320 + q * (-1.0f / 3628800 +
            q * (1.0f / 479001600 - q / 87178291200.0f))))));
        to[2 * x] = t[x] * (1.0f - 2.0f * s * s);
        to[2 * x + 1] = t[x] * (2.0f * s * c);
    }
}

/* Rows of the pupil, `pack` a transform, to all columns. */
static void pupil_rows(void *ctx, int group, int thread)
{
    const struct correlating *const c = ctx;
    const struct gp_pupil *const p = c->t->pupil;
    const int n = c->t->plan.n, cells = p->n;
    const int first = group * GROUP * c->pack;
    for (int i = 0; i < GROUP; i++) {
        float complex *const to = array_in(c, thread, i);
        const int y = first + i * c->pack; // cells are a multiple of 8
        const size_t row = (size_t) y * (size_t) cells;
        const float *const t = p->t + row;
        memset(to, 0, (size_t) n * sizeof *to);
        if (y >= cells)
            continue;
        if (c->pack == 1)
            add_path(t, p->path + row, 1.0 / c->nm, cells, (float *) to);
        for (int x = 0; x < cells && c->pack == 2; x++)
            to[x] = CMPLXF(t[x], t[cells + x]);
    }
    run(c, c->t->plan.forward, GROUP, thread);
    for (int k = 0; k < c->t->columns; k++) {
        float complex *const to = rows_at(c, first, k);
        float complex *const on = rows_at(c, first + GROUP, k); // pack 2
        for (int i = 0; i < GROUP; i++) {
            const float complex *const out = array_out(c, thread, i);
            if (c->pack == 2)
                unpack(out, n, k, i < GROUP / 2 ? &to[2 * i]
                                                : &on[2 * i - GROUP],
                       i < GROUP / 2 ? &to[2 * i + 1] : &on[2 * i + 1 - GROUP]);
            else
                to[i] = out[k];
        }
    }
    for (int half = 0; half < c->pack; half++)
        memset(rows_at(c, first + half * GROUP, c->t->columns), 0,
               (size_t) (c->t->across - c->t->columns) * GROUP *
                   sizeof(float complex));
}

/* Columns: on to the spectrum, its squares, which are real, and back to lags
 * v >= 0, two columns a transform. */
static void pupil_columns(void *ctx, int group, int thread)
{
    const struct correlating *const c = ctx;
    const int n = c->t->plan.n, cells = c->t->pupil->n, first = group * GROUP;
    for (int y = 0; y < cells; y += GROUP) {
        for (int i = 0; i < GROUP; i++)
            memcpy(array_in(c, thread, i) + y, rows_at(c, y, first + i),
                   GROUP * sizeof(float complex));
    }
    for (int i = 0; i < GROUP; i++)
        memset(array_in(c, thread, i) + cells, 0,
               (size_t) (n - cells) * sizeof(float complex));
    run(c, c->t->plan.forward, GROUP, thread);
    for (int i = 0; i < GROUP; i += 2) {
        const float complex *const a = array_out(c, thread, i);
        const float complex *const b = array_out(c, thread, i + 1);
        const float of_a = c->t->boost[first + i], of_b = c->t->boost[first + i + 1];
        float *const to = (float *) array_in(c, thread, i / 2);
        for (int k = 0; k < n; k++) {
            to[2 * k] = c->t->boost[k] * of_a * (crealf(a[k]) * crealf(a[k]) +
                                              cimagf(a[k]) * cimagf(a[k]));
            to[2 * k + 1] = c->t->boost[k] * of_b * (crealf(b[k]) * crealf(b[k]) +
                                                  cimagf(b[k]) * cimagf(b[k]));
        }
    }
    run(c, c->t->plan.backward, GROUP / 2, thread);
    for (int v = 0; v < cells + 2 * GROUP; v += GROUP) {
        for (int i = 0; i < GROUP; i += 2) {
            float complex *const to = rows_at(c, v, first + i);
            for (int r = 0; r < GROUP; r++)
                unpack(array_out(c, thread, i / 2), n, v + r, &to[r],
                       &to[GROUP + r]);
        }
    }
}

/* Lags v, `pack` a transform, to all lags u. */
static void pupil_lags(void *ctx, int group, int thread)
{
    const struct correlating *const c = ctx;
    struct gp_lags *const a = c->a;
    const int n = c->t->plan.n, first = group * GROUP * c->pack;
    for (int k = 0; k < c->t->columns; k++) {
        const float complex *const z = rows_at(c, first, k);
        const float complex *const on = rows_at(c, first + GROUP, k); // pack 2
        for (int i = 0; i < GROUP; i++) {
            float complex *const in = array_in(c, thread, i);
            if (c->pack == 1) {
                in[k] = z[i];
                continue;
            }
            const float complex *const at =
                i < GROUP / 2 ? z + 2 * i : on + 2 * i - GROUP;
            const float complex x = at[0], y = at[1];
            in[k] = CMPLXF(crealf(x) - cimagf(y), cimagf(x) + crealf(y));
            if (k > 0) // a real row's half is conjugate
                in[n - k] = CMPLXF(crealf(x) + cimagf(y),
                                   crealf(y) - cimagf(x));
        }
    }
    run(c, c->t->plan.backward, GROUP, thread);
    const int rows = gp_min(GROUP, (a->n - first) / c->pack + 1);
    for (int u = -a->n; u <= a->n; u++) {
        const size_t at = gp_lag_at(a, u, first), from = (size_t) (u < 0 ? u + n
                                                                         : u);
        for (int i = 0; i < rows; i++) {
            const float complex v = array_out(c, thread, i)[from];
            if (c->pack == 1) {
                a->re[at + (size_t) i] = crealf(v);
                a->im[at + (size_t) i] = cimagf(v);
                continue;
            }
            a->re[at + 2 * (size_t) i] = crealf(v);
            a->re[at + 2 * (size_t) i + 1] = cimagf(v);
        }
    }
    if (group == 0)
        a->sum = (double) crealf(array_out(c, thread, 0)[0]);
}

/* Clears the last strip, which lags fill in part. */
static void clear_last(struct gp_lags *a)
{
    const size_t at = gp_lag_at(a, -a->n, a->n / GP_LAG_STRIP * GP_LAG_STRIP);
    const size_t bytes = (gp_lag_count(a->n) - at) * sizeof *a->re;
    memset(a->re + at, 0, bytes);
    if (a->im)
        memset(a->im + at, 0, bytes);
}

/* The largest distance between open cells, from that to the middle. */
static double edge_of(const struct gp_pupil *p)
{
    static const double SPREAD = 16.0; // cells, of dividing by their falloff
    double most = 0.0;
    for (int y = 0; y < p->n; y++) {
        const float *const row = p->t + (size_t) y * (size_t) p->n;
        int from = 0, end = p->n;
        while (from < end && !(row[from] > 0.0f))
            from++;
        while (end > from && !(row[end - 1] > 0.0f))
            end--;
        if (from < end)
            most = fmax(most, hypot(fmax(0.5 * p->n - from, end - 0.5 * p->n),
                                    fabs(y + 0.5 - 0.5 * p->n)));
    }
    return 2.0 * most + SPREAD;
}

void gp_correlate(const struct gp_correlator *t, double nm, struct gp_lags *a)
{
    struct correlating c = {
        .t = t, .nm = nm, .a = a, .pack = t->pupil->path ? 1 : 2,
    };
    const int cells = t->pupil->n, rows = GROUP * c.pack;
    clear_last(a);
    a->edge = edge_of(t->pupil);
    gp_parallel_do((cells + rows - 1) / rows, pupil_rows, &c);
    gp_parallel_do(t->across / GROUP, pupil_columns, &c);
    gp_parallel_do(cells / rows + 1, pupil_lags, &c);
}
