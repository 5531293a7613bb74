/* Planes and carried channels to the compressed chunks of a scanline part. */
#ifndef GP_IO_EXR_ENCODE_H
#define GP_IO_EXR_ENCODE_H

#include "core/frame.h"
#include "core/status.h"
#include "io/write.h"

struct gp_exr_out;

/* One channel of the part: samples of its grid (frame.h), either a colour
 * plane or samples of the file's own type. */
struct gp_exr_source {
    const char *name;         // borrowed
    enum gp_pixel_type type;  // as written
    int xs, ys;               // subsampling, >= 1
    bool linear;              // EXR's pLinear
    int columns;              // samples in a row
    const float *plane;       // columns * rows floats, made half where the
                              // type says so; xs = ys = 1; or NULL
    const void *data;         // samples of `type`, when plane is NULL
};

struct gp_exr_image {
    struct gp_rect data;
    enum gp_compression compression;   // not AUTO
    const struct gp_exr_source *source;  // sorted by name as strcmp() does
    int sources;
};

/* Sorts sources into the order that EXR asks for. */
void gp_exr_sort(struct gp_exr_source *source, int sources);

/* Rows of a chunk and chunks of a part with that compression. */
int gp_exr_chunk_rows(enum gp_compression compression);
int gp_exr_chunk_count(const struct gp_exr_image *img);

/* Packs the rows [y0, y1) as EXR stores them before compression: row by row,
 * channel by channel, into `to`, or only counts when `to` is NULL.
 *
 *   clamped  grows by the finite values that half cannot hold; B44 can hold
 *            none below -32752
 *
 * Returns the number of bytes, always even.
 */
size_t gp_exr_pack(const struct gp_exr_image *img, int y0, int y1,
                   uint8_t *to, long long *clamped);

/* Compresses all chunks, in parallel, and appends them to part `part` in
 * order. The bytes do not depend on the number of threads.
 *
 *   path     for messages
 *   quality  of DWAA and DWAB (OpenEXR's default is 45); else not used
 *
 * Errors: GP_ERR_USAGE a compression that cannot hold these channels;
 * GP_ERR_IO; GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_exr_encode(struct gp_exr_out *out, int part,
                                      const struct gp_exr_image *img,
                                      float quality,
                                      struct gp_write_stats *stats);

/* DWAA and DWAB by the OpenImageIO bridge, which OpenEXRCore 3.1.5 cannot
 * make: gp_exr_encode() calls it. */
GP_MUST_CHECK gp_status gp_exr_encode_dwa(struct gp_exr_out *out, int part,
                                          const struct gp_exr_image *img,
                                          float quality,
                                          struct gp_write_stats *stats);

#endif
