# SPDX-License-Identifier: Apache-2.0
"""A wet street at night: lamps, shops, strings of bulbs and a neon sign."""
import os
import random
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from common import *

random.seed(11)

# ground: asphalt with puddles, pavements of wet slabs
asphalt = Material("Asphalt", (0.03, 0.031, 0.034), Specular=0.5)
puddle = asphalt.ramp(asphalt.noise(0.42, 3, 0.5), (0.45, 0.0), (0.54, 1.0))
grit = asphalt.noise(60, 3, 0.6)
asphalt.feed(Roughness=asphalt.ramp(asphalt.math("MULTIPLY_ADD", asphalt.noise(2.5, 5, 0.6), 0.5,
                                                 asphalt.math("MULTIPLY", puddle, -0.6)),
                                    (0.0, 0.03), (0.1, 0.16), (0.4, 0.42)))
ripple = asphalt.math("MULTIPLY", asphalt.noise(14, 2), 0.03)
asphalt.bump(asphalt.add("MixRGB", puddle, grit, ripple), 0.008, 0.7)
mesh("Road", [(-40, -6, 0), (40, -6, 0), (40, 80, 0), (-40, 80, 0)], [(0, 1, 2, 3)], asphalt)
slab = Material("Slab", (0.075, 0.072, 0.068))
slab.feed(Roughness=slab.ramp(slab.noise(1.1, 4), (0.35, 0.10), (0.65, 0.5)))
slab.bump(slab.noise(25, 4), 0.006)
stones = []
for side in -1, 1:
    for i in range(60):
        y = -4 + i * 0.9
        stones.append((side * 3.0, y, -0.1, side * 3.16, y + 0.885, 0.145))
        for x in 3.17, 3.79, 4.41:
            stones.append((side * x, y, -0.1, side * (x + 0.605), y + 0.888, 0.14 + random.uniform(0, 0.004)))
boxes("Pavement", [(min(a, d), b, c, max(a, d), e, f) for a, b, c, d, e, f in stones], slab, 0.012)

# facades: a wall with deep windows, each a box in the wall's own (along, out, up)
FRONT = 5.0
stone = Material("Stone", (0.20, 0.18, 0.15), 0.55)
stone.bump(stone.noise(8, 5), 0.01)
trim = Material("Trim", (0.03, 0.032, 0.035), 0.35)
dark = Material("Dark pane", (0.008, 0.01, 0.013), 0.04, Specular=0.8)


def plaster(colour, brick):
    m = Material("Brick" if brick else "Plaster", rough=0.6)
    dirt = m.noise(0.7, 6, 0.6, (1, 1, 0.35))
    if brick:
        where = m.add("SeparateXYZ", m.add("NewGeometry").outputs["Position"])
        flat = m.add("CombineXYZ", m.math("ADD", where.outputs["X"], where.outputs["Y"]), where.outputs["Z"])
        wall = m.add("TexBrick", flat, colour, [c * 0.55 for c in colour], (0.10, 0.095, 0.085),
                     Scale=1.0, Mortar_Size=0.012, Brick_Width=0.25, Row_Height=0.085)
        m.bump(wall.outputs["Fac"], -0.012)
        tone = wall.outputs["Color"]
    else:
        m.bump(m.noise(14, 5), 0.006)
        tone = m.add("RGB").outputs[0]
        tone.default_value = (*colour, 1)
    m.feed(Base_Color=m.add("MixRGB", m.ramp(dirt, (0.35, 0.55), (0.6, 0.0)), tone,
                            [c * 0.35 for c in colour]))
    return m


def room(colour, strength, goods=False):
    """A lit room behind a pane: curtains, or shelves of goods."""
    m = Material("Room", colour, emit=strength)
    where = m.add("NewGeometry").outputs["Position"]
    if goods:
        at = m.add("SeparateXYZ", where)
        flat = m.add("CombineXYZ", at.outputs["Y"], at.outputs["Z"])
        things = m.add("TexBrick", flat, colour, [c * 0.12 for c in colour], [c * 0.02 for c in colour],
                       Scale=1.0, Mortar_Size=0.022, Brick_Width=0.13, Row_Height=0.42, Bias=-0.15)
        stock = m.ramp(m.add("TexNoise", m.add("Mapping", where, Scale=(9, 9, 2)), Scale=1.0),
                       (0.35, (1, 0.5, 0.3)), (0.5, (0.9, 0.9, 0.8)), (0.62, (0.4, 0.8, 0.7)))
        shelf = m.add("MixRGB", 1.0, things, stock, set={"blend_type": "MULTIPLY"})
        # goods below, the bare bright room above
        height = m.ramp(m.math("MULTIPLY", at.outputs["Z"], 0.3), (0.56, 1.0), (0.60, 0.0))
        m.put(m.shader.inputs["Color"], m.add("MixRGB", height, colour, shelf))
    folds = m.add("TexWave", m.add("Mapping", where, Scale=(3, 3, 0.06)), Scale=1.2, Distortion=2.5)
    m.put(m.shader.inputs["Strength"], m.math(
        "MULTIPLY", m.ramp(folds.outputs["Fac"], (0.0, 0.45), (0.8, 1.0)),
        m.math("MULTIPLY", m.ramp(m.noise(0.9, 2), (0.35, 0.35), (0.65, 1.0)), strength)))
    return m.unsampled()


rooms = [room((1.0, 0.55, 0.22), 1.5), room((1.0, 0.68, 0.36), 2.2), room((1.0, 0.42, 0.13), 0.8),
         room((0.65, 0.8, 1.0), 0.7)]
shops = [room((1.0, 0.64, 0.30), 2.6, True), room((1.0, 0.52, 0.2), 1.8, True), room((0.8, 0.92, 1.0), 1.6, True)]
awnings = [Material("Awning", c, 0.7) for c in ((0.22, 0.02, 0.02), (0.02, 0.08, 0.05), (0.03, 0.05, 0.12))]


def house(side, y, width, floors, colour, brick, lit, axes=3, ground=3.6, storey=3.1):
    wall, rims, panes, frames = [], [], {}, []
    height = ground + floors * storey
    pitch = width / axes
    rows = [(ground + i * storey + 0.75, ground + i * storey + 2.45) for i in range(floors)]
    for a in range(axes):
        u = a * pitch
        w0, w1 = u + pitch / 2 - 0.5, u + pitch / 2 + 0.5
        wall += [(u, -0.3, ground, w0, 0, height), (w1, -0.3, ground, u + pitch, 0, height)]
        level = ground
        for z0, z1 in rows:
            wall.append((w0, -0.3, level, w1, 0, z0))
            level = z1
            rims += [(w0 - 0.12, -0.02, z0 - 0.12, w1 + 0.12, 0.14, z0), (w0 - 0.1, 0, z1, w1 + 0.1, 0.07, z1 + 0.16)]
            frames += [(w0, -0.2, z0, w0 + 0.06, -0.12, z1), (w1 - 0.06, -0.2, z0, w1, -0.12, z1),
                       (w0, -0.2, z1 - 0.06, w1, -0.12, z1), (w0, -0.2, z0, w1, -0.12, z0 + 0.06),
                       (w0 + 0.47, -0.2, z0, w0 + 0.53, -0.12, z1), (w0, -0.2, z0 + 1.15, w1, -0.12, z0 + 1.2)]
            glow = random.choice(rooms) if random.random() < lit else dark
            panes.setdefault(glow, []).append((w0, -0.24, z0, w1, -0.19, z1))
        wall.append((w0, -0.3, level, w1, 0, height))
        # ground floor: shop fronts and a door
        door = a == axes // 2
        g0, g1 = (u + pitch / 2 - 0.55, u + pitch / 2 + 0.55) if door else (u + 0.3, u + pitch - 0.3)
        low, high = (0.14, 2.6) if door else (0.75, 2.75)
        wall += [(u, -0.3, 0, g0, 0, ground), (g1, -0.3, 0, u + pitch, 0, ground), (g0, -0.3, high, g1, 0, ground),
                 (g0, -0.3, 0, g1, 0, low)]
        glow = random.choice(shops) if random.random() < lit + 0.2 and not door else dark
        if glow is not dark and random.random() < 0.6:
            x0, x1 = side * (FRONT - 0.02), side * (FRONT - 1.15)
            v = [(x, y + u + w, z) for w in (0.2, pitch - 0.2) for x, z in ((x0, 3.1), (x1, 2.62), (x1, 2.42))]
            mesh("Awning", v, [(0, 1, 4, 3), (1, 2, 5, 4), (0, 2, 1), (3, 4, 5)], random.choice(awnings))
        panes.setdefault(glow, []).append((g0, -0.24, low, g1, -0.18, high))
        frames += [(g0, -0.2, low, g0 + 0.08, -0.1, high), (g1 - 0.08, -0.2, low, g1, -0.1, high),
                   (g0 + (g1 - g0) / 2 - 0.03, -0.2, low, g0 + (g1 - g0) / 2 + 0.03, -0.1, high),
                   (g0, -0.2, high - 0.5, g1, -0.12, high - 0.44), (g0, -0.2, low, g1, -0.1, low + 0.1)]
        if door:
            frames.append((g0, -0.2, low, g1, -0.15, high - 0.5))
    rims += [(0, 0, ground - 0.45, width, 0.10, ground - 0.1), (0, 0, ground - 0.1, width, 0.22, ground),
             (0, 0, height - 0.3, width, 0.25, height), (0, 0, height, width, 0.42, height + 0.14),
             (0, 0, 0, width, 0.06, 0.55)]
    wall.append((0, -6, height, width, 0, height + 0.5))

    def place(list_of_boxes):
        for u0, o0, z0, u1, o1, z1 in list_of_boxes:
            xs = sorted((side * (FRONT - o0), side * (FRONT - o1)))
            yield (xs[0], y + u0, z0, xs[1], y + u1, z1)

    boxes("Wall", place(wall), plaster(colour, brick))
    boxes("Rims", place(rims), stone, 0.015)
    boxes("Frames", place(frames), trim)
    for glow, list_of_boxes in panes.items():
        boxes("Panes", place(list_of_boxes), glow)


red, ochre, grey, cream, blue = ((0.25, 0.09, 0.055), (0.34, 0.22, 0.09), (0.19, 0.20, 0.21), (0.42, 0.36, 0.26),
                                 (0.10, 0.15, 0.19))
for side, row in ((-1, [(cream, 0, 3, 7.5, 0.5), (red, 1, 4, 6.5, 0.45), (ochre, 0, 3, 8, 0.5), (grey, 0, 4, 6.5, 0.4),
                        (red, 1, 3, 7.5, 0.5), (cream, 0, 4, 8, 0.4)]),
                  (1, [(blue, 0, 3, 6.5, 0.45), (red, 1, 4, 8, 0.4), (cream, 0, 4, 6.5, 0.5), (red, 1, 3, 7.5, 0.45),
                       (grey, 0, 4, 8, 0.4), (ochre, 0, 3, 8, 0.5)])):
    y = -1.0
    for colour, brick, floors, width, lit in row:
        house(side, y, width, floors, colour, brick, lit)
        y += width
# the street ends at a church
slate = Material("Slate", (0.05, 0.055, 0.065), 0.6)
boxes("Church", [(-10, 62, 0, 12, 64, 11)], slate)
boxes("Tower", [(-1.7, 60, 0, 1.7, 63, 19)], slate)
glass = room((1.0, 0.5, 0.2), 2.0)
boxes("Church windows", [(x - 0.55, 61.95, 3, x + 0.55, 62, 8.5) for x in (-8, -5.6, -3.2, 3.2, 5.6, 8)] +
      [(-0.9, 59.95, 0, 0.9, 60, 3.4), (-0.35, 59.95, 6, 0.35, 60, 11)], glass)
mesh("Spire", [(-2, 59.8, 19), (2, 59.8, 19), (2, 63.2, 19), (-2, 63.2, 19), (0, 61.5, 30)],
     [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)], slate)
lathe("Clock", [(0.001, 0), (0.85, 0), (0.9, -0.1)], Material("Dial", (1.0, 0.8, 0.5), emit=1.6).unsampled()).matrix_world = \
    Matrix.Translation((0, 59.95, 16.5)) @ Matrix.Rotation(math.pi / 2, 4, "X")

# street lamps on the left and the right
iron = Material("Iron", (0.012, 0.014, 0.014), 0.3, Specular=0.6)
for x, y in ((-3.5, 9.5), (3.5, 17.0), (-3.5, 23.0), (3.5, 33.0)):
    lathe("Post", [(0.16, 0.1), (0.15, 0.5), (0.09, 0.6), (0.07, 1.0), (0.085, 1.05), (0.05, 1.15), (0.042, 3.6), (0.08, 3.65),
                   (0.05, 3.72), (0.14, 3.85), (0.14, 3.88)], iron, (x, y, 0), 24)
    lathe("Roof", [(0.27, 4.42), (0.28, 4.45), (0.12, 4.62), (0.03, 4.66), (0.04, 4.72), (0.001, 4.78)], iron, (x, y, 0), 8)
    tubes("Lantern", [[(x + 0.14 * math.cos(a), y + 0.14 * math.sin(a), 3.87),
                       (x + 0.25 * math.cos(a), y + 0.25 * math.sin(a), 4.43)]
                      for a in np.arange(8) * math.pi / 4], 0.009, iron)
    bulb((x, y, 4.16), 0.085, (430, 250, 100))

# strings of bulbs over the street
warm = Material("Small bulb", (1.0, 0.62, 0.26), emit=90).unsampled()
for y0, y1, z in ((9.5, 11.5, 6.4), (17, 15.5, 6.6), (24, 26, 6.6)):
    line = [(x, y0 + (y1 - y0) * (x / 10 + 0.5), z - 1.1 * (1 - (x / 5) ** 2)) for x in np.linspace(-5, 5, 49)]
    tubes("Wire", [line], 0.008, iron)
    places = [(p[0], p[1], p[2] - 0.09) for p in line[2::4]]
    balls("Bulbs", places, 0.036, warm).visible_diffuse = False
    # one lamp in the middle lights the walls for all of them
    bulb(places[6], 0.15, (55, 34, 14), show=False)

# neon
ruby = Material("Neon red", (1.0, 0.055, 0.04), emit=55)
ice = Material("Neon blue", (0.10, 0.55, 1.0), emit=45)
panel = Material("Panel", (0.012, 0.011, 0.014), 0.25)


def sign(words, at, glow, size, width, height, vertical):
    x, y, z = at
    boxes("Sign", [(x - width / 2, y, z - height / 2, x + width / 2, y + 0.22, z + height / 2)], panel, 0.05)
    turn = Matrix.Translation((x, y - 0.05, z - (0.16 if vertical else 0))) @ Matrix.Rotation(math.pi / 2, 4, "X")
    text("\n".join(words) if vertical else words, glow, turn, size, tube=0.016, space=0.95)
    edge = [(sx * (width / 2 - 0.07), sz * (height / 2 - 0.07)) for sx, sz in ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))]
    return [(x + u, y - 0.05, z + v) for u, v in edge]


tubes("Border", [sign("HOTEL", (4.2, 11.6, 5.0), ruby, 0.95, 1.05, 4.3, True)], 0.014, ice)
boxes("Arms", [(4.6, 11.66, z, 5, 11.74, z + 0.06) for z in (3.4, 6.5)], iron)
tubes("Border", [sign("BAR", (-4.2, 14.0, 3.7), ice, 0.72, 1.45, 0.9, False)], 0.014,
      Material("Neon rose", (1.0, 0.12, 0.35), emit=40))
boxes("Arms", [(-5, 14.06, 3.65, -4.8, 14.14, 3.71)], iron)

sky((0.0, (0.020, 0.020, 0.032)), (0.25, (0.010, 0.014, 0.032)), (1.0, (0.004, 0.006, 0.018)))
camera((-0.55, -2.2, 1.25), (0.15, 12, 2.85), 62)


def mist(depth):
    air = Air(depth)
    clear = air.haze((0.012, 0.015, 0.026), 0.009, 90)
    for at, radius, radiance in LAMPS:
        air.lamp(at, [math.pi * radius ** 2 * c for c in radiance], 0.01)
    return air.light, clear


render(samples=160, bounces=3, clamp=1.5, air=mist,
       quiet={**QUIET, "DiffDir": ("DiffCol", 4, 4), "GlossDir": ("GlossCol", 2, 2)})
