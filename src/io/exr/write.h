/* EXR files out, for write.c and the --hdr output. */
#ifndef GP_IO_EXR_WRITE_H
#define GP_IO_EXR_WRITE_H

#include "core/frame.h"
#include "core/status.h"
#include "io/exr/encode.h"
#include "io/exr/header.h"
#include "io/write.h"

/* A part that is made anew. */
struct gp_exr_part {
    const struct gp_frame *f;            // its windows and number
    const struct gp_exr_source *source;  // sorted
    int sources;
};

/* What goes into one file. */
struct gp_exr_job {
    const struct gp_write_params *p;
    const char *path;
    const struct gp_exr_part *part;  // of one file, no number twice; the first
    int parts;                       // frame's origin is the input
    enum gp_exr_kept kept;           // KEEP_ALL carries the other parts too;
                                     // else there is one part
};

/* Writes the file under its final name or not at all. Errors as in write.h. */
GP_MUST_CHECK gp_status gp_exr_write_file(const struct gp_log *log,
                                          const struct gp_exr_job *job,
                                          struct gp_write_stats *stats);

/* gp_write_picture() for EXR. */
GP_MUST_CHECK gp_status gp_exr_write_picture(const struct gp_log *log,
                                             const struct gp_write_params *p,
                                             const char *path,
                                             const struct gp_frame *f,
                                             const struct gp_planes *planes,
                                             enum gp_picture_kind kind,
                                             struct gp_write_stats *stats);

/* The compression of a part of the input: --compression, or its own when that
 * is AUTO and loses nothing, or zip. `raw` may be NULL. */
enum gp_compression gp_exr_compression(const struct gp_write_params *p,
                                       const struct gp_exr_raw_part *raw);

/* The sample type of colour channels that --type asks for. */
enum gp_pixel_type gp_exr_colour_type(const struct gp_write_params *p,
                                      const struct gp_frame *f);

#endif
