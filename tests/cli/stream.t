#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Frames in pipes: formats of stdout, several frames in one stream, ffmpeg and
# GNU parallel at the other end.
. "$(dirname "$0")/lib.sh"
need_python
no_provenance
examples=$root/examples

for n in 1 2 3; do
    frame s.000$n.exr size=64x48 seed=$n display=-4,0,59,49 channels=R,G,B,A,Z:float
done
frame odd.0004.exr size=40x30 seed=4
"$glarepp" -e fft -o o.#.png --layer l.#.exr --hdr h.#.exr s.####.exr || exit 1
"$glarepp" -e fft -o o.#.pfm s.####.exr || exit 1
"$glarepp" -e fft --depth-bits 16 -o w.#.png s.####.exr || exit 1

# -- one stream out ------------------------------------------------------------

# streams WANTED DESCRIPTION ARGUMENT...: the sequence to stdout
streams()
{
    wanted=$1 about=$2
    shift 2
    run -e fft "$@" s.####.exr
    quiet_success "$about"
    same out "$wanted" "$about: the files' bytes"
}

cat o.1.png o.2.png o.3.png >pngs
cat o.1.pfm o.2.pfm o.3.pfm >pfms
cat l.1.exr l.2.exr l.3.exr >layers
cat h.1.exr h.2.exr h.3.exr >hdrs
streams pngs 'PNG frames' --stdout-format png -o -
streams pfms 'PFM frames' --stdout-format pfm -o -
streams layers 'EXR layers' --layer -
streams hdrs 'EXR frames' --hdr - --stdout-format exr
streams pngs 'beside files' --stdout-format png -o - --layer again.#.exr
same again.3.exr l.3.exr 'beside files: the file'
run -e fft -o - --stdout-format png s.0002.exr odd.0004.exr
quiet_success 'plain files without numbers, of two sizes'

if [ -n "$oiio" ]; then
    "$python" - >raw.log 2>&1 <<'PY'
import numpy as np, OpenImageIO as oiio
def read(name, kind):
    return oiio.ImageBuf(name).get_pixels(kind)[..., :3]
for n, kind, sort in (("o", oiio.UINT8, "u1"), ("w", oiio.UINT16, "<u2")):
    all = b"".join(read(f"{n}.{i}.png", kind).astype(sort).tobytes()
                   for i in (1, 2, 3))
    open(n + ".raw", "wb").write(all)
np.fromfile("w.raw", "<u2").astype(">u2").tofile("wbe.raw")
open("f.raw", "wb").write(b"".join(
    read(f"o.{i}.pfm", oiio.FLOAT).astype("<f4").tobytes() for i in (1, 2, 3)))
PY
    note "$(cat raw.log)"
    streams o.raw 'raw rgb24: the codes of PNG' --raw rgb24 -o -
    streams w.raw 'raw rgb48le: the codes of 16-bit PNG' --raw rgb48le -o -
    streams wbe.raw 'raw rgb48be' --stdout-format raw --raw rgb48be -o -
    streams f.raw 'raw rgbf32le: the floats of PFM' --raw rgbf32le -o -
    streams o.raw 'raw without a word is rgb24' --stdout-format raw -o -
else
    skip 10 'no OpenImageIO for Python'
fi
"$glarepp" -e fft --threads 3 --raw rgb24 -o - s.####.exr >three
"$glarepp" -e fft --threads 1 --raw rgb24 -o - s.####.exr >one
same one three 'the same bytes from three threads'

run --raw rgb24 -o - s.0001.exr s.0002.exr odd.0004.exr
fails_with 4 'odd.0004.exr: size differs' 'a raw frame of another size'
is "$(wc -c <out)" $((2 * 64 * 50 * 3)) 'a raw frame of another size: none of it'
run --raw rgb24 --hdr - s.0001.exr
fails_with 2 '--hdr keeps all channels' '--hdr is EXR alone'
run --raw rgb24 --stdout-format png -o - s.0001.exr
fails_with 2 --raw 'two formats for stdout'
run -q --raw rgb24 -o x.raw s.0001.exr
fails_with 2 x.raw 'no files of raw frames'
run --raw yuv420p -o - s.0001.exr
fails_with 2 yuv420p 'no such raw format'
run --raw rgb24 -o x.png s.0001.exr
status_is 0 'a format of stdout that nobody asks for'
like "$(cat err)" '*warning: --raw: does nothing*' 'a format of stdout that nobody asks for: says so'

# -- several frames in ----------------------------------------------------------

# splits WANTED DESCRIPTION INPUT ARGUMENT...: frames made from a stream
splits()
{
    wanted=$1 about=$2 input=$3
    shift 3
    rm -rf made && mkdir made
    "$glarepp" -e fft "$@" - <"$input" >out 2>err
    status=$?
    quiet_success "$about"
    is "$(ls made | xargs)" "$wanted" "$about: the frames"
}

cat s.0001.exr s.0002.exr s.0003.exr >exrs
splits '1.exr 2.exr 3.exr' 'EXR frames in' exrs --hdr made/#.exr
for n in 1 2 3; do
    same made/$n.exr h.$n.exr "EXR frames in: $n as from its file"
done
splits '0007.exr 0008.exr 0009.exr' 'numbered by --frames' exrs -f 7-9 \
    --hdr made/####.exr
same made/0009.exr h.3.exr 'numbered by --frames: the last'
splits 1.exr 'one frame has a number too' s.0002.exr --hdr made/#.exr
same made/1.exr h.2.exr 'one frame has a number too: as from its file'
splits '' 'in and out' exrs --hdr -
same out hdrs 'in and out: the bytes'
splits '1.pfm 2.pfm 3.pfm' 'PNG frames in' pngs --tonemap none -t 0.5 -o made/#.pfm
splits '1.pfm 2.pfm 3.pfm' 'PFM frames in' pfms --tonemap none -t 0.5 -o made/#.pfm
"$glarepp" -e fft -t 0.5 --tonemap none -o p.pfm o.3.pfm
same made/3.pfm p.pfm 'PFM frames in: as from its file'
cat s.0001.exr o.2.png o.3.pfm odd.0004.exr >mixed
splits '1.png 2.png 3.png 4.png' 'formats mixed' mixed -o made/#.png
frame tiny.exr size=5x3
cat tiny.exr tiny.exr >tinies
rm -rf made && mkdir made
"$python" -c 'import os
for byte in open("tinies", "rb").read():
    os.write(1, bytes([byte]))' | "$glarepp" -e fft --hdr made/#.exr - >out 2>err
status=$?
is "$status" 0 'one byte at a time'
"$glarepp" -e fft --hdr p.exr tiny.exr
same made/2.exr p.exr 'one byte at a time: the second frame'
frame parts.exr size=20x70 part=depth:Z:float part=more:Y:half
frame deep.exr size=20x20 deep=1
cat parts.exr s.0001.exr parts.exr >multi
splits '1.exr 2.exr 3.exr' 'files of several parts' multi --hdr made/#.exr
"$glarepp" -e fft --hdr p.exr parts.exr
same made/3.exr p.exr 'files of several parts: as from its file'
"$glarepp" -e fft --report report.json - <exrs
is "$(sed 's/.*"frame": *\([0-9]*\).*/\1/' report.json | xargs)" '1 2 3' \
    'the report has their numbers'
if command -v exrmaketiled >tools; then
    exrmaketiled -r -t 16 16 s.0001.exr rip.exr
    exrmaketiled -m -t 16 16 s.0002.exr mip.exr
    cat rip.exr mip.exr rip.exr >tiled
    splits '1.exr 2.exr 3.exr' 'tiles of several levels' tiled --layer made/#.exr
    "$glarepp" -e fft --layer p.exr rip.exr
    same made/3.exr p.exr 'tiles of several levels: as from its file'
else
    skip 3 'no exrmaketiled'
fi
if [ -n "$data" ]; then
    find "$data" -name '*.exr' -size -600k | sort | while read -r f; do
        "$glarepp" -q -t 1e30 --report one.json "$f" 2>/dev/null || continue
        cat "$f" s.0001.exr | "$glarepp" -q -t 1e30 --report two.json - 2>err
        [ "$(wc -l <two.json)" = 2 ] || echo "$f: $(cat err)"
        rm -f one.json two.json
    done >unlike
    is "$(cat unlike)" '' 'files of the data end where they say'
fi

run -f 1-2 --hdr made/#.exr - <exrs
fails_with 2 'stdin has 3 frames' 'too few numbers'
run -o made/x.png - <exrs
fails_with 2 made/x.png 'frames into one name'
run -o made/#.png - s.0001.exr <exrs
fails_with 2 - 'stdin beside a file'
(cat s.0001.exr && echo more) >more
run -o made/#.png - <more
fails_with 4 'follows frame 1' 'what is no image'
(cat s.0001.exr && head -c 20000 s.0002.exr) >cut
rm -rf made && mkdir made
run -o made/#.png - <cut
fails_with 4 '- (frame 2)' 'a stream cut off'
is "$(find made -name '.*' -type f)" '' 'a stream cut off: no temporary file'
(cat s.0001.exr deep.exr s.0002.exr) >deeps
rm -rf made && mkdir made
run --skip-bad-frames -o made/#.png - <deeps
status_is 6 'a bad frame among others'
is "$(ls made | xargs)" '1.png 3.png' 'a bad frame among others: the others'

# -- readers that leave ---------------------------------------------------------

i=10
frame big.0010.exr size=300x200 seed=5
while [ $i -lt 30 ]; do
    i=$((i + 1))
    ln big.0010.exr big.00$i.exr
done
for format in '--raw rgb48le' '--stdout-format png' '--stdout-format pfm' \
    '--stdout-format exr --compression none --type float'; do
    rm -rf made && mkdir made
    {
        "$glarepp" $format -o - --layer made/l.####.exr big.####.exr 2>err
        echo $? >code
    } | head -c 1000 >head.out
    status=$(cat code)
    fails_with 3 stdout "a reader that leaves, $format"
    is "$(find made -name '.*' -type f)" '' "a reader that leaves, $format: no temporary file"
done

# -- ffmpeg ----------------------------------------------------------------------

mkdir bin
cat >bin/ffmpeg <<'SH'
#!/bin/sh
# stands in where there is none: keeps the pixels and the words
for movie; do :; done
printf '%s\n' "$@" >"$movie.words"
cat >"$movie"
SH
chmod +x bin/ffmpeg
"$glarepp" -t 4 --tonemap agx --raw rgb48le -o - \
    "$examples/leaves.####.exr" >want.raw
is "$(wc -c <want.raw)" $((4 * 640 * 360 * 6)) 'four example frames as pixels'
(PATH=$tmp/bin:$PATH && export PATH && sh "$examples/movie.sh" "$glarepp" movie.raw)
same movie.raw want.raw 'examples/movie.sh gives every byte'

# played FILE: H.264 in 4:2:0 with an index first, BT.709 in all tags
played()
{
    is "$(ffprobe -v error -of csv=p=0 -show_entries \
        stream=codec_name,pix_fmt,color_range,color_space,color_transfer,color_primaries \
        "$1")" h264,yuv420p,tv,bt709,bt709,bt709 "$1: as players want it"
    is "$(ffprobe -v trace "$1" 2>&1 | sed -n "s/.*type:'\(moov\|mdat\)'.*/\1/p" |
        head -n 1)" moov "$1: the index comes first"
}
wanted='bt709 -color_trc bt709 -colorspace bt709 -color_range tv -movflags +faststart'
rm -f shot.mp4*
(PATH=$tmp/bin:$PATH && export PATH && \
    sh "$examples/movie.sh" "$glarepp" shot.mp4 big.####.exr 300x200)
like "$(cat shot.mp4.words | xargs)" \
    "*scale=out_color_matrix=bt709:out_range=tv -pix_fmt yuv420p*-color_primaries $wanted shot.mp4" \
    'examples/movie.sh: the words that make it play'
is "$(($(wc -c <shot.mp4) % (300 * 200 * 6)))" 0 'examples/movie.sh: whole frames'
if command -v ffmpeg >ffmpeg.path; then
    ok 'examples/movie.sh with ffmpeg' sh "$examples/movie.sh" "$glarepp" movie.mkv
    ffmpeg -v error -i movie.mkv -f rawvideo -pix_fmt rgb48le movie.back </dev/null
    same movie.back want.raw 'examples/movie.sh with ffmpeg: every code is back'
    rm -f shot.mp4*
    sh "$examples/movie.sh" "$glarepp" shot.mp4 big.####.exr 300x200 2>ffmpeg.log
    played shot.mp4
    # BT.709's luma of red, and not BT.601's: 63, not 81
    "$python" -c 'import sys
for _ in range(3): sys.stdout.buffer.write(b"\xff\xff\0\0\0\0" * 41 * 25)' >red.raw
    printf '#!/bin/sh\ncat red.raw\n' >red && chmod +x red
    sh "$examples/movie.sh" ./red odd.mp4 none 41x25
    played odd.mp4
    is "$(ffmpeg -v error -i odd.mp4 -f rawvideo -pix_fmt yuv420p - </dev/null |
        od -An -tu1 -N1 -j100 | tr -d ' ')" 63 "odd.mp4: red by BT.709's matrix"
    {
        "$glarepp" --raw rgb48le -o - big.####.exr 2>err
        echo $? >code
    } | ffmpeg -v quiet -f rawvideo -pixel_format rgb48le -video_size 300x200 \
        -i - -frames:v 1 -f null - >ffmpeg.log 2>&1
    status=$(cat code)
    fails_with 3 stdout 'ffmpeg that ends early'
else
    skip 9 'no ffmpeg'
fi

# -- GNU parallel ------------------------------------------------------------------

if command -v parallel >parallel.path; then
    ok 'examples/parallel.sh' sh "$examples/parallel.sh" "$glarepp" lit
    "$glarepp" -e fft -t 4 --hdr whole.####.exr -o whole.####.png \
        "$examples/leaves.####.exr"
    same lit/lit.1003.exr whole.1003.exr 'examples/parallel.sh: the bytes of one run'
    same lit/lit.1004.png whole.1004.png 'examples/parallel.sh: its picture'
    mkdir 'two words'
    cp s.*.exr 'two words'
    ok 'ranges of frames' sh "$examples/parallel.sh" "$glarepp" ranges \
        'two words/s.####.exr' 1-2 3
    is "$(ls ranges | xargs)" 'lit.0001.exr lit.0001.png lit.0002.exr lit.0002.png lit.0003.exr lit.0003.png' \
        'ranges of frames: all are there'
    no 'a range that fails' sh "$examples/parallel.sh" "$glarepp" ranges \
        's.####.exr' 1-2 3-9
else
    skip 6 'no GNU parallel'
fi

done_testing
