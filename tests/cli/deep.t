#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Deep frames: shares of lights among leaves and in smoke, against a second camera that
# looks at each, and pictures of their own alpha.
. "$(dirname "$0")/lib.sh"
need_python

"$python" "$cli/deep.py" make .
frame plain.exr channels=R,G,B,Z:float kind=dark size=96x64

# shares: against the truth of the second camera, and the errors
shares()
{
    "$python" "$cli/deep.py" check truth.json r.json 0.003 2>found
}

run --lights lights.json --deep deep.exr --report r.json plain.exr
quiet_success 'a deep file beside the frame'
is "$(shares)" '10 10 True' 'intervals hold the truth; worst error'
note "$(cat found)"
like "$(field r.json 'o["sun_edges"]')" 'deep: *' 'the report says so'
mkdir hair
"$python" "$cli/deep.py" hair hair 1
run --lights hair/lights.json --report hair.json hair/deep.exr
is "$("$python" "$cli/deep.py" check hair/truth.json hair.json 0.01 2>found)" '64 64 True' \
    'hair: intervals hold the truth; worst error'
note "hair, $(cat found)"
run --lights lights.json --deep other.exr --report other.json plain.exr
is "$(field other.json '[round(l["visibility"], 5) for l in o["lights"]]')" \
    "$(field r.json '[round(l["visibility"], 5) for l in o["lights"]]')" \
    'samples in another order, the same shares'
cp deep.exr shot.0007.exr
cp plain.exr frame.0007.exr
run --lights lights.json --deep shot.####.exr --report other.json frame.####.exr
is "$(field other.json 'o["lights"]')" "$(field r.json 'o["lights"]')" \
    'a pattern of deep files'
for n in 1 3; do
    run --lights lights.json --threads $n --report $n.json -o $n.exr deep.exr
    quiet_success "a deep frame as the picture, $n threads"
done
same 1.exr 3.exr 'the same picture'
is "$(field 1.json 'o["lights"]')" "$(field r.json 'o["lights"]')" \
    'and its own samples hide lights'
run --lights lights.json --depth-file plain.exr --report r.json deep.exr
like "$(field r.json 'o["sun_edges"]')" 'depth alone: *' 'but depth by name rules'
# a lamp in the middle of smoke of alpha 0.99, so that 0.1 shows; its bias is a tenth of
# the smoke
(cd "$cli" && "$python" -c 'import deep, sys
deep.write(sys.argv[1], [[[(99.5, 100.5, 0.99)]] * deep.W] * deep.H, list)' \
    "$tmp/smoke.exr")
echo '[{"pixel": [40.5, 20.5], "radius": 3, "depth": 100}]' >lamp.json
run --lights lamp.json --deep smoke.exr --report r.json plain.exr
is "$(field r.json '(lambda l: (round(l["visibility"], 3), l["interval"][0] < 0.1001,
    l["interval"][1] > 0.158))(o["lights"][0])')" '(0.158, True, True)' \
    'the interval holds what shows with a bias and without'
frame wide.exr channels=R,G,B,Z:float kind=dark size=128x64
run --lights lights.json --deep deep.exr --report r.json wide.exr
is "$(grep -c 'deep.exr: does not cover wide.exr (its window is 96x64' err)" 1 \
    'a deep file of another size is said'
frame two.exr channels=A:float,Z:float deep=3 size=96x64 part=back:A,Z:float
run --lights lights.json --deep two.exr --report r.json plain.exr
is "$(grep -c 'two.exr: .* only part 0 hides lights, part 1 does not' err)" 1 \
    'of two deep parts the other is said'

# a scene before them, a wall beyond all: its rays are taken, samples are the check
cat >wall.gltf <<'JSON'
{"asset": {"version": "2.0"}, "cameras": [{"type": "perspective",
 "perspective": {"yfov": 1.5707963267948966, "znear": 1}}],
 "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
 "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,@"}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "nodes": [{"camera": 0}, {"mesh": 0, "translation": [0, 0, -90]}, {"name": "lamp",
 "translation": [0, 0, -50], "extras": {"ball_radius": 8},
 "extensions": {"KHR_lights_punctual": {"light": 0}}}]}
JSON
sed "s,@,$("$python" -c 'import base64, struct
print(base64.b64encode(struct.pack("<9f", -9, -9, 0, 9, -9, 0, 0, 9, 0)).decode())')," \
    wall.gltf >scene.gltf
run --scene scene.gltf --deep deep.exr --report r.json plain.exr
is "$(field r.json 'o["lights"][0]["visibility"], o["sun_method"]'
    grep -c 'shows 1.000 of the light lamp at .* and the frame 0' err)" \
    "(1.0, 'scene')
1" 'a scene wins over deep samples, which are the check'
run --scene scene.gltf --deep deep.exr --sun-share depth --report r.json plain.exr
is "$(field r.json 'o["lights"][0]["visibility"] < 1, o["sun_method"]'; cat err)" \
    "(True, 'exact')" 'unless the frame is asked'

# -- pictures ------------------------------------------------------------------

for name in deep other tiles zips; do
    run -q --type float --hdr $name.hdr.exr $name.exr
    quiet_success "$name.exr becomes a picture"
done
for name in tiles zips; do
    run compare --fail 0 deep.hdr.exr $name.hdr.exr
    status_is 0 "$name.exr: tiles over the edge make the same picture"
done
run compare --fail 1e-5 --warn 1e-5 deep.hdr.exr other.hdr.exr
status_is 0 'unsorted samples make the same picture'
if [ -n "$oiio" ]; then
    "$python" - >verdict <<'PY'
"""Colours of leaves alone, which OpenImageIO sorts, and of smoke by thin slices."""
import math
import struct
import numpy as np
import OpenImageIO as o
deep, flat = o.ImageBuf("deep.exr"), o.ImageBuf("deep.hdr.exr")
names = list(deep.spec().channelnames)
got = flat.get_pixels(o.FLOAT)
own = [list(flat.spec().channelnames).index(c) for c in "RGBA"]
worst = 0.0
for y in range(0, 64, 3):
    for x in range(0, 96, 2):
        n = deep.deep_samples(x, y, 0)
        s = [[deep.deep_value(x, y, 0, names.index(c), i)
              for c in ("Z", "ZBack", "A", "R", "G", "B")] for i in range(n)]
        at = sorted({v[0] for v in s} | {v[1] for v in s})
        light, clear = np.zeros(3), 1.0
        for k, z in enumerate(at):
            for v in s:
                if v[0] == z == v[1]:
                    light += clear * np.array(v[3:])
                    clear *= 1 - v[2]
            if k + 1 == len(at):
                break
            puffs = [v for v in s if v[0] <= z and v[1] >= at[k + 1] and v[1] > v[0]]
            slices = 400
            for _ in range(slices if puffs else 0):
                step = (at[k + 1] - z) / slices
                t = [-math.log1p(-v[2]) / (v[1] - v[0]) * step for v in puffs]
                light += clear * sum(np.array(v[3:]) / v[2] * u for v, u in zip(puffs, t))
                clear *= math.exp(-sum(t))
        want = np.append(light, 1 - clear)
        worst = max(worst, np.abs(got[y, x, own] - want).max())
print(worst < 2e-3, "worst %.2g" % worst)
PY
    like "$(cat verdict)" 'True *' 'the picture is that of thin slices'
    note "$(cat verdict)"
else
    skip 1 'no numpy or no OpenImageIO'
fi

# -- refused -------------------------------------------------------------------

run --lights lights.json --deep plain.exr --report r.json plain.exr
fails_with 4 'no deep part' 'a flat file is no deep one'
run --lights lights.json --deep nowhere.exr --report r.json plain.exr
fails_with 3 nowhere.exr 'no such file'
run --lights lights.json --deep deep.exr --sun-method mask --report r.json plain.exr
fails_with 2 '--sun-method exact' 'GL has no samples'
run --deep deep.exr --report r.json plain.exr
fails_with 2 'needs a light' 'no light to hide'
run --max-pixels 9000 --lights lights.json --deep deep.exr --report r.json plain.exr
fails_with 4 '--max-pixels' 'more samples than are allowed'
run --max-pixels 9000 -o o.png deep.exr
fails_with 4 '--max-pixels' 'of a picture, too'
frame flat.exr channels=R,G,B,A:float kind=dark deep=3
run -o o.png flat.exr
fails_with 4 'without Z' 'deep samples in no order'
run --lights lights.json --deep flat.exr --report r.json plain.exr
fails_with 2 'floats; give --deep a file that has both' 'beside a frame, too'
head -c 20000 deep.exr >cut.exr
run --lights lights.json --deep cut.exr --report r.json plain.exr
fails_with 4 cut.exr 'a truncated file'

done_testing
