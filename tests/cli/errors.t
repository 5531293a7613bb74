#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Bad input and bad places: one line, the documented status, no file left, and
# earlier files stay whole.
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr channels=R,G,B,A,Z:float type=half
frame wide.exr size=320x200 channels=R,G,B,A,Z:float lights=2000
"$glarepp" -o good.png in.exr || exit 1
mkdir there
outputs='-o there/o.png --hdr there/h.exr --layer there/l.exr'

# refuses STATUS NAME DESCRIPTION ARGUMENT...: with three outputs, none of
# which is made
refuses()
{
    wanted=$1 name=$2 about=$3
    shift 3
    run $outputs "$@"
    fails_with "$wanted" "$name" "$about"
    empty_folder there "$about: nothing written"
    is "$(wc -c <out)" 0 "$about: nothing on stdout"
}

# -- frames that cannot be read ------------------------------------------------

refuses 3 nowhere.exr 'no such file' nowhere.exr
refuses 3 no/where.exr 'no such folder' no/where.exr
mkdir folder.exr
refuses 3 folder.exr 'a folder' folder.exr
: >empty.exr
refuses 4 empty.exr 'an empty file' empty.exr
: >empty.png
refuses 4 empty.png 'an empty PNG' empty.png
size=$(wc -c <in.exr)
for part in 3 8 40 200 $((size / 2)) $((size - 1)); do
    head -c $part in.exr >cut.exr
    refuses 4 cut.exr "an EXR cut after $part bytes" cut.exr
done
cp good.png named.exr
refuses 4 named.exr 'a PNG named .exr' named.exr
like "$(cat err)" '*PNG*' 'a PNG named .exr: says that it is a PNG'
cp in.exr named.png
"$glarepp" --no-provenance --layer a.exr in.exr &&
    "$glarepp" --no-provenance --layer b.exr named.png
same a.exr b.exr 'an EXR named .png is read as what it is'
echo 'this is no picture' >text.tif
refuses 4 text.tif 'a text named .tif' text.tif
printf 'S\200\366\064 a scene' >scene.pic
refuses 4 scene.pic 'a Softimage PIC' scene.pic
is "$(cat err)" 'glarepp: scene.pic: not a format that glarepp reads (Softimage PIC); convert it, e.g. with oiiotool' \
    'a Softimage PIC: says what it is'
refuses 4 scene.pic 'a Softimage PIC as kernel' -k scene.pic in.exr
frame deep.exr deep=1
refuses 4 deep.exr 'deep data' deep.exr
like "$(cat err)" '*deep*; *' 'deep data: says so and what to do'
if [ "$(id -u)" = 0 ]; then
    skip 4 'root may read everything'
else
    cp in.exr locked.exr && chmod 0 locked.exr
    refuses 3 locked.exr 'no permission' locked.exr
fi

# a header that claims what the file cannot hold: refused before memory is
# taken, so also where there is little of it
"$python" - <<'PY'
import struct
whole = open("in.exr", "rb").read()
at = whole.index(b"dataWindow\0box2i\0") + 21
window = struct.pack("<4i", 0, 0, 65534, 65534)
open("huge.exr", "wb").write(whole[:at] + window + whole[at + 16:][:600])
PY
refuses 4 huge.exr 'a small file of 65535 x 65535 pixels' huge.exr
refuses 4 in.exr 'more pixels than --max-pixels' --max-pixels 100 in.exr
frame far.exr size=8x8 display=0,0,20000,10000
refuses 4 far.exr 'a far display window' --max-pixels 1000 far.exr
like "$(cat err)" '*: the display window is too large (20001 x 10001 pixels, *' \
    'a far display window: says which'
frame apart.exr size=8x8 origin=99,99 display=0,0,9,9
refuses 4 apart.exr 'windows far apart' --max-pixels 1000 apart.exr
like "$(cat err)" '*too large together (107 x 107 pixels, at most 1000); give --grow none *' \
    'windows far apart: says what to do'
run -q --max-pixels 1000 --grow none --layer there/l.exr apart.exr
status_is 0 'windows far apart: --grow none'
rm there/l.exr
frame vast.exr size=8x8 display=0,0,4199,4199
run --layer there/l.exr --threads 1 vast.exr
is "$(cat err)" 'glarepp: warning: vast.exr: its data window (8 x 8 pixels) grows to 4200 x 4200; give --grow none to keep it, which takes less memory' \
    'a small window in a vast display: says that memory grows'
rm there/l.exr
frame bomb.exr size=4x4 channels=R,G,B display=0,0,15999,15999
refuses 4 bomb.exr 'a display window out of proportion' bomb.exr
run --grow none --layer there/l.exr bomb.exr
status_is 0 'a display window out of proportion: --grow none'
rm there/l.exr
for by in -1 7.5 65537 all; do
    refuses 2 --grow "--grow $by" --grow $by in.exr
done
run -k far.exr --max-pixels 20000 --layer there/l.exr in.exr
fails_with 4 far.exr 'a kernel with a far display window'
run compare --max-pixels 1000 far.exr far.exr
is $status 0 'a far display window is compared: it makes no picture'

# values that are none of their type: OpenEXR would refuse what they go to
for attr in preview:1,1 deepImageState:1 chlist:1,1 keycode:1,1,1,1,1,1,1; do
    frame value.exr "attr=shot:$attr"
    refuses 4 value.exr "a bad ${attr%%:*}" value.exr
    like "$(cat err)" "*shot*${attr%%:*}*; *" \
        "a bad ${attr%%:*}: says which"
done

# -- inputs without an end and lists without measure ---------------------------

# In 160 MB of address space and 2 s of CPU; ten times as long in the builds of
# the quick form, which are slow. Sanitizers and valgrind take more for
# themselves; then without.
seconds=2
[ -z "$quick" ] || seconds=20
if [ -z "$GLAREPP_RUN" ] && (ulimit -v 160000 && "$glarepp" --version) >ok.log 2>&1; then
    small_limits="ulimit -t $seconds; ulimit -v 160000"
else
    small_limits=:
fi

# bounded ARGUMENT...: as run, within these limits
bounded()
{
    (eval "$small_limits"; exec "$glarepp" "$@") >out 2>err
    status=$?
}

# endless NAME PATTERN DESCRIPTION ARGUMENT...: refused with that line
endless()
{
    name=$1 pattern=$2 about=$3
    shift 3
    bounded --hdr there/h.exr "$@"
    fails_with 4 "$name" "$about"
    like "$(cat err)" "$pattern" "$about: says why"
    empty_folder there "$about: nothing written"
}

for device in /dev/zero /dev/urandom; do
    none='*: not a format that glarepp reads (unknown data, *); convert it, *'
    endless $device "$none" "$device as input" $device
    endless - "$none" "$device as stdin" - <$device
    endless $device "$none" "$device as kernel" -k $device in.exr
    endless $device "$none" "$device as depth" --sun 9,9 --depth-file $device \
        in.exr
    bounded compare $device in.exr
    fails_with 4 $device "$device to compare"
    ln -s $device "${device#/dev/}.exr"
    endless "${device#/dev/}.exr" '*: is not an EXR (found *' \
        "$device named .exr" "${device#/dev/}.exr"
done
for start in 'head -c 300 in.exr' 'head -c 200 good.png' "printf 'P6 9 9 255 '"; do
    (eval "$start" && cat /dev/zero) 2>tail.log | {
        bounded --max-pixels 1000 --hdr there/h.exr -
        echo $status >code
    }
    status=$(cat code)
    fails_with 4 - "no end behind $start"
    like "$(cat err)" '*: more than --max-pixels allows (over 67124864 bytes)*' \
        "no end behind $start: the limit"
done

# files of one pixel whose headers list much
"$python" - <<'PY'
import struct
def attribute(name, kind, data):
    return (name.encode() + b"\0" + kind.encode() + b"\0" +
            struct.pack("<i", len(data)) + data)
def header(name, channels, attributes, parts=1):
    channels = sorted(channels)
    h = attribute("channels", "chlist", b"".join(
        c.encode() + b"\0" + struct.pack("<4i", 1, 0, 1, 1)
        for c in channels) + b"\0")
    h += attribute("compression", "compression", b"\0")
    for window in ("dataWindow", "displayWindow"):
        h += attribute(window, "box2i", struct.pack("<4i", 0, 0, 0, 0))
    h += attribute("lineOrder", "lineOrder", b"\0")
    h += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    h += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    h += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    h += b"".join(attribute("a%07d" % i, "int", b"\0\0\0\0")
                  for i in range(attributes, 0, -1))
    if parts == 1:
        whole = struct.pack("<ii", 20000630, 2) + h + b"\0"
        whole += struct.pack("<Q", len(whole) + 8)
        row = struct.pack("<e", 0.5) * len(channels)
        whole += struct.pack("<ii", 0, len(row)) + row
    else:
        h += attribute("type", "string", b"scanlineimage")
        h += attribute("chunkCount", "int", struct.pack("<i", 1))
        whole = struct.pack("<ii", 20000630, 2 | 0x1000) + b"".join(
            h + attribute("name", "string", b"p%07d" % i) + b"\0"
            for i in range(parts)) + b"\0"
    open(name, "wb").write(whole)
rgb = ["R", "G", "B"]
n = 8192
header("plain.exr", rgb + ["c%05d" % i for i in range(n - 3)], 0)
header("layers.exr", rgb + ["c%05d.N.Z" % i for i in range(n - 3)], 0)
header("half.exr", ["c%05d.%s" % (i, c) for i in range(n // 2) for c in "RG"], 0)
header("nested.exr", [c for i in range(n // 2)
                      for c in ("a.b%05d" % i, "a.b%05d.R" % i)], 0)
header("attributes.exr", rgb, n - 8)
header("channels.exr", rgb + ["c%05d" % i for i in range(60000)], 0)
header("more.exr", rgb, 60000)
header("parts.exr", rgb, 0, 8193)
header("both.exr", rgb + ["c%05d" % i for i in range(3000)], 0, 9)
PY
for many in plain layers attributes; do
    bounded -g 0 --hdr many.exr $many.exr
    quiet_success "8192 in a list, $many: read"
done
run --hdr many.exr plain.exr
is "$(strings -n 6 many.exr | grep -c '^c0[0-9]*$')" 8189 \
    '8192 channels: all are written'
for many in half nested; do
    endless $many.exr '*: no colour channels*' "8192 channels, $many" $many.exr
done
for many in channels=channels more=attributes parts=parts both=channels; do
    endless ${many%=*}.exr "*: the EXR header lists too many ${many#*=} (*" \
        "too many ${many#*=} in ${many%=*}.exr" ${many%=*}.exr
    endless - "*: the EXR header lists too many ${many#*=} (*" \
        "too many ${many#*=} in ${many%=*}.exr, by stdin" - <${many%=*}.exr
done

# -- the command line ----------------------------------------------------------

refuses 2 nope 'an unknown channel' --depth nope in.exr
like "$(cat err)" '*A*B*G*R*Z*' 'an unknown channel: lists those that are there'
for pair in engine tonemap type compression gl mix alpha progress \
    kernel-normalize depth-bits debug threshold-mode; do
    refuses 2 "--$pair" "an unknown value of --$pair" --$pair nope in.exr
    like "$(cat err)" '*nope*one of*' "--$pair: says what there is"
done
refuses 2 builtin:nope 'an unknown kernel' -k builtin:nope in.exr
for pair in threshold=x threshold=-1 threshold=nan knee=2 gain=inf threads=1.5 \
    threads=-1 exposure=99 kernel-center=3 gain= max-value=-1 group=3 group=0 \
    cluster=12 cluster=4 cluster-fill=0 shrink=1 tolerance=-1 tolerance-pixel=0 rotate=nan; do
    refuses 2 "--${pair%%=*}" "--$pair" "--$pair" in.exr
done
refuses 2 --knee 'a knee of the part over the threshold' --knee 0.5 in.exr
refuses 2 --treshold 'an unknown option' --treshold 2 in.exr
like "$(cat err)" '*--threshold*' 'an unknown option: names the nearest'
refuses 2 -Z 'an unknown letter' -Z in.exr
refuses 2 --quiet 'a value that is not wanted' --quiet=yes in.exr
refuses 2 'no input' 'no input'
run in.exr
fails_with 2 'give -o out.png' 'no output given'
: >old.png
run in.exr old.png
fails_with 2 'give -o out.png' 'no output given, but a picture that exists'
refuses 2 --csv 'an option of glarepp bench' --csv x in.exr
run bench -o there/x.png in.exr
fails_with 2 --output 'glarepp bench with an option of pictures'
run bench
fails_with 2 'no input' 'glarepp bench without input'
run bench --paper in.exr
fails_with 2 --paper 'glarepp bench with two kinds of frames'
run -o
fails_with 2 -o 'an option without its value'
run -o there/x.png --hdr --quiet in.exr
fails_with 2 --hdr 'an option in the place of a value'
run -o - --hdr - in.exr
fails_with 2 - 'two outputs to stdout'
run -o - --report - in.exr
fails_with 2 - 'picture and report to stdout'
run -o there/x.png --hdr there/x.png in.exr
fails_with 2 there/x.png 'one name for two outputs'
run -o there/x.nope in.exr
fails_with 2 there/x.nope 'an unknown ending'
run -o there/ending in.exr
fails_with 2 there/ending 'no ending'
run --hdr there/x.png in.exr
fails_with 2 there/x.png '--hdr with an ending that is not EXR'
run --verify -o there/x.png in.exr
fails_with 2 --verify '--verify that nobody sees'
empty_folder there 'nothing written by any of these'

# -- whole lines ---------------------------------------------------------------

# Messages about the command line, word for word: "ARGUMENTS => LINE", in a folder
# of empty files. Other tests ask for the status and the name only.
mkdir texts
for name in s.0001 s.0002 s.0010 x.0001 x.10000 in v.left.0001 v.right.0001 \
    v.left.0002 v.right.0002 q.left.0001 q.right.0001 q.left.0002 w.l w.r; do
    : >texts/$name.exr
done
while read -r row; do
    # shellcheck disable=SC2086
    (cd texts && exec "$glarepp" ${row%% => *}) </dev/null >out 2>err
    is "$(cat err)" "glarepp: ${row#* => }" "the whole line: ${row%% => *}"
done <<'ROWS'
-q => no input; write glarepp -o out.png frame.exr
f.exr => no output is given (found f.exr); give -o out.png, or --hdr out.exr for linear light
f.exr out.png => no output is given (found f.exr out.png); give -o out.png, or --hdr out.exr for linear light
s.0001.exr s.0002.exr o.#.png => no output is given (found s.0001.exr ... o.#.png); give -o out.png, or --hdr out.exr for linear light
--help xyzzyquux => help: no such topic (found "xyzzyquux"); glarepp help lists them
--gian 2 i => --gian: unknown option; did you mean --gain?
--xyzzyquux i => --xyzzyquux: unknown option; glarepp --help lists them
-o a i --gain => --gain: needs a value; write --gain G
-o --hdr i => -o: needs a value (found the option --hdr); write -o FILE
-o a i --dither=1 => --dither=1: takes no value (found "1"); leave it out
-o a i -g x => --gain: not a number (found "x"); give 0 to 1000000
-o a i -g -0.1 => --gain: out of range (found -0.1); give 0 to 1000000
-o a i --threads 1.5 => --threads: not a whole number (found "1.5"); give 0 to 1024
-o a i --kernel-center 1 => --kernel-center: not 2 numbers (found "1"); write X,Y
-o a i -e gpu => --engine: no such value (found "gpu"); give one of auto, direct, fft, splat
-o a i --debug sensors => --debug: no file (found "sensors"); write sensors=FILE
-o a i --knee 0.5 => --knee: needs --threshold-mode whole (found 0.5 with excess); add it, or leave --knee out
-o a i --verify => --verify: no output shows its result; add --report FILE or -v
-o a i --sun 1 => --sun: not 2 to 3 numbers (found "1"); write X,Y[,R]
-o a i --sun 1,2,-1 => --sun: a negative radius (found -1); give 0 or more
-o a i --sun 1,2 --sun-dir 0,0,1 => --sun-dir: --sun already places the sun; leave one of the two out
-o a i --sun 1,2 --sun-color 1,2 => --sun-color: two numbers; give one or three
-o a i --sun 1,2 --sun-map 5 => --sun-map: odd (found 5); give an even number
-o a i --sun-size 2 => --sun-size: needs a light; give --sun, --sun-dir, --camera, --lights or --scene
-o a i --lights l --sun-color 1 => --sun-color: needs --sun, --sun-dir or --camera; lights of --lights have flux of their own, those of --scene by --light-scale
-o a i --debug sunmap=f => --debug sunmap: needs a light; give --sun, --sun-dir, --camera, --lights or --scene
-o a i --view left => --view: needs --ocio CONFIG; for stereo use --views left
-o a i --display d => --display: needs --ocio; give --ocio CONFIG or --ocio env
-o a i -k builtin:sta => --kernel: no such value (found "builtin:sta"); did you mean builtin:star? Else give one of builtin:eye, builtin:eye-night, builtin:eye-old, builtin:star, builtin:cross, builtin:streak, builtin:ring, builtin:circle, spencer, cie, aperture, temporal, gaussian, moffat, halation, image
-o a i -k stra => --kernel: no such file (found "stra"); did you mean builtin:star?
-o a i --threshold-mode excesss => --threshold-mode: no such value (found "excesss"); did you mean excess? Else give one of excess, whole
--layer diffuse in.exr => diffuse: unknown format (ending is missing); end the name in one of .exr, .png, .pfm, .hdr, .tif, .tx, .dpx, .tga, .webp, .jpg, .bmp, .ppm, .sgi, .rgb
compare -fial 1 a b => -fial: unknown option; did you mean --fail?
compare a => only one input; write glarepp compare a.exr b.exr
--hdr h i --ocio c --view v => --view: needs a picture; give -o FILE
-o a i --ocio c --output-space s => --output-space: converts only --hdr; give --hdr FILE
-o a i --ocio c --tonemap reinhard => --tonemap: --ocio replaces it; leave one of the two out
bench --paper --sun 1,2 => --paper: its frames have no depth to hide a light; leave --paper or the lights out
bench --sun 1,2 --flare f i => --flare: bench measures it for bright pixels, and lights by their visibility (found a light); leave one out
bench --report f i => --report: not for glarepp bench; see glarepp bench --help
-o a i --group 3 => --group: not a power of two (found 3); give 1, 2, 4, 8, 16, 32 or 64
-o a i --cluster 1 => --cluster: must be larger than --group (found 1 and 4); give a larger one, or 0 for none
-o a i --debug polygons= => --debug: no file (found "polygons="); write polygons=FILE
-o a i --csv x => --csv: not for pictures; write glarepp bench --csv, or leave it out
bench => no input; write glarepp bench frame.exr
bench a b => b: too many inputs (found 2, glarepp bench reads 1); leave it out
bench --paper a => --paper: measures frames of its own (found input a); leave one of the two out
bench --outptu a => --outptu: unknown option; glarepp bench --help lists them
-o o.png s.####.exr => o.png: one name for a sequence (found 3 frames); write a pattern such as out.####.png, or -
-o o.#.png in.exr => in.exr: no frame number in this input (o.#.png needs one); add one to its name, or give plain output names
-o o.#.png s.0001.exr x.0001.exr => o.1.png: given for two outputs (--output o.#.png for s.0001.exr and --output o.#.png for x.0001.exr); give each a name of its own
-o o.#.#.png s.####.exr => o.#.#.png: two places for the frame number (# and #); leave one
-f 1-2 -o o.png in.exr => in.exr: --frames needs a pattern (found a plain name); write shot.####.exr, or leave --frames out
-f 1- -o o.#.png s.####.exr => --frames: not a list of frames (found 1- in 1-); write 7, 1-100, 1-100x2 or 3,4,10-20:2
-f 77 -o o.@.png s.####.exr => s.0077.exr: no such frame (first of 1 missing, 1 listed by --frames 77); render it, or give --skip-bad-frames
-f 1-10 -o o.@.png s.####.exr => s.0003.exr: no such frame (first of 7 missing, 10 listed by --frames 1-10); render them, or give --skip-bad-frames
-f 10-8x2 -o m.@.png s.####.exr => s.0008.exr: no such frame (first of 1 missing, 2 listed by --frames 10-8x2); render it, or give --skip-bad-frames
-o o.#.png none.####.exr => none.####.exr: no frame on disk (found no file of that name); check the folder and the number of digits
-o o.png - in.exr => -: stdin must be the only input (found 2); give only -
-o o.png -o o.png in.exr => o.png: given for two outputs (--output o.png and --output o.png); give each a name of its own
-o no/o.png - => no/o.png: cannot be written (folder no: No such file or directory); make the folder or give --create-dir
-o - --raw rgb24 --stdout-format exr in.exr => --raw: contradicts --stdout-format; leave one of the two out
-o - --hdr - in.exr => -: given for two outputs (--hdr - and --output -); only one can go to stdout
--hdr x.%d.exr -f 1,10000 --skip-bad-frames ./x.####.exr => x.10000.exr: --hdr would replace a file that is read (input ./x.10000.exr); write to another name
--hdr t.%04d.exr --layer t.%d.exr -f 1,1000 --skip-bad-frames s.#.exr => t.1000.exr: given for two outputs (--hdr t.%04d.exr for s.1000.exr and --layer t.%d.exr for s.1000.exr); give each a name of its own
-o o.%V.#.png q.%V.####.exr => q.right.0002.exr: no such frame (first of 1 missing, 4 listed by --views left,right); render it, or give --skip-bad-frames
--views left,mono,right -o o.%V.#.png q.%V.####.exr => q.mono.0001.exr: no such frame (first of 3 missing, 6 listed by --views left,mono,right); render them, or give --skip-bad-frames
-f 1-2 -o o.%V.#.png q.%V.####.exr => q.right.0002.exr: no such frame (first of 1 missing, 4 listed by --frames 1-2); render it, or give --skip-bad-frames
-o o.%V.png q.%V.exr => q.left.exr: no such frame (first of 2 missing, 2 listed by --views left,right); render them, or give --skip-bad-frames
-o o.%V.#.png none/%V.####.exr => none/left.####.exr: cannot list the folder (No such file or directory); check the path
-o o.#.png v.%V.####.exr => o.#.png: one name for several views (found 2); write a name with %V or %v, such as out.%V.png, or -
-o o.%V.png in.exr => o.%V.png: %V and %v need views (in.exr has no %V in its name and no views inside); give --views left,right
--views left,lefty -o o.%V.png w.%v.exr => w.%v.exr: %v is the same letter for two views (found left and lefty); write %V
--views left, -o o.%V.png w.%v.exr => --views: not a list of views (found "" in "left,"); write each name once and without a slash, e.g. left,right
--views all -o o.%V.png w.%v.exr => --views: all means the views inside a file (found %V or %v in w.%v.exr); list them, e.g. --views left,right
--views a,b,a -o o.%V.png w.%v.exr => --views: not a list of views (found "a" in "a,b,a"); write each name once and without a slash, e.g. left,right
--views a/b -o o.%V.png w.%v.exr => --views: not a list of views (found "a/b" in "a/b"); write each name once and without a slash, e.g. left,right
-o o.%V.#.png v.%V.####.exr s.####.exr => s.####.exr: no %V or %v (found in v.%V.####.exr); make them in separate runs
--views l,r -o o.%V.png --debug sensors=o.%v.png w.%v.exr => o.l.png: given for two outputs (--output o.%V.png for w.l.exr and --debug sensors o.%v.png for w.l.exr); give each a name of its own
--views a,a1 -f 1,11 --skip-bad-frames -o o.%V#.png v.%V.####.exr => o.a11.png: given for two outputs (--output o.%V#.png for v.a1.0001.exr and --output o.%V#.png for v.a.0011.exr); give each a name of its own
--views left,right --hdr h.#.exr -f 1,3,5 s.####.exr => s.0003.exr: no such frame (first of 2 missing, 3 listed by --frames 1,3,5); render them, or give --skip-bad-frames
--views left,right -o no.%V/o.png in.exr => no.left/o.png: cannot be written (folder no.left: No such file or directory); make the folder or give --create-dir
ROWS

# -- kernels -------------------------------------------------------------------

refuses 3 nowhere.exr 'no such kernel' -k nowhere.exr in.exr
frame zeros.exr kind=zeros size=9x9
refuses 4 zeros.exr 'a kernel of zeros' -k zeros.exr in.exr
frame nan.exr kind=nan size=9x9 type=float
refuses 4 nan.exr 'a kernel with NaN' -k nan.exr in.exr
frame deep.exr deep=1
refuses 4 deep.exr 'a deep kernel' -k deep.exr in.exr
frame dark.exr kind=dark
refuses 4 zeros.exr 'a kernel of zeros for a dark frame' -k zeros.exr dark.exr

# -- places that cannot be written ---------------------------------------------

run -o there/none/x.png in.exr
fails_with 3 there/none/x.png 'a folder that does not exist'
run --hdr there/h.exr -o there/none/x.png in.exr
fails_with 3 there/none/x.png 'one good output, one without its folder'
empty_folder there 'one good output, one without its folder: none is written'
run -o there --hdr there/h.exr in.exr
status_is 2 'a folder as picture: its ending is unknown'
run --hdr folder.exr in.exr
fails_with 3 folder.exr 'a folder as output'
run --report there/none/r.json -o there/x.png in.exr
fails_with 3 there/none/r.json 'a report without its folder'
run -o in.exr/x.png in.exr
fails_with 3 in.exr/x.png 'a file as folder'
long=$(printf '%0300d' 0)
run -o "there/$long.png" in.exr
fails_with 3 "$long" 'a name that is too long'
empty_folder there 'nothing written in these places'
run --create-dir -o made/by/x.png in.exr
quiet_success '--create-dir'
ok '--create-dir makes the folders' test -s made/by/x.png
run --create-dir --report made/too/r.json -o made/by/x.png in.exr
quiet_success '--create-dir and a report'
ok '--create-dir makes the folders of the report' test -s made/too/r.json
run --create-dir -o in.exr/by/x.png in.exr
fails_with 3 in.exr/by/x.png 'a folder that is a file'
like "$(cat err)" '*Not a directory*check the name*' 'a folder that is a file: says why'
printf 'e\033[31m' >name
run -o made/x.png "$(cat name).exr"
status_is 3 'a name that colours the terminal'
no 'no line moves the cursor' grep -q "$(printf '\033')" err

# -- full disks ----------------------------------------------------------------

if [ -c /dev/full ]; then
    for option in --hdr --layer -o --report; do
        run $option /dev/full in.exr
        fails_with 3 /dev/full "$option to a full device"
    done
    for option in --hdr --layer -o --report; do
        "$glarepp" $option - in.exr >/dev/full 2>err
        status=$?
        fails_with 3 '' "$option - to a full device"
    done
    "$glarepp" --help >/dev/full 2>err
    status=$?
    fails_with 3 '' '--help to a full device'
else
    skip 18 'no /dev/full'
fi

# files left by a full disk, old and temporary ones included
full_disk()
{
    cp good.png small/old.png
    "$glarepp" --layer small/old.exr --compression none in.exr || return
    cp small/old.exr old.exr
    for to in '-o small/new.tif' '-o small/new.png --depth-bits 16' \
        '--hdr small/new.exr --compression none' \
        '--layer small/new.exr --compression zip --type float' \
        '--layer small/new.exr --compression dwaa --type float'; do
        run $to wide.exr
        fails_with 3 small/new. "a full disk, $to"
        is "$(ls -A small | xargs)" 'old.exr old.png' "a full disk, $to: no half file"
    done
    run --hdr small/old.exr --compression none wide.exr
    fails_with 3 small/old.exr 'a full disk, over an old file'
    same small/old.exr old.exr 'a full disk: the old EXR is whole'
    run -o small/old.png --depth-bits 16 wide.exr
    fails_with 3 small/old.png 'a full disk, over an old picture'
    same small/old.png good.png 'a full disk: the old PNG is whole'
    run -o there/first.png --hdr small/new.exr --compression none wide.exr
    fails_with 3 small/new.exr 'a full disk beside a good place'
    is "$(ls -A small | xargs)" 'old.exr old.png' 'a full disk: nothing new'
    rm -f there/first.png
}
mkdir small
if [ "$(id -u)" = 0 ] &&
    mount -t tmpfs -o size=48k tmpfs small 2>/dev/null; then
    mounted=$tmp/small
    full_disk
else
    skip 25 'no small disk can be mounted'
fi

# -- no GL ---------------------------------------------------------------------

export GLAREPP_OSMESA=/nonexistent
refuses 5 /nonexistent 'no OSMesa' --engine splat --projection plane --gl osmesa in.exr
like "$(cat err)" '*libosmesa6*' 'no OSMesa: names the package'
export GLAREPP_EGL=/nonexistent
refuses 5 /nonexistent 'no EGL' --engine splat --projection plane --gl egl in.exr
refuses 5 libosmesa6 'no GL at all' --engine splat --projection plane in.exr
run --engine splat --layer dark-layer.exr dark.exr
status_is 0 'no GL is no matter where there is no light'
run --layer any.exr in.exr
quiet_success 'no GL is no matter for auto'
unset GLAREPP_OSMESA GLAREPP_EGL

# -- old files stay ------------------------------------------------------------

cp good.png kept.png
cp in.exr kept.exr
for wrong in cut.exr empty.exr deep.exr nowhere.exr; do
    run -o kept.png --hdr kept.exr $wrong
    cmp -s kept.png good.png && cmp -s kept.exr in.exr
    result $? "$wrong: the outputs that stood before are whole"
done
cp in.exr self.exr
ln -s self.exr other-name.exr
run --hdr self.exr self.exr
fails_with 2 self.exr 'a frame over itself'
run --hdr other-name.exr self.exr
fails_with 2 other-name.exr 'a frame over itself by another name'
same self.exr in.exr 'a frame over itself: the frame is whole'

# -- pipes that end and signals ------------------------------------------------

{
    "$glarepp" --hdr - --compression none wide.exr 2>err
    echo $? >code
} | head -c 100 >head.out
status=$(cat code)
fails_with 3 '' 'a reader that leaves'
is "$(wc -c <head.out)" 100 'a reader that leaves has got its bytes'

# A run of many frames is ended in its middle, at several moments
i=0
while [ $i -lt 400 ]; do
    i=$((i + 1))
    ln wide.exr "many.$(printf %04d $i).exr"
done
mkdir seq
for signal in 'INT --compression zip' 'TERM --compression dwaa' \
    'HUP --compression none'; do
    written=${signal#* } signal=${signal%% *}
    for delay in 0 0.05 0.12; do
        rm -rf seq && mkdir seq
        # sh has background jobs ignore SIGINT, nohup SIGHUP; this gives
        # them back
        "$python" - "$signal" "$delay" "$glarepp" $written <<'PY' >code 2>err
import os, signal, subprocess, sys, time
name, delay, program, *written = sys.argv[1:]
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)
p = subprocess.Popen([program, "--hdr", "seq/h.####.exr", "-o", "seq/o.####.png",
                      "--type", "float", *written, "many.####.exr"])
while not os.listdir("seq") and p.poll() is None:
    time.sleep(0.002)
time.sleep(float(delay))
p.send_signal(getattr(signal, "SIG" + name))
code = p.wait()
print("ended" if code == -getattr(signal, "SIG" + name) else code)
PY
        is "$(cat code)" ended "SIG$signal after $delay s ends the run"
        is "$(find seq -name '.*' -type f)" '' \
            "SIG$signal after $delay s leaves no temporary file"
        cut=
        for f in seq/*.exr; do
            [ -e "$f" ] || continue
            [ -n "$cut" ] || "$glarepp" --report whole.json "$f" 2>cut.err ||
                cut=$f
        done
        is "$cut" '' "SIG$signal after $delay s leaves whole files only"
    done
done

# -- words -------------------------------------------------------------------------

run -q kernel -o there/k.exr
fails_with 2 'kernel: no such file (found a command' 'a command after an option'
like "$(cat err)" '*write the command first: glarepp kernel' \
    'a command after an option: what to do'
ln -s nowhere/a.png there/link.png
run -q -o there/link.png in.exr
fails_with 3 'there/link.png: cannot be written (a link into a folder that is not there)' \
    'a link that leads nowhere'
rm there/link.png
echo '{"asset": {"version": "2.0"}, "nodes": [{"mesh": -1}]}' >less.gltf
run -q --scene less.gltf -o there/a.png in.exr
fails_with 4 '"mesh" out of range (found -1); give 0 to 2147483647' \
    'a range is written out'
"$python" - <<'PY'
import struct, zlib
def chunk(kind, data):
    return (struct.pack(">I", len(data)) + kind + data +
            struct.pack(">I", zlib.crc32(kind + data)))
fits, rows = zlib.compress(bytes(52)), zlib.compress(bytes(117))
for name, *data in (("rows", rows), ("bytes", fits + b"more"),
                    ("chunks", fits, zlib.compress(bytes(range(52)))),
                    ("sum", fits[:-4], *(bytes([b]) for b in fits[-4:]))):
    open(name + ".png", "wb").write(
        b"\x89PNG\r\n\x1a\n" +
        chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 8, 2, 0, 0, 0)) +
        b"".join(chunk(b"IDAT", d) for d in data) + chunk(b"IEND", b""))
PY
for name in rows bytes chunks; do
    run -t 0 --layer there/a.exr $name.png
    status_is 0 "a PNG with more $name than its size"
    like "$(cat err)" "*$name.png: more data than its 4 x 4 pixels; the rest is left out*" \
        "a PNG with more $name than its size: a warning"
done
run -t 0 --layer there/a.exr sum.png
is "$(grep -c 'more data' err)" 0 'a checksum in chunks of its own is no more data'
rm there/a.exr
echo '{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
"nodes": [{"camera": 0}], "cameras": [{"type": "perspective",
"perspective": {"yfov": 1, "znear": 0.1}}]}' >one.gltf
without_gl() {
    want=$1
    shift
    GLAREPP_OSMESA=/none.so GLAREPP_EGL=/none.so "$glarepp" "$@" >out 2>err
    is "$(sed 's/.*libegl-mesa0)//' err)" "$want" "no GL for $1 $2: what needs none"
}
sun='--sun 3,3,2 --sun-color 9,9,9 -o there/a.png in.exr'
without_gl '' sets one.gltf
without_gl ', or use --sun-method exact' --sun-method readback $sun
without_gl ', or use --engine fft' --engine splat --projection plane -o there/a.png in.exr
without_gl ', or use --engine fft and --sun-method exact, which need none' \
    --engine splat --sun-method mask $sun

done_testing
