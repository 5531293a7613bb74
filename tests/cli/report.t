#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Reports and messages: the report's fields, -q, -v, --progress, --help,
# --version.
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr channels=R,G,B,A,Z:float seed=3
frame dark.exr kind=dark
frame shot.0001.exr seed=1
frame shot.0002.exr seed=2 size=40x30

# -- fields --------------------------------------------------------------------

run -k builtin:eye --projection plane --engine fft --verify -o out.png --hdr out.exr \
    --report r.json in.exr
quiet_success '--report'
is "$(wc -l <r.json)" 1 'one line a frame'
is "$(field r.json 'list(o)')" "['input', 'outputs', 'style', 'command', 'width', 'height', 'window', \
'engine', 'engine_why', 'threshold', 'sources', 'fft_size', 'flux_in', 'deg_per_pixel', \
'fov_from', 'projection', 'kernel', 'kernel_left_out', 'flux_out', 'bound', 'measured', 'nonfinite', \
'clamped', 'veil', 'depth', 'times_ms', 'cpu_ms', 'frame_mib', 'peak_rss_mib', 'threads', 'settings', 'warnings', 'status', 'version', \
'schema']" 'the fields of an fft run'
is "$(field r.json 'o["input"], o["outputs"]')" \
    "('in.exr', ['out.exr', 'out.png'])" 'input and outputs'
is "$(field r.json 'o["width"], o["height"]')" '(64, 48)' 'width and height'
is "$(field r.json 'o["engine"], o["sources"] > 0')" "('fft', True)" 'engine'
is "$(field r.json 'sorted(o["measured"])')" \
    "['flux_error', 'max_abs', 'max_rel', 'off', 'pixels', 'rel_l2']" 'measured'
is "$(field r.json '0 < o["measured"]["rel_l2"] <= o["bound"] < 1e-3')" True \
    'measured is within the bound'
is "$(field r.json 'o["depth"]')" "{'channel': 'Z', 'type': 'float'}" 'depth'
is "$(field r.json 'list(o["times_ms"])')" "['read', 'sensors', 'kernel', \
'glare', 'compose', 'tonemap', 'write', 'total']" 'times'
is "$(field r.json 'abs(sum(o["times_ms"].values()) - 2 * o["times_ms"]["total"]) < 0.02')" \
    True 'times add up to the total'
is "$(field r.json 'list(o["cpu_ms"]) == list(o["times_ms"])[:-1] and all(v >= 0 for v in o["cpu_ms"].values())')" \
    True 'CPU time of each stage'
run --threads 1 --report one.json -o out.png in.exr
is "$(field one.json 'all(o["cpu_ms"][k] <= 1.1 * v + 1 for k, v in o["times_ms"].items() if k != "total")')" \
    True 'CPU time of one thread is no more than the wall time'
is "$(field r.json 'all(0 < b <= a * 1.00001 for a, b in zip(o["flux_in"], o["flux_out"]))')" \
    True 'no more light comes out than goes in'
is "$(field r.json 'len(o["fft_size"]), o["nonfinite"], o["clamped"]')" \
    '(2, 0, 0)' 'counts'
cat >heavy.py <<'PY'
import json, subprocess, sys
ballast = bytearray(300 << 20)
line = subprocess.run([sys.argv[1], "-q", "-o", "heavy.png", "--report", "-",
                       "in.exr"], check=True, capture_output=True).stdout
exit(not 1 < json.loads(line)["peak_rss_mib"] < 250)
PY
if sanitized; then
    skip 1 'a sanitizer takes memory of its own'
else
    ok 'the memory of a program that starts this one is not counted' \
        "$python" heavy.py "$glarepp"
fi
is "$(field r.json 'o["peak_rss_mib"] > 1 and o["threads"] >= 1')" True 'costs'
is "$(field r.json 'o["version"]')" \
    "$("$glarepp" --version | sed -n '1s/^glarepp //p')" 'version'

is "$(field r.json 'o["schema"], o["status"], o["warnings"]')" '(2, 0, [])' \
    'schema, status and warnings'

# settings: what was given, defaults, and nothing that had no effect
frame k.exr kind=kernel size=9x9
run -t 2.5 -g 0.3 -k k.exr --kernel-center 3,4 --no-provenance --threads 1 -o out.png \
    --report r.json in.exr
is "$(field r.json '[o["settings"][k] for k in ("threshold", "gain", "kernel", "kernel_center", "engine", "tolerance", "depth_bits", "tonemap")]')" \
    "[2.5, 0.3, ['k.exr'], [3.0, 4.0], 'auto', 0.001, 8, 'neutral']" \
    'settings: given and default'
is "$(field r.json '{"knee", "mix", "rotate"} - set(o["settings"])')" 'set()' \
    'settings: all of light'
is "$(field r.json '{"threads", "output", "no_provenance", "report", "layer_in", "sun_map", "sun_method", "ocio"} & set(o["settings"])')" \
    'set()' 'settings: none that did nothing, or changes no pixel'
run -e direct --tonemap agx --no-dither -o out.png --report r.json in.exr
is "$(field r.json '[o["settings"].get(k) for k in ("dither", "no_dither")]')" \
    '[None, True]' 'settings: one of two words for one thing'
is "$(field r.json '[k in o["settings"] for k in ("tolerance", "group", "white")], o["settings"]["engine"], o["settings"]["tonemap"]')" \
    "([False, False, False], 'direct', 'agx')" 'settings: those of what ran'

# the lines that were said of a frame, and how it went
frame flat.exr
run --sun 5,5 --sun-color 9 -o out.png --report r.json flat.exr
is "$(field r.json '["glarepp: warning: " + w for w in o["warnings"]], o["status"]')" \
    "(['$(cat err)'], 0)" 'warnings: the line that was printed'
run -q -o out.png --report r.json dark.exr
quiet_success '-q: no warning'
like "$(field r.json 'o["warnings"]')" "*'dark.exr: no pixel is over *" \
    'but in the report'
cp dark.exr fade.1.exr
cp in.exr fade.2.exr
run -o 'fade.#.png' --report r.json 'fade.#.exr'
quiet_success 'one frame of two is dark'
is "$(grep -c '"warnings":\["fade.1.exr: no pixel is over' r.json)" 1 \
    'the report says of which frame'
cp flat.exr bad.0001.exr
head -c 900 flat.exr >bad.0002.exr
run --skip-bad-frames -o 'bad.####.png' --report r.json 'bad.####.exr'
is "$(sed 1d r.json >r2.json; field r2.json 'o["status"], o["schema"], o["warnings"], o["version"] != ""')" \
    '(4, 2, [], True)' 'a frame that failed: its exit status'

# the layer, part and view that were taken
frame many.exr channels=diffuse.R,diffuse.G,diffuse.B,spec.R,spec.G,spec.B \
    part=other:Z:float
run --layer-in spec -o out.png --report r.json many.exr
is "$(field r.json 'o["part"], o["layer"], "view" in o')" "('rgba', 'spec', False)" \
    'part and layer'
run -o out.png --report r.json many.exr
is "$(field r.json 'o["part"], o["layer"]')" "('rgba', 'diffuse')" \
    'part and layer that nobody asked for'

run --engine direct --layer l.exr --report r.json in.exr
is "$(field r.json '[k in o for k in ("fft_size", "measured", "gl", "polygons", "frame")]')" \
    '[False, False, False, False, False]' 'what was not needed is left out'
is "$(field r.json '[k in o["times_ms"] for k in ("compose", "tonemap")]')" \
    '[False, False]' 'times of what did not run are left out'
run --engine splat --projection plane --group 1 --cluster 0 --shrink 0 --layer l.exr \
    --report r.json in.exr
if [ $status = 0 ]; then
    is "$(field r.json 'o["engine"], o["polygons"] == o["sources"], o["polygon_pixels"] > 0, len(o["gl"]) > 0')" \
        "('splat', True, True, True)" 'the fields of a splat run'
    run --engine splat --projection plane --group 8 --cluster 16 --cluster-fill 0.1 --layer l.exr \
        --report r.json -v in.exr
    is "$(field r.json 'o["groups"] + o.get("clusters", 0) == o["polygons"] < o["sources"], len(o["form"]) > 0, "bound" in o')" \
        '(True, True, True)' 'the fields of a grouped splat run'
    like "$(cat err)" '*engine splat (--engine) on *' '-v: the engine, and where it drew'
else
    fails_with 5 '' 'no GL here'
    skip 1 'no GL'
fi
run -o out.png --report r.json dark.exr
status_is 0 'a dark frame is a success'
like "$(cat err)" '*dark.exr: *threshold 1 (*0.689 at 25,28)*' \
    'a dark frame: one line'
is "$(field r.json 'o["engine"], o["sources"], o["flux_in"], "bound" in o')" \
    "('none', 0, [0.0, 0.0, 0.0], False)" 'the fields of a dark frame'
frame hot.exr kind=zeros size=9x9 type=float hot=1e6
run -o out.png --max-value 65504 --report r.json hot.exr
is "$(field r.json 'o["clamped"], o["nonfinite"], o["sources"]')" '(1, 0, 1)' \
    'a value over --max-value is counted'
is "$(field r.json 'o["flux_clamped"]')" '[934496.0, 934496.0, 934496.0]' \
    'light that --max-value takes is in the report'
like "$(cat err)" '*hot.exr: the limit of values *93.4 %*; raise --max-value*' \
    'a warning: much light is taken'
run -q -o out.png --max-value 991000 --report r.json hot.exr
is "$(field r.json 'o["warnings"]')" '[]' '0.9 % of the light: no warning'
run -q -o out.png --max-value 989000 --report r.json hot.exr
is "$(field r.json 'o["warnings"][0][:40], o["warnings"][0][-36:]')" \
    "('hot.exr: the limit of values removes 1.1', '; raise --max-value, or leave it out')" \
    '1.1 % of the light: a warning'
run -o out.png --report r.json hot.exr
is "$(field r.json 'o["clamped"], "flux_clamped" in o')" '(0, False)' \
    'no value is changed without --max-value'
frame nan.exr kind=nan size=9x9 type=float
run -o out.png -t 0.01 --report r.json nan.exr
is "$(field r.json 'o["nonfinite"]')" 1 'a NaN is counted'
run --max-value 1e7 --type half --hdr h.exr --report r.json hot.exr
is "$(field r.json 'o["clamped_out"] > 0')" True \
    'what half cannot hold is counted'

run --report r.json -o 'o.####.png' 'shot.####.exr'
ok 'a sequence: a valid line a frame' "$python" -c 'import json
lines = [json.loads(line) for line in open("r.json")]
assert [o["frame"] for o in lines] == [1, 2]
assert [o["width"] for o in lines] == [64, 40]
assert lines[1]["outputs"] == ["o.0002.png"]'
name=$(printf 'b\303\244d "q\\\377.exr')
cp in.exr "$name"
run --report r.json -o out.png "$name"
is "$(field r.json '"b\u00e4d \"q\\" in o["input"]')" True \
    'any file name makes valid JSON'
run --report - in.exr
is "$(field out 'o["engine"] in ("direct", "fft", "levels", "splat")')" True \
    'the report alone, on stdout'
echo 'what was there' >old.json
run --report old.json -o out.png nowhere.exr
is "$(cat old.json)" 'what was there' 'a failed run leaves an old report'
run --report new.json -o out.png nowhere.exr
no 'a failed run leaves no empty report' test -e new.json

# -- other locales -------------------------------------------------------------

# a locale with a decimal comma, made here where the system has none
comma=
if LC_ALL=de_DE.UTF-8 sh -c 'printf %.1f 1,5' >/dev/null 2>&1; then
    comma=de_DE.UTF-8
elif command -v localedef >/dev/null &&
    localedef -i de_DE -f UTF-8 ./de_DE.UTF-8 >/dev/null 2>&1; then
    export LOCPATH=$tmp
    comma=de_DE.UTF-8
fi
if [ -n "$comma" ]; then
    run --engine direct -t 1.5 -g 0.5 --report c.json --layer c.exr in.exr
    "$glarepp" --engine direct -t 1.5 -g 0.5 --layer c.exr -v in.exr 2>points
    LC_ALL=$comma "$glarepp" --engine direct -t 1.5 -g 0.5 --report l.json \
        --layer l.exr -v in.exr 2>err
    same c.exr l.exr 'a decimal comma changes no option and no pixel'
    is "$(field l.json 'o["flux_in"], o["bound"]')" \
        "$(field c.json 'o["flux_in"], o["bound"]')" 'a report has its points'
    sed s/l.exr/c.exr/ err >commas
    same points commas '-v has its points'
    LC_ALL=$comma "$glarepp" -t 1,5 -o out.png in.exr 2>err
    status=$?
    fails_with 2 1,5 'a decimal comma is no number'
else
    skip 5 'no locale with a decimal comma'
fi

# -- words ---------------------------------------------------------------------

run -v -o out.png in.exr
status_is 0 -v
is "$(sed 's/[0-9][0-9]* sources/N sources/; s/[0-9.]* % of/P % of/; s/of [0-9.]* mm/of M mm/; s/engine [a-z]*/engine E/' err)" \
    "glarepp: in.exr: read 64x48 pixels
glarepp: in.exr: N sources: pixels over the threshold of 1 (the default), P % of the light moved
glarepp: in.exr: kernel of style camera (the default), view of 30 degrees (assumed; --fov sets it), engine E (chosen by auto)
glarepp: in.exr: wrote out.png: tone-mapped by neutral (the default)" \
    '-v: what was used, and why'
run -v --verify --engine fft -o out.png in.exr
like "$(cat err)" '*measured rel_l2*' '-v --verify: how wrong it is'
run -v -o x.exr --hdr h.exr in.exr
like "$(cat err)" '*h.exr: linear light; x.exr: tone-mapped by neutral (use --hdr*' \
    '-v: which EXR is tone-mapped'
run -o out.png in.exr
quiet_success 'nothing is said without -v'
run --tonemap none --exposure 1 -o out.exr in.exr
like "$(cat err)" 'glarepp: warning: --exposure*' 'a setting without use: a warning'
run -q --tonemap none --exposure 1 -o out.exr in.exr
quiet_success '-q: no warning'
run -q -o out.png nowhere.exr
fails_with 3 nowhere.exr '-q: errors'
run --progress always -o 'o.####.png' 'shot.####.exr'
ok '--progress always: says how far it is' grep -q '^glarepp: 0 of 2 made.*: shot.0001.exr' err
run --progress never -o 'o.####.png' 'shot.####.exr'
quiet_success '--progress never'
run -q --progress always -o 'o.####.png' 'shot.####.exr'
quiet_success '-q wins over --progress'
for how in percent openjd json; do
    run --progress $how -e fft -o - --stdout-format png 'shot.####.exr'
    status_is 0 "--progress $how"
    cp err $how
    run -q --progress $how -o 'o.####.png' 'shot.####.exr'
    quiet_success "--progress $how: -q wins"
    run --progress $how -o out.png nowhere.exr
    # (seconds may have these digits)
    ended='(^|[: ])100(\.0)?([,% ]|$)'
    is "$(grep -cE "$ended" err) $(grep -cE "$ended" $how)" '0 1' \
        "--progress $how: a run that fails does not end with 100"
done
is "$(head -n 1 percent) $(tail -n 1 percent)" '0% 100%' '--progress percent: from 0 to 100'
no '--progress percent: numbers only' grep -vqx '[0-9]*%' percent
is "$(head -n 1 openjd)" 'openjd_progress: 0.0' '--progress openjd: the start'
is "$(grep -v status openjd | tail -n 1)" 'openjd_progress: 100.0' '--progress openjd: the end'
like "$(tail -n 1 openjd)" 'openjd_status: 2 of 2 made, *shot.*' '--progress openjd: the status'
no '--progress openjd: nothing else' grep -vqE '^openjd_(progress|status): .' openjd
is "$("$python" -c 'import json, sys
lines = [json.loads(l) for l in open("json")]
print(lines[0]["percent"], lines[0]["total"], lines[-1]["percent"], lines[-1]["done"],
      lines[0]["file"], sorted(lines[-1]))')" \
    "0.0 2 100.0 2 shot.0001.exr ['done', 'file', 'percent', 'seconds', 'seconds_left', 'stage', 'total']" \
    '--progress json: an object a line'

for n in 4 6 8; do cp shot.0001.exr half.$n.exr; done
run --progress openjd --skip-bad-frames -f 4-9 -e fft -o 'half.#.png' 'half.#.exr'
status_is 6 '--progress openjd: three frames of six are missing'
like "$(grep -v '^glarepp' err | tail -n 1)" 'openjd_status: 3 of 6 made, 3 failed, *' \
    '--progress openjd: what was made and what failed'
run --progress json --skip-bad-frames -f 4-9 -e fft -o 'half.#.png' 'half.#.exr'
is "$(grep '^{' err | tail -n 1 | cut -d, -f1-4)" \
    '{"done":6,"failed":3,"total":6,"percent":100.0' '--progress json: what failed'

# a resumed run
mkdir resumed
for frames in shot.0001.exr 'shot.####.exr' 'shot.####.exr'; do
    "$glarepp" -q --no-clobber --report - -o 'resumed/####.png' "$frames" >>resumed.json
done
is "$(sed 's/.*"frame":\([0-9]*\).*/\1/' resumed.json | xargs)" '1 2' \
    '--report - >>FILE: the lines of all runs'
run --report r.json -o 'o.####.png' 'shot.####.exr'
is "$(wc -l <r.json)" 2 '--report FILE: the report is made anew'
run --progress always -o out.png nowhere.exr
is "$(grep -c '^glarepp: nowhere.exr' err)" 1 'progress: the error has a line of its own'

# on a terminal: drawn over and over on one line, which is wiped at the end
frame wide.0001.exr size=640x400
for n in 02 03 04 05 06 07 08 09 10 11 12 13 14 15 16; do
    ln wide.0001.exr wide.00$n.exr
done
"$python" - "$glarepp" <<'PY' >terminal 2>&1
import os, pty, sys
pid, fd = pty.fork()
if pid == 0:
    os.execv(sys.argv[1], [sys.argv[1], "--progress", "always", "--engine", "fft",
                           "--tonemap", "agx", "--depth-bits", "16",
                           "--verify", "--report", "wide.json",
                           "-o", "wide.####.png", "wide.####.exr"])
text = b""
while True:
    try:
        more = os.read(fd, 4096)
    except OSError:  # the other side is closed
        break
    if not more:
        break
    text += more
status = os.waitpid(pid, 0)[1]
lines = text.rsplit(b"\r\x1b[K", 1)
print(status, text.count(b" of 16") > 0, lines[0].count(b"\n"),
      lines[1].startswith(b"wide.####.png: 16 frames, "), lines[1].count(b"\n"))
PY
is "$(cat terminal)" '0 True 0 True 1' \
    'progress on a terminal: one line, wiped; then what happened, in one line'

# A line on a terminal says what happened. terminal ARGUMENT...: what stderr gets,
# a terminal; stdout goes to the file out
cat >terminal.py <<'PY'
import os, pty, sys
pid, fd = pty.fork()
if pid == 0:
    os.dup2(os.open("out", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), 1)
    os.execv(sys.argv[1], sys.argv[1:])
text = b""
while True:
    try:
        more = os.read(fd, 4096)
    except OSError:  # the other side is closed
        break
    if not more:
        break
    text += more
os.waitpid(pid, 0)
sys.stdout.buffer.write(text.replace(b"\r\n", b"\n"))
PY
terminal()
{
    "$python" terminal.py "$glarepp" "$@" >err
}
frame seven.exr kind=zeros size=9x9 type=float hot=8
terminal -o out.png seven.exr
is "$(sed 's/[0-9]*\.[0-9]* s$/T s/' err)" 'out.png: 1 source, 8.8 % of the light moved, view of 30 degrees (assumed), neutral, T s' \
    'on a terminal: one line says what happened'
terminal --fov 40 -g 0.5 --tonemap agx -o out.png --hdr h.exr seven.exr
like "$(cat err)" 'out.png and 1 more: 1 source, 4.4 % of the light moved, view of 40 degrees (--fov), agx, *' \
    'with what was given'
terminal -o x.exr seven.exr
like "$(cat err)" '*, tone-mapped by neutral (use --hdr for linear light), *' \
    'an EXR that is tone-mapped is no linear one'
terminal -o - seven.exr
like "$(cat err)" 'stdout: *, tone-mapped by neutral (use --hdr *' 'one on stdout neither'
terminal --hdr h.exr seven.exr
like "$(cat err)" 'h.exr: *, linear, *' 'a linear one is'
terminal --mix add -o out.png seven.exr
like "$(cat err)" '*, 8.8 % of the light added, *' '--mix add moves none'
terminal -k k.exr -o out.png seven.exr
like "$(cat err)" '*moved, neutral, *' 'an image of a kernel has no angle'
terminal -o out.png dark.exr
like "$(cat err)" 'out.png: 0 sources: nothing glares, *warning: dark.exr: no pixel is over *' \
    'without a source nothing glares'
terminal -o 'o.####.png' 'shot.####.exr'
like "$(cat err)" 'o.####.png: 2 frames, * sources, *' 'a sequence: one line for all'
is "$(wc -l <err)" 1 'and no more'
for quiet in -q '--progress json' --help; do
    # shellcheck disable=SC2086
    terminal $quiet -o out.png seven.exr
    no "$quiet: no such line" grep -q '^out.png' err
done
terminal -v -o out.png seven.exr
no '-v: its notes say it' grep -q '^out.png' err
terminal --report - seven.exr
is "$(cat err)" '' 'without a picture there is nothing to say'
terminal -o out.png nowhere.exr
is "$(wc -l <err)" 1 'an error has only its own line'

run --help
status_is 0 --help
ok '--help: on stdout, nothing wider than 80' \
    awk 'length > 80 { exit 1 } END { exit NR < 20 }' out
is "$(wc -c <err)" 0 '--help: nothing on stderr'
run --version
status_is 0 --version
like "$(head -1 out)" 'glarepp [0-9]*.[0-9]*.[0-9]*' '--version'
for library in OpenEXR libpng libdeflate jansson OpenImageIO; do
    ok "--version: names $library" grep -qi $library out
done
is "$(tail -n 1 out)" 'Apache-2.0; no warranty' '--version: names the licence'

# the page has each field, and no other: .It Cm has fields, .Cm those of the
# object before; cpu_ms has those of times_ms
"$glarepp" --help-table | awk -F '[\t.]' '$1 == "field" {
    print $2
    if (NF > 2 && $2 != "cpu_ms") print $2 "." $3 }' | sort -u >fields
is "$(awk '/^\.Sh/ { on = /THE REPORT/ }
    on && /^\.(It )?Cm / {
        item = /^\.It/
        of = item ? $3 : of
        for (i = 2 + item; i <= NF; i++)
            if ($i !~ /^[,.;]$/) print item ? $i : of "." $i
    }' "$root/man/glarepp.1" | sort -u)" "$(cat fields)" \
    "the man page has the fields of the report: $(wc -l <fields)"

# a pixel off by 1e-3 of itself may be less of max_rel: the page says by what
ok 'the man page says what max_rel divides by' \
    grep -q 'plus 1e-6 of the largest luminance' "$root/man/glarepp.1"

done_testing
