#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Light groups: --light-group takes the light from layers whose sum is the
# frame, each held against the threshold by itself, and --hdr keeps the sum.
# shellcheck disable=SC2016
. "$(dirname "$0")/lib.sh"
need_python
[ -n "$oiio" ] || skip_all "no python3 with OpenImageIO to compare pixels"

# Questions of the tests about files:
#   make FILE HOW  beauty = key + rim + fill in floats, with A and Z; HOW is
#                  plain, dark (rim has no light), nan (rim has one NaN),
#                  huge (a pixel of 3e38 in each), parts (rim and fill in parts
#                  of their own), colon (rim is called rim:b), or window (rim's
#                  part is smaller)
#   sums SUM A...  layer SUM is that of the others within 1e-6 rel_l2
#   grown IN OUT   what OUT has more than IN: the colour has as much more as
#                  the layers, key and rim have some, all else has its bits
#   same A B L..   layers L of A and B have the same bits
#   apart LAYER PARTS KEY RIM LIGHT  layers key and rim of PARTS are KEY and RIM,
#                  all layers together are LAYER; "a sun" is in veil and core
#   total LAYER PARTS  all layers of PARTS together are LAYER
#   energy IN OUT  sums of colour and layers, --mix scatter: the light inside
#                  the frame did not become more
cat >light.py <<'EOF'
import numpy
import OpenImageIO as oiio

W, H = 64, 48

def lamp(seed, n, top):
    rng = numpy.random.default_rng(seed)
    v = rng.random((H, W, 3)) * 0.3
    for _ in range(n):
        y, x = rng.integers(H // 4, H - H // 4), rng.integers(W // 4, W - W // 4)
        v[y:y + 2, x:x + 2] += rng.random(3) * top
    return v.astype(numpy.float32)

def part(planes, name):
    names = list(planes)
    h, w = planes[names[0]].shape
    s = oiio.ImageSpec(w, h, len(names), "float")
    s.channelnames = names
    s.attribute("compression", "zip")
    s.attribute("oiio:subimagename", name)
    s.full_width, s.full_height = W, H
    return s, numpy.stack(list(planes.values()), axis=2).astype(numpy.float32)

def make(path, how):
    light = {"key": lamp(1, 6, 200), "rim": lamp(2, 4, 900), "fill": lamp(3, 5, 50)}
    if how == "dark":
        light["rim"] = lamp(2, 0, 0)
    if how == "huge":
        for v in light.values():
            v[20, 30] = 3e38
    beauty = numpy.minimum(sum(v.astype(float) for v in light.values()), 3.4e38)
    if how == "nan":
        light["rim"][20, 30] = numpy.nan
    rgb = dict(zip("RGB", numpy.moveaxis(beauty, 2, 0)))
    rgb["A"] = numpy.full((H, W), 0.5)
    rgb["Z"] = numpy.arange(W * H).reshape(H, W) * 0.25
    split, aside = how in ("parts", "window"), []
    if how == "colon":
        light["rim:b"] = light.pop("rim")
    for name, v in light.items():
        prefix = "" if split and name != "key" else name + "."
        planes = {prefix + c: p for c, p in zip("RGB", numpy.moveaxis(v, 2, 0))}
        if not prefix:
            planes["mask"] = numpy.ones((H, W))
            if how == "window" and name == "rim":
                planes = {c: p[:, 1:] for c, p in planes.items()}
            aside.append(part(planes, name))
        else:
            rgb.update(planes)
    parts = [part(rgb, "beauty")] + aside
    if how == "named":  # primaries, of ACES
        parts[0][0].attribute("chromaticities", "float[8]",
                              (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767))
    o = oiio.ImageOutput.create(path)
    assert o.open(path, [s for s, _ in parts]), o.geterror()
    for i, (s, v) in enumerate(parts):
        assert i == 0 or o.open(path, s, "AppendSubimage")
        assert o.write_image(numpy.ascontiguousarray(v)), o.geterror()
    o.close()

def load(path):
    """Channels by layer.C, those of parts that are not the first too."""
    i, out, n = oiio.ImageInput.open(path), {}, 0
    assert i, path
    while i.seek_subimage(n, 0):
        s = i.spec()
        v = i.read_image(n, 0, 0, s.nchannels, "float")
        for c, name in enumerate(s.channelnames):
            layer = s.getattribute("oiio:subimagename") if n else ""
            out[(layer + "." if layer else "") + name] = v[:, :, c]
        n += 1
    return out

def colour(planes, layer):
    prefix = layer + "." if layer else ""
    return numpy.stack([planes[prefix + c] for c in "RGB"]).astype(numpy.float64)

def sums(whole, *parts):
    a = colour(load(whole), "")
    b = sum(colour(load(p), "") for p in parts)
    assert numpy.linalg.norm(b) > 1
    error = numpy.linalg.norm(a - b) / numpy.linalg.norm(b)
    assert error < 1e-6, error

def whole(path):
    p = load(path)
    a, b = colour(p, ""), sum(colour(p, n) for n in ("key", "rim", "fill"))
    assert numpy.abs(a - b).max() <= 2e-3 * numpy.abs(a).max()

def grown(before, after, *dark):
    p, q = load(before), load(after)
    assert sorted(p) == sorted(q)
    more = {n: colour(q, n) - colour(p, n) for n in ("", "key", "rim", "fill")}
    for n in ("key", "rim"):
        assert (numpy.abs(more[n]).max() > 0.1) == (n not in dark), n
    parts = more["key"] + more["rim"]
    assert numpy.linalg.norm(parts) > 1
    error = numpy.linalg.norm(more[""] - parts) / numpy.linalg.norm(parts)
    assert error < 1e-5, error
    for n in p:
        if n[0] not in "RGB" and n.split(".")[0] not in ("key", "rim"):
            assert p[n].tobytes() == q[n].tobytes(), n
        if n.endswith(("A", "Z", "mask")):
            assert p[n].tobytes() == q[n].tobytes(), n

def times(gain, a, b, layer=""):
    """A layer of b is that of a times the gain."""
    p, q = colour(load(a), layer) * float(gain), colour(load(b), layer)
    assert p.any() and numpy.abs(p - q).max() <= 1e-6 * numpy.abs(p).max()

def same(a, b, *layers):
    p, q = load(a), load(b)
    for n in layers:
        assert colour(p, n).tobytes() == colour(q, n).tobytes(), n

def differ(a, b, layer):
    assert colour(load(a), layer).tobytes() != colour(load(b), layer).tobytes()

def apart(layer, parts, key, rim, light):
    p, whole = load(parts), colour(load(layer), "")
    own = {n: colour(p, n) for n in sorted({c.split(".")[0] for c in p})}
    assert list(own) == ["core", "flare", "ghosts", "key", "rim", "veil"], own
    error = numpy.linalg.norm(sum(own.values()) - whole) / numpy.linalg.norm(whole)
    assert error < 1e-6, error
    for n, file in ("key", key), ("rim", rim):
        alone = colour(load(file), "")
        assert alone.any() and numpy.abs(own[n] - alone).max() <= 1e-6 * alone.max(), n
    rest = [numpy.linalg.norm(own[n]) / numpy.linalg.norm(whole) for n in ("veil", "core")]
    assert all((v > 1e-5) == (light == "a sun") for v in rest), rest

def total(layer, parts):
    p, whole = load(parts), colour(load(layer), "")
    both = sum(colour(p, n) for n in {c.rsplit(".", 1)[0] for c in p})
    error = numpy.linalg.norm(both - whole) / numpy.linalg.norm(whole)
    assert error < 1e-6, error

def energy(before, after, most):
    p, q = load(before), load(after)
    for n in ("", "key", "rim"):
        a, b = colour(p, n).sum(), colour(q, n).sum()
        assert 0 < 1 - b / a < float(most), (n, 1 - b / a)

def clean(path, most="inf"):
    assert max(abs(v).max() for v in load(path).values()) <= float(most)
    assert all(numpy.isfinite(v).all() for v in load(path).values())
EOF
answers light.py
for how in plain dark nan huge parts window; do
    ask make $how.exr $how || { echo "Bail out! no frames"; exit 1; }
done
both='--light-group key --light-group rim'

# -- the layer -----------------------------------------------------------------

for file in plain dark parts; do
    for engine in fft direct; do
        about="$file, $engine"
        run -e $engine $both --type float --layer both.exr --report r.json $file.exr
        quiet_success "$about: two groups"
        for n in key rim; do
            "$glarepp" -q -e $engine --layer-in $n --type float --layer $n.exr $file.exr
        done
        ok "$about: their layer is the sum of each one's" ask sums both.exr \
            key.exr rim.exr
        is "$(field r.json 'o["light_groups"]')" "['key', 'rim']" "$about: the report"
    done
    run -e fft --light-group key --type float --layer one.exr $file.exr
    "$glarepp" -q -e fft --layer-in key --type float --layer key.exr $file.exr
    ok "$file: one group alone" ask sums one.exr key.exr
done

run --light-group rim --type float --layer l.exr --report r.json dark.exr
like "$(cat err)" '*dark.exr: *threshold 1 (*0.295 at 27,31)*' \
    'a group without light: one line, about the group'
is "$(field r.json 'o["engine"]')" none 'a group without light: no glare, whatever beauty holds'
run -e fft $both --layer l.exr --report r.json nan.exr
status_is 0 'NaN in a group'
is "$(field r.json 'o["nonfinite"]')" 1 'NaN in a group: counted'
ok 'NaN in a group: none in the layer' ask clean l.exr
for engine in direct fft splat; do
    run -e $engine -k builtin:star $both --type float --hdr h.exr --layer l.exr \
        --report r.json huge.exr
    is "$status $(field r.json '2e38 < o["flux_in"][1] < 3.41e38')" '0 True' \
        "$engine: groups whose sum is over the largest float"
    ok "$engine: it stays finite" ask clean h.exr 3.41e38
    ok "$engine: so does the layer" ask clean l.exr 3.41e38
done
run -e fft --report r.json --layer l.exr plain.exr
is "$(field r.json '"light_groups" in o')" False 'no groups: not in the report'

# each against the threshold by itself: 900 is over what key has, not rim
run -e direct -t 250 $both --type float --layer both.exr plain.exr
"$glarepp" -q -e direct -t 250 --layer-in rim --type float --layer rim.exr plain.exr
ok 'thresholds hold for each group by itself' ask same both.exr rim.exr ''

# -- the frame -----------------------------------------------------------------

for file in plain dark parts; do
    dark=
    [ $file != dark ] || dark=rim
    run -e fft $both --type float --hdr h.exr $file.exr
    quiet_success "$file: --hdr"
    ok "$file: --hdr: what the groups get is what the frame gets, no more" \
        ask grown $file.exr h.exr $dark
    run -e fft $both --mix scatter --type float --hdr s.exr $file.exr
    quiet_success "$file: --hdr, scatter"
    ok "$file: --hdr, scatter: the same" ask grown $file.exr s.exr $dark
done
# builtin:eye reaches far: a 17x17 kernel keeps all light of the middle inside
frame k.exr kind=kernel size=17x17 type=float
ask make plain.exr plain
run -q -e direct -k k.exr --mix scatter $both --type float --hdr s.exr plain.exr
quiet_success 'scatter with a small kernel'
ok 'scatter gains no light, and loses what leaves the frame' ask energy \
    plain.exr s.exr 0.1
for threads in 1 2 5; do
    for jobs in 1 3; do
        "$glarepp" --threads $threads --frame-jobs $jobs $both --hdr "t.$threads.$jobs.exr" plain.exr
        ok "--threads $threads --frame-jobs $jobs: the same bytes" cmp \
            t.1.1.exr "t.$threads.$jobs.exr"
    done
done
run -e fft $both --hdr h1.exr --layer l1.exr -o o1.png plain.exr
run -e fft $both --layer l2.exr -o o2.png plain.exr
same l1.exr l2.exr 'the layer is the same without --hdr'
same o1.png o2.png 'so is the picture'
run -e fft $both --hdr n.exr nan.exr
status_is 0 'NaN in a group: --hdr'

# groups of frames before do not stay
mkdir seq
cp plain.exr seq/f.1.exr
cp dark.exr seq/f.2.exr
cp parts.exr seq/f.3.exr
run $both --hdr 'seq/h.#.exr' -o 'seq/o.#.png' 'seq/f.#.exr'
quiet_success 'a sequence'
for n in 1 2 3; do
    "$glarepp" $both --hdr h.exr -o o.png seq/f.$n.exr
    same seq/h.$n.exr h.exr "a sequence: frame $n as alone"
done

# -- kernels and gains of groups -----------------------------------------------

# alike "WORD..." "OTHER-WORD..." DESCRIPTION: the same files are made
alike()
{
    rm -f a.exr ah.exr b.exr bh.exr
    # shellcheck disable=SC2086
    "$glarepp" -q --no-provenance $1 --layer a.exr --hdr ah.exr -o a.png plain.exr
    # shellcheck disable=SC2086
    "$glarepp" -q --no-provenance $2 --layer b.exr --hdr bh.exr -o b.png plain.exr
    ok "$3" sh -c 'cmp a.exr b.exr && cmp ah.exr bh.exr && cmp a.png b.png'
}
for e in '-e fft --projection plane' '-e direct --mix add --projection plane' \
    '-e fft --edges mirror -g 2 --projection plane'; do
    for k in star cross:share=.2,points=6,length=5 builtin:eye; do
        alike "$e -k $k --light-group key" "$e --light-group key:kernel=$k" \
            "$e: a group by $k is a run of -k $k"
    done
    alike "$e $both" "$e --light-group key:gain=1 --light-group rim" \
        "$e: a gain of 1 is none"
    alike "$e -k star $both" "$e -k star --light-group key:kernel=star
        --light-group rim:gain=1,kernel=star" "$e: the kernel of -k is no other"
    for how in key:kernel=ring,gain=3 rim:gain=.25,kernel=star fill fill:gain=0; do
        # shellcheck disable=SC2086
        "$glarepp" -q $e --light-group "$how" --type float \
            --layer "$how.exr" plain.exr
    done
    for how in key:kernel=ring rim:kernel=star; do
        # shellcheck disable=SC2086
        "$glarepp" -q $e --light-group $how --type float --layer one.exr plain.exr
        [ $how != key:kernel=ring ] || ok "$e: gain 3" ask times 3 one.exr \
            key:kernel=ring,gain=3.exr
        [ $how != rim:kernel=star ] || ok "$e: gain .25" ask times .25 one.exr \
            rim:gain=.25,kernel=star.exr
    done
    # shellcheck disable=SC2086
    run $e --light-group key:kernel=ring,gain=3 --light-group fill \
        --light-group rim:gain=.25,kernel=star --type float --layer both.exr \
        --verify --tolerance-pixel 1e-2 --report r.json plain.exr
    quiet_success "$e: three kernels"
    ok "$e: their layer is the sum of each one's" ask sums both.exr \
        key:kernel=ring,gain=3.exr fill.exr rim:gain=.25,kernel=star.exr
    is "$(field r.json '0 < o["measured"]["rel_l2"] <= o["bound"] < 1e-4')" True \
        "$e: all of it is measured, within the bound"
    is "$(field r.json '0 < o["measured"]["max_rel"] <= o["bound_pixel"] < 1e-2')" \
        True "$e: ... and within the pixel's"
    # shellcheck disable=SC2086
    run $e --light-group key:kernel=ring,gain=3 --light-group rim:gain=.25 \
        --type float --hdr h.exr plain.exr
    ok "$e: --hdr: what the groups get is what the frame gets, no more" \
        ask grown plain.exr h.exr
done
is "$(field r.json 'o["group_glare"]')" "[{'name': 'key', 'kernel': 'ring', 'gain': 3.0}, {'name': 'fill', 'gain': 1.0}, {'name': 'rim', 'kernel': 'star', 'gain': 0.25}]" \
    'the report has kernels and gains'
is "$(field r.json 'o["light_groups"], o["settings"]["light_group"][0]')" \
    "(['key', 'fill', 'rim'], 'key:kernel=ring,gain=3')" '... names and words'
# gains of group and frame are one: both move the light that they give
for gain in .5 2; do
    "$glarepp" -q -e direct --light-group key --type float -g 1 --hdr a.exr plain.exr
    "$glarepp" -q -e direct --light-group key:gain=$gain --type float \
        -g "$("$python" -c "print(1 / $gain)")" --hdr b.exr plain.exr
    ok "scatter: gain $gain of a group and 1/$gain of the frame" ask times 1 \
        a.exr b.exr
    ok '... and of the group' ask times 1 a.exr b.exr key
done
own='--light-group key:kernel=star,gain=1.5 --light-group rim:kernel=ring'

# -- what each spreads, in --parts ---------------------------------------------

printf '[{"shape": "disc", "source": "bright", "position": -0.5, "size": 0.2,
    "color": 0.1}]' >image.json
sun='--depth none --sun 30,20,2 --sun-color 900'
for how in '-e fft' '-e direct --tint 1,.5,.2 --layer-saturation .4' \
    '--flare image.json --flare-gain 2'; do
    # shellcheck disable=SC2086
    {
        "$glarepp" -q $how --light-group key:kernel=star,gain=1.5 --type float \
            --layer key.exr plain.exr
        "$glarepp" -q $how --light-group rim:kernel=ring --type float \
            --layer rim.exr plain.exr
        run $how $own --type float --parts p.exr --layer l.exr --hdr h.exr plain.exr
        quiet_success "$how: --parts"
        ok "$how: a layer for each group, and all add up" ask apart l.exr p.exr \
            key.exr rim.exr none
        run $how $own $sun --type float --parts p.exr --layer l.exr plain.exr
        ok "$how: the light of a sun is in no group" ask apart l.exr p.exr \
            key.exr rim.exr 'a sun'
    }
done
run --light-group veil --parts p.exr plain.exr
is "$status $(cat err)" "2 glarepp: --parts: it has a layer veil of its own; give the light group another name" \
    'a group that is called like a part'
for how in key:kernel=star,gain=2 key:gain=2,kernel=cie key:kernel=k.exr,gain=.5; do
    "$glarepp" -q --light-group $how -o a.png plain.exr
    run -q --settings a.png -o b.png plain.exr
    quiet_success "--settings of --light-group $how"
    same a.png b.png "--settings of --light-group $how: the same picture"
done
run --light-group key --light-group key:gain=2 --layer l.exr plain.exr
is "$status $(cat err)" '2 glarepp: --light-group: a layer is there twice (found key); name it once' \
    'a group twice'
# shellcheck disable=SC2086
run -q -e fft $own --layer-saturation 3 --parts p.exr --type float --layer l.exr plain.exr
ok 'parts add up where a saturation leaves less than nothing' ask total l.exr p.exr
# shellcheck disable=SC2086
{
    "$glarepp" -q -t 1e9 --type half --hdr half.exr plain.exr
    run -q -e fft $own --parts p.exr half.exr
    run -q -e fft $own --type float --layer l.exr half.exr
    ok '... and without --type, as floats, of halfs' ask total l.exr p.exr
}

# shellcheck disable=SC2086
{
    "$glarepp" -q $own --threads 1 --hdr t1.exr --layer l1.exr plain.exr
    "$glarepp" -q $own --threads 3 --frame-jobs 2 --hdr t2.exr --layer l2.exr plain.exr
    same t1.exr t2.exr 'kernels of groups: the same bytes on three threads'
    same l1.exr l2.exr '... and the same layer'
    "$glarepp" -q $own $sun --type float --layer both.exr plain.exr
    "$glarepp" -q $own --type float --layer a.exr plain.exr
    "$glarepp" -q --light-group fill:gain=0 $sun \
        --type float --layer b.exr plain.exr
    ok 'the kernel of -k spreads the sun' ask sums both.exr a.exr b.exr
    run -e fft $own --type float --hdr h.exr --layer l.exr huge.exr
    ok 'kernels of groups: what overflows stays finite' ask clean h.exr 3.41e38
    ok '... in the layer too' ask clean l.exr 3.41e38
    run $own --verify --debug sensors=s.png --report r.json --layer l.exr dark.exr
    is "$status $(field r.json 'o["measured"]["rel_l2"] <= o["bound"]')" '0 True' \
        'a kernel without light'
    run $own --hdr 'seq/h.#.exr' 'seq/f.#.exr'
    quiet_success 'kernels of groups in a sequence'
    "$glarepp" $own --hdr h.exr seq/f.3.exr
    same seq/h.3.exr h.exr '... frame 3 as alone'
}
mkdir folder && frame folder/k.exr kind=kernel size=17x17 type=float
alike '-k folder/k.exr --light-group key' '--light-group key:kernel=folder/k.exr' \
    'an image as the kernel of a group'
run --light-group key:gain=2,kernel=folder/k.exr \
    --light-group rim:kernel=image:file=folder/k.exr,share=.5,gain=2 \
    --layer l.exr --report r.json plain.exr
like "$(field r.json 'o["command"]')" \
    '*key:gain=2,kernel=k.exr *rim:kernel=image:file=k.exr,share=.5,gain=2 *' \
    '... its folder is not in the command'
run --light-group key:kernel=folder/k.exr --layer folder/k.exr plain.exr
fails_with 2 folder/k.exr '... no output replaces it'
ask make colon.exr colon
"$glarepp" -q --light-group rim:b --layer a.exr colon.exr
"$glarepp" -q --light-group rim:b:gain=1 --layer b.exr colon.exr
"$glarepp" -q --light-group rim --layer c.exr plain.exr
ok 'a colon in the name of a layer' ask same a.exr b.exr ''
ok '... which is that layer' ask same a.exr c.exr ''

# -- refusals ------------------------------------------------------------------

# wrong STATUS NAME DESCRIPTION ARGUMENT...
wrong()
{
    wanted=$1 name=$2 about=$3
    shift 3
    rm -rf made && mkdir made
    run "$@" --hdr made/h.exr --layer made/l.exr
    fails_with "$wanted" "$name" "$about"
    empty_folder made "$about: makes nothing"
}
wrong 2 plain.exr 'no such layer' --light-group key --light-group nix plain.exr
like "$(cat err)" '*nix*fill, key, rim*' 'no such layer: the line lists those there are'
for how in key:gain=x key:gain=-1 key:gain=nan key:gain=1,gain=2 :gain=2 \
    key:kernel= key:kernel=star,gain=2,gain=3 key:gain=2,x=1 key:gain=1e7; do
    wrong 2 "$how" "no kernel or gain: $how" --light-group "$how" plain.exr
done
wrong 2 cross 'a wrong key of a kernel' --light-group key:kernel=cross:no=1 plain.exr
wrong 3 sttar 'no such kernel' --light-group key:kernel=sttar plain.exr
wrong 4 window.exr 'a group of another window' $both window.exr
ask make named.exr named
run $both --light-group fill --ocio "$cli/aces.ocio" --output-space lin709 --gain 0 \
    --hdr whole.exr named.exr
ok 'groups have the primaries of their frame' ask whole whole.exr
frame ids.exr 'channels=R,G,B,CryptoObject00.R:float,CryptoObject00.G:float,CryptoObject00.B:float,CryptoObject00.A:float'
wrong 2 ids.exr 'ids as a group' --light-group CryptoObject00 ids.exr
"$glarepp" -q -o in.png plain.exr
wrong 2 in.png 'groups of a PNG' --light-group key in.png
cp ids.exr seq/f.4.exr
rm -f seq/h.*
run $both --skip-bad-frames --hdr 'seq/h.#.exr' 'seq/f.#.exr'
status_is 6 'a frame without the groups, skipped'
is "$(cd seq && ls h.* | xargs)" 'h.1.exr h.2.exr h.3.exr' \
    'a frame without the groups: the others are made'

done_testing
