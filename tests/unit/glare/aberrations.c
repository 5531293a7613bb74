// SPDX-License-Identifier: Apache-2.0
/* glare/model/aperture.c: Zernike's polynomials and the stars they make. */
#include "unit.h"
#include "glare/model/model_priv.h"
#include "model_scene.h"

/* The light at the centre of a small aberration: exp(-(2 pi rms)^2) of that
 * without (Mahajan), as Zernike's polynomials are normalised. */
static void aberrations_dim_the_peak(void **state)
{
    (void) state;
    static const char *const names[] = {
        "tilt", "vertical-tilt", "defocus", "oblique-astigmatism",
        "astigmatism", "vertical-coma", "coma", "vertical-trefoil",
        "oblique-trefoil", "spherical", "secondary-astigmatism",
        "oblique-secondary", "quadrafoil", "oblique-quadrafoil",
    };
    const double unit = 550e-6 * 180.0 / M_PI;
    const struct gp_field f = scene_field(65, 65, unit / 8.0, 1.0);
    struct gp_kernel sharp, k;
    model_make(AIRY, &f, &sharp);
    for (size_t i = 0; i < COUNT(names); i++) {
        char text[200];
        snprintf(text, sizeof text, "%s,%s=0.05", AIRY, names[i]);
        model_make(text, &f, &k);
        const double strehl =
            sample_at(&k, 1, 0, 0) / sample_at(&sharp, 1, 0, 0);
        const double phase = 2.0 * M_PI * 0.05;
        if (!(fabs(strehl / exp(-phase * phase) - 1.0) < 5e-3))
            fail_msg("%s: %.4f of the peak, not %.4f", names[i], strehl,
                     exp(-phase * phase));
        gp_kernel_free(&k);
    }
    // coma's tail lies to the side of its path's mean slope
    for (int s = -1; s <= 1; s += 2) {
        char text[200];
        double at = 0.0;
        snprintf(text, sizeof text, "%s,coma=%g", AIRY, 0.3 * s);
        model_make(text, &f, &k);
        for (int y = -64; y <= 64; y++) {
            for (int x = -64; x <= 64; x++)
                at += s * x * sample_at(&k, 1, x, y);
        }
        // sqrt(8) 0.3 waves to the radius: 2 of that to D, 8 pixels each;
        // light beyond 8 D falls with the distance
        const double mean = sqrt(8.0) * 0.3 * 2.0 * 8.0;
        if (!(at > 0.5 * mean && at < mean))
            fail_msg("coma's mean is at %g of %g pixels", at, mean);
        gp_kernel_free(&k);
    }
    // tilts move the peak: 2 waves rms to the radius, 4 to D
    for (int i = 0; i < 2; i++) {
        static const int at[2][2] = {{16, 0}, {0, -16}};
        char text[200];
        snprintf(text, sizeof text, "%s,%s=0.5", AIRY, names[i]);
        model_make(text, &f, &k);
        const double peak = sample_at(&k, 1, at[i][0], at[i][1]);
        if (!(fabs(peak / sample_at(&sharp, 1, 0, 0) - 1.0) < 1e-3))
            fail_msg("%s: %g of the peak moved", names[i],
                     peak / sample_at(&sharp, 1, 0, 0));
        gp_kernel_free(&k);
    }
    gp_kernel_free(&sharp);
}

/* Light in `turns` sectors of a circle from 0 degrees on, over the mean. */
static void find_sectors(const struct gp_kernel *k, int turns, double *light)
{
    double all = 0.0;
    memset(light, 0, (size_t) turns * sizeof *light);
    for (int y = -100; y <= 100; y++) {
        for (int x = -100; x <= 100; x++) {
            for (int i = 0; i < 16; i++) { // a pixel by parts
                const double u = x + (i % 4 - 1.5) / 4.0;
                const double v = y + (i / 4 - 1.5) / 4.0;
                const double r = hypot(u, v), a = atan2(-v, u) / (2.0 * M_PI);
                if (r < 4.0 || r > 100.0)
                    continue;
                const double one = sample_at(k, 1, x, y) / 16.0;
                light[(int) ((a + 1.0) * turns) % turns] += one;
                all += one;
            }
        }
    }
    for (int i = 0; i < turns; i++)
        light[i] *= turns / all;
}

/* A term that turns m times makes a star of m arms where m is odd, of 2 m or 4
 * equal quarters where it is even; its sine is its cosine, turned. */
static void aberrations_have_their_symmetry(void **state)
{
    (void) state;
    static const struct {
        const char *cosine, *sine;
        double turn;          // degrees, from one to the other
        int arms;
    } rows[] = {
        {"tilt", "vertical-tilt", 90.0, 1},
        {"astigmatism", "oblique-astigmatism", 45.0, 4},
        {"coma", "vertical-coma", 90.0, 1},
        {"oblique-trefoil", "vertical-trefoil", 30.0, 3},
        {"secondary-astigmatism", "oblique-secondary", 45.0, 4},
        {"quadrafoil", "oblique-quadrafoil", 22.5, 8},
    };
    enum { SECTORS = 48 };
    const struct gp_field f = scene_field(121, 121, 550e-6 * 180.0 / M_PI / 8.0,
                                          1.0);
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel k[2];
        double light[2][SECTORS];
        char text[200];
        snprintf(text, sizeof text, "%s,%s=0.5,rotation=%g", AIRY,
                 rows[i].cosine, rows[i].turn);
        model_make(text, &f, &k[0]);
        snprintf(text, sizeof text, "%s,%s=0.5", AIRY, rows[i].sine);
        model_make(text, &f, &k[1]);
        double most = 0.0, least = 1e9;
        for (int j = 0; j < 2; j++)
            find_sectors(&k[j], SECTORS, light[j]);
        for (int j = 0; j < SECTORS; j++) {
            const double a = light[1][j];
            const double b = light[1][(j + SECTORS / rows[i].arms) % SECTORS];
            most = fmax(most, a);
            least = fmin(least, a);
            if (!(fabs(a - light[0][j]) < 0.03))
                fail_msg("%s: %g of the mean in sector %d, %g of its cosine",
                         rows[i].sine, a, j, light[0][j]);
            if (!(fabs(a - b) < 0.05))
                fail_msg("%s: %g in sector %d, %g an arm on", rows[i].sine, a,
                         j, b);
        }
        if (!(most > 1.15 * least))
            fail_msg("%s is round: %g to %g", rows[i].sine, least, most);
        gp_kernel_free(&k[0]);
        gp_kernel_free(&k[1]);
    }
}

SUITE_OF(aberrations, NULL, NULL, aberrations_dim_the_peak,
         aberrations_have_their_symmetry)

