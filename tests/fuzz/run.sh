#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Usage: run.sh BUILD SECONDS [TARGET...]
# Runs each target of BUILD over its corpus and over what seeds.sh makes with
# the program beside BUILD, and fuzzes it that long when SECONDS is over 0 and it
# can, two at a time. What is found stays in WORK/TARGET, and a failing input
# beside it. Prints TAP.
#
#   GLAREPP_DATA          its damaged/ is read in place; default ../shared/data
#   GLAREPP_FUZZ_WORK     WORK; default BUILD/work
set -u
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(cd "$1" && pwd) || exit 1
seconds=$2
shift 2
data=$(cd "$root" && cd "${GLAREPP_DATA:-../shared/data}" 2>/dev/null && pwd)
# The bars for CPU time and heap are in the targets; these end what hangs or
# grows before it gets there
limits="-timeout=20 -rss_limit_mb=2048 -malloc_limit_mb=512"

[ $# != 0 ] || set -- $(cd "$build" && ls | sed -n 's/^fuzz_\([a-z]*\)$/\1/p')
work=${GLAREPP_FUZZ_WORK:-$build/work}
mkdir -p "$work"
[ ! -x "$build/../glarepp" ] ||
    "$root/tests/fuzz/seeds.sh" "$build/../glarepp" "$work" || exit 1

# run_target NAME: writes NAME.log and NAME.status
run_target()
{
    local name=$1 dict=$root/tests/fuzz/dict/$1 folders
    shift
    mkdir -p "$work/$name"
    folders="$work/$name $root/tests/fuzz/corpus/$name"
    case $name in
    other) # the only one that may start the helper, which takes its time
        export GLAREPP_BRIDGES=${GLAREPP_BRIDGES:-$build/..}
        set -- -timeout=120
        ;;
    frame | raw | members)
        [ ! -d "$data/damaged" ] || folders="$folders $data/damaged"
        [ -f "$dict" ] || dict=$root/tests/fuzz/dict/exr
        ;;
    esac
    if [ "$seconds" -gt 0 ]; then
        set -- -max_total_time="$seconds" -dict="$dict" -max_len=65536 "$@"
    else
        set -- -runs=0 -max_len=262144 "$@"
    fi
    (cd "$work" && exec "$build/fuzz_$name" $limits "$@" \
        -print_final_stats=1 -artifact_prefix="$work/$name-" \
        $folders) >"$work/$name.log" 2>&1
    echo $? >"$work/$name.status"
}

# "123456 runs, 789 features" from libFuzzer's log; "98 inputs" without it
figures()
{
    sed -n -e 's/^stat::number_of_executed_units: *\([0-9]*\)/\1 runs/p' \
        -e 's/^\([0-9]* inputs\)$/\1/p' "$1" | tail -1
    sed -n 's/^#.* ft: \([0-9]*\) .*/, \1 features/p' "$1" | tail -1
}

for name; do
    while [ "$(jobs -rp | wc -l)" -ge 2 ]; do wait -n; done
    run_target "$name" &
done
wait

n=0 bad=0
for name; do
    n=$((n + 1))
    log=$work/$name.log
    if [ "$(cat "$work/$name.status")" = 0 ]; then
        echo "ok $n - $name: $(figures "$log" | tr -d '\n')"
    else
        bad=$((bad + 1))
        echo "not ok $n - $name: see $log"
        grep -vE '^(#[0-9]|INFO|NEW_FUNC)' "$log" | head -n 25 | sed 's/^/# /'
    fi
done
echo "1..$n"
[ $bad = 0 ]
