#include "io/bridge_write.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { WHY_BYTES = 512 };

static gp_status open_bridge(const struct gp_log *log, const char *path,
                             const struct gp_oiio_api **out)
{
    char why[WHY_BYTES] = "";
    *out = gp_oiio_open(why, sizeof why);
    if (!*out)
        return gp_fail(log, GP_ERR_IO,
                       "%s: cannot be written without the OpenImageIO bridge "
                       "(%s); install it, or write .exr or .png", path, why);
    return GP_OK;
}

gp_status gp_bridge_can_write(const struct gp_log *log, const char *path,
                              const char *format, bool *can)
{
    const struct gp_oiio_api *api;
    gp_status st = open_bridge(log, path, &api);
    if (!st)
        *can = api->can_write(format);
    return st;
}

gp_status gp_bridge_write(const struct gp_log *log, const char *path,
                          const char *format, const struct gp_oiio_image *img,
                          const char *type, const char *compression,
                          struct gp_stream *out)
{
    const struct gp_oiio_api *api;
    char name[64], why[WHY_BYTES] = "";
    struct stat s;
    gp_status st;
    *out = (struct gp_stream) GP_STREAM_EMPTY;
    GP_TRY(open_bridge(log, path, &api));
    out->fd = memfd_create("glarepp", MFD_CLOEXEC);
    if (out->fd < 0)
        GP_TRY(gp_fail(log, GP_ERR_IO, "%s: no file in memory (%s); write "
                       ".exr or .png", path, strerror(errno)));
    snprintf(name, sizeof name, "/proc/self/fd/%d", out->fd);
    if (api->write(name, format, img, type, compression, why, sizeof why))
        GP_TRY(gp_fail(log, GP_ERR_IO,
                       "%s: OpenImageIO cannot write it (%s); write another "
                       "format", path, why));
    if (fstat(out->fd, &s) || s.st_size <= 0)
        GP_TRY(gp_fail(log, GP_ERR_IO, "%s: OpenImageIO wrote nothing; write "
                       "another format", path));
    out->size = (uint64_t) s.st_size;
    return GP_OK;
out:
    gp_stream_close(out);
    return st;
}
