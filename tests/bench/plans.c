// SPDX-License-Identifier: Apache-2.0
/* Prints src/glare/fft/known.c: plans of the lengths that fft takes most.
 *
 *   plans [ROUNDS]
 *
 * FFTW measures the plans of each length ROUNDS times (7), forward and
 * backward, and the fastest of them is kept; on a busy machine give more
 * rounds. Beside each length, to standard error: microseconds of a transform
 * with the plan, with the one that FFTW estimates, and in double precision. */
#include "median.h"

#include "core/clock.h"
#include "core/memory.h"
#include "glare/fft/fft.h"

#include <fftw3.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct gp_log plans_log = BENCH_LOG("plans");

enum { FIRST = 512, LAST = 16384, TRIES = 60, TRANSFORMS = 16 };

/* The flags of every line of wisdom that a measured plan has. */
static const char flags[] = " #x11bdd #x11bdd #x0 ";

/* Lengths of these odd factors are fast enough to be chosen. */
static bool is_taken(int n)
{
    static const int odd[] = {1, 3, 5, 7, 9, 15, 21, 25};
    while (n % 2 == 0)
        n /= 2;
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        if (odd[i] == n)
            return true;
    }
    return false;
}

struct arrays {
    fftwf_complex *in, *out;
};

static double time_plan(fftwf_plan p, const struct arrays *a)
{
    double best = DBL_MAX;
    for (int i = 0; i < TRIES; i++) {
        const double from = gp_now_ms();
        for (int j = 0; j < TRANSFORMS; j++)
            fftwf_execute_dft(p, a->in, a->out);
        const double ms = (gp_now_ms() - from) / TRANSFORMS;
        best = ms < best ? ms : best;
    }
    return best;
}

/* Plans length n, and returns milliseconds of a transform. */
static double plan_ms(int n, int sign, unsigned how, const struct arrays *a)
{
    const fftwf_plan p = fftwf_plan_dft_1d(n, a->in, a->out, sign, how);
    const double ms = time_plan(p, a);
    fftwf_destroy_plan(p);
    return ms;
}

/* Milliseconds of a transform in double precision, by a measured plan. */
static double double_ms(int n)
{
    const struct gp_fftwd *lib;
    fftw_complex *in = NULL, *out = NULL;
    double best = DBL_MAX;
    const size_t points = (size_t) n;
    if (gp_fftwd_open(&plans_log, &lib) ||
        gp_alloc_zero(&plans_log, "in", points, sizeof *in, &in) ||
        gp_alloc_zero(&plans_log, "out", points, sizeof *out, &out))
        exit(70);
    const fftw_plan p =
        lib->plan_dft_1d(n, in, out, FFTW_FORWARD, FFTW_MEASURE);
    memset(in, 0, points * sizeof *in);
    for (int i = 0; i < TRIES; i++) {
        const double from = gp_now_ms();
        for (int j = 0; j < TRANSFORMS; j++)
            lib->execute_dft(p, in, out);
        best = fmin(best, (gp_now_ms() - from) / TRANSFORMS);
    }
    lib->destroy_plan(p);
    gp_free(in);
    gp_free(out);
    return best;
}

/* Returns FFTW's wisdom about the fastest plan; free with free(). */
static char *find_wisdom(int n, int sign, int rounds, const struct arrays *a,
                         double *best)
{
    char *wisdom = NULL;
    *best = DBL_MAX;
    for (int i = 0; i < rounds; i++) {
        fftwf_forget_wisdom();
        const double ms = plan_ms(n, sign, FFTW_MEASURE, a);
        if (ms < *best) {
            *best = ms;
            free(wisdom);
            wisdom = fftwf_export_wisdom_to_string();
        }
    }
    fftwf_forget_wisdom();
    return wisdom;
}

static int fail(const char *line)
{
    fprintf(stderr, "plans: wisdom of an unknown form: %s\n", line);
    return 1;
}

/* Prints the lines between the first, which names the library, and the last:
 * "  (fftwf_NAME INDEX FLAGS #x.. #x.. #x.. #x..)". */
static int print_wisdom(char *wisdom)
{
    char *save;
    strtok_r(wisdom, "\n", &save);
    for (char *line; (line = strtok_r(NULL, "\n", &save)) && *line != ')';) {
        char name[64];
        unsigned index, h[4];
        int at = 0, end = 0;
        if (sscanf(line, " (fftwf_%63[a-z0-9_] %u%n", name, &index, &at) != 2 ||
            strncmp(line + at, flags, sizeof flags - 1) != 0)
            return fail(line);
        if (sscanf(line + at + sizeof flags - 1, "#x%8x #x%8x #x%8x #x%8x)%n",
                   &h[0], &h[1], &h[2], &h[3], &end) != 4 || !end)
            return fail(line);
        printf("     S(\"%s\", %u, %08x, %08x, %08x, %08x)\n", name, index,
               h[0], h[1], h[2], h[3]);
    }
    return 0;
}

/* Prints the file down to its table, with the library's version and solvers. */
static int print_head(const struct arrays *a)
{
    double ms;
    char *const wisdom = find_wisdom(FIRST, FFTW_FORWARD, 1, a, &ms);
    const char *const line = strtok(wisdom, "\n");
    if (!line || strlen(line) > 74)
        return fail(line ? line : "empty");
    printf("// SPDX-License-Identifier: Apache-2.0\n"
           "/* Plans of the lengths that fft takes most, measured by\n"
           " *\n"
           " *     make known-plans\n"
           " *\n"
           " * as FFTW's wisdom: a length's solvers, each with the hash of "
           "what it solves.\n"
           " * FFTW of another version, or on a CPU with other vector "
           "instructions, refuses\n"
           " * them, and estimates its plans. */\n"
           "#include \"glare/fft/fft_priv.h\"\n\n"
           "#define HEAD                                                 "
           "                 \\\n    \"%s\"\n"
           "#define S(name, index, a, b, c, d)                           "
           "                 \\\n"
           "    \"(fftwf_\" name \" \" #index \"%s#x\" #a \" #x\" #b"
           "          \\\n"
           "    \" #x\" #c \" #x\" #d \")\"\n\n"
           "static const struct {\n    int n;\n    const char *wisdom;\n"
           "} known[] = {\n",
           line, flags);
    free(wisdom);
    return 0;
}

static void print_foot(void)
{
    printf("};\n\n"
           "const char *gp_fft_known(int n)\n{\n"
           "    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {\n"
           "        if (known[i].n == n)\n"
           "            return known[i].wisdom;\n"
           "    }\n"
           "    return NULL;\n}\n");
}

static int print_length(int n, int rounds, const struct arrays *a)
{
    double ms[2], estimated[2];
    static const int sign[2] = {FFTW_FORWARD, FFTW_BACKWARD};
    int bad = 0;
    printf("    {%d, HEAD\n", n);
    for (int i = 0; i < 2; i++) {
        fftwf_forget_wisdom();
        estimated[i] = plan_ms(n, sign[i], FFTW_ESTIMATE, a);
        char *const wisdom = find_wisdom(n, sign[i], rounds, a, &ms[i]);
        bad |= print_wisdom(wisdom);
        free(wisdom);
    }
    printf("     \")\"},\n");
    fprintf(stderr, "%5d: %.2f and %.2f us, estimated %.2f and %.2f, in double "
            "%.2f\n", n, 1e3 * ms[0], 1e3 * ms[1], 1e3 * estimated[0],
            1e3 * estimated[1], 1e3 * double_ms(n));
    return bad;
}

int main(int argc, char **argv)
{
    const int rounds = argc > 1 ? atoi(argv[1]) : 7;
    struct arrays a;
    int bad = 0;
    // aligned as gp_fft_plan_make() has them: wisdom depends on it
    if (gp_alloc_zero(&plans_log, "in", LAST, sizeof *a.in, &a.in) ||
        gp_alloc_zero(&plans_log, "out", LAST, sizeof *a.out, &a.out))
        return 70;
    bad = print_head(&a);
    for (int n = FIRST; n <= LAST && !bad; n += 8) {
        if (is_taken(n))
            bad = print_length(n, rounds < 1 ? 1 : rounds, &a);
    }
    print_foot();
    gp_free(a.in);
    gp_free(a.out);
    return bad;
}
