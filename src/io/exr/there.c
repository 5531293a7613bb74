/* What an EXR has, for the line that says that something is not there. */
#include "io/exr/exr_priv.h"

#include "io/colour_name.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Each list is cut after so many bytes or names. */
enum { LIST_BYTES = 400, LIST_NAMES = 32 };

struct list {
    char text[LIST_BYTES];
    struct {
        size_t at, len;
    } name[LIST_NAMES];
    int n;
    bool cut;
};

static bool has(const struct list *l, const char *name, size_t len)
{
    for (int i = 0; i < l->n; i++) {
        if (l->name[i].len == len &&
            strncmp(l->text + l->name[i].at, name, len) == 0)
            return true;
    }
    return false;
}

/* Adds a name that is not there yet; `number` >= 0 goes before it. */
static void add(struct list *l, int number, const char *name, size_t len)
{
    const size_t used = strlen(l->text), room = sizeof l->text - used;
    char head[16] = "";
    if (l->cut || len == 0 || (number < 0 && has(l, name, len)))
        return;
    if (number >= 0)
        snprintf(head, sizeof head, "%d ", number);
    l->cut = l->n == LIST_NAMES || len + strlen(head) + 10 > room;
    if (l->cut) {
        snprintf(l->text + used, room, ", ...");
        return;
    }
    snprintf(l->text + used, room, "%s%s%.*s", l->n ? ", " : "", head,
             (int) len, name);
    l->name[l->n].at = strlen(l->text) - len;
    l->name[l->n++].len = len;
}

static bool is_colour(const char *own)
{
    return strcmp(own, "R") == 0 || strcmp(own, "Y") == 0 ||
           strcasecmp(own, "red") == 0;
}

static void add_layers(const struct gp_crypto *crypto,
                       const struct gp_input *o, int part, struct list *l)
{
    const exr_attr_chlist_t *from;
    const char *name;
    if (exr_get_channels(o->exr, part, &from))
        return;
    for (int i = 0; !l->cut && i < from->num_channels; i++) {
        const char *channel = from->entries[i].name.str;
        size_t len = gp_layer_length(channel);
        if (!is_colour(channel + len) ||
            gp_exr_crypto_channel(crypto, o, part, channel))
            continue;
        if (len > 0) {
            add(l, -1, channel, len - 1);
        } else if (o->parts > 1) {
            len = gp_exr_part_layer(o, part, &name);
            add(l, -1, name, len);
        }
    }
}

static void add_views(const struct gp_input *o, int part, struct list *l)
{
    const char *view = gp_exr_part_view(o, part);
    if (view)
        add(l, -1, view, strlen(view));
    const int n = view ? 0 : gp_exr_views(o, part);
    for (int i = 0; !l->cut && i < n; i++) {
        view = gp_exr_view_name(o, part, i);
        add(l, -1, view, strlen(view));
    }
}

/* Whether `layer` is one of ids: CryptoObject00, CryptoObject, or one of its
 * channels. */
static bool is_ids(const struct gp_crypto *crypto, const struct gp_input *o,
                   const char *layer)
{
    const size_t len = strlen(layer);
    for (int part = 0; part < o->parts; part++) {
        const exr_attr_chlist_t *from;
        const char *name;
        size_t n = gp_exr_part_layer(o, part, &name);
        if (gp_crypto_layer(crypto, name, n) &&
            (n == len || n == len + 2) && strncmp(name, layer, len) == 0)
            return true;
        if (exr_get_channels(o->exr, part, &from))
            continue;
        for (int i = 0; i < from->num_channels; i++) {
            name = from->entries[i].name.str;
            if (strncmp(name, layer, len) != 0 ||
                !gp_exr_crypto_channel(crypto, o, part, name))
                continue;
            n = gp_layer_length(name);
            if (!name[len] || n == len + 1 || n == len + 3)
                return true;
        }
    }
    return false;
}

/* What is asked for, as "layer a in part 2 of view left". */
static void describe(const struct gp_read_params *p, const struct gp_input *o,
                     char *to, size_t size)
{
    bool known = !p->view;
    for (int part = 0; part < o->parts && !known; part++)
        known = gp_exr_part_has_view(o, part, p->view);
    if (p->part && gp_exr_part_number(o, p->part) < 0)
        snprintf(to, size, "part %.200s", p->part);
    else if (!known)
        snprintf(to, size, "view %.200s", p->view);
    else
        snprintf(to, size, "%s%.200s%s%.200s%s%.200s",
                 p->layer ? "layer " : "colour", p->layer ? p->layer : "",
                 p->part ? " in part " : "", p->part ? p->part : "",
                 p->view ? " of view " : "", p->view ? p->view : "");
}

gp_status gp_exr_not_there(const struct gp_log *log,
                           const struct gp_read_params *p, const char *path,
                           const struct gp_input *o)
{
    struct gp_crypto crypto;
    struct list layers = {0}, parts = {0}, views = {0};
    char what[700];
    gp_exr_crypto(o, &crypto);
    for (int part = 0; part < o->parts; part++) {
        const char *name = gp_exr_part_name(o, part);
        add_layers(&crypto, o, part, &layers);
        add_views(o, part, &views);
        add(&parts, part, name ? name : "-", name ? strlen(name) : 1);
    }
    const char *has_layers = layers.n ? layers.text : "none";
    if (p->layer && is_ids(&crypto, o, p->layer))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: layer %.200s is Cryptomatte: ids are no light and "
                       "are never filtered (layers of light: %s); give one of "
                       "those", path, p->layer, has_layers);
    describe(p, o, what, sizeof what);
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: has no %s (layers: %s; parts: %s; views: %s); give one "
                   "of those", path, what, has_layers, parts.text,
                   views.n ? views.text : "none");
}
