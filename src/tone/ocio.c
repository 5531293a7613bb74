// SPDX-License-Identifier: Apache-2.0
#include "tone/ocio.h"

#include "core/bridge.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BLOCK = 4096 }; // pixels at a time: 96 KiB in and out

struct gp_ocio {
    const struct gp_ocio_api *api;
    struct gp_ocio_opened opened;
    bool any_primaries;     // of the params
    bool noted, noted_output; // gp_ocio_note() has printed its lines
    float primaries[8];     // of facts.output_primaries
};

// -- primaries ----------------------------------------------------------------

/* True when two matrices are equal within the rounding of chromaticities. */
static bool is_close(const double a[9], const double b[9])
{
    for (int i = 0; i < 9; i++) {
        if (!(fabs(a[i] - b[i]) < 2e-4))
            return false;
    }
    return true;
}

/* The chromaticities of a space: its light is the same as that of spaces whose
 * white was adapted to the reference's, which are looked at first. */
static bool name_primaries(const struct gp_ocio_light *light, float out[8])
{
#define D65 0.3127f, 0.3290f
    static const float known[][8] = {
        {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, D65},       // BT.709
        {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, D65}, // BT.2020
        {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, D65}, // P3-D65
        {0.64f, 0.33f, 0.21f, 0.71f, 0.15f, 0.06f, D65},       // Adobe RGB
        {0.730f, 0.280f, 0.140f, 0.855f, 0.100f, -0.050f, D65}, // S-Gamut3
        {0.730f, 0.280f, 0.165f, 0.840f, 0.100f, -0.030f, D65}, // V-Gamut
        {1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f / 3, 1.0f / 3}, // CIE XYZ
    };
    double m[9], xyz[9];
    if (!light->known)
        return false;
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        if (gp_rgb_to_rgb(known[k], light->of, m) &&
            is_close(m, light->matrix)) {
            memcpy(out, known[k], sizeof *known);
            return true;
        }
    }
    if (!gp_rgb_to_xyz(light->of, xyz))
        return false;
    gp_multiply3(xyz, light->matrix, m);
    for (int c = 0; c < 4; c++) { // the primaries, then white: their sum
        double v[3];
        for (int i = 0; i < 3; i++)
            v[i] = c < 3 ? m[3 * i + c]
                         : m[3 * i] + m[3 * i + 1] + m[3 * i + 2];
        for (int i = 0; i < 2; i++) {
            out[2 * c + i] = (float) (v[i] / (v[0] + v[1] + v[2]));
            if (!(fabsf(out[2 * c + i]) < 10.0f))
                return false;
            // as they are published, of which the matrix was made
            const float published = roundf(out[2 * c + i] * 1e5f) / 1e5f;
            if (fabsf(published - out[2 * c + i]) < 2e-6f)
                out[2 * c + i] = published;
        }
    }
    return true;
}

/* The matrix from the frame's RGB to the input's; false: none is needed. */
static bool frame_matrix(const struct gp_ocio *ocio, const struct gp_image *f,
                         float out[9])
{
    static const double unit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const struct gp_ocio_light *const in = &ocio->opened.input_light;
    double to[9], back[9], m[9];
    if (ocio->any_primaries || !f->names_chromaticities || !in->known ||
        !gp_rgb_to_rgb(f->chromaticities, in->of, to))
        return false;
    gp_invert3(in->matrix, back);
    gp_multiply3(back, to, m);
    for (int i = 0; i < 9; i++) {
        out[i] = (float) m[i];
        if (!isfinite(out[i]))
            return false;
    }
    return !is_close(m, unit);
}

void gp_ocio_note(const struct gp_log *log, struct gp_ocio *ocio,
                  const struct gp_image *f)
{
    const struct gp_ocio_opened *const opened = &ocio->opened;
    const char *const config = opened->facts.config;
    double m[9];
    if (opened->facts.output && !opened->facts.output_primaries && !ocio->noted_output)
        gp_say_at(log, GP_LEVEL_WARN, "tone.output.primaries", "output space "
                  "%s: primaries unknown (not linear, or %s has no role "
                  "aces_interchange); the lit frame gets no chromaticities",
                  opened->facts.output, config);
    ocio->noted_output = true;
    const bool usable = gp_rgb_to_rgb(f->chromaticities,
                                      opened->input_light.known
                                          ? opened->input_light.of
                                          : gp_rec709_chromaticities, m);
    if (ocio->any_primaries || ocio->noted || !f->names_chromaticities ||
        (opened->input_light.known && usable))
        return;
    ocio->noted = true;
    if (usable)
        gp_say_at(log, GP_LEVEL_WARN, "tone.input", "%s: its chromaticities are "
                  "ignored: it is read as %s, whose primaries are unknown (not "
                  "linear, or %s has no role aces_interchange)", f->path,
                  opened->facts.input, config);
    else
        gp_say_at(log, GP_LEVEL_WARN, "tone.any_primaries", "%s: its "
                  "chromaticities are ignored: they are no colours (red %g,%g, "
                  "white %g,%g); it is read as %s; correct them", f->path,
                  (double) f->chromaticities[0], (double) f->chromaticities[1],
                  (double) f->chromaticities[6], (double) f->chromaticities[7],
                  opened->facts.input);
}

// -- the config ---------------------------------------------------------------

gp_status gp_ocio_open(const struct gp_log *log,
                       const struct glarepp_tone_params *p, struct gp_ocio **out)
{
    char why[2048];
    struct gp_ocio_fault fault;
    struct gp_ocio *o;
    *out = NULL;
    // stays open until the process ends, so that opening it again is cheap
    const struct gp_ocio_api *const api = gp_bridge_open(
        "glarepp-ocio.so", "gp_ocio_api", GP_OCIO_API_VERSION, why, sizeof why);
    if (!api)
        return gp_fail_at(log, GP_ERR_IO, "params.bridges", "OpenColorIO: the "
                          "bridge cannot be opened (%s)", why);
    gp_status st = gp_alloc_zero(log, "OCIO", 1, sizeof *o, &o);
    if (st)
        return st;
    o->api = api;
    st = (gp_status) api->open(p, &o->opened, &fault);
    if (st) {
        gp_free(o);
        return gp_fail_at(log, st, fault.parameter, "%s", fault.line);
    }
    o->any_primaries = p->any_primaries;
    if (name_primaries(&o->opened.output_light, o->primaries))
        o->opened.facts.output_primaries = o->primaries;
    *out = o;
    return GP_OK;
}

void gp_ocio_close(struct gp_ocio **ocio)
{
    if (*ocio)
        (*ocio)->api->close(&(*ocio)->opened);
    GP_FREE(*ocio);
}

const struct glarepp_plan_facts *gp_ocio_facts(const struct gp_ocio *ocio)
{
    return &ocio->opened.facts;
}

// -- pixels ------------------------------------------------------------------

struct ocio_pass {
    const struct gp_ocio_api *api;
    const void *processor;
    const struct gp_planes *in;
    struct gp_planes *out;
    float scale;
    bool mixed;
    float matrix[9]; // if mixed: frame to input space, row-major
    size_t pixels;
};

static gp_status pass_block(void *ctx, int block, int thread)
{
    const struct ocio_pass *p = ctx;
    const size_t at = (size_t) block * BLOCK, left = p->pixels - at;
    const size_t n = left < BLOCK ? left : BLOCK;
    (void) thread;
    const float *const in[3] = {p->in->c[0] + at, p->in->c[1] + at,
                                p->in->c[2] + at};
    for (int c = 0; c < 3; c++) {
        const float *const m = p->matrix + 3 * c;
        float *const out = p->out->c[c] + at;
        for (size_t i = 0; i < n && p->mixed; i++)
            out[i] = m[0] * in[0][i] + m[1] * in[1][i] + m[2] * in[2][i];
        const float *const light = p->mixed ? out : in[c];
        for (size_t i = 0; i < n; i++) // NaN stays
            out[i] = gp_maxf(-FLT_MAX, gp_minf(FLT_MAX, light[i] * p->scale));
    }
    return p->api->apply(p->processor, p->out->c[0] + at, p->out->c[1] + at,
                         p->out->c[2] + at, n) ? GP_ERR_BUG : GP_OK;
}

/* Makes `out` where it is empty, named `what` in errors, and runs the pass. */
static gp_status run_pass(const struct gp_log *log, const char *what,
                          const struct gp_ocio *ocio, const struct gp_image *f,
                          struct ocio_pass *p)
{
    p->api = ocio->api;
    p->mixed = frame_matrix(ocio, f, p->matrix);
    const int blocks = (int) ((p->pixels + BLOCK - 1) / BLOCK);
    gp_status st = p->out->c[0]
                       ? GP_OK : gp_planes_make(log, what, p->pixels, p->out);
    if (st)
        return st;
    if (!p->processor)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "OCIO: this transform was not opened; report this");
    st = gp_parallel(blocks, pass_block, p, NULL);
    return !st ? GP_OK : gp_fail_bare(log, st,
        "OCIO: OpenColorIO failed on the pixels; free some memory");
}

gp_status gp_ocio_show(const struct gp_log *log, const struct gp_ocio *ocio,
                       const struct glarepp_tone_params *p, struct gp_image *f)
{
    return run_pass(log, "shown frame", ocio, f, &(struct ocio_pass) {
        .processor = ocio->opened.view, .in = &f->lit, .out = &f->shown,
        .pixels = gp_image_pixels(f),
        .scale = gp_tone_scale(p, f),
    });
}

gp_status gp_ocio_convert(const struct gp_log *log, const struct gp_ocio *ocio,
                          const struct gp_image *f, size_t n,
                          const struct gp_planes *in, struct gp_planes *out)
{
    const char *const what = "converted frame";
    gp_status st = run_pass(log, what, ocio, f, &(struct ocio_pass) {
        .processor = ocio->opened.output, .in = in, .out = out, .scale = 1.0f,
        .pixels = n,
    });
    if (st)
        gp_planes_free(out);
    return st;
}
