#include "app/options.h"

#include "io/versions.h"

#include <jansson.h>

void gp_version(FILE *f)
{
    char io[256];
    gp_io_versions(io, sizeof io);
    fprintf(f, "glarepp " GP_VERSION "\n"
               "with %s, jansson %s\n"
               "opened when needed: FFTW 3, OpenImageIO, OpenColorIO, OSMesa, EGL\n"
               "GPL-3.0-or-later; no warranty\n", io, jansson_version_str());
}
