#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Scenes: lights and cameras of a glTF file beside a frame's own.
. "$(dirname "$0")/lib.sh"
need_python

street=$root/examples/alley.glb

# lights EXPRESSION: of o["lights"] of r.json, L by name
lights()
{
    field r.json "(lambda L: $1)({l.get('name'): l for l in o['lights']})"
}

frame in.exr channels=R,G,B,Z:float kind=dark size=640x360
frame still.1001.exr channels=R,G,B,Z:float kind=dark size=640x360

# -- the scene's camera and lights ----------------------------------------------

run --scene $street --report r.json in.exr
status_is 0 'a scene beside a frame without a camera'
is "$(field r.json 'o["scene"]["camera"]')" cam "the scene's camera is named"
is "$(field r.json 'round(o["scene"]["seconds"], 4)')" 41.7083 \
    'a frame without a number is at the first key'
is "$(lights 'sorted(L)')" \
    "['lamp1', 'lamp2', 'lamp3', 'lamp4', 'lamp5', 'lamp6', 'lamp7', 'lamp8']" \
    'lights have the names of their nodes'
# of the scene's maker: lamp1 at (0.35, 15.5, 3), a ball of 0.12; the camera at
# (0.9, -2.2, 1.7)
is "$(lights '[round(L["lamp1"][k], 1) for k in ("x", "y", "radius")]')" \
    '[322.8, 149.9, 3.1]' 'a lamp is where the camera sees it, as large'
run --scene $street --report s.json still.1001.exr
is "$(field s.json 'o["scene"]["seconds"]')" 41.708333 \
    'a frame is at its number over 24'
run --scene $street --scene-start 1 --report s.json still.1001.exr
is "$(field s.json 'round(o["scene"]["seconds"], 4)')" 41.6667 \
    '--scene-start moves the scene'
run --scene $street --scene-start 990 --report s.json still.1001.exr
like "$(cat err)" '*its keys run from 41.7*give --scene-start*' \
    'a time beside all keys is said'
run --scene $street --scene-up z --report s.json in.exr
is "$(field s.json '[round(l["x"], 2) for l in o["lights"] if "x" in l]')" \
    "$(field r.json '[round(l["x"], 2) for l in o["lights"] if "x" in l]')" \
    'camera and lights turn together'
run --scene $street --sun-share depth --report s.json in.exr
like "$(field s.json 'o["sun_edges"]')" 'depth alone: *' \
    'lamps that the frame shows have edges by depth'
run -v --sun 5000,100,3 --report s.json in.exr
is "$(field s.json '"sun_edges" in o')" False \
    'a light off screen has none'
run -v --sun 300,100,3 --report s.json in.exr
like "$(cat err)" '*edges by depth alone*' '--verbose says so too'
frame a.exr channels=R,G,B,A,Z:float kind=dark size=640x360
run -v --mask A --sun 300,100,3 --report s.json a.exr
like "$(field s.json 'o["sun_edges"]'; cat err)" \
    'coverage: *edges by coverage' 'coverage beside depth is named'
frame mask.exr channels=R,G,B,A kind=dark size=640x360
run -v --mask A --sun 300,100,3 --report s.json mask.exr
like "$(field s.json 'o["sun_edges"]'; cat err)" \
    'coverage without depth: *edges by coverage without depth*' \
    'coverage without depth names no error'
is "$(field s.json '"0.02" in o["sun_edges"]')" False \
    'the error with depth is not that without'
run --scene $street --scene-camera top -o o.png in.exr
fails_with 2 'it has: cam; give one of them to --scene-camera' 'a camera that is not there'

# -- flux -------------------------------------------------------------------------

run --scene $street --light-scale 0.00146413 --report f.json --layer lit.exr \
    in.exr
is "$(field f.json 'o["flux_in"][0] > 1000')" True \
    '--light-scale gives lamps flux'
is "$(field r.json 'o["flux_in"]')" '[0.0, 0.0, 0.0]' 'without it they have none'

# one lamp of 100 cd, 10 before a camera of 90 degrees: 0.01 * 100 / 10^2 in every
# square of 1/50 (a pixel's side at distance 1), or sin(asin(0.05)) of a ball of 0.5
cat >lamp.gltf <<'JSON'
{"asset": {"version": "2.0"}, "cameras": [{"type": "perspective",
 "perspective": {"yfov": 1.5707963267948966, "znear": 1}}],
 "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point",
 "intensity": 100}]}}, "nodes": [{"camera": 0}, {"name": "lamp",
 "translation": [0, 0, -10], "extensions": {"KHR_lights_punctual":
 {"light": 0}}}]}
JSON
frame small.exr channels=R,G,B kind=dark size=100x100
run --scene lamp.gltf --flare "$root/examples/flares/vintage.json" --layer l.exr \
    small.exr
fails_with 2 --light-scale "a flare of a scene's lights that have no flux"
run --scene lamp.gltf --light-scale 0.01 --report r.json --layer l.exr small.exr
is "$(field r.json 'abs(o["flux_in"][1] - 25) < 0.01')" True \
    'flux of a lamp without a size' || note "$(field r.json 'o["flux_in"]')"
is "$(lights '[L["lamp"][k] for k in ("x", "y", "radius")]')" '[50.0, 50.0, 0.5]' \
    'a lamp without a size is half a pixel'
run --scene lamp.gltf --light-scale 0.01 --lamp-size 0.5 --report r.json \
    --layer l.exr small.exr
is "$(field r.json 'abs(o["flux_in"][1] - 25.06) < 0.01')" True \
    'flux of a ball' || note "$(field r.json 'o["flux_in"]')"
is "$(lights 'round(L["lamp"]["radius"], 2)')" 2.5 '--lamp-size'
run --scene lamp.gltf --light-scale 0.01 --sun-in-frame --report r.json \
    --layer l.exr small.exr
is "$(field r.json 'o["flux_in"][1]')" 0.0 'lamps that the frame shows already'
# sun LIGHT NODE [OPTION...]: with these extras, and its size of the report
sun()
{
    sed "s/\"point\",/\"directional\", \"extras\": {$1},/
        s/\"name\": \"lamp\",/\"extras\": {$2},/" lamp.gltf >sun.gltf
    shift 2
    run "$@" --scene sun.gltf --report r.json small.exr
    field r.json '"%s %.3f" % (lambda l: (l["sun_from"], l["sun_degrees"]))(o["lights"][0])'
}

is "$(sun '' '')" 'default 0.533' "a sun's usual size"
is "$(sun '"angle_deg": 2' '')" 'scene 2.000' "a sun's size, of the light"
is "$(sun '"angle_deg": 2' '"angle": 0.01')" 'scene 0.573' "but its node's wins"
is "$(sun '"angle_deg": 2' '' --sun-size 3)" 'option 3.000' 'and an option'
"$python" - sun.gltf <<'PY'
import json, sys
s = json.load(open(sys.argv[1]))
at = "KHR_lights_punctual"
s["extensions"][at]["lights"].append({"type": "directional"})
s["nodes"].append({"name": "other", "extensions": {at: {"light": 1}}})
json.dump(s, open(sys.argv[1], "w"))
PY
run --scene sun.gltf --sun 9,9,3 --report r.json small.exr
is "$(field r.json '[(l.get("sun_from"), l.get("sun_degrees")) for l in o["lights"]]')" \
    "[(None, None), ('scene', 2.0), ('default', 0.533)]" 'each sun has its own'
run --lamp-size 1 -o o.png small.exr
fails_with 2 'lamp-size: needs --scene' 'an option of scenes without one'

# -- a frame's own camera -----------------------------------------------------------

# the lamp's camera, moved by 0.01 at a distance of 1: half a pixel
for x in 0 0.1; do
    frame own$x.exr channels=R,G,B kind=dark size=100x100 \
        attr=worldToNDC:m44f:0.5,0,0,0,0,-0.5,0,0,-0.5,-0.5,-1,-1,$x,0,-1,0
done
run --scene lamp.gltf --report r.json -o o.png own0.exr
is "$(field r.json 'o["scene"]["camera_apart"] < 1e-4')" True \
    "the frame's own camera is compared" || note "$(field r.json 'o["scene"]')"
is "$(grep -c apart err)" 0 'two that agree are not said'
run --scene lamp.gltf --report r.json -o o.png own0.1.exr
like "$(cat err)" '*pixels apart; the frame*' 'over half a pixel is said'
is "$(lights 'round(L["lamp"]["x"], 2)')" 51.0 "the frame's camera counts"

# -- cut-outs -----------------------------------------------------------------------

# of a cut-out of 4096 x 4096 texels, beside one of a texel: bytes a texel at the
# peak, where the least of memory that counts is that of the system
cat >leaf.py <<'PY'
import json, resource, struct, subprocess, sys, zlib

def png(name, side):
    def chunk(kind, data):
        crc = zlib.crc32(kind + data)
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", crc)
    head = struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)
    rows = zlib.compress((b"\0" + b"\1\2\3\x90" * side) * side, 1)
    with open(name + ".png", "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) +
                chunk(b"IDAT", rows) + chunk(b"IEND", b""))

def scene(name):
    at = [-9, -9, -5, 9, -9, -5, 0, 9, -5]
    uv = [0, 0, 1, 0, 0, 1]
    with open("leaf.bin", "wb") as f:
        f.write(struct.pack("<15f", *at, *uv))
    views = [{"buffer": 0, "byteLength": 36},
             {"buffer": 0, "byteOffset": 36, "byteLength": 24}]
    kinds = [{"bufferView": i, "componentType": 5126, "count": 3, "type": t}
             for i, t in enumerate(("VEC3", "VEC2"))]
    scene = {"asset": {"version": "2.0"},
        "cameras": [{"type": "perspective",
                     "perspective": {"yfov": 1.57, "znear": 0.1}}],
        "buffers": [{"uri": "leaf.bin", "byteLength": 60}],
        "bufferViews": views, "accessors": kinds,
        "images": [{"uri": name + ".png"}], "textures": [{"source": 0}],
        "materials": [{"alphaMode": "MASK", "pbrMetallicRoughness":
                       {"baseColorTexture": {"index": 0}}}],
        "meshes": [{"primitives": [{"material": 0, "attributes":
                    {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
        "nodes": [{"camera": 0}, {"mesh": 0}, {"translation": [0, 0, -10],
                   "extensions": {"KHR_lights_punctual": {"light": 0}}}]}
    with open(name + ".gltf", "w") as f:
        json.dump(scene, f)

def peak(name, *command):
    # of a process of its own: ru_maxrss is the largest of all children
    code = ("import resource, subprocess, sys\n"
            "subprocess.run(sys.argv[1:], check=True, "
            "stdout=subprocess.DEVNULL)\n"
            "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
    out = subprocess.run([sys.executable, "-c", code, *command],
                         stdout=subprocess.PIPE, check=True).stdout
    return 1024 * int(out)

for name, side in (("one", 1), ("all", 4096)):
    png(name, side)
    scene(name)
for what in (["--threads", "1", "--scene", "@", "--report", "-", "small.exr"],
             ["sets", "--threads", "1", "--size", "64x64", "@"]):
    took = [peak(n, sys.argv[1], *(n + ".gltf" if a == "@" else a for a in what))
            for n in ("one", "all")]
    print("%.1f" % ((took[1] - took[0]) / 4096 ** 2))
PY
"$python" leaf.py "$glarepp" >peaks 2>err
set -- $(cat peaks)
is "$(echo "$1" | awk '{ print ($1 > 0 && $1 <= 28) }')" 1 \
    'a cut-out takes at most 28 bytes a texel, which are read' || note "$(cat peaks err)"
is "$(echo "$2" | awk '{ print ($1 > 0 && $1 <= 28) }')" 1 \
    'and so it does in sets' || note "$(cat peaks err)"

# -- what is wrong ----------------------------------------------------------------

printf 'glTF\002\0\0\0\377\377\0\0' >bad.glb
cp bad.glb bad.png
run --scene bad.glb -o o.png in.exr
fails_with 4 'truncated' 'a scene that is cut off'
run --scene none.glb -o o.png in.exr
fails_with 3 'none.glb' 'a scene that is not there'
run --scene bad.png -o bad.png in.exr
fails_with 2 '--scene' 'an output that is the scene'

# -- a file beside that is none ----------------------------------------------------

# waiting for a FIFO would not end, reading /dev/zero takes all memory
cp one.gltf leaf.gltf
mkfifo fifo.bin
ln -s /dev/zero zero.bin
ln -s one.png -
for name in fifo zero; do
    sed "s/leaf.bin/$name.bin/" leaf.gltf >buffer.$name.gltf
    sed "s/one.png/$name.bin/" leaf.gltf >image.$name.gltf
    for of in buffer image; do
        timeout 20 "$glarepp" --scene $of.$name.gltf -o o.png small.exr >out 2>err
        status=$?
        fails_with 4 "$name.bin: no regular file" "$name, named by a $of"
    done
done
sed 's/one.png/-/' leaf.gltf >dash.gltf
run --scene dash.gltf -o o.png small.exr </dev/null
status_is 0 'an image whose name is - is a file'
{ cat leaf.bin && head -c 100000 /dev/zero; } >longer.bin
sed 's/leaf.bin/longer.bin/' leaf.gltf >longer.gltf
run --scene longer.gltf -o o.png small.exr
status_is 0 'a buffer may be shorter than its file'
head -c 59 leaf.bin >shorter.bin
sed 's/leaf.bin/shorter.bin/' leaf.gltf >shorter.gltf
run --scene shorter.gltf -o o.png small.exr
fails_with 4 'truncated (59 bytes, "byteLength" is 60)' 'but not longer'
for name in fifo zero; do
    for option in scene flare lens camera lights; do
        timeout 20 "$glarepp" --$option $name.bin -o o.png small.exr >out 2>err
        status=$?
        fails_with 4 "$name.bin: no regular file" "$name, given to --$option"
    done
done
mkfifo pipe
run --lens pipe -o o.png small.exr
like "$(cat err)" '*; write a file as ./pipe, *' 'a file without an ending as a lens'

# -- the data's frames ------------------------------------------------------------

if [ -n "$data" ] && [ -e "$data/scenes/street.1001.exr" ]; then
    for n in 1001 1002 1003 1004; do
        run --scene "$data/scenes/street.glb" --report r.json \
            "$data/scenes/street.$n.exr"
        is "$(field r.json 'o["scene"]["camera_apart"] < 0.001')" True \
            "street $n: the frame's camera and the scene's are one" ||
            note "$(cat err) $(field r.json 'o["scene"]')"
    done
    run --scene "$data/scenes/street.glb" --scene-start 1 --report r.json \
        "$data/scenes/street.1003.exr"
    like "$(cat err)" '*pixels apart*' 'another time is told by the cameras'
    run --scene "$data/scenes/forest.glb" --report r.json \
        "$data/scenes/forest.1001.exr"
    is "$(lights '[round(L["sun"][k], 1) for k in ("x", "y", "radius")]')" \
        '[255.0, 52.0, 2.8]' 'forest: the sun is in its place'
else
    skip 6 "$no_data"
fi

done_testing
