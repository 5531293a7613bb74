#!/bin/sh
# Usage: flares.sh [GLAREPP [FRAME...]]
# A contact sheet of the installed flares, a row each: on the night frame, on the
# foliage at 540, 1080 and 2160 lines (or those of env HEIGHTS), and on each
# FRAME of 640x360, with a lamp in its upper right. By oiiotool, to flares.jpg.
here=$(cd "$(dirname "$0")" && pwd)
glarepp=${1:-glarepp}
[ $# = 0 ] || shift
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cat >"$work/lamps.json" <<'JSON'
[{"pixel": [257, 133], "depth": 0, "flux": [40000, 28000, 16000]},
 {"pixel": [621, 192], "depth": 0, "flux": [22000, 29000, 40000]}]
JSON
cat >"$work/lamp.json" <<'JSON'
[{"pixel": [448, 72], "depth": 0, "flux": [90000, 80000, 70000]}]
JSON

# shot FLARE PICTURE ARGUMENT...: one picture
shot()
{
    flare=$1 picture=$work/$2.png
    shift 2
    "$glarepp" -q --flare "preset:$flare" --tonemap agx -o "$picture" "$@" ||
        exit 1
}

heights=${HEIGHTS:-540 1080 2160}
frames=$*
for lines in $heights; do
    mkdir "$work/$lines"
    oiiotool "$here/foliage.1004.exr" \
        --resize:filter=triangle $((lines * 16 / 9))x$lines \
        -o "$work/$lines/foliage.1004.exr" || exit 1
done
small='--resize:filter=box 480x270'
set --
for flare in anamorphic zoom vintage lamps veil; do
    listed="--lights $work/lamps.json --sun-in-frame"
    case $flare in lamps | veil) listed='' ;; esac
    shot $flare $flare.n -t 2 --exposure 1 $listed "$here/night.1001.exr"
    set -- "$@" "$work/$flare.n.png" $small
    for lines in $heights; do
        # flux is summed over pixels: four times as much at twice the lines
        sun="--camera $here/foliage.camera.json --sun-in-frame --sun-color
            $((9 * lines * lines)),$((8 * lines * lines)),$((6 * lines * lines))"
        case $flare in lamps | veil) sun='' ;; esac
        shot $flare $flare.$lines -t 4 $sun "$work/$lines/foliage.1004.exr"
        set -- "$@" "$work/$flare.$lines.png" $small
    done
    n=0
    for frame in $frames; do
        n=$((n + 1))
        case $flare in
        lamps | veil) shot $flare $flare.x$n -t 1 "$frame" ;;
        *) shot $flare $flare.x$n -t 4 --lights "$work/lamp.json" \
            --sun-in-frame "$frame" ;;
        esac
        set -- "$@" "$work/$flare.x$n.png" $small
    done
    echo "$flare"
done
oiiotool "$@" --mosaic:pad=4 "$(($# / 15))x5" \
    --compression jpeg:85 -o flares.jpg
