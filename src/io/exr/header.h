/* Making an EXR header, byte by byte (openexr file layout, "Header"). */
#ifndef GP_IO_EXR_HEADER_H
#define GP_IO_EXR_HEADER_H

#include "core/frame.h"
#include "core/status.h"
#include "io/exr/encode.h"
#include "io/exr/raw.h"
#include "io/write.h"

/* Bytes that grow. A failed allocation is remembered and told at the end by
 * gp_exr_header_done(). Free with gp_exr_header_free(). */
struct gp_exr_header {
    uint8_t *bytes;
    size_t size, room;
    uint32_t flags;  // of the version field
    bool full;       // memory ran out
};

/* Which attributes of the input a part gets. */
enum gp_exr_kept {
    GP_EXR_KEEP_ALL,        // --hdr: the frame as it was, with glare
    GP_EXR_KEEP_CONVERTED,  // the same in another colour space
    GP_EXR_KEEP_SCENE,      // another picture in the frame's own light
    GP_EXR_KEEP_SHOWN,      // a display-referred one
};

/* Room for magic number and version; the version is set by done(). */
void gp_exr_header_start(struct gp_exr_header *h, uint32_t flags);

/* One attribute. Names and types over 31 bytes set GP_EXR_LONG_NAMES. */
void gp_exr_header_put(struct gp_exr_header *h, const char *name,
                       const char *type, const void *data, size_t size);

/* All attributes of the scanline part that holds the colour, and its end:
 * those that the layout asks for from `f` and `img`, and those of the input
 * that `kept` lets through.
 *
 *   raw     NULL when the input was not EXR
 *   name    of the part; may be NULL in files of one part
 *   chunks  of the part in a multi-part file, where type and number of chunks
 *           must be said; 0 in files of one part
 */
void gp_exr_header_part(struct gp_exr_header *h, const struct gp_frame *f,
                        const struct gp_exr_image *img,
                        const struct gp_exr_raw_part *raw,
                        enum gp_exr_kept kept, const char *name, int chunks);

/* Bytes as they are: another part's header. */
void gp_exr_header_raw(struct gp_exr_header *h, const void *bytes,
                       size_t size);

/* Writes the version field. Errors: GP_ERR_BUG when memory ran out. */
GP_MUST_CHECK gp_status gp_exr_header_done(const struct gp_log *log,
                                           const char *path,
                                           struct gp_exr_header *h);
void gp_exr_header_free(struct gp_exr_header *h);

#endif
