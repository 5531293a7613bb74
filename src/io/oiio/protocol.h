// SPDX-License-Identifier: Apache-2.0
/* The messages between glarepp and its helper program glarepp-oiio.
 *
 * A socket between the two carries, in either direction, a fixed struct and
 * then `bytes` of text; files and memory go along as descriptors. The helper
 * sends one gp_oiio_reply at its start and then one for each gp_oiio_ask, in
 * their order. Both ends are of one build, so that structs go as they are.
 *
 *   GP_OIIO_OPEN   with the file's descriptor: looks at its header. The text
 *                  of the reply is packed as gp_oiio_spec says
 *   GP_OIIO_PIXELS with the descriptor of shared memory: decodes the picture
 *                  that was opened into it, as floats, and closes it
 *   GP_OIIO_WRITE  with the descriptors of an empty file and of memory that
 *                  holds the pixels: writes them as `format` */
#ifndef GP_IO_OIIO_PROTOCOL_H
#define GP_IO_OIIO_PROTOCOL_H

#include <stdint.h>

enum {
    GP_OIIO_PARTS = 4096,
    GP_OIIO_PROTOCOL = 0x67700004, // counts up when a struct changes
};

enum gp_oiio_call { GP_OIIO_OPEN = 1, GP_OIIO_PIXELS, GP_OIIO_WRITE };

/* The end of a call; text is the reason of all but GP_OIIO_DONE. */
enum gp_oiio_end {
    GP_OIIO_DONE,
    GP_OIIO_REFUSED,  // the file is damaged, or not to be read or written
    GP_OIIO_MEMORY,   // memory is full
};

/* An image without its pixels. Its text: each channel's name, then the colour
 * space ("" unknown, "sRGB", "Linear"), each with its '\0'; for writing in
 * channel types a byte for each channel (enum gp_pixel_type); then each
 * attribute: 's', 'i' or 'f', its name with '\0', and a string with '\0' or
 * the 4 bytes of an int or float. */
struct gp_oiio_spec {
    int32_t x, y, w, h;                      // data window
    int32_t full_x, full_y, full_w, full_h;  // display window
    int32_t channels;
    int32_t half;        // stored as half
    int32_t bits;        // 0 stored as floats, else of integers, which come
                         // scaled to [0,1]
    int32_t attributes;
    int32_t typed;       // the text has channel types
    int32_t parts;       // images in the file, up to GP_OIIO_PARTS are counted
    int32_t has_chromaticities;
    float chromaticities[8];
};

struct gp_oiio_ask {
    uint64_t size;          // of the file, or of the shared memory
    int64_t max_pixels;     // refuses more; in EXR each four channels count
                            // on their own
    uint32_t protocol, call;
    uint32_t bytes;         // of text that follows
    int32_t part;           // subimage, 0 the first
    int32_t threads;        // to decode with
    char format[16];        // OpenImageIO's name to read, an ending to write
    char type[16];          // written: "half", "float", "uint8", "uint16"
    char compression[32];   // OpenImageIO's name, "" the default
    struct gp_oiio_spec spec; // of what is written
};

struct gp_oiio_reply {
    uint32_t protocol, end;
    uint32_t bytes;         // of text that follows
    struct gp_oiio_spec spec;
};

#endif
