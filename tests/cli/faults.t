#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Calls that fail, one after another, in small runs of every kind: the status
# is a documented one, an error is one line, each output is whole or is not
# there, no memory leaks and no temporary file is left. tests/faults/drive.py
# does the work.
#
# GLAREPP_TEST_LONG tries every point of every run; GLAREPP_TEST_QUICK some.
. "$(dirname "$0")/lib.sh"
need_python
built=$(dirname "$glarepp")/tests
shim=$built/shim.so
[ -f "$shim" ] || skip_all "no $shim"
# the sanitizers' own allocator would not hear of it
if LC_ALL=C grep -qa __asan_init "$glarepp"; then
    skip_all 'AddressSanitizer has an allocator of its own'
fi
[ "$(LD_PRELOAD=$shim FAULT_LOG=$tmp/log "$glarepp" --version >out 2>&1
    grep -c '^malloc' log)" = 1 ] || skip_all 'nothing can be preloaded'

frame in.exr size=32x24 channels=R,G,B,A,Z:float type=half lights=20
frame parts.exr size=32x24 channels=R,G,B,A part=depth:Z:float part=ids:id:uint
frame views.exr size=24x16 attr=multiView:stringvector:left,right lights=9 \
    channels=R,G,B,key.R,key.G,key.B,right.R,right.G,right.B,key.right.R,key.right.G,key.right.B
for n in 1 2 3; do
    frame s.000$n.exr size=20x15 seed=$n lights=9
done
frame big.exr size=400x300 lights=3
echo '[{"pixel": [20, 10], "radius": 2, "flux": [5, 5, 5]}]' >lights.json
cat >lamp.gltf <<'JSON'
{"asset": {"version": "2.0"}, "cameras": [{"type": "perspective",
 "perspective": {"yfov": 1, "znear": 1}}], "extensions": {"KHR_lights_punctual":
 {"lights": [{"type": "point"}]}}, "nodes": [{"camera": 0}, {"translation":
 [0, 0, -9], "extensions": {"KHR_lights_punctual": {"light": 0}}}]}
JSON
cp "$root/tests/frames/flare.json" .
cp "$cli/c.ocio" . || exit 1

"$python" "$root/tests/faults/drive.py" "$glarepp" "$shim" all >drive.log 2>&1
is $? 0 'the faults were tried'
verdicts drive.log

# -- memory after a failing call ---------------------------------------------------

if command -v valgrind >valgrind.path && [ -z "$quick" ]; then
    cat >checked <<'RUN'
#!/bin/sh
# the shim is for the program alone; of its free()s valgrind hears all
LD_PRELOAD=$FAULT_SHIM exec valgrind -q --error-exitcode=99 --leak-check=full \
    --errors-for-leak-kinds=definite --soname-synonyms=somalloc=nouserintercepts \
    --suppressions="$SUPPRESSIONS" "$@"
RUN
    chmod +x checked
    SUPPRESSIONS=$root/tests/valgrind.supp FAULT_RUN=$tmp/checked \
        FAULT_ONLY=malloc:N \
        "$python" "$root/tests/faults/drive.py" "$glarepp" "$shim" \
        direct >leaks.log 2>&1
    is $? 0 'valgrind looked on'
    sed 's/ok \([a-z]*\),/ok valgrind, \1,/' leaks.log >leaks
    verdicts leaks
else
    skip 1 'no valgrind'
fi

# -- GL that breaks ---------------------------------------------------------------

broken=$built/broken_gl.so
# breaks KIND ARGUMENT...: status 5, one line, no file; twice as --gl osmesa
breaks()
{
    kind=$1
    shift
    rm -rf made && mkdir made
    BROKEN_GL=$kind GLAREPP_OSMESA=$broken "$glarepp" --gl osmesa "$@" \
        -o made/a.png --hdr made/h.exr --report made/r.json in.exr >out 2>err
    status=$?
    fails_with 5 OSMesa "GL, $kind, $*"
    empty_folder made "GL, $kind, $*: nothing is left"
}
if GLAREPP_OSMESA=$broken "$glarepp" -e splat --projection plane --gl osmesa --layer gl.exr \
    in.exr >out 2>err; then
    "$glarepp" -e splat --projection plane --gl osmesa --layer plain.exr in.exr
    same gl.exr plain.exr 'GL that does not break'
    for kind in context current old missing compile link framebuffer memory \
        lost; do
        breaks $kind -e splat --projection plane
        breaks $kind -e direct --sun 12,8,3 --sun-color 9,8,7 \
            --sun-method readback
    done
    # other engines run on
    for kind in context compile lost; do
        BROKEN_GL=$kind GLAREPP_OSMESA=$broken "$glarepp" --gl osmesa \
            --layer any.exr in.exr >out 2>err
        status=$?
        quiet_success "GL, $kind: no matter for auto"
    done
    # the other system steps in
    if GLAREPP_OSMESA=/nonexistent "$glarepp" -e splat --projection plane --layer egl.exr in.exr \
        >out 2>err; then
        BROKEN_GL=context GLAREPP_OSMESA=$broken "$glarepp" -e splat --projection plane \
            --layer other.exr in.exr >out 2>err
        status=$?
        quiet_success 'OSMesa breaks: EGL steps in'
        same other.exr egl.exr 'OSMesa breaks: EGL steps in, with its bytes'
    else
        skip 2 'no EGL'
    fi
    MESA_GL_VERSION_OVERRIDE=2.1 "$glarepp" -e splat --projection plane --gl osmesa --layer old.exr \
        in.exr >out 2>err
    status=$?
    fails_with 5 'needs OpenGL 4.5' 'a Mesa of OpenGL 2.1'
    echo 'no library' >text.so
    GLAREPP_OSMESA=$tmp/text.so "$glarepp" -e splat --projection plane --gl osmesa \
        --layer old.exr in.exr >out 2>err
    status=$?
    fails_with 5 text.so 'a library that is none'
else
    skip 70 'no OSMesa'
fi

# -- the environment --------------------------------------------------------------

# A variable that is added moves the environment under threads that read it:
# the variables for GL are set before there are any. (MESA_DEBUG
# has GL tell of calls without a context: two are open here, or one.)
lights='--sun 12,8,3 --sun-color 9,8,7 --mask G --sun-method mask'
while read -r gl what; do
    case $gl in
    none) ;;
    *) "$glarepp" -q -e splat --projection plane --gl $gl --layer can.exr in.exr 2>err || {
        skip 2 "no context by $gl"
        continue
    } ;;
    esac
    rm -rf made log && mkdir made
    # shellcheck disable=SC2086
    env -u LP_NUM_THREADS -u EGL_LOG_LEVEL MESA_DEBUG=1 ENVIRON_LOG=$tmp/log \
        LD_PRELOAD=$built/environ.so "$glarepp" $what --threads 3 >out 2>err
    status=$?
    quiet_success "variables: $gl, $what"
    ok 'variables: some are added, none beside threads' \
        eval '! grep beside-threads log && grep -q "^added" log'
done <<END
osmesa -e splat --projection plane --gl osmesa $lights --frame-jobs 3 -o made/a.#.png s.####.exr
egl -e splat --projection plane --gl egl $lights --frame-jobs 3 -o made/a.#.png s.####.exr
osmesa bench --gl osmesa --runs 1 --csv made/a.csv in.exr
egl bench --gl egl --runs 1 --csv made/a.csv in.exr
none --ocio c.ocio --view Power --frame-jobs 3 -o made/a.#.jpg s.####.exr
END

# -- inputs and places -------------------------------------------------------------

# A file that shrinks or grows while others read it has its rows above. Here
# the limits are those of the system.
"$glarepp" -e direct --hdr whole.exr --compression none in.exr
for blocks in 0 1 2 4 8 16; do
    rm -rf made && mkdir made
    # (no file can take its words either)
    { (ulimit -f $blocks; "$glarepp" -e direct --hdr made/h.exr \
        --compression none in.exr); echo $? >&3; } 2>&1 >out 3>code | cat >err
    status=$(cat code)
    if [ $status = 0 ]; then
        same made/h.exr whole.exr "files of $blocks blocks at most: whole"
    else
        fails_with 3 made/h.exr "files of $blocks blocks at most"
        empty_folder made "files of $blocks blocks at most: nothing is left"
    fi
done

# Memory that ends: the line may be any of many, a signal may be none of them
rm -rf made && mkdir made
small="$glarepp -e direct --threads 1 --no-provenance"
$small --hdr ends.exr -o ends.png s.0001.exr
for kib in 4000 8000 12000 16000 20000 30000 50000 80000 120000; do
    (ulimit -v $kib; exec $small --hdr made/h.exr -o made/a.png s.0001.exr) \
        >out 2>err
    status=$?
    case $status in
    0) is "$(ls made | xargs)" 'a.png h.exr' "$kib KiB are enough" ;;
    70 | 3) one_line_error '' "$kib KiB are not enough: one line"
        # (the first file may be whole when memory ends in the second)
        [ ! -e made/h.exr ] || cmp -s made/h.exr ends.exr
        result $? "$kib KiB are not enough: a file that is left is whole"
        rm -f made/h.exr
        empty_folder made "$kib KiB are not enough: nothing else is left" ;;
    127 | 126) note "$kib KiB: not even started ($(head -c 200 err))" ;;
    *) result 1 "$kib KiB: status $status, $(head -c 200 err)" ;;
    esac
    rm -f made/*
done

# Root may write everywhere and start what it likes: another user tries
user=
if [ "$(id -u)" = 0 ]; then
    user='setpriv --reuid 65533 --regid 65533 --clear-groups'
    chmod 755 . && mkdir built && cp "$glarepp" "${glarepp%/*}"/glarepp-* built
    glarepp=$tmp/built/glarepp
    # a folder for the counters of a build for coverage, which are not needed
    mkdir -m 777 counters
    export GCOV_PREFIX=$tmp/counters
fi
if command -v prlimit >user.log && $user "$glarepp" --version >user.log 2>&1; then
    mkdir locked && cp in.exr locked/old.exr && chmod 555 locked
    cp in.exr kept.exr && chmod 444 kept.exr
    while read -r what out why; do
        # shellcheck disable=SC2086
        $user "$glarepp" $what "$out" s.0001.exr >out 2>err
        status=$?
        fails_with 3 "$out" "$why"
    done <<'END'
-o locked/a.png a folder that is read-only
--hdr locked/old.exr a file in a folder that is read-only
--hdr kept.exr a file that is read-only
END
    is "$(ls locked)" old.exr 'nothing is left in a read-only folder'
    same locked/old.exr in.exr 'what is in a read-only folder stays'

    # Threads that cannot start: the same bytes by one, or one line. (Not for
    # splat: llvmpipe waits for ever for its own)
    mkdir few && chmod 777 few
    for engine in direct fft; do
        "$glarepp" -q -e $engine --hdr many.exr s.0001.exr 2>err
        for n in 1 2 3 4 6; do
            # shellcheck disable=SC2086
            timeout 60 $user prlimit --nproc=$n "$glarepp" -e $engine \
                --threads 4 --hdr few/h.exr s.0001.exr >out 2>err
            status=$?
            quiet_success "$engine, $n threads may start"
            same few/h.exr many.exr "$engine, $n threads may start: the bytes"
            rm -f few/h.exr
        done
    done
    if "$glarepp" -q -o many.tif s.0001.exr 2>err; then
        for n in 1 2 4 8 16; do
            # shellcheck disable=SC2086
            $user prlimit --nproc=$n "$glarepp" -o few/a.tif s.0001.exr \
                >out 2>err
            status=$?
            if [ $status = 0 ]; then
                same few/a.tif many.tif "OpenImageIO, $n threads may start"
                rm few/a.tif
            else
                fails_with 3 few/a.tif "OpenImageIO, $n threads may start"
                empty_folder few "OpenImageIO, $n threads: nothing is left"
            fi
        done
    fi
else
    skip 20 'no setpriv and prlimit'
fi

done_testing
