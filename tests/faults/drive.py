#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fails one call after another of a small run, and looks at what is left.

usage: drive.py PROGRAM SHIM all|CONFIGURATION...

Prints lines "ok ..." and "not ok ..." for lib.sh's verdicts. In the working
folder lie the inputs; each run has a folder of its own. env
GLAREPP_TEST_QUICK takes only some of the points (but with FAULT_MANY),
GLAREPP_TEST_LONG all of all configurations, FAULT_ONLY one row of KINDS, and
FAULT_RUN is put before the program (valgrind); status 99 means that it found
something.
"""
import concurrent.futures
import json
import os
import shutil
import signal
import subprocess
import sys

QUICK = bool(os.environ.get("GLAREPP_TEST_QUICK")) and \
    not os.environ.get("FAULT_MANY")
LONG = bool(os.environ.get("GLAREPP_TEST_LONG"))
RUNNER = os.environ.get("FAULT_RUN", "").split()
SECONDS = 120 if RUNNER else 30  # a run that takes longer hangs
STOP = 99   # of FAULT_RUN
AT_ONCE = 2
INPUTS = ("in.exr", "lights.json", "lamp.gltf", "flare.json", "c.ocio",
          "s.0001.exr", "s.0002.exr", "s.0003.exr", "parts.exr", "views.exr")

FILES = "-o o/a.png --hdr o/h.exr --report o/r.json --debug sensors=o/s.exr"
ONE = f"--threads 1 {FILES} in.exr"
# (arguments, more statuses that a full memory may end with: a library that
# cannot be loaded is 3, a GL context that cannot be made 5; share of points
# that an ordinary run takes: 0 none, 3 each third. Start, reader, engine and
# writers of most are those of "direct", half of whose allocations fail; what only
# the library calls fails in tests/unit/api/fail_nth.c)
CONFIGURATIONS = {
    "direct": (f"-e direct {ONE}", (), 2),
    "fft": (f"-e fft --layer o/l.exr {ONE}", (3,), 16),
    "auto": (f"{ONE}", (3,), 0),
    "sun": (f"-e direct --sun 12,8,3 --sun-color 9,8,7 --flare flare.json "
            f"--lights lights.json --debug sunmap=o/m.exr {ONE}", (), 0),
    "kernel": (f"-e direct -k in.exr --rotate 10 --verify {ONE}", (), 0),
    "threads": (f"-e fft --threads 3 {FILES} in.exr", (3,), 0),
    "old": (f"-e direct {ONE}", (), 12),
    "pipe": ("-e direct --threads 1 --hdr - --stdout-format exr -", (), 24),
    "raw": ("-e direct --threads 1 --raw rgb24 -o - s.####.exr", (), 24),
    "sequence": ("-e direct --threads 1 --skip-bad-frames -o o/a.#.png "
                 "--hdr o/h.#.exr --report o/r.json s.####.exr", (6,), 48),
    "splat": (f"-e splat --projection plane --gl osmesa {ONE}", (3, 5), 160),
    "readback": (f"-e direct --gl osmesa --sun 12,8,3 --sun-color 9,8,7 "
                 f"--sun-method readback --flare flare.json {ONE}", (3, 5), 0),
    "ocio": ("-e direct --ocio c.ocio --view Power -o o/a.png in.exr", (3,),
             48),
    "parts": ("-e direct --threads 1 --compression piz --hdr o/h.exr "
              "--layer o/l.exr --sun 12,8,3 --depth depth.Z parts.exr", (), 24),
    "views": ("-e direct --threads 1 --hdr o/h.exr "
              "-o o/%V.pfm --light-group key --sun 12,8,3 --sun-color 9,8,7 "
              "--mask-file in.exr --mask A views.exr", (), 32),
    "b44": ("-e direct --threads 2 --compression b44 --type half "
            "--hdr o/h.exr --layer o/l.exr in.exr", (), 16),
    "large": ("-e direct --threads 1 --compression none --type float "
              "--hdr o/h.exr big.exr", (), 1),
    "scene": ("-e direct --threads 1 --scene lamp.gltf --light-scale 1 "
              "--layer o/l.exr in.exr", (), 0),
    "flight": ("-e direct --threads 3 --frame-jobs 3 -o o/a.#.png "
               "--hdr o/h.#.exr s.####.exr", (), 1),
    "bridge": ("-e direct --threads 1 --compression dwaa --hdr o/h.exr "
               "-o o/a.jpg in.exr", (3,), 48),
}
# beginnings of lines about no file: the command line, or all frames
NO_FILE = ("glarepp: command line: ", "glarepp: --")
CHANGES = ("truncate", "grow")
BY_SIGNAL = (-signal.SIGTERM,)
# for one fault each: files larger than the buffer, and several threads at them
TERMINATED = ("direct", "sequence", "flight")
ALONE = {"large": "write:N:EINTR", "flight": "term:N"}
# "direct" over files that are there: the faults that can reach those
OVER_FILES = ("open", "close", "rename", "unlink", "fchmod", "ftruncate",
              "fdopen", "space", "write")
# the libraries of these take 100 ms and more to start: the faults that can find
# them at work, as all others come in the reader and the writers of "direct"
COSTLY = ("bridge", "splat")
AT_WORK = ("malloc:N", "malloc:N+", "open:N", "close:N", "rename:N",
           "ftruncate:N", "space:N")
# a library inside that ends the process when memory is full, in its own words
BY_LIBRARY = {"ocio": -signal.SIGABRT}
# a second error of a call takes the branches of the first: these two are all that
# an ordinary run tries it in
OTHER_ERRORS = ("open:N:EMFILE", "space:N:EDQUOT")
TWO_ERRORS = ("direct", "sequence")
# llvmpipe waits for ever for a thread that could not start
BY_MESA = ("splat", "readback")
# (fault, statuses that are right); N is put in
KINDS = (
    ("malloc:N", (0, 70)),
    ("malloc:N+", (0, 70)),
    ("open:N", (0, 3)),
    ("open:N:EMFILE", (0, 3)),
    ("close:N", (0, 3)),
    ("rename:N", (3,)),
    ("unlink:N", (0, 3)),
    ("fchmod:N", (0, 3)),
    ("ftruncate:N", (0, 3)),
    ("fdopen:N", (3, 70)),
    ("read:N", (0, 3)),
    ("read:N:EINTR", (0,)),
    ("short:N", (0,)),
    ("truncate:N", (0, 3, 4)),
    ("grow:N", (0, 3, 4)),
    ("space:N", (3,)),
    ("space:N:EDQUOT", (3,)),
    ("write:N:EINTR", (0,)),
    ("term:N", (-signal.SIGTERM,)),
    ("thread:N", (0,)),
    ("thread:N+", (0,)),
)


def names_of(arguments):
    """The files that a line may name: as given, and those of patterns."""
    yield "stdout"
    for word in arguments.split():
        word = word.split("=")[-1]
        yield word
        for n in (1, 2, 3):
            yield word.replace("####", f"{n:04}").replace("#", str(n))
        for view in ("left", "right"):
            yield word.replace("%V", view)


NAMES = {name: set(names_of(row[0])) for name, row in CONFIGURATIONS.items()}


class Run:
    """What one run left."""

    def __init__(self, name, folder, program, shim, fault):
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder + "/o")
        # only two faults change an input
        put_input = shutil.copy if fault.startswith(CHANGES) else os.link
        for file in INPUTS + ("big.exr",) * (name == "large"):
            put_input(file, folder + "/" + file)
        if name == "old":
            for file in ("a.png", "h.exr", "s.exr"):
                with open(f"{folder}/o/{file}", "w") as f:
                    f.write("old")
        env = dict(os.environ, FAULT=fault, LD_PRELOAD=shim,
                   FAULT_LOG=os.path.abspath(folder) + "/log")
        if RUNNER:
            del env["LD_PRELOAD"]
            env["FAULT_SHIM"] = shim
        arguments = CONFIGURATIONS[name][0].split()
        with open(folder + "/in.exr", "rb") as stdin:
            try:
                p = subprocess.run([*RUNNER, program, *arguments], cwd=folder,
                                   env=env, stdin=stdin, capture_output=True,
                                   timeout=SECONDS)
                self.status, self.out, self.err = p.returncode, p.stdout, p.stderr
            except subprocess.TimeoutExpired:
                self.status, self.out, self.err = "hang", b"", b""
        try:
            log = open(folder + "/log").read().split("\n")
        except OSError:
            log = []
        self.fired = "fired" in log
        self.counts = dict(line.split() for line in log if " " in line)
        self.leaked = int(self.counts.pop("leaked", 0))
        self.files = {}
        for file in sorted(os.listdir(folder + "/o")):
            data = open(f"{folder}/o/{file}", "rb").read()
            self.files[file] = facts(data) if file == "r.json" else data


def facts(data):
    """The report's lines without what differs from run to run."""
    lines = []
    for line in data.split(b"\n")[:-1]:
        try:
            o = json.loads(line)
        except ValueError:
            return "not JSON: " + repr(line[:80])
        for key in ("times_ms", "cpu_ms", "peak_rss_mib", "gl"):
            o.pop(key, None)
        lines.append(o)
    if not data.endswith(b"\n"):
        return "cut: " + repr(data[-40:])
    return lines


def faults_of_stderr(name, run):
    lines = run.err.decode("utf-8", "replace").split("\n")
    if lines.pop() != "":
        yield "stderr does not end its line"
    wrong = [l for l in lines if not l.startswith("glarepp: ")]
    errors = [l for l in lines if not l.startswith("glarepp: warning: ")]
    if wrong:
        yield "stderr has " + repr(wrong[0][:200])
    if run.status == 0 and errors:
        yield "an error without its status: " + repr(errors[0][:200])
    if run.status not in (0, 6) and len(errors) != (run.status not in BY_SIGNAL):
        yield f"{len(errors)} lines of error: " + repr(errors[:3])
    for line in errors:
        if "(0 bytes)" in line:
            yield "nothing is more than there is: " + repr(line[:200])
        if (line + ": ").split(": ")[1] not in NAMES[name] and \
                not line.startswith(NO_FILE):
            yield "no file is named: " + repr(line[:200])


def faults_of_files(name, run, good):
    for file, data in run.files.items():
        if file not in good.files:
            yield f"a file is left: {file}"
        elif file == "r.json" and run.status in BY_SIGNAL and \
                data == facts(b""):
            pass  # no frame was made
        elif file == "r.json":
            # a frame that was left out has its own line
            lines = [o for o in data if "error" not in o] if \
                isinstance(data, list) else [data]
            if any(o not in good.files[file] for o in lines):
                yield f"{file} differs: {str(lines)[:300]}"
        elif data != good.files[file] and not (
                name == "old" and data == b"old" and run.status != 0):
            yield f"{file} is not whole: {len(data)} bytes"
    if run.status == 0 and set(run.files) != set(good.files):
        yield f"status 0 with {sorted(run.files)} alone"
    if run.out != (good.out if run.status == 0
                   else good.out[:len(run.out)]):
        yield f"stdout differs ({len(run.out)} of {len(good.out)} bytes)"


def faults_of_memory(run, good):
    # (arguments and names of outputs last as long as the process)
    if run.leaked > good.leaked:
        yield f"{run.leaked - good.leaked} blocks of memory leak"


def judge(name, run, good, statuses):
    if run.status == "hang":
        return [f"hangs over {SECONDS} s"]
    if RUNNER and run.status == STOP:
        return ["found by " + RUNNER[0] + ": " + run.err.decode()[:1500]]
    found = []
    if run.status == BY_LIBRARY.get(name, 0) and \
            run.status in statuses and b"std::bad_alloc" in run.err:
        return list(faults_of_files(name, run, good))
    if run.status not in statuses:
        found.append(f"status {run.status}: {run.err.decode()[:200]!r}")
    return found + list(faults_of_stderr(name, run)) + \
        list(faults_of_files(name, run, good)) + \
        list(faults_of_memory(run, good))


def points(fault, good, share, arguments):
    """The N to try. Beside single allocations, which are the plainest run's
    all, each fourth will do."""
    kind = fault.split(":")[0]
    share *= 1 if LONG or fault == "malloc:N" else 4
    count = int(good.counts.get(kind, 0))
    if kind == "space":
        # as many bytes as there are cannot all be tried but with time
        stride = 1 if LONG and not RUNNER else max(1, count // 97 * share)
        return sorted({*range(1, count + 1, stride), count} - {0})
    if kind == "write" and not LONG: # of one loop, whatever it writes
        return sorted({*range(1, count + 1, max(1, count // 12)), count} - {0})
    stride = (7 if QUICK else 1) * (1 if LONG else share)
    if RUNNER:
        stride *= 10 if LONG else 200
    if kind not in ("malloc", "read", "short", "truncate", "grow"):
        stride = 1
    # more calls than counted where threads share them
    more = 0 if "--threads 1 " in arguments else count // 4 + 1
    return range(1, count + more + 1, stride)


def put(fault, n):
    return fault.replace(":N", f":{n}")


def try_kind(pool, name, program, shim, fault, statuses, good):
    tried = survived = 0
    notes = []

    def one(n):
        slot = slots.pop()
        try:
            run = Run(name, slot, program, shim, put(fault, n))
        finally:
            slots.append(slot)
        return n, run

    arguments, _, share = CONFIGURATIONS[name]
    slots = [f"slot{i}" for i in range(AT_ONCE)]
    for n, run in pool.map(one, points(fault, good, max(1, share), arguments)):
        if not run.fired and run.status == 0:
            continue
        tried += 1
        found = judge(name, run, good, statuses)
        survived += not found
        notes += [f"{fault.replace('N', str(n))}: {f}" for f in found]
    if not tried:
        return
    print(f"{'' if tried == survived else 'not '}ok {name}, {fault}: "
          f"fault points survived: {survived} of {tried}")
    for note in notes[:int(os.environ.get('FAULT_NOTES', 12))]:
        print("# " + " ".join(note.split("\n")))
    sys.stdout.flush()


def main():
    program, shim, *names = sys.argv[1:]
    only = os.environ.get("FAULT_ONLY")
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        for name in CONFIGURATIONS if names == ["all"] else names:
            arguments, more, share = CONFIGURATIONS[name]
            if names == ["all"] and not share and not LONG:
                continue
            good = Run(name, "good", program, shim, "")
            if good.status or not good.counts:
                print(f"not ok {name}: without a fault: status {good.status} "
                      f"{good.err.decode()[:300]}")
                continue
            for fault, statuses in KINDS:
                if only and fault != only or \
                        ALONE.get(name, fault) != fault or \
                        fault == "term:N" and name not in TERMINATED:
                    continue
                kind = fault.split(":")[0]
                if kind == "thread" and name in BY_MESA or \
                        not LONG and (
                            name == "old" and kind not in OVER_FILES or
                            name in COSTLY and fault not in AT_WORK or
                            fault in OTHER_ERRORS and name not in TWO_ERRORS):
                    continue
                if kind in ("malloc", "open") or 6 in more:
                    statuses = statuses + more
                if kind == "malloc" and name in BY_LIBRARY:
                    statuses = statuses + (BY_LIBRARY[name],)
                try_kind(pool, name, program, shim, fault, statuses, good)


if __name__ == "__main__":
    main()
