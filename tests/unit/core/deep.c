// SPDX-License-Identifier: Apache-2.0
/* core/deep.c: what shows behind samples, and how they are laid, by closed forms. */
#include "unit.h"
#include "core/deep.h"

#include <math.h>
#include <stdlib.h>

enum { MOST = 4 };

struct pixel {
    int n;
    float z[MOST], back[MOST], alpha[MOST], light[MOST];
};

static struct gp_deep deep_of(const struct pixel *p, int64_t first[2])
{
    first[0] = 0;
    first[1] = p->n;
    return (struct gp_deep) {
        .window = {3, -2, 4, -1},
        .first = first,
        .z = p->z,
        .back = p->back,
        .alpha = p->alpha,
        .colour = {p->light, p->light, p->light},
    };
}

static void near_to(double got, double want)
{
    if (!(fabs(got - want) < 2e-6))
        fail_msg("%.9g, not %.9g", got, want);
}

static void light_goes_through_what_is_before_it(void **state)
{
    const struct pixel p = {
        4, {5, 2, 8, NAN}, {5, 6, 8, 9}, {0.5f, 0.75f, 1, 1}, {0}};
    int64_t first[2];
    const struct gp_deep d = deep_of(&p, first);
    near_to(gp_deep_clear(&d, 3, -2, 1.0), 1.0);
    near_to(gp_deep_clear(&d, 3, -2, 4.0), 0.5); // half of the volume
    near_to(gp_deep_clear(&d, 3, -2, 5.0), pow(0.25, 0.75)); // a surface there
    near_to(gp_deep_clear(&d, 3, -2, 7.0), 0.125);
    near_to(gp_deep_clear(&d, 3, -2, INFINITY), 0.0);
    near_to(gp_deep_clear(&d, 4, -2, INFINITY), 1.0); // beside the window
}

/* The light and alpha of a pixel. */
static void flat(const struct pixel *p, double light, double alpha)
{
    int64_t first[2];
    const struct gp_deep d = deep_of(p, first);
    struct gp_planes out = {0};
    float a = -1.0f;
    assert_ok(gp_planes_make(NULL, "test", 1, &out));
    assert_ok(gp_deep_flatten(NULL, &d, &out, &a));
    near_to((double) out.c[0][0], light);
    near_to((double) out.c[2][0], light);
    near_to((double) a, alpha);
    gp_planes_free(&out);
}

static void samples_are_laid_in_order(void **state)
{
    flat(&(struct pixel) {0}, 0.0, 0.0);
    // surfaces, the farther one first
    flat(&(struct pixel) {2, {9, 4}, {9, 4}, {0.5f, 0.25f}, {0.4f, 0.1f}},
         0.1 + 0.75 * 0.4, 1.0 - 0.75 * 0.5);
    // a surface in the middle of a volume, whose halves hide one half each
    flat(&(struct pixel) {2, {4, 2}, {4, 6}, {1, 0.75f}, {0.3f, 0.6f}},
         0.6 * 0.5 / 0.75 + 0.5 * 0.3, 1.0);
    // two volumes in one place: u = 2 log 2, both light as much
    flat(&(struct pixel) {2, {1, 1}, {3, 3}, {0.5f, 0.5f}, {0.5f, 0}},
         0.5 * 0.75, 0.75);
    // one wholly in another
    flat(&(struct pixel) {2, {0, 1}, {4, 2}, {0.9375f, 0.5f}, {0, 0.5f}},
         0.5 * 0.5 * 0.75, 1.0 - 0.0625 * 0.5);
    // without alpha, light is added; walls in one place share it
    flat(&(struct pixel) {2, {1, 2}, {1, 3}, {0, 0}, {0.25f, 0.5f}}, 0.75, 0.0);
    flat(&(struct pixel) {2, {1, 1}, {1, 1}, {1, 1}, {0.2f, 0.4f}}, 0.3, 1.0);
    // no order of samples matters
    flat(
        &(struct pixel) {
            3, {1, 3, 2}, {1, 5, 2}, {0.5f, 0.5f, 0.5f}, {0.1f, 0.2f, 0.3f}},
        0.1 + 0.15 + 0.05, 0.875);
    flat(
        &(struct pixel) {
            3, {3, 2, 1}, {5, 2, 1}, {0.5f, 0.5f, 0.5f}, {0.2f, 0.3f, 0.1f}},
        0.1 + 0.15 + 0.05, 0.875);
}

SUITE_OF(deep, NULL, NULL, light_goes_through_what_is_before_it,
         samples_are_laid_in_order)
