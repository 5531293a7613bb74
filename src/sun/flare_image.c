/* Images of flare elements at half sizes, so that bilinear samples a pixel
 * apart miss no texel. */
#include "sun/flare_item.h"

#include "core/luminance.h"
#include "core/memory.h"

#include <math.h>

/* Four texels' mean; those outside are 0. The picture keeps its corner, so a
 * place u in texels is u / 2. */
static void halve_plane(const struct gp_flare_image *in, int c, int w, int h,
                        float *out)
{
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            float sum = 0.0f;
            for (int j = 2 * y; j < in->h && j < 2 * y + 2; j++) {
                for (int i = 2 * x; i < in->w && i < 2 * x + 2; i++)
                    sum += in->rgb.c[c][(size_t) j * (size_t) in->w +
                                        (size_t) i];
            }
            out[(size_t) y * (size_t) w + (size_t) x] = 0.25f * sum;
        }
    }
}

static gp_status halve(const struct gp_log *log,
                       const struct gp_flare_image *in,
                       struct gp_flare_image *out)
{
    struct gp_flare_image half = {
        .w = (in->w + 1) / 2, .h = (in->h + 1) / 2, .cx = in->cx / 2.0,
        .cy = in->cy / 2.0, .serial = in->serial,
    };
    const gp_status st = gp_planes_make(log, "a flare image at half size",
                                        (size_t) half.w * (size_t) half.h,
                                        &half.rgb);
    if (st)
        return st;
    for (int c = 0; c < 3; c++)
        halve_plane(in, c, half.w, half.h, half.rgb.c[c]);
    *out = half;
    return GP_OK;
}

static void sum_up(struct gp_flare_level *l)
{
    const size_t n = (size_t) l->image.w * (size_t) l->image.h;
    for (int c = 0; c < 3; c++) {
        const float *const v = l->image.rgb.c[c];
        l->sum[c] = 0.0;
        for (size_t i = 0; i < n; i++)
            l->sum[c] += (double) v[i];
        l->luminance += l->sum[c] * (double) gp_rec709_luminance[c];
    }
    if (!(l->luminance > 0.0) || !isfinite(l->luminance))
        l->luminance = 0.0;
}

gp_status gp_flare_level_make(const struct gp_log *log,
                              const struct gp_flare_image *image, double size,
                              struct gp_flare_level *out)
{
    struct gp_flare_level l = {.image = *image};
    sum_up(&l);
    double longer = image->w > image->h ? image->w : image->h;
    gp_status st = GP_OK;
    while (!st && l.luminance > 0.0 && longer > size &&
           (l.image.w > 1 || l.image.h > 1)) {
        struct gp_flare_image half = {0};
        st = halve(log, &l.image, &half);
        if (l.level > 0)
            gp_planes_free(&l.image.rgb);
        l.image = half;
        l.level++;
        longer /= 2.0;
    }
    *out = l;
    return st;
}

void gp_flare_level_free(struct gp_flare_level *l)
{
    if (l->level > 0)
        gp_planes_free(&l->image.rgb);
    *l = (struct gp_flare_level) {0};
}
