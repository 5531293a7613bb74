#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that tests notice what would break: `make mutants`.

Usage: run.py BUILD [WORD...]
       run.py --lines

Each mutant in tests/mutants/*.txt is one change of one line of src/, with the suite
that must fail because of it:

    a share is found in the light's own pixels
    sun/exact src/sun/occluder.c
    - if (share > 1.0)
    + if (share > 2.0)

A suite is ROOM/SUITE of tests/unit, hard/FAMILY of tests/hard, or NAME.t of tests/cli.
The line after "-" is part of one line of the file, and of one only. WORDs choose mutants
whose text has one.

BUILD is copied, so that only what changed is built. A mutant that the suite does not
notice, and one that does not compile, failed. The last line counts both. --lines only
checks that the lines and suites are there.
"""
import glob
import os
import shutil
import subprocess
import sys
import tempfile
import threading

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SECONDS = 300  # of a suite: a mutant may wait for ever
WHOLE = ("library.t", "glare/bound", "hard/glare")  # suites that need more than their quick form


def read_list(path):
    """The mutants of a file: dicts of promise, suite, file, old, new, where."""
    with open(path, encoding="utf-8") as f:
        blocks = [[]]
        for number, line in enumerate(f, 1):
            if line.startswith("#"):
                continue
            if line.strip():
                blocks[-1].append((number, line.rstrip("\n")))
            elif blocks[-1]:
                blocks.append([])
    for block in filter(None, blocks):
        where = f"{os.path.basename(path)}:{block[0][0]}"
        lines = [text for _, text in block]
        if len(lines) != 4 or lines[2][:2] != "- " or lines[3][:2] not in ("+ ", "+"):
            sys.exit(f"{where}: want a promise, 'SUITE FILE', '- OLD' and '+ NEW'")
        suite, file = lines[1].split()
        yield {"promise": lines[0], "suite": suite, "file": file, "where": where,
               "old": lines[2][2:], "new": lines[3][2:]}


def changed(mutant):
    """The file's text with the change, or what is wrong with the mutant."""
    room, _, name = mutant["suite"].rpartition("/")
    if room != "hard" and not os.path.exists(os.path.join(
            ROOT, f"tests/unit/{room}/{name}.c" if room else f"tests/cli/{name}")):
        return None, "its suite is not there"
    with open(os.path.join(ROOT, mutant["file"]), encoding="utf-8") as f:
        lines = f.read().split("\n")
    at = [i for i, line in enumerate(lines) if mutant["old"] in line]
    if len(at) != 1:
        return None, f"its line is there {len(at)} times"
    lines[at[0]] = lines[at[0]].replace(mutant["old"], mutant["new"], 1)
    return "\n".join(lines), ""


class Tree:
    """A copy of the repository and its build, for one mutant after the other."""

    def __init__(self, build):
        self.at = tempfile.mkdtemp(prefix="mutants.")
        for name in ("src", "tests", "examples", "man", "Makefile", "README.md",
                     "LICENSE"):
            path = os.path.join(ROOT, name)
            (shutil.copytree if os.path.isdir(path) else shutil.copy2)(
                path, os.path.join(self.at, name))
        shutil.copytree(build, os.path.join(self.at, "build"), ignore=lambda d, names: [
            n for n in names if n in ("fuzz", "test-logs", "asan", "ubsan", "tsan")])
        data = os.path.join(ROOT, "../shared")
        self.env = dict(os.environ, CMOCKA_MESSAGE_OUTPUT="TAP")
        if os.path.isdir(data):
            self.env.setdefault("GLAREPP_DATA", os.path.join(data, "data"))

    def run(self, command, seconds=SECONDS):
        with open(os.path.join(self.at, "log"), "w", encoding="utf-8") as log:
            process = subprocess.Popen(command, cwd=self.at, env=self.env, stdout=log,
                                       stderr=log, stdin=subprocess.DEVNULL,
                                       start_new_session=True)
            try:
                return process.wait(seconds)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, 9)
                process.wait()
                return -9

    def test(self, suite):
        """Builds what a suite needs, and runs it: 'passed', 'failed' or 'unbuilt'."""
        cli = suite.endswith(".t")
        room, _, name = suite.partition("/")
        target = "build/glarepp" if cli else (
            f"build/tests/{'hardcases' if room == 'hard' else room}")
        if self.run(["make", "-s", target], 600):
            return "unbuilt"
        self.env["GLAREPP"] = os.path.join(self.at, "build/glarepp")
        self.env.pop("GLAREPP_TEST_QUICK", None)
        if suite not in WHOLE:
            self.env["GLAREPP_TEST_QUICK"] = "1"
        status = self.run(["prove", f"tests/cli/{suite}"] if cli else [target, name])
        return "failed" if status else "passed"

    def try_mutant(self, mutant, text):
        """As test(), of the suite with the change."""
        source = os.path.join(self.at, mutant["file"])
        made = os.path.join(self.at, "build", os.path.splitext(
            mutant["file"].removeprefix("src/"))[0] + ".o")
        kept = [(path, path + ".kept") for path in (source, made)
                if os.path.exists(path)]
        for path, copy in kept:
            shutil.copy2(path, copy)
        with open(source, "w", encoding="utf-8") as f:
            f.write(text)
        found = self.test(mutant["suite"])
        for path, copy in kept:
            os.replace(copy, path)
            os.utime(path)
        return found


def main():
    if len(sys.argv) < 2 or not (sys.argv[1] == "--lines" or os.path.isdir(sys.argv[1])):
        print(__doc__)
        sys.exit(sys.argv[1:] != ["--help"])
    mutants = [m for path in sorted(glob.glob(os.path.join(ROOT, "tests/mutants/*.txt")))
               for m in read_list(path)]
    stale = [f"{m['where']}: {changed(m)[1]}" for m in mutants if not changed(m)[0]]
    if stale or sys.argv[1] == "--lines":
        sys.exit("\n".join(stale) or None)
    build, words = os.path.abspath(sys.argv[1]), sys.argv[2:]
    mutants = [m for m in mutants
               if not words or any(w in " ".join(m.values()) for w in words)]
    suites = sorted({m["suite"] for m in mutants})
    tasks = [("suite", s) for s in suites] + [("mutant", m) for m in mutants]
    sound, passed, failed = set(), [], []
    lock, started = threading.Lock(), threading.Barrier(os.cpu_count() or 1)

    def take(kind):
        with lock:
            for i, task in enumerate(tasks):
                if task[0] == kind:
                    return tasks.pop(i)[1]
        return None

    def say(ok, mutant, text):
        with lock:
            (passed if ok else failed).append(mutant)
            print(f"{'ok    ' if ok else 'FAILED'} {mutant['where']} {mutant['suite']}: "
                  f"{mutant['promise']}{text and ': ' + text}", flush=True)

    def work():
        tree = Tree(build)
        while (suite := take("suite")) is not None:
            if tree.test(suite) == "passed":
                sound.add(suite)
        started.wait()
        while (mutant := take("mutant")) is not None:
            text, _ = changed(mutant)
            wrong = "" if mutant["suite"] in sound else "the suite fails without it"
            if not wrong:
                found = tree.try_mutant(mutant, text)
                wrong = {"passed": "nobody noticed", "unbuilt": "does not compile"}.get(
                    found, "")
            say(not wrong, mutant, wrong)
        shutil.rmtree(tree.at)

    threads = [threading.Thread(target=work) for _ in range(os.cpu_count() or 1)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    print(f"{len(passed)} passed, {len(failed)} failed")
    sys.exit(bool(failed))


main()
