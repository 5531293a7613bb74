#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that two builds of glarepp make the same bytes.

Usage: same_bytes.py OLD NEW [DATA [PATTERN]]

OLD and NEW are programs, DATA a folder of frames (else GLAREPP_DATA, else
../shared/data beside the repository); the examples are always used. PATTERN
chooses runs whose arguments contain it. Each frame goes through both programs to
--hdr, --layer and -o, two also through every engine, light, layer option
and output format, compare and bench; statuses, messages, outputs and the
report's fields are compared; of PNG the chunks and the rows, not how they are
packed. Prints the differences, and exits 1 if there is one.
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import zlib
from concurrent.futures import ThreadPoolExecutor

OLD, NEW = (os.path.abspath(p) for p in sys.argv[1:3])
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(
    os.path.abspath(__file__))))
DATA = os.path.abspath(
    sys.argv[3] if len(sys.argv) > 3 and sys.argv[3] else
    os.environ.get("GLAREPP_DATA", os.path.join(ROOT, "../shared/data")))
PATTERN = sys.argv[4] if len(sys.argv) > 4 else ""
# fields of the report that differ from run to run or build to build
VARIES = {"times_ms", "cpu_ms", "peak_rss_mib", "version", "threads", "engine_why"}
EXAMPLES = os.path.join(ROOT, "examples")
FRAMES = os.path.join(ROOT, "tests/frames")

# Options and outputs for tests/frames/foliage.1004.exr (colour, depth) and
# tests/frames/night.1001.exr
SUN = ["--sun", "415,93,2.5", "--sun-color", "2e6,1.9e6,1.6e6"]
MANY = [
    *(["-e", e, "--layer", "l.exr", "--hdr", "h.exr"]
      for e in ("direct", "fft", "splat")),
    *(["-k", f"builtin:{k}", "-t", "2", "--layer", "l.exr"]
      for k in ("star", "streak", "cross", "circle", "ring")),
    ["-e", "splat", "--group", "1", "--cluster", "0", "--shrink", "0",
     "--layer", "l.exr"],
    ["-k", "builtin:star", "--rotate", "15", "--layer", "l.exr"],
    ["--threshold-mode", "whole", "--knee", "0.5", "-g", "0.4", "--hdr", "h.exr"],
    *(SUN + ["--sun-method", m, "--flare", FRAMES + "/flare.json",
             "--hdr", "h.exr", "-o", "p.png"]
      for m in ("exact", "mask", "readback")),
    *(["--tonemap", t, "--exposure", "1", "-o", "p.png", "-o", "p.exr"]
      for t in ("reinhard", "reinhard-extended", "aces", "hable", "agx",
                "neutral", "linear", "none")),
    ["--auto-exposure", "--depth-bits", "16", "--dither", "-o", "p.png"],
    *(["-o", "p." + end] for end in ("tif", "dpx", "jpg", "bmp", "ppm", "hdr",
                                     "sgi", "tga", "webp", "pfm")),
    *(["--compression", c, "--hdr", "h.exr"]
      for c in ("none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a",
                "dwaa", "dwab")),
    ["--type", "float", "--hdr", "h.exr"],
    ["--debug", "sensors=s.png", "--debug", "polygons=q.png", "-e", "splat",
     "-o", "p.png"],
    ["--raw", "rgb48le", "-o", "p.raw"],
]
# formats that OLD makes of the night frame and both read
OTHER = ["a.tif", "a.dpx", "a.jpg", "a.bmp", "a.ppm", "a.hdr", "a.sgi",
         "a.tga", "a.webp", "a.pfm", "a.png"]


def content(path):
    """The bytes of a file; of a PNG its chunks, with its rows unpacked."""
    with open(path, "rb") as f:
        data = f.read()
    if not data.startswith(b"\x89PNG"):
        return data
    at, chunks, rows = 8, [], b""
    while at < len(data):
        end = at + 8 + int.from_bytes(data[at:at + 4], "big")
        if data[at + 4:at + 8] == b"IDAT":
            rows += data[at + 8:end]
        else:
            chunks.append(data[at + 4:end])
        at = end + 4
    return chunks, zlib.decompress(rows)


def run(program, folder, args):
    os.makedirs(folder)
    try:
        p = subprocess.run([program, *args], cwd=folder, timeout=300,
                           capture_output=True, stdin=subprocess.DEVNULL)
        return p.returncode, p.stdout, p.stderr.decode(errors="replace")
    except subprocess.TimeoutExpired:
        return -1, b"", "no end in 300 s"


def fields(folder):
    path = os.path.join(folder, "r.json")
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as f:
        return [{k: v for k, v in json.loads(line).items() if k not in VARIES}
                for line in f]


def different(work, number, args, keep=()):
    """Lists the differences between both programs' outputs."""
    folders = [os.path.join(work, f"{number}.{which}") for which in "ab"]
    old, new = (run(p, f, args) for p, f in zip((OLD, NEW), folders))
    found = []
    if old[0] != new[0]:
        found.append(f"status {old[0]}, {new[0]} ({new[2].strip()[:150]})")
    elif old[2] != new[2]:
        found.append(f"message '{old[2].strip()[:150]}', "
                     f"'{new[2].strip()[:150]}'")
    if "bench" in args or "compare" in args:
        def shape(text):  # names of fields; times differ
            try:
                return sorted({k for row in json.loads(text)["techniques"]
                               for k in row})
            except (ValueError, KeyError, TypeError):
                return text if "compare" in args else None
        if shape(old[1]) != shape(new[1]):
            found.append("what it prints")
    elif old[1] != new[1]:
        found.append("stdout")
    a, b = fields(folders[0]), fields(folders[1])
    if a is not None and b is not None and a != b:
        for x, y in zip(a, b):
            for mine, other in ((x, y), (y, x)):  # settings that both have
                mine["settings"] = {k: v for k, v in
                                    mine.get("settings", {}).items()
                                    if k in other.get("settings", {})}
            found += [f"report's {k}: {str(x.get(k))[:60]}, "
                      f"{str(y.get(k))[:60]}"
                      for k in sorted(set(x) | set(y)) if x.get(k) != y.get(k)]
    names = sorted(set(os.listdir(folders[0])) | set(os.listdir(folders[1])))
    for name in names:
        if name == "r.json":
            continue
        both = [os.path.join(f, name) for f in folders]
        if not all(map(os.path.exists, both)):
            found.append(f"{name} is only in one")
            continue
        if content(both[0]) != content(both[1]):
            found.append(name)
    for f in folders:
        if not keep:
            shutil.rmtree(f)
    return found


def main():
    work = tempfile.mkdtemp(prefix="same_bytes.")
    frames = sorted(os.path.join(d, n) for d, _, names in os.walk(DATA)
                    for n in names if not n.endswith((".json", ".md", ".txt")))
    frames += sorted(os.path.join(d, n) for d in (EXAMPLES, FRAMES)
                     for n in os.listdir(d) if n.endswith(".exr"))
    foliage = os.path.join(FRAMES, "foliage.1004.exr")
    night = os.path.join(FRAMES, "night.1001.exr")
    tasks = [["--hdr", "h.exr", "--layer", "l.exr", "-o", "p.png",
              "--report", "r.json", f] for f in frames]
    made = os.path.join(work, "made")
    run(OLD, made, [x for n in OTHER for x in ("-o", n)] + [night])
    for options in MANY:
        for frame in (foliage, night):
            tasks.append([*options, "--report", "r.json", frame])
    for name in OTHER:
        tasks.append(["--hdr", "h.exr", "--report", "r.json",
                      os.path.join(made, name)])
        tasks.append(["-k", os.path.join(made, name), "--layer", "l.exr", "-e",
                      "fft", foliage])
        tasks.append(["compare", os.path.join(made, name),
                      os.path.join(made, "a.png")])
    tasks.append(["compare", foliage, foliage.replace("1004", "1007")])
    tasks.append(["bench", "--json", "--runs", "1", foliage])
    tasks = [t for t in tasks if PATTERN in " ".join(t)]
    count = 0
    try:
        with ThreadPoolExecutor(2) as pool:
            jobs = [pool.submit(different, work, i, t)
                    for i, t in enumerate(tasks)]
            for task, job in zip(tasks, jobs):
                found = job.result()
                count += bool(found)
                if found:
                    print("glarepp", " ".join(task))
                    print("    " + "; ".join(found), flush=True)
    finally:
        shutil.rmtree(work)
    print(f"{len(tasks)} runs, {count} differ")
    return count > 0


sys.exit(main())
