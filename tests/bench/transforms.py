#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The transform and the glare stage, measured: all bars in one run.

Usage: transforms.py BUILD FRAMES BEFORE [ROUNDS [PART...]]

BUILD    has glarepp and bench/transform
FRAMES   folder of w1..w3 and k512.exr; frames.py fills it when it is empty
BEFORE   a commit to compare with, which is built in BUILD/before
ROUNDS   runs of each program in turn (5)
PART     lines, stage, plain, dark, bytes, memory, size; all when none is named

Frames are float and are written as half, as 4e-4 of a dark pixel is then the rule.
Stages are wall time of the report's times_ms, the median of the rounds.
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
BUILD, FRAMES, BEFORE = sys.argv[1:4]
ROUNDS = int(sys.argv[4]) if len(sys.argv) > 4 else 5
GLAREPP = os.path.abspath(os.path.join(BUILD, "glarepp"))
K512 = os.path.join(FRAMES, "k512.exr")
SIZES = {1024: (1024, 768), 1920: (1920, 1080), 3840: (3840, 2160)}
KERNELS = ("builtin:eye", K512)


def before():
    """Builds the commit before; returns its program and its tree."""
    tree = os.path.abspath(os.path.join(BUILD, "before"))
    if not os.path.exists(tree):
        subprocess.check_call(["git", "clone", "-q", ROOT, tree])
        subprocess.check_call(["git", "-C", tree, "checkout", "-q", BEFORE])
    subprocess.check_call(["make", "-sC", tree, "-j2", "build/glarepp"],
                          stdout=subprocess.DEVNULL)
    return os.path.join(tree, "build", "glarepp"), tree


def run(program, frame, kernel, *options):
    """Returns the report of one run, a dict for each frame."""
    with tempfile.TemporaryDirectory() as folder:
        report = f"{folder}/r.json"
        subprocess.run([program, "-q", "-e", "fft", "--projection", "plane", "-k",
                        kernel, "--report", report, "--frame-jobs", "1", *options,
                        frame],
                       check=True, cwd=folder)
        with open(report, encoding="utf-8") as rows:
            return [json.loads(row) for row in rows]


def stage_ms(program, frame, kernel):
    """Milliseconds of the glare stage: the first frame's, the least of later."""
    with tempfile.TemporaryDirectory() as folder:
        for i in range(1, 5):
            os.symlink(os.path.abspath(frame), f"{folder}/f.{i:04d}.exr")
        rows = run(program, f"{folder}/f.####.exr", kernel, "--type", "half",
                   "--hdr", f"{folder}/o.####.exr")
    ms = [row["times_ms"]["glare"] for row in rows]
    return ms[0], min(ms[1:])


def cells():
    for size in SIZES:
        for kernel in KERNELS:
            for name in ("w1", "w2", "w3"):
                yield name, size, kernel, f"{FRAMES}/{name}_{size}.exr"


def stage(old):
    print("\n## Glare stage, ms before and now, warm and first\n\n"
          "| frame | kernel | warm | ratio | first | ratio | first / warm |\n"
          "|---|---|---|---|---|---|---|")
    ratios = []
    for name, size, kernel, frame in cells():
        pair = ([], [])
        for _ in range(ROUNDS):
            for program, out in zip((old, GLAREPP), pair):
                out.append(stage_ms(program, frame, kernel))
        (of, ow), (nf, nw) = ([statistics.median(run[i] for run in out)
                               for i in (0, 1)] for out in pair)
        ratios.append(nw / ow)
        print(f"| {name} {size} | {os.path.basename(kernel)} | {ow:.1f}, {nw:.1f}"
              f" | {nw / ow:.2f} | {of:.1f}, {nf:.1f} | {nf / of:.2f} |"
              f" {nf / nw:.2f} |", flush=True)
    print(f"\nwarm: mean {statistics.mean(ratios):.3f}, largest "
          f"{max(ratios):.2f}")


def plain():
    print("\n## Glare stage over plain 2-D FFTW, measured plans, best of four "
          "sizes\n\n| frame | glarepp, ms | FFTW, ms | ratio |\n|---|---|---|---|")
    ratios = []
    for size, (w, h) in SIZES.items():
        ms, best = subprocess.check_output(
            [f"{BUILD}/bench/transform", "plain", str(w), str(h), "512", "2"],
            text=True).split()
        for name in ("w1", "w2", "w3"):
            own = statistics.median(
                stage_ms(GLAREPP, f"{FRAMES}/{name}_{size}.exr", K512)[1]
                for _ in range(ROUNDS))
            ratios.append(own / float(ms))
            print(f"| {name} {size} | {own:.1f} | {ms} ({best}) | "
                  f"{ratios[-1]:.2f} |", flush=True)
    print(f"\nmean {statistics.mean(ratios):.3f}")


def dark():
    print("\n## Largest relative error of a pixel, outputs of half\n\n"
          "| frame | default | k512 |\n|---|---|---|")
    most = 4e6  # pixels: the truth of larger ones takes minutes
    data = os.path.join(ROOT, "..", "shared", "data")
    frames = [f"{FRAMES}/w{i}_{s}.exr" for s in (1024, 1920) for i in (1, 2, 3)]
    for top in (data, os.path.join(ROOT, "examples")):
        for folder, _, names in sorted(os.walk(top)):
            frames += [f"{folder}/{n}" for n in sorted(names)
                       if n.endswith(".exr")]
    worst, refused = 0.0, 0
    for frame in frames:
        row = []
        for kernel in KERNELS:
            try:
                r = run(GLAREPP, frame, kernel, "--type", "half", "--verify",
                        "--max-pixels", str(int(most)), "--hdr", "o.exr")[0]
            except subprocess.CalledProcessError:
                refused += 1
                continue
            error = r.get("measured", {}).get("max_rel", 0.0)
            double = r.get("fft_double", False)
            worst = max(worst, 0.0 if double else error)
            row.append(f"{error:.1e}{' (double)' if double else ''}")
        if row:
            print(f"| {os.path.basename(frame)} | {' | '.join(row)} |", flush=True)
    print(f"\nin float at most {worst:.1e}; {refused} runs refused: not pictures, "
          "or over 4e6 pixels")


def same_bytes():
    print("\n## Bytes of --hdr by threads and by CPU\n")
    digests = set()
    with tempfile.TemporaryDirectory() as folder:
        for threads in range(1, 9):
            for name in ("w1", "w2", "w3"):
                out = f"{folder}/{name}.{threads}.exr"
                run(GLAREPP, f"{FRAMES}/{name}_1024.exr", KERNELS[0],
                    "--threads", str(threads), "--no-provenance", "--hdr", out)
                with open(out, "rb") as f:
                    digests.add((name, f.read()))
    print(f"threads 1 to 8, w1 to w3: {len(digests)} files differ of 24 "
          "(3: none does)")
    subprocess.run([f"{ROOT}/tests/cli/cpu.t", GLAREPP], check=False)


def memory(old):
    print("\n## Peak memory, MiB, before and now\n\n| frame | kernel | before | "
          "now |\n|---|---|---|---|")
    for name, size, kernel, frame in cells():
        rss = [run(p, frame, kernel, "--type", "half", "--hdr", "o.exr",
                   "-o", "o.png")[0]
               ["peak_rss_mib"] for p in (old, GLAREPP)]
        print(f"| {name} {size} | {os.path.basename(kernel)} | {rss[0]:.0f} | "
              f"{rss[1]:.0f} |", flush=True)


def size(tree):
    def lines(top):
        total = 0
        for folder, _, names in os.walk(os.path.join(top, "src")):
            for name in names:
                with open(os.path.join(folder, name), "rb") as f:
                    total += f.read().count(b"\n")
        return total
    was, now = lines(tree), lines(ROOT)
    print(f"\n## Lines in src: {was} before, {now} now, {was - now} fewer")


def main():
    parts = sys.argv[5:] or ["lines", "stage", "plain", "dark", "bytes",
                             "memory", "size"]
    if not os.path.exists(f"{FRAMES}/w3_3840.exr"):
        os.makedirs(FRAMES, exist_ok=True)
        subprocess.check_call(["/usr/bin/python3", f"{HERE}/frames.py", FRAMES])
    old, tree = before()
    if "lines" in parts:
        print("## Lines in the cache\n", flush=True)
        subprocess.check_call([f"{BUILD}/bench/transform", "lines"])
    if "stage" in parts:
        stage(old)
    if "plain" in parts:
        plain()
    if "dark" in parts:
        dark()
    if "bytes" in parts:
        same_bytes()
    if "memory" in parts:
        memory(old)
    if "size" in parts:
        size(tree)


main()
