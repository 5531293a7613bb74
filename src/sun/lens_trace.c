// SPDX-License-Identifier: Apache-2.0
/* Rays through the spheres of a lens, and meshes of them. Source: Hullin,
 * Eisemann, Seidel and Lee, Physically-Based Real-Time Lens Flare Rendering,
 * 2011: a sparse grid of rays for each ghost, whose cells carry the light. */
#include "sun/lens_priv.h"

#include "core/cpu.h"
#include "core/maths.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

// -- the lens at a wavelength -------------------------------------------------

void gp_lens_optics_make(const struct gp_lens *lens, double nm,
                         struct gp_lens_optics *out)
{
    out->lens = lens;
    out->nm = nm;
    out->n[0] = 1.0;
    out->z[0] = 0.0;
    for (int i = 0; i < lens->n; i++) {
        const struct gp_lens_surface *const s = &lens->at[i];
        out->n[i + 1] = gp_lens_index(s->n, s->v, nm);
        out->z[i + 1] = out->z[i] + s->gap;
        float *const table = out->reflected[i];
        for (int k = 0; k <= GP_LENS_TABLE; k++)
            table[k] = (float) gp_lens_reflected(
                lens, i, k / (double) GP_LENS_TABLE, nm);
        table[GP_LENS_TABLE + 1] = table[GP_LENS_TABLE];
    }
}

// -- rays ---------------------------------------------------------------------

/* Rays that are traced side by side. */
enum { LANES = 8 };

struct rays {
    double x[LANES], y[LANES], z[LANES];    // z from the surface's vertex
    double dx[LANES], dy[LANES], dz[LANES];
    double rim2[LANES], through[LANES], passed[LANES];
    double cosine[LANES];                   // in the thinner medium
    double arrives[LANES];                  // 1, or 0
};

#define INLINE static inline __attribute__((always_inline)) // also in clones

/* Moves rays to a surface: to the plane of the vertex, then to the root of the
 * sphere nearest to it, in the form without loss. */
INLINE void meet(double curvature, struct rays *r)
{
    for (int l = 0; l < LANES; l++) {
        const double plane = -r->z[l] / r->dz[l];
        const double x = r->x[l] + plane * r->dx[l];
        const double y = r->y[l] + plane * r->dy[l];
        const double b = curvature * (x * r->dx[l] + y * r->dy[l]) - r->dz[l];
        const double q = 0.5 * curvature * (x * x + y * y);
        const double root = b * b - 2.0 * curvature * q;
        const double far = sqrt(root > 0.0 ? root : 0.0);
        const double t = 2.0 * q / (-b + (b < 0.0 ? far : -far));
        r->x[l] = x + t * r->dx[l];
        r->y[l] = y + t * r->dy[l];
        r->z[l] = t * r->dz[l];
        r->arrives[l] = root >= 0.0 && t - t == 0.0 ? r->arrives[l] : 0.0;
    }
}

/* Bends or mirrors rays at their places on a surface. `back`: to the front of
 * the lens they must go. */
INLINE void bend(double curvature, double ratio, bool mirrors, bool back,
                 struct rays *r)
{
    const double keep = mirrors ? 1.0 : ratio, ahead = back ? -1.0 : 1.0;
    const double least = mirrors ? -INFINITY : 0.0; // under it all is reflected
    for (int l = 0; l < LANES; l++) {
        const double nx = curvature * r->x[l], ny = curvature * r->y[l];
        const double nz = curvature * r->z[l] - 1.0;
        const double dot = -(r->dx[l] * nx + r->dy[l] * ny + r->dz[l] * nz);
        const double side = dot < 0.0 ? -1.0 : 1.0; // against the ray
        const double cosine = side * dot;
        const double left = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        const double after = sqrt(left > 0.0 ? left : 0.0);
        const double bent = ratio * cosine - after;
        const double along = side * (mirrors ? 2.0 * cosine : bent);
        const double thinner = ratio < 1.0 ? cosine : after;
        r->cosine[l] = thinner < 1.0 ? thinner : 1.0;
        r->dx[l] = keep * r->dx[l] + along * nx;
        r->dy[l] = keep * r->dy[l] + along * ny;
        r->dz[l] = keep * r->dz[l] + along * nz;
        // far outside the rim a ray may turn round
        r->arrives[l] = left > least ? r->arrives[l] : 0.0;
        r->arrives[l] = ahead * r->dz[l] > 0.0 ? r->arrives[l] : 0.0;
    }
}

/* Takes what a surface reflects of the light, or what it lets through: never
 * nothing, so that a mesh sees the ghosts that one of its wavelengths lacks. */
INLINE void dim(const float *table, bool mirrors, struct rays *r)
{
    for (int l = 0; l < LANES; l++) {
        // (not a number, of a ray that does not arrive)
        const float at = r->arrives[l] > 0.0
                             ? (float) r->cosine[l] * GP_LENS_TABLE : 0.0f;
        const int k = (int) at;
        const float share = table[k] + (at - (float) k) *
                                           (table[k + 1] - table[k]);
        const double left = mirrors ? 1.0 : 1.0 - (double) share;
        r->through[l] *= mirrors ? fmax((double) share, 1e-6) : left;
        r->passed[l] *= left;
    }
}

/* A path at one wavelength, made ready for many rays. */
struct leg {
    double curvature, per_semi2, before, ratio; // before: z from the last one
    const float *reflected;
    bool stop, rim, mirrors, back; // back: after it light goes to the front
};
struct route {
    int steps;
    double to_sensor, per_semi; // per_semi: of the stop
    double z[GP_LENS_STEPS + 1];
    struct leg leg[GP_LENS_STEPS];
};

static void make_route(const struct gp_lens_optics *o,
                       const struct gp_lens_path *path, struct route *out)
{
    const struct gp_lens *const lens = o->lens;
    double z = 0.0;
    out->steps = path->steps;
    for (int k = 0; k < path->steps; k++) {
        const struct gp_lens_step s = path->step[k];
        const struct gp_lens_surface *const surface = &lens->at[s.surface];
        const bool stop = s.surface == lens->stop;
        out->z[k] = o->z[s.surface];
        out->leg[k] = (struct leg) {
            surface->curvature,
            1.0 / (surface->semi * surface->semi),
            out->z[k] - z,
            o->n[s.surface + s.back] / o->n[s.surface + 1 - s.back],
            o->reflected[s.surface],
            stop,
            !stop || lens->says.blades == 0,
            s.reflects,
            s.back != s.reflects,
        };
        z = out->z[k];
    }
    out->z[path->steps] = o->z[lens->n];
    out->to_sensor = o->z[lens->n] - z;
    out->per_semi = 1.0 / lens->at[lens->stop].semi;
}

/* Traces rays from the plane of the first surface to the sensor. `at`, if not
 * NULL, gets the points of the first. */
GP_CLONES static void trace(const struct route *route, struct rays *r,
                            struct gp_lens_hit hit[LANES], double (*at)[3])
{
    const double far = 1e6; // mm
    int passes = 0, turns = 0;
    for (int l = 0; l < LANES; l++) {
        r->rim2[l] = 0.0;
        r->through[l] = r->passed[l] = r->arrives[l] = 1.0;
        hit[l] = (struct gp_lens_hit) {.through = -1.0f};
    }
    for (int k = 0; k < route->steps; k++) {
        const struct leg *const leg = &route->leg[k];
        const double rim = leg->rim ? leg->per_semi2 : 0.0;
        double any = 0.0;
        for (int l = 0; l < LANES; l++)
            r->z[l] -= leg->before;
        meet(leg->curvature, r);
        for (int l = 0; l < LANES; l++) {
            const double height2 = (r->x[l] * r->x[l] + r->y[l] * r->y[l]) *
                                   rim;
            r->rim2[l] = height2 > r->rim2[l] ? height2 : r->rim2[l];
            any += r->arrives[l];
        }
        if (!(any > 0.0))
            return;
        if (at) {
            at[k][0] = r->x[0];
            at[k][1] = r->y[0];
            at[k][2] = r->z[0] + route->z[k];
        }
        if (leg->stop) {
            for (int l = 0; l < LANES; l++) {
                hit[l].stop[passes][0] = (float) (r->x[l] * route->per_semi);
                hit[l].stop[passes][1] = (float) (r->y[l] * route->per_semi);
            }
            passes++;
            continue;
        }
        bend(leg->curvature, leg->ratio, leg->mirrors, leg->back, r);
        dim(leg->reflected, leg->mirrors, r);
        for (int l = 0; l < LANES && leg->mirrors; l++)
            hit[l].cosine[turns] = (float) r->cosine[l];
        turns += leg->mirrors;
    }
    for (int l = 0; l < LANES; l++) {
        const double t = (route->to_sensor - r->z[l]) / r->dz[l];
        const double x = r->x[l] + t * r->dx[l], y = r->y[l] + t * r->dy[l];
        if (!(r->arrives[l] > 0.0 && fabs(x) < far && fabs(y) < far)) {
            hit[l] = (struct gp_lens_hit) {.through = -1.0f};
            continue;
        }
        hit[l].x = x;
        hit[l].y = y;
        hit[l].through = (float) r->through[l];
        hit[l].passed = (float) r->passed[l];
        hit[l].rim = (float) (r->rim2[l] < 1e12 ? sqrt(r->rim2[l]) : 1e6);
    }
    if (at) {
        at[route->steps][0] = hit[0].x;
        at[route->steps][1] = hit[0].y;
        at[route->steps][2] = route->z[route->steps];
    }
}

/* Puts a ray of slope u at (x, y) before the lens. */
static void start(struct rays *r, int lane, double x, double y, double u)
{
    const double length = sqrt(1.0 + u * u);
    r->x[lane] = x;
    r->y[lane] = y;
    r->z[lane] = 0.0;
    r->dx[lane] = u / length;
    r->dy[lane] = 0.0;
    r->dz[lane] = 1.0 / length;
}

struct gp_lens_hit gp_lens_trace(const struct gp_lens_optics *o,
    const struct gp_lens_path *path, double x, double y, double u,
    double (*at)[3])
{
    struct gp_lens_hit hit[LANES];
    struct route route;
    struct rays r;
    make_route(o, path, &route);
    for (int l = 0; l < LANES; l++)
        start(&r, l, x, y, u);
    trace(&route, &r, hit, at);
    return hit[0];
}

// -- the outline of the light -------------------------------------------------

struct gp_lens_blades gp_lens_blades_of(const struct gp_lens *lens,
                                        double angle)
{
    struct gp_lens_blades b = {.n = lens->says.blades};
    for (int i = 0; i < b.n; i++) {
        // counter-clockwise as seen, where y points down
        const double a = (2.0 * i + 1.0) * M_PI / b.n -
                         lens->turn * M_PI / 180.0 - angle;
        b.normal[i][0] = gp_cos(a);
        b.normal[i][1] = gp_sin(a);
    }
    b.apothem = b.n ? gp_cos(M_PI / b.n) : 0.0;
    return b;
}

/* Cuts by one limit: a blade's, that of the rims where `normal` is NULL. Source:
 * Sutherland and Hodgman 1974. */
static int cut_by(union gp_lens_corner *c, int n, int pass,
                  const double *normal, double apothem)
{
    union gp_lens_corner out[GP_LENS_CORNERS];
    double e[GP_LENS_CORNERS];
    int m = 0;
    bool cuts = false;
    for (int i = 0; i < n; i++) {
        const double *const stop = c[i].stop[pass];
        e[i] = normal ? normal[0] * stop[0] + normal[1] * stop[1] - apothem
                      : c[i].rim - 1.0; // over 0: outside
        cuts = cuts || e[i] > 0.0;
    }
    if (!cuts)
        return n;
    for (int i = 0; i < n && m + 2 < GP_LENS_CORNERS; i++) {
        const int next = i + 1 < n ? i + 1 : 0;
        if (e[i] <= 0.0)
            out[m++] = c[i];
        if ((e[i] <= 0.0) == (e[next] <= 0.0))
            continue;
        const double t = e[i] / (e[i] - e[next]);
        for (size_t k = 0; k < sizeof c->all / sizeof *c->all; k++)
            out[m].all[k] = c[i].all[k] + t * (c[next].all[k] - c[i].all[k]);
        m++;
    }
    memcpy(c, out, (size_t) m * sizeof *c);
    return m < 3 ? 0 : m;
}

int gp_lens_cut(const struct gp_lens_blades *blades, int passes,
                union gp_lens_corner c[GP_LENS_CORNERS])
{
    int n = cut_by(c, 4, 0, NULL, 0.0);
    for (int pass = 0; pass < passes; pass++) {
        for (int i = 0; i < blades->n && n; i++)
            n = cut_by(c, n, pass, blades->normal[i], blades->apothem);
    }
    return n;
}

double gp_lens_piece(const union gp_lens_corner *c, int n,
                     const union gp_lens_corner *from,
                     const union gp_lens_corner *to, double share[4])
{
    const double wide = to->p - from->p, high = to->q - from->q;
    double area = 0.0, s = 0.0, t = 0.0; // in cells
    for (int i = 0; i < n; i++) {
        const union gp_lens_corner *const a = &c[i], *const b = &c[(i + 1) % n];
        const double sa = (a->p - from->p) / wide, sb = (b->p - from->p) / wide;
        const double ta = (a->q - from->q) / high, tb = (b->q - from->q) / high;
        const double part = 0.5 * (sa * tb - sb * ta);
        area += part;
        s += part * (sa + sb) / 3.0;
        t += part * (ta + tb) / 3.0;
    }
    s = area > 0.0 ? fmin(s / area, 1.0) : 0.5;
    t = area > 0.0 ? fmin(t / area, 1.0) : 0.5;
    share[0] = (1.0 - s) * (1.0 - t);
    share[1] = s * (1.0 - t);
    share[2] = s * t;
    share[3] = (1.0 - s) * t;
    return fabs(area * wide * high);
}

// -- meshes -------------------------------------------------------------------

/* Half of a grid's rays, of one wavelength. `near`, if not NULL, has those of
 * another one: rays far outside its rims are not traced. */
static void trace_rays(const struct gp_lens_optics *o,
                       const struct gp_lens_path *path, double u,
                       const struct gp_lens_mesh *m,
                       const struct gp_lens_hit *near, struct gp_lens_hit *hit)
{
    const float far = 1.5f;
    const int across = m->cells + 1, n = across * (m->cells / 2 + 1);
    struct gp_lens_hit own[LANES];
    struct route route;
    struct rays r;
    int at[LANES], waiting = 0;
    make_route(o, path, &route);
    for (int i = 0; i < n; i++) {
        if (near && (near[i].through < 0.0f || near[i].rim > far)) {
            hit[i] = near[i];
        } else {
            at[waiting] = i;
            start(&r, waiting++, m->x0 + (m->x1 - m->x0) * (i % across) /
                                             m->cells,
                  m->y1 * (i / across) / (m->cells / 2), u);
        }
        if (waiting < LANES && (waiting == 0 || i + 1 < n))
            continue;
        for (int l = waiting; l < LANES; l++)
            start(&r, l, 0.0, 0.0, u);
        trace(&route, &r, own, NULL);
        for (int l = 0; l < waiting; l++)
            hit[at[l]] = own[l];
        waiting = 0;
    }
}

union gp_lens_corner gp_lens_corner_of(const struct gp_lens_hit *h, double p,
                                        double q, double sign)
{
    union gp_lens_corner c = {
        .p = p, .q = sign * q, .x = h->x, .y = h->y, .rim = (double) h->rim};
    for (int k = 0; k < GP_LENS_PASSES; k++) {
        c.stop[k][0] = (double) h->stop[k][0];
        c.stop[k][1] = sign * (double) h->stop[k][1];
    }
    return c;
}

/* Light that arrives through half of a mesh of one wavelength, and the area
 * that it covers. `every`: rays between those that are used. `weigh`, if not
 * NULL, gets the weights of rays. */
struct sum {
    double light, area, lost;
};
static struct sum sum_of(const struct gp_lens_mesh *m,
                         const struct gp_lens_blades *blades,
                         const struct gp_lens_hit *hit, int every,
                         struct gp_lens_hit *weigh)
{
    struct sum sum = {0};
    const int w = m->cells + 1;
    const double dx = (m->x1 - m->x0) / m->cells;
    const double dy = m->y1 / (m->cells / 2);
    // blades need not be the mirror of themselves
    const int halves = blades->n ? 2 : 1, both = 3 - halves;
    for (int half = 0; half < halves; half++) {
        const double sign = half ? -1.0 : 1.0;
        for (int j = 0; j + every <= m->cells / 2; j += every) {
            for (int i = 0; i + every <= m->cells; i += every) {
                const struct gp_lens_hit *h[4];
                union gp_lens_corner c[GP_LENS_CORNERS];
                bool arrives = true, clear = true;
                for (int k = 0; k < 4; k++) {
                    const int x = i + (k == 1 || k == 2 ? every : 0);
                    const int y = j + (k >= 2 ? every : 0);
                    h[k] = &hit[y * w + x];
                    arrives = arrives && h[k]->through >= 0.0f;
                    clear = clear && gp_lens_is_clear(blades, m->passes, h[k]);
                    c[k] =
                        gp_lens_corner_of(h[k], m->x0 + dx * x, dy * y, sign);
                }
                // a cell that is not drawn has half of the light of its rays that
                // arrive: towards total reflection nothing passes
                for (int k = 0; k < 4 && !arrives; k++) {
                    const double area = 0.25 * both * dx * dy * every * every;
                    if (h[k]->through < 0.0f ||
                        !gp_lens_is_clear(blades, m->passes, h[k]))
                        continue;
                    sum.lost += area * (double) h[k]->through;
                    if (weigh)
                        weigh[h[k] - hit].weight[1] += (float) (0.5 * area);
                }
                if (!arrives)
                    continue;
                const union gp_lens_corner from = c[0], to = c[2];
                const int n = clear ? 4 : gp_lens_cut(blades, m->passes, c);
                double after = 0.0, share[4];
                const double area = gp_lens_piece(c, n, &from, &to, share);
                for (int k = 0; k < n; k++) {
                    const union gp_lens_corner *const a = &c[k];
                    const union gp_lens_corner *const b = &c[(k + 1) % n];
                    after += 0.5 * (a->x * b->y - b->x * a->y);
                }
                sum.area += both * fabs(after);
                for (int k = 0; k < 4; k++) {
                    const double own = both * area * share[k];
                    sum.light += own * (double) h[k]->through;
                    for (int e = 0; e < 2 && weigh; e++)
                        weigh[h[k] - hit].weight[e] += (float) own;
                }
            }
        }
    }
    return sum;
}

/* Returns true when a ray of the middle of the light arrives. */
static bool passes(const struct gp_lens_hit *h)
{
    const float stop = h->stop[0][0] * h->stop[0][0] +
                       h->stop[0][1] * h->stop[0][1];
    return h->through >= 0.0f && h->rim < 1.0f && stop < 1.0f;
}

/* Returns the largest distance from the axis, on the plane of the front's vertex,
 * of light of slope u that passes its rim: to one behind the plane it still goes
 * towards the axis. */
static double front_of(const struct gp_lens_surface *s, double u)
{
    const double c = fabs(s->curvature), flat = c * s->semi;
    return s->semi +
           u * flat * s->semi / (1.0 + sqrt(fmax(1.0 - flat * flat, 0.0)));
}

/* Fits a mesh to the rays that pass, and one cell more on each side; the front
 * ends it. Returns false where the mesh ended before the light did; no `cells`:
 * none passes. */
static bool fit(const struct gp_lens_hit *hit, double front,
                struct gp_lens_mesh *m)
{
    const int w = m->cells + 1, h = m->cells / 2 + 1;
    const double dx = (m->x1 - m->x0) / m->cells, dy = m->y1 / (h - 1);
    const double left = m->x0;
    int x0 = w, x1 = -1, y1 = -1;
    for (int j = 0; j < h; j++) {
        for (int i = 0; i < w; i++) {
            if (!passes(&hit[j * w + i]))
                continue;
            x0 = i < x0 ? i : x0;
            x1 = i > x1 ? i : x1;
            y1 = j;
        }
    }
    if (x1 < 0) { // between the rays, if at all
        m->cells = 0;
        return true;
    }
    const bool whole = x0 > 0 && x1 < w - 1 && y1 < h - 1;
    m->x0 = fmax(left + dx * (x0 > 0 ? x0 - 1 : -w / 4), -1.05 * front);
    m->x1 = fmin(left + dx * (x1 < w - 1 ? x1 + 1 : w + w / 4), 1.05 * front);
    m->y1 = fmin(dy * (y1 < h - 1 ? y1 + 1 : h + h / 2), 1.05 * front);
    return whole;
}

/* The rays that may arrive, by first order: a box around what all rims' discs
 * share, each a tenth wider. */
static void place_mesh(const struct gp_lens *lens,
                       const struct gp_lens_path *path, double nm, double u,
                       struct gp_lens_mesh *m)
{
    const double wider = 1.1;
    m->x0 = -INFINITY;
    m->x1 = m->y1 = INFINITY;
    for (int k = 0; k < path->steps; k++) {
        const struct gp_lens_matrix a = gp_lens_matrix(lens, path, k + 1, nm);
        const double semi = lens->at[path->step[k].surface].semi;
        m->passes += path->step[k].surface == lens->stop;
        if (!(fabs(a.a) * 1e6 > semi))
            continue;
        const double radius = wider * semi / fabs(a.a);
        const double middle = -a.b / a.a * u;
        m->x0 = fmax(m->x0, middle - radius);
        m->x1 = fmin(m->x1, middle + radius);
        m->y1 = fmin(m->y1, radius);
    }
}

/* Widens a mesh by the rays that pass anywhere on the front: strong aberration has
 * light far from where first order has it, or where that has none. */
static void widen_mesh(const struct gp_lens_optics *o,
                       const struct gp_lens_path *path, double u, double front,
                       struct gp_lens_hit *hit, struct gp_lens_mesh *m)
{
    struct gp_lens_mesh all = {
        .cells = 16, .x0 = -front, .x1 = front, .y1 = front};
    const bool empty = !(m->x0 < m->x1);
    trace_rays(o, path, u, &all, NULL, hit);
    fit(hit, front, &all);
    if (!all.cells)
        return;
    m->x0 = empty ? all.x0 : fmin(m->x0, all.x0);
    m->x1 = empty ? all.x1 : fmax(m->x1, all.x1);
    m->y1 = empty ? all.y1 : fmax(m->y1, all.y1);
}

/* Returns the largest distance, in mm on the sensor, of a ray that passes from
 * the middle of its two neighbours. A straight side of a cell is off by a
 * quarter of it. */
static double bend_of(const struct gp_lens_mesh *m,
                      const struct gp_lens_hit *hit)
{
    const int w = m->cells + 1, h = m->cells / 2 + 1;
    double bend = 0.0;
    for (int j = 0; j < h; j++) {
        for (int i = 0; i < w; i++) {
            const struct gp_lens_hit *const at = &hit[j * w + i];
            for (int down = 0; down < 2; down++) {
                const int beside = down ? w : 1;
                if (down ? j == 0 || j == h - 1 : i == 0 || i == w - 1)
                    continue;
                const struct gp_lens_hit *const a = at - beside;
                const struct gp_lens_hit *const b = at + beside;
                if (passes(a) && passes(at) && passes(b))
                    bend = fmax(bend, gp_hypot(at->x - 0.5 * (a->x + b->x),
                                               at->y - 0.5 * (a->y + b->y)));
            }
        }
    }
    return bend;
}

static size_t rays_in(int cells)
{
    return (size_t) (cells + 1) * (size_t) (cells / 2 + 1);
}

gp_status gp_lens_mesh_make(const struct gp_log *log,
    const struct gp_lens_optics *optics, const struct gp_lens_path *path,
    const struct gp_lens_blades *blades, double u, double tolerance,
    double step, struct gp_lens_mesh *out)
{
    enum { COARSE = 12, FIRST = 16, FITS = 5, MIDDLE = GP_LENS_NODES / 2 };
    const struct gp_lens *const lens = optics->lens;
    // coarser where an error of 1e-3 is allowed
    const bool coarse_will_do = !(tolerance < 1e-3);
    const int most = coarse_will_do ? GP_LENS_CELLS / 4 : GP_LENS_CELLS;
    const double cosine = 1.0 / sqrt(1.0 + u * u);
    const double front = front_of(&lens->at[0], u);
    struct gp_lens_mesh m = {.cells = COARSE};
    struct gp_lens_hit *hit = NULL;
    bool whole = false, enough = false;
    gp_status st;
    *out = (struct gp_lens_mesh) {0};
    place_mesh(lens, path, optics[MIDDLE].nm, u, &m);
    GP_TRY(gp_alloc(log, "rays of a lens", rays_in(most), sizeof *hit, &hit));
    widen_mesh(&optics[MIDDLE], path, u, front, hit, &m);
    if (!(m.x0 < m.x1))
        goto out;
    // aberrations reach beyond first order, or stay within
    for (int i = 0; i < FITS && !whole; i++) {
        trace_rays(&optics[MIDDLE], path, u, &m, NULL, hit);
        whole = fit(hit, front, &m);
    }
    for (m.cells = FIRST / 2; !enough;) {
        m.cells *= 2;
        trace_rays(&optics[MIDDLE], path, u, &m, NULL, hit);
        const struct sum fine = sum_of(&m, blades, hit, 1, NULL);
        const struct sum coarse = sum_of(&m, blades, hit, 2, NULL);
        if (!(fine.light > 0.0) && m.cells > FIRST)
            goto out;
        // cells that a lost ray cuts are the coarser, the more light they lose
        const double change =
            fmax(fabs(fine.light - coarse.light), fine.lost) / fine.light;
        const double wider = fabs(fine.area - coarse.area) / fine.area;
        // a change of the area of a disc of radius r moves its edge by half of
        // it times r, and the finer mesh is off by a third of the change: by
        // a step at most
        const double seen = 6.0 * step * sqrt(M_PI / fine.area);
        // cells whose sides show have facets, and those whose sizes differ a
        // grid
        const double straight =
            fmin(8.0 * step, 40.0 * tolerance * sqrt(fine.area) / m.cells);
        const bool smooth = coarse_will_do || bend_of(&m, hit) <= straight;
        enough = m.cells * 2 > most ||
                 (change <= 10.0 * tolerance &&
                  wider <= fmax(10.0 * tolerance, seen) && smooth);
        m.scale = 1.0 + (fine.light - coarse.light) / (3.0 * fine.light);
        m.scale = fmin(fmax(m.scale, 0.8), 1.25);
        m.lost = fine.lost * cosine;
    }
    // all wavelengths
    const size_t rays = rays_in(m.cells);
    GP_TRY(gp_alloc(log, "rays of a lens", rays * GP_LENS_NODES, sizeof *hit,
                    &m.hit));
    struct gp_lens_hit *const middle = m.hit + MIDDLE * rays;
    memcpy(middle, hit, rays * sizeof *hit);
    const double own_light = sum_of(&m, blades, middle, 1, middle).light;
    for (int k = 0; k < GP_LENS_NODES; k++) {
        struct gp_lens_hit *const own = m.hit + (size_t) k * rays;
        double drawn = 0.0; // through the middle's rims
        if (k != MIDDLE)
            trace_rays(&optics[k], path, u, &m, hit, own);
        for (size_t i = 0; i < rays; i++)
            drawn +=
                (double) (middle[i].weight[0] * fmaxf(own[i].through, 0.0f));
        const double light =
            k == MIDDLE ? own_light : sum_of(&m, blades, own, 1, NULL).light;
        m.root[k] = drawn > 0.0 ? sqrt(light / drawn) : 1.0;
        m.flux[k] = light * cosine * m.scale;
    }
    *out = m;
out:
    gp_free(hit);
    return st;
}

void gp_lens_mesh_free(struct gp_lens_mesh *m)
{
    gp_free(m->hit);
    *m = (struct gp_lens_mesh) {0};
}
