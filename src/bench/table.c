/* The techniques, and the table of their cost and error: as text, CSV, JSON, and
 * as a picture of speed against error. No text of the user's goes into the
 * script that gnuplot reads. */
#include "bench/bench_priv.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/parallel.h"
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

/* From the exact ones over one step of Ando et al. after the other to all of
 * them together. */
const struct gp_bench_technique gp_bench_techniques[] = {
    {"direct", "direct", 1, 0, 0.0f},
    {"fft", "fft", 1, 0, 0.0f},
    {"splat", "splat", 1, 0, 0.0f},
    {"splat group 2", "splat", 2, 0, 0.0f},
    {"splat group 4", "splat", 4, 0, 0.0f},
    {"splat group 8", "splat", 8, 0, 0.0f},
    {"splat group 4, cluster 8", "splat", 4, 8, 0.0f},
    {"splat group 4, shrink 1e-3", "splat", 4, 0, 1e-3f},
    {"splat 4/8/1e-3", "splat", 4, 8, 1e-3f},
    {"auto", "auto", 4, 8, 1e-3f},
    {0},
};
_Static_assert(sizeof gp_bench_techniques / sizeof *gp_bench_techniques ==
                   GP_BENCH_ROWS + 1, "a row for each technique");

void gp_bench_options(const struct gp_bench_technique *t, float tolerance,
                      char *line, size_t size)
{
    if (strcmp(t->engine, "auto") == 0)
        snprintf(line, size, "-e auto --tolerance %g", (double) tolerance);
    else if (strcmp(t->engine, "splat") != 0)
        snprintf(line, size, "-e %s", t->engine);
    else
        snprintf(line, size, "-e splat --group %d --cluster %d --shrink %g",
                 t->group, t->cluster, (double) t->shrink);
}

void gp_bench_mark_pareto(struct gp_bench_frame *f)
{
    for (int i = 0; i < f->rows; i++) {
        f->row[i].pareto = f->row[i].measured;
        for (int k = 0; k < f->rows; k++) {
            const struct gp_bench_row *const a = &f->row[k], *b = &f->row[i];
            const double ea = a->error.rel_l2, eb = b->error.rel_l2;
            if (a->layer == b->layer && a->measured && a->ms <= b->ms && ea <= eb &&
                (a->ms < b->ms || ea < eb))
                f->row[i].pareto = false;
        }
    }
}

void gp_bench_table_free(struct gp_bench_table *t)
{
    for (int i = 0; i < t->frames; i++) {
        GP_FREE(t->frame[i].input);
        GP_FREE(t->frame[i].kernel);
    }
    t->frames = 0;
}

void gp_bench_keep_why(void *why, const struct gp_line *line)
{
    if (line->level == GP_LEVEL_ERROR || line->level == GP_LEVEL_BARE)
        snprintf(why, GP_BENCH_WHY, "%s", line->text);
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

double gp_bench_median(double *v, int n)
{
    qsort(v, (size_t) n, sizeof *v, by_value);
    return 0.5 * (v[(n - 1) / 2] + v[n / 2]);
}

/* A number of a column, or "-" where it is not known. */
static void print_cell(int width, const char *format, double v)
{
    char text[32];
    if (isnan(v))
        snprintf(text, sizeof text, "-");
    else
        snprintf(text, sizeof text, format, v);
    printf(" %*s", width, text);
}

/* The table and its legend. */
static void print_table(const struct gp_bench_table *t)
{
    enum { WHY = 88 }; // of a line; the files have all of it
    const double none = (double) NAN;
    for (int i = 0; i < t->frames; i++) {
        const struct gp_bench_frame *const f = &t->frame[i];
        const char *gl = NULL; // context of the run
        printf("%s: %dx%d, %lld sources, kernel %s %dx%d",
               gp_printable(f->input).text, f->width, f->height, f->sources,
               gp_printable(f->kernel).text, f->kernel_w, f->kernel_h);
        if (!isnan(f->kernel_left_out))
            printf(", kernel_left_out %.2e", f->kernel_left_out);
        printf("; bright pass to layer, median of %d runs, %d threads\n",
               t->runs, gp_threads());
        if (f->paper)
            printf("beside the %s of the paper's frame rates (GeForce 7800 "
                   "GTX, approximate method, whole picture): %d frames a "
                   "second\n", f->paper->rate, f->paper->fps);
        printf("  %-26s %9s  %8s %8s %8s %8s %9s %8s %8s %8s %9s %8s",
               "technique", "ms", "min", "max", "first", "frames/s", "rel_l2",
               "max_rel", "FLIP", "bound", "polygons", "Mpixels");
        printf(f->paper ? " %8s\n" : "\n", "x paper");
        for (int k = 0; k < f->rows; k++) {
            const struct gp_bench_row *const r = &f->row[k];
            const bool drew = r->polygons > 0.0;
            if (r->why[0]) {
                printf("  %-26s cannot run: %.*s%s\n", r->name, WHY,
                       gp_printable(r->why).text,
                       strlen(r->why) > WHY ? "..." : "");
                continue;
            }
            printf("%c %-26s", r->pareto ? '>' : ' ', r->name);
            print_cell(9, r->ms < 1e4 ? "%.2f" : "%.0f", r->ms);
            putchar(r->extrapolated ? '*' : ' ');
            print_cell(8, "%.2f", r->extrapolated ? none : r->ms_min);
            print_cell(8, "%.2f", r->extrapolated ? none : r->ms_max);
            print_cell(8, r->ms_first < 1e4 ? "%.1f" : "%.0f", r->ms_first);
            print_cell(8, "%.4g", 1e3 / r->ms);
            print_cell(9, "%.2e", r->measured ? r->error.rel_l2 : none);
            print_cell(8, "%.1e", r->measured ? r->error.max_rel : none);
            print_cell(8, "%.1e", r->flip);
            print_cell(8, "%.1e", r->bound);
            print_cell(9, "%.0f", drew ? r->polygons : none);
            print_cell(8, "%.4g", drew ? r->polygon_pixels * 1e-6 : none);
            if (f->paper)
                print_cell(8, "%.2f", 1e3 / r->ms / f->paper->fps);
            putchar('\n');
        }
        for (int k = 0; k < f->rows; k++) {
            const struct gp_bench_row *const r = &f->row[k];
            if (!r->why[0] && strcmp(r->name, "auto") == 0)
                printf("  auto took %s: %s\n", r->facts.engine, r->facts.why);
            gl = !gl && r->gl[0] ? r->gl : gl;
        }
        if (gl)
            printf("  splat ran on %s\n", gp_printable(gl).text);
        putchar('\n');
    }
    printf("> on the Pareto front: no other row is both faster and nearer\n"
           "* a whole run takes over 6 s: extrapolated from a tenth (or "
           "hundredth) of the sources\n"
           "first: the first run, which makes plans, spectra and contexts "
           "that later frames keep\n"
           "4/8/1e-3: --group 4 --cluster 8 --shrink 1e-3, all of Ando's "
           "techniques; FLIP: of the tone-mapped pictures\n"
           "flare, lens: each layer against its own truth; the lens's are "
           "meshes twice as fine, of all ghosts\n");
}

// -- files -------------------------------------------------------------------

/* Milliseconds to the microsecond. */
static double round_us(double ms)
{
    return round(ms * 1e3) * 1e-3;
}

/* A cell: text, a number, or nothing. CSV and JSON have the same ones. */
struct cell {
    const char *name;
    const char *text;  // or NULL
    double number;     // NaN: nothing
    enum { REAL, WHOLE, TRUTH } kind; // of the number
};
enum { CELLS = 24 };

/* All cells of a row; those of the same index have the same name. */
static void make_cells(const struct gp_bench_frame *f,
                       const struct gp_bench_row *r, struct cell c[CELLS])
{
    const bool ran = !r->why[0], drew = ran && r->polygons > 0.0;
    const double none = (double) NAN;
    const struct glarepp_errors *const e = r->measured ? &r->error : NULL;
    const struct cell all[CELLS] = {
        {"input", f->input, none, REAL},
        {"name", r->name, none, REAL},
        {"options", r->options, none, REAL},
        {"ms", NULL, ran ? round_us(r->ms) : none, REAL},
        {"ms_min", NULL, ran ? round_us(r->ms_min) : none, REAL},
        {"ms_max", NULL, ran ? round_us(r->ms_max) : none, REAL},
        {"ms_first", NULL, ran ? round_us(r->ms_first) : none, REAL},
        {"frames_per_second", NULL, ran ? 1e3 / r->ms : none, REAL},
        {"runs", NULL, ran ? r->runs : none, WHOLE},
        {"extrapolated", NULL, r->extrapolated, TRUTH},
        {"share", NULL, r->extrapolated ? r->share : none, REAL},
        {"rel_l2", NULL, e ? e->rel_l2 : none, REAL},
        {"max_rel", NULL, e ? e->max_rel : none, REAL},
        {"max_abs", NULL, e ? e->max_abs : none, REAL},
        {"flip", NULL, r->flip, REAL},
        {"bound", NULL, r->bound, REAL},
        {"kernel_left_out", NULL, f->kernel_left_out, REAL},
        {"polygons", NULL, drew ? r->polygons : none, WHOLE},
        {"polygon_pixels", NULL, drew ? r->polygon_pixels : none, REAL},
        {"pareto", NULL, r->pareto, TRUTH},
        {"engine", ran ? r->facts.engine : NULL, none, REAL},
        {"form", ran ? r->facts.form : NULL, none, REAL},
        {"gl", ran && r->gl[0] ? r->gl : NULL, none, REAL},
        {"why", ran ? NULL : r->why, none, REAL},
    };
    memcpy(c, all, sizeof all);
}

static void print_csv_text(FILE *to, const char *s)
{
    if (!s[strcspn(s, ",\"\r\n")]) {
        fputs(s, to);
        return;
    }
    fputc('"', to);
    for (; *s; s++) {
        if (*s == '"')
            fputc('"', to);
        fputc(*s, to);
    }
    fputc('"', to);
}

static gp_status save_csv(const struct gp_log *log,
                          const struct gp_bench_table *t, const char *path)
{
    char *text = NULL;
    size_t size = 0;
    struct cell c[CELLS];
    FILE *const to = open_memstream(&text, &size);
    if (!to)
        return gp_no_memory(log, path);
    make_cells(&t->frame[0], &t->frame[0].row[0], c);
    for (int i = 0; i < CELLS; i++)
        fprintf(to, "%s%s", c[i].name, i < CELLS - 1 ? "," : "\r\n");
    for (int i = 0; i < t->frames; i++) {
        for (int k = 0; k < t->frame[i].rows; k++) {
            make_cells(&t->frame[i], &t->frame[i].row[k], c);
            for (int n = 0; n < CELLS; n++) {
                if (c[n].text) // a CSV may go to a terminal
                    print_csv_text(to, gp_printable(c[n].text).text);
                else if (c[n].kind == TRUTH)
                    fputs(c[n].number > 0.0 ? "true" : "false", to);
                else if (!isnan(c[n].number))
                    fprintf(to, c[n].kind == WHOLE ? "%.0f" : "%.10g",
                            c[n].number);
                fputs(n < CELLS - 1 ? "," : "\r\n", to);
            }
        }
    }
    const bool lost = ferror(to), closed = fclose(to) == 0;
    gp_status st = !lost && closed ? gp_file_save(log, path, text, size)
                                   : gp_no_memory(log, path);
    free(text);
    return st;
}

static gp_status save_json(const struct gp_log *log,
                           const struct gp_bench_table *t, const char *path)
{
    json_t *const frames = json_array();
    for (int i = 0; i < t->frames; i++) {
        const struct gp_bench_frame *const f = &t->frame[i];
        json_t *const paper = !f->paper ? NULL : json_pack("{ss ss si}",
            "gpu", "GeForce 7800 GTX", "rate", f->paper->rate,
            "frames_per_second", f->paper->fps);
        json_t *const rows = json_array();
        for (int k = 0; k < f->rows; k++) {
            const struct gp_bench_row *const r = &f->row[k];
            json_t *const row = json_object();
            struct cell c[CELLS];
            make_cells(f, r, c);
            for (int n = 1; n < CELLS; n++) { // the input is named once, below
                const double v = c[n].number;
                if (!c[n].text && isnan(v))
                    continue;
                json_object_set_new(
                    row, c[n].name,
                    c[n].text            ? gp_json_name(c[n].text)
                    : c[n].kind == TRUTH ? json_boolean(v > 0.0)
                    : c[n].kind == WHOLE ? json_integer((json_int_t) llround(v))
                    : isfinite(v)        ? json_real(v)
                                         : json_null());
            }
            if (!r->why[0] && strcmp(r->name, "auto") == 0)
                json_object_set_new(row, "engine_why",
                                    gp_json_name(r->facts.why));
            json_array_append_new(rows, row);
        }
        json_array_append_new(frames, json_pack(
            "{so si si sI so s[ii] so* so}", "input", gp_json_name(f->input),
            "width", f->width, "height", f->height,
            "sources", (json_int_t) f->sources,
            "kernel", gp_json_name(f->kernel),
            "kernel_size", f->kernel_w, f->kernel_h,
            "paper", paper, "rows", rows));
    }
    return gp_bench_save_json(log, json_pack("{so si si ss}", "frames", frames,
        "runs", t->runs, "threads", gp_threads(), "version", GP_VERSION), path);
}

gp_status gp_bench_save_json(const struct gp_log *log, json_t *o,
                             const char *path)
{
    char *const text =
        gp_json_print(o, JSON_INDENT(1) | JSON_REAL_PRECISION(10));
    if (!text)
        return gp_no_memory(log, path);
    const size_t size = strlen(text);
    text[size] = '\n'; // in the place of its end
    gp_status st = gp_file_save(log, path, text, size + 1);
    free(text);
    return st;
}

gp_status gp_bench_write(const struct gp_log *log,
    const struct gp_bench_params *p, const struct gp_bench_table *t)
{
    gp_status st = GP_OK;
    if (p->csv)
        GP_TRY(save_csv(log, t, p->csv));
    if (p->json)
        GP_TRY(save_json(log, t, p->json));
    if (p->plot)
        GP_TRY(gp_bench_plot(log, t, p->plot));
    if (gp_is_dash(p->csv) || gp_is_dash(p->json) ||
        gp_is_dash(p->plot))
        return GP_OK;
    print_table(t);
    st = gp_flush_stdout(log);
out:
    return st;
}

// -- plot ---------------------------------------------------------------------

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
    struct point at[GP_BENCH_MOST];
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
    int least = 3 * GP_BENCH_MOST;
    for (int k = 0; k < 44 && least > 0; k++) {
        const int step = (k / 4 + 1) * (k / 2 % 2 ? -1 : 1);
        const double dy = k < 2 ? 0.0 : step * (LINE / 2.0);
        const double x = k % 2 ? at->x - 8 - w : at->x + 8;
        const struct box b = {x, at->y + dy - LINE / 2.0, x + w,
                              at->y + dy + LINE / 2.0};
        int covered = b.x0 < LEFT || b.x1 > WIDTH - RIGHT || b.y0 < BOTTOM ||
                              b.y1 > HEIGHT - TOP
                          ? GP_BENCH_MOST : 0;
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
        if (r->layer) // of another error
            continue;
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
