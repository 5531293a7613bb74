#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes small glTF scenes into a folder, the first inputs of fuzz_gltf.

Usage: seeds_gltf.py FOLDER
"""
import base64
import json
import os
import struct
import sys

folder = sys.argv[1]


def write(name, scene, binary=None):
    text = json.dumps({"asset": {"version": "2.0"}, **scene},
                      separators=(",", ":")).encode()
    if binary is not None:
        text += b" " * (-len(text) % 4)
        text = (struct.pack("<4sIIII", b"glTF", 2,
                            28 + len(text) + len(binary), len(text),
                            0x4e4f534a) + text +
                struct.pack("<II", len(binary), 0x004e4942) + binary)
    with open(os.path.join(folder, name), "wb") as f:
        f.write(text)


def buffers(*parts):
    return {"buffers": [{"uri": "data:;base64," +
                         base64.b64encode(p).decode(), "byteLength": len(p)}
                        for p in parts],
            "bufferViews": [{"buffer": i, "byteLength": len(p)}
                            for i, p in enumerate(parts)]}


def accessor(view, kind, count, shape, **more):
    return {"bufferView": view, "componentType": kind, "count": count,
            "type": shape, **more}


floats = lambda *v: struct.pack(f"<{len(v)}f", *v)
corners = floats(0, 0, 0, 1, 0, 0, 0, 2, 0, 1, 2, 0)
mesh = {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0, "rotation": [0, 0.6, 0, 0.8]}]}

write("binary.glb", {"buffers": [{"byteLength": 48}],
                     "bufferViews": [{"buffer": 0, "byteLength": 48}],
                     "accessors": [accessor(0, 5126, 4, "VEC3")], **mesh},
      corners)
for mode in 4, 5, 6:
    write(f"mode{mode}", {**buffers(corners, bytes([0, 1, 2, 3])),
          "accessors": [accessor(0, 5126, 4, "VEC3"),
                        accessor(1, 5121, 4, "SCALAR")],
          "meshes": [{"primitives": [{"attributes": {"POSITION": 0},
                                      "indices": 1, "mode": mode}]}],
          "nodes": [{"children": [1], "scale": [2, 1, 1]}, {"mesh": 0}],
          "scene": 0, "scenes": [{"nodes": [0]}]})
for kind, size in (5120, 1), (5121, 1), (5122, 2), (5123, 2):
    write(f"type{kind}", {**buffers(bytes(range(12 * size)), b"\1", bytes(8)),
          "accessors": [accessor(0, kind, 3, "VEC3", normalized=True, sparse={
              "count": 1,
              "indices": {"bufferView": 1, "componentType": 5121},
              "values": {"bufferView": 2}})], **mesh})
for way, n in ("STEP", 1), ("LINEAR", 1), ("CUBICSPLINE", 3):
    for path, parts in ("translation", 3), ("rotation", 4), ("scale", 3):
        write(f"{way}-{path}", {
            **buffers(floats(1, 2), floats(*[0.5] * (2 * n * parts))),
            "accessors": [accessor(0, 5126, 2, "SCALAR"),
                          accessor(1, 5126, 2 * n, f"VEC{parts}")],
            "nodes": [{"camera": 0}],
            "cameras": [{"type": "perspective", "perspective": {
                "yfov": 0.7, "znear": 0.1}}],
            "animations": [{"channels": [{"sampler": 0, "target": {
                "node": 0, "path": path}}], "samplers": [{
                    "input": 0, "output": 1, "interpolation": way}]}]})
punctual = "KHR_lights_punctual"
write("lights", {"extensionsRequired": [punctual], "extensions": {punctual: {
    "lights": [{"type": "point", "range": 4, "name": "a"},
               {"type": "spot", "spot": {"innerConeAngle": 0.1}},
               {"type": "directional", "color": [1, 0.5, 0]}]}},
    "nodes": [{"extensions": {punctual: {"light": i}},
               "extras": {"ball_radius": 0.1}} for i in range(3)]})
write("cutout", {**buffers(corners, floats(*[0, 1] * 4)),
      "accessors": [accessor(0, 5126, 4, "VEC3"),
                    accessor(1, 5126, 4, "VEC2")],
      "materials": [{"alphaMode": "MASK", "pbrMetallicRoughness": {
          "baseColorTexture": {"index": 0}}}, {"alphaMode": "BLEND"}],
      "textures": [{"source": 0, "sampler": 0}],
      "samplers": [{"wrapS": 33071}],
      "images": [{"uri": "data:image/png;base64,UE5H"}],
      "meshes": [{"primitives": [{"material": 0, "attributes": {
          "POSITION": 0, "TEXCOORD_0": 1}}]}], "nodes": [{"mesh": 0}]})
write("glass", {"materials": [{"extensions": {"KHR_materials_transmission": {
    "transmissionFactor": f}}} for f in (0.4, 1)]})
write("matrix", {"nodes": [{"matrix": [1, 0, 0, 0, 0, 1, 0, 0,
                                       0, 0, 1, 0, 5, 6, 7, 1]}],
                 "cameras": [{"type": "orthographic"}], "skins": [{}]})
write("beside", {"buffers": [{"uri": "a%20b.bin", "byteLength": 4}]})
