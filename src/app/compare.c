#include "app/compare.h"

#include "app/bench_table.h"
#include "app/compare_figures.h"
#include "app/compare_flip.h"
#include "app/compare_print.h"
#include "app/files.h"
#include "core/parallel.h"
#include "io/file.h"
#include "io/raw_read.h"
#include "io/sequence.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A run, and the pair it is at. */
struct run {
    const struct gp_log *log;
    const struct gp_settings *s;
    struct gp_pattern in[2];       // .len 0: a plain file
    struct gp_pattern heatmap;
    struct gp_frames frames;       // n 0: one pair of plain files
    FILE *json;                    // NULL: not wanted
    bool full;                     // a line of it was lost
    enum gp_compare_result worst;
    int count[GP_COMPARE_FILE + 1];

    struct gp_compare_row row;
    bool drawn;                    // the pair has its heatmap
};

static bool on_stdout(const char *path)
{
    return path && strcmp(path, "-") == 0;
}

// -- one part of one pair ----------------------------------------------------

/* Says what came out, on stdout and in the JSON. */
static void tell(struct run *r)
{
    const struct gp_settings *const s = r->s;
    r->count[r->row.result]++;
    if (r->row.result > r->worst)
        r->worst = r->row.result;
    if (r->json && !gp_compare_json(&r->row, r->json))
        r->full = true;
    if (s->level == GP_LEVEL_ERROR || on_stdout(s->bench.json))
        return;
    if (r->frames.n && s->level < GP_LEVEL_INFO)
        gp_compare_print_line(&r->row, stdout);
    else
        gp_compare_print(&r->row, stdout);
}

static void tell_why(struct run *r, enum gp_compare_result result,
                     const char *why)
{
    r->row.result = result;
    r->row.why = why;
    tell(r);
    r->row.why = NULL;
}

static gp_status draw(struct run *r, const struct gp_compare_match *m,
                      const struct gp_compare_flip *flip)
{
    if (!r->s->compare.heatmap || r->drawn || !flip->known)
        return GP_OK;
    char *const name = gp_pattern_name(&r->heatmap, r->row.frame, NULL);
    if (!name)
        return gp_fail(r->log, GP_ERR_BUG, "%s: out of memory",
                       r->heatmap.path);
    gp_status st = gp_compare_heatmap(r->log, &r->s->write, name, m, flip);
    free(name);
    r->drawn = !st;
    return st;
}

/* Windows far apart would make a union that neither file asked for. */
static gp_status check_union(const struct run *r, struct gp_rect u)
{
    const long long w = (long long) u.x1 - u.x0, h = (long long) u.y1 - u.y0;
    const long long most = r->s->read.max_pixels;
    if (w > most || h > most / w || w > INT32_MAX / 4 || h > INT32_MAX / 4)
        return gp_fail(r->log, GP_ERR_DATA,
                       "%s: its window and that of %s are too far apart "
                       "(%lld x %lld pixels over both, at most %lld); crop "
                       "them, or raise --max-pixels", r->row.a, r->row.b, w, h,
                       most);
    return GP_OK;
}

static gp_status compare_images(struct run *r, const struct gp_raw_image *a,
                                const struct gp_raw_image *b)
{
    gp_status st;
    struct gp_compare_match m;
    struct gp_compare_figures figures;
    struct gp_compare_flip flip = {0};
    GP_TRY(gp_compare_match_make(r->log, a, b, &m));
    GP_TRY(check_union(r, m.window));
    if (m.shared == 0) {
        tell_why(r, GP_COMPARE_DIFFERENT, "no channel has the same name in "
                 "both");
        goto out;
    }
    GP_TRY(gp_compare_measure(r->log, &r->s->compare, &m, &figures));
    GP_TRY(gp_compare_flip(r->log, &r->s->compare, &m, &flip));
    GP_TRY(draw(r, &m, &flip));
    r->row.limits = &r->s->compare;
    r->row.match = &m;
    r->row.figures = &figures;
    r->row.flip = &flip;
    r->row.result = figures.result;
    tell(r);
out:
    gp_compare_flip_free(&flip);
    gp_compare_match_free(&m);
    return st;
}

static gp_status compare_part(struct run *r, const struct gp_raw_file f[2],
                              int part)
{
    gp_status st;
    struct gp_raw_image image[2] = {0};
    r->row.part = part;
    for (int i = 0; i < 2; i++)
        GP_TRY(gp_raw_read(r->log, &r->s->read, &f[i], part, &image[i]));
    if (image[0].deep != image[1].deep)
        tell_why(r, GP_COMPARE_DIFFERENT, "one is deep, the other is not");
    else if (image[0].deep)
        st = gp_fail(r->log, GP_ERR_DATA,
                     "%s: deep data cannot be compared (part %d); flatten "
                     "both files", r->row.a, part);
    else
        st = compare_images(r, &image[0], &image[1]);
out:
    gp_raw_image_free(&image[0]);
    gp_raw_image_free(&image[1]);
    return st;
}

// -- pairs -------------------------------------------------------------------

static gp_status compare_parts(struct run *r, const struct gp_raw_file f[2])
{
    const int least = f[0].parts < f[1].parts ? f[0].parts : f[1].parts;
    const int most = f[0].parts + f[1].parts - least;
    char why[64];
    gp_status st = GP_OK;
    r->row.parts = most;
    for (int part = 0; part < least && !st; part++)
        st = compare_part(r, f, part);
    r->row.part = least;
    if (!st && most > least) { // as idiff -a
        snprintf(why, sizeof why, "%d parts and %d", f[0].parts, f[1].parts);
        tell_why(r, GP_COMPARE_FAILURE, why);
    }
    return st;
}

static gp_status compare_files(struct run *r)
{
    struct gp_raw_file f[2] = {
        {.stream = GP_STREAM_EMPTY}, {.stream = GP_STREAM_EMPTY},
    };
    const char *const path[2] = {r->row.a, r->row.b};
    gp_status st = GP_OK;
    r->row.part = 0;
    r->row.parts = 1;
    r->drawn = false;
    for (int i = 0; i < 2 && !st; i++)
        st = gp_raw_open(r->log, &r->s->read, path[i], &f[i]);
    if (!st)
        st = compare_parts(r, f);
    if (st && st != GP_ERR_BUG) {
        tell_why(r, GP_COMPARE_FILE, "a file cannot be read or written");
        st = GP_OK;
    }
    gp_raw_close(&f[0]);
    gp_raw_close(&f[1]);
    return st;
}

static gp_status compare_frame(struct run *r, int frame)
{
    char *const a = gp_pattern_name(&r->in[0], frame, NULL);
    char *const b = gp_pattern_name(&r->in[1], frame, NULL);
    gp_status st;
    r->row = (struct gp_compare_row) {
        .a = a, .b = b, .numbered = r->frames.n > 0, .frame = frame,
    };
    st = a && b ? compare_files(r)
                : gp_fail_bare(r->log, GP_ERR_BUG,
                               "frame %d: out of memory", frame);
    free(a);
    free(b);
    return st;
}

// -- which frames ------------------------------------------------------------

/* Adds the frames on disk of a pattern to those that are there. */
static gp_status add_frames(struct run *r, const struct gp_pattern *p)
{
    struct gp_frames more = {0};
    gp_status st = gp_frames_on_disk(r->log, p, NULL, &more);
    if (!st && !gp_frames_join(&r->frames, &more))
        st = gp_fail_bare(r->log, GP_ERR_BUG, "frame list: out of memory");
    gp_frames_free(&more);
    return st;
}

static gp_status find_frames(struct run *r)
{
    const struct gp_settings *const s = r->s;
    gp_status st = GP_OK;
    for (int i = 0; i < 2; i++)
        GP_TRY(gp_pattern_of_input(r->log, s->inputs.at[i], &r->in[i]));
    const bool sequence = r->in[0].len || r->in[1].len;
    if (s->frames && !sequence)
        return gp_fail(r->log, GP_ERR_USAGE,
                       "%s: --frames needs a pattern (found plain names); "
                       "write shot.####.exr, or leave --frames out",
                       s->inputs.at[0]);
    if (s->frames)
        GP_TRY(gp_frames_parse(r->log, s->frames, &r->frames));
    for (int i = 0; i < 2 && !s->frames; i++) {
        if (r->in[i].len)
            GP_TRY(add_frames(r, &r->in[i]));
    }
    if (!s->compare.heatmap)
        return GP_OK;
    GP_TRY(gp_pattern_find(r->log, s->compare.heatmap, &r->heatmap));
    if (sequence && !r->heatmap.len)
        return gp_fail(r->log, GP_ERR_USAGE,
                       "%s: one name for a sequence; write a pattern such as "
                       "heat.####.png", s->compare.heatmap);
    GP_TRY(gp_write_check(r->log, &s->write, s->compare.heatmap));
out:
    return st;
}

// -- names ------------------------------------------------------------------

/* The item is a place in the list of frames. */
static int frame_at(const struct run *r, int item)
{
    return r->frames.n ? r->frames.number[item] : 0;
}

static struct gp_file_owner owner(const void *user,
                                  const struct gp_file_id *id)
{
    const struct run *const r = user;
    return (struct gp_file_owner) {
        .name = gp_pattern_name(&r->heatmap, frame_at(r, id->item), NULL),
        .what = "--heatmap",
        .as = r->heatmap.path,
    };
}

/* Replaces *name by that of an item's file. */
static gp_status make_name(const struct run *r, const struct gp_pattern *p,
                           int item, char **name)
{
    free(*name);
    *name = gp_pattern_name(p, frame_at(r, item), NULL);
    return *name ? GP_OK
                 : gp_fail(r->log, GP_ERR_BUG, "%s: out of memory", p->path);
}

/* Nothing is written over a file that is compared, or over another output. */
static gp_status check_names(const struct run *r)
{
    gp_status st;
    struct gp_files f;
    char *name = NULL;
    const int n = r->frames.n ? r->frames.n : 1;
    GP_TRY(gp_files_begin(r->log, r->s, owner, r, &f));
    for (int i = 0; i < n && r->s->compare.heatmap; i++) {
        GP_TRY(make_name(r, &r->heatmap, i, &name));
        GP_TRY(gp_files_write(&f, name, 0, i));
    }
    GP_TRY(gp_files_settle(&f));
    for (int i = 0; i < 2 * n && f.there; i++) {
        GP_TRY(make_name(r, &r->in[i % 2], i / 2, &name));
        GP_TRY(gp_files_read(&f, "input", name));
    }
out:
    free(name);
    gp_files_end(&f);
    return st;
}

// -- the whole run -----------------------------------------------------------

static gp_status compare_all(struct run *r)
{
    gp_status st = find_frames(r);
    const char *const json = r->s->bench.json;
    if (!st && json && !on_stdout(json))
        st = gp_file_check(r->log, json, false);
    if (!st)
        st = check_names(r);
    if (!st && !r->frames.n)
        return compare_frame(r, 0);
    for (int i = 0; i < r->frames.n && !st; i++)
        st = compare_frame(r, r->frames.number[i]);
    if (st || r->s->level == GP_LEVEL_ERROR || on_stdout(json))
        return st;
    printf("%d frames: %s", r->frames.n, gp_compare_word(r->worst));
    for (int i = 0; i <= GP_COMPARE_FILE; i++) {
        if (r->count[i])
            printf(", %d %s", r->count[i],
                   gp_compare_word((enum gp_compare_result) i));
    }
    putchar('\n');
    return GP_OK;
}

static gp_status finish(struct run *r, char **text, size_t *size)
{
    const char *const path = r->s->bench.json;
    if (r->json) {
        r->full = ferror(r->json) || r->full;
        r->full = fclose(r->json) != 0 || r->full;
    }
    if (r->full)
        return gp_fail(r->log, GP_ERR_BUG, "%s: out of memory", path);
    if (fflush(stdout) != 0 || ferror(stdout))
        return gp_fail(r->log, GP_ERR_IO,
                       "-: cannot write to stdout (%s); check who reads it",
                       strerror(errno));
    return path ? gp_bench_write(r->log, path, *text, *size) : GP_OK;
}

int gp_compare_run(const struct gp_log *log, const struct gp_settings *s)
{
    struct run r = {.log = log, .s = s};
    char *text = NULL;
    size_t size = 0;
    gp_set_threads(s->threads);
    r.json = s->bench.json ? open_memstream(&text, &size) : NULL;
    gp_status st = s->bench.json && !r.json
                       ? gp_fail(log, GP_ERR_BUG, "%s: out of memory",
                                 s->bench.json)
                       : compare_all(&r);
    if (!st)
        st = finish(&r, &text, &size);
    else if (r.json)
        fclose(r.json);
    free(text);
    gp_frames_free(&r.frames);
    return st == GP_OK          ? (int) r.worst
           : st == GP_ERR_USAGE ? (int) st
           : st == GP_ERR_BUG   ? (int) st : GP_COMPARE_FILE;
}

gp_status gp_compare_check(const struct gp_log *log,
                           const struct gp_settings *s)
{
    const struct gp_compare_settings *const c = &s->compare;
    const double *const e = c->flip_exposures.v;
    if (s->inputs.n != 2)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: two images are compared (found %d); write glarepp "
                       "compare A B", s->inputs.n > 2 ? s->inputs.at[2]
                                                      : "compare",
                       s->inputs.n);
    if (on_stdout(s->inputs.at[0]) && on_stdout(s->inputs.at[1]))
        return gp_fail(log, GP_ERR_USAGE,
                       "-: stdin holds one image; give a file beside it");
    if (c->flip_exposures.n &&
        !(e[2] >= 1.0 && e[2] <= GP_FLIP_EXPOSURES_MAX && e[2] == floor(e[2])))
        return gp_fail(log, GP_ERR_USAGE,
                       "--flip-exposures: not a number of exposures (found "
                       "%g); give START,STOP,COUNT with a count of 1 to %d",
                       e[2], GP_FLIP_EXPOSURES_MAX);
    if (c->no_flip && (c->heatmap || c->flip_exposures.n))
        return gp_fail(log, GP_ERR_USAGE,
                       "--no-flip: %s is made of FLIP; leave one of the two "
                       "out", c->heatmap ? "--heatmap" : "--flip-exposures");
    if (on_stdout(c->heatmap))
        return gp_fail(log, GP_ERR_USAGE,
                       "--heatmap: stdout is for the figures (found -); give "
                       "a file");
    return GP_OK;
}
