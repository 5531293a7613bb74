#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Frames that are bad, missing, there already, or of another size.
. "$(dirname "$0")/lib.sh"
need_python

mkdir in
for n in 1 2 3 4 5 6; do
    frame in/s.000$n.exr size=40x24 seed=$n
done
mkdir whole
"$glarepp" -e direct -o whole/o.#.png --layer whole/l.#.exr \
    'in/s.####.exr' || exit 1

# numbers FOLDER: the frames of which anything is there
numbers()
{
    ls "$1" | sed 's/^[a-z]*\.\([0-9]*\)\..*/\1/' | sort -nu | xargs
}

# as_whole DESCRIPTION: what is made has the bytes of a run without faults
as_whole()
{
    differ=
    for made in made/[ol].*; do
        cmp -s "$made" "whole/${made#made/}" || differ="$differ $made"
    done
    is "$differ" '' "$1"
}

afresh()
{
    rm -rf made && mkdir made
}

# -- --skip-bad-frames ----------------------------------------------------------

# 2 is cut short, 4 is no EXR, 5 is not there; nothing of 1 can be replaced
cp -r in bad
head -c 600 in/s.0002.exr >bad/s.0002.exr
echo 'no picture' >bad/s.0004.exr
rm bad/s.0005.exr
afresh
run -e direct -o made/o.#.png --layer made/l.#.exr 'bad/s.####.exr'
[ "$status" != 0 ] && [ "$status" != 6 ]
result $? 'without it, a bad frame has a status of its own'
is "$(numbers made)" 1 'without it, the first bad frame ends the run'
afresh
run -e direct --skip-bad-frames -f 1-7 --report r.json -o made/o.#.png \
    --layer made/l.#.exr 'bad/s.####.exr'
status_is 6 'bad frames: status 6'
is "$(numbers made)" '1 3 6' 'bad frames: the others are made'
as_whole 'bad frames: the others have the bytes they always have'
is "$(wc -l <err)" 5 'bad frames: a line for each and one at the end'
for n in 2 4 5 7; do
    is "$(grep -c "^glarepp: bad/s.000$n.exr: .*; ." err)" 1 \
        "bad frames: frame $n is said"
done
like "$(tail -n 1 err)" \
    'glarepp: --skip-bad-frames: 4 of 7 *(2,4-5,7); *--frames 2,4-5,7' \
    'bad frames: the last line lists them'
is "$("$python" -c 'import json
for line in open("r.json"):
    o = json.loads(line)
    print(o["frame"], sorted(o) == ["error", "frame", "input", "schema", "status",
                                  "version", "warnings"],
          "outputs" in o, "bad/s.%04d.exr" % o["frame"] in o.get("error", ""))
' | xargs)" \
    '1 False True False 2 True False True 3 False True False 4 True False True 5 True False True 6 False True False 7 True False True' \
    'bad frames: the report has a line for each, in order'
[ "$(sed -n '2s/.*"error":"\([^"]*\)".*/glarepp: \1/p' r.json)" = \
    "$(sed -n 1p err)" ]
result $? "bad frames: the report's error is the line that was printed"
list=$(sed -n '$s/.*--frames //p' err)
run -e direct --skip-bad-frames -f "$list" -o made/o.#.png \
    --layer made/l.#.exr 'in/s.####.exr'
status_is 6 'mended frames by the list: 7 is still not there'
is "$(numbers made)" '1 2 3 4 5 6' 'mended frames by the list: made'
as_whole 'mended frames by the list: the same bytes'

run -q -e direct --skip-bad-frames --report r.json in/s.0001.exr \
    bad/s.0004.exr none.exr
status_is 6 'plain names: status 6'
like "$(tail -n 1 err)" '*2 of 3 *(bad/s.0004.exr, none.exr);*' \
    'plain names: the last line has names'
is "$(field r.json '"error" in o')" False 'plain names: the first is made'
run -e direct --skip-bad-frames -o made/x.png bad/s.0004.exr
status_is 6 'one frame alone: status 6'

afresh
mkdir made/o.3.png # where no file can go
run -e direct --skip-bad-frames -o made/o.#.png 'in/s.####.exr'
status_is 6 'an output that cannot be written: status 6'
like "$(tail -n 1 err)" '*1 of 6 *(3);*' \
    'an output that cannot be written: said'
is "$(find made -type f | wc -l)" 5 'an output that cannot be written: the others'
rmdir made/o.3.png
as_whole 'an output that cannot be written: the same bytes'
is "$(find made -name '.*')" '' 'an output that cannot be written: nothing half'

# a frame that lacks the channel that was asked for, after one that has it
mkdir deep made.z
frame deep/d.1.exr channels=R,G,B,Z:float size=40x24 seed=1
frame deep/d.2.exr size=40x24 seed=2
frame deep/d.3.exr channels=R,G,B,Z:float size=40x24 seed=3
run -e direct --skip-bad-frames --depth Z --sun 20,12,3 --sun-color 80 \
    --hdr made.z/h.#.exr 'deep/d.#.exr'
status_is 6 'a channel that is missing: status 6'
is "$(numbers made.z)" '1 3' 'a channel that is missing: the others are made'
"$glarepp" -q -e direct --depth Z --sun 20,12,3 --sun-color 80 --hdr h.exr \
    deep/d.3.exr
same made.z/h.3.exr h.exr 'a channel that is missing: leaves nothing behind'

# an error of all frames is no bad frame
afresh
run --skip-bad-frames -k none.exr -o made/o.#.png 'in/s.####.exr'
fails_with 3 none.exr 'a kernel that is missing'
run --skip-bad-frames -o made/o.#.png 'none/s.####.exr'
fails_with 3 none/s 'a folder that is missing'
if [ -w /dev/full ]; then
    run -e direct --skip-bad-frames --report /dev/full 'in/s.####.exr'
    fails_with 3 /dev/full 'a report that cannot be written'
    "$glarepp" -e direct --skip-bad-frames --hdr - 'in/s.####.exr' \
        >/dev/full 2>err
    status=$?
    fails_with 3 stdout 'a stdout that takes nothing'
else
    skip 4 'no /dev/full here'
fi

# -- missing frames -------------------------------------------------------------

afresh
run -e direct -f 1-9 -o made/o.#.png 'bad/s.####.exr'
fails_with 3 bad/s.0005.exr 'frames that are missing'
like "$(cat err)" '* 4 *, 9 *' 'frames that are missing: how many'
empty_folder made 'frames that are missing: known before the first is made'

# -- --no-clobber ---------------------------------------------------------------

afresh
run -e direct --no-clobber -f 1-3 -o made/o.#.png --layer made/l.#.exr \
    'in/s.####.exr'
quiet_success 'nothing there: all is made'
cp made/o.1.png made/o.2.png
cp made/o.1.png made/o.3.png
rm made/l.3.exr
run -e direct --no-clobber --report r.json -o made/o.#.png \
    --layer made/l.#.exr 'in/s.####.exr'
status_is 0 'some there: status 0'
like "$(cat err)" '*--no-clobber: *2 of 6*' 'some there: counted'
is "$(wc -l <err)" 1 'some there: in one line'
same made/o.2.png made/o.1.png 'some there: a whole set is left alone'
is "$(sed 's/.*"frame":\([0-9]*\).*/\1/' r.json | xargs)" '3 4 5 6' \
    'some there: the others are made'
cp whole/o.2.png made/
as_whole 'some there: a set with a hole is made anew'
run -q -e direct --no-clobber --report r.json -f 1-6 -o made/o.#.png \
    --layer made/l.#.exr 'gone/s.####.exr'
quiet_success 'all there: the inputs need not be'
is "$(wc -l <r.json)" 4 'all there: the report stays as it was'
echo mine >made/o.1.png
run -e direct -f 1 -o made/o.#.png 'in/s.####.exr'
quiet_success 'without it, files are replaced'
as_whole 'without it: by the same bytes'

# files that another program, or a disk that lost power, left without their end
afresh
run -e direct -o made/o.1.png -o made/o.1.pfm --hdr made/o.1.exr in/s.0001.exr
cp -r made all
for name in o.1.png o.1.pfm o.1.exr; do
    size=$(wc -c <made/$name)
    for left in 0 1 40 $((size / 2)) $((size - 1)); do
        head -c $left all/$name >made/$name
        run -e direct --no-clobber -o made/o.1.png -o made/o.1.pfm \
            --hdr made/o.1.exr in/s.0001.exr
        status_is 0 "$name, $left bytes of it"
        is "$(cat err)" "glarepp: warning: --no-clobber: made/$name is empty or cut off and is made again" \
            "$name, $left bytes of it: a line"
        ok "$name, $left bytes of it: made again" cmp all/$name made/$name
    done
done
run -e direct --no-clobber -o made/o.1.png -o made/o.1.pfm \
    --hdr made/o.1.exr in/s.0001.exr
like "$(cat err)" '*skipped 1 of 1*' 'whole files are skipped'

# a bad frame leaves a hole that the next run fills
afresh
run -e direct --skip-bad-frames -f 1-6 -o made/o.#.png 'bad/s.####.exr'
run -e direct --skip-bad-frames --no-clobber -f 1-6 -o made/o.#.png \
    'in/s.####.exr'
status_is 0 'both together: the second run mends the first'
like "$(cat err)" '*3 of 6*' 'both together: makes what is not there'
as_whole 'both together: the same bytes'

# -- two eyes -------------------------------------------------------------------

# the right eye of 2 is broken, both of 4 are; the left one of 3 is not there
mkdir eyes
for n in 1 2 3 4 5; do
    for eye in left right; do
        cp in/s.000$n.exr eyes/$eye.$n.exr
        [ $eye = left ] || cp in/s.0006.exr eyes/$eye.$n.exr
    done
done
"$glarepp" -e direct -o 'whole/o.%V.#.png' 'eyes/%V.#.exr' || exit 1
cp -r eyes blind
head -c 600 in/s.0002.exr >blind/right.2.exr
echo 'no picture' >blind/left.4.exr
echo 'no picture' >blind/right.4.exr
rm blind/left.3.exr
afresh
run -e direct --skip-bad-frames -o 'made/o.%V.#.png' 'blind/%V.#.exr'
status_is 6 'bad eyes: status 6'
is "$(cd made && ls | xargs)" 'o.left.1.png o.left.2.png o.left.5.png o.right.1.png o.right.3.png o.right.5.png' \
    'bad eyes: the others are made'
as_whole 'bad eyes: the others have the bytes they always have'
is "$(wc -l <err)" 5 'bad eyes: a line for each and one at the end'
like "$(tail -n 1 err)" '*3 of 5 *(2-4);*--frames 2-4' \
    'bad eyes: a frame counts once'
run -e direct --no-clobber --skip-bad-frames -f 2-4 -o 'made/o.%V.#.png' \
    'eyes/%V.#.exr'
status_is 0 'mended eyes: status 0'
like "$(cat err)" '*2 of 6*' 'mended eyes: only what is not there'
is "$(ls made | wc -l)" 10 'mended eyes: all are there'
as_whole 'mended eyes: the bytes of a run without faults'
afresh
run -e direct -f 1,3 -o 'made/o.%V.#.png' 'blind/%V.#.exr'
fails_with 3 blind/left.3.exr 'an eye that is missing'
empty_folder made 'an eye that is missing: known before the first is made'
cp whole/o.left.3.png made
run -q -e direct --no-clobber -f 1,3 -o 'made/o.%V.#.png' 'blind/%V.#.exr'
quiet_success 'an eye that is missing and made: is not needed'
is "$(ls made | wc -l)" 4 'an eye that is missing and made: the others are made'
as_whole 'an eye that is missing and made: the same bytes'

# -- sizes that change ----------------------------------------------------------

# larger, smaller, dark, odd, one pixel, windows elsewhere; 5 is no picture
mkdir sizes
frame sizes/z.1.exr size=40x24 seed=1
frame sizes/z.2.exr size=96x70 seed=2 lights=40
frame sizes/z.3.exr size=17x90 seed=3 origin=-8,-30
frame sizes/z.4.exr size=40x24 kind=dark
echo 'no picture' >sizes/z.5.exr
frame sizes/z.6.exr size=1x1 kind=zeros hot=90
frame sizes/z.7.exr size=129x31 seed=7 display=0,0,199,99
frame sizes/z.8.exr size=40x24 seed=1

# sizes_by ENGINE LIMIT: against runs of one frame each
sizes_by()
{
    engine=$1 limit=$2
    shift 2
    afresh
    run -e "$engine" "$@" --skip-bad-frames --layer made/l.#.exr 'sizes/z.#.exr'
    if grep -q 'no GL' err || [ "$status" = 5 ]; then
        skip 3 "no GL for $engine"
        return
    fi
    status_is 6 "sizes that change, $engine: status"
    is "$(numbers made)" '1 2 3 4 6 7 8' "sizes that change, $engine: made"
    differ=
    for n in 1 2 3 4 6 7 8; do
        "$glarepp" -q -e "$engine" "$@" --layer alone.exr sizes/z.$n.exr
        if [ "$limit" = equal ]; then
            cmp -s alone.exr made/l.$n.exr || differ="$differ $n"
        else
            echo "made/l.$n.exr alone.exr $limit frame $n" |
                "$python" "$cli/compare.py" | grep -q '^ok' || differ="$differ $n"
        fi
    done
    is "$differ" '' "sizes that change, $engine: no frame depends on another"
}
sizes_by direct equal
sizes_by fft equal
sizes_by splat equal --projection plane
# (auto may keep the engine of the frame before, within its tolerance)
if [ -n "$oiio" ]; then
    sizes_by auto 2e-3
else
    skip 3 'no numpy or OpenImageIO'
fi
sizes_by direct equal --sun 9,8,3 --sun-color 50

done_testing
