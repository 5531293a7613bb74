#!/bin/sh
# The share of the sun against the truth that a second camera measured, which
# looks at the sun.
. "$(dirname "$0")/lib.sh"
need_python

# measures ARGUMENT...: reports of the frames with truth, in r.json
measures()
{
    : >r.json
    for stem in seq_foliage/foliage seq_foliage/foliage_f32 rendered/window \
        rendered/brightsky scenes/forest; do
        "$glarepp" -q "$@" --camera "$data/$stem.camera.json" \
            --report one.json "$data/$stem.####.exr" || return 1
        cat one.json >>r.json
    done
}

# -- the frame alone -----------------------------------------------------------

if [ -n "$data" ] && [ -f "$data/scenes/forest.camera.json" ]; then
    measures
    is "$("$python" "$cli/shares.py" "$data" r.json 0.02,0.051 2>found)" \
        '17 17 True' 'depth: intervals hold the truth; mean and worst error'
    note "depth, $(cat found)"
    is "$(field r.json 'o["sun_edges"][:11]')" 'depth alone' \
        'depth alone is named, with its error'
    measures --mask A
    is "$("$python" "$cli/shares.py" "$data" r.json 0.006,0.02 2>found)" \
        '17 17 True' 'coverage: intervals hold the truth; mean and worst error'
    note "coverage, $(cat found)"
    is "$(field r.json '"sun_edges" in o')" False 'coverage has no such line'
else
    skip 4 "$no_data"
fi

done_testing
