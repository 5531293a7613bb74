#include "io/plane_find.h"

#include "core/memory.h"
#include "io/channels.h"
#include "io/colour.h"
#include "io/exr/exr.h"

#include <stdio.h>
#include <string.h>

/* -- the list ------------------------------------------------------------- */

static gp_status make_list(const struct gp_log *log, int parts, int channels,
                           struct gp_plane_list *list)
{
    void *p;
    gp_status st = gp_alloc_zero(log, "parts", (size_t) parts,
                                 sizeof *list->part, &p);
    list->part = p;
    if (st)
        return st;
    st = gp_alloc_zero(log, "channels", (size_t) channels,
                       sizeof *list->channel, &p);
    list->channel = p;
    return st;
}

void gp_plane_list_free(struct gp_plane_list *list)
{
    gp_free(list->part);
    gp_free(list->channel);
    *list = (struct gp_plane_list) {0};
}

gp_status gp_plane_list_one(const struct gp_log *log, const char *path,
                            bool colour, int channels,
                            struct gp_plane_list *list)
{
    *list = (struct gp_plane_list) {.path = path};
    gp_status st = make_list(log, 1, channels, list);
    if (st)
        return st;
    list->parts = 1;
    list->channels = channels;
    list->part[0] = (struct gp_plane_part) {
        .colour = colour, .channel = list->channel, .channels = channels,
    };
    return GP_OK;
}

/* The channels of a part; none where the library has no list. */
static const exr_attr_chlist_t *channels_of(const struct gp_input *o,
                                            int part)
{
    static const exr_attr_chlist_t none;
    const exr_attr_chlist_t *list;
    return exr_get_channels(o->exr, part, &list) ? &none : list;
}

static bool other_view(const char *a, const char *b)
{
    return a && b && strcmp(a, b) != 0;
}

enum { ORDERS = 8 }; // values of order_of()

/* Smaller is searched first, the colour's part aside. */
static int order_of(const struct gp_input *o, int part, bool colour,
                    bool depth)
{
    const char *name = gp_exr_part_name(o, part);
    const bool far = colour && other_view(gp_exr_part_view(o, part),
                                          gp_exr_part_view(o, o->part));
    const bool plain = depth && !(name && strcasestr(name, "depth"));
    return 4 * gp_exr_is_deep(o, part) + 2 * far + plain;
}

static void add_part(const struct gp_input *o, int part, bool colour,
                     struct gp_plane_list *list)
{
    const exr_attr_chlist_t *const from = channels_of(o, part);
    struct gp_plane_part *to = &list->part[list->parts++];
    *to = (struct gp_plane_part) {
        .part = part, .name = gp_exr_part_name(o, part),
        .view = gp_exr_part_view(o, part),
        .colour = colour, .deep = gp_exr_is_deep(o, part),
        .channel = list->channel + list->channels,
        .channels = from->num_channels,
    };
    for (int i = 0; i < to->channels; i++)
        to->channel[i].name = (char *) (uintptr_t) from->entries[i].name.str;
    list->channels += to->channels;
}

gp_status gp_plane_list_exr(const struct gp_log *log, const char *path,
                            const struct gp_input *o, bool colour, bool depth,
                            struct gp_plane_list *list)
{
    int channels = 0;
    *list = (struct gp_plane_list) {.path = path};
    for (int part = 0; part < o->parts; part++)
        channels += channels_of(o, part)->num_channels;
    gp_status st = make_list(log, o->parts, channels, list);
    if (st)
        return st;
    if (colour)
        add_part(o, o->part, true, list);
    for (int order = 0; order < ORDERS; order++) {
        for (int part = 0; part < o->parts; part++) {
            if (!(colour && part == o->part) &&
                order_of(o, part, colour, depth) == order)
                add_part(o, part, false, list);
        }
    }
    return GP_OK;
}

/* -- by name -------------------------------------------------------------- */

/* The first channel of that name in any part. */
static bool find_exact(const struct gp_plane_list *list, const char *name,
                       struct gp_plane_place *out)
{
    for (int p = 0; p < list->parts; p++) {
        const struct gp_plane_part *part = &list->part[p];
        for (int i = 0; i < part->channels; i++) {
            if (strcmp(part->channel[i].name, name) == 0) {
                *out = (struct gp_plane_place) {part, i};
                return true;
            }
        }
    }
    return false;
}

/* The channel in the view that is looked for: left.A for A. */
static bool find_in_view(const struct gp_plane_list *list, const char *name,
                         struct gp_plane_place *out)
{
    char full[2 * (GP_CHANNEL_NAME + 1)];
    const char *const dot = strrchr(name, '.');
    const int layer = dot ? (int) (dot - name) + 1 : 0;
    if (!list->view)
        return false;
    const int n = snprintf(full, sizeof full, "%.*s%s.%s", layer, name,
                           list->view, name + layer);
    return n < (int) sizeof full && find_exact(list, full, out);
}

/* PART.CHANNEL; both may hold dots. */
static bool find_in_part(const struct gp_plane_list *list, const char *name,
                         struct gp_plane_place *out)
{
    for (int p = 0; p < list->parts; p++) {
        const struct gp_plane_part *part = &list->part[p];
        const size_t n = part->name ? strlen(part->name) : 0;
        if (n == 0 || strncmp(name, part->name, n) != 0 || name[n] != '.')
            continue;
        for (int i = 0; i < part->channels; i++) {
            if (strcmp(part->channel[i].name, name + n + 1) == 0) {
                *out = (struct gp_plane_place) {part, i};
                return true;
            }
        }
    }
    return false;
}

static void list_names(const struct gp_plane_list *list,
                       char to[GP_CHANNEL_LIST])
{
    to[0] = '\0';
    for (int p = 0; p < list->parts; p++) {
        const struct gp_plane_part *part = &list->part[p];
        const bool plain = part->colour || list->parts == 1;
        for (int i = 0; i < part->channels; i++) {
            if (!gp_channel_list_add(to, plain ? NULL : part->name,
                                     part->channel[i].name))
                return;
        }
    }
}

/* -- by search ------------------------------------------------------------ */

static gp_status depth_of_names(const struct gp_log *log,
                                const struct gp_plane_list *list,
                                struct gp_channel *channel, int n, int *out)
{
    const struct gp_frame names = {
        .path = (char *) (uintptr_t) list->path,
        .channel = channel, .channels = n,
    };
    return gp_find_depth(log, &names, NULL, out);
}

static gp_status depth_of_view(const struct gp_log *log,
                               const struct gp_plane_list *list,
                               const struct gp_plane_part *part, int *out)
{
    struct gp_exr_names bare;
    void *block = NULL;
    gp_status st = gp_exr_names_in(log, list->input, part->part, list->view,
                                   &bare);
    if (!st)
        st = gp_alloc_zero(log, "channels", (size_t) bare.n,
                           sizeof(struct gp_channel), &block);
    struct gp_channel *const channel = block;
    for (int i = 0; i < bare.n && !st; i++)
        channel[i].name = (char *) (uintptr_t) bare.name[i];
    if (!st)
        st = depth_of_names(log, list, channel, bare.n, out);
    gp_free(channel);
    gp_exr_names_free(&bare);
    return st;
}

static gp_status search_depth(const struct gp_log *log,
                              const struct gp_plane_list *list,
                              struct gp_plane_place *out)
{
    const struct gp_plane_part *const first = list->part;
    int i = -1;
    if (list->view) {
        gp_status st = depth_of_view(log, list, first, &i);
        *out = (struct gp_plane_place) {i < 0 ? NULL : first, i};
        if (st || i >= 0)
            return st;
    }
    for (int p = 0; p < list->parts; p++) {
        const struct gp_plane_part *const part = &list->part[p];
        gp_status st = depth_of_names(log, list, part->channel,
                                      part->channels, &i);
        if (st)
            return st;
        if (i < 0)
            continue;
        if (list->view && part == first)
            gp_say(log, GP_LEVEL_WARN,
                   "%s: depth %s of another view is taken for view %s, which "
                   "has none; choose with --depth or --depth-file",
                   list->path, part->channel[i].name, list->view);
        *out = (struct gp_plane_place) {part, i};
        break;
    }
    return GP_OK;
}

/* The only channel of the file; beside others, alpha is no depth. */
static void search_lone(const struct gp_plane_list *list, bool depth,
                        struct gp_plane_place *out)
{
    struct gp_plane_place lone = {0};
    for (int p = 0; p < list->parts; p++) {
        const struct gp_plane_part *part = &list->part[p];
        for (int i = 0; i < part->channels; i++) {
            const bool alpha = strcmp(part->channel[i].name, "A") == 0;
            if (depth && alpha && list->channels > 1)
                continue;
            if (lone.part)
                return;
            lone = (struct gp_plane_place) {part, i};
        }
    }
    *out = lone;
}

static gp_status not_found(const struct gp_log *log,
                           const struct gp_plane_list *list, bool depth)
{
    char names[GP_CHANNEL_LIST];
    list_names(list, names);
    return gp_fail(log, GP_ERR_USAGE,
                   depth ? "%s: no channel is clearly depth (it has %s); name "
                           "one with --depth"
                         : "%s: has no alpha, and not one channel only (it "
                           "has %s); name one with --mask",
                   list->path, names);
}

/* Says what a search found that its user might not expect. */
static void tell(const struct gp_log *log, const struct gp_plane_list *list,
                 struct gp_plane_place *at, bool whole)
{
    const char *const view = list->part[0].view;
    if (!at->part || whole)
        return;
    if (at->part->deep) {
        gp_say(log, GP_LEVEL_WARN,
               "%s: depth is only in part %d, which is deep and is not read; "
               "flatten it, with e.g. oiiotool --flatten", list->path,
               at->part->part);
        *at = (struct gp_plane_place) {0};
    } else if (other_view(at->part->view, view)) {
        gp_say(log, GP_LEVEL_WARN,
               "%s: depth of view %s is taken for colour of view %s, which "
               "has none; choose with --depth or --depth-file", list->path,
               at->part->view, view);
    }
}

gp_status gp_plane_pick(const struct gp_log *log,
                        const struct gp_plane_list *list, const char *name,
                        bool depth, bool whole, struct gp_plane_place *out)
{
    gp_status st = GP_OK;
    struct gp_plane_place at = {0};
    if (name) {
        char names[GP_CHANNEL_LIST];
        if (find_in_view(list, name, out) || find_exact(list, name, out) ||
            find_in_part(list, name, out))
            return GP_OK;
        list_names(list, names);
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: has no channel %s (it has %s); give one of those",
                       list->path, name, names);
    }
    if (depth)
        GP_TRY(search_depth(log, list, &at));
    else if (!find_in_view(list, "A", &at))
        find_exact(list, "A", &at);
    if (!at.part && whole)
        search_lone(list, depth, &at);
    if (!at.part && whole)
        return not_found(log, list, depth);
    tell(log, list, &at, whole);
    *out = at;
out:
    return st;
}
