# SPDX-License-Identifier: Apache-2.0
"""Random command lines of the soak.

options() gives two lists: what a command shares with the same command with
--engine direct, and what is the engine's own. No output depends on threads and
frames in flight, so each run of a case has its own.
"""
import json

from stored import LOSSY

BUILTIN = ["eye", "streak", "star", "cross", "circle", "ring"]
CURVES = ["reinhard", "reinhard-extended", "aces", "hable", "agx", "neutral",
          "linear", "none"]
LOSSLESS = ["none", "rle", "zips", "zip", "piz", "auto"]


def some(rng, share, *words):
    return [str(w) for w in words] if rng.random() < share else []


def light(rng, kernel, large):
    scatter = rng.random() < 0.3
    words = ["-t", rng.choice([0.5, 1, 3] if large else
                              [0, 1e-3, 0.5, 1, 1, 3, 50])]
    words += ["-g", "%.3g" % (rng.uniform(0, 1) if scatter else
                              rng.choice([0, 0.1, 1, 1, 20]))]
    words += ["-k", kernel] if kernel else \
        ["-k", "builtin:" + rng.choice(BUILTIN)]
    words += some(rng, 0.3, "--threshold-mode", "whole", "--knee",
                  "%.2f" % rng.random())
    words += [] if scatter else ["--mix", "add"]
    words += some(rng, 0.2, "--max-value", rng.choice([10, 1e5, 1e9, 1e30]))
    words += some(rng, 0.25, "--rotate", rng.choice([90, 180, -30, 12.5, 361]))
    center = some(rng, 0.15, "--kernel-center", "%.3g,%.3g" %
                  (rng.uniform(-3, 40), rng.uniform(-3, 40)))
    words += center if kernel else []
    words += some(rng, 0.15, "--kernel-normalize", "none") if kernel else []
    return [str(w) for w in words]


def sun(rng, folder, frame, form, gl):
    """A sun in or near the frame; lamps and lens flare now and then."""
    if rng.random() < 0.65:
        return []
    (x0, y0), w, h = frame["at"], frame["w"], frame["h"]

    def place():
        return [round(x0 + rng.uniform(-0.3, 1.3) * w, 3),
                round(y0 + rng.uniform(-0.3, 1.3) * h, 3)]

    words = ["--sun=%g,%g,%g" % (*place(), rng.choice([0, 0.2, 0.5, 3, 40]))]
    flux = some(rng, 0.8, "--sun-color", rng.choice(
        ["1e3", "5,4,3", "1e5,9e4,8e4", "0.01"]))
    words += flux
    methods = ["exact", "exact", "mask", "readback"] if gl else ["exact"]
    words += ["--sun-method", rng.choice(methods)]
    words += some(rng, 0.3, "--sun-map", rng.choice([2, 16, 64]))
    words += some(rng, 0.2, "--sun-pattern", "square")
    words += some(rng, 0.3, "--sun-sum", "8bit")
    words += some(rng, 0.3, "--sun-outside", rng.choice(["visible", "hidden"]))
    words += some(rng, 0.2, "--sun-adapt", "0.5")
    words += some(rng, 0.2, "--sun-in-frame")
    if form["depth"]:
        words += some(rng, 0.3, "--depth-type", rng.choice(
            ["ray", "inverse", "normalized"]))
    if form["alpha"]:
        words += some(rng, 0.4, "--mask", "A")
    if rng.random() < 0.3:
        lamps = [{"pixel": place(), "radius": rng.uniform(0, 9), "depth": 20,
                  "flux": [rng.uniform(0, 900)] * 3}
                 for _ in range(rng.randint(0, 5))]
        with open(folder + "/lamps.json", "w") as f:
            json.dump(lamps, f)
        words += ["--lights", folder + "/lamps.json"]
    if flux and rng.random() < 0.3:
        shapes = ["disc", "ring", "polygon", "streak"]
        flare = [{"shape": rng.choice(shapes), "position": rng.uniform(0, 2),
                  "size": rng.uniform(0.01, 0.6), "rotation": rng.uniform(0, 90)}
                 for _ in range(rng.randint(1, 3))]
        with open(folder + "/flare.json", "w") as f:
            json.dump(flare, f)
        words += ["--flare", folder + "/flare.json"]
    words += some(rng, 0.15, "--lens", rng.choice(["heliar", "tessar"]))
    return words


def tone(rng):
    words = ["--tonemap", rng.choice(CURVES)]
    words += some(rng, 0.3, "--exposure", rng.choice([-3, 0.5, 4]))
    words += some(rng, 0.3, "--auto-exposure")
    words += some(rng, 0.2, "--white", rng.choice([0, 2, 100]))
    words += some(rng, 0.2, rng.choice(["--dither", "--no-dither"]))
    words += some(rng, 0.3, "--depth-bits", 16)
    words += some(rng, 0.3, "--alpha", "keep")
    return words


def files(rng):
    words = ["--type", rng.choice(["float", "float", "float", "half"])]
    return words + ["--compression", rng.choice(LOSSLESS * 3 + LOSSY)]


def layers(rng, form):
    if len(form["layers"]) < 2:
        return []
    return rng.choice([[], ["--layer-in", "key"], ["--light-group", "key"]])


def engine(rng, gl):
    """The engine's options; the first two words are --engine NAME."""
    name = rng.choice(["auto", "fft", "fft", "direct"] +
                      ["auto", "splat", "splat"] * gl)
    words = ["--engine", name]
    if name == "auto":
        words += ["--tolerance", rng.choice([0, 1e-6, 1e-4, 1e-3, 0.05, 1])]
    if name != "splat":
        return [str(w) for w in words]
    kind = rng.choice(["exact", "default", "any"])
    if kind == "exact":
        words += ["--group", 1, "--cluster", 0, "--shrink", 0]
    elif kind == "any":
        group = rng.choice([1, 2, 8])
        words += ["--group", group, "--cluster", rng.choice([0, group * 2]),
                  "--cluster-fill", rng.choice([0.1, 0.5, 1]), "--shrink",
                  rng.choice([0, 1e-5, 0.1])]
    return [str(w) for w in words]


def run(rng):
    """What no output may depend on."""
    return ["--threads", str(rng.choice([0, 1, 2, 3, 8])),
            "--frame-jobs", str(rng.choice([0, 1, 2, 3]))]
