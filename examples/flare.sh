#!/bin/sh
# Usage: flare.sh [GLAREPP [FRAMES [CAMERA [FOLDER]]]]
# A sequence with lens flare that dims as leaves hide the sun: FRAMES is a
# pattern of frames with depth, CAMERA a file for --camera. Without them, two
# frames beside this script. The frames already show the sun, so its flux lights
# only the flare (--sun-in-frame).
here=$(dirname "$0")
frames=${2:-$here/foliage.####.exr}
camera=${3:-$here/foliage.camera.json}
out=${4:-flare}
exec "${1:-glarepp}" --create-dir -v -t 4 --tonemap agx \
    --camera "$camera" --sun-color 2.4e6,2.2e6,1.7e6 --sun-in-frame \
    --flare "$here/flare.json" --report "$out.json" \
    -o "$out/foliage.####.png" "$frames"
