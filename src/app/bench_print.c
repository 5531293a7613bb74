#include "app/bench_table.h"

#include "core/parallel.h"

#include <math.h>
#include <string.h>

/* A number of a column, or "-" where it is not known. */
static void put(FILE *to, int width, const char *format, double v)
{
    char text[32];
    if (isnan(v))
        snprintf(text, sizeof text, "-");
    else
        snprintf(text, sizeof text, format, v);
    fprintf(to, " %*s", width, text);
}

static void print_head(const struct gp_bench_table *t,
                       const struct gp_bench_frame *f, FILE *to)
{
    fprintf(to, "%s: %dx%d, %lld sources, kernel %s %dx%d; bright pass to "
            "layer, median of %d runs, %d threads\n", f->input, f->width,
            f->height, f->sources, f->kernel, f->kernel_w, f->kernel_h,
            t->runs, gp_threads());
    if (f->paper)
        fprintf(to, "beside the %s of the paper's frame rates (GeForce 7800 "
                "GTX, approximate method, whole picture): %d frames a second\n",
                f->paper->rate, f->paper->fps);
    fprintf(to, "  %-26s %9s  %8s %8s %8s %8s %9s %8s %8s %8s %9s %8s",
            "technique", "ms", "min", "max", "first", "frames/s", "rel_l2",
            "max_rel", "FLIP", "bound", "polygons", "Mpixels");
    fprintf(to, f->paper ? " %8s\n" : "\n", "x paper");
}

enum { WHY = 88 };

static void print_row(const struct gp_bench_frame *f,
                      const struct gp_bench_row *r, FILE *to)
{
    if (r->why[0]) { // cut to the table's width; the files have all of it
        fprintf(to, "  %-26s cannot run: %.*s%s\n", r->name, WHY, r->why,
                strlen(r->why) > WHY ? "..." : "");
        return;
    }
    const bool known = r->measured;
    fprintf(to, "%c %-26s", r->pareto ? '>' : ' ', r->name);
    put(to, 9, r->ms < 1e4 ? "%.2f" : "%.0f", r->ms);
    fputc(r->extrapolated ? '*' : ' ', to);
    put(to, 8, "%.2f", r->extrapolated ? (double) NAN : r->ms_min);
    put(to, 8, "%.2f", r->extrapolated ? (double) NAN : r->ms_max);
    put(to, 8, r->ms_first < 1e4 ? "%.1f" : "%.0f", r->ms_first);
    put(to, 8, "%.4g", 1e3 / r->ms);
    put(to, 9, "%.2e", known ? r->error.rel_l2 : (double) NAN);
    put(to, 8, "%.1e", known ? r->error.max_rel : (double) NAN);
    put(to, 8, "%.1e", r->flip);
    put(to, 8, "%.1e", r->bound);
    put(to, 9, "%.0f", r->polygons > 0.0 ? r->polygons : (double) NAN);
    put(to, 8, "%.4g", r->polygons > 0.0 ? r->polygon_pixels * 1e-6
                                         : (double) NAN);
    if (f->paper)
        put(to, 8, "%.2f", 1e3 / r->ms / f->paper->fps);
    fputc('\n', to);
}

/* What the last row chose, and where GL ran. */
static void print_notes(const struct gp_bench_frame *f, FILE *to)
{
    const char *gl = NULL;
    for (int i = 0; i < f->rows; i++) {
        const struct gp_glare_stats *s = &f->row[i].stats;
        if (!f->row[i].why[0] && strcmp(f->row[i].name, "auto") == 0)
            fprintf(to, "  auto took %s: %s\n", s->engine, s->why);
        gl = !gl && f->row[i].gl[0] ? f->row[i].gl : gl;
    }
    if (gl)
        fprintf(to, "  splat ran on %s\n", gl);
}

void gp_bench_print(const struct gp_bench_table *t, FILE *to)
{
    for (int i = 0; i < t->frames; i++) {
        const struct gp_bench_frame *f = &t->frame[i];
        print_head(t, f, to);
        for (int k = 0; k < f->rows; k++)
            print_row(f, &f->row[k], to);
        print_notes(f, to);
        fputc('\n', to);
    }
    fprintf(to,
            "> on the Pareto front: no other row is both faster and nearer\n"
            "* a whole run takes over 6 s: extrapolated from a tenth (or "
            "hundredth) of the sources\n"
            "first: the first run, which makes plans, spectra and contexts "
            "that later frames keep\n"
            "4/8/1e-3: --group 4 --cluster 8 --shrink 1e-3, all of Ando's "
            "techniques; FLIP: of the tone-mapped pictures\n");
}
