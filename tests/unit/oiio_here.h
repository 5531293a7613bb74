/* OpenImageIO by its bridge, for tests of the bridge itself. */
#ifndef OIIO_HERE_H
#define OIIO_HERE_H

#include "io/oiio.h"

#include "bridge_here.h"

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

#endif
