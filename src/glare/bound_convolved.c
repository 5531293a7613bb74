/* The norm of a convolution without the convolution: half of its transforms.
 */
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bound_state.h"
#include "glare/fft_pass.h"

#include <math.h>
#include <stdlib.h>

struct rows {
    const struct gp_planes *d; // of the light; NULL: the kernel
    const struct gp_kernel *k;
    int w;
    bool tail;
};

static void load_light(const void *ctx, int c, int y, float *z)
{
    const struct rows *const r = ctx;
    const float *const row = r->d->c[c] + (size_t) y * (size_t) r->w;
    for (int x = 0; x < r->w; x++)
        z[2 * x] = row[x];
}

static void load_kernel(const void *ctx, int c, int y, float *z)
{
    const struct rows *const r = ctx;
    const struct gp_kernel *const k = r->k;
    const float *const row = k->k.c[c] + (size_t) y * (size_t) k->w;
    const bool core = r->tail && abs(y - k->cy) <= GP_CORE_RADIUS;
    for (int x = 0; x < k->w; x++) {
        if (!core || abs(x - k->cx) > GP_CORE_RADIUS)
            z[2 * x] = row[x];
    }
}

/* Twice the half spectrum of `rows` rows, channel c alone, on nx by ny. */
static gp_status transform(const struct gp_log *log,
                           const struct gp_fft_plan_pair *x,
                           const struct gp_fft_plan_pair *y, int c, int n,
                           gp_fft_load load, const struct rows *from,
                           struct gp_fft_matrix *out)
{
    gp_status st;
    void *v = NULL;
    const struct gp_fft_job job = {
        .log = log, .x = x, .y = y, .channel = c, .channels = 1,
    };
    struct gp_fft_matrix m = {0}, rows = {0}, whole = {0};
    GP_TRY(gp_fft_matrix_make(log, 1, x->n, n, &rows));
    GP_TRY(gp_fft_matrix_make(log, 1, x->n, y->n, &whole));
    GP_TRY(gp_alloc(log, "bound", (size_t) n, sizeof(int), &v));
    int *const place = v;
    for (int j = 0; j < n; j++)
        place[j] = j;
    m = rows; // as channel c of three
    m.z[0] = NULL;
    m.z[c] = rows.z[0];
    *out = whole;
    out->z[0] = NULL;
    out->z[c] = whole.z[0];
    st = gp_fft_rows_in(&job, n, load, from, &m);
    if (!st)
        st = gp_fft_columns(&job, &m, n, place, 1.0f, out);
    out->z[c] = NULL;
    out->z[0] = whole.z[0];
    if (!st)
        whole = (struct gp_fft_matrix) {0};
out:
    gp_free(v);
    gp_fft_matrix_free(&rows);
    if (st) {
        gp_fft_matrix_free(&whole);
        *out = (struct gp_fft_matrix) {0};
    }
    return st;
}

static void free_power(struct gp_bound_power *p)
{
    for (int c = 0; c < 3; c++)
        gp_free(p->power[c]);
    *p = (struct gp_bound_power) {0};
}

static gp_status make_power(const struct gp_log *log,
                            const struct gp_kernel *k, bool tail,
                            const struct gp_fft_plan_pair *x,
                            const struct gp_fft_plan_pair *y,
                            struct gp_bound_power *p)
{
    gp_status st = GP_OK;
    const struct rows from = {.k = k, .tail = tail};
    struct gp_fft_matrix m = {0};
    if (p->nx == x->n && p->ny == y->n)
        return GP_OK;
    free_power(p);
    p->columns = (size_t) x->n / 2 + 1;
    p->channels = k->grey ? 1 : 3;
    for (int c = 0; c < p->channels; c++) {
        void *v;
        GP_TRY(gp_alloc(log, "bound", p->columns * (size_t) y->n,
                        sizeof(float), &v));
        p->power[c] = v;
        GP_TRY(transform(log, x, y, c, k->h, load_kernel, &from, &m));
        for (size_t i = 0; i < p->columns; i++) {
            const float *const z = m.z[0] + 2 * i * m.pitch;
            float *const to = p->power[c] + i * (size_t) y->n;
            for (int j = 0; j < y->n; j++)
                to[j] = z[2 * j] * z[2 * j] + z[2 * j + 1] * z[2 * j + 1];
        }
        gp_fft_matrix_free(&m);
    }
    p->nx = x->n;
    p->ny = y->n;
out:
    if (st)
        free_power(p);
    gp_fft_matrix_free(&m);
    return st;
}

struct energy {
    const struct gp_fft_matrix *m;
    const struct gp_bound_power *p;
    const float *power;
    double *column;
};

static void energy_column(void *ctx, int i, int thread)
{
    const struct energy *const e = ctx;
    const float *const z = e->m->z[0] + 2 * (size_t) i * e->m->pitch;
    const float *const k = e->power + (size_t) i * (size_t) e->p->ny;
    double sum = 0.0;
    (void) thread;
    for (int j = 0; j < e->p->ny; j++)
        sum += (double) k[j] * ((double) z[2 * j] * (double) z[2 * j] +
                                (double) z[2 * j + 1] * (double) z[2 * j + 1]);
    // columns 0 and nx / 2 are their own mirror images
    const bool alone = i == 0 || i == e->p->nx / 2;
    e->column[i] = alone ? sum : 2.0 * sum;
}

gp_status gp_bound_convolved(const struct gp_log *log,
                             const struct gp_kernel *k, bool tail,
                             const struct gp_planes *d, int w, int h,
                             struct gp_bound_state *s, double norm[3])
{
    gp_status st;
    void *v = NULL;
    struct gp_fft_plan_pair x = {0}, y = {0};
    struct gp_fft_matrix m = {0};
    struct gp_bound_power *const p = &s->power[tail];
    const struct rows from = {.d = d, .w = w};
    GP_TRY(gp_fft_plan_make(log, gp_fft_length(w + k->w - 1),
                            GP_FFT_PLAN_ESTIMATE, NULL, &x));
    GP_TRY(gp_fft_plan_make(log, gp_fft_length(h + k->h - 1),
                            GP_FFT_PLAN_ESTIMATE, NULL, &y));
    GP_TRY(make_power(log, k, tail, &x, &y, p));
    GP_TRY(gp_alloc(log, "bound", p->columns, sizeof(double), &v));
    for (int c = 0; c < 3; c++) {
        GP_TRY(transform(log, &x, &y, c, h, load_light, &from, &m));
        struct energy e = {&m, p, p->power[p->channels == 1 ? 0 : c], v};
        double sum = 0.0;
        gp_parallel_do((int) p->columns, energy_column, &e);
        for (size_t i = 0; i < p->columns; i++)
            sum += e.column[i];
        // both spectra are twice theirs
        norm[c] = sqrt(sum / (16.0 * (double) x.n * (double) y.n));
        gp_fft_matrix_free(&m);
    }
out:
    gp_free(v);
    gp_fft_matrix_free(&m);
    gp_fft_plan_free(&x);
    gp_fft_plan_free(&y);
    return st;
}
