#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Usage: run.sh BUILD FRAMES
# Measures the figures of README and manual on this machine. FRAMES is a folder that
# holds w1..w3 (few lights, windows, a sky) at 1024x768, 1920x1080, 3840x2160
# and the kernel k512.exr; it is filled by frames.py when it is empty.
# PEER=PROGRAM, an older glarepp: both side by side, first of all.
build=$1 frames=$2
here=$(dirname "$0")
runs=${RUNS:-9}
glarepp=$build/glarepp
pair() { "$build/bench/pair" "$runs" "$@"; }

set -eu
missed=0 # 1: a bar does not hold
mkdir -p "$frames"
[ -e "$frames/w3_3840.exr" ] || /usr/bin/python3 "$here/frames.py" "$frames"
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT

if [ -n "${PEER-}" ]; then
    echo "# $PEER, side by side: the new time over the old"
    /usr/bin/python3 "$here/versions.py" "$PEER" "$glarepp" "$frames" "$runs"
    /usr/bin/python3 "$here/cold.py" "$PEER" "$glarepp" "$build/bench/plain" \
        "$frames" "$runs"
fi

echo "# glare stage, the first frame of a run against later ones"
/usr/bin/python3 "$here/first.py" "$glarepp" "$frames"

echo "# true angles: their error, and their time over a plane's"
FRAMES=$frames /usr/bin/python3 "$here/bars.py" "$glarepp" angles || missed=1

echo "# CPU of the sensors, with lights that are found"
/usr/bin/python3 "$here/lights.py" "$glarepp" "$frames" "$runs"

echo "# whole process, w2, float ZIP in, half ZIP out, against OpenEXR C++ + FFTW"
for size in "1920 2304 1344" "3840 4096 2560"; do
    set -- $size
    printf '%s ' "$1"
    pair "$glarepp" --type half --compression zip -k "$frames/k512.exr" \
        --hdr "$tmp/a.exr" "$frames/w2_$1.exr" -- \
        "$build/bench/plain" glare "$frames/w2_$1.exr" "$tmp/b.exr" 2 \
        "$frames/k512.exr" "$2" "$3"
done

echo "# whole process, half ZIP in and out, against OpenEXR C++ decode + encode"
for size in 1920 3840; do
    for kernel in builtin:eye "$frames/k512.exr"; do
        "$build/bench/plain" copy "$frames/w2_$size.exr" "$tmp/half.exr" 2
        printf '%s %s ' "$size" "${kernel##*/}"
        pair "$glarepp" -k "$kernel" --hdr "$tmp/a.exr" "$tmp/half.exr" -- \
            "$build/bench/plain" copy "$tmp/half.exr" "$tmp/b.exr" 2
    done
done

echo "# start-up beyond an empty program (ratio to true is no bar; see wall)"
printf 'version '
pair "$glarepp" --version -- true
oiiotool "$frames/w1_1024.exr" --cut 64x64+0+0 --fill:color=2,2,2 4x4+30+30 \
    -d half -o "$tmp/small.exr"
oiiotool "$frames/k512.exr" --cut 65x65+224+224 -o "$tmp/k65.exr"
printf '64x64 fft '
pair "$glarepp" -e fft -k "$tmp/k65.exr" --hdr "$tmp/a.exr" "$tmp/small.exr" \
    -- true

echo "# sequences: one run, a run for each frame, and the files alone"
/usr/bin/python3 "$here/sequence.py" "$glarepp" "$build/bench/plain" "$frames"

echo "# peak memory at 3840x2160, EXR and PNG out"
for frame in w1 w2 w3; do
    "$glarepp" -k "$frames/k512.exr" --hdr "$tmp/a.exr" -o "$tmp/a.png" \
        --report "$tmp/r.json" "$frames/${frame}_3840.exr"
    awk -v f=$frame 'match($0, /"peak_rss_mib":[0-9.]+/) {
        m = substr($0, RSTART + 15, RLENGTH - 15)
        printf "%s %s MiB, %.0f bytes a pixel\n", f, m,
            m * 1048576 / 3840 / 2160 }' "$tmp/r.json"
done

echo "# sun and flare at 1920x1080: times_ms.sun, median beyond the first frame"
rendered=$here/../frames
for i in 1 2 3 4 5 6; do
    oiiotool "$rendered/foliage.1004.exr" --resize:filter=box 1920x1080 \
        -o "$tmp/sun.$i.exr"
done
# lamps N FLUX: a lights file
lamps()
{
    awk -v n="$1" -v flux="$2" 'BEGIN { for (i = 0; i < n; i++)
        printf "%s{\"pixel\": [%d, %d], \"radius\": %.1f, \"flux\": %d}%s",
            i ? "," : "[", 50 + i * 677 % 1820, 50 + i * 389 % 980,
            2 + i % 7, flux, i < n - 1 ? "" : "]\n" }' >"$tmp/lamps.$1.$2"
}
lamps 1 0; lamps 64 0; lamps 1 1000; lamps 64 1000
# sun_ms NAME OPTIONS...
sun_ms()
{
    name=$1
    shift
    "$glarepp" "$@" --report "$tmp/r.json" --layer "$tmp/l.#.exr" "$tmp/sun.#.exr"
    sed -n '2,$s/.*"sun":\([0-9.]*\).*/\1/p' "$tmp/r.json" | sort -n |
        awk -v name="$name" '{ v[NR] = $1 }
            END { printf "%-42s %6.1f ms\n", name, v[int((NR + 1) / 2)] }'
}
sun="--sun 849.7,387.2,7.44 --sun-color 1e6,9e5,7e5 --flare $rendered/flare.json"
for way in exact readback mask; do
    sun_ms "one sun, eight elements, $way" $sun --sun-method $way
done
for n in 1 64; do
    sun_ms "shares of $n lamps, exact" --lights "$tmp/lamps.$n.0"
    sun_ms "shares of $n lamps, mask" --lights "$tmp/lamps.$n.0" \
        --sun-method mask
    sun_ms "glare of $n lamps, exact" --lights "$tmp/lamps.$n.1000"
done
exit $missed
