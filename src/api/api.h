// SPDX-License-Identifier: Apache-2.0
/* The library's handles, and steps that every call takes. */
#ifndef GP_API_API_H
#define GP_API_API_H

#include "glarepp.h"

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"

/* The receiver of a log: a context's messages, of a frame or of none. */
struct gp_api_sink {
    const struct glarepp *gp;
    void *user;              // of the frame
    const char *name;        // of its image, for lines that name no file; or
                             // NULL
};

struct glarepp {
    struct gp_env env;
    struct gp_log log;
    struct gp_api_sink sink;
    struct glarepp_params params;
    char *text[4];           // owned copies of strings of `params`
    struct dirent **list[2]; // `names` in folders; owned
    int names[2];
};

/* Begins a call: the thread works in the context. Returns the one that it was
 * in, or NULL; end with gp_api_end(), which returns st. */
struct glarepp *gp_api_begin(struct glarepp *gp);
int gp_api_end(struct glarepp *outer, gp_status st);

/* Returns a log to a sink, which it borrows. */
struct gp_log gp_api_log(struct gp_api_sink *sink);

/* Names the parameter of this call's errors from here on that name none, as
 * gp_api_params() does; NULL leaves it. Returns it. */
const char *gp_api_about(const char *parameter);

/* Copies a caller's parameters, of whatever size, over the defaults in *to.
 * `from` may be NULL. Errors: GP_ERR_USAGE a size that no version has; those of
 * gp_api_check(). */
GP_MUST_CHECK gp_status gp_api_params(const struct gp_log *log,
    const char *name, void *to, size_t size, const void *from);

/* Checks each field of the struct that has a range: "layer", "light", ... Errors:
 * GP_ERR_USAGE a field, by its name. */
GP_MUST_CHECK gp_status gp_api_check(const struct gp_log *log,
                                     const char *name, const void *params);

/* Notes an error whose message the caller has printed. */
void gp_api_note(gp_status status, const char *parameter, const char *text);

/* Asks the caller to decode a picture; *out has planes of its own.
 * Errors: GP_ERR_USAGE no picture callback; its own. */
GP_MUST_CHECK gp_status gp_api_picture(struct glarepp *gp,
    const struct gp_log *log, const char *path, struct gp_image *out,
    struct glarepp_label *label);

/* Reads a scene, whose textures the caller decodes; without a callback they count
 * as opaque. Errors: those of gp_scene_read(). */
struct gp_scene;
GP_MUST_CHECK gp_status gp_api_scene_read(struct glarepp *gp,
    const struct gp_log *log, const char *path, enum glarepp_up up,
    struct gp_scene *out);

/* Makes a frame of a view.
 *   borrow  the planes are taken as they are where they are float without gaps
 *   out     gp_image_free() unless it borrows
 * Errors: GP_ERR_USAGE a view that is none; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_api_import(const struct gp_log *log,
    const struct glarepp_image *view, bool borrow, struct gp_image *out);

/* Takes one plane of a view, borrowed where it is float without gaps. */
GP_MUST_CHECK gp_status gp_api_plane(const struct gp_log *log,
    const struct glarepp_image *view, int which, struct gp_plane *out);

/* Copies planes of `data` to a view of the same window. Errors: GP_ERR_USAGE it
 * is not. */
GP_MUST_CHECK gp_status gp_api_export(const struct gp_log *log,
    const struct gp_planes *planes, struct gp_rect data,
    const struct glarepp_image *view);

/* Makes image->layer, all 0, unless it is there. */
GP_MUST_CHECK gp_status gp_api_dark_layer(const struct gp_log *log,
                                          struct gp_image *image);

/* Returns a view of planes of `data`, of a frame or (NULL) of none. */
struct glarepp_image gp_api_view(const struct gp_planes *planes,
                                 struct gp_rect data, const struct gp_image *f);

#endif
