// SPDX-License-Identifier: Apache-2.0
/* Lights that a sequence shows, followed from frame to frame, and their file. */
#ifndef GP_CLI_TRACKS_H
#define GP_CLI_TRACKS_H

#include "core/status.h"
#include "glarepp.h"

/* A light, and where it was. */
struct gp_track {
    double (*at)[3]; // frame, x, y; `n` of them, owned
    int n;
    float flux[3]; // when it was brightest
};

struct gp_tracks {
    struct gp_track *track; // `n`, in order of their first frames; owned
    int n;
};

/* Adds the lights that SENSE found in a frame of `height` pixels, whose number is
 * greater than those before. One is next to where a track leads, in place and in
 * colour, or begins a new one. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_tracks_add(const struct gp_log *log,
                                      struct gp_tracks *t,
                                      const struct glarepp_facts *f, int frame,
                                      int height);

/* Writes them for --lights: lamp1, lamp2, .... Errors: GP_ERR_IO; GP_ERR_BUG. */
GP_MUST_CHECK gp_status gp_tracks_write(const struct gp_log *log,
                                        const struct gp_tracks *t,
                                        const char *path);
void gp_tracks_free(struct gp_tracks *t);

#endif
