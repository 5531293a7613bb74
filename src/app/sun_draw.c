#include "app/sun.h"

#include "core/memory.h"

#include <math.h>
#include <string.h>

// -- which light goes where ---------------------------------------------------

bool gp_suns_glare(const struct gp_suns *suns)
{
    for (int i = 0; i < suns->n; i++) {
        if (gp_light_has_flux(&suns->light[i]))
            return true;
    }
    return false;
}

/* A light of which a part is beyond the pixels: engines know no sources there,
 * and its light would be cut. */
static bool reaches_beyond(const struct gp_light *l, struct gp_rect data)
{
    const double r = fmax(l->radius, 0.5) + 0.5; // with its bilinear shares
    return l->x - r < data.x0 || l->y - r < data.y0 || l->x + r > data.x1 ||
           l->y + r > data.y1;
}

/* Whether the shares are on GL still: what hangs on them is drawn there. On
 * the CPU the same takes a tenth of llvmpipe's time. */
static bool on_gl(const struct gp_settings *s, const struct gp_suns *suns)
{
    return s->sun.params.method == GP_SUN_MASK && !suns->early;
}

/* Whether light l is drawn as a sprite and not by the engines. */
static bool is_sprite(const struct gp_settings *s, const struct gp_suns *suns,
                      const struct gp_light *l, struct gp_rect data)
{
    return gp_light_has_flux(l) && !s->sun.in_frame &&
           (on_gl(s, suns) || (l->visibility > 0.0 && reaches_beyond(l, data)));
}

/* Whether light l goes through the engines. */
static bool is_source(const struct gp_settings *s, const struct gp_suns *suns,
                      const struct gp_light *l, struct gp_rect data)
{
    return gp_light_has_flux(l) && !s->sun.in_frame && l->visibility > 0.0 &&
           !is_sprite(s, suns, l, data);
}

gp_status gp_suns_join(const struct gp_log *log, const struct gp_settings *s,
                       const struct gp_suns *suns, const struct gp_frame *f,
                       const struct gp_sources *src, struct gp_sources *out,
                       bool *joined)
{
    gp_status st;
    struct gp_source *list = NULL;
    size_t n = 0, room = 0;
    void *v;
    *joined = false;
    for (int i = 0; i < suns->n; i++) {
        if (is_source(s, suns, &suns->light[i], f->data))
            room += gp_disc_room(suns->light[i].radius);
    }
    if (!room)
        return GP_OK;
    GP_TRY(gp_alloc(log, "lights", room, sizeof *list, &v));
    list = v;
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        struct gp_disc_pixels d;
        if (!is_source(s, suns, l, f->data))
            continue;
        GP_TRY(gp_disc_pixels_make(log, l->radius, &d));
        gp_disc_light(&d, l, f->data, list, &n);
        gp_free(d.weight);
    }
    GP_TRY(gp_sources_join(log, src, list, n, out));
    *joined = true;
out:
    gp_free(list);
    return st;
}

// -- sprites ------------------------------------------------------------------

enum { SPRITE_RADIUS = 1024 }; // its picture is 1024 + the kernel's size wide

static void drop_sprites(struct gp_suns *suns)
{
    for (int i = 0; i < suns->sprites; i++) {
        gp_planes_free(&suns->sprite[i].element.image.rgb);
        if (suns->sprite[i].drawn)
            gp_flare_close(suns->gl, &suns->sprite[i].drawn);
    }
    suns->sprites = 0;
}

/* The sprite of a radius, made when there is none yet. A frame may have more
 * radii than are kept: then all are made anew. */
static gp_status find_sprite(const struct gp_log *log,
                             const struct gp_kernel *k, double radius,
                             struct gp_suns *suns, struct gp_sun_sprite **out)
{
    struct gp_disc_pixels d;
    if (radius > SPRITE_RADIUS)
        return gp_fail_bare(log, GP_ERR_DATA,
                            "a light of radius %g: too large for glare of its "
                            "own at the frame's edge (%d pixels at most); "
                            "give it no flux, or --sun-in-frame", radius,
                            SPRITE_RADIUS);
    radius = radius > 0.5 ? radius : 0.5;
    if (suns->sprite_kernel != k->serial || suns->sprites == GP_SUN_SPRITES)
        drop_sprites(suns);
    suns->sprite_kernel = k->serial;
    for (int i = 0; i < suns->sprites; i++) {
        if (suns->sprite[i].radius == radius) {
            *out = &suns->sprite[i];
            return GP_OK;
        }
    }
    struct gp_sun_sprite *const made = &suns->sprite[suns->sprites];
    *made = (struct gp_sun_sprite) {
        .radius = radius,
        .element = {.shape = GP_FLARE_IMAGE, .plain = true,
                    .colour = {1.0f, 1.0f, 1.0f}, .scale = {1.0f, 1.0f, 1.0f}},
    };
    gp_status st = gp_disc_pixels_make(log, radius, &d);
    if (st)
        return st;
    struct gp_spread_kernel wide;
    st = gp_kernel_spread(log, k, d.m, d.weight, &wide);
    gp_free(d.weight);
    if (st)
        return st;
    made->element.image = (struct gp_flare_image) {
        .w = wide.w, .h = wide.h, .cx = wide.cx, .cy = wide.cy, .rgb = wide.k,
        .serial = wide.serial,
    };
    suns->sprites++;
    *out = made;
    return GP_OK;
}

// -- drawing ------------------------------------------------------------------

bool gp_suns_add_light(const struct gp_settings *s, const struct gp_suns *suns)
{
    if (on_gl(s, suns))
        return gp_suns_glare(suns);
    for (int i = 0; i < suns->n; i++) {
        if (gp_light_has_flux(&suns->light[i]) &&
            suns->light[i].visibility > 0.0)
            return true;
    }
    return false;
}

/* All of a flare's elements, on the CPU or on GL. */
static gp_status draw(const struct gp_log *log, const struct gp_settings *s,
                      struct gp_suns *suns, const struct gp_flare *flare,
                      const struct gp_light *light, struct gp_frame *f,
                      struct gp_flare_gl **drawn)
{
    if (!on_gl(s, suns))
        return gp_flare_add(log, flare, light, suns->n, f->data, f->display,
                            &f->layer);
    gp_status st = gp_flare_draw(log, suns->gl, flare, light, suns->n,
                                 gp_sun_intensity(suns->map), f->data,
                                 f->display, drawn);
    return st ? st : gp_flare_read_layer(log, suns->gl, *drawn, f->data,
                                         &f->layer);
}

/* Marks the sprites' lights of the next radius that has none yet; how many. */
static int next_radius(const struct gp_settings *s, const struct gp_suns *suns,
                       struct gp_rect data, bool *done, struct gp_light *some)
{
    int n = 0;
    double radius = 0.0;
    for (int i = 0; i < suns->n; i++) {
        some[i] = suns->light[i];
        const bool next = !done[i] && is_sprite(s, suns, &some[i], data) &&
                          (n == 0 || some[i].radius == radius);
        if (next) {
            radius = some[i].radius;
            done[i] = true;
            n++;
        } else {
            memset(some[i].flux, 0, sizeof some[i].flux);
        }
    }
    return n;
}

/* The glare of the sprites' lights, those of one radius at a time. */
static gp_status draw_sprites(const struct gp_log *log,
                              const struct gp_settings *s,
                              struct gp_suns *suns,
                              const struct gp_kernel *kernel, bool *done,
                              struct gp_light *some, struct gp_frame *f)
{
    while (next_radius(s, suns, f->data, done, some)) {
        struct gp_sun_sprite *sprite;
        double radius = 0.0;
        for (int i = 0; i < suns->n; i++)
            radius = gp_light_has_flux(&some[i]) ? some[i].radius : radius;
        gp_status st = find_sprite(log, kernel, radius, suns, &sprite);
        if (st)
            return st;
        const struct gp_flare one = {.element = &sprite->element, .n = 1};
        st = draw(log, s, suns, &one, some, f, &sprite->drawn);
        if (st)
            return st;
    }
    return GP_OK;
}

/* Sprite and flare together, where all lights that have flux are sprites of
 * one radius, as a lone sun is: one draw and one way back. */
static gp_status draw_together(const struct gp_log *log,
                               const struct gp_settings *s,
                               struct gp_suns *suns,
                               const struct gp_kernel *kernel,
                               struct gp_frame *f, bool *drawn)
{
    double radius = -1.0;
    struct gp_sun_sprite *sprite;
    void *v;
    *drawn = false;
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        if (!gp_light_has_flux(l))
            continue;
        if (!is_sprite(s, suns, l, f->data) ||
            (radius >= 0.0 && l->radius != radius))
            return GP_OK;
        radius = l->radius;
    }
    gp_status st = find_sprite(log, kernel, radius, suns, &sprite);
    if (st)
        return st;
    const int n = suns->flare.n + 1;
    st = gp_alloc(log, "flare", (size_t) n, sizeof *suns->flare.element, &v);
    if (st)
        return st;
    const struct gp_flare all = {.element = v, .n = n};
    all.element[0] = sprite->element;
    memcpy(all.element + 1, suns->flare.element,
           (size_t) suns->flare.n * sizeof *all.element);
    st = draw(log, s, suns, &all, suns->light, f, &suns->drawn);
    gp_free(v);
    *drawn = !st;
    return st;
}

static gp_status draw_all(const struct gp_log *log, const struct gp_settings *s,
                          struct gp_suns *suns, const struct gp_kernel *kernel,
                          struct gp_frame *f)
{
    gp_status st;
    void *some = NULL, *done = NULL;
    bool drawn = false;
    if (suns->flare.n)
        GP_TRY(draw_together(log, s, suns, kernel, f, &drawn));
    if (drawn)
        return GP_OK;
    GP_TRY(gp_alloc(log, "lights", (size_t) suns->n, sizeof *suns->light,
                    &some));
    GP_TRY(gp_alloc_zero(log, "lights", (size_t) suns->n, sizeof(bool),
                         &done));
    GP_TRY(draw_sprites(log, s, suns, kernel, done, some, f));
    if (suns->flare.n)
        GP_TRY(draw(log, s, suns, &suns->flare, suns->light, f,
                    &suns->drawn));
out:
    gp_free(some);
    gp_free(done);
    return st;
}

gp_status gp_suns_draw(const struct gp_log *log, const struct gp_settings *s,
                       struct gp_suns *suns, const struct gp_kernel *kernel,
                       struct gp_frame *f)
{
    gp_status st = GP_OK;
    if (!suns->n)
        return GP_OK;
    if (on_gl(s, suns))
        GP_TRY(gp_gl_use(log, suns->gl));
    if (gp_suns_add_light(s, suns))
        GP_TRY(draw_all(log, s, suns, kernel, f));
    if (on_gl(s, suns))
        GP_TRY(gp_sun_map_read(log, suns->gl, suns->map, suns->light,
                               suns->n));
out:
    return st;
}

void gp_suns_close(struct gp_suns *suns)
{
    gp_suns_end_frame(suns);
    drop_sprites(suns);
    if (suns->drawn)
        gp_flare_close(suns->gl, &suns->drawn);
    if (suns->map)
        gp_sun_map_close(suns->gl, &suns->map);
    if (suns->gl)
        gp_gl_close(&suns->gl);
    gp_flare_free(&suns->flare);
    gp_camera_file_free(&suns->cameras);
    gp_free(suns->spec);
    *suns = (struct gp_suns) {0};
}
