#include "io/exr/exr_priv.h"

#include "io/colour_name.h"

#include <string.h>

static bool is_dwa_colour(const char *name)
{
    static const char *const own[] = {"R", "G", "B", "Y", "RY", "BY"};
    const char *last = name + gp_layer_length(name);
    for (size_t i = 0; i < sizeof own / sizeof *own; i++) {
        if (strcmp(last, own[i]) == 0)
            return true;
    }
    return false;
}

bool gp_exr_loses(enum gp_compression compression, enum gp_pixel_type type,
                  const char *name)
{
    switch (compression) {
    case GP_COMPRESSION_PXR24:
        return type == GP_FLOAT;
    case GP_COMPRESSION_B44:
    case GP_COMPRESSION_B44A:
        return type == GP_HALF;
    case GP_COMPRESSION_DWAA:
    case GP_COMPRESSION_DWAB:
        return type != GP_UINT && is_dwa_colour(name);
    default:
        return false;
    }
}
