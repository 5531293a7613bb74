#include "core/parallel.h"

#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>

/* A pool of our own, not OpenMP's: libgomp's threads spin for milliseconds
 * after each loop, which costs a short run more than its work and takes the
 * other core from whoever shares the machine. These sleep. */
enum { MOST_THREADS = 256 };

static struct pool {
    pthread_mutex_t lock;
    pthread_cond_t wake, rest;
    int workers;         // threads there are besides the caller's
    int team;            // threads of the loop under way, the caller's too;
                         // 0 when it is over: who wakes late sleeps on
    int busy;            // workers that are in it
    unsigned long loop;  // its number
    gp_body body;
    void *ctx;
    int n;
    atomic_int next;     // i to run next
    atomic_int first;    // lowest i that failed
    gp_status result;    // of `first`
} pool = {
    .lock = PTHREAD_MUTEX_INITIALIZER,
    .wake = PTHREAD_COND_INITIALIZER,
    .rest = PTHREAD_COND_INITIALIZER,
};

static int threads_wanted;
static _Thread_local bool inside; // this thread runs a body

void gp_set_threads(int threads)
{
    threads_wanted = threads;
}

int gp_threads(void)
{
    int n = threads_wanted;
    if (n <= 0) {
        cpu_set_t set;
        n = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    }
    return n < 1 ? 1 : n > MOST_THREADS ? MOST_THREADS : n;
}

/* Takes one i after another until none is left. */
static void work(int thread)
{
    inside = true;
    for (;;) {
        const int i = atomic_fetch_add(&pool.next, 1);
        if (i >= pool.n)
            break;
        if (i > atomic_load(&pool.first))
            continue; // only what lies below can still change the answer
        const gp_status st = pool.body(pool.ctx, i, thread);
        if (!st)
            continue;
        pthread_mutex_lock(&pool.lock);
        if (i < atomic_load(&pool.first)) {
            atomic_store(&pool.first, i);
            pool.result = st;
        }
        pthread_mutex_unlock(&pool.lock);
    }
    inside = false;
}

static void *worker(void *arg)
{
    const int thread = (int) (long) arg;
    unsigned long seen = 0;
    pthread_mutex_lock(&pool.lock);
    for (;;) {
        while (pool.loop == seen || thread >= pool.team)
            pthread_cond_wait(&pool.wake, &pool.lock);
        seen = pool.loop;
        pool.busy++;
        pthread_mutex_unlock(&pool.lock);
        work(thread);
        pthread_mutex_lock(&pool.lock);
        if (--pool.busy == 0)
            pthread_cond_signal(&pool.rest);
    }
    return NULL;
}

/* The threads stay with the parent. */
static void after_fork(void)
{
    pthread_mutex_init(&pool.lock, NULL);
    pthread_cond_init(&pool.wake, NULL);
    pthread_cond_init(&pool.rest, NULL);
    pool.workers = pool.busy = pool.team = 0;
    pool.loop = 0;
}

/* Starts what is missing of `team` threads; fewer are no error. Locked.
 * Signals are for the caller's thread, which knows what it is at: a handler
 * on another could miss a file that is being opened. */
static void start_workers(int team)
{
    static bool registered;
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    if (!registered)
        registered = pthread_atfork(NULL, NULL, after_fork) == 0;
    while (pool.workers < team - 1) {
        pthread_t id;
        if (pthread_create(&id, NULL, worker,
                           (void *) (long) (pool.workers + 1)) != 0)
            break;
        pthread_detach(id);
        pool.workers++;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

static gp_status run_alone(int n, gp_body body, void *ctx, int *failed)
{
    for (int i = 0; i < n; i++) {
        const gp_status st = body(ctx, i, 0);
        if (st) {
            if (failed)
                *failed = i;
            return st;
        }
    }
    return GP_OK;
}

gp_status gp_parallel(int n, gp_body body, void *ctx, int *failed)
{
    int team = gp_threads() < n ? gp_threads() : n;
    if (team < 2 || inside)
        return run_alone(n, body, ctx, failed);
    pthread_mutex_lock(&pool.lock);
    start_workers(team);
    team = team < pool.workers + 1 ? team : pool.workers + 1;
    pool.body = body;
    pool.ctx = ctx;
    pool.n = n;
    pool.result = GP_OK;
    atomic_store(&pool.next, 0);
    atomic_store(&pool.first, INT_MAX);
    pool.team = team;
    pool.loop++;
    pthread_cond_broadcast(&pool.wake);
    pthread_mutex_unlock(&pool.lock);
    work(0);
    pthread_mutex_lock(&pool.lock);
    pool.team = 0;
    while (pool.busy > 0)
        pthread_cond_wait(&pool.rest, &pool.lock);
    pthread_mutex_unlock(&pool.lock);
    if (pool.result && failed)
        *failed = atomic_load(&pool.first);
    return pool.result;
}

/* A task as a body. */
struct plain {
    gp_task task;
    void *ctx;
};

static gp_status run_task(void *ctx, int i, int thread)
{
    const struct plain *const p = ctx;
    p->task(p->ctx, i, thread);
    return GP_OK;
}

void gp_parallel_do(int n, gp_task task, void *ctx)
{
    struct plain p = {task, ctx};
    const gp_status never = gp_parallel(n, run_task, &p, NULL);
    (void) never;
}
