/* glarepp compare: reads two images, or two sequences part by part, has them
 * compared, and reports. */
#include "cli/output_guard.h"
#include "cli/commands.h"
#include "cli/compare_report.h"
#include "cli/options.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/file.h"
#include "io/read.h"
#include "io/sequence.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEATMAP, DIFFERENCE, PICTURES };

/* A run, and its present pair. */
struct run {
    const struct gp_log *log;
    struct glarepp *gp;
    const struct gp_settings *s;
    struct gp_write_params write;        // of pictures
    struct gp_pattern in[2];             // .len 0: a plain file
    const char *wanted[PICTURES];        // as given; NULL: not wanted
    struct gp_pattern picture[PICTURES]; // of those
    struct gp_frames frames;             // n 0: one pair of plain files
    FILE *json;                          // NULL: not wanted
    bool full;                           // a line of it could not be written
    int worst;                           // exit status
    int count[GP_COMPARE_FILE + 1];

    struct gp_compare_row row;
    bool drawn[PICTURES];                // the pair has this one
};

/* True when the figures are printed for readers. */
static bool prints(const struct run *r)
{
    return r->log->level != GP_LEVEL_ERROR && !gp_is_dash(r->s->bench.json);
}

/* True when they are printed in full, not in a line for each frame. */
static bool in_full(const struct run *r)
{
    return prints(r) &&
           (r->frames.n == 0 || r->log->level >= GP_LEVEL_INFO);
}

// -- one part of one pair ----------------------------------------------------

/* Reports r->row, on stdout and in the JSON. */
static void report_pair(struct run *r, int result, const char *why)
{
    struct gp_compare_row *const row = &r->row;
    row->result = result;
    row->why = why;
    r->count[result]++;
    if (result > r->worst)
        r->worst = result;
    if (r->json) { // an object a line
        char *const text = gp_json_print(
            gp_compare_json(row, r->frames.n > 0),
            JSON_COMPACT | JSON_REAL_PRECISION(9));
        r->full = r->full || !text || fprintf(r->json, "%s\n", text) <= 0;
        free(text);
    }
    if (in_full(r))
        gp_compare_print(row, &r->s->compare);
    else if (prints(r))
        gp_compare_print_line(row);
}

/* Writes a picture of the frame, once. */
static gp_status draw(struct run *r, int which)
{
    char *const name = gp_pattern_name(&r->picture[which], r->row.frame, NULL);
    if (!name)
        return gp_no_memory(r->log, r->wanted[which]);
    const gp_status st =
        which == HEATMAP
            ? gp_compare_draw_flip(r->log, &r->write, name, &r->row)
            : gp_compare_draw_difference(r->log, &r->write, name, &r->row,
                                         &r->s->compare);
    free(name);
    r->drawn[which] = !st;
    return st;
}

/* Has the library compare two images, by all limits of the command line. */
static gp_status measure(const struct run *r, const struct gp_stored_image image[2],
                         struct glarepp_compare **out)
{
    const struct gp_compare_settings *const s = &r->s->compare;
    const double *const e = s->flip_exposures.v;
    struct glarepp_compare_params p = s->limits;
    struct glarepp_stored stored[2];
    struct glarepp_channel *channel[2] = {NULL, NULL};
    gp_status st;
    *out = NULL;
    p.most = r->s->input.read.max_pixels;
    p.start = (float) e[0];
    p.stop = (float) e[1];
    p.exposures = s->flip_exposures.n ? (int) e[2] : 0;
    for (int k = 0; k < 2; k++) {
        const struct gp_stored_image *const m = &image[k];
        GP_TRY(gp_alloc(r->log, "channels", (size_t) m->channels,
                        sizeof *channel[k], &channel[k]));
        for (int i = 0; i < m->channels; i++)
            channel[k][i] = (struct glarepp_channel) {
                m->channel[i].name, m->channel[i].v, m->channel[i].is_uint};
        stored[k] = (struct glarepp_stored) {
            .size = sizeof stored[k], .name = k ? r->row.b : r->row.a,
            .data = {m->data.x0, m->data.y0, m->data.x1, m->data.y1},
            .channel = channel[k], .channels = m->channels, .first = m->first,
            .integers = m->integers,
            .light = {m->light[0], m->light[1], m->light[2]},
            .primaries = m->chromaticities,
        };
    }
    GP_TRY(glarepp_compare(r->gp, &p, &stored[0], &stored[1], out));
out:
    gp_free(channel[0]);
    gp_free(channel[1]);
    return st;
}

static gp_status compare_images(struct run *r,
                                const struct gp_stored_image image[2])
{
    gp_status st;
    struct glarepp_compare *compare;
    const struct gp_compare_settings *const p = &r->s->compare;
    bool unwritten = false;
    GP_TRY(measure(r, image, &compare));
    const struct glarepp_compare_facts *const f = glarepp_compare_facts(compare);
    for (int k = 0; k < 2; k++)
        r->row.image[k] = &image[k];
    r->row.compare = compare;
    r->row.facts = f;
    if (p->heatmap && !f->has_flip)
        gp_say(r->log, GP_LEVEL_WARN, "%s: has no colour for FLIP; --heatmap "
               "is not written", r->row.a);
    else if (p->heatmap && !r->drawn[HEATMAP])
        GP_TRY(draw(r, HEATMAP));
    if (p->difference && image[0].deep) {
        gp_say(r->log, GP_LEVEL_WARN, "%s: is deep; --difference is not "
               "written", r->row.a);
    } else if (p->difference && !r->drawn[DIFFERENCE] &&
               (f->max > 0.0 || !p->only_different)) {
        st = draw(r, DIFFERENCE);
        unwritten = st == GP_ERR_IO;
        GP_TRY(unwritten ? GP_OK : st);
    }
    if (!f->lit && (p->limits.perceptual || isfinite(p->limits.fail_flip)))
        report_pair(r, GP_COMPARE_DIFFERENT,
                    "one has no colour, which --perceptual and --fail-flip "
                    "need");
    else
        report_pair(r, f->result, NULL);
    if (unwritten && r->row.result < GP_COMPARE_FAILURE)
        st = GP_ERR_IO; // else the difference is the status, as idiff's
out:
    glarepp_compare_end(&compare);
    return st;
}

/* Compares the files of a frame: their first parts, or part by part. */
static gp_status compare_frame(struct run *r, int frame)
{
    const struct gp_read_params *const read = &r->s->input.read;
    const bool all = r->s->compare.all_parts;
    struct gp_stored_file f[2] = {
        {.stream = GP_STREAM_EMPTY}, {.stream = GP_STREAM_EMPTY},
    };
    char *const path[2] = {
        gp_pattern_name(&r->in[0], frame, NULL),
        gp_pattern_name(&r->in[1], frame, NULL),
    };
    gp_status st = path[0] && path[1]
                       ? GP_OK : gp_no_memory(r->log, r->s->input.files.at[0]);
    r->row = (struct gp_compare_row) {.a = path[0], .b = path[1],
                                      .frame = frame, .parts = 1};
    memset(r->drawn, 0, sizeof r->drawn);
    if (in_full(r) && !st)
        printf("Comparing \"%s\" and \"%s\"\n", gp_printable(path[0]).text,
               gp_printable(path[1]).text);
    for (int i = 0; i < 2 && !st; i++)
        st = gp_stored_open(r->log, read, path[i], &f[i]);
    const int both = st ? 0 : all ? gp_min(f[0].parts, f[1].parts) : 1;
    if (!st && all)
        r->row.parts = gp_max(f[0].parts, f[1].parts);
    for (int part = 0; part < both && !st; part++) {
        struct gp_stored_image image[2] = {0};
        r->row.part = part;
        for (int i = 0; i < 2 && !st; i++)
            st = gp_stored_read(r->log, read, &f[i], part, &image[i]);
        if (!st && image[0].deep != image[1].deep)
            report_pair(r, GP_COMPARE_DIFFERENT,
                        "one is deep, the other is not");
        else if (!st)
            st = compare_images(r, image);
        gp_stored_image_free(&image[0]);
        gp_stored_image_free(&image[1]);
    }
    if (!st && r->row.parts > both) { // as idiff -a
        char why[64];
        snprintf(why, sizeof why, "%d parts and %d", f[0].parts, f[1].parts);
        r->row.part = both;
        report_pair(r, GP_COMPARE_FAILURE, why);
    }
    if (!st && !all && in_full(r) && (f[0].parts > 1 || f[1].parts > 1))
        printf("Only compared the first part (of %d and %d, respectively); -a "
               "compares all\n", f[0].parts, f[1].parts);
    if (st && st != GP_ERR_BUG) {
        report_pair(r, GP_COMPARE_FILE, "a file cannot be read or written");
        st = GP_OK;
    }
    for (int i = 0; i < 2; i++) {
        gp_stored_close(&f[i]);
        free(path[i]);
    }
    return st;
}

// -- the whole run -----------------------------------------------------------

/* Checks that no picture replaces a compared file or another output. */
static gp_status check_names(const struct run *r)
{
    gp_status st;
    struct gp_output_guard c;
    char *name = NULL;
    const int n = gp_max(r->frames.n, 1);
    GP_TRY(gp_output_guard_begin(r->log, r->s, &c));
    for (int i = 0; i < 4 * n; i++) { // the pictures of all, then the inputs
        const bool input = i >= 2 * n;
        const struct gp_pattern *const p = input ? &r->in[i % 2]
                                                 : &r->picture[i % 2];
        const int frame = r->frames.n ? r->frames.number[i % (2 * n) / 2] : 0;
        if (i == 2 * n)
            GP_TRY(gp_output_guard_settle(&c));
        if (input ? !c.exists : !r->wanted[i % 2])
            continue;
        name = gp_pattern_name(p, frame, NULL);
        if (!name)
            GP_TRY(gp_no_memory(r->log, p->path));
        const struct gp_output_guard_output output = {
            .name = name, .what = i % 2 ? "--difference" : "--heatmap",
            .as = p->path, .order = i,
        };
        GP_TRY(input ? gp_output_guard_input(&c, "input", name)
                     : gp_output_guard_add(&c, &output));
        GP_FREE(name);
    }
out:
    gp_free(name);
    gp_output_guard_end(&c);
    return st;
}

/* Finds the files and frames of the run, and checks the names of its outputs
 * before any work. */
static gp_status find_frames(struct run *r)
{
    const char *const *const input = r->s->input.files.at;
    const char *const list = r->s->input.frames, *const json = r->s->bench.json;
    struct gp_frames more = {0};
    gp_status st;
    for (int i = 0; i < 2; i++)
        GP_TRY(gp_pattern_of_input(r->log, input[i], &r->in[i]));
    const bool sequence = r->in[0].len || r->in[1].len;
    if (list && !sequence)
        return gp_fail(r->log, GP_ERR_USAGE, "%s: --frames needs a pattern "
                       "(found plain names); write a pattern, e.g. "
                       "shot.####.exr, or leave --frames out", input[0]);
    if (list)
        GP_TRY(gp_frames_parse(r->log, list, &r->frames));
    for (int i = 0; i < 2 && !list; i++) {
        if (!r->in[i].len)
            continue;
        GP_TRY(gp_frames_on_disk(r->log, &r->in[i], NULL, &more));
        if (!gp_frames_join(&r->frames, &more))
            GP_TRY(gp_no_memory(r->log, input[i]));
        gp_frames_free(&more);
    }
    for (int i = 0; i < PICTURES; i++) {
        if (!r->wanted[i])
            continue;
        GP_TRY(gp_pattern_find(r->log, r->wanted[i], &r->picture[i]));
        if (sequence && !r->picture[i].len)
            return gp_fail(r->log, GP_ERR_USAGE, "%s: one name for all frames "
                           "of a sequence; write a pattern, e.g. heat.####.png",
                           r->wanted[i]);
        // the pair is compared even where its difference cannot be written
        if (i == HEATMAP ||
            gp_write_check(NULL, &r->write, r->wanted[i]) != GP_ERR_IO)
            GP_TRY(gp_write_check(r->log, &r->write, r->wanted[i]));
    }
    if (json && !gp_is_dash(json))
        GP_TRY(gp_file_check(r->log, json, false));
    GP_TRY(check_names(r));
out:
    gp_frames_free(&more);
    return st;
}

/* Compares all frames; prints how many are alike, and the verdict. */
static gp_status compare_all(struct run *r)
{
    gp_status st = GP_OK;
    if (!r->frames.n)
        GP_TRY(compare_frame(r, 0));
    for (int i = 0; i < r->frames.n; i++)
        GP_TRY(compare_frame(r, r->frames.number[i]));
    if (prints(r) && r->frames.n) {
        printf("%d frames: %s", r->frames.n, gp_compare_word(r->worst));
        for (int i = 0; i <= GP_COMPARE_FILE; i++) {
            if (r->count[i])
                printf(", %d %s", r->count[i], gp_compare_word(i));
        }
        putchar('\n');
    }
    if (prints(r))
        puts(r->worst == GP_COMPARE_MATCH     ? "PASS"
             : r->worst == GP_COMPARE_WARNING ? "WARNING" : "FAILURE");
    else if (!gp_is_dash(r->s->bench.json) && r->worst >= GP_COMPARE_FAILURE)
        fputs("FAILURE\n", stderr); // as idiff -q
out:
    return st;
}

int gp_compare_command(const struct gp_log *log, struct glarepp *gp,
                       const struct gp_settings *s)
{
    struct run r = {
        .log = log, .gp = gp, .s = s, .write = s->output.write,
        .wanted = {s->compare.heatmap, s->compare.difference},
    };
    const char *const json = s->bench.json;
    char *text = NULL, *command = NULL;
    size_t size = 0;
    gp_status st;
    if (!s->output.no_provenance && (r.wanted[0] || r.wanted[1]))
        GP_TRY(gp_command_text(log, s, s->input.files.at, s->input.files.n, &command));
    r.write.command = command;
    r.json = json ? open_memstream(&text, &size) : NULL;
    if (json && !r.json)
        GP_TRY(gp_no_memory(log, json));
    GP_TRY(find_frames(&r));
    GP_TRY(compare_all(&r));
    if (r.json) {
        const bool lost = ferror(r.json) || r.full;
        const bool closed = fclose(r.json) == 0;
        r.json = NULL;
        if (lost || !closed)
            GP_TRY(gp_no_memory(log, json));
    }
    GP_TRY(gp_flush_stdout(log));
    if (json)
        GP_TRY(gp_file_save(log, json, text, size));
out:
    if (r.json)
        fclose(r.json);
    free(text);
    free(command);
    gp_frames_free(&r.frames);
    return st == GP_OK          ? r.worst
           : st == GP_ERR_USAGE ? GP_COMPARE_USAGE
           : st == GP_ERR_BUG   ? (int) st : GP_COMPARE_FILE;
}
