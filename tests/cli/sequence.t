#!/bin/sh
# Frame patterns, lists of frames, and frames that depend on no other frame.
. "$(dirname "$0")/lib.sh"
need_python

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

# -- what is on disk -----------------------------------------------------------

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

# -- what is missing -----------------------------------------------------------

rm -rf made && mkdir made
run -f 9-12 -o made/o.####.png 'in/shot.####.exr'
fails_with 3 in/shot.0011.exr 'a frame that is missing'
empty_folder made 'a frame that is missing: found before the first is made'
run -o made/o.####.png 'in/none.####.exr'
fails_with 3 'in/none.####.exr' 'a pattern without frames'
run -o made/o.####.png 'none/shot.####.exr'
fails_with 3 'none' 'a pattern in no folder'

# -- what goes together --------------------------------------------------------

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

done_testing
