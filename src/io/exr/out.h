/* The container of an EXR file on its way out: header, offset tables, chunks
 * (openexr file layout, "Chunk Layout").
 *
 * Written here and not with OpenEXRCore's chunk functions, because those of
 * 3.1.5 refuse chunks out of order and deep tiles without samples.
 */
#ifndef GP_IO_EXR_OUT_H
#define GP_IO_EXR_OUT_H

#include "core/status.h"
#include "io/exr/origin.h"
#include "io/exr/raw.h"
#include "io/file.h"

#include <stdint.h>

struct gp_exr_table {
    uint64_t at;       // where it stands in the file
    uint64_t *offset;  // of each chunk; 0 not written yet
    int chunks;
};

struct gp_exr_out {
    const struct gp_log *log;
    struct gp_file *file;  // borrowed
    struct gp_exr_table *table;
    int parts;
    bool multipart;
};

/* Writes the header and room for the offset tables.
 *
 *   header  from gp_exr_header_done(), its version field included
 *   chunks  of each part, > 0
 *   out     empty on failure; free with gp_exr_out_free()
 *
 * Errors: GP_ERR_IO, GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_exr_out_begin(const struct gp_log *log,
                                         struct gp_file *file,
                                         const void *header, size_t size,
                                         const int *chunks, int parts,
                                         struct gp_exr_out *out);

/* Appends a scanline chunk that starts at row `y`; `size` is at most
 * INT32_MAX. */
GP_MUST_CHECK gp_status gp_exr_out_scanlines(struct gp_exr_out *out, int part,
                                             int index, int y,
                                             const void *data, size_t size);

/* Copies all chunks of a part of the input, flat or deep, scanlines or tiles
 * of all levels, byte by byte and in the order in which they stand there.
 *
 *   raw    the input's header; raw->size is where its offset tables start
 *   part   has the same number in both files
 *
 * Errors: GP_ERR_DATA a chunk is missing or reaches out of the file (`path`
 * is the input, for the line); GP_ERR_IO; GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_exr_out_copy(struct gp_exr_out *out, int part,
                                        const char *path,
                                        const struct gp_origin *origin,
                                        const struct gp_exr_raw *raw);

/* Fills in the offset tables. Errors: GP_ERR_IO; GP_ERR_BUG a chunk was
 * never written. */
GP_MUST_CHECK gp_status gp_exr_out_end(struct gp_exr_out *out);
void gp_exr_out_free(struct gp_exr_out *out);

#endif
