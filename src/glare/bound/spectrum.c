#include "glare/bound/spectrum.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/fft/fft.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    COLUMNS = 16,           // a task takes
    MOST_POINTS = 1 << 26,  // of a plane
};

/* Columns whose |K|^2 is nowhere over this share of its mean are not
 * transformed but taken at their largest: they hardly count. */
static const double FAINT = 0.25;

/* Rounding of a transform of n points relative to its norm, two rows to a
 * complex one (Higham 2002, theorem 24.2). */
static double rounding(const struct gp_power *p)
{
    return 2.0 * 5.42 * 0x1p-24 * log2((double) p->nx * p->ny);
}

// -- the kernel ---------------------------------------------------------------

/* The kernel that counts. */
struct part {
    const struct gp_kernel *k;
    struct gp_rect crop;
    bool tail;
};

static int clamp(long long v, int low, int high)
{
    return v < low ? low : v > high ? high : (int) v;
}

static struct gp_rect crop_of(const struct gp_kernel *k, int x, int y)
{
    const long long cx = k->cx, cy = k->cy;
    return (struct gp_rect) {
        clamp(cx - x, 0, k->w), clamp(cy - y, 0, k->h),
        clamp(cx + x + 1, 0, k->w), clamp(cy + y + 1, 0, k->h),
    };
}

static float sample(const struct part *p, int c, int x, int y)
{
    const bool core = p->tail && abs(x - p->k->cx) <= GP_CORE_RADIUS &&
                      abs(y - p->k->cy) <= GP_CORE_RADIUS;
    return core ? 0.0f : p->k->k.c[c][(size_t) y * (size_t) p->k->w +
                                      (size_t) x];
}

static void load_kernel(const void *ctx, int c, int j, float *z)
{
    const struct part *const p = ctx;
    for (int x = p->crop.x0; x < p->crop.x1; x++)
        z[2 * (x - p->crop.x0)] = sample(p, c, x, p->crop.y0 + j);
}

static double sum_magnitudes(const struct part *p, int c)
{
    double sum = 0.0;
    for (int y = p->crop.y0; y < p->crop.y1; y++) {
        for (int x = p->crop.x0; x < p->crop.x1; x++)
            sum += fabs((double) sample(p, c, x, y));
    }
    return sum;
}

/* The spectrum of one channel to magnitudes, largest and mean ones. Where the
 * kernel stands on the torus does not change |K|. */
static void take_power(const struct gp_fft_matrix *m, int c,
                       struct gp_power *p)
{
    const double extra = rounding(p) * p->norm1[c];
    double all = 0.0;
    for (int k = 0; k <= p->nx / 2; k++) {
        const float *const z = m->z[c] + 2 * (size_t) k * m->pitch;
        float *const to = p->power[c] + (size_t) k * (size_t) p->ny;
        float most = 0.0f;
        double sum = 0.0;
        for (int y = 0; y < p->ny; y++) {
            const double re = (double) z[2 * y], im = (double) z[2 * y + 1];
            const double v = sqrt(re * re + im * im) + extra;
            to[y] = (float) (v * (1.0 + 0x1p-20)); // never rounded down
            sum += v * v;
            most = fmaxf(most, to[y]);
        }
        p->most[c][k] = most;
        all += sum * (k == 0 || k == p->nx / 2 ? 1.0 : 2.0);
    }
    p->mean2[c] = all / ((double) p->nx * p->ny);
}

static gp_status transform(const struct gp_log *log, const struct part *part,
                           struct gp_power *p)
{
    gp_status st;
    const int rows = gp_rect_h(part->crop);
    struct gp_fft_matrix in = {0}, out = {0};
    void *v = NULL;
    const struct gp_fft_job job = {log, &p->x, &p->y, 0, p->channels};
    const size_t points = (size_t) (p->nx / 2 + 1) * (size_t) p->ny;
    GP_TRY(gp_fft_plan_make(log, p->nx, GP_FFT_PLAN_ESTIMATE, NULL, &p->x));
    GP_TRY(gp_fft_plan_make(log, p->ny, GP_FFT_PLAN_ESTIMATE, NULL, &p->y));
    for (int c = 0; c < p->channels; c++) {
        GP_TRY(gp_alloc(log, "bound", points, sizeof(float), &v));
        p->power[c] = v;
        GP_TRY(gp_alloc(log, "bound", (size_t) p->nx / 2 + 1, sizeof(float),
                        &v));
        p->most[c] = v;
    }
    GP_TRY(gp_alloc(log, "bound", (size_t) rows, sizeof(int), &v));
    int *const place = v;
    for (int y = 0; y < rows; y++)
        place[y] = y;
    st = gp_fft_matrix_make(log, p->channels, p->nx, rows, &in);
    if (!st)
        st = gp_fft_matrix_make(log, p->channels, p->nx, p->ny, &out);
    if (!st)
        st = gp_fft_rows_in(&job, rows, load_kernel, part, &in);
    if (!st) // the matrix holds twice the spectrum
        st = gp_fft_columns(&job, &in, rows, place, 0.5f, &out);
    for (int c = 0; !st && c < p->channels; c++)
        take_power(&out, c, p);
    gp_free(place);
out:
    gp_fft_matrix_free(&in);
    gp_fft_matrix_free(&out);
    return st;
}

/* The least period on which what wraps around stays off n pixels: sources lie
 * up to `pad` outside them, the kernel reaches from -before to after. */
static int period(int n, int pad, int before, int after)
{
    const int reach = before > after ? before : after;
    const int whole = n + 2 * pad; // the residue has to fit
    const int least = n + pad + (reach > 0 ? reach : 0);
    const int kernel = before + after + 1;
    const int most = least > whole ? least : whole;
    return gp_fft_length(most > kernel ? most : kernel);
}

gp_status gp_power_make(const struct gp_log *log,
                        const struct gp_kernel *kernel, bool tail, int w,
                        int h, int pad, struct gp_power *out)
{
    const struct gp_fftwf *lib;
    const struct part part = {
        .k = kernel, .tail = tail,
        .crop = crop_of(kernel, w - 1 + pad, h - 1 + pad),
    };
    struct gp_power p = {.channels = kernel->grey ? 1 : 3};
    gp_status st = GP_OK;
    for (int c = 0; c < p.channels; c++)
        p.norm1[c] = sum_magnitudes(&part, c);
    if (!gp_rect_empty(part.crop) && !gp_fftwf_open(NULL, &lib)) {
        p.nx = period(w, pad, kernel->cx - part.crop.x0,
                      part.crop.x1 - 1 - kernel->cx);
        p.ny = period(h, pad, kernel->cy - part.crop.y0,
                      part.crop.y1 - 1 - kernel->cy);
    }
    if ((double) p.nx * p.ny > MOST_POINTS)
        p.nx = p.ny = 0;
    if (p.nx)
        st = transform(log, &part, &p);
    if (st)
        gp_power_free(&p);
    else
        *out = p;
    return st;
}

void gp_power_free(struct gp_power *p)
{
    for (int c = 0; c < 3; c++) {
        gp_free(p->power[c]);
        gp_free(p->most[c]);
    }
    gp_fft_plan_free(&p->x);
    gp_fft_plan_free(&p->y);
    *p = (struct gp_power) {0};
}

// -- the residue --------------------------------------------------------------

struct adding {
    const struct gp_power *p;
    const struct gp_residue *r;
    const struct gp_fft_matrix *m;
    const struct gp_fftwf *lib;
    int tasks;      // for each channel
    double *sum;    // of each task
    float *buffer;  // two columns for each thread
};

static void load_residue(const void *ctx, int c, int j, float *z)
{
    const struct gp_residue *const r = ctx;
    const int width = r->w + 2 * r->pad;
    const float *const row =
        r->d.c[c] + (size_t) r->row[j] * (size_t) width;
    for (int x = 0; x < width; x++)
        z[2 * x] = row[x];
}

/* Sum of |power[y] z[y]|^2, in eight parts so that it becomes vector code. In
 * double: squares may leave the range of float. */
GP_CLONES static double weigh(const float *power, const float *z, int n)
{
    enum { PARTS = 8 };
    double part[PARTS] = {0};
    for (int y = 0; y < n; y += PARTS) { // n is a multiple of 8
        for (int i = 0; i < PARTS; i++) {
            const double re = (double) z[2 * (y + i)];
            const double im = (double) z[2 * (y + i) + 1];
            const double k = (double) power[y + i];
            part[i] += k * k * (re * re + im * im);
        }
    }
    double sum = 0.0;
    for (int i = 0; i < PARTS; i++)
        sum += part[i];
    return sum;
}

GP_CLONES static double energy(const float *z, int n)
{
    enum { PARTS = 8 };
    double part[PARTS] = {0}, sum = 0.0;
    int i = 0;
    for (; i + PARTS <= 2 * n; i += PARTS) {
        for (int k = 0; k < PARTS; k++)
            part[k] += (double) z[i + k] * (double) z[i + k];
    }
    for (; i < 2 * n; i++)
        sum += (double) z[i] * (double) z[i];
    for (int k = 0; k < PARTS; k++)
        sum += part[k];
    return sum;
}

/* Column k of channel c: sum over its rows of |K|^2 |2 D|^2. */
static double add_column(const struct adding *a, int c, int k, float *spread,
                         float *whole)
{
    const struct gp_power *const p = a->p;
    const int kc = p->channels == 1 ? 0 : c;
    const float *const z = a->m->z[c] + 2 * (size_t) k * a->m->pitch;
    const double most = (double) p->most[kc][k];
    if (most * most <= FAINT * p->mean2[kc])
        return most * most * p->ny * energy(z, a->r->rows);
    memset(spread, 0, 2 * sizeof(float) * (size_t) p->ny);
    for (int j = 0; j < a->r->rows; j++) {
        spread[2 * a->r->row[j]] = z[2 * j];
        spread[2 * a->r->row[j] + 1] = z[2 * j + 1];
    }
    a->lib->execute_dft(p->y.forward, (void *) spread, (void *) whole);
    return weigh(p->power[kc] + (size_t) k * (size_t) p->ny, whole, p->ny);
}

static void add_columns(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const int c = i / a->tasks, k0 = i % a->tasks * COLUMNS;
    const int last = a->p->nx / 2;
    float *const spread = a->buffer + 4 * (size_t) a->p->ny * (size_t) thread;
    double sum = 0.0;
    for (int k = k0; k < k0 + COLUMNS && k <= last; k++)
        sum += add_column(a, c, k, spread, spread + 2 * (size_t) a->p->ny) *
               (k == 0 || k == last ? 1.0 : 2.0);
    a->sum[i] = sum;
}

/* sum |K|^2 |2 D|^2 for each channel. */
static gp_status add_up(const struct gp_log *log, const struct gp_power *p,
                        const struct gp_residue *r, double out[3])
{
    gp_status st;
    void *sum = NULL, *buffer = NULL;
    struct gp_fft_matrix m = {0};
    const struct gp_fft_job job = {log, &p->x, &p->y, 0, 3};
    struct adding a = {
        .p = p, .r = r, .m = &m, .tasks = (p->nx / 2 + COLUMNS) / COLUMNS,
    };
    GP_TRY(gp_fftwf_open(log, &a.lib));
    GP_TRY(gp_fft_matrix_make(log, 3, p->nx, r->rows, &m));
    GP_TRY(gp_alloc(log, "bound", (size_t) a.tasks * 3, sizeof *a.sum, &sum));
    // (lengths are multiples of 8: columns stay aligned)
    GP_TRY(gp_alloc(log, "bound", 4 * (size_t) p->ny * (size_t) gp_threads(),
                    sizeof *a.buffer, &buffer));
    a.sum = sum;
    a.buffer = buffer;
    GP_TRY(gp_fft_rows_in(&job, r->rows, load_residue, r, &m));
    gp_parallel_do(3 * a.tasks, add_columns, &a);
    for (int c = 0; c < 3; c++) {
        out[c] = 0.0;
        for (int i = 0; i < a.tasks; i++)
            out[c] += a.sum[c * a.tasks + i];
    }
out:
    gp_fft_matrix_free(&m);
    gp_free(sum);
    gp_free(buffer);
    return st;
}

gp_status gp_power_bound(const struct gp_log *log, const struct gp_power *p,
                         const struct gp_residue *r, double out[3])
{
    gp_status st = GP_OK;
    double sum[3] = {0};
    if (r->rows && p->nx)
        st = add_up(log, p, r, sum);
    for (int c = 0; !st && c < 3; c++) {
        const double norm1 = p->norm1[p->channels == 1 ? 0 : c];
        // Young's inequality where there is no transform
        out[c] = p->nx ? sqrt(sum[c] / (4.0 * p->nx * p->ny)) +
                             norm1 * rounding(p) * r->norm2[c]
                       : norm1 * r->norm2[c];
        out[c] += norm1 * r->rounding[c];
    }
    return st;
}
