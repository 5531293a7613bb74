/* Every channel of a file with its values as stored, for comparing. */
#ifndef GP_IO_STORED_H
#define GP_IO_STORED_H

#include "core/frame.h"
#include "core/status.h"
#include "io/read.h"
#include "io/stream.h"

#include <stdbool.h>

struct gp_input;

/* One channel at full resolution: a value for each pixel of the data window,
 * rows from the top; subsampled ones are repeated. Of deep data, one for each
 * sample. */
struct gp_stored_channel {
    char *name;   // owned
    bool is_uint; // `v` holds uint32_t (EXR's UINT), else float
    void *v;      // owned
};

/* One part. Half and float samples are as stored, integers of other formats
 * are divided by their largest code, without a curve. */
struct gp_stored_image {
    struct gp_rect data, display;   // EXR pixel space
    struct gp_stored_channel *channel; // owned; in the file's order
    int channels;
    bool deep;
    int64_t *first;     // of deep data: the samples of pixel i are
                        // v[first[i]] to before v[first[i + 1]]; else NULL
    bool integers;      // display-referred: stored as integers, not EXR
    /* Linear colour of the data window: the channels that gp_read_frame()
     * would take (of luminance-chroma the luminance in all three), integers
     * made linear by the curve that their file names. Borrowed from the
     * channels or from `own`; NULL where there is no colour, or one of the
     * three is missing. */
    const float *light[3];
    struct gp_planes own;
    float chromaticities[8], luminance[3]; // as in struct gp_frame
};

/* An open file. */
struct gp_stored_file {
    const char *path;         // borrowed
    struct gp_input *input; // of an EXR, else NULL
    struct gp_stream stream;  // of other formats
    int parts;                // of EXR; 1 of other formats
};

/* Opens a file or stdin ("-") of any format. Close it in any case.
 * Errors: as gp_read_frame(). */
GP_MUST_CHECK gp_status gp_stored_open(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_stored_file *f);
void gp_stored_close(struct gp_stored_file *f);

/* Reads part `part` of [0, f->parts).
 *   out  written only on GP_OK; free with gp_stored_image_free()
 * Errors: as gp_read_frame(), but for deep parts and parts without colour,
 * which are none; more samples than p->max_pixels are. */
GP_MUST_CHECK gp_status gp_stored_read(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_stored_file *f, int part,
    struct gp_stored_image *out);
void gp_stored_image_free(struct gp_stored_image *image);

#endif
