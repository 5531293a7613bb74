#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs that are killed at random moments: no file under a final name is ever
# incomplete. The moments are drawn from a seed that is printed.
. "$(dirname "$0")/lib.sh"
need_python

times=50
[ -z "$quick" ] || times=8
for n in 01 02 03 04 05 06 07 08 09 10 11 12; do
    frame in.00$n.exr size=160x120 seed=$n lights=40 channels=R,G,B,A,Z:float
done
mkdir good
run -e fft --hdr good/h.####.exr -o good/p.####.png in.####.exr
quiet_success 'the run that nobody kills'

cat >killer.py <<'PY'
"""killer.py PROGRAM TIMES SEED SIGNAL PLACE: one verdict for all of them"""
import filecmp, os, random, shutil, signal, subprocess, sys, time
program, times, seed, name, place = sys.argv[1:]
rng = random.Random(seed + name + place)
end = getattr(signal, "SIG" + name)
FILES = ["--hdr", "m/h.####.exr", "-o", "m/p.####.png"]
ARGUMENTS = {"files": FILES,
             "raw": ["--raw", "rgb24", "-o", "-", "--hdr", "m/h.####.exr"],
             "png": ["--stdout-format", "png", "-o", "-"]}[place]
whole = "" if place == "files" else open(place + ".good", "rb").read()


def as_it_was():
    if end != signal.SIGKILL:
        signal.signal(end, signal.SIG_DFL)


def start():
    shutil.rmtree("m", ignore_errors=True)
    os.mkdir("m")
    out = open("stdout", "wb")
    # sh may have ignored SIGINT, and then so does the program
    return subprocess.Popen([program, "-e", "fft", *ARGUMENTS, "in.####.exr"],
                            stdout=out, stderr=subprocess.PIPE,
                            preexec_fn=as_it_was)


def duration():
    begin = time.monotonic()
    p = start()
    p.communicate()
    return time.monotonic() - begin


def faults(p, err):
    if p.returncode not in (-end, 0):
        yield f"status {p.returncode}"
    if err and p.returncode != 0:
        yield f"says {err[:100]!r}"
    for file in os.listdir("m"):
        if file.startswith("."):
            if end != signal.SIGKILL:
                yield f"{file} is left"
        elif not filecmp.cmp("m/" + file, "good/" + file, shallow=False):
            yield f"{file} is not whole"
    if whole and not whole.startswith(open("stdout", "rb").read()):
        yield "stdout is no beginning of what it should be"


signal.signal(signal.SIGINT, signal.default_int_handler)
took = sorted(duration() for _ in range(3))[1]
found, killed, files, runs = [], 0, 0, 0
# (on a busy machine a run may take less than it did when it was measured)
while runs < int(times) or (3 * killed < int(times) and runs < 3 * int(times)):
    runs += 1
    delay = rng.uniform(0.0, 1.05 * took)
    p = start()
    time.sleep(delay)
    p.send_signal(end)
    try:
        err = p.communicate(timeout=20)[1]
    except subprocess.TimeoutExpired:
        p.kill()
        p.communicate()
        found.append(f"after {delay:.4f} s: does not end")
        continue
    killed += p.returncode == -end
    if p.returncode == 0:  # the machine was busy when it was measured
        took *= 0.9
    files += sum(not f.startswith(".") for f in os.listdir("m"))
    found += [f"after {delay:.4f} s: {f}" for f in faults(p, err)]
print(f"{'not ' if found else ''}ok SIG{name}, {place}, {runs} times: "
      f"ended {killed}, {files} files under final names, {len(found)} faults")
# a test that kills nobody shows nothing; of a few runs, chance may miss all
if int(times) >= 10:
    print(f"{'' if 3 * killed >= int(times) else 'not '}ok SIG{name}, {place}: "
          f"{times} runs or up to three times as many: a third of {times} was under way")
print(f"# seed {seed}, a run takes {took * 1000:.0f} ms")
for line in found[:10]:
    print("# " + line)
PY
"$glarepp" -e fft --raw rgb24 -o - in.####.exr >raw.good
"$glarepp" -e fft --stdout-format png -o - in.####.exr >png.good

seed=${GLAREPP_TEST_SEED-6}
fewer=$((times / 5))
for row in "KILL files $times" "INT files $times" "TERM files $fewer" \
    "HUP files $fewer" "INT raw $fewer" "TERM png $fewer" "KILL raw $fewer"; do
    set -- $row
    "$python" killer.py "$glarepp" $3 "$seed" $1 $2 >verdicts 2>&1
    is $? 0 "SIG$1, $2: tried"
    verdicts verdicts
done

# -- a machine that fails -----------------------------------------------------------

# fsync: of the picture before it is renamed, then of its folder
shim=$(dirname "$glarepp")/tests/shim.so
rm -rf m && mkdir m
if LC_ALL=C grep -qa __asan_init "$glarepp" || [ ! -f "$shim" ]; then
    skip 7 'nothing can be preloaded'
else
    for row in '1 0' '2 1'; do
        set -- $row
        LD_PRELOAD=$shim FAULT=fsync:$1 "$glarepp" -q -e fft --fsync \
            -o m/p.0001.png in.0001.exr >out 2>err
        status=$?
        fails_with 3 m/p.0001.png "fsync $1 fails"
        is "$(ls -A m | wc -l)" "$2" "fsync $1 fails: files"
    done
    LD_PRELOAD=$shim FAULT=fsync:1+ "$glarepp" -q -e fft -o m/p.0001.png \
        in.0001.exr >out 2>err
    is $? 0 'without --fsync none is called'
fi

# The next run ignores files that a killed run left
rm -rf m && mkdir m
run -e fft --hdr m/h.####.exr -o m/p.####.png in.####.exr
quiet_success 'the run after'
ok 'the run after: all files are there and the same' diff -r good m
done_testing
