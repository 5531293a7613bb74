#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The program and its bridges are built to be hard to abuse: what the linker
# and the compiler were asked for is read back from the files that they made.
. "$(dirname "$0")/lib.sh"
command -v readelf >/dev/null || skip_all 'no readelf'
readelf -h "$glarepp" >elf.h 2>/dev/null || skip_all 'no ELF'
! sanitized || skip_all 'a build for a sanitizer has none of it'

# -- protection compiled into the files ------------------------------------------

is_pie()
{
    readelf -Wh "$1" | grep -q 'Type:.* DYN' &&
        readelf -Wd "$1" | grep -q 'FLAGS_1.* PIE'
}

# tables of addresses are read-only once the linker has filled them
has_relro()
{
    readelf -Wl "$1" | grep -q '^ *GNU_RELRO'
}

# and it fills all of them at the start
binds_now()
{
    readelf -Wd "$1" | grep -qE 'BIND_NOW|FLAGS_1.* NOW'
}

stack_is_data()
{
    readelf -Wl "$1" | grep '^ *GNU_STACK' >stack.list &&
        ! grep -q 'E *0x[0-9a-f]*$' stack.list
}

# no page is both written and run
writes_or_runs()
{
    ! readelf -Wl "$1" | grep -q '^ *LOAD.* RWE '
}

guards_stack()
{
    readelf -W --dyn-syms "$1" | grep -qE ' __stack_chk_(fail|guard)'
}

# copies and prints whose room is known check it
is_fortified()
{
    readelf -W --dyn-syms "$1" |
        grep -qE ' __(memcpy|memset|memmove|snprintf|vsnprintf|read)_chk'
}

# jumps land only where a jump may; of the CPUs that know of it
marks_targets()
{
    case $(readelf -h "$1" | sed -n 's/ *Machine: *//p') in
    *X86-64) mark=endbr64 ;;
    AArch64) mark='bti|paciasp' ;;
    *) return 0 ;;
    esac
    objdump -d --no-show-raw-insn "$1" | grep -cE "$mark" >marks
    [ "$(cat marks)" -ge "$2" ]
}

# -- the program and its bridges ---------------------------------------------------

ok 'glarepp: may lie at any address' is_pie "$glarepp"
ok 'glarepp: checks copies' is_fortified "$glarepp"
folder=$(dirname "$glarepp")
ok 'glarepp-oiio: may lie at any address' is_pie "$folder/glarepp-oiio"
for file in "$glarepp" "$folder/glarepp-oiio" "$folder/glarepp-ocio.so"; do
    name=$(basename "$file")
    if [ ! -f "$file" ]; then
        skip 6 "no $name beside the program"
        continue
    fi
    ok "$name: read-only relocations" has_relro "$file"
    ok "$name: bound at the start" binds_now "$file"
    ok "$name: no code on the stack" stack_is_data "$file"
    ok "$name: no page written and run" writes_or_runs "$file"
    ok "$name: guards its stack" guards_stack "$file"
    ok "$name: marks the targets of jumps" marks_targets "$file" 20
done

# -- a program that has none of it: these tests can fail -----------------------------

cat >weak.c <<'C'
#include <stdio.h>
#include <string.h>
int main(int n, char **v)
{
    char room[64];
    memcpy(room, v[0], (size_t) n);
    return printf("%s", room) < 0;
}
C
if ! cc -O2 -U_FORTIFY_SOURCE -no-pie -fno-pie -fno-stack-protector -o weak weak.c \
    -Wl,-z,norelro,-z,lazy,-z,execstack 2>/dev/null; then
    skip 6 'no compiler for a weak program'
else
    for asked in is_pie has_relro binds_now stack_is_data guards_stack \
        is_fortified; do
        no "a weak program: not $asked" $asked weak
    done
fi
done_testing
