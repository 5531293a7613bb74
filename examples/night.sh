#!/bin/sh
# Usage: night.sh [GLAREPP]
# Street lamps at night: 40 % of the light over 2 moves into the glare; a 16-bit
# picture for grading.
here=$(dirname "$0")
exec "${1:-glarepp}" -t 2 --gain 0.4 --exposure 2 \
    --depth-bits 16 --dither -o night.png "$here/night.1001.exr"
