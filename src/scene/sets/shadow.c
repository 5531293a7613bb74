/* Maps of shadows: one square for spots and suns, six of one atlas for points.
 * Depth is reversed, as in gl: near / distance, of a sun from 1 to 0. */
#include "scene/sets/sets_priv.h"

#include <math.h>
#include <string.h>

/* Sets two unit vectors that are upright to `along` and to each other. */
static void set_axes(struct gp_v3 along, struct gp_v3 *x, struct gp_v3 *y)
{
    const struct gp_v3 other = fabs(along.z) < 0.9 ? (struct gp_v3) {0, 0, 1}
                                                   : (struct gp_v3) {1, 0, 0};
    *x = gp_v3_unit(gp_v3_cross(other, along));
    *y = gp_v3_cross(along, *x);
}

/* Columns of a matrix for row vectors: clip x, y, z, w. */
static void set_columns(double m[16], const double column[4][4])
{
    for (int r = 0; r < 4; r++) {
        for (int c = 0; c < 4; c++)
            m[4 * r + c] = column[c][r];
    }
}

static void lay_spot(const struct gp_scene_light *l, struct gp_shadow_map *m)
{
    // a texel around the cone, as light.frag reads neighbours
    const double k = (m->side - 2.0) / m->side / tan(fmax(l->outer, 1e-3));
    struct gp_v3 x, y;
    set_axes(l->along, &x, &y);
    set_columns(m->to_map, (const double[4][4]) {
        {k * x.x, k * x.y, k * x.z, 0.0},
        {k * y.x, k * y.y, k * y.z, 0.0},
        {0.0, 0.0, 0.0, m->near},
        {l->along.x, l->along.y, l->along.z, 0.0},
    });
    m->form_of[2] = (float) k;
}

/* Lays a sun's map over the lit box, as deep as the whole scene. */
static void lay_sun(const struct gp_draw_light *d, const struct gp_box *whole,
                    struct gp_shadow_map *m)
{
    const struct gp_v3 along = d->light->along, half = gp_box_half(&d->all);
    const struct gp_v3 middle = gp_v3_add(whole->lo, gp_box_half(whole));
    const double reach = fmax(gp_v3_length(half), 1e-6);
    const double deep = fmax(gp_v3_length(gp_box_half(whole)), 1e-6) * 1.001;
    const double k = (m->side - 2.0) / m->side / reach, s = 0.5 / deep;
    struct gp_v3 x, y;
    set_axes(along, &x, &y);
    m->origin = gp_v3_add(d->all.lo, half);
    const double at = gp_v3_dot(gp_v3_sub(m->origin, middle), along);
    set_columns(m->to_map, (const double[4][4]) {
        {k * x.x, k * x.y, k * x.z, 0.0},
        {k * y.x, k * y.y, k * y.z, 0.0},
        {-s * along.x, -s * along.y, -s * along.z, 0.5 - s * at},
        {0.0, 0.0, 0.0, 1.0},
    });
    m->form_of[1] = (float) (2.0 / (k * m->side));
    m->form_of[2] = (float) s;
}

static int squares_of(const struct gp_shadow_map *m)
{
    return m->form == GP_MAP_CUBE ? 6 : 1;
}

/* A point before the division: x / w and y / w are its place in a square. */
struct look {
    double x, y, w;
};

static struct look look_at(const struct gp_shadow_map *m, int face,
                           struct gp_v3 at)
{
    const struct gp_v3 p = gp_v3_sub(at, m->origin);
    const double *const t = m->to_map;
    if (m->form != GP_MAP_CUBE)
        return (struct look) {p.x * t[0] + p.y * t[4] + p.z * t[8] + t[12],
                              p.x * t[1] + p.y * t[5] + p.z * t[9] + t[13],
                              p.x * t[3] + p.y * t[7] + p.z * t[11] + t[15]};
    const double k = (m->side - 2.0) / m->side, q[3] = {p.x, p.y, p.z};
    const int axis = face >> 1; // as scene.vert
    return (struct look) {k * q[(axis + 1) % 3], k * q[(axis + 2) % 3],
                          face & 1 ? -q[axis] : q[axis]};
}

int gp_shadow_faces(const struct gp_shadow_map *m, const struct gp_box *box)
{
    const double wide = 1.0 + 4.0 / m->side; // a texel around each square
    int faces = 0;
    for (int face = 0; face < squares_of(m); face++) {
        bool out[5] = {true, true, true, true, true};
        for (int i = 0; i < 8; i++) {
            const struct look p = look_at(m, face, gp_box_corner(box, i));
            out[0] &= p.x < -wide * p.w;
            out[1] &= p.y < -wide * p.w;
            out[2] &= p.x > wide * p.w;
            out[3] &= p.y > wide * p.w;
            out[4] &= p.w < 0.0;
        }
        faces |= !(out[0] | out[1] | out[2] | out[3] | out[4]) << face;
    }
    return faces;
}

struct gp_shadow_map gp_shadow_map_of(const struct gp_draw_light *d,
                                      const struct gp_box *whole, int side)
{
    const struct gp_scene_light *const l = d->light;
    const bool narrow = l->kind == GP_LIGHT_SPOT && l->outer < 1.05;
    struct gp_shadow_map m = {
        .form = l->kind == GP_LIGHT_DIRECTIONAL ? GP_MAP_SUN
                : narrow ? GP_MAP_SPOT : GP_MAP_CUBE,
        .side = side, .origin = l->at,
        // reversed depth is as precise at every distance
        .near = isfinite(l->range) && l->range > 0.0 ? 1e-4 * l->range : 1e-3,
    };
    m.form_of[0] = (float) side;
    m.form_of[1] = (float) m.near;
    m.form_of[2] = 1.0f;
    if (m.form == GP_MAP_SUN)
        lay_sun(d, whole, &m);
    if (m.form == GP_MAP_SPOT)
        lay_spot(l, &m);
    return m;
}
