/* glare/model/diffract_far.c: spikes of blades where no transform reaches,
 * against the transform of a polygon. */
#include "unit.h"
#include "glare/model/model_priv.h"
#include "model_scene.h"

enum { OFFSETS = 300 };
static const double pixel = 0.03;     // degrees
static const double radius = 3.125;   // mm, 50 mm at f/8

static void whole(const char *keys, double reach, struct gp_kernel *k)
{
    const struct gp_field f = scene_field(OFFSETS, OFFSETS, pixel, 1.0);
    struct gp_kernel core;
    char text[200];
    snprintf(text, sizeof text, "aperture:share=1,dust=0,scratches=0,fnumber=8,"
             "focal=50,rotation=7,wavelength=550,reach=%g,%s", reach, keys);
    model_make(text, &f, &core);
    assert_ok(gp_kernel_whole(NULL, &core, f.w, f.h, k));
    gp_kernel_free(&core);
}

/* A window from t0 to t0 + 1 without edges, as pixels of a ring with edges are
 * few. */
static double window(double t, double t0)
{
    const double z = t - t0;
    return z > 0.0 && z < 1.0 ? pow(sin(M_PI * z), 2.0) : 0.0;
}

/* Light of the window from t0 degrees, within `side` degrees of the spike at
 * `at` degrees, counter-clockwise: the distance along the circle, or its angle. */
static double spike(const struct gp_kernel *k, double at, double t0,
                    double side, bool by_angle)
{
    double sum = 0.0;
    for (int y = -OFFSETS; y <= OFFSETS; y++) {
        for (int x = -OFFSETS; x <= OFFSETS; x++) {
            const double t = pixel * hypot(x, y);
            const double a = remainder(atan2(-y, x) - at * M_PI / 180.0,
                                       2.0 * M_PI);
            const double s = fabs(a) * (by_angle ? 180.0 / M_PI : t);
            if (t > t0 && t < t0 + 1.0 && s < side)
                sum += window(t, t0) * sample_at(k, 0, x, y);
        }
    }
    return sum;
}

/* Each of a polygon's n edges, L long, sends out on both sides
 *   L l / (4 pi^2 A) / t^2
 * at t radians, A being the polygon's area: as far as the recipe says, not the
 * transform, which ends at 4.9 degrees. */
static void edges_send_out_their_light(void **state)
{
    (void) state;
    static const struct {
        const char *keys;
        int blades;
        double fan;     // degrees, half of what an arc turns
    } rows[] = {
        {"blades=5,roundness=0", 5, 0.0},
        {"blades=6,roundness=0", 6, 0.0},
        {"blades=6,roundness=0.1", 6, 2.87},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel k;
        const int n = rows[i].blades;
        const double length = 2.0 * radius * sin(M_PI / n);
        // arcs bulge by segments of their circles
        const double bend = rows[i].fan * M_PI / 180.0;
        const double segment = bend > 0.0
            ? pow(0.5 * length / sin(bend), 2.0) * (bend - 0.5 * sin(2.0 * bend))
            : 0.0;
        const double arc = bend > 0.0 ? length * bend / sin(bend) : length;
        const double area = 0.5 * n * radius * radius * sin(2.0 * M_PI / n) +
                            n * segment;
        const double edge =
            arc * 550e-6 / (4.0 * M_PI * M_PI * area) * 180.0 / M_PI;
        whole(rows[i].keys, 30.0, &k); // they fade from 7.5 degrees on
        for (double t = 2.0; t < 7.0; t += 1.0) {
            double want = 0.0;
            for (int j = 0; j < 100; j++) {
                const double at = t + (j + 0.5) / 100.0;
                want += (n % 2 ? 1.0 : 2.0) * edge * window(at, t) /
                        (100.0 * at * at);
            }
            for (int j = 0; j < n; j++) {
                const double at = 7.0 + 360.0 * (j + 0.5) / n;
                // 12 pixels beside the fan are nearly all of it
                const double got = rows[i].fan > 0.0
                    ? spike(&k, at, t, rows[i].fan + 2.0, true)
                    : spike(&k, at, t, 12.0 * pixel, false);
                // over the join one wavelength has its fringes
                if (!(fabs(got / want - 1.0) < (t == 3.0 ? 0.07 : 0.03)))
                    fail_msg("%s: edge %d sends out %.4g from %g degrees, not "
                             "%.4g", rows[i].keys, j, got, t, want);
            }
        }
        gp_kernel_free(&k);
    }
}

/* A straight blade's spike stays as narrow, an arc's widens as a fan; both fade
 * before the recipe's reach, and the light they lack, under 0.2 % of all, is in
 * the centre. */
static void spikes_keep_their_width(void **state)
{
    (void) state;
    struct gp_kernel straight, round, near;
    whole("blades=6,roundness=0", 30.0, &straight);
    whole("blades=6,roundness=0.1", 30.0, &round);
    whole("blades=6,roundness=0", 3.7, &near);
    for (double t = 2.0; t < 7.0; t += 1.0) {
        const double all = spike(&straight, 37.0, t, 10.0, true);
        const double line = spike(&straight, 37.0, t, 0.06, false);
        if (!(line > 0.85 * all))
            fail_msg("%g of a straight spike within 2 pixels at %g degrees",
                     line / all, t);
        const double even = spike(&round, 37.0, t, 10.0, true);
        const double half = spike(&round, 37.0, t, 1.435, true);
        if (!(fabs(half / even - 0.5) < 0.06))
            fail_msg("%g of a fan in its half at %g degrees", half / even, t);
    }
    const double end = spike(&near, 37.0, 5.0, 0.06, false);
    assert_true(end < 0.5 * spike(&straight, 37.0, 5.0, 0.06, false));
    const double own = sample_at(&near, 0, 0, 0);
    const double lacks = own - sample_at(&straight, 0, 0, 0);
    if (!(lacks > 0.0 && lacks < 2e-3))
        fail_msg("%g of all light is not in the spikes", lacks);
    gp_kernel_free(&straight);
    gp_kernel_free(&round);
    gp_kernel_free(&near);
}

/* The brightest light, in luminance, of pixels t degrees away. */
static double brightest(const struct gp_kernel *k, double t)
{
    double most = 0.0;
    for (int y = -OFFSETS; y <= OFFSETS; y++) {
        for (int x = -OFFSETS; x <= OFFSETS; x++) {
            double v = 0.0;
            if (fabs(hypot(x, y) - t / pixel) > 0.8)
                continue;
            for (int c = 0; c < 3; c++)
                v += (double) gp_rec709_luminance[c] * sample_at(k, c, x, y);
            most = fmax(most, v);
        }
    }
    return most;
}

/* Spikes of any pupil taper into a haze: the brightest light around a lamp
 * never falls faster than by the inverse 12th power of the distance. Those of
 * blades fall by the 2nd, and by up to the 25th if they end where means begin. */
static void spikes_have_no_rim(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        double reach;
    } rows[] = {
        {"temporal:wavelengths=16,fibres=2", 4.9},
        {"aperture:wavelengths=16,reach=4", 4.0},
        {"aperture:wavelengths=16,dust=0,scratches=0,mask=m,reach=4", 4.0},
        {"aperture:wavelengths=16,dust=0,scratches=0,reach=4,blades=5,"
         "roundness=0", 4.0},
        {"aperture:wavelengths=16,fnumber=8,focal=50,reach=4.5,blades=5,"
         "roundness=0.05", 4.5},
    };
    const struct gp_field f = scene_field(OFFSETS, OFFSETS, pixel, 1.0);
    struct gp_frame mask = gp_frame_blank((struct gp_rect) {0, 0, 64, 48});
    assert_ok(gp_planes_make(NULL, "rgb", 64 * 48, &mask.rgb));
    for (int i = 0; i < 3 * 64 * 48; i++)
        mask.rgb.c[i % 3][i / 3] = 1.0f;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_recipe r = scene_recipe(rows[i].text);
        struct gp_kernel core, k;
        double before = 0.0;
        r.image = strstr(rows[i].text, "mask") ? &mask : NULL;
        assert_ok(gp_model_kernel(NULL, &r, 1, &f, &core));
        gp_recipe_free(&r);
        assert_ok(gp_kernel_whole(NULL, &core, f.w, f.h, &k));
        gp_kernel_free(&core);
        for (double t = 0.4 * rows[i].reach; t < 8.9; t *= 1.05) {
            const double v = brightest(&k, t);
            const double power = log(before / v) / log(1.05);
            if (before > 0.0 && !(power < 12.0))
                fail_msg("%s: %g degrees away light falls by the power %g",
                         rows[i].text, t, power);
            before = v;
        }
        gp_kernel_free(&k);
    }
    gp_frame_free(&mask);
}

/* Luminance across the spike at `at` degrees, counter-clockwise: of a place
 * `t` degrees from the light and `s` beside the spike, from the pixels around,
 * a square degree. */
static double across(const struct gp_kernel *k, double at, double t, double s)
{
    const double a = at * M_PI / 180.0;
    const double x = (t * cos(a) - s * sin(a)) / pixel;
    const double y = -(t * sin(a) + s * cos(a)) / pixel;
    const int i = (int) floor(x), j = (int) floor(y);
    double sum = 0.0;
    for (int n = 0; n < 4; n++) {
        const double u = n % 2 ? x - i : 1.0 - (x - i);
        const double v = n / 2 ? y - j : 1.0 - (y - j);
        for (int c = 0; c < 3; c++)
            sum += u * v * (double) gp_rec709_luminance[c] *
                   sample_at(k, c, i + n % 2, j + n / 2);
    }
    return sum / (pixel * pixel);
}

/* A spike is a needle from 1 degree to its reach, of one wavelength as of many:
 * it keeps its width at half of its height over the light beside it, and its
 * light falls with each step, but for 5 % where samples of one wavelength or
 * pixels of a line that is not theirs ripple. */
static void spikes_are_needles(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        double at, reach;
    } rows[] = {
        {"aperture", 90.0, 12.0}, {"aperture", 30.0, 12.0},
        {"aperture:wavelength=550", 90.0, 12.0},
        {"aperture:wavelengths=256,reach=8", 90.0, 8.0},
        {"aperture:fnumber=8,focal=50,blades=5,rotation=54", 90.0, 12.0},
    };
    const struct gp_field f = scene_field(OFFSETS, OFFSETS, pixel, 1.0);
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel core, k;
        double before = INFINITY, first = 0.0;
        model_make(rows[i].text, &f, &core);
        assert_ok(gp_kernel_whole(NULL, &core, f.w, f.h, &k));
        gp_kernel_free(&core);
        for (double t = 1.0; t < fmin(0.95 * rows[i].reach, 8.5); t += 0.1) {
            // pixels beside the spike's axis, in means over 0.5 degree along it
            double v[80] = {0}, height, width = 0.0;
            for (int j = 0; j < 80; j++) {
                for (int n = 0; n < 16; n++)
                    v[j] += across(&k, rows[i].at, t + n / 32.0,
                                   0.25 * pixel * j) / 16.0;
            }
            height = v[0] - v[79];
            for (int j = 0; j < 80 && v[j] - v[79] > 0.5 * height; j++)
                width = 0.5 * pixel * (j + 1);
            if (!(v[0] < 1.05 * before))
                fail_msg("%s: %g degrees away a spike is %g of what it is 0.1 "
                         "before", rows[i].text, t, v[0] / before);
            before = v[0];
            first = first > 0.0 ? first : width;
            if (height > 0.05 * v[79] && !(width < first + pixel))
                fail_msg("%s: %g degrees away a spike is %g degrees wide, at 1 "
                         "degree %g", rows[i].text, t, width, first);
        }
        gp_kernel_free(&k);
    }
}

/* Drawn rays and rings fade before they end, also those of a lamp of +23 EV:
 * from 1e-6 of the light half a degree away to 1/500 of that, which is from
 * white to nothing in a picture, they take a sixth of the distance. Where the
 * window falls by its square at the end it is a hundredth. */
static void drawn_light_fades(void **state)
{
    (void) state;
    static const char *const rows[] = {
        "star", "star:points=5,strands=1", "cross:length=10",
        "streak:length=10,core=0.4", "ring:radius=1.5",
    };
    const struct gp_field f = scene_field(OFFSETS, OFFSETS, pixel, 1.0);
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel k;
        double first = 0.0, white = 0.0, none = 0.0;
        model_make(rows[i], &f, &k);
        for (double t = 0.5; t < 8.9 && none == 0.0; t += pixel) {
            const double v = brightest(&k, t);
            first = fmax(first, v);
            if (white == 0.0 && v < 1e-6 * first)
                white = t;
            if (v < 1e-6 / 500.0 * first)
                none = t;
        }
        if (!(none > 1.16 * white && white > 0.0))
            fail_msg("%s: fades from %g to %g degrees", rows[i], white, none);
        gp_kernel_free(&k);
    }
}

SUITE_OF(spikes, NULL, NULL, edges_send_out_their_light,
    spikes_keep_their_width, spikes_have_no_rim, spikes_are_needles,
    drawn_light_fades)
