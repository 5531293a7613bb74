#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# No name of a file or channel moves the terminal's cursor or turns the order of
# a line: not in figures, tables, lists and messages, and not in files that
# people print. JSON keeps the name, escaped.
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr size=16x12
cat >plain.py <<'PY'
import re, sys
text = sys.stdin.buffer.read().decode("utf-8", "surrogateescape")
bad = re.findall("[\0-\b\v-\x1f\x7f-\x9f\udc80-\udc9f\u061c\u200e\u200f"
                 "\u2028-\u202e\u2066-\u2069]", text.replace("\r\n", "\n"))
print(" ".join("%04x" % ord(c) for c in bad) or "plain")
PY
cat >command.py <<'PY'
import struct, sys
text = open(sys.argv[1], "rb").read()
text = text[text.index(b"glarepp:command\0string\0") + 23:]
sys.stdout.buffer.write(text[4:4 + struct.unpack("<i", text[:4])[0]])
PY

# (contexts of GL would take most of the time of bench, and hold no names)
export GLAREPP_OSMESA=/no-gl GLAREPP_EGL=/no-gl

# plain LABEL ARGUMENT...: neither stdout nor stderr holds such a character
plain()
{
    label=$1
    shift
    "$glarepp" "$@" >out 2>err </dev/null
    status=$?
    is "$(cat out err | "$python" plain.py)" plain "$label: plain" ||
        note "$* (status $status): $(cat -v out err | head -3)"
}

# ESC, DEL, C1 in UTF-8 and by itself, right-to-left override, isolate, mark
for escape in '\033[31m' '\177' '\302\233[31m' '\233[31m' '\342\200\256' \
    '\342\201\246' '\342\200\217'; do
    # shellcheck disable=SC2059
    name=$(printf "a${escape}b")
    cp in.exr "$name.exr"
    mkdir "$name"
    frame names.exr size=16x12 "channels=R,G,B,$name"
    plain "compare $escape" compare "$name.exr" in.exr
    plain "compare --json $escape" compare --json - "$name.exr" in.exr
    plain "compare of channels $escape" compare names.exr in.exr
    plain "bench $escape" bench --runs 1 -k "$name.exr" "$name.exr"
    plain "bench --csv $escape" bench --runs 1 --csv - "$name.exr"
    plain "bench --json $escape" bench --runs 1 -k "$name.exr" --json - \
        "$name.exr"
    plain "bench --sun $escape" bench --sun 5,5,2 --mask R "$name.exr"
    plain "kernel --check $escape" kernel --check "$name.exr"
    plain "-v $escape" -v -o o.png "$name.exr"
    plain "--report $escape" -q -k "$name.exr" -o o.exr --report - "$name.exr"
    is "$("$python" -c 'import json, sys
print(json.load(open("out"))["input"] == sys.argv[1].encode(
    "utf-8", "surrogateescape").decode("utf-8", "replace"))' "$name.exr")" \
        True "--report $escape: the name is whole"
    is "$("$python" command.py o.exr | "$python" plain.py)" plain \
        "glarepp:command $escape: plain"
    for when in always percent json openjd; do
        plain "--progress $when $escape" --progress $when -o o.png "$name.exr"
    done
    plain "no frame $escape" -o o.png "none$name.exr"
    plain "no option $escape" "--$name" -o o.png in.exr
    plain "no layer $escape" --layer-in "$name" -o o.png in.exr
    plain "no ending $escape" -o "$name" in.exr
    plain "no pattern $escape" -o o.png "$name.####.exr"
    plain "depth $escape" --sun 5,5,2 --depth "$name" -o o.png names.exr
    plain "no topic $escape" help "$name"
    rm -r "$name" "$name.exr"
done
done_testing
