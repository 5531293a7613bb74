#!/bin/sh
# Commands of README and manual run as they are printed: those in blocks marked sh,
# each in a folder that holds only examples.
. "$(dirname "$0")/lib.sh"

mkdir bin
ln -s "$glarepp" bin/glarepp
PATH=$PWD/bin:$PATH
for page in "$root/README.md" "$root"/man/*.md; do
    name=$(basename "$page" .md)
    awk -v to="$PWD/$name" '/^```sh$/ { n++; on = 1; next } /^```$/ { on = 0 }
        on { print > (to "." n ".block") }' "$page"
done
for block in *.block; do
    rm -rf made && mkdir made && ln -s "$root/examples" made/examples
    (cd made && bash -e "../$block") >out 2>err
    result $? "$block: $(head -n 1 "$block")" || note "$(head -c 500 err)"
    ok "$block: makes a file" [ "$(ls made | wc -l)" -gt 1 ]
done
ok 'there are blocks' [ "$(ls ./*.block | wc -l)" -gt 5 ]
done_testing
