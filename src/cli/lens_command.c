
#include "cli/commands.h"
#include "cli/output_guard.h"
#include "io/file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

// -- --list -------------------------------------------------------------------

static gp_status list_lenses(const struct gp_log *log, struct glarepp *gp)
{
    const char *name;
    if (!glarepp_name(gp, GLAREPP_LENSES, 0, NULL))
        return gp_fail(log, GP_ERR_IO, "lenses: not found beside the program; "
                       "install it whole, or name their folder's parent in "
                       "GLAREPP_EXAMPLES");
    for (int i = 0; (name = glarepp_name(gp, GLAREPP_LENSES, i, NULL)); i++) {
        struct glarepp_lens lens;
        const gp_status st = (gp_status) glarepp_lens(gp, name, &lens);
        if (st)
            return st;
        printf("%-14s %s (%s)\n", name, lens.name, lens.patent);
        glarepp_lens_end(&lens);
    }
    return gp_flush_text(log);
}

// -- --check ------------------------------------------------------------------

/* Prints a figure beside its claim; returns true where they differ by more
 * than `most` of it. */
static bool print_claim(const char *what, const char *unit, double computed,
                        double claimed, double most)
{
    printf("%-12s %.6g%s", what, computed, unit);
    if (!(claimed > 0.0)) {
        printf("\n");
        return false;
    }
    const double off = computed / claimed - 1.0;
    printf(", claimed %.6g (%+.2f %%)\n", claimed, 100.0 * off);
    return fabs(off) > most;
}

/* Prints the ghosts, those that are brightest on the sensor first. */
static void print_ghosts(const struct glarepp_lens *lens)
{
    enum { SHOWN = 8 };
    const double image = lens->pupil * lens->pupil * lens->through;
    struct glarepp_ghost *const ghost = lens->ghost;
    const int n = lens->ghosts;
    printf("ghosts       %d; those with most light on the axis, of the image's "
           "light:\n", n);
    for (int i = 0; i < n && i < SHOWN; i++) {
        int best = i;
        for (int k = i + 1; k < n; k++) {
            if (ghost[k].through * ghost[k].radius * ghost[k].radius >
                ghost[best].through * ghost[best].radius * ghost[best].radius)
                best = k;
        }
        const struct glarepp_ghost g = ghost[best];
        ghost[best] = ghost[i];
        ghost[i] = g;
        printf("  surfaces %2d and %2d: %.3g, %.4g mm across, place %+.3g of "
               "the light's\n", g.second + 1, g.first + 1,
               g.through * g.radius * g.radius / image,
               2.0 * fabs(g.a) * g.radius,
               (g.a * g.shift + g.b) / lens->focal);
    }
    printf("starburst    --lens and -k aperture: %.4g mm f/%.3g, ",
           lens->focal, lens->f_number);
    if (lens->blades)
        printf("%d blades\n", lens->blades);
    else
        printf("round\n");
}

static gp_status draw_lens(const struct gp_log *log, const char *path,
                           struct glarepp_lens *lens)
{
    const struct glarepp_ghost *const ghost = lens->ghost;
    int best = 0;
    // brightest on the sensor: light over area
    for (int i = 1; i < lens->ghosts; i++) {
        if (ghost[i].through * ghost[best].a * ghost[best].a >
            ghost[best].through * ghost[i].a * ghost[i].a)
            best = i;
    }
    const char *const text =
        glarepp_lens_draw(lens, lens->ghosts ? &ghost[best] : NULL);
    return text ? gp_file_save(log, path, text, strlen(text))
                : gp_no_memory(log, path);
}

static gp_status check_lens(const struct gp_log *log, struct glarepp *gp,
                            const struct gp_settings *s, bool *faulty)
{
    struct glarepp_lens lens = {.own = NULL};
    const char *const draw = s->making.draw;
    const size_t name = draw ? strlen(draw) : 0;
    gp_status st;
    if (draw && !gp_is_dash(draw) &&
        (name < 4 || strcasecmp(draw + name - 4, ".svg") != 0))
        return gp_fail(log, GP_ERR_USAGE, "%s: the drawing of a lens is an "
                       "SVG; give a name that ends in .svg", draw);
    GP_TRY(gp_output_guard_check(log, s, NULL, NULL));
    GP_TRY(glarepp_lens(gp, s->making.check, &lens));
    printf("lens         %s\n", lens.name);
    if (lens.patent[0])
        printf("patent       %s\n", lens.patent);
    if (lens.note[0])
        printf("note         %s\n", lens.note);
    printf("surfaces     %d, stop %d, %s%.0d\n", lens.surfaces, lens.stop + 1,
           lens.blades ? "blades " : "round", lens.blades);
    // a nominal focal length is within 1 % (ISO 517)
    bool fault = print_claim("focal length", " mm", lens.focal,
                             lens.claims_focal, 0.01);
    fault |= print_claim("back focus", " mm", lens.back, lens.claims_back,
                         0.01);
    fault |= print_claim("f-number", "", lens.f_number, lens.claims_f_number,
                         0.05);
    // rims may let more through than the format takes
    if (lens.height >= lens.claims_height && lens.claims_height > 0.0)
        printf("image height %.6g mm by the rims, claimed %.6g: covered\n",
               lens.height, lens.claims_height);
    else
        fault |= print_claim("image height", " mm", lens.height,
                             lens.height > 0.0 ? lens.claims_height : 0.0, 0.1);
    printf("through      %.2f %%\n", 100.0 * lens.through);
    print_ghosts(&lens);
    if (fault)
        printf("fault: the surfaces do not make what the file claims; compare "
               "it with its source\n");
    *faulty = fault;
    if (draw)
        GP_TRY(draw_lens(log, draw, &lens));
    st = gp_flush_stdout(log);
out:
    glarepp_lens_end(&lens);
    return st;
}

gp_status gp_lens_command(const struct gp_log *log, struct glarepp *gp,
                          const struct gp_settings *s, bool *faulty)
{
    *faulty = false;
    return s->making.list ? list_lenses(log, gp)
                          : check_lens(log, gp, s, faulty);
}
