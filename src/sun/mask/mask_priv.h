// SPDX-License-Identifier: Apache-2.0
/* The plain form, for tests. */
#ifndef GP_SUN_MASK_MASK_PRIV_H
#define GP_SUN_MASK_MASK_PRIV_H

#include "sun/mask/mask.h"

/* Returns the visibility of one light on the CPU: the plain form of the map,
 * summed in double whatever p->bytes. `map` gets r and g of p->side squared
 * texels, or is NULL. */
double gp_sun_map_reference(const struct gp_occluders *o,
                            const struct glarepp_light_params *p,
                            const struct gp_light *light, float *map);

#endif
