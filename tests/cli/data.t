#!/bin/sh
# Every frame of the data folder goes through; every damaged one ends well:
# status 0, 3 or 4, one line, in little memory and time, and never a crash.
. "$(dirname "$0")/lib.sh"
[ -n "$data" ] || skip_all 'no data folder'

# Sanitizers reserve more address space than this
limit=4194304
(ulimit -v $limit && "$glarepp" --version) >/dev/null 2>&1 || limit=unlimited

# limited ARGUMENT...: as run, in 4 GB and 10 s
limited()
{
    (ulimit -v $limit && exec timeout 10 "$glarepp" "$@") >out 2>err
    status=$?
}

find "$data" -name '*.exr' -not -path '*/damaged/*' | sort >frames
while read -r f; do
    name=${f#"$data"/}
    rm -f h.exr
    case $name in
    deep/*)
        run --hdr h.exr "$f"
        fails_with 4 "$name" "$name is deep"
        ;;
    *)
        run --hdr h.exr --engine fft --report r.json "$f"
        [ $status = 0 ] && [ ! -s err ] && [ -s h.exr ] && [ -s r.json ]
        result $? "$name" || note "status $status: $(head -c 500 err)"
        ;;
    esac
done <frames
ok 'there are frames' [ "$(wc -l <frames)" -gt 30 ]

find "$data/damaged" -type f | sort >damaged
while read -r f; do
    name=${f##*/}
    rm -rf made && mkdir made
    limited --hdr made/h.exr -o made/p.png "$f"
    case $status in
    0) [ ! -s err ] && [ -s made/h.exr ] && [ -s made/p.png ] ;;
    3 | 4)
        [ "$(wc -l <err)" = 1 ] && grep -q "^glarepp: .*$name.*; ." err &&
            [ -z "$(ls -A made)" ]
        ;;
    *) false ;;
    esac
    result $? "damaged $(echo "$name" | cut -c1-40): $status" ||
        note "status $status, made $(ls -A made | xargs): $(head -c 500 err)"
done <damaged

if [ -n "$oiio" ]; then
    "$python" "$cli/damaged.py" "$glarepp" "$data/damaged" >same 2>/dev/null ||
        echo 'not ok damaged.py ends well' >>same
    verdicts same
else
    skip 3 'no OpenImageIO for python'
fi

done_testing
