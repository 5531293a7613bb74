#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The same bytes for any number of threads, in every run and every locale.
. "$(dirname "$0")/lib.sh"
need_python

# a frame of odd size with overscan, alpha and one very hot pixel
frame odd.exr size=203x117 origin=-11,4 display=0,0,189,119 lights=300 \
    channels=R,G,B,A,Z:float hot=60000
frame kernel.exr kind=kernel size=97x64 type=float

gl=
"$glarepp" --engine splat --projection plane --layer gl.exr odd.exr 2>/dev/null && gl=yes

# make FOLDER INPUT ENGINE ARGUMENT...: every kind of output, and the report
# without what time and memory make of it
make_all()
{
    folder=$1 input=$2 engine=$3
    shift 3
    mkdir "$folder"
    "$glarepp" --engine "$engine" --report "$folder/r" --hdr "$folder/h.exr" \
        --layer "$folder/l.exr" --debug sensors="$folder/s.exr" \
        -o "$folder/p8.png" "$@" "$input" 2>err || return
    sed -i "s/\"times_ms\".*//; s/\"outputs\":[^]]*]//; s/\"gl\".*//
            s/\"engine_why\":\"[^\"]*\"//
            s/\"command\":\"[^\"]*\"//" "$folder/r"
}

# same_for INPUT ENGINE DESCRIPTION ARGUMENT...: one thread against 2, 4, 7
same_for()
{
    input=$1 engine=$2 about=$3
    shift 3
    rm -rf t.*
    make_all t.1 "$input" "$engine" --threads 1 "$@"
    for n in 2 4 7; do
        make_all t.$n "$input" "$engine" --threads $n "$@" &&
            diff -r t.1 t.$n >diff.log
        result $? "$about, $engine: $n threads as one" ||
            note "$(cat diff.log err)"
    done
}

engines='direct fft'
[ -z "$gl" ] || engines="$engines splat"
for engine in $engines; do
    plane=
    [ $engine != splat ] || plane='--projection plane'
    same_for odd.exr $engine 'a frame with overscan' $plane
    same_for odd.exr $engine 'float, dither and all' -k kernel.exr --type float \
        --compression zip --dither --auto-exposure --tonemap agx --threshold-mode whole --knee 0.5 \
        --mix scatter -g 0.5
done
for compression in rle piz pxr24 b44a dwaa; do
    same_for odd.exr fft "--compression $compression" --compression $compression
done
same_for odd.exr fft '16 bits' --depth-bits 16 --alpha keep

# rendered frames; the threshold leaves GL a few hundred sources
for name in tests/frames/night.1001 tests/frames/brightsky.1001 tests/frames/foliage.1004; do
    input=$root/$name.exr
    same_for "$input" fft "$name"
    same_for "$input" auto "$name, high threshold" -t 50
done
if [ -n "$gl" ] && [ -z "$quick" ]; then
    same_for "$root/tests/frames/night.1001.exr" splat night.1001 -t 300 -k kernel.exr
else
    skip 3 'no GL, or quick'
fi

# -- runs, places, environments ------------------------------------------------

rm -rf t.*
make_all t.1 odd.exr fft
make_all t.2 odd.exr fft
diff -r t.1 t.2 >diff.log
result $? 'two runs' || note "$(cat diff.log)"
sleep 1.1
make_all t.3 odd.exr fft
diff -r t.1 t.3 >diff.log
result $? 'a run a second later' || note "$(cat diff.log)"
for setting in LC_ALL=C LC_ALL=C.UTF-8 TZ=Asia/Tokyo OMP_NUM_THREADS=3 \
    OMP_SCHEDULE=dynamic OMP_DYNAMIC=true; do
    rm -rf t.9
    (export "$setting" && make_all t.9 odd.exr fft)
    diff -r t.1 t.9 >diff.log
    result $? "with $setting" || note "$(cat diff.log)"
done
mkdir other && cp odd.exr kernel.exr other
(cd other && make_all "$tmp/t.10" odd.exr fft)
diff -r t.1 t.10 >diff.log
result $? 'in another folder' || note "$(cat diff.log)"

# threads take little address space, which a queue may limit (sanitizers take
# more for themselves)
limit=300000
(ulimit -v $limit && "$glarepp" --version) >ok.log 2>&1 || limit=unlimited
frame wide.exr size=1200x700 lights=20
for n in 1 64; do
    (ulimit -v $limit && exec "$glarepp" -q --threads $n --no-provenance \
        -o wide.$n.png wide.exr) >out 2>err
    status=$?
    quiet_success "$n threads in $limit KiB"
done
ok '64 threads in little memory: the same as one' cmp wide.1.png wide.64.png

done_testing
