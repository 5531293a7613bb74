// SPDX-License-Identifier: Apache-2.0
/* Parts of this program in files of their own, because loading their C++
 * libraries would slow every start: glarepp-ocio.so, opened on first use, and
 * the helper program glarepp-oiio. */
#ifndef GP_CORE_BRIDGE_H
#define GP_CORE_BRIDGE_H

#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>

/* Finds a file that is installed beside this code: the first that exists in
 * gp_env()->bridges, the folder of the program or shared library that has this
 * code, ../lib/glarepp and ../glarepp from there, and the installed folder. False
 * when there is none. */
bool gp_bridge_find(const char *name, char *path, size_t size);

/* Finds an installed example, e.g. "lenses/heliar.json": the first that exists
 * in gp_env()->data, share/doc/glarepp/examples of the prefix that this code is
 * in, the examples of the source tree that it was built in, and the installed
 * folder. False when there is none. */
bool gp_example_find(const char *name, char *path, size_t size);

/* Opens the shared object of that file name, never closes it, and returns the
 * table of functions that its function `entry` returns, whose first member is an int, its
 * version. NULL, with one line in `why`, when it or one of its libraries is missing or has
 * another version. */
const void *gp_bridge_open(const char *name, const char *entry, int version,
                           char *why, size_t why_size);

/* Memory shared with another process by its descriptor. Zero is empty. */
struct gp_shared {
    int fd;
    void *at;
    size_t size;
};

/* Makes zeroed memory of `size` >= 1 bytes, sealed against resizing. `path` is
 * for the message. Errors: GP_ERR_BUG out of memory; GP_ERR_IO no descriptor,
 * or more bytes than a file may have (ulimit -f). */
GP_MUST_CHECK gp_status gp_shared_make(const struct gp_log *log,
    const char *path, size_t size, struct gp_shared *out);
void gp_shared_free(struct gp_shared *shared);

#endif
