// SPDX-License-Identifier: Apache-2.0
/* glare/sky/sphere_*.c: lat-long frames against the sum as it is defined, that against
 * the model's formula, and laws that a sphere has. */
#include "glare/sky/sphere.h"
#include "core/parallel.h"
#include "sky_scene.h"

enum { W = 400, H = 200, N = W * H };

static struct gp_sky *sphere_of(const char *recipe, struct gp_sky_params *p)
{
    *p = sky_params(recipe, GP_LATLONG, W, H, 180.0, 1e-3);
    struct gp_sky *const s = sky_of(p);
    assert_non_null(s);
    assert_non_null(s->sphere);
    return s;
}

static const int places[][2] = {
    {200, 100}, {0, 100}, {399, 101}, {100, 40}, {0, 160},   {399, 20},
    {37, 3},    {250, 1}, {123, 0},   {0, 0},    {300, 199}, {199, 197},
};

/* Light over the sphere, as each pixel has its solid angle. */
static double light_of(const struct gp_sky *s, const float *plane)
{
    double sum = 0.0;
    for (int i = 0; i < N; i++)
        sum += (double) plane[i] *
               gp_projection_solid(&s->p.projection, i % W, i / W);
    return sum;
}

/* The largest ratio of two layers of which 99 % of the pixels, 4 rows and more away
 * from a lamp, are within. */
static double most_apart(const struct gp_sky *s, const struct gp_planes *got,
                         const double *want, const int lamp[2])
{
    enum { STEPS = 2000 };
    static const double STEP = 1e-5;
    int count[STEPS + 1] = {0}, all = 0, sum = 0, k = STEPS;
    const double near = 4.0 * s->p.projection.dy;
    for (int i = 0; i < N; i++) {
        if (gp_projection_chord2(&s->p.projection, lamp[0], lamp[1], i % W,
                                 i / W) < near * near)
            continue;
        const double off = fabs((double) got->c[1][i] / want[N + i] - 1.0);
        count[(int) fmin(off / STEP, STEPS)]++;
        all++;
    }
    for (; k > 0 && (sum + count[k]) * 100 < all; k--)
        sum += count[k];
    return (k + 1) * STEP;
}

/* A lamp at seam, poles and elsewhere: the veil within 0.3 %, its light kept. */
static void a_lamp_is_the_same_all_over(void **state)
{
    static const char *const models[] = {"eye", "cie:age=70"};
    (void) state;
    for (size_t m = 0; m < COUNT(models); m++) {
        struct gp_sky_params p;
        struct gp_sky *sky = sphere_of(models[m], &p);
        for (size_t i = 0; i < COUNT(places); i++) {
            struct gp_sources src =
                sky_lamps(W, H, 1, places[i][0], places[i][1]);
            struct gp_planes got = sky_layer(sky, &src);
            double *const want = sky_exact(sky, &src), error = 0.0, norm = 0.0;
            const double apart = most_apart(sky, &got, want, places[i]);
            const double light =
                light_of(sky, got.c[1]) /
                (src.rgb[1][0] *
                 gp_projection_solid(&sky->p.projection, 0.0, places[i][1]));
            for (int k = 0; k < 3 * N; k++) {
                const double off = (double) got.c[k / N][k % N] - want[k];
                error += off * off;
                norm += want[k] * want[k];
            }
            if (apart > 3e-3 || fabs(light - 1.0) > 1e-3)
                print_message("# %s, place %zu: %.2e apart, light %.6f\n",
                              models[m], i, apart, light);
            assert_true(apart <= 3e-3);
            assert_true(fabs(light - 1.0) <= 1e-3);
            assert_true(sqrt(error / norm) <= sky->facts.relative);
            gp_planes_free(&got);
            gp_sources_free(&src);
            free(want);
        }
        gp_sky_free(&sky);
    }
}

/* The definition is the formula: light per steradian at the angle of both, from 12 rows
 * on, where a pixel is a point. */
static void the_definition_is_the_formula(void **state)
{
    struct gp_sky_params p;
    (void) state;
    struct gp_sky *sky = sphere_of("eye", &p);
    double whole = 0.0;                // of the formula, over the sphere
    for (int i = 0; i < 200000; i++) { // by angle, denser towards 0
        const double u = (i + 0.5) / 200000.0, t = 180.0 * u * u * u * u;
        whole += p.part[0].light(&p.part[0], 0, fmin(t, 100.0)) * 2.0 * M_PI *
                 sin(t * M_PI / 180.0) * M_PI * 4.0 * u * u * u / 200000.0;
    }
    for (size_t i = 0; i < COUNT(places); i += 2) {
        struct gp_sources src = sky_lamps(W, H, 1, places[i][0], places[i][1]);
        double *const got = sky_exact(sky, &src);
        const double light =
            src.rgb[0][0] * (1.0 - p.part[0].stays) / whole *
            gp_projection_solid(&sky->p.projection, 0.0, places[i][1]);
        for (int k = 0; k < N; k += 7) {
            const double chord = sqrt(gp_projection_chord2(
                &sky->p.projection, places[i][0], places[i][1], k % W, k / W));
            if (chord < 12.0 * sky->p.projection.dy)
                continue;
            const double t = 360.0 / M_PI * asin(fmin(0.5 * chord, 1.0));
            const double want =
                light * p.part[0].light(&p.part[0], 0, fmin(t, 100.0));
            assert_true(fabs(got[k] / want - 1.0) <= 6e-3);
        }
        gp_sources_free(&src);
        free(got);
    }
    gp_sky_free(&sky);
}

static struct gp_sources filled(const float *plane, int w, int h)
{
    const struct gp_sources like = {.w = w, .h = h};
    struct gp_sources s;
    assert_ok(gp_sources_make(NULL, &like, (size_t) (w * h), &s));
    for (int i = 0; i < w * h; i++) {
        const float rgb[3] = {plane[i], 0.5f * plane[i], 0.0f};
        if (plane[i] > 0.0f)
            gp_sources_add(&s, i % w, i / w, rgb);
    }
    gp_sources_finish(&s);
    return s;
}

/* An even sphere stays even; one that is turned has a layer that is turned; a window of
 * it is dark elsewhere; light adds up; bytes are the same by any number of threads. */
static void laws_of_a_sphere_hold(void **state)
{
    enum { X = 130, Y = 20, SIDE = 90, TURN = 51 };
    struct gp_sky_params p;
    (void) state;
    struct gp_sky *sky = sphere_of(TINT, &p);
    float *const plane = scene_alloc(N, sizeof *plane);
    float *const turned = scene_alloc(N, sizeof *turned);
    float *const window = scene_alloc(SIDE * SIDE, sizeof *window);
    for (int i = 0; i < N; i++)
        plane[i] = 1.0f;
    struct gp_sources src = filled(plane, W, H);
    struct gp_planes one = sky_layer(sky, &src);
    for (int i = 0; i < N; i++)
        assert_true(fabs((double) one.c[0][i] - gp_sky_facts(sky)->light) <
                    2e-3);
    gp_planes_free(&one);
    gp_sources_free(&src);
    uint32_t seed = 5u;
    for (int i = 0; i < N; i++) {
        const bool in =
            i % W >= X && i % W < X + SIDE && i / W >= Y && i / W < Y + SIDE;
        plane[i] = in && scene_random(&seed) < 0.3f ? 1.0f : 0.0f;
        turned[i / W * W + (i + TURN) % W] = plane[i];
        if (in)
            window[(i / W - Y) * SIDE + i % W - X] = plane[i];
    }
    src = filled(plane, W, H);
    struct gp_sources other = filled(turned, W, H);
    one = sky_layer(sky, &src);
    struct gp_planes two = sky_layer(sky, &other);
    for (int i = 0; i < N; i++)
        assert_true(fabsf(one.c[0][i] - two.c[0][i / W * W + (i + TURN) % W]) <=
                    1e-5f * (1.0f + one.c[0][i]));
    gp_set_threads(5);
    struct gp_planes again = sky_layer(sky, &src);
    gp_set_threads(0);
    assert_memory_equal(one.c[0], again.c[0], N * sizeof(float));
    assert_memory_equal(one.c[1], again.c[1], N * sizeof(float));
    struct gp_sky_params part = p;
    part.w = part.h = SIDE;
    part.projection.x0 -= X;
    part.projection.y0 -= Y;
    struct gp_sky *small = sky_of(&part);
    struct gp_sources own = filled(window, SIDE, SIDE);
    struct gp_planes in = sky_layer(small, &own);
    for (int i = 0; i < SIDE * SIDE; i++)
        assert_true(in.c[0][i] == one.c[0][(i / SIDE + Y) * W + i % SIDE + X]);
    gp_planes_free(&one);
    gp_planes_free(&two);
    gp_planes_free(&again);
    gp_planes_free(&in);
    gp_sources_free(&src);
    gp_sources_free(&other);
    gp_sources_free(&own);
    gp_sky_free(&sky);
    gp_sky_free(&small);
    free(plane);
    free(turned);
    free(window);
}

/* Rows of an odd number, and of lengths that only sums of many products transform. */
static void circles_have_any_primes(void **state)
{
    static const int wide[] = {418, 290, 434};
    (void) state;
    for (size_t i = 0; i < COUNT(wide); i++) {
        const int w = wide[i], h = w / 2, n = w * h;
        const struct gp_sky_params p =
            sky_params("eye", GP_LATLONG, w, h, 180.0, 1e-3);
        struct gp_sky *sky = sky_of(&p);
        assert_non_null(sky);
        for (int k = 0; k < 3; k++) {
            struct gp_sources src =
                sky_lamps(w, h, k ? 1 : 200, 0, k > 1 ? 1 : h / 3);
            struct gp_planes got = sky_layer(sky, &src);
            double *const want = sky_exact(sky, &src), error = 0.0, norm = 0.0;
            for (int q = 0; q < 3 * n; q++) {
                error += pow((double) got.c[q / n][q % n] - want[q], 2.0);
                norm += want[q] * want[q];
            }
            assert_true(sqrt(error / norm) <= sky->facts.relative);
            gp_planes_free(&got);
            gp_sources_free(&src);
            free(want);
        }
        gp_sky_free(&sky);
    }
}

/* Frames that are no sphere, or that transforms do not take. */
static void others_are_refused(void **state)
{
    (void) state;
    const struct {
        int w, h;
        double x, y;
    } cases[] = {{405, 200, 0, 0},
                 {524, 262, 0, 0},
                 {32, 16, 0, 0},
                 {400, 200, 0.3, 0},
                 {400, 200, 0, 7}};
    for (size_t i = 0; i < COUNT(cases); i++) {
        struct gp_sky_params p =
            sky_params("eye", GP_LATLONG, cases[i].w, cases[i].h, 180.0, 1e-3);
        p.projection.x0 += cases[i].x;
        p.projection.y0 += cases[i].y;
        struct gp_sky *const s = sky_of(&p);
        assert_null(s);
    }
}

/* Pixels of the row at a pole, wedges that all meet there, against the mean over both of
 * them by solid angle, of latitudes and of what is between their longitudes. */
static void wedges_at_a_pole_are_as_defined(void **state)
{
    enum { PARTS = 240 };
    static const int to[][2] = {{1, 0}, {9, 0}, {W / 4, 0}, {W / 2, 0}, {0, 1}};
    const double row = M_PI / H;
    struct gp_sky_params p;
    (void) state;
    struct gp_sky *sky = sphere_of("eye", &p);
    struct gp_sources src = sky_lamps(W, H, 1, 0, 0);
    double *const got = sky_exact(sky, &src), whole = 0.0;
    for (int i = 0; i < 200000; i++) {
        const double u = (i + 0.5) / 200000.0, t = M_PI * u * u * u * u;
        whole += p.part[0].light(&p.part[0], 0, fmin(t * 180.0 / M_PI, 100.0)) *
                 2.0 * M_PI * sin(t) * 4.0 * M_PI * u * u * u / 200000.0;
    }
    for (size_t i = 0; i < COUNT(to); i++) {
        double sum = 0.0, all = 0.0;
        for (int k = 0; k < PARTS * PARTS * PARTS; k++) {
            // denser towards the pole
            const double a = pow((k % PARTS + 0.5) / PARTS, 2.0) * row;
            const double v = (k / PARTS % PARTS + 0.5) / PARTS;
            const double b = (to[i][1] + (to[i][1] ? v : v * v)) * row;
            const double u = 2.0 * (k / PARTS / PARTS + 0.5) / PARTS - 1.0;
            const double turn = 0.5 * (to[i][0] + u) * 2.0 * M_PI / W;
            const double half = pow(sin(0.5 * (a - b)), 2.0) +
                                sin(a) * sin(b) * pow(sin(turn), 2.0);
            const double by = (1.0 - fabs(u)) * sin(a) * sin(b) * sqrt(a) *
                              (to[i][1] ? 1.0 : sqrt(b));
            all += by;
            sum += by * p.part[0].light(&p.part[0], 0,
                                        360.0 / M_PI * asin(sqrt(half)));
        }
        const double want = sum / all / whole * (1.0 - p.part[0].stays) *
                            src.rgb[0][0] * 2.0 * M_PI / W * (1.0 - cos(row));
        const double share = got[to[i][1] * W + to[i][0]] / want;
        if (fabs(share - 1.0) > 0.02)
            print_message("# %d, %d: %g of it\n", to[i][0], to[i][1], share);
        assert_true(fabs(share - 1.0) <= 0.02);
    }
    gp_sources_free(&src);
    gp_sky_free(&sky);
    free(got);
}

/* Pixels beyond a fisheye's rim are dark, and the rest as they are defined; and the
 * share of light that falls beyond is what the others have not. */
static void fisheyes_have_a_rim(void **state)
{
    enum { SIDE = 150, M = SIDE * SIDE };
    static const enum gp_projecting kinds[] = {GP_FISHEYE, GP_EQUISOLID};
    static const int places[][2] = {{20, 60}, {75, 75}, {75, 140}, {3, 80}};
    (void) state;
    for (size_t k = 0; k < COUNT(kinds) * COUNT(places); k++) {
        const int *const at = places[k / COUNT(kinds)];
        const struct gp_sky_params p =
            sky_params("eye", kinds[k % COUNT(kinds)], SIDE, SIDE, 180.0, 1e-3);
        struct gp_sky *sky = sky_of(&p);
        assert_non_null(sky);
        struct gp_sources src = sky_lamps(SIDE, SIDE, 1, at[0], at[1]);
        struct gp_planes got = sky_layer(sky, &src);
        double *const want = sky_exact(sky, &src), error = 0.0, norm = 0.0;
        const double omega = gp_projection_solid(&p.projection, at[0], at[1]);
        double kept = gp_sky_facts(sky)->given * (double) src.rgb[0][0] * omega;
        for (int i = 0; i < M; i++) {
            const double u = (i % SIDE - p.projection.x0) * p.projection.dx;
            const double v = (i / SIDE - p.projection.y0) * p.projection.dy;
            const bool out = hypot(u, v) > p.projection.rim;
            assert_true((got.c[0][i] == 0.0f) == out);
            assert_true((want[i] == 0.0) == out);
            error += pow((double) got.c[0][i] - want[i], 2.0);
            norm += want[i] * want[i];
            kept += want[i] *
                    gp_projection_solid(&p.projection, i % SIDE, i / SIDE);
        }
        assert_true(sqrt(error / norm) <= sky->facts.relative);
        kept /= (double) src.rgb[0][0] * omega;
        const double beyond = gp_sky_outside(sky, at[0], at[1]);
        if (fabs(1.0 - kept - beyond) > 2e-3)
            print_message("# at %d, %d: %g beyond, not %g\n", at[0], at[1],
                          beyond, 1.0 - kept);
        assert_true(fabs(1.0 - kept - beyond) <= 2e-3);
        gp_planes_free(&got);
        gp_sources_free(&src);
        gp_sky_free(&sky);
        free(want);
    }
}

SUITE_OF(sphere, NULL, NULL, a_lamp_is_the_same_all_over,
         the_definition_is_the_formula, laws_of_a_sphere_hold,
         circles_have_any_primes, others_are_refused,
         wedges_at_a_pole_are_as_defined, fisheyes_have_a_rim)
