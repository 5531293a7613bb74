/* What a pair of glarepp compare leaves: idiff's lines and more, a JSON object,
 * pictures. */
#ifndef GP_CLI_COMPARE_REPORT_H
#define GP_CLI_COMPARE_REPORT_H

#include "cli/settings.h"
#include "core/status.h"
#include "glarepp.h"
#include "io/read.h"
#include "io/write.h"

#include <jansson.h>

/* Exit statuses: first those of glarepp_compare_facts.result; a wrong command
 * line has that of sysexits.h, which no difference has. */
enum {
    GP_COMPARE_MATCH = 0,
    GP_COMPARE_WARNING = 1,
    GP_COMPARE_FAILURE = 2,
    GP_COMPARE_DIFFERENT = 3, // cannot be compared
    GP_COMPARE_FILE = 4,      // a file could not be read or written
    GP_COMPARE_USAGE = 64,
};

/* One part of one pair of files, and its result; all is borrowed. */
struct gp_compare_row {
    const char *a, *b;   // files
    int frame;           // of a sequence
    int part, parts;     // parts > 1: printed beside the name
    int result;          // exit status, at most GP_COMPARE_FILE
    const char *why;     // of DIFFERENT and FILE, which have no figures; else
                         // NULL
    const struct gp_stored_image *image[2]; // of the files
    const struct glarepp_compare *compare;
    const struct glarepp_compare_facts *facts;
};

/* Returns "match", "warning", ... */
const char *gp_compare_word(int result);

/* Prints the figures of a part: idiff's lines, then our own. */
void gp_compare_print(const struct gp_compare_row *r,
                      const struct gp_compare_settings *s);

/* Prints one line, for a frame of a sequence. */
void gp_compare_print_line(const struct gp_compare_row *r);

/* An object of a row, with its frame where `numbered`; numbers that are not
 * finite are null. The caller owns it. */
json_t *gp_compare_json(const struct gp_compare_row *r, bool numbered);

/* Writes the map of FLIP, which must be known, as the ending of `path` says.
 * Errors: as gp_write_picture(). */
GP_MUST_CHECK gp_status gp_compare_draw_flip(
    const struct gp_log *log, const struct gp_write_params *write,
    const char *path, const struct gp_compare_row *r);

/* Writes a - b of flat images as s says, over the union of the windows: all
 * channels as floats to .exr; to other formats R, G and B, or the first channel
 * as grey, of which integer ones keep [0,1] without a curve.
 * Errors: as gp_write_picture(); GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_draw_difference(
    const struct gp_log *log, const struct gp_write_params *write,
    const char *path, const struct gp_compare_row *r,
    const struct gp_compare_settings *s);

#endif
