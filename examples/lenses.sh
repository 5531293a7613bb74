#!/bin/sh
# Usage: lenses.sh [GLAREPP [LENS...]]
# A contact sheet of ghosts in four lenses, or those given: the sun through
# leaves, as much brighter than the sky as it is (3e5 times, over 80 pixels), and
# a searchlight at night. By oiiotool, to lenses.jpg.
here=$(cd "$(dirname "$0")" && pwd)
glarepp=${1:-glarepp}
[ $# = 0 ] || shift
lenses=${*:-zoom-wide double-gauss heliar tessar}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
set --
for lens in $lenses; do
    "$glarepp" -q -t 4 --tonemap agx --camera "$here/foliage.camera.json" \
        --sun-color 2.4e7,2.2e7,1.8e7 --sun-in-frame --lens $lens \
        -o "$work/day.$lens.png" "$here/foliage.1004.exr" || exit 1
    "$glarepp" -q -t 2 --tonemap agx --sun 640,90,3 \
        --sun-color 9e6,8e6,6e6 --sun-in-frame --sensor-size 36 \
        --lens $lens -o "$work/night.$lens.png" "$here/night.1001.exr" ||
        exit 1
    for at in day night; do
        set -- "$@" "$work/$at.$lens.png" --resize:filter=box 480x270
    done
    echo "$lens"
done
oiiotool "$@" --mosaic:pad=4 "2x$(($# / 6))" --compression jpeg:85 -o lenses.jpg
