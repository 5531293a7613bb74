/* What is kept of the input for the writer.
 *
 * A frame that came from a file holds one gp_origin behind gp_frame.origin.
 * For EXR it is the open read context: attributes, other parts and their raw
 * chunks are read from there when gp_write_hdr() needs them, so nothing that
 * nobody asks for is ever read. For other formats it is the list of
 * attributes that the bridge gave.
 */
#ifndef GP_IO_EXR_ORIGIN_H
#define GP_IO_EXR_ORIGIN_H

#include "core/frame.h"
#include "core/status.h"
#include "io/oiio/oiio.h"
#include "io/stream.h"

#include <openexr.h>

struct gp_origin {
    /* Open for reading with the whole header parsed; NULL when the input was
     * not EXR. Safe to read from many threads at once. Its errors are return
     * values only; nothing is printed. */
    exr_context_t exr;
    struct gp_stream stream;  // the bytes behind exr
    uint64_t hidden;          // byte that the library gets another for; 0 none
    uint64_t tables;          // where the offset tables begin; 0: not found
    bool multi;               // chunks begin with the number of their part
    int part, parts;          // colour part and number of parts; exr only

    /* Attributes of an input that is not EXR, as the bridge named them; 0 and
     * NULL for EXR. Owned by the origin. */
    struct gp_oiio_attribute *attribute;
    int attributes;

    char reason[256];  // the library's last words about a bad header
};

/* The origin of a frame, or NULL for one that came from no file. */
static inline const struct gp_origin *gp_origin_of(const struct gp_frame *f)
{
    return f->origin;
}

/* Parses the header of an EXR.
 *
 *   path    for messages
 *   stream  the whole file; taken over: *stream is empty afterwards, also on
 *           failure
 *   out     written only on GP_OK; goes to gp_frame.origin, with
 *           gp_origin_free() as gp_frame.origin_free
 *
 * `part` of the result is 0 until the reader has chosen.
 * Errors: GP_ERR_DATA the header is damaged, or the file is cut off before its
 * last chunk ends, whatever part or level that is of; GP_ERR_IO a read failed;
 * GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_origin_open_exr(const struct gp_log *log,
                                           const char *path,
                                           struct gp_stream *stream,
                                           struct gp_origin **out);

/* A channel's type in the file as ours. */
enum gp_pixel_type gp_exr_pixel_type(exr_pixel_type_t type);

/* Keeps copies of the attributes of a bridge image, for an input that is not
 * EXR. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_origin_keep(const struct gp_log *log,
                                       const struct gp_oiio_image *image,
                                       struct gp_origin **out);

/* Finds chunk `index` of [0, exr_get_chunk_count()) of any part, in the
 * order of its offset table: scanline blocks from the top, or tiles by
 * level (rip maps: x level fastest), then row, then column.
 *
 *   info  written only on success; its sizes and offset are checked against
 *         the file's size, so packed_size (and for deep parts
 *         sample_count_table_size) bytes may be allocated and read with
 *         exr_read_chunk() or exr_read_deep_chunk()
 *
 * Returns EXR_ERR_SUCCESS or the library's code. OpenEXRCore 3.1.5 cannot
 * find the smaller levels of rip maps: EXR_ERR_BAD_CHUNK_LEADER.
 * Safe in parallel bodies.
 */
exr_result_t gp_origin_chunk(const struct gp_origin *o, int part, int index,
                             exr_chunk_info_t *info);

/* Closes and frees; for gp_frame.origin_free. NULL is fine. */
void gp_origin_free(void *origin);

#endif
