/* A call with a memory that is full at the n-th allocation, for every n. */
#ifndef GP_TESTS_STARVED_H
#define GP_TESTS_STARVED_H

#include "fail.h"
#include "kept_log.h"

/* Each failure is GP_ERR_BUG with one line, loses no block and leaves *result
 * at 0; without one the result is that of the first run.
 *
 *   run     logs to kept_log and writes *result, not 0, on GP_OK only
 *   least   allocations of one run */
static inline void starve(const char *name, gp_status (*run)(void),
                          double *result, int least)
{
    *result = 0.0;
    assert_ok(run());
    const double want = *result;
    assert_true(want > 0.0);
    long n = 1;
    for (;; n++) {
        const long blocks = fail_blocks();
        kept_clear();
        *result = 0.0;
        fail_at(FAIL_ALLOC, n);
        const gp_status st = run();
        const bool fired = fail_end();
        assert_int_equal(fail_blocks(), blocks);
        if (!fired) {
            assert_ok(st);
            assert_true(*result == want);
            break;
        }
        if (st != GP_ERR_BUG || kept_errors != 1)
            fail_msg("%s, %ld: status %d, %d lines, \"%s\"", name, n, (int) st,
                     kept_errors, kept_line);
        assert_true(*result == 0.0);
    }
    assert_true(n > least);
}

#endif
