#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "io/colour_name.h"

#include <string.h>

bool gp_exr_is_deep(const struct gp_input *o, int part)
{
    exr_storage_t storage;
    return exr_get_storage(o->exr, part, &storage) ||
           storage == EXR_STORAGE_DEEP_SCANLINE ||
           storage == EXR_STORAGE_DEEP_TILED;
}

const char *gp_exr_part_name(const struct gp_input *o, int part)
{
    const char *name = NULL;
    if (exr_get_name(o->exr, part, &name) || !name || !name[0])
        return NULL;
    return name;
}

const char *gp_exr_part_view(const struct gp_input *o, int part)
{
    int32_t length;
    const char *view;
    return exr_attr_get_string(o->exr, part, "view", &length, &view) ? NULL
                                                                     : view;
}

size_t gp_exr_part_layer(const struct gp_input *o, int part,
                         const char **name)
{
    const char *own = gp_exr_part_name(o, part);
    const char *view = gp_exr_part_view(o, part);
    *name = own ? own : "";
    const size_t n = strlen(*name), end = view ? strlen(view) : 0;
    if (end == 0 || n < end + 2 || strcmp(own + n - end, view) != 0)
        return n;
    const char before = own[n - end - 1];
    return before == '.' || before == '_' ? n - end - 1 : n;
}

static const exr_attr_string_vector_t *view_list(const struct gp_input *o,
                                                 int part)
{
    const exr_attribute_t *a;
    if (exr_get_attribute_by_name(o->exr, part, "multiView", &a) ||
        a->type != EXR_ATTR_STRING_VECTOR)
        return NULL;
    return a->stringvector;
}

int gp_exr_views(const struct gp_input *o, int part)
{
    const exr_attr_string_vector_t *v = view_list(o, part);
    if (!v)
        return 0;
    return v->n_strings < GP_EXR_VIEWS ? v->n_strings : GP_EXR_VIEWS;
}

const char *gp_exr_view_name(const struct gp_input *o, int part, int i)
{
    const exr_attr_string_vector_t *v = view_list(o, part);
    return v && i < v->n_strings && v->strings[i].str ? v->strings[i].str : "";
}

bool gp_exr_part_has_view(const struct gp_input *o, int part,
                          const char *view)
{
    const char *own = gp_exr_part_view(o, part);
    if (own)
        return strcmp(own, view) == 0;
    const int n = gp_exr_views(o, part);
    for (int i = 0; i < n; i++) {
        if (strcmp(gp_exr_view_name(o, part, i), view) == 0)
            return true;
    }
    return false;
}

static bool is_word(const char *from, size_t n, const char *word)
{
    return strlen(word) == n && strncmp(from, word, n) == 0;
}

bool gp_exr_bare_name(const struct gp_input *o, int part, const char *view,
                      const char *name, char *to)
{
    const char *dot = strrchr(name, '.'), *start = dot;
    const int n = gp_exr_part_view(o, part) ? 0 : gp_exr_views(o, part);
    strcpy(to, name);
    if (n == 0)
        return true;
    while (start && start > name && start[-1] != '.')
        start--;
    for (int i = 0; dot && i < n; i++) {
        if (!is_word(start, (size_t) (dot - start),
                     gp_exr_view_name(o, part, i)))
            continue;
        strcpy(to + (start - name), dot + 1);
        return is_word(start, (size_t) (dot - start), view);
    }
    return strcmp(gp_exr_view_name(o, part, 0), view) == 0;
}

void gp_exr_names_free(struct gp_exr_names *names)
{
    gp_free(names->name);
    gp_free(names->text);
    *names = (struct gp_exr_names) {0};
}

gp_status gp_exr_names_in(const struct gp_log *log, const struct gp_input *o,
                          int part, const char *view, struct gp_exr_names *out)
{
    const exr_attr_chlist_t *list;
    void *name = NULL, *text = NULL;
    size_t bytes = 1;
    *out = (struct gp_exr_names) {0};
    if (exr_get_channels(o->exr, part, &list))
        return GP_OK;
    for (int i = 0; i < list->num_channels; i++)
        bytes += strlen(list->entries[i].name.str) + 1;
    gp_status st = gp_alloc(log, "channel names", (size_t) list->num_channels,
                            sizeof(char *), &name);
    if (!st)
        st = gp_alloc(log, "channel names", bytes, 1, &text);
    *out = (struct gp_exr_names) {name, text, st ? 0 : list->num_channels};
    char *to = text;
    for (int i = 0; i < out->n; i++) {
        const char *const own = list->entries[i].name.str;
        out->name[i] = own;
        if (view)
            out->name[i] = gp_exr_bare_name(o, part, view, own, to) ? to : "";
        to += strlen(own) + 1;
    }
    if (st)
        gp_exr_names_free(out);
    return st;
}

const char *gp_exr_view_of(const struct gp_input *o, int part,
                           const char *name)
{
    char bare[GP_CHANNEL_NAME + 1];
    for (int i = 1; i < gp_exr_views(o, part) && strlen(name) < sizeof bare;
         i++) {
        const char *const view = gp_exr_view_name(o, part, i);
        if (gp_exr_bare_name(o, part, view, name, bare) &&
            strlen(bare) < strlen(name))
            return view;
    }
    return NULL;
}

/* -- Cryptomatte ----------------------------------------------------------- */

/* cryptomatte/HASH/name */
static bool names_layer(const exr_attribute_t *a)
{
    static const char first[] = "cryptomatte/", last[] = "/name";
    const size_t len = strlen(a->name), end = sizeof last - 1;
    return a->type == EXR_ATTR_STRING && len > sizeof first - 1 + end &&
           strncmp(a->name, first, sizeof first - 1) == 0 &&
           strcmp(a->name + len - end, last) == 0;
}

void gp_exr_crypto(const struct gp_input *o, struct gp_crypto *out)
{
    *out = (struct gp_crypto) {0};
    for (int part = 0; o && o->exr && part < o->parts; part++) {
        int32_t n = 0;
        if (exr_get_attribute_count(o->exr, part, &n))
            continue;
        for (int32_t i = 0; i < n && out->n < GP_CRYPTO_LAYERS; i++) {
            const exr_attribute_t *a;
            if (!exr_get_attribute_by_index(o->exr, part,
                                            EXR_ATTR_LIST_FILE_ORDER, i, &a) &&
                names_layer(a) && a->string->str && a->string->str[0])
                out->layer[out->n++] = a->string->str;
        }
    }
}

enum gp_crypto_kind gp_exr_crypto_channel(const struct gp_crypto *c,
                                      const struct gp_input *o, int part,
                                      const char *name)
{
    size_t len = gp_layer_length(name);
    if (len > 0)
        return gp_crypto_layer(c, name, len - 1);
    if (!o || !o->exr)
        return GP_CRYPTO_NONE;
    const char *layer;
    len = gp_exr_part_layer(o, part, &layer);
    return gp_crypto_layer(c, layer, len);
}
