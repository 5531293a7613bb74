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
"$python" "$root/tests/page/page.py" "$glarepp" "$root" "$axe" >verdicts 2>err
is "$? $(cat err)" '0 ' 'page.py ends'
verdicts verdicts
done_testing
