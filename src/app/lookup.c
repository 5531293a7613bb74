/* Finds options by name or letter, their values, and the nearest name to a
 * misspelt one. */
#include "app/options.h"

#include "core/minmax.h"

#include <float.h>
#include <string.h>

// -- rows of the table -------------------------------------------------------

const char *gp_option_value(const struct gp_option *o, int i, const char **text)
{
    *text = NULL;
    if (o->choices) {
        *text = o->choices[i].text;
        return o->choices[i].name;
    }
    return o->list ? o->list(i, text) : NULL;
}

struct gp_range_text gp_option_range(const struct gp_option *o)
{
    struct gp_range_text r;
    bool open_end = o->hi >= (double) FLT_MAX;
    bool over_zero = o->lo == (double) FLT_MIN; // stands for > 0
    if (o->lo <= -(double) FLT_MAX && open_end)
        snprintf(r.text, sizeof r.text, "any number");
    else if (over_zero && open_end)
        snprintf(r.text, sizeof r.text, "more than 0");
    else if (over_zero)
        snprintf(r.text, sizeof r.text, "more than 0, up to %g", o->hi);
    else if (open_end)
        snprintf(r.text, sizeof r.text, "%g or more", o->lo);
    else
        snprintf(r.text, sizeof r.text, "%.15g to %.15g", o->lo, o->hi);
    return r;
}

const struct gp_option *gp_option_find(const char *name, size_t length)
{
    for (const struct gp_option *o = gp_options; o->name; o++) {
        if (strlen(o->name) == length && strncmp(o->name, name, length) == 0)
            return o;
    }
    return NULL;
}

bool gp_option_given(const struct gp_settings *s, const char *name)
{
    const struct gp_option *const o = gp_option_find(name, strlen(name));
    const size_t i = o ? (size_t) (o - gp_options) : 0;
    return o && (s->given[i / 64] >> i % 64 & 1);
}

const struct gp_option *gp_option_letter(char letter, unsigned commands)
{
    for (const struct gp_option *o = gp_options; o->name && letter; o++) {
        if (o->letter == letter && (o->commands & commands))
            return o;
    }
    return NULL;
}

// -- misspelt words ----------------------------------------------------------

struct gp_nearest gp_nearest_to(const char *word, size_t length, int most)
{
    // a word that is half wrong is no match
    const int half = length < 64 ? (int) length / 2 : 0;
    return (struct gp_nearest) {
        .word = word, .length = length, .most = gp_min(most, half),
    };
}

void gp_nearest_try(struct gp_nearest *search, const char *name)
{
    enum { LONGEST = 31 };
    const char *const word = search->word;
    const size_t n = search->length, m = strlen(name);
    int rows[3][LONGEST + 1]; // the last three of the table of distances
    if (n > LONGEST || m > LONGEST)
        return;
    for (size_t j = 0; j <= m; j++)
        rows[0][j] = (int) j;
    for (size_t i = 1; i <= n; i++) {
        int *const row = rows[i % 3];
        const int *const above = rows[(i - 1) % 3];
        row[0] = (int) i;
        for (size_t j = 1; j <= m; j++) {
            const bool same = word[i - 1] == name[j - 1];
            row[j] = gp_min(above[j - 1] + !same,
                            gp_min(above[j], row[j - 1]) + 1);
            if (i > 1 && j > 1 && word[i - 1] == name[j - 2] &&
                word[i - 2] == name[j - 1])
                row[j] = gp_min(row[j], rows[(i - 2) % 3][j - 2] + 1);
        }
    }
    const int edits = rows[n % 3][m];
    if (search->name ? edits < search->most : edits <= search->most) {
        search->most = edits;
        search->name = name;
    }
}
