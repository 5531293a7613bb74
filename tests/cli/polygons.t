#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# --debug polygons: what -o shows, with outlines in pure green over it.
. "$(dirname "$0")/lib.sh"
need_python

frame over.exr size=120x90 origin=-20,7 display=0,0,89,99 lights=6
frame kernel.exr kind=kernel size=21x16
frame dark.exr kind=dark

# no GL is needed for it
run -q --engine fft -k kernel.exr --shrink 0 -o shown.exr --type float \
    --debug polygons=lines.exr over.exr
quiet_success 'polygons beside another engine'
run -q --engine fft -k kernel.exr --shrink 0 --depth-bits 16 -o wide.png \
    --debug polygons=lines.png over.exr
is "$(png_size lines.png)" "$(png_size wide.png)" 'a PNG of the display window'
run -q --tonemap none --type float -k kernel.exr -o lit.exr \
    --debug polygons=untoned.exr over.exr
quiet_success 'polygons over the light itself'
run -q --no-provenance -o dark.png --debug polygons=darklines.png dark.exr
quiet_success 'no light, no polygons'
same dark.png darklines.png 'no light: the picture alone'
run --debug polygons=alone.exr over.exr
quiet_success 'polygons alone'
cp over.exr s.0001.exr
cp over.exr s.0002.exr
run --no-provenance --debug polygons=p.@.exr s.####.exr
same p.1.exr p.2.exr 'polygons of a sequence'

if [ -n "$oiio" ]; then
    "$python" - <<'PY' >verdicts
import numpy as np
import OpenImageIO as oiio

def check(a, b, about):
    a, b = oiio.ImageBuf(a), oiio.ImageBuf(b)
    sa, sb = a.spec(), b.spec()
    same = all(getattr(sa, k) == getattr(sb, k) for k in (
        "x", "y", "width", "height", "full_x", "full_y", "full_width",
        "full_height"))
    pa, pb = (np.asarray(i.get_pixels(oiio.FLOAT)) for i in (a, b))
    green = (pb == (0, 1, 0)).all(axis=2)
    rest = (pa == pb).all(axis=2)
    fine = same and (green | rest).all() and 100 < green.sum() < green.size / 2
    print("ok" if fine else "not ok", about)
    if not fine:
        print("#", same, green.sum(), (~(green | rest)).sum())

check("shown.exr", "lines.exr", "windows, colours and lines")
check("lit.exr", "untoned.exr", "windows, light and lines")
PY
    verdicts verdicts
else
    skip 2 'no numpy and OpenImageIO'
fi

done_testing
