/* Every function of sun with a plain form, as pairs.h has it. */
#include "unit.h"
#include "gl/gl_priv.h"
#include "pairs.h"
#include "scene.h"

/* -- sun maps --------------------------------------------------------------*/

enum { LIGHTS = 4 };

struct mapping {
    struct gp_map_params p;
    struct gp_frame f;
    struct gp_plane depth, mask; // its first two planes
    struct gp_occluders o;
    struct gp_light light[LIGHTS];
    float *texel; // r and g of every light's map
    size_t wanted, texels; // of these that are compared: what fits the frame
};

/* Depth and coverage of the frame's values; lights in its middle, at an edge,
 * over all of it, and smaller than a pixel. */
static void *open_mapping(const struct pair *pair, struct gp_frame f)
{
    struct mapping *const m = malloc(sizeof *m);
    assert_non_null(m);
    const double w = gp_frame_w(&f), h = gp_frame_h(&f);
    const struct gp_rect r = f.data;
    *m = (struct mapping) {
        .p = *(const struct gp_map_params *) pair->how, .f = f,
        .depth = {.window = r, .v = f.rgb.c[0]},
        .mask = {.window = r, .v = f.rgb.c[1]},
        .light = {
            light_at(w / 2.0, h / 2.0, fmin(w, h) / 4.0),
            light_at(0.25, h / 3.0, h / 5.0),
            light_at(w / 2.0, h / 2.0, w + h),
            light_at(w / 3.0 + 0.1, h / 4.0 + 0.3, 0.2),
        },
    };
    m->o = occluders(&m->depth, &m->mask, r);
    for (int i = 0; i < LIGHTS; i++)
        m->light[i].depth = 1.0 + 0.25 * i; // amid uniform values
    m->texels = 2u * (size_t) (m->p.side * m->p.side);
    m->texel = calloc(LIGHTS * m->texels, sizeof *m->texel);
    assert_non_null(m->texel);
    const size_t room = 3 * gp_frame_pixels(&f);
    m->wanted = room < LIGHTS * m->texels ? room : LIGHTS * m->texels;
    return m;
}

static void map_plainly(void *ctx, double *out)
{
    struct mapping *const m = ctx;
    for (int i = 0; i < LIGHTS; i++)
        (void) gp_sun_map_reference(&m->o, &m->p, &m->light[i],
                                    m->texel + (size_t) i * m->texels);
    memset(out, 0, 3 * gp_frame_pixels(&m->f) * sizeof *out);
    for (size_t i = 0; i < m->wanted; i++)
        out[i] = (double) m->texel[i];
}

static void map_on_gl(void *ctx, float *out)
{
    struct mapping *const m = ctx;
    struct machine *const on = machine_at(0);
    const int side = m->p.side;
    assert_ok(gp_sun_map_draw(&kept_log, on->gl, &m->o, &m->p, m->light,
                              LIGHTS, &on->map));
    const int columns = on->map->columns, w = columns * side;
    const int h = (LIGHTS + columns - 1) / columns * side;
    float *const atlas = calloc((size_t) (w * h), 4 * sizeof *atlas);
    assert_non_null(atlas);
    gp_target_read(on->gl, &on->map->atlas, 0, (struct gp_rect) {0, 0, w, h},
                   atlas);
    memset(out, 0, 3 * gp_frame_pixels(&m->f) * sizeof *out);
    for (size_t k = 0; k < m->wanted; k++) {
        const int i = (int) (k / m->texels), t = (int) (k % m->texels / 2);
        const int x = i % columns * side + t % side;
        const int y = i / columns * side + t / side;
        out[k] = atlas[4 * (y * w + x) + (int) (k % 2)];
    }
    free(atlas);
}

static void close_mapping(void *ctx)
{
    struct mapping *const m = ctx;
    gp_frame_free(&m->f);
    free(m->texel);
    free(m);
}

/* -- the table -------------------------------------------------------------*/

static const struct gp_map_params
    small = {.side = 8},
    usual = {.side = 16, .outside = GP_OUTSIDE_VISIBLE},
    square = {.side = 16, .pattern = GP_PATTERN_SQUARE,
              .outside = GP_OUTSIDE_IGNORE},
    large = {.side = 64, .outside = GP_OUTSIDE_HIDDEN};

#define MAP(name, how)                                                        \
    {name, 1e8f, 1e-6, 1e-6, 1920, 1080, true, how, open_mapping,             \
     map_plainly, map_on_gl, close_mapping}

static const struct pair pairs[] = {
    MAP("sun map, 8x8", &small), MAP("sun map, 16x16", &usual),
    MAP("sun map, square", &square), MAP("sun map, 64x64", &large),
};

static void fast_forms_equal_the_plain_ones(void **state)
{
    (void) machine_at(0); // skips the test without GL
    pairs_prove(pairs, COUNT(pairs), true);
}

SUITE(pairs)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fast_forms_equal_the_plain_ones),
    };
    (void) open_machines(NULL);
    const bool only_time =
        pairs_time(pairs, COUNT(pairs), machine_count > 0, argc, argv);
    const int failed =
        only_time ? 0 : cmocka_run_group_tests(tests, NULL, NULL);
    (void) close_machines(NULL);
    return failed;
}
