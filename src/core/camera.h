// SPDX-License-Identifier: Apache-2.0
/* Matrices of space, in double, and cameras, which project points and
 * directions of the world into the frame. */
#ifndef GP_CORE_CAMERA_H
#define GP_CORE_CAMERA_H

#include "core/image.h"
#include "core/projection.h"
#include "core/status.h"
#include "core/vector.h"

#include <math.h>
#include <stdbool.h>

/* Returns the upper three of column c: the gradient of that coordinate. */
static inline struct gp_v3 gp_column(const double m[16], int c)
{
    return (struct gp_v3){m[c], m[4 + c], m[8 + c]};
}

/* Sets out = a * b, of matrices for row vectors: first a, then b. */
void gp_matrix_mul(const double a[16], const double b[16], double out[16]);

// -- cameras -----------------------------------------------------------------

/* Row vectors, p' = p * m, m[4 * row + column], as in OpenEXR: a point is
 * (x, y, z, 1), a direction (x, y, z, 0). to_ndc is always GLAREPP_NDC_SPEC after
 * gp_camera_make(): (x, y) / w in [0, 1], y down; w > 0 before the camera, and
 * scaled so that w is the distance along the view axis in units of the world.
 * A camera whose pictures are of another projection has that instead of to_ndc. */
struct gp_camera {
    bool has_camera;     // to_camera is known: its scale is that of z and ray
    double to_camera[16], to_ndc[16];
    struct gp_projection wide; // PLANE: none
};

/* A camera from a frame's matrices. The view axis v is the direction in which
 * w grows fastest, the upper three of column 3; its image is the middle of the
 * picture, (1/2, 1/2) or (0, 0), give or take a lens shift. GLAREPP_NDC_SPEC is [0, 1],
 * y down (ImfStandardAttributes.h), CLIP [-1, 1], y up (Arnold, Gaffer; worldToScreen).
 * AUTO takes [0, 1] where y falls along the y of to_camera, which is up; the nearer of the
 * two where it rises; and without to_camera [0, 1], but where the image is at 0 in one
 * direction, to 0.02, and within 0.48 of it in the other.
 *   to_camera  may be NULL
 *   path       for the message
 *   out        written on GP_OK only
 * Errors: GP_ERR_DATA a matrix with NaN or Inf; to_ndc that is no projection
 * (column 3 has no axis, as of an orthographic camera; singular; entries over
 * 1e30 times the axis); a singular to_camera. */
GP_MUST_CHECK gp_status gp_camera_make(
    const struct gp_log *log, const char *path, const double *to_camera,
    const double to_ndc[16], enum glarepp_ndc ndc, struct gp_camera *out);

/* The camera of a LATLONG or fisheye. Its space is OpenEXR's, x right, y up, z along the
 * view; where that is right-handed, z is against the view. Without to_camera the world is
 * that space, and for a LATLONG that of OpenEXR's environments: y up, z in the middle of
 * the picture, x a quarter of a turn to the left. Errors: as above. */
GP_MUST_CHECK gp_status gp_camera_wide(const struct gp_log *log,
                                       const char *path,
                                       const double *to_camera,
                                       const struct gp_projection *wide,
                                       struct gp_camera *out);

/* Projects a point (w = 1) or direction (w = 0) of the world. */
struct gp_projected {
    double x, y;     // EXR pixel space: NDC 0 to 1 spans the display window
    double z,
        ray;     // distance along the view axis (of a wide picture the same as
                 // `ray`) and from the camera, scene units; INFINITY for a
                 // direction
    bool behind; // the camera, or beside it: w <= 0, or more than 1e9
                 // pixels away, or beyond a rim; the rest is 0
};
struct gp_projected gp_camera_project(const struct gp_camera *c,
    struct gp_rect display, const double world[3], double w);

/* Returns the radius in pixels of a disc `degrees` across, seen in direction
 * `dir`: the geometric mean of the half-axes of the ellipse that its
 * cone cuts from the picture, at most 1e6. It grows off the axis, about as
 * cos^-1.5. 0 when behind, or where the cone reaches beside the camera and the
 * cut is no ellipse. Of a wide picture, by the solid angle of its pixel there: around a
 * pole of a LATLONG half of the width at most. */
double gp_camera_disc(const struct gp_camera *c, struct gp_rect display,
                      const double dir[3], double degrees);

/* Returns how many times as wide as high the disc `degrees` across around a place is: 1
 * but in a LATLONG. */
double gp_camera_disc_wide(const struct gp_camera *c, double y, double degrees);

/* Returns the point of the world that (x, y) of the picture, NDC, shows at w
 * along the view axis. */
struct gp_v3 gp_camera_point(const struct gp_camera *c, double x, double y,
                             double w);

/* Returns the place of the camera in the world. */
struct gp_v3 gp_camera_eye(const struct gp_camera *c);

/* Returns the unit direction of the world that a place of the picture shows; it
 * is before the camera. */
struct gp_v3 gp_camera_ray(const struct gp_camera *c, struct gp_rect display,
                           double x, double y);

/* Returns the inverse of gp_camera_disc(): the degrees across of a disc in
 * direction `dir` that is `radius` pixels in the picture, to 1e-9; at most
 * those at which its cone reaches beside the camera. 0 when behind. */
double gp_camera_disc_degrees(const struct gp_camera *c, struct gp_rect display,
                              const double dir[3], double radius);

/* The PERSPECTIVE projection of a camera's pictures, with their lens shift and the
 * aspect of their pixels. Where rows do not stand upright on columns, as no camera
 * has it, by their lengths. */
struct gp_projection gp_camera_projection(const struct gp_camera *c,
                                          struct gp_rect display);

/* The angle in degrees between the directions of the picture's upper and lower
 * edge, in the plane of the view axis and its upright. */
double gp_camera_fov(const struct gp_camera *c);

#endif
