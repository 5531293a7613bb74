/* An image as its file stores it, for whoever compares or keeps every value. */
#ifndef GP_CORE_STORED_H
#define GP_CORE_STORED_H

#include "core/image.h"

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
    float chromaticities[8], luminance[3]; // as in struct gp_image
};

#endif
