/* Settings as parameters of the library. All borrow from the settings. */
#ifndef GP_CLI_PLAN_SETTINGS_H
#define GP_CLI_PLAN_SETTINGS_H

#include "cli/settings.h"

/* Parameters of a plan, and those that they point to. */
struct gp_plan_settings {
    struct glarepp_plan_params plan;
    struct glarepp_light light; // the sun of --sun or --sun-dir
    struct glarepp_light_params lights;
    struct glarepp_lens_params lens;
    struct glarepp_scene_params scene;
    struct glarepp_tone_params tone;
};

/* Fills in *out, which must not move. The kernel must outlive the plan. */
void gp_plan_params(const struct gp_settings *s,
                    const struct glarepp_kernel *kernel,
                    struct gp_plan_settings *out);

/* Parameters of the kernel that the options name. */
struct glarepp_kernel_params gp_kernel_params(const struct gp_settings *s);

#endif
