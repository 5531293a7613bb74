#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Formats in and out, and what --hdr carries along.
. "$(dirname "$0")/lib.sh"
need_python
[ -n "$oiio" ] || skip_all 'no numpy and OpenImageIO to compare with'
command -v oiiotool >/dev/null || skip_all 'no oiiotool'
no_provenance

frame in.exr size=97x61 type=half
frame rich.exr size=97x61 origin=-7,5 display=0,0,79,63 \
    channels=R,G,B,A,Z:float,normals.X,normals.Y,normals.Z,id:uint \
    part=depth.left:Z:float part=mask:A:half \
    attr=owner:string:somebody attr=framesPerSecond:float:23.976 \
    attr=shot:int:12 attr=offset:v2f:0.25,-3.5 \
    attr=worldToCamera:m44f:1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16
>list

# pfm IN OUT: portable float map, which oiiotool does not write
pfm()
{
    "$python" - "$1" "$2" <<'PY'
import sys, numpy as np, OpenImageIO as oiio
px = oiio.ImageBuf(sys.argv[1]).get_pixels(oiio.FLOAT)[::-1, :, :3]
with open(sys.argv[2], "wb") as f:
    f.write(b"PF\n%d %d\n-1.0\n" % (px.shape[1], px.shape[0]))
    f.write(np.ascontiguousarray(px, "<f4").tobytes())
PY
}

# batch OPTION... FILE...: one run of all these files, whose names have numbers,
# that skips those that fail: oiiotool and the program that reads by OpenImageIO
# take a quarter of a second to start
batch()
{
    run -q --frame-jobs 1 --skip-bad-frames --report batch.json "$@"
}

# each_refused FILE...: they were the frames of the last batch: status and line
each_refused()
{
    for name; do
        ok "$name: status 4" \
            grep -q "\"input\":\"$name\".*\"status\":4," batch.json
        is "$(grep -c "^glarepp: $name: .*; ." err)" 1 "$name: one line"
    done
    status_is 6 'and the run ends'
    is "$(wc -l <err)" $(($# + 1)) 'with a line about all'
}

# -- other formats in ----------------------------------------------------------

frame kernel.exr kind=kernel size=15x15 type=float
pfm in.exr f.2.pfm
pfm kernel.exr kernel.pfm
oiiotool kernel.exr -d float -o kernel.tif in.exr -d float -o f.3.tif \
    -o:tile=64x64 tiles.1.tif -d double -o:tile=64x64 tiles.2.tif \
    -d half -o q.0001.tif -o q.0003.tif -o q.0004.tif \
    -d uint8 -o cut.8.dpx -d uint10 -o cut.10.dpx -d uint12 -o cut.12.dpx \
    -d uint16 -o cut.16.dpx --attrib oiio:ColorSpace Linear -o linear.7.png \
    in.exr --attrib oiio:ColorSpace sRGB \
    -o f.1.hdr -o f.4.jpg -o f.5.dpx -o f.6.png \
    f.1.hdr -d float --compression none -o same.1.exr f.2.pfm -o same.2.exr \
    f.3.tif -o same.3.exr >ok.log 2>&1
run -t 0.6 --type float --hdr h.#.exr --layer l.#.exr f.1.hdr f.2.pfm f.3.tif \
    f.4.jpg f.5.dpx f.6.png
quiet_success 'reads HDR, PFM, TIFF, JPEG, DPX and PNG'
# the same pixels in an EXR give the same light
run -t 0.6 --type float --hdr e.#.exr --layer g.#.exr same.?.exr
for file in 1.hdr 2.pfm 3.tif; do
    n=${file%.*} ending=${file#*.}
    echo "h.$n.exr e.$n.exr equal .$ending in: frame as from EXR" >>list
    echo "l.$n.exr g.$n.exr equal .$ending in: layer as from EXR" >>list
done
echo "h.5.exr:R,G,B l.5.exr:R,G,B 1e9 .dpx in: three channels" >>list
for file in 4.jpg 6.png; do
    head -c $(($(wc -c <f.$file) / 2)) f.$file >cut.$file
    run --hdr cut.exr cut.$file
    fails_with 4 cut.$file "$file in: cut off"
done
# nothing is over this threshold: the frame passes
batch -t 1e9 -g 0 --type float --hdr passed.#.exr f.4.jpg f.6.png linear.7.png \
    tiles.1.tif
echo "passed.4.exr f.4.jpg srgb:2e-3 .jpg in: the sRGB curve is taken off" >>list
echo "passed.6.exr f.6.png srgb:2e-3 .png in: the sRGB curve is taken off" >>list
echo "passed.7.exr linear.7.png 1e-6 .png in: a linear one stays as it is" >>list
echo "passed.1.exr in.exr equal tiles of floats" >>list
run --hdr refused.exr tiles.2.tif
fails_with 4 tiles.2.tif 'tiles of doubles'
# strips of more than the 16 MiB that are read at once, of which OpenImageIO
# reads packed doubles wrong
large='--pattern noise:type=uniform:min=0:max=1:seed=3 1500x480 3'
packings='zip:480 zip:470 lzw:480 none:480 zip:8'
n=0
# shellcheck disable=SC2046
oiiotool $large -d float -o large.exr -d double $(for packed in $packings; do
    echo "--compression ${packed%:*} --attrib tiff:RowsPerStrip ${packed#*:}"
    echo "-o large.$((n += 1)).tif"
done)
batch -t 1e9 -g 0 --type float --compression none --hdr large.#.exr large.?.tif
quiet_success 'reads doubles in TIFF'
for packed in $packings; do
    n=$((n + 1))
    echo "large.$n.exr large.exr equal doubles in TIFF, $packed" >>list
done

for ending in exr tif pfm; do
    run -q -k kernel.$ending --type float --layer k.$ending.exr in.exr
    quiet_success "a kernel from .$ending"
done
echo "k.tif.exr k.exr.exr equal a kernel from .tif: as from EXR" >>list
echo "k.pfm.exr k.exr.exr equal a kernel from .pfm: as from EXR" >>list

# -- other formats out ---------------------------------------------------------

run --type float --layer layer.exr --tonemap none -o lit.exr in.exr
run --type half --type float --layer layer.tif in.exr
quiet_success 'the last of an option that comes twice holds'
run --type float --layer layer.tif --layer layer.pfm --layer layer.hdr \
    --tonemap none -o lit.tif -o lit.pfm -o lit.hdr in.exr
quiet_success 'writes TIFF, PFM and HDR'
for ending in tif pfm hdr; do
    limit=equal
    [ $ending != hdr ] || limit=1e-2 # shared exponents: 8 bits
    echo "layer.$ending layer.exr $limit .$ending out: the layer" >>list
    echo "lit.$ending lit.exr $limit .$ending out: --tonemap none is the light" >>list
done
run --type float -o shown.exr --depth-bits 16 -o shown.png -o shown16.tif in.exr
frame smooth.exr kind=kernel size=64x48
run --type float -o smooth.shown.exr -o shown.jpg smooth.exr
run --no-dither -o shown8.png -o shown.dpx in.exr
quiet_success 'several pictures in one run'
echo "shown.exr shown.png srgb:2e-5 16-bit PNG is EXR with the sRGB curve" >>list
echo "shown.exr shown8.png srgb:4e-3 8-bit PNG is EXR with the sRGB curve" >>list
echo "smooth.shown.exr shown.jpg srgb:5e-2 JPEG is EXR with the sRGB curve" >>list
echo "shown.exr shown.dpx 1e9 DPX can be read" >>list

# a larger PNG, by every reader
run --threads 1 --no-dither --tonemap linear --type float -o png.exr -o png.png large.exr
run --threads 2 --no-dither --tonemap linear -o png2.png large.exr
ok 'large PNG: the same bytes for any threads' cmp png.png png2.png
echo "png.exr png.png srgb:4e-3 large PNG, by OpenImageIO" >>list
run -t 1e9 -g 0 --type float --hdr png.libpng.exr png.png
echo "png.libpng.exr png.png srgb:1e-6 large PNG, by libpng" >>list
if "$python" -c 'import PIL' 2>/dev/null; then
    ok 'large PNG, by Pillow' "$python" -c 'from PIL import Image
Image.open("png.png").save("png.tif")'
    echo "png.tif png.png equal large PNG, by Pillow: pixels" >>list
else
    skip 2 'no Pillow (python3-pil)'
fi
if convert -version 2>/dev/null | grep -q '^Version: ImageMagick'; then
    ok 'large PNG, by ImageMagick' convert png.png -depth 8 png.ppm
    echo "png.ppm png.png equal large PNG, by ImageMagick: pixels" >>list
else
    skip 2 'no ImageMagick'
fi
if command -v ffmpeg >/dev/null; then
    ok 'large PNG, by ffmpeg' ffmpeg -v error -xerror -y -i png.png -c:v targa png.tga
    echo "png.tga png.png equal large PNG, by ffmpeg: pixels" >>list
else
    skip 2 'no ffmpeg'
fi

# -- EXR out: every compression and type ---------------------------------------

for type in half float; do
    run --type $type --compression none --hdr $type.none.exr rich.exr
    for compression in none rle zips zip piz pxr24 b44 b44a dwaa dwab; do
        name=$type.$compression.exr
        run --type $type --compression $compression --hdr $name rich.exr
        quiet_success "writes $type $compression"
        ok "$type $compression: the header says so" \
            sh -c "exrheader $name | grep -q '^compression .*: $compression\$' ||
                exrinfo $name | grep -q \"compression: '$compression'\""
        limit=equal
        case $type.$compression in
        float.pxr24) limit=1e-4 ;; # 24 bits
        *b44*) limit=3e-2 ;;       # floats are not packed
        *dwa*) limit=1e-1 ;;
        esac
        echo "$name:R,G,B $type.none.exr:R,G,B $limit $type $compression: colour" >>list
        case $compression in
        b44* | dwa* | pxr24) ;;
        *)
            echo "$name $type.none.exr equal $type $compression: all channels" >>list
            echo "$name@1 rich.exr@1 equal $type $compression: the second part" >>list
            ;;
        esac
    done
done
exrheader half.zip.exr >half.head
exrheader float.zip.exr >float.head
ok '--type half: R is half' grep -q '^ *R, 16-bit' half.head
ok '--type float: R is float' grep -q '^ *R, 32-bit floating' float.head
run --layer auto.exr in.exr
ok '--type auto: half in, half out' sh -c \
    'exrheader auto.exr | grep -q "^ *R, 16-bit"'
frame single.exr type=float
run --hdr auto.exr single.exr
ok '--type auto: float in, float out' sh -c \
    'exrheader auto.exr | grep -q "^ *R, 32-bit floating"'

# -- channels and attributes that --hdr carries --------------------------------

run --grow none --hdr carried.exr rich.exr
quiet_success '--hdr of three parts'
exrheader carried.exr >carried.head
exrheader rich.exr >rich.head
# all lines of the header but those that the writer decides
plain()
{
    grep -vE '^(file |compression|chunkCount| *[0-9]+ part)' "$1" |
        grep -vE '^$' | sort
}
plain rich.head >rich.plain
plain carried.head >carried.plain
ok '--hdr: windows, channels, types and attributes of all parts' \
    cmp rich.plain carried.plain
echo "carried.exr:A,Z,id,normals.X,normals.Y,normals.Z rich.exr:A,Z,id,normals.X,normals.Y,normals.Z equal --hdr: other channels untouched" >>list
echo "carried.exr@1 rich.exr@1 equal --hdr: the second part" >>list
echo "carried.exr@2 rich.exr@2 equal --hdr: the third part" >>list
run -t 1e9 -g 0 --grow none --hdr dark.exr rich.exr
echo "dark.exr rich.exr equal --hdr without light: the frame itself" >>list
frame first.exr size=64x48 origin=3,3 attr=owner:string:x
run -g 0 --hdr nogain.exr first.exr
echo "nogain.exr first.exr equal --gain 0: the frame itself" >>list

# -- PNG -----------------------------------------------------------------------

# colour types: 2 RGB, 6 RGB and alpha
run -o p8.png --depth-bits 8 rich.exr
is "$(png_size p8.png)" '80x64 8 2' 'PNG: display window, 8 bits, no alpha'
run -o p16.png --depth-bits 16 rich.exr
is "$(png_size p16.png)" '80x64 16 2' 'PNG: display window, 16 bits'
run -o a8.png --alpha keep rich.exr
is "$(png_size a8.png)" '80x64 8 6' '--alpha keep: PNG with alpha'
run -o a.png --alpha keep in.exr
is "$(png_size a.png)" '97x61 8 2' '--alpha keep: no alpha where there is none'
run --hdr a.h.exr --hdr b.h.exr --layer a.l.exr --layer b.l.exr --report r.json \
    in.exr
quiet_success 'two of --hdr and --layer'
same a.h.exr b.h.exr 'both --hdr are made'
same a.l.exr b.l.exr 'both --layer are made'
like "$(cat r.json)" '*"outputs":\["a.h.exr","b.h.exr","a.l.exr","b.l.exr"\]*' \
    'the report lists them'
# the channel in every format that has one; the picture over black in all others
frame alpha.exr size=40x30 channels=R,G,B,A:float
run --alpha keep -o keep.png -o keep.exr -o keep.tif -o keep.webp -o keep.tga \
    -o keep.sgi -o keep.rgba -o keep.bmp -o keep.dpx -o keep.tx --layer keep.layer.exr alpha.exr
quiet_success '--alpha keep: formats with alpha'
run -o black.exr -o black.sgi -o black.bmp -o black.dpx -o black.jpg -o black.ppm \
    -o black.pfm -o black.hdr alpha.exr
echo "keep.exr:A alpha.exr:A equal --alpha keep: EXR" >>list
echo "keep.exr:R,G,B black.exr:R,G,B equal --alpha keep: EXR: colours are associated" >>list
echo "keep.rgba:A alpha.exr:A 2e-3 --alpha keep: .rgba" >>list
for ending in sgi bmp dpx; do
    echo "keep.$ending:A alpha.exr:A 2e-3 --alpha keep: .$ending" >>list
    echo "keep.$ending:R,G,B black.$ending:R,G,B equal --alpha keep: .$ending: colours are associated" >>list
done
for ending in tif tx webp tga; do
    echo "keep.$ending:A keep.png:A equal --alpha keep: .$ending as PNG" >>list
done
is "$(exrinfo keep.layer.exr | grep -c "'A'")" 0 '--alpha keep: a layer has none'
"$glarepp" --alpha keep --stdout-format png -o - alpha.exr >keep.stdout.png
same keep.stdout.png keep.png '--alpha keep: PNG to stdout'
run --alpha keep -o keep.jpg -o keep.ppm -o keep.pfm -o keep.hdr alpha.exr
for ending in jpg ppm pfm hdr; do
    status_is 0 "--alpha keep: .$ending"
    like "$(cat err)" "*keep.$ending: --alpha keep: *" "--alpha keep: .$ending: a line"
    same keep.$ending black.$ending "--alpha keep: .$ending is over black"
done
"$glarepp" --alpha keep --raw rgb24 -o - alpha.exr 2>err | wc -c >bytes
is "$(cat bytes)" 3600 '--alpha keep: raw has three channels'
like "$(cat err)" '*--alpha keep: *' '--alpha keep: raw: a line'
for chunk in sRGB gAMA; do
    ok "PNG: has the chunk $chunk" grep -qa $chunk p8.png
    ok "16-bit PNG: has the chunk $chunk" grep -qa $chunk p16.png
done

# -- dither --------------------------------------------------------------------

eight=png
[ -z "$oiio" ] || eight='png tif tga bmp sgi ppm webp jpg'
# shellcheck disable=SC2046
run $(for end in $eight; do echo "-o d1.$end"; done) in.exr
# shellcheck disable=SC2046
run $(for end in $eight; do echo "-o d.$end"; done) --threads 1 in.exr
# shellcheck disable=SC2046
run $(for end in $eight; do echo "-o nod.$end"; done) --no-dither in.exr
for end in $eight; do
    same d.$end d1.$end "8-bit .$end: the same bytes every time"
    no "8-bit .$end: dithered without a word" cmp -s d.$end nod.$end
done
run --raw rgb24 -o - in.exr
cp out d.raw
run --raw rgb24 --no-dither -o - in.exr
no 'raw rgb24: dithered without a word' cmp -s out d.raw
run -o d16.png --depth-bits 16 --dither rich.exr
no '--dither: of 16 bits too' cmp -s d16.png p16.png
run -o nod16.png --depth-bits 16 --no-dither rich.exr
same nod16.png p16.png '16 bits: rounded without a word'

# -- pipes ---------------------------------------------------------------------

run --hdr file.exr rich.exr
cat rich.exr | "$glarepp" - --hdr - >pipe.exr
same pipe.exr file.exr 'stdin to stdout: the bytes of the file'
"$glarepp" --hdr - - <rich.exr >pipe.exr
same pipe.exr file.exr 'stdin that is a file'
"$glarepp" --hdr - rich.exr >pipe.exr
same pipe.exr file.exr 'file to stdout'
(read -r _ && "$glarepp" --hdr - -) <<END >out 2>err
skipped
END
[ $? != 0 ] && [ "$(wc -l <err)" = 1 ]
result $? 'nothing on stdin'
run --tonemap none --type float -o file.exr in.exr
cat in.exr | "$glarepp" --tonemap none --type float -o - - | cat >pipe.exr
same pipe.exr file.exr '-o - is EXR'
cat kernel.exr | "$glarepp" -k - --layer pipe.exr in.exr
"$glarepp" -k kernel.exr --layer file.exr in.exr
same pipe.exr file.exr 'the kernel from stdin'
"$glarepp" --hdr once.exr in.exr && "$glarepp" --hdr again.exr once.exr
cat in.exr | "$glarepp" --hdr - - | "$glarepp" --hdr twice.exr -
same twice.exr again.exr 'two runs in a pipe'
run --report - in.exr
ok 'a report on stdout' "$python" -c 'import json; json.load(open("out"))'
mkfifo fifo
cat in.exr >fifo &
run --hdr fifo.exr fifo
wait
"$glarepp" --hdr once.exr in.exr
same fifo.exr once.exr 'a named pipe'
cat f.1.hdr | "$glarepp" --layer pipe.exr - 2>err
status=$?
if [ $status = 0 ]; then
    "$glarepp" --layer file.exr f.1.hdr
    same pipe.exr file.exr 'other formats by stdin'
else
    one_line_error - 'other formats by stdin are refused'
fi

# a DPX whose header names more of the user's data than the file has: for that
# file only, whatever ulimit says
run -o user.dpx in.exr
n=0
for claim in '\360\0\0\360' '\1\0\0\1'; do
    n=$((n + 1))
    cp user.dpx claims.$n.dpx
    # shellcheck disable=SC2059
    printf "$claim" | dd of=claims.$n.dpx bs=1 seek=32 conv=notrunc 2>ok.log
done
for limit in unlimited 6000000; do
    (ulimit -v $limit && batch -o none.#.png claims.?.dpx; exit "$status")
    status=$?
    each_refused claims.1.dpx claims.2.dpx
done

# every packing of DPX, cut off by a byte and by a third
n=0
for bits in 8 10 12 16; do
    size=$(wc -c <cut.$bits.dpx)
    for part in $((size - 1)) $((size * 2 / 3)); do
        n=$((n + 1))
        head -c $part cut.$bits.dpx >cut.$bits.$n.dpx
    done
done
batch --layer refused.#.exr cut.*.?.dpx
each_refused cut.*.?.dpx

# texts that nest deeply, or are long lists, cost a PNG neither time nor memory
"$python" - <<'PY'
import struct, zlib
def chunk(kind, data):
    return (struct.pack(">I", len(data)) + kind + data +
            struct.pack(">I", zlib.crc32(kind + data)))
def png(name, xmp):
    rows = (b"\0" + b"\xff\x80\x20" * 8) * 8
    text = chunk(b"iTXt", b"XML:com.adobe.xmp\0\1\0\0\0" +
                 zlib.compress(xmp, 9))
    with open(name, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" +
                chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 8, 8, 2, 0, 0, 0)) +
                (text if xmp else b"") + chunk(b"IDAT", zlib.compress(rows)) +
                chunk(b"IEND", b""))
start, end = b"<rdf:Description>", b"</rdf:Description>"
png("none.png", b"")
png("nested.png", start + b"<x>" * 200000 + end)
png("closed.png", start + b"<x>" * 200000 + b"</x>" * 200000 + end)
png("open.png", start + b"<x>" * 200000)
png("values.png", start + b"<a:b>1</a:b>" * 600000 + end)
png("lists.png", b"".join(b'<rdf:Description a:b%d="1">' % i + end
                          for i in range(60000)))
PY
"$glarepp" -q --type float --hdr wanted.exr none.png
for text in nested closed open values lists; do
    timeout 10 "$glarepp" -q --type float --hdr text.exr --report text.json \
        $text.png >out 2>err
    status=$?
    quiet_success "a PNG of $(wc -c <$text.png) bytes, $text"
    ok "a PNG with a text, $text: its pixels" \
        "$glarepp" compare --fail 0 text.exr wanted.exr
    is "$(sed 's/.*"peak_rss_mib":\([0-9]*\).*/\1/' text.json |
        awk '{ print $1 < 100 }')" 1 "a PNG with a text, $text: its memory"
done

# a name that addresses and patterns of the shell could have
named='bmp dpx hdr jpg pfm png ppm sgi tga tif webp'
set -f
n=10
# shellcheck disable=SC2046
run -q $(for ending in $named; do
    echo "-o b?.$((n += 1)).$ending -o a?[b]=1.$((n += 1)).$ending"
done) in.exr
set +f
quiet_success 'writes names of patterns'
set --
for ending in $named; do
    for name in 'b?' 'a?[b]=1'; do
        n=$((n + 1))
        ok "writes $name.$n.$ending" [ -s "$name.$n.$ending" ]
        set -- "$@" "$name.$n.$ending"
    done
done
batch --layer 'a?.#.exr' "$@"
quiet_success 'reads names of patterns'
is "$(ls 'a?'.*.exr | wc -l)" $# 'a layer of each'
run -q --layer 'a?.exr' 'b?.11.bmp'
quiet_success 'reads a plain b?.11.bmp'

# all that a stream is taken for by its first bytes; Targa has no word there
# (WebP, which not every oiiotool writes, comes last)
streams='bmp dpx hdr jpg ppm sgi tga tif webp'
n=0
# shellcheck disable=SC2046
oiiotool in.exr --resize 64x40 -d uint8 -o r.gif -o r.iff -o r.rla \
    $(for ending in $streams; do
        echo "-o s.$((n += 1)).$ending"
    done) >ok.log 2>&1
batch -e direct --layer file.#.exr s.?.*
quiet_success 'files of the formats that streams have'
for ending in $streams; do
    n=$((n + 1))
    [ -s s.$n.$ending ] || {
        skip 1 "oiiotool writes no $ending"
        continue
    }
    cat s.$n.$ending | "$glarepp" -e direct --layer pipe.exr - 2>err
    same pipe.exr file.$n.exr "$ending by stdin"
done

# formats that OpenImageIO writes wrong, or to no file of ours, or reads wrong
for ending in avif fits gif heic ico iff jp2 j2k mxr nul null rla sxr term zfile; do
    run -o refused.$ending in.exr
    fails_with 2 refused.$ending "writes no .$ending"
done
# by its first bytes: no name leads to a reader
for ending in gif iff rla; do
    cp r.$ending renamed.tif
    for name in r.$ending renamed.tif; do
        run --layer refused.exr $name
        fails_with 4 $name "reads no $ending"
    done
done
printf '\0\0\1\0\1\0\1\1\0\0\1\0\40\0\60\0\0\0\26\0\0\0' >small.ico
echo hi >made.null
echo hi >http:127.0.0.1:9989.mp4
for name in small.ico made.null http:127.0.0.1:9989.mp4; do
    run -o refused.png $name
    fails_with 4 $name "reads no $name"
done

# with a limit on file sizes none is cut off, in this process or the helper
for ending in tif sgi dpx bmp hdr tga ppm jpg webp; do
    mkdir grown
    (ulimit -f 8; exec "$glarepp" -e direct -o grown/a.$ending in.exr) >out 2>err
    status=$?
    fails_with 3 a.$ending "$ending where files may not grow"
    empty_folder grown "$ending where files may not grow: nothing is left"
    rmdir grown
done

# files that end their reader (this BMP does): one line, and the next is read
echo Qk0cBwAAAAAAADYEAAAoAAAAfwAAAEAAAAABACAAAQAAAOYCAQAADwAAAAAAZwEAAAAAAADW1gAAAQACAP8AAAa5/w== | base64 -d >q.0002.tif
for jobs in 1 3; do
    mkdir made
    run --skip-bad-frames --frame-jobs $jobs -e direct --layer made/####.exr \
        q.####.tif
    is "$status" 6 "a file that ends its reader, $jobs at once: the status"
    is "$(ls made | tr '\n' ' ')" '0001.exr 0003.exr 0004.exr ' \
        "a file that ends its reader, $jobs at once: the others are written"
    rm -r made
done
[ -z "$data" ] || for f in "$data"/damaged_other/*; do
    run --layer refused.exr "$f"
    fails_with 4 "$(basename "$f")" "$(basename "$f"): one line"
done

# zeros FILE TO: over a quarter of its bytes, from the middle on
zeros()
{
    size=$(wc -c <"$1")
    cp "$1" "$2"
    head -c $((size / 4)) /dev/zero |
        dd of="$2" bs=1 seek=$((size / 2)) conv=notrunc 2>dd.log
}

# pixels that cannot be unpacked are an error, never black
kinds='half:zip float:zip uint8:lzw uint8:packbits'
n=0
# shellcheck disable=SC2046
oiiotool --pattern noise:type=uniform:min=0:max=1:seed=3 256x256 3 \
    $(for kind in $kinds; do
        echo "-d ${kind%:*} --compression ${kind#*:} -o sound.$((n += 1)).tif"
    done)
for kind in $kinds; do
    n=$((n + 1))
    zeros sound.$n.tif broken.$n.tif
done
batch -t 1e9 -g 0 --hdr sound.#.exr sound.?.tif
quiet_success "TIFFs of $kinds are read"
batch -t 1e9 -g 0 --hdr broken.#.exr broken.?.tif
each_refused broken.?.tif
is "$(ls | grep '^broken.*exr')" '' 'TIFFs with zeros in them: nothing is written'

# -- DWA and luminance-chroma in -----------------------------------------------

packings='dwaa dwab b44 b44a pxr24 piz rle zips zip'
n=0
# shellcheck disable=SC2046
oiiotool in.exr -o:tile=16x16 tiled.exr $(for compression in $packings; do
    echo "--compression $compression -o c.$((n += 1)).exr"
done)
run -t 1e9 -g 0 --type float --hdr d.#.exr c.?.exr
quiet_success "reads EXR of $packings"
for compression in $packings; do
    n=$((n + 1))
    echo "d.$n.exr c.$n.exr equal $compression in: the library's values" >>list
done
run -t 1e9 -g 0 --hdr d.exr tiled.exr
echo "d.exr in.exr equal tiles in" >>list
if [ -n "$data" ]; then
    for name in CrissyField Garden StarField Rec709_YC; do
        f=$data/luminance_chroma/$name.exr
        run --hdr h.exr --layer l.$name.exr -o l.png "$f"
        quiet_success "luminance-chroma $name"
        echo "l.$name.exr:R,G,B l.$name.exr:R,G,B equal luminance-chroma $name becomes R,G,B" >>list
        is "$(png_size l.png | cut -d' ' -f1)" \
            "$(exrinfo "$f" | sed -n '/displayWindow/s/.*\] \([0-9]*\) x \([0-9]*\)/\1x\2/p' | head -1)" \
            "luminance-chroma $name: the size"
    done
else
    skip 12 "$no_data"
fi

"$python" "$cli/compare.py" <list >verdicts
verdicts verdicts
# -- headers that lie ------------------------------------------------------------

# A stray "type" of another file, which OpenEXR's own readers pass over
for kind in deepscanline tiledimage nonsense; do
    frame typed.exr size=8x6 attr=type:string:$kind
    frame plain.exr size=8x6
    run --hdr typed.h.exr typed.exr
    quiet_success "a stray type $kind is read"
    run --hdr plain.h.exr plain.exr
    same typed.h.exr plain.h.exr "a stray type $kind changes nothing"
done

# 1672 bytes that claim a thousand million chunks in their third part
found=$root/tests/fuzz/corpus/frame/found-chunks-of-another-part
rm -f h.exr
run --hdr h.exr "$found"
fails_with 4 found-chunks 'chunks that the file has no room for'
ok 'and nothing is written' [ ! -e h.exr ]

done_testing
