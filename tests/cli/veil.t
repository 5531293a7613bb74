#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The veil of a frame as a number, against closed forms (tests/bench/veil.py), and what
# the report says without units.
. "$(dirname "$0")/lib.sh"
need_python

ok 'L_v, illuminance, TI, UGR and DGP are those of closed forms' \
    "$python" "$root/tests/bench/bars.py" "$glarepp" veil

# -- units ---------------------------------------------------------------------

frame in.exr seed=3
frame nits.exr seed=3 attr=whiteLuminance:float:250
frame dark.exr kind=dark
run --layer l.exr --report r.json in.exr
like "$(field r.json 'o["veil"]')" "{'missing': 'cd/m2 of 1 not known:*'}" \
    'no figures without units'
run --layer l.exr --report a.json nits.exr
run --layer l.exr --luminance-scale 250 --report b.json in.exr
is "$(field a.json 'o["veil"]["white"], o["veil"]["luminance"] > 0')" '(250.0, True)' \
    'units of the file'
is "$(field a.json 'o["veil"]')" "$(field b.json 'o["veil"]')" 'and of the option'
run --layer l.exr --luminance-scale 500 --report b.json nits.exr
is "$(field b.json 'o["veil"]["white"]')" 500.0 'the option rules'
is "$(field b.json 'set(o["veil"]) & {"ugr", "dgp"}')" 'set()' \
    'no UGR of a frame that shows little'
run --layer l.exr --projection plane --report r.json nits.exr
is "$(field r.json 'o["veil"]')" "{'missing': 'pixels of a plane have no directions'}" \
    'a plane'
run --threads 1 --layer l.exr --report b.json nits.exr
is "$(field a.json 'o["veil"]')" "$(field b.json 'o["veil"]')" 'any number of threads'

# -- the eye ---------------------------------------------------------------------

is "$(field a.json 'o["veil"]["fixation"], o["veil"]["age"]')" '([32.0, 24.0], 35.0)' \
    'the middle, 35 years'
run --layer l.exr -k eye -k cie:age=70,pigment=1 --fixation 10,5.5 --report b.json nits.exr
is "$(field b.json '[o["veil"][k] for k in ("fixation", "age", "pigment")]')" \
    '[[10.0, 5.5], 70.0, 1.0]' 'by options'
run -q --layer l.exr --luminance-scale 100 --projection latlong --report r.json dark.exr
is "$(field r.json '[o["veil"][k] for k in ("sources", "luminance_of_sources", "ugr")], round(o["veil"]["dgp"] - 5.87e-5 * o["veil"]["illuminance"], 9), o["veil"]["seen"]' |
    sed 's/1\.00[0-9]*/1/')" '([0, 0.0, None], 0.16, 1)' 'no source: no UGR'
# a light by flux, 10 degrees off: E is 2 cd/m2 x 5e4 cos(t)^4 over the square of the
# focal length, 100 pixels, and L_v by CIE 146
frame black.exr kind=zeros size=200x200 channels=R,G,B
frame noise.exr kind=dark size=200x200 channels=A
for row in '1 -q' '0 --sun-in-frame --flare preset:zoom' '1 --mask A --mask-file noise.exr'; do
    run -q --layer l.exr --projection perspective --fov 90 --luminance-scale 2 \
        --sun 117.6327,100,1 --sun-color 5e4 ${row#* } --report r.json black.exr
    is "$(field r.json "(lambda v, s: (round(v['illuminance'] / s, 4),
        round(v['luminance'] / s, 4), v['sources']))(o['veil'],
        o['lights'][0]['visibility'])")" \
        "$([ "${row%% *}" = 1 ] && echo '(9.406, 0.674, 1)' || echo '(0.0, 0.0, 0)')" \
        "a light by flux, ${row#* }"
done
for row in 'fisheye 9999,3' 'fisheye 2,2' 'latlong 32,-3' 'latlong 65,24'; do
    run -q --layer l.exr --luminance-scale 100 --projection ${row% *} \
        --fixation=${row#* } --report r.json in.exr
    like "$(field r.json 'o["veil"]')" "{'missing': '*has no direction'}" \
        "no figures of a place without direction, $row"
done
run --fixation 3 --report r.json -o o.png in.exr
fails_with 2 '--fixation' 'one number'
run --fixation 3,4 -o o.png in.exr
fails_with 2 '--fixation: no output shows' 'no report that shows it'
run --luminance-scale -1 -o o.png in.exr
fails_with 2 '--luminance-scale' 'a negative scale'
done_testing
