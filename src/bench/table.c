// SPDX-License-Identifier: Apache-2.0
/* The techniques, and the table of their cost and error: as text, CSV, JSON, and
 * as a picture of speed against error. */
#include "bench/bench_priv.h"
#include "core/json.h"
#include "core/parallel.h"
#include "io/file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* From the exact ones over one step of Ando et al. after the other to all of
 * them together. */
const struct gp_bench_technique gp_bench_techniques[] = {
    {"direct", "direct", 1, 0, 0.0f, false, 1e-3f},
    {"fft", "fft", 1, 0, 0.0f, false, 1e-3f},
    {"splat", "splat", 1, 0, 0.0f, false, 1e-3f},
    {"splat group 2", "splat", 2, 0, 0.0f, false, 1e-3f},
    {"splat group 4", "splat", 4, 0, 0.0f, false, 1e-3f},
    {"splat group 8", "splat", 8, 0, 0.0f, false, 1e-3f},
    {"splat group 4, cluster 8", "splat", 4, 8, 0.0f, false, 1e-3f},
    {"splat group 4, shrink 1e-3", "splat", 4, 0, 1e-3f, false, 1e-3f},
    {"splat 4/8/1e-3", "splat", 4, 8, 1e-3f, false, 1e-3f},
    {"levels", "fft", 1, 0, 0.0f, true, 1e-3f},
    {"levels 1e-2", "fft", 1, 0, 0.0f, true, 1e-2f},
    {"direct by true angles", "direct", 1, 0, 0.0f, true, 1e-3f},
    {"auto", "auto", 4, 8, 1e-3f, true, 0.0f},
    {0},
};
_Static_assert(sizeof gp_bench_techniques / sizeof *gp_bench_techniques ==
                   GP_BENCH_ROWS + 1, "a row for each technique");

void gp_bench_options(const struct gp_bench_technique *t, float tolerance,
                      bool plane, char *line, size_t size)
{
    const char *const by = plane ? " --projection plane" : "";
    if (t->follows)
        snprintf(line, size, "-e %s --tolerance %g", t->engine,
                 (double) (t->tolerance > 0.0f ? t->tolerance : tolerance));
    else if (strcmp(t->engine, "splat") != 0)
        snprintf(line, size, "-e %s%s", t->engine, by);
    else
        snprintf(line, size, "-e splat --group %d --cluster %d --shrink %g%s",
                 t->group, t->cluster, (double) t->shrink, by);
}

static const struct gp_bench_row unknown = {.took = {NAN, NAN, NAN, NAN, 0},
                                            .share = NAN,
                                            .polygons = NAN,
                                            .polygon_pixels = NAN,
                                            .bound = NAN,
                                            .error = {NAN, NAN, NAN},
                                            .max_abs = NAN};

struct gp_bench_row *gp_bench_row_add(const struct gp_bench *b,
                                      const char *name, const char *layer,
                                      struct gp_bench_frame *out)
{
    struct gp_bench_row *const row = &out->row[out->rows++];
    *row = unknown;
    row->name = name;
    row->layer = layer;
    if (!b->sense.sources)
        strcpy(row->why, "no pixel is over the threshold");
    return row;
}

void gp_bench_mark_pareto(struct gp_bench_frame *f)
{
    for (int i = 0; i < f->rows; i++) {
        f->row[i].pareto = !isnan(f->row[i].error[GP_REL_L2]);
        for (int k = 0; k < f->rows; k++) {
            const struct gp_bench_row *const a = &f->row[k], *b = &f->row[i];
            const double ea = a->error[GP_REL_L2], eb = b->error[GP_REL_L2];
            const double fast = a->took.ms, least = b->took.least;
            if (a->layer == b->layer && fast <= least && ea <= eb &&
                (fast < least || ea < eb))
                f->row[i].pareto = false;
        }
    }
    for (int i = 0; i < GP_BENCH_BY * GP_BENCH_WITHIN; i++) {
        int *const best = &f->choice[i / GP_BENCH_WITHIN][i % GP_BENCH_WITHIN];
        *best = -1;
        for (int k = 0; k < f->rows; k++) {
            const struct gp_bench_row *const r = &f->row[k];
            if (!r->layer &&
                r->error[i / GP_BENCH_WITHIN] <=
                    gp_bench_within[i % GP_BENCH_WITHIN] &&
                (*best < 0 || r->took.ms < f->row[*best].took.ms))
                *best = k;
        }
    }
}

const char *const gp_bench_by[GP_BENCH_BY] = {"rel_l2", "max_rel", "flip"};
const double gp_bench_within[GP_BENCH_WITHIN] = {1e-1, 1e-2, 1e-3, 1e-6};

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

void gp_bench_time(struct gp_bench_times *t, double ms)
{
    t->ms[t->n++] = ms;
    t->total += ms;
}

void gp_bench_spread(struct gp_bench_times *t, struct gp_bench_took *out)
{
    qsort(t->ms, (size_t) t->n, sizeof *t->ms, by_value);
    out->ms = 0.5 * (t->ms[(t->n - 1) / 2] + t->ms[t->n / 2]);
    out->least = t->ms[0];
    out->most = t->ms[t->n - 1];
    out->runs = t->n;
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

static void print_choices(const struct gp_bench_frame *f)
{
    printf("  %-26s %9s  %8s %8s\n", "fastest within", "ms", "error", "bound");
    for (int i = 0; i < GP_BENCH_BY * GP_BENCH_WITHIN; i++) {
        const int by = i / GP_BENCH_WITHIN, k = i % GP_BENCH_WITHIN;
        const struct gp_bench_row *const r =
            f->choice[by][k] < 0 ? NULL : &f->row[f->choice[by][k]];
        printf("  %-8s %.0e  ", gp_bench_by[by], gp_bench_within[k]);
        if (!r) {
            printf("none that is measured\n");
            continue;
        }
        printf("%-10s", "");
        print_cell(9, r->took.ms < 1e4 ? "%.2f" : "%.0f", r->took.ms);
        putchar(' ');
        print_cell(8, "%.1e", r->error[by]);
        print_cell(8, "%.1e", by == GP_REL_L2 ? r->bound : (double) NAN);
        printf("  %s\n", r->name);
    }
}

static void print_whole(const struct gp_bench_whole *w)
{
    const double before = fmax(w->read.ms, 0.0) + w->glare.ms + w->tone.ms;
    printf("  whole run: read");
    print_cell(0, "%.2f", w->read.ms);
    printf(", glare %.2f, compose and tone map %.2f ms, then one of these\n"
           "  (EXR, lossy EXR and PNG have a front each)\n"
           "  %-26s %9s  %8s %8s %9s %10s\n",
           w->glare.ms, w->tone.ms, "written to $TMPDIR", "ms", "min", "max",
           "kbytes", "whole ms");
    for (int i = 0; i < w->outputs; i++) {
        const struct gp_bench_output *const o = &w->output[i];
        if (o->why[0]) {
            printf("  %-26s cannot be written: %s\n", o->options,
                   gp_printable(o->why).text);
            continue;
        }
        printf("%c %-26s %9.2f  %8.2f %8.2f %9.1f %10.2f%s\n",
               o->pareto ? '>' : ' ', o->options, o->took.ms, o->took.least,
               o->took.most, (double) o->bytes * 1e-3, before + o->took.ms,
               o->usual                                ? "  the default"
               : o->compression < GP_COMPRESSION_PXR24 ? ""
                                                       : "  lossy");
    }
}

static void print_table(const struct gp_bench_table *t)
{
    enum { WHY = 88 }; // of a line; the files have all of it
    const double none = (double) NAN;
    for (int i = 0; i < t->frames; i++) {
        const struct gp_bench_frame *const f = &t->frame[i];
        const char *gl = NULL; // context of the run
        printf("%s: %dx%d, %lld sources, kernel %s",
               gp_printable(f->input).text, f->width, f->height, f->sources,
               gp_printable(f->kernel).text);
        if (f->angles)
            printf(" by true angles");
        else
            printf(" %dx%d", f->kernel_w, f->kernel_h);
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
            const struct gp_bench_took *const ms = &r->took;
            const bool whole = isnan(r->share);
            if (r->why[0]) {
                printf("  %-26s cannot run: %.*s%s\n", r->name, WHY,
                       gp_printable(r->why).text,
                       strlen(r->why) > WHY ? "..." : "");
                continue;
            }
            printf("%c %-26s", r->pareto ? '>' : ' ', r->name);
            print_cell(9, ms->ms < 1e4 ? "%.2f" : "%.0f", ms->ms);
            putchar(whole ? ' ' : '*');
            print_cell(8, "%.2f", whole ? ms->least : none);
            print_cell(8, "%.2f", whole ? ms->most : none);
            print_cell(8, ms->first < 1e4 ? "%.1f" : "%.0f", ms->first);
            print_cell(8, "%.4g", 1e3 / ms->ms);
            for (int by = 0; by < GP_BENCH_BY; by++)
                print_cell(by ? 8 : 9, by ? "%.1e" : "%.2e", r->error[by]);
            print_cell(8, "%.1e", r->bound);
            print_cell(9, "%.0f", r->polygons);
            print_cell(8, "%.4g", r->polygon_pixels * 1e-6);
            if (f->paper)
                print_cell(8, "%.2f", 1e3 / ms->ms / f->paper->fps);
            putchar('\n');
        }
        for (int k = 0; k < f->rows; k++) {
            const struct gp_bench_row *const r = &f->row[k];
            if (!r->why[0] && strcmp(r->name, "auto") == 0)
                printf("  auto took %.*s%s%s\n",
                       (int) strcspn(r->facts.why, ","), r->facts.why,
                       r->same ? ": the same runs as " : "",
                       r->same ? r->same : "");
            gl = !gl && r->gl[0] ? r->gl : gl;
        }
        if (gl)
            printf("  splat ran on %s\n", gp_printable(gl).text);
        if (f->angles)
            printf("  direct, plane, splat: a plane's error is in theirs\n");
        print_choices(f);
        if (f->whole.outputs)
            print_whole(&f->whole);
        putchar('\n');
    }
    printf(
        "> on the Pareto front: no other row is nearer (of a format: smaller) "
        "and its median faster than the fastest run here\n"
        "* a whole run takes over 6 s: extrapolated from parts of "
        "the sources, a tenth (or hundredth) and a tenth of that\n"
        "first: the first run, which makes plans, spectra and contexts "
        "that later frames keep\n"
        "4/8/1e-3: --group 4 --cluster 8 --shrink 1e-3, all of Ando's "
        "techniques; FLIP: of the tone-mapped pictures\n"
        "flare, lens: each against its own truth; the lens's are "
        "meshes twice as fine, of all ghosts\n");
}

// -- files -------------------------------------------------------------------

/* Ends a stream in memory, and writes what it holds. */
static gp_status save_text(const struct gp_log *log, const char *path, FILE *to,
                           char **text, const size_t *size)
{
    const bool lost = ferror(to), closed = fclose(to) == 0;
    const gp_status st =
        !lost && closed ? gp_file_save(log, path, false, false, *text, *size)
                        : gp_no_memory(log, path);
    free(*text);
    return st;
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

static void print_csv_value(FILE *to, const json_t *v)
{
    if (json_is_string(v)) // a CSV may go to a terminal
        print_csv_text(to, gp_printable(json_string_value(v)).text);
    else if (json_is_boolean(v))
        fputs(json_is_true(v) ? "true" : "false", to);
    else if (json_is_integer(v))
        fprintf(to, "%" JSON_INTEGER_FORMAT, json_integer_value(v));
    else if (v)
        fprintf(to, "%.10g", json_is_null(v) ? INFINITY : json_real_value(v));
}

static gp_status save_csv(const struct gp_log *log, const char *path,
                          json_t *all, const char *columns)
{
    json_t *const frames = json_object_get(all, "frames");
    const size_t n = frames ? json_array_size(frames) : 1;
    // only its text says whether memory was full for a value
    char *const whole = gp_json_print(json_incref(all), 0), *text = NULL;
    size_t size = 0;
    FILE *const to = whole ? open_memstream(&text, &size) : NULL;
    free(whole);
    if (!to)
        return gp_no_memory(log, path);
    fprintf(to, "%s\r\n", columns);
    for (size_t i = 0; i < n; i++) {
        json_t *const frame = frames ? json_array_get(frames, i) : all, *row;
        size_t k;
        json_array_foreach(json_object_get(frame, "rows"), k, row)
        {
            for (const char *c = columns; *c;) {
                const int length = (int) strcspn(c, ",");
                char name[32];
                snprintf(name, sizeof name, "%.*s", length, c);
                const json_t *const v = json_object_get(row, name);
                print_csv_value(to, v ? v : json_object_get(frame, name));
                c += length;
                fputs(*c ? "," : "\r\n", to);
                c += *c == ',';
            }
        }
    }
    return save_text(log, path, to, &text, &size);
}

gp_status gp_bench_save(const struct gp_log *log,
                        const struct gp_bench_params *p, json_t *all,
                        const char *columns)
{
    gp_status st = p->csv ? save_csv(log, p->csv, all, columns) : GP_OK;
    if (!st && p->json)
        st = gp_bench_save_json(log, json_incref(all), p->json);
    json_decref(all);
    return st;
}

json_t *gp_bench_number(double v)
{
    return isnan(v) ? NULL : isfinite(v) ? json_real(v) : json_null();
}

json_t *gp_bench_ms(double ms)
{
    return gp_bench_number(round(ms * 1e3) * 1e-3);
}

/* A whole number; NULL of NaN, and of 0, which is not known. */
static json_t *count(double v)
{
    return v > 0.0 ? json_integer((json_int_t) llround(v)) : NULL;
}

static json_t *row_json(const struct gp_bench_frame *f,
                        const struct gp_bench_row *r)
{
    const bool ran = !r->why[0], is_auto = strcmp(r->name, "auto") == 0;
    return json_pack(
        "{ss ss so* so* so* so* so* so* sb so* so* so* so* so* so* so* so* so* "
        "sb ss* ss* ss* so* so* so* ss*}",
        "name", r->name, "options", r->options, "ms", gp_bench_ms(r->took.ms),
        "ms_min", gp_bench_ms(r->took.least), "ms_max",
        gp_bench_ms(r->took.most), "ms_first", gp_bench_ms(r->took.first),
        "frames_per_second", gp_bench_number(1e3 / r->took.ms), "runs",
        count(r->took.runs), "extrapolated", !isnan(r->share), "share",
        gp_bench_number(r->share), "rel_l2",
        gp_bench_number(r->error[GP_REL_L2]), "max_rel",
        gp_bench_number(r->error[GP_MAX_REL]), "max_abs",
        gp_bench_number(r->max_abs), "flip", gp_bench_number(r->error[GP_FLIP]),
        "bound", gp_bench_number(r->bound), "kernel_left_out",
        gp_bench_number(f->kernel_left_out), "polygons", count(r->polygons),
        "polygon_pixels", gp_bench_number(r->polygon_pixels), "pareto",
        r->pareto, "engine", ran ? r->facts.engine : NULL, "form",
        ran ? r->facts.form : NULL, "same_as", r->same, "gl",
        ran && r->gl[0] ? gp_json_name(r->gl) : NULL, "why",
        ran ? NULL : gp_json_name(r->why), "engine_why",
        ran && is_auto ? gp_json_name(r->facts.why) : NULL, "layer", r->layer);
}

/* The choices: one object a limit and measure, without a name where there is none. */
static json_t *choices_json(const struct gp_bench_frame *f)
{
    json_t *const all = json_array();
    for (int i = 0; i < GP_BENCH_BY * GP_BENCH_WITHIN; i++) {
        const int by = i / GP_BENCH_WITHIN, k = i % GP_BENCH_WITHIN;
        const int at = f->choice[by][k];
        const struct gp_bench_row *const r = at < 0 ? &unknown : &f->row[at];
        json_array_append_new(
            all, json_pack("{ss sf ss* ss* so* so* so*}", "by", gp_bench_by[by],
                           "within", gp_bench_within[k], "name", r->name,
                           "options", r->name ? r->options : NULL, "ms",
                           gp_bench_ms(r->took.ms), "error",
                           gp_bench_number(r->error[by]), "bound",
                           gp_bench_number(by ? (double) NAN : r->bound)));
    }
    return all;
}

/* The whole run; NULL: not measured. */
static json_t *whole_json(const struct gp_bench_whole *w)
{
    json_t *const outputs = w->outputs ? json_array() : NULL;
    for (int i = 0; i < w->outputs; i++) {
        const struct gp_bench_output *const o = &w->output[i];
        const struct gp_bench_took *const t = &o->took;
        json_array_append_new(
            outputs,
            json_pack("{ss ss so* so* so* so* so* sb sb so*}", "format",
                      o->format, "options", o->options, "ms",
                      gp_bench_ms(t->ms), "ms_min", gp_bench_ms(t->least),
                      "ms_max", gp_bench_ms(t->most), "runs", count(t->runs),
                      "bytes", count((double) o->bytes), "default", o->usual,
                      "pareto", o->pareto, "why",
                      o->why[0] ? gp_json_name(o->why) : NULL));
    }
    return !outputs
               ? NULL
               : json_pack("{so* so so so}", "read_ms", gp_bench_ms(w->read.ms),
                           "glare_ms", gp_bench_ms(w->glare.ms), "tone_ms",
                           gp_bench_ms(w->tone.ms), "outputs", outputs);
}

json_t *gp_bench_json_frame(const struct gp_bench_frame *f)
{
    json_t *const paper =
        !f->paper
            ? NULL
            : json_pack("{ss ss si}", "gpu", "GeForce 7800 GTX", "rate",
                        f->paper->rate, "frames_per_second", f->paper->fps);
    json_t *const rows = json_array();
    for (int k = 0; k < f->rows; k++)
        json_array_append_new(rows, row_json(f, &f->row[k]));
    return json_pack("{so si si sI so s[ii] so* so so so*}", "input",
                     gp_json_name(f->input), "width", f->width, "height",
                     f->height, "sources", (json_int_t) f->sources, "kernel",
                     gp_json_name(f->kernel), "kernel_size", f->kernel_w,
                     f->kernel_h, "paper", paper, "rows", rows, "choices",
                     choices_json(f), "whole", whole_json(&f->whole));
}

static gp_status save_files(const struct gp_log *log,
                            const struct gp_bench_params *p,
                            const struct gp_bench_table *t)
{
    static const char columns[] =
        "input,name,options,ms,ms_min,ms_max,ms_first,frames_per_second,runs,"
        "extrapolated,share,rel_l2,max_rel,max_abs,flip,bound,kernel_left_out,"
        "polygons,polygon_pixels,pareto,engine,form,same_as,gl,why";
    json_t *const frames = json_array();
    for (int i = 0; i < t->frames; i++)
        json_array_append_new(frames, gp_bench_json_frame(&t->frame[i]));
    return gp_bench_save(log, p,
                         json_pack("{so si si ss}", "frames", frames, "runs",
                                   t->runs, "threads", gp_threads(), "version",
                                   GP_VERSION),
                         columns);
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
    gp_status st = gp_file_save(log, path, false, false, text, size + 1);
    free(text);
    return st;
}

// -- the plot -----------------------------------------------------------------

/* SVG pixels of a panel, the plot inside it, a line of labels, and a column of
 * choices under the axis. */
enum { WIDTH = 900, HEIGHT = 640, LEFT = 90, RIGHT = 250, TOP = 40 };
enum { BOTTOM = 140, LINE = 16, CHOICE = 280 };
static const double LEAST = 1e-10; // an error of 0 is drawn as this

struct point {
    const struct gp_bench_row *row;
    double v[2], at[2]; // ms and rel_l2; pixels
    double label;       // y of its name, right of the plot
};

/* Whole decades, and the pixels at their ends. */
struct axis {
    double low, high, from, to;
};

static double place(const struct axis *a, double v)
{
    return a->from + (a->to - a->from) * log(v / a->low) / log(a->high / a->low);
}

/* By error, the largest first: on the front, by time too. */
static int by_error(const void *a, const void *b)
{
    return by_value(&((const struct point *) b)->v[1],
                    &((const struct point *) a)->v[1]);
}

/* Finds the rows that are drawn, and where. */
static int find_points(const struct gp_bench_frame *f, struct axis axis[2],
                       struct point at[GP_BENCH_MOST])
{
    double label = TOP - LINE, limit = HEIGHT - BOTTOM;
    int n = 0;
    for (int i = 0; i < f->rows; i++) {
        const struct gp_bench_row *const r = &f->row[i];
        if (r->layer || r->same || !isfinite(r->error[GP_REL_L2]) ||
            !(r->took.ms > 0.0))
            continue; // those of another layer have another error
        at[n++] = (struct point) {
            .row = r,
            .v = {r->took.ms, fmax(r->error[GP_REL_L2], LEAST)},
        };
        for (int k = 0; k < 2; k++) {
            const double decade = floor(log10(at[n - 1].v[k]));
            axis[k].low = fmin(axis[k].low, pow(10.0, decade));
            axis[k].high = fmax(axis[k].high, pow(10.0, decade + 1.0));
        }
    }
    qsort(at, (size_t) n, sizeof *at, by_error);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 2; k++)
            at[i].at[k] = place(&axis[k], at[i].v[k]);
        at[i].label = label = fmax(at[i].at[1], label + LINE);
    }
    for (int i = n - 1; i >= 0; i--, limit -= LINE)
        at[i].label = fmin(at[i].label, limit);
    return n;
}

static void write_grid(const struct axis axis[2], FILE *to)
{
    const struct axis *const x = &axis[0], *const y = &axis[1];
    for (double v = x->low; v < 2.0 * x->high; v *= 10.0)
        fprintf(to, "<path d='M%.1f %.1fV%.1f' stroke='#ddd'/><text x='%.1f' "
                "y='%.1f' text-anchor='middle'>%g</text>\n", place(x, v),
                y->from, y->to, place(x, v), y->from + LINE, v);
    for (double v = y->low; v < 2.0 * y->high; v *= 10.0)
        fprintf(to, "<path d='M%.1f %.1fH%.1f' stroke='#ddd'/><text x='%.1f' "
                "y='%.1f' text-anchor='end'>%.0e</text>\n", x->from, place(y, v),
                x->to, x->from - 6.0, place(y, v) + 4.0, v);
    fprintf(to,
            "<text x='%.1f' y='%d' text-anchor='middle'>milliseconds, bright "
            "pass to layer</text>\n<text transform='translate(20 %.1f) "
            "rotate(-90)' text-anchor='middle'>rel_l2</text>\n",
            0.5 * (x->from + x->to), HEIGHT - BOTTOM + 2 * LINE,
            0.5 * (y->from + y->to));
}

/* Writes the choices under the axis: a column a measure, a line a limit. */
static void write_choices(const struct gp_bench_frame *f, FILE *to)
{
    for (int i = 0; i < GP_BENCH_BY * GP_BENCH_WITHIN; i++) {
        const int by = i / GP_BENCH_WITHIN, k = i % GP_BENCH_WITHIN;
        const int at = f->choice[by][k], x = LINE + by * CHOICE;
        const int y = HEIGHT - BOTTOM + 4 * LINE;
        if (k == 0)
            fprintf(to,
                    "<text x='%d' y='%d' font-weight='bold'>fastest by "
                    "%s</text>\n",
                    x, y - LINE + 4, gp_bench_by[by]);
        fprintf(to, "<text x='%d' y='%d'>within %.0e: ", x, y + k * LINE + 4,
                gp_bench_within[k]);
        if (at >= 0)
            fprintf(to, "%s, %.3g ms", f->row[at].name, f->row[at].took.ms);
        fprintf(to, "%s</text>\n", at < 0 ? "none" : "");
    }
}

/* Draws a frame's rows, with lines to their names. */
static void write_panel(const struct gp_bench_frame *f, FILE *to)
{
    struct axis axis[2] = {{INFINITY, 0.0, LEFT, WIDTH - RIGHT},
                           {INFINITY, 0.0, HEIGHT - BOTTOM, TOP}};
    struct point at[GP_BENCH_MOST];
    const int n = find_points(f, axis, at);
    fprintf(to, "<text x='%d' y='20'>%s%s%dx%d, %lld sources%s</text>\n", LEFT,
            f->paper ? f->paper->name : "", f->paper ? ": " : "", f->width,
            f->height, f->sources, n ? "" : ": no row has an error");
    if (!n)
        return;
    write_grid(axis, to);
    write_choices(f, to);
    fprintf(to, "<polyline fill='none' stroke='#c03020' stroke-width='2' "
            "points='");
    double last = 0.0; // rows within the spread of the front leave no dents
    for (int i = 0; i < n; i++) {
        if (at[i].row->pareto && at[i].at[0] >= last)
            fprintf(to, "%.1f,%.1f ", last = at[i].at[0], at[i].at[1]);
    }
    fprintf(to, "'/>\n<text x='%d' y='20' text-anchor='end' fill='#c03020'>"
            "Pareto front</text>\n", WIDTH - RIGHT);
    for (int i = 0; i < n; i++) {
        const char *const twin = at[i].row->twin;
        fprintf(to,
                "<path d='M%.1f %.1fL%d %.1f' stroke='#bbb'/><circle "
                "cx='%.1f' cy='%.1f' r='4' fill='%s'/><text x='%d' "
                "y='%.1f'%s>%s%s%s</text>\n",
                at[i].at[0], at[i].at[1], WIDTH - RIGHT + 10, at[i].label,
                at[i].at[0], at[i].at[1],
                at[i].row->pareto ? "#c03020" : "#2050a0", WIDTH - RIGHT + 14,
                at[i].label + 4.0, at[i].row->pareto ? "" : " fill='#666'",
                at[i].row->name, twin ? ", " : "", twin ? twin : "");
    }
}

/* Milliseconds against rel_l2, a picture a frame; no text of the user's. */
static gp_status save_plot(const struct gp_log *log,
                           const struct gp_bench_table *t, const char *path)
{
    char *svg = NULL;
    size_t size = 0;
    FILE *const to = open_memstream(&svg, &size);
    if (!to)
        return gp_no_memory(log, path);
    fprintf(to, "<svg xmlns='http://www.w3.org/2000/svg' width='%d' height='%d' "
            "font-family='sans-serif' font-size='12'>\n<rect width='100%%' "
            "height='100%%' fill='white'/>\n", WIDTH, HEIGHT * t->frames);
    for (int i = 0; i < t->frames; i++) {
        fprintf(to, "<g transform='translate(0 %d)'>\n", HEIGHT * i);
        write_panel(&t->frame[i], to);
        fprintf(to, "</g>\n");
    }
    fprintf(to, "</svg>\n");
    return save_text(log, path, to, &svg, &size);
}

gp_status gp_bench_write(const struct gp_log *log,
    const struct gp_bench_params *p, const struct gp_bench_table *t)
{
    gp_status st = GP_OK;
    if (p->csv || p->json)
        GP_TRY(save_files(log, p, t));
    if (p->plot)
        GP_TRY(save_plot(log, t, p->plot));
    if (gp_is_dash(p->csv) || gp_is_dash(p->json) || gp_is_dash(p->plot) ||
        gp_is_dash(p->page))
        return GP_OK;
    print_table(t);
    st = gp_flush_stdout(log);
out:
    return st;
}
