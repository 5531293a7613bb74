#include "sun/json.h"
#include "sun/sun_priv.h"

#include "core/colour.h"
#include "core/memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Mean over all directions of m squared: an edge's ramp has variance m^2 / 12,
 * which adds to the area inside of a round one. */
#define RAMP (0.5 + 1.0 / pi)

/* Elements up to so many pixels across are summed, not integrated: the sum over
 * pixels of a small shape depends on where it lies. Above, the two differ by
 * less than 1e-3. */
enum { SUMMED = 128 };

enum { FAR = 1 << 30 }; // pixels; no window goes beyond

/* -- sizes ----------------------------------------------------------------- */

/* Shape of one channel, in pixels. */
struct shape {
    double radius, inner, area;
};

/* Nothing is under a pixel across, nor rings and streaks under a pixel wide. */
static struct shape shape_of(const struct gp_flare_element *e, double radius)
{
    const double n = e->sides, half = pi / n;
    struct shape s = {0};
    switch (e->shape) {
    case GP_FLARE_RING:
        s.radius = fmax(radius, 0.5);
        s.inner = fmin(s.radius * (1.0 - e->width), s.radius - 1.0);
        s.area = pi * (s.radius * s.radius - s.inner * fmax(s.inner, 0.0));
        break;
    case GP_FLARE_POLYGON:
        s.radius = fmax(radius, 0.5 / cos(half));
        s.inner = s.radius * cos(half);
        s.area = n * s.radius * s.radius * sin(half) * cos(half);
        break;
    case GP_FLARE_STREAK:
        s.radius = fmax(radius, 1.5); // half of it lies within 0.3
        s.inner = fmax(s.radius * e->width, 0.5);
        s.area = 4.0 / 3.0 * s.radius * s.inner; // of (1 - |t|)^2: 2/3
        break;
    default:
        s.radius = fmax(radius, 0.5);
        s.inner = -1.0;
        s.area = pi * (s.radius * s.radius + RAMP / 12.0);
    }
    return s;
}

static double largest_scale(const struct gp_flare_element *e)
{
    return (double) fmaxf(e->scale[0], fmaxf(e->scale[1], e->scale[2]));
}

static double least_scale(const struct gp_flare_element *e)
{
    return (double) fminf(e->scale[0], fminf(e->scale[1], e->scale[2]));
}

static bool is_dispersed(const struct gp_flare_element *e)
{
    return e->scale[0] != e->scale[1] || e->scale[1] != e->scale[2];
}

static double diameter_of(const struct gp_flare_element *e,
                          struct gp_rect display)
{
    return e->size * ((double) display.y1 - (double) display.y0);
}

/* -- reach ----------------------------------------------------------------- */

struct box {
    double x0, y0, x1, y1;
};

static void place_of(const struct gp_flare_element *e,
                     const struct gp_light *l, struct gp_rect display,
                     double *x, double *y)
{
    const double cx = 0.5 * ((double) display.x0 + (double) display.x1);
    const double cy = 0.5 * ((double) display.y0 + (double) display.y1);
    *x = l->x + e->at * (cx - l->x);
    *y = l->y + e->at * (cy - l->y);
}

/* Pixels of an image's texel; 1 for a plain one. */
static double texel_size(const struct gp_flare_element *e, double diameter)
{
    const int longer = e->image.w > e->image.h ? e->image.w : e->image.h;
    return e->plain ? 1.0 : fmax(diameter, 1.0) / (double) longer;
}

/* Around the place, from the image's corners and `more` texels beyond. */
static struct box image_box(const struct gp_flare_element *e, double texel,
                            double more)
{
    const double u[2] = {-more - e->image.cx, e->image.w + more - e->image.cx};
    const double v[2] = {-more - e->image.cy, e->image.h + more - e->image.cy};
    const double turn = e->plain ? 0.0 : e->rotation * pi / 180.0;
    const double c = cos(turn), s = sin(turn);
    struct box b = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 4; i++) {
        const double x = u[i & 1] * c + v[i >> 1] * s;
        const double y = v[i >> 1] * c - u[i & 1] * s;
        b = (struct box) {fmin(b.x0, x * texel), fmin(b.y0, y * texel),
                          fmax(b.x1, x * texel), fmax(b.y1, y * texel)};
    }
    return b;
}

/* Around the place, for the channel of the largest scale. */
static struct box box_of(const struct gp_flare_element *e, double diameter)
{
    const double largest = largest_scale(e);
    if (e->shape == GP_FLARE_IMAGE) {
        // half a texel of the level, which may be as much as two pixels;
        // whole pixels cover that of a plain one
        const double texel = texel_size(e, diameter * largest);
        const double spread = largest / least_scale(e);
        return image_box(e, texel, e->plain ? 0.0
                                            : 0.5 + spread * 2.0 / texel);
    }
    const struct shape s = shape_of(e, 0.5 * diameter * largest);
    double x = s.radius + 1.0, y = x;
    if (e->shape == GP_FLARE_STREAK) {
        const double turn = e->rotation * pi / 180.0;
        const double c = fabs(cos(turn)), d = fabs(sin(turn));
        x = c * (s.radius + 1.0) + d * (s.inner + 1.0);
        y = d * (s.radius + 1.0) + c * (s.inner + 1.0);
    }
    return (struct box) {-x, -y, x, y};
}

static int to_int(double v)
{
    return v < -FAR ? -FAR : v > FAR ? FAR : (int) v;
}

/* All pixels that the element may reach, in the frame or not. */
static struct gp_rect whole_reach(const struct gp_flare_element *e,
                                  const struct gp_light *l,
                                  struct gp_rect display)
{
    const bool none = e->shape == GP_FLARE_IMAGE &&
                      (e->image.w < 1 || e->image.h < 1);
    double x, y;
    place_of(e, l, display, &x, &y);
    if (l->behind || none || !isfinite(x) || !isfinite(y))
        return (struct gp_rect) {0};
    const struct box b = box_of(e, diameter_of(e, display));
    return (struct gp_rect) {
        to_int(floor(x + b.x0)), to_int(floor(y + b.y0)),
        to_int(ceil(x + b.x1)), to_int(ceil(y + b.y1)),
    };
}

struct gp_rect gp_flare_reach(const struct gp_flare_element *e,
                              const struct gp_light *l, struct gp_rect frame,
                              struct gp_rect display)
{
    return gp_rect_meet(whole_reach(e, l, display), frame);
}

/* -- images at half sizes, so that bilinear samples a pixel apart miss no texel */

/* Four texels' mean; those outside are 0. The picture keeps its corner, so a
 * place u in texels is u / 2. */
static void halve_plane(const struct gp_flare_image *in, int c, int w, int h,
                        float *out)
{
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            float sum = 0.0f;
            for (int j = 2 * y; j < in->h && j < 2 * y + 2; j++) {
                for (int i = 2 * x; i < in->w && i < 2 * x + 2; i++)
                    sum += in->rgb.c[c][(size_t) j * (size_t) in->w +
                                        (size_t) i];
            }
            out[(size_t) y * (size_t) w + (size_t) x] = 0.25f * sum;
        }
    }
}

static gp_status halve(const struct gp_log *log,
                       const struct gp_flare_image *in,
                       struct gp_flare_image *out)
{
    struct gp_flare_image half = {
        .w = (in->w + 1) / 2, .h = (in->h + 1) / 2, .cx = in->cx / 2.0,
        .cy = in->cy / 2.0, .serial = in->serial,
    };
    const gp_status st = gp_planes_make(log, "a flare image at half size",
                                        (size_t) half.w * (size_t) half.h,
                                        &half.rgb);
    if (st)
        return st;
    for (int c = 0; c < 3; c++)
        halve_plane(in, c, half.w, half.h, half.rgb.c[c]);
    *out = half;
    return GP_OK;
}

static void sum_up(struct gp_flare_level *l)
{
    const size_t n = (size_t) l->image.w * (size_t) l->image.h;
    for (int c = 0; c < 3; c++) {
        const float *const v = l->image.rgb.c[c];
        l->sum[c] = 0.0;
        for (size_t i = 0; i < n; i++)
            l->sum[c] += (double) v[i];
        l->luminance += l->sum[c] * (double) gp_rec709_luminance[c];
    }
    if (!(l->luminance > 0.0) || !isfinite(l->luminance))
        l->luminance = 0.0;
}

static gp_status level_make(const struct gp_log *log,
                              const struct gp_flare_image *image, double size,
                              struct gp_flare_level *out)
{
    struct gp_flare_level l = {.image = *image};
    sum_up(&l);
    double longer = image->w > image->h ? image->w : image->h;
    gp_status st = GP_OK;
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

static void level_free(struct gp_flare_level *l)
{
    if (l->level > 0)
        gp_planes_free(&l->image.rgb);
    *l = (struct gp_flare_level) {0};
}

/* -- items ----------------------------------------------------------------- */

/* What an item is made from. */
struct making {
    const struct gp_flare_element *e;
    const struct gp_light *light;
    const struct gp_flare_level *level;
    struct gp_rect whole, frame;
    double diameter;
};

static void put_rect(struct gp_flare_quad *i, struct gp_rect rect)
{
    i->rect = rect;
    i->base[0] = (float) ((double) rect.x0 + 0.5 - i->x);
    i->base[1] = (float) ((double) rect.y0 + 0.5 - i->y);
    if (!i->plain)
        return;
    const double q[2] = {rect.x0 - i->x + i->image->cx,
                         rect.y0 - i->y + i->image->cy};
    for (int k = 0; k < 2; k++) {
        i->corner[k] = (int) floor(q[k]);
        i->fraction[k] = (float) (q[k] - floor(q[k]));
    }
}

/* Sum over all pixels of what channel c draws with an amount of 1. */
static double sum_of(const struct gp_flare_quad *item, struct gp_rect whole,
                     int c)
{
    struct gp_flare_quad i = *item;
    double sum = 0.0;
    put_rect(&i, whole);
    for (int y = whole.y0; y < whole.y1; y++) {
        float row[4 * SUMMED] = {0};
        int x0, x1;
        if (!gp_flare_span(&i, y, y + 1, &x0, &x1))
            continue;
        gp_flare_add_row(&i, c, y, x0, x1, 1.0f, row);
        for (int x = 0; x < x1 - x0; x++)
            sum += (double) row[x];
    }
    return sum;
}

static bool is_summed(const struct making *m, double scale)
{
    return m->diameter * scale <= SUMMED &&
           gp_rect_w(m->whole) <= 4 * SUMMED &&
           gp_rect_h(m->whole) <= 4 * SUMMED;
}

static double light_of(const struct making *m, int c)
{
    return (double) m->e->colour[c] * (double) m->light->flux[c];
}

static void measure_shape(const struct making *m, struct gp_flare_quad *i)
{
    double area[3] = {0};
    for (int c = 0; c < 3; c++) {
        const double scale = (double) m->e->scale[c];
        const struct shape s = shape_of(m->e, 0.5 * m->diameter * scale);
        i->radius[c] = (float) s.radius;
        i->inner[c] = (float) s.inner;
        area[c] = s.area;
        if (c > 0 && i->radius[c] == i->radius[c - 1])
            area[c] = area[c - 1];
        else if (is_summed(m, scale))
            area[c] = sum_of(i, m->whole, c);
        i->amount[c] = area[c] > 0.0 ? (float) (light_of(m, c) / area[c])
                                     : 0.0f;
    }
}

/* Amounts of the channels in [first, end), which have one scale. */
static void measure_image(const struct making *m, struct gp_flare_quad *i,
                          int first, int end)
{
    const struct gp_flare_level *const l = m->level;
    const double scale = (double) m->e->scale[first];
    const double of_level = ldexp(texel_size(m->e, m->diameter * scale),
                                  l->level); // pixels of its texel
    i->radius[0] = (float) (1.0 / of_level);
    i->inner[0] = (float) l->image.cx;
    i->inner[1] = (float) l->image.cy;
    for (int c = first; c < end; c++) {
        const double even = ldexp(l->sum[c], -2 * l->level) * of_level *
                            of_level;
        const double sum = is_summed(m, scale) ? sum_of(i, m->whole, c) : even;
        const double fit = sum > 0.5 * even && sum < 2.0 * even ? even / sum
                                                                : 1.0;
        if (l->luminance > 0.0 && even > 0.0)
            i->amount[c] = (float) (light_of(m, c) * fit * l->sum[c] /
                                    (l->luminance * even));
    }
}

static void measure(const struct making *m, struct gp_flare_quad *i, int first,
                    int end)
{
    if (i->plain)
        memcpy(i->amount, m->light->flux, sizeof i->amount);
    else if (i->image)
        measure_image(m, i, first, end);
    else
        measure_shape(m, i);
}

/* Adds an item for channels [first, end), unless it is dark. */
static void add_item(struct gp_flare_quads *items, const struct making *m,
                     int element, int light, struct gp_rect display, int first,
                     int end)
{
    const double turn = m->e->rotation * pi / 180.0;
    struct gp_flare_quad i = {
        .shape = m->e->shape, .plain = m->e->plain && m->level,
        .element = element, .light = light,
        .turn = {(float) cos(turn), (float) sin(turn)},
        .sides = m->e->sides, .edge = items->edge + GP_FLARE_EDGE * element,
        .image = m->level ? &m->level->image : NULL,
    };
    place_of(m->e, m->light, display, &i.x, &i.y);
    put_rect(&i, gp_rect_meet(m->whole, m->frame));
    measure(m, &i, first, end);
    if (i.amount[0] != 0.0f || i.amount[1] != 0.0f || i.amount[2] != 0.0f)
        items->at[items->n++] = i;
}

/* `clear`: hidden lights have none. */
static int items_of(const struct gp_flare_element *e, const struct gp_light *l,
                    bool clear, struct gp_rect frame, struct gp_rect display)
{
    const bool dark = l->flux[0] <= 0.0f && l->flux[1] <= 0.0f &&
                      l->flux[2] <= 0.0f;
    if (dark || (clear && !(l->visibility > 0.0)) ||
        gp_rect_empty(gp_flare_reach(e, l, frame, display)))
        return 0;
    return e->shape == GP_FLARE_IMAGE && !e->plain && is_dispersed(e) ? 3 : 1;
}

/* -- the whole list -------------------------------------------------------- */

static void fill_edges(const struct gp_flare_element *e, float *edge)
{
    for (int i = 0; e->shape == GP_FLARE_POLYGON && i < e->sides; i++) {
        const double a = e->rotation * pi / 180.0 +
                         (i + 0.5) * 2.0 * pi / e->sides;
        const double x = cos(a), y = -sin(a); // counter-clockwise, y down
        edge[3 * i] = (float) x;
        edge[3 * i + 1] = (float) y;
        edge[3 * i + 2] = (float) (1.0 / fmax(fabs(x), fabs(y)));
    }
}

/* Edges of all polygons, and images at the sizes that they are drawn in. */
static gp_status prepare(const struct gp_log *log, const struct gp_flare *f,
                         struct gp_rect display, struct gp_flare_quads *items)
{
    void *edge, *level;
    gp_status st = gp_alloc_zero(log, "flare polygons", (size_t) f->n,
                                 GP_FLARE_EDGE * sizeof(float), &edge);
    if (st)
        return st;
    items->edge = edge;
    st = gp_alloc_zero(log, "flare images", (size_t) f->n,
                       sizeof *items->level, &level);
    if (st)
        return st;
    items->level = level;
    items->elements = f->n;
    for (int i = 0; !st && i < f->n; i++) {
        const struct gp_flare_element *const e = &f->element[i];
        fill_edges(e, items->edge + GP_FLARE_EDGE * i);
        if (e->shape != GP_FLARE_IMAGE || e->image.w < 1 || e->image.h < 1)
            continue;
        if (e->plain)
            items->level[i].image = e->image;
        else
            st = level_make(
                log, &e->image, fmax(diameter_of(e, display) * least_scale(e),
                                     1.0), &items->level[i]);
    }
    return st;
}

static void fill(const struct gp_flare *f, const struct gp_light *light, int n,
                 bool clear, struct gp_rect frame, struct gp_rect display,
                 struct gp_flare_quads *items)
{
    for (int l = 0; l < n; l++) {
        for (int k = 0; k < f->n; k++) {
            const struct gp_flare_element *const e = &f->element[k];
            const int parts = items_of(e, &light[l], clear, frame,
                                       display);
            const bool image = e->shape == GP_FLARE_IMAGE;
            const struct making m = {
                .e = e, .light = &light[l],
                .level = image ? &items->level[k] : NULL,
                .whole = whole_reach(e, &light[l], display), .frame = frame,
                .diameter = diameter_of(e, display),
            };
            for (int i = 0; i < parts; i++)
                add_item(items, &m, k, l, display, i, parts == 1 ? 3 : i + 1);
        }
    }
}

gp_status gp_flare_quads_make(const struct gp_log *log,
                              const struct gp_flare *f,
                              const struct gp_light *light, int n,
                              bool clear, struct gp_rect frame,
                              struct gp_rect display,
                              struct gp_flare_quads *out)
{
    *out = (struct gp_flare_quads) {0};
    size_t most = 0;
    for (int l = 0; l < n; l++) {
        for (int k = 0; k < f->n; k++)
            most += (size_t) items_of(&f->element[k], &light[l], clear,
                                      frame, display);
    }
    if (most == 0)
        return GP_OK;
    void *at;
    gp_status st = gp_alloc(log, "flare of the lights", most, sizeof *out->at,
                            &at);
    if (st)
        return st;
    out->at = at;
    st = prepare(log, f, display, out);
    if (!st)
        fill(f, light, n, clear, frame, display, out);
    return st;
}

void gp_flare_quads_free(struct gp_flare_quads *items)
{
    for (int i = 0; i < items->elements; i++)
        level_free(&items->level[i]);
    gp_free(items->at);
    gp_free(items->edge);
    gp_free(items->level);
    *items = (struct gp_flare_quads) {0};
}

enum { MOST_ELEMENTS = 1024 };

static const char *const shapes[] = {"disc", "ring", "polygon", "streak",
                                     "image", NULL};

#define COMMON_KEYS "shape", "position", "size", "color", "rotation", "scale"
static const char *const all_keys[] = {COMMON_KEYS, "width", "sides", "image",
                                       NULL};
static const char *const disc_keys[] = {COMMON_KEYS, NULL};
static const char *const width_keys[] = {COMMON_KEYS, "width", NULL};
static const char *const polygon_keys[] = {COMMON_KEYS, "sides", NULL};
static const char *const image_keys[] = {COMMON_KEYS, "image", NULL};

/* By shape: a key that a shape does not use is an error, not ignored. */
static const char *const *const keys_of[] = {
    [GP_FLARE_DISC] = disc_keys,       [GP_FLARE_RING] = width_keys,
    [GP_FLARE_POLYGON] = polygon_keys, [GP_FLARE_STREAK] = width_keys,
    [GP_FLARE_IMAGE] = image_keys,
};

/* -- one element ----------------------------------------------------------- */

/* The shape, and that no key is unknown, or of another shape. */
static gp_status read_shape(const struct gp_json_place *p, json_t *o,
                            enum gp_flare_shape *out)
{
    int shape = 0;
    bool found = false;
    gp_status st = gp_json_keys(p, o, all_keys);
    if (!st)
        st = gp_json_choice(p, o, "shape", shapes, &shape, &found);
    if (!st && !found)
        st = gp_fail(p->log, GP_ERR_DATA,
                     "%s: %s %d: no shape; add \"shape\": disc, ring, polygon, "
                     "streak or image", p->path, p->what, p->index);
    *out = (enum gp_flare_shape) shape;
    return st ? st : gp_json_keys(p, o, keys_of[shape]);
}

static gp_status read_floats(const struct gp_json_place *p, json_t *o,
                             const char *key, bool grey, double lo, double hi,
                             float out[3])
{
    double v[3] = {(double) out[0], (double) out[1], (double) out[2]};
    const gp_status st = gp_json_numbers(p, o, key, 3, grey, lo, hi, v, NULL);
    for (int c = 0; c < 3; c++)
        out[c] = (float) v[c];
    return st;
}

/* A name beside the JSON file, unless it is absolute. */
static gp_status resolve(const struct gp_json_place *p, const char *name,
                         char **out)
{
    const char *const slash = strrchr(p->path, '/');
    const size_t folder = name[0] != '/' && slash
                              ? (size_t) (slash - p->path) + 1 : 0;
    const size_t bytes = folder + strlen(name) + 1;
    void *path;
    const gp_status st = gp_alloc(p->log, "a flare image's path", bytes, 1,
                                  &path);
    if (st)
        return st;
    memcpy(path, p->path, folder);
    memcpy((char *) path + folder, name, bytes - folder);
    *out = path;
    return GP_OK;
}

static gp_status read_image(const struct gp_json_place *p, json_t *o,
                            char **out)
{
    const char *name = NULL;
    bool found = false;
    const gp_status st = gp_json_text(p, o, "image", &name, &found);
    if (st)
        return st;
    if (!found || !*name)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: %s %d: no image; add \"image\": its file",
                       p->path, p->what, p->index);
    return resolve(p, name, out);
}

static gp_status read_element(const struct gp_json_place *p, json_t *o,
                              struct gp_flare_element *e)
{
    *e = (struct gp_flare_element) {
        .size = 0.1, .width = 0.1, .sides = 6,
        .colour = {0.01f, 0.01f, 0.01f}, .scale = {1.0f, 1.0f, 1.0f},
    };
    gp_status st;
    GP_TRY(read_shape(p, o, &e->shape));
    if (e->shape == GP_FLARE_STREAK)
        e->width = 0.01;
    GP_TRY(gp_json_number(p, o, "position", -10.0, 10.0, &e->at, NULL));
    GP_TRY(gp_json_number(p, o, "size", 0.0, 10.0, &e->size, NULL));
    GP_TRY(gp_json_number(p, o, "rotation", -36000.0, 36000.0, &e->rotation,
                          NULL));
    GP_TRY(gp_json_number(p, o, "width", 1e-6, 1.0, &e->width, NULL));
    GP_TRY(gp_json_int(p, o, "sides", 3, 64, &e->sides, NULL));
    GP_TRY(read_floats(p, o, "color", true, 0.0, 1e6, e->colour));
    GP_TRY(read_floats(p, o, "scale", false, 0.01, 100.0, e->scale));
    if (e->shape == GP_FLARE_IMAGE)
        GP_TRY(read_image(p, o, &e->path));
out:
    return st;
}

/* -- the file -------------------------------------------------------------- */

gp_status gp_flare_read(const struct gp_log *log, const char *path,
                        struct gp_flare *out)
{
    struct gp_json_place place = {log, path, "element", 0};
    struct gp_flare f = {0};
    json_t *root = NULL, *array = NULL;
    void *elements = NULL;
    gp_status st;
    GP_TRY(gp_json_read(log, path, &root));
    GP_TRY(gp_json_array(&place, root, "elements", MOST_ELEMENTS, &array));
    const int n = (int) json_array_size(array);
    GP_TRY(gp_alloc_zero(log, "flare elements", n ? (size_t) n : 1,
                         sizeof *f.element, &elements));
    f.element = elements;
    while (f.n < n) {
        json_t *const o = json_array_get(array, (size_t) f.n);
        place.index = ++f.n;
        GP_TRY(read_element(&place, o, &f.element[place.index - 1]));
    }
    *out = f;
    f = (struct gp_flare) {0};
out:
    json_decref(root);
    gp_flare_free(&f);
    return st;
}

void gp_flare_free(struct gp_flare *f)
{
    for (int i = 0; i < f->n; i++) {
        gp_free(f->element[i].path);
        gp_planes_free(&f->element[i].image.rgb);
    }
    GP_FREE(f->element);
    *f = (struct gp_flare) {0};
}
