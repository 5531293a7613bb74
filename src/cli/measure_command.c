// SPDX-License-Identifier: Apache-2.0
/* glarepp sets, and the command's side of glarepp bench: tables of times. */
#include "cli/commands.h"
#include "cli/listener.h"
#include "cli/page/page.h"
#include "cli/stages.h"
#include "cli/words.h"
#include "core/json.h"
#include "io/file.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ROWS = sizeof ((struct glarepp_sets *) 0)->row /
              sizeof (struct glarepp_sets_row) };

// -- sets: files ---------------------------------------------------------------

/* Writes a picture. */
static gp_status write_picture(const struct gp_log *log,
    const struct gp_settings *s, struct glarepp_sets *sets, const char *path,
    enum glarepp_view view)
{
    struct gp_write_stats stats = {0};
    struct glarepp_image image;
    struct gp_frame f =
        gp_frame_blank((struct gp_rect) {0, 0, s->making.w, s->making.h});
    const gp_status st = (gp_status) glarepp_sets_view(sets, view, &image);
    if (st)
        return st;
    for (int c = 0; c < 3; c++)
        f.rgb.c[c] = image.plane[c]; // borrowed
    return gp_write_picture(log, &s->output.write, path, &f, &f.rgb,
                            view == GLAREPP_LIT ? GP_PICTURE_SCENE
                                                : GP_PICTURE_SHOWN, &stats);
}

// -- sets: the table ----------------------------------------------------------

static void print_table(const struct gp_settings *s,
                        const struct glarepp_sets *sets)
{
    const struct glarepp_sets_row *const first = &sets->row[0];
    printf("%s: %d objects, %d lights, %dx%d, %s\n",
           gp_printable(s->input.files.at[0]).text, sets->objects,
           sets->lights, s->making.w, s->making.h, sets->gl);
    printf("%-12s %7s %7s %6s %7s %10s %8s %8s  %s\n", "sets", "visible",
           "batches", "lights", "passes", "fragments", "ms", "CPU ms",
           "of the first: batches, fragments, speed by CPU");
    for (int i = 0; i < ROWS; i++) {
        const struct glarepp_sets_row *const r = &sets->row[i];
        char fragments[24] = "-", ratio[24] = "-";
        if (r->fragments >= 0) {
            snprintf(fragments, sizeof fragments, "%lld", r->fragments);
            snprintf(ratio, sizeof ratio, "%.3f", (double) r->fragments /
                     fmax((double) first->fragments, 1.0));
        }
        printf("%-12s %7d %7d %6d %7d %10s %8.2f %8.2f  %.3f %s %.2f%s\n",
               r->name, r->visible, r->batches, r->lights, r->passes, fragments,
               r->ms, r->cpu_ms,
               (double) r->batches / fmax(first->batches, 1.0), ratio,
               first->cpu_ms / r->cpu_ms, r->same ? "" : "  another picture");
    }
}

static gp_status save_json(const struct gp_log *log,
    const struct gp_settings *s, const struct glarepp_sets *sets)
{
    json_t *const rows = json_array(), *const lights = json_array();
    for (const struct glarepp_sets_row *r = sets->row; r < sets->row + ROWS;
         r++)
        json_array_append_new(
            rows, json_pack("{ss si si si si si si si si sI sf sf sb}", "sets",
                            r->name, "visible", r->visible, "lit", r->lit,
                            "casters", r->casters, "lights", r->lights,
                            "passes", r->passes, "batches", r->batches,
                            "shadow_batches", r->shadow_batches,
                            "batches_separate", r->separate_batches,
                            "fragments", (json_int_t) r->fragments, "ms", r->ms,
                            "cpu_ms", r->cpu_ms, "same_picture", r->same));
    for (int i = 0; i < sets->lights; i++) {
        const struct gp_rect r = sets->scissor[i];
        const double *const depth = sets->depth[i];
        const bool off = gp_rect_empty(r);
        json_array_append_new(
            lights,
            json_pack(
                "{so so so*}", "name", gp_json_name(sets->light[i]), "scissor",
                off ? json_null() : json_pack("[iiii]", r.x0, r.y0, r.x1, r.y1),
                "depth", off ? NULL : json_pack("[ff]", depth[0], depth[1])));
    }
    return gp_bench_save_json(log, json_pack(
        "{so s[ii] ss sf si si so so}", "scene",
        gp_json_name(s->input.files.at[0]), "size", s->making.w, s->making.h,
        "gl", sets->gl, "time", sets->seconds, "objects", sets->objects,
        "shadow_size", s->sets.map, "rows", rows, "lights", lights),
        s->bench.json);
}

// -- sets: the command --------------------------------------------------------

gp_status gp_sets_command(const struct gp_log *log, struct glarepp *gp,
                          const struct gp_settings *s, int *status)
{
    struct glarepp_sets_params p = s->sets;
    struct glarepp_sets sets = {.own = NULL};
    enum gp_target_kind kind;
    const char *path;
    gp_status st;
    p.path = s->input.files.at[0];
    p.camera = s->scene.camera;
    p.timed = gp_option_given(s, "time");
    p.w = s->making.w;
    p.h = s->making.h;
    p.gl = s->light.layer.gl;
    for (int i = 0; (path = gp_output_at(s, i, &kind)); i++)
        GP_TRY(gp_write_check(log, &s->output.write, path));
    GP_TRY(gp_output_guard_check(log, s, "scene", p.path));
    GP_TRY(glarepp_sets(gp, &p, &sets));
    for (int i = 0; i < ROWS; i++)
        *status |= !sets.row[i].same;
    if (!s->bench.json || strcmp(s->bench.json, "-") != 0)
        print_table(s, &sets);
    if (s->bench.json)
        GP_TRY(save_json(log, s, &sets));
    for (int i = 0; (path = gp_output_at(s, i, &kind)); i++)
        GP_TRY(write_picture(
            log, s, &sets, path,
            kind == GP_TARGET_PICTURE ? GLAREPP_LIT : gp_targets[kind].view));
    st = gp_flush_stdout(log);
out:
    glarepp_sets_end(&sets);
    return st;
}

// -- bench -------------------------------------------------------------------

/* The command's one frame, as a job of a run. */
struct user {
    struct gp_run run;
    struct gp_job job;
    struct gp_frame_state state; // its planes
    json_t *page;                // NULL: not wanted
    struct gp_page_set set;      // pictures of the present frame
};

static void free_planes(struct user *u)
{
    gp_plane_free(&u->state.depth);
    gp_plane_free(&u->state.mask);
    u->state = (struct gp_frame_state) {0};
}

static struct glarepp_frame_params describe(void *user,
                                            const struct gp_frame *f)
{
    return gp_frame_params_of(&((struct user *) user)->job, f);
}

/* Gives a frame depth and coverage; they stay until it is asked again. */
static gp_status give_planes(void *user, const struct gp_log *log,
                             const struct gp_frame *f,
                             struct glarepp_frame *to)
{
    struct user *const u = user;
    free_planes(u);
    u->state = (struct gp_frame_state) {
        .log = log, .job = &u->job, .file = *f, .frame = to,
    };
    return gp_run_occluders(&u->run, &u->state);
}

/* Adds a row's picture to the page, after the exact one. */
static gp_status take_picture(void *user, const struct gp_log *log,
                              const char *row, const char *options,
                              const struct glarepp_image *picture,
                              const struct glarepp_image *exact,
                              const struct glarepp_image *flip)
{
    static const char bench[] = "glarepp bench";
    struct user *const u = user;
    const struct gp_texts *const in = &u->run.s->input.files;
    struct glarepp_image base = *exact, shown = *picture;
    json_t *const about = json_pack("{ss}", "name", row);
    char *command = NULL;
    gp_status st = GP_OK;
    base.primaries = shown.primaries = NULL; // as a display has them
    if (!u->set.n) {
        u->set.window = base.data;
        GP_TRY(gp_page_set_add(log, &u->set,
                               json_pack("{ss}", "name", "the exact layer"),
                               &base, NULL, NULL));
    }
    if (in->n) {
        GP_TRY(gp_command_text(log, u->run.s, in->at, 1, GP_COMMAND_WHOLE,
                               &command));
        json_object_set_new(about, "command",
                            json_sprintf("glarepp%s %s -o out.png",
                                         command + sizeof bench - 1, options));
    }
    free(command);
    return gp_page_set_add(log, &u->set, about, &shown, &base, flip->plane[0]);
out:
    json_decref(about);
    return st;
}

/* Adds a frame to the page. */
static gp_status take_table(void *user, const struct gp_log *log, json_t *frame)
{
    enum { FRAMES = 3 }; // of --paper
    struct user *const u = user;
    const struct gp_settings *const s = u->run.s;
    const size_t room = gp_page_room(s, u->set.n);
    json_t *const name = json_object_get(frame, "input"), *set = NULL;
    json_t *const entry = json_pack(
        "{sO? sO sO sO* sf so}", "label", s->bench.paper ? name : NULL, "table",
        json_object_get(frame, "rows"), "choices",
        json_object_get(frame, "choices"), "whole",
        json_object_get(frame, "whole"), "tolerance",
        (double) s->light.layer.tolerance, "notes", json_array());
    gp_status st = GP_OK;
    if (u->set.n) {
        GP_TRY(gp_page_thumb(log, &u->set, 0, 110, &set));
        json_object_set_new(entry, "thumb", set);
        GP_TRY(gp_page_pack(log, &u->set, s->bench.paper ? room / FRAMES : room,
                            &set));
        json_object_set_new(entry, "set", set);
    }
    json_array_append(json_object_get(u->page, "entries"), entry);
out:
    json_decref(entry);
    json_decref(frame);
    gp_page_set_free(&u->set);
    return st;
}

gp_status gp_bench_command(const struct gp_log *log, struct glarepp *gp,
                           const struct gp_settings *s, int *status)
{
    char *const input =
        s->input.files.n ? (char *) (uintptr_t) s->input.files.at[0] : NULL;
    struct user user = {.run = {.s = s}, .job = {.input = input}};
    struct gp_bench_params params = s->bench;
    const char *const html = params.page = s->page.html;
    const struct gp_bench_request req = {
        .params = &params,
        .gp = gp,
        .input = input,
        .kernel_name = gp_option_given(s, "kernel") ? s->kernel.words.at[0]
                       : s->bench.paper             ? NULL
                                                    : s->light.style,
        .read = &s->input.read,
        .write = &s->output.write,
        .kernel = &s->kernel.p,
        .plan = &s->plan,
        .user = &user,
        .describe = describe,
        .planes = give_planes,
        .picture = take_picture,
        .table = take_table,
    };
    (void) status;
    gp_status st = gp_output_guard_check(log, s, "input", input);
    if (!st && html)
        st = gp_page_make(log, s, "bench",
                          input ? gp_base_name(input) : "bench", &user.page);
    if (!st)
        st = gp_bench_run(log, &req);
    if (!st && html) {
        st = gp_page_save(log, s, html, user.page);
        user.page = NULL;
    }
    json_decref(user.page);
    gp_page_set_free(&user.set);
    free_planes(&user);
    return st;
}
