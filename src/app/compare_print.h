/* What compare says of a pair: text for readers, and JSON. */
#ifndef GP_APP_COMPARE_PRINT_H
#define GP_APP_COMPARE_PRINT_H

#include "app/compare_figures.h"
#include "app/compare_flip.h"

#include <stdbool.h>
#include <stdio.h>

/* One part of one pair of files. All is borrowed. */
struct gp_compare_row {
    const char *a, *b;   // files
    bool numbered;       // by a pattern
    int frame;           // when numbered
    int part, parts;     // parts > 1: said beside the name
    enum gp_compare_result result;
    const char *why;     // of DIFFERENT and FILE, which have no figures; else
                         // NULL
    const struct gp_compare_settings *limits;
    const struct gp_compare_match *match;
    const struct gp_compare_figures *figures;
    const struct gp_compare_flip *flip;
};

/* "match", "warning", "failure", "different", "file error". */
const char *gp_compare_word(enum gp_compare_result r);

/* A block of lines, or one line of a sequence. */
void gp_compare_print(const struct gp_compare_row *r, FILE *to);
void gp_compare_print_line(const struct gp_compare_row *r, FILE *to);

/* One object on a line. Numbers that are not finite are null. False when
 * memory is full, or `to`. */
bool gp_compare_json(const struct gp_compare_row *r, FILE *to);

#endif
