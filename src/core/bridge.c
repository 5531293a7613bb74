// SPDX-License-Identifier: Apache-2.0
#include "core/bridge.h"

#include "core/parallel.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* The folder of the library or program that has this code; "": unknown. */
static void find_home(char folder[PATH_MAX])
{
    static const char here;
    Dl_info info;
    struct link_map *map = NULL; // a program's has no name
    folder[0] = '\0';
    if (dladdr1(&here, &info, (void **) &map, RTLD_DL_LINKMAP) && map->l_name[0])
        (void) !realpath(map->l_name, folder);
    if (!folder[0]) {
        const ssize_t at = readlink("/proc/self/exe", folder, PATH_MAX - 1);
        folder[at > 0 ? at : 0] = '\0';
    }
    char *const slash = strrchr(folder, '/');
    *(slash ? slash : folder) = '\0';
}

/* Finds the first of n places, each two parts of a folder, that has `name`. */
static bool find_in(const char *const (*place)[2], size_t n, const char *name,
                    char *path, size_t size)
{
    for (size_t i = 0; i < n; i++) {
        const char *const folder = place[i][0];
        if (!folder || !folder[0])
            continue;
        const int bytes = snprintf(path, size, "%s%s/%s", folder, place[i][1],
                                   name);
        if ((size_t) bytes < size && access(path, F_OK) == 0)
            return true;
    }
    return false;
}

bool gp_bridge_find(const char *name, char *path, size_t size)
{
    char home[PATH_MAX];
    find_home(home);
    const char *const place[][2] = {
        {gp_env()->bridges, ""}, {home, ""}, {home, "/../lib/glarepp"},
        {home, "/../glarepp"}, // of lib/x86_64-linux-gnu
        {GP_BRIDGE_DIR, ""},
    };
    return find_in(place, sizeof place / sizeof *place, name, path, size);
}

bool gp_example_find(const char *name, char *path, size_t size)
{
    char home[PATH_MAX];
    find_home(home);
    const char *const place[][2] = {
        {gp_env()->data, ""}, {home, "/../share/doc/glarepp/examples"},
        {home, "/../examples"}, {home, "/../../examples"},
        {home, "/../../share/doc/glarepp/examples"},
        {GP_BRIDGE_DIR, "/../../share/doc/glarepp/examples"},
    };
    return find_in(place, sizeof place / sizeof *place, name, path, size);
}

const void *gp_bridge_open(const char *name, const char *entry, int version,
                           char *why, size_t why_size)
{
    char path[PATH_MAX];
    const void *(*function)(void) = NULL;
    if (!gp_bridge_find(name, path, sizeof path)) {
        snprintf(why, why_size, "%s not found", name);
        return NULL;
    }
    void *const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        snprintf(why, why_size, "%s", dlerror());
        return NULL;
    }
    void *const symbol = dlsym(library, entry);
    // ISO C has no cast from an object to a function pointer
    memcpy(&function, &symbol, sizeof function);
    const int *const api = function ? function() : NULL;
    if (api && *api == version)
        return api;
    snprintf(why, why_size, "%s has another version", name);
    dlclose(library);
    return NULL;
}

/* Prints the line for bytes that cannot be shared, by errno. */
static gp_status shared_failed(const struct gp_log *log, const char *path,
                               size_t size)
{
    if (errno == ENOMEM)
        return gp_no_memory(log, path);
    return gp_fail(log, GP_ERR_IO, "%s: %zu bytes cannot be shared with a "
        "helper (%s); raise ulimit -f or -n", path, size, strerror(errno));
}

gp_status gp_shared_make(const struct gp_log *log, const char *path,
                         size_t size, struct gp_shared *out)
{
    struct gp_shared s = {.size = size};
    s.fd = memfd_create("glarepp", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    // sealed: a truncation by the helper would end this process by SIGBUS
    const bool sized =
        s.fd >= 0 && ftruncate(s.fd, (off_t) size) == 0 &&
        fcntl(s.fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) ==
            0;
    s.at = sized ? mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, s.fd, 0)
                 : MAP_FAILED;
    if (s.at != MAP_FAILED) {
        *out = s;
        return GP_OK;
    }
    const gp_status st = shared_failed(log, path, size);
    if (s.fd >= 0)
        close(s.fd);
    return st;
}

void gp_shared_free(struct gp_shared *shared)
{
    if (shared->at) {
        munmap(shared->at, shared->size);
        close(shared->fd);
    }
    *shared = (struct gp_shared) {0};
}
