/* What the splat engine keeps from frame to frame; only splat.c and
 * splat_state.c include this. */
#ifndef GP_GLARE_SPLAT_STATE_H
#define GP_GLARE_SPLAT_STATE_H

#include "gl/program.h"
#include "gl/texture.h"
#include "glare/engine.h"

enum { GP_SPLAT_BAND_TEXELS = 1 << 18 };

struct gp_splat {
    struct gp_gl *gl;
    enum gp_gl_choice choice;       // what was asked for when gl was opened
    struct gp_program splat, add;
    struct gp_target total, chunk;  // of one size; chunk only for many sources
    struct gp_texture sources, kernel;
    float *band; // GP_SPLAT_BAND_TEXELS texels on their way in or out

    // what `kernel` holds: a copy, since an address or a checksum that stays
    // the same does not prove that the samples did
    struct gp_planes held;
    size_t held_samples; // room in `held`
    int held_w, held_h;
    bool negative;       // a sample under 0 is in it
};

/* Opens the context that `choice` names and makes the programs, or keeps
 * *state when it has them. The context is current afterwards.
 * Errors: GP_ERR_GL; *state is NULL or closed with gp_splat_close(). */
GP_MUST_CHECK gp_status gp_splat_open(const struct gp_log *log,
                                      enum gp_gl_choice choice, void **state);
void gp_splat_close(void **state);

/* Makes s->kernel the `crop` of k, not empty; uploads only when it holds
 * anything else. Errors: GP_ERR_GL over the texture limit. */
GP_MUST_CHECK gp_status gp_splat_set_kernel(const struct gp_log *log,
                                            struct gp_splat *s,
                                            const struct gp_kernel *k,
                                            struct gp_rect crop);

/* Makes s->sources at least w x h. */
GP_MUST_CHECK gp_status gp_splat_fit_sources(const struct gp_log *log,
                                             struct gp_splat *s, int w, int h);

/* Makes s->total, and s->chunk when `chunks`, w x h. */
GP_MUST_CHECK gp_status gp_splat_fit_targets(const struct gp_log *log,
                                             struct gp_splat *s, int w, int h,
                                             bool chunks);

#endif
