/* What the splat engine keeps from frame to frame; only splat*.c and their
 * tests include this. */
#ifndef GP_GLARE_SPLAT_STATE_H
#define GP_GLARE_SPLAT_STATE_H

#include "gl/gl.h"
#include "glare/bound/bound.h"
#include "glare/engine.h"
#include "glare/splat/group.h"
#include "glare/splat/plan.h"
#include "glare/splat/tile.h"

#include <stdbool.h>

enum { GP_SPLAT_BAND_TEXELS = 1 << 18 };

/* Programs, made when they are first asked for. */
#define GP_SPLAT_PROGRAMS(X)                                                  \
    X(GP_SPLAT_EXACT_QUAD, "splat.vert", "splat.frag")                        \
    X(GP_SPLAT_SMOOTH_QUAD, "splat.vert", "splat_smooth.frag")                \
    X(GP_SPLAT_TURNED_QUAD, "splat_turn.vert", "splat_turn.frag")             \
    X(GP_SPLAT_POINT, "splat.vert", "splat_point.frag")                       \
    X(GP_SPLAT_GROUP, "add.vert", "group.frag")                               \
    X(GP_SPLAT_ADD, "add.vert", "add.frag")
#define GP_SPLAT_ENUM(name, vert, frag) name,
enum gp_splat_program {
    GP_SPLAT_PROGRAMS(GP_SPLAT_ENUM) GP_SPLAT_PROGRAM_COUNT
};

/* Kernels on GL: one for each blur, and two for single sources. */
enum {
    GP_SPLAT_WHOLE = GP_BLURS, // not blurred, for sensors on whole pixels
    GP_SPLAT_CORE,             // GP_CORE_RADIUS pixels around the centre
    GP_SPLAT_TURNED,           // as it was before --rotate
    GP_SPLAT_KERNELS,
};
struct gp_splat_kernel {
    struct gp_texture texture; // w x h, and a border of `border` texels of 0
    int border;
    int w, h;
    int cx, cy;                // the centre's whole part; may lie outside
    float rest[2];             // what it lacks: 0 or 1/2 each
};

struct gp_splat {
    struct gp_gl *gl;               // NULL before the first drawing
    enum gp_gl_api choice;       // what was asked for when gl was opened
    struct gp_program program[GP_SPLAT_PROGRAM_COUNT];
    struct gp_target total, chunk;  // of one size; chunk only for many polygons
    struct gp_target groups, clusters;
    struct gp_texture sources;
    struct gp_uniform_block reaches;        // of polygons, by gp_source_bin()
    struct gp_tiles *tiles;
    float *band; // GP_SPLAT_BAND_TEXELS texels on their way in or out

    // kernels of one serial, crop, and use
    struct gp_splat_kernel kernel[GP_SPLAT_KERNELS];
    unsigned long serial;
    struct gp_rect crop;
    bool tail, bordered;

    struct gp_splat_plan plan;
    struct gp_bound_cache bounds;
};

/* Makes *state, without a context, or keeps it. Errors: GP_ERR_BUG out of
 * memory. */
GP_MUST_CHECK gp_status gp_splat_make(const struct gp_log *log, void **state);

/* Opens the context that `choice` names, or keeps it; it is current
 * afterwards. Errors: GP_ERR_GL; no context is open then. */
GP_MUST_CHECK gp_status gp_splat_open(const struct gp_log *log,
                                      struct gp_splat *s,
                                      enum gp_gl_api choice);
void gp_splat_close(void **state);

/* Makes a program when it is not there. Errors: GP_ERR_GL. */
GP_MUST_CHECK gp_status gp_splat_use(const struct gp_log *log,
                                     struct gp_splat *s,
                                     enum gp_splat_program which);

/* Drops the kernels when they are not made from this very kernel, crop, and
 * use: `tail` leaves the core out of all but GP_SPLAT_CORE, and `bordered`
 * puts a border around GP_SPLAT_WHOLE and GP_SPLAT_CORE too. */
void gp_splat_set_kernel(struct gp_splat *s, const struct gp_kernel *k,
                         struct gp_rect crop, bool tail, bool bordered);

/* Makes s->kernel[which] when it is not there. A kernel of no samples (a core
 * that the crop does not meet) has w 0 and no texture.
 * Errors: GP_ERR_GL over the texture limit, GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_splat_need_kernel(const struct gp_log *log,
                                             struct gp_splat *s,
                                             const struct gp_kernel *k,
                                             int which);

/* Makes s->sources at least w x h. */
GP_MUST_CHECK gp_status gp_splat_fit_sources(const struct gp_log *log,
                                             struct gp_splat *s, int w, int h);

/* Makes s->total, and s->chunk when `chunks`, w x h. */
GP_MUST_CHECK gp_status gp_splat_fit_targets(const struct gp_log *log,
                                             struct gp_splat *s, int w, int h,
                                             bool chunks);

#endif
