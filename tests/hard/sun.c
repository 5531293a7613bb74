/* Every way to find a sun's visibility over the hard cases: depth alone, a mask
 * alone, both, and every way to count what lies outside the frame; against
 * plain sums over pixels that were told which of them hide the sun. */
#include "hardcases.h"

#include "core/parallel.h"
#include "gl/gl.h"
#include "sun/exact.h"
#include "sun/map.h"

enum { WITH_DEPTH = 1, WITH_MASK = 2, PLANES = 4, MODES = 3, PATTERNS = 2 };

static const struct gp_rect nowhere = {0, 0, 0, 0};

/* A frame whose planes cover the data window. */
struct sky {
    struct gp_rect data;
    float *depth, *mask;
    bool *surface;        // the truth of depth
    enum gp_depth_type type;
    struct gp_plane plane[2];
};

// -- planes -------------------------------------------------------------------

static uint32_t hash_of(int x, int y)
{
    uint32_t h = (uint32_t) x * 2654435761u ^ (uint32_t) y * 2246822519u;
    h = (h ^ h >> 15) * 3266489917u;
    return h ^ h >> 13;
}

/* A depth sample: of a surface at distance d in [5, 25), or of none. */
static float depth_value(enum hard_depth kind, bool surface, double d,
                         uint32_t h)
{
    const float none[] = {1e10f, INFINITY, NAN, 0.0f, 65504.0f, -NAN};
    const float share = (float) (d / 30.0); // of the way to the far plane
    switch (kind) {
    case DEPTH_ZERO:
        return surface ? (float) d : 0.0f;
    case DEPTH_INF:
        return surface ? (float) d : INFINITY;
    case DEPTH_NAN:
        return surface ? (float) d : NAN;
    case DEPTH_1E10:
    case DEPTH_RAY:
        return surface ? (float) d : 1e10f;
    case DEPTH_HALF_MAX:
        return surface ? (float) d : 65504.0f;
    case DEPTH_NEGATIVE:
        return surface ? (float) -d : 0.0f;
    case DEPTH_INVERSE:
        return surface ? (float) (1.0 / d) : 0.0f;
    case DEPTH_0_TO_1:
        return surface ? share : 1.0f;
    case DEPTH_1_TO_0:
        return surface ? 1.0f - share : 0.0f;
    case DEPTH_ALL_NEAR:
        return (float) d;
    case DEPTH_MIXED:
        break;
    }
    return surface ? (float) d : none[h % (sizeof none / sizeof *none)];
}

static enum gp_depth_type type_of(enum hard_depth kind)
{
    return kind == DEPTH_INVERSE ? GP_DEPTH_INVERSE
           : kind == DEPTH_RAY   ? GP_DEPTH_RAY
           : kind == DEPTH_0_TO_1 || kind == DEPTH_1_TO_0
               ? GP_DEPTH_NORMALIZED
               : GP_DEPTH_Z;
}

static float mask_value(uint32_t h)
{
    const float odd[] = {NAN, -1.0f, 3.0f, INFINITY, -INFINITY, 1e-41f};
    return h % 16 < 6 ? odd[h % 16] : h % 16 < 9 ? 0.0f
           : h % 16 < 12 ? 1.0f : (float) (h >> 8) * 0x1p-24f;
}

static struct sky make_sky(const struct hard_case *h)
{
    const size_t n = (size_t) h->w * (size_t) h->h;
    struct sky s = {.data = {h->x0, h->y0, h->x0 + h->w, h->y0 + h->h}};
    s.depth = scene_alloc(n, sizeof *s.depth);
    s.mask = scene_alloc(n, sizeof *s.mask);
    s.surface = scene_alloc(n, sizeof *s.surface);
    s.type = type_of(h->depth);
    for (int i = 0; i < h->w * h->h; i++) {
        const int x = i % h->w, y = i / h->w;
        const uint32_t block = hash_of(x / 3, y / 3);
        const double d = 5.0 + 20.0 * (block >> 8) * 0x1p-24;
        s.surface[i] = h->depth == DEPTH_ALL_NEAR || block % 5 < 2;
        s.depth[i] = depth_value(h->depth, s.surface[i], d, hash_of(y, x));
        s.mask[i] = mask_value(hash_of(x + 7, y));
    }
    s.plane[0] = (struct gp_plane) {.window = s.data, .v = s.depth};
    s.plane[1] = (struct gp_plane) {.window = s.data, .v = s.mask};
    return s;
}

static void free_sky(struct sky *s)
{
    free(s->depth);
    free(s->mask);
    free(s->surface);
}

/* Both windows together. */
static struct gp_rect frame_of(const struct hard_case *h, struct gp_rect data)
{
    const struct gp_rect shown = {0, 0, h->w, h->h};
    const struct gp_rect d = gp_rect_empty(h->display) ? shown : h->display;
    return (struct gp_rect) {
        d.x0 < data.x0 ? d.x0 : data.x0, d.y0 < data.y0 ? d.y0 : data.y0,
        d.x1 > data.x1 ? d.x1 : data.x1, d.y1 > data.y1 ? d.y1 : data.y1,
    };
}

// -- plain sums ---------------------------------------------------------------

/* What a pixel shows of a sun beyond everything. */
static double plain_show(const struct sky *s, int planes, int x, int y)
{
    if (x < s->data.x0 || x >= s->data.x1 || y < s->data.y0 || y >= s->data.y1)
        return 1.0;
    const size_t i = (size_t) (y - s->data.y0) *
                         (size_t) gp_rect_w(s->data) +
                     (size_t) (x - s->data.x0);
    const double m = fmin(fmax((double) s->mask[i], 0.0), 1.0);
    if (planes == WITH_DEPTH)
        return s->surface[i] ? 0.0 : 1.0;
    return planes ? 1.0 - m : 1.0; // with both, a surface and nothing alike
}

/* Pixels of the frame that the box around a light reaches. */
static struct gp_rect box_of(struct gp_rect frame, const struct gp_light *l)
{
    const double r = fmax(l->radius, 0.0) + 2.0;
    if (!(l->x + r > frame.x0 && l->x - r < frame.x1 && l->y + r > frame.y0 &&
          l->y - r < frame.y1))
        return nowhere;
    return (struct gp_rect) {
        (int) floor(fmax(l->x - r, frame.x0)),
        (int) floor(fmax(l->y - r, frame.y0)),
        (int) ceil(fmin(l->x + r, frame.x1)),
        (int) ceil(fmin(l->y + r, frame.y1)),
    };
}

/* By the area of each pixel under the disc. */
static double plain_area(const struct sky *s, int planes, struct gp_rect frame,
                         int outside, const struct gp_light *l)
{
    const double r = fmax(l->radius, 1e-3);
    const struct gp_rect box = box_of(frame, l);
    double area = 0.0, shown = 0.0;
    for (int y = box.y0; y < box.y1; y++) {
        for (int x = box.x0; x < box.x1; x++) {
            const double a = gp_disc_pixel_area(l->x, l->y, r, x, y);
            area += a;
            shown += a * plain_show(s, planes, x, y);
        }
    }
    const double rest = fmax(M_PI * r * r - area, 0.0);
    if (outside != (int) GP_OUTSIDE_IGNORE)
        area += rest;
    if (outside == (int) GP_OUTSIDE_VISIBLE)
        shown += rest;
    return area > 0.0 ? shown / area : 0.0;
}

static bool covers(const struct gp_light *l, int pattern, double x, double y)
{
    const double dx = x + 0.5 - l->x, dy = y + 0.5 - l->y, r = l->radius;
    return pattern == (int) GP_PATTERN_DISC ? dx * dx + dy * dy <= r * r
                                            : fabs(dx) <= r && fabs(dy) <= r;
}

/* By the count of the pixels whose centres are under it, else the nearest. */
static double plain_count(const struct sky *s, int planes,
                          struct gp_rect frame, int outside, int pattern,
                          const struct gp_light *l)
{
    double shown = 0.0, weight = 0.0;
    const double r = l->radius;
    for (int nearest = 0; nearest < 2 && !(weight > 0.0); nearest++) {
        bool any = false;
        for (double y = floor(l->y - r) - 1.0; y <= l->y + r + 1.0; y += 1.0) {
            for (double x = floor(l->x - r) - 1.0; x <= l->x + r + 1.0;
                 x += 1.0) {
                if (nearest ? x != floor(l->x) || y != floor(l->y)
                            : !covers(l, pattern, x, y))
                    continue;
                any = true;
                const bool in = x >= frame.x0 && x < frame.x1 &&
                                y >= frame.y0 && y < frame.y1;
                if (!in && outside == (int) GP_OUTSIDE_IGNORE)
                    continue;
                weight += 1.0;
                shown += in ? plain_show(s, planes, (int) x, (int) y)
                            : outside == (int) GP_OUTSIDE_VISIBLE;
            }
        }
        if (any)
            break;
    }
    return weight > 0.0 ? shown / weight : 0.0;
}

// -- one case -----------------------------------------------------------------

enum { EXACT, READBACK, MASK_16, MASK_64, MASK_SHARE, WAYS };

static const struct hard_column columns[WAYS + 1] = {
    {"exact", 1e-12}, {"readback", 1e-6}, {"mask 16", 1e-6},
    {"mask 64", 1e-6}, {"mask 64 to the exact share", 0.03}, {NULL, 0},
};

static struct {
    struct gp_gl *gl;
    struct gp_sun_map *map;
} machine;

static void must(gp_status st, const char *what)
{
    if (st)
        hard_die(what, scene_line);
}

static void draw(const struct gp_occluders *o, const struct gp_sun_params *p,
                 int way, struct gp_light *l, const char *what)
{
    l->visibility = -1.0; // must be written
    if (way == READBACK) {
        must(gp_sun_readback(&scene_log, machine.gl, o, p, l, 1, &machine.map),
             what);
        return;
    }
    must(gp_sun_map_draw(&scene_log, machine.gl, o, p, l, 1, &machine.map),
         what);
    must(gp_sun_map_read(&scene_log, machine.gl, machine.map, l, 1), what);
}

/* All GL methods of one light, into the largest errors. */
static void try_gl(const struct sky *s, int planes,
                   const struct gp_occluders *o, struct gp_sun_params p,
                   struct gp_light *l, double share, const char *what,
                   double error[WAYS])
{
    for (int pattern = 0; pattern < PATTERNS; pattern++) {
        p.pattern = (enum gp_sun_pattern) pattern;
        for (int way = READBACK; way <= MASK_64; way++) {
            p.map = way == MASK_64 ? 64 : 16;
            draw(o, &p, way, l, what);
            const double want =
                way == READBACK
                    ? plain_count(s, planes, o->frame, (int) p.outside,
                                  pattern, l)
                    : gp_sun_map_reference(o, &p, l, NULL);
            error[way] = hard_worse(error[way], fabs(l->visibility - want));
            if (way == MASK_64 && p.pattern == GP_PATTERN_DISC)
                error[MASK_SHARE] = hard_worse(error[MASK_SHARE],
                                               fabs(l->visibility - share));
        }
    }
}

static struct gp_light light_of(const struct hard_case *h)
{
    struct gp_light l = GP_LIGHT_DEFAULTS;
    const bool given = h->sun[2] > 0.0;
    l.x = h->x0 + (given ? h->sun[0] : 0.5 * h->w);
    l.y = h->y0 + (given ? h->sun[1] : 0.5 * h->h);
    l.radius = given ? h->sun[2] : (h->w < h->h ? h->w : h->h) / 3.0;
    return l;
}

static void run_case(const struct hard_case *h, double error[WAYS])
{
    struct sky s = make_sky(h);
    struct gp_light l = light_of(h);
    memset(error, 0, WAYS * sizeof *error);
    for (int planes = 0; planes < PLANES; planes++) {
        struct gp_occluders o = {
            .depth = planes & WITH_DEPTH ? &s.plane[0] : NULL,
            .mask = planes & WITH_MASK ? &s.plane[1] : NULL,
            .type = s.type, .frame = frame_of(h, s.data),
        };
        must(gp_occluders_survey(&scene_log, &o), h->name);
        for (int outside = 0; outside < MODES; outside++) {
            const struct gp_sun_params p = {
                .outside = (enum gp_sun_outside) outside,
            };
            const double share = plain_area(&s, planes, o.frame, outside, &l);
            l.visibility = -1.0;
            must(gp_sun_exact(&scene_log, &o, p.outside, &l, 1), h->name);
            error[EXACT] = hard_worse(error[EXACT],
                                      fabs(l.visibility - share));
            if (machine.gl)
                try_gl(&s, planes, &o, p, &l, share, h->name, error);
        }
    }
    free_sky(&s);
}

static double exact_share(const struct hard_case *h, const struct sky *s,
                          int threads)
{
    struct gp_light l = light_of(h);
    struct gp_occluders o = {
        .depth = &s->plane[0], .mask = &s->plane[1], .type = s->type,
        .frame = frame_of(h, s->data),
    };
    gp_set_threads(threads);
    must(gp_occluders_survey(&scene_log, &o), h->name);
    must(gp_sun_exact(&scene_log, &o, GP_OUTSIDE_HIDDEN, &l, 1), h->name);
    gp_set_threads(0);
    return l.visibility;
}

// -- tables -------------------------------------------------------------------

static int is_run(int row)
{
    return hard_is_run(&hard_cases[row]);
}

static void count_differing(int row, int threads, double *differ)
{
    const struct hard_case *const h = &hard_cases[row];
    struct sky s = make_sky(h);
    *differ += exact_share(h, &s, 1) != exact_share(h, &s, threads);
    free_sky(&s);
}

/* GL has its own threads; those of the exact sums are ours. */
static void print_same_bits(void)
{
    static const struct hard_column same[] = {{"exact", 0}, {NULL, 0}};
    hard_table("Suns, the same bits", "shares that differ from those of one "
                                      "thread", same);
    hard_thread_rows(1, is_run, count_differing);
    hard_table_end();
}

static void open_gl(void)
{
    if (hard_quick)
        return;
    const gp_status st = gp_gl_open(&scene_log, GP_GL_API_AUTO, &machine.gl);
    if (st && !strstr(scene_line, "install the Debian"))
        hard_die("GL", scene_line);
}

void hard_sun(void)
{
    open_gl();
    hard_table("Suns", "largest error of the share that shows, by depth, mask "
                       "and both, whatever counts outside the frame", columns);
    for (int row = 0; row < HARD_CASES; row++) {
        double error[WAYS];
        if (!hard_is_run(&hard_cases[row]))
            continue;
        run_case(&hard_cases[row], error);
        hard_row(hard_cases[row].name);
        for (int i = 0; i < WAYS; i++) {
            if (i == EXACT || machine.gl)
                hard_cell(error[i], columns[i].bar);
            else
                hard_no_cell();
        }
    }
    hard_table_end();
    print_same_bits();
    if (machine.gl)
        gp_sun_map_close(machine.gl, &machine.map);
    gp_gl_close(&machine.gl);
}
