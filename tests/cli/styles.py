# SPDX-License-Identifier: Apache-2.0
"""Measures pictures of styles. Raw pictures have 16 bits, low byte first.

usage: styles.py black A B     rise of the 1st percentile from A to B, in codes of
                               8 bits
       styles.py change A B    mean of |A - B|, of 1
       styles.py same N...     largest distance of the numbers from the first,
                               relative
       styles.py repeat W K RAW EXR   writes linear floats, W pixels wide, with
                               each pixel K x K times
"""
import struct
import sys

import numpy


def codes(path):
    return numpy.fromfile(path, "<u2").astype(float)


def repeat(w, k, raw, exr):
    p = numpy.fromfile(raw, "<f4").reshape(-1, w, 3)
    p = numpy.repeat(numpy.repeat(p, k, 0), k, 1).astype("<f2")
    h, w = p.shape[:2]
    box = struct.pack("<4i", 0, 0, w - 1, h - 1)
    names = b"".join(n + struct.pack("<xi4xii", 1, 1, 1) for n in (b"B", b"G", b"R"))
    head = b"\x76\x2f\x31\x01\x02\0\0\0"
    for name, kind, data in (
            ("channels", "chlist", names + b"\0"),
            ("compression", "compression", b"\0"),
            ("dataWindow", "box2i", box), ("displayWindow", "box2i", box),
            ("lineOrder", "lineOrder", b"\0"),
            ("pixelAspectRatio", "float", struct.pack("<f", 1)),
            ("screenWindowCenter", "v2f", bytes(8)),
            ("screenWindowWidth", "float", struct.pack("<f", 1))):
        head += b"%s\0%s\0%s%s" % (name.encode(), kind.encode(),
                                   struct.pack("<i", len(data)), data)
    head += b"\0"
    size = 8 + 6 * w
    first = len(head) + 8 * h
    with open(exr, "wb") as f:
        f.write(head)
        f.write(struct.pack("<%dQ" % h, *(first + size * y for y in range(h))))
        for y in range(h):
            f.write(struct.pack("<ii", y, 6 * w))
            f.write(numpy.ascontiguousarray(p[y].T[::-1]).tobytes())


what, *rest = sys.argv[1:]
if what == "black":
    a, b = (numpy.percentile(codes(p), 1) / 257 for p in rest)
    print("%.2f" % (b - a))
elif what == "change":
    a, b = map(codes, rest)
    print("%.5f" % (numpy.abs(a - b).mean() / 65535))
elif what == "same":
    n = [float(v) for v in rest]
    print("%.5f" % max(abs(v / n[0] - 1) for v in n))
else:
    repeat(int(rest[0]), int(rest[1]), *rest[2:])
