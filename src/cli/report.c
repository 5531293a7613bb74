// SPDX-License-Identifier: Apache-2.0
#include "cli/report.h"

#include "cli/machine.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/file.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

void gp_frame_report_dark(const struct gp_frame_report *f, int frames, char *line,
                   size_t size)
{
    char of[40] = "", found[64] = "all are black";
    const struct glarepp_sense_facts *const s = &f->lib.sense;
    const bool lit = s->peak > 0.0f;
    const bool masked = lit && f->read.mask && s->peak > s->threshold;
    if (frames > 1)
        snprintf(of, sizeof of, " of %d frames", frames);
    if (lit)
        snprintf(found, sizeof found, "brightest %.3g at %d,%d",
                 (double) s->peak, s->peak_at[0], s->peak_at[1]);
    snprintf(line, size, "%s: no pixel%s%s over the threshold %.3g%s (%s); %s",
             f->read.source ? f->read.source : f->job.of.input, of,
             masked ? "" : " is", (double) s->threshold,
             masked ? " is in the source mask" : "", found,
             masked ? "check --source-mask"
             : lit  ? "lower --threshold"
                    : "check the frame");
}

// -- the settings that made a picture -----------------------------------------

json_t *gp_option_json(const struct gp_settings *s, const struct gp_option *o)
{
    const void *const at = (const char *) s + o->at;
    const struct gp_numbers *const list = at;
    const struct gp_texts *const texts = at;
    const char *const *const word = at;
    json_t *v = NULL;
    char text[32];
    const struct gp_option_choice *choice;
    switch (o->kind) {
    case GP_KIND_FLAG:
        return json_boolean(*(const bool *) at);
    case GP_KIND_FLOAT: // 0.001 as written, not its nearest float
    case GP_KIND_REAL:
        snprintf(text, sizeof text, "%.7g", o->kind == GP_KIND_REAL
                     ? *(const double *) at : (double) *(const float *) at);
        return json_real(strtod(text, NULL)); // NULL when it is not finite
    case GP_KIND_LEVEL:
        return *(const float *) at > 0.0f
                   ? json_real((double) *(const float *) at)
                   : json_string("auto");
    case GP_KIND_THRESHOLD: // "99.9%" and "+3ev" too
        snprintf(text, sizeof text, s->light.sense.unit == GLAREPP_EV
                     ? "%+.7gev" : s->light.sense.unit == GLAREPP_PERCENTILE
                     ? "%.7g%%" : "%.7g", (double) s->light.sense.threshold);
        return s->light.sense.unit == GLAREPP_LUMINANCE
                   ? json_real(strtod(text, NULL)) : json_string(text);
    case GP_KIND_SIZE:
        snprintf(text, sizeof text, "%.7gdeg", s->kernel.p.degrees);
        return s->kernel.p.degrees > 0.0      ? json_string(text)
               : s->kernel.p.percent != 100.0 ? json_real(s->kernel.p.percent)
                                              : NULL;
    case GP_KIND_INT:
        return json_integer(*(const int *) at);
    case GP_KIND_COUNT:
        return json_integer(*(const long long *) at);
    case GP_KIND_NUMBERS:
        v = list->n ? json_array() : NULL;
        for (int i = 0; i < list->n; i++)
            json_array_append_new(v, json_real(list->v[i]));
        return v;
    case GP_KIND_CHOICE:
    case GP_KIND_EITHER:
        choice = gp_option_chosen(o, at);
        return !choice ? NULL
               : choice->text || strspn(choice->name, "0123456789") == 0
                     ? json_string(choice->name) : json_integer(choice->value);
    case GP_KIND_TEXT:
        return *word ? gp_json_name(*word) : NULL;
    case GP_KIND_TEXTS:
        v = texts->n ? json_array() : NULL;
        for (int i = 0; i < texts->n; i++)
            json_array_append_new(v, gp_json_name(texts->at[i]));
        return v;
    case GP_KIND_SET:
        return *(const int *) at == o->set ? json_true() : NULL;
    case GP_KIND_NAMED:
        break;
    }
    return NULL;
}

/* The settings of a picture, by option name with _ for -: those that can change
 * a pixel and do something together with the others, given or not; unset
 * numbers and words are left out. Errors: as gp_json_print(). */
static json_t *settings_json(const struct gp_settings *s)
{
    const unsigned unmet = gp_needs_unmet(s);
    json_t *const all = json_object();
    for (const struct gp_option *o = gp_options; o->name; o++) {
        char key[32];
        if (!(o->commands & s->command) || !gp_option_makes_pixels(o) ||
            (o->needs & unmet) ||
            (o->group == GP_GROUP_SUN && !gp_option_given(s, o->name) &&
             !gp_lights_wanted(s)))
            continue;
        snprintf(key, sizeof key, "%s", o->name);
        for (char *c = key; *c; c++)
            *c = *c == '-' ? '_' : *c;
        json_t *const v = gp_option_json(s, o);
        if (v)
            json_object_set_new(all, key, v);
    }
    return all;
}

/* A number rounded to `step`; null where it is not finite. */
static json_t *rounded(double v, double step)
{
    if (!isfinite(v))
        return json_null();
    return json_real(step > 0.0 ? round(v / step) * step : v);
}

// -- the fields --------------------------------------------------------------

enum kind {
    TEXT,     // const char *
    CHARS,    // char[]
    TRUE,
    INT,
    LONG,
    COUNT,    // size_t
    FLOAT,
    REAL,     // double, rounded to `step`
    MS,       // double; under 0: the stage did not run
    MIB,      // size_t, bytes
    PUPIL,    // double; 0 is null
    INTERVAL, // two doubles, rounded outward
    OBJECT,   // of `rows`
    SETTINGS, // const struct gp_settings *
    WARNINGS, // of all facts
    PEAK, THREADS, VERSION, SCHEMA, // no fact
};

/* A field: its name, after that of the object that holds it and a dot; where
 * its value is among the facts, or in the item whose fields they are; when it
 * is there. */
struct row {
    const char *name;
    enum kind kind;
    size_t at;
    size_t if_at, if_bytes;   // left out where these bytes are all 0
    bool unless;              // left out where they are not
    bool pointed;             // a pointer to the value or list
    size_t size;              // of an item of a list; 0: no list
    int n;                    // items; 0: the int at `count` says how many
    size_t count;
    double step;
    const struct row *rows;   // those of an object
};

#define AT(type, m) offsetof(struct type, m)
#define BYTES(type, m)                                                        \
    .if_at = AT(type, m), .if_bytes = sizeof ((struct type *) 0)->m
#define AS(k, type, label, m, ...)                                            \
    {.name = label, .kind = k, .at = AT(type, m), __VA_ARGS__}
#define OF(type, label, m, ...)                                               \
    AS(_Generic(&((struct type *) 0)->m, const char **: TEXT, char **: TEXT,  \
                char *: CHARS, bool *: TRUE, int *: INT, long long *: LONG,   \
                size_t *: COUNT, float *: FLOAT, double *: REAL,              \
                double (*)[3]: REAL, const struct gp_settings **: SETTINGS),  \
       type, label, m, __VA_ARGS__)
/* A fact; one that is left out where it is 0. */
#define FACT(label, m, ...) OF(gp_frame_report, label, m, __VA_ARGS__)
#define SOME(label, m, ...) FACT(label, m, IF(m), __VA_ARGS__)
#define IF(m) BYTES(gp_frame_report, m)
#define INTS(many) .size = sizeof(int), .n = many
#define RGB .size = sizeof(double), .n = 3
#define MANY(m, many)                                                         \
    .size = sizeof *((struct gp_frame_report *) 0)->m, .count = AT(gp_frame_report, many)
#define LIST(label, k, m, many, ...)                                          \
    AS(k, gp_frame_report, label, m, .pointed = true, MANY(m, many), __VA_ARGS__)
#define VEIL(label, m, ...) \
    FACT("veil." label, lib.veil.m, IF(lib.veil.white), __VA_ARGS__)
#define TIME(label, i)                                                        \
    AS(MS, gp_frame_report, "times_ms." label, cost.ms[i]),                          \
    AS(MS, gp_frame_report, "cpu_ms." label, cost.cpu_ms[i], IF(cost.has_cpu))

static const struct row relit_rows[] = {
    OF(glarepp_relit, "relit.name", name),
    OF(glarepp_relit, "relit.pixels", pixels),
    OF(glarepp_relit, "relit.rays", rays),
    OF(glarepp_relit, "relit.casters", casters),
    {0},
};

static const struct row group_rows[] = {
    OF(gp_light_group, "group_glare.name", name),
    OF(gp_light_group, "group_glare.kernel", kernel,
       BYTES(gp_light_group, kernel)),
    OF(gp_light_group, "group_glare.gain", gain),
    {0},
};

#define PLACED BYTES(glarepp_share, behind), .unless = true
static const struct row light_rows[] = {
    OF(glarepp_share, "lights.name", name[0], BYTES(glarepp_share, name[0])),
    OF(glarepp_share, "lights.behind", behind, BYTES(glarepp_share, behind)),
    OF(glarepp_share, "lights.x", x, PLACED, .step = 1e-4),
    OF(glarepp_share, "lights.y", y, PLACED, .step = 1e-4),
    OF(glarepp_share, "lights.radius", radius, PLACED, .step = 1e-4),
    OF(glarepp_share, "lights.flux", flux[0], BYTES(glarepp_share, flux),
       .size = sizeof(float), .n = 3),
    OF(glarepp_share, "lights.found", found, BYTES(glarepp_share, found)),
    OF(glarepp_share, "lights.visibility", visibility, .step = 1e-6),
    AS(INTERVAL, glarepp_share, "lights.interval", low),
    OF(glarepp_share, "lights.sun_degrees", sun_degrees,
       BYTES(glarepp_share, sun_from), .step = 1e-6),
    OF(glarepp_share, "lights.sun_from", sun_from,
       BYTES(glarepp_share, sun_from)),
    {0},
};

#define OCIO(m)                                                               \
    OF(glarepp_plan_facts, "ocio." #m, m, BYTES(glarepp_plan_facts, m))
static const struct row ocio_rows[] = {
    OCIO(config), OCIO(input), OCIO(display), OCIO(view), OCIO(look),
    OCIO(output), {0},
};

/* Fields of every line. Of two with one name the latter counts. */
static const struct row job_rows[] = {
    FACT("frame", job.of.frame, IF(job.of.numbered)),
    SOME("view", read.taken.view[0]),
    SOME("view", job.of.view),
    FACT("input", job.of.input),
    SOME("part", read.taken.part[0]),
    SOME("layer", read.taken.layer[0]),
    {0},
};

/* Those of a frame that was made. */
static const struct row made_rows[] = {
    LIST("outputs", TEXT, write.file, write.n),
    SOME("style", job.style),
    SOME("command", job.command),
    FACT("width", read.width),
    FACT("height", read.height),
    FACT("window", read.window.x0, INTS(4)),
    FACT("window_read", read.file.x0, IF(read.grown), INTS(4)),
    LIST("light_groups", TEXT, read.group, read.groups, IF(read.groups)),
    SOME("source", read.source),
    SOME("source_mask", read.mask),
    LIST("group_glare", OBJECT, read.group, read.groups, IF(read.grouped),
         .rows = group_rows),
    SOME("engine", lib.layer.engine),
    FACT("engine_why", lib.layer.why[0], IF(lib.layer.engine)),
    FACT("threshold", lib.sense.threshold),
    FACT("sources", lib.sense.sources),
    SOME("groups", lib.layer.groups),
    SOME("clusters", lib.layer.clusters),
    SOME("polygons", lib.layer.polygons),
    SOME("cores", lib.layer.cores),
    FACT("polygon_pixels", lib.layer.polygon_pixels, IF(lib.layer.polygons)),
    SOME("form", lib.layer.form),
    SOME("fft_size", lib.layer.fft_w, INTS(2)),
    SOME("fft_double", lib.layer.in_double),
    FACT("flux_in", lib.sense.flux, RGB),
    SOME("flux_faint", lib.sense.faint, RGB),
    SOME("kernel_faint", lib.kernel.faint, RGB),
    SOME("deg_per_pixel", lib.kernel.deg_per_pixel),
    FACT("fov_from", lib.kernel.fov_from, IF(lib.kernel.deg_per_pixel)),
    FACT("projection", lib.kernel.projection, IF(lib.kernel.deg_per_pixel)),
    AS(TEXT, gp_frame_report, "kernel.recipes", lib.kernel.recipe,
       MANY(lib.kernel.recipe, lib.kernel.recipes), IF(lib.kernel.recipes)),
    AS(PUPIL, gp_frame_report, "kernel.pupil_mm", lib.kernel.pupil,
       MANY(lib.kernel.pupil, lib.kernel.recipes), IF(lib.kernel.pupil)),
    SOME("kernel.width", lib.kernel.w),
    SOME("kernel.height", lib.kernel.h),
    SOME("kernel.grid", lib.kernel.grid),
    FACT("kernel.missed", lib.kernel.missed, IF(lib.kernel.modelled),
         .step = 1e-9),
    FACT("kernel_left_out", lib.kernel.left_out, IF(lib.kernel.modelled)),
    FACT("flux_out", lib.layer.flux, RGB),
    FACT("bound", bound, IF(bounded)),
    SOME("bound_angle", lib.layer.bound_angle),
    SOME("bound_pixel", lib.layer.bound_pixel),
    FACT("flare.elements", lib.flare.elements, IF(lib.flare.runs)),
    SOME("flare.gain", lib.flare.gain),
    SOME("flare.runs", lib.flare.runs),
    SOME("flare.engine", lib.flare.engine),
    FACT("flare.bound", lib.flare.bound, IF(lib.flare.runs)),
    FACT("flare.ms", lib.flare.ms, IF(lib.flare.runs), .step = 1e-3),
    FACT("measured.rel_l2", lib.errors.rel_l2, IF(lib.verified)),
    FACT("measured.max_rel", lib.errors.max_rel, IF(lib.verified)),
    FACT("measured.max_abs", lib.errors.max_abs, IF(lib.verified)),
    FACT("measured.flux_error", lib.errors.flux_error, IF(lib.verified)),
    FACT("measured.off", lib.errors.off, IF(lib.verified)),
    FACT("measured.pixels", lib.errors.pixels, IF(lib.verified)),
    FACT("nonfinite", lib.sense.nonfinite),
    FACT("clamped", lib.sense.clamped),
    FACT("flux_clamped", flux_clamped, IF(lib.sense.clamped), RGB),
    FACT("flux_clamped", flux_clamped, IF(clamped_out), RGB),
    SOME("clamped_out", clamped_out),
    SOME("lens.name", lib.lens.name),
    FACT("lens.sensor_mm", lib.lens.sensor, IF(lib.lens.name), .step = 1e-3),
    FACT("lens.sensor_from", lib.lens.sensor_from, IF(lib.lens.name)),
    FACT("lens.gain", lib.lens.gain, IF(lib.lens.name)),
    FACT("lens.lights", lib.lens.lights, IF(lib.lens.name)),
    FACT("lens.ghosts", lib.lens.drawn, IF(lib.lens.name)),
    FACT("lens.ghosts_left_out", lib.lens.left_out, IF(lib.lens.name)),
    FACT("lens.left_out", lib.lens.dark, IF(lib.lens.name)),
    FACT("lens.sources_left_out", lib.lens.rest, IF(lib.lens.name)),
    FACT("lens.flux", lib.lens.light, IF(lib.lens.name), RGB),
    FACT("lens.lost", lib.lens.lost, IF(lib.lens.name)),
    FACT("lens.bound", lib.lens.bound, IF(lib.lens.name)),
    SOME("scene.file", lib.scene.path),
    FACT("scene.seconds", lib.scene.seconds, IF(lib.scene.path), .step = 1e-6),
    SOME("scene.camera", lib.scene.camera),
    FACT("scene.camera_apart", lib.scene.apart, IF(lib.scene.compared),
         .step = 1e-6),
    LIST("relit", OBJECT, lib.relit, lib.relits, IF(lib.relits),
         .rows = relit_rows),
    SOME("veil.missing", lib.veil.missing),
    VEIL("white", white),
    VEIL("fixation", at[0], .size = sizeof(double), .n = 2),
    VEIL("age", age),
    VEIL("pigment", pigment),
    VEIL("seen", seen),
    VEIL("illuminance", illuminance),
    VEIL("luminance", luminance),
    VEIL("luminance_of_sources", luminance_of_sources),
    VEIL("fixated", fixated),
    VEIL("threshold_increment", threshold_increment),
    VEIL("sources", sources),
    VEIL("source_threshold", source_threshold),
    FACT("veil.ugr", lib.veil.ugr, IF(lib.veil.rated)),
    FACT("veil.dgp", lib.veil.dgp, IF(lib.veil.rated)),
    SOME("depth.channel", hidden.depth),
    SOME("depth.type", hidden.depth_type),
    SOME("depth.empty", lib.depth_empty[0]),
    SOME("depth.reversed", lib.depth_reversed),
    SOME("mask", hidden.mask),
    LIST("lights", OBJECT, lib.light, lib.lights, IF(lib.light),
         .rows = light_rows),
    SOME("sun_method", lib.shares_by),
    SOME("sun_edges", hidden.edges),
    AS(OBJECT, gp_frame_report, "ocio", ocio, IF(ocio), .pointed = true,
       .rows = ocio_rows),
    TIME("read", GP_TIME_READ),
    TIME("scene", GP_TIME_SCENE),
    TIME("relight", GP_TIME_RELIGHT),
    TIME("sun", GP_TIME_SUN),
    TIME("sensors", GP_TIME_SENSORS),
    TIME("kernel", GP_TIME_KERNEL),
    TIME("glare", GP_TIME_GLARE),
    TIME("lens", GP_TIME_LENS),
    TIME("compose", GP_TIME_COMPOSE),
    TIME("tonemap", GP_TIME_TONEMAP),
    TIME("write", GP_TIME_WRITE),
    TIME("total", GP_TIME_TOTAL),
    AS(MIB, gp_frame_report, "frame_mib", cost.bytes),
    {.name = "peak_rss_mib", .kind = PEAK},
    {.name = "threads", .kind = THREADS},
    SOME("gl", lib.shares_gl),
    SOME("gl", lib.layer.gl),
    SOME("settings", job.settings),
    {0},
};

/* The last of every line. */
static const struct row end_rows[] = {
    {.name = "warnings", .kind = WARNINGS},
    AS(INT, gp_frame_report, "status", job.status),
    {.name = "version", .kind = VERSION},
    {.name = "schema", .kind = SCHEMA},
    SOME("error", job.error),
    {0},
};

const char *gp_report_field(int i)
{
    static const struct row *const all[] = {
        job_rows,   made_rows, group_rows, relit_rows,
        light_rows, ocio_rows, end_rows,
    };
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        for (const struct row *r = all[k]; r->name; r++) {
            if (i-- == 0)
                return r->name;
        }
    }
    return NULL;
}

// -- one frame ---------------------------------------------------------------

// (No call is checked here: when memory is full, gp_json_print() returns NULL.)

static json_t *warnings_json(const struct gp_frame_report *f)
{
    const struct gp_job_report *const j = &f->job;
    json_t *const list = json_array();
    char line[GP_LINE_BYTES];
    if (j->views)
        json_array_append_new(list, gp_json_name(j->views));
    if (f->dark) {
        gp_frame_report_dark(f, 1, line, sizeof line);
        json_array_append_new(list, gp_json_name(line));
    }
    for (const char *m = j->said; m < j->said + j->said_bytes;
         m += strlen(m + 1) + 2) {
        if (*m == GP_LEVEL_WARN)
            json_array_append_new(list, gp_json_name(m + 1));
    }
    return list;
}

static void put_rows(json_t *line, const struct row *r, const void *from,
                     bool nested);

// NOLINTNEXTLINE(misc-no-recursion): an object in an object
static json_t *value_at(const struct row *r, const void *at)
{
    const double *const v = at;
    json_t *o;
    switch (r->kind) {
    case TEXT: return gp_json_name(*(const char *const *) at);
    case CHARS: return gp_json_name(at);
    case TRUE: return json_true();
    case INT: return json_integer(*(const int *) at);
    case LONG: return json_integer(*(const long long *) at);
    case COUNT: return json_integer((json_int_t) * (const size_t *) at);
    case FLOAT: return rounded((double) *(const float *) at, 0.0);
    case REAL: return rounded(*v, r->step);
    case MS: return rounded(*v, 1e-3);
    case MIB: return rounded((double) *(const size_t *) at / (1 << 20), 0.1);
    case PUPIL: return *v > 0.0 ? rounded(*v, 1e-4) : json_null();
    case INTERVAL:
        return json_pack("[f,f]", floor(v[0] * 1e6) * 1e-6,
                         ceil(v[1] * 1e6) * 1e-6);
    case OBJECT:
        o = json_object();
        put_rows(o, r->rows, at, true);
        return o;
    case SETTINGS: return settings_json(*(struct gp_settings *const *) at);
    case WARNINGS: return warnings_json(at);
    case PEAK: return rounded((double) gp_peak_memory() / (1 << 20), 0.1);
    case THREADS: return json_integer(gp_threads());
    case VERSION: return gp_json_name(GP_VERSION);
    case SCHEMA: return json_integer(2); // raised when the meaning of a field
                                         // changes or a field is removed
    }
    return NULL;
}

/* Adds the fields of rows to an object. `nested`: it is the one that their
 * names begin with. */
// NOLINTNEXTLINE(misc-no-recursion): an object in an object
static void put_rows(json_t *line, const struct row *r, const void *from,
                     bool nested)
{
    for (const char *const base = from; r->name; r++) {
        const char *const dot = strchr(r->name, '.');
        const char *const key = dot ? dot + 1 : r->name;
        const size_t length = dot ? (size_t) (dot - r->name) : 0;
        const char *at = base + r->at;
        json_t *o = line;
        bool set = false;
        for (size_t i = 0; i < r->if_bytes; i++)
            set |= base[r->if_at + i] != 0;
        if ((r->if_bytes && set == r->unless) ||
            (r->kind == MS && *(const double *) (const void *) at < 0.0))
            continue;
        if (r->pointed)
            at = *(const char *const *) (const void *) at;
        json_t *const v = r->size ? json_array() : value_at(r, at);
        const int n = !r->size ? 0 : r->n ? r->n
                      : *(const int *) (const void *) (base + r->count);
        for (int i = 0; i < n; i++)
            json_array_append_new(v, value_at(r, at + (size_t) i * r->size));
        if (dot && !nested && !(o = json_object_getn(line, r->name, length))) {
            o = json_object();
            if (json_object_setn_new(line, r->name, length, o))
                o = NULL; // memory is full, which gp_json_print() sees
        }
        json_object_set_new(o, key, v);
    }
}

// -- the file ----------------------------------------------------------------

gp_status gp_report_open(const struct gp_log *log, const char *path,
                         bool create_dir, struct gp_report *out)
{
    struct gp_report r = {.path = path, .fd = STDOUT_FILENO};
    const gp_status st =
        gp_file_descriptor(path) == STDOUT_FILENO
            ? GP_OK
            : gp_file_open_lines(log, path, create_dir, &r.fd, &r.created);
    if (!st)
        *out = r;
    return st;
}

static gp_status write_failed(const struct gp_log *log,
                              const struct gp_report *r)
{
    return gp_fail(log, GP_ERR_IO, "%s: cannot write the report (%s); check "
                   "the disk, or the program that reads the pipe", r->path,
                   strerror(errno));
}

/* Truncates a regular file that this run opened; leaves others as they are. */
static bool cut_file(const struct gp_report *r, off_t size)
{
    struct stat s;
    if (gp_file_descriptor(r->path) >= 0 || size < 0 || fstat(r->fd, &s) != 0 ||
        !S_ISREG(s.st_mode))
        return true;
    return ftruncate(r->fd, size) == 0;
}

gp_status gp_report_frame(const struct gp_log *log, struct gp_report *r,
                          const struct gp_frame_report *facts)
{
    json_t *const o = json_object();
    put_rows(o, job_rows, facts, false);
    if (!facts->job.status)
        put_rows(o, made_rows, facts, false);
    put_rows(o, end_rows, facts, false);
    char *const line = gp_json_print(o, JSON_COMPACT | JSON_REAL_PRECISION(10));
    if (!line)
        return gp_no_memory(log, r->path);
    const off_t before = lseek(r->fd, 0, SEEK_CUR);
    // old lines are removed with the first new one, so that a run that fails
    // before keeps them
    const bool fine =
        (r->lines > 0 || cut_file(r, 0)) && dprintf(r->fd, "%s\n", line) > 0;
    free(line);
    r->lines += fine;
    if (fine)
        return GP_OK;
    const gp_status st = write_failed(log, r);
    (void) cut_file(r, before); // leave no half line
    return st;
}

gp_status gp_report_close(const struct gp_log *log, struct gp_report *r)
{
    if (!r->path)
        return GP_OK;
    const bool fine = r->fd == STDOUT_FILENO || close(r->fd) == 0;
    const gp_status st = fine ? GP_OK : write_failed(log, r);
    if (r->lines == 0 && r->created)
        unlink(r->created);
    gp_free(r->created);
    *r = (struct gp_report) {0};
    return st;
}
