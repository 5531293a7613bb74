// SPDX-License-Identifier: Apache-2.0
/* Runs the suites of a room; see unit.h. */
#include "unit.h"

#include "core/json.h"

#include <fnmatch.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

int suite_run(const CMUnitTestFunction *tests, size_t n, const char *names,
              CMFixtureFunction setup, CMFixtureFunction teardown,
              CMFixtureFunction each_setup, CMFixtureFunction each_teardown)
{
    struct CMUnitTest *const test = calloc(n, sizeof *test);
    char *const text = strdup(names);
    char *rest = text;
    if (!test || !text)
        abort();
    for (size_t i = 0; i < n; i++) {
        test[i] = (struct CMUnitTest) {
            .name = strtok_r(rest, ", ", &rest),
            .test_func = tests[i],
            .setup_func = each_setup,
            .teardown_func = each_teardown,
        };
    }
    const int failed =
        _cmocka_run_group_tests("tests", test, n, setup, teardown);
    free(text);
    free(test);
    return failed;
}

const char *data_path(const char *name)
{
    static char path[4096];
    const char *const data = getenv("GLAREPP_DATA");
    snprintf(path, sizeof path, "%s/%s", data ? data : "../shared/data", name);
    return path;
}

static int run_apart(const struct suite *s)
{
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        char name[256];
        snprintf(name, sizeof name, "%s", s->name);
        char *argv[] = {name, NULL};
        const int failed = s->run(1, argv);
        fflush(stdout);
        _exit(failed != 0);
    }
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) != child)
        return 1;
    if (WIFSIGNALED(status))
        fprintf(stderr, "%s: signal %d\n", s->name, WTERMSIG(status));
    return status != 0;
}

int main(int argc, char **argv)
{
    set_env(NULL, NULL);
    gp_json_watch_memory(); // as the program does
    const char *const pattern = argc > 1 ? argv[1] : "*";
    int failed = 0, matched = 0;
    for (const struct suite *s = suites; s->name; s++) {
        if (strcmp(pattern, "--list") == 0) {
            puts(s->name);
            matched++;
        } else if (strcmp(pattern, s->name) == 0) {
            return s->run(argc - 1, argv + 1) != 0;
        } else if (fnmatch(pattern, s->name, 0) == 0) {
            failed += run_apart(s);
            matched++;
        }
    }
    if (!matched)
        fprintf(stderr, "%s: no suite %s\n", argv[0], pattern);
    return failed || !matched;
}
