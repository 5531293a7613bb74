#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Errors of the engines on real frames, kernel 512x512, against the exact sum
# in double: rel_l2 within 1e-6 for direct and fft and 2e-6 for splat, and
# never over the bound that the engine states.
. "$(dirname "$0")/lib.sh"
need_python

# a frame of few columns, or rows: the far field keeps the tolerance
for row in 2x90000:fft 3x20000:fft 90000x2:fft; do
    size=${row%%:*}
    frame tall.exr size=$size hot=1000 type=float
    run -q --projection plane -t .3 --verify --report tall.json --layer tall.hdr.exr tall.exr
    quiet_success "$size"
    is "$("$python" -c 'import json
r = json.load(open("tall.json"))
print(r["engine"], r["measured"]["rel_l2"] <= r["bound"] < 1e-3)')" "${row#*:} True" \
        "$size: the fastest engine, within the tolerance" ||
        note "$(sed 's/.*"engine"/"engine"/; s/"flux_in.*"bound"/"bound"/' \
            tall.json | cut -c 1-300)"
done

# direct with a coarse far part is no better there: auto sums the whole one
frame few.exr size=2x12000 lights=5 type=float
run --style eye --tolerance 1e-7 --layer few.layer.exr few.exr
like "$(cat err)" '*a tolerance of 1e-07 (the lowest bound is *e-06, of direct, which runs)*' \
    'no engine within: what is nearest, with the whole kernel'
run -q --style eye --tolerance 1e-5 --verify --report few.json --layer few.layer.exr few.exr
is "$("$python" -c 'import json
r = json.load(open("few.json"))
print(r["engine"], r["measured"]["rel_l2"] <= r["bound"] < 1e-5)')" 'direct True' \
    'direct is, with the whole kernel'

# the far field is as coarse as the tolerance allows
frame far.exr size=420x60 lights=9 type=float
for row in 0.001:8 0.01:16 0.1:32; do
    run -q --style camera --projection plane --tolerance "${row%:*}" --verify --report coarse.json \
        --layer coarse.exr far.exr
    is "$("$python" -c 'import json
r = json.load(open("coarse.json"))
print(r["kernel"]["grid"], r["measured"]["rel_l2"] <= r["bound"] <= '"${row%:*}"')')" \
        "${row#*:} True" "tolerance ${row%:*}: the far field's grid"
done

frame kernel.exr kind=kernel size=512x512 type=float
gl=
frame small.exr
"$glarepp" --engine splat --projection plane --layer gl.exr small.exr 2>/dev/null && gl=yes

# -- one pixel of 1e9 in a frame of 1e-3 ----------------------------------------

# Each pixel's own value of the composite, outside the hot one's reach too
if [ -n "$oiio" ]; then
    >list
    frame dim.exr kind=dark dim=1e-3 hot=1e9 size=301x203 type=float
    frame reach.exr kind=kernel size=65x64 type=float
    for threshold in 0 1e-4 1; do
        for engine in direct fft; do
            "$glarepp" --engine $engine -t $threshold --max-value 1e9 --type float \
                --hdr hot.$threshold.$engine.exr -k reach.exr dim.exr
        done
        echo "hot.$threshold.fft.exr hot.$threshold.direct.exr each:2e-5 fft: 1e9 in a frame of 1e-3, -t $threshold" >>list
    done
    "$python" "$cli/compare.py" <list >verdicts
    verdicts verdicts
else
    skip 3 'no numpy and OpenImageIO'
fi

# a lamp on black: rounding stays under half a code of 8 bits
if [ -n "$oiio" ]; then
    "$python" -c 'import numpy as n, OpenImageIO as o
a = n.zeros((480, 640, 3), "f4")
a[200:219, 300:319] = 1e6
b = o.ImageBuf(o.ImageSpec(640, 480, 3, o.FLOAT))
b.set_pixels(o.ROI(), a)
b.write("lamp.exr")'
    for kernel in star ring gaussian:fwhm=1; do
        for engine in fft direct; do
            "$glarepp" -q -e $engine -k $kernel --type float --layer lamp.$engine.exr lamp.exr
        done
        is "$("$python" -c 'import OpenImageIO as o
a, b = [o.ImageBuf("lamp.%s.exr" % n).get_pixels(o.FLOAT) for n in ("fft", "direct")]
worst = (abs(a - b) - b / 500).max() # a code grows with its value
print(b.max() > 1 and worst <= 1.5e-4 or worst)')" True "a lamp on black, $kernel: no noise"
    done
else
    skip 3 'no numpy and OpenImageIO'
fi

# -- lamps in the dark ----------------------------------------------------------

# dark_lamps ARGUMENT...: engine, and whether the worst pixel is within its bound
# and that within 1e-5; of $lamps
lamps=dark.exr
dark_lamps()
{
    # (light from beyond the border is rounded to 2e-7 of a pixel)
    "$glarepp" -q --edges black -k kernel302.exr --verify --report dark.json --layer l.exr "$@" \
        "$lamps" && "$python" - <<'PY'
import json
j = json.load(open("dark.json"))
bound, worst = j.get("bound_pixel"), j["measured"]["max_rel"]
print(j["engine"], *[] if bound is None else [worst <= bound, bound <= 1e-5])
PY
}
frame kernel302.exr kind=kernel size=302x203 type=float
frame dark.exr lights=5000 dim=1e-6 size=640x460 type=float
is "$(dark_lamps -t 0.1)" fft 'lamps in the dark: no bound of a pixel unasked'
is "$(dark_lamps -e fft --tolerance-pixel 1e-5)" 'fft True True' \
    'lamps in the dark: fft in double keeps each pixel'
is "$(dark_lamps --tolerance-pixel 1e-7)" 'fft True True' \
    'lamps in the dark: --tolerance-pixel 1e-7 is kept'
frame light.exr lights=60 dim=0.9 size=640x460 type=float
lamps=light.exr
for type in half float; do # (fft_double is there where it is true)
    "$glarepp" -q --edges black -e fft -k kernel302.exr --type $type --hdr l.exr \
        --report dark.$type.json light.exr
done
is "$(grep -l fft_double dark.half.json dark.float.json)" dark.float.json \
    'lamps in the light: floats take fft in double, halves need none'
is "$(dark_lamps -e fft --type half --tolerance-pixel 1e-5)" 'fft True False' \
    'lamps in the light: fft in float may be over 1e-5 of a pixel'
is "$(dark_lamps --tolerance-pixel 1e-5)" 'direct True True' \
    'lamps in the light: auto takes direct, which keeps 1e-5 and is faster'
is "$(dark_lamps --tolerance-pixel 1e-6)" 'fft True True' \
    'lamps in the light: auto takes fft in double for --tolerance-pixel 1e-6'
run -k kernel302.exr --tolerance-pixel 1e-9 --layer l.exr dark.exr
like "$(cat err)" \
    '*warning: dark.exr: no engine guarantees a tolerance of 1e-09 in a pixel *; raise --tolerance-pixel*' \
    '--tolerance-pixel that nothing keeps: one line says so'

# -- turned kernels -------------------------------------------------------------

frame lamps.exr lights=40 size=150x111 type=float
"$glarepp" --no-provenance --engine fft -k kernel.exr --type float \
    --layer none.exr lamps.exr
"$glarepp" --no-provenance --engine fft -k kernel.exr --type float \
    --rotate 0 --layer zero.exr lamps.exr
"$glarepp" --no-provenance --engine fft -k kernel.exr --type float \
    --rotate 12.5 --layer some.exr lamps.exr
same none.exr zero.exr '--rotate 0: the same bytes as none'
no '--rotate 12.5 turns' cmp -s none.exr some.exr
if [ -n "$oiio" ]; then
    >list
    engines=direct
    [ -z "$gl" ] || engines='direct splat'
    for degrees in 90 -30 12.5; do
        for engine in fft $engines; do
            "$glarepp" -q --engine $engine --group 1 --cluster 0 --shrink 0 \
                -k kernel.exr --type float --rotate $degrees \
                --layer turned.$degrees.$engine.exr lamps.exr
        done
        for engine in $engines; do
            echo "turned.$degrees.$engine.exr turned.$degrees.fft.exr 2e-6 $engine and fft: --rotate $degrees" >>list
        done
    done
    "$python" "$cli/compare.py" <list >verdicts
    verdicts verdicts
else
    skip 6 'no numpy and OpenImageIO'
fi

# -- real frames ----------------------------------------------------------------

if [ -z "$data" ]; then
    skip 1 "$no_data"
    done_testing
    exit 0
fi

# verify ENGINE LIMIT THRESHOLD FRAME: with one polygon a source. The quick form,
# for builds many times slower, takes two frames
verify()
{
    case $quick:$4 in
    :* | *:night/moonless* | *:rendered/night*) ;;
    *) skip 1 'quick' && return ;;
    esac
    run -q --group 1 --cluster 0 --shrink 0 -k kernel.exr --engine "$1" -t "$3" --verify --report r.json "$data/$4"
    "$python" - "$2" <<'PY' >verdict 2>&1
import json, sys
o = json.load(open("r.json"))
error, bound = o["measured"]["rel_l2"], o["bound"]
print(error <= float(sys.argv[1]) and error <= bound and o["sources"] > 0,
      "rel_l2 %.2g, bound %.2g, %d sources" % (error, bound, o["sources"]))
PY
    rm -f r.json
    [ "$status" = 0 ] && grep -q ^True verdict
    result $? "$1 $4 -t $3: $(sed 's/^[^ ]* //' verdict)" ||
        note "status $status; $(cat err verdict)"
}

# thresholds that leave at most 5,000 sources
while read -r threshold name; do
    verify direct 1e-6 "$threshold" "$name"
done <<'END'
1 night/moonless_golf_1k.exr
1 rendered/night.1001.exr
50 windows/vestibule_1k.exr
20 sky/aristea_wreck_puresky_1k.exr
END

while read -r threshold name; do
    verify fft 1e-6 "$threshold" "$name"
done <<'END'
1 night/moonless_golf_1k.exr
1 rendered/night.1001.exr
1 foliage/rainforest_trail_1k.exr
1 windows/vestibule_1k.exr
1 windows/Desk.exr
1 sky/aristea_top_x2.5.exr
1 seq_foliage/foliage_f32.1001.exr
1 patterns/BrightRingsNanInf.exr
1 patterns/CLF_testImage.exr
0.5 windows_dw/oversizeDataWindow.exr
0.5 chromaticities/XYZ.exr
END

while read -r threshold name; do
    if [ -z "$gl" ]; then
        skip 1 'no GL'
    else
        verify splat 2e-6 "$threshold" "$name"
    fi
done <<'END'
1 night/moonless_golf_1k.exr
1 rendered/night.1001.exr
50 windows/vestibule_1k.exr
END
done_testing
