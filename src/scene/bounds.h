// SPDX-License-Identifier: Apache-2.0
/* Boxes of the world, and points of the scene. */
#ifndef GP_SCENE_BOUNDS_H
#define GP_SCENE_BOUNDS_H

#include "core/minmax.h"
#include "scene/scene.h"

#define GP_BOX_EMPTY                                                          \
    ((struct gp_box) {{INFINITY, INFINITY, INFINITY},                         \
                      {-INFINITY, -INFINITY, -INFINITY}})

static inline bool gp_box_empty(struct gp_box b)
{
    return !(b.lo.x <= b.hi.x && b.lo.y <= b.hi.y && b.lo.z <= b.hi.z);
}

/* Returns corner i of 8: bit 0 is x, 1 y, 2 z; set is the high side. */
static inline struct gp_v3 gp_box_corner(const struct gp_box *b, int i)
{
    return (struct gp_v3) {i & 1 ? b->hi.x : b->lo.x, i & 2 ? b->hi.y : b->lo.y,
                           i & 4 ? b->hi.z : b->lo.z};
}

/* Returns the middle of a box, and half its sides. */
static inline struct gp_v3 gp_box_middle(const struct gp_box *b)
{
    return gp_v3_scale(gp_v3_add(b->lo, b->hi), 0.5);
}

static inline struct gp_v3 gp_box_half(const struct gp_box *b)
{
    return gp_v3_scale(gp_v3_sub(b->hi, b->lo), 0.5);
}

/* Returns the smallest box that holds a and b, of which either may be empty. */
static inline struct gp_box gp_box_join(struct gp_box a, struct gp_box b)
{
    return (struct gp_box) {
        {gp_mind(a.lo.x, b.lo.x), gp_mind(a.lo.y, b.lo.y),
         gp_mind(a.lo.z, b.lo.z)},
        {gp_maxd(a.hi.x, b.hi.x), gp_maxd(a.hi.y, b.hi.y),
         gp_maxd(a.hi.z, b.hi.z)},
    };
}

/* Returns the smallest box that holds b and p. */
static inline struct gp_box gp_box_with(struct gp_box b, struct gp_v3 p)
{
    return gp_box_join(b, (struct gp_box) {p, p});
}

/* Returns p' = p * m for an affine matrix of row vectors. */
static inline struct gp_v3 gp_move(const double m[16], struct gp_v3 p)
{
    return (struct gp_v3) {
        p.x * m[0] + p.y * m[4] + p.z * m[8] + m[12],
        p.x * m[1] + p.y * m[5] + p.z * m[9] + m[13],
        p.x * m[2] + p.y * m[6] + p.z * m[10] + m[14],
    };
}

/* Returns vertex v of the scene, in its mesh's space. */
static inline struct gp_v3 gp_scene_vertex(const struct gp_scene *s, uint32_t v)
{
    const float *const p = &s->position[3 * (size_t) v];
    return (struct gp_v3) {(double) p[0], (double) p[1], (double) p[2]};
}

#endif
