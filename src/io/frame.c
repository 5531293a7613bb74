// SPDX-License-Identifier: Apache-2.0
#include "io/frame.h"

#include "core/colour.h"
#include "core/memory.h"
#include "io/exr/exr.h"

#include <math.h>
#include <string.h>

struct gp_frame gp_frame_blank(struct gp_rect window)
{
    struct gp_frame f = {
        .data = window, .display = window, .pixel_aspect = 1.0f,
        .colour_type = GP_FLOAT, .parts = 1,
    };
    memcpy(f.chromaticities, gp_rec709_chromaticities, sizeof f.chromaticities);
    memcpy(f.luminance, gp_rec709_luminance, sizeof f.luminance);
    return f;
}

void gp_frame_free(struct gp_frame *f)
{
    if (f->input_free)
        f->input_free(f->input);
    for (int i = 0; i < f->channels; i++) {
        gp_free(f->channel[i].name);
        gp_free(f->channel[i].data);
    }
    gp_free(f->channel);
    for (int i = 0; i < f->attributes; i++) {
        gp_free(f->attribute[i].name);
        gp_free(f->attribute[i].text);
    }
    gp_free(f->attribute);
    gp_free(f->path);
    gp_planes_free(&f->rgb);
    *f = (struct gp_frame) {0};
}

gp_status gp_frame_make(const struct gp_log *log, const char *path, int n,
                        struct gp_frame *f)
{
    f->path = gp_strdup(path);
    if (!f->path)
        return gp_no_memory(log, path);
    const gp_status st = gp_alloc_zero(log, "channels", (size_t) n,
                                       sizeof *f->channel, &f->channel);
    return st ? st : gp_planes_make(log, "frame", gp_frame_pixels(f), &f->rgb);
}

gp_status gp_frame_add(const struct gp_log *log, struct gp_frame *f,
                       const struct gp_channel *like)
{
    struct gp_channel *const c = &f->channel[f->channels++];
    *c = *like;
    c->data = NULL;
    c->name = gp_strdup(like->name);
    if (!c->name)
        return gp_no_memory(log, f->path);
    if (c->colour < 0)
        return gp_alloc(log, c->name, (size_t) c->w * (size_t) c->h,
                        gp_type_size(c->type), &c->data);
    if (c->type != GP_HALF)
        f->colour_type = GP_FLOAT;
    return GP_OK;
}

void gp_frame_fill(struct gp_frame *f, const int index[3])
{
    const size_t bytes = gp_frame_pixels(f) * sizeof(float);
    for (int k = 0; k < 3; k++) {
        if (index[k] < 0 && f->model == GP_COLOUR_GREY)
            memcpy(f->rgb.c[k], f->rgb.c[0], bytes);
        else if (index[k] < 0)
            memset(f->rgb.c[k], 0, bytes);
    }
}

const struct gp_channel *gp_frame_channel(const struct gp_frame *f,
                                          const char *name)
{
    for (int i = 0; i < f->channels; i++) {
        if (strcmp(f->channel[i].name, name) == 0)
            return &f->channel[i];
    }
    return NULL;
}

const char *gp_frame_colour(const struct gp_frame *f)
{
    int i = 0;
    while (i < f->channels && f->channel[i].colour < 0)
        i++;
    return i < f->channels ? f->channel[i].name : NULL;
}

// -- attributes ---------------------------------------------------------------

/* The numbers of an attribute; how many, 0 where it has none. */
static int numbers_of(const exr_attribute_t *a, double v[16])
{
    switch (a->type) {
    case EXR_ATTR_FLOAT:
        v[0] = (double) a->f;
        return 1;
    case EXR_ATTR_ENVMAP:
        v[0] = (double) a->uc;
        return 1;
    case EXR_ATTR_RATIONAL:
        v[0] = (double) a->rational->num / a->rational->denom;
        return 1;
    case EXR_ATTR_V2F:
        v[0] = (double) a->v2f->x;
        v[1] = (double) a->v2f->y;
        return 2;
    case EXR_ATTR_M44F:
        for (int i = 0; i < 16; i++)
            v[i] = (double) a->m44f->m[i];
        return 16;
    case EXR_ATTR_M44D:
        memcpy(v, a->m44d->m, sizeof a->m44d->m);
        return 16;
    default:
        return 0;
    }
}

bool gp_frame_numbers(const struct gp_frame *f, const char *name, int n,
                      double *v)
{
    const struct gp_input *const o = gp_input_of(f);
    const exr_attribute_t *a;
    double found[16] = {0};
    for (int i = -1; o && i < o->parts; i++) {
        if (!exr_get_attribute_by_name(o->exr, i < 0 ? o->part : i, name, &a) &&
            numbers_of(a, found) == n && (n == 16 || isfinite(found[0]))) {
            memcpy(v, found, (size_t) n * sizeof *v);
            return true;
        }
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

struct glarepp_image gp_frame_view(const struct gp_frame *f,
                                   const struct gp_planes *planes)
{
    struct glarepp_image v = GLAREPP_IMAGE;
    for (int c = 0; c < 3; c++)
        v.plane[c] = planes->c[c];
    v.data = f->data;
    v.display = f->display;
    v.aspect = f->pixel_aspect;
    v.primaries = f->names_chromaticities ? f->chromaticities : NULL;
    v.name = f->path;
    return v;
}
