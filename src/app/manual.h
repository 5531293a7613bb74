/* The man page as plain text, a section at a time.
 *
 * The page's source, man/glarepp.1.in, is part of the program; what the
 * option table adds to it comes from gp_help_man(). Of mdoc, what that page
 * uses is understood; an unknown macro prints as its words.
 */
#ifndef GP_APP_MANUAL_H
#define GP_APP_MANUAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* man/glarepp.1.in, made a C file by make. */
extern const char gp_manual_text[];

/* A section: from its heading's line to the next heading of its level. */
struct gp_section {
    const char *title;  // not terminated
    size_t title_size;
    const char *text;   // behind the heading's line
    const char *end;
};

/* The next section that a topic of help can be, from `at` on: all but those
 * that --help prints, with subsections as sections of their own. Start with
 * gp_manual_text; go on with `text` of the last. False: there is none. */
bool gp_section_next(const char *at, struct gp_section *out);

/* The section's word for a list of topics, the longest of its title, in lower
 * case; cut to fit. */
void gp_section_word(const struct gp_section *s, char *word, size_t size);

/* True when a word of the title, or the whole, is `topic`, ignoring case;
 * `loose` ignores an "s" at the end of either too. */
bool gp_section_is(const struct gp_section *s, const char *topic, bool loose);

/* Prints a section with its heading, at most 79 columns unless it is verbatim.
 *
 *   parts  what gp_help_man() prints: parts behind lines @NAME@, which take
 *          the place of the same line in the section */
void gp_section_print(FILE *f, const struct gp_section *s, const char *parts);

#endif
