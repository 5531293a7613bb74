#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What may glare: --source-mask by channel, file and Cryptomatte, and --source, held
# against frames of known coverage and sums in plain Python (mask.py), at 1e-6.
. "$(dirname "$0")/lib.sh"
need_python
real=$glarepp
no_provenance
answers "$cli/mask.py"

linear='--type float --compression none'
# masks MASK FRAME...: the light that glares, of all pixels, to s.exr
masks()
{
    mask=$1
    shift
    # shellcheck disable=SC2086
    run -t 0 --source-mask "$mask" $linear --debug sensors=s.exr --report r.json "$@"
}
ask kernel k.exr && ask make in.exr || { echo "Bail out! no frames"; exit 1; }
known='truth 0 0 40 30'

# -- channels and files --------------------------------------------------------------

masks key.matte in.exr
quiet_success 'a channel'
ok 'a channel: each pixel times it, clamped to 0 to 1' ask sensors s.exr in.exr channel key.matte
is "$(field r.json 'o["source_mask"]')" key.matte 'the report names it'
masks '!key.matte' in.exr
ok '! inverts it' ask sensors s.exr in.exr not channel key.matte
ask make m.exr matte=A
for word in key.matte '!key.matte' m.exr '!m.exr' 'crypto:lamp*,wall'; do
    "$real" -q -t 0 --source-mask "$word" -o a.png in.exr
    "$real" -q --settings a.png -o b.png in.exr
    same a.png b.png "--settings of --source-mask $word: the same picture"
done
for matte in A W R,G,B R,G,B,A; do
    rm -f m.exr
    ask make m.exr matte=$matte
    masks m.exr in.exr
    ok "a file with $matte" ask sensors s.exr in.exr m.exr channel "${matte##*,}"
done
ask make small.exr matte=A size=20x12 origin=10,9
masks small.exr in.exr
ok 'a smaller file: 0 outside' ask sensors s.exr in.exr small.exr channel A
masks '!small.exr' in.exr
ok '! of a smaller file: 1 outside' ask sensors s.exr in.exr small.exr not channel A
cp in.exr key.matte
ask make m.exr matte=A
cp m.exr R
masks R in.exr
ok 'a channel comes before a file of its name' ask sensors s.exr in.exr channel R
masks ./R in.exr
ok 'a path is a file' ask sensors s.exr in.exr m.exr channel A
mkdir seq
for n in 1 2; do
    cp in.exr seq/f.$n.exr
    ask make seq/m.$n.exr matte=A size=${n}0x20
done
run -t 0 --source-mask 'seq/m.#.exr' $linear --debug sensors='seq/s.#.exr' 'seq/f.#.exr'
quiet_success 'files by pattern'
for n in 1 2; do
    ok "files by pattern: $n" ask sensors seq/s.$n.exr in.exr seq/m.$n.exr channel A
done

# -- Cryptomatte ---------------------------------------------------------------------

# covers ABOUT FRAME WORDS CRYPTO TRUTH...: coverage is that which was put there
covers()
{
    about=$1 frame=$2 words=$3
    shift 3
    masks "$words" "$frame"
    quiet_success "$about: no word"
    # shellcheck disable=SC2086
    ok "$about: the coverage that is there" ask sensors s.exr "$frame" "$@"
}
# shellcheck disable=SC2086
{
covers 'one object' in.exr crypto:lamp $known lamp
is "$(field r.json 'o["source_mask"]')" lamp 'one object: the report'
covers 'two' in.exr crypto:wall,lamp_b $known wall lamp_b
covers 'wild cards' in.exr 'crypto:lamp?*' $known lamp_b 'lamp[0]' lamp392 lamp7
is "$(field r.json 'o["source_mask"]')" 'lamp_b, lamp[0], lamp392, lamp7' 'wild cards: the report'
covers 'hashes that are no floats' in.exr crypto:lamp7,lamp392 $known lamp7 lamp392
covers 'brackets are no wild cards' in.exr 'crypto:lamp[0]' $known 'lamp[0]'
covers 'one character' in.exr 'crypto:рав?ина' $known равнина
covers 'slashes' in.exr 'crypto:*polygons:?' $known /obj/box:polygons:1
covers 'commas, quoted' in.exr 'crypto:name\, with\, comma' $known 'name, with, comma'
covers '* as it is' in.exr 'crypto:a\*b' $known 'a*b'
covers '* of all' in.exr 'crypto:a*b' $known 'a*b' aXb
covers 'a material' in.exr crypto:brass $known brass
covers 'all but' in.exr '!crypto:lamp,wall' not $known lamp wall
for spelling in r,g,b,a red,green,blue,alpha Red,Green,Blue,Alpha; do
    ask make c.exr spelling=$spelling
    covers "channels $spelling" c.exr crypto:wall $known wall
done
ask make c.exr parts=1
ask make flat.exr
masks crypto:wall c.exr
quiet_success 'a part for each layer: no word'
ok 'a part for each layer' ask sensors s.exr flat.exr $known wall
mkdir beside
ask make beside/c.exr manifest=names.json
covers 'a manifest beside the file' beside/c.exr 'crypto:wa*' $known wall
ask make c.exr manifest=none
covers 'no manifest: whole names' c.exr crypto:wall,lamp $known wall lamp
ask make c.exr origin=-7,12 size=33x21 display=-10,10,40,40
covers 'a data window' c.exr crypto:wall truth -7 12 33 21 wall
run -t 0 --source-mask crypto:wall --grow 9 $linear --debug sensors=s.exr c.exr
ok 'a data window, grown' ask sensors s.exr c.exr truth -7 12 33 21 wall
}
ask make c.exr manifest=none
masks crypto:wall,nobody c.exr
like "$status $(cat err)" '0 *warning: c.exr: no pixel is of nobody*' \
    'no manifest: a name that is in no pixel is a warning'
for threads in 1 2 5; do
    "$glarepp" --threads $threads --source-mask 'crypto:*b*' --layer t$threads.exr in.exr
    same t1.exr t$threads.exr "--threads $threads: the same bytes"
done

# -- the layer, and sums ---------------------------------------------------------------

plain="-t 0 -k k.exr --kernel-normalize none --mix add $linear"
# shellcheck disable=SC2086
for engine in direct fft; do
    run -e $engine $plain --layer l.exr in.exr
    ok "$engine: the layer" ask layer l.exr in.exr all
    run -e $engine $plain --source-mask key.matte --layer l.exr in.exr
    ok "$engine: the layer of a mask" ask layer l.exr in.exr channel key.matte
    run -e $engine $plain --source-mask 'crypto:lamp*' --layer l.exr in.exr
    ok "$engine: the layer of objects" ask layer l.exr in.exr $known lamp lamp_b \
        'lamp[0]' lamp392 lamp7
done
ask make other.exr bright=9
# shellcheck disable=SC2086
{
run -q -e direct $plain --source other.exr --layer l.exr --hdr h.exr --report r.json in.exr
quiet_success '--source'
ok '--source: the layer is of its light' ask layer l.exr other.exr all
ok '--source: and is added to the frame' ask lit h.exr in.exr l.exr
is "$(field r.json 'o["source"]')" other.exr '--source: the report names it'
run -e direct -t 0 -k k.exr --kernel-normalize none $linear --source other.exr --layer m.exr in.exr
same l.exr m.exr '--source: --mix is add without a word'
run -e direct $plain --source other.exr --source-mask crypto:wall --layer l.exr in.exr
ok '--source: the frame masks it' ask layer l.exr other.exr $known wall
run -e direct $plain -t 1 --source in.exr --layer l.exr other.exr
run -e direct $plain -t 1 --layer m.exr in.exr
same l.exr m.exr '--source: over the threshold'
for n in 1 2; do
    ask make seq/o.$n.exr bright=$n
done
run -e direct $plain --source 'seq/o.#.exr' --layer 'seq/l.#.exr' 'seq/f.#.exr'
ok '--source by pattern' ask layer seq/l.2.exr seq/o.2.exr all
for edges in extend mirror black; do
    for mix in add scatter; do
        about="--edges $edges --mix $mix"
        args="-e fft -t 0 --mix $mix --edges $edges $linear"
        run $args --layer w.exr --hdr wh.exr in.exr
        run $args --source-mask crypto:lamp,wall --layer a.exr in.exr
        run $args --source-mask '!crypto:lamp,wall' --layer b.exr in.exr
        ok "$about: a mask and its inverse add up to the whole" ask adds_up w.exr a.exr b.exr
    done
done
}
ask make rim.exr bright=0.5
ask make groups.exr group=rim
masks key.matte --light-group rim groups.exr
ok 'light groups are masked' ask sensors s.exr rim.exr in.exr channel key.matte

# -- nothing glares ---------------------------------------------------------------------

ask make dark.exr matte=A size=2x2 origin=90,90
run --source-mask dark.exr -o o.png --report r.json in.exr
like "$(cat err)" '*in.exr: no pixel over the threshold 1 is in the source mask*' \
    'a mask without light says so'
is "$status $(field r.json 'o["engine"]')" '0 none' 'a mask without light: no glare'

# -- errors ------------------------------------------------------------------------------

# wrong STATUS NAME ABOUT MASK FRAME [ARGUMENT...]
wrong()
{
    wanted=$1 name=$2 about=$3
    shift 3
    rm -rf made && mkdir made
    run --source-mask "$@" --hdr made/h.exr
    fails_with "$wanted" "$name" "$about"
    empty_folder made "$about: makes nothing"
}
wrong 2 in.exr 'neither channel nor file' nix.exr in.exr
like "$(cat err)" '*no channel nix.exr (it has B, CryptoMaterial00.A*nor is there such a file*' \
    'neither channel nor file: one line lists both'
ask make m.exr matte=X,Y
wrong 2 m.exr 'a file without a mask' m.exr in.exr
wrong 4 in.exr 'a name that is not there' crypto:lamb in.exr
like "$(cat err)" '*no lamb (nearest are "lamp", "lamp_b", "a*b"); give*' \
    'a name that is not there: the nearest three'
wrong 4 in.exr 'no name like that' 'crypto:q*' in.exr
wrong 2 in.exr 'an empty name' crypto:lamp,,wall in.exr
ask make c.exr manifest=none
wrong 4 c.exr 'wild cards without a manifest' 'crypto:l*' c.exr
like "$(cat err)" '*has no manifest*' 'wild cards without a manifest: the line says so'
frame plain.exr
wrong 4 plain.exr 'no Cryptomatte' crypto:lamp plain.exr
"$glarepp" -q -o in.png in.exr
wrong 4 in.png 'a PNG' crypto:lamp in.png
for how in ids=half drop=View.CryptoObject01.G hash=md5 conversion=none; do
    ask make c.exr "$how"
    wrong 4 c.exr "$how" crypto:lamp c.exr
done
ask make beside/c.exr manifest=names.json
echo '{"a": ' >beside/View.CryptoObject.names.json
wrong 4 View.CryptoObject.names.json 'a damaged manifest' crypto:lamp beside/c.exr
rm beside/*.json
wrong 4 c.exr 'a manifest that is not there' 'crypto:l*' beside/c.exr
ask make c.exr manifest=./names.json
wrong 4 c.exr 'a manifest in another folder' crypto:lamp c.exr
ask make other.exr size=41x30
wrong 4 other.exr '--source of another window' key.matte in.exr --source other.exr
frame other.exr size=40x30 attr=chromaticities:chromaticities:.7,.3,.2,.7,.1,.1,.3,.3
wrong 4 other.exr '--source of other primaries' key.matte in.exr --source other.exr
wrong 3 gone.exr '--source that is not there' key.matte in.exr --source gone.exr
cp in.exr kept.exr
run --source-mask kept.exr --hdr kept.exr in.exr
fails_with 2 kept.exr 'an output that is the mask'
run --source kept.exr --hdr kept.exr in.exr
fails_with 2 kept.exr 'an output that is the source'

# -- files of the data folder ---------------------------------------------------------------

if [ -n "$data" ]; then
    real=$data/camera/arnold_multichannel_tiled64.exr
    for name in ball_asset /obj/box:polygons:1 /shop/mat3/standard_surface1; do
        masks "crypto:$name" "$real"
        ok "Arnold's: $name" ask sensors s.exr "$real" crypto "$name"
    done
    for how in special_chars sidecar_manifest; do
        ask white $how.exr "$data/cryptomatte/$how.exr"
    done
    cp "$data/cryptomatte/sidecar_manifest.crypto_asset.json" .
    masks 'crypto:name*' special_chars.exr
    ok 'special characters' ask sensors s.exr special_chars.exr crypto \
        'name containing a "quote"  ' name_containing/slash 'name, with, comma'
    masks 'crypto:равнина' special_chars.exr
    ok 'Cyrillic' ask sensors s.exr special_chars.exr crypto равнина
    masks 'crypto:default_???' sidecar_manifest.exr
    ok 'a manifest of its own' ask sensors s.exr sidecar_manifest.exr crypto \
        default_111 default_222 default_333 default_444 default_555
    masks '!crypto:leftAsset' sidecar_manifest.exr
    ok 'inverted' ask sensors s.exr sidecar_manifest.exr not crypto leftAsset
else
    skip 7 "$no_data"
fi

done_testing
