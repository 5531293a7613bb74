// SPDX-License-Identifier: Apache-2.0
/* Engines: ways to compute the glare layer.
 *
 *   layer(p) = sum over sources q of source(q) * kernel(p - q)
 *
 * the linear convolution, sampled on the frame's pixels, each channel by
 * itself. Every engine is one const descriptor; options, `auto`, tests and
 * bench loop over gp_engines. */
#ifndef GP_GLARE_ENGINE_H
#define GP_GLARE_ENGINE_H

#include "core/image.h"
#include "core/status.h"
#include "gl/gl.h"
#include "glare/edges.h"
#include "glare/kernel.h"
#include "glare/sources.h"
#include "glare/far_field/far_field.h"
#include "glarepp.h"

#include <stdbool.h>

/* Forms in which a polygon is drawn. AUTO: TILE on a software context, else
 * QUAD.
 *   QUAD   a blended quad, opened by the vertex shader
 *   TILE   no primitive at all: for each tile, one fragment pass sums over
 *          the polygons that reach it */
enum gp_primitive { GP_PRIMITIVE_AUTO, GP_PRIMITIVE_QUAD, GP_PRIMITIVE_TILE };

/* Ando et al. 2007, sections 4.1 to 4.3. */
struct gp_splat_params {
    int group;           // N of NxN blocks, a power of two, 1 (off) to 64
    int cluster;         // side of a cluster, a power of two over `group`,
                         // up to 64; 0 (off)
    float cluster_fill;  // share of bright pixels from which an area is one
                         // polygon, in (0, 1]
    float shrink;        // share of the light that shrinking may leave out,
                         // in [0, 1); 0 (off)
    enum gp_primitive primitive;
};
#define GP_SPLAT_DEFAULTS                                                     \
    { .group = 4, .cluster = 8, .cluster_fill = 0.9f, .shrink = 1e-3f }
#define GP_SPLAT_EXACT { .group = 1, .cluster_fill = 0.9f }

struct gp_glare_params {
    const char *engine;        // "auto" or the name of an engine
    float gain;                // of the layer in the composite, >= 0
    float tolerance;           // of rel_l2, for auto, >= 0
    float tolerance_pixel;     // of max_rel, for auto, > 0; 0: none
    const struct gp_sources *taken; // as gp_glare_measure(), for its bound
    enum gp_gl_api gl;
    struct gp_splat_params splat;
    struct gp_surround edges;     // what is beyond the border
    float seen;                // share of a dark pixel that noise of transforms
                               // in float may be: else they are in double
    bool in_double;            // transforms in double, whatever the frame needs
    bool last;                 // no frame follows: no kernel's spectrum is kept
};
#define GP_GLARE_DEFAULTS                                                  \
    {                                                                      \
        .engine = "auto", .gain = 1.0f, .tolerance = 1e-3f, .seen = 4e-4f, \
        .splat = GP_SPLAT_DEFAULTS                                         \
    }

/* Direct work: every source's kernel, cut to the frame. */
struct gp_glare_request {
    const struct gp_log *log;
    const struct gp_glare_params *params;
    const struct gp_sources *src;
    const struct gp_kernel *kernel;
    struct gp_planes *layer;        // w * h planes, made, not cleared
    struct glarepp_layer_facts *stats;
    const struct gp_far_state *far; // of the kernel's far field, which the
                                    // caller adds; NULL: it has none
    double beyond;  // most light from beyond the border, on which the far field
                    // errs too; 0: none
    bool in_double; // transforms are, by the plan
    bool exact;     // true angles are summed as they are defined, not by levels
    double floor; // added to a bound of rel_l2: gp_error_floor_find()
};

/* Bounds the error of a sample of the layer: relative * it + of[channel]. */
struct gp_pixel_error {
    double relative, of[3];
};

struct gp_engine {
    const char *name, *text;

    /* Bounds rel_l2 before any drawing; may keep its work in *state. INFINITY
     * where nothing can be guaranteed. NULL: only run() finds it. */
    gp_status (*bound)(const struct gp_glare_request *req, void **state,
                       double *out);

    /* Bounds the error of a pixel before any drawing; `relative` is INFINITY
     * where nothing can be guaranteed. NULL: the engine never guarantees one. */
    gp_status (*pixel)(const struct gp_glare_request *req, void **state,
                       struct gp_pixel_error *out);

    /* Writes every sample of req->layer, and req->stats; a bound over 0 that
     * is there already stays, and what run() alone finds is added. *state is NULL at first,
     * kept by the caller from frame to frame, and freed by close(), which is
     * NULL where nothing is kept: spectra, GL objects. It never changes a
     * result. */
    gp_status (*run)(const struct gp_glare_request *req, void **state);
    void (*close)(void **state);
};
extern const struct gp_engine gp_engine_direct, gp_engine_fft, gp_engine_splat;
extern const struct gp_engine *const gp_engines[];  // NULL-terminated

/* The glare stage over a sequence. */
struct gp_glare {
    void *state[8];  // one an engine, in the order of gp_engines
    bool warned;     // that no engine keeps the tolerance
    struct gp_far_state *far;
    struct gp_cosines_kept *cosines;
    struct gp_outside *outside; // NULL at first
    struct gp_kernel whole; // of the kernel `whole_of`, for frames of that size
    unsigned long whole_of;
    int whole_w, whole_h;
};

/* Computes f->layer from sources, with the light from beyond the border that
 * p->edges has. No source: the layer is zero, no engine is opened. An engine
 * draws a kernel's core, and the far field is added to that; but `direct`, when
 * named, sums the whole kernel sample by sample.
 *
 * `auto` takes `direct` for a handful of sources, else `fft`, and warns when no
 * engine keeps the tolerances. A frame gets the same engine and the same bytes
 * anywhere in a sequence.
 * Errors: GP_ERR_USAGE unknown engine; GP_ERR_GL from splat. */
GP_MUST_CHECK gp_status gp_glare_run(const struct gp_log *log,
    const struct gp_glare_params *p, struct gp_glare *g,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    struct gp_image *f, struct glarepp_layer_facts *stats);
void gp_glare_close(struct gp_glare *g);

/* The truth: the same sum in double, plain loops when n sources times the
 * kernel's area is small, else a double-precision FFT. Slow; for --verify and
 * tests.
 *   edges  as in gp_glare_params; NULL: black
 *   only   of w * h pixels those that are not 0 are summed, the others NaN, where
 *          light goes by true angles; NULL: all
 *   layer  3 * w * h doubles, plane after plane */
GP_MUST_CHECK gp_status gp_glare_reference(const struct gp_log *log,
                                           const struct gp_surround *edges,
                                           const struct gp_sources *src,
                                           const struct gp_kernel *kernel,
                                           const unsigned char *only,
                                           double *layer);

/* Pixels that stand for a frame: those of at least that luminance in the layer, each
 * for itself, and some by a hash of their place, each for so many. 0: all pixels. */
struct gp_glare_sample {
    float least;
    double each;
};

/* Chooses them, where the sum of n sources by true angles would take minutes: half of
 * those that it can have are the brightest, which have the most of all light, and of
 * all error. Fills `only`, as above. */
struct gp_glare_sample gp_glare_sample(const struct gp_image *f,
                                       const struct gp_planes *layer, double n,
                                       unsigned char *only);

/* Errors of a layer against the truth. The composite is
 * f->rgb + gain * exact, less min(gain, 1) of `taken` where that is not NULL:
 * sources whose light leaves their pixels. NULL: not a sample. */
void gp_glare_measure(const struct gp_image *f, const struct gp_planes *layer,
                      const double *exact, const struct gp_glare_sample *sample,
                      float gain, const struct gp_sources *taken,
                      struct glarepp_errors *out);

// -- the frame and its layer -------------------------------------------------

struct gp_tint_params {
    float tint[3];    // >= 0
    float saturation; // >= 0
};

/* Colours f->layer, which may be empty:
 *   layer = tint (Y + saturation (layer - Y))
 * Y its luminance by the frame's weights; each sample within [0, FLT_MAX], of a
 * part of a layer, which others add up to it, within [-FLT_MAX, FLT_MAX]. */
void gp_layer_tint(const struct gp_tint_params *p, bool part,
                   struct gp_image *f);

struct gp_compose_params {
    float gain;  // >= 0
    enum glarepp_mix mix;
    float dim;   // share of everything that a narrower pupil takes; 0 to 1
    bool last;   // nothing reads f->layer afterwards
};

/* Makes f->lit from f->rgb, f->layer and the sources.
 *   add:     lit = rgb + gain * layer
 *   scatter: lit = rgb - min(gain, 1) * source + gain * layer, which up to a
 *            gain of 1 conserves energy but for what leaves the frame
 * and then lit *= 1 - dim, the whole picture alike.
 * Values over FLT_MAX are clamped to it; then a warning counts them.
 * f->layer may be empty when no pixel is a source: then lit = rgb. f->lit is
 * made when it is empty, else it has the frame's size and is overwritten. With
 * p->last an empty f->lit takes the memory of f->layer, which is empty then.
 * The sources are of f's size. */
GP_MUST_CHECK gp_status gp_compose(const struct gp_log *log,
    const struct gp_compose_params *p, const struct gp_sources *src,
    struct gp_image *f);

#endif
