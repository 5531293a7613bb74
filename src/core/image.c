// SPDX-License-Identifier: Apache-2.0
#include "core/image.h"

#include "core/colour.h"
#include "core/memory.h"

#include <string.h>

gp_status gp_planes_make(const struct gp_log *log, const char *what,
                         size_t samples, struct gp_planes *p)
{
    // one block: of three, each would end in a huge page that it fills in part
    const size_t line = GP_ALIGN / sizeof(float);
    const size_t apart = (samples + line - 1) / line * line;
    *p = (struct gp_planes) {0};
    gp_status st = gp_alloc(log, what, samples > SIZE_MAX / 16 ? SIZE_MAX : apart,
                            3 * sizeof(float), &p->c[0]);
    for (int c = 1; !st && c < 3; c++)
        p->c[c] = p->c[c - 1] + apart;
    return st;
}

void gp_planes_free(struct gp_planes *p)
{
    gp_free(p->c[0]);
    *p = (struct gp_planes) {0};
}

void gp_planes_clear(const struct gp_planes *p, size_t from, size_t n)
{
    for (int c = 0; c < 3; c++)
        memset(p->c[c] + from, 0, n * sizeof(float));
}

struct gp_image gp_image_blank(struct gp_rect window)
{
    struct gp_image f = {
        .data = window, .display = window, .pixel_aspect = 1.0f,
    };
    memcpy(f.chromaticities, gp_rec709_chromaticities, sizeof f.chromaticities);
    memcpy(f.luminance, gp_rec709_luminance, sizeof f.luminance);
    return f;
}

void gp_image_free(struct gp_image *f)
{
    gp_free(f->path);
    gp_planes_free(&f->rgb);
    gp_planes_free(&f->layer);
    gp_planes_free(&f->lit);
    gp_planes_free(&f->shown);
    *f = (struct gp_image) {0};
}

void gp_plane_free(struct gp_plane *p)
{
    if (!p->borrowed)
        gp_free(p->v);
    gp_free(p->name);
    *p = (struct gp_plane) {0};
}
