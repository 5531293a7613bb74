// SPDX-License-Identifier: Apache-2.0
/* Parallel loops: each i once, the lowest failure, loops of several threads at
 * once, and never more threads at work than there may be. */
#include "unit.h"
#include "core/parallel.h"
#include "fail.h"

#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { MOST = 5000, CALLERS = 5 };

/* The calls that a loop made. */
struct seen {
    atomic_int count[MOST];
    atomic_int in_use[256]; // by thread number
    atomic_int wrong;
    int fail_from, fail_step; // 0: none fails
    int nested;               // i of inner loops
};

static atomic_int at_work, most_at_work;

static void note_start(void)
{
    const int now = atomic_fetch_add(&at_work, 1) + 1;
    int most = atomic_load(&most_at_work);
    while (now > most &&
           !atomic_compare_exchange_weak(&most_at_work, &most, now))
        ;
}

static void inner(void *ctx, int i, int thread)
{
    atomic_int *const sum = ctx;
    (void) thread;
    atomic_fetch_add(sum, i);
}

static gp_status body(void *ctx, int i, int thread)
{
    struct seen *const s = ctx;
    note_start();
    if (thread < 0 || thread >= gp_threads() ||
        atomic_fetch_add(&s->in_use[thread], 1) != 0)
        atomic_fetch_add(&s->wrong, 1);
    atomic_fetch_add(&s->count[i], 1);
    if (s->nested) {
        atomic_int sum = 0;
        gp_parallel_do(s->nested, inner, &sum);
        if (sum != s->nested * (s->nested - 1) / 2)
            atomic_fetch_add(&s->wrong, 1);
    }
    volatile float work = 1.0f;
    for (int k = 0; k < 300; k++)
        work = work * 1.0001f;
    atomic_fetch_sub(&s->in_use[thread], 1);
    atomic_fetch_sub(&at_work, 1);
    if (s->fail_step && i >= s->fail_from &&
        (i - s->fail_from) % s->fail_step == 0)
        return i == s->fail_from ? GP_ERR_DATA : GP_ERR_IO;
    return GP_OK;
}

static void check_all_once(struct seen *s, int n)
{
    assert_int_equal(s->wrong, 0);
    for (int i = 0; i < n; i++)
        assert_int_equal(s->count[i], 1);
    for (int i = n; i < MOST; i++)
        assert_int_equal(s->count[i], 0);
}

static void each_i_once(void **state)
{
    static const int threads[] = {1, 2, 3, 8, 200}, n[] = {0, 1, 2, 7, 5000};
    static struct seen s;
    for (size_t t = 0; t < COUNT(threads); t++) {
        for (size_t k = 0; k < COUNT(n); k++) {
            memset(&s, 0, sizeof s);
            s.nested = 9;
            gp_set_threads(threads[t]);
            assert_ok(gp_parallel(n[k], body, &s, NULL));
            check_all_once(&s, n[k]);
        }
    }
}

static void lowest_failure(void **state)
{
    static const struct { int threads, n, from, step; } row[] = {
        {1, 100, 0, 1}, {2, 100, 99, 1}, {3, 2000, 77, 5}, {8, 2000, 1999, 1},
        {8, 5000, 3, 1}, {4, 2, 1, 1},
    };
    static struct seen s;
    for (size_t k = 0; k < COUNT(row); k++) {
        int failed = -1;
        memset(&s, 0, sizeof s);
        s.fail_from = row[k].from;
        s.fail_step = row[k].step;
        gp_set_threads(row[k].threads);
        assert_int_equal(gp_parallel(row[k].n, body, &s, &failed), GP_ERR_DATA);
        assert_int_equal(failed, row[k].from);
        for (int i = 0; i < row[k].from; i++) // all below was run
            assert_int_equal(s.count[i], 1);
    }
}

// -- several callers -----------------------------------------------------------

struct caller {
    struct seen seen;
    int loops, n;
    int failed;
    gp_status st;
};

static void *call(void *arg)
{
    struct caller *const c = arg;
    gp_parallel_enter();
    for (int k = 0; k < c->loops && c->st == GP_OK; k++) {
        memset(&c->seen.count, 0, sizeof c->seen.count);
        c->st = gp_parallel(c->n, body, &c->seen, &c->failed);
        for (int i = 0; i < c->n && !c->st; i++) {
            if (c->seen.count[i] != 1)
                atomic_fetch_add(&c->seen.wrong, 1);
        }
        if (k % 3 == 0) { // as one that waits for another
            gp_parallel_leave();
            gp_parallel_enter();
        }
    }
    gp_parallel_leave();
    return NULL;
}

static void callers_share(void **state)
{
    static const int threads[] = {1, 2, 3, 8};
    static struct caller c[CALLERS];
    for (size_t t = 0; t < COUNT(threads); t++) {
        pthread_t id[CALLERS];
        gp_set_threads(threads[t]);
        atomic_store(&most_at_work, 0);
        memset(c, 0, sizeof c);
        gp_parallel_leave(); // this thread only waits
        for (int i = 0; i < CALLERS; i++) {
            c[i].loops = 20;
            c[i].n = 100 + 300 * i;
            c[i].seen.fail_step = i == 3; // one fails, the others do not
            c[i].seen.fail_from = 5;
            assert_int_equal(pthread_create(&id[i], NULL, call, &c[i]), 0);
        }
        for (int i = 0; i < CALLERS; i++)
            pthread_join(id[i], NULL);
        gp_parallel_enter();
        for (int i = 0; i < CALLERS; i++) {
            assert_int_equal(c[i].st, i == 3 ? GP_ERR_DATA : GP_OK);
            assert_int_equal(c[i].seen.wrong, 0);
        }
        assert_int_equal(c[3].failed, 5);
        assert_true(atomic_load(&most_at_work) <= threads[t]);
        assert_true(atomic_load(&most_at_work) >= 1);
    }
}

/* A thread whose environment has a pool of its own. */
struct apart {
    int threads, seen;
    struct seen s;
    gp_status st;
};

static void *run_apart(void *arg)
{
    struct apart *const a = arg;
    struct gp_pool *pool;
    a->st = gp_pool_make(NULL, a->threads, &pool);
    if (a->st)
        return NULL;
    const struct gp_env env = {.pool = pool};
    gp_env_use(&env);
    a->seen = gp_threads();
    for (int k = 0; k < 20 && !a->st; k++)
        a->st = gp_parallel(500, body, &a->s, NULL);
    gp_pool_free(&pool);
    return NULL;
}

static void pools_stand_apart(void **state)
{
    static struct apart a[2] = {{.threads = 2}, {.threads = 5}};
    pthread_t id[2];
    gp_set_threads(3);
    for (int k = 0; k < 2; k++)
        assert_int_equal(pthread_create(&id[k], NULL, run_apart, &a[k]), 0);
    for (int k = 0; k < 2; k++) {
        pthread_join(id[k], NULL);
        assert_ok(a[k].st);
        assert_int_equal(a[k].seen, a[k].threads);
        for (int i = 0; i < 500; i++)
            assert_int_equal(a[k].s.count[i], 20);
    }
    assert_int_equal(gp_threads(), 3);
}

// -- threads that the system refuses --------------------------------------------

/* More processors than the system can list count as one. First of all tests:
 * processors are asked for once. */
static void processors_unknown(void **state)
{
    fail_always.affinity = true;
    gp_set_threads(0);
    assert_int_equal(gp_threads(), 1);
    fail_always.affinity = false;
    assert_int_equal(gp_threads(), 1); // and are not asked for again
    static const struct { int wanted, got; } rows[] = {
        {1, 1}, {7, 7}, {256, 256}, {257, 256}, {INT_MAX, 256}, {-3, 1},
        {INT_MIN, 1}, {0, 1},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        gp_set_threads(rows[i].wanted);
        assert_int_equal(gp_threads(), rows[i].got);
    }
}

static gp_status count_body(void *ctx, int i, int thread)
{
    atomic_int *const done = ctx;
    assert_int_equal(thread, 0);
    atomic_fetch_add(done, 1);
    return i >= 40 ? GP_ERR_DATA : GP_OK;
}

static void threads_do_not_start(void **state)
{
    static const struct { int n; gp_status st; int failed, done; } rows[] = {
        {0, GP_OK, -1, 0}, {1, GP_OK, -1, 1}, {40, GP_OK, -1, 40},
        {100, GP_ERR_DATA, 40, 41},
    };
    fail_always.threads = true;
    for (int threads = 1; threads <= 4; threads += 3) {
        gp_set_threads(threads);
        for (size_t i = 0; i < COUNT(rows); i++) {
            atomic_int done = 0;
            int failed = -1;
            assert_int_equal(gp_parallel(rows[i].n, count_body, &done, &failed),
                             rows[i].st);
            assert_int_equal(failed, rows[i].failed);
            assert_int_equal(done, rows[i].done);
            assert_int_equal(gp_parallel(rows[i].n, count_body, &done, NULL),
                             rows[i].st);
        }
    }
    fail_always.threads = false;
    gp_set_threads(1);
}

// threads_do_not_start before any loop has left workers that would help
SUITE_OF(parallel, NULL, NULL, processors_unknown, threads_do_not_start,
         each_i_once, lowest_failure, callers_share, pools_stand_apart)
