#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Agreement with a program by someone else: the glare layer of scipy's
# convolution in float64, from the script reference.py beside the data. There
# all of a pixel over the threshold is a source, and values end at 65504.
. "$(dirname "$0")/lib.sh"
reference=$root/../shared/tools/reference.py
[ -f "$reference" ] || skip_all 'no reference.py'
[ -n "$data" ] || skip_all "$no_data"
[ -n "$oiio" ] || skip_all 'no numpy and OpenImageIO'
"$python" -c 'import scipy.signal' 2>/dev/null || skip_all 'no scipy'

frame even.exr kind=kernel size=512x512 type=float
frame odd.exr kind=kernel size=255x101 type=float
>list

# FRAME KERNEL THRESHOLD ENGINE...
while read -r name kernel threshold engines; do
    base=$(basename "$name" .exr)
    "$python" "$reference" "$data/$name" $kernel ref.$base.exr "$threshold" ||
        note 'reference.py failed'
    for engine in $engines; do
        run -q -k $kernel -t "$threshold" --threshold-mode whole --edges black \
            --engine $engine --type float --compression none \
            --layer $base.$engine.exr "$data/$name"
        quiet_success "$engine $name"
        echo "$base.$engine.exr ref.$base.exr 1e-6 $engine agrees with scipy on $name" >>list
    done
done <<'END'
night/moonless_golf_1k.exr even.exr 1 fft direct
windows/vestibule_1k.exr even.exr 1 fft
rendered/night.1001.exr odd.exr 1 fft direct
seq_foliage/foliage.1004.exr odd.exr 2 fft
END

"$python" "$cli/compare.py" <list >verdicts
verdicts verdicts
done_testing
