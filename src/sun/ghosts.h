// SPDX-License-Identifier: Apache-2.0
/* Ghosts of the picture: flare elements of every bright pixel, as engine runs.
 *
 * An element at position a (flare.h) over all sources is the convolution of
 *   the sources, scaled about the display's centre by 1 - a, with
 *   the element's image, drawn once with a light of flux 1
 * (Ando et al. 2007, section 5: polygons for each bright pixel). Elements of
 * one position are one image, so a flare takes a run for each position.
 *
 * A scaled source lies between pixels. The element is drawn for the grid that
 * goes through the scaled pixel nearest to the centre, and each source is split
 * bilinearly among four points of that grid: flux and centroid stay exact, and
 * at whole 1 - a nothing is split at all. Edges are softened by half a pixel: the
 * error is at most (|f_xx| + |f_yy|) / 8 of the image f, in pixels. */
#ifndef GP_SUN_GHOSTS_H
#define GP_SUN_GHOSTS_H

#include "core/image.h"
#include "core/status.h"
#include "glare/kernel.h"
#include "glare/sources.h"
#include "sun/flare.h"

/* The elements of one position, whose sources are dimmed alike. */
struct gp_ghost {
    const struct gp_flare_element *e; // the first; the flare's
    double scale;            // of the sources about the centre: 1 - position
    int elements;
    double split; // that error where it is largest, half a pixel from
                  // the grid both ways: rel_l2 of the worst channel
    struct gp_kernel kernel; // their image; no samples: it is black
    int pixel[2];            // pixel nearest to the display's centre, and the
    int moved[2];            // one that holds it, scaled; EXR pixel space
};

/* All of a flare, for frames of one shape. Zeroed is none. */
struct gp_ghosts {
    struct gp_ghost *run;    // owned
    int n;
    struct gp_rect data, display; // of the frames
    int frame;               // number of the last one
};

/* Makes the images for frames of these windows, unless *out has them, cut to
 * offsets that reach from a source to a pixel of the frame. Flicker counts by
 * f->frame. f must stay as long as *out, which is empty after an error.
 * Errors: GP_ERR_DATA an image of over 2^26 pixels, those of
 * gp_kernel_of_planes(). */
GP_MUST_CHECK gp_status gp_ghosts_make(const struct gp_log *log,
    const struct gp_flare *f, struct gp_rect data, struct gp_rect display,
    struct gp_ghosts *out);
void gp_ghosts_free(struct gp_ghosts *g);

/* Scales the sources of a frame for a run, and dims them by flicker and
 * by_place. Those that land outside the frame are kept where the image reaches
 * into it: *out has a window of its own; free with gp_sources_free(). */
GP_MUST_CHECK gp_status gp_ghost_move(const struct gp_log *log,
    const struct gp_ghosts *g, const struct gp_ghost *run,
    const struct gp_sources *src, struct gp_sources *out);

#endif
