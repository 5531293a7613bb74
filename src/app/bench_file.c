/* The table as CSV and as JSON. */
#include "app/bench_table.h"

#include "core/json.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/file.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// -- fields ----------------------------------------------------------------------

/* A cell: text, a number, or nothing. Both files have the same ones. */
struct cell {
    const char *name;
    const char *text;  // or NULL
    double number;     // NaN: nothing
    bool whole;        // a whole number
    bool truth;        // true or false
};
enum { CELLS = 23 };

static double rounded_ms(double ms)
{
    return round(ms * 1e3) * 1e-3;
}

static double if_known(bool known, double v)
{
    return known ? v : (double) NAN;
}

static void times(const struct gp_bench_row *r, struct cell *c)
{
    const bool ran = !r->why[0];
    c[0] = (struct cell) {"ms", NULL, if_known(ran, rounded_ms(r->ms)), 0, 0};
    c[1] = (struct cell) {"ms_min", NULL, if_known(ran, rounded_ms(r->ms_min)),
                          0, 0};
    c[2] = (struct cell) {"ms_max", NULL, if_known(ran, rounded_ms(r->ms_max)),
                          0, 0};
    c[3] = (struct cell) {"ms_first", NULL,
                          if_known(ran, rounded_ms(r->ms_first)), 0, 0};
    c[4] = (struct cell) {"frames_per_second", NULL,
                          if_known(ran, 1e3 / r->ms), 0, 0};
    c[5] = (struct cell) {"runs", NULL, if_known(ran, r->runs), true, 0};
    c[6] = (struct cell) {"extrapolated", NULL, r->extrapolated, 0, true};
    c[7] = (struct cell) {"share", NULL, if_known(r->extrapolated, r->share),
                          0, 0};
}

static void errors(const struct gp_bench_row *r, struct cell *c)
{
    const bool m = r->measured;
    c[0] = (struct cell) {"rel_l2", NULL, if_known(m, r->error.rel_l2), 0, 0};
    c[1] = (struct cell) {"max_rel", NULL, if_known(m, r->error.max_rel), 0, 0};
    c[2] = (struct cell) {"max_abs", NULL, if_known(m, r->error.max_abs), 0, 0};
    c[3] = (struct cell) {"flip", NULL, r->flip, 0, 0};
    c[4] = (struct cell) {"bound", NULL, r->bound, 0, 0};
}

/* All cells of a row; those of the same index have the same name. */
static void fill(const struct gp_bench_frame *f, const struct gp_bench_row *r,
                 struct cell c[CELLS])
{
    const bool ran = !r->why[0], drew = ran && r->polygons > 0.0;
    const char *const engine = ran ? r->stats.engine : NULL;
    c[0] = (struct cell) {"input", f->input, NAN, 0, 0};
    c[1] = (struct cell) {"name", r->name, NAN, 0, 0};
    c[2] = (struct cell) {"options", r->options, NAN, 0, 0};
    times(r, c + 3);
    errors(r, c + 11);
    c[16] = (struct cell) {"polygons", NULL, if_known(drew, r->polygons), true,
                           0};
    c[17] = (struct cell) {"polygon_pixels", NULL,
                           if_known(drew, r->polygon_pixels), 0, 0};
    c[18] = (struct cell) {"pareto", NULL, r->pareto, 0, true};
    c[19] = (struct cell) {"engine", engine, NAN, 0, 0};
    c[20] = (struct cell) {"form", ran ? r->stats.form : NULL, NAN, 0, 0};
    c[21] = (struct cell) {"gl", ran && r->gl[0] ? r->gl : NULL, NAN, 0, 0};
    c[22] = (struct cell) {"why", ran ? NULL : r->why, NAN, 0, 0};
}

// -- CSV --------------------------------------------------------------------------

static void csv_text(FILE *to, const char *s)
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

static void csv_cell(FILE *to, const struct cell *c)
{
    if (c->text)
        csv_text(to, c->text);
    else if (c->truth)
        fputs(c->number > 0.0 ? "true" : "false", to);
    else if (!isnan(c->number))
        fprintf(to, c->whole ? "%.0f" : "%.10g", c->number);
}

static void csv_lines(const struct gp_bench_table *t, FILE *to)
{
    struct cell c[CELLS];
    fill(&t->frame[0], &t->frame[0].row[0], c);
    for (int i = 0; i < CELLS; i++)
        fprintf(to, "%s%s", c[i].name, i < CELLS - 1 ? "," : "\r\n");
    for (int i = 0; i < t->frames; i++) {
        for (int k = 0; k < t->frame[i].rows; k++) {
            fill(&t->frame[i], &t->frame[i].row[k], c);
            for (int n = 0; n < CELLS; n++) {
                csv_cell(to, &c[n]);
                fputs(n < CELLS - 1 ? "," : "\r\n", to);
            }
        }
    }
}

gp_status gp_bench_csv(const struct gp_log *log, const struct gp_bench_table *t,
                       const char *path)
{
    char *text = NULL;
    size_t size = 0;
    FILE *to = open_memstream(&text, &size);
    bool fine = to != NULL;
    if (to) {
        csv_lines(t, to);
        fine = !ferror(to);
        fine = fclose(to) == 0 && fine;
    }
    gp_status st = fine ? gp_file_save(log, path, text, size)
                        : gp_fail(log, GP_ERR_BUG, "%s: out of memory", path);
    free(text);
    return st;
}

// -- JSON -------------------------------------------------------------------------

static json_t *json_cell(const struct cell *c)
{
    if (c->text)
        return gp_json_name(c->text);
    if (c->truth)
        return json_boolean(c->number > 0.0);
    if (c->whole)
        return json_integer((json_int_t) llround(c->number));
    return isfinite(c->number) ? json_real(c->number) : json_null();
}

static json_t *json_row(const struct gp_bench_frame *f,
                        const struct gp_bench_row *r)
{
    struct cell c[CELLS];
    json_t *row = json_object();
    fill(f, r, c);
    for (int i = 1; i < CELLS; i++) { // the input is said once, above
        if (c[i].text || !isnan(c[i].number))
            json_object_set_new(row, c[i].name, json_cell(&c[i]));
    }
    if (!r->why[0] && strcmp(r->name, "auto") == 0)
        json_object_set_new(row, "engine_why", gp_json_name(r->stats.why));
    return row;
}

static json_t *json_frame(const struct gp_bench_frame *f)
{
    json_t *o = json_object(), *rows = json_array();
    json_object_set_new(o, "input", gp_json_name(f->input));
    json_object_set_new(o, "width", json_integer(f->width));
    json_object_set_new(o, "height", json_integer(f->height));
    json_object_set_new(o, "sources", json_integer(f->sources));
    json_object_set_new(o, "kernel", gp_json_name(f->kernel));
    json_object_set_new(o, "kernel_size",
                        json_pack("[ii]", f->kernel_w, f->kernel_h));
    if (f->paper)
        json_object_set_new(
            o, "paper",
            json_pack("{ss ss si}", "gpu", "GeForce 7800 GTX", "rate",
                      f->paper->rate, "frames_per_second", f->paper->fps));
    for (int i = 0; i < f->rows; i++)
        json_array_append_new(rows, json_row(f, &f->row[i]));
    json_object_set_new(o, "rows", rows);
    return o;
}

gp_status gp_bench_json(const struct gp_log *log,
                        const struct gp_bench_table *t, const char *path)
{
    json_t *o = json_object(), *frames = json_array();
    for (int i = 0; i < t->frames; i++)
        json_array_append_new(frames, json_frame(&t->frame[i]));
    json_object_set_new(o, "frames", frames);
    json_object_set_new(o, "runs", json_integer(t->runs));
    json_object_set_new(o, "threads", json_integer(gp_threads()));
    json_object_set_new(o, "version", json_string(GP_VERSION));
    char *text = gp_json_print(o, JSON_INDENT(1) | JSON_REAL_PRECISION(10));
    if (!text)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", path);
    const size_t size = strlen(text);
    text[size] = '\n'; // in the place of its end
    gp_status st = gp_file_save(log, path, text, size + 1);
    free(text);
    return st;
}
