// SPDX-License-Identifier: Apache-2.0
/* glTF scenes: read, posed, turned, and their cameras compared. */
#include "core/memory.h"
#include "harness.h"
#include "scene/gltf/gltf.h"

#include <math.h>
#include <stdlib.h>

/* Touches the bytes of a picture, and gives two samples. */
static gp_status give_alpha(void *user, const struct gp_log *log,
                            const char *name, const void *bytes, size_t n,
                            long long most, struct gp_cutout *out)
{
    (void) user;
    (void) name;
    (void) most;
    if (bytes)
        fuzz_touch(bytes, n);
    out->w = 2;
    out->h = 1;
    return gp_alloc_zero(log, "a texture", 2, sizeof *out->alpha, &out->alpha);
}

/* Ends the program unless all that is posed is finite and in range. */
static void check_scene(const struct gp_scene *s)
{
    for (int i = 0; i < s->indices; i++) {
        if (s->index[i] >= (uint32_t) s->vertices)
            abort();
    }
    for (int i = 0; i < s->submeshes; i++) {
        const struct gp_submesh *const p = &s->submesh[i];
        if (p->first < 0 || p->count % 3 || p->first + p->count > s->indices ||
            p->material < 0 || p->material >= s->materials)
            abort();
    }
    for (int i = 0; i < s->materials; i++) {
        if (s->material[i].cutout >= s->cutouts)
            abort();
    }
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        if (o->mesh < 0 || o->mesh >= s->meshes || !isfinite(o->radius) ||
            !isfinite(o->box.lo.x + o->box.hi.z) || o->box.lo.x > o->box.hi.x)
            abort();
    }
    for (int i = 0; i < s->lights; i++) {
        const struct gp_scene_light *const l = &s->light[i];
        if (!isfinite(l->at.x) || fabs(gp_v3_length(l->along) - 1.0) > 1e-6)
            abort();
    }
}

static void use_scene(struct gp_scene *s)
{
    static const struct gp_rect display = {0, 0, 8, 6};
    struct gp_camera camera;
    check_scene(s);
    gp_scene_turn(s, GLAREPP_UP_Z);
    for (int k = -1; k <= 3; k++) {
        gp_scene_pose(s, s->start + (s->end - s->start) * (double) k / 2.0);
        check_scene(s);
    }
    for (int i = 0; i < s->cameras && i < 4; i++) {
        if (fuzz_line(gp_scene_camera_make(&fuzz_log, s, &s->camera[i], 1.5,
                                           &camera)))
            continue;
        const enum glarepp_up up = gp_scene_find_up(s, &camera);
        if ((up != GLAREPP_UP_Y && up != GLAREPP_UP_Z) ||
            isnan(gp_scene_apart(s, &camera, &camera, display)))
            abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    // the reader's own bar (scene/gltf/gltf.h), and the harness's
    const uint64_t allowed = FUZZ_FIXED + (64u << 20) + 432u * size;
    static const struct gp_scene_images images = {NULL, give_alpha};
    const char *const path = fuzz_file(data, size);
    struct gp_scene s = {0};
    fuzz_begin();
    if (path &&
        !fuzz_line(gp_scene_read(&fuzz_log, path, GLAREPP_UP_AUTO, &images,
                                 &s))) {
        use_scene(&s);
        gp_scene_free(&s);
    }
    fuzz_end(allowed);
    fuzz_file_close();
    return 0;
}
