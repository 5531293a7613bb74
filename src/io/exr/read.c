// SPDX-License-Identifier: Apache-2.0
/* A part of an EXR as a frame, and further layers of the same file. */
#include "io/exr/exr_priv.h"

#include "core/deep.h"
#include "core/memory.h"
#include "io/channels.h"
#include "io/decoded.h"

#include <string.h>

/* State while a frame is read. */
struct reading {
    const struct gp_log *log;
    struct gp_frame *f;
    struct gp_exr_chunks chunks; // borrowed
    const struct gp_exr_choice *choice;
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

/* Adds channel i of the part, with room for its samples where it is no colour. */
static gp_status add_channel(const struct reading *r, int i,
                             enum gp_pixel_type type)
{
    const struct gp_exr_chunks *const cs = &r->chunks;
    const exr_attr_chlist_entry_t *const e = &cs->channel->entries[i];
    const struct gp_channel like = {
        .name = (char *) (uintptr_t) e->name.str,
        .type = type,
        .xs = e->x_sampling,
        .ys = e->y_sampling,
        .w = cs->w / e->x_sampling,
        .h = cs->h / e->y_sampling,
        .linear = e->p_linear,
        .colour = gp_colour_of(&r->choice->colour, i),
    };
    return gp_frame_add(r->log, r->f, &like);
}

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
            return gp_fail(
                r->log, GP_ERR_DATA,
                "%s: colour channel %s is subsampled (%d x %d); write it at "
                "full resolution",
                r->f->path, e->name.str, xs, ys);
        first = chroma ? xs : first;
    }
    return GP_OK;
}

/* Makes the channels of a flat part and its colour, of samples as they are. */
static gp_status read_flat(struct reading *r)
{
    const struct gp_exr_chunks *cs = &r->chunks;
    const int *const index = r->choice->colour.index;
    struct gp_frame *const f = r->f;
    const bool chroma = f->model == GP_COLOUR_YC;
    const int n = cs->channel->num_channels;
    struct gp_exr_sink *sink = NULL;   // one a channel
    float *yc[3] = {NULL, NULL, NULL}; // RY, Y, BY before they are RGB
    gp_status st;
    GP_TRY(check_sampling(r));
    GP_TRY(gp_alloc_zero(r->log, "channels", (size_t) n, sizeof *sink, &sink));
    for (int i = 0; i < n; i++) {
        struct gp_channel *const c = &f->channel[i];
        GP_TRY(add_channel(
            r, i, (enum gp_pixel_type) cs->channel->entries[i].pixel_type));
        sink[i] = (struct gp_exr_sink) {c->data, c->colour >= 0};
        if (chroma && c->colour >= 0)
            GP_TRY(gp_alloc(r->log, "chroma", (size_t) c->w * (size_t) c->h,
                            sizeof(float), &yc[c->colour]));
        if (c->colour >= 0)
            sink[i].to = chroma ? yc[c->colour] : f->rgb.c[c->colour];
    }
    GP_TRY(gp_exr_decode(r->log, cs, sink));
    if (chroma) { // a chroma channel that is missing is 0
        const struct gp_channel *c =
            &f->channel[index[0] >= 0 ? index[0] : index[2]];
        for (int k = 0; k < 3; k += 2) {
            if (!yc[k])
                GP_TRY(gp_alloc_zero(r->log, "chroma",
                                     (size_t) c->w * (size_t) c->h,
                                     sizeof(float), &yc[k]));
        }
        struct gp_yc in = {
            .w = cs->w,
            .h = cs->h,
            .xs = c->xs,
            .ys = c->ys,
            .y = yc[1],
            .ry = yc[0],
            .by = yc[2],
            .half = f->colour_type == GP_HALF,
        };
        gp_yc_weights(f->chromaticities, in.weight);
        GP_TRY(gp_yc_to_rgb(r->log, &in, &f->rgb));
    }
out:
    gp_free(sink);
    for (int k = 0; k < 3; k++)
        gp_free(yc[k]);
    return st;
}

/* -- deep parts ----------------------------------------------------------- */

/* Finds channel `word` of the layer that `like` is of, else of none; -1: no such
 * channel. */
static int beside(const exr_attr_chlist_t *list, const char *like,
                  const char *word)
{
    int plain = -1;
    const size_t layer = gp_layer_length(like);
    for (int i = 0; i < list->num_channels; i++) {
        const char *const name = list->entries[i].name.str;
        if (strncmp(name, like, layer) == 0 && strcmp(name + layer, word) == 0)
            return i;
        if (strcmp(name, word) == 0)
            plain = i;
    }
    return plain;
}

/* Flattens a deep part by its own alpha; of its channels the frame gets those of
 * the colour and A, as floats. */
static gp_status flatten(struct reading *r, const struct gp_exr_deep *deep)
{
    const exr_attr_chlist_t *const list = r->chunks.channel;
    const int *const index = r->choice->colour.index;
    const char *const like = list->entries[index[0]].name.str;
    const int z = beside(list, like, "Z"), alpha = beside(list, like, "A");
    const int back = beside(list, like, "ZBack");
    const int all[] = {z, alpha, index[0], index[1], index[2], back};
    for (int i = 0; i < 6; i++) {
        if (i < 2 && all[i] < 0)
            return gp_fail(r->log, GP_ERR_DATA,
                           "%s: deep data without %s (part "
                           "%d) has no picture; render it, or flatten the file "
                           "with e.g. oiiotool --flatten",
                           r->f->path, i ? "A" : "Z", r->choice->part);
        if (all[i] >= 0 && list->entries[all[i]].pixel_type == EXR_PIXEL_UINT)
            return gp_fail(r->log, GP_ERR_DATA,
                           "%s: deep channel %s is of whole "
                           "numbers (part %d); write floats",
                           r->f->path, list->entries[all[i]].name.str,
                           r->choice->part);
    }
    struct gp_deep d = {
        .window = r->f->data,
        .first = deep->first,
        .z = deep->sample[z],
        .alpha = deep->sample[alpha],
        .back = back < 0 ? NULL : deep->sample[back],
    };
    for (int c = 0; c < 3; c++)
        d.colour[c] = deep->sample[index[c] < 0 ? index[0] : index[c]];
    float *flat = NULL;
    for (int i = 0; i < list->num_channels; i++) {
        const bool colour = i == index[0] || i == index[1] || i == index[2];
        const gp_status st =
            colour || i == alpha
                ? add_channel(
                      r, i,
                      colour ? (enum gp_pixel_type) list->entries[i].pixel_type
                             : GP_FLOAT)
                : GP_OK;
        if (st)
            return st;
        if (i == alpha && !colour)
            flat = r->f->channel[r->f->channels - 1].data;
    }
    return gp_deep_flatten(r->log, &d, &r->f->rgb, flat);
}

/* -- frames --------------------------------------------------------------- */

/* The frame of one part and its colour, without an input. */
static gp_status read_choice(const struct gp_log *log,
                             const struct gp_read_params *p,
                             const struct gp_input *in,
                             const struct gp_exr_choice *choice,
                             struct gp_frame *out)
{
    gp_status st;
    struct gp_frame f = {.model = choice->colour.model, .colour_type = GP_HALF};
    struct gp_exr_deep deep = {.first = NULL};
    struct reading r = {.log = log, .f = &f, .choice = choice};
    const bool is_deep = in->each[choice->part].deep &&
                         f.model != GP_COLOUR_YC &&
                         choice->colour.index[0] >= 0;
    GP_TRY(is_deep
               ? gp_exr_deep_read(log, in, choice->part, p->max_pixels, &deep)
               : gp_exr_chunks_find(log, in, choice->part, false, p->max_pixels,
                                    &deep.part));
    r.chunks = deep.part;
    gp_exr_frame_header(&r.chunks, &f);
    GP_TRY(gp_window_check(
        log, in->path, "display", (int64_t) f.display.x1 - f.display.x0,
        (int64_t) f.display.y1 - f.display.y0, p->max_pixels));
    GP_TRY(gp_frame_make(log, in->path, r.chunks.channel->num_channels, &f));
    GP_TRY(is_deep ? flatten(&r, &deep) : read_flat(&r));
    if (!is_deep && f.model != GP_COLOUR_YC)
        gp_frame_fill(&f, choice->colour.index);
out:
    gp_exr_deep_free(&deep);
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
    GP_TRY(gp_exr_choose(log, p, in, 0, &choice));
    in->part = choice.part;
    GP_TRY(read_choice(log, p, in, &choice, out));
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
    bool all =
        choice->part == f->part && choice->colour.model != GP_COLOUR_YC &&
        gp_input_of(f)->each[f->part].channel->num_channels == f->channels;
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
        .data = f->data,
        .display = f->display,
        .pixel_aspect = f->pixel_aspect,
        .part = f->part,
        .parts = f->parts,
        .model = colour->model,
        .colour_type = GP_HALF,
        .names_chromaticities = f->names_chromaticities,
    };
    memcpy(out->chromaticities, f->chromaticities, sizeof f->chromaticities);
    memcpy(out->luminance, f->luminance, sizeof f->luminance);
    GP_TRY(gp_frame_make(log, f->path, 3, out));
    for (int k = 0; k < 3; k++) {
        const int index = colour->index[k];
        if (index < 0)
            continue;
        struct gp_channel like = f->channel[index];
        like.colour = k;
        GP_TRY(gp_frame_add(log, out, &like));
        gp_channel_floats(f, index, out->rgb.c[k]);
    }
    gp_frame_fill(out, colour->index);
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
    gp_status st;
    if (!in)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: only EXR files have layers beside the frame; "
                       "convert it, with e.g. oiiotool", f->path);
    // in the view that is asked for; else in that of f's part first, since a
    // layer of the other eye is the last that is meant
    q.view = p->view ? p->view : in->each[f->part].view;
    if (p->view || !q.view || gp_exr_choose(NULL, &q, in, f->part, &choice)) {
        q.view = p->view;
        GP_TRY(gp_exr_choose(log, &q, in, f->part, &choice));
    }
    const exr_attr_box2i_t d = in->each[choice.part].data;
    if (d.min.x != f->data.x0 || d.min.y != f->data.y0 ||
        d.max.x != f->data.x1 - 1 || d.max.y != f->data.y1 - 1)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: the data window of %s (part %d) is not that of the "
                       "frame (part %d); render both with one window", f->path,
                       layer ? layer : "the view", choice.part, f->part));
    GP_TRY(holds_choice(f, &choice) ? copy_layer(log, f, &choice.colour, &frame)
                                    : read_choice(log, p, in, &choice, &frame));
    frame.input = in;
    *out = frame;
    return GP_OK;
out:
    gp_frame_free(&frame);
    return st;
}
