#!/bin/sh
# Kernels: models by the frame's angle, several at once, images of any size, and
# the command that writes, lists and checks them.
. "$(dirname "$0")/lib.sh"
need_python

frame in.exr seed=3
frame k.exr kind=kernel size=16x12 type=float

# -- angle ---------------------------------------------------------------------

run --fov 48 --layer l.exr --report r.json in.exr
quiet_success '--fov'
is "$(field r.json 'o["deg_per_pixel"], o["fov_from"]')" "(1.0, 'option')" \
    '--fov: degrees of a pixel of 48 lines'
run --layer l.exr --report r.json in.exr
is "$(field r.json 'o["deg_per_pixel"], o["fov_from"]')" "(0.625, 'default')" \
    'no --fov: 30 degrees high'
run -k k.exr --layer l.exr --report r.json in.exr
is "$(field r.json '"deg_per_pixel" in o')" False 'an image has no angle'

# -- several -------------------------------------------------------------------

run -k cie:age=70 -k star:share=.2 -k k.exr -e direct --layer l.exr \
    --report r.json in.exr
quiet_success 'two models and an image'
is "$(field r.json 'o["settings"]["kernel"]')" \
    "['cie:age=70', 'star:share=.2', 'k.exr']" 'the report names all'
run -k image:file=k.exr,share=1 -e direct --layer a.exr in.exr
run -k k.exr -e direct --layer b.exr in.exr
ok 'an image is its own recipe' "$glarepp" compare --fail-rel 1e-6 --no-flip \
    a.exr b.exr
set --
for i in 1 2 3 4 5 6 7 8 9; do set -- "$@" -k eye; done
run "$@" --layer l.exr in.exr
fails_with 2 'found 9' 'too many kernels'
run -k image:file=none.exr --layer l.exr in.exr
fails_with 3 none.exr 'an image that is missing'
run -k image:file=in.exr --layer in.exr in.exr
fails_with 2 in.exr "an image that would be replaced"
run -k eye --kernel-size 50 --layer l.exr in.exr
fails_with 2 --kernel-size 'a model in percent'
run -k eye --kernel-center 3,4 --layer l.exr in.exr
fails_with 2 --kernel-center "a model's centre"

# -- sizes of images -----------------------------------------------------------

run -k k.exr --kernel-size 100 --layer a.exr in.exr
run -k k.exr --layer b.exr in.exr
ok 'the size of 100 percent' "$glarepp" compare --fail 0 --no-flip a.exr b.exr
run -k k.exr --kernel-size 300% -e direct --layer a.exr --report r.json in.exr
is "$(field r.json '"deg_per_pixel" in o')" False 'percent have no angle'
# 12 lines of 30 / 48 degrees are 7.5 degrees, three times that 22.5
run -k k.exr --kernel-size 22.5deg -e direct --layer b.exr --report r.json \
    --grow kernel in.exr
is "$(field r.json 'o["deg_per_pixel"], o["width"]')" '(0.625, 111)' \
    'degrees: an angle, and a reach of 25 and 22 pixels'
run -k k.exr --kernel-size 22.5deg -e direct --layer b.exr in.exr
ok 'degrees and percent of one size' "$glarepp" compare --fail-rel 1e-6 \
    --no-flip a.exr b.exr

# -- glarepp kernel ------------------------------------------------------------

run kernel -k cie:age=70 -k star:share=.05 -k image:file=k.exr,share=.1 \
    --size 96x54 --fov 20 --rotate 10 -o a.exr
quiet_success 'kernel -o'
run kernel --from a.exr -o b.exr
same a.exr b.exr '--from: the same bytes'
run kernel --from k.exr -o b.exr
fails_with 4 k.exr '--from a file without a recipe'
run kernel --from a.exr -o a.exr
fails_with 2 a.exr '--from a file that would be replaced'
run kernel -k eye --size 64x48 --threads 1 -o a.exr
run kernel -k eye --size 64x48 --threads 2 -o b.exr
same a.exr b.exr 'the same bytes for any number of threads'
run -k eye -e direct --layer l.exr in.exr
run -k a.exr --kernel-normalize none -e direct --layer m.exr in.exr
ok 'the file makes the layer of its model' "$glarepp" compare --fail-rel 1e-6 \
    --no-flip l.exr m.exr
run kernel -k eye -o a.png
fails_with 2 a.png 'a kernel is an EXR file'
run kernel --list
quiet_success '--list'
is "$(grep -c '^[a-z]*: ' out)" "$(grep -c 'share=' out)" \
    '--list: each model has a share'
for model in spencer cie star cross streak ring circle gaussian moffat image; do
    grep -q "^$model: " out || echo $model
done >missing
is "$(cat missing)" '' '--list: every model'

done_testing
