/* EXR pixels by way of OpenImageIO. */
#include "io/exr/decode.h"

#include "core/memory.h"
#include "io/half.h"

#include <string.h>

static int image_channel(const struct gp_oiio_image *image, const char *name)
{
    for (int i = 0; i < image->channels; i++) {
        if (strcmp(image->channel_name[i], name) == 0)
            return i;
    }
    return -1;
}

/* Row `y` of one channel, `row` being w floats of scratch. */
static void put_row(const struct gp_exr_layout *l,
                    const struct gp_oiio_image *image, int from,
                    exr_pixel_type_t type, const struct gp_exr_sink *s, int y,
                    float *row)
{
    const size_t w = (size_t) l->w, at = (size_t) y * w;
    const size_t step = (size_t) image->channels;
    const float *p = image->pixels + at * step + (size_t) from;
    for (size_t x = 0; x < w; x++) {
        uint32_t u;
        row[x] = p[x * step];
        if (type == EXR_PIXEL_UINT && s->as_float) {
            memcpy(&u, &row[x], sizeof u);
            row[x] = (float) u;
        }
    }
    if (type == EXR_PIXEL_HALF && !s->as_float)
        (void) gp_float_to_half(row, (uint16_t *) s->to + at, w);
    else
        memcpy((float *) s->to + at, row, w * sizeof *row);
}

static gp_status put_channels(const struct gp_log *log,
                              const struct gp_exr_layout *l,
                              const struct gp_oiio_image *image,
                              const struct gp_exr_sink *sink)
{
    void *row;
    gp_status st = gp_alloc(log, "row", (size_t) l->w, sizeof(float), &row);
    for (int i = 0; !st && i < l->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &l->channel->entries[i];
        int from = image_channel(image, e->name.str);
        if (!sink[i].to)
            continue;
        if (from < 0)
            st = gp_fail(log, GP_ERR_DATA,
                         "%s: OpenImageIO did not find channel %s; write the "
                         "file with zip compression", l->path, e->name.str);
        for (int y = 0; !st && y < l->h; y++)
            put_row(l, image, from, e->pixel_type, &sink[i], y, row);
    }
    gp_free(row);
    return st;
}

gp_status gp_exr_decode_by_bridge(const struct gp_log *log,
                                  const struct gp_exr_layout *l,
                                  const struct gp_exr_sink *sink)
{
    const struct gp_stream *s = &l->origin->stream;
    struct gp_oiio_image image;
    char why[512];
    for (int i = 0; i < l->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &l->channel->entries[i];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return gp_fail(log, GP_ERR_DATA,
                           "%s: channel %s is subsampled and DWA compressed, "
                           "which nothing here decodes; write the file with "
                           "another compression", l->path, e->name.str);
    }
    const struct gp_oiio_api *api = gp_oiio_open(why, sizeof why);
    if (!api)
        return gp_fail(log, GP_ERR_IO,
                       "%s: DWA compression needs the OpenImageIO bridge "
                       "(%s); install it, or write the file with zip",
                       l->path, why);
    const int got = api->read(l->path, s->data, s->size, l->part,
                              (long long) l->w * l->h, &image, why,
                              sizeof why);
    if (got == GP_OIIO_MEMORY)
        return gp_oiio_no_memory(log, l->path, why);
    if (got)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the pixels are damaged (%s); copy or render the "
                       "file again", l->path, why);
    gp_status st;
    if (image.w == l->w && image.h == l->h)
        st = put_channels(log, l, &image, sink);
    else
        st = gp_fail(log, GP_ERR_DATA,
                     "%s: OpenImageIO found %d x %d pixels (%d x %d in the "
                     "header); render the file again", l->path, image.w,
                     image.h, l->w, l->h);
    api->image_free(&image);
    return st;
}
