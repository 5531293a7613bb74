#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Lights that the frame shows, levels of flares and ghosts, parts of the layer.
. "$(dirname "$0")/lib.sh"
need_python

# says WANTED DESCRIPTION ARGUMENT...: what spots.py prints, by a test in Python
says()
{
    wanted=$1 about=$2
    shift 2
    "$python" "$cli/spots.py" "$@" >said 2>err
    ok "$about" "$python" -c "
a, b, c = open('said').read().split()
raise SystemExit(not ($wanted))" || note "$(cat said err)"
}
close='a == "True" and float(b) <= .3 and float(c) <= .05'

# -- lights that are found ------------------------------------------------------

# each FILE EXPRESSION: of each line of a report, o being its object
each()
{
    "$python" -c 'import json, sys
for line in open(sys.argv[1]):
    eval("print(%s)" % sys.argv[2], {"o": json.loads(line)})' "$1" "$2" 2>&1
}

"$python" "$cli/spots.py" make
run --lights auto --write-lights found.json --report r.json --frame-jobs 1 \
    'l.####.pfm'
status_is 0 'twelve lamps in five frames'
says "$close" 'each is found, alone, under its name, .3 pixels and 5 % away' \
    check r.json
run --lights auto --report jobs.json --frame-jobs 4 'l.####.pfm'
lights='o["lights"]'
is "$(each jobs.json "$lights")" "$(each r.json "$lights")" \
    'the same with four frames in flight'
run --lights found.json --report alone.json l.1005.pfm
is "$(field alone.json "$lights")" "$("$python" -c "
import json
print(json.loads(open('r.json').read().splitlines()[4])['lights'])")" \
    'a lone frame has the names of the file'
is "$(field alone.json 'o["lights"][0]["found"]')" True 'the report says found'
run --lights auto:3 --report three.json l.1001.pfm
is "$(field three.json 'len(o["lights"])')" 3 'the three brightest'
printf '{"lights": [{"name": "mine", "found": [%s], "flux": [%s]}]}' \
    "$(field r.json 'str([o["lights"][5][k] for k in "xy"])[1:-1]')" \
    "$(field r.json 'str(o["lights"][5]["flux"])[1:-1]')" >mine.json
run --lights mine.json --report mine-r.json l.1003.pfm
is "$(field mine-r.json '[l["name"] for l in o["lights"]]')" "['mine']" \
    'a file names one of them'
run --sun "$(field r.json '"%.1f,%.1f,6" % (o["lights"][0]["x"], o["lights"][0]["y"])')" \
    --lights auto --report sun.json l.1001.pfm
is "$(field sun.json '[len(o["lights"]), o["lights"][0]["name"], min(abs(l["x"] - o["lights"][0]["x"]) + abs(l["y"] - o["lights"][0]["y"]) for l in o["lights"][1:]) > 20]')" \
    "[12, 'sun', True]" 'one with a place is not found again'

# a lamp that dims: its flux is its light, fades from 1.5 T, and is gone at T. In
# other frames, a steady one is the brighter from the second on
"$python" - <<'END'
import struct
for i, v in enumerate((3, 1.4, 1.1, 1.01, 0.99)):
    for name, lamps in ("d", [(30, v)]), ("e", [(30, v), (10, 2)]):
        px = [0.0] * (3 * 64 * 64)
        for left, level in lamps:
            for y in range(30, 34):
                px[3 * (64 * y + left):3 * (64 * y + left + 4)] = [level] * 12
        open("%s.%d.pfm" % (name, i + 1), "wb").write(
            b"PF\n64 64\n-1.0\n" + struct.pack("<%df" % len(px), *px))
END
for gain in .1 1:.1,5:.2; do # a plan of the run, and one of each frame
    run --lights auto --gain $gain --report e.json 'e.#.pfm'
    is "$(each e.json '*[l["name"] for l in sorted(o["lights"], key=lambda l: -l["x"])]' |
        xargs)" 'lamp1 lamp2 lamp1 lamp2 lamp1 lamp2 lamp1 lamp2 lamp2' \
        "--gain $gain: names are those of the first frame"
done
run --lights auto --report dim.json 'd.#.pfm'
ok 'a lamp that dims fades' "$python" -c "
import json
f = [(json.loads(l).get('lights') or [{'flux': [0]}])[0]['flux'][0] / 16
     for l in open('dim.json')]
raise SystemExit(not (abs(f[0] - 3) < 1e-5 and 1.2 < f[1] < 1.4 and
                      0.05 < f[2] < 0.2 and 0 < f[3] < .01 and f[4] == 0))" ||
    note "$(cat dim.json | cut -c1-300)"

# -- lights that are followed -----------------------------------------------------

"$python" "$cli/spots.py" tracks
for jobs in 1 4; do
    run --lights auto --write-lights t.$jobs.json --frame-jobs $jobs 't.#.pfm'
    status_is 0 "lamps that pass each other, $jobs in flight"
done
same t.1.json t.4.json 'the same lights file with four in flight'
run --lights t.1.json --report t.rep --layer 't.#.exr' 't.#.pfm'
is "$("$python" "$cli/spots.py" follow t.rep)" 'lamp1 lamp4 lamp2 lamp3 lamp5' \
    'each lamp keeps its name, and one that comes later has one'
run --lights t.1.json --report one.rep --layer one.exr t.7.pfm
same one.exr t.7.exr 'a lone frame is that of the sequence'
is "$(field one.rep 'o["lights"]')" "$(sed -n 7p t.rep >7.rep; field 7.rep 'o["lights"]')" \
    '... and has its lights'
printf '{"lights": [{"name": "a", "found": [[1, 30, 52], [12, 195, 52]]}]}' >a.json
run --lights a.json --report a.rep t.9.pfm
is "$(field a.rep '[(l["name"], round(l["x"])) for l in o["lights"]]')" "[('a', 150)]" \
    'between frames of the file a light is where it goes'
run -v --lens tessar --lens-gain 3 --flare preset:zoom --flare-gain auto -o v.png t.7.pfm
like "$(cat err)" '*flare times [0-9]*, lens Tessar*, times 3*' '-v says the levels'
run --source-mask '!' -o v.png t.7.pfm
fails_with 2 '--source-mask: no name (found "!")' 'an inverted nothing'
run --lights auto --no-clobber --layer 'n.#.exr' 't.#.pfm'
is "$(cat err)" 'glarepp: warning: --lights auto: with --no-clobber the first frame that is made names them; give the file of --write-lights' \
    'names that depend on what is made: one line'
sed 's/"color": \[1, 1, 1\]/"color": [0.5, 0.25, 0]/' t.1.json >dim.json
run --lights dim.json --report dim.rep t.7.pfm
is "$(field dim.rep '[round(v, 3) for v in o["lights"][0]["flux"]]')" \
    "$(field one.rep '[round(v * k, 3) for v, k in zip(o["lights"][0]["flux"], (.5, .25, 0))]')" \
    '"color" takes part of a light'

# -- lights in a bright sky, and less than a pixel -------------------------------

"$python" - <<'END'
import struct
def save(name, w, h, pixel):
    px = [v for y in range(h) for x in range(w) for v in [pixel(x, h - 1 - y)] * 3]
    open(name, "wb").write(b"PF\n%d %d\n-1.0\n" % (w, h) +
                           struct.pack("<%df" % len(px), *px))
save("sky.pfm", 200, 120, lambda x, y: 5000 if (x - 90) ** 2 + (y - 40) ** 2 < 9
     else 9 if x < 20 > y else 3)
save("huge.pfm", 200, 120, lambda x, y: 3.4028234e38 if 40 <= x < 120 else 0)
save("flat.pfm", 200, 120, lambda x, y: 20 if 40 <= x < 120 else 0)
for i in range(9): # a lamp of a pixel, between two
    save("p.%d.pfm" % i, 40, 40, lambda x, y: 0.1 + 4.5 *
         max(0, 1 - abs(x - 20 - i / 8)) * max(0, 1 - abs(y - 20 - i / 8)))
END
run --lights auto --report sky.rep sky.pfm
is "$(field sky.rep '[(l["x"], l["y"], abs(l["flux"][0] / (25 * 4997) - 1) < .01) for l in o["lights"]]')" \
    '[(90.5, 40.5, True)]' 'a sun in a sky that is over the threshold, and no sky'
run --lights auto --report huge.rep huge.pfm
is "$status $(field huge.rep 'len(o["lights"])')" '0 0' 'one of the largest float: it ends'
run --lights auto --flare preset:zoom --layer flat.exr flat.pfm
like "$(cat err)" '*flat.pfm: no light is found: what is bright is wider than a quarter*; name a light*' \
    'a bright area that is no light: one line'
run --lights auto --report p.rep 'p.#.pfm'
ok 'a lamp of a pixel does not pop as it moves' "$python" -c "
import json
f = [sum(l['flux'][0] for l in json.loads(row)['lights']) for row in open('p.rep')]
raise SystemExit(max(f) > 2 * min(f) or min(f) <= 0)" || note "$(cut -c1-400 p.rep)"

if [ -n "$data" ]; then
    run --lights auto --report s.json "$data/scenes/street.1003.exr"
    says "$(echo "$close" | sed 's/\.3/1/')" 'lamps of a rendered street' \
        data s.json "$data/scenes/street.camera.json"
    run --lights auto --report n.json "$data/rendered/night.1001.exr"
    says "$(echo "$close" | sed 's/\.3/1/')" 'lamps of a rendered night' \
        night n.json "$data/rendered/night.camera.json"
else
    skip 2 "$no_data"
fi

# -- a lone frame ----------------------------------------------------------------

# (gain 0.5 and twice the level are the same light)
for what in '--flare preset:zoom' '--flare preset:anamorphic' \
    '--flare preset:vintage' '--flare preset:lamps' '--flare preset:veil' \
    '--flare preset:oval' '--lens heliar' '--lens tessar' '--lens telephoto' \
    '--lens double-gauss'; do
    name=${what#* }
    level=--flare-gain key=flare
    case $what in --lens*) level=--lens-gain key=lens ;; esac
    # shellcheck disable=SC2086
    run $what $level auto --report f.json --parts p.exr --layer y.exr \
        --type float "$root/tests/frames/night.1001.exr"
    status_is 0 "$name on a lone frame"
    ok "$name: its gain is in the report" [ \
        "$(field f.json "o['$key']['gain'] > 0")" = True ]
    if [ -n "$oiio" ]; then
        ok "$name: parts add up to the layer" "$python" -c "
import subprocess, sys
e = float(subprocess.check_output([sys.executable, '$cli/spots.py', 'sum',
                                   'p.exr', 'y.exr']))
raise SystemExit(not e <= 1e-6)"
        # shellcheck disable=SC2086
        run $what $level auto -o with.png "$root/tests/frames/night.1001.exr"
        run -o without.png "$root/tests/frames/night.1001.exr"
        ok "$name: it is seen: over .04 of white" "$python" -c "
import OpenImageIO as oiio, numpy as np
a, b = [oiio.ImageBuf(f).get_pixels(oiio.FLOAT) for f in ('with.png', 'without.png')]
raise SystemExit(not np.abs(a - b).max() > .04)"
    else
        skip 2 'no numpy and OpenImageIO'
    fi
done

night=$root/tests/frames/night.1001.exr
run --flare preset:zoom --report a.json --layer a.exr --type float \
    --no-provenance "$night"
run --flare preset:zoom --flare-gain +1ev --parts b.exr --layer b1.exr \
    --report b.json --type float "$night"
run --flare preset:zoom --flare-gain 1 --layer c.exr --type float \
    --no-provenance "$night"
is "$(field b.json 'o["flare"]["gain"]')" 2.0 'a level in EV'
same a.exr c.exr 'a level of 1 changes no byte'
if [ -n "$oiio" ]; then
    ok 'a level of 2 adds the flare once more' "$python" -c "
import OpenImageIO as oiio, numpy as np
a, b = [oiio.ImageBuf(f).get_pixels(oiio.FLOAT) for f in ('a.exr', 'b1.exr')]
p = oiio.ImageBuf('b.exr'); n = p.spec().channelnames
f = p.get_pixels(oiio.FLOAT)[:, :, [n.index('flare.' + c) for c in 'RGB']]
raise SystemExit(not np.abs(b - a - f / 2).max() <= 1e-5 * np.abs(b).max())"
else
    skip 1 'no numpy and OpenImageIO'
fi

# refuses OPTION DESCRIPTION ARGUMENT...
refuses()
{
    name=$1 about=$2
    shift 2
    run -o a.png "$@" l.1001.pfm
    fails_with 2 "$name" "$about"
}

# the level is found in the picture, which --layer alone does not need
for what in '--flare preset:zoom --flare-gain auto' '--lens heliar --lens-gain auto'; do
    # shellcheck disable=SC2086
    run $what --no-provenance --layer alone.exr "$night"
    status_is 0 "$what: the layer alone"
    # shellcheck disable=SC2086
    run $what --no-provenance --layer beside.exr --hdr h.exr "$night"
    same alone.exr beside.exr "$what: is that beside other outputs"
done

# -- words -----------------------------------------------------------------------

refuses --lights 'no number of lights' --lights auto:0
refuses --lights 'too many lights' --lights auto:257
refuses --write-lights 'nothing to write' --write-lights x.json
refuses --flare-gain 'no flare' --flare-gain 2
refuses --lens-gain 'no lens' --lens-gain 2
refuses --flare-gain 'a level of 0' --flare preset:zoom --flare-gain 0
printf '{"lights": [{"found": [1, 2]}]}' >noname.json
run --lights noname.json -o a.png l.1001.pfm
fails_with 4 '"name"' 'a place that was found has a name'
run --lights auto --write-lights none.json -t 1e6 -o a.png l.1001.pfm
like "$(cat err)" '*none.json: not written*' 'no light, no file'
ok 'and none is there' [ ! -e none.json ]

# a lamp whose own pixels are nearer than the place that it is given
frame near.exr channels=R,G,B,Z:float kind=dark hot=500
run --sun 32.5,24.5,1 --sun-color 100 -o a.png near.exr
like "$(cat err)" '*hidden by bright pixels at its own place (depth *--depth none*' \
    'a light that its own pixels hide'
run --sun 32.5,24.5,1 --sun-color 100 --depth none --report n.json -o a.png near.exr
is "$(cat err)" '' '--depth none says nothing'
is "$(field n.json 'o["lights"][0]["visibility"]')" 1.0 '... and nothing hides it'
run --sun 10,5,1 --sun-color 1e9 -o a.png near.exr
like "$(cat err)" '*times as bright as the brightest pixel*--sun-color*' \
    'a light that is far too bright'
done_testing
