// SPDX-License-Identifier: Apache-2.0
/* The data's scenes: what Blender and another writer made. Their folder is
 * data_path()'s; without it these tests skip. */
#include "core/memory.h"
#include "kept_log.h"
#include "scene/gltf/gltf.h"
#include "unit.h"

#include <jansson.h>
#include <unistd.h>

/* A texture of one sample, as its picture does not matter here. */
static gp_status give_alpha(void *user, const struct gp_log *log,
                            const char *name, const void *bytes, size_t n,
                            long long most, struct gp_cutout *out)
{
    out->w = out->h = 1;
    return gp_alloc_zero(log, name, 1, sizeof *out->alpha, &out->alpha);
}

static double number(const json_t *o, const char *key, int i)
{
    const json_t *const v = json_object_get(o, key);
    return json_number_value(json_is_array(v) ? json_array_get(v, (size_t) i)
                                              : v);
}

/* Lights and cameras of every frame against the file that Blender wrote beside
 * them, in Blender's world. */
static void check_scene(const char *name, int triangles, int objects)
{
    struct gp_scene s = {0};
    char file[64];
    const struct gp_scene_images images = {NULL, give_alpha};
    double worst = 0.0, camera = 0.0;
    kept_clear();
    snprintf(file, sizeof file, "scenes/%s.glb", name);
    if (access(data_path(file), R_OK) != 0)
        skip_for(NO_DATA);
    assert_ok(gp_scene_read(&kept_log, data_path(file), GLAREPP_UP_AUTO,
                            &images, &s));
    assert_int_equal(kept_lines, 0);
    long long placed = 0;
    for (int i = 0; i < s.objects; i++) {
        const struct gp_mesh *const m = &s.mesh[s.object[i].mesh];
        for (int k = 0; k < m->submeshes; k++)
            placed += s.submesh[m->first + k].count / 3;
    }
    assert_int_equal(placed, triangles);
    assert_int_equal(s.objects, objects);
    snprintf(file, sizeof file, "scenes/%s.camera.json", name);
    json_t *const root = json_load_file(data_path(file), 0, NULL), *o;
    assert_non_null(root);
    gp_scene_turn(&s, GLAREPP_UP_Z);
    size_t k;
    json_array_foreach (json_object_get(root, "lamps"), k, o) {
        const char *const lamp =
            json_string_value(json_object_get(o, "name"));
        int i = 0;
        while (i < s.lights && strcmp(s.light[i].name, lamp) != 0)
            i++;
        assert_true(i < s.lights);
        const struct gp_scene_light *const l = &s.light[i];
        worst = fmax(worst, fabs(l->at.x - number(o, "pos_world", 0)));
        worst = fmax(worst, fabs(l->at.y - number(o, "pos_world", 1)));
        worst = fmax(worst, fabs(l->at.z - number(o, "pos_world", 2)));
        worst = fmax(worst, fabs(l->ball - number(o, "ball_radius_m", 0)));
        worst = fmax(worst, fabs(l->intensity / number(o, "intensity_cd", 0) -
                                 1.0));
        if (l->kind == GP_LIGHT_SPOT)
            worst = fmax(worst, fabs(l->along.z - number(o, "dir_world", 2)));
    }
    json_array_foreach (json_object_get(root, "frames"), k, o) {
        gp_scene_pose(&s, number(o, "time_s", 0));
        for (int i = 0; i < 16; i++) { // theirs looks along +z
            const double v = s.camera[0].to_camera[i] * (i % 4 == 2 ? -1 : 1);
            camera = fmax(
                camera, fabs(v - number(o, "worldToCamera_rowmajor", i)));
        }
        if (s.light[0].kind == GP_LIGHT_DIRECTIONAL)
            worst = fmax(worst, fabs(s.light[0].along.z +
                                     number(o, "sun_dir_world", 2)));
    }
    assert_int_equal(k, json_array_size(json_object_get(root, "frames")));
    print_message("# %s: lights %.1e, camera %.1e from the file beside it\n",
                  name, worst, camera);
    assert_true(worst <= 1e-4);
    assert_true(camera <= 1e-4);
    json_decref(root);
    gp_scene_free(&s);
}

static void the_street_is_where_blender_put_it(void **state)
{
    check_scene("street", 6032, 316);
}

static void the_forest_is_where_blender_put_it(void **state)
{
    check_scene("forest", 34794, 35);
}

/* Files of another writer, without nodes. */
static void definitions_alone_are_a_scene_of_nothing(void **state)
{
    static const char *const files[] = {"gltf/magnum_camera.gltf",
                                        "gltf/magnum_light.gltf"};
    for (size_t i = 0; i < COUNT(files); i++) {
        if (access(data_path(files[i]), R_OK) != 0)
            skip_for(NO_DATA);
        struct gp_scene s = {0};
        kept_clear();
        assert_ok(gp_scene_read(&kept_log, data_path(files[i]), GLAREPP_UP_Y,
                                NULL, &s));
        assert_int_equal(s.lights + s.cameras + s.objects, 0);
        gp_scene_free(&s);
    }
}

SUITE_OF(gltf_data, NULL, NULL, the_street_is_where_blender_put_it,
    the_forest_is_where_blender_put_it,
    definitions_alone_are_a_scene_of_nothing)
