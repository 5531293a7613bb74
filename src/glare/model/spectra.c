// SPDX-License-Identifier: Apache-2.0
/* A pupil's autocorrelation by transforms, and a kernel's spectra by it:
 * diffract.c has the formulas.
 *
 * A is linear between lags, as that of a pupil of square cells. Pixels wider than
 * the finest light alias frequencies: two sparse matrices map A's rows and
 * columns to frequencies, and a row of a matrix holds all the lags that fall on
 * one frequency. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/model/model_priv.h"

#include <stdlib.h>

// -- autocorrelation ----------------------------------------------------------

enum { STRIP = 32 };
static const double SPREAD = 14.0; // cells, of dividing by their falloff

/* A pupil's autocorrelation at lags (u, v), u in [-n, n], v in [0, n] cells,
 * times `sum`, at lag_at(); at (-u, -v) it is conjugate. Lags are in strips of
 * STRIP v, with those of one u side by side; the last has zeros. */
struct lags {
    int n;
    float *re, *im; // im is NULL where it is 0: the pupil has no path
    double sum;     // 0: the pupil is dark
    double edge;    // cells: farther lags hold nothing but rounding
};

static size_t lag_at(const struct lags *a, int u, int v)
{
    const size_t row = (size_t) (v / STRIP) * (2 * (size_t) a->n + 1) +
                       (size_t) (u + a->n);
    return row * STRIP + (size_t) (v % STRIP);
}

/* Plans and scratch, in single precision: off by at most 1e-6 of the light that
 * passes. A pupil without a path is real: two rows go through one transform, and
 * half the columns of the spectrum are all. */
struct correlator {
    const struct gp_pupil *pupil;
    const struct gp_fftwf *lib;
    struct gp_fft_plan_pair plan; // of at least twice the pupil's cells, so
                                  // that no lag meets another
    size_t pitch;                 // complex numbers of an array of `room`
    float complex *room;
    float *boost;                 // of each frequency, squared sincs undone
    int columns, across;          // of the spectrum; stored, a multiple of 8
    float complex *z;             // [8 rows, or lags v >= 0][column][row]
    double nm;                    // wavelength
    int pack;                     // rows that go through one transform
    struct lags *a;
};

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

static void correlator_free(struct correlator *t)
{
    gp_fft_plan_free(&t->plan);
    gp_free(t->room);
    gp_free(t->boost);
    gp_free(t->z);
}

/* For the pupil's autocorrelation in `lags`. */
static gp_status correlator_make(const struct gp_log *log,
    const struct gp_pupil *p, struct lags *lags, struct correlator *out)
{
    const int n = gp_fft_length(2 * p->n);
    // arrays a power of two apart would share the lines of a cache
    struct correlator t = {
        .pupil = p, .a = lags, .pitch = (size_t) n + 16,
        .pack = p->path ? 1 : 2,
    };
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
    correlator_free(&t);
    return st;
}

static float complex *array_in(const struct correlator *c, int thread, int i)
{
    return c->room + (size_t) (2 * GROUP * thread + i) * c->pitch;
}

/* Rows, or lags v >= 0, from a multiple of GROUP on, of column k. */
static float complex *rows_at(const struct correlator *c, int row, int k)
{
    return c->z + (size_t) row * (size_t) c->across +
           (size_t) k * GROUP;
}

static float complex *array_out(const struct correlator *c, int thread, int i)
{
    return array_in(c, thread, GROUP + i);
}

/* Transforms the thread's first n arrays. */
static void run(const struct correlator *c, fftwf_plan plan, int n,
                int thread)
{
    const struct gp_fftwf *const lib = c->lib;
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
    const struct correlator *const c = ctx;
    const struct gp_pupil *const p = c->pupil;
    const int n = c->plan.n, cells = p->n;
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
    run(c, c->plan.forward, GROUP, thread);
    for (int k = 0; k < c->columns; k++) {
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
        memset(rows_at(c, first + half * GROUP, c->columns), 0,
               (size_t) (c->across - c->columns) * GROUP *
                   sizeof(float complex));
}

/* Columns: on to the spectrum, its squares, which are real, and back to lags
 * v >= 0, two columns a transform. */
static void pupil_columns(void *ctx, int group, int thread)
{
    const struct correlator *const c = ctx;
    const int n = c->plan.n, cells = c->pupil->n, first = group * GROUP;
    for (int y = 0; y < cells; y += GROUP) {
        for (int i = 0; i < GROUP; i++)
            memcpy(array_in(c, thread, i) + y, rows_at(c, y, first + i),
                   GROUP * sizeof(float complex));
    }
    for (int i = 0; i < GROUP; i++)
        memset(array_in(c, thread, i) + cells, 0,
               (size_t) (n - cells) * sizeof(float complex));
    run(c, c->plan.forward, GROUP, thread);
    for (int i = 0; i < GROUP; i += 2) {
        const float complex *const a = array_out(c, thread, i);
        const float complex *const b = array_out(c, thread, i + 1);
        const float of_a = c->boost[first + i], of_b = c->boost[first + i + 1];
        float *const to = (float *) array_in(c, thread, i / 2);
        for (int k = 0; k < n; k++) {
            to[2 * k] = c->boost[k] * of_a * (crealf(a[k]) * crealf(a[k]) +
                                              cimagf(a[k]) * cimagf(a[k]));
            to[2 * k + 1] = c->boost[k] * of_b * (crealf(b[k]) * crealf(b[k]) +
                                                  cimagf(b[k]) * cimagf(b[k]));
        }
    }
    run(c, c->plan.backward, GROUP / 2, thread);
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
    const struct correlator *const c = ctx;
    struct lags *const a = c->a;
    const int n = c->plan.n, first = group * GROUP * c->pack;
    for (int k = 0; k < c->columns; k++) {
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
    run(c, c->plan.backward, GROUP, thread);
    const int rows = gp_min(GROUP, (a->n - first) / c->pack + 1);
    for (int u = -a->n; u <= a->n; u++) {
        const size_t at = lag_at(a, u, first), from = (size_t) (u < 0 ? u + n
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

/* Fills the lags but `n` at one wavelength. */
static void correlate(struct correlator *t, double nm)
{
    const int cells = t->pupil->n, rows = GROUP * t->pack;
    t->nm = nm;
    gp_parallel_do((cells + rows - 1) / rows, pupil_rows, t);
    gp_parallel_do(t->across / GROUP, pupil_columns, t);
    gp_parallel_do(cells / rows + 1, pupil_lags, t);
}

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

struct band { // of one wavelength
    double rgb[3];
    struct lag_matrix x, y;
};

enum { MOST_BANDS = 32 }; // summed together

static void bands_free(struct band *b, int n)
{
    for (int i = 0; i < n; i++) {
        lag_matrix_free(&b[i].x);
        lag_matrix_free(&b[i].y);
    }
}

/* Lags of a strip as the compiler keeps them in registers. */
typedef float eight __attribute__((vector_size(32), may_alias));
enum { EIGHTS = STRIP / 8, LANE_EIGHTS = GP_LANES / 8 };

struct summing {
    const struct lags *a;
    const struct gp_spectra *s;
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

/* Adds the strip's lags v, and -v, of GP_LANES columns to rows y of the spectrum:
 * t[0] and t[1], [v][lane]. */
static inline __attribute__((always_inline)) void
sum_rows(const struct summing *s, const struct band *b, int block,
         eight (*t)[STRIP][LANE_EIGHTS], float *const to[3])
{
    const struct lag_matrix *const m = &b->y;
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
                               (size_t) y[side]) * GP_LANES;
            for (int c = 0; c < s->s->channels; c++) {
                const float w = scale * (float) b->rgb[c];
                eight *const out = (eight *) (to[c] + at);
                for (int l = 0; l < LANE_EIGHTS; l++)
                    out[l] += w * sum[side][l];
            }
        }
    }
}

/* Adds a strip of lags to GP_LANES columns of the spectrum at all wavelengths. A
 * at (u, -v) is conjugate to that at (-u, v): the column of -k. */
GP_CLONES static void sum_strip(void *ctx, int block, int thread)
{
    const struct summing *const s = ctx;
    const size_t at = lag_at(s->a, 0, s->strip * STRIP);
    float sums[2][GP_LANES][STRIP] = {0};
    eight t[2][STRIP][LANE_EIGHTS];
    (void) thread;
    for (int i = 0; i < s->bands; i++) {
        const struct band *const b = &s->band[i];
        const int lanes =
            gp_min(GP_LANES, b->x.period / 2 + 1 - block * GP_LANES);
        for (int plane = 0; plane < (s->a->im ? 2 : 1); plane++) {
            const float *const strip = (plane ? s->a->im : s->a->re) + at;
            const float sign = plane ? -1.0f : 1.0f;
            for (int l = 0; l < lanes; l++)
                sum_lags(&b->x, strip, s->edge, block * GP_LANES + l, sums[0][l],
                         sums[1][l]);
            for (int v = 0; v < STRIP; v++) {
                float columns[2][GP_LANES];
                for (int l = 0; l < GP_LANES; l++) {
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
static void add_bands(const struct lags *a, const struct band *b, int n,
                      const struct gp_spectra *s)
{
    struct summing sum = {.a = a, .s = s, .band = b, .bands = n};
    for (; sum.strip < a->n / STRIP + 1; sum.strip++) {
        const double v = sum.strip * STRIP;
        if (v > a->edge)
            break;
        sum.edge = (int) fmin(ceil(sqrt(a->edge * a->edge - v * v)), a->n);
        gp_parallel_do(s->blocks, sum_strip, &sum);
    }
}

// -- all of it ----------------------------------------------------------------

void gp_spectra_free(struct gp_spectra *s)
{
    for (int c = 0; c < 3; c++) {
        gp_free(s->re[c]);
        gp_free(s->im[c]);
    }
}

gp_status gp_spectra_make(const struct gp_log *log,
    const struct gp_diffraction *d, const struct gp_field *f,
    const struct gp_pupil *p, const int period[2], const double pixel[2],
    struct gp_spectra *out)
{
    double nm[GP_BANDS], rgb[GP_BANDS][3];
    int bands = gp_min(d->bands, GP_BANDS), n = 0;
    struct band band[MOST_BANDS] = {0};
    struct correlator t = {0};
    struct lags a = {
        .n = p->n,
        .edge = (d->corners ? sqrt(2.0) : 1.0) * p->n + SPREAD,
    };
    struct gp_spectra s = {
        .channels = d->nm > 0.0 ? 1 : 3,
        .blocks = (period[0] / 2 + GP_LANES) / GP_LANES,
    };
    gp_status st;
    gp_spectrum_colours(f->chromaticities, bands, nm, rgb);
    if (d->nm > 0.0) {
        bands = 1;
        nm[0] = d->nm;
        rgb[0][0] = rgb[0][1] = rgb[0][2] = 1.0;
    }
    for (int c = 0; c < s.channels; c++) {
        const size_t all = GP_LANES * (size_t) s.blocks * (size_t) period[1];
        GP_TRY(gp_alloc_zero(log, "kernel", all, sizeof(float), &s.re[c]));
        if (p->path)
            GP_TRY(gp_alloc_zero(log, "kernel", all, sizeof(float), &s.im[c]));
    }
    const size_t lags = (size_t) (a.n / STRIP + 1) * (2 * (size_t) a.n + 1) *
                        STRIP;
    GP_TRY(gp_alloc_zero(log, "kernel", lags, sizeof(float), &a.re));
    if (p->path)
        GP_TRY(gp_alloc_zero(log, "kernel", lags, sizeof(float), &a.im));
    GP_TRY(correlator_make(log, p, &a, &t));
    for (int i = 0; i < bands; i += n) {
        bands_free(band, n);
        n = p->path ? 1 : gp_min(bands - i, MOST_BANDS);
        if (i == 0 || p->path)
            correlate(&t, nm[i]);
        if (!(a.sum > 0.0)) {
            st = gp_fail(log, GP_ERR_DATA, "%s: no light passes the pupil; "
                         "make its openings larger", d->name);
            goto out;
        }
        for (int k = 0; k < n; k++) {
            memcpy(band[k].rgb, rgb[i + k], sizeof band[k].rgb);
            // cycles a radian, in cells of lag
            const double unit = nm[i + k] * 1e-6 / (p->cell * GP_PI / 180.0);
            GP_TRY(lag_matrix_make(log, a.n, unit / (period[0] * pixel[0]),
                                   period[0], &band[k].x));
            GP_TRY(lag_matrix_make(log, a.n, unit / (period[1] * pixel[1]),
                                   period[1], &band[k].y));
        }
        add_bands(&a, band, n, &s);
    }
    *out = s;
    s = (struct gp_spectra) {0};
out:
    gp_spectra_free(&s);
    bands_free(band, n);
    correlator_free(&t);
    gp_free(a.re);
    gp_free(a.im);
    return st;
}
