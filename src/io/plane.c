// SPDX-License-Identifier: Apache-2.0
#include "io/plane.h"

#include "core/memory.h"
#include "io/channels.h"
#include "io/exr/exr.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { FULL = 2 * (GP_CHANNEL_NAME + 1) }; // bytes of PART.CHANNEL
enum kind { COVERAGE, DEPTH, MASK };       // of what is looked for

/* -- the parts of a file -------------------------------------------------- */

/* One part and its channels, of which only names are used. */
struct part {
    int number;              // in the file
    const struct gp_exr_part *own; // of an EXR, else without a name; borrowed
    bool colour;             // it holds the frame's colour
    bool inner;              // the channels' names in the colour's view, "" for
                             // others; the part itself follows
    bool other;              // of another view than the colour's part
    const char *by;          // a channel of the frame's colour, or NULL
    const struct gp_channel *channel;
    int channels;
};

/* All parts of a file in the order in which they are searched. */
struct list {
    const char *path;            // for messages; borrowed
    const struct gp_input *in;   // of an EXR; borrowed
    struct part *part;
    int parts;
    struct gp_channel *channel;  // names are borrowed
    int channels;                // of all parts
    const char **bare;           // names of an inner part; NULL: none
};

static const struct gp_exr_part unnamed = {.layer = ""};

/* The result: a part of the list and a channel of it. Nothing when `part` is
 * NULL. */
struct place {
    const struct part *part;
    int channel; // index in its part, which is the file's order
};

static void free_list(struct list *list)
{
    gp_free(list->part);
    gp_free(list->channel);
    gp_free(list->bare);
}

static gp_status alloc_list(const struct gp_log *log, int parts, int channels,
                            struct list *list)
{
    const gp_status st = gp_alloc_zero(log, "parts", (size_t) parts,
                                       sizeof *list->part, &list->part);
    return st ? st : gp_alloc_zero(log, "channels", (size_t) channels,
                                   sizeof *list->channel, &list->channel);
}

/* Lists the parts of an EXR as plane.h orders them; after those called depth
 * those in the layer around the colour's (B.Depth for B.Combined); deep last. The
 * colour is a channel of o->part, or NULL. */
static gp_status list_exr(const struct gp_log *log, const struct gp_input *o,
                          const char *colour, bool depth, struct list *list)
{
    int channels = 0;
    gp_status st;
    const char *const view = colour ? gp_exr_view_of(o, o->part, colour) : NULL;
    list->in = o;
    for (int part = 0; part < o->parts; part++)
        channels += o->each[part].channel->num_channels;
    GP_TRY(alloc_list(log, o->parts + 1, 2 * channels, list));
    if (view)
        GP_TRY(gp_exr_names_in(log, o, o->part, view, &list->bare));
    const struct gp_exr_part *const own = &o->each[o->part];
    const size_t n = colour ? gp_last_part(own->layer, own->length) : 0;
    for (int order = -1; order < 16; order++) { // the colour's part first
        for (int part = 0; part < o->parts; part++) {
            const struct gp_exr_part *const from = &o->each[part];
            struct part to = {
                .number = part,
                .own = from,
                .colour = colour && part == o->part,
                .other = colour && gp_exr_other_view(o, part, o->part),
                .channels = from->channel->num_channels,
            };
            const char *const name = from->name ? from->name : "";
            const bool plain = depth && !strcasestr(name, "depth");
            const bool far = n > 0 && strncmp(name, own->layer, n) != 0;
            if ((to.colour ? -1
                           : 8 * from->deep + 4 * to.other + 2 * plain + far) !=
                order)
                continue;
            for (int inner = to.colour && view; inner >= 0; inner--) {
                struct gp_channel *const channel =
                    list->channel + list->channels;
                to.channel = channel;
                to.inner = inner;
                to.by = colour;
                for (int i = 0; i < to.channels; i++) {
                    const char *const full = from->channel->entries[i].name.str;
                    channel[i].name =
                        (char *) (uintptr_t) (inner ? list->bare[i] : full);
                    if (inner && colour && strcmp(full, colour) == 0)
                        to.by = list->bare[i];
                }
                list->part[list->parts++] = to;
                list->channels += to.channels;
            }
        }
    }
out:
    return st;
}

/* Lists the parts of a frame's file; free with free_list() in any case. */
static gp_status list_frame(const struct gp_log *log, const struct gp_frame *f,
                            bool depth, struct list *list)
{
    gp_status st;
    *list = (struct list) {.path = f->path};
    if (gp_input_of(f)) {
        GP_TRY(list_exr(log, gp_input_of(f), gp_frame_colour(f), depth, list));
    } else {
        GP_TRY(alloc_list(log, 1, 0, list));
        list->part[list->parts++] = (struct part) {
            .own = &unnamed,
            .colour = true,
            .by = gp_frame_colour(f),
            .channel = f->channel,
            .channels = f->channels,
        };
        list->channels = f->channels;
    }
out:
    return st;
}

/* -- by name -------------------------------------------------------------- */

/* The first channel of that name, or of PART.CHANNEL with `in_part`. */
static bool find_exact(const struct list *list, const char *name,
                       bool in_part, struct place *out)
{
    for (int p = 0; p < list->parts; p++) {
        const struct part *part = &list->part[p];
        const char *const own = part->own->name;
        const size_t n = in_part && own ? strlen(own) : 0;
        if (in_part && (part->inner || n == 0 || strncmp(name, own, n) != 0 ||
                        name[n] != '.'))
            continue;
        const char *const channel = name + (in_part ? n + 1 : 0);
        for (int i = 0; i < part->channels; i++) {
            if (strcmp(part->channel[i].name, channel) == 0) {
                *out = (struct place) {part, i};
                return true;
            }
        }
    }
    return false;
}

static void list_names(const struct list *list,
                       char to[GP_CHANNEL_LIST])
{
    to[0] = '\0';
    for (int p = 0; p < list->parts; p++) {
        const struct part *part = &list->part[p];
        const bool plain = part->colour || list->parts == 1;
        for (int i = 0; i < part->channels && !part->inner; i++)
            gp_channel_list_add(to, plain ? NULL : part->own->name,
                                part->channel[i].name);
    }
}

/* -- by search ------------------------------------------------------------ */

static gp_status search_depth(const struct gp_log *log, const struct list *list,
                              struct place *out)
{
    gp_status st = GP_OK;
    int i = -1;
    for (int p = 0; p < list->parts && !st && i < 0; p++) {
        const struct part *const part = &list->part[p];
        if (!gp_is_mist(part->own->layer, part->own->length)) // a fog's factor
            st = gp_find_depth(log, list->path, part->channel, part->channels,
                               part->by, &i);
        if (i >= 0)
            *out = (struct place) {part, i};
    }
    return st;
}

/* The channel's name after that of its part. */
static void full_name(const struct list *list,
                      const struct part *part, const char *channel,
                      char to[FULL])
{
    const bool named = part->own->name && list->parts > 1 + list->part->inner;
    snprintf(to, FULL, "%s%s%s", named ? part->own->name : "", named ? "." : "",
             channel);
}

/* True for depth of another view of the part, or of another layer around it
 * than the colour's: A.Depth.Z for B.Combined.R. */
static bool of_other_layer(const struct list *list,
                           const struct place *at)
{
    char depth[FULL], colour[sizeof depth];
    full_name(list, at->part, at->part->channel[at->channel].name, depth);
    const struct part *const first = list->part + list->part->inner;
    full_name(list, first, first->by ? first->by : "", colour);
    const char *const word = strcasestr(depth, "depth");
    const size_t last = gp_last_part(depth, strlen(depth));
    const size_t n = word   ? gp_last_part(depth, (size_t) (word - depth))
                     : last ? gp_last_part(depth, last - 1) : 0;
    const size_t own = gp_last_part(colour, strlen(colour));
    const bool in_view =
        !list->bare || at->part != first || list->bare[at->channel][0];
    return !in_view || (n > 0 && own > 0 && gp_last_part(colour, own - 1) > 0 &&
                        strncmp(colour, depth, n) != 0);
}

/* The only channel of the file; beside others, alpha is no depth. */
static void search_lone(const struct list *list, bool depth,
                        struct place *out)
{
    struct place lone = {0};
    for (int p = 0; p < list->parts; p++) {
        const struct part *part = &list->part[p];
        for (int i = 0; i < part->channels; i++) {
            const bool alpha = strcmp(part->channel[i].name, "A") == 0;
            if (depth && alpha && list->channels > 1)
                continue;
            if (lone.part)
                return;
            lone = (struct place) {part, i};
        }
    }
    *out = lone;
}

/* Finds a channel by its name; by NULL depth or A. In a file of its own
 * (`own_file`) the only channel is taken too, of a mask R, and none is an
 * error. */
static gp_status pick(const struct gp_log *log, const struct list *list,
                      const char *name, enum kind kind, bool own_file,
                      struct place *out)
{
    const bool depth = kind == DEPTH;
    gp_status st = GP_OK;
    struct place at = {0};
    char names[GP_CHANNEL_LIST];
    list_names(list, names);
    if (name) {
        if (find_exact(list, name, false, out) ||
            find_exact(list, name, true, out)) {
            out->part += out->part->inner;
            return GP_OK;
        }
        return gp_fail(log, GP_ERR_USAGE, "%s: has no channel %s (it has %s)%s",
                       list->path, name, names,
                       kind == MASK
                           ? ", nor is there such a file; give one of both"
                           : "; give one of those");
    }
    if (depth)
        GP_TRY(search_depth(log, list, &at));
    else
        find_exact(list, "A", false, &at);
    if (!at.part && own_file)
        search_lone(list, depth, &at);
    if (!at.part && kind == MASK)
        find_exact(list, "R", false, &at);
    if (!at.part && own_file)
        return gp_fail(log, GP_ERR_USAGE,
                       depth ? "%s: no channel is clearly depth (it has %s); "
                               "name one with --depth"
                       : kind == MASK
                           ? "%s: has no A, R or single channel (it "
                             "has %s); rename one A"
                           : "%s: has neither alpha nor a single channel "
                             "(it has %s); name one with --mask",
                       list->path, names);
    if (at.part)
        at.part += at.part->inner;
    // warns of what the user of a frame may not expect
    if (at.part && !own_file && at.part->own->deep) {
        gp_say(log, GP_LEVEL_WARN,
               "%s: only part %d has depth, and deep parts are not read; "
               "flatten it, with e.g. oiiotool --flatten", list->path,
               at.part->number);
        at = (struct place) {0};
    } else if (at.part && !own_file &&
               (at.part->other || (depth && of_other_layer(list, &at)))) {
        full_name(list, at.part, at.part->channel[at.channel].name, names);
        gp_say(log, GP_LEVEL_WARN, "%s: the colour's layer and view have no "
               "%s: using %s of another; choose with %s", list->path,
               depth ? "depth" : "coverage", names,
               depth ? "--depth or --depth-file" : "--mask");
    }
    *out = at;
out:
    return st;
}

/* -- shared by the ways of reading ---------------------------------------- */

/* Makes the channel's name in the form of the report and --depth. */
static gp_status make_name(const struct gp_log *log, const struct list *list,
                           const struct place *at, struct gp_plane *out)
{
    char name[FULL];
    const char *const channel = at->part->channel[at->channel].name;
    full_name(list, at->part, channel, name);
    out->name = gp_strdup(at->part->colour ? channel : name);
    return out->name ? GP_OK : gp_no_memory_bare(log, "channel name");
}

static gp_status make_samples(const struct gp_log *log, struct gp_rect window,
                              struct gp_plane *out)
{
    out->window = window;
    return gp_alloc(log, "depth or coverage", gp_rect_pixels(window),
                    sizeof *out->v, &out->v);
}

/* -- from an EXR ---------------------------------------------------------- */

/* Reads `n` channels of one part from the file; those below 0 stay empty. */
static gp_status from_part(const struct gp_log *log,
                           const struct gp_read_params *p,
                           const struct gp_input *in, int part,
                           const int *channel, int n, struct gp_plane *out)
{
    gp_status st;
    float **to = NULL;
    struct gp_exr_chunks l;
    GP_TRY(gp_exr_chunks_find(log, in, part, false, p->max_pixels, &l));
    GP_TRY(gp_alloc_zero(log, "channels", (size_t) l.channel->num_channels,
                         sizeof *to, &to));
    for (int k = 0; k < n; k++) {
        if (channel[k] < 0)
            continue;
        GP_TRY(make_samples(log, l.window, &out[k]));
        to[channel[k]] = out[k].v;
    }
    GP_TRY(gp_exr_decode_full(log, &l, false, to));
out:
    gp_free(to);
    gp_exr_chunks_free(&l);
    return st;
}

/* -- beside a frame ------------------------------------------------------- */

/* Crops the plane to a window within its own. */
static void cut_plane(struct gp_rect window, struct gp_plane *p)
{
    const size_t all = (size_t) gp_rect_w(p->window);
    const size_t w = (size_t) gp_rect_w(window);
    const float *from = p->v + (size_t) (window.y0 - p->window.y0) * all +
                        (size_t) (window.x0 - p->window.x0);
    for (size_t y = 0; y < (size_t) gp_rect_h(window); y++, from += all)
        memmove(p->v + y * w, from, w * sizeof *from);
    p->window = window;
}

gp_status gp_read_channels(const struct gp_log *log,
                           const struct gp_read_params *p,
                           const struct gp_frame *f, int part,
                           const int *channel, int n, struct gp_plane *out)
{
    // colour is read again from an EXR: its planes may be converted (luminance
    // and chroma) or cleaned of NaN
    const struct gp_input *const in = gp_input_of(f);
    bool held = part == f->part;
    gp_status st = GP_OK;
    for (int k = 0; k < n && held && in; k++)
        held = channel[k] < 0 || f->channel[channel[k]].data;
    if (!held)
        return from_part(log, p, in, part, channel, n, out);
    for (int k = 0; k < n && !st; k++) {
        if (channel[k] < 0)
            continue;
        st = make_samples(log, f->data, &out[k]);
        if (st)
            break;
        gp_channel_floats(f, channel[k], out[k].v);
        cut_plane(gp_frame_read(f), &out[k]);
    }
    return st;
}

/* Finds a channel beside a frame: its name, and its `type` or its samples. */
static gp_status find_beside(const struct gp_log *log,
                             const struct gp_read_params *p,
                             const struct gp_frame *f, const char *name,
                             enum kind kind, enum gp_pixel_type *type,
                             struct gp_plane *out)
{
    struct list list;
    struct place at;
    gp_status st;
    *out = (struct gp_plane) {0};
    GP_TRY(list_frame(log, f, kind == DEPTH, &list));
    GP_TRY(pick(log, &list, name, kind, false, &at));
    if (at.part)
        GP_TRY(make_name(log, &list, &at, out));
    if (at.part && type)
        *type = at.part->colour
                    ? f->channel[at.channel].type
                    : (enum gp_pixel_type) list.in->each[at.part->number]
                          .channel->entries[at.channel]
                          .pixel_type;
    else if (at.part)
        GP_TRY(
            gp_read_channels(log, p, f, at.part->number, &at.channel, 1, out));
out:
    if (st)
        gp_plane_free(out);
    free_list(&list);
    return st;
}

gp_status gp_read_plane(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f, const char *name,
    bool depth, struct gp_plane *out)
{
    return find_beside(log, p, f, name, depth ? DEPTH : COVERAGE, NULL, out);
}

gp_status gp_name_depth(const struct gp_log *log, const struct gp_frame *f,
    const char *name, char **channel, enum gp_pixel_type *type)
{
    struct gp_plane named;
    const gp_status st = find_beside(log, NULL, f, name, DEPTH, type, &named);
    *channel = named.name;
    return st;
}

/* -- from a file of its own ----------------------------------------------- */

static gp_status read_file(const struct gp_log *log,
                           const struct gp_read_params *p, const char *path,
                           const char *name, enum kind kind,
                           struct gp_plane *out)
{
    gp_status st;
    struct gp_stored_file file;
    const struct gp_decoded *const image = &file.first;
    struct list list = {.path = path};
    struct place at;
    struct gp_plane plane = {0};
    GP_TRY(gp_stored_open(log, p, path, &file));
    if (file.input) {
        GP_TRY(list_exr(log, file.input, NULL, kind == DEPTH, &list));
    } else {
        GP_TRY(alloc_list(log, 1, image->channels, &list));
        for (; list.channels < image->channels; list.channels++)
            list.channel[list.channels].name =
                (char *) (uintptr_t) image->channel_name[list.channels];
        list.part[list.parts++] = (struct part) {
            .own = &unnamed,
            .channel = list.channel,
            .channels = list.channels,
        };
    }
    GP_TRY(pick(log, &list, name, kind, true, &at));
    GP_TRY(make_name(log, &list, &at, &plane));
    if (file.input) {
        GP_TRY(from_part(log, p, file.input, at.part->number, &at.channel, 1,
                         &plane));
    } else {
        GP_TRY(make_samples(log, image->data, &plane));
        gp_decoded_channel(image, at.channel, plane.v);
    }
    *out = plane;
    plane = (struct gp_plane) {0};
out:
    gp_plane_free(&plane);
    free_list(&list);
    gp_stored_close(&file);
    return st;
}

gp_status gp_read_plane_file(const struct gp_log *log,
                             const struct gp_read_params *p, const char *path,
                             const char *name, bool depth, struct gp_plane *out)
{
    return read_file(log, p, path, name, depth ? DEPTH : COVERAGE, out);
}

gp_status gp_read_mask(const struct gp_log *log, const struct gp_read_params *p,
                       const struct gp_frame *f, const char *name,
                       const char *path, struct gp_plane *out)
{
    // a pattern is one of files
    const bool file = strcmp(path, name) != 0 || access(path, F_OK) == 0;
    const gp_status st =
        find_beside(file ? NULL : log, p, f, name, MASK, NULL, out);
    return st && file ? read_file(log, p, path, NULL, MASK, out) : st;
}

/* -- layers of three channels ---------------------------------------------- */

/* Channels of one part, and the colour by whose layer they are chosen. */
struct names {
    const char *part; // before each name
    int part_len;     // its bytes; 0: none
    const struct gp_channel *channel; // names "" of other views
    int n;
    char colour[FULL];
};

/* Three channels of a part. */
struct three {
    int index[3];
    int second; // first channel of another layer of equal rank, or -1
};

static void within_part(const struct names *in, const char *name, char to[FULL])
{
    snprintf(to, FULL, "%.*s%s%s", in->part_len, in->part,
             in->part_len ? "." : "", name);
}

/* Finds the channels that are called last[] in the layer of a channel. */
static bool find_siblings(const struct names *in, int of,
                          const char *const last[3], int index[3])
{
    const size_t layer = gp_layer_length(in->channel[of].name);
    for (int c = 0; c < 3; c++) {
        index[c] = -1;
        for (int i = 0; i < in->n && index[c] < 0; i++) {
            if (gp_layer_length(in->channel[i].name) == layer &&
                strncmp(in->channel[i].name, in->channel[of].name, layer) == 0 &&
                strcmp(in->channel[i].name + layer, last[c]) == 0)
                index[c] = i;
        }
    }
    return index[0] >= 0 && index[1] >= 0 && index[2] >= 0;
}

/* Finds the layer nearest to the colour's, then the best names, then the first
 * that is directly in there. */
static bool find_three(const struct names *in,
                       const struct gp_layer_names *wanted, struct three *out)
{
    enum { SETS = 3, KINDS = SETS * 8 }; // layers of names, sets of channels
    int best = INT_MAX;
    for (int i = 0; i < in->n; i++) {
        char full[FULL], tail[64];
        within_part(in, in->channel[i].name, full);
        const size_t length = strlen(full);
        for (int kind = 0; wanted->layer[kind / SETS]; kind++) {
            const char *const *const last = wanted->channel[kind % SETS];
            const size_t n = (size_t) snprintf(tail, sizeof tail, "%s.%s",
                wanted->layer[kind / SETS], last[0]);
            if (length < n || strcmp(full + length - n, tail) != 0 ||
                (length > n && full[length - n - 1] != '.'))
                continue;
            size_t skip = gp_layer_length(in->colour);
            int steps = 0; // out of the colour's layer, until it is in that
            for (; skip + n > length || strncmp(full, in->colour, skip) != 0;
                 steps++)
                skip = gp_last_part(in->colour, skip - 1);
            const int rank = 2 * (steps * KINDS + kind) + (length > skip + n);
            int index[3];
            if (rank > best || !find_siblings(in, i, last, index))
                continue;
            if (rank == best) {
                out->second = out->second < 0 ? i : out->second;
                continue;
            }
            *out = (struct three) {{index[0], index[1], index[2]}, -1};
            best = rank;
        }
    }
    return best < INT_MAX;
}

/* Names a part's channels, those of the colour's part within its view. */
static void name_part(const struct list *list, const struct part *part,
                      struct names *out)
{
    const struct part *const first = list->part;
    struct names of = {
        .part = first->own->layer,
        .part_len = (int) first->own->length,
    };
    *out = (struct names) {.n = part->channels, .channel = part->channel};
    if (!part->colour) {
        out->part = part->own->layer;
        out->part_len = (int) part->own->length;
    } else {
        of.part_len = 0;
    }
    within_part(&of, first->by ? first->by : "", out->colour);
}

/* Warns of a choice between equals, and of a layer that is not the colour's. */
static void warn_of_choice(const struct gp_log *log, const char *path,
                           const struct names *in, const struct three *three,
                           const char *what)
{
    char used[FULL], other[FULL];
    within_part(in, in->channel[three->index[0]].name, used);
    const size_t own = gp_layer_length(used);
    const size_t around = gp_last_part(used, own - (own > 0));
    if (three->second >= 0) {
        within_part(in, in->channel[three->second].name, other);
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
    struct list list;
    struct gp_plane plane[3] = {{.v = NULL}};
    gp_status st;
    bool found = false;
    GP_TRY(list_frame(log, f, false, &list));
    for (int i = 0; i < list.parts && !found && !st; i++) {
        const struct part *const part = &list.part[i];
        if (part->own->deep || part->other || (i > 0 && part[-1].inner))
            continue;
        struct names names;
        struct three three = {.second = -1};
        name_part(&list, part, &names);
        found = find_three(&names, wanted, &three);
        if (found)
            warn_of_choice(log, f->path, &names, &three, wanted->what);
        for (int c = 0; c < 3 && found && !st; c++) {
            const struct place at = {part + part->inner, three.index[c]};
            st = make_name(log, &list, &at, &plane[c]);
        }
        if (found && !st)
            st = gp_read_channels(log, p, f, part->number, three.index, 3,
                                  plane);
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
    free_list(&list);
    return st;
}
