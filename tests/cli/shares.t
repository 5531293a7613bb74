#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The share of the sun against the truth that a second camera measured, which
# looks at the sun.
. "$(dirname "$0")/lib.sh"
need_python

# measures ARGUMENT...: reports of the frames with truth, in r.json
measures()
{
    : >r.json
    for stem in seq_foliage/foliage seq_foliage/foliage_f32 rendered/window \
        rendered/brightsky scenes/forest; do
        "$glarepp" -q "$@" --camera "$data/$stem.camera.json" \
            --report one.json "$data/$stem.####.exr" || return 1
        cat one.json >>r.json
    done
}

# -- the frame alone -----------------------------------------------------------

if [ -n "$data" ] && [ -f "$data/scenes/forest.camera.json" ]; then
    measures
    is "$("$python" "$cli/shares.py" "$data" r.json 0.02,0.051 2>found)" \
        '17 17 True' 'depth: intervals hold the truth; mean and worst error'
    note "depth, $(cat found)"
    is "$(field r.json 'o["sun_edges"][:11]')" 'depth alone' \
        'depth alone is named, with its error'
    measures --mask A
    is "$("$python" "$cli/shares.py" "$data" r.json 0.006,0.02 2>found)" \
        '17 17 True' 'coverage: intervals hold the truth; mean and worst error'
    note "coverage, $(cat found)"
    is "$(field r.json 'o["sun_edges"][:21]')" 'coverage: within 0.02' \
        'coverage beside depth is named, with its error'
else
    skip 4 "$no_data"
fi

# -- a scene for what the frame does not show ----------------------------------

street=$root/examples/alley.glb
frame plain.exr channels=R,G,B kind=dark

# lamps EXPRESSION: of r.json's lights, L by name
lamps()
{
    field r.json "(lambda L: $1)({l['name']: l for l in o['lights']})"
}

# what the scene's maker counted with rays of its own: in this frame lamp3 is
# beside the picture, .728 of it clear, lamp4 behind the camera and clear,
# lamp6 beside it and hidden
frame still.1004.exr channels=R,G,B,Z:float kind=dark size=640x360
run --scene "$street" --report r.json still.1004.exr
is "$(lamps '[round(L[k]["visibility"], 2) for k in ("lamp3", "lamp4",
    "lamp6")]')" '[0.73, 1.0, 0.0]' 'lamps beside and behind'
is "$(lamps 'L["lamp4"]["behind"]')" True 'behind the camera'
is "$(lamps '[round(v, 4) for v in L["lamp4"]["interval"]]')" '[0.9993, 1.0]' \
    'the interval of one behind the camera: three of 4096 rays'
is "$(lamps 'L["lamp3"]["interval"][0] < 0.7278 < L["lamp3"]["interval"][1]')" \
    True 'the interval holds it'
# pixels that the display window has and the file has not are beside the frame
for n in 1001 1002 1003 1004; do
    frame street.$n.exr channels=R,G,B,Z:float kind=dark size=640x4 \
        display=0,0,639,359
done
# an output has the pixels of the display window too: reading adds them
for more in '' '-o wide.exr'; do
    rm -f r.json
    "$glarepp" -q $more --scene "$street" --report r.json street.1001.exr
    is "$(lamps '[round(L[k]["visibility"], 1) for k in ("lamp1", "lamp2",
        "lamp3", "lamp5")]')" '[0.0, 1.0, 0.6, 0.0]' \
        "lamps outside the data window${more:+, $more}"
done
# no lamp is in these four rows
frame rows.1004.exr channels=R,G,B kind=dark size=640x4 display=0,0,639,359
run --scene "$street" --report r.json rows.1004.exr
is "$(grep -c 'nothing hides' err)" 0 'a scene before all lamps beside'
frame bare.1004.exr channels=R,G,B kind=dark size=640x360
run --scene "$street" --report r.json bare.1004.exr
is "$(cat err)" '' 'nor where it is before all'
run --scene "$street" --sun-share depth --report r.json bare.1004.exr
like "$(cat err)" '*nothing hides the lights inside the frame*' \
    'no depth, and lamps in the frame'
# -- rays or the frame, for what it shows --------------------------------------

run --scene "$street" --report one.json "$root/examples/alley.1003.exr"
is "$(field one.json 'o["sun_method"], "sun_edges" in o'; cat err)" \
    "('scene', False)" 'rays for every light, and the frame agrees'
run --scene "$street" --report r.json still.1004.exr
is "$(lamps 'L["lamp5"]["visibility"]')" 0.0 'what only the scene has hides'
is "$(grep -c 'the scene shows 0.000 of the light lamp5 at' err)" 1 \
    'one warning names the light'
frame still.1003.exr channels=R,G,B,Z:float kind=dark size=640x360
run --scene "$street" --report r.json still.1003.exr
like "$(cat err)" '*shows 0.000 of the light lamp5 at *1.000 (3 more differ)*' \
    'of several the one that is furthest off, after lamp3 at 0.963'
run --scene "$street" --sun-share depth --report r.json still.1004.exr
is "$(lamps '(L["lamp5"]["visibility"], o["sun_method"])'; cat err)" \
    "(1.0, 'exact')" 'or the frame, without a warning'
# of lamp1 in the frame, lamp3 and lamp6 beside it, lamp4 behind the camera, lamp5
# hidden in it
for row in 'visible [1.0,1.0,1.0,0.0,0.0]' 'hidden [1.0,0.0,0.0,0.0,0.0]' \
    'ignore [1.0,0.0,0.0,0.0,0.0]'; do
    run -q --scene "$street" --sun-outside ${row%% *} --report r.json still.1004.exr
    is "$(lamps '[L[k]["visibility"] for k in ("lamp1", "lamp3", "lamp6", "lamp4",
        "lamp5")]' | tr -d ' ')$(lamps '(L["lamp3"]["interval"], o["sun_method"])')" \
        "${row#* }([0.0, 1.0], 'scene')" "rays in the frame, ${row%% *} beside it"
done
# the border cuts a quarter of lamp3, and something hides a part of it in the frame
for row in 'scene 0.95' 'visible 0.95' 'hidden 0.71' 'ignore 0.94'; do
    run -q --scene "$street" --scene-start -0.1 --sun-outside ${row%% *} \
        --report r.json still.1003.exr
    is "$(lamps 'round(L["lamp3"]["visibility"], 2)')" "${row#* }" \
        "a lamp that the border cuts, ${row%% *} beside it"
done
run --scene "$street" --sun-share scene --sun-method readback --report r.json \
    still.1004.exr
fails_with 2 'leave --sun-method' 'a scene by rays, and by GL'
run --scene "$street" --sun-method readback --report r.json still.1004.exr
is "$(field r.json 'o["sun_method"]')" readback 'a method is of the frame'
echo '[{"name": "near", "pixel": [300, 200], "radius": 4, "depth": 9}]' >near.json
run --scene "$street" --lights near.json --report r.json still.1004.exr
is "$(field r.json 'o["sun_method"]')" 'scene and frame' \
    'and so is a depth by hand'

# -- ----------------------------------------------------------------------------


run --scene "$street" --threads 1 --report one.json still.1004.exr
run --scene "$street" --threads 3 --report r.json still.1004.exr
is "$(field r.json 'o["lights"]')" "$(field one.json 'o["lights"]')" \
    'any threads, the same shares'
run --scene "$street" --sun-outside ignore --report r.json still.1004.exr
is "$(lamps '[L[k]["visibility"] for k in ("lamp3", "lamp4")]')" '[0.0, 0.0]' \
    'another rule for the part outside'
run --sun 30,12 --sun-outside scene --report r.json plain.exr
fails_with 2 'needs --scene' 'a rule without its scene'

cat >bare.gltf <<'EOF'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
 "nodes": [{"name": "nothing"}]}
EOF
run --scene bare.gltf --sun 30,12 --report r.json still.1004.exr
fails_with 2 '--sun-outside ignore' 'a scene, and no camera to see it from'
cp "$root/examples/alley.1003.exr" bare.exr
run --scene bare.gltf --sun 30,300 --report r.json bare.exr
is "$(field r.json 'o["sun_method"], o["lights"][0]["visibility"]')" \
    "('exact', 0.0)" 'a scene without objects hides nothing'
run --scene bare.gltf --sun 30,12 --sun-outside ignore --report r.json plain.exr
status_is 0 'another rule needs no camera'

if [ -n "$data" ] && [ -f "$data/scenes/forest.camera.json" ]; then
    forest="--scene $data/scenes/forest.glb --sun-size 0.53"
    scenes()
    {
        "$glarepp" "$@" $forest --report r.json "$data/scenes/forest.####.exr"
        "$glarepp" "$@" --scene "$data/scenes/street.glb" --report s.json \
            "$data/scenes/street.####.exr"
        cat s.json >>r.json
    }
    scenes 2>err
    is "$("$python" "$cli/shares.py" "$data" r.json 0.0001,0.0003 2>found)" \
        '38 38 True' 'rays, in the frame and beside it'
    note "rays, $(cat found)"
    is "$(cat err)" '' 'and all frames agree with them'
    scenes -q --sun-share depth
    is "$("$python" "$cli/shares.py" "$data" r.json 0.02,0.06 2>found)" \
        '38 38 True' 'the same by depth'
    note "depth, $(cat found)"
    scenes -q --sun-share depth --mask A
    is "$("$python" "$cli/shares.py" "$data" r.json 0.02,0.06 2>found)" \
        '38 38 True' 'by a matte that has the balls of lamps'
    note "coverage, $(cat found)"
    "$glarepp" -q --scene "$street" --report r.json street.####.exr
    is "$("$python" "$cli/shares.py" "$data" r.json 0.002,0.01 2>found)" \
        '32 32 True' 'lamps outside the data window'
    note "$(cat found)"
else
    skip 5 "$no_data"
fi

done_testing
