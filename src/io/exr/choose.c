#include "io/exr/exr_priv.h"


#include <limits.h>
#include <string.h>

/* What is looked for, and where. */
struct search {
    const struct gp_log *log;
    const struct gp_input *o;
    struct gp_crypto crypto;
    int first;  // this part before the others
    int only;   // this part alone, or -1
};

/* The channels of a part that may be colour: ids have no name. */
static gp_status make_names(const struct search *s, int part,
                            const char *view, struct gp_exr_names *out)
{
    const exr_attr_chlist_t *list;
    gp_status st = gp_exr_names_in(s->log, s->o, part, view, out);
    if (st || exr_get_channels(s->o->exr, part, &list))
        return st;
    for (int i = 0; i < out->n; i++) {
        if (gp_exr_crypto_channel(&s->crypto, s->o, part,
                              list->entries[i].name.str))
            out->name[i] = "";
    }
    return GP_OK;
}

/* The part's name, or that without its view. */
static bool is_called(const struct gp_input *o, int part, const char *layer)
{
    const char *name;
    const size_t n = gp_exr_part_layer(o, part, &name);
    return n > 0 && (strcmp(name, layer) == 0 ||
                     (strlen(layer) == n && strncmp(name, layer, n) == 0));
}

static gp_status look_in_part(const struct search *s, int part,
                              const char *layer, const char *view, bool lone,
                              struct gp_colour_choice *out, bool *found)
{
    struct gp_exr_names names;
    gp_status st = make_names(s, part, view, &names);
    if (st)
        return st;
    if (!layer) {
        *found = gp_find_colour(names.name, names.n, lone, out);
    } else {
        *found = gp_find_layer_colour(names.name, names.n, layer, lone, out) ||
                 (!lone && is_called(s->o, part, layer) &&
                  gp_find_layer_colour(names.name, names.n, "", false, out));
    }
    gp_exr_names_free(&names);
    return GP_OK;
}

/* All parts in their order; those without a lone channel, which is more likely
 * depth than colour, before those with one. Without a layer's name a deep part
 * comes before a lone channel too, so that its reader says what is wrong. */
static gp_status look(const struct search *s, const char *layer,
                      const char *view, struct gp_exr_choice *out, bool *found)
{
    int deep = -1;
    *found = false;
    for (int lone = 0; lone < 2; lone++) {
        for (int i = -1; i < s->o->parts; i++) {
            const int part = i < 0 ? s->first : i;
            if ((i == s->first) || (s->only >= 0 && part != s->only) ||
                (view && !gp_exr_part_has_view(s->o, part, view)))
                continue;
            if (gp_exr_is_deep(s->o, part)) {
                deep = deep < 0 ? part : deep;
                continue;
            }
            gp_status st = look_in_part(s, part, layer, view, lone,
                                        &out->colour, found);
            if (st)
                return st;
            if (*found) {
                out->part = part;
                return GP_OK;
            }
        }
        if (deep >= 0 && !layer) {
            *out = (struct gp_exr_choice) {.part = deep};
            *found = true;
            return GP_OK;
        }
    }
    return GP_OK;
}

/* VIEW.LAYER, LAYER.VIEW or VIEW, when there is nothing of the whole name. */
static gp_status look_for_view(const struct search *s, const char *layer,
                               struct gp_exr_choice *out, bool *found)
{
    char word[GP_CHANNEL_NAME + 1];
    const char *first = strchr(layer, '.'), *last = strrchr(layer, '.');
    *found = false;
    if (strlen(layer) >= sizeof word)
        return GP_OK;
    gp_status st = look(s, NULL, layer, out, found);
    strcpy(word, layer);
    if (!st && !*found && first) {
        word[first - layer] = '\0';
        st = look(s, first + 1, word, out, found);
        word[first - layer] = '.';
    }
    if (!st && !*found && last) {
        word[last - layer] = '\0';
        st = look(s, word, last + 1, out, found);
    }
    return st;
}

int gp_exr_part_number(const struct gp_input *o, const char *part)
{
    long long number = 0;
    const char *c = part;
    for (; *c >= '0' && *c <= '9' && number < INT_MAX; c++)
        number = number * 10 + (*c - '0');
    if (*c == '\0' && c > part)
        return number < o->parts ? (int) number : -1;
    for (int i = 0; i < o->parts; i++) {
        const char *name = gp_exr_part_name(o, i);
        if (name && strcmp(name, part) == 0)
            return i;
    }
    return -1;
}

gp_status gp_exr_choose(const struct gp_log *log,
                        const struct gp_read_params *p, const char *path,
                        const struct gp_input *o, int first,
                        struct gp_exr_choice *out)
{
    struct search s = {.log = log, .o = o, .first = first, .only = -1};
    bool found = false;
    if (p->part) {
        s.only = gp_exr_part_number(o, p->part);
        if (s.only < 0)
            return gp_exr_not_there(log, p, path, o);
    }
    gp_exr_crypto(o, &s.crypto);
    gp_status st = look(&s, p->layer, p->view, out, &found);
    if (!st && !found && p->layer && !p->view)
        st = look_for_view(&s, p->layer, out, &found);
    if (st || found)
        return st;
    if (p->layer || p->part || p->view)
        return gp_exr_not_there(log, p, path, o);
    return gp_fail(log, GP_ERR_DATA,
                   "%s: no colour channels (looked for R,G,B, Y and "
                   "LAYER.R,G,B in %d part%s); rename or add them", path,
                   o->parts, o->parts == 1 ? "" : "s");
}
