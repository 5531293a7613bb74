#include "cli/listener.h"

#include "core/minmax.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct hint {
    const char *parameter; // as in struct gp_line
    const char *first, *more; // without advice before it, and after some
};

// sorted by parameter
static const struct hint hints[] = {
#define HINT(parameter, words) {parameter, "; " words, ", or " words},
    HINT("compare.most", "crop them, or raise --max-pixels")
    HINT("field.degrees",
         "give --fov from 0.001 to 180 and a finite --rotate")
    HINT("field.most",
         "give a smaller --size, a --radius, or raise --max-pixels")
    HINT("field.radius", "make it again with a larger --size or --radius")
    HINT("frame.coverage", "give --mask FILE")
    HINT("frame.depth", "name a channel with --depth")
    HINT("frame.has_ndc", "give --camera FILE")
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
    HINT("layer.gl", "use the other --gl (osmesa or egl), or --engine fft")
    HINT("layer.gl.egl", "use --gl osmesa")
    HINT("layer.gl.osmesa", "use --gl egl")
    HINT("layer.in_double", "leave --verify, -k aperture and -k temporal out")
    HINT("layer.mix", "use --mix scatter")
    HINT("layer.tolerance", "raise --tolerance, which may be faster")
    HINT("layer.tolerance.far", "use --engine direct, which sums the kernel "
         "without its coarse far part, or raise --tolerance, which may be "
         "faster")
    HINT("layer.tolerance_pixel", "raise --tolerance-pixel")
    HINT("lens.distance", "give a longer --focus-distance")
    HINT("lens.f_number", "give a larger --f-number")
    HINT("lens.lens", "see glarepp lens --list")
    HINT("lens.lens.dark", "check it by glarepp lens --check")
    HINT("lights.cameras", "give --camera FILE")
    HINT("lights.cameras.frame", "leave --camera out")
    HINT("lights.depth", "give --depth-type z")
    HINT("lights.flare",
         "give --sun and --sun-color, --lights, --scene and --light-scale")
    HINT("lights.in_frame", "add --sun-in-frame")
    HINT("lights.method", "use --sun-method exact")
    HINT("lights.ndc", "give --camera FILE")
    HINT("lights.needed", "give --sun, --sun-dir or --lights")
    HINT("lights.outside", "give --camera FILE, or --sun-outside ignore")
    HINT("lights.side", "use a smaller --sun-map, or --sun-method exact")
    HINT("lights.sun", "give --sun-color, e.g. --sun-color 5e4")
    HINT("params.bridges", "put it beside the program, or leave --ocio out")
    HINT("plan.fov", "check --fov")
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

// -- the context's messages ---------------------------------------------------

/* Words of --kernel that a message is about, before it. */
struct kernel_words {
    char text[256];
};

static struct kernel_words words_of(const struct gp_settings *s,
                                    const char *parameter)
{
    struct kernel_words w = {""};
    int first = 0, last = 1;
    if (sscanf(parameter, "kernel.word %d %d", &first, &last) != 2 &&
        strncmp(parameter, "kernel.percent", strlen("kernel.percent")) != 0)
        return w;
    for (int i = gp_max(first, 0); i < gp_min(last, s->kernel.words.n); i++) {
        const size_t used = strlen(w.text);
        snprintf(w.text + used, sizeof w.text - used, "%s%s",
                 i > first ? " and " : "", s->kernel.words.at[i]);
    }
    const size_t used = strlen(w.text);
    snprintf(w.text + used, sizeof w.text - used, "%s: ",
             used ? "" : "--kernel");
    return w;
}

void gp_hear(void *user, const struct glarepp_message *m)
{
    const struct gp_listener *const l = user;
    const struct gp_log *const to = m->user ? m->user : l->log;
    const struct kernel_words words = words_of(l->s, m->parameter);
    if (m->level == GLAREPP_ERROR)
        (void) (m->bare ? gp_fail_bare : gp_fail)(
            to, (gp_status) m->status, "%s%s%s", words.text, m->text,
            gp_hint(m->parameter, m->text));
    else
        gp_say(to, m->level == GLAREPP_NOTE ? GP_LEVEL_INFO
                                                 : GP_LEVEL_WARN,
               "%s%s%s", words.text, m->text, gp_hint(m->parameter, m->text));
}
