#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: seeds.sh GLAREPP FOLDER
# Makes the first inputs of each target, FOLDER/NAME/*: small frames that
# the program wrote, and texts that its readers know. Ten of those that fuzzers
# grew from them are in tests/fuzz/corpus (tests/fuzz/grow.sh).
set -eu
cd "$(dirname "$0")/../.."
case $1 in /*) glarepp=$1 ;; *) glarepp=$PWD/$1 ;; esac
exr=$PWD/tests/cli/exr.py gltf=$PWD/tests/fuzz/seeds_gltf.py
mkdir -p "$2"
cd "$2"
mkdir -p frame members raw options frames json gltf other scratch
/usr/bin/python3 "$gltf" gltf

# frame NAME [key=value...]: what exr.py makes, written again by the program
frame()
{
    name=$1 compression=$2 type=$3
    shift 3
    /usr/bin/python3 "$exr" scratch/in.exr "$@"
    "$glarepp" -q --engine direct -k scratch/kernel.exr --type "$type" \
        --compression "$compression" --hdr "frame/$name.exr" scratch/in.exr
}

/usr/bin/python3 "$exr" scratch/kernel.exr kind=kernel size=5x5 type=float
for c in none rle zips zip piz pxr24 b44 b44a; do
    frame "$c" $c half size=19x35 lights=3
    frame "$c-float" $c float size=5x3 lights=1 channels=R,G,B,A,Z:float,id:uint
done
frame pixel none float size=1x1 hot=9
frame grey zip half size=7x5 channels=Y
frame far zip half size=6x6 origin=-40,70 display=0,0,9,9
frame layers zip half size=6x4 channels=beauty.R,beauty.G,beauty.B,depth.Z
frame part zips float size=5x4 part=depth:Z:float part=more:mask:half
frame attributes none half size=2x2 attr=note:string:text attr=fps:float:24 \
    attr=worldToNDC:m44f:1,0,0,0,0,1,0,0,0,0,1,1,0,0,0,0

cp frame/*.exr raw
cp scratch/kernel.exr frame

for f in png pfm; do
    "$glarepp" -q --engine direct -k scratch/kernel.exr -o scratch/a.$f \
        frame/pixel.exr 2>/dev/null || continue
    cat frame/pixel.exr scratch/a.$f frame/grey.exr >members/mixed.$f
    cat scratch/a.$f scratch/a.$f >members/two.$f
done
cat frame/grey.exr frame/far.exr frame/zips.exr >members/three

# formats that the helper reads: written by it, and forms that it does not write
/usr/bin/python3 "$exr" scratch/small.exr size=7x5 lights=3 hot=9
write_other()
{
    "$glarepp" -q --engine direct -k scratch/kernel.exr "$@" scratch/small.exr
}
for ending in bmp dpx jpg ppm sgi tga webp; do
    write_other -o scratch/a.$ending
    cp scratch/a.$ending other/$ending
done
write_other --layer scratch/a.hdr --layer scratch/a.tif
cp scratch/a.hdr other/hdr
cp scratch/a.tif other/tiff-float
for packing in none rle zip; do
    write_other --compression $packing -o scratch/a.tif
    cp scratch/a.tif other/tiff-$packing
done
printf 'P1\n# by hand\n4 3\n1 0 1 0\n0 1 1 0\n1 1 1 0\n' \
    >other/pbm-text
printf 'P2\n7 2 9\n1 2 3 4 5 6 7\n9 8 7 6 5 4 3\n' >other/pgm-text
printf 'P5 3 2 65535\n\1\2\3\4\5\6\7\10\11\12\13\14' >other/pgm-16
# Targa: runs of colour; a palette of two and runs of its codes
printf '\0\0\12\0\0\0\0\0\0\0\0\0\7\0\2\0\30\0\206\1\2\3\3\1\1\1\2\2\2\3\3\3\4\4\4\202\7\7\7' \
    >other/tga-runs
printf '\0\1\11\0\0\2\0\30\0\0\0\0\4\0\2\0\10\0\0\0\0\377\377\377\203\1\3\0\1\0\1' \
    >other/tga-palette

# every option once, with a value of each shape
"$glarepp" --help | sed -n 's/^.*--\([a-z][-a-z]*\).*$/\1/p' | sort -u |
    while read -r option; do
        for value in 1 0,1,2 0.5 a=b.exr name; do
            printf -- '--%s\n%s\n-o\nout.png\nin.exr' "$option" "$value" \
                >"options/$option-$(echo $value | tr -c 'a-z0-9\n' _)"
        done
    done
printf 'bench\nin.exr\n--runs\n3' >options/bench
printf 'compare\na.exr\nb.exr\n--fail\n0.1' >options/compare
printf 'help\nengines' >options/help
printf -- '-qt2\n-f1-9x2\n-o@.png\n--\n-\n@.exr' >options/letters

printf '1-100x7,5,-3--9\nshot.####.exr\na/@@@.png\nv%%04d.exr' >frames/list
printf '5-1\nrender@2x.####.png\n%%d\n%%%%d.exr' >frames/down

printf '{"lights":[{"pixel":[1,2],"radius":3,"flux":[1,2,3],"name":"a"},
{"world":[1,2,3],"depth":4,"bias":0.1},{"direction":[0,1,2],"degrees":1}]}' \
    >json/lights
printf '[{"shape":"ring","width":0.1,"position":2,"color":[1,2,3]},
{"shape":"polygon","sides":5,"rotation":9,"scale":[1,2,3]},
{"shape":"streak"},{"shape":"disc","size":1},{"shape":"image","image":"a"}]' \
    >json/flare
printf '{"width":8,"frames":[{"frame":1,"worldToNDC_rowmajor":
[1,0,0,0,0,1,0,0,0,0,1,1,0,0,0,0],"sun_dir_world":[0,0,1],"sun_radius_px":2},
{"frame":2,"worldToCamera_rowmajor":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],
"worldToNDC_blender_colvec":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,1,0]}]}' >json/camera
printf '{"name":"a","blades":6,"coating":"c","coatings":[{"name":"c","nm":[4e2,7e2],
"degrees":[0,60],"reflectance":[0.1,0.2,0,0.1]}],"surfaces":[{"radius":50,
"thickness":4,"n":1.5,"v":60,"semi":9},{"radius":-50,"thickness":3,"semi":9},
{"stop":true,"semi":5}]}' >json/lens
rm -r scratch
