/* A layer's bytes under other numbers of llvmpipe's threads, which it reads at
 * its start alone: the test runs itself with --hash. */
#ifndef GP_TESTS_DRIVER_THREADS_H
#define GP_TESTS_DRIVER_THREADS_H

#include <stdbool.h>
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

/* The line that this program's `suite --hash` prints, and its status, or -1. */
static inline int hash_with(const char *suite, const char *threads,
                            char *line, int size)
{
    char self[4096] = "", command[4200];
    if (readlink("/proc/self/exe", self, sizeof self - 1) < 0)
        return -1;
    snprintf(command, sizeof command, "LP_NUM_THREADS=%s '%s' %s --hash",
             threads, self, suite);
    FILE *p = popen(command, "r");
    assert_non_null(p);
    const bool said = fgets(line, size, p) != NULL;
    const int status = pclose(p);
    return WIFEXITED(status) && (said || WEXITSTATUS(status))
               ? WEXITSTATUS(status) : -1;
}

/* No GL (status 77) skips. */
static inline void threads_same_bytes(const char *suite)
{
    static const char *const threads[] = {"1", "2", "3", "4", "7", "2"};
    char first[256], line[256];
    const int status = hash_with(suite, "0", first, sizeof first);
    if (status == 77)
        skip();
    assert_int_equal(status, 0);
    for (size_t i = 0; i < sizeof threads / sizeof threads[0]; i++) {
        assert_int_equal(hash_with(suite, threads[i], line, sizeof line), 0);
        assert_string_equal(line, first);
    }
}

#endif
