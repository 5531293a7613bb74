// SPDX-License-Identifier: Apache-2.0
/* Flare elements: their images; placed, changed and measured for the lights of a
 * frame, and added to a layer. */
#include "sun/flare_priv.h"

#include "core/colour.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <fnmatch.h>
#include <math.h>
#include <string.h>

/* Elements up to so many pixels across are summed, not integrated: the sum over
 * pixels of a small shape depends on its place. Above, the two differ by
 * less than 1e-3. */
enum { SUMMED = 128 };

// -- images at half size ------------------------------------------------------

/* Texture of an image at half size, `level` times. */
struct level {
    struct gp_flare_image image; // rgb owned when level > 0, else borrowed
    int level;
    double sum[3], luminance;    // of the whole image, level 0; 0 when not
                                 // finite or not over 0: draws nothing
};

/* Each texel is the mean of four; those outside are 0. The picture keeps its
 * corner, so a place u in texels is u / 2. */
static gp_status halve(const struct gp_log *log,
    const struct gp_flare_image *in, struct gp_flare_image *out)
{
    const int w = (in->w + 1) / 2, h = (in->h + 1) / 2;
    *out = (struct gp_flare_image) {.w = w, .h = h, .cx = in->cx / 2.0,
                                    .cy = in->cy / 2.0};
    const gp_status st = gp_planes_make(log, "a flare image at half size",
                                        (size_t) w * (size_t) h, &out->rgb);
    for (int c = 0; !st && c < 3; c++) {
        float *to = out->rgb.c[c];
        for (int y = 0; y < h; y++) {
            for (int x = 0; x < w; x++) {
                float sum = 0.0f;
                for (int k = 0; k < 4; k++)
                    sum += gp_planes_at(&in->rgb, c, in->w, in->h,
                                        2 * x + k % 2, 2 * y + k / 2);
                *to++ = 0.25f * sum;
            }
        }
    }
    return st;
}

/* Makes the level at which `size` of the longer side in pixels is not under a
 * pixel a texel, with its sums. */
static gp_status make_level(const struct gp_log *log,
    const struct gp_flare_image *image, double size, struct level *out)
{
    const size_t n = (size_t) image->w * (size_t) image->h;
    double longer = image->w > image->h ? image->w : image->h;
    struct level l = {.image = *image};
    gp_status st = GP_OK;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            l.sum[c] += (double) image->rgb.c[c][i];
        l.luminance += l.sum[c] * (double) gp_rec709_luminance[c];
    }
    if (!(l.luminance > 0.0) || !isfinite(l.luminance))
        l.luminance = 0.0;
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

// -- changes of elements by lights -------------------------------------------

/* Distance from the centre, 1 in a corner. */
static double off_centre(double x, double y, struct gp_rect display)
{
    const double half = 0.5 * gp_hypot(gp_rect_w(display), gp_rect_h(display));
    return half > 0.0 ? gp_hypot(x - gp_rect_middle(display, 0),
                                 y - gp_rect_middle(display, 1)) /
                            half
                      : 0.0;
}

void gp_flare_factors(const struct gp_flare_by_place *b, double x, double y,
                      struct gp_rect display, double *size, double colour[3])
{
    const double inside = fmin(fmin(x - display.x0, display.x1 - x),
                               fmin(y - display.y0, display.y1 - y));
    const double v = b->edge ? 2.0 * inside / fmax(gp_rect_h(display), 1.0)
                             : off_centre(x, y, display);
    const double t = fmax(0.0, fmin(v, 1.0)); // 0 for NaN
    *size = b->size[0] + t * (b->size[1] - b->size[0]);
    for (int c = 0; c < 3; c++)
        colour[c] = b->colour[0][c] + t * (b->colour[1][c] - b->colour[0][c]);
}

double gp_flare_flicker(const struct gp_flare_element *e, int frame)
{
    return e->flicker > 0.0
               ? 1.0 - e->flicker * gp_flare_random(e->seed + 1, frame) : 1.0;
}

/* The element as a light sees it: its size, colour and rotation. */
static struct gp_flare_element dress(const struct gp_flare *f, int k,
    const struct gp_light *l, struct gp_rect display)
{
    struct gp_flare_element e = f->element[k];
    const double bright = gp_flare_flicker(&e, f->frame);
    const double cx = gp_rect_middle(display, 0),
                 cy = gp_rect_middle(display, 1);
    if (e.by_place.given) {
        double size, colour[3];
        gp_flare_factors(&e.by_place, l->x, l->y, display, &size, colour);
        e.size *= size;
        for (int c = 0; c < 3; c++)
            e.colour[c] *= (float) colour[c];
    }
    if (e.shrink > 0.0)
        e.size *= 1.0 - e.shrink * (1.0 - fmin(l->visibility, 1.0));
    for (int c = 0; c < 3; c++)
        e.colour[c] *= (float) bright;
    if (e.axis && (l->x != cx || l->y != cy))
        e.rotation += gp_atan2(l->y - cy, cx - l->x) * 180.0 / M_PI;
    return e;
}

static void place_of(const struct gp_flare_element *e, const struct gp_light *l,
                     struct gp_rect display, double *x, double *y)
{
    const double dx = gp_rect_middle(display, 0) - l->x;
    const double dy = gp_rect_middle(display, 1) - l->y;
    const double d = gp_hypot(dx, dy);
    const double across = d > 0.0 ? e->offset * gp_rect_h(display) / d : 0.0;
    *x = l->x + e->at * dx + across * dy;
    *y = l->y + e->at * dy - across * dx;
}

// -- reach -------------------------------------------------------------------

static bool is_image(const struct gp_flare_element *e)
{
    return e->shape == GP_FLARE_IMAGE;
}

static double least_scale(const struct gp_flare_element *e)
{
    return (double) fminf(e->scale[0], fminf(e->scale[1], e->scale[2]));
}

static double diameter_of(const struct gp_flare_element *e,
                          struct gp_rect display)
{
    return e->size * gp_rect_h(display);
}

/* Pixels of an image's texel; 1 for a plain one. */
static double texel_size(const struct gp_flare_element *e, double diameter)
{
    const int longer = e->image.w > e->image.h ? e->image.w : e->image.h;
    return e->plain ? 1.0 : fmax(diameter, 1.0) / (double) longer;
}

struct box {
    double x0, y0, x1, y1;
};

/* Around the place of an image, for the channel of the largest scale. */
static struct box box_of(const struct gp_flare_element *e, double diameter)
{
    const double largest =
        (double) fmaxf(e->scale[0], fmaxf(e->scale[1], e->scale[2]));
    const double angle = e->plain ? 0.0 : e->rotation * M_PI / 180.0;
    // half a texel of the level, which may be as much as two pixels, beyond the
    // corners; whole pixels cover that of a plain one
    const double texel = texel_size(e, diameter * largest);
    const double more = e->plain ? 0.0
                                 : 0.5 + largest / least_scale(e) * 2.0 / texel;
    const double u[2] = {-more - e->image.cx, e->image.w + more - e->image.cx};
    const double v[2] = {-more - e->image.cy, e->image.h + more - e->image.cy};
    const double c = gp_cos(angle), s = gp_sin(angle);
    struct box b = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 4; i++) {
        const double x = u[i & 1] * c + v[i >> 1] * s;
        const double y = v[i >> 1] * c - u[i & 1] * s;
        b = (struct box) {fmin(b.x0, x * texel), fmin(b.y0, y * texel),
                          fmax(b.x1, x * texel), fmax(b.y1, y * texel)};
    }
    return b;
}

static int to_pixel(double v)
{
    enum { FAR = 1 << 29 }; // no window goes beyond
    return gp_clamp_whole(v, -FAR, FAR);
}

struct gp_rect gp_flare_reach(const struct gp_flare_element *e,
                              const struct gp_light *l, struct gp_rect display)
{
    const bool none = e->path && (e->image.w < 1 || e->image.h < 1);
    double x, y;
    place_of(e, l, display, &x, &y);
    if (l->behind || none || !isfinite(x) || !isfinite(y))
        return (struct gp_rect) {0};
    struct box b;
    if (is_image(e)) {
        b = box_of(e, diameter_of(e, display));
    } else {
        const double r = gp_flare_look_reach(e, diameter_of(e, display));
        b = (struct box) {-r, -r, r, r};
        if (e->shape == GP_FLARE_STREAK && e->count == 1) { // a narrow box
            const double angle = e->rotation * M_PI / 180.0;
            const double wide = fmax(0.5 * diameter_of(e, display), 1.5) *
                                    e->width * (1.0 + e->softness) + 4.0;
            const double c = fabs(gp_cos(angle)), s = fabs(gp_sin(angle));
            const double w = r * c + wide * s, h = r * s + wide * c;
            b = (struct box) {-w, -h, w, h};
        }
    }
    return (struct gp_rect) {
        to_pixel(floor(x + b.x0)), to_pixel(floor(y + b.y0)),
        to_pixel(ceil(x + b.x1)), to_pixel(ceil(y + b.y1)),
    };
}

// -- quads -------------------------------------------------------------------

/* One element of one light, as that light sees it. */
struct pair {
    struct gp_flare_element e;
    const struct gp_light *light;
    const struct level *level; // of an image, else NULL
    struct gp_rect whole, rect, display; // rect: what is in the frame of it
    double diameter;
};

/* The part of an element that is the same for all lights. */
struct shared {
    struct gp_flare_look look;   // for the last one's diameter
    struct level level;
};

/* Finds element k as a light sees it. Returns false where it shows nothing. */
static bool find_pair(const struct gp_flare *f, int k, const struct gp_light *l,
    struct gp_rect frame, struct gp_rect display, struct pair *p)
{
    *p = (struct pair) {.e = dress(f, k, l, display), .light = l,
                        .display = display};
    p->whole = gp_flare_reach(&p->e, l, display);
    p->rect = gp_rect_meet(p->whole, frame);
    p->diameter = diameter_of(&p->e, display);
    return gp_light_has_flux(l) && l->visibility > 0.0 &&
           p->e.source == GP_FLARE_LIGHTS &&
           !(p->e.only && fnmatch(p->e.only, l->name, 0) != 0) &&
           !gp_rect_empty(p->rect);
}

static void place_quad(struct gp_flare_quad *q, struct gp_rect rect)
{
    q->rect = rect;
    q->base[0] = (float) ((double) rect.x0 + 0.5 - q->x);
    q->base[1] = (float) ((double) rect.y0 + 0.5 - q->y);
    if (!q->plain)
        return;
    const double corner[2] = {rect.x0 - q->x + q->image->cx,
                              rect.y0 - q->y + q->image->cy};
    for (int k = 0; k < 2; k++) {
        q->corner[k] = (int) floor(corner[k]);
        q->fraction[k] = (float) (corner[k] - floor(corner[k]));
    }
}

/* Finds the sums over all pixels of channels drawn with an amount of 1. */
static void sum_of(const struct gp_flare_quad *quad, struct gp_rect whole,
                   double sum[3])
{
    static const float one[3] = {1.0f, 1.0f, 1.0f};
    struct gp_flare_quad q = *quad;
    q.cut[0] = q.cut[1] = 0.0f; // takes its light away
    place_quad(&q, whole);
    memset(sum, 0, 3 * sizeof *sum);
    for (int y = whole.y0; y < whole.y1; y++) {
        float row[3][4 * SUMMED] = {{0}};
        float *const to[3] = {row[0], row[1], row[2]};
        gp_flare_add_row(&q, y, one, to);
        for (int c = 0; c < 3; c++) {
            for (int x = 0; x < gp_rect_w(whole); x++)
                sum[c] += (double) row[c][x];
        }
    }
}

static bool is_summed(const struct pair *p, double scale)
{
    return p->diameter * scale <= SUMMED && gp_rect_w(p->whole) <= 4 * SUMMED &&
        gp_rect_h(p->whole) <= 4 * SUMMED;
}

static double light_of(const struct pair *p, int c)
{
    return (double) p->e.colour[c] * (double) p->light->flux[c];
}

/* Sets the amounts of an image. */
static void fit_image(const struct pair *p, struct gp_flare_quad *q)
{
    const struct level *const l = p->level;
    double of_level[3], sums[3] = {0}; // pixels of its texel
    q->inner[0] = (float) l->image.cx;
    q->inner[1] = (float) l->image.cy;
    for (int c = 0; c < 3; c++) {
        of_level[c] = ldexp(texel_size(&p->e, p->diameter *
                                                  (double) p->e.scale[c]),
                            l->level);
        q->radius[c] = (float) (1.0 / of_level[c]);
    }
    if (is_summed(p, least_scale(&p->e)))
        sum_of(q, p->whole, sums);
    for (int c = 0; c < 3; c++) {
        const double even = ldexp(l->sum[c], -2 * l->level) * of_level[c] *
                            of_level[c];
        const double sum = is_summed(p, (double) p->e.scale[c]) ? sums[c]
                                                                : even;
        const double fit = sum > 0.5 * even && sum < 2.0 * even ? even / sum
                                                                : 1.0;
        if (l->luminance > 0.0 && even > 0.0)
            q->amount[c] = (float) (light_of(p, c) * fit * l->sum[c] /
                                    (l->luminance * even));
    }
}

/* Sets the amounts of a look, and its dirt's place in the display. */
static void fit_look(const struct pair *p, struct gp_flare_quad *q)
{
    const struct gp_flare_look *const l = q->look;
    double sums[3];
    memcpy(sums, l->area, sizeof sums);
    if (p->e.shape == GP_FLARE_DIRT) {
        q->dirt[0] = (float) (p->e.image.w / fmax(gp_rect_w(p->display), 1.0));
        q->dirt[1] = (float) (p->e.image.h / fmax(gp_rect_h(p->display), 1.0));
        q->dirt[2] = (float) ((q->x - p->display.x0) * (double) q->dirt[0]);
        q->dirt[3] = (float) ((q->y - p->display.y0) * (double) q->dirt[1]);
    } else if (is_summed(p, fmin(least_scale(&p->e), 1.0))) {
        sum_of(q, p->whole, sums);
    }
    for (int c = 0; c < 3; c++)
        q->amount[c] = sums[c] > 0.0 ? (float) (light_of(p, c) / sums[c])
                                     : 0.0f;
    // the pupil's rim moves towards the centre, in radii of the element
    const double dx = gp_rect_middle(p->display, 0) - p->light->x;
    const double dy = gp_rect_middle(p->display, 1) - p->light->y;
    const double far = 2.0 * p->e.cut *
                       off_centre(p->light->x, p->light->y, p->display);
    q->cut[0] = dx != 0.0 ? (float) (far * dx / gp_hypot(dx, dy)) : 0.0f;
    q->cut[1] = dy != 0.0 ? (float) (far * dy / gp_hypot(dx, dy)) : 0.0f;
}

static struct gp_flare_quad quad_of(const struct pair *p,
                                    const struct gp_flare_look *look)
{
    const double angle = p->e.rotation * M_PI / 180.0;
    const float visible = (float) p->light->visibility;
    struct gp_flare_quad q = {
        .plain = p->e.plain && p->level,
        .look = look,
        .turn = {(float) gp_cos(angle), (float) gp_sin(angle)},
        .image = p->level ? &p->level->image : NULL,
    };
    place_of(&p->e, p->light, p->display, &q.x, &q.y);
    place_quad(&q, p->rect);
    if (q.plain)
        memcpy(q.amount, p->light->flux, sizeof q.amount);
    else if (look)
        fit_look(p, &q);
    else
        fit_image(p, &q);
    for (int c = 0; c < 3; c++)
        q.amount[c] *= visible;
    return q;
}

/* Fits what lights share of element e to the light of a pair: a level at the
 * size that the image is drawn in, and a look. */
static gp_status fit_shared(const struct gp_log *log,
    const struct gp_flare_element *e, const struct pair *p, struct shared *s)
{
    const double size = diameter_of(e, p->display) * least_scale(e);
    gp_status st = GP_OK;
    if (e->image.w && !s->level.image.w) {
        if (e->plain || !is_image(e))
            s->level.image = e->image;
        else
            st = make_level(log, &e->image, fmax(size, 1.0),
                                     &s->level);
    }
    if (!st && !is_image(e) &&
        (!s->look.table || s->look.diameter != p->diameter)) {
        gp_flare_look_free(&s->look);
        st = gp_flare_look_make(log, &p->e, p->diameter, &s->look);
    }
    return st;
}

// -- adding ------------------------------------------------------------------

enum { ROWS = 32 }; // of a task

struct adding {
    struct gp_flare_quad quad;
    struct gp_rect frame;
    struct gp_planes *layer;
};

static void add_rows(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_flare_quad *const q = &a->quad;
    const struct gp_rect f = a->frame;
    const int y0 = q->rect.y0 + i * ROWS;
    (void) thread;
    for (int y = y0; y < gp_min(y0 + ROWS, q->rect.y1); y++) {
        const size_t at = (size_t) (y - f.y0) * (size_t) gp_rect_w(f) +
                          (size_t) (q->rect.x0 - f.x0);
        float *const to[3] = {a->layer->c[0] + at, a->layer->c[1] + at,
                              a->layer->c[2] + at};
        gp_flare_add_row(q, y, q->amount, to);
    }
}

gp_status gp_flare_add(const struct gp_log *log, const struct gp_flare *f,
    const struct gp_light *light, int n, struct gp_rect frame,
    struct gp_rect display, struct gp_planes *layer)
{
    struct shared *shared;
    gp_status st = gp_alloc_zero(log, "flare elements", (size_t) f->n,
                                 sizeof *shared, &shared);
    for (int i = 0; i < n * f->n && !st; i++) {
        const int k = i % f->n;
        struct pair p;
        if (!find_pair(f, k, &light[i / f->n], frame, display, &p))
            continue;
        st = fit_shared(log, &f->element[k], &p, &shared[k]);
        if (st)
            break;
        p.level = f->element[k].image.w ? &shared[k].level : NULL;
        struct adding a = {quad_of(&p, is_image(&p.e) ? NULL : &shared[k].look),
                           frame, layer};
        gp_parallel_do((gp_rect_h(p.rect) + ROWS - 1) / ROWS, add_rows, &a);
    }
    for (int k = 0; k < f->n && shared; k++) {
        if (shared[k].level.level > 0)
            gp_planes_free(&shared[k].level.image.rgb);
        gp_flare_look_free(&shared[k].look);
    }
    gp_free(shared);
    return st;
}
