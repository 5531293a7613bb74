/* Speed against error as a picture. No text of the user's goes into the script
 * that gnuplot reads. */
#include "bench/bench_priv.h"

#include "core/memory.h"
#include "io/file.h"

#include <errno.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

/* SVG pixels of a panel, and the plot inside it; y counts upwards. */
enum {
    WIDTH = 900, HEIGHT = 560,
    LEFT = 90, RIGHT = 20, BOTTOM = 60, TOP = 40,
    LETTER = 7, LINE = 14,  // of a label
};
static const double LEAST = 1e-10; // an error of 0 is drawn as this

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
    struct point at[GP_BENCH_ROWS];
    int n;
};

// -- panels ------------------------------------------------------------------

static bool meet(const struct box *a, const struct box *b)
{
    return a->x0 < b->x1 && b->x0 < a->x1 && a->y0 < b->y1 && b->y0 < a->y1;
}

/* Places a label beside its point if that is free, else further up or down,
 * where it covers the fewest points, earlier labels, and borders. */
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
        int covered = b.x0 < LEFT || b.x1 > WIDTH - RIGHT || b.y0 < BOTTOM ||
                              b.y1 > HEIGHT - TOP
                          ? GP_BENCH_ROWS : 0;
        for (int o = 0; o < p->n; o++) {
            const struct point *const other = &p->at[o];
            const struct box dot = {other->x - 4, other->y - 4, other->x + 4,
                                    other->y + 4};
            covered += meet(&b, &dot) + (o < i && meet(&b, &other->label));
        }
        if (covered < least) {
            least = covered;
            at->label = b;
        }
    }
}

/* Writes the plot of a frame, whose panel begins at `bottom` of `height`. */
static void write_panel(const struct gp_bench_frame *f, double height,
                        double bottom, FILE *to)
{
    struct panel panel = {.n = 0}, *const p = &panel;
    double low[2] = {INFINITY, INFINITY}, high[2] = {0.0, 0.0}; // ms, rel_l2
    for (int i = 0; i < f->rows; i++) {
        const struct gp_bench_row *r = &f->row[i];
        const double v[2] = {r->ms, fmax(r->error.rel_l2, LEAST)};
        if (!r->measured || !isfinite(r->error.rel_l2) || !(r->ms > 0.0))
            continue;
        p->at[p->n++] = (struct point) {.row = r, .ms = v[0], .error = v[1]};
        for (int axis = 0; axis < 2; axis++) {
            low[axis] = fmin(low[axis], v[axis]);
            high[axis] = fmax(high[axis], v[axis]);
        }
    }
    for (int axis = 0; axis < 2; axis++) {
        if (p->n == 0)
            low[axis] = high[axis] = 1.0;
        low[axis] /= 2.0;
        high[axis] *= axis ? 4.0 : 3.0;
    }
    for (int i = 0; i < p->n; i++) {
        struct point *const at = &p->at[i];
        const double u = log(at->ms / low[0]) / log(high[0] / low[0]);
        const double v = log(at->error / low[1]) / log(high[1] / low[1]);
        at->x = LEFT + (WIDTH - LEFT - RIGHT) * u;
        at->y = BOTTOM + (HEIGHT - BOTTOM - TOP) * v;
    }
    fprintf(to, "$rows << END\n");
    for (int i = 0; i < p->n; i++)
        fprintf(to, "%.6g %.6g\n", p->at[i].ms, p->at[i].error);
    fprintf(to, "END\n$front << END\n");
    // in order of time: on the front, that of error too
    const struct point *next;
    for (double last = 0.0;; last = next->ms) {
        next = NULL;
        for (int i = 0; i < p->n; i++) {
            const struct point *at = &p->at[i];
            if (at->row->pareto && at->ms > last &&
                (!next || at->ms < next->ms))
                next = at;
        }
        if (!next)
            break;
        fprintf(to, "%.6g %.6g\n", next->ms, next->error);
    }
    fprintf(to, "END\nunset label\nunset arrow\n");
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
                (bottom + at->y) / height, x / WIDTH, (bottom + y) / height);
    }
    fprintf(to, "set lmargin at screen %.5f\nset rmargin at screen %.5f\n"
            "set bmargin at screen %.5f\nset tmargin at screen %.5f\n",
            (double) LEFT / WIDTH, 1.0 - (double) RIGHT / WIDTH,
            (bottom + BOTTOM) / height, (bottom + HEIGHT - TOP) / height);
    fprintf(to, "set xrange [%.6g:%.6g]\nset yrange [%.6g:%.6g]\n", low[0],
            high[0], low[1], high[1]);
    fprintf(to, "set title '%s%s%dx%d, %lld sources%s'\n",
            f->paper ? f->paper->name : "", f->paper ? ": " : "", f->width,
            f->height, f->sources, p->n ? "" : ": no row has an error");
    fprintf(to, p->n ? "plot $front with lines lw 2 lc rgb '#c03020' title "
                       "'Pareto front', $rows with points pt 7 ps 0.6 lc rgb "
                       "'#2050a0' notitle\n"
                     : "plot NaN notitle\n");
}

// -- gnuplot -----------------------------------------------------------------

/* The child's standard streams are files in memory, so that no write blocks. */
enum { STREAMS = 3 };

/* All of a stream, and a 0 after it; NULL when it cannot be read. */
static char *read_stream(int fd, size_t *size)
{
    const off_t length = lseek(fd, 0, SEEK_END);
    char *const text = length >= 0 ? malloc((size_t) length + 1) : NULL;
    size_t n = 0;
    while (text && n < (size_t) length) {
        const ssize_t got = pread(fd, text + n, (size_t) length - n, (off_t) n);
        if (got <= 0 && errno != EINTR)
            break;
        n += got > 0 ? (size_t) got : 0;
    }
    if (text)
        text[n] = '\0';
    *size = n;
    return text;
}

/* Starts it and waits for its end. Returns 0, or an errno; *status is what
 * waitpid() says. */
static int run_child(const int fd[STREAMS], int *status)
{
    char name[] = "gnuplot", plain[] = "--default-settings";
    char *const argv[] = {name, plain, NULL};
    posix_spawn_file_actions_t actions;
    pid_t pid;
    int error = posix_spawn_file_actions_init(&actions);
    if (error)
        return error;
    for (int i = 0; i < STREAMS && !error; i++)
        error = posix_spawn_file_actions_adddup2(&actions, fd[i], i);
    if (!error)
        error = posix_spawnp(&pid, name, &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error)
        return error;
    while (waitpid(pid, status, 0) < 0) {
        if (errno != EINTR)
            return errno;
    }
    return 0;
}

gp_status gp_gnuplot(const struct gp_log *log, const char *script, char **out,
                     size_t *size)
{
    static const char *const names[STREAMS] = {"script", "picture", "errors"};
    int fd[STREAMS], status = 0;
    gp_status st = GP_OK;
    for (int i = 0; i < STREAMS; i++)
        fd[i] = memfd_create(names[i], MFD_CLOEXEC);
    int error = fd[0] >= 0 && fd[1] >= 0 && fd[2] >= 0 ? 0 : errno;
    for (size_t n = strlen(script), at = 0; at < n && !error;) {
        const ssize_t written = write(fd[0], script + at, n - at);
        if (written < 0 && errno != EINTR)
            error = errno;
        at += written > 0 ? (size_t) written : 0;
    }
    if (!error && lseek(fd[0], 0, SEEK_SET) != 0)
        error = errno;
    if (!error)
        error = run_child(fd, &status);
    if (error) {
        st = gp_fail(log, GP_ERR_IO,
                     "gnuplot: cannot be run (%s); install the Debian package "
                     "gnuplot-nox, or leave --plot out", strerror(error));
    } else if (!WIFEXITED(status) || WEXITSTATUS(status) == 127) {
        st = gp_fail(log, GP_ERR_IO,
                     "gnuplot: cannot be run (it ended with %#x); install the "
                     "Debian package gnuplot-nox, or leave --plot out",
                     (unsigned) status);
    } else if (WEXITSTATUS(status) != 0) { // its first line, without indent
        char *const text = read_stream(fd[2], size);
        const char *line = text ? text + strspn(text, " \n\t^") : "";
        st = gp_fail(log, GP_ERR_IO,
                     "gnuplot: drew no picture (%.*s); check the Debian "
                     "package gnuplot-nox",
                     *line ? (int) strcspn(line, "\n") : 10,
                     *line ? line : "no reason");
        free(text);
    }
    char *const text = st ? NULL : read_stream(fd[1], size);
    if (!st && !text)
        st = gp_no_memory(log, "gnuplot");
    if (!st)
        *out = text;
    for (int i = 0; i < STREAMS; i++) {
        if (fd[i] >= 0)
            close(fd[i]);
    }
    return st;
}

gp_status gp_bench_plot(const struct gp_log *log,
                        const struct gp_bench_table *t, const char *path)
{
    char *script = NULL, *svg = NULL;
    size_t length = 0, size = 0;
    FILE *to = open_memstream(&script, &length);
    const double height = (double) HEIGHT * t->frames;
    if (to)
        fprintf(to, "set terminal svg size %d,%.0f font 'sans,12' background "
                "rgb 'white' noenhanced\n"
                "set logscale xy\nset grid lt 1 lw 0.5 lc rgb '#dddddd'\n"
                "set key top right nobox\n"
                "set xlabel 'milliseconds, bright pass to layer'\n"
                "set ylabel 'rel_l2'\nset format x '%%g'\n"
                "set format y '%%.0e'\nset multiplot\n", WIDTH, height);
    for (int i = 0; to && i < t->frames; i++)
        write_panel(&t->frame[i], height,
                    (double) HEIGHT * (t->frames - 1 - i), to);
    if (to)
        fprintf(to, "unset multiplot\n");
    if (!to || fclose(to) != 0) {
        free(script);
        return gp_no_memory(log, path);
    }
    gp_status st = gp_gnuplot(log, script, &svg, &size);
    if (!st && !strstr(svg, "</svg>"))
        st = gp_fail(log, GP_ERR_IO,
                     "gnuplot: wrote no whole SVG (%zu bytes); install the "
                     "Debian package gnuplot-nox", size);
    if (!st)
        st = gp_file_save(log, path, svg, size);
    free(script);
    free(svg);
    return st;
}
