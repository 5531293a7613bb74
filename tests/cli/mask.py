# SPDX-License-Identifier: Apache-2.0
"""Questions of mask.t about files, for ask.py: frames of known coverage, and what
must come out, computed here in plain Python from the papers and the files.

  make FILE [key=value...]      a frame with Cryptomatte, keys as in MAKES below
  white FILE OF                 the Cryptomatte of another file, with white colour
  kernel FILE                   a kernel whose samples sum up to 1
  sensors OUT FRAME MASK...     OUT is FRAME's colour times the mask
  layer OUT FRAME MASK...       OUT is that spread by k.exr
  adds_up WHOLE A B             A and B add up to WHOLE, 1e-6 in rel_l2
  lit OUT BASE LAYER            OUT is BASE plus LAYER

MASK: [FILE.exr] [not] channel NAME; truth X Y W H NAME..., of what make() put into
that window; crypto NAME..., by the file's ids; all. Limits are 1e-6.
"""
import json
import math
import os
import struct
import sys
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(sys.argv[1])))
import exr

LIMIT = 1e-6
NAMES = ["lamp", "lamp_b", "wall", "name, with, comma", "равнина", "a*b", "aXb",
         "/obj/box:polygons:1", "lamp[0]",
         "lamp392", "lamp7",  # the exponents of their hashes are 0 and 255
         "gone"]
MATERIALS = ["brass", "lamp"]  # "lamp" is an object too, of other pixels


# -- Cryptomatte, by its specification ----------------------------------------------

def murmur(data):
    rotate = lambda v, n: (v << n | v >> (32 - n)) & 0xffffffff
    h, whole = 0, len(data) // 4 * 4
    for k in struct.unpack("<%dI" % (whole // 4), data[:whole]):
        h ^= rotate(k * 0xcc9e2d51 & 0xffffffff, 15) * 0x1b873593 & 0xffffffff
        h = (rotate(h, 13) * 5 + 0xe6546b64) & 0xffffffff
    if data[whole:]:
        k = int.from_bytes(data[whole:], "little")
        h ^= rotate(k * 0xcc9e2d51 & 0xffffffff, 15) * 0x1b873593 & 0xffffffff
    h ^= len(data)
    h = (h ^ h >> 16) * 0x85ebca6b & 0xffffffff
    h = (h ^ h >> 13) * 0xc2b2ae35 & 0xffffffff
    return h ^ h >> 16


def crypto_id(name):
    h = murmur(name.encode())
    return h ^ 1 << 23 if h >> 23 & 255 in (0, 255) else h


def as_float(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def as_bits(value):
    return struct.unpack("<I", struct.pack("<f", value))[0]


def single(v):
    return struct.unpack("<f", struct.pack("<f", v))[0]


def objects(names, x, y):
    """The objects of a pixel and their coverage, largest first; deterministic."""
    n = (3 * x + 5 * y) % 4  # 0 to 3 objects
    some = [names[(x // 5 + 2 * (y // 4) + 3 * i) % (len(names) - (len(names) > 2))]
            for i in range(n)]
    part = [single(c) for c in ([], [0.75], [0.5, 0.3], [0.4, 0.35, 0.25])[n]]
    return list(zip(some, part))


# -- files --------------------------------------------------------------------------

class Image:
    """Channels of a part, rows from the top: v[name][y * w + x]."""

    def __init__(self, path):
        with open(path, "rb") as f:
            b = f.read()
        flags = struct.unpack_from("<I", b, 4)[0]
        assert not flags & 0x1800, "one flat part"
        self.attr, at = {}, 8
        while b[at]:
            name, kind = b[at:].split(b"\0", 2)[:2]
            at += len(name) + len(kind) + 2
            size = struct.unpack_from("<i", b, at)[0]
            self.attr[name.decode()] = b[at + 4:at + 4 + size]
            at += 4 + size
        self.x, self.y, x1, y1 = struct.unpack("<4i", self.attr["dataWindow"])
        self.w, self.h = x1 - self.x + 1, y1 - self.y + 1
        self.channels, chlist = [], self.attr["channels"]
        while chlist[0]:
            name, chlist = chlist.split(b"\0", 1)
            self.channels.append((name.decode(), struct.unpack_from("<i", chlist)[0]))
            chlist = chlist[16:]
        self.v = {name: [0.0] * (self.w * self.h) for name, _ in self.channels}
        tile, packed = self.attr.get("tiles"), self.attr["compression"][0]
        tw, th = struct.unpack_from("<II", tile) if tile else (
            self.w, {0: 1, 2: 1, 3: 16}[packed])
        n = -(-self.w // tw) * -(-self.h // th)
        for i in range(n):
            at_chunk = struct.unpack_from("<Q", b, at + 1 + 8 * i)[0]
            self.chunk(b, at_chunk, bool(tile), tw, th, packed)

    def chunk(self, b, at, tiled, tw, th, packed):
        head = struct.unpack_from("<5i" if tiled else "<2i", b, at)
        x0, y0 = (head[0] * tw, head[1] * th) if tiled else (0, head[0] - self.y)
        w, h = min(tw, self.w - x0), min(th, self.h - y0)
        at += 20 if tiled else 8
        data = b[at:at + head[-1]]
        size = w * h * sum(2 if kind == 1 else 4 for _, kind in self.channels)
        if packed and len(data) < size:
            raw = bytearray(zlib.decompress(data))
            for i in range(1, size):
                raw[i] = (raw[i - 1] + raw[i] - 128) & 255
            data = bytearray(size)
            data[0::2], data[1::2] = raw[:(size + 1) // 2], raw[(size + 1) // 2:]
        at = 0
        for y in range(y0, y0 + h):
            for name, kind in self.channels:
                row = struct.unpack_from("<%d%s" % (w, "Ief"[kind]), data, at)
                at += w * (2 if kind == 1 else 4)
                self.v[name][y * self.w + x0:y * self.w + x0 + w] = row

    def at(self, name, x, y):
        """A sample by its place in EXR pixel space."""
        x, y = x - self.x, y - self.y
        inside = 0 <= x < self.w and 0 <= y < self.h
        return self.v[name][y * self.w + x] if inside else 0.0


class Given(exr.Part):
    """A part whose samples are given by channel: f(x, y) from its corner."""

    def __init__(self, o, planes, name=None):
        super().__init__(o, [(n, kind) for n, (kind, _) in planes.items()], name)
        self.planes = planes

    def chunks(self):
        for y in range(self.h):
            row = b""
            for name, kind in self.channels:
                v = [self.planes[name][1](x, y) for x in range(self.w)]
                row += struct.pack("<%d%s" % (self.w, exr.TYPES[kind][1]), *v)
            yield struct.pack("<ii", self.y + y, len(row)) + row


MAKES = {
    "size": "40x30", "origin": "0,0", "display": "",
    "spelling": "R,G,B,A",  # of crypto's channels
    "manifest": "header",   # header, FILE.json, none
    "parts": "",            # 1: each layer is a part
    "ids": "float",         # type of crypto's channels
    "drop": "",             # a channel that is left out
    "hash": "MurmurHash3_32", "conversion": "uint32_to_float32",
    "matte": "",            # only a matte: channels with these names
    "bright": "1",          # times the colour
    "group": "",            # a layer of half the colour
}


def crypto_planes(kind, names, o):
    spelling = o["spelling"].split(",")
    planes = {}
    for layer in range(2):
        for i, own in enumerate(spelling):
            def value(x, y, k=2 * layer + i // 2, id_=i % 2 == 0):
                some = objects(names, x, y)
                if k >= len(some):
                    return 0.0
                v = as_float(crypto_id(some[k][0])) if id_ else some[k][1]
                return max(-6e4, min(v, 6e4)) if o["ids"] == "half" else v
            planes["%s%02d.%s" % (kind, layer, own)] = (o["ids"], value)
    return planes


def make(path, *words):
    o = dict(MAKES, **dict(w.split("=", 1) for w in words))
    part = {"size": o["size"], "origin": o["origin"], "display": o["display"],
            "pad": "", "deep": "0", "zips": "", "more": "", "aspect": "1", "attr": []}
    bright = float(o["bright"])
    colour = lambda x, y, k, times: single(
        times * (0.1 + 0.07 * k + (x * 7 + y * 13) % 11 * 0.2))
    planes = {c: ("float", lambda x, y, k=k: colour(x, y, k, bright))
              for k, c in enumerate("RGB")}
    for k, c in enumerate("RGB" if o["group"] else ""):
        planes["%s.%s" % (o["group"], c)] = (
            "float", lambda x, y, k=k: colour(x, y, k, bright / 2))
    matte = lambda x, y: single((x * 5 + y * 3) % 9 / 8 * 1.25 - 0.125)
    planes["key.matte"] = ("float", matte)
    if o["matte"]:
        planes = {c: ("float", matte) for c in o["matte"].split(",")}
        exr.write(path, [Given(part, planes)])
        return
    cryptos = {}
    for key, kind, names in ("d593dd7", "View.CryptoObject", NAMES), \
                            ("be93ba3", "CryptoMaterial", MATERIALS):
        start = "cryptomatte/%s/" % key
        text = json.dumps({n: "%08x" % crypto_id(n) for n in names}, ensure_ascii=False)
        for field, value in ("name", kind), ("hash", o["hash"]), \
                            ("conversion", o["conversion"]):
            part["attr"].append("%s%s:string:%s" % (start, field, value))
        if o["manifest"] == "header":
            part["attr"].append("%smanifest:string:%s" % (start, text))
        elif o["manifest"] != "none":
            beside = "%s.%s" % (kind, o["manifest"])
            part["attr"].append("%smanif_file:string:%s" % (start, beside))
            if "/" not in beside:
                with open(os.path.join(os.path.dirname(path), beside), "w") as f:
                    f.write(text)
        cryptos.update(crypto_planes(kind, names, o))
    cryptos.pop(o["drop"], None)
    if not o["parts"]:
        exr.write(path, [Given(part, dict(planes, **cryptos))])
        return
    # a part for each layer, whose channels have no layer themselves
    parts = [Given(part, planes)]
    for layer in sorted({n.rpartition(".")[0] for n in cryptos}):
        own = {n.rpartition(".")[2]: v for n, v in cryptos.items()
               if n.startswith(layer + ".")}
        parts.append(Given(part, own, layer))
    exr.write(path, parts)


def kernel(path):
    w = 9
    shape = lambda x, y: 1 / (1 + (x - 4) ** 2 + 0.5 * (y - 4) ** 2)
    total = sum(shape(x, y) for x in range(w) for y in range(w))
    part = {"size": "9x9", "origin": "0,0", "display": "", "pad": "", "deep": "0",
            "zips": "", "more": "", "aspect": "1", "attr": []}
    exr.write(path, [Given(part, {c: ("float", lambda x, y: shape(x, y) / total)
                                  for c in "RGB"})])


def white(path, of):
    """The Cryptomatte of a file of one part, with white colour."""
    f = Image(of)
    part = {"size": "%dx%d" % (f.w, f.h), "origin": "%d,%d" % (f.x, f.y),
            "display": "", "pad": "", "deep": "0", "zips": "", "more": "",
            "aspect": "1", "attr": []}
    for name, value in f.attr.items():
        if name.startswith("cryptomatte/"):
            part["attr"].append("%s:string:%s" % (name, value.decode()))
    planes = {n: ("float", lambda x, y, n=n: f.v[n][y * f.w + x])
              for n, kind in f.channels if "." in n}
    planes.update({c: ("float", lambda x, y: 2.0) for c in "RGB"})
    exr.write(path, [Given(part, planes)])


# -- what must come out ---------------------------------------------------------------

def mask_of(words, frame):
    """Function (x, y) -> share, in EXR pixel space."""
    words = list(words)
    inverse = words[0] == "not"
    kind, names = words[inverse], words[inverse + 1:]
    f = Image(frame) if frame and kind != "truth" else None
    if kind == "truth":  # what make() put there
        x0, y0 = int(names.pop(0)), int(names.pop(0))
        w, h = int(names.pop(0)), int(names.pop(0))

        def share(x, y):
            x, y = x - x0, y - y0
            if not (0 <= x < w and 0 <= y < h):
                return 0.0
            return max(min(1.0, sum(c for n, c in objects(all_, x, y) if n in names))
                       for all_ in (NAMES, MATERIALS))
    elif kind == "channel":
        share = lambda x, y: min(max(f.at(names[0], x, y), 0.0), 1.0)
    elif kind == "crypto":
        ids = {crypto_id(n) for n in names}
        types = [v.decode() for n, v in f.attr.items()
                 if n.startswith("cryptomatte/") and n.endswith("/name")]
        own = lambda *all_: next(n for n, _ in f.channels if n in all_)
        pairs = {t: [(own(t + "%02d.%s" % (k, a), t + "%02d.%s" % (k, b)),
                      own(t + "%02d.%s" % (k, c), t + "%02d.%s" % (k, d)))
                     for k in range(3)
                     for a, b, c, d in (("R", "red", "G", "green"),
                                        ("B", "blue", "A", "alpha"))]
                 for t in types}
        share = lambda x, y: max(min(1.0, sum(
            f.at(c, x, y) for i, c in pairs[t] if as_bits(f.at(i, x, y)) in ids))
            for t in types)
    else:
        share = lambda x, y: 1.0
    return (lambda x, y: 1.0 - share(x, y)) if inverse else share


def light_of(frame, words):
    """(x, y) -> three floats: the colour over 0 times the mask, and the window."""
    f = Image(frame)
    share = mask_of(words[1:] if words[0].endswith(".exr") else words,
                    words[0] if words[0].endswith(".exr") else frame)
    return f, lambda x, y: [max(f.at(c, x, y), 0.0) * share(x, y) for c in "RGB"]


def near(got, wanted):
    norm = math.sqrt(sum(v * v for v in wanted))
    error = math.sqrt(sum((a - b) ** 2 for a, b in zip(got, wanted)))
    worst = max(abs(a - b) for a, b in zip(got, wanted))
    assert norm > 0.5, "too dark to tell: %g" % norm
    assert error <= LIMIT * norm and worst <= LIMIT * max(wanted), (error / norm, worst)


def sensors(out, frame, *words):
    o = Image(out)
    _, light = light_of(frame, words)
    places = [(x, y) for y in range(o.y, o.y + o.h) for x in range(o.x, o.x + o.w)]
    near([o.at(c, x, y) for x, y in places for c in "RGB"],
         [v for x, y in places for v in light(x, y)])


def layer(out, frame, *words):
    o, k = Image(out), Image("k.exr")
    f, light = light_of(frame, words)
    spread = {}
    for y in range(f.y, f.y + f.h):
        for x in range(f.x, f.x + f.w):
            own = light(x, y)
            for j in range(-4, 5):
                for i in range(-4, 5):
                    part = k.at("R", i + 4, j + 4)
                    to = spread.setdefault((x + i, y + j), [0.0] * 3)
                    for c in range(3):
                        to[c] += own[c] * part
    places = [(x, y) for y in range(o.y, o.y + o.h) for x in range(o.x, o.x + o.w)]
    near([o.at(c, x, y) for x, y in places for c in "RGB"],
         [v for p in places for v in spread.get(p, [0.0] * 3)])


def adds_up(whole, a, b):
    w, p, q = Image(whole), Image(a), Image(b)
    near([u + v for c in "RGB" for u, v in zip(p.v[c], q.v[c])],
         [v for c in "RGB" for v in w.v[c]])


def lit(out, base, added):
    o, f, g = Image(out), Image(base), Image(added)
    near([v for c in "RGB" for v in o.v[c]],
         [u + v for c in "RGB" for u, v in zip(f.v[c], g.v[c])])
