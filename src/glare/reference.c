#include "core/memory.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "glare/engine.h"
#include "glare/fft/lib.h"

#include <math.h>
#include <string.h>

/* Taps over which the plain loops would take minutes. */
static const double MOST_TAPS = 3e9;

struct plain {
    const struct gp_sources *src;
    const struct gp_kernel *k;
    double *layer;
};

/* layer(p) = sum over q of source(q) * kernel(p - q), one row of p. */
static void plain_row(void *ctx, int y, int thread)
{
    const struct plain *const s = ctx;
    const int w = s->src->w;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        double *const out = s->layer +
                            ((size_t) c * (size_t) s->src->h + (size_t) y) *
                                (size_t) w;
        memset(out, 0, (size_t) w * sizeof *out);
        for (int sy = 0; sy < s->src->h; sy++) {
            const int ky = y - sy + s->k->cy;
            if (ky < 0 || ky >= s->k->h)
                continue;
            const float *const row =
                s->k->k.c[c] + (size_t) ky * (size_t) s->k->w;
            for (uint32_t i = s->src->row[sy]; i < s->src->row[sy + 1]; i++) {
                const int at = s->src->x[i] - s->k->cx; // of kernel column 0
                for (int kx = 0; kx < s->k->w; kx++) {
                    if (at + kx >= 0 && at + kx < w)
                        out[at + kx] +=
                            (double) s->src->rgb[c][i] * (double) row[kx];
                }
            }
        }
    }
}

void gp_glare_reference_direct(const struct gp_sources *src,
                               const struct gp_kernel *kernel, double *layer)
{
    struct plain s = {src, kernel, layer};
    gp_parallel_do(src->h, plain_row, &s);
}

/* -- dense frames: complex two-dimensional transforms, in double ------------ */

struct grid {
    int nx, ny;
    double *a, *b; // nx * ny complex each
};

/* Rows, then columns, in place; z is scratch for two lines. */
static void transform(const struct gp_fftwd *lib, const struct grid *g,
                      fftw_plan row, fftw_plan column, double *a, double *z)
{
    for (int y = 0; y < g->ny; y++) {
        double *const line = a + 2 * (size_t) y * (size_t) g->nx;
        memcpy(z, line, 2 * sizeof(double) * (size_t) g->nx);
        lib->execute_dft(row, (void *) z, (void *) (z + 2 * (size_t) g->nx));
        memcpy(line, z + 2 * (size_t) g->nx,
               2 * sizeof(double) * (size_t) g->nx);
    }
    for (int x = 0; x < g->nx; x++) {
        double *const line = a + 2 * (size_t) x;
        for (int y = 0; y < g->ny; y++)
            memcpy(z + 2 * (size_t) y,
                   line + 2 * (size_t) y * (size_t) g->nx,
                   2 * sizeof(double));
        lib->execute_dft(column, (void *) z,
                         (void *) (z + 2 * (size_t) g->ny));
        for (int y = 0; y < g->ny; y++)
            memcpy(line + 2 * (size_t) y * (size_t) g->nx,
                   z + 2 * (size_t) (g->ny + y), 2 * sizeof(double));
    }
}

static void fill(const struct gp_sources *src, const struct gp_kernel *k,
                 int c, const struct grid *g)
{
    memset(g->a, 0, 2 * sizeof(double) * (size_t) g->nx * (size_t) g->ny);
    memset(g->b, 0, 2 * sizeof(double) * (size_t) g->nx * (size_t) g->ny);
    for (int y = 0; y < src->h; y++) {
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
            g->a[2 * ((size_t) y * (size_t) g->nx + (size_t) src->x[i])] =
                (double) src->rgb[c][i];
    }
    for (int y = 0; y < k->h; y++) {
        for (int x = 0; x < k->w; x++)
            g->b[2 * ((size_t) y * (size_t) g->nx + (size_t) x)] =
                (double) k->k.c[c][(size_t) y * (size_t) k->w + (size_t) x];
    }
}

static void multiply(const struct grid *g)
{
    const double scale = 1.0 / ((double) g->nx * g->ny);
    for (size_t i = 0; i < (size_t) g->nx * (size_t) g->ny; i++) {
        const double re = g->a[2 * i], im = g->a[2 * i + 1];
        g->a[2 * i] = scale * (re * g->b[2 * i] - im * g->b[2 * i + 1]);
        g->a[2 * i + 1] = scale * (re * g->b[2 * i + 1] + im * g->b[2 * i]);
    }
}

/* The full convolution's sample (x + cx, y + cy) is the layer's (x, y). */
static void take(const struct gp_sources *src, const struct gp_kernel *k,
                 int c, const struct grid *g, double *layer)
{
    for (int y = 0; y < src->h; y++) {
        for (int x = 0; x < src->w; x++) {
            const int gx = x + k->cx, gy = y + k->cy;
            const int inside = gx >= 0 && gx < src->w + k->w - 1 && gy >= 0 &&
                               gy < src->h + k->h - 1;
            layer[((size_t) c * (size_t) src->h + (size_t) y) *
                      (size_t) src->w + (size_t) x] =
                inside ? g->a[2 * ((size_t) gy * (size_t) g->nx + (size_t) gx)]
                       : 0.0;
        }
    }
}

static gp_status by_fft(const struct gp_log *log, const struct gp_sources *src,
                        const struct gp_kernel *k, double *layer)
{
    gp_status st;
    const struct gp_fftwd *lib;
    struct grid g = {
        gp_fft_length(src->w + k->w - 1), gp_fft_length(src->h + k->h - 1),
        NULL, NULL,
    };
    const size_t n = (size_t) g.nx * (size_t) g.ny;
    const int longest = g.nx > g.ny ? g.nx : g.ny;
    void *a = NULL, *b = NULL, *z = NULL;
    fftw_plan plan[4] = {0}; // rows and columns, there and back
    GP_TRY(gp_fftwd_open(log, &lib));
    GP_TRY(gp_alloc(log, "reference", n, 16, &a));
    GP_TRY(gp_alloc(log, "reference", n, 16, &b));
    GP_TRY(gp_alloc_zero(log, "reference", (size_t) longest, 32, &z));
    g.a = a;
    g.b = b;
    for (int i = 0; i < 4; i++) {
        const int length = i % 2 ? g.ny : g.nx;
        plan[i] = lib->plan_dft_1d(length, z,
                                   (void *) ((double *) z + 2 * length),
                                   i < 2 ? FFTW_FORWARD : FFTW_BACKWARD,
                                   FFTW_ESTIMATE | FFTW_UNALIGNED);
        if (!plan[i])
            GP_TRY(gp_fail_bare(log, GP_ERR_BUG,
                                "reference: FFTW makes no plan (length %d); verify "
                                "a smaller frame", length));
    }
    for (int c = 0; c < 3; c++) {
        fill(src, k, c, &g);
        transform(lib, &g, plan[0], plan[1], g.a, z);
        transform(lib, &g, plan[0], plan[1], g.b, z);
        multiply(&g);
        transform(lib, &g, plan[2], plan[3], g.a, z);
        take(src, k, c, &g, layer);
    }
out:
    for (int i = 0; i < 4; i++) {
        if (plan[i])
            lib->destroy_plan(plan[i]);
    }
    gp_free(a);
    gp_free(b);
    gp_free(z);
    return st;
}

gp_status gp_glare_reference(const struct gp_log *log,
                             const struct gp_sources *src,
                             const struct gp_kernel *kernel, double *layer)
{
    const double work = 3.0 * gp_direct_work(src, kernel->w, kernel->h,
                                             kernel->cx, kernel->cy);
    if (work > MOST_TAPS)
        return by_fft(log, src, kernel, layer);
    gp_glare_reference_direct(src, kernel, layer);
    return GP_OK;
}
