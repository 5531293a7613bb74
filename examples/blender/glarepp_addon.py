# SPDX-License-Identifier: Apache-2.0
"""Glare of bright pixels and lamps on what Blender 3.4 or later renders, by the
program glarepp. README.md beside this file says how to install and use it."""
import functools
import json
import math
import os
import re
import shutil
import subprocess
import tempfile

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

bl_info = {
    "name": "glarepp",
    "author": "the authors of glarepp",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "Compositor > Sidebar > glarepp",
    "description": "Adds the glare of bright pixels and lamps to each render",
    "category": "Compositing",
}
IMAGE = "glarepp"  # the datablock of the result

seen = {}  # look() of the last render, by the name of its scene
made = []  # frames of this render
said = set()  # its errors, so that one is not shown for each frame


class Problem(Exception):
    """An error that the user can mend: one line."""


# -- what the camera sees --------------------------------------------------------

def look(depsgraph):
    """Returns number, camera and lamps of a frame, in the terms of --camera and
    --lights. Only the evaluated scene has the places of the frame that is rendered."""
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    camera, render = scene.camera, scene.render
    view = {"frame": scene.frame_current, "camera": None, "lights": [], "drawn": [],
            "layer": layer.name, "depth": layer.use_pass_z}
    if not camera or camera.type != "CAMERA" or camera.data.type != "PERSP":
        return view
    size = [n * render.resolution_percentage // 100
            for n in (render.resolution_x, render.resolution_y)]
    world = camera.matrix_world.normalized()
    lens = camera.calc_matrix_camera(
        depsgraph, x=size[0], y=size[1], scale_x=render.pixel_aspect_x,
        scale_y=render.pixel_aspect_y)
    ndc = lens @ world.inverted()
    if render.use_border and render.use_crop_to_border:
        for i, low, high in ((0, render.border_min_x, render.border_max_x),
                             (1, render.border_min_y, render.border_max_y)):
            # (whole pixels, counted in single precision)
            low, high = (int(edge * size[i] + 1e-4) / size[i] for edge in (low, high))
            ndc[i] = (ndc[i] - ndc[3] * (low + high - 1)) / (high - low)
    view["camera"] = [x for row in ndc for x in row]
    # pixels to a steradian in the middle, and what scales the light of the render
    pixels = lens[0][0] * lens[1][1] * size[0] * size[1] / 4
    exposure = scene.cycles.film_exposure if render.engine == "CYCLES" else 1
    for instance in depsgraph.object_instances:
        thing, matrix = instance.object, instance.matrix_world
        if thing.type == "LIGHT" and not thing.hide_render:
            view["lights"].append(lamp(thing, matrix, world, pixels, exposure))
            view["drawn"].append(render.engine == "CYCLES" and thing.visible_camera and
                                 size_of(thing.data, matrix) > 0)
    return view


def lamp(thing, matrix, camera, pixels, exposure):
    """Returns a light of --lights. Its flux is the sum of the pixels that Cycles
    draws of it: irradiance at the camera, times pixels to a steradian."""
    data, along = thing.data, matrix.col[2].xyz.normalized()  # lamps shine along -z
    sun, size = data.type == "SUN", size_of(data, matrix)
    to = along if sun else matrix.translation - camera.translation
    distance = 1 if sun else max(to.length, 1e-6)
    to = to.normalized()
    ahead = -to.dot(camera.col[2].xyz)  # cosine of the angle from the view axis
    pixels *= ahead ** -3 if ahead > 1e-3 else 0
    power = data.energy * exposure * 2 ** getattr(data, "exposure", 0)
    if not sun:
        power *= share_of(data, to.dot(along)) / distance ** 2
    light = {"name": thing.name,
             "flux": [min(max(power * pixels * c, 0), 1e12) for c in data.color]}
    if sun:
        light.update(direction=list(to), degrees=min(math.degrees(size), 90))
    else:
        own = size / max(distance * ahead, size + 1e-6)  # its bulb does not hide it
        light.update(world=list(matrix.translation), bias=min(1e-3 + own, 1),
                     radius=min(size * math.sqrt(pixels) / distance, 1e6) or 0.5)
    return light


def size_of(data, matrix):
    """Returns a lamp's radius, of a sun its angle."""
    if data.type == "SUN":
        return data.angle
    if data.type != "AREA":
        return data.shadow_soft_size
    x, y, _ = matrix.to_scale()
    other = data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size
    fill = math.pi / 4 if data.shape in {"DISK", "ELLIPSE"} else 1
    return math.sqrt(abs(fill * data.size * x * other * y) / math.pi)


def share_of(data, cosine):
    """Returns the watts a steradian that Cycles sends of a lamp of one watt at an
    angle from its axis."""
    if data.type == "AREA":
        cosine, half = min(max(cosine, 1e-6), 1), min(data.spread / 2, 1.57)
        spread = math.tan(half) - math.tan(math.acos(cosine))
        return cosine / 4 * max(spread, 0) / (math.tan(half) - half)
    share = 1 / (4 * math.pi)
    if data.type == "SPOT":
        rim = math.cos(data.spot_size / 2)
        t = (cosine - rim) / max((1 - rim) * data.spot_blend, 1e-6)
        t = min(max(t, 0), 1)
        share *= t * t * (3 - 2 * t)
    return share


# -- the program -----------------------------------------------------------------

def program():
    """Returns the path of glarepp. It is a preference, and not the scene's, so that
    no file that is opened chooses what is run."""
    addon = bpy.context.preferences.addons.get(__name__)
    name = addon.preferences.program if addon else "glarepp"
    path = shutil.which(bpy.path.abspath(name))
    if not path:
        raise Problem(f"glarepp: {name}: program not found; install glarepp, or give "
                      "its path in the add-on's preferences")
    return os.path.abspath(path)


def save(scene, path):
    """Writes the render with all its passes."""
    if scene.render.use_multiview:
        raise Problem("glarepp: a render of several views is not read; turn Stereoscopy "
                      "off")
    settings = scene.render.image_settings
    names = "file_format", "color_mode", "color_depth", "exr_codec"
    before = [getattr(settings, name) for name in names]
    try:
        settings.file_format = "OPEN_EXR_MULTILAYER"
        settings.color_depth, settings.exr_codec = "32", "NONE"
        bpy.data.images["Render Result"].save_render(path, scene=scene)
    except (KeyError, RuntimeError):
        raise Problem("glarepp: there is no render to read; render the scene first")
    finally:
        for name, value in zip(names, before):
            setattr(settings, name, value)


def options(own, view, folder):
    """Returns the options of the panel; writes the files that they name."""
    def put(name, value):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            json.dump(value, file)
        return name

    found = ["--style", own.style, "--gain", repr(own.gain),
             "--layer-in", view["layer"] + ".Combined"]
    if own.threshold:
        found += ["--threshold", own.threshold]
    if view["camera"]:
        found += ["--camera", put("camera.json", {"frames": [
            {"frame": view["frame"], "worldToNDC_blender_colvec": view["camera"]}]})]
    elif own.lights != "OFF":
        raise Problem("glarepp: lights need a perspective camera; take another camera, "
                      "or turn lights off")
    if own.lights != "OFF" and view["lights"]:
        shown = own.lights == "SHOWN" or all(view["drawn"])
        # without --sun-in-frame, a lamp that is in the pixels must not add its light
        found += ["--sun-in-frame"] * shown + ["--lights", put("lights.json", [
            {**light, "flux": 0} if drawn and not shown else light
            for light, drawn in zip(view["lights"], view["drawn"])])]
        if view["depth"]:
            found += ["--depth", view["layer"] + ".Depth.Z"]
    return found


def make(scene, view):
    """Runs glarepp on the render. Returns the picture's path, the report and the
    warnings."""
    path = re.sub("#+", lambda signs: str(view["frame"]).zfill(len(signs[0])),
                  scene.glarepp.output)
    if path.startswith("//") and not bpy.data.filepath:
        path = os.path.join(bpy.app.tempdir, path[2:])
    if not path.lower().endswith(".exr"):
        raise Problem(f"glarepp: the output must be an EXR (found \"{path}\"); name it "
                      ".exr")
    run, final = program(), bpy.path.abspath(path)
    with tempfile.TemporaryDirectory(dir=bpy.app.tempdir) as folder:
        save(scene, os.path.join(folder, "frame.exr"))
        done = subprocess.run(
            [run, *options(scene.glarepp, view, folder), "--tonemap", "none", "--alpha",
             "keep", "--report", "report.json", "-o", "glare.exr", "frame.exr"],
            cwd=folder, stdin=subprocess.DEVNULL, capture_output=True,
            encoding="utf-8", errors="replace")
        words = done.stderr.strip().splitlines()
        if done.returncode:
            raise Problem(words[-1] if words else f"{run}: died ({done.returncode})")
        with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
            report = file.read()
        try:
            os.makedirs(os.path.dirname(final), exist_ok=True)
            shutil.move(os.path.join(folder, "glare.exr"), final)
        except OSError as error:
            raise Problem(f"glarepp: {final}: {error.strerror}; choose another output")
    return path, report, words


def load(scene, path, report):
    """Shows the picture in the image, or from the second frame of an animation on the
    sequence, which the compositor's nodes then play."""
    image = bpy.data.images.get(IMAGE)
    if not image:
        image = bpy.data.images.load(path)
        image.name = IMAGE
    sequence = len(made) > 1 and "#" in scene.glarepp.output
    image.source, image.filepath = "SEQUENCE" if sequence else "FILE", path
    image.reload()
    image["report"] = report
    for node in scene.node_tree.nodes if sequence and scene.node_tree else ():
        if node.type == "IMAGE" and node.image == image:
            node.frame_start, node.frame_offset = min(made), min(made) - 1
            node.frame_duration = max(made) - min(made) + 1
            node.use_auto_refresh = True


# -- after each render -----------------------------------------------------------

def later(function, *words):
    """Calls it in the main thread, which alone may change Blender's data: with a
    window, renders have a thread of their own."""
    if bpy.app.background:
        function(*words)
    else:
        bpy.app.timers.register(functools.partial(function, *words))


def show(text):
    print(text)
    manager = bpy.context.window_manager
    if not bpy.app.background:
        with bpy.context.temp_override(window=manager.windows[0]):
            manager.popup_menu(lambda menu, _: menu.layout.label(text=text),
                               title="glarepp", icon="ERROR")


@bpy.app.handlers.persistent
def on_start(scene, _):
    said.clear()
    made.clear()
    seen.pop(scene.name, None)
    if scene.glarepp.after_render and scene.glarepp.lights != "OFF":
        for layer in scene.view_layers:
            layer.use_pass_z = True  # depth says what hides a lamp


@bpy.app.handlers.persistent
def on_evaluated(scene, depsgraph):
    # motion blur moves the scene between frames, and each view layer has a depsgraph:
    # the first of a frame counts
    before = seen.get(scene.name)
    if (depsgraph and depsgraph.mode == "RENDER" and scene.frame_subframe == 0 and
            not (before and before["frame"] == scene.frame_current)):
        seen[scene.name] = look(depsgraph)


@bpy.app.handlers.persistent
def on_rendered(scene, _):
    if not scene.glarepp.after_render or scene.name not in seen:
        return
    try:
        path, report, words = make(scene, seen[scene.name])
        made.append(scene.frame_current)
        for text in words:
            print(text)
        later(load, scene, path, report)
    except Problem as problem:
        if str(problem) not in said:
            said.add(str(problem))
            later(show, str(problem))


HANDLERS = {"render_init": on_start, "frame_change_post": on_evaluated,
            "render_post": on_rendered}


# -- the panel -------------------------------------------------------------------

class GlareppPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: StringProperty(
        name="Program", default="glarepp", subtype="FILE_PATH",
        description="Path of glarepp, or its name if it is on PATH")

    def draw(self, _):
        self.layout.prop(self, "program")


class GlareppSettings(bpy.types.PropertyGroup):
    after_render: BoolProperty(
        name="After Each Render", description="Add glare to every frame that is "
        "rendered. With lights, the Z pass is turned on")
    style: EnumProperty(name="Style", items=[(s, s, "") for s in (
        "camera", "vintage", "mist", "anamorphic", "halation", "star", "eye",
        "eye-night")])
    gain: FloatProperty(name="Level", default=1, min=0, soft_max=4, max=1e6,
                        description="Scale of the glare")
    threshold: StringProperty(
        name="Threshold", description="Luminance over which pixels glare: a number, a "
        "percentile as 99.9%, or EV over the mean as +3ev. Empty: the style's")
    lights: EnumProperty(name="Lights", default="ADD", items=(
        ("OFF", "Off", "Only the frame's pixels glare"),
        ("ADD", "Add", "Lamps that the frame does not show glare too"),
        ("SHOWN", "In the Frame", "The frame shows all lamps, as bulbs perhaps, and "
         "their pixels glare: lamps drive only flares and lenses")))
    output: StringProperty(
        name="Output", default="//glarepp_####.exr", subtype="FILE_PATH",
        description="Scene-linear EXR; # are digits of the frame's number")


class GLAREPP_OT_apply(bpy.types.Operator):
    """Add glare to the last render"""
    bl_idname = "glarepp.apply"
    bl_label = "Apply Now"

    def execute(self, context):
        scene = context.scene
        view = seen.get(scene.name) or look(context.evaluated_depsgraph_get())
        try:
            path, report, words = make(scene, view)
        except Problem as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        load(scene, path, report)
        for text in words:
            self.report({"WARNING"}, text)
        return {"FINISHED"}


class GLAREPP_PT_panel(bpy.types.Panel):
    bl_label = "glarepp"
    bl_space_type, bl_region_type, bl_category = "NODE_EDITOR", "UI", "glarepp"

    @classmethod
    def poll(cls, context):
        return context.space_data.tree_type == "CompositorNodeTree"

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in "style", "gain", "threshold", "lights", "output":
            column.prop(context.scene.glarepp, name)
        column.operator("glarepp.apply")
        self.layout.prop(context.scene.glarepp, "after_render")
        image = bpy.data.images.get(IMAGE)
        lights = json.loads(image.get("report", "{}")).get("lights", []) if image else []
        for light in lights[:16]:
            share = light.get("visibility", 0)
            column.label(text=f"{light['name']}: {100 * share:.0f} % visible",
                         icon="LIGHT")


CLASSES = GlareppPreferences, GlareppSettings, GLAREPP_OT_apply, GLAREPP_PT_panel


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.glarepp = bpy.props.PointerProperty(type=GlareppSettings)
    for name, function in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(function)


def unregister():
    for name, function in HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(function)
    del bpy.types.Scene.glarepp
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)


if __name__ == "__main__":
    register()
