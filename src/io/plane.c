#include "io/plane.h"

#include "core/memory.h"
#include "io/channels.h"
#include "io/exr/exr.h"
#include "io/io_priv.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* -- the parts of a file -------------------------------------------------- */

static gp_status alloc_list(const struct gp_log *log, int parts, int channels,
                           struct gp_plane_list *list)
{
    const gp_status st = gp_alloc_zero(log, "parts", (size_t) parts,
                                       sizeof *list->part, &list->part);
    return st ? st : gp_alloc_zero(log, "channels", (size_t) channels,
                                   sizeof *list->channel, &list->channel);
}

void gp_plane_list_free(struct gp_plane_list *list)
{
    gp_free(list->part);
    gp_free(list->channel);
    *list = (struct gp_plane_list) {0};
}

gp_status gp_plane_list_one(const struct gp_log *log, const char *path,
    bool colour, int channels, struct gp_plane_list *list)
{
    *list = (struct gp_plane_list) {.path = path};
    gp_status st = alloc_list(log, 1, channels, list);
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
static const exr_attr_chlist_t *channels_of(const struct gp_input *o, int part)
{
    static const exr_attr_chlist_t none;
    const exr_attr_chlist_t *list;
    return exr_get_channels(o->exr, part, &list) ? &none : list;
}

static bool other_view(const char *a, const char *b)
{
    return a && b && strcmp(a, b) != 0;
}

gp_status gp_plane_list_exr(const struct gp_log *log, const char *path,
                            const struct gp_input *o, bool colour, bool depth,
                            struct gp_plane_list *list)
{
    int channels = 0;
    *list = (struct gp_plane_list) {.path = path};
    for (int part = 0; part < o->parts; part++)
        channels += channels_of(o, part)->num_channels;
    gp_status st = alloc_list(log, o->parts, channels, list);
    if (st)
        return st;
    const char *own = "", *layer;
    size_t n = colour ? gp_exr_part_layer(o, o->part, &own) : 0;
    while (n > 0 && own[n - 1] != '.')
        n--;
    for (int order = -1; order < 16; order++) { // the colour's part first
        for (int part = 0; part < o->parts; part++) {
            const exr_attr_chlist_t *const from = channels_of(o, part);
            const size_t bytes = gp_exr_part_layer(o, part, &layer);
            const struct gp_plane_part to = {
                .part = part, .name = gp_exr_part_name(o, part),
                .view = gp_exr_part_view(o, part),
                .colour = colour && part == o->part,
                .deep = gp_exr_is_deep(o, part),
                .mist = gp_is_mist(layer, bytes),
                .channel = list->channel + list->channels,
                .channels = from->num_channels,
            };
            const bool other = colour && other_view(to.view,
                gp_exr_part_view(o, o->part));
            const bool plain = depth && !(to.name &&
                                          strcasestr(to.name, "depth"));
            const bool far = n > 0 && !(to.name &&
                                        strncmp(to.name, own, n) == 0);
            if ((to.colour ? -1 : 8 * to.deep + 4 * other + 2 * plain + far) !=
                order)
                continue;
            for (int i = 0; i < to.channels; i++)
                to.channel[i].name =
                    (char *) (uintptr_t) from->entries[i].name.str;
            list->part[list->parts++] = to;
            list->channels += to.channels;
        }
    }
    return GP_OK;
}

/* -- by name -------------------------------------------------------------- */

/* The first channel of that name in any part; with `in_part` the name is
 * PART.CHANNEL, of which both may hold dots. */
static bool find_exact(const struct gp_plane_list *list, const char *name,
                       bool in_part, struct gp_plane_place *out)
{
    for (int p = 0; p < list->parts; p++) {
        const struct gp_plane_part *part = &list->part[p];
        const size_t n = in_part && part->name ? strlen(part->name) : 0;
        if (in_part && (n == 0 || strncmp(name, part->name, n) != 0 ||
                        name[n] != '.'))
            continue;
        const char *const channel = name + (in_part ? n + 1 : 0);
        for (int i = 0; i < part->channels; i++) {
            if (strcmp(part->channel[i].name, channel) == 0) {
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
    return n < (int) sizeof full && find_exact(list, full, false, out);
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
    const struct gp_plane_list *list, struct gp_channel *channel, int n,
    const char *colour, int *out)
{
    const struct gp_frame names = {
        .path = (char *) (uintptr_t) list->path,
        .channel = channel, .channels = n,
    };
    return gp_find_depth(log, &names, NULL, colour, out);
}

static gp_status search_depth(const struct gp_log *log,
    const struct gp_plane_list *list, struct gp_plane_place *out)
{
    const struct gp_plane_part *const first = list->part;
    gp_status st = GP_OK;
    int i = -1;
    if (list->view) { // by the names that its channels have without the view
        const char **bare;
        struct gp_channel *channel = NULL;
        st = gp_exr_names_in(log, list->input, first->part, list->view, &bare);
        if (!st)
            st = gp_alloc_zero(log, "channels", (size_t) first->channels,
                               sizeof *channel, &channel);
        const char *colour = NULL;
        for (int k = 0; k < first->channels && !st; k++) {
            channel[k].name = (char *) (uintptr_t) bare[k];
            if (list->colour && strcmp(first->channel[k].name,
                                       list->colour) == 0)
                colour = bare[k];
        }
        if (!st)
            st = depth_of_names(log, list, channel, first->channels, colour,
                                &i);
        gp_free(channel);
        gp_free(bare);
        if (i >= 0)
            *out = (struct gp_plane_place) {first, i};
    }
    for (int p = 0; p < list->parts && !st && i < 0; p++) {
        const struct gp_plane_part *const part = &list->part[p];
        if (!part->mist)
            st = depth_of_names(log, list, part->channel, part->channels,
                                list->colour, &i);
        if (st || i < 0)
            continue;
        if (list->view && part == first)
            gp_say(log, GP_LEVEL_WARN,
                   "%s: view %s has no depth: using %s of another view; choose "
                   "with --depth or --depth-file", list->path, list->view,
                   part->channel[i].name);
        *out = (struct gp_plane_place) {part, i};
    }
    return st;
}

/* The channel's name after that of its part. */
static void full_name(const struct gp_plane_list *list,
                      const struct gp_plane_part *part, const char *channel,
                      char to[2 * (GP_CHANNEL_NAME + 1)])
{
    const bool named = list->parts > 1 && part->name;
    snprintf(to, 2 * (GP_CHANNEL_NAME + 1), "%s%s%s", named ? part->name : "",
             named ? "." : "", channel);
}

/* Start of the last part of the first n bytes of a name. */
static size_t last_start(const char *name, size_t n)
{
    while (n > 0 && name[n - 1] != '.')
        n--;
    return n;
}

/* True when the depth is in another layer around it than the colour, where that
 * is in one: A.Depth.Z for B.Combined.R. */
static bool of_other_layer(const struct gp_plane_list *list,
                           const struct gp_plane_place *at)
{
    char depth[2 * (GP_CHANNEL_NAME + 1)], colour[sizeof depth];
    full_name(list, at->part, at->part->channel[at->channel].name, depth);
    full_name(list, list->part, list->colour ? list->colour : "", colour);
    const char *const word = strcasestr(depth, "depth");
    const size_t last = last_start(depth, strlen(depth));
    const size_t n = word   ? last_start(depth, (size_t) (word - depth))
                     : last ? last_start(depth, last - 1) : 0;
    const size_t own = last_start(colour, strlen(colour));
    return n > 0 && own > 0 && last_start(colour, own - 1) > 0 &&
           strncmp(colour, depth, n) != 0;
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

gp_status gp_plane_pick(const struct gp_log *log,
                        const struct gp_plane_list *list, const char *name,
                        bool depth, bool own_file, struct gp_plane_place *out)
{
    gp_status st = GP_OK;
    struct gp_plane_place at = {0};
    char names[GP_CHANNEL_LIST];
    list_names(list, names);
    if (name) {
        if (find_in_view(list, name, out) ||
            find_exact(list, name, false, out) ||
            find_exact(list, name, true, out))
            return GP_OK;
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: has no channel %s (it has %s); give one of those",
                       list->path, name, names);
    }
    if (depth)
        GP_TRY(search_depth(log, list, &at));
    else if (!find_in_view(list, "A", &at))
        find_exact(list, "A", false, &at);
    if (!at.part && own_file)
        search_lone(list, depth, &at);
    if (!at.part && own_file)
        return gp_fail(log, GP_ERR_USAGE,
                       depth ? "%s: no channel is clearly depth (it has %s); "
                               "name one with --depth"
                             : "%s: has neither alpha nor a single channel "
                               "(it has %s); name one with --mask",
                       list->path, names);
    // warns of what the user of a frame may not expect
    const char *const view = list->part[0].view;
    if (at.part && !own_file && at.part->deep) {
        gp_say(log, GP_LEVEL_WARN,
               "%s: only part %d has depth, and deep parts are not read; "
               "flatten it, with e.g. oiiotool --flatten", list->path,
               at.part->part);
        at = (struct gp_plane_place) {0};
    } else if (at.part && !own_file && other_view(at.part->view, view)) {
        gp_say(log, GP_LEVEL_WARN,
               "%s: view %s has no depth: using that of view %s; choose with "
               "--depth or --depth-file", list->path, view, at.part->view);
    } else if (at.part && !own_file && depth && of_other_layer(list, &at)) {
        full_name(list, at.part, at.part->channel[at.channel].name, names);
        gp_say(log, GP_LEVEL_WARN,
               "%s: the layer has no depth: using %s of another layer; choose "
               "with --depth or --depth-file", list->path, names);
    }
    *out = at;
out:
    return st;
}

/* -- shared by the ways of reading ---------------------------------------- */

/* Makes the channel's name in the form of the report and --depth. */
static gp_status make_name(const struct gp_log *log,
    const struct gp_plane_list *list, const struct gp_plane_place *at,
    struct gp_plane *out)
{
    const struct gp_plane_part *part = at->part;
    const char *channel = part->channel[at->channel].name;
    const bool plain = part->colour || list->parts == 1 || !part->name;
    const size_t room = strlen(channel) + 2 + (plain ? 0 : strlen(part->name));
    const gp_status st = gp_alloc(log, "channel name", room, 1, &out->name);
    if (!st)
        snprintf(out->name, room, "%s%s%s", plain ? "" : part->name,
                 plain ? "" : ".", channel);
    return st;
}

static gp_status make_samples(const struct gp_log *log, struct gp_rect window,
                              struct gp_plane *out)
{
    out->window = window;
    return gp_alloc(log, "depth or coverage",
        (size_t) gp_rect_w(window) * (size_t) gp_rect_h(window), sizeof *out->v,
        &out->v);
}

/* -- from an EXR ---------------------------------------------------------- */

/* One channel of one part, from the file. */
static gp_status from_part(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, const struct gp_input *o,
    const struct gp_plane_place *at, struct gp_plane *out)
{
    gp_status st;
    float **to = NULL;
    struct gp_exr_chunks l;
    GP_TRY(gp_exr_chunks_find(log, path, o, at->part->part, p->max_pixels, &l));
    GP_TRY(make_samples(log, (struct gp_rect) {l.x0, l.y0, l.x0 + l.w,
                                               l.y0 + l.h}, out));
    GP_TRY(gp_alloc_zero(log, "channels", (size_t) l.channel->num_channels,
                         sizeof *to, &to));
    to[at->channel] = out->v;
    GP_TRY(gp_exr_decode_full(log, &l, false, to));
out:
    gp_free(to);
    gp_exr_chunks_free(&l);
    return st;
}

/* -- beside a frame ------------------------------------------------------- */

gp_status gp_plane_list_frame(const struct gp_log *log,
    const struct gp_frame *f, bool depth, struct gp_plane_list *list)
{
    gp_status st;
    const struct gp_input *const in = gp_input_of(f);
    if (in) {
        GP_TRY(gp_plane_list_exr(log, f->path, in, true, depth, list));
        list->input = in;
    } else {
        GP_TRY(gp_plane_list_one(log, f->path, true, f->channels, list));
        for (int i = 0; i < f->channels; i++)
            list->channel[i].name = f->channel[i].name;
    }
    for (int i = 0; i < f->channels && !list->colour; i++)
        list->colour = f->channel[i].colour >= 0 ? f->channel[i].name : NULL;
    if (in && list->colour)
        list->view = gp_exr_view_of(in, in->part, list->colour);
out:
    return st;
}

/* Finds the wanted channel among all parts of the frame's file, and
 * its name; nothing when `at` has no part. Free the list in any case. */
static gp_status pick_beside(const struct gp_log *log, const struct gp_frame *f,
    const char *name, bool depth, struct gp_plane_list *list,
    struct gp_plane_place *at, struct gp_plane *named)
{
    gp_status st;
    GP_TRY(gp_plane_list_frame(log, f, depth, list));
    GP_TRY(gp_plane_pick(log, list, name, depth, false, at));
    if (at->part)
        GP_TRY(make_name(log, list, at, named));
out:
    return st;
}

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

/* Reads the samples of a channel of a frame's file. */
static gp_status read_samples(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f,
    const struct gp_plane_place *at, struct gp_plane *out)
{
    // colour is read again from an EXR: its planes may be converted (luminance
    // and chroma) or cleaned of NaN
    const struct gp_input *const in = gp_input_of(f);
    if (!at->part->colour || (!f->channel[at->channel].data && in))
        return from_part(log, p, f->path, in, at, out);
    const gp_status st = make_samples(log, f->data, out);
    if (!st) {
        gp_channel_floats(f, at->channel, out->v);
        cut_plane(gp_frame_read(f), out);
    }
    return st;
}

gp_status gp_plane_read_at(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f,
    const struct gp_plane_list *list, const struct gp_plane_place *at,
    struct gp_plane *out)
{
    const gp_status st = make_name(log, list, at, out);
    return st ? st : read_samples(log, p, f, at, out);
}

gp_status gp_read_plane(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f, const char *name,
    bool depth, struct gp_plane *out)
{
    struct gp_plane_list list;
    struct gp_plane_place at;
    struct gp_plane plane = {0};
    gp_status st = pick_beside(log, f, name, depth, &list, &at, &plane);
    if (!st && at.part)
        st = read_samples(log, p, f, &at, &plane);
    if (st)
        gp_plane_free(&plane);
    else
        *out = plane;
    gp_plane_list_free(&list);
    return st;
}

gp_status gp_name_depth(const struct gp_log *log, const struct gp_frame *f,
    const char *name, char **channel, enum gp_pixel_type *type)
{
    struct gp_plane_list list;
    struct gp_plane_place at;
    struct gp_plane named = {0};
    gp_status st = pick_beside(log, f, name, true, &list, &at, &named);
    const exr_attr_chlist_t *channels;
    if (!st && at.part && (at.part->colour ||
                           exr_get_channels(gp_input_of(f)->exr,
                                            at.part->part, &channels)))
        *type = f->channel[at.channel].type;
    else if (!st && at.part)
        *type = (enum gp_pixel_type) channels->entries[at.channel].pixel_type;
    *channel = named.name;
    gp_plane_list_free(&list);
    return st;
}

/* -- from a file of its own ----------------------------------------------- */

gp_status gp_read_plane_file(const struct gp_log *log,
                             const struct gp_read_params *p, const char *path,
                             const char *name, bool depth, struct gp_plane *out)
{
    gp_status st;
    struct gp_stream stream;
    struct gp_input *in = NULL;
    struct gp_decoded image = {0};
    struct gp_plane_list list = {0};
    struct gp_plane_place at;
    struct gp_plane plane = {0};
    bool exr;
    GP_TRY(gp_read_open(log, p, path, &stream, &exr));
    if (exr) {
        GP_TRY(gp_exr_open(log, path, &stream, &in));
        GP_TRY(gp_plane_list_exr(log, path, in, false, depth, &list));
    } else {
        GP_TRY(gp_read_image(log, p, path, &stream, 0, &image));
        GP_TRY(gp_plane_list_one(log, path, false, image.channels, &list));
        for (int i = 0; i < image.channels; i++)
            list.channel[i].name = (char *) (uintptr_t) image.channel_name[i];
    }
    GP_TRY(gp_plane_pick(log, &list, name, depth, true, &at));
    GP_TRY(make_name(log, &list, &at, &plane));
    if (exr) {
        GP_TRY(from_part(log, p, path, in, &at, &plane));
    } else {
        GP_TRY(make_samples(log, image.data, &plane));
        GP_TRY(gp_decoded_channel(log, &image, at.channel, plane.v));
    }
    *out = plane;
    plane = (struct gp_plane) {0};
out:
    gp_plane_free(&plane);
    gp_plane_list_free(&list);
    gp_decoded_close(&image);
    gp_input_free(in);
    gp_stream_close(&stream);
    return st;
}

/* -- the alpha of a picture ------------------------------------------------ */

/* Reads an open picture. */
static gp_status read_alpha(const struct gp_log *log, struct gp_decoded *image,
                            long long most, struct gp_coverage *out)
{
    struct gp_coverage a = {1, 1, NULL};
    float *v = NULL;
    gp_status st;
    int channel = image->channels - 1;
    while (channel >= 0 && strcmp(image->channel_name[channel], "A") != 0)
        channel--;
    if (channel >= 0) {
        a.w = gp_rect_w(image->data);
        a.h = gp_rect_h(image->data);
    }
    const long long texels = (long long) a.w * a.h;
    if (texels > most)
        return gp_fail(log, GP_ERR_DATA, "%s: too large for a cut-out (%d x %d "
                       "texels, at most %lld); make the texture smaller",
                       image->path, a.w, a.h, most);
    GP_TRY(gp_alloc(log, image->path, (size_t) texels, sizeof *a.code,
                    &a.code));
    a.code[0] = GP_COVERED;
    if (channel >= 0) {
        GP_TRY(gp_alloc(log, image->path, (size_t) texels, sizeof *v, &v));
        GP_TRY(gp_decoded_channel(log, image, channel, v));
        for (long long i = 0; i < texels; i++) { // NaN is 0
            const float covered = v[i] > 0.0f ? v[i] < 1.0f ? v[i] : 1.0f : 0.0f;
            a.code[i] = (uint16_t) (covered * (float) GP_COVERED + 0.5f);
        }
    }
    *out = a;
    a.code = NULL;
out:
    gp_free(v);
    gp_free(a.code);
    return st;
}

gp_status gp_read_coverage(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, const void *bytes,
    size_t n, long long most, struct gp_coverage *out)
{
    struct gp_read_params limits = gp_read_limits(p);
    struct gp_stream stream = gp_stream_of(bytes, n);
    struct gp_decoded image = {0};
    gp_status st;
    if (!bytes)
        GP_TRY(gp_stream_open_regular(log, path, &stream));
    // a larger picture than `most` has a line of its own, which does not
    // advise --max-pixels
    if (limits.max_pixels >= most)
        limits.max_pixels = LLONG_MAX / 64;
    GP_TRY(gp_read_image(log, &limits, path, &stream, 0, &image));
    st = read_alpha(log, &image, most, out);
out:
    gp_decoded_close(&image);
    gp_stream_close(&stream);
    return st;
}

/* -- attributes ----------------------------------------------------------- */

static bool part_matrix(const struct gp_input *o, int part, const char *name,
                        double m[16])
{
    exr_attr_m44f_t single;
    exr_attr_m44d_t twice;
    if (!exr_attr_get_m44d(o->exr, part, name, &twice)) {
        memcpy(m, twice.m, sizeof twice.m);
        return true;
    }
    if (exr_attr_get_m44f(o->exr, part, name, &single))
        return false;
    for (int i = 0; i < 16; i++)
        m[i] = (double) single.m[i];
    return true;
}

bool gp_frame_matrix(const struct gp_frame *f, const char *name, double m[16])
{
    const struct gp_input *o = gp_input_of(f);
    if (!o)
        return false;
    if (part_matrix(o, o->part, name, m))
        return true;
    for (int part = 0; part < o->parts; part++) {
        if (part != o->part && part_matrix(o, part, name, m))
            return true;
    }
    return false;
}

char *gp_frame_text(const struct gp_frame *f, const char *name)
{
    const struct gp_input *const o = gp_input_of(f);
    const char *text;
    int32_t length;
    return o && !exr_attr_get_string(o->exr, o->part, name, &length, &text)
               ? gp_strdup(text) : NULL;
}

double gp_frame_rate(const struct gp_frame *f)
{
    const struct gp_input *const o = gp_input_of(f);
    exr_attr_rational_t rate;
    if (!o || exr_attr_get_rational(o->exr, o->part, "framesPerSecond", &rate))
        return 0.0;
    return rate.num > 0 && rate.denom > 0 ? (double) rate.num / rate.denom
                                          : 0.0;
}

bool gp_frame_real(const struct gp_frame *f, const char *name, double *v)
{
    const struct gp_input *const o = gp_input_of(f);
    float found;
    if (!o || exr_attr_get_float(o->exr, o->part, name, &found) ||
        !isfinite(found))
        return false;
    *v = (double) found;
    return true;
}

bool gp_frame_pair(const struct gp_frame *f, const char *name, double v[2])
{
    const struct gp_input *const o = gp_input_of(f);
    exr_attr_v2f_t found;
    if (!o || exr_attr_get_v2f(o->exr, o->part, name, &found) ||
        !isfinite(found.x) || !isfinite(found.y))
        return false;
    v[0] = (double) found.x;
    v[1] = (double) found.y;
    return true;
}
