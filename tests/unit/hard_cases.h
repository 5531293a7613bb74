/* The hard cases of the glare engines, one table: every engine of gp_engines
 * runs through all of them against the reference in double, and each cell has
 * its own bar. */
#ifndef GP_TESTS_HARD_CASES_H
#define GP_TESTS_HARD_CASES_H

#include "glare_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Bars of one case, a cell for each engine. A bar is of rel_l2; where the
 * exact layer is 0, max_abs must be 0 whatever it says. */
struct hard_bars {
    double direct, fft, splat;
};
#define BARS .bar = {1e-6, 1e-6, 2e-6}

struct hard_case {
    const char *name;
    int w, h;
    enum light light;
    int kw, kh, cx, cy; // cx MID: the middle
    enum shape shape;
    struct hard_bars bar;
    float knee, max_value; // max_value 0: the default
    bool all_light; // threshold 0, else 1
    int x0, y0;     // corner of the data window
    double own;     // bar of fft's error of a pixel over its own value; 0 none
    double abs;     // bar of max_abs in place of rel_l2; 0 none
    size_t sources; // that there must be; 0 is not checked
};

/* GL may take denormals for 0, so light under FLT_MIN may be lost. */
static const struct hard_case hard_cases[] = {
    // sizes
    {"1x1", 1, 1, ALL, 9, 7, MID, 0, PEAK, BARS, .sources = 1},
    {"1x1, kernel 1x1", 1, 1, ALL, 1, 1, MID, 0, PEAK, BARS},
    {"1xN", 1, 97, FEW, 33, 33, MID, 0, PEAK, BARS},
    {"Nx1", 97, 1, FEW, 33, 33, MID, 0, TINTED, BARS},
    {"2x2", 2, 2, CORNERS, 3, 3, MID, 0, PEAK, BARS, .sources = 4},
    {"primes", 61, 67, FEW, 31, 29, MID, 0, PEAK, BARS},
    {"larger primes", 211, 151, FEW, 41, 43, MID, 0, TINTED, BARS},
    {"16384 wide", 16384, 3, FEW, 65, 5, MID, 0, PEAK, BARS},
    {"16384 wide, its ends", 16384, 2, CORNERS, 65, 5, MID, 0, PEAK, BARS,
     .sources = 4},
    {"16384 high", 3, 16384, CORNERS, 5, 65, MID, 0, PEAK, BARS},

    // kernels
    {"kernel 1x1", 64, 48, FEW, 1, 1, MID, 0, BOX, BARS},
    {"even kernel", 64, 48, FEW, 16, 10, MID, 0, PEAK, BARS},
    {"kernel 1x31", 64, 48, FEW, 1, 31, MID, 0, PEAK, BARS},
    {"kernel over the frame", 40, 30, CORNERS, 200, 151, MID, 0, PEAK, BARS,
     .sources = 4},
    {"kernel over the frame, all lit", 40, 30, ALL, 200, 151, MID, 0, TINTED,
     BARS, .sources = 1200},
    {"zero borders", 64, 48, FEW, 33, 31, MID, 0, BORDER, BARS},
    {"negative lobes", 64, 48, FEW, 31, 31, MID, 0, LOBES, BARS},
    {"negative lobes, all lit", 50, 41, ALL, 31, 31, MID, 0, LOBES, BARS},
    {"coloured light, grey kernel", 64, 48, COLOURED, 21, 21, MID, 0, PEAK,
     BARS},
    {"coloured light and kernel", 64, 48, COLOURED, 21, 21, MID, 0, TINTED,
     BARS},
    {"ring", 64, 48, FEW, 41, 41, MID, 0, RING, BARS},
    {"ring that the frame cuts off", 9, 9, HOT, 20, 20, MID, 0, RING, BARS,
     .all_light = true, .max_value = 1e10f},

    // centres
    {"centre in a corner", 64, 48, FEW, 13, 11, 0, 10, PEAK, BARS},
    {"centre left of the kernel", 64, 48, FEW, 13, 11, -20, 5, PEAK, BARS},
    {"centre right below the kernel", 64, 48, FEW, 13, 11, 30, 25, TINTED,
     BARS},
    {"centre far left, one source", 97, 1, CORNERS, 3, 1, -50, 0, PEAK, BARS},
    {"centre far above, one source", 1, 97, CORNERS, 1, 3, 0, 60, PEAK, BARS},
    {"centre far right, a block", 251, 83, BLOCK, 61, 61, 111, 30, TINTED,
     BARS, .sources = 33 * 33},
    {"centre far left and below, a block", 167, 151, BLOCK, 61, 61, -60, 80,
     PEAK, BARS, .sources = 33 * 33},
    {"centre out of reach", 64, 48, FEW, 13, 11, 2000, 5, PEAK, BARS},
    {"centre as far as it goes", 64, 48, ALL, 13, 11, 1048575, -1048576, PEAK,
     BARS},

    // light
    {"none bright", 64, 48, DARK, 31, 31, MID, 0, PEAK, BARS},
    {"all bright", 131, 67, ALL, 31, 30, MID, 0, PEAK, BARS,
     .sources = 131 * 67},
    {"all bright, large kernel", 97, 83, ALL, 51, 51, MID, 0, TINTED, BARS,
     .sources = 97 * 83},
    {"1e9 in 1e-3", 128, 96, HOT, 63, 63, MID, 0, PEAK, BARS,
     .max_value = 1e10f, .own = 1e-5, .sources = 1},
    {"1e9 in 1e-3, all lit", 96, 64, HOT, 47, 47, MID, 0, PEAK, BARS,
     .all_light = true, .max_value = 1e10f, .own = 1e-5, .sources = 96 * 64},
    {"1e9 in 1e-3, kernel over the frame", 48, 40, HOT, 129, 129, MID, 0,
     TINTED, BARS, .all_light = true, .max_value = 1e10f, .own = 1e-5,
     .sources = 48 * 40},
    {"NaN, Inf, denormals, negative", 89, 53, BAD, 21, 21, MID, 0, PEAK, BARS},
    {"the same, threshold 0", 89, 53, BAD, 21, 21, MID, 0, TINTED, BARS,
     .all_light = true},
    {"the same, 1e30 allowed", 89, 53, BAD, 21, 21, MID, 0, PEAK, BARS,
     .max_value = 1e30f},
    {"denormals alone", 31, 29, DENORMAL, 9, 9, MID, 0, PEAK, BARS,
     .all_light = true, .abs = (double) FLT_MIN},
    // a third of the pixels is over the threshold, by one step
    {"at the threshold", 63, 47, EDGE, 15, 15, MID, 0, PEAK, BARS,
     .sources = 63 * 47 / 3},
    {"knee", 61, 47, RAMP, 21, 21, MID, 0, PEAK, BARS, .knee = 0.5f},
    {"knee 1", 61, 47, RAMP, 21, 21, MID, 0, PEAK, BARS, .knee = 1.0f},

    // windows
    {"negative window", 64, 48, FEW, 21, 21, MID, 0, PEAK, BARS, .x0 = -1000,
     .y0 = -77},
    {"window beside the display", 64, 48, FEW, 21, 21, MID, 0, PEAK, BARS,
     .x0 = 100000, .y0 = 70000},
};
enum { HARD_CASES = sizeof hard_cases / sizeof *hard_cases };

/* The case without its exact layer. */
static inline struct scene hard_sense(const struct hard_case *h)
{
    struct gp_sensor_params p = GP_SENSOR_DEFAULTS;
    p.threshold = h->all_light ? 0.0f : 1.0f;
    p.knee = h->knee;
    if (h->max_value > 0.0f)
        p.max_value = h->max_value;
    return scene_sense(scene_frame(h->w, h->h, h->x0, h->y0, h->light, 20071u),
                       scene_kernel(h->kw, h->kh, h->cx, h->cy, h->shape), &p);
}

static inline struct scene hard_scene(const struct hard_case *h)
{
    struct scene s = hard_sense(h);
    scene_find_exact(&s);
    return s;
}

/* The bar of an engine; an engine that has none fails its test. */
static inline double hard_bar(const struct hard_case *h, const char *engine)
{
    return strcmp(engine, "direct") == 0  ? h->bar.direct
           : strcmp(engine, "fft") == 0   ? h->bar.fft
           : strcmp(engine, "splat") == 0 ? h->bar.splat
                                          : -1.0;
}

/* Small enough for valgrind. */
static inline int hard_is_quick(const struct hard_case *h)
{
    return h->w * h->h <= 4096 && h->kw * h->kh <= 1024;
}

/* -- running them -----------------------------------------------------------*/

static int quick; // GLAREPP_TEST_QUICK is set: no GL, small cases
static int no_gl; // no GL library on this machine

/* Runs an engine; 0 when it cannot run here for want of GL. */
static inline int ran(const char *engine, struct scene *s, struct gp_glare *g,
                      struct gp_glare_stats *stats, const char *what)
{
    const int is_gl = strcmp(engine, "splat") == 0;
    if (is_gl && (quick || no_gl))
        return 0;
    const gp_status st = scene_run(engine, s, g, stats);
    if (is_gl && st == GP_ERR_GL && strstr(scene_line, "install the Debian")) {
        print_message("splat is left out: %s\n", scene_line);
        no_gl = 1;
        return 0;
    }
    if (st)
        fail_msg("%s, %s: %s", what, engine, scene_line);
    return 1;
}

/* The same for one frame alone. */
static inline int ran_once(const char *engine, struct scene *s,
                           struct gp_glare_stats *stats, const char *what)
{
    struct gp_glare g = {0};
    const int yes = ran(engine, s, &g, stats, what);
    gp_glare_close(&g);
    return yes;
}

/* An engine's bar where nothing is hard. */
static inline double usual_bar(const char *engine)
{
    const double bar = hard_bar(&hard_cases[0], engine);
    if (!(bar > 0.0))
        fail_msg("engine %s has no bar in hard_cases.h", engine);
    return bar;
}

#endif
