// SPDX-License-Identifier: Apache-2.0
/* Pages: one HTML file that shows pictures beside each other, with their figures.
 * page.html, page.css and page.js are put into the program by the build; what they
 * show is JSON. Numbers of a picture are halfs, packed so that all fit the size of the
 * page. */
#ifndef GP_CLI_PAGE_PAGE_H
#define GP_CLI_PAGE_PAGE_H

#include "cli/options.h"
#include "core/image.h"
#include "core/status.h"

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// -- pictures over each other --------------------------------------------------

/* A picture of a set. All is owned. */
struct gp_page_picture {
    json_t *about; // its object on the page
    uint16_t *half[3];
    uint8_t *relative, *flip; // at each pixel against the first picture;
                              // NULL: none
};

enum { GP_PAGE_PICTURES = 20 };

/* Pictures of one window, the first of which is the reference. Zeroed is none. */
struct gp_page_set {
    struct gp_rect window; // of all, not empty
    struct gp_rect keep;   // within it, from its corner: in the region of
                           // whole pixels; empty: none
    int n;
    struct gp_page_picture picture[GP_PAGE_PICTURES];
};
void gp_page_set_free(struct gp_page_set *s);

/* Adds a picture, as halfs, rounded to the nearest; beyond its data it is 0.
 *   about  what the page says of it, at least "name"; its reference is taken
 *   base   the first picture in floats: then the relative error is kept, of
 *          luminance as in max_rel, in codes of 8 bits; NULL: none is
 *   flip   FLIP at each pixel of the window, in [0,1]; NULL: none */
GP_MUST_CHECK gp_status gp_page_set_add(const struct gp_log *log,
                                        struct gp_page_set *s, json_t *about,
                                        const struct glarepp_image *light,
                                        const struct glarepp_image *base,
                                        const float *flip);

/* Packs a set into at most about `bytes` of JSON: whole, or as averages of
 * squares of pixels, as few as fit three fifths, and a region of whole pixels, where
 * the pictures differ most, in the rest.
 *   out  object "set" of an entry, with its "bytes" of pictures */
GP_MUST_CHECK gp_status gp_page_pack(const struct gp_log *log,
                                     const struct gp_page_set *s, size_t bytes,
                                     json_t **out);

/* Packs a thumbnail of picture i, at most `side` pixels wide and high, sRGB. */
GP_MUST_CHECK gp_status gp_page_thumb(const struct gp_log *log,
                                      const struct gp_page_set *s, int i,
                                      int side, json_t **out);

// -- the page -------------------------------------------------------------------

/* Bytes that --html-size leaves for so many pictures; without it they have half as
 * much each as a pair. */
size_t gp_page_room(const struct gp_settings *s, int pictures);

/* Makes a page without entries.
 *   out  {"kind", "title", "version", "command", "entries": []}; the command makes
 *        it again */
GP_MUST_CHECK gp_status gp_page_make(const struct gp_log *log,
                                     const struct gp_settings *s,
                                     const char *kind, const char *title,
                                     json_t **out);

/* Writes a page, whose reference it takes; "-" is stdout. A warning says so where its
 * text alone is larger than was asked for.
 * Errors: GP_ERR_IO; GP_ERR_BUG out of memory, also for a NULL page. */
GP_MUST_CHECK gp_status gp_page_save(const struct gp_log *log,
                                     const struct gp_settings *s,
                                     const char *path, json_t *page);

/* The text of a page before and after its JSON, made by the build of page.html,
 * page.css and page.js, with the hashes of both in its Content-Security-Policy. */
extern const char gp_page_before[], gp_page_after[];

#endif
