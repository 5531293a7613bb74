#include "app/report.h"

#include "app/options.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/model/model.h"
#include "io/file.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// -- facts ---------------------------------------------------------------------

/* Keys of times_ms. */
static const char *const time_names[GP_TIMES] = {
    [GP_TIME_READ] = "read",
    [GP_TIME_SCENE] = "scene", [GP_TIME_RELIGHT] = "relight",
    [GP_TIME_SUN] = "sun", [GP_TIME_SENSORS] = "sensors",
    [GP_TIME_KERNEL] = "kernel",
    [GP_TIME_GLARE] = "glare", [GP_TIME_LENS] = "lens",
    [GP_TIME_COMPOSE] = "compose", [GP_TIME_TONEMAP] = "tonemap",
    [GP_TIME_WRITE] = "write",
};

static const char *pixel_type_name(enum gp_pixel_type type)
{
    static const char *const names[] = {
        [GP_UINT] = "uint", [GP_HALF] = "half", [GP_FLOAT] = "float",
    };
    return names[type];
}

void gp_facts_dark(const struct gp_facts *f, int frames, char *line,
                   size_t size)
{
    char of[40] = "";
    const double t = (double) f->threshold;
    if (frames > 1)
        snprintf(of, sizeof of, " of %d frames", frames);
    if (f->peak > 0.0f)
        snprintf(line, size, "%s: no pixel%s is over the threshold %.3g "
                 "(brightest %.3g at %d,%d); lower --threshold", f->input, of,
                 t, (double) f->peak, f->peak_at[0], f->peak_at[1]);
    else
        snprintf(line, size, "%s: no pixel%s is over the threshold %.3g (all "
                 "are black); check the frame", f->input, of, t);
}

enum gp_edges gp_facts_edges(const struct gp_facts *f)
{
    bool seen = false;
    for (int i = 0; i < f->lights; i++)
        seen = seen || f->light[i].in_frame;
    return !seen ? GP_EDGES_NONE
           : f->mask ? f->depth ? GP_EDGES_COVERAGE : GP_EDGES_MASK
           : f->depth ? GP_EDGES_DEPTH
                      : GP_EDGES_NONE;
}

// -- the settings that made a picture -----------------------------------------

/* True when pixels of an output may depend on the option. */
static bool makes_pixels(const struct gp_option *o)
{
    return o->pixels ||
           (!o->aside && o->group != GP_GROUP_OUTPUT &&
            o->group != GP_GROUP_REPORT && o->group != GP_GROUP_GENERAL);
}

static const char *base_name(const char *path)
{
    const char *const slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* Prints the first n bytes of `head`, then `word`, quoted for a shell. */
static void print_word(FILE *f, const char *head, size_t n, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyz"
        "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
    const bool bare = n + strlen(word) > 0 && strspn(head, plain) >= n &&
                      !word[strspn(word, plain)];
    fputs(bare ? " " : " '", f);
    for (size_t i = 0; i < n || *word; i++) {
        const char c = i < n ? head[i] : *word++;
        if (c == '\'')
            fputs("'\\''", f);
        else
            fputc(c, f);
    }
    if (!bare)
        fputc('\'', f);
}

/* Prints an option's value without folders of this machine. */
static void print_value(FILE *f, const struct gp_option *o, const char *value)
{
    const bool config = strcmp(o->arg, "CONFIG") == 0;
    const char *const is = strchr(value, '=');
    const char *const file = strstr(value, "file="); // of a kernel's recipe
    if (config && (!*value || strcmp(value, "env") == 0) && getenv("OCIO"))
        value = getenv("OCIO");
    if (file && o->kind == GP_KIND_TEXTS && gp_recipe_is(value))
        print_word(f, value, (size_t) (file + 5 - value), base_name(file + 5));
    else if ((config || strstr(o->arg, "FILE")) && !strstr(value, "://"))
        print_word(f, "", 0, base_name(value));
    else if (is && is[1] == '/') // NAME=/some/folder/file
        print_word(f, value, (size_t) (is + 1 - value), base_name(value));
    else
        print_word(f, "", 0, value);
}

gp_status gp_command_text(const struct gp_log *log, const struct gp_settings *s,
    const char *const *input, int inputs, char **out)
{
    char *text = NULL;
    size_t size;
    FILE *const f = open_memstream(&text, &size);
    *out = NULL;
    if (!f)
        return gp_no_memory_bare(log, "command line");
    const char *const word = gp_command_of(s->command)->word;
    fprintf(f, "glarepp%s%s", *word ? " " : "", word);
    for (int i = 0; i + 1 < s->words.options.n; i += 2) {
        const char *const name = s->words.options.at[i];
        const char *const value = s->words.options.at[i + 1];
        const struct gp_option *const o = gp_option_find(name, strlen(name));
        if (!makes_pixels(o))
            continue;
        fprintf(f, " --%s", name);
        if (value)
            print_value(f, o, value);
    }
    for (int i = 0; i < inputs; i++)
        print_word(f, "", 0, base_name(input[i]));
    const bool full = ferror(f);
    // (glibc's fclose() succeeds even when the last block cannot be allocated)
    const bool whole = fclose(f) == 0 && !full && text;
    if (whole) // control characters would break listings of the file
        gp_make_printable(text);
    json_t *const clean = whole ? gp_json_name(text) : NULL;
    free(text);
    *out = clean ? strdup(json_string_value(clean)) : NULL;
    json_decref(clean);
    return *out ? GP_OK : gp_no_memory_bare(log, "command line");
}

/* Returns the value of an option as JSON; NULL when it is unset. */
static json_t *value_of(const struct gp_settings *s, const struct gp_option *o)
{
    const void *const at = (const char *) s + o->at;
    const struct gp_numbers *const list = at;
    const struct gp_texts *const texts = at;
    const double *const pair = at;
    const char *const *const word = at;
    json_t *v = NULL;
    char text[32];
    switch (o->kind) {
    case GP_KIND_FLAG:
        return json_boolean(*(const bool *) at);
    case GP_KIND_FLOAT: // 0.001 as written, not its nearest float
        snprintf(text, sizeof text, "%.7g", (double) *(const float *) at);
        return json_real(strtod(text, NULL)); // NULL when it is not finite
    case GP_KIND_THRESHOLD: // "99.9%" and "+3ev" too
        snprintf(text, sizeof text, s->light.sensor.unit == GP_THRESHOLD_EV
                     ? "%+.7gev" : s->light.sensor.unit == GP_THRESHOLD_PERCENT
                     ? "%.7g%%" : "%.7g", (double) s->light.sensor.threshold);
        return s->light.sensor.unit == GP_THRESHOLD_LUMINANCE
                   ? json_real(strtod(text, NULL)) : json_string(text);
    case GP_KIND_INT:
        return json_integer(*(const int *) at);
    case GP_KIND_COUNT:
        return json_integer(*(const long long *) at);
    case GP_KIND_PAIR:
        return gp_option_given(s, o->name)
                   ? json_pack("[ff]", pair[0], pair[1]) : NULL;
    case GP_KIND_NUMBERS:
        v = list->n ? json_array() : NULL;
        for (int i = 0; i < list->n; i++)
            json_array_append_new(v, json_real(list->v[i]));
        return v;
    case GP_KIND_CHOICE:
        for (const struct gp_option_choice *c = o->choices; c->name; c++) {
            if (c->value == *(const int *) at)
                return c->text || strspn(c->name, "0123456789") == 0
                           ? json_string(c->name) : json_integer(c->value);
        }
        return NULL;
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
        if (!(o->commands & s->command) || !makes_pixels(o) ||
            (o->needs & unmet) ||
            (o->group == GP_GROUP_SUN && !gp_option_given(s, o->name) &&
             !gp_suns_wanted(&s->sun) && !s->scene.path))
            continue;
        snprintf(key, sizeof key, "%s", o->name);
        for (char *c = key; *c; c++)
            *c = *c == '-' ? '_' : *c;
        json_t *const v = value_of(s, o);
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

/* Raised when the meaning of a field changes or a field is removed. */
enum { SCHEMA = 2 };

// -- one frame ---------------------------------------------------------------

// (No call is checked here: when memory is full, gp_json_print() returns NULL.)

/* Adds a count unless it is 0. */
static void put_count(json_t *o, const char *key, size_t n)
{
    if (n)
        json_object_set_new(o, key, json_integer((json_int_t) n));
}

static void put_number(json_t *o, const char *key, double v, double step)
{
    json_object_set_new(o, key, rounded(v, step));
}

static void put_name(json_t *o, const char *key, const char *name)
{
    json_object_set_new(o, key, gp_json_name(name));
}

static json_t *name_or_none(const char *name)
{
    return name ? gp_json_name(name) : NULL;
}

static void put_list(json_t *o, const char *key, const char *const *name, int n)
{
    json_t *const list = json_array();
    for (int i = 0; i < n; i++)
        json_array_append_new(list, gp_json_name(name[i]));
    json_object_set_new(o, key, list);
}

static void put_rgb(json_t *o, const char *key, const double v[3])
{
    json_t *const list = json_array();
    for (int c = 0; c < 3; c++)
        json_array_append_new(list, rounded(v[c], 0.0));
    json_object_set_new(o, key, list);
}

static void put_frame(json_t *o, const struct gp_facts *f)
{
    if (f->numbered)
        json_object_set_new(o, "frame", json_integer(f->frame));
    if (f->view || f->taken.view[0])
        put_name(o, "view", f->view ? f->view : f->taken.view);
    put_name(o, "input", f->input);
    if (f->taken.part[0])
        put_name(o, "part", f->taken.part);
    if (f->taken.layer[0])
        put_name(o, "layer", f->taken.layer);
}

/* Adds the fields that end every line. */
static void put_end(json_t *o, const struct gp_facts *f, gp_status status)
{
    json_t *const list = json_array();
    char line[GP_LINE_BYTES];
    if (f->views)
        json_array_append_new(list, gp_json_name(f->views));
    if (f->dark) {
        gp_facts_dark(f, 1, line, sizeof line);
        json_array_append_new(list, gp_json_name(line));
    }
    for (size_t at = 0; at < f->warned_bytes; at += strlen(f->warned + at) + 1)
        json_array_append_new(list, gp_json_name(f->warned + at));
    json_object_set_new(o, "warnings", list);
    json_object_set_new(o, "status", json_integer(status));
    json_object_set_new(o, "version", gp_json_name(GP_VERSION));
    json_object_set_new(o, "schema", json_integer(SCHEMA));
}

/* Adds what the kernel is and what it leaves out. */
static void put_kernel(json_t *o, const struct gp_kernel_facts *k)
{
    if (!k->w)
        return;
    json_t *const list = k->recipes ? json_array() : NULL;
    json_t *const pupils = json_array();
    bool eyes = false;
    for (int i = 0; i < k->recipes; i++) {
        char *const recipe = gp_recipe_text(&k->recipe[i]);
        json_array_append_new(list, gp_json_name(recipe));
        gp_free(recipe);
        eyes |= k->pupil[i] > 0.0;
        json_array_append_new(pupils, k->pupil[i] > 0.0
                                          ? rounded(k->pupil[i], 1e-4)
                                          : json_null());
    }
    json_object_set_new(o, "kernel", json_pack("{so* so* si si so* so*}",
        "recipes", list, "pupil_mm", eyes ? json_incref(pupils) : NULL,
        "width", k->w, "height", k->h,
        "grid", k->grid ? json_integer(k->grid) : NULL,
        "missed", k->modelled ? rounded(k->missed, 1e-9) : NULL));
    json_decref(pupils);
    if (k->modelled)
        put_number(o, "kernel_left_out", k->left_out, 0.0);
}

/* Adds the engine, its work and its result. */
static void put_glare(json_t *o, const struct gp_facts *f)
{
    const struct gp_glare_stats *g = &f->glare;
    if (g->engine) {
        put_name(o, "engine", g->engine);
        put_name(o, "engine_why", g->why);
    }
    put_number(o, "threshold", (double) f->threshold, 0.0);
    json_object_set_new(o, "sources", json_integer(f->sources));
    put_count(o, "groups", g->groups);
    put_count(o, "clusters", g->clusters);
    put_count(o, "polygons", g->polygons);
    put_count(o, "cores", g->cores);
    if (g->polygons)
        put_number(o, "polygon_pixels", g->polygon_pixels, 0.0);
    if (g->form)
        put_name(o, "form", g->form);
    if (g->fft_w)
        json_object_set_new(o, "fft_size",
                            json_pack("[ii]", g->fft_w, g->fft_h));
    if (g->fft_double)
        json_object_set_new(o, "fft_double", json_true());
    put_rgb(o, "flux_in", f->flux_in);
    if (f->flux_faint[0] + f->flux_faint[1] + f->flux_faint[2] > 0.0)
        put_rgb(o, "flux_faint", f->flux_faint);
    if (f->kernel_faint[0] + f->kernel_faint[1] + f->kernel_faint[2] > 0.0)
        put_rgb(o, "kernel_faint", f->kernel_faint);
    if (f->deg_per_pixel > 0.0) {
        put_number(o, "deg_per_pixel", f->deg_per_pixel, 0.0);
        put_name(o, "fov_from", f->fov_from);
    }
    put_kernel(o, &f->kernel);
    if (f->has_flux_out)
        put_rgb(o, "flux_out", f->flux_out);
    // of the layer with ghosts too, which is no darker than without them
    if ((g->engine && f->sources) || f->lens.name)
        put_number(o, "bound", (g->engine && f->sources ? g->bound : 0.0) +
                                   f->lens.bound, 0.0);
    if (g->engine && f->sources && g->bound_pixel > 0.0)
        put_number(o, "bound_pixel", g->bound_pixel, 0.0);
    if (f->flare.runs)
        json_object_set_new(o, "flare", json_pack("{si si ss so so}",
            "elements", f->flare.elements, "runs", f->flare.runs,
            "engine", f->flare.engine, "bound", rounded(f->flare.bound, 0.0),
            "ms", rounded(f->flare.ms, 1e-3)));
    if (f->verified)
        json_object_set_new(o, "measured", json_pack("{so so so so}",
            "rel_l2", rounded(f->error.rel_l2, 0.0),
            "max_rel", rounded(f->error.max_rel, 0.0),
            "max_abs", rounded(f->error.max_abs, 0.0),
            "flux_error", rounded(f->error.flux_error, 0.0)));
    json_object_set_new(o, "nonfinite", json_integer(f->nonfinite));
    json_object_set_new(o, "clamped", json_integer(f->clamped));
    if (f->clamped || f->clamped_out)
        put_rgb(o, "flux_clamped", f->flux_clamped);
    if (f->clamped_out)
        json_object_set_new(o, "clamped_out", json_integer(f->clamped_out));
}

/* Adds the scene, its time, and how far apart two cameras are. */
static void put_scene(json_t *o, const struct gp_scene_facts *f)
{
    if (f->path)
        json_object_set_new(o, "scene", json_pack("{so so so* so*}",
            "file", gp_json_name(f->path),
            "seconds", rounded(f->seconds, 1e-6),
            "camera", name_or_none(f->camera),
            "camera_apart", f->compared ? rounded(f->apart, 1e-6) : NULL));
}

/* Adds the lights of --relight. */
static void put_relit(json_t *o, const struct gp_facts *f)
{
    if (!f->relits)
        return;
    json_t *const list = json_array();
    for (int i = 0; i < f->relits; i++) {
        const struct gp_relit_facts *const l = &f->relit[i];
        json_array_append_new(list, json_pack("{so sI sI si}",
            "name", gp_json_name(l->name), "pixels", (json_int_t) l->pixels,
            "rays", (json_int_t) l->rays, "casters", l->casters));
    }
    json_object_set_new(o, "relit", list);
}

/* Adds the depth channel, its values that are no surface, and the lights. */
static void put_lights(json_t *o, const struct gp_facts *f)
{
    const bool filled = f->depth_empty[0] != '\0';
    if (f->depth)
        json_object_set_new(o, "depth", json_pack("{so ss so*}",
            "channel", gp_json_name(f->depth), filled ? "empty" : "type",
            filled ? f->depth_empty : pixel_type_name(f->depth_type),
            "reversed", f->depth_reversed ? json_true() : NULL));
    if (f->mask)
        put_name(o, "mask", f->mask);
    if (!f->light)
        return;
    json_t *const list = json_array();
    for (int i = 0; i < f->lights; i++) {
        const struct gp_light *const l = &f->light[i];
        json_array_append_new(list, json_pack(
            "{so* so* so* so* so* so so}",
            "name", l->name[0] ? gp_json_name(l->name) : NULL,
            "behind", l->behind ? json_true() : NULL,
            "x", l->behind ? NULL : rounded(l->x, 1e-4),
            "y", l->behind ? NULL : rounded(l->y, 1e-4),
            "radius", l->behind ? NULL : rounded(l->radius, 1e-4),
            "visibility", rounded(l->visibility, 1e-6),
            "interval", json_pack("[f,f]", floor(l->low * 1e6) * 1e-6,
                                  ceil(l->high * 1e6) * 1e-6)));
    }
    json_object_set_new(o, "lights", list);
    if (f->sun_way)
        put_name(o, "sun_method", f->sun_way);
    static const char *const edges[] = {
        [GP_EDGES_DEPTH] = "depth alone: within 0.06 of the truth for a sun of "
                           "2.5 pixels; coverage (--mask) is nearer",
        [GP_EDGES_COVERAGE] = "coverage: within 0.02 of the truth for a sun of "
                              "2.5 pixels",
        [GP_EDGES_MASK] = "coverage without depth: surfaces beyond a light "
                          "hide it too, and the error is not known; add depth "
                          "(--depth)",
    };
    const enum gp_edges by = gp_facts_edges(f);
    if (by)
        put_name(o, "sun_edges", edges[by]);
}

// -- the file ----------------------------------------------------------------

/* Removes the file that this run made, if any. */
static void remove_created(struct gp_report *r)
{
    if (r->created)
        unlink(r->created);
}

gp_status gp_report_open(const struct gp_log *log, const char *path,
                         bool create_dir, bool append, struct gp_report *out)
{
    struct gp_report r = {.path = path, .append = append};
    const int given = gp_file_descriptor(path);
    r.given = given >= 0;
    if (given == STDOUT_FILENO) {
        r.file = stdout;
    } else {
        int fd;
        // (append: a line is written whole, after those of other tasks of a
        // farm)
        gp_status st = gp_file_open_lines(log, path, create_dir, append, &fd,
                                          &r.created);
        if (st)
            return st;
        r.file = fdopen(fd, append ? "a" : "w");
        if (!r.file) {
            close(fd);
            remove_created(&r);
            gp_free(r.created);
            return gp_no_memory(log, path);
        }
    }
    if (append && r.file != stdout) {
        (void) setvbuf(r.file, NULL, _IOFBF, 1 << 16);
        (void) fseek(r.file, 0, SEEK_END); // (a pipe has no end)
    }
    *out = r;
    return GP_OK;
}

static gp_status write_failed(const struct gp_log *log,
                              const struct gp_report *r)
{
    return gp_fail(log, GP_ERR_IO, "%s: cannot write the report (%s); check "
                   "the disk, or the program that reads the pipe", r->path,
                   strerror(errno));
}

/* Truncates a regular file to `size`; leaves other kinds as they are. */
static bool cut_file(const struct gp_report *r, long size)
{
    struct stat s;
    const int fd = fileno(r->file);
    if (r->given || size < 0 || fstat(fd, &s) != 0 ||
        !S_ISREG(s.st_mode))
        return true;
    return ftruncate(fd, size) == 0;
}

/* Ends a last line without a line feed: adds it to a whole object, and removes
 * the part of one that a killed run left. */
static bool end_last_line(const struct gp_report *r)
{
    struct stat s;
    const int fd = fileno(r->file);
    char last = '\n';
    if (r->given || fstat(fd, &s) != 0 || !S_ISREG(s.st_mode))
        return true;
    off_t end = s.st_size;
    while (end > 0 && pread(fd, &last, 1, end - 1) == 1 && last != '\n')
        end--;
    if (end == s.st_size)
        return true;
    const size_t bytes = (size_t) (s.st_size - end);
    char *const line = malloc(bytes);
    if (!line)
        return false;
    json_t *const whole = pread(fd, line, bytes, end) == (ssize_t) bytes
                              ? json_loadb(line, bytes, 0, NULL) : NULL;
    const bool fine = json_is_object(whole) ? write(fd, "\n", 1) == 1
                                            : ftruncate(fd, end) == 0;
    json_decref(whole);
    free(line);
    return fine;
}

/* Writes the line of an object, whose reference it takes. */
static gp_status write_object(const struct gp_log *log, struct gp_report *r,
                              json_t *o)
{
    char *line = gp_json_print(o, JSON_COMPACT | JSON_REAL_PRECISION(10));
    if (!line)
        return gp_no_memory(log, r->path);
    const bool first = r->lines == 0;
    bool fine = !first || !r->append || end_last_line(r);
    if (fine && first && r->append)
        (void) fseek(r->file, 0, SEEK_END);
    const long before = ftell(r->file);
    // old lines are removed with the first new one, so that a run that fails
    // before keeps them
    fine = fine && (!first || r->append || cut_file(r, 0)) &&
                fprintf(r->file, "%s\n", line) > 0 && fflush(r->file) == 0;
    free(line);
    if (!fine) {
        const gp_status st = write_failed(log, r);
        if (r->file != stdout)
            __fpurge(r->file); // or closing it would try again
        (void) cut_file(r, before); // leave no half line
        return st;
    }
    r->lines++;
    return GP_OK;
}

/* Adds a window by its edges: left, top, right, bottom. */
static void put_window(json_t *o, const char *name, struct gp_rect r)
{
    json_object_set_new(o, name, json_pack("[iiii]", r.x0, r.y0, r.x1, r.y1));
}

gp_status gp_report_failed(const struct gp_log *log, struct gp_report *r,
                           const struct gp_facts *facts, gp_status status,
                           const char *error)
{
    json_t *const o = json_object();
    put_frame(o, facts);
    put_end(o, facts, status);
    put_name(o, "error", error);
    return write_object(log, r, o);
}

/* Adds the style, and the command that makes the picture again. */
static gp_status put_style(const struct gp_log *log, const struct gp_facts *f,
                           json_t *o)
{
    char *command;
    gp_status st = gp_command_text(log, f->settings, &f->input, 1, &command);
    put_name(o, "style", f->settings->light.style);
    put_name(o, "command", command);
    free(command);
    return st;
}

gp_status gp_report_frame(const struct gp_log *log, struct gp_report *r,
                          const struct gp_facts *facts)
{
    const struct gp_ocio_names *const n = facts->ocio;
    json_t *const o = json_object();
    put_frame(o, facts);
    put_list(o, "outputs", (const char *const *) facts->outputs,
             facts->n_outputs);
    const gp_status st = facts->settings ? put_style(log, facts, o) : GP_OK;
    if (st) {
        json_decref(o);
        return st;
    }
    json_object_set_new(o, "width", json_integer(facts->width));
    json_object_set_new(o, "height", json_integer(facts->height));
    put_window(o, "window", facts->window);
    if (memcmp(&facts->read, &facts->window, sizeof facts->read) != 0)
        put_window(o, "window_read", facts->read);
    if (facts->light_groups)
        put_list(o, "light_groups", facts->light_group, facts->light_groups);
    put_glare(o, facts);
    if (facts->lens.name)
        json_object_set_new(o, "lens", gp_lens_facts_json(&facts->lens));
    put_scene(o, &facts->scene);
    put_relit(o, facts);
    put_lights(o, facts);
    if (n)
        json_object_set_new(o, "ocio", json_pack("{so* so* so* so* so* so*}",
            "config", name_or_none(n->config), "input", name_or_none(n->input),
            "display", name_or_none(n->display), "view", name_or_none(n->view),
            "look", name_or_none(n->look), "output", name_or_none(n->output)));
    json_t *const times = json_object(), *const cpu = json_object();
    for (int i = 0; i < GP_TIMES; i++) {
        if (facts->ms[i] >= 0.0) {
            put_number(times, time_names[i], facts->ms[i], 1e-3);
            put_number(cpu, time_names[i], facts->cpu_ms[i], 1e-3);
        }
    }
    put_number(times, "total", facts->total_ms, 1e-3);
    json_object_set_new(o, "times_ms", times);
    if (facts->has_cpu)
        json_object_set(o, "cpu_ms", cpu);
    json_decref(cpu);
    put_number(o, "frame_mib", (double) facts->bytes / (1 << 20), 0.1);
    put_number(o, "peak_rss_mib", (double) gp_peak_memory() / (1 << 20), 0.1);
    json_object_set_new(o, "threads", json_integer(gp_threads()));
    if (facts->glare.gl || facts->sun_gl)
        put_name(o, "gl", facts->glare.gl ? facts->glare.gl : facts->sun_gl);
    if (facts->settings && !r->settings)
        r->settings = settings_json(facts->settings);
    if (facts->settings)
        json_object_set(o, "settings", r->settings);
    put_end(o, facts, GP_OK);
    return write_object(log, r, o);
}

gp_status gp_report_close(const struct gp_log *log, struct gp_report *r)
{
    if (!r->file)
        return GP_OK;
    bool fine = r->file == stdout ? fflush(stdout) == 0 : fclose(r->file) == 0;
    gp_status st = fine ? GP_OK : write_failed(log, r);
    if (r->lines == 0)
        remove_created(r);
    gp_free(r->created);
    json_decref(r->settings);
    *r = (struct gp_report) {0};
    return st;
}
