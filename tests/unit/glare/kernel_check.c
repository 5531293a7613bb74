// SPDX-License-Identifier: Apache-2.0
/* glare/kernel_check.c: each rule has kernels that break it, and only it. */
#include "unit.h"
#include "core/memory.h"
#include "glare/kernel_check.h"
#include "model_scene.h"

/* A sample at offset (dx, dy) from the middle of an image. */
typedef double drawing(double dx, double dy);

static double fade(double dx, double dy)
{
    return pow(fmax(1.0 - hypot(dx, dy) / 7.5, 0.0), 2.0);
}

static double cut(double dx, double dy)
{
    return 1.0 / (1.0 + dx * dx + dy * dy);
}

static double box(double dx, double dy)
{
    return fmax(fabs(dx), fabs(dy)) <= 20.0 ? 1.0 : 0.0;
}

/* A lamp in a faint disc with an edge: under 1 % of the light is on it. */
static double halo(double dx, double dy)
{
    const double d = hypot(dx, dy);
    return d < 0.5 ? 1.0 : d < 12.0 ? 1e-5 : 0.0;
}

static double ball(double dx, double dy, double to, double edge, double left)
{
    const double r = hypot(dx, dy);
    const double share = fmin(fmax((to - r) / edge, 0.0), 1.0);
    return cut(dx, dy) * (left + (1.0 - left) * share);
}

/* Light that ends, or drops, over a few pixels and from one to the next. */
static double soft(double dx, double dy)
{
    return ball(dx, dy, 81.0, 2.0, 0.0);
}

static double milli(double dx, double dy)
{
    return ball(dx, dy, 80.0, 1e-3, 2e-3);
}

/* A square on its corner, its edge a pixel wide, in light that goes on. */
static double corner(double dx, double dy)
{
    const double off = (fabs(dx) + fabs(dy)) * sqrt(0.5);
    const double share = fmin(fmax(40.5 - off, 0.0), 1.0);
    return (cut(dx, dy) + 1e-3 * share) *
           pow(fmax(1.0 - hypot(dx, dy) / 95.0, 0.0), 2.0);
}

/* Light that fades to 0, alone and in rings, in spikes and in a lobe. */
static double fades(double dx, double dy)
{
    return cut(dx, dy) * pow(fmax(1.0 - hypot(dx, dy) / 95.0, 0.0), 2.0);
}

static double rings(double dx, double dy)
{
    return fades(dx, dy) * pow(cos(acos(-1.0) * hypot(dx, dy) / 12.0), 2.0);
}

static double spikes(double dx, double dy)
{
    const double off = fmin(fabs(dx - dy), fabs(dx + 2.0 * dy));
    return fades(dx, dy) * (0.05 + exp(-0.5 * off * off));
}

static double bell(double dx, double dy)
{
    return exp(-0.005 * (dx * dx + dy * dy));
}

static double cone(double dx, double dy)
{
    return fmax(1.0 - hypot(dx, dy) / 12.0, 0.0);
}

static double lobe(double dx, double dy)
{
    return hypot(dx, dy) == 2.0 ? -1e-3 : fade(dx, dy);
}

static double moved(double dx, double dy)
{
    return pow(fmax(1.0 - hypot(dx - 3.0, dy) / 4.0, 0.0), 2.0);
}

static double beside(double dx, double dy)
{
    return cone(dx - 1.0, dy + 1.0);
}

static double between(double dx, double dy)
{
    return bell(dx + 2.3, dy);
}

static double half(double dx, double dy)
{
    return dx >= 0.0 ? fade(dx, dy) : 0.0;
}

static double dark(double dx, double dy)
{
    (void) dx;
    (void) dy;
    return -1e-3;
}

static double twins(double dx, double dy)
{
    return moved(dx, dy) + moved(-dx, dy);
}

static double side(double dx, double dy)
{
    const double slope = fmax(1.0 - fabs(dx) / 8.0, 0.0);
    return dy != 0.0 ? 0.0 : dx == 0.0 ? 1.0 : slope * (dx > 0.0 ? 0.1 : 0.02);
}

static double point(double dx, double dy)
{
    return dx == 0.0 && dy == 0.0 ? 1.0 : 0.0;
}

static double blur(double dx, double dy)
{
    return exp(-0.02 * (dx * dx + dy * dy)); // 0.03 % in its own pixel
}

/* Draws channel c times scale[c], shift[c] pixels to the right. */
static struct gp_kernel make_shifted(drawing *draw, int n,
    const double scale[3], const int shift[3])
{
    struct gp_planes p;
    struct gp_kernel k;
    assert_ok(gp_planes_make(NULL, "kernel", (size_t) n * (size_t) n, &p));
    for (int i = 0; i < n * n; i++) {
        const double x = i % n - 0.5 * (n - 1), y = i / n - 0.5 * (n - 1);
        for (int c = 0; c < 3; c++)
            p.c[c][i] = (float) (scale[c] * draw(x - shift[c], y));
    }
    assert_ok(gp_kernel_of_planes(NULL, "kernel", n, n, &p, &k));
    return k;
}

static struct gp_kernel make(drawing *draw, int n, const double scale[3])
{
    return make_shifted(draw, n, scale, (const int[3]) {0, 0, 0});
}

#define BIT(rule) (1u << GP_RULE_##rule)
#define WHITE {1.0, 1.0, 1.0}

static void each_rule_finds_its_fault(void **state)
{
    (void) state;
    static const struct {
        const char *name;
        drawing *draw;
        int n;
        double scale[3];
        struct gp_kernel_use use;
        unsigned faults;
    } rows[] = {
        {"fade", fade, 15, WHITE, {.ends = true, .brightest = 1e6}, 0},
        {"cone", cone, 25, WHITE, {.ends = true, .brightest = 1e6}, 0},
        {"cut", cut, 31, WHITE, {.ends = true, .brightest = 1000.0}, BIT(RIM)},
        {"cut by the frame", cut, 31, WHITE, {.brightest = 1000.0}, 0},
        {"box, with dark around it", box, 61, WHITE,
         {.ends = true, .brightest = 1000.0}, BIT(RIM) | BIT(BORDER)},
        {"halo", halo, 61, WHITE, {.ends = true, .brightest = 1000.0},
         BIT(RIM)},
        {"an edge of two pixels", soft, 201, WHITE,
         {.ends = true, .brightest = 1000.0}, BIT(RIM)},
        {"a drop to 2e-3", milli, 201, WHITE,
         {.ends = true, .brightest = 1000.0}, BIT(RIM)},
        {"a square on its corner", corner, 201, WHITE,
         {.ends = true, .brightest = 1000.0}, BIT(RIM)},
        {"no edge", fades, 201, WHITE, {.ends = true, .brightest = 1000.0}, 0},
        {"rings", rings, 201, WHITE, {.ends = true, .brightest = 1000.0}, 0},
        {"spikes", spikes, 201, WHITE, {.ends = true, .brightest = 1000.0}, 0},
        {"a bell", bell, 201, WHITE, {.ends = true, .brightest = 1000.0}, 0},
        {"lobe", lobe, 15, WHITE, {.ends = true}, BIT(NEGATIVE)},
        {"half beside", fade, 16, WHITE, {.ends = true}, BIT(CENTROID)},
        {"moved", moved, 21, WHITE, {.ends = true}, BIT(PEAK) | BIT(SYMMETRY)},
        {"a pixel beside", beside, 31, WHITE, {.ends = true}, BIT(CENTROID)},
        {"a pixel beside, resampled", beside, 31, WHITE,
         {.ends = true, .resampled = true}, BIT(CENTROID)},
        {"a pixel beside, by a centre that was given", beside, 31, WHITE,
         {.ends = true, .centred = true}, 0},
        {"between pixels", between, 201, WHITE, {.ends = true},
         BIT(CENTROID)},
        {"half of one", half, 21, WHITE, {.brightest = 1.0}, BIT(SYMMETRY)},
        {"no light", dark, 9, WHITE, {.brightest = 1.0},
         BIT(SUM) | BIT(NEGATIVE)},
        {"half beside, resampled", fade, 16, WHITE,
         {.ends = true, .resampled = true}, 0},
        {"lobe, of a centre that was given", lobe, 15, WHITE,
         {.centred = true}, BIT(NEGATIVE)},
        {"twins", twins, 21, WHITE, {.ends = true, .brightest = 1e6}, 0},
        {"to one side", side, 21, WHITE, {.ends = true}, BIT(SYMMETRY)},
        {"point", point, 9, WHITE, {.ends = true, .brightest = 1e9},
         BIT(SIZE)},
        {"no blue", fade, 15, {1.0, 1.0, 0.0}, {.ends = true}, BIT(SUM)},
        {"red under 0", fade, 15, {-1.0, 1.0, 1.0}, {.ends = true},
         BIT(SUM) | BIT(NEGATIVE)},
        {"a sum that is normalised", fade, 15, WHITE, {.ends = true}, 0},
        {"a sum that is not", fade, 15, WHITE,
         {.ends = true, .as_it_is = true}, BIT(SUM)},
        {"a blur that is added", blur, 51, WHITE, {.add = true}, BIT(OWN)},
        {"light left out", fade, 15, WHITE, {.missed = 0.011},
         BIT(LEFT_OUT)},
        {"less of it", fade, 15, WHITE, {.missed = 0.009}, 0},
    };
    unsigned found = 0;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel k = make(rows[i].draw, rows[i].n, rows[i].scale);
        struct gp_kernel_figures f;
        gp_kernel_measure(&k, gp_rec709_luminance, &f);
        unsigned faults = 0;
        for (int rule = 0; rule < GP_KERNEL_RULES; rule++) {
            struct gp_fault fault;
            const bool broken = gp_kernel_fault(&f, &rows[i].use,
                                                (enum gp_kernel_rule) rule,
                                                &fault);
            assert_true(broken == (fault.line[0] != '\0'));
            if (broken && !strchr(fault.line, ';') && !fault.parameter[0])
                fail_msg("does not say what to do: %s", fault.line);
            faults |= broken ? 1u << rule : 0u;
        }
        if (faults != rows[i].faults)
            fail_msg("%s: faults %#x, not %#x", rows[i].name, faults,
                     rows[i].faults);
        found |= faults;
        gp_kernel_free(&k);
    }
    // light of a model that misses the frame, by the share that it takes
    static const struct {
        double left_out, missed, share;
        bool fault;
    } outside[] = {
        {0.101, 0.0, 1.0, true}, {0.099, 0.0, 1.0, false},
        {0.101, 0.003, 1.0, false}, {0.03, 0.0, 0.1, true},
        {0.009, 0.0, 0.1, false}, {0.5, 0.0, 0.0, true},
    };
    for (size_t i = 0; i < COUNT(outside); i++) {
        const struct gp_kernel_figures f = {.left_out = outside[i].left_out};
        const struct gp_kernel_use use = {.missed = outside[i].missed,
                                          .share = outside[i].share};
        struct gp_fault fault;
        const bool broken = gp_kernel_fault(&f, &use, GP_RULE_BEYOND, &fault);
        if (broken != outside[i].fault || (broken && !strchr(fault.line, ';')))
            fail_msg("outside %zu: %s", i, fault.line);
        found |= broken ? BIT(BEYOND) : 0u;
    }
    // NaN makes no kernel: its count is all there is
    const struct gp_kernel_figures bad = {.nonfinite = 3, .measured = true};
    const struct gp_kernel_use use = {.add = true, .ends = true, .missed = 1.0,
                                      .as_it_is = true, .brightest = 1.0};
    for (int rule = 0; rule < GP_KERNEL_RULES; rule++) {
        struct gp_fault fault;
        const bool broken =
            gp_kernel_fault(&bad, &use, (enum gp_kernel_rule) rule, &fault);
        assert_true(broken == (rule == GP_RULE_NONFINITE));
        found |= broken ? 1u << rule : 0u;
    }
    assert_int_equal(found, (1u << GP_KERNEL_RULES) - 1u); // none is left
}

/* A channel that is beside the others is named; a kernel that is beside its
 * centre as a whole is not one of its channels. */
static void a_fault_names_its_channel(void **state)
{
    (void) state;
    static const struct {
        int shift[3];
        const char *peak, *centroid; // begin so
        bool centred;
        double tint[3];
    } rows[] = {
        {{8, 0, 0}, "the peak of its red is 8,0 pixels", "", false, WHITE},
        {{0, 8, 0}, "the peak of its green is 8,0 pixels", "", false, WHITE},
        {{0, 0, -8}, "the peak of its blue is -8,0 pixels", "", false, WHITE},
        {{8, 8, 8}, "its peak is 8,0 pixels", "", false, {1.0, 0.8, 0.6}},
        {{2, 0, 0}, "", "the centroid of its red is 2,0 pixels", false, WHITE},
        {{0, 3, 3}, "", "the centroid of its green is 3,0 pixels", false,
         WHITE},
        {{2, 2, 2}, "", "its centroid is 2,0 pixels", false, {1.0, 0.8, 0.6}},
        {{2, 0, 15}, "the peak of its blue is 15,0 pixels",
         "the centroid of its red is 2,0 pixels", false, WHITE},
        // luminance half a pixel beside
        {{0, 0, 7}, "the peak of its blue is 7,0 pixels", "", false, WHITE},
        {{0, 0, 0}, "", "", false, {1.0, 0.8, 0.6}},
        {{8, 0, 2}, "", "", true, WHITE},
        {{0, 0, 8}, "", "", false, {1.0, 1.0, 1e-4}}, // hardly any light
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_kernel k = make_shifted(cone, 61, rows[i].tint,
                                          rows[i].shift);
        const struct gp_kernel_use use = {.ends = true,
                                          .centred = rows[i].centred};
        struct gp_kernel_figures f;
        gp_kernel_measure(&k, gp_rec709_luminance, &f);
        for (int centroid = 0; centroid < 2; centroid++) {
            const char *const wanted = centroid ? rows[i].centroid
                                                : rows[i].peak;
            struct gp_fault fault;
            gp_kernel_fault(&f, &use, centroid ? GP_RULE_CENTROID
                                               : GP_RULE_PEAK, &fault);
            if (strncmp(fault.line, wanted, strlen(wanted)) != 0 ||
                (fault.line[0] != '\0') != (wanted[0] != '\0'))
                fail_msg("row %zu: \"%s\", not \"%s\"", i, fault.line,
                         wanted);
        }
        gp_kernel_free(&k);
    }
}

SUITE_OF(kernel_check, NULL, NULL, each_rule_finds_its_fault,
         a_fault_names_its_channel)

