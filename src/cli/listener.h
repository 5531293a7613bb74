// SPDX-License-Identifier: Apache-2.0
/* The program as the library's user: parameters, planes and messages. */
#ifndef GP_CLI_LISTENER_H
#define GP_CLI_LISTENER_H

#include "cli/jobs.h"

/* The user of a context, whom its messages and pictures are for. */
struct gp_listener {
    const struct gp_log *log;
    const struct gp_settings *s;
};

/* The message callback of a context. Prints to the log that is the user of a
 * frame, else to the listener's, and adds what to do. */
void gp_hear(void *user, const struct glarepp_message *m);

/* Has this thread's messages of no frame go to a log, until it is NULL: of a plan
 * that is made for one frame. Borrowed. */
void gp_hear_about(const struct gp_log *log);

/* Returns words to put after the text of a message about that parameter: "; use
 * --engine fft", or ", or use --engine fft" where the text gives advice, or
 * "". */
const char *gp_hint(const char *parameter, const char *text);

/* Returns what a job and its file say of a frame, and a view of its pixels. */
struct glarepp_frame_params gp_frame_params_of(const struct gp_job *job,
                                               const struct gp_frame *f);

/* Returns an image as its file stores it, borrowed. */
struct glarepp_stored gp_stored_view(const struct gp_stored_image *m,
                                     const char *name);

/* Names of the recipes' attributes in a file of glarepp kernel;
 * glare/model/README.md has the others. */
enum { GP_KERNEL_RECIPES = 8 };
extern const char *const gp_recipe_names[GP_KERNEL_RECIPES];

/* Reads what the file of a kernel says of it; all 0 where it is not by glarepp
 * kernel. Errors: GP_ERR_DATA a recipe that this program does not know. */
GP_MUST_CHECK gp_status gp_label_read(const struct gp_log *log,
    const struct gp_frame *f, struct glarepp_label *out);

/* Callbacks of a context. A picture is released by the thread that read it,
 * before it reads another. */
int gp_picture_read(void *user, const struct glarepp_picture *p,
                    struct glarepp_image *out, struct glarepp_label *label);
void gp_picture_release(void *user, struct glarepp_image *image);

#endif
