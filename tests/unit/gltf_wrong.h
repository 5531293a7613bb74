// SPDX-License-Identifier: Apache-2.0
/* glTF files that are wrong, as gm_write() takes them. */
#ifndef GP_TESTS_GLTF_WRONG_H
#define GP_TESTS_GLTF_WRONG_H

#include "gltf_made.h"

/* A triangle of places and an index for each, as base64. */
#define GLTF_WRONG_MESH(places, order)                                        \
    "'buffers': [{'uri': 'data:;base64," places "', 'byteLength': 36}, "      \
    "{'uri': 'data:;base64," order "', 'byteLength': 6}], 'bufferViews': [{"  \
    "'buffer': 0, 'byteLength': 36}, {'buffer': 1, 'byteLength': 6}], "       \
    "'accessors': [{'bufferView': 0, 'componentType': 5126, 'count': 3, "     \
    "'type': 'VEC3'}, {'bufferView': 1, 'componentType': 5123, 'count': 3, "  \
    "'type': 'SCALAR'}], 'meshes': [{'primitives': [{'attributes': {"         \
    "'POSITION': 0}, 'indices': 1}]}]"

#define GLTF_WRONG_LIGHT(members)                                             \
    "'extensions': {'KHR_lights_punctual': {'lights': [{'type': 'point', "    \
    members "}]}}"

static const struct gltf_wrong {
    const char *name, *json;
    const char *part; // of the line that says so
} gltf_wrong[] = {
    {"two versions", "'asset': {'version': '1.0'}", "duplicate"},
    {"nodes that are no array", "'nodes': {}", "\"nodes\" is not an array"},
    {"a node that is a number", "'nodes': [3]", "\"nodes\" 0 is not an object"},
    {"a node in itself", "'nodes': [{'children': [0]}]", "a circle"},
    {"a circle of two nodes", "'nodes': [{'children': [1]}, {'children': [0]}]",
     "a circle"},
    {"two parents", "'nodes': [{'children': [2]}, {'children': [2]}, {}]",
     "another parent"},
    {"a child that is not there", "'nodes': [{'children': [1]}]",
     "no such child"},
    {"half a child", "'nodes': [{'children': [0.5]}]", "no such child"},
    {"a mesh that is not there", "'nodes': [{'mesh': 0}]", "no such \"mesh\""},
    {"a matrix with perspective",
     "'nodes': [{'matrix': [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]",
     "perspective"},
    {"a scale of two numbers", "'nodes': [{'scale': [1, 2]}]", "\"scale\""},
    {"a place at 1e300", "'nodes': [{'translation': [1, 2, 1e300]}]",
     "\"translation\""},
    {"a root that is not there", "'nodes': [{}], 'scenes': [{'nodes': [1]}]",
     "holds no root"},
    {"a scene that is not there", "'scene': 0", "no such \"scene\""},
    {"Draco", "'extensionsRequired': ['KHR_draco_mesh_compression']",
     "KHR_draco_mesh_compression"},
    {"meshopt", "'extensionsRequired': ['EXT_meshopt_compression']",
     "EXT_meshopt_compression"},
    {"places that are matrices",
     "'accessors': [{'componentType': 5126, 'count': 3, 'type': 'MAT4'}], "
     "'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}]",
     "a type that is not read"},
    {"places of 32-bit whole numbers",
     "'accessors': [{'componentType': 5124, 'count': 3, 'type': 'VEC3'}], "
     "'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}]",
     "a type that is not read"},
    {"places of no type",
     "'accessors': [{'count': 3, 'type': 'VEC3'}], "
     "'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}]",
     "a type that is not read"},
    // 2 GB of zeros from a file of 200 bytes
    {"2 GB of zeros",
     "'accessors': [{'componentType': 5126, 'count': 100000000, 'type': "
     "'VEC3'}], 'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}"
     "]}]",
     "out of proportion"},
    {"a buffer without URI", "'buffers': [{'byteLength': 4}]", "no \"uri\""},
    {"a buffer cut off",
     "'buffers': [{'byteLength': 4, 'uri': 'data:x;base64,AAAA'}]",
     "truncated (3 bytes"},
    {"a view 2 GB into its buffer",
     "'buffers': [{'byteLength': 3, 'uri': 'data:x;base64,AAAA'}], "
     "'bufferViews': [{'buffer': 0, 'byteOffset': 2147483647, 'byteLength'"
     ": 1}], 'accessors': [{'bufferView': 0, 'componentType': 5121, 'count'"
     ": 1, 'type': 'VEC3'}], 'meshes': [{'primitives': [{'attributes': {"
     "'POSITION': 0}}]}]",
     "byteOffset"},
    {"a view of 2 GB",
     "'buffers': [{'byteLength': 3, 'uri': 'data:x;base64,AAAA'}], "
     "'bufferViews': [{'buffer': 0, 'byteOffset': 2, 'byteLength': 2147483"
     "600}], 'accessors': [{'bufferView': 0, 'componentType': 5121, 'count'"
     ": 1, 'type': 'VEC3'}], 'meshes': [{'primitives': [{'attributes': {"
     "'POSITION': 0}}]}]",
     "leaves its buffer"},
    {"strides of 33 GB",
     "'buffers': [{'byteLength': 3, 'uri': 'data:x;base64,AAAA'}], "
     "'bufferViews': [{'buffer': 0, 'byteLength': 3, 'byteStride': 252}], "
     "'accessors': [{'bufferView': 0, 'componentType': 5121, 'count': "
     "134217000, 'type': 'VEC3'}], 'meshes': [{'primitives': [{"
     "'attributes': {'POSITION': 0}}]}]",
     "leaves its buffer view"},
    {"a view of a byte more than its buffer",
     "'buffers': [{'byteLength': 3, 'uri': 'data:x;base64,AAAA'}], "
     "'bufferViews': [{'buffer': 0, 'byteOffset': 1, 'byteLength': 3}], "
     "'accessors': [{'bufferView': 0, 'componentType': 5121, 'count': 1, "
     "'type': 'VEC3'}], 'meshes': [{'primitives': [{'attributes': {"
     "'POSITION': 0}}]}]",
     "leaves its buffer"},
    {"an element of a byte more than its view",
     "'buffers': [{'byteLength': 3, 'uri': 'data:x;base64,AAAA'}], "
     "'bufferViews': [{'buffer': 0, 'byteLength': 2}], 'accessors': [{"
     "'bufferView': 0, 'componentType': 5121, 'count': 1, 'type': 'VEC3'}], "
     "'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}]",
     "end at byte 3 of 2"},
    {"a sparse element after the last",
     "'buffers': [{'byteLength': 3, 'uri': 'data:x;base64,AQAA'}], "
     "'bufferViews': [{'buffer': 0, 'byteLength': 3}], 'accessors': [{"
     "'componentType': 5121, 'count': 1, 'type': 'VEC3', 'sparse': {'count': "
     "1, 'indices': {'bufferView': 0, 'componentType': 5121}, 'values': {"
     "'bufferView': 0}}}], 'meshes': [{'primitives': [{'attributes': {"
     "'POSITION': 0}}]}]",
     "replaces element 1 of 1"},
    {"a light of no type",
     "'extensions': {'KHR_lights_punctual': {'lights': [{}]}}",
     "light 0: no \"type\""},
    {"a spot inside out",
     "'extensions': {'KHR_lights_punctual': {'lights': [{'type': 'spot', "
     "'spot': {'innerConeAngle': 1, 'outerConeAngle': 0.5}}]}}",
     "innerConeAngle"},
    {"a range of 0",
     "'extensions': {'KHR_lights_punctual': {'lights': [{'type': 'point', "
     "'range': 0}]}}",
     "\"range\" is not over 0"},
    {"a turn by nothing", "'nodes': [{'rotation': [0, 0, 0, 0]}]",
     "node 0: \"rotation\""},
    {"a light that is not there",
     "'nodes': [{'extensions': {'KHR_lights_punctual': {'light': 0}}}]",
     "no such light"},
    {"a camera without angle", "'cameras': [{'type': 'perspective'}]", "yfov"},
    {"a camera of 229 degrees",
     "'cameras': [{'type': 'perspective', 'perspective': {'yfov': 4}}]",
     "yfov"},
    {"an unknown alphaMode", "'materials': [{'alphaMode': 'MASKED'}]",
     "alphaMode"},
    {"keys that do not rise",
     "'nodes': [{}], 'accessors': [{'componentType': 5126, 'count': 2, "
     "'type': 'SCALAR'}, {'componentType': 5126, 'count': 2, 'type': 'VEC3'"
     "}], 'animations': [{'channels': [{'sampler': 0, 'target': {'node': 0,"
     " 'path': 'translation'}}], 'samplers': [{'input': 0, 'output': 1}]}]",
     "keys that do not rise"},
    {"a channel without sampler",
     "'nodes': [{}], 'animations': [{'channels': [{'sampler': 3, 'target':"
     " {'node': 0, 'path': 'translation'}}], 'samplers': []}]",
     "a channel without sampler"},
    {"a place of NaN",
     GLTF_WRONG_MESH("AAAAAAAAAAAAAAAAAACAPwAAwH8AAAAAAAAAAAAAAEAAAAAA",
                     "AAABAAIA"),
     "element 1 is not finite"},
    {"a place of Inf",
     GLTF_WRONG_MESH("AAAAAAAAAAAAAAAAAACAPwAAgH8AAAAAAAAAAAAAAEAAAAAA",
                     "AAABAAIA"),
     "element 1 is not finite"},
    {"a place at 1e30",
     GLTF_WRONG_MESH("AAAAAAAAAAAAAAAAAACAP8rySXEAAAAAAAAAAAAAAEAAAAAA",
                     "AAABAAIA"),
     "or over 1e+15"},
    {"an index beyond the places",
     GLTF_WRONG_MESH("AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAA",
                     "AAABAAMA"),
     "index 2 is 3, there are 3 vertices"},
    {"a light of NaN cd", GLTF_WRONG_LIGHT("'intensity': NaN"), "not JSON"},
    {"a light of infinite cd", GLTF_WRONG_LIGHT("'intensity': 1e999"),
     "not JSON"},
    {"a light of 1e300 cd", GLTF_WRONG_LIGHT("'intensity': 1e300"),
     "intensity"},
    {"a light of -1 cd", GLTF_WRONG_LIGHT("'intensity': -1"), "intensity"},
    {"a light of infinite range", GLTF_WRONG_LIGHT("'range': 1e999"),
     "not JSON"},
    {"a light of endless colour", GLTF_WRONG_LIGHT("'color': [1e300, 1, 1]"),
     "color"},
    {"a circle of three nodes",
     "'nodes': [{'children': [1]}, {'children': [2]}, {'children': [0]}]",
     "a circle"},
    {"-1 places",
     "'accessors': [{'componentType': 5126, 'count': -1, 'type': 'VEC3'}], "
     "'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}]",
     "count"},
    {"9e15 places",
     "'accessors': [{'componentType': 5126, 'count': 9007199254740993, 'type': "
     "'VEC3'}], 'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}]",
     "count"},
};

#endif
