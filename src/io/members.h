/* Several images one behind the other in one stream, as `cat a.exr b.exr`
 * makes them.
 *
 * A stream is read to its end into memory before the first frame, because a
 * program that writes to a pipe says nowhere how many frames will come.
 */
#ifndef GP_IO_MEMBERS_H
#define GP_IO_MEMBERS_H

#include "core/frame.h"
#include "core/status.h"
#include "io/read.h"
#include "io/stream.h"

/* Where one image lies in the stream. */
struct gp_member {
    uint64_t at, size; // bytes
};

struct gp_members {
    struct gp_stream stream;  // owned: all bytes
    struct gp_member *member; // owned; in the stream's order
    int n;
};

/* Reads stdin (or another pipe) to its end and finds its images.
 *
 * EXR, PNG and PFM say where they end: EXR by its offset tables, PNG by IEND,
 * PFM by its header. Any other format has
 * the stream for itself. An image whose end cannot be told (damaged, cut off)
 * reaches to the end of the stream, so that its reader says what is wrong.
 * Zero bytes behind an image are padding.
 *
 *   p     max_pixels bounds the bytes of the whole stream: 16 for each pixel,
 *         and 64 MiB
 *   path  "-", or a pipe
 *   out   written only on GP_OK; free with gp_members_free() after the last
 *         frame read from it is freed
 *
 * Errors: those of gp_read_open(); GP_ERR_DATA bytes behind an image that
 * begin no EXR, PNG or PFM; GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_members_read(const struct gp_log *log,
                                        const struct gp_read_params *p,
                                        const char *path,
                                        struct gp_members *out);
/* Frees what it owns and clears it; an empty or all-zero one is fine. */
void gp_members_free(struct gp_members *m);

/* gp_read_frame() for image `i` of [0, m->n). The frame borrows the stream's
 * bytes; several threads may read at once.
 *
 *   name  for messages and gp_frame.path
 */
GP_MUST_CHECK gp_status gp_members_frame(const struct gp_log *log,
                                         const struct gp_read_params *p,
                                         const char *name,
                                         const struct gp_members *m, int i,
                                         struct gp_frame *out);

#endif
