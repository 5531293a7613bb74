#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# glarepp bench: a table of speed against error, the same rows as CSV, JSON and
# plot.
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr channels=R,G,B,A lights=40 seed=3
frame kernel.exr kind=kernel size=33x32 type=float
frame dark.exr kind=dark
unset DISPLAY
gl=
"$glarepp" --engine splat --layer gl.exr in.exr 2>/dev/null && gl=yes

techniques='direct
fft
splat
splat group 2
splat group 4
splat group 8
splat group 4, cluster 8
splat group 4, shrink 1e-3
splat 4/8/1e-3
auto'

cat >check.py <<'PY'
"""check.py JSON CSV [extrapolated]: laws of a table, and that both agree."""
import csv
import json
import math
import sys

def verdict(fine, what):
    print(("ok " if fine else "not ok ") + what)

table = json.load(open(sys.argv[1]))
lines = list(csv.DictReader(open(sys.argv[2], newline="")))
raw = open(sys.argv[2], "rb").read()
verdict(raw.endswith(b"\r\n") and raw.count(b"\n") == raw.count(b"\r\n"),
        "CSV: lines end as RFC 4180 asks")
rows = [(f, r) for f in table["frames"] for r in f["rows"]]
verdict(len(rows) == len(lines) > 0, "as many rows in both files")

def cell(value):
    if value is None:
        return "inf"
    if isinstance(value, bool):
        return str(value).lower()
    return value

agree, absent = True, True
for (frame, row), line in zip(rows, lines):
    agree = agree and line["input"] == frame["input"]
    for key, text in line.items():
        if key in ("input", "why"):
            continue
        if key not in row:
            absent = absent and text == ""
            continue
        value = cell(row[key])
        same = (text == value if isinstance(value, str)
                else math.isclose(float(text), value, rel_tol=1e-9))
        agree = agree and same
verdict(agree, "CSV and JSON hold the same")
verdict(absent, "what JSON leaves out is empty in CSV")

ran = [r for _, r in rows if "why" not in r]
verdict(all("ms" not in r for _, r in rows if "why" in r) and
        all("ms" in r for r in ran), "a row has a time, or says why not")
verdict(all(0 < r["ms_min"] <= r["ms"] <= r["ms_max"] for r in ran),
        "the median is between least and most")
verdict(all(abs(r["frames_per_second"] * r["ms"] - 1000) < 20 for r in ran
            if r["ms"] > .05), "frames a second are those of the median")
whole = [r for r in ran if not r["extrapolated"]]
parts = [r for r in ran if r["extrapolated"]]
verdict(all(r["runs"] == table["runs"] for r in whole if r["ms_max"] < 1000),
        "as many runs as were asked for")
verdict(all(r["rel_l2"] < 2e-6 for r in whole
            if r["name"] in ("direct", "fft", "splat")), "exact rows are exact")
verdict(all(r["rel_l2"] < 1e-6 for r in whole if r["name"] in ("direct", "fft")),
        "direct and fft: rel_l2 under 1e-6")
verdict(all(r.get("bound") is None or r["rel_l2"] <= r["bound"] for r in whole),
        "no error is over its bound")
verdict(all(0 <= r["flip"] <= 1 for r in whole), "FLIP is in [0,1]")
verdict(all(r["flip"] < 1e-3 for r in whole if r["rel_l2"] < 1e-6),
        "FLIP sees nothing in exact rows")
front = True
for f in table["frames"]:
    mine = [r for r in f["rows"] if "rel_l2" in r]
    for r in f["rows"]:
        # (times in the files are rounded: two that differ there do differ)
        beaten = any(o["ms"] < r["ms_min"] and o["rel_l2"] <= r["rel_l2"]
                     for o in mine if "rel_l2" in r)
        tied = any(o["ms"] == r.get("ms_min") for o in mine)
        if "rel_l2" not in r and r["pareto"] or \
                "rel_l2" in r and not tied and r["pareto"] == beaten:
            front = False
    front = front and (not mine or any(r["pareto"] for r in mine))
verdict(front, "the Pareto front is the rows that none surely beats")
times = ("ms", "ms_min", "ms_max", "ms_first", "runs", "pareto", "rel_l2", "max_abs", "bound")
autos = [(f, r) for f, r in rows if r["name"] == "auto" and "ms" in r]
verdict(all([o.get(k) for k in times] == [a.get(k) for k in times]
            for f, a in autos for o in f["rows"] if o["name"] == a.get("same_as")),
        "auto has the figures of the row that it is")
verdict(all("same_as" in a or a["engine"] not in
            [o["engine"] for o in f["rows"] if o is not a and "rel_l2" in o]
            for f, a in autos), "auto is the row of its engine")

def best(f, by, within):
    """The time of the fastest row within an error, or None."""
    return min((r["ms"] for r in f["rows"] if r.get(by, within + 1) <= within),
               default=None)

verdict(all(len(f["choices"]) == 12 and
            all(c.get("ms") == best(f, c["by"], c["within"]) and
                ("name" in c) == ("ms" in c) and
                c.get("error", 0) <= c["within"] for c in f["choices"])
            for f in table["frames"]), "the choices are the fastest rows")
verdict(all("rel_l2" not in r and "flip" not in r and not r["pareto"] and
            0 < r["share"] < .3 and r["ms_min"] == r["ms"] == r["ms_max"]
            for r in parts), "extrapolated rows are marked and have no error")
if "extrapolated" in sys.argv:
    verdict(len(parts) > 0, "there is an extrapolated row")
PY

# table JSON: the rows' names
names()
{
    "$python" -c 'import json, sys
for f in json.load(open(sys.argv[1]))["frames"]:
    for r in f["rows"]:
        print(r["name"])' "$1"
}

# -- one frame -----------------------------------------------------------------

run bench --runs 3 -k kernel.exr --csv t.csv --json t.json in.exr
quiet_success 'bench'
is "$(names t.json)" "$techniques" 'every technique has its row'
"$python" check.py t.json t.csv >verdicts 2>&1 || echo 'not ok check.py' >>verdicts
verdicts verdicts
is "$(awk '/^  technique /,/^$/' out | sed '1d' | cut -c 3-28 | sed 's/ *$//' |
    head -10)" "$techniques" 'the table has them in the same order'
like "$(head -1 out)" 'in.exr: 64x48, * sources, kernel kernel.exr 33x32; *' \
    'the table says what was measured'
ok 'the table: a mark on the Pareto front' grep -q '^> ' out
is "$(awk 'length > 140' out | grep -cv '^  auto took')" 0 'no line is too wide'

is "$(grep -c '^  \(rel_l2\|max_rel\|flip\)  *1e-0[1236] ' out)" 12 \
    'the table: the fastest within each error'
"$python" - >verdicts 2>&1 <<'PY' || echo 'not ok whole run' >>verdicts
import json
w = json.load(open("t.json"))["frames"][0]["whole"]
def ok(fine, what): print(("ok " if fine else "not ok ") + what)
out = w["outputs"]
png = [o for o in out if o["format"] == "PNG"]
ok(all(w[k] > 0 for k in ("read_ms", "glare_ms", "tone_ms")),
   "whole run: each step has a time")
ok(len(png) == 13 and len(out) == 23, "whole run: every level and compression")
ok([o["options"] for o in out if o["default"]] ==
   ["--hdr --compression none", "-o --png-level 1"], "whole run: the defaults")
ok(all(o["bytes"] > 0 and o["ms_min"] <= o["ms"] <= o["ms_max"] for o in out
       if "why" not in o), "whole run: times and bytes")
ok(all("why" in o for o in out) is False and png[12]["bytes"] < png[0]["bytes"],
   "whole run: a level packs")
ran = [o for o in out if "why" not in o]
def ahead(o): # by how much another is surely faster, and no larger; ms
    return max([o["ms_min"] - p["ms"] for p in ran if p is not o and
                p["format"] == o["format"] and p["bytes"] <= o["bytes"]],
               default=-1)
# (times are rounded to microseconds, the front is not)
ok(all(ahead(o) <= 0 if o["pareto"] else ahead(o) >= 0 for o in ran),
   "whole run: the front of each format")
PY
verdicts verdicts
# (the input is not compressed) what a row says of bytes is what the job writes
for level in 0 12; do
    "$glarepp" -q -k kernel.exr --no-provenance --png-level $level -o $level.png in.exr
done
is "$("$python" -c 'import json, os
b = {o["options"]: o["bytes"] for o in
     json.load(open("t.json"))["frames"][0]["whole"]["outputs"]}
print(*[os.path.getsize("%d.png" % n) - b["-o --png-level %d" % n] for n in (0, 12)])')" \
    '0 0' 'whole run: the bytes of the files'
ok '--png-level: the same pixels' "$glarepp" compare -q --fail 0 0.png 12.png

no 'an image leaves nothing out that is known' \
    grep -q kernel_left_out out t.json

# the model's light outside the frame, beside the bound and the error
run bench --runs 1 --threshold .5 -k cie:age=70 --csv m.csv --json m.json in.exr
quiet_success 'bench with a model'
"$glarepp" --threshold .5 -k cie:age=70 --report m.report --layer m.exr in.exr \
    >out2 2>err2
"$python" - >verdicts 2>&1 <<'PY' || echo 'not ok kernel_left_out' >>verdicts
import csv, json, re
says = json.load(open("m.report"))["kernel_left_out"]
rows = json.load(open("m.json"))["frames"][0]["rows"]
lines = list(csv.DictReader(open("m.csv", newline="")))
head = re.match(r"in.exr: .*, kernel_left_out (\S+); ", open("out").readline())
def verdict(fine, what):
    print(("ok " if fine else "not ok ") + what)
def is_near(got, by=1e-8):
    return abs(float(got) - says) <= by * says
verdict(says > .01, "the report's kernel_left_out is a share of the light")
verdict(all(is_near(r["kernel_left_out"]) for r in rows), "JSON has the same")
verdict(all(is_near(r["kernel_left_out"]) for r in lines), "CSV has the same")
verdict(head and is_near(head[1], .005), "the table's head has the same")
mine = {r["name"]: r for r in rows}
verdict(all(0 < mine[n]["rel_l2"] <= mine[n]["bound"] < 1e-3 for n in ("levels", "auto")),
        "bound and rel_l2 are beside it")
PY
verdicts verdicts

cp "$root/tests/frames/foliage.1004.exr" camera.exr
"$glarepp" -q -t 8 -k spencer --report c.report --layer c.exr camera.exr
GLAREPP_OSMESA=/nonexistent GLAREPP_EGL=/nonexistent \
    "$glarepp" bench -t 8 --runs 1 -k spencer --json c.json camera.exr >out 2>err
is "$("$python" -c 'import json
r = json.load(open("c.report"))
b = json.load(open("c.json"))["frames"][0]["rows"][0]["kernel_left_out"]
print(r["fov_from"], abs(b - r["kernel_left_out"]) < 1e-8)')" 'camera True' \
    'the angle is that of the frame'"'"'s camera, as in the main job'

frame one.exr seed=3
"$glarepp" kernel -q -k eye --size 64x48 --radius 12 -o small.exr
"$glarepp" -q -k small.exr -e fft --report s.report --layer c.exr one.exr
GLAREPP_OSMESA=/nonexistent GLAREPP_EGL=/nonexistent \
    "$glarepp" bench --runs 1 -k small.exr --json s.json one.exr >out 2>err
is "$("$python" -c 'import json
r = json.load(open("s.report"))
b = json.load(open("s.json"))["frames"][0]["rows"][0]["kernel_left_out"]
print(b > 0.02, abs(b - r["kernel_left_out"]) < 1e-8)')" 'True True' \
    'what a file of glarepp kernel leaves out, as in the main job'

frame move.0005.exr seed=3 attr=framesPerSecond:rational:2,1
"$glarepp" -q --fov 5 -k temporal --report t.report --layer t.exr \
    move.0005.exr
GLAREPP_OSMESA=/nonexistent GLAREPP_EGL=/nonexistent "$glarepp" bench --runs 1 \
    --fov 5 -k temporal --json t2.json move.0005.exr >out 2>err
is "$("$python" -c 'import json
r = json.load(open("t.report"))
b = json.load(open("t2.json"))["frames"][0]["rows"][0]["kernel_left_out"]
print(abs(b / r["kernel_left_out"] - 1) < 1e-8)')" True \
    'a model that moves: at the time of the frame'"'"'s number and rate'

# the truth is the picture's: by true angles, of which a plane's rows are off
"$glarepp" -q -k eye --fov 90 --report e.report --layer e.exr in.exr
for options in '' '--projection plane'; do
    GLAREPP_OSMESA=/nonexistent GLAREPP_EGL=/nonexistent \
        "$glarepp" bench --runs 1 -k eye --fov 90 $options --json a.json in.exr >out 2>err
    "$python" - $options >verdicts 2>&1 <<'PY' || echo 'not ok true angles' >>verdicts
import json, sys
f = json.load(open("a.json"))["frames"][0]
r = {r["name"].split(",")[0]: r for r in f["rows"]}
chosen = {(c["by"], c["within"]): c.get("name", "") for c in f["choices"]}
a, b = r["auto"], r.get("plane") or r["fft"]
def verdict(fine, what):
    print(("ok " if fine else "not ok ") + what)
if len(sys.argv) > 1:
    verdict("levels" not in r and b["rel_l2"] < 1e-6 and "bound" in b,
            "on a plane: a plane is exact")
else:
    taken = json.load(open("e.report"))["engine"]
    verdict(a["engine"] == taken and a["rel_l2"] <= a["bound"] < 1e-3, "auto is what a run takes")
    verdict(b["rel_l2"] > .03 and 20 * a["rel_l2"] < b["rel_l2"] and "bound" not in b,
            "a plane leaves an error that it does not bound")
    verdict(b["options"] == "-e fft --projection plane" and
            r["levels"]["options"] == "-e fft --tolerance 0.001", "options make the row")
    verdict(chosen["rel_l2", 1e-3][:6] == chosen["flip", 1e-3][:6] == "levels",
            "within an error is what keeps it")
    exact = r["direct by true angles"]
    verdict(chosen["rel_l2", 1e-6] == exact["name"] and
            exact["options"] == "-e direct --tolerance 0.001" and
            exact["rel_l2"] <= exact["bound"], "within 1e-6, the sum itself")
    rough = r["levels 1e-2"]
    verdict(rough["options"] == "-e fft --tolerance 0.01" and rough["rel_l2"] > 2 * a["rel_l2"] and
            rough["rel_l2"] <= rough["bound"] < 1e-2, "one weight a node is a row")
PY
    verdicts verdicts
done
GLAREPP_OSMESA=/nonexistent GLAREPP_EGL=/nonexistent \
    "$glarepp" bench --runs 1 --tolerance 0.01 --json a.json --plot a.svg camera.exr >out 2>err
is "$("$python" -c 'import json
print(json.load(open("a.json"))["frames"][0]["rows"][-1].get("same_as"))'
    grep -c '>levels 1e-2, auto<' a.svg)" 'levels 1e-2
1' '--tolerance 0.01: auto is the row of one weight a node, and one point'
run bench --runs 1 -k kernel.exr --json - in.exr
ok '--json -: stdout is JSON alone' "$python" -m json.tool out
run bench --runs 1 -k kernel.exr --csv - in.exr
like "$(head -1 out)" 'input,name,options,ms,*' '--csv -: stdout is CSV alone'
is "$(wc -l <out)" 11 '--csv -: a line for each row'
run bench --runs 1 -k kernel.exr --tonemap none --json n.json in.exr
no '--tonemap none: no FLIP' grep -q '"flip":' n.json
run bench -v --runs 1 -k kernel.exr in.exr
is "$(grep -c '^glarepp: ' err)" 10 '-v: a line for each row'
run bench --runs 1 -k kernel.exr - <in.exr
like "$(head -1 out)" '-: 64x48*' 'a frame from stdin'
cp in.exr 'a,"b".exr'
run bench --runs 1 -k kernel.exr --csv q.csv --json q.json 'a,"b".exr'
is "$("$python" -c 'import csv, json
print(list(csv.DictReader(open("q.csv", newline="")))[0]["input"],
      json.load(open("q.json"))["frames"][0]["input"])')" \
    'a,"b".exr a,"b".exr' 'a file name with a comma and quotes'
# the word is the command, a path is a file
cp in.exr bench
run -q --engine direct -k kernel.exr -o bench.png ./bench
quiet_success './bench is a file'

run bench --runs 1 --csv d.csv --json d.json dark.exr
quiet_success 'a dark frame is a success'
is "$(grep -c 'no pixel is over the threshold' out)" 10 \
    'a dark frame: every row says so'

# -- long rows -------------------------------------------------------------------

# every pixel is a source: seconds for direct, of which a tenth is run; minutes
# in the builds of a quick run
long_rows()
{
    # (767x511 and 511x511 pixels, none of them 0)
    "$glarepp" kernel -q -k spencer --size 384x256 -o all.exr
    "$glarepp" kernel -q -k spencer --size 256x256 -o wide.exr
    GLAREPP_OSMESA=/nonexistent GLAREPP_EGL=/nonexistent "$glarepp" bench \
        -t 0 --runs 1 --threads 1 -k wide.exr --csv x.csv --json x.json \
        all.exr >out 2>err
    status=$?
    quiet_success 'a frame with too many sources'
    "$python" check.py x.json x.csv extrapolated >verdicts 2>&1 ||
        echo 'not ok check.py' >>verdicts
    verdicts verdicts
    ok 'the table: extrapolated rows have a star' \
        grep -q '^  direct  *[0-9.]*\*' out
}
if [ -z "$quick" ]; then long_rows; else skip 3 'quick'; fi

# -- missing frames and programs ---------------------------------------------------

GLAREPP_OSMESA=/nonexistent GLAREPP_EGL=/nonexistent \
    "$glarepp" bench --runs 1 -k kernel.exr --json g.json in.exr >out 2>err
status=$?
quiet_success 'no GL is no error of bench'
is "$("$python" -c 'import json
rows = json.load(open("g.json"))["frames"][0]["rows"]
print(all(("why" in r) == r["name"].startswith("splat") for r in rows),
      all(len(r["why"]) > 10 for r in rows if "why" in r))')" 'True True' \
    'no GL: the rows of splat say why'
is "$(grep -c '^  splat.* cannot run: .*nonexistent' out)" 7 \
    'no GL: the table says why'

run bench --runs 1 -k kernel.exr --plot p.svg in.exr
quiet_success '--plot'
ok '--plot: a valid SVG with a label for each row that has an error' \
    "$python" -c 'import json, xml.dom.minidom
d = xml.dom.minidom.parse("p.svg")
assert d.documentElement.tagName == "svg"
words = " ".join(n.firstChild.data for n in d.getElementsByTagName("text"))
rows = json.load(open("t.json"))["frames"][0]["rows"]
assert all(r["name"] in words for r in rows if "rel_l2" in r)
assert "Pareto front" in words and "rel_l2" in words'
run bench --runs 1 --plot d.svg dark.exr
quiet_success '--plot of a dark frame'
mkdir plots
run bench --runs 1 --plot plots/p.png in.exr
fails_with 2 plots/p.png '--plot with an ending that is not SVG'
is "$(wc -c <out)" 0 '--plot with a wrong ending: found out before any work'
empty_folder plots '--plot with a wrong ending: no file'

# -- the paper's frames --------------------------------------------------------------

# fewer sources and no GL: a matter of seconds
paper()
{
    if [ -z "${GLAREPP_TEST_LONG-}" ] || [ -z "$gl" ]; then
        GLAREPP_OSMESA=/nonexistent GLAREPP_EGL=/nonexistent \
            "$glarepp" bench --paper -t 17 --runs 1 "$@" >out 2>err
    else
        "$glarepp" bench --paper --runs 1 "$@" >out 2>err
    fi
    status=$?
}
paper --json paper.json --csv paper.csv
quiet_success '--paper'
"$python" check.py paper.json paper.csv >verdicts 2>&1 ||
    echo 'not ok check.py' >>verdicts
verdicts verdicts
is "$("$python" -c 'import json
for f in json.load(open("paper.json"))["frames"]:
    print(f["input"], f["width"], f["height"], f["kernel"],
          f["paper"]["rate"], f["paper"]["frames_per_second"])')" \
    'points 1024 768 streaks best 120
windows 1024 768 streaks average 60
sky 1024 768 streaks worst 40' '--paper: three frames, beside the paper'"'"'s rates'
is "$(grep -c 'beside the .* of the paper' out)" 3 '--paper: the table says so'

# -- refusals --------------------------------------------------------------------------

run bench
fails_with 2 bench 'no input'

run bench --threads 1,2 in.exr
fails_with 2 --threads 'several numbers of threads'
run bench in.exr dark.exr
fails_with 2 dark.exr 'two inputs'
run bench --paper in.exr
fails_with 2 in.exr '--paper with an input'
run bench --runs 0 in.exr
fails_with 2 --runs 'no runs'
run bench --runs 2.5 in.exr
fails_with 2 --runs 'half a run'
run bench -o out.png in.exr
fails_with 2 -o 'a picture from bench'
run --runs 3 -o out.png in.exr
fails_with 2 --runs 'runs without bench'
# layers of --flare and --lens are rows of the same table
cat >flare.json <<'JSON'
[{"source": "bright", "shape": "disc", "position": 0.4, "size": 0.2},
 {"source": "bright", "shape": "ring", "position": 1.7, "size": 0.3}]
JSON
run bench --runs 1 -k kernel.exr --flare flare.json --lens tessar --fov 20 \
    --json layers.json in.exr
is "$status" 0 'bench with flare and lens'
is "$("$python" -c 'import json
rows = json.load(open("layers.json"))["frames"][0]["rows"]
flare, many, few = (r for r in rows if r["options"][:3] in ("--f", "--l"))
print(0 < flare["rel_l2"] <= min(1e-6, flare["bound"]), 0 < many["rel_l2"] < 0.1,
      0 < few["rel_l2"] < 0.1, "bound" in few,
      all(r["ms"] > 0 for r in (flare, many, few)))')" \
    'True True True False True' 'each near its own truth'
frame camera.exr size=32x24 lights=5 \
    attr=worldToNDC:m44f:0.5,0,0,0,0,-0.5,0,0,0.5,0.5,1,1,0,0,-1,0
run bench --runs 1 -k kernel.exr --lens tessar --json - camera.exr
is "$status" 0 'bench with a lens on a frame that has a camera'
echo '{"frames": [{"frame": 1, "worldToNDC_blender_colvec":
    [0.5, 0, -0.5, 0, 0, -0.5, -0.5, 0, 0, 0, -1, 0, 0, 0, -1, 0]}]}' >plain.json
run bench --runs 1 -k kernel.exr --camera plain.json --json plain.out camera.exr
is "$status" 0 'bench with a camera and without a sun'
run bench --camera plain.json --sun-size 0.5 camera.exr
fails_with 4 plain.json 'bench with a size of no sun'
run bench --flare flare.json --sun 3,3 in.exr
fails_with 2 --flare 'bench of flare with a light'
run bench --csv - --json - in.exr
fails_with 2 - 'two files on stdout'
run bench nowhere.exr
fails_with 3 nowhere.exr 'a frame that is not there'
run bench -k nowhere.exr in.exr
fails_with 3 nowhere.exr 'a kernel that is not there'
run bench --csv nowhere/t.csv in.exr
fails_with 3 nowhere 'a folder that is not there'
if [ -w /dev/full ]; then
    "$glarepp" bench --runs 1 -k kernel.exr in.exr >/dev/full 2>err
    status=$?
    fails_with 3 stdout 'a full disk under stdout'
else
    skip 2 'no /dev/full'
fi

done_testing
