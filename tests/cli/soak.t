#!/bin/sh
# A short soak; `make soak` has frames without end.
. "$(dirname "$0")/lib.sh"
[ -n "$oiio" ] || skip_all 'no numpy and OpenImageIO'
python_gl=--no-gl
frame can.exr
"$glarepp" -q --engine splat --layer none.exr can.exr 2>/dev/null && python_gl=

# At most 30 s: how many frames that is depends on the machine
frames=60
[ -z "$quick" ] || frames=12
for seed in 1 2; do
    "$python" "$root/tests/soak/soak.py" "$glarepp" --frames $((frames / 2)) \
        --seed $seed --folder soak --seconds 15 $python_gl >out 2>&1
    result $? "seed $seed: $(grep ' frames, ' out)" || note "$(cat out)"
    note "$(grep -v ' frames, ' out)"
done

# The soak finds what is wrong: an engine whose layer is a little off
cat >wrong <<END_OF_SCRIPT
#!/bin/sh
case " \$* " in
*' --engine direct '*) exec "$glarepp" "\$@" ;;
*' -t '*) exec "$glarepp" "\$@" --max-value 1.7 ;;
esac
exec "$glarepp" "\$@"
END_OF_SCRIPT
chmod +x wrong
no 'a wrong layer is a fault' "$python" "$root/tests/soak/soak.py" ./wrong \
    --frames 4 --seed 1 --folder wrong.d $python_gl
cp ok.log found
ok 'and is told apart' grep -q 'layer: .* measured' found
done_testing
