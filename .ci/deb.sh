#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: deb.sh TREE VERSION FOLDER
# Makes Debian packages FOLDER/NAME_VERSION_ARCH.deb of TREE, a folder in which `make
# install PREFIX=/usr` has put its files; adds what Debian asks for: libglarepp0,
# libglarepp-dev, and glarepp, which has all other files.
# Needs dpkg-deb and dpkg-shlibdeps (package dpkg-dev). The same tree gives the same
# bytes: all dates are that of the man page, or SOURCE_DATE_EPOCH.
set -eu
umask 022
tree=$(cd "$1" && pwd) version=$2
folder=$(cd "$3" && pwd)
root=$(cd "$(dirname "$0")/.." && pwd)
arch=$(dpkg --print-architecture)
export LC_ALL=C
day=$(sed -n 's/^\.Dd //p' "$root/man/glarepp.1.in")
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(date -u -d "$day" +%s)}
export SOURCE_DATE_EPOCH
date=$(date -u -R -d "@$SOURCE_DATE_EPOCH")
maintainer="${DEBFULLNAME:-glarepp} <${DEBEMAIL:-glarepp@example.org}>"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# -- one package -----------------------------------------------------------------

# documents PACKAGE TREE: what each has below usr/share/doc
documents()
{
    doc=$2/usr/share/doc/$1
    mkdir -p "$doc"
    cat >"$doc/copyright" <<EOF
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: glarepp

Files: *
Copyright: ${day##* } the authors of glarepp
License: Apache-2.0
 Licensed under the Apache License, Version 2.0 (the "License"); you may not use
 these files except in compliance with the License. They come without
 warranties or conditions of any kind.
 .
 On Debian systems the text of the License is in
 /usr/share/common-licenses/Apache-2.0.
EOF
    gzip -9n >"$doc/changelog.gz" <<EOF
glarepp ($version) unstable; urgency=medium

  * Version $version.

 -- $maintainer  $date
EOF
}

# needs FILE...: the libraries of these, as dpkg-shlibdeps finds them. It reads a
# source package's debian/control
needs()
{
    mkdir -p "$work/debian"
    printf 'Source: glarepp\n\nPackage: glarepp\nArchitecture: any\n' \
        >"$work/debian/control"
    (cd "$work" && dpkg-shlibdeps -O "$@") | sed -n 's/^shlibs:Depends=//p'
}

# package NAME TREE SECTION: of the tree; the other fields and the description are
# those of stdin
package()
{
    documents "$1" "$2"
    mkdir -p "$2/DEBIAN"
    cat >"$2/DEBIAN/control" <<EOF
Package: $1
Source: glarepp
Version: $version
Architecture: $arch
Maintainer: $maintainer
Installed-Size: $(du -k -s --apparent-size "$2/usr" | cut -f1)
Section: $3
Priority: optional
EOF
    cat >>"$2/DEBIAN/control"
    (cd "$2" && find usr -type f | sort | xargs md5sum >DEBIAN/md5sums)
    find "$2" -newermt "@$SOURCE_DATE_EPOCH" -exec \
        touch -h -d "@$SOURCE_DATE_EPOCH" {} +
    dpkg-deb --root-owner-group -Zxz --build "$2" \
        "$folder/$1_${version}_$arch.deb"
}

# -- the library ------------------------------------------------------------------

# GL is opened at run time, where nothing sees it; without it the engine splat and
# the mask of the sun are missing, all else is there
gl="Recommends: libosmesa6 | libegl1"
strip --strip-unneeded "$tree/usr/bin/glarepp" "$tree"/usr/lib/glarepp/*
so=$(find "$tree/usr/lib" -name libglarepp.so.0)
lib=${so%/*}
lib=${lib#"$tree"}
strip --strip-unneeded "$so"
strip --strip-debug "$tree$lib/libglarepp.a"

mkdir -p "$work/dev$lib" "$work/run$lib" "$work/run/usr/lib/glarepp"
mv "$tree/usr/include" "$work/dev/usr"
mv "$tree$lib"/libglarepp.a "$tree$lib"/libglarepp.so "$tree$lib/pkgconfig" \
    "$work/dev$lib"
mv "$tree$lib/libglarepp.so.0" "$work/run$lib"
rmdir "$tree$lib"
mv "$tree/usr/lib/glarepp/glarepp-ocio.so" "$work/run/usr/lib/glarepp"

mkdir -p "$work/run/DEBIAN"
echo "libglarepp 0 libglarepp0 (>= $version)" >"$work/run/DEBIAN/shlibs"
echo activate-noawait ldconfig >"$work/run/DEBIAN/triggers"
depends=$(needs "$work/run$lib/libglarepp.so.0" "$work/run/usr/lib/glarepp/"*)
[ -n "$depends" ]
package libglarepp0 "$work/run" libs <<EOF
Depends: $depends
$gl
Description: glare of bright light in HDR images (shared library)
 libglarepp adds the glare that bright light makes in an eye or a lens to images
 in memory, and says how wrong it is.
EOF
package libglarepp-dev "$work/dev" libdevel <<EOF
Depends: libglarepp0 (= $version), libjansson-dev
Description: glare of bright light in HDR images (development files)
 The header, the archive and the pkg-config file of libglarepp, which adds the
 glare that bright light makes in an eye or a lens to images in memory.
EOF

# -- the program ------------------------------------------------------------------

# Debian's zsh looks for packages' completions elsewhere than make install's
mv "$tree/usr/share/zsh/site-functions" \
    "$tree/usr/share/zsh/vendor-completions"
gzip -9n "$tree/usr/share/man/man1/glarepp.1"
depends=$(needs "$tree/usr/bin/glarepp" "$tree"/usr/lib/glarepp/*)
[ -n "$depends" ]
package glarepp "$tree" graphics <<EOF
Depends: $depends, libglarepp0 (= $version)
$gl
Description: add the glare of bright light to HDR frames
 glarepp reads scene-linear OpenEXR frames, adds the glare that bright light
 makes in an eye or a lens, with the sun hidden behind what stands in front of
 it, and writes tone-mapped pictures and scene-linear frames. It needs no
 display, and says how fast and how wrong it was.
EOF
