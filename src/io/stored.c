// SPDX-License-Identifier: Apache-2.0
#include "io/read.h"

#include "core/memory.h"
#include "io/channels.h"
#include "io/exr/exr.h"
#include "io/io_priv.h"

#include <stdlib.h>
#include <string.h>

static gp_status make_list(const struct gp_log *log, const char *const *name,
                           int n, struct gp_stored_image *out)
{
    gp_status st = gp_alloc_zero(log, "channels", (size_t) n,
                                 sizeof *out->channel, &out->channel);
    out->channels = st ? 0 : n;
    for (int i = 0; i < n && !st; i++) {
        out->channel[i].name = gp_strdup(name[i]);
        if (!out->channel[i].name)
            st = gp_no_memory(log, name[i]);
    }
    return st;
}

/* Finds the colour by the channels' names. */
static void find_light(const char *const *name, bool lone,
                       struct gp_stored_image *out)
{
    struct gp_colour_choice colour;
    const bool found = gp_find_colour(name, out->channels, lone, &colour);
    for (int k = 0; k < 3 && found; k++) {
        const int i = colour.model == GP_COLOUR_GREY ? colour.index[0]
                      : colour.model == GP_COLOUR_YC ? colour.index[1]
                                                     : colour.index[k];
        if (i >= 0 && !out->channel[i].is_uint)
            out->light[k] = out->channel[i].v;
    }
    if (!out->light[0] || !out->light[1] || !out->light[2])
        memset(out->light, 0, sizeof out->light);
}

/* The windows and the colour of a frame's header. */
static void copy_header(const struct gp_frame *f, struct gp_stored_image *out)
{
    out->data = f->data;
    out->display = f->display;
    memcpy(out->chromaticities, f->chromaticities, sizeof out->chromaticities);
    memcpy(out->luminance, f->luminance, sizeof out->luminance);
}

/* -- EXR ------------------------------------------------------------------- */

/* Reads a part; a deep one has no light. */
static gp_status read_exr(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_stored_file *file, int part,
    struct gp_stored_image *out)
{
    gp_status st;
    const struct gp_input *const in = file->input;
    const bool is_deep = in->each[part].deep;
    const exr_attr_chlist_t *const list = in->each[part].channel;
    const int n = list->num_channels;
    struct gp_exr_deep deep = {.first = NULL};
    struct gp_frame f;
    const char **name = NULL;
    float **to = NULL;
    GP_TRY(gp_exr_names_in(log, in, part, NULL, &name));
    GP_TRY(is_deep ? gp_exr_deep_read(log, in, part, p->max_pixels, &deep)
                   : gp_exr_chunks_find(log, in, part, false, p->max_pixels,
                                        &deep.part));
    gp_exr_frame_header(&deep.part, &f);
    copy_header(&f, out);
    GP_TRY(make_list(log, name, n, out));
    GP_TRY(gp_alloc(log, "channels", (size_t) n, sizeof *to, &to));
    for (int i = 0; i < n; i++) {
        const exr_attr_chlist_entry_t *const e = &list->entries[i];
        struct glarepp_channel *const c = &out->channel[i];
        c->is_uint = e->pixel_type == EXR_PIXEL_UINT && e->x_sampling == 1 &&
                     e->y_sampling == 1;
        if (is_deep) {
            c->v = deep.sample[i];
            deep.sample[i] = NULL;
            continue;
        }
        GP_TRY(gp_alloc(log, c->name, gp_rect_pixels(out->data), sizeof **to,
                        &to[i]));
        c->v = to[i];
    }
    out->first = deep.first;
    deep.first = NULL;
    if (!is_deep) {
        GP_TRY(gp_exr_decode_full(log, &deep.part, true, to));
        find_light(name, file->parts == 1, out);
    }
out:
    gp_free(to);
    gp_free(name);
    gp_exr_deep_free(&deep);
    return st;
}

/* -- other formats --------------------------------------------------------- */

static gp_status read_other(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_stored_file *f, int part,
    struct gp_stored_image *out)
{
    gp_status st;
    struct gp_decoded own = {0};
    struct gp_frame frame = {0};
    const struct gp_decoded *const image = part > 0 ? &own : &f->first;
    if (part > 0)
        GP_TRY(gp_read_image(log, p, f->path, &f->stream, part, &own));
    GP_TRY(gp_decoded_frame(log, NULL, image, &frame));
    copy_header(&frame, out);
    out->integers = image->bits > 0;
    out->own = frame.rgb;
    frame.rgb = (struct gp_planes) {0};
    for (int c = 0; c < 3; c++)
        out->light[c] = out->own.c[c];
    GP_TRY(make_list(log, image->channel_name, image->channels, out));
    for (int c = 0; c < image->channels; c++) {
        float *v;
        GP_TRY(gp_alloc(log, image->channel_name[c], gp_frame_pixels(&frame),
                        sizeof *v, &v));
        out->channel[c].v = v;
        gp_decoded_channel(image, c, v);
    }
out:
    gp_frame_free(&frame);
    gp_decoded_close(&own);
    return st;
}

/* -- both ------------------------------------------------------------------ */

gp_status gp_stored_open(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_stored_file *f)
{
    bool exr;
    *f = (struct gp_stored_file) {
        .path = path, .stream = GP_STREAM_EMPTY, .parts = 1,
    };
    gp_status st = gp_read_open(log, p, path, &f->stream, &exr);
    if (!st && exr) {
        st = gp_exr_open(log, path, &f->stream, &f->input);
        f->parts = st ? 0 : f->input->parts;
    } else if (!st) {
        st = gp_read_image(log, p, path, &f->stream, 0, &f->first);
        f->parts = f->first.parts > 1 ? f->first.parts : 1;
    }
    return st;
}

void gp_stored_close(struct gp_stored_file *f)
{
    gp_input_free(f->input);
    gp_decoded_close(&f->first);
    gp_stream_close(&f->stream);
    f->input = NULL;
}

gp_status gp_stored_read(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_stored_file *f, int part,
    struct gp_stored_image *out)
{
    struct gp_stored_image image = {0};
    gp_status st = f->input ? read_exr(log, p, f, part, &image)
                             : read_other(log, p, f, part, &image);
    if (st)
        gp_stored_image_free(&image);
    else
        *out = image;
    return st;
}

void gp_stored_image_free(struct gp_stored_image *image)
{
    for (int i = 0; i < image->channels; i++) {
        free((void *) image->channel[i].name);
        gp_free((void *) image->channel[i].v);
    }
    gp_free(image->channel);
    gp_free(image->first);
    gp_planes_free(&image->own);
    *image = (struct gp_stored_image) {0};
}

// -- deep pixels beside a frame -------------------------------------------------

/* Returns the first deep part from `part` on with a channel A, in the view of part
 * `like` where that is not -1; -1: none. */
static int deep_part(const struct gp_input *in, int like, int part)
{
    for (; part < in->parts; part++) {
        const exr_attr_chlist_t *const list = in->each[part].channel;
        if (!in->each[part].deep ||
            (like >= 0 && gp_exr_other_view(in, part, like)))
            continue;
        for (int i = 0; i < list->num_channels; i++) {
            if (strcmp(list->entries[i].name.str, "A") == 0)
                return part;
        }
    }
    return -1;
}

gp_status gp_read_deep(const struct gp_log *log, const struct gp_read_params *p,
                       const struct gp_frame *f, const char *path,
                       struct gp_stored_image *out, bool *found)
{
    struct gp_stored_file file = {.path = f->path, .input = f->input};
    gp_status st = path ? gp_stored_open(log, p, path, &file) : GP_OK;
    const int like = path ? -1 : f->part;
    const int part = st || !file.input ? -1 : deep_part(file.input, like, 0);
    const int other = part < 0 ? -1 : deep_part(file.input, like, part + 1);
    *found = part >= 0;
    if (other >= 0)
        gp_say(log, GP_LEVEL_WARN,
               "%s: of its deep parts only part %d hides lights, part %d does "
               "not; merge them",
               file.path, part, other);
    if (*found)
        st = gp_stored_read(log, p, &file, part, out);
    else if (path && !st)
        st = gp_fail(log, GP_ERR_DATA,
                     "%s: no deep part with a channel A; give "
                     "a deep EXR, or its coverage with --mask",
                     path);
    if (path)
        gp_stored_close(&file);
    return st;
}
