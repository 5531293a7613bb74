/* The pictures of a pair: FLIP's map in false colours, and the difference. */
#include "compare/compare_priv.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/file.h"

#include <math.h>
#include <string.h>

// -- FLIP --------------------------------------------------------------------

void gp_compare_magma(float v, float rgb[3])
{
    // least squares of degree 6, a row for each power
    static const float power[7][3] = {
        {-0.002136485f, -0.000749655f, -0.005386128f},
        {0.251660541f, 0.677523244f, 2.494026599f},
        {8.353717279f, -3.577719515f, 0.314467903f},
        {-27.66873309f, 14.26473078f, -13.64921319f},
        {52.17613981f, -27.94360607f, 12.94416944f},
        {-50.76852536f, 29.04658282f, 4.23415299f},
        {18.65570507f, -11.48977352f, -5.60196151f},
    };
    const float t = gp_clamp01(v);
    for (int c = 0; c < 3; c++) {
        float sum = power[6][c];
        for (int i = 5; i >= 0; i--)
            sum = sum * t + power[i][c];
        rgb[c] = gp_clamp01(sum);
    }
}

gp_status gp_compare_heatmap(
    const struct gp_log *log, const struct gp_write_params *p, const char *path,
    const struct gp_compare_match *m, const struct gp_compare_flip *f)
{
    struct gp_frame frame = gp_frame_blank(m->window);
    struct gp_write_params plain = *p;
    struct gp_write_stats stats = {0};
    const size_t pixels = gp_frame_pixels(&frame);
    gp_status st;
    frame.path = gp_strdup(path);
    if (!frame.path)
        return gp_no_memory(log, path);
    GP_TRY(gp_planes_make(log, "heatmap", pixels, &frame.shown));
    for (size_t i = 0; i < pixels; i++) {
        float rgb[3];
        gp_compare_magma(f->map[i], rgb);
        for (int c = 0; c < 3; c++)
            frame.shown.c[c][i] = gp_srgb_decode(rgb[c]);
    }
    plain.dither = GP_DITHER_NEVER; // each pixel is a number
    GP_TRY(gp_write_picture(log, &plain, path, &frame, &frame.shown,
                            GP_PICTURE_SHOWN, &stats));
out:
    gp_frame_free(&frame);
    return st;
}

// -- difference --------------------------------------------------------------

/* A pair's difference in `to`, a sample for each pixel of the window. */
static void subtract(const struct gp_compare_params *p,
                     const struct gp_compare_match *m, int pair, float *to)
{
    for (int y = m->window.y0; y < m->window.y1; y++) {
        for (int x = m->window.x0; x < m->window.x1; x++) {
            const float d = (float) (gp_compare_value(m, false, pair, x, y) -
                                     gp_compare_value(m, true, pair, x, y));
            *to++ = (p->absolute ? fabsf(d) : d) * p->scale;
        }
    }
}

/* The channels of the pairs in `f`, in the order of their names, all but its
 * colour with their samples. */
static gp_status make_channels(const struct gp_log *log,
    const struct gp_compare_params *p, const struct gp_compare_match *m,
    const int colour[3], struct gp_frame *f)
{
    const size_t pixels = gp_frame_pixels(f);
    gp_status st = gp_alloc_zero(log, "channels", (size_t) m->pairs,
                                 sizeof *f->channel, &f->channel);
    for (int i = 0; i < m->pairs && !st; i++) {
        struct gp_channel *const c = &f->channel[f->channels++];
        *c = (struct gp_channel) {
            .name = gp_strdup(gp_compare_name(m, i)), .type = GP_FLOAT,
            .xs = 1, .ys = 1, .w = gp_frame_w(f), .h = gp_frame_h(f),
            .colour = -1,
        };
        for (int k = 2; k >= 0; k--)
            c->colour = colour[k] == i ? k : c->colour;
        if (!c->name)
            return gp_no_memory(log, f->path);
        if (c->colour >= 0)
            continue;
        st = gp_alloc(log, c->name, pixels, sizeof(float), &c->data);
        if (!st)
            subtract(p, m, i, c->data);
    }
    return st;
}

gp_status gp_compare_subtract(const struct gp_log *log,
    const struct gp_write_params *write, const struct gp_compare_params *p,
    const char *path, const struct gp_compare_match *m)
{
    static const char *const name[3] = {"R", "G", "B"};
    struct gp_write_params as = *write;
    struct gp_write_stats stats = {0};
    struct gp_frame f = gp_frame_blank(m->window);
    const size_t pixels = gp_frame_pixels(&f);
    int colour[3] = {-1, -1, -1};
    char ending[8];
    gp_status st;
    memcpy(f.chromaticities, m->a->chromaticities, sizeof f.chromaticities);
    memcpy(f.luminance, m->a->luminance, sizeof f.luminance);
    f.path = gp_strdup(path);
    if (!f.path)
        return gp_no_memory(log, path);
    for (int i = 0; i < m->pairs; i++) {
        for (int k = 0; k < 3; k++)
            colour[k] = strcmp(gp_compare_name(m, i), name[k]) == 0 ? i
                                                                    : colour[k];
    }
    if (colour[0] < 0 && colour[1] < 0 && colour[2] < 0) { // the first is grey
        f.model = GP_COLOUR_GREY;
        colour[0] = colour[1] = colour[2] = 0;
    }
    GP_TRY(gp_planes_make(log, "difference", pixels, &f.rgb));
    for (int k = 0; k < 3; k++) {
        if (colour[k] >= 0)
            subtract(p, m, colour[k], f.rgb.c[k]);
        else
            memset(f.rgb.c[k], 0, pixels * sizeof(float));
    }
    as.type = GP_OUT_FLOAT;
    as.dither = GP_DITHER_NEVER; // equal values become equal codes
    gp_file_ending(path, ending, sizeof ending);
    if (strcmp(ending, "exr") == 0) {
        f.display = m->a->display;
        GP_TRY(make_channels(log, p, m, colour, &f));
        GP_TRY(gp_write_hdr(log, &as, path,
                            &(struct gp_hdr_colour) {&f, &f.rgb}, 1, &stats));
    } else {
        GP_TRY(gp_write_picture(log, &as, path, &f, &f.rgb, GP_PICTURE_ENCODED,
                                &stats));
    }
out:
    gp_frame_free(&f);
    return st;
}
