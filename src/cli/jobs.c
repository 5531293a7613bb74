// SPDX-License-Identifier: Apache-2.0
#include "cli/jobs.h"

#include "core/memory.h"
#include "io/file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* True for --views all, and without --views. */
static bool views_all(const struct gp_settings *s)
{
    return !s->input.views || strcmp(s->input.views, "all") == 0;
}

/* Makes room for `frames` frames of that many jobs; `path` for messages. */
static gp_status make_room(const struct gp_log *log, struct gp_jobs *j,
                           int frames, int jobs, const char *path)
{
    void *block = j->job;
    if (frames > GP_FRAME_LIST_MAX / jobs)
        return gp_fail(log, GP_ERR_USAGE, "%s: too many frames (over %d); make "
                       "them in several runs", path, GP_FRAME_LIST_MAX);
    const gp_status st = gp_resize(log, "frame list", (size_t) frames *
                                   (size_t) jobs * sizeof *j->job, &block);
    j->job = block;
    return st;
}

// -- frames ------------------------------------------------------------------

/* Appends all views of one frame. */
static gp_status add_frame(const struct gp_log *log, struct gp_jobs *j,
                           const struct gp_pattern *p, bool numbered, int frame)
{
    const int views = gp_jobs_of_frame(j);
    const gp_status st = make_room(log, j, j->n / views + 1, views, p->path);
    for (int i = 0; i < views && !st; i++) {
        const char *const view = j->view.n ? j->view.name[i] : NULL;
        char *const input = i && j->views > 1 ? j->job[j->n - 1].input
                                              : gp_pattern_name(p, frame, view);
        if (!input)
            return gp_no_memory_bare(log, "frame list");
        j->job[j->n++] = (struct gp_job) {
            input, numbered, frame, view, false};
    }
    return st;
}

/* Lists frames of a pattern by --frames, else on disk; those of any view. */
static gp_status list_frames(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_pattern *p,
    const struct gp_views *view, struct gp_frames *all)
{
    if (s->input.frames)
        return gp_frames_parse(log, s->input.frames, all);
    if (!p->views)
        return gp_frames_on_disk(log, p, NULL, all);
    for (int i = 0; i < view->n; i++) {
        struct gp_frames more = {0};
        gp_status st = gp_frames_on_disk(NULL, p, view->name[i], &more);
        if (!st && !gp_frames_join(all, &more))
            st = gp_no_memory_bare(log, "frame list");
        gp_frames_free(&more);
        if (st && st != GP_ERR_IO)
            return st;
    }
    // reading the first view's again reports why there is none
    return all->n ? GP_OK : gp_frames_on_disk(log, p, view->name[0], all);
}

/* Makes the jobs of all inputs. Sets *patterns when an input is a pattern; a
 * file that has the pattern's own name is a plain input. */
static gp_status add_inputs(const struct gp_log *log,
    const struct gp_settings *s, struct gp_jobs *j, bool *patterns)
{
    gp_status st;
    struct gp_pattern *in;
    struct gp_frames f = {0};
    bool place = false; // some output is a pattern
    for (int i = 0; i < j->targets; i++)
        place = place || j->target[i].name.len;
    GP_TRY(gp_alloc_zero(log, "input list", (size_t) s->input.files.n,
                         sizeof *in, &in));
    for (int i = 0; i < s->input.files.n; i++) {
        const char *const path = s->input.files.at[i];
        in[i] = (struct gp_pattern) {.path = path};
        if (!gp_is_dash(path))
            st = gp_pattern_of_input(log, path, &in[i]);
        else if (s->input.files.n > 1)
            st = gp_fail(log, GP_ERR_USAGE, "-: stdin must be the only input "
                         "(found %d); give only -", s->input.files.n);
        else if (isatty(STDIN_FILENO))
            st = gp_fail(log, GP_ERR_USAGE,
                         "-: stdin is a terminal; pipe an EXR file in");
        char file[PATH_MAX];
        for (int k = 0; gp_is_dash(path) && !st && gp_kernel_file(s, k, file);
             k++) {
            if (gp_is_dash(file))
                st = gp_fail(log, GP_ERR_USAGE, "-: frame and kernel cannot "
                             "both come from stdin; give one of them as a "
                             "file");
        }
        GP_TRY(st);
        *patterns = *patterns || in[i].len;
    }
    // settle which views there are, and whether they are files or parts
    const bool in_names = in[0].views > 0;
    for (int i = 1; i < s->input.files.n; i++) {
        if ((in[i].views > 0) != in_names)
            GP_TRY(gp_fail(log, GP_ERR_USAGE, "%s: no %%V or %%v (found in "
                "%s); make them in separate runs", in[in_names ? i : 0].path,
                in[in_names ? 0 : i].path));
    }
    if (in_names && s->input.views && views_all(s))
        GP_TRY(gp_fail(log, GP_ERR_USAGE, "--views: all means the views inside "
            "a file (found %%V or %%v in %s); list them, e.g. --views "
            "left,right", in[0].path));
    if (in_names || !views_all(s))
        GP_TRY(gp_views_parse(
            log, s->input.views ? s->input.views : "left,right", &j->view));
    for (int i = 0; i < s->input.files.n; i++)
        GP_TRY(gp_views_check(log, &in[i], &j->view));
    j->views = in_names ? 1 : gp_jobs_of_frame(j);
    j->views_inside = !in_names && j->view.n > 0;
    // list the frames of each
    for (const struct gp_pattern *p = in; p < in + s->input.files.n; p++) {
        int frame = 0;
        if (gp_is_dash(p->path)) { // one frame until stdin is read
            if (s->input.frames)
                GP_TRY(gp_frames_parse(log, s->input.frames, &f));
            GP_TRY(add_frame(log, j, p, place || s->input.frames,
                             f.n ? f.number[0] : 1));
        } else if (p->len) {
            GP_TRY(list_frames(log, s, p, &j->view, &f));
            for (int i = 0; i < f.n; i++)
                GP_TRY(add_frame(log, j, p, true, f.number[i]));
        } else if (s->input.frames) {
            GP_TRY(gp_fail(log, GP_ERR_USAGE, "%s: --frames needs a pattern "
                           "(found a plain name); write shot.####.exr, or "
                           "leave --frames out", p->path));
        } else {
            const bool numbered = place && gp_frame_number(p->path, &frame);
            GP_TRY(add_frame(log, j, p, numbered, frame));
        }
        gp_frames_free(&f);
    }
out:
    gp_frames_free(&f);
    gp_free(in);
    return st;
}

/* Reads stdin into j->members and makes the jobs of each image in it, which
 * replace the placeholder; numbered by --frames, or 1, 2, 3. */
static gp_status read_stdin(const struct gp_log *log,
                            const struct gp_settings *s, struct gp_jobs *j)
{
    gp_status st = gp_members_read(log, &s->input.read, "-", &j->members);
    if (st)
        return st;
    const int frames = j->members.n;
    const int n = frames * j->views;
    struct gp_frames f = {0};
    st = make_room(log, j, frames, j->views, "-");
    for (; j->n < n && !st; j->n++) // all have the first one's views
        j->job[j->n] = (struct gp_job) {.view = j->job[j->n % j->views].view};
    if (!st && s->input.frames)
        st = gp_frames_parse(log, s->input.frames, &f);
    if (!st && s->input.frames && f.n != frames)
        st = gp_fail(log, GP_ERR_USAGE, "-: stdin has %d frame%s, --frames %s "
                     "lists %d; list one number for each", frames,
                     frames == 1 ? "" : "s", s->input.frames, f.n);
    for (int i = 0; i < n && !st; i++) {
        struct gp_job *const job = &j->job[i];
        char name[32];
        job->frame =
            s->input.frames ? f.number[i / j->views] : i / j->views + 1;
        if (frames == 1)
            continue;
        snprintf(name, sizeof name, "- (frame %d)", job->frame);
        if (i % j->views == 0)
            free(job->input);
        job->numbered = true;
        job->input = i % j->views ? job[-1].input : gp_strdup(name);
        if (!job->input)
            st = gp_no_memory_bare(log, "frame list");
    }
    gp_frames_free(&f);
    return st;
}

// -- views that the command line does not name -------------------------------

/* Finds the views of the first input that is a regular file: a pipe can be read
 * only once. `log` is NULL where reading the frame will report the error. */
static gp_status find_views(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_jobs *j,
    struct gp_views *found, const char **input)
{
    gp_status st = GP_OK;
    *input = j->job[0].input;
    if (j->members.n)
        return gp_read_views(log, &s->input.read, "-", &j->members, found);
    for (int i = 0; i < j->n; i++) {
        struct stat info;
        *input = j->job[i].input;
        if (stat(*input, &info) != 0 || !S_ISREG(info.st_mode))
            continue;
        st = gp_read_views(log, &s->input.read, *input, &j->members, found);
        if (!st || st == GP_ERR_BUG)
            return st;
    }
    return st;
}

/* Finds the views inside the first input, if an output has a place for several,
 * makes a job of each, and warns in one line of the choice. */
static gp_status add_views(const struct gp_log *log,
    const struct gp_settings *s, struct gp_jobs *j)
{
    struct gp_views found = {0};
    char list[512] = "", line[GP_LINE_BYTES];
    const char *input, *hero = NULL; // an output of the first view only
    bool places = false;             // an output by view
    j->views_found = j->targets == 0;  // the report has a line for each
    for (int i = 0; i < j->targets; i++) {
        const struct gp_output *const t = &j->target[i];
        places = places || t->name.views;
        if (!hero && t->kind != GP_TARGET_HDR && !t->name.views)
            hero = t->name.path;
        j->views_found = j->views_found || t->kind == GP_TARGET_HDR ||
                         t->name.views;
    }
    gp_status st = find_views(NULL, s, j, &found, &input);
    // names with %V cannot be made without views: report why there are none
    if (st == GP_ERR_IO && places && j->n == 1)
        GP_TRY(find_views(log, s, j, &found, &input));
    if (st == GP_ERR_BUG)
        return gp_no_memory(log, input);
    if (st || found.n == 0)
        return GP_OK;
    for (int i = 0; i < found.n; i++) {
        const char *const name = found.name[i];
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", name);
        if (places && (strchr(name, '/') || strcmp(name, ".") == 0 ||
                       strcmp(name, "..") == 0))
            st = gp_fail(log, GP_ERR_DATA, "%s: has a view whose name cannot "
                         "be part of a file name (found %s); choose others "
                         "with --views", input, name);
    }
    if (!st && !j->views_found)
        snprintf(line, sizeof line, "%s: makes only view %s of %s; write a "
                 "name with %%V to make all, or choose with --views", input,
                 found.name[0], list);
    else if (hero)
        snprintf(line, sizeof line, "%s: makes its views %s, but of %s only "
                 "%s; write a name with %%V to make all, or choose with "
                 "--views", input, list, hero, found.name[0]);
    else
        snprintf(line, sizeof line, "%s: makes its views %s; choose with "
                 "--views", input, list);
    if (!st) {
        gp_say(log, GP_LEVEL_WARN, "%s", line);
        free(j->views_line);
        j->views_line = gp_strdup(line);
        st = j->views_line ? GP_OK : gp_no_memory(log, input);
    }
    if (st || !j->views_found)
        goto out;
    // each job becomes one for each view
    j->views = found.n;
    j->views_inside = true;
    GP_TRY(make_room(log, j, j->n, j->views, j->job[0].input));
    j->n *= j->views;
    for (int i = j->n - 1; i >= 0; i--) {
        j->job[i] = j->job[i / j->views];
        j->job[i].view = found.name[i % j->views];
    }
    j->view = found;
    return GP_OK;
out:
    gp_views_free(&found);
    return st;
}

gp_status gp_jobs_check_views(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_jobs *j,
    const struct gp_frame *f)
{
    struct gp_views own;
    gp_status st = gp_frame_views(log, p, f, &own);
    for (int i = 0; i < own.n && !st; i++) {
        int k = 0;
        while (k < j->view.n && strcmp(j->view.name[k], own.name[i]) != 0)
            k++;
        if (k == j->view.n)
            st = gp_fail(log, GP_ERR_USAGE, "%s: has view %s (the first input "
                "has %s); choose with --views, or make it in a run of its own",
                f->path, own.name[i], j->view.n ? "others" : "none");
    }
    gp_views_free(&own);
    return st;
}

// -- outputs -----------------------------------------------------------------

const struct gp_target_row gp_targets[] = {
    [GP_TARGET_HDR] = {"--hdr", "linear light", GLAREPP_OUTPUT},
    [GP_TARGET_LAYER] = {"--layer", "the glare alone, linear light",
                         GLAREPP_GLARE},
    [GP_TARGET_PARTS] = {"--parts", "the parts of the glare, linear light",
                         GLAREPP_PART_VEIL},
    [GP_TARGET_PICTURE] = {"--output", "", GLAREPP_SHOWN},
    [GP_TARGET_SENSORS] = {"--debug sensors", "the light that glares",
                           GLAREPP_SOURCES},
    [GP_TARGET_POLYGONS] = {"--debug polygons", "outlines of polygons",
                            GLAREPP_POLYGONS},
    [GP_TARGET_SUNMAP] = {"--debug sunmap", "sun maps", GLAREPP_SUNMAP},
    [GP_TARGET_INTENSITY] = {"--debug intensity", "intensity map",
                             GLAREPP_INTENSITY},
    [GP_TARGET_SCISSOR] = {"--debug scissor", "", GLAREPP_SHOWN},
    [GP_TARGET_SETS] = {"--debug sets", "", GLAREPP_SOURCES},
};

const char *const gp_part_names[] = {"veil", "core", "flare", "ghosts"};

// -- checks ------------------------------------------------------------------

/* Checks that frames of --frames, and all views of a frame, are there. */
static gp_status check_missing(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_jobs *j)
{
    const bool eyes = j->view.n > 1 && j->views == 1; // files of each frame
    const char *first = NULL;
    int missing = 0;
    if ((!s->input.frames && !eyes) || s->input.skip_bad_frames)
        return GP_OK;
    for (int i = 0; i < j->n; i += j->views) {
        const char *const input = j->job[i].input;
        bool complete = true;
        // (other failures are reported when the file is read)
        if (gp_is_dash(input) || access(input, F_OK) == 0 ||
            (errno != ENOENT && errno != ENOTDIR))
            continue;
        for (int k = i; k < i + j->views && complete; k++)
            complete = gp_job_complete(NULL, &s->output.write, j, &j->job[k]);
        if (complete)
            continue;
        first = first ? first : input;
        missing++;
    }
    if (!first)
        return GP_OK;
    return gp_fail(log, GP_ERR_IO,
                   "%s: no such frame (first of %d missing, "
                   "%d listed by %s %s); render %s, or give --skip-bad-frames",
                   first, missing, j->n / j->views,
                   s->input.frames ? "--frames" : "--views",
                   s->input.frames  ? s->input.frames
                   : s->input.views ? s->input.views
                                    : "left,right",
                   missing == 1 ? "it" : "them");
}

// -- names -------------------------------------------------------------------

gp_status gp_job_beside(const struct gp_log *log, const struct gp_job *job,
                        const char *path, char **name)
{
    struct gp_pattern p;
    int number = 0;
    gp_status st = gp_pattern_of_input(log, path, &p);
    if (st)
        return st;
    if (p.views && !job->view)
        return gp_fail(log, GP_ERR_USAGE, "%s: %%V and %%v need views (%s has "
            "none); give a plain file name, or --views", path, job->input);
    if (p.len && !gp_job_number(job, &number))
        return gp_fail(log, GP_ERR_USAGE, "%s: a pattern needs frame numbers "
                       "(%s has none); give a plain file name", path,
                       job->input);
    *name = gp_pattern_name(&p, number, job->view);
    return *name ? GP_OK : gp_no_memory(log, path);
}

gp_status gp_jobs_check_names(
    const struct gp_log *log, const struct gp_settings *s,
    const struct gp_jobs *j, const char *const *also, int n)
{
    enum { BESIDE = 5 };
    const struct gp_mask_word mask =
        gp_mask_word_of(s->light.mask ? s->light.mask : "crypto:");
    const struct {
        const char *what, *path;
    } beside[BESIDE] = {
        {"--depth-file", s->sun.depth_file},
        {"--mask-file", s->sun.mask_file},
        {"--deep", s->sun.deep},
        {"--source", s->light.source},
        {"--source-mask", mask.crypto ? NULL : mask.word},
    };
    gp_status st = GP_OK;
    struct gp_output_guard c = {.log = log, .s = s};
    for (int t = 0; t < j->targets; t++) {
        const struct gp_output *const target = &j->target[t];
        const struct gp_pattern *const p = &target->name;
        // jobs share a stream, and a file of all views
        const int step = gp_is_dash(p->path) ? j->n
                         : target->whole || target->hero ? j->views : 1;
        for (int i = 0; i < j->n; i += step) {
            const struct gp_job *const job = &j->job[i];
            char *const name = gp_job_name(job, target);
            st = !name ? gp_no_memory(log, p->path)
                 : p->views && gp_is_dash(name)
                     ? gp_fail(log, GP_ERR_USAGE, "%s: becomes - for a view, "
                               "which is stdout; write ./%s", p->path, p->path)
                     : gp_output_guard_add(&c, name,
                                           gp_targets[target->kind].option,
                                           p->path, j->n > 1 ? job->input
                                                             : NULL);
            free(name);
            GP_TRY(st);
        }
    }
    GP_TRY(gp_output_guard_settle(&c));
    // (frames of stdin have names of their own)
    if (c.exists && j->members.n)
        GP_TRY(gp_output_guard_input(&c, "input", "-"));
    for (int i = 0; i < j->n && c.exists && !j->members.n; i += j->views)
        GP_TRY(gp_output_guard_input(&c, "input", j->job[i].input));
    for (int i = 0; i < BESIDE * j->n && c.exists; i++) {
        char *name;
        const char *const path = beside[i % BESIDE].path;
        if (!path || gp_job_beside(NULL, &j->job[i / BESIDE], path, &name))
            continue; // reading the frame reports it
        st = gp_output_guard_input(&c, beside[i % BESIDE].what, name);
        free(name);
        GP_TRY(st);
    }
    for (int i = 0; i < n; i++)
        GP_TRY(gp_output_guard_input(&c, "another file names", also[i]));
out:
    gp_output_guard_end(&c);
    return st;
}

// -- all jobs ----------------------------------------------------------------

/* Marks the outputs of all views of a frame, and those of only the first. */
static void mark_outputs(struct gp_jobs *j)
{
    for (int i = 0; i < j->targets; i++) {
        struct gp_output *const t = &j->target[i];
        const bool one = j->views > 1 && !t->name.views;
        t->whole = one && t->kind == GP_TARGET_HDR;
        t->hero = one && !t->whole && j->views_found;
    }
}

/* Checks that several frames have patterns and several views have %V, the names of
 * all outputs, and that the first frame's can be written.
 *   patterns  some input is a pattern
 *   later     the views are not known yet: names with %V are left for then */
static gp_status check_outputs(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_jobs *j, bool patterns,
    bool later)
{
    const int views = gp_jobs_of_frame(j), frames = j->n / views;
    gp_status st = GP_OK;
    for (const struct gp_output *t = j->target; t < j->target + j->targets;
         t++) {
        const struct gp_pattern *const p = &t->name;
        const bool dash = gp_is_dash(p->path);
        if (!p->len && !dash && (patterns || frames > 1))
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: one name for a sequence "
                           "(found %d frame%s); write a pattern such as "
                           "out.####.png, or -",
                           p->path, frames, frames == 1 ? "" : "s");
        for (int i = 0; i < j->n && p->len; i++) {
            if (!j->job[i].numbered)
                return gp_fail(log, GP_ERR_USAGE,
                               "%s: no frame number in this "
                               "input (%s needs one); add one to its name, or "
                               "give plain output names",
                               j->job[i].input, p->path);
        }
        if (p->views && !j->view.n && !later)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: %%V and %%v need views (%s "
                           "has no %%V in its name and no views inside); give "
                           "--views left,right",
                           p->path, j->job[0].input);
        if (!p->views && !t->whole && !t->hero && j->view.n > 1 && !dash)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: one name for several views "
                           "(found %d); write a name with %%V or %%v, such as "
                           "out.%%V.png, or -",
                           p->path, j->view.n);
        GP_TRY(gp_views_check(log, p, &j->view));
        if (dash && isatty(STDOUT_FILENO))
            return gp_fail(log, GP_ERR_USAGE, "-: stdout is a terminal; pipe "
                           "it into a program, or give a file");
        for (int k = 0; k < views && !(later && p->views); k++) {
            char *const name = gp_job_name(&j->job[k], t);
            st = !name ? gp_no_memory(log, p->path)
                 : t->kind == GP_TARGET_HDR || t->kind == GP_TARGET_PARTS
                     ? gp_write_hdr_check(log, &s->output.write,
                                          t->kind == GP_TARGET_HDR
                                              ? GP_HDR_KEEPS
                                              : GP_PARTS_KEEP,
                                          name)
                     : gp_write_check(log, &s->output.write, name);
            free(name);
            GP_TRY(st);
        }
    }
    st = gp_jobs_check_names(log, s, j, NULL, 0);
out:
    return st;
}

gp_status gp_jobs_make(const struct gp_log *log, const struct gp_settings *s,
                       struct gp_jobs *out)
{
    gp_status st;
    struct gp_jobs j = {.views = 1, .members.stream = GP_STREAM_EMPTY};
    bool patterns = false;
    enum gp_target_kind kind;
    size_t outputs = 0;
    while (gp_output_at(s, (int) outputs, &kind))
        outputs++;
    GP_TRY(gp_alloc_zero(log, "output list", outputs + 1, sizeof *j.target,
                         &j.target));
    for (const char *path; (path = gp_output_at(s, j.targets, &kind));) {
        struct gp_output *const t = &j.target[j.targets++];
        t->kind = kind;
        GP_TRY(gp_pattern_find(log, path, &t->name));
    }
    GP_TRY(add_inputs(log, s, &j, &patterns));
    const bool piped = gp_is_dash(j.job[0].input);
    const bool looks = views_all(s) && !j.view.n;
    if (looks && !piped)
        GP_TRY(add_views(log, s, &j));
    mark_outputs(&j);
    // outputs are checked before stdin is read, and again with its views
    GP_TRY(check_outputs(log, s, &j, patterns, looks && piped));
    GP_TRY(check_missing(log, s, &j));
    if (piped) {
        GP_TRY(read_stdin(log, s, &j));
        if (looks)
            GP_TRY(add_views(log, s, &j));
        mark_outputs(&j);
        GP_TRY(check_outputs(log, s, &j, patterns, false));
    }
    for (int i = 0; i < j.targets && s->output.write.alpha == GP_ALPHA_KEEP;
         i++) {
        const struct gp_output *const t = &j.target[i];
        if (t->kind == GP_TARGET_PICTURE &&
            !gp_write_has_alpha(&s->output.write, t->name.path))
            gp_say(log, GP_LEVEL_WARN, "%s: --alpha keep: this format has no "
                   "alpha (the picture is composited over black); write .exr, "
                   ".png or .tif", t->name.path);
    }
    *out = j;
    return GP_OK;
out:
    gp_jobs_free(&j);
    return st;
}

void gp_jobs_free(struct gp_jobs *j)
{
    for (int i = 0; i < j->n; i += j->views)
        free(j->job[i].input);
    gp_free(j->job);
    gp_members_free(&j->members);
    gp_views_free(&j->view);
    gp_free(j->target);
    free(j->views_line);
    *j = (struct gp_jobs) {0};
}

char *gp_job_name(const struct gp_job *job, const struct gp_output *target)
{
    return gp_pattern_name(&target->name, job->frame, job->view);
}

bool gp_job_number(const struct gp_job *job, int *number)
{
    *number = job->frame;
    return job->numbered || gp_frame_number(job->input, number);
}

int gp_jobs_of_frame(const struct gp_jobs *j)
{
    return j->view.n ? j->view.n : 1;
}

bool gp_job_complete(const struct gp_log *log, const struct gp_write_params *p,
                     const struct gp_jobs *j, const struct gp_job *job)
{
    int from = (int) (job - j->job), jobs = 1;
    if (!p->no_clobber || j->targets == 0)
        return false;
    for (int i = 0; i < j->targets && jobs == 1; i++) {
        if (j->target[i].whole) { // made from all views of the frame
            from -= from % j->views;
            jobs = j->views;
        }
    }
    for (int i = 0; i < jobs * j->targets; i++) {
        const struct gp_output *const t = &j->target[i % j->targets];
        const int k = from + i / j->targets;
        if (t->hero && k % j->views)
            continue;
        char *const name = gp_job_name(&j->job[k], t);
        const bool kept = name && gp_write_kept(log, p, name);
        free(name);
        if (!kept)
            return false;
    }
    return true;
}
