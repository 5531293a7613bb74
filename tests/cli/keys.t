#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Values that change over frames: the bytes of frames made one by one. Files of
# settings, and settings of a picture: its bytes again.
. "$(dirname "$0")/lib.sh"
need_python
real=$glarepp
no_provenance

mkdir in one made
for n in 0007 0008 0009 0010; do
    frame in/s.$n.exr size=64x48 seed=$n
done
cp in/s.0007.exr in/plain.exr
printf 'frame,x,y,radius\n7,10,12,3\n# lost\n10, 40, 30.5, 1.5 # found\n' >sun.csv
frame k.exr kind=kernel size=9x7

# keyed: the options of the sequence
keyed()
{
    run -q -e fft --gain 7:0.1,9:0.3 --threshold 0:0.5,8:0.1,20:0.7 \
        --exposure 8:-1,11:0.7 --sun @sun.csv --sun-color 50 --max-value \
        8:3,9:1.7 -k k.exr --kernel-center 7:4.5/3.5,10:2/3 --kernel-size \
        7:100,10:200% --rotate \
        9:90,10:180 "$@"
}
# alone NUMBER: the same of one frame, as plain numbers in double
alone()
{
    "$python" - "$1" >words <<'PY'
import sys
f = int(sys.argv[1])
def at(*keys):
    before = [k for k in keys if k[0] <= f] or [keys[0]]
    after = [k for k in keys if k[0] > f] or [keys[-1]]
    (a, *x), (b, *y) = before[-1], after[0]
    t = (f - a) / (b - a) if a < f < b else 0
    return ",".join("%.17g" % (p + t * (q - p)) for p, q in zip(x, y))
print("-g", at((7, .1), (9, .3)), "-t", at((0, .5), (8, .1), (20, .7)))
print("--exposure=" + at((8, -1), (11, .7)), "--sun-color 50")
print("--sun", at((7, 10, 12, 3), (10, 40, 30.5, 1.5)), "-k k.exr")
print("--max-value", at((8, 3), (9, 1.7)))
print("--kernel-size", at((7, 100), (10, 200)))
print("--kernel-center", at((7, 4.5, 3.5), (10, 2, 3)))
print("--rotate", at((9, 90), (10, 180)))
PY
    # shellcheck disable=SC2046
    run -q -e fft $(cat words) -o one/$1.png --hdr one/$1.exr --layer one/l.$1.exr \
        in/s.$1.exr
}
for n in 0007 0008 0009 0010; do
    alone $n
    quiet_success "frame $n alone"
done
for jobs in 1 4; do
    keyed --frame-jobs $jobs -f 8,10,7,9 -o made/####.png --hdr made/####.exr \
        --layer made/l.####.exr --report $jobs.json 'in/s.####.exr'
    quiet_success "keys, $jobs in flight"
    for n in 0007 0008 0009 0010; do
        for name in $n.png $n.exr l.$n.exr; do
            same made/$name one/$name "$name: the bytes of a run of its own"
        done
    done
    rm made/*
done
no 'frames differ' cmp -s one/0007.exr one/0008.exr
is "$(field 4.json '[o["frame"], o["settings"]["gain"], o["settings"]["sun"]]')" \
    '[8, 0.2, [20.0, 18.16666667, 2.5]]' "the report's settings are the frame's"
like "$(field 4.json 'o["command"]')" '*--gain 7:0.1,9:0.3 *--sun @sun.csv *' \
    'and its command has the words'
keyed -f 9 -o made/#.png 'in/s.####.exr'
same one/0009.png made/9.png 'a farm renders one of them'
cat in/s.0007.exr in/s.0008.exr >two.exr
run -f 8,9 --gain 8:0,9:0.5 --report - -o made/#.png - <two.exr
is "$(sed 's/.*"gain": *\([0-9.]*\).*/\1/' out | xargs)" '0.0 0.5' \
    'frames of stdin, by --frames'
run -f 7,9,10 --gain 7:0,9:1e6 -v -o made/#.png 'in/s.####.exr'
like "$(cat err)" '*, 0 % of the light moved*e+06 % added*' "-v: the frame's own gain"

# GL ends on the thread that it began on
for jobs in 1 3; do
    run -e splat --projection plane --sun-method mask --sun @sun.csv --sun-color 50 --frame-jobs \
        $jobs --hdr made/$jobs.####.exr 'in/s.####.exr'
    [ $status = 0 ] || break
done
if [ $status = 5 ]; then
    skip 1 'no GL'
else
    same made/1.0010.exr made/3.0010.exr 'GL, one and three in flight'
fi

# -- errors of keys: no output is made -------------------------------------------

rm -rf made && mkdir made
# wrong STATUS NAME ARGUMENT...: one line with that
wrong()
{
    wanted=$1 name=$2
    shift 2
    run -o made/o.png "$@"
    fails_with "$wanted" "$name" "$*"
}
wrong 2 'in/plain.exr: no frame number' --gain 1:2 in/plain.exr
wrong 2 '--threads: takes no keys' --threads 1:2 in/s.0007.exr
wrong 2 '--report would replace a file that is read (--sun sun.csv)' \
    --sun @sun.csv --report sun.csv in/s.0007.exr
printf 'frame,gain\n7,1\n8,-1\n' >bad.csv
wrong 4 'bad.csv:3: --gain: out of range (found -1)' --gain @bad.csv in/s.0007.exr
mkfifo pipe
wrong 4 'pipe: no regular file' --gain @pipe in/s.0007.exr
rm pipe
run kernel --fov 1:20,2:30 -k cie -o made/k.exr
fails_with 2 '--fov: takes no keys here' 'glarepp kernel'
empty_folder made 'nothing was made'
run -q --lens heliar --focus-distance 7:1,8:0.0001 --frame-jobs 3 -o made/#.png \
    'in/s.####.exr'
fails_with 2 'in/s.0008.exr: ' 'a value that only one frame cannot have'
is "$(ls made)" 7.png 'the frame before it is made'

# -- settings ----------------------------------------------------------------------

glarepp=$real
rm -rf made && mkdir made looks again
cp k.exr "it's ä.exr"
cp sun.csv k.exr looks
# made_again SETTINGS: the pictures of `made`, byte for byte
made_again()
{
    run -q --settings "$1" -o again/o.png --hdr again/o.exr in/s.0008.exr
    quiet_success "--settings $1"
    same made/o.png again/o.png "$1: the PNG"
    same made/o.exr again/o.exr "$1: the EXR"
    rm -f again/*
}
run -q -g .5 -k "it's ä.exr" --kernel-center 2,3 -t 7:.1,9:.4 --sun @sun.csv \
    --sun-color 9 --no-dither --type float --tonemap agx --save-settings s.txt \
    -o made/o.png --hdr made/o.exr in/s.0008.exr
quiet_success '--save-settings'
made_again s.txt
cp made/o.png made/o.exr .
made_again o.png
made_again o.exr
run --settings o.exr --save-settings t.txt
quiet_success 'settings of a picture as text, without a frame'
made_again t.txt
run --settings t.txt --save-settings again.txt
same t.txt again.txt 'read and written: the same text'
is "$(sed -n '2,3p' s.txt)" "--gain .5
--kernel 'it'\\''s ä.exr'" 'an option a line, as it was given'

# files beside the settings
printf -- '-k k.exr --sun @sun.csv --sun-color 50\n' >looks/l.txt
rm k.exr sun.csv
run -q --settings looks/l.txt -o made/o.png --hdr made/o.exr in/s.0008.exr
quiet_success 'files beside the settings'
cp made/o.png looks
made_again looks/o.png
cp looks/o.png away.png
run --settings away.png -o again/o.png in/s.0008.exr
fails_with 3 'away.png: --kernel: no file k.exr (looked for in the current folder)' \
    'a file that is not there'
printf -- '--gain 1\n--gian 2\n' >bad.txt
run --settings bad.txt -o again/o.png in/s.0008.exr
fails_with 4 'bad.txt:2: --gian: unknown option' 'an unknown option'
run --settings in/plain.exr -o again/o.png in/s.0008.exr
fails_with 4 'in/plain.exr: no settings (found no glarepp:command)' 'a frame'
"$glarepp" compare --difference minus.exr in/s.0007.exr in/s.0008.exr >/dev/null
run --settings minus.exr -o again/o.png in/s.0008.exr
fails_with 4 'minus.exr: no settings of a picture (found the command glarepp compare)' \
    'of another command'
run --settings in -o again/o.png in/s.0008.exr
fails_with 3 'in: cannot read (it is a folder)' 'a folder'
run --settings looks/o.png -o looks/o.png in/s.0008.exr
fails_with 2 'would replace a file that is read (--settings looks/o.png)' \
    'the picture is not replaced'
printf -- '-g 2\n' >t.txt
run --settings t.txt --save-settings t.txt
fails_with 2 'would replace a file that is read' 'nor the settings'
run --save-settings none/s.txt -o again/o.png in/s.0008.exr
fails_with 3 none/s.txt 'a folder that is not there'
run --save-settings s.txt -o again/o.png
fails_with 2 'no input' 'a picture of nothing'
empty_folder again 'nothing was made'
cp s.txt kept.txt
run -g 3 --save-settings s.txt --no-clobber -o again/o.png in/s.0008.exr
same s.txt kept.txt '--no-clobber keeps settings'
run -g 3 --save-settings new/s.txt --create-dir
is "$(tail -n 1 new/s.txt)" '--gain 3' '--create-dir'

done_testing
