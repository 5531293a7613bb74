// SPDX-License-Identifier: Apache-2.0
/* The whole run: read, glare, tone map, and each way to write the result. */
#include "bench/bench_priv.h"

#include "core/clock.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const double OUTPUT_MS = 1e3; // no further run is started after this

/* A frame that is written again and again. */
struct whole {
    const struct gp_bench *b;
    struct glarepp_frame *frame;
    char folder[200]; // of a file that is written again and again
    struct gp_write_params p;
    struct gp_bench_whole *out;
    struct gp_bench_times steps[3], times[GP_BENCH_OUTPUTS];
};

/* Lists the ways to write: of EXR the job's own first. */
static void list_outputs(const struct whole *w)
{
    static const char *const names[] = {
        "none",  "rle", "zips", "zip",  "piz",
        "pxr24", "b44", "b44a", "dwaa", "dwab",
    };
    struct gp_bench_output *o = w->out->output;
    for (int c = GP_COMPRESSION_AUTO; c <= GP_COMPRESSION_DWAB; c++, o++) {
        o->compression = (enum gp_compression) c;
        o->format = c < GP_COMPRESSION_PXR24 ? "EXR" : "EXR, lossy";
        snprintf(o->options, sizeof o->options, "--hdr --compression %s",
                 c < 0 ? "auto" : names[c]);
    }
    for (int level = 0; level <= GP_PNG_LEVELS; level++, o++) {
        o->png_level = level;
        o->format = "PNG";
        o->usual = level == w->p.png_level;
        snprintf(o->options, sizeof o->options, "-o --png-level %d", level);
    }
    w->out->outputs = (int) (o - w->out->output);
}

/* Writes once; the file is removed at once. */
static gp_status write_once(const struct whole *w, struct gp_bench_output *o,
                            double *ms)
{
    gp_status st;
    char path[sizeof w->folder + 8];
    struct stat file = {0};
    const struct gp_log log = {gp_bench_keep_why, o->why, GP_LEVEL_ERROR};
    const bool exr = strcmp(o->format, "PNG") != 0;
    struct gp_write_params p = w->p;
    struct gp_write_stats stats = {0};
    struct glarepp_image view;
    struct gp_planes planes;
    p.no_clobber = false;
    p.compression = o->compression;
    p.png_level = o->png_level;
    GP_TRY(glarepp_frame_view(w->frame, exr ? GLAREPP_LIT : GLAREPP_SHOWN, 0,
                              &view));
    for (int c = 0; c < 3; c++)
        planes.c[c] = view.plane[c]; // borrowed
    snprintf(path, sizeof path, "%s/o.%s", w->folder, exr ? "exr" : "png");
    const double start = gp_now_ms();
    st =
        exr ? gp_write_hdr(&log, &p, path,
                           &(struct gp_hdr_colour) {w->b->f, planes}, 1, &stats)
            : gp_write_picture(&log, &p, path, w->b->f, &planes,
                               GP_PICTURE_SHOWN, &stats);
    *ms = gp_now_ms() - start;
    if (!st && stat(path, &file) == 0)
        o->bytes = (long long) file.st_size;
    (void) unlink(path);
out:
    if (st && !o->why[0])
        snprintf(o->why, sizeof o->why, "%s", gp_status_text(st));
    return st;
}

/* One round: a frame is read, computed, and written in all ways whose time is not
 * over. The first round makes what later frames keep, and counts for none. */
static gp_status run_round(struct whole *w, struct glarepp_plan *plan,
                           int round)
{
    gp_status st;
    const struct gp_bench_request *const req = w->b->req;
    const bool pipe = strcmp(req->input, "-") == 0; // which is read once
    struct gp_frame f = {0};
    double ms[3], took;
    const double begin = gp_now_ms();
    if (!pipe)
        GP_TRY(gp_read_frame(&w->b->errors, req->read, req->input, &f));
    ms[0] = pipe ? (double) NAN : gp_now_ms() - begin;
    gp_frame_free(&f);
    GP_TRY(glarepp_frame(plan, &w->b->params, &w->frame));
    const double start = gp_now_ms();
    GP_TRY(glarepp_frame_run(w->frame, GLAREPP_SENSE));
    GP_TRY(glarepp_frame_run(w->frame, GLAREPP_KERNEL));
    GP_TRY(glarepp_frame_run(w->frame, GLAREPP_LAYER));
    const double middle = gp_now_ms();
    GP_TRY(glarepp_frame_run(w->frame, GLAREPP_COMPOSE));
    GP_TRY(glarepp_frame_run(w->frame, GLAREPP_TONE));
    GP_TRY(glarepp_frame_run(w->frame, GLAREPP_DONE));
    ms[1] = middle - start;
    ms[2] = gp_now_ms() - middle;
    for (int i = 0; i < 3 && round > 0; i++)
        gp_bench_time(&w->steps[i], ms[i]);
    for (int i = 0; i < w->out->outputs && round > 0; i++) {
        struct gp_bench_output *const o = &w->out->output[i];
        if (!o->why[0] && w->times[i].total < OUTPUT_MS &&
            !write_once(w, o, &took))
            gp_bench_time(&w->times[i], took);
    }
out:
    glarepp_frame_end(&w->frame);
    return st;
}

/* Finds medians, the job's own compression (`auto` writes the same bytes), and the
 * front of each format. */
static void end_outputs(struct whole *w)
{
    struct gp_bench_whole *const out = w->out;
    struct gp_bench_output *const o = out->output;
    for (int i = 0; i < out->outputs; i++) {
        if (w->times[i].n)
            gp_bench_spread(&w->times[i], &o[i].took);
    }
    for (int i = 1; i < out->outputs && o[i].compression <= GP_COMPRESSION_PIZ;
         i++) {
        o[i].usual = o[i].bytes == o[0].bytes;
        if (o[i].usual)
            break;
    }
    memmove(o, o + 1, (size_t) --out->outputs * sizeof *o);
    for (int i = 0; i < out->outputs; i++) {
        o[i].pareto = o[i].took.runs > 0;
        for (int k = 0; k < out->outputs; k++) {
            if (o[k].took.runs && strcmp(o[k].format, o[i].format) == 0 &&
                o[k].took.ms < o[i].took.least && o[k].bytes <= o[i].bytes)
                o[i].pareto = false;
        }
    }
}

gp_status gp_bench_whole_run(const struct gp_bench *b,
                             struct gp_bench_whole *out)
{
    gp_status st;
    struct glarepp_plan_params p = *b->req->plan;
    struct glarepp_plan *plan = NULL;
    struct whole w = {.b = b, .p = *b->req->write, .out = out};
    bool made = false;
    p.kernel = b->kernel;
    p.lights = NULL;
    p.lens = NULL;
    p.scene = NULL;
    list_outputs(&w);
    const char *const tmp = getenv("TMPDIR");
    const int n = snprintf(w.folder, sizeof w.folder, "%s/glarepp-XXXXXX",
                           tmp && tmp[0] ? tmp : "/tmp");
    made = n < (int) sizeof w.folder && mkdtemp(w.folder);
    if (!made)
        GP_TRY(gp_fail(b->log, GP_ERR_IO,
                       "%s: cannot make a folder for outputs (%s); set TMPDIR",
                       w.folder, strerror(errno)));
    GP_TRY(glarepp_plan(b->req->gp, &p, &plan));
    for (int i = 0; i <= b->req->params->runs; i++)
        GP_TRY(run_round(&w, plan, i));
    gp_bench_spread(&w.steps[0], &out->read);
    gp_bench_spread(&w.steps[1], &out->glare);
    gp_bench_spread(&w.steps[2], &out->tone);
out:
    end_outputs(&w);
    if (made)
        (void) rmdir(w.folder);
    glarepp_plan_end(&plan);
    return st;
}
