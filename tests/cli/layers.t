#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Layers, parts and views: --layer-in and --part, and all that --hdr carries.
# shellcheck disable=SC1007,SC2016
. "$(dirname "$0")/lib.sh"
need_python
[ -n "$oiio" ] || skip_all "no python3 with OpenImageIO to compare pixels"
no_provenance

# Questions of the tests about files:
#   same A B PART BUT...    every channel of the part but those named has the
#                           same type and bits in both, and those named differ
#   parts A B BUT           every part but that one has the same chunks
#   rename A B LAYER        B has LAYER's channels of A alone, without its name
#   poison A B              B is A with NaN of many payloads in its floats that
#                           are not R, G or B
cat >files.py <<'EOF'
import struct
import numpy
import OpenImageIO as oiio

def part(path, n):
    i = oiio.ImageInput.open(path)
    assert i and i.seek_subimage(n, 0), path
    s = i.spec()
    kinds = [str(s.channelformat(c)) for c in range(s.nchannels)]
    out = {}
    for c, name in enumerate(s.channelnames):
        v = numpy.ascontiguousarray(i.read_image(n, 0, c, c + 1, kinds[c]))
        out[name] = kinds[c], v.tobytes()
    return out

def chunks(path):
    """The bytes of every chunk of each part of a multi-part file."""
    b = open(path, "rb").read()
    at, counts = 8, []
    while b[at]:
        count = None
        while b[at]:
            name = b[at:b.index(b"\0", at)]
            at += len(name) + 1
            at = b.index(b"\0", at) + 1
            size, = struct.unpack_from("<i", b, at)
            if name == b"chunkCount":
                count, = struct.unpack_from("<i", b, at + 4)
            at += 4 + size
        at += 1
        counts.append(count)
    at, out = at + 1, []
    for n in counts:
        found = []
        for k in range(n):
            place, = struct.unpack_from("<Q", b, at + 8 * k)
            size, = struct.unpack_from("<i", b, place + 8)
            found.append(b[place:place + 12 + size])
        at += 8 * n
        out.append(found)
    return out

def same(a, b, n, *but):
    p, q = part(a, int(n)), part(b, int(n))
    assert sorted(p) == sorted(q), (sorted(p), sorted(q))
    for name in p:
        if name in but:
            assert p[name][1] != q[name][1], name + " is what it was"
        else:
            assert p[name] == q[name], name + " is not what it was"

def parts(a, b, but):
    p, q = chunks(a), chunks(b)
    assert len(p) == len(q) > 1
    for i in range(len(p)):
        assert i == int(but) or p[i] == q[i], "part %d" % i

def rename(a, b, layer):
    img = oiio.ImageBuf(a)
    names = ["%s.%s" % (layer, c) for c in "RGB"]
    out = oiio.ImageBufAlgo.channels(img, tuple(names), ("R", "G", "B"))
    out.set_write_format("half")
    assert out.write(b), out.geterror()

def poison(a, b):
    i = oiio.ImageInput.open(a)
    s = i.spec()
    s.attribute("compression", "none")
    v = i.read_image("float")
    for c, name in enumerate(s.channelnames):
        if str(s.channelformat(c)) == "float" and name not in "RGB":
            bits = numpy.arange(v[:, :, c].size, dtype=numpy.uint32) * 2654435
            bits = bits.reshape(v[:, :, c].shape)
            bits[::3] |= 0x7f800000
            v[:, :, c] = bits.view(numpy.float32)
    o = oiio.ImageOutput.create(b)
    o.open(b, s)
    assert o.write_image(v)
    o.close()
EOF
answers files.py

# status WANTED PATTERN DESCRIPTION COMMAND...: its status and its line
status()
{
    wanted=$1 pattern=$2 description=$3
    shift 3
    got=$("$@" 2>&1 >/dev/null)
    code=$?
    is "$code" "$wanted" "$description: status $wanted"
    like "$got" "$pattern" "$description: the line"
}

"$python" "$cli/exr.py" plain.exr kind=lights \
    'channels=R,G,B,A,Z:float,id:uint,key.R,key.G,key.B,fill.Y:float,CryptoObject00.R:float,CryptoObject00.G:float,CryptoObject00.B:float,CryptoObject00.A:float'
ask poison plain.exr in.exr

# -- a layer as the frame ------------------------------------------------------

ok 'a layer has glare' "$glarepp" --layer-in key --hdr key.exr in.exr
ok 'and everything else its bits' ask same in.exr key.exr 0 key.R key.G key.B
ok 'a grey layer too' "$glarepp" --layer-in fill --hdr fill.exr in.exr
ask rename in.exr alone.exr key
"$glarepp" --layer-in key --layer one.exr in.exr
"$glarepp" --layer two.exr alone.exr
ok 'the glare is that of the layer alone' "$glarepp" compare --fail 0 \
    --warn 0 one.exr two.exr
"$glarepp" --layer-in key --layer - - <in.exr >three.exr
ok 'the same from a stream' cmp one.exr three.exr
for threads in 1 2; do
    "$glarepp" --threads $threads --layer-in key --hdr t$threads.exr in.exr
done
ok 'the same with any number of threads' cmp t1.exr t2.exr
ok 'bench takes a layer' "$glarepp" bench --runs 1 --layer-in key in.exr

# -- carried channels ----------------------------------------------------------

for compression in none rle zips zip piz; do
    for type in auto half float; do
        rm -f out.exr
        "$glarepp" --compression $compression --type $type --hdr out.exr in.exr
        ask same in.exr out.exr 0 R G B 2>log
        result $? "$compression, $type: carried channels keep their bits" ||
            note "$(tail -n 1 log)"
    done
done

# -- ids -----------------------------------------------------------------------

for compression in pxr24 dwaa dwab; do
    rm -f out.exr
    status 2 '*would change the Cryptomatte ids of in.exr (channel *; use --compression zip' \
        "$compression with ids" "$glarepp" --compression $compression \
        --hdr out.exr in.exr
    no "$compression with ids writes nothing" ls out.exr
done
ok 'b44 keeps floats' "$glarepp" --compression b44 --hdr out.exr in.exr
ok 'so ids are what they were' ask same in.exr out.exr 0 R G B key.R \
    key.G key.B
status 2 '*layer CryptoObject00 is Cryptomatte: ids are no light*(layers of light: fill, key)*' \
    'ids as a layer' "$glarepp" --layer-in CryptoObject00 --hdr no.exr in.exr

# -- names that are not there ---------------------------------------------------

status 2 '*in.exr: has no layer nix (layers: fill, key; parts: 0 *; views: none); give one of those' \
    'no such layer' "$glarepp" --layer-in nix --hdr no.exr in.exr
status 2 '*in.exr: has no part 4 (*' 'no such part' "$glarepp" --part 4 \
    -o no.png in.exr
status 2 '*in.exr: has no layer nix (*' 'no such layer to measure' \
    "$glarepp" bench --layer-in nix in.exr
status 64 '*layer-in*' 'compare has no layers' "$glarepp" compare --layer-in a \
    in.exr in.exr
"$glarepp" -o in.png in.exr
status 2 '*in.png: has no layer nix (channels: R, G, B); give one of its layers' \
    'a layer of a PNG' "$glarepp" --layer-in nix -o no.png in.png
status 2 '*in.png: has no part main: *only numbers; give one from 0' \
    'a named part of a PNG' "$glarepp" --part main -o no.png in.png
ok 'part 0 of a PNG' "$glarepp" --part 0 -o part.png in.png
status 4 '*in.png: *part 3*' 'part 3 of a PNG' \
    "$glarepp" --part 3 -o no.png in.png
no 'nothing was written' ls no.exr no.png

# -- parts ---------------------------------------------------------------------

"$python" "$cli/exr.py" two.exr part=depth:Z:float part=more:id:uint
ok 'a file of parts' "$glarepp" --part rgba --hdr out.exr two.exr
ok 'whose other parts are the bytes they were' ask parts two.exr out.exr 0
ok 'a part of one channel' "$glarepp" --part 1 --layer-in Z --hdr out.exr two.exr
ok 'is made anew alone' ask parts two.exr out.exr 1

if [ -z "$data" ]; then
    skip 6 "$no_data"
else
    stereo=$data/depth/Beachball_multipart.0001.exr
    ok 'the left eye' "$glarepp" -t 0.4 --grow none --part rgba_left \
        --hdr out.exr "$stereo"
    ok 'the right eye and all others stay' ask parts "$stereo" out.exr 4
    ok 'with A' ask same "$stereo" out.exr 4 R G B
    "$glarepp" -t 0.4 --grow none --layer-in left.rgba --hdr out2.exr "$stereo"
    ok 'the left eye by its view' cmp out.exr out2.exr
    ids=$data/camera/arnold_multichannel_tiled64.exr
    ok 'a render with ids' "$glarepp" -t 0.5 --hdr out.exr "$ids"
    ok 'whose 56 channels stay' ask same "$ids" out.exr 0 R G B
fi

# OpenEXR 3.1.5 reads 4 bytes too many of a manifest: of what it writes itself
# these are the start of lineOrder, and so they are of ours
frame ids.exr attr=idManifest:idmanifest:1,0,5
"$glarepp" --hdr ids.hdr.exr --layer ids.layer.exr ids.exr
for f in ids.hdr.exr ids.layer.exr; do
    is "$("$python" -c 'import sys
b = open(sys.argv[1], "rb").read()
print(b.count(b"idmanifest"), b[b.index(b"idmanifest") + 27:][:9].decode())' $f)" \
        '1 lineOrder' "$f: lineOrder follows the manifest of ids"
done


# -- channels that are no light --------------------------------------------------

# a frame of these has no colour; beside light they keep their bits
for channels in Z:float Z:float,ZBack:float A,Z:float depth.V:float Depth.Y \
    zdepth:float depth.R,depth.G,depth.B id:uint foo:uint objectID:float id.Y \
    IndexOB.X A alpha mask matte.A mask.R,mask.G,mask.B N.X,N.Y,N.Z N.X \
    N.R,N.G,N.B P.X P.Z Vector.X,Vector.Y,Vector.Z,Vector.W motion.u velocity.X \
    uv.R,uv.G,uv.B position.red,position.green,position.blue Mist.Z crypto00.R \
    CryptoObject00.R,CryptoObject00.G,CryptoObject00.B,CryptoObject00.A; do
    frame data.exr size=24x16 hot=100 "channels=$channels"
    rm -f data.hdr.exr
    run -q --hdr data.hdr.exr data.exr
    fails_with 4 data.exr "$channels: no light"
    no "$channels: no light: nothing is written" [ -e data.hdr.exr ]
    frame data.exr size=24x16 hot=100 "channels=R,G,B,$channels"
    run -q -e direct --hdr data.hdr.exr data.exr
    ok "$channels beside light: the same bits" \
        ask same data.exr data.hdr.exr 0 R G B
done
# nor has a part that is called so, but where it is asked for
oiiotool --pattern constant:color=9,9,9 24x16 3 --attrib oiio:subimagename N \
    --pattern constant:color=5,5,5 24x16 3 --attrib oiio:subimagename rgba \
    --siappend -d float -o parts.exr
run -q --report parts.json -o parts.png parts.exr
like "$(cat parts.json)" '*"part":"rgba"*' 'a part of normals: passed over'
run -q --part N --report parts.json -o parts.png parts.exr
like "$(cat parts.json)" '*"part":"N"*' 'a part of normals: --part takes it'
done_testing
