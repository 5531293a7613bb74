// SPDX-License-Identifier: Apache-2.0
#include "harness.h"

#include "core/parallel.h"

#include <fcntl.h>
#include <sanitizer/asan_interface.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

/* Of sanitizer/allocator_interface.h, which gcc leaves out of its headers. */
int __sanitizer_install_malloc_and_free_hooks(
    void (*on_malloc)(const volatile void *, size_t),
    void (*on_free)(const volatile void *));
size_t __sanitizer_get_allocated_size(const volatile void *p);

/* -- the target --------------------------------------------------------------- */

static const struct fuzz_target *target;

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void) argc;
    const char *const path = (*argv)[0], *const slash = strrchr(path, '/');
    const char *const name = slash ? slash + 1 : path;
    for (target = fuzz_targets; target->name; target++) {
        if (strcmp(target->name, name) == 0)
            return 0;
    }
    fprintf(stderr, "%s: no fuzz target of that name\n", name);
    exit(1);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    return target->run(data, size);
}

/* -- lines of a call -------------------------------------------------------- */

static int errors;
static char last[4200];
static bool hinted; // the program adds what to do, by the parameter

static void sink(void *user, const struct gp_line *line)
{
    (void) user;
    if (line->level != GP_LEVEL_ERROR && line->level != GP_LEVEL_BARE)
        return;
    errors++;
    hinted = line->parameter[0] != '\0';
    snprintf(last, sizeof last, "%s", line->text);
}

const struct gp_log fuzz_log = {sink, NULL, GP_LEVEL_INFO};

static void broken(const char *promise, long long value)
{
    fprintf(stderr, "broken promise: %s (%lld); last line: %s\n", promise,
            value, last);
    abort();
}

gp_status fuzz_line(gp_status st)
{
    if (errors != (st != GP_OK))
        broken("one line for an error, none for success", errors);
    if (st == GP_ERR_BUG)
        broken("a file is no bug of the program", st);
    // a line that was cut at its limit has lost its end
    if (st && strlen(last) < 4095 && !hinted && !strstr(last, "; "))
        broken("what is wrong; what to do", st);
    errors = 0;
    last[0] = '\0';
    return st;
}

/* -- the heap ----------------------------------------------------------------- */

static int64_t now, peak;  // bytes; other threads of the run allocate too

static void on_malloc(const volatile void *p, size_t size)
{
    (void) p;
    const int64_t sum =
        __atomic_add_fetch(&now, (int64_t) size, __ATOMIC_RELAXED);
    int64_t old = __atomic_load_n(&peak, __ATOMIC_RELAXED);
    while (sum > old && !__atomic_compare_exchange_n(
                            &peak, &old, sum, true, __ATOMIC_RELAXED,
                            __ATOMIC_RELAXED))
        ;
}

static void on_free(const volatile void *p)
{
    if (p)
        __atomic_sub_fetch(
            &now, (int64_t) __sanitizer_get_allocated_size(p),
            __ATOMIC_RELAXED);
}

/* Seconds of the processor: a busy machine makes no input slow. */
static double cpu_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double) t.tv_sec + 1e-9 * (double) t.tv_nsec;
}

static double began;

void fuzz_begin(void)
{
    static bool started;
    if (!started && !__sanitizer_install_malloc_and_free_hooks(on_malloc,
                                                               on_free))
        broken("the sanitizer takes hooks", 0);
    if (!started)
        gp_set_threads(1);
    started = true;
    errors = 0;
    last[0] = '\0';
    now = peak = 0;
    began = cpu_seconds();
}

void fuzz_end(uint64_t allowed)
{
    const double took = cpu_seconds() - began;
    if (took > FUZZ_SECONDS)
        broken("an input takes 2 s at most", (long long) took);
    if (peak > 0 && (uint64_t) peak > allowed)
        broken("memory is bounded by what the header claims", peak);
}

static int64_t le32(const uint8_t *p)
{
    return (int32_t) ((uint32_t) p[0] | (uint32_t) p[1] << 8 |
                      (uint32_t) p[2] << 16 | (uint32_t) p[3] << 24);
}

uint64_t fuzz_allowed(const uint8_t *data, size_t size)
{
    static const char box[] = "dataWindow\0box2i\0\x10\0\0"; // and its last 0
    static const char list[] = "channels\0chlist";
    enum { ENTRY = 18 }; // bytes of the shortest channel
    uint64_t pixels = 0, channels = 0;
    const uint8_t *const end = data + size, *p = data;
    while ((p = memmem(p, (size_t) (end - p), box, sizeof box))) {
        p += sizeof box;
        if (end - p < 16)
            break;
        const int64_t w = le32(p + 8) - le32(p) + 1;
        const int64_t h = le32(p + 12) - le32(p + 4) + 1;
        if (w > 0 && h > 0 && w <= FUZZ_PIXELS / h &&
            (uint64_t) (w * h) > pixels)
            pixels = (uint64_t) (w * h);
    }
    for (p = data; (p = memmem(p, (size_t) (end - p), list, sizeof list));) {
        p += sizeof list;
        if (end - p < 4)
            break;
        const int64_t n = le32(p);
        if (n > 0 && n <= end - p && (uint64_t) n / ENTRY > channels)
            channels = (uint64_t) n / ENTRY;
    }
    return FUZZ_FIXED + pixels * (32 * sizeof(float) + 8 * channels);
}

/* -- the input ---------------------------------------------------------------- */

static int file = -1, reader = -1;

const char *fuzz_file(const uint8_t *data, size_t size)
{
    static char name[64];
    fuzz_file_close();
    file = memfd_create("input", MFD_CLOEXEC);
    if (file < 0 || write(file, data, size) != (ssize_t) size)
        return NULL;
    snprintf(name, sizeof name, "/proc/self/fd/%d", file);
    return name;
}

void fuzz_file_close(void)
{
    if (file >= 0)
        close(file);
    file = -1;
}

const char *fuzz_pipe(const uint8_t *data, size_t size)
{
    static char name[64];
    enum { ROOM = 1 << 18 };
    int fd[2];
    fuzz_pipe_close();
    if (size > ROOM || pipe(fd))
        return NULL;
    reader = fd[0];
    const bool fits = fcntl(fd[1], F_SETPIPE_SZ, ROOM) >= (int) size &&
                      write(fd[1], data, size) == (ssize_t) size;
    close(fd[1]);
    snprintf(name, sizeof name, "/proc/self/fd/%d", reader);
    return fits ? name : NULL;
}

void fuzz_pipe_close(void)
{
    if (reader >= 0)
        close(reader);
    reader = -1;
}

void fuzz_touch(const void *p, size_t bytes)
{
    if (bytes && __asan_region_is_poisoned((void *) (uintptr_t) p, bytes))
        broken("what is given out can be read", (long long) bytes);
}
