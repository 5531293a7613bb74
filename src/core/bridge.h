/* Parts of this program that are files of their own, as their C++ libraries
 * cost too much at every start: glarepp-ocio.so, opened when first needed, and
 * the helper program glarepp-oiio. */
#ifndef GP_CORE_BRIDGE_H
#define GP_CORE_BRIDGE_H

#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>

/* Finds a file of this program: in $GLAREPP_BRIDGES, beside the program, in
 * ../lib/glarepp from there, or in the installed folder; the first that exists.
 * False: none does. */
bool gp_bridge_find(const char *name, char *path, size_t size);

/* Opens the shared object of that file name, for good, and returns what its
 * function `entry` returns: what it offers. NULL, with one line in `why`, when
 * it or one of its libraries is missing, or it is of another version. */
const void *gp_bridge_open(const char *name, const char *entry, char *why,
                           size_t why_size);

/* Memory that another process is given by its descriptor. Zero is empty. */
struct gp_shared {
    int fd;
    void *at;
    size_t size;
};

/* Makes zeroed memory of `size` >= 1 bytes, which nobody can make smaller.
 * `path` is for the message. Errors: GP_ERR_BUG out of memory; GP_ERR_IO no
 * descriptor, or more bytes than a file may have (ulimit -f). */
GP_MUST_CHECK gp_status gp_shared_make(const struct gp_log *log,
    const char *path, size_t size, struct gp_shared *out);
/* The line and the status for `size` bytes that errno says cannot be shared. */
gp_status gp_shared_failed(const struct gp_log *log, const char *path,
                           size_t size);
void gp_shared_free(struct gp_shared *shared);

#endif
