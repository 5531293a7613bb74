#include "core/bridge.h"

#include <dlfcn.h>
#include <limits.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// -- no memory where nothing can catch it ---------------------------------------

static void (*end_for_memory)(const char *line); // NULL: as C++ does
static void (*end_for_others)(void);             // C++'s own
static void *(*type_of_exception)(void);
static _Thread_local const char *about;
static _Thread_local bool loading;

void gp_bridge_on_no_memory(void (*end)(const char *line))
{
    end_for_memory = end;
}

void gp_bridge_about(const char *file)
{
    about = file;
}

/* Itanium C++ ABI, 2.9.4: a std::type_info is a pointer to its functions, then
 * one to its name; 5.1: "St" is std::, names have their length before them. */
static bool is_bad_alloc(void)
{
    static const char name[] = "St9bad_alloc";
    const char *const *const type = type_of_exception ? type_of_exception()
                                                      : NULL;
    return type && strcmp(type[1], name) == 0;
}

static void at_terminate(void)
{
    char line[PATH_MAX + 128];
    if (!is_bad_alloc()) {
        end_for_others();
        abort(); // it does not come back
    }
    snprintf(line, sizeof line, "%s: out of memory (%s); close other programs",
             about ? about : "bridge",
             loading ? "while a bridge and its libraries are loaded"
                     : "in a bridge or its libraries");
    end_for_memory(line);
    abort();
}

/* dlsym() as a function's address, which ISO C has no cast to. */
static bool find_function(void *library, const char *name, void *to)
{
    void *const symbol = dlsym(library, name);
    memcpy(to, &symbol, sizeof symbol);
    return symbol;
}

/* Every bridge brings the C++ library that is loaded here. Where that is
 * another one, or has no such function, nothing changes. */
static void watch_memory(void)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    static bool watches;
    void (*(*set_terminate)(void (*)(void)))(void);
    pthread_mutex_lock(&lock);
    void *const cxx = watches || !end_for_memory
                          ? NULL : dlopen("libstdc++.so.6", RTLD_NOW);
    if (cxx && find_function(cxx, "__cxa_current_exception_type",
                             &type_of_exception) &&
        find_function(cxx, "_ZSt13set_terminatePFvvE", &set_terminate)) {
        end_for_others = set_terminate(at_terminate);
        watches = true;
    }
    pthread_mutex_unlock(&lock);
}

// -- opening ----------------------------------------------------------------------

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

bool gp_bridge_find(const char *name, char *path, size_t size)
{
    char program[PATH_MAX];
    program_folder(program, sizeof program);
    const char *const place[][2] = {
        {getenv("GLAREPP_BRIDGES"), ""},
        {program, ""},
        {program, "/../lib/glarepp"},
        {GP_BRIDGE_DIR, ""},
    };
    for (size_t i = 0; i < sizeof place / sizeof *place; i++) {
        const char *const folder = place[i][0];
        if (!folder || !folder[0])
            continue;
        const int n = snprintf(path, size, "%s%s/%s", folder, place[i][1],
                               name);
        if ((size_t) n < size && access(path, F_OK) == 0)
            return true;
    }
    return false;
}

void *gp_bridge_open(const char *name, char *why, size_t why_size)
{
    char path[PATH_MAX];
    if (!gp_bridge_find(name, path, sizeof path)) {
        snprintf(why, why_size, "%s is not there", name);
        return NULL;
    }
    watch_memory();
    loading = true;
    void *const library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    loading = false;
    if (!library)
        snprintf(why, why_size, "%s", dlerror());
    return library;
}
