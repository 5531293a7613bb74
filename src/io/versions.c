#include "io/versions.h"

#include <libdeflate.h>
#include <openexr.h>
#include <png.h>
#include <stdio.h>

void gp_io_versions(char *line, size_t size)
{
    int major, minor, patch;
    const char *extra;
    exr_get_library_version(&major, &minor, &patch, &extra);
    snprintf(line, size, "OpenEXRCore %d.%d.%d%s, libpng %s, libdeflate %s",
             major, minor, patch, extra ? extra : "",
             png_get_libpng_ver(NULL), LIBDEFLATE_VERSION_STRING);
}
