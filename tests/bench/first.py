#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""CPU time of the glare stage in a run's only or first frame against later ones.

Usage: first.py GLAREPP FRAMES [ROUNDS]

FRAMES   folder of w1..w3 at 1024, 1920 and 3840 and k512.exr, as frames.py
         makes them
ROUNDS   runs of one frame, and of five equal ones (5); the least of each counts

CPU time, as other work on the machine changes it less; on one processor
(taskset -c 0) it changes least.
"""
import json
import os
import subprocess
import sys
import tempfile


def run_ms(glarepp, folder, kernel, frames, layers):
    """Returns milliseconds of each frame of a run."""
    report = f"{folder}/report.json"
    subprocess.run(
        [glarepp, "-q", "--frame-jobs", "1", "--report", report,
         "-k", kernel, "--layer", f"{folder}/{layers}", f"{folder}/{frames}"],
        check=True)
    with open(report, encoding="utf-8") as lines:
        return [json.loads(line)["cpu_ms"]["glare"] for line in lines]


def stage_ms(glarepp, frame, kernel, rounds):
    """Returns milliseconds of an only frame, a first one, those from the third."""
    only, first, later = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for i in range(1, 6):
            os.symlink(os.path.abspath(frame), f"{folder}/f.{i:04d}.exr")
        for _ in range(rounds):
            only += run_ms(glarepp, folder, kernel, "f.0001.exr", "o.exr")
            ms = run_ms(glarepp, folder, kernel, "f.####.exr", "o.####.exr")
            first.append(ms[0])
            later += ms[2:]
    return min(only), min(first), min(later)


def main():
    glarepp, frames = sys.argv[1:3]
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    for size in (1024, 1920, 3840):
        for name in ("w1", "w2", "w3"):
            for kernel in ("builtin:eye", os.path.join(frames, "k512.exr")):
                only, first, later = stage_ms(
                    glarepp, os.path.join(frames, f"{name}_{size}.exr"),
                    kernel, rounds)
                print(f"{name} {size} {os.path.basename(kernel):11} only "
                      f"{only:.1f} ms, first {first:.1f} ms, later {later:.1f} "
                      f"ms, ratios {only / later:.2f} {first / later:.2f}",
                      flush=True)


if __name__ == "__main__":
    main()
