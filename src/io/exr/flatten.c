// SPDX-License-Identifier: Apache-2.0
/* A deep part of an EXR as a frame, flattened by its own alpha. */
#include "io/exr/exr_priv.h"

#include "core/deep.h"
#include "core/memory.h"
#include "io/channels.h"

#include <string.h>

/* Finds channel `word` of the layer that `like` is of; -1: none. */
static int beside(const exr_attr_chlist_t *list, const char *like,
                  const char *word)
{
    const size_t layer = gp_layer_length(like);
    for (int i = 0; i < list->num_channels; i++) {
        const char *const name = list->entries[i].name.str;
        if (gp_layer_length(name) == layer && strncmp(name, like, layer) == 0 &&
            strcmp(name + layer, word) == 0)
            return i;
    }
    return -1;
}

/* Adds a channel as the file has it, k of the colour, or of samples of its own. */
static gp_status add_channel(const struct gp_log *log,
                             const exr_attr_chlist_entry_t *e, int k,
                             struct gp_frame *f)
{
    struct gp_channel *const c = &f->channel[f->channels++];
    gp_status st = GP_OK;
    *c = (struct gp_channel) {
        .name = gp_strdup(e->name.str),
        .type = GP_FLOAT,
        .xs = 1,
        .ys = 1,
        .w = gp_frame_w(f),
        .h = gp_frame_h(f),
        .linear = e->p_linear,
        .colour = k,
    };
    if (!c->name)
        return gp_no_memory(log, e->name.str);
    if (k >= 0)
        c->type = (enum gp_pixel_type) e->pixel_type;
    else
        st =
            gp_alloc(log, c->name, gp_frame_pixels(f), sizeof(float), &c->data);
    return st;
}

/* Finds Z, ZBack and A beside the colour, floats all of them. */
static gp_status find_samples(const struct gp_log *log, const char *path,
                              const struct gp_exr_deep *deep,
                              const struct gp_exr_choice *choice,
                              struct gp_deep *d, int *alpha)
{
    const exr_attr_chlist_t *const list = deep->part.channel;
    const int *const index = choice->colour.index;
    const char *const like = list->entries[index[0]].name.str;
    int z = beside(list, like, "Z"), back = beside(list, like, "ZBack");
    z = z < 0 ? beside(list, "Z", "Z") : z;
    back = back < 0 ? beside(list, "Z", "ZBack") : back;
    *alpha = beside(list, like, "A");
    *alpha = *alpha < 0 ? beside(list, "A", "A") : *alpha;
    const int all[] = {z, *alpha, index[0], index[1], index[2], back};
    for (int i = 0; i < 6; i++) {
        if (i < 2 && all[i] < 0)
            return gp_fail(log, GP_ERR_DATA,
                           "%s: deep data without %s (part "
                           "%d) has no picture; render it, or flatten the file "
                           "with e.g. oiiotool --flatten",
                           path, i ? "A" : "Z", choice->part);
        if (all[i] >= 0 && list->entries[all[i]].pixel_type == EXR_PIXEL_UINT)
            return gp_fail(log, GP_ERR_DATA,
                           "%s: deep channel %s is of whole "
                           "numbers (part %d); write floats",
                           path, list->entries[all[i]].name.str, choice->part);
    }
    d->z = deep->sample[z];
    d->alpha = deep->sample[*alpha];
    d->back = back < 0 ? NULL : deep->sample[back];
    for (int c = 0; c < 3; c++)
        d->colour[c] = deep->sample[index[c] < 0 ? index[0] : index[c]];
    return GP_OK;
}

gp_status gp_exr_read_flat(const struct gp_log *log,
                           const struct gp_read_params *p, const char *path,
                           const struct gp_input *in,
                           const struct gp_exr_choice *choice,
                           struct gp_frame *out)
{
    const int *const index = choice->colour.index;
    struct gp_frame f = {.model = choice->colour.model, .colour_type = GP_HALF};
    struct gp_exr_deep deep;
    struct gp_deep d = {0};
    int alpha;
    gp_status st;
    GP_TRY(gp_exr_deep_read(log, path, in, choice->part, p->max_pixels, &deep));
    const exr_attr_chlist_t *const list = deep.part.channel;
    gp_exr_frame_header(&deep.part, &f);
    GP_TRY(gp_window_check(
        log, path, "display", (int64_t) f.display.x1 - f.display.x0,
        (int64_t) f.display.y1 - f.display.y0, p->max_pixels));
    GP_TRY(find_samples(log, path, &deep, choice, &d, &alpha));
    d.window = f.data;
    d.first = deep.first;
    GP_TRY(gp_planes_make(log, "frame", gp_frame_pixels(&f), &f.rgb));
    GP_TRY(gp_alloc_zero(log, "channels", 4, sizeof *f.channel, &f.channel));
    float *flat = NULL;
    for (int i = 0; i < list->num_channels; i++) {
        const int k = i == index[0]   ? 0
                      : i == index[1] ? 1
                      : i == index[2] ? 2
                                      : -1;
        if (k < 0 && i != alpha)
            continue;
        GP_TRY(add_channel(log, &list->entries[i], k, &f));
        if (k < 0)
            flat = f.channel[f.channels - 1].data;
        else if (list->entries[i].pixel_type != EXR_PIXEL_HALF)
            f.colour_type = GP_FLOAT;
    }
    GP_TRY(gp_deep_flatten(log, &d, &f.rgb, flat));
    f.path = gp_strdup(path);
    if (!f.path)
        st = gp_no_memory(log, path);
out:
    gp_exr_deep_free(&deep);
    if (st)
        gp_frame_free(&f);
    else
        *out = f;
    return st;
}
