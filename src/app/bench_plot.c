/* Speed against error as a picture. No text of the user's goes into the script
 * that gnuplot reads. */
#include "app/bench_table.h"

#include "app/bench_gnuplot.h"

#include "io/file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* SVG pixels of a panel, and the plot inside it; y counts upwards. */
enum {
    WIDTH = 900, HEIGHT = 560,
    LEFT = 90, RIGHT = 20, BOTTOM = 60, TOP = 40,
    LETTER = 7, LINE = 14,  // of a label
};
static const double LEAST = 1e-10; // what an error of 0 is drawn as

struct box {
    double x0, y0, x1, y1;
};

struct point {
    const struct gp_bench_row *row;
    double ms, error;
    double x, y;       // in its panel
    struct box label;
};

struct panel {
    const struct gp_bench_frame *f;
    double low[2], high[2];  // ranges: ms, rel_l2
    struct point at[GP_BENCH_ROWS];
    int n;
};

// -- places ------------------------------------------------------------------------

static double along(const struct panel *p, int axis, double v)
{
    return log(v / p->low[axis]) / log(p->high[axis] / p->low[axis]);
}

static void widen(struct panel *p, int axis, double v)
{
    p->low[axis] = p->low[axis] < v ? p->low[axis] : v;
    p->high[axis] = p->high[axis] > v ? p->high[axis] : v;
}

static void place_points(const struct gp_bench_frame *f, struct panel *p)
{
    *p = (struct panel) {.f = f, .low = {INFINITY, INFINITY}};
    for (int i = 0; i < f->rows; i++) {
        const struct gp_bench_row *r = &f->row[i];
        const double e = r->error.rel_l2;
        if (!r->measured || !isfinite(e) || !(r->ms > 0.0))
            continue;
        struct point *const at = &p->at[p->n++];
        *at = (struct point) {.row = r, .ms = r->ms, .error = fmax(e, LEAST)};
        widen(p, 0, at->ms);
        widen(p, 1, at->error);
    }
    for (int axis = 0; axis < 2; axis++) {
        if (p->n == 0)
            p->low[axis] = p->high[axis] = 1.0;
        p->low[axis] /= 2.0;
        p->high[axis] *= axis ? 4.0 : 3.0;
    }
    for (int i = 0; i < p->n; i++) {
        p->at[i].x = LEFT + (WIDTH - LEFT - RIGHT) * along(p, 0, p->at[i].ms);
        p->at[i].y = BOTTOM +
                     (HEIGHT - BOTTOM - TOP) * along(p, 1, p->at[i].error);
    }
}

static bool meet(const struct box *a, const struct box *b)
{
    return a->x0 < b->x1 && b->x0 < a->x1 && a->y0 < b->y1 && b->y0 < a->y1;
}

/* How many points and labels before the i-th the box would cover. */
static int covered(const struct panel *p, int i, const struct box *b)
{
    int n = b->x0 < LEFT || b->x1 > WIDTH - RIGHT || b->y0 < BOTTOM ||
                    b->y1 > HEIGHT - TOP
                ? GP_BENCH_ROWS : 0;
    for (int k = 0; k < p->n; k++) {
        const struct point *o = &p->at[k];
        const struct box dot = {o->x - 4, o->y - 4, o->x + 4, o->y + 4};
        n += meet(b, &dot) + (k < i && meet(b, &o->label));
    }
    return n;
}

/* Beside its point where there is room, else further up or down. */
static void place_label(struct panel *p, int i)
{
    struct point *const at = &p->at[i];
    const double w = LETTER * (double) strlen(at->row->name);
    int least = 3 * GP_BENCH_ROWS;
    for (int k = 0; k < 44 && least > 0; k++) {
        const int step = (k / 4 + 1) * (k / 2 % 2 ? -1 : 1);
        const double dy = k < 2 ? 0.0 : step * (LINE / 2.0);
        const double x = k % 2 ? at->x - 8 - w : at->x + 8;
        const struct box b = {x, at->y + dy - LINE / 2.0, x + w,
                              at->y + dy + LINE / 2.0};
        const int n = covered(p, i, &b);
        if (n < least) {
            least = n;
            at->label = b;
        }
    }
}

// -- the script ---------------------------------------------------------------------

static void write_points(const struct panel *p, FILE *to)
{
    fprintf(to, "$rows << END\n");
    for (int i = 0; i < p->n; i++)
        fprintf(to, "%.6g %.6g\n", p->at[i].ms, p->at[i].error);
    fprintf(to, "END\n$front << END\n");
    // in order of time: on the front, that of error too
    double last = 0.0;
    for (int done = 0; done < p->n; done++) {
        const struct point *next = NULL;
        for (int i = 0; i < p->n; i++) {
            const struct point *at = &p->at[i];
            if (at->row->pareto && at->ms > last && (!next || at->ms < next->ms))
                next = at;
        }
        if (!next)
            break;
        fprintf(to, "%.6g %.6g\n", next->ms, next->error);
        last = next->ms;
    }
    fprintf(to, "END\n");
}

static void write_labels(struct panel *p, double height, double bottom,
                         FILE *to)
{
    fprintf(to, "unset label\nunset arrow\n");
    for (int i = 0; i < p->n; i++) {
        place_label(p, i);
        const struct point *at = &p->at[i];
        const bool right = at->label.x0 > at->x; // its near end is sure
        const double x = right ? at->label.x0 : at->label.x1;
        const double y = (at->label.y0 + at->label.y1) / 2.0;
        fprintf(to, "set label '%s' at screen %.5f,%.5f %s font ',11'%s\n",
                at->row->name, x / WIDTH, (bottom + y) / height,
                right ? "left" : "right",
                at->row->pareto ? "" : " textcolor rgb '#666666'");
        if (fabs(y - at->y) > LINE)
            fprintf(to, "set arrow from screen %.5f,%.5f to screen %.5f,%.5f "
                    "nohead lc rgb '#bbbbbb'\n", at->x / WIDTH,
                    (bottom + at->y) / height, x / WIDTH,
                    (bottom + y) / height);
    }
}

static void write_panel(struct panel *p, double height, double bottom, FILE *to)
{
    const struct gp_bench_frame *f = p->f;
    write_points(p, to);
    write_labels(p, height, bottom, to);
    fprintf(to, "set lmargin at screen %.5f\nset rmargin at screen %.5f\n"
            "set bmargin at screen %.5f\nset tmargin at screen %.5f\n",
            (double) LEFT / WIDTH, 1.0 - (double) RIGHT / WIDTH,
            (bottom + BOTTOM) / height, (bottom + HEIGHT - TOP) / height);
    fprintf(to, "set xrange [%.6g:%.6g]\nset yrange [%.6g:%.6g]\n", p->low[0],
            p->high[0], p->low[1], p->high[1]);
    fprintf(to, "set title '%s%s%dx%d, %lld sources%s'\n",
            f->paper ? f->paper->name : "", f->paper ? ": " : "", f->width,
            f->height, f->sources, p->n ? "" : ": no row has an error");
    fprintf(to, p->n ? "plot $front with lines lw 2 lc rgb '#c03020' title "
                       "'Pareto front', $rows with points pt 7 ps 0.6 lc rgb "
                       "'#2050a0' notitle\n"
                     : "plot NaN notitle\n");
}

static void write_script(const struct gp_bench_table *t, FILE *to)
{
    const double height = (double) HEIGHT * t->frames;
    fprintf(to, "set terminal svg size %d,%.0f font 'sans,12' background rgb "
            "'white' noenhanced\n", WIDTH, height);
    fprintf(to, "set logscale xy\nset grid lt 1 lw 0.5 lc rgb '#dddddd'\nset key top right "
            "nobox\nset xlabel 'milliseconds, bright pass to layer'\n"
            "set ylabel 'rel_l2'\nset format x '%%g'\n"
            "set format y '%%.0e'\nset multiplot\n");
    for (int i = 0; i < t->frames; i++) {
        struct panel p;
        place_points(&t->frame[i], &p);
        write_panel(&p, height, (double) HEIGHT * (t->frames - 1 - i), to);
    }
    fprintf(to, "unset multiplot\n");
}

gp_status gp_bench_plot_check(const struct gp_log *log)
{
    char *out;
    size_t size;
    gp_status st = gp_gnuplot(log, "exit\n", &out, &size);
    if (!st)
        free(out);
    return st;
}

gp_status gp_bench_plot(const struct gp_log *log, const struct gp_bench_table *t,
                        const char *path)
{
    char *script = NULL, *svg = NULL;
    size_t length = 0, size = 0;
    FILE *to = open_memstream(&script, &length);
    if (to)
        write_script(t, to);
    if (!to || fclose(to) != 0) {
        free(script);
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", path);
    }
    gp_status st = gp_gnuplot(log, script, &svg, &size);
    if (!st && !strstr(svg, "</svg>"))
        st = gp_fail(log, GP_ERR_IO,
                     "gnuplot: made no SVG (%zu bytes); install the Debian "
                     "package gnuplot-nox", size);
    if (!st)
        st = gp_file_save(log, path, svg, size);
    free(script);
    free(svg);
    return st;
}
