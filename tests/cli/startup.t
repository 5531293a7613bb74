#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A run does not load libraries that it does not need: no time is lost, and no
# package is needed.
. "$(dirname "$0")/lib.sh"
need_python
[ "$(uname)" = Linux ] || skip_all 'asks the dynamic loader of Linux'
! sanitized || skip_all 'a sanitizer loads what the program does not'

frame in.exr
frame dark.exr kind=dark
frame kernel.exr kind=kernel size=65x65
mkfifo held

# loaded ARGUMENT...: names of the shared objects that a run opens
loaded()
{
    LD_DEBUG=files LD_DEBUG_OUTPUT=$tmp/ld "$glarepp" "$@" >out 2>err
    status=$?
    sed -n 's/.*calling init: //p' ld.* | sed 's|.*/||' | sort -u >loaded.list
    rm -f ld.*
}

# without NAME... : none of them is in the list
without()
{
    for name; do
        if grep -qi "^lib$name\|^$name" loaded.list; then
            return 1
        fi
    done
}

loaded --version
status_is 0 --version
if ! grep -q '^libc\.' loaded.list; then
    skip 1 'LD_DEBUG says nothing here'
    done_testing
    exit 0
fi
heavy='OpenImageIO OpenColorIO OSMesa EGL GL LLVM stdc++ glarepp-oiio fftw3'
ok '--version: no library that is heavy' without $heavy
loaded --help
ok '--help: no library that is heavy' without $heavy
loaded -o out.png nowhere.exr
ok 'an error: no library that is heavy' without $heavy
loaded -q -o out.png --hdr out.exr dark.exr
quiet_success 'a dark frame'
ok 'a dark frame: no bridge, no GL' without $heavy
loaded --engine direct -o out.png --hdr out.exr in.exr
ok 'direct: no bridge, no GL' without $heavy
loaded -q --engine fft -k kernel.exr --hdr out.exr in.exr
quiet_success 'fft with a kernel file'
ok 'fft: no bridge, no GL' without $heavy
loaded --hdr out.exr --compression piz in.exr
ok 'EXR to EXR: no bridge, no GL' without $heavy
if [ -n "$oiio" ]; then
    loaded -o out.jpg in.exr
    no 'JPEG needs the bridge: this test can fail' without $heavy
else
    skip 1 'no OpenImageIO'
fi
count=$(wc -l <loaded.list)
loaded --hdr out.exr --engine direct in.exr
ok "EXR to EXR: few libraries" [ "$(wc -l <loaded.list)" -lt 25 ]

done_testing
