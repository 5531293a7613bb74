#!/bin/sh
# Usage: flares.sh [GLAREPP [FRAME...]]
# A contact sheet of the installed flares: a row each, on the night frame, on the
# foliage and on each FRAME, whose bright pixels or --sun of 5e4 in a corner
# light it; then the first row's element sizes at 540, 1080 and 2160 lines. By
# oiiotool, to flares.jpg.
here=$(cd "$(dirname "$0")" && pwd)
glarepp=${1:-glarepp}
[ $# = 0 ] || shift
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cat >"$work/lamps.json" <<'JSON'
[{"pixel": [261, 137], "radius": 5, "flux": [6000, 4500, 2800]},
 {"pixel": [621, 193], "radius": 6, "flux": [3500, 4500, 6000]}]
JSON

# shot FLARE PICTURE ARGUMENT...: one picture of the sheet
shot()
{
    flare=$1 picture=$work/$2.png
    shift 2
    "$glarepp" -q --flare "preset:$flare" --tonemap agx -o "$picture" "$@" ||
        exit 1
    oiiotool "$picture" --resize:filter=box 480x270 -o "$picture" || exit 1
}

set -- "$@"
columns=$(($# + 4))
frames=$*
set --
for flare in anamorphic zoom vintage lamps veil; do
    listed="--lights $work/lamps.json --sun-in-frame"
    sun="--camera $here/foliage.camera.json --sun-color 1.2e6,1.1e6,8e5
        --sun-in-frame"
    case $flare in lamps | veil) listed='' sun='' ;; esac
    shot $flare $flare.n -t 2 --exposure 1 $listed "$here/night.1001.exr"
    shot $flare $flare.f -t 4 $sun "$here/foliage.1004.exr"
    set -- "$@" "$work/$flare.n.png" "$work/$flare.f.png"
    for lines in 1080 2160; do
        oiiotool "$here/foliage.1004.exr" \
            --resize:filter=triangle $((lines * 16 / 9))x$lines \
            -o "$work/$lines.exr" || exit 1
        shot $flare $flare.$lines -t 4 $sun "$work/$lines.exr"
        set -- "$@" "$work/$flare.$lines.png"
    done
    n=0
    for frame in $frames; do
        n=$((n + 1))
        case $flare in
        lamps | veil) shot $flare $flare.x$n -t 4 "$frame" ;;
        *) shot $flare $flare.x$n -t 4 --sun 500,60,3 --sun-color 5e4 "$frame" ;;
        esac
        set -- "$@" "$work/$flare.x$n.png"
    done
    echo "$flare"
done
oiiotool "$@" --mosaic:pad=4 ${columns}x$(($# / columns)) \
    --compression jpeg:85 -o flares.jpg
