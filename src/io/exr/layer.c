/* Other layers of a file that is open already. */
#include "io/read.h"

#include "core/memory.h"
#include "io/channels.h"
#include "io/exr/choose.h"
#include "io/exr/read.h"
#include "io/exr/view.h"

#include <string.h>

/* The view that is asked for; else that of f's part first, since a layer of
 * the other eye is the last that is meant. */
static gp_status choose(const struct gp_log *log,
                        const struct gp_read_params *p,
                        const struct gp_frame *f, const char *layer,
                        struct gp_exr_choice *out)
{
    const struct gp_origin *o = gp_origin_of(f);
    struct gp_read_params q = {
        .max_pixels = p->max_pixels, .layer = layer, .view = p->view,
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
static bool lies_in(const struct gp_frame *f,
                    const struct gp_exr_choice *choice)
{
    const exr_attr_chlist_t *list;
    if (choice->part != f->part || choice->colour.model == GP_COLOUR_YC ||
        exr_get_channels(gp_origin_of(f)->exr, f->part, &list) ||
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
static gp_status like(const struct gp_log *log, const struct gp_frame *f,
                      struct gp_frame *out)
{
    *out = (struct gp_frame) {
        .path = gp_strdup(f->path), .data = f->data, .display = f->display,
        .pixel_aspect = f->pixel_aspect, .part = f->part, .parts = f->parts,
        .colour_type = GP_HALF,
    };
    memcpy(out->chromaticities, f->chromaticities, sizeof f->chromaticities);
    memcpy(out->luminance, f->luminance, sizeof f->luminance);
    if (!out->path)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory; close other "
                       "programs", f->path);
    return gp_planes_make(log, "layer", gp_frame_pixels(f), &out->rgb);
}

/* Channel `index` of f as colour k. */
static gp_status take_channel(const struct gp_log *log,
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
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory; close other "
                       "programs", f->path);
    if (to->type != GP_HALF)
        out->colour_type = GP_FLOAT;
    gp_channel_floats(f, index, out->rgb.c[k]);
    return GP_OK;
}

static gp_status take(const struct gp_log *log, const struct gp_frame *f,
                      const struct gp_colour_choice *colour,
                      struct gp_frame *out)
{
    gp_status st;
    void *channels;
    const size_t bytes = gp_frame_pixels(f) * sizeof(float);
    GP_TRY(like(log, f, out));
    out->model = colour->model;
    GP_TRY(gp_alloc_zero(log, "channels", 3, sizeof *out->channel, &channels));
    out->channel = channels;
    for (int k = 0; k < 3; k++) {
        if (colour->index[k] >= 0)
            GP_TRY(take_channel(log, f, colour->index[k], k, out));
        else if (colour->model == GP_COLOUR_GREY)
            memcpy(out->rgb.c[k], out->rgb.c[0], bytes);
        else
            memset(out->rgb.c[k], 0, bytes);
    }
out:
    return st;
}

static bool same_window(const struct gp_origin *o, int part,
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
    struct gp_origin *const o = f->origin;
    struct gp_exr_choice choice;
    struct gp_frame made = {0};
    if (!o || !o->exr)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: layers beside the frame are read from EXR alone; "
                       "convert it, with e.g. oiiotool", f->path);
    gp_status st = choose(log, p, f, layer, &choice);
    if (st)
        return st;
    if (!same_window(o, choice.part, f))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the data window of %s (part %d) is not that of the "
                       "frame (part %d); render both with one window", f->path,
                       layer ? layer : "the view", choice.part, f->part);
    if (lies_in(f, &choice))
        st = take(log, f, &choice.colour, &made);
    else
        st = gp_exr_read_choice(log, p, f->path, o, &choice, &made);
    if (st) {
        gp_frame_free(&made);
        return st;
    }
    made.origin = o;
    *out = made;
    return GP_OK;
}
