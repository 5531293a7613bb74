#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The add-on of examples/blender in Blender without a window: three lamps and a sun
# behind an edge, in stills and an animation.
. "$(dirname "$0")/cli/lib.sh"

command -v blender >/dev/null || {
    skip 1 'no blender' # (one that is counted)
    done_testing
    exit
}
mkdir -p scripts/addons
cp "$root/examples/blender/glarepp_addon.py" scripts/addons

cat >shot.py <<'E_PY'
import json, math, os, sys
import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

WIDTH, HEIGHT = 240, 136
verdicts = open("verdicts", "w")

def check(good, what, *found):
    verdicts.write(f"{'ok' if good else 'not ok'} {what}\n")
    if not good:
        verdicts.write(f"# {found}\n")
    verdicts.flush()

bpy.ops.preferences.addon_enable(module="glarepp_addon")
preferences = bpy.context.preferences.addons["glarepp_addon"].preferences
scene = bpy.context.scene
own, render = scene.glarepp, scene.render
for thing in list(scene.objects):
    bpy.data.objects.remove(thing)

def add(name, data, matrix=Matrix()):
    thing = bpy.data.objects.new(name, data)
    thing.matrix_world = matrix
    scene.collection.objects.link(thing)
    return thing

def lamp(name, kind, place=(0, 0, 0), **keys):
    data = bpy.data.lights.new(name, kind)
    for key, value in keys.items():
        setattr(data, key, value)
    return add(name, data, Matrix.Translation(place))

def rectangle(name, x0, x1, y, z0, z1):
    data = bpy.data.meshes.new(name)
    data.from_pydata([(x0, y, z0), (x1, y, z0), (x1, y, z1), (x0, y, z1)], [],
                     [(0, 1, 2, 3)])
    return add(name, data)

# The camera at the origin looks along y; a place (x, y, z) is x / y and z / y from the
# middle, in focal lengths of FOCAL pixels. It moves in the animation.
lens = bpy.data.cameras.new("Camera")
scene.camera = add("Camera", lens, Matrix.Rotation(math.pi / 2, 4, "X"))
FOCAL = WIDTH * lens.lens / lens.sensor_width
lamps = [lamp("clear", "POINT", (-2, 10, 1), energy=3000, shadow_soft_size=.2),
         lamp("hidden", "POINT", (-2, 10, -1), energy=3000, shadow_soft_size=.2),
         lamp("area", "AREA", (0, 10, -1.5), energy=900, shape="DISK", size=.5)]
lamps[2].rotation_euler = -math.pi / 2, 0, .2
rectangle("screen", -1.8, -.2, 6, -1.2, -.2)
sun = lamp("sun", "SUN", energy=2, angle=math.radians(6))
toward = Vector((30 / FOCAL, 1, 20 / FOCAL))
sun.rotation_euler = toward.to_track_quat("Z", "Y").to_euler()
# the edge is where pixel 157 begins, 7 pixels right of the sun's centre: it covers
# what is right of it
EDGE = 157
rectangle("wall", (EDGE - WIDTH / 2) / FOCAL * 8, 9, 8, -9, 9)

render.engine = "CYCLES"
scene.cycles.samples = 16
scene.cycles.use_denoising = False
render.resolution_x, render.resolution_y, render.resolution_percentage = 480, 272, 50
scene.world.node_tree.nodes["Background"].inputs[1].default_value = 0

def pixels(image):
    return np.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)[::-1, :, :3]

def rendered(path):
    """Renders, and returns the frame as it is without glare."""
    settings = render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    render.filepath = os.path.abspath(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath)
    found = pixels(image)
    bpy.data.images.remove(image)
    return found

def result():
    image = bpy.data.images["glarepp"]
    return pixels(image), json.loads(image["report"])

def pixel_of(thing):
    at = thing.matrix_world.translation
    if thing == sun:
        at = scene.camera.matrix_world.translation + 1e5 * toward.normalized()
    x, y, _ = world_to_camera_view(scene, scene.camera, at)
    return x * WIDTH, (1 - y) * HEIGHT

def places(report, what):
    off = [math.dist((light["x"], light["y"]), pixel_of(scene.objects[light["name"]]))
           for light in report["lights"]]
    check(len(off) == 4 and max(off) < .5, f"{what}: places within .5 pixel", off)

def clear_share(r, d):
    """Returns the share of a disc that is left of an edge d right of its centre."""
    return 1 - (r * r * math.acos(d / r) - d * math.sqrt(r * r - d * d)) / (math.pi * r * r)

# -- a still -----------------------------------------------------------------------

preferences.program = os.environ["GLAREPP_PROGRAM"]
try:
    bpy.ops.glarepp.apply()
    check(False, "nothing is rendered: an error")
except RuntimeError as error:
    check(str(error).strip().count("\n") == 0 and "render the scene first" in str(error),
          "nothing is rendered: an error of one line", str(error))
own.after_render = True
before = rendered("still.exr")
after, report = result()
places(report, "still")
light = {l["name"]: l for l in report["lights"]}
d = EDGE - light["sun"]["x"]
truth = {"clear": 1, "hidden": 0, "area": 1, "sun": clear_share(light["sun"]["radius"], d)}
shares = {name: light[name]["visibility"] for name in truth}
check(all(abs(shares[n] - truth[n]) < .01 for n in truth), "shares within .01",
      shares, truth)
check(.6 < truth["sun"] < .9, "the sun is behind an edge", truth)
check(abs(after - before).max() > .1, "the picture changed")
x, y = (int(v) for v in pixel_of(lamps[0]))
check(after[y, x].min() > before[y, x].max() + .1, "a lamp glares where it is",
      before[y, x], after[y, x])
check(render.image_settings.file_format == "OPEN_EXR" and
      render.image_settings.color_depth == "32", "the scene's output is as it was")

# -- light that the frame holds ----------------------------------------------------

flux = sum(l["flux"][0] * shares[l["name"]]
           for l in sys.modules["glarepp_addon"].seen[scene.name]["lights"])
added = report["flux_in"][0]
own.lights = "OFF"
bpy.ops.glarepp.apply()
plain = result()[1]
check("lights" not in plain or not plain["lights"], "lights off", plain.get("lights"))
check(abs(added - plain["flux_in"][0] - flux) < .01 * flux, "lamps add their flux",
      added, plain["flux_in"][0], flux)
for thing in lamps + [sun]:
    thing.visible_camera = True
lights = {l["name"]: l for l in sys.modules["glarepp_addon"].seen[scene.name]["lights"]}
drawn = rendered("drawn.exr") - before
for thing, margin in ((lamps[0], 12), (lamps[2], 14), (sun, 0)):
    x, y = (int(v) for v in pixel_of(thing))
    part = drawn[y - 24:y + 24, x - 24:x + 24] if thing == sun else \
        drawn[y - margin:y + margin, x - margin:x + margin]
    wanted = lights[thing.name]["flux"][0] * shares[thing.name]
    check(abs(part[..., 0].sum() / wanted - 1) < .015,
          f"{thing.name}: the flux is that of the pixels that Cycles draws",
          part[..., 0].sum(), wanted)
own.lights = "OFF"
bpy.ops.glarepp.apply()
alone = result()[1]["flux_in"][0]
own.lights = "ADD"
bpy.ops.glarepp.apply()
both = result()[1]
check(both["settings"]["sun_in_frame"] and both["flux_in"][0] == alone,
      "drawn lamps are not added", both["flux_in"], alone)
lamps[0].visible_camera = False
own.after_render = False
rendered("some.exr")
bpy.ops.glarepp.apply()
some = result()[1]["flux_in"][0]
own.lights = "OFF"
bpy.ops.glarepp.apply()
check(abs(some - result()[1]["flux_in"][0] - lights["clear"]["flux"][0]) < .01 * some,
      "of some that are drawn, the others are added", some)

# -- options and errors ------------------------------------------------------------

own.style, own.threshold, own.gain = "star", "+3ev", 2
bpy.ops.glarepp.apply()
settings = result()[1]["settings"]
check(settings["style"] == "star" and settings["gain"] == 2 and
      result()[1]["threshold"] != 1, "style, level and threshold reach the program", settings)
own.threshold = "much"
try:
    bpy.ops.glarepp.apply()
    check(False, "an option that is refused: an error")
except RuntimeError as error:
    check("--threshold" in str(error), "an option that is refused: an error", str(error))
own.threshold, own.lights, own.style = "", "ADD", "camera"
lens.type = "ORTHO"
rendered("flat.exr")
try:
    bpy.ops.glarepp.apply()
    check(False, "lights of an orthographic camera: an error")
except RuntimeError as error:
    check("perspective" in str(error), "lights of an orthographic camera: an error",
          str(error))
lens.type = "PERSP"

# -- an animation ------------------------------------------------------------------

own.after_render = True
own.output = os.path.abspath("glare_####.exr")
render.use_border = render.use_crop_to_border = False
for number, x in ((7, 0), (9, .4)):
    scene.camera.location[0] = x
    scene.camera.keyframe_insert("location", frame=number)
    lamps[0].location[2] = 1 + x
    lamps[0].keyframe_insert("location", frame=number)
scene.use_nodes = True
node = scene.node_tree.nodes.new("CompositorNodeImage")
node.image = bpy.data.images["glarepp"]
scene.frame_start, scene.frame_end = 7, 9
render.filepath = os.path.abspath("shot_####")
moved = []
def each(scene, _):
    moved.append((scene.frame_current, json.loads(node.image["report"])))
bpy.app.handlers.render_post.append(each)
bpy.ops.render.render(animation=True)
bpy.app.handlers.render_post.remove(each)
check([number for number, _ in moved] == [7, 8, 9] and
      all(os.path.exists(f"glare_000{n}.exr") for n in (7, 8, 9)), "a file a frame", moved)
for number, report in moved:
    scene.frame_set(number)
    places(report, f"frame {number}")
check(node.image.source == "SEQUENCE" and
      (node.frame_start, node.frame_offset, node.frame_duration) == (7, 6, 3),
      "the compositor has a sequence", node.frame_start, node.frame_duration)

# -- a part of the picture ---------------------------------------------------------

render.use_border = render.use_crop_to_border = True
render.border_min_x, render.border_max_x = .2, .9
render.border_min_y, render.border_max_y = .1, 1
scene.frame_set(7)
bpy.ops.render.render()
off = [math.dist((light["x"] + int(.2 * WIDTH), light["y"]),
                 pixel_of(scene.objects[light["name"]]))
       for light in json.loads(bpy.data.images["glarepp"]["report"])["lights"]]
check(len(off) == 4 and max(off) < .5, "a cropped render: places within .5 pixel", off)

# -- no program --------------------------------------------------------------------

preferences.program = "/nowhere/glarepp"
print("-- no program", flush=True)
bpy.ops.render.render(animation=True)
print("-- end", flush=True)
try:
    bpy.ops.glarepp.apply()
    check(False, "a missing program: an error")
except RuntimeError as error:
    check(str(error).strip().count("\n") == 0 and "/nowhere/glarepp" in str(error),
          "a missing program: an error of one line", str(error))
bpy.ops.preferences.addon_disable(module="glarepp_addon")
check(not hasattr(scene, "glarepp") and not any(
    f.__module__ == "glarepp_addon" for f in bpy.app.handlers.render_post),
      "the add-on leaves nothing behind")
verdicts.close()
E_PY

HOME=$tmp BLENDER_USER_SCRIPTS=$tmp/scripts GLAREPP_PROGRAM=$glarepp \
    blender -b --factory-startup --python-exit-code 1 --python shot.py >log 2>&1
is $? 0 'blender runs the scene' || note "$(tail -n 20 log)"
verdicts verdicts
is "$(sed -n '/^-- no program/,/^-- end/p' log | grep -c '^glarepp: .*program not found')" \
    1 'a missing program is one message of an animation'
done_testing
