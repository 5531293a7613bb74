#include "core/core_priv.h"
#include "core/memory.h"

#include <errno.h>
#include <malloc.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* Sanitizers must see what is freed: all blocks are the C library's then. */
#ifndef __has_feature
#define __has_feature(x) 0 // clang's; gcc has names for them
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) ||          \
    __has_feature(address_sanitizer)
enum { ARENA = false };
#else
enum { ARENA = true };
#endif

enum { ARENA_LEAST = 64 << 10 }; // bytes of a block of the arena

static bool arena_on; // set before there are threads

// -- allocation --------------------------------------------------------------

static gp_status no_memory(const struct gp_log *log, const char *what,
                           size_t bytes)
{
    return gp_fail_bare(log, GP_ERR_BUG, "%s: out of memory (%zu byte%s); use "
                        "a smaller frame or a machine with more memory", what,
                        bytes, bytes == 1 ? "" : "s");
}

gp_status gp_alloc(const struct gp_log *log, const char *what, size_t count,
                   size_t size, void *out)
{
    void *block = NULL;
    memcpy(out, &block, sizeof block); // of whatever type it points to
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) ||
        bytes > SIZE_MAX / 2)
        return gp_fail_bare(log, GP_ERR_BUG, "%s: size overflows (%zu x %zu "
            "bytes); use a smaller frame", what, count, size);
    bytes += !bytes; // never none: NULL is only for failure
    if (arena_on && bytes >= ARENA_LEAST)
        block = gp_arena_take(bytes);
    if (!block && posix_memalign(&block, GP_ALIGN, bytes) != 0)
        return no_memory(log, what, bytes);
    memcpy(out, &block, sizeof block);
    return GP_OK;
}

void gp_free(void *p)
{
    if (arena_on && gp_arena_has(p))
        gp_arena_give(p);
    else
        free(p);
}

gp_status gp_resize(const struct gp_log *log, const char *what, size_t bytes,
                    void **block)
{
    void *const moved = realloc(*block, bytes);
    if (!moved)
        return no_memory(log, what, bytes);
    *block = moved;
    return GP_OK;
}

gp_status gp_alloc_zero(const struct gp_log *log, const char *what,
                        size_t count, size_t size, void *out)
{
    void *block;
    const gp_status st = gp_alloc(log, what, count, size, &block);
    if (!st)
        memset(block, 0, count * size);
    memcpy(out, &block, sizeof block);
    return st;
}

void gp_keep_memory(void)
{
    arena_on = ARENA;
    static const int apart = 256 << 10; // mapped by itself
    static const int ends = 1 << 30; // free bytes that the heap keeps
    static const int heaps = 1; // a heap for each thread would grow by what
                                // other threads take from it and free
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, apart);
    mallopt(M_TRIM_THRESHOLD, ends);
    mallopt(M_ARENA_MAX, heaps);
#else
    (void) apart;
    (void) ends;
    (void) heaps;
#endif
}

unsigned long gp_serial_next(void)
{
    static atomic_ulong last;
    return atomic_fetch_add_explicit(&last, 1, memory_order_relaxed) + 1;
}

char *gp_strdup(const char *s)
{
    size_t n = strlen(s) + 1;
    char *copy = malloc(n);
    if (copy)
        memcpy(copy, s, n);
    return copy;
}

// -- the memory that this process may use -------------------------------------

enum { NAME = 4096 + 256 }; // bytes of a path

/* Returns the number in a file; `most` when there is no file, it is larger (v1
 * writes a huge one for no limit), or is "max". */
static size_t limit_of(const char *path, size_t most)
{
    char line[64] = "";
    char *end = line;
    FILE *const f = fopen(path, "re");
    if (!f)
        return most;
    const bool read = fgets(line, sizeof line, f) != NULL;
    fclose(f);
    errno = 0;
    const unsigned long long v = strtoull(line, &end, 10);
    return read && end != line && !errno && v > 0 && v < most ? (size_t) v
                                                              : most;
}

/* Returns the least limit of a group and its parents. In a container the path
 * may be the host's, of which only the mounted folder exists. */
static size_t least_upwards(const char *mount, const char *group,
                            const char *file, size_t most)
{
    char path[NAME];
    size_t length = strlen(group);
    for (;;) {
        const int n = snprintf(path, sizeof path, "%s%.*s/%s", mount,
                               (int) length, group, file);
        if (n > 0 && (size_t) n < sizeof path)
            most = limit_of(path, most);
        if (length == 0)
            return most;
        do
            length--;
        while (length > 0 && group[length] != '/');
    }
}

/* True when a list with commas has that word. */
static bool lists(const char *list, size_t bytes, const char *word)
{
    const size_t n = strlen(word);
    for (size_t at = 0; at + n <= bytes; at++) {
        if ((at == 0 || list[at - 1] == ',') &&
            strncmp(list + at, word, n) == 0 &&
            (at + n == bytes || list[at + n] == ','))
            return true;
    }
    return false;
}

size_t gp_cgroup_limit(const char *root, size_t most)
{
    char path[NAME], mount[NAME];
    char *line = NULL;
    size_t room = 0;
    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    FILE *const f = fopen(path, "re");
    if (!f)
        return most;
    // "4:cpu,memory:/job/step" of v1, "0::/job/step" of v2; cgroups(7)
    while (getline(&line, &room, f) > 0) {
        line[strcspn(line, "\n")] = '\0';
        const char *const list = strchr(line, ':');
        const char *const group = list ? strchr(list + 1, ':') : NULL;
        if (!group)
            continue;
        const size_t bytes = (size_t) (group - list) - 1;
        if (lists(list + 1, bytes, "memory")) {
            snprintf(mount, sizeof mount, "%s/sys/fs/cgroup/memory", root);
            most = least_upwards(mount, group + 1, "memory.limit_in_bytes",
                                 most);
        } else if (bytes == 0) {
            snprintf(mount, sizeof mount, "%s/sys/fs/cgroup", root);
            most = least_upwards(mount, group + 1, "memory.max", most);
            // beside controllers of v1
            snprintf(mount, sizeof mount, "%s/sys/fs/cgroup/unified", root);
            most = least_upwards(mount, group + 1, "memory.max", most);
        }
    }
    free(line);
    fclose(f);
    return most;
}

size_t gp_memory_limit(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    const bool known = pages > 0 && page > 0;
    const size_t machine = known ? (size_t) pages * (size_t) page : SIZE_MAX;
    struct rlimit own; // ulimit -v, as Grid Engine and LSF set it
    size_t most = gp_cgroup_limit("", machine);
    if (getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY &&
        own.rlim_cur < most)
        most = (size_t) own.rlim_cur;
    return most == SIZE_MAX ? 0 : most;
}

size_t gp_peak_memory(void)
{
    struct rusage used;
    char line[128];
    unsigned long long kib = 0;
    FILE *const f = fopen("/proc/self/status", "re");
    while (f && kib == 0 && fgets(line, sizeof line, f)) {
        if (strncmp(line, "VmHWM:", 6) == 0)
            kib = strtoull(line + 6, NULL, 10);
    }
    if (f)
        fclose(f);
    if (kib == 0 && getrusage(RUSAGE_SELF, &used) == 0)
        kib = (unsigned long long) used.ru_maxrss; // in KiB, as proc(5)'s
    return (size_t) kib << 10;
}
