#include "app/commands.h"

#include "app/clobber.h"
#include "app/options.h"
#include "app/stages.h"
#include "bench/bench.h"
#include "core/json.h"
#include "gl/gl.h"
#include "io/file.h"
#include "io/write.h"
#include "scene/gltf/gltf.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

// -- files --------------------------------------------------------------------

/* The i-th picture that is asked for: outputs, then kinds of --debug. */
static const char *picture_path(const struct gp_settings *s, int i)
{
    return i < s->output.pictures.n
               ? s->output.pictures.at[i]
               : s->output.debug[GP_DEBUG_SCISSOR + i - s->output.pictures.n];
}

static int pictures(const struct gp_settings *s)
{
    return s->output.pictures.n + GP_DEBUG_SETS - GP_DEBUG_SCISSOR + 1;
}

/* Checks that no picture replaces the scene or another output. */
static gp_status check_names(const struct gp_log *log,
                             const struct gp_settings *s)
{
    struct gp_clobber c;
    gp_status st;
    GP_TRY(gp_clobber_begin(log, s, &c));
    for (int i = 0; i < pictures(s); i++) {
        const char *const path = picture_path(s, i);
        if (!path)
            continue;
        GP_TRY(gp_write_check(log, &s->output.write, path));
        GP_TRY(gp_clobber_add(&c, &(struct gp_clobber_output) {
            .name = path, .what = i < s->output.pictures.n ? "-o" : "--debug",
            .as = path, .order = i}));
    }
    GP_TRY(gp_clobber_settle(&c));
    GP_TRY(gp_clobber_input(&c, "scene", s->input.files.at[0]));
out:
    gp_clobber_end(&c);
    return st;
}

static gp_status write_pictures(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_scene *scene,
    const struct gp_camera *c, const struct gp_table *t)
{
    const int w = s->making.w, h = s->making.h;
    const size_t n = (size_t) w * (size_t) h;
    struct gp_write_stats stats = {0};
    struct gp_frame f = gp_frame_blank((struct gp_rect) {0, 0, w, h});
    gp_status st = gp_planes_make(log, "picture", n, &f.rgb);
    for (int i = 0; i < pictures(s) && !st; i++) {
        const char *const path = picture_path(s, i);
        const bool scissor = i == s->output.pictures.n;
        if (!path)
            continue;
        if (i < s->output.pictures.n) {
            for (size_t k = 0; k < 3 * n; k++)
                f.rgb.c[k / n][k % n] = t->picture[4 * (k % n) + k / n];
        } else if (scissor) {
            gp_sets_draw_scissors(t, scene->lights, w, h, &f.rgb);
        } else {
            st = gp_sets_draw_map(log, t, scene, c, w, h, &f.rgb);
        }
        if (st)
            break;
        st = gp_write_picture(log, &s->output.write, path, &f, &f.rgb,
                              i < s->output.pictures.n ? GP_PICTURE_SCENE
                                               : GP_PICTURE_SHOWN, &stats);
    }
    gp_frame_free(&f);
    return st;
}

// -- the table ----------------------------------------------------------------

static void print_table(const struct gp_settings *s,
                        const struct gp_scene *scene, const struct gp_table *t,
                        const char *gl)
{
    const struct gp_table_row *const first = &t->row[0];
    printf("%s: %d objects, %d lights, %dx%d, %s\n",
           gp_printable(scene->path).text, scene->objects, scene->lights,
           s->making.w, s->making.h, gl);
    printf("%-12s %7s %7s %6s %7s %10s %8s  %s\n", "sets", "visible", "batches",
           "lights", "passes", "fragments", "ms", "of the first: batches, "
           "fragments, speed");
    for (int i = 0; i < GP_TABLE_ROWS; i++) {
        const struct gp_table_row *const r = &t->row[i];
        char fragments[24] = "-", ratio[24] = "-";
        if (r->fragments >= 0) {
            snprintf(fragments, sizeof fragments, "%lld", r->fragments);
            snprintf(ratio, sizeof ratio, "%.3f", (double) r->fragments /
                     fmax((double) first->fragments, 1.0));
        }
        printf("%-12s %7d %7d %6d %7d %10s %8.2f  %.3f %s %.2f%s\n",
               gp_table_names[i], r->visible, r->drawn.batches, r->drawn.lights,
               r->drawn.passes, fragments, r->ms, (double) r->drawn.batches /
               fmax(first->drawn.batches, 1.0), ratio, first->ms / r->ms,
               r->same ? "" : "  another picture");
    }
}

static json_t *row_json(const struct gp_table_row *r, const char *name)
{
    return json_pack(
        "{ss si si si si si si si si sI sf sf sb}", "sets", name, "visible",
        r->visible, "lit", r->lit, "casters", r->casters, "lights",
        r->drawn.lights, "passes", r->drawn.passes, "batches",
        r->drawn.batches, "shadow_batches", r->drawn.shadow_batches,
        "batches_separate", r->batches[0], "fragments",
        (json_int_t) r->fragments, "ms", r->ms, "cpu_ms", r->cpu_ms,
        "same_picture", r->same);
}

static gp_status save_json(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_scene *scene,
    const struct gp_table *t, const char *gl)
{
    json_t *const rows = json_array(), *const lights = json_array();
    for (int i = 0; i < GP_TABLE_ROWS; i++)
        json_array_append_new(rows, row_json(&t->row[i], gp_table_names[i]));
    for (int i = 0; i < scene->lights; i++) {
        const struct gp_table_light *const l = &t->light[i];
        const bool off = gp_rect_empty(l->rect);
        json_t *const o = json_pack("{so}", "name",
                                    gp_json_name(scene->light[i].name));
        json_object_set_new(o, "scissor", off ? json_null()
                            : json_pack("[iiii]", l->rect.x0, l->rect.y0,
                                        l->rect.x1, l->rect.y1));
        if (!off)
            json_object_set_new(o, "depth", json_pack("[ff]", l->near, l->far));
        json_array_append_new(lights, o);
    }
    return gp_bench_save_json(log, json_pack(
        "{so s[ii] ss sf si si so so}", "scene", gp_json_name(scene->path),
        "size", s->making.w, s->making.h, "gl", gl, "time", scene->time,
        "objects", scene->objects, "shadow_size", s->table.draw.map, "rows",
        rows, "lights", lights), s->bench.json);
}

// -- the command --------------------------------------------------------------

static gp_status find_camera(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_scene *scene,
    struct gp_table_params *p, struct gp_camera *out)
{
    const double aspect = (double) s->making.w / s->making.h;
    const struct gp_scene_camera *const c =
        gp_scene_find_camera(scene, s->scene.camera);
    if (!c && s->scene.camera)
        return gp_scene_no_camera(log, scene, s->scene.camera);
    if (!c)
        return gp_fail(log, GP_ERR_DATA, "%s: %d cameras; sets are those of one "
                       "camera, name it with --scene-camera", scene->path,
                       scene->cameras);
    if (c->near > 0.0)
        p->draw.near = c->near;
    return gp_scene_camera_make(log, scene, c, aspect, out);
}

gp_status gp_sets_command(const struct gp_log *log, const struct gp_settings *s,
                          bool *differ)
{
    struct gp_scene scene = {0};
    struct gp_camera camera;
    struct gp_gl *gl = NULL;
    struct gp_table t = {0};
    struct gp_table_params p = s->table;
    const struct gp_scene_images images = gp_scene_images_of(s);
    gp_status st;
    *differ = false;
    p.draw.w = s->making.w;
    p.draw.h = s->making.h;
    GP_TRY(check_names(log, s));
    GP_TRY(gp_scene_read(log, s->input.files.at[0], GP_UP_Y, &images, &scene));
    gp_scene_pose(&scene, gp_option_given(s, "time") ? (double) s->scene.time
                                                      : scene.start);
    GP_TRY(find_camera(log, s, &scene, &p, &camera));
    GP_TRY(gp_gl_open(log, s->glare.gl, &gl));
    GP_TRY(gp_table_make(log, gl, &scene, &camera, &p, &t));
    for (int i = 0; i < GP_TABLE_ROWS; i++)
        *differ = *differ || !t.row[i].same;
    if (!s->bench.json || strcmp(s->bench.json, "-") != 0)
        print_table(s, &scene, &t, gp_gl_info(gl)->name);
    if (s->bench.json)
        GP_TRY(save_json(log, s, &scene, &t, gp_gl_info(gl)->name));
    GP_TRY(write_pictures(log, s, &scene, &camera, &t));
    st = gp_flush_stdout(log);
out:
    gp_table_free(&t);
    gp_gl_close(&gl);
    gp_scene_free(&scene);
    return st;
}
