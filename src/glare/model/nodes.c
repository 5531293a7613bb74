// SPDX-License-Identifier: Apache-2.0
/* Light that goes by nodes of direction cosines: sky/cosines.h. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/pass.h"
#include "glare/model/model_priv.h"

static double squared_sinc(double x)
{
    return gp_sinc(x) * gp_sinc(x);
}

/* Light of one frequency, in pixels' periods, of which all that is finer than a pixel has
 * the same up to CUT of its first zero. There hardly anything else is left. */
void gp_finest_take(const struct gp_spectra *s, const int period[2],
                    double nodes, double own[3])
{
    static const double CUT = 0.9;
    const double step[2] = {nodes / period[0], nodes / period[1]};
    const int n = period[0] / 2 + 1, ny = period[1];
    const int x = gp_min((int) (CUT / step[0]), n - 1);
    const int y = gp_min((int) (CUT / step[1]), ny / 2);
    for (int c = 0; c < s->channels; c++) {
        const double across =
            (double) *gp_spectra_at(s, c, x, 0, ny) / squared_sinc(x * step[0]);
        const double down =
            (double) *gp_spectra_at(s, c, 0, y, ny) / squared_sinc(y * step[1]);
        own[c] = fmax(fmin(across, down), 0.0);
        for (int i = 0; i < n * ny; i++) {
            const double u = i % n * step[0];
            const double v = gp_min(i / n, ny - i / n) * step[1];
            if (u < 1.0 && v < 1.0)
                *gp_spectra_at(s, c, i % n, i / n, ny) -=
                    (float) (own[c] * squared_sinc(u) * squared_sinc(v));
        }
    }
}

// -- from D to K ---------------------------------------------------------------

/* A frequency of an axis: the inverse of what both splines keep of it, 0 beyond a
 * pixel's first zero; and the 2-norm of what one lets out at others, over what it
 * keeps. */
struct keeping {
    double inverse, others;
};

static struct keeping keep_at(double periods, double nodes)
{
    enum { IMAGES = 4 };
    double kept = 0.0, square = 0.0;
    for (int i = -IMAGES; i <= IMAGES; i++) {
        const double b = gp_pow(squared_sinc(periods + i), 4.0); // degree 7
        if (i)
            square += b * b;
        else
            kept = b;
    }
    return (struct keeping) {periods * nodes < 1.0 ? 1.0 / (kept * kept) : 0.0,
                             sqrt(square) / kept};
}

struct dividing {
    int w, h;
    float *plane;             // of one channel
    struct gp_transform t[2]; // of x, of y
    struct gp_fft_matrix m;
    struct keeping *at[2]; // owned: at[0]
    char *scratch;         // of a thread: two arrays of points
    double *wrong;         // of a thread
};

static void load_row(const void *ctx, GP_UNUSED int c, int j, float *z)
{
    const struct dividing *const d = ctx;
    memcpy(z, d->plane + (size_t) j * (size_t) d->w, (size_t) d->w * sizeof *z);
}

/* A block of columns; back, re and im are exchanged. */
static void divide_columns(void *ctx, int block, int thread)
{
    enum { LINES = GP_FLOAT_LINES, POINT = 2 * LINES };
    const struct dividing *const d = ctx;
    const int n = d->t[1].n, nx = d->t[0].n;
    const size_t room = gp_transform_room(n) / sizeof(float);
    float *const in =
        (float *) (void *) d->scratch + 2 * room * (size_t) thread;
    float *const rows =
        (float *) d->m.z[0] + (size_t) block * d->m.pitch * POINT;
    memcpy(in, rows, (size_t) d->h * GP_POINT_BYTES);
    memset(in + (size_t) d->h * POINT, 0, (size_t) (n - d->h) * GP_POINT_BYTES);
    float *const z = gp_float_transform(&d->t[1], in, in + room);
    for (int k = 0; k < n; k++) {
        const struct keeping *const b = &d->at[1][gp_min(k, n - k)];
        for (int i = 0; i < LINES; i++) {
            const struct keeping *const a =
                &d->at[0][gp_min(block * LINES + i, nx / 2)];
            float *const re = z + k * POINT + i, *const im = re + LINES;
            const float by = (float) (a->inverse * b->inverse);
            const double square =
                (1.0 + a->others * a->others) * (1.0 + b->others * b->others) -
                1.0;
            // the matrix holds twice the spectrum
            const double light =
                by > 0.0f ? 0.5 * gp_hypot((double) *re, (double) *im) : 0.0;
            const float other = *re;
            d->wrong[thread] =
                fmax(d->wrong[thread], light * (4.0 * sqrt(square) + square));
            *re = by * *im;
            *im = by * other;
        }
    }
    const float *const out =
        gp_float_transform(&d->t[1], z, z == in ? in + room : in);
    for (int y = 0; y < d->h; y++)
        for (int i = 0; i < POINT; i++)
            rows[y * POINT + i] = out[y * POINT + (i + LINES) % POINT];
}

static void store_row(const void *ctx, GP_UNUSED int c, int j, const float *z)
{
    const struct dividing *const d = ctx;
    const float scale = (float) (0.5 / ((double) d->t[0].n * d->t[1].n));
    for (int x = 0; x < d->w; x++)
        d->plane[(size_t) j * (size_t) d->w + (size_t) x] = scale * z[x];
}

gp_status gp_nodes_divide(const struct gp_log *log, int w, int h, double nodes,
                          struct gp_planes *k, double *wrong)
{
    enum { APART = 64 }; // from what is on the torus' other side
    const int nx = gp_fft_length(w + APART), ny = gp_fft_length(h + APART);
    const size_t threads = (size_t) gp_threads();
    struct dividing d = {.w = w, .h = h};
    gp_status st;
    GP_TRY(gp_fft_pair_make(log, nx, ny, false, d.t));
    const struct gp_fft_request fft = {
        .log = log,
        .t = d.t,
        .channels = 1,
    };
    GP_TRY(
        gp_fft_matrix_make(log, (struct gp_fft_numbers) {0}, 1, nx, h, &d.m));
    GP_TRY(gp_alloc(log, "kernel", 2 * threads, gp_transform_room(ny),
                    &d.scratch));
    GP_TRY(gp_alloc_zero(log, "kernel", threads, sizeof *d.wrong, &d.wrong));
    GP_TRY(gp_alloc(log, "kernel", (size_t) (nx / 2 + 1 + ny / 2 + 1),
                    sizeof *d.at[0], &d.at[0]));
    d.at[1] = d.at[0] + nx / 2 + 1;
    for (int i = 0; i <= nx / 2; i++)
        d.at[0][i] = keep_at((double) i / nx, nodes);
    for (int i = 0; i <= ny / 2; i++)
        d.at[1][i] = keep_at((double) i / ny, nodes);
    for (int c = 0; c < 3; c++) {
        d.plane = k->c[c];
        GP_TRY(gp_fft_rows_in(&fft, h, load_row, &d, &d.m));
        gp_parallel_do(d.m.blocks, divide_columns, &d);
        GP_TRY(gp_fft_rows_out(&fft, &d.m, h, store_row, &d));
    }
    *wrong = 0.0;
    for (size_t i = 0; i < threads; i++)
        *wrong = fmax(*wrong, d.wrong[i]);
out:
    gp_fft_pair_free(d.t);
    gp_fft_matrix_free(&d.m);
    gp_free(d.scratch);
    gp_free(d.wrong);
    gp_free(d.at[0]);
    return st;
}
