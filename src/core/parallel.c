// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.h"

#include "core/memory.h"

#include <limits.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* A pool of our own, not OpenMP's: libgomp's threads spin for milliseconds
 * after each loop, which costs a short run more than its work, and other
 * programs a core. These sleep. */
enum { MOST_THREADS = 256 };

/* Of a worker; the usual 8 MiB of address space each leave little for frames
 * under `ulimit -v`. No body of the tests takes more than 40 KiB. */
enum { STACK_BYTES = 1 << 20 };

/* A loop under way, on its caller's stack. */
struct loop {
    gp_body body;
    void *ctx;
    int n;
    atomic_int next;          // i to run next
    atomic_int first;         // lowest i that failed
    gp_status result;         // of `first`
    int team;                 // most threads in it, the caller's too
    int busy;                 // workers in it
    bool taken[MOST_THREADS]; // numbers of these, from 1
    const struct gp_env *env; // of its caller
    struct loop *younger;     // next open one
};

struct gp_pool {
    pthread_mutex_t lock;
    pthread_cond_t wake, rest, turn;
    atomic_int wanted;   // threads; 0: one a processor
    int workers;         // threads there are besides the callers'
    pthread_t worker[MOST_THREADS];
    bool ends;           // the workers shall
    int active;          // threads at work: callers and workers
    atomic_int waiting;  // threads in gp_parallel_enter()
    struct loop *open;   // loops that may have something left, oldest first
};

/* The pool of threads that use no other. Its callers do not enter: the first
 * counts as at work. */
static struct gp_pool usual = {
    .lock = PTHREAD_MUTEX_INITIALIZER,
    .wake = PTHREAD_COND_INITIALIZER,
    .rest = PTHREAD_COND_INITIALIZER,
    .turn = PTHREAD_COND_INITIALIZER,
    .active = 1,
};

static atomic_int processors; // that the process may use; 0 not asked yet
static _Thread_local bool inside; // this thread runs a body

// -- the environment of a thread ----------------------------------------------

static const struct gp_env nothing;
static _Thread_local const struct gp_env *own;

const struct gp_env *gp_env(void)
{
    return own ? own : &nothing;
}

const struct gp_env *gp_env_use(const struct gp_env *env)
{
    static _Thread_local locale_t outside; // of the thread, outside of calls
    const struct gp_env *const before = own;
    const bool in = before && before->locale, goes_in = env && env->locale;
    own = env;
    if (in || goes_in) {
        const locale_t was = uselocale(goes_in ? env->locale : outside);
        outside = in ? outside : was;
    }
    return before;
}

// -- pools --------------------------------------------------------------------

static struct gp_pool *pool_of(const struct gp_env *env)
{
    return env->pool ? env->pool : &usual;
}

gp_status gp_pool_make(const struct gp_log *log, int threads,
                       struct gp_pool **out)
{
    gp_status st = gp_alloc_zero(log, "threads", 1, sizeof **out, out);
    if (st)
        return st;
    pthread_mutex_init(&(*out)->lock, NULL);
    pthread_cond_init(&(*out)->wake, NULL);
    pthread_cond_init(&(*out)->rest, NULL);
    pthread_cond_init(&(*out)->turn, NULL);
    atomic_init(&(*out)->wanted, threads);
    return GP_OK;
}

void gp_pool_free(struct gp_pool **pool)
{
    struct gp_pool *const p = *pool;
    if (!p)
        return;
    pthread_mutex_lock(&p->lock);
    p->ends = true;
    pthread_cond_broadcast(&p->wake);
    pthread_mutex_unlock(&p->lock);
    for (int i = 0; i < p->workers; i++)
        pthread_join(p->worker[i], NULL);
    pthread_cond_destroy(&p->turn);
    pthread_cond_destroy(&p->rest);
    pthread_cond_destroy(&p->wake);
    pthread_mutex_destroy(&p->lock);
    GP_FREE(*pool);
}

void gp_set_threads(int threads)
{
    atomic_store(&pool_of(gp_env())->wanted, threads);
}

static int threads_of(struct gp_pool *pool)
{
    const int wanted = atomic_load(&pool->wanted);
    int n = wanted > 0 ? wanted : atomic_load(&processors);
    if (n == 0) { // not asked yet
        cpu_set_t set;
        n = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
        atomic_store(&processors, n);
    }
    return n > MOST_THREADS ? MOST_THREADS : n;
}

int gp_threads(void)
{
    return threads_of(pool_of(gp_env()));
}

// -- loops --------------------------------------------------------------------

/* Takes one i after another until none is left, or, as a helper, until some
 * thread waits for its place. */
static void run_share(struct gp_pool *pool, struct loop *l, int thread)
{
    inside = true;
    while (!thread || !atomic_load(&pool->waiting)) {
        const int i = atomic_fetch_add(&l->next, 1);
        if (i >= l->n)
            break;
        if (i > atomic_load(&l->first))
            continue; // only a failure of a lower i could change the result
        const gp_status st = l->body(l->ctx, i, thread);
        if (!st)
            continue;
        pthread_mutex_lock(&pool->lock);
        if (i < atomic_load(&l->first)) {
            atomic_store(&l->first, i);
            l->result = st;
        }
        pthread_mutex_unlock(&pool->lock);
    }
    inside = false;
}

/* The oldest loop that one more thread can help, or NULL. Locked. */
static struct loop *find_loop(struct gp_pool *pool)
{
    if (pool->active >= threads_of(pool) || atomic_load(&pool->waiting))
        return NULL;
    for (struct loop *l = pool->open; l; l = l->younger) {
        if (l->busy + 1 < l->team && atomic_load(&l->next) < l->n)
            return l;
    }
    return NULL;
}

/* One thread less at work. Locked. */
static void retire(struct gp_pool *pool)
{
    pool->active--;
    if (atomic_load(&pool->waiting))
        pthread_cond_signal(&pool->turn);
}

/* Wakes a worker when there is something for it; it wakes the next. Locked. */
static void call_help(struct gp_pool *pool)
{
    if (find_loop(pool))
        pthread_cond_signal(&pool->wake);
}

/* Works for one loop after another, as its next free number. */
static void *worker(void *arg)
{
    struct gp_pool *const pool = arg;
    pthread_mutex_lock(&pool->lock);
    while (!pool->ends) {
        struct loop *const l = find_loop(pool);
        int thread = 1;
        if (!l) {
            pthread_cond_wait(&pool->wake, &pool->lock);
            continue;
        }
        while (l->taken[thread])
            thread++;
        l->taken[thread] = true;
        l->busy++;
        pool->active++;
        call_help(pool);
        pthread_mutex_unlock(&pool->lock);
        gp_env_use(l->env);
        run_share(pool, l, thread);
        pthread_mutex_lock(&pool->lock);
        l->taken[thread] = false;
        if (--l->busy == 0)
            pthread_cond_broadcast(&pool->rest);
        retire(pool);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* Starts the missing threads; fewer are no error. They block signals: the
 * caller's threads handle them. Locked. */
static void start_workers(struct gp_pool *pool, int n)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    pthread_attr_t own;
    const bool sized = pthread_attr_init(&own) == 0;
    if (sized)
        pthread_attr_setstacksize(&own, STACK_BYTES);
    while (pool->workers < n &&
           pthread_create(&pool->worker[pool->workers], sized ? &own : NULL,
                          worker, pool) == 0)
        pool->workers++;
    if (sized)
        pthread_attr_destroy(&own);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

gp_status gp_parallel(int n, gp_body body, void *ctx, int *failed)
{
    const int team = gp_threads() < n ? gp_threads() : n;
    if (team < 2 || inside) {
        for (int i = 0; i < n; i++) {
            const gp_status st = body(ctx, i, 0);
            if (st && failed)
                *failed = i;
            if (st)
                return st;
        }
        return GP_OK;
    }
    struct loop l = {.body = body, .ctx = ctx, .n = n, .team = team,
                     .env = gp_env()};
    struct gp_pool *const pool = pool_of(l.env);
    atomic_init(&l.next, 0);
    atomic_init(&l.first, INT_MAX);
    pthread_mutex_lock(&pool->lock);
    start_workers(pool, team - 1);
    struct loop **at = &pool->open; // after the others
    while (*at)
        at = &(*at)->younger;
    *at = &l;
    call_help(pool);
    pthread_mutex_unlock(&pool->lock);
    run_share(pool, &l, 0);
    pthread_mutex_lock(&pool->lock);
    at = &pool->open; // earlier loops may have ended
    while (*at != &l)
        at = &(*at)->younger;
    *at = l.younger;
    while (l.busy > 0)
        pthread_cond_wait(&pool->rest, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
    if (l.result && failed)
        *failed = atomic_load(&l.first);
    return l.result;
}

void gp_parallel_enter(void)
{
    struct gp_pool *const pool = pool_of(gp_env());
    pthread_mutex_lock(&pool->lock);
    atomic_fetch_add(&pool->waiting, 1);
    while (pool->active >= threads_of(pool))
        pthread_cond_wait(&pool->turn, &pool->lock);
    atomic_fetch_sub(&pool->waiting, 1);
    pool->active++;
    call_help(pool);
    pthread_mutex_unlock(&pool->lock);
}

void gp_parallel_leave(void)
{
    struct gp_pool *const pool = pool_of(gp_env());
    pthread_mutex_lock(&pool->lock);
    retire(pool);
    call_help(pool);
    pthread_mutex_unlock(&pool->lock);
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
