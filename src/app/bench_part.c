#include "app/bench_measure.h"

#include <string.h>

enum { BLOCK = 32 }; // no group or cluster of bench's is cut by one

/* Rows of blocks start 3 blocks further than the one before, 37 for
 * hundredths, so that the chosen ones make no columns. */
static bool is_chosen(int x, int y, int parts)
{
    const int step = parts > 10 ? 37 : 3;
    return (x / BLOCK + y / BLOCK * step) % parts == 0;
}

static void copy_blocks(const struct gp_frame *f, int parts,
                        struct gp_planes *to)
{
    const int w = gp_frame_w(f), h = gp_frame_h(f);
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x += BLOCK) {
            const size_t at = (size_t) y * (size_t) w + (size_t) x;
            const size_t n = (size_t) (w - x < BLOCK ? w - x : BLOCK);
            for (int c = 0; c < 3 && is_chosen(x, y, parts); c++)
                memcpy(to->c[c] + at, f->rgb.c[c] + at, n * sizeof(float));
        }
    }
}

static void copy_first(const struct gp_frame *f, const struct gp_sources *src,
                       struct gp_planes *to)
{
    const size_t w = (size_t) gp_frame_w(f);
    size_t y = 0;
    while (src->row[y + 1] == 0)
        y++;
    const size_t at = y * w + (size_t) src->x[0];
    for (int c = 0; c < 3; c++)
        to->c[c][at] = f->rgb.c[c][at];
}

gp_status gp_bench_part(const struct gp_log *log, const struct gp_frame *f,
                        const struct gp_sources *src, int parts,
                        struct gp_frame *out)
{
    const size_t n = gp_frame_pixels(f);
    struct gp_frame part = {.data = f->data, .display = f->display};
    memcpy(part.luminance, f->luminance, sizeof part.luminance);
    memcpy(part.chromaticities, f->chromaticities, sizeof part.chromaticities);
    gp_status st = gp_planes_make(log, "part of the frame", n, &part.rgb);
    if (st)
        return st;
    for (int c = 0; c < 3; c++)
        memset(part.rgb.c[c], 0, n * sizeof(float));
    if (parts > 0)
        copy_blocks(f, parts, &part.rgb);
    else if (src->n > 0)
        copy_first(f, src, &part.rgb);
    *out = part;
    return GP_OK;
}
