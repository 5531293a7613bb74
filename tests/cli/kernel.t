#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Kernels: models by the frame's angle, several at once, images of any size, and
# the command that writes, lists and checks them.
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr seed=3
frame k.exr kind=kernel size=16x12 type=float

# -- angle ---------------------------------------------------------------------

run --projection plane --fov 48 --layer l.exr --report r.json in.exr
quiet_success '--fov'
is "$(field r.json 'o["deg_per_pixel"], o["fov_from"]')" "(1.0, 'option')" \
    '--fov: degrees of a pixel of 48 lines'
run --projection plane --layer l.exr --report r.json in.exr
is "$(field r.json 'o["deg_per_pixel"], o["fov_from"]')" "(0.625, 'default')" \
    'no --fov: 30 degrees high'
run -k k.exr --layer l.exr --report r.json in.exr
is "$(field r.json '"deg_per_pixel" in o')" False 'an image has no angle'

# the coarse grid of the far part keeps fft and direct over a small tolerance
frame wide.exr seed=5 size=640x480
run --projection plane -k eye --verify --layer l.exr --report r.json wide.exr
is "$(field r.json 'o["kernel"]["grid"] > 0, o["bound"] > 3e-6')" \
    '(True, True)' 'a tail on a coarse grid'
run --projection plane -k eye --tolerance 2.5e-6 --verify --layer l.exr --report r.json wide.exr
quiet_success 'a tolerance that only the whole kernel keeps'
is "$(field r.json 'o["engine"], "whole kernel" in o["engine_why"]')" \
    "('direct', True)" 'auto sums the whole kernel'
is "$(field r.json 'o["measured"]["rel_l2"] <= o["bound"] <= 3e-6')" True \
    'within its bound'
run -k eye --tolerance 1e-9 --layer l.exr --report r.json wide.exr
like "$(cat err)" '*no engine guarantees a tolerance of 1e-09 *; *--tolerance*' \
    'and one that none keeps'

# frames of one size in a row have one kernel, in the same bytes
for i in 1 2 3 4 5; do
    case $i in 3 | 4) size=48x40 ;; 5) size=40x30 ;; *) size=64x48 ;; esac
    frame "sizes.$i.exr" seed=$i size=$size
done
made='["kernel" in json.loads(l)["times_ms"] for l in open("r.json")]'
run -k star -e fft --layer 's.#.exr' --report r.json 'sizes.#.exr'
is "$(field r.json "$made")" '[True, False, True, False, True]' \
    'times_ms has the kernel of frames for which one was made'
run -k star --frame-jobs 1 --layer one.exr --report r.json sizes.4.exr
is "$(field r.json 'o["cpu_ms"]["kernel"] > 0')" True 'and cpu_ms'
run -k star -e fft --layer one.exr sizes.4.exr
ok 'a kernel that is kept is the kernel of its size' \
    "$glarepp" compare --no-flip --fail 0 one.exr s.4.exr
run -k temporal:wavelengths=2 --layer 's.#.exr' --report r.json 'sizes.#.exr'
is "$(field r.json "$made")" '[True, True, True, True, True]' \
    'one that moves is made for each frame'

# one scene at 30 and at 60 lines, and the layers' distance after averaging
cat >scene.py <<'PY'
import array, math, sys

def read(path):
    with open(path, "rb") as f:
        assert f.readline() == b"PF\n"
        w = int(f.readline().split()[0])
        f.readline()
        v = array.array("f")
        v.frombytes(f.read())
    return v, w

def write(path, v, w, h):
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (w, h) + v.tobytes())

if sys.argv[1] == "make":
    for n in 1, 2:
        v = array.array("f")
        for y in range(30 * n):
            for x in range(40 * n):
                lamp = (x // n * 13 + y // n * 7) % 97 == 0
                v.extend([90., 60., 30.] if lamp else [0.2] * 3)
        write("scene.%d.pfm" % n, v, 40 * n, 30 * n)
elif sys.argv[1] == "draw":  # lamps of 3 to 18 pixels with smooth edges
    w, h = 80, 60
    v = array.array("f", [0.2] * (3 * w * h))
    for k in range(6):
        x0, y0 = 8 + 37.3 * k % 64, 7 + 23.7 * k % 46
        radius = 1.5 + 1.5 * k
        for i in range(w * h):
            x, y = i % w - x0, i // w - y0
            if math.hypot(x, y) > radius + 1:
                continue
            n = sum(math.hypot(x + a / 8 + 1 / 16, y + b / 8 + 1 / 16) < radius
                    for a in range(8) for b in range(8)) / 64
            for c in range(3):
                v[3 * i + c] += n * ((90., 60., 30.)[c] - v[3 * i + c])
    write("scene.2.pfm", v, w, h)
    mean = array.array("f")
    for i in range(3 * w * h // 4):
        c, x, y = i % 3, i // 3 % (w // 2), i // 3 // (w // 2)
        mean.append(sum(v[3 * ((2 * y + j) * w + 2 * x + k) + c]
                        for j in (0, 1) for k in (0, 1)) / 4)
    write("scene.1.pfm", mean, w // 2, h // 2)
else:
    (a, w), (b, _) = read("l.1.pfm"), read("l.2.pfm")
    norm = error = 0.0
    for i, v in enumerate(a):
        c, x, y = i % 3, i // 3 % w, i // 3 // w
        mean = sum(b[3 * ((2 * y + j) * 2 * w + 2 * x + k) + c]
                   for j in (0, 1) for k in (0, 1)) / 4
        norm, error = norm + v * v, error + (mean - v) ** 2
    print(math.sqrt(error / norm) < 0.01)
PY
"$python" scene.py make
for model in spencer cie:age=70 spencer:light=scotopic star cross streak ring \
    circle moffat aperture temporal; do
    for n in 1 2; do
        run -e direct -k $model --fov 5 -t 1 --layer l.$n.pfm scene.$n.pfm
    done
    is "$("$python" scene.py compare)" True "$model: one glare at both sizes"
done

# the same of a scene drawn at 2160 lines of 30 degrees and averaged to
# 1080; of models that leave under a pixel's width alone: where in its pixel the
# light of a lamp's edge was, averages no longer know
"$python" scene.py draw
for model in star cross streak ring circle moffat gaussian; do
    for n in 1 2; do
        run -e direct -k $model --fov 0.8333 -t 0 --layer l.$n.pfm scene.$n.pfm
    done
    is "$("$python" scene.py compare)" True "$model: one glare of a drawn scene"
done

# -- time ----------------------------------------------------------------------

for rate in 24 48; do # the frame's rate, and its number
    for i in 1 2; do
        frame move.$i.exr seed=3 "attr=framesPerSecond:rational:$rate,1"
    done
    run --fov 5 -k temporal -e direct --layer "t$rate.#.exr" 'move.#.exr'
    quiet_success "a pupil that moves, at $rate frames a second"
done
no 'it moves with the frames' "$glarepp" compare --no-flip --fail-rel 1e-6 \
    t24.1.exr t24.2.exr
no 'frames of another rate are at another time' "$glarepp" compare --no-flip \
    --fail-rel 1e-6 t24.1.exr t48.1.exr
ok 'but the same time is the same pupil' "$glarepp" compare --no-flip --fail 0 \
    t24.1.exr t48.2.exr

# pupils of each frame, by Moon and Spencer: a pixel of 100 among 160 is a mean
# of 62.5 cd/m2, or 625, in a window of 320 pixels 31.25; one of 10 is 6.25
frame adapt.1.exr kind=zeros hot=100 size=16x10
frame adapt.2.exr kind=zeros hot=100 size=16x10 \
    attr=whiteLuminance:float:1000
frame adapt.3.exr kind=zeros hot=100 size=16x10 display=0,0,31,9
frame adapt.4.exr kind=zeros hot=10 size=16x10
for eye in temporal:adaptation=0,hippus=0 spencer:light=adapted,halo=0; do
    run --fov 5 -k star -k $eye --layer 'eye.#.exr' --report r.json 'adapt.#.exr'
    quiet_success "$eye: frames of their own light"
    is "$(field r.json '[json.loads(l)["kernel"]["pupil_mm"] for l in open("r.json")]')" \
        '[[None, 3.0545], [None, 2.4802], [None, 3.2957], [None, 3.979]]' \
        "$eye: the report has each pupil"
    run --fov 5 -k star -k $eye --layer alone.exr adapt.3.exr
    same alone.exr eye.3.exr "$eye: a frame alone has the same bytes"
    run --fov 5 -k $eye,white=1000 --layer a.exr --report r.json adapt.1.exr
    is "$(field r.json 'o["kernel"]["pupil_mm"]')" '[2.4802]' \
        "$eye: white in place of the file's"
    run kernel -k $eye -o k2.exr
    fails_with 2 "${eye%%:*}" "$eye: a kernel that no frame has"
    like "$(cat err)" '*give it in cd/m2' "$eye: and says what to do"
done

run kernel -k eye --size 16384x16384 -o big.exr
status_is 4 'a kernel over --max-pixels: status 4'
no 'and it is not there' test -e big.exr
run -k star --kernel-normalize luminance -o o.png in.exr
status_is 2 'a model is not normalised: usage'
like "$(cat err)" '*--kernel-normalize*leave it out*' 'and a line says so'
run -k halation:share=1 -o o.png wide.exr
status_is 2 'a channel that would spread more than all of its light'
like "$(cat err)" '*multiply share= by 0.3* or less' 'a tint too strong: says by how much'

# -- several -------------------------------------------------------------------

run -k cie:age=70 -k star:share=.2 -k k.exr -e direct --layer l.exr \
    --report r.json in.exr
quiet_success 'two models and an image'
is "$(field r.json 'o["settings"]["kernel"]')" \
    "['cie:age=70', 'star:share=.2', 'k.exr']" 'the report names all'
run -k image:file=k.exr,share=1 -e direct --layer a.exr in.exr
run -k k.exr -e direct --layer b.exr in.exr
ok 'an image is its own recipe' "$glarepp" compare --fail-rel 1e-6 --no-flip \
    a.exr b.exr
run -k eye-old:share=.5 -e direct --layer a.exr in.exr
run -k builtin:eye-old:share=.5 -e direct --layer b.exr in.exr
ok "a preset's keys, without builtin:" "$glarepp" compare --fail 0 --no-flip \
    a.exr b.exr
set --
for i in 1 2 3 4 5 6 7 8 9; do set -- "$@" -k eye; done
run "$@" --layer l.exr in.exr
fails_with 2 'found 9' 'too many kernels'
run -k image:file=none.exr --layer l.exr in.exr
fails_with 3 none.exr 'an image that is missing'
run -k image:file=in.exr --layer in.exr in.exr
fails_with 2 in.exr "an image that would be replaced"
run -k eye --kernel-size 50 --layer l.exr in.exr
fails_with 2 --kernel-size 'a model in percent'
run -k eye --kernel-center 3,4 --layer l.exr in.exr
fails_with 2 --kernel-center "a model's centre"

# -- sizes of images -----------------------------------------------------------

run -k k.exr --kernel-size 100 --layer a.exr in.exr
run -k k.exr --layer b.exr in.exr
ok 'the size of 100 percent' "$glarepp" compare --fail 0 --no-flip a.exr b.exr
run -k k.exr --kernel-size 300% -e direct --layer a.exr --report r.json in.exr
is "$(field r.json '"deg_per_pixel" in o')" False 'percent have no angle'
# 12 lines of 30 / 48 degrees are 7.5 degrees, three times that 22.5
run --projection plane -k k.exr --kernel-size 22.5deg -e direct --layer b.exr --report r.json \
    --grow kernel in.exr
is "$(field r.json 'o["deg_per_pixel"], o["width"]')" '(0.625, 111)' \
    'degrees: an angle, and a reach of 25 and 22 pixels'
run --projection plane -k k.exr --kernel-size 22.5deg -e direct --layer b.exr in.exr
ok 'degrees and percent of one size' "$glarepp" compare --fail-rel 1e-6 \
    --no-flip a.exr b.exr

# -- glarepp kernel ------------------------------------------------------------

run kernel -k cie:age=70 -k star:share=.05 -k image:file=k.exr,share=.1 \
    --size 96x54 --fov 20 --rotate 10 -o a.exr
quiet_success 'kernel -o'
mkdir -p away
cp k.exr away/own.exr
run kernel -k image:file=away/own.exr,share=.1 --size 64x48 -o away/own.exr
fails_with 2 away/own.exr 'kernel: an output that its recipe reads'
same k.exr away/own.exr 'and that stays as it was'
# hostile attributes
long=$(printf '%050000d' 0 | tr 0 9)
labelled() # RECIPE [NAME=VALUE...]
{
    recipe=$1
    shift
    fov=30 size=64x48,0 rotate=0 frame=0 compression=auto left_out=0 beyond=0
    for word; do eval "${word%%=*}=\${word#*=}"; done
    frame odd.exr kind=kernel size=9x9 "attr=glarepp:recipe:string:$recipe" \
        attr=glarepp:fov:string:$fov attr=glarepp:size:string:$size \
        attr=glarepp:rotate:string:$rotate attr=glarepp:frame:string:$frame \
        attr=glarepp:compression:string:$compression \
        attr=glarepp:left_out:string:$left_out \
        attr=glarepp:beyond:string:$beyond
}
for recipe in nosuch "star:ponits=3" "star:share=$long" "$long" ''; do
    labelled "$recipe"
    run kernel --check odd.exr
    [ -z "$recipe" ] ||
        fails_with 4 odd.exr "--check: a recipe of ${#recipe} bytes that is none"
    ok 'in a short line' test "$(wc -c <err)" -lt 500
    run -k odd.exr --layer l.exr in.exr
    fails_with 4 odd.exr 'a run: such a recipe'
done
for value in fov=1e9 fov=nan fov=0 fov= size=0x0,0 size=99999x9,0 size=64x48 \
    size=64x48,99999 left_out=7 left_out=1e999 beyond=x; do
    labelled star $value
    run kernel --check odd.exr
    no "attributes that are not whole are none: $value" grep -q '^left out' out
done
labelled star
run kernel --check odd.exr
like "$status $(cat out)" '1 *its light sums to *' \
    '--check: samples that are not those of its attributes'
run -k odd.exr --layer l.exr in.exr
like "$status $(cat err)" '0 *warning: odd.exr: its light sums to *' \
    'a run warns of them'
run -k odd.exr --kernel-normalize luminance --layer l.exr in.exr
no 'but not where they are scaled' grep 'its light sums' err
run kernel -k eye --fov 0.02 --size 64x48 --threads 1 -o a.exr
run kernel -k eye --fov 0.02 --size 64x48 --threads 2 -o b.exr
same a.exr b.exr 'the same bytes for any number of threads'
run --projection plane -k eye --fov 0.02 -e direct --type float --layer l.exr in.exr
run -k a.exr --fov 0.02 --kernel-normalize none -e direct --type float --layer m.exr in.exr
ok 'the file makes the layer of its model' "$glarepp" compare --fail-rel 1e-6 \
    --no-flip l.exr m.exr

# frames of other primaries
rec2020=0.708,0.292,0.17,0.797,0.131,0.046,0.3127,0.329
acescg=0.713,0.293,0.165,0.83,0.128,0.044,0.32168,0.33767
frame wide.1.exr seed=3 attr=chromaticities:chromaticities:$rec2020
frame wide.2.exr seed=3 attr=chromaticities:chromaticities:$acescg
frame wide.3.exr seed=3
run kernel -k aperture:share=1,wavelengths=8 --size 64x48 -o a.exr
is "$("$python" "$cli/tags.py" a.exr | grep '^chromaticities')" \
    chromaticities=0.6400,0.3300,0.3000,0.6000,0.1500,0.0600,0.3127,0.3290 \
    'a kernel file names its primaries'
# of a plane, whose pixels are those in the middle of 30 degrees
run --projection plane --fov 30.7047157 -k aperture:share=1,wavelengths=8 -e direct \
    --type float --layer 'm.#.exr' 'wide.#.exr'
run -k a.exr -e direct --type float --layer 'l.#.exr' --report r.json 'wide.#.exr'
quiet_success 'a kernel file in frames of other primaries'
for i in 1 2 3; do
    ok "makes the layer of the model in those of frame $i" "$glarepp" compare \
        --no-flip --fail-rel 1e-5 m.$i.exr l.$i.exr
done
run -k image:file=a.exr -e direct --type float --layer 'l.#.exr' 'wide.#.exr'
ok 'and so does its recipe' "$glarepp" compare --no-flip --fail-rel 1e-5 \
    m.1.exr l.1.exr
run kernel --check a.exr
like "$(cat out)" '*primaries  0.64,0.33 0.3,0.6 0.15,0.06, white 0.3127,0.329*' \
    '--check: its primaries'
run kernel --check k.exr
like "$(cat out)" '*primaries  not named: used as it is in any frame*' \
    '--check: none'

run kernel -k eye -o a.png
fails_with 2 '-o of a kernel' 'a kernel is an EXR file'
run kernel --list
quiet_success '--list'
is "$(awk 'length($0) > 79' out)" '' '--list: fits a terminal'
is "$(grep -c '^[a-z]*: ' out)" "$(grep -c 'share=' out)" \
    '--list: each model has a share'
for model in spencer cie star cross streak ring circle gaussian moffat image; do
    grep -q "^$model: " out || echo $model
done >missing
is "$(cat missing)" '' '--list: every model'

# -- faults --------------------------------------------------------------------

# images, and the rules that each breaks
cat >images.py <<'PY'
import array, math, sys
kind = sys.argv[1]
n = {"beside": 16, "box": 61, "one": 9, "soft": 201}.get(kind, 15)
v = array.array("f")
for y in range(n):
    for x in range(n):
        dx, dy = x - (n - 1) / 2, y - (n - 1) / 2
        d = math.hypot(dx, dy)
        a = max(1 - d / 7.5, 0) ** 2
        if kind == "cut":
            a = 1 / (1 + d * d)
        if kind == "soft":
            a = 1 / (1 + d * d) * min(max((81 - d) / 2, 0), 1)
        if kind == "box":
            a = 1.0 * (max(abs(dx), abs(dy)) <= 20)
        if kind == "shifted":
            a = max(1 - math.hypot(dx - 1, dy) / 6, 0)
        if kind == "dark":
            a = 0.0
        if kind == "moved":
            a = max(1 - math.hypot(dx - 3, dy) / 4, 0) ** 2
        if kind == "side":
            a = 1.0 * (d == 0) + (dy == 0) * (1 - d / 8) * (.1 if dx > 0 else .02)
        if kind == "one":
            a = 1.0 * (d == 0)
        c = -1e-3 if kind == "lobe" and d == 2 else a
        red = max(1 - math.hypot(dx - 3, dy) / 4, 0) if kind == "fringe" else c
        v.extend([red, c, 0.0 if kind == "yellow" else c])
with open(kind + ".pfm", "wb") as f:
    f.write(b"PF\n%d %d\n-1.0\n" % (n, n) + v.tobytes())
PY
# $1: an image; $2: the parts of fault lines, in their order
faults()
{
    "$python" images.py $1
    run kernel --check $1.pfm
    [ -z "$2" ] && wanted=0 || wanted=1
    status_is $wanted "--check: $1"
    like "$(grep '^fault: ' out)" "$2" "--check: faults of $1"
    is "$(grep -c '^fault: ' out)" "$3" "--check: no other of $1"
    sed -n 's/^fault: \([^:;]*\).*/\1/p' out >checked
    run -k $1.pfm --layer l.exr in.exr
    sed -n "s/.*warning: $1.pfm: \([^:;]*\).*/\1/p" err >warned
    # a run is by its own frame's light, and scaled to a sum of 1
    is "$(sed 's/[0-9.]*$//' warned)" "$(sed 's/[0-9.]*$//' checked)" \
        "a run warns of the faults of $1"
    run -q -k $1.pfm --layer l.exr in.exr
    quiet_success "but not with -q: $1"
}
faults fade '' 0
faults cut '*its outermost rows*its edge shows*' 2
faults box '*its outermost rows*its edge shows*' 2
faults lobe '*samples are negative*' 1
faults beside '*its centroid is half a pixel*' 1
faults moved '*its peak is 3,0 pixels*no counterpart*' 2
faults fringe '*the peak of its red is 3,0 pixels*' 1
faults shifted '*its centroid is 1,0 pixels*' 1
faults side '*no counterpart opposite*' 1
faults yellow '*its blue sums to 0*' 1
faults one '*a single sample*' 1
"$python" images.py dark
run kernel --check dark.pfm
like "$status $(cat out)" '1 *fault: its light sums to 0*' '--check: no light'
"$python" images.py soft
run kernel --check soft.pfm
like "$status $(grep '^fault: ' out)" '1 *its edge shows: 0.0* a source of 1e+03*' \
    '--check: an edge over two pixels'
for kernel in moved side; do
    run -k $kernel.pfm --kernel-center 8.5,8.5 --layer l.exr in.exr
    quiet_success "no warning of $kernel with a centre that was given"
done
run -k beside.pfm --kernel-size 50% --layer l.exr in.exr
no 'nor of a centroid that was resampled' grep 'half a pixel' err
frame wide.exr size=64x48 aspect=2
run -k beside.pfm --layer l.exr wide.exr
no 'nor for pixels that are not square' grep 'half a pixel' err
run -k lobe.pfm --kernel-center 7.5,7.5 --layer l.exr in.exr
like "$status $(cat err)" '0 *samples are negative*' \
    'a centre that was given does not hide negative samples'
for kernel in fade lobe beside moved fringe side yellow one; do
    run kernel --check $kernel.pfm
    sed -n 's/^fault: \([^:;]*\).*/\1/p' out >checked
    run -k image:file=$kernel.pfm,share=.5 -k star --layer l.exr in.exr
    sed -n "s/.*warning: image:file=$kernel.pfm,share=.5: \([^:;]*\).*/\1/p" err \
        >warned
    is "$(cat warned)" "$(cat checked)" "a run warns of $kernel among several"
done
run -k image:file=side.pfm,x=8 -k image:file=beside.pfm,percent=50 -k star \
    --layer l.exr in.exr
quiet_success 'but not of what a recipe sets'
run -k lobe.pfm -k star --layer 's.#.exr' 'sizes.#.exr'
is "$(grep -c 'samples are negative' err)" 1 'once for all frames, of several'
run -k lobe.pfm --layer 's.#.exr' 'sizes.#.exr'
is "$(grep -c 'samples are negative' err)" 1 'once for all frames'
frame nan.exr kind=nan size=9x9
run kernel --check nan.exr
status_is 1 '--check: NaN'
like "$(cat out)" '*3 samples are NaN or infinite*' '--check: how many'
run kernel --check fade.pfm
like "$status $(cat out)" '0 *own pixel  3.388 %*' '--check: own pixel'
run kernel --check circle:share=1 --mix add --size 200x200
like "$status $(cat out)" '1 *use --mix scatter*' '--check: defocus with add'
run kernel --check eye
like "$status $(cat out)" '0 *left out   1.1? %, of which 0 % in the frame' \
    "--check: light beside the frame is no fault"
run kernel --check eye --radius 30
like "$status $(cat out)" "1 *% of its model's light falls in the frame*" \
    "--check: a model's share outside"
run kernel -k eye --size 64x48 --radius 12 -o small.exr
run kernel --check small.exr
like "$status $(cat out)" "1 *% of its model's light falls in the frame*" \
    "--check: a file's share outside"
run kernel -k eye --size 64x48 -o whole.exr
run kernel --check whole.exr
status_is 0 '--check: a file as large as its frame'
run kernel --check star
like "$(cat out)" '*left out   0 %*' '--check: rounding is no light left out'
for preset in $("$glarepp" kernel --list | sed -n 's/^  \([a-z-]*\)  .*/\1/p'); do
    run kernel --check builtin:$preset --size 320x180
    status_is 0 "--check: builtin:$preset"
done
run kernel --check cut.pfm in.exr
like "$status $(cat out)" '1 *edge shows*' "--check: by a frame's light"
frame faint.exr kind=dark
run kernel --check cut.pfm faint.exr
no '--check: too faint a light to show it' grep 'edge shows' out
run -k cut.pfm --layer l.exr --report r.json in.exr
like "$status $(cat err)" '0 *warning: cut.pfm: its edge shows*' \
    'a run warns of the edge'
is "$(field r.json 'len(o["warnings"])')" 2 'and its report does'
run -k small.exr -e direct --layer l.exr --report r.json in.exr
like "$status $(cat err)" \
    "0 *warning: small.exr: *% of its model's light falls in the frame*" \
    'a run warns of light that its file lacks'
is "$(field r.json 'o["kernel_left_out"] > o["kernel"]["missed"] + .01 > .02')" \
    True 'and reports it, with what falls beside the frame'
sums='abs(sum(f * (1 - o["kernel_left_out"]) for f in o["flux_in"]) / sum(o["flux_out"]) - 1)'
is "$(field r.json "$sums < 0.1")" True 'it is not scaled up'
run -k small.exr --kernel-normalize luminance -e direct --layer m.exr in.exr
no 'but with --kernel-normalize it is' "$glarepp" compare --no-flip \
    --fail-rel 0.01 l.exr m.exr
run -k whole.exr -e direct --layer l.exr --report r.json in.exr
quiet_success 'no warning of light that falls beside the frame'
is "$(field r.json 'o["kernel_left_out"] > .01, o["kernel"]["missed"]')" \
    '(True, 0.0)' 'which the report has'
# in a plane of the angle that has the same degrees in the middle
run --projection plane --fov 30.7047157005 --style eye --layer m.exr --report r.json \
    -e direct in.exr
quiet_success 'nor by the model itself'
is "$(field r.json 'o["kernel_left_out"] > .01, o["kernel"]["missed"], o["kernel"]["recipes"]')" \
    "(True, 0.0, ['spencer'])" 'which reports the same'
ok 'and the same layer' "$glarepp" compare --no-flip --fail-rel 1e-6 l.exr m.exr

# light outside of every frame of this size
run kernel --check moffat:beta=1.1
like "$status $(cat out)" '1 *30 % of the light that it takes from a pixel falls outside*' \
    "--check: light that misses the frame"
for k in moffat:beta=1.1 moffat:beta=1.1,share=1; do
    run kernel -k $k --size 64x48 -o far.exr
    for one in $k far.exr image:file=far.exr; do
        run --projection plane -k $one --layer l.exr --report r.json in.exr
        like "$status $(cat err)" \
            "0 *warning: $one: 3? % of the light that it takes from a pixel falls outside *" \
            "a run warns of light of $k that misses the frame: $one"
        is "$(wc -l <err)" 1 'in one line'
    done
done
is "$(field r.json 'o["kernel_left_out"] > .2, o["kernel"]["missed"]')" \
    '(True, 0.0)' 'the report has the share'
for k in eye eye-old cie moffat moffat:beta=1.3; do
    run -k $k --layer l.exr in.exr
    quiet_success "not where it is little: $k"
done
run -k eye --fov 0.5 --layer l.exr in.exr
like "$status $(cat err)" \
    '0 *warning: eye: * falls outside of the frame*' 'a narrow angle of view'
run -k moffat:beta=1.1 --layer 's.#.exr' 'sizes.#.exr'
is "$(grep -c 'falls outside' err)" 1 'once for all frames'

run kernel -k eye --size 64x48 --fov 30 -o narrow.exr
run -k narrow.exr --fov 60 --layer l.exr in.exr
like "$status $(cat err)" '0 *warning: narrow.exr: made for 0.6397 degrees a pixel, used at 1.378 (46.41%*set --kernel-size to that' \
    'a run warns of a kernel made for another angle'
run -k narrow.exr --fov 60 --kernel-size 46.41% --layer l.exr in.exr
no 'but not at the size it names' grep 'degrees a pixel' err
run -q -k narrow.exr --fov 60 --layer l.exr in.exr
quiet_success 'nor with -q'
run -k narrow.exr --fov 30 --layer l.exr in.exr
quiet_success 'nor at its own angle'
frame large.exr size=128x96
run -k whole.exr --layer l.exr large.exr
like "$status $(cat err)" "0 *% of its model's light falls in the frame*" \
    'a run warns of a kernel made for smaller frames'
run -k image:file=small.exr,share=.5 -k star --layer l.exr --report r.json in.exr
like "$status $(cat err)" \
    "0 *warning: image:file=small.exr,share=.5: *% of its model's light falls*" \
    'a run warns of one of several'

# a light outside of the frame lights all of it: 124 pixels are more than 63
run -k eye --fov 5 -t 1e9 --sun=-60,20,2 --sun-color 1e6,1e6,1e6 \
    --sun-outside visible --layer l.pfm in.exr
is "$("$python" - <<'PY'
import array
with open("l.pfm", "rb") as f:
    f.readline(), f.readline(), f.readline()
    v = array.array("f")
    v.frombytes(f.read())
print(min(v) > 0, max(v[63 * 3::64 * 3]) > 0.1 * max(v[32 * 3::64 * 3]))
PY
)" 'True True' 'a light beside the frame lights all of it'

run -k circle:share=1 --fov 1 --mix add --layer l.exr in.exr
like "$status $(cat err)" '0 *warning: circle:share=1: *use --mix scatter*' \
    'a run warns of defocus'
run -k circle:share=1 -k ring:share=1 --fov 1 --mix add --layer l.exr in.exr
like "$(cat err)" '*warning: circle:share=1 and ring:share=1: *--mix scatter*' \
    'of all kernels together'

done_testing
