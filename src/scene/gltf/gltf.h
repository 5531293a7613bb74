// SPDX-License-Identifier: Apache-2.0
/* Reads a glTF 2.0 scene, and poses it at a time. */
#ifndef GP_SCENE_GLTF_GLTF_H
#define GP_SCENE_GLTF_GLTF_H

#include "scene/scene.h"

/* Decodes pictures for the reader, which knows no format. */
struct gp_scene_images {
    void *user;
    /* Coverage of a picture, w * h codes from the upper left corner, as
     * gp_cutout has them; without alpha it may be one texel of 65535.
     *   name   of the picture, for messages; a file where `bytes` is NULL
     *   most   texels that it may have
     *   out    its w, h and alpha, on GP_OK only; gp_free()
     * Errors: those of its reader; GP_ERR_DATA over `most`. */
    gp_status (*alpha)(void *user, const struct gp_log *log, const char *name,
                       const void *bytes, size_t n, long long most,
                       struct gp_cutout *out);
};

/* Reads a scene: .glb, or .gltf with buffers in data URIs and at most one file
 * beside it. It is posed at its first key.
 *
 *   up      axis of the frame's world that points up; AUTO is Y until
 *           gp_scene_turn(). Z, Blender's: glTF's (x, y, z) is (x, -z, y) here
 *   images  of cut-out materials; NULL: they count as opaque, with a warning
 *   out     written on GP_OK only; gp_scene_free()
 *
 * Nodes that no scene of the file holds are left out, and so are points, lines
 * and orthographic cameras. With a warning each, skins and morph targets keep
 * their rest pose, instances of one node (EXT_mesh_gpu_instancing) are one, and
 * hidden nodes (KHR_node_visibility) are placed.
 *
 * Memory: 64 MiB, 32 times the size of the file, of which values of its JSON take
 * at most 1 GiB, and 2 bytes for each texel of its cut-outs: at most 2^24 texels,
 * each image once; what `images` takes to decode one comes on top.
 *
 * Errors: GP_ERR_IO a file cannot be read; GP_ERR_DATA not glTF 2.0, damaged, it,
 * its buffer or an image is no regular file, a circle of nodes, a number out of
 * its range, content out of proportion to the file, an extension that is required
 * and not known (Draco, meshopt); GP_ERR_BUG out of memory; those of `images`. */
GP_MUST_CHECK gp_status gp_scene_read(
    const struct gp_log *log, const char *path, enum glarepp_up up,
    const struct gp_scene_images *images, struct gp_scene *out);

/* Places objects, lights and cameras at a time in seconds; before the first
 * key of a node it is as at that, after the last as at that. A node that leaves
 * 1e15 either way is at the origin with size 0. */
void gp_scene_pose(struct gp_scene *s, double seconds);

/* Turns a scene that was read with AUTO, and poses it anew. */
void gp_scene_turn(struct gp_scene *s, enum glarepp_up up);

/* Returns the axis for AUTO: the one by which a camera of the scene, as posed,
 * is nearer to the frame's; without cameras in the scene the one of the
 * world that is nearer to the picture's upright. */
enum glarepp_up gp_scene_find_up(const struct gp_scene *s,
                                 const struct gp_camera *frame);

/* Returns the camera of that name, else the one whose node has that number, or
 * of name NULL the only one; NULL: none, or more than one of the name. */
const struct gp_scene_camera *gp_scene_find_camera(const struct gp_scene *s,
                                                   const char *name);

/* Fails with the cameras that --scene-camera may name where
 * gp_scene_find_camera() found none, or more than one. */
gp_status gp_scene_no_camera(const struct gp_log *log, const struct gp_scene *s,
                             const char *name);

/* A camera as posed, as a frame's, for a picture of that width to height.
 * Errors: those of gp_camera_make(). */
GP_MUST_CHECK gp_status gp_scene_camera_make(
    const struct gp_log *log, const struct gp_scene *s,
    const struct gp_scene_camera *c, double aspect, struct gp_camera *out);

/* Returns how far apart two cameras place a point, in pixels: the largest
 * distance over 3x3 places of the picture by `a`, at a tenth of the scene's
 * diagonal and at all of it; INFINITY where b has one behind it. */
double gp_scene_apart(const struct gp_scene *s, const struct gp_camera *a,
                      const struct gp_camera *b, struct gp_rect display);

void gp_scene_free(struct gp_scene *s);

#endif
