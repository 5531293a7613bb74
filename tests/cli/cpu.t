#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The same bytes on any processor: layers, --hdr and PNG pictures of this one, and of
# those that qemu-user emulates. GLAREPP_CPU names these; by default one without AVX
# and one with AVX2 and fused multiply-add. (aarch64: see make arm64-bytes)
. "$(dirname "$0")/lib.sh"
need_python
command -v qemu-x86_64 >/dev/null || skip_all 'no qemu-x86_64'
[ "$(uname -m)" = x86_64 ] || skip_all 'not an x86-64'
! sanitized || skip_all 'a sanitizer does not run in qemu-user'

frame in.exr size=48x36 seed=3 channels=R,G,B,A,Z:float hot=60000
frame wide.exr size=300x120 seed=5 hot=60000
frame hot.exr size=64x40 kind=dark dim=1e-3 hot=1e9 type=float
frame scene.exr size=96x54 kind=dark channels=R,G,B,Z:float
"$glarepp" -q --no-provenance -o in.png in.exr || exit 1
ln -s "$root/examples/alley.glb" .

# name, engine and arguments
cat >rows <<'END'
curves direct -k eye -k star:strands=8 -k gaussian -k moffat -k halation ../../in.exr
rings direct -k builtin:ring -k circle -k streak -k cross ../../in.exr
eyes direct -k spencer:needles=30 -k cie:equation=general --rotate 15 ../../in.exr
iris fft -k aperture:wavelengths=2,reach=1,coma=0.3,grating=0.5,lashes=0.5 ../../in.exr
pupil direct -k temporal:wavelengths=2,reach=1 ../../in.exr
far fft -k eye ../../wide.exr
tight fft --tolerance-pixel 1e-6 ../../wide.exr
lights fft --sun 20,12,4 --sun-color 1e4 --flare preset:zoom --lens heliar --fov 40 ../../in.exr
scene auto --scene ../../alley.glb --light-scale 1e-3 ../../scene.exr
exposed auto -t 3ev --auto-exposure --tonemap agx -o p.png ../../wide.exr
double fft -k ring --max-value 1e9 ../../hot.exr
codes fft --style mist --depth-bits 16 --tonemap aces -o p.png ../../in.png
END

# make_all FOLDER THREADS COMMAND...: every row's outputs, in a folder of each
make_all()
{
    into=$1 threads=$2
    shift 2
    while read -r name engine words; do
        mkdir -p "$into/$name"
        (cd "$into/$name" && "$@" -q -e "$engine" --threads "$threads" --type float \
            --no-provenance --layer l.exr --hdr h.exr $words 2>>"$tmp/err")
    done <rows
}

make_all here 1 "$glarepp"
is "$(cat err)" '' 'this processor'
threads=3
cpus=Conroe
[ -n "$quick" ] || cpus="Conroe Haswell"
for cpu in ${GLAREPP_CPU-$cpus}; do
    case $cpu in
    aarch64) set -- qemu-aarch64 -L "$GLAREPP_ARM64/root" "$GLAREPP_ARM64/glarepp" ;;
    *) set -- qemu-x86_64 -cpu "$cpu" "$glarepp" ;;
    esac
    make_all "$cpu" $threads "$@"
    while read -r name engine words; do
        [ -s "here/$name/h.exr" ] && diff -r "here/$name" "$cpu/$name" >diff.log 2>&1
        result $? "$cpu, $threads threads: $name" || note "$(head -c 500 diff.log err)"
    done <rows
    threads=8
done

done_testing
