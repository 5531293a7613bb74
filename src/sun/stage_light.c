/* The light of suns and lamps: sources for the engines, sprites of the kernel
 * for lights that reach beyond the frame, and lens flare. */
#include "sun/stage.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <string.h>

// -- a light's disc in pixels ------------------------------------------------

/* Weights of the (2m+1) x (2m+1) pixels around a disc's centre pixel, whose
 * sum is 1; one pixel for a radius up to 1/2. */
struct disc {
    int m;
    float *weight; // owned
};

static int disc_reach(double radius)
{
    return radius > 0.5 ? (int) ceil(radius - 0.5) : 0;
}

static gp_status make_disc(const struct gp_log *log, double radius,
                           struct disc *out)
{
    const int m = disc_reach(radius), side = 2 * m + 1;
    const double all = M_PI * radius * radius;
    float *weight;
    gp_status st = gp_alloc(log, "disc of a light",
        (size_t) side * (size_t) side, sizeof *weight, &weight);
    if (st)
        return st;
    for (int i = 0; i < side * side; i++)
        weight[i] = m == 0 ? 1.0f
                           : (float) (gp_disc_pixel_area(0.5, 0.5, radius,
                                                         i % side - m,
                                                         i / side - m) / all);
    *out = (struct disc) {m, weight};
    return GP_OK;
}

/* Weight of pixel (x, y) from the centre pixel; 0 outside. */
static double weight_at(const struct disc *d, int x, int y)
{
    const int m = d->m;
    const size_t side = 2 * (size_t) m + 1;
    if (x < -m || x > m || y < -m || y > m)
        return 0.0;
    return (double) d->weight[(size_t) (y + m) * side + (size_t) (x + m)];
}

/* Appends the pixels of `frame` that a light's disc falls on. */
static void add_disc(const struct disc *d, const struct gp_light *l,
                     struct gp_rect frame, struct gp_source *list, size_t *n)
{
    const double left = floor(l->x - 0.5), top = floor(l->y - 0.5);
    const double fx = l->x - 0.5 - left, fy = l->y - 0.5 - top;
    const int m = d->m;
    for (int y = -m; y <= m + 1; y++) {
        for (int x = -m; x <= m + 1; x++) {
            const int px = (int) left + x, py = (int) top + y;
            if (px < frame.x0 || px >= frame.x1 || py < frame.y0 ||
                py >= frame.y1)
                continue;
            const double w =
                (1.0 - fy) * ((1.0 - fx) * weight_at(d, x, y) +
                              fx * weight_at(d, x - 1, y)) +
                fy * ((1.0 - fx) * weight_at(d, x, y - 1) +
                      fx * weight_at(d, x - 1, y - 1));
            if (!(w > 0.0))
                continue;
            struct gp_source *const e = &list[(*n)++];
            *e = (struct gp_source) {.x = px - frame.x0, .y = py - frame.y0};
            for (int c = 0; c < 3; c++)
                e->rgb[c] = (float) (w * l->visibility * (double) l->flux[c]);
        }
    }
}

// -- lights for the engines, and for sprites ----------------------------------

bool gp_suns_have_light(const struct gp_suns *suns, bool seen)
{
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        if (gp_light_has_flux(l) && (!seen || l->visibility > 0.0))
            return true;
    }
    return false;
}

/* Returns true when light l has glare of its own to add. */
static bool glares(const struct gp_suns *suns, const struct gp_light *l)
{
    return gp_light_has_flux(l) && !suns->p->in_frame && l->visibility > 0.0;
}

/* Returns true when light l goes through the engines, which have no sources
 * outside the frame: one that is partly outside, or nowhere, is a sprite. */
static bool is_inside(const struct gp_light *l, struct gp_rect data)
{
    const double r = fmax(l->radius, 0.5) + 0.5; // with its bilinear shares
    return l->x - r >= data.x0 && l->y - r >= data.y0 &&
           l->x + r <= data.x1 && l->y + r <= data.y1;
}

void gp_suns_offsets(const struct gp_suns *suns, struct gp_rect data,
                     int offset[2])
{
    offset[0] = offset[1] = 0;
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        const double r = fmax(l->radius, 0.5) + 1.5; // with bilinear shares
        const double x = fmax(fabs(l->x - data.x0), fabs(l->x - data.x1)) + r;
        const double y = fmax(fabs(l->y - data.y0), fabs(l->y - data.y1)) + r;
        if (!glares(suns, l) || is_inside(l, data) || !(x < 1e8 && y < 1e8))
            continue;
        offset[0] = gp_max(offset[0], (int) ceil(x));
        offset[1] = gp_max(offset[1], (int) ceil(y));
    }
}

gp_status gp_suns_join(const struct gp_log *log, const struct gp_suns *suns,
                       const struct gp_image *f, const struct gp_sources *src,
                       struct gp_sources *out)
{
    gp_status st;
    struct gp_source *list = NULL;
    size_t n = 0, room = 0;
    for (int i = 0; i < suns->n; i++) {
        const size_t side = 2 * (size_t) disc_reach(suns->light[i].radius) + 2;
        if (glares(suns, &suns->light[i]) &&
            is_inside(&suns->light[i], f->data))
            room += side * side;
    }
    if (!room)
        return GP_OK;
    GP_TRY(gp_alloc(log, "lights", room, sizeof *list, &list));
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        struct disc d;
        if (!glares(suns, l) || !is_inside(l, f->data))
            continue;
        GP_TRY(make_disc(log, l->radius, &d));
        add_disc(&d, l, f->data, list, &n);
        gp_free(d.weight);
    }
    GP_TRY(gp_sources_join(log, src, list, n, out));
out:
    gp_free(list);
    return st;
}

// -- sprites: the kernel spread over a light's disc ---------------------------

enum { SPRITE_RADIUS = 1024 }; // its picture is 1024 + the kernel's size wide

static void drop_sprite(struct gp_flare *sprite)
{
    for (int k = 0; k < sprite->n; k++)
        gp_planes_free(&sprite->element[k].image.rgb);
    sprite->n = 0;
}

/* A spread kernel as an element; takes its planes. That of a tail is drawn as
 * many times larger as its samples are pixels apart, and its colour gives it
 * back the light that the sum of 1 takes. */
static struct gp_flare_element element_of(const struct gp_spread_kernel *k,
                                          int height)
{
    struct gp_flare_element e = {
        .shape = GP_FLARE_IMAGE, .plain = k->step == 1,
        .scale = {1.0f, 1.0f, 1.0f},
        .size = (double) gp_max(k->w, k->h) * k->step / height,
        .image = {.w = k->w, .h = k->h, .cx = k->cx, .cy = k->cy, .rgb = k->k},
    };
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        double channel = 0.0;
        for (size_t i = 0; i < (size_t) k->w * (size_t) k->h; i++)
            channel += (double) k->k.c[c][i];
        sum += channel * (double) gp_rec709_luminance[c];
    }
    for (int c = 0; c < 3; c++)
        e.colour[c] = e.plain ? 1.0f : (float) (sum * k->step * k->step);
    return e;
}

/* Makes elements of the kernel's core and tail; out->element has room for two. */
static gp_status make_sprite(const struct gp_log *log,
                             const struct gp_kernel *k, double radius,
                             int height, struct gp_flare *out)
{
    struct disc d;
    struct gp_spread_kernel spread;
    if (radius > SPRITE_RADIUS)
        return gp_fail_bare_at(log, GP_ERR_DATA, "lights.in_frame",
            "a light of radius %g pixels is too large for glare of its own at "
            "the frame's edge (the limit is %d); leave its flux out", radius,
            SPRITE_RADIUS);
    drop_sprite(out);
    gp_status st = make_disc(log, fmax(radius, 0.5), &d);
    if (st)
        return st;
    GP_TRY(gp_kernel_spread(log, k, d.m, d.weight, &spread));
    out->element[out->n++] = element_of(&spread, height);
    if (k->tail) {
        GP_TRY(gp_kernel_spread_far(log, k, d.m, d.weight, &spread));
        out->element[out->n++] = element_of(&spread, height);
    }
out:
    gp_free(d.weight);
    return st;
}

// -- drawing -----------------------------------------------------------------

gp_status gp_suns_draw(const struct gp_log *log, struct gp_suns *suns,
                       const struct gp_kernel *kernel, struct gp_image *f)
{
    struct gp_flare_element element[2];
    struct gp_flare sprite = {.element = element};
    double radius = 0.0; // of the sprite
    gp_status st = GP_OK;
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        if (!glares(suns, l) || is_inside(l, f->data))
            continue;
        if (!sprite.n || radius != l->radius)
            GP_TRY(make_sprite(log, kernel, l->radius, gp_rect_h(f->display),
                               &sprite));
        radius = l->radius;
        GP_TRY(gp_flare_add(log, &sprite, l, 1, f->data, f->display,
                            &f->layer));
    }
    if (suns->flare.n)
        GP_TRY(gp_flare_add(log, &suns->flare, suns->light, suns->n, f->data,
                            f->display, &f->layer));
out:
    drop_sprite(&sprite);
    return st;
}
