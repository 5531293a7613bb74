// SPDX-License-Identifier: Apache-2.0
/* Chooses the part of an EXR that is the frame, and its colour channels. */
#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "io/channels.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* -- parts and views ------------------------------------------------------ */

bool gp_exr_other_view(const struct gp_input *in, int a, int b)
{
    const char *const one = in->each[a].view, *const two = in->each[b].view;
    return one && two && strcmp(one, two) != 0;
}

/* Lists the views of a part: its own, or several; returns how many. The first
 * VIEWS count: real files have fewer, and a hostile one would cost that many
 * comparisons for each channel. */
enum { VIEWS = 64 };
static int views_of(const struct gp_input *in, int part,
                    const char *view[VIEWS])
{
    const exr_attribute_t *a;
    view[0] = in->each[part].view;
    if (view[0])
        return 1;
    if (exr_get_attribute_by_name(in->exr, part, "multiView", &a) ||
        a->type != EXR_ATTR_STRING_VECTOR)
        return 0;
    const exr_attr_string_vector_t *const v = a->stringvector;
    const int n = v->n_strings < VIEWS ? v->n_strings : VIEWS;
    for (int i = 0; i < n; i++)
        view[i] = v->strings[i].str ? v->strings[i].str : "";
    return n;
}

/* True when the part is of that view, or has channels of it. */
static bool has_view(const struct gp_input *in, int part, const char *wanted)
{
    const char *view[VIEWS];
    for (int i = 0, n = views_of(in, part, view); i < n; i++) {
        if (strcmp(view[i], wanted) == 0)
            return true;
    }
    return false;
}

static bool is_word(const char *from, size_t n, const char *word)
{
    return strlen(word) == n && strncmp(from, word, n) == 0;
}

/* The view of several that a channel names, and where in it; -1: none. */
static int named_view(const char *const *view, int n, const char *name,
                      size_t *at)
{
    const char *const dot = strrchr(name, '.'), *start = dot;
    while (start && start > name && start[-1] != '.')
        start--;
    *at = dot ? (size_t) (start - name) : 0;
    for (int i = 0; dot && i < n; i++) {
        if (is_word(start, (size_t) (dot - start), view[i]))
            return i;
    }
    return -1;
}

bool gp_exr_bare_name(const struct gp_input *in, int part, const char *wanted,
                      const char *name, char *to)
{
    const char *view[VIEWS];
    const int n = in->each[part].view ? 0 : views_of(in, part, view);
    size_t at;
    strcpy(to, name);
    if (n == 0)
        return true;
    const int i = named_view(view, n, name, &at);
    if (i >= 0)
        strcpy(to + at, strrchr(name, '.') + 1);
    return strcmp(view[i < 0 ? 0 : i], wanted) == 0;
}

const char *gp_exr_view_of(const struct gp_input *in, int part,
                           const char *name)
{
    const char *view[VIEWS];
    size_t at;
    const int i = named_view(view, views_of(in, part, view), name, &at);
    return i > 0 ? view[i] : NULL;
}

void gp_read_taken(const struct gp_frame *f, struct gp_taken *out)
{
    const struct gp_input *const in = gp_input_of(f);
    const char *colour = gp_frame_colour(f), *part = NULL, *view = NULL;
    char bare[GP_CHANNEL_NAME + 1];
    *out = (struct gp_taken) {0};
    colour = colour ? colour : "";
    if (in) {
        part = in->parts > 1 ? in->each[f->part].name : NULL;
        view = in->each[f->part].view;
    }
    if (in && !view) {
        view = gp_exr_view_of(in, f->part, colour);
        if (view && gp_exr_bare_name(in, f->part, view, colour, bare))
            colour = bare;
    }
    if (part)
        snprintf(out->part, sizeof out->part, "%s", part);
    else if (f->parts > 1)
        snprintf(out->part, sizeof out->part, "%d", f->part);
    if (view)
        snprintf(out->view, sizeof out->view, "%s", view);
    const size_t dot = gp_layer_length(colour);
    if (dot > 0)
        snprintf(out->layer, sizeof out->layer, "%.*s", (int) dot - 1, colour);
}

gp_status gp_exr_names_in(const struct gp_log *log, const struct gp_input *in,
                          int part, const char *view, const char ***out)
{
    const exr_attr_chlist_t *const list = in->each[part].channel;
    size_t bytes = (size_t) list->num_channels * sizeof **out;
    for (int i = 0; view && i < list->num_channels; i++)
        bytes += strlen(list->entries[i].name.str) + 1;
    const gp_status st = gp_alloc(log, "channel names", bytes, 1, out);
    if (st)
        return st;
    char *to = (char *) (*out + list->num_channels);
    for (int i = 0; i < list->num_channels; i++) {
        const char *const own = list->entries[i].name.str;
        (*out)[i] = own;
        if (view) {
            (*out)[i] = gp_exr_bare_name(in, part, view, own, to) ? to : "";
            to += strlen(own) + 1;
        }
    }
    return GP_OK;
}

/* -- Cryptomatte ---------------------------------------------------------- */

void gp_exr_find_crypto(struct gp_input *in)
{
    // cryptomatte/HASH/name
    static const char first[] = "cryptomatte/", last[] = "/name";
    const size_t start = sizeof first - 1, end = sizeof last - 1;
    struct gp_crypto *const c = &in->crypto;
    for (int part = 0; part < in->parts; part++) {
        const struct gp_exr_part *const own = &in->each[part];
        for (int i = 0; i < own->attrs && c->n < GP_CRYPTO_LAYERS; i++) {
            const char *const name = own->attr[i].name, *layer;
            const size_t len = strlen(name);
            int32_t n;
            int k = 0; // of another part
            if (len <= start + end || strncmp(name, first, start) != 0 ||
                strcmp(name + len - end, last) != 0 ||
                exr_attr_get_string(in->exr, part, name, &n, &layer) ||
                !layer || !*layer)
                continue;
            while (k < c->n && strcmp(c->layer[k], layer) != 0)
                k++;
            if (k < c->n)
                continue;
            c->layer[k] = layer;
            c->part[k] = part;
            c->key[k] = name;
            c->n++;
        }
    }
}

enum gp_crypto_kind gp_exr_crypto_channel(const struct gp_input *in, int part,
                                          const char *name)
{
    static const struct gp_crypto none;
    const struct gp_crypto *const c = in ? &in->crypto : &none;
    const size_t len = gp_layer_length(name);
    if (len > 0)
        return gp_crypto_layer(c, name, len - 1);
    return in ? gp_crypto_layer(c, in->each[part].layer, in->each[part].length)
              : GP_CRYPTO_NONE;
}

/* -- the search ----------------------------------------------------------- */

struct search {
    const struct gp_log *log;
    const struct gp_input *in;
    int first; // this part before the others
    int only;  // this part and no other, or -1
};

/* Searches all parts for colour, then for a lone channel; a deep part comes before
 * that, with its colour, or without, so that its reader reports it. out->part is -1:
 * none. */
static gp_status search_parts(const struct search *s, const char *layer,
    const char *view, struct gp_exr_choice *out)
{
    const struct gp_input *const in = s->in;
    struct gp_exr_choice deep = {-1, {.index = {-1, -1, -1}}};
    *out = (struct gp_exr_choice) {.part = -1};
    for (int lone = 0; lone < 2; lone++) {
        for (int i = -1; i < in->parts; i++) {
            const int part = i < 0 ? s->first : i;
            if (i == s->first || (s->only >= 0 && part != s->only) ||
                (view && !has_view(in, part, view)))
                continue;
            // the part's channels of the view; those of ids are no colour
            const exr_attr_chlist_t *const list = in->each[part].channel;
            const int channels = list->num_channels;
            const char **name;
            gp_status st = gp_exr_names_in(s->log, in, part, view, &name);
            if (st)
                return st;
            for (int k = 0; k < channels; k++) {
                const exr_attr_chlist_entry_t *const c = &list->entries[k];
                if (gp_exr_crypto_channel(in, part, c->name.str) ||
                    (lone && !layer && c->pixel_type == EXR_PIXEL_UINT))
                    name[k] = "";
            }
            // the layer of that name, or the part: with or without its view
            const char *const called = in->each[part].layer;
            const size_t n = in->each[part].length;
            const bool data = n > 0 && s->only < 0 && !gp_is_light(called, n);
            const bool found =
                !layer ? !data && gp_find_colour(name, channels, lone,
                                                 &out->colour)
                       : gp_find_layer_colour(name, channels, layer, lone,
                                              &out->colour) ||
                             (!lone && n > 0 &&
                              (strcmp(called, layer) == 0 ||
                               is_word(called, n, layer)) &&
                              gp_find_layer_colour(name, channels, "", false,
                                                   &out->colour));
            gp_free(name);
            if (found && !in->each[part].deep) {
                out->part = part;
                return GP_OK;
            }
            if (!layer && deep.colour.index[0] < 0 && in->each[part].deep) {
                deep.part = part;
                if (found)
                    deep.colour = out->colour;
            }
        }
        if (deep.part >= 0) {
            *out = deep;
            break;
        }
    }
    return GP_OK;
}

/* The number of the part of that number or name, or -1. */
static int part_number(const struct gp_input *in, const char *part)
{
    if (*part && !part[strspn(part, "0123456789")]) {
        const long number = strtol(part, NULL, 10);
        return number < in->parts ? (int) number : -1;
    }
    for (int i = 0; i < in->parts; i++) {
        const char *name = in->each[i].name;
        if (name && strcmp(name, part) == 0)
            return i;
    }
    return -1;
}

/* -- messages that list what a file has ----------------------------------- */

enum { NAMES = 400 }; // bytes of a list

/* Adds ", NAME" to a list that has not got it; ", ..." where it is full. */
static void add_name(char list[NAMES], const char *name, size_t len)
{
    char word[NAMES];
    const size_t used = strlen(list);
    const int n = snprintf(word, sizeof word, ", %.*s",
                           len < 300 ? (int) len : 300, name);
    for (const char *p = list; (p = strstr(p, word)); p += n) {
        if (!p[n] || p[n] == ',')
            return;
    }
    if (len > 0 && !strstr(list, ", ..."))
        snprintf(list + used, NAMES - used, "%s",
                 used + (size_t) n + 6 < NAMES ? word : ", ...");
}

/* Prints the line for a layer, part or view that the file does not have. */
static gp_status not_there(const struct search *s,
                           const struct gp_read_params *p)
{
    char layers[NAMES] = "", parts[NAMES] = "", views[NAMES] = "";
    const struct gp_input *const in = s->in;
    char what[700];
    bool known = !p->view;
    for (int part = 0; part < in->parts; part++) {
        const struct gp_exr_part *const own = &in->each[part];
        const exr_attr_chlist_t *const list = own->channel;
        const char *view[VIEWS];
        snprintf(what, sizeof what, "%d %s", part, own->name ? own->name : "-");
        add_name(parts, what, strlen(what));
        known = known || has_view(in, part, p->view);
        for (int i = 0, n = views_of(in, part, view); i < n; i++)
            add_name(views, view[i], strlen(view[i]));
        // the layers that hold light
        for (int i = 0; i < list->num_channels; i++) {
            const char *layer = list->entries[i].name.str;
            const size_t len = gp_layer_length(layer);
            const char *const letter = layer + len;
            if ((strcmp(letter, "R") != 0 && strcmp(letter, "Y") != 0 &&
                 strcasecmp(letter, "red") != 0) ||
                gp_exr_crypto_channel(in, part, layer) ||
                (len == 0 && in->parts == 1))
                continue;
            if (len > 0)
                add_name(layers, layer, len - 1);
            else
                add_name(layers, own->layer, own->length);
        }
    }
    const char *const has_layers = *layers ? layers + 2 : "none";
    const size_t own = p->layer ? gp_layer_length(p->layer) : 0;
    if (p->layer &&
        (gp_crypto_layer(&s->in->crypto, p->layer, strlen(p->layer)) ||
         (own && gp_crypto_layer(&s->in->crypto, p->layer, own - 1))))
        return gp_fail(s->log, GP_ERR_USAGE,
                       "%s: layer %.200s is Cryptomatte: ids are no light and "
                       "are never filtered (layers of light: %s); give one of "
                       "those",
                       in->path, p->layer, has_layers);
    if (p->part && part_number(in, p->part) < 0)
        snprintf(what, sizeof what, "part %.200s", p->part);
    else if (!known)
        snprintf(what, sizeof what, "view %.200s", p->view);
    else // as "layer a in part 2 of view left"
        snprintf(what, sizeof what, "%s%.200s%s%.200s%s%.200s",
                 p->layer ? "layer " : "colour", p->layer ? p->layer : "",
                 p->part ? " in part " : "", p->part ? p->part : "",
                 p->view ? " of view " : "", p->view ? p->view : "");
    return gp_fail(s->log, GP_ERR_USAGE,
                   "%s: has no %s (layers: %s; parts: %s; views: %s); give one "
                   "of those",
                   in->path, what, has_layers, parts + 2,
                   *views ? views + 2 : "none");
}

gp_status gp_exr_choose(const struct gp_log *log,
                        const struct gp_read_params *p,
                        const struct gp_input *in, int first,
                        struct gp_exr_choice *out)
{
    struct search s = {.log = log, .in = in, .first = first, .only = -1};
    char word[GP_CHANNEL_NAME + 1];
    if (p->part) {
        s.only = part_number(in, p->part);
        if (s.only < 0)
            return not_there(&s, p);
    }
    gp_status st = search_parts(&s, p->layer, p->view, out);
    if (!st && out->part < 0 && p->layer && !p->view &&
        strlen(p->layer) < sizeof word) {
        // no layer of that name: tries VIEW, VIEW.LAYER and LAYER.VIEW
        strcpy(word, p->layer);
        char *const dot[2] = {strchr(word, '.'), strrchr(word, '.')};
        st = search_parts(&s, NULL, p->layer, out);
        for (int i = 0; i < 2 && dot[i] && !st && out->part < 0; i++) {
            *dot[i] = '\0';
            st = search_parts(&s, i ? word : dot[i] + 1, i ? dot[i] + 1 : word,
                              out);
            *dot[i] = '.';
        }
    }
    if (st || out->part >= 0)
        return st;
    if (p->layer || p->part || p->view)
        return not_there(&s, p);
    return gp_fail(log, GP_ERR_DATA,
                   "%s: no colour channels (looked for R,G,B, Y and "
                   "LAYER.R,G,B in %d part%s); rename or add them",
                   in->path, in->parts, in->parts == 1 ? "" : "s");
}

/* -- the views of a file -------------------------------------------------- */

/* Adds a view that is not there yet; an empty name is none. */
static void add_view(const char *view[GP_VIEWS_MAX], int *n, const char *name)
{
    for (int i = 0; i < *n; i++) {
        if (strcmp(view[i], name) == 0)
            return;
    }
    if (*name && *n < GP_VIEWS_MAX)
        view[(*n)++] = name;
}

gp_status gp_frame_views(const struct gp_log *log,
                         const struct gp_read_params *p,
                         const struct gp_frame *f, struct gp_views *out)
{
    const struct gp_input *const in = gp_input_of(f);
    struct gp_read_params q = *p;
    struct gp_exr_choice choice;
    const char *view[GP_VIEWS_MAX] = {NULL}, *inner[VIEWS], *own;
    int named = 0;
    // the view that is taken by itself
    q.view = NULL;
    *out = (struct gp_views) {0};
    if (!in)
        return GP_OK;
    gp_status st = gp_exr_choose(NULL, &q, in, 0, &choice);
    if (!st && views_of(in, choice.part, inner) > 0) {
        const exr_attr_chlist_t *const list = in->each[choice.part].channel;
        const char *first = inner[0];
        for (int c = 0; c < 3; c++) {
            const int i = choice.colour.index[c];
            own = i < 0 ? NULL : gp_exr_view_of(in, choice.part,
                                                list->entries[i].name.str);
            first = own ? own : first;
        }
        add_view(view, &named, first);
    }
    for (int part = 0; part < in->parts; part++) {
        for (int i = 0, many = views_of(in, part, inner); i < many; i++)
            add_view(view, &named, inner[i]);
    }
    for (int i = 0; i < named && st != GP_ERR_BUG; i++) {
        q.view = view[i];
        st = gp_exr_choose(NULL, &q, in, 0, &choice);
        if (st) // it does not have the colour
            continue;
        out->name[out->n] = gp_strdup(view[i]);
        st = out->name[out->n] ? GP_OK : GP_ERR_BUG;
        out->n += !st;
    }
    if (st == GP_ERR_BUG || out->n < 2)
        gp_views_free(out);
    return st == GP_ERR_BUG ? gp_no_memory_bare(log, "view list") : GP_OK;
}
