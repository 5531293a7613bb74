// SPDX-License-Identifier: Apache-2.0
/* A pupil's autocorrelation by transforms, and a kernel's spectra by it:
 * diffract.c has the formulas.
 *
 * A is linear between lags, as that of a pupil of square cells. Pixels wider than
 * the finest light alias frequencies: two sparse matrices map A's rows and
 * columns to frequencies, of which several rows fall on one of the kernel. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/pass.h"
#include "glare/model/model_priv.h"

#include <string.h>

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

/* Transforms and scratch, in single precision: off by at most 1e-6 of the light
 * that passes. The pupil's light has one part, or with a path two, re and im: both
 * are real pictures. */
struct correlator {
    const struct gp_pupil *pupil;
    int parts;
    struct gp_transform t;  // of at least twice the pupil's cells, so that no
                            // lag meets another
    struct gp_fft_matrix m; // the parts' half spectra, and those of the lags
    float *boost;           // of each frequency, squared sincs undone
    char *scratch;          // of a thread: two arrays of points each part
    double nm;              // wavelength
    struct lags *a;
};

static void correlator_free(struct correlator *t)
{
    gp_transform_free(&t->t);
    gp_fft_matrix_free(&t->m);
    gp_free(t->boost);
    gp_free(t->scratch);
}

/* For the pupil's autocorrelation in `lags`. The caller frees it, on failure too. */
static gp_status correlator_make(const struct gp_log *log,
                                 const struct gp_pupil *p, struct lags *lags,
                                 struct correlator *t)
{
    const int n = gp_fft_length(2 * p->n);
    const int parts = p->path ? 2 : 1;
    const size_t arrays = 2 * (size_t) parts * (size_t) gp_threads();
    gp_status st;
    *t = (struct correlator) {.pupil = p, .a = lags, .parts = parts};
    GP_TRY(gp_float_transform_make(log, n, &t->t));
    GP_TRY(gp_fft_matrix_make(log, (struct gp_fft_numbers) {0}, t->parts, n,
                              p->n + 1, &t->m));
    GP_TRY(gp_alloc(log, "kernel", arrays, gp_transform_room(n), &t->scratch));
    GP_TRY(
        gp_alloc(log, "kernel", (size_t) n + 1, sizeof *t->boost, &t->boost));
    for (int k = 0; k <= n; k++) {
        const double s = gp_sinc((double) gp_min(k, n - k) / n);
        t->boost[k] = (float) (1.0 / (s * s * s * s));
    }
out:
    return st;
}

/* Amplitudes t of n cells whose paths are so many nm, of `waves` a nm: re, or
 * im. */
GP_CLONES static void add_path(const float *restrict t,
                               const float *restrict path, double waves,
                               bool im, int n, float *restrict to)
{
    static const double ROUND = 0x1.8p52; // added, leaves whole numbers
    for (int x = 0; x < n; x++) {
        const double turns = (double) path[x] * waves;
        const float z = (float) (M_PI * (turns - ((turns + ROUND) - ROUND)));
        const float q = z * z;
        // of half the angle, within pi / 2: Taylor's series, to 1e-9
        const float s = z * (1.0f + q * (-1.0f / 6 + q * (1.0f / 120 +
            q * (-1.0f / 5040 + q * (1.0f / 362880 +
            q * (-1.0f / 39916800 + q / 6227020800.0f))))));
        const float c = 1.0f + q * (-1.0f / 2 + q * (1.0f / 24 +
            q * (-1.0f / 720 + q * (1.0f / 40320 + q * (-1.0f / 3628800 +
            q * (1.0f / 479001600 - q / 87178291200.0f))))));
        to[x] = t[x] * (im ? 2.0f * s * c : 1.0f - 2.0f * s * s);
    }
}

/* Row j of one part of the light in the pupil. */
static void load_pupil_row(const void *ctx, int part, int j, float *z)
{
    const struct correlator *const c = ctx;
    const struct gp_pupil *const p = c->pupil;
    const size_t at = (size_t) j * (size_t) p->n;
    if (c->parts == 2)
        add_path(p->t + at, p->path + at, 1.0 / c->nm, part == 1, p->n, z);
    else
        memcpy(z, p->t + at, (size_t) p->n * sizeof *z);
}

/* Squares of the spectrum at frequencies k and -k, of which one part is even,
 * the other odd, times `boost`: to the spectra of the lags' re and im, their own
 * re and im exchanged. `a` and `b` have points of the light's parts, which are
 * overwritten; b is NULL where there is one. */
GP_CLONES static void square(float *restrict a, float *restrict b,
                             const float *boost, const float *across, int n)
{
    enum { LANES = GP_FLOAT_LINES };
    for (int k = 0; k < n; k++, a += 2 * LANES) {
        for (int i = 0; i < LANES; i++) {
            const float by = boost[k] * across[i];
            if (!b) {
                a[LANES + i] = by * (a[i] * a[i] + a[LANES + i] * a[LANES + i]);
                a[i] = 0.0f;
                continue;
            }
            const float re = a[i] - b[LANES + i], im = a[LANES + i] + b[i];
            const float re2 = a[i] + b[LANES + i], im2 = b[i] - a[LANES + i];
            const float here = by * (re * re + im * im);
            const float there = by * (re2 * re2 + im2 * im2);
            a[i] = b[LANES + i] = 0.0f;
            a[LANES + i] = here + there;
            b[i] = there - here; // times -i
        }
        b = b ? b + 2 * LANES : NULL;
    }
}

/* A block of columns of the light's spectra to those of the lags v in [0, n]. */
static void correlate_columns(void *ctx, int block, int thread)
{
    enum { POINT = 2 * GP_FLOAT_LINES };
    const struct correlator *const c = ctx;
    const int n = c->t.n, cells = c->pupil->n;
    const size_t room = gp_transform_room(n) / sizeof(float);
    float *const scratch = (float *) (void *) c->scratch +
                           2 * (size_t) c->parts * room * (size_t) thread;
    float *part[2] = {NULL, NULL}, *rows[2];
    for (int i = 0; i < c->parts; i++) {
        float *const in = scratch + 2 * room * (size_t) i;
        rows[i] = (float *) c->m.z[i] + (size_t) block * c->m.pitch * POINT;
        memcpy(in, rows[i], (size_t) cells * GP_POINT_BYTES);
        memset(in + (size_t) cells * POINT, 0,
               (size_t) (n - cells) * GP_POINT_BYTES);
        part[i] = gp_float_transform(&c->t, in, in + room);
    }
    square(part[0], part[1], c->boost, c->boost + block * GP_FLOAT_LINES, n);
    for (int i = 0; i < c->parts; i++) {
        float *const in = scratch + 2 * room * (size_t) i;
        const float *const out =
            gp_float_transform(&c->t, part[i], part[i] == in ? in + room : in);
        for (int v = 0; v <= cells; v++) {
            for (int l = 0; l < POINT; l++)
                rows[i][v * POINT + l] =
                    out[v * POINT + (l + GP_FLOAT_LINES) % POINT];
        }
    }
}

/* Lags (u, v) of one part. */
static void store_lags(const void *ctx, int part, int v, const float *z)
{
    const struct correlator *const c = ctx;
    const struct lags *const a = c->a;
    float *const to = part ? a->im : a->re;
    for (int u = -a->n; u <= a->n; u++)
        to[lag_at(a, u, v)] = z[u < 0 ? u + c->t.n : u];
}

/* Fills the lags but `n` at one wavelength. */
static gp_status correlate(const struct gp_log *log, struct correlator *c,
                           double nm)
{
    const struct gp_fft_request fft = {
        .log = log,
        .t = &c->t,
        .channels = c->parts,
    };
    c->nm = nm;
    gp_status st = gp_fft_rows_in(&fft, c->pupil->n, load_pupil_row, c, &c->m);
    if (st)
        return st;
    gp_parallel_do(c->m.blocks, correlate_columns, c);
    st = gp_fft_rows_out(&fft, &c->m, c->pupil->n + 1, store_lags, c);
    c->a->sum = (double) c->a->re[lag_at(c->a, 0, 0)];
    return st;
}

// -- from lags to frequencies -------------------------------------------------

/* Shares of lags first .. first + n - 1 in a step of frequency. */
struct lag_row {
    int first, n;
    size_t at; // of its weights
};

/* Rows -edge .. edge of frequencies of a kernel of `period` pixels. */
struct lag_matrix {
    int edge, period;
    double step; // of frequencies, in cells of lag
    struct lag_row *row;
    float *weight;
};

static void lag_matrix_free(struct lag_matrix *m)
{
    gp_free(m->row);
    gp_free(m->weight);
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

/* Cells go from -n to n. The caller frees it, on failure too. */
static gp_status lag_matrix_make(const struct gp_log *log, int n, double step,
                                 int period, double nodes, struct lag_matrix *m)
{
    *m = (struct lag_matrix) {
        .edge = (int) ceil(n / step + 1.0), .period = period, .step = step};
    if (nodes > 0.0) // nothing is beyond the first zero
        m->edge = gp_min(m->edge, (int) ceil(period / fmax(nodes, 1.0)));
    const size_t rows = 2 * (size_t) m->edge + 1;
    const size_t most = (size_t) ceil(2.0 * step) + 3;
    size_t at = 0;
    gp_status st = gp_alloc(log, "kernel", rows, sizeof *m->row, &m->row);
    if (!st)
        st =
            gp_alloc(log, "kernel", rows * most, sizeof *m->weight, &m->weight);
    for (size_t i = 0; i < rows && !st; i++) {
        const int k = (int) i - m->edge;
        // a mean over steps to both sides, by a hat of their width
        const double low = (k - 1.0) * step, high = (k + 1.0) * step;
        // the pixel that shines and the one that is lit
        const double f = fmax(nodes, 1.0) * k / period;
        // of nodes, up to the first zero
        const double pixel =
            nodes > 0.0 && fabs(f) >= 1.0 ? 0.0 : gp_sinc(f) / step;
        const int first = gp_max((int) floor(low), -n);
        const int last = gp_min((int) ceil(high), n);
        m->row[i] = (struct lag_row) {first, gp_max(last - first + 1, 0), at};
        for (int u = first; u <= last; u++)
            m->weight[at++] = (float) (pixel * pixel *
                                       (ramp(high - u) + ramp(low - u) -
                                        2.0 * ramp(k * step - u)));
    }
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
    // all rows whose frequency is k modulo the period
    for (int r = (k + m->edge) % m->period; r <= 2 * m->edge; r += m->period) {
        const struct lag_row *const row = &m->row[r];
        const float *const weight = m->weight + row->at;
        const int first = gp_max(-edge - row->first, 0);
        const int end = gp_min(edge + 1 - row->first, row->n);
        for (int j = first; j < end; j++) {
            const int at = (row->first + j) * STRIP;
            const eight *const plus = (const eight *) (strip + at);
            const eight *const minus = (const eight *) (strip - at);
            for (int i = 0; i < EIGHTS; i++) {
                sum[0][i] += weight[j] * plus[i];
                sum[1][i] += weight[j] * minus[i];
            }
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
GP_CLONES static void sum_strip(void *ctx, int block, GP_UNUSED int thread)
{
    const struct summing *const s = ctx;
    const size_t at = lag_at(s->a, 0, s->strip * STRIP);
    float sums[2][GP_LANES][STRIP] = {0};
    eight t[2][STRIP][LANE_EIGHTS];
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
            GP_TRY(correlate(log, &t, nm[i]));
        if (!(a.sum > 0.0)) {
            st = gp_fail(log, GP_ERR_DATA, "%s: no light passes the pupil; "
                         "make its openings larger", d->name);
            goto out;
        }
        for (int k = 0; k < n; k++) {
            memcpy(band[k].rgb, rgb[i + k], sizeof band[k].rgb);
            // cycles a radian, in cells of lag
            const double unit = nm[i + k] * 1e-6 / (p->cell * M_PI / 180.0);
            GP_TRY(lag_matrix_make(log, a.n, unit / (period[0] * pixel[0]),
                                   period[0], f->nodes, &band[k].x));
            GP_TRY(lag_matrix_make(log, a.n, unit / (period[1] * pixel[1]),
                                   period[1], f->nodes, &band[k].y));
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
