/* The sun map and the intensity map on GL: their state, drawing, reading back.
 * And shares counted on the CPU: of a region that is drawn and waited for, the
 * paper's other method ("lens flare occlusion"); and the plain form of the sun
 * map. */
#include "core/memory.h"
#include "sun/sun_priv.h"

#include <math.h>

enum { LIGHT_TEXELS = 3 }; // of a row of `lights`

void gp_sun_map_close(const struct gp_gl *gl, struct gp_sun_map **state)
{
    struct gp_sun_map *const s = *state;
    if (!s)
        return;
    for (int i = 0; i < GP_SUN_PROGRAMS; i++)
        gp_program_free(gl, &s->program[i]);
    gp_texture_free(gl, &s->pixels);
    gp_texture_free(gl, &s->lights);
    gp_target_free(gl, &s->atlas);
    gp_target_free(gl, &s->region);
    gp_target_free(gl, &s->sums);
    gp_target_free(gl, &s->byte_sums);
    gp_target_free(gl, &s->intensity);
    gp_free(s->band);
    gp_free(s);
    *state = NULL;
}

static gp_status use_program(const struct gp_log *log, const struct gp_gl *gl,
                             struct gp_sun_map *s, enum gp_sun_program which)
{
    static const struct {
        const char *defines, *vert, *frag;
    } files[GP_SUN_PROGRAMS] = {
        [GP_SUN_TEXELS] = {"", "sun_map.vert", "sun_map.frag"},
        [GP_SUN_PIXELS] = {"#define PIXELS\n", "sun_map.vert",
                           "sun_map.frag"},
        [GP_SUN_POINTS] = {"", "sun_point.vert", "sun_point.frag"},
        [GP_SUN_POINTS_BYTE] = {"#define BYTE\n", "sun_point.vert",
                                "sun_point.frag"},
        [GP_SUN_POINTS_BILINEAR] = {"#define BILINEAR\n", "sun_point.vert",
                                    "sun_point.frag"},
        [GP_SUN_TOTAL] = {"", "add.vert", "sun_sum.frag"},
    };
    if (s->program[which].id)
        return GP_OK;
    return gp_program_make(log, gl, files[which].defines, files[which].vert,
                           files[which].frag, &s->program[which]);
}

/* The sum of two floats, for places that one is too short for. */
static void split_float(double v, float out[2])
{
    out[0] = (float) v;
    out[1] = (float) (v - (double) out[0]);
}

/* Makes *state and what a frame of n lights needs but the atlas: lights and
 * pixels written, intensity of n x 1. Errors: as gp_sun_map_draw(). */
static gp_status begin_frame(const struct gp_log *log, const struct gp_gl *gl,
                             const struct gp_occluders *o,
                             const struct gp_map_params *p,
                             const struct gp_light *light, int n,
                             struct gp_sun_map **state)
{
    const int limit = gp_gl_info(gl)->max_size;
    struct gp_map_pixels pixels;
    float row[GP_LIGHTS_MAX][4 * LIGHT_TEXELS];
    gp_status st = GP_OK;
    if (n < 1 || n > GP_LIGHTS_MAX)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "sun map: cannot draw %d lights (1 to %d); report "
                            "this", n, GP_LIGHTS_MAX);
    if (p->side < 2 || p->side > 256 || p->side % 2)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "sun map: cannot draw %d texels wide (even, 2 to "
                            "256); report this", p->side);
    if (n > limit)
        return gp_fail_bare(log, GP_ERR_GL,
            "sun map: %d lights do not fit into a texture (the limit is %d "
            "texels wide); use --sun-method exact", n, limit);
    if (!*state)
        st = gp_alloc_zero(log, "sun map", 1, sizeof **state, state);
    if (st)
        return st;
    struct gp_sun_map *const s = *state;
    s->n = 0; // nothing is drawn until all is
    if (!s->band) // zeroed: texels between boxes are written too
        GP_TRY(gp_alloc_zero(log, "sun map's pixels", GP_SUN_BAND,
                             4 * sizeof(float), &s->band));
    for (int i = 0; i < n; i++) {
        s->light[i] = gp_map_light_of(o, p->side, &light[i]);
        if (s->light[i].k || light[i].behind)
            gp_map_outside(p->outside, &light[i], s->light[i].outside);
    }
    GP_TRY(gp_map_pack(log, o, s->light, n,
                       limit < GP_SUN_BAND ? limit : GP_SUN_BAND, &pixels));
    GP_TRY(gp_map_write_pixels(log, gl, o, &pixels, s, n));
    // the lights, a row each
    if (s->lights.h < n) {
        gp_texture_free(gl, &s->lights);
        GP_TRY(gp_texture_make(log, gl, "lights", GP_TEXEL_FLOAT, LIGHT_TEXELS,
                               n, &s->lights));
    }
    for (int i = 0; i < n; i++) {
        const struct gp_map_light *const l = &s->light[i];
        split_float(l->x, row[i]);
        split_float(l->y, row[i] + 2);
        split_float(l->radius, row[i] + 4);
        row[i][6] = (float) l->k;
        row[i][7] = l->limit;
        row[i][8] = (float) (l->slot_x - l->box.x0);
        row[i][9] = (float) (l->slot_y - l->box.y0);
        row[i][10] = l->outside[0];
        row[i][11] = l->outside[1];
    }
    gp_texture_write(gl, &s->lights, (struct gp_rect) {0, 0, LIGHT_TEXELS, n},
                     row[0]);
    if (s->intensity.colour.w != n) {
        gp_target_free(gl, &s->intensity);
        GP_TRY(gp_target_make(log, gl, "intensity map", GP_TEXEL_FLOAT, 1, n, 1,
                              &s->intensity));
    }
out:
    return st;
}

// -- atlas -------------------------------------------------------------------

static int power_of_two(int v)
{
    int p = 1;
    while (p < v)
        p *= 2;
    return p;
}

static int rows_of(const struct gp_sun_map *s, int n)
{
    return (n + s->columns - 1) / s->columns;
}

static gp_status draw_points(const struct gp_log *log, const struct gp_gl *gl,
    enum gp_sun_sum sum, struct gp_sun_map *s, const struct gp_target *to)
{
    const enum gp_sun_program which = GP_SUN_POINTS + sum;
    const int count = s->map * s->map;
    const int w = to->colour.w, h = to->colour.h;
    const float widest = gp_gl_info(gl)->max_point;
    const int tile = widest < (float) w ? (int) widest : w; // w >= h
    const int across = (w + tile - 1) / tile, down = (h + tile - 1) / tile;
    struct gp_uniform uniform[] = {
        {.name = "atlas", .texture = &s->atlas.colour},
        {.name = "map", .v = {s->map, s->columns}},
        {.name = "tiles", .v = {across, down}},
        {.name = "width", .v = {tile, tile}},
        {0}, {0},
    };
    // the paper's 1 / 255 is for 256 texels; others are scaled to them
    if (sum == GP_SUM_BYTE)
        uniform[4] = (struct gp_uniform) {
            .name = "scale", .floats = 1,
            .f = {256.0f / (255.0f * (float) count)},
        };
    const struct gp_draw draw = {
        .program = &s->program[which], .target = to,
        .cut = {0, 0, w, h}, .view = {0, 0, across * tile, down * tile},
        .uniform = uniform,
        .vertices = sum == GP_SUM_BILINEAR ? count / 4 : count,
        .instances = across * down, .points = true,
    };
    gp_status st = use_program(log, gl, s, which);
    return st ? st : gp_draw_run(log, gl, &draw);
}

gp_status gp_sun_map_draw(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_occluders *o, const struct gp_map_params *p,
    const struct gp_light *light, int n, struct gp_sun_map **state)
{
    enum { MOST = 1 << 24 }; // texels of the atlas, 256 MiB
    const bool byte = p->sum == GP_SUM_BYTE;
    const int limit = gp_gl_info(gl)->max_size;
    gp_status st;
    GP_TRY(begin_frame(log, gl, o, p, light, n, state));
    struct gp_sun_map *const s = *state;

    // an atlas that is large enough, with about as many columns as rows
    s->columns = (int) ceil(sqrt((double) n));
    const int h = rows_of(s, n);
    const int atlas_w = power_of_two(s->columns * p->side);
    const int atlas_h = power_of_two(h * p->side);
    if (atlas_w > limit || atlas_h > limit ||
        (long long) atlas_w * atlas_h > MOST)
        return gp_fail_bare(log, GP_ERR_GL,
            "sun map: %d maps of %dx%d texels do not fit into a texture (the "
            "limit is %d texels wide and high, and %d in all); use a smaller "
            "--sun-map or --sun-method exact", n, p->side, p->side, limit,
            MOST);
    s->map = p->side;
    const struct gp_texture *const to = &s->atlas.colour;
    if (to->w < atlas_w || to->h < atlas_h) {
        gp_target_free(gl, &s->atlas);
        GP_TRY(gp_target_make(log, gl, "sun maps", GP_TEXEL_LINEAR, 1, atlas_w,
                              atlas_h, &s->atlas));
    }
    const struct gp_uniform of_maps[] = {
        {.name = "pixels", .texture = &s->pixels},
        {.name = "lights", .texture = &s->lights},
        {.name = "frame", .v = {gp_rect_w(o->frame), gp_rect_h(o->frame)}},
        {.name = "size", .v = {to->w, to->h}},
        {.name = "map", .v = {s->map, s->columns}},
        {.name = "form", .v = {s->map, p->pattern == GP_PATTERN_DISC}},
        {0},
    };
    const struct gp_draw maps = {
        .program = &s->program[GP_SUN_TEXELS], .target = &s->atlas,
        .cut = {0, 0, s->columns * s->map, h * s->map},
        .uniform = of_maps, .vertices = 6, .instances = n, .replace = true,
    };
    GP_TRY(use_program(log, gl, s, GP_SUN_TEXELS));
    GP_TRY(gp_draw_run(log, gl, &maps));

    // a pixel for each light, in rows as the maps of the atlas
    struct gp_target *const sums = byte ? &s->byte_sums : &s->sums;
    const int w = s->columns;
    if (sums->colour.w != w || sums->colour.h != h) {
        gp_target_free(gl, sums);
        GP_TRY(byte ? gp_target_make(log, gl, "8-bit sums", GP_TEXEL_BYTE, 1, w,
                                     h, sums)
                    : gp_target_make(log, gl, "sums", GP_TEXEL_FLOAT, 1, w, h,
                                     sums));
    }
    gp_target_clear(gl, sums, (struct gp_rect) {0, 0, w, h});
    GP_TRY(draw_points(log, gl, p->sum, s, sums));
    const struct gp_uniform uniform[] = {
        {.name = "sums", .texture = &sums->colour},
        {.name = "map", .v = {s->map, s->columns}},
        {.name = "scale", .floats = 1,
         .f = {byte ? 1.0f : 1.0f / (float) (s->map * s->map)}}, {0},
    };
    const struct gp_draw draw = {
        .program = &s->program[GP_SUN_TOTAL], .target = &s->intensity,
        .cut = {0, 0, n, 1}, .uniform = uniform, .vertices = 3,
        .instances = 1, .replace = true,
    };
    GP_TRY(use_program(log, gl, s, GP_SUN_TOTAL));
    GP_TRY(gp_draw_run(log, gl, &draw));
    GP_TRY(gp_gl_check(log, gl, "sun map"));
    s->n = n;
out:
    return st;
}

gp_status gp_sun_map_read(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_sun_map *s, struct gp_light *light, int n)
{
    float rgba[4 * GP_LIGHTS_MAX];
    if (!s || !n || s->n != n)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "sun map: %d lights were drawn and %d are read; "
                            "report this", s ? s->n : 0, n);
    gp_target_read(gl, &s->intensity, 0, (struct gp_rect) {0, 0, n, 1}, rgba);
    for (int i = 0; i < n; i++) {
        const double shown = (double) rgba[4 * i];
        const double weight = (double) rgba[4 * i + 1];
        const double share = weight > 0.0 ? shown / weight : 0.0;
        light[i].visibility = share < 1.0 ? share : 1.0;
    }
    return gp_gl_check(log, gl, "sun map");
}

gp_status gp_sun_map_picture(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_sun_map *s, bool intensity, int *w, int *h, float **out)
{
    if (!s || !s->n || (!intensity && !s->map))
        return gp_fail(log, GP_ERR_USAGE,
                       "--debug %s: no such map was drawn; use --sun or "
                       "--lights, and --sun-method mask",
                       intensity ? "intensity" : "sunmap");
    const struct gp_target *const from = intensity ? &s->intensity : &s->atlas;
    struct gp_rect r = {0, 0, s->n, 1};
    if (!intensity) {
        r.x1 = s->columns * s->map;
        r.y1 = rows_of(s, s->n) * s->map;
    }
    const size_t n = (size_t) gp_rect_w(r) * (size_t) gp_rect_h(r);
    float *rgba = NULL, *grey = NULL;
    gp_status st;
    GP_TRY(gp_alloc(log, "picture of the sun map", n, 4 * sizeof *rgba,
                    &rgba));
    GP_TRY(gp_alloc(log, "picture of the sun map", n, sizeof(float), &grey));
    gp_target_read(gl, from, 0, r, rgba);
    GP_TRY(gp_gl_check(log, gl, "picture of the sun map"));
    *w = gp_rect_w(r);
    *h = gp_rect_h(r);
    for (size_t i = 0; i < n; i++) {
        // cells of the atlas after the last light's hold old maps
        const int x = (int) (i % (size_t) *w), y = (int) (i / (size_t) *w);
        const bool drawn = intensity ||
                           y / s->map * s->columns + x / s->map < s->n;
        grey[i] = drawn && rgba[4 * i + 1] > 0.0f
                      ? rgba[4 * i] / rgba[4 * i + 1] : 0.0f;
    }
    *out = grey;
    grey = NULL;
out:
    gp_free(rgba);
    gp_free(grey);
    return st;
}

// -- the region under a light ------------------------------------------------

/* Half of the light's width at `down` from its centre; under 0: outside. */
static double half_width(const struct gp_map_light *l,
                         enum gp_sun_pattern pattern, double down)
{
    const double r = l->radius;
    if (fabs(down) > r)
        return -1.0;
    return pattern == GP_PATTERN_DISC ? sqrt(r * r - down * down) : r;
}

/* Returns the visible share of a light: over the pixels whose centres are in
 * it, or in the pixel under its centre when it holds none.
 *   rgba  the region of l->box; NULL when none of it is in the frame */
static double count_region(const struct gp_map_light *l,
                           const struct gp_occluders *o,
                           const struct gp_map_params *p, const float *rgba)
{
    enum { BY_ROWS = 2048 }; // radius; over it the area is right to 1e-5
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const struct gp_rect box = l->box;
    const double r = l->radius;
    double all = 0.0; // pixel centres in the light, on an unbounded plane
    if (r > BY_ROWS)
        all = (p->pattern == GP_PATTERN_DISC ? M_PI : 4.0) * r * r;
    else
        for (double y = floor(l->y - r); y <= l->y + r; y += 1.0) {
            const double half = half_width(l, p->pattern, y + 0.5 - l->y);
            if (half >= 0.0)
                all += floor(l->x + half - 0.5) + 1.0 - ceil(l->x - half - 0.5);
        }
    double shown = 0.0, weight = 0.0;
    const float *const outside = l->outside;
    if (!(all > 0.0)) {
        const int x = gp_map_pixel_at(l->x, w), y = gp_map_pixel_at(l->y, h);
        const bool inside = rgba && x >= 0 && x < w && y >= 0 && y < h;
        const float *const at =
            inside ? rgba + 4 * ((size_t) (y - box.y0) *
                                     (size_t) gp_rect_w(box) +
                                 (size_t) (x - box.x0))
                   : outside;
        return at[1] > 0.0f ? (double) at[0] / (double) at[1] : 0.0;
    }
    for (int y = box.y0; rgba && y < box.y1; y++) {
        const float *const row = rgba + 4 * (size_t) (y - box.y0) *
                                            (size_t) gp_rect_w(box);
        const double half = half_width(l, p->pattern, y + 0.5 - l->y);
        const double first = ceil(l->x - half - 0.5);
        const double end = floor(l->x + half - 0.5) + 1.0;
        if (half < 0.0)
            continue;
        const int to = end < box.x0   ? box.x0
                       : end > box.x1 ? box.x1
                                      : (int) end;
        for (int x = first > box.x0 ? (int) fmin(first, to) : box.x0; x < to;
             x++) {
            shown += (double) row[4 * (x - box.x0)];
            weight += (double) row[4 * (x - box.x0) + 1];
        }
    }
    const double beyond = all > weight ? all - weight : 0.0;
    shown += beyond * (double) outside[0];
    weight += beyond * (double) outside[1];
    return weight > 0.0 ? shown / weight : 0.0;
}

gp_status gp_sun_readback(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_occluders *o, const struct gp_map_params *p,
    struct gp_light *light, int n, struct gp_sun_map **state)
{
    float intensity[4 * GP_LIGHTS_MAX] = {0}, *rgba = NULL;
    gp_status st;
    GP_TRY(begin_frame(log, gl, o, p, light, n, state));
    struct gp_sun_map *const s = *state;
    GP_TRY(use_program(log, gl, s, GP_SUN_PIXELS));
    for (int i = 0; i < n; i++) {
        const struct gp_map_light *const l = &s->light[i];
        const int w = gp_rect_w(l->box), h = gp_rect_h(l->box);
        const bool drawn = l->k && w && h;
        const struct gp_uniform uniform[] = {
            {.name = "pixels", .texture = &s->pixels},
            {.name = "lights", .texture = &s->lights},
            {.name = "first", .v = {l->box.x0, l->box.y0}},
            {.name = "size", .v = {w, h}},
            {.name = "light", .v = {i, 0}},
            {0},
        };
        const struct gp_draw draw = {
            .program = &s->program[GP_SUN_PIXELS], .target = &s->region,
            .cut = {0, 0, w, h}, .view = {0, 0, w, h}, .uniform = uniform,
            .vertices = 6, .instances = 1, .replace = true,
        };
        if (drawn && (s->region.colour.w < w || s->region.colour.h < h)) {
            gp_target_free(gl, &s->region);
            GP_TRY(gp_target_make(log, gl, "region under a light",
                                  GP_TEXEL_FLOAT, 1, w, h, &s->region));
        }
        if (drawn) { // and waited for
            GP_TRY(gp_draw_run(log, gl, &draw));
            GP_TRY(gp_alloc(log, "region under a light",
                            (size_t) w * (size_t) h, 4 * sizeof(float), &rgba));
            gp_target_read(gl, &s->region, 0, (struct gp_rect) {0, 0, w, h},
                           rgba);
        }
        light[i].visibility = l->k ? count_region(l, o, p, rgba)
                                   : (double) l->outside[0];
        GP_FREE(rgba);
        intensity[4 * i] = (float) light[i].visibility;
        intensity[4 * i + 1] = 1.0f;
    }
    gp_texture_write(gl, &s->intensity.colour, (struct gp_rect) {0, 0, n, 1},
                     intensity);
    GP_TRY(gp_gl_check(log, gl, "sun readback"));
    s->n = n;
    s->map = 0;
out:
    gp_free(rgba);
    return st;
}

double gp_sun_map_reference(const struct gp_occluders *o,
    const struct gp_map_params *p, const struct gp_light *light, float *map)
{
    const struct gp_map_light l = gp_map_light_of(o, p->side, light);
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const int side = p->side * l.k, count = l.k * l.k;
    double shown = 0.0, weight = 0.0;
    float outside[2];
    gp_map_outside(p->outside, light, outside);
    for (int texel = 0; texel < p->side * p->side; texel++) {
        const int i = texel % p->side, j = texel / p->side;
        double r = 0.0, g = 0.0;
        for (int n = 0; n < count; n++) {
            double x, y;
            gp_pattern_place(p->pattern, (i * l.k + n % l.k + 0.5) / side,
                             (j * l.k + n / l.k + 0.5) / side, &x, &y);
            const int px = gp_map_pixel_at(l.x + l.radius * x, w);
            const int py = gp_map_pixel_at(l.y + l.radius * y, h);
            const bool inside = px >= 0 && px < w && py >= 0 && py < h;
            r += inside ? gp_occluders_show(o, light, px + o->frame.x0,
                                            py + o->frame.y0)
                        : (double) outside[0];
            g += inside ? 1.0 : (double) outside[1];
        }
        if (light->behind) {
            r = (double) outside[0];
            g = (double) outside[1];
        }
        r /= count ? count : 1;
        g /= count ? count : 1;
        shown += r;
        weight += g;
        if (map) {
            map[2 * texel] = (float) r;
            map[2 * texel + 1] = (float) g;
        }
    }
    return weight > 0.0 ? shown / weight : 0.0;
}
