# SPDX-License-Identifier: Apache-2.0
"""Ghosts of the installed lenses against single rays at 26 wavelengths (trace.c).

The light of a lamp's ghosts, by channel and as luminance: in the frame and beyond it.
"""
import array
import glob
import json
import math
import os
import subprocess
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
W, H = 96, 64
NM = [380 + 400 * (i + 0.5) / 26 for i in range(26)]


def colours():
    """Linear BT.709 of the parts: CIE 1931 by Wyman, Sloan and Shirley 2013, eq. 4; equal
    energy is white."""
    def g(nm, peak, a, b):
        return math.exp(-0.5 * ((nm - peak) / (a if nm < peak else b)) ** 2)
    xyz = [(1.056 * g(v, 599.8, 37.9, 31.0) + 0.362 * g(v, 442.0, 16.0, 26.7) -
            0.065 * g(v, 501.1, 20.4, 26.2),
            0.821 * g(v, 568.8, 46.9, 40.5) + 0.286 * g(v, 530.9, 16.3, 31.1),
            1.217 * g(v, 437.0, 11.8, 36.0) + 0.681 * g(v, 459.0, 26.0, 13.8)) for v in NM]
    white = [sum(v[c] for v in xyz) for c in range(3)]
    d65 = (0.3127 / 0.329, 1.0, (1 - 0.3127 - 0.329) / 0.329)
    to = ((3.2409699419, -1.5373831776, -0.4986107603),
          (-0.9692436363, 1.8759675015, 0.0415550574),
          (0.0556300797, -0.2039769589, 1.0569715142))
    return [[sum(row[c] * v[c] / white[c] * d65[c] for c in range(3)) for row in to]
            for v in xyz]


RGB = colours()
LUMINANCE = (0.2126390059, 0.7151686788, 0.0721923154)


def first_order(lens):
    """Focal length, and the gap from the last surface to the image of what is far."""
    y, v, n = 1.0, 0.0, 1.0
    for s in lens["surfaces"]:
        after = n if s.get("stop") else s.get("n", 1.0)
        r = s.get("radius", 0)
        v = (n * v - (y * (after - n) / r if r else 0)) / after
        n = after
        last, y = y, y + v * s.get("thickness", 0)
    return -1 / v, -last / v


def numbers(lens, away, toward, sensor, axis):
    """The input of the tracer."""
    focal, gap = first_order(lens)
    names = [t["name"] for t in lens.get("coatings", [])]
    stop = [i for i, s in enumerate(lens["surfaces"]) if s.get("stop")][0]
    out = [len(lens["surfaces"]), stop, lens.get("blades", 0), lens.get("blade_turn", 0),
           away / focal, *sensor, math.degrees(toward), *axis]
    n, v = 1.0, 0.0
    for i, s in enumerate(lens["surfaces"]):
        before = n
        if not s.get("stop"):
            n, v = s.get("n", 1.0), s.get("v", 0.0)
        coated = not s.get("stop") and before != n and (before == 1 or n == 1)
        coat = s.get("coating", lens.get("coating", 0) if coated else 0)
        last = i + 1 == len(lens["surfaces"])
        out += [s.get("radius", 0), gap if last else s["thickness"], n, v, s["semi"],
                -1 - names.index(coat) if isinstance(coat, str) else coat]
    out.append(len(names))
    for t in lens.get("coatings", []):
        out += [len(t["nm"]), len(t["degrees"]), *t["nm"], *t["degrees"], *t["reflectance"]]
    return " ".join("%.12g" % x for x in out)


def traced(tracer, words, *pair):
    """By pair of surfaces the colours in the frame and of all light."""
    out = subprocess.run([tracer, *map(str, pair)], input=words, text=True, check=True,
                         capture_output=True).stdout
    ghosts = {}
    for line in out.splitlines():
        v = line.split()
        ghosts[int(v[0]), int(v[1])] = [
            [sum(RGB[i][c] * float(v[2 + 2 * i + k]) for i in range(26)) for c in range(3)]
            for k in range(2)]
    return ghosts


def drawn(glarepp, lens, x, y, width):
    """The colour of the layer's pixels, and of all light by the report."""
    flux = 1e6
    with open("lens.json", "w") as f:
        json.dump(lens, f)
    with open("lamp.json", "w") as f:
        json.dump([{"pixel": [x, y], "radius": 0.5, "flux": [flux] * 3}], f)
    with open("black.pfm", "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (W, H) + bytes(12 * W * H))
    out = subprocess.run([glarepp, "-q", "--lights", "lamp.json", "--sun-in-frame", "--lens",
                          "./lens.json", "--sensor-size", str(width), "--layer", "layer.pfm",
                          "--report", "-", "black.pfm"], check=True, capture_output=True).stdout
    report = json.loads(out)
    with open("layer.pfm", "rb") as f:
        for _ in range(3):
            f.readline()
        v = array.array("f", f.read())
    return [[sum(v[c::3]) / flux for c in range(3)], [a / flux for a in report["lens"]["flux"]]]


def apart(got, want):
    """The worst channel, and luminance: relative."""
    y = [sum(a * b for a, b in zip(LUMINANCE, v)) for v in (got, want)]
    return max(abs(a / b - 1) for a, b in zip(got, want)), abs(y[0] / y[1] - 1)


def measure(glarepp, tracer, lens):
    """Relative errors of all ghosts, channel and luminance: in the frame, and of all."""
    focal = first_order(lens)[0]
    # a sensor of the lens's format; the light at a slope of .15, not far beyond the frame
    width = min(84.0, 0.6 * focal)
    mm = width / W
    axis = (width / 2, H * mm / 2)
    x, y = 0.5 * W - 3 + 0.15 * focal / mm, 0.5 * H + 5
    dx, dy = x * mm - axis[0], y * mm - axis[1]
    words = (math.hypot(dx, dy), math.atan2(dy, dx), (width, H * mm), axis)
    ghosts = traced(tracer, numbers(lens, *words))
    want = [[sum(g[k][c] for g in ghosts.values()) for c in range(3)] for k in range(2)]
    got = drawn(glarepp, lens, x, y, width)
    rows = {"frame": apart(got[0], want[0]), "all": apart(got[1], want[1])}
    return rows


def bars(glarepp):
    """Rows: text, measured, bar."""
    lenses = {}
    for path in sorted(glob.glob(HERE + "/../../examples/lenses/*.json")):
        with open(path) as f:
            lenses[os.path.basename(path)[:-5]] = json.load(f)
    back = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            tracer = folder + "/trace"
            subprocess.run([os.environ.get("CC", "cc"), "-O3", "-ffast-math", HERE + "/trace.c",
                            "-o", tracer, "-lm"], check=True)
            for name in os.environ.get("GLAREPP_LENSES", "").split(",") \
                    if os.environ.get("GLAREPP_LENSES") else lenses:
                r = measure(glarepp, tracer, lenses[name])
                yield "2.1 %s: ghosts in the frame, worst channel" % name, r["frame"][0], 0.03
                yield "2.1 %s: ghosts in and beside it, worst channel" % name, r["all"][0], 0.03
                yield "2.1 %s: their luminance" % name, r["all"][1], \
                    0.005 if name == "tessar" else 0.015
        finally:
            os.chdir(back)
