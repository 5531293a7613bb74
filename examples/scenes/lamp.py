# SPDX-License-Identifier: Apache-2.0
"""A table by a wall in the evening; the lamp hangs in the left border of the frame."""
import os
import random
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from common import *

random.seed(5)

# room: wall with a window at dusk, table
wall = Material("Plaster", rough=0.8)
stain = wall.noise(1.6, 6, 0.6)
wall.feed(Base_Color=wall.ramp(stain, (0.3, (0.36, 0.40, 0.36)), (0.7, (0.52, 0.53, 0.45))))
wall.bump(wall.math("ADD", wall.noise(9, 8, 0.55), wall.math(
    "MULTIPLY", wall.noise(1.2, 3), 1.5)), 0.025)
boxes("Wall", [(-4, 2.2, -1, 0.78, 2.5, 4), (0.78, 2.2, -1, 1.66, 2.5, 1.02),
               (0.78, 2.2, 2.02, 1.66, 2.5, 4), (1.66, 2.2, -1, 4, 2.5, 4),
               (-4, -3, 3.2, 4, 2.5, 3.4), (-3.6, -3, -1, -3.4, 2.5, 4),
               (3.4, -3, -1, 3.6, 2.5, 4), (-4, -3.2, -1, 4, -3, 4)], wall)
paint = Material("Paint", (0.55, 0.53, 0.47), 0.35)
bars = [(0.78, 2.3, 1.02, 0.84, 2.38, 2.02), (1.60, 2.3, 1.02, 1.66, 2.38, 2.02),
        (0.78, 2.3, 1.96, 1.66, 2.38, 2.02), (0.78, 2.3, 1.02, 1.66, 2.38, 1.08),
        (1.2, 2.31, 1.02, 1.235, 2.37, 2.02), (0.78, 2.31, 1.60, 1.66, 2.37, 1.635),
        (0.72, 2.02, 0.97, 1.72, 2.4, 1.02)]
boxes("Window", bars, paint, 0.008)
sky((0.0, (0.34, 0.16, 0.12)), (0.06, (0.25, 0.19, 0.26)), (0.25, (0.07, 0.14, 0.33)),
    (1, (0.02, 0.05, 0.14)))
wood = Material("Wood", rough=0.4)
grain = wood.noise(5, 8, 0.65, (0.7, 14, 14))
wood.feed(Base_Color=wood.ramp(grain, (0.3, (0.075, 0.030, 0.012)), (0.7, (0.23, 0.105, 0.042))),
          Roughness=wood.ramp(grain, (0.3, 0.5), (0.7, 0.3)))
wood.bump(grain, 0.004)
boxes("Table", [(-2, y, 0.71, 2, y + 0.196, 0.75) for y in (0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 1.7)],
      wood, 0.004)

# the lamp: enamelled shade, bulb, cord
at = (-1.045, 1.5, 1.62)
bulb(at, 0.04, (1000, 640, 300))
enamel = Material("Enamel", (0.012, 0.07, 0.045), 0.12)
inside = Material("Inside", (0.75, 0.72, 0.62), 0.35)
rim = (at[0], at[1], at[2] + 0.028)
profile = [(0.035, 0.17), (0.05, 0.15), (0.08, 0.135), (0.15, 0.10), (0.21, 0.035), (0.225, 0.012)]
lathe("Shade", profile + [(0.226, 0.008)], enamel, rim, 96)
lathe("Shade inside", [(max(r - 0.004, 0.02), z - 0.006) for r, z in profile], inside, rim,
      96).visible_diffuse = False  # so near to the bulb it would be all noise
brass = Material("Brass", (0.75, 0.5, 0.2), 0.25, Metallic=1.0)
lathe("Socket", [(0.001, 0.21), (0.022, 0.205), (0.024, 0.045), (0.001, 0.04)], brass, rim)
tubes("Cord", [[(at[0], at[1], at[2] + 0.2), (at[0], at[1], 3.2)]], 0.004, Material("Cord", (0.02,) * 3))

# a picture: hills at sunset
frame = Material("Gilt", (0.55, 0.36, 0.13), 0.35, Metallic=1.0)
x0, x1, z0, z1 = -0.34, 0.34, 1.42, 1.90
boxes("Frame", [(x0, 2.14, z0, x1, 2.2, z0 + 0.045), (x0, 2.14, z1 - 0.045, x1, 2.2, z1),
                (x0, 2.14, z0 + 0.045, x0 + 0.045, 2.2, z1 - 0.045),
                (x1 - 0.045, 2.14, z0 + 0.045, x1, 2.2, z1 - 0.045)], frame, 0.012)
canvas = Material("Canvas", rough=0.6)
where = canvas.add("NewGeometry").outputs["Position"]
z = canvas.add("SeparateXYZ", where).outputs["Z"]
rolling = canvas.math("ADD", z, canvas.math("MULTIPLY", canvas.noise(3.5, 5, 0.5, (1, 1, 2)), 0.22))
level = canvas.math("DIVIDE", canvas.math("SUBTRACT", rolling, z0 + 0.1), z1 - z0)
canvas.feed(Base_Color=canvas.ramp(level, (0.05, (0.03, 0.035, 0.015)), (0.22, (0.10, 0.09, 0.03)), (
    0.36, (0.05, 0.07, 0.06)), (0.47, (0.10, 0.13, 0.15)), (0.5, (0.75, 0.45, 0.2)), (
    0.7, (0.5, 0.45, 0.4)), (1, (0.2, 0.28, 0.38))))
canvas.bump(canvas.noise(60, 2), 0.002)
boxes("Picture", [(x0 + 0.03, 2.165, z0 + 0.03, x1 - 0.03, 2.2, z1 - 0.03)], canvas)

# on the table: books, jug with twigs, pears, bowl of apples
top = 0.75
height = top
for i, (colour, thick, wide) in enumerate((
        ((0.16, 0.02, 0.015), 0.045, 0.34), ((0.02, 0.05, 0.09), 0.03, 0.30),
        ((0.20, 0.13, 0.05), 0.055, 0.27), ((0.015, 0.06, 0.03), 0.025, 0.22))):
    turn = Matrix.Translation((-0.64, 1.42, 0)) @ Matrix.Rotation(random.uniform(-0.3, 0.2), 4, "Z")
    cloth = Material("Cloth", colour, 0.55)
    cloth.bump(cloth.noise(300, 2), 0.001)
    w, d, z = wide / 2, 0.11, height
    boxes("Cover", [(-w, -d, z, w, d, z + 0.004), (-w, -d, z + thick - 0.004, w, d, z + thick),
                    (-w, -d, z, w, -d + 0.005, z + thick)], cloth, 0.0015).matrix_world = turn
    boxes("Pages", [(-w + 0.006, -d + 0.004, z + 0.003, w - 0.006, d - 0.005, z + thick - 0.003)],
          Material("Paper", (0.62, 0.55, 0.42), 0.8)).matrix_world = turn
    height += thick
clay = Material("Clay", (0.30, 0.33, 0.36), 0.22)
speck = clay.noise(40, 6, 0.7)
clay.feed(Base_Color=clay.ramp(speck, (0.42, (0.05, 0.08, 0.11)), (0.62, (0.34, 0.38, 0.40))))
jug = (-0.10, 1.55, top)
lathe("Jug", [(0.001, 0), (0.06, 0), (0.085, 0.04), (0.097, 0.1), (0.088, 0.16), (0.058, 0.215),
              (0.044, 0.25), (0.05, 0.285), (0.056, 0.292), (0.05, 0.285), (0.038, 0.25),
              (0.04, 0.2)], clay, jug, 96)
tubes("Handle", [[(jug[0] + 0.05 + 0.062 * math.sin(a) ** 0.7, jug[1], top + 0.18 + 0.075 * math.cos(a))
                  for a in np.linspace(0.05, 3.0, 24)]], 0.009, clay)
twigs, buds = [], []


def grow(p, direction, length, thick):
    line = [(*p, thick)]
    for i in range(7):
        direction = (direction + Vector(random.gauss(0, 0.13) for _ in range(3)) +
                     Vector((0, 0, 0.03))).normalized()
        p = p + direction * length / 7
        line.append((*p, thick * (1 - 0.08 * i)))
        if length > 0.16 and i > 0:
            side = Vector(random.gauss(0, 1) for _ in range(3)).normalized()
            grow(p, (direction + 0.8 * side).normalized(), length * random.uniform(0.3, 0.5), thick * 0.6)
        if length < 0.3:
            buds.append(p + Vector(random.gauss(0, 0.004) for _ in range(3)))
    twigs.append(line)


for _ in range(6):
    grow(Vector((jug[0] + random.gauss(0, 0.01), jug[1], top + 0.2)),
         Vector((random.gauss(0.08, 0.42), random.gauss(-0.1, 0.2), 1)).normalized(),
         random.uniform(0.42, 0.62), 1)
tubes("Twigs", twigs, 0.0042, Material("Bark", (0.07, 0.04, 0.022), 0.7))
petal = Material("Petal", (0.78, 0.62, 0.60), 0.6)
balls("Buds", buds, 0.007, petal)


def fruit(profile, at, material, lean=0.0, turn=0.0):
    thing = lathe("Fruit", profile, material)
    thing.modifiers.new("Round", "SUBSURF").render_levels = 2
    thing.matrix_world = Matrix.Translation(at) @ Matrix.Rotation(turn, 4, "Z") @ Matrix.Rotation(lean, 4, "Y")
    stalk = tubes("Stalk", [[(0, 0, profile[-1][1] - 0.004), (0.003, 0, profile[-1][1] + 0.012),
                             (0.009, 0, profile[-1][1] + 0.024)]], 0.0018, bark)
    stalk.matrix_world = thing.matrix_world


bark = Material("Stalk", (0.05, 0.03, 0.015), 0.8)
pear = [(0.001, 0.002), (0.018, 0), (0.036, 0.018), (0.042, 0.04), (0.036, 0.064), (0.024, 0.085),
        (0.018, 0.1), (0.012, 0.108), (0.001, 0.107)]
skin = Material("Pear", rough=0.32)
skin.feed(Base_Color=skin.ramp(skin.noise(26, 7, 0.7), (0.35, (0.42, 0.32, 0.05)), (0.6, (0.34, 0.36, 0.06)),
                               (0.75, (0.30, 0.12, 0.03))))
fruit(pear, (0.20, 1.30, top), skin, 0.06)
fruit(pear, (0.31, 1.42, top), skin, -0.1, 1)
fruit([(r, z) for r, z in pear], (0.255, 1.13, top + 0.04), skin, 1.62, 2.5)
apple = [(0.001, 0.008), (0.014, 0.001), (0.03, 0.008), (0.04, 0.032), (0.036, 0.056), (0.02, 0.066),
         (0.008, 0.060), (0.001, 0.052)]
red = Material("Apple", rough=0.22)
red.feed(Base_Color=red.ramp(red.noise(18, 6, 0.7, (1, 1, 0.4)), (0.4, (0.36, 0.02, 0.015)), (0.62, (0.42, 0.16, 0.03))))
bowl = (0.68, 1.42, top)
lathe("Bowl", [(0.001, 0.006), (0.06, 0), (0.062, 0.01), (0.1, 0.03), (0.15, 0.075), (0.165, 0.1), (0.16, 0.102),
               (0.145, 0.078), (0.095, 0.036), (0.001, 0.018)], Material("Copper", (0.72, 0.33, 0.17), 0.24, Metallic=1.0), bowl, 96)
for dx, dy, dz in ((-0.05, -0.03, 0.032), (0.045, -0.045, 0.034), (0.0, 0.05, 0.033), (0.07, 0.04, 0.045),
                   (-0.07, 0.045, 0.04), (0.005, 0.0, 0.085)):
    fruit(apple, (bowl[0] + dx, bowl[1] + dy, top + dz), red, random.uniform(-0.6, 0.6), random.uniform(0, 6))

camera((0, -1.0, 1.23), (0, 2.2, 1.23), 45.6)
render(samples=128, bounces=4, clamp=1)
