/* The OpenColorIO bridge: what crosses from C to C++ and back.
 *
 * The bridge is a shared object of its own (glarepp-ocio.so), opened at first
 * need as core/bridge.h says. No C++ type crosses this header. */
#ifndef GP_TONE_OCIO_BRIDGE_H
#define GP_TONE_OCIO_BRIDGE_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Names to look up in a config. Strings are borrowed. */
struct gp_ocio_params {
    const char *config;   // file, or ocio://NAME; "" or "env": what $OCIO
                          // says. NULL: no OCIO
    const char *input;    // the frame's space; NULL: role scene_linear, else
                          // reference, else default
    const char *display;  // NULL: the config's default
    const char *view;     // NULL: the display's default for the input
    const char *look;     // "a, +b, -c | d" in place of the view's own looks;
                          // NULL: those
    const char *output;   // space of --hdr; NULL: as it is
    const char *const *context;  // `contexts` settings, "NAME=VALUE"
    int contexts;
    bool shows;           // a display's view is wanted
    bool any_primaries;   // frames are in `input` whatever their file names
};

/* The names that were found, as the config spells them. Strings live until the
 * processors are closed. */
struct gp_ocio_names {
    const char *config;         // file or URI
    const char *input;
    const char *display, *view; // NULL when !shows
    const char *look;           // NULL: none was asked for
    const char *output;         // NULL: none was asked for
    const char *const *file;    // `files` that the processors were made of,
    int files;                  // besides the config; some may be in it
};

/* The light of a colour space. */
struct gp_ocio_light {
    bool known;          // it is linear, and the config has a space (by role or
                         // name) whose primaries are known
    double matrix[9];    // its RGB to linear RGB of primaries `of`, row-major
    float of[8];         // rx ry gx gy bx by wx wy
};

/* Processors; NULL for what was not asked for. Any thread may use them. */
struct gp_ocio_opened {
    struct gp_ocio_names names;
    const void *view, *output;
    struct gp_ocio_light input_light, output_light;
    /* ITU-T H.273 ColourPrimaries and TransferCharacteristics of the view's
     * picture, which is full-range RGB: those of sRGB, PQ and HLG in BT.709,
     * P3-D65 and BT.2020. 0, 0 where the config does not say. */
    unsigned char cicp[2];
    void *own;
};

/* An error, with a parameter as in struct gp_line; both always terminated. */
struct gp_ocio_fault {
    char parameter[32], line[2048];
};

/* The functions of the bridge. It never throws and never prints. */
struct gp_ocio_api {
    int version;  // GP_OCIO_API_VERSION

    /* Reads the config and makes what `p` asks for. Returns GP_OK, or another
     * enum gp_status with the error in *fault; *out is empty then.
     *   GP_ERR_USAGE  a name that the config does not have (lists those it
     *                 has), $OCIO unset, ocio:// without built-in configs
     *   GP_ERR_IO     the config cannot be read
     *   GP_ERR_DATA   OpenColorIO refuses the config or a file of it
     */
    int (*open)(const struct gp_ocio_params *p, struct gp_ocio_opened *out,
                struct gp_ocio_fault *fault);
    void (*close)(struct gp_ocio_opened *opened);

    /* n pixels in place, float32, plane by plane. 0, or -1 when OpenColorIO
     * fails (out of memory). */
    int (*apply)(const void *processor, float *r, float *g, float *b, size_t n);
};
enum { GP_OCIO_API_VERSION = 4 };

/* The one symbol of the bridge. */
const struct gp_ocio_api *gp_ocio_api(void);

#ifdef __cplusplus
}
#endif

#endif
