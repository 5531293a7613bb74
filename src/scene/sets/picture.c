// SPDX-License-Identifier: Apache-2.0
#include "core/minmax.h"
#include "scene/sets/sets.h"

#include <math.h>
#include <string.h>

/* A picture that lines are drawn into. */
struct sheet {
    int w, h;
    const struct gp_planes *rgb;
};

static void set_pixel(const struct sheet *s, int x, int y, const float *colour)
{
    if (x < 0 || y < 0 || x >= s->w || y >= s->h)
        return;
    for (int c = 0; c < 3; c++)
        s->rgb->c[c][(size_t) y * (size_t) s->w + (size_t) x] = colour[c];
}

static void draw_outline(const struct sheet *s, struct gp_rect r,
                         const float *colour)
{
    if (gp_rect_empty(r))
        return;
    for (int x = gp_max(r.x0, 0); x < gp_min(r.x1, s->w); x++) {
        set_pixel(s, x, r.y0, colour);
        set_pixel(s, x, r.y1 - 1, colour);
    }
    for (int y = gp_max(r.y0, 0); y < gp_min(r.y1, s->h); y++) {
        set_pixel(s, r.x0, y, colour);
        set_pixel(s, r.x1 - 1, y, colour);
    }
}

void gp_sets_draw_scissors(const struct gp_table *t, int lights, int w, int h,
                           const struct gp_planes *rgb)
{
    const struct sheet sheet = {w, h, rgb};
    for (size_t i = 0; i < (size_t) w * (size_t) h; i++) {
        for (int c = 0; c < 3; c++) {
            const float v = t->picture[4 * i + (size_t) c];
            rgb->c[c][i] = v / (1.0f + v); // Reinhard et al. 2002, eq. 3
        }
    }
    for (int i = 0; i < lights; i++) {
        float colour[3]; // six hues, then paler ones
        for (int c = 0; c < 3; c++)
            colour[c] = (i % 6 + 1) >> c & 1 ? 1.0f : i < 6 ? 0.0f : 0.3f;
        struct gp_rect r = t->light[i].rect;
        for (int k = 0; k < i; k++) { // equal ones one inside the other
            const struct gp_rect *const q = &t->light[k].rect;
            if (memcmp(q, &t->light[i].rect, sizeof *q) == 0)
                r = (struct gp_rect) {r.x0 + 1, r.y0 + 1, r.x1 - 1, r.y1 - 1};
        }
        draw_outline(&sheet, r, colour);
    }
}

/* Colours of objects, each over those before it. */
static const struct {
    unsigned set;
    float colour[3];
} colours[] = {
    {0, {0.03f, 0.03f, 0.03f}},        // in none
    {GP_SET_F, {0.0f, 0.05f, 0.5f}},   // in the frustum, hidden
    {GP_SET_S, {0.7f, 0.0f, 0.0f}},    // casts shadows
    {GP_SET_V, {0.0f, 0.4f, 0.05f}},   // visible
    {GP_SET_I, {0.9f, 0.7f, 0.0f}},    // visible and lit
};

// -- the map -------------------------------------------------------------------

/* Finds the part of the world that the map shows: the eye, the lamps and the
 * middles of objects, and of their boxes what is within a quarter of that
 * beside it, so that a large ground does not make all others small. */
static struct gp_box find_extent(const struct gp_scene *s, struct gp_v3 eye)
{
    struct gp_box core = {eye, eye};
    for (int i = 0; i < s->objects; i++) {
        if (!gp_box_empty(s->object[i].box))
            core = gp_box_with(core, gp_box_middle(&s->object[i].box));
    }
    for (int i = 0; i < s->lights; i++) {
        if (s->light[i].kind != GP_LIGHT_DIRECTIONAL)
            core = gp_box_with(core, s->light[i].at);
    }
    const double side = 0.25 * fmax(core.hi.x - core.lo.x,
                                    core.hi.z - core.lo.z);
    // else all is in one place with the eye
    const double more = side > 0.0 ? side : INFINITY;
    struct gp_box all = core;
    for (int i = 0; i < s->objects; i++) {
        struct gp_box b = s->object[i].box;
        b.lo.x = fmax(b.lo.x, core.lo.x - more);
        b.lo.z = fmax(b.lo.z, core.lo.z - more);
        b.hi.x = fmin(b.hi.x, core.hi.x + more);
        b.hi.z = fmin(b.hi.z, core.hi.z + more);
        if (!gp_box_empty(b))
            all = gp_box_join(all, b);
    }
    return all;
}

/* Returns a coordinate of the map as a pixel, at most one outside. */
static int pixel_of(double at, int size)
{
    return (int) floor(fmin(fmax(at, -1.0), (double) size));
}

void gp_sets_draw_map(const struct gp_table *t, const struct gp_scene *s,
                      const struct gp_camera *c, int w, int h,
                      const struct gp_planes *rgb)
{
    static const float white[3] = {1.0f, 1.0f, 1.0f}, eye_colour[3] = {0, 1, 1};
    const struct sheet sheet = {w, h, rgb};
    const struct gp_v3 eye = gp_camera_eye(c);
    const struct gp_box all = find_extent(s, eye);
    for (int i = 0; i < 3; i++)
        memset(rgb->c[i], 0, (size_t) w * (size_t) h * sizeof(float));
    // glTF's y is up: x to the right, z down
    const double wide = fmax(all.hi.x - all.lo.x, 1e-9);
    const double deep = fmax(all.hi.z - all.lo.z, 1e-9);
    const double scale = 0.96 * fmin(w / wide, h / deep);
    const double x0 = 0.5 * (w - scale * wide) - scale * all.lo.x;
    const double y0 = 0.5 * (h - scale * deep) - scale * all.lo.z;
    for (size_t k = 0; k < sizeof colours / sizeof *colours; k++) {
        for (int i = 0; i < s->objects; i++) {
            const struct gp_box *const b = &s->object[i].box;
            if (gp_box_empty(*b) ||
                (t->set[i] & colours[k].set) != colours[k].set)
                continue;
            // a box that leaves the map ends at its edge
            draw_outline(&sheet, gp_rect_meet((struct gp_rect) {0, 0, w, h},
                (struct gp_rect) {pixel_of(x0 + scale * b->lo.x, w),
                                  pixel_of(y0 + scale * b->lo.z, h),
                                  pixel_of(x0 + scale * b->hi.x, w) + 1,
                                  pixel_of(y0 + scale * b->hi.z, h) + 1}),
                colours[k].colour);
        }
    }
    for (int i = 0; i <= s->lights; i++) {
        const bool is_eye = i == s->lights;
        const struct gp_v3 p = is_eye ? eye : s->light[i].at;
        const int x = pixel_of(x0 + scale * p.x, w);
        const int y = pixel_of(y0 + scale * p.z, h);
        if (x < 0 || y < 0 || x >= w || y >= h ||
            (!is_eye && s->light[i].kind == GP_LIGHT_DIRECTIONAL))
            continue;
        for (int k = -2; k <= 2; k++) {
            set_pixel(&sheet, x + k, y, is_eye ? eye_colour : white);
            set_pixel(&sheet, x, y + k, is_eye ? eye_colour : white);
        }
    }
}
