/* Layers of three channels beside the colour: normals, albedo. */
#include "io/plane.h"

#include "core/memory.h"
#include "io/channels.h"
#include "io/exr/exr.h"
#include "io/io_priv.h"

#include <stdio.h>
#include <string.h>

enum { FULL = 2 * (GP_CHANNEL_NAME + 1) }; // bytes of PART.CHANNEL

/* Channels of one part, and the colour by whose layer they are chosen. */
struct names {
    const char *part; // before each name, of `part_len` bytes; "" for none
    int part_len;
    const char **name; // owned; "" for channels of other views
    int n;
    char colour[FULL];
};

/* Three channels of a part. */
struct three {
    int index[3];
    int second; // first channel of another layer of equal rank, or -1
};

static void full_name(const struct names *in, const char *name, char to[FULL])
{
    snprintf(to, FULL, "%.*s%s%s", in->part_len, in->part,
             in->part_len ? "." : "", name);
}

/* Finds the channels that are called last[] in the layer of a channel. */
static bool find_siblings(const struct names *in, int of,
                          const char *const last[3], int index[3])
{
    const size_t layer = gp_layer_length(in->name[of]);
    for (int c = 0; c < 3; c++) {
        index[c] = -1;
        for (int i = 0; i < in->n && index[c] < 0; i++) {
            if (gp_layer_length(in->name[i]) == layer &&
                strncmp(in->name[i], in->name[of], layer) == 0 &&
                strcmp(in->name[i] + layer, last[c]) == 0)
                index[c] = i;
        }
    }
    return index[0] >= 0 && index[1] >= 0 && index[2] >= 0;
}

/* Finds a layer of that name among channels that begin as the first `skip`
 * bytes of the colour: directly in there, else the first deeper one. */
static bool find_named(const struct names *in, size_t skip, const char *layer,
                       const char *const last[3], struct three *out)
{
    char full[FULL], tail[64];
    const size_t n = (size_t) snprintf(tail, sizeof tail, "%s.%s", layer,
                                       last[0]);
    bool found = false;
    for (int i = 0; i < in->n; i++) {
        const char *const own = in->name[i];
        if (strcmp(own + gp_layer_length(own), last[0]) != 0)
            continue;
        full_name(in, own, full);
        const size_t length = strlen(full);
        if (length < skip + n || strncmp(full, in->colour, skip) != 0 ||
            strcmp(full + length - n, tail) != 0)
            continue;
        const bool exact = length == skip + n;
        int index[3];
        if ((!exact && full[length - n - 1] != '.') ||
            !find_siblings(in, i, last, index))
            continue;
        if (found && !exact) {
            out->second = out->second < 0 ? i : out->second;
            continue;
        }
        memcpy(out->index, index, sizeof index);
        out->second = -1;
        found = true;
        if (exact)
            return true;
    }
    return found;
}

/* Finds a layer in the colour's layer, in the layer around it, ..., anywhere. */
static bool find_three(const struct names *in,
                       const struct gp_layer_names *wanted, struct three *out)
{
    size_t skip = gp_layer_length(in->colour);
    for (bool last = false; !last;) {
        last = skip == 0;
        for (int l = 0; wanted->layer[l]; l++) {
            for (int k = 0; k < 3; k++) {
                if (find_named(in, skip, wanted->layer[l], wanted->channel[k],
                               out))
                    return true;
            }
        }
        for (skip -= skip > 0; skip > 0 && in->colour[skip - 1] != '.';)
            skip--;
    }
    return false;
}

/* Names a part's channels, those of the colour's part within its view. */
static gp_status name_part(const struct gp_log *log,
    const struct gp_plane_list *list, const struct gp_plane_part *part,
    const char ***bare, struct names *out)
{
    const struct gp_plane_part *const first = list->part;
    gp_status st;
    *out = (struct names) {.part = "", .n = part->channels};
    GP_TRY(gp_alloc(log, "channels", (size_t) out->n + 1, sizeof *out->name,
                    &out->name));
    if (part->colour && list->view)
        GP_TRY(gp_exr_names_in(log, list->input, part->part, list->view, bare));
    const char *colour = list->colour ? list->colour : "";
    for (int i = 0; i < out->n; i++) {
        out->name[i] = *bare ? (*bare)[i] : part->channel[i].name;
        if (*bare && strcmp(part->channel[i].name, colour) == 0)
            colour = out->name[i];
    }
    if (!part->colour) {
        struct names of = {.part = ""};
        of.part_len = (int) gp_exr_part_layer(list->input, first->part,
                                              &of.part);
        full_name(&of, colour, out->colour);
        out->part_len = (int) gp_exr_part_layer(list->input, part->part,
                                                &out->part);
    } else {
        snprintf(out->colour, sizeof out->colour, "%s", colour);
    }
out:
    return st;
}

/* Warns of a choice between equals, and of a layer that is not the colour's. */
static void warn_of_choice(const struct gp_log *log, const char *path,
                           const struct names *in, const struct three *three,
                           const char *what)
{
    char used[FULL], other[FULL];
    full_name(in, in->name[three->index[0]], used);
    const size_t own = gp_layer_length(used);
    size_t around = own - (own > 0);
    while (around > 0 && used[around - 1] != '.')
        around--;
    if (three->second >= 0) {
        full_name(in, in->name[three->second], other);
        gp_say(log, GP_LEVEL_WARN, "%s: two layers could be %s: using %.*s, "
               "not %.*s; choose the colour of either with --layer-in", path,
               what, (int) own - 1, used, (int) gp_layer_length(other) - 1,
               other);
    } else if (in->part_len == 0 && around > 0 && strchr(in->colour, '.') &&
               strncmp(in->colour, used, around) != 0) {
        gp_say(log, GP_LEVEL_WARN, "%s: the layer of %s has no %s: using %.*s "
               "of another layer; choose the colour with --layer-in", path,
               in->colour, what, (int) own - 1, used);
    }
}

gp_status gp_read_vectors(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f,
    const struct gp_layer_names *wanted, struct gp_plane out[3])
{
    struct gp_plane_list list;
    struct gp_plane plane[3] = {{.v = NULL}};
    gp_status st;
    bool found = false;
    GP_TRY(gp_plane_list_frame(log, f, false, &list));
    for (int i = 0; i < list.parts && !found && !st; i++) {
        const struct gp_plane_part *const part = &list.part[i];
        if (part->deep || (part->view && list.part->view &&
                           strcmp(part->view, list.part->view) != 0))
            continue;
        const char **bare = NULL;
        struct names names;
        struct three three = {.second = -1};
        st = name_part(log, &list, part, &bare, &names);
        found = !st && find_three(&names, wanted, &three);
        if (found)
            warn_of_choice(log, f->path, &names, &three, wanted->what);
        for (int c = 0; c < 3 && found && !st; c++) {
            const struct gp_plane_place at = {part, three.index[c]};
            st = gp_plane_read_at(log, p, f, &list, &at, &plane[c]);
        }
        gp_free(names.name);
        gp_free(bare);
    }
    if (!st && !found)
        st = gp_fail(log, GP_ERR_USAGE, "%s: --relight needs %s, and no "
                     "channel of its colour's view is %s.%s; render them into "
                     "it", f->path, wanted->what, wanted->layer[0],
                     wanted->channel[0][0]);
out:
    for (int c = 0; c < 3; c++) {
        if (st)
            gp_plane_free(&plane[c]);
        else
            out[c] = plane[c];
    }
    gp_plane_list_free(&list);
    return st;
}
