/* The part of the picture that a light can change: bounds on the screen, the
 * frame's depth by tiles, and the scissor (O'Rorke 15.5). */
#include "scene/sets/sets_priv.h"

#include "core/depth.h"
#include "core/memory.h"
#include "core/minmax.h"

// -- bounds on the screen -----------------------------------------------------

/* Bounds of points before the division: x and y in units of the display window,
 * and w. */
struct bounds {
    double lo[3], hi[3];
};

static void widen(struct bounds *b, const double p[3])
{
    const double at[3] = {p[0] / p[2], p[1] / p[2], p[2]};
    for (int c = 0; c < 3; c++) {
        b->lo[c] = gp_mind(at[c], b->lo[c]);
        b->hi[c] = gp_maxd(at[c], b->hi[c]);
    }
}

/* Returns a whole number as an int, cut to what fits with room for a picture. */
static int whole(double v)
{
    return (int) fmin(fmax(v, -1e9), 1e9);
}

struct gp_scissor gp_box_project(const struct gp_sets_view *v,
                                 const struct gp_box *box)
{
    const double *const m = v->camera.to_ndc;
    const struct gp_rect d = v->display;
    const double w = gp_rect_w(d), h = gp_rect_h(d);
    struct bounds b = {{INFINITY, INFINITY, INFINITY},
                       {-INFINITY, -INFINITY, -INFINITY}};
    double at[8][3];
    for (int i = 0; i < 8; i++) {
        const struct gp_v3 p = gp_box_corner(box, i);
        for (int c = 0; c < 3; c++) { // z has no part in it
            const int k = c < 2 ? c : 3;
            at[i][c] = p.x * m[k] + p.y * m[4 + k] + p.z * m[8 + k] + m[12 + k];
        }
        if (at[i][2] >= v->near)
            widen(&b, at[i]);
    }
    // where an edge meets the plane at `near`, from corner i to i with bit k
    for (int e = 0; e < 24; e++) {
        const int i = e % 8, k = 1 << e / 8;
        const double *const p = at[i], *const q = at[i | k];
        if (i & k || (p[2] < v->near) == (q[2] < v->near))
            continue;
        const double t = (v->near - p[2]) / (q[2] - p[2]);
        widen(&b, (const double[3]) {p[0] + t * (q[0] - p[0]),
                                     p[1] + t * (q[1] - p[1]), v->near});
    }
    if (!(b.lo[2] <= b.hi[2]))
        return (struct gp_scissor) {0};
    return (struct gp_scissor) {
        gp_rect_meet(v->window, (struct gp_rect) {
            whole(floor(d.x0 + b.lo[0] * w)), whole(floor(d.y0 + b.lo[1] * h)),
            whole(ceil(d.x0 + b.hi[0] * w)), whole(ceil(d.y0 + b.hi[1] * h))}),
        b.lo[2], b.hi[2],
    };
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

bool gp_depths_hide(const struct gp_depths *d, const struct gp_scissor *b)
{
    const double near = b->near * (1.0 - GP_DEPTH_SLACK);
    if (gp_rect_empty(b->rect))
        return true;
    const struct gp_rect all = tiles_of(d, b->rect);
    for (int y = all.y0; y < all.y1; y++) {
        for (int x = all.x0; x < all.x1; x++) {
            if (!(near > (double) d->tile[y * d->across + x].most) &&
                !all_before(d, gp_rect_meet(b->rect, pixels_of(d, x, y)), near))
                return false;
        }
    }
    return true;
}

// -- scissors -----------------------------------------------------------------

static struct gp_scissor widened(struct gp_scissor s)
{
    s.near *= 1.0 - GP_DEPTH_SLACK;
    s.far *= 1.0 + GP_DEPTH_SLACK;
    return s;
}

struct gp_scissor gp_depths_cut(const struct gp_depths *d,
                                const struct gp_scissor *of)
{
    const struct gp_scissor s = widened(*of);
    float least = INFINITY, most = -INFINITY;
    struct gp_rect pixels = {0};
    if (gp_rect_empty(s.rect))
        return (struct gp_scissor) {0};
    if (d->across == 0)
        return s;
    const struct gp_rect all = tiles_of(d, s.rect);
    for (int y = all.y0; y < all.y1; y++) {
        for (int x = all.x0; x < all.x1; x++) {
            const struct gp_depth_tile *const t = &d->tile[y * d->across + x];
            if (!((double) t->least <= s.far && (double) t->deepest >= s.near))
                continue;
            const struct gp_rect own = gp_rect_meet(s.rect, pixels_of(d, x, y));
            pixels = gp_rect_empty(pixels) ? own : gp_rect_join(pixels, own);
            least = gp_minf(t->least, least);
            most = gp_maxf(t->deepest, most);
        }
    }
    if (gp_rect_empty(pixels))
        return (struct gp_scissor) {0};
    return (struct gp_scissor) {pixels, fmax((double) least, s.near),
                                fmin((double) most, s.far)};
}

struct gp_scissor gp_scissor_join(const struct gp_scissor *box,
                                  const int *index, int n,
                                  const struct gp_scissor *light)
{
    const struct gp_scissor l = widened(*light);
    struct gp_scissor all = {0};
    for (int i = 0; i < n; i++) {
        const struct gp_scissor *const b = &box[index[i]];
        const struct gp_scissor both = {gp_rect_meet(b->rect, l.rect),
                                        fmax(b->near, l.near),
                                        fmin(b->far, l.far)};
        if (gp_rect_empty(both.rect) || both.near > both.far)
            continue;
        all = gp_rect_empty(all.rect)
                  ? both
                  : (struct gp_scissor) {gp_rect_join(all.rect, both.rect),
                                         fmin(all.near, both.near),
                                         fmax(all.far, both.far)};
    }
    return all;
}
