/* Values that options take by name; each list ends with a NULL name. */
#ifndef GP_APP_OPTION_VALUES_H
#define GP_APP_OPTION_VALUES_H

#include "app/options.h"

extern const struct gp_option_choice gp_normalizes[], gp_mixes[], gp_gls[],
    gp_methods[], gp_primitives[],
    gp_depth_types[], gp_sun_methods[], gp_patterns[], gp_sums[],
    gp_outsides[], gp_sun_draws[], gp_ndcs[], gp_plans[], gp_types[], gp_compressions[],
    gp_bits[], gp_alphas[], gp_progresses[], gp_stdout_formats[], gp_raws[],
    gp_debugs[], gp_shells[];

#endif
