#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a sequence costs: in one run, in a run for each frame, and beside what
OpenEXR's C++ library takes to decode and encode the same frames.

usage: sequence.py GLAREPP PLAIN FRAMES [COUNT [ROUNDS]]

GLAREPP  the program; exact glare (--engine fft) of builtin:eye
PLAIN    tests/bench/plain.cpp
FRAMES   folder of w1..w3 at 1024, 1920 and 3840, as frames.py makes them
COUNT    frames of a sequence (100), half ZIP, links to the three
ROUNDS   how often the ways take turns (3); medians of each round's ratios

Needs python3 alone.
"""
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time


def measure(commands):
    """Seconds of wall and of CPU that the commands take, one after another."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    for command in commands:
        subprocess.check_call(command)
    wall = time.monotonic() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, (after.ru_utime + after.ru_stime -
                  before.ru_utime - before.ru_stime)


def add(a, b):
    return a[0] + b[0], a[1] + b[1]


def make(plain, frames, folder, width, count):
    """COUNT half ZIP frames: in turn the three of that width."""
    os.makedirs(folder)
    for name in ("w1", "w2", "w3"):
        subprocess.check_call([plain, "copy", f"{frames}/{name}_{width}.exr",
                               f"{folder}/{name}.exr", "2"])
    for i in range(count):
        os.symlink(f"w{i % 3 + 1}.exr", f"{folder}/s.{i + 1:04}.exr")
    os.mkdir(folder + "/out")


def one_run(glarepp, folder, *more):
    return [[glarepp, "-e", "fft", *more, "--hdr", f"{folder}/out/o.####.exr",
             f"{folder}/s.####.exr"]]


def bar(glarepp, plain, folder, count, rounds):
    names = [f"{i + 1:04}" for i in range(count)]
    single = [[glarepp, "-e", "fft", "--hdr", f"{folder}/out/o.{n}.exr",
               f"{folder}/s.{n}.exr"] for n in names]
    peer = [[plain, "copy", f"{folder}/s.{n}.exr", f"{folder}/out/p.exr", "2"]
            for n in names]
    rate, cpu, flight = [], [], []
    half = count // 2
    for _ in range(rounds):
        # a shared machine's speed drifts: half before the sequence, half after
        each, copy = measure(single[:half]), measure(peer[:half])
        seq = measure(one_run(glarepp, folder))
        each = add(each, measure(single[half:]))
        copy = add(copy, measure(peer[half:]))
        alone = measure(one_run(glarepp, folder, "--frame-jobs", "1"))
        rate.append(each[0] / seq[0])
        cpu.append(seq[1] / copy[1])
        flight.append(alone[0] / seq[0])
        for what, t in (("one run", seq), ("one run, --frame-jobs 1", alone),
                        ("a run each", each), ("decode and encode", copy)):
            print(f"  {what:24} {t[0]:7.2f} s, CPU {t[1]:7.2f} s", flush=True)
        print(f"  rate over a run each {rate[-1]:.2f}, CPU over decode and "
              f"encode {cpu[-1]:.2f}, rate over one in flight {flight[-1]:.2f}",
              flush=True)
    print(f"median of {rounds}: rate over a run each "
          f"{statistics.median(rate):.2f} (bar: 1.4 or more), CPU over decode "
          f"and encode {statistics.median(cpu):.2f} (bar: 1.2 or less), rate "
          f"over one in flight {statistics.median(flight):.2f}", flush=True)


def farm(glarepp, folder, width, count):
    """Frames an hour and memory, by frames in flight."""
    for jobs in ("1", "3"):
        report = folder + "/r.json"
        wall, cpu = measure(one_run(glarepp, folder, "--frame-jobs", jobs,
                                    "--report", report))
        with open(report) as f:
            last = json.loads(f.readlines()[-1])
        print(f"{width:5} wide, --frame-jobs {jobs}: "
              f"{3600 * count / wall:7.0f} frames/h here, "
              f"{3600 * count / cpu:7.0f} an hour of one core, "
              f"peak {last['peak_rss_mib']:5.0f} MiB", flush=True)


def main():
    glarepp, plain, frames = sys.argv[1:4]
    count = int(sys.argv[4]) if len(sys.argv) > 4 else 100
    rounds = int(sys.argv[5]) if len(sys.argv) > 5 else 3
    with tempfile.TemporaryDirectory() as tmp:
        print(f"{count} frames 1920x1080, half ZIP to half ZIP, "
              f"{len(os.sched_getaffinity(0))} cores")
        make(plain, frames, tmp + "/bar", 1920, count)
        bar(glarepp, plain, tmp + "/bar", count, rounds)
        few = max(3, count // 8)
        for width in (1024, 1920, 3840):
            folder = f"{tmp}/{width}"
            make(plain, frames, folder, width, few)
            farm(glarepp, folder, width, few)


main()
