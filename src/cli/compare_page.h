// SPDX-License-Identifier: Apache-2.0
/* The pages of glarepp compare: one of all pairs, the worst first, or one for each
 * frame and an index of them. */
#ifndef GP_CLI_COMPARE_PAGE_H
#define GP_CLI_COMPARE_PAGE_H

#include "cli/options.h"
#include "io/sequence.h"

#include <jansson.h>

/* A part of a pair of files, and its result; all is borrowed. */
struct gp_compare_row {
    const char *a, *b; // files
    int frame;         // of a sequence
    int part, parts;
    int result;      // exit status, at most GP_COMPARE_FILE
    const char *why; // there are no figures; else NULL
    const struct gp_stored_image *image[2]; // of the files
    const struct glarepp_compare *compare;
    const struct glarepp_compare_facts *facts;
};

/* A run's pages. Zeroed is none. */
struct gp_compare_pages {
    const struct gp_log *log;
    const struct gp_settings *s;
    struct gp_pattern pattern; // of --html; .len 0: there is one page
    bool sequence;
    int pairs;            // that there will be
    json_t *page, *index; // present ones; NULL: none
    struct gp_page_entries {
        struct gp_page_entry *at; // owned
        int n;
    } kept, listed;    // of page; of index
    size_t used, text; // bytes of its pictures, of all else of kept
};

/* Begins, before any work; does nothing without --html.
 *   frames  0: one pair of plain files
 * Errors: GP_ERR_USAGE --html-index without a page for each frame; GP_ERR_IO a
 * page cannot be written. */
GP_MUST_CHECK gp_status gp_compare_pages_begin(const struct gp_log *log,
                                               const struct gp_settings *s,
                                               int frames,
                                               struct gp_compare_pages *out);

/* Adds a row, and its facts as in --json. */
GP_MUST_CHECK gp_status gp_compare_pages_add(struct gp_compare_pages *p,
                                             const struct gp_compare_row *e,
                                             json_t *facts);

/* Writes the page that ends with a frame; with `last` that of all, or the index. */
GP_MUST_CHECK gp_status gp_compare_pages_write(struct gp_compare_pages *p,
                                               int frame, bool last);
void gp_compare_pages_free(struct gp_compare_pages *p);

#endif
