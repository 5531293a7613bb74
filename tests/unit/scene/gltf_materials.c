// SPDX-License-Identifier: Apache-2.0
/* The glTF reader: cut-outs, their coordinates, and glass. */
#include "gltf_made.h"

static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 2, 0};

struct picture {
    int calls, wide; // wide: 0 as 2
    char name[256], bytes[8];
    size_t n;
};

static gp_status give_alpha(void *user, const struct gp_log *log,
                            const char *name, const void *bytes, size_t n,
                            long long most, struct gp_cutout *out)
{
    struct picture *const p = user;
    p->calls++;
    snprintf(p->name, sizeof p->name, "%s", name);
    p->n = n;
    if (bytes)
        memcpy(p->bytes, bytes, n < 8 ? n : 8);
    assert_int_equal(most, 1 << 24);
    uint16_t *const v = out->alpha = aligned_alloc(64, 64);
    v[0] = 0;
    v[1] = 65535;
    out->w = p->wide ? p->wide : 2;
    out->h = 1;
    return GP_OK;
}

/* KHR_texture_transform moves the coordinates of a cut-out, each material by its
 * own; the first is the extension's example, the lower left quarter turned. */
static void cutouts_are_moved(void **state)
{
    static const float place[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const float uv[] = {0, 0, 1, 0, 0, 1, 0.5f, 0.5f, 0.5f, 0.5f,
                               0.25f, 0};
    static const float moved[3][6] = {{0, 1, 0, 0.5f, 0.5f, 1},
                                      {-2, 0.25f, -2, 0.25f, -2.5f, 0.25f},
                                      {0, 0, 1, 0, 0, 1}};
    struct picture p = {0};
    struct gp_scene s = {0};
    const struct gp_scene_images images = {&p, give_alpha};
    gm_write("'extensionsRequired': ['KHR_texture_transform'], "
             "'buffers': [{'byteLength': 36, 'uri': '%s'}, "
             "{'byteLength': 48, 'uri': '%s'}], "
             "'bufferViews': [{'buffer': 0, 'byteLength': 36}, {'buffer': 1, "
             "'byteLength': 24}, {'buffer': 1, 'byteOffset': 24, 'byteLength': "
             "24}], 'accessors': [{'bufferView': 0, 'componentType': 5126, "
             "'count': 3, 'type': 'VEC3'}, {'bufferView': 1, 'componentType': "
             "5126, 'count': 3, 'type': 'VEC2'}, {'bufferView': 2, "
             "'componentType': 5126, 'count': 3, 'type': 'VEC2'}], "
             "'images': [{'uri': 'data:image/png;base64,UE5H'}], "
             "'textures': [{'source': 0}], 'materials': [{'alphaMode': 'MASK', "
             "'pbrMetallicRoughness': {'baseColorTexture': {'index': 0, "
             "'extensions': {'KHR_texture_transform': {'offset': [0, 1], "
             "'rotation': 1.5707963267948966, 'scale': [0.5, 0.5]}}}}}, "
             "{'alphaMode': 'MASK', 'pbrMetallicRoughness': "
             "{'baseColorTexture': {'index': 0, 'extensions': "
             "{'KHR_texture_transform': {'offset': [-3, 0.25], 'scale': [2, 0], "
             "'texCoord': 1}}}}}, {'alphaMode': 'MASK', 'pbrMetallicRoughness':"
             " {'baseColorTexture': {'index': 0}}}], 'meshes': [{'primitives': "
             "[{'material': 0, 'attributes': {'POSITION': 0, 'TEXCOORD_0': 1}}, "
             "{'material': 1, 'attributes': {'POSITION': 0, 'TEXCOORD_0': 1, "
             "'TEXCOORD_1': 2}}, {'material': 2, 'attributes': {'POSITION': 0, "
             "'TEXCOORD_0': 1}}]}]",
             gm_uri(place, sizeof place), gm_uri(uv, sizeof uv));
    assert_ok(gp_scene_read(&kept_log, path, GLAREPP_UP_Y, &images, &s));
    assert_int_equal(s.submeshes, 3);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 6; i++) {
            const uint32_t v = s.index[s.submesh[k].first + i / 2];
            assert_true(fabs((double) s.uv[2 * v + (uint32_t) i % 2] -
                             (double) moved[k][i]) < 1e-6);
        }
    }
    gp_scene_free(&s);
}

static void alpha_of_vertices_is_a_warning_on_cutouts(void **state)
{
    static const struct {
        const char *mode, *type;
        bool warns;
    } row[] = {
        {"MASK", "VEC4", true}, {"BLEND", "VEC4", true},
        {"MASK", "VEC3", false}, {"OPAQUE", "VEC4", false},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        kept_clear();
        struct gp_scene s = gm_read(gm_write(
                 "'buffers': [{'byteLength': 36, 'uri': '%s'}], 'bufferViews': "
                 "[{'buffer': 0, 'byteLength': 36}], 'accessors': "
                 "[{'bufferView': 0, 'componentType': 5126, 'count': 3, "
                 "'type': 'VEC3'}, {'componentType': 5126, 'count': 3, 'type': "
                 "'%s'}], 'materials': [{'alphaMode': '%s'}], 'meshes': "
                 "[{'primitives': [{'material': 0, 'attributes': {'POSITION': "
                 "0, 'COLOR_0': 1}}]}]",
                 gm_uri(corners, 36), row[i].type, row[i].mode), GLAREPP_UP_Y);
        assert_int_equal(strstr(kept_warning, "(COLOR_0) is not read") != NULL,
                         row[i].warns);
        gp_scene_free(&s);
    }
}

/* Glass of at least half the light hides nothing; a texture of it is not read. */
static void glass_hides_nothing(void **state)
{
    static const struct {
        const char *glass;
        bool gone, warns;
    } row[] = {
        {"'transmissionFactor': 1", true, false},
        {"'transmissionFactor': 0.5", true, true},
        {"'transmissionFactor': 0.4", false, true},
        {"'transmissionFactor': 0", false, false},
        {"", false, false},
        {"'transmissionFactor': 1, 'transmissionTexture': {'index': 0}", false,
         true},
        {"'transmissionTexture': {'index': 0}", false, false}, // factor 0
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        kept_clear();
        struct gp_scene s = gm_read(gm_write(
                 "'extensionsRequired': ['KHR_materials_transmission'], "
                 "'materials': [{'extensions': {'KHR_materials_transmission': "
                 "{%s}}}]", row[i].glass), GLAREPP_UP_Y);
        assert_int_equal(gp_material_gone(&s.material[0]), row[i].gone);
        assert_int_equal(strstr(kept_warning, "hides all light, other glass "
                                "none") != NULL, row[i].warns);
        assert_false(gp_material_gone(&s.material[1])); // the default
        gp_scene_free(&s);
    }
    gm_write("'materials': [{'extensions': {'KHR_materials_transmission': "
             "{'transmissionFactor': 2}}}]");
    struct gp_scene s;
    assert_int_equal(gp_scene_read(&kept_log, path, GLAREPP_UP_Y, NULL, &s),
                     GP_ERR_DATA);
    assert_non_null(strstr(kept_line, "transmissionFactor"));
}

static void an_image_is_read_once_for_all_textures(void **state)
{
    struct picture p = {0};
    struct gp_scene s = {0};
    const struct gp_scene_images images = {&p, give_alpha};
    gm_write("'materials': [{'alphaMode': 'MASK', 'pbrMetallicRoughness': {"
             "'baseColorTexture': {'index': 0}}}, {'alphaMode': 'MASK', "
             "'pbrMetallicRoughness': {'baseColorTexture': {'index': 1}}}], "
             "'textures': [{'source': 0, 'sampler': 0}, {'source': 0}], "
             "'samplers': [{'wrapS': 33071}], 'images': [{'uri': "
             "'data:image/png;base64,UE5H'}]");
    assert_ok(gp_scene_read(&kept_log, path, GLAREPP_UP_Y, &images, &s));
    assert_int_equal(p.calls, 1);
    assert_int_equal(s.cutouts, 2);
    assert_ptr_equal(s.cutout[0].alpha, s.cutout[1].alpha);
    assert_int_equal(s.cutout[1].owner, 0);
    assert_int_equal(s.cutout[0].wrap[0], GP_WRAP_CLAMP);
    assert_int_equal(s.cutout[1].wrap[0], GP_WRAP_REPEAT);
    gp_scene_free(&s);
    p.wide = (1 << 24) + 1;
    gp_status st = gp_scene_read(&kept_log, path, GLAREPP_UP_Y, &images, &s);
    assert_int_equal(st, GP_ERR_DATA);
    assert_non_null(strstr(kept_line, "over 16777216 texels"));
}

static void cutouts_are_read_once_for_all_materials(void **state)
{
    struct picture p = {0};
    struct gp_scene s = {0};
    const struct gp_scene_images images = {&p, give_alpha};
    gm_write("'materials': [{'alphaMode': 'MASK', 'alphaCutoff': 0.25, "
             "'pbrMetallicRoughness': {'baseColorTexture': {'index': 0}, "
             "'baseColorFactor': [1, 0.5, 0.25, 0.75]}}, {'alphaMode': 'MASK', "
             "'pbrMetallicRoughness': {'baseColorTexture': {'index': 0}}}, {"
             "'pbrMetallicRoughness': {'baseColorTexture': {'index': 1}}}], "
             "'textures': [{'source': 0, 'sampler': 0}, {'source': 1}], "
             "'samplers': [{'wrapS': 33071, 'wrapT': 33648}], 'images': [{"
             "'uri': 'data:image/png;base64,UE5H'}, {'uri': 'no.png'}]");
    assert_ok(gp_scene_read(&kept_log, path, GLAREPP_UP_Y, &images, &s));
    assert_int_equal(p.calls, 1); // an opaque material's is not read
    assert_int_equal(p.n, 3);
    assert_memory_equal(p.bytes, "PNG", 3);
    assert_int_equal(s.cutout[0].wrap[0], GP_WRAP_CLAMP);
    assert_int_equal(s.cutout[0].wrap[1], GP_WRAP_MIRROR);
    assert_true(s.material[0].cutoff == 0.25f && s.material[1].cutoff == 0.5f);
    assert_true(s.material[0].base[3] == 0.75f && s.material[2].cutoff == 0);
    assert_int_equal(s.material[1].cutout, 0);
    assert_int_equal(s.material[2].cutout, -1);
    assert_int_equal(s.material[3].cutout, -1);
    gp_scene_free(&s);
    s = gm_read(path, GLAREPP_UP_Y);
    assert_non_null(strstr(kept_warning, "they count as opaque"));
    gp_scene_free(&s);
}

SUITE_OF(gltf_materials, make_folder, remove_folder,
         alpha_of_vertices_is_a_warning_on_cutouts, glass_hides_nothing,
         cutouts_are_read_once_for_all_materials,
         an_image_is_read_once_for_all_textures, cutouts_are_moved)
