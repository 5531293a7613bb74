#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
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
frame f.exr size=67x45 lights=9 attr=owner:string:me
frame named.exr size=67x45 lights=9 attr=owner:string:me \
    attr=chromaticities:chromaticities:$primaries

# -- pictures ------------------------------------------------------------------

run --ocio c.ocio -o p.png -o p.exr -o p.tif --report r.json f.exr
quiet_success 'a view as PNG, EXR and TIFF'
no 'the PNG does not claim a colour space' grep -qE 'sRGB|gAMA|cHRM|cICP' p.png
run --ocio c.ocio -q -o n.exr named.exr
no 'nor does the EXR that of the frame' grep -q chromaticities n.exr
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
run --ocio c.ocio --no-dither -o d.png --depth-bits 8 f.exr
quiet_success '--no-dither'
no '--no-dither changes it' cmp -s d.png 1.png
run --ocio c.ocio --debug polygons=poly.png -e splat --projection plane f.exr
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

run --hdr h.exr named.exr
ok 'without it --hdr keeps the primaries' grep -q chromaticities h.exr
run --ocio c.ocio --output-space turned --hdr t.exr --ignore-chromaticities named.exr
is "$(grep -c 'turned.*no chromaticities$' err) $(wc -l <err)" '1 1' \
    '--output-space of unknown primaries: a line'
no 'with it the old primaries are gone' grep -q chromaticities t.exr
run --hdr h.exr f.exr
run -q --ocio c.ocio --output-space turned --hdr t.exr -o t.png --report r.json f.exr
quiet_success '--output-space'
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

# -- spaces of inputs ----------------------------------------------------------

cp "$cli/aces.ocio" . || exit 1
ap0=0.7347,0.2653,0,1,0.0001,-0.077,0.32168,0.33767
frame ap0.exr size=67x45 lights=9 attr=chromaticities:chromaticities:$ap0
frame bt709.exr size=67x45 lights=9 \
    attr=chromaticities:chromaticities:0.64,0.33,0.3,0.6,0.15,0.06,0.3127,0.329

# as_if SPACE FRAME FLAG...: the frame, which says what it is, is shown as the
# one of the same numbers that says nothing is shown from SPACE
as_if()
{
    space=$1 named=$2
    shift 2
    run --ocio aces.ocio -g 0 --type float -o said.exr "$@" "$named"
    quiet_success "$named: its chromaticities are honoured, $*"
    run --ocio aces.ocio -g 0 --type float -o told.exr --input-space "$space" f.exr
    ok "$named: as $space, $*" "$glarepp" compare --fail 2e-5 --hardfail 2e-5 \
        said.exr told.exr
}
as_if ap0 ap0.exr
as_if ap0 ap0.exr --input-space lin709
as_if lin709 bt709.exr
as_if cg ap0.exr --ignore-chromaticities
run --ocio aces.ocio -g 0 --type float -o said.exr ap0.exr
no 'a frame in AP0 is not one in ACEScg' "$glarepp" compare --fail 0.2 \
    said.exr told.exr
run --ocio aces.ocio -o g.png --input-space log ap0.exr
is "$(grep -c '^glarepp: warning: ap0.exr: its chromaticities are ignored' err)" 1 \
    'an input space that is not linear: a line that it is not honoured'
run --ocio c.ocio -o 'g.####.png' --report r.json --frames 1-3 "$(
    for n in 1 2 3; do cp named.exr g.000$n.exr; done; echo 'g.####.exr')"
is "$(grep -c 'its chromaticities are ignored' err) $(wc -l <err)" '1 1' \
    'a config that does not say: one line for all frames'
is "$(field r.json '"ignored" in o["warnings"][0]')" True 'and in the report'

for bad in 0,0,0,0,0,0,0,0 nan,nan,nan,nan,nan,nan,nan,nan; do
    frame bad.exr size=8x8 attr=chromaticities:chromaticities:$bad
    for config in aces.ocio c.ocio; do
        run --ocio $config -o g.png bad.exr
        is "$(grep -c 'bad.exr.*they are no colours (red.*--ignore-chrom' err) $(
            wc -l <err)" '1 1' "$config, chromaticities $bad: a line that says so"
    done
done

# written SPACE CHROMATICITIES
written()
{
    run --ocio aces.ocio --output-space "$1" -g 0 --type float --hdr w.exr ap0.exr
    quiet_success "--output-space $1"
    is "$("$python" "$cli/tags.py" w.exr | grep chroma)" "chromaticities=$2" \
        "--output-space $1: its chromaticities"
}
written lin709 0.6400,0.3300,0.3000,0.6000,0.1500,0.0600,0.3127,0.3290
written xyz 1.0000,0.0000,0.0000,1.0000,0.0000,0.0000,0.3333,0.3333
written cg 0.7130,0.2930,0.1650,0.8300,0.1280,0.0440,0.3217,0.3377
written ap0 0.7347,0.2653,0.0000,1.0000,0.0001,-0.0770,0.3217,0.3377
ok '--output-space of what the frame is in: the frame' "$glarepp" compare \
    --failrelative 1e-5 --fail 1e-5 w.exr ap0.exr
run --ocio aces.ocio --output-space lin709 -g 0 --type float --hdr w.exr ap0.exr
run --ocio aces.ocio -g 0 --type float -o said.exr w.exr
run --ocio aces.ocio -g 0 --type float -o told.exr ap0.exr
ok '--output-space: what was written is the same light' "$glarepp" compare \
    --fail 1e-4 --hardfail 1e-4 said.exr told.exr


# other layers of the part
frame ml.exr size=67x45 lights=9 attr=chromaticities:chromaticities:$ap0 \
    channels=R,G,B,diffuse.R,diffuse.G,diffuse.B,N.R,N.G,N.B type=float
run --ocio aces.ocio --output-space lin709 -g 0 --type float --hdr w.exr ml.exr
quiet_success '--output-space of a file of layers'
run --ocio aces.ocio --output-space lin709 -g 0 --type float --hdr v.exr \
    --layer-in diffuse ml.exr
ok '--output-space: R,G,B is converted beside a layer' "$glarepp" compare \
    --fail 1e-6 w.exr v.exr
for name in v ml; do
    run -q -g 0 --tonemap none --type float -o $name.rgb.exr $name.exr
    run -q -g 0 --tonemap none --type float --layer-in N -o $name.N.exr $name.exr
done
no '--output-space: which changes it' "$glarepp" compare --fail 0.1 v.rgb.exr ml.rgb.exr
ok '--output-space: normals stay' "$glarepp" compare --fail 0 v.N.exr ml.N.exr
run -v --ocio aces.ocio --output-space lin709 -g 0 --type float --hdr v1.exr \
    --hdr v2.exr ml.exr
is "$(grep -c 'converts the layers of diffuse.R too$' err)" 1 \
    '--output-space: -v names the layers, once'
same v2.exr w.exr '--output-space: converted once for two files'

# cicp DISPLAY CHUNK
cicp()
{
    run --ocio aces.ocio --display "$1" -o w.png f.exr
    is "$status $("$python" "$cli/tags.py" w.png | grep -a cICP)" "0 ${2:+cICP=$2}" \
        "$1: cICP ${2:-unknown}"
}
cicp PQ 9,16,0,1
cicp P3-PQ 12,16,0,1
cicp HLG 9,18,0,1
cicp sRGB 1,13,0,1
cicp Gamma ''
cicp Named 9,16,0,1
run --ocio aces.ocio --display PQ --view Raw -o w.png f.exr
quiet_success 'numbers as they are'
no 'numbers as they are, on a PQ display: no cICP' grep -q cICP w.png
if command -v exrheader >/dev/null && command -v oiiotool >/dev/null; then
    for n in 1 2; do
        oiiotool --create 8x8 3 --attrib name p$n --attrib:type='float[8]' \
            chromaticities $ap0 -o part$n.exr
    done
    oiiotool part1.exr part2.exr --siappend -o parts.exr
    run --ocio aces.ocio --output-space lin709 --hdr w.exr parts.exr
    is "$(grep -c 'part 1 is not converted' err)" 1 'another part is not converted: a line'
    ok 'OpenEXR reads what has one part converted' exrheader w.exr
else
    skip 2 'no exrheader'
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

# agrees CONFIG INPUT DISPLAY VIEW FRAME DESCRIPTION: within 1e-5, and as a PNG
# within a code value
agrees()
{
    run --ocio "$1" --input-space "$2" --display "$3" --view "$4" -g 0 \
        --type float -o g.exr -o g.png "$5"
    quiet_success "$6: made"
    ok "$6: as by oiiotool" oiiotool --colorconfig "$1" "$5" --ch R,G,B \
        --ociodisplay:from="$2" "$3" "$4" -d float -o o.exr -d uint8 -o o.png \
        --fail 1e-5 --hardfail 1e-5 g.exr o.exr --diff \
        --fail 0.00393 --hardfail 0.00393 g.png o.png --diff
    rm -f [go].exr [go].png
}
if command -v oiiotool >/dev/null; then
    agrees c.ocio lin Screen Half f.exr 'a matrix'
    agrees c.ocio turned Screen Power f.exr 'a power, from another space'
else
    skip 4 'no oiiotool'
fi
if [ -n "$data" ]; then
    for config in '' $data/ocio/cg-config-v1.0.0_aces-v1.3_ocio-v2.1.ocio; do
        for name in XYZ Rec709; do
            run ${config:+--ocio "$config" --input-space} \
                ${config:+'Linear Rec.709 (sRGB)'} -q -e fft --type float \
                -o $name.exr "$data/chromaticities/$name.exr"
        done
        ok "XYZ looks as BT.709${config:+, --ocio}" "$glarepp" compare --fail 4e-3 \
            XYZ.exr Rec709.exr
    done
else
    skip 2 "$no_data"
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
    skip 10 "no oiiotool, or $no_data"
fi

done_testing
