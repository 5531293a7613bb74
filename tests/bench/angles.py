# SPDX-License-Identifier: Apache-2.0
"""Glare by true angles against its definition, and its time against a plane's.

The definition is here once more, in double, by formulas of its own: light per steradian
between two directions of view, its mean over both pixels, which shine and are lit evenly,
times the steradians of the source's.
Pixels 4 and more away from a lone lamp count, and all of them for its bound. Of frames
of the data ($GLAREPP_DATA, or ../shared/data beside the repository) the pixels with most
light and as many others by chance do.

Times are those of the glare stage, runs in turn: the median of each run's frames but the
first, over that of the other way, and of these the median. Frames are of $FRAMES, a
folder that is filled by frames.py when it is empty, else made for the time being.
"""
import filecmp
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np

from shares import DATA, ROOT

W, H = 480, 270
LONE = ("-t", "0", "--threshold-mode", "whole")

# -- models: the light per steradian between directions p and q ----------------------


def by_angle(curve, whole=1.0):
    """That of a curve of degrees, which stays the same from 100 on."""
    def light(p, q):
        chord = np.sqrt(sum((a - b) ** 2 for a, b in zip(p, q)))
        return curve(np.minimum(np.degrees(2 * np.arcsin(np.minimum(chord / 2, 1))), 100)) / whole
    return light


def sphere(curve):
    """The light of a curve over the sphere."""
    edge = np.concatenate([[0], np.geomspace(1e-7, 180.0, 400001)])
    t = 0.5 * (edge[1:] + edge[:-1])
    return np.sum(curve(np.minimum(t, 100.0)) * 2 * np.pi * np.sin(np.radians(t)) *
                  np.radians(np.diff(edge)))


def eye(t):
    return 0.384 * 2.61e6 * np.exp(-(t / 0.02) ** 2) + \
        0.478 * 20.91 / (t + 0.02) ** 3 + 0.138 * 72.37 / (t + 0.02) ** 2


def cie(t, left=1.0):
    """Of age 70 and pigment 0.5; absolute. So much is left of the narrow peak's light, and
    of its width as much more, so that all adds up to 1."""
    return 0.92 * (9.2e6 * left ** 3 / (1 + (t * left / 0.0046) ** 2) ** 1.5 +
                   1.5e5 / (1 + (t / 0.045) ** 2) ** 1.5) + \
        2.6 * (400 / (1 + (t / 0.1) ** 2) + 3e-8 * t * t +
               0.5 * (1300 / (1 + (t / 0.1) ** 2) ** 1.5 +
                      0.8 / (1 + (t / 0.1) ** 2) ** 0.5)) + 1.25e-3


OVER = (sphere(cie) - 1) / (0.92 * 9.2e6 * 2 * math.pi * math.radians(0.0046) ** 2)
MODELS = {"eye": by_angle(eye, sphere(eye)), "cie:age=70": by_angle(lambda t: cie(t, 1 - OVER))}



TURN = math.radians(20)  # an edge along rows would be drawn less well


def hexagon(p, q, mm, nm=550.0):
    """Fraunhofer's of a hexagon, turned counter-clockwise, by direction cosines; of radiance,
    so that a source counts by its solid angle times cosine."""
    u, v = ((a - b) * 1e6 / nm for a, b in zip(p[:2], q[:2]))
    turn = np.arange(7) * math.pi / 3 - TURN
    x, y = mm / 2 * np.cos(turn), mm / 2 * np.sin(turn)
    field = sum((u * (y[i + 1] - y[i]) - v * (x[i + 1] - x[i])) *
                np.sinc(u * (x[i + 1] - x[i]) + v * (y[i + 1] - y[i])) *
                np.exp(-1j * math.pi * (u * (x[i] + x[i + 1]) + v * (y[i] + y[i + 1])))
                for i in range(6)) / (2 * math.pi * (u * u + v * v))
    return abs(field) ** 2 / (3 * math.sqrt(3) / 8 * mm * mm) * (1e6 / nm) ** 2 * q[2]


def spread(u, v, pixel, mm, nm=550.0, n=1024):
    """The same as a pixel in the middle sees it, D of src/glare/sky/cosines.h: its transform
    is what the hexagon has in common with itself, shifted."""
    f = np.arange(-n, n) / n / pixel
    shift = np.meshgrid(f[n:] * nm / 1e6, f * nm / 1e6, indexing="ij")
    strip = np.sort([np.maximum(mm * math.sqrt(3) / 4 - abs(np.cos(a) * shift[0] +
                                                            np.sin(a) * shift[1]) / 2, 0)
                     for a in np.arange(1, 7, 2) * math.pi / 6 - TURN], 0)
    area = (8 * strip[0] * strip[1] - 2 * np.maximum(strip[0] + strip[1] - strip[2], 0) ** 2) / \
        (9 / 8 * mm * mm)
    area -= min(area[n * 9 // 10, n], area[0, n + n * 9 // 10])
    mean = np.sinc(f * pixel) ** 2 / n / pixel
    area *= np.outer(mean[n:] * np.where(f[n:] > 0, 2, 1), mean)
    a, b = 2 * np.pi * np.outer(u, f[n:]), 2 * np.pi * np.outer(v, f)
    return (np.cos(a) @ area * np.cos(b) - np.sin(a) @ area * np.sin(b)).sum(1)


# -- places: their direction of view, and steradians a square pixel there -----------------


def perspective(k, w, h):
    """Of a camera whose pixels are k wide at a distance of 1."""
    def view(x, y):
        u, v = (x + 0.5 - w / 2) * k, (y + 0.5 - h / 2) * k
        n = np.sqrt(1 + u * u + v * v)
        return (u / n, v / n, 1 / n), k * k / n ** 3
    return view


def latlong(h):
    def view(x, y):
        u, v = (x + 0.5) * math.pi / h - math.pi, (y + 0.5) * math.pi / h - math.pi / 2
        c = np.cos(v)
        return (c * np.sin(u), np.sin(v), c * np.cos(u)), (math.pi / h) ** 2 * c
    return view


def pixel_width(fov, h):
    return 2 * math.tan(math.radians(fov / 2)) / h


# -- means over two pixels: places in both, and their weights ----------------------------


def square(at, source, weight):
    """Along both axes, of places and weights along one."""
    x, y = (g.reshape(-1, 1) for g in np.meshgrid(*[np.arange(len(weight))] * 2))
    return at[x], at[y], source[x], source[y], np.outer(weight, weight).ravel()


def gauss(n):
    """Of n points along each axis of each."""
    node, weight = np.polynomial.legendre.leggauss(n)
    at, source = (g.ravel() for g in np.meshgrid(node / 2, node / 2))
    return square(at, source, np.outer(weight, weight).ravel() / 4)


def folded(n, *edges):
    """By steps between places, n points between edges from 0 to 1, the rarer the longer, and
    two of what both move together."""
    node, weight = np.polynomial.legendre.leggauss(n)
    part = np.diff(edges)[:, None] / 2
    step, weight = (np.array(edges)[:-1, None] + part * (1 + node)).ravel(), (part * weight).ravel()
    rest = 1 - step
    step = np.tile(np.concatenate([-step, step]), 2)
    both = np.repeat([-0.5, 0.5], len(step) // 2) * np.tile(rest, 4) / math.sqrt(3)
    return square(both + step / 2, both - step / 2, np.tile(weight * rest, 4) / 2)


# edges lie where light peaks in the pixel itself, and in those beside it
PEAK = folded(5, 0, 0.002, 0.006, 0.015, 0.04, 0.1, 0.25, 0.5,
              0.75, 0.9, 0.96, 0.985, 0.994, 0.998, 1)
NEAR = folded(6, 0, 1)
FAR = square(np.array([-1, 1]) / math.sqrt(24), np.array([1, -1]) / math.sqrt(24), np.full(2, 0.5))
BANDS = ((0, PEAK), (1.5, NEAR), (4, gauss(5)), (12, gauss(3)), (40, gauss(2)))


def mean(light, view, at, source, rule):
    ax, ay, sx, sy, weight = rule
    p, q = view(at[0] + ax, at[1] + ay)[0], view(source[0] + sx, source[1] + sy)[0]
    return weight @ light(p, q) * view(*source)[1]


def definition(light, view, at, source, away, bands=BANDS):
    """At places, or of sources at places, by a rule for each band of pixels away."""
    out, at, source = np.zeros(away.shape), np.broadcast_arrays(*at, away)[:2], \
        np.broadcast_arrays(*source, away)[:2]
    for (low, rule), high in zip(bands, [low for low, _ in bands[1:]] + [math.inf]):
        pick = np.flatnonzero((away >= low) & (away < high))
        for part in np.array_split(pick, 1 + len(pick) * len(rule[4]) // 2000000):
            out[part] = mean(light, view, [a[part] for a in at], [s[part] for s in source], rule)
    return out


# -- runs ----------------------------------------------------------------------------


def write(path, image):
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % image.shape[1::-1])
        f.write(image[::-1].astype("<f4").tobytes())


def run(glarepp, report, *words):
    subprocess.run([glarepp, "-q", "--report", report, *words], check=True)
    with open(report, encoding="utf-8") as f:
        return [json.loads(line) for line in f]


def glare(glarepp, folder, image, *words):
    """The layer of an image, or of a frame's path, and its facts."""
    frame, layer = folder + "/f.pfm", folder + "/l.pfm"
    if isinstance(image, str):
        frame = image
    else:
        write(frame, image)
    facts = run(glarepp, folder + "/r", "--edges", "black", "--layer", layer, *words, frame)[0]
    with open(layer, "rb") as f:
        w, h = (int(n) for n in (f.readline(), f.readline(), f.readline())[1].split())
        return np.frombuffer(f.read(), "<f4").reshape(h, w, 3)[::-1].astype(float), facts


def lamp(w, h, px, py):
    image = np.zeros((h, w, 3), np.float32)
    image[py, px] = 1e6
    return image


def rel_l2(got, want, weight=1.0):
    return math.sqrt((weight * (got - want) ** 2).sum() / (weight * want ** 2).sum())


# -- bars ----------------------------------------------------------------------------


def lamps(glarepp, folder):
    ways = (("default options", (), 1e-3), ("--tolerance 1e-5", ("--tolerance", "1e-5"), 1e-5),
            ("levels alone", ("-e", "fft"), None),
            ("levels alone, 1e-5", ("-e", "fft", "--tolerance", "1e-5"), None))
    y, x = (g.ravel() for g in np.mgrid[0:H, 0:W])
    for fov in 30, 40, 60, 90, 120:
        view = perspective(pixel_width(fov, H), W, H)
        for model, light in MODELS.items():
            worst, of_bound = {name: 0.0 for name, *_ in ways}, 0.0
            for place in 0.5, 0.75, 0.98:
                px, py = int(W * place), int(H * place)
                away = np.hypot(x - px, y - py)
                want = definition(light, view, (x, y), (px, py), away)
                for name, words, _ in ways:
                    got, facts = glare(glarepp, folder, lamp(W, H, px, py), *LONE, "-k", model,
                                       "--fov", str(fov), *words)
                    got = got[:, :, 1].ravel() / 1e6
                    worst[name] = max(worst[name], rel_l2(got[away >= 4], want[away >= 4]))
                    of_bound = max(of_bound, rel_l2(got, want) / facts["bound"])
            for name, _, bar in ways:
                yield "lamp, %d degrees, %s, %s: rel_l2" % (fov, model, name), worst[name], bar
            yield "  over its bound, all pixels", of_bound, 1


def apertures(glarepp, folder):
    """A hexagon, finer than a pixel, against its definition where it is not yet faded; and
    against means over each pair's own pixels, by as many pairs of points."""
    n = 15000
    root = 1.1673039782614187  # of x^5 = x + 1: Kronecker's points of four dimensions
    pair = np.mod(0.5 + np.outer(np.arange(1, n + 1), root ** -np.arange(1.0, 5)), 1) - 0.5
    points = (*pair.T[:, :, None], np.full(n, 1 / n))
    y, x = (g.ravel() for g in np.mgrid[0:H, 0:W])
    ways = (("sum", ()), ("transform", ("-e", "fft")), ("1e-5", ("--tolerance", "1e-5")),
            ("plane", ("--projection", "plane")))
    for fov, mm in (30, 1), (40, 1), (60, 0.5), (90, 0.25), (120, 0.25):
        view, k, off = perspective(pixel_width(fov, H), W, H), pixel_width(fov, H), {}
        words = (*LONE, "--fov", str(fov), "-k", "aperture:share=1,dust=0,scratches=0,"
                 "wavelength=550,reach=90,rotation=20,pupil=%g" % mm)
        for place in 0.5, 0.75, 0.98:
            px, py = int(W * place), int(H * place)
            away = np.hypot(x - px, y - py)
            pick = np.flatnonzero((away >= 4) & (away < 30))
            (p, _), (q, solid) = view(x[pick], y[pick]), view(px, py)
            want = np.maximum(spread(p[0] - q[0], p[1] - q[1], k, mm), 0) * q[2] * solid
            some = pick[::10]
            means = definition(lambda p, q: hexagon(p, q, mm), view, (x[some], y[some]),
                               (px, py), away[some], ((0, points),))
            layer = {}
            for name, way in ways:
                got, facts = glare(glarepp, folder, lamp(W, H, px, py), *words, *way)
                layer[name] = got[:, :, 1].ravel() / 1e6
                off.setdefault(name, []).append(rel_l2(layer[name][pick], want))
                off.setdefault(name + " means", []).append(rel_l2(layer[name][some], means))
                if name == "transform":
                    off.setdefault("bound", []).append(
                        rel_l2(layer[name], layer["sum"]) / facts["bound"])
            off.setdefault("both", []).append(rel_l2(layer["1e-5"], layer["sum"]))
        yield "lamp, %d degrees, a hexagon, default options: rel_l2" % fov, max(off["sum"]), 1e-3
        yield "  by transform", max(off["transform"]), 1e-3
        yield "  --tolerance 1e-5, over the sum of all pairs", max(off["both"]), 1e-5
        yield "  transform over sum, over its bound, all pixels", max(off["bound"]), 1
        for i, place in enumerate(("in the middle", "at 3/4", "in the corner")):
            yield "  over means of pixels as sharp as their own, " + place, off["sum means"][i], None
            yield "    a plane's", off["plane means"][i], None


def camera(stem):
    """The width of a pixel by a frame's own camera, at a distance of 1."""
    with open(stem + ".camera.json", encoding="utf-8") as f:
        facts = json.load(f)
    m = np.array(facts["frames"][0]["worldToNDC_blender_colvec"]).reshape(4, 4)[:, :3]
    return 2 / facts["height"] * np.linalg.norm(m[3]) / np.linalg.norm(m[1])


def of_data(glarepp, folder):
    if not os.path.isdir(DATA):
        yield "frames of the data: left out, no folder " + DATA, None, None
        return
    import OpenImageIO as oiio
    rng, n = np.random.default_rng(5), 400
    bands = (0, folded(4, 0, 0.05, 0.2, 0.5, 0.8, 0.95, 1)), (2, NEAR), (9, FAR)
    for stem in "rendered/night", "scenes/street", "scenes/forest", "rendered/window":
        name, k = os.path.basename(stem), camera(os.path.join(DATA, stem))
        path = os.path.join(DATA, stem + ".1001.exr")
        image = oiio.ImageBuf(path).get_pixels(oiio.FLOAT)[:, :, :3].astype(float)
        h, w = image.shape[:2]
        view = perspective(k, w, h)
        lum = image @ (0.2126390, 0.7151687, 0.0721923)
        sy, sx = np.nonzero(lum > 1)
        light = image[sy, sx] * (1 - 1 / lum[sy, sx])[:, None]
        order = np.argsort(-lum.ravel(), kind="stable")
        pick = np.concatenate([order[:n], rng.choice(order[n:], n, False)])
        weight = np.repeat([1, (w * h - n) / n], n)[:, None]
        want = np.array([definition(MODELS["eye"], view, (i % w, i // w), (sx, sy),
                                    np.maximum(abs(sx - i % w), abs(sy - i // w)), bands) @ light
                         for i in pick])
        got, facts = glare(glarepp, folder, path, "-k", "eye")
        got = got.reshape(-1, 3)[pick]
        off = rel_l2(got, want, weight)
        yield "%s, %d sources: rel_l2" % (name, len(sx)), off, 1e-3
        yield "  95 % of pixels' veil within", \
            np.quantile(abs(got[n:, 1] / want[n:, 1] - 1), 0.95), 5e-3
        yield "  rel_l2 over its bound", off / facts["bound"], 1


def spheres(glarepp, folder):
    h, places = 1024, ((1024, 512), (0, 512), (2047, 511), (512, 200), (0, 820), (2047, 100),
                       (190, 15), (1300, 5), (630, 1), (0, 0), (1536, 1023), (2047, 1010))
    view, step = latlong(h), math.pi / h
    y, x = (g.ravel() for g in np.mgrid[0:h, 0:2 * h])
    far, (at, solid) = np.random.default_rng(7).random(x.size) < 0.1, view(x, y)
    most = worst = kept = 0.0
    for px, py in places:
        got, _ = glare(glarepp, folder, lamp(2 * h, h, px, py), *LONE, "-k", "eye",
                       "--projection", "latlong")
        got = got[:, :, 1].ravel() / 1e6
        kept = max(kept, abs(got @ solid / solid[py * 2 * h] - 1))
        away = np.sqrt(sum((a - b) ** 2 for a, b in zip(at, view(px, py)[0]))) / step
        pick = np.flatnonzero((away >= 4) & (far | (away < 40)))
        off = abs(got[pick] / definition(MODELS["eye"], view, (x[pick], y[pick]), (px, py),
                                         away[pick]) - 1)
        most, worst = max(most, np.quantile(off[far[pick]], 0.99)), max(worst, off.max())
    yield "lat-long 2048x1024, a lamp in 12 places: 99 % of pixels' veil within", most, 3e-3
    yield "  its worst pixel's, 4 rows and more away", worst, None
    yield "  light that is not kept, or too much", kept, 1e-3


def views(glarepp, folder):
    """A lat-long's glare as a perspective shows it, against the glare of that view with what
    is 60 degrees beside it."""
    h, fov, wide, size = 1024, 40, 100, (288, 512)
    rng = np.random.default_rng(3)
    light = np.zeros((h, 2 * h, 3), np.float32)
    for _ in range(40):  # lamps of 5x5 pixels before the camera
        y, x = rng.integers(h // 3, 2 * h // 3), rng.integers(2 * h // 3, 4 * h // 3)
        light[y:y + 5, x:x + 5] = rng.random() * 1e4

    def places(k, height, width, parts):
        """Of a view's pixels on the sphere, or of their parts."""
        y, x = np.mgrid[0:height * parts, 0:width * parts] / parts + (0.5 / parts - 0.5)
        (x, y, z), _ = perspective(k, width, height)(x, y)
        return np.arctan2(x, z) * h / math.pi + h, np.arcsin(y) * h / math.pi + h / 2
    k = pixel_width(fov, size[0])
    over = [round(n * math.tan(math.radians(wide / 2)) / math.tan(math.radians(fov / 2)) / 2) * 2
            for n in size]
    x, y = (n.astype(int) for n in places(k, *over, 8))
    seen = light[y, x].reshape(over[0], 8, over[1], 8, 3).mean((1, 3))
    want, _ = glare(glarepp, folder, seen, *LONE, "-k", "eye", "--projection", "perspective",
                    "--fov", str(2 * math.degrees(math.atan(k * over[0] / 2))))
    got, _ = glare(glarepp, folder, light, *LONE, "-k", "eye", "--projection", "latlong")
    top, left = ((o - n) // 2 for o, n in zip(over, size))
    want, lit = (a[top:top + size[0], left:left + size[1], 1] for a in (want, seen))
    x, y = (n - 0.5 for n in places(k, *size, 1))
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    x, y, got = x - i, y - j, got[:, :, 1]
    got = (1 - y) * ((1 - x) * got[j, i] + x * got[j, i + 1]) + \
        y * ((1 - x) * got[j + 1, i] + x * got[j + 1, i + 1])
    y, x = np.nonzero(lit)  # around lamps both round to pixels of their own
    near = np.zeros(size, bool)
    for a, b in np.ndindex(25, 25):
        near[np.clip(y + a - 12, 0, size[0] - 1), np.clip(x + b - 12, 0, size[1] - 1)] = True
    yield "lat-long cut into a view of 40 degrees, 12 pixels and more from lamps: rel_l2", \
        rel_l2(got[~near], want[~near]), 1e-2


def timed(glarepp, folder, frames, runs, ways):
    """The glare stage of each way over that of the first, and its memory."""
    rows = {name: [] for name in ways}
    for name in list(ways) * runs:
        rows[name].append(run(glarepp, folder + "/r", "--layer", folder + "/" + name + ".@.pfm",
                              *ways[name], frames))
    ms = {name: [statistics.median(r["times_ms"]["glare"] for r in reports[1:])
                 for reports in found] for name, found in rows.items()}
    first = next(iter(ways))
    return {name: statistics.median(a / b for a, b in zip(ms[name], ms[first])) for name in ways}, \
        {name: found[0][0] for name, found in rows.items()}


def speeds(glarepp, folder, frames):
    plane = ("-k", "eye", "--projection", "plane")
    for name in "w1", "w2", "w3":
        for i in range(1, 5):
            os.symlink(os.path.join(frames, name + "_1920.exr"),
                       os.path.join(folder, "%s.%d.exr" % (name, i)))
    for fov, bar in (20, 1.02), (40, 1.5), (90, 2.0):
        for name in "w1", "w2", "w3":
            ratio, _ = timed(glarepp, folder, folder + "/" + name + ".@.exr", 5, {
                "plane": (*plane, "--fov", str(fov)), "true": ("-k", "eye", "--fov", str(fov))})
            yield "glare stage over a plane's, 1920x1080, %s, %d degrees" % (name, fov), \
                ratio["true"], bar
    for name in "w1", "w2", "w3":
        words = ("--threads", "1", "--fov", "30")
        ratio, _ = timed(glarepp, folder, folder + "/" + name + ".@.exr", 1, {
            "plane": (*words, "--projection", "plane"), "true": (*words, "--tolerance", "0.01")})
        yield "  the default style, --tolerance 0.01, one thread, %s, 30 degrees" % name, \
            ratio["true"], None
    ratio, facts = timed(glarepp, folder, folder + "/w2.@.exr", 9, {
        "given": ("-k", "eye", "--fov", "30"), "assumed": ("-k", "eye")})
    yield "w2 without --fov: the report does not say that it is assumed", \
        int(facts["assumed"]["fov_from"] != "default"), 0
    yield "  layers that differ from those of --fov 30", \
        sum(not filecmp.cmp(*("%s/%s.%d.pfm" % (folder, name, i) for name in ratio), False)
            for i in range(1, 5)), 0
    yield "  glare stage over that of --fov 30", ratio["assumed"], 1.02
    for name in "w1", "w2", "w3":
        frame = os.path.join(frames, name + "_3840.exr")
        mib = [run(glarepp, folder + "/r", *words, "-k", "eye", "--fov", "90", "--layer",
                   folder + "/l.pfm", frame)[0]["peak_rss_mib"]
               for words in ((), ("--projection", "plane"))]
        yield "memory over a plane's, 3840x2160, %s, 90 degrees" % name, mib[0] / mib[1], 1.25


def sphere_speeds(glarepp, folder):
    rng = np.random.default_rng(1)
    for name, side, share in ("lamps", 1, 1e-4), ("windows", 8, 0.03), ("sky", 8, 0.4):
        image = rng.random((2048, 4096, 3), np.float32) * 0.5
        lit = rng.random((2048 // side, 4096 // side)) < share
        image[np.kron(lit, np.ones((side, side), bool))] *= 100.0
        for i in range(1, 4):
            write(folder + "/s.%d.pfm" % i, image)
        plane = ("-k", "eye", "--fov", "150", "--projection", "plane")
        ratio, facts = timed(glarepp, folder, folder + "/s.@.pfm", 3, {
            "plane": (*plane, "-e", "fft"), "auto": plane,
            "true": ("-k", "eye", "--projection", "latlong")})
        yield "glare stage over a plane's fft, lat-long 4096x2048, %s" % name, ratio["true"], 2.5
        yield "  over what auto takes on a plane, %s" % facts["auto"]["engine"], \
            ratio["true"] / ratio["auto"], None


def hard(glarepp):
    tests = os.path.join(os.path.dirname(glarepp), "tests")
    for words in ("glare", "sky"), ("glare", "sphere"), ("hardcases", "field"):
        p = subprocess.run([os.path.join(tests, words[0]), words[1]], capture_output=True,
                           env={**os.environ, "GLAREPP_TEST_QUICK": "1"}, text=True)
        failed = p.stdout.count("[  FAILED  ]") + p.stderr.count("[  FAILED  ]")
        yield "hard cases of each projection, tests/%s %s: failures" % words, \
            max(failed, int(p.returncode != 0)), 0


def bars(glarepp):
    """Rows: text, measured, bar or None."""
    with tempfile.TemporaryDirectory() as folder:
        frames = os.path.abspath(os.environ.get("FRAMES") or folder + "/frames")
        if not os.path.exists(frames + "/w3_3840.exr"):
            os.makedirs(frames, exist_ok=True)
            subprocess.run([sys.executable, ROOT + "/tests/bench/frames.py", frames], check=True)
        for part in lamps, apertures, of_data, spheres, views:
            yield from part(glarepp, folder)
        yield from speeds(glarepp, folder, frames)
        yield from sphere_speeds(glarepp, folder)
        yield from hard(glarepp)
