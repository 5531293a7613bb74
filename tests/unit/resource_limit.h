/* The system's limits of a process, made smaller for a moment. */
#ifndef RESOURCE_LIMIT_H
#define RESOURCE_LIMIT_H

#include <sys/resource.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

/* Lets the process have `most` of `what` (RLIMIT_...); returns what it might
 * have until then, for setrlimit(). */
static inline struct rlimit resource_limit(int what, rlim_t most)
{
    struct rlimit was, now;
    assert_int_equal(getrlimit(what, &was), 0);
    now = was;
    now.rlim_cur = most;
    assert_int_equal(setrlimit(what, &now), 0);
    return was;
}

#endif
