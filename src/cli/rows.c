// SPDX-License-Identifier: Apache-2.0
/* Rows of the table of options: by name, by letter, and the values that one takes,
 * with their limits in words. */
#include "cli/options.h"

#include <float.h>
#include <string.h>

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

bool gp_option_makes_pixels(const struct gp_option *o)
{
    return o->pixels ||
           (!o->aside && o->group != GP_GROUP_OUTPUT &&
            o->group != GP_GROUP_REPORT && o->group != GP_GROUP_GENERAL);
}

bool gp_option_given(const struct gp_settings *s, const char *name)
{
    const struct gp_texts *const given = &s->words.options;
    int i = 0;
    while (i < given->n && strcmp(given->at[i], name) != 0)
        i += 2;
    return i < given->n;
}

const struct gp_option_choice *gp_option_chosen(const struct gp_option *o,
                                                const void *field)
{
    const int v = o->kind == GP_KIND_EITHER ? *(const bool *) field
                                            : *(const int *) field;
    const struct gp_option_choice *c = o->choices;
    while (c->name && c->value != v)
        c++;
    return c->name ? c : NULL;
}

const struct gp_option *gp_option_letter(char letter, unsigned commands)
{
    for (const struct gp_option *o = gp_options; o->name && letter; o++) {
        if (o->letter == letter && (o->commands & commands))
            return o;
    }
    return NULL;
}
