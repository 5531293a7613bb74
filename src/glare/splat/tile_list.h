/* Which polygon reaches which tile: the lists that shaders/tile.frag walks.
 * Only splat_tile.c and its test include this; no GL here. */
#ifndef GP_GLARE_SPLAT_TILE_LIST_H
#define GP_GLARE_SPLAT_TILE_LIST_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/splat/blur.h"
#include "glare/splat/group.h"
#include "glare/kernel.h"

/* Polygons that one program and one kernel texture can draw together. Kind 0
 * lies on whole pixels and has blur 0, so that samples are not mixed; kind
 * 1 + b has blur b. */
enum { GP_TILE_KINDS = GP_BLURS + 1 };

/* Sizes, chosen so that a batch holds a thousand polygons of any size:
 * gp_tiles_roundings() counts on it. */
enum {
    GP_TILE_FIELD = 1024,    // widest and highest part of the frame, pixels
    GP_TILE_TEXELS = 1 << 19, // of a list: one a tile, two an entry
    GP_TILE_SIDES = 3,       // tiles are 16, 32 or 64 pixels wide and high
    GP_TILE_BATCH = 1000,    // polygons, at least, when not all are listed
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
 *   out  written only on GP_OK; free with gp_tile_pieces_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_tile_pieces_make(const struct gp_log *log,
                                            const struct gp_kernel *kernel,
                                            struct gp_rect crop,
                                            const struct gp_polygons *polygons,
                                            const struct gp_shrink *shrink,
                                            int w, int h,
                                            struct gp_tile_pieces *out);
void gp_tile_pieces_free(struct gp_tile_pieces *p);

/* One batch of a kind's pieces, listed for the tiles of a field. */
struct gp_tile_list {
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

/* Lists pieces of the kind from *next on, as many as fit, and moves *next
 * behind them. */
void gp_tile_list_fill(const struct gp_polygons *polygons,
                       const struct gp_tile_pieces *p, int kind, size_t *next,
                       struct gp_tile_list *list);

/* Polygons of an inner sum, for a tile with `most` of them: about the square
 * root, so that a pixel takes the fewest roundings. */
int gp_tile_inner(size_t most);

#endif
