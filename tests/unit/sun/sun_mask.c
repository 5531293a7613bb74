/* sun/map as a measure of what shows: readback is a plain count; masks are
 * near gp_sun_exact() on random frames, on the data's, and on a fence that
 * slides. The data's folder is $GLAREPP_DATA, or ../shared/data; without it
 * those frames are skipped. */
#include "unit.h"
#include "io/channels.h"
#include "sun/occluder.h"

#include "reading.h"
#include "sun_maps.h"

#include <jansson.h>

/* -- readback ---------------------------------------------------------------*/

static bool inside(const struct gp_light *l, enum gp_sun_pattern pattern,
                   int x, int y)
{
    const double dx = x + 0.5 - l->x, dy = y + 0.5 - l->y, r = l->radius;
    return pattern == GP_PATTERN_DISC ? dx * dx + dy * dy <= r * r
                                      : fabs(dx) <= r && fabs(dy) <= r;
}

/* Pixel by pixel over a box around the light. */
static double plain_count(const struct gp_occluders *o,
                          const struct gp_map_params *p,
                          const struct gp_light *l)
{
    double shown = 0.0, weight = 0.0;
    const bool none = l->radius < 0.5;
    const double r = none ? 0.0 : l->radius;
    for (int y = (int) floor(l->y - r) - 1; y <= l->y + r + 1.0; y++) {
        for (int x = (int) floor(l->x - r) - 1; x <= l->x + r + 1.0; x++) {
            const bool within = x >= o->frame.x0 && x < o->frame.x1 &&
                                y >= o->frame.y0 && y < o->frame.y1;
            const bool nearest = x == (int) floor(l->x) &&
                                 y == (int) floor(l->y);
            if (none ? !nearest : !inside(l, p->pattern, x, y))
                continue;
            if (!within && p->outside == GP_OUTSIDE_IGNORE)
                continue;
            shown += within ? gp_occluders_show(o, l, x, y)
                            : p->outside == GP_OUTSIDE_VISIBLE;
            weight += 1.0;
        }
    }
    return weight > 0.0 ? shown / weight : 0.0;
}

static void readback_is_a_plain_count(void **state)
{
    static const double at[][3] = { // 0.1 and 0.2 are between all centres
        {37.3, 70.8, 2.5}, {20.0, 60.0, 24.0}, {-41.0, 70.0, 9.0},
        {120.0, 125.0, 12.0}, {-300.0, 70.0, 8.0}, {50.0, 50.0, 0.1},
        {-40.9, 52.0, 0.2}, {10.0, 75.0, 300.0}, {-50.0, 60.0, 0.2},
    };
    enum { N = 9 };
    (void) state;
    for (int k = 0; k < 24 * machine_count; k++) {
        struct machine *const m = machine_at(k / 24);
        const struct gp_map_params p = {
            .side = 16, .pattern = k % 2, .outside = k / 2 % 3,
        };
        struct sun_frame f;
        struct gp_light l[N];
        make_frame(&f, (struct gp_rect) {-40, 25, 120, 125}, k / 6 % 4, 2);
        for (int i = 0; i < N; i++)
            l[i] = light_at(at[i][0], at[i][1], at[i][2]);
        assert_ok(gp_sun_readback(&log_kept, m->gl, &f.o, &p, l, N, &m->map));
        for (int i = 0; i < N; i++) {
            const double want = plain_count(&f.o, &p, &l[i]);
            if (!(fabs(l[i].visibility - want) < 1e-6))
                fail_msg("row %d, light %d: %.9g is %.9g", k, i, want,
                         l[i].visibility);
        }
        struct gp_light again[N];
        memcpy(again, l, sizeof l);
        assert_ok(gp_sun_map_read(&log_kept, m->gl, m->map, again, N));
        for (int i = 0; i < N; i++)
            assert_true(fabs(again[i].visibility - l[i].visibility) < 1e-7);
        assert_true(gp_sun_intensity(m->map)->w == N);
        free_frame(&f);
    }
}

/* -- hidden, behind, outside -----------------------------------------------*/

static void ends_of_the_scale(void **state)
{
    static const struct {
        float depth;       // of every pixel
        double x;          // of a light of radius 5 in 64 x 64; behind at 99
        enum gp_sun_outside outside;
        double want;
    } rows[] = {
        {5.0f, 30.0, GP_OUTSIDE_IGNORE, 0.0},
        {1e10f, 30.0, GP_OUTSIDE_IGNORE, 1.0},
        {1e10f, 99.0, GP_OUTSIDE_VISIBLE, 0.0},
        {1e10f, -30.0, GP_OUTSIDE_IGNORE, 0.0},
        {1e10f, -30.0, GP_OUTSIDE_HIDDEN, 0.0},
        {5.0f, -30.0, GP_OUTSIDE_VISIBLE, 1.0},
        {5.0f, 0.0, GP_OUTSIDE_VISIBLE, 0.5},
        {1e10f, 0.0, GP_OUTSIDE_HIDDEN, 0.5},
        {1e10f, 0.0, GP_OUTSIDE_IGNORE, 1.0},
    };
    struct gp_plane depth = plane_of((struct gp_rect) {0, 0, 64, 64});
    (void) state;
    for (int k = 0; k < 9 * machine_count; k++) {
        struct machine *const m = machine_at(k / 9);
        struct gp_occluders o = {.depth = &depth, .frame = depth.window};
        for (int i = 0; i < 64 * 64; i++)
            depth.v[i] = rows[k % 9].depth;
        gp_occluders_count(&o);
        for (int method = 0; method < 3; method++) {
            const struct gp_map_params p = {
                .side = 16, .outside = rows[k % 9].outside,
                .pattern = method % 2,
            };
            struct gp_light l = light_at(rows[k % 9].x, 32.0, 5.0);
            l.behind = l.x == 99.0;
            if (method == 2)
                assert_ok(gp_sun_readback(&log_kept, m->gl, &o, &p, &l, 1,
                                          &m->map));
            else
                assert_ok(gp_sun_map_draw(&log_kept, m->gl, &o, &p, &l, 1,
                                          &m->map));
            assert_ok(gp_sun_map_read(&log_kept, m->gl, m->map, &l, 1));
            if (!(fabs(l.visibility - rows[k % 9].want) < 1e-6))
                fail_msg("row %d, method %d: %g is %g", k % 9, method,
                         rows[k % 9].want, l.visibility);
        }
    }
    free(depth.v);
}

/* -- against the exact share -----------------------------------------------*/

/* Leaves: discs of random size that cover about half of the plane. */
static void grow_leaves(struct gp_plane *p)
{
    const int w = gp_rect_w(p->window), h = gp_rect_h(p->window);
    for (int i = 0; i < w * h; i++)
        p->v[i] = 1e10f;
    for (int leaf = 0; leaf < 4000; leaf++) {
        const double r = 1.0 + 10.0 * uniform01() * uniform01();
        const int x = (int) (w * uniform01()), y = (int) (h * uniform01());
        for (int dy = (int) -r; dy <= r; dy++)
            for (int dx = (int) -r; dx <= r; dx++)
                if (dx * dx + dy * dy <= r * r && x + dx >= 0 && x + dx < w &&
                    y + dy >= 0 && y + dy < h)
                    p->v[(y + dy) * w + x + dx] = 8.0f;
    }
}

static void mask_64_is_near_exact(void **state)
{
    enum { N = 60 };
    struct gp_plane depth = plane_of((struct gp_rect) {0, 0, 1024, 768});
    const struct gp_map_params p = {.side = 64};
    struct gp_light exact[N], mask[N];
    (void) state;
    seed = 9;
    grow_leaves(&depth);
    struct gp_occluders o = {.depth = &depth, .frame = depth.window};
    gp_occluders_count(&o);
    for (int i = 0; i < N; i++) {
        const double r = 2.0 + 58.0 * i / (N - 1);
        exact[i] = mask[i] = light_at(1024.0 * uniform01(),
                                      768.0 * uniform01(), r);
    }
    gp_sun_exact(&o, p.outside, exact, N);
    for (int k = 0; k < machine_count; k++) {
        struct machine *const m = machine_at(k);
        double mean = 0.0, worst = 0.0;
        assert_ok(gp_sun_map_draw(&log_kept, m->gl, &o, &p, mask, N, &m->map));
        assert_ok(gp_sun_map_read(&log_kept, m->gl, m->map, mask, N));
        for (int i = 0; i < N; i++) {
            const double off = fabs(mask[i].visibility - exact[i].visibility);
            mean += off / N;
            worst = fmax(worst, off);
        }
        print_message("64x64 against exact: mean %.5f, worst %.5f\n", mean,
                      worst);
        assert_true(mean > 0.0 && mean <= 0.01 && worst <= 0.03);
    }
    free(depth.v);
}

/* -- a fence that slides ---------------------------------------------------*/

enum { FENCE_STEPS = 128 };

/* Bars 3 pixels wide every 8, `at` pixels to the right, as coverage. */
static void draw_fence(struct gp_plane *p, double at)
{
    const int w = gp_rect_w(p->window), h = gp_rect_h(p->window);
    for (int x = 0; x < w; x++) {
        double cover = 0.0;
        for (int bar = -3; bar < w / 8 + 1; bar++) {
            const double from = fmax(x, 8.0 * bar + at);
            cover += fmax(0.0, fmin(x + 1.0, 8.0 * bar + at + 3.0) - from);
        }
        for (int y = 0; y < h; y++)
            p->v[y * w + x] = (float) cover;
    }
}

/* The largest change from a step of 1/8 pixel to the next, and error. */
struct curve {
    const char *name;
    int map;     // 0: readback
    enum gp_sun_pattern pattern;
    enum gp_sun_sum sum;
    double most, worst; // bars of step and error
    double step, error, last;
};

static void follow(struct machine *m, const struct gp_occluders *o, int step,
                   double exact, struct curve *c)
{
    const struct gp_map_params p = {
        .side = c->map ? c->map : 16, .pattern = c->pattern, .sum = c->sum,
    };
    struct gp_light l = light_at(31.3, 23.8, 6.0);
    if (c->map)
        assert_ok(gp_sun_map_draw(&log_kept, m->gl, o, &p, &l, 1, &m->map));
    else
        assert_ok(gp_sun_readback(&log_kept, m->gl, o, &p, &l, 1, &m->map));
    assert_ok(gp_sun_map_read(&log_kept, m->gl, m->map, &l, 1));
    if (step)
        c->step = fmax(c->step, fabs(l.visibility - c->last));
    c->error = fmax(c->error, fabs(l.visibility - exact));
    c->last = l.visibility;
}

/* Coverage lets every method move in small steps: an edge of the fence sweeps
 * 12 of the disc's 113 square pixels in a step at most, and 4 cross it. */
static void a_fence_slides_without_jumps(void **state)
{
    struct gp_plane mask = plane_of((struct gp_rect) {0, 0, 64, 48});
    const struct gp_occluders o = {.mask = &mask, .frame = mask.window};
    (void) state;
    for (int k = 0; k < machine_count; k++) {
        struct machine *const m = machine_at(k);
        // 8 bits round each grey texel's 1/255 to all or nothing; a square
        // sees more than the disc
        struct curve curves[] = {
            {.name = "mask 4", .map = 4, .most = 0.04, .worst = 0.04},
            {.name = "mask 16", .map = 16, .most = 0.04, .worst = 0.04},
            {.name = "mask 64", .map = 64, .most = 0.04, .worst = 0.005},
            {.name = "mask 16 bilinear", .map = 16, .sum = GP_SUM_BILINEAR,
             .most = 0.04, .worst = 0.04},
            {.name = "mask 16 8bit", .map = 16, .sum = GP_SUM_BYTE,
             .most = 0.25, .worst = 0.25},
            {.name = "mask 16 square", .map = 16,
             .pattern = GP_PATTERN_SQUARE, .most = 0.06, .worst = 0.12},
            {.name = "readback", .most = 0.04, .worst = 0.04},
        };
        const int n = (int) (sizeof curves / sizeof *curves);
        for (int step = 0; step < FENCE_STEPS; step++) {
            struct gp_light l = light_at(31.3, 23.8, 6.0);
            draw_fence(&mask, step / 8.0);
            gp_sun_exact(&o, GP_OUTSIDE_IGNORE, &l, 1);
            for (int i = 0; i < n; i++)
                follow(m, &o, step, l.visibility, &curves[i]);
        }
        for (int i = 0; i < n; i++) {
            print_message("fence, %s: largest step %.4f, worst error %.4f\n",
                          curves[i].name, curves[i].step, curves[i].error);
            assert_true(curves[i].step > 0.0);
            assert_true(curves[i].step < curves[i].most);
            assert_true(curves[i].error < curves[i].worst);
        }
    }
    free(mask.v);
}

/* -- the data's frames -----------------------------------------------------*/

struct errors {
    double truth, exact, worst; // mask 16 to truth; mask 64 to exact
    int n;
};

static double mask_of(struct machine *m, const struct gp_occluders *o,
                      int map, struct gp_light l)
{
    const struct gp_map_params p = {.side = map};
    assert_ok(gp_sun_map_draw(&log_kept, m->gl, o, &p, &l, 1, &m->map));
    assert_ok(gp_sun_map_read(&log_kept, m->gl, m->map, &l, 1));
    return l.visibility;
}

static void add_frame(struct machine *m, const char *stem,
                      const json_t *frame, struct errors *e)
{
    const json_t *const at = json_object_get(frame, "sun_pixel_xy_depth");
    struct gp_light l = light_at(
        json_number_value(json_array_get(at, 0)),
        json_number_value(json_array_get(at, 1)),
        json_number_value(json_object_get(frame, "sun_radius_px")));
    char name[600];
    struct gp_frame f;
    int index;
    snprintf(name, sizeof name, "%s.%lld.exr", stem,
             (long long) json_integer_value(json_object_get(frame, "frame")));
    assert_int_equal(read_file(name, &f), GP_OK);
    assert_ok(gp_find_depth(&log_kept, &f, "Z", &index));
    struct gp_plane z = plane_of(f.data);
    gp_channel_floats(&f, index, z.v);
    struct gp_occluders o = {.depth = &z, .frame = f.data};
    gp_occluders_count(&o);
    gp_sun_exact(&o, GP_OUTSIDE_IGNORE, &l, 1);
    const double off = fabs(mask_of(m, &o, 64, l) - l.visibility);
    e->truth += fabs(mask_of(m, &o, 16, l) -
                     json_number_value(json_object_get(
                         frame, "sun_visibility_depth")));
    e->exact += off;
    e->worst = fmax(e->worst, off);
    e->n++;
    free(z.v);
    gp_frame_free(&f);
}

static void the_datas_frames(void **state)
{
    static const char *const stems[] = {
        "seq_foliage/foliage", "seq_foliage/foliage_f32", "rendered/window",
        "rendered/brightsky",
    };
    const char *const data = getenv("GLAREPP_DATA");
    (void) state;
    for (int k = 0; k < machine_count; k++) {
        struct errors e = {0};
        for (int i = 0; i < 4; i++) {
            char stem[400], name[500];
            snprintf(stem, sizeof stem, "%.300s/%s",
                     data ? data : "../shared/data", stems[i]);
            snprintf(name, sizeof name, "%s.camera.json", stem);
            json_t *const root = json_load_file(name, 0, NULL);
            const json_t *const list = json_object_get(root, "frames");
            for (size_t j = 0; j < json_array_size(list); j++)
                add_frame(machine_at(k), stem, json_array_get(list, j), &e);
            json_decref(root);
        }
        if (!e.n)
            skip();
        print_message("%d frames: mask 16 to truth, mean %.4f; mask 64 to "
                      "exact, mean %.4f, worst %.4f\n", e.n, e.truth / e.n,
                      e.exact / e.n, e.worst);
        assert_true(e.truth / e.n <= 0.06);
        assert_true(e.exact / e.n <= 0.01 && e.worst <= 0.03);
    }
}

SUITE_OF(sun_mask, open_machines, close_machines,
    readback_is_a_plain_count, ends_of_the_scale, mask_64_is_near_exact,
    a_fence_slides_without_jumps, the_datas_frames)
