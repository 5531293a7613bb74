# SPDX-License-Identifier: Apache-2.0
"""Shares of lights that are hidden in part, against what second cameras saw.

The truths are the data's ($GLAREPP_DATA, or ../shared/data beside the repository), and those
of deep.py's leaves and smoke; tests/cli/shares.t and deep.t test the same.
"""
import json
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CLI = os.path.join(ROOT, "tests", "cli")
DATA = os.environ.get("GLAREPP_DATA", os.path.join(ROOT, "..", "shared", "data"))
FRAMES = ("seq_foliage/foliage", "seq_foliage/foliage_f32", "rendered/window",
          "rendered/brightsky", "scenes/forest")


def lights(glarepp, folder, *words):
    """The reports of frames, a line each."""
    out = os.path.join(folder, "r.json")
    subprocess.run([glarepp, "-q", *words, "--report", out], check=True, cwd=folder)
    with open(out, encoding="utf-8") as f:
        return f.read()


def against_truth(folder, reports):
    """Shares, those whose interval misses the truth, the worst error."""
    out = os.path.join(folder, "all.json")
    with open(out, "w", encoding="utf-8") as f:
        f.write("".join(reports))
    p = subprocess.run([sys.executable, os.path.join(CLI, "shares.py"), DATA, out, "1,1"],
                       check=True, capture_output=True, text=True)
    count, holds = map(int, p.stdout.split()[:2])
    return count, count - holds, float(re.search(r"worst ([.\d]+)", p.stderr)[1])


def seen(glarepp, folder, *words):
    """Shares of the sun in the data's frames."""
    return [json.loads(line)["lights"][0]["visibility"] for stem in FRAMES
            for line in lights(glarepp, folder, *words, "--camera",
                               f"{DATA}/{stem}.camera.json",
                               f"{DATA}/{stem}.####.exr").splitlines()]


def of_data(glarepp, folder):
    by_depth = [lights(glarepp, folder, "--camera", f"{DATA}/{stem}.camera.json",
                       f"{DATA}/{stem}.####.exr") for stem in FRAMES]
    count, missed, worst = against_truth(folder, by_depth)
    yield f"the frame's depth, {count} suns: worst share", worst, 0.07
    yield "  intervals that miss the truth", missed, 0
    for how, bar in (("scene", 3e-4), ("depth", 0.07)):
        by = [lights(glarepp, folder, "--sun-share", how, "--scene", f"{DATA}/scenes/{name}.glb",
                     *words, f"{DATA}/scenes/{name}.####.exr")
              for name, words in (("forest", ("--sun-size", "0.53")), ("street", ()))]
        count, missed, worst = against_truth(folder, by)
        yield f"scenes, {count} lights by --sun-share {how}: worst share", worst, bar
        yield "  intervals that miss the truth", missed, 0
    exact = seen(glarepp, folder)
    for side in "32", "64":
        small = seen(glarepp, folder, "--sun-method", "mask", "--sun-sum", "8bit",
                     "--sun-map", side)
        yield (f"a sun map of {side}, summed in 8 bits: worst share from the exact one",
               max(abs(a - b) for a, b in zip(small, exact)), 0.02)


def of_deep(glarepp, folder):
    deep = os.path.join(CLI, "deep.py")
    subprocess.run([sys.executable, deep, "make", "."], check=True, cwd=folder)
    lights(glarepp, folder, "--lights", "lights.json", "deep.exr")
    found = subprocess.run([sys.executable, deep, "check", "truth.json", "r.json", "1"],
                           check=True, cwd=folder, capture_output=True, text=True)
    worst = re.search(r"worst ([.\d]+) of discs.*, ([.\d]+) of small", found.stdout + found.stderr)
    yield "deep frames, discs of 6 pixels and more: worst share", float(worst[1]), 0.003
    yield "deep frames, smaller discs: worst share", float(worst[2]), 0.003


def bars(glarepp):
    with tempfile.TemporaryDirectory() as folder:
        if os.path.exists(f"{DATA}/scenes/forest.camera.json"):
            yield from of_data(glarepp, folder)
        else:
            print("no data folder: shares of its lights are left out")
        yield from of_deep(glarepp, folder)
