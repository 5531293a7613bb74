/* Measures the numbers of src/glare/costs.h on this machine and prints them
 * beside those that are built in.
 *
 *   costs [NAME]    NAME starts those to measure
 *
 * All on one thread, by the process' own time, of many runs nearly the least:
 * what else the machine does must not decide what `auto` takes.
 */
#include "costs.h"
#include "median.h"

#include "core/memory.h"
#include "core/parallel.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

static const char *wanted;

void costs_die(const char *what)
{
    fprintf(stderr, "costs: %s\n", what);
    exit(70);
}

double costs_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double) t.tv_sec * 1e3 + (double) t.tv_nsec * 1e-6;
}

double costs_time(costs_body body, void *ctx)
{
    enum { FEWEST = 15, MOST = 4000 };
    static double ms[MOST];
    double all = 0.0;
    int n = 0;
    while (n < FEWEST || (all < 120.0 && n < MOST)) {
        const double t = costs_now();
        body(ctx);
        ms[n] = costs_now() - t;
        all += ms[n++];
    }
    qsort(ms, (size_t) n, sizeof *ms, by_value);
    return ms[n / 10];
}

bool costs_wants(const char *name)
{
    return strncmp(name, wanted, strlen(wanted)) == 0;
}

void costs_print(const char *name, const char *built_in, const double *value,
                 int n)
{
    printf("%-26s %s -> %s", name, built_in, n > 1 ? "{" : "");
    for (int i = 0; i < n; i++) // a difference of two times may be negative
        printf("%s%.3g", i ? ", " : "", fmax(value[i], 0.0));
    printf("%s\n", n > 1 ? "}" : "");
    fflush(stdout);
}

// -- memory -------------------------------------------------------------------

static void measure_memory(void)
{
    enum { BYTES = 64 << 20, PAGE = 4096 };
    if (!costs_wants("GP_COST_FRESH_BYTE"))
        return;
    double least = INFINITY;
    for (int i = 0; i < 5; i++) {
        volatile char *const p = mmap(NULL, BYTES, PROT_READ | PROT_WRITE,
                                      MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (p == MAP_FAILED)
            costs_die("out of memory");
        const double t = costs_now();
        for (int at = 0; at < BYTES; at += PAGE)
            p[at] = 1;
        least = fmin(least, costs_now() - t);
        munmap((void *) (uintptr_t) p, BYTES);
    }
    COSTS_PRINT(GP_COST_FRESH_BYTE, least / BYTES);
}

int main(int argc, char **argv)
{
    wanted = argc > 1 ? argv[1] : "";
    gp_set_threads(1);
    measure_memory();
    gp_keep_memory();
    costs_direct();
    costs_fft();
    costs_splat();
    return 0;
}
