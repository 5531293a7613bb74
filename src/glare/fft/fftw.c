#include "glare/fft/fft.h"

#include "core/memory.h"

#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Fills `table`, whose members are function pointers in this order. */
static gp_status load_functions(const struct gp_log *log, const char *file,
    const char *package, const char *without, const char *prefix, void **table)
{
    static const char *const names[] = {
        "plan_dft_1d", "execute_dft", "destroy_plan",
        "import_wisdom_from_filename", "export_wisdom_to_filename",
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
    return (how == GP_FFT_PLAN_ESTIMATE ? estimated[i] : 1.0) * each * 1e-3 *
           n * log2(n);
}

int gp_fft_length(int n)
{
    static const double ps[] = GP_COST_FFT_PS;
    int best = 0;
    double cost = INFINITY;
    // a power of two lies within twice the length, so this ends there at the
    // latest; before that where the least cost of any length from m up, with
    // the whole part of the logarithm, is no less
    for (int m = (n + 7) / 8 * 8; m < 2 * n + 8; m += 8) {
        if (ps[0] * 1e-3 * m * (31 - __builtin_clz((unsigned) m)) >= cost)
            break;
        int rest = m; // of factors that the passes take
        for (int p = 2; p <= 7; p += p == 2 ? 1 : 2) {
            while (rest % p == 0)
                rest /= p;
        }
        const double ns = rest == 1 ? gp_fft_cost(m, GP_FFT_PLAN_MEASURE)
                                    : INFINITY;
        if (ns < cost) {
            best = m;
            cost = ns;
        }
    }
    return best;
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
    p.forward = lib->plan_dft_1d(n, a, b, FFTW_FORWARD, flags);
    p.backward = lib->plan_dft_1d(n, a, b, FFTW_BACKWARD, flags);
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
