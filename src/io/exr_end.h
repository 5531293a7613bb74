/* Where an EXR ends inside a longer stream. */
#ifndef GP_IO_EXR_END_H
#define GP_IO_EXR_END_H

#include "io/exr_origin.h"

#include <stdint.h>

/* *end: bytes from the magic number to the end of the chunk that stands last,
 * by the offset tables of all parts (OpenEXR file layout, "Chunk Offset
 * Table"). 0 when they do not tell: a file that was not finished, or is
 * damaged. Errors: GP_ERR_BUG out of memory; no line is printed. */
GP_MUST_CHECK gp_status gp_exr_end(const struct gp_origin *o, uint64_t *end);

#endif
