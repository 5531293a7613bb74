# SPDX-License-Identifier: Apache-2.0
"""Compares shares of reports with the truth beside the data's frames.

Usage: shares.py DATA REPORT LIMIT

Prints shares, those whose interval holds the truth, and whether the mean and
the worst error are within LIMIT (MEAN,WORST); the errors themselves go to
stderr. Without a scene only frames with all of the light in the picture count
for the error.
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
with open(f"{data}/scenes/street.camera.json") as f:
    for frame in json.load(f)["frames"]:
        for lamp in frame["lamps"]:
            name = f"street.{frame['frame']}.exr"
            truth[name, lamp["name"]] = lamp["visible_share"]
off, holds, count = [], 0, 0
with open(report) as f:
    lines = [json.loads(line) for line in f]
for o in lines:
    for light in o["lights"]:
        name = os.path.basename(o["input"])
        true = truth.get((name, light.get("name")), truth.get(name))
        by_scene = o["settings"].get("scene") is not None
        # a light behind the camera is known by the scene; the truth of lamps
        # has a standard error of 0.003
        lo, hi = light.get("interval", [light["visibility"]] * 2)
        slack = 0.003 if "street" in name else 0.0
        holds += lo - slack <= true <= hi + slack
        count += 1
        if by_scene or whole.get(name, True):
            off.append(abs(light["visibility"] - true))
mean, worst = sum(off) / len(off), max(off)
print(f"{len(off)} shares: mean {mean:.4f}, worst {worst:.4f}",
      file=sys.stderr)
bars = [float(v) for v in limit.split(",")]
print(count, holds, mean <= bars[0] and worst <= bars[1])
