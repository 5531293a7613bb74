/* Styles: names for options that belong together, as their words. */
#ifndef GP_CLI_STYLES_H
#define GP_CLI_STYLES_H

#include <stdbool.h>

#define GP_STYLE_USUAL "camera" // of a run without --style

enum { GP_STYLE_WORDS = 16 };   // most of one style, with the NULL

struct gp_style {
    const char *name;
    const char *text;           // one line
    const char *word[GP_STYLE_WORDS]; // names of options, without dashes, and
                                // their values in turn; then NULL
};
extern const struct gp_style gp_styles[]; // ends with name NULL

/* The style of that name, which must be one. */
const struct gp_style *gp_style_of(const char *name);

/* True when a style has a value for an option, by its long name. */
bool gp_style_sets(const char *style, const char *option);

/* The i-th name and its line, for the option table; NULL after the last. */
const char *gp_style_name(int i, const char **text);

#endif
