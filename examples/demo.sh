#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: demo.sh GLAREPP FOLDER
# Renders the example frames to FOLDER and prints files, times and errors.
# `make demo` calls it.
glarepp=$1 out=$2
here=$(dirname "$0")
set -eu
mkdir -p "$out"
report=$out/report.jsonl
: > "$report"

# render NAME FRAME OPTIONS...: makes a picture, and the frame with glare
render()
{
    name=$1 frame=$2
    shift 2
    "$glarepp" "$@" --verify --report "$out/$name.json" \
        -o "$out/$name.png" --hdr "$out/$name.exr" "$here/$frame"
    cat "$out/$name.json" >> "$report"
    rm "$out/$name.json"
}

render street street.exr --style anamorphic
render hall hall.exr --style mist
render lamp lamp.exr --style vintage

# field NAME: a number or a word of the JSON line on stdin
awk -v out="$out" '
function field(name)
{
    if (!match($0, "\"" name "\":[\"]?[^,\"}]*"))
        return "-"
    text = substr($0, RSTART, RLENGTH)
    sub(/^"[^"]*":"?/, "", text)
    return text
}
BEGIN {
    printf "%-28s %-9s %-7s %8s %9s %9s %10s %10s\n", "made (.png and .exr)",
        "size", "engine", "sources", "glare ms", "total ms", "rel_l2",
        "bound"
}
{
    input = field("input")
    sub(/.*\//, "", input)
    sub(/\..*/, "", input)
    printf "%-28s %-9s %-7s %8s %9s %9s %10.2e %10.2e\n", out "/" input,
        field("width") "x" field("height"), field("engine"),
        field("sources"), field("glare"), field("total"), field("rel_l2"),
        field("bound")
}' "$report"
echo "rel_l2: error of the glare layer against the exact one, computed in double;"
echo "bound: its upper limit, known before the engine ran. All fields: $report"
