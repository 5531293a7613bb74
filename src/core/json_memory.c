#include "core/json_memory.h"

#include <jansson.h>
#include <pthread.h>
#include <stdlib.h>

static _Thread_local bool full;

void *gp_json_allocate(size_t size)
{
    void *const p = malloc(size);
    full = full || !p;
    return p;
}

static void set(void)
{
    json_set_alloc_funcs(gp_json_allocate, free);
}

void gp_json_memory_watch(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, set);
    full = false;
}

bool gp_json_memory_full(void)
{
    return full;
}
