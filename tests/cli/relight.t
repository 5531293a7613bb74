#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Frames lit by lamps of their scene: beside lamps that a renderer lit, and what
# is missing.
. "$(dirname "$0")/lib.sh"
need_python

street=$root/examples/alley.glb
frame in.exr channels=R,G,B,Z:float kind=dark size=64x36
frame n.exr channels=R,G,B,Z:float,N.X,N.Y,N.Z kind=dark size=64x36
frame flat.exr channels=R,G,B kind=dark size=64x36

run --relight lamp1 -o o.png in.exr
fails_with 2 'relight: needs --scene' '--relight without a scene'
run --normal-space camera -o o.png in.exr
fails_with 2 'normal-space: needs --relight' '--normal-space without --relight'
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

# -- the report ----------------------------------------------------------------

frame lit.exr channels=R,G,B,Z:float,N.X,N.Y,N.Z,albedo.R,albedo.G,albedo.B \
    kind=dark size=64x36
frame still.exr channels=R,G,B,Z:float kind=dark size=64x36
up="--scene-up y --sun-share depth" # depth and normals of lit.exr are of no surface
run --scene $street $up --relight lamp6 --relight lamp1 --report r.json \
    -o o.png lit.exr
status_is 0 'two lamps, of which one lights nothing'
is "$(field r.json '[(l["name"], l["pixels"] > 0, l["rays"] > l["pixels"] > 0, l["casters"] > 0) for l in o["relit"]]')" \
    "[('lamp1', True, True, True), ('lamp6', False, False, True)]" \
    'the report counts pixels, rays and casters of each lamp'
is "$(field r.json '[k for k in o["times_ms"] if k in ("scene", "relight", "sun")]')" \
    "['scene', 'relight', 'sun']" 'scene and lamps have their own times'
is "$(field r.json 'o["cpu_ms"]["relight"] > o["cpu_ms"]["sun"]')" True \
    'the time of lamps is not that of suns'
like "$(cat err)" '*lit.exr: *lamp6 lights no pixel*; leave it out*' \
    'a lamp that lights nothing is a warning'
no 'a lamp that lights is none' grep -q 'lamp1 lights no' err
is "$(field r.json 'len(o["warnings"])')" 1 'the report has the warning'
run --scene $street $up --relight all --report r.json -o o.png lit.exr
is "$(field r.json 'len(o["relit"]), o["warnings"]')" '(8, [])' \
    'all lamps: no warning, as one of them lights'

# only the frame has surfaces
"$python" - $street bare.glb <<'PYTHON'
import json, struct, sys
data = open(sys.argv[1], "rb").read()
n = struct.unpack("<I", data[12:16])[0]
scene = json.loads(data[20:20 + n])
for node in scene["nodes"]:
    node.pop("mesh", None)
text = json.dumps(scene).encode()
text += b" " * (-len(text) % 4)
rest = data[20 + n:]
open(sys.argv[2], "wb").write(
    struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest)) +
    struct.pack("<II", len(text), 0x4e4f534a) + text + rest)
PYTHON
run --scene bare.glb $up --relight lamp1 --report r.json -o o.png lit.exr
is "$(field r.json '[(l["name"], l["pixels"] > 1000, l["casters"]) for l in o["relit"]], o["warnings"]')" \
    "([('lamp1', True, 0)], [])" 'a scene without meshes lights the frame'
run --scene $street --report r.json -o o.png still.exr
is "$(field r.json '"relit" in o, "relight" in o["times_ms"], "scene" in o["times_ms"]')" \
    '(False, False, True)' 'without --relight there is only the scene'

# -- the axis of normals that points up ------------------------------------------

# a frame without a camera: only its normals say which axis its world has up
cat >lamp.gltf <<'JSON'
{"asset": {"version": "2.0"}, "cameras": [{"type": "perspective",
 "perspective": {"yfov": 1.5707963267948966, "znear": 1}}],
 "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point",
 "intensity": 1000}]}}, "nodes": [{"camera": 0}, {"name": "lamp",
 "translation": [0.5, 1, -2], "extensions": {"KHR_lights_punctual":
 {"light": 0}}}]}
JSON
for axis in x y z; do
    frame $axis.exr size=60x60 kind=ground-$axis \
        channels=R,G,B,Z:float,N.X,N.Y,N.Z,albedo.R,albedo.G,albedo.B
done
ground()
{
    name=$1
    shift
    run --scene lamp.gltf --relight lamp -g 0 --no-provenance --depth-bits 16 \
        -o $name.png "$@"
}
ground wanted --scene-up y y.exr
ground unlit --scene-up y z.exr
no 'normals of another world are dark' cmp -s wanted.png unlit.png
for axis in y z; do
    ground $axis $axis.exr
    quiet_success "normals $axis up: not a word"
    same $axis.png wanted.png "normals $axis up are found"
done
ground x x.exr
like "$(cat err)" '*x.exr: has no camera, and its normals fit *y up is taken*scene-up*' \
    'normals that fit neither are a warning'
ground x --scene-up y x.exr
quiet_success 'which --scene-up ends'

# -- layers and parts ------------------------------------------------------------

as_png()
{
    name=$1
    shift
    run --scene $street -g 0 --no-provenance --depth-bits 16 -o $name.png "$@"
}

# integers are other normals and albedo than numbers with fractions
b=b.R,b.G,b.B,b.N.X,b.N.Y,b.N.Z,b.albedo.R,b.albedo.G,b.albedo.B
frame own.exr channels=Z:float,$b size=64x36
frame two.exr channels=Z:float,a.N.X:uint,a.N.Y:uint,a.N.Z:uint,$b,\
a.albedo.R:uint,a.albedo.G:uint,a.albedo.B:uint,c.R,c.G,c.B size=64x36
for layers in own two; do
    as_png $layers --layer-in b --relight lamp1 $layers.exr
    status_is 0 "layer b of $layers.exr"
    no 'which has its own normals and albedo: no warning' grep -q layer err
done
cmp own.png two.png
result $? 'normals and albedo are those of the layer of the colour'
as_png dark --layer-in b own.exr
no 'and they are lit' cmp -s own.png dark.png
as_png c --layer-in c --relight lamp1 two.exr
like "$(cat err)" \
    '*two layers could be normals: using a.N, not b.N;*two layers*a.albedo*' \
    'neither layer is that of the colour: a warning'
frame a.exr channels=Z:float,a.N.X,a.N.Y,a.N.Z,c.R,c.G,c.B,\
a.albedo.R,a.albedo.G,a.albedo.B size=64x36
as_png c --layer-in c --relight lamp1 a.exr
like "$(cat err)" '*the layer of c.? has no normals: using a.N of another*' \
    'only another layer has normals: a warning'
frame mixed.exr channels=R,G,B,Z:float,N.X,N.Y,N.Z,a.albedo.R,b.albedo.G,\
b.albedo.B kind=dark size=64x36
run --scene $street --relight lamp1 -o o.png mixed.exr
fails_with 2 'needs albedo' 'the three channels are those of one layer'

frame parts.exr channels=R,G,B part=depth:Z:float part=N:N.X,N.Y,N.Z:half \
    part=albedo:albedo.R,albedo.G,albedo.B:half kind=dark size=64x36
frame plain.exr channels=R,G,B part=depth:Z:float part=albedo:R,G,B:half \
    part=view.Normal:X,Y,Z:half kind=dark size=64x36
for parts in lit parts plain; do
    as_png $parts --relight lamp1 $parts.exr
    status_is 0 "normals and albedo of $parts.exr"
done
cmp lit.png parts.png
result $? 'parts of their own are as channels of one part'
as_png dark plain.exr
no 'and so are parts whose name is that of the layer' cmp -s plain.png dark.png

# -- the street's lamps, each rendered by itself ---------------------------------

# lamp3 lights thin things, of whose pixels the renderer took 24 places: the noise
# of that is more than 0.05 in two frames
cat >rows <<'ROWS'
lamp2 1001 0.05
lamp3 1001 0.07
lamp3 1002 0.06
lamp3 1003 0.05
ROWS
[ -n "$quick" ] || cat >>rows <<'ROWS'
lamp1 1001 0.05
lamp1 1002 0.05
lamp1 1003 0.05
lamp1 1004 0.05
lamp2 1002 0.05
lamp2 1003 0.05
lamp2 1004 0.05
ROWS
if [ -z "$data" ] || [ ! -f "$data/scenes/street.1001.exr" ]; then
    skip $(($(wc -l <rows) + 3)) "$no_data"
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
    skip $(($(wc -l <rows) + 1)) 'no numpy or OpenImageIO'
    done_testing
    exit
fi
cat >error.py <<'PYTHON'
import functools, sys, numpy, OpenImageIO as oiio
@functools.lru_cache(maxsize=None)
def read(path):
    b = oiio.ImageBuf(path)
    a = b.get_pixels(oiio.FLOAT).astype(float)
    return {c: a[:, :, i] for i, c in enumerate(b.spec().channelnames)}
for row in open("rows"):
    lamp, frame, bar = row.split()
    lit = read("lit.%s.%s.exr" % (lamp, frame))
    before = read("%s/scenes/street.%s.exr" % (sys.argv[1], frame))
    lamps = read("%s/scenes/street_lamps.%s.exr" % (sys.argv[1], frame))
    on = sum(before["albedo." + c] for c in "RGB") > 0
    wrong = light = 0.0
    for c in "RGB":
        own = lamps[lamp + "." + c]
        wrong += ((lit[c] - before[c] - own)[on] ** 2).sum()
        light += (own[on] ** 2).sum()
    error = (wrong / light) ** 0.5
    print("%sok frame %s: %s is within %s of its own light (rel_l2 %.4g)" %
          ("" if error <= float(bar) else "not ", frame, lamp, bar, error))
PYTHON
while read -r lamp frame bar <&3; do
    "$glarepp" --scene "$data/scenes/street.glb" --relight $lamp -g 0 \
        --type float --compression none --hdr lit.$lamp.$frame.exr \
        "$data/scenes/street.$frame.exr" 2>err
done 3<rows
"$python" error.py "$data" >verdicts 2>&1
is $? 0 'the lamps of every row'
verdicts verdicts
done_testing
