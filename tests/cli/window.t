#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Data windows that are not the display window: outputs are made on the union,
# and are those of a frame that was as large before.
. "$(dirname "$0")/lib.sh"
need_python

channels=channels=R,G,B,A,Z:float,id:uint

# window FILE: the windows that its report's lines say
window()
{
    sed 's/.*"window":\(\[[^]]*\]\).*/\1/' "$1" | xargs
}

# a lamp whose crop ends 8 pixels beside it
lamp='size=17x17 origin=40,30 display=0,0,99,79 kind=zeros hot=1000'
frame lamp.exr $lamp $channels
frame padded.exr $lamp $channels pad=0,0,99,79
run --style eye --fov 3 --report r.json --layer l.exr --hdr h.exr -o o.png \
    lamp.exr
quiet_success 'a cropped lamp'
is "$(window r.json)" '[0,0,100,80]' 'glares over the display window'
like "$(cat r.json)" '*"window_read":\[40,30,57,47\]*' \
    'the report has the window that was read'
is "$(png_size o.png)" '100x80 8 2' 'PNG: the display window'
run --style eye --fov 3 --report c.json --grow none --layer cut.exr lamp.exr
is "$(window c.json)" '[40,30,57,47]' '--grow none: the data window'
"$python" - r.json c.json <<'PY'
import json, sys
whole, cut = (json.load(open(n))["flux_out"][1] for n in sys.argv[1:])
print(whole, cut)
sys.exit(not 1.05 * cut < whole < 1000)
PY
result $? 'the halo outside of the data window is there'

# luminance and chroma of 2x2 pixels grow as the RGB that they are
frame yc.exr size=40x24 origin=10,8 display=0,0,62,46 lights=30 \
    channels=BY:half,RY:half,Y:half
run --no-provenance -g 0 --grow none --type float --hdr rgb.exr yc.exr
for grow in none 0 5 kernel; do
    for name in yc rgb; do
        run --no-provenance -e direct -k builtin:star --grow $grow --type float \
            --hdr $name.h.exr --layer $name.l.exr -o $name.o.png $name.exr
        quiet_success "$name --grow $grow"
    done
    for kind in h.exr l.exr o.png; do
        same yc.$kind rgb.$kind "luminance and chroma, --grow $grow: $kind"
    done
done

# -- as if the frame had been as large before ------------------------------------

# alike DESCRIPTION OPTION...: what is made of in.exr and large.exr is the same;
# $grow: options of in.exr only
grow=
alike()
{
    about=$1
    shift
    for name in in large; do
        [ $name = in ] || grow=
        run --no-provenance $grow "$@" -o $name.o.png -o $name.o.exr \
            --layer $name.l.exr --hdr $name.h.exr $name.exr
        quiet_success "$about: $name"
    done
    differ=
    for end in o.png o.exr l.exr h.exr; do
        cmp -s in.$end large.$end || differ="$differ $end"
    done
    is "$differ" '' "$about: the same bytes"
}

# crops ORIGIN DISPLAY PAD: display and pad with both ends inside
crops()
{
    crop="size=40x24 origin=$1 display=$2 lights=30"
    frame in.exr $crop $channels
    frame large.exr $crop $channels "pad=$3"
}

crops 10,8 0,0,63,47 0,0,63,47
for engine in auto direct fft; do
    alike "$engine" -e $engine
done
alike splat -e splat --projection plane
alike 'splat without groups' -e splat --projection plane --group 1 --cluster 0 --shrink 0
alike '--mix scatter, a turned kernel' --mix scatter --rotate 30
alike '--auto-exposure' --auto-exposure
alike '--alpha keep' --alpha keep
alike 'none bright' -q -t 1e9
alike 'one thread' --threads 1
crops -1000,-77 -1010,-90,-950,-40 -1010,-90,-950,-40
alike 'negative windows'
crops 30,40 0,0,50,60 0,0,69,63
alike 'over a corner of the display window'
crops 0,0 50,10,80,20 0,0,80,23
alike 'beside the display window'
crops -5,-5 0,0,30,15 -5,-5,34,18
alike 'overscan stays'
crops 10,8 0,0,63,47 -7,-7,70,54
grow='--grow 7'
alike '--grow 7'
crops 10,8 0,0,63,47 -6,-6,69,53
frame k.exr size=13x13 kind=kernel channels=R,G,B:float
grow='--grow kernel'
alike '--grow kernel: as far as it reaches' -q -k k.exr
run --grow kernel --report r.json --layer l.exr in.exr
is "$(window r.json)" '[-255,-255,319,303]' '--grow kernel: of a builtin kernel'

# a threshold of the file's pixels does not depend on how many are added
for much in none 0 32 kernel; do
    run --grow $much -t 90% --report r.json --layer l.exr in.exr
    field r.json 'o["threshold"]'
done >thresholds
is "$(sort -u thresholds | wc -l) $(wc -l <thresholds)" '1 4' \
    '--threshold 90%: the same for any --grow'

# -- sequences, views, groups ----------------------------------------------------

mkdir s
n=1
for at in 0,0 20,3 -9,-30 61,40; do
    crop="size=24x16 origin=$at display=0,0,63,47 seed=$n"
    frame s/in.$n.exr $crop $channels
    n=$((n + 1))
done
run --no-provenance -f 1-4 --frame-jobs 3 --report r.json \
    --layer s/l.#.exr s/in.#.exr
quiet_success 'windows that move'
is "$(window r.json)" '[0,0,64,48] [0,0,64,48] [-9,-30,64,48] [0,0,85,56]' \
    'each frame has its own union'
differ=
for n in 1 2 3 4; do
    "$glarepp" --no-provenance --layer alone.exr s/in.$n.exr
    cmp -s alone.exr s/l.$n.exr || differ="$differ $n"
done
is "$differ" '' 'and the bytes that it has alone'

key=channels=R,G,B,Z:float,key.R,key.G,key.B
crop='size=40x24 origin=10,8 display=0,0,63,47'
frame in.exr $crop $key
frame large.exr $crop $key pad=0,0,63,47
alike 'light groups' --light-group key

# -- suns --------------------------------------------------------------------------

# outside of the data window nothing hides a sun, and it is drawn
crop='size=40x24 origin=10,8 display=0,0,63,47 lights=0 dim=0.1'
frame in.exr $crop $channels
frame large.exr $crop $channels pad=0,0,63,47
alike 'a sun outside of the data window' --sun 56,40,2 --sun-color 500 \
    --sun-method exact
run --report r.json --sun 56,40,2 --sun-color 500 --sun-method exact \
    --mask A --layer l.exr in.exr
like "$(cat r.json)" '*"visibility":1.0*' 'shines whole'
"$python" - r.json <<'PY'
import json, sys
o = json.load(open(sys.argv[1]))
sys.exit(not 300 < o["flux_out"][1] < 500)
PY
result $? 'and is drawn'
run --report r.json --sun 30,11,2 --sun-color 500 --sun-method exact \
    --layer l.exr in.exr
like "$(cat r.json)" '*"visibility":1.0*' 'before empty depth'
run --report r.json --sun 30,28,2 --sun-color 500 --sun-method exact \
    --layer l.exr in.exr
like "$(cat r.json)" '*"visibility":0.0*' 'depth hides it inside'

# -- frames of the field -------------------------------------------------------------

if [ -z "$data" ]; then
    skip 10 "$no_data"
else
    for row in 'oversizeDataWindow [-25,-25,281,281]' 't01 [0,0,400,300]' \
        't03 [0,0,400,300]' 't05 [0,0,400,300]' 't08 [0,0,501,401]' \
        't09 [0,0,600,300]' 't13 [0,0,500,400]' 't15 [-40,-40,441,331]'; do
        name=${row% *}
        run -t 0.5 --report r.json --hdr h.exr "$data/windows_dw/$name.exr"
        is "$status $(window r.json)" "0 ${row#* }" "$name"
    done
    run --report r.json --hdr h.exr --views left,right \
        "$data/depth/Beachball_multipart.0001.exr"
    is "$status $(window r.json)" '0 [0,0,2048,1556] [0,0,2048,1556]' \
        'eyes in parts of different windows'
    run -q --grow none --report r.json --hdr h.exr --views left,right \
        "$data/depth/Beachball_multipart.0001.exr"
    is "$status $(window r.json)" \
        '0 [688,245,1565,1121] [654,245,1531,1121]' '--grow none: as they are'
fi

done_testing
