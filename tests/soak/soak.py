#!/usr/bin/python3
"""Random frames with random options, each against --engine direct.

usage: soak.py PROGRAM [--seed N] [--frames N] [--only N] [--jobs N]
               [--seconds S] [--folder DIR] [--no-gl]

A case is one command over one to four random frames, made from seed and
number alone, and run twice: as it is, and with --engine direct and other
numbers of threads and of frames in flight. Checked, for each frame:

  layer    `glarepp compare`: rel_l2 within the bounds that both reports state
  bound    of auto: within --tolerance, or a warning said otherwise
  verify   in some cases: --verify measures no more than the bound
  hdr      `glarepp compare`: no value further off than the layer times the
           gain, and rounding
  picture  where hdr agrees value by value: within one code value
  again    in some cases: the same bytes with other threads and frames in flight
  read     every output is read by OpenImageIO, in the input's windows

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
import OpenImageIO as oiio

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import frames
import options

HALF, FLOAT = 2.0 ** -10, 2.0 ** -22  # of a value, both sides rounded


class Fault(Exception):
    pass


class Refused(Exception):
    """What the program may refuse: more than the driver's point sprites."""


class Case:
    def __init__(self, program, number, seed, folder, gl):
        self.program, self.folder = program, folder
        self.rng = rng = random.Random("%d:%d" % (seed, number))
        self.worst, self.engines = {}, collections.Counter()
        self.pictures = 0
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
        self.shared = options.light(rng, kernel, large) + \
            options.sun(rng, folder, self.frames[0], form, gl) + \
            options.tone(rng) + options.files(rng) + options.layers(rng, form)
        self.engine = options.engine(rng, gl)
        self.runs = [options.run(rng) for _ in range(3)]
        self.verify = not large and rng.random() < 0.15
        self.again = rng.random() < 0.3
        self.ending = rng.choice(["png", "png", "png", "exr", "tif", "pfm"])
        if self.ending == "tif":  # has few compressions
            self.shared += ["--compression", rng.choice(["none", "rle", "zip"])]

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

    def make(self, name, engine, run, more=()):
        """Runs one side; its outputs are NAME.*. Returns its report."""
        at = self.folder + "/" + name
        words = self.shared + engine + run + list(more) + [
            "--report", at + ".json", "--hdr", at + ".hdr.####.exr", "--layer",
            at + ".layer.####.exr", "-o", at + ".out.####." + self.ending,
            "-f", "1-%d" % self.count, self.folder + "/in.####.exr"]
        p = self.call(words, name)
        if p.returncode == 5 and "point sprites of" in p.stderr:
            raise Refused
        if p.returncode:
            raise Fault("%s: status %d: %s" %
                        (name, p.returncode, p.stderr.strip()[-300:]))
        with open(at + ".json") as f:
            return [json.loads(line) for line in f], p.stderr

    def compare(self, what, *limits):
        """Rows of `glarepp compare`, direct being the first image."""
        at, end = self.folder, self.ending if what == "out" else "exr"
        p = self.call(["compare", "--no-flip", "--json", "-", *limits,
                       "-f", "1-%d" % self.count, "%s/b.%s.####.%s" % (at, what, end),
                       "%s/a.%s.####.%s" % (at, what, end)], "compare")
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

    def read(self, i):
        """Reads all outputs of frame i; the largest magnitudes of direct's."""
        peaks = {}
        for name in "ab":
            for what, end in (("hdr", "exr"), ("layer", "exr"),
                              ("out", self.ending)):
                path = "%s/%s.%s.%04d.%s" % (self.folder, name, what, i + 1, end)
                buf = oiio.ImageBuf(path)
                px = buf.get_pixels(oiio.FLOAT)
                if buf.has_error or px is None or not px.size:
                    raise Fault("read %s: %s" % (path, buf.geterror()))
                spec, f = buf.spec(), self.frames[i]
                if what != "out" and (spec.x, spec.y, spec.width, spec.height) \
                        != (*f["at"], f["w"], f["h"]):
                    raise Fault("read %s: another data window" % path)
                px = px[..., [c in "RGBY" for c in spec.channelnames]] \
                    if what == "layer" else px
                if what == "layer" and not np.isfinite(px).all():
                    raise Fault("read %s: not finite" % path)
                px = np.abs(px[np.isfinite(px)])
                peaks[what] = float(px.max()) if px.size else 0.0
        return peaks

    def check_layer(self, rows, a, b, said):
        step = HALF if self.option("--type") == "half" else FLOAT
        for i, row in enumerate(rows):
            bounds = [o[i].get("bound", 0.0) for o in (a, b)]
            self.engines[a[i]["engine"]] += 1
            if None in bounds:
                continue  # a kernel with lobes: the engine says no bound
            allowed = sum(bounds) / max(1 - bounds[1], 0.1) * 1.0001 + FLOAT
            if step == HALF:  # of each value, and of denormal halves
                allowed += HALF
                self.half(row, allowed, i)
            else:
                self.hold("layer", row["rel_l2"], allowed)
            tolerance = self.tolerance()
            if tolerance is not None and a[i]["engine"] != "none" and \
                    "tolerance" not in said:  # which the warning names
                self.hold("bound", bounds[0], tolerance * (1 + 1e-6))
            if "measured" in a[i]:
                self.hold("verify", a[i]["measured"]["rel_l2"], bounds[0])

    def half(self, row, allowed, i):
        """Denormal halves round by a fixed step; compare gives the norm by
        the root mean square of all values."""
        values = 3 * self.frames[i]["w"] * self.frames[i]["h"]
        floor = 6e-8 * values ** 0.5
        norm = row["rms"] * values ** 0.5
        if row["rel_l2"] and norm > floor:
            self.hold("layer", row["rel_l2"],
                      allowed + row["rel_l2"] * floor / norm)

    def tolerance(self):
        if self.engine[1] != "auto":
            return None
        return float(self.engine[self.engine.index("--tolerance") + 1])

    def check_hdr(self, layer):
        gain = float(self.option("-g"))
        step = HALF if self.option("--type") == "half" else FLOAT
        rows = self.compare("hdr", "--fail", "0")
        for i, row in enumerate(rows):
            peak = max(self.peaks[i]["hdr"], gain * self.peaks[i]["layer"])
            self.hold("hdr", row["max"], gain * layer[i]["max"] * 1.001 +
                      step * peak + 1e-37)

    def check_pictures(self):
        """Where each value of hdr agrees, pictures are a code value apart."""
        fine = self.option("--depth-bits") == "16"
        near = "1e-6" if fine else "1e-4"
        hdr = self.compare("hdr", "--fail", "1e-30", "--failrelative", near,
                           "--warn", "1e38")
        step = 1 / (65535 if fine else 255)
        whole = self.ending in ("png", "tif")
        for i, row in enumerate(self.compare("out")):
            if hdr[i]["status"] == 0 and whole:
                self.hold("picture", row["max"], step * 1.01)
                self.pictures += 1

    def check_again(self):
        self.make("c", self.engine, self.runs[2])
        for path in sorted(glob.glob(self.folder + "/a.*.*.*")):
            other = re.sub(r"/a\.([^/]*)$", r"/c.\1", path)
            if not filecmp.cmp(path, other, False):
                raise Fault("again: %s and %s differ" % (path, other))

    def check(self):
        a, said = self.make("a", self.engine, self.runs[0],
                            ["--verify"] if self.verify else [])
        b, _ = self.make("b", ["--engine", "direct"], self.runs[1])
        self.peaks = [self.read(i) for i in range(self.count)]
        if len(a) != self.count or len(b) != self.count:
            raise Fault("report: %d and %d lines" % (len(a), len(b)))
        rows = self.compare("layer")
        # (what a half file cannot hold is cut there, and no longer the layer)
        cut = any("clamped_out" in o for o in a + b)
        if cut or self.option("--compression") in options.LOSSY:
            self.compare("hdr")
        else:
            self.check_layer(rows, a, b, said)
            self.check_hdr(rows)
            self.check_pictures()
        if self.again:
            self.check_again()


def soak(o, number):
    """One case: (frames, worst of each check, engines, pictures, fault)."""
    folder = os.path.join(o.folder, str(number))
    shutil.rmtree(folder, ignore_errors=True)
    case = Case(o.program, number, o.seed, folder, not o.no_gl)
    fault = None
    try:
        case.check()
    except Refused:
        case.engines["refused"] += case.count
    except Fault as e:
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
    started, number, done, faults, pictures = time.monotonic(), 0, 0, 0, 0
    worst, engines = {}, collections.Counter()
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
                pictures += case.pictures
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
    print("%d pictures within one code value" % pictures)
    print("%d faults" % faults)
    sys.exit(1 if faults else 0)


main()
