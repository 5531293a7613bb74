#!/bin/sh
# Usage: pipe.sh [GLAREPP]
# In a pipe: EXR in on stdin, EXR out on stdout.
here=$(dirname "$0")
cat "$here/brightsky.1001.exr" | "${1:-glarepp}" -t 4 --hdr - - > sky.lit.exr
