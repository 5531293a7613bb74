# SPDX-License-Identifier: Apache-2.0
"""Shares of lights that are hidden in part, against what second cameras saw.

The truths are of the triangles made here, of deep.py's leaves, smoke and hair, and the data's
($GLAREPP_DATA, or ../shared/data beside the repository); tests/cli/shares.t and deep.t test
the same.
"""
import base64
import json
import math
import os
import random
import re
import struct
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CLI = os.path.join(ROOT, "tests", "cli")
sys.path.append(CLI)
import exr  # noqa: E402
DATA = os.environ.get("GLAREPP_DATA", os.path.join(ROOT, "..", "shared", "data"))
FRAMES = ("seq_foliage/foliage", "seq_foliage/foliage_f32", "rendered/window",
          "rendered/brightsky", "scenes/forest")


def lights(glarepp, folder, *words):
    """The reports of frames, a line each."""
    out = os.path.join(folder, "r.json")
    subprocess.run([glarepp, "-q", *words, "--report", out], check=True, cwd=folder)
    with open(out, encoding="utf-8") as f:
        return f.read()


def against_truth(folder, reports):
    """Shares, those whose interval misses the truth, the worst error."""
    out = os.path.join(folder, "all.json")
    with open(out, "w", encoding="utf-8") as f:
        f.write("".join(reports))
    p = subprocess.run([sys.executable, os.path.join(CLI, "shares.py"), DATA, out, "1,1"],
                       check=True, capture_output=True, text=True)
    count, holds = map(int, p.stdout.split()[:2])
    return count, count - holds, float(re.search(r"worst ([.\d]+)", p.stderr)[1])


def seen(glarepp, folder, *words):
    """Shares of the sun in the data's frames."""
    return [json.loads(line)["lights"][0]["visibility"] for stem in FRAMES
            for line in lights(glarepp, folder, *words, "--camera",
                               f"{DATA}/{stem}.camera.json",
                               f"{DATA}/{stem}.####.exr").splitlines()]


def of_data(glarepp, folder):
    by_depth = [lights(glarepp, folder, "--camera", f"{DATA}/{stem}.camera.json",
                       f"{DATA}/{stem}.####.exr") for stem in FRAMES]
    count, missed, worst = against_truth(folder, by_depth)
    yield f"the frame's depth, {count} suns: worst share", worst, 0.07
    yield "  intervals that miss the truth", missed, 0
    for how, bar in (("scene", 3e-4), ("depth", 0.07)):
        by = [lights(glarepp, folder, "--sun-share", how, "--scene", f"{DATA}/scenes/{name}.glb",
                     *words, f"{DATA}/scenes/{name}.####.exr")
              for name, words in (("forest", ("--sun-size", "0.53")), ("street", ()))]
        count, missed, worst = against_truth(folder, by)
        yield f"scenes, {count} lights by --sun-share {how}: worst share", worst, bar
        yield "  intervals that miss the truth", missed, 0
    exact = seen(glarepp, folder)
    for side in "32", "64":
        small = seen(glarepp, folder, "--sun-method", "mask", "--sun-sum", "8bit",
                     "--sun-map", side)
        yield (f"a sun map of {side}, summed in 8 bits: worst share from the exact one",
               max(abs(a - b) for a, b in zip(small, exact)), 0.02)


# -- triangles of this file --------------------------------------------------------

W, H, FOV, SUN, BALL = 240, 160, math.radians(35), 1.2, 0.13  # suns of 2.6 pixels' radius
T = math.tan(FOV / 2)
PLACES = [(120.3, 82.7), (40, 30.2), (200.7, 120.4), (150.2, 40.6), (70.5, 110.3), (180, 75.9),
          (3, 60), (239, 100), (100.4, -0.5), (-30, 70)]  # the last four not whole in the frame


def direction(x, y):
    """The ray of a pixel's place from a camera at 0 that looks along -z."""
    return (x / W * 2 - 1) * T * W / H, (1 - y / H * 2) * T, -1.0


def cut(tri, y):
    """The ends of a triangle (x, y) on a row, none where it is beside it."""
    x = [p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0])
         for p, q in zip(tri, tri[1:] + tri[:1]) if (p[1] <= y) != (q[1] <= y)]
    return (min(x), max(x)) if x else None


def shown(triangles, d, radius):
    """The share of a disc around d that no triangle covers: exact along 4000 rows."""
    length = math.hypot(*d)
    d = [v / length for v in d]
    side = math.hypot(d[0], d[2])
    u = -d[2] / side, 0, d[0] / side
    v = d[1] * u[2], d[2] * u[0] - d[0] * u[2], -d[1] * u[0]

    def dot(a, b):
        return sum(p * q for p, q in zip(a, b))
    flat = [[(dot(p, u) / dot(p, d) / radius, dot(p, v) / dot(p, d) / radius) for p in tri]
            for tri in triangles]
    flat = [t for t in flat if all(min(p[i] for p in t) < 1 and max(p[i] for p in t) > -1
                                   for i in range(2))]
    total = hidden = 0
    for row in range(4000):
        y = (row + 0.5) / 2000 - 1
        end = math.sqrt(1 - y * y)
        at, total = -end, total + 2 * end
        for a, b in sorted(filter(None, (cut(t, y) for t in flat))):
            hidden += max(min(b, end) - max(a, at), 0)
            at = max(at, b)
    return 1 - hidden / total


def leaves(folder, seed):
    """s.gltf of leaves before suns and a lamp, f.exr with their depth; the true shares."""
    rng, triangles, truth = random.Random(seed), [], {}
    for _ in range(150):
        x, y = rng.choice(PLACES)
        far, size = rng.uniform(2, 40), rng.uniform(0.01, 0.04)
        if not 10 < far < 14:  # where the lamps are
            d = direction(x + rng.gauss(0, 4), y + rng.gauss(0, 4))
            triangles.append([tuple(far * (v + size * rng.gauss(0, 1)) for v in d)
                              for _ in range(3)])
    nodes, kinds = [{"camera": 0}, {"mesh": 0}], []
    for k, place in enumerate(PLACES):
        d = direction(*place)
        length = math.hypot(*d)
        lamp = k % 2  # else a sun, whose node's -z is where its light goes
        extra = {"ball_radius": BALL} if lamp else {"angle_deg": SUN}
        turn = (-d[1], d[0], 0, length + d[2])
        at = {"translation": [12 / length * v for v in d]} if lamp else {
            "rotation": [v / math.hypot(*turn) for v in turn]}
        nodes.append({"name": f"l{k}", "extras": extra, **at,
                      "extensions": {"KHR_lights_punctual": {"light": k}}})
        kinds.append({"type": "point" if lamp else "directional", "name": f"l{k}"})
        radius = math.tan(math.asin(BALL / 12)) if lamp else math.tan(math.radians(SUN / 2))
        truth[f"l{k}"] = shown([t for t in triangles if not lamp or -t[0][2] < 11], d, radius)
    data = struct.pack("<%df" % (9 * len(triangles)), *(v for t in triangles for p in t for v in p))
    ends = [[f(p[i] for t in triangles for p in t) for i in range(3)] for f in (min, max)]
    with open(folder + "/s.gltf", "w", encoding="utf-8") as f:
        json.dump({
            "asset": {"version": "2.0"}, "nodes": nodes,
            "cameras": [{"type": "perspective", "perspective": {"yfov": FOV, "znear": 0.1}}],
            "extensions": {"KHR_lights_punctual": {"lights": kinds}},
            "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," +
                         base64.b64encode(data).decode()}],
            "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3 * len(triangles),
                           "type": "VEC3", "min": ends[0], "max": ends[1]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]}, f)
    exr.pixels = lambda *_: lambda name, x, y: depth[y][x] if name == "Z" else 0.2
    depth = depths(triangles)
    sys.argv[1:], words = [folder + "/f.exr", f"size={W}x{H}", "channels=R,G,B,Z:float"], sys.argv[1:]
    exr.main()
    sys.argv[1:] = words
    return truth


def depths(triangles):
    """Z of each pixel's ray: the distance along the axis of what it meets first."""
    out = [[1e10] * W for _ in range(H)]
    for tri in triangles:
        flat = [((p[0] / -p[2] * H / W / T + 1) / 2 * W, (1 - p[1] / -p[2] / T) / 2 * H, -1 / p[2])
                for p in tri]  # 1 / z is even over the picture
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = flat
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        for y in range(max(math.floor(min(ay, by, cy)), 0), min(math.ceil(max(ay, by, cy)), H)):
            row = cut([p[:2] for p in flat], y + 0.5) or (0, 0)
            for x in range(max(math.ceil(row[0] - 0.5), 0), min(math.ceil(row[1] - 0.5), W)):
                px, py = x + 0.5 - ax, y + 0.5 - ay
                s = (px * (cy - ay) - py * (cx - ax)) / area
                t = (py * (bx - ax) - px * (by - ay)) / area
                out[y][x] = min(out[y][x], 1 / (az + s * (bz - az) + t * (cz - az)))
    return out


def of_leaves(glarepp, folder):
    ways = {"scene": [], "depth": []}
    sums = {"32": [], "64": []}
    for seed in range(10):
        truth = leaves(folder, seed)

        def found(*words):
            report = json.loads(lights(glarepp, folder, "--scene", "s.gltf", *words, "f.exr"))
            return {k["name"]: k for k in report["lights"]}
        for how, off in ways.items():
            got = found("--sun-share", how)
            for name, share in list(truth.items())[:None if how == "scene" else 6]:
                low, high = got[name]["interval"]
                off.append((abs(got[name]["visibility"] - share), max(low - share, share - high)))
        for side, off in sums.items():
            small = found("--sun-share", "depth", "--sun-method", "mask", "--sun-sum", "8bit",
                          "--sun-map", side)
            off += [abs(small[k]["visibility"] - got[k]["visibility"]) for k in list(truth)[:6]]
    for how, bar, miss in (("scene", 8e-4, 5e-4), ("depth", 0.07, 0.005)):
        yield (f"leaves, {len(ways[how])} lights by --sun-share {how}: worst share",
               max(off for off, _ in ways[how]), bar)
        yield (f"  intervals that miss the truth by over {miss:g}",
               sum(by > miss for _, by in ways[how]), 0)
    for side, bar in (("32", 0.02), ("64", 0.02)):
        yield (f"leaves, a sun map of {side}, summed in 8 bits: worst share from the exact one",
               max(sums[side]), bar)


# -- deep frames -----------------------------------------------------------------------


def of_deep(glarepp, folder):
    deep = os.path.join(CLI, "deep.py")
    for what, bar, makes in (("leaves and smoke", 0.003, [("make", ".")]),
                             ("hair", 0.003, [("hair", ".", str(n)) for n in range(6)])):
        worst, small, missed, apart = 0.0, 0.0, 0, [0.0]
        for words in makes:
            subprocess.run([sys.executable, deep, *words], check=True, cwd=folder)
            lights(glarepp, folder, "--lights", "lights.json", "deep.exr")
            p = subprocess.run([sys.executable, deep, "check", "truth.json", "r.json", "1"],
                               check=True, cwd=folder, capture_output=True, text=True)
            off = re.search(r"worst ([.\d]+) of discs.*, ([.\d]+) of small", p.stderr)
            worst, small = max(worst, float(off[1])), max(small, float(off[2]))
            count, held = map(int, p.stdout.split()[:2])
            missed += count - held
            if what == "hair":
                with open(folder + "/truth.json") as t, open(folder + "/mirror.json") as m:
                    truth, mirror = json.load(t), json.load(m)
                apart += [abs(truth[k] - mirror[k]) / 2 for k in truth]
        note = f", any reader's {max(apart):.4f}" if what == "hair" else ""
        yield f"deep frames of {what}, discs of 6 pixels and more: worst share{note}", worst, bar
        if what != "hair":  # which has no smaller ones
            yield "  smaller discs: worst share", small, bar
        yield "  intervals that miss the truth", missed, 0


def bars(glarepp):
    with tempfile.TemporaryDirectory() as folder:
        if os.path.exists(f"{DATA}/scenes/forest.camera.json"):
            yield from of_data(glarepp, folder)
        else:
            print("no data folder: its frames are left out")
        yield from of_leaves(glarepp, folder)
        yield from of_deep(glarepp, folder)
