// SPDX-License-Identifier: Apache-2.0
/* A file's frame as the picture that a library's room takes, and back. */
#ifndef GP_TESTS_UNIT_VIEWS_H
#define GP_TESTS_UNIT_VIEWS_H

#include "io/frame.h"

#include <string.h>

/* Its planes and its path stay the frame's. */
static inline struct gp_image view_of(const struct gp_frame *f)
{
    struct gp_image v = gp_image_blank(f->data);
    v.path = f->path;
    v.display = f->display;
    v.read = f->read;
    v.pixel_aspect = f->pixel_aspect;
    v.names_chromaticities = f->names_chromaticities;
    memcpy(v.chromaticities, f->chromaticities, sizeof v.chromaticities);
    memcpy(v.luminance, f->luminance, sizeof v.luminance);
    v.rgb = f->rgb;
    return v;
}

/* A frame of those planes, which stay the picture's. */
static inline struct gp_frame frame_of(const struct gp_image *v,
                                       const struct gp_planes *rgb)
{
    struct gp_frame f = gp_frame_blank(v->data);
    f.path = v->path;
    f.display = v->display;
    f.read = v->read;
    f.pixel_aspect = v->pixel_aspect;
    f.names_chromaticities = v->names_chromaticities;
    memcpy(f.chromaticities, v->chromaticities, sizeof f.chromaticities);
    memcpy(f.luminance, v->luminance, sizeof f.luminance);
    f.rgb = *rgb;
    return f;
}

#endif
