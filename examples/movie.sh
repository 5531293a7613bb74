#!/bin/sh
# Usage: movie.sh [GLAREPP [MOVIE [PATTERN SIZE]]]
# Frames into ffmpeg as 16-bit pixels, with no file in between. FFV1 keeps every
# code; to watch, take -c:v libx264 -pix_fmt yuv420p and a name in .mp4.
glarepp=${1:-glarepp} movie=${2:-foliage.mkv}
frames=${3:-$(dirname "$0")/foliage.####.exr} size=${4:-640x360}
"$glarepp" -t 4 --tonemap agx --raw rgb48le -o - "$frames" |
    ffmpeg -v error -y -f rawvideo -pixel_format rgb48le -video_size "$size" \
        -framerate 24 -i - -c:v ffv1 "$movie"
