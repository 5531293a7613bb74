/* Finds options by name or letter, their values, and commands. */
#include "app/options.h"

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

// -- commands ----------------------------------------------------------------

const struct gp_command_row *gp_command_of(unsigned commands)
{
    const struct gp_command_row *c = gp_commands;
    while (!(c->bit & commands))
        c++;
    return c;
}
