// SPDX-License-Identifier: Apache-2.0
/* A part of an EXR as a frame, and further layers of the same file. */
#include "io/exr/exr_priv.h"

#include "core/colour.h"
#include "core/memory.h"
#include "io/channels.h"
#include "io/decoded.h"

#include <string.h>

/* State while a frame is read. */
struct reading {
    const struct gp_log *log;
    const char *path;
    struct gp_frame *f;
    struct gp_exr_chunks chunks;
    const struct gp_exr_choice *choice;
    struct gp_exr_sink *sink; // one a channel
    float *yc[3];             // RY, Y, BY before they are RGB
};

gp_status gp_exr_decode_full(const struct gp_log *log,
    const struct gp_exr_chunks *cs, bool numbers, float *const *to)
{
    const int n = cs->channel->num_channels;
    const size_t pixels = (size_t) cs->w * (size_t) cs->h;
    struct gp_exr_sink *sink = NULL;
    float *few = NULL; // samples of a subsampled channel
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "channels", (size_t) n, sizeof *sink, &sink));
    for (int i = 0; i < n; i++) {
        const exr_attr_chlist_entry_t *const e = &cs->channel->entries[i];
        const bool number = numbers && e->pixel_type == EXR_PIXEL_UINT;
        sink[i] = (struct gp_exr_sink) {
            to[i], !(number && e->x_sampling == 1 && e->y_sampling == 1),
        };
    }
    GP_TRY(gp_exr_decode(log, cs, sink));
    for (int i = 0; i < n; i++) {
        const exr_attr_chlist_entry_t *const e = &cs->channel->entries[i];
        if (!to[i] || (e->x_sampling == 1 && e->y_sampling == 1))
            continue;
        GP_FREE(few);
        GP_TRY(gp_alloc(log, e->name.str, pixels, sizeof *few, &few));
        memcpy(few, to[i], pixels * sizeof *few);
        memset(to[i], 0, pixels * sizeof *few);
        struct gp_channel channel = {
            .type = GP_FLOAT, .xs = e->x_sampling, .ys = e->y_sampling,
            .w = cs->w / e->x_sampling, .h = cs->h / e->y_sampling,
            .colour = -1, .data = few,
        };
        const struct gp_frame one = {
            .data = {0, 0, cs->w, cs->h}, .channel = &channel, .channels = 1,
        };
        gp_channel_floats(&one, 0, to[i]);
    }
out:
    gp_free(few);
    gp_free(sink);
    return st;
}

/* -- channels ------------------------------------------------------------- */

/* Full resolution for all but chroma, which may be halved in both ways. */
static gp_status check_sampling(const struct reading *r)
{
    const struct gp_colour_choice *colour = &r->choice->colour;
    int first = 0; // sampling of a chroma channel
    for (int k = 0; k < 3; k++) {
        if (colour->index[k] < 0)
            continue;
        const exr_attr_chlist_entry_t *e =
            &r->chunks.channel->entries[colour->index[k]];
        const int xs = e->x_sampling, ys = e->y_sampling;
        const bool chroma = colour->model == GP_COLOUR_YC && k != 1;
        if (xs != ys || xs > (chroma ? 2 : 1) ||
            (chroma && first && first != xs))
            return gp_fail(r->log, GP_ERR_DATA,
                "%s: colour channel %s is subsampled (%d x %d); write it at "
                "full resolution", r->path, e->name.str, xs, ys);
        first = chroma ? xs : first;
    }
    return GP_OK;
}

/* Lists the channels, and where their samples go. */
static gp_status make_channels(struct reading *r)
{
    const struct gp_exr_chunks *cs = &r->chunks;
    struct gp_frame *const f = r->f;
    const int n = cs->channel->num_channels;
    gp_status st;
    GP_TRY(gp_alloc_zero(r->log, "channels", (size_t) n, sizeof *f->channel,
                         &f->channel));
    GP_TRY(gp_alloc_zero(r->log, "channels", (size_t) n, sizeof *r->sink,
                         &r->sink));
    GP_TRY(gp_planes_make(r->log, "frame", gp_frame_pixels(f), &f->rgb));
    f->colour_type = GP_HALF;
    for (int i = 0; i < n; i++) {
        const exr_attr_chlist_entry_t *e = &cs->channel->entries[i];
        struct gp_channel *c = &f->channel[f->channels++];
        *c = (struct gp_channel) {
            .type = (enum gp_pixel_type) e->pixel_type, .xs = e->x_sampling,
            .ys = e->y_sampling, .w = cs->w / e->x_sampling,
            .h = cs->h / e->y_sampling, .linear = e->p_linear, .colour = -1,
        };
        const size_t samples = (size_t) c->w * (size_t) c->h;
        for (int k = 0; k < 3; k++) {
            if (r->choice->colour.index[k] == i)
                c->colour = k;
        }
        c->name = gp_strdup(e->name.str);
        if (!c->name)
            GP_TRY(gp_no_memory(r->log, r->path));
        if (c->colour < 0) {
            GP_TRY(gp_alloc(r->log, c->name, samples, gp_type_size(c->type),
                            &c->data));
            r->sink[i].to = c->data;
            continue;
        }
        if (c->type != GP_HALF)
            f->colour_type = GP_FLOAT;
        float **const plane = f->model == GP_COLOUR_YC ? r->yc : f->rgb.c;
        if (f->model == GP_COLOUR_YC)
            GP_TRY(gp_alloc(r->log, "chroma", samples, sizeof(float),
                            &plane[c->colour]));
        r->sink[i] = (struct gp_exr_sink) {plane[c->colour], true};
    }
out:
    return st;
}

/* -- colour --------------------------------------------------------------- */

/* Plane k of a colour that has no channel for it: grey's first, or black. */
static void fill_missing_plane(struct gp_frame *f, int k)
{
    const size_t bytes = gp_frame_pixels(f) * sizeof(float);
    if (f->model == GP_COLOUR_GREY)
        memcpy(f->rgb.c[k], f->rgb.c[0], bytes);
    else
        memset(f->rgb.c[k], 0, bytes);
}

/* The frame of one part and its colour, without an input. */
static gp_status read_choice(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, const struct gp_input *in,
    const struct gp_exr_choice *choice, struct gp_frame *out)
{
    gp_status st;
    const int *const index = choice->colour.index;
    struct gp_frame f = {.model = choice->colour.model};
    struct reading r = {
        .log = log, .path = path, .f = &f, .choice = choice,
    };
    if (gp_exr_is_deep(in, choice->part) &&
        choice->colour.model != GP_COLOUR_YC && index[0] >= 0)
        return gp_exr_read_flat(log, p, path, in, choice, out);
    GP_TRY(gp_exr_chunks_find(log, path, in, choice->part, p->max_pixels,
                              &r.chunks));
    gp_exr_frame_header(&r.chunks, &f);
    GP_TRY(gp_window_check(log, path, "display",
           (int64_t) f.display.x1 - f.display.x0,
           (int64_t) f.display.y1 - f.display.y0, p->max_pixels));
    GP_TRY(check_sampling(&r));
    GP_TRY(make_channels(&r));
    GP_TRY(gp_exr_decode(log, &r.chunks, r.sink));
    if (f.model == GP_COLOUR_YC) { // a chroma channel that is missing is 0
        const struct gp_channel *c = &f.channel[index[0] >= 0 ? index[0]
                                                              : index[2]];
        for (int k = 0; k < 3; k += 2) {
            if (!r.yc[k])
                GP_TRY(gp_alloc_zero(log, "chroma",
                                     (size_t) c->w * (size_t) c->h,
                                     sizeof(float), &r.yc[k]));
        }
        struct gp_yc yc = {
            .w = r.chunks.w, .h = r.chunks.h, .xs = c->xs, .ys = c->ys,
            .y = r.yc[1], .ry = r.yc[0], .by = r.yc[2],
            .half = f.colour_type == GP_HALF,
        };
        gp_yc_weights(f.chromaticities, yc.weight);
        GP_TRY(gp_yc_to_rgb(log, &yc, &f.rgb));
    }
    for (int k = 0; f.model != GP_COLOUR_YC && k < 3; k++) {
        if (index[k] < 0)
            fill_missing_plane(&f, k);
    }
    f.path = gp_strdup(path);
    if (!f.path)
        st = gp_no_memory(log, path);
out:
    gp_exr_chunks_free(&r.chunks);
    gp_free(r.sink);
    for (int k = 0; k < 3; k++)
        gp_free(r.yc[k]);
    if (st)
        gp_frame_free(&f);
    else
        *out = f;
    return st;
}

gp_status gp_read_exr(const struct gp_log *log, const struct gp_read_params *p,
    const char *path, struct gp_stream *stream, struct gp_frame *out)
{
    gp_status st;
    struct gp_input *in = NULL;
    struct gp_exr_choice choice;
    GP_TRY(gp_exr_open(log, path, stream, &in));
    GP_TRY(gp_exr_choose(log, p, path, in, 0, &choice));
    in->part = choice.part;
    GP_TRY(read_choice(log, p, path, in, &choice, out));
    out->input = in;
    out->input_free = gp_input_free;
    return GP_OK;
out:
    gp_input_free(in);
    return st;
}

/* -- other layers of a file that is open ---------------------------------- */

/* True when f holds the samples of every channel of the colour. */
static bool holds_choice(const struct gp_frame *f,
                         const struct gp_exr_choice *choice)
{
    bool all = choice->part == f->part &&
               choice->colour.model != GP_COLOUR_YC &&
               gp_exr_channels(gp_input_of(f), f->part)->num_channels ==
                   f->channels;
    for (int k = 0; all && k < 3; k++) {
        const int i = choice->colour.index[k];
        all = i < 0 || (f->channel[i].data && f->channel[i].xs == 1 &&
                        f->channel[i].ys == 1);
    }
    return all;
}

/* A frame like f, with the colour that f's channels hold. */
static gp_status copy_layer(const struct gp_log *log, const struct gp_frame *f,
    const struct gp_colour_choice *colour, struct gp_frame *out)
{
    gp_status st;
    *out = (struct gp_frame) {
        .path = gp_strdup(f->path), .data = f->data, .display = f->display,
        .pixel_aspect = f->pixel_aspect, .part = f->part, .parts = f->parts,
        .model = colour->model, .colour_type = GP_HALF,
    };
    memcpy(out->chromaticities, f->chromaticities, sizeof f->chromaticities);
    memcpy(out->luminance, f->luminance, sizeof f->luminance);
    if (!out->path)
        GP_TRY(gp_no_memory(log, f->path));
    GP_TRY(gp_planes_make(log, "layer", gp_frame_pixels(f), &out->rgb));
    GP_TRY(gp_alloc_zero(log, "channels", 3, sizeof *out->channel,
                         &out->channel));
    for (int k = 0; k < 3; k++) {
        const int index = colour->index[k];
        if (index < 0) {
            fill_missing_plane(out, k);
            continue;
        }
        struct gp_channel *to = &out->channel[out->channels++];
        *to = f->channel[index];
        to->data = NULL;
        to->colour = k;
        to->name = gp_strdup(f->channel[index].name);
        if (!to->name)
            GP_TRY(gp_no_memory(log, f->path));
        if (to->type != GP_HALF)
            out->colour_type = GP_FLOAT;
        gp_channel_floats(f, index, out->rgb.c[k]);
    }
out:
    return st;
}

gp_status gp_read_layer(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f, const char *layer,
    struct gp_frame *out)
{
    struct gp_input *const in = f->input;
    struct gp_read_params q = {.max_pixels = p->max_pixels, .layer = layer};
    struct gp_exr_choice choice;
    struct gp_frame frame = {0};
    exr_attr_box2i_t d;
    gp_status st;
    if (!in || !in->exr)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: only EXR files have layers beside the frame; "
                       "convert it, with e.g. oiiotool", f->path);
    // in the view that is asked for; else in that of f's part first, since a
    // layer of the other eye is the last that is meant
    q.view = p->view ? p->view : gp_exr_part_view(in, f->part);
    if (p->view || !q.view ||
        gp_exr_choose(NULL, &q, f->path, in, f->part, &choice)) {
        q.view = p->view;
        GP_TRY(gp_exr_choose(log, &q, f->path, in, f->part, &choice));
    }
    if (exr_get_data_window(in->exr, choice.part, &d) ||
        d.min.x != f->data.x0 || d.min.y != f->data.y0 ||
        d.max.x != f->data.x1 - 1 || d.max.y != f->data.y1 - 1)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: the data window of %s (part %d) is not that of the "
                       "frame (part %d); render both with one window", f->path,
                       layer ? layer : "the view", choice.part, f->part));
    GP_TRY(holds_choice(f, &choice)
               ? copy_layer(log, f, &choice.colour, &frame)
               : read_choice(log, p, f->path, in, &choice, &frame));
    frame.input = in;
    *out = frame;
    return GP_OK;
out:
    gp_frame_free(&frame);
    return st;
}
