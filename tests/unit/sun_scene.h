/* What tests of a light's visibility share: lights, planes, occluders. */
#ifndef GP_TESTS_SUN_SCENE_H
#define GP_TESTS_SUN_SCENE_H

#include "core/memory.h"
#include "sun/occluder.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { MODES = 3 }; // of enum gp_sun_outside

static inline void assert_near(double got, double want, double bar,
                               const char *what, int index)
{
    if (!(fabs(got - want) <= bar))
        fail_msg("%s, %d: %.17g, not %.17g: %g over %g", what, index, got,
                 want, fabs(got - want), bar);
}

static inline struct gp_light light_at(double x, double y, double radius)
{
    struct gp_light l = GP_LIGHT_DEFAULTS;
    l.x = x;
    l.y = y;
    l.radius = radius;
    return l;
}

static inline double visibility(const struct gp_occluders *o, int outside,
                                struct gp_light l)
{
    l.visibility = -1.0; // must be written
    gp_sun_exact(o, (enum gp_sun_outside) outside, &l, 1);
    return l.visibility;
}

static inline struct gp_plane plane_of(struct gp_rect window)
{
    struct gp_plane p = {.window = window};
    void *v;
    assert_int_equal(gp_alloc_zero(NULL, "test",
                                   (size_t) gp_rect_w(window) *
                                       (size_t) gp_rect_h(window),
                                   sizeof *p.v, &v), GP_OK);
    p.v = v;
    return p;
}

static inline struct gp_occluders occluders(const struct gp_plane *depth,
                                            const struct gp_plane *mask,
                                            struct gp_rect frame)
{
    struct gp_occluders o = {.depth = depth, .mask = mask, .frame = frame};
    gp_occluders_count(&o);
    return o;
}

#endif
