#!/bin/sh
# --ocio: the view of an OpenColorIO config in the place of --tonemap. Where
# oiiotool is there, its --ociodisplay is the truth.
. "$(dirname "$0")/lib.sh"
need_python
bridge=${glarepp%/*}/glarepp-ocio.so
no_provenance
unset OCIO

cp "$cli/c.ocio" . || exit 1
printf '4 0 0 0\n0 4 0 0\n0 0 4 0\n' >four.spimtx
printf '8 0 0 0\n0 8 0 0\n0 0 8 0\n' >eight.spimtx
primaries=0.64,0.33,0.21,0.71,0.15,0.06,0.3127,0.329
frame f.exr size=67x45 lights=9 \
    attr=chromaticities:chromaticities:$primaries attr=owner:string:me

# -- pictures ------------------------------------------------------------------

run --ocio c.ocio -o p.png -o p.exr -o p.tif --report r.json f.exr
quiet_success 'a view as PNG, EXR and TIFF'
no 'the PNG does not claim a colour space' grep -qE 'sRGB|gAMA|cHRM|cICP' p.png
no 'nor does the EXR that of the frame' grep -q chromaticities p.exr
ok 'other attributes stay' grep -q owner p.exr
is "$(field r.json 'o["ocio"]')" \
    "{'config': 'c.ocio', 'input': 'lin', 'display': 'Screen', 'view': 'Half'}" \
    'the report says what was used'
run -o s.png --report r.json f.exr
is "$(field r.json '"ocio" in o')" False 'and nothing without --ocio'
ok 'a tone-mapped PNG says that it is sRGB' grep -q sRGB s.png

run --ocio c.ocio --threads 1 -o 1.png --type float -o 1.exr f.exr
run --ocio c.ocio --threads 5 -o 5.png --type float -o 5.exr f.exr
same 1.png 5.png 'the same PNG for any threads'
same 1.exr 5.exr 'the same EXR for any threads'
OCIO=c.ocio "$glarepp" --ocio env -o e.png f.exr
same 1.png e.png '--ocio env takes $OCIO'
OCIO=c.ocio "$glarepp" --ocio '' -o e2.png f.exr
same 1.png e2.png 'so does an empty word'
run --ocio c.ocio --exposure 1 -o x.png f.exr
run --ocio c.ocio --look twice -o l.png f.exr
same x.png l.png '--exposure 1 is a look that doubles the light'
run --ocio c.ocio --auto-exposure -o a.png f.exr
quiet_success '--auto-exposure'
no '--auto-exposure changes it' cmp -s a.png 1.png
run --ocio c.ocio --view Shot --exposure 1 -o four.png f.exr
run --ocio c.ocio --view Shot --ocio-context SHOT=eight -o eight.png f.exr
same four.png eight.png '--ocio-context'
run --ocio c.ocio --dither -o d.png --depth-bits 8 f.exr
quiet_success '--dither'
no '--dither changes it' cmp -s d.png 1.png
run --ocio c.ocio --debug polygons=poly.png -e splat f.exr
quiet_success 'a view below the polygons'
run --ocio c.ocio --white 3 -o w.png f.exr
like "$(cat err)" '*warning: --white: does nothing with --ocio*' \
    '--white is told that it does nothing'

mkdir seq
cp f.exr seq/f.0001.exr
frame seq/f.0002.exr size=31x20
run --ocio c.ocio -o 'seq/o.####.png' 'seq/f.####.exr'
quiet_success 'a sequence whose frames change size'
same seq/o.0001.png 1.png 'its first frame'

# -- --hdr ---------------------------------------------------------------------

run --hdr h.exr f.exr
run --ocio c.ocio --output-space turned --hdr t.exr -o t.png --report r.json f.exr
quiet_success '--output-space'
ok 'without it --hdr keeps the primaries' grep -q chromaticities h.exr
no 'with it the old primaries are gone' grep -q chromaticities t.exr
ok 'other attributes of --hdr stay' grep -q owner t.exr
is "$(field r.json 'o["ocio"]["output"]')" turned 'the report names the space'
same t.png 1.png 'the picture does not change by it'
if [ -n "$oiio" ]; then
    ok 'the channels have turned' "$python" -c '
import OpenImageIO as o, numpy as n
h, t = (o.ImageBuf(f).get_pixels(o.FLOAT) for f in ("h.exr", "t.exr"))
assert n.array_equal(n.roll(h, 1, 2), t) and h.max() > 1'
else
    skip 1 'no OpenImageIO for python'
fi

# -- errors --------------------------------------------------------------------

mkdir made
# refused STATUS NAME DESCRIPTION ARGUMENT...
refused()
{
    wanted=$1 name=$2 what=$3
    shift 3
    run "$@" f.exr
    fails_with "$wanted" "$name" "$what"
    empty_folder made "$what: nothing is written"
}
refused 2 'give one of Screen' 'a wrong display' \
    --ocio c.ocio --display x -o made/p.png
refused 2 'give one of Half, Power, Shot' 'a wrong view' \
    --ocio c.ocio --view x -o made/p.png
refused 2 'give one of twice' 'a wrong look' \
    --ocio c.ocio --look x -o made/p.png
refused 2 'give one of lin, half, power, turned, shot' 'a wrong input space' \
    --ocio c.ocio --input-space x -o made/p.png
refused 2 '--output-space' 'a wrong output space' \
    --ocio c.ocio --output-space x --hdr made/h.exr
refused 2 '--ocio-context' 'a context without a value' \
    --ocio c.ocio --ocio-context SHOT -o made/p.png
refused 4 'none.spimtx' 'a LUT that is missing' \
    --ocio c.ocio --view Shot --ocio-context SHOT=none -o made/p.png
refused 2 '$OCIO' 'env without $OCIO' --ocio env -o made/p.png
refused 3 'missing.ocio' 'a config that is missing' \
    --ocio missing.ocio -o made/p.png
refused 3 '/dev/zero' 'a config that never ends' --ocio /dev/zero -o made/p.png
refused 4 'f.exr' 'a config that is a frame' --ocio f.exr -o made/p.png
refused 2 '--tonemap' 'a tone curve as well' \
    --ocio c.ocio --tonemap aces -o made/p.png
refused 2 '--view' 'a view without a config' --view Half -o made/p.png
refused 2 '--ocio-context' 'a context without a config' \
    --ocio-context A=B -o made/p.png
refused 2 '--output-space' 'an output space without --hdr' \
    --ocio c.ocio --output-space turned -o made/p.png
refused 2 '--display' 'a display without a picture' \
    --ocio c.ocio --display Screen --hdr made/h.exr
ldd "$bridge" 2>/dev/null | grep -q 'OpenColorIO.*2\.1' &&
    refused 2 'has no built-in configs' 'a built-in config' \
        --ocio ocio://default -o made/p.png

# -- against oiiotool ----------------------------------------------------------

# agrees CONFIG INPUT DISPLAY VIEW FRAME DESCRIPTION
agrees()
{
    oiiotool --colorconfig "$1" "$5" --ch R,G,B --ociodisplay:from="$2" \
        "$3" "$4" -d float -o o.exr -d uint8 -o o.png >/dev/null 2>&1
    run --ocio "$1" --input-space "$2" --display "$3" --view "$4" -g 0 \
        --type float -o g.exr -o g.png "$5"
    quiet_success "$6: made"
    ok "$6: within 1e-5" oiiotool --fail 1e-5 --hardfail 1e-5 --diff \
        g.exr o.exr
    ok "$6: within a code value" oiiotool --fail 0.00393 --hardfail 0.00393 \
        --diff g.png o.png
}
if command -v oiiotool >/dev/null; then
    agrees c.ocio lin Screen Half f.exr 'a matrix'
    agrees c.ocio turned Screen Power f.exr 'a power, from another space'
else
    skip 6 'no oiiotool'
fi
if command -v oiiotool >/dev/null && [ -n "$data" ]; then
    rings=$data/patterns/BrightRings.exr
    cg=$data/ocio/cg-config-v1.0.0_aces-v1.3_ocio-v2.1.ocio
    lut=$data/ocio/lut_minimal/config.ocio
    agrees "$cg" ACEScg 'sRGB - Display' 'ACES 1.0 - SDR Video' "$rings" ACES
    agrees "$cg" 'Linear Rec.709 (sRGB)' 'P3-D65 - Display' \
        'ACES 1.0 - SDR Cinema' "$rings" 'ACES for P3'
    agrees "$cg" ACEScg 'Rec.2100-PQ - Display' Un-tone-mapped "$rings" PQ
    agrees "$lut" linear sRGB Film "$rings" 'a cube'
    agrees "$lut" linear sRGB sRGB "$rings" 'a curve'
    run --ocio "$data/ocio/oiio_test_v0.9.2.ocio" -o made/p.png f.exr
    [ $status = 0 ] || fails_with 4 'refuses it (' 'a config of a later library'
else
    skip 15 "no oiiotool, or $no_data"
fi

done_testing
