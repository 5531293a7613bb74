/* What EXR's lossy compressions do to channels that are not colour.
 *
 *   PXR24      32-bit floats lose the low 8 bits of their mantissa; half and
 *              uint keep all bits
 *   B44, B44A  half loses (blocks of 4x4 to 6 bits); float and uint keep all
 *   DWAA/B     what is called R, G, B, Y, RY or BY behind its last dot loses,
 *              of any layer and in half and float, and becomes half; all else
 *              keeps its bits, depth too
 *
 * Sources: OpenEXR 3.1.5, ImfPxr24Compressor.cpp, ImfB44Compressor.cpp,
 * DwaCompressor::initializeDefaultChannelRules() of ImfDwaCompressor.cpp.
 */
#ifndef GP_IO_EXR_LOSSY_H
#define GP_IO_EXR_LOSSY_H

#include "core/frame.h"
#include "io/write.h"

#include <stdbool.h>

/* True when samples of that channel may come back with other bits; of AUTO,
 * never. */
bool gp_exr_loses(enum gp_compression compression, enum gp_pixel_type type,
                  const char *name);

#endif
