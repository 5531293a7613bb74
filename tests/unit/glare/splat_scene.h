// SPDX-License-Identifier: Apache-2.0
/* The splat engine on made-up scenes, against the plain sum in double. */
#ifndef GP_TESTS_SPLAT_SCENE_H
#define GP_TESTS_SPLAT_SCENE_H

#include "glare/glare_priv.h"
#include "glare/splat/splat_priv.h"
#include "glare_scene.h"

enum { PRIMITIVES = 2 };
static const enum gp_primitive primitives[PRIMITIVES] = {
    GP_PRIMITIVE_QUAD, GP_PRIMITIVE_TILE,
};
static struct glarepp_layer_facts stats; // of the last run
static struct gp_splat_params how = GP_SPLAT_EXACT; // of the next

/* Its centre may be where no kernel that is read has one. */
static inline struct gp_kernel splat_kernel(int w, int h, int cx, int cy,
                                            enum shape shape)
{
    struct gp_kernel k = scene_kernel(w, h, MID, 0, shape);
    k.cx = cx;
    k.cy = cy;
    return k;
}

/* Takes the kernel. Light that is hot or faint is not measured by what is
 * usual. */
static inline struct scene splat_scene(int w, int h, enum light light,
                                       struct gp_kernel k)
{
    return scene_sense(scene_frame(w, h, 0, 0, light, 20071u), k,
                       light == HOT || light == FAINT ? &open_all : &usual);
}

static inline gp_status splat(enum gp_gl_api gl, struct scene *s, void **state)
{
    const struct gp_glare_params params = {.engine = "splat", .gain = 1.0f,
                                           .gl = gl, .splat = how};
    const struct gp_glare_request req = {
        .log = &kept_log, .params = &params, .src = &s->src, .kernel = &s->k,
        .layer = &s->f.layer, .stats = &stats,
    };
    stats = (struct glarepp_layer_facts) {0};
    scene_clear_layer(s);
    return gp_engine_splat.run(&req, state);
}

/* Makes the engine's state with a context, or skips the test without one. */
static inline void *open_or_skip(enum gp_gl_api gl)
{
    void *state = NULL;
    const gp_status st = gp_splat_open(&kept_log, &state, gl);
    if (st == GP_ERR_GL && strstr(kept_line, "install the Debian")) {
        print_message("no context: %s\n", kept_line);
        gp_engine_splat.close(&state);
        skip_for("no GL");
    }
    assert_ok(st);
    return state;
}

/* The same with a driver that draws no side over this many pixels. */
static inline void *open_small_or_skip(const char *side)
{
    set_env("GLAREPP_GL_MAX_SIZE", side);
    void *const state = open_or_skip(GP_GL_AUTO);
    set_env("GLAREPP_GL_MAX_SIZE", NULL);
    return state;
}

/* rel_l2 of the layer against the sum in double. */
static inline double splat_error(struct scene *s)
{
    free(s->exact);
    s->exact = scene_alloc(3 * gp_image_pixels(&s->f), sizeof *s->exact);
    gp_glare_reference_direct(&s->src, &s->k, s->exact);
    return scene_rel_l2(s);
}

#endif
