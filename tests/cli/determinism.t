#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The same bytes of every output: threads by frames in flight, contexts, runs,
# places and environments, for every engine and for sun masks. (One frame of
# every kind of output by threads: threads.t.)
. "$(dirname "$0")/lib.sh"
need_python

# a sequence whose frames change size, window and light
frame in.0001.exr size=127x83 origin=-11,4 display=0,0,139,79 lights=60 \
    channels=R,G,B,A,Z:float hot=60000
frame in.0002.exr size=64x91 seed=2 channels=R,G,B,A,Z:float
frame in.0003.exr size=151x40 seed=3 lights=200 channels=R,G,B,A,Z:float \
    origin=70,-20
frame kernel.exr kind=kernel size=65x64 type=float
cat >lamps.json <<'END_OF_JSON'
[{"pixel": [60, 30], "radius": 4, "depth": 40, "flux": 300},
 {"pixel": [20.5, 10.5], "flux": [9, 8, 7]}]
END_OF_JSON
echo '[{"shape": "polygon", "position": 0.6}, {"shape": "streak"}]' >flare.json
here=$PWD

# make_all FOLDER ARGUMENT...: every output of the sequence, and its report
# without what a run's time, memory, place and threads are
make_all()
{
    into=$1
    shift
    mkdir -p "$into"
    "$glarepp" -k "$here/kernel.exr" --threshold-mode whole --knee 0.4 --auto-exposure --dither \
        --report "$into/r" --hdr "$into/h.####.exr" \
        --layer "$into/l.####.exr" --debug sensors="$into/s.####.exr" \
        -o "$into/p.####.png" "$@" "$here/in.####.exr" 2>err || return
    sed -i "s/\"times_ms\".*//; s/\"outputs\":[^]]*]//; s/\"gl\".*//
            s/\"engine_why\":\"[^\"]*\"//; s/\"input\":\"[^\"]*\"//
            s/\"command\":\"[^\"]*\"//" "$into/r"
}

# as_first DESCRIPTION COMMAND...: its folder `new` holds what `first` does
as_first()
{
    about=$1
    shift
    rm -rf new
    "$@" && diff -r first new >diff.log
    result $? "$about" || note "$(head -c 1000 diff.log err)"
}

# can GL: whether a context opens
can()
{
    "$glarepp" -q --engine splat --projection plane --gl "$1" --layer can.exr in.0001.exr 2>/dev/null
}

# -- threads and frames in flight ------------------------------------------------------

# ten NAME ARGUMENT...: the defaults, which are two threads on two processors, and
# numbers of threads and of frames in flight; with GLAREPP_TEST_LONG a second run
# and each with each, ten runs in all. (What changes from run to run differs from
# the first in each of these; a quick run has the second run alone.)
ten()
{
    name=$1
    shift
    rm -rf first
    make_all first --threads 1 --frame-jobs 1 "$@"
    [ -z "$quick${GLAREPP_TEST_LONG-}" ] ||
        as_first "$name: a second run" make_all new --threads 1 --frame-jobs 1 "$@"
    [ -z "$quick" ] || return
    as_first "$name: defaults" make_all new "$@"
    for n in 1 2 3 8; do
        for jobs in 1 3; do
            case $n,$jobs,${GLAREPP_TEST_LONG:+long} in
            1,1,* | [12],3, | ?,1,) continue ;;
            esac
            as_first "$name: $n threads, $jobs in flight" \
                make_all new --threads $n --frame-jobs $jobs "$@"
        done
    done
}

lights="--sun 70,35,9 --sun-color 4e3,3e3,2e3 --lights $here/lamps.json \
    --flare $here/flare.json --mask A"
ten direct --engine direct
ten fft --engine fft
ten auto --engine auto $lights
ten 'ghosts of a lens' --engine fft $lights --lens double-gauss --fov 30
ten 'ghosts of sources' --engine direct --lens tessar --fov 30
for gl in osmesa egl; do
    if ! can $gl; then
        skip 1 "no context by $gl"
        continue
    fi
    ten "splat, $gl" --engine splat --projection plane --gl $gl
    ten "sun masks, $gl" --engine fft --sun-method mask --gl $gl $lights
done

# -- OSMesa and EGL --------------------------------------------------------------------

if can osmesa && can egl &&
    "$glarepp" -v --engine splat --projection plane --gl egl --layer can.exr in.0001.exr 2>&1 |
    grep -q llvmpipe; then
    for row in '--engine splat --projection plane' '--engine splat --group 1' \
        "--engine fft --sun-method mask $lights" \
        "--engine fft --sun-method mask --sun-sum 8bit --sun-pattern square $lights" \
        "--engine fft --sun-method readback $lights" \
        "--engine splat --projection plane --sun-method mask $lights"; do
        rm -rf first
        make_all first --no-provenance --gl osmesa $row
        as_first "EGL as OSMesa: ${row%% --sun 70*}" make_all new \
            --no-provenance --gl egl $row
    done
else
    skip 7 'no EGL on llvmpipe beside OSMesa'
fi

# -- environments ----------------------------------------------------------------------

everything="--engine auto $lights"
! can auto || everything="--engine splat --projection plane --sun-method mask $lights"
rm -rf first
make_all first $everything
# (a comma for the decimal point, where the system can make such a locale)
localedef -i de_DE -f UTF-8 ./de_DE.UTF-8 2>/dev/null && export LOCPATH="$here"
big=$(head -c 100000 /dev/zero | tr '\0' x)
# (those of a line in one run: a difference of any of them shows)
while read -r settings; do
    as_first "with $(echo "$settings" | sed "s|$here|.|g" | head -c 70)" \
        eval '(export $settings && make_all new $everything)'
done <<END
LC_ALL=de_DE.UTF-8
LC_NUMERIC=de_DE.UTF-8 HOME=
HOME=$here/lamps.json/no XDG_CACHE_HOME=$here/lamps.json/no
LC_ALL=C TZ=Asia/Kathmandu COLUMNS=13 MALLOC_PERTURB_=165 LONG=$big
END
as_first 'with umask 077' eval '(umask 077 && make_all new $everything)'
mkdir other
as_first 'in another folder' eval '(cd other && make_all "$here/new" $everything)'
cat >fixed <<'END_OF_SCRIPT'
#!/bin/sh
exec setarch -R "$REAL" "$@"
END_OF_SCRIPT
chmod +x fixed
if setarch -R true 2>/dev/null; then
    as_first 'without random addresses' eval \
        '(export REAL="$glarepp" && glarepp=$here/fixed && make_all new $everything)'
else
    skip 1 'setarch -R is not allowed here'
fi

# -- another copy of the program -----------------------------------------------------------

mkdir "$here/a copy"
cp "$glarepp" "$here/a copy/"
for bridge in "${glarepp%/*}"/*.so "${glarepp%/*}"/glarepp-oiio; do
    [ ! -f "$bridge" ] || cp "$bridge" "$here/a copy/"
done
as_first 'the program in another folder' eval \
    '(glarepp="$here/a copy/${glarepp##*/}" && make_all new $everything)'
"$glarepp" -q -o here.tif in.0001.exr 2>err
"$here/a copy/${glarepp##*/}" -q -o copy.tif in.0001.exr 2>>err
same here.tif copy.tif 'and its bridges'

# Objects hold no folder of the build
source_of()
{
    mkdir -p "$1/src" && cp "$root/Makefile" "$1" && cp -r "$root/src/core" "$1/src" &&
        (cd "$1" && make -s B="$2" "$2/core/memory.o" "$2/core/parallel.o") >make.log 2>&1
}
if command -v make >/dev/null && command -v cc >/dev/null; then
    ok 'objects in one folder' source_of one build
    ok 'objects in another' source_of "two/deeper" other-build
    for o in memory parallel; do
        same one/build/core/$o.o two/deeper/other-build/core/$o.o \
            "core/$o.o: the same bytes from both folders"
    done
else
    skip 4 'no compiler'
fi

done_testing
