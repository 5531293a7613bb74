#!/bin/sh
# Usage: layers.sh [GLAREPP]
# For a compositor: the frame with glare and all its channels, the glare layer,
# and the light sources, all as float and without tone mapping.
here=$(dirname "$0")
exec "${1:-glarepp}" -t 4 --hdr foliage.lit.exr --layer foliage.glare.exr \
    --debug sensors=foliage.light.exr --type float --report foliage.json \
    "$here/foliage.1004.exr"
