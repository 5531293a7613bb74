// SPDX-License-Identifier: Apache-2.0
/* A glTF 2.0 file that is being read: JSON, buffers, and how much of memory its
 * content may still take. Only the reader sees it. Numbers of items start at
 * 0, as in the file. Source: glTF 2.0 specification (Khronos, 2021). */
#ifndef GP_SCENE_GLTF_GLTF_PRIV_H
#define GP_SCENE_GLTF_GLTF_PRIV_H

#include "core/json.h"
#include "core/status.h"
#include "scene/gltf/gltf.h"
#include "scene/scene.h"

#include <stddef.h>
#include <stdint.h>

#define GP_GLTF_MOST 1e15 // of a number of a file, either way

/* Bytes of the file or of one of its buffers. */
struct gp_gltf_span {
    const uint8_t *at;
    int bytes;
    void *own;  // of a data URI or a file beside; NULL: borrowed
    char *file; // owned name of the file beside that has them; NULL: `at` has
};

/* Content that is read as something else, by the warnings of node.c. */
enum gp_gltf_odd {
    GP_GLTF_BLENDED, GP_GLTF_GLASS, GP_GLTF_BLIND, GP_GLTF_MORPHS,
    GP_GLTF_FADED, GP_GLTF_TWICE, GP_GLTF_SKINS, GP_GLTF_COPIES,
    GP_GLTF_HIDDEN, GP_GLTF_FLAT, GP_GLTF_ODD,
};

struct gp_gltf {
    const struct gp_log *log;
    const char *path;
    struct gp_json_place whole; // the place of no item
    void *file;        // of a .glb
    size_t file_bytes; // of the file and the .bin beside it
    json_t *root;
    struct gp_gltf_span chunk; // the binary chunk of a .glb; at NULL: none
    struct gp_gltf_span *buffer;
    int buffers;
    bool beside;       // a buffer is a file of its own
    const struct gp_scene_images *images; // as of gp_scene_read()
    long long texels;                     // of all cut-outs
    size_t taken;                         // bytes of content
    bool odd[GP_GLTF_ODD]; // what it has
};

/* Reads the file, its JSON and buffers, and checks version and extensions.
 *   out  zero; gp_gltf_close() in any case
 * Errors: GP_ERR_IO a file cannot be read; GP_ERR_DATA; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_gltf_open(const struct gp_log *log, const char *path,
                                     struct gp_gltf *out);
void gp_gltf_close(struct gp_gltf *g);

/* Returns the place of item `index`, a "node", for core/json.h's messages. */
static inline struct gp_json_place gp_gltf_at(const struct gp_gltf *g,
                                              const char *what, int index)
{
    return (struct gp_json_place) {g->log, g->path, what, -1 - index};
}

/* Prints "street.glb: node 3: TEXT; export the scene again" and returns
 * GP_ERR_DATA. */
gp_status gp_gltf_fail(const struct gp_json_place *at, const char *fmt, ...)
    GP_PRINTF(2, 3);

/* Items of a list of the file, "nodes": how many, and one of them, an object.
 * A list that is not there has none. */
int gp_gltf_count(const struct gp_gltf *g, const char *list);
json_t *gp_gltf_item(const struct gp_gltf *g, const char *list, int index);

/* The value of a key as the number of an item of `list`; -1: not there.
 * Errors: GP_ERR_DATA no such item. */
GP_MUST_CHECK gp_status gp_gltf_index(const struct gp_gltf *g,
                                      const struct gp_json_place *at, json_t *o,
                                      const char *key, const char *list,
                                      int *out);

/* An extension of `o`, or NULL. */
json_t *gp_gltf_extension(json_t *o, const char *name);

/* Copies the name of `o`, printable, cut to fit; "" where it has none. */
void gp_gltf_name(json_t *o, char out[GP_SCENE_NAME]);

/* Allocates zeroed content; `out` is the address of a pointer; gp_free(). Errors:
 * GP_ERR_DATA when all content is out of proportion to the file: more than 64 MiB
 * and 32 times its size. */
GP_MUST_CHECK gp_status gp_gltf_alloc(struct gp_gltf *g, size_t count,
                                      size_t size, void *out);

/* The same after `have` items of the same pointer, NULL where there are none. */
GP_MUST_CHECK gp_status gp_gltf_grow(struct gp_gltf *g, size_t have,
                                     size_t more, size_t size, void *out);

/* Buffer view `index`; *stride 0: packed. */
GP_MUST_CHECK gp_status gp_gltf_view(const struct gp_gltf *g, int index,
    struct gp_gltf_span *out, int *stride);

/* Image `index`; *out is zero, and its own and file are freed in any case. */
GP_MUST_CHECK gp_status gp_gltf_image(const struct gp_gltf *g, int index,
                                      struct gp_gltf_span *out);

// -- accessor.c --------------------------------------------------------------

/* Elements of numbers in a buffer, bounds checked. */
struct gp_gltf_numbers {
    const uint8_t *at; // first element; NULL: zeros
    int stride;        // bytes
    int type;          // glTF's componentType
};
struct gp_gltf_accessor {
    struct gp_json_place place;
    struct gp_gltf_numbers all;
    int count;         // elements
    int components;    // numbers of an element: 1 to 4
    bool normalized;
    int sparse;        // elements that are replaced
    struct gp_gltf_numbers where, with; // their numbers, and their values
};

/* Checks accessor `index`. Errors: GP_ERR_DATA it leaves its buffer view, is
 * not of glTF's types, or is a matrix. */
GP_MUST_CHECK gp_status gp_gltf_accessor(const struct gp_gltf *g, int index,
                                         struct gp_gltf_accessor *out);

/* Its values: count * components floats; normalised integers within [-1, 1].
 * Errors: GP_ERR_DATA a value that is not finite or over 1e15 either way, or an
 * element to replace that is not there; not `components` to an element. */
GP_MUST_CHECK gp_status gp_gltf_floats(const struct gp_gltf_accessor *a,
                                       int components, float *out);

/* Its values as vertex numbers: count of them, each under `below`.
 * Errors: GP_ERR_DATA floats or signed integers, a number too high, an element
 * to replace that is not there, no numbers at all. */
GP_MUST_CHECK gp_status gp_gltf_indices(const struct gp_gltf_accessor *a,
                                        int below, uint32_t *out);

// -- mesh.c ------------------------------------------------------------------

/* Reads materials with the coverage of their textures, then meshes. */
GP_MUST_CHECK gp_status gp_gltf_materials(struct gp_gltf *g,
                                          struct gp_scene *out);
GP_MUST_CHECK gp_status gp_gltf_meshes(struct gp_gltf *g, struct gp_scene *out);

// -- anim.c ------------------------------------------------------------------

/* Keys of one property of a node. */
enum gp_key_path { GP_KEY_MOVE, GP_KEY_TURN, GP_KEY_SCALE, GP_KEY_PATHS };
enum gp_key_way { GP_KEY_STEP, GP_KEY_LINEAR, GP_KEY_CUBIC };
struct gp_keys {
    int node;
    enum gp_key_path path;
    enum gp_key_way way;
    int n;
    float *time;       // n seconds, rising; owned
    float *value;      // n * components; CUBIC: tangent in, value, tangent
                       // out of each; owned
};

/* A node: its place relative to its parent. */
struct gp_scene_node {
    int parent;        // -1: none
    bool listed;       // it is in the order of all
    bool placed;       // it is in the scene
    bool matrix;       // given as a matrix, which keys cannot move
    double local[16];  // row vectors; of its matrix
    double move[3], turn[4], scale[3]; // turn: x, y, z, w
    double world[16];  // posed
};

/* All nodes; keys replace the rest of their node. */
struct gp_scene_nodes {
    struct gp_scene_node *at;
    int n;
    int *order;        // parents first
    struct gp_keys *key;
    int keys;
    bool turned;       // the world is z up
};

/* Reads all animations into nodes->key and out->start, end. */
GP_MUST_CHECK gp_status gp_gltf_animations(struct gp_gltf *g,
                                           struct gp_scene *out);

/* Sets box and radius of an object from to_world and each vertex of its mesh
 * that a triangle uses; from the corners of the mesh's box where such vertices
 * times objects of the scene are over 2^20, as scenes are posed anew for every
 * frame. */
void gp_bounds_set(const struct gp_scene *s, struct gp_object *o);

#endif
