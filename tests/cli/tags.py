#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Prints what files say about themselves, with nothing but Python.

usage: tags.py FILE...

EXR: a line for each attribute of each part, NAME=VALUE for string and
chromaticities, else NAME. PNG: a line for each chunk before the pixels,
TYPE=VALUE for cICP, cHRM, gAMA, and KEY=TEXT for texts.
"""
import struct
import sys


def exr(b):
    version = struct.unpack("<I", b[4:8])[0]
    at = 8

    def word():
        nonlocal at
        end = b.index(0, at)
        text, at = b[at:end].decode(), end + 1
        return text

    while True:
        name = word()
        if not name:  # the end of a part, and of all parts
            if not version & 0x1000 or b[at] == 0:
                return
            continue
        kind = word()
        n = struct.unpack("<i", b[at:at + 4])[0]
        v, at = b[at + 4:at + 4 + n], at + 4 + n
        if kind == "string":
            yield f"{name}={v.decode()}"
        elif kind == "chromaticities":
            yield name + "=" + ",".join(f"{x:.4f}" for x in struct.unpack("<8f", v))
        else:
            yield name


def png(b):
    at = 8
    while True:
        n, kind = struct.unpack(">I4s", b[at:at + 8])
        v, kind = b[at + 8:at + 8 + n], kind.decode()
        at += 12 + n
        if kind == "IDAT":
            return
        if kind == "tEXt":
            yield v.decode("latin-1").replace("\0", "=", 1)
        elif kind == "iTXt":
            key, rest = v.split(b"\0", 1)
            yield f"{key.decode()}={rest[2:].split(bytes(1), 2)[2].decode()}"
        elif kind == "cICP":
            yield "cICP=" + ",".join(map(str, v))
        elif kind in ("cHRM", "gAMA"):
            yield kind + "=" + ",".join(
                f"{x / 1e5:.4f}" for x in struct.unpack(f">{n // 4}I", v))
        else:
            yield kind


for path in sys.argv[1:]:
    data = open(path, "rb").read()
    for line in (png if data[:4] == b"\x89PNG" else exr)(data):
        print(line)
