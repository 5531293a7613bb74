/* Objects in groups of those that lie beside each other: a test asks a group's
 * bounds first, and its objects 16 at once where these do not decide.
 *
 * Every test gives each object what the test of it alone gives: gp_umbra_holds(),
 * gp_volume_misses(), gp_reach_too_far(), gp_reach_beside(). */
#ifndef GP_SCENE_GROUPS_H
#define GP_SCENE_GROUPS_H

#include "scene/umbra.h"

enum { GP_PACK = 16 };

/* Boxes side by side: centres and half sides of GP_PACK of them. */
struct gp_pack {
    const double *at[3], *half[3]; // borrowed; numbers in unused ones too
    unsigned used;                 // bit i: box i counts
    // bounds of those that count
    struct gp_v3 middle, reach;    // centre and half sides of a box around all
    struct gp_v3 centre;           // of a box around their centres
    struct gp_v3 inner;            // its half sides less the least of theirs:
                                   // under 0 where all hold the centre
    double apart;                  // radius of a sphere around their centres
    double round;                  // that rounding may move a point by
};

/* Umbras and planes that decided for packs before: they often decide for the
 * next one, which is beside these. Zero at first; no result depends on it. */
struct gp_pack_hint {
    int held;                           // the umbra that held all of a pack
    unsigned char out_by[GP_OCCLUDERS]; // planes of umbras that held none of it
};

/* Return the bits of `in`, of boxes that count, whose box
 *   held    is in one of the umbras
 *   missed  cannot meet the volume */
unsigned gp_pack_held(const struct gp_pack *p, const struct gp_umbras *u,
                      unsigned in, struct gp_pack_hint *hint);
unsigned gp_pack_missed(const struct gp_pack *p, const struct gp_volume *v,
                        unsigned in);

/* Objects of a scene, in the order of a curve through space (Morton 1966). */
struct gp_groups {
    int n;                    // groups
    struct gp_pack *pack;     // owned
    int *object;              // owned; GP_PACK a group
    double *at[3], *half[3];  // owned; GP_PACK a group, as are the next
    double *wide[3];          // owned; half sides, widened
    double *radius;           // owned; of spheres around boxes
    double *size;             // owned; gp_darkest_size()
    double *largest;          // owned; size of a group
    bool *near;               // owned; a group may be in the light's range
};

/* Groups the objects that have a box.
 *   out  empty on failure; free with gp_groups_free()
 * Errors: GP_ERR_BUG memory is full. */
GP_MUST_CHECK gp_status gp_groups_make(const struct gp_log *log,
                                       const struct gp_scene *s,
                                       const struct gp_bodies *bodies,
                                       struct gp_groups *out);
void gp_groups_free(struct gp_groups *g);

/* Sets near[] of the groups of which a box may be in a light's range. */
void gp_groups_near(struct gp_groups *g, const struct gp_reach *light);

/* Returns bits of the objects of a group that are in a light's range and cone. */
unsigned gp_groups_reached(const struct gp_groups *g, int group,
                           const struct gp_reach *light);

/* Keeps those of `in` that are among the largest occluders. */
void gp_groups_darkest(const struct gp_groups *g, int group, unsigned in,
                       const struct gp_reach *light, struct gp_darkest *most);

/* Returns a group's boxes, widened as by gp_texel_widen(); they last until the
 * group is widened again. */
struct gp_pack gp_groups_widen(struct gp_groups *g, int group,
                               const struct gp_reach *light, double texel);

#endif
