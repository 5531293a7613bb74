#!/bin/sh
# glarepp compare: status and figures beside idiff's, files, sequences.
. "$(dirname "$0")/lib.sh"
need_python

# -- one pair of EXR files ---------------------------------------------------------

frame a.exr size=40x30 seed=1
frame b.exr size=40x30 seed=2
frame part.exr size=40x30 seed=1 part=depth:Z:float
frame deep.exr size=40x30 deep=1
frame z.exr size=40x30 channels=Z:float
frame id.exr size=40x30 channels=R,G,B,id:uint
frame far.exr size=40x30 seed=1 origin=100000000,0

run compare a.exr a.exr
quiet_success 'an image and itself'
like "$(head -1 out)" 'a.exr and a.exr: match' 'an image and itself: match'
ok 'an image and itself: no error' grep -q '^  max error    0$' out
ok 'an image and itself: FLIP is 0' grep -q '^  HDR-FLIP     0\.000000 ' out
run compare a.exr b.exr
status_is 2 'two images: status 2'
is "$(wc -c <err)" 0 'two images: no line on stderr'
like "$(head -1 out)" 'a.exr and b.exr: failure' 'two images: failure'
cp out first
for threads in 1 3; do
    run compare --threads $threads a.exr b.exr
    same first out "the same bytes with $threads threads"
done
run compare - b.exr <a.exr
sed 's/^- and/a.exr and/' out >piped
same first piped 'the first image from stdin'
run compare -q a.exr b.exr
is "$status $(wc -c <out)" '2 0' '-q: the status alone'
run compare --no-flip a.exr b.exr
no '--no-flip: no FLIP' grep -q FLIP out
run compare --flip-exposures -1,2,4 --json - a.exr b.exr
is "$(field out 'o["flip_exposures"], o["flip_kind"], 0 < o["flip"] < 1')" \
    "([-1.0, 2.0, 4], 'hdr', True)" '--flip-exposures'
run compare --json r.json a.exr b.exr
same first out '--json FILE: the text stays'
is "$(field r.json 'o["a"], o["b"], o["status"], o["result"], o["pixels"]')" \
    "('a.exr', 'b.exr', 2, 'failure', 1200)" '--json FILE'
run compare --json - a.exr b.exr
same out r.json '--json -: stdout is JSON alone'

run compare --heatmap h.png a.exr b.exr
is "$(png_size h.png)" '40x30 8 2' '--heatmap: a picture of the frame'
run compare --heatmap black.png a.exr a.exr
if [ -n "$oiio" ]; then
    is "$("$python" -c 'import OpenImageIO as o
print(max(o.ImageBuf("black.png").get_pixels(o.UINT8).flatten()) < 5,
      max(o.ImageBuf("h.png").get_pixels(o.UINT8).flatten()) > 100)')" 'True True' \
        '--heatmap: black without error, bright with it'
else
    skip 1 'no OpenImageIO for python'
fi

# -- limits -------------------------------------------------------------------------

for row in '--fail 1e9 --warn 1e9=0' '--fail 1e9=1' '--fail 1e9 --hardfail 1=2' \
    '--fail 1e9 --warn 1e9 --hardwarn 1=1' '--failpercent 100 --warnpercent 100=0' \
    '--failpercent 100=1' '--failrelative 2 --warnrelative 2=0' \
    '--failrelative 2=1'; do
    run compare --no-flip ${row%=*} a.exr b.exr
    status_is "${row##*=}" "${row%=*}: status ${row##*=}"
done

# -- parts, channels, deep data -------------------------------------------------------

run compare --no-flip part.exr part.exr
is "$status $(grep -c ': match$' out)" '0 2' 'each part is compared'
run compare --no-flip a.exr part.exr
is "$status $(grep -c '1 parts and 2' out)" '2 1' 'one part and two: status 2'
run compare a.exr z.exr
status_is 3 'no channel of one name: status 3'
run compare a.exr deep.exr
status_is 3 'flat and deep: status 3'
run compare deep.exr deep.exr
fails_with 4 deep.exr 'deep files'
run compare --no-flip id.exr id.exr
status_is 0 'uint32 channels'
run compare far.exr a.exr
fails_with 4 far.exr 'windows too far apart'

# -- sequences --------------------------------------------------------------------------

for i in 1 2 3; do
    cp a.exr s.000$i.exr
    cp a.exr t.000$i.exr
done
cp b.exr t.0002.exr
run compare --no-flip --json s.json s.####.exr t.####.exr
is "$status $(wc -l <out) $(wc -l <s.json)" '2 4 3' 'a sequence: a line each, the worst status'
like "$(tail -1 out)" '3 frames: failure, 2 match, 1 failure' 'a sequence: the summary'
is "$("$python" -c 'import json
print([(o["frame"], o["status"]) for o in map(json.loads, open("s.json"))])')" \
    '[(1, 0), (2, 2), (3, 0)]' 'a sequence: a row each in the JSON'
run compare --no-flip -f 1,3 s.####.exr t.####.exr
status_is 0 '--frames'
run compare --no-flip s.####.exr a.exr
status_is 0 'a sequence and one image'
run compare --heatmap m.####.png -f 1-2 s.####.exr t.####.exr
is "$(ls m.*.png | wc -l)" 2 'a heatmap each'
rm t.0003.exr
run compare --no-flip s.####.exr t.####.exr
fails_with 4 t.0003.exr 'a frame that only one has'
is "$(wc -l <out)" 4 'a frame that only one has: the others are compared'

# -- what makes no sense ------------------------------------------------------------------

run compare a.exr
fails_with 2 compare 'one image'
run compare a.exr b.exr id.exr
fails_with 2 id.exr 'three images'
run compare - -
fails_with 2 - 'stdin twice'
run compare --flip-exposures 0,1,1.5 a.exr b.exr
fails_with 2 --flip-exposures 'half an exposure'
run compare --no-flip --heatmap h.png a.exr b.exr
fails_with 2 --heatmap 'a heatmap without FLIP'
run compare -f 1-2 a.exr b.exr
fails_with 2 a.exr '--frames without a pattern'
run compare --heatmap h.png s.####.exr t.####.exr
fails_with 2 h.png 'one heatmap for a sequence'
run compare --heatmap - a.exr b.exr
fails_with 2 --heatmap 'a heatmap on stdout'
cp a.exr keep.exr
run compare --heatmap keep.exr keep.exr b.exr
fails_with 2 keep.exr 'a heatmap over an input'
run compare --json keep.exr b.exr keep.exr
fails_with 2 keep.exr 'JSON over an input'
same keep.exr a.exr 'the input is whole'
run compare --fail -1 a.exr b.exr
fails_with 2 --fail 'a negative limit'
run compare -k a.exr a.exr b.exr
fails_with 2 --kernel 'an option of pictures'
run --fail 1 -o x.png a.exr
fails_with 2 --fail 'a limit without compare'
run compare a.exr nowhere.exr
fails_with 4 nowhere.exr 'a file that is not there'
head -c 900 a.exr >cut.exr
run compare a.exr cut.exr
fails_with 4 cut.exr 'a file that is cut off'
run compare --json nowhere/r.json a.exr b.exr
fails_with 4 nowhere 'a folder that is not there'

# -- beside idiff ----------------------------------------------------------------------------

if [ -z "$oiio" ] || ! command -v idiff >/dev/null; then
    skip 60 'no idiff, or no OpenImageIO for python'
    done_testing
    exit
fi
cat >pairs.py <<'PY'
"""Makes pairs of images, runs idiff and compare on each, prints verdicts."""
import json, re, subprocess, sys
import numpy as np
import OpenImageIO as oiio

glarepp = sys.argv[1]
rng = np.random.default_rng(5)
nan, inf = np.nan, np.inf

def write(name, parts, kind="float"):
    specs, data = [], []
    for p in parts:
        a = np.ascontiguousarray(p["v"], np.float32)
        s = oiio.ImageSpec(a.shape[1], a.shape[0], a.shape[2], p.get("kind", kind))
        s.x, s.y = p.get("at", (0, 0))
        full = p.get("full", (s.x, s.y, a.shape[1], a.shape[0]))
        s.full_x, s.full_y, s.full_width, s.full_height = full
        if "names" in p:
            s.channelnames = p["names"]
        if len(parts) > 1:
            s.attribute("oiio:subimagename", "part%d" % len(specs))
        if "compression" in p:
            s.attribute("compression", p["compression"])
        specs.append(s)
        data.append(a)
    f = oiio.ImageOutput.create(name)
    assert f.open(name, specs if len(specs) > 1 else specs[0]), f.geterror()
    for i, a in enumerate(data):
        if i:
            f.open(name, specs[i], "AppendSubimage")
        assert f.write_image(a), f.geterror()
    f.close()

def figures(text):
    """Blocks of what idiff -v prints."""
    out = []
    for block in text.split("Mean error = ")[1:]:
        g = lambda p: re.search(p, block).group(1)
        f = {"mean": float(block.split()[0]), "rms": float(g(r"RMS error = (\S+)")),
             "psnr": float(g(r"Peak SNR = (\S+)")), "max": float(g(r"Max error  = (\S+)"))}
        at = re.search(r"@ \((-?\d+), (-?\d+), (\S+)\)", block)
        f["at"] = (int(at[1]), int(at[2]), at[3]) if at else None
        n = re.findall(r"(\d+) pixels", block)
        f["warned"], f["failed"] = int(n[0]), int(n[1])
        out.append(f)
    return out

def near(a, b):
    return a == b or abs(a - b) <= 2e-5 * abs(b)

def number(v):
    return inf if v is None else v

def run(a, b, options):
    theirs = subprocess.run(["idiff", "-v", "-a"] + options + [a, b],
                            capture_output=True, text=True)
    ours = subprocess.run([glarepp, "compare", "--no-flip", "--json", "-"] +
                          [o.replace("-", "--", 1) if o[0] == "-" else o
                           for o in options] + [a, b],
                          capture_output=True, text=True)
    rows = [json.loads(l) for l in ours.stdout.splitlines()]
    return theirs, ours, rows

def verdict(good, text, notes=""):
    print("ok" if good else "not ok", text)
    if not good:
        print("#", notes)

count = 0

def pair(name, a, b, *options, ending="exr", **key):
    global count
    count += 1
    files = ["p%02da.%s" % (count, ending), "p%02db.%s" % (count, ending)]
    for f, image in zip(files, (a, b)):
        write(f, image if isinstance(image, list) else [dict(v=image)], **key)
    theirs, ours, rows = run(*files, list(options))
    blocks = figures(theirs.stdout)
    good = theirs.returncode == ours.returncode and len(blocks) == len(
        [r for r in rows if "max" in r])
    for f, r in zip(blocks, rows):
        at = (r["worst"]["x"], r["worst"]["y"], r["worst"]["channel"]) if "worst" in r else None
        good = good and all(near(number(r[k]), f[k]) for k in ("mean", "rms", "psnr", "max")) \
            and at == f["at"] and (r["warned"], r["failed"]) == (f["warned"], f["failed"])
    verdict(good, "as idiff: " + name, "%s %s %s %s" % (theirs.returncode, ours.returncode,
                                                        blocks, rows))

def change(a, *changes):
    a = np.array(a)
    for y, x, c, v in changes:
        a[y, x, c] = v
    return a

base = rng.random((31, 47, 3)).astype(np.float32)
other = rng.random((31, 47, 3)).astype(np.float32)
hdr = (base * np.exp(9 * other)).astype(np.float32)
noisy = (hdr * (1 + 1e-3 * (base - .5))).astype(np.float32)
ones = base * 0 + 1
one = change(base, (3, 7, 1, base[3, 7, 1] + .25))
few = change(base, (3, 7, 1, 9), (3, 8, 1, 8), (30, 46, 2, -9))

pair("equal", base, base)
pair("one pixel", base, one)
pair("one pixel, other way", one, base)
pair("noise", base, other)
pair("high dynamic range", hdr, noisy)
pair("half", hdr, noisy, kind="half")
pair("negative", base, -3 * base)
pair("black and negative", base * 0, -3 * base)
pair("black", base * 0, base * 0)
pair("black and white", base * 0, ones)
pair("large", base * 1e30, other * 1e30)
pair("tiny", base * 1e-30, other * 1e-30)
pair("under the limit", base, base + np.float32(5e-7))
pair("NaN in both", change(base, (1, 2, 0, nan)), change(base, (1, 2, 0, nan)))
pair("NaN in both, an error elsewhere", change(base, (1, 2, 0, nan)),
     change(few, (1, 2, 0, nan)))
pair("Inf in both", change(base, (1, 2, 0, inf)), change(base, (1, 2, 0, inf)))
pair("-Inf in both", change(few, (0, 0, 2, -inf)), change(base, (0, 0, 2, -inf)))
pair("all NaN", ones * nan, ones * nan)
pair("NaN everywhere but one", change(ones * nan, (5, 5, 0, 1)),
     change(ones * nan, (5, 5, 0, 2)))
pair("1x1", base[:1, :1], other[:1, :1])
pair("1xN", base[:, :1], other[:, :1])
pair("Nx1", base[:1], other[:1])
pair("a row less", base, base[:-1])
pair("a row more", base[:-1], base)
pair("a column less", base, base[:, :-1])
pair("other sizes", base[:9, :40], other[:30, :7])
full = (0, 0, 60, 50)
win = lambda v, x, y, **k: [dict(v=v, at=(x, y), full=full, **k)]
pair("windows that meet", win(base, 0, 0), win(other, 10, 12))
pair("windows that do not meet", win(base[:9, :9], 0, 0), win(other[:9, :9], 30, 30))
pair("a window inside", win(base, 3, 4), win(base[2:9, 3:9], 6, 6))
pair("negative window", win(base, -20, -7), win(other, -25, 3))
pair("other display window", win(base, 0, 0), [dict(v=base, full=(0, 0, 99, 99))])
rgba = np.concatenate([base, other[..., :1]], 2)
pair("alpha", rgba, change(rgba, (4, 4, 3, 9)))
pair("alpha in one", base, rgba)
pair("alpha in the other", rgba, base)
pair("grey", base[..., :1], other[..., :1])
layers = ["R", "G", "B", "A", "N.X", "N.Y", "Z"]
many = np.concatenate([rgba, other], 2)
pair("layers", [dict(v=many, names=layers)], [dict(v=change(many, (1, 1, 5, 7)), names=layers)])
order = [3, 0, 6, 2, 1, 4, 5]
pair("channels written in another order", [dict(v=many, names=layers)],
     [dict(v=many[..., order], names=[layers[i] for i in order])])
for method in ("none", "rle", "piz", "zips", "dwaa"):
    pair("compression " + method, [dict(v=hdr, compression=method)],
         [dict(v=noisy, compression=method)], kind="half")
pair("two parts", [dict(v=base), dict(v=hdr)], [dict(v=base), dict(v=noisy)])
pair("three parts and two", [dict(v=base)] * 3, [dict(v=base)] * 2)
pair("--fail", base, one, "-fail", "0.3", "-warn", "0.3")
pair("--fail over some", base, few, "-fail", "8", "-warn", "1")
pair("--failpercent", base, few, "-failpercent", "1", "-warnpercent", "1")
pair("--failpercent, warning", base, few, "-failpercent", "1")
pair("--failpercent, failure", base, other, "-failpercent", "99.9")
pair("--hardfail", base, few, "-failpercent", "1", "-hardfail", "5")
pair("--hardwarn", base, few, "-failpercent", "1", "-warnpercent", "1", "-hardwarn", "5")
pair("--failrelative", hdr, noisy, "-failrelative", "2e-4", "-warnrelative", "4e-4")
pair("--failrelative, none", hdr, noisy, "-failrelative", "1e-2", "-warnrelative", "1e-2")
pair("PNG of 8 bits", base, one, ending="png", kind="uint8")
pair("PNG of 16 bits", base, one, ending="png", kind="uint16")
pair("TIFF of floats", hdr, noisy, ending="tif")
print("#", count, "pairs")

# where idiff 2.4 answers otherwise than its own documents, compare does not
def apart(name, a, b, wanted, *options):
    write("x.exr", [dict(v=a)])
    write("y.exr", [dict(v=b)])
    theirs, ours, rows = run("x.exr", "y.exr", list(options))
    verdict(ours.returncode == wanted, name, "idiff %d, compare %d" %
            (theirs.returncode, ours.returncode))
    return rows[0]

apart("a NaN against a number fails", base, change(base, (1, 2, 0, nan)), 2)
r = apart("many NaN against numbers fail", base, change(base, (1, 2, 0, nan), (9, 9, 1, inf)), 2)
verdict(r["nonfinite"] == 2 and r["mean"] == 0 and r["max"] is None,
        "values that are not finite stay out of the sums")
apart("Inf against -Inf fails", change(base, (1, 2, 0, inf)), change(base, (1, 2, 0, -inf)), 2)
apart("a warning where nothing fails", base, one, 1, "-fail", "1")
apart("--hardfail where nothing fails", base, one, 2, "-fail", "1", "-hardfail", "0.1")
PY
"$python" pairs.py "$glarepp" >verdicts 2>pairs.err ||
    { echo 'not ok pairs.py' >>verdicts; note "$(tail -5 pairs.err)"; }
verdicts verdicts
ok 'at least 40 pairs' sh -c 'test "$(grep -c "^ok as idiff" verdicts)" -ge 40'

done_testing
