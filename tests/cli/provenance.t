#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# glarepp:version, glarepp:command and glarepp:output: what made a picture, in each EXR
# and PNG.
. "$(dirname "$0")/lib.sh"
need_python

version=$("$glarepp" --version | sed -n '1s/^glarepp //p')
mkdir -p in/deep made
frame in/f.exr
frame in/two.exr part=other:Z:float

# says FILE COMMAND DESCRIPTION [OPTION]: all, once
says()
{
    is "$("$python" "$cli/tags.py" "$1" | grep -a '^glarepp:' | LC_ALL=C sort)" \
        "glarepp:command=$2${4:+
glarepp:output=$4}
glarepp:version=$version" "$3"
}

run -o made/p.png -o made/p.exr --hdr made/h.exr --layer made/l.exr \
    --debug sensors=made/s.exr -g 0.5 -t 2 --threads 2 --frame-jobs 1 \
    --report r.json "$tmp/in/f.exr"
quiet_success 'pictures of every kind'
for made in p.png=--output p.exr=--output h.exr=--hdr l.exr=--layer s.exr=; do
    says made/${made%%=*} 'glarepp --gain 0.5 --threshold 2 f.exr' "$made says it" "${made#*=}"
done
run --hdr made/two.exr in/two.exr
says made/two.exr 'glarepp two.exr' 'two parts: the one that was made, once' --hdr
run --compression dwaa --hdr made/d.exr in/f.exr
[ $status = 0 ] &&
    says made/d.exr 'glarepp --compression dwaa f.exr' 'DWA, by the helper' --hdr ||
    skip 1 'no helper'
run --hdr made/again.exr -o made/again.png -g 0.25 made/h.exr
says made/again.exr 'glarepp --gain 0.25 h.exr' 'a picture of a picture: the last' --hdr
run --hdr made/png.exr made/p.png
says made/png.exr 'glarepp p.png' 'a picture of a PNG: the last' --hdr
run -o made/o.png -o made/o.exr "$(
    cp in/f.exr "in/it's $(printf '\303\244').exr" && echo "in/it's $(printf '\303\244').exr")"
says made/o.png "glarepp 'it'\\''s $(printf '\303\244').exr'" 'a PNG: letters that are not ASCII' --output
says made/o.exr "glarepp 'it'\\''s $(printf '\303\244').exr'" 'an EXR: the same' --output
run compare --heatmap made/heat.png --fail 1e9 in/f.exr "$tmp/in/f.exr"
says made/heat.png 'glarepp compare --fail 1e9 f.exr f.exr' 'a heatmap'
run compare -scale 2 -o made/minus.exr in/f.exr in/f.exr
says made/minus.exr 'glarepp compare --scale 2 f.exr f.exr' 'a difference'
"$glarepp" -o - in/f.exr >made/stdout.exr
says made/stdout.exr 'glarepp f.exr' 'stdout' --output

# a command is a command: it makes the same bytes again, in another folder
cp in/f.exr in/deep
run -k builtin:star --rotate=10 -t 0.9 -o made/1.png --hdr made/1.exr in/f.exr
(cd in/deep && sh -c "$("$python" "$cli/tags.py" ../../made/1.png |
    sed -n 's/^glarepp:command=glarepp/"$0" -o 2.png --hdr 2.exr/p')" "$glarepp")
same made/1.png in/deep/2.png 'the command of a PNG makes it again'
same made/1.exr in/deep/2.exr 'the command of an EXR makes it again'
run --grow=5 --hdr made/grown.exr in/f.exr
says made/grown.exr 'glarepp --grow 5 f.exr' 'more pixels' --hdr

# none of it
run --no-provenance -o made/n.png -o made/n.exr --hdr made/nh.exr made/h.exr
quiet_success '--no-provenance'
no '--no-provenance: nothing of it, nor what the input had' \
    grep -q glarepp made/n.png made/n.exr made/nh.exr
cp made/h.exr in/deep/renamed.exr
run --no-provenance -o made/m.png in/deep/renamed.exr
same made/n.png made/m.png '--no-provenance: the same bytes for any name'

done_testing
