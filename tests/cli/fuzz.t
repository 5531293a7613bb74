#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Every fuzz target runs its corpus, and fuzzes for a while where clang made
# it. GLAREPP_FUZZ_TIME: seconds for each, default 1, two at a time.
. "$(dirname "$0")/lib.sh"
build=${glarepp%/*}/fuzz
[ -x "$build/fuzz_frame" ] ||
    skip_all 'no fuzz targets; make fuzz-build makes them'
command -v bash >/dev/null || skip_all 'no bash'

seconds=${GLAREPP_FUZZ_TIME:-1}
[ -z "$quick" ] || seconds=0

# Without a fuzzer in it a target knows no options, and runs its corpus alone
grep -q 'libFuzzer' "$build/fuzz_frame" || seconds=0

GLAREPP_FUZZ_WORK=$tmp/work GLAREPP_DATA=${data:-/nonexistent} \
    bash "$root/tests/fuzz/run.sh" "$build" "$seconds" >tap
sed -e '/^1\.\.[0-9]*$/d' -e 's/^\(ok\|not ok\) [0-9]* - /\1 /' tap >verdict
verdicts verdict
ok 'there are targets' [ "$(grep -c . verdict)" -gt 7 ]
for t in "$root"/tests/fuzz/corpus/*; do
    n=$(find "$t" -type f | wc -l)
    size=$(cat "$t"/* | wc -c)
    ok "the corpus of ${t##*/} is small ($n files, $size bytes)" \
        [ "$n" -gt 0 -a "$n" -le 10 -a "$size" -lt 40960 ]
done
done_testing
