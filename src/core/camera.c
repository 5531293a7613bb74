// SPDX-License-Identifier: Apache-2.0
/* Makes cameras from matrices; projects points and discs. */
#include "core/camera.h"

#include "core/maths.h"

#include <math.h>
#include <string.h>

/* Places farther away than this count as beside the camera, so that every pixel
 * position fits an int. */
static const double FAR_PIXEL = 1e9;

static const double MOST_RADIUS = 1e6; // pixels

void gp_matrix_mul(const double a[16], const double b[16], double out[16])
{
    double m[16] = {0};
    for (int r = 0; r < 4; r++) {
        for (int c = 0; c < 4; c++) {
            for (int k = 0; k < 4; k++)
                m[4 * r + c] += a[4 * r + k] * b[4 * k + c];
        }
    }
    memcpy(out, m, sizeof m);
}

/* Returns true when three vectors span space, within single precision. */
static bool spans(struct gp_v3 a, struct gp_v3 b, struct gp_v3 c)
{
    return fabs(gp_v3_det(a, b, c)) >
           1e-9 * gp_v3_length(a) * gp_v3_length(b) * gp_v3_length(c);
}

// -- making ------------------------------------------------------------------

static double largest(const double *v, int n)
{
    double most = 0.0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(v[i]));
    return most;
}

static gp_status check_finite(const struct gp_log *log, const char *path,
                              const char *name, const double m[16])
{
    for (int i = 0; i < 16; i++) {
        if (!isfinite(m[i]))
            return gp_fail_at(log, GP_ERR_DATA, "lights.cameras",
                              "%s: %s is not finite (row %d, column %d is "
                              "%s); repair the header", path, name, i / 4,
                              i % 4, isnan(m[i]) ? "NaN" : "Inf");
    }
    return GP_OK;
}

static gp_status set_camera(const struct gp_log *log, const char *path,
                            const double *m, struct gp_camera *c)
{
    const gp_status st = check_finite(log, path, "worldToCamera", m);
    const double most = largest(m, 16);
    if (st)
        return st;
    if (most > 1e30 ||
        !spans(gp_column(m, 0), gp_column(m, 1), gp_column(m, 2)))
        return gp_fail_at(log, GP_ERR_DATA, "lights.cameras",
                          "%s: worldToCamera is singular (its largest entry "
                          "is %g); repair the header",
                          path, most);
    c->has_camera = true;
    memcpy(c->to_camera, m, sizeof c->to_camera);
    return GP_OK;
}

gp_status gp_camera_wide(const struct gp_log *log, const char *path,
                         const double *to_camera,
                         const struct gp_projection *wide,
                         struct gp_camera *out)
{
    const double left = wide->kind == GP_LATLONG ? -1.0 : 1.0;
    const double plain[16] = {left, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0,
                              0.0,  0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0};
    struct gp_camera c = {.wide = *wide};
    const gp_status st =
        set_camera(log, path, to_camera ? to_camera : plain, &c);
    const double *const m = c.to_camera;
    if (st)
        return st;
    if (to_camera &&
        gp_v3_det(gp_column(m, 0), gp_column(m, 1), gp_column(m, 2)) > 0.0) {
        for (int i = 2; i < 16; i += 4)
            c.to_camera[i] = -m[i];
    }
    *out = c;
    return GP_OK;
}

gp_status gp_camera_make(const struct gp_log *log, const char *path,
                         const double *to_camera, const double to_ndc[16],
                         enum glarepp_ndc ndc, struct gp_camera *out)
{
    gp_status st;
    struct gp_camera c = {0};
    GP_TRY(check_finite(log, path, "worldToNDC", to_ndc));

    // a projection keeps its meaning when all of it is scaled: here so that
    // the view axis has length 1, and w is a distance
    const double a[3] = {to_ndc[3], to_ndc[7], to_ndc[11]};
    const double longest = largest(a, 3);
    double size = 0.0; // in two steps: squares of 1e300 would overflow
    for (int i = 0; i < 3; i++)
        size += longest > 0.0 ? a[i] / longest * (a[i] / longest) : 0.0;
    size = sqrt(size);
    for (int i = 0; i < 16; i++)
        c.to_ndc[i] = size > 0.0 ? to_ndc[i] / longest / size : INFINITY;
    const struct gp_v3 x_column = gp_column(c.to_ndc, 0);
    const struct gp_v3 y_column = gp_column(c.to_ndc, 1);
    const struct gp_v3 axis = gp_column(c.to_ndc, 3); // so w on it is 1
    // (written so that a NaN fails too)
    if (!(largest(c.to_ndc, 16) <= 1e30 &&
          1e-9 * gp_v3_length(x_column) < 1.0 &&
          1e-9 * gp_v3_length(y_column) < 1.0))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: worldToNDC is not of a perspective camera (column "
                       "3 is %g, %g, %g); give the light's pixel",
                       path, a[0], a[1], a[2]);
    if (!spans(x_column, y_column, axis))
        return gp_fail_at(log, GP_ERR_DATA, "lights.cameras",
                          "%s: worldToNDC is singular (its columns x, y and w "
                          "are linearly dependent); repair the header", path);

    // by the image of the view axis, and which way y goes
    if (ndc == GLAREPP_NDC_AUTO) {
        const double x = gp_v3_dot(axis, x_column);
        const double y = gp_v3_dot(axis, y_column);
        const double apart = fmax(fabs(x), fabs(y));
        const double up =
            to_camera ? gp_v3_dot(y_column, gp_column(to_camera, 1)) : 0.0;
        const bool clip =
            up > 0.0
                ? apart <= fmax(fabs(x - 0.5), fabs(y - 0.5))
                : up == 0.0 && fmin(fabs(x), fabs(y)) < 0.02 && apart < 0.48;
        ndc = clip ? GLAREPP_NDC_CLIP : GLAREPP_NDC_SPEC;
    }
    // [-1, 1] with y up to [0, 1] with y down, before the division by w
    for (int row = 0; ndc == GLAREPP_NDC_CLIP && row < 16; row += 4) {
        double *const m = c.to_ndc + row;
        m[0] = 0.5 * (m[3] + m[0]);
        m[1] = 0.5 * (m[3] - m[1]);
    }
    if (to_camera)
        GP_TRY(set_camera(log, path, to_camera, &c));
    *out = c;
out:
    return st;
}

// -- projecting --------------------------------------------------------------

/* Solves p . (gradients of three columns) = x, y, w by Cramer's rule. */
static struct gp_v3 solve(const double m[16], int column, double x, double y,
                          double w)
{
    const struct gp_v3 a = gp_column(m, 0), b = gp_column(m, 1),
                       v = gp_column(m, column);
    const struct gp_v3 bv = gp_v3_cross(b, v), va = gp_v3_cross(v, a),
                       ab = gp_v3_cross(a, b);
    const double d = gp_v3_dot(a, bv);
    const double ex = x / d, ey = y / d, ez = w / d;
    return (struct gp_v3) {ex * bv.x + ey * va.x + ez * ab.x,
                           ex * bv.y + ey * va.y + ez * ab.y,
                           ex * bv.z + ey * va.z + ez * ab.z};
}

struct gp_v3 gp_camera_point(const struct gp_camera *c, double x, double y,
                             double w)
{
    const double *const m = c->to_ndc;
    return solve(m, 3, x * w - m[12], y * w - m[13], w - m[15]);
}

struct gp_v3 gp_camera_eye(const struct gp_camera *c)
{
    const double *const m = c->to_camera;
    return c->wide.kind ? solve(m, 2, -m[12], -m[13], -m[14])
                        : gp_camera_point(c, 0.0, 0.0, 0.0);
}

struct gp_v3 gp_camera_ray(const struct gp_camera *c, struct gp_rect display,
                           double x, double y)
{
    const double w = (double) display.x1 - display.x0;
    const double h = (double) display.y1 - display.y0;
    if (c->wide.kind) {
        const struct gp_v3 to = gp_projection_direction(&c->wide, x, y);
        return gp_v3_unit(solve(c->to_camera, 2, to.x, -to.y, to.z));
    }
    return gp_v3_unit(
        solve(c->to_ndc, 3, (x - display.x0) / w, (y - display.y0) / h, 1.0));
}

/* gp_camera_project() of a wide picture. */
static struct gp_projected project_wide(const struct gp_camera *c,
                                        struct gp_v3 p, double w)
{
    const double *const m = c->to_camera;
    const struct gp_v3 to = {gp_v3_dot(p, gp_column(m, 0)) + w * m[12],
                             -gp_v3_dot(p, gp_column(m, 1)) - w * m[13],
                             gp_v3_dot(p, gp_column(m, 2)) + w * m[14]};
    double at[2];
    if (!(gp_v3_length(to) > 0.0) || !gp_projection_place(&c->wide, to, at))
        return (struct gp_projected) {.behind = true};
    const double ray = w != 0.0 ? gp_v3_length(to) : INFINITY;
    return (struct gp_projected) {at[0], at[1], ray, ray, false};
}

struct gp_projected gp_camera_project(const struct gp_camera *c,
                                      struct gp_rect display,
                                      const double world[3], double w)
{
    static const struct gp_projected behind = {.behind = true};
    const double *m = c->to_ndc;
    // a direction's length is arbitrary: none may overflow or vanish
    const double scale = w == 0.0 ? largest(world, 3) : 1.0;
    const struct gp_v3 p = {world[0] / scale, world[1] / scale,
                            world[2] / scale};
    if (c->wide.kind)
        return project_wide(c, p, w);
    const double pw = gp_v3_dot(p, gp_column(m, 3)) + w * m[15];
    if (!(pw > 0.0))
        return behind;
    const double x = (gp_v3_dot(p, gp_column(m, 0)) + w * m[12]) / pw;
    const double y = (gp_v3_dot(p, gp_column(m, 1)) + w * m[13]) / pw;
    struct gp_projected at = {
        .x = display.x0 + x * ((double) display.x1 - display.x0),
        .y = display.y0 + y * ((double) display.y1 - display.y0),
        .z = INFINITY,
        .ray = INFINITY,
    };
    if (!(fabs(at.x) <= FAR_PIXEL && fabs(at.y) <= FAR_PIXEL))
        return behind;
    if (w != 0.0) {
        const struct gp_v3 e = gp_camera_eye(c);
        // camera units in a unit of the world
        const double *const s = c->to_camera;
        const double unit =
            c->has_camera
                ? gp_pow(fabs(gp_v3_det(gp_column(s, 0), gp_column(s, 1),
                                        gp_column(s, 2))),
                         1.0 / 3.0)
                : 1.0;
        at.z = pw * unit;
        at.ray = unit *
                 gp_v3_length((struct gp_v3) {p.x - e.x, p.y - e.y, p.z - e.z});
    }
    return at;
}

double gp_camera_disc_wide(const struct gp_camera *c, double y, double degrees)
{
    const double v = (y - c->wide.y0) * c->wide.dy;
    return c->wide.kind == GP_LATLONG
               ? 1.0 / fmax(fmax(gp_cos(v), degrees / 360.0), 1e-9)
               : 1.0;
}

/* The cone of half-angle a around a ray at angle t off the axis of a pinhole of
 * distance 1 cuts an ellipse with the half-axes
 *   sin a cos a / (cos^2 t - sin^2 a)  and  sin a / sqrt(cos^2 t - sin^2 a),
 * and the picture is that plane by an affine map of determinant `area`. */
double gp_camera_disc(const struct gp_camera *c, struct gp_rect display,
                      const double dir[3], double degrees)
{
    const double *m = c->to_ndc;
    const double most = largest(dir, 3);
    const struct gp_v3 d = {dir[0] / most, dir[1] / most, dir[2] / most};
    const struct gp_v3 axis = gp_column(m, 3);
    const double t =
        gp_atan2(gp_v3_length(gp_v3_cross(d, axis)), gp_v3_dot(d, axis));
    const double a = degrees * (M_PI / 360.0);
    if (c->wide.kind) {
        const struct gp_projected at = gp_camera_project(c, display, dir, 0.0);
        const double solid = c->wide.kind == GP_LATLONG
                                 ? c->wide.dx * c->wide.dy /
                                       gp_camera_disc_wide(c, at.y, degrees)
                                 : gp_projection_solid(&c->wide, at.x, at.y);
        // the cap's solid angle is 4 pi sin^2(a / 2)
        return at.behind
                   ? 0.0
                   : fmin(2.0 * gp_sin(0.5 * a) / sqrt(solid), MOST_RADIUS);
    }
    if (!(a >= 0.0 && t + a < M_PI / 2.0))
        return 0.0;
    const double det = gp_v3_det(gp_column(m, 0), gp_column(m, 1), axis);
    const double area = fabs(det) *
                        ((double) display.x1 - display.x0) *
                        ((double) display.y1 - display.y0);
    const double rest = gp_cos(t + a) * gp_cos(t - a); // cos^2 t - sin^2 a
    const double wide = sqrt(fmax(area, 0.0) * gp_cos(a)) * gp_sin(a);
    return fmin(wide / gp_pow(rest, 0.75), MOST_RADIUS);
}

double gp_camera_disc_degrees(const struct gp_camera *c, struct gp_rect display,
                              const double dir[3], double radius)
{
    const struct gp_v3 d = {dir[0], dir[1], dir[2]};
    const struct gp_v3 axis = gp_column(c->to_ndc, 3);
    const double t =
        gp_atan2(gp_v3_length(gp_v3_cross(d, axis)), gp_v3_dot(d, axis));
    double lo = 0.0;
    double hi = c->wide.kind ? 180.0 : (M_PI / 2.0 - t) * (360.0 / M_PI);
    // the radius grows with the angle
    while (hi - lo > 1e-9) {
        const double middle = 0.5 * (lo + hi);
        if (gp_camera_disc(c, display, dir, middle) < radius)
            lo = middle;
        else
            hi = middle;
    }
    return hi > 0.0 ? 0.5 * (lo + hi) : 0.0;
}

double gp_camera_fov(const struct gp_camera *c)
{
    // y of direction d is d * b / d * v: with b = along * v + up * u, u upright
    // to v of length 1, d = v + t u has along + t up, 0 above and 1 below
    const struct gp_v3 v = gp_column(c->to_ndc, 3), b = gp_column(c->to_ndc, 1);
    const double along = gp_v3_dot(b, v), up = gp_v3_length(gp_v3_cross(b, v));
    return (gp_atan((1.0 - along) / up) + gp_atan(along / up)) * (180.0 / M_PI);
}

struct gp_projection gp_camera_projection(const struct gp_camera *c,
                                          struct gp_rect display)
{
    const struct gp_v3 v = gp_column(c->to_ndc, 3);
    const struct gp_v3 a = gp_column(c->to_ndc, 0), b = gp_column(c->to_ndc, 1);
    const double w = gp_rect_w(display), h = gp_rect_h(display);
    // x of direction v + t u, u upright to v, is a * v + t a * u
    return (struct gp_projection) {
        .kind = GP_PERSPECTIVE,
        .x0 = display.x0 + gp_v3_dot(a, v) * w,
        .y0 = display.y0 + gp_v3_dot(b, v) * h,
        .dx = 1.0 / (gp_v3_length(gp_v3_cross(a, v)) * w),
        .dy = 1.0 / (gp_v3_length(gp_v3_cross(b, v)) * h),
    };
}
