#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Pages of compare as files: names, sizes, markup. What they show: tests/page/browser.t.
. "$(dirname "$0")/lib.sh"
need_python

frame seed.exr size=40x30 channels=R,G,B,A
run compare --html no/page.html seed.exr seed.exr
fails_with 4 no/page.html 'a page in no folder'
run compare --html page.html --html-index index.html seed.exr seed.exr
fails_with 64 index.html 'an index of one page'
run compare --html seed.exr seed.exr seed.exr
fails_with 64 seed.exr 'a page that would replace an input'
run bench --sun 4,4,1 --mask A --html sun.html seed.exr
fails_with 2 --html 'a page of the table of a sun'
is "$(ls -- *.html 2>/dev/null)" '' 'nothing is left of them'

run compare -q --html one.html --threads 1 seed.exr seed.exr
run compare -q --html one3.html --threads 3 seed.exr seed.exr
sed s/one3.html/one.html/ one3.html >three.html
same one.html three.html 'a page is the same for 1 and 3 threads'
run compare --html - seed.exr seed.exr
sed 's/--html -/--html one.html/' out >piped.html
same one.html piped.html 'a page on stdout, and nothing else'
is "$(grep -oE "https?://[^'\"]*|(src|href)=.[^'\"]*" one.html | sort -u)" \
    'href="data:,
http://www.w3.org/2000/svg' 'a page names no other place'
hash=$(sed -n '/^<script>/,/^<\/script>/p' one.html | sed '1s/^<script>//; $d' |
    "$python" -c 'import base64, hashlib, sys
print(base64.b64encode(hashlib.sha256(sys.stdin.buffer.read()).digest()).decode())')
ok 'its policy allows its script, by the hash' grep -qF "script-src 'sha256-$hash'" one.html

evil='<script>alert(1)<!--.exr'
frame "$evil" size=8x8 'channels=R,G,B,</script><b>:half'
run compare -q --html evil.html "$evil" "$evil"
status_is 0 'names like markup: status 0'
is "$(grep -c '<script' evil.html) $(grep -c '<!--\|<b>' evil.html)" '2 0' \
    'names like markup are none on a page'

frame noise.exr size=320x240 kind=dark
frame other.exr size=320x240 kind=dark seed=2
for size in 0.1 0.5; do
    run compare -q --no-flip --html size.html --html-size $size noise.exr other.exr
    ok "--html-size $size" [ "$(wc -c <size.html)" -le "${size#0.}00000" ]
done
# (limits around what is found, some of them none; and a NaN, which fails without one)
frame nan.exr size=320x240 kind=nan
cat >gates.py <<'END'
import json, random, re, subprocess, sys
random.seed(5)
worst = ["match", "warning", "failure"]
for i in range(24):
    words = []
    for name, most in (("fail", .5), ("warn", .5), ("hardfail", 2.), ("hardwarn", 2.),
                       ("failpercent", 100.), ("warnpercent", 100.), ("fail-rel", 2.),
                       ("allowfailures", 76800.)):
        if random.random() < .5:
            v = random.random() * most
            words += ["--" + name, "%d" % v if name[0] == "a" else "%g" % v]
    subprocess.run([sys.argv[1], "compare", "-q", "--no-flip", "--html", "g.html", *words,
                    "noise.exr", "nan.exr" if i % 6 == 5 else "other.exr"], check=False,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    entry = json.loads(re.search('application/json">(.*?)</script>',
                                 open("g.html", encoding="utf-8").read())[1])["entries"][0]
    of = [worst.index(g["status"]) for g in entry["gates"]]
    if worst[max(of, default=0)] != entry["facts"]["result"]:
        print(*words, entry["facts"]["result"], entry["gates"])
END
is "$("$python" gates.py "$glarepp" 2>&1)" '' 'the worst of the gates is the verdict'

frame t.exr size=4x4
mkdir many
for i in $(seq 150); do ln t.exr many/t.$i.exr; done
run compare --no-flip --html small.html --html-size 0.1 many/t.#.exr many/t.#.exr
like "$(cat err)" '*small.html: * MB, over --html-size*' 'a page that cannot be so small: a warning'

for i in 1 2 3; do cp seed.exr s.$i.exr; done
run compare -q -f 2-3 --html f.html s.#.exr s.#.exr
like "$(grep -o '"command":"glarepp compare [^"]*"' f.html)" '*--frames 2-3*' \
    'its command has the frames'
run compare -q --html 'p.#.html' --html-index index.html s.#.exr s.#.exr
is "$(ls p.*.html index.html | tr '\n' ' ')" 'index.html p.1.html p.2.html p.3.html ' \
    'a page for each frame, and their index'
mkdir below
run compare -q --html 'below/p.#.html' --html-index over.html s.#.exr s.#.exr
is "$(grep -o '"href":"[^"]*"' over.html | head -1)" '"href":"below/p.1.html"' \
    'an index over the folder of its pages links to them'
run compare -q --html 'p.#.html' --html-index below/index.html s.#.exr s.#.exr
fails_with 64 below/index.html 'an index beneath its pages'
cp seed.exr below/seed.exr
run compare -q --html two.html seed.exr below/seed.exr
like "$(grep -o '"command":"glarepp compare [^"]*"' two.html)" \
    '*seed.exr below/seed.exr --html two.html"' 'its command keeps folders'
run -q -g 0.5 -o "an a.exr" --hdr an.exr seed.exr
run compare -q --html made.html "an a.exr" an.exr
is "$(grep -o '"command":"glarepp --gain [^"]*"' made.html)" \
    "\"command\":\"glarepp --gain 0.5 seed.exr --output 'an a.exr'\"
\"command\":\"glarepp --gain 0.5 seed.exr --hdr an.exr\"" 'the commands of both, with their outputs'
run styles -q -o sheet.html --html-size 0.5 -t 2 seed.exr
status_is 0 'styles: the size of a page is not for its pictures'
ok 'styles --html-size' [ "$(wc -c <sheet.html)" -le 500000 ]
done_testing
