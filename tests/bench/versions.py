#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Times two builds of glarepp side by side.

Usage: versions.py OLD NEW FRAMES [RUNS]

FRAMES is the folder that frames.py fills. Runs alternate, OLD and NEW in turn
and every second pair in the other order; prints for each job the ratio NEW over
OLD, as median over the pairs, of the wall time, of the CPU time and of each
stage in the report's times_ms. Under 1 is faster. Stages under 0.3 ms are left
out, as clocks differ by more.
"""
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

OLD, NEW = (os.path.abspath(p) for p in sys.argv[1:3])
FRAMES = sys.argv[3]
RUNS = int(sys.argv[4]) if len(sys.argv) > 4 else 15
K512 = os.path.join(FRAMES, "k512.exr")
LEAST_MS = 0.3


def jobs():
    for size in ("1024", "1920", "3840"):
        for frame in ("w1", "w2", "w3"):
            path = os.path.join(FRAMES, f"{frame}_{size}.exr")
            for kernel in ("builtin:eye", K512):
                name = f"{frame} {size} {os.path.basename(kernel)}"
                yield name, ["-k", kernel, path]
    w1 = os.path.join(FRAMES, "w1_1024.exr")
    w2 = os.path.join(FRAMES, "w2_1920.exr")
    yield "w1 1024 direct", ["-e", "direct", "-k", K512, w1]
    yield "w1 1024 splat", ["-e", "splat", "-k", K512, w1]
    yield "w2 1920 sun", ["--sun", "849.7,387.2,7.44", "--sun-color",
                          "1e6,9e5,7e5", "--mask", "R", w2]
    tif = os.path.join(FRAMES, "w2_1920.tif")
    if not os.path.exists(tif):
        subprocess.run([OLD, "-g", "0", "--tonemap", "none", "--type", "half",
                        "-o", tif, w2], check=True)
    yield "w2 1920 TIFF in", ["-k", "builtin:eye", tif]


def run(program, options, folder):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.monotonic()
    subprocess.run([program, *options, "--hdr", folder + "/h.exr", "-o",
                    folder + "/p.png", "--report", folder + "/r.json"],
                   check=True, stderr=subprocess.DEVNULL)
    wall = (time.monotonic() - began) * 1e3
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = 1e3 * (after.ru_utime + after.ru_stime - before.ru_utime
                 - before.ru_stime)
    with open(folder + "/r.json", encoding="utf-8") as f:
        times = json.loads(f.readline())["times_ms"]
    return {"wall": wall, "cpu": cpu, **times}


def main():
    with tempfile.TemporaryDirectory() as folder:
        for name, options in jobs():
            pairs = []
            for program in (OLD, NEW):  # one to warm the files
                run(program, options, folder)
            for i in range(RUNS):
                order = (OLD, NEW) if i % 2 else (NEW, OLD)
                made = {p: run(p, options, folder) for p in order}
                pairs.append((made[OLD], made[NEW]))
            print(f"{name:24}", end="")
            for key in pairs[0][0]:
                old = [a[key] for a, b in pairs if key in a and key in b]
                if not old or statistics.median(old) < LEAST_MS:
                    continue
                ratio = statistics.median(b[key] / a[key] for a, b in pairs
                                          if a.get(key) and key in b)
                print(f" {key} {ratio:.3f}", end="")
            print(f"   ({statistics.median(a['wall'] for a, b in pairs):.0f} "
                  "ms)", flush=True)


main()
