// SPDX-License-Identifier: Apache-2.0
/* Wall and CPU clocks for reports; no result depends on them. */
#ifndef GP_CORE_CLOCK_H
#define GP_CORE_CLOCK_H

#include <time.h>

/* Milliseconds of the monotonic clock. */
static inline double gp_now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double) t.tv_sec * 1e3 + (double) t.tv_nsec * 1e-6;
}

/* Milliseconds of CPU time that all threads of the process took. */
static inline double gp_cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double) t.tv_sec * 1e3 + (double) t.tv_nsec * 1e-6;
}

#endif
