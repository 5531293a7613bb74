// SPDX-License-Identifier: Apache-2.0
/* Edges: the light that comes from beyond the border of the picture.
 *
 * A kernel takes light out of every bright pixel. Near the border part of it
 * lands outside, and without a picture there nothing comes back: a flat sky is
 * darker along its border. So the picture goes on. Pixel p of channel c gets
 *
 *   beyond(p) = w(p) b(p)
 *
 * beside the light of the picture's own pixels, where w is the share of the
 * kernel whose sources lie outside,
 *
 *   w(p) = all of the kernel - sum over q in the picture of kernel(p - q)
 *
 * and b the broad light of the border as seen from p. For that the border is
 * cut into cells, GP_EDGE_CELLS along the longer side and an eighth as deep.
 * Each has the mean r of the cube roots of its light, and
 *
 *   b(p) = (sum over cells j of v_j(p) r_j / sum of v_j(p))^3
 *   v_j(p) = length_j (|p - q_j|^2 + cell^2)^(-3/2)
 *
 * q_j being the middle of the cell's outer side: at depth d under the border
 * that looks at some d to each side. A flat border of light s has b = s, so a
 * flat picture stays flat.
 *
 * Lamps are taken out twice. By the cube root, small ones: a lamp on a share f of a
 * cell counts f^3 of its light. And by an opening of the cells along the border: a
 * stretch that is shorter than 2 GP_EDGE_LAMP + 1 cells, a seventh of the longer
 * side, counts as what is beside it. So a lamp that the border cuts adds nothing,
 * while a sky or a window front goes on.
 *
 * b is found at the corners of the cells and linear between them. */
#ifndef GP_GLARE_EDGES_H
#define GP_GLARE_EDGES_H

#include "core/image.h"
#include "core/status.h"
#include "glare/sources.h"
#include "glarepp.h"

enum {
    GP_EDGE_CELLS = 48, // along the longer side: no finer, as a cell is the
                        // least that a lamp is told from the sky by
    GP_EDGE_LAMP = 3,   // cells to each side that broad light has at least
};

/* The ways in which the picture goes on.
 *   BLACK   not at all
 *   EXTEND  as above
 *   MIRROR  as its mirror image, gp_mirror_reach() pixels far, then as above */
struct gp_surround {
    enum glarepp_edges how;
    const struct gp_sources *picture; // whose border is looked at; borrowed;
                                      // NULL: as BLACK
    const struct gp_sources *own;     // the part of it whose light is wanted:
                                      // parts that add up to the picture add
                                      // up here too; NULL: all of it
    int turn; // columns of a whole turn, where a kernel's samples go around; else 0
};

struct gp_kernel;
struct gp_far_state;

/* The broad light of a border: b. */
struct gp_beyond {
    int w, h, side;     // of the picture; of a cell, pixels
    int rows;           // of corners of cells, `side` pixels apart
    struct gp_planes b; // rows * w: b in these rows
    double most;        // its largest value
};

/* Finds it. *out stays NULL where the border has no light. Free with
 * gp_beyond_free(). */
GP_MUST_CHECK gp_status gp_beyond_find(const struct gp_log *log,
    const struct gp_surround *edges, struct gp_beyond **out);
void gp_beyond_free(struct gp_beyond **b);

/* Facts of a kernel that w needs, for pictures of one size: kept from frame to
 * frame. */
struct gp_outside;

/* Finds it unless *outside is of that kernel and of b's size, for adding b to a
 * layer of that size; all are borrowed.
 *   far  open for k's far field, where it has one
 * Free with gp_outside_free(); *outside is NULL on failure. */
GP_MUST_CHECK gp_status gp_outside_find(const struct gp_log *log,
    const struct gp_kernel *k, const struct gp_far_state *far,
    const struct gp_beyond *b, struct gp_planes *layer,
    struct gp_outside **outside);
void gp_outside_free(struct gp_outside **outside);

/* Adds w b to row y of the layer; a task of gp_parallel_do(), whose ctx is what was
 * found. */
void gp_beyond_add_row(void *ctx, int y, int thread);

/* The same in double, for the truth: k has no far field; 3 w h doubles. */
GP_MUST_CHECK gp_status gp_beyond_add_exact(const struct gp_log *log,
    const struct gp_beyond *b, const struct gp_kernel *k, double *layer);

/* Pixels that MIRROR mirrors on each side: a quarter of the shorter side. A
 * kernel is made for frames larger by twice that. */
int gp_mirror_reach(int w, int h);

/* Pixels around a picture that show its mirror image or, where a turn has so many
 * columns, what is on its other side. */
struct gp_margin {
    int x, y, turn;
};

/* The margin of a picture of w x h pixels and a kernel: none, all 0, but for MIRROR, and
 * where samples go around. */
struct gp_margin gp_margin_of(const struct gp_surround *edges,
                              const struct gp_kernel *k, int w, int h);

/* Adds what a margin shows of sources. Free with gp_sources_free(). */
GP_MUST_CHECK gp_status gp_mirror_sources(const struct gp_log *log,
                                          const struct gp_sources *src,
                                          const struct gp_margin *m,
                                          struct gp_sources *out);

/* A picture and its margin. */
struct gp_mirrored {
    struct gp_surround edges; // of the larger picture: a mirror image EXTENDs
    struct gp_sources src, picture, own;
    struct gp_planes rgb;
};

/* Adds the margin to `src`, the sources of `edges`, and to planes of its size unless `rgb`
 * is NULL. Free with gp_mirrored_free(), on failure too. */
GP_MUST_CHECK gp_status gp_mirror(const struct gp_log *log,
                                  const struct gp_surround *edges,
                                  const struct gp_sources *src,
                                  const struct gp_planes *rgb,
                                  const struct gp_margin *margin,
                                  struct gp_mirrored *out);
void gp_mirrored_free(struct gp_mirrored *m);

#endif
