#!/bin/bash
# Usage: run.sh BUILD "UNIT_BINARIES" "MAKE_CHECKS" [no-cli | "CLI_TESTS"]
# Runs every test, prints what failed, and ends with "N passed, N failed".
# GLAREPP_RUN is put before each unit test (valgrind).
build=$1 units=$2 checks=$3 cli=${4-}
cd "$(dirname "$0")/.." || exit 1
log=$build/test-logs
mkdir -p "$log"
passed=0 failed=0

# count NAME LOG STATUS: adds up a TAP log; a death without a word is a failure
count()
{
    local ok not
    # what was skipped, with a reason, neither passed nor failed
    ok=$(grep -E '^[[:space:]]*ok ' "$2" | grep -ciEv '# skip')
    not=$(grep -E '^[[:space:]]*not ok ' "$2" | grep -ciEv '# skip')
    if [ "$3" != 0 ] && [ "$not" = 0 ] || ! grep -qE '^[[:space:]]*(not )?ok |^1\.\.0 # |skipped: ' "$2"; then
        not=$((not + 1))
    fi
    passed=$((passed + ok)) failed=$((failed + not))
    if [ "$not" != 0 ]; then
        echo "FAILED $1 (status $3); the end of $2:"
        grep -nE -A6 '^[[:space:]]*not ok ' "$2" | grep -iv '# skip' | head -60
        tail -n 12 "$2"
    else
        echo "ok     $1: $ok"
    fi
}

for check in $checks; do
    make --no-print-directory B="$build" "$check" > "$log/$check.log" 2>&1
    status=$?
    if [ $status = 0 ]; then echo "ok 1 $check"; else echo "not ok 1 $check"; fi \
        >> "$log/$check.log"
    count "$check" "$log/$check.log" $status
done

for unit in $units; do
    name=${unit##*/}
    CMOCKA_MESSAGE_OUTPUT=TAP $GLAREPP_RUN "$unit" > "$log/$name.log" 2>&1
    count "$name" "$log/$name.log" $?
done

[ -n "$cli" ] || cli=$(cd tests/cli && echo *.t)
[ "$cli" != no-cli ] || cli=
for test in $cli; do
    name=${test%.t}
    GLAREPP=$PWD/$build/glarepp prove -v "tests/cli/$name.t" \
        > "$log/$name.log" 2>&1
    count "$name.t" "$log/$name.log" $?
done

echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
