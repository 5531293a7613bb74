#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: parallel.sh [GLAREPP [FOLDER [PATTERN RANGE...]]]
# A sequence by ranges of frames (or frames) under GNU parallel: a job for each
# processor, each on one thread. The first job that fails ends the others; with
# --no-clobber the same command resumes where it was stopped. The engine is named,
# as auto's choice depends on the frame before, which another job may make.
set -eu
glarepp=${1:-glarepp} folder=${2:-lit}
frames=${3:-$(dirname "$0")/leaves.####.exr}
if [ $# -gt 3 ]; then shift 3; else set -- 1001-1002 1003-1004; fi
parallel -q --will-cite --halt now,fail=1 "$glarepp" --threads 1 --engine fft \
    -t 4 --no-clobber --fsync --create-dir -f {} \
    --hdr "$folder/lit.####.exr" -o "$folder/lit.####.png" "$frames" ::: "$@"
