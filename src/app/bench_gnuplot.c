#include "app/bench_gnuplot.h"

#include <errno.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

/* The child's standard streams are files in memory: nothing can block, however
 * much is written. */
enum { STREAMS = 3 };

static bool open_streams(int fd[STREAMS])
{
    static const char *const names[STREAMS] = {"script", "picture", "errors"};
    for (int i = 0; i < STREAMS; i++)
        fd[i] = memfd_create(names[i], MFD_CLOEXEC);
    return fd[0] >= 0 && fd[1] >= 0 && fd[2] >= 0;
}

static void close_streams(const int fd[STREAMS])
{
    for (int i = 0; i < STREAMS; i++) {
        if (fd[i] >= 0)
            close(fd[i]);
    }
}

static bool put_script(int fd, const char *script)
{
    size_t n = strlen(script);
    while (n > 0) {
        const ssize_t written = write(fd, script, n);
        if (written < 0 && errno != EINTR)
            return false;
        script += written > 0 ? written : 0;
        n -= written > 0 ? (size_t) written : 0;
    }
    return lseek(fd, 0, SEEK_SET) == 0;
}

/* All of a stream with a 0 behind it; NULL when it cannot be read. */
static char *take(int fd, size_t *size)
{
    const off_t length = lseek(fd, 0, SEEK_END);
    char *const text = length >= 0 ? malloc((size_t) length + 1) : NULL;
    size_t n = 0;
    while (text && n < (size_t) length) {
        const ssize_t got = pread(fd, text + n, (size_t) length - n, (off_t) n);
        if (got <= 0 && errno != EINTR)
            break;
        n += got > 0 ? (size_t) got : 0;
    }
    if (text)
        text[n] = '\0';
    *size = n;
    return text;
}

/* Starts it and waits for its end. Returns 0, or an errno; *status is what
 * waitpid() says. */
static int run(const int fd[STREAMS], int *status)
{
    char name[] = "gnuplot", plain[] = "--default-settings";
    char *const argv[] = {name, plain, NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int error = posix_spawn_file_actions_init(&actions);
    if (error)
        return error;
    for (int i = 0; i < STREAMS && !error; i++)
        error = posix_spawn_file_actions_adddup2(&actions, fd[i], i);
    if (!error)
        error = posix_spawnp(&pid, name, &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error)
        return error;
    while (waitpid(pid, status, 0) < 0) {
        if (errno != EINTR)
            return errno;
    }
    return 0;
}

/* The first line of what it complained about, without its indent. */
static gp_status complain(const struct gp_log *log, int fd)
{
    size_t size;
    char *const text = take(fd, &size);
    const char *line = text ? text + strspn(text, " \n\t^") : "";
    gp_status st = gp_fail(log, GP_ERR_IO,
                           "gnuplot: made no picture (%.*s); check the Debian "
                           "package gnuplot-nox",
                           *line ? (int) strcspn(line, "\n") : 10,
                           *line ? line : "no reason");
    free(text);
    return st;
}

gp_status gp_gnuplot(const struct gp_log *log, const char *script, char **out,
                     size_t *size)
{
    int fd[STREAMS], status = 0;
    gp_status st = GP_OK;
    int error = open_streams(fd) && put_script(fd[0], script) ? 0 : errno;
    if (!error)
        error = run(fd, &status);
    if (error)
        st = gp_fail(log, GP_ERR_IO,
                     "gnuplot: cannot be run (%s); install the Debian package "
                     "gnuplot-nox, or leave --plot out", strerror(error));
    else if (!WIFEXITED(status) || WEXITSTATUS(status) == 127)
        st = gp_fail(log, GP_ERR_IO,
                     "gnuplot: cannot be run (it ended with %#x); install the "
                     "Debian package gnuplot-nox, or leave --plot out",
                     (unsigned) status);
    else if (WEXITSTATUS(status) != 0)
        st = complain(log, fd[2]);
    char *const text = st ? NULL : take(fd[1], size);
    if (!st && !text)
        st = gp_fail(log, GP_ERR_BUG, "gnuplot: out of memory");
    if (!st)
        *out = text;
    close_streams(fd);
    return st;
}
