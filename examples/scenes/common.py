# SPDX-License-Identifier: Apache-2.0
"""What the scenes share: shapes, materials, lamps, camera, air, render and file.

A scene ends with render(), which reads "-- -o FILE [--scale PERCENT] [--samples N]".
Lengths are metres; radiance is in scene units, 1 being white at exposure 0.
"""
import argparse
import math
import os
import sys
import tempfile

import bpy
import numpy as np
import OpenImageIO as oiio
from mathutils import Matrix, Vector

parser = argparse.ArgumentParser(prog="blender -b -P SCENE.py --")
parser.add_argument("-o", "--output", required=True, help="EXR; #### becomes the frame")
parser.add_argument("--scale", type=int, default=100, help="percent of the size")
parser.add_argument("--samples", type=int, help="a pixel, in place of the scene's")
parser.add_argument("--frame", type=int, help="this one alone")
args = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.world = bpy.data.worlds.new("World")
scene.world.use_nodes = True


# Materials

class Nodes:
    """The shader nodes of a material or of the world."""

    def __init__(self, tree):
        self.tree = tree

    def put(self, socket, value):
        """Links a socket to another, or gives it a value; RGB becomes RGBA."""
        if isinstance(value, bpy.types.Node):
            value = value.outputs[0]
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif socket.type == "RGBA" and len(value) == 3:
            socket.default_value = (*value, 1)
        else:
            socket.default_value = value

    def add(self, kind, *inputs, set=(), **named):
        """Adds a node: its attributes in `set`, inputs by place or by Name_of_it."""
        node = self.tree.nodes.new("ShaderNode" + kind)
        for key, value in dict(set).items():
            setattr(node, key, value)
        for i, value in enumerate(inputs):
            if value is not None:
                self.put(node.inputs[i], value)
        for key, value in named.items():
            self.put(node.inputs[key.replace("_", " ")], value)
        return node

    def math(self, operation, *inputs):
        return self.add("Math", *inputs, set={"operation": operation})

    def ramp(self, value, *stops):
        """Maps 0 to 1 onto colours: pairs (place, RGB or grey)."""
        node = self.add("ValToRGB", value)
        ramp = node.color_ramp
        while len(ramp.elements) < len(stops):
            ramp.elements.new(1)
        for element, (place, colour) in zip(ramp.elements, stops):
            element.position = place
            element.color = (*(colour if hasattr(colour, "__len__") else [colour] * 3), 1)
        return node

    def noise(self, scale, detail=4, rough=0.5, stretch=(1, 1, 1)):
        """Noise from 0 to 1 in metres of the world."""
        where = self.add("NewGeometry").outputs["Position"]
        where = self.add("Mapping", where, Scale=stretch)
        return self.add("TexNoise", Vector=where, Scale=scale, Detail=detail,
                        Roughness=rough)


class Material(Nodes):
    """A principled surface, or with `emit` one that only shines."""

    def __init__(self, name, colour=(0.5, 0.5, 0.5), rough=0.5, emit=None, **named):
        self.data = bpy.data.materials.new(name)
        self.data.use_nodes = True
        super().__init__(self.data.node_tree)
        self.tree.nodes.clear()
        self.out = self.add("OutputMaterial")
        if emit is None:
            self.shader = self.add("BsdfPrincipled", Base_Color=colour,
                                   Roughness=rough, **named)
        else:
            self.shader = self.add("Emission", colour, emit)
        self.put(self.out.inputs["Surface"], self.shader)

    def feed(self, **named):
        for key, value in named.items():
            self.put(self.shader.inputs[key.replace("_", " ")], value)
        return self

    def bump(self, height, distance=0.01, strength=1.0):
        self.feed(Normal=self.add("Bump", Strength=strength, Distance=distance,
                                  Height=height))
        return self

    def unsampled(self):
        """Leaves it to chance rays to find this light, for large and dim ones."""
        self.data.cycles.sample_as_light = False
        return self


# Shapes

def mesh(name, vertices, faces, material, smooth=False):
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(v) for v in vertices], [], faces)
    data.update()
    if smooth:
        data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
    return add(name, data, material)


def add(name, data, material=None, matrix=None):
    if material and not data.materials:
        data.materials.append(material.data)
    thing = bpy.data.objects.new(name, data)
    if matrix:
        thing.matrix_world = matrix
    scene.collection.objects.link(thing)
    return thing


def boxes(name, list_of_boxes, material, bevel=0.0):
    """Axis-aligned boxes (x0, y0, z0, x1, y1, z1) as one mesh."""
    vertices, faces = [], []
    for x0, y0, z0, x1, y1, z1 in list_of_boxes:
        n = len(vertices)
        vertices += [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
        faces += [tuple(n + i for i in f) for f in (
            (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7),
            (2, 0, 4, 6))]
    thing = mesh(name, vertices, faces, material)
    return rounded(thing, bevel) if bevel else thing


def rounded(thing, width, segments=2):
    modifier = thing.modifiers.new("Bevel", "BEVEL")
    modifier.width, modifier.segments = width, segments
    modifier.limit_method = "ANGLE"
    return thing


def lathe(name, profile, material, at=(0, 0, 0), steps=48):
    """Turns (radius, z) pairs about the axis z."""
    vertices = [(at[0] + r * math.cos(2 * math.pi * i / steps),
                 at[1] + r * math.sin(2 * math.pi * i / steps), at[2] + z)
                for r, z in profile for i in range(steps)]
    faces = [(j * steps + i, j * steps + (i + 1) % steps,
              (j + 1) * steps + (i + 1) % steps, (j + 1) * steps + i)
             for j in range(len(profile) - 1) for i in range(steps)]
    return mesh(name, vertices, faces, material, smooth=True)


def tubes(name, lines, radius, material):
    """Round tubes along lines of points, as one curve."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions, data.bevel_depth, data.bevel_resolution = "3D", radius, 2
    data.use_fill_caps = True
    for line in lines:
        spline = data.splines.new("POLY")
        spline.points.add(len(line) - 1)
        for point, p in zip(spline.points, line):
            point.co = (*p[:3], 1)
            point.radius = p[3] if len(p) > 3 else 1
    return add(name, data, material)


def text(words, material, matrix, size=1.0, tube=0.0, extrude=0.0, space=1.0):
    """Letters, or with `tube` their outlines as tubes of that radius."""
    data = bpy.data.curves.new(words, "FONT")
    data.body, data.size, data.align_x, data.align_y = words, size, "CENTER", "CENTER"
    data.space_line = space
    data.extrude = extrude
    if tube:
        data.fill_mode, data.bevel_depth, data.bevel_resolution = "NONE", tube, 2
    return add(words, data, material, matrix)


def quad_sphere(at, radius, steps=16):
    """Vertices and faces of a ball, for many in one mesh."""
    vertices, faces = [], []
    for j in range(steps // 2 + 1):
        a = math.pi * j / (steps // 2)
        vertices += [(at[0] + radius * math.sin(a) * math.cos(2 * math.pi * i / steps),
                      at[1] + radius * math.sin(a) * math.sin(2 * math.pi * i / steps),
                      at[2] + radius * math.cos(a)) for i in range(steps)]
    for j in range(steps // 2):
        faces += [(j * steps + i, (j + 1) * steps + i,
                   (j + 1) * steps + (i + 1) % steps, j * steps + (i + 1) % steps)
                  for i in range(steps)]
    return vertices, faces


def balls(name, places, radius, material):
    vertices, faces = [], []
    for at in places:
        v, f = quad_sphere(at, radius)
        faces += [tuple(i + len(vertices) for i in face) for face in f]
        vertices += v
    return mesh(name, vertices, faces, material, smooth=True)


def blades(name, places, height, width, material, lean=0.5):
    """Grass: a bent blade of two faces at each place."""
    at = np.array(places)
    n = len(at)
    rng = np.random.default_rng(n)
    turn = rng.uniform(0, 2 * math.pi, n)
    tall = height * rng.uniform(0.5, 1.3, n)[:, None]
    side = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1) * width / 2
    over = np.stack([-np.sin(turn), np.cos(turn), 0 * turn], -1) * tall * \
        lean * rng.uniform(0.3, 1.5, n)[:, None]
    up = np.array([0, 0, 1]) * tall
    v = np.stack([at - side, at + side, at + 0.6 * up + 0.3 * over - 0.8 * side,
                  at + 0.6 * up + 0.3 * over + 0.8 * side, at + 0.95 * up + over], 1)
    i = np.arange(n)[:, None] * 5
    faces = [tuple(f) for f in i + [0, 1, 3, 2]] + [tuple(f) for f in i + [2, 3, 4]]
    return mesh(name, v.reshape(-1, 3), faces, material, smooth=True)


def tree(at, height, rng, spread=0.55, twigs=4):
    """Lines of a bare tree, with the radius as fourth number, and its tips."""
    lines, tips = [], []

    def branch(p, direction, length, radius, level):
        line = [(*p, radius)]
        steps = 6
        for i in range(steps):
            direction = direction + Vector(rng.gauss(0, 0.10 + 0.04 * level) for _ in range(3))
            direction = (direction + Vector((0, 0, 0.05 * level))).normalized()
            p = p + direction * length / steps
            radius *= 0.9
            line.append((*p, radius))
            if level < twigs and i >= (2 if level == 0 else 1):
                for _ in range(2 if level == 0 else 1):
                    side = direction.orthogonal()
                    side.rotate(Matrix.Rotation(rng.uniform(0, 2 * math.pi), 3, direction))
                    branch(p, (direction * (1 - spread) + side * spread).normalized(),
                           length * rng.uniform(0.42, 0.66), radius * 0.55, level + 1)
        tips.append((p, direction))
        lines.append(line)

    branch(Vector(at), Vector((rng.gauss(0, 0.05), rng.gauss(0, 0.05), 1)).normalized(),
           height * 0.62, height * 0.022, 0)
    return lines, tips


# Light

def only_camera(thing):
    """Hides from all rays but the camera's what a lamp stands for."""
    for kind in "diffuse", "glossy", "transmission", "volume_scatter", "shadow":
        setattr(thing, "visible_" + kind, False)
    return thing


LAMPS = []  # (place, radius, radiance) of those seen, for the air


def bulb(at, radius, radiance, name="Bulb", show=True):
    """A glowing ball: a lamp for the light and its picture for the camera."""
    data = bpy.data.lights.new(name, "POINT")
    data.shadow_soft_size = radius
    peak = max(radiance)
    # the flux of a Lambertian ball
    data.energy = 4 * math.pi ** 2 * radius ** 2 * peak
    data.color = [c / peak for c in radiance]
    add(name, data, matrix=Matrix.Translation(at))
    if show:
        only_camera(balls(name, [at], radius, Material(name, data.color, emit=peak)))
        LAMPS.append((at, radius, radiance))


def sun(direction, irradiance, colour=(1, 1, 1), angle=0.533):
    """Parallel light from `direction`; returns the radiance of its disc."""
    data = bpy.data.lights.new("Sun", "SUN")
    data.angle = math.radians(angle)
    data.energy, data.color = irradiance, colour
    matrix = Vector(direction).to_track_quat("Z", "Y").to_matrix().to_4x4()
    add("Sun", data, matrix=matrix)
    return irradiance / (math.pi * math.sin(math.radians(angle / 2)) ** 2)


def sky(*stops, disc=None, lights=True, sampled=False):
    """Background by height: (sine of elevation, RGB) pairs; disc = (direction,
    radiance) draws the sun for the camera alone, as the lamp gives its light.
    With lights=False the camera alone sees all of it; `sampled` aims rays at it."""
    if not sampled:
        scene.world.cycles.sampling_method = "NONE"
    n = Nodes(scene.world.node_tree)
    n.tree.nodes.clear()
    ray = n.add("NewGeometry").outputs["Incoming"]
    ray = n.add("VectorMath", ray, set={"operation": "SCALE"}, Scale=-1.0).outputs[0]
    height = n.add("SeparateXYZ", ray).outputs["Z"]
    peak = max(max(colour) for _, colour in stops)
    shade = n.add("Background", n.ramp(height, *(
        (place, [c / peak for c in colour]) for place, colour in stops)), peak)
    camera = n.add("LightPath").outputs["Is Camera Ray"]
    if not lights:
        n.put(shade.inputs["Strength"], n.math("MULTIPLY", camera, peak))
    if disc:
        direction, radiance = disc
        toward = n.add("VectorMath", ray, Vector(direction).normalized(),
                       set={"operation": "DISTANCE"}).outputs["Value"]
        inside = n.math("LESS_THAN", toward, 2 * math.sin(math.radians(0.533) / 4))
        seen = n.math("MULTIPLY", inside, camera)
        shade = n.add("AddShader", shade,
                      n.add("Background", radiance, seen))
    n.put(n.add("OutputWorld").inputs["Surface"], shade)


# Camera

def camera(at, look, width_degrees, size=(960, 540)):
    data = bpy.data.cameras.new("Camera")
    data.angle = math.radians(width_degrees)
    data.clip_end = 1000
    scene.camera = add("Camera", data)
    aim(at, look)
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = args.scale


def aim(at, look):
    turn = (Vector(look) - Vector(at)).to_track_quat("-Z", "Y")
    scene.camera.matrix_world = Matrix.Translation(at) @ turn.to_matrix().to_4x4()


def matrices():
    """worldToCamera and worldToNDC as OpenEXR wants them: row vectors, z positive
    in front of the camera, [0,1] with y down."""
    view = scene.camera.matrix_world.normalized().inverted()
    render = scene.render
    lens = scene.camera.calc_matrix_camera(
        bpy.context.evaluated_depsgraph_get(), x=render.resolution_x,
        y=render.resolution_y)
    half = Matrix(((0.5, 0, 0, 0.5), (0, -0.5, 0, 0.5), (0, 0, 1, 0), (0, 0, 0, 1)))
    flip = Matrix.Diagonal((1, 1, -1, 1))
    return [[m[c][r] for r in range(4) for c in range(4)]
            for m in (flip @ view, half @ lens @ view)]


def pixel_of(direction):
    """Pixel and radius in pixels of a sun in that direction."""
    view = scene.camera.matrix_world.normalized().inverted().to_3x3()
    x, y, z = view @ Vector(direction)
    width = scene.render.resolution_x * args.scale / 100
    height = scene.render.resolution_y * args.scale / 100
    focal = width / 2 / math.tan(scene.camera.data.angle / 2)
    return (width / 2 - focal * x / z, height / 2 + focal * y / z,
            focal * math.tan(math.radians(0.533 / 2)))


# Air: single scattering, computed for each pixel, so that it has no noise

class Air:
    """What the air adds along the rays of the camera up to `depth`."""

    def __init__(self, depth):
        height, width = depth.shape
        focal = width / 2 / math.tan(scene.camera.data.angle / 2)
        x, y = np.meshgrid((np.arange(width) + 0.5 - width / 2) / focal,
                           (height / 2 - np.arange(height) - 0.5) / focal)
        matrix = np.array(scene.camera.matrix_world.normalized())
        rays = np.stack([x, y, -np.ones_like(x)], -1)
        self.stretch = np.linalg.norm(rays, axis=-1)
        self.rays = (rays / self.stretch[..., None]) @ matrix[:3, :3].T
        self.eye = matrix[:3, 3]
        self.far = depth * self.stretch
        self.light = np.zeros((height, width, 3))

    def lamp(self, at, intensity, density, beam=None, steps=24):
        """Adds the light of a lamp of radiant intensity RGB; `beam` maps the unit
        vectors from it to a factor. Steps of equal angle seen from the lamp."""
        to = np.array(at) - self.eye
        along = self.rays @ to
        miss = np.sqrt(np.maximum((to @ to) - along ** 2, 1e-4))
        first = np.arctan2(-along, miss)
        angle = (np.arctan2(self.far - along, miss) - first) / steps
        total = np.zeros_like(miss)
        for i in range(steps):
            t = along + miss * np.tan(first + (i + 0.5) * angle)
            distance2 = (t - along) ** 2 + miss ** 2
            part = np.exp(-density * (t + np.sqrt(distance2)))
            if beam:
                out = self.eye + self.rays * t[..., None] - at
                part *= beam(out / np.sqrt(distance2)[..., None])
            total += part
        # dt = distance^2 / miss * d(angle); 1/distance^2 falls out
        total *= density / (4 * math.pi) * angle / miss
        self.light += total[..., None] * np.array(intensity)

    def shafts(self, lit, radiance, density, steps=96, reach=60.0):
        """Adds parallel light where lit(points) is above 0."""
        far = np.minimum(self.far, reach)
        for i in range(steps):
            t = far * (i + 0.5) / steps
            part = lit(self.eye + self.rays * t[..., None]) * far / steps
            self.light += (part * np.exp(-density * t) * density)[..., None] * \
                np.array(radiance)

    def streaks(self, tops, bottoms, light, width, steps=40):
        """Adds thin streaks `width` wide that shine with light(points) RGB, in
        front of what is there: points of a line, each shared by four pixels."""
        height, columns = self.far.shape
        matrix = np.array(scene.camera.matrix_world.normalized())
        focal = columns / 2 / math.tan(scene.camera.data.angle / 2)
        for i in range(steps):
            p = tops + (bottoms - tops) * (i + 0.5) / steps
            q = (p - self.eye) @ matrix[:3, :3]
            z = np.maximum(-q[:, 2], 1e-3)
            x = q[:, 0] / z * focal + columns / 2 - 0.5
            y = height / 2 - q[:, 1] / z * focal - 0.5
            ok = (q[:, 2] < -1) & (x > 0) & (y > 0) & (x < columns - 1) & (y < height - 1)
            x, y, z, q, length = x[ok], y[ok], z[ok], p[ok], np.linalg.norm(
                bottoms - tops, axis=-1)[ok]
            seen = z * self.stretch[y.astype(int), x.astype(int)] < \
                self.far[y.astype(int), x.astype(int)]
            area = length / steps * width * (focal / z) ** 2 * seen
            for dy in 0, 1:
                for dx in 0, 1:
                    share = abs(1 - dx - x % 1) * abs(1 - dy - y % 1) * area
                    np.add.at(self.light, (y.astype(int) + dy, x.astype(int) + dx),
                              share[:, None] * light(q))

    def haze(self, colour, density, reach=1e4):
        """Share of what is behind that comes through; adds the rest as colour."""
        clear = np.exp(-density * np.minimum(self.far, reach))[..., None]
        self.light += (1 - clear) * np.array(colour)
        return clear


# Render and file

# pass of light: its colour, levels of smoothing (each doubles the reach), and how
# many deviations of the noise two pixels may differ by
QUIET = {"DiffInd": ("DiffCol", 5, 8), "DiffDir": ("DiffCol", 3, 2.5),
         "GlossInd": ("GlossCol", 2, 2.5)}


def shifted(a, dy, dx):
    """The array moved by (dy, dx); the border repeats."""
    h, w = a.shape[:2]
    return a[np.clip(np.arange(h) + dy, 0, h - 1)[:, None],
             np.clip(np.arange(w) + dx, 0, w - 1)]


def smooth(light, normal, depth, levels, tolerance):
    """Edge-avoiding a-trous wavelets (Dammertz et al. 2010), with the local noise
    as measure (Schied et al. 2017): Debian's Cycles has no denoiser."""
    depth = np.minimum(depth[..., 0], 1e4)
    # the smaller step to either side: the larger may be an edge
    slope = 1e-3 * depth + np.maximum(*(np.minimum(
        abs(depth - shifted(depth, y, x)), abs(depth - shifted(depth, -y, -x)))
        for y, x in ((0, 1), (1, 0))))
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    normal = normal / np.maximum(length, 1e-6)
    # where surfaces share a pixel there is no normal to go by: it stays as it is
    sure = np.clip((length - 0.8) / 0.15, 0, 1)
    # a pixel far over all its neighbours is a chance path, not light
    ring = [shifted(light, y, x) for y in (-1, 0, 1) for x in (-1, 0, 1) if x or y]
    light = np.minimum(light, 1.5 * np.partition(np.stack(ring), -2, 0)[-2])
    noisy = light
    for level in range(levels):
        step = 2 ** level
        grey = light.mean(-1)
        around = [shifted(grey, y * step, x * step) for y in (-1, 0, 1) for x in (-1, 0, 1)]
        noise = np.std(around, 0) * tolerance + 1e-6
        total, weights = 0, 0
        for y in range(-2, 3):
            for x in range(-2, 3):
                kernel = (6, 4, 1)[abs(x)] * (6, 4, 1)[abs(y)]
                facing = np.sum(normal * shifted(normal, y * step, x * step), -1)
                apart = abs(depth - shifted(depth, y * step, x * step))
                near = np.exp(-apart / (slope * step * math.hypot(x, y) + 1e-6)
                              - abs(grey - shifted(grey, y * step, x * step)) / noise)
                weight = (kernel * np.maximum(facing, 1e-6) ** 32 * near)[..., None]
                total = total + weight * shifted(light, y * step, x * step)
                weights = weights + weight
        light = total / np.maximum(weights, 1e-12)
    return noisy + sure * (light - noisy)


def render(samples, bounces=4, air=None, clamp=8.0, frames=None, mist=100.0, quiet=QUIET):
    """Renders the frames; air(depth) returns light to add and share that passes.
    `mist` is the depth up to which the air is smooth along edges, `quiet` the
    passes whose noise is smoothed."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples = args.samples or samples
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces = bounces
    cycles.diffuse_bounces = cycles.glossy_bounces = bounces
    cycles.transmission_bounces = bounces
    cycles.transparent_max_bounces = 8
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.sample_clamp_direct, cycles.sample_clamp_indirect = 0, clamp
    cycles.blur_glossy = 0.5
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 1.0
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    # the sky is the pass Env, the coverage is the alpha of the rest
    scene.render.film_transparent = True
    scene.view_settings.view_transform = "Raw"
    layer = bpy.context.view_layer
    for name in ("z", "environment", "mist", "normal", "diffuse_color", "diffuse_direct",
                 "diffuse_indirect", "glossy_color", "glossy_direct", "glossy_indirect"):
        setattr(layer, "use_pass_" + name, True)
    scene.world.mist_settings.start, scene.world.mist_settings.depth = 0, mist
    scene.world.mist_settings.falloff = "LINEAR"
    image = scene.render.image_settings
    image.file_format, image.color_depth = "OPEN_EXR_MULTILAYER", "32"
    with tempfile.TemporaryDirectory() as folder:
        for frame in [args.frame] if args.frame else frames or [None]:
            if frame is not None:
                scene.frame_set(frame)
            scene.render.filepath = os.path.join(folder, "frame.exr")
            bpy.ops.render.render(write_still=True)
            write(scene.render.filepath, args.output.replace("####", str(frame)),
                  air, mist, frames, quiet)


def write(source, output, air, mist, frames, quiet):
    pixels = oiio.ImageBuf(source)
    names = pixels.spec().channelnames
    values = pixels.get_pixels(oiio.FLOAT)

    def pick(layer, letters):
        return np.stack([values[..., names.index(next(
            n for n in names if n.endswith(f"{layer}.{c}")))] for c in letters], -1)

    colour = pick("Combined", "RGB") + pick("Env", "RGB")
    cover = pick("Combined", "A")
    depth = pick("Depth", "Z")
    depth[cover[..., 0] < 1e-3] = 1e10
    normal = pick("Normal", "XYZ")
    for light, (tint, levels, tolerance) in quiet.items():
        noisy = pick(light, "RGB")
        colour += pick(tint, "RGB") * (smooth(noisy, normal, depth, levels, tolerance) - noisy)
    if air:
        soft = pick("Mist", "Z")[..., 0] * mist
        light, share = air(soft)
        colour = colour * share + light
    rgba = np.concatenate([colour, cover], -1).clip(0, 65504).astype(np.float16)
    height, width = depth.shape[:2]
    spec = oiio.ImageSpec(width, height, 5, oiio.HALF)
    spec.channelnames = ["R", "G", "B", "A", "Z"]
    spec.channelformats = [oiio.HALF] * 4 + [oiio.FLOAT]
    spec.attribute("compression", "zip")
    to_camera, to_ndc = matrices()
    spec.attribute("worldToCamera", oiio.TypeDesc("matrix"), tuple(to_camera))
    spec.attribute("worldToNDC", oiio.TypeDesc("matrix"), tuple(to_ndc))
    if frames:
        spec.attribute("framesPerSecond", oiio.TypeDesc("rational"), (24, 1))
    # 13 bits of Z's mantissa do for hiding lamps, and compress
    z = depth.astype(np.float32)
    bits = z.view(np.uint32)
    bits[z < 1e9] &= np.uint32(0xFFFFFC00)
    file = oiio.ImageOutput.create(output)
    if not file or not file.open(output, spec) or not file.write_image(
            np.concatenate([rgba.astype(np.float32), z], -1)):
        sys.exit(f"{output}: {oiio.geterror()}")
    file.close()
    print(f"{output}: brightest {rgba[..., :3].max()}, median "
          f"{np.median(rgba[..., 1]):.3g}, coverage {rgba[..., 3].mean():.3f}")
