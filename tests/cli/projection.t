#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Projections: glare by true angles, its facts, its error and what refuses it.
# shellcheck disable=SC2016
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr seed=3
frame wide.exr seed=5 size=640x480

# -- facts ---------------------------------------------------------------------

run --projection plane -k eye --layer plane.exr --report r.json in.exr
is "$(field r.json 'o["projection"], "bound_angle" in o')" "('plane', False)" \
    'a plane where it is asked for'
run --fov 60 -k eye --layer l.exr --report r.json wide.exr
quiet_success 'without --projection'
is "$(field r.json 'o["projection"], o["engine"], o["engine_why"][:6]')" \
    "('perspective', 'levels', 'levels')" 'levels'
is "$(field r.json '0 < o["bound_angle"] <= o["bound"] <= 1e-3')" True \
    'within the tolerance'
is "$(field r.json 'round(o["deg_per_pixel"], 4)')" 0.1378 \
    'degrees of a pixel in the middle: 2 tan 30 / 480'
run --projection perspective -k k.exr --layer l.exr in.exr
like "$(cat err)" '*k.exr: *' 'no such kernel, by any projection'
run --projection cube --layer l.exr in.exr
status_is 2 'no such projection'

# -- error -----------------------------------------------------------------------

for words in '--fov 30' '--fov 90' '--fov 120 --edges black' '--edges mirror'; do
    # shellcheck disable=SC2086
    run --projection perspective $words -k eye --verify --layer l.exr \
        --report r.json in.exr
    quiet_success "$words: verified"
    is "$(field r.json 'o["measured"]["rel_l2"] <= o["bound"]')" True \
        "$words: within the bound"
done
run --projection perspective -e direct -k eye --fov 90 --verify --layer l.exr \
    --report r.json in.exr
is "$(field r.json 'o["engine"], o["measured"]["rel_l2"] < 1e-6')" \
    "('direct', True)" 'direct is the sum as it is defined'
run --projection perspective --verify --layer l.exr --report r.json wide.exr
is "$(field r.json '0 < o["measured"]["pixels"] <= 640 * 480')" True \
    'pixels that were summed'

# -- the rest of a run -------------------------------------------------------------

run -e splat --projection perspective -k eye --layer no.exr wide.exr
status_is 2 'splat draws one shape everywhere'
like "$(cat err)" '*--projection plane*' 'and says what to do'
is "$(ls no.exr 2>/dev/null)" '' 'nothing is written'
run --projection perspective --style star --layer l.exr --report r.json wide.exr
quiet_success 'a model with rays beside others'
run --projection plane --save-settings s.txt --layer a.exr wide.exr
run --settings s.txt --layer b.exr wide.exr
same a.exr b.exr 'settings keep the projection'
run --layer a.exr wide.exr
run --threads 1 --layer b.exr wide.exr
same a.exr b.exr 'the same bytes by one thread'
run --projection perspective --fov 0.001 --layer l.exr --report r.json in.exr
status_is 0 'a tele lens'
run --projection perspective --fov 170 --layer l.exr --report r.json in.exr
quiet_success 'an angle that no level serves is of a plane'

done_testing
