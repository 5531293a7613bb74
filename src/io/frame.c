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

const struct gp_channel *gp_frame_channel(const struct gp_frame *f,
                                          const char *name)
{
    for (int i = 0; i < f->channels; i++) {
        if (strcmp(f->channel[i].name, name) == 0)
            return &f->channel[i];
    }
    return NULL;
}

// -- attributes ---------------------------------------------------------------

static bool part_matrix(const struct gp_input *o, int part, const char *name,
                        double m[16])
{
    exr_attr_m44f_t single;
    exr_attr_m44d_t twice;
    if (!exr_attr_get_m44d(o->exr, part, name, &twice)) {
        memcpy(m, twice.m, sizeof twice.m);
        return true;
    }
    if (exr_attr_get_m44f(o->exr, part, name, &single))
        return false;
    for (int i = 0; i < 16; i++)
        m[i] = (double) single.m[i];
    return true;
}

bool gp_frame_matrix(const struct gp_frame *f, const char *name, double m[16])
{
    const struct gp_input *o = gp_input_of(f);
    if (!o)
        return false;
    if (part_matrix(o, o->part, name, m))
        return true;
    for (int part = 0; part < o->parts; part++) {
        if (part != o->part && part_matrix(o, part, name, m))
            return true;
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

double gp_frame_rate(const struct gp_frame *f)
{
    const struct gp_input *const o = gp_input_of(f);
    exr_attr_rational_t rate;
    if (!o || exr_attr_get_rational(o->exr, o->part, "framesPerSecond", &rate))
        return 0.0;
    return rate.num > 0 && rate.denom > 0 ? (double) rate.num / rate.denom
                                          : 0.0;
}

bool gp_frame_real(const struct gp_frame *f, const char *name, double *v)
{
    const struct gp_input *const o = gp_input_of(f);
    float found;
    if (!o || exr_attr_get_float(o->exr, o->part, name, &found) ||
        !isfinite(found))
        return false;
    *v = (double) found;
    return true;
}

bool gp_frame_pair(const struct gp_frame *f, const char *name, double v[2])
{
    const struct gp_input *const o = gp_input_of(f);
    exr_attr_v2f_t found;
    if (!o || exr_attr_get_v2f(o->exr, o->part, name, &found) ||
        !isfinite(found.x) || !isfinite(found.y))
        return false;
    v[0] = (double) found.x;
    v[1] = (double) found.y;
    return true;
}
