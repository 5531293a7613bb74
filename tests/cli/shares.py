"""Compares shares of reports with the truth beside the data's frames.

Usage: shares.py DATA REPORT LIMIT

Prints frames, frames whose interval holds the truth, and whether the mean and
the worst error of the frames with all of the light in the picture are within
LIMIT (MEAN,WORST); the errors themselves go to stderr.
"""
import json
import os
import sys

data, report, limit = sys.argv[1:]
truth, whole = {}, {}
for stem in ("seq_foliage/foliage", "seq_foliage/foliage_f32",
             "rendered/window", "rendered/brightsky"):
    with open(f"{data}/{stem}.sun_truth.json") as f:
        for frame, t in json.load(f)["frames"].items():
            truth[f"{os.path.basename(stem)}.{frame}.exr"] = t["share"]
with open(f"{data}/scenes/forest.camera.json") as f:
    for frame in json.load(f)["frames"]:
        name = f"forest.{frame['frame']}.exr"
        truth[name] = frame["sun_visibility_true"]
        whole[name] = frame["on_screen"] == "full"
off, holds = [], 0
with open(report) as f:
    lines = [json.loads(line) for line in f]
for o in lines:
    name, light = os.path.basename(o["input"]), o["lights"][0]
    lo, hi = light["interval"]
    holds += lo <= truth[name] <= hi
    if whole.get(name, True):
        off.append(abs(light["visibility"] - truth[name]))
mean, worst = sum(off) / len(off), max(off)
print(f"{len(off)} frames: mean {mean:.4f}, worst {worst:.4f}",
      file=sys.stderr)
bars = [float(v) for v in limit.split(",")]
print(len(lines), holds, mean <= bars[0] and worst <= bars[1])
