/* What an image file begins with. */
#ifndef GP_IO_FORMAT_H
#define GP_IO_FORMAT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* First bytes that are looked at: DICOM's word stands behind 128. */
enum { GP_FORMAT_BYTES = 132 };

/* The format that begins so, as a message names it ("PNG", but also what is
 * likely to be found under a wrong name: "gzip", "a web page"); NULL when
 * nothing known does. `n` bytes are there, at most GP_FORMAT_BYTES count. */
const char *gp_format_name(const uint8_t *first, size_t n);

/* Whether a stream that begins so can be an image that OpenImageIO reads. Of
 * formats without a word at their start (Targa, RLA) the first fields must
 * hold what these formats allow. True for EXR too. */
bool gp_format_reads(const uint8_t *first, size_t n);

#endif
