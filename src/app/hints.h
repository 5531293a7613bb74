/* Messages of the library, in the program's words: which option to give. */
#ifndef GP_APP_HINTS_H
#define GP_APP_HINTS_H

#include "app/settings.h"
#include "core/status.h"
#include "glarepp.h"

/* Who a message of the library is for: the user of a context's callbacks, and of
 * a frame's messages. */
struct gp_listener {
    const struct gp_log *log;
    const struct gp_settings *s;
};

/* The message callback of a context, whose user is a struct gp_listener. Prints
 * to the log that is a frame's user, else to that of the context's, and adds what
 * to do. */
void gp_hear(void *user, const struct glarepp_message *m);

/* Returns words to put after the text of a message about that parameter: "; use
 * --engine fft", or ", or use --engine fft" where the text gives advice already.
 * "": none are needed. */
const char *gp_hint(const char *parameter, const char *text);

#endif
