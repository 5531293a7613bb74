/* Opening the bridge. */
#include "io/oiio/oiio.h"

#include "core/bridge.h"
#include "core/parallel.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { MOST_PROBED = 64 };

static const char bridge[] = "glarepp-oiio.so";

/* OpenImageIO starts a thread for each processor, OpenEXR's library below it
 * too; they end the process when they cannot. Our own may yet come. */
static bool has_threads(char *why, size_t why_size)
{
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    const int each = processors < 1 ? 1
                     : processors > MOST_PROBED ? MOST_PROBED
                                                : (int) processors;
    const int wanted = 2 * each + gp_threads();
    const bool has = gp_threads_spare(wanted) == wanted;
    if (!has)
        snprintf(why, why_size, "the system starts no more threads; raise "
                 "ulimit -u");
    return has;
}

static const struct gp_oiio_api *load(char *why, size_t why_size)
{
    if (!has_threads(why, why_size))
        return NULL;
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

gp_status gp_oiio_no_memory(const struct gp_log *log, const char *path,
                            const char *why)
{
    return gp_fail(log, GP_ERR_BUG,
                   "%s: out of memory (%s); close other programs", path, why);
}
