// SPDX-License-Identifier: Apache-2.0
/* The glTF reader: what is placed where, every form of numbers, and files that
 * are wrong. */
#include "fail.h"
#include "gltf_wrong.h"

static void assert_at(struct gp_v3 p, double x, double y, double z)
{
    if (!(fabs(p.x - x) + fabs(p.y - y) + fabs(p.z - z) < 1e-6))
        fail_msg("at %.9g, %.9g, %.9g; expected %g, %g, %g", p.x, p.y, p.z, x,
                 y, z);
}

/* A triangle (0,0,0) (1,0,0) (0,2,0), with indices. */
static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 2, 0};
static const uint16_t order[4] = {0, 1, 2, 0};
#define TRIANGLE                                                              \
    "'buffers': [{'uri': '%s', 'byteLength': 36}, {'uri': '%s', 'byteLength'" \
    ": 6}], 'bufferViews': [{'buffer': 0, 'byteLength': 36}, {'buffer': 1, "  \
    "'byteLength': 6}], 'accessors': [{'bufferView': 0, 'componentType': "    \
    "5126, 'count': 3, 'type': 'VEC3'}, {'bufferView': 1, 'componentType': "  \
    "5123, 'count': 3, 'type': 'SCALAR'}], 'meshes': [{'name': 'm', "         \
    "'primitives': [{'attributes': {'POSITION': 0}, 'indices': 1}]}]"
#define TRIANGLE_URIS gm_uri(corners, 36), gm_uri(order, 6)

// -- places -------------------------------------------------------------------

static void a_node_is_scaled_turned_and_moved_after_its_parent(void **state)
{
    // parent: 90 degrees round y (x to -z), up by 10; child: x by 3, right by 5
    struct gp_scene s = gm_read(
        gm_write(TRIANGLE ", 'nodes': [{'children': [1], 'rotation': [0, "
                 "0.70710678118654752, 0, 0.70710678118654752], 'translation': "
                 "[0, 10, 0]}, {'mesh': 0, 'scale': [3, 1, 1], 'translation': "
                 "[5, 0, 0]}]", TRIANGLE_URIS),
        GLAREPP_UP_Y);
    assert_int_equal(s.objects, 1);
    assert_int_equal(s.indices, 3);
    assert_int_equal(s.vertices, 3);
    assert_at(s.object[0].box.lo, 0, 10, -8);
    assert_at(s.object[0].box.hi, 0, 12, -5);
    assert_true(fabs(s.object[0].radius - hypot(1.0, 1.5)) < 1e-9);
    gp_scene_free(&s);
    gp_scene_free(&s); // twice is harmless
}

static void a_matrix_is_read_by_columns(void **state)
{
    struct gp_scene s = gm_read(
        gm_write(TRIANGLE ", 'nodes': [{'mesh': 0, 'matrix': [0,1,0,0, -1,0,0,"
                 "0, 0,0,1,0, 7,8,9,1]}]", TRIANGLE_URIS),
        GLAREPP_UP_Y);
    assert_at(s.object[0].box.lo, 5, 8, 9);
    assert_at(s.object[0].box.hi, 7, 9, 9);
    gp_scene_free(&s);
}

static void z_up_turns_the_world(void **state)
{
    struct gp_scene s = gm_read(
        gm_write(TRIANGLE ", 'nodes': [{'mesh': 0, 'translation': [1, 2, 3]}]",
                 TRIANGLE_URIS), GLAREPP_UP_AUTO);
    assert_at(s.object[0].box.lo, 1, 2, 3);
    gp_scene_turn(&s, GLAREPP_UP_Z);
    assert_at(s.object[0].box.lo, 1, -3, 2);
    assert_at(s.object[0].box.hi, 2, -3, 4);
    gp_scene_turn(&s, GLAREPP_UP_Y);
    assert_at(s.object[0].box.lo, 1, 2, 3);
    gp_scene_free(&s);
}

static void only_the_nodes_of_the_scene_are_placed(void **state)
{
    struct gp_scene s = gm_read(
        gm_write(TRIANGLE ", 'nodes': [{'mesh': 0}, {'children': [2]}, {'mesh'"
                 ": 0, 'name': 'in'}, {'mesh': 0}], 'scene': 1, 'scenes': [{"
                 "'nodes': [0, 3]}, {'nodes': [1]}]", TRIANGLE_URIS),
        GLAREPP_UP_Y);
    assert_int_equal(s.objects, 1);
    assert_int_equal(s.object[0].node, 2);
    gp_scene_free(&s);
}

static void lights_have_the_defaults_of_their_extension(void **state)
{
    struct gp_scene s = gm_read(
        gm_write(
            "'extensions': {'KHR_lights_punctual': {'lights': [{'type': "
            "'point', 'name': 'bulb'}, {'type': 'spot', 'spot': {}, 'range'"
            ": 4}, {'type': 'directional', 'color': [1, 0.5, 0], 'extras': "
            "{'angle_deg': "
            "2}}]}}, "
            "'nodes': [{'extensions': {'KHR_lights_punctual': {'light': 0}"
            "}, 'translation': [1, 2, 3], 'extras': {'ball_radius': 0.25}}"
            ", {'name': 'a', 'extensions': {'KHR_lights_punctual': {'light"
            "': 0}}}, {'name': 'b', 'extensions': {'KHR_lights_punctual': "
            "{'light': 1}}, 'rotation': [0, 1, 0, 0]}, {'extensions': {"
            "'KHR_lights_punctual': {'light': 2}}}, {'extensions': {"
            "'KHR_lights_punctual': {'light': 2}}, 'extras': {'angle_deg'"
            ": 0.53}}, {'extensions': {'KHR_lights_punctual': {'light': 2"
            "}}, 'extras': {'angle': 0.01}}]"),
        GLAREPP_UP_Y);
    assert_int_equal(s.lights, 6);
    assert_true(s.light[3].degrees == 2.0 && s.light[4].degrees == 0.53);
    assert_true(fabs(s.light[5].degrees - 0.5729578) < 1e-6);
    assert_int_equal(s.light[0].kind, GP_LIGHT_POINT);
    assert_string_equal(s.light[0].name, "bulb"); // the light's: no node's name
    assert_string_equal(s.light[1].name, "a");
    assert_at(s.light[0].at, 1, 2, 3);
    assert_true(s.light[0].ball == 0.25 && s.light[1].ball == 0.0);
    assert_true(s.light[0].intensity == 1.0 && isinf(s.light[0].range));
    assert_true(s.light[2].range == 4.0 && s.light[2].inner == 0.0);
    assert_true(fabs(s.light[2].outer - M_PI / 4) < 1e-12);
    assert_at(s.light[2].along, 0, 0, 1);
    assert_at(s.light[3].along, 0, 0, -1);
    assert_true(s.light[3].color[1] == 0.5);
    gp_scene_free(&s);
}

// -- numbers ------------------------------------------------------------------

/* Positions of bytes, normalised, in a strided view, with a sparse vertex. */
static void numbers_are_strided_normalised_and_sparse(void **state)
{
    static const int8_t bytes[24] = {127, -127, 0, 9, 0, 0, 0, 9,
                                     -128, 64, 0, 9};
    static const uint8_t where[1] = {1};
    static const int8_t with[3] = {0, 0, 127};
    struct gp_scene s = gm_read(
        gm_write("'buffers': [{'uri': '%s', 'byteLength': 12}, {'uri': '%s', "
                 "'byteLength': 1}, {'uri': '%s', 'byteLength': 3}], "
                 "'bufferViews': [{'buffer': 0, 'byteLength': 12, 'byteStride'"
                 ": 4}, {'buffer': 1, 'byteLength': 1}, {'buffer': 2, "
                 "'byteLength': 3}], 'accessors': [{'bufferView': 0, "
                 "'componentType': 5120, 'normalized': true, 'count': 3, 'type'"
                 ": 'VEC3', 'sparse': {'count': 1, 'indices': {'bufferView': 1,"
                 " 'componentType': 5121}, 'values': {'bufferView': 2}}}], "
                 "'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}"
                 "], 'nodes': [{'mesh': 0}]", gm_uri(bytes, 12),
                 gm_uri(where, 1), gm_uri(with, 3)), GLAREPP_UP_Y);
    static const float expected[9] = {1, -1, 0, 0, 0, 1, -1, 64.0f / 127, 0};
    assert_memory_equal(s.position, expected, sizeof expected);
    gp_scene_free(&s);
}

/* Mode 5 and 6 of four corners, as the specification orders them (3.7.2.1). */
static void strips_and_fans_become_triangles(void **state)
{
    static const float four[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    static const uint32_t expected[2][6] = {{0, 1, 2, 1, 3, 2},
                                            {1, 2, 0, 2, 3, 0}};
    for (int mode = 5; mode <= 6; mode++) {
        struct gp_scene s = gm_read(
            gm_write("'buffers': [{'uri': '%s', 'byteLength': 48}], "
                     "'bufferViews': [{'buffer': 0, 'byteLength': 48}], "
                     "'accessors': [{'bufferView': 0, 'componentType': 5126, "
                     "'count': 4, 'type': 'VEC3'}], 'meshes': [{'primitives': "
                     "[{'mode': %d, 'attributes': {'POSITION': 0}}]}], "
                     "'nodes': [{'mesh': 0}]", gm_uri(four, 48), mode),
            GLAREPP_UP_Y);
        assert_int_equal(s.indices, 6);
        assert_memory_equal(s.index, expected[mode - 5], sizeof expected[0]);
        gp_scene_free(&s);
    }
}

static void primitives_share_vertices_and_have_boxes_of_their_own(void **state)
{
    struct gp_scene s = gm_read(
        gm_write(TRIANGLE ", 'nodes': [{'mesh': 0}, {'mesh': 0}]",
                 TRIANGLE_URIS),
        GLAREPP_UP_Y);
    assert_int_equal(s.objects, 2);
    assert_int_equal(s.vertices, 3);
    assert_int_equal(s.submeshes, 1);
    assert_int_equal(s.submesh[0].material, s.materials - 1);
    gp_scene_free(&s);
}

// -- binary files -------------------------------------------------------------

static void a_glb_has_its_buffer_in_its_second_chunk(void **state)
{
    const uint32_t whole = 28 + ((sizeof GM_GLB_JSON + 2) & ~3u) + 36;
    struct gp_scene s = gm_read(gm_write_glb(GM_GLB_JSON, corners, 36, 0),
                                   GLAREPP_UP_Y);
    assert_memory_equal(s.position, corners, sizeof corners);
    gp_scene_free(&s);
    gm_refused(gm_write_glb(GM_GLB_JSON, corners, 32, 0), GP_ERR_DATA, "truncated");
    gm_refused(gm_write_glb(GM_GLB_JSON, corners, 36, 9999), GP_ERR_DATA,
               "truncated");
    gm_refused(gm_write_glb(GM_GLB_JSON, corners, 36, 100), GP_ERR_DATA, "damaged");
    gm_refused(gm_write_glb(GM_GLB_JSON, corners, 36, whole - 1), GP_ERR_DATA,
               "damaged (chunk 1 of 36 bytes, the file has 35 left)");
    gm_refused(gm_write_glb(GM_GLB_JSON, corners, 36, whole + 1), GP_ERR_DATA,
               "truncated");
    gm_refused(gm_write_bytes("a.glb", "glTF\1\0\0\0\14\0\0\0", 12),
               GP_ERR_DATA, "version 1");
}

static void a_gltf_has_one_file_beside_it(void **state)
{
    static const char json[] =
        "'buffers': [{'byteLength': 36, 'uri': '%s'}], 'bufferViews': [{"
        "'buffer': 0, 'byteLength': 36}], 'accessors': [{'bufferView': 0, "
        "'componentType': 5126, 'count': 3, 'type': 'VEC3'}], 'meshes': [{"
        "'primitives': [{'attributes': {'POSITION': 0}}]}], 'nodes': [{'mesh':"
        " 0}]";
    gm_write_bytes("a b.bin", corners, 36);
    struct gp_scene s = gm_read(gm_write(json, "a%20b.bin"), GLAREPP_UP_Y);
    assert_memory_equal(s.position, corners, sizeof corners);
    gp_scene_free(&s);
    gm_refused(gm_write(json, "no.bin"), GP_ERR_IO, "no.bin");
    gm_refused(gm_write(json, "../a.bin"), GP_ERR_DATA, "no file beside");
    gm_refused(gm_write(json, "%2e%2e/a.bin"), GP_ERR_DATA, "no file beside");
    gm_refused(gm_write(json, "/etc/passwd"), GP_ERR_DATA, "no file beside");
    gm_refused(gm_write(json, "http://a.b/c"), GP_ERR_DATA, "no file beside");
    gm_refused(gm_write(json, "data:x;base64,A*"), GP_ERR_DATA, "not base64");
    gm_refused(gm_write("'buffers': [{'byteLength': 1, 'uri': 'a%%20b.bin'}, {"
                        "'byteLength': 1, 'uri': 'c.bin'}]"), GP_ERR_DATA,
               "a second file");
}

// -- what is wrong ------------------------------------------------------------

static void what_is_wrong_is_one_line(void **state)
{
    for (size_t i = 0; i < COUNT(gltf_wrong); i++)
        gm_refused(gm_write("%s", gltf_wrong[i].json), GP_ERR_DATA,
                   gltf_wrong[i].part);
    gm_refused(gm_write_bytes("a.gltf", "", 0), GP_ERR_DATA, "not JSON");
    gm_refused(gm_write_bytes("a.gltf", "[]", 2), GP_ERR_DATA, "not glTF");
    gm_refused(gm_write_bytes("a.gltf", "{}", 2), GP_ERR_DATA, "version\" is none");
    static const char least[] =
        "{\"asset\": {\"version\": \"2.0\", \"minVersion\": \"2.1\"}}";
    gm_refused(gm_write_bytes("a.gltf", least, sizeof least - 1), GP_ERR_DATA,
               "minVersion\" 2.1");
    gm_refused(gm_write_bytes("a.glb", "glTF\2\0\0\0\x10\x63\1", 11),
               GP_ERR_DATA, "truncated (11 bytes");
    kept_clear();
    gm_refused(in_folder("none.glb"), GP_ERR_IO, "none.glb");
}

static void skins_and_targets_warn_once(void **state)
{
    struct gp_scene s = gm_read(
        gm_write(TRIANGLE ", 'nodes': [{'mesh': 0, 'skin': 0}, {'mesh': 0, "
                 "'skin': 0}], 'skins': [{}]", TRIANGLE_URIS),
        GLAREPP_UP_Y);
    assert_int_equal(kept_lines, 1);
    assert_non_null(strstr(kept_warning, "skins are not supported"));
    gp_scene_free(&s);
}

static void instances_and_hidden_nodes_warn_once(void **state)
{
    struct gp_scene s = gm_read(
        gm_write(TRIANGLE ", 'extensionsUsed': ['EXT_mesh_gpu_instancing'], "
                 "'nodes': [{'mesh': 0, 'extensions': {'EXT_mesh_gpu_instancing"
                 "': {'attributes': {}}}}, {'mesh': 0, 'extensions': {"
                 "'EXT_mesh_gpu_instancing': {}}}, {'extensions': {"
                 "'KHR_node_visibility': {'visible': true}}}]", TRIANGLE_URIS),
        GLAREPP_UP_Y);
    assert_int_equal(kept_lines, 1);
    assert_non_null(strstr(kept_warning, "EXT_mesh_gpu_instancing"));
    gp_scene_free(&s);
    kept_clear();
    s = gm_read(
        gm_write(TRIANGLE ", 'nodes': [{'mesh': 0, 'extensions': {"
                 "'KHR_node_visibility': {'visible': false}}}]", TRIANGLE_URIS),
        GLAREPP_UP_Y);
    assert_int_equal(kept_lines, 1);
    assert_non_null(strstr(kept_warning, "KHR_node_visibility"));
    gp_scene_free(&s);
}

/* Indices 0, 1, 2 become 0, 2, 1; and so do zeros. */
static void indices_are_sparse(void **state)
{
    static const uint8_t where[4] = {1, 2, 9};
    static const uint16_t with[2] = {2, 1};
    for (int i = 0; i < 3; i++) {
        const char *const file = gm_write(
            "'buffers': [{'uri': '%s', 'byteLength': 36}, {'uri': '%s', "
            "'byteLength': 8}, {'uri': '%s', 'byteLength': 4}, {'uri': '%s', "
            "'byteLength': 4}], 'bufferViews': [{'buffer': 0, 'byteLength': 36}"
            ", {'buffer': 1, 'byteLength': 8}, {'buffer': 2, 'byteLength': 4}, "
            "{'buffer': 3, 'byteLength': 4}], 'accessors': [{'bufferView': 0, "
            "'componentType': 5126, 'count': 3, 'type': 'VEC3'}, {%s "
            "'componentType': 5123, 'count': 3, 'type': 'SCALAR', 'sparse': {"
            "'count': 2, 'indices': {'bufferView': 2, 'byteOffset': %d, "
            "'componentType': 5121}, 'values': {'bufferView': 3}}}], 'meshes': "
            "[{'primitives': [{'attributes': {'POSITION': 0}, 'indices': 1}]}]"
            ", 'nodes': [{'mesh': 0}]",
            gm_uri(corners, 36), gm_uri(order, 8), gm_uri(where, 4),
            gm_uri(with, 4), i ? "" : "'bufferView': 1,", i == 2);
        if (i == 2) {
            gm_refused(file, GP_ERR_DATA, "replaces element 9 of 3");
            break;
        }
        struct gp_scene s = gm_read(file, GLAREPP_UP_Y);
        assert_int_equal(s.indices, 3);
        assert_int_equal(s.index[0], 0);
        assert_int_equal(s.index[1], 2);
        assert_int_equal(s.index[2], 1);
        gp_scene_free(&s);
    }
}

static void places_out_of_range_are_at_the_origin(void **state)
{
    struct gp_scene s = gm_read(
        gm_write(TRIANGLE ", 'nodes': [{'scale': [1e14, 1e14, 1e14], 'children'"
                 ": [1]}, {'scale': [1e14, 1, 1], 'mesh': 0}]", TRIANGLE_URIS),
        GLAREPP_UP_Y);
    assert_at(s.object[0].box.lo, 0, 0, 0);
    assert_at(s.object[0].box.hi, 0, 0, 0);
    gp_scene_free(&s);
}

// -- keys ---------------------------------------------------------------------

/* A scene with all that is read: triangles, a light, a camera, keys. */
static const char *whole_scene(void)
{
    static const float times[2] = {1, 3}, places[6] = {1, 2, 3, 5, 2, 3};
    return gm_write(
        "'buffers': [{'uri': '%s', 'byteLength': 36}, {'uri': '%s', "
        "'byteLength': 8}, {'uri': '%s', 'byteLength': 24}], 'bufferViews': [{"
        "'buffer': 0, 'byteLength': 36}, {'buffer': 1, 'byteLength': 8}, {"
        "'buffer': 2, 'byteLength': 24}], 'accessors': [{'bufferView': 0, "
        "'componentType': 5126, 'count': 3, 'type': 'VEC3'}, {'bufferView': 1,"
        " 'componentType': 5126, 'count': 2, 'type': 'SCALAR'}, {'bufferView':"
        " 2, 'componentType': 5126, 'count': 2, 'type': 'VEC3'}], 'materials':"
        " [{}], 'meshes': [{'primitives': [{'attributes': {'POSITION': 0}, "
        "'material': 0}]}], 'nodes': [{'mesh': 0, 'camera': 0, 'children': [1]"
        "}, {'extensions': {'KHR_lights_punctual': {'light': 0}}}], 'cameras':"
        " [{'type': 'perspective', 'perspective': {'yfov': 1, 'znear': 1}}], "
        "'extensions': {'KHR_lights_punctual': {'lights': [{'type': 'spot'}]}}"
        ", 'animations': [{'channels': [{'sampler': 0, 'target': {'node': 0, "
        "'path': 'translation'}}], 'samplers': [{'input': 1, 'output': 2}]}]",
        gm_uri(corners, 36), gm_uri(times, 8), gm_uri(places, 24));
}

/* A node that keys move: times 0 and 1, or 2 of them. */
static struct gp_scene moved(const char *way, const char *prop,
                             const char *type, const float *values, int n,
                             int count)
{
    static const float times[2] = {1, 3};
    return gm_read(
        gm_write("'buffers': [{'uri': '%s', 'byteLength': 8}, {'uri': '%s', "
                 "'byteLength': %d}], 'bufferViews': [{'buffer': 0, "
                 "'byteLength': 8}, {'buffer': 1, 'byteLength': %d}], "
                 "'accessors': [{'bufferView': 0, 'componentType': 5126, "
                 "'count': 2, 'type': 'SCALAR'}, {'bufferView': 1, "
                 "'componentType': 5126, 'count': %d, 'type': '%s'}], 'nodes': "
                 "[{'extensions': {'KHR_lights_punctual': {'light': 0}}}], "
                 "'extensions': {'KHR_lights_punctual': {'lights': [{'type': "
                 "'spot'}]}}, 'animations': [{'channels': [{'sampler': 0, "
                 "'target': {'node': 0, 'path': '%s'}}], 'samplers': [{'input':"
                 " 0, 'output': 1, 'interpolation': '%s'}]}]",
                 gm_uri(times, 8), gm_uri(values, (size_t) n * 4), 4 * n, 4 * n,
                 count, type, prop, way), GLAREPP_UP_Y);
}

static void keys_step_and_run_straight(void **state)
{
    static const float values[6] = {1, 2, 3, 5, 2, 3};
    static const struct {
        double t, step, linear;
    } row[] = {{-5, 1, 1}, {1, 1, 1}, {1.5, 1, 2}, {2.5, 1, 4}, {3, 5, 5},
               {99, 5, 5}};
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_scene a = moved("STEP", "translation", "VEC3", values, 6, 2);
        struct gp_scene b = moved("LINEAR", "translation", "VEC3", values, 6,
                                  2);
        assert_true(a.start == 1.0 && a.end == 3.0);
        gp_scene_pose(&a, row[i].t);
        gp_scene_pose(&b, row[i].t);
        assert_at(a.light[0].at, row[i].step, 2, 3);
        assert_at(b.light[0].at, row[i].linear, 2, 3);
        gp_scene_free(&a);
        gp_scene_free(&b);
    }
}

/* x(t) = t^3 - 2 t has the tangents 3 t^2 - 2: one cubic piece is it. */
static void cubic_keys_follow_their_tangents(void **state)
{
    static const float values[18] = {9, 9, 9, -1, 0, 0, 1, 0, 0,
                                     25, 0, 0, 21, 0, 0, 9, 9, 9};
    struct gp_scene s = moved("CUBICSPLINE", "translation", "VEC3", values, 18,
                              6);
    for (double t = 1.0; t <= 3.0; t += 0.125) {
        gp_scene_pose(&s, t);
        assert_at(s.light[0].at, t * t * t - 2.0 * t, 0, 0);
    }
    gp_scene_pose(&s, 0.0);
    assert_at(s.light[0].at, -1, 0, 0);
    gp_scene_free(&s);
}

/* From no turn to 120 degrees round y, a quarter of the way: 30 degrees; and
 * the same turn written with the other sign takes the same way. */
static void turns_run_at_one_speed_the_shorter_way(void **state)
{
    const float s = sinf((float) M_PI / 3), c = cosf((float) M_PI / 3);
    const float values[2][8] = {{0, 0, 0, 1, 0, s, 0, c},
                                {0, 0, 0, 1, 0, -s, 0, -c}};
    for (int i = 0; i < 2; i++) {
        struct gp_scene scene = moved("LINEAR", "rotation", "VEC4", values[i],
                                      8, 2);
        gp_scene_pose(&scene, 1.5);
        assert_at(scene.light[0].along, -sin(M_PI / 6), 0, -cos(M_PI / 6));
        gp_scene_free(&scene);
    }
}

// -- memory -------------------------------------------------------------------

/* Every call of the reader that may fail does: one line, and nothing is kept.
 */
static void full_memory_is_one_line_and_keeps_nothing(void **state)
{
    const char *const file = whole_scene();
    const long blocks = fail_blocks();
    struct gp_scene s = {0};
    long n = 1;
    for (;; n++) {
        kept_clear();
        fail_at(FAIL_ALLOC, n);
        const gp_status st =
            gp_scene_read(&kept_log, file, GLAREPP_UP_Y, NULL, &s);
        if (!fail_end()) {
            assert_ok(st);
            break;
        }
        if (st != GP_ERR_BUG || kept_errors != 1)
            fail_msg("allocation %ld: status %d, %d lines (%s)", n, (int) st,
                     kept_errors, kept_line);
        assert_int_equal(fail_blocks(), blocks);
    }
    assert_true(n > 20);
    gp_scene_free(&s);
    assert_int_equal(fail_blocks(), blocks);
    gm_refused(gm_write("'buffers': [{'byteLength': 1, 'uri': 'data:;base64,'}]"
                        ), GP_ERR_DATA, "truncated (0 bytes");
}

// -- cameras ------------------------------------------------------------------

static void cameras_of_one_name_are_told_apart_by_node(void **state)
{
    struct gp_scene s = gm_read(
        gm_write("'cameras': [{'type': 'perspective', 'perspective': {'yfov': "
                 "1, 'znear': 0.1}}], 'nodes': [{}, {'camera': 0, 'name': "
                 "'Cam'}, {'camera': 0, 'name': 'Cam'}, {'camera': 0, 'name': "
                 "'other'}]"), GLAREPP_UP_Y);
    assert_null(gp_scene_find_camera(&s, "Cam"));
    assert_int_equal(gp_scene_no_camera(&kept_log, &s, "Cam"), GP_ERR_USAGE);
    assert_non_null(strstr(kept_line, "2 cameras"));
    assert_non_null(strstr(kept_line, "1 (Cam), 2 (Cam), other"));
    assert_ptr_equal(gp_scene_find_camera(&s, "2"), &s.camera[1]);
    assert_ptr_equal(gp_scene_find_camera(&s, "other"), &s.camera[2]);
    assert_null(gp_scene_find_camera(&s, "0")); // a node without one
    kept_clear();
    gp_scene_free(&s);
}

static void cameras_project_and_are_compared(void **state)
{
    static const struct gp_rect display = {0, 0, 200, 100};
    struct gp_camera a, b;
    struct gp_scene s = gm_read(
        gm_write("'cameras': [{'type': 'perspective', 'perspective': {'yfov': "
                 "1.5707963267948966, 'znear': 0.1}}, {'type': 'orthographic'}]"
                 ", 'nodes': [{'camera': 0, 'name': 'main', 'translation': [0, "
                 "0, 5], 'scale': [2, 2, 2]}, {'camera': 1}]"), GLAREPP_UP_Y);
    assert_int_equal(s.cameras, 1);
    assert_non_null(strstr(kept_warning, "orthographic"));
    assert_null(gp_scene_find_camera(&s, "other"));
    const struct gp_scene_camera *const c = gp_scene_find_camera(&s, "main");
    assert_ptr_equal(c, gp_scene_find_camera(&s, NULL));
    assert_ok(gp_scene_camera_make(&kept_log, &s, c, 2.0, &a));
    // 45 degrees up and 45 right at a distance of 10
    const struct gp_projected p = gp_camera_project(
        &a, display, (double[3]) {10, 10, -5}, 1.0);
    assert_true(fabs(p.x - 150.0) < 1e-9 && fabs(p.y) < 1e-9);
    assert_true(fabs(p.z - 10.0) < 1e-9);
    assert_true(gp_scene_apart(&s, &a, &a, display) < 1e-9);
    b = a; // a shift of a picture's hundredth is 2 pixels
    for (int i = 0; i < 4; i++)
        b.to_ndc[4 * i] += 0.01 * b.to_ndc[4 * i + 3];
    assert_true(fabs(gp_scene_apart(&s, &a, &b, display) - 2.0) < 1e-9);
    assert_int_equal(gp_scene_find_up(&s, &a), GLAREPP_UP_Y);
    gp_scene_turn(&s, GLAREPP_UP_Z);
    assert_ok(gp_scene_camera_make(&kept_log, &s, s.camera, 2.0, &b));
    gp_scene_turn(&s, GLAREPP_UP_Y);
    assert_int_equal(gp_scene_find_up(&s, &b), GLAREPP_UP_Z);
    s.cameras = 0; // then by the picture's upright
    assert_int_equal(gp_scene_find_up(&s, &a), GLAREPP_UP_Y);
    assert_int_equal(gp_scene_find_up(&s, &b), GLAREPP_UP_Z);
    s.cameras = 1;
    gp_scene_free(&s);
}

/* Writes {"asset": ..., "KEY": [ITEM, ITEM, ...]} of `n` items. */
static const char *write_many(const char *key, const char *item, size_t n)
{
    const size_t room = 64 + n * (strlen(item) + 1);
    char *const text = malloc(room), *to = text;
    assert_non_null(text);
    to += sprintf(to, "{\"asset\": {\"version\": \"2.0\"}, \"%s\": [", key);
    for (size_t i = 0; i < n; i++)
        to += sprintf(to, "%s%s", i ? "," : "", item);
    to += sprintf(to, "]}");
    const char *const file =
        gm_write_bytes("a.gltf", text, (size_t) (to - text));
    free(text);
    return file;
}

/* A small file cannot take all memory: not by its JSON, which would take 76
 * bytes for each of its own, and not by what is made of it. */
static void memory_is_in_proportion_to_the_file(void **state)
{
    static const struct {
        const char *key, *item;
        size_t n;
    } row[] = {
        {"extras", "{}", 600000},
        {"extras", "[]", 1200000},
        {"extras", "{\"a\":\"\"}", 1000000},
        {"nodes", "{}", 200000},
        {"nodes", "{\"mesh\":0}", 180000},
    };
    for (size_t i = 0; i < COUNT(row); i++)
        gm_refused(write_many(row[i].key, row[i].item, row[i].n), GP_ERR_DATA,
                   "out of proportion");
    // in proportion, but seconds and GBs
    gm_refused(write_many("meshes", "{\"primitives\":[]}", 2500000),
               GP_ERR_DATA, "its JSON would take");
    struct gp_scene s =
        gm_read(write_many("nodes", "{}", 100000), GLAREPP_UP_Y);
    gp_scene_free(&s);
}

SUITE_OF(gltf, make_folder, remove_folder,
         a_node_is_scaled_turned_and_moved_after_its_parent,
         a_matrix_is_read_by_columns, z_up_turns_the_world,
         only_the_nodes_of_the_scene_are_placed,
         lights_have_the_defaults_of_their_extension,
         numbers_are_strided_normalised_and_sparse,
         strips_and_fans_become_triangles,
         primitives_share_vertices_and_have_boxes_of_their_own,
         a_glb_has_its_buffer_in_its_second_chunk,
         a_gltf_has_one_file_beside_it, what_is_wrong_is_one_line,
         memory_is_in_proportion_to_the_file, skins_and_targets_warn_once,
         instances_and_hidden_nodes_warn_once, indices_are_sparse,
         places_out_of_range_are_at_the_origin, keys_step_and_run_straight,
         cubic_keys_follow_their_tangents,
         turns_run_at_one_speed_the_shorter_way,
         full_memory_is_one_line_and_keeps_nothing,
         cameras_project_and_are_compared,
         cameras_of_one_name_are_told_apart_by_node)
