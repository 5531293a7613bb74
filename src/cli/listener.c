// SPDX-License-Identifier: Apache-2.0
#include "cli/listener.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "io/plane.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// -- what the library says ----------------------------------------------------

struct hint {
    const char *parameter; // as in struct gp_line
    const char *first, *more; // without advice before it, and after some
};

// sorted by parameter
// clang-format off
static const struct hint hints[] = {
#define HINT(parameter, words) {parameter, "; " words, ", or " words},
    HINT("compare.most", "crop them, or raise --max-pixels")
    HINT("field.degrees",
         "give --fov from 0.001 to 180 and a finite --rotate")
    HINT("field.most",
         "give a smaller --size, a --radius, or raise --max-pixels")
    HINT("field.radius", "make it again with a larger --size or --radius")
    HINT("frame.coverage", "give --mask FILE")
    HINT("frame.deep", "give --deep a file that has both")
    HINT("frame.depth", "name a channel with --depth")
    HINT("frame.has_ndc", "give --camera FILE")
    HINT("frame.to_ndc", "give --fov, or --camera FILE")
    HINT("kernel.as_it_is", "use --kernel-normalize none")
    HINT("kernel.centre", "set --kernel-center")
    HINT("kernel.normalized", "use --kernel-normalize luminance")
    HINT("kernel.percent", "give this --fov and --size to glarepp kernel, or "
         "--kernel-size")
    HINT("kernel.percent.angle", "set --kernel-size to that")
    HINT("kernel.words", "give fewer --kernel")
    HINT("layer.engine", "use --engine fft")
    HINT("layer.engine.fft", "use --engine direct")
    HINT("layer.gain", "lower --gain, or give --max-value")
    HINT("layer.gl", "use the other --gl (osmesa or egl)")
    HINT("layer.gl.egl", "use --gl osmesa")
    HINT("layer.gl.none", "use --engine fft and --sun-method exact, which need "
         "none")
    HINT("layer.gl.osmesa", "use --gl egl")
    HINT("layer.in_double", "leave --verify, -k aperture and -k temporal out")
    HINT("layer.levels", "raise --tolerance, or use --engine direct")
    HINT("layer.mix", "use --mix scatter")
    HINT("layer.tolerance", "raise --tolerance, which may be faster")
    HINT("layer.tolerance_pixel", "raise --tolerance-pixel")
    HINT("lens.distance", "give a longer --focus-distance")
    HINT("lens.f_number", "give a larger --f-number")
    HINT("lens.lens", "see glarepp lens --list")
    HINT("lens.lens.dark", "check it by glarepp lens --check")
    HINT("lights.cameras", "give --camera FILE")
    HINT("lights.cameras.frame", "leave --camera out")
    HINT("lights.depth", "give --depth-type z")
    HINT("lights.depth_there", "give \"depth\" in --lights, or --depth none")
    HINT("lights.flare", "give --light-scale, or --lights auto")
    HINT("lights.flux", "lower --sun-color, \"flux\" or --light-scale")
    HINT("lights.in_frame", "add --sun-in-frame")
    HINT("lights.method", "use --sun-method exact")
    HINT("lights.needed", "give --sun, --sun-dir or --lights")
    HINT("lights.outside", "give --camera FILE, or --sun-outside ignore")
    HINT("lights.share_by", "leave --sun-method out, or use --sun-share depth")
    HINT("lights.share_by.scene", "use --sun-share depth to take the frame's")
    HINT("lights.side", "use a smaller --sun-map, or --sun-method exact")
    HINT("lights.sun", "give --sun-color, e.g. --sun-color 5e4")
    HINT("lights.wide", "name a light with --sun or --lights FILE")
    HINT("params.bridges", "put it beside the program, or leave --ocio out")
    HINT("plan.fov", "check --fov")
    HINT("plan.fov.wide", "give --projection fisheye or equisolid")
    HINT("plan.projection", "use another --engine, or --projection plane")
    HINT("plan.projection.axis", "leave --flare and --lens out")
    HINT("plan.projection.relight", "leave --relight out")
    HINT("plan.rotate", "use --rotate 0, 90, 180 or 270")
    HINT("scene.camera", "give one of them to --scene-camera")
    HINT("scene.camera_normals", "give --scene-up or --normal-space")
    HINT("scene.relight", "give one of them to --relight")
    HINT("scene.relight.dark", "leave it out, or check --scene-start")
    HINT("scene.start", "give --scene-start, the frame at 0 s")
    HINT("scene.up", "check --scene-start and --scene-up")
    HINT("sense.max_value", "lower --max-value")
    HINT("sense.max_value.low", "raise --max-value, or leave it out")
    HINT("sense.threshold", "use --engine fft, or raise --threshold")
    HINT("sets.camera", "name it with --scene-camera")
    HINT("tone.any_primaries", "give --ignore-chromaticities")
    HINT("tone.config", "give another config, e.g. --ocio config.ocio")
    HINT("tone.context", "give --ocio-context NAME=VALUE")
    HINT("tone.display", "leave --display out")
    HINT("tone.input", "check --input-space")
    HINT("tone.look", "leave --look out")
    HINT("tone.output", "leave --output-space out")
    HINT("tone.view", "leave --view out")
#undef HINT
};
// clang-format on

static int compare(const void *parameter, const void *hint)
{
    return strcmp(parameter, ((const struct hint *) hint)->parameter);
}

const char *gp_hint(const char *parameter, const char *text)
{
    // "kernel.word I J FIELD"
    const char *const space = strrchr(parameter, ' ');
    const struct hint *const h =
        bsearch(space ? space + 1 : parameter, hints,
                sizeof hints / sizeof *hints, sizeof *hints, compare);
    return !h ? "" : strstr(text, "; ") ? h->more : h->first;
}

enum { WORDS_BYTES = 256 };

/* Finds the words of --kernel that a message is about, before it. */
static void find_words(const struct gp_settings *s, const char *parameter,
                       char *text)
{
    int first = 0, last = 1;
    // NOLINTNEXTLINE(cert-err34-c): the library wrote it
    if (sscanf(parameter, "plan.more %d", &first) == 1)
        snprintf(text, WORDS_BYTES,
                 "%.252s: ", s->input.group_kernels.at[first]);
    // NOLINTNEXTLINE(cert-err34-c): the library wrote it
    if (sscanf(parameter, "kernel.word %d %d", &first, &last) != 2 &&
        strncmp(parameter, "kernel.percent", strlen("kernel.percent")) != 0)
        return;
    for (int i = gp_max(first, 0); i < gp_min(last, s->kernel.words.n); i++) {
        const size_t used = strlen(text);
        snprintf(text + used, WORDS_BYTES - used, "%s%s",
                 i > first ? " and " : "", s->kernel.words.at[i]);
    }
    const size_t used = strlen(text);
    snprintf(text + used, WORDS_BYTES - used, "%s: ", used ? "" : "--kernel");
}

static _Thread_local const struct gp_log *about;

void gp_hear_about(const struct gp_log *log)
{
    about = log;
}

void gp_hear(void *user, const struct glarepp_message *m)
{
    const struct gp_listener *const l = user;
    const struct gp_log *const to = m->user ? m->user : about ? about : l->log;
    char words[WORDS_BYTES] = "";
    const char *const engine = l->s->light.layer.engine;
    const bool splat = engine && strcmp(engine, "splat") == 0;
    const bool exact = l->s->sun.p.method == GLAREPP_EXACT;
    const char *helps = m->parameter;
    // where GL failed, what of the settings does without: nothing for sets
    if (m->status == GLAREPP_ERR_GL && (strcmp(helps, "layer.engine") == 0 ||
                                        strcmp(helps, "layer.gl.none") == 0))
        helps = splat && exact ? "layer.engine"
                : splat        ? "layer.gl.none"
                : exact        ? ""
                               : "lights.method";
    const char *const hint = gp_hint(helps, m->text);
    if (gp_no_depth(l->s) && strcmp(m->parameter, "frame.coverage") == 0)
        return; // that nothing hides the lights was asked for
    find_words(l->s, m->parameter, words);
    (void) gp_print(to, m->bare ? GP_LEVEL_BARE : (enum gp_level) m->level,
                    (gp_status) m->status, "", "%s%s%s", words, m->text, hint);
}

// -- what it is given ---------------------------------------------------------

/* Returns an attribute that is a positive number; 0: none. */
static double positive(const struct gp_frame *f, const char *name)
{
    double v = 0.0;
    return gp_frame_numbers(f, name, 1, &v) && v > 0.0 ? v : 0.0;
}

struct glarepp_frame_params gp_frame_params_of(const struct gp_job *job,
                                               const struct gp_frame *f)
{
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    double size[2] = {0};
    p.image = gp_frame_view(f, &f->rgb);
    p.file = f->read;
    p.numbered = gp_job_number(job, &p.number);
    p.fps = positive(f, "framesPerSecond");
    p.has_camera = gp_frame_numbers(f, "worldToCamera", 16, p.to_camera);
    p.has_ndc = gp_frame_numbers(f, "worldToNDC", 16, p.to_ndc);
    if (!p.has_ndc) {
        p.has_ndc = gp_frame_numbers(f, "worldToScreen", 16, p.to_ndc);
        p.ndc = GLAREPP_NDC_CLIP;
    }
    double map = 1.0;
    if (gp_frame_numbers(f, "envmap", 1, &map) && map == 0.0)
        p.projection = GLAREPP_LATLONG;
    p.focus = positive(f, "focus");
    p.aperture = positive(f, "aperture");
    p.white = positive(f, "whiteLuminance");
    if (gp_frame_numbers(f, "sensorOverallDimensions", 2, size) &&
        size[0] > 0.0)
        p.sensor = size[0]; // OpenEXR 3.2
    return p;
}

struct glarepp_stored gp_stored_view(const struct gp_stored_image *m,
                                     const char *name)
{
    return (struct glarepp_stored) {
        .size = sizeof(struct glarepp_stored),
        .name = name,
        .data = m->data,
        .channel = m->channel,
        .channels = m->channels,
        .first = m->first,
        .integers = m->integers,
        .light = {m->light[0], m->light[1], m->light[2]},
        .primaries = m->chromaticities,
    };
}

// -- files of glarepp kernel --------------------------------------------------

const char *const gp_recipe_names[GP_KERNEL_RECIPES] = {
    "glarepp:recipe", "glarepp:recipe2", "glarepp:recipe3", "glarepp:recipe4",
    "glarepp:recipe5", "glarepp:recipe6", "glarepp:recipe7", "glarepp:recipe8",
};

/* Reads a number in [lo, hi] that a kernel's file has as text. */
static bool read_number(const struct gp_frame *f, const char *name, double lo,
                        double hi, double *v)
{
    char *const text = gp_frame_text(f, name);
    char *end = NULL;
    if (text)
        *v = strtod(text, &end);
    const bool good = text && end != text && !*end && *v >= lo && *v <= hi;
    gp_free(text);
    return good;
}

/* Checks the recipes, and adds up their shares. Their images are not read: the
 * samples are in the file. */
static gp_status read_recipes(const struct gp_log *log, struct glarepp *quiet,
                              const struct gp_frame *f, double *share)
{
    gp_status st = GP_OK;
    for (int i = 0; i < GP_KERNEL_RECIPES && !st; i++) {
        struct glarepp_kernel_params p = GLAREPP_KERNEL_PARAMS;
        struct glarepp_kernel *k;
        char *const text = gp_frame_text(f, gp_recipe_names[i]);
        const char *const word[] = {text};
        if (!text)
            break;
        p.word = word;
        p.words = 1;
        p.unread = true;
        st = (gp_status) glarepp_kernel(quiet, &p, &k);
        if (st)
            st = gp_fail(log, st == GP_ERR_BUG ? st : GP_ERR_DATA,
                         "%s: %s: %s", f->path, gp_recipe_names[i],
                         glarepp_error()->text);
        else
            *share += glarepp_kernel_share(k);
        glarepp_kernel_end(&k);
        gp_free(text);
    }
    *share = fmin(*share, 1.0);
    return st;
}

gp_status gp_label_read(const struct gp_log *log, const struct gp_frame *f,
                        struct glarepp_label *out)
{
    const struct glarepp_params params = {.size = sizeof params, .threads = 1};
    struct glarepp *quiet = NULL;
    struct glarepp_label l = {.present = true};
    const double slack = 1e-3; // sums of floats
    int v[3] = {0};
    char *const first = gp_frame_text(f, gp_recipe_names[0]);
    char *const size = gp_frame_text(f, "glarepp:size");
    const bool sized = size && gp_read_whole(size, "x,", v) && v[0] > 0 &&
                       v[1] > 0 && v[0] <= 16384 && v[1] <= 16384 &&
                       v[2] < 16384;
    const bool ours = first != NULL;
    gp_free(first);
    gp_free(size);
    l.w = v[0];
    l.h = v[1];
    *out =
        ours && sized && read_number(f, "glarepp:fov", 0.001, 180.0, &l.fov) &&
                read_number(f, "glarepp:left_out", -slack, 1.0 + slack,
                            &l.left_out) &&
                read_number(f, "glarepp:beyond", -slack, 1.0 + slack, &l.beyond)
            ? l
            : (struct glarepp_label) {.present = false};
    if (!ours)
        return GP_OK;
    gp_status st = (gp_status) glarepp_open(&params, &quiet);
    if (!st)
        st = read_recipes(log, quiet, f, &out->share);
    glarepp_close(&quiet);
    return st;
}

// -- what it asks for --------------------------------------------------------

/* The frame that an image borrows from. */
static _Thread_local struct gp_frame lent;

int gp_picture_read(void *user, const struct glarepp_picture *p,
                    struct glarepp_image *out, struct glarepp_label *label)
{
    const struct gp_listener *const l = user;
    const struct gp_read_params limits = gp_read_limits(&l->s->input.read);
    gp_status st;
    if (p->alpha) {
        struct gp_coverage a;
        st = gp_read_coverage(l->log, &l->s->input.read, p->path, p->bytes,
                              p->n, p->most, &a);
        if (st)
            return (int) st;
        out->type = GLAREPP_CODES;
        out->plane[0] = a.code;
        out->data = (struct glarepp_rect) {0, 0, a.w, a.h};
        return GP_OK;
    }
    st = gp_read_frame(l->log, &limits, p->path, &lent);
    if (!st)
        st = gp_label_read(l->log, &lent, label);
    if (st) {
        gp_frame_free(&lent);
        return (int) st;
    }
    *out = gp_frame_view(&lent, &lent.rgb);
    return GP_OK;
}

void gp_picture_release(void *user, struct glarepp_image *image)
{
    (void) user;
    if (image->type == GLAREPP_CODES)
        gp_free(image->plane[0]);
    else
        gp_frame_free(&lent);
}
