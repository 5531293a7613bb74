// SPDX-License-Identifier: Apache-2.0
/* FFTW by dlopen, transform lengths, and plans. */
#include "core/memory.h"
#include "glare/fft/fft_priv.h"

#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// -- FFTW ---------------------------------------------------------------------

/* Held while the tables are filled, and around all of FFTW's calls but
 * execute_dft(): its planner serves one thread at a time, of all contexts. */
static pthread_mutex_t planner = PTHREAD_MUTEX_INITIALIZER;

/* Fills `table`, whose members are function pointers in this order.
 * `parameter` is that of the message where there is no such library. */
static gp_status load_functions(const struct gp_log *log, const char *file,
    const char *package, const char *parameter, const char *prefix, void **table)
{
    static const char *const names[] = {
        "plan_dft_1d", "execute_dft", "destroy_plan",
        "import_wisdom_from_filename", "import_wisdom_from_string",
        "forget_wisdom", "export_wisdom_to_filename",
    };
    enum { NAMES = sizeof names / sizeof *names };
    if (table[NAMES - 1])
        return GP_OK;
    void *const lib = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (!lib)
        return gp_fail_at(log, GP_ERR_IO, parameter,
                          "%s: cannot be loaded (%s); install %s (Debian)",
                          file, dlerror(), package);
    for (size_t i = 0; i < NAMES; i++) {
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

/* Fills `table`, whose members are function pointers in the order of the names,
 * once; the last is NULL until it is whole. */
static gp_status fill_table(const struct gp_log *log, const char *file,
    const char *package, const char *parameter, const char *prefix, void **table)
{
    pthread_mutex_lock(&planner);
    const gp_status st = load_functions(log, file, package, parameter, prefix,
                                        table);
    pthread_mutex_unlock(&planner);
    return st;
}

gp_status gp_fftwf_open(const struct gp_log *log, const struct gp_fftwf **out)
{
    static union {
        struct gp_fftwf table;
        void *slot[sizeof(struct gp_fftwf) / sizeof(void *)];
    } lib;
    *out = &lib.table;
    return fill_table(log, "libfftw3f.so.3", "libfftw3-single3",
                      "layer.engine.fft", "fftwf_", lib.slot);
}

static gp_status open_double(const struct gp_log *log, const char *parameter,
                             const struct gp_fftwd **out)
{
    static union {
        struct gp_fftwd table;
        void *slot[sizeof(struct gp_fftwd) / sizeof(void *)];
    } lib;
    *out = &lib.table;
    return fill_table(log, "libfftw3.so.3", "libfftw3-double3", parameter,
                      "fftw_", lib.slot);
}

gp_status gp_fftwd_open(const struct gp_log *log, const struct gp_fftwd **out)
{
    return open_double(log, "layer.in_double", out);
}

fftw_plan gp_fftwd_plan(const struct gp_fftwd *lib, int n, void *in, void *out,
                        int sign, unsigned flags)
{
    pthread_mutex_lock(&planner);
    lib->forget_wisdom(); // a plan may not depend on those made before
    const fftw_plan p = lib->plan_dft_1d(n, in, out, sign,
                                         FFTW_ESTIMATE | flags);
    pthread_mutex_unlock(&planner);
    return p;
}

void gp_fftwd_end(const struct gp_fftwd *lib, fftw_plan plan)
{
    if (!plan)
        return;
    pthread_mutex_lock(&planner);
    lib->destroy_plan(plan);
    pthread_mutex_unlock(&planner);
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

static gp_status fail_plan(const struct gp_log *log, int n)
{
    return gp_fail_bare_at(log, GP_ERR_BUG, "layer.engine.fft",
                           "transform: FFTW has no plan for length %d", n);
}

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
    pthread_mutex_lock(&planner);
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
    pthread_mutex_unlock(&planner);
    if (!p.forward || !p.backward) {
        gp_fft_plan_free(&p);
        st = fail_plan(log, n);
        goto out;
    }
    *out = p;
out:
    gp_free(a);
    gp_free(b);
    return st;
}

gp_status gp_fft_plan_make_double(const struct gp_log *log, int n,
                                  struct gp_fft_plan_pair *out)
{
    const struct gp_fftwd *lib;
    gp_status st = open_double(log, "layer.engine.fft", &lib);
    if (st)
        return st;
    double *z = NULL;
    struct gp_fft_plan_pair p = {.n = n, .in_double = true};
    GP_TRY(gp_alloc_zero(log, "transform", 4 * (size_t) n, sizeof *z, &z));
    void *const a = z, *const b = z + 2 * n; // n is a multiple of 8: aligned
    p.forward_double = gp_fftwd_plan(lib, n, a, b, FFTW_FORWARD, 0);
    p.backward_double = gp_fftwd_plan(lib, n, a, b, FFTW_BACKWARD, 0);
    *out = p;
    if (!p.forward_double || !p.backward_double) {
        gp_fft_plan_free(out);
        st = fail_plan(log, n);
    }
out:
    gp_free(z);
    return st;
}

void gp_fft_plan_free(struct gp_fft_plan_pair *p)
{
    const struct gp_fftwf *lib;
    const struct gp_fftwd *twice;
    if ((p->forward || p->backward) && gp_fftwf_open(NULL, &lib) == GP_OK) {
        pthread_mutex_lock(&planner);
        if (p->forward)
            lib->destroy_plan(p->forward);
        if (p->backward)
            lib->destroy_plan(p->backward);
        pthread_mutex_unlock(&planner);
    }
    if ((p->forward_double || p->backward_double) &&
        gp_fftwd_open(NULL, &twice) == GP_OK) {
        gp_fftwd_end(twice, p->forward_double);
        gp_fftwd_end(twice, p->backward_double);
    }
    *p = (struct gp_fft_plan_pair) {0};
}
