/* The command glarepp lens: lists and checks lenses, and draws them. */
#ifndef GP_APP_LENS_COMMAND_H
#define GP_APP_LENS_COMMAND_H

#include "app/settings.h"
#include "core/status.h"

/* Does what s->making asks for. *faulty is true where --check finds a lens that
 * does not make what its file claims.
 * Errors: those of gp_lens_read() and gp_lens_focus(); GP_ERR_IO writing. */
GP_MUST_CHECK gp_status gp_lens_command(const struct gp_log *log,
    const struct gp_settings *s, bool *faulty);

#endif
