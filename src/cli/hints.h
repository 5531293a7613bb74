/* Messages of the library, in the program's words: which option to give. */
#ifndef GP_CLI_HINTS_H
#define GP_CLI_HINTS_H

#include "cli/settings.h"
#include "core/status.h"
#include "glarepp.h"

/* Who messages and pictures of the library are for: the user of a context. */
struct gp_listener {
    const struct gp_log *log;
    const struct gp_settings *s;
};

/* The message callback of a context, whose user is a struct gp_listener. Prints
 * to the log that is the user of a frame, else to the context's, and adds what to
 * do. */
void gp_hear(void *user, const struct glarepp_message *m);

/* Returns words to put after the text of a message about that parameter: "; use
 * --engine fft", or ", or use --engine fft" where the text gives advice already.
 * "": none are needed. */
const char *gp_hint(const char *parameter, const char *text);

#endif
