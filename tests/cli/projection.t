#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Projections: glare by true angles, its facts, its error and what refuses it.
# shellcheck disable=SC2016
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr seed=3
frame wide.exr seed=5 size=640x480

# -- facts ---------------------------------------------------------------------

run --projection plane -k eye --layer plane.exr --report r.json in.exr
is "$(field r.json 'o["projection"], "bound_angle" in o')" "('plane', False)" \
    'a plane where it is asked for'
run --fov 60 -k eye --layer l.exr --report r.json wide.exr
quiet_success 'without --projection'
is "$(field r.json 'o["projection"], o["engine"], o["engine_why"][:6]')" \
    "('perspective', 'levels', 'levels')" 'levels'
is "$(field r.json '0 < o["bound_angle"] <= o["bound"] <= 1e-3')" True \
    'within the tolerance'
is "$(field r.json 'round(o["deg_per_pixel"], 4)')" 0.1378 \
    'degrees of a pixel in the middle: 2 tan 30 / 480'
run --projection perspective -k k.exr --layer l.exr in.exr
like "$(cat err)" '*k.exr: *' 'no such kernel, by any projection'
run --projection cube --layer l.exr in.exr
status_is 2 'no such projection'

# -- error -----------------------------------------------------------------------

for words in '-k eye --fov 30' '-k eye --fov 90' '-k eye --fov 120 --edges black' \
    '-k eye --edges mirror' '-k eye-night -e fft' '-k eye-night --fov 90 -t .5' \
    '-k spencer:light=scotopic,halo=1,share=.5 -k eye-night --edges mirror'; do
    # shellcheck disable=SC2086
    run --projection perspective $words --verify --layer l.exr \
        --report r.json in.exr
    quiet_success "$words: verified"
    is "$(field r.json 'o["measured"]["rel_l2"] <= o["bound"]')" True \
        "$words: within the bound"
done
run --projection perspective -e direct -k eye --fov 90 --verify --layer l.exr \
    --report r.json in.exr
is "$(field r.json 'o["engine"], o["measured"]["rel_l2"] < 1e-6')" \
    "('direct', True)" 'direct is the sum as it is defined'
run --projection perspective --verify --layer l.exr --report r.json wide.exr
is "$(field r.json '0 < o["measured"]["pixels"] <= 640 * 480')" True \
    'pixels that were summed'

# -- the rest of a run -------------------------------------------------------------

run -e splat --projection perspective -k eye --layer no.exr wide.exr
status_is 2 'splat draws one shape everywhere'
like "$(cat err)" '*--projection plane*' 'and says what to do'
is "$(ls no.exr 2>/dev/null)" '' 'nothing is written'
run --projection perspective --style star --layer l.exr --report r.json wide.exr
quiet_success 'a model with rays beside others'
run -e splat -k eye --layer a.exr --report r.json wide.exr
if [ "$status" -eq 5 ]; then
    skip 3 'no GL: what splat draws'
else
    like "$status $(grep -c . err) $(cat err) $(field r.json 'o["projection"]')" \
        '0 1 *warning: wide.exr: its glare is that of a plane*--projection plane plane' \
        'splat says that it draws a plane'
    run -e splat -k eye --projection plane --layer b.exr wide.exr
    quiet_success 'which it was asked for'
    ok 'and draws as without' "$glarepp" compare --fail 0 --no-flip a.exr b.exr
fi
run --projection plane --save-settings s.txt --layer a.exr wide.exr
run --settings s.txt --layer b.exr wide.exr
same a.exr b.exr 'settings keep the projection'
run --layer a.exr wide.exr
run --threads 1 --layer b.exr wide.exr
same a.exr b.exr 'the same bytes by one thread'
# -- matrices ----------------------------------------------------------------------

# 90 degrees along +z; the axis at .25, .5, and for a matrix of -1 to 1 at 0, .2
for row in 'shift 0.5,0,0,0,0,-0.5,0,0,0.25,0.5,1,1,0,0,-1,0' \
    'corner 0.5,0,0,0,0,-0.5,0,0,0.15,0.15,1,1,0,0,-1,0' \
    'clip 1,0,0,0,0,1,0,0,0,0.2,1,1,0,0,-1,0'; do
    frame "${row% *}.exr" seed=3 "attr=worldToNDC:m44f:${row#* }"
    run --layer l.exr --report r.json "${row% *}.exr"
    quiet_success "${row% *}: a camera"
    is "$(field r.json 'o["fov_from"], round(o["deg_per_pixel"] * o["height"], 3)')" \
        "('camera', 114.592)" "${row% *}: 2 tan 45 degrees high"
done
frame flat.1.exr seed=3 attr=worldToNDC:m44f:0.5,0,0,0,0,-0.5,0,0,0,0,1,0,0.5,0.5,0,1
cp flat.1.exr flat.2.exr
run --layer l.#.exr --report r.json 'flat.#.exr'
like "$status $(grep -c . err) $(cat err) $("$python" -c 'import json
print({json.loads(l)["fov_from"] for l in open("r.json")})')" \
    "0 1 *warning: *flat.1.exr: *worldToNDC*no perspective*--fov* {'default'}" \
    'a matrix that is of no camera, once'
frame up.exr seed=3 attr=worldToNDC:m44f:0.5,0,0,0,0,0.5,0,0,0.4,0.6,1,1,0,0,-1,0 \
    attr=worldToCamera:m44f:1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1
run --layer l.exr --report r.json up.exr
like "$status $(cat err) $(field r.json 'round(o["deg_per_pixel"] * o["height"], 3)')" \
    '0 *warning: *up.exr: *y up*--camera FILE 114.592' 'one against the specification'
run --layer l.exr --fov 40 flat.1.exr
quiet_success 'and is not looked at where an angle is given'

# -- spheres and fisheyes ------------------------------------------------------------

frame sphere.exr seed=3 size=200x100 attr=envmap:envmap:0
frame cube.exr seed=3 size=64x384 attr=envmap:envmap:1
frame odd.exr seed=3 size=262x131
run --layer a.exr --report r.json --verify sphere.exr
quiet_success 'a lat-long by its attribute'
is "$(field r.json 'o["projection"], o["engine"], o["kernel_left_out"]')" \
    "('latlong', 'levels', 0.0)" 'of which no light is lost'
is "$(field r.json 'o["measured"]["rel_l2"] <= o["bound"] <= 1e-3')" True \
    'within its bound'
frame same.exr seed=3 size=200x100
run --projection latlong --fov 77 --layer b.exr same.exr
ok 'a lat-long by the option, which no angle of view changes' \
    "$glarepp" compare --fail 0 --no-flip a.exr b.exr
run --edges mirror --threads 1 --layer b.exr sphere.exr
ok 'nothing is beyond its border; the same by one thread' \
    "$glarepp" compare --fail 0 --no-flip a.exr b.exr
run --projection perspective --layer b.exr --report r.json sphere.exr
is "$(field r.json 'o["projection"]')" perspective 'the option is over the attribute'
run --projection latlong -k star --layer b.exr --report r.json sphere.exr
like "$status $(cat err)" '0 *warning: sphere.exr: its glare is that of a plane*' \
    'a model with rays has no place on a sphere'
run --projection latlong -k streak --layer b.exr --report r.json sphere.exr
is "$(field r.json 'all(abs(a / b - 1) < 5e-6 for a, b in zip(o["flux_out"], o["flux_in"]))')" \
    True 'but rays cross the seam'
run --projection latlong --layer b.exr --report r.json odd.exr
like "$status $(cat err) $(field r.json 'o["projection"]')" \
    '0 *warning: odd.exr: its glare is that of a plane*plane' 'a width with a factor of 131'
run -o no.png cube.exr
like "$status $(cat err)" '4 *cube.exr: its envmap is a cube map; *exrenvmap*' \
    'a cube map is refused, with a way out'
run --flare preset:zoom --lights auto -o no.png sphere.exr
like "$status $(cat err)" '2 *sphere.exr: a lat-long frame has no axis*--flare*' \
    'and so is a flare on a sphere'
is "$(ls no.png 2>/dev/null)" '' 'nothing is written'
run -e splat --projection latlong -o no.png sphere.exr
is "$status $(grep -c . err)" '2 1' 'nor does splat draw it, in one line'
for row in 'anamorphic flare' 'vintage lens'; do
    run --style "${row% *}" -k eye -o styled.png sphere.exr
    like "$status $(grep -c . err) $(cat err)" \
        "0 1 *warning: sphere.exr: *style ${row% *} is without its ${row#* }" \
        "a style's own ${row#* } is left out"
done
run styles -o sheet.png sphere.exr
is "$status" 0 'all styles of a sphere'
run --style vintage --lens tessar -o no.exr sphere.exr
is "$status" 2 'a lens that is given is not'
frame wrong.exr seed=3 size=200x120 attr=envmap:envmap:0
run --layer l.exr wrong.exr
like "$status $(cat err)" '0 *warning: wrong.exr: *twice as wide as high*200x120*' \
    'a sphere of a wrong size'
run --fov 200 --layer no.exr in.exr
like "$status $(cat err)" '2 *fov: 200 degrees*--projection fisheye*' \
    'a perspective ends before 180 degrees'
for how in fisheye equisolid; do
    run --projection $how -k eye --fov 200 --verify --layer l.exr --report r.json wide.exr
    quiet_success "$how: 200 degrees"
    is "$(field r.json 'o["projection"], o["fov_from"], o["measured"]["rel_l2"] <= o["bound"]')" \
        "('$how', 'option', True)" "$how: within its bound"
done
run --projection fisheye --report r.json --layer l.exr wide.exr
is "$(field r.json 'o["fov_from"]')" projection '180 degrees without --fov'

# -- suns ----------------------------------------------------------------------------

run --projection latlong --sun-dir 1,0,0 --sun-color 1e4 --report r.json --layer a.exr same.exr
status_is 0 'a sun of a lat-long needs no camera'
is "$(field r.json '[o["lights"][0][k] for k in "xy"]')" '[50.0, 50.0]' \
    'x is a quarter of a turn to the left, as OpenEXR has it'
run --projection fisheye --sun-dir 0,0,-1 --sun-color 1e4 --report r.json --layer a.exr wide.exr
is "$(field r.json 'o["lights"][0].get("behind")')" True 'beyond the rim'
# one that turns with its sphere, and in a fisheye
frame black.exr kind=zeros size=256x128
i=0
for row in 'latlong 0,0,1' 'latlong 0,0.7071,0.7071' 'latlong 0,1,0' 'latlong -1,-3,-1' \
    'fisheye 0,0,1' 'fisheye 1,0,0.3'; do
    i=$((i + 1))
    run --projection "${row% *}" --sun-dir "${row#* }" --sun-size 4 --sun-color 1e4 \
        --layer $i.pfm black.exr
done
"$python" - 1 2 3 4 5 6 <<'END'
import math, struct, sys
def veil(name, fisheye, to):
    with open(name + ".pfm", "rb") as f:
        f.readline()
        w, h = (int(n) for n in f.readline().split())
        f.readline()
        v = struct.unpack("<%df" % (3 * w * h), f.read())[1::3]
    size, total, n = math.hypot(*to), 0, 0
    for i, value in enumerate(v):
        x, y = (i % w + 0.5 - w / 2) * math.pi / h, (i // w + 0.5 - h / 2) * math.pi / h
        r = math.hypot(x, y)
        if fisheye: # x right
            d = (math.sin(r) * x / r, math.sin(r) * y / r, math.cos(r))
        else: # x left
            d = (-math.cos(y) * math.sin(x), math.sin(y), math.cos(y) * math.cos(x))
        a = math.degrees(math.acos(sum(p * q for p, q in zip(d, to)) / size))
        if abs(a - 20) < 1.5 and not (fisheye and r > math.pi / 2):
            total += value * (a / 20) ** 3.3 # as it falls
            n += 1
    return total / n
to = [(0, 0, 1), (0, .7071, .7071), (0, 1, 0), (-1, -3, -1), (0, 0, 1), (1, 0, .3)]
v = [veil(name, i > 3, to[i]) for i, name in enumerate(sys.argv[1:])]
print("# veil at 20 degrees:", v)
sys.exit(not all(abs(x / v[i // 4 * 4] - 1) < 0.006 for i, x in enumerate(v)))
END
result $? 'a sun has the same glare wherever its sphere turns it'
# a sun that leaves the frame: in it, on its border, beside it
for x in 59 64 69; do
    run --fov 90 -k eye --edges black -t 1e6 --sun-outside visible --sun $x,32,3 \
        --sun-color 1e4 --layer $x.pfm in.exr
done
"$python" - 59.pfm 64.pfm 69.pfm <<'END'
import struct, sys
v = []
for path in sys.argv[1:]:
    with open(path, "rb") as f:
        f.readline()
        w, h = (int(n) for n in f.readline().split())
        f.readline()
        f.seek(12 * ((h - 1 - 32) * w + 15), 1)
        v.append(struct.unpack("<3f", f.read(12))[1])
sys.exit(not (0.6 < v[1] / v[0] < 0.7 and abs(v[1] * v[1] / v[0] / v[2] - 1) < 0.05))
END
result $? 'light does not jump where a sun leaves the frame'
# -- hard angles ---------------------------------------------------------------------

frame nan.exr kind=nan size=96x48
frame hot.exr seed=2 size=96x48 hot=1e9 dim=1e-3
for how in perspective latlong fisheye equisolid; do
    for name in nan hot; do
        run --projection $how -k eye -t 0 --max-value 1e10 --verify --layer l.exr \
            --report r.json $name.exr
        is "$status $(field r.json 'o["projection"], o["measured"]["rel_l2"] <= o["bound"]')" \
            "0 ('$how', True)" "$how: $name"
    done
done
for words in 'extend --fov 60' 'mirror --fov 20' 'mirror --fov 70'; do
    # shellcheck disable=SC2086
    run --projection equisolid -k eye -t 0 --edges $words --verify --layer l.exr \
        --report r.json hot.exr
    is "$status $(field r.json 'o["measured"]["rel_l2"] <= o["bound"]')" '0 True' \
        "a fisheye whose rim is beyond the frame: $words"
done
run --projection perspective --fov 0.001 --layer l.exr --report r.json in.exr
status_is 0 'a tele lens'
run --projection perspective --fov 179.9 --layer l.exr --report r.json in.exr
like "$status $(cat err)" '0 *warning: in.exr: its glare is that of a plane*8 degrees*' \
    'an angle that no level serves'
is "$(field r.json 'o["projection"], o["bound"]')" "('plane', None)" \
    'is of a plane, of which the report says that it has no bound'
run -k aperture --fov 175 --layer l.exr --report r.json in.exr
like "$status $(cat err) $(field r.json 'o["bound"]')" '0 *a plane of 175*8 degrees* None' \
    'nor direction cosines'
run -k aperture:share=0 -k eye --layer l.exr in.exr
quiet_success 'an opening without a share'
# what keeps one shape is said where light would go by angle, and over a sphere
for words in '-e splat -k eye-night' '-e splat -k eye' \
    '-k eye -k streak --projection latlong' '-k aperture --projection latlong' \
    '-k star --projection fisheye'; do
    # shellcheck disable=SC2086
    run $words --layer l.exr --report r.json in.exr
    like "$status $(cat err) $(field r.json 'o["bound"]')" \
        '0 *glare is that of a plane* None' "one shape, without bound: $words"
done
for words in '-k star' '-k eye -k star'; do
    # shellcheck disable=SC2086
    run $words --layer l.exr in.exr
    quiet_success "a camera's frame has shapes of pixels: $words"
done
run -k cie --fov .001 --tolerance .01 --layer l.exr in.exr
status_is 0 'nothing of a kernel but light by angle'
run -k aperture:pupil=500 --fov 100 --layer l.exr in.exr
quiet_success 'a wide pupil, whose light is far finer than a pixel'
frame lamps.exr kind=lights lights=50 seed=4 size=192x108
run -k aperture --fov 60 -e fft --verify --layer l.exr --report r.json lamps.exr
is "$status $(field r.json 'o["measured"]["rel_l2"] <= o["bound"] < 1e-3')" '0 True' \
    'direction cosines keep their bound'
for fov in 0.02 0.1 0.5 2; do
    run -k eye --fov $fov --verify --layer l.exr --report r.json lamps.exr
    is "$status $(field r.json 'o["measured"]["rel_l2"] <= o["bound"]')" '0 True' \
        "a narrow field of $fov degrees, whose pixels are far under an eye's core"
done
run -t 50% --projection latlong --report r.json --layer l.exr sphere.exr
run -t 50% --projection perspective --report s.json --layer l.exr sphere.exr
no 'percentiles of a lat-long are of its solid angle' \
    test "$(field r.json 'o["threshold"]')" = "$(field s.json 'o["threshold"]')"

done_testing
