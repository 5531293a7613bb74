#include "io/oiio/image.h"

#include "core/memory.h"
#include "io/oiio/oiio.h"
#include "io/whole.h"

#include <stdio.h>
#include <string.h>

struct held {
    const struct gp_oiio_api *api;
    struct gp_oiio_image image;
    struct gp_attribute *attribute;
};

static gp_status bridge_failed(const struct gp_log *log, const char *path,
                               int result, const char *which, const char *why)
{
    if (result == GP_OIIO_MEMORY)
        return gp_oiio_no_memory(log, path, why);
    return gp_fail(log, GP_ERR_DATA,
                   "%s: no image format%s that can be read (%s); give an EXR "
                   "or convert it", path, which,
                   why[0] ? why : "cut off or damaged");
}

static void close_image(struct gp_image *image)
{
    struct held *const held = image->own;
    if (held->image.own)
        held->api->image_free(&held->image);
    gp_free(held->attribute);
    gp_free(held);
}

static gp_status read_rows(const struct gp_log *log, struct gp_image *image,
                           int y, float *to)
{
    struct held *const held = image->own;
    char why[512] = "";
    const int got = held->api->rows(&held->image, y, to, why, sizeof why);
    return got ? bridge_failed(log, image->path, got, "", why) : GP_OK;
}

/* Attributes with our kinds and names; the texts stay the bridge's. */
static gp_status list_attributes(const struct gp_log *log, struct held *held,
                                 struct gp_image *image)
{
    void *list;
    gp_status st = gp_alloc(log, "attributes",
                            (size_t) held->image.attributes,
                            sizeof *held->attribute, &list);
    held->attribute = list;
    for (int i = 0; !st && i < held->image.attributes; i++) {
        const struct gp_oiio_attribute *a = &held->image.attribute[i];
        held->attribute[i] = (struct gp_attribute) {
            .name = (char *) (uintptr_t) a->name,
            .kind = a->kind == 0   ? GP_ATTRIBUTE_TEXT
                    : a->kind == 1 ? GP_ATTRIBUTE_INT : GP_ATTRIBUTE_FLOAT,
            .text = a->kind == 0 ? (char *) (uintptr_t) a->text : NULL,
            .whole = a->whole, .real = a->real,
        };
        if (a->kind == 2 && strcmp(a->name, "PixelAspectRatio") == 0)
            image->pixel_aspect = a->real;
    }
    image->attribute = held->attribute;
    image->attributes = st ? 0 : held->image.attributes;
    return st;
}

gp_status gp_oiio_image_open(const struct gp_log *log, const char *path,
                             const struct gp_stream *stream, int part,
                             long long max_pixels, struct gp_image *out)
{
    char why[512] = "", which[40] = "";
    void *own = NULL;
    struct gp_image image = {0};
    const struct gp_oiio_api *api = gp_oiio_open(why, sizeof why);
    if (!api)
        return gp_fail(log, GP_ERR_IO,
                       "%s: formats other than EXR and PNG need the "
                       "OpenImageIO bridge (%s); install it, or give an EXR",
                       path, why);
    gp_status st = gp_whole_check(log, path, stream, part, max_pixels);
    if (!st)
        st = gp_alloc_zero(log, "picture", 1, sizeof(struct held), &own);
    if (st)
        return st;
    struct held *const held = own;
    held->api = api;
    if (part > 0)
        snprintf(which, sizeof which, " and part %d of it", part);
    const int got = api->open(path, stream->data, stream->size, part,
                              max_pixels, &held->image, why, sizeof why);
    if (got) {
        held->image = (struct gp_oiio_image) {0};
        gp_free(held);
        return bridge_failed(log, path, got, which, why);
    }
    const struct gp_oiio_image *const in = &held->image;
    image = (struct gp_image) {
        .path = path,
        .data = {in->x, in->y, in->x + in->w, in->y + in->h},
        .display = {in->full_x, in->full_y, in->full_x + in->full_w,
                    in->full_y + in->full_h},
        .chromaticities = in->has_chromaticities ? in->chromaticities : NULL,
        .channels = in->channels, .channel_name = in->channel_name,
        .half = in->half, .bits = in->bits, .colour_space = in->colour_space,
        .block = in->block, .rows = read_rows, .close = close_image,
        .own = held,
    };
    st = list_attributes(log, held, &image);
    if (st)
        gp_image_close(&image);
    else
        *out = image;
    return st;
}
