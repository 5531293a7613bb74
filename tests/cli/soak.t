#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A short soak; `make soak` has frames without end.
. "$(dirname "$0")/lib.sh"
[ -n "$oiio" ] || skip_all 'no numpy and OpenImageIO'
python_gl=--no-gl
frame can.exr
"$glarepp" -q --engine splat --projection plane --layer none.exr can.exr 2>/dev/null && python_gl=

# At most 30 s: how many frames that is depends on the machine
frames=20
[ -z "$quick" ] || frames=12
for seed in 1 2; do
    "$python" "$root/tests/soak/soak.py" "$glarepp" --frames $((frames / 2)) \
        --seed $seed --folder soak --seconds 15 $python_gl >out 2>&1
    result $? "seed $seed: $(grep ' frames, ' out)" || note "$(cat out)"
    note "$(grep -v ' frames, ' out)"
done

# A program is found out whose engines' runs get other options: all of them, or
# those alone that are not the ones into whole float files
while read -r case runs words fault; do
    right="' --engine direct '"
    [ "$runs" = all ] || right="$right* | *' --type float --compression zip '"
    cat >wrong <<END_OF_SCRIPT
#!/bin/sh
case " \$* " in
' compare '* | *$right*) exec "$glarepp" "\$@" ;;
esac
exec "$glarepp" "\$@" $(echo "$words" | tr = ' ')
END_OF_SCRIPT
    chmod +x wrong
    no "wrong in $runs files, $words: a fault" "$python" \
        "$root/tests/soak/soak.py" ./wrong --seed 1 --only "$case" --no-gl \
        --folder wrong.d
    cp ok.log found
    ok "that says $fault" grep -q "^case $case: $fault[ :,]" found
done <<END_OF_ROWS
2 dwaa --max-value=2 stored layer
2 b44 -g=0.5 stored hdr
0 pxr24 --exposure=1 stored out
0 half --max-value=1.1 stored layer
1 all --max-value=1.1 layer
28 all --max-value=0.6 lobes
74 all -g=0.5 hdr
74 all --exposure=0.01 picture
END_OF_ROWS
done_testing
