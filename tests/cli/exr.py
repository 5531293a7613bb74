#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Makes small EXR files with nothing but Python: no library that is tested.

usage: exr.py FILE [key=value...]

  size=64x48          pixels of the data window
  kind=lights         lights: dim noise and hot pixels; dark: noise alone;
                      kernel: a peak with streaks; zeros; nan: kernel with one;
                      ground-y: black, Z and albedo of a ground 1 below a camera
                      of 90 degrees, N its normal along the axis y
  lights=20 seed=1    number of hot pixels, and which
  dim=0.7             largest value of the noise
  hot=0               value of one more pixel in the middle
  channels=R,G,B      names, with :half, :float or :uint behind (else type)
  type=half           of channels that do not say
  origin=0,0          first pixel of the data window
  display=x0,y0,x1,y1 display window, both ends inside; else the data window
  pad=x0,y0,x1,y1     the data window instead, both ends inside; pixels around
                      the others are black, Z is 1e10 there
  attr=name:string:text  and float, int, rational, envmap, v2f, m44f (numbers with commas),
                      stringvector (words with commas)
  part=NAME:Z:float   one more part, of these channels (with commas)
  deep=1              a deep file without samples; deep=N of less than N a pixel
  channels=BY:half,RY:half,Y:half   chroma holds every other pixel and row
  zips=1 more=X,Y     deep files: compressed; a pixel that has a sample more
Keys attr and part may come more than once.
"""
import math
import os
import random
import re
import struct
import sys
import zlib

TYPES = {"uint": (0, "I"), "half": (1, "e"), "float": (2, "f")}
CHROMA = "BY", "RY"


def pixels(o, w, h):
    """Function (channel, x, y) -> value, the same for any channel list."""
    rng = random.Random(int(o["seed"]))
    kind = o["kind"]
    noise = [rng.random() for _ in range(4099)]
    hot = {}
    if kind == "lights":
        for _ in range(int(o["lights"])):
            at = rng.randrange(w), rng.randrange(h)
            hot[at] = math.exp(rng.uniform(1, 7)), rng.random(), rng.random()
    if float(o["hot"]):
        hot[w // 2, h // 2] = float(o["hot"]), 1.0, 1.0

    def colour(c, x, y):
        if kind == "zeros":
            return hot.get((x, y), (0.0,))[0]
        if kind in ("kernel", "nan"):
            dx, dy = x - w // 2, y - h // 2
            if kind == "nan" and (dx, dy) == (1, 0):
                return math.nan
            streak = 1.0 if dx == 0 or dy == 0 else 0.0
            r2 = (dx * dx + dy * dy) * (1 + 0.1 * c)
            return 1 / (1 + r2) ** 1.25 + 0.02 * streak / (3 + r2)
        v = float(o["dim"]) * (0.03 + 0.97 * noise[(x * 31 + y * 977 + c * 7) % 4099])
        if (x, y) in hot:
            L, g, b = hot[x, y]
            v += L * (1.0, 0.5 + 0.5 * g, 0.5 + 0.5 * b)[c]
        return v

    def ground(name, x, y):
        slope = 2 * (y + 0.5) / h - 1
        if name == "Z":
            return 1 / slope if slope > 0.05 else 1e10
        return {"N." + kind[-1].upper(): 1}.get(name, 0.5 * ("albedo" in name))

    def value(name, x, y):
        if kind.startswith("ground-"):
            return ground(name, x, y)
        if name in CHROMA:
            return colour(0, x, y) % 0.25
        if name in ("R", "G", "B", "Y"):
            name = {"Y": "G"}.get(name, name)
            return colour("RGB".index(name), x, y)
        if name == "A":
            return (x % 5) / 4
        if name == "Z":
            return 1e10 if y < h // 4 else 10 + 0.125 * x + y
        if name == "id":
            return x * 70001 + y
        return x - 0.5 * y

    return value


def attribute(name, kind, data):
    return (name.encode() + b"\0" + kind.encode() + b"\0" +
            struct.pack("<i", len(data)) + data)


def given_attribute(text):
    # a name may have colons too: it ends before a type
    name, kind, value = re.match(
        "(.+?):(string|stringvector|float|int|rational|v2f|m44f|chromaticities|"
        "chlist|deepImageState|envmap|idmanifest|keycode|preview):(.*)", text,
        re.S).groups()
    if kind == "string":
        return attribute(name, kind, value.encode())
    if kind == "stringvector":
        return attribute(name, kind, b"".join(
            struct.pack("<i", len(w)) + w.encode() for w in value.split(",")))
    v = [float(n) for n in value.split(",")]
    if kind == "int":
        return attribute(name, kind, struct.pack("<i", int(v[0])))
    if kind == "envmap":
        return attribute(name, kind, struct.pack("B", int(v[0])))
    if kind == "rational":
        return attribute(name, kind, struct.pack("<iI", int(v[0]), int(v[1])))
    return attribute(name, kind, struct.pack("<%df" % len(v), *v))


def zips(data):
    """As EXR compresses a chunk, or as it is where that does not shrink it."""
    split = data[0::2] + data[1::2]
    packed = zlib.compress(split[:1] + bytes(
        (b - a + 128) & 255 for a, b in zip(split, split[1:])))
    return packed if len(packed) < len(data) else data


class Part:
    def __init__(self, o, channels, name=None):
        self.w, self.h = (int(n) for n in o["size"].split("x"))
        self.x, self.y = (int(n) for n in o["origin"].split(","))
        self.channels = sorted(channels)
        self.name, self.deep, self.o = name, int(o["deep"]), o
        self.own = self.x, self.y, self.w, self.h
        if o["pad"]:
            x0, y0, x1, y1 = (int(n) for n in o["pad"].split(","))
            self.x, self.y, self.w, self.h = x0, y0, x1 - x0 + 1, y1 - y0 + 1

    def header(self, multi):
        data = (self.x, self.y, self.x + self.w - 1, self.y + self.h - 1)
        shown = self.o["display"]
        shown = [int(n) for n in shown.split(",")] if shown else data
        chlist = b"".join(os.fsencode(n) + b"\0" +
                          struct.pack("<iiii", TYPES[t][0], 0, *[2 if n in CHROMA else 1] * 2)
                          for n, t in self.channels) + b"\0"
        h = attribute("channels", "chlist", chlist)
        h += attribute("compression", "compression", bytes([2 if self.o["zips"] else 0]))
        h += attribute("dataWindow", "box2i", struct.pack("<4i", *data))
        h += attribute("displayWindow", "box2i", struct.pack("<4i", *shown))
        h += attribute("lineOrder", "lineOrder", b"\0")
        h += attribute("pixelAspectRatio", "float", struct.pack("<f", float(self.o["aspect"])))
        h += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
        h += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
        if multi or self.deep:
            kind = b"deepscanline" if self.deep else b"scanlineimage"
            h += attribute("name", "string", (self.name or "rgba").encode())
            h += attribute("type", "string", kind)
            h += attribute("chunkCount", "int", struct.pack("<i", self.h))
        if self.deep:
            h += attribute("version", "int", struct.pack("<i", 1))
            h += attribute("maxSamplesPerPixel", "int", struct.pack("<i", 0))
        if not self.name:
            h += b"".join(given_attribute(a) for a in self.o["attr"])
        return h + b"\0"

    def deep_chunk(self, value, y):
        more = [int(n) for n in (self.o["more"] or "-1,-1").split(",")]
        count = [(7 * x + 3 * y) % self.deep + ([x, y] == more) for x in range(self.w)]
        table = struct.pack("<%di" % self.w, *(sum(count[:x + 1]) for x in range(self.w)))
        row = b""
        for name, kind in self.channels:
            v = [value(name, x, y) + s for x in range(self.w) for s in range(count[x])]
            row += struct.pack("<%d%s" % (len(v), TYPES[kind][1]), *v)
        size = len(row)
        if self.o["zips"]:
            table, row = zips(table), zips(row)
        return struct.pack("<iQQQ", self.y + y, len(table), len(row), size) + table + row

    def chunks(self):
        x0, y0, w, h = self.own
        inside = pixels(self.o, w, h)

        def value(name, x, y):
            x, y = x + self.x - x0, y + self.y - y0
            return (inside(name, x, y) if 0 <= x < w and 0 <= y < h
                    else 1e10 if name == "Z" else 0)

        for y in range(self.h):
            if self.deep:
                yield self.deep_chunk(value, y)
                continue
            row = b""
            for name, kind in self.channels:
                skip = 2 if name in CHROMA else 1
                if (self.y + y) % skip:
                    continue
                v = [value(name, x, y) for x in range(0, self.w, skip)]
                if kind == "uint":
                    v = [int(abs(n)) for n in v]
                if kind == "half":
                    v = [min(n, 65504.0) if n == n else n for n in v]
                row += struct.pack("<%d%s" % (len(v), TYPES[kind][1]), *v)
            yield struct.pack("<ii", self.y + y, len(row)) + row


def write(path, parts):
    multi = len(parts) > 1
    version = 2 | (0x1000 if multi else 0) | (0x800 if parts[0].deep else 0)
    head = struct.pack("<ii", 20000630, version)
    head += b"".join(p.header(multi) for p in parts) + (b"\0" if multi else b"")
    at = len(head) + sum(8 * p.h for p in parts)
    table, body = [], []
    for i, p in enumerate(parts):
        for chunk in p.chunks():
            chunk = (struct.pack("<i", i) if multi else b"") + chunk
            table.append(struct.pack("<Q", at))
            body.append(chunk)
            at += len(chunk)
    with open(path, "wb") as f:
        f.write(head + b"".join(table) + b"".join(body))


def main():
    o = {"size": "64x48", "kind": "lights", "lights": "20", "seed": "1", "dim": "0.7",
         "hot": "0", "channels": "R,G,B", "type": "half", "origin": "0,0",
         "display": "", "pad": "", "deep": "0", "zips": "", "more": "",
         "aspect": "1", "attr": [], "part": []}
    for word in sys.argv[2:]:
        key, value = word.split("=", 1)
        if isinstance(o[key], list):
            o[key].append(value)
        else:
            o[key] = value
    names = [(c.split(":") + [o["type"]])[:2] for c in o["channels"].split(",")]
    parts = [Part(o, [tuple(n) for n in names])]
    for text in o["part"]:
        name, channel, kind = text.split(":")
        parts.append(Part(o, [(c, kind) for c in channel.split(",")], name))
    write(sys.argv[1], parts)


if __name__ == "__main__":
    main()
