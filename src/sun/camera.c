/* Makes cameras from matrices and JSON; projects points and discs. */
#include "sun/camera.h"
#include "core/json.h"

#include "core/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Places farther away than this count as beside the camera, so that every pixel
 * position fits an int. */
static const double FAR_PIXEL = 1e9;

static const double MOST_RADIUS = 1e6; // pixels
static const double PI = 3.14159265358979323846;

// -- vectors: columns of a matrix for row vectors ----------------------------

struct v3 {
    double x, y, z;
};

/* The upper three of column c: the gradient of that coordinate. */
static struct v3 column(const double m[16], int c)
{
    return (struct v3) {m[c], m[4 + c], m[8 + c]};
}

static double dot(struct v3 a, struct v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static struct v3 cross(struct v3 a, struct v3 b)
{
    return (struct v3) {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
                        a.x * b.y - a.y * b.x};
}

static double det(struct v3 a, struct v3 b, struct v3 c)
{
    return dot(a, cross(b, c));
}

static double length(struct v3 a)
{
    return sqrt(dot(a, a));
}

/* Returns whether three vectors span space, within single precision. */
static bool spans(struct v3 a, struct v3 b, struct v3 c)
{
    return fabs(det(a, b, c)) > 1e-9 * length(a) * length(b) * length(c);
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
            return gp_fail(log, GP_ERR_DATA,
                           "%s: %s is not finite (row %d, column %d is %s); "
                           "repair the header or give --camera", path, name,
                           i / 4, i % 4, isnan(m[i]) ? "NaN" : "Inf");
    }
    return GP_OK;
}

gp_status gp_camera_make(const struct gp_log *log, const char *path,
                         const double *to_camera, const double to_ndc[16],
                         enum gp_ndc ndc, struct gp_camera *out)
{
    gp_status st;
    struct gp_camera c = {.has_camera = to_camera != NULL};
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
    const struct v3 x_column = column(c.to_ndc, 0);
    const struct v3 y_column = column(c.to_ndc, 1);
    const struct v3 axis = column(c.to_ndc, 3); // so w on it is 1
    // (written so that a NaN fails too)
    if (!(largest(c.to_ndc, 16) <= 1e30 && 1e-9 * length(x_column) < 1.0 &&
          1e-9 * length(y_column) < 1.0))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: worldToNDC is not of a perspective camera (column "
                       "3 is %g, %g, %g); give the light's pixel", path, a[0],
                       a[1], a[2]);
    if (!spans(x_column, y_column, axis))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: worldToNDC is singular (its columns x, y and w are "
                       "linearly dependent); repair the header or give "
                       "--camera", path);

    if (ndc == GP_NDC_AUTO) { // by the image of the view axis
        static const double reach = 0.2;
        const double x = dot(axis, x_column), y = dot(axis, y_column);
        const double spec = fmax(fabs(x - 0.5), fabs(y - 0.5));
        const double clip = fmax(fabs(x), fabs(y));
        if (!(fmin(spec, clip) <= reach))
            GP_TRY(gp_fail(log, GP_ERR_DATA,
                "%s: worldToNDC follows neither convention (it maps the view "
                "axis to %.3g, %.3g: neither near 0.5, 0.5 nor near 0, 0); "
                "give --ndc spec or --ndc clip", path, x, y));
        ndc = spec <= clip ? GP_NDC_SPEC : GP_NDC_CLIP;
    }
    // [-1, 1] with y up to [0, 1] with y down, before the division by w
    for (int row = 0; ndc == GP_NDC_CLIP && row < 16; row += 4) {
        double *const m = c.to_ndc + row;
        m[0] = 0.5 * (m[3] + m[0]);
        m[1] = 0.5 * (m[3] - m[1]);
    }
    if (to_camera) {
        GP_TRY(check_finite(log, path, "worldToCamera", to_camera));
        const double most = largest(to_camera, 16);
        if (most > 1e30 || !spans(column(to_camera, 0), column(to_camera, 1),
                                  column(to_camera, 2)))
            return gp_fail(log, GP_ERR_DATA,
                "%s: worldToCamera is singular (its largest entry is %g); "
                "repair the header or give --camera", path, most);
        memcpy(c.to_camera, to_camera, sizeof c.to_camera);
    }
    *out = c;
out:
    return st;
}

// -- projecting --------------------------------------------------------------

struct gp_projected gp_camera_project(const struct gp_camera *c,
    struct gp_rect display, const double world[3], double w)
{
    static const struct gp_projected behind = {.behind = true};
    const double *m = c->to_ndc;
    // a direction's length is arbitrary: none may overflow or vanish
    const double scale = w == 0.0 ? largest(world, 3) : 1.0;
    const struct v3 p = {world[0] / scale, world[1] / scale, world[2] / scale};
    const double pw = dot(p, column(m, 3)) + w * m[15];
    if (!(pw > 0.0))
        return behind;
    const double x = (dot(p, column(m, 0)) + w * m[12]) / pw;
    const double y = (dot(p, column(m, 1)) + w * m[13]) / pw;
    struct gp_projected at = {
        .x = display.x0 + x * ((double) display.x1 - display.x0),
        .y = display.y0 + y * ((double) display.y1 - display.y0),
        .z = INFINITY, .ray = INFINITY,
    };
    if (!(fabs(at.x) <= FAR_PIXEL && fabs(at.y) <= FAR_PIXEL))
        return behind;
    if (w != 0.0) {
        // the camera's place e: x, y and w are 0 there (Cramer's rule)
        const struct v3 a = column(m, 0), b = column(m, 1), v = column(m, 3);
        const struct v3 bv = cross(b, v), va = cross(v, a), ab = cross(a, b);
        const double d = dot(a, bv);
        const double ex = -m[12] / d, ey = -m[13] / d, ez = -m[15] / d;
        const struct v3 e = {ex * bv.x + ey * va.x + ez * ab.x,
                             ex * bv.y + ey * va.y + ez * ab.y,
                             ex * bv.z + ey * va.z + ez * ab.z};
        // camera units in a unit of the world
        const double *const s = c->to_camera;
        const double unit = c->has_camera
            ? cbrt(fabs(det(column(s, 0), column(s, 1), column(s, 2)))) : 1.0;
        at.z = pw * unit;
        at.ray = unit * length((struct v3) {p.x - e.x, p.y - e.y, p.z - e.z});
    }
    return at;
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
    const struct v3 d = {dir[0] / most, dir[1] / most, dir[2] / most};
    const struct v3 axis = column(m, 3);
    const double t = atan2(length(cross(d, axis)), dot(d, axis));
    const double a = degrees * (PI / 360.0);
    if (!(a >= 0.0 && t + a < PI / 2.0))
        return 0.0;
    const double area =
        fabs(det(column(m, 0), column(m, 1), axis)) *
        ((double) display.x1 - display.x0) * ((double) display.y1 - display.y0);
    const double rest = cos(t + a) * cos(t - a); // cos^2 t - sin^2 a
    const double r = sqrt(fmax(area, 0.0) * cos(a)) * sin(a) / pow(rest, 0.75);
    return fmin(r, MOST_RADIUS);
}

double gp_camera_fov(const struct gp_camera *c)
{
    // y of direction d is d * b / d * v: with b = along * v + up * u, u upright
    // to v of length 1, d = v + t u has along + t up, 0 above and 1 below
    const struct v3 v = column(c->to_ndc, 3), b = column(c->to_ndc, 1);
    const double along = dot(b, v), up = length(cross(b, v));
    return (atan((1.0 - along) / up) + atan(along / up)) * (180.0 / PI);
}

/* 5000 frames and more as they are commonly written, a number a line. */
enum { MOST_BYTES = 8 << 20, MOST_FRAMES = 1 << 20 };

static const double MOST_FRAME = 9007199254740992.0; // 2^53: exact in double
static const double MOST_VALUE = 1e300;

static gp_status read_frame(const struct gp_json_place *p, json_t *o,
                            struct gp_camera_frame *out)
{
    gp_status st;
    char frame[2048]; // "cameras.json: frame 1001"
    struct gp_json_place at = *p;
    double number = 0.0, camera[16], ndc[16], columns[16];
    bool found, has_camera, spec, clip;
    if (!json_is_object(o))
        return gp_fail(p->log, GP_ERR_DATA,
            "%s: %s %d in order is not an object; give {\"frame\": ..., "
            "\"worldToNDC_rowmajor\": [...]}", p->path, p->what, p->index);
    // from here messages name the frame by its number
    GP_TRY(gp_json_number(p, o, "frame", -MOST_FRAME, MOST_FRAME, &number,
                          &found));
    if (!found || number != floor(number))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: %s %d in order has no frame number (found %s); "
                       "give \"frame\" an integer", p->path, p->what, p->index,
                       found ? "a fraction" : "no \"frame\"");
    out->frame = (long long) number;
    snprintf(frame, sizeof frame, "%s: frame %lld", p->path, out->frame);
    at.path = frame;
    at.index = 0;

    GP_TRY(gp_json_numbers(&at, o, "worldToCamera_rowmajor", 16, false,
                           -MOST_VALUE, MOST_VALUE, camera, &has_camera));
    GP_TRY(gp_json_numbers(&at, o, "worldToNDC_rowmajor", 16, false,
                           -MOST_VALUE, MOST_VALUE, ndc, &spec));
    GP_TRY(gp_json_numbers(&at, o, "worldToNDC_blender_colvec", 16, false,
                           -MOST_VALUE, MOST_VALUE, columns, &clip));
    if (!spec && !clip)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: no projection (found neither \"worldToNDC_rowmajor"
                       "\" nor \"worldToNDC_blender_colvec\"); give one of "
                       "them", frame);
    for (int i = 0; !spec && i < 16; i++)
        ndc[i] = columns[i % 4 * 4 + i / 4];
    GP_TRY(gp_camera_make(p->log, frame, has_camera ? camera : NULL, ndc,
                          spec ? GP_NDC_SPEC : GP_NDC_CLIP, &out->camera));

    GP_TRY(gp_json_numbers(&at, o, "sun_dir_world", 3, false, -MOST_VALUE,
                           MOST_VALUE, out->sun_dir, &out->has_sun));
    GP_TRY(gp_json_number(&at, o, "sun_radius_px", 0.0, 1e6, &out->sun_radius,
                          NULL));
    const double *const d = out->sun_dir;
    if (out->has_sun && d[0] == 0.0 && d[1] == 0.0 && d[2] == 0.0)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: \"sun_dir_world\" is 0, 0, 0; give a vector that "
                       "is not zero, or leave it out", frame);
out:
    return st;
}

static int by_number(const void *a, const void *b)
{
    const struct gp_camera_frame *x = a, *y = b;
    return (x->frame > y->frame) - (x->frame < y->frame);
}

gp_status gp_camera_read(const struct gp_log *log, const char *path,
                         struct gp_camera_file *out)
{
    gp_status st;
    json_t *root = NULL, *frames;
    struct gp_camera_file f = {0};
    struct gp_json_place place = {.log = log, .path = path, .what = "frame"};
    GP_TRY(gp_json_read(log, path, MOST_BYTES, &root));
    GP_TRY(gp_json_array(&place, root, "frames", MOST_FRAMES, &frames));
    f.n = (int) json_array_size(frames);
    if (f.n == 0)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: no frames (\"frames\" is empty); give each "
                       "frame's matrices", path));
    GP_TRY(gp_alloc_zero(log, path, (size_t) f.n, sizeof *f.at, &f.at));
    for (int i = 0; i < f.n; i++) {
        place.index = i + 1;
        GP_TRY(read_frame(&place, json_array_get(frames, (size_t) i),
                          &f.at[i]));
    }
    qsort(f.at, (size_t) f.n, sizeof *f.at, by_number);
    for (int i = 1; i < f.n; i++) {
        if (f.at[i].frame == f.at[i - 1].frame)
            GP_TRY(gp_fail(log, GP_ERR_DATA,
                           "%s: frame %lld is listed twice; remove one", path,
                           f.at[i].frame));
    }
    place.index = 0;
    if (json_is_object(root))
        GP_TRY(gp_json_number(&place, root, "width", 1.0, 1e9, &f.width, NULL));
    *out = f;
    f = (struct gp_camera_file) {0}; // the caller's
out:
    gp_camera_file_free(&f);
    json_decref(root);
    return st;
}

void gp_camera_file_free(struct gp_camera_file *f)
{
    GP_FREE(f->at);
    f->n = 0;
}

const struct gp_camera_frame *
gp_camera_frame_find(const struct gp_camera_file *f, long long number)
{
    if (f->n == 1)
        return &f->at[0];
    const struct gp_camera_frame key = {.frame = number};
    return f->n ? bsearch(&key, f->at, (size_t) f->n, sizeof key, by_number)
                : NULL;
}
