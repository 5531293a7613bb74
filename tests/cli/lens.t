#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Real lenses: glarepp lens lists, checks and draws them; files that are wrong.
. "$(dirname "$0")/lib.sh"

# -- the installed lenses ------------------------------------------------------

"$glarepp" lens --list >list 2>err
result $? 'lens --list'
is "$(wc -l <list)" 6 'six lenses'
run lens
quiet_success 'lens alone lists'
same out list 'the same'
while read -r name rest; do
    "$glarepp" lens --check "$name" >out 2>err
    result $? "lens --check $name"
    grep -q "^patent  *US [0-9],\\?[0-9]" out
    result $? "$name names its patent"
done <list

# -- a lens that is not what it says ---------------------------------------------

cat >long.json <<'JSON'
{"name": "105 mm that is 100.6", "claims": {"focal_length": 105},
 "surfaces": [{"radius": 100.6, "thickness": 0.001, "n": 1.5, "semi": 10},
              {"radius": -100.6, "thickness": 1, "semi": 10},
              {"stop": true, "semi": 8}]}
JSON
"$glarepp" lens --check long.json >out 2>err
is $? 1 'a claim that the surfaces do not meet: status 1'
is "$(grep -c '^fault: ' out)" 1 'and one line that says so'
grep -q '^focal length 100.6.* claimed 105 (-4.19 %)' out
result $? 'with what was found'

# control and bidirectional characters of a file move no cursor
printf '%s' '{"name": "a\u001b[31m\u202eb", "note": "\u009b2J\u007f", "patent": "\u2066c",
 "surfaces": [{"radius": 50, "thickness": 1, "n": 1.5, "semi": 10},
              {"radius": -50, "thickness": 1, "semi": 10},
              {"stop": true, "semi": 8}]}' >marks.json
"$glarepp" lens --check marks.json --draw marks.svg >out 2>err
result $? 'a lens with control characters in its names'
no 'none of which is printed' env LC_ALL=C grep -q "$(printf '\033\\|\302\233\\|\177\\|\342\200\256\\|\342\201\246')" out err marks.svg

"$glarepp" lens --check heliar >out
is "$(grep -c '^image height .* claimed 50.5: covered$' out)" 1 \
    'an image height that the rims cover, beside its claim'
is "$(grep -c '^ghosts .* on the axis at 587.6 nm' out)" 1 'ghosts of one wavelength'

# -- the drawing -----------------------------------------------------------------

"$glarepp" lens --check heliar --draw a.svg >out 2>err
result $? '--draw'
is "$(grep -c 'class="glass"' a.svg)" 5 'five glasses'
is "$(grep -c 'class="ray"' a.svg | tr 1-9 y)" y 'and rays'
is "$(tail -n 1 a.svg)" '</svg>' 'whole'

# -- wrong files and command lines -------------------------------------------------

wrong()
{
    "$glarepp" lens $2 >out 2>err
    is "$? $(wc -l <err)" "$1 1" "lens $2: status $1, one line"
}
echo '{"name": "a", "surfaces": [{"semi": 1, "thickness": 1, "n": 9}]}' >n.json
printf '{"name": "a", "surfaces": [' >cut.json
echo '{"name": "neg", "surfaces": [{"radius": -50, "thickness": 2, "n": 1.5,
"semi": 5}, {"thickness": 1, "semi": 5}, {"stop": true, "semi": 3}]}' >neg.json
wrong 4 '--check n.json'
grep -q '^glarepp: n.json: surface 1: "n" ' err
result $? 'that names file, surface and key'
wrong 4 '--check cut.json'
wrong 4 '--check neg.json'
wrong 3 '--check none.json'
wrong 3 '--check nosuch'
wrong 2 '--draw a.svg'
wrong 2 '--check heliar --list'
wrong 2 '--draw a.svg --list'
wrong 2 '--check heliar frame.exr'
wrong 3 '--check heliar --draw no/such/folder.svg'
wrong 2 '--check heliar --draw picture.png'
grep -q '^glarepp: picture.png: .*\.svg$' err
result $? 'a drawing is an SVG by its name too'
cp long.json kept.json
wrong 2 '--check long.json --draw long.json'
cmp -s long.json kept.json
result $? 'a drawing does not replace its lens'

# -- ghosts in a frame -----------------------------------------------------------

need_python
frame in.exr size=120x80 kind=dark dim=0.01 seed=2 attr=aperture:float:8 \
    attr=focus:float:2
cat >lamps.json <<'JSON'
[{"pixel": [30.5, 20.5], "flux": [900, 800, 700]},
 {"pixel": [90, 60], "flux": 0}]
JSON
set -- --lights lamps.json --sun-in-frame -t 1e9 -q --report r.json
"$glarepp" "$@" --lens heliar --layer a.exr in.exr
result $? '--lens'
is "$(field r.json 'o["lens"]["lights"], o["lens"]["sensor_from"]')" \
    "(1, 'lens')" 'one light has flux; the sensor is the lens'\''s own'
is "$(field r.json 'o["lens"]["ghosts"] + o["lens"]["ghosts_left_out"]')" 28 \
    '28 ghosts'
is "$(field r.json 'o["lens"]["left_out"] <= 1e-3')" True \
    'those left out stay under --tolerance'
is "$(field r.json '0 < o["lens"]["bound"] == o["bound"] < 1')" True \
    'and are in the bound'
is "$(field r.json '0 < sum(o["lens"]["flux"]) < 24')" True \
    'all ghosts have less than a hundredth of the light'
is "$(field r.json '"lens" in o["times_ms"]')" True 'timed'
"$glarepp" "$@" --lens heliar --threads 1 --layer b.exr in.exr
"$glarepp" compare --no-flip --fail 0 a.exr b.exr >out
result $? 'the same for one thread'
for other in '--f-number 3.5' '--focus-distance 100' '--sensor-size 36' \
    '--fov 20' '--tolerance 1'; do
    "$glarepp" "$@" --lens heliar $other --layer b.exr in.exr
    "$glarepp" compare --no-flip --fail 0 a.exr b.exr >out
    is $? 2 "$other changes them"
done
is "$(field r.json 'o["lens"]["ghosts"]')" 0 '--tolerance 1 leaves all out'
"$glarepp" "$@" --lens heliar --f-number 8 --focus-distance 2 --layer b.exr \
    in.exr
"$glarepp" compare --no-flip --fail 0 a.exr b.exr >out
result $? "without options, the frame's attributes aperture and focus"

frame sized.exr size=120x80 kind=dark dim=0.01 seed=2 \
    attr=sensorOverallDimensions:v2f:36,24 attr=focus:float:2 \
    attr=aperture:float:8
"$glarepp" "$@" --lens heliar --layer b.exr sized.exr
is "$(field r.json 'o["lens"]["sensor_mm"], o["lens"]["sensor_from"]')" \
    "(36.0, 'attribute')" 'and the size of its sensor'
"$glarepp" "$@" --lens heliar --sensor-size 36 --layer c.exr in.exr
"$glarepp" compare --no-flip --fail 0 b.exr c.exr >out
result $? 'as by --sensor-size'
"$glarepp" "$@" --lens heliar --fov 20 --layer b.exr sized.exr
is "$(field r.json 'o["lens"]["sensor_from"]')" angle 'but an angle says more'

# without lights, of bright pixels
frame lit.exr size=64x48 seed=5 lights=9
"$glarepp" -q --lens tessar --report r.json --layer a.exr lit.exr
is "$(field r.json '0 < o["lens"]["lights"] <= 9')" True \
    'groups of bright pixels are lights'
is "$(field r.json 'o["bound"] > o["lens"]["bound"] > 0')" True \
    'the bound is of glare and ghosts'
"$glarepp" -q --layer b.exr lit.exr
"$glarepp" compare --no-flip --fail 0 a.exr b.exr >out
is $? 2 'whose ghosts the layer has'
"$glarepp" -q -t 1e9 --lens tessar --layer a.exr in.exr
result $? 'a dark frame'

# -- with what hides a light -------------------------------------------------------

# two_of KEY: of a sun behind a mask, and of one that nothing hides
frame veil.exr size=96x64 seed=3 channels=R,G,B,A
set -- --sun 40.5,30.5,6 --sun-color 4e3 --sun-in-frame -t 1e9 -q --lens heliar \
    --tolerance 0
"$glarepp" "$@" --report clear.json --layer a.exr veil.exr
"$glarepp" "$@" --report hidden.json --mask A --layer b.exr veil.exr
is "$(field hidden.json '0.05 < o["lights"][0]["visibility"] < 0.95')" True \
    'a sun that is partly hidden'
is "$("$python" -c 'import json
a, b = (json.load(open(f)) for f in ("clear.json", "hidden.json"))
v = b["lights"][0]["visibility"]
print(all(abs(y - v * x) < 1e-6 * x
          for x, y in zip(a["lens"]["flux"], b["lens"]["flux"])))')" True \
    'its ghosts have its visible share of their light'
printf '{"name": "veil", "surfaces": [%s,%s,%s]}' \
    '{"radius": 50, "thickness": 1, "n": 1.5, "semi": 10}' \
    '{"radius": -50, "thickness": 1, "semi": 10}' \
    '{"stop": true, "semi": 8}' >veil.json
"$glarepp" -q --sun 40.5,30.5,6 --sun-color 4e3 --lens ./veil.json --mask A \
    --layer b.exr veil.exr
result $? 'a sun beside the frame'"'"'s own light, in a lens of a file'

# -- the starburst -----------------------------------------------------------------

recipe()
{
    "$glarepp" -q --tonemap none -o x.exr --report r.json "$@" &&
        field r.json 'o["kernel"]["recipes"][-1], o["fov_from"]'
}
frame open.exr size=64x48 seed=5 lights=9 attr=aperture:float:5.6
near='aperture:blades=7,fnumber'
case $(recipe --lens zoom-wide -k aperture lit.exr) in
"('$near=3.5,focal=36.022', 'lens')") result 0 'the stop of the lens' ;;
*) result 1 'the stop of the lens' ;;
esac
case $(recipe --lens zoom-wide -k eye -k aperture --f-number 11 open.exr) in
"('$near=11,focal=36.022', 'lens')") result 0 'closed by --f-number' ;;
*) result 1 'closed by --f-number' ;;
esac
case $(recipe --lens zoom-wide -k aperture open.exr) in
"('$near=5.6,focal=36.022', 'lens')") result 0 "and by the frame's aperture" ;;
*) result 1 "and by the frame's aperture" ;;
esac
is "$(recipe --lens zoom-wide -k aperture:blades=5,roundness=.1,fnumber=8,focal=50 \
    --fov 20 lit.exr)" \
    "('aperture:blades=5,roundness=0.1,fnumber=8,focal=50', 'option')" 'written keys win'
is "$(recipe -k aperture lit.exr)" "('aperture', 'default')" 'none without --lens'
# frames of one run have their own stop
cp lit.exr seq.1.exr
cp open.exr seq.2.exr
"$glarepp" -q --tonemap none --lens zoom-wide -k aperture -o seq.out.@.exr \
    --report r.json seq.@.exr
"$glarepp" -q --tonemap none --lens zoom-wide -k aperture -o two.exr open.exr
"$glarepp" compare --no-flip --fail 0 seq.out.2.exr two.exr >out
result $? 'frames of a sequence have each its own'

cp list nolens.json
wrong_run()
{
    want=$1
    shift
    "$glarepp" -q "$@" --layer x.exr in.exr >out 2>err
    is "$? $(wc -l <err)" "$want 1" "$*: status $want, one line"
}
wrong_run 4 --lens ./nolens.json
wrong_run 3 --lens nosuch
wrong_run 2 --lens heliar --f-number 3.47 # its own is 3.5
wrong_run 2 --f-number 8
wrong_run 2 --lens heliar --focus-distance 0.05
wrong_run 2 --lens heliar --sensor-size 0
"$glarepp" --sensor-size 36 --layer x.exr in.exr 2>err
is "$(grep -c 'sensor-size.*--lens' err)" 1 'options of no lens are warned of'
cp long.json own.json
"$glarepp" -q --lens ./own.json --layer own.json in.exr 2>err
is $? 2 'an output does not replace the lens'

done_testing
