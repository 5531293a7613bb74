/* Transforms of frames: FFTW by dlopen, lengths and plans; and the passes over
 * rows and columns. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/fft_priv.h"

#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// -- FFTW ---------------------------------------------------------------------

/* Fills `table`, whose members are function pointers in this order. */
static gp_status load_functions(const struct gp_log *log, const char *file,
    const char *package, const char *without, const char *prefix, void **table)
{
    static const char *const names[] = {
        "plan_dft_1d", "execute_dft", "destroy_plan",
        "import_wisdom_from_filename", "import_wisdom_from_string",
        "forget_wisdom", "export_wisdom_to_filename",
    };
    void *const lib = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (!lib)
        return gp_fail(log, GP_ERR_IO,
                       "%s: cannot be loaded (%s); install %s (Debian) or "
                       "%s", file, dlerror(), package, without);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char symbol[64] = "";
        strcat(strcat(symbol, prefix), names[i]);
        table[i] = dlsym(lib, symbol);
        if (!table[i]) {
            dlclose(lib);
            return gp_fail(log, GP_ERR_IO,
                           "%s: is not FFTW 3 (no %s); install %s (Debian)",
                           file, symbol, package);
        }
    }
    return GP_OK;
}

gp_status gp_fftwf_open(const struct gp_log *log, const struct gp_fftwf **out)
{
    static union {
        struct gp_fftwf table;
        void *slot[sizeof(struct gp_fftwf) / sizeof(void *)];
    } lib;
    gp_status st = GP_OK;
    if (!lib.table.export_wisdom_to_filename)
        st = load_functions(log, "libfftw3f.so.3", "libfftw3-single3",
                            "use --engine direct", "fftwf_", lib.slot);
    *out = &lib.table;
    return st;
}

gp_status gp_fftwd_open(const struct gp_log *log, const struct gp_fftwd **out)
{
    static union {
        struct gp_fftwd table;
        void *slot[sizeof(struct gp_fftwd) / sizeof(void *)];
    } lib;
    gp_status st = GP_OK;
    if (!lib.table.export_wisdom_to_filename)
        st = load_functions(log, "libfftw3.so.3", "libfftw3-double3",
                            "leave --verify, -k aperture and -k temporal out",
                            "fftw_", lib.slot);
    *out = &lib.table;
    return st;
}

// -- lengths -----------------------------------------------------------------

double gp_fft_cost(int n, enum gp_fft_plan how)
{
    enum { ODDS = 7 };
    static const int odd[ODDS - 1] = {1, 3, 5, 9, 15, 25};
    static const double ps[ODDS] = GP_COST_FFT_PS;
    static const double estimated[ODDS] = GP_COST_FFT_ESTIMATED;
    if (n < 2)
        return 1.0;
    int rest = n, i = 0;
    while (rest % 2 == 0)
        rest /= 2;
    while (i < ODDS - 1 && odd[i] != rest)
        i++;
    const double each = rest == 5 && n > 2048 ? GP_COST_FFT_PS_LARGE_5 : ps[i];
    const bool slow = how == GP_FFT_PLAN_ESTIMATE && !gp_fft_known(n);
    return (slow ? estimated[i] : 1.0) * each * 1e-3 * n * log2(n);
}

/* The length >= n of the least cost, planned so, with `each` ns more a point. */
static int find_length(int n, enum gp_fft_plan how, double each)
{
    static const double ps[] = GP_COST_FFT_PS;
    int best = 0;
    double cost = INFINITY;
    // a power of two lies within twice the length, so this ends there at the
    // latest; before that where the least cost of any length from m up, with
    // the whole part of the logarithm, is no less
    for (int m = (n + 7) / 8 * 8; m < 2 * n + 8; m += 8) {
        if (m * (ps[0] * 1e-3 * (31 - __builtin_clz((unsigned) m)) + each) >=
            cost)
            break;
        int rest = m; // of factors that the passes take
        for (int p = 2; p <= 7; p += p == 2 ? 1 : 2) {
            while (rest % p == 0)
                rest /= p;
        }
        const double ns = rest == 1 ? gp_fft_cost(m, how) + each * m
                                    : INFINITY;
        if (ns < cost) {
            best = m;
            cost = ns;
        }
    }
    return best;
}

int gp_fft_length(int n)
{
    return find_length(n, GP_FFT_PLAN_MEASURE, 0.0);
}

int gp_fft_column_length(int n)
{
    return find_length(n, GP_FFT_PLAN_ESTIMATE, GP_COST_FFT_POINT);
}

int gp_fft_row_length(int n, int rows, int ny)
{
    // each point more is two transforms of half a column
    const double column =
        gp_fft_cost(ny, GP_FFT_PLAN_ESTIMATE) + GP_COST_FFT_POINT * ny;
    return find_length(n, GP_FFT_PLAN_ESTIMATE,
                       GP_COST_FFT_POINT + column / rows);
}

// -- plans -------------------------------------------------------------------

gp_status gp_fft_plan_make(const struct gp_log *log, int n,
    enum gp_fft_plan how, const char *wisdom, struct gp_fft_plan_pair *out)
{
    const struct gp_fftwf *lib;
    gp_status st = gp_fftwf_open(log, &lib);
    if (st)
        return st;
    void *a = NULL, *b = NULL;
    struct gp_fft_plan_pair p = {.n = n, .how = how};
    GP_TRY(gp_alloc_zero(log, "transform", (size_t) n, 8, &a));
    GP_TRY(gp_alloc_zero(log, "transform", (size_t) n, 8, &b));
    const int measure = how == GP_FFT_PLAN_MEASURE;
    const unsigned flags = measure ? FFTW_MEASURE : FFTW_ESTIMATE;
    // wisdom is read once for each plan and written back under another name
    // first, so that two runs side by side never see half a file; a cache that
    // cannot be kept is no error
    if (measure && wisdom)
        lib->import_wisdom_from_filename(wisdom);
    // only about this length: a plan may not depend on those made before
    const char *const known = measure ? NULL : gp_fft_known(n);
    if (!measure)
        lib->forget_wisdom();
    if (known)
        lib->import_wisdom_from_string(known);
    p.forward = lib->plan_dft_1d(n, a, b, FFTW_FORWARD, flags);
    p.backward = lib->plan_dft_1d(n, a, b, FFTW_BACKWARD, flags);
    if (known)
        lib->forget_wisdom();
    if (measure && wisdom) {
        char other[4096];
        const int length = snprintf(other, sizeof other, "%s.XXXXXX", wisdom);
        const bool fits = length >= 0 && (size_t) length < sizeof other;
        const int fd = fits ? mkstemp(other) : -1; // no other run has this name
        if (fd >= 0)
            close(fd);
        if (fd >= 0 && (!lib->export_wisdom_to_filename(other) ||
                        rename(other, wisdom) != 0))
            unlink(other);
    }
    if (!p.forward || !p.backward) {
        gp_fft_plan_free(&p);
        st = gp_fail_bare(log, GP_ERR_BUG,
                          "transform: FFTW has no plan for length %d; use "
                          "--engine direct", n);
        goto out;
    }
    *out = p;
out:
    gp_free(a);
    gp_free(b);
    return st;
}

void gp_fft_plan_free(struct gp_fft_plan_pair *p)
{
    const struct gp_fftwf *lib;
    if ((p->forward || p->backward) && gp_fftwf_open(NULL, &lib) == GP_OK) {
        if (p->forward)
            lib->destroy_plan(p->forward);
        if (p->backward)
            lib->destroy_plan(p->backward);
    }
    *p = (struct gp_fft_plan_pair) {0};
}

// -- passes -------------------------------------------------------------------

enum {
    ROWS = 8,     // rows that share a cache line of a column
    PAIRS = 4,    // complex rows that hold them
    COLUMNS = 16, // columns a task takes
    AHEAD = 12,   // columns fetched before they are needed: no CPU foresees
                  // steps as long as a column
};

/* Four complex numbers; as floats to calculate, as doubles to move. */
typedef float vf __attribute__((vector_size(32)));
typedef double vd __attribute__((vector_size(32)));
typedef vf vf_loose __attribute__((aligned(8), may_alias));
typedef float vh __attribute__((vector_size(16))); // four real numbers
typedef vh vh_loose __attribute__((aligned(4), may_alias));

#define INLINE static inline __attribute__((always_inline))
#define CONJ ((vf) {1, -1, 1, -1, 1, -1, 1, -1})

INLINE vf load4(const float *p)
{
    return *(const vf_loose *) p;
}

INLINE void store4(float *p, vf v)
{
    *(vf_loose *) p = v;
}

/* The four numbers in reverse order. */
INLINE vf reverse(vf v)
{
    return (vf) __builtin_shufflevector((vd) v, (vd) v, 3, 2, 1, 0);
}

/* re and im of each number exchanged. */
INLINE vf swap(vf v)
{
    return __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
}

/* Rows of four to columns of four. */
INLINE void transpose(const vf in[4], vf out[4])
{
    const vd a = (vd) in[0], b = (vd) in[1], c = (vd) in[2], d = (vd) in[3];
    const vd ab0 = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const vd ab1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const vd cd0 = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const vd cd1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    out[0] = (vf) __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5);
    out[1] = (vf) __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5);
    out[2] = (vf) __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7);
    out[3] = (vf) __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7);
}

/* Spectra Z of four pairs of rows, each nx + 4 numbers with Z[nx] = Z[0], to
 * twice the spectra of the eight rows, transposed into the matrix. */
GP_CLONES static void unpack(const float *z, size_t z_pitch, int nx,
                             float *out, size_t pitch)
{
    for (int k = 0; k <= nx / 2; k += 4) {
        vf row[ROWS];
        for (int p = 0; p < PAIRS; p++) {
            const float *const zp = z + (size_t) p * z_pitch;
            const vf f = load4(zp + 2 * k);
            const vf r = reverse(load4(zp + 2 * (nx - k - 3))) * CONJ;
            row[2 * p] = f + r;
            row[2 * p + 1] = swap(f - r) * CONJ; // times -i
        }
        vf lo[4], hi[4];
        transpose(row, lo);
        transpose(row + 4, hi);
        for (int i = 0; i < 4; i++) {
            float *const line = out + 2 * ((size_t) (k + i) * pitch);
            __builtin_prefetch(line + 2 * AHEAD * pitch, 1);
            store4(line, lo[i]);
            store4(line + 8, hi[i]);
        }
    }
}

/* The inverse: eight columns' rows to four complex rows of nx numbers. */
GP_CLONES static void pack(const float *in, size_t pitch, int nx, float *z,
                           size_t z_pitch)
{
    for (int k = 0; k < nx / 2; k += 4) {
        vf lo[4], hi[4], row[ROWS];
        for (int i = 0; i < 4; i++) {
            const float *const line = in + 2 * ((size_t) (k + i) * pitch);
            __builtin_prefetch(line + 2 * AHEAD * pitch);
            lo[i] = load4(line);
            hi[i] = load4(line + 8);
        }
        transpose(lo, row);
        transpose(hi, row + 4);
        for (int p = 0; p < PAIRS; p++) {
            float *const zp = z + (size_t) p * z_pitch;
            const vf ib = swap(row[2 * p + 1] * CONJ); // times i
            const vf minus = (row[2 * p] - ib) * CONJ;
            // Z[nx - k] for k = 0 is Z[nx], which nothing reads
            store4(zp + 2 * (nx - k - 3), reverse(minus));
            store4(zp + 2 * k, row[2 * p] + ib);
        }
    }
    const float *const nyquist = in + 2 * ((size_t) (nx / 2) * pitch);
    for (int p = 0; p < PAIRS; p++) {
        float *const mid = z + (size_t) p * z_pitch + nx;
        mid[0] = nyquist[4 * p] - nyquist[4 * p + 3];
        mid[1] = nyquist[4 * p + 1] + nyquist[4 * p + 2];
    }
}

/* z[i] *= k[i] for n complex numbers, n a multiple of 4. */
GP_CLONES static void multiply(float *restrict z, const float *restrict k,
                               int n)
{
    for (int i = 0; i < n; i += 4) {
        const vf a = load4(z + 2 * i), b = load4(k + 2 * i);
        const vf re = __builtin_shufflevector(b, b, 0, 0, 2, 2, 4, 4, 6, 6);
        const vf im = __builtin_shufflevector(b, b, 1, 1, 3, 3, 5, 5, 7, 7);
        store4(z + 2 * i, a * re - swap(a) * im * CONJ);
    }
}

/* z[i] *= k[i] for n complex numbers and as many real ones, n a multiple of
 * 4. */
GP_CLONES static void multiply_real(float *restrict z, const float *restrict k,
                                    int n)
{
    for (int i = 0; i < n; i += 4) {
        const vh b = *(const vh_loose *) (k + i);
        store4(z + 2 * i, load4(z + 2 * i) *
                   __builtin_shufflevector(b, b, 0, 0, 1, 1, 2, 2, 3, 3));
    }
}

/* A matrix without planes. */
static struct gp_fft_matrix matrix_of(int nx, int rows, bool real)
{
    struct gp_fft_matrix m = {
        .columns = (nx / 2 + 1 + 3) / 4 * 4, .real = real,
    };
    m.pitch = ((size_t) rows + ROWS - 1) / ROWS * ROWS;
    if (m.pitch % 64 == 0)
        m.pitch += ROWS; // neighbouring columns must not share a cache set
    return m;
}

size_t gp_fft_matrix_floats(int nx, int rows)
{
    const struct gp_fft_matrix m = matrix_of(nx, rows, false);
    return 2 * (size_t) m.columns * m.pitch;
}

struct gp_fft_matrix gp_fft_matrix_in(float *memory, int nx, int rows)
{
    struct gp_fft_matrix m = matrix_of(nx, rows, false);
    m.z[0] = memory;
    return m;
}

static gp_status make_matrix(const struct gp_log *log, int channels, int nx,
                             int rows, bool real, struct gp_fft_matrix *out)
{
    struct gp_fft_matrix m = matrix_of(nx, rows, real);
    const size_t floats = real ? 1 : 2; // of a number
    // one block, as it fills huge pages
    const size_t plane = (size_t) m.columns * m.pitch;
    gp_status st = gp_alloc(log, "spectrum", (size_t) channels * plane,
                            floats * sizeof(float), &m.z[0]);
    if (st)
        return st;
    for (int c = 1; c < channels; c++)
        m.z[c] = m.z[0] + floats * (size_t) c * plane;
    *out = m;
    return GP_OK;
}

gp_status gp_fft_matrix_make(const struct gp_log *log, int channels, int nx,
                             int rows, struct gp_fft_matrix *out)
{
    return make_matrix(log, channels, nx, rows, false, out);
}

gp_status gp_fft_real_matrix_make(const struct gp_log *log, int channels,
                                  int nx, int rows, struct gp_fft_matrix *out)
{
    return make_matrix(log, channels, nx, rows, true, out);
}

void gp_fft_matrix_free(struct gp_fft_matrix *m)
{
    gp_free(m->z[0]);
    *m = (struct gp_fft_matrix) {0};
}

/* A pass under way: scratch for each thread, and what its tasks read. */
struct pass {
    const struct gp_fftwf *lib;
    const struct gp_fft_request *req;
    struct gp_fft_matrix *m, *out;
    const struct gp_fft_kernel *kernel;
    int rows, tasks; // tasks of one channel
    const int *place;
    int first, count;
    float scale;
    gp_fft_load load;
    gp_fft_store store;
    const void *ctx;
    size_t scratch; // floats of each thread
    float *buffer;
};

static gp_status run_pass(struct pass *s, size_t scratch, gp_task task)
{
    gp_status st = gp_fftwf_open(s->req->log, &s->lib);
    if (st)
        return st;
    s->scratch = (scratch + 15) / 16 * 16;
    st = gp_alloc(s->req->log, "transform", s->scratch * (size_t) gp_threads(),
                  sizeof(float), &s->buffer);
    if (st)
        return st;
    gp_parallel_do(s->tasks * s->req->channels, task, s);
    gp_free(s->buffer);
    return GP_OK;
}

/* Floats of a complex row of n numbers and a little more, cache-aligned. */
static size_t row_floats(int n)
{
    return (2 * (size_t) n + 8 + 15) / 16 * 16;
}

/* One task: its channel, its first row or column, and its thread's scratch, a
 * line of `pitch` floats and one or more after it. */
struct pass_task {
    int c, first;
    size_t pitch;
    float *line, *next;
};

/* Task i of lines of n numbers, `step` rows or columns a task. */
static struct pass_task task_of(const struct pass *s, int i, int thread,
                                int step, int n)
{
    struct pass_task p = {
        .c = s->req->channel + i / s->tasks, .first = i % s->tasks * step,
        .pitch = row_floats(n),
        .line = s->buffer + s->scratch * (size_t) thread,
    };
    p.next = p.line + p.pitch;
    return p;
}

static void rows_in(void *ctx, int i, int thread)
{
    struct pass *const s = ctx;
    const int nx = s->req->x->n;
    const struct pass_task t = task_of(s, i, thread, ROWS, nx);
    for (int p = 0; p < PAIRS; p++) {
        float *const out = t.next + (size_t) p * t.pitch;
        const int j = t.first + 2 * p;
        if (j >= s->rows) {
            memset(out, 0, t.pitch * sizeof(float));
            continue;
        }
        memset(t.line, 0, t.pitch * sizeof(float));
        s->load(s->ctx, t.c, j, t.line);
        if (j + 1 < s->rows)
            s->load(s->ctx, t.c, j + 1, t.line + 1);
        s->lib->execute_dft(s->req->x->forward, (void *) t.line, (void *) out);
        out[2 * nx] = out[0];
        out[2 * nx + 1] = out[1];
    }
    unpack(t.next, t.pitch, nx, s->m->z[t.c] + 2 * (size_t) t.first,
           s->m->pitch);
}

gp_status gp_fft_rows_in(const struct gp_fft_request *req, int rows,
    gp_fft_load load, const void *ctx, struct gp_fft_matrix *m)
{
    struct pass s = {
        .req = req, .m = m, .rows = rows, .load = load, .ctx = ctx,
        .tasks = (rows + ROWS - 1) / ROWS,
    };
    return run_pass(&s, (PAIRS + 1) * row_floats(req->x->n), rows_in);
}

/* Transforms a column of `rows` rows into `out`, row j at place[j] of ny. */
static void column_forward(const struct pass *s, const float *column, int rows,
                           const int *place, float *spread, float *out)
{
    const int ny = s->req->y->n;
    const size_t one = 2 * sizeof(float); // complex number
    const int first = rows ? place[0] : 0;
    const int end = first + rows, over = gp_max(end - ny, 0);
    if (rows && place[rows - 1] == (end - 1) % ny) { // no gap
        const int upper = rows - over;
        memcpy(spread, column + 2 * upper, one * (size_t) over);
        memset(spread + 2 * over, 0, one * (size_t) (first - over));
        memcpy(spread + 2 * first, column, one * (size_t) upper);
        if (!over)
            memset(spread + 2 * end, 0, one * (size_t) (ny - end));
    } else {
        memset(spread, 0, one * (size_t) ny);
        for (int j = 0; j < rows; j++)
            memcpy(spread + 2 * place[j], column + 2 * j, one);
    }
    s->lib->execute_dft(s->req->y->forward, (void *) spread, (void *) out);
}

GP_CLONES static void scale_column(float *z, float by, int n)
{
    for (int i = 0; i < n; i++)
        z[i] *= by;
}

static void columns_forward(void *ctx, int i, int thread)
{
    struct pass *const s = ctx;
    const int ny = s->req->y->n;
    const struct pass_task t = task_of(s, i, thread, COLUMNS, ny);
    const int end = gp_min(t.first + COLUMNS, s->req->x->n / 2 + 1);
    for (int k = t.first; k < end; k++) {
        float *const out = s->out->z[t.c] + 2 * (size_t) k * s->out->pitch;
        column_forward(s, s->m->z[t.c] + 2 * (size_t) k * s->m->pitch, s->rows,
                       s->place, t.line, out);
        scale_column(out, s->scale, 2 * ny);
    }
}

gp_status gp_fft_columns(const struct gp_fft_request *req,
    const struct gp_fft_matrix *m, int rows, const int *place, float scale,
    struct gp_fft_matrix *out)
{
    struct gp_fft_matrix in = *m;
    struct pass s = {
        .req = req, .m = &in, .out = out, .rows = rows, .place = place,
        .scale = scale, .tasks = (req->x->n / 2 + COLUMNS) / COLUMNS,
    };
    return run_pass(&s, 2 * row_floats(req->y->n), columns_forward);
}

/* Columns a and b, of which row -y is the conjugate of row y, as a + ib; b
 * begins `next` floats after a, 0: it is dark. */
static void join_even(const float *a, size_t next, int rows, int ny, float *z)
{
    memset(z, 0, 2 * sizeof(float) * (size_t) ny);
    for (int y = 0; y < rows; y++) {
        const float *const p = a + 2 * y;
        const float q[2] = {next ? p[next] : 0.0f, next ? p[next + 1] : 0.0f};
        float *const other = z + 2 * (y ? ny - y : 0);
        z[2 * y] = p[0] - q[1];
        z[2 * y + 1] = p[1] + q[0];
        other[0] = y ? p[0] + q[1] : p[0]; // row 0 is real
        other[1] = y ? q[0] - p[1] : q[0];
    }
}

/* Takes z = a + ib apart, times `scale`; b may be NULL. */
GP_CLONES static void part_even(const float *z, float scale, int n, float *a,
                                float *b)
{
    for (int y = 0; y < n; y++)
        a[y] = z[2 * y] * scale;
    for (int y = 0; y < n && b; y++)
        b[y] = z[2 * y + 1] * scale;
}

/* Returns column k of the kernel's spectrum: the one that is there, or makes
 * it, in its place or, where it is not kept, in the thread's scratch. Real
 * columns are made with the next one when k is even: call for each k in order,
 * from an even one on. */
static const float *kernel_column(const struct pass *s,
                                  const struct pass_task *t, int k, int end)
{
    const struct gp_fft_kernel *const from = s->kernel;
    const bool real = from->spectrum.real;
    const int ny = s->req->y->n, plane = from->channels == 1 ? 0 : t->c;
    const size_t pitch = (real ? 1 : 2) * from->spectrum.pitch;
    const struct gp_fft_matrix *const rows = from->rows;
    float *const kept = from->spectrum.z[plane];
    float *const made = kept ? kept + (size_t) k * pitch
                        : t->line + 2 * t->pitch + (real ? k % 2 * ny : 0);
    if (!rows || (real && k % 2))
        return made;
    const float *const column = rows->z[t->c] + 2 * (size_t) k * rows->pitch;
    if (real) {
        const bool two = k + 1 < end;
        float *const other = kept ? made + pitch : made + ny;
        join_even(column, two ? 2 * rows->pitch : 0, from->n, ny, t->line);
        s->lib->execute_dft(s->req->y->forward, (void *) t->line,
                            (void *) t->next);
        part_even(t->next, from->scale, ny, made, two ? other : NULL);
    } else {
        column_forward(s, column, from->n, from->place, t->line, made);
        scale_column(made, from->scale, 2 * ny);
    }
    return made;
}

/* Fetches a column that is written next: a transform's steps are too long for
 * the CPU to foresee. */
static void fetch_column(const float *z, int n)
{
    enum { LINE = 8 }; // complex numbers
    for (int i = 0; i < n; i += LINE)
        __builtin_prefetch(z + 2 * i, 1, 2);
}

static void columns_multiply(void *ctx, int i, int thread)
{
    struct pass *const s = ctx;
    const int ny = s->req->y->n;
    const struct pass_task t = task_of(s, i, thread, COLUMNS, ny);
    const int end = gp_min(t.first + COLUMNS, s->req->x->n / 2 + 1);
    const int upper = gp_min(s->count, ny - s->first);
    const bool fresh = s->kernel->rows && s->kernel->spectrum.z[0] &&
                       !s->kernel->spectrum.real;
    for (int k = t.first; k < end; k++) {
        float *const column = s->m->z[t.c] + 2 * (size_t) k * s->m->pitch;
        const float *const kernel = kernel_column(s, &t, k, end);
        if (fresh && k + 1 < end)
            fetch_column(kernel + 2 * s->kernel->spectrum.pitch, ny);
        column_forward(s, column, s->rows, s->place, t.line, t.next);
        if (s->kernel->spectrum.real)
            multiply_real(t.next, kernel, ny);
        else
            multiply(t.next, kernel, ny);
        s->lib->execute_dft(s->req->y->backward, (void *) t.next,
                            (void *) t.line);
        memcpy(column, t.line + 2 * (size_t) s->first,
               2 * sizeof(float) * (size_t) upper);
        memcpy(column + 2 * (size_t) upper, t.line,
               2 * sizeof(float) * (size_t) (s->count - upper));
        // the last eight rows go back together; those past the end are dark
        const int tail = (s->count + ROWS - 1) / ROWS * ROWS - s->count;
        memset(column + 2 * (size_t) s->count, 0,
               2 * sizeof(float) * (size_t) tail);
    }
}

gp_status gp_fft_multiply(const struct gp_fft_request *req,
    struct gp_fft_matrix *m, int rows, const int *place,
    const struct gp_fft_kernel *kernel, int first, int count)
{
    struct pass s = {
        .req = req, .m = m, .kernel = kernel, .rows = rows, .place = place,
        .first = first, .count = count,
        .tasks = (req->x->n / 2 + COLUMNS) / COLUMNS,
    };
    return run_pass(&s, 3 * row_floats(req->y->n), columns_multiply);
}

static void rows_out(void *ctx, int i, int thread)
{
    struct pass *const s = ctx;
    const int nx = s->req->x->n;
    const struct pass_task t = task_of(s, i, thread, ROWS, nx);
    float *in = t.next;
    pack(s->m->z[t.c] + 2 * (size_t) t.first, s->m->pitch, nx, in, t.pitch);
    for (int j = t.first; j < t.first + ROWS && j < s->rows; j += 2) {
        s->lib->execute_dft(s->req->x->backward, (void *) in, (void *) t.line);
        s->store(s->ctx, t.c, j, thread, t.line);
        if (j + 1 < s->rows)
            s->store(s->ctx, t.c, j + 1, thread, t.line + 1);
        in += t.pitch;
    }
}

gp_status gp_fft_rows_out(const struct gp_fft_request *req,
                          const struct gp_fft_matrix *m, int rows,
                          gp_fft_store store, const void *ctx)
{
    struct gp_fft_matrix in = *m;
    struct pass s = {
        .req = req, .m = &in, .rows = rows, .store = store, .ctx = ctx,
        .tasks = (rows + ROWS - 1) / ROWS,
    };
    return run_pass(&s, (PAIRS + 1) * row_floats(req->x->n), rows_out);
}
