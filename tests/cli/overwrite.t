#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# No output may take the place of a file that the run reads, nor that of another
# output: files are told apart as files, whatever names they are given by.
. "$(dirname "$0")/lib.sh"
need_python

# -- files to lose -------------------------------------------------------------

mkdir w w/sq w/real
frame w/i.exr size=24x16 channels=R,G,B,A,Z:float
frame w/k.exr size=5x5
for n in 1 2 3; do cp w/i.exr w/sq/s.100$n.exr; cp w/i.exr w/sq/d.100$n.exr; done
cp w/i.exr w/d.exr
cp w/i.exr w/real/in.exr
cp w/i.exr w/j.exr
cp "$cli/c.ocio" w/c.ocio
echo '[{"position": [3, 3], "radius": 2, "flux": 10}]' >w/l.json
echo '[{"shape": "image", "image": "g.exr", "size": 0.2}]' >w/f.json
echo '[{"shape": "image", "image": "sq/s.1002.exr"}]' >w/f2.json
cp w/k.exr w/g.exr
echo '{"frames": [{"sun": [9, 9, 2]}]}' >w/c.json
echo '2 0 0 0 0 2 0 0 0 0 2 0' >w/four.spimtx
echo old >w/o.png
cp w/o.png w/o2.png
ln w/i.exr w/hard.exr
ln -s i.exr w/soft.exr
ln -s real w/also
ln -s new.png w/dangling.png
ln -s ../w/dangling.png w/chain.png
ln -s loop.png w/loop.png
ln w/o.png w/o-hard.png
sum() { (cd w && find . -type f -exec cksum {} + && ls -lR) | sort; }
sum >before

# refused NAME ARGUMENT...: status 2, a line that starts with NAME, and every
# file in the folder has its bytes, none comes and none goes
refused()
{
    name=$1
    shift
    (cd w && "$glarepp" "$@") >out 2>err
    status=$?
    sum >after
    case $1 in compare) wanted=64 ;; *) wanted=2 ;; esac
    [ $status = $wanted ] && [ "$(wc -l <err)" = 1 ] && cmp -s before after &&
        case $(cat err) in
        "glarepp: "$name": "*'; write to another name' | \
            "glarepp: "$name": "*'; give each a name of its own') true ;;
        *) false ;;
        esac
    result $? "$name: $*" || {
        note "status $status, $(cat err)"
        note "$(diff before after)"
    }
}

# table: a row a line, "NAME ARGUMENT..."; a name or argument has no blank
table()
{
    while read -r row; do
        # shellcheck disable=SC2086
        case $row in '' | '#'*) ;; *) refused $row </dev/null ;; esac
    done
}

sun='--sun 9,9,2 --sun-color 5'
table <<ROWS
# frames: by every output, under every name
i.exr --report i.exr -o p.png i.exr
i.exr --hdr i.exr i.exr
./i.exr --hdr ./i.exr i.exr
i.exr --layer i.exr i.exr
i.exr --debug sensors=i.exr i.exr
i.exr $sun --debug sunmap=i.exr i.exr
i.exr --tonemap none -o i.exr i.exr
soft.exr --hdr soft.exr i.exr
i.exr --hdr i.exr soft.exr
hard.exr --hdr hard.exr i.exr
i.exr --report i.exr hard.exr
also/in.exr --hdr also/in.exr real/in.exr
real/../also/in.exr --report real/../also/in.exr -o p.png real/in.exr
$tmp/w/i.exr --hdr $tmp/w/i.exr i.exr
j.exr --report j.exr i.exr j.exr
i.exr --no-clobber --hdr i.exr i.exr
i.exr --create-dir --hdr i.exr i.exr
i.exr --skip-bad-frames --hdr i.exr i.exr
# sequences: of any frame
sq/s.1002.exr --report sq/s.1002.exr --hdr sq/o.####.exr sq/s.####.exr
sq/s.1003.exr --report sq/s.1003.exr -f 1001-1003 sq/s.%04d.exr
sq/s.1001.exr --hdr sq/s.####.exr sq/s.####.exr
sq/s.1002.exr --hdr sq/s.%d.exr -f 1002 sq/s.####.exr
sq/s.1001.exr --hdr sq/s.####.exr --frame-jobs 3 ./sq/s.@@@@.exr
sq/d.1001.exr $sun --depth-file sq/d.####.exr --hdr sq/d.####.exr sq/s.####.exr
sq/d.1003.exr $sun --depth-file sq/d.####.exr --report sq/d.1003.exr sq/s.####.exr
./sq/d.1002.exr $sun --mask-file sq/d.%04d.exr --mask A --report ./sq/d.1002.exr sq/s.####.exr
# files that options read
k.exr -k k.exr --hdr k.exr i.exr
k.exr -k ./k.exr --report k.exr -o p.png i.exr
d.exr $sun --depth-file d.exr --hdr d.exr i.exr
d.exr $sun --mask-file d.exr --mask A --hdr d.exr i.exr
l.json --lights l.json --report l.json i.exr
./l.json --lights l.json --report ./l.json i.exr
f.json $sun --flare f.json --report f.json i.exr
c.json --camera c.json --report c.json i.exr
c.ocio --ocio c.ocio --report c.ocio -o p.png i.exr
# files named by these files
g.exr $sun --flare f.json --hdr g.exr i.exr
./g.exr $sun --flare ../w/f.json --report ./g.exr -o p.png i.exr
sq/s.1002.exr $sun --flare f2.json --report sq/s.1002.exr -o p.png i.exr
four.spimtx --ocio c.ocio --view Shot --report four.spimtx -o p.png i.exr
also/../four.spimtx --ocio $tmp/w/c.ocio --output-space shot --report also/../four.spimtx --hdr h.exr i.exr
# the other commands
i.exr bench --csv i.exr i.exr
hard.exr bench --json hard.exr i.exr
k.exr bench -k k.exr --csv k.exr i.exr
l.json bench --lights l.json --csv l.json i.exr
d.exr bench --sun 9,9,2 --depth-file d.exr --json d.exr i.exr
i.exr compare --json i.exr i.exr j.exr
soft.exr compare --json soft.exr j.exr i.exr
hard.exr compare --heatmap hard.exr i.exr j.exr
sq/s.1002.exr compare --json sq/s.1002.exr sq/s.####.exr sq/d.####.exr
sq/d.1001.exr compare --heatmap sq/d.####.exr sq/s.####.exr sq/d.####.exr
sq/d.1003.exr compare --heatmap sq/d.####.exr -f 1003,1001 sq/s.####.exr ./sq/d.####.exr
ROWS

# stdin is a file where it comes from one
(cd w && "$glarepp" --hdr i.exr - <i.exr) >out 2>err
status=$?
fails_with 2 i.exr 'a frame from stdin'
(cd w && "$glarepp" --hdr i.exr /dev/stdin <i.exr) >out 2>err
status=$?
fails_with 2 i.exr 'a frame from /dev/stdin'
(cd w && OCIO=c.ocio "$glarepp" --ocio env --report c.ocio -o p.png i.exr) \
    >out 2>err
status=$?
fails_with 2 c.ocio 'the config of $OCIO'
sum >after
ok 'stdin and $OCIO: all is as it was' cmp before after

# -- one output and another ----------------------------------------------------

table <<ROWS
# files to come
*p.png -o ./p.png --layer p.png i.exr
*o.exr --hdr sq/o.exr --debug sensors=./sq/o.exr i.exr
*r.png --report r.png -o ./r.png i.exr
*p.png -o p.png -o p.png i.exr
*p.png -o real/p.png -o also/p.png i.exr
*p.png -o $tmp/w/p.png -o p.png i.exr
*p.png --create-dir -o n/m/p.png --layer n//./x/../m/p.png i.exr
*p.png --create-dir -o also/m/p.png --layer real/m/p.png i.exr
*p.png --create-dir -o n/../p.png --layer p.png i.exr
*p.png --create-dir -o $tmp/w/n/p.png --layer n/p.png i.exr
# a link to nothing makes what it leads to
*.png -o new.png --layer dangling.png i.exr
*.png -o chain.png --layer new.png i.exr
# files that are there
*.png -o o.png --layer ./o.png i.exr
*.png -o o.png --layer o-hard.png i.exr
*.png --report o-hard.png -o o.png i.exr
# sequences
sq/o.1001.exr --hdr sq/o.####.exr --layer ./sq/o.%04d.exr sq/s.####.exr
*sq/o.1002.exr --hdr sq/o.####.exr --report ./sq/o.1002.exr sq/s.####.exr
# the other commands
*x.svg bench --csv ./x.svg --plot x.svg i.exr
*x bench --csv x --json ./x i.exr
*x.png compare --heatmap x.png --json ./x.png i.exr j.exr
*x.1002.png compare --heatmap x.####.png --json ./x.1002.png sq/s.####.exr sq/d.####.exr
ROWS

# -- harmless names ------------------------------------------------------------

# taken ARGUMENT...: fine, without a word
taken()
{
    (cd w && timeout 60 "$glarepp" -e direct "$@") >out 2>err </dev/null
    status=$?
    quiet_success "taken: $*"
}

mkfifo w/pipe w/other
taken -o /dev/null --stdout-format png -o /dev/null --layer /dev/null i.exr
taken --report /dev/null --hdr /dev/null i.exr
taken --report /dev/stdout --stdout-format png -o /dev/fd/1 i.exr
taken --report /dev/fd/1 --layer /dev/stdout --stdout-format exr i.exr
(cd w && cat pipe >/dev/null) &
taken --hdr pipe --report /dev/null i.exr
wait $!
(cd w && cat i.exr >pipe) & # read as a frame, and its namesake as output
(cd w && cat other >/dev/null) &
taken --stdout-format exr --layer other pipe
wait
taken -q --report r.json -k i.exr i.exr # (-q: a frame has an edge)
taken $sun --depth-file i.exr --mask-file i.exr --mask A --report r.json i.exr
taken --report r.json i.exr i.exr
taken -o o.png --layer h.exr --report r.json i.exr
taken -o o.png --layer h.exr --report r.json i.exr # over its own files
taken -o dangling.png i.exr
taken --hdr sq/i.exr --layer real/i.exr i.exr
taken --hdr sq/lit.####.exr sq/s.####.exr
taken -q --hdr sq/lit.####.exr --no-clobber --report r.json sq/s.####.exr
taken --create-dir --hdr n/a/x.exr --layer n/b/x.exr i.exr

# -- open descriptors ----------------------------------------------------------

kept() { sum >after; cmp -s before after; result $? "$1: as it was"; }
sum >before
(cd w && exec "$glarepp" --hdr /dev/fd/7 i.exr 7<>i.exr) >out 2>err
status=$?
fails_with 2 /dev/fd/7 'a descriptor of the frame'
kept 'a descriptor of the frame'
(cd w && exec "$glarepp" --hdr - i.exr) 1<>w/i.exr 2>err
status=$?
: >out
fails_with 2 - 'the frame as stdout'
kept 'the frame as stdout'
(cd w && exec "$glarepp" --hdr - -) <w/i.exr 1<>w/i.exr 2>err
status=$?
fails_with 2 - 'stdin as stdout'
kept 'stdin as stdout'
(cd w && exec "$glarepp" --hdr - i.exr) >copy.exr 2>err
status=$?
quiet_success 'another file as stdout'
(cd w && exec "$glarepp" --hdr /dev/fd/7 --report /dev/fd/7 i.exr \
    7>../both) >out 2>err
status=$?
quiet_success 'one descriptor for two'
kept 'the folder'

# logs that others write too keep their lines, in front
head -c 99999 /dev/zero | tr '\0' l >log
"$glarepp" -q --no-provenance -o one.png w/i.exr 2>err
cat log one.png >wanted || exit 1
for to in /dev/stdout /dev/fd/1 /proc/self/fd/1 -; do
    cat log >logged
    "$glarepp" -q --no-provenance -o $to --stdout-format png w/i.exr \
        >>logged 2>err
    same logged wanted "$to, appended to a log"
done
cat log >logged
"$glarepp" -q -o one.png --report /dev/stderr w/i.exr 2>>logged
is "$(head -c 99999 logged | cmp - log; tail -n 1 logged | cut -c 1-100001 |
    tr -d l | cut -c 1)" '{' 'a report by /dev/stderr, appended to a log'

# appended LABEL ARGUMENT...: what the log held stays in front of the output
appended()
{
    label=$1
    shift
    cat log >logged
    "$glarepp" "$@" >>logged 2>err </dev/null
    is "$? $(head -c 99999 logged | cmp - log) $(($(wc -c <logged) > 99999))" \
        '0  1' "$label: appended to a log" || note "$(cat err)"
}
ln -s /dev/stdout ln
ln -s /proc/self/fd/1 ln.exr
ln -s ln.exr ln.png
ln -s /proc/thread-self/fd descriptors
names="ln ln.exr descriptors/1 /proc/thread-self/fd/1 /dev/../dev/stdout"
for to in $names /proc/self/task/../fd/1; do
    appended "--report $to" -q -o one.png --report $to w/i.exr
    appended "-o $to" -q -o $to --stdout-format png w/i.exr
    appended "--json $to" compare -q --json $to w/i.exr w/i.exr
done
for to in ln.exr ln.png; do
    appended "-o $to" -q -o $to w/i.exr
    appended "--layer $to" -q --layer $to w/i.exr
    appended "--debug sensors=$to" -q --debug sensors=$to w/i.exr
    appended "--heatmap $to" compare -q --heatmap $to w/i.exr w/i.exr
done
appended '--hdr ln.exr' -q --hdr ln.exr w/i.exr
appended 'kernel -o ln.exr' kernel -q -k star -o ln.exr
ln -s ln.exr ln.svg
for option in '--csv ln' '--json ln' '--plot ln.svg'; do
    # shellcheck disable=SC2086
    appended "bench $option" bench -q --runs 1 $option w/i.exr
done
rm ln ln.exr ln.png ln.svg descriptors
# the log of another process, and a name of /proc for a file
cat log >logged
sleep 60 >>logged &
other=/proc/$!/fd/1
ln -s "$other" w/other.exr
cp log w/log
for name in /proc/self/cwd/w/log "$other" w/other.exr; do
    for option in "-o $name --stdout-format png" "-o o.png --report $name" \
        "--hdr $name --stdout-format exr"; do
        # shellcheck disable=SC2086
        run -q $option w/i.exr
        fails_with 3 "$name" "a file by a name in /proc: $option"
    done
done
kill $!
wait $! 2>/dev/null
same w/log log 'a file by a name in /proc: as it was'
same logged log 'the log of another process: as it was'
rm w/log w/other.exr
# a report by a link to nothing makes what it leads to, as other outputs do
ln -s there.json w/link.json
run -q -o one.png --report w/link.json w/i.exr
quiet_success 'a report by a link to nothing'
is "$(readlink w/link.json) $(wc -l <w/there.json)" 'there.json 1' \
    'a report by a link to nothing: the file'
rm w/link.json w/there.json

# modes: those of a replaced file, else by umask
for mask in 022 027 077; do
    mkdir moded
    (umask $mask && exec "$glarepp" -q -o moded/o.png --hdr moded/h.exr \
        --layer moded/l.tif --report moded/r.json w/i.exr) >out 2>err
    is "$(stat -c %a moded/* | sort -u)" $(printf %o $((0666 & ~0$mask))) \
        "umask $mask: the mode of new files"
    chmod 604 moded/*
    (umask $mask && exec "$glarepp" -q -o moded/o.png --hdr moded/h.exr \
        --layer moded/l.tif --report moded/r.json w/i.exr) >out 2>err
    is "$(stat -c %a moded/* | sort -u)" 604 "umask $mask: replaced files"
    rm -r moded
done

run -o w/loop.png w/i.exr
fails_with 3 w/loop.png 'a link to itself'
done_testing
