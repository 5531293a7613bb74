/* The nearest name to a misspelt one, for "did you mean". */
#ifndef GP_CORE_NEAREST_H
#define GP_CORE_NEAREST_H

#include <stddef.h>

/* A search for the nearest name: start with gp_nearest_to(), try each name,
 * read `name`. */
struct gp_nearest {
    const char *word;
    size_t length;
    int most;          // edits allowed, then those of `name`
    const char *name;  // the nearest so far, the first of equals; NULL: none
};

/* Starts a search for a word of that many bytes, borrowed; names more than
 * `most` edits away, or half the word's bytes, do not match. */
struct gp_nearest gp_nearest_to(const char *word, size_t length, int most);

/* Tries one name, borrowed. An edit inserts, deletes or replaces a byte, or
 * swaps two neighbours (the optimal string alignment distance). Words and names
 * over 31 bytes do not match. */
void gp_nearest_try(struct gp_nearest *search, const char *name);

#endif
