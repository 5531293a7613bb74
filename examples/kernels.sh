#!/bin/sh
# Usage: kernels.sh [GLAREPP]
# A contact sheet of all presets, and of models without one, on the night frame:
# a row each, columns of 540, 1080 and 2160 lines. By oiiotool, to kernels.jpg.
here=$(cd "$(dirname "$0")" && pwd)
glarepp=${1:-glarepp}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
presets=$("$glarepp" kernel --list |
    sed -n '/^Presets/,$s/^  \([a-z-][a-z-]*\) .*/builtin:\1/p')
for lines in 540 1080 2160; do
    oiiotool "$here/night.1001.exr" \
        --resample:interp=0 $((lines * 16 / 9))x$lines -o "$work/$lines.exr" || exit 1
done
set --
for kernel in $presets aperture temporal; do
    for lines in 540 1080 2160; do
        picture=$work/$kernel.$lines.png
        "$glarepp" -q -t 2 -k "$kernel" --exposure 2 -o "$picture" \
            "$work/$lines.exr" || exit 1
        oiiotool "$picture" --resize:filter=box 320x180 -o "$picture" || exit 1
        set -- "$@" "$picture"
    done
    echo "$kernel"
done
oiiotool "$@" --mosaic:pad=4 3x$(($# / 3)) --compression jpeg:85 -o kernels.jpg
