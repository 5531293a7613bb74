/* What sun_map.frag reads of a pixel is made so that one rule does for every
 * pair of planes: hidden is the coverage, where a surface is nearer or where
 * there is none. */
#include "sun/map_state.h"

#include "core/parallel.h"
#include "sun/surfaces.h"

/* Pixels under which threads cost more than they save. */
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

/* gp_depth_place() of n samples to every other float of `out`. Types of depth
 * that are places already stay exact. */
static void put_places(const struct gp_occluders *o, const float *v, int n,
                       float *out)
{
    const bool turned = o->facts.reversed;
    const struct gp_surfaces s = gp_surfaces_of(o->type, turned);
    const float sign = turned ? -1.0f : 1.0f;
    if (o->type == GP_DEPTH_Z || o->type == GP_DEPTH_RAY) {
        for (int i = 0; i < n; i++)
            out[2 * i] = gp_is_surface(s, v[i]) ? sign * v[i] : GP_SUN_EMPTY;
        return;
    }
    for (int i = 0; i < n; i++) {
        if (!gp_is_surface(s, v[i]))
            continue;
        const double place = gp_depth_place(o, v[i]);
        out[2 * i] = place < 3e38 ? (float) place : 3e38f;
    }
}

static void put_mask(const float *m, int n, float *out)
{
    for (int i = 0; i < n; i++)
        out[2 * i] = m[i] > 0.0f ? (m[i] < 1.0f ? m[i] : 1.0f) : 0.0f;
}

/* Columns [x0, x1) of row y, EXR pixel space. */
static void put_row(const struct gp_occluders *o, int y, int x0, int x1,
                    float *out)
{
    int from = x0, to = x1;
    for (int i = 0; i < x1 - x0; i++) {
        out[2 * i] = GP_SUN_EMPTY;
        out[2 * i + 1] = 0.0f;
    }
    const float *row = row_of(o->depth, y, &from, &to);
    if (row)
        put_places(o, row, to - from, out + 2 * (from - x0));
    if (!o->mask || !o->mask->v) {
        for (int i = 0; i < x1 - x0; i++)
            out[2 * i + 1] = out[2 * i] < GP_SUN_EMPTY ? 1.0f : 0.0f;
        return;
    }
    from = x0;
    to = x1;
    row = row_of(o->mask, y, &from, &to);
    if (row)
        put_mask(row, to - from, out + 2 * (from - x0) + 1);
}

/* Where the rows of a box go: `to` is the band's row 0. */
struct fill {
    const struct gp_occluders *o;
    struct gp_rect box;  // of the frame, those rows that go into the band
    float *to;
    size_t stride;       // floats
};

static void fill_row(void *ctx, int i, int thread)
{
    const struct fill *const f = ctx;
    const struct gp_rect frame = f->o->frame;
    (void) thread;
    put_row(f->o, f->box.y0 + i + frame.y0, f->box.x0 + frame.x0,
            f->box.x1 + frame.x0, f->to + (size_t) i * f->stride);
}

/* The rows of a box that lie in rows [y0, y1) of what is uploaded. */
static void fill_box(const struct gp_occluders *o, struct gp_rect box,
                     int slot_x, int slot_y, int y0, int y1, int w,
                     float *band)
{
    const int down = slot_y - box.y0; // a row of the frame, plus this
    struct gp_rect part = box;
    part.y0 = y0 - down > box.y0 ? y0 - down : box.y0;
    part.y1 = y1 - down < box.y1 ? y1 - down : box.y1;
    if (gp_rect_empty(part))
        return;
    struct fill f = {
        .o = o, .box = part, .stride = 4 * (size_t) w,
        .to = band + (size_t) (part.y0 + down - y0) * 4 * (size_t) w +
              2 * slot_x,
    };
    const int h = gp_rect_h(part);
    if ((long long) h * gp_rect_w(part) >= ALONE) {
        gp_parallel_do(h, fill_row, &f);
        return;
    }
    for (int i = 0; i < h; i++)
        fill_row(&f, i, 0);
}

static gp_status fit_pixels(const struct gp_log *log, const struct gp_gl *gl,
                            const struct gp_sun_upload *u,
                            struct gp_sun_map *s)
{
    if (s->pixels.w >= u->w && s->pixels.h >= u->h)
        return GP_OK;
    gp_texture_free(gl, &s->pixels);
    return gp_texture_make(log, gl, "pixels under the lights", u->w, u->h,
                           &s->pixels);
}

gp_status gp_sun_upload(const struct gp_log *log, const struct gp_gl *gl,
                        const struct gp_occluders *o,
                        const struct gp_sun_upload *u, struct gp_sun_map *s,
                        int n)
{
    const struct gp_rect frame = {0, 0, gp_rect_w(o->frame),
                                  gp_rect_h(o->frame)};
    const int rows = GP_SUN_BAND / u->w;
    gp_status st = fit_pixels(log, gl, u, s);
    for (int y0 = 0; !st && y0 < u->h; y0 += rows) {
        const int y1 = u->h - y0 > rows ? y0 + rows : u->h;
        if (u->whole)
            fill_box(o, frame, 0, 0, y0, y1, u->w, s->band);
        for (int i = 0; !u->whole && i < n; i++)
            fill_box(o, s->spot[i].box, s->spot[i].slot_x, s->spot[i].slot_y,
                     y0, y1, u->w, s->band);
        gp_texture_write(gl, &s->pixels, (struct gp_rect) {0, y0, u->w, y1},
                         s->band);
    }
    return st;
}
