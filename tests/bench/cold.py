#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Times whole processes of two builds in turn: one frame from cold, and a
sequence of 48.

Usage: cold.py OLD NEW PLAIN FRAMES [ROUNDS]

OLD, NEW  glarepp
PLAIN     tests/bench/plain.cpp, which makes half ZIP frames
FRAMES    the folder that frames.py fills
ROUNDS    runs of each (9); every second round is in the other order

Prints for each job the least wall and CPU time of NEW over those of OLD, the
bar, and NEW's times, page faults and peak memory. The least of many runs, since
other programs only add time. Needs python3 alone.
"""
import os
import subprocess
import sys
import tempfile
import time

SIZES = "1920", "3840"
COUNT = 48


def jobs(folder, k512):
    """Name, bar of the wall time, arguments."""
    png, exr = ["-o", folder + "/o.png"], ["--hdr", folder + "/o.exr"]
    for size in SIZES:
        for frame in ("w1", "w2", "w3"):
            path = f"{folder}/{frame}_{size}.exr"
            name = f"{frame} {size}"
            yield name + " PNG", 0.75, ["-k", "builtin:eye", *png, path]
            yield name + " EXR", 0.92, ["-k", "builtin:eye", *exr, path]
            yield name + " both, k512", 0.80, ["-k", k512, *exr, *png, path]
    yield f"sequence of {COUNT}, EXR", 0.97, [
        "-k", "builtin:eye", "--hdr", folder + "/o.####.exr", folder + "/s.####.exr"]


def run(command):
    """Wall and CPU seconds, page faults, peak KiB."""
    begin = time.monotonic()
    pid = os.posix_spawn(command[0], command, os.environ)
    status, used = os.wait4(pid, 0)[1:]
    wall = time.monotonic() - begin
    if status:
        sys.exit(f"{' '.join(command)}: status {status}")
    return wall, used.ru_utime + used.ru_stime, used.ru_minflt, used.ru_maxrss


def main():
    builds = [os.path.abspath(p) for p in sys.argv[1:3]]
    plain, frames = sys.argv[3:5]
    rounds = int(sys.argv[5]) if len(sys.argv) > 5 else 9
    with tempfile.TemporaryDirectory() as folder:
        for size in SIZES:
            for frame in ("w1", "w2", "w3"):
                name = f"{frame}_{size}.exr"
                subprocess.check_call([plain, "copy", f"{frames}/{name}",
                                       f"{folder}/{name}", "2"])
        for i in range(COUNT):
            os.symlink(f"w{i % 3 + 1}_1920.exr", f"{folder}/s.{i + 1:04}.exr")
        for name, bar, words in jobs(folder, frames + "/k512.exr"):
            made = {b: [] for b in builds}
            for i in range(rounds):
                for b in builds[::-1] if i % 2 else builds:
                    made[b].append(run([b, "-q", *words]))
            old, new = ([min(column) for column in zip(*made[b])]
                        for b in builds)
            print(f"{name:22} wall {new[0] / old[0]:.3f} (bar {bar:.2f}), CPU "
                  f"{new[1] / old[1]:.3f}; {1e3 * new[0]:.0f} ms, CPU "
                  f"{1e3 * new[1]:.0f} ms, {new[2]} page faults, "
                  f"{new[3] / 1024:.0f} MiB", flush=True)


main()
