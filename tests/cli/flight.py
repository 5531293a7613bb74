# SPDX-License-Identifier: Apache-2.0
"""Runs a command with many numbers of frames in flight and of threads, and
compares all that comes out of it with one frame on one thread.

usage: flight.py PROGRAM ROWS

ROWS is a file of lines
    NAME | STATUS | HOW | ARGUMENTS
HOW: `all` numbers of both, or `few`; `stdin=FILE` goes in by a pipe; `ends=N`:
frame N ends the run, and files of frames behind it are whole or not there;
`alone`: stderr is one line. The command runs in the folder `made`, which starts
as a copy of `start`. Prints a verdict for each row.
"""
import json
import os
import re
import shutil
import subprocess
import sys

PROGRAM, ROWS = sys.argv[1:]
ALL = [(j, t) for j in (1, 2, 3, 7, 64) for t in (1, 2, 3, 8)]
FEW = [(1, 1), (0, 2), (3, 2), (7, 3), (64, 8)]
if not os.environ.get("GLAREPP_TEST_LONG"): # each number of either
    ALL = [(1, 8), (2, 1), (3, 3), (7, 2), (64, 8)]
    FEW = [(0, 2), (7, 3), (64, 8)]
DIFFERS = "times_ms", "cpu_ms", "peak_rss_mib", "threads"
TIMES = re.compile(rb"; (read|total) .* MiB$", re.M)


def plain(path):
    """A file's bytes; a report without what may differ."""
    with open(path, "rb") as f:
        data = f.read()
    if not path.endswith(".json"):
        return data
    out = []
    for line in data.splitlines():
        o = json.loads(line)
        out.append({k: v for k, v in o.items() if k not in DIFFERS})
    return out


def files():
    out = {}
    for folder, _, names in os.walk("."):
        for name in names:
            path = os.path.join(folder, name)
            if not os.path.islink(path): # to a device
                out[path] = plain(path)
    return out


def run(words, how, jobs, threads):
    shutil.rmtree("made", ignore_errors=True)
    if os.path.isdir("start"):
        shutil.copytree("start", "made", symlinks=True)
    else:
        os.mkdir("made")
    os.chdir("made")
    more = ["--threads", str(threads)]
    if jobs:
        more += ["--frame-jobs", str(jobs)]
    given = next((h[6:] for h in how if h.startswith("stdin=")), None)
    p = subprocess.Popen([PROGRAM, *more, *words], stdout=subprocess.PIPE,
                         stderr=subprocess.PIPE, stdin=subprocess.PIPE)
    fed = open("../" + given, "rb").read() if given else None
    try:
        out, err = p.communicate(fed, timeout=60)
    except subprocess.TimeoutExpired:
        p.kill()
        p.communicate()
        os.chdir("..")
        raise SystemExit(f"not ok {words}: does not end with --frame-jobs "
                         f"{jobs} --threads {threads}")
    found = files()
    os.chdir("..")
    return p.returncode, out, TIMES.sub(b"", err), found


def number(path):
    n = re.search(r"\.(\d+)\.\w+$", path)
    return int(n[1]) if n else 0


def faults(want, got, end, whole):
    for i, what in enumerate(("status", "stdout", "stderr")):
        if want[i] != got[i]:
            yield f"{what} {want[i][-300:] if i else want[i]!r}, " \
                  f"then {got[i][-300:] if i else got[i]!r}"
    for path in sorted(set(want[3]) | set(got[3])):
        if os.path.basename(path).startswith("."):
            yield path + " is left"
        elif end and number(path) > end:
            if path in got[3] and got[3][path] != whole[3].get(path):
                yield path + " is not whole"
        elif want[3].get(path) != got[3].get(path):
            yield path + " differs, or is missing"


def try_row(name, status, how, words):
    end = int(next((h[5:] for h in how if h.startswith("ends=")), 0))
    want = run(words, how, 1, 1)
    whole = run(["--skip-bad-frames", *words], how, 1, 1) if end else None
    found = []
    if want[0] != status:
        found.append(f"status {want[0]}: {want[2][-300:]!r}")
    if not want[1] and not want[3]:
        found.append("nothing is made")
    said = [line for line in want[2].split(b"\n") if line and b" warning: " not in line]
    if "alone" in how and len(said) != 1:
        found.append(f"more than a line: {want[2]!r}")
    for jobs, threads in ALL if "all" in how else FEW:
        got = run(words, how, jobs, threads)
        found += [f"--frame-jobs {jobs} --threads {threads}: {f}"
                  for f in faults(want, got, end, whole)]
    print(f"{'not ' if found else ''}ok {name}: {len(want[3])} files, "
          f"{len(want[1])} bytes out, the same for any number in flight")
    for line in found[:8]:
        print("# " + line)


for row in open(ROWS):
    if row.strip():
        name, status, how, words = (f.strip() for f in row.split("|"))
        try_row(name, int(status), how.split(), words.split())
