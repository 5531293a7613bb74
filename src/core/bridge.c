#include "core/bridge.h"

#include <dlfcn.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The folder of the running program, "" when the system does not say. */
static void program_folder(char *to, size_t size)
{
    ssize_t n = readlink("/proc/self/exe", to, size - 1);
    to[n > 0 ? n : 0] = '\0';
    char *slash = strrchr(to, '/');
    if (slash)
        *slash = '\0';
    else
        to[0] = '\0';
}

/* Opens FOLDER/SUB/name when it is there; `why` says what went wrong with
 * one that is. */
static void *try_folder(const char *folder, const char *sub, const char *name,
                        char *why, size_t why_size)
{
    char path[PATH_MAX];
    if (!folder || !folder[0])
        return NULL;
    const int n = snprintf(path, sizeof path, "%s%s/%s", folder, sub, name);
    if ((size_t) n >= sizeof path || access(path, F_OK) != 0)
        return NULL;
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        snprintf(why, why_size, "%s", dlerror());
    return library;
}

void *gp_bridge_open(const char *name, char *why, size_t why_size)
{
    char program[PATH_MAX];
    program_folder(program, sizeof program);
    const char *const place[][2] = {
        {getenv("GLAREPP_BRIDGES"), ""},
        {program, ""},
        {program, "/../lib/glarepp"},
        {GP_BRIDGE_DIR, ""},
    };
    snprintf(why, why_size, "%s is not there", name);
    for (size_t i = 0; i < sizeof place / sizeof *place; i++) {
        void *library = try_folder(place[i][0], place[i][1], name, why,
                                   why_size);
        if (library)
            return library;
    }
    return NULL;
}
