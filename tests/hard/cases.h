// SPDX-License-Identifier: Apache-2.0
/* The hard cases, one table: every engine, tone curve, sun method and output
 * format runs through all of them against a plain form in double (hardcases.h).
 * A field that a row does not give has its usual value. */
#ifndef GP_TESTS_HARD_CASES_TABLE_H
#define GP_TESTS_HARD_CASES_TABLE_H

#include "glare_scene.h"
#include "io/grow.h"
#include "views.h"
#include "sun/occluder.h"

/* Contents of the depth plane. Background and surfaces are in blocks. */
enum hard_depth {
    DEPTH_MIXED,    // near and far, 1e10, Inf, NaN, 0 beside each other
    DEPTH_ZERO,     // background 0
    DEPTH_INF,
    DEPTH_NAN,
    DEPTH_1E10,
    DEPTH_HALF_MAX, // 65504
    DEPTH_NEGATIVE, // counts backwards along the axis
    DEPTH_INVERSE,  // 1 / z, background 0
    DEPTH_RAY,
    DEPTH_0_TO_1,   // normalised, background 1
    DEPTH_1_TO_0,   // normalised, reversed: background 0
    DEPTH_ALL_NEAR, // nothing but surfaces
};

/* Bars of one case, a cell for each engine. A bar is of rel_l2; where the
 * exact layer is 0, max_abs must be 0 whatever it says. */
struct hard_bars {
    double direct, fft, splat;
};
#define BARS .bar = {1e-6, 1e-6, 2e-6}
#define OF_KERNEL BARS, .of_kernel = true

struct hard_case {
    const char *name;
    int w, h;
    enum light light;
    int kw, kh, cx, cy; // cx MID: the middle
    enum shape shape;
    struct hard_bars bar;
    float knee, max_value; // max_value 0: none
    bool all_light; // threshold 0, else 1
    int x0, y0;     // corner of the data window
    double own;     // bar of fft's error of a pixel over its own value; 0 none
    bool faint;     // light or kernel have values under FLT_MIN
    bool under;     // the layer has values under FLT_MIN, which GL may lose
    double light_gain, kernel_gain; // times what is usual; 0: 1
    bool of_kernel; // hard for its kernel alone
    const char *recipe; // of the kernel for the frame's field, in place of kw
                        // to shape and kernel_gain
    bool has_far;   // that kernel must
    double fov;     // its display's height, degrees; 0: the usual
    size_t sources; // that there must be; 0 is not checked
    struct gp_rect display; // 0: from the origin, as large as the data window
    bool grown;             // to the union of data and display window
    enum hard_depth depth;
    double sun[3];  // x, y from the data window's corner, radius; 0: in the
                    // middle, of a third of the shorter side
};

static const struct hard_case hard_cases[] = {
    // sizes
    {"1x1", 1, 1, ALL, 9, 7, MID, 0, PEAK, BARS, .sources = 1},
    {"1x1, kernel 1x1", 1, 1, ALL, 1, 1, MID, 0, PEAK, OF_KERNEL},
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
    {"kernel 1x1", 64, 48, FEW, 1, 1, MID, 0, BOX, OF_KERNEL},
    {"even kernel", 64, 48, FEW, 16, 10, MID, 0, PEAK, OF_KERNEL},
    {"kernel 1x31", 64, 48, FEW, 1, 31, MID, 0, PEAK, OF_KERNEL},
    {"kernel over the frame", 40, 30, CORNERS, 200, 151, MID, 0, PEAK,
     OF_KERNEL, .sources = 4},
    {"kernel over the frame, all lit", 40, 30, ALL, 200, 151, MID, 0, TINTED,
     OF_KERNEL, .sources = 1200},
    {"zero borders", 64, 48, FEW, 33, 31, MID, 0, BORDER, OF_KERNEL},
    {"slanted, even about its centre", 64, 48, FEW, 41, 33, MID, 0, SLANT,
     OF_KERNEL},
    {"negative lobes", 64, 48, FEW, 31, 31, MID, 0, LOBES, OF_KERNEL},
    {"negative lobes, all lit", 50, 41, ALL, 31, 31, MID, 0, LOBES, OF_KERNEL},
    {"coloured light, grey kernel", 64, 48, COLOURED, 21, 21, MID, 0, PEAK,
     OF_KERNEL},
    {"coloured light and kernel", 64, 48, COLOURED, 21, 21, MID, 0, TINTED,
     OF_KERNEL},
    {"ring", 64, 48, FEW, 41, 41, MID, 0, RING, OF_KERNEL},
    // what float leaves of the light that falls outside is under 4e-4 of a pixel,
    // but not of the little light that the layer has
    {"ring that the frame cuts off", 9, 9, HOT, 20, 20, MID, 0, RING,
     .bar = {1e-6, 2e-5, 2e-6}, .of_kernel = true, .all_light = true,
     .max_value = 1e10f},

    // centres
    {"centre in a corner", 64, 48, FEW, 13, 11, 0, 10, PEAK, OF_KERNEL},
    {"centre left of the kernel", 64, 48, FEW, 13, 11, -20, 5, PEAK, OF_KERNEL},
    {"centre right below the kernel", 64, 48, FEW, 13, 11, 30, 25, TINTED,
     OF_KERNEL},
    {"centre far left, one source", 97, 1, CORNERS, 3, 1, -50, 0, PEAK,
     OF_KERNEL},
    {"centre far above, one source", 1, 97, CORNERS, 1, 3, 0, 60, PEAK,
     OF_KERNEL},
    {"centre far right, a block", 251, 83, BLOCK, 61, 61, 111, 30, TINTED,
     OF_KERNEL, .sources = 33 * 33},
    {"centre far left and below, a block", 167, 151, BLOCK, 61, 61, -60, 80,
     PEAK, OF_KERNEL, .sources = 33 * 33},
    {"centre out of reach", 64, 48, FEW, 13, 11, 2000, 5, PEAK, OF_KERNEL},
    {"centre as far as it goes", 64, 48, ALL, 13, 11, 1048575, -1048576, PEAK,
     OF_KERNEL},

    // light
    {"none bright", 64, 48, DARK, 31, 31, MID, 0, PEAK, BARS},
    {"all bright", 131, 67, ALL, 31, 30, MID, 0, PEAK, BARS,
     .sources = 131 * 67},
    {"all bright, large kernel", 97, 83, ALL, 51, 51, MID, 0, TINTED, OF_KERNEL,
     .sources = 97 * 83},
    {"1e9 in 1e-3", 128, 96, HOT, 63, 63, MID, 0, PEAK, BARS,
     .max_value = 1e10f, .own = 1e-5, .sources = 1},
    {"1e9 in 1e-3, all lit", 96, 64, HOT, 47, 47, MID, 0, PEAK, BARS,
     .all_light = true, .max_value = 1e10f, .own = 1e-5, .sources = 96 * 64},
    {"1e9 in 1e-3, kernel over the frame", 48, 40, HOT, 129, 129, MID, 0,
     TINTED, OF_KERNEL, .all_light = true, .max_value = 1e10f, .own = 1e-5,
     .sources = 48 * 40},
    {"NaN, Inf, denormals, negative", 89, 53, BAD, 21, 21, MID, 0, PEAK, BARS},
    {"the same, threshold 0", 89, 53, BAD, 21, 21, MID, 0, TINTED, BARS,
     .all_light = true, .faint = true},
    {"the same, 1e30 allowed", 89, 53, BAD, 21, 21, MID, 0, PEAK, BARS,
     .max_value = 1e30f},
    {"denormals alone", 31, 29, DENORMAL, 9, 9, MID, 0, PEAK, BARS,
     .all_light = true, .faint = true},
    {"denormals under a kernel of 1e-30", 30, 31, DENORMAL, 9, 9, MID, 0, PEAK,
     OF_KERNEL, .all_light = true, .kernel_gain = 1e-30, .faint = true},
    {"kernel partly of denormals", 67, 48, FEW, 33, 33, MID, 0, TINTED,
     OF_KERNEL, .kernel_gain = 1e-34, .faint = true},
    {"light partly of denormals, kernel of 1e30", 64, 48, FEW, 33, 33, MID, 0,
     PEAK, OF_KERNEL, .all_light = true, .light_gain = 1e-37,
     .kernel_gain = 1e30, .faint = true},
    {"light of 1e-9, kernel of 1e-20", 64, 48, FEW, 33, 33, MID, 0, TINTED,
     OF_KERNEL, .all_light = true, .light_gain = 1e-13, .kernel_gain = 1e-20},
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
    {"window larger than the display", 80, 60, FEW, 21, 21, MID, 0, PEAK, BARS,
     .x0 = -20, .y0 = -10, .display = {0, 0, 32, 24}},
    {"window smaller than the display", 40, 22, FEW, 21, 21, MID, 0, PEAK, BARS,
     .x0 = 10, .y0 = 8, .display = {0, 0, 64, 48}},
    {"window over the display's corner", 64, 48, FEW, 21, 21, MID, 0, TINTED,
     BARS, .x0 = -30, .y0 = -20, .display = {0, 0, 64, 48}},
    {"negative display, disjoint", 64, 48, FEW, 21, 21, MID, 0, PEAK, BARS,
     .display = {-500, -400, -436, -352}},
    {"window inside the display, grown", 40, 22, FEW, 21, 21, MID, 0, TINTED,
     BARS, .x0 = 10, .y0 = 8, .display = {0, 0, 64, 48}, .grown = true},
    {"window over the display's corner, grown", 64, 48, FEW, 21, 21, MID, 0,
     PEAK, BARS, .x0 = -30, .y0 = -20, .display = {0, 0, 64, 48},
     .grown = true},
    {"negative window beside the display, grown", 24, 18, FEW, 31, 33, MID, 0,
     PEAK, BARS, .x0 = -47, .y0 = -33, .display = {-10, -12, 20, 15},
     .grown = true},

    // light that cancels, light that does not fit
    {"light beside as much negative light", 64, 48, CANCEL, 21, 21, MID, 0,
     PEAK, BARS, .all_light = true, .sources = 64 * 48 / 2},
    {"kernel of sum 0 over even light", 64, 48, FLAT, 2, 1, MID, 0, DIPOLE,
     OF_KERNEL, .sources = 64 * 48},
    {"groups that cancel, kernel of sum 0", 64, 48, BLOCK, 8, 8, MID, 0, DIPOLE,
     OF_KERNEL, .sources = 33 * 33},
    {"over half's 65504", 61, 47, OVER, 21, 21, MID, 0, TINTED, BARS,
     .max_value = 1e7f},
    {"at the ends of half and float", 61, 47, ENDS, 3, 3, MID, 0, PEAK, BARS,
     .max_value = 1e7f},

    // depth
    {"depth 0", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS, .depth = DEPTH_ZERO},
    {"depth Inf", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS, .depth = DEPTH_INF},
    {"depth NaN", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS, .depth = DEPTH_NAN},
    {"depth 1e10", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS, .depth = DEPTH_1E10},
    {"depth 65504", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .depth = DEPTH_HALF_MAX},
    {"depth counted backwards", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .depth = DEPTH_NEGATIVE},
    {"depth as 1/z", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .depth = DEPTH_INVERSE},
    {"depth along the ray", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .depth = DEPTH_RAY},
    {"depth normalised", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .depth = DEPTH_0_TO_1},
    {"depth normalised, reversed", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .depth = DEPTH_1_TO_0},
    {"depth all near", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .depth = DEPTH_ALL_NEAR},

    // suns
    {"sun partly outside", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .sun = {2.3, 20.7, 9.0}},
    {"sun over a corner", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .sun = {64.0, 48.0, 12.0}},
    {"sun wholly outside", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .sun = {-30.0, 20.0, 9.0}},
    {"sun far outside", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .sun = {1e12, -1e12, 9.0}},
    {"sun smaller than a pixel", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .sun = {31.9, 24.4, 0.2}},
    {"sun on a pixel's corner", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .sun = {32.0, 24.0, 0.25}},
    {"sun of 1e-6 pixels", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .sun = {20.5, 30.5, 1e-6}},
    {"sun larger than the frame", 64, 48, FEW, 5, 5, MID, 0, PEAK, BARS,
     .sun = {30.0, 25.0, 400.0}},
};
enum { HARD_CASES = sizeof hard_cases / sizeof *hard_cases };

/* Frames of over 300 pixels a side for kernels over the whole field, which
 * have their far field there; a recipe takes the place of these kernels. */
#define WIDE(name, w, h, light) name, w, h, light, 1, 1, MID, 0, PEAK, BARS
static const struct hard_case hard_wide[] = {
    {WIDE("wide, few bright", 331, 257, FEW)},
    {WIDE("wide, its corners", 317, 211, CORNERS), .sources = 4},
    {WIDE("wide, none bright", 320, 180, DARK)},
    {WIDE("wide, all bright", 401, 10, ALL), .sources = 4010},
    {WIDE("wide, even light", 384, 10, FLAT), .sources = 3840},
    {WIDE("wide, colours", 320, 41, COLOURED)},
    {WIDE("wide, 1e9 in 1e-3", 320, 200, HOT), .max_value = 1e10f,
     .own = 1e-3, .sources = 1},
    {WIDE("wide, 1e9 in 1e-3, all lit", 400, 10, HOT), .max_value = 1e10f,
     .all_light = true, .own = 1e-3, .sources = 4000},
    {WIDE("wide, NaN, Inf, denormals, negative", 331, 97, BAD)},
    {WIDE("wide, the same, 1e30 allowed", 331, 97, BAD), .max_value = 1e30f},
    {WIDE("wide, the same, threshold 0", 331, 12, BAD), .all_light = true,
     .faint = true},
    {WIDE("wide, denormals alone", 300, 13, DENORMAL), .all_light = true,
     .faint = true},
    {WIDE("wide, light of 1e-9", 320, 12, FEW), .all_light = true,
     .light_gain = 1e-13},
    {WIDE("wide, light partly of denormals", 320, 12, FEW), .all_light = true,
     .light_gain = 1e-37, .faint = true, .under = true},
    {WIDE("wide, at the threshold", 333, 12, EDGE), .sources = 333 * 12 / 3},
    {WIDE("wide, knee", 341, 12, RAMP), .knee = 0.5f},
    {WIDE("wide, light beside as much negative light", 400, 10, CANCEL),
     .all_light = true, .sources = 2000},
    {WIDE("wide, over half's 65504", 389, 10, OVER), .max_value = 1e7f},
    {WIDE("wide, at the ends of half and float", 383, 10, ENDS),
     .max_value = 1e7f},
    {WIDE("wide, 1xN", 1, 701, ALL)},
    {WIDE("wide, Nx1", 701, 1, ALL), .fov = 0.05},
    {WIDE("wide, 16384 at 36 pixels a degree", 16384, 3, FEW),
     .fov = 3.0 / 36.0},
    {WIDE("wide, 16384 high", 3, 16384, FEW)},
    {WIDE("wide, 120 degrees", 331, 97, FEW), .fov = 120.0},
    {WIDE("wide, negative window beside the display", 320, 31, FEW),
     .x0 = -1000, .y0 = -77, .sun = {120.0, 15.0, 4.0}},
    {WIDE("wide, window over the display's corner, grown", 280, 40, FEW),
     .x0 = -70, .y0 = -20, .display = {0, 0, 300, 48}, .grown = true,
     .sun = {200.0, 20.0, 5.0}},
    {WIDE("wide, sun partly outside", 300, 60, FEW),
     .sun = {2.3, 20.7, 9.0}},
};
#undef WIDE
enum { HARD_WIDE = sizeof hard_wide / sizeof *hard_wide };

/* Rows about windows, depth and suns have the sun's light in their frame. */
static inline bool hard_is_sunny(const struct hard_case *h)
{
    return h->x0 || h->y0 || !gp_rect_empty(h->display) ||
           h->depth != DEPTH_MIXED || h->sun[2] > 0.0;
}

/* A number of the row's own. */
static inline uint32_t hard_own(const struct hard_case *h)
{
    return (uint32_t) hash_more(HASH_NONE, h->name, strlen(h->name));
}

/* Sunny rows may differ in nothing else: their suns may be hidden, outside. */
static inline struct gp_image hard_frame(const struct hard_case *h)
{
    struct gp_image f = scene_frame(h->w, h->h, h->x0, h->y0, h->light,
                                    hard_is_sunny(h) ? hard_own(h) : 20071u);
    if (!gp_rect_empty(h->display))
        f.display = h->display;
    if (h->grown) {
        const struct gp_grow_params none = {0};
        struct gp_frame grown = frame_of(&f, &f.rgb);
        if (gp_grow(NULL, &none, gp_grow_window(&none, &grown), &grown))
            abort();
        f = view_of(&grown);
    }
    for (int c = 0; c < 3 && h->light_gain > 0.0; c++) {
        for (size_t i = 0; i < gp_image_pixels(&f); i++)
            f.rgb.c[c][i] = (float) ((double) f.rgb.c[c][i] * h->light_gain);
    }
    return f;
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

#endif
