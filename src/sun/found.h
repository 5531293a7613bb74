// SPDX-License-Identifier: Apache-2.0
/* Lights that a frame shows: its bright blobs, measured, and named by those of
 * another frame. */
#ifndef GP_SUN_FOUND_H
#define GP_SUN_FOUND_H

#include "core/image.h"
#include "core/status.h"
#include "glare/sources.h"
#include "sun/lights.h"

enum { GP_FOUND_USUAL = 32, GP_FOUND_MOST = 256 };

/* Finds the brightest lights of a frame. A blob is an area of sources that touch,
 * at corners too. Its light is what its pixels, and those up to 2 pixels from
 * them, have over their ground: the mean of the pixels 3 to 5 away that are in
 * reach of no blob. Place and radius are the light's centroid and that of the
 * even disc with its second moment. Of a blob wider than a quarter of the display
 * window's height, which is no light, blobs over 4 times the level may be, and so on,
 * if they are 4 times as bright as their ground, as a sun in a bright sky is.
 *   None pops up: flux grows from 0 to all while the brightest pixel, or a quarter of
 * the luminance where that is less (it may be the middle of four pixels), grows from T
 * to 1.5 T; and from 4 to 6 times the ground.
 *   src  of the frame; f: its pixels, after gp_sense()
 *   out  owned by the caller, gp_free(); *n, to GP_FOUND_MOST, by falling flux;
 *        without names
 *   wide  a blob is no light */
GP_MUST_CHECK gp_status gp_lights_find(const struct gp_log *log,
                                       const struct gp_sources *src,
                                       const struct gp_image *f,
                                       struct gp_light **out, int *n,
                                       bool *wide);

/* Where lights are in a frame, by their places in others: those of one name are
 * side by side, in order of frames; between two it is linear, outside that of the
 * first or last. `out` has room for n. Returns how many there are. */
int gp_lights_at(const struct glarepp_light *track, int n, double frame,
                 struct glarepp_light *out);

/* Gives lights the names of `known`, at most GP_LIGHTS_MAX places and fluxes of
 * another frame, none "": by pairs whose places, in 1/20 of `height`, and whose
 * fluxes, in octaves, are least apart, the nearest first, and at most 1/4 of the
 * height and 3 octaves; or 1/20 whatever the flux is, as of one that fades. Their
 * fluxes are times its gain. */
GP_MUST_CHECK gp_status gp_lights_name(const struct gp_log *log,
                                       struct gp_light *light, int n,
                                       const struct glarepp_light *known,
                                       int knowns, double height);

#endif
