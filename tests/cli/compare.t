#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# glarepp compare: command line, status and figures beside idiff's, files, sequences.
. "$(dirname "$0")/lib.sh"
need_python

# -- one pair of EXR files ---------------------------------------------------------

frame a.exr size=40x30 seed=1
frame b.exr size=40x30 seed=2
frame part.exr size=40x30 seed=1 part=depth:Z:float
frame deep.exr size=40x30 deep=1
deep='size=40x30 deep=5 channels=R,G,A,Z:float,id:uint origin=3,-4 kind=dark'
frame d1.exr $deep
frame d2.exr $deep zips=1
frame d3.exr $deep seed=2
frame d4.exr $deep more=7,9
frame d5.exr size=40x30 deep=5 channels=R,G,A,Z:float,id:uint origin=4,-4 kind=dark
frame z.exr size=40x30 channels=Z:float
frame uv.exr size=40x30 channels=u:float,v:float
frame id.exr size=40x30 channels=R,G,B,id:uint
frame far.exr size=40x30 seed=1 origin=100000000,0

run compare a.exr a.exr
quiet_success 'an image and itself'
is "$(head -1 out)" 'Comparing "a.exr" and "a.exr"' 'an image and itself: their names'
ok 'an image and itself: no error' grep -q '^  Max error  = 0$' out
ok 'an image and itself: FLIP is 0' grep -q '^  HDR-FLIP = 0\.000000 ' out
is "$(tail -1 out)" PASS 'an image and itself: PASS'
for escape in '\033[31m' '\302\233[31m' '\233[31m'; do
    name=$(printf "$escape").exr
    cp a.exr "$name"
    run compare "$name" a.exr
    is "$(LC_ALL=C tr -d '\n -~' <out | wc -c)" 0 "compare prints no $escape"
    run compare "$name" none.exr "$(printf "$escape")"
    is "$(LC_ALL=C tr -d '\n -~' <err | wc -c)" 0 "no line holds $escape"
done
run compare a.exr b.exr
status_is 2 'two images: status 2'
is "$(wc -c <err)" 0 'two images: no line on stderr'
is "$(tail -1 out)" FAILURE 'two images: FAILURE'
cp out first
for threads in 1 3; do
    run compare --threads $threads a.exr b.exr
    same first out "the same bytes with $threads threads"
done
run compare - b.exr <a.exr
sed 's/"-" and/"a.exr" and/' out >piped
same first piped 'the first image from stdin'
run compare -q a.exr b.exr
is "$status $(wc -c <out) $(cat err)" '2 0 FAILURE' '-q: only FAILURE, on stderr as of idiff'
run compare -q a.exr a.exr
is "$status $(cat out err)" '0 ' '-q: nothing where the images match'
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

# with the word of the last line; nothing over --fail passes, whatever --warn says
while read -r wanted word options; do
    run compare --no-flip $options a.exr b.exr
    is "$status $(tail -1 out)" "$wanted $word" "$options: status $wanted, $word"
    one=$(echo " $options" | sed 's/ --/ -/g')
    run compare --no-flip $one a.exr b.exr
    is "$status $(tail -1 out)" "$wanted $word" "$one, with one dash"
done <<'END'
0 PASS --fail 1e9 --warn 1e9
0 PASS --fail 1e9
0 PASS --fail 1e9 --hardfail 1 --hardwarn 1
0 PASS --fail inf
1 WARNING --failpercent 100 --hardwarn 1 --warnpercent 100
2 FAILURE --failpercent 100 --hardfail 1
0 PASS --failpercent 100 --warnpercent 100
1 WARNING --failpercent 100
0 PASS --failrelative 2
2 FAILURE --allowfailures 1199
0 PASS --allowfailures 1200
END
for row in '--fail-rel 10=0' '--fail-rel 1e-3=2' '--fail-rel 10 --fail 1e-3=2' \
    '--fail-flip 1=0' '--fail-flip 1e-3=2' '--fail-flip 1 --fail-rel 1e-3=2'; do
    run compare ${row%=*} a.exr b.exr
    status_is "${row##*=}" "${row%=*}: status ${row##*=}"
done
run compare --fail-flip 0.5 uv.exr uv.exr
status_is 3 '--fail-flip without colour: status 3'
run compare -p uv.exr uv.exr
status_is 3 '-p without colour: status 3'

# -- the picture of the difference ------------------------------------------------------

run compare -q -o d.exr a.exr b.exr
run compare -q -o back.exr b.exr a.exr
run compare -q -abs -scale 2 -o twice.exr a.exr b.exr
run compare -q -od -o no.exr a.exr a.exr
no '-od: no picture of equal images' test -e no.exr
run compare -q -od -o yes.exr a.exr b.exr
ok '-od: the picture of images that differ' "$glarepp" compare --fail 0 d.exr yes.exr
run compare -q -o zero.exr id.exr id.exr
is "$("$glarepp" compare -v zero.exr zero.exr | grep -c 'Max error  = 0')" 1 \
    '-o: a picture of equal images too'
run compare -q -o black.exr d.exr d.exr
run compare -q -abs -o once.exr a.exr b.exr
run compare -q -o half.exr -scale -0.5 d.exr back.exr
run compare -fail 0 half.exr back.exr
is "$status" 0 '-o: A - B is B - A but for its sign'
run compare -q -o sum.exr -abs -scale 2 d.exr black.exr
run compare -fail 0 sum.exr twice.exr
is "$status" 0 '-abs -scale 2: twice its magnitude'
run compare -o d.png a.exr b.exr
is "$(png_size d.png)" '40x30 8 2' '-o: PNG'
# unwritable STATUS ARGUMENT...: the statuses where idiff cannot write -o, but
# that a match without the picture is none
unwritable()
{
    wanted=$1
    shift
    run compare -q -o nodir/d.exr "$@"
    status_is "$wanted" "-o nodir/d.exr $*"
}
unwritable 2 a.exr b.exr
is "$(grep -c '^glarepp: nodir/d.exr: ' err)" 1 '-o nodir/d.exr: a line'
unwritable 0 -od a.exr a.exr
unwritable 4 a.exr a.exr
run compare -q -failpercent 150 -warnpercent 1e3 a.exr b.exr
status_is 0 '-failpercent 150: all pixels may fail'
run compare -q -allowfailures -1 a.exr b.exr
status_is 0 '-allowfailures -1: all pixels may fail'


# -- parts, channels, deep data -------------------------------------------------------

run compare --no-flip -a part.exr part.exr
is "$status $(grep -c 'Max error  = 0' out)" '0 2' '-a: each part is compared'
run compare --no-flip a.exr part.exr
is "$status $(grep -c '^Only compared the first part (of 1 and 2' out)" '0 1' \
    'without -a only the first part, and a line says so'
run compare --no-flip -a a.exr part.exr
is "$status $(grep -c '1 parts and 2' out)" '2 1' '-a: one part and two: status 2'
tiff2() # FILE GREY: a TIFF of two 8-bit images of 4x4, the second of that grey
{
    python3 - "$1" "$2" <<'END'
import struct, sys
def image(grey, at, last):
    tags = [(256, 4), (257, 4), (258, 8), (259, 1), (262, 1), (273, at + 102),
            (277, 1), (279, 16)]
    return (struct.pack('<H', len(tags)) +
            b''.join(struct.pack('<HHII', t, 4, 1, v) for t, v in tags) +
            struct.pack('<I', last) + bytes([grey] * 16))
first = image(9, 8, 126)
open(sys.argv[1], 'wb').write(b'II*\0' + struct.pack('<I', 8) + first +
                              image(int(sys.argv[2]), 126, 0))
END
}
tiff2 t1.tif 9
tiff2 t2.tif 99
run compare --no-flip t1.tif t2.tif
is "$status $(grep -c '^Only compared the first part (of 2 and 2' out)" '0 1' \
    'a TIFF of two images: the first alone'
run compare --no-flip -a t1.tif t2.tif
is "$status $(tail -1 out)" '2 FAILURE' 'a TIFF of two images: -a compares both'
run compare --no-flip -a t1.tif t1.tif
is "$status $(grep -c 'Max error  = 0' out)" '0 2' 'a TIFF of two images and itself'

run compare a.exr z.exr
is "$status $(grep -c 'channel R is compared with Z of B' out)" '2 1' \
    'no channel of one name: by number'
run compare a.exr deep.exr
status_is 3 'flat and deep: status 3'
for pair in 'deep.exr deep.exr' 'd1.exr d1.exr' 'd1.exr d2.exr' 'd2.exr d1.exr'; do
    run compare $pair
    is "$status $(tail -1 out) $(cat err)" '0 PASS ' "equal deep files match: $pair"
done
run compare d1.exr d3.exr
status_is 2 'deep files of other values: status 2'
ok 'deep files of other values: where' grep -q '^  Max error  = .* @ (-\{0,1\}[0-9]*, [-0-9]*, [A-Zid]*)$' out
run compare -fail 1e9 -v d2.exr d3.exr
status_is 0 'deep files: limits'
for pair in 'd1.exr d4.exr' 'd4.exr d2.exr'; do
    run compare --fail inf $pair
    is "$status $(grep -c '^  1 pixels differ in their number of samples, the first at (10, 5)$' out)" \
        '2 1' "deep files with a sample more: $pair, and where"
done
run compare --json - d1.exr d4.exr
is "$(field out 'o["uneven"]')" "{'pixels': 1, 'x': 10, 'y': 5}" 'a sample more: in the JSON'
run compare d1.exr d5.exr
status_is 2 'deep files whose windows differ'
run compare -o no.exr d1.exr d3.exr
is "$status $(grep -c 'd1.exr: is deep' err)" '2 1' 'no picture of deep files, and a line says so'
run compare --max-pixels 1300 d1.exr d1.exr
fails_with 4 --max-pixels 'more samples than --max-pixels'
for at in 700 20000 -1; do
    head -c $at d2.exr >short.exr
    run compare short.exr short.exr
    fails_with 4 short.exr "a deep file of $at bytes"
done
"$python" - "$glarepp" >flipped <<'PY'
"""Flips bytes of deep files: one line and status 4, or figures."""
import random, subprocess, sys
rng, worst = random.Random(3), ""
for i in range(60):
    b = bytearray(open(("d1.exr", "d2.exr")[i % 2], "rb").read())
    for _ in range(1 + i % 4):
        b[rng.randrange(400, len(b))] = rng.randrange(256)
    open("bent.exr", "wb").write(b)
    p = subprocess.run([sys.argv[1], "compare", "d1.exr", "bent.exr"], capture_output=True,
                       text=True, timeout=60)
    lines = p.stderr.count("\n")
    if (p.returncode, lines) not in ((0, 0), (2, 0), (3, 0), (4, 1)):
        worst += "%d: %d, %s" % (i, p.returncode, p.stderr)
print(worst or "fine")
PY
is "$(cat flipped)" fine 'damaged deep files: a line and status 4, or figures'
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
is "$status $(wc -l <out) $(wc -l <s.json)" '2 5 3' 'a sequence: a line each, the worst status'
is "$(tail -2 out | tr '\n' /)" '3 frames: failure, 2 match, 1 failure/FAILURE/' 'a sequence: the summary'
run compare --no-flip -v s.####.exr t.####.exr
is "$(grep -c '^  Max error' out)" 3 'a sequence with -v: the figures of each'
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
is "$(wc -l <out)" 5 'a frame that only one has: the others are compared'

# -- refusals -----------------------------------------------------------------------------

run compare a.exr
fails_with 64 compare 'one image'
run compare a.exr b.exr id.exr
fails_with 64 id.exr 'three images'
run compare - -
fails_with 64 - 'stdin twice'
run compare --flip-exposures 0,1,1.5 a.exr b.exr
fails_with 64 --flip-exposures 'half an exposure'
run compare --no-flip --heatmap h.png a.exr b.exr
fails_with 64 --heatmap 'a heatmap without FLIP'
run compare -f 1-2 a.exr b.exr
fails_with 64 a.exr '--frames without a pattern'
run compare --heatmap h.png s.####.exr t.####.exr
fails_with 64 h.png 'one heatmap for a sequence'
run compare --heatmap - a.exr b.exr
fails_with 64 --heatmap 'a heatmap on stdout'
cp a.exr keep.exr
run compare --heatmap keep.exr keep.exr b.exr
fails_with 64 keep.exr 'a heatmap over an input'
run compare --json keep.exr b.exr keep.exr
fails_with 64 keep.exr 'JSON over an input'
same keep.exr a.exr 'the input is whole'
run compare --fail -1 a.exr b.exr
fails_with 64 --fail 'a negative limit'
run compare -k a.exr a.exr b.exr
fails_with 64 --kernel 'an option of pictures'
run compare -foo 1 a.exr b.exr
fails_with 64 -foo 'an option that idiff has not either'
run compare --no-flip --fail-flip 0.1 a.exr b.exr
fails_with 64 --fail-flip 'a limit of FLIP without FLIP'
run compare -o - a.exr b.exr
fails_with 64 --difference 'a difference on stdout'
run compare -o d.png --heatmap ./d.png a.exr b.exr
fails_with 64 d.png 'two pictures of one name'
run compare -o keep.exr b.exr keep.exr
fails_with 64 keep.exr 'a difference over an input'
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
"""Makes pairs of images, runs compare on each, prints verdicts beside idiff's.

usage: pairs.py PROGRAM ANSWERS

A start of idiff takes ten times as long as compare, so ANSWERS has its answers by
options, files and their pixels, and the checksums of its pictures' channels. Pairs
that are not there, each 32nd, the first picture of each kind, and all with
GLAREPP_TEST_LONG or another OpenImageIO are asked of idiff; what answers
otherwise than ANSWERS fails. GLAREPP_TEST_RECORD writes ANSWERS anew.
"""
import json, os, re, subprocess, sys, zlib
import numpy as np
import OpenImageIO as oiio

glarepp, answers = sys.argv[1:]
RECORD = bool(os.environ.get("GLAREPP_TEST_RECORD"))
known = {} if RECORD else json.load(open(answers))
if known.get("version") != oiio.VERSION_STRING:
    known = {"version": oiio.VERSION_STRING}
ASK = RECORD or bool(os.environ.get("GLAREPP_TEST_LONG"))
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

def idiff(a, b, options, pixels):
    """Status and lines of idiff -v."""
    def ask():
        p = subprocess.run(["idiff", "-v"] + options + [a, b],
                           capture_output=True, text=True)
        return [p.returncode, *p.stdout.splitlines()]
    said = answer([*options, a, b, "%08x" % pixels], ask, count % 32 == 0)
    return said[0], said[1:]

def answer(words, ask, afresh=False):
    """The answer of ANSWERS, or of idiff by `ask`."""
    key = " ".join(words)
    said = known.get(key)
    if said is None or ASK or afresh:
        now = ask()
        if said is None:
            known[key] = now
        elif said != now:
            verdict(False, "idiff answers as before: " + key, "%s %s" % (said, now))
        said = now
    return said

def run(a, b, options, pixels):
    theirs = idiff(a, b, options, pixels)
    ours = subprocess.run([glarepp, "compare", "--no-flip", "-v", "--json", "o.json"] +
                          options + [a, b], capture_output=True, text=True)
    rows = [json.loads(l) for l in open("o.json")] if os.path.exists("o.json") else []
    if rows:
        os.remove("o.json")
    return theirs, ours, rows

def verdict(good, text, notes=""):
    print("ok" if good else "not ok", text)
    if not good:
        print("#", notes)

count = 0
made, pixels_of = {}, {}

def deep(name, kind, tile=0, change=None, more=-1):
    """A deep file of OpenImageIO's own."""
    r = np.random.default_rng(1)
    w, h, types = 40, 30, ["half", "half", "half", "half", "float"]
    s = oiio.ImageSpec(w, h, 5, "float")
    s.channelnames = ["R", "G", "B", "A", "Z"]
    s.channelformats = tuple(oiio.TypeDesc(t) for t in types)
    s.deep, s.x, s.y, s.tile_width, s.tile_height = True, 3, -4, tile, tile
    s.attribute("compression", kind)
    d = oiio.DeepData()
    d.init(w * h, 5, list(s.channelformats), s.channelnames)
    for p, n in enumerate(r.integers(0, 5, w * h)):
        d.set_samples(p, int(n) + (p == more))
        for i in range(int(n)):
            for c in range(5):
                d.set_deep_value(p, c, i, float(r.random()))
    if change:
        d.set_deep_value(*change)
    f = oiio.ImageOutput.create(name)
    assert f.open(name, s), f.geterror()
    assert f.write_deep_tiles(3, 43, -4, 26, 0, 1, d) if tile else \
        f.write_deep_scanlines(-4, 26, 0, d), f.geterror()
    f.close()

def pair(name, a, b, *options, ending="exr", **key):
    global count
    count += 1
    files = ["p%02da.%s" % (count, ending), "p%02db.%s" % (count, ending)]
    made[name] = files
    for f, image in zip(files, (a, b)):
        if isinstance(image, dict):
            deep(f, **image)
            continue
        write(f, image if isinstance(image, list) else [dict(v=image)], **key)
    pixels_of[name] = crc((a, b, key))
    (status, said), ours, rows = run(*files, list(options), pixels_of[name])
    blocks = figures("\n".join(said))
    shown = ours.stdout.splitlines()
    lines = [[l for l in t if "error" in l and "Max" not in l or "pixels" in l]
             for t in (said, shown)]
    good = said[-1:] == shown[-1:] and lines[0] == lines[1] and \
        status == ours.returncode and len(blocks) == len([r for r in rows if "max" in r])
    for f, r in zip(blocks, rows):
        at = (r["worst"]["x"], r["worst"]["y"], r["worst"]["channel"]) if "worst" in r else None
        good = good and all(near(number(r[k]), f[k]) for k in ("mean", "rms", "psnr", "max")) \
            and at == f["at"] and (r["warned"], r["failed"]) == (f["warned"], f["failed"])
    verdict(good, "as idiff: " + name, "%s %s %s %s" % (status, ours.returncode,
                                                        blocks, rows))

def crc(v):
    """Of all pixels and words in v."""
    if isinstance(v, np.ndarray):
        return zlib.crc32(np.ascontiguousarray(v, np.float32).tobytes(), v.size)
    if isinstance(v, dict):
        v = sorted(v.items())
    if isinstance(v, (list, tuple)):
        return zlib.crc32(repr([crc(part) for part in v]).encode())
    return zlib.crc32(repr(v).encode())

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
pair("-a, two parts", [dict(v=base), dict(v=hdr)], [dict(v=base), dict(v=noisy)], "-a")
pair("-a, three parts and two", [dict(v=base)] * 3, [dict(v=base)] * 2, "-a")
other_names = lambda v, n: [dict(v=v, names=n)]
pair("other names", other_names(rgba, ["k", "l", "m", "n"]), other_names(rgba, ["p", "q", "s", "t"]))
pair("other names and values", other_names(base, ["k", "l", "m"]), [dict(v=other)])
pair("--fail", base, one, "-fail", "0.3", "-warn", "0.3")
pair("--fail over some", base, few, "-fail", "8", "-warn", "1")
pair("--failpercent", base, few, "-failpercent", "1", "-warnpercent", "1")
pair("--failpercent, warning", base, few, "-failpercent", "1")
pair("--failpercent, failure", base, other, "-failpercent", "99.9")
pair("-warn where nothing fails", base, one, "-fail", "0.3", "-warn", "1e-3")
pair("-hardfail where nothing fails", base, one, "-fail", "1", "-hardfail", "0.1")
pair("-allowfailures", base, few, "-allowfailures", "3", "-hardfail", "1")
pair("-allowfailures, too few", base, few, "-allowfailures", "2")
pair("-fail inf", base, few, "-fail", "inf")
pair("--hardfail", base, few, "-failpercent", "1", "-hardfail", "5")
pair("--hardwarn", base, few, "-failpercent", "1", "-warnpercent", "1", "-hardwarn", "5")
pair("--failrelative", hdr, noisy, "-failrelative", "2e-4", "-warnrelative", "4e-4")
pair("--failrelative, none", hdr, noisy, "-failrelative", "1e-2", "-warnrelative", "1e-2")
pair("PNG of 8 bits", base, one, ending="png", kind="uint8")
pair("PNG of 16 bits", base, one, ending="png", kind="uint16")
pair("TIFF of floats", hdr, noisy, ending="tif")
plain = dict(kind="zips")
for name, b in (("equal", plain), ("stored", dict(kind="none")), ("RLE", dict(kind="rle")),
                ("tiles", dict(kind="zips", tile=16)),
                ("another value", dict(kind="rle", change=(50, 1, 0, 7.5))),
                ("tiles, another value", dict(kind="zips", tile=7, change=(50, 4, 0, -7.5)))):
    pair("deep, " + name, plain, b)
    if "value" in name:
        pair("deep, " + name + ", other way", b, plain, "-warn", "1")
print("#", count, "pairs")

# compare follows idiff's documents, also where idiff 2.4 does not
def apart(name, a, b, wanted, *options):
    write("x.exr", [dict(v=a)])
    write("y.exr", [dict(v=b)])
    (status, _), ours, rows = run("x.exr", "y.exr", list(options), crc((a, b)))
    verdict(ours.returncode == wanted, name, "idiff %d, compare %d" %
            (status, ours.returncode))
    return rows[0]

apart("a NaN against a number fails", base, change(base, (1, 2, 0, nan)), 2)
r = apart("many NaN against numbers fail", base, change(base, (1, 2, 0, nan), (9, 9, 1, inf)), 2)
verdict(r["nonfinite"] == 2 and r["mean"] == 0 and r["max"] is None,
        "values that are not finite stay out of the sums")
apart("Inf against -Inf fails", change(base, (1, 2, 0, inf)), change(base, (1, 2, 0, -inf)), 2)

# OpenImageIO's own cases, inputs made anew: testsuite/diff, and what its other
# tests leave to idiff (oiiotool-pattern, oiiotool-copy, tiff-depths and the
# like: 8 bits with -fail 0.004 -failpercent 0.02, as runtest.py asks)
img1 = np.full((64, 64, 3), .1, np.float32)
img2 = np.array(img1)
img2[17:28, 5:16, 1] = .6
pair("testsuite/diff", img1, img2, "-fail", "0.004", "-warn", "0.008")
pair("testsuite/diff --diff", img1, img2)
pair("testsuite/diff -p", img1, img2, "-p")
pair("testsuite/diff -p, equal", img1, img1, "-p")
pair("testsuite/diff -a", img1, img2, "-a")
lax = ("-fail", "0.004", "-failpercent", "0.02", "-hardfail", "0.012", "-warn", "0.008", "-a")
ramp = np.linspace(0, 1, 64 * 64 * 3).reshape(64, 64, 3).astype(np.float32)
for kind, ending in (("uint8", "tif"), ("uint16", "tif"), ("float", "tif"), ("uint8", "png"),
                     ("half", "exr")):
    pair("testsuite, a code off: " + kind + " " + ending, ramp, ramp + np.float32(1 / 255.5), *lax,
         kind=kind, ending=ending)
    pair("testsuite, half a code off: " + kind + " " + ending, ramp, ramp + np.float32(.4 / 255),
         *lax, kind=kind, ending=ending)
noise = rng.normal(.5, .1, (64, 64, 3)).astype(np.float32)
salt = np.where(rng.random((64, 64, 1)) < .01, 1, 0) * np.ones(3)
pair("testsuite/oiiotool-pattern, noise", noise, noise, *lax, kind="uint8", ending="tif")
pair("testsuite/oiiotool-pattern, other noise", noise, noise[::-1], *lax, kind="uint8",
     ending="tif")
pair("testsuite/oiiotool-pattern, salt", salt, salt[:, ::-1], *lax, kind="uint8", ending="tif")

def statuses(wanted, *words):
    """idiff's status and ours of a command line."""
    def status(*command):
        return subprocess.run([*command, *words], capture_output=True).returncode
    got = [answer(["status", *words], lambda: status("idiff")),
           status(glarepp, "compare")]
    verdict(got == [wanted, wanted], "as idiff: %s" % " ".join(words), got)

write("p.exr", [dict(v=img1)])
write("q.exr", [dict(v=img2)])
statuses(0, "p.exr", "p.exr")
statuses(2, "-q", "p.exr", "q.exr")
statuses(4, "p.exr", "nowhere.exr")
statuses(0, "-q", "-od", "-o", "od.exr", "p.exr", "p.exr")

# pictures of the difference, pixel by pixel
# (files have a name each: OpenImageIO keeps what it has read)
for row, (name, of, *options) in enumerate((
        ("noise", "noise", "-scale", "1"), ("-abs -scale", "noise", "-abs", "-scale", "3"),
        ("-scale -2", "half", "-scale", "-2"), ("grey", "grey", "-abs"),
        ("windows", "windows that meet", "-abs"), ("alpha", "alpha", "-abs"))):
    for ending in ("exr", "png"):
        def channels(out, *command):
            """Size and checksums of the channels of the picture it writes."""
            subprocess.run([*command, *options, "-o", out, *made[of]],
                           capture_output=True)
            a = oiio.ImageBuf(out).get_pixels(oiio.FLOAT) + np.float32(0)  # no -0
            return [*a.shape[:2], *(zlib.crc32(np.ascontiguousarray(a[..., c]))
                                    for c in range(a.shape[2]))]
        ours = channels("o%d.%s" % (row, ending), glarepp, "compare", "--no-flip")
        theirs = answer([*options, "-o", ending, *made[of], "%08x" % pixels_of[of]],
                        lambda: channels("i%d.%s" % (row, ending), "idiff"), row == 0)
        # (the size, then four channels; PNG may leave out a channel)
        most = 6 if ending == "exr" else min(len(ours), len(theirs))
        verdict(len(ours) > 2 and ours[:most] == theirs[:most],
                "as idiff -o: %s, %s" % (name, ending), "%s %s" % (ours, theirs))
if RECORD:
    with open(answers, "w") as f:
        json.dump(known, f, indent=1)
        f.write("\n")
PY
"$python" pairs.py "$glarepp" "$cli/idiff.json" >verdicts 2>pairs.err ||
    { echo 'not ok pairs.py' >>verdicts; note "$(tail -5 pairs.err)"; }
verdicts verdicts
ok 'at least 40 pairs' sh -c 'test "$(grep -c "^ok as idiff" verdicts)" -ge 40'

done_testing
