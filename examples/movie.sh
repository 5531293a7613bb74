#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: movie.sh [GLAREPP [MOVIE [PATTERN SIZE]]]
# Pipes frames into ffmpeg as 16-bit pixels. A MOVIE that ends in .mp4 plays in
# browsers and QuickTime: H.264 in 4:2:0, an even size, BT.709 matrix and tags. Any
# other is FFV1, which is lossless.
glarepp=${1:-glarepp} movie=${2:-leaves.mkv}
frames=${3:-$(dirname "$0")/leaves.####.exr} size=${4:-640x360}
case $movie in
*.mp4)
    even='pad=ceil(iw/2)*2:ceil(ih/2)*2'
    set -- -vf "$even,scale=out_color_matrix=bt709:out_range=tv" \
        -pix_fmt yuv420p -c:v libx264 -crf 18 -color_primaries bt709 \
        -color_trc bt709 -colorspace bt709 -color_range tv -movflags +faststart
    ;;
*) set -- -c:v ffv1 ;;
esac
"$glarepp" -t 4 --tonemap agx --raw rgb48le -o - "$frames" |
    ffmpeg -v error -y -f rawvideo -pixel_format rgb48le -video_size "$size" \
        -framerate 24 -i - "$@" "$movie"
