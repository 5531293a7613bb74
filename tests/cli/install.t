#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Files that make install, make uninstall and make deb install and remove;
# shells complete with what is installed; glarepp help.
. "$(dirname "$0")/lib.sh"

build=$(dirname "$glarepp")
version=$("$glarepp" --version | sed -n '1s/^glarepp //p')
unset MAKEFLAGS MFLAGS MAKELEVEL GLAREPP_BRIDGES

# mk TARGET VARIABLE...: in the repository, with the build that is tested
mk()
{
    (cd "$root" && make --no-print-directory B="$build" "$@") >mk.log 2>&1
    result $? "make $1" || note "$(tail -n 12 mk.log)"
}

# files FOLDER: those in it, one a line
files()
{
    (cd "$1" && find . ! -type d | LC_ALL=C sort | sed 's|^\./||')
}

# own: files that install and package have under the same names
own()
{
    echo 'bin/glarepp
lib/glarepp/glarepp-oiio
share/bash-completion/completions/glarepp
share/fish/vendor_completions.d/glarepp.fish'
    [ "$1" = deb ] || echo lib/glarepp/glarepp-ocio.so
    (cd "$root" && ls README.md LICENSE man/*.md examples/lenses/*.json \
        examples/flares/*.json) | sed 's|^|share/doc/glarepp/|'
    for file in alley.glb blender/README.md blender/glarepp_addon.py \
        blender_camera.py embed.c embed_many.c openjd.yaml parallel.sh slurm.sh; do
        echo share/doc/glarepp/examples/$file
    done
}

# library: what it installs
library()
{
    echo 'include/glarepp.h
lib/libglarepp.a
lib/libglarepp.so
lib/libglarepp.so.0
lib/pkgconfig/glarepp.pc'
}

# -- install and uninstall -----------------------------------------------------

prefix=/opt/a\ place
mk install DESTDIR="$tmp/root" PREFIX="$prefix"
at=$tmp/root$prefix
is "$(files "$at")" "$( (own; library; echo share/man/man1/glarepp.1
    echo share/zsh/site-functions/_glarepp) | LC_ALL=C sort)" \
    'what make install puts in place'
is "$(files "$tmp/root" | grep -vc '^opt/a place/')" 0 'and nothing elsewhere'
is "$(find "$at" -type f -perm /022)" '' 'no file that others can write to'
is "$("$at/bin/glarepp" --version | head -n 1)" "glarepp $version" \
    'the installed program runs'
same "$at/share/man/man1/glarepp.1" "$root/man/glarepp.1" 'the man page'
for file in LICENSE README.md examples/slurm.sh examples/openjd.yaml; do
    same "$at/share/doc/glarepp/$file" "$root/$file" "the installed $file"
done
for shell in bash zsh fish; do
    cp "$build/completions.$shell" completion.$shell
    is "$(grep -c -e --help-table -e '-l help-table' completion.$shell)" 0 \
        "no hidden option is completed by $shell"
done
same "$at/share/bash-completion/completions/glarepp" completion.bash \
    'completions of bash'
same "$at/share/zsh/site-functions/_glarepp" completion.zsh \
    'completions of zsh'
same "$at/share/fish/vendor_completions.d/glarepp.fish" completion.fish \
    'completions of fish'

# -- licences ------------------------------------------------------------------

# The libraries of the table in man/dependencies.md, but those of the GPL without an
# exception for who links them
awk -F '|' '$3 ~ /`l/ && ($5 !~ /[^L]GPL/ || $5 ~ / WITH /) { print $3 }' \
    "$root/man/dependencies.md" | tr -d '` ' | tr , '\n' >.allowed
echo libglarepp >>.allowed

# strangers FILE...: libraries that these need, or have the name of, and the table lacks
strangers()
{
    for file; do
        readelf -d "$file" 2>/dev/null | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p'
        grep -aoE 'lib[A-Za-z0-9_+-]+\.so' "$file"
    done | sed -E 's/\.so.*//; s/^(ld-linux).*/\1/; s/[0-9_.-]*$//' | sort -u |
        grep -vxFf .allowed
}

if command -v readelf >/dev/null && ! sanitized; then
    for file in bin/glarepp lib/glarepp/glarepp-oiio lib/glarepp/glarepp-ocio.so \
        lib/libglarepp.so.0 lib/libglarepp.a; do
        is "$(strangers "$at/$file")" '' \
            "$file: its libraries are in the table of man/dependencies.md"
    done
    echo 'opens libfftw3f.so.3' >.opens
    is "$(strangers .opens)" libfftw3f 'a library of the GPL is found: this test can fail'
    ok 'the table has libraries' [ "$(wc -l <.allowed)" -gt 10 ]
else
    skip 7 'no readelf, or a sanitizer brings libraries'
fi

# A TIFF needs the helper, which is found from where the program lies
if [ -n "$python" ]; then
    frame f.exr size=8x8
    ok 'the installed program finds its helper' \
        "$at/bin/glarepp" -o f.tif f.exr
    rm f.tif "$at/lib/glarepp/glarepp-oiio"
    if [ -e /usr/local/lib/glarepp/glarepp-oiio ]; then
        skip 1 'another glarepp is installed'
    else
        no 'which it takes from nowhere else' "$at/bin/glarepp" -o f.tif f.exr
    fi
else
    skip 2 'no python3 to make frames'
fi

echo mine >"$at/bin/other"
mk uninstall DESTDIR="$tmp/root" PREFIX="$prefix"
is "$(files "$tmp/root")" 'opt/a place/bin/other' \
    'make uninstall leaves what is not its own'
no 'and takes its own folder away' test -e "$at/lib/glarepp"
no 'and that of its documents' test -e "$at/share/doc/glarepp"
mk uninstall DESTDIR="$tmp/root" PREFIX="$prefix"

# -- the Debian package --------------------------------------------------------

package()
{
    mk deb
    deb=$build/glarepp_${version}_$(dpkg --print-architecture).deb
    cp "$deb" first.deb || return
    mk deb
    same first.deb "$deb" 'the package has the same bytes again'

    dpkg-deb -x first.deb tree
    is "$(cd tree/usr && files .)" "$( (own deb
        echo share/doc/glarepp/changelog.gz; echo share/doc/glarepp/copyright
        echo share/man/man1/glarepp.1.gz
        echo share/zsh/vendor-completions/_glarepp) | LC_ALL=C sort)" \
        'what the package holds'
    is "$(dpkg-deb -f first.deb Version)" "$version" 'its version'
    depends=$(dpkg-deb -f first.deb Depends)
    for library in libc6 libopenexr libpng16 libopenimageio libjansson4 \
        libglarepp0; do
        like "$depends" "*$library*" "it depends on $library"
    done
    is "$(gzip -dc tree/usr/share/man/man1/glarepp.1.gz | cmp - \
        "$root/man/glarepp.1" 2>&1)" '' 'its man page'
    like "$(gzip -dc tree/usr/share/doc/glarepp/changelog.gz)" \
        "glarepp ($version) *" 'its changelog'
    like "$(cat tree/usr/share/doc/glarepp/copyright)" '*License: Apache-2.0*' 'its licence'
    is "$(dpkg-deb -c first.deb | awk '$2 != "root/root"')" '' \
        'all of it is root'\''s'
    like "$(tree/usr/bin/glarepp --version)" "glarepp $version*" \
        'the unpacked program runs'
    [ ! -f f.exr ] || ok 'and finds its bridge' \
        tree/usr/bin/glarepp -o deb.tif f.exr

    lib=lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH)
    packs libglarepp0 "lib/glarepp/glarepp-ocio.so $lib/libglarepp.so.0"
    like "$(dpkg-deb -f "$deb" Depends)" '*libjansson4*libopencolorio*' \
        'what it depends on'
    packs libglarepp-dev "include/glarepp.h $lib/libglarepp.a $lib/libglarepp.so \
        $lib/pkgconfig/glarepp.pc"
    is "$(for deb in "$build"/*glarepp*_"${version}"_*.deb; do
        dpkg-deb -f "$deb" Depends Recommends
    done | grep -io '[^ ]*fftw[^ ,]*')" '' 'no package asks for FFTW'
    if command -v lintian >/dev/null; then
        is "$(lintian --allow-root --fail-on none --display-level '>=warning' \
            "$build"/*"glarepp"*"_${version}_"*.deb 2>&1)" '' 'lintian has nothing to say'
    else
        skip 1 'no lintian'
    fi
}

# packs PACKAGE "FILES": what it holds
packs()
{
    deb=$build/$1_${version}_$(dpkg --print-architecture).deb
    dpkg-deb -x "$deb" "$1"
    is "$(files "$1/usr")" "$(printf '%s\n' $2 share/doc/$1/changelog.gz \
        share/doc/$1/copyright)" "what $1 holds"
}

# dpkg itself, into a root where nothing else is
dpkg_into_root()
{
    mkdir -p fresh/var/lib/dpkg/info fresh/var/lib/dpkg/updates
    : >fresh/var/lib/dpkg/status
    ok 'dpkg installs it into a fresh root' dpkg --root="$tmp/fresh" \
        --force-depends --force-script-chrootless --log=/dev/null \
        -i first.deb
    like "$(dpkg-query --root="$tmp/fresh" -W -f '${Status}' glarepp 2>&1)" \
        'install ok installed' 'it counts as installed'
    is "$(cd fresh && md5sum -c var/lib/dpkg/info/glarepp.md5sums 2>&1 |
        grep -vc ': OK$')" 0 'its sums hold'
    like "$(fresh/usr/bin/glarepp help report)" 'Reports and progress*' \
        'the program runs from there'
    ok 'dpkg removes it' dpkg --root="$tmp/fresh" --log=/dev/null \
        --force-script-chrootless -P glarepp
    no 'and nothing stays' test -e fresh/usr/lib/glarepp -o \
        -e fresh/usr/bin/glarepp -o -e fresh/usr/share/doc/glarepp
}

if [ -n "$quick" ]; then
    skip 1 'no package of a build for tests'
elif ! command -v dpkg-deb >/dev/null || ! command -v dpkg-shlibdeps >/dev/null
then
    skip 1 'no dpkg-deb and dpkg-shlibdeps'
else
    package
    if [ "$(id -u)" = 0 ]; then
        dpkg_into_root
    else
        skip 1 'dpkg installs for root only'
    fi
fi

# -- completion ----------------------------------------------------------------

touch 'a file.exr'
cat >.ask.bash <<'EOF'
. ./completion.bash
while read -r line; do
    read -ra COMP_WORDS <<<"$line"
    [[ $line != *' _' ]] || COMP_WORDS[-1]=
    COMP_CWORD=$((${#COMP_WORDS[@]} - 1)) COMPREPLY=()
    "$(complete -p glarepp | sed 's/.*-F \([^ ]*\) .*/\1/')" 2>/dev/null
    printf '%s|' "${COMPREPLY[@]}"
    echo
done
EOF

# bash_says "WORDS" "ANSWERS|": readline's words, _ is an empty one
bash_says()
{
    is "$(echo "$1" | bash .ask.bash)" "$2" "bash: $1"
}

if command -v bash >/dev/null; then
    ok 'bash reads its completions' bash -n completion.bash
    bash_says 'glarepp --eng' '--engine|'
    bash_says 'glarepp --engine _' 'auto|direct|fft|splat|'
    bash_says 'glarepp --engine = s' 'splat|'
    bash_says 'glarepp -e f' 'fft|'
    bash_says 'glarepp -k builtin : st' 'star|streak|'
    bash_says 'glarepp --kernel = builtin : eye-n' 'eye-night|'
    bash_says 'glarepp -k a' 'aperture|a file.exr|'
    bash_says 'glarepp -k cie : a' 'age=|'
    bash_says 'glarepp -k cie : equation = t' 'total|'
    bash_says 'glarepp -k cie : age = 70,pig' '70,pigment=|'
    bash_says 'glarepp kernel --check builtin : eye-old : eq' \
        'equation=total|equation=general|'
    bash_says 'glarepp --debug pol' 'polygons=|'
    bash_says 'glarepp --debug polygons = a' 'a file.exr|'
    bash_says 'glarepp --gain _' '|'
    bash_says 'glarepp ben' 'bench|'
    bash_says 'glarepp bench --js' '--json|'
    bash_says 'glarepp bench --hd' '|'
    bash_says 'glarepp --js' '|'
    bash_says 'glarepp help sequ' 'sequences|'
    bash_says 'glarepp help al' 'all|'
    bash_says 'glarepp --help al' 'all|'
    bash_says 'glarepp --help = sequ' 'sequences|'
    bash_says 'glarepp -o x.png a' 'a file.exr|'
else
    skip 1 'no bash'
fi

if command -v fish >/dev/null; then
    export HOME="$tmp" XDG_CONFIG_HOME="$tmp" XDG_DATA_HOME="$tmp"
    fish_says()
    {
        is "$(fish -c "source completion.fish; complete -C'$1'" 2>&1 |
            cut -f1 | tr '\n' '|')" "$2" "fish: $1"
    }
    ok 'fish reads its completions' fish --no-execute completion.fish
    fish_says 'glarepp --eng' '--engine|'
    fish_says 'glarepp --engine ' 'auto|direct|fft|splat|'
    fish_says 'glarepp -k builtin:eye-n' 'builtin:eye-night|'
    fish_says 'glarepp -k cie:a' 'cie:age=|'
    fish_says 'glarepp --kernel=cie:age=70,pig' '--kernel=cie:age=70,pigment=|'
    fish_says 'glarepp kernel --check builtin:eye-old:equation=t' \
        'builtin:eye-old:equation=total|'
    fish_says 'glarepp --gain ' ''
    fish_says 'glarepp bench --js' '--json|'
    fish_says 'glarepp --js' ''
    fish_says 'glarepp help sequ' 'sequences|'
    fish_says 'glarepp --help sequ' 'sequences|'
else
    skip 1 'no fish'
fi

# zsh completes at a terminal only: one of its own
cat >ask.zsh <<'EOF'
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell "fpath=($PWD \$fpath); autoload -U compinit; compinit -u -D"
zpty -w shell "print READ''Y"
zpty -r -m shell out "*READY*" # waits for it
zpty -w -n shell "$1"$'\t'
zpty -r -m shell out "*$2*"
zpty -d shell
EOF
if command -v zsh >/dev/null && zsh -fc 'zmodload zsh/zpty' 2>/dev/null; then
    cp completion.zsh _glarepp
    ok 'zsh reads its completions' zsh -n completion.zsh
    for row in '--engine=sp splat' '-k builtin:ey builtin:eye' '-k cie:age=70,pig pigment=' \
        'bench --js --json' 'help sequ sequences' '--help=sequ sequences'; do
        ok "zsh: glarepp ${row% *}" timeout 10 zsh -f ask.zsh \
            "glarepp ${row% *}" "${row##* }"
    done
else
    skip 1 'no zsh'
fi

# -- help ----------------------------------------------------------------------

run help
quiet_success 'help lists its topics'
like "$(cat out)" '*kernels*sequences*' 'kernels and sequences are topics'
run help --gain
quiet_success 'help --gain is about the option'
like "$(cat out)" '*-g, --gain G*' 'it names it'
run help sequences
if [ ! -r "${glarepp%/*}/../man/glarepp.1" ]; then
    fails_with 3 man/glarepp.1 'help sequences without the page'
elif command -v man >/dev/null; then
    quiet_success 'help sequences prints that section'
    is "$(head -n 1 out | tr -d ' ')" Sequences 'it begins with its heading'
    no 'and ends before the next' grep -q '^   Views' out
else
    fails_with 3 Sequences 'help sequences without man'
fi
(PATH=.; exec "$glarepp" help sequences) >out 2>err
status=$?
fails_with 3 man/glarepp.1 'help sequences without man: where the page is'
run help kernsl
fails_with 2 kernel 'a topic that is none'
run bnech f.exr
fails_with 2 'glarepp bench' 'a command that is none'
is "$(cat out)" '' 'nothing on stdout'
echo text >bnech
run -o x.png bnech
run bnech -o x.png
like "$(cat err)" 'glarepp: bnech: *' 'a file of such a name is a file'
no 'and no slip' grep -q 'did you mean' err
run --help
quiet_success '--help'
ok '--help is one screen: 24 lines of 80 columns' \
    awk 'length > 80 { exit 1 } END { exit NR > 24 || NR < 15 }' out
run sets --help
like "$(head -n 3 out)" '*glarepp sets*' 'a command begins with its own text'
run --help kernels
like "$(head -n 1 out)" 'Light and kernel' '--help TOPIC is help TOPIC'
# a reader that is gone before the first word
for words in --help 'help all' 'help --gain' 'kernel --list' 'lens --list' --version; do
    {
        sleep 0.2
        # shellcheck disable=SC2086
        "$glarepp" $words 2>err
        echo $? >code
    } | :
    is "$(cat code err)" 0 "$words into a pipe that nobody reads"
done
if [ -c /dev/full ]; then
    "$glarepp" help kernels >/dev/full 2>err
    status=$?
    fails_with 3 stdout 'help into a full device'
fi

done_testing
