/* Measures src/glare/costs.h on this machine and writes the numbers there.
 *
 *   costs FILE [NAME]    FILE is costs.h; NAME starts those to measure
 *
 * All on one thread, by the process' own time, of many runs nearly the least:
 * what else the machine does must not decide what `auto` takes.
 */
#include "costs.h"

#include "core/memory.h"
#include "core/parallel.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

static char *text;        // of FILE
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

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
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

/* Puts n values in place of what the line of `name` defines. */
void costs_put(const char *name, const double *value, int n)
{
    char line[256] = "", define[80];
    size_t used = 0;
    snprintf(define, sizeof define, "#define %s ", name);
    char *const at = strstr(text, define);
    if (!at)
        costs_die(name);
    for (int i = 0; i < n; i++) {
        // a difference of two times may come out under nothing
        const double v = value[i] > 0.0 ? value[i] : 0.0;
        used += (size_t) snprintf(line + used, sizeof line - used, "%s%.3g",
                                  i ? ", " : n > 1 ? "{" : "", v);
    }
    if (n > 1)
        snprintf(line + used, sizeof line - used, "}");
    char *const from = at + strlen(define);
    const char *const rest = strchr(from, '\n');
    if (!rest)
        costs_die(name);
    printf("%-26s %.*s -> %s\n", name, (int) (rest - from), from, line);
    fflush(stdout);
    char *whole;
    if (asprintf(&whole, "%.*s%s%s", (int) (from - text), text, line, rest) < 0)
        costs_die("out of memory");
    free(text);
    text = whole;
}

void costs_put_one(const char *name, double value)
{
    costs_put(name, &value, 1);
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
    costs_put_one("GP_COST_FRESH_BYTE", least / BYTES);
}

// -- the file -----------------------------------------------------------------

static char *read_all(const char *path)
{
    enum { MOST = 1 << 16 };
    FILE *const f = fopen(path, "r");
    char *const s = calloc(1, MOST);
    if (!f || !s)
        costs_die(path);
    const size_t n = fread(s, 1, MOST - 1, f);
    fclose(f);
    s[n] = '\0';
    return s;
}

static void write_all(const char *path)
{
    char temporary[4096];
    snprintf(temporary, sizeof temporary, "%.4000s.new", path);
    FILE *const f = fopen(temporary, "w");
    if (!f || fputs(text, f) < 0 || fclose(f) != 0 ||
        rename(temporary, path) != 0)
        costs_die(temporary);
}

int main(int argc, char **argv)
{
    if (argc < 2)
        costs_die("usage: costs src/glare/costs.h [NAME]");
    text = read_all(argv[1]);
    wanted = argc > 2 ? argv[2] : "";
    gp_set_threads(1);
    measure_memory();
    gp_keep_memory();
    costs_direct();
    costs_fft();
    costs_splat();
    write_all(argv[1]);
    return 0;
}
