/* Flare elements: read from JSON, placed and measured for the lights of a
 * frame, and added to a layer on the CPU. */
#include "sun/sun_priv.h"

#include "core/colour.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "core/json.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Mean over all directions of m squared: an edge's ramp has variance m^2 / 12,
 * which adds to the area inside of a round one. */
#define RAMP (0.5 + 1.0 / pi)

/* Elements up to so many pixels across are summed, not integrated: the sum over
 * pixels of a small shape depends on its place. Above, the two differ by
 * less than 1e-3. */
enum { SUMMED = 128 };

// -- sizes -------------------------------------------------------------------

/* Shape of one channel, in pixels. */
struct shape {
    double radius, inner, area;
};

/* Clamps sizes: no element is under a pixel across, no ring or streak under a
 * pixel wide. */
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

static double least_scale(const struct gp_flare_element *e)
{
    return (double) fminf(e->scale[0], fminf(e->scale[1], e->scale[2]));
}

static double diameter_of(const struct gp_flare_element *e,
                          struct gp_rect display)
{
    return e->size * ((double) display.y1 - (double) display.y0);
}

/* Pixels of an image's texel; 1 for a plain one. */
static double texel_size(const struct gp_flare_element *e, double diameter)
{
    const int longer = e->image.w > e->image.h ? e->image.w : e->image.h;
    return e->plain ? 1.0 : fmax(diameter, 1.0) / (double) longer;
}

// -- reach -------------------------------------------------------------------

struct box {
    double x0, y0, x1, y1;
};

/* Around the place, for the channel of the largest scale. */
static struct box box_of(const struct gp_flare_element *e, double diameter)
{
    const double largest =
        (double) fmaxf(e->scale[0], fmaxf(e->scale[1], e->scale[2]));
    const double angle = e->plain ? 0.0 : e->rotation * pi / 180.0;
    if (e->shape != GP_FLARE_IMAGE) {
        const struct shape s = shape_of(e, 0.5 * diameter * largest);
        double x = s.radius + 1.0, y = x;
        if (e->shape == GP_FLARE_STREAK) {
            const double c = fabs(cos(angle)), d = fabs(sin(angle));
            x = c * (s.radius + 1.0) + d * (s.inner + 1.0);
            y = d * (s.radius + 1.0) + c * (s.inner + 1.0);
        }
        return (struct box) {-x, -y, x, y};
    }
    // half a texel of the level, which may be as much as two pixels, beyond the
    // corners; whole pixels cover that of a plain one
    const double texel = texel_size(e, diameter * largest);
    const double more = e->plain ? 0.0
                                 : 0.5 + largest / least_scale(e) * 2.0 / texel;
    const double u[2] = {-more - e->image.cx, e->image.w + more - e->image.cx};
    const double v[2] = {-more - e->image.cy, e->image.h + more - e->image.cy};
    const double c = cos(angle), s = sin(angle);
    struct box b = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 4; i++) {
        const double x = u[i & 1] * c + v[i >> 1] * s;
        const double y = v[i >> 1] * c - u[i & 1] * s;
        b = (struct box) {fmin(b.x0, x * texel), fmin(b.y0, y * texel),
                          fmax(b.x1, x * texel), fmax(b.y1, y * texel)};
    }
    return b;
}

static void place_of(const struct gp_flare_element *e, const struct gp_light *l,
                     struct gp_rect display, double *x, double *y)
{
    const double cx = 0.5 * ((double) display.x0 + (double) display.x1);
    const double cy = 0.5 * ((double) display.y0 + (double) display.y1);
    *x = l->x + e->at * (cx - l->x);
    *y = l->y + e->at * (cy - l->y);
}

static int to_pixel(double v)
{
    enum { FAR = 1 << 30 }; // no window goes beyond
    return v < -FAR ? -FAR : v > FAR ? FAR : (int) v;
}

/* Finds all pixels that the element may reach, inside the frame or not. */
static struct gp_rect whole_reach(const struct gp_flare_element *e,
    const struct gp_light *l, struct gp_rect display)
{
    const bool none = e->shape == GP_FLARE_IMAGE &&
                      (e->image.w < 1 || e->image.h < 1);
    double x, y;
    place_of(e, l, display, &x, &y);
    if (l->behind || none || !isfinite(x) || !isfinite(y))
        return (struct gp_rect) {0};
    const struct box b = box_of(e, diameter_of(e, display));
    return (struct gp_rect) {
        to_pixel(floor(x + b.x0)), to_pixel(floor(y + b.y0)),
        to_pixel(ceil(x + b.x1)), to_pixel(ceil(y + b.y1)),
    };
}

struct gp_rect gp_flare_reach(const struct gp_flare_element *e,
    const struct gp_light *l, struct gp_rect frame, struct gp_rect display)
{
    return gp_rect_meet(whole_reach(e, l, display), frame);
}

/* Each texel is the mean of four; those outside are 0. The picture keeps its
 * corner, so a place u in texels is u / 2. */
static gp_status halve(const struct gp_log *log,
    const struct gp_flare_image *in, struct gp_flare_image *out)
{
    const int w = (in->w + 1) / 2, h = (in->h + 1) / 2;
    *out = (struct gp_flare_image) {.w = w, .h = h, .cx = in->cx / 2.0,
                                    .cy = in->cy / 2.0, .serial = in->serial};
    const gp_status st = gp_planes_make(log, "a flare image at half size",
                                        (size_t) w * (size_t) h, &out->rgb);
    for (int c = 0; !st && c < 3; c++) {
        float *to = out->rgb.c[c];
        for (int y = 0; y < h; y++) {
            for (int x = 0; x < w; x++) {
                float sum = 0.0f;
                for (int j = 2 * y; j < in->h && j < 2 * y + 2; j++) {
                    for (int i = 2 * x; i < in->w && i < 2 * x + 2; i++)
                        sum += in->rgb.c[c][(size_t) j * (size_t) in->w +
                                            (size_t) i];
                }
                *to++ = 0.25f * sum;
            }
        }
    }
    return st;
}

/* The level at which `size` of the longer side in pixels is not under a pixel
 * a texel, with its sums. Errors: GP_ERR_BUG memory. */
static gp_status make_level(const struct gp_log *log,
    const struct gp_flare_image *image, double size, struct gp_flare_level *out)
{
    const size_t n = (size_t) image->w * (size_t) image->h;
    double longer = image->w > image->h ? image->w : image->h;
    struct gp_flare_level l = {.image = *image};
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

// -- quads -------------------------------------------------------------------

/* One element of one light, of which quads are made. */
struct pair {
    const struct gp_flare_element *e;
    const struct gp_light *light;
    const struct gp_flare_level *level; // of an image, else NULL
    struct gp_rect whole, frame;
    double diameter;
};

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

/* Returns the sum over all pixels of channel c drawn with an amount of 1. */
static double sum_of(const struct gp_flare_quad *quad, struct gp_rect whole,
                     int c)
{
    struct gp_flare_quad q = *quad;
    double sum = 0.0;
    place_quad(&q, whole);
    for (int y = whole.y0; y < whole.y1; y++) {
        float row[4 * SUMMED] = {0};
        int x0, x1;
        if (!gp_flare_span(&q, y, y + 1, &x0, &x1))
            continue;
        gp_flare_add_row(&q, c, y, x0, x1, 1.0f, row);
        for (int x = 0; x < x1 - x0; x++)
            sum += (double) row[x];
    }
    return sum;
}

static bool is_summed(const struct pair *p, double scale)
{
    return p->diameter * scale <= SUMMED && gp_rect_w(p->whole) <= 4 * SUMMED &&
        gp_rect_h(p->whole) <= 4 * SUMMED;
}

static double light_of(const struct pair *p, int c)
{
    return (double) p->e->colour[c] * (double) p->light->flux[c];
}

/* Adds a quad for channels [first, end), unless it is dark. */
static void add_quad(struct gp_flare_quads *quads, const struct pair *p,
    int element, int light, struct gp_rect display, int first, int end)
{
    const double angle = p->e->rotation * pi / 180.0;
    struct gp_flare_quad q = {
        .shape = p->e->shape, .plain = p->e->plain && p->level,
        .element = element, .light = light,
        .turn = {(float) cos(angle), (float) sin(angle)},
        .sides = p->e->sides, .edge = quads->edge + GP_FLARE_EDGE * element,
        .image = p->level ? &p->level->image : NULL,
    };
    place_of(p->e, p->light, display, &q.x, &q.y);
    place_quad(&q, gp_rect_meet(p->whole, p->frame));
    if (q.plain) {
        memcpy(q.amount, p->light->flux, sizeof q.amount);
    } else if (q.image) { // its channels have one scale
        const struct gp_flare_level *const l = p->level;
        const double scale = (double) p->e->scale[first];
        const double of_level = ldexp(texel_size(p->e, p->diameter * scale),
                                      l->level); // pixels of its texel
        q.radius[0] = (float) (1.0 / of_level);
        q.inner[0] = (float) l->image.cx;
        q.inner[1] = (float) l->image.cy;
        for (int c = first; c < end; c++) {
            const double even = ldexp(l->sum[c], -2 * l->level) * of_level *
                                of_level;
            const double sum = is_summed(p, scale) ? sum_of(&q, p->whole, c)
                                                   : even;
            const double fit = sum > 0.5 * even && sum < 2.0 * even
                                   ? even / sum : 1.0;
            if (l->luminance > 0.0 && even > 0.0)
                q.amount[c] = (float) (light_of(p, c) * fit * l->sum[c] /
                                       (l->luminance * even));
        }
    } else {
        double area = 0.0; // of a channel; equal ones have the last one's
        for (int c = 0; c < 3; c++) {
            const double scale = (double) p->e->scale[c];
            const struct shape s = shape_of(p->e, 0.5 * p->diameter * scale);
            q.radius[c] = (float) s.radius;
            q.inner[c] = (float) s.inner;
            if (c == 0 || q.radius[c] != q.radius[c - 1])
                area = is_summed(p, scale) ? sum_of(&q, p->whole, c) : s.area;
            q.amount[c] = area > 0.0 ? (float) (light_of(p, c) / area) : 0.0f;
        }
    }
    if (q.amount[0] != 0.0f || q.amount[1] != 0.0f || q.amount[2] != 0.0f)
        quads->at[quads->n++] = q;
}

/* Counts the quads of an element of a light; `clear`: none for hidden ones. */
static int quads_of(const struct gp_flare_element *e, const struct gp_light *l,
                    bool clear, struct gp_rect frame, struct gp_rect display)
{
    const bool dark = l->flux[0] <= 0.0f && l->flux[1] <= 0.0f &&
                      l->flux[2] <= 0.0f;
    if (dark || e->source != GP_FLARE_LIGHTS || (clear && !(l->visibility > 0.0)) ||
        gp_rect_empty(gp_flare_reach(e, l, frame, display)))
        return 0;
    const bool dispersed = e->scale[0] != e->scale[1] ||
                           e->scale[1] != e->scale[2];
    return e->shape == GP_FLARE_IMAGE && !e->plain && dispersed ? 3 : 1;
}

gp_status gp_flare_quads_make(const struct gp_log *log,
    const struct gp_flare *f, const struct gp_light *light, int n, bool clear,
    struct gp_rect frame, struct gp_rect display, struct gp_flare_quads *out)
{
    size_t most = 0;
    gp_status st;
    *out = (struct gp_flare_quads) {0};
    for (int l = 0; l < n; l++) {
        for (int k = 0; k < f->n; k++)
            most += (size_t) quads_of(&f->element[k], &light[l], clear, frame,
                                      display);
    }
    if (most == 0)
        return GP_OK;
    GP_TRY(gp_alloc(log, "flare of the lights", most, sizeof *out->at,
                    &out->at));
    GP_TRY(gp_alloc_zero(log, "flare polygons", (size_t) f->n,
                         GP_FLARE_EDGE * sizeof(float), &out->edge));
    GP_TRY(gp_alloc_zero(log, "flare images", (size_t) f->n,
                         sizeof *out->level, &out->level));
    out->elements = f->n;
    // edges of all polygons, and images at the sizes that they are drawn in
    for (int k = 0; k < f->n; k++) {
        const struct gp_flare_element *const e = &f->element[k];
        float *const edge = out->edge + GP_FLARE_EDGE * k;
        for (int i = 0; e->shape == GP_FLARE_POLYGON && i < e->sides; i++) {
            const double a = e->rotation * pi / 180.0 +
                             (i + 0.5) * 2.0 * pi / e->sides;
            const double x = cos(a), y = -sin(a); // counter-clockwise, y down
            edge[3 * i] = (float) x;
            edge[3 * i + 1] = (float) y;
            edge[3 * i + 2] = (float) (1.0 / fmax(fabs(x), fabs(y)));
        }
        if (e->shape != GP_FLARE_IMAGE || e->image.w < 1 || e->image.h < 1)
            continue;
        if (e->plain)
            out->level[k].image = e->image;
        else
            GP_TRY(make_level(log, &e->image,
                              fmax(diameter_of(e, display) * least_scale(e),
                                   1.0), &out->level[k]));
    }
    for (int l = 0; l < n; l++) {
        for (int k = 0; k < f->n; k++) {
            const struct gp_flare_element *const e = &f->element[k];
            const int quads = quads_of(e, &light[l], clear, frame, display);
            const bool image = e->shape == GP_FLARE_IMAGE;
            const struct pair p = {
                .e = e, .light = &light[l],
                .level = image ? &out->level[k] : NULL,
                .whole = whole_reach(e, &light[l], display), .frame = frame,
                .diameter = diameter_of(e, display),
            };
            for (int i = 0; i < quads; i++)
                add_quad(out, &p, k, l, display, i, quads == 1 ? 3 : i + 1);
        }
    }
out:
    return st;
}

void gp_flare_quads_free(struct gp_flare_quads *quads)
{
    for (int i = 0; i < quads->elements; i++) {
        if (quads->level[i].level > 0)
            gp_planes_free(&quads->level[i].image.rgb);
    }
    gp_free(quads->at);
    gp_free(quads->edge);
    gp_free(quads->level);
    *quads = (struct gp_flare_quads) {0};
}

enum { ROWS = 16 }; // of a task

struct adding {
    const struct gp_flare_quads *quads;
    const struct gp_light *light;
    struct gp_rect frame;
    struct gp_planes *layer;
};

static void add_rows(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_rect f = a->frame;
    const int y0 = f.y0 + i * ROWS;
    const int y1 = f.y1 - y0 < ROWS ? f.y1 : y0 + ROWS;
    (void) thread;
    for (int k = 0; k < a->quads->n; k++) {
        const struct gp_flare_quad *const q = &a->quads->at[k];
        const float visible = (float) a->light[q->light].visibility;
        int x0, x1;
        if (q->rect.y0 >= y1 || q->rect.y1 <= y0)
            continue;
        for (int y = y0; y < y1; y++) {
            if (!gp_flare_span(q, y, y + 1, &x0, &x1))
                continue;
            const size_t at = (size_t) (y - f.y0) * (size_t) gp_rect_w(f) +
                              (size_t) (x0 - f.x0);
            for (int c = 0; c < 3; c++) {
                if (q->amount[c] != 0.0f)
                    gp_flare_add_row(q, c, y, x0, x1, q->amount[c] * visible,
                                     a->layer->c[c] + at);
            }
        }
    }
}

gp_status gp_flare_add(const struct gp_log *log, const struct gp_flare *f,
    const struct gp_light *light, int n, struct gp_rect frame,
    struct gp_rect display, struct gp_planes *layer)
{
    struct gp_flare_quads quads = {0};
    gp_status st = gp_flare_quads_make(log, f, light, n, true, frame, display,
                                       &quads);
    if (!st && quads.n > 0) {
        struct adding a = {&quads, light, frame, layer};
        gp_parallel_do((gp_rect_h(frame) + ROWS - 1) / ROWS, add_rows, &a);
    }
    gp_flare_quads_free(&quads);
    return st;
}

// -- reading -----------------------------------------------------------------

#define COMMON_KEYS \
    "shape", "position", "size", "color", "rotation", "scale", "source"
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

static gp_status read_floats(const struct gp_json_place *p, json_t *o,
    const char *key, bool grey, double lo, double hi, float out[3])
{
    double v[3] = {(double) out[0], (double) out[1], (double) out[2]};
    const gp_status st = gp_json_numbers(p, o, key, 3, grey, lo, hi, v, NULL);
    for (int c = 0; c < 3; c++)
        out[c] = (float) v[c];
    return st;
}

static gp_status read_source(const struct gp_json_place *p, json_t *o,
                             enum gp_flare_source *out)
{
    static const char *const names[] = {"lights", "bright", NULL};
    int source = (int) *out;
    const gp_status st = gp_json_choice(p, o, "source", names, &source, NULL);
    *out = (enum gp_flare_source) source;
    return st;
}

static gp_status read_element(const struct gp_json_place *p, json_t *o,
    enum gp_flare_source source, struct gp_flare_element *e)
{
    static const char *const shapes[] = {"disc", "ring", "polygon", "streak",
                                         "image", NULL};
    const char *name = NULL;
    int shape = 0;
    bool found = false;
    gp_status st;
    *e = (struct gp_flare_element) {
        .source = source, .size = 0.1, .width = 0.1, .sides = 6,
        .colour = {0.01f, 0.01f, 0.01f}, .scale = {1.0f, 1.0f, 1.0f},
    };
    GP_TRY(gp_json_keys(p, o, all_keys));
    GP_TRY(gp_json_choice(p, o, "shape", shapes, &shape, &found));
    if (!found)
        GP_TRY(gp_fail(p->log, GP_ERR_DATA,
               "%s: %s %d: no shape; add \"shape\": disc, ring, "
               "polygon, streak or image", p->path, p->what, p->index));
    GP_TRY(gp_json_keys(p, o, keys_of[shape]));
    e->shape = (enum gp_flare_shape) shape;
    if (e->shape == GP_FLARE_STREAK)
        e->width = 0.01;
    GP_TRY(read_source(p, o, &e->source));
    GP_TRY(gp_json_number(p, o, "position", -10.0, 10.0, &e->at, NULL));
    GP_TRY(gp_json_number(p, o, "size", 0.0, 10.0, &e->size, NULL));
    GP_TRY(gp_json_number(p, o, "rotation", -36000.0, 36000.0, &e->rotation,
                          NULL));
    GP_TRY(gp_json_number(p, o, "width", 1e-6, 1.0, &e->width, NULL));
    GP_TRY(gp_json_int(p, o, "sides", 3, 64, &e->sides, NULL));
    GP_TRY(read_floats(p, o, "color", true, 0.0, 1e6, e->colour));
    GP_TRY(read_floats(p, o, "scale", false, 0.01, 100.0, e->scale));
    if (e->shape != GP_FLARE_IMAGE)
        return GP_OK;
    // the path of an image: beside the JSON file, unless it is absolute
    GP_TRY(gp_json_text(p, o, "image", &name, &found));
    if (!found || !*name)
        GP_TRY(gp_fail(p->log, GP_ERR_DATA,
                       "%s: %s %d: no image; add \"image\": its file",
                       p->path, p->what, p->index));
    const char *const slash = strrchr(p->path, '/');
    const size_t folder = name[0] != '/' && slash
                              ? (size_t) (slash - p->path) + 1 : 0;
    const size_t bytes = folder + strlen(name) + 1;
    GP_TRY(gp_alloc(p->log, "a flare image's path", bytes, 1, &e->path));
    memcpy(e->path, p->path, folder);
    memcpy(e->path + folder, name, bytes - folder);
out:
    return st;
}

gp_status gp_flare_read(const struct gp_log *log, const char *path,
                        struct gp_flare *out)
{
    enum { MOST_ELEMENTS = 1024 };
    static const char *const keys[] = {"elements", "source", NULL};
    struct gp_json_place place = {log, path, "element", 0};
    enum gp_flare_source source = GP_FLARE_LIGHTS;
    struct gp_flare f = {0};
    json_t *root = NULL, *array = NULL;
    gp_status st;
    GP_TRY(gp_json_read(log, path, GP_JSON_SMALL, &root));
    GP_TRY(gp_json_array(&place, root, "elements", MOST_ELEMENTS, &array));
    if (json_is_object(root)) {
        GP_TRY(gp_json_keys(&place, root, keys));
        GP_TRY(read_source(&place, root, &source));
    }
    f.path = gp_strdup(path);
    if (!f.path)
        GP_TRY(gp_no_memory(log, path));
    const int n = (int) json_array_size(array);
    GP_TRY(gp_alloc_zero(log, "flare elements", n ? (size_t) n : 1,
                         sizeof *f.element, &f.element));
    while (f.n < n) {
        json_t *const o = json_array_get(array, (size_t) f.n);
        place.index = ++f.n;
        GP_TRY(read_element(&place, o, source, &f.element[place.index - 1]));
    }
    *out = f;
    f = (struct gp_flare) {0};
out:
    json_decref(root);
    gp_flare_free(&f);
    return st;
}

bool gp_flare_has(const struct gp_flare *f, enum gp_flare_source source)
{
    for (int i = 0; i < f->n; i++) {
        if (f->element[i].source == source)
            return true;
    }
    return false;
}

void gp_flare_free(struct gp_flare *f)
{
    for (int i = 0; i < f->n; i++) {
        gp_free(f->element[i].path);
        gp_planes_free(&f->element[i].image.rgb);
    }
    gp_free(f->element);
    gp_free(f->path);
    *f = (struct gp_flare) {0};
}
