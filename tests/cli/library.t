#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The installed library, as its users have it: its header and pkg-config alone, in C11
# and C++17, shared and as an archive; what it reads; where it finds its bridge.
. "$(dirname "$0")/lib.sh"
[ -z "$quick" ] || skip_all 'a build for tests'
for tool in pkg-config "${CC:=cc}" "${CXX:=c++}"; do
    command -v "$tool" >/dev/null || skip_all "no $tool"
done
pkg-config jansson || skip_all 'no jansson.pc'

prefix=/opt/a\ place
unset MAKEFLAGS MFLAGS MAKELEVEL GLAREPP_BRIDGES
(cd "$root" && make --no-print-directory B="$(dirname "$glarepp")" install \
    DESTDIR="$tmp/root" PREFIX="$prefix") >mk.log 2>&1
result $? 'make install' || note "$(tail -n 12 mk.log)"
lib="$tmp/root$prefix/lib"
export PKG_CONFIG_PATH="$lib/pkgconfig" PKG_CONFIG_SYSROOT_DIR="$tmp/root"
shared=$(pkg-config --cflags --libs glarepp)
static=$(pkg-config --static --cflags --libs glarepp |
    sed 's/-lglarepp/-l:libglarepp.a/')
unset PKG_CONFIG_SYSROOT_DIR

# build COMPILER OUT SOURCE FLAGS: without a warning (pkg-config quotes for a shell)
build()
{
    eval "ok '$2: it compiles' $1 -Wall -Wextra -Wpedantic -Werror -o $2 $3 $4"
}


# -- examples ------------------------------------------------------------------------

cp "$root/examples/embed.c" embed.c && cp embed.c embed.cpp
cp "$root/examples/embed_many.c" .
build "$CC -std=c11" c_shared embed.c "$shared"
build "$CC -std=c11" c_static embed.c "$static"
build "$CXX -std=c++17" cpp_shared embed.cpp "$shared"
build "$CXX -std=c++17" cpp_static embed.cpp "$static"
for program in c_shared c_static cpp_shared cpp_static; do
    LD_LIBRARY_PATH="$lib" ./$program >$program.out
    is "$?, $(cat $program.out)" "0, $(cat c_shared.out)" "$program: it runs"
done
bound=$(sed -n 's/.*error at most //p' c_shared.out)
ok "the bound that it prints, $bound" awk -v b="$bound" \
    'BEGIN { exit !(b > 0 && b <= 1e-3) }'
readelf -d c_static >needed
no 'the archive needs no installed library' grep -q libglarepp needed
build "$CC -std=c11 -pthread" many embed_many.c "$shared"
export LD_LIBRARY_PATH="$lib"
is "$(./many 2>&1)" '12 of 12 frames' 'frames from several threads'
like "$(./many 3 2>&1)" '[3-6] of 12 frames' 'and fewer when they are cancelled'

{
    printf '#include <glarepp.h>\n#include <stdio.h>\nint main(void)\n{\n'
    echo 'static float pixels[3 * 640 * 360] = {9.0f};'
    awk '/^```c$/ { on = 1; next } /^```$/ { on = 0 } on' "$root/man/library.md"
    echo 'return status; }'
} >page.c
build "$CC -std=c11" page page.c "$shared"
ok 'the code of man/library.md runs' ./page

# -- what it reads -------------------------------------------------------------------

is "$(readelf -d "$lib/libglarepp.so.0" | sed -n 's/.*NEEDED.*\[\(.*\)\.so.*/\1/p' |
    grep -vE '^(libc|libm|libdl|libpthread|ld-linux.*)$')" libjansson \
    'the libraries that it needs'
if strace -f -o trace -e trace=file ./c_shared >/dev/null 2>&1; then
    is "$(grep -v ENOENT trace | sed -n 's/^[^"]*open[^"]*"\([^"]*\)".*/\1/p' |
        grep -vE '\.so(\.[0-9.]*)?$|^/etc/ld\.so\.(cache|preload)$')" '' \
        'it opens no file but libraries'
else
    skip 1 'no strace'
fi

# -- its bridge ----------------------------------------------------------------------

cat >ocio.c <<'END'
#include <glarepp.h>
#include <stdio.h>
int main(int argc, char *argv[])
{
    (void) argc;
    struct glarepp_tone_params tone = GLAREPP_TONE_PARAMS;
    struct glarepp_plan_params how = GLAREPP_PLAN_PARAMS;
    struct glarepp *gp;
    struct glarepp_plan *plan;
    tone.config = argv[1];
    how.tone = &tone;
    if (glarepp_open(NULL, &gp))
        return 1;
    int status = glarepp_plan(gp, &how, &plan);
    puts(status ? glarepp_error()->text : glarepp_plan_facts(plan)->display);
    glarepp_plan_end(&plan);
    glarepp_close(&gp);
    return status;
}
END
build "$CC -std=c11" ocio ocio.c "$shared"
if [ -f "$lib/glarepp/glarepp-ocio.so" ]; then
    ok 'it finds the bridge in lib/glarepp' ./ocio "$cli/c.ocio"
    export LD_LIBRARY_PATH="$lib/triplet"
    mkdir "$lib/triplet" && mv "$lib"/libglarepp.so* "$lib/triplet"
    ok 'and from lib/TRIPLET' ./ocio "$cli/c.ocio"
    mv "$lib/glarepp/glarepp-ocio.so" "$lib/triplet"
    ok 'and beside it' ./ocio "$cli/c.ocio"
    mv "$lib/triplet/glarepp-ocio.so" .
    [ -e /usr/local/lib/glarepp/glarepp-ocio.so ] ||
        no 'but not in the folder of the program' ./ocio "$cli/c.ocio"
else
    skip 4 'no glarepp-ocio.so'
fi

done_testing
