#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Styles: what each does to a picture, the default's blacks by day and halo by
# night, and the sheet of them.
. "$(dirname "$0")/lib.sh"
need_python
night=$root/tests/frames/night.1001.exr

# -- the command -----------------------------------------------------------------

run styles
quiet_success 'a list'
styles=$(cut -d' ' -f1 out)
is "$([ "$(wc -l <out)" -ge 8 ] && echo yes)" yes 'of at least 8'
is "$(head -1 out | cut -d' ' -f1), $(grep -c '(default)' out)" 'camera, 1' \
    'camera is the default'
run styles "$night"
status_is 2 'a frame, and nothing to make'
run styles -o sheet.png
status_is 2 'a sheet of no frame'
run styles -o sheet.png - <"$night"
status_is 2 'a frame that can be read once'
run styles --style eye
status_is 2 'one of the styles'

frame in.exr size=48x32 hot=900
for style in $styles; do
    echo "glarepp --style $style in.exr"
done >wanted
run styles -o sheet.png --tonemap agx --report r.json in.exr
quiet_success 'a sheet'
"$python" -c 'import json
for line in open("r.json"):
    o = json.loads(line)
    print(o["command"].replace(" --tonemap agx", ""), o["status"])' >found
is "$(sed 1d found)" "$(sed 's/$/ 0/' wanted)" 'a command for each in the report'
is "$(head -1 found)" 'glarepp --gain 0 in.exr 0' 'and for that without glare'
is "$("$python" -c 'import struct
print(struct.unpack(">2I", open("sheet.png", "rb").read()[16:24]))')" \
    "(176, 200)" 'three columns, three rows'

# -- what a style stands for -------------------------------------------------------

run --style eye -o a.png in.exr
run -k eye -o b.png in.exr
run -k eye --style mist -t 1 -o c.png in.exr
ok 'a kernel that is given takes the place of all' \
    sh -c '[ "$(tail -c 800 a.png | cksum)" = "$(tail -c 800 b.png | cksum)" ] &&
           [ "$(tail -c 800 a.png | cksum)" = "$(tail -c 800 c.png | cksum)" ]'
run --style mist -o a.png --report r.json in.exr
is "$(field r.json 'o["style"], o["threshold"], o["settings"]["style"]')" \
    "('mist', 0.0, 'mist')" 'a style in the report'
run --style mis -o a.png in.exr
like "$(cat err)" '*did you mean mist?*' 'a misspelt style'
run bench --style halation --runs 1 in.exr
is "$status" 0 'bench takes a style'
run kernel --style halation --size 64x48 -o k.exr
quiet_success 'kernel takes a style'

# -- pictures ------------------------------------------------------------------

if [ -z "$oiio" ]; then
    skip 2 'no numpy to measure pictures'
    done_testing
    exit 0
fi

# A tile of the sheet has the mean of the pixels that it shows
frame wide.exr size=1000x100 dim=0.5 lights=0
run styles -o sheet.exr wide.exr
run -g 0 -o plain.exr wide.exr
ok 'a tile is as bright as the picture' "$python" -c 'import numpy, OpenImageIO
sheet, plain = (OpenImageIO.ImageBuf(n).get_pixels() for n in ("sheet.exr", "plain.exr"))
assert abs(sheet[32:96, 8:648].mean() / plain.mean() - 1) < 0.01'

# shown OUT ARGUMENT...: a picture as raw
shown()
{
    to=$1
    shift
    "$glarepp" -q --no-dither --raw rgb48le -o - "$@" >"$to" || exit 1
}
measure()
{
    "$python" "$cli/styles.py" "$@"
}
# at_most A B, at_least A B: of numbers
at_most()
{
    "$python" -c 'import sys; sys.exit(float(sys.argv[1]) > float(sys.argv[2]))' \
        "$1" "$2"
}

shown plain.raw -g 0 "$night"
for style in $styles; do
    shown style.raw --style "$style" "$night"
    change=$(measure change plain.raw style.raw)
    note "$style changes night by $change"
    ok "$style changes the night" at_most 0.002 "$change"
done
for curve in reinhard agx neutral; do
    shown plain.raw -g 0 --tonemap $curve "$night"
    shown style.raw --tonemap $curve "$night"
    change=$(measure change plain.raw style.raw)
    note "$curve: the default changes night by $change"
    ok "$curve: lamps at night keep a halo" at_most 0.004 "$change"
done

# black FRAME NAME [CURVE...]: the default's blacks by day, with each curve
black()
{
    worst=0 frame=$1 name=$2
    shift 2
    for curve in "$@"; do
        shown plain.raw -g 0 --tonemap $curve "$frame"
        shown style.raw --tonemap $curve "$frame"
        rise=$(measure black plain.raw style.raw)
        at_most "$rise" "$worst" || worst=$rise
    done
    ok "$name: blacks rise by $worst codes, at most 8" at_most "$worst" 8
}
for f in examples/leaves.1001 tests/frames/brightsky.1001; do
    black "$root/$f.exr" $f reinhard agx neutral
done
for f in examples/leaves.1003 examples/hall tests/frames/foliage.1004 \
    tests/frames/foliage.1007; do
    black "$root/$f.exr" $f neutral
done
for f in sky/aristea_top_x2.5 sky/aristea_wreck_puresky_1k \
    foliage/KernerEnvLatLong foliage/rainforest_trail_1k \
    seq_foliage/foliage.1001 seq_foliage/foliage.1004 rendered/window.1001 \
    windows/Desk windows/brown_photostudio_02_1k \
    windows/evalglare_office_fisheye windows/teufelsberg_inner_2k_dwaa \
    windows/vestibule_1k depth/weta_trees_aristea_RGBAZ scenes/forest.1001 \
    scenes/forest.1004 scenes/forest.1006; do
    if [ -n "$data" ] && [ -f "$data/$f.exr" ]; then
        black "$data/$f.exr" "$f" neutral
    else
        skip 1 "$no_data: $f"
    fi
done

# -- the same at all sizes -------------------------------------------------------

"$glarepp" -q -g 0 --tonemap none --raw rgbf32le -o - "$night" >night.raw
times='1 2'
[ -z "${GLAREPP_TEST_LONG-}" ] || times='1 2 4'
for k in $times; do
    measure repeat 960 "$k" night.raw "$k.exr"
    shown "plain.$k" -g 0 "$k.exr"
done
for style in $styles; do
    changes=
    for k in $times; do
        shown style.raw --style "$style" "$k.exr"
        changes="$changes $(measure change "plain.$k" style.raw)"
    done
    apart=$(measure same $changes)
    note "$style:$changes"
    ok "$style: the same at each size, within 1 %" at_most "$apart" 0.01
done

done_testing
