#include "io/plane.h"

#include "core/memory.h"
#include "io/channels.h"
#include "io/exr/exr.h"
#include "io/plane_find.h"
#include "io/read_open.h"

#include <stdio.h>
#include <string.h>

/* -- what each way of reading shares -------------------------------------- */

/* The channel as the report and --depth call it. */
static gp_status make_name(const struct gp_log *log,
                           const struct gp_plane_list *list,
                           const struct gp_plane_place *at,
                           struct gp_plane *out)
{
    const struct gp_plane_part *part = at->part;
    const char *channel = part->channel[at->channel].name;
    const bool plain = part->colour || list->parts == 1 || !part->name;
    const size_t room = strlen(channel) + 2 + (plain ? 0 : strlen(part->name));
    void *to;
    gp_status st = gp_alloc(log, "channel name", room, 1, &to);
    out->name = to;
    if (!st)
        snprintf(to, room, "%s%s%s", plain ? "" : part->name,
                 plain ? "" : ".", channel);
    return st;
}

static gp_status make_samples(const struct gp_log *log, struct gp_rect window,
                              struct gp_plane *out)
{
    void *to;
    gp_status st = gp_alloc(log, "depth or coverage",
                            (size_t) gp_rect_w(window) *
                                (size_t) gp_rect_h(window),
                            sizeof *out->v, &to);
    out->window = window;
    out->v = to;
    return st;
}

/* -- from an EXR ---------------------------------------------------------- */

/* A subsampled channel at full resolution. */
static gp_status widen(const struct gp_log *log, struct gp_rect window,
                       struct gp_channel *c, struct gp_plane *out)
{
    const struct gp_frame one = {
        .data = window, .channel = c, .channels = 1,
    };
    gp_status st = make_samples(log, window, out);
    if (!st)
        gp_channel_floats(&one, 0, out->v);
    return st;
}

static gp_status decode(const struct gp_log *log,
                        const struct gp_exr_chunks *l, int channel,
                        float *samples)
{
    void *list;
    gp_status st = gp_alloc_zero(log, "channels",
                                 (size_t) l->channel->num_channels,
                                 sizeof(struct gp_exr_sink), &list);
    if (st)
        return st;
    struct gp_exr_sink *sink = list;
    sink[channel] = (struct gp_exr_sink) {samples, true};
    st = gp_exr_decode(log, l, sink);
    gp_free(list);
    return st;
}

/* One channel of one part, from the file. */
static gp_status from_part(const struct gp_log *log,
                           const struct gp_read_params *p, const char *path,
                           const struct gp_input *o,
                           const struct gp_plane_place *at,
                           struct gp_plane *out)
{
    gp_status st;
    void *samples = NULL;
    struct gp_exr_chunks l;
    GP_TRY(gp_exr_chunks_find(log, path, o, at->part->part, p->max_pixels,
                              &l));
    const exr_attr_chlist_entry_t *e = &l.channel->entries[at->channel];
    const struct gp_rect window = {l.x0, l.y0, l.x0 + l.w, l.y0 + l.h};
    struct gp_channel c = {
        .type = GP_FLOAT, .xs = e->x_sampling, .ys = e->y_sampling,
        .w = l.w / e->x_sampling, .h = l.h / e->y_sampling, .colour = -1,
    };
    GP_TRY(gp_alloc(log, "depth or coverage", (size_t) c.w * (size_t) c.h,
                    sizeof(float), &samples));
    GP_TRY(decode(log, &l, at->channel, samples));
    c.data = samples;
    if (c.xs == 1 && c.ys == 1) {
        out->window = window;
        out->v = samples;
        samples = NULL;
    } else {
        st = widen(log, window, &c, out);
    }
out:
    gp_free(samples);
    gp_exr_chunks_free(&l);
    return st;
}

/* -- beside a frame ------------------------------------------------------- */

/* The view of the frame's colour in a part of several. */
static const char *view_of(const struct gp_frame *f, const struct gp_input *o)
{
    for (int i = 0; i < f->channels; i++) {
        if (f->channel[i].colour >= 0)
            return gp_exr_view_of(o, o->part, f->channel[i].name);
    }
    return NULL;
}

static gp_status list_frame(const struct gp_log *log, const struct gp_frame *f,
                            bool depth, struct gp_plane_list *list)
{
    const struct gp_input *o = gp_input_of(f);
    if (o && o->exr) {
        gp_status st = gp_plane_list_exr(log, f->path, o, true, depth, list);
        list->input = o;
        list->view = view_of(f, o);
        return st;
    }
    gp_status st = gp_plane_list_one(log, f->path, true, f->channels, list);
    for (int i = 0; !st && i < f->channels; i++)
        list->channel[i].name = f->channel[i].name;
    return st;
}

/* Colour is read again from an EXR: its planes may be converted (luminance
 * and chroma) or cleaned of NaN. */
static gp_status from_frame(const struct gp_log *log,
                            const struct gp_read_params *p,
                            const struct gp_frame *f,
                            const struct gp_plane_place *at,
                            struct gp_plane *out)
{
    const struct gp_input *o = gp_input_of(f);
    const bool here = at->part->colour &&
                      (f->channel[at->channel].data || !o || !o->exr);
    if (!here)
        return from_part(log, p, f->path, o, at, out);
    gp_status st = make_samples(log, f->data, out);
    if (!st)
        gp_channel_floats(f, at->channel, out->v);
    return st;
}

/* The channel of the list that is asked for, and its name; nothing when `at`
 * has no part. Free the list in any case. */
static gp_status pick_beside(const struct gp_log *log, const struct gp_frame *f,
                             const char *name, bool depth,
                             struct gp_plane_list *list,
                             struct gp_plane_place *at, struct gp_plane *named)
{
    gp_status st = list_frame(log, f, depth, list);
    if (!st)
        st = gp_plane_pick(log, list, name, depth, false, at);
    if (!st && at->part)
        st = make_name(log, list, at, named);
    return st;
}

static gp_status read_beside(const struct gp_log *log,
                             const struct gp_read_params *p,
                             const struct gp_frame *f, const char *name,
                             bool depth, struct gp_plane *out)
{
    struct gp_plane_list list;
    struct gp_plane_place at;
    struct gp_plane made = {0};
    gp_status st = pick_beside(log, f, name, depth, &list, &at, &made);
    if (!st && at.part)
        st = from_frame(log, p, f, &at, &made);
    if (st)
        gp_plane_free(&made);
    else
        *out = made;
    gp_plane_list_free(&list);
    return st;
}

gp_status gp_read_depth(const struct gp_log *log,
                        const struct gp_read_params *p,
                        const struct gp_frame *f, const char *name,
                        struct gp_plane *out)
{
    return read_beside(log, p, f, name, true, out);
}

static enum gp_pixel_type type_of(const struct gp_frame *f,
                                  const struct gp_plane_place *at)
{
    const exr_attr_chlist_t *list;
    if (at->part->colour || // as it is in files that are not EXR
        exr_get_channels(gp_input_of(f)->exr, at->part->part, &list))
        return f->channel[at->channel].type;
    return gp_exr_pixel_type(list->entries[at->channel].pixel_type);
}

gp_status gp_name_depth(const struct gp_log *log, const struct gp_frame *f,
                        const char *name, char **channel,
                        enum gp_pixel_type *type)
{
    struct gp_plane_list list;
    struct gp_plane_place at;
    struct gp_plane named = {0};
    gp_status st = pick_beside(log, f, name, true, &list, &at, &named);
    if (!st && at.part)
        *type = type_of(f, &at);
    *channel = named.name;
    gp_plane_list_free(&list);
    return st;
}

gp_status gp_read_coverage(const struct gp_log *log,
                           const struct gp_read_params *p,
                           const struct gp_frame *f, const char *name,
                           struct gp_plane *out)
{
    return read_beside(log, p, f, name, false, out);
}

/* -- from a file of its own ----------------------------------------------- */

/* What is asked of a file. */
struct wanted {
    const struct gp_log *log;
    const struct gp_read_params *p;
    const char *path, *name;
    bool depth;
};

/* Takes the stream over. */
static gp_status from_exr(const struct wanted *w, struct gp_stream *stream,
                          struct gp_plane *out)
{
    gp_status st;
    struct gp_input *o = NULL;
    struct gp_plane_list list = {0};
    struct gp_plane_place at;
    GP_TRY(gp_exr_open(w->log, w->path, stream, &o));
    GP_TRY(gp_plane_list_exr(w->log, w->path, o, false, w->depth, &list));
    GP_TRY(gp_plane_pick(w->log, &list, w->name, w->depth, true, &at));
    GP_TRY(make_name(w->log, &list, &at, out));
    GP_TRY(from_part(w->log, w->p, w->path, o, &at, out));
out:
    gp_plane_list_free(&list);
    gp_input_free(o);
    return st;
}

/* One channel of a picture, a block of rows at a time. */
static gp_status read_channel(const struct gp_log *log, struct gp_image *image,
                              int channel, float *to)
{
    const int w = gp_rect_w(image->data), h = gp_rect_h(image->data);
    const size_t step = (size_t) image->channels;
    void *block;
    gp_status st = gp_alloc(log, "rows", (size_t) image->block * (size_t) w,
                            step * sizeof *to, &block);
    for (int y = 0; !st && y < h; y += image->block) {
        const int rows = h - y < image->block ? h - y : image->block;
        const float *const from = (const float *) block + channel;
        st = image->rows(log, image, y, block);
        for (size_t i = 0; !st && i < (size_t) rows * (size_t) w; i++)
            *to++ = from[i * step];
    }
    gp_free(block);
    return st;
}

static gp_status from_other(const struct wanted *w,
                            const struct gp_stream *stream,
                            struct gp_plane *out)
{
    gp_status st;
    struct gp_image image = {0};
    struct gp_plane_list list = {0};
    struct gp_plane_place at;
    GP_TRY(gp_read_image(w->log, w->p, w->path, stream, 0, &image));
    GP_TRY(gp_plane_list_one(w->log, w->path, false, image.channels, &list));
    for (int i = 0; i < image.channels; i++)
        list.channel[i].name = (char *) (uintptr_t) image.channel_name[i];
    GP_TRY(gp_plane_pick(w->log, &list, w->name, w->depth, true, &at));
    GP_TRY(make_name(w->log, &list, &at, out));
    GP_TRY(make_samples(w->log, image.data, out));
    GP_TRY(read_channel(w->log, &image, at.channel, out->v));
out:
    gp_plane_list_free(&list);
    gp_image_close(&image);
    return st;
}

gp_status gp_read_plane_file(const struct gp_log *log,
                             const struct gp_read_params *p, const char *path,
                             const char *name, bool depth,
                             struct gp_plane *out)
{
    const struct wanted w = {log, p, path, name, depth};
    struct gp_stream stream;
    struct gp_plane made = {0};
    bool exr;
    gp_status st = gp_read_open(log, p, path, &stream, &exr);
    if (st)
        return st;
    if (exr) {
        st = from_exr(&w, &stream, &made);
    } else {
        st = from_other(&w, &stream, &made);
        gp_stream_close(&stream);
    }
    if (st)
        gp_plane_free(&made);
    else
        *out = made;
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
    if (!o || !o->exr)
        return false;
    if (part_matrix(o, o->part, name, m))
        return true;
    for (int part = 0; part < o->parts; part++) {
        if (part != o->part && part_matrix(o, part, name, m))
            return true;
    }
    return false;
}
