#!/bin/sh
# Real lenses: glarepp lens lists, checks and draws them; files that are wrong.
. "$(dirname "$0")/lib.sh"

# -- the installed lenses ------------------------------------------------------

"$glarepp" lens --list >list 2>err
result $? 'lens --list'
is "$(wc -l <list)" 6 'six lenses'
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
wrong 2 ''
wrong 2 '--check heliar --list'
wrong 2 '--draw a.svg --list'
wrong 2 '--check heliar frame.exr'
wrong 3 '--check heliar --draw no/such/folder.svg'
cp long.json kept.json
wrong 2 '--check long.json --draw long.json'
cmp -s long.json kept.json
result $? 'a drawing does not replace its lens'

done_testing
