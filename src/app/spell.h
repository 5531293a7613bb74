/* The nearest of some names to a word that may be a slip of the finger. */
#ifndef GP_APP_SPELL_H
#define GP_APP_SPELL_H

#include <stddef.h>

/* A search: start it with gp_nearest_to(), try each name, read `name`. */
struct gp_nearest {
    const char *word;
    size_t length;
    int most;          // edits; lowered to those of `name` as names are tried
    const char *name;  // the nearest so far, the first of equals; NULL: none
};

/* A search for the word of that many bytes, borrowed; names that take more
 * than `most` edits, or than half its bytes, are no match. */
struct gp_nearest gp_nearest_to(const char *word, size_t length, int most);

/* Tries one name, borrowed. */
void gp_nearest_try(struct gp_nearest *search, const char *name);

/* Edits that turn the `n` bytes of `word` into `name`: insert, delete or
 * replace a byte, or swap two neighbours (the optimal string alignment
 * distance); 99 when one of them is longer than 31 bytes. */
int gp_edits(const char *word, size_t n, const char *name);

#endif
