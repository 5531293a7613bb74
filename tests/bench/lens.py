# SPDX-License-Identifier: Apache-2.0
"""Ghosts of the installed lenses against single rays at 26 wavelengths (trace.c).

The light of a lamp's ghosts, by channel and as luminance: in the frame and beyond it.
"""
import glob
import json
import math
import os
import shlex
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
W, H = 96, 64
PLACES = [("middle", 50.5, 33.1), ("side", 0.75 * W - 3, 0.5 * H + 5), ("corner", 88.3, 6.2)]
NM = [380 + 400 * (i + 0.5) / 26 for i in range(26)]


# primaries: chromaticities, of XYZ, weights of luminance; SMPTE ST 2065-1 has no colour with
# a channel under 0, which a pixel of the other would have to be folded to, as those of the
# wide rainbows that lamps in the corner make are
BT709 = ((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),
         ((3.2409699419, -1.5373831776, -0.4986107603),
          (-0.9692436363, 1.8759675015, 0.0415550574),
          (0.0556300797, -0.2039769589, 1.0569715142)),
         (0.2126390059, 0.7151686788, 0.0721923154))
AP0 = ((0.7347, 0.2653, 0, 1, 0.0001, -0.077, 0.32168, 0.33767),
       ((1.0498110175, 0, -0.0000974845), (-0.4959030231, 1.3733130458, 0.0982400361),
        (0, 0, 0.9912520182)),
       (0.3439664498, 0.7281660966, -0.0721325464))


def colours(primaries):
    """Linear colours of the parts: CIE 1931 by Wyman, Sloan and Shirley 2013, eq. 4; equal
    energy is white."""
    def g(nm, peak, a, b):
        return math.exp(-0.5 * ((nm - peak) / (a if nm < peak else b)) ** 2)
    xyz = [(1.056 * g(v, 599.8, 37.9, 31.0) + 0.362 * g(v, 442.0, 16.0, 26.7) -
            0.065 * g(v, 501.1, 20.4, 26.2),
            0.821 * g(v, 568.8, 46.9, 40.5) + 0.286 * g(v, 530.9, 16.3, 31.1),
            1.217 * g(v, 437.0, 11.8, 36.0) + 0.681 * g(v, 459.0, 26.0, 13.8)) for v in NM]
    sums = [sum(v[c] for v in xyz) for c in range(3)]
    x, y = primaries[0][6:]
    white = (x / y, 1.0, (1 - x - y) / y)
    return [[sum(row[c] * v[c] / sums[c] * white[c] for c in range(3)) for row in primaries[1]]
            for v in xyz]


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


def traced(tracer, primaries, words, *pair):
    """By pair of surfaces the colours in the frame and of all light."""
    rgb = colours(primaries)
    out = subprocess.run([tracer, *map(str, pair)], input=words, text=True, check=True,
                         capture_output=True).stdout
    ghosts = {}
    for line in out.splitlines():
        v = line.split()
        ghosts[int(v[0]), int(v[1])] = [
            [sum(rgb[i][c] * float(v[2 + 2 * i + k]) for i in range(26)) for c in range(3)]
            for k in range(2)]
    return ghosts


def drawn(glarepp, primaries, lens, x, y, width):
    """The colour of the layer's pixels, and of all light, by the report."""
    flux = 1e6
    with open("lens.json", "w") as f:
        json.dump(lens, f)
    with open("lamp.json", "w") as f:
        json.dump([{"pixel": [x, y], "radius": 0.5, "flux": [flux] * 3}], f)
    subprocess.run([sys.executable, HERE + "/../cli/exr.py", "black.exr", "kind=zeros",
                    "size=%dx%d" % (W, H), "attr=chromaticities:chromaticities:" +
                    ",".join(map(str, primaries[0]))], check=True)
    out = subprocess.run([glarepp, "-q", "--lights", "lamp.json", "--sun-in-frame", "--lens",
                          "./lens.json", "--sensor-size", str(width), "--layer", "layer.pfm",
                          "--report", "-", "black.exr"], check=True, capture_output=True).stdout
    report = json.loads(out)
    return [[a / flux for a in v] for v in (report["flux_out"], report["lens"]["flux"])]


def luminance(primaries, rgb):
    return sum(a * b for a, b in zip(primaries[2], rgb))


def apart(primaries, got, want):
    """The worst channel, and luminance: relative. A channel under 1 % of the brightest is what
    is left of parts that cancel: it does not count."""
    y = [luminance(primaries, v) for v in (got, want)]
    least = 0.01 * max(map(abs, want))
    return (max(abs(a / b - 1) for a, b in zip(got, want) if abs(b) > least),
            abs(y[0] / y[1] - 1))


def layers(nm, degrees, glass, films):
    """The share that films on glass reflect, from the air: (n, nm of a quarter wave) each, by
    characteristic matrices; Macleod, Thin-Film Optical Filters, section 2."""
    share, sine = 0, math.sin(math.radians(degrees))
    def tilted(n, p):
        c = math.sqrt(1 - (sine / n) ** 2)
        return n / c if p else n * c
    for p in range(2):
        b, c = 1, tilted(glass, p)
        for n, quarter in reversed(films):
            phase = math.pi / 2 * quarter / nm * math.sqrt(1 - (sine / n) ** 2)
            e, x, y = tilted(n, p), math.cos(phase), 1j * math.sin(phase)
            b, c = x * b + y / e * c, y * e * b + x * c
        air = tilted(1, p)
        share += 0.5 * abs((air * b - c) / (air * b + c)) ** 2
    return share


def broadband(lens):
    """The lens with three layers, quarter, half and quarter wave, on all that has a coat."""
    nm, degrees = list(range(360, 801, 10)), list(range(0, 86, 5))
    films = (1.38, 520), (2.1, 1040), (1.65, 520)
    return {**lens, "coating": "three layers", "coatings": [
        {"name": "three layers", "nm": nm, "degrees": degrees,
         "reflectance": [layers(v, a, 1.62, films) for v in nm for a in degrees]}]}


def alone(lens, pair):
    """The lens of which two surfaces reflect."""
    surfaces = []
    for i, s in enumerate(lens["surfaces"]):
        before = lens["surfaces"][i - 1].get("n", 1.0) if i else 1.0
        air = (before == 1) != (s.get("n", 1.0) == 1)
        coat = s.get("coating", lens.get("coating", 0) if air else 0)
        surfaces.append(s if s.get("stop") else
                        {**s, "coating": coat if i in pair else "none"})
    none = {"name": "none", "nm": [300, 900], "degrees": [0, 80], "reflectance": [0] * 4}
    return {**lens, "surfaces": surfaces, "coatings": [*lens.get("coatings", []), none]}


def measure(glarepp, tracer, primaries, lens, x, y, singly):
    """Relative errors, worst channel and luminance, of the ghosts of a lamp at a pixel in the
    frame, of all their light, and, singly, of that of each ghost which has over 1 % of it."""
    focal = first_order(lens)[0]
    # a sensor about as large as the lens's format, of which 84 mm is the largest; the light
    # is in the frame: nothing says that one beside it is seen
    width = min(84.0, 0.6 * focal)
    mm = width / W
    axis = (width / 2, H * mm / 2)
    dx, dy = x * mm - axis[0], y * mm - axis[1]
    words = (math.hypot(dx, dy), math.atan2(dy, dx), (width, H * mm), axis)
    ghosts = traced(tracer, primaries, numbers(lens, *words))
    want = [[sum(g[k][c] for g in ghosts.values()) for c in range(3)] for k in range(2)]
    got = drawn(glarepp, primaries, lens, x, y, width)
    rows = [apart(primaries, *v) for v in zip(got, want)]
    for pair, ghost in ghosts.items():
        if singly and luminance(primaries, ghost[1]) > 0.01 * luminance(primaries, want[1]):
            single = alone(lens, pair)
            truth = traced(tracer, primaries, numbers(single, *words), *pair)[pair]
            found = drawn(glarepp, primaries, single, x, y, width)
            rows.append(apart(primaries, found[1], truth[1]))
    return rows


def bars(glarepp):
    """Rows: text, measured, bar."""
    lenses = {}
    for path in sorted(glob.glob(HERE + "/../../examples/lenses/*.json")):
        with open(path) as f:
            lenses[os.path.basename(path)[:-5]] = json.load(f)
    lenses["three-layers"] = broadband(lenses["heliar"])
    back = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            tracer = folder + "/trace"
            subprocess.run([*shlex.split(os.environ.get("CC", "cc")), "-O3", "-ffast-math",
                            HERE + "/trace.c", "-o", tracer, "-lm"], check=True)
            for name in os.environ.get("GLAREPP_LENSES", "").split(",") \
                    if os.environ.get("GLAREPP_LENSES") else lenses:
                for where, x, y in PLACES:
                    wide = where == "corner" or "coatings" in lenses[name]
                    frame, light, *each = measure(glarepp, tracer, AP0 if wide else BT709,
                                                  lenses[name], x, y, where != "middle")
                    text = "2.1 %s, %s: " % (name, where)
                    yield text + "ghosts in the frame, worst channel", frame[0], 0.03
                    yield text + "in and beside it, worst channel", light[0], 0.03
                    if each:
                        yield text + "each of %d over 1 %% of this, worst channel" % len(each), \
                            max(e[0] for e in each), 0.03
                    yield text + "luminance", max(frame[1], light[1]), 0.015
                    if name == "tessar":
                        yield text + "flux", light[1], 0.005
        finally:
            os.chdir(back)
