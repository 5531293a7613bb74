/* Whether a TIFF's rows are all there. OpenImageIO reads what lies behind the
 * end of an uncompressed file as zeros. */
#ifndef GP_IO_WHOLE_TIFF_H
#define GP_IO_WHOLE_TIFF_H

#include "core/status.h"
#include "io/stream.h"

/* Checks directory `part` (from 0) of a classic or Big TIFF of either byte
 * order: its tables of strips or tiles are as long as its size demands, each
 * lies within the file, uncompressed ones hold their rows and compressed ones
 * can hold them. Of the tables no more is read than the size demands. Deflated
 * ones are unpacked (whole_zip.h), but for YCbCr, bits in the order that nobody
 * writes, and more bytes than `max_pixels` of four doubles have; nothing else
 * takes memory.
 *
 * A strip or tile without data (offset and count 0, "sparse") is refused:
 * libtiff does not read it either. What a check cannot judge passes: files
 * without a size or offsets (camera raw), a part that is not there, counts
 * that old writers left out or got wrong in files of one uncompressed strip,
 * which libtiff finds itself.
 *
 * Errors: GP_ERR_DATA cut off or damaged; GP_ERR_IO; GP_ERR_BUG out of
 * memory.
 * Sources: Adobe, TIFF 6.0, sections 2, 3 and 15; libtiff, BigTIFF design.
 */
GP_MUST_CHECK gp_status gp_whole_tiff(const struct gp_log *log,
                                      const char *path,
                                      const struct gp_stream *s, int part,
                                      long long max_pixels);

#endif
