#!/usr/bin/env python3
"""CPU time of the glare stage in the first frame of a run against later ones.

Usage: first.py GLAREPP FRAMES [ROUNDS]

FRAMES   folder of w1..w3 at 1024, 1920 and 3840 and k512.exr, as frames.py
         makes them
ROUNDS   runs of five equal frames each (5); the least of each frame counts

CPU time, as other work on the machine changes it less; on one processor
(taskset -c 0) it changes least.
"""
import json
import os
import subprocess
import sys
import tempfile


def stage_ms(glarepp, frame, kernel, rounds):
    """Returns milliseconds of the first frame, and of those from the third."""
    first, later = [], []
    with tempfile.TemporaryDirectory() as folder:
        for i in range(1, 6):
            os.symlink(os.path.abspath(frame), f"{folder}/f.{i:04d}.exr")
        for _ in range(rounds):
            report = f"{folder}/report.json"
            subprocess.run(
                [glarepp, "-q", "--frame-jobs", "1", "--report", report,
                 "-k", kernel, "--layer", f"{folder}/o.####.exr",
                 f"{folder}/f.####.exr"], check=True)
            with open(report, encoding="utf-8") as lines:
                ms = [json.loads(line)["cpu_ms"]["glare"] for line in lines]
            first.append(ms[0])
            later += ms[2:]
    return min(first), min(later)


def main():
    glarepp, frames = sys.argv[1:3]
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    for size in (1024, 1920, 3840):
        for name in ("w1", "w2", "w3"):
            for kernel in ("builtin:eye", os.path.join(frames, "k512.exr")):
                first, later = stage_ms(
                    glarepp, os.path.join(frames, f"{name}_{size}.exr"),
                    kernel, rounds)
                print(f"{name} {size} {os.path.basename(kernel):11} first "
                      f"{first:.1f} ms, later {later:.1f} ms, ratio "
                      f"{first / later:.2f}", flush=True)


if __name__ == "__main__":
    main()
