// SPDX-License-Identifier: Apache-2.0
/* Rays through scenes in memory, triangle by triangle, for what sets must not
 * lose. Triangles have two sides; texels of cutouts are taken as squares. */
#ifndef GP_TESTS_SCENE_RAYS_H
#define GP_TESTS_SCENE_RAYS_H

#include "scene_made.h"

/* A hit at from + t * to. */
struct ray_hit {
    int object; // -1: none
    double t;
};

/* True where a part is opaque at barycentric (u, v) of the triangle at index
 * i. */
static inline bool ray_opaque(const struct gp_scene *s,
                              const struct gp_submesh *p, int i, double u,
                              double v)
{
    const struct gp_material *const m = &s->material[p->material];
    if (m->cutout < 0 || !(m->cutoff > 0.0f))
        return m->base[3] >= m->cutoff;
    const struct gp_cutout *const c = &s->cutout[m->cutout];
    const float *const a = &s->uv[2 * s->index[i]],
                *const b = &s->uv[2 * s->index[i + 1]],
                *const d = &s->uv[2 * s->index[i + 2]];
    const double at[2] = {
        (double) a[0] * (1 - u - v) + (double) b[0] * u + (double) d[0] * v,
        (double) a[1] * (1 - u - v) + (double) b[1] * u + (double) d[1] * v};
    const int x = (int) fmin(c->w - 1, fmax(0.0, floor(at[0] * c->w)));
    const int y = (int) fmin(c->h - 1, fmax(0.0, floor(at[1] * c->h)));
    return m->base[3] * (float) c->alpha[y * c->w + x] >=
           65535.0f * m->cutoff;
}

/* The hit of one object with the least t in (t0, t1) (Moeller and Trumbore
 * 1997). */
static inline double ray_object(const struct gp_scene *s,
                                const struct gp_object *o, struct gp_v3 from,
                                struct gp_v3 to, double t0, double t1)
{
    // the nearest point of the line to the centre of the sphere
    const struct gp_v3 w = gp_v3_sub(gp_box_middle(&o->box), from);
    const double along = gp_v3_dot(w, to) / gp_v3_dot(to, to);
    const struct gp_v3 off = gp_v3_sub(w, gp_v3_scale(to, along));
    if (gp_v3_dot(off, off) > o->radius * o->radius)
        return INFINITY;
    double first = INFINITY;
    const struct gp_mesh *const m = &s->mesh[o->mesh];
    for (int k = m->first; k < m->first + m->submeshes; k++) {
        const struct gp_submesh *const p = &s->submesh[k];
        for (int i = p->first; i < p->first + p->count; i += 3) {
            const struct gp_v3 a = made_corner(s, o, i),
                               b = gp_v3_sub(made_corner(s, o, i + 1), a),
                               c = gp_v3_sub(made_corner(s, o, i + 2), a);
            const struct gp_v3 h = gp_v3_cross(to, c);
            const double det = gp_v3_dot(b, h);
            if (det == 0.0)
                continue;
            const struct gp_v3 d = gp_v3_sub(from, a), q = gp_v3_cross(d, b);
            const double u = gp_v3_dot(d, h) / det, v = gp_v3_dot(to, q) / det;
            const double t = gp_v3_dot(c, q) / det;
            if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > t0 && t < t1 &&
                t < first && ray_opaque(s, p, i, u, v))
                first = t;
        }
    }
    return first;
}

/* The first hit of all objects. */
static inline struct ray_hit ray_scene(const struct gp_scene *s,
                                       struct gp_v3 from, struct gp_v3 to,
                                       double t0, double t1)
{
    struct ray_hit hit = {-1, t1};
    for (int i = 0; i < s->objects; i++) {
        const double t = ray_object(s, &s->object[i], from, to, t0, hit.t);
        if (t < hit.t)
            hit = (struct ray_hit) {i, t};
    }
    return hit;
}

#endif
