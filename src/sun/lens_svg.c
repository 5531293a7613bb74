/* A lens in section, with the rays of one ghost, as SVG. */
#include "core/memory.h"
#include "sun/lens_priv.h"

#include <math.h>

enum { RAYS = 9, ARC = 24 };

/* Distance by which a surface of that height bulges towards the sensor. */
static double sag(const struct gp_lens_surface *s, double height)
{
    const double c = s->curvature, root = 1.0 - c * c * height * height;
    return c * height * height / (1.0 + sqrt(root > 0.0 ? root : 0.0));
}

/* Adds the points of a surface from one height to another. */
static void print_arc(FILE *f, const struct gp_lens_surface *s, double z,
                      double from, double to)
{
    for (int i = 0; i <= ARC; i++) {
        const double y = from + (to - from) * i / ARC;
        // a rim that is wider than the surface is a flat edge
        const double height = fmin(fabs(y), s->semi);
        fprintf(f, "%.3f,%.3f ", z + sag(s, height), -y);
    }
}

static void print_glass(FILE *f, const struct gp_lens_optics *o)
{
    const struct gp_lens *const lens = o->lens;
    for (int i = 0; i + 1 < lens->n; i++) {
        const struct gp_lens_surface *const a = &lens->at[i], *const b = a + 1;
        const double semi = fmax(a->semi, b->semi);
        if (a->n == 1.0)
            continue;
        fprintf(f, "<polygon class=\"glass\" points=\"");
        print_arc(f, a, o->z[i], -semi, semi);
        print_arc(f, b, o->z[i + 1], semi, -semi);
        fprintf(f, "\"/>\n");
    }
}

/* Rays of a light a little off the axis, over the ghost's pupil. */
static void print_rays(FILE *f, const struct gp_lens_optics *o,
                       const struct gp_lens_ghost *ghost, double u)
{
    struct gp_lens_path path;
    double at[GP_LENS_STEPS + 1][3];
    gp_lens_path(o->lens, ghost->first, ghost->second, &path);
    for (int i = 0; i < RAYS; i++) {
        const double radius = fmin(ghost->radius, o->lens->at[0].semi);
        const double x = ghost->shift * u +
                         0.95 * radius * (2.0 * i / (RAYS - 1) - 1.0);
        const struct gp_lens_hit h = gp_lens_trace(o, &path, x, 0.0, u, at);
        if (h.through < 0.0f || h.rim > 1.0f)
            continue;
        const double before = 0.15 * o->z[o->lens->n];
        fprintf(f, "<polyline class=\"ray\" points=\"%.3f,%.3f ", -before,
                -(x - before * u));
        for (int k = 0; k <= path.steps; k++)
            fprintf(f, "%.3f,%.3f ", at[k][2], -at[k][0]);
        fprintf(f, "\"/>\n");
    }
}

gp_status gp_lens_svg(const struct gp_log *log, FILE *f,
                      const struct gp_lens *lens,
                      const struct gp_lens_ghost *ghost)
{
    struct gp_lens_optics *o; // 130 KiB: too large for a stack
    double tall = 0.0;
    const gp_status st = gp_alloc(log, lens->name, 1, sizeof *o, &o);
    if (st)
        return st;
    gp_lens_optics_make(lens, GP_D_LINE, o);
    for (int i = 0; i < lens->n; i++)
        tall = fmax(tall, lens->at[i].semi);
    const double end = o->z[lens->n], side = 0.17 * end, half = 1.25 * tall;
    const double stop = lens->at[lens->stop].semi, at = o->z[lens->stop];
    const double line = 0.002 * end;
    fprintf(f, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"960\" "
               "viewBox=\"%.3f %.3f %.3f %.3f\">\n"
               "<style>.glass{fill:#cfe3f2;stroke:#3a5a78;stroke-width:%.4f}"
               ".ray{fill:none;stroke:#d06020;stroke-width:%.4f}"
               ".line{stroke:#222;stroke-width:%.4f}</style>\n"
               "<rect x=\"%.3f\" y=\"%.3f\" width=\"%.3f\" height=\"%.3f\" "
               "fill=\"#fff\"/>\n", -side, -half, end + 1.3 * side, 2.0 * half,
            line, 0.6 * line, 1.5 * line, -side, -half, end + 1.3 * side,
            2.0 * half);
    fprintf(f, "<line class=\"line\" stroke-dasharray=\"%.3f\" x1=\"%.3f\" "
               "y1=\"0\" x2=\"%.3f\" y2=\"0\"/>\n", 8.0 * line, -side, end);
    print_glass(f, o);
    for (int k = -1; k <= 1; k += 2)
        fprintf(f, "<line class=\"line\" x1=\"%.3f\" y1=\"%.3f\" x2=\"%.3f\" "
                   "y2=\"%.3f\"/>\n", at, k * stop, at, k * 1.15 * tall);
    fprintf(f, "<line class=\"line\" x1=\"%.3f\" y1=\"%.3f\" x2=\"%.3f\" "
               "y2=\"%.3f\"/>\n", end, -tall, end, tall);
    if (ghost)
        print_rays(f, o, ghost, 0.05);
    fprintf(f, "</svg>\n");
    gp_free(o);
    return GP_OK;
}
