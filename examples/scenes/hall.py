# SPDX-License-Identifier: Apache-2.0
"""The nave of a church: sun through the clerestory, coloured glass in the east."""
import os
import random
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from common import *

random.seed(3)
BAY, BAYS, NAVE, AISLE, WALL = 4.6, 7, 4.2, 7.8, 0.8
SPRING, TOP = 11.5, 15.5  # where the vault starts and ends
END = BAY * BAYS


def pointed(u, half, low, high):
    """Height of a pointed arch at u from its middle: two arcs."""
    rise = high - low
    radius = (half * half + rise * rise) / (2 * half)
    return low + math.sqrt(max(radius ** 2 - (abs(u) + radius - half) ** 2, 0))


stone = Material("Limestone", rough=0.75)
stain = stone.noise(0.5, 7, 0.6)
place = stone.add("SeparateXYZ", stone.add("NewGeometry").outputs["Position"])
flat = stone.add("CombineXYZ", stone.math("ADD", place.outputs["X"], place.outputs["Y"]), place.outputs["Z"])
joints = stone.add("TexBrick", flat, (1, 1, 1), (0.86, 0.85, 0.82), (0.6, 0.58, 0.54), Scale=1.0,
                   Mortar_Size=0.008, Brick_Width=0.75, Row_Height=0.36)
stone.feed(Base_Color=stone.add("MixRGB", 1.0, joints, stone.ramp(
    stain, (0.3, (0.40, 0.33, 0.25)), (0.7, (0.58, 0.51, 0.41))), set={"blend_type": "MULTIPLY"}))
stone.bump(stone.noise(6, 6), 0.01)
plain = Material("Plain stone", (0.52, 0.46, 0.37), 0.7)
plain.bump(plain.noise(8, 5), 0.008)

# floor: polished slabs in two colours
floor = Material("Floor", rough=0.2)
tile = floor.add("TexChecker", floor.add("Mapping", floor.add("NewGeometry").outputs["Position"],
                                         Rotation=(0, 0, math.pi / 4), Location=(0, 0, 0.31)),
                 (0.40, 0.36, 0.30), (0.12, 0.10, 0.09), Scale=1.5)
worn = floor.noise(1.3, 6, 0.6)
floor.feed(Base_Color=floor.add("MixRGB", floor.ramp(worn, (0.3, 0.0), (0.8, 0.5)), tile, (0.25, 0.22, 0.18)),
           Roughness=floor.ramp(worn, (0.3, 0.10), (0.7, 0.34)))
floor.bump(floor.noise(2.0, 3), 0.003)
mesh("Floor", [(-9, -9, 0), (9, -9, 0), (9, END + 1, 0), (-9, END + 1, 0)], [(0, 1, 2, 3)], floor)


def pierced(name, side, x, thick, holes, low, high, steps=14):
    """A wall along y with pointed holes (half width, sill, spring, top) a bay."""
    edges = sorted({u for half, *_ in holes for u in np.linspace(-half, half, steps + 1)} | {-BAY / 2, BAY / 2})
    v, f = [], []
    for bay in range(-2, BAYS):
        middle = (bay + 0.5) * BAY
        for u0, u1 in zip(edges, edges[1:]):
            cuts = [(h, s) for h in holes for s in [h[0]] if abs(u0 + u1) / 2 < s]
            spans, z = [], (low, low)
            for (half, sill, spring, top), _ in sorted(cuts, key=lambda c: c[0][1]):
                spans.append((z, (sill, sill)))
                z = tuple(pointed(u, half, spring, top) for u in (u0, u1))
            spans.append((z, (high, high)))
            for (a0, a1), (b0, b1) in spans:
                if b0 <= a0 and b1 <= a1:
                    continue
                n = len(v)
                v += [(side * (x + d), middle + u, z) for d in (0, thick) for u, z in ((u0, a0), (u1, a1), (u1, b1), (u0, b0))]
                f += [tuple(n + i for i in q) for q in ((0, 1, 2, 3), (7, 6, 5, 4), (0, 1, 5, 4), (3, 2, 6, 7),
                                                        (0, 3, 7, 4), (1, 2, 6, 5))]
    return mesh(name, v, f, stone)


SUN = Vector((0.80, 0.30, 0.60)).normalized()
WARM = (1.0, 0.84, 0.62)
SUNNY = 1, 3, 5  # bays; a tower outside shades the others
ARCH = (1.75, 0.0, 4.2, 6.6)
CLERE = (0.95, 8.3, 10.4, 12.2)
AISLES = (0.8, 2.2, 4.4, 5.9)
leads = []
for side in -1, 1:
    pierced("Arcade", side, NAVE, WALL, [ARCH, CLERE], 0, TOP)
    pierced("Aisle", side, AISLE, 0.45, [AISLES], 0, 7.4)
    boxes("Aisle roof", [(min(side * NAVE, side * 8.6), -9, 7.4, max(side * NAVE, side * 8.6), END, 7.5)], plain)
    for bay in range(-2, BAYS):
        y = (bay + 0.5) * BAY
        for x, (half, sill, spring, top) in ((NAVE + 0.45, CLERE), (AISLE + 0.45, AISLES)):
            # mullion, bars and leads; the sky itself is seen between them
            leads += [(x - 0.05, y - 0.045, sill, x + 0.05, y + 0.045, top), (x - 0.05, y - half, spring - 0.05, x + 0.05, y + half, spring + 0.05)]
            leads += [(x, y - half, z, x + 0.02, y + half, z + 0.018) for z in np.arange(sill + 0.35, spring, 0.35)]
            leads += [(x, y + u - 0.007, sill, x + 0.02, y + u + 0.007, pointed(u, half, spring, top)) for u in (-0.66 * half, -0.33 * half, 0.33 * half, 0.66 * half)]
    boxes("Leads", [(min(side * a, side * d), b, c, max(side * a, side * d), e, f) for a, b, c, d, e, f in leads],
          Material("Lead", (0.03, 0.03, 0.03), 0.5))
    leads = []

boxes("Shade", [(9.5, bay * BAY + 4.9 * SUN.y / SUN.x, 4, 9.6, (bay + 1) * BAY + 4.9 * SUN.y / SUN.x, 30)
                for bay in range(-3, BAYS + 1) if bay not in SUNNY], plain).visible_camera = False

# light of the sky: a glowing strip along each row of windows, as bright as their
# mean, which the camera and the sun ignore; so most rays to it are free
strip = Material("Skylight", (0.8, 0.86, 1.0), emit=0.9)
v = [(side * x, y, z) for side in (-1, 1) for x, z0, z1 in ((NAVE - 0.02, 8.3, 12.0), (AISLE - 0.02, 2.2, 5.6))
     for y, z in ((-6, z0), (END, z0), (END, z1), (-6, z1))]
skylight = mesh("Skylight", v, [(i, i + 1, i + 2, i + 3) for i in range(0, 16, 4)], strip)
skylight.visible_camera = skylight.visible_shadow = False

# piers: a core and eight shafts, base and capital
core, shafts = [], []
for side in -1, 1:
    for bay in range(-1, BAYS):
        x, y = side * (NAVE + WALL / 2), bay * BAY
        lathe("Pier", [(0.78, 0), (0.78, 0.25), (0.70, 0.3), (0.72, 0.4), (0.62, 0.5), (0.46, 0.56), (0.46, 3.75), (0.52, 3.8),
                       (0.50, 3.86), (0.62, 4.1), (0.74, 4.18), (0.74, 4.32)], plain, (x, y, 0), 32)
        for i in range(8):
            a = i * math.pi / 4
            shafts.append([(x + 0.48 * math.cos(a), y + 0.48 * math.sin(a), z) for z in (0.4, 3.9)])
        shafts.append([(side * (NAVE - 0.04), y, z) for z in (4.3, SPRING)])
        for d in -0.22, 0.22:
            shafts.append([(side * (NAVE - 0.0), y + d, z) for z in (4.3, SPRING)])
        core.append((side * NAVE - 0.24, y - 0.4, SPRING - 0.35, side * NAVE + 0.24, y + 0.4, SPRING - 0.1))
        core.append((side * NAVE - 0.18, y - 0.32, SPRING - 0.5, side * NAVE + 0.18, y + 0.32, SPRING - 0.35))
tubes("Shafts", shafts, 0.11, plain)
boxes("Capitals", core, plain, 0.05)
boxes("String course", [(min(s * 4.05, s * 4.4), -9, 7.45, max(s * 4.05, s * 4.4), END, 7.62) for s in (-1, 1)], plain, 0.04)
arches = []
for side in -1, 1:
    for bay in range(-2, BAYS):
        y = (bay + 0.5) * BAY
        for half, sill, spring, top, out in ((*ARCH, 0.06), (*CLERE, 0.05)):
            arches.append([(side * (NAVE - 0.02), y + u, pointed(u, half + out, spring, top + out)) for u in np.linspace(-half - out, half + out, 33)])
tubes("Mouldings", arches, 0.09, plain)

# vault: two pointed barrels that cross, and their ribs
n = 20
v, f, ribs = [], [], []
for bay in range(-2, BAYS):
    middle = (bay + 0.5) * BAY
    start = len(v)
    for i in range(n + 1):
        for j in range(n + 1):
            x, u = NAVE * (2 * i / n - 1), BAY * (j / n - 0.5)
            v.append((x, middle + u, max(pointed(x, NAVE, SPRING, TOP), pointed(u, BAY / 2, SPRING, TOP))))
    f += [tuple(start + q for q in (i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1))
          for i in range(n) for j in range(n)]
    t = np.linspace(-1, 1, 49)
    ribs += [[(NAVE * a, middle - BAY / 2, pointed(NAVE * a, NAVE, SPRING, TOP) - 0.05) for a in t]]
    ribs += [[(NAVE * a, middle + s * a * BAY / 2, pointed(NAVE * a, NAVE, SPRING, TOP) - 0.03) for a in t] for s in (-1, 1)]
mesh("Vault", v, f, plain, smooth=False)
tubes("Ribs", ribs, 0.12, plain)

# east wall: three lancets and a rose, of coloured glass
glass = Material("Stained glass", (1, 1, 1), emit=1.0).unsampled()
where = glass.add("NewGeometry").outputs["Position"]
cells = glass.add("TexVoronoi", glass.add("Mapping", where, Scale=(1, 0, 0.8)), Scale=5.0)
edge = glass.add("TexVoronoi", glass.add("Mapping", where, Scale=(1, 0, 0.8)), Scale=5.0, set={"feature": "DISTANCE_TO_EDGE"})
pick = glass.add("SeparateXYZ", cells.outputs["Color"])
hue = glass.ramp(pick.outputs["X"], (0.0, (0.02, 0.06, 0.55)), (0.34, (0.03, 0.22, 0.75)), (0.36, (0.75, 0.03, 0.02)), (0.55, (0.6, 0.02, 0.05)),
                 (0.57, (1.0, 0.55, 0.06)), (0.72, (0.95, 0.75, 0.25)), (0.74, (0.04, 0.40, 0.12)), (0.85, (0.25, 0.55, 0.9)))
hue.color_ramp.interpolation = "CONSTANT"
lead = glass.ramp(edge.outputs["Distance"], (0.02, 0.0), (0.03, 1.0))
glass.feed(Color=hue, Strength=glass.math("MULTIPLY", glass.math("MULTIPLY_ADD", pick.outputs["Y"], 3.5, 3.0), lead))
EAST = [(0.0, 0.85, 3.4, 8.6, 10.6), (-2.3, 0.7, 3.4, 7.2, 9.0), (2.3, 0.7, 3.4, 7.2, 9.0)]
y = END
for x, half, sill, spring, top in EAST:
    u = np.linspace(-half, half, 25)
    outline = [(x - half, y - 0.12, sill)] + [(x + a, y - 0.12, pointed(a, half, spring, top)) for a in u] + [(x + half, y - 0.12, sill)]
    mesh("Lancet", outline, [tuple(range(len(outline)))], glass).visible_diffuse = False
    tubes("Lancet frame", [[(p[0], y - 0.15, p[2]) for p in outline + outline[:1]]], 0.10, plain)
    tubes("Bars", [[(x - half, y - 0.16, z), (x + half, y - 0.16, z)] for z in np.arange(sill + 1, spring + 0.5, 1.0)] +
          [[(x, y - 0.16, sill), (x, y - 0.16, top)]], 0.03, Material("Iron", (0.02, 0.02, 0.02)))
turn = np.linspace(0, 2 * math.pi, 65)
mesh("Rose", [(1.5 * math.cos(a), y - 0.12, 12.6 + 1.5 * math.sin(a)) for a in turn[:-1]], [tuple(range(64))], glass).visible_diffuse = False
# what the coloured glass gives to the walls, in one colour: many are much noise
mixed = mesh("Mixed light", [(x, y - 0.2, z) for x, z in ((-2.6, 3.6), (2.6, 3.6), (2.6, 8.6), (-2.6, 8.6))], [(0, 1, 2, 3)],
             Material("Mixed light", (0.9, 0.8, 1.0), emit=0.9))
mixed.visible_camera = mixed.visible_glossy = mixed.visible_shadow = False
tubes("Tracery", [[(r * math.cos(a), y - 0.16, 12.6 + r * math.sin(a)) for a in turn] for r in (1.52, 0.55)] +
      [[(r * math.cos(a), y - 0.16, 12.6 + r * math.sin(a)) for r in (0.55, 1.5)] for a in np.arange(12) * math.pi / 6], 0.055, plain)
boxes("East wall", [(-9, y, 0, 9, y + 1, 17), (-9, -9.4, 0, 9, -9.2, 17)], stone)

# steps, altar, candles, pews
boxes("Steps", [(-4, END - 6 + 0.5 * i, 0, 4, END, 0.16 * (i + 1)) for i in range(4)], plain, 0.02)
boxes("Altar", [(-1.5, END - 2.6, 0.6, 1.5, END - 1.6, 1.7)], Material("Marble", (0.6, 0.58, 0.54), 0.2), 0.03)
wax = Material("Wax", (0.7, 0.65, 0.5), 0.5)
for x in (-1.2, -0.8, 0.8, 1.2):
    lathe("Candle", [(0.09, 0), (0.03, 0.05), (0.03, 0.2), (0.06, 0.22), (0.03, 0.24), (0.03, 0.7), (0.001, 0.72)], wax, (x, END - 2.1, 1.7), 16)
    flame = balls("Flame", [(x, END - 2.1, 2.5)], 0.035, Material("Flame", (1.0, 0.55, 0.16), emit=400))
    only_camera(flame)
oak = Material("Oak", rough=0.4)
oak.feed(Base_Color=oak.ramp(oak.noise(4, 6, 0.6, (1, 12, 12)), (0.3, (0.09, 0.042, 0.018)), (0.7, (0.24, 0.12, 0.05))))
pews = []
for i in range(13):
    y = 6.4 + 1.3 * i
    for s in -1, 1:
        a, b = sorted((s * 1.2, s * 3.4))
        pews += [(a, y, 0.42, b, y + 0.42, 0.46), (a, y + 0.42, 0.3, b, y + 0.46, 0.98), (a, y + 0.36, 0.98, b, y + 0.52, 1.02)]
        pews += [(e - 0.035, y - 0.06, 0, e + 0.035, y + 0.52, 1.06) for e in (a, b)]
boxes("Pews", pews, oak, 0.012)

# sun from the right, ahead; outside a bright sky
sun(SUN, 100, WARM)
sky((0.0, (14, 16, 18)), (0.4, (8, 12, 18)), (1, (5, 8, 16)), lights=False)
camera((0.9, -2.0, 2.1), (-0.9, 20, 5.6), 64)


def lit(p):
    """Whether the sun reaches a point through the clerestory of the right."""
    half, sill, spring, top = CLERE
    t = (NAVE + WALL / 2 - p[..., 0]) / SUN.x
    u = np.mod(p[..., 1] + t * SUN.y, BAY) - BAY / 2
    z = p[..., 2] + t * SUN.z
    radius = (half * half + (top - spring) ** 2) / (2 * half)
    roof = spring + np.sqrt(np.maximum(radius ** 2 - (abs(u) + radius - half) ** 2, 0))
    inside = np.minimum(np.minimum((half - abs(u)) / 0.1, (z - sill) / 0.1), (roof - z) / 0.1)
    bay = np.floor((p[..., 1] + t * SUN.y) / BAY)
    return np.clip(inside, 0, 1) * (abs(p[..., 0]) < NAVE) * np.isin(bay, SUNNY)


def air(depth):
    dust = Air(depth)
    clear = dust.haze((0.10, 0.12, 0.15), 0.004)
    # the dust scatters forward: its share toward the camera is about 0.06
    dust.shafts(lit, [100 * 0.06 * c for c in WARM], 0.013)
    return dust.light, clear


render(samples=112, bounces=5, clamp=2, air=air,
       quiet={"DiffInd": ("DiffCol", 5, 8), "DiffDir": ("DiffCol", 4, 4), "GlossInd": ("GlossCol", 3, 3), "GlossDir": ("GlossCol", 3, 3)})
