#include "core/memory.h"
#include "core/minmax.h"
#include "scene/bounds.h"
#include "scene/sets/sets.h"

#include <math.h>
#include <stdlib.h>
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
        if (!gp_rect_empty(r))
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

/* A part of the world from above, x to the right and z down. */
struct extent {
    double lo[2], hi[2];
};

static void widen(struct extent *e, int axis, double lo, double hi)
{
    e->lo[axis] = fmin(e->lo[axis], lo);
    e->hi[axis] = fmax(e->hi[axis], hi);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

static double on_axis(struct gp_v3 p, int axis)
{
    return axis ? p.z : p.x;
}

/* Widens by the n places of an axis, but for those ten times as far from the
 * quartiles as these are apart; all of them where the quartiles are one. */
static void widen_by_most(struct extent *e, int axis, double *place, int n)
{
    qsort(place, (size_t) n, sizeof *place, compare);
    const double low = place[n / 4], high = place[n - 1 - n / 4];
    const double far = high > low ? 10.0 * (high - low) : INFINITY;
    for (int i = 0; i < n; i++) {
        if (place[i] >= low - far && place[i] <= high + far)
            widen(e, axis, place[i], place[i]);
    }
}

/* Finds the part that the map shows: the eye, the lamps and the middles of
 * objects, and of their boxes what is within a quarter of that beside it, so that
 * a large ground does not make all others small. */
static gp_status find_extent(const struct gp_log *log, const struct gp_scene *s,
                             struct gp_v3 eye, struct extent *out)
{
    double *place;
    gp_status st = gp_alloc(log, "map of sets",
                            (size_t) s->objects + (size_t) s->lights + 1,
                            sizeof *place, &place);
    if (st)
        return st;
    for (int axis = 0; axis < 2; axis++) {
        int n = 0;
        out->lo[axis] = out->hi[axis] = on_axis(eye, axis);
        for (int i = 0; i < s->objects; i++) {
            if (!gp_box_empty(s->object[i].box))
                place[n++] = on_axis(gp_box_middle(&s->object[i].box), axis);
        }
        for (int i = 0; i < s->lights; i++) {
            if (s->light[i].kind != GP_LIGHT_DIRECTIONAL)
                place[n++] = on_axis(s->light[i].at, axis);
        }
        if (n)
            widen_by_most(out, axis, place, n);
    }
    gp_free(place);
    const struct extent core = *out;
    const double more = 0.25 * fmax(core.hi[0] - core.lo[0],
                                    core.hi[1] - core.lo[1]);
    for (int i = 0; i < s->objects; i++) {
        const struct gp_box *const b = &s->object[i].box;
        double lo[2], hi[2];
        for (int k = 0; k < 2; k++) {
            lo[k] = on_axis(b->lo, k);
            hi[k] = on_axis(b->hi, k);
            if (more > 0.0) { // else all is in one place with the eye
                lo[k] = fmax(lo[k], core.lo[k] - more);
                hi[k] = fmin(hi[k], core.hi[k] + more);
            }
        }
        for (int k = 0; k < 2 && lo[0] <= hi[0] && lo[1] <= hi[1]; k++)
            widen(out, k, lo[k], hi[k]);
    }
    return GP_OK;
}

/* Returns a coordinate of the map as a pixel, at most one outside. */
static int pixel_of(double at, int size)
{
    return (int) floor(fmin(fmax(at, -1.0), (double) size));
}

gp_status gp_sets_draw_map(const struct gp_log *log, const struct gp_table *t,
                           const struct gp_scene *s, const struct gp_camera *c,
                           int w, int h, const struct gp_planes *rgb)
{
    static const float white[3] = {1.0f, 1.0f, 1.0f}, eye_colour[3] = {0, 1, 1};
    const struct sheet sheet = {w, h, rgb};
    const struct gp_v3 eye = gp_camera_eye(c);
    struct extent all;
    const gp_status st = find_extent(log, s, eye, &all);
    if (st)
        return st;
    for (int i = 0; i < 3; i++)
        memset(rgb->c[i], 0, (size_t) w * (size_t) h * sizeof(float));
    // glTF's y is up: x to the right, z down
    const double wide = fmax(all.hi[0] - all.lo[0], 1e-9);
    const double deep = fmax(all.hi[1] - all.lo[1], 1e-9);
    const double scale = 0.96 * fmin(w / wide, h / deep);
    const double x0 = 0.5 * (w - scale * wide) - scale * all.lo[0];
    const double y0 = 0.5 * (h - scale * deep) - scale * all.lo[1];
    for (size_t k = 0; k < sizeof colours / sizeof *colours; k++) {
        for (int i = 0; i < s->objects; i++) {
            const struct gp_box *const b = &s->object[i].box;
            if (gp_box_empty(*b) ||
                (t->set[i] & colours[k].set) != colours[k].set)
                continue;
            const struct gp_rect r = {
                pixel_of(x0 + scale * b->lo.x, w),
                pixel_of(y0 + scale * b->lo.z, h),
                pixel_of(x0 + scale * b->hi.x, w) + 1,
                pixel_of(y0 + scale * b->hi.z, h) + 1};
            const struct gp_rect shown =
                gp_rect_meet(r, (struct gp_rect) {0, 0, w, h});
            // a box that leaves the map ends at its edge
            if (!gp_rect_empty(shown))
                draw_outline(&sheet, shown, colours[k].colour);
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
    return GP_OK;
}
