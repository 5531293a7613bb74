#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Pages of compare, styles and bench in a headless chromium: page.py makes frames and
# pages, presses keys, drags, and reads what the canvas shows.
. "$(dirname "$0")/../cli/lib.sh"
need_python
[ -n "$oiio" ] || skip_all 'no numpy'
"$python" -c 'import sys
sys.path.insert(0, sys.argv[1])
import browser
sys.exit(not browser.find())' "$root/tests/page" || {
    skip 1 'no chromium'
    done_testing
    exit
}
# (axe-core finds what a screen reader, or an eye, cannot read; make deps fetches it)
axe=
for folder in "$(dirname "$glarepp")" "$root/build"; do
    [ -n "$axe" ] || [ ! -f "$folder/axe.min.js" ] || axe=$folder/axe.min.js
done
[ -n "$axe" ] || skip 1 'no axe-core'
frame seed.exr size=40x30
run compare --html no/page.html seed.exr seed.exr
fails_with 4 no/page.html 'a page in no folder'
run compare --html page.html --html-index index.html seed.exr seed.exr
fails_with 64 index.html 'an index of one page'
run compare --html seed.exr seed.exr seed.exr
fails_with 64 seed.exr 'a page that would replace an input'
run compare -q --html one.html --threads 1 seed.exr seed.exr
run compare -q --html one3.html --threads 3 seed.exr seed.exr
sed s/one3.html/one.html/ one3.html >three.html
same one.html three.html 'a page is the same for 1 and 3 threads'
is "$(grep -oE "https?://[^'\"]*|(src|href)=.[^'\"]*" one.html | sort -u)" \
    'href="data:,
http://www.w3.org/2000/svg' 'a page names no other place'
run compare --html - seed.exr seed.exr
sed 's/--html -/--html one.html/' out >piped.html
same one.html piped.html 'a page on stdout, and nothing else'
"$python" "$root/tests/page/page.py" "$glarepp" "$root" "$axe" >verdicts 2>err
is "$? $(cat err)" '0 ' 'page.py ends'
verdicts verdicts
done_testing
