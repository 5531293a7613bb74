#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: pipe.sh [GLAREPP]
# In a pipe: EXR in on stdin, EXR out on stdout.
here=$(dirname "$0")
cat "$here/hall.exr" | "${1:-glarepp}" -t 4 --hdr - - > hall.lit.exr
