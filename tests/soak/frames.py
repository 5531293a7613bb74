# SPDX-License-Identifier: Apache-2.0
"""Random frames and kernels of the soak: what a stranger's EXR may hold.

Everything comes from the random.Random that is passed, so a case can be made
again. Files are written by OpenImageIO, never by the program that is tested.
"""
import numpy as np
import OpenImageIO as oiio

ODD = [float("nan"), float("inf"), float("-inf"), 1e-40, -1e-42, -3.0, 6e-8,
       65504.0, 1e9, 3e38]
COMPRESSIONS = ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a",
                "dwaa"]


def size(rng):
    """Width and height, and whether the frame is large: few sources then."""
    kind = rng.random()
    if kind < 0.06:
        return 1, 1, False
    if kind < 0.14:
        n = rng.randint(2, 300)
        return (1, n, False) if rng.random() < 0.5 else (n, 1, False)
    if kind < 0.94:
        return rng.randint(2, 180), rng.randint(2, 120), False
    return rng.randint(300, 1300), rng.randint(200, 800), True


def windows(rng, w, h):
    """Data window's origin, and display window as x, y, w, h."""
    kind = rng.choice(["same", "negative", "larger", "smaller", "disjoint",
                       "far"])
    x, y = (0, 0) if kind == "same" else (rng.randint(-300, 300),
                                          rng.randint(-300, 300))
    if kind == "far":
        x, y = rng.choice([-1, 1]) * 900000, rng.randint(-9, 9)
    shown = x, y, w, h
    if kind == "larger":
        shown = x - rng.randint(0, 40), y - rng.randint(0, 40), w + 40, h + 40
    elif kind == "smaller":
        shown = x + w // 3, y + h // 4, max(1, w // 2), max(1, h // 2)
    elif kind == "disjoint":
        shown = x + w + 7, y - h - 5, max(1, w // 2), max(1, h)
    return (x, y), shown


def light(rng, w, h, large):
    """Scene-linear colour, h x w x 3, and what it is."""
    n = np.random.default_rng(rng.getrandbits(32))
    kind = rng.choice(["points", "night"] if large else
                      ["points", "night", "windows", "sky", "noise", "zeros",
                       "wide", "odd", "negative"])
    px = n.random((h, w, 3)) * (0.3 if large else rng.choice([0.01, 0.7, 0.9]))

    def spot(value, tall, wide):
        y, x = rng.randrange(h), rng.randrange(w)
        px[y:y + tall, x:x + wide] = value * n.uniform(0.2, 1, 3)

    if kind in ("points", "night", "odd"):
        for _ in range(rng.randint(0, 40)):
            spot(np.exp(rng.uniform(0, 9)), 1, 1)
    if kind == "windows":
        for _ in range(rng.randint(1, 4)):
            spot(rng.uniform(1, 300), rng.randint(1, 30), rng.randint(1, 30))
    if kind == "sky":
        px[:max(1, h // 2)] += np.linspace(1.5, 4, w)[:, None]
        spot(6e4, 3, 3)
    if kind == "noise":
        px = np.exp(n.normal(0, 2, (h, w, 3)))
    if kind == "zeros":
        px *= 0
        spot(rng.choice([0, 1, 1e4]), 1, 1)
    if kind == "wide":
        px *= 1e-3
        spot(1e9, 1, 1)
    if kind == "negative":
        px = n.normal(0, rng.choice([0.3, 3]), (h, w, 3))
    if kind == "odd":
        for _ in range(rng.randint(1, 12)):
            px[rng.randrange(h), rng.randrange(w), rng.randrange(3)] = \
                rng.choice(ODD)
    return kind, px


def depth(rng, w, h):
    n = np.random.default_rng(rng.getrandbits(32))
    z = n.uniform(0.5, 100, (h, w))
    z[:h // 2] = rng.choice([1e10, float("inf"), 0, 65504, 30])
    for _ in range(rng.randint(0, 5)):
        z[rng.randrange(h), rng.randrange(w)] = rng.choice(ODD)
    return z


def write(path, names, planes, types, at, shown, compression, tile=0):
    """One EXR of float32 planes, each h x w; `types` oiio names, one each."""
    px = np.ascontiguousarray(np.stack(planes, -1), dtype=np.float32)
    spec = oiio.ImageSpec(px.shape[1], px.shape[0], len(names), oiio.FLOAT)
    spec.channelnames = tuple(names)
    spec.channelformats = tuple(oiio.TypeDesc(t) for t in types)
    spec.x, spec.y = at
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = shown
    spec.tile_width = spec.tile_height = tile
    spec.attribute("compression", compression)
    spec.attribute("oiio:RawColor", 1)
    out = oiio.ImageOutput.create(path)
    if not out.open(path, spec) or not out.write_image(px) or not out.close():
        raise OSError("%s: %s" % (path, out.geterror()))


def frame(rng, path, form, large_too=True):
    """Writes a frame. `form` is what a sequence's frames share: channels and
    types. Returns a dict: size, content, at, and the window that it grows to, as
    x, y, h, w."""
    w, h, large = size(rng)
    while large and not large_too:
        w, h, large = size(rng)
    at, shown = windows(rng, w, h)
    kind, px = light(rng, w, h, large)
    if form["type"] == "half":
        over = np.abs(px) > 65504
        px = np.where(over & np.isfinite(px), 65504 * np.sign(px), px)
    names, planes = [], []
    for layer in form["layers"]:
        dot = layer + "." if layer else ""
        if form["grey"]:
            names, planes = names + [dot + "Y"], planes + [px[..., 0]]
        else:
            names += [dot + c for c in "RGB"]
            planes += [px[..., c] for c in range(3)]
        kind, px = kind, px[::-1] * 0.5
    types = [form["type"]] * len(names)
    if form["alpha"]:
        names.append("A"), types.append(form["type"])
        planes.append(np.clip(px[..., 0], 0, 1) * (np.arange(w) % 3 > 0))
    if form["depth"]:
        names.append("Z"), types.append("float")
        planes.append(depth(rng, w, h))
    write(path, names, planes, types, at, shown, rng.choice(COMPRESSIONS),
          rng.choice([0, 0, 0, 16, 64]))
    x, y = min(at[0], shown[0]), min(at[1], shown[1])
    grown = (x, y, max(at[1] + h, shown[1] + shown[3]) - y,
             max(at[0] + w, shown[0] + shown[2]) - x)
    return {"w": w, "h": h, "large": large, "content": kind, "at": at,
            "grown": grown}


def form(rng):
    grey = rng.random() < 0.15
    return {"grey": grey, "alpha": rng.random() < 0.4,
            "depth": rng.random() < 0.4,
            "type": rng.choice(["half", "float"]),
            "layers": rng.choice([[""], [""], [""], ["", "key"],
                                  ["" if grey else "beauty", "key"]])}


def kernel(rng, path):
    """A kernel file: any size, with zeros, lobes, one colour or three."""
    n = np.random.default_rng(rng.getrandbits(32))
    w, h = (rng.choice([1, 2, 3, 8, 17, 33, 64, 97]) for _ in "wh")
    kind = rng.choice(["peak", "noise", "dot", "lobes", "sparse"])
    y, x = np.mgrid[:h, :w]
    r2 = (x - w // 2) ** 2 + (y - h // 2) ** 2
    px = np.repeat((1 / (1 + r2) ** 1.3)[..., None], 3, 2)
    if kind == "noise":
        px = n.random((h, w, 3)) + 0.01
    elif kind == "dot":
        px = (r2 == 0)[..., None] * np.array([1, 0.5, 0.25])
    elif kind == "lobes":
        px -= 0.2 / (1 + r2.max()) * (x + y > w // 2)[..., None]
        px[h // 2, w // 2] += 1
    elif kind == "sparse":
        px = px * (n.random((h, w, 1)) < 0.2)
        px[0, 0] = 1
    write(path, "RGB", [px[..., c] for c in range(3)],
          [rng.choice(["half", "float"])] * 3, (0, 0), (0, 0, w, h), "zip")
    return kind
