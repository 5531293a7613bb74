#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""CPU time that --lights auto adds to the sensors, in ms, on one thread.

Usage: lights.py GLAREPP FRAMES [RUNS]

FRAMES is the folder that frames.py fills. Runs alternate, with and without; prints the
median of each, and how many lights there are.
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile

GLAREPP, FRAMES = sys.argv[1:3]
RUNS = int(sys.argv[3]) if len(sys.argv) > 3 else 9


def report(frame, folder, *words):
    subprocess.run([GLAREPP, "-q", "--threads", "1", *words, "--layer", folder + "/l.exr",
                    "--report", folder + "/r.json", frame], check=True)
    with open(folder + "/r.json", encoding="utf-8") as f:
        return json.loads(f.readline())


def main():
    print("| frame | without | with | lights |\n|---|---|---|---|")
    for name in "w1_1920", "w2_1920", "w3_1920":
        frame = os.path.join(FRAMES, name + ".exr")
        ms = [[], []]
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(RUNS):
                for words, out in ([], ms[0]), (["--lights", "auto"], ms[1]):
                    row = report(frame, folder, *words)
                    out.append(row["cpu_ms"]["sensors"])
        print("| %s | %.1f | %.1f | %d |" % (name, *map(statistics.median, ms),
                                             len(row["lights"])))


main()
