/* Fraunhofer diffraction: from the light that passes a pupil to a shape.
 *
 *   I(q)    = |sum over cells of t exp(2 pi i path / l) exp(-2 pi i q x)|^2
 *   A(u)    = sum over q of I(q) exp(2 pi i q u) / sum over q of I(q)
 *   OTF_c(f) = sum over wavelengths l of w_c(l) A(l f)
 *   kernel_c(x) = sum over f of OTF_c(f) sinc(f)^2 exp(-2 pi i f x)
 *
 * A is the pupil's autocorrelation by the lag u in mm, f is in cycles per
 * radian, sinc is a pixel's: Goodman, Introduction to Fourier Optics,
 * sections 4.3 and 6.3. The spectrum is summed in the transfer function, one
 * transform a channel; OTF_c(0) is 1, so no light is lost. A channel of a
 * sample outside of the primaries' gamut comes out negative, and is folded in at
 * constant luminance.
 *
 * A is linear between lags, as that of a pupil of square cells. Pixels wider than
 * the finest light alias frequencies: two sparse matrices map A's rows and
 * columns to frequencies, and a row of a matrix holds all the lags that fall on
 * one frequency.
 *
 * The kernel is periodic: light from beyond N / 2 pixels wraps to the other
 * side. OTFs are means over steps of frequency by a hat, which multiplies
 * the unbounded kernel by sinc(x / N)^2 in x and y, and the result is divided
 * by it: light that wraps to x from x - N is down to (x / (N - x))^2, a quarter
 * at the reach, a 25th at half of it, as N is three times the reach. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/model/model_priv.h"

#include <stdlib.h>

enum {
    MOST_CELLS = 2048, // of a pupil, along a side
    LEAST_CELLS = 512,
    LANES = 16,        // columns of the kernel's spectrum made together
};

// -- from lags to frequencies -------------------------------------------------

/* Shares of lags first .. first + n - 1 in a step of frequency. */
struct lag_row {
    int first, n;
    size_t at; // of its weights
};

/* A lag's share in a frequency. */
struct lag_share {
    int lag;
    float weight;
};

/* Rows -edge .. edge of frequencies of a kernel of `period` pixels. Those that
 * fall on a frequency k from 0 to half of the period are put together as well,
 * in order of their lags: folded[at[k]] up to folded[at[k + 1]]. */
struct lag_matrix {
    int edge, period;
    double step; // of frequencies, in cells of lag
    struct lag_row *row;
    float *weight;
    struct lag_share *folded;
    int *at;
};

static void lag_matrix_free(struct lag_matrix *m)
{
    gp_free(m->row);
    gp_free(m->weight);
    gp_free(m->folded);
    gp_free(m->at);
    *m = (struct lag_matrix) {0};
}

/* The second integral of the hat function up to t. */
static double ramp(double t)
{
    const double a = 1.0 + t, b = 1.0 - t;
    return t <= -1.0 ? 0.0
           : t < 0.0 ? a * a * a / 6.0
           : t < 1.0 ? t + b * b * b / 6.0
                     : t;
}

/* The first row whose frequency is k modulo the period. */
static int first_row(const struct lag_matrix *m, int k)
{
    return (k + m->edge) % m->period;
}

static gp_status fold(const struct gp_log *log, size_t weights,
                      struct lag_matrix *m)
{
    const int half = m->period / 2;
    gp_status st = gp_alloc(log, "kernel", (size_t) half + 2, sizeof *m->at,
                            &m->at);
    if (!st)
        st = gp_alloc(log, "kernel", weights, sizeof *m->folded, &m->folded);
    if (st)
        return st;
    int n = 0;
    for (int k = 0; k <= half; k++) {
        m->at[k] = n;
        for (int r = first_row(m, k); r <= 2 * m->edge; r += m->period) {
            const struct lag_row *const row = &m->row[r];
            for (int i = 0; i < row->n; i++)
                m->folded[n++] = (struct lag_share) {
                    row->first + i, m->weight[row->at + (size_t) i]};
        }
    }
    m->at[half + 1] = n;
    return GP_OK;
}

/* Cells go from -n to n. */
static gp_status lag_matrix_make(const struct gp_log *log, int n, double step,
                                 int period, struct lag_matrix *out)
{
    struct lag_matrix m = {.edge = (int) ceil(n / step + 1.0),
                           .period = period, .step = step};
    const size_t rows = 2 * (size_t) m.edge + 1;
    const size_t most = (size_t) ceil(2.0 * step) + 3;
    size_t at = 0;
    gp_status st = gp_alloc(log, "kernel", rows, sizeof *m.row, &m.row);
    if (!st)
        st = gp_alloc(log, "kernel", rows * most, sizeof *m.weight, &m.weight);
    for (size_t i = 0; i < rows && !st; i++) {
        const int k = (int) i - m.edge;
        // a mean over steps to both sides, by a hat of their width
        const double low = (k - 1.0) * step, high = (k + 1.0) * step;
        // the pixel that shines and the one that is lit
        const double pixel = gp_sinc((double) k / period) / step;
        const int first = gp_max((int) floor(low), -n);
        const int last = gp_min((int) ceil(high), n);
        m.row[i] = (struct lag_row) {first, gp_max(last - first + 1, 0), at};
        for (int u = first; u <= last; u++)
            m.weight[at++] = (float) (pixel * pixel *
                                      (ramp(high - u) + ramp(low - u) -
                                       2.0 * ramp(k * step - u)));
    }
    if (!st)
        st = fold(log, at, &m);
    if (st)
        lag_matrix_free(&m);
    else
        *out = m;
    return st;
}

/* Spectra of the kernel: [c][block of LANES x][y][x in it], x in [0, nx / 2],
 * y in [0, ny). */
struct spectra {
    int blocks;
    float *re[3], *im[3];
    int channels;
};

/* One wavelength; matrices may be the same. */
struct band {
    double rgb[3];
    const struct lag_matrix *x, *y;
    struct lag_matrix own[2];
};

enum { MOST_BANDS = 32 }; // summed together

static void bands_free(struct band *b, int n)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 2; k++)
            lag_matrix_free(&b[i].own[k]);
    }
}

enum { STRIP = GP_LAG_STRIP };

/* Lags of a strip as the compiler keeps them in registers. */
typedef float eight __attribute__((vector_size(32), may_alias));
enum { EIGHTS = STRIP / 8, LANE_EIGHTS = LANES / 8 };

struct summing {
    const struct gp_lags *a;
    const struct spectra *s;
    const struct band *band;
    int bands;
    int strip;
    int edge;        // lags u beyond which the strip is 0
};

/* Sums lags u of one plane of a strip for frequency k, to out[0]; as many for
 * -k to out[1]. `strip` has those of u = 0. */
static inline __attribute__((always_inline)) void
sum_lags(const struct lag_matrix *m, const float *strip, int edge, int k,
         float *restrict out0, float *restrict out1)
{
    eight sum[2][EIGHTS] = {0};
    const struct lag_share *at = m->folded + m->at[k];
    const struct lag_share *end = m->folded + m->at[k + 1];
    while (at < end && at->lag < -edge)
        at++;
    while (at < end && end[-1].lag > edge)
        end--;
    for (; at < end; at++) {
        const eight *const plus = (const eight *) (strip + at->lag * STRIP);
        const eight *const minus = (const eight *) (strip - at->lag * STRIP);
        for (int i = 0; i < EIGHTS; i++) {
            sum[0][i] += at->weight * plus[i];
            sum[1][i] += at->weight * minus[i];
        }
    }
    memcpy(out0, sum[0], sizeof sum[0]);
    memcpy(out1, sum[1], sizeof sum[1]);
}

/* Adds the strip's lags v, and -v, of LANES columns to rows y of the spectrum:
 * t[0] and t[1], [v][lane]. */
static inline __attribute__((always_inline)) void
sum_rows(const struct summing *s, const struct band *b, int block,
         eight (*t)[STRIP][LANE_EIGHTS], float *const to[3])
{
    const struct lag_matrix *const m = b->y;
    const float scale = (float) (1.0 / s->a->sum);
    const int v0 = s->strip * STRIP, end = v0 + STRIP;
    const int low = gp_max((int) floor((v0 - 1) / m->step) - 1, -m->edge);
    const int high = gp_min((int) ceil((end + 1) / m->step) + 1, m->edge);
    for (int k = low; k <= high; k++) {
        const struct lag_row *const row = &m->row[k + m->edge];
        const int first = gp_max(row->first, v0);
        const int last = gp_min(row->first + row->n, end);
        const int turns = k % m->period;
        const int y[2] = {turns < 0 ? turns + m->period : turns,
                          turns > 0 ? m->period - turns : -turns};
        eight sum[2][LANE_EIGHTS] = {0};
        for (int v = first; v < last; v++) {
            const float w = m->weight[row->at + (size_t) (v - row->first)];
            for (int i = 0; i < 2 * LANE_EIGHTS; i++)
                sum[i % 2][i / 2] += w * t[i % 2][v - v0][i / 2];
        }
        for (int side = 0; side < 2 && first < last; side++) {
            const size_t at = ((size_t) block * (size_t) m->period +
                               (size_t) y[side]) * LANES;
            for (int c = 0; c < s->s->channels; c++) {
                const float w = scale * (float) b->rgb[c];
                eight *const out = (eight *) (to[c] + at);
                for (int l = 0; l < LANE_EIGHTS; l++)
                    out[l] += w * sum[side][l];
            }
        }
    }
}

/* Adds a strip of lags to LANES columns of the spectrum at all wavelengths. A
 * at (u, -v) is conjugate to that at (-u, v): the column of -k. */
GP_CLONES static void sum_strip(void *ctx, int block, int thread)
{
    const struct summing *const s = ctx;
    const size_t at = gp_lag_at(s->a, 0, s->strip * STRIP);
    float sums[2][LANES][STRIP] = {0};
    eight t[2][STRIP][LANE_EIGHTS];
    (void) thread;
    for (int i = 0; i < s->bands; i++) {
        const struct band *const b = &s->band[i];
        const int lanes =
            gp_min(LANES, b->x->period / 2 + 1 - block * LANES);
        for (int plane = 0; plane < (s->a->im ? 2 : 1); plane++) {
            const float *const strip = (plane ? s->a->im : s->a->re) + at;
            const float sign = plane ? -1.0f : 1.0f;
            for (int l = 0; l < lanes; l++)
                sum_lags(b->x, strip, s->edge, block * LANES + l, sums[0][l],
                         sums[1][l]);
            for (int v = 0; v < STRIP; v++) {
                float columns[2][LANES];
                for (int l = 0; l < LANES; l++) {
                    columns[0][l] = sums[0][l][v];
                    columns[1][l] = sign * sums[1][l][v];
                }
                memcpy(t[0][v], columns[0], sizeof t[0][v]);
                memcpy(t[1][v], columns[1], sizeof t[1][v]);
            }
            if (s->strip == 0) // v = 0 is no other's counterpart
                memset(t[1][0], 0, sizeof t[1][0]);
            sum_rows(s, b, block, t, plane ? s->s->im : s->s->re);
        }
    }
}

/* Adds wavelengths with one autocorrelation. */
static void add_bands(const struct gp_lags *a, const struct band *b, int n,
                      const struct spectra *s)
{
    struct summing sum = {.a = a, .s = s, .band = b, .bands = n};
    for (; sum.strip < gp_lag_strips(a->n); sum.strip++) {
        const double v = sum.strip * STRIP;
        if (v > a->edge)
            break;
        sum.edge = (int) fmin(ceil(sqrt(a->edge * a->edge - v * v)), a->n);
        gp_parallel_do(s->blocks, sum_strip, &sum);
    }
}

// -- from frequencies to the shape --------------------------------------------

enum { GROUP = 4 }; // rows that go through memory together: a cache line

/* A transform, and GROUP arrays in and as many out for each thread. */
struct transform {
    const struct gp_fftwd *lib;
    struct gp_fft_plan_pair plan;
    double complex *room;
};

static gp_status transform_make(const struct gp_log *log, int n,
                                struct transform *out)
{
    gp_status st = gp_fftwd_open(log, &out->lib);
    if (!st)
        st = gp_fft_plan_make_double(log, n, &out->plan);
    if (!st)
        st = gp_alloc_zero(log, "kernel",
                           2 * GROUP * (size_t) gp_threads() * (size_t) n,
                           sizeof *out->room, &out->room);
    return st;
}

static double complex *array_in(const struct transform *t, int thread, int i)
{
    return t->room + (size_t) (2 * GROUP * thread + i) * (size_t) t->plan.n;
}

static double complex *array_out(const struct transform *t, int thread, int i)
{
    return array_in(t, thread, GROUP + i);
}

/* Transforms the thread's first n arrays. */
static void run(const struct transform *t, int n, int thread)
{
    for (int i = 0; i < n; i++)
        t->lib->execute_dft(t->plan.forward_double,
                            (void *) array_in(t, thread, i),
                            (void *) array_out(t, thread, i));
}

struct finishing {
    const struct spectra *s;
    int c;
    int first;                    // row of samples: 0, or -ry with a path,
                                  // without which the shape is even
    const struct transform *t; // of x, of y
    size_t pitch;                 // LANES columns each block
    double complex *z;            // [row of samples][column of the spectrum]
    double pixel[2], fades;       // degrees; at the second samples are 0
    struct gp_samples *out;
    const float *luminance;       // of the primaries
};

/* Four columns of the spectrum to rows of samples. */
static void finish_columns(void *ctx, int group, int thread)
{
    const struct finishing *const f = ctx;
    const struct transform *const t = &f->t[1];
    const size_t first = (size_t) group * GROUP;
    const int n = t->plan.n;
    const size_t block = first / LANES * LANES * (size_t) n + first % LANES;
    const float *const re = f->s->re[f->c], *const im = f->s->im[f->c];
    for (int y = 0; y < n; y++) {
        for (int i = 0; i < GROUP; i++) {
            const size_t at = block + (size_t) y * LANES + (size_t) i;
            array_in(t, thread, i)[y] =
                CMPLX((double) re[at], im ? (double) im[at] : 0.0);
        }
    }
    run(t, GROUP, thread);
    for (int y = f->first; y <= f->out->ry; y++) {
        double complex *const to =
            f->z + first + (size_t) (y - f->first) * f->pitch;
        for (int i = 0; i < GROUP; i++)
            to[i] = array_out(t, thread, i)[y < 0 ? y + n : y];
    }
}

/* Fades samples out over the last quarter of t degrees: no rim. */
static double fade(double t, double end)
{
    const double z = fmin(fmax(4.0 * (end - t) / end, 0.0), 1.0);
    return z * z * (3.0 - 2.0 * z);
}

/* Four rows of samples. */
static void finish_rows(void *ctx, int group, int thread)
{
    const struct finishing *const f = ctx;
    const struct transform *const t = &f->t[0];
    const int n = t->plan.n, rx = f->out->rx, ry = f->out->ry;
    const int rows = gp_min(GROUP, ry + 1 - f->first - group * GROUP);
    const double all = (double) n * f->t[1].plan.n;
    for (int i = 0; i < rows; i++) {
        const double complex *const from =
            f->z + (size_t) (group * GROUP + i) * f->pitch;
        double complex *const to = array_in(t, thread, i);
        memcpy(to, from, ((size_t) n / 2 + 1) * sizeof *to);
        for (int x = n / 2 + 1; x < n; x++)
            to[x] = conj(from[n - x]);
    }
    run(t, rows, thread);
    for (int i = 0; i < rows; i++) {
        const double complex *const from = array_out(t, thread, i);
        const int y = group * GROUP + i + f->first;
        const double across = gp_sinc((double) y / f->t[1].plan.n);
        const size_t w = 2 * (size_t) rx + 1;
        float *const to = f->out->k.c[f->c] + (size_t) (y + ry) * w;
        float *const other = f->out->k.c[f->c] + (size_t) (ry - y) * w;
        for (int x = f->first == 0 && y == 0 ? 0 : -rx; x <= rx; x++) {
            const double at = hypot(f->pixel[0] * x, f->pixel[1] * y);
            const double window = across * gp_sinc((double) x / n);
            const double v = creal(from[x < 0 ? x + n : x]) *
                             fade(at, f->fades) / (all * window * window);
            to[x + rx] = (float) v;
            if (f->first == 0)
                other[rx - x] = (float) v;
        }
    }
}

/* Folds a row of samples in; of one channel, rounding is all that is under 0.
 * No sample within the reach is 0: a light's reach without holes is found
 * faster (gp_fft_reach_clear()). */
static void fold_row(void *ctx, int y, int thread)
{
    static const double LEAST = 1e-20; // of all light
    const struct finishing *const f = ctx;
    const size_t w = 2 * (size_t) f->out->rx + 1;
    float *const *const k = f->out->k.c;
    (void) thread;
    for (size_t i = (size_t) y * w; i < (size_t) (y + 1) * w; i++) {
        double v[3] = {0}, least = 0.0;
        for (int c = 0; c < f->s->channels; c++) {
            v[c] = (double) k[c][i];
            least = v[c] != 0.0 ? LEAST : least;
        }
        if (f->s->channels == 3)
            gp_gamut_fold(f->luminance, v);
        for (int c = 0; c < f->s->channels; c++)
            k[c][i] = (float) fmax(v[c], least);
    }
}

static gp_status finish(const struct gp_log *log, const struct spectra *s,
    const struct transform t[2], const double pixel[2], double fades,
    const float luminance[3], struct gp_samples *out)
{
    struct finishing f = {
        .s = s, .t = t, .pixel = {pixel[0], pixel[1]},
        .fades = fades, .out = out, .pitch = LANES * (size_t) s->blocks,
        .luminance = luminance, .first = s->im[0] ? -out->ry : 0,
    };
    const int rows = out->ry + 1 - f.first;
    gp_status st = gp_alloc(log, "kernel", (size_t) rows,
                            f.pitch * sizeof *f.z, &f.z);
    for (f.c = 0; f.c < s->channels && !st; f.c++) {
        gp_parallel_do((int) (f.pitch / GROUP), finish_columns, &f);
        gp_parallel_do((rows + GROUP - 1) / GROUP, finish_rows, &f);
    }
    if (!st)
        gp_parallel_do(2 * out->ry + 1, fold_row, &f);
    gp_free(f.z);
    return st;
}

// -- all of it ----------------------------------------------------------------

/* The pupil's cells, so that light up to `reach` degrees is resolved and its
 * path changes by under a sixteenth of a wave from cell to cell: the mean over
 * a cell is near its middle. Aberrations too strong for MOST_CELLS stay under
 * half a wave from cell to cell, where they do not alias. */
static int cells_of(const struct gp_diffraction *d, double reach)
{
    const double nm = d->nm > 0.0 ? d->nm : 450.0; // shorter ones are dim
    const double waves = d->diameter * 1e6 / nm * reach * GP_PI / 180.0;
    const double n = fmax(2.2 * waves, 16.0 * d->steep * d->diameter / 400.0);
    return (int) fmin(ceil(fmax(n, LEAST_CELLS) / 8.0), MOST_CELLS / 8) * 8;
}

struct drawing {
    const struct gp_diffraction *d;
    struct gp_pupil *p;
};

static void draw_row(void *ctx, int y, int thread)
{
    const struct drawing *const d = ctx;
    (void) thread;
    d->d->draw(d->d->ctx, d->p, y);
}

/* Makes a wavelength's matrices for lags -n .. n of `cell` mm. */
static gp_status band_make(const struct gp_log *log, int n, double cell,
    double nm, const int period[2], const double pixel[2], struct band *b)
{
    double step[2];
    for (int k = 0; k < 2; k++)
        step[k] = nm * 1e-6 / (period[k] * pixel[k] * (GP_PI / 180.0) * cell);
    const bool alike = step[0] == step[1] && period[0] == period[1];
    gp_status st = lag_matrix_make(log, n, step[0], period[0], &b->own[0]);
    if (!st && !alike)
        st = lag_matrix_make(log, n, step[1], period[1], &b->own[1]);
    b->x = &b->own[0];
    b->y = &b->own[alike ? 0 : 1];
    return st;
}

static gp_status make_spectra(const struct gp_log *log,
    const struct gp_diffraction *d, const struct gp_field *f,
    const struct gp_pupil *p, const int period[2], const double pixel[2],
    struct spectra *s)
{
    double nm[GP_BANDS], rgb[GP_BANDS][3];
    int bands = gp_min(d->bands, GP_BANDS), n = 0;
    struct band band[MOST_BANDS] = {0};
    struct gp_correlator t = {0};
    struct gp_lags a = {.n = p->n};
    gp_status st;
    gp_spectrum_colours(f->chromaticities, bands, nm, rgb);
    if (d->nm > 0.0) {
        bands = 1;
        nm[0] = d->nm;
        rgb[0][0] = rgb[0][1] = rgb[0][2] = 1.0;
    }
    const size_t lags = gp_lag_count(a.n);
    GP_TRY(gp_alloc(log, "kernel", lags, sizeof(float), &a.re));
    if (p->path)
        GP_TRY(gp_alloc(log, "kernel", lags, sizeof(float), &a.im));
    GP_TRY(gp_correlator_make(log, p, &t));
    for (int i = 0; i < bands; i += n) {
        bands_free(band, n);
        n = p->path ? 1 : gp_min(bands - i, MOST_BANDS);
        if (i == 0 || p->path)
            gp_correlate(&t, nm[i], &a);
        if (!(a.sum > 0.0)) {
            st = gp_fail(log, GP_ERR_DATA, "%s: no light passes the pupil; "
                         "make its openings larger", d->name);
            goto out;
        }
        for (int k = 0; k < n; k++) {
            memcpy(band[k].rgb, rgb[i + k], sizeof band[k].rgb);
            GP_TRY(band_make(log, a.n, p->cell, nm[i + k], period, pixel,
                             &band[k]));
        }
        add_bands(&a, band, n, s);
    }
out:
    bands_free(band, n);
    gp_correlator_free(&t);
    gp_free(a.re);
    gp_free(a.im);
    return st;
}

/* Slices that hold `reach` at least; pixels that are wider are cut into them. */
enum { LEAST_REACH = 16 };

gp_status gp_diffract(const struct gp_log *log, const struct gp_diffraction *d,
                      const struct gp_field *f, struct gp_shape *out)
{
    double pixel[2] = {f->degrees * f->aspect, f->degrees};
    const int size[2] = {f->w, f->h};
    int period[2], slices[2], r[2];
    struct gp_pupil p = {0};
    struct spectra s = {.channels = d->nm > 0.0 ? 1 : 3};
    struct transform t[2] = {{0}, {0}};
    struct gp_shape shape = {0};
    gp_status st;
    // as far as the key says, as cells resolve it, as a frame can meet it
    const double corner = hypot(pixel[0] * f->w, pixel[1] * f->h);
    p.n = cells_of(d, fmin(d->reach, corner / d->sampled));
    p.cell = d->diameter / (p.n - 4);
    const double resolved = (d->nm > 0.0 ? d->nm : 450.0) * 0.5e-6 / p.cell *
                            0.95 * 180.0 / GP_PI;
    const double reach = fmin(d->reach, resolved);
    for (int i = 0; i < 2; i++) {
        slices[i] = (int) fmin(ceil(LEAST_REACH * pixel[i] / reach), 1e8);
        pixel[i] /= slices[i];
        r[i] = (int) fmin(ceil(reach / pixel[i]),
                          slices[i] > 1 ? LEAST_REACH * 2.0 : size[i] - 1);
        period[i] = gp_fft_length(gp_max(3 * r[i] + 1, 64));
    }
    const size_t cells = (size_t) p.n * (size_t) p.n;
    GP_TRY(gp_alloc_zero(log, "kernel", cells, sizeof(float), &p.t));
    if (d->steep > 0.0)
        GP_TRY(gp_alloc_zero(log, "kernel", cells, sizeof(float), &p.path));
    gp_parallel_do(p.n, draw_row, &(struct drawing) {d, &p});
    s.blocks = (period[0] / 2 + LANES) / LANES;
    for (int c = 0; c < s.channels; c++) {
        const size_t n = LANES * (size_t) s.blocks * (size_t) period[1];
        GP_TRY(gp_alloc_zero(log, "kernel", n, sizeof(float), &s.re[c]));
        if (p.path)
            GP_TRY(gp_alloc_zero(log, "kernel", n, sizeof(float), &s.im[c]));
    }
    GP_TRY(make_spectra(log, d, f, &p, period, pixel, &s));
    GP_FREE(p.t);
    GP_FREE(p.path);
    for (int i = 0; i < 2; i++)
        GP_TRY(transform_make(log, period[i], &t[i]));
    GP_TRY(gp_samples_shape(log, s.channels, r[0], r[1], &shape));
    const bool sliced = slices[0] > 1 || slices[1] > 1; // nothing goes on
    GP_TRY(finish(log, &s, t, pixel, sliced ? reach : 1e9, f->luminance,
                  shape.state));
    if (!sliced && corner > d->sampled * reach)
        GP_TRY(gp_diffract_join(log, d, r, reach, f, &shape));
    *out = shape;
    shape.free = NULL;
    if (sliced)
        st = gp_slices_join(log, slices, r[0], r[1], f, out);
out:
    if (shape.free)
        shape.free(shape.state);
    gp_free(p.t);
    gp_free(p.path);
    for (int i = 0; i < 2; i++) {
        gp_fft_plan_free(&t[i].plan);
        gp_free(t[i].room);
    }
    for (int c = 0; c < 3; c++) {
        gp_free(s.re[c]);
        gp_free(s.im[c]);
    }
    return st;
}
