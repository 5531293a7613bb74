#include "io/exr/exr_priv.h"

#include "core/colour.h"
#include "core/memory.h"
#include "io/channels.h"
#include "io/image.h"

#include <string.h>

/* What is known while a frame is read. */
struct reading {
    const struct gp_log *log;
    const char *path;
    struct gp_frame *f;
    struct gp_exr_chunks layout;
    struct gp_colour_choice colour;
    struct gp_exr_sink *sink; // one a channel
    float *yc[3];             // RY, Y, BY before they are RGB
};

/* -- the frame around the pixels ------------------------------------------ */

static struct gp_rect rect_of(exr_attr_box2i_t b)
{
    return (struct gp_rect) {b.min.x, b.min.y, b.max.x + 1, b.max.y + 1};
}

void gp_exr_frame_header(const struct gp_exr_chunks *l, struct gp_frame *f)
{
    const exr_context_t exr = l->input->exr;
    exr_attr_box2i_t box;
    exr_attr_chromaticities_t c;
    f->data = (struct gp_rect) {l->x0, l->y0, l->x0 + l->w, l->y0 + l->h};
    f->display = f->data;
    if (!exr_get_display_window(exr, l->part, &box))
        f->display = rect_of(box);
    if (exr_get_pixel_aspect_ratio(exr, l->part, &f->pixel_aspect))
        f->pixel_aspect = 1.0f;
    memcpy(f->chromaticities, gp_rec709_chromaticities,
           sizeof f->chromaticities);
    if (!exr_attr_get_chromaticities(exr, l->part, "chromaticities", &c)) {
        const float given[8] = {c.red_x,  c.red_y,  c.green_x, c.green_y,
                                c.blue_x, c.blue_y, c.white_x, c.white_y};
        memcpy(f->chromaticities, given, sizeof given);
    }
    gp_luminance_weights(f->chromaticities, f->luminance);
    f->part = l->part;
    f->parts = l->input->parts;
}

static gp_status make_channel(const struct reading *r, int index)
{
    const struct gp_exr_chunks *l = &r->layout;
    const exr_attr_chlist_entry_t *e = &l->channel->entries[index];
    struct gp_channel *c = &r->f->channel[index];
    *c = (struct gp_channel) {
        .type = gp_exr_pixel_type(e->pixel_type),
        .xs = e->x_sampling,
        .ys = e->y_sampling,
        .w = l->w / e->x_sampling,
        .h = l->h / e->y_sampling,
        .linear = e->p_linear,
        .colour = -1,
    };
    r->f->channels = index + 1;
    for (int k = 0; k < 3; k++) {
        if (r->colour.index[k] == index)
            c->colour = k;
    }
    c->name = gp_strdup(e->name.str);
    if (!c->name)
        return gp_fail(r->log, GP_ERR_BUG,
                       "%s: out of memory; close other "
                       "programs",
                       r->path);
    if (c->colour >= 0)
        return GP_OK;
    return gp_alloc(r->log, c->name, (size_t) c->w * (size_t) c->h,
                    gp_type_size(c->type), &c->data);
}

/* Full resolution for all but chroma, which may be halved in both ways. */
static gp_status check_sampling(const struct reading *r)
{
    const struct gp_exr_chunks *l = &r->layout;
    const exr_attr_chlist_entry_t *chroma = NULL;
    for (int k = 0; k < 3; k++) {
        if (r->colour.index[k] < 0)
            continue;
        const exr_attr_chlist_entry_t *e =
            &l->channel->entries[r->colour.index[k]];
        int xs = e->x_sampling, ys = e->y_sampling;
        bool whole = xs == 1 && ys == 1;
        if (r->colour.model == GP_COLOUR_YC && k != 1) {
            bool same = !chroma ||
                        (chroma->x_sampling == xs && chroma->y_sampling == ys);
            chroma = e;
            if (same && (whole || (xs == 2 && ys == 2)))
                continue;
        } else if (whole) {
            continue;
        }
        return gp_fail(r->log, GP_ERR_DATA,
                       "%s: channel %s is subsampled %d x %d, which no colour "
                       "has; write it at full resolution",
                       r->path, e->name.str, xs, ys);
    }
    return GP_OK;
}

static gp_status make_channels(struct reading *r)
{
    const int n = r->layout.channel->num_channels;
    void *channels, *sinks;
    gp_status st = gp_alloc_zero(r->log, "channels", (size_t) n,
                                 sizeof *r->f->channel, &channels);
    r->f->channel = channels;
    if (!st)
        st = gp_alloc_zero(r->log, "channels", (size_t) n, sizeof *r->sink,
                           &sinks);
    if (st)
        return st;
    r->sink = sinks;
    r->f->colour_type = GP_HALF;
    for (int i = 0; i < n; i++) {
        st = make_channel(r, i);
        if (st)
            return st;
        const struct gp_channel *c = &r->f->channel[i];
        r->sink[i].to = c->data;
        if (c->colour >= 0 && c->type != GP_HALF)
            r->f->colour_type = GP_FLOAT;
    }
    return GP_OK;
}

/* -- pixels --------------------------------------------------------------- */

static size_t channel_samples(const struct reading *r, int index)
{
    const struct gp_channel *c = &r->f->channel[index];
    return (size_t) c->w * (size_t) c->h;
}

/* Colour goes to the planes; luminance and chroma to planes of their own. */
static gp_status make_planes(struct reading *r)
{
    struct gp_frame *f = r->f;
    gp_status st = gp_planes_make(r->log, "frame", gp_frame_pixels(f), &f->rgb);
    for (int k = 0; !st && k < 3; k++) {
        int index = r->colour.index[k];
        float *to = f->rgb.c[k];
        if (index >= 0 && f->model == GP_COLOUR_YC) {
            void *p;
            st = gp_alloc(r->log, "chroma", channel_samples(r, index),
                          sizeof(float), &p);
            to = r->yc[k] = p;
        }
        if (index >= 0)
            r->sink[index] = (struct gp_exr_sink) {to, true};
    }
    return st;
}

/* RGB from luminance and chroma. A chroma channel that is missing is 0. */
static gp_status finish_yc(struct reading *r)
{
    struct gp_frame *f = r->f;
    const int some = r->colour.index[r->colour.index[0] >= 0 ? 0 : 2];
    const struct gp_channel *chroma = &f->channel[some];
    for (int k = 0; k < 3; k += 2) {
        if (r->yc[k])
            continue;
        void *p;
        gp_status st = gp_alloc_zero(r->log, "chroma", channel_samples(r, some),
                                     sizeof(float), &p);
        if (st)
            return st;
        r->yc[k] = p;
    }
    struct gp_yc yc = {
        .w = r->layout.w,
        .h = r->layout.h,
        .xs = chroma->xs,
        .ys = chroma->ys,
        .y = r->yc[1],
        .ry = r->yc[0],
        .by = r->yc[2],
        .half = f->colour_type == GP_HALF,
    };
    gp_yc_weights(f->chromaticities, yc.weight);
    return gp_yc_to_rgb(r->log, &yc, &f->rgb);
}

static gp_status finish_colour(struct reading *r)
{
    struct gp_frame *f = r->f;
    const size_t bytes = gp_frame_pixels(f) * sizeof(float);
    if (f->model == GP_COLOUR_YC)
        return finish_yc(r);
    for (int k = 0; k < 3; k++) {
        if (r->colour.index[k] >= 0)
            continue;
        if (f->model == GP_COLOUR_GREY)
            memcpy(f->rgb.c[k], f->rgb.c[0], bytes);
        else
            memset(f->rgb.c[k], 0, bytes);
    }
    return GP_OK;
}

static gp_status read_part(struct reading *r)
{
    gp_status st;
    GP_TRY(check_sampling(r));
    GP_TRY(make_channels(r));
    GP_TRY(make_planes(r));
    GP_TRY(gp_exr_decode(r->log, &r->layout, r->sink));
    GP_TRY(finish_colour(r));
out:
    return st;
}

static gp_status read_choice(const struct gp_log *log,
                             const struct gp_read_params *p, const char *path,
                             const struct gp_input *o,
                             const struct gp_exr_choice *choice,
                             struct gp_frame *out)
{
    gp_status st;
    struct gp_frame f = {0};
    struct reading r = {
        .log = log,
        .path = path,
        .f = &f,
        .colour = choice->colour,
    };
    GP_TRY(gp_exr_chunks_find(log, path, o, choice->part, p->max_pixels,
                              &r.layout));
    gp_exr_frame_header(&r.layout, &f);
    f.model = choice->colour.model;
    GP_TRY(gp_window_check(
        log, path, "display", (int64_t) f.display.x1 - f.display.x0,
        (int64_t) f.display.y1 - f.display.y0, p->max_pixels));
    GP_TRY(read_part(&r));
    f.path = gp_strdup(path);
    if (!f.path)
        st = gp_fail(log, GP_ERR_BUG,
                     "%s: out of memory; close other "
                     "programs",
                     path);
out:
    gp_exr_chunks_free(&r.layout);
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
                      const char *path, struct gp_stream *stream,
                      struct gp_frame *out)
{
    struct gp_input *o = NULL;
    struct gp_exr_choice choice;
    gp_status st = gp_exr_open(log, path, stream, &o);
    if (!st)
        st = gp_exr_choose(log, p, path, o, 0, &choice);
    if (!st) {
        o->part = choice.part;
        st = read_choice(log, p, path, o, &choice, out);
    }
    if (st) {
        gp_input_free(o);
        return st;
    }
    out->input = o;
    out->input_free = gp_input_free;
    return GP_OK;
}

/* -- other layers of a file that is open ----------------------------------- */

/* The view that is asked for; else that of f's part first, since a layer of
 * the other eye is the last that is meant. */
static gp_status choose_layer(const struct gp_log *log,
                              const struct gp_read_params *p,
                              const struct gp_frame *f, const char *layer,
                              struct gp_exr_choice *out)
{
    const struct gp_input *o = gp_input_of(f);
    struct gp_read_params q = {
        .max_pixels = p->max_pixels,
        .layer = layer,
        .view = p->view,
    };
    if (!p->view) {
        q.view = gp_exr_part_view(o, f->part);
        if (q.view && !gp_exr_choose(NULL, &q, f->path, o, f->part, out))
            return GP_OK;
        q.view = NULL;
    }
    return gp_exr_choose(log, &q, f->path, o, f->part, out);
}

/* True when every channel of the colour lies in f as it was read. */
static bool is_in_frame(const struct gp_frame *f,
                        const struct gp_exr_choice *choice)
{
    const exr_attr_chlist_t *list;
    if (choice->part != f->part || choice->colour.model == GP_COLOUR_YC ||
        exr_get_channels(gp_input_of(f)->exr, f->part, &list) ||
        list->num_channels != f->channels)
        return false;
    for (int k = 0; k < 3; k++) {
        const int i = choice->colour.index[k];
        if (i < 0)
            continue;
        const struct gp_channel *c = &f->channel[i];
        if (!c->data || c->xs != 1 || c->ys != 1)
            return false;
    }
    return true;
}

/* A frame like f without pixels and channels. */
static gp_status start_layer(const struct gp_log *log, const struct gp_frame *f,
                             struct gp_frame *out)
{
    *out = (struct gp_frame) {
        .path = gp_strdup(f->path),
        .data = f->data,
        .display = f->display,
        .pixel_aspect = f->pixel_aspect,
        .part = f->part,
        .parts = f->parts,
        .colour_type = GP_HALF,
    };
    memcpy(out->chromaticities, f->chromaticities, sizeof f->chromaticities);
    memcpy(out->luminance, f->luminance, sizeof f->luminance);
    if (!out->path)
        return gp_fail(log, GP_ERR_BUG,
                       "%s: out of memory; close other "
                       "programs",
                       f->path);
    return gp_planes_make(log, "layer", gp_frame_pixels(f), &out->rgb);
}

/* Channel `index` of f as colour k. */
static gp_status copy_channel(const struct gp_log *log,
                              const struct gp_frame *f, int index, int k,
                              struct gp_frame *out)
{
    const struct gp_channel *from = &f->channel[index];
    struct gp_channel *to = &out->channel[out->channels++];
    *to = *from;
    to->data = NULL;
    to->colour = k;
    to->name = gp_strdup(from->name);
    if (!to->name)
        return gp_fail(log, GP_ERR_BUG,
                       "%s: out of memory; close other "
                       "programs",
                       f->path);
    if (to->type != GP_HALF)
        out->colour_type = GP_FLOAT;
    gp_channel_floats(f, index, out->rgb.c[k]);
    return GP_OK;
}

static gp_status copy_layer(const struct gp_log *log, const struct gp_frame *f,
                            const struct gp_colour_choice *colour,
                            struct gp_frame *out)
{
    gp_status st;
    void *channels;
    const size_t bytes = gp_frame_pixels(f) * sizeof(float);
    GP_TRY(start_layer(log, f, out));
    out->model = colour->model;
    GP_TRY(gp_alloc_zero(log, "channels", 3, sizeof *out->channel, &channels));
    out->channel = channels;
    for (int k = 0; k < 3; k++) {
        if (colour->index[k] >= 0)
            GP_TRY(copy_channel(log, f, colour->index[k], k, out));
        else if (colour->model == GP_COLOUR_GREY)
            memcpy(out->rgb.c[k], out->rgb.c[0], bytes);
        else
            memset(out->rgb.c[k], 0, bytes);
    }
out:
    return st;
}

static bool same_window(const struct gp_input *o, int part,
                        const struct gp_frame *f)
{
    exr_attr_box2i_t d;
    return !exr_get_data_window(o->exr, part, &d) && d.min.x == f->data.x0 &&
           d.min.y == f->data.y0 && d.max.x == f->data.x1 - 1 &&
           d.max.y == f->data.y1 - 1;
}

gp_status gp_read_layer(const struct gp_log *log,
                        const struct gp_read_params *p,
                        const struct gp_frame *f, const char *layer,
                        struct gp_frame *out)
{
    struct gp_input *const o = f->input;
    struct gp_exr_choice choice;
    struct gp_frame made = {0};
    if (!o || !o->exr)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: layers beside the frame are read from EXR alone; "
                       "convert it, with e.g. oiiotool",
                       f->path);
    gp_status st = choose_layer(log, p, f, layer, &choice);
    if (st)
        return st;
    if (!same_window(o, choice.part, f))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the data window of %s (part %d) is not that of the "
                       "frame (part %d); render both with one window",
                       f->path, layer ? layer : "the view", choice.part,
                       f->part);
    if (is_in_frame(f, &choice))
        st = copy_layer(log, f, &choice.colour, &made);
    else
        st = read_choice(log, p, f->path, o, &choice, &made);
    if (st) {
        gp_frame_free(&made);
        return st;
    }
    made.input = o;
    *out = made;
    return GP_OK;
}
