/* OpenImageIO by its bridge, for tests of the bridge itself. */
#ifndef OIIO_HERE_H
#define OIIO_HERE_H

#include "io/oiio/oiio.h"

#include "bridge_here.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

/* NULL where there is no OpenImageIO, and then why; after open_oiio(). */
static const struct gp_oiio_api *api;
static char why[512];

static inline int open_oiio(void **state)
{
    if (find_bridges(state))
        return -1;
    api = gp_oiio_open(why, sizeof why);
    return 0;
}

/* From memory: what the bridge says goes to `why`. */
static inline int read_bytes(const void *bytes, size_t n, long long max_pixels,
                             struct gp_oiio_image *out)
{
    memset(why, 'x', sizeof why);
    *out = (struct gp_oiio_image) {0};
    return api->read("-", bytes, n, 0, max_pixels, out, why, sizeof why);
}

static inline void refused(const char *name, const void *bytes, size_t n,
                           const char *said)
{
    struct gp_oiio_image image;
    if (read_bytes(bytes, n, 1 << 20, &image) != -1 || image.own)
        fail_msg("%s was read", name);
    if (!strstr(why, said))
        fail_msg("%s: \"%s\" is not in: %s", name, said, why);
}

#endif
