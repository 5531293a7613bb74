#include "sun/map_state.h"

#include <float.h>
#include <math.h>

/* -- one light --------------------------------------------------------------*/

enum { K_MAX = 16 }; // samples along a texel's side

/* The nearest sum of two floats, which is how the shader gets it; 1e8 is
 * beyond every frame. */
static double two_floats(double v)
{
    v = v > 1e8 ? 1e8 : v < -1e8 ? -1e8 : v;
    const float most = (float) v;
    return (double) most + (double) (float) (v - (double) most);
}

/* The least float that is no less than the place at which surfaces end to be
 * nearer: for depths that are floats themselves, a comparison with it comes
 * out as one in double. NaN: nothing is nearer. */
static float limit_of(const struct gp_light *l)
{
    const double at = isinf(l->depth) && l->depth > 0.0
                          ? l->depth : l->depth * (1.0 - l->bias);
    if (isnan(at) || at < -3e38)
        return -GP_SUN_EMPTY;
    if (isinf(at))
        return GP_SUN_EMPTY;
    if (at > 3e38)
        return 3e38f;
    const float limit = (float) at;
    return (double) limit < at ? nextafterf(limit, FLT_MAX) : limit;
}

int gp_sun_pixel(double at, int size)
{
    at += GP_SUN_NUDGE;
    return at < 0.0 ? -1 : at >= size ? size : (int) at;
}

static void span(double at, double radius, int size, int *from, int *to)
{
    const int first = gp_sun_pixel(at - radius, size);
    const int last = gp_sun_pixel(at + radius, size);
    *from = first < 0 ? 0 : first;
    *to = last < size ? last + 1 : size;
}

struct gp_sun_spot gp_sun_spot_of(const struct gp_occluders *o, int map,
                                  const struct gp_light *l)
{
    struct gp_sun_spot s = {.limit = limit_of(l)};
    if (l->behind || !isfinite(l->x) || !isfinite(l->y) ||
        !(l->radius >= 0.0))
        return s;
    s.x = two_floats(l->x - o->frame.x0);
    s.y = two_floats(l->y - o->frame.y0);
    s.radius = two_floats(l->radius);
    const double side = ceil(2.0 * s.radius / map);
    s.k = side < 1.0 ? 1 : side > K_MAX ? K_MAX : (int) side;
    span(s.x, s.radius, gp_rect_w(o->frame), &s.box.x0, &s.box.x1);
    span(s.y, s.radius, gp_rect_h(o->frame), &s.box.y0, &s.box.y1);
    return s;
}

void gp_sun_outside_counts(enum gp_sun_outside outside, float count[2])
{
    count[0] = outside == GP_OUTSIDE_VISIBLE ? 1.0f : 0.0f;
    count[1] = outside == GP_OUTSIDE_IGNORE ? 0.0f : 1.0f;
}

/* -- all of them ------------------------------------------------------------*/

/* Texels of n pixels in a row; room for a pixel without one. */
static int texels(int n)
{
    return n / 2 + n % 2;
}

/* Boxes side by side until a row is `wide` texels; returns the height, or the
 * first one over `most`. */
static int pack_rows(struct gp_sun_spot *spot, int n, int wide, int most,
                     int *used)
{
    int x = 0, y = 0, high = 0;
    *used = 1;
    for (int i = 0; i < n && y + high <= most; i++) {
        if (gp_rect_empty(spot[i].box))
            continue;
        const int w = texels(gp_rect_w(spot[i].box));
        const int h = gp_rect_h(spot[i].box);
        if (x + w > wide) {
            y += high;
            x = high = 0;
        }
        spot[i].slot_x = 2 * x;
        spot[i].slot_y = y;
        x += w;
        high = h > high ? h : high;
        *used = x > *used ? x : *used;
    }
    return y + high > 1 ? y + high : 1;
}

/* A width that makes rows of boxes about as wide as high. */
static int pack_width(const struct gp_sun_spot *spot, int n, int most)
{
    double area = 0.0;
    int widest = 1;
    for (int i = 0; i < n; i++) {
        if (gp_rect_empty(spot[i].box))
            continue;
        const int w = texels(gp_rect_w(spot[i].box));
        area += (double) w * gp_rect_h(spot[i].box);
        widest = w > widest ? w : widest;
    }
    const double even = ceil(sqrt(area));
    const int wide = even < most ? (int) even : most;
    return wide > widest ? wide : widest;
}

static void share_frame(struct gp_sun_spot *spot, int n)
{
    for (int i = 0; i < n; i++) {
        spot[i].slot_x = spot[i].box.x0;
        spot[i].slot_y = spot[i].box.y0;
    }
}

gp_status gp_sun_pack(const struct gp_log *log, const struct gp_occluders *o,
                      struct gp_sun_spot *spot, int n, int most,
                      struct gp_sun_upload *out)
{
    enum { EXACT_IN_FLOAT = 1 << 24 };
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const int frame_w = w ? texels(w) : 1, frame_h = h ? h : 1;
    int used;
    const int high = pack_rows(spot, n, pack_width(spot, n, most), most, &used);
    const bool fits = used <= most && high <= most;
    const bool frame_fits = frame_w <= most && frame_h <= most;
    if (w > EXACT_IN_FLOAT || h > EXACT_IN_FLOAT || (!fits && !frame_fits))
        return gp_fail_bare(log, GP_ERR_GL,
                            "sun map: the pixels under %d lights in a frame "
                            "of %dx%d do not go into one texture (%dx%d "
                            "texels is the limit); use --sun-method exact",
                            n, w, h, most, most);
    const bool less = (double) frame_w * frame_h < (double) used * high;
    *out = (struct gp_sun_upload) {!fits || (less && frame_fits), used, high};
    if (out->whole) {
        share_frame(spot, n);
        out->w = frame_w;
        out->h = frame_h;
    }
    return GP_OK;
}
