#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Light, and the way it goes: no step at the threshold, no light made or
# lost, no finite value changed, and a line where there is no light.
. "$(dirname "$0")/lib.sh"
need_python

cat >light.py <<'PY'
import array, math, sys

def write(path, w, h, value):
    v = array.array("f")
    for y in range(h - 1, -1, -1):
        for x in range(w):
            v.extend(value(x, y))
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (w, h) + v.tobytes())

def read(path):
    b = open(path, "rb").read()
    _, size, _, data = b.split(b"\n", 3)
    v = array.array("f")
    v.frombytes(data)
    return v, int(size.split()[0])

what, args = sys.argv[1], sys.argv[2:]
if what == "make":
    write("ramp.pfm", 400, 40, lambda x, y: [0.8 + 0.001 * x] * 3)
    write("spot.pfm", 540, 540, lambda x, y: [70.] * 3
          if 260 <= x < 270 and 265 <= y < 268 else [0.] * 3)
    write("sun.pfm", 40, 40, lambda x, y: [250000., 200000., 150000.]
          if x == 9 and y == 9 else [0.5] * 3)
    write("huge.pfm", 40, 40, lambda x, y: [3e38] * 3
          if x == 9 and y == 9 else [0.5] * 3)
    write("over.pfm", 40, 40, lambda x, y: [3.4e38] * 3)
    write("lamps.pfm", 64, 64, lambda x, y: [2. ** 118] * 3
          if (7 * x + 3 * y) % 29 == 0 else [0.] * 3)
elif what == "step":  # largest jump of output over input between neighbours
    (a, w), (b, _) = read(args[0]), read(args[1])
    at = 3 * w * 20
    r = [b[at + 3 * x] / a[at + 3 * x] for x in range(w)]
    print(max(abs(q / p - 1) for p, q in zip(r[100:299], r[101:300])) < 0.02)
elif what == "sum":
    y = [sum(w * sum(v[c::3]) for c, w in enumerate((.2126, .7152, .0722)))
         for v, _ in map(read, args)]
    print(abs(y[1] / y[0] - 1) < 1e-5)
elif what == "nearest":  # halfs of the second to floats of the first
    a, b = (read(n)[0] for n in args)
    step = lambda n: 2. ** (max(math.frexp(n)[1] - 1, -14) - 10)
    noise = 1e-9 * max(a)
    print(len(a) == len(b) and all(abs(p - q) <= step(p) / 2 + 1e-5 * p + noise
                                   for p, q in zip(a, b)))
elif what == "brightest":  # pixel, in 1/1000 of its largest channel
    v = read(args[0])[0]
    i = v.index(max(v)) // 3 * 3
    print("%.5g" % max(v), [round(1000 * n / max(v)) for n in v[i:i + 3]])
elif what == "tinted":  # R,G,B S LAYER ITS-TINTED-ONE FRAME ITS-TINTED-ONE
    tint, s = [float(n) for n in args[0].split(",")], float(args[1])
    a, b, lit, other = (read(n)[0] for n in args[2:])
    good = max(a) > 1
    for i in range(0, len(a), 3):
        y = sum(w * n for w, n in zip((.2126, .7152, .0722), a[i:i + 3]))
        for c in range(3):
            want = max(tint[c] * (y + s * (a[i + c] - y)), 0)
            good &= abs(b[i + c] - want) <= 1e-6 * (want + y)
            more = other[i + c] - lit[i + c] - (b[i + c] - a[i + c])
            good &= abs(more) <= 1e-6 * max(lit[i + c], other[i + c], 1)
    print(good)
elif what == "finite":
    v = read(args[0])[0]
    print(all(abs(n) <= 3.4028235e38 for n in v) and max(v) > 1e35)
elif what == "largest":
    v = read(args[0])[0]
    print((min(v), max(v)))
elif what == "near":
    print(all(abs(n - float(args[0])) < 1e-4 for n in read(args[1])[0]))
PY
"$python" light.py make
frame k.exr kind=kernel size=9x9 type=float

# out NAME INPUT OPTION...: the frame with glare, as a PFM
out()
{
    out=$1 in=$2
    shift 2
    run --tonemap none "$@" -o "$out.pfm" "$in.pfm"
}

out plain ramp
is "$("$python" light.py step ramp.pfm plain.pfm)" True 'no step at the threshold'
out whole ramp --threshold-mode whole --mix add
is "$("$python" light.py step ramp.pfm whole.pfm)" False \
    'a step with --threshold-mode whole and --mix add'
for kernel in star streak:length=5 cross:length=5 circle ring gaussian; do
    # they end inside the frame
    out spot.glare spot -e direct --fov 15 -k $kernel
    is "$("$python" light.py sum spot.pfm spot.glare.pfm)" True \
        "$kernel: white light keeps its luminance"
done
out sun.0 sun -g 0
same sun.0.pfm sun.pfm 'a float sun stays as it is'

# -- the colour of the layer ---------------------------------------------------

# with flare and lens; what scatters leaves its pixel as before
for mix in add scatter; do
    lights="--mix $mix -e fft --flare preset:zoom --lens heliar --sun 20,15,2.5
        --sun-color 2e4,1e4,5e3"
    # shellcheck disable=SC2086
    out tint.no sun $lights --verify --report r.json --layer l.no.pfm
    for row in '1,.5,.25 1' '1,1,1 0' '.9,1,2 2.5'; do
        tint=${row% *} s=${row#* }
        # shellcheck disable=SC2086
        out tint.yes sun $lights --tint "$tint" --layer-saturation "$s" \
            --layer l.yes.pfm --verify --report t.json
        status_is 0 "--mix $mix --tint $tint --layer-saturation $s"
        is "$("$python" light.py tinted "$tint" "$s" l.no.pfm l.yes.pfm \
            tint.no.pfm tint.yes.pfm)" True '... its formula, in layer and picture'
        # shellcheck disable=SC2086
        "$glarepp" -q $lights --tint "$tint" --layer-saturation "$s" \
            --layer l.only.pfm sun.pfm
        same l.yes.pfm l.only.pfm '... the layer by itself'
        is "$(field t.json 'o["measured"], o["bound"]')" \
            "$(field r.json 'o["measured"], o["bound"]')" \
            '... the errors are those of the layer before'
    done
    # shellcheck disable=SC2086
    out tint.one sun $lights --tint 1,1,1 --layer-saturation 1 --layer l.one.pfm
    same l.no.pfm l.one.pfm "--mix $mix --tint 1,1,1 --layer-saturation 1: nothing"
done
for wrong in '--tint 1,2' '--tint 1,-1,1' '--layer-saturation 11'; do
    # shellcheck disable=SC2086
    run $wrong --layer l.pfm sun.pfm
    fails_with 2 "${wrong% *}" "$wrong"
done

# brightest FILE: the brightest pixel of an EXR and its hue
brightest()
{
    "$glarepp" -q -g 0 --tonemap none -o back.pfm "$1"
    "$python" light.py brightest back.pfm
}

# a half is the nearest to each float, but for what halves hide: fft is in float for
# them, and in double for floats where noise would be seen
for type in float half; do
    for engine in direct fft; do
        run -e $engine -k ring --type $type --hdr l.exr spot.pfm
        "$glarepp" -q -g 0 --tonemap none -o l.$type.$engine.pfm l.exr
    done
done
for engine in direct fft; do
    is "$("$python" light.py sum spot.pfm l.float.$engine.pfm) $("$python" \
        light.py nearest l.float.$engine.pfm l.half.$engine.pfm)" 'True True' \
        "$engine: --hdr keeps its light, in half each value's nearest"
done

run --no-provenance -g 0 --type half --hdr h.exr -o o.exr --tonemap none --report r.json sun.pfm
is "$(brightest h.exr)" '65504 [1000, 800, 600]' '--type half: a sun keeps its hue'
same h.exr o.exr '--type half: so does -o'
like "$(cat err)" '*: --type half *7[0-9.]* % * red *(1 *65504); *--type float*' \
    '--type half: says what that costs'
is "$(field r.json 'o["clamped_out"], o["flux_clamped"][0], len(o["warnings"])')" \
    '(6, 368992.0, 2)' '--type half: so does the report'
frame glow.exr kind=zeros size=40x30 type=half hot=60000
for mix in add scatter; do
    run -q --mix $mix -g 1 --sun 20,15,2.5 --sun-color 2e6,1.9e6,1.6e6 \
        --hdr h.exr -o o.exr --tonemap none --report r.json glow.exr
    quiet_success "--mix $mix: a frame of half with a sun over 65504"
    run -q --type float --mix $mix -g 1 --sun 20,15,2.5 \
        --sun-color 2e6,1.9e6,1.6e6 --hdr f.exr glow.exr
    ok "--mix $mix: is written as float" "$glarepp" compare --fail 0 --no-flip \
        h.exr f.exr
    ok "--mix $mix: -o too" "$glarepp" compare --fail 0 --no-flip o.exr f.exr
    is "$(field r.json '"clamped_out" in o')" False "--mix $mix: nothing is clamped"
done
for engine in direct fft; do
    out huge.$engine huge -e $engine
    is "$status $("$python" light.py finite huge.$engine.pfm)" '0 True' \
        "$engine: light of 3e38 stays finite"
done
for engine in direct fft splat; do # a kernel of sum over 1
    run -e $engine -k k.exr --kernel-normalize none --layer over.l.pfm \
        --report r.json over.pfm
    like "$status $(cat err)" \
        '0 *over.pfm: the layer overflows and has no bound *' \
        "$engine: a layer over the largest float: one line"
    is "$("$python" light.py largest over.l.pfm) $(field r.json 'o["bound"]')" \
        '(3.4028234663852886e+38, 3.4028234663852886e+38) None' \
        "$engine: it is that float everywhere, and has no bound"
done
# a frame with its glare over the largest float: the line counts the samples
frame over.exr size=32x24 type=float hot=1e36
for threads in 1 2; do
    run -g 1e6 --threads $threads --hdr over.hdr.exr over.exr
    like "$status $(cat err)" \
        '0 *over.exr: [1-9]* samples overflow with their glare (limited to *); *' \
        "a composite over the largest float, $threads threads"
    cp err err.$threads
done
same err.1 err.2 'a composite over the largest float: the same count'
run -g 1e3 --hdr over.hdr.exr glow.exr
quiet_success 'a composite over half alone: written as float, no line'
for engine in direct fft auto; do # light over 2^80 is halved on its way
    run --projection plane -e $engine --mix add -k builtin:eye --tolerance-pixel 1e-4 --verify \
        --layer l.pfm --report r.json lamps.pfm
    is "$status $(field r.json \
        'o["measured"]["max_rel"] <= o["bound_pixel"] < 1e9 * o["measured"]["max_rel"]')" \
        '0 True' "$engine: light over 2^80 keeps bound_pixel"
done
is "$(field r.json 'o["bound_pixel"] <= 1e-4')" True \
    'light over 2^80: auto keeps --tolerance-pixel'
out metered over -g 0 --auto-exposure --tonemap linear
is "$("$python" light.py near 0.18 metered.pfm)" True \
    '--auto-exposure: an even 3.4e38 becomes the key'
run --report r.json -t 95% --layer l.exr ramp.pfm
is "$(field r.json 'o["sources"], round(o["threshold"], 4)')" '(800, 1.179)' \
    '--threshold 95%: the rest is over it'
run --report r.json -t +0.1ev --layer l.exr ramp.pfm
is "$(field r.json '1.06 < o["threshold"] < 1.075')" True '--threshold +0.1ev'
run -t 5 --layer l.exr ramp.pfm
like "$status $(cat err)" '0 *no pixel is over the threshold 5 (brightest 1.2 at 399,0)*' \
    'no light: one line, status 0'
if [ -n "$data" ]; then
    f=$data/seq_foliage/foliage_f32.1001.exr
    run -g 0 --report r.json --hdr h.exr "$f"
    ok 'foliage_f32 keeps its light' "$glarepp" compare --fail 0 --no-flip "$f" h.exr
else
    skip 1 "$no_data"
fi

# Frames whose light crosses T = 1 smoothly: picture over frame, the median of
# [1, 1.02) over that of [0.98, 1). What remains with T at 0.9, on the same
# pixels, is the veil of other light, not the threshold.
cat >step.py <<'PY'
import subprocess, sys
import numpy as np, OpenImageIO as oiio

program, path, *words = sys.argv[1:]

def picture(name, *more): # a name each: OpenImageIO keeps what it has read
    subprocess.run([program, "-q", "--tonemap", "none", "-e", "fft", "--type",
                    "float", "-o", name, *more, path], check=True)
    return np.maximum(oiio.ImageBuf(name).get_pixels(oiio.FLOAT)[..., :3], 0) \
        @ np.array([.2126, .7152, .0722])

y = picture("plain.exr", "-g", "0")
over, under = (y >= 1) & (y < 1.02), (y >= 0.98) & (y < 1)
step = []
for t in "1", "0.9":
    r = picture(t + ".exr", "-t", t, *words) / np.where(y > 0, y, 1)
    step.append(np.median(r[over]) / np.median(r[under]) - 1)
print("%d pixels: %.4f" % (min(over.sum(), under.sum()), step[0] - step[1]))
sys.exit(int(abs(step[0] - step[1]) > 0.02))
PY
if [ -n "$data" ] && [ -n "$oiio" ]; then
    for f in sky/aristea_wreck_puresky_1k windows/Desk night/GoldenGate \
        seq_foliage/foliage.1004 rendered/brightsky.1001 rendered/window.1001; do
        ok "$f: no step at the threshold" "$python" step.py "$glarepp" \
            "$data/$f.exr"
    done
    no 'the whole pixel, added: a step' "$python" step.py "$glarepp" \
        "$data/sky/aristea_wreck_puresky_1k.exr" --threshold-mode whole --mix add
else
    skip 7 "no numpy and OpenImageIO, or $no_data"
fi
done_testing
