#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Line and branch coverage of src/, a file and a room, from gcov's counters.

usage: coverage.py [-u] BUILD [FLOOR|ROOM=FLOOR]...

BUILD is a folder built with --coverage -O0 whose tests have run. -u lists the
branches not taken and the lines not run, as FILE:LINE. Ends with status 1
when the branches taken in src/, or in ROOM, are under FLOOR percent.

Counts every branch that gcov reports for a file of src/, C++ bridges included,
except those that only an exception takes. The build uses -O0, so that no branch
is the optimiser's, and makes each function once: no copies for several CPUs
(target_clones), no inlining. A function of a header, which is in several objects,
counts once: its branch is taken if it is taken in any. Code for other CPUs in
#if is not compiled and does not count. A file that no test reached counts as not
taken.
"""
import json
import os
import subprocess
import sys

AT_ONCE = 40  # files a call of gcov


def counter_files(build):
    return sorted(os.path.join(folder, name)
                  for folder, _, names in os.walk(build) for name in names
                  if name.endswith(".gcno"))


def reports(build):
    """gcov's report of each file of counters."""
    paths = [os.path.abspath(p) for p in counter_files(build)
             if os.sep + "tests" + os.sep not in p[len(build):]]
    for i in range(0, len(paths), AT_ONCE):
        out = subprocess.run(
            ["gcov", "--json-format", "--stdout", "--branch-probabilities",
             *paths[i:i + AT_ONCE]],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True)
        for line in out.stdout.splitlines():
            if line.strip():
                yield json.loads(line)


class File:
    def __init__(self):
        self.lines = {}     # line: times run
        self.branches = {}  # (line, how many): times taken of each

    def add(self, line):
        n = line["line_number"]
        self.lines[n] = max(self.lines.get(n, 0), line["count"])
        taken = [b["count"] for b in line["branches"] if not b["throw"]]
        key = n, len(taken)
        had = self.branches.get(key, [0] * len(taken))
        self.branches[key] = [a + b for a, b in zip(had, taken)]

    def sums(self):
        """Lines, lines run, branches, branches taken."""
        taken = [t for b in self.branches.values() for t in b]
        return (len(self.lines), sum(n > 0 for n in self.lines.values()),
                len(taken), sum(t > 0 for t in taken))

    def not_taken(self):
        """(line, what) in order."""
        missing = {n: "not run" for n, count in self.lines.items() if not count}
        for (n, _), taken in self.branches.items():
            if 0 in taken and n not in missing:
                never = [str(i) for i, t in enumerate(taken) if not t]
                missing[n] = f"branch {','.join(never)} of {len(taken)}"
        return sorted(missing.items())


def read(build, root):
    files = {}
    for report in reports(build):
        folder = report["current_working_directory"]
        for f in report["files"]:
            path = os.path.relpath(os.path.join(folder, f["file"]), root)
            if path.startswith("src" + os.sep):
                file = files.setdefault(path, File())
                for line in f["lines"]:
                    file.add(line)
    return dict(sorted(files.items()))


def share(of, n):
    return 100.0 * n / of if of else 100.0


def show(name, s):
    print(f"{name:32} {share(s[2], s[3]):6.2f} % {s[3]:5} of {s[2]:5}   "
          f"{share(s[0], s[1]):6.2f} % {s[1]:5} of {s[0]:5}")


def total(files, room):
    sums = [f.sums() for path, f in files.items()
            if room == "src" or path.split(os.sep)[1] == room]
    return [sum(column) for column in zip(*sums)] or [0] * 4


def main():
    arguments = sys.argv[1:]
    untaken = arguments[:1] == ["-u"]
    build, *floors = arguments[untaken:]
    files = read(build, os.getcwd())
    if not files:
        sys.exit(f"coverage.py: {build}: no counters of src/; "
                 "build and run with --coverage")
    if untaken:
        for path, f in files.items():
            for n, what in f.not_taken():
                print(f"{path}:{n}: {what}")
    print(f"{'':32} {'branches':>24}   {'lines':>24}")
    for path, f in files.items():
        show(path, f.sums())
    print()
    rooms = sorted({path.split(os.sep)[1] for path in files})
    for room in (*rooms, "src"):
        show(room, total(files, room))
    under = 0
    for floor in floors:
        room, least = ("src=" + floor).split("=")[-2:]
        s = total(files, room)
        if share(s[2], s[3]) < float(least):
            print(f"{room}: {share(s[2], s[3]):.2f} % of the branches taken, "
                  f"wanted {least} %")
            under = 1
    sys.exit(under)


if __name__ == "__main__":
    main()
