#!/bin/sh
# Frames lit by lamps of their scene: beside lamps that a renderer lit, and what
# is missing.
. "$(dirname "$0")/lib.sh"
need_python

street=$root/examples/street.glb
frame in.exr channels=R,G,B,Z:float kind=dark size=64x36
frame n.exr channels=R,G,B,Z:float,N.X,N.Y,N.Z kind=dark size=64x36
frame flat.exr channels=R,G,B kind=dark size=64x36

run --relight lamp1 -o o.png in.exr
like "$(cat err)" '*--relight: does nothing without --scene*' \
    '--relight without a scene does nothing'
run --scene $street --relight lamp9 -o o.png in.exr
fails_with 2 'no light of that name (found "lamp9"' 'a lamp that is not there'
run --scene $street --relight all -o o.png flat.exr
fails_with 2 'needs depth' 'a frame without depth'
run --scene $street --relight all -o o.png in.exr
fails_with 2 'needs normals' 'a frame without normals'
run --scene $street --relight all -o o.png n.exr
fails_with 2 'needs albedo' 'a frame without albedo'
run --scene $street --relight all --depth-type ray -o o.png n.exr
fails_with 2 'give --depth-type z' 'distances from the eye'

# -- the street's lamps, each rendered by itself ---------------------------------

if [ -z "$data" ] || [ ! -f "$data/scenes/street.1001.exr" ]; then
    skip 3 "$no_data"
    done_testing
    exit
fi
beauty=$data/scenes/street.1001.exr
"$glarepp" --scene "$data/scenes/street.glb" --relight lamp2 -g 0 --type float \
    --hdr two.exr --threads 1 "$beauty" 2>err
result $? 'lamp2 lights the street'
"$glarepp" --scene "$data/scenes/street.glb" --relight lamp2 -g 0 --type float \
    --hdr again.exr --threads 2 "$beauty" 2>err
cmp two.exr again.exr
result $? 'the same bytes for any threads'
if [ -z "$oiio" ]; then
    skip 1 'no numpy or OpenImageIO'
    done_testing
    exit
fi
error=$("$python" - two.exr "$beauty" "$data/scenes/street_lamps.1001.exr" \
    <<'PYTHON'
import sys, numpy, OpenImageIO as oiio
def read(path):
    b = oiio.ImageBuf(path)
    a = b.get_pixels(oiio.FLOAT).astype(float)
    return {c: a[:, :, i] for i, c in enumerate(b.spec().channelnames)}
lit, before, lamps = map(read, sys.argv[1:])
on = sum(before["albedo." + c] for c in "RGB") > 0
wrong = light = 0.0
for c in "RGB":
    own = lamps["lamp2." + c]
    wrong += ((lit[c] - before[c] - own)[on] ** 2).sum()
    light += (own[on] ** 2).sum()
print((wrong / light) ** 0.5)
PYTHON
)
result "$(awk "BEGIN { exit !($error <= 0.05) }"; echo $?)" \
    "lamp2 is within 0.05 of its own light (rel_l2 $error)"
done_testing
