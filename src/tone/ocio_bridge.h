// SPDX-License-Identifier: Apache-2.0
/* The OpenColorIO bridge: what crosses from C to C++ and back.
 *
 * The bridge is a shared object of its own (glarepp-ocio.so), opened at first
 * need as core/bridge.h says. No C++ type crosses this header. */
#ifndef GP_TONE_OCIO_BRIDGE_H
#define GP_TONE_OCIO_BRIDGE_H

#include "glarepp.h"

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The light of a colour space. */
struct gp_ocio_light {
    bool known;          // it is linear, and the config has a space (by role or
                         // name) whose primaries are known
    double matrix[9];    // its RGB to linear RGB of primaries `of`, row-major
    float of[8];         // rx ry gx gy bx by wx wy
};

/* Processors; NULL for what was not asked for. Any thread may use them. The names
 * of `facts`, as the config spells them, and files besides it live as long. */
struct gp_ocio_opened {
    struct glarepp_plan_facts facts;
    const void *view, *output;
    struct gp_ocio_light input_light, output_light;
    void *own;
};

/* An error, with a parameter as in struct gp_line; both always terminated. */
struct gp_ocio_fault {
    char parameter[32], line[2048];
};

/* The functions of the bridge. It never throws and never prints. */
struct gp_ocio_api {
    int version;  // GP_OCIO_API_VERSION

    /* Reads the config and makes what `p`, whose config is not NULL, asks for. The
     * code points of a picture are those of full-range RGB. Returns GP_OK, or another
     * enum gp_status with the error in *fault; *out is empty then.
     *   GP_ERR_USAGE  a name that the config does not have (lists those it
     *                 has), $OCIO unset, ocio:// without built-in configs
     *   GP_ERR_IO     the config cannot be read
     *   GP_ERR_DATA   OpenColorIO refuses the config or a file of it
     */
    int (*open)(const struct glarepp_tone_params *p, struct gp_ocio_opened *out,
                struct gp_ocio_fault *fault);
    void (*close)(struct gp_ocio_opened *opened);

    /* n pixels in place, float32, plane by plane. 0, or -1 when OpenColorIO
     * fails (out of memory). */
    int (*apply)(const void *processor, float *r, float *g, float *b, size_t n);
};
enum { GP_OCIO_API_VERSION = 5 };

/* The one symbol of the bridge. */
const struct gp_ocio_api *gp_ocio_api(void);

#ifdef __cplusplus
}
#endif

#endif
