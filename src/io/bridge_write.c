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

/* Fields for a name that OpenImageIO fills with other bytes in each run. SGI's it
 * leaves as its memory was, addresses and all ("The SGI Image File Format",
 * 1.00); DPX's gets the number of a descriptor (SMPTE 268M, section 7.1). */
static const struct name_field {
    unsigned char magic[4];
    size_t magics; // bytes of magic
    off_t at;
    size_t size;
} name_fields[] = {
    {{0x01, 0xda}, 2, 24, 80},
    {"SDPX", 4, 36, 100},
    {"XPDS", 4, 36, 100},
};

static gp_status clear_name(const struct gp_log *log, const char *path, int fd)
{
    static const char none[100] = {0};
    unsigned char magic[4] = {0};
    if (pread(fd, magic, sizeof magic, 0) != (ssize_t) sizeof magic)
        return GP_OK;
    for (size_t i = 0; i < sizeof name_fields / sizeof *name_fields; i++) {
        const struct name_field *const f = &name_fields[i];
        if (memcmp(magic, f->magic, f->magics) != 0)
            continue;
        if (pwrite(fd, none, f->size, f->at) != (ssize_t) f->size)
            return gp_fail(log, GP_ERR_IO, "%s: the file in memory cannot be "
                           "written (%s); write .exr or .png", path,
                           strerror(errno));
    }
    return GP_OK;
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
    const int got =
        api->write(name, format, img, type, compression, why, sizeof why);
    if (got == GP_OIIO_MEMORY)
        GP_TRY(gp_oiio_no_memory(log, path, why));
    if (got)
        GP_TRY(gp_fail(log, GP_ERR_IO,
                       "%s: OpenImageIO cannot write it (%s); write another "
                       "format", path, why));
    if (fstat(out->fd, &s) || s.st_size <= 0)
        GP_TRY(gp_fail(log, GP_ERR_IO, "%s: OpenImageIO wrote nothing; write "
                       "another format", path));
    GP_TRY(clear_name(log, path, out->fd));
    out->size = (uint64_t) s.st_size;
    return GP_OK;
out:
    gp_stream_close(out);
    return st;
}
