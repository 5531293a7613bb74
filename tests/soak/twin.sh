#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# usage: twin.sh BUILD
# Builds the same source in another folder, and says whether the program and
# its bridges are the same bytes as those in BUILD; status 1 when one is not.
set -eu
differ=0
twin=$1/twin
rm -rf "$twin"
mkdir -p "$twin/a"
cp -r Makefile src man "$twin/a"
(cd "$twin/a" && make -s B=elsewhere elsewhere/glarepp \
    elsewhere/glarepp-oiio elsewhere/glarepp-ocio.so) >"$twin/log" 2>&1
for f in glarepp glarepp-oiio glarepp-ocio.so; do
    if cmp -s "$1/$f" "$twin/a/elsewhere/$f"; then
        echo "$f: the same bytes from another build folder"
    else
        echo "$f: other bytes from another build folder"
        differ=1
    fi
done
exit $differ
