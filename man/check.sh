#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: check.sh GLAREPP FRESH_PAGE COMMITTED_PAGE
# The committed man page is what the program and glarepp.1.in make, is clean
# mdoc, and names the same options and statuses as --help and the parser.
glarepp=$1 fresh=$2 page=$3
failed=0

fail()
{
    echo "check-man: $*" >&2
    failed=1
}

cmp -s "$fresh" "$page" || fail "$page is stale; run make man"

if command -v mandoc >/dev/null; then
    complaints=$(mandoc -Tlint -Wall "$page" 2>&1)
    [ -z "$complaints" ] || fail "$complaints"
else
    echo "check-man: mandoc is missing, its check is left out" >&2
fi

# options_of [COMMAND]: those that its --help lists, one a line: "-o --output"
options_of()
{
    "$glarepp" "$@" --help all |
        sed -n 's/^ \{2,6\}\(-[a-z], \)\{0,1\}\(--[a-z-]*\).*/\1\2/p' | tr -d ,
}
commands='bench compare kernel lens sets styles'
help=$({ options_of; for command in $commands; do options_of $command; done; } |
    sort -u)
man=$(sed -n '/^\.Sh OPTIONS/,/^\.Sh THE REPORT/p' "$page" |
    sed -n 's/^\.It \(Fl \([a-z]\) , \)\{0,1\}Fl \\-\([a-z-]*\).*/-\2 --\3/p' |
    sed 's/^- //' | sort)
[ -n "$help" ] || fail "--help lists no options"
[ "$help" = "$man" ] || fail "--help and $page list different options:
--help:
$help
page:
$man"

# sections that `glarepp help` names
sections()
{
    "$glarepp" help | sed -n '/^a section/,/^$/s/^  [a-z]*  *//p'
    for topic in $("$glarepp" help |
        sed -n '/^options for/,/^$/s/^  \([a-z]*\)  *.*/\1/p'); do
        "$glarepp" help "$topic" | sed -n 's/.* in its section "\(.*\)"\.$/\1/p'
    done
}
[ "$(sections | wc -l)" -ge 12 ] || fail "help names too few sections"
sections | while read -r title; do
    grep -qx "\.S[hs] $title" "$page" || echo "$title"
done | grep . && fail "help names sections that $page does not have"

# keys of flare elements, as the reader refuses one that it does not know
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for shape in disc ring polygon streak image glow spikes caustic dirt; do
    echo '[{"shape": "'$shape'", "no such key": 1}]' > "$folder/flare.json"
    "$glarepp" --flare "$folder/flare.json" -o "$folder/out.png" \
        "$folder/none.exr" 2>&1 | sed -n 's/.*use one of //p' | tr -d '",' |
        tr ' ' '\n'
done | sort -u > "$folder/keys"
[ "$(wc -l < "$folder/keys")" -ge 30 ] || fail "too few keys of flares are known"
while read -r key; do
    grep -q "\"$key\": " "$page" || fail "$page lacks the flare key \"$key\""
done < "$folder/keys"

for command in '' $commands; do
    for option in $(options_of $command); do
        # (the value after it, which none takes, keeps anything from running)
        line=$("$glarepp" $command "$option" --help=1 2>&1)
        case $line in
        *"unknown option"* | *": not for "*)
            fail "$command --help lists $option, the parser: $line" ;;
        esac
    done
done
"$glarepp" --no-such-option 2>/dev/null
[ $? = 2 ] || fail "an unknown option is no usage error"

exit $failed
