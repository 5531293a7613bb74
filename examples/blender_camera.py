# SPDX-License-Identifier: Apache-2.0
"""Writes the JSON of glarepp --camera: camera and sun of each frame of a scene.

Usage: blender -b shot.blend -P blender_camera.py -- shot.camera.json
       glarepp --camera shot.camera.json --sun-color 5e4 -o out.####.png shot.####.exr
"""
import json
import math
import sys

import bpy

scene = bpy.context.scene
render = scene.render
width = render.resolution_x * render.resolution_percentage // 100
height = render.resolution_y * render.resolution_percentage // 100
suns = [o for o in scene.objects if o.type == "LIGHT" and o.data.type == "SUN"]
frames = []
for number in range(scene.frame_start, scene.frame_end + 1, scene.frame_step):
    scene.frame_set(number)  # markers may change the camera
    view = scene.camera.matrix_world.normalized().inverted()
    lens = scene.camera.calc_matrix_camera(
        bpy.context.evaluated_depsgraph_get(), x=width, y=height,
        scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y)
    ndc = lens @ view
    frame = {
        "frame": number,
        # for row vectors, with z positive in front of the camera as in OpenEXR
        "worldToCamera_rowmajor": [(-1 if c == 2 else 1) * view[c][r]
                                   for r in range(4) for c in range(4)],
        "worldToNDC_blender_colvec": [ndc[r][c] for r in range(4) for c in range(4)],
    }
    if suns:  # the first: a lamp shines along its -z
        frame["sun_dir_world"] = [suns[0].matrix_world[r][2] for r in range(3)]
        frame["sun_radius_px"] = (math.tan(suns[0].data.angle / 2) * lens[0][0] *
                                  width / 2)
    frames.append(frame)
with open(sys.argv[sys.argv.index("--") + 1], "w") as f:
    json.dump({"width": width, "height": height, "frames": frames}, f, indent=1)
