#include "app/bench.h"

#include "app/bench_measure.h"
#include "app/bench_sun.h"
#include "app/bench_table.h"
#include "app/options.h"
#include "app/sun_files.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "gl/gl.h"
#include "io/file.h"
#include "io/read.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

// -- before any work -----------------------------------------------------------------

static bool on_stdout(const char *path)
{
    return path && strcmp(path, "-") == 0;
}

/* Minutes of measuring should not end at a name that cannot be written. */
static gp_status check_files(const struct gp_log *log,
                             const struct gp_settings *s)
{
    const char *const file[] = {s->bench.csv, s->bench.json, s->bench.plot};
    for (int i = 0; i < 3; i++) {
        if (!file[i] || on_stdout(file[i]))
            continue;
        gp_status st = gp_file_check(log, file[i], false);
        if (st)
            return st;
    }
    if (!s->bench.plot)
        return GP_OK;
    const size_t n = strlen(s->bench.plot);
    if (!on_stdout(s->bench.plot) &&
        (n < 4 || strcasecmp(s->bench.plot + n - 4, ".svg") != 0))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: the plot is an SVG; give a name that ends in .svg",
                       s->bench.plot);
    return gp_bench_plot_check(log);
}

/* The kernel that was asked for; the paper's own where none was. */
static gp_status make_kernel(const struct gp_log *log,
                             const struct gp_settings *s,
                             struct gp_kernel *kernel, const char **name)
{
    // its address, so that asking for the default by name still counts
    const bool asked = s->kernel.source != gp_defaults.kernel.source;
    const bool own = s->bench.paper && !asked;
    const struct gp_read_params limits = gp_read_limits(&s->read);
    struct gp_frame image = {0};
    *name = own ? "streaks" : s->kernel.source;
    if (!own && strncmp(s->kernel.source, "builtin:", 8) == 0)
        return gp_kernel_builtin(log, &s->kernel, kernel);
    gp_status st = own ? gp_paper_kernel(log, GP_PAPER_KERNEL, &image)
                       : gp_read_frame(log, &limits, s->kernel.source, &image);
    if (!st)
        st = gp_kernel_from_frame(log, &s->kernel, &image, kernel);
    gp_frame_free(&image);
    return st;
}

// -- frames ---------------------------------------------------------------------------

/* The i-th frame of bench: the paper's, or the one that was given. */
static gp_status make_frame(const struct gp_log *log,
                            const struct gp_settings *s, int i,
                            struct gp_frame *f)
{
    return s->bench.paper
               ? gp_paper_frame(log, (enum gp_paper_kind) i, GP_PAPER_W,
                                GP_PAPER_H, f)
               : gp_read_frame(log, &s->read, s->inputs.at[0], f);
}

static gp_status measure_frame(const struct gp_bench_job *job, const char *kernel,
                               int i, struct gp_bench_table *t)
{
    struct gp_bench_frame *const out = &t->frame[t->frames++];
    struct gp_frame f = {0};
    gp_status st;
    GP_TRY(make_frame(job->log, job->s, i, &f));
    out->input = gp_strdup(f.path);
    out->kernel = gp_strdup(kernel);
    out->kernel_w = job->kernel->w;
    out->kernel_h = job->kernel->h;
    out->paper = job->s->bench.paper ? &gp_paper_rates[i] : NULL;
    if (!out->input || !out->kernel)
        GP_TRY(gp_fail(job->log, GP_ERR_BUG, "%s: out of memory", f.path));
    GP_TRY(gp_bench_measure(job, &f, out));
out:
    gp_frame_free(&f);
    return st;
}

// -- results --------------------------------------------------------------------------

static gp_status print_table(const struct gp_log *log,
                             const struct gp_bench_table *t)
{
    gp_bench_print(t, stdout);
    if (fflush(stdout) != 0 || ferror(stdout))
        return gp_fail(log, GP_ERR_IO,
                       "-: cannot write to stdout (%s); check who reads it",
                       strerror(errno));
    return GP_OK;
}

static gp_status write_all(const struct gp_log *log,
                           const struct gp_settings *s,
                           const struct gp_bench_table *t)
{
    gp_status st = GP_OK;
    if (s->bench.csv)
        GP_TRY(gp_bench_csv(log, t, s->bench.csv));
    if (s->bench.json)
        GP_TRY(gp_bench_json(log, t, s->bench.json));
    if (s->bench.plot)
        GP_TRY(gp_bench_plot(log, t, s->bench.plot));
    if (!on_stdout(s->bench.csv) && !on_stdout(s->bench.json) &&
        !on_stdout(s->bench.plot))
        GP_TRY(print_table(log, t));
out:
    return st;
}

gp_status gp_bench_run(const struct gp_log *log, const struct gp_settings *s)
{
    gp_status st;
    struct gp_kernel kernel = {0};
    struct gp_bench_job job = {.log = log, .s = s, .kernel = &kernel};
    struct gp_bench_table table = {.runs = s->bench.runs};
    const char *name;
    gp_set_threads(s->threads);
    gp_gl_prepare(); // while there is one thread
    GP_TRY(check_files(log, s));
    if (gp_suns_wanted(&s->sun)) {
        struct gp_job suns = {.input = (char *) s->inputs.at[0]};
        struct gp_sun_files files = {s, &suns};
        const struct gp_sun_reader reader = gp_sun_reader_of(&files);
        st = gp_bench_sun(log, s, &reader);
        goto out;
    }
    GP_TRY(make_kernel(log, s, &kernel, &name));
    for (int i = 0; i < (s->bench.paper ? GP_PAPER_KINDS : 1); i++)
        GP_TRY(measure_frame(&job, name, i, &table));
    GP_TRY(write_all(log, s, &table));
out:
    gp_bench_table_free(&table);
    gp_kernel_free(&kernel);
    return st;
}
