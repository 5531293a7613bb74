#include "app/hints.h"

#include "core/minmax.h"

#include <stdio.h>
#include <string.h>

/* What to do about a parameter. */
static const struct hint {
    const char *parameter;
    enum glarepp_level level;
    const char *text; // after the message
} hints[] = {
    {"compare.most", GLAREPP_ERROR, "; crop them, or raise --max-pixels"},
    {"frame.has_ndc", GLAREPP_ERROR, "; give --camera"},
    {"gl", GLAREPP_ERROR, "; give --engine fft and --sun-method exact"},
    {"kernel.percent", GLAREPP_WARNING,
     " (glarepp kernel with this --fov and --size, or --kernel-size)"},
    {"kernel.words", GLAREPP_ERROR, " (--kernel)"},
    {"layer.tolerance", GLAREPP_ERROR, "; give a larger --tolerance"},
    {"layer.tolerance", GLAREPP_WARNING, "; give a larger --tolerance"},
    {"lights.outside", GLAREPP_ERROR,
     "; give --camera FILE, or --sun-outside ignore"},
    {"lights.depth", GLAREPP_ERROR,
     "; give --depth-type z, and depth of that kind"},
    {"scene.camera", GLAREPP_ERROR, "; give one with --scene-camera"},
    {"scene.camera_normals", GLAREPP_WARNING,
     "; give --scene-up or --normal-space"},
    {"scene.relight", GLAREPP_ERROR, "; check --relight"},
    {"scene.relight", GLAREPP_WARNING,
     "; leave it out of --relight, or check --scene-start"},
    {"scene.start", GLAREPP_WARNING, "; give --scene-start, the frame at 0 s"},
    {"scene.up", GLAREPP_WARNING, "; check --scene-start and --scene-up"},
};

static const char *hint_of(const struct glarepp_message *m)
{
    for (size_t i = 0; i < sizeof hints / sizeof *hints; i++) {
        if (hints[i].level == m->level &&
            strcmp(hints[i].parameter, m->parameter) == 0)
            return hints[i].text;
    }
    return "";
}

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
        strcmp(parameter, "kernel.percent") != 0)
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
        (void) gp_fail(to, (gp_status) m->status, "%s%s%s", words.text, m->text,
                       hint_of(m));
    else
        gp_say(to, m->level == GLAREPP_NOTE ? GP_LEVEL_INFO : GP_LEVEL_WARN,
               "%s%s%s", words.text, m->text, hint_of(m));
}
