#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# glarepp sets: Table 15-1 of a scene, with the same picture in every row; its
# JSON and pictures; scenes and options that are wrong.
. "$(dirname "$0")/lib.sh"

# A square of 1 x 1: a wall, a square behind it, one beside it, a floor, and one
# behind the camera; a lamp and a sun
cat >square.gltf <<'JSON'
{"asset": {"version": "2.0"}, "scene": 0,
 "scenes": [{"nodes": [0, 1, 2, 3, 4, 5, 6, 7]}],
 "nodes": [
  {"mesh": 0, "name": "wall", "scale": [4, 4, 1], "translation": [0, 0, -4]},
  {"mesh": 0, "name": "hidden", "translation": [0, 0, -8]},
  {"mesh": 0, "name": "beside", "translation": [3, 1, -6]},
  {"mesh": 0, "name": "floor", "scale": [40, 40, 1],
   "translation": [0, -2, -5], "rotation": [-0.7071068, 0, 0, 0.7071068]},
  {"mesh": 0, "name": "behind", "translation": [0, 0, 9]},
  {"camera": 0, "name": "camera"},
  {"name": "lamp", "translation": [2, 2, -3],
   "extensions": {"KHR_lights_punctual": {"light": 0}}},
  {"name": "sun", "rotation": [-0.5, 0, 0, 0.8660254],
   "extensions": {"KHR_lights_punctual": {"light": 1}}}],
 "cameras": [{"type": "perspective",
              "perspective": {"yfov": 0.9, "znear": 0.1}}],
 "extensionsUsed": ["KHR_lights_punctual"],
 "extensions": {"KHR_lights_punctual": {"lights": [
  {"type": "point", "intensity": 6830, "range": 20},
  {"type": "directional", "intensity": 683}]}},
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
 "accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
   "min": [-0.5, -0.5, 0], "max": [0.5, 0.5, 0]},
  {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
 "bufferViews": [{"buffer": 0, "byteLength": 48},
                 {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
 "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,AAAAvwAAAL8AAAAAAAAAPwAAAL8AAAAAAAAAPwAAAD8AAAAAAAAAvwAAAD8AAAAAAAABAAIAAAACAAMA"}]}
JSON

if ! "$glarepp" sets --size 64x36 --runs 1 square.gltf >out 2>err; then
    grep -q 'no GL context' err && skip_all 'no GL'
fi
is "$(wc -l <out)" 7 'a line about the scene, a heading, five rows'
is "$(head -1 out | cut -d, -f1-3)" 'square.gltf: 5 objects, 2 lights, 64x36' \
    'the scene is described'
no 'every row draws the same picture' grep -q another out
# of F: all but what is behind the camera; the wall hides one of them
is "$(awk 'NR > 2 { print $(NF - 9) }' out | tr '\n' ' ')" '4 3 3 3 3 ' \
    'the square behind the wall is hidden'

"$glarepp" sets --size 64x36 --runs 1 --json - square.gltf >json 2>err
result $? '--json -'
is "$(grep -c '"same_picture": true' json)" 5 'has five rows, and no table'
is "$(grep -c '"name"' json)" 2 'and two lights'
is "$(grep -c '"cpu_ms": 0*[.1-9]' json)" 5 'and the CPU time of each row'
is "$(tail -c 1 json | wc -l)" 1 'and ends with a line feed'
"$glarepp" sets --size 64x36 --runs 2 --json - square.gltf >json2 2>err
is "$(sed -n '/"lights": \[/,$p' json2)" "$(sed -n '/"lights": \[/,$p' json)" \
    'lights are those of the last row, however many runs'

"$glarepp" sets --size 64x36 --runs 1 -o a.exr --debug sets=sets.png \
    --debug scissor=scissor.png square.gltf >/dev/null 2>err
result $? 'pictures'
for f in a.exr sets.png scissor.png; do
    result "$([ -s $f ]; echo $?)" "$f is there"
done
# a ground that leaves the map does not make the rest small
for wide in 400 40000; do
    sed "s/\[40, 40, 1\]/[$wide, $wide, 1]/" square.gltf >ground.gltf
    "$glarepp" sets --size 64x36 --runs 1 --debug sets=$wide.pfm ground.gltf \
        >/dev/null 2>err
done
cmp 400.pfm 40000.pfm
result $? 'the map of sets shows what stands on a large ground'
# five lamps of the street reach all of this picture
"$glarepp" sets --size 64x36 --runs 1 --time 41.7083 \
    --debug scissor=scissor.pfm "$root/examples/alley.glb" >/dev/null 2>err
is "$(tail -c $((64 * 36 * 12)) scissor.pfm | tail -c +$((64 * 18 * 12 + 1)) |
    head -c $((7 * 12)) | od -An -v -f -w12 | grep -cv '\.')" 5 \
    'outlines of equal scissors are one inside the other'
"$glarepp" sets --size 64x36 --runs 1 --threads 1 -o b.exr square.gltf \
    >/dev/null 2>err
cmp a.exr b.exr
result $? 'the same bytes with one thread'
"$glarepp" sets --size 64x36 --runs 1 --gl egl -o c.exr square.gltf >/dev/null \
    2>err
result "$([ $? -eq 0 ] || grep -q 'no GL context\|cannot be loaded' err; echo $?)" \
    'with EGL'

# -- wrong command lines and scenes ----------------------------------------------

wrong() # STATUS TEXT NAME ARGS...
{
    want=$1 text=$2 name=$3
    shift 3
    "$glarepp" "$@" >out 2>err
    is $? "$want" "$name: status $want"
    is "$(wc -l <err)" 1 "$name: one line"
    grep -q -e "$text" err
    result $? "$name: says $text"
}
wrong 2 'no input' 'no scene' sets
wrong 2 'too many inputs' 'two scenes' sets square.gltf square.gltf
wrong 2 'not a size' 'a size of 0' sets --size 0x9 square.gltf
wrong 2 'not of glarepp sets' 'a picture of frames' \
    sets --debug sunmap=x.png square.gltf
wrong 2 'of glarepp sets only' 'a picture of scenes' \
    --debug sets=x.png frame.exr
wrong 3 'absent.glb' 'no such file' sets absent.glb
sed '/"camera": 0/d; /"cameras"/,+1d; s/4, 5, 6, 7/4, 5, 6/' square.gltf >blind.gltf
wrong 2 '0 cameras of that name' 'another camera' \
    sets --scene-camera top square.gltf
wrong 4 '0 cameras' 'no camera' sets blind.gltf
wrong 2 'square.gltf' 'the scene as an output' \
    sets --json square.gltf square.gltf

# -- the street ------------------------------------------------------------------

for time in 41.7083 41.75 41.7917 41.8333; do # its four frames
    "$glarepp" sets --size 640x360 --runs 1 --time $time \
        "$root/examples/alley.glb" >out 2>err
    result $? "the street at $time s: every row draws the same picture"
    for column in '2 0.31 batches' '1 0.66 fragments'; do
        set -- $column
        part=$(awk "NR == 7 { print \$(NF - $1) }" out)
        [ "$part" = - ] && part=0 # this context does not count fragments
        result "$(awk "BEGIN { exit !($part <= $2) }"; echo $?)" \
            "the street at $time s: $3 $part of the frustum's, at most $2"
    done
done
done_testing
