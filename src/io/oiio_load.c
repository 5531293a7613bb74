/* Opening the bridge. */
#include "io/oiio.h"

#include "core/bridge.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

static const char bridge[] = "glarepp-oiio.so";

static const struct gp_oiio_api *load(char *why, size_t why_size)
{
    void *library = gp_bridge_open(bridge, why, why_size);
    if (!library)
        return NULL;
    void *symbol = dlsym(library, "gp_oiio_api");
    const struct gp_oiio_api *(*entry)(void) = NULL;
    // ISO C has no cast from an object to a function pointer
    memcpy(&entry, &symbol, sizeof entry);
    const struct gp_oiio_api *api = entry ? entry() : NULL;
    if (!api || api->version != GP_OIIO_API_VERSION) {
        snprintf(why, why_size, "%s is of another version", bridge);
        dlclose(library);
        return NULL;
    }
    return api;
}

const struct gp_oiio_api *gp_oiio_open(char *why, size_t why_size)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    static const struct gp_oiio_api *opened; // stays open until the end
    pthread_mutex_lock(&lock);
    if (!opened)
        opened = load(why, why_size);
    const struct gp_oiio_api *const api = opened;
    pthread_mutex_unlock(&lock);
    return api;
}
