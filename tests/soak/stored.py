# SPDX-License-Identifier: Apache-2.0
"""What a file must hold, given the values that were to be stored in it.

Compressions that lose have no bar here: the values are written once more, by
OpenImageIO in the same compression, types and windows, and what it reads back
must be what it reads from the program's file, value by value. Before that,
what a type or compression cannot hold is cut as the program promises:

  half         a pixel with a finite value over 65504 is scaled until it fits,
               which keeps its hue; the rest is rounded to the nearest, even at
               ties
  B44, B44A    halfs below -32752 become that
  DWAA, DWAB   the same at 57344, of float channels too. One channel alone is
               zip instead

Only colour is cut. Channels that pass through are what they were, and then
what the compression makes of them.
"""
import collections

import numpy as np
import OpenImageIO as oiio

import frames

DWA = ["dwaa", "dwab"]
LOSSY = ["pxr24", "b44", "b44a"] + DWA

LUMINANCE = [0.2126, 0.7152, 0.0722]  # BT.709

Image = collections.namedtuple("Image", "names types at shown px")


class Unlike(Exception):
    pass


def read(path):
    """An image as float32, h x w x channels. Never from a cache: files of one
    name follow each other."""
    f = oiio.ImageInput.open(path)
    if not f:
        raise Unlike("read %s: %s" % (path, oiio.geterror()))
    spec = f.spec()
    px = f.read_image(oiio.FLOAT)
    f.close()
    if px is None or not px.size:
        raise Unlike("read %s: %s" % (path, f.geterror()))
    types = [str(t) for t in spec.channelformats] or \
        [str(spec.format)] * spec.nchannels
    return Image(list(spec.channelnames), types, (spec.x, spec.y),
                 (spec.full_x, spec.full_y, spec.full_width, spec.full_height),
                 px.reshape(spec.height, spec.width, spec.nchannels))


def cut(v, half, compression):
    """Colour values as they go to the encoder; Inf and NaN are not cut."""
    most = 57344 if compression in DWA else \
        65504 if half else np.inf
    least = -32752 if half and compression in ("b44", "b44a") else -most
    within = np.clip(v, least, most)
    v = np.where(np.isfinite(v) | (compression in DWA), within, v)
    return v.astype(np.float16).astype(np.float32) if half else v


def fit(image, colour, half, compression):
    """The samples, each layer's colour scaled where a value is over what the
    file can hold, in float32 as the program does it."""
    px = image.px.astype(np.float32).copy()
    dwa = compression in DWA
    if not half and not dwa:
        return px
    limit = np.float32(57344 if dwa else 65504)
    most = limit if dwa else np.nextafter(np.float32(65520), np.float32(0))
    layers = collections.defaultdict(list)
    for c, name in enumerate(image.names):
        if name in colour and name.rsplit(".", 1)[-1] != "A":
            layers[name.rpartition(".")[0]].append(c)
    for at in layers.values():
        v = px[..., at]
        finite = v <= np.finfo(np.float32).max  # no NaN
        over = (finite & (v > most)).any(-1, keepdims=True)
        largest = np.where(finite, v, 0).max(-1, keepdims=True, initial=0)
        with np.errstate(all="ignore"):
            to = np.minimum(v * (limit / largest), limit)
        px[..., at] = np.where(over & np.isfinite(v), to, v)
    return px


def expected(image, colour, half, compression, path):
    """What an EXR file of `image` must hold where the names in `colour` are
    stored as half, or float, in that compression. `path`: room for a file."""
    planes, types = [], []
    if compression in DWA and len(image.names) == 1:
        compression = "zip"
    fitted = fit(image, colour, half, compression)
    for c, name in enumerate(image.names):
        own = name in colour
        planes.append(cut(fitted[..., c], half, compression) if own
                      else image.px[..., c])
        types.append(("half" if half else "float") if own else image.types[c])
    if compression not in LOSSY:
        return image._replace(types=types, px=np.stack(planes, -1))
    frames.write(path, image.names, planes, types, image.at, image.shown,
                 compression)
    return read(path)


def differ(a, b):
    """The first and largest difference of two images in words, or None."""
    for what in "names", "types", "at", "shown":
        if getattr(a, what) != getattr(b, what):
            return "%s are %s, not %s" % (what, getattr(b, what),
                                          getattr(a, what))
    if a.px.shape != b.px.shape:
        return "size is %s, not %s" % (b.px.shape, a.px.shape)
    wrong = ~((a.px == b.px) | (np.isnan(a.px) & np.isnan(b.px)))
    if not wrong.any():
        return None
    y, x, c = np.argwhere(wrong)[0]
    return "%d of %d values differ; the first, %s of pixel %d,%d, is %.9g, " \
        "not %.9g" % (wrong.sum(), wrong.size, a.names[c], x, y,
                      b.px[y, x, c], a.px[y, x, c])
