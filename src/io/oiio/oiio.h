/* The OpenImageIO bridge: formats that io does not know itself.
 *
 * The bridge is a shared object of its own (glarepp-oiio.so), opened with
 * dlopen at first need, because linking OpenImageIO costs 200 ms at every
 * start. oiio_load.c finds it beside the program, in ../lib/glarepp, in the
 * installed folder, or in $GLAREPP_BRIDGES. No C++ type crosses this header.
 */
#ifndef GP_IO_OIIO_OIIO_H
#define GP_IO_OIIO_OIIO_H

#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* An image as OpenImageIO sees it. Strings and arrays belong to the bridge
 * until gp_oiio_image_free(). */
struct gp_oiio_attribute {
    const char *name;
    int kind;            // 0 string, 1 int, 2 float
    const char *text;
    int whole;
    float real;
};

struct gp_oiio_image {
    int x, y, w, h;                            // data window
    int full_x, full_y, full_w, full_h;        // display window
    int channels;
    const char *const *channel_name;
    int half;                                  // stored as half
    int bits;                                  // 0 stored as floats, else of
                                               // the integers that pixels has
                                               // scaled to [0,1]
    float *pixels;                             // w * h * channels, interleaved;
                                               // NULL from open()
    int block;                                 // rows of a block of rows()
    int has_chromaticities;
    float chromaticities[8];
    const char *colour_space;                  // "" unknown, "sRGB", "Linear"
    const struct gp_oiio_attribute *attribute;
    int attributes;
    void *own;
    /* For writing EXR only, both or neither: samples in each channel's own
     * type (enum gp_pixel_type as int), interleaved without padding; pixels
     * and the `type` of write() do not count then. */
    const void *native;
    const int *channel_type;
};

/* Of a bridge's function that failed because memory is full. */
enum { GP_OIIO_MEMORY = -2 };

/* What a bridge gives. Every function returns 0, or -1 or GP_OIIO_MEMORY with
 * a one-line reason in `why` (always terminated). The bridge never throws. */
struct gp_oiio_api {
    int version;  // GP_OIIO_API_VERSION

    /* Reads an image by path, or from memory when `data` is not NULL (the
     * path then only helps to guess the format).
     *
     *   size        of the file too when `data` is NULL: a picture that its
     *               bytes cannot hold is refused
     *   part        subimage, 0 the first
     *   max_pixels  refuses more before it allocates; but in EXR each four
     *               channels count on their own
     *
     * Values are as stored: colour_space says what they mean, and making
     * them linear is the caller's. Of EXR files, channels that are stored as
     * uint32 come as those 32 bits in the place of the float.
     */
    int (*read)(const char *path, const void *data, size_t size, int part,
                long long max_pixels, struct gp_oiio_image *out, char *why,
                size_t why_size);

    /* The same without pixels, which rows() gives; the file stays open until
     * image_free(), and `data` must live as long. */
    int (*open)(const char *path, const void *data, size_t size, int part,
                long long max_pixels, struct gp_oiio_image *out, char *why,
                size_t why_size);

    /* Rows [y, y + image->block) of an image from open(), or as many as there
     * are: w * channels floats each, from y = 0 at the top. Blocks are asked
     * for in their order, each once; `to` has room for a whole one. */
    int (*rows)(struct gp_oiio_image *image, int y, float *to, char *why,
                size_t why_size);

    void (*image_free)(struct gp_oiio_image *image);

    /* Writes img->pixels to `path`, which has the final ending `format`
     * ("tif", "exr", ...) even when its name is a temporary one.
     *   type         "half", "float", "uint8", "uint16"
     *   compression  EXR/TIFF compression name, "dwaa:45" with its quality,
     *                or "" for the default
     *
     * A fourth channel is alpha: associated in float types, not associated
     * in integer ones.
     */
    int (*write)(const char *path, const char *format,
                 const struct gp_oiio_image *img, const char *type,
                 const char *compression, char *why, size_t why_size);

    /* True when an OpenImageIO plugin writes this ending, to a file of any
     * name, so that it holds what it was given. Of EXR's endings .exr alone. */
    int (*can_write)(const char *format);

    /* Resizes img into a new image (lanczos3), each channel's mean kept:
     * flux an area of the picture gives stays what it was. */
    int (*resize)(const struct gp_oiio_image *img, int w, int h,
                  struct gp_oiio_image *out, char *why, size_t why_size);
};
enum { GP_OIIO_API_VERSION = 2 };

/* The one symbol of the bridge. */
const struct gp_oiio_api *gp_oiio_api(void);

/* In the program: opens the bridge at first call. NULL, with the reason in
 * `why`, when it or one of its libraries is missing. */
const struct gp_oiio_api *gp_oiio_open(char *why, size_t why_size);

/* In the program: the line and the status of GP_OIIO_MEMORY, which a function
 * of the bridge gave for `path` with `why`. Never GP_OK. */
gp_status gp_oiio_no_memory(const struct gp_log *log, const char *path,
                            const char *why);

#ifdef __cplusplus
}
#endif

#endif
