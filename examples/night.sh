#!/bin/sh
# Usage: night.sh [GLAREPP]
# Street lamps at night: a threshold with a knee, energy kept (what glares is
# taken from its source), and a 16-bit picture for the grade.
here=$(dirname "$0")
exec "${1:-glarepp}" -t 2 --knee 0.5 --mix scatter --gain 0.4 --exposure 2 \
    --depth-bits 16 --dither -o night.png "$here/night.1001.exr"
