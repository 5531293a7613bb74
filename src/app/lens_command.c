#include "app/commands.h"

#include "app/clobber.h"
#include "core/bridge.h"
#include "core/memory.h"
#include "io/file.h"
#include "sun/lens.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

// -- --list -------------------------------------------------------------------

static int is_lens(const struct dirent *d)
{
    const char *const end = strrchr(d->d_name, '.');
    return d->d_name[0] != '.' && end && strcmp(end, ".json") == 0;
}

static gp_status list_lenses(const struct gp_log *log)
{
    char folder[PATH_MAX];
    struct dirent **entry = NULL;
    gp_status st = GP_OK;
    if (!gp_example_find("lenses", folder, sizeof folder))
        return gp_fail(log, GP_ERR_IO, "lenses: not found beside the program; "
                       "install it whole, or name their folder's parent in "
                       "GLAREPP_EXAMPLES");
    const int n = scandir(folder, &entry, is_lens, alphasort);
    if (n < 0)
        return gp_fail(log, GP_ERR_IO, "%s: cannot read (%s); check its "
                       "permissions", folder, strerror(errno));
    for (int i = 0; i < n; i++) {
        struct gp_lens lens;
        char *const name = entry[i]->d_name;
        name[strlen(name) - strlen(".json")] = '\0';
        if (!st)
            st = gp_lens_read(log, name, &lens);
        if (!st)
            printf("%-14s %s (%s)\n", name, lens.name, lens.patent);
        free(entry[i]);
    }
    free(entry);
    return st ? st : gp_flush_text(log);
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
static void print_ghosts(const struct gp_lens *lens,
                         const struct gp_lens_figures *f,
                         struct gp_lens_ghost *ghost, int n)
{
    enum { SHOWN = 8 };
    const double image = f->pupil * f->pupil * f->through;
    printf("ghosts       %d; those with most light on the axis, of the image's "
           "light:\n", n);
    for (int i = 0; i < n && i < SHOWN; i++) {
        int best = i;
        for (int k = i + 1; k < n; k++) {
            if (ghost[k].through * ghost[k].radius * ghost[k].radius >
                ghost[best].through * ghost[best].radius * ghost[best].radius)
                best = k;
        }
        const struct gp_lens_ghost g = ghost[best];
        ghost[best] = ghost[i];
        ghost[i] = g;
        printf("  surfaces %2d and %2d: %.3g, %.4g mm across, place %+.3g of "
               "the light's\n", g.second + 1, g.first + 1,
               g.through * g.radius * g.radius / image,
               2.0 * fabs(g.m.a) * g.radius,
               (g.m.a * g.shift + g.m.b) / f->focal);
    }
    printf("starburst    --lens and -k aperture: %.4g mm f/%.3g, ", f->focal,
           f->f_number);
    if (lens->blades)
        printf("%d blades\n", lens->blades);
    else
        printf("round\n");
}

static gp_status draw_lens(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_lens *lens,
    const struct gp_lens_ghost *ghost, int n)
{
    char *text = NULL;
    size_t size = 0;
    int best = 0;
    // brightest on the sensor: light over area
    for (int i = 1; i < n; i++) {
        if (ghost[i].through * ghost[best].m.a * ghost[best].m.a >
            ghost[best].through * ghost[i].m.a * ghost[i].m.a)
            best = i;
    }
    FILE *const f = open_memstream(&text, &size);
    if (!f)
        return gp_no_memory(log, s->making.draw);
    gp_lens_svg(f, lens, n ? &ghost[best] : NULL);
    const bool whole = !ferror(f);
    gp_status st = fclose(f) == 0 && whole
                       ? gp_file_save(log, s->making.draw, text, size)
                       : gp_no_memory(log, s->making.draw);
    free(text);
    return st;
}

static gp_status check_lens(const struct gp_log *log,
                            const struct gp_settings *s, bool *faulty)
{
    struct gp_lens lens;
    struct gp_lens_figures f;
    struct gp_lens_ghost *ghost = NULL;
    const char *const draw = s->making.draw;
    const size_t name = draw ? strlen(draw) : 0;
    gp_status st;
    if (draw && !gp_is_dash(draw) &&
        (name < 4 || strcasecmp(draw + name - 4, ".svg") != 0))
        return gp_fail(log, GP_ERR_USAGE, "%s: the drawing of a lens is an "
                       "SVG; give a name that ends in .svg", draw);
    GP_TRY(gp_clobber_check(log, s, "--check", s->making.check));
    GP_TRY(gp_lens_read(log, s->making.check, &lens));
    GP_TRY(gp_lens_focus(log, &lens, INFINITY, 0.0));
    GP_TRY(gp_alloc(log, "ghosts", GP_LENS_GHOSTS, sizeof *ghost, &ghost));
    gp_lens_measure(&lens, &f);
    const int n = gp_lens_ghosts(&lens, GP_D_LINE, ghost);
    printf("lens         %s\n", lens.name);
    if (lens.patent[0])
        printf("patent       %s\n", lens.patent);
    if (lens.note[0])
        printf("note         %s\n", lens.note);
    printf("surfaces     %d, stop %d, %s%.0d\n", lens.n, lens.stop + 1,
           lens.blades ? "blades " : "round", lens.blades);
    // a nominal focal length is within 1 % (ISO 517)
    bool fault = print_claim("focal length", " mm", f.focal, lens.claims_focal,
                             0.01);
    fault |= print_claim("back focus", " mm", f.back, lens.claims_back, 0.01);
    fault |= print_claim("f-number", "", f.f_number, lens.claims_f_number,
                         0.05);
    // rims may let more through than the format takes
    if (f.height >= lens.claims_height && lens.claims_height > 0.0)
        printf("image height %.6g mm by the rims, claimed %.6g: covered\n",
               f.height, lens.claims_height);
    else
        fault |= print_claim("image height", " mm", f.height,
                             f.height > 0.0 ? lens.claims_height : 0.0, 0.1);
    printf("through      %.2f %%\n", 100.0 * f.through);
    print_ghosts(&lens, &f, ghost, n);
    if (fault)
        printf("fault: the surfaces do not make what the file claims; compare "
               "it with its source\n");
    *faulty = fault;
    if (s->making.draw)
        GP_TRY(draw_lens(log, s, &lens, ghost, n));
    st = gp_flush_stdout(log);
out:
    gp_free(ghost);
    return st;
}

gp_status gp_lens_command(const struct gp_log *log,
                          const struct gp_settings *s, bool *faulty)
{
    *faulty = false;
    return s->making.list ? list_lenses(log) : check_lens(log, s, faulty);
}
