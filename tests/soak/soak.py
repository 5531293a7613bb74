#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Random frames with random options, each against --engine direct.

usage: soak.py PROGRAM [--seed N] [--frames N] [--only N] [--jobs N]
               [--seconds S] [--folder DIR] [--no-gl]

A case is one command over one to four random frames, made from seed and
number alone. It is run up to five times, with other numbers of threads and of
frames in flight each time; the letters name the files:

  a  as it is: half or float, any compression
  p  its engine, values kept whole: float, zip. (a itself where it does that)
  b  the reference: --engine direct, float, zip
  d  the reference of pictures: --engine direct on p's hdr, without glare
  c  in some cases: as a

So each output of a is held to the reference in steps that have no gap:

  stored   a's layer, hdr and picture are p's, as their type and compression
           store them: value by value, lossy files too (stored.py)
  layer    p to b by `glarepp compare`: rel_l2 within the bounds that both
           reports state. With negative lobes they state none: see check_lobes
  hdr      p to b: no value further off than the layer times the gain, and
           rounding
  picture  p to d: the same values, each of them
  bound    of auto: within --tolerance, or a warning said otherwise
  verify   in some cases: --verify measures no more than the bound
  again    in some cases: c is the same bytes as a
  read     every output is read by OpenImageIO, in the input's windows

The last lines count what was compared, and what was not and why.

A fault keeps its files under --folder and says the command that repeats it.
"""
import argparse
import collections
import concurrent.futures
import filecmp
import glob
import json
import os
import random
import re
import shutil
import subprocess
import sys
import time

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import frames
import options
import stored

MOST = "3.4e38"  # no light is over it
FLOAT = 2.0 ** -22  # of a value, both sides rounded
WHOLE = ["--type", "float", "--compression", "zip"]


class Fault(Exception):
    pass


class Refused(Exception):
    """What the program may refuse: more than the driver's point sprites."""


class Case:
    def __init__(self, program, number, seed, folder, gl):
        self.program, self.folder = program, folder
        self.rng = rng = random.Random("%d:%d" % (seed, number))
        self.worst, self.engines = {}, collections.Counter()
        self.compared = collections.Counter()
        os.makedirs(folder)
        self.count = rng.choice([1, 1, 1, 1, 1, 1, 1, rng.randint(2, 4)])
        form = frames.form(rng)
        self.frames = [frames.frame(rng, "%s/in.%04d.exr" % (folder, i + 1),
                                    form, self.count == 1)
                       for i in range(self.count)]
        large = any(f["large"] for f in self.frames)
        kernel = None
        if rng.random() < 0.4:
            kernel = folder + "/kernel.exr"
            frames.kernel(rng, kernel)
        light = options.light(rng, kernel, large) + \
            options.sun(rng, folder, self.frames[0], form, gl)
        self.tone = options.tone(rng)
        self.grow = ["--grow", "none"] * (number % 2)
        self.shared = light + self.tone + options.files(rng) + self.grow
        self.layers = options.layers(rng, form)
        self.shared += self.layers
        self.engine = options.engine(rng, gl)
        if self.engine[1] == "splat":  # which draws one kernel
            self.shared += ["--projection", "plane"]
        self.runs = [options.run(rng) for _ in range(3)]
        self.verify = not large and rng.random() < 0.15
        self.again = rng.random() < 0.3
        self.ending = rng.choice(["png", "png", "png", "exr", "tif", "pfm"])
        if self.ending == "tif":  # has few compressions
            self.shared += ["--compression", rng.choice(["none", "rle", "zip"])]
        self.half = self.option("--type") == "half"
        self.compression = self.option("--compression")
        first = self.option("--layer-in", form["layers"][0])
        self.colour = [(layer + "." if layer else "") + c for c in "RGBY"
                       for layer in (first, self.option("--light-group", first))]

    def option(self, name, other=None):
        at = [i for i, w in enumerate(self.shared) if w == name]
        return self.shared[at[-1] + 1] if at else other

    # -- running -----------------------------------------------------------

    def call(self, words, name):
        try:
            p = subprocess.run([self.program] + words, capture_output=True,
                               text=True, timeout=120)
        except subprocess.TimeoutExpired:
            raise Fault("%s: over 120 s: %s" % (name, " ".join(words)))
        with open("%s/%s.log" % (self.folder, name), "a") as f:
            f.write("glarepp %s\n%s%s" % (" ".join(words), p.stdout, p.stderr))
        return p

    def make(self, name, words, run):
        """Runs one side; its outputs are NAME.*. Returns its report."""
        at = self.folder + "/" + name
        return self.report(name, self.shared + words + run + [
            "--hdr", at + ".hdr.####.exr", "--layer", at + ".layer.####.exr"],
            self.folder + "/in")

    def report(self, name, words, inputs):
        """Makes the pictures NAME.out.*, and what `words` ask for."""
        at = self.folder + "/" + name
        p = self.call(words + [
            "--report", at + ".json", "-o", at + ".out.####." + self.ending,
            "-f", "1-%d" % self.count, inputs + ".####.exr"], name)
        if p.returncode == 5 and "point sprites of" in p.stderr:
            raise Refused
        if p.returncode:
            raise Fault("%s: status %d: %s" %
                        (name, p.returncode, p.stderr.strip()[-300:]))
        with open(at + ".json") as f:
            lines = [json.loads(line) for line in f]
        if len(lines) != self.count:
            raise Fault("%s: report of %d lines" % (name, len(lines)))
        return lines, p.stderr

    def compare(self, what):
        """Rows of `glarepp compare`, direct being the first image."""
        at = self.folder
        p = self.call(["compare", "--no-flip", "--json", "-",
                       "-f", "1-%d" % self.count, "%s/b.%s.####.exr" % (at, what),
                       "%s/%s.%s.####.exr" % (at, self.whole, what)], "compare")
        if p.returncode > 2 or p.returncode < 0:
            raise Fault("compare %s: status %d: %s" %
                        (what, p.returncode, p.stderr.strip()[-300:]))
        rows = [json.loads(line) for line in p.stdout.splitlines()]
        if len(rows) != self.count:
            raise Fault("compare %s: %d rows" % (what, len(rows)))
        return rows

    # -- checks ------------------------------------------------------------

    def hold(self, what, measured, allowed):
        if measured is None or not measured <= allowed:
            raise Fault("%s: %s measured, %s allowed" % (what, measured, allowed))
        if allowed > 0:
            self.worst[what] = max(self.worst.get(what, 0), measured / allowed)

    def read(self, name, what, i):
        end = self.ending if what == "out" else "exr"
        path = "%s/%s.%s.%04d.%s" % (self.folder, name, what, i + 1, end)
        image, f = stored.read(path), self.frames[i]
        if what != "out" and (*image.at, *image.px.shape[:2]) != \
                ((*f["at"], f["h"], f["w"]) if self.grow else f["grown"]):
            raise Fault("read %s: another data window" % path)
        if what == "layer" and not np.isfinite(image.px).all():
            raise Fault("read %s: not finite" % path)
        return image

    def same(self, what, i, wanted, got):
        wrong = stored.differ(wanted, got)
        if wrong:
            raise Fault("%s, frame %d: %s" % (what, i + 1, wrong))

    def peak(self, name, what, i, finite=True):
        """The largest magnitude of its colour."""
        image = self.read(name, what, i)
        px = np.abs(image.px[..., [c in self.colour or what != "hdr"
                                   for c in image.names]])
        return float(px[np.isfinite(px)].max(initial=0)) if finite else px.max()

    def check_stored(self, i):
        """Where a is p, reading it and `compare` are all there is to do."""
        for what in "layer", "hdr", "out":
            got = self.read("a", what, i)
            if self.whole == "a":
                continue
            wanted = self.read("p", what, i)
            exr = what != "out" or self.ending == "exr"
            if exr:  # TIFF and PFM are float, PNG has integers
                wanted = stored.expected(
                    wanted, self.colour if what == "hdr" else "RGBA", self.half,
                    self.compression, self.folder + "/stored.exr")
            self.same("stored " + what, i, wanted, got)
            if exr and self.compression in stored.LOSSY:
                self.compared["lossy"] += 1

    def check_layer(self, rows, a, b, warnings):
        for i, row in enumerate(rows):
            bounds = [o[i].get("bound", 0.0) for o in (a, b)]
            self.engines[a[i]["engine"]] += 1
            if None in bounds and row["max"] > 0:
                self.check_lobes(row, i, a[i]["engine"])
                continue
            if None in bounds:
                self.compared["layers"] += 1  # the same values
                continue
            allowed = sum(bounds) / max(1 - bounds[1], 0.1) * 1.0001 + FLOAT
            self.hold("layer", row["rel_l2"], allowed)
            self.compared["layers"] += 1
            tolerance = self.tolerance()
            if tolerance is not None and a[i]["engine"] != "none" and \
                    "tolerance" not in warnings:  # which the warning names
                self.hold("bound", bounds[0], tolerance * (1 + 1e-6))

    def check_reports(self, a, p):
        for one, other in zip(a, p):
            for key in "engine", "bound":
                if one.get(key) != other.get(key):
                    raise Fault("report: %s is %s, and %s in a float file" %
                                (key, one.get(key), other.get(key)))
            if "measured" in one and one["bound"] is not None:
                self.hold("verify", one["measured"]["rel_l2"], one["bound"])

    def check_lobes(self, row, i, engine):
        """A kernel with negative lobes: light may cancel, and the engine says
        no bound. The sums of fft and direct round as those of the kernel's
        magnitudes would, which have one. What splat approximates is linear in
        the kernel: its positive part less its negative one, whose bounds add
        up."""
        own = self.engine if self.engine[1] != "auto" else ["--engine", engine]
        if self.option("-k").startswith("builtin:"):  # none reaches the frame
            self.compared["unbounded"] += 1           # for sure: no least norm
            return
        allowed = 0.0
        for sign in (1, -1) if engine == "splat" else (0,):
            words = WHOLE + ["-k", self.folder + "/part.exr"]
            share = self.part(sign)
            q, _ = self.make("q", words + own, self.runs[0])
            e, _ = self.make("e", words + ["--engine", "direct"], self.runs[1])
            bounds = [o[i].get("bound", 0.0) for o in (q, e)]
            if None in bounds:
                self.compared["unbounded"] += 1
                return
            norm = np.linalg.norm(self.read("e", "layer", i).px.astype(float))
            allowed += share * (sum(bounds) + FLOAT) * norm
        values = self.read("e", "layer", i).px.size
        self.hold("lobes", row["rms"] * values ** 0.5, allowed + 1e-37)
        self.compared["layers"] += 1

    def part(self, sign):
        """Makes a file of the kernel's values of one sign, or of the magnitudes
        of all for 0. Returns how much of the kernel's luminance, which is scaled
        to 1, they hold."""
        k = stored.read(self.option("-k"))
        px = np.maximum(sign * k.px, 0) if sign else np.abs(k.px)
        frames.write(self.folder + "/part.exr", k.names,
                     np.moveaxis(px, -1, 0), k.types, k.at, k.shown, "zip")
        if self.option("--kernel-normalize") == "none":
            return 1.0
        light, whole = (np.dot(v.sum((0, 1), dtype=float), stored.LUMINANCE)
                        for v in (px, k.px))
        return light / whole

    def tolerance(self):
        if self.engine[1] != "auto":
            return None
        return float(self.engine[self.engine.index("--tolerance") + 1])

    def check_hdr(self, layer):
        gain = float(self.option("-g"))
        for i, row in enumerate(self.compare("hdr")):
            peak = max(self.peak("b", "hdr", i), gain * self.peak("b", "layer", i))
            self.hold("hdr", row["max"], gain * layer[i]["max"] * 1.001 +
                      FLOAT * peak + 1e-37)
            self.compared["hdrs"] += 1

    def check_pictures(self):
        """A frame's hdr as input, all of it under the threshold, is shown as
        that frame was."""
        one = ["-t", MOST, "-g", "0"]
        layer = self.layers if "--layer-in" in self.layers else []
        self.report("d", self.tone + self.grow + layer + one + WHOLE +
                    ["--engine", "direct"] + self.runs[1],
                    "%s/%s.hdr" % (self.folder, self.whole))
        for i in range(self.count):
            if not self.peak(self.whole, "hdr", i, False) <= float(MOST):
                self.compared["beyond"] += 1
                continue
            self.same("picture", i, self.read("d", "out", i),
                      self.read(self.whole, "out", i))
            self.compared["pictures"] += 1

    def check_again(self):
        self.make("c", self.engine, self.runs[2])
        for path in sorted(glob.glob(self.folder + "/a.*.*.*")):
            other = re.sub(r"/a\.([^/]*)$", r"/c.\1", path)
            if not filecmp.cmp(path, other, False):
                raise Fault("again: %s and %s differ" % (path, other))

    def check(self):
        a, warnings = self.make("a", self.engine + ["--verify"] * self.verify,
                            self.runs[0])
        b, _ = self.make("b", WHOLE + ["--engine", "direct"], self.runs[1])
        self.whole, p = "a", a
        if self.half or self.compression in stored.LOSSY:
            self.whole = "p"
            p, warnings = self.make("p", self.engine + WHOLE, self.runs[2])
        rows = self.compare("layer")
        self.check_layer(rows, p, b, warnings)
        self.check_hdr(rows)
        self.check_pictures()
        for i in range(self.count):
            self.check_stored(i)
        self.check_reports(a, p)
        if self.again:
            self.check_again()


def soak(o, number):
    """One case, and its fault or None."""
    folder = os.path.join(o.folder, str(number))
    shutil.rmtree(folder, ignore_errors=True)
    case = Case(o.program, number, o.seed, folder, not o.no_gl)
    fault = None
    try:
        case.check()
    except Refused:
        case.engines["refused"] += case.count
    except (Fault, stored.Unlike) as e:
        fault = str(e)
    if not fault and o.only is None:
        shutil.rmtree(folder)
    return case, fault


def main():
    p = argparse.ArgumentParser()
    p.add_argument("program")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--frames", type=int, default=2000)
    p.add_argument("--only", type=int)
    p.add_argument("--jobs", type=int, default=2)
    p.add_argument("--seconds", type=float, default=1e9,
                   help="begin no cases later than that")
    p.add_argument("--folder", default="soak")
    p.add_argument("--no-gl", action="store_true")
    o = p.parse_args()
    started, number, done, faults = time.monotonic(), 0, 0, 0
    worst, engines = {}, collections.Counter()
    compared = collections.Counter()
    again = "python3 %s %s --seed %d%s --only %%d" % (
        sys.argv[0], o.program, o.seed, " --no-gl" * o.no_gl)
    with concurrent.futures.ThreadPoolExecutor(o.jobs) as pool:
        while done < o.frames and time.monotonic() - started < o.seconds:
            batch = range(number, number + 4) if o.only is None else [o.only]
            number += 4
            for n, (case, fault) in zip(batch, pool.map(
                    lambda n: soak(o, n), batch)):
                done += case.count
                engines += case.engines
                compared += case.compared
                for k, v in case.worst.items():
                    worst[k] = max(worst.get(k, (0, 0)), (v, n))
                if fault:
                    faults += 1
                    print("case %d: %s\n  files: %s\n  again: %s" %
                          (n, fault, case.folder, again % n), flush=True)
            if o.only is not None:
                break
    print("%d frames, %.0f seconds, seed %d" %
          (done, time.monotonic() - started, o.seed))
    print("engines: " + ", ".join("%s %d" % e for e in sorted(engines.items())))
    for k, (v, n) in sorted(worst.items()):
        print("%-8s worst measured / allowed %.3g (case %d)" % (k, v, n))
    print("compared: %d layers, %d hdrs, %d pictures; %d files of them lossy" %
          tuple(compared[k] for k in ("layers", "hdrs", "pictures", "lossy")))
    print("not compared: %d layers whose engine states no bound, %d pictures of "
          "values beyond %s, %d frames that the GL refused" %
          (compared["unbounded"], compared["beyond"], MOST, engines["refused"]))
    print("%d faults" % faults)
    sys.exit(1 if faults else 0)


main()
