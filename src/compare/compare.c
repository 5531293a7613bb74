#include "compare/compare_priv.h"

#include "core/json.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "io/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One part of one pair of files, and its result; all is borrowed. */
struct row {
    const char *a, *b;   // files
    int frame;           // of a sequence
    int part, parts;     // parts > 1: printed beside the name
    enum gp_compare_result result;
    const char *why;     // of DIFFERENT and FILE, which have no figures; else
                         // NULL
    const struct gp_compare_match *match;
    const struct gp_compare_figures *figures;
    const struct gp_compare_flip *flip;
};

/* A run, and its present pair. */
struct run {
    const struct gp_log *log;
    const struct gp_compare_request *req;
    struct gp_compare_names names;
    FILE *json;                    // NULL: not wanted
    bool full;                     // a line of it could not be written
    enum gp_compare_result worst;
    int count[GP_COMPARE_FILE + 1];

    struct row row;
    bool drawn, subtracted;        // the pair has its pictures
};

/* True when the figures are printed for readers. */
static bool prints(const struct run *r)
{
    return r->log->level != GP_LEVEL_ERROR && !gp_is_dash(r->req->json);
}

// -- text --------------------------------------------------------------------

static const char *result_word(enum gp_compare_result r)
{
    static const char *const word[] = {
        [GP_COMPARE_MATCH] = "match", [GP_COMPARE_WARNING] = "warning",
        [GP_COMPARE_FAILURE] = "failure", [GP_COMPARE_DIFFERENT] = "different",
        [GP_COMPARE_FILE] = "file error",
    };
    return word[r];
}

static void print_worst(const struct row *r)
{
    const struct gp_compare_figures *const f = r->figures;
    printf("%g", f->max);
    if (f->max > 0.0)
        printf(" @ (%d, %d, %s)", f->x, f->y,
               gp_printable(gp_compare_name(r->match, f->channel)).text);
}

/* The values of all channels of an image at the largest error. */
static void print_values(const struct row *r, bool of_b, const char *before)
{
    for (int i = 0; i < r->match->pairs; i++) {
        const struct gp_compare_pair *const p = &r->match->pair[i];
        if (!(of_b ? p->b : p->a))
            continue;
        printf("%s%g", before, gp_compare_value(r->match, of_b, i,
                                                r->figures->x, r->figures->y));
        before = ", ";
    }
}

static void print_count(long long n, long long of, double limit)
{
    printf("  %lld pixels (%.3g%%) over %g\n", n,
           100.0 * (double) n / (double) of, limit);
}

/* Prints the figures of a part: idiff's lines, then our own. */
static void print_block(const struct row *r, const struct gp_compare_params *p)
{
    const struct gp_compare_figures *const f = r->figures;
    if (r->why) {
        printf("  %s%s\n", r->parts > 1 ? "parts: " : "",
               gp_printable(r->why).text);
        return;
    }
    const struct gp_compare_match *const m = r->match;
    const struct gp_rect a = m->a->data, b = m->b->data;
    if (p->all_parts && r->parts > 1)
        printf("Subimage %d : ", r->part);
    if (p->all_parts)
        printf("%d x %d, %d channels\n", gp_rect_w(a), gp_rect_h(a),
               m->a->channels);
    printf("  Mean error = %g\n  RMS error = %g\n  Peak SNR = %g\n"
           "  Max error  = ", f->mean, f->rms, f->psnr);
    print_worst(r);
    if (f->max > 0.0 && !m->a->deep) {
        print_values(r, false, "  values are ");
        print_values(r, true, " vs ");
    }
    putchar('\n');
    print_count(f->warned, f->pixels, (double) p->warn);
    print_count(f->failed, f->pixels, (double) p->fail);
    if (p->perceptual)
        printf("  %lld pixels (%3g%%) failed the perceptual test\n", f->seen,
               100.0 * (double) f->seen / (double) f->pixels);
    printf("  rel_l2 = %g\n", f->rel_l2);
    if (!isnan(f->max_rel))
        printf("  max_rel = %g\n", f->max_rel);
    if (r->flip->known)
        printf("  %s = %.6f", r->flip->hdr ? "HDR-FLIP" : "LDR-FLIP",
               r->flip->mean);
    if (r->flip->known && r->flip->hdr)
        printf(" (exposures %.4g to %.4g EV, %d)",
               (double) r->flip->exposures.start,
               (double) r->flip->exposures.stop, r->flip->exposures.count);
    if (r->flip->known)
        putchar('\n');
    if (f->uneven)
        printf("  %lld pixels differ in their number of samples, the first at "
               "(%d, %d)\n", f->uneven, f->uneven_x, f->uneven_y);
    if (f->nonfinite)
        printf("  %lld values that are NaN or infinite differ\n",
               f->nonfinite);
    for (int i = 0; i < m->pairs; i++) {
        const struct gp_compare_pair *const at = &m->pair[i];
        const bool both = at->a && at->b;
        if (both && strcmp(at->a->name, at->b->name) == 0)
            continue;
        if (both)
            printf("  channel %s is compared with %s of B, by its number\n",
                   gp_printable(at->a->name).text,
                   gp_printable(at->b->name).text);
        else
            printf("  channel %s is only in %s (0 in the other)\n",
                   gp_printable(gp_compare_name(m, i)).text,
                   at->a ? "A" : "B");
    }
    if (memcmp(&a, &b, sizeof a) != 0)
        printf("  windows %dx%d at (%d, %d) and %dx%d at (%d, %d); 0 "
               "outside\n", gp_rect_w(a), gp_rect_h(a), a.x0, a.y0,
               gp_rect_w(b), gp_rect_h(b), b.x0, b.y0);
}

// -- JSON --------------------------------------------------------------------

static json_t *make_real(double v)
{
    return isfinite(v) ? json_real(v) : json_null();
}

/* An object of a row; numbers that are not finite are null. */
static json_t *make_json(const struct row *r, bool numbered)
{
    json_t *const o = json_pack("{so so so* so* ss si so*}",
        "a", gp_json_name(r->a), "b", gp_json_name(r->b),
        "frame", numbered ? json_integer(r->frame) : NULL,
        "part", r->parts > 1 ? json_integer(r->part) : NULL,
        "result", result_word(r->result), "status", (int) r->result,
        "why", r->why ? gp_json_name(r->why) : NULL);
    if (r->why)
        return o;
    const struct gp_compare_figures *const f = r->figures;
    const struct gp_compare_flip *const flip = r->flip;
    const struct gp_flip_exposures *const e = &flip->exposures;
    json_t *const worst = !(f->max > 0.0) ? NULL : json_pack(
        "{si si so so so}", "x", f->x, "y", f->y,
        "channel", gp_json_name(gp_compare_name(r->match, f->channel)),
        "a", make_real(f->worst_a), "b", make_real(f->worst_b));
    json_t *const figures = json_pack(
        "{so so* so so so so so* so* ss* so* sI sI sI so* so* sI}",
        "max", make_real(f->max), "worst", worst, "mean", make_real(f->mean),
        "rms", make_real(f->rms), "psnr", make_real(f->psnr),
        "rel_l2", make_real(f->rel_l2),
        "max_rel", isnan(f->max_rel) ? NULL : make_real(f->max_rel),
        "flip", flip->known ? make_real(flip->mean) : NULL,
        "flip_kind", !flip->known ? NULL : flip->hdr ? "hdr" : "ldr",
        "flip_exposures", !flip->known || !flip->hdr ? NULL : json_pack("[ffi]",
            (double) e->start, (double) e->stop, e->count),
        "nonfinite", (json_int_t) f->nonfinite,
        "failed", (json_int_t) f->failed, "warned", (json_int_t) f->warned,
        "uneven", !f->uneven ? NULL : json_pack("{sI si si}", "pixels",
            (json_int_t) f->uneven, "x", f->uneven_x, "y", f->uneven_y),
        "seen", f->seen < 0 ? NULL : json_integer(f->seen),
        "pixels", (json_int_t) f->pixels);
    json_object_update(o, figures);
    json_decref(figures);
    return o;
}

// -- one part of one pair ----------------------------------------------------

/* True when figures are printed in full, not in a line for each frame. */
static bool in_full(const struct run *r)
{
    return r->names.frames.n == 0 || r->log->level >= GP_LEVEL_INFO;
}

/* Reports r->row, on stdout and in the JSON. */
static void report_pair(struct run *r, enum gp_compare_result result,
                        const char *why)
{
    struct row *const row = &r->row;
    const bool numbered = r->names.frames.n > 0;
    row->result = result;
    row->why = why;
    r->count[result]++;
    if (result > r->worst)
        r->worst = result;
    if (r->json) { // an object a line
        char *const text = gp_json_print(make_json(row, numbered),
                                         JSON_COMPACT | JSON_REAL_PRECISION(9));
        r->full = r->full || !text || fprintf(r->json, "%s\n", text) <= 0;
        free(text);
    }
    if (prints(r) && in_full(r)) {
        print_block(row, r->req->params);
    } else if (prints(r)) { // one line, for a frame of a sequence
        const struct gp_compare_figures *const f = row->figures;
        printf("%d", row->frame);
        if (row->parts > 1)
            printf(", part %d", row->part);
        printf(": %s; ", result_word(result));
        if (why) {
            printf("%s\n", gp_printable(why).text);
            return;
        }
        printf("max ");
        print_worst(row);
        printf("; mean %g, RMS %g, PSNR %g, rel_l2 %g", f->mean, f->rms,
               f->psnr, f->rel_l2);
        if (row->flip->known)
            printf(", FLIP %.6f", row->flip->mean);
        putchar('\n');
    }
}

/* The name of the frame's picture, into *name: gp_free(). */
static gp_status name_picture(struct run *r, const struct gp_pattern *p,
                              char **name)
{
    free(*name);
    *name = gp_pattern_name(p, r->row.frame, NULL);
    return *name ? GP_OK : gp_no_memory(r->log, p->path);
}

static gp_status compare_images(struct run *r, const struct gp_stored_image *a,
                                const struct gp_stored_image *b)
{
    gp_status st;
    struct gp_compare_match m;
    struct gp_compare_figures figures;
    struct gp_compare_flip flip = {0};
    char *name = NULL;
    bool unwritten = false;
    const struct gp_compare_params *const p = r->req->params;
    GP_TRY(gp_compare_match_make(r->log, a, b, &m));
    // windows far apart would make a union much larger than both files
    const long long w = (long long) m.window.x1 - m.window.x0;
    const long long h = (long long) m.window.y1 - m.window.y0;
    const long long most = r->req->read->max_pixels;
    if (w > most || h > most / w || w > INT32_MAX / 4 || h > INT32_MAX / 4)
        GP_TRY(gp_fail(r->log, GP_ERR_DATA, "%s: its window and that of %s are "
                       "too far apart (%lld x %lld pixels over both, at most "
                       "%lld); crop them, or raise --max-pixels", r->row.a,
                       r->row.b, w, h, most));
    GP_TRY(gp_compare_measure(r->log, p, &m, &figures));
    GP_TRY(gp_compare_flip(r->log, p, &m, &flip));
    if (p->heatmap && !r->drawn && flip.known) {
        GP_TRY(name_picture(r, &r->names.heatmap, &name));
        GP_TRY(gp_compare_heatmap(r->log, r->req->write, name, &m, &flip));
        r->drawn = true;
    } else if (p->heatmap && !flip.known) {
        gp_say(r->log, GP_LEVEL_WARN, "%s: has no colour for FLIP; --heatmap "
               "is not written", r->row.a);
    }
    if (p->difference && !r->subtracted && !a->deep &&
        (figures.max > 0.0 || !p->only_different)) {
        GP_TRY(name_picture(r, &r->names.difference, &name));
        st = gp_compare_subtract(r->log, r->req->write, p, name, &m);
        unwritten = st == GP_ERR_IO;
        GP_TRY(unwritten ? GP_OK : st);
        r->subtracted = true;
    } else if (p->difference && a->deep) {
        gp_say(r->log, GP_LEVEL_WARN, "%s: is deep; --difference is not "
               "written", r->row.a);
    }
    if (p->perceptual && m.lit)
        GP_TRY(gp_compare_see(r->log, &m, &figures.seen));
    if (!m.lit && (p->perceptual || isfinite(p->fail_flip))) {
        report_pair(r, GP_COMPARE_DIFFERENT,
                    "one has no colour, which --perceptual and --fail-flip "
                    "need");
        goto out;
    }
    r->row.match = &m;
    r->row.figures = &figures;
    r->row.flip = &flip;
    report_pair(r, gp_compare_judge(p, &figures, &flip), NULL);
    if (unwritten && r->row.result < GP_COMPARE_FAILURE)
        st = GP_ERR_IO; // else the difference is the status, as idiff's
out:
    free(name);
    gp_compare_flip_free(&flip);
    gp_compare_match_free(&m);
    return st;
}

/* Compares the files of a frame: their first parts, or part by part. */
static gp_status compare_frame(struct run *r, int frame)
{
    struct gp_stored_file f[2] = {
        {.stream = GP_STREAM_EMPTY}, {.stream = GP_STREAM_EMPTY},
    };
    char *const path[2] = {
        gp_pattern_name(&r->names.in[0], frame, NULL),
        gp_pattern_name(&r->names.in[1], frame, NULL),
    };
    gp_status st = path[0] && path[1]
                       ? GP_OK : gp_no_memory(r->log, r->req->input[0]);
    r->row = (struct row) {.a = path[0], .b = path[1], .frame = frame,
                           .parts = 1};
    r->drawn = r->subtracted = false;
    if (prints(r) && in_full(r) && !st)
        printf("Comparing \"%s\" and \"%s\"\n", gp_printable(path[0]).text,
               gp_printable(path[1]).text);
    for (int i = 0; i < 2 && !st; i++)
        st = gp_stored_open(r->log, r->req->read, path[i], &f[i]);
    const bool all = r->req->params->all_parts;
    const int both = st ? 0 : all ? gp_min(f[0].parts, f[1].parts) : 1;
    if (!st && all)
        r->row.parts = gp_max(f[0].parts, f[1].parts);
    for (int part = 0; part < both && !st; part++) {
        struct gp_stored_image image[2] = {0};
        r->row.part = part;
        for (int i = 0; i < 2 && !st; i++)
            st = gp_stored_read(r->log, r->req->read, &f[i], part, &image[i]);
        if (!st && image[0].deep != image[1].deep)
            report_pair(r, GP_COMPARE_DIFFERENT,
                        "one is deep, the other is not");
        else if (!st)
            st = compare_images(r, &image[0], &image[1]);
        gp_stored_image_free(&image[0]);
        gp_stored_image_free(&image[1]);
    }
    if (!st && r->row.parts > both) { // as idiff -a
        char why[64];
        snprintf(why, sizeof why, "%d parts and %d", f[0].parts, f[1].parts);
        r->row.part = both;
        report_pair(r, GP_COMPARE_FAILURE, why);
    }
    if (!st && !all && prints(r) && in_full(r) &&
        (f[0].parts > 1 || f[1].parts > 1))
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

/* Finds the patterns and frames of the names, and compares them all. */
static gp_status compare_all(struct run *r)
{
    const struct gp_compare_request *const req = r->req;
    struct gp_compare_names *const n = &r->names;
    struct gp_frames more = {0};
    gp_status st = GP_OK;
    for (int i = 0; i < 2; i++)
        GP_TRY(gp_pattern_of_input(r->log, req->input[i], &n->in[i]));
    const bool sequence = n->in[0].len || n->in[1].len;
    if (req->frames && !sequence)
        return gp_fail(r->log, GP_ERR_USAGE, "%s: --frames needs a pattern "
                       "(found plain names); write a pattern, e.g. "
                       "shot.####.exr, or leave --frames out", req->input[0]);
    if (req->frames)
        GP_TRY(gp_frames_parse(r->log, req->frames, &n->frames));
    for (int i = 0; i < 2 && !req->frames; i++) {
        if (!n->in[i].len)
            continue;
        GP_TRY(gp_frames_on_disk(r->log, &n->in[i], NULL, &more));
        if (!gp_frames_join(&n->frames, &more))
            GP_TRY(gp_no_memory(r->log, req->input[i]));
        gp_frames_free(&more);
    }
    // before any work: check that the outputs may be written
    for (int i = 0; i < 2; i++) {
        const char *const picture = i ? req->params->difference
                                      : req->params->heatmap;
        struct gp_pattern *const name = i ? &n->difference : &n->heatmap;
        if (!picture)
            continue;
        GP_TRY(gp_pattern_find(r->log, picture, name));
        if (sequence && !name->len)
            return gp_fail(r->log, GP_ERR_USAGE, "%s: one name for all frames "
                           "of a sequence; write a pattern, e.g. heat.####.png",
                           picture);
        // the pair is compared even where its difference cannot be written
        if (!i || gp_write_check(NULL, req->write, picture) != GP_ERR_IO)
            GP_TRY(gp_write_check(r->log, req->write, picture));
    }
    if (req->json && !gp_is_dash(req->json))
        GP_TRY(gp_file_check(r->log, req->json, false));
    if (req->check_names)
        GP_TRY(req->check_names(r->log, req->user, n));
    if (!n->frames.n)
        GP_TRY(compare_frame(r, 0));
    for (int i = 0; i < n->frames.n; i++)
        GP_TRY(compare_frame(r, n->frames.number[i]));
    if (prints(r) && n->frames.n) {
        printf("%d frames: %s", n->frames.n, result_word(r->worst));
        for (int i = 0; i <= GP_COMPARE_FILE; i++) {
            if (r->count[i])
                printf(", %d %s", r->count[i],
                       result_word((enum gp_compare_result) i));
        }
        putchar('\n');
    }
    if (prints(r))
        puts(r->worst == GP_COMPARE_MATCH     ? "PASS"
             : r->worst == GP_COMPARE_WARNING ? "WARNING" : "FAILURE");
    else if (!gp_is_dash(req->json) && r->worst >= GP_COMPARE_FAILURE)
        fputs("FAILURE\n", stderr); // as idiff -q
out:
    gp_frames_free(&more);
    return st;
}

int gp_compare_run(const struct gp_log *log,
                   const struct gp_compare_request *req)
{
    struct run r = {.log = log, .req = req};
    char *text = NULL;
    size_t size = 0;
    gp_status st;
    r.json = req->json ? open_memstream(&text, &size) : NULL;
    if (req->json && !r.json)
        GP_TRY(gp_no_memory(log, req->json));
    GP_TRY(compare_all(&r));
    if (r.json) {
        const bool lost = ferror(r.json) || r.full;
        const bool closed = fclose(r.json) == 0;
        r.json = NULL;
        if (lost || !closed)
            GP_TRY(gp_no_memory(log, req->json));
    }
    GP_TRY(gp_flush_stdout(log));
    if (req->json)
        GP_TRY(gp_file_save(log, req->json, text, size));
out:
    if (r.json)
        fclose(r.json);
    free(text);
    gp_frames_free(&r.names.frames);
    return st == GP_OK          ? (int) r.worst
           : st == GP_ERR_USAGE ? GP_COMPARE_USAGE
           : st == GP_ERR_BUG   ? (int) st : GP_COMPARE_FILE;
}

gp_status gp_compare_check(const struct gp_log *log, const char *const *inputs,
                           int n, const struct gp_compare_params *p)
{
    const double *const e = p->flip_exposures.v;
    if (n != 2)
        return gp_fail(log, GP_ERR_USAGE, "%s: needs two images (found %d); "
            "write glarepp compare A B", n > 2 ? inputs[2] : "compare", n);
    if (gp_is_dash(inputs[0]) && gp_is_dash(inputs[1]))
        return gp_fail(log, GP_ERR_USAGE,
                       "-: stdin holds only one image; give a file as the "
                       "other");
    if (p->flip_exposures.n &&
        !(e[2] >= 1.0 && e[2] <= GP_FLIP_EXPOSURES_MAX && e[2] == floor(e[2])))
        return gp_fail(log, GP_ERR_USAGE, "--flip-exposures: not a number of "
                       "exposures (found %g); give START,STOP,COUNT with a "
                       "count of 1 to %d", e[2], GP_FLIP_EXPOSURES_MAX);
    if (p->no_flip && (p->heatmap || p->flip_exposures.n))
        return gp_fail(log, GP_ERR_USAGE,
                       "--no-flip: %s needs FLIP; leave one of the two out",
                       p->heatmap ? "--heatmap" : "--flip-exposures");
    if (p->no_flip && isfinite(p->fail_flip))
        return gp_fail(log, GP_ERR_USAGE, "--no-flip: --fail-flip needs FLIP; "
                       "leave one of the two out");
    if (gp_is_dash(p->heatmap) || gp_is_dash(p->difference))
        return gp_fail(log, GP_ERR_USAGE, "--%s: stdout is for the figures "
                       "(found -); give a file",
                       gp_is_dash(p->heatmap) ? "heatmap" : "difference");
    return GP_OK;
}
