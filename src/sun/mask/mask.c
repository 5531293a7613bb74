// SPDX-License-Identifier: Apache-2.0
/* Maughan's texture masking on GL, and the paper's other method: drawing,
 * reading back, and the plain form on the CPU. */
#include "sun/mask/mask_priv.h"

#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <string.h>

enum {
    LIGHT_TEXELS = 4, // of a row of `lights`
    NARROW = 64,      // texels of a row of `pixels`, at least
    K_MAX = 16,       // samples along a texel's side
    POINTS = 16,      // along a map's side, of sums in 8 bits
};

/* Place on the scale of depth of a pixel without surface, and of a light
 * beyond everything; surfaces are under it. Known to sun_map.frag as EMPTY. */
static const float EMPTY = 3.4e38f;

/* Samples are moved so many pixels right and down. A sample is often on the
 * line between two pixels (whole positions and radii); this decides which one
 * it reads, whatever the rounding. */
static const double NUDGE = 1.0 / 1048576.0;

// -- lights in pixels of the frame -------------------------------------------

/* A light as sun_map.frag sees it. Places are from o->frame's first pixel. */
struct spot {
    double x, y, radius; // pixels, each the sum of two floats; 1e8 at most
    int k;               // samples along a texel's side; 0: invisible, as it
                         // is behind the camera or its place is not finite
    float limit;         // surfaces at a place under it hide the light
    struct gp_rect box;  // pixels that its samples read; may be empty
    int row;             // of the texture, from which on it has the box
    float outside[2];    // shown * weight and weight of a sample outside the
                         // frame, or of all where the light is behind the
                         // camera
};

/* The sum of two floats, for places that one is too short for. */
static void split_float(double v, float out[2])
{
    out[0] = (float) v;
    out[1] = (float) (v - (double) out[0]);
}

/* The nearest sum of two floats, which is how the shader gets it; 1e8 is
 * beyond every frame. */
static double two_floats(double v)
{
    float part[2];
    split_float(fmax(-1e8, fmin(v, 1e8)), part);
    return (double) part[0] + (double) part[1];
}

/* Returns the pixel of coordinate `at`, -1 or `size` outside of [0, size). */
static int pixel_at(double at, int size)
{
    at += NUDGE;
    return at < 0.0 ? -1 : at >= size ? size : (int) at;
}

static void pixel_span(double at, double radius, int size, int *from, int *to)
{
    *from = gp_max(pixel_at(at - radius, size), 0);
    *to = gp_min(pixel_at(at + radius, size) + 1, size);
}

static struct spot spot_of(const struct gp_occluders *o,
                           const struct glarepp_light_params *p,
                           const struct gp_light *l)
{
    const bool scene = p->outside == GLAREPP_BY_SCENE;
    const bool nowhere = !isfinite(l->x) || !isfinite(l->y) ||
                         !(l->radius >= 0.0);
    const double nearer = l->depth * (1.0 - l->bias);
    struct spot s = {.limit = -EMPTY}; // NaN hides none
    if (isinf(l->depth) && l->depth > 0.0)
        s.limit = EMPTY;
    else if (nearer >= -3e38)
        s.limit = (float) fmin(nearer, 3e38);
    if (l->behind ? scene : !nowhere && p->outside != GLAREPP_IGNORE) {
        s.outside[0] = scene ? (float) l->outside
                             : p->outside == GLAREPP_VISIBLE;
        s.outside[1] = 1.0f;
    }
    if (l->behind || nowhere)
        return s;
    s.x = two_floats(l->x - o->frame.x0);
    s.y = two_floats(l->y - o->frame.y0);
    s.radius = two_floats(l->radius);
    s.k = (int) fmax(1.0, fmin(ceil(2.0 * s.radius / p->side), K_MAX));
    pixel_span(s.x, s.radius, gp_rect_w(o->frame), &s.box.x0, &s.box.x1);
    pixel_span(s.y, s.radius, gp_rect_h(o->frame), &s.box.y0, &s.box.y1);
    return s;
}

/* Maps (u, v) in [0, 1)^2 to the square [-1, 1]^2, or to the unit disc by
 * the concentric map (Shirley and Chiu 1997), which keeps areas' ratios.
 * Texel (i, j) of an n x n sun map is the cell [i, i+1)/n x [j, j+1)/n. */
static void place_sample(bool square, double u, double v,
                         double *x, double *y)
{
    const double a = 2.0 * u - 1.0, b = 2.0 * v - 1.0;
    *x = a;
    *y = b;
    if (square || (a == 0.0 && b == 0.0))
        return;
    // the wedge of the larger coordinate, which is the radius; the other one
    // turns by up to an eighth of a circle from its axis
    if (fabs(a) > fabs(b)) {
        const double turn = M_PI_4 * (b / a);
        *x = a * gp_cos(turn);
        *y = a * gp_sin(turn);
    } else {
        const double turn = M_PI_4 * (a / b);
        *x = b * gp_sin(turn);
        *y = b * gp_cos(turn);
    }
}

double gp_sun_map_reference(const struct gp_occluders *o,
    const struct glarepp_light_params *p, const struct gp_light *light, float *map)
{
    const struct spot l = spot_of(o, p, light);
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const int side = p->side * l.k, count = l.k * l.k;
    double shown = 0.0, weight = 0.0;
    for (int texel = 0; texel < p->side * p->side; texel++) {
        const int i = texel % p->side, j = texel / p->side;
        double r = l.k ? 0.0 : (double) l.outside[0];
        double g = l.k ? 0.0 : (double) l.outside[1];
        for (int n = 0; n < count; n++) {
            double x, y;
            place_sample(p->square, (i * l.k + n % l.k + 0.5) / side,
                         (j * l.k + n / l.k + 0.5) / side, &x, &y);
            const int px = pixel_at(l.x + l.radius * x, w);
            const int py = pixel_at(l.y + l.radius * y, h);
            const bool inside = px >= 0 && px < w && py >= 0 && py < h;
            r += (inside ? gp_occluders_show(o, light, px + o->frame.x0,
                                             py + o->frame.y0, NULL)
                         : (double) l.outside[0]) / count;
            g += (inside ? 1.0 : (double) l.outside[1]) / count;
        }
        shown += r;
        weight += g;
        if (map) {
            map[2 * texel] = (float) r;
            map[2 * texel + 1] = (float) g;
        }
    }
    return weight > 0.0 ? shown / weight : 0.0;
}

/* Draws a light's map, or its visibility where p is NULL, and the picture there,
 * as tiles of `tile` pixels side by side.
 *   map   r and g of p->side squared texels
 *   to    the first pixel in planes of `wide` */
static void draw_tiles(const struct glarepp_light_params *p, const float *map,
                       const struct gp_image *f, const struct gp_light *l,
                       int tile, size_t to, size_t wide,
                       const struct gp_planes *out)
{
    const int side = p ? p->side : 1;
    const double r = fmax(l->radius, 0.5), step = 2.0 * r / tile;
    for (int k = 0; k < tile * tile; k++) {
        const int i = k % tile, j = k / tile;
        const int texel = j * side / tile * side + i * side / tile;
        const double x = floor(l->x - r + (i + 0.5) * step) - f->data.x0;
        const double y = floor(l->y - r + (j + 0.5) * step) - f->data.y0;
        const bool seen = !l->behind && x >= 0.0 && x < gp_image_w(f) &&
                          y >= 0.0 && y < gp_image_h(f);
        const size_t from =
            seen ? (size_t) y * (size_t) gp_image_w(f) + (size_t) x : 0;
        const float g = p ? map[2 * texel + 1] : 1.0f;
        const float v = !p         ? (float) l->visibility
                        : g > 0.0f ? map[2 * texel] / g
                                   : 0.0f;
        float *at;
        for (int c = 0; c < 3; c++) {
            at = out->c[c] + to + (size_t) j * wide + (size_t) i;
            at[0] = v;
            at[tile] = seen ? f->rgb.c[c][from] : 0.0f;
        }
    }
}

gp_status gp_sun_map_picture(const struct gp_log *log,
                             const struct gp_occluders *o,
                             const struct glarepp_light_params *p,
                             const struct gp_image *f,
                             const struct gp_light *light, int n, int size[2],
                             struct gp_planes *out)
{
    enum { LARGE = 256, FEW = 64, IN_A_ROW = 32 };
    const int side = p ? p->side : 1, columns = gp_min(n, IN_A_ROW);
    const int tile = n > FEW ? side : (LARGE + side - 1) / side * side;
    float *map = NULL;
    gp_status st;
    size[0] = columns * 2 * tile;
    size[1] = (n + columns - 1) / columns * tile;
    const size_t w = (size_t) size[0], all = w * (size_t) size[1];
    GP_TRY(gp_alloc(log, "map", (size_t) (side * side), 2 * sizeof *map, &map));
    GP_TRY(gp_planes_make(log, "picture", all, out));
    gp_planes_clear(out, 0, all);
    for (int i = 0; i < n; i++) {
        if (p)
            (void) gp_sun_map_reference(o, p, &light[i], map);
        draw_tiles(p, map, f, &light[i], tile,
                   (size_t) (i / columns * tile) * w +
                       (size_t) (i % columns * 2 * tile),
                   w, out);
    }
out:
    gp_free(map);
    return st;
}

// -- state on a context ------------------------------------------------------

void gp_sun_map_close(const struct gp_gl *gl, struct gp_sun_map *s)
{
    gp_program_free(gl, &s->draws_maps);
    gp_program_free(gl, &s->draws_pixels);
    gp_texture_free(gl, &s->pixels);
    gp_texture_free(gl, &s->lights);
    gp_target_free(gl, &s->atlas);
    gp_target_free(gl, &s->region);
    for (int bytes = 0; bytes < 2; bytes++) {
        gp_program_free(gl, &s->adds_up[bytes]);
        gp_target_free(gl, &s->sums[bytes]);
    }
}

/* Lights to be measured on a context. */
struct job {
    const struct gp_log *log;
    const struct gp_gl *gl;
    const struct gp_occluders *o;
    const struct glarepp_light_params *p;
    struct gp_light *light;
    int n;
    struct gp_sun_map *s;
    struct spot spot[GP_LIGHTS_MAX];
};

/* Rows of `wide` texels that the pixels of r fill, two a texel. */
static double rows_of(struct gp_rect r, int wide)
{
    return ceil((double) gp_rect_w(r) * gp_rect_h(r) / (2.0 * wide));
}

/* Writes the pixels of the frame in `r`, row after row: place and coverage. */
static void write_pixels(const struct gp_occluders *o, struct gp_rect r,
                         float *to)
{
    for (int y = r.y0; y < r.y1; y++) {
        for (int x = r.x0; x < r.x1; x++, to += 2) {
            const struct gp_sun_pixel p =
                gp_occluders_at(o, x + o->frame.x0, y + o->frame.y0);
            to[0] = isinf(p.place) ? EMPTY : (float) fmin(p.place, 3e38);
            to[1] = p.cover;
        }
    }
}

/* Writes the pixels under the lights to s->pixels. Errors: GP_ERR_GL they do not
 * fit. */
static gp_status upload(struct job *j)
{
    enum { EXACT_IN_FLOAT = 1 << 24 };
    const struct gp_gl *const gl = j->gl;
    struct gp_texture *const to = &j->s->pixels;
    const int w = gp_rect_w(j->o->frame), h = gp_rect_h(j->o->frame);
    const int most = gp_gl_info(gl)->max_size;
    int wide = gp_max(gp_min(most, NARROW), to->w) / 2;
    double rows;
    float *rgba = NULL;
    gp_status st;
    do {
        rows = 0.0;
        wide *= 2;
        for (int i = 0; i < j->n; i++)
            rows += rows_of(j->spot[i].box, wide);
    } while (rows > most && 2 * wide <= most);
    if (w > EXACT_IN_FLOAT || h > EXACT_IN_FLOAT || rows > most)
        return gp_fail_bare_at(j->log, GP_ERR_GL, "lights.method",
                               "sun map: the pixels under %d lights in a frame "
                               "of %dx%d do not fit into a texture (the limit "
                               "is %dx%d texels)",
                               j->n, w, h, wide, most);
    const struct gp_rect all = {0, 0, wide, (int) fmax(rows, 1.0)};
    GP_TRY(gp_texture_make(j->log, gl, "pixels under the lights",
                           GP_TEXEL_FLOAT, all.x1, all.y1, to));
    GP_TRY(gp_alloc_zero(j->log, "pixels under the lights", gp_rect_pixels(all),
                         4 * sizeof *rgba, &rgba));
    for (int i = 0, row = 0; i < j->n; i++) {
        struct spot *const l = &j->spot[i];
        l->row = row;
        write_pixels(j->o, l->box, rgba + 4 * (size_t) row * (size_t) wide);
        row += (int) rows_of(l->box, wide);
    }
    gp_texture_write(gl, to, all, rgba);
out:
    gp_free(rgba);
    return st;
}

/* Writes the lights to s->lights. */
static gp_status upload_lights(const struct job *j)
{
    float row[GP_LIGHTS_MAX][4 * LIGHT_TEXELS] = {0};
    struct gp_texture *const to = &j->s->lights;
    const gp_status st = gp_texture_make(
        j->log, j->gl, "lights", GP_TEXEL_FLOAT, LIGHT_TEXELS, j->n, to);
    if (st)
        return st;
    for (int i = 0; i < j->n; i++) {
        const struct spot *const l = &j->spot[i];
        const int whole[6] = {l->k, 0, l->box.x0, l->box.y0,
                              gp_rect_w(l->box), l->row};
        split_float(l->x, row[i]);
        split_float(l->y, row[i] + 2);
        split_float(l->radius, row[i] + 4);
        for (int k = 0; k < 6; k++)
            row[i][6 + k] = (float) whole[k];
        row[i][7] = l->limit;
        memcpy(row[i] + 12, l->outside, sizeof l->outside);
    }
    gp_texture_write(j->gl, to, (struct gp_rect) {0, 0, LIGHT_TEXELS, j->n},
                     row[0]);
    return GP_OK;
}

// -- texture masking ---------------------------------------------------------

/* Step 3: the sun maps. */
static gp_status draw_maps(const struct job *j, struct gp_rect cells)
{
    enum { MOST = 1 << 24 }; // texels of the atlas, 256 MiB
    struct gp_sun_map *const s = j->s;
    const int limit = gp_gl_info(j->gl)->max_size, side = j->p->side;
    const int w = cells.x1 * side, h = cells.y1 * side;
    gp_status st;
    if (w > limit || h > limit || (long long) w * h > MOST)
        return gp_fail_bare_at(
            j->log, GP_ERR_GL, "lights.side",
            "sun map: %d maps of %dx%d texels do not fit into a texture (the "
            "limit is %d texels wide and high, and %d in all)",
            j->n, side, side, limit, MOST);
    GP_TRY(gp_target_make(j->log, j->gl, "sun maps", GP_TEXEL_FLOAT, 1, w, h,
                          &s->atlas));
    GP_TRY(gp_program_make(j->log, j->gl, "", "sun_map.vert", "sun_map.frag",
                           &s->draws_maps));
    const struct gp_uniform uniform[] = {
        {.name = "pixels", .texture = &s->pixels},
        {.name = "lights", .texture = &s->lights},
        {.name = "frame",
         .v = {gp_rect_w(j->o->frame), gp_rect_h(j->o->frame)}},
        {.name = "size", .v = {s->atlas.w, s->atlas.h}},
        {.name = "light", .v = {0, 0}},
        {.name = "map", .v = {side, cells.x1}},
        {.name = "form", .v = {side, !j->p->square}},
        {0},
    };
    const struct gp_draw maps = {
        .program = &s->draws_maps,
        .target = &s->atlas,
        .cut = {0, 0, w, h},
        .uniform = uniform,
        .vertices = 6,
        .instances = j->n,
        .replace = true,
    };
    st = gp_draw_run(j->log, j->gl, &maps);
out:
    return st;
}

/* Step 4: the texels of each map, added up in a pixel. */
static gp_status draw_sums(const struct job *j, struct gp_rect cells)
{
    const int side = j->p->side, bytes = j->p->bytes;
    // in 8 bits 256 points at most, each of four texels or more
    const int points = bytes && side > POINTS ? gp_min(side / 2, POINTS) : side;
    const int count = points * points;
    struct gp_target *const to = &j->s->sums[bytes];
    gp_status st;
    GP_TRY(gp_target_make(j->log, j->gl, "intensity map",
                          bytes ? GP_TEXEL_BYTE : GP_TEXEL_FLOAT, 1, cells.x1,
                          cells.y1, to));
    GP_TRY(gp_program_make(j->log, j->gl, bytes ? "#define BYTE\n" : "",
                           "sun_point.vert", "sun_point.frag",
                           &j->s->adds_up[bytes]));
    struct gp_uniform uniform[] = {
        {.name = "atlas", .texture = &j->s->atlas.colour},
        {.name = "map", .v = {side, points}},
        {0},
        {0},
    };
    // the paper's 1 / 255 is for 256 points; fewer make whole steps of it, no more
    if (bytes)
        uniform[2] = (struct gp_uniform) {
            .name = "scale",
            .floats = 1,
            .f = {(float) (256 / count) / 255.0f},
        };
    const struct gp_draw sums = {
        .program = &j->s->adds_up[bytes],
        .target = to,
        .cut = cells,
        .view = cells,
        .uniform = uniform,
        .vertices = 3,
        .instances = count,
    };
    gp_target_clear(j->gl, to, cells);
    st = gp_draw_run(j->log, j->gl, &sums);
out:
    return st;
}

/* Both steps, read at once. */
static gp_status by_maps(const struct job *j)
{
    const int columns = (int) ceil(sqrt((double) j->n)); // maps in the atlas
    const struct gp_rect cells = {0, 0, columns,
                                  (j->n + columns - 1) / columns};
    float sum[GP_LIGHTS_MAX][4];
    gp_status st;
    GP_TRY(draw_maps(j, cells));
    GP_TRY(draw_sums(j, cells));
    gp_target_read(j->gl, &j->s->sums[j->p->bytes], 0, cells, sum[0]);
    GP_TRY(gp_gl_check(j->log, j->gl, "sun map"));
    for (int i = 0; i < j->n; i++) { // with the rests of sums in float
        const double shown = (double) sum[i][0] + (double) sum[i][2];
        const double weight = (double) sum[i][1] + (double) sum[i][3];
        j->light[i].visibility = weight > 0.0 ? fmin(shown / weight, 1.0) : 0.0;
    }
out:
    return st;
}

// -- the region under a light ------------------------------------------------

/* Counts the pixel centres in a light, in the frame or not. */
static double centres_in(const struct spot *l, bool disc)
{
    enum { BY_ROWS = 2048 }; // radius; over it the area is right to 1e-5
    const double r = l->radius;
    double all = 0.0;
    if (r > BY_ROWS)
        return (disc ? M_PI : 4.0) * r * r;
    for (double y = ceil(l->y - r - 0.5) + 0.5; y <= l->y + r; y += 1.0) {
        const double down = y - l->y;
        const double half = disc ? sqrt(fmax(r * r - down * down, 0.0)) : r;
        all += floor(l->x + half - 0.5) + 1.0 - ceil(l->x - half - 0.5);
    }
    return all;
}

/* Returns the visible share of a light: over the pixels whose centres are in
 * it, or in the pixel under its centre when it holds none.
 *   rgba  the region of l->box; NULL when none of it is in the frame */
static double count_region(const struct spot *l, const struct gp_occluders *o,
                           const struct glarepp_light_params *p, const float *rgba)
{
    const struct gp_rect box = l->box;
    const int w = gp_rect_w(o->frame), h = gp_rect_h(o->frame);
    const bool disc = !p->square;
    const double r = l->radius, all = centres_in(l, disc);
    double shown = 0.0, weight = 0.0;
    double under[2] = {(double) l->outside[0], (double) l->outside[1]};
    for (int i = 0; rgba && i < gp_rect_w(box) * gp_rect_h(box); i++) {
        const int x = box.x0 + i % gp_rect_w(box);
        const int y = box.y0 + i / gp_rect_w(box);
        const double dx = x + 0.5 - l->x, dy = y + 0.5 - l->y;
        const double v = (double) rgba[4 * i], g = (double) rgba[4 * i + 1];
        if (x == pixel_at(l->x, w) && y == pixel_at(l->y, h)) {
            under[0] = v;
            under[1] = g;
        }
        if (disc ? dx * dx + dy * dy > r * r
                 : fmax(fabs(dx), fabs(dy)) > r)
            continue;
        shown += v;
        weight += g;
    }
    if (!(all > 0.0))
        return under[1] > 0.0 ? under[0] / under[1] : 0.0;
    const double beyond = fmax(all - weight, 0.0);
    shown += beyond * (double) l->outside[0];
    weight += beyond * (double) l->outside[1];
    return weight > 0.0 ? shown / weight : 0.0;
}

/* Draws and reads the region under each light. */
static gp_status by_regions(const struct job *j)
{
    struct gp_sun_map *const s = j->s;
    float *rgba = NULL;
    gp_status st;
    GP_TRY(gp_program_make(j->log, j->gl, "#define PIXELS\n", "sun_map.vert",
                           "sun_map.frag", &s->draws_pixels));
    for (int i = 0; i < j->n; i++) {
        const struct spot *const l = &j->spot[i];
        const struct gp_rect all = {0, 0, gp_rect_w(l->box), gp_rect_h(l->box)};
        const struct gp_uniform uniform[] = {
            {.name = "pixels", .texture = &s->pixels},
            {.name = "lights", .texture = &s->lights},
            {.name = "size", .v = {all.x1, all.y1}},
            {.name = "light", .v = {i, 0}},
            {.name = "map", .v = {gp_max(all.x1, all.y1), 1}},
            {0},
        };
        const struct gp_draw draw = {
            .program = &s->draws_pixels,
            .target = &s->region,
            .cut = all,
            .view = all,
            .uniform = uniform,
            .vertices = 6,
            .instances = 1,
            .replace = true,
        };
        if (l->k && !gp_rect_empty(all)) { // drawn, and waited for
            GP_TRY(gp_target_make(j->log, j->gl, "region under a light",
                                  GP_TEXEL_FLOAT, 1, all.x1, all.y1,
                                  &s->region));
            GP_TRY(gp_draw_run(j->log, j->gl, &draw));
            GP_TRY(gp_alloc(j->log, "region under a light", gp_rect_pixels(all),
                            4 * sizeof(float), &rgba));
            gp_target_read(j->gl, &s->region, 0, all, rgba);
        }
        j->light[i].visibility =
            l->k ? count_region(l, j->o, j->p, rgba) : (double) l->outside[0];
        GP_FREE(rgba);
    }
    st = gp_gl_check(j->log, j->gl, "sun readback");
out:
    gp_free(rgba);
    return st;
}

gp_status gp_sun_by_gl(const struct gp_log *log, const struct gp_gl *gl,
                       const struct gp_occluders *o,
                       const struct glarepp_light_params *p,
                       struct gp_light *light, int n, struct gp_sun_map *s)
{
    struct job j = {
        .log = log, .gl = gl, .o = o, .p = p, .light = light, .n = n, .s = s};
    gp_status st;
    for (int i = 0; i < n; i++)
        j.spot[i] = spot_of(o, p, &light[i]);
    GP_TRY(upload(&j));
    GP_TRY(upload_lights(&j));
    st = p->method == GLAREPP_READBACK ? by_regions(&j) : by_maps(&j);
out:
    return st;
}
