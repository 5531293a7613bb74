#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: lens_lights.sh [GLAREPP]
# The lens stage of 100 lights in the Heliar on the night frame at 1920x1080, for
# three ranges of flux: ghosts drawn, least milliseconds of three runs of the
# stage, and of the whole process. By oiiotool.
root=$(cd "$(dirname "$0")/../.." && pwd)
glarepp=${1:-glarepp}
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
oiiotool "$root/tests/frames/night.1001.exr" --resize 1920x1080 \
    -o "$work/night.exr" || exit 1
for flux in 2e3 2e5 2e7; do
    awk -v flux=$flux 'BEGIN {
        for (i = 0; i < 100; i++) { # places and fluxes spread evenly
            v = flux * (1 + 3.5 * ((i * 0.618034) % 1))
            printf "%s{\"pixel\": [%g, %g], \"depth\": 0, \"flux\": [%g, %g, %g]}",
                i ? "," : "[", 1920 * ((i * 0.754878) % 1),
                1080 * ((i * 0.569840) % 1), v, 0.9 * v, 0.7 * v
        }
        print "]" }' >"$work/lights.json"
    for run in 1 2 3; do
        begin=$(date +%s%N)
        "$glarepp" -q -t 2 --lights "$work/lights.json" --lens heliar \
            --sensor-size 36 --report "$work/report.json" \
            -o "$work/out.exr" "$work/night.exr" || exit 1
        end=$(date +%s%N)
        ghosts=$(sed 's/.*"ghosts":\([0-9]*\).*/\1/' "$work/report.json")
        lens=$(sed 's/.*"times_ms":{[^}]*"lens":\([0-9.]*\).*/\1/' \
            "$work/report.json")
        echo "$ghosts $lens $(((end - begin) / 1000000))"
    done | awk -v flux=$flux '
        NR == 1 || $2 < lens { lens = $2 }
        NR == 1 || $3 < process { process = $3 }
        END { print "flux from", flux ": ghosts", $1 ", lens", lens,
              "ms, process", process, "ms" }'
done
