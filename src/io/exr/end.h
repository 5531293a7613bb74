/* Where an EXR ends: inside a longer stream, or behind the end of one. */
#ifndef GP_IO_EXR_END_H
#define GP_IO_EXR_END_H

#include "io/exr/origin.h"

#include <stdint.h>

/* Bytes from the magic number to the end of the chunk that stands last, by the
 * offset tables of all parts (OpenEXR file layout, "Chunk Offset Table"): more
 * than the stream has where it is cut off. 0 when they do not tell: a file
 * that was not finished, or is damaged. */
uint64_t gp_exr_end(const struct gp_origin *o);

#endif
