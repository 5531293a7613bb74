#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Deep frames of leaves and smoke, or of hair, and the shares of lights in them.

    deep.py make FOLDER       deep.exr, other.exr (its samples in another order), tiles.exr
                              and zips.exr (in tiles), lights.json, truth.json
    deep.py hair FOLDER SEED  deep.exr, lights.json, truth.json, mirror.json
    deep.py check TRUTH.json REPORT.json LIMIT

A pixel's samples are what a renderer writes: the coverage of each leaf, nearest first, by
16 x 16 rays; of smoke its alpha between front and back. The truth is of a second camera,
which looks at one light only: 256 x 256 rays to its disc, through the same leaves
and smoke. Hair is bits, 16 x 16 a pixel, of which samples and truth are counts. With what
is in each pixel mirrored the samples are the same, and the truth is mirror.json: in one of
the two any reader is off by half of what they differ by."""
import json
import math
import random
import struct
import sys
import zlib

W, H, RAYS, LOOKS = 96, 64, 16, 256


def scene(rng):
    """Leaves (z, x, y, half axes, cos, sin), smoke (z, back, x, y, radius, density)."""
    leaves = []
    for _ in range(90):
        turn = rng.uniform(0, math.pi)
        leaves.append((rng.uniform(4, 40), rng.uniform(-4, 52), rng.uniform(-4, 68),
                       rng.uniform(2, 7), rng.uniform(1, 2.5), math.cos(turn),
                       math.sin(turn)))
    smoke = []
    for _ in range(12):
        z, thick = rng.uniform(3, 30), rng.uniform(1, 12)
        smoke.append((z, z + thick, rng.uniform(50, 96), rng.uniform(0, 64),
                      rng.uniform(9, 22), rng.uniform(0.01, 0.12)))
    return sorted(leaves), smoke


def in_leaf(leaf, x, y):
    _, cx, cy, a, b, c, s = leaf
    u, v = (x - cx) * c + (y - cy) * s, (y - cy) * c - (x - cx) * s
    return (u / a) ** 2 + (v / b) ** 2 < 1


def path(puff, x, y):
    """Optical depth of a puff: densest in its middle, even along the view."""
    z, back, cx, cy, r, density = puff
    q = 1 - ((x - cx) ** 2 + (y - cy) ** 2) / (r * r)
    return density * (back - z) * q if q > 0 else 0.0


def clear(leaves, smoke, depth, x, y):
    """Share of light from `depth` along a ray."""
    if any(leaf[0] < depth and in_leaf(leaf, x, y) for leaf in leaves):
        return 0.0
    t = 0.0
    for puff in smoke:
        part = (min(depth, puff[1]) - puff[0]) / (puff[1] - puff[0])
        t += max(part, 0.0) * path(puff, x, y)
    return math.exp(-t)


def samples(leaves, smoke, x, y):
    """Samples (z, back, alpha) of a pixel."""
    at = [(x + (i + 0.5) / RAYS, y + (j + 0.5) / RAYS)
          for i in range(RAYS) for j in range(RAYS)]
    out, open_rays = [], at
    for leaf in leaves:
        left = [p for p in open_rays if not in_leaf(leaf, *p)]
        if len(left) < len(open_rays):
            out.append((leaf[0], leaf[0], 1 - len(left) / len(open_rays)))
        open_rays = left
        if not left:
            break
    for puff in smoke:
        mean = sum(math.exp(-path(puff, *p)) for p in at) / len(at)
        if mean < 1:
            out.append((puff[0], puff[1], 1 - mean))
    return out


def near(things, x, y, r):
    """The leaves or puffs that may be within r of a point."""
    def reach(t):
        return t[3] if len(t) == 7 else t[4]

    def at(t):
        return t[1:3] if len(t) == 7 else t[2:4]
    return [t for t in things if math.dist(at(t), (x, y)) < reach(t) + r]


def attribute(name, kind, data):
    return (name.encode() + b"\0" + kind.encode() + b"\0" +
            struct.pack("<i", len(data)) + data)


def packed(counts):
    """A count table as OpenEXR compresses it (ZIPS)."""
    split = counts[0::2] + counts[1::2]
    return zlib.compress(split[:1] + bytes((b - a + 128) & 255
                                           for a, b in zip(split, split[1:])))


def write(path, pixels, order, tile=None, zips=False):
    """A deep EXR of scanlines, or of tiles as OpenEXR writes them: a count table that is
    stored has the bytes of a whole tile. pixels[y][x] is a list of samples."""
    names = ["A", "B", "G", "R", "Z", "ZBack"]
    box = struct.pack("<4i", 0, 0, W - 1, H - 1)
    channels = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1)
                        for n in names) + b"\0"
    w, h = tile or (W, 1)
    blocks = [(x, y) for y in range(0, H, h) for x in range(0, W, w)]
    head = struct.pack("<ii", 20000630, 2 | 0x800)
    for a in (("channels", "chlist", channels),
              ("compression", "compression", b"\2" if zips else b"\0"),
              ("dataWindow", "box2i", box), ("displayWindow", "box2i", box),
              ("lineOrder", "lineOrder", b"\0"),
              ("pixelAspectRatio", "float", struct.pack("<f", 1)),
              ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
              ("screenWindowWidth", "float", struct.pack("<f", 1)),
              ("tiles", "tiledesc", struct.pack("<iib", w, h, 0)),
              ("type", "string", b"deeptile" if tile else b"deepscanline"),
              ("version", "int", struct.pack("<i", 1)),
              ("chunkCount", "int", struct.pack("<i", len(blocks)))):
        if tile or a[0] != "tiles":
            head += attribute(*a)
    head += b"\0"
    body, table, at = b"", b"", len(head) + 8 * len(blocks)
    for x, y in blocks:
        counts, data = b"", b""
        for row in pixels[y:y + h]:
            row, n = [order(s) for s in row[x:x + w]], 0
            for s in row:
                n += len(s)
                counts += struct.pack("<i", n)
            for name in names:
                for s in row:
                    for z, back, a in s:
                        v = {"A": a, "Z": z, "ZBack": back, "R": 0.5 * a, "G": z / 40 * a,
                             "B": (z + back) / 80 * a}[name]
                        data += struct.pack("<f", v)
        counts = packed(counts) if zips else counts.ljust(4 * w * h, b"\xff")
        lead = struct.pack("<4i", x // w, y // h, 0, 0) if tile else struct.pack("<i", y)
        chunk = lead + struct.pack("<QQQ", len(counts), len(data), len(data)) + counts + data
        table += struct.pack("<Q", at)
        at += len(chunk)
        body += chunk
    with open(path, "wb") as f:
        f.write(head + table + body)


def make(folder):
    rng = random.Random(39)
    leaves, smoke = scene(rng)
    pixels = []
    for y in range(H):
        pixels.append([samples(near(leaves, x + 0.5, y + 0.5, 0.8),
                               near(smoke, x + 0.5, y + 0.5, 0.8), x, y)
                       for x in range(W)])
    write(folder + "/deep.exr", pixels, lambda s: s)
    write(folder + "/other.exr", pixels, lambda s: s[::-1])
    write(folder + "/tiles.exr", pixels, lambda s: s, (19, 21))
    write(folder + "/zips.exr", pixels, lambda s: s, (19, 21), True)
    lights, truth = [], {}
    for k, (x, y, r, depth) in enumerate(
            [(24.3, 30.1, 15, None), (24.3, 30.1, 15, 20), (22, 33.7, 20, 12),
             (30.5, 26, 12, None), (72.4, 31.2, 12, None), (70, 30, 15, 15),
             (75.2, 36.6, 6, 9.5), (80, 20, 2.5, 25), (48, 32, 25, None),
             (20, 32, 2.5, None)]):
        name = "l%d" % k
        lights.append({"name": name, "pixel": [x, y], "radius": r, "bias": 0,
                       **({"depth": depth} if depth else {})})
        own, puffs, total = near(leaves, x, y, r), near(smoke, x, y, r), 0.0
        looks = LOOKS if r > 5 else 2 * LOOKS
        n = 0
        for i in range(0, looks):
            for j in range(0, looks):
                u, v = (i + 0.5) / looks * 2 - 1, (j + 0.5) / looks * 2 - 1
                if u * u + v * v < 1:
                    n += 1
                    total += clear(own, puffs, depth or math.inf, x + u * r, y + v * r)
        truth[name] = total / n
    json.dump(lights, open(folder + "/lights.json", "w"))
    json.dump(truth, open(folder + "/truth.json", "w"))


def hair(folder, seed):
    """120 straight hairs, 0.1 to 0.8 pixels wide, and discs of 6 to 8 pixels among them."""
    n, rng, lights, truth, mirror = 16, random.Random(seed), [], {}, {}
    clear = [(1 << W * n) - 1] * (H * n)  # rows of bits that no hair covers yet
    left = [[n * n] * W for _ in range(H)]  # of these in each pixel
    pixels = [[[] for _ in range(W)] for _ in range(H)]

    def bits(row, a, b):
        return clear[row] & ((1 << b) - (1 << a)) if b > a else 0

    def look(depth):
        r = rng.choice((6, 6, 7, 8))
        x, y = rng.uniform(r + 1, W - r - 1), rng.uniform(r + 1, H - r - 1)
        seen = turned = total = 0
        for row in range(round((y - r) * n), round((y + r) * n)):
            half = math.sqrt(max(r * r - ((row + 0.5) / n - y) ** 2, 0))
            a, b = round((x - half) * n), round((x + half) * n)
            seen += bin(bits(row, a, b)).count("1")
            text = f"{clear[row]:0{W * n}b}"[::-1]  # bit 0 first
            text = "".join(text[k:k + n][::-1] for k in range(0, W * n, n))
            turned += text.count("1", a, b)
            total += b - a
        name = "h%d" % len(lights)
        lights.append({"name": name, "pixel": [x, y], "radius": r, "bias": 0,
                       **({"depth": depth} if depth else {})})
        truth[name], mirror[name] = seen / total, turned / total

    depths = sorted(rng.uniform(3, 40) for _ in range(24))
    for z in sorted(rng.uniform(3, 40) for _ in range(120)):
        while depths and depths[0] < z:
            look(depths.pop(0))
        x, y, w = rng.uniform(0, W), rng.uniform(0, H), rng.uniform(0.05, 0.4)
        turn, gone = rng.uniform(0, math.pi), {}
        for row in range(H * n):
            mid = x + ((row + 0.5) / n - y) / math.tan(turn)
            a, b = (min(max(round((mid + k * w / math.sin(turn)) * n), 0), W * n) for k in (-1, 1))
            cut = bits(row, a, b)
            clear[row] ^= cut
            for px in range(a // n, -(-b // n) if cut else 0):
                gone[row // n, px] = (gone.get((row // n, px), 0) +
                                      bin(cut >> px * n & (1 << n) - 1).count("1"))
        for (py, px), count in gone.items():
            if count:
                pixels[py][px].append((z, z, count / left[py][px]))
                left[py][px] -= count
    for depth in depths + [None] * 40:
        look(depth)
    write(folder + "/deep.exr", pixels, lambda s: s)
    json.dump(lights, open(folder + "/lights.json", "w"))
    json.dump(truth, open(folder + "/truth.json", "w"))
    json.dump(mirror, open(folder + "/mirror.json", "w"))


def check(truth, report, limit):
    want = json.load(open(truth))
    got = {l["name"]: l for l in json.load(open(report))["lights"]}
    off = {k: abs(got[k]["visibility"] - want[k]) for k in want}
    held = sum(got[k]["interval"][0] - 1e-4 <= want[k] <= got[k]["interval"][1] + 1e-4
               for k in want)
    large = [off[k] for k in want if got[k]["radius"] >= 6]
    print(len(want), held, max(large) <= limit)
    print("mean %.4f, worst %.4f of discs of 6 pixels and more, %.4f of small ones" % (
        sum(large) / len(large), max(large), max(off.values())), file=sys.stderr)
    if "-v" in sys.argv:
        for k in want:
            print(k, got[k]["radius"], want[k], got[k]["visibility"], got[k]["interval"])


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(sys.argv[2])
    elif sys.argv[1] == "hair":
        hair(sys.argv[2], int(sys.argv[3]))
    else:
        check(sys.argv[2], sys.argv[3], float(sys.argv[4]))
