# SPDX-License-Identifier: Apache-2.0
# Shared by the command-line tests; each does  . "$(dirname "$0")/lib.sh"
#
# Afterwards the working folder is a fresh one that goes away at exit, and
#   $glarepp  the program: env GLAREPP, else build/glarepp
#   $root     the repository
#   $data     the optional data folder: env GLAREPP_DATA, else ../shared/data;
#             empty when there is none
#   $python   a python for helpers beside this file, empty when there is none
# Numbers of tests are counted here, and done_testing prints the plan: a test
# that ends early has none and fails.

root=$(cd "$(dirname "$0")/.." && pwd)
[ -d "$root/tests" ] || root=${root%/tests} # of a test in tests/cli
cli=$root/tests/cli
case ${GLAREPP-} in
'') glarepp=$root/build/glarepp ;;
/*) glarepp=$GLAREPP ;;
*) glarepp=$PWD/$GLAREPP ;;
esac
data=$(cd "$root" && cd "${GLAREPP_DATA:-../shared/data}" 2>/dev/null && pwd) ||
    data=
no_data='no data folder (../shared/data, or $GLAREPP_DATA)'
python=/usr/bin/python3
[ -x "$python" ] || python=$(command -v python3 || :)
# numpy and OpenImageIO, to compare pixels: GLAREPP_TEST_OIIO says yes or no, as
# run.sh has found once for all
oiio=
case ${GLAREPP_TEST_OIIO-} in
yes) oiio=yes ;;
no) ;;
*) [ -n "$python" ] && "$python" -c 'import numpy, OpenImageIO' 2>/dev/null &&
    oiio=yes ;;
esac
quick=${GLAREPP_TEST_QUICK-}
unset GLAREPP_OSMESA GLAREPP_EGL
export PYTHONDONTWRITEBYTECODE=1

tests=0
status=0
tmp=$(mktemp -d "${TMPDIR:-/tmp}/glarepp-test.XXXXXX") || exit 1
mounted=
cleanup()
{
    [ -z "$mounted" ] || umount "$mounted"
    cd / && chmod -R u+w "$tmp" && rm -rf "$tmp"
}
trap cleanup EXIT
trap 'exit 1' INT TERM HUP
cd "$tmp" || exit 1

if [ ! -x "$glarepp" ]; then
    echo "Bail out! no program at $glarepp; build it, or set GLAREPP"
    exit 1
fi

# sanitized: the program brings a sanitizer's run time along
sanitized()
{
    ldd "$glarepp" 2>/dev/null | grep -qE 'lib[a-z]*san\.'
}

# -- results -------------------------------------------------------------------

note()
{
    printf '%s\n' "$*" | sed 's/^/# /'
}

# result 0|1 DESCRIPTION: 0 is fine, as exit statuses are
result()
{
    tests=$((tests + 1))
    if [ "$1" = 0 ]; then
        echo "ok $tests - $2"
        return 0
    fi
    echo "not ok $tests - $2"
    return 1
}

# ok DESCRIPTION COMMAND...: the command succeeds
ok()
{
    description=$1
    shift
    "$@" >ok.log 2>&1
    result $? "$description" || { note "$*"; note "$(head -c 2000 ok.log)"; }
}

# no DESCRIPTION COMMAND...: the command fails
no()
{
    description=$1
    shift
    ! "$@" >ok.log 2>&1
    result $? "$description" || { note "$*"; note "$(head -c 2000 ok.log)"; }
}

# is GOT WANTED DESCRIPTION
is()
{
    [ "$1" = "$2" ]
    result $? "$3" || note "found '$1', wanted '$2'"
}

# like TEXT PATTERN DESCRIPTION: a shell pattern
like()
{
    case $1 in
    $2) result 0 "$3" ;;
    *) result 1 "$3" || note "found '$1', wanted '$2'" ;;
    esac
}

# skip COUNT WHY
skip()
{
    skipped=0
    while [ $skipped -lt "$1" ]; do
        tests=$((tests + 1)) skipped=$((skipped + 1))
        echo "ok $tests # SKIP $2"
    done
}

# skip_all WHY: the whole file, before its first test
skip_all()
{
    echo "1..0 # SKIP $1"
    exit 0
}

need_python()
{
    [ -n "$python" ] || skip_all "no python3 to make frames"
}

# verdicts FILE: numbers its lines "ok DESC", "not ok DESC" and "# note"
verdicts()
{
    while read -r line; do
        case $line in
        'ok '*) result 0 "${line#ok }" ;;
        'not ok '*) result 1 "${line#not ok }" ;;
        *) note "${line#\# }" ;;
        esac
    done <"$1"
}

done_testing()
{
    echo "1..$tests"
}

# -- the program ---------------------------------------------------------------

# run ARGUMENT...: stdout and stderr go to the files out and err, $status is
# the exit status
run()
{
    "$glarepp" "$@" >out 2>err
    status=$?
}

# no_provenance: from here on pictures do not say what made them, for tests in
# which two commands make the same bytes
no_provenance()
{
    cat >.glarepp <<SH
#!/bin/sh
case \$1 in
compare | bench | kernel | help) exec "$glarepp" "\$@" ;;
esac
exec "$glarepp" --no-provenance "\$@"
SH
    chmod +x .glarepp
    glarepp=$tmp/.glarepp
}

# status_is WANTED DESCRIPTION
status_is()
{
    [ "$status" = "$1" ]
    result $? "$2" || {
        note "status $status, wanted $1"
        note "$(head -c 1000 err)"
    }
}

# quiet_success DESCRIPTION: status 0 and not a word on stderr
quiet_success()
{
    [ "$status" = 0 ] && [ ! -s err ]
    result $? "$1" || {
        note "status $status"
        note "$(head -c 1000 err)"
    }
}

# one_line_error NAME DESCRIPTION: stderr is one line in the documented form,
# "glarepp: FILE: what is wrong (found); what to do", and holds NAME
one_line_error()
{
    [ "$(wc -l <err)" = 1 ] && [ "$(tail -c 1 err | wc -l)" = 1 ] &&
        grep -q '^glarepp: [^ ].*; .' err && grep -qF -e "$1" err
    result $? "$2" || note "stderr: $(head -c 1000 err)"
}

# fails_with STATUS NAME DESCRIPTION: status and line in one
fails_with()
{
    status_is "$1" "$3: status $1"
    one_line_error "$2" "$3: one line that names $2"
}

# same A B DESCRIPTION: two files of the same bytes, not empty
same()
{
    [ -s "$1" ] && cmp -s "$1" "$2"
    result $? "$3" || note "$1 and $2 differ, or are missing"
}

# empty_folder FOLDER DESCRIPTION: no file under final or temporary name
empty_folder()
{
    is "$(ls -A "$1")" '' "$2"
}

# field FILE EXPRESSION: of the first line, o being the object
field()
{
    "$python" -c 'import json, sys
o = json.loads(open(sys.argv[1]).readline())
print(eval(sys.argv[2]))' "$1" "$2" 2>&1
}

# answers SCRIPT: from here on  ask FUNCTION WORD...  calls a function of that
# python script, and succeeds when it raises nothing (ask.py)
answers()
{
    mkfifo .questions .answers || exit 1
    "$python" "$cli/ask.py" "$1" <.questions >.answers &
    exec 8>.questions 9<.answers
}
ask()
{
    { printf '%s\037' "$@" && echo; } >&8
    read -r answer <&9 || answer='no answer'
    [ "$answer" = ok ] || {
        echo "$answer" >&2
        return 1
    }
}

# -- frames --------------------------------------------------------------------

# frame FILE [key=value...]: an uncompressed EXR; the keys are in exr.py
frame()
{
    "$python" "$cli/exr.py" "$@" || exit 1
}

# png_size FILE: "WxH bits colour-type"
png_size()
{
    od -An -tu1 -j16 -N10 "$1" | awk '{
        print (($1 * 256 + $2) * 256 + $3) * 256 + $4 "x" \
              (($5 * 256 + $6) * 256 + $7) * 256 + $8, $9, $10 }'
}
