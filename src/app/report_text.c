/* Words of reports, and the line of --verbose on a frame. */
#include "app/report.h"

#include "core/memory.h"

#include <stdarg.h>
#include <stdio.h>

const char *const gp_time_names[GP_TIMES] = {
    [GP_TIME_READ] = "read",
    [GP_TIME_SCENE] = "scene", [GP_TIME_RELIGHT] = "relight",
    [GP_TIME_SUN] = "sun", [GP_TIME_SENSORS] = "sensors",
    [GP_TIME_KERNEL] = "kernel",
    [GP_TIME_GLARE] = "glare", [GP_TIME_LENS] = "lens",
    [GP_TIME_COMPOSE] = "compose", [GP_TIME_TONEMAP] = "tonemap",
    [GP_TIME_WRITE] = "write",
};

double gp_peak_rss_mib(void)
{
    return (double) gp_peak_memory() / (1 << 20);
}

const char *gp_pixel_type_name(enum gp_pixel_type type)
{
    static const char *const names[] = {
        [GP_UINT] = "uint", [GP_HALF] = "half", [GP_FLOAT] = "float",
    };
    return names[type];
}

/* Appends to a line of `size` bytes that is full up to *at. */
GP_PRINTF(4, 5)
static void append(char *line, size_t size, size_t *at, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    int n = vsnprintf(line + *at, size - *at, fmt, args);
    va_end(args);
    size_t room = size - *at - 1;
    *at += n < 0 ? 0 : (size_t) n < room ? (size_t) n : room;
}

void gp_facts_dark(const struct gp_facts *f, int frames, char *line,
                   size_t size)
{
    size_t at = 0;
    append(line, size, &at, "%s: no pixel", f->input);
    if (frames > 1)
        append(line, size, &at, " of %d frames", frames);
    append(line, size, &at, " is over the threshold %.3g (",
           (double) f->threshold);
    if (f->peak > 0.0f)
        append(line, size, &at, "brightest %.3g at %d,%d); lower --threshold",
               (double) f->peak, f->peak_at[0], f->peak_at[1]);
    else
        append(line, size, &at, "all are black); check the frame");
}

enum gp_edges gp_facts_edges(const struct gp_facts *f)
{
    bool seen = false;
    for (int i = 0; i < f->lights; i++)
        seen = seen || f->light[i].in_frame;
    return !seen ? GP_EDGES_NONE
           : f->mask ? f->depth ? GP_EDGES_COVERAGE : GP_EDGES_MASK
           : f->depth ? GP_EDGES_DEPTH
                      : GP_EDGES_NONE;
}

void gp_facts_text(const struct gp_facts *f, char *line, size_t size)
{
    const struct gp_glare_stats *g = &f->glare;
    size_t at = 0;
    append(line, size, &at, "%s%s%s%s: %dx%d, %lld sources", f->input,
           f->view ? " (" : "", f->view ? f->view : "", f->view ? ")" : "",
           f->width, f->height, f->sources);
    if (g->engine)
        append(line, size, &at, ", %s (%s)", g->engine, g->why);
    if (g->polygons)
        append(line, size, &at, ", %zu polygons", g->polygons);
    if (g->polygons && (g->groups || g->clusters))
        append(line, size, &at, " (%zu groups, %zu clusters)", g->groups,
               g->clusters);
    if (g->polygons && g->cores)
        append(line, size, &at, ", %zu cores", g->cores);
    if (g->polygons && g->form)
        append(line, size, &at, ", %s", g->form);
    if (f->flare.runs)
        append(line, size, &at, ", flare of bright pixels: %d elements in %d "
               "runs (%s, bound %.3g, %.1f ms)", f->flare.elements,
               f->flare.runs, f->flare.engine, f->flare.bound, f->flare.ms);
    if (f->lens.name)
        append(line, size, &at, ", lens: %d ghosts of %d lights, %d left out "
               "(bound %.3g)", f->lens.stats.drawn, f->lens.stats.lights,
               f->lens.stats.left_out, f->lens.bound);
    if (g->gl)
        append(line, size, &at, " on %s", g->gl);
    for (int i = 0; i < f->lights && i < 8; i++)
        append(line, size, &at, "%s%.4g", i ? " " : ", visible ",
               f->light[i].visibility);
    if (f->lights > 8)
        append(line, size, &at, " ... of %d", f->lights);
    static const char *const edges[] = {
        [GP_EDGES_DEPTH] = "depth alone (within 0.06 for a sun of 2.5 pixels)",
        [GP_EDGES_COVERAGE] = "coverage (within 0.02 for a sun of 2.5 pixels)",
        [GP_EDGES_MASK] = "coverage without depth (error not known)",
    };
    const enum gp_edges by = gp_facts_edges(f);
    if (by)
        append(line, size, &at, ", edges by %s", edges[by]);
    if (f->depth && !f->depth_empty[0])
        append(line, size, &at, ", depth %s (%s)", f->depth,
               gp_pixel_type_name(f->depth_type));
    if (f->nonfinite || f->clamped)
        append(line, size, &at, ", %lld NaN or Inf, %lld clamped",
               f->nonfinite, f->clamped);
    if (f->verified)
        append(line, size, &at, ", measured rel_l2 %.3g (bound %.3g), max_rel "
               "%.3g, max_abs %.3g, flux_error %.3g", f->error.rel_l2, g->bound,
               f->error.max_rel, f->error.max_abs, f->error.flux_error);
    append(line, size, &at, ";");
    for (int i = 0; i < GP_TIMES; i++) {
        if (f->ms[i] >= 0.0)
            append(line, size, &at, " %s %.1f", gp_time_names[i], f->ms[i]);
    }
    append(line, size, &at, " total %.1f ms, %.0f MiB", f->total_ms,
           gp_peak_rss_mib());
}
