#!/usr/bin/python3
"""Damaged EXRs that OpenEXR reads whole are read, and read the same.

usage: damaged.py GLAREPP FOLDER

Reads each file by OpenImageIO, which has OpenEXR's C++ library; where that
succeeds without a word, the program must give the same samples. Prints a
line a file, "ok ..." or "not ok ...", and how many there were.
"""
import os
import subprocess
import sys
import tempfile

import numpy as np
import OpenImageIO as oiio

MOST = 1 << 26  # samples


def read_whole(path):
    """Channel names and samples, or None where anything is wrong with it."""
    image = oiio.ImageInput.open(path)
    if image is None:
        return None
    spec = image.spec()
    data = None
    if not spec.deep and spec.width * spec.height * spec.nchannels <= MOST:
        data = image.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
        if image.has_error:
            data = None
    image.close()
    return None if data is None else (list(spec.channelnames), data)


def main():
    glarepp, folder = sys.argv[1:]
    whole = 0
    with tempfile.TemporaryDirectory() as tmp:
        link, out = os.path.join(tmp, "in.exr"), os.path.join(tmp, "out.exr")
        for name in sorted(os.listdir(folder)):
            os.symlink(os.path.abspath(os.path.join(folder, name)), link)
            theirs = read_whole(link)
            if theirs:
                whole += 1
                run = subprocess.run([glarepp, "-q", "-t", "1e30", "--hdr",
                                      out, link], capture_output=True)
                ours = read_whole(out) if run.returncode == 0 else None
                same = (ours and ours[0] == theirs[0] and
                        np.array_equal(ours[1], theirs[1], equal_nan=True))
                print("%s the same as OpenEXR: %s" %
                      ("ok" if same else "not ok", name))
            os.unlink(link)
    print("%s OpenEXR reads some of them whole (%d)" %
          ("ok" if whole else "not ok", whole))


main()
