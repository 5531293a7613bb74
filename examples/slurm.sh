#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A sequence on a Slurm cluster: each task of the array makes a range of frames.
#
# Usage: sbatch --array=0-9 [SBATCH OPTIONS] slurm.sh FIRST LAST N INPUT OUTPUT
#               [GLAREPP OPTIONS]
#
# FIRST to LAST are the frames, N is the number of frames of a task; the array
# counts tasks from 0, so that 100 frames by 10 are --array=0-9. INPUT and OUTPUT
# are patterns in a folder that all nodes share:
#
#   sbatch --array=0-9 --cpus-per-task=4 slurm.sh 1001 1100 10 \
#       /show/shot.####.exr /show/lit.####.exr --engine fft
#
# A task that is killed and queued again continues after the last frame that it
# finished: frames that exist are skipped, and a frame gets its name only when it
# is complete. Exit status 6 (with --skip-bad-frames) means that some frames
# failed; the log ends with their list. GLAREPP names the program if it is not in
# the PATH.
#
#SBATCH --job-name=glarepp
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --ntasks=1
set -eu
usage='sbatch --array=0-9 slurm.sh FIRST LAST N INPUT OUTPUT [OPTIONS]'
[ $# -ge 5 ] || {
    echo "slurm.sh: $# arguments; write $usage" >&2
    exit 2
}
[ -n "${SLURM_ARRAY_TASK_ID-}" ] || {
    echo "slurm.sh: not a task of an array (SLURM_ARRAY_TASK_ID is not set);" \
        "write $usage" >&2
    exit 2
}
number() { # without the zeros that would make it octal
    echo "$1" | sed 's/^0*\([0-9]\)/\1/'
}
first=$(number "$1") last=$(number "$2") n=$3 input=$4 output=$5
shift 5
from=$((first + SLURM_ARRAY_TASK_ID * n))
to=$((from + n - 1))
[ "$to" -le "$last" ] || to=$last
[ "$from" -le "$to" ] || exit 0 # more tasks than frames
exec "${GLAREPP:-glarepp}" --frames "$from-$to" --no-clobber --fsync --create-dir \
    --threads "${SLURM_CPUS_PER_TASK:-1}" --hdr "$output" "$@" "$input"
