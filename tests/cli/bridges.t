#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The program without its helper for OpenImageIO and its bridge to OpenColorIO,
# with files that are none, and with others: what needs them fails with one
# line, all else works.
. "$(dirname "$0")/lib.sh"
need_python
built=$(dirname "$glarepp")
frame in.exr size=128x96 lights=9
for name in glarepp-oiio glarepp-ocio.so; do
    [ -f "$built/$name" ] || skip_all "no $name"
done
"$glarepp" -e direct -o in.tif in.exr 2>err &&
    "$glarepp" -e direct --hdr dwaa.exr --compression dwaa in.exr 2>err ||
    skip_all 'the bridge to OpenImageIO does not work here'
cp "$cli/c.ocio" . || exit 1
mkdir bin && cp "$glarepp" bin/glarepp || exit 1
glarepp=$tmp/bin/glarepp
unset GLAREPP_BRIDGES
run -e direct -o installed.png in.tif
[ "$status" != 0 ] || skip_all 'bridges are installed where the program looks'

# needs_them NAME TEXT: each way to need a bridge fails; err has TEXT
needs_them()
{
    while read -r file arguments; do
        rm -rf made && mkdir made
        run -e direct $arguments
        fails_with 3 "$file" "$1, $arguments"
        like "$(cat err)" "*$2*" "$1, $arguments: it says why"
        empty_folder made "$1, $arguments: nothing is left"
    done <<'ROWS'
in.tif -o made/a.png in.tif
in.tif -o made/a.png --depth-file in.tif --depth G --sun 5,5,2 --sun-color 5 in.exr
made/a.tif -o made/a.tif in.exr
dwaa.exr -o made/a.png dwaa.exr
made/h.exr --hdr made/h.exr --compression dwaa in.exr
--ocio --ocio c.ocio -o made/a.png in.exr
ROWS
    run -e direct -o made/a.png --hdr made/h.exr in.exr
    quiet_success "$1: EXR and PNG need none"
    run compare in.exr in.tif
    is "$status" 4 "$1: compare cannot read it"
    one_line_error in.tif "$1: compare, one line"
}

needs_them 'no bridges' 'not found'

mkdir none
for name in glarepp-oiio glarepp-ocio.so; do
    echo 'no library' >none/$name
done
chmod +x none/*
export GLAREPP_BRIDGES=$tmp/none
needs_them 'no libraries' "$tmp/none/glarepp-o"

# a program and a library, but not those of these names
mkdir other
cp "$built/glarepp" other/glarepp-oiio
cp "$built/glarepp" other/glarepp-ocio.so
export GLAREPP_BRIDGES=$tmp/other
needs_them 'others' "other/glarepp-o"

# a folder that is not there: those beside the program are taken
cp "$built"/glarepp-oiio bin/
export GLAREPP_BRIDGES=$tmp/nowhere
run -e direct -t 0.5 -o beside.png in.tif
quiet_success 'the bridge beside the program'

done_testing
