#!/bin/sh
# Usage: gallery.sh GLAREPP
# Makes man/gallery.md and man/pictures/ from the frames in examples/: every style,
# kernel, flare and lens on one frame, and the pictures of README and manual.
# `make gallery` calls it. Needs ImageMagick, to make them small.
set -eu
glarepp=$1
cd "$(dirname "$0")/.."
to=man/pictures page=man/gallery.md
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
mkdir -p $to
rm -f $to/*

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

# -- README and the chapters ----------------------------------------------------

shot street-before 480 --gain 0 examples/street.exr
shot street-after 480 examples/street.exr
shot hall-before 480 --gain 0 examples/hall.exr
shot hall-after 480 --style mist examples/hall.exr
shot lamp-before 480 --gain 0 examples/lamp.exr
shot lamp-after 480 --style vintage examples/lamp.exr
shot first 640 examples/street.exr
shot sun 640 --style star examples/leaves.1001.exr
"$glarepp" styles -q -o "$tmp/styles.png" examples/street.exr
convert "$tmp/styles.png" -resize 1200 -quality 82 -strip $to/styles.jpg
for frame in street hall leaves.1003; do
    for curve in neutral reinhard reinhard-extended aces hable agx; do
        shot curve.$frame.$curve 240 --tonemap $curve examples/$frame.exr
        convert $to/curve.$frame.$curve.jpg -gravity south -fill white \
            -undercolor '#0008' -pointsize 13 -annotate +0+4 " $curve " \
            $to/curve.$frame.$curve.jpg
    done
done
sheet curves 6x 240 $(cd $to && ls curve.*.jpg)
rm $to/curve.*

# -- the gallery ----------------------------------------------------------------

# entry OPTIONS: the frame with them, and its command
entry()
{
    name=$(echo "$1" | tr -c 'a-z0-9\n' - | sed 's/^-*//')
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
chapter Styles 'A style sets everything at once; any option beside it rules.' "$@"
set -- $("$glarepp" kernel --list | sed -n \
    -e '/^image:/d;s/^\([a-z]*\): .*/--kernel=\1/p' \
    -e '/^Presets/,$s/^  \([a-z][a-z-]*\) .*/--kernel=\1/p' |
    sed 's/=circle$/=circle:share=.02/' | sort -u)
chapter Kernels 'A kernel is the shape of the light around one bright pixel.' "$@"
frame=examples/leaves.1001.exr more='--sun=381.3,72.5,3.1 --sun-color=2e6,1.8e6,1.5e6'
set -- $("$glarepp" --flare preset:list | sed -n 's/^ *\([a-z]*\).*/--flare=preset:\1/p')
chapter Flares 'A flare draws the ghosts of a lens for each light.' "$@"
more='--sun=381.3,72.5,3.1 --sun-color=2e7,1.8e7,1.5e7'
set -- $("$glarepp" lens | sed -n 's/^\([a-z][a-z-]*\) .*/--lens=\1/p')
chapter Lenses 'A lens draws its own ghosts, traced through the glass of its patent.' "$@"

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
