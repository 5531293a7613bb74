/* The command glarepp kernel: writes kernels with the recipe that made them,
 * makes them again, lists models and checks kernels. */
#ifndef GP_APP_KERNEL_COMMAND_H
#define GP_APP_KERNEL_COMMAND_H

#include "app/settings.h"
#include "core/status.h"

/* Does what s->making and s->outputs ask for. *faulty is true where --check
 * finds a fault.
 * Errors: those of reading images, making kernels and writing pictures. */
GP_MUST_CHECK gp_status gp_kernel_command(const struct gp_log *log,
    const struct gp_settings *s, bool *faulty);

#endif
