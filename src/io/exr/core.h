/* OpenEXRCore's compressors, one chunk at a time: RLE, PIZ, PXR24, B44, B44A.
 *
 * The library ties them to a file that it writes itself. Here they get a
 * context whose file goes nowhere, and give the compressed bytes back.
 */
#ifndef GP_IO_EXR_CORE_H
#define GP_IO_EXR_CORE_H

#include "core/status.h"
#include "io/exr/encode.h"

#include <openexr.h>

struct gp_exr_core;

/* Makes a compressor for one thread; `img` is borrowed until it is freed.
 * NULL when the library refuses these channels or memory is full, which
 * gp_exr_fault() then says. */
struct gp_exr_core *gp_exr_core_new(const struct gp_exr_image *img);
void gp_exr_core_free(struct gp_exr_core *core);

/* Packs and compresses the rows [y0, y1) of a whole chunk.
 *
 *   out, size  the bytes as they go into the file; owned by `core`, good
 *              until its next call
 *   clamped    as in gp_exr_pack()
 *
 * Returns GP_OK; GP_ERR_BUG memory is full; GP_ERR_USAGE the library's count
 * of samples is not that of the file layout (3.1.5 and odd subsampling).
 */
GP_MUST_CHECK gp_status gp_exr_core_run(struct gp_exr_core *core, int y0,
                                        int y1, const void **out,
                                        size_t *size, long long *clamped);

#endif
