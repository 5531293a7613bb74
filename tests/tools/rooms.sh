#!/bin/sh
# Usage: rooms.sh SRC
# Who may include whom: app -> {bench, compare} -> {glare, sun, scene, tone, io} -> {gl, core}.
# The middle rooms never meet, but that sun sees glare/kernel.h and sources.h;
# each library is seen by one room only.
src=$1
bad=0

# refuse ROOM PATTERN WHY: no include in ROOM matches PATTERN
refuse()
{
    [ -d "$src/$1" ] || return 0
    if grep -rnE "^ *# *include *$2" "$src/$1"; then
        echo "check-rooms: $1 $3" >&2
        bad=1
    fi
}

refuse core '"(app|glare|sun|scene|tone|io|gl)/' 'includes a room above it'
refuse gl '"(app|glare|sun|scene|tone|io)/' 'includes a room above it'
refuse bench '"(app|compare/[^f])/?' 'includes a room above it'
refuse compare '"(app|bench)/' 'includes a room above it'
refuse glare '"(app|sun|scene|tone|io)/' 'includes another room'
refuse sun '"(app|scene|tone|io)/' 'includes another room'
refuse sun '"glare/([^ks]|k[^e]|s[^o]|kernel[^.]|sources[^.])' 'includes more of glare'
refuse scene '"(app|glare|sun|tone|io)/' 'includes another room'
refuse tone '"(app|glare|sun|scene|io)/' 'includes another room'
refuse io '"(app|glare|sun|scene|tone)/' 'includes another room'
for room in app bench compare core gl glare sun scene tone; do
    refuse $room '<(openexr|Imf|OpenEXR|OpenImageIO|png|libdeflate)' \
        'sees a file format; only io may'
done
for room in app bench compare core glare sun scene tone io; do
    refuse $room '<(GL|EGL)/' 'sees GL; only gl may'
done
for room in app bench compare core gl glare sun scene io; do
    refuse $room '<OpenColorIO' 'sees OpenColorIO; only tone may'
done
exit $bad
