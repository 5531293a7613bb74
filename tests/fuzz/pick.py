#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Picks the inputs that reach the most, few and small.

usage: pick.py CONTROL FOLDER

CONTROL is libFuzzer's -merge_control_file: the names of the inputs, and what
each reaches. Those that reach most anew for their size are copied to FOLDER,
one after the other, up to MOST_FILES and MOST_BYTES with what is there.
"""
import hashlib
import os
import shutil
import sys

MOST_FILES, MOST_BYTES, MOST_EACH = 10, 36 << 10, 6 << 10


def read_control(path):
    """The names, and the set of features and edges of each."""
    lines = open(path, encoding="utf-8", errors="replace").read().split("\n")
    n = int(lines[0])
    names, reached = lines[2:2 + n], {}
    for line in lines[2 + n:]:
        word = line.split()
        if word and word[0] in ("FT", "COV"):
            reached.setdefault(int(word[1]), set()).update(
                word[0] + w for w in word[2:])
    return [(names[i], r) for i, r in sorted(reached.items())]


def main():
    control, folder = sys.argv[1:]
    left = [(n, r, os.path.getsize(n)) for n, r in read_control(control)]
    left = [x for x in left if 0 < x[2] <= MOST_EACH and
            os.path.dirname(x[0]) != folder]
    have = [os.path.getsize(os.path.join(folder, n))
            for n in os.listdir(folder)]
    files, size, seen = len(have), sum(have), set()
    while left and files < MOST_FILES:
        best = max(left, key=lambda x: len(x[1] - seen) / (x[2] + 256))
        left.remove(best)
        if not best[1] - seen:
            break
        if size + best[2] > MOST_BYTES:
            continue
        seen |= best[1]
        with open(best[0], "rb") as f:
            name = hashlib.sha1(f.read()).hexdigest()[:16]
        shutil.copyfile(best[0], os.path.join(folder, name))
        files, size = files + 1, size + best[2]
    print("%s: %d inputs, %d bytes" % (os.path.basename(folder), files, size))


main()
