#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Frames of lamps, and lights that were found in them against the truth.

Usage: spots.py make        writes l.1001.pfm to l.1005.pfm and truth.json here:
                            twelve even discs of radius 1.2 to 6 on a noisy
                            ground, which move by 3 pixels a frame
       spots.py tracks      writes t.1.pfm to t.12.pfm and truth.json here: a warm
                            and a blue lamp, and two equal ones, that pass each other
                            over more than a quarter of the height, and a brighter one
                            from frame 5 on
       spots.py check REPORT   prints, over all frames of a report, whether there
                            is one light for each lamp, of its size, and the names stay, then
                            the largest errors: pixels, share of flux
       spots.py data REPORT CAMERA   the same of lamps of a rendered frame, by its
                            camera file
       spots.py follow REPORT   prints the names of the lamps of `tracks`
       spots.py night REPORT CAMERA   ... of balls of one radius, which the camera
                            file does not have: it is found from all, then each
                            one's brightest channel is compared
       spots.py sum PARTS LAYER      the norm of LAYER less the sum of PARTS, two
                            EXR files of floats, over that of LAYER
"""
import json
import math
import random
import statistics
import struct
import sys

W, H, LAMPS, FRAMES, SUB = 640, 360, 12, 5, 6


def lamps(frame):
    rng = random.Random(5)
    for i in range(LAMPS):
        r = 1.2 + 4.8 * i / (LAMPS - 1)
        x = 60 + i % 4 * 50 + rng.uniform(0, 15) + 3 * frame
        y = 50 + i // 4 * 120 + rng.uniform(0, 30) + 1.3 * frame
        level = rng.uniform(20, 300)
        yield x, y, r, [level * c for c in (1.0, 0.8, 0.5)]


def coverage(x, y, r, px, py):
    inside = 0
    for j in range(SUB):
        for i in range(SUB):
            inside += math.hypot(px + (i + 0.5) / SUB - x,
                                 py + (j + 0.5) / SUB - y) <= r
    return inside / SUB ** 2


def make():
    truth = []
    for frame in range(FRAMES):
        rng = random.Random(frame)
        image = [max(0.0, rng.gauss(0.2, 0.05)) for _ in range(3 * W * H)]
        own = []
        for x, y, r, colour in lamps(frame):
            area = 0.0
            for py in range(int(y - r) - 1, int(y + r) + 2):
                for px in range(int(x - r) - 1, int(x + r) + 2):
                    share = coverage(x, y, r, px, py)
                    area += share
                    for c in range(3):
                        image[3 * ((H - 1 - py) * W + px) + c] += share * colour[c]
            own.append([x, y, [area * c for c in colour], r])
        truth.append(own)
        with open(f"l.{1001 + frame}.pfm", "wb") as f:
            f.write(b"PF\n%d %d\n-1.0\n" % (W, H))
            f.write(struct.pack("<%df" % len(image), *image))
    with open("truth.json", "w", encoding="utf-8") as f:
        json.dump(truth, f)


def disc(image, w, h, x, y, r, colour):
    for py in range(int(y - r) - 1, int(y + r) + 2):
        for px in range(int(x - r) - 1, int(x + r) + 2):
            if 0 <= px < w and 0 <= py < h:
                share = coverage(x, y, r, px, py)
                for c in range(3):
                    image[3 * ((h - 1 - py) * w + px) + c] += share * colour[c]


def tracks():
    w, h, truth = 240, 120, []
    for i in range(12):
        own = [[30 + 15 * i, 52, [60, 30, 9]], [210 - 15 * i, 66, [9, 30, 60]],
               [20 + 18 * i, 96, [30, 30, 30]], [220 - 18 * i, 108, [30, 30, 30]]]
        if i >= 4:
            own.append([120 + 4 * i, 20, [200, 200, 200]])
        image = [0.1] * (3 * w * h)
        for x, y, colour in own:
            disc(image, w, h, x, y, 2.5, colour)
        with open(f"t.{i + 1}.pfm", "wb") as f:
            f.write(b"PF\n%d %d\n-1.0\n" % (w, h))
            f.write(struct.pack("<%df" % len(image), *image))
        truth.append(own)
    with open("truth.json", "w", encoding="utf-8") as f:
        json.dump(truth, f)


def follow(rows):
    """Prints names of each lamp of the truth over all frames."""
    names = [set() for _ in range(5)]
    with open("truth.json", encoding="utf-8") as f:
        for row, own in zip(rows, json.load(f)):
            assert len(row["lights"]) == len(own), row["lights"]
            for k, (x, y, _) in enumerate(own):
                names[k].add(nearest(row["lights"], x, y)["name"])
    print(*(" ".join(sorted(n)) for n in names))


def nearest(lights, x, y):
    return min(lights, key=lambda l: math.hypot(l["x"] - x, l["y"] - y))


def compare(rows, truth, only=False):
    names, away, flux, single = [], 0.0, 0.0, True
    for row, own in zip(rows, truth):
        lights = row["lights"]
        found = [nearest(lights, x, y) for x, y, *_ in own]
        single &= len({l["name"] for l in found}) == len(own)
        single &= only or len(lights) == len(own)
        names.append([l["name"] for l in found])
        for l, (x, y, light, *size) in zip(found, own):
            single &= all(abs(l["radius"] - r) <= 0.2 for r in size)
            away = max(away, math.hypot(l["x"] - x, l["y"] - y))
            flux = max(flux, max(abs(l["flux"][c] / light[c] - 1)
                                 for c in range(3) if light[c]))
    print(single and all(n == names[0] for n in names), f"{away:.3f}", f"{flux:.4f}")


def rendered(camera):
    """Lamps in view of a frame that shine in all directions: the balls' flux."""
    with open(camera, encoding="utf-8") as f:
        file = json.load(f)
    lamp = {l["name"]: l for l in file["lamps"]}
    m = file["frames"][2]["worldToNDC_blender_colvec"]
    focal = abs(m[0]) * file["width"] / 2
    for seen in file["frames"][2]["lamps"]:
        own, (x, y, depth) = lamp[seen["name"]], seen["pixel_xy_depth"]
        if (seen["on_screen"] != "on" or seen["visible_share"] < 1 or
                own["type"] != "point"):
            continue
        # solid angle of the ball over that of a pixel at its place
        angle = 2 * math.pi * (1 - math.sqrt(
            1 - (own["ball_radius_m"] / seen["distance_m"]) ** 2))
        area = angle * focal ** 2 * (seen["distance_m"] / depth) ** 3
        yield [x, y, [own["ball_radiance"] * area * c for c in own["color"]]]


def night(lights, camera):
    with open(camera, encoding="utf-8") as f:
        file = json.load(f)
    frame = file["frames"][0]
    seen, sizes = [], []
    for lamp in frame["lamps"]:
        x, y, depth = lamp["pixel_xy_depth"]
        if 0 <= x < file["width"] and 0 <= y < file["height"]:
            light = nearest(lights, x, y)
            away = math.dist(lamp["pos"], (0, 0, 1.7))  # from the camera
            seen.append([x, y, light])
            sizes.append(max(light["flux"]) / lamp["radiance"] * depth ** 3 / away)
    usual = statistics.median(sizes)
    print(len({l["name"] for *_, l in seen}) == len(seen) == len(lights) == 8,
          "%.3f" % max(math.hypot(l["x"] - x, l["y"] - y) for x, y, l in seen),
          "%.4f" % max(abs(s / usual - 1) for s in sizes))


def main():
    if sys.argv[1] == "make":
        make()
        return
    if sys.argv[1] == "tracks":
        tracks()
        return
    if sys.argv[1] == "sum":
        import numpy as np
        import OpenImageIO as oiio
        parts, layer = oiio.ImageBuf(sys.argv[2]), oiio.ImageBuf(sys.argv[3])
        names, own = parts.spec().channelnames, parts.get_pixels(oiio.FLOAT)
        whole = layer.get_pixels(oiio.FLOAT).astype(float)
        total = sum(np.stack([own[:, :, names.index(f"{p}.{c}")] for c in "RGB"],
                             -1).astype(float)
                    for p in ("veil", "core", "flare", "ghosts"))
        print(np.linalg.norm(total - whole) / np.linalg.norm(whole))
        return
    with open(sys.argv[2], encoding="utf-8") as f:
        rows = [json.loads(line) for line in f]
    if sys.argv[1] == "night":
        night(rows[0]["lights"], sys.argv[3])
        return
    if sys.argv[1] == "follow":
        follow(rows)
        return
    if sys.argv[1] == "data":
        compare(rows, [list(rendered(sys.argv[3]))], True)
        return
    with open("truth.json", encoding="utf-8") as f:
        compare(rows, json.load(f))


main()
