/* A sheet of pictures with captions: rows of tiles of one size. */
#ifndef GP_CLI_SHEET_H
#define GP_CLI_SHEET_H

#include "core/status.h"
#include "io/write.h"

/* Tiles are at most so wide, in pixels. */
enum { GP_SHEET_WIDTH = 640 };

struct gp_sheet {
    int w, h;                // of a tile; 0: none is there yet
    int columns, tiles;      // all that there will be
    struct gp_planes planes; // display-linear, of the whole sheet; owned
};

/* The sheet's size in pixels, once the first tile is there. */
int gp_sheet_w(const struct gp_sheet *s);
int gp_sheet_h(const struct gp_sheet *s);

/* Draws tile i, 0 to s->tiles - 1: the display window of f from `picture`, the
 * samples of its data window, scaled down by areas; outside of the data window
 * it is black. The first tile sets the size of all. Captions are of a to z,
 * spaces and dashes; longer ones are cut. Start with {.columns, .tiles}; end
 * with gp_planes_free(&s->planes).
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sheet_draw(const struct gp_log *log,
    struct gp_sheet *s, int i, const char *caption, const struct gp_frame *f,
    const struct gp_planes *picture);

#endif
