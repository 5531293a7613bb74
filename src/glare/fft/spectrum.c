#include "glare/fft/spectrum.h"

#include "core/memory.h"

#include <stdlib.h>

/* v modulo n, in [0, n). */
static int wrap(int v, int n)
{
    return v % n < 0 ? v % n + n : v % n;
}

struct kernel_rows {
    const struct gp_kernel *kernel;
    const struct gp_fft_placing *p;
    int core;
};

/* Row of offset dy = taps.y0 + j, each sample at its offset modulo nx. */
static void load_kernel(const void *ctx, int c, int j, float *z)
{
    const struct kernel_rows *const r = ctx;
    const struct gp_kernel *const k = r->kernel;
    const int dy = r->p->taps.y0 + j, nx = r->p->nx;
    const float *const row =
        k->k.c[c] + (size_t) (dy + k->cy) * (size_t) k->w + k->cx;
    for (int dx = r->p->taps.x0; dx < r->p->taps.x1; dx++) {
        const int inside = abs(dx) <= r->core && abs(dy) <= r->core;
        if (!inside)
            z[2 * wrap(dx, nx)] = row[dx];
    }
}

/* Rows first .. first + n at places modulo ny. */
static gp_status make_places(const struct gp_log *log, int first, int n,
                             int ny, int **out)
{
    void *v;
    gp_status st = gp_alloc(log, "transform", (size_t) n, sizeof **out, &v);
    if (st)
        return st;
    *out = v;
    for (int j = 0; j < n; j++)
        (*out)[j] = wrap(first + j, ny);
    return GP_OK;
}

struct gp_fft_matrix gp_fft_channel(const struct gp_fft_matrix *m, int c)
{
    struct gp_fft_matrix view = {.columns = m->columns, .pitch = m->pitch};
    view.z[c] = m->z[0];
    return view;
}

gp_status gp_fft_spectrum(const struct gp_fft_job *fft,
                          const struct gp_kernel *k,
                          const struct gp_fft_placing *p, int core,
                          struct gp_fft_matrix *out)
{
    gp_status st = GP_OK;
    struct gp_fft_matrix rows = {0}, spectrum = {0};
    int *places = NULL;
    const int n = gp_rect_h(p->taps), channels = k->grey ? 1 : 3;
    const struct kernel_rows from = {.kernel = k, .p = p, .core = core};
    struct gp_fft_job one = *fft;
    // two factors 1/2 were left out on the way in: the kernel's rows, the
    // sources' rows
    const float scale = (float) (0.25 / ((double) p->nx * p->ny));
    GP_TRY(gp_fft_matrix_make(fft->log, 1, p->nx, n, &rows));
    GP_TRY(gp_fft_matrix_make(fft->log, channels, p->nx, p->ny, &spectrum));
    GP_TRY(make_places(fft->log, p->taps.y0, n, p->ny, &places));
    for (one.channel = 0; one.channel < channels; one.channel++) {
        struct gp_fft_matrix m = gp_fft_channel(&rows, one.channel);
        GP_TRY(gp_fft_rows_in(&one, n, load_kernel, &from, &m));
        GP_TRY(gp_fft_columns(&one, &m, n, places, scale, &spectrum));
    }
    *out = spectrum;
    spectrum = (struct gp_fft_matrix) {0};
out:
    gp_fft_matrix_free(&spectrum);
    gp_free(places);
    gp_fft_matrix_free(&rows);
    return st;
}
