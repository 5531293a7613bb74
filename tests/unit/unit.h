// SPDX-License-Identifier: Apache-2.0
/* A suite is a file of tests; a room's suites are one program:
 *
 *   build/tests/ROOM              every suite, each in a process of its own
 *   build/tests/ROOM 'exr*'       the suites that the pattern matches
 *   build/tests/ROOM fft --time   one suite, in this process, with arguments
 *   build/tests/ROOM --list       their names
 *
 * tests/unit/ROOM/NAME.c ends with SUITE_OF(NAME, setup, teardown, tests...),
 * with SUITE_OF_EACH where each test has its own setup and teardown, or defines
 * SUITE(NAME) { ... }, which runs its tests and returns how many failed. The
 * tests/Makefile lists the files.
 */
#ifndef GP_TESTS_UNIT_H
#define GP_TESTS_UNIT_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "set_env.h"

#define COUNT(a) (sizeof(a) / sizeof *(a))
#define assert_ok(call) assert_int_equal(call, GP_OK)

/* Skips the test; tests/run.sh counts the reasons. */
#define skip_for(why) (print_message("# skipped: %s\n", why), skip())

/* The data folder is $GLAREPP_DATA, or ../shared/data; data_path() returns a
 * path in it, in one place of memory. */
#define NO_DATA "no data folder (../shared/data, or $GLAREPP_DATA)"
const char *data_path(const char *name);

#define SUITE(name)                                                           \
    int suite_##name(int argc, char **argv);                                  \
    int suite_##name(int argc __attribute__((unused)),                        \
                     char **argv __attribute__((unused)))

/* A suite of these tests; setup and teardown of the group, or NULL. */
#define SUITE_OF(name, setup, teardown, ...)                                  \
    SUITE(name)                                                               \
    {                                                                         \
        const CMUnitTestFunction tests[] = {__VA_ARGS__};                     \
        return suite_run(tests, COUNT(tests), #__VA_ARGS__, setup, teardown,  \
                         NULL, NULL);                                         \
    }

/* The same, with setup and teardown for each test. */
#define SUITE_OF_EACH(name, setup, teardown, ...)                             \
    SUITE(name)                                                               \
    {                                                                         \
        const CMUnitTestFunction tests[] = {__VA_ARGS__};                     \
        return suite_run(tests, COUNT(tests), #__VA_ARGS__, NULL, NULL,       \
                         setup, teardown);                                    \
    }

/* Runs n tests, whose names stand in `names` with ", " between them. */
int suite_run(const CMUnitTestFunction *tests, size_t n, const char *names,
              CMFixtureFunction setup, CMFixtureFunction teardown,
              CMFixtureFunction each_setup, CMFixtureFunction each_teardown);

struct suite {
    const char *name;
    int (*run)(int argc, char **argv); // argv[0] is the suite's name
};

extern const struct suite suites[]; // ends with a NULL name

#endif
