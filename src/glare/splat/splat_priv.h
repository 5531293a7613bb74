/* The splat engine's parts, from the bottom up:
 *   tile.c     polygons gathered per tile, and the list of each tile's
 *              polygons
 *   draw.c     programs, kernels, sensors and groups on GL; polygons as blended
 *              quads
 *   splat.c    the layout of what is drawn, and the engine */
#ifndef GP_GLARE_SPLAT_SPLAT_PRIV_H
#define GP_GLARE_SPLAT_SPLAT_PRIV_H

#include "gl/gl.h"
#include "glare/bound/bound.h"
#include "glare/splat/polygons.h"

/* -- the layout ------------------------------------------------------------ */

/* The drawing, and the bound of its error: made on the CPU before any
 * drawing. */
struct gp_splat_layout {
    struct gp_splat_params params;
    bool single;                   // each source is a polygon on whole pixels
    bool core;                     // sources draw the kernel's core
    bool tail;                     // the kernel is more than its core
    struct gp_rect crop;           // of the kernel, that can reach the frame
    struct gp_polygons polygons;
    size_t chunk;                  // polygons summed separately before their
                                   // sum is added to the layer: about
                                   // the square root of all, as a sum of n
                                   // equal terms in float may drift by n / 2
                                   // roundings
    struct gp_shrink shrink;
    double polygon_pixels;         // of polygons and cores, on the layer
    double bound;                  // of rel_l2, for any way to draw
};

/* -- the engine's state ---------------------------------------------------- */

enum { GP_SPLAT_BAND_TEXELS = 1 << 18 };

/* Programs, made when they are first asked for. */
#define GP_SPLAT_PROGRAMS(X)                                                  \
    X(GP_SPLAT_EXACT_QUAD, "splat.vert", "splat.frag")                        \
    X(GP_SPLAT_SMOOTH_QUAD, "splat.vert", "splat_smooth.frag")                \
    X(GP_SPLAT_GROUP, "add.vert", "group.frag")                               \
    X(GP_SPLAT_ADD, "add.vert", "add.frag")
#define GP_SPLAT_ENUM(name, vert, frag) name,
enum gp_splat_program {
    GP_SPLAT_PROGRAMS(GP_SPLAT_ENUM) GP_SPLAT_PROGRAM_COUNT
};

/* Kernels on GL: one for each blur, and two for single sources. */
enum {
    GP_SPLAT_WHOLE = GP_BLURS, // not blurred, for sensors on whole pixels
    GP_SPLAT_CORE,             // GP_CORE_RADIUS pixels around the centre
    GP_SPLAT_KERNELS,
};
struct gp_splat_kernel {
    struct gp_texture texture; // w x h, and a border of `border` texels of 0
    int border;
    int w, h;
    int cx, cy;                // the centre's whole part; may lie outside
    float rest[2];             // rest of the centre: 0 or 1/2 each
};

/* Kept from frame to frame. */
struct gp_splat {
    struct gp_gl *gl;               // NULL before the first drawing
    enum gp_gl_api api;             // the API wanted when gl was opened
    struct gp_program program[GP_SPLAT_PROGRAM_COUNT];
    struct gp_target total, chunk;  // of one size; chunk only for many polygons
    struct gp_target groups, clusters;
    struct gp_texture sources;
    struct gp_buffer reaches; // of polygons, by gp_source_bin()
    struct gp_tiles *tiles;
    float *band; // GP_SPLAT_BAND_TEXELS texels on their way in or out

    // kernels of one serial, crop, and use
    struct gp_splat_kernel kernel[GP_SPLAT_KERNELS];
    unsigned long serial;
    struct gp_rect crop;
    bool tail;
};

/* Makes *state, without a context, or keeps it. Errors: GP_ERR_BUG out of
 * memory. */
GP_MUST_CHECK gp_status gp_splat_make(const struct gp_log *log, void **state);

/* Opens the context that `api` names, or keeps it; it is current afterwards.
 * Errors: GP_ERR_GL; no context is open then. */
GP_MUST_CHECK gp_status gp_splat_open(const struct gp_log *log,
                                      struct gp_splat *s, enum gp_gl_api api);

/* Bounds rel_l2 of a splat layer: grouping and clustering, light left out by
 * shrinking, samples' positions, and `roundings` float roundings, each 2^-24 of
 * a pixel's sum. INFINITY for kernels with lobes.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_group_bound(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    const struct gp_splat_params *p, const struct gp_polygons *polygons,
    const struct gp_shrink *shrink, double roundings, double *out);

/* -- objects on GL --------------------------------------------------------- */

/* Makes a target with n attachments at least w x h; what it held is lost when
 * it grows. Errors: those of gp_target_make(). */
GP_MUST_CHECK gp_status gp_splat_fit_target(const struct gp_log *log,
    const struct gp_gl *gl, const char *what, int n, int w, int h,
    struct gp_target *t);

void gp_splat_drop_kernels(struct gp_splat *s);

/* -- drawing --------------------------------------------------------------- */

/* Draws the layer of a layout, which fits into a target, by blended quads. The
 * context is open and current. Nothing is read back before the layer is done.
 * Errors: GP_ERR_GL; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_splat_draw(const struct gp_glare_request *req,
    struct gp_splat *s, const struct gp_splat_layout *layout);

/* Programs, packed kernels and targets of tiles, kept from frame to frame. */
struct gp_tiles;

/* What tiles draw. */
struct gp_tiles_light {
    const struct gp_kernel *kernel;
    struct gp_rect crop; // its part that can reach the frame, in its pixels
    bool tail;           // leave its core out
    const struct gp_polygons *polygons;
    const struct gp_shrink *shrink; // reach of each polygon
    int w, h;                       // of the layer
};

/* Writes the polygons' light to the layer's planes (what they held is lost),
 * gathered per tile: one fragment pass over a tile sums over the polygons that
 * reach it, so that nothing is blended. The context is current.
 *
 *   *state  NULL at first; kept by the caller; gp_tiles_free(). Packed kernels
 *           are kept while kernel->serial, crop and tail stay.
 *
 * Polygons at whole pixels with blur 0 are fetched exactly; others are
 * sampled bilinearly, with weights in float and not the driver's. Fractions
 * of positions are rounded to 2^-25 of a pixel. The sum's order depends on
 * nothing but the arguments (within a blur the polygons' own), and each pixel
 * sees at most *roundings float roundings of its sum, each 2^-24 of it where
 * GL rounds to nearest.
 * Errors: GP_ERR_GL no context can draw it, or a blurred kernel over the
 * texture limit; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_tiles_draw(const struct gp_log *log,
    struct gp_gl *gl, const struct gp_tiles_light *light,
    struct gp_planes *layer, struct gp_tiles **state, double *roundings);
void gp_tiles_free(struct gp_gl *gl, struct gp_tiles **state);

/* Bounds the roundings of a pixel's sum in gp_tiles_draw(), before it runs. */
double gp_tiles_roundings(const struct gp_polygons *polygons);

/* -- tile.c's lists, declared for tests ------------------------------------ */

/* Polygons that one program and one kernel texture can draw together. Kind 0
 * is on whole pixels and has blur 0, so that samples are not mixed; kind
 * 1 + b has blur b. */
enum { GP_TILE_KINDS = GP_BLURS + 1 };

/* Sizes, chosen so that a batch holds a thousand polygons of any size:
 * gp_tiles_roundings() counts on it. */
enum {
    GP_TILE_FIELD = 1024,     // widest and highest part of the frame, pixels
    GP_TILE_TEXELS = 1 << 19, // of a batch: one a tile, two an entry
    GP_TILE_SIDES = 3,        // tiles are 16, 32 or 64 pixels wide and high
    GP_TILE_BATCH = 1000,     // polygons, at least, when not all are in it
};

/* A polygon that reaches the frame. */
struct gp_tile_piece {
    struct gp_rect box; // the frame's pixels that it draws; not empty
    size_t polygon;     // index
};

struct gp_tile_pieces {
    struct gp_tile_piece *at;        // within a kind in the polygons' order
    size_t first[GP_TILE_KINDS + 1]; // kind k: pieces [first[k], first[k + 1])
    double cx[GP_BLURS], cy[GP_BLURS]; // centre of each blur, in its samples
};

/* Finds each polygon's pixels: those that its blurred kernel covers and
 * |dx|, |dy| <= reach does not cut, inside the w x h frame.
 *   out  written only on GP_OK; free with gp_tile_pieces_free() */
GP_MUST_CHECK gp_status gp_tile_pieces_make(const struct gp_log *log,
    const struct gp_kernel *kernel, struct gp_rect crop,
    const struct gp_polygons *polygons, const struct gp_shrink *shrink, int w,
    int h, struct gp_tile_pieces *out);
void gp_tile_pieces_free(struct gp_tile_pieces *p);

/* Some of a kind's pieces, entered for the tiles of a field that they reach. */
struct gp_tile_batch {
    struct gp_rect field;  // in: pixels of the frame, up to GP_TILE_FIELD
    int side;              // in: log2 of a tile's pixels, 4 to 6
    int across;            // out: tiles in a row
    struct gp_rect lit;    // out: box of the tiles with polygons, in tiles
    int most;              // out: polygons of the fullest tile; 0: none left
    int texels;            // out: in use
    float *texel;          // GP_TILE_TEXELS of 4 floats; borrowed
};

/* The side of tiles with which the kind's pieces cost least in the field. */
int gp_tile_side(const struct gp_tile_pieces *p, int kind,
                 struct gp_rect field);

/* Enters pieces of the kind from *next on, as many as fit, and moves *next
 * after them. */
void gp_tile_batch_enter(const struct gp_polygons *polygons,
                         const struct gp_tile_pieces *p, int kind,
                         size_t *next, struct gp_tile_batch *batch);

#endif
