/* Lights in pixels of the frame, and the texture of the pixels under them. */
#include "sun/sun_priv.h"

#include "core/parallel.h"

#include <float.h>
#include <math.h>

// -- one light ---------------------------------------------------------------

enum { K_MAX = 16 }; // samples along a texel's side

/* The nearest sum of two floats, which is how the shader gets it; 1e8 is
 * beyond every frame. */
static double two_floats(double v)
{
    v = v > 1e8 ? 1e8 : v < -1e8 ? -1e8 : v;
    const float most = (float) v;
    return (double) most + (double) (float) (v - (double) most);
}

int gp_map_pixel_at(double at, int size)
{
    at += GP_SUN_NUDGE;
    return at < 0.0 ? -1 : at >= size ? size : (int) at;
}

static void pixel_span(double at, double radius, int size, int *from, int *to)
{
    const int first = gp_map_pixel_at(at - radius, size);
    const int last = gp_map_pixel_at(at + radius, size);
    *from = first < 0 ? 0 : first;
    *to = last < size ? last + 1 : size;
}

struct gp_map_light gp_map_light_of(const struct gp_occluders *o, int map,
                                    const struct gp_light *l)
{
    // the least float that is no less than the place at which surfaces end to
    // be nearer: for depths that are floats themselves, a comparison with it
    // comes out as one in double
    const double nearer = isinf(l->depth) && l->depth > 0.0
                              ? l->depth : l->depth * (1.0 - l->bias);
    const float limit = nearer > -3e38 && nearer < 3e38 ? (float) nearer : 0.0f;
    struct gp_map_light s = {
        .limit = isnan(nearer) || nearer < -3e38 ? -GP_SUN_EMPTY // no surface
                 : isinf(nearer)          ? GP_SUN_EMPTY
                 : nearer > 3e38          ? 3e38f
                 : (double) limit < nearer ? nextafterf(limit, FLT_MAX) : limit,
    };
    if (l->behind || !isfinite(l->x) || !isfinite(l->y) || !(l->radius >= 0.0))
        return s;
    s.x = two_floats(l->x - o->frame.x0);
    s.y = two_floats(l->y - o->frame.y0);
    s.radius = two_floats(l->radius);
    const double side = ceil(2.0 * s.radius / map);
    s.k = side < 1.0 ? 1 : side > K_MAX ? K_MAX : (int) side;
    pixel_span(s.x, s.radius, gp_rect_w(o->frame), &s.box.x0, &s.box.x1);
    pixel_span(s.y, s.radius, gp_rect_h(o->frame), &s.box.y0, &s.box.y1);
    return s;
}

void gp_map_outside(enum gp_sun_outside outside, const struct gp_light *l,
                    float count[2])
{
    const bool scene = outside == GP_OUTSIDE_SCENE;
    const bool none = outside == GP_OUTSIDE_IGNORE || (l->behind && !scene);
    count[0] = scene ? (float) l->outside
               : outside == GP_OUTSIDE_VISIBLE && !none ? 1.0f
                                                        : 0.0f;
    count[1] = none ? 0.0f : 1.0f;
}

/* Texels of n pixels in a row; room for a pixel without one. */
static int texels(int n)
{
    return n / 2 + n % 2;
}

gp_status gp_map_pack(const struct gp_log *log, const struct gp_occluders *o,
    struct gp_map_light *light, int n, int most, struct gp_map_pixels *out)
{
    enum { EXACT_IN_FLOAT = 1 << 24 };
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const int frame_w = w ? texels(w) : 1, frame_h = h ? h : 1;
    double area = 0.0;
    int wide = 1; // texels: rows of boxes about as wide as high
    for (int i = 0; i < n; i++) {
        if (gp_rect_empty(light[i].box))
            continue;
        const int box = texels(gp_rect_w(light[i].box));
        area += (double) box * gp_rect_h(light[i].box);
        wide = box > wide ? box : wide;
    }
    const int even = (int) fmin(ceil(sqrt(area)), most);
    wide = even > wide ? even : wide;
    // boxes side by side until a row is `wide`; ends after `most` rows
    int x = 0, y = 0, row = 0, used = 1;
    for (int i = 0; i < n && y + row <= most; i++) {
        if (gp_rect_empty(light[i].box))
            continue;
        const int box_w = texels(gp_rect_w(light[i].box));
        const int box_h = gp_rect_h(light[i].box);
        if (x + box_w > wide) {
            y += row;
            x = row = 0;
        }
        light[i].slot_x = 2 * x;
        light[i].slot_y = y;
        x += box_w;
        row = box_h > row ? box_h : row;
        used = x > used ? x : used;
    }
    const int high = y + row > 1 ? y + row : 1;
    const bool fits = used <= most && high <= most;
    const bool frame_fits = frame_w <= most && frame_h <= most;
    if (w > EXACT_IN_FLOAT || h > EXACT_IN_FLOAT || (!fits && !frame_fits))
        return gp_fail_bare(log, GP_ERR_GL,
                            "sun map: the pixels under %d lights in a frame of "
                            "%dx%d do not fit into a texture (the limit is "
                            "%dx%d texels); use --sun-method exact", n, w, h,
                            most, most);
    const bool less = (double) frame_w * frame_h < (double) used * high;
    *out = (struct gp_map_pixels) {!fits || (less && frame_fits), used, high};
    if (!out->whole)
        return GP_OK;
    out->w = frame_w;
    out->h = frame_h;
    for (int i = 0; i < n; i++) {
        light[i].slot_x = light[i].box.x0;
        light[i].slot_y = light[i].box.y0;
    }
    return GP_OK;
}

// -- pixels under the lights -------------------------------------------------
//
// One rule for every pair of planes: a pixel is hidden by its coverage where a
// surface is nearer and where it has no surface.

/* Under so many pixels threads cost more than they save. */
enum { ALONE = 1 << 15 };

/* The samples of a plane in columns [*x0, *x1) of EXR pixel row y, which are
 * cut to its window; NULL when there are none. */
static const float *row_of(const struct gp_plane *p, int y, int *x0, int *x1)
{
    if (!p || !p->v || y < p->window.y0 || y >= p->window.y1)
        return NULL;
    *x0 = *x0 > p->window.x0 ? *x0 : p->window.x0;
    *x1 = *x1 < p->window.x1 ? *x1 : p->window.x1;
    if (*x0 >= *x1)
        return NULL;
    const size_t row = (size_t) ((long long) y - p->window.y0);
    return p->v + row * (size_t) gp_rect_w(p->window) +
           (size_t) ((long long) *x0 - p->window.x0);
}

/* The place for the rows of a box: `to` is the band's row 0. */
struct box_rows {
    const struct gp_occluders *o;
    struct gp_rect box;  // of the frame, those rows that go into the band
    float *to;
    size_t stride;       // floats
};

static void write_row(void *ctx, int i, int thread)
{
    const struct box_rows *const b = ctx;
    const struct gp_occluders *const o = b->o;
    const int y = b->box.y0 + i + o->frame.y0; // EXR pixel space
    const int x0 = b->box.x0 + o->frame.x0, x1 = b->box.x1 + o->frame.x0;
    float *const out = b->to + (size_t) i * b->stride;
    int from = x0, to = x1;
    (void) thread;
    for (int k = 0; k < x1 - x0; k++) {
        out[2 * k] = GP_SUN_EMPTY;
        out[2 * k + 1] = 0.0f;
    }
    const float *row = row_of(o->depth, y, &from, &to);
    const bool reversed = o->facts.reversed;
    const struct gp_depth_range s = gp_depth_range_of(o->type, reversed);
    // types of depth that are places already stay exact
    const bool exact = o->type == GP_DEPTH_Z || o->type == GP_DEPTH_RAY;
    const float sign = reversed ? -1.0f : 1.0f;
    float *const place = row ? out + 2 * (from - x0) : out;
    const int n = row ? to - from : 0;
    for (int k = 0; exact && k < n; k++)
        place[2 * k] = gp_is_surface(s, row[k]) ? sign * row[k] : GP_SUN_EMPTY;
    for (int k = 0; !exact && k < n; k++) {
        if (gp_is_surface(s, row[k]))
            place[2 * k] = (float) fmin(gp_depth_place(o, row[k]), 3e38);
    }
    if (!o->mask || !o->mask->v) {
        for (int k = 0; k < x1 - x0; k++)
            out[2 * k + 1] = out[2 * k] < GP_SUN_EMPTY ? 1.0f : 0.0f;
        return;
    }
    from = x0;
    to = x1;
    row = row_of(o->mask, y, &from, &to);
    for (int x = from; row && x < to; x++, row++)
        out[2 * (x - x0) + 1] = *row > 0.0f ? (*row < 1.0f ? *row : 1.0f)
                                            : 0.0f;
}

/* Writes the rows of a box that are in rows [y0, y1) of the texture, w texels
 * wide. */
static void write_box(const struct gp_occluders *o, struct gp_rect box,
    int slot_x, int slot_y, int y0, int y1, int w, float *band)
{
    const int down = slot_y - box.y0; // a row of the frame, plus this
    struct gp_rect cut = box;
    cut.y0 = y0 - down > box.y0 ? y0 - down : box.y0;
    cut.y1 = y1 - down < box.y1 ? y1 - down : box.y1;
    if (gp_rect_empty(cut))
        return;
    struct box_rows b = {
        .o = o, .box = cut, .stride = 4 * (size_t) w,
        .to = band + (size_t) (cut.y0 + down - y0) * 4 * (size_t) w +
              2 * slot_x,
    };
    const int h = gp_rect_h(cut);
    if ((long long) h * gp_rect_w(cut) >= ALONE) {
        gp_parallel_do(h, write_row, &b);
        return;
    }
    for (int i = 0; i < h; i++)
        write_row(&b, i, 0);
}

gp_status gp_map_write_pixels(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_occluders *o, const struct gp_map_pixels *pixels,
    struct gp_sun_map *s, int n)
{
    const struct gp_rect frame = {0, 0, gp_rect_w(o->frame),
                                  gp_rect_h(o->frame)};
    const int w = pixels->w, h = pixels->h, rows = GP_SUN_BAND / w;
    gp_status st = GP_OK;
    if (s->pixels.w < w || s->pixels.h < h) {
        gp_texture_free(gl, &s->pixels);
        st = gp_texture_make(log, gl, "pixels under the lights", GP_TEXEL_FLOAT,
                             w, h, &s->pixels);
    }
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        const int y1 = h - y0 > rows ? y0 + rows : h;
        if (pixels->whole)
            write_box(o, frame, 0, 0, y0, y1, w, s->band);
        for (int i = 0; !pixels->whole && i < n; i++)
            write_box(o, s->light[i].box, s->light[i].slot_x,
                      s->light[i].slot_y, y0, y1, w, s->band);
        gp_texture_write(gl, &s->pixels, (struct gp_rect) {0, y0, w, y1},
                         s->band);
    }
    return st;
}
