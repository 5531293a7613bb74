// SPDX-License-Identifier: Apache-2.0
/* glare/model/aperture.c and diffract.c against published values and
 * closed forms. */
#include "unit.h"
#include "core/parallel.h"
#include "core/colour.h"
#include "glare/model/model_priv.h"
#include "model_scene.h"

/* Airy's pattern, 550 nm through 1 mm: its first zero, by a parabola through
 * the least pixels, and the light within it. */
static void a_circle_makes_airys_pattern(void **state)
{
    (void) state;
    const double unit = 550e-6 / 1.0 * 180.0 / M_PI; // lambda / D, degrees
    const struct gp_field f = scene_field(321, 321, unit / 20.0, 1.0);
    struct gp_kernel k;
    model_make(AIRY, &f, &k);
    double within = 0.0;
    for (int dy = -30; dy <= 30; dy++) {
        for (int dx = -30; dx <= 30; dx++) {
            // a pixel at the zero by parts
            for (int i = 0; i < 64; i++) {
                const double r = hypot(dx + (i % 8 + 0.5) / 8.0 - 0.5,
                                       dy + (i / 8 + 0.5) / 8.0 - 0.5);
                within += r / 20.0 < 1.219670 ? sample_at(&k, 1, dx, dy) / 64.0
                                              : 0.0;
            }
        }
    }
    if (!(fabs(within / 0.837785 - 1.0) < 1e-3))
        fail_msg("%.5f within the first zero, not 0.83779", within);
    // around its zero v r^3 is even, as J1 falls with the root of r
    double zero = 0.0;
    for (int x = 20; x < 29 && zero == 0.0; x++) {
        double v[3];
        for (int i = 0; i < 3; i++)
            v[i] = sample_at(&k, 1, x + i - 1, 0) * pow(x + i - 1, 3.0);
        if (v[1] < v[0] && v[1] < v[2])
            zero = x + 0.5 * (v[0] - v[2]) / (v[0] - 2.0 * v[1] + v[2]);
    }
    if (!(fabs(zero / 20.0 / 1.219670 - 1.0) < 1e-3))
        fail_msg("first zero at %.5f lambda / D", zero / 20.0);
    gp_kernel_free(&k);
}

/* Light along rays from the centre, by half degrees, between two radii. */
static void find_spikes(const struct gp_kernel *k, double *light, int steps,
                        double from, double to)
{
    memset(light, 0, (size_t) steps * sizeof *light);
    for (int y = -(int) to; y <= (int) to; y++) {
        for (int x = -(int) to; x <= (int) to; x++) {
            const double r = hypot(x, y);
            if (r < from || r > to)
                continue;
            double a = atan2(-y, x) / (2.0 * M_PI) + 1.0;
            a -= floor(a);
            light[(int) (a * steps) % steps] += sample_at(k, 1, x, y) * r;
        }
    }
}

/* n straight blades make n spikes where n is even, 2n where it is odd, across
 * the edges; their directions are means over five degrees. */
static void blades_make_spikes(void **state)
{
    (void) state;
    static const struct {
        int blades, spikes;
        double rotation;
    } rows[] = {{4, 4, 10.0}, {5, 10, 0.0}, {6, 6, 17.3}, {7, 14, 3.0},
                {8, 8, -11.0}};
    enum { STEPS = 3600 };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_field f = scene_field(256, 256, 1.0 / 36.0, 1.0);
        char text[200];
        struct gp_kernel k;
        double light[STEPS];
        const double n = rows[i].blades;
        snprintf(text, sizeof text, "aperture:share=1,blades=%d,roundness=0,"
                 "dust=0,scratches=0,wavelengths=8,reach=28,rotation=%g",
                 rows[i].blades, rows[i].rotation);
        model_make(text, &f, &k);
        find_spikes(&k, light, STEPS, 60.0, 250.0);
        double all = 0.0, inside = 0.0;
        for (int j = 0; j < STEPS; j++)
            all += light[j];
        for (int s = 0; s < rows[i].spikes; s++) {
            // across an edge: its middle is half a blade from a corner
            const double to = rows[i].rotation + 180.0 / n +
                              360.0 * s / rows[i].spikes;
            double sum = 0.0, off = 0.0;
            for (int j = 0; j < STEPS; j++) {
                const double d = remainder((j + 0.5) * 360.0 / STEPS - to,
                                           360.0);
                if (fabs(d) > 2.5)
                    continue;
                sum += light[j];
                off += light[j] * d;
            }
            inside += sum;
            if (!(fabs(off / sum) < 0.1))
                fail_msg("%d blades: spike at %g is %g degrees off",
                         rows[i].blades, to, off / sum);
            // as bright as all others, and darkness between
            if (!(sum > 0.8 * inside / (s + 1)))
                fail_msg("%d blades: no spike at %g", rows[i].blades, to);
        }
        if (!(inside > 0.9 * all))
            fail_msg("%d blades: %g of the light is in spikes", rows[i].blades,
                     inside / all);
        gp_kernel_free(&k);
    }
}

/* All light is in the kernel, but for what the edge's length says is beyond;
 * equal energy light is white. */
static void light_is_kept_and_white(void **state)
{
    (void) state;
    const struct gp_field f = scene_field(256, 256, 1.0 / 36.0, 1.0);
    struct gp_kernel k;
    model_make("aperture:share=1,blades=0,dust=0,scratches=0,pupil=2", &f, &k);
    // 1 - E(r) = l L / (2 pi^2 S r), L / S = 4 / D; half is left in the fade
    const double r = 255.0 / 36.0 * M_PI / 180.0;
    const double beyond = 550e-6 * 4.0 / 2.0 / (2.0 * M_PI * M_PI * r);
    if (!(k.left_out > 0.5 * beyond && k.left_out < 1.5 * beyond))
        fail_msg("%g left out, about %g lies beyond", k.left_out, beyond);
    for (int c = 0; c < 3; c++)
        assert_true(fabs(k.sum[c] - k.sum[1]) < 2e-4);
    assert_false(k.negative);
    gp_kernel_free(&k);
}

/* Diameters by luminance as published; log10, not ln. Watson and Yellott's by
 * their figure: 2 to 8 mm, smaller in old eyes. */
static void pupils_are_as_wide_as_published(void **state)
{
    (void) state;
    static const double rows[][2] = {{0.01, 6.9}, {1, 4.90}, {100, 2.91},
                                     {1e4, 2.14}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        const double got = gp_pupil_moon_spencer(rows[i][0]);
        if (!(fabs(got - rows[i][1]) < 0.0061))
            fail_msg("%g cd/m2: %g mm", rows[i][0], got);
    }
    // no light: 7.75 mm; F = 846 cd/m2 deg2: 7.75 - 5.75 / 3
    assert_true(fabs(gp_pupil_watson(1e-12, 846.0, 28.58) - 7.75) < 1e-3);
    assert_true(fabs(gp_pupil_watson(1.0, 846.0, 28.58) - 5.83333) < 1e-4);
    assert_true(fabs(gp_pupil_watson(1e-12, 846.0, 78.58) -
                     (7.75 + 50.0 * (0.02132 - 0.009562 * 7.75))) < 1e-3);
}

/* Fibres of the lens make a halo at l n / (2 pi r), Simpson 1953: those from
 * 1.5 to 2.5 mm away from the axis at 2.2 to 3.7 degrees. */
static void fibres_make_a_halo(void **state)
{
    (void) state;
    const struct gp_field f = scene_field(100, 100, 0.05, 1.0);
    double light[2][2] = {{0}, {0}}; // within, of the halo
    for (int i = 0; i < 2; i++) {
        struct gp_kernel k;
        char text[100];
        snprintf(text, sizeof text, "temporal:pupil=5,hippus=0,particles=0,"
                 "lashes=0,grating=%d", i);
        model_make(text, &f, &k);
        for (int y = -99; y <= 99; y++) {
            for (int x = -99; x <= 99; x++) {
                const double t = 0.05 * hypot(x, y);
                const double v = sample_at(&k, 1, x, y);
                light[i][0] += t > 0.5 && t < 1.5 ? v : 0.0;
                light[i][1] += t > 2.2 && t < 3.7 ? v : 0.0;
            }
        }
        gp_kernel_free(&k);
    }
    // a cosine's first orders have an eighth of what passes the fibres, which
    // is half of a share of the light
    if (!(light[1][1] > 0.03 && light[1][1] < 0.12 &&
          light[0][1] < 0.002 && light[1][0] < 0.01))
        fail_msg("halo: %g of the light, %g without; %g within it",
                 light[1][1], light[0][1], light[1][0]);
}

SUITE_OF(model_aperture, NULL, NULL, a_circle_makes_airys_pattern,
         blades_make_spikes, light_is_kept_and_white,
         pupils_are_as_wide_as_published, fibres_make_a_halo)

