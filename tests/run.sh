#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Usage: run.sh BUILD "UNIT_BINARIES" "MAKE_CHECKS" [no-cli | TEST... | -TEST...]
# Runs every test, of the command-line ones none, those named, or all but those
# named; prints what failed and what was skipped for which reason, and ends with
# "N passed, N failed, N skipped".
# GLAREPP_TEST_JOBS at a time, else two more than there are processors: some wait.
# GLAREPP_TEST_SKIP names suites that are left out, as ROOM/SUITE.
# GLAREPP_RUN is put before each unit test (valgrind); GLAREPP_PROGRAM is what the
# command-line tests run, else glarepp of BUILD.
build=$1 units=$2 checks=$3 cli=" ${*:4} "
cd "$(dirname "$0")/.." || exit 1
log=$build/test-logs
mkdir -p "$log"
passed=0 failed=0 skipped=0
python=/usr/bin/python3
[ -x "$python" ] || python=python3
GLAREPP_TEST_OIIO=no
! "$python" -c 'import numpy, OpenImageIO' 2>/dev/null || GLAREPP_TEST_OIIO=yes
export GLAREPP_TEST_OIIO
# a program that does not lie in the repository is told where the lenses are
case $(realpath "$build") in
"$PWD"/*) ;;
*) export GLAREPP_EXAMPLES="${GLAREPP_EXAMPLES-$PWD/examples}" ;;
esac

# count NAME LOG STATUS SECONDS TENTHS: adds up a TAP log; a death without a word is a
# failure
count()
{
    local ok not skip
    # (cmocka calls a test that was skipped "not ok N # SKIP")
    skip=$(grep -acE '^[[:space:]]*((not )?ok [0-9]+|1\.\.0) # (SKIP|skip)' "$2")
    ok=$(grep -aE '^[[:space:]]*ok ' "$2" | grep -aciEv '# skip')
    not=$(grep -aE '^[[:space:]]*not ok ' "$2" | grep -aciEv '# skip')
    if [ "$3" != 0 ] && [ "$not" = 0 ] || ! grep -aqE '^[[:space:]]*(not )?ok |^1\.\.0 # |skipped: ' "$2"; then
        not=$((not + 1))
    fi
    passed=$((passed + ok)) failed=$((failed + not)) skipped=$((skipped + skip))
    [ "$skip" = 0 ] || reasons "$1" "$2" >>"$log/skipped"
    if [ "$not" != 0 ]; then
        echo "FAILED $1 (status $3); the end of $2:"
        grep -anE -A6 '^[[:space:]]*not ok ' "$2" | grep -aiv '# skip' | head -60
        tail -n 12 "$2"
    else
        echo "ok     $1: $ok$([ "$skip" = 0 ] || echo ", $skip skipped")" \
            "($4 s, $(($5 / 10)).$(($5 % 10)) s of processors)"
    fi
}

# reasons NAME LOG: one line for each test that was skipped
reasons()
{
    case $1 in
    *.t | *.sh) sed -nE 's/^(ok [0-9]+|1\.\.0) # SKIP //p' "$2" ;;
    *) sed -n 's/^# skipped: //p' "$2" ;;
    esac
}

# seconds_of TIME: of "MmS.SSSs", as `times` prints, in tenths
seconds_of()
{
    local minutes=${1%%m*} rest=${1#*m}
    echo $((minutes * 600 + 10#${rest%%.*} * 10 + 10#$(cut -c1 <<<"${rest#*.}")))
}

# run_one KIND PATH NAME [SUITE]: leaves NAME.log, NAME.status, NAME.seconds
# (passed, and spent on processors in tenths)
run_one()
{
    local began=$SECONDS user sys
    case $1 in
    check)
        if make --no-print-directory B="$build" "$2"; then
            echo "ok 1 $2"
        else
            echo "not ok 1 $2"
            false
        fi
        ;;
    unit) CMOCKA_MESSAGE_OUTPUT=TAP $GLAREPP_RUN "$2" $4 ;;
    cli) GLAREPP=${GLAREPP_PROGRAM:-$(realpath "$build")/glarepp} prove -v "$2" ;;
    esac > "$log/$3.log" 2>&1
    echo $? > "$log/$3.status"
    times >"$log/$3.times"
    { read -r _; read -r user sys; } <"$log/$3.times"
    echo $((SECONDS - began)) $(($(seconds_of "$user") + $(seconds_of "$sys"))) \
        > "$log/$3.seconds"
}

# chosen NAME: whether the command-line test is to run
chosen()
{
    case $cli in
    *" no-cli "* | *" -$1 "*) return 1 ;;
    *" $1 "*) return 0 ;;
    *' '[a-z]*) return 1 ;; # others are named
    esac
}

# Two more at a time than there are processors, as tests that kill, stop or count on
# a clock leave theirs idle; printed in the order of the list
first='hardcases-.*|faults\.t|flight\.t|check-(tidy|clang|cppcheck)|formats\.t'
first="$first|manual\.t|styles\.t|data\.t|bench\.t|determinism\.t|soak\.t|fuzz\.t"
first="$first|lens\.t|names\.t|farm\.t|install\.t|sun-lens_draw|api-fail_nth"
first="$first|browser\.t|blender\.sh|compare\.t|engines\.t|glare-edges|scene-sets"
tasks=()
for check in $checks; do tasks+=("check $check $check"); done
for test in tests/cli/*.t tests/page/*.t tests/blender.sh; do
    name=${test##*/}
    ! chosen "${name%.*}" || tasks+=("cli $test $name")
done
for unit in $units; do
    room=${unit##*/}
    if [ "$room" = hardcases ]; then
        for family in $("$unit" families); do
            tasks+=("unit $unit hardcases-$family $family")
        done
        continue
    fi
    for suite in $("$unit" --list); do
        case " $GLAREPP_TEST_SKIP " in *" $room/$suite "*) continue ;; esac
        tasks+=("unit $unit $room-$suite $suite")
    done
done
# (those that take longest first, so that none of them is last)
longest=$(printf '%s\n' "${tasks[@]}" | grep -E " ($first)( |$)")
others=$(printf '%s\n' "${tasks[@]}" | grep -vE " ($first)( |$)")
printf '%s\n' "$longest" "$others" | grep . >"$log/order"
while read -r -u 9 task; do
    while [ "$(jobs -rp | wc -l)" -ge "${GLAREPP_TEST_JOBS:-$(($(nproc) + 2))}" ]; do
        wait -n
    done
    run_one $task 9<&- &
done 9<"$log/order"
wait
: >"$log/skipped"
for task in "${tasks[@]}"; do
    read -r _ _ name _ <<<"$task"
    count "$name" "$log/$name.log" "$(cat "$log/$name.status")" \
        $(cat "$log/$name.seconds")
done

sort "$log/skipped" | uniq -c | sort -rn | sed 's/^ *\([0-9]*\) /skipped \1: /'
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" = 0 ]
