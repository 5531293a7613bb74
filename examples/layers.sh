#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: layers.sh [GLAREPP]
# For a compositor: the frame with glare and all its channels, the glare layer,
# and the light sources, all as float and without tone mapping.
here=$(dirname "$0")
exec "${1:-glarepp}" --hdr street.lit.exr --layer street.glare.exr \
    --debug sensors=street.light.exr --type float --report street.json \
    "$here/street.exr"
