// SPDX-License-Identifier: Apache-2.0
/* Two commands in turn, A B A B ..., and the ratio of their times.
 *
 *   pair RUNS A... -- B...
 *
 * Prints medians of wall and CPU milliseconds, the largest peak memory of A,
 * and the medians of the ratios A/B of each pair, after one uncounted run of
 * each. Output of the commands is thrown away.
 */
#include "median.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { MOST_RUNS = 100 };

struct reading {
    double wall, cpu, peak_mib;
};

static double ms(struct timeval t)
{
    return (double) t.tv_sec * 1e3 + (double) t.tv_usec * 1e-3;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double) t.tv_sec * 1e3 + (double) t.tv_nsec * 1e-6;
}

static struct reading run_command(char **command)
{
    const double start = now();
    const pid_t child = fork();
    if (child == 0) {
        const int null = open("/dev/null", O_RDWR);
        if (null < 0 || dup2(null, 0) < 0 || dup2(null, 1) < 0)
            _exit(126);
        execvp(command[0], command);
        _exit(127);
    }
    int status = 0;
    struct rusage use;
    if (child < 0 || wait4(child, &status, 0, &use) < 0 ||
        !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        fprintf(stderr, "pair: %s failed\n", command[0]);
        exit(1);
    }
    return (struct reading) {
        now() - start, ms(use.ru_utime) + ms(use.ru_stime),
        (double) use.ru_maxrss / 1024.0,
    };
}

int main(int argc, char **argv)
{
    int split = 2;
    while (split < argc && strcmp(argv[split], "--") != 0)
        split++;
    if (split < 3 || split + 1 >= argc) {
        fprintf(stderr, "usage: pair RUNS A... -- B...\n");
        return 2;
    }
    argv[split] = NULL;
    int runs = atoi(argv[1]);
    runs = runs < 1 ? 1 : runs > MOST_RUNS ? MOST_RUNS : runs;
    static double v[6][MOST_RUNS];
    double peak = 0.0;
    for (int i = -1; i < runs; i++) {
        const struct reading a = run_command(argv + 2);
        const struct reading b = run_command(argv + split + 1);
        if (i < 0)
            continue;
        const double row[6] = {a.wall, a.cpu, b.wall, b.cpu,
                               a.wall / b.wall, a.cpu / b.cpu};
        for (int k = 0; k < 6; k++)
            v[k][i] = row[k];
        peak = a.peak_mib > peak ? a.peak_mib : peak;
    }
    for (int k = 0; k < 6; k++)
        v[k][0] = median(v[k], runs);
    printf("wall %.1f cpu %.1f ms, peak %.0f MiB; peer wall %.1f cpu %.1f ms; "
           "ratio wall %.2f cpu %.2f (medians of %d pairs)\n", v[0][0],
           v[1][0], peak, v[2][0], v[3][0], v[4][0], v[5][0], runs);
    return 0;
}
