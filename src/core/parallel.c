#include "core/parallel.h"

#include <limits.h>
#include <omp.h>

static int threads_wanted;

void gp_set_threads(int threads)
{
    threads_wanted = threads;
}

int gp_threads(void)
{
    int n = threads_wanted > 0 ? threads_wanted : omp_get_num_procs();
    return n > 0 ? n : 1;
}

gp_status gp_parallel(int n, gp_body body, void *ctx, int *failed)
{
    int first = INT_MAX; // lowest i that failed
    gp_status result = GP_OK;
    int team = gp_threads() < n ? gp_threads() : n;
    if (team < 1)
        return GP_OK;
#pragma omp parallel for schedule(dynamic, 1) num_threads(team)
    for (int i = 0; i < n; i++) {
        int limit;
#pragma omp atomic read
        limit = first;
        if (i > limit) // only what lies below can still change the answer
            continue;
        gp_status st = body(ctx, i, omp_get_thread_num());
        if (st) {
#pragma omp critical(gp_parallel_failed)
            if (i < first) {
                result = st;
#pragma omp atomic write
                first = i;
            }
        }
    }
    if (result && failed)
        *failed = first;
    return result;
}

void gp_parallel_do(int n, gp_task task, void *ctx)
{
    int team = gp_threads() < n ? gp_threads() : n;
    if (team < 1)
        return;
#pragma omp parallel for schedule(dynamic, 1) num_threads(team)
    for (int i = 0; i < n; i++)
        task(ctx, i, omp_get_thread_num());
}
