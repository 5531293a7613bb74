#include "io/file.h"

#include "core/memory.h"
#include "io/io_priv.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    LIVE_MAX = 64, // temporary files that a signal can remove
    LIVE_NAME_MAX = 4096,
    PATIENCE_MS = 1000,
    TRIES = 1000, // names of one target and one process number
    NAME_BYTES = 255, // of one path component, on all usual systems
};

// -- what a signal must remove ------------------------------------------------

static struct {
    volatile sig_atomic_t live;
    char name[LIVE_NAME_MAX];
} live_temps[LIVE_MAX];
static pthread_mutex_t live_lock = PTHREAD_MUTEX_INITIALIZER;

/* A signal's handler may run while other threads make or remove files. It waits
 * for those; threads that start to do so later wait for the end. */
static atomic_int naming;
static atomic_bool ending;

void gp_temp_wait(void)
{
    while (atomic_load(&ending))
        pause();
}

/* Between begin_naming() and end_naming() this thread handles no signal, and no
 * signal ends the process, so that live_temps matches the files on disk. */
static void begin_naming(sigset_t *before)
{
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, before);
    atomic_fetch_add(&naming, 1);
    if (atomic_load(&ending)) {
        atomic_fetch_sub(&naming, 1);
        gp_temp_wait();
    }
}

static void end_naming(const sigset_t *before)
{
    atomic_fetch_sub(&naming, 1);
    pthread_sigmask(SIG_SETMASK, before, NULL);
}

static int live_add(const char *name)
{
    int slot = -1;
    if (strlen(name) >= LIVE_NAME_MAX)
        return -1;
    pthread_mutex_lock(&live_lock);
    for (int i = 0; i < LIVE_MAX && slot < 0; i++) {
        if (!live_temps[i].live) {
            strcpy(live_temps[i].name, name);
            live_temps[i].live = 1; // last: the handler trusts the name
            slot = i;
        }
    }
    pthread_mutex_unlock(&live_lock);
    return slot;
}

static void live_drop(int slot)
{
    if (slot < 0)
        return;
    pthread_mutex_lock(&live_lock);
    live_temps[slot].live = 0;
    pthread_mutex_unlock(&live_lock);
}

void gp_temp_remove_all(void)
{
    const struct timespec moment = {.tv_nsec = 1000000};
    atomic_store(&ending, true);
    // not forever: a file system may hang
    for (int i = 0; i < PATIENCE_MS && atomic_load(&naming) > 0; i++)
        nanosleep(&moment, NULL);
    for (int i = 0; i < LIVE_MAX; i++) {
        if (live_temps[i].live)
            unlink(live_temps[i].name);
    }
}

static void remove_and_end(int sig)
{
    gp_temp_remove_all();
    raise(sig); // SA_RESETHAND: the default action, once this returns
}

void gp_temp_cleanup_on_signal(void)
{
    static const int deadly[] = {SIGINT,  SIGTERM,   SIGHUP,  SIGQUIT, SIGXCPU,
                                 SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2};
    struct sigaction act = {.sa_handler = remove_and_end,
                            .sa_flags = (int) SA_RESETHAND};
    sigemptyset(&act.sa_mask);
    for (size_t i = 0; i < sizeof deadly / sizeof *deadly; i++) {
        struct sigaction was;
        if (!sigaction(deadly[i], NULL, &was) && was.sa_handler != SIG_IGN)
            sigaction(deadly[i], &act, NULL);
    }
    signal(SIGPIPE, SIG_IGN);
}

// -- names --------------------------------------------------------------------

char *gp_file_temp_name(const char *path, int nth)
{
    const char *const slash = strrchr(path, '/');
    const char *const base = slash ? slash + 1 : path;
    const long pid = (long) getpid();
    char tail[48];
    int tail_bytes = nth ? snprintf(tail, sizeof tail, ".%ld-%d.tmp", pid, nth)
                         : snprintf(tail, sizeof tail, ".%ld.tmp", pid);
    int name_bytes = NAME_BYTES - 1 - tail_bytes;
    if (strlen(base) < (size_t) name_bytes)
        name_bytes = (int) strlen(base);
    size_t size = (size_t) (base - path) + NAME_BYTES + 1;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s.%.*s%s", (int) (base - path), path,
                 name_bytes, base, tail);
    return name;
}

int gp_temp_make(struct gp_temp *temp, const char *target, mode_t mode)
{
    const int flags = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
    int fd = -1, error = EEXIST;
    sigset_t before;
    begin_naming(&before);
    for (int nth = 0; fd < 0 && error == EEXIST && nth < TRIES; nth++) {
        char *name = gp_file_temp_name(target, nth);
        fd = name ? open(name, flags, mode) : -1;
        error = name ? errno : ENOMEM;
        if (fd >= 0)
            *temp = (struct gp_temp) {name, live_add(name)};
        else
            gp_free(name);
    }
    end_naming(&before);
    errno = error;
    return fd;
}

int gp_temp_end(struct gp_temp *temp, const char *target)
{
    if (!temp->name)
        return 0;
    sigset_t before;
    begin_naming(&before);
    const int result = target ? rename(temp->name, target)
                              : unlink(temp->name);
    const int error = errno;
    if (!target || result == 0) {
        live_drop(temp->live);
        GP_FREE(temp->name);
    }
    end_naming(&before);
    errno = error;
    return result;
}
