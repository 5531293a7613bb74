#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Files that hold several views, --views: what each eye becomes, and what --hdr
# carries. The truth is a run on that eye alone.
# shellcheck disable=SC2016
. "$(dirname "$0")/lib.sh"
need_python
[ -n "$oiio" ] || skip_all "no python3 with OpenImageIO to make stereo files"
no_provenance

# Questions of the tests about files:
#   make N           s.N.exr, parts rgba.left, rgba.right and depth of both; of
#                    the same eyes m.N.exr, one multiView part; and left.N.exr
#                    and right.N.exr, each eye alone
#   pixels A B       colour of A's part or view `a` and of B is the same
#   carried A B C..  all channels of both but those named are the same bits,
#                    and those named differ
cat >stereo.py <<'EOF'
import numpy
import OpenImageIO as oiio

W, H = 48, 32

def eye(seed, hot):
    rng = numpy.random.default_rng(seed)
    v = (rng.random((H, W, 5)) * 0.6).astype(numpy.float16)
    for _ in range(hot):
        y, x = rng.integers(0, H), rng.integers(0, W)
        v[y, x, :3] = rng.random(3) * 300
    return v.astype(numpy.float32)

def spec(names, **attributes):
    s = oiio.ImageSpec(W, H, len(names), "half")
    s.channelnames = names
    for k, v in attributes.items():
        if k == "views":
            s.attribute("multiView", oiio.TypeDesc("string[2]"), v)
        else:
            s.attribute(k.replace("_", ":"), v)
    s.attribute("compression", "zip")
    return s

def save(path, parts):
    o = oiio.ImageOutput.create(path)
    specs = [s for s, _ in parts]
    assert o.open(path, specs), o.geterror()
    for i, (s, v) in enumerate(parts):
        assert i == 0 or o.open(path, s, "AppendSubimage"), o.geterror()
        assert o.write_image(numpy.ascontiguousarray(v)), o.geterror()
    o.close()

def make(n):
    n = int(n)
    left, right = eye(n, 9), eye(n + 100, 0 if n == 3 else 7)
    colour = ["R", "G", "B", "A"]
    save("s.%d.exr" % n, [
        (spec(colour, oiio_subimagename="rgba.left", view="left"), left[..., :4]),
        (spec(colour, oiio_subimagename="rgba.right", view="right"), right[..., :4]),
        (spec(["Z"], oiio_subimagename="depth.left", view="left"), left[..., 4:]),
        (spec(["Z"], oiio_subimagename="depth.right", view="right"), right[..., 4:])])
    names = colour + ["right." + c for c in colour] + ["Z", "right.Z", "id.X"]
    save("m.%d.exr" % n, [(spec(names, views=("left", "right")), numpy.concatenate(
        (left[..., :4], right[..., :4], left[..., 4:], right[..., 4:], left[..., 4:]),
        axis=2))])
    save("left.%d.exr" % n, [(spec(colour), left[..., :4])])
    save("right.%d.exr" % n, [(spec(colour), right[..., :4])])

def load(path):
    i = oiio.ImageInput.open(path)
    out, part = {}, 0
    while i.seek_subimage(part, 0):
        s = i.spec()
        at = s.getattribute("oiio:subimagename") or ""
        for c, name in enumerate(s.channelnames):
            kind = str(s.channelformat(c))
            v = i.read_image(part, 0, c, c + 1, kind)
            out[at + "/" + name] = kind, numpy.ascontiguousarray(v).tobytes()
        part += 1
    return out

def pixels(a, prefix, b):
    p, q = load(a), load(b)
    for c in "RGB":
        assert p[prefix + c] == q["/" + c], c + " of " + prefix

def carried(a, b, *but):
    p, q = load(a), load(b)
    assert sorted(p) == sorted(q), (sorted(p), sorted(q))
    for name in p:
        if name.startswith(but):
            assert p[name] != q[name] or name.endswith("A"), name
            assert not name.endswith("A") or p[name] == q[name], name
        else:
            assert p[name] == q[name], name + " is not what it was"
EOF
answers stereo.py

for n in 1 2 3; do
    ask make $n || { echo "Bail out! no stereo files"; exit 1; }
    for eye in left right; do
        "$glarepp" -q -e fft --hdr alone.$eye.$n.exr --layer layer.$eye.$n.exr \
            -o alone.$eye.$n.png $eye.$n.exr || exit 1
    done
done

# -- one file ------------------------------------------------------------------

# fresh: an empty folder `made`
fresh()
{
    rm -rf made && mkdir made
}

for kind in s m; do
    case $kind in
    s) about='parts' left=rgba.left/ right=rgba.right/ depths='depth.left.Z depth.right.Z' ;;
    m) about='multiView' left=/ right=/right. depths='Z right.Z' ;;
    esac
    fresh
    run -e fft --views left,right --hdr made/h.exr -o 'made/%V.png' \
        --layer 'made/l.%v.exr' --report r.json $kind.1.exr
    quiet_success "$about: both eyes"
    is "$(ls made | xargs)" 'h.exr l.l.exr l.r.exr left.png right.png' \
        "$about: the files"
    for eye in left right; do
        same made/$eye.png alone.$eye.1.png "$about: the $eye picture is that of the eye alone"
        ok "$about: so is the $eye layer" "$glarepp" compare --fail 0 --warn 0 \
            "made/l.$(printf %.1s $eye).exr" layer.$eye.1.exr
    done
    ok "$about: --hdr, the left eye" ask pixels made/h.exr $left alone.left.1.exr
    ok "$about: --hdr, the right eye" ask pixels made/h.exr $right alone.right.1.exr
    ok "$about: --hdr carries the rest" ask carried $kind.1.exr made/h.exr \
        ${left}R ${left}G ${left}B ${right}R ${right}G ${right}B
    is "$(sed 's/.*"view":"\([a-z]*\)".*/\1/' r.json | xargs)" 'left right' \
        "$about: a line of the report for each"
    is "$(field r.json 'o["outputs"]')" \
        "['made/h.exr', 'made/l.l.exr', 'made/left.png']" \
        "$about: the first has the file of both"
    is "$(sed 's/.*"channel": *"\([A-Za-z.]*\)".*/\1/' r.json | xargs)" "$depths" \
        "$about: each with its own depth"
    run -e fft --views right --hdr made/d.exr --depth "${depths#* }" --report r.json \
        $kind.1.exr
    quiet_success "$about: a depth by name, which nothing reads"
    is "$(field r.json 'o["depth"]["channel"], o["depth"]["type"]')" \
        "('${depths#* }', 'half')" "$about: is told"

    run -e fft --views left,right --hdr 'made/h.%V.exr' $kind.1.exr
    quiet_success "$about: --hdr with %V"
    ok "$about: --hdr with %V, left" ask pixels made/h.left.exr $left alone.left.1.exr
    ok "$about: --hdr with %V, left: right stays" ask carried $kind.1.exr \
        made/h.left.exr ${left}R ${left}G ${left}B
    ok "$about: --hdr with %V, right" ask pixels made/h.right.exr $right alone.right.1.exr
    ok "$about: --hdr with %V, right: left stays" ask carried $kind.1.exr \
        made/h.right.exr ${right}R ${right}G ${right}B

    fresh
    run -e fft --views right -o 'made/o.%V.png' $kind.1.exr
    quiet_success "$about: one eye"
    same made/o.right.png alone.right.1.png "$about: one eye: its bytes"
    run -e fft --layer-in right -o made/in.png $kind.1.exr
    same made/in.png alone.right.1.png "$about: --layer-in right is that eye"

    # -- without --views ---------------------------------------------------------

    # by_default DESCRIPTION ARGUMENT...: status 0 and one line that names both
    by_default()
    {
        description=$1
        shift
        run -e fft "$@"
        status_is 0 "$description"
        is "$(wc -l <err)" 1 "$description: one line"
        like "$(cat err)" "*$kind.1.exr: *left, right*" "$description: says the views"
    }
    fresh
    by_default "$about: without --views" --hdr made/h.exr -o made/o.png \
        --layer made/l.exr --layer 'made/l.%V.exr' --report r.json $kind.1.exr
    like "$(cat err)" "*made/l.exr *left; *%V *" \
        "$about: without --views: says which output has only the first"
    is "$(field r.json '["glarepp: warning: " + w for w in o["warnings"]]')" \
        "['$(cat err)']" "$about: without --views: and in the report"
    run -q -e fft --views left,right --hdr made/given.exr $kind.1.exr
    same made/h.exr made/given.exr "$about: without --views: --hdr has glare in both"
    same made/o.png alone.left.1.png "$about: without --views: -o shows the first"
    same made/l.exr made/l.left.exr "$about: without --views: so does --layer"
    ok "$about: without --views: %V has each" "$glarepp" compare --fail 0 --warn 0 \
        made/l.right.exr layer.right.1.exr
    is "$(sed 's/.*"view":"\([a-z]*\)".*/\1/' r.json | xargs)" 'left right' \
        "$about: without --views: a line of the report for each"
    fresh
    by_default "$about: -o alone" -o made/o.png --report r.json $kind.1.exr
    same made/o.png alone.left.1.png "$about: -o alone shows the first"
    is "$(wc -l <r.json)" 1 "$about: -o alone computes no other"
    by_default "$about: %V by default" -o 'made/%V.png' $kind.1.exr
    same made/right.png alone.right.1.png "$about: %V by default: the right eye"
    run -q -e fft --views all --hdr made/all.exr $kind.1.exr
    run -q -e fft --hdr made/none.exr $kind.1.exr
    same made/all.exr made/none.exr "$about: --views all is the default"
    run -e fft --layer-in right --hdr made/r.exr $kind.1.exr
    quiet_success "$about: a layer of one view"
    ok "$about: a layer of one view: left stays" ask carried $kind.1.exr \
        made/r.exr ${right}R ${right}G ${right}B
    fresh
    by_default "$about: a sequence by default" --hdr 'made/h.#.exr' -o 'made/o.#.png' \
        "$kind.#.exr"
    is "$(ls made | xargs)" 'h.1.exr h.2.exr h.3.exr o.1.png o.2.png o.3.png' \
        "$about: a sequence by default: the files"
    run -q -e fft --views left,right --hdr made/given.exr $kind.2.exr
    same made/h.2.exr made/given.exr "$about: a sequence by default: both eyes"
    rm made/h.2.exr
    run -q -e fft --no-clobber --hdr 'made/h.#.exr' -o 'made/o.#.png' "$kind.#.exr"
    same made/h.2.exr made/given.exr "$about: --no-clobber makes what is missing"
    cat $kind.1.exr $kind.2.exr >two.exr
    "$glarepp" -q -e fft --stdout-format png -o - --hdr 'made/p.#.exr' - <two.exr >pngs
    cat alone.left.1.png alone.left.2.png >want
    same pngs want "$about: a pipe by default: the first eye of each frame"
    same made/p.2.exr made/given.exr "$about: a pipe by default: --hdr has both"
    mkdir made/left made/right
    "$glarepp" -q -e fft -o 'made/%V/%#.png' - <two.exr
    same made/right/%2.png alone.right.2.png "$about: a pipe by default: %V"

    # -- sequences -------------------------------------------------------------

    fresh
    run -e fft --views right,left --hdr 'made/h.#.exr' -o 'made/o.%V.#.png' \
        --report r.json "$kind.#.exr"
    quiet_success "$about: a sequence"
    is "$(sed 's/.*"frame":\([0-9]*\),"view":"\(.\).*/\1\2/' r.json | xargs)" \
        '1r 1l 2r 2l 3r 3l' "$about: a sequence: frame by frame, in the list's order"
    differ=
    for n in 1 2 3; do
        for eye in left right; do
            cmp -s made/o.$eye.$n.png alone.$eye.$n.png || differ="$differ $eye.$n"
        done
    done
    is "$differ" '' "$about: a sequence: each eye as alone"
    mkdir again
    for row in '1 1' '3 2' '7 3' '64 8'; do
        rm -rf again && mkdir again
        set -- $row
        "$glarepp" -e fft --frame-jobs "$1" --threads "$2" --views right,left \
            --hdr 'again/h.#.exr' -o 'again/o.%V.#.png' "$kind.#.exr"
        ok "$about: --frame-jobs $1 --threads $2: the same bytes" \
            diff -r made again
    done
    rm -rf again

    # -- going on, and streams -------------------------------------------------

    rm made/o.left.2.png
    cp alone.right.1.png made/o.left.1.png
    run -e fft --no-clobber --views right,left --hdr 'made/h.#.exr' \
        -o 'made/o.%V.#.png' "$kind.#.exr"
    status_is 0 "$about: --no-clobber"
    same made/o.left.2.png alone.left.2.png "$about: --no-clobber makes what is missing"
    same made/o.left.1.png alone.right.1.png "$about: --no-clobber leaves what is there"
    cat $kind.1.exr $kind.2.exr | "$glarepp" -e fft --views left,right \
        --stdout-format png -o - - >pngs
    cat alone.left.1.png alone.right.1.png alone.left.2.png alone.right.2.png >want
    same pngs want "$about: frames of a pipe, eye by eye"
    "$glarepp" -e fft --views left,right --hdr - $kind.1.exr >stream.exr
    "$glarepp" -e fft --views left,right --hdr file.exr $kind.1.exr
    same stream.exr file.exr "$about: --hdr to stdout holds both"
done

# -- refusals ------------------------------------------------------------------

fresh
run --views left,right -o 'made/o.%V.png' --hdr made/h.exr left.1.exr
fails_with 2 left.1.exr 'a file without views'
empty_folder made 'a file without views: makes nothing'
run -o 'made/o.%V.png' left.1.exr
fails_with 2 'o.%V.png' '%V for a file without views'
empty_folder made '%V for a file without views: makes nothing'
run --views all -o 'made/o.png' left.1.exr
quiet_success '--views all of a file without views'
frame slash.exr size=24x16 attr=multiView:stringvector:left,/x \
    channels=R,G,B,/x.R,/x.G,/x.B
run -o 'made/o.%V.png' slash.exr
fails_with 4 slash.exr 'a view that is a path'
is "$(ls made)" o.png 'a view that is a path: makes nothing'
run -q --hdr made/h.exr slash.exr
quiet_success 'a view that is a path: --hdr needs no name of it'
rm made/h.exr
run -q --report r.json s.1.exr
is "$(wc -l <r.json)" 2 'only a report: a line for each view'
mkfifo pipe
cat s.1.exr >pipe &
run --hdr made/h.exr pipe
fails_with 2 pipe 'views of a named pipe are not known before'
wait $!
rm made/o.png
run --hdr 'made/h.#.exr' left.1.exr s.2.exr
fails_with 2 s.2.exr 'a second file with views'
like "$(cat err)" '*--views*' 'a second file with views: the line says what to do'
fresh
run --views left,middle -o 'made/o.%V.png' --hdr made/h.exr s.1.exr
fails_with 2 s.1.exr 'a view that is not there'
like "$(cat err)" '*left*right*' 'a view that is not there: the line lists those that are'
empty_folder made 'a view that is not there: makes nothing'
mkdir mixed
cp s.1.exr mixed/f.1.exr
cp left.2.exr mixed/f.2.exr
cp m.3.exr mixed/f.3.exr
run -e fft --views left,right --skip-bad-frames --hdr 'made/h.#.exr' \
    -o 'made/o.%V.#.png' --report r.json 'mixed/f.#.exr'
status_is 6 'one file of a sequence lacks them'
is "$(ls made | xargs)" \
    'h.1.exr h.3.exr o.left.1.png o.left.3.png o.right.1.png o.right.3.png' \
    'one file of a sequence lacks them: the others are made'
is "$(grep -c '"error"' r.json)" 2 'one file of a sequence lacks them: a line an eye'
like "$(tail -n 1 err)" '*1 of 3 *(2)*' \
    'one file of a sequence lacks them: it counts as one frame'
same made/o.right.3.png alone.right.3.png 'parts and multiView in one sequence'

# -- files of others -----------------------------------------------------------

if [ -z "$data" ]; then
    skip 7 "$no_data"
else
    ball=$data/depth/Beachball_multipart.0001.exr
    fresh
    run -e fft -t 0.4 --views left,right --hdr made/h.exr -o 'made/%V.png' "$ball"
    quiet_success 'Beachball, ten parts'
    "$glarepp" -e fft -t 0.4 --part rgba_right -o part.png "$ball"
    same made/right.png part.png 'Beachball: the right eye is that part'
    run -e fft -t 0.1 --views left,right -o 'made/fog.%V.png' \
        "$data/multiview/Fog_Y_2views.exr"
    quiet_success 'Fog, two views of Y in one part'
    # one part with both eyes: at 962 a thing stands before the right one alone,
    # at 1217 before the left
    for row in '962 left 1.0' '962 right 0.0' '1217 left 0.0' '1217 right 1.0'; do
        set -- $row
        run -e fft --sun "$1,265,2" --sun-color 1000 --views "$2" --report r.json \
            "$data/depth/Beachball_singlepart.0001.exr"
        like "$(cat r.json)" "*\"visibility\":$3*" "depth of the $2 eye at $1"
    done
fi

done_testing
