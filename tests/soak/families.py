#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What differs between processors, as a table.

usage: families.py PROGRAM FOLDER

Each engine's layer and picture under settings that stand for other processors,
against this one as it is: `glarepp compare`'s rel_l2 and largest error of the
layer, and the largest difference of the picture in code values of 8 and of
16 bits. The settings:

  libm        GLIBC_TUNABLES: the C library's functions without AVX2 and FMA
  llvmpipe N  LP_NATIVE_VECTOR_WIDTH=N: vectors of the software GL
  NAME        qemu-x86_64 -cpu NAME, where there is one: the exact engine's
              loops, FFTW's codelets and llvmpipe's code are then those for
              that processor as well. EMULATOR=FILE is another such program
"""
import json
import os
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import frames

import numpy as np

ENGINES = [("direct", ["--engine", "direct"]), ("fft", ["--engine", "fft"]),
           ("splat", ["--engine", "splat"]),
           ("splat, plain", ["--engine", "splat", "--group", "1", "--cluster",
                             "0", "--shrink", "0"]),
           ("sun masks", ["--engine", "fft", "--sun", "150,60,20",
                          "--sun-color", "1e4,9e3,8e3", "--sun-method", "mask"])]
TUNABLES = "glibc.cpu.hwcaps=-AVX2,-AVX,-FMA,-FMA4,-AVX512F"


def settings():
    yield "libm", {"GLIBC_TUNABLES": TUNABLES}, []
    for width in "128", "256", "512":
        yield "llvmpipe " + width, {"LP_NATIVE_VECTOR_WIDTH": width}, []
    emulator = shutil.which(os.environ.get("EMULATOR", "qemu-x86_64"))
    for cpu in ("Nehalem", "Haswell") if emulator else ():
        yield cpu, {}, [emulator, "-cpu", cpu]


def make(program, folder, name, engine, environment, emulator):
    at = os.path.join(folder, name)
    for bits in "8", "16":
        words = emulator + [program, "-q", "-t", "1", "-k", "builtin:eye",
                            "--type", "float", "--tonemap", "agx", "--layer",
                            at + ".exr", "-o", "%s.%s.png" % (at, bits),
                            "--depth-bits", bits, *engine, folder + "/in.exr"]
        p = subprocess.run(words, env={**os.environ, **environment},
                           capture_output=True, text=True)
        if p.returncode:
            return p.stderr.strip()[-200:] or "status %d" % p.returncode
    return None


def compare(program, a, b):
    p = subprocess.run([program, "compare", "--no-flip", "--json", "-", a, b],
                       capture_output=True, text=True)
    return json.loads(p.stdout)


def main():
    program, folder = sys.argv[1:]
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    n = np.random.default_rng(1)
    w, h = 320, 200
    px = n.random((h, w, 3)) * 0.5
    px[n.integers(0, h, 150), n.integers(0, w, 150)] = \
        np.exp(n.uniform(0, 8, (150, 1))) * n.uniform(0.5, 1, (150, 3))
    frames.write(folder + "/in.exr", "RGB", [px[..., c] for c in range(3)],
                 ["float"] * 3, (0, 0), (0, 0, w, h), "zip")
    print("%-14s %-13s %9s %9s %12s %13s" % (
        "engine", "processor", "rel_l2", "max_abs", "8-bit codes", "16-bit codes"))
    for engine, words in ENGINES:
        wrong = make(program, folder, "here", words, {}, [])
        if wrong:
            print("%-14s %s" % (engine, wrong))
            continue
        for name, environment, emulator in settings():
            if "llvmpipe" in name and not engine.startswith(("splat", "sun")):
                continue
            wrong = make(program, folder, "there", words, environment, emulator)
            if wrong:
                print("%-14s %-13s %s" % (engine, name, wrong))
                continue
            here, there = folder + "/here", folder + "/there"
            layer = compare(program, here + ".exr", there + ".exr")
            codes = [compare(program, here + end, there + end)["max"] * full
                     for end, full in ((".8.png", 255), (".16.png", 65535))]
            print("%-14s %-13s %9.2g %9.2g %12.0f %13.0f" % (
                engine, name, layer["rel_l2"], layer["max"], *codes), flush=True)


main()
