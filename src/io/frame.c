#include "io/frame.h"

#include "core/colour.h"
#include "core/memory.h"

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

const struct gp_channel *gp_frame_channel(const struct gp_frame *f,
                                          const char *name)
{
    for (int i = 0; i < f->channels; i++) {
        if (strcmp(f->channel[i].name, name) == 0)
            return &f->channel[i];
    }
    return NULL;
}
