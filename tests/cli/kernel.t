#!/bin/sh
# Kernels: models by the frame's angle, several at once, images of any size, and
# the command that writes, lists and checks them.
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr seed=3
frame k.exr kind=kernel size=16x12 type=float

# -- angle ---------------------------------------------------------------------

run --fov 48 --layer l.exr --report r.json in.exr
quiet_success '--fov'
is "$(field r.json 'o["deg_per_pixel"], o["fov_from"]')" "(1.0, 'option')" \
    '--fov: degrees of a pixel of 48 lines'
run --layer l.exr --report r.json in.exr
is "$(field r.json 'o["deg_per_pixel"], o["fov_from"]')" "(0.625, 'default')" \
    'no --fov: 30 degrees high'
run -k k.exr --layer l.exr --report r.json in.exr
is "$(field r.json '"deg_per_pixel" in o')" False 'an image has no angle'

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

if sys.argv[1] == "make":
    for n in 1, 2:
        v = array.array("f")
        for y in range(30 * n):
            for x in range(40 * n):
                lamp = (x // n * 13 + y // n * 7) % 97 == 0
                v.extend([90., 60., 30.] if lamp else [0.2] * 3)
        with open("scene.%d.pfm" % n, "wb") as f:
            f.write(b"PF\n%d %d\n-1.0\n" % (40 * n, 30 * n) + v.tobytes())
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

run kernel -k eye --size 16384x16384 -o big.exr
status_is 4 'a kernel over --max-pixels: status 4'
no 'and it is not there' test -e big.exr
run -k star --kernel-normalize luminance -o o.png in.exr
status_is 2 'a model is not normalised: usage'
like "$(cat err)" '*--kernel-normalize*leave it out*' 'and a line says so'

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
run -k k.exr --kernel-size 22.5deg -e direct --layer b.exr --report r.json \
    --grow kernel in.exr
is "$(field r.json 'o["deg_per_pixel"], o["width"]')" '(0.625, 111)' \
    'degrees: an angle, and a reach of 25 and 22 pixels'
run -k k.exr --kernel-size 22.5deg -e direct --layer b.exr in.exr
ok 'degrees and percent of one size' "$glarepp" compare --fail-rel 1e-6 \
    --no-flip a.exr b.exr

# -- glarepp kernel ------------------------------------------------------------

run kernel -k cie:age=70 -k star:share=.05 -k image:file=k.exr,share=.1 \
    --size 96x54 --fov 20 --rotate 10 -o a.exr
quiet_success 'kernel -o'
run kernel --from a.exr -o b.exr
same a.exr b.exr '--from: the same bytes'
run kernel --from k.exr -o b.exr
fails_with 4 k.exr '--from a file without a recipe'
run kernel --from a.exr -o a.exr
fails_with 2 a.exr '--from a file that would be replaced'
run kernel -k eye --size 64x48 --threads 1 -o a.exr
run kernel -k eye --size 64x48 --threads 2 -o b.exr
same a.exr b.exr 'the same bytes for any number of threads'
run -k eye -e direct --layer l.exr in.exr
run -k a.exr --kernel-normalize none -e direct --layer m.exr in.exr
ok 'the file makes the layer of its model' "$glarepp" compare --fail-rel 1e-6 \
    --no-flip l.exr m.exr
run kernel -k eye -o a.png
fails_with 2 a.png 'a kernel is an EXR file'
run kernel --list
quiet_success '--list'
is "$(grep -c '^[a-z]*: ' out)" "$(grep -c 'share=' out)" \
    '--list: each model has a share'
for model in spencer cie star cross streak ring circle gaussian moffat image; do
    grep -q "^$model: " out || echo $model
done >missing
is "$(cat missing)" '' '--list: every model'

# -- faults --------------------------------------------------------------------

# a cut kernel, one that fades to 0, a negative lobe, and half a pixel beside
for kind in cut fade lobe beside; do
    "$python" - $kind <<'PY'
import array, math, sys
kind = sys.argv[1]
n = 16 if kind == "beside" else 15
v = array.array("f")
for y in range(n):
    for x in range(n):
        d = math.hypot(x - (n - 1) / 2, y - (n - 1) / 2)
        a = 1 / (1 + d * d) if kind == "cut" else max(1 - d / 7.5, 0) ** 2
        v.extend([-1e-3 if kind == "lobe" and d == 2 else a] * 3)
with open(kind + ".pfm", "wb") as f:
    f.write(b"PF\n%d %d\n-1.0\n" % (n, n) + v.tobytes())
PY
    run kernel --check $kind.pfm
    [ $kind = fade ] && wanted=0 || wanted=1
    status_is $wanted "--check: $kind"
    is "$(grep -c '^fault: ' out)" $wanted "--check: faults of $kind"
done
frame nan.exr kind=nan size=9x9
run kernel --check nan.exr
status_is 1 '--check: NaN'
like "$(cat out)" '*3 samples are NaN or infinite*' '--check: how many'
run kernel --check fade.pfm
like "$status $(cat out)" '0 *own pixel  3.388 %*' '--check: own pixel'
run kernel --check circle:share=1 --mix add --size 200x200
like "$status $(cat out)" '1 *use --mix scatter*' '--check: defocus with add'
run kernel --check eye --radius 30
like "$status $(cat out)" "1 *% of the model's light is outside*" \
    "--check: a model's share outside"
run kernel -k eye --radius 30 -o small.exr
run kernel --check small.exr
like "$status $(cat out)" "1 *% of the model's light is outside*" \
    "--check: a file's share outside"
run kernel --check cut.pfm in.exr
like "$status $(cat out)" '1 *edge shows*' "--check: by a frame's light"
frame faint.exr kind=dark
run kernel --check cut.pfm faint.exr
like "$status $(cat out)" '0 *' '--check: too faint a light to show it'
run -k cut.pfm --layer l.exr --report r.json in.exr
like "$status $(cat err)" '0 *warning: cut.pfm: its edge shows*' \
    'a run warns of the edge'
is "$(field r.json 'len(o["warnings"])')" 1 'and its report does'
run -k circle:share=1 --fov 1 --mix add --layer l.exr in.exr
like "$status $(cat err)" '0 *--kernel: *use --mix scatter*' \
    'a run warns of defocus'

done_testing
