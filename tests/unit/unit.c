/* Runs the suites of a room; see unit.h. */
#include "unit.h"

#include <fnmatch.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

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
