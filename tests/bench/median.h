// SPDX-License-Identifier: Apache-2.0
/* Shared by the programs that time: medians, and a log. */
#ifndef GP_BENCH_MEDIAN_H
#define GP_BENCH_MEDIAN_H

#include "core/status.h"

#include <stdio.h>
#include <stdlib.h>

static inline int by_value(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

/* Sorts v. */
static inline double median(double *v, int n)
{
    qsort(v, (size_t) n, sizeof *v, by_value);
    return v[n / 2];
}

/* `user` is the program's name. */
static inline void print_line(void *user, const struct gp_line *line)
{
    fprintf(stderr, "%s: %s\n", (const char *) user, line->text);
}
#define BENCH_LOG(name) {print_line, (void *) (name), GP_LEVEL_WARN}

#endif
