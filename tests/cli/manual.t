#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Commands of README and manual run as they are printed, each in a folder that holds
# only examples: blocks marked sh, and lines and words in quotes that name a file of
# examples. Options that pages name are there.
. "$(dirname "$0")/lib.sh"

mkdir bin
ln -s "$glarepp" bin/glarepp
PATH=$PWD/bin:$PATH
for page in "$root/README.md" "$root"/man/*.md; do
    name=$(basename "$page" .md)
    awk -v to="$PWD/$name" '
        function block(text) { print text > (sprintf("%s.%02d.block", to, ++n)) }
        /^```sh$/ { on = 1; n++; next }
        /^```$/ { on = 0 }
        on { print > (sprintf("%s.%02d.block", to, n)); next }
        /^    glarepp .*examples\// { block(substr($0, 5)); next }
        { while (match($0, /`glarepp [^`]*examples\/[^`]*`/)) {
            block(substr($0, RSTART + 1, RLENGTH - 2))
            $0 = substr($0, RSTART + RLENGTH) } }' "$page"
    [ "$name" = changes ] || # (it names options that went)
        grep -oE '`--?[a-z][^`]*`' "$page" | grep -oE -- '(^`-[a-z]\>|--[a-z][a-z-]+)' |
        tr -d '`' | sed "s/\$/ $name/"
done | sort -u >options
ok 'there are blocks' [ "$(ls ./*.block | wc -l)" -gt 50 ]
# (half of the blocks are the gallery's, by one script for each kernel and style)
n=0
for block in gallery.*.block; do
    n=$((n + 1))
    [ -z "$quick" ] && [ $((n % 10)) = 0 ] || rm "$block"
done
for block in *.block; do
    rm -rf made && mkdir made && ln -s "$root/examples" made/examples
    (cd made && bash -e "../$block") >out 2>err
    result $? "$block: $(head -n 1 "$block")" || note "$(head -c 500 err)"
    ok "$block: makes a file" [ "$(ls made | wc -l)" -gt 1 ]
done

{
    "$glarepp" --help all
    for command in bench compare kernel lens sets styles; do
        "$glarepp" $command --help
    done
} >help
while read -r option page; do
    grep -qE -- "(^|[ ,])$option([ ,=]|\$)" help || echo "$option ($page)"
done <options >unknown
is "$(cat unknown)" '' "options of pages: $(wc -l <options)"
done_testing
