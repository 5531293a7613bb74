// SPDX-License-Identifier: Apache-2.0
/* A picture as its file stores it, of any format but EXR, and the frame made
 * from it. */
#ifndef GP_IO_DECODED_H
#define GP_IO_DECODED_H

#include "io/frame.h"
#include "core/status.h"

/* A picture. Its reader owns what it points to, until gp_decoded_close(). */
struct gp_decoded {
    const char *path;            // for messages
    struct gp_rect data, display; // display empty: it is `data`
    float pixel_aspect;          // of width to height; not in (1e-6, 1e6): 1
    const float *chromaticities; // as in struct gp_frame; NULL: BT.709's
    int parts;                   // images in the file; 0: not known, or 1
    int channels;
    const char *const *channel_name;
    bool half;                   // stored as half
    int bits;                    // of the stored integers, which the samples
                                 // are scaled from to [0, 1]; 0: floats
    const char *colour_space;    // "sRGB", "Rec709", "KodakLog", "Gamma2.2",
                                 // "linear"; "" unknown
    const struct gp_attribute *attribute;
    int attributes;

    float *pixels; // samples as stored, w * channels a row, interleaved
    void (*close)(struct gp_decoded *image); // NULL: only `pixels` is owned
    void *own;
};

/* Frees a picture; one that is all zero is fine. */
void gp_decoded_close(struct gp_decoded *image);

/* Copies the samples of one channel to `to`, w * h of them. */
void gp_decoded_channel(const struct gp_decoded *image, int channel,
                        float *to);

/* Makes a frame from a picture, which stays the caller's. Chooses colour, by
 * `layer` as in gp_read_params, and makes it linear as io/read.h says.
 * Errors: GP_ERR_USAGE no such layer. */
GP_MUST_CHECK gp_status gp_decoded_frame(const struct gp_log *log,
    const char *layer, const struct gp_decoded *image, struct gp_frame *out);

/* Refuses a window of `w` x `h` pixels that is empty, has more than
 * max_pixels, or edges that int cannot hold four times. `which` is "data" or
 * "display", for the line. Errors: GP_ERR_DATA. */
GP_MUST_CHECK gp_status gp_window_check(const struct gp_log *log,
    const char *path, const char *which, int64_t w, int64_t h,
    long long max_pixels);

#endif
