/* Autocorrelation of pupils by transforms. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/model/diffract_priv.h"

#include <stdlib.h>

// -- transforms ---------------------------------------------------------------

void gp_transform_free(struct gp_transform *t)
{
    if (t->forward)
        t->lib->destroy_plan(t->forward);
    if (t->backward)
        t->lib->destroy_plan(t->backward);
    gp_free(t->room);
    *t = (struct gp_transform) {0};
}

gp_status gp_transform_make(const struct gp_log *log, int n,
                                struct gp_transform *out)
{
    struct gp_transform t = {.n = n};
    gp_status st = gp_fftwd_open(log, &t.lib);
    if (st)
        return st;
    st = gp_alloc_zero(log, "kernel",
                       2 * GP_GROUP * (size_t) gp_threads() * (size_t) n,
                       sizeof *t.room, &t.room);
    if (st)
        return st;
    void *const from = t.room, *const to = t.room + GP_GROUP * (size_t) n;
    t.forward = t.lib->plan_dft_1d(n, from, to, FFTW_FORWARD, FFTW_ESTIMATE);
    t.backward = t.lib->plan_dft_1d(n, from, to, FFTW_BACKWARD, FFTW_ESTIMATE);
    *out = t;
    if (t.forward && t.backward)
        return GP_OK;
    gp_transform_free(out);
    return gp_fail_bare(log, GP_ERR_BUG, "kernel: FFTW has no plan for length "
                        "%d; use another --fov", n);
}

void gp_transform_run(const struct gp_transform *t, fftw_plan plan, int n,
                      int thread)
{
    for (int i = 0; i < n; i++)
        t->lib->execute_dft(plan, (void *) gp_transform_in(t, thread, i),
                            (void *) gp_transform_out(t, thread, i));
}

/* Splits the transform of a + ib, a and b real, at frequency k. */
static void unpack(const double complex *z, int n, int k, float complex *a,
                   float complex *b)
{
    const double complex other = conj(z[k ? n - k : 0]);
    *a = (float complex) (0.5 * (z[k] + other));
    *b = (float complex) (-0.5 * I * (z[k] - other));
}

// -- the pupil's autocorrelation ----------------------------------------------

/* A pupil without a path is real: two rows go through one transform, and half
 * the columns of the spectrum are all. */
struct correlating {
    const struct gp_pupil *p;
    double nm;
    int pack;             // rows that go through one transform
    int columns;
    const struct gp_transform *t;
    size_t pitch;         // of z: p->n + 2 GP_GROUP
    float complex *z;     // [column of the spectrum][row, or lag v >= 0]
    const double *boost;  // of each frequency, squared sincs undone
    struct gp_lags *a;
};

/* Rows of the pupil, `pack` a transform, to all columns. */
static void pupil_rows(void *ctx, int group, int thread)
{
    const struct correlating *const c = ctx;
    const int n = c->t->n, cells = c->p->n;
    const int first = group * GP_GROUP * c->pack;
    for (int i = 0; i < GP_GROUP; i++) {
        double complex *const to = gp_transform_in(c->t, thread, i);
        const size_t row = (size_t) (first + i * c->pack) * (size_t) cells;
        const float *const t = c->p->t + row;
        memset(to, 0, (size_t) n * sizeof *to);
        for (int x = 0; x < cells; x++)
            to[x] = c->pack == 2
                ? (double) t[x] + I * (double) t[cells + x]
                : (double) t[x] * cexp(2.0 * GP_PI * I / c->nm *
                                       (double) c->p->path[row + (size_t) x]);
    }
    gp_transform_run(c->t, c->t->forward, GP_GROUP, thread);
    for (int k = 0; k < c->columns; k++) {
        float complex *const to = c->z + (size_t) k * c->pitch + first;
        for (int i = 0; i < GP_GROUP; i++) {
            const double complex *const out = gp_transform_out(c->t, thread, i);
            if (c->pack == 2)
                unpack(out, n, k, &to[2 * i], &to[2 * i + 1]);
            else
                to[i] = (float complex) out[k];
        }
    }
}

/* Four columns: on to the spectrum, its squares, which are real, and back to
 * lags v >= 0. */
static void pupil_columns(void *ctx, int group, int thread)
{
    const struct correlating *const c = ctx;
    const int n = c->t->n, cells = c->p->n, first = group * GP_GROUP;
    float complex *const z = c->z + (size_t) first * c->pitch;
    for (size_t i = 0; i < GP_GROUP; i++) {
        double complex *const to = gp_transform_in(c->t, thread, (int) i);
        for (int y = 0; y < cells; y++)
            to[y] = (double complex) z[i * c->pitch + (size_t) y];
        memset(to + cells, 0, (size_t) (n - cells) * sizeof *to);
    }
    gp_transform_run(c->t, c->t->forward, GP_GROUP, thread);
    for (int i = 0; i < GP_GROUP; i += 2) {
        const double complex *const a = gp_transform_out(c->t, thread, i);
        const double complex *const b = gp_transform_out(c->t, thread, i + 1);
        const double of_a = c->boost[first + i], of_b = c->boost[first + i + 1];
        double complex *const to = gp_transform_in(c->t, thread, i / 2);
        for (int k = 0; k < n; k++)
            to[k] = c->boost[k] *
                    (of_a * (creal(a[k]) * creal(a[k]) +
                             cimag(a[k]) * cimag(a[k])) +
                     I * of_b * (creal(b[k]) * creal(b[k]) +
                                 cimag(b[k]) * cimag(b[k])));
    }
    gp_transform_run(c->t, c->t->backward, GP_GROUP / 2, thread);
    for (size_t i = 0; i < GP_GROUP; i += 2) {
        float complex *const to = z + i * c->pitch;
        for (int v = 0; v < (int) c->pitch; v++)
            unpack(gp_transform_out(c->t, thread, (int) i / 2), n, v, &to[v],
                   &to[c->pitch + (size_t) v]);
    }
}

/* A at lag (u, v), v >= 0, and at (-u, v). */
static void put_lag(struct gp_lags *a, int u, int v, double complex here,
                    double complex other)
{
    const size_t at = (size_t) u * a->pitch + (size_t) a->n;
    if (v > a->n)
        return;
    a->re[at + (size_t) v] = (float) creal(here);
    a->re[at - (size_t) v] = (float) creal(other);
    if (a->im) {
        a->im[at + (size_t) v] = (float) cimag(here);
        a->im[at - (size_t) v] = -(float) cimag(other);
    }
}

/* Lags v, `pack` a transform, to all lags u. */
static void pupil_lags(void *ctx, int group, int thread)
{
    const struct correlating *const c = ctx;
    const int n = c->t->n, first = group * GP_GROUP * c->pack;
    for (int k = 0; k < c->columns; k++) {
        const float complex *const z = c->z + (size_t) k * c->pitch + first;
        for (int i = 0; i < GP_GROUP; i++) {
            double complex *const in = gp_transform_in(c->t, thread, i);
            const double complex a = z[i * c->pack];
            const double complex b = c->pack == 2 ? z[2 * i + 1] : 0.0;
            in[k] = a + I * b;
            if (c->pack == 2 && k > 0) // a real row's half is conjugate
                in[n - k] = conj(a) + I * conj(b);
        }
    }
    gp_transform_run(c->t, c->t->backward, GP_GROUP, thread);
    for (int u = 0; u <= c->p->n; u++) {
        const int other = u ? n - u : 0;
        for (int i = 0; i < GP_GROUP; i++) {
            const double complex *const out = gp_transform_out(c->t, thread, i);
            const int v = first + i * c->pack;
            put_lag(c->a, u, v, out[u], out[other]);
            if (c->pack == 2)
                put_lag(c->a, u, v + 1, cimag(out[u]), cimag(out[other]));
        }
    }
    if (group == 0)
        c->a->sum = creal(gp_transform_out(c->t, thread, 0)[0]);
}

gp_status gp_correlate(const struct gp_log *log, const struct gp_pupil *p,
    double nm, const struct gp_transform *t, struct gp_lags *a)
{
    const int n = t->n;
    double *boost = NULL;
    struct correlating c = {
        .p = p, .nm = nm, .t = t, .a = a, .pitch = (size_t) p->n + 2 * GP_GROUP,
        .pack = p->path ? 1 : 2,
    };
    gp_status st;
    c.columns = p->path ? n : n / 2 + 1;
    const int groups = (c.columns + GP_GROUP - 1) / GP_GROUP;
    GP_TRY(gp_alloc(log, "kernel", (size_t) n + GP_GROUP, sizeof *boost,
                    &boost));
    GP_TRY(gp_alloc_zero(log, "kernel", (size_t) groups * GP_GROUP,
                         c.pitch * sizeof *c.z, &c.z));
    for (int k = 0; k < n + GP_GROUP; k++) {
        const double s = gp_sinc((double) gp_min(k, abs(n - k)) / n);
        boost[k] = 1.0 / (s * s * s * s);
    }
    c.boost = boost;
    gp_parallel_do(p->n / (GP_GROUP * c.pack), pupil_rows, &c);
    gp_parallel_do(groups, pupil_columns, &c);
    gp_parallel_do(p->n / (GP_GROUP * c.pack) + 1, pupil_lags, &c);
out:
    gp_free(boost);
    gp_free(c.z);
    return st;
}
