#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares pictures as OpenImageIO reads them; needs numpy and OpenImageIO.

stdin, one comparison a line:   A B LIMIT DESCRIPTION...
stdout:                         "ok DESCRIPTION" or "not ok DESCRIPTION"

A and B are FILE, FILE@PART or FILE:channel,channel (also FILE@PART:...).
LIMIT is `equal` (every value, NaN equals NaN), a limit of rel_l2 (the norm of
the difference over that of B), srgb:LIMIT, where B is decoded from sRGB
first, or each:LIMIT, the largest error relative to a value of B itself.
Without channels, both sides have the same ones.
"""
import sys
import numpy as np
import OpenImageIO as oiio


def read(word):
    word, _, names = word.partition(":")
    path, _, part = word.partition("@")
    buf = oiio.ImageBuf(path, int(part or 0), 0)
    if buf.has_error:
        raise ValueError(buf.geterror())
    have = list(buf.spec().channelnames)
    px = np.asarray(buf.get_pixels(oiio.FLOAT))
    names = names.split(",") if names else sorted(have)
    return names, px[..., [have.index(n) for n in names]].astype(np.float64)


def decode(v):
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def compare(a, b, limit):
    (na, a), (nb, b) = read(a), read(b)
    if na != nb or a.shape != b.shape:
        return "%s %s, %s %s" % (na, a.shape, nb, b.shape)
    if limit == "equal":
        n = int((~((a == b) | (np.isnan(a) & np.isnan(b)))).sum())
        return "%d values differ" % n if n else ""
    if limit.startswith("srgb:"):
        limit, b = limit[5:], decode(b)
    if limit.startswith("each:"):
        error = (np.abs(a - b) / np.maximum(np.abs(b), 1e-300)).max()
        return "" if error <= float(limit[5:]) else "largest %.3g" % error
    error = np.linalg.norm(a - b) / max(np.linalg.norm(b), 1e-300)
    return "" if error <= float(limit) else "rel_l2 %.3g" % error


for line in sys.stdin:
    a, b, limit, about = line.rstrip("\n").split(" ", 3)
    try:
        wrong = compare(a, b, limit)
    except Exception as e:  # a file that cannot be read is a verdict too
        wrong = "%s: %s" % (type(e).__name__, " ".join(str(e).split()))
    print(("not ok " if wrong else "ok ") + about)
    if wrong:
        print("# %s %s: %s" % (a, b, wrong))
