/* The part of the picture that a light can change: bounds on the screen, the
 * frame's depth by tiles, and the scissor (O'Rorke 15.5). */
#include "scene/sets/sets_priv.h"

#include "core/depth.h"
#include "core/memory.h"
#include "core/minmax.h"

// -- bounds on the screen -----------------------------------------------------

/* A point before the division: x and y in units of the display window. */
struct image {
    double x, y, w;
};

static struct image image_of(const double m[16], struct gp_v3 p)
{
    return (struct image) {
        p.x * m[0] + p.y * m[4] + p.z * m[8] + m[12],
        p.x * m[1] + p.y * m[5] + p.z * m[9] + m[13],
        p.x * m[3] + p.y * m[7] + p.z * m[11] + m[15],
    };
}

static struct gp_screen_box with_image(struct gp_screen_box b, struct image p)
{
    const double x = p.x / p.w, y = p.y / p.w;
    return (struct gp_screen_box) {
        gp_mind(x, b.x0),     gp_mind(y, b.y0),
        gp_maxd(x, b.x1),     gp_maxd(y, b.y1),
        gp_mind(p.w, b.near), gp_maxd(p.w, b.far), true,
    };
}

static struct gp_screen_box to_pixels(struct gp_screen_box b,
                                      struct gp_rect display)
{
    if (!b.seen)
        return (struct gp_screen_box) {0};
    const double w = (double) display.x1 - display.x0,
                 h = (double) display.y1 - display.y0;
    b.x0 = display.x0 + b.x0 * w;
    b.x1 = display.x0 + b.x1 * w;
    b.y0 = display.y0 + b.y0 * h;
    b.y1 = display.y0 + b.y1 * h;
    return b;
}

static const struct gp_screen_box nothing = {
    INFINITY, INFINITY, -INFINITY, -INFINITY, INFINITY, -INFINITY, false,
};

struct gp_screen_box gp_bounds_project(const struct gp_camera *c,
                                       struct gp_rect display,
                                       const struct gp_box *box, double near)
{
    struct gp_screen_box b = nothing;
    struct image at[8];
    if (gp_box_empty(*box))
        return to_pixels(b, display);
    for (int i = 0; i < 8; i++) {
        at[i] = image_of(c->to_ndc, gp_box_corner(box, i));
        if (at[i].w >= near)
            b = with_image(b, at[i]);
    }
    // where an edge meets the plane at `near`, from corner i to i with bit k
    for (int e = 0; e < 24; e++) {
        const int i = e % 8, k = 1 << e / 8;
        const struct image p = at[i], q = at[i | k];
        if (i & k || (p.w < near) == (q.w < near))
            continue;
        const double t = (near - p.w) / (q.w - p.w);
        b = with_image(b, (struct image) {p.x + t * (q.x - p.x),
                                          p.y + t * (q.y - p.y), near});
    }
    return to_pixels(b, display);
}

struct gp_screen_box gp_reach_project(const struct gp_reach *r,
                                      const struct gp_camera *c,
                                      struct gp_rect display, double near)
{
    static const double wide = 1e9;
    if (!isfinite(r->range)) // also of spots: bounds of what they light do
        return (struct gp_screen_box) {-wide, -wide, wide, wide, near,
                                       INFINITY, true};
    return gp_bounds_project(c, display, &r->box, near);
}

/* Returns a whole number as an int, cut to what fits with room for a picture. */
static int whole(double v)
{
    return (int) fmin(fmax(v, -1e9), 1e9);
}

struct gp_rect gp_screen_pixels(const struct gp_screen_box *b,
                                struct gp_rect window)
{
    if (!b->seen)
        return (struct gp_rect) {0};
    return gp_rect_meet(window, (struct gp_rect) {
        whole(floor(b->x0)), whole(floor(b->y0)), whole(ceil(b->x1)),
        whole(ceil(b->y1))});
}

// -- depths by tiles ----------------------------------------------------------

gp_status gp_depths_make(const struct gp_log *log, struct gp_rect window,
                         const float *depth, struct gp_depths *out)
{
    static const char what[] = "depths of the scene";
    const int w = gp_rect_w(window), h = gp_rect_h(window);
    struct gp_depths d = {
        .window = window, .across = (w + GP_TILE - 1) / GP_TILE,
        .down = (h + GP_TILE - 1) / GP_TILE,
    };
    const size_t tiles = (size_t) d.across * (size_t) d.down;
    gp_status st;
    GP_TRY(gp_alloc(log, what, (size_t) w * (size_t) h, sizeof *d.pixel,
                    &d.pixel));
    GP_TRY(gp_alloc(log, what, tiles, sizeof *d.tile, &d.tile));
    for (size_t i = 0; i < tiles; i++)
        d.tile[i] = (struct gp_depth_tile) {.least = INFINITY};
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            const size_t i = (size_t) y * (size_t) w + (size_t) x;
            struct gp_depth_tile *const t =
                &d.tile[y / GP_TILE * d.across + x / GP_TILE];
            const bool surface = depth[i] > 0.0f && depth[i] < GP_DEPTH_HUGE;
            d.pixel[i] = surface ? depth[i] : INFINITY;
            t->least = gp_minf(d.pixel[i], t->least);
            t->most = gp_maxf(d.pixel[i], t->most);
            t->deepest = gp_maxf(surface ? depth[i] : 0.0f, t->deepest);
        }
    }
out:
    if (st)
        gp_depths_free(&d);
    *out = d;
    return st;
}

void gp_depths_free(struct gp_depths *d)
{
    gp_free(d->pixel);
    gp_free(d->tile);
    *d = (struct gp_depths) {0};
}

double gp_depths_deepest(const struct gp_depths *d)
{
    double deepest = 0.0;
    for (int i = 0; i < d->across * d->down; i++)
        deepest = fmax(deepest, (double) d->tile[i].deepest);
    return deepest * (1.0 + GP_DEPTH_SLACK);
}

/* The tiles that pixels are in. */
static struct gp_rect tiles_of(const struct gp_depths *d, struct gp_rect r)
{
    const struct gp_rect w = d->window;
    return (struct gp_rect) {
        (r.x0 - w.x0) / GP_TILE, (r.y0 - w.y0) / GP_TILE,
        (r.x1 - 1 - w.x0) / GP_TILE + 1, (r.y1 - 1 - w.y0) / GP_TILE + 1};
}

/* The pixels of a tile. */
static struct gp_rect pixels_of(const struct gp_depths *d, int x, int y)
{
    const struct gp_rect w = d->window;
    return (struct gp_rect) {
        w.x0 + x * GP_TILE, w.y0 + y * GP_TILE, w.x0 + (x + 1) * GP_TILE,
        w.y0 + (y + 1) * GP_TILE};
}

/* True where all of some pixels are before `near`. */
static bool all_before(const struct gp_depths *d, struct gp_rect r, double near)
{
    const struct gp_rect w = d->window;
    for (int y = r.y0; y < r.y1; y++) {
        const float *const row =
            d->pixel + (size_t) (y - w.y0) * (size_t) gp_rect_w(w);
        for (int x = r.x0; x < r.x1; x++) {
            if (!(near > (double) row[x - w.x0]))
                return false;
        }
    }
    return true;
}

bool gp_depths_hide(const struct gp_depths *d, const struct gp_screen_box *b)
{
    const struct gp_rect r = gp_screen_pixels(b, d->window);
    const double near = b->near * (1.0 - GP_DEPTH_SLACK);
    if (gp_rect_empty(r))
        return true;
    const struct gp_rect all = tiles_of(d, r);
    for (int y = all.y0; y < all.y1; y++) {
        for (int x = all.x0; x < all.x1; x++) {
            if (!(near > (double) d->tile[y * d->across + x].most) &&
                !all_before(d, gp_rect_meet(r, pixels_of(d, x, y)), near))
                return false;
        }
    }
    return true;
}

// -- scissors -----------------------------------------------------------------

static struct gp_screen_box widened(struct gp_screen_box b)
{
    b.near *= 1.0 - GP_DEPTH_SLACK;
    b.far *= 1.0 + GP_DEPTH_SLACK;
    return b;
}

/* Returns what two bounds have in common. */
static struct gp_screen_box meet(const struct gp_screen_box *a,
                                 const struct gp_screen_box *b)
{
    return (struct gp_screen_box) {
        fmax(a->x0, b->x0), fmax(a->y0, b->y0), fmin(a->x1, b->x1),
        fmin(a->y1, b->y1), fmax(a->near, b->near), fmin(a->far, b->far),
        a->seen && b->seen,
    };
}

/* Returns the bounds of the tiles of r that have depths from near to far. */
static struct gp_scissor of_tiles(const struct gp_depths *d, struct gp_rect r,
                                  double near, double far)
{
    float least = INFINITY, most = -INFINITY;
    struct gp_rect pixels = {0};
    if (gp_rect_empty(r))
        return (struct gp_scissor) {0};
    const struct gp_rect all = tiles_of(d, r);
    for (int y = all.y0; y < all.y1; y++) {
        for (int x = all.x0; x < all.x1; x++) {
            const struct gp_depth_tile *const t = &d->tile[y * d->across + x];
            if (!((double) t->least <= far && (double) t->deepest >= near))
                continue;
            const struct gp_rect own = gp_rect_meet(r, pixels_of(d, x, y));
            pixels = gp_rect_empty(pixels) ? own : gp_rect_join(pixels, own);
            least = gp_minf(t->least, least);
            most = gp_maxf(t->deepest, most);
        }
    }
    if (gp_rect_empty(pixels))
        return (struct gp_scissor) {0};
    return (struct gp_scissor) {pixels, fmax((double) least, near),
                                fmin((double) most, far)};
}

struct gp_screen_box gp_scissor_visible(const struct gp_depths *d,
                                        const struct gp_screen_box *box)
{
    const struct gp_screen_box b = widened(*box);
    if (d->across == 0 || !b.seen)
        return *box;
    const struct gp_scissor s =
        of_tiles(d, gp_screen_pixels(&b, d->window), b.near, b.far);
    if (gp_rect_empty(s.rect))
        return (struct gp_screen_box) {0};
    return (struct gp_screen_box) {
        fmax(b.x0, s.rect.x0), fmax(b.y0, s.rect.y0), fmin(b.x1, s.rect.x1),
        fmin(b.y1, s.rect.y1), s.near, s.far, true,
    };
}

struct gp_scissor gp_scissor_make(const struct gp_depths *d,
                                  const struct gp_screen_box *box,
                                  const int *index, int n,
                                  const struct gp_screen_box *light)
{
    struct gp_screen_box all = nothing;
    const struct gp_screen_box l = widened(*light);
    for (int i = 0; l.seen && i < n; i++) {
        const struct gp_screen_box b = meet(&box[index[i]], &l);
        if (!b.seen || b.x0 > b.x1 || b.y0 > b.y1 || b.near > b.far)
            continue;
        all = (struct gp_screen_box) {
            fmin(all.x0, b.x0), fmin(all.y0, b.y0), fmax(all.x1, b.x1),
            fmax(all.y1, b.y1), fmin(all.near, b.near), fmax(all.far, b.far),
            true,
        };
    }
    if (!all.seen)
        return (struct gp_scissor) {0};
    const struct gp_screen_box b = widened(all);
    if (d->across > 0)
        return of_tiles(d, gp_screen_pixels(&b, d->window), b.near, b.far);
    const struct gp_scissor s = {gp_screen_pixels(&b, d->window), b.near,
                                 b.far};
    if (gp_rect_empty(s.rect))
        return (struct gp_scissor) {0};
    return s;
}
