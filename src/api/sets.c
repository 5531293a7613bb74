// SPDX-License-Identifier: Apache-2.0
/* O'Rorke's table of a scene. */
#include "api/api.h"

#include "core/memory.h"
#include "scene/gltf/gltf.h"
#include "scene/sets/sets.h"

#include <string.h>

struct own {
    struct gp_scene scene;
    struct gp_camera camera;
    struct gp_table table;
    struct glarepp *gp;
    int w, h;
    struct gp_planes view;   // of the last glarepp_sets_view()
    char gl[sizeof ((struct gp_gl_info *) 0)->name];
    const char **light;      // `scene.lights` of each
    struct glarepp_rect *scissor;
    double (*depth)[2];
};

/* Makes the camera; its near plane, where it has one, is the table's. */
static gp_status find_camera(const struct gp_log *log,
    struct glarepp_sets_params *p, struct own *own)
{
    const struct gp_scene *const s = &own->scene;
    const struct gp_scene_camera *const c = gp_scene_find_camera(s, p->camera);
    if (!c && p->camera)
        return gp_scene_no_camera(log, s, p->camera);
    if (!c)
        return gp_fail_at(log, GP_ERR_DATA, "sets.camera", "%s: %d cameras; "
                          "sets are those of one camera", s->path, s->cameras);
    if (c->near > 0.0)
        p->near = c->near;
    return gp_scene_camera_make(log, s, c, (double) p->w / p->h, &own->camera);
}

/* Points *out to what `own` keeps. */
static gp_status fill(const struct gp_log *log, struct own *own,
                      struct glarepp_sets *out)
{
    const size_t n = (size_t) own->scene.lights + 1;
    gp_status st;
    GP_TRY(gp_alloc(log, "lights", n, sizeof *own->light, &own->light));
    GP_TRY(gp_alloc(log, "lights", n, sizeof *own->scissor, &own->scissor));
    GP_TRY(gp_alloc(log, "lights", n, sizeof *own->depth, &own->depth));
    for (int i = 0; i < own->scene.lights; i++) {
        const struct gp_scissor *const l = &own->table.light[i];
        own->light[i] = own->scene.light[i].name;
        own->scissor[i] = l->rect;
        own->depth[i][0] = l->near;
        own->depth[i][1] = l->far;
    }
    _Static_assert(sizeof out->row == sizeof own->table.row, "all rows");
    memcpy(out->row, own->table.row, sizeof out->row);
    out->objects = own->scene.objects;
    out->lights = own->scene.lights;
    out->seconds = own->scene.time;
    out->gl = own->gl;
    out->light = own->light;
    out->scissor = own->scissor;
    out->depth = (const double (*)[2]) own->depth;
out:
    return st;
}

int glarepp_sets(struct glarepp *gp, const struct glarepp_sets_params *params,
                 struct glarepp_sets *out)
{
    struct glarepp *const outer = gp_api_begin(gp);
    struct glarepp_sets_params p = GLAREPP_SETS_PARAMS;
    struct gp_gl *gl = NULL;
    struct own *own;
    gp_status st;
    memset(out, 0, sizeof *out);
    GP_TRY(gp_api_params(&gp->log, "sets", &p, sizeof p, params));
    GP_TRY(gp_alloc_zero(&gp->log, "sets", 1, sizeof *own, &own));
    out->own = own;
    own->gp = gp;
    own->w = p.w;
    own->h = p.h;
    GP_TRY(gp_api_scene_read(gp, &gp->log, p.path, p.up, &own->scene));
    gp_scene_pose(&own->scene, p.timed ? p.seconds : own->scene.start);
    GP_TRY(find_camera(&gp->log, &p, own));
    GP_TRY(gp_gl_open(&gp->log, (enum gp_gl_api) p.gl, &gl));
    memcpy(own->gl, gp_gl_info(gl)->name, sizeof own->gl);
    GP_TRY(gp_table_make(&gp->log, gl, &own->scene, &own->camera, &p,
                         &own->table));
    GP_TRY(fill(&gp->log, own, out));
out:
    gp_gl_close(&gl);
    if (st)
        glarepp_sets_end(out);
    return gp_api_end(outer, st);
}

void glarepp_sets_end(struct glarepp_sets *sets)
{
    struct own *const own = sets->own;
    if (own) {
        gp_planes_free(&own->view);
        gp_table_free(&own->table);
        gp_scene_free(&own->scene);
        gp_free(own->light);
        gp_free(own->scissor);
        gp_free(own->depth);
    }
    gp_free(own);
    memset(sets, 0, sizeof *sets);
}

int glarepp_sets_view(struct glarepp_sets *sets, enum glarepp_view view,
                      struct glarepp_image *out)
{
    struct own *const own = sets->own;
    const struct gp_log *const log = &own->gp->log;
    struct glarepp *const outer = gp_api_begin(own->gp);
    const size_t n = (size_t) own->w * (size_t) own->h;
    gp_status st = GP_OK;
    if (!own->view.c[0])
        GP_TRY(gp_planes_make(log, "picture", n, &own->view));
    switch (view) {
    case GLAREPP_LIT:
        for (size_t k = 0; k < 3 * n; k++)
            own->view.c[k / n][k % n] =
                own->table.picture[4 * (k % n) + k / n];
        break;
    case GLAREPP_SHOWN:
        gp_sets_draw_scissors(&own->table, own->scene.lights, own->w, own->h,
                              &own->view);
        break;
    case GLAREPP_SOURCES:
        gp_sets_draw_map(&own->table, &own->scene, &own->camera, own->w, own->h,
                         &own->view);
        break;
    default:
        GP_TRY(gp_fail_at(log, GP_ERR_USAGE, "view", "sets: no such picture "
                          "(found %d)", (int) view));
    }
    *out = gp_api_view(&own->view, (struct gp_rect) {0, 0, own->w, own->h},
                       NULL);
out:
    return gp_api_end(outer, st);
}
