// SPDX-License-Identifier: Apache-2.0
/* glarepp compare: reads two images, or two sequences part by part, has them
 * compared, and reports: idiff's lines and more, a JSON object, pictures. */
#include "cli/commands.h"
#include "cli/compare_page.h"
#include "cli/listener.h"
#include "cli/words.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/file.h"

#include <math.h>
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
    struct gp_pattern picture[PICTURES]; // .path NULL: not wanted
    struct gp_frames frames;             // n 0: one pair of plain files
    struct gp_file *json;                // NULL: not wanted
    struct gp_compare_pages pages;
    int worst;                           // exit status
    int count[GP_COMPARE_FILE + 1];

    struct gp_compare_row row;
    bool drawn[PICTURES];                // the pair has this one
};

// -- text --------------------------------------------------------------------

static const char *const result_words[] = {
    [GP_COMPARE_MATCH] = "match",     [GP_COMPARE_WARNING] = "warning",
    [GP_COMPARE_FAILURE] = "failure", [GP_COMPARE_DIFFERENT] = "different",
    [GP_COMPARE_FILE] = "file error",
};

static void print_worst(const struct gp_compare_row *r)
{
    const struct glarepp_compare_facts *const f = r->facts;
    printf("%g", f->max);
    if (f->max > 0.0)
        printf(" @ (%d, %d, %s)", f->x, f->y,
               gp_printable(f->pair[f->channel]).text);
}

/* The channel of a pair in file k, or NULL. */
static const struct glarepp_channel *channel_of(const struct gp_compare_row *r,
                                                int k, int pair)
{
    const int i = (k ? r->facts->in_b : r->facts->in_a)[pair];
    return i < 0 ? NULL : &r->image[k]->channel[i];
}

/* The values of all channels of file k at the largest error; 0 outside. */
static void print_values(const struct gp_compare_row *r, int k,
                         const char *before)
{
    const struct gp_rect d = r->image[k]->data;
    const int x = r->facts->x, y = r->facts->y;
    const bool inside = x >= d.x0 && x < d.x1 && y >= d.y0 && y < d.y1;
    const long long at = (long long) (y - d.y0) * gp_rect_w(d) + (x - d.x0);
    for (int i = 0; i < r->facts->pairs; i++) {
        const struct glarepp_channel *const c = channel_of(r, k, i);
        if (!c)
            continue;
        printf("%s%g", before,
               !inside      ? 0.0
               : c->is_uint ? (double) ((const uint32_t *) c->v)[at]
                            : (double) ((const float *) c->v)[at]);
        before = ", ";
    }
}

static void print_count(long long n, long long of, double limit)
{
    printf("  %lld pixels (%.3g%%) over %g\n", n,
           100.0 * (double) n / (double) of, limit);
}

static void print_part(const struct gp_compare_row *r,
                       const struct gp_compare_settings *s)
{
    const struct glarepp_compare_facts *const f = r->facts;
    if (r->why) {
        printf("  %s%s\n", r->parts > 1 ? "parts: " : "",
               gp_printable(r->why).text);
        return;
    }
    const struct gp_rect a = r->image[0]->data, b = r->image[1]->data;
    if (s->all_parts && r->parts > 1)
        printf("Subimage %d : ", r->part);
    if (s->all_parts)
        printf("%d x %d, %d channels\n", gp_rect_w(a), gp_rect_h(a),
               r->image[0]->channels);
    printf("  Mean error = %g\n  RMS error = %g\n  Peak SNR = %g\n"
           "  Max error  = ", f->mean, f->rms, f->psnr);
    print_worst(r);
    if (f->max > 0.0 && !r->image[0]->first) {
        print_values(r, 0, "  values are ");
        print_values(r, 1, " vs ");
    }
    putchar('\n');
    print_count(f->warned, f->pixels, (double) s->limits.warn);
    print_count(f->failed, f->pixels, (double) s->limits.fail);
    if (s->limits.perceptual)
        printf("  %lld pixels (%3g%%) failed the perceptual test\n", f->seen,
               100.0 * (double) f->seen / (double) f->pixels);
    printf("  rel_l2 = %g\n", f->rel_l2);
    if (!isnan(f->max_rel))
        printf("  max_rel = %g\n", f->max_rel);
    if (f->has_flip && f->hdr)
        printf("  HDR-FLIP = %.6f (exposures %.4g to %.4g EV, %d)\n", f->flip,
               (double) f->start, (double) f->stop, f->exposures);
    else if (f->has_flip)
        printf("  LDR-FLIP = %.6f\n", f->flip);
    if (f->uneven)
        printf("  %lld pixels differ in their number of samples, the first at "
               "(%d, %d)\n", f->uneven, f->uneven_x, f->uneven_y);
    if (f->nonfinite)
        printf("  %lld values that are NaN or infinite differ\n",
               f->nonfinite);
    for (int i = 0; i < f->pairs; i++) {
        const struct glarepp_channel *const in_a = channel_of(r, 0, i);
        const struct glarepp_channel *const in_b = channel_of(r, 1, i);
        if (in_a && in_b && strcmp(in_a->name, in_b->name) == 0)
            continue;
        if (in_a && in_b)
            printf("  channel %s is compared with %s of B, by its number\n",
                   gp_printable(in_a->name).text,
                   gp_printable(in_b->name).text);
        else
            printf("  channel %s is only in %s (0 in the other)\n",
                   gp_printable(f->pair[i]).text, in_a ? "A" : "B");
    }
    if (memcmp(&a, &b, sizeof a) != 0)
        printf("  windows %dx%d at (%d, %d) and %dx%d at (%d, %d); 0 "
               "outside\n", gp_rect_w(a), gp_rect_h(a), a.x0, a.y0,
               gp_rect_w(b), gp_rect_h(b), b.x0, b.y0);
}

static void print_frame(const struct gp_compare_row *r)
{
    const struct glarepp_compare_facts *const f = r->facts;
    printf("%d", r->frame);
    if (r->parts > 1)
        printf(", part %d", r->part);
    printf(": %s; ", result_words[r->result]);
    if (r->why) {
        printf("%s\n", gp_printable(r->why).text);
        return;
    }
    printf("max ");
    print_worst(r);
    printf("; mean %g, RMS %g, PSNR %g, rel_l2 %g", f->mean, f->rms, f->psnr,
           f->rel_l2);
    if (f->has_flip)
        printf(", FLIP %.6f", f->flip);
    putchar('\n');
}

// -- JSON --------------------------------------------------------------------

static json_t *row_json(const struct gp_compare_row *r, bool numbered)
{
    json_t *const o = json_pack(
        "{so so so* so* ss si so*}", "a", gp_json_name(r->a), "b",
        gp_json_name(r->b), "frame", numbered ? json_integer(r->frame) : NULL,
        "part", r->parts > 1 ? json_integer(r->part) : NULL, "result",
        result_words[r->result], "status", r->result, "why",
        r->why ? gp_json_name(r->why) : NULL);
    if (r->why)
        return o;
    const struct glarepp_compare_facts *const f = r->facts;
    json_t *const worst =
        !(f->max > 0.0)
            ? NULL
            : json_pack("{si si so so? so?}", "x", f->x, "y", f->y, "channel",
                        gp_json_name(f->pair[f->channel]), "a",
                        json_real(f->worst_a), "b", json_real(f->worst_b));
    json_t *const figures = json_pack( // (json_real() of Inf is NULL)
        "{so? so* so? so? so? so? so* so* ss* so* sI sI sI so* so* sI}", "max",
        json_real(f->max), "worst", worst, "mean", json_real(f->mean), "rms",
        json_real(f->rms), "psnr", json_real(f->psnr), "rel_l2",
        json_real(f->rel_l2), "max_rel",
        isinf(f->max_rel) ? json_null() : json_real(f->max_rel), "flip",
        f->has_flip ? json_real(f->flip) : NULL, "flip_kind",
        !f->has_flip ? NULL
        : f->hdr     ? "hdr"
                     : "ldr",
        "flip_exposures",
        !f->has_flip || !f->hdr ? NULL
                                : json_pack("[ffi]", (double) f->start,
                                            (double) f->stop, f->exposures),
        "nonfinite", (json_int_t) f->nonfinite, "failed",
        (json_int_t) f->failed, "warned", (json_int_t) f->warned, "uneven",
        !f->uneven ? NULL
                   : json_pack("{sI si si}", "pixels", (json_int_t) f->uneven,
                               "x", f->uneven_x, "y", f->uneven_y),
        "seen", f->seen < 0 ? NULL : json_integer(f->seen), "pixels",
        (json_int_t) f->pixels);
    json_object_update(o, figures);
    json_decref(figures);
    return o;
}

// -- pictures ----------------------------------------------------------------

/* Copies the difference of a pair. */
static gp_status subtract(const struct run *r, int pair, size_t pixels,
                          float *to)
{
    const struct gp_compare_settings *const s = &r->s->compare;
    struct glarepp_image d;
    const gp_status st = (gp_status) glarepp_compare_view(
        r->row.compare, pair, s->absolute, s->scale, &d);
    if (!st)
        memcpy(to, d.plane[0], pixels * sizeof *to);
    glarepp_image_end(&d);
    return st;
}

/* The channels of the pairs in `f`, in the order of their names, all but its
 * colour with their samples. */
static gp_status make_channels(const struct run *r, const int colour[3],
                               struct gp_frame *f)
{
    const int pairs = r->row.facts->pairs;
    const size_t pixels = gp_frame_pixels(f);
    gp_status st = gp_alloc_zero(r->log, "channels", (size_t) pairs,
                                 sizeof *f->channel, &f->channel);
    for (int i = 0; i < pairs && !st; i++) {
        struct gp_channel *const c = &f->channel[f->channels++];
        *c = (struct gp_channel) {
            .name = gp_strdup(r->row.facts->pair[i]), .type = GP_FLOAT,
            .xs = 1, .ys = 1, .w = gp_frame_w(f), .h = gp_frame_h(f),
            .colour = -1,
        };
        for (int k = 2; k >= 0; k--)
            c->colour = colour[k] == i ? k : c->colour;
        if (!c->name)
            return gp_no_memory(r->log, f->path);
        if (c->colour >= 0)
            continue;
        st = gp_alloc(r->log, c->name, pixels, sizeof(float), &c->data);
        if (!st)
            st = subtract(r, i, pixels, c->data);
    }
    return st;
}

static gp_status draw_difference(const struct run *r, struct gp_frame *f)
{
    static const char *const name[3] = {"R", "G", "B"};
    const struct gp_stored_image *const a = r->row.image[0];
    const size_t pixels = gp_frame_pixels(f);
    struct gp_write_params as = r->write;
    struct gp_write_stats stats = {0};
    int colour[3] = {-1, -1, -1};
    char ending[8];
    gp_status st;
    memcpy(f->chromaticities, a->chromaticities, sizeof f->chromaticities);
    memcpy(f->luminance, a->luminance, sizeof f->luminance);
    for (int i = 0; i < r->row.facts->pairs; i++) {
        for (int k = 0; k < 3; k++) {
            if (strcmp(r->row.facts->pair[i], name[k]) == 0)
                colour[k] = i;
        }
    }
    if (colour[0] < 0 && colour[1] < 0 && colour[2] < 0) { // the first is grey
        f->model = GP_COLOUR_GREY;
        colour[0] = colour[1] = colour[2] = 0;
    }
    GP_TRY(gp_planes_make(r->log, "difference", pixels, &f->rgb));
    for (int k = 0; k < 3; k++) {
        if (colour[k] >= 0)
            GP_TRY(subtract(r, colour[k], pixels, f->rgb.c[k]));
        else
            memset(f->rgb.c[k], 0, pixels * sizeof(float));
    }
    as.type = GP_OUT_FLOAT;
    gp_file_ending(f->path, ending, sizeof ending);
    if (strcmp(ending, "exr") == 0) {
        f->display = a->display;
        GP_TRY(make_channels(r, colour, f));
        GP_TRY(gp_write_hdr(r->log, &as, f->path,
                            &(struct gp_hdr_colour) {f, f->rgb}, 1, &stats));
    } else {
        GP_TRY(gp_write_picture(r->log, &as, f->path, f, &f->rgb,
                                GP_PICTURE_ENCODED, &stats));
    }
out:
    return st;
}

/* True when the figures are printed for readers. */
static bool prints(const struct run *r)
{
    return r->log->level != GP_LEVEL_ERROR && !gp_is_dash(r->s->bench.json) &&
           !gp_is_dash(r->s->page.html);
}

/* True when they are printed in full, not in a line for each frame. */
static bool in_full(const struct run *r)
{
    return prints(r) &&
           (r->frames.n == 0 || r->log->level >= GP_LEVEL_INFO);
}

// -- one part of one pair ----------------------------------------------------

/* Reports r->row, on stdout, in the JSON and on a page. */
static gp_status report_pair(struct run *r, int result, const char *why)
{
    gp_status st = GP_OK;
    struct gp_compare_row *const row = &r->row;
    row->result = result;
    row->why = why;
    r->count[result]++;
    if (result > r->worst)
        r->worst = result;
    json_t *const facts =
        r->json || r->s->page.html ? row_json(row, r->frames.n > 0) : NULL;
    if (r->json) { // an object a line
        char *const text = gp_json_print(json_incref(facts),
                                         JSON_COMPACT | JSON_REAL_PRECISION(9));
        st = text ? gp_file_write(r->json, text, strlen(text))
                  : gp_no_memory(r->log, r->s->bench.json);
        st = st ? st : gp_file_write(r->json, "\n", 1);
        free(text);
    }
    if (in_full(r))
        print_part(row, &r->s->compare);
    else if (prints(r))
        print_frame(row);
    if (r->s->page.html && !st)
        st = gp_compare_pages_add(&r->pages, row, facts);
    json_decref(facts);
    return st;
}

/* Writes a picture of the frame, once: FLIP at each pixel, or the difference. */
static gp_status draw(struct run *r, int which)
{
    struct glarepp_image map = GLAREPP_IMAGE;
    struct gp_write_stats stats = {0};
    struct gp_frame f = gp_frame_blank(r->row.facts->window);
    gp_status st;
    f.path = gp_pattern_name(&r->picture[which], r->row.frame, NULL);
    if (!f.path)
        GP_TRY(gp_no_memory(r->log, r->picture[which].path));
    if (which == HEATMAP) {
        GP_TRY(glarepp_compare_view(r->row.compare, -1, false, 1.0f, &map));
        const struct gp_planes shown = {
            {map.plane[0], map.plane[1], map.plane[2]}};
        GP_TRY(gp_write_picture(r->log, &r->write, f.path, &f, &shown,
                                GP_PICTURE_SHOWN, &stats));
    } else
        GP_TRY(draw_difference(r, &f));
    r->drawn[which] = true;
out:
    glarepp_image_end(&map);
    gp_frame_free(&f);
    return st;
}

/* Has the library compare two images, by all limits of the command line. */
static gp_status compare_images(struct run *r,
                                const struct gp_stored_image image[2])
{
    gp_status st;
    struct glarepp_compare *compare = NULL;
    const struct gp_compare_settings *const p = &r->s->compare;
    const double *const e = p->flip_exposures.v;
    struct glarepp_compare_params limits = p->limits;
    struct glarepp_stored stored[2];
    bool unwritten = false;
    limits.most = r->s->input.read.max_pixels;
    limits.start = (float) e[0];
    limits.stop = (float) e[1];
    limits.exposures = p->flip_exposures.n ? (int) e[2] : 0;
    for (int k = 0; k < 2; k++) {
        stored[k] = gp_stored_view(&image[k], k ? r->row.b : r->row.a);
        r->row.image[k] = &image[k];
    }
    GP_TRY(glarepp_compare(r->gp, &limits, &stored[0], &stored[1], &compare));
    const struct glarepp_compare_facts *const f =
        glarepp_compare_facts(compare);
    r->row.compare = compare;
    r->row.facts = f;
    if (p->heatmap && !f->has_flip)
        gp_say(r->log, GP_LEVEL_WARN, "%s: has no colour for FLIP; --heatmap "
               "is not written", r->row.a);
    else if (p->heatmap && !r->drawn[HEATMAP])
        GP_TRY(draw(r, HEATMAP));
    if (p->difference && image[0].first) {
        gp_say(r->log, GP_LEVEL_WARN, "%s: is deep; --difference is not "
               "written", r->row.a);
    } else if (p->difference && !r->drawn[DIFFERENCE] &&
               (f->max > 0.0 || !p->only_different)) {
        st = draw(r, DIFFERENCE);
        unwritten = st == GP_ERR_IO;
        GP_TRY(unwritten ? GP_OK : st);
    }
    if (!f->lit && (p->limits.perceptual || isfinite(p->limits.fail_flip)))
        GP_TRY(report_pair(r, GP_COMPARE_DIFFERENT,
                           "one has no colour, which --perceptual and "
                           "--fail-flip need"));
    else
        GP_TRY(report_pair(r, f->result, NULL));
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
    r->row = (struct gp_compare_row) {
        .a = path[0], .b = path[1], .frame = frame, .parts = 1};
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
        if (!st && !image[0].first != !image[1].first)
            st = report_pair(r, GP_COMPARE_DIFFERENT,
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
        st = report_pair(r, GP_COMPARE_FAILURE, why);
    }
    if (!st && !all && in_full(r) && (f[0].parts > 1 || f[1].parts > 1))
        printf("Only compared the first part (of %d and %d, respectively); -a "
               "compares all\n", f[0].parts, f[1].parts);
    if (st && st != GP_ERR_BUG)
        st =
            report_pair(r, GP_COMPARE_FILE, "a file cannot be read or written");
    if (!st)
        st = gp_compare_pages_write(&r->pages, frame, false);
    for (int i = 0; i < 2; i++) {
        gp_stored_close(&f[i]);
        free(path[i]);
    }
    return st;
}

// -- the whole run -----------------------------------------------------------

/* Adds the names of all frames to the guard: as inputs, or as what an option
 * writes. */
static gp_status add_names(const struct run *r, struct gp_output_guard *c,
                           const struct gp_pattern *p, const char *option)
{
    gp_status st = GP_OK;
    for (int i = 0; i < gp_max(r->frames.n, 1) && !st; i++) {
        char *const name =
            gp_pattern_name(p, r->frames.n ? r->frames.number[i] : 0, NULL);
        st = !name    ? gp_no_memory(r->log, p->path)
             : option ? gp_output_guard_add(c, name, option, p->path, NULL)
                      : gp_output_guard_input(c, "input", name);
        free(name);
    }
    return st;
}

/* Checks that no picture replaces a compared file or another output. */
static gp_status check_names(const struct run *r)
{
    static const char *const option[] = {"--heatmap", "--difference"};
    struct gp_output_guard c = {.log = r->log, .s = r->s};
    gp_status st;
    if (r->pages.pattern.len)
        GP_TRY(add_names(r, &c, &r->pages.pattern, "--html"));
    for (int i = 0; i < PICTURES; i++) {
        if (r->picture[i].path)
            GP_TRY(add_names(r, &c, &r->picture[i], option[i]));
    }
    GP_TRY(gp_output_guard_settle(&c));
    for (int i = 0; i < 2 && c.exists; i++)
        GP_TRY(add_names(r, &c, &r->in[i], NULL));
out:
    gp_output_guard_end(&c);
    return st;
}

/* Finds files and frames, and checks the names of outputs before any work. */
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
        const char *const path = r->picture[i].path;
        if (!path)
            continue;
        GP_TRY(gp_pattern_find(r->log, path, &r->picture[i]));
        if (sequence && !r->picture[i].len)
            return gp_fail(r->log, GP_ERR_USAGE,
                           "%s: one name for all frames "
                           "of a sequence; write a pattern, e.g. heat.####.png",
                           path);
        // the pair is compared even where its difference cannot be written
        if (i == HEATMAP || gp_write_check(NULL, &r->write, path) != GP_ERR_IO)
            GP_TRY(gp_write_check(r->log, &r->write, path));
    }
    GP_TRY(gp_compare_pages_begin(r->log, r->s, r->frames.n, &r->pages));
    GP_TRY(check_names(r));
    if (json)
        GP_TRY(gp_file_open(r->log, json, false, false, &r->json));
out:
    gp_frames_free(&more);
    return st;
}

gp_status gp_compare_command(const struct gp_log *log, struct glarepp *gp,
                             const struct gp_settings *s, int *status)
{
    struct run r = {
        .log = log,
        .gp = gp,
        .s = s,
        .write = s->output.write,
        .picture = {{.path = s->compare.heatmap},
                    {.path = s->compare.difference}},
    };
    char *command = NULL;
    gp_status st;
    if (!s->output.no_provenance &&
        (s->compare.heatmap || s->compare.difference))
        GP_TRY(gp_command_text(log, s, s->input.files.at, s->input.files.n,
                               GP_COMMAND_NAMES, &command));
    r.write.command = command;
    r.write.dither = GP_DITHER_NEVER; // equal values become equal codes
    GP_TRY(find_frames(&r));
    if (!r.frames.n)
        GP_TRY(compare_frame(&r, 0));
    for (int i = 0; i < r.frames.n; i++)
        GP_TRY(compare_frame(&r, r.frames.number[i]));
    if (prints(&r) && r.frames.n) {
        printf("%d frames: %s", r.frames.n, result_words[r.worst]);
        for (int i = 0; i <= GP_COMPARE_FILE; i++) {
            if (r.count[i])
                printf(", %d %s", r.count[i], result_words[i]);
        }
        putchar('\n');
    }
    if (prints(&r))
        puts(r.worst == GP_COMPARE_MATCH     ? "PASS"
             : r.worst == GP_COMPARE_WARNING ? "WARNING"
                                             : "FAILURE");
    else if (!gp_is_dash(s->bench.json) && r.worst >= GP_COMPARE_FAILURE)
        fputs("FAILURE\n", stderr); // as idiff -q
    GP_TRY(gp_flush_stdout(log));
    GP_TRY(gp_compare_pages_write(&r.pages, 0, true));
    if (r.json)
        GP_TRY(gp_file_commit(&r.json));
out:
    gp_file_discard(&r.json);
    free(command);
    gp_frames_free(&r.frames);
    gp_compare_pages_free(&r.pages);
    *status = st == GP_OK          ? r.worst
              : st == GP_ERR_USAGE ? GP_COMPARE_USAGE
              : st == GP_ERR_BUG   ? (int) st : GP_COMPARE_FILE;
    return GP_OK;
}
