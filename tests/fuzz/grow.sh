#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Usage: grow.sh BUILD SECONDS
# Grows the corpora: fuzzes each target from its seeds and from what
# tests/fuzz/corpus has, and keeps there the ten files that reach most.
# No file of another origin takes part. found-* are inputs that once failed;
# they stay.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "$1" && pwd)
grow=$build/grow
GLAREPP_DATA=/nonexistent GLAREPP_FUZZ_WORK=$grow \
    "$root/tests/fuzz/run.sh" "$build" "$2"
for folder in "$root"/tests/fuzz/corpus/*; do
    name=${folder##*/}
    [ "$name" != other ] || continue # what its files reach is not seen
    merged=$grow/$name.merged
    rm -rf "$merged" "$merged.control"
    mkdir "$merged"
    cp "$folder"/* "$grow/$name/"
    (cd "$grow" && "$build/fuzz_$name" -merge=1 -timeout=10 -max_len=6144 \
        -merge_control_file="$merged.control" "$merged" "$grow/$name") \
        >"$grow/$name.merge.log" 2>&1
    find "$folder" -type f ! -name 'found-*' -delete
    /usr/bin/python3 "$root/tests/fuzz/pick.py" "$merged.control" "$folder"
done
