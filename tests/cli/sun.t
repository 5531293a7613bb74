#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Suns and lamps: where they stand, what hides them, the light they bring.
. "$(dirname "$0")/lib.sh"
need_python

# Z is 1e10 in rows 0 to 11, a surface below; A is 0, 1/4 ... 1 by columns
frame in.exr channels=R,G,B,A,Z:float kind=dark
frame matte.exr channels=R,G,B,A kind=dark
frame crop2.exr channels=R,G,B kind=dark size=99x99
frame kernel.exr kind=kernel size=17x17 type=float
gl=yes
"$glarepp" --sun 30,12 --sun-method mask --report r.json in.exr 2>/dev/null ||
    gl=

# sees WANTED LIMIT DESCRIPTION ARGUMENT...: the first light's visibility
sees()
{
    wanted=$1 limit=$2 about=$3
    shift 3
    run --report r.json "$@"
    is "$(field r.json "abs(o['lights'][0]['visibility'] - $wanted) <= $limit")" \
        True "$about" || note "$(head -c 300 err) $(field r.json 'o["lights"]')"
}

# -- visible shares ------------------------------------------------------------

for row in 'exact 1e-6' 'mask 0.06' 'readback 0.06'; do
    method=${row% *} limit=${row#* }
    [ -n "$gl" ] || [ $method = exact ] || {
        skip 12 'no GL'
        continue
    }
    set -- --sun-method $method in.exr
    sees 1 0 "$method: a clear sun" --sun 30,6,4 "$@"
    sees 0 0 "$method: a hidden sun" --sun 30,30,4 "$@"
    sees 0.5 $limit "$method: half of a sun" --sun 30,12,5 "$@"
    sees 1 0 "$method: smaller than a pixel, clear" --sun 30.5,11.5,0.1 "$@"
    sees 0 0 "$method: smaller than a pixel, hidden" --sun 30.5,12.5,0.1 "$@"
    sees 0.25 0.02 "$method: larger than the frame" --sun 32,24,900 "$@"
    sees 1 0 "$method: partly outside, ignored" --sun 0,6,4 "$@"
    sees 0.5 $limit "$method: partly outside, hidden" --sun 0,6,4 \
        --sun-outside hidden "$@"
    sees 0.5 $limit "$method: partly outside, visible" --sun 0,24,4 \
        --sun-outside visible "$@"
    sees 0 0 "$method: wholly outside, ignored" --sun -90,6,4 "$@"
    sees 1 0 "$method: wholly outside, visible" --sun -90,6,4 \
        --sun-outside visible "$@"
    sees 0.5 0.03 "$method: coverage alone" --sun 32.5,24,20 --mask A \
        --sun-method $method matte.exr
done

sees 0.5 1e-6 'exact: a mask where depth is empty, nothing where it is behind' \
    --sun 32.5,6,2.5 --mask A in.exr
printf '[{"pixel": [30, 30], "radius": 3, "depth": 5}]' >near.json
sees 1 0 'exact: a lamp before all surfaces' --lights near.json in.exr
printf '[{"pixel": [30, 30], "radius": 3, "depth": 500}]' >far.json
sees 0 0 'exact: a lamp behind them' --lights far.json in.exr
run --sun 30,12,5 --depth-file in.exr --report r.json crop2.exr
like "$(cat err)" '*does not cover*' 'depth of another window is said'
frame moved.exr channels=R,G,B,A,Z:float kind=dark origin=-100,2000
sees 0.5 1e-6 'a data window elsewhere' --sun -70,2012,5 moved.exr
frame crop.exr channels=R,G,B,Z:float kind=dark origin=10,10 \
    display=0,0,99,99
sees 1 0 'in the display window, outside the data window: nothing hides it' \
    --sun 5,5,3 crop.exr

# -- places of the channels ----------------------------------------------------

frame part.exr channels=R,G,B kind=dark part=depth:Z:float
sees 0.5 1e-6 'depth in another part' --sun 30,12,5 part.exr
sees 0.5 1e-6 'depth by PART.CHANNEL' --sun 30,12,5 --depth depth.Z part.exr
frame colour.exr channels=R,G,B kind=dark
sees 0.5 1e-6 'depth in another file' --sun 30,12,5 --depth-file in.exr \
    colour.exr
sees 0.5 1e-6 'coverage in another file' --sun 32.5,6,2.5 \
    --mask-file matte.exr colour.exr
run --sun 30,12,5 --report r.json colour.exr
status_is 0 'no depth at all is no error'
like "$(cat err)" '*nothing hides the lights*' 'no depth at all is said'
run --sun 30,12 --depth Q --report r.json in.exr
fails_with 2 'A, B, G, R, Z' 'a depth channel that is not there'
run --sun 30,12 --mask Q --report r.json in.exr
fails_with 2 'A, B, G, R, Z' 'a mask channel that is not there'

# -- messages ------------------------------------------------------------------

run --sun 30,12,5 -v --report r.json in.exr
is "$(field r.json 'o["lights"]')" \
    "[{'name': 'sun', 'x': 30.0, 'y': 12.0, 'radius': 5.0, \
'visibility': 0.5, 'interval': [0.37353, 0.62647]}]" 'lights'
is "$(field r.json 'o["depth"]')" "{'channel': 'Z', 'empty': '1e+10'}" \
    'depth, and what of it is empty'
is "$(field r.json '"sun" in o["times_ms"]')" True 'time of the sun'
like "$(cat err)" '*sun 50 % visible*' '-v: the share'
run --report r.json --layer l.exr in.exr
is "$(field r.json '"lights" in o, "sun" in o["times_ms"]')" '(False, False)' \
    'no sun: not a word of it'

# -- the light that it brings --------------------------------------------------

# sums EXPRESSION FILE...: t are the sums of channel R of each, in 6 digits
sums()
{
    "$python" - "$@" <<'PY'
import sys, numpy as np, OpenImageIO as oiio
t = [float("%.6g" % np.asarray(oiio.ImageBuf(f).get_pixels(oiio.FLOAT),
                               np.float64)[..., 0].sum()) for f in sys.argv[2:]]
print(eval(sys.argv[1]))
PY
}

printf '[{"pixel": [20, 5], "radius": 2, "flux": 100},
 {"pixel": [10.2, 6.7], "radius": 1, "flux": [9, 50, 20]},
 {"pixel": [50, 4.4], "radius": 2, "flux": 60},
 {"pixel": [44, 40], "radius": 2, "flux": 6e5},
 {"pixel": [60, 3], "radius": 0, "flux": 30}]' >many.json
printf '[{"shape": "disc", "position": 0.3, "size": 0.2, "color": 0.01},
 {"shape": "ring", "position": 1.2, "size": 0.3, "color": [0.01, 0.02, 0.03],
  "scale": [1, 1.1, 1.2]}]' >flare.json
if [ -n "$oiio" ]; then
    run -k kernel.exr --sun 30,12,3 --sun-color 100,50,20 --verify \
        --kernel-normalize none --layer half.exr --report r.json in.exr
    run -k kernel.exr --sun 30,12,3 --sun-color 100,50,20 \
        --kernel-normalize none --layer clear.exr matte.exr
    is "$(sums 'round(t[0] / t[1], 5)' half.exr clear.exr)" \
        0.5 'half a sun, half the glare'
    is "$(field r.json 'o["measured"]["rel_l2"] <= o["bound"]')" True \
        'a light goes through the engines, and is verified'
    run --sun 30,30,3 --sun-color 1e6 --flare flare.json --layer dark.exr \
        --report r.json in.exr
    is "$(sums 't[0]' dark.exr) $(field r.json 'o["engine"]')" '0.0 none' \
        'a hidden light is no light'
    run --flare flare.json --sun 30,6,2 --sun-color 1000 -k kernel.exr \
        --layer flared.exr matte.exr
    run --sun 30,6,2 --sun-color 1000 -k kernel.exr --layer plain.exr matte.exr
    is "$(sums 'round(t[0] - t[1], 1)' flared.exr plain.exr)" \
        20.0 'flare carries its share of the flux'
    # elements of bright pixels: no light is listed
    sed 's/{"shape"/{"source": "bright", "shape"/g' flare.json >bright.json
    printf '{"source": "bright", "elements": %s}' "$(cat flare.json)" >all.json
    frame bright.exr kind=lights size=200x120
    run -k kernel.exr --layer plain.exr --report p.json bright.exr
    run -k kernel.exr --flare bright.json --layer flared.exr --report r.json \
        --no-provenance bright.exr
    is "$(sums "round((t[0] - t[1]) / $(field p.json 'o["flux_in"][0]'), 4)" \
        flared.exr plain.exr)" 0.02 \
        'flare of bright pixels carries its share of their flux'
    is "$(field r.json '[o["flare"]["elements"], o["flare"]["runs"]] + \
        [1e-3 < o["flare"]["bound"] < 0.5, o["flare"]["ms"] > 0, "lights" in o]'
        )" '[2, 2, True, True, False]' \
        'flare of bright pixels: runs, bound and time'
    run -k kernel.exr --flare all.json --layer all.exr --threads 3 \
        --no-provenance bright.exr
    same all.exr flared.exr '"source" for all elements; any threads'
    run -k kernel.exr -v --flare bright.json --layer dark.exr matte.exr
    is "$(sums 't[0]' dark.exr)" 0.0 'flare of a frame without bright pixels'
    run -k kernel.exr --sun 30,6,2 --flare bright.json --layer sun.exr \
        bright.exr
    status_is 0 'a sun without flux beside flare of bright pixels'
    printf '{"elements": [], "sauce": 1}' >wrong.json
    run --flare wrong.json --layer l.exr bright.exr
    fails_with 4 sauce 'a flare file with a key that does not exist'
    run --sun 30,6,4 --sun-adapt 0.5 --hdr dim.exr --type float in.exr
    run --hdr full.exr --type float in.exr
    is "$(sums 'round(t[0] / t[1], 4)' dim.exr full.exr)" \
        0.5 '--sun-adapt dims by the visible share'
    run --sun 30,30,4 --sun-adapt 0.5 --hdr dim.exr --type float in.exr
    is "$(sums 't[0] == t[1] > 0' dim.exr full.exr)" True '--sun-adapt: hidden, no change'
    for how in ignore hidden; do
        run --sun 0,24,9 --sun-outside $how --sun-color 1000 -k kernel.exr \
            --layer $how.exr matte.exr
    done
    is "$(sums 'round(t[0] / t[1], 4)' hidden.exr ignore.exr)" \
        0.5 'half outside and hidden: half the glare of half outside and ignored'
    run --sun 0,24,9000 --sun-color 1000 --layer x.exr in.exr
    fails_with 4 'too large' 'a sun far larger than the frame, with glare'
    run --sun -3,24,2 --sun-outside visible --sun-color 1000 -k kernel.exr \
        --layer beyond.exr matte.exr
    is "$(sums 't[0] > 0' beyond.exr)" True \
        'a sun beyond the edge glares into the frame'
else
    skip 11 'no numpy or no OpenImageIO'
fi
if [ -n "$gl" ] && [ -n "$oiio" ]; then
    for engine in direct fft; do
        run -k kernel.exr -e $engine --sun 30.3,6.6,2.2 --sun-color 900,500,200 \
            --flare flare.json --layer $engine.exr in.exr
    done
    for method in mask readback; do
        run -k kernel.exr --sun 30.3,6.6,2.2 --sun-color 900,500,200 \
            --flare flare.json --sun-method $method --layer $method.exr in.exr
        quiet_success "$method draws light and flare"
    done
    for method in exact mask; do
        run -k kernel.exr --sun=-1,6,5 --sun-color 900,500,200 \
            --flare flare.json --sun-method $method --layer edge_$method.exr \
            --report r.json in.exr
        is "$(field r.json 'o["sun_method"]')" $method 'the report names it'
    done
    run -k kernel.exr --lights many.json --flare flare.json --layer many.exr \
        in.exr
    run -k kernel.exr --lights many.json --flare flare.json --sun-method mask \
        --layer masked.exr in.exr
    {
        echo 'fft.exr direct.exr 1e-6 fft lays the same light as direct'
        echo 'mask.exr direct.exr 1e-5 mask lays the same'
        echo 'edge_mask.exr edge_exact.exr 1e-5 partly outside, the same'
        echo 'masked.exr many.exr 1e-5 five lights of three sizes, the same'
        echo 'readback.exr direct.exr 1e-5 readback, the same'
    } | "$python" "$cli/compare.py" >verdicts
    verdicts verdicts
else
    skip 9 'no GL, or nothing to compare with'
fi

# -- the same bytes ------------------------------------------------------------

for method in exact mask; do
    [ -n "$gl" ] || [ "$method" = exact ] || {
        skip 2 'no GL'
        continue
    }
    for threads in 1 2 3; do
        run --threads $threads --sun 30.3,12.6,5 --sun-color 900,500,200 \
            --sun-method $method --flare flare.json --layer $threads.exr in.exr
    done
    same 1.exr 2.exr "$method: two threads, the same bytes"
    same 1.exr 3.exr "$method: three threads, the same bytes"
done

# -- cameras -------------------------------------------------------------------

# looks along +z from the origin, 90 degrees: x' = (x + z) / 2z
spec=m44f:0.5,0,0,0,0,-0.5,0,0,0.5,0.5,1,1,0,0,-1,0
clip=m44f:1,0,0,0,0,1,0,0,0,0,1,1,0,0,-1,0
frame spec.exr channels=R,G,B,Z:float kind=dark attr=worldToNDC:$spec
frame clip.exr channels=R,G,B,Z:float kind=dark attr=worldToNDC:$clip
frame screen.exr channels=R,G,B,Z:float kind=dark attr=worldToScreen:$clip
for name in spec clip screen; do
    run --sun-dir 0,0.5,1 --sun-size 8 --report r.json $name.exr
    is "$(field r.json '[o["lights"][0][k] for k in ("x", "y", "visibility")]')" \
        '[32.0, 12.0, 0.5]' "$name: --sun-dir finds the place"
done
run --sun-dir 0,0,-1 --report r.json spec.exr
is "$(field r.json 'o["lights"]')" \
    "[{'name': 'sun', 'behind': True, 'visibility': 0.0, 'interval': [0.0, 1.0]}]" \
    'behind the camera'
# a lens shift so large that the axis falls where the other one's centre is
shifted=m44f:1,0,0,0,0,1,0,0,0.5,0.5,1,1,0,0,-1,0
frame shifted.exr channels=R,G,B,Z:float kind=dark attr=worldToNDC:$shifted
frame named.exr channels=R,G,B,Z:float kind=dark attr=worldToScreen:$shifted
for row in 'shifted 32.0 24.0' 'named 48.0 12.0'; do
    set -- $row
    run --sun-dir 0,0,1 --report r.json $1.exr
    is "$(field r.json '[o["lights"][0][k] for k in ("x", "y")]')" "[$2, $3]" \
        "$1.exr: the convention"
done
run --sun-dir 0,0.5,1 --report r.json in.exr
fails_with 2 worldToNDC 'a direction without a camera'
cat >camera.json <<'JSON'
{"frames": [{"frame": 7, "sun_dir_world": [0, 0.5, 1], "sun_radius_px": 5,
  "worldToNDC_rowmajor": [0.5,0,0,0,0,-0.5,0,0,0.5,0.5,1,1,0,0,-1,0]},
 {"frame": 8, "sun_dir_world": [0, 0.25, 1], "sun_radius_px": 5,
  "worldToNDC_rowmajor": [0.5,0,0,0,0,-0.5,0,0,0.5,0.5,1,1,0,0,-1,0]}]}
JSON
cp in.exr shot.7.exr
cp in.exr shot.8.exr
run --camera camera.json --report r.json -f 7,8 'shot.#.exr'
is "$("$python" -c 'import json
print([json.loads(l)["lights"][0]["y"] for l in open("r.json")])')" \
    '[12.0, 18.0]' '--camera: each frame has its own'
cp in.exr shot.9.exr
run --camera camera.json --report r.json shot.9.exr
fails_with 4 camera.json '--camera without that frame'
printf '{"lights": [{"world": [0, 4, 8], "radius": 4},
 {"world": [0, 40, 80], "radius": 4}]}' >lamps.json
run --camera camera.json --lights lamps.json --report r.json shot.7.exr
is "$(field r.json 'len(o["lights"])')" 3 'lamps beside the camera'\''s sun'

# a camera without a sun: the angle of view, and places of other lights
cat >night.json <<'JSON'
{"frames": [{"frame": 7,
  "worldToNDC_rowmajor": [0.5,0,0,0,0,-0.5,0,0,0.5,0.5,1,1,0,0,-1,0]}]}
JSON
run -t 0 --camera night.json --report r.json shot.7.exr
is "$status $(field r.json '[o["fov_from"], o["lights"]]')" \
    "0 ['camera', []]" '--camera without a sun'
run --camera night.json --sun-dir 0,0.5,1 --report r.json shot.7.exr
is "$(field r.json 'o["lights"][0]["y"]')" 12.0 \
    '--sun-dir by a camera without a sun'
run --camera night.json --lights lamps.json --report r.json shot.7.exr
is "$(field r.json 'len(o["lights"])')" 2 'lamps by a camera without a sun'
for more in '--sun-color 5' '--sun-in-frame' '--sun-size 2' '--mask A'; do
    run --camera night.json $more --report r.json shot.7.exr
    fails_with 4 sun_dir_world "$more: of a sun that --camera lacks"
done

# -- refusals ------------------------------------------------------------------

# refuses NAME DESCRIPTION ARGUMENT...
refuses()
{
    name=$1 about=$2
    shift 2
    run --report r.json "$@" in.exr
    fails_with 2 "$name" "$about"
}
refuses --sun 'one number' --sun 3
refuses --sun 'four numbers' --sun 1,2,3,4
refuses --sun 'no number' --sun 1,x
refuses --sun 'NaN' --sun nan,1
refuses --sun 'a negative radius' --sun 1,2,-3
refuses --sun-dir 'two suns' --sun 1,2 --sun-dir 0,0,1
refuses --sun-color 'two colours' --sun 1,2 --sun-color 1,2
refuses --sun-map 'an odd map' --sun 1,2 --sun-method mask --sun-map 15
refuses --sun-color 'flare without flux' --sun 1,2 --flare flare.json
run --flare flare.json -o a.png in.exr
status_is 0 'flare of lights without light: those that the frame shows'
refuses 'anamorphic, lamps, oval, veil' 'a list of flares in place of one' \
    --flare preset:list
run --flare preset:list
status_is 0 'the list of flares'
is "$(tr '\n' ' ' <out)" 'anamorphic lamps oval veil vintage zoom ' 'their names'
run --flare preset:list --threads 2 -o out.png
fails_with 2 'no input' 'a list of flares, and a picture of nothing'
refuses 'veil, vintage, zoom' 'a flare by a path' --flare preset:../flare
for flare in anamorphic zoom vintage; do
    run --flare preset:$flare --sun 30,6,2 --sun-color 1000 --layer l.exr in.exr
    status_is 0 "--flare preset:$flare"
done
for flare in lamps veil; do
    run --flare preset:$flare --report r.json matte.exr
    status_is 0 "--flare preset:$flare"
done
refuses --mask 'a mask without light' --mask A
refuses --debug 'a sun map without light' --debug sunmap=m.png
run --lights nowhere.json --report r.json in.exr
fails_with 3 nowhere.json 'no such lights'
printf '[{"pixel": [1, 2], "radius": -1}]' >wrong.json
run --lights wrong.json --report r.json in.exr
fails_with 4 radius 'a lamp of a negative radius'
printf '[{"shape": "disc", "sise": 1}]' >wrong.json
run --sun 1,2 --sun-color 1 --flare wrong.json --report r.json in.exr
fails_with 4 sise 'a flare with a key that does not exist'

# -- pictures and tables -------------------------------------------------------

for method in exact mask; do
    [ -n "$gl" ] || [ $method = exact ] || {
        skip 2 'no GL'
        continue
    }
    run --sun 30,12,5 --sun-method $method --debug sunmap=m.png \
        --debug intensity=i.png in.exr
    quiet_success "$method: pictures of the maps"
    is "$(png_size m.png); $(png_size i.png)" '512x256 8 2; 512x256 8 2' \
        "$method: their sizes"
done
run bench --sun 30,12,5 --runs 3 --csv t.csv --json t.json in.exr
quiet_success 'bench --sun'
is "$(wc -l <t.csv)" 23 'bench --sun: a line for each way'
is "$("$python" -c 'import json
rows = {r["method"]: r for r in json.load(open("t.json"))["rows"]}
print(len(rows), abs(rows["exact"]["visibility"] - 0.5) < 1e-9,
      rows["exact"]["error_worst"])')" '22 True 0.0' 'bench --sun: its JSON'
like "$(cat out)" '*mean error*' 'bench --sun: a table'
run bench --sun 30,12,5 --plot p.svg in.exr
fails_with 2 --plot 'bench --sun has no plot'

# -- real frames ---------------------------------------------------------------

# truth METHOD LIMIT: the mean error over all frames that have a truth
truth()
{
    rm -f r.json
    for scene in seq_foliage/foliage seq_foliage/foliage_f32 \
        rendered/window rendered/brightsky; do
        "$glarepp" --camera "$data/$scene.camera.json" --sun-method "$1" \
            --report one.json "$data/$scene.####.exr" || return 1
        cat one.json >>r.json
    done
    "$python" - "$data" "$2" <<'PY'
import json, os, re, sys
data, limit = sys.argv[1], float(sys.argv[2])
errors = []
for line in open("r.json"):
    o = json.loads(line)
    scene, frame = re.fullmatch(r"(.*)\.(\d+)\.exr", o["input"]).groups()
    for f in json.load(open(scene + ".camera.json"))["frames"]:
        if f["frame"] == int(frame):
            errors.append(abs(f["sun_visibility_depth"] -
                              o["lights"][0]["visibility"]))
print(len(errors), sum(errors) / len(errors), max(errors))
sys.exit(len(errors) != 11 or sum(errors) / len(errors) > limit)
PY
}
if [ -n "$data" ] && [ -d "$data/seq_foliage" ]; then
    ok 'exact: within 0.02 of the truth of real frames' truth exact 0.02
    if [ -n "$gl" ]; then
        ok 'mask: within 0.06 of the truth of real frames' truth mask 0.06
    else
        skip 1 'no GL'
    fi
else
    skip 2 "$no_data"
fi

done_testing
