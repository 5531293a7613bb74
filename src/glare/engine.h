/* Engines: ways to compute the glare layer.
 *
 *   layer(p) = sum over sources q of source(q) * kernel(p - q)
 *
 * the linear convolution, sampled on the frame's pixels, each channel by
 * itself. Every engine is one const descriptor; options, `auto`, tests and
 * bench loop over gp_engines.
 */
#ifndef GP_GLARE_ENGINE_H
#define GP_GLARE_ENGINE_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/kernel.h"
#include "glare/sensors.h"

enum gp_gl_choice { GP_GL_AUTO, GP_GL_OSMESA, GP_GL_EGL };
enum gp_fft_plan { GP_FFT_PLAN_ESTIMATE, GP_FFT_PLAN_MEASURE };

struct gp_glare_params {
    const char *engine;        // "auto" or the name of an engine
    float gain;                // of the layer in the composite, >= 0
    enum gp_gl_choice gl;
    enum gp_fft_plan fft_plan;
    const char *wisdom;        // file for measured plans; NULL keeps none
};
#define GP_GLARE_DEFAULTS { .engine = "auto", .gain = 1.0f }

/* What an engine did, for the report. Zero and NULL fields were not needed. */
struct gp_glare_stats {
    const char *engine;     // the engine that ran
    char why[160];          // engine_why
    int fft_w, fft_h;       // transform size
    int fft_core;           // radius of the kernel's part that went direct
    size_t hot;             // sources that fft handed to direct
    size_t polygons;        // quads that opened
    double polygon_pixels;  // their area on the layer
    double bound;           // of rel_l2, guaranteed before the run
    const char *gl;         // renderer string of the context
};

/* Direct work: every source's kernel, cut to the frame. */
struct gp_glare_job {
    const struct gp_log *log;
    const struct gp_glare_params *params;
    const struct gp_sources *src;
    const struct gp_kernel *kernel;
    struct gp_planes *layer;        // w * h planes, made, not cleared
    struct gp_glare_stats *stats;
};

struct gp_engine {
    const char *name, *text;

    /* Milliseconds that `run` is expected to take on one core, from counted
     * work. Never from the number of threads: what `auto` picks would then
     * depend on it, and the bytes with it. */
    double (*predict_ms)(const struct gp_glare_job *job);

    /* Writes every sample of job->layer. *state is NULL at first, kept by the
     * caller from frame to frame, and freed by close(): spectra, plans, GL
     * objects. It never changes a result. */
    gp_status (*run)(const struct gp_glare_job *job, void **state);
    void (*close)(void **state);
};
extern const struct gp_engine gp_engine_direct, gp_engine_fft, gp_engine_splat;
extern const struct gp_engine *const gp_engines[];  // NULL-terminated

/* The glare stage over a sequence. */
struct gp_glare {
    void *state[8];  // one an engine, in the order of gp_engines
};

/* Computes f->layer from sources. No source: the layer is zero, no engine is
 * opened. `auto` takes the engine with the fewest predicted milliseconds.
 * Errors: GP_ERR_USAGE unknown engine; GP_ERR_GL from splat.
 */
GP_MUST_CHECK gp_status gp_glare_run(const struct gp_log *log,
                                     const struct gp_glare_params *p,
                                     struct gp_glare *g,
                                     const struct gp_sources *src,
                                     const struct gp_kernel *kernel,
                                     struct gp_frame *f,
                                     struct gp_glare_stats *stats);
void gp_glare_close(struct gp_glare *g);

/* The truth: the same sum in double, plain loops when n sources times the
 * kernel's area is small, else a double-precision FFT. Slow; for --verify and
 * tests. `layer` has 3 * w * h doubles, plane after plane. */
GP_MUST_CHECK gp_status gp_glare_reference(const struct gp_log *log,
                                           const struct gp_sources *src,
                                           const struct gp_kernel *kernel,
                                           double *layer);
/* The plain loops alone, for tests that check the FFT reference. */
void gp_glare_reference_direct(const struct gp_sources *src,
                               const struct gp_kernel *kernel, double *layer);

/* Errors of a layer against the truth; design.md section 6. */
struct gp_glare_error {
    double rel_l2, max_rel, max_abs, flux_error;
};
void gp_glare_measure(const struct gp_frame *f, const struct gp_planes *layer,
                      const double *exact, float gain,
                      struct gp_glare_error *out);

#endif
