#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: gallery.sh GLAREPP [NIGHT]
# Makes man/gallery.md and man/pictures/ from the frames in examples/: every style,
# kernel, flare and lens on one frame, and the pictures of README and manual.
# `make gallery` calls it. Needs ImageMagick, to make them small. NIGHT is a frame for the
# second plot of speed.md, which is left as it is without.
set -eu
glarepp=$1
cd "$(dirname "$0")/.."
to=man/pictures page=man/gallery.md
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
mkdir -p $to
rm -f $to/*.jpg

# shot NAME WIDTH ARGUMENT...: a picture WIDTH pixels wide
shot()
{
    name=$1 width=$2
    shift 2
    "$glarepp" -q "$@" -o "$tmp/$name.png"
    convert "$tmp/$name.png" -resize "$width" -quality 84 -strip "$to/$name.jpg"
}

# sheet NAME TILES WIDTH PICTURE...: made by shot, beside each other
sheet()
{
    name=$1 tiles=$2 width=$3
    shift 3
    (cd $to && montage "$@" -tile "$tiles" -geometry "${width}x+3+3" \
        -quality 84 -strip "$name.jpg")
}

# -- plots of bench, in minutes --------------------------------------------------

"$glarepp" bench -q --runs 5 --paper --plot $to/bench.svg
[ -z "${2-}" ] || "$glarepp" bench -q --runs 5 --plot $to/bench-night.svg "$2"

# -- README and the chapters ----------------------------------------------------

shot street-before 480 --gain 0 examples/street.exr
shot street-after 480 examples/street.exr
shot hall-before 480 --gain 0 examples/hall.exr
shot hall-after 480 --style mist examples/hall.exr
shot lamp-before 480 --gain 0 examples/lamp.exr
shot lamp-after 480 --style vintage examples/lamp.exr
shot first 640 examples/street.exr
shot sun 640 --sun 381.3,72.5,3.1 --sun-color 4e6,3e6,2e6 --sun-in-frame \
    --flare preset:zoom --exposure -1 examples/leaves.1001.exr
cat >"$tmp/lights.json" <<'END'
[{"name": "left", "pixel": [243, 346], "radius": 12, "depth": 8,
  "flux": [2e5, 1.8e5, 1.3e5]},
 {"name": "right", "pixel": [377, 346], "radius": 12, "depth": 8,
  "flux": [2e5, 1.8e5, 1.3e5]}]
END
shot headlights 640 --lights "$tmp/lights.json" --sun-in-frame --flare preset:zoom \
    examples/headlights.exr
# a lamp in the middle and one in the corner of a frame of 90 degrees
python3 -c '
import struct, sys
w, h = 640, 360
def value(x, y):
    lamp = any(abs(x - a) < 2 and abs(y - b) < 2 for a, b in ((320, 180), (604, 336)))
    return 3e4 if lamp else 0.02
sys.stdout.buffer.write(b"PF\n%d %d\n-1.0\n" % (w, h) + b"".join(
    struct.pack("<3f", *[value(x, h - 1 - y)] * 3) for y in range(h) for x in range(w)))
' >"$tmp/lamps.pfm"
for how in plane perspective; do
    shot angles-$how 480 --projection $how --fov 90 -k eye "$tmp/lamps.pfm"
done
sheet angles 2x1 480 angles-plane.jpg angles-perspective.jpg
rm $to/angles-*.jpg
"$glarepp" styles -q -o "$tmp/styles.png" examples/street.exr
convert "$tmp/styles.png" -resize 1200 -quality 82 -strip $to/styles.jpg
for frame in street hall leaves.1003 headlights lamp; do
    for curve in neutral agx aces hable reinhard reinhard-extended linear; do
        shot curve.$frame.$curve 200 --tonemap $curve examples/$frame.exr
        convert $to/curve.$frame.$curve.jpg -gravity south -fill white \
            -undercolor '#0008' -pointsize 13 -annotate +0+4 " $curve " \
            $to/curve.$frame.$curve.jpg
    done
done
sheet curves 7x 200 $(cd $to && ls curve.*.jpg)
rm $to/curve.*

for n in 1001 1002 1003 1004; do
    shot shot.$n 300 --style star --flare preset:anamorphic --sun 381.3,72.5,3.1 \
        --sun-in-frame --sun-color 3e6,2.4e6,1.8e6 --exposure -1 examples/leaves.$n.exr
done
sheet sequences 4x 300 shot.1001.jpg shot.1002.jpg shot.1003.jpg shot.1004.jpg
"$glarepp" -q --style eye-night --layer "$tmp/l.exr" --hdr "$tmp/h.exr" \
    examples/street.exr
shot shot.frame 400 --gain 0 "$tmp/h.exr"
shot shot.layer 400 --gain 0 "$tmp/l.exr"
shot shot.dark 400 --gain 0 --exposure -4 "$tmp/h.exr"
sheet files 3x 400 shot.frame.jpg shot.layer.jpg shot.dark.jpg
set -- --exposure 2 examples/alley.1003.exr
shot shot.1 480 --gain 0 "$@"
shot shot.2 480 --scene examples/alley.glb --light-scale 0.00146413 --sun-in-frame \
    --flare preset:zoom "$@"
sheet scenes 2x 480 shot.1.jpg shot.2.jpg
cat >"$tmp/lights.json" <<'END'
[{"pixel": [244, 346], "radius": 12, "depth": 8, "flux": [3e6, 2.7e6, 2.1e6]},
 {"pixel": [377, 347], "radius": 12, "depth": 8, "flux": [3e6, 2.7e6, 2.1e6]}]
END
set -- --lights "$tmp/lights.json" --sun-in-frame examples/headlights.exr
shot shot.3 480 --lens zoom-wide "$@"
shot shot.4 480 --lens zoom-wide --f-number 16 "$@"
shot shot.5 480 --lens double-gauss "$@"
shot shot.6 480 --lens tessar "$@"
sheet lenses 2x 480 shot.3.jpg shot.4.jpg shot.5.jpg shot.6.jpg
rm $to/shot.*

# -- the gallery ----------------------------------------------------------------

# entry OPTIONS: the frame with them, and its command
entry()
{
    name=$(echo "${1%% *}" | tr -c 'a-z0-9\n' - | sed 's/^-*//;s/-share.*//')
    # shellcheck disable=SC2086
    shot "$name" 400 $1 $more "$frame"
    printf '\n![%s](pictures/%s.jpg)\n\n    %s\n' "$name" "$name" \
        "glarepp $1${more:+ $more} -o out.png $frame" >>$page
}

# chapter TITLE TEXT OPTIONS...
chapter()
{
    printf '\n## %s\n\n%s\n' "$1" "$2" >>$page
    shift 2
    for options; do
        entry "$options"
    done
}

cat >$page <<'END'
# Gallery

Each picture has its command. `make gallery` makes them all again.
END
frame=examples/street.exr more=
set -- $("$glarepp" styles | sed 's/ .*//;s/^/--style=/')
chapter Styles '`glarepp styles -o sheet.html examples/street.exr` shows two at a time.' "$@"
set -- $("$glarepp" kernel --list | sed -n \
    -e '/^image:/d;s/^\([a-z]*\): .*/--kernel=\1/p' \
    -e '/^Presets/,$s/^  \([a-z][a-z-]*\) .*/--kernel=\1/p' |
    sed 's/=circle$/=circle:share=.02/' | sort -u)
chapter Kernels 'A kernel is the shape of the light around one bright pixel.' "$@"
frame=examples/leaves.1001.exr more='--sun=381.3,72.5,3.1 --sun-color=2e6,1.8e6,1.5e6'
set -- $("$glarepp" --flare preset:list | sed -n 's/^ *\([a-z]*\).*/--flare=preset:\1/p')
chapter Flares 'A flare draws the ghosts of a lens for each light.' "$@"
more=
# (coated glass hides its ghosts: each lens gets the sun that shows them)
sun='--sun=381.3,72.5,3.1 --sun-in-frame --sun-color='
set --
for lens in $("$glarepp" lens | sed -n 's/^\([a-z][a-z-]*\) .*/\1/p'); do
    case $lens in
    tessar) flux=1e7,9e6,7.7e6 ;;
    zoom-*) flux=5e7,4.5e7,3.8e7 ;;
    *) flux=4e8,3.6e8,3e8 ;;
    esac
    set -- "$@" "--lens=$lens --exposure=-2 $sun$flux"
done
chapter Lenses 'A lens draws its own ghosts, traced through the glass of its patent. Coats
hide them: each sun is as bright as it takes to see them.' "$@"

# -- pictures that need those before ----------------------------------------------

sheet kernels 3x 320 kernel-aperture.jpg kernel-streak.jpg kernel-cross.jpg \
    kernel-ring.jpg kernel-eye.jpg kernel-halation.jpg
"$glarepp" -q --gain 0 -o "$tmp/a.png" examples/street.exr
"$glarepp" -q --style eye -o "$tmp/b.png" examples/street.exr
"$glarepp" compare -q --heatmap "$tmp/c.png" --fail-flip 1 "$tmp/a.png" "$tmp/b.png"
convert "$tmp/c.png" -resize 640 -quality 84 -strip $to/compare.jpg
"$glarepp" -q --layer "$tmp/l.exr" examples/street.exr
shot speed 640 --gain 0 --exposure 4 "$tmp/l.exr"
du -sh $to
