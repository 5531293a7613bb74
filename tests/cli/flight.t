#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Frames in flight: files, report, messages and streams are the same for any
# number of them and of threads, whatever fails on the way.
# shellcheck disable=SC2016
. "$(dirname "$0")/lib.sh"
need_python

# rows HOW...: runs flight.py over the rows of stdin
rows()
{
    cat >rows
    "$python" "$cli/flight.py" "$glarepp" rows >verdicts 2>&1
    is $? 0 "$1: tried"
    verdicts verdicts
}

# -- a sequence ----------------------------------------------------------------

# sizes that change, a dark frame, one bad frame in the middle, NaN, one pixel
mkdir in
frame in/s.0001.exr size=96x64 seed=1 channels=R,G,B,A,Z:float
frame in/s.0002.exr size=161x97 seed=2 type=float channels=R,G,B,A,Z:float
frame in/s.0003.exr size=96x64 kind=dark channels=R,G,B,A,Z:float
frame in/s.0004.exr size=57x131 seed=4 origin=-20,9 display=0,0,95,63 \
    channels=R,G,B,A,Z:float
frame in/s.0005.exr size=96x64 seed=5 lights=400 channels=R,G,B,A,Z:float
frame in/s.0007.exr size=1x1 hot=90 channels=R,G,B,A,Z:float
frame in/s.0008.exr size=96x64 kind=nan channels=R,G,B,A,Z:float
frame in/s.0009.exr size=96x64 seed=9 hot=1e6 type=float \
    channels=R,G,B,A,Z:float
for n in 10 11 12 13 14 15 16 17; do
    frame in/s.00$n.exr size=64x48 seed=$n channels=R,G,B,A,Z:float
done
head -c 3000 in/s.0001.exr >in/s.0006.exr
cat in/s.0001.exr in/s.0003.exr in/s.0002.exr in/s.0005.exr in/s.0004.exr >four
cat in/s.0001.exr in/s.0003.exr in/s.0006.exr >cut

good=1-5,7-17
many="--hdr h.####.exr -o p.####.png -o q.####.exr --layer l.####.exr --report r.json -v"
rows 'a sequence' <<ROWS
all outputs | 0 | all | -f $good $many ../in/s.####.exr
bad frames skipped | 6 | all | --skip-bad-frames $many ../in/s.####.exr
the first bad frame ends the run | 4 | all ends=6 | $many ../in/s.####.exr
no frame behind it is heard of | 4 | all ends=6 alone | --hdr h.####.exr ../in/s.####.exr
EXR to stdout | 0 | all | -f $good --hdr - --report r.json ../in/s.####.exr
PNG to stdout | 0 | few | -f $good --stdout-format png -o - -v ../in/s.####.exr
raw to stdout | 0 | few | -f 10-17 --raw rgb48le -o - --hdr h.####.exr ../in/s.####.exr
raw of sizes that change | 4 | few ends=2 | -f 1-2,10-17 --raw rgb24 -o - ../in/s.####.exr
the layer alone | 0 | few | -f $good --layer l.####.exr --report r.json ../in/s.####.exr
stdin | 0 | all stdin=four | $many -
stdin, cut off | 4 | few stdin=cut ends=3 | $many -
stdin to stdout | 0 | few stdin=four | --hdr - -
sums of engines | 0 | few | -f $good --engine direct --verify $many ../in/s.####.exr
backwards | 0 | few | -f 17-7,5-1 --engine fft $many ../in/s.####.exr
ROWS

# -- state by frame, and shared state ------------------------------------------

cat >lights.json <<'JSON'
[{"pixel": [30.5, 20.25], "radius": 4, "depth": 30, "flux": 5000, "name": "a"},
 {"pixel": [60, 12], "radius": 9, "flux": [900, 100, 4000]},
 {"pixel": [5, 44], "radius": 0.5, "depth": 60, "flux": 2000}]
JSON
cat >flare.json <<'JSON'
[{"shape": "polygon", "position": 1.5, "size": 0.3},
 {"shape": "disc", "position": 0.4, "size": 0.1, "color": [0.1, 0.02, 0.2]}]
JSON
cp "$cli/c.ocio" . || exit 1
sun='--sun 40,30,6 --sun-color 3000,2500,900'
rows 'lights and colours' <<ROWS
a sun and lamps behind depth | 0 | all | -f $good $sun --lights ../lights.json --flare ../flare.json --sun-method exact $many ../in/s.####.exr
a mask, bad frames skipped | 6 | few | --skip-bad-frames --mask A $sun --sun-method exact $many ../in/s.####.exr
OCIO, one output space | 0 | all | --ocio ../c.ocio --output-space turned -f $good $many ../in/s.####.exr
pictures by the bridge | 0 | few | -f $good -o t.####.tif -o j.####.jpg ../in/s.####.exr
ROWS
if "$glarepp" -q -e splat --projection plane --layer gl.exr in/s.0001.exr 2>gl.log; then
    rows 'GL on one thread' <<ROWS
splat | 0 | few | -e splat --projection plane -f $good $many ../in/s.####.exr
splat, bad frames skipped | 6 | few | -e splat --projection plane --skip-bad-frames $many ../in/s.####.exr
lights by mask | 0 | few | -f $good $sun --lights ../lights.json --flare ../flare.json --sun-method mask --mask A --debug sunmap=m.####.png $many ../in/s.####.exr
lights read back | 0 | few | -f $good $sun --lights ../lights.json --sun-method readback $many ../in/s.####.exr
ROWS
else
    skip 5 'no GL here'
fi

# -- outputs that cannot be written --------------------------------------------

mkdir start start/h.0009.exr
ln -s /dev/full start/p.0012.png
rows 'targets that fail' <<ROWS
a folder in the way, skipped | 6 | all | -f $good --skip-bad-frames $many ../in/s.####.exr
a folder in the way ends it | 3 | all ends=9 alone | -f $good --hdr h.####.exr ../in/s.####.exr
a full disk ends it | 3 | few ends=12 alone | -f $good -o p.####.png ../in/s.####.exr
read and written ones, skipped | 6 | few | --skip-bad-frames $many ../in/s.####.exr
ROWS
rm -r start

# -- going on ------------------------------------------------------------------

mkdir start
(cd start && "$glarepp" -f 1-4,12 --hdr h.####.exr -o p.####.png \
    ../in/s.####.exr && rm p.0003.png && cp h.0001.exr h.0002.exr)
rows 'resumed' <<ROWS
--no-clobber | 0 | all | --no-clobber -f $good --hdr h.####.exr -o p.####.png --report r.json -v ../in/s.####.exr
--no-clobber, bad frames skipped | 6 | few | --no-clobber --skip-bad-frames --hdr h.####.exr -o p.####.png --report r.json ../in/s.####.exr
ROWS
is "$(cmp made/h.0001.exr made/h.0002.exr && echo same)" same \
    'what is there is left alone'
ok 'half of a set is made anew' test -s made/p.0003.png
rm -r start

# -- interrupted ---------------------------------------------------------------

cat >interrupt.py <<'PY'
import os, random, shutil, signal, subprocess, sys, time
program, times = sys.argv[1], int(sys.argv[2])
rng = random.Random(7)
words = [program, "-q", "--frame-jobs", "7", "--threads", "4", "-e", "direct", "-f",
         "1-5,7-17", "--compression", "zip", "--hdr", "made/h.####.exr", "-o",
         "made/p.####.png", "in/s.####.exr"]

def start():
    shutil.rmtree("made", ignore_errors=True)
    os.mkdir("made")
    return subprocess.Popen(words, stderr=subprocess.PIPE, preexec_fn=lambda:
                            signal.signal(signal.SIGINT, signal.SIG_DFL))

begin = time.monotonic()
start().communicate()
took, found, ended, tries = time.monotonic() - begin, [], 0, 0
while ended < times and tries < 10 * times:
    p, tries = start(), tries + 1
    time.sleep(rng.uniform(0.1, 0.9) * took)
    p.send_signal(signal.SIGINT)
    try:
        err = p.communicate(timeout=20)[1]
    except subprocess.TimeoutExpired:
        p.kill()
        p.communicate()
        found.append("does not end")
        break
    ended += p.returncode == -signal.SIGINT
    if p.returncode not in (0, -signal.SIGINT) or err:
        found.append(f"status {p.returncode}: {err[-200:]!r}")
    found += [f for f in os.listdir("made") if f.startswith(".")]
print(f"{'not ' if found or ended < times else ''}ok interrupted {ended} times "
      "with seven frames in flight: no file is left, the signal ends it")
for line in found[:5]:
    print("# " + line)
PY
times=8
[ -z "$quick" ] || times=4
"$python" interrupt.py "$glarepp" $times >verdicts 2>&1
is $? 0 'interrupted: tried'
verdicts verdicts

# -- memory --------------------------------------------------------------------

if sanitized; then
    skip 4 'a sanitizer takes memory of its own'
    done_testing
    exit
fi
count=300
frame small.exr size=320x180 seed=3 dim=0.5
mkdir long
for n in $(seq -f %04.0f $count); do
    ln -s ../small.exr "long/s.$n.exr"
done
# One frame in flight: the peak at the end is that of the hundredth frame within
# 0.3 MiB, the pages which the kernel counts late. Several: it rises until their
# largest moments have met, which is chance, and never over what the man page says
# a frame takes, 60 bytes a pixel.
cat >flat.py <<'PY'
import json, subprocess, sys
program, count, some = sys.argv[1], int(sys.argv[2]), 150

def peaks(jobs, count):
    subprocess.run([program, "--frame-jobs", str(jobs), "--threads", "2",
                    "--raw", "rgb24", "-o", "-", "--report", "r.json",
                    "-f", f"1-{count}", "long/s.####.exr"], stdout=subprocess.DEVNULL,
                   check=True)
    peak = [json.loads(line)["peak_rss_mib"] for line in open("r.json")]
    assert len(peak) == count, len(peak)
    return peak

one = peaks(1, count)
print(f"{'' if one[-1] <= one[99] + 0.3 else 'not '}ok {count} frames, one in "
      f"flight: {one[99]:.1f} MiB at frame 100, {one[-1]:.1f} at the end")
for jobs in (3, 7):
    peak = peaks(jobs, some)
    most = one[some - 1] + (jobs - 1) * 60 * 320 * 180 / 2**20
    print(f"{'' if peak[-1] <= most else 'not '}ok {some} frames, {jobs} in "
          f"flight: {peak[99]:.1f} MiB at frame 100, {peak[-1]:.1f} at the end, "
          f"of {most:.1f} that they may take")
PY
"$python" flat.py "$glarepp" $count >verdicts 2>&1
is $? 0 'memory: tried'
verdicts verdicts

# The memory that a frame is believed to take, by which --frame-jobs finds how
# many fit, is the peak within 1.3, with other channels too. Small frames that
# grow are fast to make.
# Frames in flight take half of the memory at most. The second line shows that
# the frames would take more if they were let: in one of three runs, as on a busy
# machine three frames may not meet.
three_of()
{
    for run in 1 2 3; do
        "$1" --frame-jobs 3
    done | sort -g | tail -n 1
}
guarded()
{
    "$glarepp" -q --threads 2 --grow 900 -e direct -k k9.exr -o 'g.#.exr' \
        --hdr 'g.h.#.exr' --type float --compression none --report g.json \
        "$@" 'few.#.exr' && "$python" -c 'import json
print(max(json.loads(n)["peak_rss_mib"] for n in open("g.json")))'
}
frame k9.exr kind=kernel size=9x9
for n in 1 2 3; do
    frame few.$n.exr size=8x8 lights=9
done
if sanitized; then
    skip 2 'a sanitizer takes memory of its own'
else
    one=$(guarded --frame-jobs 1)
    three=$(three_of guarded)
    limited=$( (ulimit -v 350000 && guarded))
    note "peaks: $one MiB of one frame, $three of three, $limited where 350 MB are allowed"
    ok 'memory: ulimit -v allows one frame in flight' \
        "$python" -c "exit(not $limited < 1.1 * $one)"
    ok 'memory: three would take more' \
        "$python" -c "exit(not $three > 1.2 * $one)"
    rm -f g.*.exr
fi

# The kernel and its transforms, which all frames share, take of that half too.
wide()
{
    "$glarepp" -q --threads 2 --grow 700 -e fft -k k301.exr --kernel-size 700 \
        --hdr 'g.h.#.exr' --type float --compression none --report g.json \
        "$@" 'few.#.exr' && "$python" -c 'import json
print(max(json.loads(n)["peak_rss_mib"] for n in open("g.json")))'
}
frame k301.exr kind=kernel size=301x301
if sanitized; then
    skip 2 'a sanitizer takes memory of its own'
else
    one=$(wide --frame-jobs 1)
    three=$(three_of wide)
    limited=$( (ulimit -v 350000 && wide))
    note "peaks with a wide kernel: $one MiB of one frame, $three of three, $limited where 350 MB are allowed"
    ok 'memory: ulimit -v allows one frame beside a wide kernel' \
        "$python" -c "exit(not $limited < 1.1 * $one)"
    ok 'memory: three would take more beside it' \
        "$python" -c "exit(not $three > 1.2 * $one)"
    rm -f g.*.exr
fi

many=$(seq -s , -f 'c%02.0f.X:float' 20)
frame many.exr size=8x8 lights=9 "channels=R,G,B,$many"
frame few.exr size=8x8 lights=9
cat >believed.py <<'PY'
import json, subprocess, sys
# a sun fills the frame with sources, for all of an engine's memory
sun = ["--sun", "4,4,700", "--sun-color", "1e9,1e9,1e9"]
for name in "few", "many":
    for files in ("--hdr h.exr", "-o o.png -e fft",
                  "--hdr h.exr -o o.exr --layer l.exr"):
        subprocess.run([sys.argv[1], "--frame-jobs", "1", "--threads", "2",
                        *sun, *files.split(), "-q", "--grow", "900",
                        "--report", "r.json", name + ".exr"], check=True)
        o = json.load(open("r.json"))
        believed, peak = o["frame_mib"], o["peak_rss_mib"]
        fits = believed / 1.3 < peak < believed * 1.3
        print(f"{'' if fits else 'not '}ok memory of {name} channels, {files}: "
              f"{peak:.0f} MiB, believed {believed}")
PY
if sanitized; then
    skip 6 'a sanitizer takes memory of its own'
else
    "$python" believed.py "$glarepp" >verdicts 2>&1
    verdicts verdicts
fi

# A frame's memory is that of the frames before: its pages are there already
frame many.exr size=400x250 lights=40
for i in $(seq 100 123); do
    ln -s many.exr page.$i.exr
done
cat >pages.py <<'PY'
import resource, subprocess, sys

def faults(program, last, *files):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_minflt
    subprocess.run([program, "-q", "--threads", "2", "-f", f"100-{last}",
                    *files, "page.#.exr"], check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_minflt - before

for files in ("--hdr", "h.#.exr"), ("-o", "o.#.png"):
    few = faults(sys.argv[1], 107, *files)
    more = (faults(sys.argv[1], 123, *files) - few) / 16
    print(f"{'' if more < 20 else 'not '}ok {files[1]}: {more:.0f} page faults "
          f"a frame after {few} of the first eight")
PY
if sanitized; then
    skip 2 'a sanitizer takes memory of its own'
else
    "$python" pages.py "$glarepp" >verdicts 2>&1
    verdicts verdicts
fi

# A frame by itself, or the last one, keeps no spectrum of its kernel: each
# channel's is made when it is needed. The kernel has an even side, so that its
# spectra are complex and three.
frame lone.1.exr size=8x8 lights=9
ln -s lone.1.exr lone.2.exr
frame k64.exr kind=kernel size=64x64
first_peak()
{
    "$glarepp" -q --threads 2 --frame-jobs 1 --grow 900 -e fft -k k64.exr \
        --sun 4,4,700 --sun-color 1e9,1e9,1e9 --hdr 'l.#.exr' \
        --report lone.json -f "$1" 'lone.#.exr' &&
        "$python" -c 'import json
print(json.loads(open("lone.json").readline())["peak_rss_mib"])'
}
if sanitized; then
    skip 1 'a sanitizer takes memory of its own'
else
    alone=$(first_peak 1)
    other=$(first_peak 1-2)
    note "peaks: $alone MiB of one frame, $other of the first of two"
    ok 'memory: one frame keeps no spectrum' \
        "$python" -c "exit(not $alone < 0.92 * $other)"
fi

done_testing
