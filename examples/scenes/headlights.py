# SPDX-License-Identifier: Apache-2.0
"""A car in the rain on a country road at nightfall, its headlights in the mist."""
import os
import random
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from common import *

random.seed(8)
rng = np.random.default_rng(8)

# road with wet lanes, markings, verges of grass
asphalt = Material("Asphalt", (0.028, 0.028, 0.03), Specular=0.5)
pools = asphalt.noise(0.5, 4, 0.55, (2.2, 0.45, 1))
asphalt.feed(Roughness=asphalt.ramp(pools, (0.42, 0.30), (0.52, 0.16), (0.60, 0.03)))
asphalt.bump(asphalt.add("MixRGB", asphalt.ramp(pools, (0.45, 0.0), (0.6, 1.0)), asphalt.noise(70, 3),
                         asphalt.math("MULTIPLY", asphalt.noise(25, 2), 0.05)), 0.008, 0.8)
mesh("Road", [(-3.3, -5, 0), (3.3, -5, 0), (3.3, 140, 0), (-3.3, 140, 0)], [(0, 1, 2, 3)], asphalt)
paint = Material("Paint", (0.55, 0.55, 0.5), 0.25)
paint.bump(paint.noise(50, 3), 0.003)
boxes("Marks", [(-0.07, y, 0, 0.07, y + 3, 0.006) for y in range(-2, 120, 7)] +
      [(x - 0.06, -5, 0, x + 0.06, 140, 0.006) for x in (-3.05, 3.05)], paint)
earth = Material("Earth", (0.030, 0.032, 0.015), 0.85)
earth.bump(earth.noise(4, 6), 0.06)
for s in -1, 1:
    mesh("Verge", [(s * 3.3, -5, -0.01), (s * 6, -5, 0.25), (s * 60, -5, 1.2), (s * 60, 140, 1.2), (s * 6, 140, 0.25), (s * 3.3, 140, -0.01)],
         [(0, 1, 4, 5), (1, 2, 3, 4)], earth)
grass = Material("Grass", rough=0.45)
grass.feed(Base_Color=grass.ramp(grass.noise(0.8, 4), (0.35, (0.06, 0.09, 0.022)), (0.7, (0.16, 0.14, 0.05))))
for s in -1, 1:
    n = 26000
    y = rng.uniform(-1, 1, n)
    y = 1 + 60 * abs(y) ** 1.7
    x = 3.35 + 6 * rng.uniform(0, 1, n) ** 1.6
    z = np.where(x < 6, (x - 3.3) / 2.7 * 0.26, 0.25 + (x - 6) * 0.0176) - 0.02
    blades("Grass", np.stack([s * x, y, z], -1), 0.30, 0.012, grass)
white = Material("Post", (0.6, 0.6, 0.58), 0.4)
posts = [(s * 3.75, y) for y in (8, 20, 32, 44, 56) for s in (-1, 1)]
boxes("Posts", [(x - 0.05, y - 0.03, 0, x + 0.05, y + 0.03, 0.95) for x, y in posts], white, 0.02)
boxes("Bands", [(x - 0.053, y - 0.033, 0.68, x + 0.053, y + 0.033, 0.88) for x, y in posts], Material("Band", (0.02,) * 3), 0.02)

# bare trees
lines = []
for y in (5, 12, 18, 25, 33, 40, 49, 58, 68, 80):
    for s in -1, 1:
        at = (s * random.uniform(5.6, 8.5), y + random.uniform(-2, 2), 0.15)
        lines += tree(at, random.uniform(8, 13), random, 0.5, 3 if y < 50 else 2)[0]
bark = Material("Bark", (0.06, 0.05, 0.04), 0.6)
bark.bump(bark.noise(9, 5, 0.6, (1, 1, 0.3)), 0.03)
tubes("Trees", lines, 1.0, bark)

# the car: sections from the nose (y = 0) to the tail, half of each, then mirrored
SECTIONS = [  # y, (x, z) from the sill to the middle of the top
    (0.00, (0.55, 0.30), (0.62, 0.38), (0.64, 0.50), (0.60, 0.62), (0.48, 0.68), (0.25, 0.70), (0, 0.70)),
    (0.08, (0.70, 0.22), (0.76, 0.34), (0.78, 0.52), (0.74, 0.72), (0.58, 0.78), (0.30, 0.79), (0, 0.79)),
    (0.35, (0.74, 0.20), (0.81, 0.32), (0.83, 0.54), (0.79, 0.78), (0.62, 0.84), (0.34, 0.85), (0, 0.86)),
    (1.00, (0.76, 0.20), (0.83, 0.32), (0.85, 0.56), (0.81, 0.84), (0.64, 0.91), (0.36, 0.93), (0, 0.94)),
    (1.25, (0.76, 0.20), (0.83, 0.32), (0.86, 0.56), (0.82, 0.88), (0.70, 0.95), (0.40, 0.98), (0, 0.99)),
    (1.32, (0.76, 0.20), (0.83, 0.32), (0.86, 0.56), (0.82, 0.90), (0.72, 0.99), (0.42, 1.03), (0, 1.04)),
    (1.95, (0.76, 0.20), (0.83, 0.32), (0.86, 0.56), (0.82, 0.92), (0.60, 1.38), (0.40, 1.43), (0, 1.44)),
    (2.15, (0.76, 0.20), (0.83, 0.32), (0.86, 0.56), (0.82, 0.92), (0.60, 1.41), (0.40, 1.46), (0, 1.475)),
    (3.10, (0.76, 0.20), (0.83, 0.32), (0.86, 0.56), (0.82, 0.92), (0.60, 1.41), (0.40, 1.46), (0, 1.475)),
    (3.75, (0.76, 0.20), (0.82, 0.32), (0.84, 0.56), (0.80, 0.90), (0.62, 1.02), (0.40, 1.05), (0, 1.06)),
    (4.25, (0.70, 0.24), (0.76, 0.34), (0.78, 0.56), (0.74, 0.80), (0.60, 0.88), (0.36, 0.90), (0, 0.90))]
lacquer = Material("Lacquer", (0.025, 0.035, 0.05), 0.16, Specular=0.6, Clearcoat=1.0)
drops = lacquer.add("TexVoronoi", lacquer.add("TexCoord").outputs["Object"], Scale=60.0)
lacquer.bump(lacquer.ramp(drops.outputs["Distance"], (0.0, 1.0), (0.35, 0.0)), 0.003, 0.6)
pane = Material("Windscreen", (0.006, 0.008, 0.01), 0.05, Specular=0.9)
chrome = Material("Chrome", (0.8, 0.8, 0.8), 0.12, Metallic=1.0)
rubber = Material("Rubber", (0.012,) * 3, 0.6)
glow = Material("Reflector", (1, 1, 1), emit=1)
where = glow.add("TexCoord").outputs["Object"]
flat = glow.add("VectorMath", where, (1, 0, 1), set={"operation": "MULTIPLY"})
r = glow.add("VectorMath", flat, set={"operation": "LENGTH"}).outputs["Value"]
facet = glow.ramp(glow.add("TexWave", where, Scale=22.0), (0.2, 0.55), (0.8, 1.0))
core = glow.math("POWER", glow.math("SUBTRACT", 1.0, glow.math("MULTIPLY", r, 9.5)), 5.0)
glow.feed(Color=(1.0, 0.86, 0.62), Strength=glow.math("MULTIPLY", facet, glow.math("MULTIPLY_ADD", core, 1150.0, 70.0)))
BEAMS = []


def car(at, heading):
    """Places a car whose nose points along -y turned by heading."""
    body = Matrix.Translation(at) @ Matrix.Rotation(heading, 4, "Z")
    v, f, m = [], [], []
    rows = [[(x, z) for x, z in s[1:]] + [(-x, z) for x, z in reversed(s[1:-1])] for s in SECTIONS]
    for s, row in zip(SECTIONS, rows):
        v += [(x, s[0], z) for x, z in row]
    k = len(rows[0])
    for i in range(len(rows) - 1):
        for j in range(k - 1):
            f.append((i * k + j, i * k + j + 1, (i + 1) * k + j + 1, (i + 1) * k + j))
            screen = i == 5 and 3 < j < k - 5 or i == 8 and 3 < j < k - 5
            window = i in (6, 7, 8) and j in (3, k - 5)
            m.append(1 if screen or window else 0)
    f += [tuple(range(k - 1, -1, -1)), tuple((len(rows) - 1) * k + j for j in range(k))]
    shell = mesh("Car", v, f, lacquer, smooth=True)
    shell.data.materials.append(pane.data)
    shell.data.polygons.foreach_set("material_index", m + [0, 0])
    shell.modifiers.new("Round", "SUBSURF").render_levels = 3
    parts = [shell,
             boxes("Bumper", [(-0.80, -0.10, 0.36, 0.80, -0.01, 0.45)], chrome, 0.03),
             boxes("Grille", [(-0.36, -0.015, z, 0.36, 0.03, z + 0.012) for z in np.arange(0.50, 0.66, 0.026)] +
                   [(-0.38, -0.02, 0.655, 0.38, 0.03, 0.675), (-0.38, -0.02, 0.48, 0.38, 0.03, 0.495)], chrome, 0.003),
             boxes("Dark", [(-0.37, -0.004, 0.485, 0.37, 0.04, 0.67)], rubber),
             boxes("Plate", [(-0.26, -0.112, 0.355, 0.26, -0.10, 0.465)], Material("Plate", (0.5, 0.5, 0.46), 0.4), 0.005),
             text("CC0 1953", rubber, Matrix.Translation((0, -0.114, 0.41)) @ Matrix.Rotation(math.pi / 2, 4, "X"), 0.105),
             boxes("Shadow", [(-0.7, 0.2, 0.14, 0.7, 4.1, 0.3)], rubber),
             tubes("Wipers", [[(x, 1.30, 1.02), (x + 0.32, 1.52, 1.13)] for x in (-0.5, 0.05)], 0.008, rubber)]
    for s in -1, 1:
        parts.append(boxes("Mirror", [(s * 0.92 - 0.09, 1.5, 0.98, s * 0.92 + 0.09, 1.58, 1.10)], lacquer, 0.03))
        for y in 0.72, 3.35:
            wheel = lathe("Wheel", [(0.001, 0.05), (0.17, 0.06), (0.2, 0.09), (0.29, 0.1), (0.32, 0.06), (0.32, -0.08), (0.28, -0.1)], rubber)
            wheel.matrix_world = Matrix.Translation((s * 0.75, y, 0.32)) @ Matrix.Rotation(s * math.pi / 2, 4, "Y")
            parts.append(wheel)
        lamp = Matrix.Translation((s * 0.57, -0.045, 0.60)) @ Matrix.Rotation(math.pi / 2, 4, "X")
        for thing in (lathe("Ring", [(0.098, 0), (0.12, 0.012), (0.125, -0.02), (0.12, -0.12)], chrome),):
            thing.matrix_world = lamp
            parts.append(thing)
        a = np.linspace(0, 2 * math.pi, 49)[:-1]
        disc = mesh("Headlight", [(0.1 * math.cos(t), 0, 0.1 * math.sin(t)) for t in a], [tuple(range(48))], glow)
        disc.matrix_world = Matrix.Translation((s * 0.57, -0.05, 0.60))
        parts.append(only_camera(disc))
        data = bpy.data.lights.new("Beam", "SPOT")
        data.energy, data.color = 4 * math.pi * BEAM, (1.0, 0.86, 0.62)
        data.spot_size, data.spot_blend, data.shadow_soft_size = math.radians(100), 1.0, 0.07
        aim_down = Vector((0, -1, -0.045)).to_track_quat("-Z", "Y").to_matrix().to_4x4()
        parts.append(add("Beam", data, matrix=Matrix.Translation((s * 0.57, -0.08, 0.60)) @ aim_down))
    for part in parts:
        part.matrix_world = body @ part.matrix_world
    turn = body.to_3x3()
    for s in -1, 1:
        BEAMS.append((np.array(body @ Vector((s * 0.57, -0.08, 0.60))), np.array((turn @ Vector((0, -1, -0.045))).normalized())))


BEAM = 26.0  # radiant intensity along the axis
car((-1.75, 9.6, 0), math.radians(-7))
car((-1.7, 46, 0), 0)
# the tail lights of one that went by
red = Material("Tail light", (1.0, 0.03, 0.02), emit=60)
boxes("Gone", [(0.9, 34, 0.35, 2.5, 36, 1.4)], rubber, 0.2)
balls("Tail lights", [(1.05, 33.97, 0.8), (2.35, 33.97, 0.8)], 0.07, red)

sky((0.0, (0.040, 0.050, 0.072)), (0.12, (0.024, 0.034, 0.058)), (0.5, (0.011, 0.017, 0.036)), (1, (0.006, 0.010, 0.024)))
camera((0.75, 1.2, 0.95), (-0.72, 12, 1.28), 48)

tops = np.stack([rng.uniform(-9, 9, 9000), rng.uniform(4, 26, 9000), rng.uniform(0.1, 5.5, 9000)], -1)
fall = np.array([0.05, -0.03, -0.26])


def mist(depth):
    air = Air(depth)
    clear = air.haze((0.027, 0.035, 0.052), 0.017, 110)
    tint = np.array((1.0, 0.86, 0.62))
    for at, axis in BEAMS:
        # what the lens lets out: a hot middle and a wide skirt
        air.lamp(at, BEAM * tint * 4, 0.010, lambda d: np.clip((d @ axis - 0.45) / 0.55, 0, 1) ** 6 +
                 0.025 * np.clip(d @ axis, 0, 1), steps=32)
    for x in 1.05, 2.35:
        air.lamp((x, 33.9, 0.8), (0.7, 0.02, 0.015), 0.02)

    def shine(p):
        total = 0.003
        for at, axis in BEAMS:
            d = p - at
            r2 = np.maximum(np.sum(d * d, -1), 0.3)
            total = total + BEAM * np.clip((d @ axis) / np.sqrt(r2) - 0.4, 0, 1) ** 2 / r2
        return total[:, None] * tint * 0.35

    air.streaks(tops, tops + fall, shine, 0.002, steps=160)
    return air.light, clear


render(samples=112, bounces=3, clamp=1.5, air=mist,
       quiet={"DiffInd": ("DiffCol", 4, 6), "GlossInd": ("GlossCol", 2, 2.5)})
