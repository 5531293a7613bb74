# SPDX-License-Identifier: Apache-2.0
"""The sun behind the leaves of a beech: the camera sinks until they hide it."""
import os
import random
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from common import *

random.seed(21)
rng = np.random.default_rng(21)
SUN = Vector((0.10, 1.0, 0.40)).normalized()

# leaves: a folded blade of six faces that lets light through
leaf = Material("Leaf", rough=0.35)
tone = leaf.add("ObjectInfo").outputs["Random"]
green = leaf.ramp(leaf.noise(3.0, 3), (0.3, (0.05, 0.10, 0.014)), (0.7, (0.12, 0.15, 0.02)))
leaf.feed(Base_Color=green, Specular=0.4)
through = leaf.add("BsdfTranslucent", leaf.ramp(leaf.noise(3.0, 3), (0.3, (0.22, 0.36, 0.03)), (0.7, (0.50, 0.50, 0.05))))
leaf.put(leaf.out.inputs["Surface"], leaf.add("MixShader", 0.55, leaf.shader, through))


def foliage(name, tips, count, reach, size, material):
    """Leaves about the tips of branches, as one mesh."""
    where = np.repeat(np.array([t[0] for t in tips]), count, 0)
    n = len(where)
    where = where + rng.normal(0, reach, (n, 3)) * (1, 1, 0.7)
    way = rng.normal(0, 1, (n, 3)) + (0, 0, -0.5)
    way /= np.linalg.norm(way, axis=1)[:, None]
    flat = np.cross(way, rng.normal(0, 0.45, (n, 3)) + (0, 0, 1))
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    up = np.cross(flat, way)
    long = size * rng.uniform(0.6, 1.25, n)[:, None]
    outline = [(0, 0, 0), (0.25, 0.22, 0.05), (0.6, 0.27, 0.06), (1, 0, -0.08), (0.6, -0.27, 0.06), (0.25, -0.22, 0.05), (0.5, 0, 0)]
    v = np.stack([where + long * (a * way + b * flat + c * up) for a, b, c in outline], 1)
    i = np.arange(n)[:, None] * 7
    faces = [tuple(q) for f in ((0, 1, 6), (1, 2, 6), (2, 3, 6), (3, 4, 6), (4, 5, 6), (5, 0, 6)) for q in i + f]
    return mesh(name, v.reshape(-1, 3), faces, material)


bark = Material("Bark", rough=0.7)
bark.feed(Base_Color=bark.ramp(bark.noise(6, 6, 0.6, (1, 1, 0.25)), (0.35, (0.05, 0.04, 0.03)), (0.7, (0.16, 0.13, 0.10))))
bark.bump(bark.noise(12, 6, 0.6, (1, 1, 0.2)), 0.03)
lines, tips = [], []
# the wood behind, then the near beech on the left
for x, y, height in ((-9, 17, 15), (-4.5, 27, 17), (7.5, 19, 16), (12, 28, 18), (2.6, 36, 17), (-13, 33, 18),
                     (-1.5, 48, 18), (8, 44, 19), (-8, 47, 19), (17, 42, 18), (-18, 46, 18)):
    new, ends = tree((x, y, 0), height, random, 0.5, 3)
    lines += new
    tips += ends
tubes("Wood", lines, 1.0, bark)
foliage("Crowns", tips, 26, 0.55, 0.24, leaf)
lines, ends = tree((-2.6, 6.4, 0), 9.5, random, 0.52, 4)
tubes("Beech", lines, 1.0, bark)
foliage("Beech leaves", ends, 13, 0.16, 0.11, leaf)
# a bough that reaches in from above
bough, ends = [], []
for k in range(3):
    p, direction = Vector((-2.4 + 0.5 * k, 5.6 - 0.3 * k, 3.6 + 0.35 * k)), Vector((1, -0.12 * k, 0.02))
    line = [(*p, 0.035)]
    for i in range(14):
        direction = (direction + Vector(random.gauss(0, 0.09) for _ in range(3)) + Vector((0, 0, -0.022))).normalized()
        p = p + direction * 0.26
        line.append((*p, 0.035 * (1 - i / 15)))
        for _ in range(2):
            q, way, twig = p.copy(), (direction + 1.1 * Vector(random.gauss(0, 1) for _ in range(3)).normalized()).normalized(), []
            for j in range(5):
                twig.append((*q, 0.007 * (1 - j / 6)))
                way = (way + Vector((0, 0, -0.10))).normalized()
                q = q + way * 0.12
                ends.append((q.copy(), way))
            bough.append(twig)
    bough.append(line)
tubes("Bough", bough, 1.0, bark)
foliage("Bough leaves", ends, 3, 0.05, 0.10, leaf)

# a meadow
ground = Material("Ground", rough=0.9)
ground.feed(Base_Color=ground.ramp(ground.noise(0.5, 5), (0.35, (0.05, 0.07, 0.015)), (0.65, (0.12, 0.10, 0.03))))
n = 60
v = [(60 * (2 * i / n - 1), 90 * j / n - 4, 0.25 * math.sin(i * 0.9) * math.sin(j * 0.7)) for j in range(n + 1) for i in range(n + 1)]
mesh("Ground", v, [(j * (n + 1) + i, j * (n + 1) + i + 1, (j + 1) * (n + 1) + i + 1, (j + 1) * (n + 1) + i)
                   for j in range(n) for i in range(n)], ground, smooth=True)
grass = Material("Grass", rough=0.4)
grass.feed(Base_Color=grass.ramp(grass.noise(0.6, 4), (0.35, (0.06, 0.11, 0.015)), (0.7, (0.15, 0.15, 0.03))))
shine = grass.add("BsdfTranslucent", grass.ramp(grass.noise(0.6, 4), (0.35, (0.20, 0.32, 0.03)), (0.7, (0.45, 0.40, 0.08))))
grass.put(grass.out.inputs["Surface"], grass.add("MixShader", 0.5, grass.shader, shine))
y = 3 + 40 * rng.uniform(0, 1, 60000) ** 1.8
blades("Grass", np.stack([rng.uniform(-0.62, 0.62, 60000) * (y + 2), y, 0 * y - 0.1], -1), 0.34, 0.016, grass)

# the sun as bright as it is against a white sheet in its light
IRRADIANCE = math.pi * 0.95
COLOUR = (1.0, 0.90, 0.74)
radiance = sun(SUN, IRRADIANCE, COLOUR)
sky((0.0, (0.85, 0.80, 0.70)), (0.15, (0.62, 0.70, 0.78)), (0.45, (0.30, 0.44, 0.68)), (1, (0.14, 0.25, 0.50)),
    disc=(SUN, [radiance * c for c in COLOUR]), sampled=True)

EYE = (0.6, -1.2, 1.55)
camera(EYE, (0.6, 10, 4.05), 52, (640, 360))
PATH = {1001: (0, 0, 0), 1002: (0.2, 0, -0.45), 1003: (0.33, 0, -0.6), 1004: (0.45, 0, -0.66)}  # of the eye


def move(_, __=None):
    eye = Vector(EYE) + Vector(PATH.get(scene.frame_current, (0, 0, 0)))
    aim(eye, eye + Vector((0, 11.2, 2.5)))


bpy.app.handlers.frame_change_pre.append(move)


def air(depth):
    haze = Air(depth)
    toward = np.clip(haze.rays @ np.array(SUN), 0, 1)
    clear = np.exp(-0.006 * np.minimum(haze.far, 90))[..., None]
    # the air is brighter toward the sun; the sky has its own
    glow = 0.14 + 0.6 * toward ** 24 + 2.0 * toward ** 300
    haze.light += (1 - clear) * glow[..., None] * np.array((1.0, 0.90, 0.70))
    sky_only = (depth > 99)[..., None]
    return haze.light, np.where(sky_only, 1, clear)


render(samples=128, bounces=4, clamp=4, air=air, frames=[1001, 1002, 1003, 1004])
