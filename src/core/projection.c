// SPDX-License-Identifier: Apache-2.0
#include "core/projection.h"

#include "core/cpu.h"
#include "core/maths.h"

#include <math.h>

struct gp_projection gp_projection_of(enum gp_projecting kind,
                                      struct gp_rect display, double aspect,
                                      double degrees)
{
    const double w = fmax(gp_rect_w(display), 1),
                 h = fmax(gp_rect_h(display), 1);
    const double radians = degrees * (M_PI / 180.0);
    struct gp_projection p = {
        .kind = kind,
        .x0 = gp_rect_middle(display, 0),
        .y0 = gp_rect_middle(display, 1),
    };
    if (kind == GP_LATLONG) {
        p.dx = 2.0 * M_PI / w;
        p.dy = M_PI / h;
        return p;
    }
    p.dy = kind == GP_PERSPECTIVE ? 2.0 * gp_tan(0.5 * radians) / h
           : kind == GP_EQUISOLID ? 4.0 * gp_sin(0.25 * radians) / h
                                  : radians / h;
    p.dx = aspect * p.dy;
    const double half = fmin(0.5 * fmax(radians, M_PI), M_PI);
    p.rim = kind == GP_FISHEYE     ? half
            : kind == GP_EQUISOLID ? 2.0 * gp_sin(0.5 * half)
                                   : 0.0;
    return p;
}

double gp_middle_degrees(double fov, double h)
{
    const double radians = fov * (M_PI / 180.0);
    return fov < 180.0 ? 2.0 * gp_tan(0.5 * radians) / h * (180.0 / M_PI)
                       : fov / h;
}

void gp_projection_pull(const struct gp_projection *p, double beyond,
                        double at[2])
{
    const double last = p->kind == GP_EQUISOLID ? 1.95 : 0.95 * M_PI;
    const double most = fmax(fmin(p->rim + beyond, last), p->rim);
    const double r = gp_hypot((at[0] - p->x0) * p->dx, (at[1] - p->y0) * p->dy);
    if (p->rim > 0.0 && r > most) {
        at[0] = p->x0 + (at[0] - p->x0) * most / r;
        at[1] = p->y0 + (at[1] - p->y0) * most / r;
    }
}

void gp_projection_span(const struct gp_projection *p, double x, double y,
                        int n, int span[2])
{
    const double v = (y - p->y0) * p->dy;
    span[0] = 0;
    span[1] = n;
    if (!(p->rim > 0.0))
        return;
    const double half = sqrt(fmax(p->rim * p->rim - v * v, 0.0)) / p->dx;
    span[0] = (int) fmin(fmax(ceil(p->x0 - half - x), 0.0), n);
    span[1] = (int) fmax(fmin(floor(p->x0 + half - x) + 1.0, n), span[0]);
    if (fabs(v) > p->rim)
        span[1] = span[0];
}

struct gp_v3 gp_projection_direction(const struct gp_projection *p, double x,
                                     double y)
{
    const double u = (x - p->x0) * p->dx, v = (y - p->y0) * p->dy;
    if (p->kind == GP_PERSPECTIVE) {
        const double s = 1.0 / sqrt(1.0 + u * u + v * v);
        return (struct gp_v3) {u * s, v * s, s};
    }
    if (p->kind == GP_LATLONG) {
        const double c = gp_cos(v);
        return (struct gp_v3) {c * gp_sin(u), gp_sin(v), c * gp_cos(u)};
    }
    const double r2 = u * u + v * v, r = sqrt(r2);
    if (p->kind == GP_EQUISOLID) { // sin t = r sqrt(1 - r^2 / 4)
        const double s = sqrt(fmax(1.0 - 0.25 * r2, 0.0));
        return (struct gp_v3) {u * s, v * s, 1.0 - 0.5 * r2};
    }
    const double s = r > 0.0 ? gp_sin(r) / r : 1.0;
    return (struct gp_v3) {u * s, v * s, gp_cos(r)};
}

bool gp_projection_place(const struct gp_projection *p, struct gp_v3 to,
                         double at[2])
{
    const double side = gp_hypot(to.x, to.y);
    double u = to.x, v = to.y;
    if (p->kind == GP_PERSPECTIVE) {
        u /= to.z;
        v /= to.z;
    } else if (p->kind == GP_LATLONG) {
        u = gp_atan2(to.x, to.z);
        v = gp_atan2(to.y, gp_hypot(to.x, to.z));
    } else {
        const double t = gp_atan2(side, to.z);
        const double r = p->kind == GP_EQUISOLID ? 2.0 * gp_sin(0.5 * t) : t;
        u = side > 0.0 ? u * (r / side) : r; // behind, any
        v = side > 0.0 ? v * (r / side) : 0.0;
        if (p->rim > 0.0 && r > p->rim)
            return false;
    }
    at[0] = p->x0 + u / p->dx;
    at[1] = p->y0 + v / p->dy;
    return p->kind != GP_PERSPECTIVE || to.z > 0.0;
}

struct gp_metric gp_projection_metric(const struct gp_projection *p, double x,
                                      double y)
{
    const double u = (x - p->x0) * p->dx, v = (y - p->y0) * p->dy;
    const double r2 = u * u + v * v;
    struct gp_metric g = {1.0, 0.0, 1.0}; // by u and v
    if (p->kind == GP_PERSPECTIVE) {
        const double n = 1.0 + r2, s = 1.0 / (n * n);
        g = (struct gp_metric) {s * (1.0 + v * v), -s * u * v,
                                s * (1.0 + u * u)};
    } else if (p->kind == GP_LATLONG) {
        const double c = gp_cos(v);
        g.xx = c * c;
    } else if (p->kind != GP_PLANE && r2 > 0.0) {
        // along the radius `along`, across it `across`, both squared
        const double r = sqrt(r2), sine = gp_sin(r) / r;
        const bool even = p->kind == GP_EQUISOLID;
        const double across = even ? 1.0 - 0.25 * r2 : sine * sine;
        const double along = even ? 1.0 / fmax(across, 1e-300) : 1.0;
        const double c = u / r, s = v / r;
        g = (struct gp_metric) {along * c * c + across * s * s,
                                (along - across) * c * s,
                                along * s * s + across * c * c};
    }
    g.xx *= p->dx * p->dx;
    g.xy *= p->dx * p->dy;
    g.yy *= p->dy * p->dy;
    return g;
}

double gp_projection_solid(const struct gp_projection *p, double x, double y)
{
    const double u = (x - p->x0) * p->dx, v = (y - p->y0) * p->dy;
    const double area = p->dx * p->dy, r2 = u * u + v * v;
    if (p->kind == GP_PERSPECTIVE) {
        const double n = 1.0 + r2;
        return area / (n * sqrt(n));
    }
    if (p->kind == GP_LATLONG)
        return area * fmax(gp_cos(v), 0.0);
    if (p->kind == GP_FISHEYE && r2 > 0.0)
        return area * fmax(gp_sin(sqrt(r2)), 0.0) / sqrt(r2);
    return area;
}

GP_CLONES static void fill_perspective(double u, double step, double vv,
                                       double area, int n, float *restrict row)
{
    for (int i = 0; i < n; i++) {
        const double at = u + i * step, m = 1.0 + vv + at * at;
        row[i] = (float) (area / (m * sqrt(m)));
    }
}

void gp_projection_solid_row(const struct gp_projection *p, double x, double y,
                             int n, float *row)
{
    const double v = (y - p->y0) * p->dy;
    if (p->kind == GP_PERSPECTIVE)
        fill_perspective((x - p->x0) * p->dx, p->dx, v * v, p->dx * p->dy, n,
                         row);
    else
        for (int i = 0; i < n; i++)
            row[i] = (float) gp_projection_solid(p, x + i, y);
}

double gp_projection_chord2(const struct gp_projection *p, double x, double y,
                            double to_x, double to_y)
{
    const double u = (to_x - x) * p->dx, v = (to_y - y) * p->dy;
    if (p->kind == GP_PLANE)
        return u * u + v * v;
    if (p->kind == GP_PERSPECTIVE) {
        // of (u, v, 1), lengths a and b: (apart^2 - (a - b)^2) / (a b)
        const double u0 = (x - p->x0) * p->dx, u1 = u0 + u;
        const double v0 = (y - p->y0) * p->dy, v1 = v0 + v;
        const double a = sqrt(1.0 + u0 * u0 + v0 * v0);
        const double b = sqrt(1.0 + u1 * u1 + v1 * v1);
        const double less = (u * (u0 + u1) + v * (v0 + v1)) / (a + b);
        return (u * u + v * v - less * less) / (a * b);
    }
    if (p->kind == GP_LATLONG) { // the haversine
        const double a = gp_sin(0.5 * v), b = gp_sin(0.5 * u);
        return 4.0 * (a * a + b * b * gp_cos((y - p->y0) * p->dy) *
                                  gp_cos((to_y - p->y0) * p->dy));
    }
    const struct gp_v3 apart = gp_v3_sub(gp_projection_direction(p, to_x, to_y),
                                         gp_projection_direction(p, x, y));
    return gp_v3_dot(apart, apart);
}
