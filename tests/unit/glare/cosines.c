// SPDX-License-Identifier: Apache-2.0
/* Diffraction by direction cosines. */
#include "glare/sky/cosines.h"
#include "sky_scene.h"

enum { W = 72, H = 48, N = W * H };

/* The kernel of a frame of w x h pixels that a camera shows, fov degrees high. */
static struct gp_kernel kernel_of(const char *recipe, enum gp_projecting kind,
                                  int w, int h, double fov, double shift)
{
    struct gp_kernel k;
    struct gp_field f = scene_field(w, h, gp_middle_degrees(fov, h), 1.0);
    f.projection =
        gp_projection_of(kind, (struct gp_rect) {0, 0, w, h}, 1.0, fov);
    f.projection.x0 += shift - 0.5;
    f.projection.y0 -= 0.5;
    f.seen_w = w;
    f.seen_h = h;
    model_make(recipe, &f, &k);
    return k;
}

static struct gp_planes layer_of(const struct gp_kernel *k,
                                 const struct gp_sources *src)
{
    struct gp_cosines_kept *kept = NULL;
    struct gp_planes p;
    assert_ok(
        gp_planes_make(NULL, "layer", (size_t) src->w * (size_t) src->h, &p));
    gp_planes_clear(&p, 0, (size_t) src->w * (size_t) src->h);
    for (int i = 0; i < 2; i++) { // what is kept makes the same bytes
        const struct gp_sky_drawing d = {
            .src = src, .add = i > 0, .kept = &kept, .layer = &p};
        assert_ok(gp_sky_add(NULL, k->sky, &d));
    }
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < src->w * src->h; i++)
            p.c[c][i] *= 0.5f;
    gp_cosines_kept_free(&kept);
    return p;
}

/* Airy's transfer function: Goodman, eq. 6-31; nu of the cutoff. */
static double airy(double nu)
{
    return nu >= 1.0 ? 0.0 : 2.0 / M_PI * (acos(nu) - nu * sqrt(1.0 - nu * nu));
}

static double sinc(double x)
{
    return fabs(x) > 1e-9 ? sin(M_PI * x) / (M_PI * x) : 1.0;
}

/* D at (u, v) pixels, of a pixel's area, for a cutoff of so many cycles a pixel. */
static double airy_at(double u, double v, double cutoff)
{
    enum { STEPS = 400 };
    const double own = airy(0.9 / cutoff);
    double sum = 0.0;
    for (int i = 0; i < STEPS * STEPS; i++) {
        const double x = (i % STEPS + 0.5) / STEPS,
                     y = (i / STEPS + 0.5) / STEPS;
        sum += 4.0 * (airy(hypot(x, y) / cutoff) - own) *
               pow(sinc(x) * sinc(y), 2) * cos(2.0 * M_PI * x * u) *
               cos(2.0 * M_PI * y * v);
    }
    return sum / (STEPS * STEPS);
}

static void the_definition_is_the_formula(void **state)
{
    static const int offsets[][2] = {{1, 0}, {0, 1}, {2, 1}, {3, -2}, {-5, 4}};
    static const int places[][2] = {{36, 24}, {60, 40}};
    (void) state;
    for (int i = 0; i < 2; i++) {
        // pixels of 1.5 mrad, whose corner is far off the axis
        struct gp_kernel k =
            kernel_of(AIRY, GP_PERSPECTIVE, W, H, 4.0, i ? 300.0 : 0.0);
        assert_non_null(k.sky);
        struct gp_projection p = gp_projection_of(
            GP_PERSPECTIVE, (struct gp_rect) {0, 0, W, H}, 1.0, 4.0);
        p.x0 += (i ? 300.0 : 0.0) - 0.5;
        p.y0 -= 0.5;
        const double cutoff = p.dx * 1.0 / 550e-6;
        const int *const at = places[i];
        struct gp_sources src = sky_lamps(W, H, 1, at[0], at[1]);
        double *const v = sky_exact(k.sky, &src);
        const struct gp_v3 from = gp_projection_direction(&p, at[0], at[1]);
        const double area =
            gp_projection_solid(&p, at[0], at[1]) * from.z / (p.dx * p.dy);
        for (size_t j = 0; j < COUNT(offsets); j++) {
            const int x = at[0] + offsets[j][0], y = at[1] + offsets[j][1];
            const struct gp_v3 to = gp_projection_direction(&p, x, y);
            const double want = area * airy_at((to.x - from.x) / p.dx,
                                               (to.y - from.y) / p.dy, cutoff);
            const double got = v[y * W + x] / (double) src.rgb[0][0];
            if (!(fabs(got - want) <= 5e-3 * fabs(want) + 2e-6))
                print_message("# %d at %d, %d: %g, not %g\n", i, offsets[j][0],
                              offsets[j][1], got, want);
            assert_true(fabs(got - want) <= 5e-3 * fabs(want) + 2e-6);
        }
        free(v);
        gp_sources_free(&src);
        gp_kernel_free(&k);
    }
}

/* Its finest light is coarser than a pixel of 5 degrees. */
#define ALL_BY_NODES \
    "aperture:share=1,dust=0,scratches=0,wavelength=550,pupil=0.05"

static void transforms_are_the_sum(void **state)
{
    static const struct {
        const char *recipe;
        double fov, shift;
    } rows[] = {
        {"aperture", 30, 0},           {"aperture", 100, 0},
        {"aperture", 0.5, 0},          {AIRY, 40, 30},
        {"aperture:coma=1", 60, 0},    {"aperture:share=1", 5, 0},
        {"aperture:reach=0.1", 60, 0}, {ALL_BY_NODES, 5, 0},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel k = kernel_of(rows[i].recipe, GP_PERSPECTIVE, W, H,
                                       rows[i].fov, rows[i].shift);
        assert_non_null(k.sky);
        struct gp_sources src = sky_lamps(W, H, 5, 0, 0);
        struct gp_planes got = layer_of(&k, &src);
        double *const want = sky_exact(k.sky, &src), error = 0.0, norm = 0.0;
        for (int c = 0; c < 3; c++) {
            for (int j = 0; j < N; j++) {
                error += pow((double) got.c[c][j] - want[c * N + j], 2.0);
                norm += pow(want[c * N + j], 2.0);
            }
        }
        error = sqrt(error);
        const double light =
            sqrt(src.energy[0] + src.energy[1] + src.energy[2]);
        const double limit =
            gp_sky_facts(k.sky)->splines * light + 2e-6 * sqrt(norm);
        if (error > limit || error > 1e-4 * light)
            print_message("# %s at %g: %g over %g, limit %g\n", rows[i].recipe,
                          rows[i].fov, error, light, limit);
        assert_true(error <= limit);
        assert_true(error <= 1e-4 * light);
        gp_planes_free(&got);
        free(want);
        gp_sources_free(&src);
        gp_kernel_free(&k);
    }
}

static void light_is_kept(void **state)
{
    static const int places[][2] = {{36, 24}, {60, 10}, {66, 43}};
    (void) state;
    struct gp_kernel k = kernel_of("aperture:dust=0,scratches=0",
                                   GP_PERSPECTIVE, W, H, 50.0, 0.0);
    struct gp_projection p = gp_projection_of(
        GP_PERSPECTIVE, (struct gp_rect) {0, 0, W, H}, 1.0, 50.0);
    p.x0 -= 0.5;
    p.y0 -= 0.5;
    for (size_t i = 0; i < COUNT(places); i++) {
        const int *const at = places[i];
        struct gp_sources src = sky_lamps(W, H, 1, at[0], at[1]);
        struct gp_sources other = sky_lamps(W, H, 1, W - 1 - at[0], at[1]);
        double *const v = sky_exact(k.sky, &src), *const m =
                                                      sky_exact(k.sky, &other);
        double sum = 0.0;
        for (int j = 0; j < N; j++) {
            const struct gp_v3 d = gp_projection_direction(&p, j % W, j / W);
            sum += v[j] * gp_projection_solid(&p, j % W, j / W) * d.z;
            // blades mirror themselves
            const double mirrored = m[j / W * W + W - 1 - j % W];
            assert_true(fabs(v[j] - mirrored) <= 2e-5 * fabs(v[j]) + 1e-5);
        }
        const struct gp_v3 d = gp_projection_direction(&p, at[0], at[1]);
        sum /= (double) src.rgb[0][0] * d.z *
               gp_projection_solid(&p, at[0], at[1]);
        const double beyond = gp_sky_outside(k.sky, at[0], at[1]);
        const double all = k.sum[0] + sum + beyond;
        if (fabs(all - 1.0) > 2e-3)
            print_message("# at %d, %d: %g kept, %g beyond, all %g\n", at[0],
                          at[1], sum, beyond, all);
        assert_true(fabs(all - 1.0) <= 2e-3);
        free(v);
        free(m);
        gp_sources_free(&src);
        gp_sources_free(&other);
    }
    gp_kernel_free(&k);
}

/* Light beside a picture is that of a larger one's part. */
static void light_beside_is_the_same(void **state)
{
    enum { WIDE = W + 24 };
    (void) state;
    struct gp_kernel k =
        kernel_of("aperture", GP_PERSPECTIVE, WIDE, H, 40.0, 0.0);
    const struct gp_source lamp = {-8, 20, {50.0f, 40.0f, 30.0f}};
    struct gp_sources src = sky_lamps(WIDE, H, 1, lamp.x + 12, lamp.y);
    for (int c = 0; c < 3; c++)
        src.rgb[c][0] = lamp.rgb[c];
    struct gp_planes whole = layer_of(&k, &src), part;
    assert_ok(gp_planes_make(NULL, "layer", N, &part));
    gp_planes_clear(&part, 0, N);
    assert_ok(gp_kernel_add_beyond(NULL, &k, &lamp, 1, W, H, &part));
    for (int j = 0; j < N; j++) {
        const float want = whole.c[0][j / W * WIDE + j % W + 12];
        assert_true(fabsf(part.c[0][j] - want) <= 1e-4f * want + 1e-8f);
    }
    gp_planes_free(&whole);
    gp_planes_free(&part);
    gp_sources_free(&src);
    gp_kernel_free(&k);
}

static void even_pictures_stay_even(void **state)
{
    static const double fovs[] = {0.001, 0.05, 1.0, 30.0, 90.0};
    (void) state;
    for (size_t i = 0; i < COUNT(fovs); i++) {
        struct gp_kernel k =
            kernel_of("aperture", GP_PERSPECTIVE, W, H, fovs[i], 0.0);
        const struct gp_sources like = {
            .w = W, .h = H, .luminance = {0.2f, 0.7f, 0.1f}};
        struct gp_image f = {.data = {0, 0, W, H}, .display = {0, 0, W, H}};
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare engines = {0};
        struct glarepp_layer_facts facts;
        struct gp_sources src;
        assert_ok(gp_sources_make(NULL, &like, N, &src));
        for (int j = 0; j < N; j++)
            gp_sources_add(&src, j % W, j / W,
                           (const float[3]) {10.0f, 10.0f, 10.0f});
        gp_sources_finish(&src);
        p.engine = "fft";
        p.edges = (struct gp_surround) {.how = GLAREPP_EXTEND, .picture = &src};
        assert_ok(gp_glare_run(NULL, &p, &engines, &src, &k, &f, &facts));
        for (int j = 0; j < 3 * N; j++)
            assert_true(fabsf(f.layer.c[j / N][j % N] - 10.0f) <= 1e-3f);
        gp_glare_close(&engines);
        gp_planes_free(&f.layer);
        gp_sources_free(&src);
        gp_kernel_free(&k);
    }
}

static void others_are_planes(void **state)
{
    static const enum gp_projecting kinds[] = {GP_LATLONG, GP_FISHEYE,
                                               GP_PLANE};
    (void) state;
    for (size_t i = 0; i < COUNT(kinds); i++) {
        struct gp_kernel k = kernel_of("aperture", kinds[i], W, H, 120.0, 0.0);
        assert_null(k.sky);
        gp_kernel_free(&k);
    }
    struct gp_kernel k =
        kernel_of("aperture", GP_PERSPECTIVE, W, H, 176.0, 0.0);
    assert_null(k.sky);
    gp_kernel_free(&k);
}

SUITE_OF(cosines, NULL, NULL, the_definition_is_the_formula,
         transforms_are_the_sum, light_is_kept, light_beside_is_the_same,
         even_pictures_stay_even, others_are_planes)
