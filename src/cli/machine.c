// SPDX-License-Identifier: Apache-2.0
#include "cli/machine.h"

#include <limits.h>
#include <malloc.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

enum { NAME = 4096 + 256 }; // bytes of a path

/* Returns the least limit of a group and its parents: of files with a number, none
 * where there is no file, the number is larger (v1 writes a huge one for no limit),
 * or is "max". In a container the path may be the host's, of which only the mounted
 * folder exists. */
static size_t least_upwards(const char *mount, const char *group,
                            const char *file, size_t most)
{
    char path[NAME];
    for (int length = (int) strlen(group); length >= 0; length--) {
        if (length && group[length] && group[length] != '/')
            continue;
        const int n = snprintf(path, sizeof path, "%s%.*s/%s", mount, length,
                               group, file);
        char line[64] = "";
        FILE *const f =
            n > 0 && (size_t) n < sizeof path ? fopen(path, "re") : NULL;
        const char *const number = f ? fgets(line, sizeof line, f) : NULL;
        const unsigned long long v = number ? strtoull(line, NULL, 10) : 0;
        most = v > 0 && v < most ? (size_t) v : most;
        if (f)
            fclose(f);
    }
    return most;
}

/* Returns the least limit of this process's control groups, at most `most`. */
static size_t group_limit(const char *root, size_t most)
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
        char *const list = strchr(line, ':');
        char *const group = list ? strchr(list + 1, ':') : NULL;
        if (!group)
            continue;
        *group = '\0';
        const bool v1 = strstr(list, "memory") != NULL;
        snprintf(mount, sizeof mount, "%s/sys/fs/cgroup%s", root,
                 v1 ? "/memory" : "");
        if (v1 || !list[1])
            most = least_upwards(mount, group + 1, v1 ? "memory.limit_in_bytes"
                                                      : "memory.max", most);
    }
    free(line);
    fclose(f);
    return most;
}

size_t gp_memory_limit(const char *root)
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    const bool known = pages > 0 && page > 0;
    const size_t machine = known ? (size_t) pages * (size_t) page : SIZE_MAX;
    struct rlimit own; // ulimit -v, as Grid Engine and LSF set it
    size_t most = group_limit(root, machine);
    if (getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY &&
        own.rlim_cur < most)
        most = (size_t) own.rlim_cur;
    return most == SIZE_MAX ? 0 : most;
}

size_t gp_peak_memory(void)
{
    char line[128];
    unsigned long long kib = 0;
    FILE *const f = fopen("/proc/self/status", "re");
    while (f && kib == 0 && fgets(line, sizeof line, f)) {
        if (strncmp(line, "VmHWM:", 6) == 0)
            kib = strtoull(line + 6, NULL, 10);
    }
    if (f)
        fclose(f);
    return (size_t) kib << 10;
}

// -- the environment ---------------------------------------------------------

/* Returns a variable; NULL where it is empty or not set. */
static const char *variable(const char *name)
{
    const char *const v = getenv(name);
    return v && *v ? v : NULL;
}

void gp_environment_read(struct glarepp_params *p)
{
    const char *const size = variable("GLAREPP_GL_MAX_SIZE");
    const long side = size ? strtol(size, NULL, 10) : 0;
    p->bridges = variable("GLAREPP_BRIDGES");
    p->data = variable("GLAREPP_EXAMPLES");
    p->osmesa = variable("GLAREPP_OSMESA");
    p->egl = variable("GLAREPP_EGL");
    p->gl_size = side > 0 && side < INT_MAX ? (int) side : 0;
}

void gp_environment_set_heap(void)
{
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 256 << 10); // larger blocks are mapped
    mallopt(M_TRIM_THRESHOLD, 1 << 30);   // free bytes that the heap keeps
    mallopt(M_ARENA_MAX, 1); // a heap for each thread would grow by what other
                             // threads take from it and free
#endif
}

void gp_environment_set_gl(int threads)
{
    char text[16];
    snprintf(text, sizeof text, "%d", threads);
    setenv("LP_NUM_THREADS", text, 0);
    setenv("EGL_LOG_LEVEL", "fatal", 0);
}
