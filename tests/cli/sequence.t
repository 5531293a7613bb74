#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Frame patterns, lists of frames, and frames that depend on no other frame.
. "$(dirname "$0")/lib.sh"
need_python
no_provenance

# five frames of three sizes; one of them dark
mkdir in
frame in/shot.0007.exr size=64x48 seed=7
frame in/shot.0008.exr size=80x33 seed=8
frame in/shot.0009.exr size=64x48 kind=dark
frame in/shot.0010.exr size=31x57 seed=10 origin=-4,9
frame in/shot.0012.exr size=64x48 seed=12 type=float
touch in/shot.11.exr in/shot.0013.exr.bak in/shot.00x4.exr
mkdir alone
# (auto may keep the engine of the frame before, and differ by rounding)
for n in 0007 0008 0009 0010 0012; do
    "$glarepp" -e fft --hdr alone/h.$n.exr --layer alone/l.$n.exr \
        -o alone/o.$n.png in/shot.$n.exr || exit 1
done

# numbers FOLDER: what was made there, as one line of frame numbers
numbers()
{
    ls "$1" | sed 's/^[a-z]*\.\([-0-9]*\)\..*/\1/' | sort -nu | xargs
}

# makes WANTED DESCRIPTION ARGUMENT...: into a fresh folder `made`
makes()
{
    wanted=$1 about=$2
    shift 2
    rm -rf made && mkdir made
    run "$@"
    quiet_success "$about"
    is "$(numbers made)" "$wanted" "$about: the frames"
}

# -- frames on disk ------------------------------------------------------------

makes '0007 0008 0009 0010 0012' 'all frames on disk' -e fft --hdr made/h.####.exr \
    --layer made/l.####.exr -o made/o.####.png 'in/shot.####.exr'
for kind in h o l; do
    for n in 0007 0008 0009 0010 0012; do
        ending=exr
        [ $kind != o ] || ending=png
        same made/$kind.$n.$ending alone/$kind.$n.$ending \
            "$kind.$n.$ending: the bytes of a run of its own"
    done
done
for engine in fft direct; do
    makes '0007 0008 0009 0010 0012' "sizes that change, $engine" \
        --engine $engine --layer made/l.####.exr 'in/shot.####.exr'
    cp made/l.0012.exr last.exr
    makes 12 "one frame, $engine" --engine $engine --layer made/l.@.exr \
        in/shot.0012.exr
    same made/l.12.exr last.exr "$engine: no frame depends on those before it"
done
makes '7 8 9 10 12' '%04d to %d' -o made/o.%d.png in/shot.%04d.exr
is "$(ls made | wc -l)" 5 '%04d to %d: as many'
rm -rf made && mkdir made
run -o made/o.@.png 'in/shot.@@@@.exr'
quiet_success '@@@@ to @'
is "$(ls made | sort -V | xargs)" 'o.7.png o.8.png o.9.png o.10.png o.12.png' \
    '@@@@ to @: names'
makes '000007 000008 000009 000010 000012' '###### out' -o 'made/o.######.png' \
    'in/shot.####.exr'
run -o 'made/o.#.png' 'in/shot.#.exr'
fails_with 4 in/shot.11.exr 'shot.# is no shot.####: the empty shot.11'

# -- lists ---------------------------------------------------------------------

makes '0007 0008 0009 0010' '--frames 7-10' -f 7-10 -o made/o.####.png \
    'in/shot.####.exr'
makes '0008 0010 0012' '--frames 8-12x2' --frames=8-12x2 -o made/o.####.png \
    'in/shot.####.exr'
makes '0007 0010 0012' '--frames 12,10,7' -f12,10,7 -o made/o.####.png \
    'in/shot.####.exr'
makes '0007 0008 0009' '--frames 9-7,8,7' -f 9-7,8,7 --report made.json \
    -o made/o.####.png 'in/shot.####.exr'
is "$(sed 's/.*"frame":\([0-9]*\).*/\1/' made.json | xargs)" '9 8 7' \
    '--frames 9-7,8,7: in this order, none twice'
for wrong in x 1- 1-2x0 1,,2 '' 1-2x 1..5 1-99999999 7-5x-1 1-9x2y; do
    run -f "$wrong" -o made/p.####.png 'in/shot.####.exr'
    status_is 2 "--frames '$wrong' is a usage error"
    one_line_error glarepp "--frames '$wrong': one line"
done
frame in/neg.-003.exr seed=3
makes -003 'a negative frame' -f -3 -o made/o.####.png 'in/neg.####.exr'

# -- missing frames ------------------------------------------------------------

rm -rf made && mkdir made
run -f 9-12 -o made/o.####.png 'in/shot.####.exr'
fails_with 3 in/shot.0011.exr 'a frame that is missing'
empty_folder made 'a frame that is missing: found before the first is made'
run -o made/o.####.png 'in/none.####.exr'
fails_with 3 'in/none.####.exr' 'a pattern without frames'
run -o made/o.####.png 'none/shot.####.exr'
fails_with 3 'none' 'a pattern in no folder'

# -- patterns that go together -------------------------------------------------

rm -rf made && mkdir made
run -o made/one.png 'in/shot.####.exr'
fails_with 2 made/one.png 'a sequence into one name'
run -o made/o.####.png in.exr
status_is 2 'a pattern for a frame without a number'
run -f 1-3 -o made/o.png in/shot.0007.exr
fails_with 2 in/shot.0007.exr '--frames without a pattern'
run -o 'made/####.%d.####.png' 'in/shot.####.exr'
status_is 0 'printf form counts before signs'
rm -rf made && mkdir made
run -o 'made/####.####.png' 'in/shot.####.exr'
fails_with 2 'made/####.####.png' 'two places for the number'
run -o made/o.####.png in/shot.0007.exr in/shot.0007.exr
fails_with 2 in/shot.0007.exr 'one frame twice'
run -o made/o.%012d.png 'in/shot.####.exr'
fails_with 2 made/o.%012d.png 'too many digits'
empty_folder made 'none of these made anything'
makes '0008 0010' 'plain files, numbered by their names' -o made/o.####.png \
    in/shot.0010.exr in/shot.0008.exr
cp in/shot.0007.exr 'in/odd.####.exr'
makes '' 'a file of a pattern'"'"'s own name' -e fft --hdr odd.exr 'in/odd.####.exr'
same odd.exr alone/h.0007.exr 'a file of a pattern'"'"'s own name: is read'

# -- views ---------------------------------------------------------------------

# two eyes of frames 1 and 2, by long and short names, and in folders
mkdir eyes eyes/left eyes/right
for n in 1 2; do
    frame eyes/s.left.000$n.exr size=48x32 seed=2$n
    frame eyes/s.right.000$n.exr size=48x32 seed=3$n
    for eye in left right; do
        cp eyes/s.$eye.000$n.exr eyes/$eye/s.$n.exr
        cp eyes/s.$eye.000$n.exr "eyes/s_$(printf %.1s $eye).$n.exr"
        "$glarepp" -e fft --hdr alone/h.$eye.$n.exr -o alone/o.$eye.$n.png \
            eyes/s.$eye.000$n.exr || exit 1
    done
done

# sees DESCRIPTION ARGUMENT...: both eyes of both frames, made/o.EYE.N.png
sees()
{
    about=$1
    shift
    rm -rf made && mkdir made made/left made/right
    run -e fft "$@"
    quiet_success "$about"
    differ=
    for eye in left right; do
        for n in 1 2; do
            cmp -s "alone/o.$eye.$n.png" "made/o.$eye.$n.png" ||
                differ="$differ $eye $n"
        done
    done
    is "$differ" '' "$about: each eye as made alone"
}
sees '%V without --views' -o 'made/o.%V.#.png' 'eyes/s.%V.####.exr'
is "$(ls made | xargs)" 'left o.left.1.png o.left.2.png o.right.1.png o.right.2.png right' \
    '%V without --views: left and right, no more'
sees '%v in, %V out' -o 'made/o.%V.#.png' 'eyes/s_%v.#.exr'
sees '--views right,left' --views right,left --report r.json \
    -o 'made/o.%V.#.png' 'eyes/%V/s.#.exr'
is "$(sed 's/.*"input":"\([^"]*\)".*/\1/' r.json | xargs)" \
    'eyes/right/s.1.exr eyes/left/s.1.exr eyes/right/s.2.exr eyes/left/s.2.exr' \
    '--views right,left: frame by frame, in this order'
sees '%V in folders, with --create-dir' -f 2,1 --create-dir \
    --hdr 'made/more/%V/%v.%02d.exr' -o 'made/o.%V.#.png' 'eyes/%V/s.#.exr'
is "$(cd made/more && ls */* | xargs)" \
    'left/l.01.exr left/l.02.exr right/r.01.exr right/r.02.exr' \
    '%V in folders, with --create-dir: names'
same made/more/right/r.02.exr alone/h.right.2.exr '%V in folders: the bytes'
for eye in left right; do
    rm -rf made && mkdir made
    run -e fft --views $eye -o made/o.#.png 'eyes/s.%V.####.exr'
    quiet_success "--views $eye: a sequence of its own"
    same made/o.2.png alone/o.$eye.2.png "--views $eye: the bytes"
done
for n in 1 2; do
    rm -rf made && mkdir made
    run -e fft -o 'made/o.%V.png' "eyes/s.%V.000$n.exr"
    quiet_success "one frame, $n"
    same made/o.right.png alone/o.right.$n.png "one frame, $n: the right eye"
done
run -e fft --stdout-format png -o - 'eyes/s.%V.####.exr'
quiet_success 'both eyes to stdout'
cat alone/o.left.1.png alone/o.right.1.png alone/o.left.2.png \
    alone/o.right.2.png >pngs
same out pngs 'both eyes to stdout: frame by frame, left first'
cp eyes/s.left.0001.exr 'eyes/odd.%V.exr'
run -e fft -o odd.png 'eyes/odd.%V.exr'
quiet_success 'a file that is called %V'
same odd.png alone/o.left.1.png 'a file that is called %V: is read'

# aside planes follow the eye: without one, nothing hides the sun
frame eyes/m.left.exr channels=R,G,B,A size=48x32 kind=dark
frame eyes/m.right.exr channels=R,G,B,A size=48x32 kind=dark
run -e fft --sun 24,16,4 --sun-color 40 --mask A --mask-file 'eyes/m.%V.exr' \
    --hdr 'made/s.%V.exr' 'eyes/s.%V.0001.exr'
quiet_success '--mask-file with %V'
"$glarepp" -q -e fft --sun 24,16,4 --sun-color 40 --mask A \
    --mask-file eyes/m.right.exr --hdr s.exr eyes/s.right.0001.exr
same made/s.right.exr s.exr '--mask-file with %V: that of the eye'
run -e fft --sun 24,16,4 --sun-color 40 --mask A --mask-file 'eyes/m.%V.exr' \
    --hdr made/t.exr eyes/s.left.0001.exr
fails_with 2 'eyes/m.%V.exr' '--mask-file with %V and no views'

# wrong STATUS NAME DESCRIPTION ARGUMENT...: one line, and nothing is made
wrong()
{
    wanted=$1 name=$2 about=$3
    shift 3
    rm -rf made && mkdir made
    run "$@"
    fails_with "$wanted" "$name" "$about"
    empty_folder made "$about: makes nothing"
}
wrong 2 'made/o.#.png' 'one name for two eyes' -o 'made/o.#.png' 'eyes/s.%V.####.exr'
wrong 2 'made/o.%V.png' '%V out and no views' -o 'made/o.%V.png' in/shot.0007.exr
wrong 2 'eyes/s_%v.#.exr' 'one letter for two views' --views left,lefty \
    -o 'made/o.%V.#.png' 'eyes/s_%v.#.exr'
wrong 2 made/o.l.png 'two names that are one' --views l,r -o 'made/o.%V.png' \
    --layer 'made/o.%v.png' 'eyes/s_%v.1.exr'
wrong 2 eyes/s.left.0001.exr 'over its own input' --hdr 'eyes/s.%V.%04d.exr' \
    'eyes/s.%V.####.exr'
wrong 2 made/o.png 'views in the file, one name' --views left,right -o made/o.png \
    in/shot.0007.exr
for list in , left, left,left a/b ,left; do
    wrong 2 --views "--views '$list'" --views "$list" -o 'made/o.%V.png' \
        'eyes/s_%v.1.exr'
done
same eyes/s.left.0001.exr eyes/left/s.1.exr 'over its own input: it is whole'
rm eyes/s.right.0002.exr
wrong 3 eyes/s.right.0002.exr 'an eye that is missing' -o 'made/o.%V.#.png' \
    'eyes/s.%V.####.exr'
wrong 3 eyes/s.right.0002.exr 'an eye that is missing, --frames' -f 1,2 \
    -o 'made/o.%V.#.png' 'eyes/s.%V.####.exr'

# -- primaries and pixels that change ------------------------------------------

ap0=chromaticities:chromaticities:.7347,.2653,0,1,.0001,-.077,.32168,.33767
frame mixed.1.exr size=90x70 lights=3
frame mixed.2.exr size=90x70 lights=3 attr=$ap0
frame mixed.3.exr size=90x70 lights=3 aspect=2
frame mixed.4.exr size=90x70 lights=3
frame disc.exr kind=kernel size=31x31
for kernel in builtin:streak disc.exr; do
    run -q -e fft -k $kernel --layer mixed.l.#.exr --debug polygons=mixed.p.#.png \
        mixed.#.exr
    quiet_success "$kernel: primaries and pixel aspect change within a sequence"
    for n in 1 2 3 4; do
        run -e fft -k $kernel --layer own.exr --debug polygons=own.png mixed.$n.exr
        same mixed.l.$n.exr own.exr "$kernel: frame $n is as by itself"
        same mixed.p.$n.png own.png "$kernel: frame $n, while the next is made"
    done
done

# -- the words -----------------------------------------------------------------

run --help all
like "$(cat out)" '*--views LIST*' '--views is in --help'
grep -qF -- '\-views' "$root/man/glarepp.1"
result $? '--views is in the man page'
for row in 'bench 2' 'compare 64'; do
    run "${row% *}" --views left,right in.exr in.exr
    status_is "${row#* }" "--views is not for ${row% *}"
done

done_testing
