#include "core/memory.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "glare/fft/fft.h"
#include "glare/glare_priv.h"

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

/* -- dense frames: complex two-dimensional transforms, in double ----------- */

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
            memcpy(z + 2 * (size_t) y, line + 2 * (size_t) y * (size_t) g->nx,
                2 * sizeof(double));
        lib->execute_dft(column, (void *) z, (void *) (z + 2 * (size_t) g->ny));
        for (int y = 0; y < g->ny; y++)
            memcpy(line + 2 * (size_t) y * (size_t) g->nx,
                   z + 2 * (size_t) (g->ny + y), 2 * sizeof(double));
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
    const double scale = 1.0 / ((double) g.nx * g.ny);
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
                                "reference: FFTW makes no plan (length %d); "
                                "verify a smaller frame", length));
    }
    for (int c = 0; c < 3; c++) {
        memset(g.a, 0, 2 * sizeof(double) * n);
        memset(g.b, 0, 2 * sizeof(double) * n);
        for (int y = 0; y < src->h; y++) {
            for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
                g.a[2 * ((size_t) y * (size_t) g.nx + (size_t) src->x[i])] =
                    (double) src->rgb[c][i];
        }
        for (int y = 0; y < k->h; y++) {
            for (int x = 0; x < k->w; x++)
                g.b[2 * ((size_t) y * (size_t) g.nx + (size_t) x)] =
                    (double) k->k.c[c][(size_t) y * (size_t) k->w +
                                       (size_t) x];
        }
        transform(lib, &g, plan[0], plan[1], g.a, z);
        transform(lib, &g, plan[0], plan[1], g.b, z);
        for (size_t i = 0; i < n; i++) {
            const double re = g.a[2 * i], im = g.a[2 * i + 1];
            g.a[2 * i] = scale * (re * g.b[2 * i] - im * g.b[2 * i + 1]);
            g.a[2 * i + 1] = scale * (re * g.b[2 * i + 1] + im * g.b[2 * i]);
        }
        transform(lib, &g, plan[2], plan[3], g.a, z);
        // the full convolution's sample (x + cx, y + cy) is the layer's (x, y)
        double *out = layer + (size_t) c * (size_t) src->w * (size_t) src->h;
        for (int gy = k->cy; gy < src->h + k->cy; gy++) {
            for (int gx = k->cx; gx < src->w + k->cx; gx++) {
                const bool inside = gx >= 0 && gx < src->w + k->w - 1 &&
                                    gy >= 0 && gy < src->h + k->h - 1;
                *out++ = inside ? g.a[2 * ((size_t) gy * (size_t) g.nx +
                                           (size_t) gx)] : 0.0;
            }
        }
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
    const struct gp_sources *src, const struct gp_kernel *kernel, double *layer)
{
    const double work = 3.0 * gp_direct_work(src, kernel->w, kernel->h,
                                             kernel->cx, kernel->cy);
    if (work > MOST_TAPS)
        return by_fft(log, src, kernel, layer);
    gp_glare_reference_direct(src, kernel, layer);
    return GP_OK;
}

// -- errors against the truth ------------------------------------------------

/* The larger; a layer that is not a number is as wrong as can be. */
static double worse(double a, double b)
{
    return b != b ? INFINITY : fmax(a, b);
}

void gp_glare_measure(const struct gp_frame *f, const struct gp_planes *layer,
    const double *exact, float gain, struct gp_glare_error *out)
{
    const size_t n = gp_frame_pixels(f);
    double square = 0.0, exact_square = 0.0, sum = 0.0, exact_sum = 0.0;
    double max_abs = 0.0, max_rel = 0.0, peak = 0.0;
    for (size_t i = 0; i < n; i++) {
        double composite = 0.0;
        for (int c = 0; c < 3; c++) {
            const double want = exact[(size_t) c * n + i];
            const double got = (double) layer->c[c][i];
            composite += (double) f->luminance[c] *
                         ((double) f->rgb.c[c][i] + (double) gain * want);
            square += (got - want) * (got - want);
            exact_square += want * want;
            max_abs = worse(max_abs, fabs(got - want));
            sum += got;
            exact_sum += want;
        }
        peak = fmax(peak, composite);
    }
    // relative to a pixel's own value, for which the peak must be known
    for (size_t i = 0; i < n; i++) {
        double composite = 0.0, wrong = 0.0;
        for (int c = 0; c < 3; c++) {
            const double want = exact[(size_t) c * n + i];
            const double weight = (double) f->luminance[c];
            composite += weight *
                         ((double) f->rgb.c[c][i] + (double) gain * want);
            wrong += weight * (double) gain *
                     ((double) layer->c[c][i] - want);
        }
        if (wrong != 0.0)
            max_rel = worse(max_rel, fabs(wrong) / (fmax(composite, 0.0) +
                                                    1e-6 * peak));
    }
    *out = (struct gp_glare_error) {
        .rel_l2 = sqrt(exact_square > 0.0 ? square / exact_square : square),
        .max_rel = max_rel,
        .max_abs = max_abs,
        .flux_error = fabs(exact_sum > 0.0 ? sum / exact_sum - 1.0 : sum),
    };
}
