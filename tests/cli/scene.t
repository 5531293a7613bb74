#!/bin/sh
# Scenes: lights and cameras of a glTF file beside a frame's own.
. "$(dirname "$0")/lib.sh"
need_python

street=$root/examples/street.glb

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
run --scene $street --scene-camera top -o o.png in.exr
fails_with 2 'use one of: cam' 'a camera that is not there'

# -- flux -------------------------------------------------------------------------

run --scene $street --light-scale 0.00146413 --report f.json --layer lit.exr \
    in.exr
is "$(field f.json 'o["flux_in"][0] > 1000')" True \
    '--light-scale gives lamps flux'
is "$(field r.json 'o["flux_in"]')" '[0.0, 0.0, 0.0]' 'without it they have none'

# -- what is wrong ----------------------------------------------------------------

printf 'glTF\002\0\0\0\377\377\0\0' >bad.glb
cp bad.glb bad.png
run --scene bad.glb -o o.png in.exr
fails_with 4 'truncated' 'a scene that is cut off'
run --scene none.glb -o o.png in.exr
fails_with 3 'none.glb' 'a scene that is not there'
run --scene bad.png -o bad.png in.exr
fails_with 2 '--scene' 'an output that is the scene'

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
